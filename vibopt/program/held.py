"""A program with some variables held at their values: fewer axes, the same question."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.mechanics.model import Model
from vibopt.program.program import Aim, Limit, Program

Part = TypeVar("Part", Limit, Aim)


def held(program: Program, x: FloatArray, free: Sequence[int]) -> Program:
    """The program in the variables `free` alone, the others at x (n_vars,)."""
    chosen = list(free)
    models: dict[int, Model] = {}

    def smaller(model: Model) -> Model:
        if id(model) not in models:
            models[id(model)] = model.held(np.array(chosen, dtype=int), x)
        return models[id(model)]

    def moved(part: Part) -> Part:
        return replace(part, model=smaller(part.model), form=part.form.held(x, chosen))

    limits = tuple(moved(limit) for limit in program.limits)
    aim = program.aim
    if aim is not None:
        aim = replace(moved(aim), others=tuple(moved(other) for other in aim.others))
    axes = tuple(program.axes[i] for i in chosen)
    return replace(program, model=smaller(program.model), axes=axes, limits=limits, aim=aim)
