"""What a peak in time is no more than on a box of designs, at whatever time it is.

At each time what is read is, but for second derivatives in the coefficients, a mean of what it is on the machines at
the corners of the box, weighed by the place; so no peak is above that mean of the peaks there, and what is left out is
bounded for all times at once.  A plane that none of the peaks at corners is above is above the mean, too.
"""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms.tangent import Opened, Tangent, bent
from vibopt.mechanics.kernel_bounds import extension, throughout

if TYPE_CHECKING:
    from vibopt.forms.peak_in_time import PeakInTime
    from vibopt.mechanics.model import Model

MOST = 4
"""Coefficients that may be open: each doubles the corners."""
_AT_ONCE = 256
_TURN = 2.0 * np.pi


def majorants(form: PeakInTime, model: Model, x: FloatArray, reach: FloatArray) -> list[list[Tangent]]:
    """Tangents of the negative of a peak on boxes around designs x that reach so far, both (n, n_vars)."""
    from vibopt.mechanics.harmonic import mount_count

    opened, peaks = Opened(model, form.output), form.peaks(model, x)
    p, share, exponents = model.values(x), 1.0 / mount_count(model, form.output, x[0]), opened.exponents
    off, curved = reach @ np.abs(exponents).T + bent(exponents, reach), bent(exponents, reach)
    found: list[list[Tangent]] = [[] for _ in x]
    known = np.flatnonzero(np.isfinite([peak.value for peak in peaks]) & (off <= 1.0).all(axis=1))
    if not len(known):
        return found
    moves = p[:, opened.active] * off
    machine, reading = form.transient(model, p[known])
    greatest = np.stack([np.abs(machine.peaks(extension(one)).value) for one in opened.elements], axis=-1)
    last = _last(form, model, p, off, opened)[known]
    near = throughout(machine, reading, opened.elements, last, greatest)
    if near is None:
        return found
    rests = near.rests(moves[known])
    some = np.isfinite(rests).all(axis=1)
    known, rests = known[some], rests[some] * share
    signs = np.array(list(product([-1.0, 1.0], repeat=len(opened.active))))
    corners = np.repeat(p[known, None], len(signs), axis=1)
    corners[..., opened.active] *= 1.0 + signs * off[known, None]
    tops = share * _sizes(form, model, corners.reshape(-1, p.shape[1])).reshape(len(known), len(signs))
    for i, top, rest in zip(known, tops, rests, strict=True):
        if not np.isfinite(top).all():
            continue
        middle, along = float(top.mean()), top @ signs / len(signs)
        slope = np.divide(along, off[i], out=np.zeros(len(along)), where=off[i] > 0.0)
        above = middle + float((top - middle - signs @ along).max()) - share * abs(peaks[i].value)
        each = rest + np.abs(slope) * curved[i]
        sides = (exponents != 0.0).T @ each
        found[i].append(Tangent(-share * abs(peaks[i].value), -slope @ exponents, above + float(each.sum()), sides))
    return found


def _sizes(form: PeakInTime, model: Model, p: FloatArray) -> FloatArray:
    """Peaks at coefficients p (n, n_terms), (n,)."""
    found = [np.zeros(0)]
    for k in range(0, len(p), _AT_ONCE):
        machine, reading = form.transient(model, p[k : k + _AT_ONCE])
        found.append(np.abs(machine.peaks(reading).value))
    return np.concatenate(found)


def _last(form: PeakInTime, model: Model, p: FloatArray, off: FloatArray, opened: Opened) -> FloatArray:
    """Time [s] from which on nothing greater comes on any machine of a box, (n,).

    Of one mass that swings it is a turn behind the load; of others it is infinite.
    """
    if model.n_free > 1:
        return np.full(len(p), np.inf)
    low, high = p.copy(), p.copy()
    low[:, opened.active] *= 1.0 - off
    high[:, opened.active] *= 1.0 + off
    least, most = (form.transient(model, some)[0] for some in (low, high))
    light, soft = least.mass[:, 0, 0], least.stiffness[:, 0, 0]
    heavy, braked = most.mass[:, 0, 0], most.damping[:, 0, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        squared = soft / heavy - (0.5 * braked / light) ** 2
        turn = np.where(squared > 0.0, _TURN / np.sqrt(np.abs(squared)), np.inf)
    long = sum(segment.length for segment in form.segments)
    return np.asarray(float(long) + turn)
