"""Sharpness of the peaks of what an unbalance drives: N / (N2 - N1) at 1/sqrt(2) of the peak."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms.form import AtWorst, Worst
from vibopt.forms.orbit import Orbit, frozen
from vibopt.forms.whirling import of_whirls
from vibopt.mechanics.model import Model
from vibopt.mechanics.orbits import spun
from vibopt.mechanics.peaks import peaks
from vibopt.records import dataclass
from vibopt.signals import Band, Drive, Output

_TURN = 1e-4
_ABOUT, _APART, _ACROSS = 0.05, 4.0, 12
"""Log of how far beside a band whirls are watched; over its width, how far apart; in how many steps at most."""
_BESIDE, _HALF, _FAR, _SHARP = 1e-6, 0.5, {-1.0: 0.999, 1.0: 1.0}, 1e6
"""Part of a speed beside which a peak is less; part of it that a side is wide at most; parts of it that are looked at
on either side; factor from which on a peak is one that nothing damps."""
_OUTWARD = np.unique(np.concatenate([np.geomspace(1e-9, 1.0, 160), np.linspace(0.01, 1.0, 100)]))
"""Parts of a side that are looked at, beside those where a pole is near."""

_AT_ONCE, _CLOSE = 50, 2e-13
"""Speeds of a side that are asked at once where it is narrowed; part of a speed by which it is known."""

Size = Callable[[FloatArray], FloatArray]


@dataclass(frozen=True, slots=True)
class Amplification(AtWorst):
    """The greatest of all peaks inside bands of the spin; 0 of none, infinite where nothing damps one."""

    output: Output
    shaken: tuple[Drive, ...]
    dear = True
    no_bounds = "is an amplification factor, which has no bounds on boxes of designs"
    not_convex = "is an amplification factor, which is not convex in stiffness and damping"
    rough = "is an amplification factor, which begins where a peak does"

    def acting(self, model: Model) -> FloatArray:
        return of_whirls(model)

    def watched(self, ends: tuple[float, ...]) -> list[float]:
        """The ends of each band, and speeds across and beside it, a few times as far apart as it is wide.

        A peak enters the band as its whirl is about as fast as an end, the farther off the more it is damped.
        """
        found: list[float] = []
        for band in [band for drive in self.shaken for band in drive.bands]:
            low, high = max(band.low, _BESIDE), band.high
            wide = np.log(high / low) + 2.0 * _ABOUT
            count = int(min(np.ceil(wide / (_APART * np.log(high / low) + _BESIDE)), _ACROSS))
            found += [low, high, *np.geomspace(low * np.exp(-_ABOUT), high * np.exp(_ABOUT), count + 1).tolist()]
        return found

    def slope(self, model: Model, x: FloatArray) -> FloatArray:
        """By wider differences than elsewhere: a level top says where it is to fewer digits."""
        found = np.zeros(len(x))
        for i in range(len(x)):
            ends = [self.value(model, x * np.exp(sense * _TURN * (np.arange(len(x)) == i))) for sense in (1.0, -1.0)]
            if all(0.0 < value < np.inf for value in ends):
                found[i] = np.log(ends[0] / ends[1]) / (2.0 * _TURN)
        return found

    def worst(self, model: Model, x: FloatArray, *, least_wanted: bool = False) -> Worst:
        found = [(factor, speed, drive.name) for drive in self.shaken for speed, factor in self._all(model, x, drive)]
        if not found:
            return Worst(0.0)
        factor, speed, name = max(found)
        return Worst(factor, {name: speed})

    def _all(self, model: Model, x: FloatArray, drive: Drive) -> list[tuple[float, float]]:
        """Speeds [rad/s] and factors of all peaks."""
        orbit, rotor = Orbit(self.output, (drive,), "sum"), spun(model, x)
        knots = rotor.knots
        ends = (float(knots[0]), float(knots[-1])) if len(knots) else (0.0, np.inf)

        def size(speeds: FloatArray) -> FloatArray:
            return orbit.sizes(model, x, drive, speeds)

        wider = [Band(band.low, (1.0 + _FAR[1.0]) * band.high) for band in drive.bands]
        singular = rotor.singular(np.concatenate([frozen(band, knots) for band in wider]))
        tops = peaks(size, drive.bands, singular, knots, within=0.0)
        found: list[tuple[float, float]] = []
        for top in tops:
            beside = top.speed * np.array([1.0 - _BESIDE, 1.0 + _BESIDE])
            inside = any(band.low < beside[0] and beside[1] < band.high for band in drive.bands)
            known = any(abs(top.speed - speed) <= _BESIDE * speed for speed, _ in found)
            if inside and not known and (not np.isfinite(top.value) or (size(beside) < top.value).all()):
                found.append((top.speed, factor_of(size, top.speed, top.value, ends, singular.real)))
        return found


def factor_of(size: Size, speed: float, top: float, ends: tuple[float, float], poles: FloatArray) -> float:
    """Amplification factor of a peak at a speed [rad/s], as far as a response is known.

    A side on which the response rises above the peak, or is not known, before it falls to 1/sqrt(2) of it is as wide as
    the other; 1 where both are so.  Looked for from rest to twice the speed; no side is wider than half the speed.
    `poles` are speeds [rad/s] near which it may rise.
    """
    if not np.isfinite(top):
        return float("inf")
    sides = [_side(size, speed, top, sense, ends, poles) for sense in (-1.0, 1.0)]
    known = [value for value in sides if value is not None]
    if not known:
        return 1.0
    wide = sum(known) * (2.0 / len(known))
    return float("inf") if wide * _SHARP <= speed else speed / wide


def _side(
    size: Size, speed: float, top: float, sense: float, ends: tuple[float, float], poles: FloatArray
) -> float | None:
    """How far beside a peak the response is 1/sqrt(2) of it [rad/s]; None where it is not on this side."""
    level, most = top / np.sqrt(2.0), _HALF * speed
    reach = min(_FAR[sense] * speed, speed - ends[0] if sense < 0.0 else ends[1] - speed)
    near = sense * (poles - speed)
    off = np.unique(np.concatenate([reach * _OUTWARD, near[(near > 0.0) & (near < reach)]]))
    values = size(speed + sense * off)
    fallen, risen = np.flatnonzero(values <= level), np.flatnonzero(values > top * (1.0 + 1e-9))
    if len(risen) and not (len(fallen) and fallen[0] < risen[0]):
        return None
    if not len(fallen):
        return most if reach == _FAR[sense] * speed else None
    high = float(off[fallen[0]])
    low = float(off[fallen[0] - 1]) if fallen[0] else 0.0
    if low >= most:
        return most
    while high - low > _CLOSE * speed:  # many speeds at once cost little more than one
        inside = np.linspace(low, high, _AT_ONCE)[1:-1]
        fallen = np.flatnonzero(size(speed + sense * inside) <= level)
        k = int(fallen[0]) if len(fallen) else len(inside)
        low, high = float(inside[k - 1]) if k else low, float(inside[k]) if k < len(inside) else high
    return min(high, most)
