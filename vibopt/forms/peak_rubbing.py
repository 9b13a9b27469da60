"""Greatest response in time of a body on links of which one rubs, at a design."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms.form import by_differences, kept
from vibopt.forms.peak_in_time import PeakInTime, matrices, reading
from vibopt.forms.rubbing import friction_of, grip_of
from vibopt.mechanics.harmonic import mount_count
from vibopt.records import dataclass

if TYPE_CHECKING:
    from vibopt.mechanics.model import Model
    from vibopt.mechanics.ringing import Peak
    from vibopt.mechanics.sliding import Sliding
    from vibopt.mechanics.transient import Reading

_KEPT, _NEAR, _ROUNDED = 16, 1e-7, 1e-9
"""Motions that are kept; parts of itself and of what would move without friction by which both routes may differ."""


@dataclass(frozen=True, slots=True)
class PeakRubbing(PeakInTime):
    """As `PeakInTime`, of what slips, stops and holds: loads that come together do not add; slopes are differences."""

    no_bounds = "is a motion with dry friction, which has no bounds on boxes of designs"
    not_convex = "is a motion with dry friction, which is not convex in stiffness, damping and friction"
    rough = "is a motion with dry friction, which slips, stops or holds: no smooth function of the design"

    @property
    def in_time(self) -> None:
        return None

    @property
    def tangents_of(self) -> tuple[float, ...]:
        return ()

    @property
    def screened(self) -> bool:
        return True

    def push(self, mass: float, speed: float) -> float:
        sizes = np.array([np.abs(one.read @ one.start) for one in self.segments]).max(axis=0)
        blows = np.array([np.abs(one.blows) for one in self.segments]).max(axis=0)
        forces = np.abs(self.loads[0]) + mass * np.abs(self.loads[1:]).sum(axis=0)
        return float(forces @ (sizes + speed * blows)) or 1.0

    def slope(self, model: Model, x: FloatArray) -> FloatArray:
        return by_differences(lambda at: self.value(model, at), x)

    def acting(self, model: Model) -> FloatArray:
        assert model.rubbing is not None
        return np.vstack([model.exponents, model.rubbing[1].row(model.n_vars)])

    def room(self, model: Model, x: FloatArray, value: float, other: float, rounding: float) -> float:
        """And less still of what would move without friction, whatever that leaves of it."""
        machine, read = self.transient(model, model.values(x[None]))
        free = abs(machine.peaks(read).each()[0].value)
        sizes = [_NEAR * abs(value), _NEAR * abs(other), _ROUNDED * free]
        return max([0.0, *(one for one in sizes if np.isfinite(one))])

    def cost(self, model: Model) -> float:
        return 10.0 + 0.1 * len(self.segments)

    def peak(self, model: Model, x: FloatArray) -> Peak:
        def measured(some: FloatArray) -> list[Peak]:
            return [machine.peak(read) for machine, read in (self.motion(model, one) for one in some)]

        return kept(model, self, x[None], measured)[0]

    def values(self, model: Model, x: FloatArray, *, least_wanted: bool = False) -> FloatArray:
        return np.array([abs(self.peak(model, one).value) / mount_count(model, self.output, one) for one in x])

    def motion(self, model: Model, x: FloatArray) -> tuple[Sliding, Reading]:
        from vibopt.mechanics.sliding import Sliding

        assert model.rubbing is not None
        known: dict[tuple[bytes, ...], Sliding] = vars(model).setdefault("sliding", {})
        arrays = ((np.array(one.length), one.start, one.rates, one.read, one.blows) for one in self.segments)
        said = (one.tobytes() for every in arrays for one in every)  # each response has segments of its own
        key = self.loads.tobytes(), np.asarray(x, dtype=float).tobytes(), *said
        if key not in known:
            if len(known) >= _KEPT:
                known.pop(next(iter(known)))
            rows = matrices(model, model.values(x))
            across, friction = model.links[model.rubbing[0]], friction_of(model, x)
            known[key] = Sliding(*rows, self.loads, self.segments, across, friction)
        read = reading(model, self.output, model.values(x))
        return known[key], replace(read, grip=grip_of(model, self.output.signs))
