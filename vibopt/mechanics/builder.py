"""Collects what devices contribute and turns it into a Model."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from vibopt.forms import FloatArray
from vibopt.mechanics.model import DAMPING, HYSTERETIC, INERTIA, STIFFNESS, Model, Term
from vibopt.mechanics.monomial import Monomial

GROUND = "ground"


@dataclass
class ModelBuilder:
    """Coordinates first (free ones, then bases), terms after.  One coordinate a body for now."""

    n_vars: int
    free: list[str] = field(default_factory=list)
    bases: list[str] = field(default_factory=list)
    terms: list[Term] = field(default_factory=list)
    links: dict[str, FloatArray] = field(default_factory=dict)
    ends: dict[str, tuple[str, str]] = field(default_factory=dict)
    counts: dict[str, Monomial] = field(default_factory=dict)
    ratios: dict[str, Monomial] = field(default_factory=dict)

    @property
    def coords(self) -> list[str]:
        return self.free + self.bases

    def direction(self, point: str) -> FloatArray:
        """Unit row of a point's coordinate; zero for the ground.  Shape (n_coords,)."""
        row = np.zeros(len(self.coords))
        if point != GROUND:
            row[self.coords.index(point)] = 1.0
        return row

    def add_inertia(self, body: str, mass: Monomial) -> None:
        self._add(INERTIA, self.direction(body), mass, body)

    def add_link(self, name: str, between: tuple[str, str], count: Monomial) -> FloatArray:
        """Incidence of a link: its row . u is the extension, second end minus first [m]."""
        row = self.direction(between[1]) - self.direction(between[0])
        self.links[name] = row
        self.ends[name] = between
        self.counts[name] = count
        return row

    def add_stiffness(self, link: str, stiffness: Monomial, static: float) -> None:
        self._add(STIFFNESS, self.links[link], stiffness, link, static)

    def add_damping(self, link: str, damping: Monomial) -> None:
        self._add(DAMPING, self.links[link], damping, link)

    def add_hysteretic(self, link: str, stiffness: Monomial) -> None:
        self._add(HYSTERETIC, self.links[link], stiffness, link)

    def _add(self, kind: int, row: FloatArray, value: Monomial, owner: str, static: float = 1.0) -> None:
        exponents = value.row(self.n_vars)
        self.terms.append(Term(kind, row, value.scale, exponents, owner, value.scale * static))

    def build(self) -> Model:
        return Model(
            points={name: self.direction(name) for name in self.coords},
            n_free=len(self.free),
            terms=tuple(self.terms),
            links=self.links,
            ends=self.ends,
            counts=self.counts,
            ratios=self.ratios,
        )
