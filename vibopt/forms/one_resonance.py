"""Lower bound of a resonance of one mass on boxes of designs: all links between the same two points."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.mechanics.harmonic import bordered
from vibopt.mechanics.model import DAMPING, HYSTERETIC, INERTIA, STIFFNESS, Model, factors

if TYPE_CHECKING:
    from vibopt.forms.modulus import Modulus


def applies(model: Model, form: Modulus) -> bool:
    """Whether numerators grow with every spring, damper, mass and frequency: all links between the same two points."""
    if model.inerters.any() or model.with_beams or model.n_free != 1:
        return False
    if len(form.drives) != 1 or len(form.drives[0].lines) != 1:
        return False
    if form.rigid_link or form.output.shared_by or len(form.drives[0].lines[0].amplitude.pieces) != 1:
        return False
    links = model.vectors[model.kinds != INERTIA]
    same = bool(len(links)) and bool(np.all(np.abs(links) == np.abs(links[0])))
    signs = set(form.output.signs[model.kinds != INERTIA] * links[:, 0]) if same else {0.0, 1.0}
    return same and len(signs) == 1 and not form.drives[0].lines[0].amplitude.pieces[0].slope


def resonant_floor(model: Model, form: Modulus, low: FloatArray, high: FloatArray) -> FloatArray:
    """Lower bound of the greatest value on boxes (n_boxes, n_vars), shape (n_boxes,); 0 where it says nothing."""
    small, large = model.extent(low, high)
    square = model.vectors[:, 0] ** 2

    def total(values: FloatArray, kind: int) -> FloatArray:
        return np.asarray((values * (model.kinds == kind)) @ square, dtype=float)

    with np.errstate(divide="ignore", invalid="ignore"):
        slow = np.sqrt(total(small, STIFFNESS) / total(large, INERTIA))
        fast = np.sqrt(total(large, STIFFNESS) / total(small, INERTIA))
    drive = form.drives[0]
    line = drive.lines[0]
    inside = np.zeros(len(low), dtype=bool)
    for band in drive.bands:
        inside |= (slow >= line.order * band.low) & (fast <= line.order * band.high)
    floor = np.zeros(len(low))
    if not inside.any():
        return floor
    slow, fast = slow[inside], fast[inside]
    z = small[inside] * factors(model.kinds, slow)
    _, border = bordered(model, z, form.output, line.vector)
    top = np.abs(border[:, 0, 0] * border[:, 1, 1] - border[:, 0, 1] * border[:, 1, 0])
    piece = line.amplitude.pieces[0]
    power = form.output.power + piece.power
    weight = abs(piece.constant) * (slow if power >= 0 else fast) ** power / line.order**piece.power
    bottom = fast * total(large[inside], DAMPING) + total(large[inside], HYSTERETIC)
    with np.errstate(divide="ignore", invalid="ignore"):
        floor[inside] = np.nan_to_num(top * weight / bottom, nan=0.0, posinf=np.inf)
    return floor
