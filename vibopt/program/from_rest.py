"""Responses from standstill on: coordinates in which nothing cancels, and a first speed in place of 0 times infinity.

Motion that no spring calls back grows as 1/w^2 towards w = 0, and so does a base whose acceleration is given.  In
coordinates of which some are just that motion, and the others move against it or against the base, every power of
w stands by itself.  The modulus is even in w, so its limit is met at a speed far below every mode, to all digits.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from vibopt.arrays import BoolArray, FloatArray
from vibopt.forms import Modulus
from vibopt.forms.drive_response import DriveResponse
from vibopt.mechanics.model import DAMPING, INERTIA, Model
from vibopt.mechanics.modes import poles
from vibopt.signals import Band

_NOTHING = 1e-12
"""Part of its terms that a sum must have not to be rounding."""
_PLAIN = 1e-6
"""Part of what is usual below which what grows towards standstill is rounding: ten decades further on it is no more."""
_FIRST = 1e-10
"""First speed over that of the slowest mode, or over the highest speed."""


def fades(model: Model, form: Modulus) -> bool:
    """Whether a base's motion is said by its velocity or acceleration, and so has no end at standstill."""
    lines = [line for drive in form.drives for line in drive.lines]
    return any(line.amplitude.grows_to_rest and line.vector[model.n_free :].any() for line in lines)


def graded(model: Model, form: Modulus) -> Model:
    """The model in coordinates for low speeds: rigid motions, those against dampers alone, and motion against these.

    The same model where springs hold everything and no base's motion grows towards standstill.
    """
    n = model.n_free
    if model.sprung and not fades(model, form):
        return model
    springs, falls = _rows(model, damped=False), fades(model, form)
    free = _nothing_done(springs[:, :n])
    if not falls and not free.shape[1]:
        return model
    dampers = _rows(model, damped=True)
    rigid = _nothing_done(np.concatenate([springs, dampers])[:, :n])
    loose = _beyond(free, rigid)
    first = np.hstack([rigid, loose])
    whole = np.eye(model.n_coords)
    whole[:n, :n] = np.hstack([first, np.delete(np.eye(n), _pivots(first, ~model.massless), axis=1)])
    if falls:
        whole[:n, n:] = _ride(springs, dampers, n)
    return model.through(whole, _NOTHING)


def from_rest(model: Model, form: Modulus, x: FloatArray) -> Modulus:
    """The form with a first speed instead of standstill, and the names of drives under which it has no limit there.

    Parameters
    ----------
    model
        In the coordinates of `graded`.
    form
        What is asked.
    x
        Some design, shape (n_vars,).
    """
    if not any(band.low == 0.0 for drive in form.drives for band in drive.bands):
        return form
    slowest = np.abs(poles(model, model.values(x)))
    slowest = slowest[slowest > 1e-6 * slowest.max(initial=0.0)].min(initial=1e3)
    drives, endless = [], []
    for drive in form.drives:
        order = max(line.order for line in drive.lines)
        tops = [band.high for band in drive.bands if 0.0 < band.high < np.inf]
        far = min(float(slowest) / order, *tops, np.inf)
        first = _FIRST * far
        here, above, typical = DriveResponse(model, form, drive, x)(np.array([first, 10.0 * first, 0.5 * far]))
        grows = not here <= max(2.0 * above, _PLAIN * typical if np.isfinite(typical) else 0.0)
        begins = any(band.low == 0.0 for band in drive.bands)
        endless += [drive.name] if begins and grows and _may_drift(model, form) else []
        bands = (Band(first, max(first, band.high)) if band.low == 0.0 else band for band in drive.bands)
        drives.append(replace(drive, bands=tuple(bands)))
    return replace(form, drives=tuple(drives), endless=tuple(endless))


def _may_drift(model: Model, form: Modulus) -> bool:
    """Whether something may move without end at standstill; of what springs hold only rounding may seem to."""
    return fades(model, form) or bool(_nothing_done(_rows(model, damped=False)[:, : model.n_free]).shape[1])


def _rows(model: Model, *, damped: bool) -> FloatArray:
    """Vectors of the dampers, or of springs with and without loss, that are there, each of length one."""
    chosen = (model.kinds == DAMPING) if damped else (model.kinds != DAMPING) & (model.kinds != INERTIA)
    rows = model.vectors[chosen & (model.scales > 0.0)]
    sizes = np.linalg.norm(rows, axis=1, keepdims=True)
    found: FloatArray = rows[sizes[:, 0] > 0.0] / sizes[sizes[:, 0] > 0.0]
    return found


def _nothing_done(rows: FloatArray) -> FloatArray:
    """Motions (n, r) on which no row (m, n) does work, each with a one of its own where all others have a zero."""
    return _motions(rows.shape, rows.tobytes()).copy()  # all questions to a machine ask it


@lru_cache(maxsize=16)
def _motions(shape: tuple[int, int], said: bytes) -> FloatArray:
    """The same of rows as their bytes."""
    n, rows = shape[1], np.frombuffer(said).reshape(shape)
    found = np.eye(n)
    if len(rows):
        _, sizes, across = np.linalg.svd(rows)
        found = across[int((sizes > 1e-10 * sizes[0]).sum()) :].T
    if not found.shape[1]:
        return found
    motions = found @ np.linalg.inv(found[_pivots(found)])
    return np.asarray(np.where(np.abs(motions) < _NOTHING, 0.0, motions))


def _beyond(motions: FloatArray, known: FloatArray) -> FloatArray:
    """Of motions (n, r) those that complete the known ones (n, q) among them, (n, r - q)."""
    kept = known
    for motion in motions.T:
        more = np.column_stack([kept, motion])
        kept = more if np.linalg.matrix_rank(more / np.linalg.norm(more, axis=0), tol=1e-10) == more.shape[1] else kept
    return kept[:, known.shape[1] :]


def _pivots(motions: FloatArray, among: BoolArray | None = None) -> list[int]:
    """Coordinates that tell independent motions (n, r) apart, the greatest first; `among` some (n,)."""
    rest, found = motions.copy() if among is None else motions * among[:, None], []
    for _ in range(motions.shape[1]):
        row = int(np.argmax((rest**2).sum(axis=1)))
        found.append(row)
        along = rest[row] / np.linalg.norm(rest[row])
        rest = rest - np.outer(rest @ along, along)
    return found


def _ride(springs: FloatArray, dampers: FloatArray, n: int) -> FloatArray:
    """How the coordinates move with each base (n, n_bases) when no spring is strained, nor a damper if that can be."""
    for rows in (np.concatenate([springs, dampers]), springs):
        if len(rows):
            ride = np.linalg.lstsq(rows[:, :n], -rows[:, n:], rcond=1e-10)[0]
            if np.abs(rows[:, :n] @ ride + rows[:, n:]).max(initial=0.0) <= 1e-10:
                return np.asarray(np.where(np.abs(ride - np.round(ride)) < _NOTHING, np.round(ride), ride))
    return np.zeros((n, springs.shape[1] - n))
