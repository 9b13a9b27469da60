"""Poles on boxes of designs: discs in which each machine of a box has some, and so the most that the least damped has.

With D(z + w) = sum c_k w^k, D the characteristic polynomial, k of its zeros lie within r of z where |c_k| r^k is more
than all other |c_j| r^j together (Rouche).  The c_k are polynomials in the variables, and their Bernstein coefficients
say how far they are from those at the middle of a box.  Of k poles one is no better damped than their mean: all that
are better lie in a half plane or a sector, which is convex.  With k = 1, z is a pole of the middle; with k = 2 and 3 it
lies between the least damped, which meet at the best: each moves by a root of the change, their mean smoothly.
"""

from __future__ import annotations

from math import comb
from typing import TYPE_CHECKING

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.forms.characteristic import ROUNDING, circle, nodes, plain, powers, tables, typical_rate
from vibopt.forms.rational import expanded
from vibopt.mechanics.model import HYSTERETIC, STIFFNESS, Model
from vibopt.mechanics.modes import rigid_count
from vibopt.signals import Output

if TYPE_CHECKING:
    from vibopt.forms.bounds import FormBounds
    from vibopt.forms.damped import OfPoles
    from vibopt.forms.form import Bounds

_BODIES, _HELD, _NOTHING = 6, 1e-9, 1e-14
"""Free coordinates, each of which is two poles; part of the greatest stiffness that hardly holds; one that is none."""
_TOGETHER = 3
"""Poles of which the mean is looked at, at most."""
_ROUNDS, _WIDER = 12, 1.0 + 1e-3
"""In which the radius of a disc is found, and how much wider it is made, so that it is one."""


def bounded(model: Model) -> bool:
    """Whether the polynomial is known, and that springs hold every motion, or it drifts: nothing holds it."""
    if model.spins or model.mixed or model.massless.any() or (model.kinds == HYSTERETIC).any():
        return False
    n = model.n_free
    if not 0 < n <= _BODIES:
        return False
    springs = model.vectors[(model.kinds == STIFFNESS) & (model.scales > 0.0), :n]
    held = np.linalg.eigvalsh(springs.T @ springs)  # of springs all as stiff: each may be anything
    drifts = int((held < _NOTHING * held[-1]).sum())
    free = drifts < n and rigid_count(model, model.scales) == 2 * drifts  # no damper holds what springs do not
    return free and bool((held[drifts:] > _HELD * held[-1]).all())


def on_boxes(form: OfPoles, known: FormBounds, low: FloatArray, high: FloatArray) -> Bounds:
    """Bounds of the number of the least damped pole on boxes low, high (n_boxes, n_vars), (n_boxes,) each."""
    model = known.model
    rate, order = typical_rate(model, known.reference), 2 * model.n_free
    if ("", 0) not in known.samples:
        still = Output(np.zeros(model.n_coords), np.zeros(len(model.terms)))
        none = np.zeros(model.n_coords, dtype=complex)
        known.samples["", 0] = expanded(model, still, none, circle(model, rate), known.reference)
    made = known.samples["", 0]

    drift = rigid_count(model, model.scales)  # numbers that are zero
    own = powers(made.at(0.5 * (low + high)[:, None])[1])[:, 0, drift : order + 1]
    on_nodes = powers(made.at(nodes(made.groups, low, high))[1])[..., drift : order + 1]
    boxes = np.array([plain(one) for one in tables(on_nodes, made.groups)])
    most, centers = np.full(len(low), np.inf), _centers(form, own)
    sizes = np.abs([center for center, count in centers if count == 1])
    lost = ROUNDING * (sizes.max(axis=0) / sizes.min(axis=0)) ** 2  # determinants lose what the stiffest is stiffer
    for center, count in centers:
        off = _off(*_sizes(boxes, own, center, lost), count)
        most = np.minimum(most, form.most_within(rate * center, rate * off))
    return np.zeros(len(low)), most


def _centers(form: OfPoles, numbers: FloatArray) -> list[tuple[ComplexArray, int]]:
    """Poles of polynomials (n, order + 1) by ascending powers, and means of the least damped, each with how many."""
    companion = np.zeros((len(numbers), numbers.shape[1] - 1, numbers.shape[1] - 1))
    companion[:, 1:, :-1] = np.eye(companion.shape[1] - 1)
    companion[:, :, -1] = -numbers[:, :-1] / numbers[:, -1:]
    poles = np.linalg.eigvals(companion).astype(complex)
    poles = np.where(poles.imag < 0.0, poles.conj(), poles)  # conjugate ones say the same
    poles = np.take_along_axis(poles, np.argsort(form.level(poles), axis=1, kind="stable"), axis=1)
    turning = poles[:, 0].imag > 0.0
    each = [(poles[:, i], 1) for i in range(0, poles.shape[1], 2)]
    if poles.shape[1] == 2:  # these meet on the real axis
        each.append((poles.real.mean(axis=1) + 0j, 2))
    for count in range(2, min(_TOGETHER, poles.shape[1] // 2) + 1):
        each.append((np.where(turning, poles[:, : 2 * count : 2].mean(axis=1), poles[:, :count].mean(axis=1)), count))
    return each


def _sizes(boxes: FloatArray, own: FloatArray, center: ComplexArray, lost: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The greatest and the least size that each c_k has on a box, (order + 1, n_boxes) each.

    boxes, own
        Bernstein coefficients of the numbers of D, (order + 1, n_boxes, m), and those in the middle.
    lost
        Part of them that is rounding, (n_boxes,).
    """
    order = len(boxes) - 1
    sizes = np.abs(boxes).max(axis=2)
    sizes = sizes + sizes.max(axis=0)
    most, least = np.empty((2, order + 1, len(center)))
    for k in range(order + 1):
        parts = np.array([comb(j, k) * center ** (j - k) for j in range(k, order + 1)])
        rounded = lost * (np.abs(parts) * sizes[k:]).sum(axis=0)
        middle = (parts * own.T[k:]).sum(axis=0)
        off = np.abs(np.einsum("jn,jnm->nm", parts, boxes[k:]) - middle[:, None]).max(axis=1) + rounded
        most[k], least[k] = np.abs(middle) + off, np.abs(middle) - off
    return most, least


def _off(most: FloatArray, least: FloatArray, count: int) -> FloatArray:
    """How far the mean of the `count` zeros in a disc is from its middle; infinite where no disc is found.

    Where D is zero, so is its divided difference: c_k-1 + c_k h_1 + c_k+1 h_2 + ..., h_m the complete homogeneous
    polynomials of the k zeros, and h_1 their sum.
    """
    others = [j for j in range(len(most)) if j != count]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        radius = (most[0] / least[count]) ** (1.0 / count)
        for _ in range(_ROUNDS):
            radius = (sum(most[j] * radius**j for j in others) / least[count]) ** (1.0 / count)
        radius = radius * _WIDER
        good = least[count] * radius**count > sum(most[j] * radius**j for j in others)
        further = [comb(j, count - 1) * most[j] * radius ** (j - count + 1) for j in others if j >= count - 1]
        off = sum(further) / (count * least[count])
    return np.where(good & (least[count] > 0.0), off, np.inf)
