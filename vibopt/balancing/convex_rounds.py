"""One convex program solved to a checked gap: only the rows that matter are shown to the solver, as cones."""

from __future__ import annotations

from math import sqrt

import numpy as np

from vibopt.arrays import BoolArray, ComplexArray, FloatArray, IntArray, inverted, solved
from vibopt.balancing.interior import least_within
from vibopt.balancing.question import held_by, together
from vibopt.balancing.scaled import EXACT, Dual, Scaled, into_wedge, weak_duality
from vibopt.cones import Cones, over_parts
from vibopt.records import dataclass, replace
from vibopt.work import worked

Rows = IntArray
INSIDE = 20.0  # limits are drawn in by so many tolerances (2e-9 at most), the solver's own slack stays inside them


@dataclass(frozen=True)
class ConeAnswer:
    """x (n_planes,), multipliers z of the goal rows and v of the limit rows (full length, zero where not used)."""

    x: ComplexArray
    z: ComplexArray
    v: ComplexArray
    status: str


def solve_cone(scene: Scaled, goal_rows: Rows, limit_rows: Rows, tolerance: float = 1e-11) -> ConeAnswer:
    """Solve with only these goal rows ("worst") and limit rows; all other goals take every goal row."""
    exact, cones, heads, n = scene.exact, Cones(scene.n_planes), 0, scene.n_planes
    if len(scene.goal_sums):
        heads = _added(cones, scene.G[goal_rows], scene.g[goal_rows], scene.goal_sums[goal_rows])
    elif scene.goal != "correction":
        rows = round(scene.divisor**2)
        heads = cones.least(scene.goal, scene.G[goal_rows], scene.g[goal_rows], scene.huber, rows)
    shown = limit_rows if exact is None else np.setdiff1d(limit_rows, exact.rows)
    inside = min(INSIDE * tolerance, 2e-9)
    apart = _apart(scene, shown) if len(shown) else ()
    firsts = [(some, _limits(scene, cones, some, inside)) for some in apart if len(some)]
    _amounts(scene, cones, 0.0 if exact is None else inside)
    _arcs(scene, cones)
    worked(0.5 + 0.007 * (len(goal_rows) + len(shown)) * scene.n_planes)
    along = None
    if exact is not None:  # x = base + free y in real and imaginary parts
        base, N = exact.base, exact.free
        along = np.concatenate([base.real, base.imag]), np.concatenate(over_parts(N))
    cone_point = cones.solve(tolerance=tolerance, along=along)
    z = np.zeros(len(scene.g), dtype=complex)
    z[goal_rows] = _multipliers(cone_point.z, heads, len(goal_rows), whole=scene.goal == "rms")
    v = np.zeros(len(scene.f), dtype=complex)
    for some, first in firsts:
        v[some] = _multipliers(cone_point.z, first, len(some), whole=False) / scene.tightness[some]
    if exact is not None:
        pulled = cones.pulled(cone_point.z) if len(cone_point.z) else np.zeros(2 * n)
        v[exact.rows] = -exact.inverse.conj().T @ (pulled[:n] + 1j * pulled[n : 2 * n])
    return ConeAnswer(cone_point.x[:n] + 1j * cone_point.x[n : 2 * n], z, v, cone_point.status)


def _by_squares(scene: Scaled, goal_rows: Rows, limit_rows: Rows) -> ConeAnswer | None:
    """The same without a cone program; None where more than discs is asked about, or where that does not settle."""
    if not scene.is_discs or len(goal_rows) + len(limit_rows) < MANY or len(goal_rows) <= scene.n_planes:
        return None
    worked(0.5 + 0.0007 * (len(goal_rows) + len(limit_rows)) * scene.n_planes)
    G, g, worst = scene.G[goal_rows], scene.g[goal_rows], scene.goal == "worst"
    try:
        found = least_within(G, g, scene.F[limit_rows], scene.f[limit_rows], scene.caps, worst=worst)
    except np.linalg.LinAlgError:
        return None
    if found is None:
        return None
    left = np.abs(G @ found[0] + g)
    size = float(left.max()) if worst else float(np.linalg.norm(left)) * scene.divisor
    z, v = np.zeros(len(scene.g), dtype=complex), np.zeros(len(scene.f), dtype=complex)
    z[goal_rows], v[limit_rows] = found[1] / size, found[2] / size
    return ConeAnswer(found[0], z, v, "Solved")


def _apart(scene: Scaled, rows: Rows) -> tuple[Rows, Rows]:
    """Limit rows that are held by themselves, and those that are added up."""
    many = scene.shared[rows]
    return rows[~many], rows[many]


def _limits(scene: Scaled, cones: Cones, rows: Rows, inside: float) -> int:
    """Limit rows, drawn in by a part `inside`; the place of the first."""
    tight = scene.tightness[rows]
    bounds = np.maximum(1.0 / tight - inside, 0.5 / tight)
    slope, constant = scene.F[rows] / tight[:, None], scene.f[rows] / tight
    if not scene.shared[rows].any():
        return cones.moduli(slope, constant, bounds)
    return _added(cones, slope, constant, scene.sums[rows], bounds)


def _added(
    cones: Cones, slope: ComplexArray, constant: ComplexArray, sums: IntArray, bounds: FloatArray | None = None
) -> int:
    """Moduli of one number in `sums` together below their bound, or the greatest as the cost; the first row's place."""
    slots = cones.helpers(len(sums))
    start = cones.moduli(slope, constant, 0.0, (slots,))
    _, first, own = np.unique(sums, return_index=True, return_inverse=True)
    table, most = np.equal.outer(np.arange(len(first)), own).astype(float), np.zeros(len(first))
    if bounds is None:
        slots, table = np.append(slots, cones.helpers(1, 1.0)), np.column_stack([table, most - 1.0])
    else:
        most = bounds[first]
    at, which = np.nonzero(table)
    cones.linear(np.zeros((len(first), cones.n)), most, (at, slots[which], table[at, which]))
    return start


def _multipliers(dual: FloatArray, first: int, count: int, whole: bool) -> ComplexArray:
    """Complex multipliers (the solver's with its sign turned) of `count` rows whose cones start at row `first`."""
    if whole:
        block = dual[first + 1 : first + 1 + 2 * count]
        return -(block[:count] + 1j * block[count:])
    triples = dual[first : first + 3 * count].reshape(-1, 3)
    return -(triples[:, 1] + 1j * triples[:, 2])


def _amounts(scene: Scaled, cones: Cones, inside: float) -> None:
    """Caps, total and mass, drawn in by a part `inside`; where mass is counted each plane has its size as a helper."""
    caps, total = scene.caps * (1.0 - inside), scene.total * (1.0 - inside)
    planes = (scene.caps < np.inf).nonzero()[0]
    unit, nothing = np.eye(scene.n_planes, dtype=complex), np.zeros(scene.n_planes, dtype=complex)
    whole = [plane for plane in range(scene.n_planes) if plane not in scene.fans]
    if scene.goal != "correction" and not np.isfinite(scene.total):
        held = [plane for plane in whole if caps[plane] < np.inf]
        if held:
            cones.moduli(unit[held], nothing[held], caps[held])
        for plane, fan in scene.fans.items():
            if np.isfinite(caps[plane]):
                cones.linear(_along_normals(scene, plane, fan.sides), np.full(len(fan.sides), caps[plane]))
        return
    slots = cones.helpers(scene.n_planes, scene.mass if scene.goal == "correction" else 0.0)
    cones.moduli(unit[whole], nothing[whole], 0.0, (slots[whole],))
    for plane, fan in scene.fans.items():
        count = len(fan.sides)
        entries = (np.arange(count), np.full(count, slots[plane]), np.full(count, -1.0))
        cones.linear(_along_normals(scene, plane, fan.sides), np.zeros(count), entries)
    if len(planes):
        flat = np.zeros((len(planes), cones.n))
        cones.linear(flat, caps[planes], (np.arange(len(planes)), slots[planes], np.ones(len(planes))))
    if np.isfinite(scene.total):
        place = np.zeros(scene.n_planes, dtype=int)
        cones.linear(np.zeros((1, cones.n)), np.array([total]), (place, slots, scene.mass))


def _along_normals(scene: Scaled, plane: int, normals: ComplexArray) -> FloatArray:
    """Rows Re n* x of one plane over real and imaginary parts (n_normals, 2 n_planes)."""
    dense = np.zeros((len(normals), 2 * scene.n_planes))
    dense[:, plane], dense[:, scene.n_planes + plane] = normals.real, normals.imag
    return dense


def _arcs(scene: Scaled, cones: Cones) -> None:
    """Allowed arcs of half a turn at most: two half planes each; and what one hole bears."""
    for plane, fan in scene.fans.items():
        if len(fan.faces) and np.isfinite(fan.each):
            cones.linear(_along_normals(scene, plane, fan.faces), np.full(len(fan.faces), fan.each))
    for plane, wedge in enumerate(scene.wedges):
        if wedge is None:
            continue
        middle, half = wedge
        edges = np.array([middle - half - 0.5 * np.pi, middle + half + 0.5 * np.pi])
        normals = np.cos(edges) + 1j * np.sin(edges)  # outward
        if half < 1e-12:  # a ray: forward along it as well
            normals = np.append(normals, -np.cos(middle) - 1j * np.sin(middle))
        cones.linear(_along_normals(scene, plane, normals), np.zeros(len(normals)))


Places = IntArray

KEPT = 1e-9  # a limit is kept when it is exceeded by no more than this share
MANY_PLANES = 20
FEW, FEW_DISCS = 30, 100  # up to so many rows all of them are shown at once
MANY = 16  # rows from which on each of them makes a cone program slower than steps in whole arrays
ROUNDS = 40
TOLERANCES = (1e-10, 1e-11, 1e-8)
CLOSE = 1e-8
SURE = 1e-10
TANGENT = 1e-7  # part of a cap from which on a step along tangents is the last: its square is rounding
PULLS, SLACK, ALIKE = 12, 1e-6, 1e-3
TRACE, ROUNDING = 1e-3, 1e-13
"""Part of a least correction that may be a trace, and part of a limit by which rounding may pass it."""
STEPS = 15


@dataclass(frozen=True)
class Convex:
    """Answer of one convex program in scaled variables.

    x
        None where no correction keeps the limits (then `factor` > 1 is proven) or none was found.
    factor
        With caps as they are every limit would have to be at least this many times as wide; 0 where not asked, nan
        where unknown.
    impossible
        The solver says that no correction keeps the limits (its word only; `factor` is the proof).
    """

    x: ComplexArray | None
    value: float
    bound: float
    dual: Dual | None
    factor: float = 0.0
    rounds: int = 0
    impossible: bool = False

    @property
    def gap(self) -> float:
        """Scaled gap, relative to the value or to 1e-3 where that is about zero."""
        return (self.value - self.bound) / max(abs(self.value), 1e-3) if self.x is not None else np.inf


def solve_convex(scene: Scaled) -> Convex:
    """Least goal over discs, arcs, total and limits; the bound is our own."""
    if not scene.n_planes:
        return _nothing_to_choose(scene)
    found = _least_squares(scene) or _patient(scene)
    if found.x is not None:
        return found
    ratio, least = _least_factor(scene)
    if least > 1.0 + KEPT:
        return Convex(None, np.inf, np.inf, None, least, found.rounds)
    if ratio.x is not None and ratio.value <= 1.0 + KEPT:
        return Convex(ratio.x, scene.value(ratio.x), found.bound, found.dual, 1.0, found.rounds)
    return Convex(None, np.inf, found.bound, None, float("nan"), found.rounds)


def _least_squares(scene: Scaled) -> Convex | None:
    """Least squares within discs; None where it is another question, or not proven."""
    if scene.goal != "rms" or len(scene.f) or not scene.is_discs or len(scene.g) <= scene.n_planes:
        return None
    try:
        with np.errstate(all="ignore"):
            across = scene.G.conj().T
            x = within_discs(across @ scene.G, across @ scene.g, scene.caps)
    except np.linalg.LinAlgError:
        return None
    worked(0.5)
    if x is None or not np.isfinite(x).all():
        return None
    left = scene.G @ x + scene.g
    size = sqrt(np.vdot(left, left).real)
    dual = weak_duality(scene, left / (size * scene.divisor or 1.0), scene.f, float(np.abs(x).max()))
    found = Convex(x, size / scene.divisor, dual.bound, dual, rounds=1)
    return found if found.gap <= SURE else None


def within_discs(square: ComplexArray, slope: ComplexArray, caps: FloatArray) -> ComplexArray | None:
    """The x of least x* square x + 2 Re slope* x with |x| <= caps, by Newton's method on 1/|x| of those at their caps.

    1/|x| is nearly a straight line in the multiplier of its cap, as in the trust region step of Moré and Sorensen
    (1983); it takes two to seven, and None is returned where it does not settle.  Whoever asks proves the answer.
    """
    multipliers = np.maximum(np.abs(slope) / caps - square.diagonal().real, 0.0)  # right where planes act apart
    matrix = square.copy()
    for _ in range(STEPS):
        matrix.flat[:: len(caps) + 1] = square.diagonal() + multipliers
        inverse = inverted(matrix)
        x: ComplexArray = -inverse @ slope
        size = np.abs(x)
        off = size / caps - 1.0
        rows = ((multipliers > 0.0) | (off > 0.0)).nonzero()[0]
        if not len(rows):
            return x
        steep = (x.conj()[:, None] * inverse * x).real[rows[:, None], rows] / size[rows, None] ** 2
        more = solved(steep, off[rows])
        if float(np.abs(off[rows]).max()) <= TANGENT:
            x = x - inverse[:, rows] @ (more * x[rows])
            return np.asarray(x * np.minimum(caps / np.maximum(np.abs(x), 1e-300), 1.0))
        multipliers[rows] += more
        multipliers = np.maximum(multipliers, 0.0)
    return None


def _least_factor(scene: Scaled) -> tuple[Convex, float]:
    """The x for which all limits have to be wider by the least common factor, and a bound of this factor."""
    rows = scene.tightness > EXACT
    if not rows.any():
        ratio = _patient(_as_goal(scene, ~rows, rows))
        return ratio, ratio.bound
    tight = scene.tightness[:, None] * rows[:, None] + ~rows[:, None]
    near = _patient(_as_goal(replace(scene, F=scene.F / tight, f=scene.f / tight[:, 0]), rows, rows & ~rows))
    least = near.bound * float(tight[rows].min())
    if least > 1.0 + KEPT:
        return near, least
    ratio = _patient(_as_goal(scene, ~rows, rows))
    own = scene.sums[rows] if len(scene.sums) else scene.sums
    kept = 0.0 if ratio.dual is None else held_by(np.abs(ratio.dual.v), own)
    return ratio, (ratio.bound + kept) / (1.0 + kept)  # those that are equations become wider, too


def _as_goal(scene: Scaled, rows: BoolArray, kept: BoolArray) -> Scaled:
    """The worst of the limits `rows` as the goal, with the limits `kept`."""
    sums, goal_sums = (scene.sums[some] if len(scene.sums) else scene.sums for some in (kept, rows))
    return replace(
        scene, G=scene.F[rows], g=scene.f[rows], F=scene.F[kept], f=scene.f[kept], limited=scene.limited[kept],
        goal="worst", goal_size=1.0, sums=sums, goal_sums=goal_sums,
    )  # fmt: skip


def _patient(scene: Scaled) -> Convex:
    """The solver asked for less where it stumbles over too much; best answer and best bound of all."""
    found = _rounds(scene, TOLERANCES[0])
    for tolerance in TOLERANCES[1:]:
        if found.gap <= CLOSE or found.impossible:
            break
        again = _rounds(scene, tolerance)
        better = again if again.value < found.value else found
        surer = again if again.bound > found.bound else found
        found = replace(better, bound=surer.bound, dual=surer.dual, rounds=found.rounds + again.rounds)
    return found


def _rounds(scene: Scaled, tolerance: float) -> Convex:
    """Solve, look at the rows left out, add the violated ones, until the gap is closed or nothing is left to add."""
    goal_rows, limit_rows = first_rows(scene)
    best_x, best_value, best_bound, best_dual, impossible, count = None, np.inf, -np.inf, None, False, 0
    for count in range(1, ROUNDS + 1):  # noqa: B007 - read after the loop
        answer = _by_squares(scene, goal_rows, limit_rows) if tolerance == TOLERANCES[0] else None
        answer = answer or solve_cone(scene, goal_rows, limit_rows, tolerance)
        x = answer.x if np.isfinite(answer.x).all() else np.zeros(scene.n_planes, dtype=complex)
        x = pull_in(scene, x)
        x = _no_heavier(scene, _onto_limits(scene, x)) if len(scene.f) else x
        limits_left = scene.held(x)
        kept = limits_left.max(initial=0.0) <= 1.0 + KEPT and (scene.exact is None or _inside(scene, x))
        value = scene.value(x) if kept else np.inf
        dual = weak_duality(scene, answer.z, answer.v, float(np.abs(x).max()))
        if dual.bound > best_bound:
            best_bound, best_dual = dual.bound, dual
        if value < best_value:
            best_x, best_value = x, value
        impossible = answer.status == "PrimalInfeasible"
        if impossible or "Infeasible" in answer.status or "Numerical" in answer.status:
            break
        if best_x is not None and best_value - best_bound <= 1e-10 * max(abs(best_value), 1e-6):
            break
        more_goal, more_limits = _missing(scene, goal_rows, x), _add(limit_rows, limits_left, 1.0, scene)
        if not len(more_goal) and not len(more_limits):
            break
        goal_rows, limit_rows = np.union1d(goal_rows, more_goal), np.union1d(limit_rows, more_limits)
    return Convex(best_x, best_value, best_bound, best_dual, rounds=count, impossible=impossible)


def _onto_limits(scene: Scaled, x: ComplexArray) -> ComplexArray:
    """x moved onto the limits that it breaks by no more than the solver's own slack, by as little as that takes."""
    for _ in range(PULLS):
        left = scene.held(x)
        if not KEPT < left.max(initial=0.0) - 1.0 <= SLACK:
            break
        rows = np.flatnonzero(left > 1.0 - KEPT)
        now = scene.F[rows] @ x + scene.f[rows]
        along = (now.conj() / np.maximum(np.abs(now), 1e-300))[:, None] * scene.F[rows]
        _, first, own = np.unique(scene.sums[rows] if len(scene.sums) else rows, return_index=True, return_inverse=True)
        added = np.equal.outer(np.arange(len(first)), own) @ along
        parts = np.concatenate([added.real, -added.imag], axis=1)
        step = np.linalg.lstsq(parts, 1.0 - KEPT - left[rows[first]], rcond=ALIKE)[0]
        x = pull_in(scene, x + step[: scene.n_planes] + 1j * step[scene.n_planes :])
    return x


def _no_heavier(scene: Scaled, x: ComplexArray) -> ComplexArray:
    """A least correction without traces in planes that help nothing, and no longer along its ray than limits ask for.

    A solver ends a little inside of its limits, and of what is nearly kept as found that is much of the correction.
    """
    if scene.goal != "correction" or len(scene.sums) or scene.exact is not None:
        return x
    own = scene.mass * np.abs(x)
    bare: ComplexArray = np.where(own > TRACE * own.sum(), x, 0j)
    tried = (pull_in(scene, one * _part(scene, one)) for one in (x, bare))
    kept = [one for one in tried if scene.held(one).max(initial=0.0) <= 1.0 + ROUNDING]
    return min([x, *kept], key=scene.value)


def _part(scene: Scaled, x: ComplexArray) -> float:
    """The least part of x that keeps the limits, where any part of it keeps those that are broken as found."""
    step, rest = scene.F @ x, np.abs(scene.f) ** 2 - 1.0
    slope = (step.conj() * scene.f).real
    with np.errstate(all="ignore"):  # a row that is kept as found, or that x does not move, has no such part
        parts = rest / (np.sqrt(np.maximum(slope**2 - np.abs(step) ** 2 * rest, 0.0)) - slope)
    return float(parts[(rest > 0.0) & np.isfinite(parts)].max(initial=0.0))


def _missing(scene: Scaled, rows: Places, x: ComplexArray) -> Places:
    """Goal rows left out although they are the worst at x; only "worst" leaves rows out."""
    if scene.goal != "worst" or len(rows) == len(scene.g):
        return np.empty(0, dtype=np.intp)
    left = together(np.abs(scene.G @ x + scene.g), scene.goal_sums)
    return _add(rows, left, float(left[rows].max(initial=0.0)) * (1.0 + 1e-11), scene)


def _add(rows: Places, left: FloatArray, level: float, scene: Scaled) -> Places:
    """The rows above `level` that are not shown yet, the worst few of them."""
    above = np.setdiff1d(np.flatnonzero(left > level), rows, assume_unique=True)
    return above[np.argsort(-left[above])[: 2 * scene.n_planes + 4]]


def first_rows(scene: Scaled) -> tuple[Places, Places]:
    """Goal and limit rows shown first: all where few, else the worst after a few rounds of Lawson's weights."""
    every, few = np.arange(len(scene.g)), FEW_DISCS if scene.is_discs else FEW
    goal_rows = every[:0] if scene.goal == "correction" else every
    limit_rows = np.arange(len(scene.f))
    if scene.goal == "worst" and len(every) > few and not len(scene.goal_sums):
        goal_rows = likely_worst(scene, scene.G, scene.g)
    if len(limit_rows) > few:
        limit_rows = np.union1d(likely_worst(scene, scene.F, scene.f), np.flatnonzero(scene.shared))
    return goal_rows, limit_rows


def likely_worst(scene: Scaled, M: ComplexArray, c: ComplexArray) -> Places:
    """Rows that are likely to be worst at the answer: weighted least squares, weights times residual, a few times.

    Two rows per free plane and one per plane at its cap are what an answer rests on; a few more are shown.
    (Lawson, 1961; Ellacott and Williams, 1976, for complex data.)
    """
    weights, left = np.full(len(c), 1.0 / len(c)), np.abs(c)
    x, across = np.zeros(scene.n_planes, dtype=complex), M.conj().T
    for _ in range(8 if scene.n_planes <= MANY_PLANES else 20):
        heavy = across * weights
        square = heavy @ M
        square.flat[:: len(square) + 1] += 1e-12 * np.trace(square).real + 1e-300
        x = pull_in(scene, np.linalg.solve(square, -heavy @ c))
        left = np.abs(M @ x + c)
        weights = weights * left
        weights /= weights.sum() or 1.0
    at_cap = int(np.count_nonzero(np.abs(x) >= 0.999 * scene.caps))
    count = min(int(2.2 * (scene.n_planes - at_cap)) + at_cap + 12, len(c))
    score = left / (left.max() or 1.0) + weights / (weights.max() or 1.0)
    return np.sort(np.argpartition(-score, count - 1)[:count])


def pull_in(scene: Scaled, x: ComplexArray) -> ComplexArray:
    """x brought into its discs, arcs, holes and the total mass, by as little as rounding asks for."""
    for plane, wedge in enumerate(scene.wedges):
        if wedge is not None:
            x[plane] = into_wedge(x[plane], *wedge)
    size = scene.sizes(x)
    over = size > scene.caps
    if over.any():
        x = x * (np.where(over, scene.caps, 1.0) / np.where(over, size, 1.0))
    for plane, fan in scene.fans.items():
        if not fan.bulges and np.isfinite(fan.each):
            x[plane] *= fan.each / max(fan.greatest(complex(x[plane])), fan.each)
    if np.isfinite(scene.total):
        mass = float(scene.mass @ scene.sizes(x))
        if mass > scene.total:
            x = x * (scene.total / mass)
    if scene.exact is not None:
        x = x - scene.exact.inverse @ (scene.F[scene.exact.rows] @ x + scene.f[scene.exact.rows])
    return x


def _inside(scene: Scaled, x: ComplexArray) -> bool:
    """Whether x is still within its discs, arcs and the total mass after it was brought back to the equations."""
    size = scene.sizes(x)
    arcs = [(one, wedge) for one, wedge in zip(x.tolist(), scene.wedges, strict=True) if wedge is not None]
    if any(abs(one - into_wedge(one, *wedge)) > KEPT * float(size.max()) for one, wedge in arcs):
        return False
    return bool((size <= scene.caps * (1.0 + KEPT)).all() and scene.mass @ size <= scene.total * (1.0 + KEPT))


def _nothing_to_choose(scene: Scaled) -> Convex:
    """No plane is free: the readings stay as they are."""
    factor = float(scene.held(np.empty(0, dtype=complex)).max(initial=0.0))
    if factor > 1.0 + KEPT:
        return Convex(None, np.inf, np.inf, None, factor)
    value = scene.value(np.empty(0, dtype=complex))
    return Convex(np.empty(0, dtype=complex), value, value, None)
