"""A program: minimise or maximise a form, subject to forms within bounds, over a box."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms import Form
from vibopt.forms.form import Local, Worst
from vibopt.mechanics.model import Model
from vibopt.records import dataclass

Side = Literal["at_most", "at_least", "outside"]

_ROUNDING, _LEFT = 1e-12, 1e-6
"""Part of a goal that rounding may take, and least part of a bound that is looked at by itself."""


class Asked:
    """A form on the smallest model that it needs, and which of its values is the worst."""

    __slots__ = ()
    model: Model
    form: Form

    @property
    def least_wanted(self) -> bool:
        """Whether the least value over the speeds is the worst."""
        raise NotImplementedError(f"{type(self).__name__} does not say which value is the worst")

    @property
    def cost(self) -> float:
        """Work of measuring it at one design, on one machine [nominal ms]."""
        return self.form.cost(self.model)

    def worst(self, x: FloatArray) -> Worst:
        """The worst value over its speeds at a design x (n_vars,), and where it is."""
        return self.form.worst(self.model, x, least_wanted=self.least_wanted)

    def values(self, x: FloatArray) -> FloatArray:
        """The worst value over its speeds at designs x (n, n_vars), shape (n,)."""
        return self.form.values(self.model, x, least_wanted=self.least_wanted)

    def extremes(self, x: FloatArray, within: float = 0.5) -> list[Local]:
        """Local extremes within a factor of the worst one, the worst first."""
        return self.form.extremes(self.model, x, least_wanted=self.least_wanted, within=within)

    def candidates(self, x: FloatArray) -> list[tuple[tuple[float, ...], float]]:
        """As `Form.candidates`."""
        return self.form.candidates(self.model, x, least_wanted=self.least_wanted)


@dataclass(frozen=True, slots=True)
class Limit(Asked):
    """form <= bound, form >= bound, or every value of it outside (bound, upper) [SI].

    name
        Name of the limit in the file.
    model
        The smallest model that this form needs.
    side
        In terms of the form: an isolation of at least 80 % is a transmissibility of at most 0.2.
    complement
        The user's value is one minus the form's value.
    soft
        How easily it may be loosened, beside 1 of others.
    of_bands
        Whether the form is how far all values are from the bands of the file, one at an edge.
    """

    name: str
    model: Model
    form: Form
    side: Side
    bound: float
    upper: float = 0.0
    complement: bool = False
    soft: float = 1.0
    of_bands: bool = False

    @property
    def least_wanted(self) -> bool:
        return self.side == "at_least"

    @property
    def user_side(self) -> str:
        """The side as the user counts it: an isolation of at least 80 % is a transmissibility of at most 0.2."""
        if self.of_bands:
            return "outside"
        return {"at_most": "at_least", "at_least": "at_most"}[self.side] if self.complement else self.side

    def of_what_varies(self) -> Limit:
        """The same limit on a sum of powers without the part that no variable changes: both sides have that less.

        A log of the whole, of which a heavy machine is nearly all, hardly moves with what is chosen.  Where next to
        nothing is left the rounding of the whole would be felt in it, and the limit stays as it is.
        """
        powers = self.form.powers
        if powers is None or self.side == "outside":
            return self
        varied = powers.exponents.any(axis=1)
        bound = self.bound - float(powers.scale[~varied].sum())
        if varied.all() or not varied.any() or not _LEFT * self.bound < bound < np.inf:
            return self
        return replace(
            self, form=replace(powers, scale=powers.scale[varied], exponents=powers.exponents[varied]), bound=bound
        )

    def missed(self, value: float) -> float:
        """How far a value misses the bound, as a part of it; below zero where it is kept."""
        size = abs(self.bound) or 1.0
        if self.side == "at_most":
            return (value - self.bound) / size if np.isfinite(value) else np.inf
        return (self.bound - value) / size if np.isfinite(value) else -np.inf


@dataclass(frozen=True, slots=True)
class Aim(Asked):
    """What is made best: sense is +1 to minimise the form and -1 to maximise it.

    With `others`, the same goal on other machines, the worst of all of them counts.
    """

    name: str
    model: Model
    form: Form
    sense: float
    complement: bool = False
    others: tuple[Aim, ...] = ()

    @property
    def least_wanted(self) -> bool:
        return self.sense < 0.0

    def direction(self, index: int) -> float | None:
        """Sense in which a variable is wanted to go: +1 up, -1 down; None where it is not that simple."""
        rises = self.form.rises(self.model, index)
        return None if rises is None else -self.sense * rises

    @property
    def pieces(self) -> tuple[Aim, ...]:
        """The goal on each of the machines that count, by itself."""
        return (replace(self, others=()), *self.others) if self.others else (self,)


@dataclass(frozen=True, slots=True)
class Axis:
    """One design variable: range [SI], or the discrete values to choose from.

    open_low, open_high
        Whether an end of the range only stands for zero or for infinity.
    """

    path: str
    low: float
    high: float
    values: tuple[float, ...] | None = None
    open_low: bool = False
    open_high: bool = False

    @property
    def rest(self) -> float:
        """Of the factors of a number that may be off the one nearest to one: as said, where that may be built."""
        return min(max(1.0, self.low), self.high)


@dataclass(frozen=True, slots=True)
class Tie:
    """Variables that take their values together from one row of a table: a part of a catalogue.

    path
        Of the part in the file.
    axes
        Indices of the variables, one a column of the table.
    table
        Values [SI], shape (n_parts, n_axes).
    names
        Name of each part; none where it is the values of one variable.
    """

    path: str
    axes: tuple[int, ...]
    table: FloatArray
    names: tuple[str, ...]

    def chosen(self, x: FloatArray) -> int:
        """Index of the part that a design x (n_vars,) has; the first of those that are alike."""
        return int(np.abs(self.table - np.asarray(x)[list(self.axes)]).max(axis=1, initial=0.0).argmin())


@dataclass(frozen=True, slots=True)
class Program:
    """The whole question.

    model
        The full mechanical model; every limit carries the part of it that it needs.
    several
        Whether the limits speak of several machines: the same design with its numbers off in different ways.
    ties
        Variables that take their values together.
    room
        Names of the limits whose least margin is made greatest, which is the goal then; empty where it is another.
    """

    model: Model
    axes: tuple[Axis, ...]
    limits: tuple[Limit, ...]
    aim: Aim | None
    several: bool = False
    ties: tuple[Tie, ...] = ()
    room: tuple[str, ...] = ()

    @property
    def parts(self) -> list[Limit | Aim]:
        """The limits, and the goal behind them where there is one."""
        return [*self.limits, *(self.aim.pieces if self.aim is not None else ())]

    @property
    def doubts(self) -> str:
        """What of its values is found by a search and not proven, in words; "" where nothing is."""
        searched = sorted({part.form.searched for part in self.parts} - {""})
        return f"{', '.join(searched)} and not proven" if searched else ""

    @property
    def cost(self) -> float:
        """Work of measuring all of it at one design [nominal ms]."""
        return sum(part.cost for part in self.parts)

    @property
    def used_dof(self) -> int:
        """Greatest number of free coordinates that any question needs."""
        return max((part.model.n_free for part in self.parts if part.form.powers is None), default=0)

    @property
    def low(self) -> FloatArray:
        return np.array([axis.low for axis in self.axes])

    @property
    def high(self) -> FloatArray:
        return np.array([axis.high for axis in self.axes])

    @property
    def ranged(self) -> Axis | None:
        """The first variable that may be any value of a range, and is none of a part."""
        tied = {index for tie in self.ties for index in tie.axes}
        return next((axis for i, axis in enumerate(self.axes) if axis.values is None and i not in tied), None)

    def is_best(self, goal: float) -> bool:
        """Whether a goal, in the sense to be minimised, is the best that the ranges alone permit.

        Known of what needs no machine: a stiffness, a mass, a price.
        """
        powers = None if self.aim is None or self.aim.others else self.aim.form.powers
        if self.aim is None or powers is None or not (powers.scale > 0.0).all():
            return False
        low = np.array([0.0 if axis.open_low else axis.low for axis in self.axes])
        high = np.array([np.inf if axis.open_high else axis.high for axis in self.axes])
        with np.errstate(invalid="ignore"):
            least, most = powers.extent(low[None], high[None])
        floor = least[0] if self.aim.sense > 0.0 else -most[0]
        return bool(np.isfinite(floor) and goal - floor <= _ROUNDING * abs(floor))

    def of_what_varies(self) -> Program:
        """The same question, each limit of it without what no variable changes."""
        return replace(self, limits=tuple(limit.of_what_varies() for limit in self.limits))

    def aiming(self, aim: Aim | None) -> Program:
        return replace(self, aim=aim)
