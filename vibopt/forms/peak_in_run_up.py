"""Greatest response in a run-up or run-down, at a design, with its exact slope.

Moving the peak changes nothing to first order: the slope is that of the envelope at one time, by Cauchy's integral
around the design, for the answer is analytic in the coefficients and its modulus is not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray, IntArray
from vibopt.forms.form import ROOTS, WITHOUT_END, Form, by_differences, kept
from vibopt.forms.peak_in_time import matrices, reading
from vibopt.mechanics.motor import NO_SWEEP, Motor
from vibopt.mechanics.readout import Reading
from vibopt.records import dataclass
from vibopt.signals import AT_REST, Output, Sweep, Sweeps

if TYPE_CHECKING:
    from vibopt.forms.reduce import Reach
    from vibopt.forms.tangent import Tangent
    from vibopt.mechanics.model import Model
    from vibopt.mechanics.panels import Numbers
    from vibopt.mechanics.peaks_in_time import Peak
    from vibopt.mechanics.spinning_up import SpinUp
    from vibopt.mechanics.sweep_response import RunUp

BY_TORQUE = 3e-5
"""Part of itself to which the greatest is known where the speed follows from torque."""
_STEP, _WIDE = 1e-5, 1e-4
"""Parts of a rate, and of any value where whirls hang on the spin, for differences."""
_SETTLED, _APART = 50.0, 0.1
"""Times that the slowest mode fades by e until nothing is left; part by which times differ that are told apart."""
_HALF, _AROUND = 4, 0.05
"""Points of half a circle around a design, and the greatest change of a phase on it [rad]."""


@dataclass(frozen=True, slots=True)
class PeakInRunUp(Form):
    """Greatest size of a response while the speed of a force changes, and behind, over every angle at which it begins.

    load
        (n_coords,): what a force of one acts on.
    sweep
        How force and speed change: a given way, at a rate to be chosen, or by the torque of a motor, which depends on
        the design.
    spun
        Whether it is of a rotor whose whirl hangs on its spin.
    """

    output: Output
    load: FloatArray
    sweep: Sweep | Sweeps | Motor
    spun: bool = False
    tangents_up_to = 2
    no_bounds = "is a peak in a run-up: tangents alone bound it, of a run-up that is the same at all designs"
    not_convex = "is a peak in a run-up, which is not convex in stiffness and damping"
    rough = "is a peak in a run-up: its instant is found by a search, and jumps from one resonance to another"

    @property
    def known_to(self) -> float:
        return BY_TORQUE if isinstance(self.sweep, Motor) else ROOTS if self.spun else 0.0

    def value(self, model: Model, x: FloatArray) -> float:
        from vibopt.mechanics.harmonic import mount_count

        return self.peak(model, x).value / mount_count(model, self.output, x)

    def slope(self, model: Model, x: FloatArray) -> FloatArray:
        if model.spun_in_time:
            return by_differences(lambda at: self.value(model, at), x, _WIDE)
        peak, p = self.peak(model, x), model.values(x)
        if not 0.0 < peak.value < np.inf or isinstance(self.sweep, Motor):
            return by_differences(lambda at: self.value(model, at), x)
        at = np.array([peak.time])
        changes, (machine, row) = self._changes(model, x, model.exponents.T, at)[:, 0], self.run_up(model, x, p)
        if isinstance(self.sweep, Sweeps):  # it moves joints of the force, in which nothing is analytic
            changes[self.sweep.index] = self._change_of_rate(model, x, peak.time)
        slope: FloatArray = np.real(changes / machine.turning(machine.modal(row), at)[0])
        if self.output.shared_by:
            slope = slope - model.counts[self.output.shared_by].row(model.n_vars)
        return slope

    def _changes(self, model: Model, x: FloatArray, ways: FloatArray, times: FloatArray) -> ComplexArray:
        """How the complex reading at times (n,) changes along ways of log p (k, n_terms), (k, n).

        On the lower half of the circle all is conjugate to the upper.
        """
        from vibopt.mechanics.sweep_response import Modal, mean

        p, found = model.values(x), np.zeros((len(ways), len(times)), dtype=complex)
        machine, row = self.run_up(model, x, p)
        last = times[np.isfinite(times)].max(initial=0.0)
        reach = _AROUND / (1.0 + float(np.abs(machine.modal(row).poles).max()) * last)
        turns = np.exp(2j * np.pi * (np.arange(_HALF) + 0.5) / (2 * _HALF))
        for i in np.flatnonzero(ways.any(axis=1)):
            around = [self.run_up(model, x, p * (1.0 + reach * turn * ways[i])) for turn in turns]
            upper = [machine.modal(row) for machine, row in around]
            lower = [Modal(one.poles.conj(), one.parts.conj(), one.through.conjugate()) for one in upper]
            weights = 0.5 / (_HALF * reach * np.concatenate([turns, turns.conj()]))
            found[i] = around[0][0].turning(mean([*upper, *lower], weights), times)
        return found

    def _change_of_rate(self, model: Model, x: FloatArray, time: float) -> complex:
        """What changes the size of the reading at one time in the log of the rate, in the phase of the reading."""
        if not np.isfinite(time):
            return 0j
        assert isinstance(self.sweep, Sweeps)
        sizes, at = [], np.array([time])
        for off in (-_STEP, _STEP, 0.0):
            beside = x.copy()
            beside[self.sweep.index] *= np.exp(off)
            machine, row = self.run_up(model, beside, model.values(x))
            sizes.append(complex(machine.turning(machine.modal(row), at)[0]))
        return (abs(sizes[1]) - abs(sizes[0])) / (2.0 * _STEP) * sizes[2] / abs(sizes[2])

    @property
    def tangents_of(self) -> tuple[float, ...]:
        given = isinstance(self.sweep, Sweep) and not self.spun
        return (1.0,) if given else ()  # it is no less than at any time, at any angle of beginning

    def tangents(
        self, model: Model, x: FloatArray, reach: FloatArray, level: float = WITHOUT_END, times: Sequence[float] = ()
    ) -> list[list[Tangent]]:
        """At the time of the peak at x, and at each of `times` [s]."""
        return [self._tangents(model, one, off, times) for one, off in zip(x, reach, strict=True)]

    def tangents_cost(self, model: Model) -> float:
        return self.cost(model) * int(model.exponents.any(axis=1).sum())

    def greatest_at(self, model: Model, x: FloatArray) -> float:
        return self.peak(model, x).time

    def _tangents(self, model: Model, x: FloatArray, reach: FloatArray, times: Sequence[float]) -> list[Tangent]:
        from vibopt.forms.tangent import Opened, flat
        from vibopt.mechanics.harmonic import mount_count
        from vibopt.mechanics.kernel_bounds import extension, swept
        from vibopt.mechanics.transient import Transient

        peak, opened = self.peak(model, x), Opened(model, self.output)
        if not 0.0 < peak.value < np.inf or (self.output.shared_by and model.counts[self.output.shared_by].exponents):
            return []
        if not opened.elements:  # what is chosen moves other bodies alone
            return [flat(self.value(model, x), len(x))]
        machine, read = self.run_up(model, x, model.values(x))
        own, sweep = machine.modal(read), machine.sweep
        with np.errstate(divide="ignore"):
            settled = float(_SETTLED / -own.poles.real.max(initial=-np.inf))
        moments = np.array([peak.time, *(one for one in times if abs(one - peak.time) > _APART * peak.time)])
        moments = np.minimum(moments, sweep.times[-1] + settled)
        extensions = [extension(element) for element in opened.elements]
        sizes = np.array([peak.value if _alike(one, read) else machine.at_most(one) for one in extensions])
        if not np.isfinite([*moments, *sizes]).all():
            return []
        p = np.broadcast_to(model.values(x), (len(moments), len(model.terms)))
        here = machine.turning(own, moments)
        still = Transient(*matrices(model, p), model.n_free, self.load[:, None], (AT_REST,))
        pushed = moments + (settled if sweep.still[0] else 0.0)
        near = swept(
            still, read, opened.elements, pushed, np.abs(here), np.broadcast_to(sizes, (len(here), len(sizes)))
        )
        if near is None:
            return []
        wide = np.broadcast_to(reach, (len(here), len(reach)))

        def slopes(of: IntArray) -> FloatArray:
            found = self._changes(model, x, opened.ways, moments[of])
            return np.real(found / here[of] * np.abs(here[of])).T

        return opened.tangents(near, p, slopes, wide, 1.0 / mount_count(model, self.output, x))

    def acting(self, model: Model) -> FloatArray:
        chosen = [np.eye(model.n_vars)[self.sweep.index]] if isinstance(self.sweep, Sweeps) else []
        return np.vstack([model.acting, *chosen])

    def held(self, x: FloatArray, free: list[int]) -> PeakInRunUp:
        if not isinstance(self.sweep, Sweeps):
            return self
        if self.sweep.index in free:
            return replace(self, sweep=replace(self.sweep, index=free.index(self.sweep.index)))
        return replace(self, sweep=self.sweep.of(x))

    def reach(self, model: Model) -> Reach | None:
        from vibopt.forms.reduce import driven

        if model.spun_in_time:
            return None
        return driven(model, self.output, [self.load])

    def cost(self, model: Model) -> float:
        return 10.0 + 20.0 * model.n_free if model.spun_in_time else 3.0 + model.n_free

    def peak(self, model: Model, x: FloatArray) -> Peak:
        """The greatest response, of all mounts together where shared."""
        return kept(model, self, x[None], lambda some: [self._peak(model, one) for one in some])[0]

    def _peak(self, model: Model, x: FloatArray) -> Peak:
        from vibopt.mechanics.peaks_in_time import Peak

        machine, read = self.course(model, x)
        return machine.peak(read) if machine.sweep.speeds else Peak(np.inf, np.inf)

    def course(self, model: Model, x: FloatArray) -> tuple[RunUp | SpinUp, Reading]:
        """The machine or the rotor in its run-up at a design, and what is read."""
        p = model.values(x)
        return (
            (self._spun(model, x), reading(model, self.output, p)) if model.spun_in_time else self.run_up(model, x, p)
        )

    def _spun(self, model: Model, x: FloatArray) -> SpinUp:
        from vibopt.mechanics.spinning_up import SpinUp

        assert not isinstance(self.sweep, Motor)
        return SpinUp(model, x, self.output, self.load, self.sweep.of(x))

    def run_up(self, model: Model, x: FloatArray, p: Numbers) -> tuple[RunUp, Reading]:
        """The machine under its force, and what is read, at a design and coefficients p (n_terms,), real or complex.

        Of a motor that sticks the run-up has no speeds.
        """
        from vibopt.mechanics.sweep_response import RunUp

        read = reading(model, self.output, p)
        if not isinstance(self.sweep, Motor):
            return RunUp(*matrices(model, p), model.n_free, self.load, self.sweep.of(x)), read
        machine = RunUp(*matrices(model, p), model.n_free, self.load, NO_SWEEP)
        motor, own = self.sweep, machine.modal(Reading(self.load, 0.0 * self.load, 0.0 * self.load))

        def drag(speeds: FloatArray) -> FloatArray:
            with np.errstate(divide="ignore", invalid="ignore"):  # at an undamped resonance it has no end
                moved = (own.parts / (1j * speeds[..., None] - own.poles)).sum(axis=-1)
            return motor.drag(moved, speeds)

        return replace(machine, sweep=motor.against(drag, own.poles) or NO_SWEEP), read

    def _rounded(self, model: Model, x: FloatArray, rounding: float) -> float:
        """Rounding of motions as large that a reading does not see, as where all is symmetric."""
        from vibopt.mechanics.harmonic import mount_count

        if model.spun_in_time or model.massless.any():
            return 0.0
        p, n = model.values(x), model.n_free
        root = np.linalg.inv(np.linalg.cholesky(matrices(model, p)[0][:n, :n])).T
        whole = np.zeros((n, model.n_coords))
        whole[:, :n] = np.linalg.inv(root)
        still = np.zeros(len(model.terms))
        each = [replace(self, output=Output(one, still, self.output.power)).value(model, x) for one in whole]
        read = np.linalg.norm(reading(model, self.output, p).row[:n] @ root)
        return rounding * float(read * np.linalg.norm(each)) / mount_count(model, self.output, x)

    def room(self, model: Model, x: FloatArray, value: float, other: float, rounding: float) -> float:
        """Accelerations that follow from torque are even on stretches; of a rotor fast free whirls are left out."""
        left_out = 0.0
        if model.spun_in_time:
            from vibopt.mechanics.harmonic import mount_count

            left_out = self._spun(model, x).left_out / mount_count(model, self.output, x)
        sizes = [0.0, *(abs(one) for one in (value, other) if np.isfinite(one))]
        known = left_out + (self.known_to or ROOTS) * max(sizes)
        rounded = self._rounded(model, x, rounding)
        return max(known, rounded) if max(sizes) <= rounded else known


def _alike(one: Reading, other: Reading) -> bool:
    pairs = ((one.row, other.row), (one.rates, other.rates), (one.inertia, other.inertia))
    return one.power == other.power and all(np.array_equal(*pair) for pair in pairs)
