"""From which spin on the whirl of a rotor grows, and how its free whirls are damped."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.forms.form import Form, by_differences, kept
from vibopt.mechanics.bearings import whirling
from vibopt.mechanics.free_whirls import (
    Synchronous,
    damping_ratios,
    decrements,
    free_whirls,
    least_damped,
    synchronous,
)
from vibopt.mechanics.model import DAMPING, INERTIA, STIFFNESS, Model
from vibopt.mechanics.modes import free_matrices
from vibopt.mechanics.orbits import spun
from vibopt.mechanics.whirl import Neutral, rotor_threshold, threshold
from vibopt.records import dataclass

_END = 0.99
"""Part of the highest spin that is looked at, from which on a growth may lie beyond it as well."""


@dataclass(frozen=True, slots=True)
class WhirlThreshold(Form):
    """Least spin [rad/s] beyond which a whirl grows; infinite where none does.

    top
        Highest spin that is looked at of a rotor in bearings that are not alike in both planes [rad/s]; 0 where nobody
        says one.
    """

    top: float = 0.0
    dear = True
    no_bounds = "is a threshold of whirl: the poles of what spins have no bounds on boxes of designs"
    not_convex = "is a threshold of whirl, which is not convex in stiffness and damping"
    rough = "is the least threshold of several whirls, which has a kink where two of them are equal"

    def acting(self, model: Model) -> FloatArray:
        return of_whirls(model)

    def slope(self, model: Model, x: FloatArray) -> FloatArray:
        if model.bearings or not model.spins:
            return np.zeros(len(x)) if np.isinf(self.value(model, x)) else Form.slope(self, model, x)
        neutral = self._neutral(model, x)
        if not len(neutral.motion):
            return np.zeros(len(x)) if np.isinf(neutral.spin) else Form.slope(self, model, x)
        change = _changes(model, x, neutral.whirl, neutral.spin, neutral.motion, neutral.motion)
        both = np.array([neutral.by_whirl, neutral.by_spin])
        moved: FloatArray = np.linalg.solve([both.real, both.imag], -np.array([change.real, change.imag]))[1]
        return moved / neutral.spin

    def room(self, model: Model, x: FloatArray, value: float, other: float, rounding: float) -> float:
        """As of all, and all of it where one route finds a growth that begins where the other looks no farther."""
        least = min(value, other)
        return least if least >= _END * self.top > 0.0 else Form.room(self, model, x, value, other, rounding)

    def value(self, model: Model, x: FloatArray) -> float:
        if model.bearings:
            return spun(model, x).threshold(self.top)
        if model.spins:
            return self._neutral(model, x).spin
        mass, damping, stiffness, _ = free_matrices(model, model.values(x))
        return threshold(mass, damping, model.turning(x), stiffness)

    def _neutral(self, model: Model, x: FloatArray) -> Neutral:
        """Of a rotor in supports that are alike in both planes."""

        def found(each: FloatArray) -> list[Neutral]:
            both = []
            for one in each:
                p = model.values(one)
                mass, damping, stiffness, _ = free_matrices(model, p)
                turns = np.array([term.polar for term in model.terms])
                polar = -model.matrix(INERTIA, np.where(turns, p, 0.0))[: model.n_free, : model.n_free]
                both.append(rotor_threshold(mass + polar, polar, damping, model.turning(one), stiffness))
            return both

        return kept(model, self, np.asarray(x)[None], found)[0]


@dataclass(frozen=True, slots=True)
class WhirlDamping(Form):
    """Least damping of free whirls over spins: logarithmic decrement, or `ratio` over critical; infinite of none.

    bands
        Low and high spins [rad/s].
    top
        Frequency up to which whirls count [rad/s].
    sense
        1 of whirls with the spin, -1 of those against it, 0 of both.
    number
        Of the least damped ones, 1 is the least.
    """

    ratio: bool
    bands: tuple[tuple[float, float], ...]
    top: float
    sense: float
    number: int
    dear = True
    no_bounds = "is a damping of whirls: the poles of what spins have no bounds on boxes of designs"
    not_convex = "is a damping of whirls, which is not convex in stiffness and damping"
    rough = "is the least damping of several whirls, which has a kink where two of them are equal"

    def acting(self, model: Model) -> FloatArray:
        return of_whirls(model)

    def slope(self, model: Model, x: FloatArray) -> FloatArray:
        """That of the one whirl that says the value, at its spin: where that is the least of a range it stays so."""
        value, spin = self._least(model, x)
        if np.isinf(value):
            return np.zeros(len(x))
        if value <= 0.0:
            return Form.slope(self, model, x)
        rotor = spun(model, x)
        found = free_whirls(rotor, spin, self.top)
        off = np.where(found.senses * self.sense >= 0.0, np.abs(self._measure(found.rates) - value), np.inf)
        rate, motion = complex(found.rates[off.argmin()]), found.ways[off.argmin()]
        first, second = rotor.powers(spin)
        force = rotor.balanced(rate, spin) if model.bearings else motion
        halves = zip((1.0, -1.0), np.split(force, 2), np.split(motion, 2), strict=True)
        change = _of_bearings(model, x, rate, force, motion)
        change = change + sum(_changes(model, x, rate, sense * spin, *half) for sense, *half in halves)
        moved = np.asarray(-change / (force @ (first + 2.0 * rate * second) @ motion))
        damping = (moved.imag - (rate.imag / rate.real) * moved.real) / rate.real  # of Im w / Re w
        if not self.ratio:
            return np.asarray(2.0 * np.pi * damping / value)
        return np.asarray(damping * (rate.real / abs(rate)) ** 3 / value)

    @property
    def _measure(self) -> Callable[[ComplexArray], FloatArray]:
        return damping_ratios if self.ratio else decrements

    def _least(self, model: Model, x: FloatArray) -> tuple[float, float]:
        """The value, and its spin [rad/s]."""

        def found(each: FloatArray) -> list[tuple[float, float]]:
            asked = self.top, self.sense, self.number, self._measure
            return [min(least_damped(spun(model, one), band, *asked) for band in self.bands) for one in each]

        return kept(model, self, np.asarray(x)[None], found)[0]

    def value(self, model: Model, x: FloatArray) -> float:
        return self._least(model, x)[0]


def _changes(
    model: Model, x: FloatArray, rate: complex, spin: float, force: ComplexArray, motion: ComplexArray
) -> ComplexArray:
    """f^T D u by log x, (n_vars,), of the resistance D to a whirl e^{i w t} with the spin; against one below zero.

    Without bearings that couple both; f is u (n_free,) where there are none.
    """
    kinds = model.kinds
    factor = np.select([kinds == STIFFNESS, kinds == DAMPING, kinds == INERTIA], [1.0, 1j * rate, -(rate**2)], 0.0)
    factor = np.where([term.polar for term in model.terms], -rate * spin, factor)
    pushed, read = (model.vectors[:, : model.n_free] @ one for one in (force, motion))
    change = (factor * model.values(x) * pushed * read) @ model.exponents
    for term in model.rotating:
        size = term.scale * np.where(term.exponents == 0.0, 1.0, x**term.exponents).prod()
        row = term.vector[: model.n_free]
        change = change + 1j * (rate - spin) * size * (row @ force) * (row @ motion) * term.exponents
    return np.asarray(change)


def _of_bearings(model: Model, x: FloatArray, rate: complex, force: ComplexArray, motion: ComplexArray) -> ComplexArray:
    """As `_changes` of the bearings that couple forward and backward whirl, f and u (2 n_free,); tables are facts."""
    change = np.zeros(len(x), dtype=complex)
    for bearing in model.bearings:
        if not bearing.powers:
            continue
        eight = bearing.coefficients(x, np.zeros(()))
        by = eight * np.array([power.row(len(x)) for power in bearing.powers]).T  # (n_vars, 8)
        both = whirling(by[:, :4]) + 1j * rate * whirling(by[:, 4:])
        pushed, read = (np.reshape(one, (2, -1)) @ bearing.row[: model.n_free] for one in (force, motion))
        change += np.einsum("i,vij,j->v", pushed, both, read)
    return change


@dataclass(frozen=True, slots=True)
class DampedCriticalSpeed(Form):
    """Speed at which a damped whirl is as fast as the spin, number `mode` [rad/s]; infinite of none.

    With mode 0 how far all are from bands: the least of low / speed or speed / high, one at an edge, less inside.

    sense
        1 of whirl with the spin, -1 against it, 0 of both.
    bands
        Low and high ends [rad/s].
    top
        Spin up to which is looked; 0 where a mode says when it is enough.
    """

    sense: float
    mode: int
    bands: tuple[tuple[float, float], ...]
    top: float
    dear = True
    no_bounds = "is a damped critical speed: the poles of what spins have no bounds on boxes of designs"
    not_convex = "is a damped critical speed, which is not convex in stiffness and damping"
    rough = "is a damped critical speed, which is there from some damping on, and gone beyond"

    def every(self, model: Model, x: FloatArray) -> FloatArray:
        """All that are looked for, ascending [rad/s]."""
        return np.array([synchronous.speed for synchronous in self._met(model, x)])

    def _met(self, model: Model, x: FloatArray) -> list[Synchronous]:
        def found(each: FloatArray) -> list[list[Synchronous]]:
            return [synchronous(spun(model, one), self.sense, self.top, self.mode) for one in each]

        return kept(model, self, np.asarray(x)[None], found)[0]

    def acting(self, model: Model) -> FloatArray:
        return of_whirls(model)

    def slope(self, model: Model, x: FloatArray) -> FloatArray:
        """That of the one whirl that says the value, followed alone."""
        met = self._met(model, x)
        if not self._of([one.speed for one in met]) < np.inf:
            return np.zeros(len(x))
        one = met[self.mode - 1] if self.mode else min(met, key=lambda each: apart([each.speed], self.bands))

        def value(y: FloatArray) -> float:
            speed = one.moved(spun(model, y))
            if np.isnan(speed):
                return self.value(model, y)
            return speed if self.mode else apart([speed], self.bands)

        return by_differences(value, x)

    def value(self, model: Model, x: FloatArray) -> float:
        return self._of([synchronous.speed for synchronous in self._met(model, x)])

    def _of(self, speeds: list[float]) -> float:
        if self.mode:
            return speeds[self.mode - 1] if len(speeds) >= self.mode else float("inf")
        return apart(speeds, self.bands)


def apart(speeds: list[float], bands: tuple[tuple[float, float], ...]) -> float:
    """How far speeds are from bands: the least of low / speed or speed / high; infinite of none."""
    each = [max(low / speed, speed / high) for speed in speeds for low, high in bands]
    return float(min(each, default=np.inf))


def of_whirls(model: Model) -> FloatArray:
    """Exponents of all that free whirls hang on, (n, n_vars)."""
    rows = [term.exponents for term in model.rotating]
    rows += [power.row(model.n_vars) for bearing in model.bearings for power in bearing.powers]
    own = model.exponents[np.isin(model.kinds, (STIFFNESS, INERTIA, DAMPING))]
    return np.vstack([own, *rows])
