"""One mass on links, one frequency: the response against speed in closed form.

With w the square of the frequency, |r|^2 = A^2 w^a P(w) / (m^2 ((w - w0)^2 + g)).  Stationary
points are roots of a small polynomial in v = w - w0, so light damping costs no digits, and where the damping is heavy
in w itself, whose like terms are left out before they are added.
"""

from __future__ import annotations

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray, IntArray
from vibopt.mechanics.combine import Extreme
from vibopt.mechanics.model import DAMPING, HYSTERETIC, INERTIA, STIFFNESS, Model
from vibopt.records import dataclass
from vibopt.signals import Band, Line, Output

_DEGREE = {INERTIA: 2, STIFFNESS: 0, DAMPING: 1, HYSTERETIC: 0}


@dataclass(frozen=True, slots=True)
class Curve:
    """|r|^2 against w.

    numerator
        Coefficients of P, ascending in w.
    power
        a, a whole number.
    size
        A^2 / m^2.
    centre, width
        w0 [rad^2/s^2] and g [rad^4/s^4]; g = 0 without damping.
    natural, decay
        k/m [rad^2/s^2] and (c/m)^2 [rad^2/s^2]: the same denominator as (k/m - w)^2 + (c/m)^2 w, which
        keeps its digits when the damping is heavy; decay < 0 where only the other form holds.
    order
        Frequency over speed.
    """

    numerator: FloatArray
    power: int
    size: float
    centre: float
    width: float
    natural: float
    decay: float
    order: float

    def _at(self, w: FloatArray, v: FloatArray) -> FloatArray:
        """|r| at w, and at v beyond the centre, shape of both; inf at an undamped resonance."""
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            top = self.size * np.maximum(np.polyval(self.numerator[::-1], w), 0.0)  # rounding at an antiresonance
            if self.power:
                top = top * w**self.power
            square = top / ((self.natural - w) ** 2 + self.decay * w if self.heavy else v * v + self.width)
        value: FloatArray = np.sqrt(np.where(np.isnan(square), np.inf if self.power >= 0 else square, square))
        return value

    @property
    def heavy(self) -> bool:
        return self.decay > 0.5 * self.natural

    def stationary(self) -> tuple[FloatArray, FloatArray]:
        """w, and v = w - w0, of every real stationary point of |r|."""
        v = np.zeros(0) if self.heavy else self._around()
        w = self._outright() if self.heavy else v + self.centre
        return w, w - self.centre if self.heavy else v

    def _outright(self) -> FloatArray:
        """w where w (log |r|^2)' = 0: P_i D_j w^(i+j) counts a + i - j times, D being the denominator."""
        below = np.array([self.natural**2, self.decay - 2.0 * self.natural, 1.0])
        i, j = np.indices((len(self.numerator), 3))
        slopes = np.bincount((i + j).ravel(), ((self.power + i - j) * np.outer(self.numerator, below)).ravel())
        return _roots(slopes, self.natural or self.decay)

    def _around(self) -> FloatArray:
        """v where |r| is stationary."""
        p = self.numerator
        if len(p) == 1 and self.power == 0:
            return np.zeros(1)
        shifted = _shift(p, self.centre)
        slope = shifted[1:] * np.arange(1, len(shifted)) if len(shifted) > 1 else np.zeros(1)
        w = np.array([self.centre, 1.0])
        first = _add(self.power * shifted, np.convolve(w, slope))
        round_pole = np.array([self.width, 0.0, 1.0])
        left = np.convolve(first, round_pole)
        right = 2.0 * np.convolve(np.convolve(w, np.array([0.0, 1.0])), shifted)
        return _roots(_add(left, -right), abs(self.centre) or 1.0)

    def candidates(self, band: Band) -> list[Extreme]:
        """Ends and stationary points of a band of speeds."""
        low, high = (self.order * band.low) ** 2, (self.order * band.high) ** 2
        ends = np.array([low, high])
        w, v = self.stationary() if high > low else (np.zeros(0), np.zeros(0))
        w, v = np.concatenate([ends, w]), np.concatenate([ends - self.centre, v])
        inside = (w >= low * (1 - 1e-15)) & (w <= high * (1 + 1e-15))
        w, v = w[inside], v[inside]
        if self.width == 0.0 and high > low and low <= self.centre <= high:
            w, v = np.append(w, self.centre), np.append(v, 0.0)
        values = self._at(w, v)
        return [Extreme(float(a), float(np.sqrt(b)) / self.order) for a, b in zip(values, w, strict=True)]


def _roots(slopes: FloatArray | IntArray, scale: float) -> FloatArray:
    """Real roots of an ascending polynomial, of the size of `scale`."""
    from vibopt.mechanics.polynomials import real_roots

    return real_roots(slopes * scale ** np.arange(len(slopes)), 1e-6, 2, 1e-8) * scale


def curve(model: Model, p: FloatArray, output: Output, line: Line) -> Curve | None:
    """The closed form of a line of a response; None where it has none (tables, mixed damping, many masses).

    Parameters
    ----------
    model
        A model with one free coordinate.
    p
        Coefficients of its terms, shape (n_terms,).
    output, line
        What is read, and what shakes.
    """
    if model.n_free != 1 or len(line.amplitude.pieces) != 1 or line.amplitude.pieces[0].slope:
        return None
    vectors, kinds = model.vectors, model.kinds
    squares = vectors[:, 0] ** 2
    mass, c, k, h = (float((p * squares)[kinds == kind].sum()) for kind in (INERTIA, DAMPING, STIFFNESS, HYSTERETIC))
    if h and c:
        return None
    top = numerator(model, p, output, line)
    square = np.real(np.convolve(top, np.conj(top) * (-1.0) ** np.arange(len(top))))[::2]
    square = square * (-1.0) ** np.arange(len(square))
    piece = line.amplitude.pieces[0]
    leading = int(np.flatnonzero(square)[0]) if square.any() else 0
    trimmed = np.trim_zeros(square, "b")[leading:]
    if h:
        centre, width = k / mass, (h / mass) ** 2
    else:
        centre, width = k / mass - 0.5 * (c / mass) ** 2, (c / mass) ** 2 * (k / mass - 0.25 * (c / mass) ** 2)
    power = output.power + leading + piece.power
    size = (piece.constant / mass) ** 2 / line.order ** (2 * piece.power)
    decay = -1.0 if h else (c / mass) ** 2
    return Curve(trimmed if len(trimmed) else np.zeros(1), power, size, centre, width, k / mass, decay, line.order)


def reading(model: Model, p: FloatArray, output: Output, line: Line, omega: float) -> tuple[complex, float]:
    """What is read of one free coordinate under a unit amplitude at one frequency [rad/s], inf at a pole.

    Beside it what is left of the body's impedance after terms have cancelled, as a part of them; 0 where a base moves.
    """
    factors = (-(omega**2), 1.0, 1j * omega, 1j)
    moved, still = [0.0] * len(model.terms), 0j
    if model.n_coords > 1:
        moved, still = (model.vectors[:, 1:] @ line.vector[1:]).tolist(), complex(output.row[1:] @ line.vector[1:])
    stiff, load, read = 0j, complex(line.vector[0]), complex(output.row[0])
    size = 0.0
    kinds, vectors = model.alone
    for kind, scale, own, other, sign in zip(kinds, p.tolist(), vectors, moved, output.signs.tolist(), strict=True):
        z = scale * factors[kind]
        stiff += z * own * own
        size += abs(z) * own * own
        load -= z * own * other
        read += sign * z * own
        still += sign * z * other
    if not stiff:
        return complex("inf"), 0.0
    value = complex((read * load / stiff + still) * (1j * omega) ** output.power)
    return value, 0.0 if any(moved) else abs(stiff) / size


def numerator(model: Model, p: FloatArray, output: Output, line: Line) -> ComplexArray:
    """Numerator of the transfer as a polynomial in s = i w, ascending.

    Terms with s^0, s^1, s^2 for springs, dampers and masses; structural damping is a complex spring.
    """
    if model.n_coords == 1:
        return _on_the_body(model, p, output, line)
    degree = np.array([2, 0, 1, 0])[model.kinds]
    weight = p * np.where(model.kinds == HYSTERETIC, 1j, 1.0)
    load = np.zeros(3, dtype=complex)
    row = np.zeros((3, model.n_coords), dtype=complex)
    stiff = np.zeros(3, dtype=complex)
    load[0] = line.vector[0]
    row[0] = output.row
    base = model.vectors[:, 1:] @ line.vector[1:] if model.n_coords > 1 else np.zeros(len(p))
    for t in range(len(p)):
        b = model.vectors[t]
        stiff[degree[t]] += weight[t] * b[0] ** 2
        load[degree[t]] -= weight[t] * b[0] * base[t]
        if output.signs[t]:
            row[degree[t]] += output.signs[t] * weight[t] * b
    top = np.convolve(row[:, 0], load)
    if model.n_coords > 1:
        top = top + np.convolve(row[:, 1:] @ line.vector[1:], stiff)
    return np.trim_zeros(top, "b") if top.any() else np.zeros(1, dtype=complex)


def _on_the_body(model: Model, p: FloatArray, output: Output, line: Line) -> ComplexArray:
    """The same where nothing but the body moves: what is read times the force."""
    row = [complex(output.row[0]), 0j, 0j]
    if output.signs.any():
        weights = (output.signs * p * model.vectors[:, 0]).tolist()
        for kind, weight in zip(model.kinds.tolist(), weights, strict=True):
            row[_DEGREE[kind]] += weight * (1j if kind == HYSTERETIC else 1.0)
    while len(row) > 1 and row[-1] == 0.0:
        row.pop()
    return np.asarray(np.array(row) * line.vector[0])


def _shift(p: FloatArray, by: float) -> FloatArray:
    """Coefficients of p(by + v), ascending in v."""
    shifted = np.zeros(1)
    for coefficient in p[::-1]:
        shifted = _add(np.convolve(shifted, np.array([by, 1.0])), np.array([coefficient]))
    return np.trim_zeros(shifted, "b") if shifted.any() else np.zeros(1)


def _add(a: FloatArray, b: FloatArray) -> FloatArray:
    if len(a) < len(b):
        a, b = b, a
    total = a.copy()
    total[: len(b)] += b
    return total
