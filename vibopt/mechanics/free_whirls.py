"""Free whirls of a rotor in its model: frequencies with their damping at a spin, and where one is as fast as it.

Begun at the lowest motions at rest and solved in all coordinates.  A motion e^{i w t} with Re w > 0 fades where
Im w > 0; its logarithmic decrement is 2 pi Im w / Re w.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from vibopt.arrays import BoolArray, ComplexArray, FloatArray
from vibopt.mechanics.orbits import FARTHEST, Spun, roots
from vibopt.records import dataclass

NO_PEAK, HEAVY, _FOLLOWED = 1.0 / np.sqrt(2.0), 0.95, 0.98
"""Damping ratio from which on a whirl has no resonance; from which on it hardly swings and does not count; up to which
it is followed where it is not known well."""
_SAME, _STEPS, _NONE = 1e-13, 12, 1e-11
"""Part of itself by which a frequency is known; steps of Newton; below which a damping is rounding."""
_ASTRAY, _TWICE, _NARROW = 0.1, 1e-9, 1e-4
"""Part of itself by which a whirl may move when solved in all coordinates; within which two are one; how narrow a range
of spins is in which a whirl is solved."""
_SCANNED, _BEYOND, _SURELY, _HALVED = 24, 1.5, 0.9, 60
"""Spins of a range that are looked at beside rows of tables; by how much faster whirls are followed than asked for;
the part of that up to which one surely counts; steps of a golden section."""
_EQUAL = 1e-7
"""Part of themselves within which two speeds are one."""
_GOLDEN, _LEVEL, _BESIDE = 0.5 * (np.sqrt(5.0) - 1.0), 1e-12, 1e-3
"""Of its section; part of a value by which it is level; part of a step at which one looks whether an end is a least."""


@dataclass(frozen=True, slots=True)
class Whirls:
    """Complex frequencies, Re ascending and above zero, (n,) [rad/s], and whether each goes round with the spin.

    A motion of which some places go round with the spin and others against it is told by the greater mass.
    """

    rates: ComplexArray
    forward: BoolArray

    def of(self, sense: float) -> ComplexArray:
        """Those with the spin (1), against it (-1), or both (0)."""
        return self.rates[self.forward == (sense > 0.0)] if sense else self.rates


def free_whirls(
    rotor: Spun, spin: float, top: float = np.inf, telling: Callable[[ComplexArray], BoolArray] | None = None
) -> Whirls:
    """All that are no quicker than `top` [rad/s] at a spin [rad/s] and no more damped than `HEAVY`, in all coordinates.

    Where it is known which are `telling`, by about what they are, others may be left out.
    """
    rates, ways = np.linalg.eig(rotor.rates(spin))
    near, half = -1j * rates, len(rates) // 2
    swings = (near.real > 0.0) & (near.imag <= _FOLLOWED * np.abs(near))
    chosen = np.flatnonzero(swings & (near.real <= _BEYOND * top))
    chosen = chosen[telling(near[chosen])] if telling is not None else chosen
    shapes = np.kron(np.eye(2), rotor.at_rest_shapes)
    first, second = rotor.powers(spin)
    still = rotor.dynamic(0.0, spin)
    found = [_solved(still, first, second, near[k], shapes @ ways[:half, k]) for k in chosen.tolist()]
    met = np.array([rate for rate, _ in found], dtype=complex)
    bad = np.abs(met - near[chosen]) > _ASTRAY * np.abs(near[chosen])
    if bad.any() or _double(met, [way for _, way in found]):
        met, motions = _whole(still, first, second, _BEYOND * top)
    else:
        motions = [way for _, way in found]
    order = np.argsort(met.real)
    kept = order[(met.real <= top)[order] & (met.imag < HEAVY * np.abs(met))[order]]
    forward = np.array([_forward(rotor, motions[k]) for k in kept.tolist()], dtype=bool)
    return Whirls(met[kept], forward)


def _solved(
    still: ComplexArray, first: ComplexArray, second: FloatArray, rate: complex, way: ComplexArray
) -> tuple[complex, ComplexArray]:
    """A root of still + w first + w^2 second and its motion, near some: by Newton in both at once."""
    size = np.sqrt(np.abs(np.diagonal(still))) + 1e-300
    way = way * size / np.linalg.norm(way * size)
    n = len(way)
    scale = np.outer(size, size)
    a, b, c = still / scale, first / scale, second / scale
    read, unit = way.conj(), abs(rate)
    system = np.zeros((n + 1, n + 1), dtype=complex)
    for _ in range(_STEPS):
        here, slope = a + rate * b + rate**2 * c, b + 2.0 * rate * c
        system[:n, :n], system[:n, n], system[n, :n] = here, slope @ way * unit, read
        step = np.linalg.solve(system, np.append(here @ way, read @ way - 1.0))
        way, rate = way - step[:n], complex(rate - unit * step[n])
        if abs(step[n]) <= _SAME:
            break
    return rate, way / size


def _double(rates: ComplexArray, ways: list[ComplexArray]) -> bool:
    """Whether two of them are one and the same motion."""
    for i, one in enumerate(rates):
        for j in range(i):
            if abs(one - rates[j]) <= _TWICE * abs(one):
                across = abs(np.vdot(ways[i], ways[j])) / (np.linalg.norm(ways[i]) * np.linalg.norm(ways[j]))
                if across > 1.0 - 1e-6:
                    return True
    return False


def _whole(
    still: ComplexArray, first: ComplexArray, second: FloatArray, top: float
) -> tuple[ComplexArray, list[ComplexArray]]:
    """All at once, where one by one some is met twice."""
    every = roots(second, first, still)
    chosen = every[(every.real > 0.0) & (every.imag <= _FOLLOWED * np.abs(every)) & (every.real <= top)]
    ways = [np.linalg.svd(still + one * first + one**2 * second)[2][-1].conj() for one in chosen.tolist()]
    return chosen, ways


def _forward(rotor: Spun, way: ComplexArray) -> bool:
    forward, backward = np.split(way, 2)
    return bool(np.vdot(forward, rotor.mass @ forward).real >= np.vdot(backward, rotor.mass @ backward).real)


def decrements(rates: ComplexArray) -> FloatArray:
    """Logarithmic decrements; what is rounding is none."""
    return np.asarray(np.where(np.abs(rates.imag) > _NONE * np.abs(rates), 2.0 * np.pi * rates.imag / rates.real, 0.0))


def damping_ratios(rates: ComplexArray) -> FloatArray:
    """Over critical; what is rounding is none."""
    return np.asarray(np.where(np.abs(rates.imag) > _NONE * np.abs(rates), rates.imag / np.abs(rates), 0.0))


def least_damped(
    rotor: Spun, band: tuple[float, float], top: float, sense: float, number: int,
    measure: Callable[[ComplexArray], FloatArray],
) -> float:  # fmt: skip
    """Least, over a range of spins [rad/s], of the damping of the `number`-th least damped whirl up to `top`.

    Infinite where there are not as many.
    """

    def telling(near: ComplexArray) -> BoolArray:
        if sense:
            return np.ones(len(near), dtype=bool)
        each = measure(near)
        slow = np.sort(each[near.real <= _SURELY * top])
        enough = slow[number - 1] if len(slow) >= number else np.inf
        return np.asarray(each <= enough + 0.5 * abs(enough))

    def at(spin: float) -> float:
        found = np.sort(measure(free_whirls(rotor, spin, top, telling).of(sense)))
        return float(found[number - 1]) if len(found) >= number else float("inf")

    low, high = band
    if low == high:
        return at(low)
    knots = rotor.knots
    spins = np.unique(np.concatenate([np.linspace(low, high, _SCANNED), knots[(knots > low) & (knots < high)]]))
    values = [at(spin) for spin in spins.tolist()]
    best = min(values)
    for k, value in enumerate(values):
        left, right = max(k - 1, 0), min(k + 1, len(spins) - 1)
        if np.isfinite(value) and value and value == min(values[left : right + 1]):
            inside = spins[k] + _BESIDE * (spins[right] - spins[left]) * (1.0 if k == 0 else -1.0)
            if left < k < right or at(float(inside)) < value:
                best = min(best, _lowest(at, float(spins[left]), float(spins[right])))
    return best


def _lowest(value: Callable[[float], float], low: float, high: float) -> float:
    """Least of a function between two numbers, by the golden section."""
    ends, level = [high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)], 0
    heights = [value(one) for one in ends]
    for _ in range(_HALVED):
        level = level + 1 if abs(heights[0] - heights[1]) <= _LEVEL * abs(heights[0]) else 0
        if level > 2 or high - low <= _SAME * high:
            break
        if heights[0] <= heights[1]:
            high, ends[1], heights[1] = ends[1], ends[0], heights[0]
            ends[0] = high - _GOLDEN * (high - low)
            heights[0] = value(ends[0])
        else:
            low, ends[0], heights[0] = ends[0], ends[1], heights[1]
            ends[1] = low + _GOLDEN * (high - low)
            heights[1] = value(ends[1])
    return min(heights)


def damped_critical_speeds(rotor: Spun, sense: float, top: float = 0.0, most: int = 0) -> FloatArray:
    """Spins at which a free whirl with the spin (1), against it (-1), or any (0), is as fast as the spin [rad/s].

    What is damped by `NO_PEAK` of critical and more has no resonance, and is left out.  Up to `top` and as far as
    tables go; without a top the `most` lowest are looked for up to `FARTHEST` times the lowest frequency at rest.
    """
    spins = _looked_at(rotor, top).tolist()
    found: list[float] = []
    before = spins[0], _faster(rotor, spins[0])
    for high in spins[1:]:
        after = high, _faster(rotor, high)
        for near, way in _crossings(rotor, before, after):
            rate, forward = _as_fast(rotor, near, way)
            counts = not sense or forward == (sense > 0.0)
            if counts and rate.imag < NO_PEAK * abs(rate) and spins[0] <= rate.real <= spins[-1]:
                found.append(rate.real)
        before = after
        if most and len(found) >= most + 1:  # one may be met twice
            break
    return apart(found)


def apart(speeds: list[float]) -> FloatArray:
    """Ascending, of those that are equal one."""
    every = np.sort(np.array(speeds))
    return every[np.append(True, np.diff(every) > _EQUAL * every[1:])] if len(every) else every


def _looked_at(rotor: Spun, top: float) -> FloatArray:
    """Spins at which whirls are counted [rad/s]."""
    unit, knots = rotor.slowest, rotor.knots
    top = top or FARTHEST * unit
    low, high = (float(knots[0]), min(top, float(knots[-1]))) if len(knots) else (0.0, top)
    steps = unit * np.geomspace(0.02, max(high / unit, 0.05), 2 * _SCANNED)
    every = np.concatenate([steps, np.linspace(low, high, _SCANNED), knots])
    return np.unique(every[(every >= low) & (every <= high)])


def _faster(rotor: Spun, spin: float) -> int:
    """How many of the lowest whirls are faster than the spin."""
    return int((rotor.rates_at(spin).imag > spin).sum())


def _crossings(rotor: Spun, low: tuple[float, int], high: tuple[float, int]) -> list[tuple[complex, ComplexArray]]:
    """Whirls, and their motions, that are as fast as the spin somewhere between two, of which each number is known."""
    if low[1] == high[1]:
        return []
    middle = 0.5 * (low[0] + high[0])
    if high[0] - low[0] <= _NARROW * high[0]:
        rates, ways = np.linalg.eig(rotor.rates(middle))
        near = np.argsort(np.abs(rates.imag - middle))[: abs(low[1] - high[1])]
        shapes = np.kron(np.eye(2), rotor.at_rest_shapes)
        every = [(complex(-1j * rates[k]), shapes @ ways[: len(rates) // 2, k]) for k in near.tolist()]
        return [one for one in every if one[0].imag <= HEAVY * abs(one[0])]
    there = middle, _faster(rotor, middle)
    return [*_crossings(rotor, low, there), *_crossings(rotor, there, high)]


def _as_fast(rotor: Spun, near: complex, way: ComplexArray) -> tuple[complex, bool]:
    """The whirl near some that is as fast as the spin, in all coordinates, and whether it goes round with it."""

    def off(spin: float, like: complex, way: ComplexArray) -> tuple[float, complex, ComplexArray]:
        rate, way = _solved(rotor.dynamic(0.0, spin), *rotor.powers(spin), like, way)
        return rate.real - spin, rate, way

    before, here = near.real * (1.0 + 1e-5), near.real
    low, like, way = off(before, near, way)
    for _ in range(_STEPS):
        high, like, way = off(here, like, way)
        if high == low or abs(here - before) <= _SAME * here:
            break
        before, here, low = here, here - high * (here - before) / (high - low), high
    return complex(here, like.imag), _forward(rotor, way)


__all__ = [
    "HEAVY",
    "NO_PEAK",
    "Whirls",
    "damped_critical_speeds",
    "damping_ratios",
    "decrements",
    "free_whirls",
    "least_damped",
]
