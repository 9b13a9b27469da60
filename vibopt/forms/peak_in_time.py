"""Greatest response under loads that change with time, at a design, with its exact slope.

Where the peak lies inside, moving it changes nothing to first order, and where it lies at a joint it stays there: the
slope is that of the motion at one time, by complex steps.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms.form import WITHOUT_END, Form, by_differences
from vibopt.records import dataclass
from vibopt.signals import Output, Segment

if TYPE_CHECKING:
    from vibopt.forms.reduce import Reach
    from vibopt.forms.tangent import Tangent
    from vibopt.mechanics.model import Model
    from vibopt.mechanics.panels import Numbers
    from vibopt.mechanics.ringing import Peak
    from vibopt.mechanics.transient import Reading, Transient

_STEP = 1e-30
_KEPT = 64
_APART = 0.1
"""Part of its time by which another time must differ from that of a peak to say more."""


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
    no_bounds = "is a peak in time: tangents bound it, not boxes"
    not_convex = "is a peak in time, which is not convex in stiffness and damping"
    rough = "is a peak in time: its instant is found by a search, and jumps from one peak to another"

    def value(self, model: Model, x: FloatArray) -> float:
        from vibopt.mechanics.harmonic import mount_count

        return abs(self.peak(model, x).value) / mount_count(model, self.output, x)

    def slope(self, model: Model, x: FloatArray) -> FloatArray:
        peak, p = self.peak(model, x), model.values(x)
        if not 0.0 < abs(peak.value) < np.inf or not np.isfinite(peak.time):
            return by_differences(lambda at: self.value(model, at), x)
        slope = np.zeros(model.n_vars)
        for i in range(model.n_vars):
            machine, reading = self.transient(model, p * (1.0 + 1j * _STEP * model.exponents[:, i]))
            slope[i] = machine.at(reading, peak).imag / _STEP / peak.value
        if self.output.shared_by:
            slope = slope - model.counts[self.output.shared_by].row(model.n_vars)
        return slope

    @property
    def in_time(self) -> PeakInTime:
        return self

    @property
    def tangents_of(self) -> tuple[float, ...]:
        return () if self.segments[-1].endless else (1.0,)

    def tangents(
        self, model: Model, x: FloatArray, reach: FloatArray, level: float = WITHOUT_END, times: Sequence[float] = ()
    ) -> Iterator[Tangent]:
        """At the time of the peak at x, at each of `times` [s], and early on the way up to a peak above `level`.

        Early, less can have changed.
        """
        from vibopt.mechanics.harmonic import mount_count

        peak = self.peak(model, x)
        if not np.isfinite(peak.value) or (self.output.shared_by and model.counts[self.output.shared_by].exponents):
            return
        machine, reading = self.transient(model, model.values(x))
        size = abs(peak.value)
        half = 0.5 * (size + level * mount_count(model, self.output, x))
        early = [machine.placed(machine.first_above(reading, half, peak))] if half < size else []
        others = [machine.placed(time) for time in times if abs(time - peak.time) > _APART * peak.time]
        for at in (*early, peak, *others):
            tangent = self._tangent(model, x, reach, at)
            if tangent is not None and np.isfinite(tangent.rest):
                yield tangent

    def _tangent(self, model: Model, x: FloatArray, reach: FloatArray, at: Peak) -> Tangent | None:
        """At one time; None where the motion follows too suddenly to have one."""
        from vibopt.forms.tangent import Tangent, bent
        from vibopt.mechanics.harmonic import mount_count
        from vibopt.mechanics.kernel_bounds import Element, nearby

        p, active = model.values(x), np.flatnonzero(model.exponents.any(axis=1))
        elements = [Element(int(model.kinds[i]), model.vectors[i], float(self.output.signs[i])) for i in active]
        near = nearby(*self.transient(model, p), elements, at)
        if near is None:
            return None
        slopes, exponents = np.zeros(len(active)), model.exponents[active]
        for k, i in enumerate(active):
            off = p.astype(complex)
            off[i] *= 1.0 + 1j * _STEP
            machine, reading = self.transient(model, off)
            slopes[k] = machine.at(reading, at).imag / _STEP

        def rest(reach: FloatArray) -> float:
            bends = bent(exponents, reach)
            return near.rest(p[active] * (np.abs(exponents) @ reach + bends)) + float(np.abs(slopes) @ bends)

        share = float(np.copysign(1.0, near.value)) / mount_count(model, self.output, x)
        sides = np.array([rest(reach * one) for one in np.eye(len(x))])
        return Tangent(near.value * share, slopes @ exponents * share, rest(reach) * abs(share), sides * abs(share))

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
        """The machine under its loads, and what is read, at coefficients p (n_terms,), real or complex."""
        known: dict[tuple[int, bytes, bytes], tuple[PeakInTime, Transient]] = vars(model).setdefault("in_time", {})
        key = id(self.segments), self.loads.tobytes(), p.tobytes()
        if key not in known:
            from vibopt.mechanics.transient import Transient

            if len(known) >= _KEPT:
                known.pop(next(iter(known)))
            machine = Transient(*matrices(model, p), model.n_free, self.loads, self.segments)
            known[key] = self, machine  # the form stays, and so the number of its segments
        return known[key][1], reading(model, self.output, p)


def matrices(model: Model, p: Numbers) -> tuple[Numbers, Numbers, Numbers]:
    """Mass, damping and stiffness at coefficients p (n_terms,), (n_coords, n_coords) each."""
    from vibopt.mechanics.model import DAMPING, INERTIA, STIFFNESS

    def matrix(kind: int) -> Numbers:
        vectors = model.vectors[model.kinds == kind]
        return np.asarray((vectors.T * p[model.kinds == kind]) @ vectors)

    return matrix(INERTIA), matrix(DAMPING), matrix(STIFFNESS)


def reading(model: Model, output: Output, p: Numbers) -> Reading:
    """What is read at coefficients p (n_terms,).

    A force follows position through stiffness, velocity through damping and acceleration through inertance.
    """
    from vibopt.mechanics.model import DAMPING, INERTIA, STIFFNESS
    from vibopt.mechanics.transient import Reading

    rows = [(output.signs * p * (model.kinds == kind)) @ model.vectors for kind in (STIFFNESS, DAMPING, INERTIA)]
    return Reading(output.row + rows[0], rows[1], rows[2], output.power)
