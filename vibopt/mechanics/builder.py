"""Collects what devices contribute and turns it into a Model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from vibopt.forms import FloatArray
from vibopt.mechanics.model import DAMPING, HYSTERETIC, INERTIA, STIFFNESS, Model, Term
from vibopt.mechanics.monomial import Monomial

GROUND = "ground"


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
    families
        Names by the family of the file that they come from.
    top, modes
        How high structures are looked at [rad/s], and how many of their lowest modes are asked for.
    left_out, remarks
        Degrees of freedom of structures that are not needed, and what is to be said of them.
    """

    n_vars: int
    top: float = 1.0
    modes: int = 0
    left_out: int = 0
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
    families: dict[str, tuple[str, ...]] = field(default_factory=dict)

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

    def add_point(self, name: str, row: Mapping[str, float]) -> None:
        """A point that moves by the sum of its parts of the coordinates."""
        self.points[name] = dict(row)

    def direction(self, point: str) -> FloatArray:
        """Row of a point over the coordinates; zero for the ground.  Shape (n_coords,)."""
        row = np.zeros(len(self.coords))
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

    def add_stiffness(self, link: str, stiffness: Monomial, static: float = 1.0) -> None:
        self._add(STIFFNESS, self.links[link], stiffness, link, static)

    def add_damping(self, link: str, damping: Monomial) -> None:
        self._add(DAMPING, self.links[link], damping, link)

    def add_hysteretic(self, link: str, stiffness: Monomial) -> None:
        self._add(HYSTERETIC, self.links[link], stiffness, link)

    def add_term(self, kind: int, row: Mapping[str, float], value: Monomial, owner: str, static: float = 1.0) -> None:
        """A term over the coordinates themselves, by name; `static` times it is what acts under weights alone."""
        vector = np.array([row.get(name, 0.0) for name in self.coords])
        self._add(kind, vector, value, owner, static)

    def _add(self, kind: int, row: FloatArray, value: Monomial, owner: str, static: float = 1.0) -> None:
        exponents = value.row(self.n_vars)
        self.terms.append(Term(kind, row, value.scale, exponents, owner, value.scale * static))

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
            families=self.families,
            left_out=self.left_out,
            remarks=tuple(self.remarks),
        )
