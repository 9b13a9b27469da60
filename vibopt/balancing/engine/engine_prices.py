"""What each limit and cap of an engine costs, found by solving again; and which limits cannot hold together."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from math import inf, isfinite

import numpy as np

from vibopt.answer.answer import Conflict
from vibopt.answer.entry import Checked, Entry
from vibopt.balancing.engine.choose_weights import (
    Balanced,
    balance,
    box_of,
    goal_table,
    goal_value,
    least_response,
    lengths,
    settings,
    size_of,
)
from vibopt.balancing.engine.engine_job import EngineJob
from vibopt.balancing.engine.engine_tables import EngineLimitTable
from vibopt.balancing.engine.shaking import arms, free_shares, free_weights
from vibopt.balancing.lengths import Lengths
from vibopt.balancing.question_prices import ACTIVE, Bound, Step, clash, prices_of
from vibopt.records import dataclass
from vibopt.units import show
from vibopt.work import Budget


@dataclass(frozen=True, slots=True)
class Cap:
    """The upper end of what is chosen: an unbalance [kg m], or a share [1].

    path
        In the file: "counterweights.front.unbalance", "engine.counterweight_share".
    weight, share
        Index of the weight, or name of the share.
    """

    path: str
    bound: float
    unit: str
    dimension: str
    weight: int | None = None
    share: str = ""

    def columns(self, job: EngineJob) -> list[int]:
        """Its places in the choices x."""
        shares = free_shares(job)
        if self.weight is None:
            return [[one.name for one in shares].index(self.share)]
        first = len(shares) + 2 * free_weights(job).index(self.weight)
        return [first, first + 1]

    def reached(self, job: EngineJob, found: Balanced) -> float:
        """Part of it that an answer takes."""
        return float(np.linalg.norm(found.x[self.columns(job)])) / self.bound

    def size(self, job: EngineJob) -> Lengths:
        """What it bounds as a length of the choices."""
        slope = np.zeros((1, box_of(job).size), dtype=complex)
        slope[0, self.columns(job)] = (1.0, 1j)[: len(self.columns(job))]
        return Lengths(np.zeros(1, dtype=complex), slope)


def caps_of(job: EngineJob) -> list[Cap]:
    """All of them, shares first."""
    found = [Cap(f"engine.{one.name}", one.high, "%", "ratio", share=one.name) for one in free_shares(job)]
    for index in free_weights(job):
        one = job.weights[index]
        if isfinite(one.cap):
            path = f"{one.family}.{one.name}.unbalance"
            found.append(Cap(path, one.cap, one.unit, "unbalance", weight=index))
    return found


def wider(job: EngineJob, cap: Cap, bound: float) -> EngineJob:
    """The job with one of them at another bound."""
    if cap.weight is None:
        shares = tuple(replace(one, high=max(bound, one.low)) if one.name == cap.share else one for one in job.shares)
        return replace(job, shares=shares)
    weights = list(job.weights)
    weights[cap.weight] = replace(weights[cap.weight], cap=bound)
    return replace(job, weights=tuple(weights))


_LOOSER = 1.0005
Known = EngineLimitTable | Cap


def prices(
    job: EngineJob, found: Balanced, limits: Mapping[str, Checked], work: float, budget: Budget
) -> tuple[dict[str, str], tuple[str, ...]]:
    """What a wider limit or cap buys, in words by name (path), and a sentence where a price was not found out.

    Parameters
    ----------
    job, found
        The engine with its answer.
    limits
        Measured on the answer.  Where cranks are chosen every limit may hold the answer back, else those it touches.
    work, budget
        What the answer took, which is expected of each further solution, and what all may take [nominal ms].
    """
    if job.goal is None or found.status not in ("optimal", "feasible") or found.way == "none":
        return {}, ()
    asked: list[tuple[str, Known]] = [
        (name, job.limits[name]) for name, one in limits.items() if job.is_search or one.margin < ACTIVE
    ]
    asked += [(one.path, one) for one in caps_of(job) if job.is_search or one.reached(job, found) >= 1.0 - ACTIVE]
    goal = goal_table(job)
    grain = 1e-9 * size_of(job, goal.is_couple)
    bounds = [_bound(job, name, one, grain) for name, one in asked]
    return prices_of(
        bounds, goal_value(job, found), lambda one: show(one, "", goal.dimension, digits=4), grain, work, budget
    )


def _bound(job: EngineJob, name: str, limit: Known, grain: float) -> Bound:
    def best(bound: float) -> tuple[float, Balanced] | None:
        other = moved(job, name, limit, bound)
        found = balance(other)
        return (goal_value(other, found), found) if found.status in ("optimal", "feasible") else None

    def until(free: tuple[float, Balanced]) -> float | None:
        return _until(job, name, limit, free[0] + 10.0 * grain, best)

    return Bound(name, limit.bound, limit.unit, limit.dimension, best, until)


def _until(
    job: EngineJob, name: str, limit: Known, target: float, best: Callable[[float], tuple[float, Balanced] | None]
) -> float | None:
    """The bound from which on the goal is as good as without the limit, solved once more with it; None if none."""
    free = moved(job, name, limit, inf)
    reached: list[float] = []
    for cranks in settings(job):
        here = arms(job, cranks)
        kept = replace(lengths(goal_table(job), here), limit=target)
        asked = limit.size(job) if isinstance(limit, Cap) else lengths(limit, here)
        value = least_response(free, here, asked, [kept])
        reached += [] if value is None else [value]
    if not reached:
        return None
    bound = min(reached) * (1.0 + 1e-6)
    again = best(bound)
    grain = 1e-7 * size_of(job, goal_table(job).is_couple)
    return bound if again is not None and again[0] <= target + grain else None


def moved(job: EngineJob, name: str, limit: Known, bound: float) -> EngineJob:
    """The job with one limit or cap at another bound [SI], inf: without it."""
    if isinstance(limit, Cap):
        return wider(job, limit, bound)
    if bound == inf:
        return replace(job, limits={key: one for key, one in job.limits.items() if key != name})
    return replace(job, limits={**job.limits, name: limit.at(bound)})


def impasse(job: EngineJob, claim: str, work: float, budget: Budget) -> tuple[Conflict | None, str]:
    """Why no weights and no cranks are possible: the limits that cannot hold together and the smallest loosening."""

    def possible(kept: tuple[str, ...]) -> bool:
        return balance(replace(job, limits={name: job.limits[name] for name in kept})).status != "infeasible"

    def loosened(names: tuple[str, ...]) -> list[Step]:
        return [step for name in names for step in _loosening(job, name)]

    return clash(tuple(job.limits), possible, loosened, claim, 3 * len(job.limits) + 1, work, budget)


def _loosening(job: EngineJob, name: str) -> list[Step]:
    """The least bound of one limit that lets the others hold, solved once more with it."""
    table = job.limits[name]
    free, every = moved(job, name, table, inf), (arms(job, cranks) for cranks in settings(job))
    found = [least_response(free, here, lengths(table, here), []) for here in every]
    reached = [one for one in found if one is not None]
    if not reached:
        return []
    bound = min(reached) * _LOOSER
    if balance(moved(job, name, table, bound)).status == "infeasible":
        return []
    now, then = (Entry(one, table.dimension, table.unit) for one in (table.bound, bound))
    return [(name, now, then)]
