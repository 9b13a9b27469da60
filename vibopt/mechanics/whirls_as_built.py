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

_TURNS, _CLOSE, _TRIED, _FINE = 1e-9, 1e-13, 20, 1e-9
"""Part of itself that a frequency is at least of what turns; by which one is known; steps to it; part
of the highest spin by which that of a least is known."""
_ONE = 1e-7
"""Part of themselves within which two speeds are one."""
_DRAWN = 0.5**0.5
"""Damping ratio up to which a whirl has a resonance, and is drawn."""
_LEAST, _SWINGS, _ALMOST = 2.0, 0.95, 0.98
"""Times the least damping over a frequency beyond which a whirl is not the least damped, of pieces or of waves; damping
ratios up to which one counts, and up to which one is followed."""
_SOUGHT, _ALONG, _UP, _NARROW = 1.5, 21, 40, 1e-3
"""How much faster than asked for a beginning may be; spins of a range that are looked at, and of all; how narrow
they are at last."""

Whirl = tuple[complex, bool]
"""Complex frequency [rad/s], and whether it goes round with the spin, by the greater mass."""


def in_planes(machine: RotatingMachine) -> OrbitingMachine:
    """The same in two planes, of supports that are alike in both, too."""
    if isinstance(machine, OrbitingMachine):
        return machine
    return OrbitingMachine(**{one.name: getattr(machine, one.name) for one in fields(machine)})


def whirls(machine: OrbitingMachine, spin: float, top: float, most: float = np.inf) -> list[Whirl]:
    """Free whirls no faster than `top` at a spin [rad/s] and no more damped than `_SWINGS`, the slowest first.

    Those that fade faster than `most` times the least damped, over their frequency, may be left out.
    """
    begun = [one for one in _begun(machine, spin) if one[0].real <= _SOUGHT * top]
    begun = [one for one in begun if one[0].imag <= _ALMOST * abs(one[0])]
    fades = sorted(abs(near.imag) / abs(near) for near, _, _ in begun if near.real <= top)
    if np.isfinite(most) and fades and min(near.imag for near, _, _ in begun) > 0.0:
        begun = [one for one in begun if one[0].imag <= most * fades[0] * abs(one[0])]
    found = [(_by_waves(machine, spin, near, motion), forward) for near, motion, forward in begun]
    kept = [(rate, forward) for rate, forward in found if rate.real <= top and rate.imag < _SWINGS * abs(rate)]
    return sorted(kept, key=lambda one: one[0].real)


def _begun(machine: OrbitingMachine, spin: float) -> list[tuple[complex, ComplexArray, bool]]:
    """Whirls of the pieces, with their motions as `free` has them, y then z."""
    mass, damping, stiffness = machine.free(spin)
    n, inverse = len(mass), np.linalg.inv(mass)
    state = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ stiffness, -inverse @ damping]])
    rates, ways = np.linalg.eig(state)
    found = []
    for k in np.flatnonzero(rates.imag > _TURNS * np.abs(rates)):
        y, z = np.split(ways[:n, k], 2)
        sizes = [np.vdot(one, mass[: n // 2, : n // 2] @ one).real for one in (y + 1j * z, y - 1j * z)]
        found.append((complex(-1j * rates[k]), ways[:n, k], bool(sizes[0] >= sizes[1])))
    return found


def whirls_of_pieces(machine: OrbitingMachine, spin: float, top: float) -> list[Whirl]:
    """Those of `whirls` that swing, by the pieces alone: good where their waves are short."""
    every = _begun(machine, spin)
    return [(near, with_it) for near, _, with_it in every if near.real <= top and near.imag < _DRAWN * abs(near)]


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
        if abs(move) <= _CLOSE * abs(at):
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
        each = sorted(damping(rate) for rate, with_it in found if sense in (0.0, 2.0 * with_it - 1.0))
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
    low = max((one[0] for one in machine.tables), default=0.0)
    high = machine.searched(top)
    slow = machine.slowest
    steps = slow * np.geomspace(0.03, max(high / slow, 0.1), _UP)
    spins = np.concatenate([steps, np.linspace(low, high, _UP), *machine.tables])
    spins = np.unique(spins[(spins >= low) & (spins <= high)])
    found: list[float] = []
    before = low, _ahead(machine, low)
    for spin in spins[spins > low].tolist():
        after = spin, _ahead(machine, spin)
        for near, motion, with_it in _passed(machine, before, after):
            if near.imag > _SWINGS * abs(near):
                continue
            rate = _synchronous(machine, near, motion)
            counts = not sense or with_it == (sense > 0.0)
            if counts and low <= rate.real <= high and rate.imag < most_damped * abs(rate):
                found.append(rate.real)
        before = after
        if many and len(found) >= many + 1:  # one may be met twice
            break
    every = np.unique(found)
    return every[np.diff(every, prepend=0.0) > _ONE * every]


def _ahead(machine: OrbitingMachine, spin: float) -> int:
    """How many whirls of the pieces are faster than the spin."""
    return sum(near.real > spin for near, _, _ in _begun(machine, spin))


def _passed(
    machine: OrbitingMachine, low: tuple[float, int], high: tuple[float, int]
) -> list[tuple[complex, ComplexArray, bool]]:
    """Whirls of the pieces that the spin gets ahead of, or falls behind, between two spins."""
    ends = [low, high]
    while ends[-1][0] - ends[0][0] > _NARROW * high[0]:
        if len(ends) == 2 and ends[0][1] == ends[1][1]:
            return []
        middle = 0.5 * (ends[0][0] + ends[1][0])
        there = middle, _ahead(machine, middle)
        if ends[0][1] != there[1] != ends[1][1]:
            return [*_passed(machine, ends[0], there), *_passed(machine, there, ends[1])]
        ends = [ends[0], there] if there[1] != ends[0][1] else [there, ends[1]]
    every = sorted(_begun(machine, ends[1][0]), key=lambda one: abs(one[0].real - ends[1][0]))
    return every[: abs(ends[0][1] - ends[1][1])]


def _synchronous(machine: OrbitingMachine, near: complex, motion: ComplexArray) -> complex:
    """The whirl near some that is as fast as its spin, by a secant on the spin."""
    spins = [near.real, near.real * (1.0 + 1e-4)]
    rates = [near := _by_waves(machine, spin, near, motion) for spin in spins]
    for _ in range(_TRIED):
        off = [rate.real - spin for rate, spin in zip(rates, spins, strict=True)]
        if off[0] == off[1] or abs(spins[1] - spins[0]) <= _CLOSE * spins[1]:
            break
        spins = [spins[1], spins[1] - off[1] * (spins[1] - spins[0]) / (off[1] - off[0])]
        rates = [rates[1], _by_waves(machine, spins[1], rates[1], motion)]
    return complex(spins[1], rates[1].imag)


__all__ = ["as_fast", "in_planes", "least_over", "whirls", "whirls_of_pieces"]
