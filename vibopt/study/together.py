"""One mass at many values of some facts: all answers at once, each measured again on machines of many numbers.

The question is read at a few values; where every number in it follows the facts by a law, it is answered at all.  What
the rows of the optimiser say of each limit is compared with what is measured on the machine as built.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import product
from typing import Any

import numpy as np

from vibopt.answer.entry import TOLERANCE, Entry
from vibopt.arrays import BoolArray, FloatArray
from vibopt.errors import InputError
from vibopt.mechanics.lone import LoneMachine
from vibopt.program.pose import pose
from vibopt.records import dataclass
from vibopt.responses import HarmonicResponse, RandomResponse, Response, TransientResponse
from vibopt.scene.drives import bands_for, combine_for, names_for, unit_lines
from vibopt.scene.read import with_changes
from vibopt.scene.scene import Scene
from vibopt.solve.closed_form import INFEASIBLE, OPTIMAL, Answers, answer
from vibopt.solve.closed_program import NotClosedError, Number, Numbers, Question, question, value_at
from vibopt.solve.ranges import closed
from vibopt.study.points import Columns, Words
from vibopt.study.seen import measured_goal
from vibopt.values.fact_at import FactAt
from vibopt.verify.as_built import built
from vibopt.verify.certify import Shaken
from vibopt.verify.checked import shown_value, usual_unit

_EXACT = 1e-12
_INSIDE = (0.41, 0.68)
"""Where the question is read, as parts of each fact's values: the corners fix the laws, places inside verify them."""
_BETWEEN = np.array([[0.11], [0.37], [0.63], [0.89]])
"""Parts of a band at which no machine may be worse than where its response turns."""
_SAME = 1e-9
"""Part of a value by which the two routes to it may differ; of its terms where these cancel, `_ROUNDING`."""
_ROUNDING = 2e-12


Law = Callable[[FloatArray], Number]


class Seen:
    """What one batch has shown of the others, at other values of the same facts of the same scene.

    compared
        Whether one of its answers was found alone, too.
    """

    def __init__(self) -> None:
        self.compared = False
        self._followed: tuple[Question, dict[str, Law]] | None = None
        self._within = np.empty((2, 0))

    def at(self, scene: Scene, facts: Sequence[FactAt], values: FloatArray) -> tuple[Question, dict[str, Number]]:
        """The question, and its numbers at all values (n_points, n_facts): a float where it is the same, else (n,).

        It is read at the corners and inside of the values, and again only beyond them, or where a number between
        corners that are farther apart has fewer digits.
        """
        ends = np.array([values.min(axis=0), values.max(axis=0)])
        if self._followed is None or np.any((ends - self._within) * [[1.0], [-1.0]] < 0.0):
            self._followed, exact = _followed(scene, facts, values)
            self._within = ends if exact else np.full(ends.shape, np.inf)
        first, laws = self._followed
        return first, {name: law(values) for name, law in laws.items()}


def _followed(
    scene: Scene, facts: Sequence[FactAt], values: FloatArray
) -> tuple[tuple[Question, dict[str, Law]], bool]:
    """The question with the law of each of its numbers, and whether all have all digits anywhere between the values."""

    def at(place: FloatArray, like: Question | None = None) -> tuple[Question, dict[str, float]]:
        here = with_changes(scene, {fact.path: fact.text(float(v)) for fact, v in zip(facts, place, strict=True)})
        asked = question(closed(pose(here)), like)
        return asked, {**asked.numbers, **_shaking(here)}

    where = places(values)
    first, begin = at(where[0])
    if any(row.tabled is not None for row in first.rows):
        raise NotClosedError("a number follows a table.")
    tables = [begin, *(_like(first, *at(one, first)) for one in where[1:])]
    if any(table.keys() != begin.keys() for table in tables):
        raise NotClosedError("the question is another one.")
    found = {name: law(where, [table[name] for table in tables]) for name in begin}
    return (first, {name: one for name, (one, _) in found.items()}), all(exact for _, exact in found.values())


def columns(
    scene: Scene,
    facts: Sequence[FactAt],
    values: FloatArray,
    progress: Callable[[float], None] | None = None,
    *,
    whole: bool = True,
    seen: Seen | None = None,
) -> Columns | None:
    """Answers at all values (n_points, n_facts) [SI]; None where the scene is not one that is answered together.

    A point has the status "" where nothing was proven, where it did not stand the check on the built machine, or, where
    the `whole` design is asked for and not the goal alone, where the goal does not say all of it.
    """
    if scene.find_all is not None or not _is_plain(scene) or np.any(np.ptp(values, axis=0) <= 0.0):
        return None
    try:
        first, numbers = (seen or Seen()).at(scene, facts, values)
        if scene.is_analysis:
            answers = Answers(np.full(len(values), OPTIMAL), np.zeros((1, len(values))), np.zeros((1, len(values))), 0)
        else:
            answers = answer(first, numbers, len(values), progress)
        known = {fact.path: values[:, i] for i, fact in enumerate(facts)}
        return _Checked(scene, first, numbers, known).columns(answers, whole=whole)
    except (NotClosedError, InputError):
        return None


def _is_plain(scene: Scene) -> bool:
    """Whether the scene is one body that moves along a line, on links that give stiffness and damping outright."""
    bodies, links = scene.bodies.values(), scene.links.values()
    return (
        len(bodies) == 1
        and (scene.goal is None or not scene.goal.response.of_limits)
        and not (scene.absorbers or scene.structures or scene.rotors or scene.mounts or scene.others)
        and all(not body.freedoms and body.rolling is None for body in bodies)
        and all(body.mass is not None or body.weight is not None for body in bodies)
        and all(
            link.part is None and not (link.says_axis or link.turns_with_shaft) and link.beam is None for link in links
        )
    )


def _like(first: Question, asked: Question, numbers: dict[str, float]) -> dict[str, float]:
    if asked.structure != first.structure:
        raise NotClosedError("the question is another one.")
    return numbers


def _shaking(scene: Scene) -> dict[str, float]:
    """Bounds, amplitudes and speeds of all limits as numbers, straight from the scene, and their structure in names."""
    found: dict[str, float] = {}
    for name, response in scene.limits.items():
        for side in ("at_most", "at_least"):
            if getattr(response, side) is not None:
                found[f"{name}.{side}"] = float(getattr(response, side).value)
        if not isinstance(response, HarmonicResponse):
            continue
        drive = names_for(scene, response)[0]
        (line,) = scene.excitations[drive].lines(np.ones(1))
        piece = line.amplitude.pieces[0]
        power = 0 if response.normalised else piece.power
        found[f"{name}.amplitude.{power}"] = 1.0 if response.normalised else abs(piece.constant) / line.order**power
        for b, band in enumerate(bands_for(scene, response, drive)):
            found[f"{name}.low{b}"], found[f"{name}.high{b}"] = line.order * band.low, line.order * band.high
    return found


def places(values: FloatArray) -> FloatArray:
    """Where the question is read, (n_places, n_facts): the corners of all values, the least first, then inside."""
    axes = [np.unique(column) for column in values.T]
    ends = [(axis[0], axis[-1]) for axis in axes]
    inside = [[axis[round(part * (len(axis) - 1))] for axis in axes] for part in _INSIDE[: len(axes)]]
    return np.array([*product(*ends), *inside])


def law(at: FloatArray, numbers: list[float]) -> tuple[Law, bool]:
    """A number that is constant, a product of powers of the facts, or linear in each of them, to 12 digits.

    It was read at the places `at` (n_places, n_facts); whether it has all digits anywhere between them is told, too.
    """
    if min(numbers) == max(numbers):
        return lambda values: numbers[0], True
    known, count = np.array(numbers), at.shape[1]
    first, last = at[0], at[2**count - 1]
    if np.all(at > 0.0) and np.all(known > 0.0):
        single = known[[2 ** (count - 1 - i) for i in range(count)]]  # where one fact alone is at its other end
        exponents = np.round(2.0 * np.log(single / known[0]) / np.log(last / first)) / 2.0
        if np.all(np.abs(known[0] * np.prod((at / first) ** exponents, axis=1) - known) <= _EXACT * known):
            unit = known[-1] / np.prod(at[-1] ** exponents)
            return lambda values: np.asarray(unit * np.prod(values**exponents, axis=1)), True
    corners = known[: 2**count].reshape((2,) * count)
    if np.all(np.abs(_linear(corners, (at - first) / (last - first)) - known) <= _EXACT * np.abs(known).max()):
        return lambda values: _linear(corners, (values - first) / (last - first)), False
    raise NotClosedError("a number does not follow the facts by a simple law.")


def _linear(corners: FloatArray, parts: FloatArray) -> FloatArray:
    """Between the corners of a box, linear in each of the parts (n, n_facts) of its sides."""
    found = corners[..., None]
    for part in parts.T:
        found = found[0] + (found[1] - found[0]) * part
    return np.asarray(np.broadcast_to(found, (len(parts),)))


@dataclass(frozen=True)
class _Checked:
    """Answers measured on the machines as built, with what the rows of the optimiser say beside it."""

    scene: Scene
    asked: Question
    numbers: Numbers
    known: Mapping[str, FloatArray]

    def columns(self, answers: Answers, *, whole: bool) -> Columns:
        """Check every answer; what is not optimal or infeasible beyond doubt has no status."""
        scene, count = self.scene, len(answers.status)
        x = np.full((len(scene.variables), count), np.nan)
        x[list(self.asked.order)] = answers.x[: len(self.asked.order)]
        shown = np.where(np.isnan(x), np.array([variable.high for variable in scene.variables]).reshape(-1, 1), x)
        chosen = {variable.path: row for variable, row in zip(scene.variables, shown, strict=True)}
        machine = built(scene, {**self.known, **chosen})
        if not isinstance(machine, LoneMachine) or machine.loose:
            raise NotClosedError("nothing holds the machine.")
        same, good = np.ones(count, dtype=bool), np.ones(count, dtype=bool)
        design, margins, worst, index = shown[list(self.asked.order)] if len(x) else answers.x, {}, {}, 0
        for name, response in scene.limits.items():
            sides = [side for side in ("at_most", "at_least") if getattr(response, side) is not None]
            for side in sides:
                value, omega = self._measured(machine, name, response, side, count)
                same &= self._agrees(index, design, value, omega)
                value = 1.0 - value if response.complement else value
                given = self.numbers[f"{name}.{side}"]
                size = np.abs(1.0 - given if response.complement else given)
                left = (given - value if side == "at_most" else value - given) / np.where(size == 0.0, 1.0, size)
                key = name if side == sides[0] else f"{name} ({side})"
                margins[key], worst[key] = left, (response, getattr(response, side).unit, value)
                good &= left >= -TOLERANCE
                index += 1
        if scene.is_analysis:
            judged = np.where(good, "met", "violated")
            return Columns(np.where(same, judged, "").tolist(), x, None, margins, self._judged(machine, worst, count))
        goal = None
        if scene.goal is not None:
            goal = np.broadcast_to(self._plain(machine, scene.goal.response), (count,))
        proven = (answers.status == OPTIMAL) & good & same
        proven &= ~self._undecided(design) if whole else True
        status = np.where(proven, "optimal", np.where(answers.status == INFEASIBLE, "infeasible", ""))
        return Columns(status.tolist(), x, goal, margins)

    def _judged(self, machine: LoneMachine, worst: Mapping[str, tuple[Response, str, FloatArray]], count: int) -> Words:
        """What was made best, where that is a property of the machine, and the worst value of each limit."""
        became = measured_goal(self.scene)
        goal = self.scene.measures[became] if became else None
        if isinstance(goal, (HarmonicResponse, TransientResponse, RandomResponse)):
            raise NotClosedError("what was made best is a motion.")
        best = None if goal is None else np.broadcast_to(self._plain(machine, goal), (count,))

        def words(index: int) -> tuple[Entry | None, Mapping[str, Entry], Mapping[str, Entry]]:
            def shown(response: Response, unit: str, value: FloatArray) -> Entry:
                return shown_value(
                    response, float(value[index]), response.unit or unit or usual_unit(self.scene, response)
                )

            left = {f"limits.{name}": shown(*one) for name, one in worst.items()}
            return None if goal is None or best is None else shown(goal, "", best), {}, left

        return words

    def _undecided(self, design: FloatArray) -> BoolArray:
        """Whether the goal is at the end of its range and leaves the other variable open."""
        place, way = self.asked.goal
        end = (self.asked.high if way > 0.0 else self.asked.low)[place]
        return np.asarray(self.asked.plane & (np.abs(design[place] - end) <= _SAME * end))

    def _agrees(self, index: int, design: FloatArray, value: FloatArray, omega: FloatArray) -> BoolArray:
        """Whether both routes give one value of a limit at the speed at which it is worst."""
        other, terms = value_at(self.asked, self.numbers, index, design, omega)
        room = np.maximum(_SAME, _ROUNDING * terms) * np.maximum(np.abs(value), np.abs(other))
        return np.asarray((np.abs(value - other) <= room) | (value == other))

    @staticmethod
    def _plain(machine: LoneMachine, response: Response) -> Any:
        if response.response == "damping_ratio" and getattr(response, "of", None) is None:
            return machine.damping_ratio
        return response.measure_static(machine)

    def _measured(
        self, machine: LoneMachine, name: str, response: Response, side: str, count: int
    ) -> tuple[FloatArray, FloatArray]:
        """Worst value of a response on each machine [SI], before its complement is taken, and where [rad/s]."""
        if not isinstance(response, HarmonicResponse):
            return np.broadcast_to(self._plain(machine, response), (count,)), np.zeros(count)
        key = next(number for number in self.numbers if number.startswith(f"{name}.amplitude."))
        power, drive = int(key.rpartition(".")[2]), names_for(self.scene, response)[0]
        shaker, lines = self.scene.excitations[drive], unit_lines(self.scene, drive)
        unit = Shaken(machine, response, shaker, lines, combine_for(self.scene, response))
        inner: FloatArray | None = None
        speeds, b = [], 0
        while f"{name}.low{b}" in self.numbers:
            low, high = (np.full((1, count), self.numbers[f"{name}.{end}{b}"]) for end in ("low", "high"))
            speeds += [low, high]
            if np.any(low < high):
                inner = machine.turning(unit.under_unit, power) if inner is None else inner
                if inner is None:
                    raise NotClosedError("its damping is of several kinds.")
                inside = np.clip(inner.reshape(len(inner), -1), low, high)
                speeds += [inside, low + (high - low) * _BETWEEN]
            b += 1
        omega = np.concatenate(speeds)
        with np.errstate(all="ignore"):
            value = unit.under_unit(omega) * self.numbers[key] * omega**power
        value[np.isnan(value)] = np.inf
        at = value.argmin(axis=0) if (side == "at_least") != response.complement else value.argmax(axis=0)
        return value[at, np.arange(count)], omega[at, np.arange(count)]
