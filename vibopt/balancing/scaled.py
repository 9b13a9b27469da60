"""A question divided by its own sizes, so that the solver sees numbers of order one; and its bound by weak duality.

For multipliers z of the goal rows and v of the limit rows (complex, one per row),

    goal(x) >= Re z*(G x + g) - conjugate(z) + Re v*(F x + f) - sum |v|      for every x that keeps the limits,

and the right side is least over discs, arcs and the total mass in closed form (a fractional knapsack).  Whatever the
solver answered, this number is a bound; a wrong multiplier makes it weak, never wrong.
(Boyd and Vandenberghe, Convex Optimization, 2004, chapter 5)
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from math import sqrt

import numpy as np

from vibopt.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from vibopt.balancing.fan import Fan
from vibopt.balancing.question import Goal, Question, combined, greatest, held_by, together
from vibopt.records import cached_property, dataclass, replace


@dataclass(frozen=True)
class Scaled:
    """Rows and columns of order one; x = u / column.

    G, g
        Goal rows importance * (H u + y0) / size, shape (n, n_planes) and (n,); for "rms" compressed by QR to at most
        n_planes + 1 rows with the same norms.
    F, f
        Limit rows (H u + y0) / limit; |F x + f| <= 1.  `limited` are their places among the readings.
    caps, mass, total
        |x| <= caps; sum of mass * |x| <= total.
    goal_size
        What a scaled goal of one is in the asker's unit.
    wedges
        Per plane (middle, half width <= pi/2) of the allowed arc of x, None: every angle.
    fans
        By plane the holes of a weight cut in two; caps and masses are of both parts.
    sums, goal_sums
        Numbers of limit rows (of goal rows, only for "worst") whose moduli are added up, as those of a question.
    """

    G: ComplexArray
    g: ComplexArray
    F: ComplexArray
    f: ComplexArray
    limited: IntArray
    caps: FloatArray
    mass: FloatArray
    total: float
    goal: Goal
    huber: float
    divisor: float
    goal_size: float
    mass_size: float
    column: FloatArray
    wedges: tuple[tuple[float, float] | None, ...]
    fans: Mapping[int, Fan] = field(default_factory=dict)
    sums: IntArray = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    goal_sums: IntArray = field(default_factory=lambda: np.empty(0, dtype=np.int64))

    @property
    def n_planes(self) -> int:
        return int(self.G.shape[1])

    @cached_property
    def is_discs(self) -> bool:
        """Whether least squares or the worst residual are asked for within discs alone, none of which is tight."""
        other = self.fans or any(self.wedges) or len(self.sums) or len(self.goal_sums) or np.isfinite(self.total)
        return not other and self.goal in ("rms", "worst") and not (self.tightness > 1.0).any()

    @cached_property
    def reach(self) -> FloatArray:
        """Greatest |x| that cap and total leave to each plane, shape (n_planes,)."""
        if not np.isfinite(self.total):
            return self.caps
        with np.errstate(divide="ignore"):
            return np.minimum(self.caps, self.total / self.mass)

    @cached_property
    def tightness(self) -> FloatArray:
        """What limit rows are divided by before a solver sees them, (n_limits,): those far below what is read."""
        if not len(self.f):
            return np.ones(0)
        sizes = np.maximum(np.abs(self.f), np.abs(self.F).max(axis=1, initial=0.0))
        return _tightness(greatest(sizes, self.sums))

    @cached_property
    def shared(self) -> BoolArray:
        """Limit rows to which others are added (n_limits,)."""
        return np.asarray(together(np.ones(len(self.f)), self.sums) > 1.0)

    @cached_property
    def exact(self) -> Exact | None:
        """x that keep the limits that are next to nothing, as equations; None where there are none, or no such x."""
        rows = (self.tightness > EXACT).nonzero()[0]
        if not len(rows):
            return None
        A, c = self.F[rows] / self.tightness[rows, None], self.f[rows] / self.tightness[rows]
        left, sizes, right = np.linalg.svd(A)
        rank = int(np.count_nonzero(sizes > 1e-12 * sizes[0]))
        inverse = right[:rank].conj().T @ (left[:, :rank].conj().T / sizes[:rank, None])
        base = -inverse @ c
        if (np.abs(A @ base + c) * self.tightness[rows] > 0.5).any():
            return None
        return Exact(rows, base, right[rank:].conj().T, inverse / self.tightness[rows])

    def sizes(self, x: ComplexArray) -> FloatArray:
        """What is fitted in each plane, (n_planes,): |x|, or both parts of a weight cut in two."""
        sizes: FloatArray = np.abs(x)
        for plane, fan in self.fans.items():
            sizes[plane] = float(fan.gauge(complex(x[plane])))
        return sizes

    def value(self, x: ComplexArray) -> float:
        """The scaled goal at x."""
        if self.goal == "correction":
            return float(self.mass @ self.sizes(x))
        return float(self.measure(np.abs(self.G @ x + self.g)))

    def measure(self, t: FloatArray) -> FloatArray:
        """The scaled goal of moduli (..., n_rows), (n_rows,) where some are added up; not for "correction"."""
        return combined(self.goal, together(t, self.goal_sums), self.huber, self.divisor**2)

    def held(self, x: ComplexArray) -> FloatArray:
        """Each limit row as a part of its limit, with those that are added to it (n_limits,)."""
        return together(np.abs(self.F @ x + self.f), self.sums)


EXACT = 1e8
"""A limit so far below what is read is met as an equation."""
_TIGHT = 100.0
_ROUNDING = 1e-9


def _tightness(sizes: FloatArray) -> FloatArray:
    return np.where(sizes > _TIGHT, sizes, 1.0)


@dataclass(frozen=True)
class Exact:
    """All x with F[rows] x + f[rows] = 0: x = base + free y.

    rows
        Places among the limits.
    base, free
        Shape (n_planes,) and (n_planes, n_planes - rank).
    inverse
        Pseudo-inverse of F[rows], shape (n_planes, n_rows).
    """

    rows: IntArray
    base: ComplexArray
    free: ComplexArray
    inverse: ComplexArray


def scaled(question: Question, *, merge: bool = True) -> Scaled:
    """Divide a question (without pairs) by its sizes; limits of zero become 1e-12 of the readings.

    Shares are counted from their lower ends: numbers that are not negative, of which nothing is weighed.  Without
    `merge` rows of least squares stay as they are, which is sooner where they are looked at a few times.
    """
    shares = {plane: ends[1] - ends[0] for plane, ends in enumerate(question.ends) if ends is not None}
    if shares:
        caps = np.array([shares.get(plane, cap) for plane, cap in enumerate(question.caps)])
        question = replace(question, y0=question.residual(question.base), caps=caps, ends=())
    weights = np.zeros(question.n_readings) if question.goal == "correction" else question.importance
    found, felt = np.abs(question.y0), np.abs(question.H)
    as_found = float(found.max(initial=0.0))
    limited = (question.limits < np.inf).nonzero()[0]
    F, f, seen, far = question.H[:0], question.y0[:0], np.zeros(question.n_planes), question.caps
    if len(limited):
        limits = np.maximum(question.limits[limited], 1e-12 * (as_found or float(felt.max(initial=0.0))) or 1e-300)
        F, f = question.H[limited] / limits[:, None], question.y0[limited] / limits
        seen = (np.abs(F) / _tightness(as_found / limits)[:, None]).max(axis=0)
        far = np.minimum(np.where(seen > 0.0, 1.0 / np.maximum(seen, 1e-300), np.inf), far)
    size = float((weights * found).max(initial=0.0))
    most = (weights[:, None] * felt).max(axis=0, initial=0.0)
    room = float((most * np.where(far < np.inf, far, 0.0)).max(initial=0.0))
    size = (size if size > _ROUNDING * room else room) or 1.0  # what weights may do, where as found it is nothing
    parts = weights / size
    G, g = question.H * parts[:, None], question.y0 * parts
    goal_sums = question.sums if question.goal == "worst" and question.adds_up else question.sums[:0]
    if question.goal in ("worst", "sum") and not weights.all():  # rows of limits alone are no rows of these goals
        G, g, goal_sums = G[weights > 0.0], g[weights > 0.0], goal_sums[weights[: len(goal_sums)] > 0.0]
    if len(np.unique(goal_sums)) == len(goal_sums):  # of limits alone
        goal_sums = goal_sums[:0]
    most = np.maximum(most / size, seen)
    column = 1.0 / np.where(most > 0, most, 1.0)
    if merge and question.goal == "rms" and len(g) > question.n_planes + 1:
        rows, constants = question.triangle[:, :-1] * (column / size), question.triangle[:, -1] / size
    else:
        rows, constants = G * column, g
    mass = question.densities * column
    mass_size = float(mass.max(initial=0.0)) or 1.0
    cut = [(plane, fan) for plane, fan in enumerate(question.fans) if fan is not None]
    fans = {plane: replace(fan, each=fan.each / column[plane]) for plane, fan in cut}
    caps = question.caps / column
    for plane, fan in fans.items():
        caps[plane] = min(caps[plane], fan.most)
    goal_size = {"correction": mass_size, "huber": size * size}.get(question.goal, size)
    return Scaled(
        G=rows, g=constants, F=F * column, f=f, limited=limited, caps=caps, mass=mass / mass_size,
        total=question.total_cap / mass_size, goal=question.goal, huber=question.huber / size,
        divisor=float(np.sqrt(question.n_readings)), goal_size=goal_size, mass_size=mass_size, column=column,
        wedges=tuple(
            fans[k].wedge if k in fans else (0.0, 0.0) if k in shares else None for k in range(question.n_planes)
        ),
        fans=fans, sums=question.sums[limited] if len(question.sums) else question.sums, goal_sums=goal_sums,
    )  # fmt: skip


def into_wedge(value: complex, middle: float, half: float) -> complex:
    """Nearest point of the arc of directions middle ± half (half <= pi/2) to `value`."""
    off = (np.angle(value) - middle + np.pi) % (2.0 * np.pi) - np.pi
    if abs(off) <= half:
        return value
    edge = np.exp(1j * (middle + np.copysign(half, off)))
    return complex(edge * max((value * edge.conjugate()).real, 0.0))


_HALVINGS = 60
_OPEN = 10.0  # times the answer beyond which a cap holds nothing back, and rounding of the slope times it is much
FAR = 1e3  # a plane without a cap is searched this many times beyond the answer; convexity carries the rest


@dataclass(frozen=True)
class Dual:
    """Bound of the scaled goal with the multipliers behind it.

    z, v
        Multipliers of the goal rows and of the limit rows.
    caps, total
        What a cap of one more would save, per plane and for the total (scaled).
    """

    bound: float
    z: ComplexArray
    v: ComplexArray
    caps: FloatArray
    total: float


def weak_duality(scene: Scaled, z: ComplexArray, v: ComplexArray, reach: float) -> Dual:
    """The bound of the multipliers z, v; `reach` is the size of the answer |x| (for planes without a cap)."""
    z, v = _stationary(scene, z, v, scene.reach > _OPEN * reach)
    if (shrink := _shrink(scene, z)) < 1.0:
        z, v = z * shrink, v * shrink
    constant, pull = float((z.conj() @ scene.g).real), scene.G.conj().T @ z
    if len(v):
        constant += float((v.conj() @ scene.f).real) - held_by(np.abs(v), scene.sums)
        pull = pull + scene.F.conj().T @ v
    if scene.goal == "huber":
        constant -= 0.25 * float((np.abs(z) ** 2).sum())
    gains, ends, capped = gain(scene, pull), scene.reach < np.inf, scene.caps < np.inf
    if scene.goal == "correction":
        fair = _fair(scene.mass, gains, ~(ends | capped))
        constant, gains, z, v = fair * constant, np.maximum(fair * gains - scene.mass, 0.0), fair * z, fair * v
    # twice what the total leaves: the total binds, not the cap that follows from it
    caps = np.where(capped, scene.caps, np.where(ends, 2.0 * scene.reach, FAR * (1.0 + reach)))
    lost, slope = _won(scene, pull, gains, caps)
    prices = np.maximum(gains - slope * scene.mass, 0.0)
    return Dual(constant - lost, z, v, np.where(capped, prices, 0.0), slope)


def _fair(mass: FloatArray, gains: FloatArray, endless: BoolArray) -> float:
    """By which the multipliers of a least correction become those of the best bound along their ray.

    So large that a weight just wins its mass in some plane; where it may be `endless`, it must not win more.
    """
    parts = np.divide(mass, gains, out=np.full(len(mass), np.inf), where=gains > 0.0)
    least = float(parts.min(initial=np.inf))
    return least if 1.0 < least < np.inf else float(parts[endless].min(initial=1.0))


def gain(scene: Scaled, slope: ComplexArray) -> FloatArray:
    """Greatest fall of Re(slope* x) per |x| that the allowed arc permits, zero at least, per plane."""
    full = np.abs(slope)
    for plane, wedge in enumerate(scene.wedges):
        if wedge is not None:
            middle, half = wedge
            off = abs((np.angle(-slope[plane]) - middle + np.pi) % (2.0 * np.pi) - np.pi)
            full[plane] *= max(np.cos(max(off - half, 0.0)), 0.0)
    for plane, fan in scene.fans.items():
        full[plane] = _pulls(fan, slope[plane]).max(initial=0.0)
    return full


def _pulls(fan: Fan, slope: complex) -> FloatArray:
    """Fall of Re(slope* x) per part at each hole (n_holes,)."""
    return np.asarray(-(np.conj(slope) * fan.holes).real)


def _won(scene: Scaled, slope: ComplexArray, gains: FloatArray, caps: FloatArray) -> tuple[float, float]:
    """Greatest fall of Re(slope* x) within caps, holes and total, and what one more of the total would add.

    Where holes take only so much each the total has a price: at any price this is a bound, and the best one is taken.
    """
    drilled = {plane: fan for plane, fan in scene.fans.items() if np.isfinite(fan.each)}
    if not drilled:
        return knapsack(gains, caps, scene.mass, scene.total)
    own = scene.mass if scene.goal == "correction" else np.zeros(scene.n_planes)
    pulls = {plane: _pulls(fan, slope[plane]) - own[plane] for plane, fan in drilled.items()}
    plain = np.array([plane for plane in range(scene.n_planes) if plane not in drilled], dtype=int)

    def at(price: float) -> float:
        won = float(np.maximum(gains[plain] - price * scene.mass[plain], 0.0) @ caps[plain])
        won += sum(fan.won(pulls[k] - price * scene.mass[k], float(caps[k])) for k, fan in drilled.items())
        return won + price * scene.total if price else won

    if not np.isfinite(scene.total) or float(scene.mass @ caps) <= scene.total:
        return at(0.0), 0.0
    heavy = [k for k in drilled if scene.mass[k] > 0.0]
    usual = plain[scene.mass[plain] > 0.0]
    rates = [np.zeros(1), gains[usual] / scene.mass[usual], *(pulls[k] / scene.mass[k] for k in heavy)]
    prices = np.unique(np.maximum(np.concatenate(rates), 0.0)).tolist()
    best = min(range(len(prices)), key=lambda place: at(prices[place]))
    low, high = prices[max(best - 1, 0)], prices[min(best + 1, len(prices) - 1)]
    for _ in range(_HALVINGS if high > low else 0):
        first, second = low + (high - low) / 3.0, high - (high - low) / 3.0
        low, high = (low, second) if at(first) < at(second) else (first, high)
    price = min((prices[best], low, high), key=at)
    return at(price), price


def knapsack(gains: FloatArray, caps: FloatArray, mass: FloatArray, total: float) -> tuple[float, float]:
    """Greatest sum of gains * r for 0 <= r <= caps and mass @ r <= total, and what one more of total would add."""
    if not np.isfinite(total) or float(mass @ np.where(gains > 0, caps, 0.0)) <= total:
        return float(gains @ caps), 0.0
    left, won = total, 0.0
    for plane in np.argsort(-gains / np.maximum(mass, 1e-300)):
        room = caps[plane] * mass[plane]
        if room >= left:
            rate = gains[plane] / mass[plane]
            return float(won + rate * left), float(rate)
        won += gains[plane] * caps[plane]
        left -= room
    return float(won), 0.0


def _stationary(
    scene: Scaled, z: ComplexArray, v: ComplexArray, held_by_none: BoolArray
) -> tuple[ComplexArray, ComplexArray]:
    """The nearest multipliers along whose slope planes far from a cap gain nothing (only rows in use are moved)."""
    open_planes = held_by_none.nonzero()[0]
    if not len(open_planes) or scene.goal == "correction":
        return z, v
    used = np.concatenate([np.abs(z), np.abs(v)])
    used = np.where(used > 1e-9 * used.max(initial=0.0), used, 0.0)
    both = np.concatenate([z, v])
    rows = np.vstack([scene.G, scene.F])[:, open_planes]
    root = np.sqrt(used)
    for _ in range(2):
        slope = rows.conj().T @ both
        for k, plane in enumerate(open_planes):
            wedge = scene.wedges[plane]
            slope[k] = -into_wedge(-slope[k], *wedge) if wedge is not None else slope[k]
        both = both - root * np.linalg.lstsq((root[:, None] * rows).conj().T, slope, rcond=None)[0]
    return both[: len(z)], both[len(z) :]


def _shrink(scene: Scaled, z: ComplexArray) -> float:
    """Factor <= 1 that brings z into the domain of the goal's conjugate; for "correction" there is nothing to bring."""
    if scene.goal == "rms":
        reached = sqrt(np.vdot(z, z).real) * scene.divisor
    elif scene.goal == "worst":
        reached = held_by(np.abs(z), scene.goal_sums)
    elif scene.goal == "sum":
        reached = float(np.abs(z).max(initial=0.0))
    elif scene.goal == "huber":
        reached = float(np.abs(z).max(initial=0.0)) / (2.0 * scene.huber)
    else:
        reached = 0.0
    return 1.0 / max(reached, 1.0)
