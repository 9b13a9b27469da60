"""What each limit of an engine costs, found by solving again; and which limits cannot hold together."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import replace

from vibopt.balancing.conflict import Step, conflict_words, smallest_set
from vibopt.balancing.engine.job import EngineJob
from vibopt.balancing.engine.shaking import arms
from vibopt.balancing.engine.solve import (
    Balanced,
    balance,
    goal_table,
    goal_value,
    least_response,
    lengths,
    settings,
    size_of,
)  # fmt: skip
from vibopt.balancing.engine.tables import EngineLimitTable
from vibopt.balancing.outcome import Held
from vibopt.units import show, si_unit

STEP = 1.1
PATIENCE = 2.0
"""Seconds for all prices together: more is not spent on them."""
_ACTIVE = 1e-4
_LOOSER = 1.0005


def prices(job: EngineJob, found: Balanced, limits: Mapping[str, Held], took: float) -> tuple[dict[str, str], str]:
    """What a wider limit buys, in words by name, and one sentence where a price was not found out.

    Parameters
    ----------
    job, found
        The engine with its answer.
    limits
        Measured on the answer.  Where cranks are chosen every limit may hold the answer back, else those it touches.
    took
        Seconds of the answer itself: each price takes about four of them.
    """
    if job.goal is None or found.status not in ("optimal", "feasible") or found.way == "none":
        return {}, ""
    asked = [name for name, one in limits.items() if job.is_search or one.margin < _ACTIVE]
    end, words, left = time.perf_counter() + PATIENCE, {}, []
    for name in asked:
        if time.perf_counter() + 4.0 * took > end:
            left.append(name)
        elif said := _price(job, found, name):
            words[name] = said
    return words, f"No price was computed for {', '.join(left)}: it takes too long." if left else ""


def _price(job: EngineJob, found: Balanced, name: str) -> str:
    """ "400 N m -> 440 N m buys 812 N -> 640 N; nothing more to gain beyond 731 N m"; "" where it buys nothing."""
    table, goal = job.limits[name], goal_table(job)
    now, grain = goal_value(job, found), 1e-9 * size_of(job, goal.is_couple)
    free = _goal(without(job, name))
    if free is None or not free < now * (1.0 - 1e-6) - grain:
        return ""
    then = _goal(moved(job, name, table.bound * STEP))
    if then is None:
        return ""
    until = _until(job, name, free + 10.0 * grain)
    bound, wider = (show(one, table.unit, table.dimension) for one in (table.bound, table.bound * STEP))
    first, second, third = (show(one, "", goal.dimension, digits=4) for one in (now, then, free))
    if not then < now * (1.0 - 1e-6) - grain:
        return f"{bound} -> {wider} buys nothing" + (f", {until} buys {first} -> {third}" if until else "")
    return f"{bound} -> {wider} buys {first} -> {second}" + (f"; nothing more to gain beyond {until}" if until else "")


def _until(job: EngineJob, name: str, target: float) -> str:
    """The bound from which on the goal is as good as without the limit, solved once more with it; "" if none."""
    table, free = job.limits[name], without(job, name)
    reached: list[float] = []
    for cranks in settings(job):
        here = arms(job, cranks)
        kept = replace(lengths(goal_table(job), here), limit=target)
        value = least_response(free, here, table, [kept])
        reached += [] if value is None else [value]
    if not reached:
        return ""
    bound = min(reached) * (1.0 + 1e-6)
    again = _goal(moved(job, name, bound))
    grain = 1e-7 * size_of(job, goal_table(job).is_couple)
    return show(bound, table.unit, table.dimension) if again is not None and again <= target + grain else ""


def _goal(job: EngineJob) -> float | None:
    """The best goal of a job; None where there is no answer."""
    found = balance(job)
    return goal_value(job, found) if found.status in ("optimal", "feasible") else None


def without(job: EngineJob, name: str) -> EngineJob:
    """The job less one limit."""
    return replace(job, limits={key: one for key, one in job.limits.items() if key != name})


def moved(job: EngineJob, name: str, bound: float) -> EngineJob:
    """The job with one limit at another bound [N, N m]."""
    table = job.limits[name]
    text = f"{bound!r} {si_unit(table.dimension)}"
    return replace(job, limits={**job.limits, name: table.model_copy(update={"at_most": text})})


def impasse(job: EngineJob, took: float) -> str:
    """Why no weights and no cranks are possible: the limits that cannot hold together and the smallest loosening."""
    if took * (len(job.limits) + 1) > PATIENCE:
        return "Which limits stand in the way was not computed: it takes too long."

    def possible(kept: tuple[str, ...]) -> bool:
        return balance(replace(job, limits={name: job.limits[name] for name in kept})).status != "infeasible"

    names = smallest_set(tuple(job.limits), possible)
    return conflict_words(names, [step for name in names for step in _loosening(job, name)])


def _loosening(job: EngineJob, name: str) -> list[Step]:
    """The least bound of one limit that lets the others hold, solved once more with it."""
    table, free = job.limits[name], without(job, name)
    found = [least_response(free, arms(job, cranks), table, []) for cranks in settings(job)]
    reached = [one for one in found if one is not None]
    if not reached:
        return []
    bound = min(reached) * _LOOSER
    if balance(moved(job, name, bound)).status == "infeasible":
        return []
    return [(name, _shown(table, table.bound), _shown(table, bound))]


def _shown(table: EngineLimitTable, bound: float) -> str:
    return show(bound, table.unit, table.dimension)
