"""Few coordinates, one harmonic: the peaks of a response from its numerator and denominator as polynomials.

With the bordered matrix a sum of rank-one terms, both determinants are sums over subsets of terms
(Cauchy-Binet); in the denominator nothing ever cancels.  Numerator N and denominator D in s = i w give
every stationary point as a root, its polish, and the slopes and bends of its value with the design.
What rounding could spoil is found by checks, and then there is no answer: the general search takes over.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import field
from functools import lru_cache, partial
from itertools import combinations
from math import comb

import numpy as np

from vibopt.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from vibopt.mechanics.combine import Extreme
from vibopt.mechanics.model import DAMPING, HYSTERETIC, INERTIA, Model
from vibopt.mechanics.quotient import Polynomials
from vibopt.records import cached_property, dataclass
from vibopt.signals import Amplitude, Band, Line, Output

MOST = 4
"""Number of free coordinates up to which a model is small."""
_SUBSETS = 2500
_GONE = 1e-13
_TRUSTED = 1e5
"""By how much rounding may grow in a sum: eleven digits are left, of which thirteen were seen."""
_KEPT = 64
_COUNTED = 0.5
_FOLLOWED, _CLOSE = 6, 1e-6
"""Steps of Newton by which a peak is followed to a near design, and the part of its speed that ends them."""


Moebius = tuple[ComplexArray, ComplexArray, ComplexArray, ComplexArray]
"""n0, n1, d0, d1 of (n0 + n1 kappa) / (d0 + d1 kappa), each (n_speeds,)."""


@dataclass(frozen=True, slots=True)
class Peak:
    """A local greatest value.

    at
        Its value and its speed.
    index, among
        Its number among the points whose derivatives are found together, when one is first asked for.
    """

    at: Extreme
    index: int
    among: Moving

    @property
    def slope(self) -> FloatArray:
        """Derivative of the log of the value in log x, its own motion in it, (n_vars,)."""
        return np.asarray(self.among.derivatives[0][self.index])

    @property
    def bend(self) -> FloatArray:
        """Second derivative, (n_vars, n_vars)."""
        return np.asarray(self.among.derivatives[1][self.index])


@dataclass(frozen=True)
class Moving:
    """Points of which `made` finds the slopes and bends, (n, n_vars) and (n, n_vars, n_vars)."""

    made: Callable[[], tuple[FloatArray, FloatArray]]

    @cached_property
    def derivatives(self) -> tuple[FloatArray, FloatArray]:
        with np.errstate(divide="ignore", invalid="ignore"):
            return self.made()


@dataclass(frozen=True, slots=True)
class Side:
    """Numerator or denominator as a sum over subsets of terms.

    members
        Terms of each subset, shape (n_subsets, size); the number of terms stands for a factor of one.
    spread
        Which power of s each subset belongs to, times its weight, shape (degree + 1, n_subsets).
    weights
        1, e_i, e_i e_j (i <= j) of each subset's exponents, shape (n_subsets, n_columns).
    """

    members: IntArray
    spread: FloatArray
    weights: FloatArray

    def coefficients(self, p: FloatArray) -> FloatArray:
        """Coefficients in s, ascending, of the value and its derivatives in log x, (degree + 1, n_columns)."""
        products = p[self.members].prod(axis=1)
        found: FloatArray = self.spread @ (products[:, None] * self.weights)
        return found


@dataclass(frozen=True, slots=True)
class Ratio:
    """One line of a response as N / D times w**power times a size.

    pairs
        Columns of the second derivatives, shape (n_vars, n_vars).
    known
        Peaks of the last few designs.
    """

    model: Model
    top: Side
    bottom: Side
    power: int
    size: float
    order: float
    pairs: IntArray
    known: dict[tuple[bytes, tuple[Band, ...]], list[Peak] | None] = field(default_factory=dict, compare=False)

    def at(self, x: FloatArray, speeds: FloatArray) -> FloatArray:
        """Modulus at designs x (n, n_vars) and speeds (m,) [rad/s], shape (n, m); without care for rounding."""
        p = np.concatenate([self.model.values(x), np.ones((len(x), 1))], axis=1)
        w = self.order * speeds
        sides = []
        for side in (self.top, self.bottom):
            coefficients = p[:, side.members].prod(axis=2) @ side.spread.T
            sides.append(np.abs(coefficients @ (1j * w) ** np.arange(coefficients.shape[1])[:, None]))
        with np.errstate(divide="ignore", invalid="ignore"):
            value: FloatArray = sides[0] / sides[1] * (self.size * w**self.power)
        return value

    def about(self, spring: int, damper: int, speeds: FloatArray) -> Moebius:
        """n0, n1, d0, d1 of (n0 + n1 kappa) / (d0 + d1 kappa) at speeds (m,) [rad/s], size and power in N.

        kappa = k + s c, the coefficients of two terms with one vector, the only ones that vary.
        """
        p, s = np.append(self.model.scales, 1.0), 1j * self.order * speeds
        p[spring], p[damper] = 1.0, 0.0
        found = list[ComplexArray]()
        for side in (self.top, self.bottom):
            products, held = p[side.members].prod(axis=1), (side.members == spring).any(axis=1)
            both = np.where(held, 0.0, products), np.where(held, products, 0.0)
            found += [np.asarray(np.polyval((side.spread @ one)[::-1], s), dtype=complex) for one in both]
        n0, n1, d0, d1 = found
        size = self.size * (self.order * speeds) ** self.power
        return np.asarray(n0 * size), np.asarray(n1 * size), d0, d1

    def peaks(self, x: FloatArray, bands: tuple[Band, ...], within: float) -> list[Peak] | None:
        """Local maxima and band ends no lower than `within` (at least a half) times the greatest, highest first.

        None where rounding, or a resonance without damping, leaves a doubt.
        """
        key = (x.tobytes(), bands)
        if key not in self.known:
            while len(self.known) >= _KEPT:
                self.known.pop(next(iter(self.known)), None)
            with np.errstate(divide="ignore", invalid="ignore"):
                self.known[key] = self._peaks(x, bands)
        found = self.known[key]
        return found if found is None else [peak for peak in found if peak.at.value >= within * found[0].at.value]

    def _peaks(self, x: FloatArray, bands: tuple[Band, ...]) -> list[Peak] | None:
        p = np.append(self.model.values(x), 1.0)
        made = Polynomials.of(self.top.coefficients(p), self.bottom.coefficients(p), self.power)
        if made is None:
            return None
        found = [made.in_band(self.order * band.low / made.unit, self.order * band.high / made.unit) for band in bands]
        if any(one is None for one in found):
            return None
        at = np.concatenate([one for one in found if one is not None])
        return self._measured(made, at[:, 0], at[:, 1] > 0.0)

    def followed(self, x: FloatArray, speeds: FloatArray) -> list[Peak] | None:
        """Maxima near `speeds` (n,) at a near design, the highest first; those of half its height are left out.

        None where one of them is no maximum, or where rounding leaves a doubt.
        """
        with np.errstate(divide="ignore", invalid="ignore"):
            return self._followed(x, speeds)

    def _followed(self, x: FloatArray, speeds: FloatArray) -> list[Peak] | None:
        p = np.append(self.model.values(x), 1.0)
        made = Polynomials.of(self.top.coefficients(p), self.bottom.coefficients(p), self.power)
        if made is None:
            return None
        v = self.order * speeds / made.unit
        for _ in range(_FOLLOWED):
            first, second = made.rise(v)
            if not (second < 0.0).all():
                return None
            step = np.minimum(np.maximum(-first / second, -0.1 * v), 0.1 * v)
            v = v + step
            if (np.abs(step) <= _CLOSE * v).all():
                break
        return self._measured(made, v, np.ones(len(v), dtype=bool))

    def _measured(self, made: Polynomials, v: FloatArray, moves: BoolArray) -> list[Peak] | None:
        top, bottom = made.sides(v)
        log = np.log(np.abs(top[0][:, 0])) - np.log(np.abs(bottom[0][:, 0]))
        if self.power:
            log = log + self.power * np.log(v)
        if np.isnan(log).any() or np.isposinf(log).any():
            return None
        kept = np.flatnonzero(log >= log.max() + np.log(_COUNTED))
        kept = kept[np.argsort(-log[kept], kind="stable")]
        doubt = np.maximum(made.doubt(v[kept], 0), made.doubt(v[kept], 1))
        if not (doubt <= _TRUSTED).all():
            return None
        among = Moving(partial(self._derivatives, top, bottom, moves, v))
        size = self.size * made.size * made.unit**self.power
        value = np.exp(log) * size
        speeds = v * made.unit / self.order
        return [Peak(Extreme(float(value[i]), float(speeds[i])), i, among) for i in kept.tolist()]

    def _derivatives(
        self, top: list[ComplexArray], bottom: list[ComplexArray], moves: BoolArray, v: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Slope and bend of the log of the value in log x at points v, the points' own motion in them."""
        n = self.pairs.shape[0]
        first, mixed, curve = np.zeros((len(v), n)), np.zeros((len(v), n)), np.zeros(len(v))
        second = np.zeros((len(v), n, n))
        for side, sign in ((top, 1.0), (bottom, -1.0)):
            value = side[0][:, :1]
            here, along, twice = side[0] / value, side[1] / value, side[2][:, 0] / value[:, 0]
            own = here[:, 1 : n + 1]
            first = first + sign * own.real
            second = second + sign * (here[:, self.pairs] - own[:, :, None] * own[:, None, :]).real
            mixed = mixed + sign * (along[:, 1 : n + 1] - own * along[:, :1]).real
            curve = curve + sign * (twice - along[:, 0] ** 2).real
        curve = curve - (self.power / v**2 if self.power else 0.0)
        share = np.where(moves, 1.0 / curve, 0.0)
        bend = second - mixed[:, :, None] * mixed[:, None, :] * share[:, None, None]
        return np.nan_to_num(first), np.nan_to_num(bend)


_known: dict[tuple[int, int, int], tuple[Model, Output, Line, Ratio | None]] = {}


def ratio_of(model: Model, output: Output, line: Line) -> Ratio | None:
    """A line of a response as a ratio of polynomials, built once; None where it is none."""
    key = (id(model), id(output), id(line))
    if key not in _known:
        while len(_known) >= _KEPT:
            _known.pop(next(iter(_known)), None)
        _known[key] = (model, output, line, _built(model, output, line))
    return _known[key][3]


@lru_cache(maxsize=32)
def _pairs(n: int) -> tuple[IntArray, IntArray]:
    """Every two of n variables, and each with itself."""
    first, second = np.triu_indices(n)
    return first, second


def _built(model: Model, output: Output, line: Line) -> Ratio | None:
    n, count = model.n_free, len(model.terms)
    simple = _simple(line.amplitude)
    if not 1 < n <= MOST or simple is None or (model.kinds == HYSTERETIC).any() or comb(count + 2, n + 1) > _SUBSETS:
        return None
    kind = complex if line.vector.imag.any() else float
    shaken = line.vector if kind is complex else line.vector.real
    vectors, base = model.vectors[:, :n], shaken[n:]
    moved = model.vectors[:, n:] @ base
    left, right = np.zeros((count + 2, n + 1), dtype=kind), np.zeros((count + 2, n + 1), dtype=kind)
    left[:count, :n], left[:count, n] = vectors, -output.signs
    right[:count, :n], right[:count, n] = vectors, -moved
    left[count, :n], right[count, n] = shaken[:n], 1.0
    left[count + 1, n], right[count + 1, :n], right[count + 1, n] = 1.0, -output.row[:n], output.row[n:] @ base
    top = _side(model, left, right)
    bottom = _side(model, vectors, vectors)
    if top is None or bottom is None:
        return None
    upper = _pairs(model.n_vars)
    pairs = np.zeros((model.n_vars, model.n_vars), dtype=int)
    pairs[upper] = 1 + model.n_vars + np.arange(len(upper[0]))
    pairs = np.maximum(pairs, pairs.T)
    constant, power = simple
    size = abs(constant) / line.order**power
    return Ratio(model, top, bottom, output.power + power, size, line.order, pairs) if size > 0.0 else None


@lru_cache(maxsize=32)
def _subsets(count: int, size: int) -> IntArray:
    """Every choice of so many of `count` terms, (n_subsets, size)."""
    return np.array(list(combinations(range(count), size)), dtype=int).reshape(-1, size)


def _simple(amplitude: Amplitude) -> tuple[float, int] | None:
    """Constant and power of an amplitude of one piece."""
    piece = amplitude.pieces[0]
    return None if len(amplitude.pieces) > 1 or piece.slope or piece.power < 0 else (piece.constant, piece.power)


def _side(model: Model, left: FloatArray | ComplexArray, right: FloatArray | ComplexArray) -> Side | None:
    """det(sum_t z_t left_t right_t^T) over subsets of terms; None where its weights are not of one phase."""
    count, size = len(model.terms), left.shape[1]
    members = _subsets(len(left), size)
    weight = np.linalg.det(left[members]) * np.linalg.det(right[members])
    sizes = np.sqrt((np.abs(left) ** 2).sum(axis=1) * (np.abs(right) ** 2).sum(axis=1))
    most = sizes[members].prod(axis=1)
    kept = np.abs(weight) > _GONE * most
    members, weight = members[kept], weight[kept]
    if not len(members):
        return None
    if np.iscomplexobj(weight):
        weight = weight * np.exp(-1j * np.angle(weight[np.abs(weight).argmax()]))
        if (np.abs(weight.imag) > 1e-14 * np.abs(weight)).any():
            return None
    of_term = np.append(np.where(model.kinds == INERTIA, 2, np.where(model.kinds == DAMPING, 1, 0)), [0, 0])
    exponents = np.concatenate([model.exponents, np.zeros((2, model.n_vars))])
    degree, power = of_term[members].sum(axis=1), exponents[members].sum(axis=1)
    spread = np.zeros((int(degree.max()) + 1, len(members)))
    spread[degree, np.arange(len(members))] = weight.real
    i, j = _pairs(model.n_vars)
    weights = np.concatenate([np.ones((len(members), 1)), power, power[:, i] * power[:, j]], axis=1)
    return Side(np.minimum(members, count), spread, weights)
