"""Rows that read motions and link forces off a model."""

from __future__ import annotations

import numpy as np

from vibopt.forms import Output
from vibopt.mechanics.model import INERTIA, Model


def at_point(model: Model, point: str, power: int = 0) -> Output:
    """Displacement of a point, times (i w)**power."""
    row = model.points.get(point, np.zeros(model.n_coords))
    return Output(row, np.zeros(len(model.terms)), power)


def across_link(model: Model, link: str) -> Output:
    """Extension of a link."""
    return Output(model.links[link], np.zeros(len(model.terms)))


def link_forces(model: Model, signs: dict[str, float]) -> Output:
    """Sum of the forces of links, each with its sign, as impedance times extension."""
    row = [
        signs.get(term.owner, 0.0) if term.kind != INERTIA and term.owner in model.links else 0.0
        for term in model.terms
    ]
    return Output(np.zeros(model.n_coords), np.array(row))
