"""Correction weights of rotors, of known masses and of engines: what is left is y0 + H u, u complex per plane.

Shares of engines are planes, too: real numbers within their ends.

Both programs have an objective of order one (the goal over its size as found) and limits as parts of their bounds; the
variables are unbalances in SI units [kg m], complex, turning with the rotor.  "rms" is stated in CasADi as its square,
"worst" as the square of the worst amplitude: smooth, with the same answer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field, replace
from typing import Any

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray, IntArray
from vibopt.balancing.fan import Fan
from vibopt.balancing.planes import open_arcs
from vibopt.balancing.question import Question
from vibopt.errors import counted
from vibopt.posed import conic
from vibopt.posed.nonlinear import Collected, NonlinearProgram
from vibopt.records import dataclass

ZERO = 1e-9
HALF_TURN = np.pi * (1.0 + 1e-12)


@dataclass(frozen=True)
class Named:
    """A question with the words of its file.

    planes
        Path of each plane, "planes.left".
    limits
        Path, rows and bounds [SI] of each limit on what is left.
    caps
        Path of what caps each plane.
    total
        Path of the limit on all corrections together.
    fixed
        Weights that are decided (n_planes,), counted among what was read; empty where there are none.
    readings
        What each row reads, "a at 1200 rpm"; empty where a limit says that.
    pairs
        Path of each pair.
    """

    question: Question
    planes: tuple[str, ...]
    limits: tuple[tuple[str, IntArray, FloatArray], ...]
    caps: tuple[str, ...]
    total: str = "limits.total"
    fixed: ComplexArray = field(default_factory=lambda: np.zeros(0, dtype=complex))
    readings: tuple[str, ...] = ()
    pairs: tuple[str, ...] = ()

    def name(self, path: str, row: int) -> str:
        """That of what holds one row, with what it reads."""
        return f"{path}, {self.readings[row]}" if row < len(self.readings) else path

    @classmethod
    def of(
        cls, question: Question, planes: tuple[str, ...], limits: Sequence[tuple[str, IntArray, FloatArray]],
        caps: Sequence[str], total: str,
    ) -> Named:  # fmt: skip
        """With the weights that are decided, one in a list of one, among what was read."""
        fixed = np.zeros(question.n_planes, dtype=complex)
        options = list(question.options)
        for k, option in enumerate(options):
            if option is not None and len(option.u) == 1:
                fixed[k], options[k] = option.u[0], None
        if not fixed.any():
            return cls(question, planes, tuple(limits), tuple(caps), total)
        left = replace(
            question, y0=question.residual(fixed), caps=np.where(fixed == 0.0, question.caps, 0.0),
            options=tuple(options) if any(one is not None for one in options) else (),
            total_cap=question.total_cap - float(question.masses(fixed)[fixed != 0.0].sum()),
        )  # fmt: skip
        return cls(left, planes, tuple(limits), tuple(caps), total, fixed)

    @classmethod
    def plain(cls, question: Question, planes: tuple[str, ...] = ()) -> Named:
        """With the paths of planes at most."""
        rows = np.flatnonzero(np.isfinite(question.limits))
        planes = planes or tuple(f"planes.{k}" for k in range(question.n_planes))
        limits = (("limits.readings", rows, question.limits[rows]),) if len(rows) else ()
        named = cls.of(question, planes, limits, [f"{plane}.cap" for plane in planes], "limits.total")
        return replace(named, pairs=tuple(f"pairs.{k}" for k in range(len(question.pairs))))

    @property
    def free(self) -> list[int]:
        """Planes that may be changed."""
        return [int(k) for k in np.flatnonzero(self.question.caps > 0.0)]

    @property
    def ends(self) -> Sequence[tuple[float, float] | None]:
        """Of the shares, by plane; None of a weight."""
        return self.question.ends or (None,) * self.question.n_planes

    def within(self, u: ComplexArray) -> ComplexArray:
        """Shares pulled back onto their ends, to which a solver keeps only to its tolerance."""
        pairs = zip(u.tolist(), self.ends, strict=True)
        return np.array([z if ends is None else np.clip(z.real, *ends) for z, ends in pairs], dtype=complex)

    @property
    def greatest(self) -> float:
        """Greatest reading [SI]."""
        return float(np.abs(self.question.y0).max(initial=0.0)) or 1.0

    @property
    def zero(self) -> float:
        """What counts as nothing left: bounds up to it are met as equations [SI]."""
        return ZERO * self.greatest

    @property
    def size(self) -> float:
        """What a goal of one is [SI]: the goal as found, or the correction that would cancel all readings."""
        q = self.question
        if q.goal == "correction":
            sizes = np.abs(q.H).max(axis=0, initial=0.0)[self.free]
            amounts = np.abs(q.y0).max(initial=0.0) / np.where(sizes > 0.0, sizes, np.inf) * q.densities[self.free]
            return float(amounts.sum()) or 1.0
        value = float(q.measure(np.abs(q.y0)))
        return value or float((q.importance * np.abs(q.H).max(axis=1, initial=0.0)).max(initial=0.0)) or 1.0

    def not_convex(self) -> str:
        """Why there is no convex program; "" where there is one."""
        for plane, arc in self._arcs():
            if arc[1] - arc[0] > HALF_TURN:
                return (
                    f"{plane} may be corrected over {np.degrees(arc[1] - arc[0]):.4g} deg, more than half a turn: two "
                    "weights that are allowed may add up to one that is not"
                )
        return ""

    def not_smooth(self) -> str:
        """Why there is neither program; "" where there is one."""
        q = self.question
        if not self.free:
            return "no plane may be changed"
        for plane, option in zip(self.planes, q.options, strict=False):
            if option is not None:
                many = counted(len(option.u), "weights")
                return f"{plane} takes one of {many}; a choice from a list is neither convex nor smooth"
        for k, fan in enumerate(q.fans):
            if fan is not None and (np.isfinite(fan.each) or fan.line is not None):
                return (
                    f"{self.planes[k]} has holes that take only so much each: what two neighbours reach bulges, and "
                    "their gaps have to be compared one by one"
                )
        for k in self.free:
            if len(_allowed(q, k)) > 1:
                return f"{self.planes[k]} has several forbidden sectors: the arcs between them are separate sets"
            if not _allowed(q, k):
                return f"{self.planes[k]} has no allowed angle"
        return ""

    def _arcs(self) -> list[tuple[str, tuple[float, float]]]:
        found = [(self.planes[k], _allowed(self.question, k)) for k in self.free]
        return [(plane, arcs[0]) for plane, arcs in found if arcs and arcs[0] != EVERY]

    def arc(self, plane: int) -> tuple[float, float] | None:
        """First and last allowed angle [rad]; None where every angle is."""
        first = _allowed(self.question, plane)[0]
        return None if first == EVERY else first


EVERY = (0.0, 2.0 * np.pi)


def _allowed(question: Question, plane: int) -> list[tuple[float, float]]:
    """Allowed arcs (from, to) [rad] of a plane, from < to."""
    fan = question.fans[plane] if question.fans else None
    if fan is not None and fan.wedge is not None:
        middle, half = fan.wedge
        return [(middle - half, middle + half)]
    return open_arcs(question.sectors[plane] if question.sectors else ())


def convex(named: Named, *, margin: float = 0.0, widened: bool = False) -> Any:
    """The `cvxpy.Problem`: a complex variable a plane, named by its path; bounds are drawn in by the part `margin`.

    Where they are `widened`, the least common factor on all bounds of what is left is asked for instead of the goal.
    """
    import cvxpy as cp

    q = named.question
    factor = cp.Variable(nonneg=True, name="factor") if widened else 1.0 - margin
    u = {k: cp.Variable(complex=named.ends[k] is None, name=named.planes[k]) for k in named.free}
    left = _left(cp, q, u)
    masses = [_mass(cp, q, k, one) for k, one in u.items()]
    constraints = []
    goal = sum(masses) / named.size if q.goal == "correction" else _measure(cp, q, left, named.size)
    for path, rows, bounds in named.limits:
        some, none = rows[bounds > named.zero], rows[bounds <= named.zero]
        if len(some):
            there = cp.multiply(left[some], 1.0 / bounds[bounds > named.zero])
            constraints.append(conic.named(_together(q, some) @ cp.abs(there) <= factor, path))
        if len(none):
            constraints.append(conic.named(left[none] / named.greatest == 0.0, path))
    for k, one in u.items():
        constraints += _held(cp, named, k, one, margin)
    if np.isfinite(q.total_cap):
        constraints.append(conic.named(sum(masses) / q.total_cap <= 1.0 - margin, named.total))
    for path, (first, second, ratio) in zip(named.pairs, q.pairs, strict=True):
        sizes = [1.0 / (np.abs(q.H[:, k]).max(initial=0.0) or 1.0) for k in (first, second)]
        constraints.append(conic.named((u.get(second, 0.0) - ratio * u.get(first, 0.0)) / max(sizes) == 0.0, path))
    return cp.Problem(cp.Minimize(factor if widened else goal), constraints)


def _left(cp: Any, question: Question, u: dict[int, Any]) -> Any:
    """What is left, y0 + H u, by its parts: of complex constants cvxpy drops a part that is nowhere above 1e-5."""
    real, imag = question.y0.real, question.y0.imag
    for k, one in u.items():
        H = question.H[:, k]
        real = real + H.real * cp.real(one) - H.imag * cp.imag(one)
        imag = imag + H.imag * cp.real(one) + H.real * cp.imag(one)
    return real + 1j * imag


def _together(question: Question, rows: IntArray) -> FloatArray:
    """Which of some rows are added up before they are held against their limit, (n_held, n_rows)."""
    numbers = question.sums[rows] if len(question.sums) else rows
    return np.equal.outer(np.unique(numbers), numbers).astype(float)


def _mass(cp: Any, question: Question, plane: int, u: Any) -> Any:
    """Correction mass of a plane [kg]; of a weight cut in two that of both parts."""
    fan = question.fans[plane] if question.fans else None
    return question.densities[plane] * (cp.abs(u) if fan is None else cp.pos(cp.max(_sides(cp, fan, u))))


def _sides(cp: Any, fan: Fan, u: Any) -> Any:
    return fan.sides.real * cp.real(u) + fan.sides.imag * cp.imag(u)


def _measure(cp: Any, question: Question, left: Any, size: float) -> Any:
    """The goal of what is left, over `size`; for "sum" and "worst" of the rows that count alone."""
    counts = question.importance > (0.0 if question.goal in ("sum", "worst") else -1.0)
    rows = cp.multiply(question.importance[counts], left[counts])
    if question.goal == "rms":
        return cp.norm(rows / (size * np.sqrt(question.n_readings)))
    if question.goal == "worst":
        return cp.max(_together(question, np.flatnonzero(counts)) @ cp.abs(rows / size))
    if question.goal == "sum":
        return cp.sum(cp.abs(rows / size))
    root = np.sqrt(size)  # Huber's sum is of squares
    return cp.sum(cp.huber(cp.abs(rows / root), question.huber / root))


def _held(cp: Any, named: Named, plane: int, u: Any, margin: float) -> list[Any]:
    """Cap and allowed arc of one plane."""
    q = named.question
    if (ends := named.ends[plane]) is not None:
        held = [conic.named(u >= ends[0], f"{named.planes[plane]}.from")]
        return [*held, conic.named(u <= ends[1], f"{named.planes[plane]}.to")] if np.isfinite(ends[1]) else held
    cap, arc = q.caps[plane], named.arc(plane)
    fan = q.fans[plane] if q.fans else None
    held = []
    if np.isfinite(cap):
        whole = cp.abs(u) if fan is None else cp.pos(cp.max(_sides(cp, fan, u)))
        held.append(conic.named(whole / cap <= 1.0 - margin, named.caps[plane]))
    if arc is not None:
        for angle, turn in ((arc[0], 1.0), (arc[1], -1.0)):  # to the left of the first ray, to the right of the last
            normal = turn * 1j * np.exp(1j * angle)
            inside = normal.real * cp.real(u) + normal.imag * cp.imag(u)
            held.append(conic.named(inside >= 0.0, f"{named.planes[plane]}.forbidden"))
    return held


def smooth(named: Named) -> NonlinearProgram:
    """The same in CasADi: unknowns are Re u and Im u over the size of each plane, or size and angle in an arc."""

    made = _Smooth(named)
    goal = made.goal()
    made.limits()
    return made.program(goal)


class _Smooth(Collected):
    """Of correction weights: their two parts each, or size and angle in an arc."""

    def __init__(self, named: Named) -> None:
        import casadi

        super().__init__()
        self.named, self.q = named, named.question
        q, self.begin = self.q, self._begin()
        real, imag = casadi.SX(q.y0.real), casadi.SX(q.y0.imag)
        self.parts: dict[int, tuple[Any, Any]] = {}
        for k in named.free:
            a, b = self._phasor(k)
            self.parts[k] = a, b
            self.variables[named.planes[k]] = a if named.ends[k] is not None else casadi.vertcat(a, b)
            real += q.H[:, k].real * a - q.H[:, k].imag * b
            imag += q.H[:, k].imag * a + q.H[:, k].real * b
        self.left, self.squares = (real, imag), real**2 + imag**2

    def _phasor(self, plane: int) -> tuple[Any, Any]:
        import casadi

        path, arc, begin = self.named.planes[plane], self.named.arc(plane), complex(self.begin[plane])
        if (share := self.named.ends[plane]) is not None:
            return self.unknown(path, *share, float(np.clip(begin.real, *share))), casadi.SX(0)
        size = self.named.greatest / (float(np.abs(self.q.H[:, plane]).max(initial=0.0)) or 1.0)
        size = min(size or 1.0, self.q.caps[plane])
        if arc is None:
            ends = (("Re", begin.real), ("Im", begin.imag))
            real, imag = (size * self.unknown(f"{part} {path}", -np.inf, np.inf, z / size) for part, z in ends)
            return real, imag
        # an angle outside the arc begins at its nearer end
        turn = float(arc[0] + (np.angle(begin) - arc[0]) % (2.0 * np.pi))
        turn = turn if turn <= arc[1] else arc[1] if turn - arc[1] < np.pi - 0.5 * (arc[1] - arc[0]) else arc[0]
        long = size * self.unknown(f"|{path}|", 0.0, np.inf, abs(begin) / size)
        angle = self.unknown(f"angle of {path}", arc[0], arc[1], turn)
        return long * casadi.cos(angle), long * casadi.sin(angle)

    def _begin(self) -> ComplexArray:
        """Least squares of all readings, pulled into the caps (n_planes,)."""
        q, free = self.q, self.named.free
        found = np.zeros(q.n_planes, dtype=complex)
        if free:
            found[free] = np.linalg.lstsq(q.H[:, free], -q.y0, rcond=None)[0]
        over = np.abs(found) > q.caps
        found[over] *= q.caps[over] / np.abs(found[over])
        return found

    def amount(self, plane: int) -> Any:
        """Correction mass over the goal's size, an unknown above what is fitted; of a weight cut in two all of it."""
        a, b = self.parts[plane]
        part = self.q.densities[plane] / self.named.size if self.q.goal == "correction" else 1.0 / self.q.total_cap
        part = part if self.q.goal == "correction" else part * self.q.densities[plane]
        above = self.unknown(f"mass of {self.named.planes[plane]}", 0.0, np.inf, 1.0)
        fan = self.q.fans[plane] if self.q.fans else None
        if fan is None:
            self.below(f"mass of {self.named.planes[plane]}", part**2 * (a**2 + b**2) - above**2)
        for side in fan.sides if fan is not None else ():
            self.below(f"mass of {self.named.planes[plane]}", part * (side.real * a + side.imag * b) - above)
        return above

    def goal(self) -> Any:
        import casadi

        q, size = self.q, self.named.size
        if q.goal == "correction":
            return sum((self.amount(k) for k in self.parts), casadi.SX(0))
        if q.goal == "huber":
            return self._huber(float(np.sqrt(size)))
        rows = casadi.vertsplit(q.importance**2 * self.squares / size**2)
        if q.goal == "rms":
            return sum(rows[1:], rows[0]) / q.n_readings
        counts = np.flatnonzero(q.importance > 0.0).tolist()
        if q.goal == "worst" and q.adds_up:
            return self._worst_sum(rows, counts)
        if q.goal == "worst":
            above = self.unknown("square of the worst", 0.0, np.inf, 1.0)
            for k in counts:
                self.below(self.named.name("goal", k), rows[k] - above)
            return above
        heads = [self.unknown("amplitude", 0.0, np.inf, 1.0) for _ in counts]
        for k, head in zip(counts, heads, strict=True):
            self.below(self.named.name("goal", k), rows[k] - head**2)
        return sum(heads[1:], heads[0])

    def _worst_sum(self, rows: Sequence[Any], counts: Sequence[int]) -> Any:
        """The greatest sum of amplitudes of one number, each below an unknown of its own."""
        above = self.unknown("the worst", 0.0, np.inf, 1.0)
        heads = [self.unknown("amplitude", 0.0, np.inf, 1.0) for _ in counts]
        for k, head in zip(counts, heads, strict=True):
            self.below(self.named.name("goal", k), rows[k] - head**2)
        for some in _together(self.q, np.array(counts)):
            own = [head for head, held in zip(heads, some, strict=True) if held]
            self.below("goal", sum(own[1:], own[0]) - above)
        return above

    def _huber(self, root: float) -> Any:
        """Each amplitude below a + b: a counts as its square, b beyond the threshold linearly."""
        import casadi

        total = casadi.SX(0)
        for k, (row, weight) in enumerate(zip(casadi.vertsplit(self.squares), self.q.importance, strict=True)):
            near, far = (self.unknown(part, 0.0, np.inf, 0.5) for part in ("near", "far"))
            self.below(self.named.name("goal", k), weight**2 * row / root**2 - (near + far) ** 2)
            total += near**2 + 2.0 * self.q.huber / root * far
        return total

    def limits(self) -> None:
        q, named = self.q, self.named
        for path, rows, bounds in named.limits:
            if len(groups := _together(q, rows)) < len(rows) and bounds[0] > named.zero:
                heads = [self.unknown("amplitude", 0.0, np.inf, 1.0) for _ in rows]
                for row, head in zip(rows.tolist(), heads, strict=True):
                    self.below(named.name(path, row), self.squares[row] / bounds[0] ** 2 - head**2)
                for some in groups:
                    own = [head for head, held in zip(heads, some, strict=True) if held]
                    self.below(path, sum(own[1:], own[0]) - 1.0)
                continue
            for row, bound in zip(rows.tolist(), bounds.tolist(), strict=True):
                if bound > named.zero:
                    self.below(named.name(path, row), self.squares[row] / bound**2 - 1.0)
                else:
                    self.below(named.name(path, row), *(part[row] / named.greatest for part in self.left), equal=True)
        for k, (a, b) in self.parts.items():
            cap, fan = q.caps[k] if named.ends[k] is None else np.inf, q.fans[k] if q.fans else None
            if np.isfinite(cap) and fan is None:
                self.below(named.caps[k], (a**2 + b**2) / cap**2 - 1.0)
            elif np.isfinite(cap) and fan is not None:
                sides = [(side.real * a + side.imag * b) / cap - 1.0 for side in fan.sides]
                self.below(named.caps[k], *sides)
        if np.isfinite(q.total_cap):
            if q.goal == "correction":
                heads = [unknown for unknown in self.unknowns if str(unknown).startswith("mass of")]
                self.below(named.total, sum(heads[1:], heads[0]) * named.size / q.total_cap - 1.0)
            else:
                heads = [self.amount(k) for k in self.parts]
                self.below(named.total, sum(heads[1:], heads[0]) - 1.0)
        for path, pair in zip(named.pairs, q.pairs, strict=True):
            self._pair(path, *pair)

    def _pair(self, path: str, first: int, second: int, ratio: complex) -> None:
        a, b = self.parts.get(first, (0.0, 0.0))
        c, d = self.parts.get(second, (0.0, 0.0))
        size = self.named.greatest / (float(np.abs(self.q.H[:, second]).max(initial=0.0)) or 1.0)
        for row in (c - ratio.real * a + ratio.imag * b, d - ratio.imag * a - ratio.real * b):
            self.below(path, row / size, equal=True)
