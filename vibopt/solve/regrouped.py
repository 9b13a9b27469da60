"""Designs beside one of several devices: two exchanged, one left out, divided in two or tuned next to another."""

from __future__ import annotations

from itertools import combinations, permutations, product

import numpy as np

from vibopt.arrays import BoolArray, FloatArray
from vibopt.mechanics.model import INERTIA, Model
from vibopt.program.program import Program
from vibopt.solve.screen import SPRINGS, MassOnSpring, masses_on_springs

_SCALED = {"stiffness", "damping"}
"""Numbers of a device that go with the mass that hangs on it."""
_IDLE, _NONE, _BESIDE, _NEAR = 1.5, 1e-6, 0.05, 0.02
"""How much heavier than the lightest a device may be that does little, what counts as nothing, and how far it is tuned
from what it is half of."""


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


def left_out(program: Program) -> list[tuple[list[int], int]]:
    """Of each device whose mass is to be chosen, where there are several, its variables and which of them is its mass.

    One of those with like ranges on the same host.
    """
    hung = masses_on_springs(program)
    return [(list(one.axes.values()), one.weight) for one in _unlike(program, hung)] if len(hung) > 1 else []


def divided(program: Program, x: FloatArray) -> list[FloatArray]:
    """Designs (n_vars,) in which a device next to as light as it may be takes half of another, both tuned apart."""
    hung, found = [one for one in masses_on_springs(program) if one.weight >= 0], list[FloatArray]()
    least = [_IDLE * max(axis.low, _NONE * axis.high) for axis in program.axes]
    idle = _unlike(program, [one for one in hung if x[one.weight] <= least[one.weight]])
    for one, other, way in product(idle, hung, (1.0 - _BESIDE, 1.0 + _BESIDE)):
        if set(one.axes) != set(other.axes) or x[other.weight] <= least[other.weight]:
            continue
        y = x.copy()
        for word, i in other.axes.items():
            part = 1.0 if word in SPRINGS - {"stiffness"} or word == "damping_ratio" else 0.5
            apart = way ** {"stiffness": 2.0}.get(word, float(word in SPRINGS))
            y[i], y[one.axes[word]] = part * x[i] * apart, part * x[i] / apart
        found.append(np.clip(y, program.low, program.high))
    return found


def retuned(program: Program, x: FloatArray) -> list[FloatArray]:
    """Designs (n_vars,) in which one device is tuned next to another, as far damped as it was."""
    hung, found = [one for one in masses_on_springs(program) if one.last], list[FloatArray]()
    speeds = [_own(one, x) for one in hung]
    for (one, w), (other, v) in permutations(zip(hung, speeds, strict=True), 2):
        ratio = v / w * (1.0 + _NEAR * np.sign(w - v))
        if one is not other and abs(np.log(ratio)) > _NEAR:
            y = x.copy()
            for word, i in one.axes.items():
                y[i] *= ratio ** {"stiffness": 2.0, "damping": 1.0}.get(word, float(word in SPRINGS))
            found.append(np.clip(y, program.low, program.high))
    return found


def _own(one: MassOnSpring, x: FloatArray) -> float:
    """Frequency of a device on a host at rest, in whatever it is told."""
    word = next(word for word in one.axes if word in SPRINGS)
    mass = one.mass or (x[one.weight] if one.weight >= 0 else 1.0)
    return float(np.sqrt(x[one.axes[word]] / mass)) if word == "stiffness" else float(x[one.axes[word]])


def _unlike(program: Program, hung: list[MassOnSpring]) -> list[MassOnSpring]:
    """Those on which nothing rides and whose mass is to be chosen, one of those with like ranges on the same host."""
    found: dict[tuple[object, ...], MassOnSpring] = {}
    for one in hung:
        if one.weight >= 0:
            ends = [(word, program.axes[i].low, program.axes[i].high) for word, i in sorted(one.axes.items())]
            found.setdefault((one.host, *ends), one)
    return list(found.values())
