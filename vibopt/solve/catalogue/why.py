"""Beside an answer of parts: why none will do, and what stiffness and damping could do if they were had at will."""

from __future__ import annotations

import contextlib
from collections import Counter
from dataclasses import replace
from typing import Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.errors import InputError, counted
from vibopt.forms import StaticLoad
from vibopt.forms.bounds import FormBounds
from vibopt.program.held import held
from vibopt.program.program import Aim, Limit, Program
from vibopt.solve.branch import Judge
from vibopt.solve.catalogue.pointwise import bounds_of
from vibopt.solve.choose import choose, modest
from vibopt.solve.method import Found

_NEAR_ZERO = 1e-9


def free_optimum(program: Program, found: Found, *, thorough: bool = False) -> dict[str, Any] | None:
    """Stiffness and damping free within the ends of the catalogue, all else as chosen and made to carry its load.

    None where the goal does not depend on them (a price); status "unproven" where the search, a modest one unless
    `thorough`, came to no end.
    """
    x = np.asarray(found.x)
    free = [axis for tie in program.ties for axis in tie.axes if ".part." not in program.axes[axis].path]
    asked = replace(
        program, limits=tuple(limit for limit in program.limits if not isinstance(limit.form, StaticLoad)), ties=()
    )
    if not free or program.aim is None or any(_bounds(one, x).direct for one in program.parts):
        return None
    part = held(asked, x, free)
    assert part.aim is not None
    if part.aim.form.powers is not None and not part.aim.form.powers.exponents.any():
        return None
    axes = [replace(axis, values=None, low=max(axis.low, _NEAR_ZERO * axis.high)) for axis in part.axes]
    part = replace(part, axes=tuple(axes))
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


def why_dropped(limit: Limit, parts: int) -> str:
    """What stands against so many parts that a limit forbids, behind "12 of 60 parts"."""
    one = parts == 1
    if isinstance(limit.form, StaticLoad):
        less = "is loaded less than it needs" if one else "are loaded less than they need"
        return "cannot carry the load" if limit.side == "at_most" else less
    if limit.form.frequency is not None and limit.side in ("at_most", "at_least"):
        return f"{'is' if one else 'are'} too {'stiff' if limit.side == 'at_most' else 'soft'} for {limit.name}"
    return f"{'breaks' if one else 'break'} {limit.name}"


def reason_of(program: Program, found: Found) -> str:
    """Parts that cannot be used, and the choice that comes nearest."""
    sentences = [*_tables(program, found), _near(program, found.details.get("nearest"))]
    return " ".join(sentence for sentence in sentences if sentence)


def _tables(program: Program, found: Found) -> list[str]:
    sentences = []
    for tie in program.ties:
        mine = [one for one in found.details["rows"] if one["path"] == tie.path]
        kinds = Counter((one["limit"], one["side"]) for one in mine if one["alone"])
        words = [f"{count} {why_dropped(_limit(program, *key), count)}" for key, count in kinds.most_common()]
        if list(kinds.values()) == [len(tie.names)]:
            (key,) = kinds
            why = why_dropped(_limit(program, *key), len(mine))
            sentences.append(f"{tie.path}: no part will do: all {len(mine)} {why}.")
        elif words:
            sentences.append(f"{tie.path}: of {counted(len(tie.names), 'parts')} {', '.join(words)}.")
    return sentences


def _limit(program: Program, name: str, side: str) -> Limit:
    return next(limit for limit in program.limits if (limit.name, limit.side) == (name, side))


def _near(program: Program, near: dict[str, Any] | None) -> str:
    if near is None:
        return ""
    tied = {axis for tie in program.ties for axis in tie.axes}
    others = [
        f"{axis.path} = {value:.4g}"
        for i, (axis, value) in enumerate(zip(program.axes, near["x"], strict=True))
        if i not in tied
    ]
    chosen = ", ".join([*(f"{path} = {name}" for path, name in near["parts"].items()), *others])
    limit = _limit(program, near["limit"], near["side"])
    percent = f"{100.0 * near['missed']:.3g} %"
    if isinstance(limit.form, StaticLoad):
        if limit.side == "at_least" and near["missed"] > 1.0:
            return f"The nearest is {chosen}: a mount of {limit.name.split(':')[0]} is lifted."
        over = "above the most" if limit.side == "at_most" else "below the least"
        return f"The nearest is {chosen}: its load is {percent} {over} that it is rated for."
    return f"The nearest is {chosen}: it misses {limit.name} by {percent}."
