"""Every speed at which a limit may be worst: local extremes and ends of its bands."""

from __future__ import annotations

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms import Form, Modulus
from vibopt.forms.drive_response import closed_form
from vibopt.mechanics.model import Model
from vibopt.mechanics.peaks import Extreme
from vibopt.signals import Drive


def local_extremes(model: Model, form: Form, x: FloatArray, *, least: bool) -> list[tuple[tuple[float, ...], float]]:
    """Speeds per excitation and value of every local extreme that could be the worst."""
    if not isinstance(form, Modulus):
        return [((), form.value(model, x))]
    per_drive = [_drive_extremes(model, form, drive, x, least) for drive in form.drives]
    found = per_drive[0] if len(per_drive) == 1 else []
    if len(per_drive) == 1:
        return [((one.speed,), one.value) for one in found]
    tops = [(min if least else max)(one, key=lambda e: e.value) for one in per_drive]
    values = np.array([one.value for one in tops])
    total = float(np.sqrt((values**2).sum())) if form.combine == "rss" else float(values.sum())
    return [(tuple(one.speed for one in tops), total)]


def _drive_extremes(model: Model, form: Modulus, drive: Drive, x: FloatArray, least: bool) -> list[Extreme]:
    closed = closed_form(model, form, drive, x)
    if closed is not None:
        return _once([one for band in drive.bands for one in closed.candidates(band)])
    from vibopt.forms.extremes import extremes_of
    from vibopt.forms.few import few_peaks

    few = None if least else few_peaks(model, form, drive, x, 0.9)
    if few is not None:
        return _once([one.at for one in few])
    return _once(extremes_of(model, form, drive, x, least_wanted=least, within=0.9))


def _once(found: list[Extreme]) -> list[Extreme]:
    """Each speed once."""
    unique: list[Extreme] = []
    for one in found:
        if not any(abs(one.speed - other.speed) <= 1e-9 * abs(one.speed) for other in unique):
            unique.append(one)
    return unique
