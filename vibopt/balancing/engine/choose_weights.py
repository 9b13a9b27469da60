"""The best weights for given cranks, the best cranks of all classes, and what each limit and cap costs."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from math import inf

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.balancing.engine.engine_job import EngineJob
from vibopt.balancing.engine.engine_tables import EngineGoalTable, EngineLimitTable
from vibopt.balancing.engine.firing import best_firing, classes, count, is_even
from vibopt.balancing.engine.shaking import Arms, arms, free_shares, free_weights, of_order, over_turn, peaks, size_of
from vibopt.balancing.lengths import Box, Least, Lengths, excess, least
from vibopt.errors import counted
from vibopt.records import dataclass

Solver = Callable[[Lengths, Sequence[Lengths], Box], Least]
ALIKE = 1e-9
_DEGREES = np.linspace(0.0, 2.0 * np.pi, 360, endpoint=False)
_ROUNDS, _EXACT = 12, 1e-9
"""Times that crank angles are added, and the part by which all orders together may be greater between them."""


@dataclass(frozen=True)
class Balanced:
    """Crank angles per throw [rad], the choices x, and how they are known.

    alike
        Classes of crank phasings that are as good in the goal and in every response of `then`; 1 without a search.
    rates
        What the goal falls by per unit of each limit, and of what is chosen at its most [SI]; None with a search.
    """

    cranks: tuple[float, ...]
    x: FloatArray
    status: str
    claim: str
    way: str
    tried: int = 1
    alike: int = 1
    rates: Mapping[str, float] | None = None


def balance(job: EngineJob, solver: Solver = least) -> Balanced:
    """The engine with what is chosen set as well as can be; `solver` answers the program of given cranks."""
    if not job.is_search:
        cranks = tuple(0.0 if crank is None else crank for crank in job.cranks)
        answer = weigh(job, arms(job, cranks), solver)
        way = "program" if box_of(job).size and job.goal is not None else "none"
        x = answer.x if answer.x is not None else np.zeros(box_of(job).size)
        return Balanced(cranks, x, answer.status, answer.claim, way, rates=_rates(job, answer))
    best: Balanced | None = None
    best_rank: tuple[float, ...] = ()
    tried, alike, open_ = 0, 1, 0
    for cranks in settings(job):
        tried += 1
        found = arms(job, cranks)
        answer = weigh(job, found, solver)
        if answer.x is None:
            open_ += answer.status != "infeasible"
            continue
        rank = _rank(job, found, answer)
        order = _compare(rank, best_rank)
        alike = alike + 1 if order == 0 else 1 if order < 0 else alike
        if order < 0:
            best, best_rank = Balanced(cranks, answer.x, answer.status, answer.claim, "phasing"), rank
    return _searched(job, best, tried, alike, open_)


def _rates(job: EngineJob, answer: Least) -> dict[str, float] | None:
    """By names in the file; None of an analysis."""
    if answer.pulls is None:
        return None
    weights = [job.weights[k] for k in free_weights(job)]
    names = [
        *(f"engine.{share.name}" for share in free_shares(job)),
        *(f"{w.family}.{w.name}.unbalance" for w in weights),
    ]
    pulls = answer.pulls
    every = np.concatenate([pulls.shares, pulls.caps, pulls.limits])
    return dict(zip([*names, *job.limits], every.tolist(), strict=True))


def settings(job: EngineJob) -> Iterator[tuple[float, ...]]:
    """Crank angles per throw [rad] to be looked at: as given, or one of each class that may be chosen."""
    if not job.is_search:
        yield tuple(0.0 if crank is None else crank for crank in job.cranks)
        return
    for cranks in classes(job):
        if not job.even_firing or is_even(best_firing(job, cranks)):
            yield cranks


def _searched(job: EngineJob, best: Balanced | None, tried: int, alike: int, undecided: int) -> Balanced:
    """The answer of a search with what was tried; classes without an answer and without a proof leave it open."""
    said = f"all {counted(count(job), 'settings')} of the cranks, {tried} classes that differ"
    if undecided:
        said += f", {undecided} of them without an answer and without a proof that there is none"
    if best is None:
        none = tuple(0.0 if crank is None else crank for crank in job.cranks)
        word = "found to keep" if undecided else "keeps"
        claim = f"no setting {word} the limits: {said}" if tried else "no setting of the cranks fires evenly"
        status = "unproven" if undecided else "infeasible"
        return Balanced(none, np.zeros(box_of(job).size), status, claim, "phasing", tried)
    claim = f"{said}, {alike} as good as this one" if alike > 1 else f"{said}, none as good as this one"
    status = "feasible" if undecided or best.status == "feasible" else "optimal"
    return Balanced(best.cranks, best.x, status, claim, best.way, tried, alike)


def _rank(job: EngineJob, arms: Arms, answer: Least) -> tuple[float, ...]:
    """The goal and the responses that decide between equals, each relative to its size."""
    now = arms.at(answer.x if answer.x is not None else np.zeros(box_of(job).size))
    sizes = [size_of(job, couple, rotating=False) for couple in (False, True)]
    then = [EngineLimitTable(response=one) for one in (job.goal.then if job.goal is not None else ())]
    goal = goal_table(job)
    size, here = sizes[goal.is_couple], of_order(now, goal.is_couple, goal.of_order)
    return (here / size, *(of_order(now, t.is_couple, t.of_order) / sizes[t.is_couple] for t in then))


def _compare(rank: tuple[float, ...], best: tuple[float, ...]) -> int:
    """-1 where `rank` is better, 0 where as good, 1 where worse; differences below rounding do not count."""
    if not best:
        return -1
    for value, other in zip(rank, best, strict=True):
        if abs(value - other) > ALIKE:
            return -1 if value < other else 1
    return 0


def goal_table(job: EngineJob) -> EngineLimitTable:
    """The goal as a response."""
    if job.goal is None:
        return EngineLimitTable(response="primary_force")
    return EngineLimitTable(response=job.goal.minimise, order=job.goal.order)


def box_of(job: EngineJob) -> Box:
    """Bounds of the choices."""
    shares = tuple((share.low, share.high) for share in free_shares(job))
    return Box(shares, tuple(job.weights[k].cap for k in free_weights(job)))


def weigh(job: EngineJob, arms: Arms, solver: Solver = least) -> Least:
    """The best share and weights for given cranks; what is only looked at is "met" or "violated".

    All orders together are held at ever more crank angles, until they are no greater between them.
    """
    turn = _DEGREES
    for _ in range(_ROUNDS):
        answer = _weigh_at(job, arms, turn, solver)
        beyond = _beyond(job, arms, answer, turn)
        if not beyond.size:
            break
        turn = np.union1d(turn, beyond)
    return answer


def _beyond(job: EngineJob, arms: Arms, answer: Least, turn: FloatArray) -> FloatArray:
    """Crank angles [rad] at which all orders together are greater than at those of `turn`, and matter; (n,)."""
    whole = [table for table in (goal_table(job), *job.limits.values()) if not table.of_order]
    if answer.x is None or not whole:
        return np.zeros(0)
    now, most = arms.at(answer.x), []
    for table in whole:
        angles, sizes = peaks(now, table.is_couple)
        looked = float(np.abs(over_turn(now, table.is_couple, turn)).max())
        most.append(angles[sizes > max(looked, table.bound if table.at_most is not None else 0.0) * (1.0 + _EXACT)])
    return np.concatenate(most)


def _weigh_at(job: EngineJob, arms: Arms, turn: FloatArray, solver: Solver) -> Least:
    """The same with all orders together at the crank angles `turn` [rad] alone."""
    box, goal = box_of(job), lengths(goal_table(job), arms, turn=turn)
    limits = [lengths(limit, arms, limit.bound, turn=turn) for limit in job.limits.values()]
    if not box.size or job.goal is None:
        x = np.zeros(box.size)
        broken = [
            name for name, limit in zip(job.limits, limits, strict=True) if limit.value(x) > limit.limit * (1.0 + 1e-9)
        ]
        if broken and job.is_search:
            return Least(None, inf, inf, "infeasible", "broken: " + ", ".join(broken))
        claim = "limits that do not hold: " + ", ".join(broken) if broken else "nothing is chosen: the engine as it is"
        return Least(x, goal.value(x), goal.value(x), "violated" if broken else "met", claim)
    first = solver(goal, limits, box)
    if first.x is None:
        return first
    return _shared_out(job, _lightest(job, goal, limits, box, first, solver) if box.caps else first)


def _shared_out(job: EngineJob, answer: Least) -> Least:
    """Of all pairs of shares that carry as much the one with most of the rotating mass, which is the rule.

    Only where both are chosen and both masses have one ratio in all cylinders does it not matter which is carried.
    """
    free = free_shares(job)
    parts = np.array([[share.of(cylinder) for share in job.shares] for cylinder in job.cylinders])
    if len(free) < 2 or answer.x is None or np.ptp(parts[:, 1] * parts[0, 0] - parts[:, 0] * parts[0, 1]) > 0.0:
        return answer
    mass, turning = parts[0]
    x = answer.x.copy()
    whole = x[0] * mass + x[1] * turning
    x[1] = min(free[1].high, (whole - free[0].low * mass) / turning)
    x[0] = (whole - x[1] * turning) / mass
    return replace(answer, x=x)


def _lightest(job: EngineJob, goal: Lengths, limits: list[Lengths], box: Box, first: Least, solver: Solver) -> Least:
    """Of all weights with the same goal the lightest: so that none is there for nothing."""
    size = size_of(job, goal_table(job).is_couple, rotating=False)
    start = len(box.shares)
    picks = np.zeros((len(box.caps), box.size), dtype=complex)
    for k in range(len(box.caps)):
        picks[k, start + 2 * k], picks[k, start + 2 * k + 1] = 1.0, 1j
    kept = Lengths(goal.constant, goal.slope, goal.by, first.value + 1e-8 * size)
    weights = Lengths(np.zeros(len(box.caps), dtype=complex), picks)
    second = solver(weights, [*limits, kept], box)
    if second.x is None or first.x is None or weights.value(second.x) > weights.value(first.x) * (1.0 - 1e-6):
        return first
    if excess(second.x, limits) > max(excess(first.x, limits), _EXACT):
        return first
    return replace(first, x=second.x, value=goal.value(second.x))


def lengths(table: EngineLimitTable, arms: Arms, limit: float = inf, turn: FloatArray = _DEGREES) -> Lengths:
    """A response as lengths of affine rows: both arms of one order added, or the greatest at crank angles [rad]."""
    row, order = int(table.is_couple), table.of_order
    if order:
        if order >= arms.constant.shape[2]:
            return Lengths(np.zeros(1, dtype=complex), np.zeros((1, arms.slope.shape[3]), dtype=complex), "sum", limit)
        return Lengths(arms.constant[row, :, order], arms.slope[row, :, order], "sum", limit)
    constant = over_turn(arms.constant, table.is_couple, turn)
    slope = np.array([over_turn(arms.slope[..., k], table.is_couple, turn) for k in range(arms.slope.shape[3])])
    return Lengths(constant, slope.T.reshape(len(turn), -1), "worst", limit)


def least_bound(job: EngineJob, name: str) -> float | None:
    """The least bound of one limit that lets the others hold; None where that is not known."""
    others = {key: one for key, one in job.limits.items() if key != name}
    goal = EngineGoalTable(minimise=job.limits[name].response, order=job.limits[name].order)
    free = replace(job, limits=others, goal=goal)
    every = [weigh(free, arms(job, cranks)) for cranks in settings(job)]
    return min((least.value for least in every if least.x is not None and least.status != "violated"), default=None)
