"""Stiffness as if it could be had at will, by SLSQP on sampled speeds, and then the nearest part of the shelf."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from vibopt.forms import FloatArray, IntArray
from vibopt.study.chart.mounts.machine import Machine
from vibopt.study.chart.mounts.shelf import Shelf
from vibopt.study.chart.mounts.simple import grid, missed

SPEEDS = 200
_ANY = 1e30
"""A load [N] that no part is asked to carry."""


def rounded_choice(machine: Machine, shelf: Shelf, shares: FloatArray) -> tuple[str, str, IntArray | None]:
    """Status, claim and choice.

    Price, loss factor and the softness of slow motion follow the stiffness by straight lines through the shelf, in
    logarithms.  Of the parts that carry their group's share the one with the nearest stiffness is bought.
    """
    from scipy.optimize import minimize

    if not len(shelf):
        return "unproven", "nothing to choose from", None
    low, high = np.log(shelf.k.min()), np.log(shelf.k.max())
    speeds = grid(machine, SPEEDS)
    counts = np.array([len(places) for places in machine.groups])
    chosen = np.arange(len(counts))[None, :]

    def keeps(y: FloatArray) -> float:
        """Above zero where every limit but the loads holds at the sampled speeds."""
        worst = float(missed(machine, made(shelf, y), chosen, speeds)[0])
        return -worst if np.isfinite(worst) else -1e3

    def cost(y: FloatArray) -> float:
        return float(made(shelf, y).price @ counts) / float(shelf.price.mean())

    found: Any = minimize(
        cost,
        np.full(len(counts), 0.5 * (low + high)),
        method="SLSQP",
        bounds=[(low, high)] * len(counts),
        constraints=[{"type": "ineq", "fun": keeps}],
    )
    if not found.success:
        return "unproven", f"SLSQP: {found.message}", None
    carries = (shelf.least <= shares[:, None]) & (shares[:, None] <= shelf.most)
    if not carries.any(axis=1).all():
        return "unproven", "no part carries its share", None
    far = np.where(carries, np.abs(np.log(shelf.k) - found.x[:, None]), np.inf)
    return "feasible", "nearest stiffness that carries its share", far.argmin(axis=1)


def made(shelf: Shelf, y: FloatArray) -> Shelf:
    """Parts of the stiffnesses exp(y) (n,), their other columns by straight lines through the shelf."""

    def line(values: FloatArray) -> FloatArray:
        if np.ptp(shelf.k) == 0.0 or (values <= 0.0).any():
            return np.full(len(y), values.mean())
        return np.asarray(np.exp(np.polyval(np.polyfit(np.log(shelf.k), np.log(values), 1), y)))

    free = np.full(len(y), _ANY)
    return replace(
        shelf, least=-free, most=free, k=np.exp(y), shear=line(shelf.shear), static=line(shelf.static),
        loss=line(shelf.loss), price=line(shelf.price),
    )  # fmt: skip
