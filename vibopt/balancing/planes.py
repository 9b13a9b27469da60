"""Correction planes: what may be bolted on or drilled away, where, and how a weight is written in text."""

from __future__ import annotations

import re
from cmath import rect
from collections.abc import Iterator, Mapping, Sequence
from math import inf, isclose, pi, tau
from typing import Any

from vibopt.answer.plan import Weight
from vibopt.balancing.conventions import Conventions, behind_number, read_angle, split_angle
from vibopt.balancing.fan import Fan
from vibopt.errors import QuantityError
from vibopt.records import dataclass
from vibopt.units import best_unit, read_quantity, show, to_unit
from vibopt.units.dimensions import DIMENSIONS
from vibopt.units.showing import show_angle

MASS, UNBALANCE = "mass", "unbalance"
_AT = re.compile(r"\s+at\s+", re.IGNORECASE)
_HAIR = 1e-9
_TRACE = 1e-7
"""Part of a cut weight below which a part of it is rounding."""
_HOLE = re.compile(r"\s+in\s+hole\s+(\d+)$", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class Drill:
    """A drill of `diameter` [m] in a material of `density` [kg/m³]; holes no deeper than `deepest` [m]."""

    diameter: float
    density: float
    deepest: float = inf

    def depth(self, mass: float) -> float:
        """Depth of a flat-bottomed hole that takes `mass` [kg] away [m]."""
        return mass / (self.density * 0.25 * pi * self.diameter**2)

    @property
    def most(self) -> float:
        """What a hole of the greatest depth takes away [kg]."""
        return self.deepest / self.depth(1.0)


@dataclass(frozen=True, slots=True)
class Plane:
    """A correction plane as the file gives it: one set of permitted weights, of which `breaks` knows every rule.

    name
        As in the file.
    kind
        "mass": weights in kg at a radius; "unbalance": in kg m, where the radius is not said.
    radii
        Radii to choose from [m], rising; empty where the file has none (masses then count at an agreed radius of 1 m).
    unit, length_unit
        How the user writes weights and radii.
    cap
        Greatest correction mass [kg] (unbalance [kg m]); inf without one.
    moment
        The cap counts mass times radius, over the greatest radius.
    holes
        Angles of the holes as written [rad]; empty: anywhere.
    shelf
        Masses there are [kg]; empty: any.
    stock
        How many of each mass of the shelf there are, for all planes together, inf without end; empty: not counted.
    most_weights
        Most weights of the shelf in this plane, one a hole.
    split
        The weight is cut in two that sit in the two neighbouring holes.
    forbidden
        Arcs as written (from, to) [rad], counted in the sense of the file.
    remove
        Material is taken away, opposite to where a weight would go.
    keep
        Nothing may be changed here.
    fitted
        The weights that are decided, none where it is empty; None where they are to be chosen.
    at
        Axial place [m]; None where the file says none.
    """

    name: str
    kind: str = MASS
    radii: tuple[float, ...] = ()
    unit: str = "g"
    length_unit: str = "mm"
    cap: float = inf
    moment: bool = False
    holes: tuple[float, ...] = ()
    shelf: tuple[float, ...] = ()
    stock: tuple[float, ...] = ()
    most_weights: int = 1
    split: bool = False
    forbidden: tuple[tuple[float, float], ...] = ()
    remove: bool = False
    keep: bool = False
    drill: Drill | None = None
    fitted: tuple[Weight, ...] | None = None
    at: float | None = None

    @property
    def radius(self) -> float:
        """Radius at which a mass does most [m]; 1 m where none is said, 1 for unbalances."""
        return self.radii[-1] if self.radii and self.kind == MASS else 1.0

    @property
    def place(self) -> float:
        """Axial place [m], zero where the file says none."""
        return self.at or 0.0

    @property
    def most(self) -> float:
        """Greatest mass [kg] (unbalance [kg m]): the cap, at the least radius, and what drilled holes hold."""
        if self.drill is not None and not self.is_discrete:
            return min(self.cap, self.drill.most * (2.0 if self.split else 1.0))
        return self.cap * self.radius / self.radii[0] if self.moment and self.shelf else self.cap

    @property
    def is_discrete(self) -> bool:
        return (bool(self.shelf) or self.fitted is not None) and not self.keep

    @property
    def is_open(self) -> bool:
        """Whether its weights are to be chosen."""
        return not self.keep and self.fitted is None

    @property
    def is_plain(self) -> bool:
        """Whether nothing is said of its weights but a cap, and at which one radius: any of them, at any angle."""
        keys = ("name", "kind", "unit", "length_unit", "cap", "remove", "at")
        return self == Plane(radii=self.radii[:1], **{key: getattr(self, key) for key in keys})

    @property
    def dimension(self) -> str:
        return "mass" if self.kind == MASS else "unbalance"

    @property
    def kind_word(self) -> str:
        """Key under which its weights stand in the file."""
        return "weight" if self.kind == MASS else "unbalance"

    def weight(self, mass: float, angle: float, hole: int | None = None, radius: float = 0.0) -> Weight:
        """One weight as it is told, at the greatest radius where none is said, with the depth of what is drilled."""
        arm = (radius or self.radius) if self.radii else None
        return Weight(mass, arm, angle, hole, self.drill.depth(mass) if self.drill is not None else None)

    def in_hole(self, hole: int, mass: float, radius: float = 0.0) -> Weight:
        """One weight in a hole."""
        return self.weight(mass, self.holes[hole] % tau, hole, radius)

    def cut(self, mass: float, angle: float) -> tuple[Weight, ...]:
        """A weight at the written `angle` [rad] cut in two for the holes around it; one where it hits a hole."""
        used = [hole for hole, own in enumerate(self.holes) if self.may_sit_at(own)]
        fan = Fan.of([self.holes[hole] for hole in used])
        parts = [(fan.angles[place], part) for place, part in fan.parts(rect(mass, angle)) if part > _TRACE * mass]
        return tuple(
            self.in_hole(min(used, key=lambda hole: abs(_turned(self.holes[hole] - own))), part) for own, part in parts
        )

    def breaks(self, weights: Sequence[Weight], tol: float = _HAIR, size: float = 0.0) -> str:
        """The rule of this plane that weights break: "the cap"; "" where all of them are kept.

        Parameters
        ----------
        tol
            Part by which rounding may pass a cap, a depth, or (over `size`) the edge of a sector.
        size
            The greatest mass that matters [kg]; 0: the greatest of these.
        """
        there = [weight for weight in weights if weight.mass]
        return next(self._broken(there, 1.0 + tol, tol * max([size, *(weight.mass for weight in there)])), "")

    def _broken(self, there: Sequence[Weight], room: float, hair: float) -> Iterator[str]:
        """The rules that weights break, in the order in which they are told."""
        if self.filled(there) > self.cap * room:
            yield "the cap"
        if self.drill is not None and any(weight.mass > self.drill.most * room for weight in there):
            yield "the drill"
        if self.forbidden and any(weight.mass * self.inside(weight.angle) > hair for weight in there):
            yield "the sectors"
        if self.is_open and any(
            weight.radius is not None and not _among(weight.radius, self.radii) for weight in there
        ):
            yield "the radius"
        if self.is_open and not self._seated([weight.hole for weight in there]):
            yield "the holes"
        if self.is_open and self.shelf and not all(_among(weight.mass, self.shelf) for weight in there):
            yield "the shelf"
        if self.keep and there:
            yield "keep"

    def made(self, weights: Sequence[Weight], conventions: Conventions) -> complex:
        """Internal unbalance that weights add, as they are told [kg m]."""
        sign = -1.0 if self.remove else 1.0
        return sum(
            (sign * conventions.weight(weight.mass * (weight.radius or 1.0), weight.angle) for weight in weights), 0j
        )

    def filled(self, weights: Sequence[Weight]) -> float:
        """What of the cap weights take [kg; kg m without a radius]."""
        if self.moment:
            return sum((weight.mass * ((weight.radius or 1.0) / self.radius) for weight in weights), 0.0)
        return sum((weight.mass for weight in weights), 0.0)

    def _seated(self, holes: Sequence[int | None]) -> bool:
        """Whether weights sit one a hole, no more than there may be, and parts of a split one in neighbours."""
        used = {self.holes[hole] % tau for hole in holes if hole is not None}
        if not self.holes or not self.split or len(holes) < 2:
            return len(holes) <= self.most_weights and len(used) == (len(holes) if self.holes else 0)
        around = [low for low, _ in self.gaps]
        behind = zip(self.gaps, [*around[1:], *around[:1]], strict=True)
        return len(holes) == 2 and used in [{low, value} for (low, high), value in behind if high - low < pi - _HAIR]

    def amount(self, u: complex | float) -> float:
        """Mass [kg] at the greatest radius (unbalance [kg m]) of an internal unbalance."""
        return abs(u) / self.radius

    def show(self, amount: float, digits: int = 4) -> str:
        """A mass (unbalance) as the user writes it."""
        return show(amount, self.unit, self.dimension, digits=digits)

    @property
    def gaps(self) -> tuple[tuple[float, float], ...]:
        """Arcs (from, to) as written [rad] between neighbouring holes that may be used."""
        around = sorted(angle % tau for angle in self.holes if self.may_sit_at(angle))
        return tuple(zip(around, [*around[1:], *(value + tau for value in around[:1])], strict=True))

    @property
    def out_of_reach(self) -> tuple[tuple[float, float], ...]:
        """Arcs in which no two parts of a split weight act: gaps between its holes of half a turn or more."""
        return tuple((low, high) for low, high in self.gaps if high - low >= pi - _HAIR) if self.split else ()

    def internal_sectors(self, conventions: Conventions) -> tuple[tuple[float, float], ...]:
        """Arcs forbidden to the correction's internal angle, counted with growing angle [rad]."""
        turn = pi if self.remove else 0.0
        arcs = []
        for low, high in self.forbidden:
            ends = (low, high) if conventions.weight_sense > 0 else (-high, -low)
            arcs.append((ends[0] + turn, ends[1] + turn))
        return tuple(arcs)

    def inside(self, angle: float) -> float:
        """How far the written `angle` is inside a forbidden arc [rad], zero outside of all."""
        depths = [0.0]
        for low, high in self.forbidden:
            behind = (angle - low) % tau
            depths.append(min(behind, high - low - behind))
        return max(depths)

    def may_sit_at(self, angle: float) -> bool:
        """Whether the written `angle` [rad] is outside the forbidden arcs."""
        return self.inside(angle) <= _HAIR


class Corrected:
    """A job whose answer is weights in its planes."""

    planes: tuple[Plane, ...]
    document: Mapping[str, Any]

    @property
    def choices(self) -> tuple[str, ...]:
        """Paths of the numbers that the answer chooses."""
        return tuple(
            f"planes.{plane.name}.{word}"
            for plane in self.planes if plane.is_open
            for word in (plane.dimension, "angle", *(("radius",) if len(plane.radii) > 1 else ()))
        )  # fmt: skip

    @property
    def decided_at(self) -> tuple[str, ...]:
        """Where the weights stand that are chosen freely, once they are decided."""
        return tuple(
            f"planes.{plane.name}.{plane.kind_word}." for plane in self.planes if plane.is_open and not plane.shelf
        )

    def beyond(self, decided: Corrected) -> list[str]:
        """Planes whose decided weights are not among those that this job may choose, by path."""
        pairs = zip(self.planes, decided.planes, strict=True)
        return [f"planes.{mine.name}" for mine, its in pairs if mine.is_open and mine.breaks(its.fitted or ())]


def read_weight(text: object, plane: Plane, conventions: Conventions) -> complex:
    """Unbalance [kg m] of "10 g @ 270 deg", "10 g at 150 mm @ 270 deg", "10 g in hole 7" or "1500 g mm @ 270 deg"."""
    front, radius, angle, _ = _parts(text, plane)
    size = _size(front, radius, plane)
    if size == 0.0:
        raise QuantityError(
            "is a trial weight of zero: it says nothing about its plane. Leave the plane out of this run."
        )
    return conventions.weight(size, angle)


def read_fitted(text: object, plane: Plane) -> Weight:
    """A weight that is decided, written as those of runs are."""
    front, radius, angle, hole = _parts(text, plane)
    arm = _arm(radius, plane) if plane.kind == MASS else 1.0
    fitted = plane.weight(_size(front, radius, plane) / arm, angle % tau, hole, arm)
    if plane.drill is not None and plane.drill.depth(fitted.mass) > plane.drill.deepest * (1.0 + _HAIR):
        deep, most = (show(value, "mm", "length") for value in (plane.drill.depth(fitted.mass), plane.drill.deepest))
        raise QuantityError(f"takes a hole {deep} deep, but the deepest that may be drilled is {most}.")
    return fitted


def _parts(text: object, plane: Plane) -> tuple[str, str, float, int | None]:
    """Amount, radius ("" where none is said), angle as written [rad] and index of the hole of a weight."""
    example = "1500 g mm @ 270 deg" if plane.kind == UNBALANCE else "10 g @ 270 deg"
    if not isinstance(text, str):
        raise QuantityError(f'is no weight. Write "{example}".')
    hole = _HOLE.search(text)
    if hole is not None:
        amount, angle = text[: hole.start()], _angle_of_hole(int(hole[1]), plane)
    else:
        amount, turned = split_angle(text, example)
        if turned is None:
            raise QuantityError(f'has no angle. Write "{example}".')
        angle = turned
    front, _, radius = _at_radius(amount)
    return front, radius, angle, None if hole is None else int(hole[1]) - 1


def text_of(weight: Weight, plane: Plane) -> str:
    """A decided weight as it stands in a file, exact to the last digit."""
    unit = plane.unit or best_unit(weight.mass, plane.dimension)
    amount = f"{to_unit(weight.mass, unit, plane.dimension):.15g} {unit}"
    if len(plane.radii) > 1:
        amount += f" at {to_unit(weight.radius or 1.0, plane.length_unit, 'length'):.15g} {plane.length_unit}"
    if weight.hole is not None:
        return f"{amount} in hole {weight.hole + 1}"
    return f"{amount} @ {to_unit(weight.angle, 'deg', 'angle'):.15g} deg"


def unit_of(text: object, plane: Plane) -> str:
    """Unit in which a weight of the plane was written; "" where it is another kind of amount."""
    if not isinstance(text, str):
        return ""
    amount = _at_radius(_HOLE.sub("", text).partition("@")[0])[0]
    unit = behind_number(amount).strip()
    return unit if unit and _maybe(f"1 {unit}", plane.dimension) is not None else ""


def _at_radius(text: str) -> tuple[str, str, str]:
    parts = _AT.split(text.strip(), maxsplit=1)
    return (parts[0], "at", parts[1]) if len(parts) == 2 else (parts[0], "", "")


def _size(text: str, radius: str, plane: Plane) -> float:
    """Unbalance [kg m] of an amount, at its own radius or that of the plane."""
    mass = _maybe(text, "mass")
    unbalance = _maybe(text, "unbalance") if mass is None else None
    if unbalance is not None:
        size = unbalance * (1.0 if plane.kind == UNBALANCE or plane.radii else inf)
        if size == inf:
            raise QuantityError(
                f"is an unbalance, but planes.{plane.name} has no radius. Add its radius, or write a mass."
            )
    else:
        mass = read_quantity(text, "mass").value if mass is None else mass  # which says what is wrong
        if plane.kind == UNBALANCE:
            raise QuantityError(
                f'is a mass, but planes.{plane.name} counts in unbalance. Write "{DIMENSIONS["unbalance"].example} '
                f'@ 270 deg".'
            )
        size = mass * _arm(radius, plane)
    if size < 0.0:
        raise QuantityError("is a negative amplitude. Write it positive and turn the angle by 180 deg.")
    return size


def _arm(radius: str, plane: Plane) -> float:
    if radius:
        arm = read_quantity(radius, "length").value
        if not arm > 0.0:
            raise QuantityError(f'has the radius "{radius}", which is not greater than zero.')
        if not plane.radii:
            raise QuantityError(f"has a radius, but planes.{plane.name} has none. Add its radius.")
        return arm
    if len(plane.radii) > 1:
        own = show(plane.radii[0], "mm", "length")
        raise QuantityError(f'does not say at which radius of planes.{plane.name}. Write "10 g at {own} @ 270 deg".')
    return plane.radius


def _maybe(text: str, dimension: str) -> float | None:
    try:
        return read_quantity(text, dimension).value
    except QuantityError:
        return None


def _angle_of_hole(number: int, plane: Plane) -> float:
    if not plane.holes:
        raise QuantityError(f'names a hole, but planes.{plane.name} has none. Write "10 g @ 270 deg", or add holes.')
    if not 1 <= number <= len(plane.holes):
        raise QuantityError(f"names a hole that is not there: planes.{plane.name} has holes 1 to {len(plane.holes)}.")
    return plane.holes[number - 1]


def read_arc(text: object) -> tuple[float, float]:
    """A forbidden sector "80..110 deg" as written [rad]; "350..10 deg" goes through zero."""
    if not isinstance(text, str) or text.count("..") != 1:
        raise QuantityError('is no sector. Write "80..110 deg".')
    low_text, high_text = (part.strip() for part in text.split(".."))
    high = read_angle(high_text)
    low = read_angle(low_text if any(one.isalpha() or one == "°" for one in low_text) else f"{low_text} deg")
    if isclose(low, high):
        raise QuantityError('is an empty sector: both ends are the same. Write "80..110 deg".')
    return low, high if high > low else high + tau


def open_arcs(sectors: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """Arcs (from, to) [rad] that forbidden arcs leave, single angles not counted; the whole turn without any."""
    if not sectors:
        return [(0.0, tau)]
    spans = sorted((low % tau, low % tau + ((high - low) % tau or tau)) for low, high in sectors)
    start, gaps = spans[0][0], []
    reach = start
    for low, high in [*spans, (start + tau, start + tau)]:
        if low > reach + _HAIR:
            gaps.append((reach, low))
        reach = max(reach, high)
    around = reach - tau  # what the last sector covers of the first gaps, once around
    return [(max(low, around), high) for low, high in gaps if high > around + _HAIR]


def hole_name(plane: Plane, index: int) -> str:
    return f"hole {index + 1} at {show_angle(plane.holes[index])}"


def _turned(angle: float) -> float:
    """The same angle between minus and plus half a turn."""
    return (angle + pi) % tau - pi


def _among(size: float, listed: Sequence[float]) -> bool:
    return size in listed or any(isclose(size, value) for value in listed)
