"""Limiting performance: what no isolator can do better, passive or active, when a load comes once.

Relative to its support a mass moves with x'' = u - g, from rest when the load begins, where g is the acceleration of
the support (less force over mass) and u what the isolator gives the mass.  Sought is the least peak of |u| for a room
|x| <= d, or the least room for a peak, over every u in time.  Both ends of the answer are bounds:

- From above, a u that is constant between nodes, with x held inside the room at the nodes by as much as it may bulge
  between them (h^2 / 8 of |x''| at most), and stopped behind the load where its speed leaves room to: a cone program.
- From below, any numbers l_i at times t_i: with the path Y of the support, sum l_i Y_i - d sum |l_i| is no more than
  sum l_i X_i = integral of K u, and so no more than the peak times the integral of |K|, K(s) = sum l_i max(t_i - s, 0).
  The multipliers of the program are such numbers, and all of this is arithmetic: no step of time leaves anything out.

Nodes are added where the two ends differ: where x touches the room and where K changes its sign.
"""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from vibopt.arrays import BoolArray, FloatArray, IntArray
from vibopt.cones import CONE, EQUAL, LINEAR, by_columns, solve_cones
from vibopt.mechanics.panels import exponentials
from vibopt.mechanics.readout import Reading
from vibopt.mechanics.stretches import joints_of
from vibopt.mechanics.transient import Transient
from vibopt.records import cached_property, dataclass
from vibopt.signals import Segment

CLOSE = 2e-4
"""Part of the upper end by which the two ends may differ."""
_FEW, _MOST, _ROUNDS, _JOINTS = 60, 2500, 20, 200
"""Cells at first, and in all; programs in a row; joints that are all nodes at first."""
_BULGE = 0.3
"""Part of the room that a bulge between the first nodes takes at most, as far as there may be cells."""
_TOUCHES, _ATOM, _NONE = 1e-6, 1e-12, 1e-7
"""Parts of the greatest multiplier from which one counts; part of the load's size that is no peak at all."""
_TOLERANCE, _SURE = 1e-10, 1e-8
"""Of the program, and part by which its upper end may be off."""
_LOOKS = 17


@dataclass(frozen=True, slots=True)
class Between:
    """What is sought lies between `low`, which is proven, and `high`, which some isolator reaches [SI]."""

    low: float
    high: float


@dataclass(frozen=True)
class Path:
    """Path of a support that its acceleration makes, from rest: a sum of signals.

    mix
        (n_signals,): acceleration [m/s^2] for signals of one.
    segments
        The signals; none goes on for ever.
    """

    mix: FloatArray
    segments: tuple[Segment, ...]

    @cached_property
    def _free(self) -> Transient:
        one, none = np.ones((1, 1)), np.zeros((1, 1))
        return Transient(one, none, none, 1, np.asarray(self.mix)[None, :], self.segments)

    def at(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Displacement [m] and velocity [m/s] at times that rise (n,), just behind any blow."""
        one, none = np.ones(1), np.zeros(1)
        return self._free.history(Reading(one, none, none), times), self._free.history(Reading(none, one, none), times)

    @cached_property
    def joints(self) -> FloatArray:
        """Where a segment begins or the last ends [s], (n_segments + 1,)."""
        ended, found = 0.0, [np.zeros(1)]
        for run in self._free.runs:
            found.append(ended + joints_of(run)[1:])
            ended = float(found[-1][-1])
        return np.concatenate(found)

    @cached_property
    def struck(self) -> BoolArray:
        """Whether a blow comes at each joint but the last."""
        return np.array([bool((segment.blows @ self.mix) != 0.0) for segment in self.segments])

    @cached_property
    def pushes(self) -> FloatArray:
        """What the acceleration does not exceed on each segment, without blows [m/s^2]."""
        found = []
        for run in self._free.runs:
            rates, read = run[0].rates, self.mix @ run[0].read
            starts = np.array([segment.start for segment in run])
            seen = np.abs(starts @ (read @ exponentials(rates, np.linspace(0.0, 1.0, _LOOKS))).T).max(axis=1)
            grows = np.exp(max(0.0, float(np.linalg.eigvalsh(0.5 * (rates + rates.T)).max())))
            between = np.linalg.norm(read @ rates) * np.linalg.norm(starts, axis=1) * grows
            found.append(seen + between * 0.5 / (_LOOKS - 1))
        return np.concatenate(found)

    def pushed(self, times: FloatArray) -> FloatArray:
        """The same between nodes (n,), shape (n - 1,)."""
        first = np.searchsorted(self.joints, times[:-1] * (1.0 + 1e-12), side="right") - 1
        last = np.searchsorted(self.joints, times[1:] * (1.0 - 1e-12), side="left")
        last = np.maximum(np.minimum(last, len(self.pushes)), first + 1)
        ends = np.column_stack([first, last]).ravel()
        return np.asarray(np.maximum.reduceat(np.append(self.pushes, 0.0), ends)[::2])

    def nodes(self, room: float) -> FloatArray:
        """First nodes: all blows, all joints where they are few, and so many that little bulges between them."""
        end, load = float(self.joints[-1]), float(self.pushes.max(initial=0.0))
        count = end * np.sqrt(2.0 * load / (8.0 * _BULGE * room)) if room > 0.0 else _FEW
        even = np.linspace(0.0, end, int(np.clip(count, _FEW, _MOST // 2)) + 1)
        own = self.joints if len(self.joints) <= _JOINTS else self.joints[:-1][self.struck]
        return _apart(np.concatenate([even, own, [end]]))


def least_peak(path: Path, room: float, close: float = CLOSE) -> Between | None:
    """Least peak of |u| [m/s^2] for a room [m]; None where the program is not solved."""
    return _between(path, path.nodes(room), room, None, close)


def least_room(path: Path, peak: float, close: float = CLOSE) -> Between | None:
    """Least room [m] for a peak of |u| [m/s^2]; None where the program is not solved."""
    if not path.struck.any() and peak >= float(path.pushes.max(initial=0.0)):
        return Between(0.0, 0.0)  # held fast
    return _between(path, path.nodes(0.0), None, peak, close)


def _between(path: Path, times: FloatArray, room: float | None, peak: float | None, close: float) -> Between | None:
    best: Between | None = None
    most = float(path.pushes.max(initial=0.0)) if room is not None else 0.0
    for _ in range(_ROUNDS):
        found = _Program(path, times, room, peak).solved()
        if found is None and best is None and len(times) < _MOST:  # bulges that fill the room leave nothing
            times = _apart(np.concatenate([times, 0.5 * (times[1:] + times[:-1])]))
            continue
        if found is None:
            break
        high, atoms = found
        low = max(atoms.bound(room, peak), 0.0)
        best = Between(max(low, best.low), min(high, best.high)) if best is not None else Between(low, high)
        if best.high - best.low <= close * best.high or best.high <= _NONE * most or len(times) > _MOST:
            break
        times = _apart(np.concatenate([atoms.finer(times), path.nodes(room if room is not None else best.high)]))
    if best is None:
        return None
    return (
        Between(min(best.low, best.high), best.high * (1.0 + _SURE)) if best.high > _NONE * most else Between(0.0, 0.0)
    )


@dataclass(frozen=True)
class _Atoms:
    """Numbers at times that rise, and the path there: any of them are a proof of how little is possible."""

    times: FloatArray
    sizes: FloatArray
    path: FloatArray

    def bound(self, room: float | None, peak: float | None) -> float:
        """What the peak cannot fall below in a room, or the room for a peak."""
        whole, total = self._integral, float(np.abs(self.sizes).sum())
        along = float(self.sizes @ self.path)
        top, under = (along - room * total, whole) if room is not None else (along - (peak or 0.0) * whole, total)
        return top / under if under > 0.0 else 0.0

    @cached_property
    def weights(self) -> FloatArray:
        """K at the times; straight between them, and zero behind the last."""
        behind = np.cumsum(self.sizes[::-1])[::-1]
        return np.append(np.cumsum((np.diff(self.times) * behind[1:])[::-1])[::-1], 0.0)

    @cached_property
    def _integral(self) -> float:
        """Of |K| from zero on."""
        first, last = self.weights[:-1], self.weights[1:]
        both = np.abs(first) + np.abs(last)
        squares = np.divide(first**2 + last**2, both, out=np.zeros(len(both)), where=both > 0.0)
        return float(np.diff(self.times) @ (0.5 * np.where(first * last >= 0.0, both, squares)))

    def finer(self, times: FloatArray) -> FloatArray:
        """Nodes with three more in each cell beside a touch and where K changes its sign."""
        sizes = np.interp(times, self.times, self.sizes)
        hot = np.abs(sizes) > _TOUCHES * np.abs(sizes).max()
        weights = np.interp(times, self.times, self.weights)
        cells = np.flatnonzero(hot[:-1] | hot[1:] | (weights[:-1] * weights[1:] < 0.0))
        widths = times[cells + 1] - times[cells]
        return _apart(np.concatenate([times, *(times[cells] + part * widths for part in (0.25, 0.5, 0.75))]))


class _Program:
    """The cone program on given nodes: x and x' at each, u between them, the peak, the room, two speeds to stop from.

    Lengths are counted in `long`, accelerations in `fast`, and times so that both fit.
    """

    def __init__(self, path: Path, times: FloatArray, room: float | None, peak: float | None) -> None:
        self.times, self.given = times, (room, peak)
        self.y, self.v = path.at(times)
        load = path.pushed(times)
        speed = float(np.abs(self.v).max())
        most = float(load.max(initial=0.0)) or speed**2 / (2.0 * (room or 1.0))
        self.fast = (peak if peak is not None else most) or 1.0
        self.long = (room if room is not None else min(float(np.abs(self.y).max()), speed**2 / self.fast)) or 1.0
        self.clock = float(np.sqrt(self.long / self.fast))
        self.steps, self.load = np.diff(times) / self.clock, load / self.fast
        self.rows: list[tuple[IntArray, IntArray, FloatArray]] = []
        self.right: list[FloatArray] = []

    def solved(self) -> tuple[float, _Atoms] | None:
        """The least that was found [SI], and its multipliers."""
        n, cells = len(self.times), len(self.steps)
        x, v, u = np.arange(n), n + np.arange(n), 2 * n + np.arange(cells)
        peak, room, up, down = (2 * n + cells + k for k in range(4))
        self._motion(x, v, u)
        given, unit = (self.given[0], self.long) if self.given[0] is not None else (self.given[1], self.fast)
        self._add([((room if self.given[0] is not None else peak), 1.0)], np.array([(given or 0.0) / unit]))
        equal = self.height
        for sign in (1.0, -1.0):
            self._add([(u, sign), (peak, -1.0)], np.zeros(cells))
        bulge, pushed = self._bulges()
        touches = [self.height, self.height + n - 1]
        for sign in (1.0, -1.0):
            self._add([(x[1:], sign), (room, -1.0), (peak, bulge)], -pushed)
        speeds = self.height
        for sign, stop in ((1.0, up), (-1.0, down)):
            self._add([(v[-1:], sign), (stop, -1.0)], np.zeros(1))
            self._add([(stop, -1.0)], np.zeros(1))
        linear, cones = self.height - equal, self.height
        for sign, stop in ((1.0, up), (-1.0, down)):  # stop^2 <= 2 peak (room - sign x)
            self._add([(peak, -1.0), (room, -1.0), (x[-1:], sign)], np.zeros(1))
            self._add([(peak, -1.0), (room, 1.0), (x[-1:], -sign)], np.zeros(1))
            self._add([(stop, -np.sqrt(2.0))], np.zeros(1))
        cost = np.zeros(down + 1)
        cost[peak if self.given[0] is not None else room] = 1.0
        kinds = [(EQUAL, equal), (LINEAR, linear), (CONE, 3), (CONE, 3)]
        cone_point = solve_cones(cost, self._table(down + 1), np.concatenate(self.right), kinds, tolerance=_TOLERANCE)
        if not cone_point.is_finite or cone_point.status not in ("Solved", "AlmostSolved"):
            return None
        z = cone_point.z
        sizes = np.append(0.0, z[touches[1] : touches[1] + n - 1] - z[touches[0] : touches[0] + n - 1])
        times, path = self.times, self.y
        for sign, row, at in ((1.0, cones, speeds), (-1.0, cones + 3, speeds + 2)):
            stopped = z[row] - z[row + 1]  # behind the load it is stopped where it touches the room
            if stopped > _ATOM * np.abs(z).max():
                later = z[at] / stopped * self.clock
                times, sizes = np.append(times, self.times[-1] + later), np.append(sizes, -sign * stopped)
                path = np.append(path, self.y[-1] + self.v[-1] * later)
        order = np.argsort(times, kind="stable")
        unit = self.fast if self.given[0] is not None else self.long
        return float(cone_point.x @ cost) * unit, _Atoms(times[order], sizes[order], path[order])

    def _motion(self, x: IntArray, v: IntArray, u: IntArray) -> None:
        """From node to node, and from where it begins: behind a blow the mass lags."""
        h, speed = self.steps, self.v * (self.clock / self.long)
        gone = np.diff(self.y) / self.long - h * speed[:-1]
        self._add([(x[1:], 1.0), (x[:-1], -1.0), (v[:-1], -h), (u, -0.5 * h * h)], -gone)
        self._add([(v[1:], 1.0), (v[:-1], -1.0), (u, -h)], -np.diff(speed))
        self._add([(x[:1], 1.0)], np.zeros(1))
        self._add([(v[:1], 1.0)], -speed[:1])

    def _bulges(self) -> tuple[FloatArray, FloatArray]:
        """By how much x may bulge beside each node but the first, for a peak of one, and by the load."""
        own, loaded = self.steps**2 / 8.0, self.steps**2 / 8.0 * self.load
        return np.maximum(own, np.append(own[1:], 0.0)), np.maximum(loaded, np.append(loaded[1:], 0.0))

    @property
    def height(self) -> int:
        return sum(len(one) for one in self.right)

    def _add(self, terms: list[tuple[IntArray | int, FloatArray | float]], right: FloatArray) -> None:
        """Rows, one for each of `right`: sums of columns times factors."""
        rows = self.height + np.arange(len(right))
        for columns, factors in terms:
            placed = np.broadcast_to(columns, rows.shape), np.broadcast_to(factors, rows.shape)
            self.rows.append((rows, *placed))
        self.right.append(right)

    def _table(self, width: int) -> SimpleNamespace:
        rows, columns, factors = (np.concatenate(one) for one in zip(*self.rows, strict=True))
        places, which = np.unique(columns * self.height + rows, return_inverse=True)
        starts = np.searchsorted(places, self.height * np.arange(width + 1))
        summed = np.asarray(np.bincount(which, factors), dtype=float)
        return by_columns(summed, places % self.height, starts, (self.height, width))


def _apart(times: FloatArray) -> FloatArray:
    """Times that rise, without those that are one but for rounding."""
    found = np.unique(times)
    return np.asarray(found[np.append(True, np.diff(found) > 1e-12 * found[-1])])
