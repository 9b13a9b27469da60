"""One mass, in closed form: the best design at a few speeds, its worst speeds, more rows, until nothing is missed.

Fewer speeds are fewer limits, so each answer is a proven bound; where the worst speeds break nothing any more, bound
and design are the same.  All questions that differ in numbers alone are answered together: a solve asks one.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from vibopt.arrays import FloatArray, IntArray, every, some
from vibopt.program.program import Program
from vibopt.records import dataclass
from vibopt.solve.branch import Judge
from vibopt.solve.closed_peaks import worst
from vibopt.solve.closed_program import NotClosedError, Numbers, Question, RowKind, question
from vibopt.solve.closed_rows import Rows, ends_of_damping, extreme, harmonic_row, plain_row, take
from vibopt.solve.method import Found, Progress

OPEN, OPTIMAL, INFEASIBLE = 0, 1, 2
_DONE, _STILL = 1e-11, 5e-10
"""Part of its bound by which a limit may be missed; the same where another round would not move the design."""
_SHARP, _AHEAD = 0.5, 8
"""Part of its bound by which a limit is missed at a sharp resonance; how many steps of it are looked ahead."""
_ROUNDS = 40
_COARSE = (33, 513)
_FEWER = 4
"""Times as many questions as a coarse round has, for it to be worth its time."""
_CHUNK = 1024
_BEGIN, _EACH = np.linspace(0.0, 1.0, 129)[:, None], 8
"""Parts of each range of speeds at which a limit is looked at first, where nothing better is known; of many every 8th.
"""

Memory = dict[int, FloatArray]
"""Worst speeds of the last round, squared frequencies (count,), by the index of their limit."""
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
        answers = _answer(asked, take(numbers, few), _at(first, few), len(few))
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


def _answer(asked: Question, numbers: Numbers, first: Speeds, count: int) -> Answers:
    """Answer some questions, beginning at the speeds `first`."""
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
            missed, fresh = _learn(asked, numbers, best, before)
            done = ~none & (missed <= np.where((best == last).all(axis=0), _STILL, _DONE))
            status[left[none]], status[left[done]] = INFEASIBLE, OPTIMAL
            x[:, left[done]], reach[:, left[done]] = best[:, done], ends[:, done]
            rest = ~(none | done)
            if not some(rest):
                break
            rows = rows.plus(Rows.of(asked, np.concatenate(fresh, axis=1))) if fresh else rows
            if not every(rest):
                left, numbers, rows = left[rest], take(numbers, rest), rows.some(rest)
                before = {index: w[rest] for index, w in before.items()}
            last = best[:, rest]
    return Answers(status, x, reach, rounds)


def _first_rows(asked: Question, numbers: Numbers, count: int, first: Speeds) -> FloatArray:
    rows = [ends_of_damping(asked, count)]
    for index, kind in enumerate(asked.rows):
        if kind.kind != "harmonic":
            rows.append(plain_row(asked, numbers, index, count))
        for b, point in enumerate(kind.points):
            low, high = numbers[f"{index}.low{b}"], numbers[f"{index}.high{b}"]
            each = len(_BEGIN) - 1 if first else _EACH if count > 1 or asked.goal[0] else 1
            parts = _BEGIN[:1] if point else _BEGIN[::each]
            rows.append(harmonic_row(asked, numbers, index, (low + parts * (high - low) + np.zeros(count)) ** 2))
    rows += [harmonic_row(asked, numbers, index, w[None]) for index, w in first]
    return np.concatenate(rows, axis=1)


def _learn(asked: Question, numbers: Numbers, x: FloatArray, before: Memory) -> tuple[FloatArray, list[FloatArray]]:
    """Greatest miss of each question, and rows per limit that some question misses, (4, n, count).

    A limit without a range of speeds is a row of its own, which x meets already.  A sharp resonance that is missed by
    far moves on by its own width at each round: rows of the next ones are asked for at once.  `before` has the worst
    speeds of the last round, and gets those of this one.
    """
    greatest, rows = np.full(x.shape[1], -np.inf), []
    for index, kind in enumerate(asked.rows):
        if kind.over_speeds:
            missed, w = worst(asked, numbers, index, x)
            greatest = np.maximum(greatest, missed)
            if some(missed > _DONE):
                rows.append(harmonic_row(asked, numbers, index, w[None]))
            if index in before and some(sharp := missed > _SHARP):
                step = np.where(sharp, np.clip(w / before[index], 0.5, 2.0), 1.0)
                ahead = [_within(kind, numbers, index, np.sqrt(w * step**n)) ** 2 for n in range(1, _AHEAD + 1)]
                rows.append(harmonic_row(asked, numbers, index, np.array(ahead)))
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
    answers = answer(asked, asked.numbers, 1)
    if answers.status[0] == OPEN:
        return Found("unproven", None, "the worst speeds did not settle", name)
    if answers.status[0] == INFEASIBLE:
        return none_found(name, answers.rounds)
    x, reach = np.zeros(len(asked.order)), np.zeros(len(asked.order))
    x[list(asked.order)], reach[list(asked.order)] = answers.x[:, 0], answers.reach[:, 0]
    return best_found(program, name, x, answers.rounds, tuple(reach.tolist()))


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
