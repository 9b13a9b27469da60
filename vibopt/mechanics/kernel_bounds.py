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
from vibopt.mechanics.ringing import Peak
from vibopt.mechanics.transient import Reading, Transient
from vibopt.records import dataclass

_PLACES, _SHARES = np.polynomial.legendre.leggauss(16)
_NODES, _WEIGHTS = np.append(0.5 + 0.5 * _PLACES, 1.0), 0.5 * _SHARES
_ROUNDING = 1.0 + 1e-9
_APART = 1e6
"""Condition of modes up to which they are told apart well enough to bound by."""
_SLIGHT = 1e-9
"""Fall of a mode below which it stands still."""
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
    """Bounds of the rest at the time of `peak`; None where the reading or an element is driven by a blow or a jerk,
    or what only springs hold has an open one.
    """
    order = max(i + reading.power for i, row in enumerate((reading.row, reading.rates, reading.inertia)) if row.any())
    blown = any(segment.blows.any() for segment in machine.segments)
    if (
        order > 2
        or (reading.power and any(one.weight for one in elements))
        or (blown and any(one.kind == INERTIA for one in elements))
    ):
        return None
    if machine.jointed is not None and any(one.vector[machine.jointed.quick].any() for one in elements):
        return None
    own = [Reading(*_split(one), power=0) for one in elements]
    pushes = np.array([machine.struck @ one.vector[: machine.n_free] for one in elements])
    rows = np.array([_free(machine, machine.row(one, machine.own)) for one in (*own, reading)]) / machine.scale
    count, time = len(elements), _time(machine, peak)
    kernels, sums = _kernels(machine, pushes, rows, time)
    direct = np.abs(np.array([_at_once(machine, one, pushes) for one in (*own, reading)]))
    if not np.isfinite(direct).all():
        return None
    squares, now = _along(machine, [*own, reading], peak)
    return Nearby(
        value=float(now[-1]),
        kernels=kernels[:count],
        sums=sums[:count] + direct[:count],
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


def _at_once(machine: Transient, reading: Reading, pushes: FloatArray) -> FloatArray:
    """What of a reading follows a force on each element at once, (n_elements,); infinite where its rate is felt."""
    found, half = np.zeros(len(pushes)), machine.size // 2
    for order, row in enumerate((reading.row, reading.rates, reading.inertia), start=reading.power):
        along, felt = pushes.T, np.zeros(len(pushes))
        for _ in range(order if row.any() else 0):
            found = np.where(felt != 0.0, np.inf, found)
            felt = row @ machine.places @ along[:half]
            along = machine.own @ along * machine.rate
        found = found + felt
    return found


def _free(machine: Transient, row: FloatArray) -> FloatArray:
    half, n = machine.size // 2, machine.parts[3]
    return np.concatenate([row[:n], row[half : half + n]])


def _time(machine: Transient, peak: Peak) -> float:
    return sum(one.length for one in machine.segments[: peak.within]) + peak.part


def _kernels(machine: Transient, pushes: FloatArray, rows: FloatArray, time: float) -> tuple[FloatArray, FloatArray]:
    """Of rows against impulses up to `time`: root of the integral of squares, bound of that of sizes, (n_rows, n)."""
    half, n = machine.size // 2, machine.parts[3]
    index = np.r_[:n, half : half + n]
    own, span = machine.own[np.ix_(index, index)], machine.rate * time
    starts = pushes[:, index]
    squares = np.einsum("ri,eij,rj->re", rows, _integrals(own, starts, span), rows)
    kernels = np.asarray(np.sqrt(np.maximum(squares, 0.0) / machine.rate))
    return kernels, np.minimum(np.sqrt(time) * kernels, _sizes(own, starts, rows, span) / machine.rate)


def _sizes(a: FloatArray, starts: FloatArray, rows: FloatArray, span: float) -> FloatArray:
    """Bound of the integral of |row . z| over times 0 to `span` with z' = a z from each of `starts`, mode by mode."""
    values, modes = np.linalg.eig(a)
    if np.linalg.cond(modes) > _APART:
        return np.full((len(rows), len(starts)), np.inf)
    falls = -values.real * span
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        each = span * np.where(np.abs(falls) > _SLIGHT, -np.expm1(-falls) / falls, 1.0 + np.abs(falls))
    return np.asarray(np.abs(rows @ modes) @ (each[:, None] * np.abs(np.linalg.solve(modes, starts.T))))


def _along(machine: Transient, readings: Sequence[Reading], peak: Peak) -> tuple[FloatArray, FloatArray]:
    """Integrals of the squares of all readings but the last up to the time (or a little later), and all at the time."""
    squares, begun = np.zeros(len(readings) - 1), 0
    for one in machine.stretches:
        rows = np.array([machine.row(reading, one.a / (machine.rate * one.length)) for reading in readings])
        inside = peak.within < begun + len(one.starts)
        kept = one.starts[: peak.within - begun + 1] if inside else one.starts
        sums = _integrals(one.a.T, rows[:-1], 1.0)
        squares += one.length * np.einsum("si,eij,sj->e", kept, sums, kept)
        if inside:
            return squares, rows @ exponential(one.a, peak.part / one.length) @ kept[-1]
        begun += len(one.starts)
    rows = np.array([machine.row(reading, machine.own) for reading in readings])
    span, state = machine.rate * peak.part, machine.left
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
