"""Devices that may exchange their numbers without any effect on what is asked: boxes need only hold one order."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations

import numpy as np

from vibopt.arrays import IntArray
from vibopt.forms.monomials import mounts
from vibopt.forms.rational import Groups, Sampled
from vibopt.program.program import Aim, Limit, Program
from vibopt.solve.hanging import SPRINGS

_SAME, _NOTHING = 1e-9, 1e-12
"""Part by which numbers that are the same may differ, and part of the greatest that is rounding."""
_Row = tuple[float, ...]


def orders(program: Program, asked: Sequence[Limit | Aim], lines: Mapping[int, Sampled]) -> list[tuple[int, int]]:
    """Variables (i, j) of which x_i <= x_j may be asked: any design has its like that keeps all of that.

    `asked` is all that counts, with N and D of each response at the same speeds in `lines`, by its id.
    """
    owners: dict[str, list[int]] = {}
    for index, axis in enumerate(program.axes):
        owners.setdefault(axis.path.rpartition(".")[0], []).append(index)
    found: list[tuple[int, int]] = []
    for one, other in combinations(owners, 2):
        order = np.arange(len(program.axes))
        mine, its = owners[one], owners[other]
        if one.split(".")[0] != other.split(".")[0] or len(mine) != len(its):
            continue
        order[mine], order[its] = its, mine
        if _ranges(program, order) and all(any(_become(a, b, order, lines) for b in asked) for a in asked):
            free = [
                pair for pair in zip(mine, its, strict=True) if program.axes[pair[0]].high > program.axes[pair[0]].low
            ]
            found += sorted(free, key=lambda pair: _word(program, pair[0]) not in SPRINGS)[:1]
    return found


def _word(program: Program, index: int) -> str:
    return program.axes[index].path.rpartition(".")[2]


def _ranges(program: Program, order: IntArray) -> bool:
    """Whether what is exchanged has the same word and the same range."""
    said = [(_word(program, i), axis.low, axis.high, axis.values) for i, axis in enumerate(program.axes)]
    return said == [said[i] for i in order.tolist()]


def _become(one: Limit | Aim, other: Limit | Aim, order: IntArray, lines: Mapping[int, Sampled]) -> bool:
    """Whether what is asked is the other thing with the variables in another order."""
    if isinstance(one, Limit) != isinstance(other, Limit) or _bounds(one) != _bounds(other):
        return False
    mine, its = one.form.powers, other.form.powers
    if mine is not None and its is not None:
        return _rows(mine.scale, mine.exponents[:, order]) == _rows(its.scale, its.exponents)
    if id(one) not in lines or id(other) not in lines or _shares(one, order) != _shares(other, np.arange(len(order))):
        return False
    return _same(lines[id(one)], lines[id(other)], order)


def _shares(asked: Limit | Aim, order: IntArray) -> list[_Row]:
    """By how many mounts a response is divided."""
    form = asked.form.harmonic
    shared = mounts(asked.model, form.output) if form is not None else None
    return [] if shared is None else _rows(shared.scale, shared.exponents[:, order])


def _bounds(one: Limit | Aim) -> tuple[str, float]:
    return (one.side, one.bound) if isinstance(one, Limit) else ("", one.sense)


def _rows(*columns: np.ndarray) -> list[_Row]:
    """Rows of numbers (n,) or (n, m), those of sizes rounded, in their order."""
    table = np.column_stack(columns).tolist()
    return sorted(tuple(float(f"{one:.10g}") for one in row) for row in table)


def _same(sampled: Sampled, other: Sampled, order: IntArray) -> bool:
    """Whether a response is the other with the variables in another order."""
    after, before = _members(sampled.groups, order), _members(other.groups, None)
    count = len(after)
    if sorted(after) != sorted(before) or sampled.count != other.count:
        return False
    there = [after.index(group) for group in before]
    if len(set(there)) < count or not np.allclose(sampled.scale[:, there], other.scale, rtol=_SAME, atol=0.0):
        return False
    for mine, its in ((sampled.top, other.top), (sampled.bottom, other.bottom)):
        turned = mine.reshape(-1, *([2] * count)).transpose(0, *(1 + g for g in there)).reshape(its.shape)
        room = np.maximum(_SAME * np.abs(its), _NOTHING * np.abs(its).max(axis=1, keepdims=True))
        if not (np.abs(turned - its) <= room).all():
            return False
    return True


def _members(groups: Groups, order: IntArray | None) -> list[list[_Row]]:
    """Of each group the kinds, sizes and exponents of its terms."""
    model = groups.model
    exponents = model.exponents if order is None else model.exponents[:, order]
    every = [list(one) for one in groups.members]
    return [_rows(model.kinds[one], model.scales[one], exponents[one]) for one in every]
