"""A rotor: sections of a round shaft, discs on it, and stations at which bearings and supports hold it."""

import math
from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from pydantic import model_validator

from vibopt.arrays import FloatArray
from vibopt.devices.device import Device
from vibopt.devices.rotor_disc import RotorDisc
from vibopt.devices.shaft_places import EndOf, Place, Stations
from vibopt.devices.spring import bore, check_bore
from vibopt.devices.symbols import Numbers, Symbols
from vibopt.errors import counted
from vibopt.mechanics import shaft_waves as waves
from vibopt.mechanics.assembly import Assembly
from vibopt.mechanics.builder import ModelBuilder
from vibopt.mechanics.matrix_shaft import MatrixShaft
from vibopt.mechanics.model import DAMPING, INERTIA, STIFFNESS, stressed
from vibopt.mechanics.monomial import Monomial
from vibopt.mechanics.shaft_polynomials import Beam, Span, shapes, shares
from vibopt.values import Fact, Table, Value, number, word
from vibopt.values.fields import Choice, numbers_in
from vibopt.values.kinds import Later
from vibopt.values.tolerance import span

if TYPE_CHECKING:
    from vibopt.devices.shaft_matrices import Planes, ShaftMatrices
else:
    ShaftMatrices = Annotated[Any, Later("vibopt.devices", "shaft_matrices.ShaftMatrices")]

_TOGETHER = 1e-9
"""Part of the length by which two places on a shaft are the same."""
_AT_NODE = 1e-6
"""Part of the length by which a place may be off a node of matrices."""
_NOTHING = 1e-14
"""Part of the greatest value of a scaled matrix below which one is rounding."""
_OF_SECTIONS = ("modulus", "density", "poisson_ratio", "shear_modulus", "shear_coefficient")
_WIDEST = 1000.0
"""Widest over thinnest section; stiffness goes with the fourth power."""


class Section(Table):
    """One entry of `sections`: a round piece of shaft; they follow each other from the left end.

    Keys
    ----
    length: From the end of the one before; it may be chosen: `length = { from = "300 mm", to = "600 mm" }`. What stands
        behind such a section stands at the end of one.
    diameter: Outer diameter; it may be chosen: `diameter = { from = "40 mm", to = "90 mm" }`.
    inner_diameter: Of a hollow section. Not beside `inner_ratio`, nor a diameter that is to be chosen.
    inner_ratio: Inner over outer diameter: `inner_ratio = 0.6`.
    """

    length: Value = number("length", required=True)
    diameter: Value = number("length", required=True)
    inner_diameter: Fact | None = number("length", choice=False)
    inner_ratio: Fact | None = number("ratio", choice=False)

    @model_validator(mode="after")
    def _hollow(self) -> "Section":
        check_bore(self, "bend")
        for name, ends in (("length", '"300 mm", to = "600 mm"'), ("diameter", '"40 mm", to = "120 mm"')):
            one = getattr(self, name)
            if isinstance(one, Choice) and (one.open_low or one.high == math.inf):
                raise word(f"leaves an end of its {name} open. Write both: {name} = {{ from = {ends} }}.")
        return self

    @property
    def free(self) -> bool:
        """Whether its length may be chosen, or is off as built."""
        return isinstance(self.length, Choice) or self.length.tolerance > 0.0

    @property
    def lengths(self) -> tuple[float, float, float]:
        """Least, middle and greatest length as built [m]."""
        one = self.length
        low, high = (one.low, one.high) if isinstance(one, Choice) else (one.value, one.value)
        short, long = span(one.tolerance)
        return low * short, math.sqrt(low * high), high * long


class RotorTable(Device):
    """`[rotors.NAME]`: a shaft that spins, with discs and stations; its whirl is that of an unbalance.

    Keys
    ----
    sections: Pieces of shaft from left to right: `sections = [{ length = "0.8 m", diameter = "60 mm" }]`. One of
        `sections`, `matrices`.
    matrices: The shaft by matrices of another program, instead of its sections and what these are made of: `matrices =
        { mass = "mass.mtx", stiffness = "stiffness.mtx", gyroscopic = "gyroscopic.mtx", units = "kg m s", order = ["y",
        "z", "about_y", "about_z"], nodes = ["0 mm", "400 mm", "800 mm"] }`.
    discs: What sits on it: `discs = [{ name = "wheel", at = "0.5 m", mass = "30 kg", diametral = "0.4 kg m2", polar =
        "0.8 kg m2" }]`.
    stations: Named places from the left end, at which links end and motion is asked for: `stations = { left = "0 mm",
        right = "800 mm" }`, or `"end of section 1"`. Discs are stations by their own names.
    modulus: Modulus of elasticity of the shaft: `modulus = "207 GPa"`. One of `modulus`, `matrices`; so with the
        next four.
    density: Of the shaft: `density = "7850 kg/m3"`. One of `density`, `matrices`.
    poisson_ratio: Of the shaft, 0.3 without it; it says the shear modulus, and how shear is spread over a section.
    shear_modulus: Instead of what modulus and Poisson's ratio say.
    shear_coefficient: Mean over greatest shear of a section, by which its area counts; by Cowper's formula without it:
        `shear_coefficient = 0.9`.
    material_damping: Viscous damping of the shaft's own material, which turns with it: the time t by which stress leads
        strain, E (e + t de/dt), in shear as in bending: `material_damping = "0.02 ms"`. See `stability_threshold`.
    """

    sections: tuple[Section, ...] = ()
    matrices: ShaftMatrices | None = None
    discs: tuple[RotorDisc, ...] = ()
    stations: Stations
    modulus: Fact | None = number("modulus", choice=False)
    density: Fact | None = number("density", choice=False)
    poisson_ratio: Fact | None = number("ratio", choice=False, sign="not negative", most=0.5)
    shear_modulus: Fact | None = number("modulus", choice=False)
    shear_coefficient: Fact | None = number("ratio", choice=False, most=1.0)
    material_damping: Fact | None = number("time", choice=False, sign="not negative")

    @model_validator(mode="after")
    def _fits(self) -> "RotorTable":
        self._one_way()
        ends = [
            getattr(section.diameter, end, None) or 0.0 for section in self.sections for end in ("value", "low", "high")
        ]
        wide = [end for end in ends if end > 0.0]
        if max(wide, default=1.0) > _WIDEST * min(wide, default=1.0):
            raise word(
                f"has sections of {min(wide):g} m and of {max(wide):g} m: where diameters differ by more than a factor "
                f"of {_WIDEST:g}, rounding decides how the shaft bends. Write diameters nearer to each other."
            )
        discs = [disc.name for disc in self.discs]
        by_section = sorted(self._spots.items(), key=lambda one: not isinstance(one[1], EndOf))
        for name, spot in by_section:  # those first: nodes stand there, too
            at: tuple[str | int, ...] = ("discs", discs.index(name), "at") if name in discs else ("stations", name)
            if isinstance(spot, EndOf):
                if not 1 <= spot.section <= len(self.sections):
                    raise word(
                        f"has {name} at the end of section {spot.section}, and "
                        f"{counted(len(self.sections), 'sections')}. Count them from 1.",
                        *at,
                    )
                continue
            place, free = (
                spot.value,
                next((i for i, section in enumerate(self.sections) if section.free), len(self.sections)),
            )
            if free < len(self.sections) and place > self._ends[free] + _TOGETHER * self.long:
                raise word(
                    f"has {name} at {place:g} m, behind the begin of section {free + 1}, whose length is not fixed. "
                    f'Say where it stands by sections: "end of section {free + 1}".',
                    *at,
                )
            if place > self.long * (1.0 + _TOGETHER):
                raise word(
                    f"has {name} at {place:g} m, beyond the end of its shaft at {self.long:g} m. Write a place on the "
                    "shaft, or longer sections.",
                    *at,
                )
            near = self.nodes[self.node(place)]
            if abs(near - place) > _AT_NODE * self.long:
                raise word(
                    f"has {name} at {place:g} m, where its matrices have no node; the nearest is at {near:g} m. Write "
                    "that place, or export a node there.",
                    *at,
                )
        names = [*self.stations, *(disc.name for disc in self.discs)]
        double = next((name for name in names if names.count(name) > 1), None)
        if double is not None:
            raise word(f"has two places called {double}. Give each a name of its own; a disc is a station, too.")
        return self

    def _one_way(self) -> None:
        """Whether the shaft is said by its sections, or by matrices."""
        if self.matrices is not None:
            extra = [key for key in (*_OF_SECTIONS, "sections") if getattr(self, key)]
            if extra:
                raise word(f"gives matrices and {extra[0]}. Keep the matrices, or sections with what they are made of.")
            return
        if not self.sections:
            raise word('has no sections. Write sections = [{ length = "0.5 m", diameter = "60 mm" }].')
        for key, example in (("modulus", "207 GPa"), ("density", "7850 kg/m3")):
            if getattr(self, key) is None:
                raise word(f'has sections and no {key}. Write {key} = "{example}".')

    @property
    def long(self) -> float:
        """Length of the shaft [m]; where lengths are not fixed all of them are in the middle, here and below."""
        return self.matrices.nodes[-1] if self.matrices else float(self._ends[-1])

    @property
    def _ends(self) -> FloatArray:
        """Left end of the first section and right ends of all [m]."""
        return np.cumsum([0.0, *(section.lengths[1] for section in self.sections)])

    @property
    def _spots(self) -> dict[str, Place]:
        return {**self.stations, **{disc.name: disc.at for disc in self.discs}}

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
        return self.places_on(self._ends)

    def places_on(self, ends: FloatArray) -> dict[str, float]:
        """As `places`, where the sections end so [m], from the left end on."""
        return {
            name: float(ends[spot.section]) if isinstance(spot, EndOf) else spot.value
            for name, spot in self._spots.items()
        }

    @property
    def names(self) -> list[str]:
        """Names of its points."""
        return list(self.places)

    @property
    def nodes(self) -> list[float]:
        """Ends of sections, stations and discs from left to right, those that are together once [m]."""
        if self.matrices is not None:
            return list(self.matrices.nodes)
        found: list[float] = []
        for place in sorted([*self._ends.tolist(), *self.places.values()]):
            if not found or place > found[-1] + _TOGETHER * self.long:
                found.append(place)
        return found

    def node(self, place: float) -> int:
        """Number of the node at a place [m]."""
        return int(np.argmin(np.abs(np.array(self.nodes) - place)))

    @property
    def spans(self) -> list[tuple[int, float]]:
        """From node to node the number of the section there, and the length [m]."""
        ends = self._ends[1:]
        between = list(pairwise(self.nodes))
        last = len(self.sections) - 1
        return [(min(int(np.searchsorted(ends, 0.5 * (a + b))), last), b - a) for a, b in between]

    @property
    def mass(self) -> float | None:
        """Of shaft and discs [kg]; None where a size is to be chosen."""
        if any(isinstance(one, Choice) for _, one, _ in numbers_in("", self)):
            return None
        assembly = Assembly()
        self.built(assembly, "", Numbers({}))
        return assembly.shafts[""].weighs

    def _given(self, key: str) -> float:
        """What sections are made of, which is there beside them."""
        return float(getattr(self, key).value)

    def sheared(self, section: Section) -> float:
        """Shear coefficient times shear modulus [Pa]: of a ring by Cowper (1966)."""
        ratio = self.poisson_ratio.value if self.poisson_ratio is not None else 0.3
        modulus = self._given("modulus") / (2.0 * (1.0 + ratio))
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
        many = 2 * len(self.nodes) if self.matrices else self.beam(builder.top, builder.modes).count
        for i in range(many):
            builder.add_coordinate(coordinate(name, i))
        for point, place in self.places.items():
            builder.add_point(point, {coordinate(name, 2 * self.node(place)): 1.0})

    def beam(self, top: float, modes: int) -> Beam:
        """The shaft in polynomials that are good up to a frequency [rad/s], and for so many of its lowest whirls."""
        thin, thick = self._extremes()
        top = max(top, self._reach(thick, modes))
        degrees = [max(span.degree(top)[0], other.degree(top)[0]) for span, other in zip(thin, thick, strict=True)]
        return Beam(tuple(long for _, long in self.spans), tuple(degrees))

    def half_waves(self, top: float) -> float:
        """Most half waves of one span, as thin as it may be, at a frequency [rad/s]; none of matrices."""
        thin, _ = self._extremes() if self.matrices is None else ([], [])
        return max((span.phase(top) / math.pi for span in thin), default=0.0)

    def _extremes(self) -> tuple[list[Span], list[Span]]:
        """The spans, as long as they may be, where every diameter that may be chosen is least, and greatest."""
        both: tuple[list[Span], list[Span]] = [], []
        for i, middle in self.spans:
            section = self.sections[i]
            long = section.lengths[2] if section.free else middle
            free = section.diameter if isinstance(section.diameter, Choice) else None
            for found, end in zip(both, ("low", "high"), strict=True):
                wide = getattr(free or section.diameter, end if free else "value")
                wide *= span(section.diameter.tolerance)[end == "high"]
                area = 0.25 * math.pi * wide**2 * (1.0 - bore(section) ** 2)
                second = area * wide**2 * (1.0 + bore(section) ** 2) / 16.0
                heavy = self._given("density")
                found.append(
                    Span(
                        long,
                        self._given("modulus") * second,
                        self.sheared(section) * area,
                        heavy * area,
                        heavy * second,
                    )
                )
        return both

    def _reach(self, spans: list[Span], modes: int) -> float:
        """Frequency that so many whirls of the bare shaft do not exceed, however stations hold it [rad/s]."""
        shorts = [self.sections[i].lengths[0] / self.sections[i].lengths[2] for i, _ in self.spans]
        phases = sum(span.phase(1.0) * short for span, short in zip(spans, shorts, strict=True))
        return ((modes + len(self.stations) - 0.5) * math.pi / phases) ** 2 if modes else 0.0

    def bent(self, name: str) -> tuple[str, ...]:
        """Both ends of every span, where bending is asked for: what a rotor called so stands for; none of matrices."""
        if self.matrices is not None:
            return ()
        return tuple(one for k in range(len(self.spans)) for one in ends_of_span(name, k))

    def add_to(self, builder: ModelBuilder, name: str, symbols: Symbols) -> None:
        """Energies of the shaft, and of the discs; polar inertia counts in forward whirl alone."""
        if self.matrices is not None:
            builder.remarks.append(add_planes(builder, name, self.matrices.planes, self.lags))
        else:
            self._add_sections(builder, name, symbols)
        for j, disc in enumerate(self.discs):
            masses, diametral, polar = disc.inertias(f"rotors.{name}.discs.{j + 1}", symbols)
            tilt = {coordinate(name, 2 * self.node(self.places[disc.name]) + 1): 1.0}
            for mass in masses:
                builder.add_inertia(disc.name, mass, name)
            for moment in diametral:
                builder.add_term(INERTIA, tilt, moment, name, 0.0)
            for moment in polar:
                builder.add_polar(tilt, moment, name)

    def _add_sections(self, builder: ModelBuilder, name: str, symbols: Symbols) -> None:
        """Energies of the shaft by its sections."""
        beam = self.beam(builder.top, builder.modes)
        for k, (i, _) in enumerate(self.spans):
            section, path = self.sections[i], f"rotors.{name}.sections.{i + 1}"
            wide = symbols.read(f"{path}.diameter", section.diameter)
            area = (wide**2.0).times(0.25 * math.pi * (1.0 - bore(section) ** 2))
            second = (wide**4.0).times(math.pi * (1.0 - bore(section) ** 4) / 64.0)
            long = symbols.read(f"{path}.length", section.length).times(1.0 / beam.lengths[k]) if section.free else None
            self._add_span(builder, name, beam, k, (area, second, self.sheared(section)), long)
            stress = (wide**-3.0).times(32.0 / (math.pi * (1.0 - bore(section) ** 4)))
            for single in ends_of_span(name, k):
                builder.counts[stressed(single)] = stress**-1.0
        builder.remarks.append(self._remark(name, beam, builder))

    def _remark(self, name: str, beam: Beam, builder: ModelBuilder) -> str:
        """How good the polynomials are, for the answer."""
        thin, thick = self._extremes()
        top = max(builder.top, self._reach(thick, builder.modes))
        moved = max(span.degree(top)[1] for span in thin)
        least, most = min(beam.degrees), max(beam.degrees)
        degrees = f"degree {most}" if least == most else f"degrees {least} to {most}"
        many = counted(len(thin), "spans")
        return (
            f"{name}: {many} of Timoshenko's beam in polynomials of {degrees}; one degree more moves "
            f"its stiffness by less than {max(moved, 1e-15):.0e} up to {top * 30.0 / math.pi:.4g} rpm"
        )

    def _add_span(
        self, builder: ModelBuilder, name: str, beam: Beam, k: int, section: tuple[Monomial, Monomial, float],
        stretch: Monomial | None,
    ) -> None:  # fmt: skip
        """Energies between two nodes, `stretch` times as far apart as in the middle; the mean deflection weighs."""
        area, second, shear = section
        places, owner = [coordinate(name, i) for i in beam.coordinates(k)], f"{name}@{k + 1}"
        rows, long = shapes(beam.degrees[k], beam.lengths[k]), beam.lengths[k]
        far = Monomial(1.0) if stretch is None else stretch
        mass, rotary = area.times(self._given("density")) * far, second.times(self._given("density")) * far
        bends = second.times(self._given("modulus")) * far**-1.0
        lags, halves = self.lags, "" if stretch is None else "shear"
        kinds = (
            (STIFFNESS, rows.curvature, bends, ""),
            (STIFFNESS, rows.shear, area.times(shear), halves),
            (INERTIA, rows.deflection, mass, "weighs"),
            (INERTIA, rows.tilt, rotary, "tilts"),
        )
        for kind, table, size, does in kinds:
            for i, (row, share) in enumerate(zip(table, shares(len(table), long), strict=True)):
                static = 1.0 if kind == STIFFNESS or (does == "weighs" and i == 0) else 0.0
                one = size.times(float(share))
                tilted = rows.tilt[i] if does == "shear" else row
                for part, value in _squares(row, -tilted, one, far) if does == "shear" else ((row, one),):
                    parts = dict(zip(places, part.tolist(), strict=True))
                    tilts = float(part[1]), float(part[3])
                    apart = does == "shear" and part is not row
                    builder.add_term(kind, parts, value, owner, static, tilts, apart=apart)
                    if kind == STIFFNESS and lags:
                        builder.add_rotating_term(parts, value.times(lags), owner)
                    if does == "tilts":
                        builder.add_polar(parts, value.times(2.0), owner, tilts)

    def built(self, assembly: Assembly, name: str, numbers: Numbers) -> None:
        """The same shaft by its waves, of radii; or by the matrices of both planes."""
        discs = [
            waves.Disc(self.node(self.places[disc.name]), *disc.built(f"rotors.{name}.discs.{j + 1}", numbers))
            for j, disc in enumerate(self.discs)
        ]
        points = {point: self.node(place) for point, place in self.places.items()}
        if self.matrices is not None:
            assembly.shafts[name] = MatrixShaft(self.matrices.planes.both, tuple(discs), points, self.lags)
            return
        pieces = []
        for i, middle in self.spans:
            section, path = self.sections[i], f"rotors.{name}.sections.{i + 1}"
            long = numbers(f"{path}.length", section.length) if section.free else middle
            outer = 0.5 * numbers(f"{path}.diameter", section.diameter)
            inner = 0.5 * numbers(f"{path}.inner_diameter", section.inner_diameter)
            if section.inner_ratio is not None:
                inner = outer * numbers(f"{path}.inner_ratio", section.inner_ratio)
            area = math.pi * (outer - inner) * (outer + inner)
            second = 0.25 * area * (outer**2 + inner**2)
            bends, shears = self._given("modulus") * second, self.sheared(section) * area
            heavy = self._given("density")
            pieces.append(waves.Section(long, bends, shears, heavy * area, heavy * second, outer / second))
        phases = sum(piece.length * (piece.mass / piece.bending) ** 0.25 for piece in pieces)
        reach = ((assembly.modes + len(points)) * math.pi / phases) ** 2 if assembly.modes else 0.0
        top = max(assembly.top, reach)
        assembly.shafts[name] = waves.WhirlingShaft(tuple(pieces), tuple(discs), points, top, self.lags)


def _squares(
    row: FloatArray, tilt: FloatArray, size: Monomial, far: Monomial
) -> tuple[tuple[FloatArray, Monomial], ...]:
    """Shear of a span that is s times as long as one on which it is p + t, the slope p and `tilt` t.

    s (p / s + t)^2 = p^2 / s + s t^2 + (p + t)^2 - p^2 - t^2: squares with factors that are powers of s.
    """
    slope = row - tilt
    return (
        (row, size), (slope, size * far**-1.0), (slope, size.times(-1.0)), (tilt, size * far), (tilt, size.times(-1.0)),
    )  # fmt: skip


def add_planes(builder: ModelBuilder, name: str, planes: "Planes", lags: float) -> str:
    """Energies of a shaft by its matrices, each a sum of squares, and what to say of it."""
    n = len(planes.mass)
    moves = np.tile([1.0, 0.0], n // 2)
    pushed = planes.mass @ moves
    weight = float(moves @ pushed)

    def squares(matrix: FloatArray, size: FloatArray, least: int = 0) -> Iterator[tuple[dict[str, float], float]]:
        """Of a scaled matrix, without so many of its lowest values: rows over the coordinates, and their factors."""
        values, ways = np.linalg.eigh(matrix / np.outer(size, size))
        for value, way in list(zip(values.tolist(), ways.T, strict=True))[least:]:
            if value > _NOTHING * values[-1]:
                yield {coordinate(name, i): float(one) for i, one in enumerate(size * way)}, value

    own, stiff = np.sqrt(np.diag(planes.mass)), np.sqrt(np.diag(planes.stiffness))
    along = {coordinate(name, i): float(one) for i, one in enumerate(pushed / weight)}
    builder.add_term(INERTIA, along, Monomial(weight), name)  # on which gravity acts; the rest it has no hold on
    for row, value in squares(planes.mass - np.outer(pushed, pushed) / weight, own, 1):
        builder.add_term(INERTIA, row, Monomial(value), name, 0.0)
    for row, value in squares(planes.stiffness, stiff, 2):  # it may move and tilt freely
        builder.add_term(STIFFNESS, row, Monomial(value), name)
        if lags:
            builder.add_rotating_term(row, Monomial(value * lags), name)
    if planes.damping.any():
        for row, value in squares(planes.damping, own):
            builder.add_term(DAMPING, row, Monomial(value), name, 0.0)
    for row, value in squares(planes.polar, own) if planes.polar.any() else ():
        builder.add_polar(row, Monomial(value), name)
    builder.precision = max(builder.precision, planes.precision)
    return f"{name}: a shaft of {weight:.4g} kg by its matrices at {counted(n // 2, 'nodes')}, all of them used"


def ends_of_span(rotor: str, k: int) -> tuple[str, str]:
    """Names of the left and the right end of a span, that no link of a file can have."""
    return f"{rotor}@{k + 1}.left", f"{rotor}@{k + 1}.right"


def coordinate(rotor: str, index: int) -> str:
    """Name of a coordinate that no point of a file can have; two of each node, then those within sections."""
    return f"{rotor} [{index + 1}]"
