"""The design with the most room in its limits: as a goal, and where a goal leaves several designs to choose from.

The room is the least margin: the part of its bound by which the nearest limit could be tightened, all of them alike.
Slopes lead to the most of it, and the limits tightened by a little more are answered as any other question: that no
design keeps them is the proof.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from operator import and_

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.program.program import Limit, Program
from vibopt.records import dataclass
from vibopt.solve.branch import Judge
from vibopt.solve.method import Found
from vibopt.work import late

GAP = 1e-6
"""Part of its bound by which the least margin may be away from the most there is."""
_ROUNDS, _FASTER = 40, 8.0
_END = 1.0 + 1e-6
"""Part of an end of a range within which a number may rest on it."""
_FAR = 0.999
"""Part of the far end of a range without one, from which on a design stands for one without end."""
Again = Callable[[Program], Found]
"""Answers a program without a goal."""


def with_most_room(program: Program, found: Found, again: Again) -> Found:
    """The design with the most room in the limits that `room` names, from one that keeps all of them."""
    if found.x is None or not program.room:
        return found
    x, last = _Most(program).proven(np.asarray(found.x, dtype=float), again)
    sure = last.status == "infeasible"
    how = (
        f"proven to {GAP:.0e} of the bounds, for limits tighter by that leave no design; "
        if sure
        else f"the most room that was found; of limits tighter by {GAP:.0e} of their bounds: "
    )
    details = {key: one for key, one in found.details.items() if key != "picks"}  # of parts that just hold
    status, method = "optimal" if sure else "feasible", last.method or found.method
    return replace(found, status=status, x=x, claim=f"{how}{last.claim}", method=method, details=details)


def spread_out(program: Program, found: Found) -> Found:
    """The answer with the most room that slopes lead to among designs whose goal is as good, where ranges decide that.

    The numbers that the goal knows stay, and so does the design where the others have nothing to say or no end.
    """
    powers = None if program.aim is None else program.aim.form.powers
    if found.x is None or powers is None or program.ties:
        return found
    x, known = np.array(found.x, dtype=float), [bool(power.any()) for power in powers.exponents.T]
    inside = (axis.low * _END < one < axis.high / _END for one, axis in zip(x.tolist(), program.axes, strict=True))
    if any(map(and_, known, inside)) or not program.is_best(Judge(program).goal(found.x).value):
        return found
    from vibopt.program.held import held

    free = [i for i, axis in enumerate(program.axes) if not known[i] and axis.high > axis.low]
    less = held(program, x, free)
    most = _Most(replace(less, room=tuple(limit.name for limit in less.limits if _has_room(limit))))
    y = most.slid(x[free])
    if np.array_equal(y, x[free]) or any(a.open_high and y[i] >= _FAR * a.high for i, a in enumerate(less.axes)):
        return found
    x[free] = y
    claim = f"{found.claim}; of the designs found with this goal it has the most room in its limits"
    return replace(found, x=x, claim=claim)


def _has_room(limit: Limit) -> bool:
    """Whether a limit has a bound of which a part can be left over."""
    return limit.side != "outside" and not limit.of_bands and limit.bound > 0.0


@dataclass
class _Most:
    """The search for the most room in the limits that a program names; what no variable moves has none to gain."""

    program: Program

    def __post_init__(self) -> None:
        limits = tuple(replace(limit, soft=1.0) for limit in self.program.limits)
        self.bare = replace(self.program, limits=limits, aim=None, room=())
        names = self.program.room
        self.counted = [i for i, one in enumerate(limits) if one.name in names and one.form.acting(one.model).any()]
        self.judge = Judge(self.bare)

    def room(self, x: FloatArray) -> float:
        """The least margin at x (n_vars,), of what can be moved."""
        return -max(self.judge.limit(self.bare.limits[i], x)[0] for i in self.counted)

    def tightened(self, part: float) -> Program:
        """The program with the limits that count tightened by a part of their bounds."""
        limits = list(self.bare.limits)
        for i in self.counted:
            one = limits[i]
            limits[i] = replace(one, bound=one.bound * (1.0 - part if one.side == "at_most" else 1.0 + part))
        return replace(self.bare, limits=tuple(limits))

    def slid(self, x: FloatArray, **given: int) -> FloatArray:
        """Where slopes lead from x (n_vars,), if that is better."""
        if not self.counted:
            return x
        kept = [i for i in range(len(self.bare.limits)) if i not in self.counted]
        from vibopt.solve.least_missed import nearest_to

        there = nearest_to(self.bare, (x,), kept, **given)
        return there if self.judge.feasible(there) and self.room(there) > self.room(x) else x

    def proven(self, x: FloatArray, again: Again) -> tuple[FloatArray, Found]:
        """The design with the most room, from one that keeps every limit, and the answer to a little more of it."""
        x, last, step = self.slid(x), Found("infeasible", None, "no variable moves any that counts", ""), GAP
        for _ in range(_ROUNDS if self.counted else 0):
            if late("the search for the most room"):
                return x, Found("unproven", None, "not looked at", last.method)
            part = self.room(x) + step
            if part >= 1.0 and any(self.bare.limits[i].side == "at_most" for i in self.counted):
                return x, Found("infeasible", None, "no limit leaves more than all of its bound", last.method)
            last = again(self.tightened(part))
            if last.x is not None:
                x, step = self.slid(np.asarray(last.x, dtype=float), spread=0), step * _FASTER
            elif step == GAP:
                break
            else:
                step = GAP
        return x, last
