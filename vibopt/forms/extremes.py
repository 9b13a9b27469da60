"""Local extremes of a form over its speeds, with their exact slopes in log x.

A peak's slope with the design is the slope at its own speed (the speed's own motion drops out), so
a moving peak costs no more than a fixed one.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.forms.bends import Curved, curved
from vibopt.forms.drive_response import DriveResponse, closed_form, modes_for, rigid_form
from vibopt.forms.few import few_peaks
from vibopt.forms.form import Local, by_differences, log_of
from vibopt.forms.greatest_values import highest
from vibopt.mechanics.combine import Extreme
from vibopt.mechanics.harmonic import dynamic_stiffness, impedances
from vibopt.mechanics.model import Model
from vibopt.mechanics.modes import frequency_slopes
from vibopt.mechanics.peaks import least, peaks
from vibopt.signals import Drive, Line, Output

if TYPE_CHECKING:
    from vibopt.forms.modulus import Modulus

_NEAR = 1e-6
_MOST = 24
_ENOUGH = 200
_NUDGE = 1e-14j


def of_few(model: Model, form: Modulus, x: FloatArray, within: float) -> list[Local] | None:
    """The peaks by polynomials, with their bends, where those can be trusted."""
    drive = form.drives[0]
    found = few_peaks(model, form, drive, x, within)
    if found is None:
        return None
    return [Local(log_of(peak.at.value), peak.slope, (peak.at.speed,), peak.bend) for peak in found]


def of_drive(
    model: Model, form: Modulus, drive: Drive, x: FloatArray, least_wanted: bool, within: float
) -> list[Local]:
    """Local extremes of the response to one excitation."""
    found = extremes_of(model, form, drive, x, least_wanted=least_wanted, within=within)
    return _locals(model, form, drive, x, _once(found, 1e-7)[:_MOST], least_wanted)


def _locals(
    model: Model, form: Modulus, drive: Drive, x: FloatArray, found: list[Extreme], least_wanted: bool
) -> list[Local]:
    """Extremes with their slopes, and the bends of those that have one in closed form."""
    known: dict[float, Curved | None] = {}
    if not form.rigid_link:
        speeds = [one.speed for one in found if 0.0 < one.value < np.inf and one.speed > 0.0]
        known = dict(zip(speeds, curved(model, form.output, drive, x, np.array(speeds), form.combine), strict=True))
    made = []
    for at in found:
        one, bend = known.get(at.speed), None
        if one is None:
            slope = slope_at(model, form, drive, x, at)
        else:
            slope, bend = one.at_extreme(-1.0 if least_wanted else 1.0)
            if form.output.shared_by:
                slope = slope - model.counts[form.output.shared_by].row(model.n_vars)
        made.append(Local(log_of(at.value), slope, (at.speed,), bend))
    return made


def extremes_of(
    model: Model, form: Modulus, drive: Drive, x: FloatArray, *, least_wanted: bool, within: float
) -> list[Extreme]:
    """Local extremes of the response to one excitation over its bands, the worst first."""
    closed = closed_form(model, form, drive, x)
    if closed is not None:
        found = [candidate for band in drive.bands for candidate in closed.candidates(band)]
        values = [one.value for one in found]
        if least_wanted:
            return sorted((o for o in found if o.value * within <= min(values)), key=lambda o: o.value)
        return sorted((o for o in found if o.value >= within * max(values)), key=lambda o: -o.value)
    through = None if least_wanted else highest(model, form, drive, x, within)
    if through is not None:
        return through
    modal, singular, breaks = modes_for(model, form, drive, x)
    response = DriveResponse(model, form, drive, x, modal)
    if least_wanted:
        return _direct(response, [least(response, drive.bands, singular, breaks)])
    found = peaks(response, drive.bands, singular, breaks, within=within)[:_ENOUGH]
    real = [one for one, top in zip(found, _is_peak(response, drive, found), strict=True) if top]
    return _direct(response, real or found[:1])  # of next to nothing all tops are rounding


def _direct(response: DriveResponse, found: list[Extreme]) -> list[Extreme]:
    """The extremes that count, with values solved directly where they were found through modes."""
    if response.modal is None or not found:
        return found
    kept = found[: 2 * _MOST]
    values = replace(response, modal=None)(np.array([one.speed for one in kept])).tolist()
    return [
        replace(one, value=value) if np.isfinite(one.value) else one for one, value in zip(kept, values, strict=True)
    ]


def _is_peak(response: DriveResponse, drive: Drive, found: list[Extreme]) -> list[bool]:
    """Which extremes are local maxima, and not points on a flank where a search interval ended."""
    speeds = np.array([one.speed for one in found])
    around = speeds[:, None] * np.array([1.0 - _NEAR, 1.0 + _NEAR])
    inside = np.array([[any(band.holds(s) for band in drive.bands) for s in pair] for pair in around])
    beside = np.where(inside & ~np.isnan(values := response(around)), values, -np.inf)
    return [not beside[i].max() > one.value * (1.0 + 1e-10) for i, one in enumerate(found)]


def slope_at(model: Model, form: Modulus, drive: Drive, x: FloatArray, at: Extreme) -> FloatArray:
    """Slope of the log of the response to one drive at one speed, shape (n_vars,).

    At an undamped resonance, where the response is infinite, it is the slope of log of the
    natural frequency there.
    """
    if not np.isfinite(at.value):
        return _slope_of_nearest_mode(model, drive, x, at.speed)
    if at.value == 0.0:
        return np.zeros(model.n_vars)
    if form.combine == "peak" and len(drive.lines) > 1:
        return by_differences(lambda y: float(DriveResponse(model, form, drive, y)(np.array([at.speed]))[0]), x)
    slope: FloatArray = sampled_slopes(model, form, drive, x, np.array([at.speed]))[1][0]
    return slope


def sampled_slopes(
    model: Model, form: Modulus, drive: Drive, x: FloatArray, speeds: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Log of the response to one drive at speeds (n,), and its slope in log x, shape (n, n_vars).

    Several harmonics are added as sums or roots of sums of squares.
    """
    log, slope = _combined_slope(model, form.output, drive, x, speeds, form.combine)
    if form.rigid_link:
        rigid, output = rigid_form(model, form)
        lines = tuple(replace(line, vector=line.vector @ rigid.basis) for line in drive.lines)
        other, other_slope = _combined_slope(rigid, output, replace(drive, lines=lines), x, speeds, form.combine)
        log, slope = other - log, other_slope - slope
    if form.output.shared_by:
        count = model.counts[form.output.shared_by]
        log = log - np.log(count.scale)
        for index, power in count.exponents.items():
            log = log - power * np.log(x[index])
            slope[:, index] -= power
    return log, slope


def _combined_slope(
    model: Model, output: Output, drive: Drive, x: FloatArray, speeds: FloatArray, combine: str
) -> tuple[FloatArray, FloatArray]:
    """log sum |h| (or log root of sum of squares) over the lines of a drive, and its slope."""
    sizes, slopes = [], []
    for line in drive.lines:
        h, dh = line_slope(model, output, line, x, speeds)
        size = np.abs(h)
        sizes.append(size)
        with np.errstate(divide="ignore", invalid="ignore"):
            slopes.append(np.nan_to_num((np.conj(h)[:, None] * dh).real / (size**2)[:, None]))
    size = np.array(sizes)
    power = 2 if combine == "rss" else 1
    weight = size**power
    total = weight.sum(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.einsum("ls,lsi->si", weight, np.array(slopes)) / total[:, None]
        return np.log(total) / power, np.nan_to_num(slope)


def line_slope(
    model: Model, output: Output, line: Line, x: FloatArray, speeds: FloatArray
) -> tuple[ComplexArray, ComplexArray]:
    """One harmonic of a response at speeds (n,), and its slope in log x, shape (n, n_vars)."""
    n = model.n_free
    omega = line.order * speeds
    z = impedances(model, model.values(x), omega)
    both = dynamic_stiffness(model, z)
    stiff, to_base = both[..., :n], both[..., n:]
    size = np.sqrt(np.abs(np.diagonal(stiff, axis1=-2, axis2=-1)))
    size = np.where(size == 0.0, 1.0, size)
    scaled = stiff / (size[:, :, None] * size[:, None, :])
    load = line.vector[:n] - to_base @ line.vector[n:]
    row = output.row + (output.signs * z) @ model.vectors
    right = np.stack([load / size, row[:, :n] / size], axis=-1)
    try:
        solved = np.linalg.solve(scaled, right) / size[:, :, None]
    except np.linalg.LinAlgError:
        solved = np.linalg.solve(scaled + _NUDGE * np.eye(n), right) / size[:, :, None]
    base = np.broadcast_to(line.vector[n:], (len(speeds), len(line.vector) - n))
    u = np.concatenate([solved[..., 0], base], axis=1)
    change = (output.signs - solved[..., 1] @ model.vectors[:, :n].T) * (u @ model.vectors.T) * z
    scale = (1j * omega) ** output.power * line.amplitude.at(speeds)
    return (row * u).sum(axis=1) * scale, (change @ model.exponents) * scale[:, None]


def _slope_of_nearest_mode(model: Model, drive: Drive, x: FloatArray, speed: float) -> FloatArray:
    omega, slopes = frequency_slopes(model, x)
    asked = np.array([line.order * speed for line in drive.lines])
    far = np.log(np.maximum(omega, 1e-300))[:, None] - np.log(np.maximum(asked, 1e-300))
    nearest = np.abs(far).min(axis=1).argmin()
    slope: FloatArray = slopes[nearest]
    return slope


def candidates_of(model: Model, form: Modulus, drive: Drive, x: FloatArray, least_wanted: bool) -> list[Extreme]:
    """Every local extreme of the response to one excitation that could be the worst, each speed once."""
    closed = closed_form(model, form, drive, x)
    if closed is not None:
        return _once([candidate for band in drive.bands for candidate in closed.candidates(band)])
    few = None if least_wanted else few_peaks(model, form, drive, x, 0.9)
    if few is not None:
        return _once([peak.at for peak in few])
    return _once(extremes_of(model, form, drive, x, least_wanted=least_wanted, within=0.9))


def _once(found: list[Extreme], apart: float = 1e-9) -> list[Extreme]:
    """Each speed once."""
    unique: list[Extreme] = []
    for one in found:
        if all(abs(one.speed - other.speed) > apart * abs(one.speed) for other in unique):
            unique.append(one)
    return unique
