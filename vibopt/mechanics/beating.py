"""Greatest of a sum of waves that fade or last, over any time: stretches on which their beats cannot reach it drop out.

On a stretch, waves of nearly one speed are one carrier with a slow amplitude.  The sum of these amplitudes bounds all;
what is left is halved until it is shorter than a radian, so that no period costs anything where no beat has its top.
"""

from __future__ import annotations

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray

_BEGIN, _MOST, _TRIED = 64, 1 << 17, 4
"""Stretches at the beginning and at most, and those in which a greater value is looked for at each level."""
_SURE, _NOTHING, _SAMPLES, _TOGETHER, _NEWTON = 1e-12, 1e-16, 97, 1.0, 6
"""Part of the greatest that is none, and of all waves one that is; samples of a turn; radians by which waves of one
carrier part; steps to a top."""


def highest(rates: ComplexArray, waves: ComplexArray, length: float, least: float) -> tuple[float, float, bool]:
    """Greatest size of Re(sum of waves e^(rates t)) from 0 to `length`, when, and whether more was left than could be
    looked at; `least` and -1 where nothing is greater.
    """
    felt = np.flatnonzero(np.abs(waves) > _NOTHING * np.abs(waves).sum())  # what has faded sets no pace
    order = felt[np.argsort(rates[felt].imag)]
    rates, waves = rates[order], waves[order]
    fast, best, at = float(np.abs(rates).max(initial=0.0)), least, -1.0
    middle, half = np.asarray((np.arange(_BEGIN) + 0.5) * (length / _BEGIN), dtype=float), 0.5 * length / _BEGIN
    while len(middle):
        bound, hope = _bounds(rates, waves, middle, half)
        left = np.flatnonzero(bound > best * (1.0 + _SURE))
        short = half * fast <= 0.5
        tried = left if short else left[np.argsort(-hope[left], kind="stable")[:_TRIED]]
        reach = half if short else 2.0 * np.pi / fast
        value, when = _tops(rates, waves, middle[tried], reach, length)
        if value > best:
            best, at = value, when
        left = left[bound[left] > best * (1.0 + _SURE)]
        if short or not len(left):
            break
        if 2 * len(left) > _MOST:
            return best, at, True
        half *= 0.5
        middle = (middle[left, None] + half * np.array([-1.0, 1.0])).ravel()
    return best, at, False


def _bounds(rates: ComplexArray, waves: ComplexArray, middle: FloatArray, half: float) -> tuple[FloatArray, FloatArray]:
    """What a sum may reach on stretches about their middles (n,), and what it may be there if all carriers meet."""
    now = waves * np.exp(rates * middle[:, None])
    grown = np.abs(waves) * np.exp(rates.real * middle[:, None] + np.abs(rates.real) * half)
    bound, hope = np.zeros(len(middle)), np.zeros(len(middle))
    apart = np.diff(rates.imag) * half > _TOGETHER
    for own in np.split(np.arange(len(rates)), np.flatnonzero(apart) + 1):
        carrier = 0.5 * float(rates.imag[own[0]] + rates.imag[own[-1]])
        size = np.abs if carrier * half > _TOGETHER else _real
        off = rates[own] - (1j * carrier if size is np.abs else 0.0)
        whole, slope = now[:, own].sum(axis=1), (now[:, own] @ off) * half
        bent = 0.5 * half**2 * (grown[:, own] @ np.abs(off) ** 2)
        bound += np.minimum(np.maximum(size(whole + slope), size(whole - slope)) + bent, grown[:, own].sum(axis=1))
        hope += size(whole)
    return bound, hope


def _real(values: ComplexArray) -> FloatArray:
    return np.abs(values.real)


def _tops(
    rates: ComplexArray, waves: ComplexArray, about: FloatArray, reach: float, length: float
) -> tuple[float, float]:
    """Greatest size so near to some times (n,), and when."""
    if not len(about):
        return 0.0, -1.0
    times = np.clip(about[:, None] + reach * np.linspace(-1.0, 1.0, _SAMPLES), 0.0, length)
    sizes = np.abs((np.exp(times[..., None] * rates) @ waves).real)
    rows = np.arange(len(about))
    at = times[rows, sizes.argmax(axis=1)]
    low, high = (np.clip(at + side * 2.0 * reach / (_SAMPLES - 1), 0.0, length) for side in (-1.0, 1.0))
    found, when = float(sizes.max()), float(times.ravel()[sizes.argmax()])
    for _ in range(_NEWTON):
        turned = np.exp(at[:, None] * rates) * waves
        value, slope, bend = (np.real(turned @ rates**k) for k in range(3))
        if float(np.abs(value).max()) > found:
            found, when = float(np.abs(value).max()), float(at[np.abs(value).argmax()])
        at = np.clip(at - slope / np.where(bend * value < 0.0, bend, np.inf), low, high)
    return found, when
