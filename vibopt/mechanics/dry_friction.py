"""Steady motion of one mass on a spring, a damper and dry friction under a harmonic force: it holds, slips, or stops.

Between two stops the motion is linear and known in closed form.  Without stops a half cycle closes by itself (Den
Hartog, 1931, with the damper beside); with stops, or with more turns than two in a cycle, half cycles are followed from
event to event and closed by Newton's method on their exact derivative.  Two motions under the same force never move
apart in energy, since friction opposes their difference, so that what repeats is the steady motion, whatever it began
from; where there is no damper and the natural frequency is a whole multiple of that of the force, others swing beside.

Time is counted in radians of the force, lengths in static deflections under its amplitude:
r^2 z'' + 2 zeta r z' + z + f sgn(z') = cos(theta).
"""

from __future__ import annotations

import cmath
from dataclasses import replace
from functools import lru_cache
from itertools import islice
from math import acos, cos, floor, isfinite, pi, sqrt

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike

from vibopt.arrays import FloatArray
from vibopt.mechanics.closing import closing
from vibopt.mechanics.slipping import COEFFICIENTS, NODES, Slipping, edges, moved, summits
from vibopt.records import cached_property, dataclass

_CHUNK, _ALONG, _SAFE = 12, np.arange(1.0, 13.0) / 12.0, 0.02
"""Panels that are looked at together; points up to the end of one; part of the greatest below which nothing falls
between them."""
_BEGUN, _ROUND, _ALIKE = 1e-6, 1e-13, 0.05
"""Part of a panel at its beginning that is no end of a motion; rounding of a state; rates that are next to alike."""
_SETTLED = 1e-9
_TURNS, _PATIENCE, _HELD = 4000, 8, 0.9
"""Half cycles at most; steps before another beginning is tried; friction from which on what it began with is rest,
where that swings on."""


@dataclass(frozen=True, slots=True)
class Piece:
    """Part of a motion: its beginning and length [rad], place and speed there, and the sense of slip, 0 of a hold."""

    begin: float
    length: float
    z: float
    v: float
    side: int


@dataclass(frozen=True)
class Rub:
    """The motion under cos(theta).

    r, ratio, friction
        Frequency over the natural one; viscous damping over critical; friction over the amplitude of the force.
    """

    r: float
    ratio: float
    friction: float

    @cached_property
    def half_cycle(self) -> tuple[Piece, ...] | None:
        """Pieces of half a cycle; the other half is its negative.  None where the motion grows without end."""
        if self.friction >= 1.0:
            return (Piece(0.0, pi, 0.0, 0.0, 0),)
        if self.grows:
            return None
        return self._without_stops() or self._closed()

    @property
    def grows(self) -> bool:
        """Whether at the undamped resonance friction takes less than the force gives."""
        return self.ratio == 0.0 and self.r == 1.0 and self.friction <= 0.25 * pi

    @cached_property
    def _slipping(self) -> Slipping:
        return Slipping(*(np.array([value]) for value in (self.r, self.ratio, self.friction)))

    @cached_property
    def poles(self) -> tuple[complex, complex]:
        """Rates of free motion [1/rad], the one nearer to that of the force first."""
        slow, fast = self._slipping.poles
        return complex(slow[0]), complex(fast[0])

    def at(self, piece: Piece, tau: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Place, speed and acceleration so long behind the beginning of a piece [rad]."""
        if piece.side == 0:
            still = np.zeros(tau.shape)
            return still + piece.z, still, still
        rest = -piece.side * self.friction
        return moved(self.poles, self.r, self.ratio, rest, (piece.begin, piece.z, piece.v), tau)

    def _answer_at(self, tau: float) -> tuple[float, float, complex]:
        """Response to a blow and its rate, and the response from rest to e^(i tau), for a mass of one."""
        near, far = self.poles
        one = cmath.exp(near * tau)
        other = one.conjugate() if near.imag else cmath.exp(far * tau)
        own = _divided_at(near, far, tau, one - other)
        forced = _divided_at(near, 1j, tau, one - cmath.exp(1j * tau))
        rate = 0.5 * ((near + far) * own + one + other)
        return own.real, rate.real, (forced - own) / (1j - far)

    def now(self, piece: Piece, tau: float) -> tuple[float, float, float]:
        """As `at`, at one time."""
        if piece.side == 0:
            return piece.z, 0.0, 0.0
        blow, rate, pushed = self._answer_at(tau)
        square, rest, turn = self.r**2, -piece.side * self.friction, cmath.exp(1j * piece.begin)
        z = rest + (piece.z - rest) * (rate + 2.0 * self.ratio / self.r * blow) + piece.v * blow
        z += (turn * pushed).real / square
        v = -(piece.z - rest) * blow / square + piece.v * rate + (turn * (1j * pushed + blow)).real / square
        return z, v, (cos(piece.begin + tau) + rest - z) / square - 2.0 * self.ratio / self.r * v

    def _rests(self, piece: Piece) -> float | None:
        """When a slip comes to rest [rad], behind its beginning; None where it does not within its length."""
        joints = edges(self.poles, piece.length)
        power = 0 if piece.v else 1 if self._pushed(piece.begin, piece.z) else 2
        for k in range(0, len(joints) - 1, _CHUNK):
            low, width = joints[k : k + _CHUNK + 1][:-1], np.diff(joints[k : k + _CHUNK + 1])
            tau = low[:, None] + width[:, None] * _ALONG
            part = piece.side * self.at(piece, tau.ravel())[1].reshape(tau.shape) / tau**power
            least, most = part.min(axis=1), np.abs(part).max(axis=1)
            for j in np.flatnonzero(least <= _SAFE * most):
                turned = np.flatnonzero(part[j] <= 0.0)
                plain = len(turned) and turned[0] > 1 and part[j, : turned[0] - 1].min() > _SAFE * most[j]
                value = (
                    self._between(piece, tau[j, turned[0] - 1], tau[j, turned[0]])
                    if plain
                    else self._closely(piece, float(low[j]), float(width[j]), first=bool(power) and k + j == 0)
                )
                if value is not None:
                    return value
        return None

    def _between(self, piece: Piece, low: float, high: float) -> float:
        """The root of the speed between times at which its signs differ: Newton's steps, halves where they leave."""
        tau = 0.5 * (low + high)
        for _ in range(60):
            _, v, a = self.now(piece, tau)
            low, high = (tau, high) if piece.side * v > 0.0 else (low, tau)
            step = tau - v / a if a else low
            last, tau = tau, step if low <= step <= high else 0.5 * (low + high)
            if abs(tau - last) <= _SETTLED * (high + 1.0):  # the next of Newton's steps is as short as its square
                break
        return tau

    def _closely(self, piece: Piece, low: float, width: float, *, first: bool) -> float | None:
        """The first rest on a panel by all roots of the polynomial through it, those of its beginning left out."""
        coefficients = piece.side * self.at(piece, low + width * NODES)[1] @ COEFFICIENTS
        roots = _real_roots(coefficients, _BEGUN if first else 0.0)
        if first and chebyshev.chebval((roots[0] if len(roots) else 1.0) - 1.0, coefficients) <= 0.0:
            return 0.0
        for root in roots:
            tau = low + width * float(root)
            for _ in range(2):
                _, v, a = self.now(piece, tau)
                tau -= v / a if a and abs(v / a) < 1e-3 else 0.0
            if piece.side * self.now(piece, tau)[2] <= 0.0:
                return tau
        return None

    def _without_stops(self) -> tuple[Piece, ...] | None:
        """One slip from the highest place to the lowest; None where that is not the motion."""
        begin, top = (float(one[0]) for one in self._slipping.tops)
        if not isfinite(top):
            return None
        piece = Piece(begin, pi, top, 0.0, -1)
        if not np.isnan(self._slipping.greatest(np.eye(3, 1), np.zeros(1, dtype=complex))[0]):
            return (piece,)
        if self._pushed(begin, top) != -1:  # friction holds it at the top for a while
            return None
        rests = self._rests(Piece(begin, pi * (1.0 + 1e-4), top, 0.0, -1))
        return (piece,) if rests is not None and abs(rests - pi) < 1e-6 else None

    def _closed(self) -> tuple[Piece, ...] | None:
        """Half a cycle from theta = 0 that ends at the negative of its beginning.

        From two states in turns, for where two motions nearly meet only one of them is soon there.
        """
        roads = [closing(self._half, self._size, state, _TURNS) for state in self._starts]
        for _ in range(_TURNS // _PATIENCE + 1):
            for road in roads:
                for known in islice(road, _PATIENCE):
                    if known is not None:
                        return known
        return None

    @property
    def _starts(self) -> list[FloatArray]:
        """States at theta = 0: of a motion that slips on where friction would stop it, and rest; the likelier first.

        One alone where what it began with swings on.
        """
        begin, top = (float(one[0]) for one in self._slipping.tops)
        if not isfinite(top):
            return [np.zeros(2)]
        turns = floor(-begin / pi)
        z, v, _ = self.now(Piece(begin, pi, top, 0.0, -1), -begin - turns * pi)
        found = [(-1.0) ** turns * np.array([z, v]), np.zeros(2)]
        return found[self.friction > _HELD :][:1] if self.ratio == 0.0 and (1.0 / self.r).is_integer() else found

    def _size(self, state: FloatArray) -> float:
        """Root of twice the energy of a state or a difference of two."""
        return float(np.hypot(state[0], self.r * state[1]))

    def _half(self, state: FloatArray) -> tuple[tuple[Piece, ...], FloatArray, FloatArray]:
        """Pieces from theta = 0 to pi, the state there, and its derivative in that at the beginning (2, 2)."""
        theta, z, v = 0.0, float(state[0]), float(state[1])
        pieces, slope = list[Piece](), np.eye(2)
        v = 0.0 if abs(v) < _ROUND else v
        side = int(np.sign(v)) or self._pushed(theta, z)
        while theta < pi:
            if side == 0:
                until, side = self._leaves(theta, z)
                until = min(until, pi)
                pieces.append(Piece(theta, until - theta, z, 0.0, 0))
                slope = np.diag([1.0, 0.0]) @ slope
                theta, v = until, 0.0
                continue
            whole = Piece(theta, pi - theta, z, v, side)
            rests = self._rests(whole)
            length = pi - theta if rests is None else min(rests, pi - theta)
            if length <= _ROUND and pieces and pieces[-1].side == 0:  # pushed by rounding alone: held until that turns
                pieces[-1] = replace(pieces[-1], length=pi - pieces[-1].begin)
                break
            z, v, before = self.now(whole, length)
            pieces.append(Piece(theta, length, whole.z, whole.v, side))
            blow, rate, _ = self._answer_at(length)
            own = rate + 2.0 * self.ratio / self.r * blow
            slope = np.array([[own, blow], [-blow / self.r**2, rate]]) @ slope
            theta = theta + length if rests is not None and length == rests else pi
            if theta < pi or rests == length:
                was, v = side, 0.0
                side = self._pushed(theta, z, was)
                behind = before - 0.0 if side == 0 else before + (was - side) * self.friction / self.r**2
                slope = np.diag([1.0, 0.0 if side == 0 else behind / before]) @ slope
        return tuple(pieces), np.array([z, v]), slope

    def _pushed(self, theta: float, z: float, was: int = 0) -> int:
        """The sense in which a mass at rest begins to slip, 0 where friction holds it; not that from which it came."""
        push = cos(theta) - z
        side = 0 if abs(push) <= self.friction else 1 if push > 0.0 else -1
        return 0 if was and side == was else side

    def _leaves(self, theta: float, z: float) -> tuple[float, int]:
        """When friction holds no longer, and the sense of the slip behind."""
        found = []
        for level, side in ((z + self.friction, 1), (z - self.friction, -1)):
            if abs(level) < 1.0:
                at = -side * acos(level)
                found.append((theta + (at - theta - 1e-14) % (2.0 * pi), side))
        return min(found, default=(float("inf"), 0))

    def greatest(self, parts: ArrayLike, phasor: complex) -> float:
        """Greatest size of parts . (z, z', z'') + Re(phasor e^(i theta)) in a cycle; infinite where it has no end."""
        pieces = self.half_cycle
        if pieces is None:
            return float("inf")
        return max(self._most(piece, np.asarray(parts, dtype=float), phasor) for piece in pieces)

    def equivalent(self, parts: ArrayLike, phasor: complex) -> float:
        """What is greatest by equivalent viscous damping, which takes as much in a cycle: a figure to compare with."""
        steady, push = 1.0 - self.r**2 + 2j * self.ratio * self.r, 4.0 / pi * self.friction
        if self.friction >= 1.0:
            return abs(phasor)
        if not steady:
            return float("inf") if push <= 1.0 else abs(phasor)
        beside, square = steady.imag * push, abs(steady) ** 2
        size = (sqrt(max(beside**2 - square * (push**2 - 1.0), 0.0)) - beside) / square
        if size <= 0.0:  # it says that nothing moves, where some does
            return abs(phasor)
        moved = 1.0 / (steady + 1j * push / size)
        return float(abs(moved * np.dot(parts, (1.0, 1j, -1.0)) + phasor))

    def _most(self, piece: Piece, parts: FloatArray, phasor: complex) -> float:
        """Greatest size on one piece."""

        def reading(tau: FloatArray) -> FloatArray:
            return np.asarray(parts @ self.at(piece, tau) + (phasor * np.exp(1j * (piece.begin + tau))).real)

        ends = np.abs(reading(np.array([0.0, piece.length])))
        if not (parts[1:].any() or phasor) or not piece.length:
            return float(ends.max())
        if piece.side == 0:
            tops = (-cmath.phase(phasor) - piece.begin + np.array([0.0, pi])) % (2.0 * pi)
            inside = tops[tops < piece.length]
            return float(np.abs(np.concatenate([ends, reading(inside)])).max())
        joints = edges(self.poles, piece.length)
        inside = joints[:-1, None] + np.diff(joints)[:, None] * NODES
        return max(float(ends.max()), float(summits(reading(inside.ravel()).reshape(1, *inside.shape))[0]))


@lru_cache(maxsize=4096)
def rub_of(r: float, ratio: float, friction: float) -> Rub:
    """The motion, kept: whatever is asked of it, it is followed once."""
    return Rub(r, ratio, friction)


def _divided_at(a: complex, b: complex, tau: float, apart: complex) -> complex:
    """(e^(a tau) - e^(b tau)) / (a - b), of which `apart` is the numerator; also where the two are next to alike."""
    half = 0.5 * (a - b) * tau
    if abs(a - b) > _ALIKE or abs(half) >= 0.5:
        return apart / (a - b)
    square = half * half
    series = 1.0 + square / 6.0 * (1.0 + square / 20.0 * (1.0 + square / 42.0 * (1.0 + square / 72.0)))
    return cmath.exp(0.5 * (a + b) * tau) * tau * series


def _real_roots(coefficients: FloatArray, begin: float) -> FloatArray:
    """Real roots of a Chebyshev series on 0 to 1, from `begin` on, ascending."""
    roots = chebyshev.chebroots(np.trim_zeros(coefficients, "b")) if np.count_nonzero(coefficients) > 1 else np.zeros(0)
    real = 0.5 + 0.5 * roots.real[np.abs(roots.imag) < 1e-9]
    return np.sort(real[(real >= begin - (begin == 0.0) * 1e-12) & (real <= 1.0 + 1e-12)])
