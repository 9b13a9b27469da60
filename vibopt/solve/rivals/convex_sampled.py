"""cvxpy where one mass on one mount is convex: in (k, q) with q the square of the damping.

Force handed on, at every sampled speed with F > T: (F^2 - T^2)(k^2 + w^2 q) + 2 T^2 m w^2 k <= T^2 m^2 w^4.
Passage through resonance under a constant force, P = F / X: k >= P and (q >= 2 m P or k >= m P^2 / q + q / 4 m);
under an unbalance, r = m_e e / (m X): q >= 2 k m (1 - sqrt(1 - r^2)).  Motion at a running speed above resonance is
held by k <= m w^2 - F / X, which asks a little too much where there is damping.
"""

from __future__ import annotations

import warnings
from dataclasses import field
from typing import Any, ClassVar

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms import Modulus, StaticRow
from vibopt.mechanics.constants import GRAVITY
from vibopt.mechanics.model import INERTIA
from vibopt.program.program import Limit, Program
from vibopt.records import dataclass
from vibopt.signals import Line
from vibopt.solve.method import Found, Progress
from vibopt.solve.rivals.balance import clarabel
from vibopt.solve.rivals.sampled import sampled_speeds


class _NotConvexError(Exception):
    """Why this scene has no convex form in (k, q)."""


@dataclass
class _Rows:
    """square * k^2 + slope * k + tilt * q <= right, all divided by their size, k and q in their own scales."""

    square: list[float] = field(default_factory=list)
    slope: list[float] = field(default_factory=list)
    tilt: list[float] = field(default_factory=list)
    right: list[float] = field(default_factory=list)

    def add(self, square: float, slope: float, tilt: float, right: float) -> None:
        size = max(abs(square), abs(slope), abs(tilt), abs(right), 1e-300)
        for row, value in zip(
            (self.square, self.slope, self.tilt, self.right), (square, slope, tilt, right), strict=True
        ):
            row.append(value / size)


@dataclass
class Convex:
    """One mass on (k, q) with Clarabel.

    keep
        Build the problem once with parameters (DPP) and only change them afterwards.
    tolerance
        Of Clarabel, of its gap and of every row.
    """

    keep: bool = False
    tolerance: float = 1e-8
    speeds: int = 200
    name: str = "cvxpy_sampled"
    built: ClassVar[dict[tuple[int, int], Any]] = {}

    @property
    def summary(self) -> str:
        how = "built once with parameters" if self.keep else "built afresh"
        return f"cvxpy with Clarabel on one mass, stiffness and squared damping, {how}"

    def refuses(self, program: Program) -> str | None:
        """Everything but one mass on one viscous mount, under limits that are convex in (k, q)."""
        try:
            _OneMount(program, self.speeds).branches()
        except _NotConvexError as why:
            return f"{self.name} takes one mass on one mount where it is convex: {why}"
        return None

    def solve(self, program: Program, progress: Progress | None = None) -> Found:
        """The best of the branches, each solved by Clarabel, with its word for it."""
        mount = _OneMount(program, self.speeds)
        found, words = [], []
        for rows, hyperbola in mount.branches():
            value, y, word = self._solve(mount, rows, hyperbola)
            words.append(word)
            if y is not None:
                found.append((value, tuple(y)))
        if not found:
            if all(word == "infeasible" for word in words):
                return Found("infeasible", None, "Clarabel: infeasible", self.name)
            return Found("unproven", None, f"Clarabel: {', '.join(words)}", self.name)
        _, (k, q) = min(found)
        x = np.zeros(2)
        x[mount.stiffness], x[mount.damping] = k * mount.k_size, np.sqrt(max(q, 0.0)) * mount.c_size
        return Found("feasible", np.clip(x, program.low, program.high), "Clarabel: optimal", self.name,
                     details={"within": 10.0 * self.tolerance})  # fmt: skip

    def _solve(self, mount: _OneMount, rows: _Rows, hyperbola: float) -> tuple[float, FloatArray | None, str]:
        import cvxpy

        count, curved = len(rows.square), int(hyperbola > 0.0)
        key = (count, curved)
        made = self.built.get(key) if self.keep else None
        if made is None:
            made = _build(cvxpy, count, bool(curved), parameters=self.keep, rows=rows, mount=mount, hyperbola=hyperbola)
            if self.keep:
                self.built[key] = made
        problem, k, q, knobs = made
        if self.keep:
            values = (rows.square, rows.slope, rows.tilt, rows.right, mount.linear, hyperbola)
            for knob, value in zip(knobs, values, strict=True):
                if knob is not None:
                    knob.value = np.array(value)
        with warnings.catch_warnings():  # what it warns of is in its status
            warnings.simplefilter("ignore")
            try:
                problem.solve(solver="CLARABEL", **clarabel(self.tolerance))
            except cvxpy.SolverError:
                return np.inf, None, "solver error"
        if problem.status != "optimal":
            return np.inf, None, str(problem.status)
        return float(problem.value), np.array([float(k.value), float(q.value)]), "optimal"


def _build(
    cvxpy: Any, count: int, curved: bool, *, parameters: bool, rows: _Rows, mount: _OneMount, hyperbola: float
) -> tuple[Any, Any, Any, tuple[Any, ...]]:
    k, q = cvxpy.Variable(), cvxpy.Variable()
    if parameters:
        square = cvxpy.Parameter(count, nonneg=True)
        slope, tilt, right, linear = (cvxpy.Parameter(n) for n in (count, count, count, 2))
        bend = cvxpy.Parameter(nonneg=True) if curved else None
    else:
        square, slope, tilt, right = (np.array(one) for one in (rows.square, rows.slope, rows.tilt, rows.right))
        linear, bend = np.array(mount.linear), hyperbola
    limits = [cvxpy.multiply(square, cvxpy.square(k) * np.ones(count)) + slope * k + tilt * q <= right]
    if curved:
        limits.append(k >= bend * cvxpy.inv_pos(q) + q / 4.0)
    problem = cvxpy.Problem(cvxpy.Minimize(linear[0] * k + linear[1] * q), limits)
    return problem, k, q, (square, slope, tilt, right, linear, bend)


class _OneMount:
    """The numbers of one mass on one viscous mount; k and q in units of m W^2 and (m W)^2."""

    def __init__(self, program: Program, speeds: int) -> None:
        self.program, self.speeds = program, speeds
        model = program.model
        words = [axis.path.rsplit(".", 1)[-1] for axis in program.axes]
        if model.n_free != 1 or len(model.links) != 1 or any(axis.values for axis in program.axes):
            raise _NotConvexError("this is more than one mass on one mount.")
        if sorted(words) != ["damping", "stiffness"] or model.n_coords != 1:
            raise _NotConvexError("the variables must be one stiffness and one damping.")
        self.stiffness, self.damping = words.index("stiffness"), words.index("damping")
        self.mass = float(model.scales[model.kinds == INERTIA].sum())
        drives = [drive for limit in program.limits for drive in limit.form.drives]
        self.top = max((band.high for drive in drives for band in drive.bands), default=1.0)
        self.k_size, self.c_size = self.mass * self.top**2, self.mass * self.top
        self.linear = self._goal()

    def branches(self) -> list[tuple[_Rows, float]]:
        """Convex pieces of the feasible set: rows, and m P^2 of the hyperbola (0: none), all scaled."""
        rows, passages = _Rows(), []
        for index, size in ((self.stiffness, self.k_size), (self.damping, self.c_size)):
            axis = self.program.axes[index]
            low, high = axis.low / size, min(axis.high / size, 1e9)
            slope, tilt = (1.0, 0.0) if index == self.stiffness else (0.0, 1.0)
            low, high = (low, high) if index == self.stiffness else (low**2, high**2)
            rows.add(0.0, -slope, -tilt, -low)
            rows.add(0.0, slope, tilt, high)
        for limit in self.program.limits:
            passages += self._limit(limit, rows)
        if not passages:
            return [(rows, 0.0)]
        strongest = max(passages)
        overdamped = _Rows(*(list(getattr(rows, key)) for key in ("square", "slope", "tilt", "right")))
        overdamped.add(0.0, 0.0, -1.0, -2.0 * strongest)
        return [(overdamped, 0.0), (rows, strongest**2)]

    def _goal(self) -> tuple[float, float]:
        aim = self.program.aim
        if aim is None:
            return (0.0, 0.0)
        if isinstance(aim.form, StaticRow):
            return (-aim.sense, 0.0)
        if aim.form.powers is not None and len(aim.form.powers.scale) == 1:
            powers = aim.form.powers.exponents[0]
            if powers[self.stiffness] > 0 and powers[self.damping] == 0:
                return (aim.sense, 0.0)
            if powers[self.damping] > 0 and powers[self.stiffness] == 0 and aim.sense > 0:
                return (0.0, 1.0)
        raise _NotConvexError("the goal must be a stiffness, a sag or a least damping.")

    def _limit(self, limit: Limit, rows: _Rows) -> list[float]:
        """Add the rows of a limit; the strongest P of a passage under constant force, scaled."""
        form = limit.form.harmonic
        if isinstance(limit.form, StaticRow):
            bound = self.mass * GRAVITY / limit.bound / self.k_size
            rows.add(0.0, *((-1.0, 0.0, -bound) if limit.side == "at_most" else (1.0, 0.0, bound)))
            return []
        if form is None or limit.side != "at_most" or len(form.drives) != 1:
            raise _NotConvexError(f"{limit.name} is no upper bound of a response to one excitation.")
        if len(form.drives[0].lines) != 1 or form.rigid_link or form.output.power or form.output.shared_by:
            raise _NotConvexError(f"{limit.name} has several harmonics or is not a force or displacement.")
        line = form.drives[0].lines[0]
        if form.output.signs.any():
            self._force(limit, form, line, rows)
            return []
        return self._motion(limit, form, line, rows)

    def _force(self, limit: Limit, form: Modulus, line: Line, rows: _Rows) -> None:
        """Force into the ground at each sampled speed."""
        speeds = sampled_speeds(form.drives[0], self.speeds)
        forces = np.abs(line.amplitude.at(speeds) * line.vector[0])
        for speed, force in zip(line.order * speeds, forces, strict=True):
            if force <= limit.bound:
                raise _NotConvexError(f"{limit.name} is not convex where its bound is more than the exciting force.")
            w2, ratio = (speed / self.top) ** 2, (limit.bound / force) ** 2
            rows.add(1.0 - ratio, 2.0 * ratio * w2, (1.0 - ratio) * w2, ratio * w2**2)

    def _motion(self, limit: Limit, form: Modulus, line: Line, rows: _Rows) -> list[float]:
        passages = []
        for band in form.drives[0].bands:
            piece = line.amplitude.pieces[0]
            if len(line.amplitude.pieces) > 1 or piece.slope or piece.power not in (0, 2):
                raise _NotConvexError(f"{limit.name} has a force that is neither constant nor that of an unbalance.")
            size = abs(piece.constant * line.vector[0]) / limit.bound
            high = line.order * band.high
            if band.is_point:
                pull = size * (band.high**2 if piece.power else 1.0) / self.k_size
                rows.add(0.0, 1.0, 0.0, (high / self.top) ** 2 - pull)
            elif band.low > 0.0:
                raise _NotConvexError(f"{limit.name} does not begin at rest.")
            elif piece.power:
                ratio = size / (self.mass * line.order**2)
                if ratio >= 1.0:
                    continue
                rows.add(0.0, 2.0 * (1.0 - np.sqrt(1.0 - ratio**2)), -1.0, 0.0)
            else:
                rows.add(0.0, -1.0, 0.0, -size / self.k_size)
                passages.append(size / self.k_size)
        return passages
