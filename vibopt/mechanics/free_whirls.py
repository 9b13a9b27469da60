"""Free whirls of a rotor in its model: frequencies with their damping at a spin, and where one is as fast as it.

Begun at the lowest motions at rest and solved in all coordinates.  A motion e^{i w t} with Re w > 0 fades where
Im w > 0; its logarithmic decrement is 2 pi Im w / Re w.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from vibopt.arrays import BoolArray, ComplexArray, FloatArray
from vibopt.mechanics.orbits import FARTHEST, Half, Spun, roots
from vibopt.mechanics.resistance import Resistance
from vibopt.records import dataclass
from vibopt.work import worked

NO_PEAK, HEAVY, _FOLLOWED = 1.0 / np.sqrt(2.0), 0.95, 0.98
"""Damping ratio from which on a whirl has no resonance; from which on it hardly swings and does not count; up to which
it is followed where it is not known well."""
_SAME, _LAST, _STEPS, _NONE = 1e-13, 1e-9, 12, 1e-11
"""Part of itself by which a frequency is known; of the last step to one, behind which rounding is left; steps of
Newton; below which a damping is rounding."""
_ASTRAY, _TWICE, _NARROW = 0.1, 1e-9, 1e-4
"""Part of itself by which a whirl may move when solved in all coordinates; within which two are one; how narrow a range
of spins is in which a whirl is solved."""
_SCANNED, _BEYOND, _SURELY, _HALVED = 24, 1.5, 0.9, 60
"""Spins of a range that are looked at beside rows of tables; by how much faster whirls are followed than asked for;
the part of that up to which one surely counts; steps of a golden section."""
_EQUAL, _MET = 1e-6, 1e-3
"""Part of themselves within which two speeds are one, and by which a whirl that is met differs from the spin at most,
where the numbers of a rotor leave few digits."""
_MANY = 128
"""Coordinates from which on a whirl is sooner solved sense by sense."""
_LOOK, _MEETING = 1.0, 20.0
"""Work of all whirls at a spin, and of one whirl as fast as its spin [nominal ms]."""
_RUNS, _LIGHT = 1.5, 0.8
"""Times what a slope says by which a whirl may run; damping ratio up to which one is watched between two spins."""
_GOLDEN, _LEVEL, _BESIDE = 0.5 * (np.sqrt(5.0) - 1.0), 1e-12, 1e-3
"""Of its section; part of a value by which it is level; part of a step at which one looks whether an end is a least."""


@dataclass(frozen=True, slots=True)
class Whirls:
    """Complex frequencies, Re ascending and above zero, (n,) [rad/s], their senses, (n,), and motions (n, 2 n_free).

    1 is with the spin and -1 against it, by the greater mass where places differ; 0 of one along a line, which is both.
    """

    rates: ComplexArray
    senses: FloatArray
    ways: ComplexArray

    def of(self, sense: float) -> ComplexArray:
        """Those with the spin (1), against it (-1), or both (0)."""
        return self.rates[self.senses * sense >= 0.0]


def free_whirls(
    rotor: Spun, spin: float, top: float = np.inf, telling: Callable[[ComplexArray], BoolArray] | None = None
) -> Whirls:
    """All that are no quicker than `top` [rad/s] at a spin [rad/s] and no more damped than `HEAVY`, in all coordinates.

    Where it is known which are `telling`, by about what they are, others may be left out.
    """
    rates, ways = np.linalg.eig(rotor.rates(spin))
    near = -1j * rates
    swings = (near.real > 0.0) & (near.imag <= _FOLLOWED * np.abs(near))
    chosen = np.flatnonzero(swings & (near.real <= _BEYOND * top))
    chosen = chosen[telling(near[chosen])] if telling is not None else chosen
    motions = rotor.motions(ways[:, chosen])
    resistance = Resistance(rotor, spin)
    found = [_solved(resistance, near[k], way) for k, way in zip(chosen.tolist(), motions.T, strict=True)]
    met = np.array([rate for rate, _ in found], dtype=complex)
    bad = np.abs(met - near[chosen]) > _ASTRAY * np.abs(near[chosen])
    if bad.any() or _double(met, [way for _, way in found]):
        met, every = _whole(*resistance.powers, _BEYOND * top)
    else:
        every = [way for _, way in found]
    order = np.argsort(met.real)
    kept = order[(met.real <= top)[order] & (met.imag < HEAVY * np.abs(met))[order]]
    senses = np.array([rotor.sense(every[k]) for k in kept.tolist()], dtype=float)
    return Whirls(met[kept], senses, np.array([every[k] for k in kept.tolist()]))


def _solved(resistance: Resistance, rate: complex, way: ComplexArray) -> tuple[complex, ComplexArray]:
    """The root near one and its motion: of many coordinates sense by sense, where that settles, else all at once."""
    found = resistance.freed(rate, way) if len(way) > _MANY else None
    return _by_newton(*resistance.powers, rate, way) if found is None else found


def _by_newton(
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
        if abs(step[n]) <= _LAST:
            break
    return rate, way / size


def solved(rotor: Spun, spin: float, rate: complex, way: ComplexArray) -> tuple[complex, ComplexArray]:
    """The free whirl near one at a spin [rad/s], and its motion, in all coordinates."""
    return _solved(Resistance(rotor, spin), rate, way)


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


def decrements(rates: ComplexArray) -> FloatArray:
    """Logarithmic decrements; what is rounding is none."""
    return np.asarray(np.where(np.abs(rates.imag) > _NONE * np.abs(rates), 2.0 * np.pi * rates.imag / rates.real, 0.0))


def damping_ratios(rates: ComplexArray) -> FloatArray:
    """Over critical; what is rounding is none."""
    return np.asarray(np.where(np.abs(rates.imag) > _NONE * np.abs(rates), rates.imag / np.abs(rates), 0.0))


def least_damped(
    rotor: Spun, band: tuple[float, float], top: float, sense: float, number: int,
    measure: Callable[[ComplexArray], FloatArray],
) -> tuple[float, float]:  # fmt: skip
    """Least, over a range of spins [rad/s], of the damping of the `number`-th least damped whirl up to `top`; its spin.

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
        return at(low), low
    knots = rotor.knots
    spins = np.unique(np.concatenate([np.linspace(low, high, _SCANNED), knots[(knots > low) & (knots < high)]]))
    values = [at(spin) for spin in spins.tolist()]
    best = min(zip(values, spins.tolist(), strict=True))
    for k, value in enumerate(values):
        left, right = max(k - 1, 0), min(k + 1, len(spins) - 1)
        if np.isfinite(value) and value and value == min(values[left : right + 1]):
            inside = spins[k] + _BESIDE * (spins[right] - spins[left]) * (1.0 if k == 0 else -1.0)
            if left < k < right or at(float(inside)) < value:
                best = min(best, _lowest(at, float(spins[left]), float(spins[right])))
    return best


def _lowest(value: Callable[[float], float], low: float, high: float) -> tuple[float, float]:
    """Least of a function between two numbers and where it is, by the golden section."""
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
    return min(zip(heights, ends, strict=True))


@dataclass(frozen=True, slots=True)
class Synchronous:
    """A free whirl as fast as the spin: that speed [rad/s], its complex frequency [rad/s] and motion (2 n,), its sense.

    Of a rotor whose bearings couple no forward and backward whirl the motion is (n,).
    """

    speed: float
    rate: complex
    way: ComplexArray
    sense: float

    def moved(self, rotor: Spun) -> float:
        """The speed of the same whirl of a rotor that is nearly the same [rad/s]; nan if none is met."""
        rotor = Half(rotor, self.sense) if len(self.way) == len(rotor.mass) else rotor
        return _as_fast(rotor, self.speed, self.rate, self.way).speed


def synchronous(rotor: Spun, sense: float, top: float = 0.0, most: int = 0) -> list[Synchronous]:
    """Free whirls with the spin (1), against it (-1), or any (0), that are as fast as the spin, the slowest first.

    What is damped by `NO_PEAK` of critical and more has no resonance, and is left out.  Up to `top` and as far as
    tables go; without a top the `most` lowest are looked for up to `FARTHEST` times the lowest frequency at rest.
    Those of a rotor that nothing damps are found outright.
    """
    direct = rotor.undamped_ways() if rotor.model.bearings else None
    if direct is not None:
        speeds, ways = np.sqrt(direct[0]), direct[1].T
        both = zip(speeds.tolist(), ways, strict=True)
        every = [Synchronous(speed, complex(speed), way, rotor.sense(way)) for speed, way in both]
        return _apart([one for one in every if one.speed <= (top or np.inf) and one.sense * sense >= 0.0])
    senses = (0.0,) if rotor.model.bearings else (1.0, -1.0)
    searches: dict[tuple[float, float], _Search] = vars(rotor).setdefault("searches", {})
    for half in senses:
        if (half, top) not in searches:
            searches[half, top] = _Search(Half(rotor, half) if half else rotor, top)
    return _apart([one for half in senses if half * sense >= 0.0 for one in searches[half, top].until(sense, most)])


def _apart(found: list[Synchronous]) -> list[Synchronous]:
    """Each once, the slowest first."""
    found = sorted(found, key=lambda one: one.speed)
    alone = np.diff([one.speed for one in found], prepend=0.0) > [_EQUAL * one.speed for one in found]
    return [one for one, kept in zip(found, alone.tolist(), strict=True) if kept]


class _Search:
    """What is as fast as the spin from low spins on, up to `top`: followed as far as was ever asked."""

    def __init__(self, rotor: Spun, top: float) -> None:
        self.rotor, self.few, self.known = rotor, rotor.enough(top), list[Synchronous]()
        self.spins, self.reached = _looked_at(rotor, top).tolist(), 0
        self.look = _Look.at(rotor, self.spins[0], self.few)

    def until(self, sense: float, most: int) -> list[Synchronous]:
        """More than `most` of a sense, all where it is 0, in any order, some of them twice."""
        while True:
            found = [one for one in self.known if one.sense * sense >= 0.0]
            if (most and len(_apart(found)) > most) or self.reached == len(self.spins) - 1:
                return found
            self._follow()

    def _follow(self) -> None:
        """One stretch of spins more."""
        self.reached += 1
        before, self.look = self.look, _Look.at(self.rotor, self.spins[self.reached], self.few)
        for spin, near, way in _crossings(self.rotor, before, self.look):
            one = _as_fast(self.rotor, spin, near, way)
            if one.rate.imag < NO_PEAK * abs(one.rate) and self.spins[0] <= one.speed <= self.spins[-1]:
                self.known.append(one)


def _looked_at(rotor: Spun, top: float) -> FloatArray:
    """Spins at which whirls are counted [rad/s]."""
    unit, knots = rotor.slowest, rotor.knots
    top = top or FARTHEST * unit
    low, high = (float(knots[0]), min(top, float(knots[-1]))) if len(knots) else (0.0, top)
    steps = unit * np.geomspace(0.02, max(high / unit, 0.05), 2 * _SCANNED)
    every = np.concatenate([steps, np.linspace(low, high, _SCANNED), knots])
    return np.unique(every[(every >= low) & (every <= high)])


@dataclass(frozen=True, slots=True)
class _Look:
    """The `few` lowest whirls at a spin [rad/s]: states (n, n), their rates (n,) [1/s] and motions (n, n)."""

    spin: float
    few: int
    states: ComplexArray
    rates: ComplexArray
    ways: ComplexArray

    @classmethod
    def at(cls, rotor: Spun, spin: float, few: int) -> _Look:
        worked(_LOOK)
        states = rotor.rates(spin, few)
        return cls(spin, few, states, *np.linalg.eig(states))

    @property
    def faster(self) -> int:
        """How many are faster than the spin."""
        return int((self.rates.imag > self.spin).sum())

    def may_meet(self, other: _Look) -> bool:
        """Whether some whirl may be as fast as the spin before another, by how each begins to change with it."""
        step = other.spin - self.spin
        light = (self.rates.imag > 0.0) & (-self.rates.real <= _LIGHT * np.abs(self.rates))
        try:
            turned = np.linalg.solve(self.ways, (other.states - self.states) @ self.ways)
        except np.linalg.LinAlgError:
            return True
        ahead = self.rates.imag - self.spin
        gains = np.diagonal(turned).imag - step
        return bool((light & (ahead * (ahead + _RUNS * gains) <= 0.0)).any())


def _crossings(rotor: Spun, low: _Look, high: _Look) -> list[tuple[float, complex, ComplexArray]]:
    """Spins, whirls and motions where one is about as fast as the spin between two, over which nothing has a kink."""
    count = abs(low.faster - high.faster)
    if not count and not low.may_meet(high) and not high.may_meet(low):
        return []
    if high.spin - low.spin <= _NARROW * max(high.spin, rotor.slowest):  # what only creeps is as fast as no spin
        middle = _Look.at(rotor, 0.5 * (low.spin + high.spin), low.few)
        off = np.abs(middle.rates.imag - middle.spin)
        near = np.argsort(off)[: max(count, int((off <= high.spin - low.spin).sum()))]
        ways = rotor.motions(middle.ways[:, near]).T
        every = [(middle.spin, complex(-1j * middle.rates[k]), way) for k, way in zip(near.tolist(), ways, strict=True)]
        return [one for one in every if one[1].imag <= HEAVY * abs(one[1])]
    there = _Look.at(rotor, 0.5 * (low.spin + high.spin), low.few)
    return [*_crossings(rotor, low, there), *_crossings(rotor, there, high)]


def _as_fast(rotor: Spun, spin: float, near: complex, way: ComplexArray) -> Synchronous:
    """The whirl near one at a spin that is as fast as that, in all coordinates; nan if none is met."""

    def off(spin: float, like: complex, way: ComplexArray) -> tuple[float, complex, ComplexArray]:
        rate, way = solved(rotor, spin, like, way)
        return rate.real - spin, rate, way

    worked(_MEETING)
    before, here = spin * (1.0 + 1e-5), spin
    low, like, way = off(before, near, way)
    for _ in range(_STEPS):
        high, like, way = off(here, like, way)
        if high == low or abs(here - before) <= _LAST * here:
            break
        before, here, low = here, here - high * (here - before) / (high - low), high
    here = here if abs(high) <= _MET * here else np.nan
    return Synchronous(here, complex(here, like.imag), way, rotor.sense(way))
