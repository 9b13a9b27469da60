"""Identical devices in a canonical order: heaviest first, then the one of lower frequency, in the order of the file.

Two absorbers with the same words may exchange their numbers without any effect.  Which of them has
which would be decided by rounding, so that names differed from machine to machine.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.devices import Device
from vibopt.program.program import Program
from vibopt.scene.open_places import numbers_of
from vibopt.scene.places import devices
from vibopt.scene.scene import Scene
from vibopt.solve.branch import Judge
from vibopt.solve.method import Found

_FALLING = ("mass", "mass_ratio", "inertia", "inertance", "torsional_inertance")
_RISING = ("frequency", "tuning", "stiffness", "torsional_stiffness", "damping_ratio", "damping", "torsional_damping")
_DIGITS = 9
"""Values that agree to so many digits are equal."""
_EQUAL = 1e-9


def in_order(scene: Scene, program: Program, found: Found) -> Found:
    """The answer with the numbers of identical devices exchanged into their order, where that changes no goal.

    Where it makes no difference how they share, as with springs side by side, they share evenly.
    """
    every = [] if found.x is None or program.ties else list(_alike(scene, program))
    if not every:
        return found
    x, judge = np.array(found.x, dtype=float), Judge(program)
    for groups in every:
        for there in (_even(x, groups, program), _exchanged(x, groups)):
            if (there == x).all() or _as_good(judge, x, there):
                x = there
                break
    return replace(found, x=x) if (x != found.x).any() else found


def _alike(scene: Scene, program: Program) -> Iterator[list[dict[str, int]]]:
    """Per set of identical devices, the index of each variable of each device, by its word."""
    for family in dict.fromkeys(family for family, _, table in devices(scene) if table.exchangeable):
        tables: Mapping[str, Device] = getattr(scene, family)
        left = [name for name in tables if _variables(program, family, name)]
        while len(left) > 1:
            said = numbers_of(tables[left[0]])
            same = [name for name in left if numbers_of(tables[name]) == said]
            left = [name for name in left if name not in same]
            if len(same) > 1:
                yield [_variables(program, family, name) for name in same]


def _variables(program: Program, family: str, name: str) -> dict[str, int]:
    head = f"{family}.{name}."
    return {axis.path.removeprefix(head): i for i, axis in enumerate(program.axes) if axis.path.startswith(head)}


def _even(x: FloatArray, groups: Sequence[dict[str, int]], program: Program) -> FloatArray:
    """The design with the mean of each number in all of the devices; listed values stay."""
    there = x.copy()
    for word in groups[0]:
        own = [group[word] for group in groups]
        if all(program.axes[i].values is None for i in own):
            there[own] = x[own].mean()
    return there


def _exchanged(x: FloatArray, groups: Sequence[dict[str, int]]) -> FloatArray:
    """The design with the numbers of each device given to the one whose turn it is."""
    words = list(groups[0])
    order = sorted(range(len(groups)), key=lambda g: _rank(x, groups[g]))
    there = x.copy()
    for place, taken in enumerate(order):
        for word in words:
            there[groups[place][word]] = x[groups[taken][word]]
    return there


def _rank(x: FloatArray, group: Mapping[str, int]) -> tuple[float, ...]:
    """Less comes first."""
    key = [-_rounded(x[group[word]]) for word in _FALLING if word in group]
    key += [_rounded(x[group[word]]) for word in _RISING if word in group]
    return (*key, *(_rounded(x[i]) for word, i in group.items() if word not in (*_FALLING, *_RISING)))


def _rounded(value: float) -> float:
    return float(f"{value:.{_DIGITS}g}")


def _as_good(judge: Judge, x: FloatArray, there: FloatArray) -> bool:
    """Whether the exchanged design has the same goal and keeps every limit that the other keeps."""
    here, other = judge.goal(x).value, judge.goal(there).value
    same = here == other or abs(here - other) <= _EQUAL * abs(here)
    return same and judge.feasible(there) >= judge.feasible(x)
