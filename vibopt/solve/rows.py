"""Limits at fixed speeds as polynomial inequalities, exact and few.

One variable: a polynomial in y (x = y**root).  One mass on (k, c): alpha k^2 + beta k + gamma +
delta c^2 <= 0, linear in q = c^2, so that for given k each row bounds q from one side.
"""

from __future__ import annotations

from dataclasses import field
from typing import TypeVar

import numpy as np

from vibopt.forms import (
    ComplexArray,
    DecayRate,
    EnergyShare,
    FloatArray,
    ModeDamping,
    ModeFrequency,
    ModeGap,
    Modulus,
    Monomials,
    RootMeanSquare,
    StaticForce,
    StaticLoad,
    StaticRow,
)
from vibopt.mechanics.model import DAMPING, HYSTERETIC, INERTIA, STIFFNESS, Model, factors
from vibopt.mechanics.onemass import numerator
from vibopt.program.program import Aim, Limit, Program
from vibopt.program.rational import Groups, Sampled, sampled, sampled_static
from vibopt.records import dataclass

_Numbers = TypeVar("_Numbers", FloatArray, ComplexArray)

_MOST_DEGREE = 4
"""Degree of N and D in the variable up to which their squares keep their digits: a mount in space has three springs."""


def single_lines(limit: Limit) -> bool:
    """Whether a limit is one harmonic of one excitation, or knows neither speeds nor poles nor noise."""
    form = limit.form
    if isinstance(form, DecayRate | RootMeanSquare | StaticForce | StaticLoad | ModeGap | EnergyShare):
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
        if isinstance(form, Modulus) and limit.model.n_coords == 1:
            return self._pushed(limit, speeds)
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

    def _pushed(self, limit: Limit, speeds: FloatArray) -> list[FloatArray]:
        """Rows of one mass under a force: both N and D are sums over the terms, each a power of y."""
        assert isinstance(limit.form, Modulus)
        model, output, line = limit.model, limit.form.output, limit.form.drives[0].lines[0]
        omega = line.order * speeds
        powers = np.round(model.exponents[:, 0] * self.root).astype(int)
        parts = (powers[:, None] == np.arange(powers.max(initial=0) + 1)) * model.vectors[:, :1]
        sizes = model.scales * self.reference ** model.exponents[:, 0]
        z = sizes * factors(model.kinds, omega)
        top, bottom = (z * output.signs) @ parts, z @ (parts * model.vectors[:, :1])
        top[:, 0] += output.row[0]
        top *= (np.abs(line.amplitude.at(speeds) * line.vector[0]) * omega**output.power)[:, None]
        rows = []
        for n, d in zip(top, bottom, strict=True):
            row = (np.convolve(n, n.conj()) - limit.bound**2 * np.convolve(d, d.conj())).real
            rows.append(sign_of(limit) * row / max(float(np.abs(row).max()), 1e-300))
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


@dataclass(frozen=True)
class PlaneRows:
    """Rows of a program with one mass, one stiffness k (index 0 of `order`) and one damping c.

    order
        Indices of k and c among the variables.
    many
        Number of identical mounts.
    known
        Transfers met so far, by form.
    """

    program: Program
    order: tuple[int, int]
    many: float
    known: dict[int, tuple[ComplexArray, ComplexArray, ComplexArray]] = field(default_factory=dict, compare=False)

    @classmethod
    def of(cls, program: Program) -> PlaneRows | None:
        """The rows, or None where the variables are not one stiffness and one damping in parallel."""
        model = program.model
        if model.n_free != 1 or len(program.axes) != 2:
            return None
        variable = [term for term in model.terms if term.exponents.any()]
        springs = [term for term in variable if term.kind == STIFFNESS]
        dampers = [term for term in variable if term.kind == DAMPING]
        if len(springs) != 1 or len(dampers) != 1 or len(variable) != 2:
            return None
        k, c = int(springs[0].exponents.argmax()), int(dampers[0].exponents.argmax())
        plain = springs[0].exponents.sum() == 1.0 and dampers[0].exponents.sum() == 1.0
        same = np.array_equal(springs[0].vector, dampers[0].vector) and springs[0].owner == dampers[0].owner
        if not plain or not same or k == c or springs[0].scale != dampers[0].scale:
            return None
        return cls(program, (k, c), springs[0].scale)

    def accepts(self, limit: Limit) -> bool:
        """Whether the limit is a row linear in c^2."""
        form = limit.form
        if not single_lines(limit) or (limit.model.exponents < 0.0).any():
            return False
        if isinstance(form, Monomials):
            return len(form.scale) == 1 and self._single(form) is not None
        if isinstance(form, ModeFrequency | ModeDamping):
            return form.mode == 1 and not _fixed(self.program.model, DAMPING)
        if isinstance(form, StaticRow):
            return True
        assert isinstance(form, Modulus)
        speeds = np.array([max(form.drives[0].bands[0].high, 1e-3)])
        return self._modulus(limit, speeds) is not None

    def _single(self, form: Monomials) -> int | None:
        """Index of the only variable of a monomial of power one; None for anything else."""
        used = np.flatnonzero(form.exponents[0])
        return int(used[0]) if len(used) == 1 and form.exponents[0, used[0]] == 1.0 else None

    def at(self, limit: Limit, speeds: FloatArray) -> FloatArray:
        """alpha, beta, gamma, delta per speed, shape (n, 4); k and c of one single mount."""
        form, sign = limit.form, sign_of(limit)
        if isinstance(form, Monomials):
            bound = limit.bound / form.scale[0]
            on_k = self._single(form) == self.order[0]
            row = [0.0, 1.0, -bound, 0.0] if on_k else [0.0, 0.0, -(bound**2), 1.0]
            return sign * np.array([row])
        model, many = self.program.model, self.many
        k0, m = _fixed(model, STIFFNESS), _fixed(model, INERTIA)
        if isinstance(form, ModeFrequency):
            return sign * np.array([[0.0, many, k0 - limit.bound**2 * m, 0.0]])
        if isinstance(form, ModeDamping):
            z = 4.0 * limit.bound**2 * m
            return sign * np.array([[0.0, -z * many, -z * k0, many**2]])
        if isinstance(form, StaticRow):
            made = sample(limit, speeds, self.program.high)
            size = made.scale[0, 0] if made.scale.size else 1.0
            top, bottom = abs(made.top[0, 0]), made.bottom[0].real
            return sign * np.array(
                [[0.0, -limit.bound * bottom[1] / size * _static(model), top - limit.bound * bottom[0], 0.0]]
            )
        rows = self._modulus(limit, speeds)
        assert rows is not None
        return rows

    def _modulus(self, limit: Limit, speeds: FloatArray) -> FloatArray | None:
        assert isinstance(limit.form, Modulus)
        line, many = limit.form.drives[0].lines[0], self.many
        top, top_slope, bottom = self._transfer(limit)
        omega = line.order * speeds
        s: ComplexArray = np.asarray(1j * omega)
        size = np.abs(line.amplitude.at(speeds)) * omega**limit.form.output.power
        a_n, b_n = _power_series(top, s) * size, _power_series(top_slope, s) * (size * many)
        a_d = _power_series(bottom, s)
        for a, b in ((a_n, b_n), (a_d, many)):
            if np.any(np.abs((np.conj(a) * b).imag) > 1e-12 * np.abs(a) * np.abs(b)):
                return None
        square = limit.bound**2
        alpha = _square(b_n) - square * many**2
        beta = 2.0 * ((np.conj(a_n) * b_n).real - square * many * a_d.real)
        gamma = _square(a_n) - square * _square(a_d)
        rows = np.array([alpha, beta, gamma, alpha * omega**2]).T
        return sign_of(limit) * rows

    def _transfer(self, limit: Limit) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """N at no mount, dN per dynamic stiffness of the mounts, and D at no mount, ascending in s = i w."""
        key = id(limit.form)
        if key not in self.known:
            assert isinstance(limit.form, Modulus)
            model, line, output = limit.model, limit.form.drives[0].lines[0], limit.form.output
            variable = model.exponents.any(axis=1)
            fixed = np.where(variable, 0.0, model.scales)
            typical = float(model.scales[~variable].max())
            one = np.where(variable & (model.kinds == STIFFNESS), typical, fixed)
            none, some = numerator(model, fixed, output, line), numerator(model, one, output, line)
            stiff = _fixed(model, STIFFNESS) + 1j * _fixed(model, HYSTERETIC)
            bottom = np.array([stiff, _fixed(model, DAMPING), _fixed(model, INERTIA)])
            self.known[key] = (none, _plus(some, -none) / typical, bottom)
        return self.known[key]


def _power_series(coefficients: ComplexArray, s: ComplexArray) -> ComplexArray:
    value = np.full(s.shape, coefficients[-1])
    for one in coefficients[-2::-1]:
        value = value * s + one
    return value


def _square(value: ComplexArray) -> FloatArray:
    square: FloatArray = value.real**2 + value.imag**2
    return square


def _static(model: Model) -> float:
    """Static stiffness of the whole group per stiffness of one single mount."""
    return next(term.static_scale for term in model.terms if term.kind == STIFFNESS and term.exponents.any())


def _fixed(model: Model, kind: int) -> float:
    """Sum of the fixed terms of one kind on the one coordinate."""
    return float(
        sum(term.scale * term.vector[0] ** 2 for term in model.terms if term.kind == kind and not term.exponents.any())
    )


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
