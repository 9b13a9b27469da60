"""Steady harmonic response: u e^{i w t}, forces and motions as complex peak amplitudes."""

from __future__ import annotations

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray, IntArray
from vibopt.mechanics.modal import WORTH, Modal, Undamped, decompose, undamped
from vibopt.mechanics.model import DAMPING, HYSTERETIC, Model, factors, kept
from vibopt.mechanics.modes import free_matrices, whirls
from vibopt.signals import Output


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


def assembled(model: Model, p: FloatArray, omega: FloatArray) -> ComplexArray:
    """D at one design and many frequencies, or at many of what spins, from four matrices; as `dynamic_stiffness`."""
    n = model.n_free
    made = model.sums if model.spins else model.matrix
    mass, stiff, damping, hysteretic = (made(kind, p)[..., :n, :] for kind in range(4))
    w = np.asarray(omega)[..., None, None]
    real = stiff - w**2 * mass
    result = np.empty(real.shape, dtype=complex)
    result.real, result.imag = real, hysteretic + w * damping
    return result


def modal_of(model: Model, p: FloatArray, top: float) -> Modal | Undamped | None:
    """The modes of a model worth decomposing; None for small ones and where modes cannot be trusted.

    Those of what spins are good up to the frequency `top` [rad/s].
    """
    if model.n_free < WORTH:
        return None
    if model.spins:
        return kept(model, ("modes", top), p[None], lambda each: [_whirling(model, one, top) for one in each], most=4)[
            0
        ]
    mass, damping, stiffness, hysteretic = free_matrices(model, p)
    if not stiffness.any(axis=0).all():  # rigid motion
        return None
    return decompose(mass, damping, stiffness + 1j * hysteretic)


def _whirling(model: Model, p: FloatArray, top: float) -> Undamped | None:
    some = np.flatnonzero(np.isin(model.kinds, (DAMPING, HYSTERETIC)) & (p != 0.0))
    return undamped(*whirls(model, p), model.vectors[some, : model.n_free], p[some], model.kinds[some] == DAMPING, top)


def motion(model: Model, p: FloatArray, vector: ComplexArray, omega: FloatArray) -> ComplexArray:
    """Motion of all coordinates per unit line amplitude [m], shape (..., n_coords); inf at a pole.

    `vector` (..., n_coords) is one line's, or one for each frequency.
    """
    n = model.n_free
    both = (
        assembled(model, p, omega)
        if np.ndim(p) == 1 or model.spins
        else dynamic_stiffness(model, impedances(model, p, omega))
    )
    shaken = vector.shape[-1] > n
    if shaken:
        load = vector[..., :n] - (both[..., n:] @ vector[..., n:, None])[..., 0]
    else:
        load = np.broadcast_to(vector, (*np.broadcast_shapes(both.shape[:-2], vector.shape[:-1]), n))
    if n == 1:
        with np.errstate(divide="ignore", invalid="ignore"):
            free = load / both[..., 0, :1]
    else:
        free = _solve(both[..., :n], load)
    if not shaken:
        return free
    base = np.broadcast_to(vector[..., n:], (*free.shape[:-1], vector.shape[-1] - n))
    return np.concatenate([free, base], axis=-1)


def _through_modes(
    model: Model, p: FloatArray, output: Output, vector: ComplexArray, omega: FloatArray, modal: Modal | Undamped
) -> ComplexArray:
    """As `transfer` without its power: what the row reads of each mode times what the load gives to it."""
    n, rows, base = model.n_free, model.vectors, vector[..., model.n_free :]
    taken, pulling = np.flatnonzero(output.signs), np.flatnonzero(rows[:, n:].any(axis=1))
    reads = np.concatenate([np.ones((*omega.shape, 1)), output.signs[taken] * _of(model, taken, p, omega)], axis=-1)
    lines = np.concatenate([output.row[None, :], rows[taken]])
    load = vector[..., :n]
    if base.any():
        pulled = _of(model, pulling, p, omega) * (base @ rows[pulling, n:].T)
        load = load - pulled @ rows[pulling, :n]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        seen = modal.seen(lines[:, :n], load, omega) + base @ lines[:, n:].T
        value: ComplexArray = (reads * seen).sum(axis=-1)
    return value


def _of(model: Model, terms: IntArray, p: FloatArray, omega: FloatArray) -> ComplexArray:
    """Dynamic stiffness of some terms [N/m], shape (..., n_chosen)."""
    return np.asarray(p[..., terms] * factors(model.kinds[terms], omega))


def _solve(stiff: ComplexArray, load: ComplexArray) -> ComplexArray:
    scale = np.abs(stiff).max(axis=-1, keepdims=True)
    scale[scale == 0.0] = 1.0
    try:
        return np.asarray(np.linalg.solve(stiff / scale, (load / scale[..., 0])[..., None])[..., 0], dtype=complex)
    except np.linalg.LinAlgError:
        if stiff.ndim == 2:
            return np.full(load.shape, np.inf, dtype=complex)
        each = zip(stiff.reshape(-1, *stiff.shape[-2:]), load.reshape(-1, load.shape[-1]), strict=True)
        return np.array([_solve(*one) for one in each]).reshape(load.shape)


def transfer(
    model: Model,
    p: FloatArray,
    output: Output,
    vector: ComplexArray,
    omega: FloatArray,
    modal: Modal | Undamped | None = None,
) -> ComplexArray:
    """Response per unit line amplitude, shape of omega [rad/s]; inf exactly at a pole; `vector` as in `motion`."""
    omega = np.asarray(omega, dtype=float)
    with np.errstate(invalid="ignore", over="ignore"):
        if modal is not None:
            value = _through_modes(model, p, output, vector, omega, modal)
        else:
            u = motion(model, p, vector, omega)
            taken = np.flatnonzero(output.signs)
            row: FloatArray | ComplexArray = output.row
            if len(taken):
                row = row + (output.signs[taken] * _of(model, taken, p, omega)) @ model.vectors[taken]
            value = np.asarray(np.einsum("...i,...i->...", row, u), dtype=complex)
        if output.power:
            value = value * (1j * omega) ** output.power
    return np.where(np.isnan(value), np.inf, value)


def mount_count(model: Model, output: Output, x: FloatArray) -> float:
    """Number of mounts by which the value is divided."""
    if not output.shared_by:
        return 1.0
    count = model.counts[output.shared_by]
    return float(count.scale * np.prod([x[i] ** e for i, e in count.exponents.items()]))


def stretches(model: Model, u: FloatArray | ComplexArray) -> FloatArray:
    """Stretch of each term with nothing cancelled, (n_terms,)."""
    found: FloatArray = np.abs(model.vectors) @ np.abs(u)
    return found


def carried(
    model: Model,
    z: FloatArray | ComplexArray,
    stiff: ComplexArray,
    row: FloatArray | ComplexArray,
    u: FloatArray | ComplexArray,
) -> float:
    """Sum of |coefficient| times what the adjoint and the motion make of it, nothing cancelled."""
    try:
        back = np.linalg.solve(stiff.T, np.asarray(row, dtype=complex)[: model.n_free])
    except np.linalg.LinAlgError:
        return np.inf
    whole = np.concatenate([back, np.zeros(model.n_coords - model.n_free)])
    return float(np.abs(z) @ (stretches(model, whole) * stretches(model, u)) + np.abs(row) @ np.abs(u))
