"""Enumeration of the choices in three planes by hand: pairs first, and those that cannot win pruned."""

from __future__ import annotations

import numpy as np

from vibopt.balancing.question import Question
from vibopt.forms import ComplexArray, FloatArray, IntArray

_PAIRS = 256
"""Pairs whose third planes are looked at together."""


def best_choice(question: Question) -> ComplexArray | None:
    """The correction with the smallest worst residual, or of the least mass that keeps the limits; None without one.

    Parameters
    ----------
    question
        A list in each of three planes, equal importance; goal "worst" or "correction".

    Notes
    -----
    A pair of the first two planes leaves at each reading no less than what it leaves there without the third plane,
    less the most that the third can do: with the pairs in the order of that bound (of their mass), the search ends at
    the first that cannot win any more.
    """
    options = [option for option in question.options if option is not None]
    masses = [one for one in question.option_masses if one is not None]
    effects = [np.outer(option, column) for option, column in zip(options, question.H.T, strict=True)]
    reach = np.abs(effects[2]).max(axis=0)
    left = question.y0 + effects[0][:, None, :] + effects[1][None, :, :]
    least = np.maximum(np.abs(left) - reach, 0.0)
    weights = masses[0][:, None] + masses[1][None, :]
    by_mass = question.goal == "correction"
    bound = weights + masses[2].min() if by_mass else least.max(axis=-1)
    sound = (least <= question.limits).all(axis=-1)
    best, chosen = np.inf, None
    for pairs in _blocks(bound, sound):
        if bound[tuple(pairs[0])] >= best:
            break
        remaining = np.abs(left[pairs[:, 0], pairs[:, 1], None, :] + effects[2])
        value = weights[pairs[:, 0], pairs[:, 1], None] + masses[2] if by_mass else remaining.max(axis=-1)
        value = np.where((remaining <= question.limits).all(axis=-1), value, np.inf)
        row, third = np.unravel_index(int(value.argmin()), value.shape)
        if value[row, third] < best:
            best, chosen = float(value[row, third]), (*pairs[row].tolist(), int(third))
    return None if chosen is None else np.array([option[k] for option, k in zip(options, chosen, strict=True)])


def _blocks(bound: FloatArray, sound: FloatArray) -> list[IntArray]:
    """Sound pairs in the order of their bound, in blocks (n_pairs, 2)."""
    pairs = np.argwhere(sound)
    pairs = pairs[np.argsort(bound[sound], kind="stable")]
    return [pairs[begin : begin + _PAIRS] for begin in range(0, len(pairs), _PAIRS)]
