"""Steady harmonic response: u e^{i w t}, forces and motions as complex peak amplitudes."""

from __future__ import annotations

import numpy as np

from vibopt.forms import ComplexArray, FloatArray, Output
from vibopt.mechanics.modal import WORTH, Modal, decompose
from vibopt.mechanics.model import Model, factors
from vibopt.mechanics.modes import free_matrices


def impedances(model: Model, p: FloatArray, omega: FloatArray) -> ComplexArray:
    """Dynamic stiffness z_t of each term [N/m], shape (..., n_terms), at omega (...)."""
    return np.asarray(p) * factors(model.kinds, omega)


def dynamic_stiffness(model: Model, z: ComplexArray) -> ComplexArray:
    """D = sum_t z_t b_t b_t^T on free rows and all columns, shape (..., n_free, n_coords)."""
    vectors = model.vectors
    result: ComplexArray = np.matmul(vectors.T[: model.n_free] * z[..., None, :], vectors)
    return result


def bordered(model: Model, z: ComplexArray, output: Output, vector: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """Square blocks whose determinants are denominator and numerator of the transfer.

    Returns D (..., n, n) and the bordered matrix (..., n+1, n+1) with
    det(bordered) = det(D) * (row . u); no inverse is taken, so a resonance does no harm.
    """
    n = model.n_free
    both = dynamic_stiffness(model, z)
    stiff, to_base = both[..., :n], both[..., n:]
    load = vector[:n] - to_base @ vector[n:]
    row = output.row + (output.signs * z) @ model.vectors
    border = np.zeros((*z.shape[:-1], n + 1, n + 1), dtype=complex)
    border[..., :n, :n] = stiff
    border[..., :n, n] = load
    border[..., n, :n] = -row[..., :n]
    border[..., n, n] = row[..., n:] @ vector[n:]
    return stiff, border


def _assembled(model: Model, p: FloatArray, omega: FloatArray) -> ComplexArray:
    """D at one design and many frequencies, from its four matrices; as `dynamic_stiffness`."""
    n = model.n_free
    mass, stiff, damping, hysteretic = (model.matrix(kind, p)[:n] for kind in range(4))
    w = np.asarray(omega)[..., None, None]
    result: ComplexArray = (stiff + 1j * hysteretic) - w**2 * mass + 1j * w * damping
    return result


def modal_of(model: Model, p: FloatArray) -> Modal | None:
    """The modes of a model worth decomposing; None for small ones and where modes cannot be trusted."""
    if model.n_free < WORTH:
        return None
    mass, damping, stiffness, hysteretic = free_matrices(model, p)
    if not stiffness.any(axis=0).all():  # rigid motion
        return None
    return decompose(mass, damping, stiffness + 1j * hysteretic)


def motion(
    model: Model, p: FloatArray, vector: ComplexArray, omega: FloatArray, modal: Modal | None = None
) -> ComplexArray:
    """Motion of all coordinates per unit line amplitude [m], shape (..., n_coords); inf at a pole.

    `vector` (..., n_coords) is one line's, or one for each frequency.
    """
    n = model.n_free
    if modal is not None:
        return _through_modes(model, p, vector, omega, modal)
    both = _assembled(model, p, omega) if np.ndim(p) == 1 else dynamic_stiffness(model, impedances(model, p, omega))
    load = vector[..., :n] - (both[..., n:] @ vector[..., n:, None])[..., 0]
    if n == 1:
        with np.errstate(divide="ignore", invalid="ignore"):
            free = load / both[..., 0, :1]
    else:
        free = _solve(both[..., :n], load)
    base = np.broadcast_to(vector[..., n:], (*free.shape[:-1], vector.shape[-1] - n))
    return np.concatenate([free, base], axis=-1)


def _through_modes(model: Model, p: FloatArray, vector: ComplexArray, omega: FloatArray, modal: Modal) -> ComplexArray:
    n = model.n_free
    load = np.broadcast_to(vector[..., :n], (*omega.shape, n))
    if vector[..., n:].any():
        pull = (impedances(model, p, omega) * (vector[..., n:] @ model.vectors[:, n:].T)) @ model.vectors[:, :n]
        load = load - pull
    base = np.broadcast_to(vector[..., n:], (*omega.shape, vector.shape[-1] - n))
    return np.concatenate([modal.motion(load, omega), base], axis=-1)


def _solve(stiff: ComplexArray, load: ComplexArray) -> ComplexArray:
    scale = np.abs(stiff).max(axis=-1, keepdims=True)
    scale[scale == 0.0] = 1.0
    try:
        return np.asarray(np.linalg.solve(stiff / scale, (load / scale[..., 0])[..., None])[..., 0], dtype=complex)
    except np.linalg.LinAlgError:
        flat = (stiff / scale).reshape(-1, *stiff.shape[-2:])
        right = (load / scale[..., 0]).reshape(-1, stiff.shape[-1])
        rows = [_solve_one(a, b) for a, b in zip(flat, right, strict=True)]
        return np.array(rows).reshape(load.shape)


def _solve_one(stiff: ComplexArray, load: ComplexArray) -> ComplexArray:
    try:
        return np.asarray(np.linalg.solve(stiff, load), dtype=complex)
    except np.linalg.LinAlgError:
        return np.full(load.shape, np.inf, dtype=complex)


def transfer(
    model: Model,
    p: FloatArray,
    output: Output,
    vector: ComplexArray,
    omega: FloatArray,
    modal: Modal | None = None,
) -> ComplexArray:
    """Response per unit line amplitude, shape of omega [rad/s]; inf exactly at a pole; `vector` as in `motion`."""
    omega = np.asarray(omega, dtype=float)
    u = motion(model, p, vector, omega, modal)
    row = output.row + (output.signs * impedances(model, p, omega)) @ model.vectors
    with np.errstate(invalid="ignore", over="ignore"):
        value: ComplexArray = np.einsum("...i,...i->...", row, u)
        if output.power:
            value = value * (1j * omega) ** output.power
    return np.where(np.isnan(value), np.inf, value)
