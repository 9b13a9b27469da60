"""Rows that read motions and link forces off a model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vibopt.mechanics.model import STIFFNESS, Model, Term
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
    found = link_forces(model, signs)
    return replace(found, signs=found.signs * [float(model.axes.get(term.owner, up) @ way) for term in model.terms])


def across_link(model: Model, link: str) -> Output:
    """Extension of a link."""
    return Output(model.links[link], np.zeros(len(model.terms)))


def forces_of_beam(model: Model, link: str, word: str) -> Output:
    """What spring, damper and mass of a beam do together, as `readings` of the model says; a stress knows no damper."""
    pulled, moved, shaped = model.readings[link, word]

    def reads(term: Term) -> float:
        if term.owner != link:
            return 0.0
        if term.across:
            return pulled * (term.kind == STIFFNESS or word != "stress")
        return moved if term.static_scale else shaped

    return Output(np.zeros(model.n_coords), np.array([reads(term) for term in model.terms]))


def link_forces(model: Model, signs: dict[str, float]) -> Output:
    """Sum of the forces of links, as impedance times extension: 1 on the first end of one, -1 on its second."""

    def pulls(term: Term) -> float:
        sign = signs.get(term.owner, 0.0)
        if term.across:
            return sign
        return -abs(sign) * term.shares[0 if sign > 0.0 else 1]  # the mass of a beam: on its first end, on its second

    held = tuple(signs.items()) if model.bearings or model.rotating else ()
    return Output(np.zeros(model.n_coords), np.array([pulls(term) for term in model.terms]), held=held)
