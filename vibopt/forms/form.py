"""What every form answers: each says what a method asks of it, or that it has no such thing."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import field
from typing import TYPE_CHECKING

import numpy as np

from vibopt.records import dataclass

if TYPE_CHECKING:
    from vibopt.arrays import FloatArray
    from vibopt.forms.modulus import Modulus
    from vibopt.forms.monomials import Monomials
    from vibopt.forms.reduce import Reach
    from vibopt.forms.tangents import Tangent
    from vibopt.mechanics.model import Model
    from vibopt.signals import Drive

_STEP = 1e-6
WITHOUT_END = 1e30


@dataclass(frozen=True, slots=True)
class Worst:
    """Value of a form [SI], and per excitation the speed [rad/s] at which it is reached."""

    value: float
    speeds: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Local:
    """One local extreme of a form.

    value
        Log of the form's value; inf at an undamped resonance.
    slope
        d value / d log x, shape (n_vars,).
    speeds
        Speed per excitation [rad/s].
    bend
        Its second derivative in log x, shape (n_vars, n_vars), the peak's own motion in it; None where not known.
    """

    value: float
    slope: FloatArray
    speeds: tuple[float, ...] = ()
    bend: FloatArray | None = None


class Form:
    """A number that a machine has at a design.

    Designs x (n_vars,) are positive, slopes and bends those of its log in log x.
    """

    __slots__ = ()

    @property
    def drives(self) -> tuple[Drive, ...]:
        """The excitations over whose speeds it is the worst; none where it knows no speeds."""
        return ()

    @property
    def harmonic(self) -> Modulus | None:
        """Itself where it is a response over speeds."""
        return None

    @property
    def powers(self) -> Monomials | None:
        """Itself where it is a sum of powers of the variables, which needs no machine."""
        return None

    def value(self, model: Model, x: FloatArray) -> float:
        """At a design; infinite where it has no end."""
        raise NotImplementedError(f"{type(self).__name__} has no value")

    def worst(self, model: Model, x: FloatArray, *, least_wanted: bool = False) -> Worst:
        """The greatest value (the least with `least_wanted`) over its speeds, and where it is."""
        return Worst(self.value(model, x))

    def slope(self, model: Model, x: FloatArray) -> FloatArray:
        """Of a form that knows no speeds, shape (n_vars,)."""
        return by_differences(lambda at: self.value(model, at), x)

    def bend(self, model: Model, x: FloatArray) -> FloatArray | None:
        """Second derivative of a form that knows no speeds (n_vars, n_vars), where it is had for little."""
        return None

    def extremes(self, model: Model, x: FloatArray, *, least_wanted: bool, within: float = 0.5) -> list[Local]:
        """Local extremes within a factor of the worst one, the worst first.

        Parameters
        ----------
        model, x
            Where, at a design (n_vars,).
        least_wanted
            Whether the least value is the worst.
        within
            Part of the greatest value that a peak must have to be counted.
        """
        return [Local(log_of(self.value(model, x)), self.slope(model, x), bend=self.bend(model, x))]

    def tangents(
        self, model: Model, x: FloatArray, reach: FloatArray, level: float = WITHOUT_END, times: Sequence[float] = ()
    ) -> Iterator[Tangent]:
        """What it is no less than where x is off by at most `reach` (n_vars,) of itself; the first is its value at x.

        Only of forms that have `tangents_of`; `level` and `times` [s] say where it is worth looking.
        """
        return iter(())

    @property
    def tangents_of(self) -> tuple[float, ...]:
        """Signs with which it has tangents: 1 where bounds from below are known, -1 those of its negative."""
        return ()

    def reach(self, model: Model) -> Reach | None:
        """What moves the machine and what is read of it, where no other motion has a part in it."""
        return None

    def cost(self, model: Model) -> float:
        """Work of measuring it at one design [nominal ms]: an eigenproblem grows with the square of the coordinates."""
        return 0.3 + 0.01 * model.n_free**2


def by_differences(value: Callable[[FloatArray], float], x: FloatArray) -> FloatArray:
    """Slope of the log of a value in log x by central differences."""
    slope = np.zeros(len(x))
    for i in range(len(x)):
        up, down = x.copy(), x.copy()
        up[i] *= 1.0 + _STEP
        down[i] *= 1.0 - _STEP
        slope[i] = (log_of(value(up)) - log_of(value(down))) / (2.0 * _STEP)
    return np.nan_to_num(slope, posinf=0.0, neginf=0.0)


def bend_of_slopes(form: Form, model: Model, x: FloatArray) -> FloatArray:
    """Second derivative by differences of exact slopes, shape (n_vars, n_vars)."""
    turns = np.exp(1e-5 * np.eye(len(x)))
    up, down = (np.array([form.slope(model, one) for one in every]) for every in (x * turns, x / turns))
    rows = (up - down) / 2e-5
    return np.asarray(0.5 * (rows + rows.T))


def log_of(value: float) -> float:
    """Log, and of nothing a number without end."""
    return float(np.log(value)) if value > 0.0 else -WITHOUT_END
