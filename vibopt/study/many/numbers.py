"""How every number of a question follows the varied fact: constant, a power, or a straight line."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from vibopt.forms import FloatArray
from vibopt.study.many.lower import RefusedError

Numbers = Mapping[str, FloatArray]
_EXACT = 1e-12
_PLACES = (0.0, 1.0, 0.41, 0.77)
"""Where the question is read, as parts of the sweep: the ends fix the law, the others verify it."""


def samples(values: FloatArray) -> FloatArray:
    """Values of the fact at which a question is read [SI]."""
    places = np.unique(np.round(np.array(_PLACES) * (len(values) - 1)).astype(int))
    return np.asarray(values[places])


def follow(values: FloatArray, read: Callable[[float], Mapping[str, float]]) -> dict[str, FloatArray]:
    """Every number at all values: shape () where it is the same, else (n_values,).

    Parameters
    ----------
    values
        Values of the fact, rising.
    read
        Numbers at one value.

    Raises
    ------
    RefusedError
        A number follows no such law to 12 digits.
    """
    at = samples(values)
    tables = [read(float(v)) for v in at]
    if any(one.keys() != tables[0].keys() for one in tables):
        raise RefusedError
    return {name: _law(at, np.array([one[name] for one in tables]), values) for name in tables[0]}


def _law(at: FloatArray, known: FloatArray, values: FloatArray) -> FloatArray:
    if np.ptp(known) == 0.0:
        return np.array(known[0])
    first, last = known[0], known[-1]
    size = float(np.abs(known).max())
    if at[0] > 0.0 and np.all(known > 0.0):
        exponent = round(2.0 * np.log(last / first) / np.log(at[-1] / at[0])) / 2.0
        if _fits(first * (at / at[0]) ** exponent, known, np.abs(known)):
            constant = known[len(at) // 2] / at[len(at) // 2] ** exponent
            return np.asarray(constant * values**exponent)
    slope = (last - first) / (at[-1] - at[0])
    if _fits(first + slope * (at - at[0]), known, np.full(len(known), size)):
        return np.asarray(first + slope * (values - at[0]))
    raise RefusedError


def _fits(guess: FloatArray, known: FloatArray, size: FloatArray) -> bool:
    return bool(np.all(np.abs(guess - known) <= _EXACT * size))
