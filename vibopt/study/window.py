"""The permitted designs: how far each variable may go, and the largest box of equal parts that stays permitted."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import product
from math import isfinite
from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.answer.entry import Entry
from vibopt.answer.tabular import Tabular
from vibopt.arrays import FloatArray
from vibopt.document.mistakes import Mistakes
from vibopt.document.toml_reading import changed
from vibopt.errors import InputError
from vibopt.forms import Monomials
from vibopt.jobs import answer, of_document, scene_only
from vibopt.program.pose import pose
from vibopt.program.program import Aim, Program
from vibopt.records import dataclass
from vibopt.scene.open_places import open_places, open_positions
from vibopt.scene.scene import Scene
from vibopt.scene.uncertain import uncertain
from vibopt.solve.branch import Judge
from vibopt.solve.method import Progress
from vibopt.solve.one_range import permitted
from vibopt.solve.ranges import closed
from vibopt.solve.solve import answer as best_of
from vibopt.verify.checked import checked_limits

if TYPE_CHECKING:
    from vibopt.jobs import Job

MOST_VARIABLES = 6
_GRID = {1: 257, 2: 21, 3: 9, 4: 6, 5: 4, 6: 4}
_TRIED = 12
"""Designs of the grid from which the centre is sought."""
_STEPS = 30
_ROOM = 1e-6
"""Part by which a box is drawn in, so that its faces hold as measured."""
_SHRINK = 14
_MOST = 0.5
"""Greatest half of a box that is looked at."""


@dataclass(frozen=True, slots=True)
class Span:
    """How far a variable may go while the others move as it needs.

    intervals
        From and to; several where one variable is all there is.
    proven
        Whether the ends are: beyond them no design is permitted.
    opened
        Whether it goes on beyond the last end without end.
    """

    path: str
    intervals: tuple[tuple[Entry, Entry], ...]
    proven: bool
    opened: bool = False


@dataclass(frozen=True, slots=True)
class Window(Tabular):
    """Permitted designs of a machine.

    spans
        One per variable.
    centre
        Design in the middle of the largest box that was found, by path.
    part
        Half of that box, as a part of each value: 0.09 for ±9 %.
    proven
        Whether it is proven that every limit holds all over the box.
    claim
        How the box was tested.
    around
        Half of the largest box around the answer itself.
    """

    job: Job
    spans: tuple[Span, ...]
    centre: Mapping[str, Entry]
    part: float
    proven: bool
    claim: str
    around: float

    def table(self) -> list[dict[str, Any]]:
        """A row for each interval of each variable: its ends, and the box in it."""
        rows = []
        for span in self.spans:
            middle = self.centre[span.path]
            for low, high in span.intervals:
                rows.append({
                    "path": span.path, "unit": middle.si, "from": low.value, "to": high.value, "proven": span.proven,
                    "open": span.opened, "centre": middle.value, "box from": middle.value * (1.0 - self.part),
                    "box to": middle.value * (1.0 + self.part), "from shown": low.shown, "to shown": high.shown,
                    "centre shown": middle.shown,
                })  # fmt: skip
        return rows

    def heading(self) -> tuple[str, ...]:
        """Title, and the box in words."""
        return self.job.title, f"±{percent(self.part)} on each at once is safe: {self.claim}"

    def to_json(self) -> dict[str, Any]:
        """Spans, centre and box."""
        keys = ("spans", "centre", "part", "proven", "claim", "around")
        return {key: getattr(self, key) for key in keys}


def percent(part: float) -> str:
    """A part in percent, rounded down: what is said holds."""
    if part <= 0.0:
        return "0 %"
    step = 10.0 ** (np.floor(np.log10(100.0 * part)) - 2)
    return f"{np.floor(100.0 * part / step * (1.0 + 1e-12)) * step:.3g} %"


def window(job: Job, *, progress: Progress | None = None) -> Window:
    """How far each variable may go, and the largest box of equal parts in which every limit holds.

    Parameters
    ----------
    job
        A machine with limits and up to six variables, each chosen from a range; its goal does not matter.
    progress
        Called now and then with a stage and the part that is done.

    Raises
    ------
    InputError
        A job of another kind, a choice that is no range, or no permitted design.
    """
    instead = "A weight is an amount at an angle: vibopt sweep --keep-design shows what each may be off by."
    scene = scene_only(job, "window", instead)
    _check(scene)
    program = replace(closed(pose(scene)), aim=None)
    spans = _only(scene, program) if len(program.axes) == 1 else tuple(_spans(scene, program, progress))
    box = _Box(program, spans)
    centre, part = box.largest(progress)
    part, proven, claim = _tested(scene, centre, part)
    own = _own(scene)
    around = 0.0 if own is None else box.half(own)
    shown = {one.path: Entry(float(x), one.dimension, one.unit) for one, x in zip(scene.variables, centre, strict=True)}
    return Window(job, spans, shown, part, proven, claim, around)


def _check(scene: Scene) -> None:
    if not scene.limits:
        raise InputError(f"{scene.name}: window needs limits: without any every design is permitted.")
    listed = next((one.path for one in scene.variables if one.values is not None), "")
    listed = listed or next(iter({**open_places(scene), **open_positions(scene)}), "")
    if listed:
        raise InputError(
            f"{scene.name}: window is for variables that are chosen from a range, and {listed} is chosen from a list "
            "or is a place. Set it to a value with --set."
        )
    if uncertain(scene):
        raise InputError(
            f"{scene.name}: window finds the tolerances that a design bears, and the file has tolerances already. "
            "Leave them out."
        )
    if not 1 <= len(scene.variables) <= MOST_VARIABLES:
        raise InputError(
            f"{scene.name}: window is for one to {MOST_VARIABLES} variables, and the file has {len(scene.variables)}. "
            "Set some to values with --set."
        )


def _none(scene: Scene, words: str) -> InputError:
    return InputError(f"{scene.name}: there is no permitted design ({words}). vibopt explain says which limits clash.")


def _only(scene: Scene, program: Program) -> tuple[Span, ...]:
    """Of one variable all intervals."""
    (variable,) = scene.variables
    found = permitted(program)
    if not found.intervals:
        raise _none(scene, "proven" if found.complete else "none was found")
    ends = tuple(
        (Entry(low, variable.dimension, variable.unit), Entry(high, variable.dimension, variable.unit))
        for low, high in found.intervals
    )
    opened = program.axes[0].open_high and found.intervals[-1][1] >= 0.999 * program.axes[0].high
    return (Span(variable.path, ends, found.complete, opened),)


def _spans(scene: Scene, program: Program, progress: Progress | None) -> Iterator[Span]:
    """Least and greatest of each variable over all permitted designs, each a program of its own."""
    for index, variable in enumerate(scene.variables):
        if progress is not None:
            progress("window", 0.5 * index / len(scene.variables))
        row = np.zeros((1, len(program.axes)))
        row[0, index] = 1.0
        form = Monomials(np.ones(1), row)
        ends, proven, opened = [], True, False
        for sense in (1.0, -1.0):
            found, _ = best_of(program.aiming(Aim(variable.path, program.model, form, sense)), scene, None, None)
            if found.x is None and found.status != "unbounded":
                raise _none(scene, "proven" if found.status == "infeasible" else "none was found")
            opened |= found.status == "unbounded"
            end = program.axes[index].high if found.x is None else float(found.x[index])
            sound = found.x is None or all(one.met for one in _rows(scene, found.x))
            proven &= found.status in ("optimal", "unbounded") and sound
            ends.append(Entry(end, variable.dimension, variable.unit))
        yield Span(variable.path, ((ends[0], ends[1]),), proven, opened)


def _rows(scene: Scene, x: FloatArray) -> list[Any]:
    chosen = {one.path: float(v) for one, v in zip(scene.variables, x, strict=True)}
    return list(checked_limits(scene, chosen).values())


class _Box:
    """Boxes of equal parts around designs, tested at their corners and in the middles of their edges and faces."""

    def __init__(self, program: Program, spans: tuple[Span, ...]) -> None:
        self.judge = Judge(program)
        self.limits = list(program.limits)
        self.low, self.high = program.low, program.high
        self.inner = [(one.intervals[0][0].value, one.intervals[-1][1].value) for one in spans]
        count = len(spans)
        places = (-1.0, 0.0, 1.0) if count <= 3 else (-1.0, 1.0)
        corners = [one for one in product(places, repeat=count) if any(one)]
        self.corners = np.array(sorted(corners, key=lambda one: -sum(map(abs, one))))

    def holds(self, x: FloatArray, part: float, places: int) -> bool:
        """Whether all places of a box hold; first those that are farthest out."""
        return all(self._good(x * (1.0 + part * one)) for one in self.corners[:places])

    def _good(self, x: FloatArray) -> bool:
        """Whether a design is permitted; the limit that was broken last is asked first."""
        for index, limit in enumerate(self.limits):
            if self.judge.limit(limit, x)[0] > self.judge.tolerance:
                self.limits.insert(0, self.limits.pop(index))
                return False
        return True

    def half(self, x: FloatArray, close: float = 1e-7, most_places: int = 1000) -> float:
        """Half of the largest box around a design, as a part; fewer places are its corners."""
        x = np.asarray(x, dtype=float)
        if not self.judge.feasible(x):
            return 0.0
        with np.errstate(divide="ignore", invalid="ignore"):
            most = float(min(np.min((x - self.low) / x), np.min((self.high - x) / x), _MOST))
        if most <= 0.0:
            return 0.0
        if self.holds(x, most, most_places):
            return most
        good, bad = 0.0, most
        for _ in range(_STEPS):
            middle = 0.5 * (good + bad)
            good, bad = (middle, bad) if self.holds(x, middle, most_places) else (good, middle)
            if bad - good <= close * bad:
                break
        return good

    def largest(self, progress: Progress | None) -> tuple[FloatArray, float]:
        """The best centre that was found, and half of its box."""
        from scipy.optimize import minimize

        axes = [_between(low, high, _GRID[len(self.inner)]) for low, high in self.inner]
        grid = np.array(list(product(*axes)))
        self.judge.ahead(grid)
        good = [(self._margin(x), x) for x in grid]
        good = sorted((one for one in good if one[0] >= 0.0), key=lambda one: -one[0])
        if not good:
            middle = np.array([np.sqrt(max(low, 1e-300) * high) for low, high in self.inner])
            return middle, self.half(middle)
        tried = [(self.half(x, 1e-2, 2 ** len(x)), x) for _, x in good[:: max(1, len(good) // _TRIED)]]
        tried.sort(key=lambda one: -one[0])
        best = (self.half(tried[0][1]), tried[0][1])
        x = tried[0][1]
        if progress is not None:
            progress("window", 0.6)
        simplex = np.log(x) + 0.05 * np.vstack([np.zeros(len(x)), np.eye(len(x))])
        options: Any = {"xatol": 1e-4, "fatol": 1e-6, "maxfev": 40 + 20 * len(x), "initial_simplex": simplex}
        found: Any = minimize(self._small, np.log(x), method="Nelder-Mead", options=options)
        if -found.fun > best[0]:
            best = (-float(found.fun), np.exp(found.x))
        return best[1], self.half(best[1])

    def _small(self, y: FloatArray) -> float:
        """What is made least where the box is greatest; y is the logarithm of its centre."""
        return -self.half(np.exp(y), 1e-3, 2 ** len(y))

    def _margin(self, x: FloatArray) -> float:
        return -max((self.judge.limit(one, x)[0] for one in self.judge.program.limits), default=0.0)


def _between(low: float, high: float, count: int) -> FloatArray:
    """Places inside of an interval, by ratios where it is wide."""
    spaced = np.geomspace if low > 0.0 and high > 3.0 * low else np.linspace
    return np.asarray(spaced(low, high, count + 2)[1:-1])


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
        one.path: {"value": f"{x:.17g} {Entry(x, one.dimension).si}".strip(), "tolerance": f"{100.0 * part:.17g} %"}
        for one, x in zip(scene.variables, map(float, centre), strict=True)
    }
    document = {key: one for key, one in changed(scene.document, said).items() if key not in ("goal", "expected")}
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


__all__ = ["Span", "Window", "percent", "window"]
