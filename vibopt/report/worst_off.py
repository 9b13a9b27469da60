"""Worst values of forms over many designs at once, for pictures: speeds are sampled, closely around every resonance."""

from __future__ import annotations

import numpy as np

from vibopt.arrays import FloatArray, IntArray
from vibopt.forms import Form, Modulus
from vibopt.forms.rational import sampled
from vibopt.mechanics.combine import combined
from vibopt.mechanics.harmonic import transfer
from vibopt.mechanics.model import INERTIA, STIFFNESS, Model
from vibopt.mechanics.modes import undamped
from vibopt.signals import Band, Drive

SPEEDS = 70
MANY_SPEEDS = 1500
LARGE = 8
"""Free coordinates from which on the speeds are the same for every design."""
_NEAR = np.concatenate([[0.0], np.geomspace(1e-3, 0.6, 13)])
_CLOSER = np.linspace(0.0, 1.0, 11)
_CHUNK = 200_000
_PEAKS = 2
"""Peaks of each design that are looked at more closely: of an absorber two are nearly equal."""


def over(model: Model, form: Form, x: FloatArray, least_wanted: bool) -> FloatArray:
    """Worst value of a form at designs x (n, n_vars), shape (n,)."""
    asked = form.harmonic
    if asked is None or asked.rigid_link:
        return form.values(model, x, least_wanted=least_wanted)
    parts = np.array([_drive(model, asked, drive, x, least_wanted) for drive in asked.drives])
    total: FloatArray = np.sqrt((parts**2).sum(axis=0)) if asked.combine == "rss" else parts.sum(axis=0)
    return total


def _drive(model: Model, form: Modulus, drive: Drive, x: FloatArray, least_wanted: bool) -> FloatArray:
    """Worst over sampled speeds of the response to one excitation, shape (n,)."""
    if model.n_free >= LARGE and len(drive.lines) == 1 and (x > 0.0).all():
        return _at_fixed(model, form, drive, x, least_wanted)
    p = model.values(x)
    share = _share(model, form, x)[:, None]
    speeds = np.sort(_speeds(model, drive, p), axis=1)
    sign = -1.0 if least_wanted else 1.0
    values = sign * _response(model, form, drive, p, speeds) / share
    best = values.max(axis=1)
    tops = _tops(values)
    for _ in range(_PEAKS):
        chosen = tops.argmax(axis=1)[:, None]
        near = _between(drive, speeds, chosen)
        for _ in range(2):
            closer = sign * _response(model, form, drive, p, near) / share
            best = np.maximum(best, closer.max(axis=1))
            near = _between(drive, near, closer.argmax(axis=1)[:, None])
        np.put_along_axis(tops, chosen, -np.inf, axis=1)
    found: FloatArray = sign * best
    return found


def _tops(values: FloatArray) -> FloatArray:
    """The local maxima along each row, all else minus infinity."""
    edge = np.full((len(values), 1), -np.inf)
    left, right = np.hstack([edge, values[:, :-1]]), np.hstack([values[:, 1:], edge])
    tops: FloatArray = np.where((values > left) & (values >= right), values, -np.inf)
    return tops


def _response(model: Model, form: Modulus, drive: Drive, p: FloatArray, speeds: FloatArray) -> FloatArray:
    """Combined amplitude at speeds (n, n_speeds) of designs with coefficients p (n, n_terms)."""
    orders = tuple(line.order for line in drive.lines)
    with np.errstate(all="ignore"):
        lines = [
            transfer(model, p[:, None, :], form.output, line.vector, line.order * speeds) * line.amplitude.at(speeds)
            for line in drive.lines
        ]
        return combined(lines, orders, form.combine)


def _between(drive: Drive, speeds: FloatArray, chosen: IntArray) -> FloatArray:
    """Speeds closer together about the chosen one of each design, in the same band, shape (n, 11)."""
    here = np.take_along_axis(speeds, chosen, axis=1)
    low = np.take_along_axis(speeds, np.maximum(chosen - 1, 0), axis=1)
    high = np.take_along_axis(speeds, np.minimum(chosen + 1, speeds.shape[1] - 1), axis=1)
    for band in drive.bands:
        inside = (here >= band.low) & (here <= band.high)
        low, high = (
            np.where(inside, np.maximum(low, band.low), low),
            np.where(inside, np.minimum(high, band.high), high),
        )
    closer: FloatArray = np.sort(np.concatenate([low + (high - low) * _CLOSER, here], axis=1), axis=1)
    return closer


def _at_fixed(model: Model, form: Modulus, drive: Drive, x: FloatArray, least_wanted: bool) -> FloatArray:
    """As `_drive`, at the same many speeds for every design: ratios of polynomials in the variables."""
    speeds = np.concatenate([_spread(band) for band in drive.bands])
    line = sampled(model, form.output, drive.lines[0], speeds, np.median(x, axis=0))
    best = []
    for part in np.array_split(x, max(1, len(x) * len(speeds) // _CHUNK)):
        with np.errstate(all="ignore"):
            top, bottom = line.at(part)
            values = np.abs(top / bottom)
        best.append(values.min(axis=1) if least_wanted else values.max(axis=1))
    found: FloatArray = np.concatenate(best) / _share(model, form, x)
    return found


def _spread(band: Band) -> FloatArray:
    if band.is_point:
        return np.array([band.low])
    return np.geomspace(max(band.low, 1e-3 * band.high), band.high, MANY_SPEEDS)


def _share(model: Model, form: Modulus, x: FloatArray) -> FloatArray:
    """Number of mounts that share the value, shape (n,)."""
    if not form.output.shared_by:
        return np.ones(len(x))
    count = model.counts[form.output.shared_by]
    row = count.row(model.n_vars)
    share: FloatArray = count.scale * np.where(row == 0.0, 1.0, x**row).prod(axis=1)
    return share


def _speeds(model: Model, drive: Drive, p: FloatArray) -> FloatArray:
    """Speeds to look at, shape (n, n_speeds): evenly in each band, and around every resonance within."""
    even = [np.array([band.low]) if band.is_point else np.linspace(band.low, band.high, SPEEDS) for band in drive.bands]
    everywhere = np.broadcast_to(np.concatenate(even), (len(p), sum(map(len, even))))
    wide = [band for band in drive.bands if not band.is_point]
    if not wide:
        return everywhere
    orders = np.array([line.order for line in drive.lines])
    modes = (_modes(model, p)[:, :, None] / orders).reshape(len(p), -1)
    around = (modes[:, :, None] * np.concatenate([1.0 - _NEAR, 1.0 + _NEAR])).reshape(len(p), -1)
    inside = [np.clip(around, band.low, band.high) for band in wide]
    return np.concatenate([everywhere, *inside], axis=1)


def _modes(model: Model, p: FloatArray) -> FloatArray:
    """Undamped natural frequencies of many designs [rad/s], shape (n, n_modes)."""
    n = model.n_free
    mass, stiffness = (_matrices(model, p, kind) for kind in (INERTIA, STIFFNESS))
    return np.asarray(np.sqrt(stiffness[:, :, 0] / mass[:, :, 0])) if n == 1 else undamped(mass, stiffness)


def _matrices(model: Model, p: FloatArray, kind: int) -> FloatArray:
    """Matrix of one kind for many designs, shape (n, n_free, n_free)."""
    chosen = model.kinds == kind
    vectors = model.vectors[chosen, : model.n_free]
    matrices: FloatArray = np.einsum("kt,ti,tj->kij", p[:, chosen], vectors, vectors)
    return matrices
