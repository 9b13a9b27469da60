"""The best that stiffness and damping could do if they could be had at will: what buying from the shelf costs."""

from __future__ import annotations

import contextlib
from dataclasses import replace
from typing import Any

import numpy as np

from vibopt.errors import InputError
from vibopt.forms import FloatArray, Monomials, StaticLoad
from vibopt.program.bounds import FormBounds
from vibopt.program.held import held
from vibopt.program.program import Aim, Axis, Limit, Program
from vibopt.solve.branch import Judge
from vibopt.solve.choose import choose, modest
from vibopt.solve.method import Found
from vibopt.solve.shelf.pointwise import Direct, bounds_of

_NEAR_ZERO = 1e-9


def free_optimum(program: Program, found: Found, *, thorough: bool = False) -> dict[str, Any] | None:
    """Stiffness and damping free within the ends of the catalogue, all else as chosen and made to carry its load.

    None where the goal does not depend on them (a price); status "unproven" where the search, a modest one unless
    `thorough`, came to no end.
    """
    x = np.asarray(found.x)
    free = [axis for tie in program.ties for axis in tie.axes if ".part." not in program.axes[axis].path]
    asked = replace(
        program, limits=tuple(one for one in program.limits if not isinstance(one.form, StaticLoad)), ties=()
    )
    if not free or program.aim is None or any(isinstance(_bounds(one, x), Direct) for one in program.parts):
        return None
    part = held(asked, x, free)
    assert part.aim is not None
    if isinstance(part.aim.form, Monomials) and not part.aim.form.exponents.any():
        return None
    part = replace(part, axes=tuple(_opened(one) for one in part.axes))
    best = None
    with contextlib.suppress(InputError):
        best = (choose(part, None) if thorough else modest(part)).solve(part)
    if best is None:
        return None
    if best.x is None or best.status not in ("optimal", "feasible"):
        return {"status": "unproven", "claim": best.claim}
    values = {axis.path: float(value) for axis, value in zip(part.axes, best.x, strict=True)}
    bought, ideal = Judge(program).goal(x).value, Judge(part).goal(best.x).value
    if ideal > bought + 1e-9 * abs(bought):  # a search that was cut short
        return {"status": "unproven", "claim": best.claim}
    return {"status": best.status, "claim": best.claim, "goal": ideal, "values": values}


def _bounds(part: Limit | Aim, x: FloatArray) -> FormBounds:
    return bounds_of(part.model, part.form, np.where(x > 0.0, x, 1.0))


def _opened(axis: Axis) -> Axis:
    return replace(axis, values=None, low=max(axis.low, _NEAR_ZERO * axis.high))


__all__ = ["free_optimum"]
