"""What every form answers: each says what a method asks of it, or that it has no such thing."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import field
from itertools import combinations
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

import numpy as np

from vibopt.mechanics.model import kept as model_keeps
from vibopt.records import dataclass

if TYPE_CHECKING:
    from vibopt.arrays import ComplexArray, FloatArray, IntArray
    from vibopt.forms.asking import ConvexRows, LogRows, OneVariable, Proof
    from vibopt.forms.bounds import FormBounds
    from vibopt.forms.damped import OfPoles
    from vibopt.forms.floors import Floors
    from vibopt.forms.modulus import Modulus
    from vibopt.forms.monomials import Monomials
    from vibopt.forms.peak_in_time import PeakInTime
    from vibopt.forms.rational import Groups, Sampled
    from vibopt.forms.reduce import Reach
    from vibopt.forms.tangent import Tangent
    from vibopt.forms.undamped import ModeFrequency
    from vibopt.mechanics.model import Model
    from vibopt.signals import Drive

    Bounds = tuple[FloatArray, FloatArray]

_STEP, _TURN = 1e-6, 1e-4
_T = TypeVar("_T")
WITHOUT_END = 1e30
ROOTS = 1e-6
"""Part of the greatest pole, or of a root mean square, that near roots and integrals may lose."""


@dataclass(frozen=True, slots=True)
class Worst:
    """Value of a form [SI], and per excitation the speed [rad/s] at which it is reached."""

    value: float
    speeds: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Against:
    """A form against the speed of one excitation, the others at their worst; callable.

    sizes
        Of that excitation alone, at speeds of any shape [rad/s].
    singular, breaks
        Complex speeds at which it is singular, real ones where it is not smooth.
    others, squares
        What the other excitations add, and whether as the root of the sum of the squares.
    beside
        What stands beside all excitations and adds to them.
    """

    sizes: Callable[[FloatArray], FloatArray]
    singular: ComplexArray
    breaks: FloatArray
    others: float
    squares: bool
    beside: float = 0.0

    def __call__(self, speed: FloatArray) -> FloatArray:
        return self.whole(self.sizes(speed))

    def whole(self, value: FloatArray) -> FloatArray:
        """A size with all that adds to it."""
        return self.beside + (np.hypot(value, self.others) if self.squares else value + self.others)


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
    solved_directly: ClassVar[bool] = False
    """Whether no polynomials in the variables stand for it."""
    rank: ClassVar[int] = 3
    """Of what is asked of many designs: first what is cheap and telling."""
    random: ClassVar[bool] = False
    """Whether it is the mean square of something under white noise."""
    not_convex: ClassVar[str] = "is not convex in the design"
    rough: ClassVar[str] = "is no smooth function of the design"
    no_bounds: ClassVar[str] = "has no bounds on boxes of designs"
    """Why it has no statement in cvxpy, none in CasADi, or no bounds on boxes of designs, behind its name."""
    tangents_up_to: ClassVar[int] = 3
    """Variables up to which boxes with tangents come to an end."""
    dear: ClassVar[bool] = False
    """Whether it is measured behind all others, which may rule a design out for less."""
    once: ClassVar[float] = 0.25
    """Work of measuring it at one design, or at one speed of one, of few coordinates [nominal ms]."""

    @property
    def searched(self) -> str:
        """What of its value is found by a search that could miss something greater, in words; else empty."""
        return ""

    @property
    def known_to(self) -> float:
        """Part of itself to which a value is known, if more than rounding; limits are kept with that to spare."""
        return 0.0

    @property
    def drives(self) -> tuple[Drive, ...]:
        """The excitations over whose speeds it is the worst; none where it knows no speeds."""
        return ()

    @property
    def shaken(self) -> tuple[Drive, ...]:
        """Every excitation that it counts, its drives or others that move the machine at speeds."""
        return self.drives

    @property
    def harmonic(self) -> Modulus | None:
        """Itself where it is a response over speeds."""
        return None

    @property
    def swings(self) -> Modulus | None:
        """What of it is a response over speeds, where one part is and all else stands beside it."""
        return self.harmonic

    def swinging(self, other: Modulus) -> Form:
        """Itself with another response over speeds in the place of `swings`."""
        return other

    def against(self, model: Model, x: FloatArray, name: str, *, least_wanted: bool) -> Against:
        """The response against the speed of an excitation, by its name."""
        raise NotImplementedError(f"{type(self).__name__} is no response over speeds")

    @property
    def powers(self) -> Monomials | None:
        """Itself where it is a sum of powers of the variables, which needs no machine."""
        return None

    @property
    def in_time(self) -> PeakInTime | None:
        """Itself where it is the greatest in time."""
        return None

    @property
    def screened(self) -> bool:
        """Whether a search begins at the best of many designs: it has plains where nothing moves."""
        return False

    def push(self, mass: float, speed: float) -> float:
        """Size of the force [N] that moves a mass [kg] at a speed [rad/s]: of a friction that matters."""
        return 1.0

    @property
    def one_line(self) -> bool:
        """Whether it is one harmonic of one excitation, or knows neither speeds nor poles nor noise."""
        return False

    @property
    def ratio(self) -> bool:
        """Whether it is |N| / |D| at each speed, as `sampled` gives them."""
        return False

    @property
    def poles(self) -> OfPoles | None:
        """Itself where it is the least of a number that poles have."""
        return None

    @property
    def frequency(self) -> ModeFrequency | None:
        """Itself where it is a natural frequency."""
        return None

    def value(self, model: Model, x: FloatArray) -> float:
        """At a design; infinite where it has no end."""
        raise NotImplementedError(f"{type(self).__name__} has no value")

    def every(self, model: Model, x: FloatArray) -> FloatArray:
        """All frequencies that it keeps away from bands, ascending [rad/s]."""
        raise NotImplementedError(f"{type(self).__name__} keeps nothing away from bands")

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
    ) -> list[list[Tangent]]:
        """What it is no less than where x is off by at most `reach` of itself, both (n, n_vars), at each of n designs.

        Only of forms that have `tangents_of`; `level` and `times` [s] say where it is worth looking.
        """
        return [[] for _ in x]

    def closed_to(self, model: Model) -> float:
        """Part of a goal that boxes leave open to rounding, where that is more than of most; else 0."""
        return 0.0

    def tangents_cost(self, model: Model) -> float:
        """Work of tangents on a box beside a measurement in its middle [nominal ms]."""
        return 0.007 * int(model.exponents.any(axis=1).sum()) * model.n_free

    def greatest_at(self, model: Model, x: FloatArray) -> float | None:
        """When, or at which duration [s], it is greatest at a design (n_vars,), as `tangents` takes it; else None."""
        return None

    def floors(self, model: Model) -> Floors | None:
        """What says how little it can be on boxes of designs, however wide; only of forms that have `tangents_of`."""
        return None

    def by_size(self, model: Model, along: FloatArray) -> float | None:
        """Power of s by which it goes where x s**along (n_vars,) makes masses, springs and dampers s times as large.

        None where that is not known.
        """
        if self.powers is None or (self.powers.scale < 0.0).any():
            return None
        powers = np.unique(self.powers.exponents @ along)
        return float(powers[0]) if len(powers) == 1 else None

    @property
    def tangents_of(self) -> tuple[float, ...]:
        """Signs with which it has tangents: 1 where bounds from below are known, -1 those of its negative."""
        return ()

    def majorised(self, model: Model) -> bool:
        """Whether `majorants` may say how great it can be on boxes of designs."""
        return False

    def majorants(self, model: Model, x: FloatArray, reach: FloatArray) -> list[list[Tangent]]:
        """Tangents of its negative where x is off by at most `reach` of itself, both (n, n_vars)."""
        return [[] for _ in x]

    def reach(self, model: Model) -> Reach | None:
        """What moves the machine and what is read of it, where no other motion has a part in it."""
        return None

    def values(self, model: Model, x: FloatArray, *, least_wanted: bool = False) -> FloatArray:
        """The worst at designs x (n, n_vars), shape (n,)."""
        return np.array([self.worst(model, one, least_wanted=least_wanted).value for one in x])

    def ahead(self, model: Model, x: FloatArray) -> None:
        """Be ready for its values at designs x (n, n_vars), where many together take less than each alone."""

    def glance(self, model: Model, x: FloatArray) -> FloatArray | None:
        """No greater than the greatest at designs x (n, n_vars), shape (n,), where many are had for little."""
        return None

    def candidates(self, model: Model, x: FloatArray, *, least_wanted: bool) -> list[tuple[tuple[float, ...], float]]:
        """Speed and value of every local extreme of a `ratio` that could be the worst; without speeds its value."""
        return [((), self.value(model, x))]

    def acting(self, model: Model) -> FloatArray:
        """Exponents of all that it depends on, (n, n_vars)."""
        return model.exponents

    def senses(self, model: Model) -> FloatArray | None:
        """Senses in which its parts move with each variable (n, n_vars), where the worst lies at a corner of them."""
        return None

    def at_corners(self, model: Model, *, least_wanted: bool) -> bool:
        """Whether the worst of a box of designs lies at some corner for sure."""
        return False

    def rises(self, model: Model, index: int) -> float | None:
        """1 where it rises with a variable, -1 where it falls; None where it is not that simple."""
        return None

    def held(self, x: FloatArray, free: list[int]) -> Form:
        """Itself in the variables `free` alone, the others at x (n_vars,)."""
        return self

    def watched(self, ends: tuple[float, ...]) -> list[float]:
        """Frequencies [rad/s] at which something begins or ends for a limit with such bounds."""
        return []

    def room(self, model: Model, x: FloatArray, value: float, other: float, rounding: float) -> float:
        """How far rounding may move it from the value of the second route.

        `rounding` is the part by which coefficients may be off.
        """
        return ROOTS * max([0.0, *(abs(one) for one in (value, other) if np.isfinite(one))])

    def said(self, model: Model, order: IntArray) -> tuple[Any, ...]:
        """As plain data, its variables renumbered; one that cannot tell is the same in one order only."""
        return tuple(order.tolist())

    def groups(self, model: Model) -> Groups | None:
        """Directions of the determinants whose quotient it is."""
        return None

    def sampled(self, model: Model, speeds: FloatArray, reference: FloatArray) -> Sampled:
        """N and D at speeds (n,) [rad/s] of what is a `ratio`."""
        raise NotImplementedError(f"{type(self).__name__} is no quotient of determinants")

    def polynomial(self, rows: OneVariable, model: Model, bound: float) -> FloatArray | None:
        """Ascending coefficients of what is below zero where it is below the bound; None where `sampled` tells."""
        return None

    def is_polynomial(self, model: Model, most_degree: int) -> bool:
        """Whether a bound of it is a polynomial inequality in the one variable."""
        return False

    def sampleable(self, model: Model) -> bool:
        """Whether a row at sampled speeds says more of it than its slope at one design."""
        return False

    def not_smooth(self, model: Model) -> str:
        """Why it is not smooth, or has no smooth statement, behind its name; "" where it has one."""
        return self.rough

    def bounded(self, model: Model) -> bool:
        """Whether it has bounds on boxes of designs."""
        return False

    def on_boxes(self, known: FormBounds, low: FloatArray, high: FloatArray) -> Bounds:
        """Lower and upper bound on boxes low, high (n_boxes, n_vars), each (n_boxes,), where `bounded`.

        Of a response over speeds: lower bound of the greatest, upper bound of the least.
        """
        raise NotImplementedError(f"{type(self).__name__} has no bounds on boxes")

    def known(self, at: FormBounds) -> bool:
        """Whether `on_points` tells anything of it."""
        return False

    def on_points(self, at: FormBounds, x: FloatArray) -> Bounds:
        """Lower bound of the greatest and upper bound of the least value at designs x (n, n_vars), each (n,)."""
        value = self.on_boxes(at, x, x)[0]
        return value, value

    def logged(self, rows: LogRows, model: Model, bound: float) -> Any:
        """log(value / bound) in CasADi; to first order where it has no statement of its own."""
        return rows.of_slope(model, self, bound)

    def convex_limit(self, rows: ConvexRows, limit: Any, sense: float, bound: float) -> Any:
        """The constraint sense * value <= sense * bound in cvxpy; None where it is none that is convex."""
        return None

    def convex_goal(self, rows: ConvexRows, aim: Any) -> Any:
        """What rises with it and is convex (concave where it is made greatest) in cvxpy; None where there is none."""
        return None

    def around(self, proof: Proof) -> bool:
        """Whether a proof by bounds on boxes finds a level kept in the neighbourhood of a machine."""
        return False

    def cost(self, model: Model) -> float:
        """Work of measuring it at one design [nominal ms], which grows with the square of the coordinates."""
        return self.once + 1e-4 * model.n_free**2


class AtWorst(Form):
    """A form that is known by where it is worst."""

    __slots__ = ()

    def value(self, model: Model, x: FloatArray) -> float:
        return self.worst(model, x).value

    def slope(self, model: Model, x: FloatArray) -> FloatArray:
        return self.extremes(model, x, least_wanted=False)[0].slope


def kept(model: Model, form: Form, x: FloatArray, measured: Callable[[FloatArray], Sequence[_T]]) -> list[_T]:
    """What a form measures at designs x (n, n_vars), of which the last ones stay with the model."""

    def both(some: FloatArray) -> list[tuple[Form, _T]]:
        return [(form, one) for one in measured(some)]  # the form stays, and so its number

    return [one for _, one in model_keeps(model, id(form), np.asarray(x, dtype=float), both)]


def by_differences(value: Callable[[FloatArray], float], x: FloatArray, step: float = _STEP) -> FloatArray:
    """Slope of the log of a value in log x by central differences over a part of x."""
    slope = np.zeros(len(x))
    for i in range(len(x)):
        up, down = x.copy(), x.copy()
        up[i] *= 1.0 + step
        down[i] *= 1.0 - step
        slope[i] = (log_of(value(up)) - log_of(value(down))) / (2.0 * step)
    return np.nan_to_num(slope, posinf=0.0, neginf=0.0)


def top_by_differences(
    at: Callable[[FloatArray, FloatArray], FloatArray], x: FloatArray, value: float, speed: float, *, moves: bool
) -> Local:
    """A local extreme over speeds, with slope and bend by small turns of the logs of the design and of the speed.

    Of values `at` designs (m, n_vars), each at a speed of its own (m,) [rad/s]; the speed of the extreme moves with the
    design where it `moves`.  No bend where some difference has no end.
    """
    n = len(x)
    if not 0.0 < value < np.inf:
        return Local(log_of(value) if np.isfinite(value) else np.inf, np.zeros(n), (speed,))

    steps, pairs = _TURN * np.eye(n + moves), list(combinations(range(n + moves), 2))
    both = [steps[i] + steps[j] for i, j in pairs]
    turns = np.array([0.0 * steps[0], *steps, *-steps, *both, *(-one for one in both)])
    found = at(x * np.exp(turns[:, :n]), speed * np.exp(turns[:, n:].sum(axis=1)))
    here, *logs = [log_of(float(one)) for one in found]
    ups, downs, rest = np.array(logs[: len(steps)]), np.array(logs[len(steps) : 2 * len(steps)]), logs[2 * len(steps) :]
    slope, bend = (ups - downs) / (2.0 * _TURN), np.diag((ups + downs - 2.0 * here) / _TURN**2)
    for (i, j), up, down in zip(pairs, rest[: len(pairs)], rest[len(pairs) :], strict=True):
        apart = up + down + 2.0 * here - ups[i] - ups[j] - downs[i] - downs[j]
        bend[i, j] = bend[j, i] = apart / (2.0 * _TURN**2)
    if moves and bend[n, n]:
        bend -= np.outer(bend[:, n], bend[n]) / bend[n, n]
    whole = np.isfinite(bend[:n, :n]).all()
    return Local(log_of(value), np.nan_to_num(slope[:n]), (speed,), bend[:n, :n] if whole else None)


def bend_of_slopes(form: Form, model: Model, x: FloatArray) -> FloatArray:
    """Second derivative by differences of exact slopes, shape (n_vars, n_vars)."""
    turns = np.exp(1e-5 * np.eye(len(x)))
    up, down = (np.array([form.slope(model, one) for one in every]) for every in (x * turns, x / turns))
    rows = (up - down) / 2e-5
    return np.asarray(0.5 * (rows + rows.T))


def log_of(value: float) -> float:
    """Log, and of nothing a number without end."""
    return float(np.log(value)) if value > 0.0 else -WITHOUT_END


def row_said(row: FloatArray) -> tuple[float, ...]:
    """A row without its sign: springs and the size of a response do not know it."""
    turned = row if not row.any() or row[np.flatnonzero(row)[0]] > 0 else -row
    return tuple(float(one) + 0.0 for one in turned)


def plus(a: FloatArray, b: FloatArray) -> FloatArray:
    """Sum of two polynomials, coefficients ascending."""
    total = np.zeros(max(len(a), len(b)))
    total[: len(a)] += a
    total[: len(b)] += b
    return total
