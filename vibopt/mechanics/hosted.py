"""A machine as built that stands on structures: bodies and joints coupled with receptances.

The structure is never put into one matrix with what it carries.  It answers with displacements per force
at its points, and the forces of the joints there are found together with the motion of the bodies.  A
finished design is measured with the matrices in full, solved at the speed in question.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field, replace
from typing import ClassVar

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray, IntArray
from vibopt.mechanics.built import Motion
from vibopt.mechanics.built_algebra import at_rest, inverse_root, singular, solved
from vibopt.mechanics.constants import GRAVITY
from vibopt.mechanics.host import Coordinates, Matrices, condensed, massless
from vibopt.mechanics.host.matrices import Dashed
from vibopt.mechanics.machine import Machine
from vibopt.records import cached_property, dataclass

_REST = 1e-5
"""Part of the lowest natural frequency that is standstill: its square is what that leaves off."""


@dataclass(frozen=True, eq=False)
class Carrier:
    """One structure of a built machine.

    coordinates
        Modes, or what was found to be enough of the matrices.
    matrices, places
        The matrices in full and the coordinate numbers of the points; None for a list of modes.
    """

    coordinates: Coordinates
    matrices: Matrices | None = None
    places: IntArray | None = None

    @cached_property
    def dash(self) -> float:
        """A damper of the structure's own size [N s/m]."""
        at = self.coordinates
        row = np.abs(at.rows()).max(initial=0.0) or 1.0
        return float(np.sqrt(np.median(at.mass) * np.median(np.abs(at.stiffness)))) / row**2 or 1.0

    @cached_property
    def _dashed(self) -> Dashed:
        assert self.matrices is not None
        assert self.places is not None
        return Dashed(self.matrices, self.places, self.dash)

    @cached_property
    def in_time(self) -> tuple[FloatArray, FloatArray, FloatArray, Mapping[str, FloatArray]]:
        """M, C, K of what has mass, of matrices in full and else of the modes, and the rows of the points over it."""
        at = self.coordinates
        if self.matrices is None or self.places is None:
            return np.diag(at.mass), at.damping, np.diag(at.stiffness), at.points
        of, empty = condensed(self.matrices), massless(self.matrices.mass)
        mass, damping, stiffness = (one.toarray() for one in (of.mass, of.damping, of.stiffness))
        rows = np.eye(len(mass))[self.places - np.searchsorted(empty, self.places)]
        return mass, damping, stiffness, dict(zip(at.points, rows, strict=True))

    def answer(self, omega: FloatArray, *, full: bool) -> ComplexArray:
        """Receptances with the damper at each point, (n, p, p); `full` solves the matrices themselves.

        At complex frequencies by the coordinates.
        """
        if full and self.matrices is not None and not np.iscomplexobj(omega):
            return self._dashed.receptances(omega)
        return self.coordinates.receptances(omega, self.dash)


@dataclass(frozen=True)
class HostedMachine(Machine):
    """A machine with structures.

    carriers
        Structures by name.
    full
        Whether matrices are solved as they are, at every frequency that is asked for.
    """

    carriers: Mapping[str, Carrier] = field(default_factory=dict)
    full: bool = False
    on_structures: ClassVar[bool] = True

    @property
    def in_full(self) -> Machine:
        return replace(self, full=True)

    @cached_property
    def host_points(self) -> tuple[str, ...]:
        """Points of all structures."""
        return tuple(point for carrier in self.carriers.values() for point in carrier.coordinates.points)

    @property
    def places(self) -> tuple[str, ...]:
        return (*self.masses, *self.host_points)

    def shake(self, omega: FloatArray, forces: dict[str, ComplexArray], bases: dict[str, ComplexArray]) -> Motion:
        """As `Machine.shake`; rows of bodies are balances of forces, rows of points say u = H f."""
        flat = np.ravel(omega)
        if self._beside_rest:  # receptances of what is free have no end at standstill
            flat = np.where(flat == 0.0, self._beside_rest, flat)
        names = list(self.places)
        stiff, load = self._joints(names, flat, bases)
        for name, force in forces.items():
            load[:, names.index(name)] += np.ravel(force)
        start = len(self.masses)
        for i, mass in enumerate(self.masses.values()):
            stiff[:, i, i] -= mass * flat**2
        for carrier in self.carriers.values():
            stop = start + len(carrier.coordinates.points)
            here = slice(start, stop)
            moved = carrier.answer(flat, full=self.full)
            rows = np.arange(start, stop)
            stiff[:, rows, rows] -= 1j * flat[:, None] * carrier.dash
            stiff[:, here] = moved @ stiff[:, here]
            stiff[:, rows, rows] += 1.0
            load[:, here] = (moved @ load[:, here, None])[..., 0]
            start = stop
        found = solved(stiff, load)
        points = {name: found[:, i].reshape(omega.shape) for i, name in enumerate(names)}
        for base in self.bases:
            points[base] = bases.get(base, np.zeros(omega.shape, dtype=complex))
        return Motion(points, forces, omega)

    @cached_property
    def _beside_rest(self) -> float:
        """A frequency [rad/s] that is as good as none, where a structure is free; else zero."""
        own = self.natural_frequencies()
        least = own[own > _REST**2 * own.max(initial=0.0)].min(initial=np.inf)
        free = any((carrier.coordinates.stiffness == 0.0).any() for carrier in self.carriers.values())
        return float(_REST * least) if free and np.isfinite(least) else 0.0

    def _joints(
        self, names: list[str], omega: FloatArray, bases: dict[str, ComplexArray]
    ) -> tuple[ComplexArray, ComplexArray]:
        """Dynamic stiffness of the joints over bodies and points, (n, k, k), and the pull of moving bases, (n, k)."""
        number = {name: i for i, name in enumerate(names)}
        stiff = np.zeros((len(omega), len(names), len(names)), dtype=complex)
        load = np.zeros((len(omega), len(names)), dtype=complex)
        for joint in self.joints:
            z = joint.dynamic(omega)
            for here, there in (joint.ends, joint.ends[::-1]):
                if here not in number:
                    continue
                stiff[:, number[here], number[here]] += z
                if there in number:
                    stiff[:, number[here], number[there]] -= z
                elif there in bases:
                    load[:, number[here]] += z * np.ravel(bases[there])
        return stiff, load

    @cached_property
    def _rows(self) -> dict[str, FloatArray]:
        """Per body and point its row over [bodies, coordinates of the structures]."""
        return self._rows_over([carrier.coordinates.points for carrier in self.carriers.values()])

    def _rows_over(self, hosts: list[Mapping[str, FloatArray]]) -> dict[str, FloatArray]:
        """The same, of structures whose points have these rows over coordinates of their own."""
        sizes = [len(self.masses), *(len(next(iter(points.values()))) for points in hosts)]
        ends, found = np.cumsum(sizes), dict(zip(self.masses, np.eye(sum(sizes)), strict=False))
        for points, start, stop in zip(hosts, ends, ends[1:], strict=False):
            for point, row in points.items():
                found[point] = np.zeros(sum(sizes))
                found[point][start:stop] = row
        return found

    def _extensions(self, rows: Mapping[str, FloatArray]) -> FloatArray:
        """Row of every joint over the coordinates of these rows of bodies and points, shape (n_joints, count)."""
        zero = np.zeros(len(next(iter(rows.values()))))
        return np.array([rows.get(b, zero) - rows.get(a, zero) for a, b in (joint.ends for joint in self.joints)])

    @property
    def coordinate_names(self) -> tuple[str, ...]:
        """Bodies, then each structure's modes or, of matrices, their own coordinates, then bases."""
        hosts = (f"{name} [{i + 1}]" for name, one in self.carriers.items() for i in range(len(one.in_time[0])))
        return (*self.masses, *hosts, *self.bases)

    @property
    def n_free(self) -> int:
        return len(self.coordinate_names) - len(self.bases)

    @cached_property
    def _rows_in_time(self) -> dict[str, FloatArray]:
        """Per body, point and base its row over all coordinates."""
        whole = np.eye(len(self.coordinate_names))
        free = self._rows_over([carrier.in_time[3] for carrier in self.carriers.values()])
        rows = {name: np.pad(row, (0, len(self.bases))) for name, row in free.items()}
        return rows | dict(zip(self.bases, whole[self.n_free :], strict=True))

    def pushes(self, acts: Mapping[str, complex]) -> FloatArray:
        zero = np.zeros(len(self.coordinate_names))
        return np.asarray(sum((part.real * self._rows_in_time[place] for place, part in acts.items()), zero))

    def parts_in_time(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        found, start = np.zeros((3, *2 * (len(self.coordinate_names),))), len(self.masses)
        found[0, :start, :start] = np.diag(list(self.masses.values()))
        for carrier in self.carriers.values():
            here = slice(start, start := start + len(carrier.in_time[0]))
            found[:, here, here] = carrier.in_time[:3]
        if self.joints:
            rows = self._extensions(self._rows_in_time)
            found += [(rows.T * values) @ rows for values in self._fours[:3]]
        return found[0], found[1], found[2]

    def points_in_time(self, moved: FloatArray) -> dict[str, FloatArray]:
        return {name: row @ moved for name, row in self._rows_in_time.items()}

    def matrices(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """M, C, K and hysteretic stiffness over bodies and coordinates of the structures."""
        hosts = [carrier.coordinates for carrier in self.carriers.values()]
        mass = np.diag(np.concatenate([list(self.masses.values()), *(host.mass for host in hosts)]))
        damping, stiffness, hysteretic = (np.zeros_like(mass) for _ in range(3))
        start = len(self.masses)
        for host in hosts:
            here = slice(start, start + host.count)
            damping[here, here] = host.damping
            stiffness[here, here] = np.diag(host.stiffness)
            hysteretic[here, here] = host.loss_factor * np.diag(host.stiffness)
            start += host.count
        if self.joints:
            rows = self._extensions(self._rows)
            for target, values in zip((mass, damping, stiffness, hysteretic), self._fours, strict=True):
                target += (rows.T * values) @ rows
        return mass, damping, stiffness, hysteretic

    def natural_frequencies(self) -> FloatArray:
        """Undamped natural frequencies, ascending [rad/s], as singular values; no squares are taken."""
        mass = self.matrices()[0]
        columns = [np.diag(np.concatenate([np.zeros(len(self.masses)), *self._host_roots()]))]
        if self.joints:
            stiffness = np.array([joint.stiffness for joint in self.joints])
            columns.append(self._extensions(self._rows).T * np.sqrt(stiffness))
        return singular(inverse_root(mass) @ np.hstack(columns))

    def _host_roots(self) -> list[FloatArray]:
        return [np.sqrt(carrier.coordinates.stiffness) for carrier in self.carriers.values()]

    def sag(self) -> dict[str, float] | None:
        """Displacement of every point under the weights of the bodies [m]; structures are drawn as they hang."""
        hosts = [carrier.coordinates.stiffness for carrier in self.carriers.values()]
        stiffness = np.diag(np.concatenate([np.zeros(len(self.masses)), *hosts]))
        if self.joints:
            rows = self._extensions(self._rows)
            stiffness += (rows.T * np.array([joint.static_stiffness for joint in self.joints])) @ rows
        load = np.zeros(len(stiffness))
        load[: len(self.masses)] = [self.weights[name] * GRAVITY for name in self.masses]
        down = at_rest(stiffness, load)
        return None if down is None else {name: float(row @ down) for name, row in self._rows.items()}
