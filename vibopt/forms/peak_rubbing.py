"""Greatest response in time of a machine of which one link rubs, at a design."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms.form import by_differences, kept
from vibopt.forms.peak_in_time import PeakInTime, matrices, reading
from vibopt.forms.rubbing import acting_with_friction, friction_of, grip_of
from vibopt.mechanics.harmonic import mount_count
from vibopt.records import dataclass

if TYPE_CHECKING:
    from vibopt.mechanics.model import Model
    from vibopt.mechanics.ringing import Peak
    from vibopt.mechanics.sliding import Sliding
    from vibopt.mechanics.transient import Reading

_KEPT, _NEAR, _ROUNDED, _NOTHING = 16, 1e-7, 1e-9, 1e-13
"""Motions that are kept; parts of itself and of what would move without friction by which both routes may differ; part
of its terms below which a sum is rounding."""


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
        sizes = np.array([np.abs(segment.read @ segment.start) for segment in self.segments]).max(axis=0)
        blows = np.array([np.abs(segment.blows) for segment in self.segments]).max(axis=0)
        forces = np.abs(self.loads[0]) + mass * np.abs(self.loads[1:]).sum(axis=0)
        return float(forces @ (sizes + speed * blows)) or 1.0

    def reach(self, model: Model) -> None:
        return None

    def slope(self, model: Model, x: FloatArray) -> FloatArray:
        return by_differences(lambda at: self.value(model, at), x)

    def acting(self, model: Model) -> FloatArray:
        return acting_with_friction(model)

    def room(self, model: Model, x: FloatArray, value: float, other: float, rounding: float) -> float:
        """And less still of what would move without friction, whatever that leaves of it."""
        machine, read = self.transient(model, model.values(x[None]))
        free = abs(machine.peaks(read).each()[0].value)
        sizes = [_NEAR * abs(value), _NEAR * abs(other), _ROUNDED * free]
        return max([0.0, *(size for size in sizes if np.isfinite(size))])

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
        arrays = (
            (np.array(segment.length), segment.start, segment.rates, segment.read, segment.blows)
            for segment in self.segments
        )
        said = (one.tobytes() for every in arrays for one in every)  # each response has segments of its own
        released = self.segments[0].released
        begins = b"" if released is None else released.tobytes()
        key = self.loads.tobytes(), begins, np.asarray(x, dtype=float).tobytes(), *said
        if key not in known:
            if len(known) >= _KEPT:
                known.pop(next(iter(known)))
            turned, whole = in_stretches(model)
            n = model.n_free
            loads = np.vstack([whole[:n, :n].T @ self.loads[:n], self.loads[n:]])
            begun: FloatArray = np.zeros((len(whole), 2))
            if released is not None:
                begun = np.asarray(np.linalg.solve(whole, self.loads @ released))
            rows = matrices(turned, model.values(x))
            known[key] = Sliding(*rows, n, loads, self.segments, begun, friction_of(model, x))
        turned, whole = in_stretches(model)
        read = reading(turned, replace(self.output, row=self.output.row @ whole), model.values(x))
        return known[key], replace(read, grip=grip_of(model, self.output.signs))


def in_stretches(model: Model) -> tuple[Model, FloatArray]:
    """The model in stretches of links, that of the one that rubs first, and coordinates from these; bases stay.

    What rides on a base that goes far away keeps its digits.
    """
    known: dict[str, tuple[Model, FloatArray]] = vars(model).setdefault("in_stretches", {})
    if not known:
        assert model.rubbing is not None
        n, name = model.n_free, model.rubbing[0]
        rows = [model.links[name]]
        for row in [*model.links.values(), *np.eye(model.n_coords)[:n]]:
            if np.linalg.matrix_rank(np.array([*rows, row])[:, :n]) > len(rows):
                rows.append(row)
        whole = np.linalg.inv(np.vstack([*rows, np.eye(model.n_coords)[n:]]))
        known[name] = model.through(whole, _NOTHING), whole
    return next(iter(known.values()))
