"""Free whirl of an isotropic rotor that spins: z = x + i y, with damping that turns with it and gyroscopic moments.

    M z'' + (C_e + C_i - i W G) z' + (K - i W C_i) z = 0

Spin W [rad/s] is positive in the sense of positive angles, e^{i w t} with w > 0 whirls forward.  All matrices are real
and symmetric, (n, n), M positive.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import field
from typing import Any

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.bracketing import crossing
from vibopt.mechanics.growth import first_growth, states
from vibopt.records import dataclass

MOST = 8
"""Coordinates up to which several rotating dampers, or gyroscopic moments, are answered."""
_AXIS, _NOTHING, _SAME = 1e-5, 1e-10, 1e-14
"""Part of its size by which a root may be off its axis before it is polished; of the greatest, what is rounding."""

_FOLLOWED, _MORE, _HIGHEST, _CLOSE, _MOVED = 16, 48, 300.0, 0.02, 0.2
"""Free motions of a rotor that are followed, and where these tell too little; the highest spin over its lowest
frequency; the part of itself by which a threshold of either may move when it is solved in all coordinates."""


class TooManyError(Exception):
    """Several rotating dampers among more coordinates than are answered."""


def threshold(mass: FloatArray, fixed: FloatArray, rotating: FloatArray, stiffness: FloatArray) -> float:
    """Least spin [rad/s] beyond which a whirl grows; infinite where none does.

    Motions that no damper reaches go on for ever at any spin, and are left out.

    Raises
    ------
    TooManyError
        Several rotating dampers and more than `MOST` coordinates.
    """
    size = np.sqrt(np.maximum(np.abs(np.diag(stiffness)) + np.diag(mass), 1e-300))
    if not rotating.any():
        return float("inf")
    if _unheld(stiffness / np.outer(size, size), rotating / np.outer(size, size)):
        return 0.0
    strengths, ways = np.linalg.eigh(rotating / np.outer(size, size))
    strong = strengths > _NOTHING * strengths.max()
    if strong.sum() == 1:
        way = size * ways[:, strong][:, 0] * np.sqrt(strengths[strong][0])
        return min(_of_one(mass, fixed + rotating, stiffness, way), default=float("inf"))
    return _of_several(mass, fixed, rotating, stiffness)


@dataclass(frozen=True, slots=True)
class Neutral:
    """A spin at which a whirl neither grows nor fades [rad/s], infinite of none; how fast it goes round [rad/s].

    Its motion (n,), empty where it is not known to all digits, and what D(w, W) of that motion changes by with both.
    """

    spin: float
    whirl: float = 0.0
    motion: ComplexArray = field(default_factory=lambda: np.zeros(0, dtype=complex))
    by_whirl: complex = 0.0
    by_spin: complex = 0.0


def rotor_threshold(
    mass: FloatArray, polar: FloatArray, fixed: FloatArray, rotating: FloatArray, stiffness: FloatArray
) -> Neutral:
    """As `threshold`, of a rotor with gyroscopic moments W P and any number of coordinates that springs hold.

    Followed over spins in its lowest free motions at rest, by steps that are sure, and solved in all coordinates from
    there; where that leads elsewhere, from where the growth of more free motions begins near it.
    """
    from scipy.linalg import eigh

    if not rotating.any():
        return Neutral(np.inf)
    periods, shapes = eigh(mass, stiffness)
    told = periods[::-1] > _SAME * periods[-1]
    squares, shapes = 1.0 / periods[::-1][told], shapes[:, ::-1][:, told] / np.sqrt(periods[::-1][told])
    unit, matrices = float(np.sqrt(squares[0])), (mass, polar, fixed + rotating, rotating, stiffness)

    def of(most: int) -> tuple[ComplexArray, ComplexArray]:
        ways = shapes[:, :most]
        damping, turning, turned = (ways.T @ one @ ways for one in (fixed + rotating, rotating, polar))
        first = states(squares[:most], damping, np.zeros_like(damping))
        return first, states(squares[:most], damping - 1j * turned, -1j * turning) - first

    first, slope = of(_FOLLOWED)
    begun = first_growth(first, slope, 0.0, _HIGHEST * unit, unit)
    if begun is None:
        return Neutral(np.inf)
    neutral = _neutral(*matrices, first + begun * slope, begun)
    if abs(neutral.spin - begun) <= _CLOSE * begun:
        return neutral
    first, slope = of(_MORE)

    def growth(spin: float) -> float:
        return float(np.linalg.eigvals(first + spin * slope).real.max()) - _NOTHING * unit

    low = high = begun
    while growth(low) > 0.0 and low > _NOTHING * begun:
        low *= 1.0 - _MOVED
    while growth(high) <= 0.0:
        high *= 1.0 + _MOVED
        if high > _HIGHEST * unit:
            return Neutral(np.inf)
    begun = crossing(growth, low, high)[1]
    neutral = _neutral(*matrices, first + begun * slope, begun)
    return neutral if abs(neutral.spin - begun) <= _MOVED * begun else Neutral(begun)


def _neutral(
    mass: FloatArray, polar: FloatArray, damping: FloatArray, rotating: FloatArray, stiffness: FloatArray,
    state: ComplexArray, spin: float,
) -> Neutral:  # fmt: skip
    """The spin near one of a `state` at which a whirl neither grows nor fades, by Newton; not a number if none is.

    By a quadratic form u^T D(w, W) u of its motion u, good to the square of what u is off.
    """
    rates = np.linalg.eigvals(state)
    whirl = float(rates[rates.real.argmax()].imag)
    moved = np.ones(len(mass), dtype=complex)
    for turn in range(40):
        dynamic = stiffness - whirl**2 * mass + 1j * whirl * damping - 1j * spin * rotating
        dynamic = dynamic + whirl * spin * polar
        try:
            for _ in range(1 if turn else 4):
                moved = np.linalg.solve(dynamic, moved)
                moved /= moved[np.abs(moved).argmax()]  # real but for what damps: rounding of what is stiff stays real
        except np.linalg.LinAlgError:  # singular to the last digit: this is the spin
            return Neutral(float(spin))
        along = -2.0 * whirl * mass + 1j * damping + spin * polar
        value, by_whirl, by_spin = (moved @ one @ moved for one in (dynamic, along, whirl * polar - 1j * rotating))
        table = [[by_whirl.real, by_spin.real], [by_whirl.imag, by_spin.imag]]
        try:
            step = np.linalg.solve(table, [-value.real, -value.imag])
        except np.linalg.LinAlgError:
            return Neutral(np.nan)
        whirl, spin = whirl + step[0], spin + step[1]
        if abs(step[0]) <= _SAME * abs(whirl) and abs(step[1]) <= _SAME * spin:
            break
    return Neutral(float(spin), whirl, moved, complex(by_whirl), complex(by_spin))


def _unheld(stiffness: FloatArray, rotating: FloatArray) -> bool:
    """Whether a rotating damper drags what no spring calls back: that grows at every spin."""
    values, ways = np.linalg.eigh(stiffness)
    loose = ways[:, values <= 1e-13 * max(values[-1], 1e-300)]
    return bool(np.abs(rotating @ loose).max(initial=0.0) > 1e-9 * np.abs(rotating).max())


def _of_one(mass: FloatArray, damping: FloatArray, stiffness: FloatArray, way: FloatArray) -> Iterator[float]:
    """Spins of neutral whirl where one damper b b^T turns: W = 1 / (i h), h = b^T (K - w^2 M + i w C)^-1 b.

    They are real where h is imaginary: at imaginary zeros s of h(s) + h(-s), values of one pencil.
    """
    from scipy.linalg import eigvals

    n = len(mass)
    unit = float(np.sqrt(np.abs(stiffness).max() / np.abs(mass).max())) or 1.0
    m, c, k, b = mass * unit**2, damping * unit, stiffness, way * np.sqrt(unit)
    scale = 1.0 / np.sqrt(np.maximum(np.abs(np.diag(k)) + np.diag(m) + np.diag(c), 1e-300))
    m, c, k = (one * np.outer(scale, scale) for one in (m, c, k))
    b = b * scale / np.linalg.norm(b * scale)
    zero, one = np.zeros((n, n)), np.eye(n)
    side = np.zeros((n, 1))
    # p = q(s) + q(-s), r = q(s) - q(-s): (s^2 M + K) p + s C r = b, (s^2 M + K) r + s C p = 0, b^T p = 0
    left = np.block([
        [zero, zero, one, zero, side], [zero, zero, zero, one, side],
        [-k, zero, zero, -c, b[:, None]], [zero, -k, -c, zero, side],
        [b[None, :], np.zeros((1, 3 * n + 1))],
    ])  # fmt: skip
    right = np.zeros_like(left)
    right[: 2 * n, : 2 * n] = np.eye(2 * n)
    right[2 * n : 3 * n, 2 * n : 3 * n] = right[3 * n : 4 * n, 3 * n : 4 * n] = m
    above, below = eigvals(left, right, homogeneous_eigvals=True)
    finite = np.abs(below) > _NOTHING * np.abs(above)
    rates = above[finite] / below[finite]
    neutral = rates[(np.abs(rates.real) <= _AXIS * np.abs(rates)) & (rates.imag > 0.0)].imag
    strength = float(np.linalg.norm(way * np.sqrt(unit) * scale)) ** 2

    def inverse(omega: float) -> tuple[complex, complex]:
        """1 / h and its slope."""
        dynamic = k - omega**2 * m + 1j * omega * c
        moved = np.linalg.solve(dynamic, b.astype(complex))
        h, slope = b @ moved, -moved @ (1j * c - 2.0 * omega * m) @ moved
        return complex(1.0 / h), complex(-slope / h**2)

    for start in np.unique(neutral):
        omega = float(start)
        for _ in range(20):
            value, slope = inverse(omega)
            step = value.real / slope.real if slope.real else 0.0
            omega -= step
            if abs(step) <= _SAME * omega:
                break
        value, _ = inverse(omega)
        if omega > 0.0 and abs(omega - start) <= 1e3 * _AXIS * start and value.imag > 0.0:
            yield value.imag / strength * unit  # W = Im(1 / h)


def _of_several(mass: FloatArray, fixed: FloatArray, rotating: FloatArray, stiffness: FloatArray) -> float:
    """Where a rate meets the mirror image of one in the imaginary axis: A(W) x I + I x conj(A(W)) is singular.

    A is linear in the spin, so these are the values of one pencil, of which the least with a neutral rate counts.
    """
    from scipy.linalg import eigvals

    root = np.linalg.inv(np.linalg.cholesky(mass))
    own = [root @ one @ root.T for one in (fixed + rotating, rotating, stiffness)]
    basis = _damped(own[0], own[2])
    if basis.shape[1] > MOST:
        raise TooManyError
    own = [basis.T @ one @ basis for one in own]
    size = float(np.sqrt(np.abs(own[2]).max(initial=0.0))) or 1.0
    first, slope = _states(own[0] / size, own[1] / size, own[2] / size**2)
    unit = np.eye(len(first))
    still = np.kron(first, unit) + np.kron(unit, first.conj())
    moving = np.kron(slope, unit) + np.kron(unit, slope.conj())
    above, below = eigvals(still, -moving, homogeneous_eigvals=True)
    finite = np.abs(below) > 1e-12 * np.abs(above)
    spins = above[finite] / below[finite]
    real = np.sort(spins[(np.abs(spins.imag) <= 1e-4 * np.abs(spins)) & (spins.real > 0.0)].real)
    for start in real:
        spin = _polished(first, slope, float(start))
        if spin is not None:
            return spin * size
    grows = np.linalg.eigvals(first + (real.max(initial=1.0)) * slope).real.max() > _NOTHING
    return 0.0 if grows and not len(real) else float("inf")


def _polished(first: ComplexArray, slope: ComplexArray, spin: float) -> float | None:
    """The spin near one at which a rate is neutral; None where none is."""
    from scipy.linalg import eig

    begun = spin
    for _ in range(30):
        found: Any = eig(first + spin * slope, left=True, right=True)
        rates, left, right = found
        near = int(np.argmin(np.abs(rates.real)))
        change = (left[:, near].conj() @ slope @ right[:, near]) / (left[:, near].conj() @ right[:, near])
        step = float(rates[near].real / change.real) if change.real else 0.0
        if abs(step) > 1e-2 * begun:
            return None
        spin -= step
        if abs(step) <= _SAME * spin:
            break
    return spin if abs(spin - begun) <= 1e-2 * begun else None


def _states(damping: FloatArray, rotating: FloatArray, stiffness: FloatArray) -> tuple[ComplexArray, ComplexArray]:
    """Rates of places and rates of a rotor of unit masses at rest, and what the spin adds to them, (2 n, 2 n)."""
    n = len(damping)
    zero = np.zeros((n, n))
    first = np.block([[zero, np.eye(n)], [-stiffness, -damping]]).astype(complex)
    return first, 1j * np.block([[zero, zero], [rotating, zero]])


def _damped(damping: FloatArray, stiffness: FloatArray) -> FloatArray:
    """Basis (n, k) of the motions that dampers reach, of unit masses."""
    found = np.zeros((len(damping), 0))
    new = damping / max(np.abs(damping).max(), 1e-300)
    scale = max(np.abs(stiffness).max(), 1e-300)
    while new.shape[1] and found.shape[1] < len(damping):
        rest = new - found @ (found.T @ new)
        left, sizes, _ = np.linalg.svd(rest - found @ (found.T @ rest), full_matrices=False)
        fresh = left[:, sizes > 1e-9]
        found = np.hstack([found, fresh])
        new = stiffness @ fresh / scale
    return found
