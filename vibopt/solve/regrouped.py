"""Designs beside one of several like devices: two exchanged."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from vibopt.arrays import BoolArray, FloatArray
from vibopt.mechanics.model import INERTIA, Model
from vibopt.program.program import Program

_SCALED = {"stiffness", "damping"}
"""Numbers of a device that go with the mass that hangs on it."""


def likes(program: Program) -> list[tuple[list[int], list[int], BoolArray, BoolArray]]:
    """Variables of every two devices of a family that both have, in the same order; of each the terms of its mass."""
    owners: dict[str, dict[str, int]] = {}
    for index, axis in enumerate(program.axes):
        owner, _, word = axis.path.rpartition(".")
        owners.setdefault(owner, {})[word] = index
    found = []
    for (one, a), (other, b) in combinations(owners.items(), 2):
        both = [word for word in a if word in b]
        if len(both) > 1 and one.split(".")[0] == other.split(".")[0]:
            masses = _masses(program.model, one, other), _masses(program.model, other, one)
            found.append(([a[word] for word in both], [b[word] for word in both], *masses))
    return found


def _masses(model: Model, one: str, other: str) -> BoolArray:
    """Which terms (n_terms,) are the mass of a device, or what it carries at the end that it does not share."""
    name, its = (path.partition(".")[2] for path in (one, other))
    heavy = [term.owner if term.kind == INERTIA else "" for term in model.terms]
    ends = set(model.ends.get(name, ())) - set(model.ends.get(its, ()))
    return np.isin(heavy, [name] if name in heavy else list(ends))


def exchanged(
    program: Program, y: FloatArray, first: list[int], second: list[int], mine: BoolArray, its: BoolArray
) -> FloatArray:
    """Log of a design (n_vars,) with the numbers of two devices exchanged, those that go with a mass in its ratio."""
    there = y.copy()
    there[first], there[second] = y[second], y[first]
    before, after = (program.model.values(np.exp(one)) for one in (y, there))
    scaled = np.array([axis.path.rpartition(".")[2] in _SCALED for axis in program.axes])
    for own, taken, given in ((first, mine, its), (second, its, mine)):
        if taken.any() and given.any():
            there[own] += scaled[own] * np.log(after[taken].sum() / before[given].sum())
    return there
