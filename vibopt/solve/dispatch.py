"""A program to what is found: which method is asked, who goes on where it leaves doubts, and what that proves."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache, partial

import numpy as np

from vibopt.errors import InputError
from vibopt.program.program import Limit, Program
from vibopt.scene.scene import Scene
from vibopt.scene.uncertain import uncertain
from vibopt.solve.by_name import called
from vibopt.solve.choose import choose, closed_form
from vibopt.solve.method import OPEN, Found, Method, Progress, Told
from vibopt.solve.ranges import closed, log_box
from vibopt.solve.spared import sure_of_none
from vibopt.solve.without_search import as_goal, lost_limit, moot_goal, no_design
from vibopt.solve.without_search import words as lost_words

_NEAR, _SAME = 1e3, 1e-9
"""How near to the least that is looked at a value is next to nothing, and part of a goal that is rounding."""


def best_of(
    program: Program,
    scene: Scene,
    method: str | Method | None,
    progress: Progress | None,
    near: Sequence[float] | None = None,
) -> tuple[Found, Callable[[], str]]:
    """What a method says, and what finds the physical reason where there is one."""
    limit = lost_limit(program)
    if limit is not None:
        return no_design(limit), partial(lost_words, scene, limit)
    moot = moot_goal(program)
    if moot and program.aim is not None:
        found, why = best_of(replace(program, aim=None), scene, method, progress, near)
        return as_goal(found, moot, program.aim), why
    finite = closed(program)
    outright = closed_form(finite) if method is None and not program.ties else None
    sure = outright.solve(finite, progress) if outright is not None else None  # sooner than to ask what cannot be
    clash = None
    if method is None and (sure is None or sure.status != "optimal"):
        from vibopt.solve.physical import impossible

        clash = impossible(finite)
    if clash is not None:
        from vibopt.solve.impasse import physical_words

        claim = "proven by the balance of forces on the machine, for any isolator"
        return Found("infeasible", None, claim, "physical bound"), partial(physical_words, scene, clash)
    if program.ties:
        return _of_parts(program, finite, scene, method, progress)
    told: Told | None = {} if method is None and near is None and not uncertain(scene) else None
    chosen = outright or _with_proof(finite, choose(finite, called(method), near), told)
    found = sure or _searched(finite, chosen, method, progress, near)
    exact = chosen.name.startswith("closed_form")
    if exact and found.status == "unproven" and method is None:
        found = _unsettled(finite, found, progress)
        exact = bool(found.details.get("settled"))
    if found.method == "discs" and found.status in OPEN and method is None:
        from vibopt.solve.global_search import beside_slices

        found = beside_slices(finite, found, progress)
    found = _on_zero(finite, found)
    said = _open_ends(finite, found, exact=exact)
    if method is None and said.status in OPEN:
        from vibopt.solve.one_range import OneRange

        if OneRange().refuses(finite) is None:
            found = _one_variable(finite, found, progress)
            said = _open_ends(finite, found, exact=bool(found.details.get("settled")))
    found = _bounded(finite, _not_proven(finite, said), told)
    found = sure_of_none(finite, found, partial(_chosen, method=method, progress=progress))
    if found.status == "infeasible":
        from vibopt.solve.impasse import hopeless_words

        return found, partial(hopeless_words, scene, program)
    return found, str


def _of_parts(
    program: Program, finite: Program, scene: Scene, method: str | Method | None, progress: Progress | None
) -> tuple[Found, Callable[[], str]]:
    """The best parts; beside ranges they are exchanged, and what is proven holds for any numbers between theirs."""
    from vibopt.solve.catalogue.why import reason_of
    from vibopt.solve.impasse import hopeless_words

    ranged = program.ranged
    if ranged is not None and uncertain(scene):
        doubt = uncertain(scene)[0]
        raise InputError(
            f"{ranged.path} may be any value of a range, and {doubt.path} has a tolerance: parts of a catalogue are "
            "chosen beside one of the two. Write one value, or one_of = [...], or no tolerance."
        )
    again = partial(_chosen, method=method, progress=progress)
    found = _not_proven(finite, again(finite))
    if ranged is not None:
        found = _bounded(replace(finite, ties=()), found, {})
        return found, partial(hopeless_words, scene, program) if found.status == "infeasible" else str
    found = sure_of_none(finite, found, again)
    return found, partial(reason_of, program, found) if found.status == "infeasible" else str


def _searched(
    program: Program, chosen: Method, method: str | Method | None, progress: Progress | None,
    near: Sequence[float] | None,
) -> Found:  # fmt: skip
    """What a method finds, or that there is no design where few boxes show it: before a search that takes long."""
    early = _hopeless(program, chosen, method) if near is None else None
    found = early or chosen.solve(program, progress)
    if near is not None and found.status == "unproven":  # where few starts find none, there may be none
        return _hopeless(program, chosen, method) or found
    return found


def _chosen(program: Program, *, method: str | Method | None, progress: Progress | None) -> Found:
    return choose(program, called(method)).solve(program, progress)


def _with_proof(program: Program, chosen: Method, told: Told | None) -> Method:
    """The method, which asks boxes of the first design found whether others need be looked for."""
    if told is None or chosen.name != "nlp":
        return chosen
    from vibopt.solve.nlp import Nlp
    from vibopt.solve.passive import with_bound
    from vibopt.solve.relaxed import with_least

    def proof(found: Found) -> Found:
        passive = cache(partial(with_bound, program, found))
        return with_least(program, found, lambda: passive().bound, told)

    return replace(chosen, proof=proof) if isinstance(chosen, Nlp) else chosen


def _bounded(program: Program, found: Found, told: Told | None) -> Found:
    """The answer with the better of what boxes (beyond what they `told`) and any passive device say of the best."""
    if found.status not in OPEN:
        return found
    from vibopt.solve.passive import with_bound

    passive = cache(partial(with_bound, program, found))  # only asked for where boxes do not prove all of it
    boxes = found
    if told is not None:
        from vibopt.solve.relaxed import with_least

        boxes = with_least(program, found, lambda: passive().bound, told)
    if boxes.status != "feasible" or boxes.bound >= passive().bound or np.isnan(passive().bound):
        return boxes
    return passive()


def _hopeless(program: Program, chosen: Method, method: str | Method | None) -> Found | None:
    """That there is no design, where few boxes show it before a search that would take longer."""
    if method is not None or chosen.name.startswith("closed_form"):
        return None
    from vibopt.solve.relaxed import hopeless

    return hopeless(program)


def _unsettled(program: Program, found: Found, progress: Progress | None) -> Found:
    """The answer where worst speeds do not settle: each cuts next to nothing off a range that limits all but leave."""
    from vibopt.solve.global_search import BranchAndBound
    from vibopt.solve.one_range import OneRange

    if OneRange().refuses(program) is None:
        return _one_variable(program, found, progress)
    return BranchAndBound().solve(program, progress)


def _one_variable(program: Program, found: Found, progress: Progress | None) -> Found:
    """One variable is decided along its range, and where that leaves doubts by as many boxes as it takes."""
    from vibopt.solve.global_search import BranchAndBound, provable
    from vibopt.solve.one_range import OneRange

    line = found if found.method == OneRange.name else OneRange().solve(program, progress)
    search = BranchAndBound()
    if line.status not in OPEN or search.refuses(program) is not None or not provable(program):
        return line
    whole = search.solve(program, progress)
    return whole if whole.status in ("optimal", "infeasible") else line


def _not_proven(program: Program, found: Found) -> Found:
    """The answer without the word where a limit or the goal might be greater than was seen."""
    seen = [part for part in program.parts if part.form.searched]
    if found.status == "optimal" and seen:  # tangents bound it from below whatever the search has missed
        better = program.aim is not None and found.method == "tangents"
        return replace(found, status="optimal" if better else "feasible", claim=f"{found.claim}; {program.doubts}")
    if found.status == "infeasible" and any(isinstance(one, Limit) and one.side == "at_least" for one in seen):
        return replace(found, status="unproven", claim=f"no design was found; {program.doubts}")
    return found


def _on_zero(program: Program, found: Found) -> Found:
    """The design with zero for what is next to nothing, where its range begins there and that is as good."""
    if found.x is None or found.status not in ("optimal", "feasible"):
        return found
    ends = zip(program.axes, found.x, np.exp(log_box(program)[0]), strict=True)
    fading = [
        i for i, (one, x, low) in enumerate(ends) if one.low <= 0.0 and not one.open_low and 0.0 < x <= _NEAR * low
    ]
    if not fading:
        return found
    from vibopt.solve.branch import Judge

    judge, best = Judge(program), found.x
    with np.errstate(all="ignore"):
        goal = judge.goal(best).value
        for i in fading:
            x = best.copy()
            x[i] = 0.0
            if judge.goal(x).value <= goal + _SAME * abs(goal) and judge.feasible(x):
                best = x
    return replace(found, x=best)


def _open_ends(program: Program, found: Found, *, exact: bool) -> Found:
    """What half-open ranges mean for an answer: no best design at an open end, no proof beyond a far one."""
    opened = [axis for axis in program.axes if axis.open_high or axis.open_low]
    if not opened or found.status == "unbounded":
        return found
    if found.x is None:
        if exact or found.status != "infeasible" or not any(axis.open_high for axis in opened):
            return found
        ends = ", ".join(f"{axis.path} = {axis.high:.3g} (SI)" for axis in opened if axis.open_high)
        return replace(found, status="unproven", claim=f"no design up to {ends}; nothing is proven about larger values")
    reach = found.details.get("reach") or tuple(program.high)
    for i, axis in enumerate(program.axes):
        up, down = axis.open_high and found.x[i] >= 0.999 * reach[i], axis.open_low and found.x[i] <= 1.001 * axis.low
        if not up and not down:
            continue
        way = "grows without end" if up else "goes to zero"
        if program.aim is not None and program.aim.direction(i) is not None:
            claim = f"every limit holds and the goal keeps improving as {axis.path} {way}"
            return replace(found, status="unbounded", claim=claim)
        claim = f"every limit holds; the goal comes ever nearer to its best value as {axis.path} {way}"
        return replace(found, status="feasible", claim=claim)
    return found
