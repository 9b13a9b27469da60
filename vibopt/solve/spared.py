"""What is proven of limits that are kept with some to spare, as their values are known to a part of themselves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from vibopt.program.program import Limit, Program
from vibopt.solve.method import Found

NONE_WITH = (
    "no design keeps every limit with {part} to spare, to which their values are known; that none keeps them with less "
    "is not proven"
)


def sure_of_none(program: Program, found: Found, again: Callable[[Program], Found]) -> Found:
    """The answer; "unproven" in place of "infeasible" where a design may keep every limit with less to spare.

    again
        Answers the same program with limits as wide as their values may be off.
    """
    if found.status != "infeasible" or not spared(program) or again(widened(program)).status == "infeasible":
        return found
    return replace(found, status="unproven", claim=NONE_WITH.format(part=spared(program)))


def spared(program: Program) -> str:
    """With how much to spare limits are kept, as "0.003 %"; "" where values are known to rounding."""
    part = known_to(program)
    return f"{100.0 * part:.2g} %" if part else ""


def known_to(program: Program) -> float:
    """Greatest part of themselves to which values of limits are known, if more than rounding; 0 else."""
    return max((limit.form.known_to for limit in program.limits), default=0.0)


def widened(program: Program) -> Program:
    """The same with limits as wide as their values may be off."""
    return replace(program, limits=tuple(_wider(limit) for limit in program.limits))


def _wider(limit: Limit) -> Limit:
    """At the bound as it is asked, and beyond it by as much as it was kept to spare."""
    part = 2.0 * limit.form.known_to
    return replace(limit, bound=limit.bound * (1.0 + (part if limit.side == "at_most" else -part)))
