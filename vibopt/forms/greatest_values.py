"""The greatest values of a form through its poles, proven to be all there are; None where there is a doubt."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.mechanics.cells import Stretches
from vibopt.mechanics.combine import Extreme
from vibopt.mechanics.harmonic import mount_count
from vibopt.mechanics.highest import local_maxima
from vibopt.mechanics.model import Model
from vibopt.mechanics.pole_residue import Reading, reading_of
from vibopt.mechanics.polynomials import Weight
from vibopt.records import dataclass
from vibopt.signals import Band, Drive

if TYPE_CHECKING:
    from vibopt.forms.modulus import Modulus

_MOST = 40
"""Number of free coordinates up to which the poles are worth their cost."""
_MOST_POWER = 6
_ROOM = 1e-6
_TRUST = 1e-7


def highest(model: Model, form: Modulus, drive: Drive, x: FloatArray, within: float) -> list[Extreme] | None:
    """Local maxima and band ends of the response to one excitation, the highest first.

    Parameters
    ----------
    model, form, drive
        What is asked.
    x
        Design, shape (n_vars,).
    within
        Part of the greatest value that one must have to be counted.

    Returns
    -------
    list[Extreme] | None
        Speeds [rad/s], and values from direct solutions there.
        None where the sum over the poles does not apply or is not to be trusted.
    """
    if model.spins or not 1 < model.n_free <= _MOST or len(drive.lines) != 1 or form.rigid_link:
        return None
    reading = reading_of(model, form.output, drive.lines[0], x)
    if reading is None:
        return None
    try:
        with np.errstate(all="ignore"):
            points = all(band.is_point for band in drive.bands)
            found = (_at_points if points else _found)(reading, drive.bands, x, within)
    except np.linalg.LinAlgError:
        return None
    share = mount_count(model, form.output, x)
    if found is None or share == 1.0:
        return found
    return [Extreme(one.value / share, one.speed) for one in found]


def _found(reading: Reading, bands: tuple[Band, ...], x: FloatArray, within: float) -> list[Extreme] | None:
    plan = _plan(reading, bands)
    if plan is None:
        return None
    modes = reading.oscillator.modes(x)
    ends = reading.ends(modes)
    h = reading.fractions(modes, ends)
    made = local_maxima(h, plan.weight, plan.stretches, plan.ends, within * (1.0 - _ROOM)) if h is not None else None
    if h is None or made is None:
        return None
    count = len(made.at)
    points = np.concatenate([made.at, made.probes])
    speeds = points * (reading.oscillator.unit / reading.order)
    value = np.abs(reading.direct(modes, ends, points)) * (plan.size or reading.size(speeds))
    best = float(value[:count].max(initial=0.0))
    wrong = np.abs(np.concatenate([made.value, made.sizes]) * (plan.size or 1.0) - value)
    if not (0.0 < best < np.inf and wrong.max() <= _TRUST * best):
        return None
    exact = plan.speeds
    triples = zip(made.at.tolist(), value.tolist(), speeds.tolist(), strict=False)
    found = [Extreme(v, exact.get(w, s)) for w, v, s in triples if v >= within * best]
    return sorted(found, key=lambda one: -one.value)


def _at_points(reading: Reading, bands: tuple[Band, ...], x: FloatArray, within: float) -> list[Extreme] | None:
    """Single speeds need no poles."""
    modes = reading.oscillator.modes(x)
    speeds = np.array([band.low for band in bands])
    at = speeds * (reading.order / reading.oscillator.unit)
    value = np.abs(reading.direct(modes, reading.ends(modes), at)) * reading.size(speeds)
    floor = within * value.max()
    if not 0.0 < floor < np.inf:
        return None
    found = [Extreme(v, s) for v, s in zip(value.tolist(), speeds.tolist(), strict=True) if v >= floor]
    return sorted(found, key=lambda one: -one.value)


@dataclass(frozen=True, slots=True)
class _Plan:
    """Where to look, frequencies in units.

    stretches
        Parts of the axis on which the weight is smooth, ascending.
    ends
        The ends of all of them in turn, shape (2 n_stretches,).
    weight
        On each; None where it is the same constant on all.
    size
        What |h| is multiplied by where that is one number; else 0.
    speeds
        Speed at each end of a stretch [rad/s], free of rounding.
    """

    stretches: Stretches
    ends: FloatArray
    weight: Weight | None
    size: float
    speeds: dict[float, float]


@lru_cache(maxsize=64)
def _plan(reading: Reading, bands: tuple[Band, ...]) -> _Plan | None:
    """None for single speeds and for weights that are no polynomials."""
    unit, order = reading.oscillator.unit, reading.order
    stretches, parts = [], []
    speeds: dict[float, float] = {}
    for band in bands:
        for piece in reading.amplitude.pieces:
            low, high = max(band.low, piece.band.low), min(band.high, piece.band.high)
            power = piece.power + reading.power
            if band.is_point or not 0 <= power <= _MOST_POWER:
                return None
            if low >= high:
                continue
            stretches.append((low * order / unit, high * order / unit))
            speeds |= {low * order / unit: low, high * order / unit: high}
            scale = unit**reading.power * (unit / order) ** piece.power
            parts.append((piece.constant * scale, piece.slope * scale * unit / order, power))
    if not stretches:
        return None
    constant, slope, power_of = (np.array(one) for one in zip(*parts, strict=True))
    plain = not slope.any() and not power_of.any() and (constant == constant[0]).all()
    weight = None if plain else Weight(constant, slope, power_of)
    size = abs(float(constant[0])) if plain else 0.0
    return _Plan(tuple(stretches), np.array(stretches).ravel(), weight, size, speeds)
