"""A rotor: sections of a round shaft, discs on it, and stations at which bearings and supports hold it."""

import math
from collections.abc import Mapping
from itertools import pairwise
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator, WithJsonSchema, model_validator

from vibopt.devices.device import Device
from vibopt.devices.spring import bore, check_bore
from vibopt.devices.symbols import Numbers, Symbols
from vibopt.errors import QuantityError, counted
from vibopt.mechanics import shaft_waves as waves
from vibopt.mechanics.assembly import Assembly
from vibopt.mechanics.builder import ModelBuilder
from vibopt.mechanics.model import INERTIA, STIFFNESS, stressed
from vibopt.mechanics.monomial import Monomial
from vibopt.mechanics.shaft_polynomials import Beam, Span, shapes, shares
from vibopt.units import read_quantity
from vibopt.values import Fact, Table, Value, number, word
from vibopt.values.fields import Choice, complaint

_TOGETHER = 1e-9
"""Part of the length by which two places on a shaft are the same."""
_WIDEST = 1000.0
"""Widest over thinnest section; stiffness goes with the fourth power."""


class Section(Table):
    """One entry of `sections`: a round piece of shaft; they follow each other from the left end.

    Keys
    ----
    length: From the end of the one before.
    diameter: Outer diameter; it may be chosen: `diameter = { from = "40 mm", to = "90 mm" }`.
    inner_diameter: Of a hollow section. Not beside `inner_ratio`, nor a diameter that is to be chosen.
    inner_ratio: Inner over outer diameter: `inner_ratio = 0.6`.
    """

    length: Fact = number("length", choice=False, required=True)
    diameter: Value = number("length", required=True)
    inner_diameter: Fact | None = number("length", choice=False)
    inner_ratio: Fact | None = number("ratio", choice=False)

    @model_validator(mode="after")
    def _hollow(self) -> "Section":
        check_bore(self, "bend")
        return self


class RotorDisc(Table):
    """One entry of `discs`: a rigid disc, by mass and moments of inertia or by its sizes.

    Keys
    ----
    name: What it is called: a point as any other, at which links end and `on` which an unbalance acts: `name =
        "wheel"`.
    at: Its place from the left end of the shaft.
    mass: Its mass; beside it both moments of inertia, or none of a mass that is a point.
    diametral: Moment of inertia about a diameter.
    polar: Moment of inertia about the axis of the shaft, which says how much it resists tilting as it spins.
    outer_diameter: Of a round disc, beside `width` and `density`, instead of `mass`.
    inner_diameter: Of its bore; none without it.
    width: Along the shaft.
    density: Of its material: `density = "7850 kg/m3"`.
    """

    name: str
    at: Fact = number("length", choice=False, sign="not negative", required=True)
    mass: Value | None = number("mass")
    diametral: Value | None = number("inertia")
    polar: Value | None = number("inertia")
    outer_diameter: Value | None = number("length")
    inner_diameter: Fact | None = number("length", choice=False)
    width: Value | None = number("length")
    density: Fact | None = number("density", choice=False)

    @model_validator(mode="after")
    def _one_way(self) -> "RotorDisc":
        sizes = [key for key in ("outer_diameter", "width", "density") if getattr(self, key) is not None]
        if self.mass is not None:
            if sizes:
                raise word(f"gives mass and {sizes[0]}. Keep the mass with its moments of inertia, or the sizes.")
            if (self.diametral is None) != (self.polar is None):
                raise word('gives one moment of inertia. Write both: diametral = "0.4 kg m2" and polar = "0.8 kg m2".')
            polar, diametral = (getattr(one, "value", None) for one in (self.polar, self.diametral))
            if polar is not None and diametral is not None and polar > 2.0 * diametral * (1.0 + 1e-9):
                raise word(
                    "has a polar moment of inertia of more than twice the diametral one: there is no such body. A thin "
                    "disc has twice."
                )
            return self
        if len(sizes) < 3:
            raise word('needs its mass, or outer_diameter, width and density. Write mass = "30 kg".')
        if self.diametral is not None or self.polar is not None:
            raise word("gives its sizes and a moment of inertia, which follows from them. Keep one.")
        least = getattr(self.outer_diameter, "low", getattr(self.outer_diameter, "value", 0.0))
        if self.inner_diameter is not None and self.inner_diameter.value >= least:
            raise word("is as wide inside as outside, or wider. Write a smaller inner_diameter.")
        return self

    def inertias(self, path: str, symbols: Symbols) -> tuple[list[Monomial], list[Monomial], list[Monomial]]:
        """Mass [kg], diametral and polar moment of inertia [kg m^2], each a sum."""

        def read(key: str) -> Monomial:
            return symbols.read(f"{path}.{key}", getattr(self, key))

        if self.mass is not None:
            tilts = [[read(key)] if getattr(self, key) is not None else [] for key in ("diametral", "polar")]
            return [read("mass")], tilts[0], tilts[1]
        assert self.density is not None
        hole = self.inner_diameter.value if self.inner_diameter is not None else 0.0
        ring = read("width").times(0.25 * math.pi * self.density.value)
        squares = [ring * read("outer_diameter") ** 2.0, *([ring.times(-(hole**2))] if hole else [])]
        fourths = [ring * read("outer_diameter") ** 4.0, *([ring.times(-(hole**4))] if hole else [])]
        flat = [square * read("width") ** 2.0 for square in squares]
        diametral = [fourth.times(1.0 / 16.0) for fourth in fourths] + [one.times(1.0 / 12.0) for one in flat]
        return squares, diametral, [fourth.times(1.0 / 8.0) for fourth in fourths]

    def built(self, path: str, numbers: Numbers) -> tuple[float, float, float]:
        """Mass [kg], diametral and polar moment of inertia [kg m^2], of radii."""

        def given(key: str) -> float:
            return numbers(f"{path}.{key}", getattr(self, key))

        if self.mass is not None:
            return given("mass"), given("diametral"), given("polar")
        outer, inner, wide = 0.5 * given("outer_diameter"), 0.5 * given("inner_diameter"), given("width")
        mass = given("density") * math.pi * (outer - inner) * (outer + inner) * wide
        about = outer**2 + inner**2
        return mass, mass * (3.0 * about + wide**2) / 12.0, 0.5 * mass * about


def _stations(given: object) -> object:
    if not isinstance(given, Mapping) or not given:
        raise complaint('names no station. Write stations = { left = "0 mm", right = "800 mm" }.')
    found = {}
    for name, place in given.items():
        try:
            found[str(name)] = place if isinstance(place, Fact) else _place(place)
        except QuantityError as error:
            raise complaint(f'puts {name} at "{place}", which {error} Write {name} = "800 mm".') from None
    return found


def _place(given: object) -> Fact:
    found = read_quantity(given, "length")
    if found.value < 0.0:
        raise QuantityError("is left of the shaft.")
    return Fact(found.value, found.unit)


Stations = Annotated[
    Any, BeforeValidator(_stations), WithJsonSchema({"type": "object", "description": "places from the left end"})
]


class RotorTable(Device):
    """`[rotors.NAME]`: a shaft that spins, of sections, with discs and stations; its whirl is that of an unbalance.

    Keys
    ----
    sections: Pieces of shaft from left to right: `sections = [{ length = "0.8 m", diameter = "60 mm" }]`.
    discs: What sits on it: `discs = [{ name = "wheel", at = "0.5 m", mass = "30 kg", diametral = "0.4 kg m2", polar =
        "0.8 kg m2" }]`.
    stations: Named places from the left end, at which links end and motion is asked for: `stations = { left = "0 mm",
        right = "800 mm" }`. Discs are stations by their own names.
    modulus: Modulus of elasticity of the shaft: `modulus = "207 GPa"`.
    density: Of the shaft: `density = "7850 kg/m3"`.
    poisson_ratio: Of the shaft, 0.3 without it; it says the shear modulus, and how shear is spread over a section.
    shear_modulus: Instead of what modulus and Poisson's ratio say.
    shear_coefficient: Mean over greatest shear of a section, by which its area counts; by Cowper's formula without it:
        `shear_coefficient = 0.9`.
    material_damping: Viscous damping of the shaft's own material, which turns with it: the time t by which stress leads
        strain, E (e + t de/dt), in shear as in bending: `material_damping = "0.02 ms"`. See `stability_threshold`.
    """

    sections: tuple[Section, ...]
    discs: tuple[RotorDisc, ...] = ()
    stations: Stations
    modulus: Fact = number("modulus", choice=False, required=True)
    density: Fact = number("density", choice=False, required=True)
    poisson_ratio: Fact | None = number("ratio", choice=False, sign="not negative", most=0.5)
    shear_modulus: Fact | None = number("modulus", choice=False)
    shear_coefficient: Fact | None = number("ratio", choice=False, most=1.0)
    material_damping: Fact | None = number("time", choice=False, sign="not negative")

    @model_validator(mode="after")
    def _fits(self) -> "RotorTable":
        if not self.sections:
            raise word('has no sections. Write sections = [{ length = "0.5 m", diameter = "60 mm" }].')
        ends = [
            getattr(section.diameter, end, None) or 0.0 for section in self.sections for end in ("value", "low", "high")
        ]
        wide = [end for end in ends if 0.0 < end < math.inf]
        if max(wide, default=1.0) > _WIDEST * min(wide, default=1.0):
            raise word(
                f"has sections of {min(wide):g} m and of {max(wide):g} m: where diameters differ by more than a factor "
                f"of {_WIDEST:g}, rounding decides how the shaft bends. Write diameters nearer to each other."
            )
        discs = [disc.name for disc in self.discs]
        for name, place in self.places.items():
            if place > self.long * (1.0 + _TOGETHER):
                raise word(
                    f"has {name} at {place:g} m, beyond the end of its shaft at {self.long:g} m. Write a place on the "
                    "shaft, or longer sections.",
                    *(("discs", discs.index(name), "at") if name in discs else ("stations", name)),
                )
        names = [*self.stations, *(disc.name for disc in self.discs)]
        double = next((name for name in names if names.count(name) > 1), None)
        if double is not None:
            raise word(f"has two places called {double}. Give each a name of its own; a disc is a station, too.")
        return self

    @property
    def long(self) -> float:
        """Length of the shaft [m]."""
        return sum(section.length.value for section in self.sections)

    @property
    def lags(self) -> float:
        """Time by which the stress of its material leads the strain [s]."""
        return self.material_damping.value if self.material_damping is not None else 0.0

    @property
    def turns_with_shaft(self) -> str:
        return "material_damping" if self.lags else ""

    @property
    def places(self) -> dict[str, float]:
        """Place of every station and disc from the left end [m]."""
        return {name: station.value for name, station in self.stations.items()} | {
            disc.name: disc.at.value for disc in self.discs
        }

    @property
    def names(self) -> list[str]:
        """Names of its points."""
        return list(self.places)

    @property
    def nodes(self) -> list[float]:
        """Ends of sections, stations and discs from left to right, those that are together once [m]."""
        ends = np.cumsum([0.0, *(section.length.value for section in self.sections)])
        found: list[float] = []
        for place in sorted([*ends.tolist(), *self.places.values()]):
            if not found or place > found[-1] + _TOGETHER * self.long:
                found.append(place)
        return found

    def node(self, place: float) -> int:
        """Number of the node at a place [m]."""
        return int(np.argmin(np.abs(np.array(self.nodes) - place)))

    @property
    def spans(self) -> list[tuple[int, float]]:
        """From node to node the number of the section there, and the length [m]."""
        ends = np.cumsum([section.length.value for section in self.sections])
        between = list(pairwise(self.nodes))
        last = len(self.sections) - 1
        return [(min(int(np.searchsorted(ends, 0.5 * (a + b))), last), b - a) for a, b in between]

    def sheared(self, section: Section) -> float:
        """Shear coefficient times shear modulus [Pa]: of a ring by Cowper (1966)."""
        ratio = self.poisson_ratio.value if self.poisson_ratio is not None else 0.3
        modulus = self.modulus.value / (2.0 * (1.0 + ratio))
        if self.shear_modulus is not None:
            modulus = self.shear_modulus.value
        if self.shear_coefficient is not None:
            return self.shear_coefficient.value * modulus
        hole = bore(section) ** 2
        whole = (1.0 + hole) ** 2
        return 6.0 * (1.0 + ratio) * whole / ((7.0 + 6.0 * ratio) * whole + (20.0 + 12.0 * ratio) * hole) * modulus

    @classmethod
    def moving_in(cls, name: str, given: Mapping[str, Any]) -> tuple[str, ...]:
        stations, discs = given.get("stations"), given.get("discs")
        found = list(stations) if isinstance(stations, Mapping) else []
        listed = discs if isinstance(discs, list) else []
        found += [one["name"] for one in listed if isinstance(one, Mapping) and isinstance(one.get("name"), str)]
        return tuple(dict.fromkeys(found))

    @classmethod
    def freedoms_in(cls, name: str, given: Mapping[str, Any]) -> int:
        return waves.MODES

    def declare(self, builder: ModelBuilder, name: str) -> None:
        for i in range(self.beam(builder.top, builder.modes).count):
            builder.add_coordinate(coordinate(name, i))
        for point, place in self.places.items():
            builder.add_point(point, {coordinate(name, 2 * self.node(place)): 1.0})

    def beam(self, top: float, modes: int) -> Beam:
        """The shaft in polynomials that are good up to a frequency [rad/s], and for so many of its lowest whirls."""
        thin, thick = self._extremes()
        top = max(top, self._reach(thick, modes))
        degrees = [max(one.degree(top)[0], other.degree(top)[0]) for one, other in zip(thin, thick, strict=True)]
        return Beam(tuple(one.length for one in thin), tuple(degrees))

    def _extremes(self) -> tuple[list[Span], list[Span]]:
        """The spans where every diameter that may be chosen is least, and where it is greatest."""
        both: tuple[list[Span], list[Span]] = [], []
        for i, long in self.spans:
            section = self.sections[i]
            free = section.diameter if isinstance(section.diameter, Choice) else None
            for found, end in zip(both, ("low", "high"), strict=True):
                wide = getattr(free or section.diameter, end if free else "value")
                wide *= 1.0 + (-1.0 if end == "low" else 1.0) * section.diameter.tolerance
                area = 0.25 * math.pi * wide**2 * (1.0 - bore(section) ** 2)
                second = area * wide**2 * (1.0 + bore(section) ** 2) / 16.0
                heavy = self.density.value
                found.append(
                    Span(long, self.modulus.value * second, self.sheared(section) * area, heavy * area, heavy * second)
                )
        return both

    def _reach(self, spans: list[Span], modes: int) -> float:
        """Frequency that so many whirls of the bare shaft do not exceed, however stations hold it [rad/s]."""
        phases = sum(span.phase(1.0) for span in spans)
        return ((modes + len(self.stations) - 0.5) * math.pi / phases) ** 2 if modes else 0.0

    def bent(self, name: str) -> tuple[str, ...]:
        """Both ends of every span, where bending is asked for: what a rotor called so stands for."""
        return tuple(one for k in range(len(self.spans)) for one in ends_of_span(name, k))

    def add_to(self, builder: ModelBuilder, name: str, symbols: Symbols) -> None:
        """Energies of the shaft by its sections, and of the discs; polar inertia counts in forward whirl alone."""
        beam = self.beam(builder.top, builder.modes)
        for k, (i, _) in enumerate(self.spans):
            section, path = self.sections[i], f"rotors.{name}.sections.{i + 1}"
            wide = symbols.read(f"{path}.diameter", section.diameter)
            area = (wide**2.0).times(0.25 * math.pi * (1.0 - bore(section) ** 2))
            second = (wide**4.0).times(math.pi * (1.0 - bore(section) ** 4) / 64.0)
            self._add_span(builder, name, beam, k, (area, second, self.sheared(section)))
            stress = (wide**-3.0).times(32.0 / (math.pi * (1.0 - bore(section) ** 4)))
            for single in ends_of_span(name, k):
                builder.counts[stressed(single)] = stress**-1.0
        for j, disc in enumerate(self.discs):
            masses, diametral, polar = disc.inertias(f"rotors.{name}.discs.{j + 1}", symbols)
            tilt = {coordinate(name, 2 * self.node(disc.at.value) + 1): 1.0}
            for mass in masses:
                builder.add_inertia(disc.name, mass, name)
            for moment in diametral:
                builder.add_term(INERTIA, tilt, moment, name, 0.0)
            for moment in polar:
                builder.add_polar(tilt, moment, name)
        builder.remarks.append(self._remark(name, beam, builder))

    def _remark(self, name: str, beam: Beam, builder: ModelBuilder) -> str:
        """How good the polynomials are, for the answer."""
        thin, thick = self._extremes()
        top = max(builder.top, self._reach(thick, builder.modes))
        moved = max(one.degree(top)[1] for one in thin)
        least, most = min(beam.degrees), max(beam.degrees)
        degrees = f"degree {most}" if least == most else f"degrees {least} to {most}"
        many = counted(len(thin), "spans")
        return (
            f"{name}: {many} of Timoshenko's beam in polynomials of {degrees}; one degree more moves "
            f"its stiffness by less than {max(moved, 1e-15):.0e} up to {top * 30.0 / math.pi:.4g} rpm"
        )

    def _add_span(
        self, builder: ModelBuilder, name: str, beam: Beam, k: int, section: tuple[Monomial, Monomial, float]
    ) -> None:
        """Energies between two nodes; of the deflection its mean has the weight."""
        area, second, shear = section
        places, owner = [coordinate(name, i) for i in beam.coordinates(k)], f"{name}@{k + 1}"
        rows, long = shapes(beam.degrees[k], beam.lengths[k]), beam.lengths[k]
        mass, rotary = area.times(self.density.value), second.times(self.density.value)
        kinds = (
            (STIFFNESS, rows.curvature, second.times(self.modulus.value), False),
            (STIFFNESS, rows.shear, area.times(shear), False),
            (INERTIA, rows.deflection, mass, True),
            (INERTIA, rows.tilt, rotary, False),
        )
        for kind, table, size, weighs in kinds:
            for i, (row, share) in enumerate(zip(table, shares(len(table), long), strict=True)):
                parts = dict(zip(places, row.tolist(), strict=True))
                static = 1.0 if kind == STIFFNESS or (weighs and i == 0) else 0.0
                tilts = float(row[1]), float(row[3])
                builder.add_term(kind, parts, size.times(float(share)), owner, static, tilts)
                if kind == STIFFNESS and self.lags:
                    builder.add_rotating_term(parts, size.times(float(share) * self.lags), owner)
                if kind == INERTIA and not weighs:
                    builder.add_polar(parts, size.times(2.0 * float(share)), owner, tilts)

    def built(self, assembly: Assembly, name: str, numbers: Numbers) -> None:
        """The same shaft by its waves, of radii."""
        pieces = []
        for i, long in self.spans:
            section, path = self.sections[i], f"rotors.{name}.sections.{i + 1}"
            outer = 0.5 * numbers(f"{path}.diameter", section.diameter)
            inner = 0.5 * numbers(f"{path}.inner_diameter", section.inner_diameter)
            if section.inner_ratio is not None:
                inner = outer * numbers(f"{path}.inner_ratio", section.inner_ratio)
            area = math.pi * (outer - inner) * (outer + inner)
            second = 0.25 * area * (outer**2 + inner**2)
            bends, shears = self.modulus.value * second, self.sheared(section) * area
            heavy = self.density.value
            pieces.append(waves.Section(long, bends, shears, heavy * area, heavy * second, outer / second))
        discs = [
            waves.Disc(self.node(disc.at.value), *disc.built(f"rotors.{name}.discs.{j + 1}", numbers))
            for j, disc in enumerate(self.discs)
        ]
        points = {point: self.node(place) for point, place in self.places.items()}
        phases = sum(piece.length * (piece.mass / piece.bending) ** 0.25 for piece in pieces)
        reach = ((assembly.modes + len(points)) * math.pi / phases) ** 2 if assembly.modes else 0.0
        top = max(assembly.top, reach)
        assembly.shafts[name] = waves.WhirlingShaft(tuple(pieces), tuple(discs), points, top, self.lags)


def ends_of_span(rotor: str, k: int) -> tuple[str, str]:
    """Names of the left and the right end of a span, that no link of a file can have."""
    return f"{rotor}@{k + 1}.left", f"{rotor}@{k + 1}.right"


def coordinate(rotor: str, index: int) -> str:
    """Name of a coordinate that no point of a file can have; two of each node, then those within sections."""
    return f"{rotor} [{index + 1}]"
