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
from math import acos, asin, cos, isfinite, pi, sqrt

import numpy as np
from numpy.polynomial import chebyshev

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.records import cached_property, dataclass

_NODES = 0.5 - 0.5 * np.cos(np.pi * np.arange(15) / 14.0)
_COEFFICIENTS = np.linalg.inv(chebyshev.chebvander(2.0 * _NODES - 1.0, 14)).T
_FINE = np.linspace(0.0, 1.0, 33)
_VALUES = chebyshev.chebvander(2.0 * _FINE - 1.0, 14).T
_PANEL, _GONE, _CHUNK = 1.2, 42.0, 12
"""Radians of the fastest motion on a panel; exponent behind which it has faded; panels that are looked at together."""
_INSIDE, _ALONG, _SAFE, _NEAR = (np.arange(12.0) + 0.5) / 12.0, np.arange(1.0, 13.0) / 12.0, 0.02, 2e-3
"""Points inside a panel, and up to its end; parts of the greatest below which nothing falls between them, or between
fine ones."""
_BEGUN, _ROUND, _ALIKE = 1e-6, 1e-13, 0.05
"""Part of a panel at its beginning that is no end of a motion; rounding of a state; rates that are next to alike."""
_SETTLED = 1e-9
_WARM, _TURNS = 2, 4000
"""Half cycles before Newton's method, and at most."""
_CLOSED, _ENOUGH, _FAR = 1e-13, 1e-9, 3.0
"""Part that may be left of a closed half cycle, at the latest; how far a step of Newton's may lead."""


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
    def _poles(self) -> tuple[complex, complex]:
        """Rates of free motion [1/rad], the one nearer to that of the force first."""
        beta = self.ratio / self.r
        root = cmath.sqrt(beta**2 - 1.0 / self.r**2)
        slow = root - beta if root.imag else -1.0 / self.r**2 / (beta + root)
        return slow, -(beta + root)

    def _answer(self, tau: FloatArray) -> tuple[FloatArray, FloatArray, ComplexArray]:
        """Response to a blow and its rate, and the response from rest to e^(i tau), each for a mass of one."""
        near, far = self._poles
        one = np.exp(near * tau)
        other = one.conj() if near.imag else np.exp(far * tau)
        own, forced = _divided(near, far, tau, one - other), _divided(near, 1j, tau, one - np.exp(1j * tau))
        rate = 0.5 * ((near + far) * own + one + other)
        return own.real, rate.real, (forced - own) / (1j - far)

    def at(self, piece: Piece, tau: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Place, speed and acceleration so long behind the beginning of a piece [rad]."""
        if piece.side == 0:
            still = np.zeros(tau.shape)
            return still + piece.z, still, still
        blow, rate, pushed = self._answer(tau)
        square, rest = self.r**2, -piece.side * self.friction
        turn = cmath.exp(1j * piece.begin)
        z = rest + (piece.z - rest) * (rate + 2.0 * self.ratio / self.r * blow) + piece.v * blow
        z = z + (turn * pushed).real / square
        v = -(piece.z - rest) * blow / square + piece.v * rate + (turn * (1j * pushed + blow)).real / square
        a = (np.cos(piece.begin + tau) + rest - z) / square - 2.0 * self.ratio / self.r * v
        return z, v, a

    def _answer_at(self, tau: float) -> tuple[float, float, complex]:
        """As `_answer`, at one time."""
        near, far = self._poles
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

    def _edges(self, length: float) -> FloatArray:
        """Ends of panels on which every part of a motion is smooth, from 0 to a length [rad]."""
        if self._poles[0].imag:
            fastest = max(1.0, abs(self._poles[0]))
            count = int(length * fastest / _PANEL) + 1
            return np.asarray(np.arange(count + 1) * (length / count))
        found = [np.linspace(0.0, length, int(length / _PANEL) + 2)]
        for pole in self._poles:
            reach = min(length, _GONE / -pole.real if pole.real else length)
            found.append(np.linspace(0.0, reach, int(reach * abs(pole) / _PANEL) + 2))
        edges = np.unique(np.concatenate(found))
        apart: FloatArray = edges[np.append(np.diff(edges) > _ROUND * length, True)]
        return apart

    def _rests(self, piece: Piece) -> float | None:
        """When a slip comes to rest [rad], behind its beginning; None where it does not within its length."""
        edges = self._edges(piece.length)
        power = 0 if piece.v else 1 if self._pushed(piece.begin, piece.z) else 2
        for k in range(0, len(edges) - 1, _CHUNK):
            low, width = edges[k : k + _CHUNK + 1][:-1], np.diff(edges[k : k + _CHUNK + 1])
            tau = low[:, None] + width[:, None] * _ALONG
            part = piece.side * self.at(piece, tau.ravel())[1].reshape(tau.shape) / tau**power
            least, most = part.min(axis=1), np.abs(part).max(axis=1)
            for j in np.flatnonzero(least <= _SAFE * most):
                turned = np.flatnonzero(part[j] <= 0.0)
                plain = len(turned) and turned[0] > 1 and part[j, : turned[0] - 1].min() > _SAFE * most[j]
                found = (
                    self._between(piece, tau[j, turned[0] - 1], tau[j, turned[0]])
                    if plain
                    else self._closely(piece, float(low[j]), float(width[j]), first=bool(power) and k + j == 0)
                )
                if found is not None:
                    return found
        return None

    def _between(self, piece: Piece, low: float, high: float) -> float:
        """The root of the speed between times at which its signs differ: Newton's steps, halves where they leave."""
        tau = 0.5 * (low + high)
        for _ in range(60):
            _, v, a = self.now(piece, tau)
            low, high = (tau, high) if piece.side * v > 0.0 else (low, tau)
            step = tau - v / a if a else low
            last, tau = tau, step if low < step < high else 0.5 * (low + high)
            if abs(tau - last) <= _SETTLED * (high + 1.0):  # the next of Newton's steps is as short as its square
                break
        return tau

    def _closely(self, piece: Piece, low: float, width: float, *, first: bool) -> float | None:
        """The first rest on a panel by all roots of the polynomial through it, those of its beginning left out."""
        coefficients = piece.side * self.at(piece, low + width * _NODES)[1] @ _COEFFICIENTS
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
        first, second = self._poles
        slow, fast = (cmath.tanh(0.5 * pi * one) if abs(one.real) < 200.0 else -1.0 for one in (first, second))
        apart = second - first
        if abs(apart) > 1e-2:
            per = (fast - slow) / apart
        else:  # next to critical damping
            half = 0.5 * pi * apart
            per = 0.5 * pi * (1.0 + half**2 / 6.0 + half**4 / 120.0)
            per /= cmath.cosh(0.5 * pi * first) * cmath.cosh(0.5 * pi * second)
        steady = 1.0 - self.r**2 + 2j * self.ratio * self.r
        lag = -per.real * self.friction / self.r**2 * abs(steady)
        if not (isfinite(lag) and abs(lag) < 1.0 and steady):
            return None
        turn = asin(lag)
        top = cos(turn) / abs(steady) + (slow - per * first).real * self.friction
        piece = Piece(turn + cmath.phase(steady), pi, top, 0.0, -1)
        if self._never_rests(piece):
            return (piece,)
        rests = self._rests(Piece(piece.begin, pi * (1.0 + 1e-4), top, 0.0, -1))
        return (piece,) if rests is not None and abs(rests - pi) < 1e-6 else None

    def _never_rests(self, piece: Piece) -> bool:
        """Whether the speed is far from zero everywhere but at both ends, where it turns."""
        edges = self._edges(piece.length)
        tau = (edges[:-1, None] + np.diff(edges)[:, None] * _INSIDE).ravel()
        part = piece.side * self.at(piece, tau)[1] / (tau * (piece.length - tau))
        return bool(part.min() > _SAFE * part.max())

    def _closed(self) -> tuple[Piece, ...] | None:
        """Half a cycle from theta = 0 that ends at the negative of its beginning.

        Plain half cycles never move it away, and Newton's steps are only taken where they halve what is missing.
        """
        state: FloatArray = np.zeros(2)
        known = self._half(state)
        for turn in range(_TURNS):
            miss = state + known[1]
            left = self._size(miss)
            if left <= _CLOSED * self._size(state) + _ROUND * 1e-2:
                return known[0]
            if turn >= _WARM:
                step: FloatArray = np.linalg.lstsq(np.eye(2) + known[2], miss, rcond=None)[0].astype(float)
                step *= min(1.0, _FAR * (1.0 + self._size(state)) / (self._size(step) + 1e-300))
                tried = [(state - part * step, self._half(state - part * step)) for part in (1.0,)]
                for part in (0.25, 0.0625):
                    if self._size(tried[-1][0] + tried[-1][1][1]) > 0.5 * left:
                        tried.append((state - part * step, self._half(state - part * step)))
                best = min(tried, key=lambda one: self._size(one[0] + one[1][1]))
                if self._size(best[0] + best[1][1]) < 0.9 * left:
                    state, known = best
                    continue
            state = -known[1]
            known = self._half(state)
        return known[0] if left < _ENOUGH * self._size(state) else None

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

    def greatest(self, order: int, part: float, phasor: complex) -> float:
        """Greatest size of part z^(order) + Re(phasor e^(i theta)) in a cycle; infinite where it grows without end."""
        pieces = self.half_cycle
        if pieces is None:
            return float("inf")
        return max(self._most(piece, order, part, phasor) for piece in pieces)

    def equivalent(self, order: int, part: float, phasor: complex) -> float:
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
        return float(abs(part * moved * 1j**order + phasor))

    def _most(self, piece: Piece, order: int, part: float, phasor: complex) -> float:
        """Greatest size on one piece."""

        def reading(tau: FloatArray) -> FloatArray:
            return np.asarray(part * self.at(piece, tau)[order] + (phasor * np.exp(1j * (piece.begin + tau))).real)

        ends = np.abs(reading(np.array([0.0, piece.length])))
        if order == 0 and not phasor:
            return float(ends.max())
        if piece.side == 0:
            tops = (-cmath.phase(phasor) - piece.begin + np.array([0.0, pi])) % (2.0 * pi)
            inside = tops[tops < piece.length]
            return float(np.abs(np.concatenate([ends, reading(inside)])).max())
        edges = self._edges(piece.length)
        low, width = edges[:-1], np.diff(edges)
        coefficients = reading(low[:, None] + width[:, None] * _NODES) @ _COEFFICIENTS
        tops = np.abs(coefficients @ _VALUES).max(axis=1)
        best = max(float(ends.max()), float(tops.max()))
        for j in np.flatnonzero(tops >= (1.0 - _NEAR) * best):
            at = _real_roots(chebyshev.chebder(coefficients[j]), 0.0)
            best = max([best, *np.abs(reading(low[j] + width[j] * at))])
        return best


def _divided(a: complex, b: complex, tau: FloatArray, apart: ComplexArray) -> ComplexArray:
    """(e^(a tau) - e^(b tau)) / (a - b), of which `apart` is the numerator; also where the two are next to alike."""
    if abs(a - b) > _ALIKE:
        return apart / (a - b)
    half = 0.5 * (a - b) * tau
    square, close = half * half, np.abs(half) < 0.5
    series = 1.0 + square / 6.0 * (1.0 + square / 20.0 * (1.0 + square / 42.0 * (1.0 + square / 72.0)))
    near = np.exp(0.5 * (a + b) * tau) * tau * series
    return np.where(close, near, apart / (a - b)) if a != b else near


def _divided_at(a: complex, b: complex, tau: float, apart: complex) -> complex:
    """As `_divided`, at one time."""
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


__all__ = ["Piece", "Rub"]
