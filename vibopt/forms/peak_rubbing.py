"""Greatest response in time of a machine of which one link rubs, at a design."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from vibopt.arrays import FloatArray, IntArray
from vibopt.forms.form import Form, Local, by_differences, kept
from vibopt.forms.peak_in_time import PeakInTime, matrices, reading
from vibopt.forms.rubbing import Rubbing, acting_with_friction, friction_of, grip_of
from vibopt.mechanics.harmonic import mount_count
from vibopt.records import dataclass

if TYPE_CHECKING:
    from vibopt.mechanics.model import Model
    from vibopt.mechanics.peaks_in_time import Peak
    from vibopt.mechanics.readout import Reading
    from vibopt.mechanics.sliding import Sliding
    from vibopt.signals import Output

_KEPT, _NEAR, _ROUNDED, _NOTHING = 16, 1e-7, 1e-9, 1e-13
"""Motions that are kept; parts of itself and of what would move without friction by which both routes may differ; part
of its terms below which a sum is rounding."""


@dataclass(frozen=True, slots=True)
class PeakRubbing(PeakInTime):
    """As `PeakInTime`, of what slips, stops and holds: loads that come together do not add; slopes are differences."""

    no_bounds, not_convex, rough = Rubbing.no_bounds, Rubbing.not_convex, Rubbing.rough

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

    def extremes(self, model: Model, x: FloatArray, *, least_wanted: bool, within: float = 0.5) -> list[Local]:
        return Form.extremes(self, model, x, least_wanted=least_wanted, within=within)

    def acting(self, model: Model) -> FloatArray:
        return acting_with_friction(model)

    def room(self, model: Model, x: FloatArray, value: float, other: float, rounding: float) -> float:
        """And less still of what would move without friction, whatever that leaves of it."""
        machine, read = self.transient(model, model.values(x[None]))
        free = abs(machine.peaks(read).each()[0].value)
        sizes = [_NEAR * abs(value), _NEAR * abs(other), _ROUNDED * free]
        return max([0.0, *(size for size in sizes if np.isfinite(size))])

    def cost(self, model: Model) -> float:
        return 3.0 * model.n_free + 0.1 * len(self.segments)

    def ahead(self, model: Model, x: FloatArray) -> None:
        """Nothing: design after design, all that is read of one shares its motion."""

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
            seen, n = in_stretches(model, x), model.n_free
            loads = np.vstack([seen.whole[:n, : seen.n_free].T @ self.loads[:n], self.loads[n:]])
            begun: FloatArray = np.zeros((len(seen.kept), 2))
            if released is not None:
                begun = np.asarray(np.linalg.solve(_turned(model)[1], self.loads @ released)[seen.kept])
            known[key] = Sliding(*seen.rows, seen.n_free, loads, self.segments, begun, friction_of(model, x))
        return known[key], read_in_stretches(model, x, self.output)


@dataclass(frozen=True, slots=True)
class InStretches:
    """A machine in stretches of links, that of the one that rubs first, bases last.

    rows
        Mass, damping and stiffness, (n, n) each.
    n_free
        Number of those that are free.
    kept
        Numbers of them among all: joints that springs alone hold are left out.
    lift, whole
        All stretches from those that are kept, and all coordinates, (n_coords, n).
    """

    rows: tuple[FloatArray, FloatArray, FloatArray]
    n_free: int
    kept: IntArray
    lift: FloatArray
    whole: FloatArray


def in_stretches(model: Model, x: FloatArray) -> InStretches:
    """The machine of a design."""
    turned, whole = _turned(model)
    mass, damping, stiffness = matrices(turned, model.values(x))
    quick = 1 + np.flatnonzero((np.diag(mass) + np.diag(damping))[1 : model.n_free] == 0.0)
    kept, lift = np.setdiff1d(np.arange(len(mass)), quick), np.eye(len(mass))
    if not len(quick):
        return InStretches((mass, damping, stiffness), model.n_free, kept, lift, whole)
    lift = lift[:, kept]
    lift[quick] = -np.linalg.solve(stiffness[np.ix_(quick, quick)], stiffness[np.ix_(quick, kept)])
    rows = mass[np.ix_(kept, kept)], damping[np.ix_(kept, kept)], lift.T @ stiffness @ lift
    return InStretches(rows, model.n_free - len(quick), kept, lift, whole @ lift)


def read_in_stretches(model: Model, x: FloatArray, output: Output) -> Reading:
    """What is read, of the coordinates of `in_stretches`."""
    (turned, whole), lift = _turned(model), in_stretches(model, x).lift
    read = reading(turned, replace(output, row=output.row @ whole), model.values(x))
    return replace(
        read,
        row=read.row @ lift,
        rates=read.rates @ lift,
        inertia=read.inertia @ lift,
        grip=grip_of(model, output.signs),
    )


def _turned(model: Model) -> tuple[Model, FloatArray]:
    """The model in stretches of links, that of the one that rubs first, and coordinates from these; bases stay.

    What rides on a base that goes far away keeps its digits.  Those of bodies move all that rests on them, those of
    joints without mass no body, first where a damper holds them.
    """
    known: dict[str, tuple[Model, FloatArray]] = vars(model).setdefault("in_stretches", {})
    if not known:
        from vibopt.mechanics.model import DAMPING

        assert model.rubbing is not None
        n, name, light = model.n_free, model.rubbing[0], model.massless
        braked = [term.vector[:n] for term in model.terms if term.kind == DAMPING and term.owner != name]
        held = light & (np.any(braked, axis=0) if braked else False)
        rows = [model.links[name]]
        every = [*model.links.values(), *np.eye(model.n_coords)[:n]]
        first = [row for row in every if not row[:n][light].any()]
        then = [row for row in every if np.count_nonzero(row[:n][light]) == 1]
        for row in [*first, *sorted(then, key=lambda row: not row[:n][held].any())]:
            if np.linalg.matrix_rank(np.array([*rows, row])[:, :n]) > len(rows):
                rows.append(row)
        whole = np.linalg.inv(np.vstack([*rows, np.eye(model.n_coords)[n:]]))
        known[name] = model.through(whole, _NOTHING), whole
    return next(iter(known.values()))
