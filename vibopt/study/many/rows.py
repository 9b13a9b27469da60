"""Limits of many questions as rows a k^2 + b k + g + d q <= 0, q = c^2; with one variable d = 0."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vibopt.forms import FloatArray
from vibopt.study.many.lower import Question
from vibopt.study.many.numbers import Numbers

IndexArray = NDArray[np.int_]
BoolArray = NDArray[np.bool_]


def take(numbers: Numbers, chosen: IndexArray | BoolArray | slice) -> dict[str, FloatArray]:
    """The numbers of some of the questions."""
    return {name: one[chosen] if one.ndim else one for name, one in numbers.items()}


def plain_row(asked: Question, numbers: Numbers, index: int, count: int) -> FloatArray:
    """Row of a limit without speeds, shape (4, count)."""
    kind = asked.rows[index]
    bound = numbers[f"{index}.bound"]
    k0, k1, m0, m1 = (numbers[name] for name in ("K0", "K1", "M0", "M1"))
    a = b = g = d = np.zeros(())
    if kind.kind == "frequency":
        b, g = k1 - bound**2 * m1, k0 - bound**2 * m0
    elif kind.kind == "static":
        s0, s1, gravity = (numbers[f"{index}.{name}"] for name in ("S0", "S1", "gravity"))
        b, g = gravity * m1 - bound * s1, gravity * m0 - bound * s0
    elif kind.kind == "damping":
        z = 4.0 * bound**2
        c0, c1, ch = (numbers[name] for name in ("C0", "C1", "Ch"))
        a, b, g = -z * k1 * m1, -z * (k0 * m1 + k1 * m0), c0**2 - z * k0 * m0
        if asked.plane:
            d = c1**2
        else:
            a, b = a + c1**2, b + 2.0 * c0 * c1 + ch**2
    else:
        a, b, g, d = _monomial(asked, numbers, index)
    return _stacked(kind.sign, (a, b, g, d), count)


def _monomial(asked: Question, numbers: Numbers, index: int) -> tuple[FloatArray, ...]:
    kind, bound = asked.rows[index], numbers[f"{index}.bound"]
    zero = np.zeros(())
    if asked.plane:
        bound = bound / numbers[f"{index}.scale0"]
        on_k = kind.exponents[0][asked.order[0]] == 1.0
        return (zero, zero + 1.0, -bound, zero) if on_k else (zero, zero, -(bound**2), zero + 1.0)
    parts = [zero, zero, zero]
    for j, (power,) in enumerate(kind.exponents):
        parts[int(power)] = parts[int(power)] + numbers[f"{index}.scale{j}"]
    return parts[2], parts[1], parts[0] - bound, zero


def harmonic_row(asked: Question, numbers: Numbers, index: int, w: FloatArray) -> FloatArray:
    """Row of a limit at one squared frequency per question, w (count,); shape (4, count)."""
    kind = asked.rows[index]
    bound = numbers[f"{index}.bound"] ** 2
    bottom = _square(numbers, "", w, inertia=True)
    lead = numbers[f"{index}.size"] ** 2 * (w**kind.power if kind.power else 1.0)
    if kind.inertia:
        lead = lead * numbers["M0"] ** 2
    if kind.through:
        top = _square(numbers, f"{index}.", w, inertia=False)
        row = [lead * t - bound * b for t, b in zip(top, bottom, strict=True)]
    else:
        row = [-bound * b for b in bottom]
        row[2] = row[2] + lead
    if not asked.plane:
        row[0], row[3] = row[0] + row[3], np.zeros(())
    return _stacked(kind.sign, row, len(w))


def _square(numbers: Numbers, prefix: str, w: FloatArray, *, inertia: bool) -> list[FloatArray]:
    """|z|^2 of an impedance: coefficients of k^2, k, 1 and of the damping that is chosen, squared."""
    k0, k1, c0, c1, ch, h0, h1 = (numbers[prefix + name] for name in ("K0", "K1", "C0", "C1", "Ch", "H0", "H1"))
    if inertia:
        k0 = k0 - numbers["M0"] * w
        k1 = k1 - numbers["M1"] * w
    a, b, g = k1**2, 2.0 * k0 * k1, k0**2
    d = c1**2 * w
    if ch.any():
        b = b + ch**2 * w
    if h0.any() or h1.any() or c0.any():
        omega = np.sqrt(w)
        real, steep = omega * c0 + h0, h1
        a = a + steep**2 + 2.0 * omega * c1 * steep
        b = b + 2.0 * real * (omega * c1 + steep)
        g = g + real**2
    return [a, b, g, d]


def _stacked(sign: float, parts: tuple[FloatArray, ...] | list[FloatArray], count: int) -> FloatArray:
    table = np.empty((4, count))
    for place, part in enumerate(parts):
        table[place] = sign * part
    return table


def machine_at(asked: Question, numbers: Numbers, x: FloatArray, prefix: str = "") -> tuple[FloatArray, ...]:
    """M, K, C, H at designs x (n_vars, count) in the order (k, c)."""
    m0, m1, k0, k1, c0, c1, ch, h0, h1 = (
        numbers[prefix + name] for name in ("M0", "M1", "K0", "K1", "C0", "C1", "Ch", "H0", "H1")
    )
    damper = c1 * x[-1] + c0
    if ch.any():
        damper = damper + ch * np.sqrt(x[0])
    return m0 + m1 * x[0], k0 + k1 * x[0], damper, h0 + h1 * x[0]


__all__ = ["BoolArray", "IndexArray", "harmonic_row", "machine_at", "plain_row", "take"]
