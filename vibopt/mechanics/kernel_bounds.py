"""A reading at one time as a function of the machine's coefficients: its tangent, and how far it can be from it.

With coefficients p that are off by d, the motion is that of the machine at p0 under further forces: d_i times what
the element i is extended by (its rate, its acceleration), on the machine as it is.  So the reading is its tangent in d,
and a rest of second order.  Schwarz and Young bound the rest: the answer to a force is never greater than the root of
the energy of its kernel times that of the force, and its own energy is no greater than the kernel's sum times the
force's.  Energies are integrals of squares up to that time, by doubling; in a run-up the greatest sizes stand in their
place, and sums of kernels for the roots.  Machines stand in a row, each with its time.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vibopt.arrays import FloatArray, IntArray
from vibopt.mechanics.model import DAMPING, INERTIA, STIFFNESS
from vibopt.mechanics.panels import exponential, halvings_of, series
from vibopt.mechanics.readout import Reading
from vibopt.mechanics.stacked import wide
from vibopt.mechanics.stretches import Stretch
from vibopt.mechanics.transient import Transient
from vibopt.records import dataclass

_PLACES, _SHARES = np.polynomial.legendre.leggauss(16)
_NODES, _WEIGHTS = np.append(0.5 + 0.5 * _PLACES, 1.0), 0.5 * _SHARES
_ROUNDING, _LOST = 1.0 + 1e-9, 1e-14
_APART = 1e6
"""Condition of modes up to which they are told apart well enough to bound by."""
_SLIGHT, _FADED, _AT_ONCE = 1e-9, 25.0, 64
"""Fall of a mode below which it stands still, and at which hardly anything of it is left; segments of lengths of their
own that are looked at together."""
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
    """What bounds the rest of a reading at a time; all (n, n_elements) or (n, n_elements, n_elements), at p0.

    value
        The reading at p0, (n,).
    kernels, sums
        Of each extension against a force on each element: root of the integral of the squares (in a run-up bound of
        that of sizes), and bound of the integral of sizes, with the part that follows at once.
    read, read_at_once
        The same of the reading against a force on each element, and the part that follows at once.
    at_once
        Part of each extension that follows a force on each element at once.
    energies, now
        Root of the integral of the square of each extension up to the time, and its size at the time; in a run-up its
        greatest size both.
    weights
        Of the elements' own forces in the reading, (n_elements,).
    """

    value: FloatArray
    kernels: FloatArray
    sums: FloatArray
    read: FloatArray
    read_at_once: FloatArray
    at_once: FloatArray
    energies: FloatArray
    now: FloatArray
    weights: FloatArray

    def rests(self, off: FloatArray) -> FloatArray:
        """How far the reading can be from its tangent where coefficients are off by at most `off`, (n, k, n_elements)
        to (n, k).
        """
        kernels, sums, at_once = self.kernels[:, None], self.sums[:, None], self.at_once[:, None]
        with np.errstate(invalid="ignore", over="ignore"):
            grown = _contracted(sums * off[..., None, :], self.energies[:, None])
            at_time = _times(kernels, off * grown)
            now = _contracted(at_once * off[..., None, :], self.now[:, None] + at_time)
            moved = at_time + _times(at_once, off * now)
            felt = self.read[:, None] * _times(sums, off * grown)
            felt += (self.read_at_once + self.weights)[:, None] * moved
            rest = (off * felt).sum(axis=-1) * _ROUNDING
        return np.where(np.isfinite(rest), rest, np.inf)


@dataclass(frozen=True, slots=True)
class Throughout:
    """What bounds second derivatives of a reading at all times; (n, n_elements) or (n, n_elements, n_elements), at p0.

    sums
        Of each extension against a force on each element: bound of the integral of the kernel's size, with what follows
        at once.
    felt
        The same of the reading, with the element's own force in it.
    greatest
        Greatest size of each extension.
    """

    sums: FloatArray
    felt: FloatArray
    greatest: FloatArray

    def rests(self, off: FloatArray) -> FloatArray:
        """How far a reading can be from what goes straight in each coefficient, off by at most `off`, (n, n_elements).

        Half of off squared times a second derivative, which is twice: the reading feels what the element is extended
        by what it feels itself.
        """
        with np.errstate(invalid="ignore", over="ignore"):
            step = self.sums * off[..., None, :]
            grown = _contracted(step, self.greatest)
            sums = np.stack([_contracted(step, one) for one in np.moveaxis(self.sums, -1, 0)], axis=-1)
            felt = self.felt + ((self.felt * off)[..., None, :] @ sums)[..., 0, :]
            rest = off**2 * felt * np.diagonal(sums, axis1=-2, axis2=-1) * grown * _ROUNDING
        return np.where(np.isfinite(rest), rest, np.inf)


def _times(matrix: FloatArray, vector: FloatArray) -> FloatArray:
    return np.asarray((matrix @ vector[..., None])[..., 0])


def _contracted(step: FloatArray, start: FloatArray) -> FloatArray:
    """Bound of S where S <= start + step S; infinite where nothing contracts."""
    count = step.shape[-1]
    known = np.isfinite(step).all(axis=(-2, -1))
    step = np.where(wide(known), step, 0.0)
    known = known & (np.abs(np.linalg.eigvals(step)).max(axis=-1, initial=0.0) < 1.0 - 1e-9)
    matrix = np.eye(count) - np.where(wide(known), step, 0.0)
    start = np.broadcast_to(start, step.shape[:-1])
    return np.where(known[..., None], np.linalg.solve(matrix, start[..., None])[..., 0], np.inf)


def nearby(
    machine: Transient, reading: Reading, elements: Sequence[Element], within: IntArray, part: FloatArray
) -> Nearby | None:
    """Bounds of the rest of each machine at a time, so many seconds `part` behind the beginning of a segment, (n,).

    None where the reading or an element is driven by a blow or a jerk, or what only springs hold has an open one.
    """
    if not boundable(machine, reading, elements):
        return None
    begins = np.cumsum([0.0, *(segment.length for segment in machine.segments)])
    squares, now = _along(machine, [*map(extension, elements), reading], within, part)
    kernels, sums, at_once = _felt(machine, reading, elements, begins[within] + part)
    return _near(elements, now[:, -1], (kernels, sums, at_once), np.sqrt(squares), np.abs(now[:, :-1]))


def swept(
    machine: Transient,
    reading: Reading,
    elements: Sequence[Element],
    times: FloatArray,
    value: FloatArray,
    sizes: FloatArray,
) -> Nearby | None:
    """The same in a run-up, at a time so many seconds behind what moves the machine, by the reading's value there.

    times, value
        (n,).
    sizes
        Greatest size of each extension up to the time, (n, n_elements).
    """
    if not boundable(machine, reading, elements):
        return None
    _, sums, at_once = _felt(machine, reading, elements, times)
    return _near(elements, value, (sums, sums, at_once), sizes, sizes)


def throughout(
    machine: Transient, reading: Reading, elements: Sequence[Element], last: FloatArray, greatest: FloatArray
) -> Throughout | None:
    """Bounds at all times up to `last` (n,), which may be infinite; None as of `nearby`.

    greatest
        Greatest size of each extension, (n, n_elements).
    """
    if not boundable(machine, reading, elements):
        return None
    _, sums, at_once = _felt(machine, reading, elements, last)
    sums, count = sums + at_once, len(elements)
    weights = np.abs([element.weight for element in elements])
    return Throughout(sums[:, :count], sums[:, count] + weights, greatest)


def boundable(machine: Transient, reading: Reading, elements: Sequence[Element]) -> bool:
    """Whether anything bounds the rest: not where the reading or an element is driven by a blow or a jerk."""
    order = max(i + reading.power for i, row in enumerate((reading.row, reading.rates, reading.inertia)) if row.any())
    blown = np.any([segment.blows for segment in machine.segments], axis=0)
    struck = np.abs(machine.loads) @ blown > 0.0  # no mass is, where a base jumps to another velocity
    if (
        order > 2
        or (reading.power and any(element.weight for element in elements))
        or any(element.kind == INERTIA and element.vector[struck].any() for element in elements)
    ):
        return False
    hung = machine.jointed
    return hung is None or not any(element.vector[hung.quick].any() for element in elements)


def _near(
    elements: Sequence[Element],
    value: FloatArray,
    felt: tuple[FloatArray, FloatArray, FloatArray],
    energies: FloatArray,
    now: FloatArray,
) -> Nearby:
    """Of kernels, sums and what follows at once, of extensions and reading (n, n_elements + 1, n_elements) each."""
    (kernels, sums, at_once), count = felt, len(elements)
    return Nearby(
        value=value,
        kernels=kernels[:, :count],
        sums=sums[:, :count] + at_once[:, :count],
        read=kernels[:, count],
        read_at_once=at_once[:, count],
        at_once=at_once[:, :count],
        energies=energies,
        now=now,
        weights=np.abs([element.weight for element in elements]),
    )


def _felt(
    machine: Transient, reading: Reading, elements: Sequence[Element], times: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    vectors = np.array([element.vector[: machine.n_free] for element in elements])
    pushes = (machine.struck @ vectors.T).mT
    _, first, same = np.unique(vectors, axis=0, return_index=True, return_inverse=True)  # spring and damper push alike
    same, every = same.ravel(), [*map(extension, elements), reading]
    rows = _rows(machine, every, machine.own) / wide(machine.scale)
    kernels, sums = (one[..., same] for one in _kernels(machine, pushes[:, first], rows, times))
    return kernels, sums, np.abs(np.stack([_at_once(machine, one, pushes) for one in every], axis=1))


def extension(element: Element) -> Reading:
    """What a coefficient multiplies: an extension, its rate or its acceleration."""
    rows = np.zeros((3, len(element.vector)))
    rows[_POWERS[element.kind]] = element.vector
    return Reading(rows[0], rows[1], rows[2])


def _rows(machine: Transient, readings: Sequence[Reading], a: FloatArray) -> FloatArray:
    """Of each reading over the states, (n, n_readings, N), or on each of k segments (n, k, n_readings, N)."""
    return np.stack([machine.row(reading, a) for reading in readings], axis=-2)


def _at_once(machine: Transient, reading: Reading, pushes: FloatArray) -> FloatArray:
    """What of a reading follows a force on each element at once, (n, n_elements); infinite where its rate is felt."""
    found, half = np.zeros(pushes.shape[:2]), machine.size // 2
    for order, row in enumerate((reading.row, reading.rates, reading.inertia), start=reading.power):
        along, felt = pushes.mT, np.zeros(found.shape)
        for _ in range(order if row.any() else 0):
            found = np.where(felt != 0.0, np.inf, found)
            felt = (row[..., None, :] @ machine.places @ along[:, :half])[:, 0]
            along = machine.own @ along * wide(machine.rate)
        found = found + felt
    return found


def _kernels(
    machine: Transient, pushes: FloatArray, rows: FloatArray, times: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Of rows against impulses up to `times`: root of the integral of squares, bound of that of sizes.

    Both (n, n_rows, n_elements).
    """
    half, n = machine.size // 2, machine.parts[3]
    index = np.r_[:n, half : half + n]
    own, rate = machine.own[:, index[:, None], index], machine.rate
    starts, rows, spans = pushes[..., index], rows[..., index], rate * times
    endless = np.isinf(spans)
    until = np.where(endless, _faded(own), spans)
    integrals = _integrals(own, starts, until)
    squares = ((rows[:, None] @ integrals) * rows[:, None]).sum(axis=-1).mT
    roots = np.sqrt(np.maximum(squares, 0.0))
    sizes, later = _sizes(own, starts, rows, spans, until)
    sums = np.minimum(wide(np.sqrt(until)) * roots + later, sizes) / wide(rate)
    return np.asarray(np.where(wide(endless), np.inf, roots / wide(np.sqrt(rate)))), sums


def _faded(a: FloatArray) -> FloatArray:
    """A time at which hardly anything is left of z' = a z, (n,); some time where it is not damped."""
    slowest = -np.linalg.eigvals(a).real.max(axis=-1)
    return np.asarray(_FADED / np.where(slowest > _SLIGHT, slowest, 1.0))


def _sizes(
    a: FloatArray, starts: FloatArray, rows: FloatArray, spans: FloatArray, until: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Bounds of the integral of |row . z| over times 0 to a span with z' = a z from each of `starts`, mode by mode.

    Of all of it, and of what comes later than `until`.  What a mode and its conjugate add is a cosine that fades: of
    each half turn no more than 2, faded at its beginning.
    """
    values, modes = np.linalg.eig(a)
    apart = np.linalg.cond(modes) <= _APART
    modes = np.where(wide(apart), modes, np.eye(a.shape[-1]))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        falls = -values.real * spans[:, None]
        slow = np.where(np.abs(falls) > _SLIGHT, np.expm1(-falls) / values.real, spans[:, None] * (1.0 + np.abs(falls)))
        half = np.pi / np.abs(values.imag)
        waves = 2.0 / np.pi * half * np.expm1(values.real * half * np.ceil(spans[:, None] / half))
        waves = np.abs(waves / np.expm1(values.real * half))
        long = np.fmin(slow, waves)  # nan where nothing turns or fades
        each = np.abs(np.linalg.solve(modes, starts.mT.astype(modes.dtype)))
        seen = np.abs(rows @ modes)
        left = np.exp(values.real * until[:, None])
        found = [np.where(wide(apart), seen @ (each * one[..., None]), np.inf) for one in (long, left * long)]
    return found[0], np.where(wide(spans > until), found[1], 0.0)


def _along(
    machine: Transient, readings: Sequence[Reading], within: IntArray, part: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Integrals of the squares of all readings but the last up to the time (or a little later), and all at the time."""
    count = len(within)
    squares, now, begun = np.zeros((count, len(readings) - 1)), np.zeros((count, len(readings))), 0
    for stretch in machine.stretches:
        kept = stretch.starts * (np.arange(stretch.count) <= (within - begun)[:, None])[..., None]
        squares += _on_stretch(machine, readings[:-1], stretch, kept)
        inside = (within >= begun) & (within < begun + stretch.count)
        if inside.any():
            a, length, start = stretch.of(np.clip(within - begun, 0, stretch.count - 1))
            rows, step = _rows(machine, readings, a / wide(machine.rate * length)), exponential(a * wide(part / length))
            now = np.where(inside[:, None], (rows @ step @ start[..., None])[..., 0], now)
        begun += stretch.count
    behind = within >= begun
    if not behind.any():
        return squares, now
    a, state = machine.onward(machine.left)
    rows, spans = _rows(machine, readings, a), machine.rate * np.where(behind, part, 0.0)
    squares += _squares(a, rows[:, :-1], state[:, None], spans) / machine.rate[:, None]
    moved = (rows @ exponential(a * wide(spans)) @ state[..., None])[..., 0]
    return squares, np.where(behind[:, None], moved, now)


def _on_stretch(machine: Transient, readings: Sequence[Reading], stretch: Stretch, starts: FloatArray) -> FloatArray:
    """Integrals of the squares of readings over a stretch from other starts (n, k, N): (n, n_readings)."""
    if not stretch.uneven:
        rows = _rows(machine, readings, stretch.a / wide(machine.rate * stretch.length))
        return np.asarray(stretch.length * _squares(stretch.a, rows, starts, np.ones(len(starts))))
    found = np.zeros((len(starts), len(readings)))
    for first in range(0, stretch.count, _AT_ONCE):
        some = slice(first, first + _AT_ONCE)
        a, length = stretch.a[:, some], stretch.length[some]
        rows = _rows(machine, readings, a / wide(machine.rate[:, None] * length))
        a, rows, each = (one.reshape(-1, *one.shape[2:]) for one in (a, rows, starts[:, some, None]))
        squares = _squares(a, rows, each, np.ones(len(a))).reshape(len(starts), len(length), -1)
        found += (length[:, None] * squares).sum(axis=1)
    return found


def _squares(a: FloatArray, rows: FloatArray, starts: FloatArray, spans: FloatArray) -> FloatArray:
    """Integral of (row . z)^2 over times 0 to a span with z' = a z, of all starts (n, k, N) together: (n, n_rows).

    With what rounding may have taken: where a reading is nothing beside what it is the difference of, that is all.
    """
    if starts.shape[1] <= rows.shape[1]:
        moved = _integrals(a, starts, spans).sum(axis=1)
        found, size = (((r @ m) * r).sum(axis=-1) for r, m in _and_size(rows, moved))
    else:
        seen = _integrals(a.mT, rows, spans)
        found, size = (np.einsum("nsi,nsj,neij->ne", s, s, m, optimize=True) for s, m in _and_size(starts, seen))
    return np.asarray(np.maximum(found, 0.0) + _LOST * size)


def _and_size(some: FloatArray, others: FloatArray) -> tuple[tuple[FloatArray, FloatArray], ...]:
    return (some, others), (np.abs(some), np.abs(others))


def _integrals(a: FloatArray, starts: FloatArray, spans: FloatArray) -> FloatArray:
    """Integral of z z^T over times 0 to a span with z' = a z from each of `starts` (n, k, N): (n, k, N, N)."""
    halvings = halvings_of(a * wide(spans))
    steps = spans / 2.0**halvings
    along = series(a * wide(steps), _NODES)
    z = starts[:, None] @ along[:, :-1].mT  # (n, times, k, N)
    z = (z * np.sqrt(steps[:, None] * _WEIGHTS)[..., None, None]).transpose(0, 2, 3, 1)
    found, power = z @ z.mT, along[:, -1]
    for done in range(int(halvings.max(initial=0))):
        more = halvings > done
        doubled = found + power[:, None] @ found @ power[:, None].mT
        found = doubled if more.all() else np.where(wide(more)[..., None], doubled, found)
        power = power @ power if more.all() else np.where(wide(more), power @ power, power)
    return np.asarray(found)
