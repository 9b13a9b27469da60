"""Slider-crank kinematics: the piston's acceleration as a cosine series of the crank angle.

A piston in line with the crank axis stands at r cos(a) + l sqrt(1 - (r/l)² sin²(a)) from it, a the crank angle after
top dead centre.  Its inertia force on the engine is m r omega² (sum of A_k cos(k a)), away from the crank axis at the
top.  A_1 = 1, and the other odd orders vanish.  The textbook series stops after A_2 = r/l, itself the first term only.
"""

from __future__ import annotations

from functools import cache
from math import comb

import numpy as np

from vibopt.forms import FloatArray

_SMALL = 1e-18


def exact_orders(ratio: float, highest: int) -> FloatArray:
    """A_0..A_highest for crank over rod `ratio` < 1, shape (highest + 1,); index is the order, A_0 = 0.

    From the binomial series of the square root, with each power of the sine written as a cosine series.
    """
    series = np.zeros(highest + 1)
    series[1] = 1.0
    for half in range(1, highest // 2 + 1):
        series[2 * half] = (2 * half) ** 2 * _cosine_of_root(ratio, half)
    return series


def truncated_orders(ratio: float, highest: int) -> FloatArray:
    """The textbook's series: A_1 = 1, A_2 = ratio, nothing beyond; shape (highest + 1,)."""
    series = np.zeros(highest + 1)
    series[1:3] = (1.0, ratio)
    return series


@cache
def _cosine_of_root(ratio: float, half: int) -> float:
    """Coefficient of cos(2 half a) in sqrt(1 - ratio² sin²(a)) / ratio."""
    total, choose, power = 0.0, 1.0, 1.0
    for n in range(1, 2000):
        choose *= (1.5 - n) / n
        power *= -(ratio**2) / 4.0
        if n < half:
            continue
        term = 2.0 * choose * power * (-1) ** half * comb(2 * n, n - half)
        total += term
        if abs(term) < _SMALL * abs(total):
            break
    return total / ratio
