"""Responses on boxes of designs where all that is chosen acts on one place of a host, as devices that hang there.

They act on the host through the sum a of their dynamic stiffnesses alone, so at a frequency any response of it is
t + q / (D + a), with numbers t, q and D of the host.  On a box the stiffness and damping of a device per its mass lie
in a rectangle of the complex plane, which a disc holds; inverses and sums of discs are discs, and so is the response.
What it is at least takes a few operations, far less than a row (`rows_on_boxes`), which says more where boxes are
small.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from vibopt.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from vibopt.forms.form import Form
from vibopt.forms.monomials import Monomials, mounts
from vibopt.mechanics.harmonic import dynamic_stiffness
from vibopt.mechanics.model import DAMPING, HYSTERETIC, INERTIA, STIFFNESS, Model, factors
from vibopt.records import dataclass
from vibopt.signals import Band

Disc = tuple[ComplexArray, FloatArray]
"""Middle and radius, each (n_boxes, n)."""
_Said = tuple[Any, ...]
"""Arrays, each (n_boxes, n)."""
_KEPT = 1_000_000
"""Numbers of one kind that are kept of a device at most [16 bytes each]."""
_ALIKE = 1e-9
"""Part of a direction by which another one may be off it and be the same."""
_BEYOND = 1e6
"""How many times as far from zero as a rectangle a disc around it may reach."""
_ILL, _ROUNDING = 1e7, 1e-11
"""Condition of a host from which on a frequency says nothing, and part of what cancels that rounding may leave."""


@dataclass(frozen=True, slots=True)
class Hung:
    """A mass on springs and dampers that hangs on the place.

    at
        Its coordinate.
    part
        How far the other end of what holds it moves when the place moves by one.
    mass, spring, damper, hysteresis, inerter
        In the variables [kg], and all but the mass per mass.
    """

    at: int
    part: float
    mass: Monomials
    spring: Monomials
    damper: Monomials
    hysteresis: Monomials
    inerter: Monomials

    @property
    def parts(self) -> tuple[Monomials, ...]:
        """All that tells what it does."""
        return self.mass, self.spring, self.damper, self.hysteresis, self.inerter

    def moved(self, low: FloatArray, high: FloatArray, w: FloatArray) -> Disc:
        """Its motion per motion of its other end on boxes (n_boxes, n_vars) at frequencies (n,) [rad/s]."""
        middle, radius = _inverse(*self._off(low, high, w))
        return 1.0 + w**2 * middle, w**2 * radius

    def apart(self, low: FloatArray, high: FloatArray, w: FloatArray) -> FloatArray:
        """How far boxes are from where it resonates, as a part of their size, (n_boxes, n); below zero within."""
        real, imaginary = self._off(low, high, w)
        with np.errstate(all="ignore"):
            beside = np.fmax(real[0], -real[1]) / (real[1] - real[0])
            above = imaginary[0] / (imaginary[1] - imaginary[0])
            return np.asarray(np.fmax(np.fmax(beside, above), -1.0))

    def _off(
        self, low: FloatArray, high: FloatArray, w: FloatArray
    ) -> tuple[tuple[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]:
        """Ends of the real and imaginary part of what holds it, per mass, less w^2: it resonates where that is zero."""
        spring, damper, hysteresis, inerter = (
            [one[:, None] for one in some.extent(low, high)]
            for some in (self.spring, self.damper, self.hysteresis, self.inerter)
        )
        return (
            (spring[0] - w**2 * (1.0 + inerter[1]), spring[1] - w**2 * (1.0 + inerter[0])),
            (hysteresis[0] + w * damper[0], hysteresis[1] + w * damper[1]),
        )


def _inverse(real: tuple[FloatArray, FloatArray], imaginary: tuple[FloatArray, FloatArray]) -> Disc:
    """A disc that holds the inverses of all in a rectangle; without end where zero is near it.

    Of a disc about c with radius r that holds the rectangle it is the disc about conj(c) / (|c|^2 - r^2) with radius
    r / (|c|^2 - r^2).  That is least where c lies on from the middle of the rectangle, away from the one or other axis.
    """
    x, y = 0.5 * (real[0] + real[1]), 0.5 * (imaginary[0] + imaginary[1])
    a, b = 0.5 * (real[1] - real[0]), 0.5 * (imaginary[1] - imaginary[0])
    room = x * x + y * y - a * a - b * b
    right, right_radius, right_room = _away(np.abs(x), a, y * y, b * b, room)
    up, up_radius, up_room = _away(np.abs(y), b, x * x, a * a, room)
    first = right_radius < up_radius
    x, y = np.where(first, x + np.sign(x) * right, x), np.where(first, y, y + np.sign(y) * up)
    radius = np.where(first, right_radius, up_radius)
    size = np.where(radius < np.inf, np.where(first, right_room, up_room), np.inf)
    return x / size - 1j * (y / size), radius


def _away(
    x: FloatArray, a: FloatArray, y_square: FloatArray, b_square: FloatArray, room: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """How far on along x the disc around a rectangle at (x, y) with half widths a and b lies whose inverse is least.

    With the radius of that, and |c|^2 - r^2; `room` is that of the disc around the middle.
    """
    near = x - a
    open_ = near * near + y_square - b_square
    with np.errstate(divide="ignore", invalid="ignore"):
        way = np.where(open_ > 0.0, 2.0 * near * b_square / open_, np.inf) - a
        way = np.where(near > 0.0, np.clip(way, 0.0, _BEYOND * near), 0.0)
        left = room + 2.0 * way * near
        return way, np.where(left > 0.0, np.sqrt((way + a) ** 2 + b_square) / left, np.inf), left


@dataclass(frozen=True, slots=True)
class Place:
    """The place of a host at which all acts that can be chosen.

    direction
        Coordinates that move it, (n_coords,).
    host, fixed
        Coordinates that are the host's (n_free,), and terms of the model that do not change (n_terms,).
    hung, plain
        What hangs there, and the kinds and coefficients of what holds or loads the place itself.
    """

    model: Model
    direction: FloatArray
    host: BoolArray
    fixed: BoolArray
    hung: tuple[Hung, ...]
    plain: tuple[tuple[int, Monomials], ...]

    def apart(self, low: FloatArray, high: FloatArray, w: FloatArray) -> FloatArray:
        """How far boxes are from where any device resonates, as a part of their size, one at most, (n_boxes, n)."""
        found = np.ones((len(low), len(w)))
        for device in self.hung:
            np.minimum(found, device.apart(low, high, w), out=found)
        return found


class Pulls:
    """Dynamic stiffness of all that acts on a place at frequencies, and what moves there, on boxes.

    Very many boxes share the ranges of one device: what it says on them is worked out once.

    Parameters
    ----------
    w
        Frequencies (n,) [rad/s].
    seen
        Devices of the place whose motion is asked for.
    """

    def __init__(self, place: Place, w: FloatArray, seen: Collection[int] = ()) -> None:
        self.many, self.seen = len(w), seen
        self._each = [
            _Ranges(device.parts, len(w), partial(_pulled_by, device, w, i in seen))
            for i, device in enumerate(place.hung)
        ]
        if place.plain:
            parts = [powers for _, powers in place.plain]
            self._each.append(_Ranges(parts, len(w), partial(_held, place.plain, w)))

    def on(self, low: FloatArray, high: FloatArray) -> tuple[Disc, dict[int, Disc]]:
        """The sum, and the motion of each device that is asked for, on boxes (n_boxes, n_vars)."""
        total, off = np.zeros((len(low), self.many), dtype=complex), np.zeros((len(low), self.many))
        moved = {}
        for i, one in enumerate(self._each):
            middle, radius, *motion = one.on(low, high)
            total += middle
            off += radius
            if motion:
                moved[i] = motion[0], motion[1]
        return (total, off), moved


class _Ranges:
    """What is said on ranges of a few of the variables, kept for each that was asked for.

    Parameters
    ----------
    parts
        All that it follows from, which tells the variables.
    say
        What is said on boxes, arrays (n_boxes, many).
    """

    def __init__(self, parts: Sequence[Monomials], many: int, say: Callable[[FloatArray, FloatArray], _Said]) -> None:
        self._own = np.flatnonzero(np.any([one.exponents.any(axis=0) for one in parts], axis=0))
        self._say, self._known = say, dict[bytes, int]()
        self._most = max(_KEPT // max(many, 1), 1)
        self._kept: _Said = ()

    def on(self, low: FloatArray, high: FloatArray) -> _Said:
        """On boxes (n_boxes, n_vars), each (n_boxes, many)."""
        ends = np.ascontiguousarray(np.concatenate([low[:, self._own], high[:, self._own]], axis=1))
        names = ends.view(f"V{ends.itemsize * ends.shape[1]}")[:, 0].tolist() if len(self._own) else [b""] * len(low)
        if len(self._known) > self._most:
            self._known.clear()
        known, fresh = self._known, list[int]()
        for box, name in enumerate(names):
            if name not in known:
                known[name] = len(known)
                fresh.append(box)
        if fresh:
            first, said = len(known) - len(fresh), self._say(low[fresh], high[fresh])
            if not self._kept:
                self._kept = tuple(np.empty((0, one.shape[1]), dtype=one.dtype) for one in said)
            self._kept = tuple(_filled(all_, first, one) for all_, one in zip(self._kept, said, strict=True))
        places = np.fromiter(map(known.__getitem__, names), dtype=np.intp, count=len(names))
        return tuple(one[places] for one in self._kept)


def _filled(table: Any, first: int, rows: Any) -> Any:
    """A table with rows from `first` on, in twice the room where there is none."""
    if first + len(rows) > len(table):
        more = np.empty((max(2 * len(table), first + len(rows)), rows.shape[1]), dtype=table.dtype)
        more[:first] = table[:first]
        table = more
    table[first : first + len(rows)] = rows
    return table


def _pulled_by(device: Hung, w: FloatArray, seen: bool, low: FloatArray, high: FloatArray) -> _Said:
    """Dynamic stiffness by which a device pulls, and where it is seen its motion: middles and radii."""
    middle, radius = device.moved(low, high, w)
    least, most = (one[:, None] for one in device.mass.extent(low, high))
    size = (w * device.part) ** 2
    pull = -0.5 * size * (least + most) * middle
    off = size * (0.5 * (most - least) * _size(middle) + most * radius)
    return (pull, off, middle, radius) if seen else (pull, off)


def _held(plain: Sequence[tuple[int, Monomials]], w: FloatArray, low: FloatArray, high: FloatArray) -> _Said:
    """Dynamic stiffness of what holds or loads the place itself."""
    total, off = np.zeros((len(low), len(w)), dtype=complex), np.zeros((len(low), len(w)))
    for kind, powers in plain:
        least, most = (one[:, None] for one in powers.extent(low, high))
        pull = factors(np.array([kind]), w)[:, 0]
        total += 0.5 * pull * (least + most)
        off += 0.5 * np.abs(pull) * (most - least)
    return total, off


def place_of(model: Model) -> Place | None:
    """Where all that can be chosen in a model acts; None where that is no one place."""
    variable = model.exponents.any(axis=1)
    if model.spun_in_time or not variable.any():
        return None
    held: dict[int, FloatArray] = {}
    for j in range(model.n_free):
        by = _held_by(model, j)
        if by is not None and not by[list(held)].any() and not any(one[j] for one in held.values()):
            held[j] = by
    owned = (model.vectors[:, list(held)] != 0.0).any(axis=1)
    if (model.scales[variable | owned] < 0.0).any():  # corrections of spans: their ranges are not those of a sum
        return None
    loose = np.flatnonzero(variable & ~owned & model.vectors.any(axis=1))
    rows = np.array([*held.values(), *model.vectors[loose]])
    if not len(rows):
        return None
    direction, size = rows[0], np.abs(rows).max(axis=1)
    parts = rows @ direction / (direction @ direction)
    if direction[model.n_free :].any() or (np.abs(rows - np.outer(parts, direction)).max(axis=1) > _ALIKE * size).any():
        return None
    host = np.ones(model.n_free, dtype=bool)
    host[list(held)] = False
    hung = tuple(_hung(model, j, float(part)) for j, part in zip(held, parts, strict=False))
    plain = tuple(
        (int(model.kinds[t]), Monomials(model.scales[[t]] * part**2, model.exponents[[t]]))
        for t, part in zip(loose, parts[len(held) :], strict=True)
    )
    return Place(model, direction, host, ~(variable | owned), hung, plain)


def _held_by(model: Model, j: int) -> FloatArray | None:
    """What moves the other end of all that holds a mass, some of which can be chosen, (n_coords,); None of others."""
    own, weighs = _terms(model, j)
    if not model.exponents[own].any() or not 0 < weighs.sum() < len(own):
        return None
    rows, mass = -model.vectors[own[~weighs]] / model.vectors[own[~weighs], j][:, None], model.exponents[own[weighs]]
    rows[:, j] = 0.0
    alike = np.abs(rows - rows[0]).max() <= _ALIKE * np.abs(rows[0]).max()
    return rows[0] if alike and rows[0].any() and (mass == mass[0]).all() else None


def _terms(model: Model, j: int) -> tuple[IntArray, BoolArray]:
    """Terms that act on a coordinate, and which of them are inertia of it alone."""
    own = np.flatnonzero(model.vectors[:, j])
    alone = np.count_nonzero(model.vectors[own], axis=1) == 1
    return own, np.asarray(alone & (model.kinds[own] == INERTIA))


def _hung(model: Model, j: int, part: float) -> Hung:
    own, weighs = _terms(model, j)
    sizes, powers = model.scales[own] * model.vectors[own, j] ** 2, model.exponents[own[weighs][0]]
    mass = float(sizes[weighs].sum())

    def per_mass(kind: int) -> Monomials:
        some = ~weighs & (model.kinds[own] == kind)
        return Monomials(sizes[some] / mass, model.exponents[own[some]] - powers)

    each = (per_mass(kind) for kind in (STIFFNESS, DAMPING, HYSTERETIC, INERTIA))
    return Hung(j, part, Monomials(np.array([mass]), powers[None]), *each)


@dataclass(frozen=True, slots=True)
class Read:
    """A response at frequencies: |t + (q + s p) / (D + a)|, p being the motion of the device `of` where that is read.

    still, pull, swing, stiff
        t, q, s and D at each frequency, (n,).
    doubt
        What rounding may take of t, (n,).
    asked
        Whether it is asked there, (n,).
    """

    still: ComplexArray
    pull: ComplexArray
    swing: ComplexArray
    stiff: ComplexArray
    doubt: FloatArray
    asked: BoolArray
    of: int

    def least(self, total: Disc, moved: Mapping[int, Disc]) -> FloatArray:
        """The greatest over frequencies of what it is at least on boxes, (n_boxes,); zero where nothing is known."""
        middle, radius = self.stiff + total[0], total[1]
        with np.errstate(all="ignore"):
            if self.of >= 0:
                there, off = moved[self.of]
                found = (_size(self.pull + self.swing * there) - np.abs(self.swing) * off) / (_size(middle) + radius)
            elif not self.still.any():
                found = np.abs(self.pull) / (_size(middle) + radius)
            else:
                room = middle.real**2 + middle.imag**2 - radius**2
                there, off = self.still + self.pull * np.conj(middle) / room, np.abs(self.pull) * radius / room
                found = np.where(room > 0.0, _size(there) - off, -off - _size(there)) - self.doubt
        return np.asarray(np.fmax(np.where(self.asked, found, 0.0), 0.0).max(axis=1))


def read(form: Form, place: Place, w: FloatArray) -> Read | None:
    """A response of the host, or of one device beside it, at frequencies (n,) [rad/s]; None of anything else."""
    harmonic, model, n = form.harmonic, place.model, place.model.n_free
    line = None if harmonic is None else harmonic.line
    if harmonic is None or line is None or harmonic.endless or line.order <= 0.0 or harmonic.output.held:
        return None
    output, devices = harmonic.output, [device.at for device in place.hung]
    shared, seen = mounts(model, output), [i for i, j in enumerate(devices) if output.row[j]]
    if len(seen) > 1 or shared.exponents.any() or output.signs[~place.fixed].any() or line.vector[devices].any():
        return None
    z = np.where(place.fixed, model.scales, 0.0) * factors(model.kinds, w)
    full, base, h = dynamic_stiffness(model, z)[:, place.host], line.vector[n:], place.direction[:n][place.host]
    rows, stiff = output.row + (output.signs * z) @ model.vectors, full[..., :n][..., place.host]
    told = np.linalg.cond(stiff) < _ILL
    stiff[~told] = np.eye(len(h))
    load = line.vector[:n][place.host] - full[..., n:] @ base
    free, by = np.moveaxis(np.linalg.solve(stiff, np.stack([load, np.broadcast_to(h, load.shape)], axis=-1)), -1, 0)
    r, drawn = rows[:, :n][:, place.host], free @ h
    give: ComplexArray = by @ h
    told &= np.abs(give) > 0.0
    give[~told] = 1.0
    parts: ComplexArray = np.array([(r * free).sum(axis=1), rows[:, n:] @ base, -(r * by).sum(axis=1) * drawn / give])
    still, doubt = parts.sum(axis=0), _ROUNDING * np.abs(parts).sum(axis=0)
    still[np.abs(still) <= doubt] = 0.0
    swing: ComplexArray = np.zeros(len(w), dtype=complex)
    if seen:
        told &= still == 0.0
        swing += output.row[devices[seen[0]]] * place.hung[seen[0]].part * drawn / give
    size = np.abs(line.amplitude.at(w / line.order)) * w**output.power / float(shared.scale.sum())
    pull: ComplexArray = -size * parts[2] / give
    stiff = np.reciprocal(give)
    told &= _asked(harmonic.bands, w / line.order)
    swing *= size
    return Read(size * still, pull, swing, stiff, size * doubt, told, seen[0] if seen else -1)


def _asked(bands: Sequence[Band], speed: FloatArray) -> BoolArray:
    near = 1.0 + 1e-12, 1.0 - 1e-12
    return np.asarray(
        np.any([(band.low <= speed * near[0]) & (speed * near[1] <= band.high) for band in bands], axis=0)
    )


def _size(z: ComplexArray) -> FloatArray:
    """Modulus, of numbers none of which is too great or too small to be squared."""
    return np.asarray(np.sqrt(z.real**2 + z.imag**2))
