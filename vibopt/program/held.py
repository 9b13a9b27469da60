"""A program with some variables held at their values: fewer axes, the same question."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.mechanics.model import Model, Term
from vibopt.mechanics.monomial import Monomial
from vibopt.program.program import Aim, Limit, Program

Part = TypeVar("Part", Limit, Aim)


def held(program: Program, x: FloatArray, free: Sequence[int]) -> Program:
    """The program in the variables `free` alone, the others at x (n_vars,)."""
    chosen = list(free)
    fixed = [i for i in range(len(x)) if i not in chosen]
    models: dict[int, Model] = {}

    def smaller(model: Model) -> Model:
        if id(model) not in models:
            models[id(model)] = _model(model, x, chosen, fixed)
        return models[id(model)]

    def moved(part: Part) -> Part:
        return replace(part, model=smaller(part.model), form=part.form.held(x, chosen))

    limits = tuple(moved(one) for one in program.limits)
    aim = program.aim
    if aim is not None:
        aim = replace(moved(aim), others=tuple(moved(one) for one in aim.others))
    axes = tuple(program.axes[i] for i in chosen)
    return replace(program, model=smaller(program.model), axes=axes, limits=limits, aim=aim)


def _model(model: Model, x: FloatArray, free: list[int], fixed: list[int]) -> Model:
    def term(one: Term) -> Term:
        size = _power(one.exponents, x, fixed)
        return replace(one, scale=one.scale * size, static_scale=one.static_scale * size, exponents=one.exponents[free])

    def monomial(one: Monomial) -> Monomial:
        size = _power(one.row(len(x)), x, fixed)
        return Monomial(one.scale * size, {free.index(i): e for i, e in one.exponents.items() if i in free})

    return replace(
        model,
        terms=tuple(term(one) for one in model.terms),
        counts={name: monomial(one) for name, one in model.counts.items()},
        ratios={name: monomial(one) for name, one in model.ratios.items()},
        properties={key: monomial(one) for key, one in model.properties.items()},
    )


def _power(exponents: FloatArray, x: FloatArray, fixed: list[int]) -> float:
    """prod over the held variables of x_i**exponents_i."""
    powers = exponents[fixed]
    return float(np.prod(np.where(powers == 0.0, 1.0, x[fixed] ** powers)))
