"""A question divided by its own sizes, so that the solver and the bound see numbers of order one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vibopt.balancing.question import Goal, Question
from vibopt.forms import ComplexArray, FloatArray


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
    """

    G: ComplexArray
    g: ComplexArray
    F: ComplexArray
    f: ComplexArray
    limited: NDArray[np.intp]
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

    @property
    def n_planes(self) -> int:
        return int(self.G.shape[1])

    @property
    def reach(self) -> FloatArray:
        """Greatest |x| that cap and total leave to each plane, shape (n_planes,)."""
        with np.errstate(divide="ignore"):
            alone = self.total / self.mass if np.isfinite(self.total) else np.full(self.n_planes, np.inf)
        return np.minimum(self.caps, alone)

    def value(self, x: ComplexArray) -> float:
        """The scaled goal at x."""
        if self.goal == "correction":
            return float(self.mass @ np.abs(x))
        t = np.abs(self.G @ x + self.g)
        if self.goal == "rms":
            return float(np.linalg.norm(t)) / self.divisor
        if self.goal == "worst":
            return float(t.max(initial=0.0))
        if self.goal == "sum":
            return float(t.sum())
        inside = np.minimum(t, self.huber)
        return float((inside * inside + 2.0 * np.where(t > inside, inside * (t - inside), 0.0)).sum())


def scaled(question: Question) -> Scaled:
    """Divide a question (without pairs) by its sizes; limits of zero become 1e-12 of the readings."""
    weights = np.zeros(question.n_readings) if question.goal == "correction" else question.importance
    size = float((weights * np.abs(question.y0)).max(initial=0.0)) or 1.0
    limited = np.flatnonzero(np.isfinite(question.limits))
    limits = np.maximum(question.limits[limited], 1e-12 * float(np.abs(question.y0).max(initial=0.0)) or 1e-300)
    G, g = question.H * (weights / size)[:, None], question.y0 * (weights / size)
    F, f = question.H[limited] / limits[:, None], question.y0[limited] / limits
    greatest = np.maximum(np.abs(G).max(axis=0, initial=0.0), np.abs(F).max(axis=0, initial=0.0))
    column = 1.0 / np.where(greatest > 0, greatest, 1.0)
    if question.goal == "rms" and len(g) > question.n_planes + 1:
        both: ComplexArray = np.asarray(np.linalg.qr(np.column_stack([G * column, g]), mode="r"))
        rows, constants = both[:, :-1], both[:, -1]
    else:
        rows, constants = G * column, g
    mass = question.densities * column
    mass_size = float(mass.max(initial=0.0)) or 1.0
    goal_size = {"correction": mass_size, "huber": size * size}.get(question.goal, size)
    return Scaled(
        G=rows, g=constants, F=F * column, f=f, limited=limited, caps=question.caps / column, mass=mass / mass_size,
        total=question.total_cap / mass_size, goal=question.goal, huber=question.huber / size,
        divisor=float(np.sqrt(question.n_readings)), goal_size=goal_size, mass_size=mass_size, column=column,
        wedges=(None,) * question.n_planes,
    )  # fmt: skip


def into_wedge(value: complex, middle: float, half: float) -> complex:
    """Nearest point of the arc of directions middle ± half (half <= pi/2) to `value`."""
    off = (np.angle(value) - middle + np.pi) % (2.0 * np.pi) - np.pi
    if abs(off) <= half:
        return value
    edge = np.exp(1j * (middle + np.copysign(half, off)))
    return complex(edge * max((value * edge.conjugate()).real, 0.0))
