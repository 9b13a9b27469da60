"""Rows that read motions and link forces off a model."""

from __future__ import annotations

import numpy as np

from vibopt.mechanics.model import Model
from vibopt.signals import Output
from vibopt.values.directions import AXES, Vector


def at_point(model: Model, point: str, power: int = 0) -> Output:
    """Displacement of a point, times (i w)**power."""
    row = model.points.get(point, np.zeros(model.n_coords))
    return Output(row, np.zeros(len(model.terms)), power)


def along(model: Model, point: str, way: Vector, *, power: int = 0, turn: bool = False) -> Output:
    """Displacement of a place in space along a direction, or its rotation about it, times (i w)**power."""
    kind = ".r" if turn else "."
    parts = [part * model.points[f"{point}{kind}{axis}"] for part, axis in zip(way, AXES, strict=True)]
    return Output(np.sum(parts, axis=0), np.zeros(len(model.terms)), power)


def along_mount(model: Model, mount: str, way: Vector) -> Output:
    """Second end of a mount less its first, along a direction."""
    rows = [float(model.axes[f"{mount}.{axis}"] @ way) * model.links[f"{mount}.{axis}"] for axis in AXES]
    return Output(np.sum(rows, axis=0), np.zeros(len(model.terms)))


def forces_along(model: Model, signs: dict[str, float], way: Vector) -> Output:
    """Sum of the forces of links and mounts along a direction, each with its sign; a link acts along z."""
    up = np.array([0.0, 0.0, 1.0])
    return link_forces(model, {link: sign * float(model.axes.get(link, up) @ way) for link, sign in signs.items()})


def across_link(model: Model, link: str) -> Output:
    """Extension of a link."""
    return Output(model.links[link], np.zeros(len(model.terms)))


def link_forces(model: Model, signs: dict[str, float]) -> Output:
    """Sum of the forces of links, each with its sign, as impedance times extension."""
    row = [signs.get(term.owner, 0.0) if term.across else 0.0 for term in model.terms]
    return Output(np.zeros(model.n_coords), np.array(row))
