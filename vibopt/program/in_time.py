"""Greatest response under loads that change with time, at a design, with its exact slope.

Where the peak lies inside, moving it changes nothing to first order, and where it lies at a joint it stays there: the
slope is that of the motion at one time, by complex steps.
"""

from __future__ import annotations

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms import PeakInTime
from vibopt.mechanics.model import DAMPING, INERTIA, STIFFNESS, Model
from vibopt.mechanics.panels import Numbers
from vibopt.mechanics.transient import Peak, Reading, Transient
from vibopt.program.mean_square import share_of
from vibopt.signals import Output

_STEP = 1e-30
_KEPT = 64


def transient_of(model: Model, form: PeakInTime, p: Numbers) -> tuple[Transient, Reading]:
    """The machine under its loads, and what is read, at coefficients p (n_terms,), real or complex."""
    mass, damping, stiffness = (_matrix(model, kind, p) for kind in (INERTIA, DAMPING, STIFFNESS))
    machine = Transient(mass, damping, stiffness, model.n_free, form.loads, form.segments)
    return machine, _reading(model, form.output, p)


def peak_in_time(model: Model, form: PeakInTime, x: FloatArray) -> Peak:
    """The greatest response at design x (n_vars,), of all mounts together where shared; the last ones are kept."""
    known: dict[tuple[int, bytes], tuple[PeakInTime, Peak]] = vars(model).setdefault("peaks_in_time", {})
    key = id(form), np.asarray(x, dtype=float).tobytes()
    if key not in known:
        if len(known) >= _KEPT:
            known.pop(next(iter(known)))
        machine, reading = transient_of(model, form, model.values(x))
        known[key] = form, machine.peak(reading)  # the form stays, and so its number
    return known[key][1]


def peak_value(model: Model, form: PeakInTime, x: FloatArray) -> float:
    """Size of the greatest response at design x (n_vars,)."""
    return abs(peak_in_time(model, form, x).value) / share_of(model, form.output, x)


def peak_slope(model: Model, form: PeakInTime, x: FloatArray) -> FloatArray | None:
    """Slope of its log in log x, shape (n_vars,); None where it is infinite or nothing."""
    peak, p = peak_in_time(model, form, x), model.values(x)
    if not 0.0 < abs(peak.value) < np.inf:
        return None
    slope = np.zeros(model.n_vars)
    for i in range(model.n_vars):
        machine, reading = transient_of(model, form, p * (1.0 + 1j * _STEP * model.exponents[:, i]))
        slope[i] = machine.at(reading, peak).imag / _STEP / peak.value
    if form.output.shared_by:
        slope = slope - model.counts[form.output.shared_by].row(model.n_vars)
    return slope


def _matrix(model: Model, kind: int, p: Numbers) -> Numbers:
    chosen = model.kinds == kind
    vectors = model.vectors[chosen]
    return np.asarray((vectors.T * p[chosen]) @ vectors)


def _reading(model: Model, output: Output, p: Numbers) -> Reading:
    """A force follows position through stiffness, velocity through damping and acceleration through inertance."""
    weight = output.signs * p
    rows = [(weight * (model.kinds == kind)) @ model.vectors for kind in (STIFFNESS, DAMPING, INERTIA)]
    return Reading(output.row + rows[0], rows[1], rows[2], output.power)


__all__ = ["peak_in_time", "peak_slope", "peak_value", "transient_of"]
