"""Greatest response under loads that change with time, at a design, with its exact slope.

Where the peak lies inside, moving it changes nothing to first order, and where it lies at a joint it stays there: the
slope is that of the motion at one time, by complex steps.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms.form import Form, by_differences
from vibopt.records import dataclass
from vibopt.signals import Output, Segment

if TYPE_CHECKING:
    from vibopt.forms.reduce import Reach
    from vibopt.mechanics.model import Model
    from vibopt.mechanics.panels import Numbers
    from vibopt.mechanics.transient import Peak, Reading, Transient

_STEP = 1e-30
_KEPT = 64


@dataclass(frozen=True, slots=True)
class PeakInTime(Form):
    """Greatest size of a response from the beginning of some signals on, for ever; the machine is at rest before.

    loads
        (n_coords, n_signals): force on free coordinates [N], acceleration of bases [m/s^2], for a signal of one.
    segments
        The signals, one segment behind the other.
    """

    output: Output
    loads: FloatArray
    segments: tuple[Segment, ...]

    def value(self, model: Model, x: FloatArray) -> float:
        from vibopt.mechanics.harmonic import mount_count

        return abs(self.peak(model, x).value) / mount_count(model, self.output, x)

    def slope(self, model: Model, x: FloatArray) -> FloatArray:
        peak, p = self.peak(model, x), model.values(x)
        if not 0.0 < abs(peak.value) < np.inf:
            return by_differences(lambda at: self.value(model, at), x)
        slope = np.zeros(model.n_vars)
        for i in range(model.n_vars):
            machine, reading = self.transient(model, p * (1.0 + 1j * _STEP * model.exponents[:, i]))
            slope[i] = machine.at(reading, peak).imag / _STEP / peak.value
        if self.output.shared_by:
            slope = slope - model.counts[self.output.shared_by].row(model.n_vars)
        return slope

    def reach(self, model: Model) -> Reach:
        from vibopt.forms.reduce import driven

        return driven(model, self.output, list(self.loads.T))

    def cost(self, model: Model) -> float:
        return 3.0 + 0.02 * len(self.segments)

    def peak(self, model: Model, x: FloatArray) -> Peak:
        """The greatest response, of all mounts together where shared; the last ones are kept."""
        known: dict[tuple[int, bytes], tuple[PeakInTime, Peak]] = vars(model).setdefault("peaks_in_time", {})
        key = id(self), np.asarray(x, dtype=float).tobytes()
        if key not in known:
            if len(known) >= _KEPT:
                known.pop(next(iter(known)))
            machine, reading = self.transient(model, model.values(x))
            known[key] = self, machine.peak(reading)  # the form stays, and so its number
        return known[key][1]

    def transient(self, model: Model, p: Numbers) -> tuple[Transient, Reading]:
        """The machine under its loads, and what is read, at coefficients p (n_terms,), real or complex.

        A force follows position through stiffness, velocity through damping and acceleration through inertance.
        """
        from vibopt.mechanics.model import DAMPING, INERTIA, STIFFNESS
        from vibopt.mechanics.transient import Reading, Transient

        def matrix(kind: int) -> Numbers:
            vectors = model.vectors[model.kinds == kind]
            return np.asarray((vectors.T * p[model.kinds == kind]) @ vectors)

        mass, damping, stiffness = (matrix(kind) for kind in (INERTIA, DAMPING, STIFFNESS))
        rows = [
            (self.output.signs * p * (model.kinds == kind)) @ model.vectors for kind in (STIFFNESS, DAMPING, INERTIA)
        ]
        machine = Transient(mass, damping, stiffness, model.n_free, self.loads, self.segments)
        return machine, Reading(self.output.row + rows[0], rows[1], rows[2], self.output.power)
