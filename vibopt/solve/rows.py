"""Limits at fixed speeds as polynomial inequalities, exact and few.

One variable: a polynomial in y (x = y**root).  One mass on (k, c): alpha k^2 + beta k + gamma +
delta c^2 <= 0, linear in q = c^2, so that for given k each row bounds q from one side.
"""

from __future__ import annotations

from typing import TypeVar

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.forms import (
    DecayRate,
    EnergyShare,
    ModeDamping,
    ModeFrequency,
    ModeGap,
    Modulus,
    Monomials,
    PeakInTime,
    RootMeanSquare,
    StaticForce,
    StaticLoad,
    StaticRow,
)
from vibopt.forms.rational import Groups, Sampled, sampled, sampled_static
from vibopt.mechanics.model import DAMPING, INERTIA, STIFFNESS, Model
from vibopt.program.program import Aim, Limit, Program
from vibopt.records import dataclass

_Numbers = TypeVar("_Numbers", FloatArray, ComplexArray)

_MOST_DEGREE = 4
"""Degree of N and D in the variable up to which their squares keep their digits: a mount in space has three springs."""


def single_lines(limit: Limit) -> bool:
    """Whether a limit is one harmonic of one excitation, or knows neither speeds nor poles nor noise."""
    form = limit.form
    if isinstance(form, DecayRate | RootMeanSquare | PeakInTime | StaticForce | StaticLoad | ModeGap | EnergyShare):
        return False
    if isinstance(form, Modulus):
        return (
            len(form.drives) == 1
            and len(form.drives[0].lines) == 1
            and not form.rigid_link
            and not form.output.shared_by
        )
    return limit.side != "outside"


def sample(limit: Limit, speeds: FloatArray, reference: FloatArray) -> Sampled:
    """N and D of a limit at its speeds (n,) [rad/s]."""
    form = limit.form
    if isinstance(form, StaticRow):
        return sampled_static(limit.model, form.row, reference)
    assert isinstance(form, Modulus)
    return sampled(limit.model, form.output, form.drives[0].lines[0], speeds, reference)


def sign_of(limit: Limit) -> float:
    """+1 when the form must stay below the bound."""
    return 1.0 if limit.side == "at_most" else -1.0


@dataclass(frozen=True)
class LineRows:
    """Rows of a program with one variable: polynomials in y, <= 0 where the limit holds.

    root
        x = y**root.
    """

    program: Program
    root: float
    reference: float

    @classmethod
    def of(cls, program: Program) -> LineRows:
        exponents = program.model.exponents[:, 0]
        half = bool((np.abs(exponents * 2 % 2) == 1).any())
        axis = program.axes[0]
        reference = float(np.sqrt(max(axis.low, axis.high * 1e-8) * axis.high))
        return cls(program, 2.0 if half else 1.0, reference)

    def at(self, limit: Limit, speeds: FloatArray) -> list[FloatArray]:
        """Ascending coefficients in y / y_ref, one polynomial per speed (a single one without speeds)."""
        form, sign = limit.form, sign_of(limit)
        if isinstance(form, Monomials):
            return [sign * self._monomials(form, limit.bound)]
        if isinstance(form, ModeFrequency | ModeDamping):
            return [sign * self._mode(limit)]
        made = sample(limit, speeds, np.array([self.reference]))
        degree = made.groups.degrees[0]
        nodes = np.array([0.0, 1.0, 2.0, 0.5, 3.0])[: degree + 1]
        y = nodes * self.reference ** (1.0 / self.root)
        top, bottom = made.at((y**self.root)[:, None])
        inverse = np.linalg.inv(np.vander(nodes, degree + 1, increasing=True))
        n, d = inverse @ top, inverse @ bottom
        rows = []
        for column in range(n.shape[1]):
            square = np.convolve(n[:, column], np.conj(n[:, column])) - limit.bound**2 * np.convolve(
                d[:, column], np.conj(d[:, column])
            )
            rows.append(sign * square.real / max(float(np.abs(square).max()), 1e-300))
        return rows

    def _monomials(self, form: Monomials, bound: float) -> FloatArray:
        powers = np.round(form.exponents[:, 0] * self.root).astype(int)
        row = np.zeros(int(powers.max(initial=0)) + 1)
        for scale, power, exponent in zip(form.scale, powers, form.exponents[:, 0], strict=True):
            row[power] += scale * self.reference**exponent
        row[0] -= bound
        return row

    def _mode(self, limit: Limit) -> FloatArray:
        """One mass: k - w^2 m, or c^2 - 4 z^2 k m, as a polynomial."""
        k, m, c = (self._total(limit.model, kind) for kind in (STIFFNESS, INERTIA, DAMPING))
        if isinstance(limit.form, ModeFrequency):
            return _plus(k, -(limit.bound**2) * m)
        return _plus(np.convolve(c, c), -4.0 * limit.bound**2 * np.convolve(k, m))

    def _total(self, model: Model, kind: int) -> FloatArray:
        row = np.zeros(round(self.root * float(model.exponents.max(initial=0.0))) + 1)
        for term in model.terms:
            if term.kind == kind:
                power = round(float(term.exponents[0]) * self.root)
                row[power] += term.scale * self.reference ** float(term.exponents[0]) * float(term.vector[0]) ** 2
        return row

    def accepts(self, limit: Limit) -> bool:
        """Whether the limit is a polynomial inequality."""
        form = limit.form
        if not single_lines(limit) or (limit.model.exponents < 0.0).any():
            return False
        if isinstance(form, ModeFrequency | ModeDamping):
            return limit.model.n_free == 1 and form.mode == 1
        if isinstance(form, Monomials):
            return bool((form.exponents >= 0).all())
        groups = Groups.of(limit.model, getattr(getattr(form, "output", None), "signs", None))
        return groups.degrees[0] <= _MOST_DEGREE


def _plus(a: _Numbers, b: _Numbers) -> _Numbers:
    total = np.zeros(max(len(a), len(b)), dtype=a.dtype)
    total[: len(a)] += a
    total[: len(b)] += b
    return total


def direction(aim: Aim, model: Model, index: int) -> float | None:
    """Sense in which the aim wants variable `index` to go: +1 up, -1 down; None where it is not that simple.

    Natural frequencies rise with every stiffness and fall with every mass; a single mass sags less
    the stiffer it is held.
    """
    form = aim.form
    kinds = {term.kind for term in model.terms if term.exponents[index]}
    if isinstance(form, ModeFrequency | StaticRow) and any(term.exponents[index] < 0.0 for term in model.terms):
        return None
    others = [i for i in range(model.n_vars) if i != index]
    if isinstance(form, Monomials):
        one = form.exponents[:, index]
        if np.any(form.exponents[:, others]) or not ((one > 0).all() or (one < 0).all()):
            return None
        return -aim.sense if (one > 0).all() else aim.sense
    if isinstance(form, ModeFrequency) and form.mode >= 1 and kinds <= {STIFFNESS, DAMPING}:
        return -aim.sense if STIFFNESS in kinds else None
    if isinstance(form, StaticRow) and model.n_free == 1 and kinds <= {STIFFNESS, DAMPING} and STIFFNESS in kinds:
        return aim.sense
    return None
