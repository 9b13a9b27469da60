"""Motions that slip all the time under dry friction, of many frequencies at once: Den Hartog's closed form (1931).

Lengths, times and letters are those of `dry_friction`: r^2 z'' + 2 zeta r z' + z + f sgn(z') = cos(theta).
Arrays stand for machines in a row, (n,), and behind them for instants, (n, m).
"""

from __future__ import annotations

from math import pi

import numpy as np
from numpy.polynomial import chebyshev

from vibopt.arrays import BoolArray, ComplexArray, FloatArray
from vibopt.records import cached_property, dataclass

NODES = 0.5 - 0.5 * np.cos(np.pi * np.arange(15) / 14.0)
COEFFICIENTS = np.linalg.inv(chebyshev.chebvander(2.0 * NODES - 1.0, 14)).T
_FINE = np.linspace(-1.0, 1.0, 33)
_VALUES = chebyshev.chebvander(_FINE, 14).T
_SLOPES = chebyshev.chebder(np.eye(15)).T
_BENDS = chebyshev.chebder(np.eye(15), 2).T
PANEL, _SLOWEST = 1.2, 2e-3
"""Radians of the fastest motion on a panel; frequency over the natural one below which equal panels are too many."""
_GONE, _APART, _NEXT = 42.0, 1e-2, 0.05
"""Exponent behind which a motion has faded; rates that are next to alike, as tangents and as exponentials."""
_INSIDE, _SAFE, _NEAR, _STEPS = (np.arange(12.0) + 0.5) / 12.0, 0.02, 2e-3, 3
"""Points inside a panel; parts of the greatest below which nothing falls between them, or between fine ones; Newton's
steps from these to a top."""


@dataclass(frozen=True)
class Slipping:
    """Motions under cos(theta) that begin at their greatest place and slip down half a cycle.

    r, ratio, friction
        Frequency over the natural one; viscous damping over critical; friction over the amplitude of the force; (n,).
    """

    r: FloatArray
    ratio: FloatArray
    friction: FloatArray

    @cached_property
    def poles(self) -> tuple[ComplexArray, ComplexArray]:
        """Rates of free motion [1/rad], the slower first."""
        beta = self.ratio / self.r
        root = np.sqrt((beta**2 - 1.0 / self.r**2).astype(complex))
        slow = np.where(root.imag != 0.0, root - beta, -1.0 / self.r**2 / (beta + root))
        return slow, -(beta + root)

    @cached_property
    def tops(self) -> tuple[FloatArray, FloatArray]:
        """Angle and size of the greatest place; not a number where no half cycle closes."""
        first, second = self.poles
        slow, fast = (np.tanh(0.5 * pi * np.maximum(pole.real, -200.0) + 0.5j * pi * pole.imag) for pole in self.poles)
        apart = second - first
        half = 0.5 * pi * apart
        with np.errstate(all="ignore"):
            near = 0.5 * pi * (1.0 + half**2 / 6.0 + half**4 / 120.0)
            near = near / (np.cosh(0.5 * pi * first) * np.cosh(0.5 * pi * second))
            per = np.where(np.abs(apart) > _APART, (fast - slow) / apart, near)
            steady = 1.0 - self.r**2 + 2j * self.ratio * self.r
            lag = -per.real * self.friction / self.r**2 * np.abs(steady)
            turn = np.arcsin(np.where((np.abs(lag) < 1.0) & (steady != 0.0), lag, np.nan))
            top = np.cos(turn) / np.abs(steady) + (slow - per * first).real * self.friction
        return np.asarray(turn + np.angle(steady)), np.asarray(top)

    def of(self, some: BoolArray) -> Slipping:
        return Slipping(self.r[some], self.ratio[some], self.friction[some])

    def at(self, tau: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Place, speed and acceleration so long behind the greatest place [rad], (n, m)."""
        begin, top = self.tops
        r, ratio, push = self.r[:, None], self.ratio[:, None], self.friction[:, None]
        slow, fast = self.poles
        return moved((slow[:, None], fast[:, None]), r, ratio, push, (begin[:, None], top[:, None], 0.0), tau)

    def greatest(self, parts: FloatArray, phasor: ComplexArray) -> FloatArray:
        """Greatest size of parts . (z, z', z'') + Re(phasor e^(i theta)) in a cycle, (n,), parts (3, n).

        Not a number where a motion does not slip all the time, is next to stopping, or is slow.
        """
        found = np.full(self.r.shape, np.nan)
        closed = np.isfinite(self.tops[1]) & (self.r > _SLOWEST)
        panels = 1 << np.ceil(np.log2(pi * np.maximum(1.0, 1.0 / np.maximum(self.r, _SLOWEST)) / PANEL + 1.0)).astype(
            int
        )
        for count in np.unique(panels[closed & (self.ratio < 1.0)]):
            some = closed & (self.ratio < 1.0) & (panels == count)
            found[some] = self.of(some)._on(np.linspace(0.0, pi, count + 1), parts[:, some], phasor[some])
        for k in np.flatnonzero(closed & (self.ratio >= 1.0)):
            some = np.arange(len(found)) == k
            own = self.of(some)
            found[k] = own._on(edges((own.poles[0][0], own.poles[1][0]), pi), parts[:, some], phasor[some])[0]
        return found

    def _on(self, joints: FloatArray, parts: FloatArray, phasor: ComplexArray) -> FloatArray:
        """As `greatest`, on panels between joints."""
        low, width = joints[:-1, None], np.diff(joints)[:, None]
        found = np.where(self._never_rests(np.ravel(low + width * _INSIDE)), np.abs(parts[0]) * self.tops[1], np.nan)
        some = ~np.isnan(found) & (parts[1:].any(axis=0) | (phasor != 0.0))
        if not some.any():
            return found
        own, tau = self.of(some), np.ravel(low + width * NODES)[None, :]
        turn = np.exp(1j * (own.tops[0][:, None] + tau))
        values = (parts[:, some, None] * own.at(tau)).sum(axis=0) + (phasor[some, None] * turn).real
        found[some] = summits(values.reshape(len(own.r), -1, len(NODES)))
        return found

    def _never_rests(self, tau: FloatArray) -> BoolArray:
        """Whether the speed is far from zero everywhere but at both ends, where it turns."""
        part = -self.at(tau[None, :])[1] / (tau * (pi - tau))
        return np.asarray(part.min(axis=1) > _SAFE * part.max(axis=1))


def summits(values: FloatArray) -> FloatArray:
    """Greatest sizes of smooth functions by their values at the nodes of panels, (n, panels, nodes)."""
    coefficients = values @ COEFFICIENTS
    fine = np.abs(coefficients @ _VALUES)
    best: FloatArray = np.maximum(np.abs(values).max(axis=(1, 2)), fine.max(axis=(1, 2)))
    beside = np.pad(fine, ((0, 0), (0, 0), (1, 1)), constant_values=-1.0)
    tops = (fine >= beside[..., :-2]) & (fine >= beside[..., 2:]) & (fine >= (1.0 - _NEAR) * best[:, None, None])
    which, panel, cell = np.nonzero(tops)
    own, at, step = coefficients[which, panel], _FINE[cell], _FINE[1] - _FINE[0]
    low, high = np.maximum(at - step, -1.0), np.minimum(at + step, 1.0)
    slope, bend = own @ _SLOPES, own @ _BENDS
    for _ in range(_STEPS):
        turned = _basis(at)
        first, second = (slope * turned[:, :-1]).sum(axis=1), (bend * turned[:, :-2]).sum(axis=1)
        at = np.clip(at - first / np.where(second == 0.0, np.inf, second), low, high)
    np.maximum.at(best, which, np.abs((own * _basis(at)).sum(axis=1)))
    return best


def _basis(at: FloatArray) -> FloatArray:
    """Chebyshev's polynomials at places, (n, 15)."""
    return np.asarray(np.cos(np.arange(15) * np.arccos(at)[:, None]))


def moved(
    poles: tuple[ComplexArray, ComplexArray] | tuple[complex, complex],
    r: FloatArray | float,
    ratio: FloatArray | float,
    rest: FloatArray | float,
    begun: tuple[FloatArray | float, FloatArray | float, FloatArray | float],
    tau: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Place, speed and acceleration of a slip toward `rest`, begun at an angle from a place with a speed."""
    begin, place, speed = begun
    blow, rate, pushed = answer(poles, tau)
    square, turn = r**2, np.exp(1j * np.asarray(begin))
    z = rest + (place - rest) * (rate + 2.0 * ratio / r * blow) + speed * blow + (turn * pushed).real / square
    v = -(place - rest) * blow / square + speed * rate + (turn * (1j * pushed + blow)).real / square
    a = (np.cos(begin + tau) + rest - z) / square - 2.0 * ratio / r * v
    return z, v, a


def answer(
    poles: tuple[ComplexArray, ComplexArray] | tuple[complex, complex], tau: FloatArray
) -> tuple[FloatArray, FloatArray, ComplexArray]:
    """Response to a blow and its rate, and the response from rest to e^(i tau), each for a mass of one."""
    near, far = poles
    one, other = np.exp(near * tau), np.exp(far * tau)
    own, forced = _divided(near, far, tau, one - other), _divided(near, 1j, tau, one - np.exp(1j * tau))
    rate = 0.5 * ((near + far) * own + one + other)
    return own.real, rate.real, np.asarray((forced - own) / (1j - far))


def _divided(
    a: ComplexArray | complex, b: ComplexArray | complex, tau: FloatArray, apart: ComplexArray
) -> ComplexArray:
    """(e^(a tau) - e^(b tau)) / (a - b), of which `apart` is the numerator; also where the two are next to alike."""
    gap = np.asarray(a - b)
    if (np.abs(gap) > _NEXT).all():
        return np.asarray(apart / gap)
    half = 0.5 * gap * tau
    square, close = half * half, (np.abs(half) < 0.5) & (np.abs(gap) <= _NEXT)
    series = 1.0 + square / 6.0 * (1.0 + square / 20.0 * (1.0 + square / 42.0 * (1.0 + square / 72.0)))
    near = np.exp(0.5 * (a + b) * tau) * tau * series
    return np.where(close, near, apart / np.where(gap == 0.0, 1.0, gap))


def radians_at(rates: ComplexArray, omega: float = 1.0) -> FloatArray:
    """Radians of free motions with such rates, as far as they have not faded, in half a cycle at omega, (n,)."""
    with np.errstate(divide="ignore"):
        return np.asarray(np.minimum(pi / omega, _GONE / np.abs(rates.real)) * np.abs(rates))


def edges(poles: tuple[complex, complex], length: float) -> FloatArray:
    """Ends of panels on which every part of a motion is smooth, from 0 to a length [rad]."""
    if poles[0].imag and -poles[0].real * length <= _GONE:
        count = int(length * max(1.0, abs(poles[0])) / PANEL) + 1
        return np.asarray(np.arange(count + 1) * (length / count))
    found = [np.linspace(0.0, length, int(length / PANEL) + 2)]
    for pole in poles:
        reach = min(length, _GONE / -pole.real if pole.real else length)
        found.append(np.linspace(0.0, reach, int(reach * abs(pole) / PANEL) + 2))
    joints = np.unique(np.concatenate(found))
    apart: FloatArray = joints[np.append(np.diff(joints) > 1e-13 * length, True)]
    return apart
