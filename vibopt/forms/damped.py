"""Forms of free vibration with its damping: ratios and rates of the modes, motion after a start."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.forms.form import ROOTS, Form, Local, by_differences, log_of, plus
from vibopt.forms.rational import Groups
from vibopt.mechanics.model import DAMPING, INERTIA, STIFFNESS
from vibopt.mechanics.modes import damping_ratios, decay_rates, free_matrices, held_poles, pole_slopes
from vibopt.records import dataclass

if TYPE_CHECKING:
    from vibopt.arrays import IntArray
    from vibopt.forms.asking import ConvexRows, OneVariable
    from vibopt.forms.bounds import FormBounds
    from vibopt.forms.form import Bounds
    from vibopt.mechanics.model import Model

_NEAR = 2.0
"""Poles with up to so many times the least decay rate (damping ratio) are pieces of their own."""
_ROUNDING = 1e-14
"""Part of the numbers of a machine that is rounding."""
_SWINGS = 1.0 - 1e-12
"""Damping ratio up to which a slope of the logarithmic decrement is told."""
_MEET = 1e-5
"""Part of a goal that boxes leave open: where two poles meet, rounding moves each by its root."""


class OfPoles(Form):
    """The least of a number that every pole of free vibration has."""

    __slots__ = ()
    relative: ClassVar[bool] = False
    """Whether the number is a part of the pole's size."""

    @property
    def poles(self) -> OfPoles:
        return self

    def meet(self, model: Model) -> bool:
        """Whether its best may lie where poles meet."""
        return True

    def closed_to(self, model: Model) -> float:
        return _MEET * (model.n_free > 1)

    def level(self, rates: ComplexArray) -> FloatArray:
        """The number of poles e^{s t} by their rates s (m,)."""
        raise NotImplementedError(f"{type(self).__name__} is no number of a pole")

    def most_within(self, rates: ComplexArray, radii: FloatArray) -> FloatArray:
        """The most that the number of a pole can be so near to rates s (m,) [1/s], (m,)."""
        raise NotImplementedError(f"{type(self).__name__} is no number of a pole")

    def place(self, level: FloatArray, height: FloatArray) -> ComplexArray:
        """Rates (...) of poles with such a number, so far from the real axis or, where relative, from zero."""
        raise NotImplementedError(f"{type(self).__name__} is no number of a pole")

    def moved(self, model: Model, x: FloatArray) -> float:
        """By how much rounding moves the least number: a pole by a part of its size, of m that meet its m-th root."""
        rates = 1j * held_poles(model, model.values(x))
        if not len(rates):
            return 0.0
        least = rates[self.level(rates).argmin()]
        reach = _ROUNDING ** (1.0 / np.arange(1, len(rates) + 1))
        meet = np.sort(np.abs(rates - least)) <= 2.0 * reach * abs(least)
        return float(reach[meet].max(initial=0.0)) * (1.0 if self.relative else float(abs(least)))

    def slope(self, model: Model, x: FloatArray) -> FloatArray:
        pieces = self._pieces(model, x)
        if pieces and pieces[0][0] > 0.0:
            return pieces[0][1] / pieces[0][0]
        return by_differences(lambda at: self.value(model, at), x)

    def extremes(self, model: Model, x: FloatArray, *, least_wanted: bool, within: float = 0.5) -> list[Local]:
        """As of every form; every pole near the least is a piece of its own, the least first.

        Two poles that meet have no slope where they do; beside that, each has one.
        """
        pieces = self._pieces(model, x) if least_wanted else []
        if not pieces:
            return [Local(log_of(self.value(model, x)), self.slope(model, x))]
        return [
            Local(log_of(value), slope / value if value > 0.0 else 0.0 * slope, (speed,))
            for value, slope, speed in pieces
        ]

    def _pieces(self, model: Model, x: FloatArray) -> list[tuple[float, FloatArray, float]]:
        """The number of every pole near the least, its slope in log x, and |s|; the least first."""
        values, slopes, sizes = self._each(model, x)
        order = [i for i in np.argsort(values) if values[i] <= _NEAR * values.min()] if len(values) else []
        return [(float(values[i]), slopes[i], float(sizes[i])) for i in order]

    def _each(self, model: Model, x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """The number of every pole (m,), its slopes (m, n_vars), and |s| (m,); none where they say nothing."""
        raise NotImplementedError(f"{type(self).__name__} is no number of a pole")


@dataclass(frozen=True, slots=True)
class DecayRate(OfPoles):
    """Least decay rate of free vibration, -max Re(pole) [1/s]; rigid motion, which nothing calls back, is left out."""

    no_bounds = "is a decay rate: of up to three variables and six coordinates, held or free, poles have bounds"
    not_convex = "is a decay rate, which is not convex in stiffness and damping"
    rough = "is the least decay rate of several modes, which has a kink where two of them are equal"

    def bounded(self, model: Model) -> bool:
        from vibopt.forms.poles_on_boxes import bounded

        return bounded(model)

    def groups(self, model: Model) -> Groups:
        return Groups.of(model)

    def on_boxes(self, known: FormBounds, low: FloatArray, high: FloatArray) -> Bounds:
        from vibopt.forms.poles_on_boxes import on_boxes

        if known.model.n_free > 1:
            return on_boxes(self, known, low, high)
        (m, k, c), (big, stiff, damped) = _sums(known.model, low, high)
        with np.errstate(divide="ignore", invalid="ignore"):  # the rate is the lesser, above critical or below
            slow = [2.0 * k / (damped + np.sqrt(np.maximum(damped**2 - 4.0 * k * m, 0.0))), damped / (2.0 * m)]
            fast = [c / (2.0 * big), 2.0 * stiff / (c + np.sqrt(np.maximum(c**2 - 4.0 * stiff * big, 0.0)))]
        return np.fmin(slow[0], fast[0]), np.fmin(slow[1], fast[1])

    def known(self, at: FormBounds) -> bool:
        return at.model.n_free == 1

    def room(self, model: Model, x: FloatArray, value: float, other: float, rounding: float) -> float:
        fastest = float(np.abs(held_poles(model, model.values(x))).max(initial=0.0))
        return max(ROOTS * fastest, self.moved(model, x))

    def said(self, model: Model, order: IntArray) -> tuple[Any, ...]:
        return ()

    def value(self, model: Model, x: FloatArray) -> float:
        return float(decay_rates(model, model.values(x)).min(initial=np.inf))

    def level(self, rates: ComplexArray) -> FloatArray:
        return np.asarray(-rates.real)

    def most_within(self, rates: ComplexArray, radii: FloatArray) -> FloatArray:
        return np.asarray(radii - rates.real)

    def place(self, level: FloatArray, height: FloatArray) -> ComplexArray:
        return -level + 1j * height

    def _each(self, model: Model, x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        rates, slopes = pole_slopes(model, x)
        values = -rates.real
        if len(values):
            values = np.maximum(values, decay_rates(model, model.values(x)).min())
        return values, -slopes.real, np.abs(rates)


@dataclass(frozen=True, slots=True)
class ModeDamping(OfPoles):
    """Damping ratio of the `mode`-th least damped mode (1 is the least)."""

    mode: int
    relative = True
    one_line = True
    no_bounds = "is a damping ratio: the least of up to three variables and six coordinates, held or free, has bounds"
    not_convex = "is a damping ratio of several modes, which is not convex in stiffness and damping"
    rough = ""

    def meet(self, model: Model) -> bool:
        return self.mode == 1 and model.n_free > 1

    def room(self, model: Model, x: FloatArray, value: float, other: float, rounding: float) -> float:
        return max(ROOTS, self.moved(model, x), Form.room(self, model, x, value, other, rounding))

    def said(self, model: Model, order: IntArray) -> tuple[Any, ...]:
        return (self.mode,)

    def polynomial(self, rows: OneVariable, model: Model, bound: float) -> FloatArray:
        """One mass: c^2 - 4 z^2 k m."""
        k, m, c = (rows.total(model, kind) for kind in (STIFFNESS, INERTIA, DAMPING))
        return plus(np.convolve(c, c), -4.0 * bound**2 * np.convolve(k, m))

    def is_polynomial(self, model: Model, most_degree: int) -> bool:
        return model.n_free == 1 and self.mode == 1

    def sampleable(self, model: Model) -> bool:
        return model.n_free == 1

    def not_smooth(self, model: Model) -> str:
        kink = "is the least of several damping ratios, which has a kink where two of them are equal"
        return kink if model.n_free > 1 else self.rough

    def bounded(self, model: Model) -> bool:
        from vibopt.forms.poles_on_boxes import bounded

        return model.n_free == 1 or (self.mode == 1 and bounded(model))

    def groups(self, model: Model) -> Groups | None:
        return Groups.of(model) if model.n_free > 1 else None

    def on_boxes(self, known: FormBounds, low: FloatArray, high: FloatArray) -> Bounds:
        from vibopt.forms.poles_on_boxes import on_boxes

        if known.model.n_free > 1:
            return on_boxes(self, known, low, high)
        (m, k, c), (big, stiff, damped) = _sums(known.model, low, high)
        with np.errstate(divide="ignore", invalid="ignore"):
            least, most = c / (2.0 * np.sqrt(stiff * big)), damped / (2.0 * np.sqrt(k * m))
        return np.nan_to_num(least, nan=0.0), np.nan_to_num(most, nan=np.inf, posinf=np.inf)

    def known(self, at: FormBounds) -> bool:
        return at.model.n_free == 1

    def convex_limit(self, rows: ConvexRows, limit: Any, sense: float, bound: float) -> Any:
        return rows.damping(limit, self, sense, self.ratio_of(bound)) if limit.model.n_free == 1 else None

    def value(self, model: Model, x: FloatArray) -> float:
        ratios = damping_ratios(model, model.values(x))
        return float(ratios[self.mode - 1]) if len(ratios) >= self.mode else float("inf")

    def level(self, rates: ComplexArray) -> FloatArray:
        return np.asarray(-rates.real / np.abs(rates))

    def most_within(self, rates: ComplexArray, radii: FloatArray) -> FloatArray:
        angle = np.abs(np.angle(-rates)) - np.arcsin(np.minimum(radii / np.abs(rates), 1.0))
        return np.where(angle > 0.0, np.cos(angle), np.inf)  # on the axis nothing swings, and there is no such number

    def place(self, level: FloatArray, height: FloatArray) -> ComplexArray:
        ratio = self.ratio_of(level)
        return np.asarray(height * (-ratio + 1j * np.sqrt(np.maximum(1.0 - ratio * ratio, 0.0))))

    def ratio_of(self, value: Any) -> Any:
        """The damping ratio that such a value is, or many."""
        return value

    def _each(self, model: Model, x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        nothing = np.zeros(0), np.zeros((0, model.n_vars)), np.zeros(0)
        if self.mode > 1:
            return nothing
        rates, slopes = pole_slopes(model, x)
        turning = rates.imag > 1e-9 * np.abs(rates)
        rates, slopes, size = rates[turning], slopes[turning], np.abs(rates)[turning]
        values = -rates.real / size
        along = (np.conj(rates)[:, None] * slopes).real / size[:, None] ** 2
        changes = -slopes.real / size[:, None] - values[:, None] * along
        return nothing if not len(values) or values.min() > 1.0 - 1e-9 else (values, changes, size)


@dataclass(frozen=True, slots=True)
class LogDecrement(ModeDamping):
    """Log of the ratio of two deflections one period apart in the `mode`-th least damped mode, 2 pi z / sqrt(1 - z^2).

    Infinite where nothing goes to and fro.
    """

    not_convex = "is a logarithmic decrement, which is not convex in stiffness and damping"
    rough = "is a logarithmic decrement, which has no end where nothing swings"

    @property
    def _least(self) -> ModeDamping:
        return ModeDamping(self.mode)

    def is_polynomial(self, model: Model, most_degree: int) -> bool:
        return False

    def room(self, model: Model, x: FloatArray, value: float, other: float, rounding: float) -> float:
        z = self._least.value(model, x)
        return 2.0 * np.pi * self._least.room(model, x, z, z, rounding) / float(max(1.0 - z**2, ROOTS) ** 1.5)

    def on_boxes(self, known: FormBounds, low: FloatArray, high: FloatArray) -> Bounds:
        least, most = self._least.on_boxes(known, low, high)
        return decrement(least), decrement(most)

    def value(self, model: Model, x: FloatArray) -> float:
        return float(decrement(np.array(self._least.value(model, x))))

    def level(self, rates: ComplexArray) -> FloatArray:
        return decrement(self._least.level(rates))

    def ratio_of(self, value: Any) -> Any:
        return value / np.hypot(value, 2.0 * np.pi)

    def slope(self, model: Model, x: FloatArray) -> FloatArray:
        return self._least.slope(model, x) / (1.0 - min(self._least.value(model, x), _SWINGS) ** 2)

    def extremes(self, model: Model, x: FloatArray, *, least_wanted: bool, within: float = 0.5) -> list[Local]:
        found = self._least.extremes(model, x, least_wanted=least_wanted, within=within)
        ratios = [min(float(np.exp(local.value)), _SWINGS) for local in found]
        return [
            Local(log_of(float(decrement(np.array(z)))), local.slope / (1.0 - z**2), local.speeds)
            for z, local in zip(ratios, found, strict=True)
        ]


def _sums(model: Model, low: FloatArray, high: FloatArray) -> list[list[FloatArray]]:
    """Least and greatest mass, stiffness and damping of one mass on boxes, (n_boxes,) each."""
    share = np.array([model.kinds == kind for kind in (INERTIA, STIFFNESS, DAMPING)]) * model.vectors[:, 0] ** 2
    return [[values @ one for one in share] for values in model.extent(low, high)]


def decrement(ratio: FloatArray) -> FloatArray:
    """Logarithmic decrement of damping ratios, any shape; infinite from one on."""
    with np.errstate(divide="ignore", invalid="ignore"):
        found = 2.0 * np.pi * ratio / np.sqrt(1.0 - ratio**2)
    return np.where(ratio >= 1.0, np.inf, found)


@dataclass(frozen=True, slots=True)
class FreeMotion(Form):
    """Motion row . u [m], with its sign, `after` a time [s] of free vibration.

    row (n_coords,); displacements [m] and velocities [m/s] at the start, (n_free,).
    """

    row: FloatArray
    displacements: FloatArray
    velocities: FloatArray
    after: float
    no_bounds = "is a motion at one time, which turns many times within a box of designs"
    not_convex = "is a motion at one time, which is not convex in stiffness and damping"
    rough = "is a motion at one time with its sign, which may be zero"

    def room(self, model: Model, x: FloatArray, value: float, other: float, rounding: float) -> float:
        begun = np.abs(self.displacements) + self.after * np.abs(self.velocities)
        return ROOTS * float(np.abs(self.row[: model.n_free]) @ begun)

    def value(self, model: Model, x: FloatArray) -> float:
        from scipy.linalg import expm

        n = model.n_free
        mass, damping, stiffness, _ = free_matrices(model, model.values(x))
        root = np.linalg.cholesky(mass)
        inverse = np.linalg.inv(root)
        own, drag = inverse @ stiffness @ inverse.T, inverse @ damping @ inverse.T
        rate = float(np.sqrt(np.abs(own).max(initial=0.0))) or 1.0
        state = np.block([[np.zeros((n, n)), rate * np.eye(n)], [-own / rate, -drag]])
        started = np.concatenate([root.T @ self.displacements, root.T @ self.velocities / rate])
        return float(self.row[:n] @ inverse.T @ (expm(self.after * state) @ started)[:n])
