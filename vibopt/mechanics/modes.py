"""Free vibration and sag, with their slopes: poles of det D(w) = 0, natural frequencies, damping ratios."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.mechanics.constants import GRAVITY
from vibopt.mechanics.joints import condensed, first_order, massless
from vibopt.mechanics.model import DAMPING, HYSTERETIC, INERTIA, STIFFNESS, Model, kept

_TOGETHER = 1_000_000
"""Entries of matrices that are taken at once."""
_MIXED = 1e-9
"""Part of itself by which the square of a frequency differs at least from that of a mode that mixes with it."""
_FREE = 1e-14
"""Part of the greatest square of a frequency up to which one is rounding, of a mode that nothing holds."""
_STILL = 1e-12
"""Part of the longest period below which one is rounding."""


def free_matrices(model: Model, p: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """M, C, K, H on the free coordinates, each (n_free, n_free)."""
    n = model.n_free
    kinds = (INERTIA, DAMPING, STIFFNESS, HYSTERETIC)
    made = model.sums if model.spins else model.matrix
    mass, damping, stiffness, hysteretic = (made(kind, p)[:n, :n] for kind in kinds)
    return mass, damping, stiffness, hysteretic


def poles(model: Model, p: FloatArray) -> ComplexArray:
    """Complex frequencies w with det D(w) = 0 [rad/s], time factor e^{i w t}, Im w > 0 for decaying motion.

    Two of each coordinate with mass, one of what only dampers and springs hold.
    """
    mass, damping, stiffness, hysteretic = free_matrices(model, p)
    n = model.n_free
    if model.spins:
        return _poles_by_inverse(mass, damping, stiffness + 1j * hysteretic)
    if model.massless.any():
        return -1j * np.linalg.eigvals(_states(mass, damping, stiffness + 1j * hysteretic)[0])
    if n == 1:
        return _poles_of_one(mass[0, 0], damping[0, 0], stiffness[0, 0] + 1j * hysteretic[0, 0])
    root = np.linalg.cholesky(mass)
    inverse = np.linalg.inv(root)
    k = inverse @ (stiffness + 1j * hysteretic) @ inverse.T
    c = inverse @ damping @ inverse.T
    if not c.any():
        squares = np.linalg.eigvals(k) if hysteretic.any() else np.linalg.eigvalsh(k.real).astype(complex)
        half = np.sqrt(squares)
        return np.concatenate([half, -half])
    scale = np.sqrt(max(np.abs(k).max(), np.abs(c).max() ** 2))
    first = np.block([[np.zeros((n, n)), np.eye(n)], [k / scale**2, 1j * c / scale]])
    result: ComplexArray = np.linalg.eigvals(first) * scale
    return result


def _poles_by_inverse(mass: FloatArray, damping: FloatArray, stiffness: ComplexArray) -> ComplexArray:
    """As `poles`, where the inertia against a whirl need not be positive but springs hold everything."""
    n = len(mass)
    still = np.linalg.solve(stiffness, np.hstack([mass, damping]))
    slow = float(np.sqrt(np.abs(np.linalg.eigvals(still[:, :n])).max()))
    state = np.block([[np.zeros((n, n)), np.eye(n)], [still[:, :n] / slow**2, -1j * still[:, n:] / slow]])
    periods = np.linalg.eigvals(state) * slow
    return np.asarray(1.0 / periods[np.abs(periods) > _STILL * slow], dtype=complex)


def whirls(model: Model, p: FloatArray) -> tuple[FloatArray, FloatArray]:
    """1 / w^2 of each free undamped whirl (n,), greatest first, and motions (n, n) that have potential energy 1/2.

    The stiffness is positive.  Where the first is not, gyroscopic moments keep that motion from ever being free.
    """

    def found(each: FloatArray) -> Iterator[tuple[FloatArray, FloatArray]]:
        for one in each:
            mass, _, stiffness, _ = free_matrices(model, one)
            root = np.linalg.inv(np.linalg.cholesky(stiffness))
            squares, vectors = np.linalg.eigh(root @ mass @ root.T)
            yield squares[::-1], (root.T @ vectors)[:, ::-1]

    return kept(model, "whirls", p[None], found, most=4)[0]


def critical_speeds(model: Model, p: FloatArray) -> FloatArray:
    """Speeds of free undamped whirl with the spin at coefficients p (n, n_terms), ascending, (n, n_free) [rad/s].

    Infinite for each that gyroscopic moments keep away.
    """
    n = model.n_free

    def found(each: FloatArray) -> FloatArray:
        if len(each) == 1:
            inverse: Any = whirls(model, each[0])[0][None]
        else:
            root = np.linalg.inv(np.linalg.cholesky(model.sums(STIFFNESS, each)[:, :n, :n]))
            mass = model.sums(INERTIA, each)[:, :n, :n]
            inverse = np.linalg.eigvalsh(root @ mass @ np.swapaxes(root, 1, 2))[:, ::-1]
        return np.asarray(np.where(inverse > 0.0, 1.0 / np.sqrt(np.abs(inverse)), np.inf))

    parts = np.array_split(p, len(p) * n**2 // _TOGETHER + 1)
    return np.array([one for part in parts for one in kept(model, "critical speeds", part, found)]).reshape(-1, n)


def _poles_of_one(mass: float, damping: float, stiffness: complex) -> ComplexArray:
    """Roots of m w^2 - i c w - k = 0, the small root without cancellation."""
    half = 0.5j * damping / mass
    root = np.sqrt(complex(stiffness / mass) + half * half)
    large = half + root if (half * np.conj(root)).real >= 0 else half - root
    small = -(stiffness / mass) / large if large != 0 else 0.0
    return np.array([large, small], dtype=complex)


def _states(mass: FloatArray, damping: FloatArray, stiffness: ComplexArray | FloatArray) -> tuple[Any, Any]:
    """Rates (N, N) of the states of a machine with joints, and its free coordinates from these, (n_free, N)."""
    stiffness = stiffness if np.asarray(stiffness).imag.any() else np.asarray(stiffness).real
    found = first_order(mass, damping, stiffness, len(mass))
    return found.rates, found.places


def undamped_root(mass: FloatArray, stiffness: FloatArray) -> FloatArray:
    """R (n_modes, n_free) with R M R^T = 1, where joints without mass follow the springs."""
    n = len(mass)
    if not len(massless(mass, n)):
        return np.asarray(np.linalg.inv(np.linalg.cholesky(mass)))
    still = condensed(mass, np.zeros_like(mass), stiffness, n)
    return np.asarray(np.linalg.inv(np.linalg.cholesky(still.mass)) @ still.lift.T)


def natural_frequencies(model: Model, p: FloatArray) -> FloatArray:
    """Undamped natural frequencies in ascending order [rad/s], one of each free coordinate with mass.

    Of what spins the critical speeds of whirl with the spin; infinite for each that gyroscopic moments keep away.
    """
    if model.spins:
        only: FloatArray = critical_speeds(model, p[None])[0]
        return only
    mass, _, stiffness, _ = free_matrices(model, p)
    if model.n_free == 1:
        return np.asarray(np.sqrt(stiffness[0] / mass[0, 0]))
    root = undamped_root(mass, stiffness)
    squares = np.linalg.eigvalsh(root @ stiffness @ root.T)
    found: FloatArray = np.sqrt(np.maximum(squares, 0.0))
    return found


def mode_shapes(model: Model, p: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Natural frequencies (n_modes,) [rad/s] and mass-normalised shapes (n_free, n_modes)."""
    if model.spins:
        inverse, shapes = whirls(model, p)
        free = inverse > 0.0
        return 1.0 / np.sqrt(inverse[free]), shapes[:, free] / np.sqrt(inverse[free])
    mass, _, stiffness, _ = free_matrices(model, p)
    root = undamped_root(mass, stiffness)
    squares, vectors = np.linalg.eigh(root @ stiffness @ root.T)
    return np.sqrt(np.maximum(squares, 0.0)), root.T @ vectors


def damping_ratios(model: Model, p: FloatArray) -> FloatArray:
    """Damping ratio of every oscillating or overdamped mode, ascending, shape (n_modes,).

    Viscous: Im w / |w| of each pole with Re w >= 0; two real decay rates count as one mode
    with the ratio (a + b) / (2 sqrt(a b)).  A rigid-body pole at zero has none and is left out.
    """
    w = held_poles(model, p)
    turning = w[w.real > 1e-9 * np.abs(w)]
    still = np.sort(w[np.abs(w.real) <= 1e-9 * np.abs(w)].imag)
    pairs = [
        (a + b) / (2.0 * np.sqrt(a * b))
        for a, b in zip(still[: len(still) // 2], still[::-1][: len(still) // 2], strict=True)
        if a * b > 0
    ]
    return np.sort(np.concatenate([turning.imag / np.abs(turning), np.array(pairs)]))


def decay_rates(model: Model, p: FloatArray) -> FloatArray:
    """Decay rate of every pole [1/s], Im w, ascending; poles of rigid motion, which are at zero, are left out."""
    return np.sort(np.maximum(held_poles(model, p).imag, 0.0))


def held_poles(model: Model, p: FloatArray) -> ComplexArray:
    """As `poles`, ascending by size, without those of rigid motion: rounding moves two at zero by its root."""
    w = poles(model, p)
    return w[np.argsort(np.abs(w))[rigid_count(model, p) :]]


def rigid_count(model: Model, p: FloatArray) -> int:
    """Number of poles at zero: one per motion that no spring holds, a second one where no damper does either."""

    def loose(acts: FloatArray, *kinds: int) -> int:
        rows = model.vectors[np.isin(model.kinds, kinds) & (acts > 0.0), : model.n_free]
        rows = rows[rows.any(axis=1)]
        sizes = np.linalg.norm(rows, axis=1, keepdims=True)
        return model.n_free - (int(np.linalg.matrix_rank(rows / sizes, tol=1e-10)) if len(rows) else 0)

    def found(each: FloatArray) -> Iterator[int]:
        for acts in each:
            yield loose(acts, STIFFNESS, HYSTERETIC) + loose(acts, STIFFNESS, HYSTERETIC, DAMPING)

    return kept(model, "rigid motions", np.sign(p)[None], found)[0]


def sag(model: Model, x: FloatArray) -> FloatArray | None:
    """Displacement under all weights [m], shape (n_coords,), to be read; None where nothing holds the machine."""
    return kept(model, "sag", x[None], lambda rows: (_sag(model, row) for row in rows))[0]


def _sag(model: Model, x: FloatArray) -> FloatArray | None:
    n = model.n_free
    p = model.values(x, static=True)
    stiff = model.matrix(STIFFNESS, p)[:n, :n]
    load = model.weights(p)[:n] * GRAVITY
    down, root = np.zeros(model.n_coords), np.sqrt(np.abs(np.diag(stiff)))
    if not np.all(root > 0.0):
        return None
    if n == 1:
        down[0] = load[0] / stiff[0, 0]
        return down
    scaled = stiff / np.outer(root, root)
    levels = np.abs(np.linalg.eigvalsh(scaled))
    if not levels.min() * 1e14 >= levels.max():
        return None
    down[:n] = np.linalg.solve(scaled, load / root) / root
    return down


def sag_bend(model: Model, asked: FloatArray, x: FloatArray) -> FloatArray | None:
    """Second derivative of the log of asked . u in log x, (n_vars, n_vars); None where there is none."""
    n, down = model.n_free, sag(model, x)
    value = 0.0 if down is None else float(asked @ down)
    if down is None or not value:
        return None
    p, vectors, slopes = model.values(x, static=True), model.vectors[:, :n], model.exponents
    springs, heavy = np.where(model.kinds == STIFFNESS, p, 0.0), np.where(model.kinds == INERTIA, GRAVITY * p, 0.0)
    stiff = (vectors.T * springs) @ vectors
    size = np.sqrt(np.diag(stiff))
    stiff = stiff / np.outer(size, size)
    row = vectors @ (np.linalg.solve(stiff, asked[:n] / size) / size)
    sunk = heavy - springs * (vectors @ down[:n])
    pushed = (vectors.T @ (sunk[:, None] * slopes)) / size[:, None]
    pulled = (vectors.T @ ((springs * row)[:, None] * slopes)) / size[:, None]
    mixed = pulled.T @ np.linalg.solve(stiff, pushed)
    slope = (row * sunk) @ slopes / value
    bend = ((slopes.T * (row * sunk)) @ slopes - mixed - mixed.T) / value
    return np.asarray(bend - np.outer(slope, slope))


def sag_slope(model: Model, asked: FloatArray, x: FloatArray) -> FloatArray:
    """Slope of the log of asked . u in log x, (n_vars,).

    The sag u solves K u = m g; its slope is r . K^-1 (dm g - dK u).
    """
    n = model.n_free
    down = sag(model, x)
    if down is None or not asked @ down:
        return np.zeros(model.n_vars)
    p = model.values(x, static=True)
    stiff = model.matrix(STIFFNESS, p)[:n, :n]
    size = np.sqrt(np.diag(stiff))
    row = np.linalg.solve(stiff / np.outer(size, size), asked[:n] / size) / size
    vectors = model.vectors[:, :n]
    change = np.where(model.kinds == INERTIA, GRAVITY * p * (vectors @ row), 0.0)
    change -= np.where(model.kinds == STIFFNESS, p * (vectors @ row) * (vectors @ down[:n]), 0.0)
    value = float(asked @ down)
    slope: FloatArray = change @ model.exponents / value if value else np.zeros(model.n_vars)
    return slope


def frequency_slopes(model: Model, x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Natural frequencies (n_modes,) [rad/s] and the slopes of their logs (n_modes, n_vars), zero of free motion."""
    p = model.values(x)
    omega, shapes = mode_shapes(model, p)
    share = (model.vectors[:, : model.n_free] @ shapes) ** 2
    springs = p * (model.kinds == STIFFNESS)
    masses = p * (model.kinds == INERTIA)
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = 0.5 * ((share.T * springs) / (omega**2)[:, None] - share.T * masses) @ model.exponents
    slope[omega**2 <= _FREE * (omega**2).max(initial=0.0)] = 0.0
    return omega, np.nan_to_num(slope)


def frequency_bends(model: Model, x: FloatArray, indices: Sequence[int]) -> list[FloatArray] | None:
    """Second derivatives of the logs of natural frequencies (0 is the lowest) in log x, each (n_vars, n_vars).

    Modes that are as fast, to the last digits, are taken not to mix; None where joints without mass follow.
    """
    if model.massless.any():
        return None
    p, n, slopes = model.values(x), model.n_free, model.exponents
    if model.spins:
        values, shapes = whirls(model, p)
    else:
        omega, shapes = mode_shapes(model, p)
        values = omega**2
    upper, lower, power = (INERTIA, STIFFNESS, -0.5) if model.spins else (STIFFNESS, INERTIA, 0.5)
    reads, held, found = model.vectors[:, :n] @ shapes, p * (model.kinds == lower), []
    for index in indices:
        own, value = reads[:, index], values[index]
        if value <= _FREE * values.max():
            found.append(np.zeros((model.n_vars, model.n_vars)))
            continue
        moved = p * (model.kinds == upper) - value * held
        mixed = (reads * (moved * own)[:, None]).T @ slopes
        gaps = value - values
        gaps[np.abs(gaps) <= _MIXED * abs(value)] = np.inf
        slope, beside = mixed[index], (held * own**2) @ slopes
        bend = (slopes.T * (moved * own**2)) @ slopes + 2.0 * (mixed.T / gaps) @ mixed
        bend -= np.outer(slope, beside) + np.outer(beside, slope)
        found.append(power * (bend / value - np.outer(slope, slope) / value**2))
    return found


def rates_and_shapes(model: Model, p: FloatArray) -> tuple[ComplexArray, ComplexArray]:
    """Rates s of free motion e^{s t} [1/s] (m,) with Im s >= 0 and no rigid motion, and shapes (n_free, m)."""
    mass, damping, stiffness, _ = free_matrices(model, p)
    n = model.n_free
    if model.massless.any():
        system, places = _states(mass, damping, stiffness)
        rates, vectors = np.linalg.eig(system)
        order = np.argsort(np.abs(rates))[rigid_count(model, p) :]
        chosen = order[rates[order].imag >= 0.0]
        return rates[chosen].astype(complex), (places @ vectors[:, chosen]).astype(complex)
    root = np.linalg.inv(np.linalg.cholesky(mass))
    k, c = root @ stiffness @ root.T, root @ damping @ root.T
    scale = float(np.sqrt(np.abs(k).max()) or np.abs(c).max() or 1.0)
    state = np.block([[np.zeros((n, n)), np.eye(n)], [-k / scale**2, -c / scale]])
    rates, vectors = np.linalg.eig(state)
    order = np.argsort(np.abs(rates))[rigid_count(model, p) :]
    chosen = order[rates[order].imag >= 0.0]
    return (rates[chosen] * scale).astype(complex), (root.T @ vectors[:n, chosen]).astype(complex)


def pole_slopes(model: Model, x: FloatArray) -> tuple[ComplexArray, ComplexArray]:
    """Rates of free motion (m,) and their slopes in log x (m, n_vars); large where two poles nearly meet."""
    p = model.values(x)
    rates, shapes = rates_and_shapes(model, p)
    share = (model.vectors[:, : model.n_free] @ shapes) ** 2
    power = np.select([model.kinds == INERTIA, model.kinds == DAMPING, model.kinds == STIFFNESS], [2, 1, 0], 0)
    each = share.T * p * rates[:, None] ** power
    with np.errstate(divide="ignore", invalid="ignore"):
        slopes = -(each @ model.exponents) / ((power * each).sum(axis=1) / rates)[:, None]
    return rates, np.nan_to_num(slopes)


def characteristic(model: Model, p: FloatArray, scale: float) -> FloatArray:
    """Coefficients of det(s^2 M + s C + K) in s / scale, ascending, the last of them 1: one more than poles.

    p
        Coefficients of machines, (..., n_terms); what is found is (..., n_poles + 1).
    """
    n = model.n_free
    mass, damping, stiffness = (model.sums(kind, p)[..., :n, :n] for kind in (INERTIA, DAMPING, STIFFNESS))
    if model.massless.any():
        each = zip(*(one.reshape(-1, n, n) for one in (mass, damping, stiffness)), strict=True)
        rows = [np.poly(np.linalg.eigvals(_states(*one)[0]) / scale).real[::-1] for one in each]
        return np.array(rows).reshape(*p.shape[:-1], -1)
    root = np.linalg.inv(np.linalg.cholesky(mass))
    k, c = (root @ one @ root.mT / scale**power for one, power in ((stiffness, 2), (damping, 1)))
    circle = np.exp(2j * np.pi * np.arange(2 * n + 1) / (2 * n + 1))[:, None, None]
    values = np.linalg.det(circle**2 * np.eye(n) + circle * c[..., None, :, :] + k[..., None, :, :])
    return np.asarray((np.fft.fft(values) / (2 * n + 1)).real)


def modes_at(model: Model, x: FloatArray) -> FloatArray:
    """Undamped natural frequencies at designs x (n, n_vars) [rad/s], ascending, shape (n, n_modes)."""
    p, n = model.values(x), model.n_free
    if model.spins:
        return critical_speeds(model, p)
    vectors = model.vectors[:, :n]
    pairs = vectors[:, :, None] * vectors[:, None, :]
    stiff = np.tensordot(p * (model.kinds == STIFFNESS), pairs, axes=1)
    mass = np.tensordot(p * (model.kinds == INERTIA), pairs, axes=1)
    if n == 1:
        only: FloatArray = np.sqrt(stiff[:, :, 0] / mass[:, :, 0])
        return only
    return undamped(mass, stiff)


def undamped(mass: FloatArray, stiff: FloatArray) -> FloatArray:
    """Undamped natural frequencies of many machines (n, n_free, n_free) [rad/s], ascending, shape (n, n_modes)."""
    light = massless(mass[0], mass.shape[1]) if len(mass) else np.zeros(0, dtype=int)
    if len(light):
        heavy = np.setdiff1d(np.arange(mass.shape[1]), light)
        across = stiff[:, light[:, None], heavy]
        held = np.linalg.solve(stiff[:, light[:, None], light], across)
        stiff = stiff[:, heavy[:, None], heavy] - np.swapaxes(across, 1, 2) @ held
        mass = mass[:, heavy[:, None], heavy]
    root = np.linalg.inv(np.linalg.cholesky(mass))
    squares = np.linalg.eigvalsh(root @ stiff @ np.swapaxes(root, 1, 2))
    return np.asarray(np.sqrt(np.maximum(squares, 0.0)))


def sags_at(model: Model, x: FloatArray) -> FloatArray:
    """Displacement of the free coordinates under the weights at designs x (n, n_vars) [m], shape (n, n_free).

    Not a number where nothing holds them.
    """
    products = model.products(x)
    springs, heavy = model.static_blocks()
    stiff, load = np.tensordot(products, springs, axes=1), products @ heavy
    try:
        return np.asarray(np.linalg.solve(stiff, GRAVITY * load[..., None])[..., 0], dtype=float)
    except np.linalg.LinAlgError:
        return np.full(load.shape, np.nan)
