"""Collects what devices contribute and turns it into a Model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import field

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.mechanics.bearings import Bearing
from vibopt.mechanics.model import DAMPING, HYSTERETIC, INERTIA, STIFFNESS, Model, Term
from vibopt.mechanics.monomial import Monomial
from vibopt.records import dataclass

GROUND = "ground"
EVERY_MODE = 10**9
"""As many modes of structures as there are, for what holds every frequency."""
MOST_WHOLE = 100
"""Coordinates with mass of a structure of which every mode is carried."""
_AXES, _TURNS = ("x", "y", "z"), ("rx", "ry", "rz")


@dataclass
class ModelBuilder:
    """Coordinates first (free ones, then bases), terms after.

    A point is a row over the coordinates: a body has a coordinate of its own, a point of a structure
    may read many.

    points
        Per point the parts that it takes of each coordinate, by name.
    masses
        Inertia of a point, where it is one product of powers [kg] or [kg m^2].
    references
        Per device that is tuned to the rest, the frequency that it is tuned to [rad/s].
    turning
        Points that turn about an axis instead of moving along a line.
    properties
        Own numbers of a device by its name and the word for them, ("tmd", "tuning").
    rotating, readings, gears
        As of `Model`.
    families
        Names by the family of the file that they come from.
    top, modes
        How high structures are looked at [rad/s], and how many of their lowest modes are asked for.
    left_out, precision, remarks
        Degrees of freedom of structures that are not needed, the relative error of what is left, and its words.
    frames
        Bodies in space: their centre [m] and the words of their coordinates.
    fixed
        Places on bodies in space, by name: the body and the place [m].
    spatial
        Bases that may move in any direction.
    guides
        Per absorber in space what carries it, a body or another one, and where [m].
    axes
        Per link of a mount, and per absorber, its direction in space, shape (3,).
    """

    n_vars: int
    top: float = 1.0
    modes: int = 0
    left_out: int = 0
    precision: float = 0.0
    remarks: list[str] = field(default_factory=list)
    free: list[str] = field(default_factory=list)
    bases: list[str] = field(default_factory=list)
    points: dict[str, dict[str, float]] = field(default_factory=dict)
    terms: list[Term] = field(default_factory=list)
    links: dict[str, FloatArray] = field(default_factory=dict)
    ends: dict[str, tuple[str, str]] = field(default_factory=dict)
    counts: dict[str, Monomial] = field(default_factory=dict)
    ratios: dict[str, Monomial] = field(default_factory=dict)
    masses: dict[str, Monomial] = field(default_factory=dict)
    references: dict[str, Monomial] = field(default_factory=dict)
    turning: dict[str, bool] = field(default_factory=dict)
    properties: dict[tuple[str, str], Monomial] = field(default_factory=dict)
    rotating: list[Term] = field(default_factory=list)
    bearings: list[Bearing] = field(default_factory=list)
    readings: dict[tuple[str, str], tuple[float, float, float]] = field(default_factory=dict)
    gears: dict[str, tuple[str, float]] = field(default_factory=dict)
    families: dict[str, tuple[str, ...]] = field(default_factory=dict)
    frames: dict[str, tuple[FloatArray, tuple[str, ...]]] = field(default_factory=dict)
    fixed: dict[str, tuple[str, FloatArray]] = field(default_factory=dict)
    spatial: tuple[str, ...] = ()
    guides: Mapping[str, tuple[str, Sequence[float]]] = field(default_factory=dict)
    axes: dict[str, FloatArray] = field(default_factory=dict)

    @property
    def coords(self) -> list[str]:
        return self.free + self.bases

    def add_coordinate(self, name: str) -> None:
        """A free coordinate."""
        self.free.append(name)

    def add_base(self, name: str) -> None:
        """A coordinate that is prescribed, and the point of the same name."""
        self.bases.append(name)
        self.add_point(name, {name: 1.0})

    def add_spatial_base(self, name: str) -> None:
        """A support prescribed in three directions; as a point of a line it is the vertical one."""
        for axis in _AXES:
            self.bases.append(f"{name}.{axis}")
            self.add_point(f"{name}.{axis}", {f"{name}.{axis}": 1.0})
        self.add_point(name, {f"{name}.z": 1.0})

    def add_frame(self, name: str, centre: Sequence[float], freedoms: tuple[str, ...]) -> None:
        """A body in space with its coordinates, and the points that read them."""
        self.frames[name] = (np.array(centre), freedoms)
        for axis in freedoms:
            self.add_coordinate(f"{name}.{axis}")
        for axis in (*_AXES, *_TURNS):
            self.add_point(f"{name}.{axis}", {f"{name}.{axis}": 1.0} if axis in freedoms else {})

    def fix(self, name: str, body: str, at: Sequence[float]) -> None:
        """A place on a body in space, by name."""
        self.fixed[name] = (body, np.array(at))
        for k, axis in enumerate(_AXES):
            self.add_point(f"{name}.{axis}", self.motion_at(body, at)[k])
            self.add_point(f"{name}.r{axis}", self.points.get(f"{body}.r{axis}", {}))

    def add_slider(self, name: str, way: Sequence[float]) -> None:
        """A mass that slides along a direction of what carries it, and goes with it across: its stroke, and its points.

        Under its own name the point is read along the direction.
        """
        self.add_coordinate(name)
        self.axes[name] = np.array(way)
        host, at = self.guides[name]
        moved: dict[str, float] = {}
        for axis, part, motion in zip(_AXES, way, self.motion_at(name, at), strict=True):
            self.add_point(f"{name}.{axis}", motion)
            self.add_point(f"{name}.r{axis}", self.points[f"{host}.r{axis}"])
            for coordinate, value in motion.items():
                moved[coordinate] = moved.get(coordinate, 0.0) + part * value
        self.add_point(name, moved)

    def add_mass_of_slider(self, name: str, mass: Monomial) -> None:
        """Its mass [kg] along each axis, and the link that is its stroke."""
        for axis in _AXES:
            if self.points[f"{name}.{axis}"]:
                self.add_inertia(f"{name}.{axis}", mass, name, weighs=axis == "z")
        self.links[name] = np.array([float(one == name) for one in self.coords])
        self.ends[name] = (self.guides[name][0], name)
        self.counts[name] = Monomial(1.0)

    def motion_at(self, place: str, at: Sequence[float]) -> list[dict[str, float]]:
        """Displacement along x, y, z of what is at a place [m] on a body, base or the ground, over the coordinates.

        u + theta x r; what knows one coordinate only moves along z.
        """
        if place == GROUND:
            return [{}, {}, {}]
        if place in self.spatial:
            return [{f"{place}.{axis}": 1.0} for axis in _AXES]
        if place in self.guides:
            under = self.motion_at(self.guides[place][0], at)
            return [{**one, place: part} if part else one for one, part in zip(under, self.axes[place], strict=True)]
        if place not in self.frames:
            return [{}, {}, dict(self.points[place])]
        centre, freedoms = self.frames[place]
        x, y, z = (float(one) for one in np.asarray(at) - centre)
        arms = ({"x": 1.0, "ry": z, "rz": -y}, {"y": 1.0, "rx": -z, "rz": x}, {"z": 1.0, "rx": y, "ry": -x})
        return [{f"{place}.{axis}": part for axis, part in arm.items() if axis in freedoms and part} for arm in arms]

    def add_spring_at(self, name: str, between: tuple[str, str], at: Sequence[float], axis: FloatArray) -> None:
        """A link of a mount along one direction at a place: its row . u is the extension, second end minus first."""
        row = np.zeros(len(self.coords))
        for sign, end in ((-1.0, between[0]), (1.0, between[1])):
            for part, motion in zip(axis, self.motion_at(end, at), strict=True):
                for coordinate, value in motion.items():
                    row[self.coords.index(coordinate)] += sign * float(part) * value
        self.links[name] = row
        self.ends[name] = between
        self.counts[name] = Monomial(1.0)
        self.axes[name] = np.asarray(axis, dtype=float)

    def add_point(self, name: str, row: Mapping[str, float]) -> None:
        """A point that moves by the sum of its parts of the coordinates."""
        self.points[name] = dict(row)

    def add_gear(self, name: str, to: str, ratio: float) -> None:
        """A point that turns so many times as fast as another one."""
        self.points[name], self.gears[name] = {}, (to, ratio)

    def direction(self, point: str) -> FloatArray:
        """Row of a point over the coordinates; zero for the ground.  Shape (n_coords,)."""
        row = np.zeros(len(self.coords))
        if point in self.gears:
            to, ratio = self.gears[point]
            return ratio * self.direction(to)
        if point != GROUND:
            for coordinate, part in self.points[point].items():
                row[self.coords.index(coordinate)] = part
        return row

    def add_inertia(self, point: str, inertia: Monomial, owner: str = "", *, weighs: bool = True) -> None:
        """Inertia that moves with a point; `weighs` where gravity acts on it along the coordinate."""
        self._add(INERTIA, self.direction(point), inertia, owner or point, 1.0 if weighs else 0.0)

    def add_link(self, name: str, between: tuple[str, str], count: Monomial) -> FloatArray:
        """Incidence of a link: its row . u is the extension, second end minus first [m]."""
        row = self.direction(between[1]) - self.direction(between[0])
        self.links[name] = row
        self.ends[name] = between
        self.counts[name] = count
        return row

    def add_mass_of_beam(self, link: str, mass: Monomial, mean: float, spread: float) -> None:
        """A mass [kg] spread between the ends of a link: its mean moves `mean` of the way from the second to the first.

        `spread` is the mean square of what its parts have beside that; gravity acts on the mean.
        """
        first, second = (self.direction(end) for end in self.ends[link])
        row = mean * first + (1.0 - mean) * second
        self._add(INERTIA, row, mass, link, shares=(mean, 1.0 - mean))
        self._add(INERTIA, first - second, mass.times(spread), link, 0.0, shares=(1.0, -1.0))

    def add_inertance(self, link: str, inertance: Monomial) -> None:
        """Force per relative acceleration of the two ends; gravity has no hold on it."""
        self._add(INERTIA, self.links[link], inertance, link, 0.0, across=True)

    def add_stiffness(self, link: str, stiffness: Monomial, static: float = 1.0) -> None:
        self._add(STIFFNESS, self.links[link], stiffness, link, static, across=True)

    def add_static_stiffness(self, link: str, stiffness: Monomial) -> None:
        """A stiffness that acts under weights alone."""
        row = self.links[link]
        self.terms.append(Term(STIFFNESS, row, 0.0, stiffness.row(self.n_vars), link, stiffness.scale, across=True))

    def add_damping(self, link: str, damping: Monomial) -> None:
        self._add(DAMPING, self.links[link], damping, link, across=True)

    def add_rotating(self, link: str, damping: Monomial) -> None:
        """A damper that turns with a shaft."""
        row, powers = self.links[link], damping.row(self.n_vars)
        self.rotating.append(Term(DAMPING, row, damping.scale, powers, link, damping.scale, across=True))

    def add_rotating_term(self, row: Mapping[str, float], damping: Monomial, owner: str) -> None:
        """As `add_rotating`, over the coordinates themselves, by name."""
        vector = np.array([row.get(name, 0.0) for name in self.coords])
        self.rotating.append(Term(DAMPING, vector, damping.scale, damping.row(self.n_vars), owner, 0.0))

    def add_bearing(
        self, name: str, powers: tuple[Monomial, ...], speeds: FloatArray | None = None, table: FloatArray | None = None
    ) -> None:
        """A bearing that is not alike in both planes, on a link that is there: coefficients as of `Bearing`."""
        none = np.zeros(0)
        speeds, table = none if speeds is None else speeds, none if table is None else table
        self.bearings.append(Bearing(name, self.links[name], powers, speeds, table))

    def add_hysteretic(self, link: str, stiffness: Monomial) -> None:
        self._add(HYSTERETIC, self.links[link], stiffness, link, across=True)

    def add_term(
        self, kind: int, row: Mapping[str, float], value: Monomial, owner: str, static: float = 1.0,
        tilts: tuple[float, float] = (0.0, 0.0), *, apart: bool = False,
    ) -> None:  # fmt: skip
        """A term over the coordinates themselves, by name; `static` times it is what acts under weights alone."""
        vector = np.array([row.get(name, 0.0) for name in self.coords])
        exponents, weighs = value.row(self.n_vars), value.scale * static
        self.terms.append(Term(kind, vector, value.scale, exponents, owner, weighs, tilts=tilts, apart=apart))

    def add_polar(
        self, row: Mapping[str, float], moment: Monomial, owner: str, tilts: tuple[float, float] = (0.0, 0.0)
    ) -> None:
        """Polar moment of inertia of what spins, over the coordinates that tilt it: it counts against the other one."""
        vector = np.array([row.get(name, 0.0) for name in self.coords])
        self.terms.append(
            Term(INERTIA, vector, -moment.scale, moment.row(self.n_vars), owner, 0.0, polar=True, tilts=tilts)
        )

    def _add(
        self,
        kind: int,
        row: FloatArray,
        value: Monomial,
        owner: str,
        static: float = 1.0,
        *,
        across: bool = False,
        shares: tuple[float, float] | None = None,
    ) -> None:
        exponents, weighs = value.row(self.n_vars), value.scale * static
        shares = shares or ((-1.0, 1.0) if across else (0.0, 0.0))
        self.terms.append(Term(kind, row, value.scale, exponents, owner, weighs, across, shares))

    def build(self) -> Model:
        return Model(
            points={name: self.direction(name) for name in self.points},
            n_free=len(self.free),
            terms=tuple(self.terms),
            links=self.links,
            ends=self.ends,
            counts=self.counts,
            ratios=self.ratios,
            properties=self.properties,
            readings=self.readings,
            rotating=tuple(self.rotating),
            gears=self.gears,
            bearings=tuple(self.bearings),
            families=self.families,
            axes=self.axes,
            left_out=self.left_out,
            remarks=tuple(self.remarks),
            precision=self.precision,
        )
