"""Worst speeds of many one-mass responses at once, in closed form about each resonance."""

from __future__ import annotations

from math import copysign, inf, sqrt
from typing import Any

import numpy as np

from vibopt.arrays import FloatArray, some
from vibopt.program.program import Limit
from vibopt.solve.closed_program import Number, Numbers, Question, machine_at


def worst(asked: Question, numbers: Numbers, index: int, x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """How far a limit is missed at its worst, as a part of its bound, and the squared frequency there.

    Parameters
    ----------
    index
        Of a harmonic limit.
    x
        Designs in the order (k, c), shape (n_vars, count).
    """
    kind = asked.rows[index]
    if kind.tabled is not None:
        return _searched(asked, kind.tabled, x)
    size, top, slope, natural, decay, lossy, centre, width = _about(asked, numbers, index, x)
    w, v = _candidates(asked, numbers, index, (top, slope, centre, width), x.shape[1])
    bottom = np.where(decay > 0.5 * natural, (natural - w) ** 2 + decay * w + lossy, v * v + width)
    square = (top + slope * w) / bottom
    if kind.power:
        square = square * w ** float(kind.power)
    value = size * np.sqrt(np.maximum(square, 0.0))
    value[np.isnan(value)] = np.inf
    at = value.argmax(axis=0) if kind.sign > 0 else value.argmin(axis=0)
    columns = np.arange(x.shape[1])
    bound = numbers[f"{index}.bound"]
    return kind.sign * (value[at, columns] - bound) / bound, w[at, columns]


def worst_alone(asked: Question, index: int, x: tuple[float, ...]) -> tuple[float, float]:
    """As `worst`, of one question and its design in plain floats."""
    kind, numbers = asked.rows[index], asked.numbers
    size, top, slope, natural, decay, lossy, centre, width = _about(asked, numbers, index, x)
    inner, best, at = _turns(kind.power, top, slope, centre, width), -inf, 0.0
    for b, point in enumerate(kind.points):
        low, high = numbers[f"{index}.low{b}"] ** 2, numbers[f"{index}.high{b}"] ** 2
        tried = [(low, low - centre)]
        if not point:
            tried += [(high, high - centre), *((v + centre, v) for v in inner if low <= v + centre <= high)]
        for w, v in tried:
            bottom = (natural - w) ** 2 + decay * w + lossy if decay > 0.5 * natural else v * v + width
            square = (top + slope * w) / bottom * w**kind.power if bottom else inf
            value = kind.sign * size * sqrt(max(square, 0.0))
            if value > best:
                best, at = value, w
    bound = numbers[f"{index}.bound"]
    return (best - kind.sign * bound) / bound, at


def _turns(power: int, top: float, slope: float, centre: float, width: float) -> list[float]:
    """As `stationary`."""
    if not slope and power in (0, 2):
        return [0.0, width / centre] if power else [0.0]
    if power:
        with np.errstate(all="ignore"):
            return list(stationary(power, top, slope, np.array([centre]), np.array([width]), 1)[:, 0].tolist())
    b = -2.0 * (top + slope * centre)
    square = b * b + 4.0 * slope * slope * width
    large = -0.5 * (b + copysign(sqrt(max(square, 0.0)), b))
    return [0.0, -large / slope, slope * width / large] if square >= 0.0 and large else [0.0]


def _about(asked: Question, numbers: Numbers, index: int, x: Any) -> tuple[Number, ...]:
    """A limit about its resonance: |r|^2 = size^2 w^power (top + slope w) / ((w - centre)^2 + width)."""
    kind = asked.rows[index]
    m, k, c, h = machine_at(numbers, x)
    top: Number = 1.0
    slope: Number = 0.0
    if kind.through:
        _, part, damper, loss = machine_at(numbers, x, f"{index}.")
        top, slope = part**2 + loss**2, damper**2
    size = numbers[f"{index}.size"] / (1.0 if kind.inertia else m)
    natural, decay, lossy = k / m, (c / m) ** 2, (h / m) ** 2
    return (
        size, top, slope, natural, decay, lossy,
        natural - 0.5 * decay, lossy + decay * (natural - 0.25 * decay),
    )  # fmt: skip


def _searched(asked: Question, limit: Limit, x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """As `worst`, of one design whose amplitude is a table over the speed."""
    design, least = np.zeros(len(x)), limit.least_wanted
    design[list(asked.order)] = x[:, 0]
    found = limit.candidates(design)
    (speed,), value = (min if least else max)(found, key=lambda one: one[1])
    missed = (limit.bound - value if least else value - limit.bound) / limit.bound
    return np.array([missed]), np.array([(limit.form.drives[0].lines[0].order * speed) ** 2])


def _candidates(
    asked: Question, numbers: Numbers, index: int, shape: tuple[Number, ...], count: int
) -> tuple[FloatArray, FloatArray]:
    """Ends of the bands, the resonance and every stationary point in them: w and w less the centre."""
    kind = asked.rows[index]
    top, slope, centre, width = shape
    inner = stationary(kind.power, top, slope, centre, width, count)
    w, v = [], []
    for b, point in enumerate(kind.points):
        ends = np.empty((2, count))
        low, high = ends[0], ends[1] = numbers[f"{index}.low{b}"] ** 2, numbers[f"{index}.high{b}"] ** 2
        w.append(ends)
        v.append(ends - centre)
        if not point:
            speeds = inner + centre
            inside = (speeds >= low) & (speeds <= high)
            w.append(np.where(inside, speeds, low))
            v.append(np.where(inside, inner, low - centre))
    return np.concatenate(w), np.concatenate(v)


def stationary(power: int, top: Number, slope: Number, centre: FloatArray, width: FloatArray, count: int) -> FloatArray:
    """v = w - centre where w^power (top + slope w) / (v^2 + width) is stationary, and v = 0; nan where not real."""
    here = top + slope * centre
    zero = np.zeros(count)
    if not some(slope):
        if power == 0:
            return zero[None]
        if power == 2:
            return np.stack([zero, width / centre])
        return np.concatenate([zero[None], _quadratic(here * (power - 2), -2.0 * here * centre, power * here * width)])
    if power == 0:
        return np.concatenate([zero[None], _quadratic(-slope + zero, -2.0 * here, slope * width)])
    lead = (power - 1) * slope
    square = (power - 2) * here - centre * slope
    line = (power + 1) * slope * width - 2.0 * here * centre
    last = power * here * width + centre * slope * width
    if power == 1:
        return np.concatenate([zero[None], _quadratic(square, line, last)])
    return np.concatenate([zero[None], _cubic(lead, square, line, last)])


def _quadratic(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    large = -0.5 * (b + np.copysign(np.sqrt(b * b - 4.0 * a * c), b))
    return np.stack([large / a, c / large])


def _cubic(a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray) -> FloatArray:
    """Real roots by cosines or cube roots, then by Newton's rule on the cubic itself."""
    b, c, d = b / a, c / a, d / a
    shift = b / 3.0
    p, q = c / 3.0 - shift**2, shift**3 - 0.5 * shift * c + 0.5 * d
    gap = q * q + p**3
    radius = np.sqrt(np.maximum(-p, 0.0))
    angle = np.arccos(np.clip(-q / radius**3, -1.0, 1.0)) / 3.0
    turns = angle + np.array([[0.0], [2.0 * np.pi / 3.0], [-2.0 * np.pi / 3.0]])
    three = 2.0 * radius * np.cos(turns) - shift
    half = -np.copysign(np.cbrt(np.abs(q) + np.sqrt(np.maximum(gap, 0.0))), q)
    one = half - p / half - shift
    roots = np.where(gap <= 0.0, three, np.stack([one, np.full_like(one, np.nan), np.full_like(one, np.nan)]))
    small = -d / c  # the peak of a light damper, too small for the formulas above
    roots = np.concatenate([roots, np.broadcast_to(small, (1, roots.shape[1]))])
    for _ in range(4):
        value = ((roots + b) * roots + c) * roots + d
        roots = roots - value / ((3.0 * roots + 2.0 * b) * roots + c)
    return roots
