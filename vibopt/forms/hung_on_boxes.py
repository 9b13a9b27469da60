"""What is chosen of a machine as devices that act on a few places of a host, and its dynamic stiffness on boxes.

They act on the host through the sum of their dynamic stiffnesses at each place alone.  On a box the stiffness and
damping of a device per its mass lie in a rectangle of the complex plane, which a disc holds; inverses and sums of discs
are discs.  What responses are at least follows (`read_on_places`).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from functools import partial
from typing import Any

import numpy as np

from vibopt.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from vibopt.forms.monomials import Monomials
from vibopt.mechanics.model import DAMPING, HYSTERETIC, INERTIA, STIFFNESS, Model, factors
from vibopt.records import cached_property, dataclass

Disc = tuple[ComplexArray, FloatArray]
"""Middle and radius, each (n_boxes, n)."""
_Said = tuple[Any, ...]
"""Arrays, each (n_boxes, n)."""
_KEPT = 1_000_000
"""Numbers of one kind that are kept of a device at most [16 bytes each]."""
_ALIKE = 1e-9
"""Part of a direction by which another one may be off it and be the same."""
PLACES = 4
"""So many at most: each doubles the work."""
_DIGITS = 4.0 * float(np.finfo(float).eps)
"""Part of a number that rounding may take."""
_BEYOND = 1e6
"""How many times as far from zero as a rectangle a disc around it may reach."""


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

    def stroke(self, low: FloatArray, high: FloatArray, w: FloatArray) -> Disc:
        """How far it moves against its other end per motion of that, at frequencies (n,) [rad/s].

        On boxes (n_boxes, n_vars).  Where the device is stiff this is known to more digits than its motion.
        """
        middle, radius = _inverse(*self._off(low, high, w))
        return w**2 * middle, w**2 * radius

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
    """One place of a host at which something acts that can be chosen.

    direction
        Coordinates that move it, (n_coords,).
    hung, plain
        What hangs there, and what holds or loads the place itself: kind, coefficients, how far it moves when the place
        moves by one, and its term of the model.
    """

    direction: FloatArray
    hung: tuple[Hung, ...]
    plain: tuple[tuple[int, Monomials, float, int], ...]


@dataclass(frozen=True)
class Hosted:
    """A machine as a host, with the places at which all acts that can be chosen.

    host, fixed
        Coordinates that are the host's (n_free,), and terms of the model that do not change (n_terms,).
    """

    model: Model
    host: BoolArray
    fixed: BoolArray
    places: tuple[Place, ...]

    @cached_property
    def devices(self) -> list[tuple[int, Hung]]:
        """All that hangs, with its place."""
        return [(i, device) for i, place in enumerate(self.places) for device in place.hung]

    def apart(self, low: FloatArray, high: FloatArray, w: FloatArray) -> FloatArray:
        """How far boxes are from where any device resonates, as a part of their size, one at most, (n_boxes, n)."""
        found = np.ones((len(low), len(w)))
        for _, device in self.devices:
            np.minimum(found, device.apart(low, high, w), out=found)
        return found


class Pulls:
    """Dynamic stiffness of all that acts on each place at frequencies, and the strokes of devices, on boxes.

    Very many boxes share the ranges of one device: what it says on them is worked out once.

    Parameters
    ----------
    w
        Frequencies (n,) [rad/s].
    seen
        Devices whose stroke is asked for.
    """

    def __init__(self, hosted: Hosted, w: FloatArray, seen: Collection[int] = ()) -> None:
        self.many, self.places = len(w), len(hosted.places)
        self._each = [
            (
                place,
                None if i not in seen else i,
                _Ranges(device.parts, len(w), partial(_pulled_by, device, w, i in seen)),
            )
            for i, (place, device) in enumerate(hosted.devices)
        ]
        for i, place in enumerate(hosted.places):
            if place.plain:
                parts = [one[1] for one in place.plain]
                self._each.append((i, None, _Ranges(parts, len(w), partial(_held, place.plain, w))))

    def on(self, low: FloatArray, high: FloatArray) -> tuple[list[Disc], dict[int, Disc]]:
        """The sum at each place, and the stroke of each device that is asked for, on boxes (n_boxes, n_vars)."""
        totals: list[Any] = [None] * self.places
        moved = {}
        for place, seen, ranges in self._each:
            middle, radius, *motion = ranges.on(low, high)
            if totals[place] is None:
                totals[place] = middle, radius
            else:
                totals[place] = totals[place][0] + middle, totals[place][1] + radius
            if seen is not None:
                moved[seen] = motion[0], motion[1]
        return totals, moved


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
    """Dynamic stiffness by which a device pulls, and where it is seen its stroke: middles and radii."""
    stroke, radius = device.stroke(low, high, w)
    middle = 1.0 + stroke
    least, most = (one[:, None] for one in device.mass.extent(low, high))
    size = (w * device.part) ** 2
    pull = -0.5 * size * (least + most) * middle
    off = size * (0.5 * (most - least) * modulus(middle) + most * (radius + _DIGITS * (1.0 + modulus(stroke))))
    return (pull, off, stroke, radius + _DIGITS * modulus(stroke)) if seen else (pull, off)


def _held(
    plain: Sequence[tuple[int, Monomials, float, int]], w: FloatArray, low: FloatArray, high: FloatArray
) -> _Said:
    """Dynamic stiffness of what holds or loads the place itself."""
    total, off = np.zeros((len(low), len(w)), dtype=complex), np.zeros((len(low), len(w)))
    for kind, powers, *_ in plain:
        least, most = (one[:, None] for one in powers.extent(low, high))
        pull = factors(np.array([kind]), w)[:, 0]
        total += 0.5 * pull * (least + most)
        off += np.abs(pull) * (0.5 * (most - least) + _DIGITS * most)
    return total, off


def places_of(model: Model, load: ComplexArray, signs: FloatArray) -> Hosted | None:
    """The places at which all acts that can be chosen in a model; None where they are many, or anything else is.

    Coordinates of which `load` (n_coords,) is not zero are the host's, and what is chosen and whose force is read, as
    `signs` (n_terms,) say, has a place of its own beside what else acts there.
    """
    variable = model.exponents.any(axis=1)
    if model.spun_in_time or not variable.any():
        return None
    held: dict[int, FloatArray] = {}
    for j in range(model.n_free):
        by = None if load[j] or any(one[j] for one in held.values()) else _held_by(model, j)
        if by is not None and by[: model.n_free].any() and not by[list(held)].any():
            held[j] = by
    owned = (model.vectors[:, list(held)] != 0.0).any(axis=1)
    if (model.scales[variable | owned] < 0.0).any():  # corrections of spans: their ranges are not those of a sum
        return None
    loose = np.flatnonzero(variable & ~owned & model.vectors.any(axis=1))
    places: list[tuple[FloatArray, list[Hung], list[tuple[int, Monomials, float, int]]]] = []
    is_read = list[bool]()
    for row, j, term in [(by, j, -1) for j, by in held.items()] + [(model.vectors[t], -1, int(t)) for t in loose]:
        own = term >= 0 and bool(signs[term])
        at, part = _found([one[0] if own is read else None for one, read in zip(places, is_read, strict=True)], row)
        if at == len(places):
            places.append((row, [], []))
            is_read.append(own)
        if term < 0:
            places[at][1].append(_hung(model, j, part))
        else:
            size = Monomials(model.scales[[term]] * part**2, model.exponents[[term]])
            places[at][2].append((int(model.kinds[term]), size, part, term))
    if not 0 < len(places) <= PLACES:
        return None
    host = np.ones(model.n_free, dtype=bool)
    host[list(held)] = False
    each = tuple(Place(direction, tuple(hung), tuple(plain)) for direction, hung, plain in places)
    return Hosted(model, host, ~(variable | owned), each)


def _found(directions: Sequence[FloatArray | None], row: FloatArray) -> tuple[int, float]:
    """Which of some directions a row lies along, their number where it is none, and how long it is beside that."""
    for i, direction in enumerate(directions):
        if direction is None:
            continue
        part = float(row @ direction / (direction @ direction))
        if np.abs(row - part * direction).max() <= _ALIKE * np.abs(row).max():
            return i, part
    return len(directions), 1.0


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


def modulus(z: ComplexArray) -> FloatArray:
    """Modulus, of numbers none of which is too great or too small to be squared."""
    return np.asarray(np.sqrt(z.real**2 + z.imag**2))
