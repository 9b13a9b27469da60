"""A reading at one time as a function of the machine's coefficients: its tangent, and how far it can be from it.

With coefficients p that are off by d, the motion is that of the machine at p0 under further forces: d_i times what
the element i is extended by (its rate, its acceleration), on the machine as it is.  So the reading is its tangent in d,
and a rest of second order.  Schwarz and Young bound the rest: the answer to a force is never greater than the root of
the energy of its kernel times that of the force, and its own energy is no greater than the kernel's sum times the
force's.  Energies are integrals of squares up to that time, by doubling.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.mechanics.model import DAMPING, INERTIA, STIFFNESS
from vibopt.mechanics.panels import exponential, series
from vibopt.mechanics.transient import Peak, Reading, Transient
from vibopt.records import dataclass

_PLACES, _SHARES = np.polynomial.legendre.leggauss(16)
_NODES, _WEIGHTS = np.append(0.5 + 0.5 * _PLACES, 1.0), 0.5 * _SHARES
_ROUNDING = 1.0 + 1e-9
_POWERS = {STIFFNESS: 0, DAMPING: 1, INERTIA: 2}
"""How often the extension is differentiated that a coefficient multiplies."""


@dataclass(frozen=True, slots=True)
class Element:
    """A coefficient that is open: `vector` (n_coords,) . u is the extension; the reading has `weight` of its force."""

    kind: int
    vector: FloatArray
    weight: float


@dataclass(frozen=True, slots=True)
class Nearby:
    """What bounds the rest of a reading at a time; all (n_elements,) or (n_elements, n_elements), at p0.

    value
        The reading at p0.
    kernels, sums
        Of each extension against a force on each element: root of the integral of the squares, and bound of the
        integral of sizes, with the part that follows at once.
    read, read_at_once
        The same of the reading against a force on each element, and the part that follows at once.
    at_once
        Part of each extension that follows a force on each element at once.
    energies, now
        Root of the integral of the square of each extension up to the time, and its size at the time.
    weights
        Of the elements' own forces in the reading.
    """

    value: float
    kernels: FloatArray
    sums: FloatArray
    read: FloatArray
    read_at_once: FloatArray
    at_once: FloatArray
    energies: FloatArray
    now: FloatArray
    weights: FloatArray

    def rest(self, off: FloatArray) -> float:
        """How far the reading can be from its tangent where coefficients are off by at most `off` (n_elements,)."""
        grown = _contracted(self.sums * off, self.energies)
        if not np.isfinite(grown).all():
            return float("inf")
        at_time = self.kernels @ (off * grown)
        now = _contracted(self.at_once * off, self.now + at_time)
        moved = at_time + self.at_once @ (off * now)
        energies = self.sums @ (off * grown)
        rest = off @ (self.read * energies + (self.read_at_once + self.weights) * moved)
        return float(rest * _ROUNDING) if np.isfinite(rest) else float("inf")


def _contracted(step: FloatArray, start: FloatArray) -> FloatArray:
    """Bound of S where S <= start + step S; infinite where nothing contracts."""
    if not np.isfinite(step).all() or np.abs(np.linalg.eigvals(step)).max(initial=0.0) >= 1.0 - 1e-9:
        return np.full(len(start), np.inf)
    return np.asarray(np.linalg.solve(np.eye(len(start)) - step, start))


def nearby(machine: Transient, reading: Reading, elements: Sequence[Element], peak: Peak) -> Nearby | None:
    """Bounds of the rest at the time of `peak`; None where the reading or an element is driven by a blow or a jerk."""
    order = max(i + reading.power for i, row in enumerate((reading.row, reading.rates, reading.inertia)) if row.any())
    blown = any(segment.blows.any() for segment in machine.segments)
    if (
        order > 2
        or (reading.power and any(one.weight for one in elements))
        or (blown and any(one.kind == INERTIA for one in elements))
    ):
        return None
    own = [Reading(*_split(one), power=0) for one in elements]
    pushes = np.array([machine.root.T @ one.vector[: machine.n_free] for one in elements])
    rows = np.array([_free(machine, machine.row(one, machine.own)) for one in (*own, reading)]) / machine.scale
    kernels = _kernels(machine, pushes, rows, _time(machine, peak))
    direct = np.abs(
        np.array([_acceleration(one)[: machine.n_free] @ machine.root for one in (*own, reading)]) @ pushes.T
    )
    count, time = len(elements), _time(machine, peak)
    squares, now = _along(machine, [*own, reading], peak)
    return Nearby(
        value=float(now[-1]),
        kernels=kernels[:count],
        sums=np.sqrt(time) * kernels[:count] + direct[:count],
        read=kernels[count],
        read_at_once=direct[count],
        at_once=direct[:count],
        energies=np.sqrt(squares),
        now=np.abs(now[:-1]),
        weights=np.abs([one.weight for one in elements]),
    )


def _split(element: Element) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Rows of the positions, rates and accelerations that the coefficient multiplies."""
    rows = np.zeros((3, len(element.vector)))
    rows[_POWERS[element.kind]] = element.vector
    return rows[0], rows[1], rows[2]


def _acceleration(reading: Reading) -> FloatArray:
    """Row by which accelerations are read."""
    return np.asarray((reading.inertia, reading.rates, reading.row)[reading.power], dtype=float)


def _free(machine: Transient, row: FloatArray) -> FloatArray:
    half, n = len(machine.mass), machine.n_free
    return np.concatenate([row[:n], row[half : half + n]])


def _time(machine: Transient, peak: Peak) -> float:
    return sum(one.length for one in machine.segments[: peak.within]) + peak.part


def _kernels(machine: Transient, pushes: FloatArray, rows: FloatArray, time: float) -> FloatArray:
    """Root of the integral up to `time` of the squares of rows against impulses, (n_rows, n_elements)."""
    half, n = len(machine.mass), machine.n_free
    index = np.r_[:n, half : half + n]
    starts = np.hstack([np.zeros((len(pushes), n)), pushes / machine.rate])
    sums = _integrals(machine.own[np.ix_(index, index)], starts, machine.rate * time)
    return np.asarray(np.sqrt(np.maximum(np.einsum("ri,eij,rj->re", rows, sums, rows), 0.0) / machine.rate))


def _along(machine: Transient, readings: Sequence[Reading], peak: Peak) -> tuple[FloatArray, FloatArray]:
    """Integrals of the squares of all readings but the last up to the time (or a little later), and all at the time."""
    squares, begun = np.zeros(len(readings) - 1), 0
    state = np.zeros(machine.size)
    for alike in machine.runs:
        starts, after = machine.through(alike, state)
        a, length = machine.whole(alike[0]), alike[0].length
        rows = np.array([machine.row(one, a / (machine.rate * length)) for one in readings])
        inside = peak.within < begun + len(alike)
        kept = starts[: peak.within - begun + 1] if inside else starts
        sums = _integrals(a.T, rows[:-1], 1.0)
        squares += length * np.einsum("si,eij,sj->e", kept, sums, kept)
        if inside:
            return squares, rows @ exponential(a, peak.part / length) @ kept[-1]
        state, begun = after, begun + len(alike)
    rows = np.array([machine.row(one, machine.own) for one in readings])
    span = machine.rate * peak.part
    squares += np.einsum("i,eij,j->e", state, _integrals(machine.own.T, rows[:-1], span), state) / machine.rate
    return squares, rows @ exponential(machine.own * span) @ state


def _integrals(a: FloatArray, starts: FloatArray, span: float) -> FloatArray:
    """Integral of z z^T over times 0 to `span` with z' = a z from each of `starts` (n, N): (n, N, N)."""
    size = float(np.abs(a).sum(axis=0).max(initial=0.0)) * span
    halvings = max(0, int(np.ceil(np.log2(size)))) if size > 0.0 else 0
    step = span / 2.0**halvings
    along = series(a * step, _NODES)
    z = np.sqrt(step * _WEIGHTS)[:, None, None] * (starts @ along[:-1].transpose(0, 2, 1))
    found = np.einsum("tni,tnj->nij", z, z)
    power = along[-1]
    for _ in range(halvings):
        found = found + power @ found @ power.T
        power = power @ power
    return np.asarray(found)


__all__ = ["Element", "Nearby", "nearby"]
