"""Weights cut in two for neighbouring holes, under caps: a cone program over what every hole takes.

What two neighbours do together is a sum of non-negative parts at the holes, and the lightest such sum uses two
neighbours.  So a cap on both parts is a cap on the sum over all holes, and the program is convex.  A cap on each hole
(a drill goes no deeper) may spread the best over more holes; then pairs of neighbours are branched over.
Clarabel finds the answer; the bound is worked out here from its multipliers, made feasible first.
"""

from __future__ import annotations

from dataclasses import field

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.balancing.fan import Fan
from vibopt.balancing.question import Question, Solved
from vibopt.cones import CONE, LINEAR, solve_cones
from vibopt.errors import counted
from vibopt.frontier import Frontier
from vibopt.records import dataclass
from vibopt.work import Budget

GAP = 1e-7
PROGRAMS = 500
PROGRAM = 10.0  # of nominal work [ms]
_TINY = 1e-300
_FAR = 10.0


def takes(question: Question) -> bool:
    """Whether caps on split weights are what makes the question, and all else in it is convex."""
    if not any(_bound(question, plane) for plane in range(len(question.fans))):
        return False
    others = [plane for plane in range(question.n_planes) if question.fans[plane] is None]
    arcs = any(question.sectors[plane] for plane in others) if question.sectors else False
    return not (question.pairs or question.is_discrete or arcs)


def _bound(question: Question, plane: int) -> bool:
    fan = question.fans[plane]
    limited = (np.isfinite(question.caps[plane]) and question.caps[plane] > 0.0) or np.isfinite(question.total_cap)
    return fan is not None and bool(np.isfinite(fan.each) or limited)


def solve_split(question: Question, budget: Budget | None = None) -> Solved:
    """The best correction, its gap worked out from multipliers; branching only where holes have caps of their own."""
    frontier = Frontier(budget or Budget(PROGRAMS, "programs", PROGRAM))
    first = _relaxed(question, question.fans)
    if first is None:
        return Solved(None, "unproven", "the cone program over the holes found no weights")
    best, value, bar, solved = None, np.inf, np.inf, 1
    frontier.push(first.bound, (first, question.fans))
    while frontier and not frontier.over and frontier.bound < bar:
        found, fans = frontier.pop()[1]
        worst = _overfull(found.u, fans)
        if worst is None:
            if found.value < value:
                best, value, bar = found.u, found.value, found.value - GAP * max(abs(found.value), _TINY)
            continue
        fan = fans[worst]
        assert fan is not None
        for part in fan.split_at(complex(found.u[worst])) if len(fan.gaps) > 1 else ():
            narrowed = tuple(part if plane == worst else one for plane, one in enumerate(fans))
            inner = _relaxed(question, narrowed)
            solved += 1
            frontier.budget.spend()
            if inner is not None:
                frontier.push(inner.bound, (inner, narrowed))
    if best is None:
        return Solved(None, "unproven", f"no split weights were found in {counted(solved, 'programs')}")
    bound = frontier.bound if frontier else first.bound if solved == 1 else value
    gap = max(value - bound, 0.0) / max(abs(value), _TINY)
    sure = bool(gap <= 1e-4)
    claim = f"cone program over the holes of split weights, {solved} solved, gap {gap:.1e} by our own dual bound"
    return Solved(best, "optimal" if sure else "feasible", claim, value, bound, gap, details={"programs": solved})


def _overfull(u: ComplexArray, fans: tuple[Fan | None, ...]) -> int | None:
    """The plane in which a hole of the pair around u takes most above its cap."""
    over = [
        0.0 if fan is None or abs(u[plane]) == 0.0 else fan.excess(complex(u[plane])) / abs(u[plane])
        for plane, fan in enumerate(fans)
    ]
    worst = int(np.argmax(over)) if over else 0
    return worst if over and over[worst] > 1e-7 else None


@dataclass(frozen=True)
class _Found:
    u: ComplexArray
    value: float
    bound: float


@dataclass
class _Cone:
    """Rows of A x + s = b in the order zero, non-negative, second-order cones."""

    size: int
    rows: list[FloatArray] = field(default_factory=list)
    right: list[float] = field(default_factory=list)
    flat: int = 0
    cones: list[int] = field(default_factory=list)

    def below(self, row: FloatArray, bound: float) -> None:
        """row . x <= bound; all of these before any cone."""
        self.rows.append(row)
        self.right.append(bound)
        self.flat += 1

    def within(self, radius: FloatArray, room: float, vectors: FloatArray, shift: FloatArray) -> None:
        """|vectors @ x + shift| <= radius . x + room."""
        self.rows += [-radius, *(-vectors)]
        self.right += [room, *shift.tolist()]
        self.cones.append(len(vectors) + 1)


def _relaxed(question: Question, fans: tuple[Fan | None, ...]) -> _Found | None:
    """Best correction with any number of holes of each plane, and a bound that no correction can be better than."""
    program = _Program(question, fans)
    return program.solve()


class _Program:
    """x: parts at the holes, then both components of free planes, then one or more tops of the goal (all scaled)."""

    def __init__(self, question: Question, fans: tuple[Fan | None, ...]) -> None:
        self.question, self.fans = question, fans
        self.unit = self._unit()
        self.amplitude = float(np.abs(question.y0).max(initial=0.0)) or 1.0
        columns: list[ComplexArray] = []
        self.owner: list[int] = []
        self.free: list[int] = []
        for plane, fan in enumerate(fans):
            if question.caps[plane] == 0.0:
                continue
            if fan is None:
                columns += [np.array([1.0 + 0j]), np.array([1j])]
                self.free += [plane, plane]
                self.owner += [plane, plane]
            else:
                columns += [np.array([hole]) for hole in fan.holes]
                self.free += [-1] * len(fan.holes)
                self.owner += [plane] * len(fan.holes)
        self.phasors = np.concatenate([*columns, np.zeros(0, dtype=complex)])
        n = question.n_readings
        self.tops = {"rms": 1, "worst": 1, "sum": n, "huber": 2 * n, "correction": 0}[question.goal]
        self.mass_tops = sorted({plane for plane in self.free if plane >= 0}) if self._needs_masses() else []
        self.n = len(self.owner)
        self.size = self.n + self.tops + len(self.mass_tops)

    def _unit(self) -> float:
        with np.errstate(divide="ignore", invalid="ignore"):
            felt = np.abs(self.question.y0).max(initial=0.0) / np.abs(self.question.H).max(initial=0.0)
        return float(felt) if np.isfinite(felt) and felt > 0.0 else 1.0

    def _needs_masses(self) -> bool:
        return self.question.goal == "correction" or bool(np.isfinite(self.question.total_cap))

    def _residual_rows(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Real and imaginary rows (n_readings, size) and shifts, amplitudes in units of the greatest reading."""
        H = self.question.H[:, self.owner] * self.phasors * (self.unit / self.amplitude)
        real, imag = np.zeros((len(H), self.size)), np.zeros((len(H), self.size))
        real[:, : self.n], imag[:, : self.n] = H.real, H.imag
        y0 = self.question.y0 / self.amplitude
        return real, imag, y0.real, y0.imag

    def _mass_row(self) -> FloatArray:
        """Sum of correction masses [kg per unit]."""
        row = np.zeros(self.size)
        density = self.question.densities * self.unit
        for i, plane in enumerate(self.owner):
            if self.free[i] < 0:
                row[i] = density[plane]
        for k, plane in enumerate(self.mass_tops):
            row[self.n + self.tops + k] = density[plane]
        return row

    def solve(self) -> _Found | None:
        question, cone = self.question, _Cone(self.size)
        unit = np.eye(self.size)
        for i in range(self.n):
            if self.free[i] < 0:
                cone.below(-unit[i], 0.0)
                fan = self.fans[self.owner[i]]
                if fan is not None and np.isfinite(fan.each):
                    cone.below(unit[i], fan.each / self.unit)
        for plane, fan in enumerate(self.fans):
            if fan is not None and np.isfinite(question.caps[plane]) and question.caps[plane] > 0.0:
                cone.below(
                    np.array([float(one == plane) for one in self.owner] + [0.0] * (self.size - self.n)),
                    question.caps[plane] / self.unit,
                )
        if np.isfinite(question.total_cap):
            cone.below(self._mass_row(), question.total_cap)
        real, imag, re0, im0 = self._residual_rows()
        for i in np.flatnonzero(np.isfinite(question.limits)).tolist():
            cone.within(
                np.zeros(self.size),
                question.limits[i] / self.amplitude,
                np.stack([real[i], imag[i]]),
                np.array([re0[i], im0[i]]),
            )
        for plane in sorted({one for one in self.free if one >= 0}):
            both = np.stack([unit[i] for i in range(self.n) if self.free[i] == plane])
            if np.isfinite(question.caps[plane]):
                cone.within(np.zeros(self.size), question.caps[plane] / self.unit, both, np.zeros(2))
            if plane in self.mass_tops:
                cone.within(unit[self.n + self.tops + self.mass_tops.index(plane)], 0.0, both, np.zeros(2))
        linear, quadratic = self._goal(cone, real, imag, re0, im0, unit)
        A, b = np.array(cone.rows), np.array(cone.right)
        kinds = [(LINEAR, cone.flat), *((CONE, size) for size in cone.cones)]
        answer = solve_cones(linear, A, b, kinds, quadratic=quadratic)
        x, z = answer.x, answer.z
        if not np.isfinite(x).all() or answer.status not in ("Solved", "AlmostSolved", "InsufficientProgress"):
            return None
        u = self._correction(x)
        if not self._kept(u):
            return None
        value = question.value(u)
        bound = self._bound(A, b, linear, quadratic, cone, x, z, value)
        return _Found(u, value, min(bound, value))

    def _goal(
        self, cone: _Cone, real: FloatArray, imag: FloatArray, re0: FloatArray, im0: FloatArray, unit: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        question, first = self.question, self.n
        linear, quadratic = np.zeros(self.size), np.zeros((self.size, self.size))
        weight = question.importance
        if question.goal == "correction":
            row = self._mass_row()
            self.scale = float(np.abs(row).max()) or 1.0
            return row / self.scale, quadratic
        if question.goal == "rms":
            linear[first] = 1.0
            self.scale = self.amplitude / np.sqrt(question.n_readings)
            cone.within(
                unit[first],
                0.0,
                np.concatenate([weight[:, None] * real, weight[:, None] * imag]),
                np.concatenate([weight * re0, weight * im0]),
            )
            return linear, quadratic
        self.scale = self.amplitude
        for i in range(question.n_readings):
            top = {"worst": unit[first], "sum": unit[min(first + i, self.size - 1)]}.get(question.goal)
            if top is None:
                top = unit[first + 2 * i] + unit[first + 2 * i + 1]
                quadratic[first + 2 * i, first + 2 * i] = 2.0
                linear[first + 2 * i + 1] = 2.0 * question.huber / self.amplitude
            cone.within(top, 0.0, weight[i] * np.stack([real[i], imag[i]]), weight[i] * np.array([re0[i], im0[i]]))
        if question.goal == "worst":
            linear[first] = 1.0
        elif question.goal == "sum":
            linear[first : first + question.n_readings] = 1.0
        else:
            self.scale = self.amplitude**2
        return linear, quadratic

    def _correction(self, x: FloatArray) -> ComplexArray:
        parts = np.where(np.array(self.free) < 0, np.maximum(x[: self.n], 0.0), x[: self.n]) * self.unit
        u = np.zeros(self.question.n_planes, dtype=complex)
        np.add.at(u, self.owner, parts * self.phasors)
        return u

    def _kept(self, u: ComplexArray) -> bool:
        """Whether all limits hold, to within what rounding of the solver is."""
        question = self.question
        left = np.abs(question.residual(u))
        masses = question.masses(u)
        room = 1.0 + 1e-7
        caps = np.where(np.isfinite(question.caps), question.caps * question.densities, np.inf)
        return bool(
            (left <= question.limits * room).all()
            and (masses <= caps * room + 1e-12 * masses.max(initial=0.0)).all()
            and masses.sum() <= question.total_cap * room
        )

    def _bound(
        self,
        A: FloatArray,
        b: FloatArray,
        linear: FloatArray,
        quadratic: FloatArray,
        cone: _Cone,
        x: FloatArray,
        z: FloatArray,
        value: float,
    ) -> float:
        """No correction is better: multipliers put into their cones, what is left of A'z + c times the reach of x."""
        if quadratic.any():
            return -np.inf
        z = z.copy()
        z[: cone.flat] = np.maximum(z[: cone.flat], 0.0)
        at = cone.flat
        for k in cone.cones:
            z[at] = max(z[at], float(np.linalg.norm(z[at + 1 : at + k])))
            at += k
        rest = np.abs(A.T @ z + linear)
        reach = np.full(self.size, max(value / self.scale, 0.0) * 2.0 + 2.0)
        for i, plane in enumerate(self.owner):
            fan, cap = self.fans[plane], self.question.caps[plane] / self.unit
            most = cap if fan is None else min(cap, fan.each / self.unit)
            reach[i] = most if np.isfinite(most) else _FAR * max(float(np.abs(x[: self.n]).max()), 1.0)
        return float(-(b @ z) - rest @ reach) * self.scale
