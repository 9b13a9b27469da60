"""At what value of each fact a given machine first breaks a limit."""

from __future__ import annotations

from collections.abc import Callable, Collection
from itertools import pairwise

import numpy as np

from vibopt.answer.entry import Entry
from vibopt.arrays import FloatArray
from vibopt.bracketing import crossing
from vibopt.program.pose import pose
from vibopt.records import dataclass
from vibopt.scene.facts import facts
from vibopt.scene.scene import Scene
from vibopt.study.margins import LARGE, Margins
from vibopt.study.seen import shown_value
from vibopt.units import show
from vibopt.values.fact_at import FactAt

REACH = 10.0
ROOM = 1e-6
"""Part of a fact (or metres, of a coordinate that is zero) that counts as no room."""
_POINTS = 16
_NOT_PHYSICAL = (".order", ".tolerance")
_WORTH = -0.9
"""A top of a violation below this is not followed: its limit keeps nine tenths of its bound."""
_LOOK = 6
"""Over tolerances the worst machines are sought anew at every so many values, and where a limit breaks."""
METHOD = (
    "Each fact was followed to ten times and to a tenth of its value, a coordinate as far as the machine is long: over "
    "16 values each way, every value at which a natural frequency meets a speed or a bound of a limit, and every top "
    "of a limit between them. The first crossing is exact to the last digits, and beyond it the limits may hold again; "
    "a failing stretch narrower than all of these is not seen."
)
"""What was looked at, for the reader of the table."""


@dataclass(frozen=True, slots=True)
class Threshold:
    """One fact and the values at which the frozen design stops to meet its limits.

    below, above
        First failing value downward and upward; None where none is found within a factor `REACH`.
    limits
        Names of the limits that break there: (below, above).
    whole
        Whether it is a whole number, which fails at the ends and holds beside them.
    """

    path: str
    now: Entry
    below: Entry | None
    above: Entry | None
    limits: tuple[str, str]
    whole: bool = False

    @property
    def free(self) -> bool:
        """Whether no failing value was found."""
        return self.below is None and self.above is None

    def at_once(self, end: Entry) -> bool:
        """Whether an end leaves no room that anybody could measure."""
        return abs(end.value - self.now.value) <= ROOM * (abs(self.now.value) or 1.0)


def thresholds(
    scene: Scene, progress: Callable[[str, float], None] | None = None, only: Collection[str] | None = None
) -> list[Threshold]:
    """Threshold of every physical fact of an analysis whose limits all hold, or of those by path; `METHOD` says how.

    With tolerances each limit is the worst over them, as far as it was found.
    """
    physical = [one for one in facts(scene) if _is_physical(one)]
    extent = extent_of(physical)
    asked = [fact_at for fact_at in physical if only is None or fact_at.path in only]
    if not pose(scene).limits:
        return []
    found = []
    first: Margins | None = None
    for index, fact in enumerate(asked):
        if progress is not None:
            progress("thresholds", index / len(asked))
        margins = Margins(scene, fact)
        if first is None:
            first = margins
            margins.full(fact.value)
        margins.worst_machines = {key: [*many] for key, many in first.worst_machines.items()}
        found.append(_of(margins, extent))
    return found


def _is_physical(fact: FactAt) -> bool:
    if fact.path.startswith("limits.") or fact.path.endswith(_NOT_PHYSICAL):
        return False
    return fact.signed or fact.value > 0.0


def extent_of(asked: list[FactAt]) -> float:
    """Greatest distance between two places along an axis [m]."""
    sides = [0.0]
    for axis in "xyz":
        values = [fact_at.value for fact_at in asked if fact_at.signed and fact_at.path.endswith(f".{axis}")]
        sides.append(max(values) - min(values) if values else 0.0)
    return max(sides) or 1.0


def _of(margins: Margins, extent: float) -> Threshold:
    fact = margins.fact
    if fact.dimension == "count":
        down, up = _counted(margins, 1.0 / REACH), _counted(margins, REACH)
    else:
        down, up = _crossing(margins, _values(fact, extent, -1)), _crossing(margins, _values(fact, extent, 1))
    ends = [None if value is None else _apart(fact, float(value)) for value in (down, up)]
    names = ["" if value is None else margins.name(value) for value in (down, up)]
    return Threshold(
        fact.path, shown_value(fact, fact.value), ends[0], ends[1], (names[0], names[1]), fact.dimension == "count"
    )


def _apart(fact: FactAt, value: float) -> Entry:
    """A value with as many digits as it takes to tell it from the fact."""
    now = shown_value(fact, fact.value).shown
    texts = (show(value, fact.unit, fact.dimension, digits=n, amplitude=fact.amplitude) for n in (4, 6, 8, 10, 13))
    text = next((one for one in texts if one != now), now)
    return Entry(value, fact.dimension, text=text)


def _counted(margins: Margins, reach: float) -> float | None:
    """The first failing whole number."""
    now, last = round(margins.fact.value), round(margins.fact.value * reach)
    steps = range(now + 1, last + 1) if reach > 1.0 else range(now - 1, 0, -1)
    return next((float(n) for n in steps if margins.most(float(n)) > 0.0), None)


def _values(fact: FactAt, extent: float, way: int) -> list[float]:
    """Values to try, from the fact outward, that value first."""
    if fact.signed:
        return [float(v) for v in fact.value + way * extent * np.linspace(0.0, 1.0, _POINTS + 1)]
    return [float(v) for v in fact.value * np.geomspace(1.0, REACH**way, _POINTS + 1)]


def _crossing(margins: Margins, values: list[float]) -> float | None:
    """The first failing value; None where none was found before the last, or before the scene cannot be."""
    start = values[0]
    if margins.most(start) > 0.0:
        return start
    before = values[-1]
    for sparing in (True, True, True, False, False):
        bad = _first(margins, values, sparing)
        if bad is None:
            return None
        margins.refining = sparing
        if not margins.most(bad[0]) <= 0.0 < margins.most(bad[1]):  # on a machine that was not known before
            continue
        edge = crossing(margins.most, *bad)[1]
        margins.refining = False
        before = float(np.nextafter(edge, start))
        if before == start or not (_breaks(margins.full(edge)) and _breaks(margins.full(before))):
            return edge
        values = [start, *[v for v in values[1:] if abs(v - start) < abs(before - start)], before]
    return before


def _breaks(found: FloatArray | None) -> bool:
    return found is not None and bool(found.max(initial=-LARGE) > 0.0)


def _first(margins: Margins, values: list[float], sparing: bool) -> tuple[float, float] | None:
    """A good value and the first failing one behind it; `sparing` looks for new worst machines at few values only."""
    seen = [values[0]]
    for index, (last, value) in enumerate(pairwise(values)):
        margins.refining = sparing and (index + 1) % _LOOK != 0 and value != values[-1]
        if margins(value) is None:
            return None
        for step in (*_meetings(margins, last, value), value):
            found = _top(margins, [*seen[-2:], step])
            if found is not None:
                return seen[max(len(seen) - 2, 0)], found
            if margins.most(step) > 0.0:
                return seen[-1], step
            seen.append(step)
    return None


def _meetings(margins: Margins, low: float, high: float) -> list[float]:
    """Values between two at which a natural frequency meets one that a limit looks at, in order from `low`."""
    first, last = margins.above(low), margins.above(high)
    if first is None or last is None or first.shape != last.shape:
        return []
    found = []
    for index in np.flatnonzero(first * last < 0.0):

        def gap(value: float, index: int = int(index), way: float = float(np.sign(last[index]))) -> float:
            here = margins.above(value)
            return way * float(here[index]) if here is not None and len(here) > index else 0.0

        found.append(crossing(gap, low, high, 1e-12, least=1e-9 * abs(high - low))[0])
    found = sorted(set(found), key=lambda one: abs(one - low))
    middles = [0.5 * (a + b) for a, b in pairwise(found)]
    both = sorted({*found, *middles}, key=lambda one: abs(one - low))
    return [one for one in both if min(low, high) < one < max(low, high) and margins(one) is not None]


def _top(margins: Margins, three: list[float]) -> float | None:
    """A failing value between the outer two of three, where the violation of a limit has its top; None without one."""
    if len(three) < 3:
        return None
    rows = [margins(value) for value in three]
    if any(row is None or row.shape != rows[0].shape for row in rows):  # type: ignore[union-attr]
        return None
    left, middle, right = (np.asarray(row) for row in rows)
    for index in np.flatnonzero((middle >= left) & (middle >= right) & (middle > _WORTH) & (middle <= 0.0)):
        found = _climbed(margins, three, int(index))
        if found is not None:
            return found
    return None


def _climbed(margins: Margins, three: list[float], index: int) -> float | None:
    """Up to the top of one limit between the outer two of three; the first failing value met on the way."""
    from scipy.optimize import minimize_scalar

    bad: list[float] = []

    def fall(value: float) -> float:
        here = margins(value)
        size = -LARGE if here is None or len(here) <= index else float(here[index])
        if size > 0.0:
            bad.append(value)
            raise StopIteration
        return -size

    low, high = sorted((three[0], three[2]))
    flat = float(np.ptp([margins(one)[index] for one in three])) <= 1e-12  # type: ignore[index]
    if not flat and high > low:
        try:
            minimize_scalar(fall, bounds=(low, high), method="bounded", options={"xatol": 1e-6 * (high - low)})
        except StopIteration:
            return bad[0]
    return None
