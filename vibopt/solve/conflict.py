"""Why there is no design: every smallest set of limits that cannot hold together, and what loosening helps."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from vibopt.answer.clashes import Clashes, every_clash
from vibopt.arrays import FloatArray
from vibopt.program.program import Aim, Limit, Program
from vibopt.records import dataclass
from vibopt.solve.choose import MODEST_GAP, modest
from vibopt.solve.method import Found
from vibopt.solve.relaxed import hopeless, none_holds

Answer = Callable[[Program], Found]
_CLOSE = 0.002
"""Part of a change by which a bound that is proven the least may be greater."""


@dataclass(frozen=True, slots=True)
class Loosening:
    """A limit and the bound [SI] with which a design exists, as found; not rounded yet.

    Where the search began at starts, `near` is that design [SI]; `known` says whether the bound is proven the least.
    """

    limit: Limit
    bound: float
    near: FloatArray | None = None
    known: bool = False


Key = tuple[str, str]
"""Name and side of a limit, which may be asked at many places."""


def asked(part: Program) -> Found:
    """The answer to some limits of a job, by a coarse search; where that finds nothing, by as many boxes as the job."""
    found = hopeless(part) or modest(part).solve(part)
    return none_holds(part) or found if part.aim is None and found.status == "unproven" else found


def conflicts(program: Program, answer: Answer, may: Callable[[], bool] = lambda: True) -> Clashes[Key]:
    """Every set of limits that cannot hold together, and of which none can be left out.

    Parameters
    ----------
    program
        Proven infeasible.
    answer
        Solves a program without a goal; only a proven "infeasible" counts.
    may
        Whether, after the first set, another answer may be asked for.
    """

    def clashes(some: tuple[Key, ...]) -> bool | None:
        kept = tuple(limit for limit in program.limits if (limit.name, limit.user_side) in some)
        status = answer(replace(program, limits=kept, aim=None)).status
        return True if status == "infeasible" else None if status == "unproven" else False

    return every_clash(list(dict.fromkeys((limit.name, limit.user_side) for limit in program.limits)), clashes, may)


def loosenings(
    program: Program, conflict: tuple[Limit, ...], answer: Answer, may: Callable[[], bool] = lambda: True
) -> tuple[list[Loosening], list[Limit]]:
    """For each limit of the conflict the smallest loosening that makes the whole program feasible.

    A limit is left out where no loosening of it alone helps; those come second that were not asked for, once `may`
    says that no further answer is.
    """
    found, left = [], []
    for limit in {(one.name, one.user_side): one for one in conflict}.values():
        if limit.user_side == "outside":
            continue
        if not may():
            left.append(limit)
            continue
        alike = [one for one in program.limits if (one.name, one.user_side) == (limit.name, limit.user_side)]
        rest = tuple(one for one in program.limits if (one.name, one.user_side) != (limit.name, limit.user_side))
        sense = 1.0 if limit.side == "at_most" else -1.0
        aims = [Aim(one.name, one.model, one.form, sense, one.complement) for one in alike]  # one limit, many places
        aim = replace(aims[0], others=tuple(aims[1:]))
        best = answer(replace(program, limits=rest, aim=aim))
        if best.x is None or best.status not in ("optimal", "feasible"):
            continue
        value, near = best.details.get("goal"), None
        if not isinstance(value, float):
            value = sense * max(sense * float(piece.form.value(piece.model, best.x)) for piece in aim.pieces)
            near = best.x
        if math.isfinite(value):
            close = MODEST_GAP * abs(value) <= _CLOSE * abs(value - limit.bound)
            found.append(Loosening(limit, value, near, close and best.status == "optimal"))
    return found, left
