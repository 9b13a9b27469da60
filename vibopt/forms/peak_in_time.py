"""Greatest response under loads that change with time, at a design, with its exact slope.

Where the peak lies inside, moving it changes nothing to first order, and where it lies at a joint it stays there: the
slope is that of the motion at one time, by complex steps.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from typing import TYPE_CHECKING

import numpy as np

from vibopt.arrays import FloatArray, IntArray
from vibopt.forms.form import WITHOUT_END, Form, Local, by_differences, kept, log_of
from vibopt.records import dataclass
from vibopt.signals import Output, Segment

if TYPE_CHECKING:
    from vibopt.forms.floors import Floors
    from vibopt.forms.per_mass import PerMass
    from vibopt.forms.reduce import Reach
    from vibopt.forms.tangent import Tangent
    from vibopt.mechanics.model import Model
    from vibopt.mechanics.panels import Numbers
    from vibopt.mechanics.peaks_in_time import Peak
    from vibopt.mechanics.readout import Reading
    from vibopt.mechanics.sliding import Sliding
    from vibopt.mechanics.transient import Transient

_STEP = 1e-30
_KEPT, _STATES, _ENTRIES = 16, 50_000, 40_000
"""Rows of machines that are kept; states of loads, and entries of mass matrices, at once and kept."""
_ALONE, _JOINT, _RADIAN, _FOLLOWED = 0.06, 1e-3, 0.0125, 5.0
"""Work of one machine, of a segment, of a radian that it turns beyond the first round, and of a load that varies for
ever [nominal ms]."""
_APART = 0.1
"""Part of its time by which another time must differ from that of a peak to say more."""
_NOTHING, _BEHIND, _HIGH = 1e-9, 8.0, 0.7
"""Part of the fastest rate that is none; radians of the slowest motion behind a load in which tops are looked for, and
part of the greatest that they are at least."""


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
    no_bounds = "is a peak in time: tangents alone bound it"
    not_convex = "is a peak in time, which is not convex in stiffness and damping"
    rough = "is a peak in time: its instant is found by a search, and jumps from one peak to another"

    def value(self, model: Model, x: FloatArray) -> float:
        return float(self.values(model, x[None])[0])

    def values(self, model: Model, x: FloatArray, *, least_wanted: bool = False) -> FloatArray:
        from vibopt.mechanics.harmonic import mount_count

        pairs = zip(self.peaks(model, x), x, strict=True)
        return np.array([abs(peak.value) / mount_count(model, self.output, one) for peak, one in pairs])

    def ahead(self, model: Model, x: FloatArray) -> None:
        with suppress(np.linalg.LinAlgError):  # told where it is asked for alone
            self.values(model, x)

    def slope(self, model: Model, x: FloatArray) -> FloatArray:
        peak, p = self.peak(model, x), model.values(x)
        if not 0.0 < abs(peak.value) < np.inf or not np.isfinite(peak.time):
            return by_differences(lambda at: self.value(model, at), x)
        return self._slope_of(model, p, peak)

    def _slope_of(self, model: Model, p: FloatArray, top: Peak) -> FloatArray:
        """Of the log of a top in time, at coefficients p (n_terms,)."""
        slope: FloatArray = self._changes(model, p[None], model.exponents.T, top.within, top.part)[0] / top.value
        if self.output.shared_by:
            slope = slope - model.counts[self.output.shared_by].row(model.n_vars)
        return slope

    def extremes(self, model: Model, x: FloatArray, *, least_wanted: bool, within: float = 0.5) -> list[Local]:
        """The greatest and, where it is to be small, other tops in time: what is made less moves on to another."""
        peak = self.peak(model, x)
        if least_wanted or not 0.0 < abs(peak.value) < np.inf or not np.isfinite(peak.time):
            return Form.extremes(self, model, x, least_wanted=least_wanted)
        from vibopt.mechanics.harmonic import mount_count
        from vibopt.mechanics.modes import poles
        from vibopt.mechanics.tops import other_tops

        p, count, size = model.values(x), mount_count(model, self.output, x), np.abs(poles(model, model.values(x)))
        slow = float(size[size > _NOTHING * size.max(initial=0.0)].min(initial=np.inf))
        others = other_tops(*self.transient(model, p), peak, _BEHIND / slow, max(within, _HIGH))
        return [
            Local(log_of(abs(top.value) / count), self._slope_of(model, p, top), (top.time,)) for top in [peak, *others]
        ]

    def _changes(
        self, model: Model, p: FloatArray, ways: FloatArray, within: int | IntArray, part: float | FloatArray
    ) -> FloatArray:
        """How the reading at a time of each machine p (n, n_terms) changes along ways of log p (k, n_terms), (n, k)."""
        moved = (p[:, None] * (1.0 + 1j * _STEP * ways)).reshape(-1, p.shape[1])
        machine, reading = self.transient(model, moved)
        places = (np.repeat(np.broadcast_to(one, len(p)), len(ways)) for one in (within, part))
        return np.asarray(machine.at(reading, *places).imag / _STEP).reshape(len(p), -1)

    @property
    def in_time(self) -> PeakInTime | None:
        return self

    @property
    def tangents_of(self) -> tuple[float, ...]:
        return (1.0,)  # a peak is no less than what it is at any time

    def tangents(
        self, model: Model, x: FloatArray, reach: FloatArray, level: float = WITHOUT_END, times: Sequence[float] = ()
    ) -> list[list[Tangent]]:
        """At the time of the peak at x, at each of `times` [s], and early on the way up to a peak above `level`.

        Early, less can have changed.
        """
        from vibopt.mechanics.harmonic import mount_count

        peaks = self.peaks(model, x)
        found: list[list[Tangent]] = [[] for _ in x]
        known = [i for i, peak in enumerate(peaks) if np.isfinite([peak.value, peak.time]).all()]
        if not known or (self.output.shared_by and model.counts[self.output.shared_by].exponents):
            return found
        if not model.exponents.any():  # what is chosen moves other bodies alone
            from vibopt.forms.tangent import flat

            values = self.values(model, x).tolist()
            return [[flat(values[i], x.shape[1])] if i in known else [] for i in range(len(x))]
        machine, reading = self.transient(model, model.values(x[known]))
        tops = np.array([peaks[i].time for i in known])
        sizes = np.array([abs(peaks[i].value) for i in known])
        half = 0.5 * (sizes + level * mount_count(model, self.output, x[0]))
        early = machine.times_above(reading, half, tops)
        other = [(known[i], early[i]) for i in np.flatnonzero(half < sizes)]
        other += [(i, time) for i in known for time in times if abs(time - peaks[i].time) > _APART * peaks[i].time]
        within, part = machine.placed(np.array([time for _, time in other]))
        which = np.array([*known, *(i for i, _ in other)])
        within = np.concatenate([[peaks[i].within for i in known], within])
        part = np.concatenate([[peaks[i].part for i in known], part])
        tangents = self._tangents(model, x[which], reach[which], within, part)
        for i, tangent in zip(which, tangents, strict=bool(tangents)):  # of none there are none
            found[i].append(tangent)
        return found

    def majorised(self, model: Model) -> bool:
        from vibopt.forms.majorant import MOST
        from vibopt.forms.tangent import Opened
        from vibopt.mechanics.kernel_bounds import boundable

        last, opened = self.segments[-1], Opened(model, self.output)
        if (
            not 0 < len(opened.active) <= MOST
            or (last.endless and (last.rates @ last.start).any())
            or (self.output.shared_by and model.counts[self.output.shared_by].exponents)
        ):
            return False
        return boundable(*self.transient(model, model.values(np.ones(model.n_vars))), opened.elements)

    def majorants(self, model: Model, x: FloatArray, reach: FloatArray) -> list[list[Tangent]]:
        from vibopt.forms.majorant import majorants

        return majorants(self, model, x, reach)

    def per_mass(self, model: Model) -> PerMass | None:
        """How it goes by a lone mass that is open; of what is let go it is not asked."""
        from vibopt.forms.per_mass import per_mass

        return None if self.segments[0].released is not None else per_mass(model, self.output, self.loads)

    def by_size(self, model: Model, along: FloatArray) -> float | None:
        from vibopt.forms.per_mass import by_size

        if self.segments[0].released is not None or (
            self.output.shared_by and model.counts[self.output.shared_by].exponents
        ):
            return None
        powers = by_size(self.output, self.loads, model.n_free)
        return None if powers is None else powers[1]

    def greatest_at(self, model: Model, x: FloatArray) -> float:
        return self.peak(model, x).time

    def floors(self, model: Model) -> Floors | None:
        from vibopt.forms.floors import floors

        return floors(self, model)

    def _tangents(
        self, model: Model, x: FloatArray, reach: FloatArray, within: IntArray, part: FloatArray
    ) -> list[Tangent]:
        """At one time of each design; none where the motion follows too suddenly to have one."""
        from vibopt.forms.tangent import Opened
        from vibopt.mechanics.harmonic import mount_count
        from vibopt.mechanics.kernel_bounds import nearby

        p, opened = model.values(x), Opened(model, self.output)
        near = nearby(*self.transient(model, p), opened.elements, within, part)
        if near is None:
            return []

        def slopes(of: IntArray) -> FloatArray:
            return self._changes(model, p[of], opened.ways, within[of], part[of])

        return opened.tangents(near, p, slopes, reach, 1.0 / mount_count(model, self.output, x[0]))

    def room(self, model: Model, x: FloatArray, value: float, other: float, rounding: float) -> float:
        """Rounding of all motions together, of which a reading may be what is left."""
        from vibopt.mechanics.harmonic import mount_count

        machine, read = self.transient(model, model.values(x))
        parts = rounding * machine.reached(read) / mount_count(model, self.output, x)
        return max(Form.room(self, model, x, value, other, rounding), parts)

    def reach(self, model: Model) -> Reach | None:
        from vibopt.forms.reduce import driven

        if self.segments[0].released is not None:  # displacements are of bodies, not of what forces reach
            return None
        return driven(model, self.output, list(self.loads.T))

    def cost(self, model: Model) -> float:
        last = self.segments[-1]
        if last.endless and (last.rates @ last.start).any():
            return _FOLLOWED
        known: dict[int, tuple[PeakInTime, float]] = vars(model).setdefault("turns", {})
        if id(self.segments) not in known:
            fastest = (float(np.abs(segment.rates).max(initial=0.0)) for segment in self.segments)
            known[id(self.segments)] = self, sum(max(one - 2.0 * np.pi, 0.0) for one in fastest)
        return _ALONE + _JOINT * len(self.segments) + _RADIAN * known[id(self.segments)][1]

    def never_more(self, model: Model, x: FloatArray) -> float:
        """What it is never above, under a load that ends; where nothing is damped it comes near."""
        from vibopt.mechanics.harmonic import mount_count

        machine, read = self.transient(model, model.values(x[None]))
        most = max(abs(self.peak(model, x).value), float(machine.behind.most(read)[0]))
        return most / mount_count(model, self.output, x)

    def peak(self, model: Model, x: FloatArray) -> Peak:
        """The greatest response, of all mounts together where shared."""
        return self.peaks(model, x[None])[0]

    def peaks(self, model: Model, x: FloatArray) -> list[Peak]:
        """The same at designs x (n, n_vars), side by side."""
        return kept(model, self, x, lambda some: self._measured(model, some))

    def _measured(self, model: Model, x: FloatArray) -> list[Peak]:
        loads = sum(segment.start.shape[-1] for segment in self.segments)
        most = max(1, min(_STATES // loads, _ENTRIES // model.n_coords**2))
        found = []
        for k in range(0, len(x), most):
            machine, read = self.transient(model, model.values(x[k : k + most]))
            found += machine.peaks(read).each()
        return found

    def motion(self, model: Model, x: FloatArray) -> tuple[Transient | Sliding, Reading]:
        """The machine under its loads, and what is read, at a design (n_vars,)."""
        return self.transient(model, model.values(x))

    def transient(self, model: Model, p: Numbers) -> tuple[Transient, Reading]:
        """The machine under its loads, and what is read, at coefficients p (..., n_terms), real or complex."""
        known: dict[tuple[int, bytes, bytes, int], tuple[PeakInTime, Transient]] = vars(model).setdefault("in_time", {})
        key = id(self.segments), self.loads.tobytes(), p.tobytes(), p.ndim
        if key not in known:
            from vibopt.mechanics.transient import Transient

            while known and (len(known) >= _KEPT or sum(one.mass.size for _, one in known.values()) > _ENTRIES):
                known.pop(next(iter(known)))
            machine = Transient(*matrices(model, p), model.n_free, self.loads, self.segments)
            known[key] = self, machine  # the form stays, and so the number of its segments
        return known[key][1], reading(model, self.output, p)


def matrices(model: Model, p: Numbers) -> tuple[Numbers, Numbers, Numbers]:
    """Mass, damping and stiffness at coefficients p (..., n_terms), (..., n_coords, n_coords) each."""
    from vibopt.mechanics.model import DAMPING, INERTIA, STIFFNESS

    def matrix(kind: int) -> Numbers:
        vectors = model.vectors[model.kinds == kind]
        return np.asarray((vectors.T * p[..., None, model.kinds == kind]) @ vectors)

    return matrix(INERTIA), matrix(DAMPING), matrix(STIFFNESS)


def reading(model: Model, output: Output, p: Numbers) -> Reading:
    """What is read at coefficients p (..., n_terms).

    A force follows position through stiffness, velocity through damping and acceleration through inertance.
    """
    from vibopt.mechanics.model import DAMPING, INERTIA, STIFFNESS
    from vibopt.mechanics.readout import Reading

    rows = [(output.signs * p * (model.kinds == kind)) @ model.vectors for kind in (STIFFNESS, DAMPING, INERTIA)]
    return Reading(output.row + rows[0], rows[1], rows[2], output.power)
