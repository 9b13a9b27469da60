"""Free whirls of a rotor as built, by its waves: the second road to damping at a spin and to damped critical speeds.

Begun at the lowest motions of its pieces in both planes, then solved where the dynamic stiffness of all waves lets a
motion go by itself; e^{i w t} fades where Im w > 0.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from typing import Any

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.mechanics.orbiting import OrbitingMachine
from vibopt.mechanics.rotating import RotatingMachine
from vibopt.mechanics.shaft_waves import MODES
from vibopt.work import worked

_OF_PIECES = 1e-4
"""Work of the whirls of n coordinates, by n^3 [nominal ms]."""
_ROUNDING, _TURNS, _LAST, _TRIED, _FINE, _FASTEST = 1e-11, 1e-9, 1e-9, 20, 1e-9, 1e-12
"""Part of a frequency below which its damping is rounding; that it is at least of what turns; of the last step to one,
behind which rounding is left; steps to it; part of the highest spin by which that of a least is known; of the longest
period squared below which one is rounding."""
_ONE, _MET, _ALIKE = 1e-6, 1e-3, 1e-6
"""Part of themselves within which two speeds are one, by which a whirl that is met differs from its spin at most, and
within which two whirls of pieces are alike, of which any mixture is one."""
_LINE = 2e-3
"""Energy forward less that backward over their mean, below which a whirl goes along a line."""
_BESIDE, _WATCHED, _ASIDE = 2.0, 0.8, 0.2
"""Steps of the spin within which a whirl at either end may be as fast as one between; damping ratio of whirls that are
counted apart, for one that fades at once may come as one that hardly does goes; part of a spin by which one is too far
from it, where only its damping passed that ratio."""
_DRAWN = 0.5**0.5
"""Damping ratio up to which a whirl has a resonance, and is drawn."""
_LEAST, _SWINGS, _ALMOST = 2.0, 0.95, 0.98
"""Times the least damping over a frequency beyond which a whirl is not the least damped, of pieces or of waves; damping
ratios up to which one counts, and up to which one is followed."""
_SOUGHT, _ALONG, _UP, _NARROW = 1.5, 21, 40, 1e-3
"""How much faster than asked for a beginning may be; spins of a range that are looked at, and of all; how narrow
they are at last."""

Whirl = tuple[complex, float]
"""Complex frequency [rad/s], and its sense: 1 with the spin, -1 against it, by the greater mass, 0 along a line."""


def in_planes(machine: RotatingMachine) -> OrbitingMachine:
    """The same in two planes, of supports that are alike in both, too."""
    if isinstance(machine, OrbitingMachine):
        return machine
    known: dict[str, OrbitingMachine] = vars(machine)
    if "in planes" not in known:
        known["in planes"] = OrbitingMachine(**{field.name: getattr(machine, field.name) for field in fields(machine)})
    return known["in planes"]


def whirls(machine: OrbitingMachine, spin: float, top: float, most: float = np.inf) -> list[Whirl]:
    """Free whirls no faster than `top` at a spin [rad/s] and no more damped than `_SWINGS`, the slowest first.

    Those that fade faster than `most` times the least damped, over their frequency, may be left out.  A damping that is
    rounding is none.
    """
    begun = [one for one in _begun(machine, spin) if one[0].real <= _SOUGHT * top]
    begun = [one for one in begun if one[0].imag <= _ALMOST * abs(one[0])]
    fades = sorted(abs(near.imag) / abs(near) for near, _, _ in begun if near.real <= top)
    if np.isfinite(most) and fades and min(near.imag for near, _, _ in begun) > 0.0:
        begun = [one for one in begun if one[0].imag <= most * fades[0] * abs(one[0])]
    found = [(_by_waves(machine, spin, near, motion), sense) for near, motion, sense in begun]
    found = [(rate if abs(rate.imag) > _ROUNDING * abs(rate) else complex(rate.real), sense) for rate, sense in found]
    kept = [(rate, sense) for rate, sense in found if rate.real <= top and rate.imag < _SWINGS * abs(rate)]
    return sorted(kept, key=lambda one: one[0].real)


def _begun(machine: OrbitingMachine, spin: float) -> list[tuple[complex, ComplexArray, float]]:
    """Whirls of the pieces, with their motions as `free` has them, y then z."""
    mass, damping, stiffness = machine.free(spin)
    n, inverse = len(mass), np.linalg.inv(mass)
    worked(_OF_PIECES * n**3)
    state = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ stiffness, -inverse @ damping]])
    rates, ways = np.linalg.eig(state)
    found = []
    for k in np.flatnonzero(rates.imag > _TURNS * np.abs(rates)):
        found.append((complex(-1j * rates[k]), ways[:n, k], _sense(mass, ways[:n, k])))
    return found


def _sense(mass: FloatArray, motion: ComplexArray) -> float:
    """1 of a motion of the pieces, y then z, with the spin, -1 against it, by the greater mass, 0 along a line."""
    y, z = np.split(motion, 2)
    n = len(y)
    sizes = [np.vdot(one, mass[:n, :n] @ one).real for one in (y + 1j * z, y - 1j * z)]
    straight = abs(sizes[0] - sizes[1]) <= 0.5 * _LINE * (sizes[0] + sizes[1])
    return 0.0 if straight else float(np.sign(sizes[0] - sizes[1]))


def whirls_of_pieces(machine: OrbitingMachine, spin: float, top: float) -> list[Whirl]:
    """Those of `whirls` that swing, by the pieces alone: good where their waves are short."""
    every = _begun(machine, spin)
    return [(near, sense) for near, _, sense in every if near.real <= top and near.imag < _DRAWN * abs(near)]


def _by_waves(machine: OrbitingMachine, spin: float, near: complex, motion: ComplexArray) -> complex:
    """The whirl near one of the pieces: by inverse iteration from both sides, the frequency a quotient of both."""
    at, turn = near, np.array([spin])
    cut, begun = machine.begun(_SOUGHT * max(abs(near), spin), motion)
    size = np.sqrt(np.abs(np.diagonal(cut.planes(np.array([0.5 * near]), turn, braked=True)[0])))
    way: Any = begun * size
    back: Any = way
    for _ in range(_TRIED):
        step = 1e-6 * abs(at)
        stiff = cut.planes(np.array([at, at + step, at - step]), np.repeat(turn, 3), braked=True)
        stiff = stiff / np.outer(size, size)
        try:
            way, back = np.linalg.solve(stiff[0], way), np.linalg.solve(stiff[0].conj().T, back)
        except np.linalg.LinAlgError:
            break
        way, back = way / np.linalg.norm(way), back / np.linalg.norm(back)
        slope = (stiff[1] - stiff[2]) / (2.0 * step)
        move = complex(np.vdot(back, stiff[0] @ way) / np.vdot(back, slope @ way))
        at -= move
        if abs(move) <= _LAST * abs(at):
            break
    return at


def least_over(
    machine: OrbitingMachine, band: tuple[float, float], top: float, sense: float, number: int,
    damping: Callable[[complex], float],
) -> float:  # fmt: skip
    """Least over a range of spins [rad/s] of what the `number`-th least damped whirl up to `top` has.

    `sense` is 1 of those with the spin, -1 of those against it, 0 of all; infinite where there are not as many.
    """
    from scipy.optimize import minimize_scalar

    def at(spin: float) -> float:
        found = whirls(machine, spin, top, _LEAST if number == 1 and not sense else np.inf)
        each = sorted(damping(rate) for rate, goes in found if goes * sense >= 0.0)
        return each[number - 1] if len(each) >= number else float("inf")

    low, high = band
    if low == high:
        return at(low)
    rows = [one for table in machine.tables for one in table.tolist() if low < one < high]
    spins = sorted({*np.linspace(low, high, _ALONG).tolist(), *rows})
    values = np.array([at(spin) for spin in spins])
    best = float(values.min())
    for k in np.flatnonzero(np.isfinite(values) & (values != 0.0)).tolist():
        left, right = max(k - 1, 0), min(k + 1, len(spins) - 1)
        if values[k] == values[left : right + 1].min() and values[k] <= best + 0.5 * np.ptp(values[left : right + 1]):
            ends = spins[left], spins[right]
            with np.errstate(invalid="ignore"):  # a whirl that no longer swings is infinitely damped
                least = minimize_scalar(at, bounds=ends, method="bounded", options={"xatol": _FINE * high})
            best = min(best, float(least.fun))
    return best


def as_fast(machine: OrbitingMachine, sense: float, most_damped: float, top: float = 0.0, many: int = 0) -> FloatArray:
    """Spins at which a whirl with the spin (1), against it (-1), or any (0), is as fast as that, ascending [rad/s].

    Those with a damping ratio of `most_damped` and more are left out.  As far as tables go, and up to `top`; without
    it the lowest `many`.
    """
    searches: dict[float, _Search] = vars(machine).setdefault("searches", {})
    if top not in searches:
        searches[top] = _Search(machine, top)
    return searches[top].until(sense, most_damped, many)


class _Search:
    """Spins that a whirl is as fast as from low ones on, up to `top`: followed as far as was ever asked."""

    def __init__(self, machine: OrbitingMachine, top: float) -> None:
        low = max((table[0] for table in machine.tables), default=0.0)
        high, slow = machine.searched(top), machine.slowest
        steps = slow * np.geomspace(0.03, max(high / slow, 0.1), _UP)
        spins = np.concatenate([[low], steps, np.linspace(low, high, _UP), *machine.tables])
        self.machine, self.reached, self.begun = machine, 0, (low, _begun(machine, low))
        self.spins: list[float] = np.unique(spins[(spins >= low) & (spins <= high)]).tolist()
        self.met: list[tuple[complex, list[float]]] = []  # that spin beside how it fades, and senses of all that do so

    def until(self, sense: float, most_damped: float, many: int) -> FloatArray:
        """More than `many` of a sense, all where it is 0."""
        while True:
            light = [one for one in self.met if one[0].imag < most_damped * abs(one[0])]
            found = _apart([rate.real for rate, senses in light if any(goes * sense >= 0.0 for goes in senses)])
            if (many and len(found) > many) or self.reached >= len(self.spins) - 1:
                return found
            self._follow()

    def _follow(self) -> None:
        """One stretch of spins more."""
        self.reached += 1
        spin = self.spins[self.reached]
        before, self.begun = self.begun, (spin, _begun(self.machine, spin))
        for near, motion, ends in _passed(self.machine, before, self.begun):
            if near.imag > _SWINGS * abs(near) or abs(near.real - ends[0]) > _ASIDE * ends[0]:
                continue
            rate = _synchronous(self.machine, near, motion, ends)
            if self.spins[0] <= rate.real <= self.spins[-1]:
                self.met.append((rate, _senses(self.machine, ends[0], near)))


def undamped_as_fast(machine: OrbitingMachine, sense: float) -> FloatArray:
    """Those of the machine without dampers, in bearings that have a potential and do not change with the spin.

    The lowest `MODES`: outright by the pieces, K - w^2 (M - i G) with gyroscopic moments w G, then by the waves.
    """
    machine = machine.undamped
    mass, none, stiffness = machine.free(0.0)
    gyroscopic = machine.free(1.0)[1] - none
    root = np.linalg.inv(np.linalg.cholesky(stiffness))
    periods, ways = np.linalg.eigh(root @ (mass - 1j * gyroscopic) @ root.T)
    found = []
    for k in np.argsort(-periods)[: int((periods > _FASTEST * periods.max()).sum())].tolist():
        motion = root.T @ ways[:, k]
        if _sense(mass, motion) * sense >= 0.0:
            near = 1.0 / float(np.sqrt(periods[k]))
            found.append(_synchronous(machine, near, motion, [near * (1.0 - _ONE), near]).real)
        if len(found) == MODES:
            break
    return _apart(found)


def _apart(found: list[float]) -> FloatArray:
    """Each once, ascending."""
    every = np.unique(found)
    return every[np.diff(every, prepend=0.0) > _ONE * every]


Begun = tuple[float, list[tuple[complex, ComplexArray, float]]]
"""A spin [rad/s], and the whirls of the pieces there."""


def _ahead(one: Begun) -> FloatArray:
    """How many whirls of the pieces are faster than the spin: of all, and of those that hardly fade."""
    rates = np.array([near for near, _, _ in one[1]])
    faster = rates.real > one[0]
    return np.array([faster.sum(), (faster & (rates.imag < _WATCHED * np.abs(rates))).sum()])


def _off(one: Begun) -> float:
    """How far the nearest whirl that swings is from the spin [rad/s]."""
    return min((abs(near.real - one[0]) for near, _, _ in one[1] if near.imag < _SWINGS * abs(near)), default=np.inf)


def _senses(machine: OrbitingMachine, spin: float, near: complex) -> list[float]:
    """Those in which a whirl of the pieces at a spin goes round, and all that are alike."""
    return [goes for one, _, goes in _begun(machine, spin) if abs(one - near) <= _ALIKE * abs(near)]


def _passed(machine: OrbitingMachine, low: Begun, high: Begun) -> list[tuple[complex, ComplexArray, list[float]]]:
    """Whirls of the pieces that the spin gets ahead of, or falls behind, between two spins, with two close ones."""
    step, count = high[0] - low[0], int(np.abs(_ahead(low) - _ahead(high)).max())
    if not count and max(_off(low), _off(high)) > _BESIDE * step:
        return []
    if step <= _NARROW * high[0]:
        before = np.array([near for near, _, _ in low[1]])
        gone = [before[np.abs(before - near).argmin()] for near, _, _ in high[1]]
        changed = [(one.real > low[0]) != (there[0].real > high[0]) for one, there in zip(gone, high[1], strict=True)]
        each = sorted(range(len(gone)), key=lambda k: (not changed[k], abs(high[1][k][0].real - high[0])))
        return [(*high[1][k][:2], [high[0], low[0]]) for k in each[: max(count, sum(changed))]]
    middle = 0.5 * (low[0] + high[0])
    there = middle, _begun(machine, middle)
    return [*_passed(machine, low, there), *_passed(machine, there, high)]


def _synchronous(machine: OrbitingMachine, near: complex, motion: ComplexArray, spins: list[float]) -> complex:
    """The whirl near some that is as fast as its spin, by a secant from two spins; no number where none is met."""
    rates = [near := _by_waves(machine, spin, near, motion) for spin in spins]
    for _ in range(_TRIED):
        off = [rate.real - spin for rate, spin in zip(rates, spins, strict=True)]
        if off[0] == off[1] or abs(spins[1] - spins[0]) <= _LAST * spins[1]:
            break
        spins = [spins[1], spins[1] - off[1] * (spins[1] - spins[0]) / (off[1] - off[0])]
        rates = [rates[1], _by_waves(machine, spins[1], rates[1], motion)]
    met = abs(rates[1].real - spins[1]) <= _MET * abs(spins[1])
    return complex(spins[1] if met else np.nan, rates[1].imag)
