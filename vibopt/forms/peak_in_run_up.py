"""Greatest response in a run-up or run-down, at a design, with its exact slope.

Moving the peak changes nothing to first order: the slope is that of the envelope at one time, by Cauchy's integral
around the design, for the answer is analytic in the coefficients and its modulus is not.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms.form import ROOTS, Form, by_differences, kept
from vibopt.forms.peak_in_time import matrices, reading
from vibopt.mechanics.motor import NO_SWEEP, Motor
from vibopt.mechanics.transient import Reading
from vibopt.records import dataclass
from vibopt.signals import Output, Sweep, Sweeps

if TYPE_CHECKING:
    from vibopt.forms.reduce import Reach
    from vibopt.mechanics.model import Model
    from vibopt.mechanics.panels import Numbers
    from vibopt.mechanics.ringing import Peak
    from vibopt.mechanics.spinning_up import SpinUp
    from vibopt.mechanics.sweep_response import RunUp

BY_TORQUE = 3e-5
"""Part of itself to which the greatest is known where the speed follows from torque."""
_STEP, _WIDE = 1e-5, 1e-4
"""Parts of a rate, and of any value where whirls hang on the spin, for differences."""
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
    no_bounds = "is a peak in a run-up: it has no bounds on boxes of designs"
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
        machine, row = self.run_up(model, x, p)
        own = machine.modal(row)
        here = machine.turning(own, np.array([peak.time]))[0]
        reach = _AROUND / (1.0 + float(np.abs(own.poles).max()) * (peak.time if np.isfinite(peak.time) else 0.0))
        changes = [self._change(model, x, reach, i, peak.time) for i in range(model.n_vars)]
        slope: FloatArray = np.real(np.array(changes) / here)
        if self.output.shared_by:
            slope = slope - model.counts[self.output.shared_by].row(model.n_vars)
        return slope

    def _change(self, model: Model, x: FloatArray, reach: float, index: int, time: float) -> complex:
        """Slope of the complex reading at one time in the log of one variable.

        On the lower half of the circle all is conjugate to the upper.  A rate moves joints of the force, too, in which
        nothing is analytic: its slope is that of the reading's size, by differences.
        """
        from vibopt.mechanics.sweep_response import Modal, mean

        p, exponents = model.values(x), model.exponents[:, index]
        if isinstance(self.sweep, Sweeps) and self.sweep.index == index:
            return self._change_of_rate(model, x, time)

        turns = np.exp(2j * np.pi * (np.arange(_HALF) + 0.5) / (2 * _HALF))
        around = [self.run_up(model, x, p * (1.0 + reach * turn * exponents)) for turn in turns]
        upper = [machine.modal(row) for machine, row in around]
        lower = [Modal(one.poles.conj(), one.parts.conj(), one.through.conjugate()) for one in upper]
        weights = 0.5 / (_HALF * reach * np.concatenate([turns, turns.conj()]))
        return complex(around[0][0].turning(mean([*upper, *lower], weights), np.array([time]))[0])

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
        from vibopt.mechanics.ringing import Peak

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
