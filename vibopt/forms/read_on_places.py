"""What responses are at least on boxes of designs where all that is chosen acts on a few places of a host.

With a pull a_i at each place, a response at a frequency is N / D, both affine in each pull and in the stroke of a
device that is read: sums over sets of them of a number of the host times their product.  On a box each lies in a disc,
so N and D lie in discs about their middles, and so does N - (N / D of the middles) D, which is next to nothing where
boxes are small.  With one pull the disc of the response is exact.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from vibopt.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from vibopt.forms.form import Form
from vibopt.forms.hung_on_boxes import Disc, Hosted, modulus
from vibopt.forms.monomials import mounts
from vibopt.mechanics.harmonic import dynamic_stiffness
from vibopt.mechanics.model import Model, factors
from vibopt.records import dataclass
from vibopt.signals import Band, Output

Sets = dict[int, ComplexArray]
"""Numbers at frequencies (n,), each of a set of unknowns that it goes with: bit i is that of unknown i."""
Doubts = dict[int, FloatArray]
"""What rounding may take of numbers at frequencies (n,), by their sets."""
_Known = tuple[ComplexArray, FloatArray]
"""Numbers, and how far rounding may have moved each."""
_ILL, _ROUNDING, _CANCELS = 1e7, 1e-11, 1e-5
"""Condition of a host from which on a frequency says nothing, part of what cancels that rounding may leave, and what is
left of it from which on that does not matter."""
_DIGITS, _KNOWN = 4.0 * float(np.finfo(float).eps), 1e-10
"""Part of each summand that rounding may take of a solution, and part of a number by which it may be off."""
_TOGETHER = 256
"""Boxes whose numbers stay near the processor."""
_ALIKE = 1e-9
"""Part by which two factors may differ and be the same."""


@dataclass(frozen=True, slots=True)
class Read:
    """A response at frequencies: |N / D|.

    top, bottom
        Numbers of N and D; the first unknowns are the pulls of the places, the last one the stroke of what is read.
    top_doubt, bottom_doubt
        What rounding may take of those of them that are far less than what they are made of, (n,).
    asked
        Whether it is asked there, (n,).
    of
        The device whose motion is read; -1 where none is.
    held
        The pull at each place from which on pulls are counted, (n,): it holds a host that nothing holds without it.
    """

    top: Sets
    bottom: Sets
    top_doubt: Doubts
    bottom_doubt: Doubts
    asked: BoolArray
    of: int
    held: ComplexArray

    def least(self, pulls: Sequence[Disc], moved: Mapping[int, Disc]) -> FloatArray:
        """The greatest over frequencies of what it is at least on boxes, (n_boxes,); zero where nothing is known."""
        discs = list(pulls)
        if self.held.any():
            discs = [(middle - self.held, radius + _DIGITS * np.abs(self.held)) for middle, radius in discs]
        discs += [moved[self.of]] if self.of >= 0 else []
        of_few = self._of_one if len(discs) == 1 and 1 in self.bottom else self._of_several
        found = np.zeros(len(discs[0][0]))
        with np.errstate(all="ignore"):
            for at in range(0, len(found), _TOGETHER):
                some = slice(at, at + _TOGETHER)
                each = of_few([(middle[some], radius[some]) for middle, radius in discs])
                found[some] = np.fmax(np.where(self.asked, each, 0.0), 0.0).max(axis=1)
        return found

    def _of_one(self, discs: Sequence[Disc]) -> FloatArray:
        """Of t + q / (d + a), each (n_boxes, n)."""
        ((pull, radius),) = discs
        stiff, first = 1.0 / self.bottom[1], self.top.get(0, 0.0)
        still = self.top.get(1, 0.0) * stiff
        q, off, off_still, off_q = (first - still) * stiff, *self._off_of_one(np.abs(stiff), first - still)
        middle, radius = stiff + pull, radius + off
        if not np.any(still) and not np.any(off_still):
            return np.asarray((np.abs(q) - off_q) / (modulus(middle) + radius))
        room = middle.real**2 + middle.imag**2 - radius**2
        there, reach = still + q * np.conj(middle) / room, np.abs(q) * radius / room
        found = np.where(room > 0.0, modulus(there) - reach, -reach - modulus(there))
        if np.any(off_q):
            part = off_q / np.abs(q)
            turned = np.where(part < 1.0, part * (found + 2.0 * np.abs(still)), np.inf)
            found -= np.fmin(turned, np.where(room > 0.0, off_q / (modulus(middle) - radius), np.inf))
        return np.asarray(found - off_still)

    def _off_of_one(self, stiff: FloatArray, left: Any) -> tuple[Any, Any, Any]:
        """How far d, t and q of t + q / (d + a) may be off, for the size of d and what is `left` of q beside it."""
        part = self.bottom_doubt.get(1, 0.0) * stiff
        off = np.where(part < 1.0, stiff * part / (1.0 - part), np.inf)
        still = self.top_doubt.get(1, 0.0) * (stiff + off) + np.abs(self.top.get(1, 0.0)) * off
        return off, still, (self.top_doubt.get(0, 0.0) + still) * (stiff + off) + np.abs(left) * off

    def _of_several(self, discs: Sequence[Disc]) -> FloatArray:
        """The greater of |N| at least over |D| at most, and of what N / D is off what it is at the middles."""
        top, bottom = _about(self.top, discs), _about(self.bottom, discs)
        reach = _reach([radius for _, radius in discs])
        above, below = (modulus(np.asarray(one.get(0, 0.0j))) for one in (top, bottom))
        doubt, lost = np.zeros(below.shape), np.zeros(below.shape)
        if self.top_doubt or self.bottom_doubt:
            far = _reach([modulus(middle) + radius for middle, radius in discs])
            for key, size in self.top_doubt.items():
                doubt += size * far[key]
            for key, size in self.bottom_doubt.items():
                lost += size * far[key]
        wide = _spread(bottom, reach) + lost
        first = (above - _spread(top, reach) - doubt) / (below + wide)
        ratio = top.get(0, 0.0) / bottom[0]
        off = {key: top.get(key, 0.0) - ratio * bottom.get(key, 0.0) for key in top.keys() | bottom.keys()}
        second = modulus(ratio) - (_spread(off, reach) + doubt + modulus(ratio) * lost) / (below - wide)
        return np.asarray(np.fmax(first, np.where(below > wide, second, 0.0)))


def _about(sets: Sets, discs: Sequence[Disc]) -> dict[int, ComplexArray]:
    """The numbers of how far the unknowns are off their middles, each (n_boxes, n)."""
    found: dict[int, ComplexArray] = dict(sets)
    for i, (middle, _) in enumerate(discs):
        for key in [key for key in found if key >> i & 1]:
            rest = key ^ (1 << i)
            found[rest] = found[rest] + middle * found[key] if rest in found else middle * found[key]
    return found


def _spread(sets: Mapping[int, Any], reach: Sequence[FloatArray]) -> FloatArray:
    """How far the sum over all sets but the empty one may be off zero, (n_boxes, n)."""
    found = np.zeros(reach[0].shape)
    for key, number in sets.items():
        if key:
            found += modulus(number) * reach[key]
    return found


def _reach(sizes: Sequence[FloatArray]) -> list[FloatArray]:
    """The product of sizes over each set, (n_boxes, n)."""
    found = [np.ones(sizes[0].shape)]
    for size in sizes:
        found += [one * size for one in found]
    return found


def read(form: Form, hosted: Hosted, w: FloatArray) -> Read | None:
    """A response of the host, of one device beside it or of what is chosen at a place; None of anything else.

    At frequencies w (n,) [rad/s].
    """
    harmonic, model, n = form.harmonic, hosted.model, hosted.model.n_free
    line = None if harmonic is None else harmonic.line
    if harmonic is None or line is None or harmonic.endless or line.order <= 0.0 or harmonic.output.held:
        return None
    output, devices = harmonic.output, [device.at for _, device in hosted.devices]
    shared, seen = mounts(model, output), [i for i, j in enumerate(devices) if output.row[j]]
    forces = _forces(hosted, output)
    if forces is None or len(seen) > 1 or shared.exponents.any() or line.vector[devices].any():
        return None
    z = np.where(hosted.fixed, model.scales, 0.0) * factors(model.kinds, w)
    full, base = dynamic_stiffness(model, z)[:, hosted.host], line.vector[n:]
    carried = [output.row[device.at] * device.part * hosted.places[i].direction for i, device in hosted.devices]
    rows, stiff = (output.signs * z) @ model.vectors + sum(carried, output.row), full[..., :n][..., hosted.host]
    load = line.vector[:n][hosted.host] - full[..., n:] @ base
    H = np.array([place.direction[:n][hosted.host] for place in hosted.places])
    borne = np.array([place.direction[n:] @ base for place in hosted.places])
    size = np.abs(stiff).max(axis=(1, 2))
    held = np.where(np.linalg.cond(stiff) < _ILL, 0.0, 1j * np.where(size > 0.0, size, w**2))
    stiff = stiff + held[:, None, None] * (H.T @ H)
    load = load - held[:, None] * (borne @ H)
    told = np.linalg.cond(stiff) < _ILL
    stiff[~told] = np.eye(stiff.shape[-1])
    sides = np.concatenate([load[..., None], np.broadcast_to(H.T, (len(w), *H.T.shape))], axis=-1)
    sizes = _sizes(model, z)
    far = np.abs(sides)
    far[..., 0] = np.abs(line.vector[:n])[hosted.host] + (sizes[..., n:] @ np.abs(base))[:, hosted.host]
    sizes = sizes[:, hosted.host][..., :n][..., hosted.host] + np.abs(held)[:, None, None] * (np.abs(H).T @ np.abs(H))
    solved, lost = _solved(stiff, sizes, sides, far)
    read_by = np.abs(sum(carried, output.row)) + np.abs(output.signs * z) @ np.abs(model.vectors)
    own = _read(rows[:, None, :n][..., hosted.host], read_by[:, None, :n][..., hosted.host], solved, lost)
    own[0][..., 0] += rows[:, None, n:] @ base
    there = _read(H, np.abs(H), solved, lost)
    there[0][..., 0] += borne
    for i, size in forces.items():
        own[0][:, 0] += size * held[:, None] * there[0][:, i]
        own[1][:, 0] += abs(size) * np.abs(held)[:, None] * there[1][:, i]
    top, bottom, every = _Sums(), _Sums(), range(1 << len(H))
    for key in every:
        some = _members(key)
        bottom.add(key, *_determinant(there[0][:, some][:, :, 1 + some], there[1][:, some][:, :, 1 + some]))
        top.add(key, *_bordered(own, there, key))
    read_off = [(i, 1 << i, size) for i, size in forces.items()]
    for at in seen:
        i, device = hosted.devices[at]
        read_off.append((i, 1 << len(H), float(output.row[device.at]) * device.part))
    for i, bit, size in read_off:
        for key in every:
            if not key >> i & 1:
                top.add(key | bit, *_bordered((there[0][:, [i]], there[1][:, [i]]), there, key, size))
    gain = np.abs(line.amplitude.at(w / line.order)) * w**output.power / float(shared.scale.sum())
    told &= _asked(harmonic.bands, w / line.order)
    (over, doubt), (under, off) = (
        one.told(by, all_doubts=bool(held.any())) for one, by in ((top, gain), (bottom, np.ones(len(w))))
    )
    return Read(over, under, doubt, off, told, seen[0] if seen else -1, held)


def _sizes(model: Model, z: ComplexArray) -> FloatArray:
    """What the dynamic stiffness is made of: the sum of the sizes of all terms, (n, n_free, n_coords)."""
    rows = np.abs(model.vectors)
    return np.asarray(np.matmul(rows.T[: model.n_free] * np.abs(z)[..., None, :], rows))


def _solved(stiff: ComplexArray, size: FloatArray, sides: ComplexArray, far: FloatArray) -> _Known:
    """Motions (n, n_host, k) under sides, refined once, of a stiffness and of sides whose summands have these sizes."""
    inverse = np.linalg.inv(stiff)
    found = inverse @ sides
    found += inverse @ (sides - stiff @ found)
    return found, _DIGITS * (np.abs(inverse) @ (size @ np.abs(found) + far))


def _read(rows: Any, sizes: Any, solved: ComplexArray, lost: FloatArray) -> _Known:
    """What rows (..., m, n_host) whose summands have these sizes read of motions, (n, m, k)."""
    return rows @ solved, sizes @ (lost + _DIGITS * np.abs(solved))


def _forces(hosted: Hosted, output: Output) -> dict[int, float] | None:
    """How much of the pull at each place is read; None where it is of no such part, or of what a device is held by."""
    found, rest = dict[int, float](), np.flatnonzero(output.signs * ~hosted.fixed).tolist()
    for i, place in enumerate(hosted.places):
        sizes = np.array([output.signs[term] / part for _, _, part, term in place.plain])
        if sizes.any():
            if np.abs(sizes - sizes[0]).max() > _ALIKE * abs(sizes[0]):
                return None
            found[i] = float(sizes[0])
            rest = [term for term in rest if term not in [one[-1] for one in place.plain]]
    return None if rest else found


class _Sums:
    """Numbers of sets, with the sizes of what they are made of, and how far what was solved may have moved them."""

    def __init__(self) -> None:
        self.each: dict[int, tuple[ComplexArray, FloatArray, FloatArray]] = {}

    def add(self, key: int, number: ComplexArray, size: FloatArray, lost: FloatArray) -> None:
        if key in self.each:
            before = self.each[key]
            number, size, lost = number + before[0], size + before[1], lost + before[2]
        self.each[key] = number, size, lost

    def told(self, gain: FloatArray, *, all_doubts: bool) -> tuple[Sets, Doubts]:
        """Those that are not rounding alone, and what it may take of them where they are next to nothing, or of all."""
        sets, doubts = Sets(), Doubts()
        if all_doubts:
            for key, (number, size, lost) in self.each.items():
                sets[key], doubts[key] = gain * number, gain * (_DIGITS * size + lost)
            return sets, doubts
        for key, (number, size, lost) in self.each.items():
            real = np.abs(number) > _ROUNDING * size
            if real.any():
                sets[key] = np.where(real, gain * number, 0.0)
                if ((np.abs(number) < _CANCELS * size) | (lost > _KNOWN * np.abs(number))).any():
                    doubts[key] = gain * (_ROUNDING * size + lost)
        return sets, doubts


def _members(key: int) -> IntArray:
    return np.array([i for i in range(key.bit_length()) if key >> i & 1], dtype=int)


def _bordered(first: _Known, there: _Known, key: int, size: float = 1.0) -> tuple[ComplexArray, FloatArray, FloatArray]:
    """The number of a reading `first` (n, 1, 1 + n_places) that goes with the places of a set, as `_determinant`.

    Numbers of the load alone stand first, then those of a force of one at each place.
    """
    some = _members(key)
    columns = np.concatenate([[0], 1 + some])
    rows, lost = (np.concatenate([a, b[:, some]], axis=1)[..., columns] for a, b in zip(first, there, strict=True))
    number, parts, off = _determinant(rows, lost)
    return size * number, abs(size) * parts, abs(size) * off


def _determinant(matrices: ComplexArray, lost: FloatArray) -> tuple[ComplexArray, FloatArray, FloatArray]:
    """Determinants of (n, k, k), the sums of the sizes of their terms, and how far they are off, each (n,).

    `lost` is how far each entry may be off.
    """
    n, k = len(matrices), matrices.shape[-1]
    if not k:
        return np.ones(n, dtype=complex), np.ones(n), np.zeros(n)
    number, parts, off = np.zeros(n, dtype=complex), np.zeros(n), np.zeros(n)
    for j in range(k):
        rest = np.arange(k) != j
        minor, size, less = _determinant(matrices[:, 1:][..., rest], lost[:, 1:][..., rest])
        own = np.abs(matrices[:, 0, j])
        number += (-1) ** j * matrices[:, 0, j] * minor
        parts += own * size
        off += own * less + lost[:, 0, j] * (np.abs(minor) + less)
    return number, parts, off


def _asked(bands: Sequence[Band], speed: FloatArray) -> BoolArray:
    near = 1.0 + 1e-12, 1.0 - 1e-12
    return np.asarray(
        np.any([(band.low <= speed * near[0]) & (speed * near[1] <= band.high) for band in bands], axis=0)
    )
