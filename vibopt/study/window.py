"""The permitted designs: how far each variable may go, and the largest box of equal parts that stays permitted."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import product
from math import isfinite
from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.answer.entry import Entry
from vibopt.arrays import FloatArray
from vibopt.balancing import is_engine, is_known, is_rotor
from vibopt.bracketing import crossing
from vibopt.document.mistakes import Mistakes
from vibopt.document.toml_reading import changed
from vibopt.errors import InputError, RoutesDiffer
from vibopt.jobs import answer, of_document, scene_only
from vibopt.program.pose import pose
from vibopt.program.program import Program
from vibopt.scene.open_places import open_places, open_positions
from vibopt.scene.places import bound_parts
from vibopt.scene.scene import Scene
from vibopt.scene.uncertain import uncertain
from vibopt.solve.method import Progress
from vibopt.solve.ranges import closed
from vibopt.study.freeze import shown_values
from vibopt.study.permitted import Window
from vibopt.study.spans import Span, Violations, between, spans_of
from vibopt.study.weights_window import weights_window
from vibopt.verify.checked import checked_limits, disagreement

if TYPE_CHECKING:
    from vibopt.jobs import Job

MOST_VARIABLES = 6
_GRID = {1: 65, 2: 12, 3: 7, 4: 4, 5: 3, 6: 2}
_TRIED, _GROWN = 8, 2
"""Designs of the grid around which a box is measured, and from which the centre is sought."""
_COARSE, _FINE, _CLOSE = 1e-2, 1e-4, 1e-7
"""Part to which a box is known: of many, while it is moved, and at the end."""
_GREAT = 10.0
"""A limit that is missed by more counts as missed by this."""
_REACH, _NO_REACH, _GAIN = 0.3, 3e-3, 3e-4
_NEAR, _SLOPE = -0.9, 1e-6
"""Least violation of a place that is followed, and how far its slope is taken, in logs."""
_ROOM = 1e-6
"""Part by which a box is drawn in, so that its faces hold as measured."""
_SHRINK = 14
_MOST = 0.5
"""Greatest half of a box that is looked at."""


def window(job: Job, *, progress: Progress | None = None) -> Window:
    """How far each variable may go, and the largest box of equal parts in which every limit holds.

    Parameters
    ----------
    job
        A machine with limits and up to six variables, each chosen from a range, or a measured rotor or a shaft with
        known masses with limits and free weights; its goal does not matter.
    progress
        Called now and then with a stage and the part that is done.

    Raises
    ------
    InputError
        A job of another kind, a choice that is no range, or no permitted design.
    """
    if is_rotor(job) or is_known(job):
        return weights_window(job)
    if is_engine(job):
        raise InputError(
            f"{job.name}: window is for limits that hold one amplitude each, and the orders of an engine add up over a "
            "turn. vibopt sweep FILE --keep-design --vary PATH=RANGE shows what each share or weight may be."
        )
    scene = scene_only(job, "window")
    _check(scene)
    program = replace(closed(pose(scene)), aim=None)
    middle = np.where(program.low > 0.0, np.sqrt(program.low * program.high), 0.5 * (program.low + program.high))
    _confirmed(scene, program, [middle])
    begin: list[FloatArray] = []
    spans = spans_of(scene, program, progress, begin)
    box = _Box(program, spans)
    if len(spans) == 1:
        centre, part = _widest(spans[0])
        part, proven, claim = part * (1.0 - _ROOM), spans[0].proven, "every limit was followed all over it"
    else:
        mean = [np.exp(np.mean(np.log(begin), axis=0))] if begin and np.min(begin) > 0.0 else []
        centre, part = box.largest(np.array(mean).reshape(-1, len(spans)), progress)
        part, proven, claim = _tested(scene, centre, part)
    if program.doubts:
        spans = tuple(replace(span, proven=False) for span in spans)
        proven, claim = False, f"{claim}; {program.doubts}"
    _confirmed(scene, program, [centre, centre * (1.0 - part), centre * (1.0 + part)])
    own = _own(scene)
    around = 0.0 if own is None else box.half(own)
    return Window(job, spans, shown_values(scene, centre), part, proven, claim, around, doubts=program.doubts)


def _confirmed(scene: Scene, program: Program, designs: Sequence[FloatArray]) -> None:
    """Refuse to tell a window of a model from which the machine as built differs at one of the designs (n_vars,)."""
    for x in designs:
        rows = checked_limits(scene, scene.named(x), model=program.model)
        if any(row.doubt for row in rows.values()):
            raise RoutesDiffer(f"{scene.name}: no window is told: {disagreement(rows)}")


def _check(scene: Scene) -> None:
    if not scene.limits:
        raise InputError(f"{scene.name}: window needs limits: without any every design is permitted.")
    if parts := bound_parts(scene):
        raise InputError(
            f"{scene.name}: window is for variables that are chosen from a range, and {parts[0].path} is of a "
            "catalogue, of which each part is permitted or not. vibopt solve FILE lists the best choices; --set "
            f'{parts[0].path}.name="..." takes one.'
        )
    listed = next((variable.path for variable in scene.variables if variable.values is not None), "")
    listed = listed or next(iter({**open_places(scene), **open_positions(scene)}), "")
    if listed:
        raise InputError(
            f"{scene.name}: window is for variables that are chosen from a range, and {listed} is chosen from a list "
            "or is a place. Set it to a value with --set."
        )
    if uncertain(scene):
        without = " ".join(f'--set {path}="0 %"' for path in _tolerances(scene.document, ""))
        raise InputError(
            f"{scene.name}: window finds the tolerances that a design bears, and the file has tolerances already. "
            f"Leave them out{f': {without}' if without else ''}."
        )
    if not scene.variables:
        raise InputError(f"{scene.name}: nothing is chosen, so nothing may go anywhere. Write a range, {{ from, to }}.")
    if len(scene.variables) > MOST_VARIABLES:
        raise InputError(
            f"{scene.name}: window is for one to {MOST_VARIABLES} variables, and the file has {len(scene.variables)}. "
            "Set some to values with --set."
        )


def _tolerances(table: Mapping[str, Any], base: str) -> Iterator[str]:
    """Paths of the tolerances that a file says itself."""
    for key, value in table.items():
        if key == "tolerance":
            yield f"{base}{key}"
        elif isinstance(value, Mapping) and base + key != "scenarios":
            yield from _tolerances(value, f"{base}{key}.")


def _widest(span: Span) -> tuple[FloatArray, float]:
    """Centre and half of the largest box of one variable: of a wide interval the middle by ratios."""
    low, high = max(
        ((a.value, b.value) for a, b in span.intervals),
        key=lambda one: one[1] / one[0] if one[0] else np.inf if one[1] else 0.0,
    )
    part = min((high - low) / (high + low) if high else 0.0, _MOST)
    centre = float(np.clip(np.sqrt(low * high), low / (1.0 - part), high / (1.0 + part)))
    return np.array([centre]), part


class _Box:
    """Boxes of equal parts around designs, tested at their corners and in the middles of their edges and faces."""

    def __init__(self, program: Program, spans: tuple[Span, ...]) -> None:
        self.violations = Violations(program)
        self.tolerance = self.violations.judge.tolerance
        self.low, self.high = program.low, program.high
        self.inner = [(span.intervals[0][0].value, span.intervals[-1][1].value) for span in spans]
        count = len(spans)
        places = (-1.0, 0.0, 1.0) if count <= 3 else (-1.0, 1.0)
        self.places = np.array([one for one in product(places, repeat=count) if any(one)])

    def half(self, x: FloatArray, close: float = _CLOSE) -> float:
        """Half of the largest box around a design, as a part, known to a part of itself."""
        x = np.asarray(x, dtype=float)
        if not self.violations.most(x[None])[0] <= self.tolerance:
            return 0.0
        with np.errstate(divide="ignore", invalid="ignore"):
            part = float(min(np.min((x - self.low) / x), np.min((self.high - x) / x), _MOST))
        for index in range(len(self.violations.limits)):
            part = self._half_of(index, x, part, close)
        return max(part, 0.0)

    def _half_of(self, index: int, x: FloatArray, part: float, close: float) -> float:
        """The same for one limit, no more than `part`: drawn in to the place that is missed most, until none is."""
        places = self.places
        while part > 0.0:
            missed = self.violations(index, x * (1.0 + part * places))
            bad = ~(missed <= self.tolerance)
            if not bad.any():
                break
            first = places[int(np.argmax(np.where(np.isnan(missed), np.inf, missed)))]
            part, places = self._until(index, x, first, part, close), places[bad]
        return part

    def _until(self, index: int, x: FloatArray, place: FloatArray, part: float, close: float) -> float:
        """How far from a design towards a place that is missed a limit holds."""

        def missed(t: float) -> float:
            value = float(self.violations(index, (x * (1.0 + t * place))[None])[0]) - self.tolerance
            return min(value, _GREAT) if value > -_GREAT else -_GREAT if value == value else _GREAT

        return crossing(missed, 0.0, part, close)[0]

    def largest(self, begin: FloatArray, progress: Progress | None) -> tuple[FloatArray, float]:
        """The best centre that was found, and half of its box; `begin` (n, n_vars) are designs to look at too."""
        axes = [between(low, high, _GRID[len(self.inner)]) for low, high in self.inner]
        grid = np.concatenate([begin, np.array(list(product(*axes)))])
        missed = self.violations.most(grid)
        good = grid[np.argsort(missed, kind="stable")][: int((missed <= self.tolerance).sum())]
        if not len(good):
            middle = np.array([np.sqrt(max(low, 1e-300) * high) for low, high in self.inner])
            return middle, self.half(middle)
        tried = sorted(((self.half(x, _COARSE), tuple(x)) for x in good[:: max(1, len(good) // _TRIED)]), reverse=True)
        if progress is not None:
            progress("window", 0.6)
        _, x = max((self._grown(np.array(x), part) for part, x in tried[:_GROWN]), key=lambda one: one[0])
        return x, self.half(x)

    def _grown(self, x: FloatArray, part: float) -> tuple[float, FloatArray]:
        """A box moved and grown by linear programs on what limits do at its places, until it grows no more."""
        reach = _REACH
        while reach > _NO_REACH and 0.0 < part < _MOST:
            step = self._step(x, part, reach)
            moved = x * np.exp(step)
            new = self.half(moved, _FINE) if np.all((moved >= self.low) & (moved <= self.high)) else 0.0
            if new > part * (1.0 + _GAIN):
                x, part, reach = moved, new, min(2.0 * reach, _REACH)
            else:
                reach *= 0.2
        return part, x

    def _step(self, x: FloatArray, part: float, reach: float) -> FloatArray:
        """How to move the logarithm of a centre (n_vars,), as far as slopes tell."""
        from vibopt.cones import LINEAR, solve_cones

        count, parts = len(x), 1.0 + part * self.places
        rows, right = [], []
        for index in range(len(self.violations.limits)):
            here = self.violations(index, x * parts)
            near = np.isfinite(here) & (here > _NEAR)
            at, value = parts[near], here[near]
            beside = [self.violations(index, x * np.exp(_SLOPE * one) * at) for one in np.eye(count)]
            slope = np.array([(one - value) / _SLOPE for one in beside]).reshape(count, -1).T
            along = (slope * self.places[near] / at).sum(axis=1)
            rows.append(np.column_stack([slope, along]))
            right.append(-value)
        ends = np.column_stack([np.eye(count), np.full(count, 1.0 / (1.0 + part))])
        under = np.column_stack([-np.eye(count), np.full(count, 1.0 / (1.0 - part))])
        with np.errstate(divide="ignore"):
            right += [np.log(self.high / x) - np.log1p(part), np.log(x / self.low) + np.log1p(-part)]
        square = np.eye(count + 1)
        table = np.concatenate([*rows, ends, under, square, -square])
        limits = np.concatenate([*right, np.full(2 * count + 2, reach)])
        keep = np.isfinite(table).all(axis=1) & np.isfinite(limits)
        size = np.maximum(np.abs(table[keep]).max(axis=1), 1e-12)
        linear = np.append(np.zeros(count), -1.0)
        cone_point = solve_cones(linear, table[keep] / size[:, None], limits[keep] / size, [(LINEAR, int(keep.sum()))])
        return cone_point.x[:count] if cone_point.is_finite else np.zeros(count)


def _tested(scene: Scene, centre: FloatArray, part: float) -> tuple[float, bool, str]:
    """The box as one of tolerances around the centre, answered for the worst machine; drawn in until it holds."""
    part *= 1.0 - _ROOM
    for _ in range(_SHRINK):
        worst = _over(scene, centre, part)
        if worst is None:
            break
        if worst.status == "met":
            return part, worst.proven and "proven" in worst.claim, worst.claim
        part *= 0.9
    return part, False, "every limit holds at its corners, in the middles of its edges and faces, and at its centre"


def _over(scene: Scene, centre: FloatArray, part: float) -> Any:
    """The answer over the tolerances of a box; None where the numbers take no tolerance."""
    if not part > 0.0:
        return None
    said = {
        variable.path: {
            "value": f"{x:.17g} {Entry(x, variable.dimension).si}".strip(),
            "tolerance": f"{100.0 * part:.17g} %",
        }
        for variable, x in zip(scene.variables, map(float, centre), strict=True)
    }
    document = {
        key: one for key, one in changed(scene.document, said).items() if key not in ("goal", "expected", "measures")
    }
    try:
        return answer(of_document(document, Mistakes(scene.name, None)), explain=False)
    except InputError:
        return None


def _own(scene: Scene) -> FloatArray | None:
    """What the file's own goal chooses; None without a goal or a design."""
    if scene.goal is None:
        return None
    found = answer(scene, explain=False, brief=True)
    x = np.array(found.x, dtype=float)
    return x if len(x) == len(scene.variables) and all(map(isfinite, x)) else None
