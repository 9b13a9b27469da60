"""One mass, in closed form: the best design at a few speeds, its worst speeds, more rows, until nothing is missed.

Fewer speeds are fewer limits, so each answer is a proven bound; where the worst speeds break nothing any more, bound
and design are the same.  All questions that differ in numbers alone are answered together: a solve asks one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from math import inf

import numpy as np

from vibopt.arrays import FloatArray, IntArray, every, some
from vibopt.program.program import Program
from vibopt.records import dataclass
from vibopt.solve.branch import Judge
from vibopt.solve.closed_peaks import worst, worst_alone
from vibopt.solve.closed_program import NotClosedError, Numbers, Question, RowKind, question
from vibopt.solve.closed_rows import LoneRows, Rows, ends_of_damping, extreme, harmonic_row, plain_row, stacked, take
from vibopt.solve.method import Found, Progress

OPEN, OPTIMAL, INFEASIBLE = 0, 1, 2
_DONE, _STILL = 1e-11, 5e-10
"""Part of its bound by which a limit may be missed; the same where another round would not move the design."""
_SHARP, _AHEAD = 0.5, 8
"""Part of its bound by which a limit is missed at a sharp resonance; how many steps of it are looked ahead."""
_STEPS = np.arange(1.0, _AHEAD + 1.0)[:, None]
_ROUNDS = 40
_COARSE = (33, 513)
_ROUGH = 1e3
"""By what part of its bound a limit may be missed in a coarse round, times the fourth power of its questions: straight
lines between their worst speeds are as far off."""
_FEWER = 4
"""Times as many questions as a coarse round has, for it to be worth its time."""
_CHUNK = 1024
_BEGIN, _EACH = np.linspace(0.0, 1.0, 129)[:, None], 8
"""Parts of each range of speeds at which a limit is looked at first, where nothing better is known; of many every 8th.
"""
_PARTS = (0.0, 0.25, 0.5, 0.75, 1.0)
"""The same of one question in plain floats."""

Memory = dict[int, FloatArray]
"""Worst speeds of the last round, squared frequencies (count,), by the index of their limit."""
Seen = tuple[int, FloatArray, FloatArray]
"""Index of a limit, how far it is missed at its worst as a part of its bound, and the squared frequency there."""
Speeds = list[tuple[int, FloatArray]]
"""Squared frequencies at which limits are looked at first: (index of the limit, one per question)."""


@dataclass(frozen=True)
class Answers:
    """Per question: OPEN (nothing proven), OPTIMAL or INFEASIBLE; x (n_vars, count) in the order (k, c).

    reach
        The far end of an open range where x lies on it, else infinity; shape of x.
    rounds
        Greatest number of rounds.
    """

    status: IntArray
    x: FloatArray
    reach: FloatArray
    rounds: int


def answer(asked: Question, numbers: Numbers, count: int, progress: Callable[[float], None] | None = None) -> Answers:
    """Answer all questions; first a few, whose worst speeds tell where the others begin to look."""
    first: Speeds = []
    for size in (n for n in _COARSE if _FEWER * n <= count):
        few = np.unique(np.round(np.linspace(0, count - 1, size)).astype(int))
        answers = _answer(asked, take(numbers, few), _at(first, few), len(few), _ROUGH / size**4)
        first = _speeds(asked, numbers, few, answers, count)
    parts = []
    for begin in range(0, count, _CHUNK):
        chunk = slice(begin, min(begin + _CHUNK, count))
        here = numbers if count <= _CHUNK else take(numbers, chunk)
        parts.append(_answer(asked, here, _at(first, chunk), chunk.stop - begin))
        if progress is not None:
            progress(chunk.stop / count)
    if len(parts) == 1:
        return parts[0]
    whole = [np.concatenate([getattr(part, key) for part in parts], axis=-1) for key in ("status", "x", "reach")]
    return Answers(whole[0], whole[1], whole[2], max(part.rounds for part in parts))


def _at(speeds: Speeds, chosen: IntArray | slice) -> Speeds:
    return [(index, w[chosen]) for index, w in speeds]


def _speeds(asked: Question, numbers: Numbers, few: IntArray, answers: Answers, count: int) -> Speeds:
    """Worst speeds at a few answers, drawn as straight lines between them."""
    good = answers.status == OPTIMAL
    speeds = []
    for index, kind in enumerate(asked.rows):
        if not kind.over_speeds or not good.any():
            continue
        with np.errstate(all="ignore"):
            _, w = worst(asked, take(numbers, few[good]), index, answers.x[:, good])
        between = np.interp(np.arange(count), few[good], np.sqrt(w))
        speeds.append((index, _within(kind, numbers, index, between) ** 2))
    return speeds


def _within(kind: RowKind, numbers: Numbers, index: int, omega: FloatArray) -> FloatArray:
    """Frequencies moved into the nearest band of a limit, (count,): elsewhere the limit asks for nothing."""
    found = np.full(omega.shape, np.inf)
    for b, point in enumerate(kind.points):
        if not point:
            here = np.clip(omega, numbers[f"{index}.low{b}"], numbers[f"{index}.high{b}"])
            found = np.where(np.abs(here - omega) < np.abs(found - omega), here, found)
    return found


def _answer(asked: Question, numbers: Numbers, first: Speeds, count: int, enough: float = _DONE) -> Answers:
    """Answer some questions, beginning at the speeds `first`; of each limit that part of its bound may be missed."""
    status, left, rounds = np.zeros(count, dtype=int), np.arange(count), 0
    before: Memory = {}
    last = np.full((len(asked.low), count), np.nan)
    x, reach = np.full((2, len(asked.low), count), np.nan)
    with np.errstate(all="ignore"):
        rows = Rows.of(asked, _first_rows(asked, numbers, count, first))
        while rounds < _ROUNDS:
            rounds += 1
            best, ends = extreme(asked, rows)
            none = np.isnan(best[0])
            if every(none):
                status[left] = INFEASIBLE
                break
            seen = [(i, *worst(asked, numbers, i, best)) for i, kind in enumerate(asked.rows) if kind.over_speeds]
            missed = np.max([one for _, one, _ in seen], axis=0, initial=-np.inf)
            done = ~none & (missed <= np.where((best == last).all(axis=0), max(_STILL, enough), enough))
            status[left[none]], status[left[done]] = INFEASIBLE, OPTIMAL
            x[:, left[done]], reach[:, left[done]] = best[:, done], ends[:, done]
            rest = ~(none | done)
            if not some(rest):
                break
            if not every(rest):  # before rows are made: most questions are done after two rounds
                left, numbers, rows = left[rest], take(numbers, rest), rows.some(rest)
                before = {index: w[rest] for index, w in before.items()}
                seen = [(index, one[rest], w[rest]) for index, one, w in seen]
            fresh = _learn(asked, numbers, seen, before)
            rows = rows.plus(Rows.of(asked, np.concatenate(fresh, axis=1))) if fresh else rows
            before = {index: w for index, _, w in seen}
            last = best[:, rest]
    return Answers(status, x, reach, rounds)


def _first_rows(asked: Question, numbers: Numbers, count: int, first: Speeds) -> FloatArray:
    ends = ends_of_damping(asked)
    rows = [np.array(ends).reshape(-1, 4).T[:, :, None] + np.zeros(count)]
    for index, kind in enumerate(asked.rows):
        if kind.kind != "harmonic":
            rows.append(stacked(plain_row(asked, numbers, index), 1, count))
        for b, point in enumerate(kind.points):
            low, high = numbers[f"{index}.low{b}"], numbers[f"{index}.high{b}"]
            each = len(_BEGIN) - 1 if first else _EACH if count > 1 or asked.goal[0] else 1
            parts = _BEGIN[:1] if point else _BEGIN[::each]
            rows.append(_at_speeds(asked, numbers, index, (low + parts * (high - low) + np.zeros(count)) ** 2))
    rows += [_at_speeds(asked, numbers, index, w[None]) for index, w in first]
    return np.concatenate(rows, axis=1)


def _at_speeds(asked: Question, numbers: Numbers, index: int, w: FloatArray) -> FloatArray:
    """Rows of a limit at squared frequencies of each question, w (n, count); shape (4, n, count)."""
    return stacked(harmonic_row(asked, numbers, index, w), *w.shape)


def _learn(asked: Question, numbers: Numbers, seen: Sequence[Seen], before: Memory) -> list[FloatArray]:
    """Rows per limit that some question misses, (4, n, count), from what was `seen` of them this round.

    A limit without a range of speeds is a row of its own, which x meets already.  Worst speeds go on the way that they
    went since the last round, whose speeds `before` has: a row is asked for one step ahead of each, and for several
    steps at once where a sharp resonance is missed by far, which moves on by its own width at each round.
    """
    rows = []
    for index, missed, w in seen:
        if not some(missed > _DONE):
            continue
        speeds = w[None]
        if index in before:
            ahead = w * np.clip(w / before[index], 0.5, 2.0) ** _STEPS[: None if some(missed > _SHARP) else 1]
            speeds = np.concatenate([speeds, _within(asked.rows[index], numbers, index, np.sqrt(ahead)) ** 2])
        rows.append(_at_speeds(asked, numbers, index, speeds))
    return rows


def alone(asked: Question) -> tuple[tuple[float, ...] | None, tuple[float, ...], int] | None:
    """One question in plain floats: x (None where there is none) in the order (k, c), reach and rounds as of `Answers`.

    None where that settles nothing: then arrays do.
    """
    if asked.goal[0] or any(kind.tabled is not None for kind in asked.rows):
        return None
    rows, before, last = LoneRows(asked), dict[int, float](), None
    try:
        for row in _begun(asked):
            rows.add(row)
        for rounds in range(1, _ROUNDS + 1):
            found = rows.extreme()
            if found is None:
                return None, (), rounds
            missed, fresh = _learnt(asked, found[0], before)
            if missed <= (_STILL if found[0] == last else _DONE):
                return *found, rounds
            for row in fresh:
                rows.add(row)
            last = found[0]
    except ArithmeticError:  # a number beyond floats
        pass
    return None


def _begun(asked: Question) -> Iterator[list[float]]:
    """Rows of one question at first: fewer than of many, as a round of it costs little."""
    numbers = asked.numbers
    yield from ends_of_damping(asked)
    for index, kind in enumerate(asked.rows):
        if kind.kind != "harmonic":
            yield plain_row(asked, numbers, index)
        for b, point in enumerate(kind.points):
            low, high = numbers[f"{index}.low{b}"], numbers[f"{index}.high{b}"]
            for part in _PARTS[:1] if point else _PARTS:
                yield harmonic_row(asked, numbers, index, (low + part * (high - low)) ** 2)


def _learnt(asked: Question, x: tuple[float, ...], before: dict[int, float]) -> tuple[float, list[list[float]]]:
    """As `_learn`, of one question."""
    greatest, rows, numbers = -inf, list[list[float]](), asked.numbers
    for index, kind in enumerate(asked.rows):
        if not kind.over_speeds:
            continue
        missed, w = worst_alone(asked, index, x)
        greatest = max(greatest, missed)
        if missed > _DONE:
            rows.append(harmonic_row(asked, numbers, index, w))
        if index in before and missed > _SHARP:
            step = min(max(w / before[index], 0.5), 2.0)
            ahead = _within(kind, numbers, index, np.array([w * step**n for n in range(1, _AHEAD + 1)]) ** 0.5)
            rows += [harmonic_row(asked, numbers, index, one * one) for one in ahead.tolist()]
        before[index] = w
    return greatest, rows


class StiffnessAndDamping:
    """One mass on (k, c): for each k the limits leave an interval of c^2."""

    name = "closed_form_kc"
    summary = "exact in damping and stiffness, over the worst speeds"

    def __init__(self) -> None:
        self._last: tuple[Program, Question] | None = None

    def refuses(self, program: Program) -> str | None:
        if len(program.axes) != 2:
            return "the variables are not the stiffness and the damping of one mass."
        try:
            self._last = program, question(program)
        except NotClosedError as error:
            return str(error)
        return None

    def solve(self, program: Program, progress: Progress | None = None) -> Found:
        """Status "optimal" or "infeasible", both proven."""
        known = self._last is not None and self._last[0] is program
        return closed_found(program, self._last[1] if known and self._last else question(program), self.name)


def closed_found(program: Program, asked: Question, name: str) -> Found:
    """The answer to one question."""
    known = alone(asked)
    if known is None:
        answers = answer(asked, asked.numbers, 1)
        if answers.status[0] == OPEN:
            return Found("unproven", None, "the worst speeds did not settle", name)
        here = tuple(answers.x[:, 0].tolist()) if answers.status[0] == OPTIMAL else None
        known = here, tuple(answers.reach[:, 0].tolist()), answers.rounds
    here, far, rounds = known
    if here is None:
        return none_found(name, rounds)
    x, reach = ([one[i] for i in asked.order] for one in (here, far))  # an order of two is its own inverse
    return best_found(program, name, np.array(x), rounds, tuple(reach))


def none_found(name: str, rounds: int) -> Found:
    """No design, proven."""
    claim = "proven in closed form: at a few speeds alone the limits leave no design"
    return Found("infeasible", None, claim, name, details={"rounds": rounds})


def best_found(program: Program, name: str, x: FloatArray, rounds: int, reach: tuple[float, ...]) -> Found:
    """The best design x (n_vars,), proven; `reach` is how far each open range was looked through."""
    aim = program.aim
    value = Judge(program).goal(x).value
    goal = value * (aim.sense if aim is not None else 1.0)
    claim = "proven in closed form: the best design at its worst speeds meets every limit at all speeds"
    return Found("optimal", x, claim, name, value, {"rounds": rounds, "goal": goal, "reach": reach})
