"""The best weights for given cranks, the best cranks of all classes, and what each limit and cap costs.

What is chosen is asked as of a rotor: shares are real numbers within ends, weights complex unbalances at crank angle
zero.  The force or couple of one order is longest by both of its arms together, so that these two readings are added;
of all orders together it is held at many crank angles.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from math import inf

import numpy as np

from vibopt.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from vibopt.balancing.engine.engine_job import EngineJob
from vibopt.balancing.engine.engine_tables import EngineGoalTable, EngineLimitTable
from vibopt.balancing.engine.firing import classes, count, may_fire
from vibopt.balancing.engine.shaking import Arms, arms, free_shares, free_weights, of_order, over_turn, peaks, size_of
from vibopt.balancing.optimisers import Solver, solve_question
from vibopt.balancing.question import Question, Solved, relative_gap, together
from vibopt.balancing.rates import Bounding, rates
from vibopt.errors import counted
from vibopt.records import dataclass

ALIKE = 1e-9
NOTHING = 1e-11
"""Part of the size of a goal that is rounding: such a goal is zero, and stays it with lighter weights."""
_TRACE = 1e-8
"""Part of what the cranks carry up to which a weight is none."""
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
    x: ComplexArray
    status: str
    claim: str
    way: str
    tried: int = 1
    alike: int = 1
    rates: Mapping[str, float] | None = None


def balance(job: EngineJob, solver: Solver = solve_question, others: Sequence[EngineJob] = ()) -> Balanced:
    """The engine with what is chosen set as well as can be; `solver` answers the question of given cranks.

    others
        The same engine in scenarios: every limit holds in each of them, and the goal is that of the worst.
    """
    if not job.is_search:
        cranks = tuple(0.0 if crank is None else crank for crank in job.cranks)
        answer = weigh(_cases(job, others, cranks), solver)
        way = "program" if chosen(job) and job.goal is not None else "none"
        found = answer.details.get("rates")
        return Balanced(cranks, _choices(job, answer), answer.status, answer.claim, way, rates=found)
    best: Balanced | None = None
    best_rank: tuple[float, ...] = ()
    tried, alike, open_ = 0, 1, 0
    for cranks in settings(job, others):
        tried += 1
        cases = _cases(job, others, cranks)
        answer = weigh(cases, solver)
        if answer.u is None:
            open_ += answer.status != "infeasible"
            continue
        rank = _rank(cases, answer)
        order = _compare(rank, best_rank)
        alike = alike + 1 if order == 0 else 1 if order < 0 else alike
        if order < 0:
            best, best_rank = Balanced(cranks, answer.u, answer.status, answer.claim, "phasing"), rank
    return _searched(job, best, tried, alike, open_)


Cases = Sequence[tuple[EngineJob, Arms]]
"""An engine and its scenarios, each with its arms at the same cranks."""


def _cases(job: EngineJob, others: Sequence[EngineJob], cranks: Sequence[float]) -> Cases:
    return [(one, arms(one, cranks)) for one in (job, *others)]


def chosen(job: EngineJob) -> tuple[str, ...]:
    """Paths of the shares and weights that are chosen, as planes of a question."""
    weights = [job.weights[k] for k in free_weights(job)]
    return (*(f"engine.{share.name}" for share in free_shares(job)), *(f"{w.family}.{w.name}" for w in weights))


def _choices(job: EngineJob, answer: Solved) -> ComplexArray:
    """What is chosen (n_chosen,); nothing where there is no answer."""
    return answer.u if answer.u is not None else np.zeros(len(chosen(job)), dtype=complex)


def bounds_of(job: EngineJob, question: Question, own: IntArray) -> dict[str, Bounding]:
    """What bounds a question that `pose` made, by the names of the file: ends of shares, caps and limits."""
    known = {}
    for k, path in enumerate(chosen(job)):
        ends = question.ends[k] if question.ends else None
        most = question.caps[k] if ends is None else ends[1] - ends[0]
        known[path if ends is not None else f"{path}.unbalance"] = Bounding(float(most), plane=k)
    for number, (name, limit) in enumerate(job.limits.items(), start=1):
        known[name] = Bounding(limit.bound, rows=np.flatnonzero(own == number).tolist())
    return known


def settings(job: EngineJob, others: Sequence[EngineJob] = ()) -> Iterator[tuple[float, ...]]:
    """Crank angles per throw [rad] to be looked at: as given, or one of each class that may be chosen."""
    if not job.is_search:
        yield tuple(0.0 if crank is None else crank for crank in job.cranks)
        return
    for cranks in classes(job, others):
        if all(may_fire(one, cranks) for one in (job, *others)):
            yield cranks


def _searched(job: EngineJob, best: Balanced | None, tried: int, alike: int, undecided: int) -> Balanced:
    """The answer of a search with what was tried; classes without an answer and without a proof leave it open."""
    said = f"all {counted(count(job), 'settings')} of the cranks, {counted(tried, 'classes')}"
    said += " that differ" if tried > 1 else ""
    if undecided:
        said += f", {undecided} of them without an answer and without a proof that there is none"
    if best is None:
        none = tuple(0.0 if crank is None else crank for crank in job.cranks)
        word = "found to keep" if undecided else "keeps"
        so = f" in the order {'-'.join(map(str, job.fires))}" if job.fires else ""
        fires = f"no setting of the cranks fires{so}{' at equal distances' if job.even_firing else ''}"
        claim = f"no setting {word} the limits: {said}" if tried else fires
        status = "unproven" if undecided else "infeasible"
        return Balanced(none, np.zeros(len(chosen(job)), dtype=complex), status, claim, "phasing", tried)
    if tried > 1:
        said += f", {alike} as good as this one" if alike > 1 else ", none as good as this one"
    status = "feasible" if undecided or best.status == "feasible" else "optimal"
    return Balanced(best.cranks, best.x, status, said, best.way, tried, alike)


def _rank(cases: Cases, answer: Solved) -> tuple[float, ...]:
    """The goal and the responses that decide between equals, each that of the worst case, relative to its size."""
    job = cases[0][0]
    then = [EngineLimitTable(response=one) for one in (job.goal.then if job.goal is not None else ())]
    sizes = [_size(cases, couple) for couple in (False, True)]
    every = [arms.at(_choices(job, answer)) for _, arms in cases]
    return tuple(
        max(of_order(now, table.is_couple, table.of_order) for now in every) / sizes[table.is_couple]
        for table in (goal_table(job), *then)
    )


def _size(cases: Cases, couple: bool) -> float:
    return max(size_of(job, couple, rotating=False) for job, _ in cases)


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


def pose(
    job: EngineJob, arms: Arms, turn: FloatArray = _DEGREES, *, several: bool = False
) -> tuple[Question, IntArray]:
    """What is chosen as a question, and the number of what each of its rows belongs to: 0 the goal, then the limits.

    turn
        Crank angles [rad] at which all orders together are held.
    several
        Whether the goal is to be that of the worst of several cases: one order, too, is then held at all of `turn`.
    """
    tables = [goal_table(job), *job.limits.values()]
    rows = [_rows(table, arms, turn, at_turn=several and not k) for k, table in enumerate(tables)]
    own = np.repeat(np.arange(len(tables)), [len(constant) for constant, _ in rows])
    of_one = np.array([table.of_order > 0 and not (several and not k) for k, table in enumerate(tables)])
    shares, weights = free_shares(job), [job.weights[k] for k in free_weights(job)]
    question = Question(
        y0=np.concatenate([constant for constant, _ in rows]),
        H=np.concatenate([slope for _, slope in rows]),
        importance=np.where(own == 0, 1.0, 0.0),
        limits=np.array([inf, *(table.bound for table in tables[1:])])[own],
        caps=np.array([*(share.high for share in shares), *(weight.cap for weight in weights)]),
        ends=(*((share.low, share.high) for share in shares), *(None for _ in weights)) if shares else (),
        mass_per_unbalance=np.array([0.0] * len(shares) + [1.0] * len(weights)),
        goal="sum" if of_one[0] else "worst",
        sums=np.where(of_one[own], own, len(tables) + np.arange(len(own))),
    )
    return question, own


def pose_cases(cases: Cases, turn: FloatArray) -> tuple[Question, IntArray]:
    """The same of an engine and its scenarios, limits numbered on from one to the next."""
    first, *rest = [pose(job, arms, turn, several=len(cases) > 1) for job, arms in cases]
    question, own = first
    for more, its in rest:
        sums = np.concatenate([question.sums, more.sums + question.sums.max() + 1])
        own = np.concatenate([own, np.where(its > 0, its + own.max(), 0)])
        question = replace(question.with_rows(more.y0, more.H, more.importance, more.limits), sums=sums)
    return question, own


def _rows(
    table: EngineLimitTable, arms: Arms, turn: FloatArray, *, at_turn: bool = False
) -> tuple[ComplexArray, ComplexArray]:
    """A response as affine rows, (n,) and (n, n_chosen): both arms of one order, or all together at crank angles.

    With `at_turn` one order is told at crank angles, too.
    """
    row, order, n = int(table.is_couple), table.of_order, arms.slope.shape[3]
    if order >= arms.constant.shape[2]:
        return np.zeros(1, dtype=complex), np.zeros((1, n), dtype=complex)
    if order and not at_turn:
        return arms.constant[row, :, order], arms.slope[row, :, order]
    arms = _alone(arms, order)
    slope = [over_turn(arms.slope[..., k], table.is_couple, turn) for k in range(n)]
    return over_turn(arms.constant, table.is_couple, turn), np.array(slope).T.reshape(len(turn), n)


def _alone(arms: Arms, order: int) -> Arms:
    """One order without the others; all of them where it is 0."""
    if not order:
        return arms
    kept = np.arange(arms.constant.shape[2]) == order
    return replace(arms, constant=arms.constant * kept, slope=arms.slope * kept[:, None])


def weigh(cases: Cases, solver: Solver = solve_question) -> Solved:
    """The best shares and weights for given cranks; what is only looked at is "met" or "violated".

    All orders together are held at ever more crank angles, until they are no greater between them.
    """
    turn = _DEGREES
    for _ in range(_ROUNDS):
        answer = _weigh_at(cases, turn, solver)
        beyond = np.concatenate([_beyond(job, arms, answer, turn, several=len(cases) > 1) for job, arms in cases])
        if not beyond.size:
            break
        turn = np.union1d(turn, beyond)
    return answer


def _beyond(job: EngineJob, arms: Arms, answer: Solved, turn: FloatArray, *, several: bool) -> FloatArray:
    """Crank angles [rad] at which what is held at those of `turn` is greater, and matters; (n,)."""
    goal = goal_table(job)
    held = [table for table in (goal, *job.limits.values()) if not table.of_order or (several and table is goal)]
    if answer.u is None or not held:
        return np.zeros(0)
    most = []
    for table in held:
        now = _alone(arms, table.of_order).at(answer.u)
        if not now[int(table.is_couple)].any():
            continue
        angles, sizes = peaks(now, table.is_couple)
        looked = float(np.abs(over_turn(now, table.is_couple, turn)).max())
        most.append(angles[sizes > max(looked, table.bound if table.at_most is not None else 0.0) * (1.0 + _EXACT)])
    return np.concatenate([np.zeros(0), *most])


def _weigh_at(cases: Cases, turn: FloatArray, solver: Solver) -> Solved:
    """The same with all orders together at the crank angles `turn` [rad] alone."""
    question, own = pose_cases(cases, turn)
    job = cases[0][0]
    if not question.n_planes or job.goal is None:
        u = question.base
        over = _excess(question, u) > 1e-9
        names = [name for one, _ in cases for name in one.limits]
        broken = [name for number, name in enumerate(names, start=1) if over[own == number].any()]
        if broken and job.is_search:
            return Solved(None, "infeasible", "broken: " + ", ".join(broken))
        claim = "limits that do not hold: " + ", ".join(broken) if broken else "nothing is chosen: the engine as it is"
        return Solved(u, "violated" if broken else "met", claim, question.value(u))
    first = solver(question)
    if first.u is None:
        return first
    if len(cases) == 1:
        first = replace(first, details={"rates": rates(question, first, bounds_of(job, question, own))})
    if not free_weights(job):
        return _shared_out(cases, first)
    lightest = _without_traces(cases, question, _lightest(cases, question, own == 0, first, solver))
    return _shared_out(cases, _as_proven(lightest, question, _size(cases, goal_table(job).is_couple)))


def _excess(question: Question, u: ComplexArray) -> FloatArray:
    """By which part each row is over its limit (n_readings,)."""
    left = together(np.abs(question.residual(u)), question.sums)
    return np.asarray(left / np.maximum(question.limits, 1e-250) - 1.0)


def _shared_out(cases: Cases, answer: Solved) -> Solved:
    """Of all pairs of shares that carry as much the one with most of the rotating mass, which is the rule.

    Only where both are chosen and both masses have one ratio in all cylinders does it not matter which is carried.
    """
    free = free_shares(cases[0][0])
    parts = np.array([[share.of(cylinder) for share in job.shares] for job, _ in cases for cylinder in job.cylinders])
    if len(free) < 2 or answer.u is None or np.ptp(parts[:, 1] * parts[0, 0] - parts[:, 0] * parts[0, 1]) > 0.0:
        return answer
    mass, turning = parts[0]
    u = answer.u.copy()
    whole = float((u[0] * mass + u[1] * turning).real)
    u[1] = min(free[1].high, (whole - free[0].low * mass) / turning)
    u[0] = (whole - u[1] * turning) / mass
    return replace(answer, u=u)


def _lightest(cases: Cases, question: Question, goal: BoolArray, first: Solved, solver: Solver) -> Solved:
    """Of all weights with the same goal, whose rows are given, the lightest: so that none is there for nothing."""
    assert first.u is not None
    size = _size(cases, goal_table(cases[0][0]).is_couple)
    bound = first.value + 1e-8 * size if first.value > NOTHING * size else 0.0
    lighter = replace(question, goal="correction", limits=np.where(goal, bound, question.limits))
    second = solver(lighter)
    if second.u is None or lighter.value(second.u) > lighter.value(first.u) * (1.0 - 1e-6):
        return first
    over, before = (float(_excess(question, u)[question.limits > 0.0].max(initial=0.0)) for u in (second.u, first.u))
    return first if over > max(before, _EXACT) else replace(first, u=second.u, value=question.value(second.u))


def _without_traces(cases: Cases, question: Question, answer: Solved) -> Solved:
    """Without weights that are next to nothing of what the cranks carry: rounding of a solver, where nothing feels it.

    A goal of zero stays zero.
    """
    assert answer.u is not None
    job = cases[0][0]
    least = _TRACE * size_of(job, couple=False) / job.speed**2
    weights = np.arange(len(answer.u)) >= len(free_shares(job))
    u = np.where(weights & (np.abs(answer.u) <= least), 0.0, answer.u)
    over, before = (float(_excess(question, one).max(initial=0.0)) for one in (u, answer.u))
    size = _size(cases, goal_table(job).is_couple)
    most = answer.value + _EXACT * size if answer.value > NOTHING * size else NOTHING * size
    return answer if over > max(before, _EXACT) or question.value(u) > most else replace(answer, u=u)


def _as_proven(answer: Solved, question: Question, size: float) -> Solved:
    """The answer with the gap of the weights that were taken: the lightest may be a hair worse than the best."""
    assert answer.u is not None
    value = question.value(answer.u)
    gap = relative_gap(value, answer.bound, size)
    claim = answer.claim.replace(f"gap {answer.gap:.1e}", f"gap {gap:.1e}")
    return replace(answer, value=value, gap=gap, claim=claim)


def least_bound(job: EngineJob, name: str) -> float | None:
    """The least bound of one limit that lets the others hold; None where that is not known."""
    others = {key: one for key, one in job.limits.items() if key != name}
    goal = EngineGoalTable(minimise=job.limits[name].response, order=job.limits[name].order)
    free = replace(job, limits=others, goal=goal)
    every = [weigh(_cases(free, (), cranks)) for cranks in settings(job)]
    return min((least.value for least in every if least.u is not None and least.status != "violated"), default=None)
