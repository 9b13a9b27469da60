"""One plan of weights for a measured rotor or for known masses, or one engine, as the file is and in every scenario."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from vibopt.answer.answer import Answer
from vibopt.answer.entry import Entry
from vibopt.balancing import is_known, is_rotor
from vibopt.balancing.engine.choose_weights import balance
from vibopt.balancing.engine.engine_answer import answer_at
from vibopt.balancing.engine.engine_job import EngineJob
from vibopt.balancing.impasses import NOTHING_FOUND, clash
from vibopt.balancing.known import solve_known
from vibopt.balancing.known.correct import complete
from vibopt.balancing.known.correct import pose as pose_known
from vibopt.balancing.known.known_job import KnownJob, KnownLimitTable
from vibopt.balancing.known.shaft_statics import aim_of
from vibopt.balancing.optimisers import allowance, solve_question
from vibopt.balancing.question import Options, Question, Solved
from vibopt.balancing.rotor_job import CorrectionLimit, ResidualLimit, RotorJob
from vibopt.balancing.rotor_limits import with_limits
from vibopt.balancing.solve_rotor import asked_of, solve_job
from vibopt.errors import InputError
from vibopt.jobs import asks_shares, is_open, kept_plan
from vibopt.records import dataclass
from vibopt.study.for_all import AS_IT_IS, OneForAll
from vibopt.study.seen import GOOD, chosen
from vibopt.work import metered

if TYPE_CHECKING:
    from vibopt.jobs import Job

_INSTEAD = "vibopt compare FILE --scenarios answers each by itself."
_SAME_CHOICE = ("options", "stock", "sectors", "mass_per_unbalance", "pairs", "goal")


@dataclass(frozen=True)
class _Asked:
    """A scenario with its question.

    limits
        By name; what bounds the weights alone says as much, if it is the same, in every scenario.
    with_only
        The question with some of its limits.
    with_plan
        The answer with the weights of a plan, put back into the rotor, or the shaft, of this scenario.
    sure
        Whether every plane is felt, so that what is impossible is proven.
    """

    question: Question
    limits: Mapping[str, ResidualLimit | CorrectionLimit | KnownLimitTable]
    with_only: Callable[[Sequence[str]], Question]
    with_plan: Callable[[Solved], Answer[Any]]
    sure: bool = True


def one_plan(job: Job, variants: Mapping[str, Job]) -> OneForAll:
    """The best one plan that keeps every limit in every variant, measured in each.

    Where least squares, or a sum, is asked for it goes over the readings of all variants at once.

    Raises
    ------
    InputError
        Nothing to choose, readings without angles, or variants that may not choose from the same.
    """
    asked = {name: _asked(job, name, one) for name, one in variants.items()}
    for name, one in asked.items():
        if not _same_choice(asked[AS_IT_IS].question, one.question):
            raise InputError(
                f"{job.name}: scenario {name} changes what may be chosen, or what is made best, so there is no one "
                f"plan for all. {_INSTEAD}"
            )
    solved = solve_question(_merged([one.question for one in asked.values()]))
    if solved.u is None:
        proven = solved.status == "infeasible" and all(one.sure for one in asked.values())
        status, reason = ("infeasible", _reason(asked, solved)) if proven else ("unproven", "")
        claim = f"{solved.claim}; no one plan was found that holds in all scenarios"
        return OneForAll(job, status, claim, None, {}, {}, reason)
    found = {name: one.with_plan(replace(solved, prices=None)) for name, one in asked.items()}
    said = f"{solved.claim}; put back into each of {len(found)} {'shafts' if is_known(job) else 'simulated rotors'}"
    if asked[AS_IT_IS].question.goal not in ("worst", "correction"):
        said += "; made least over all scenarios at once"
    return _told(job, solved.status, said, found)


def one_engine(job: EngineJob, variants: Mapping[str, EngineJob]) -> OneForAll:
    """The same of an engine: its shares, weights and cranks, the goal that of the worst variant."""
    for name, one in variants.items():
        if not (is_open(one) and one.goal is not None):
            raise InputError(
                f"{job.name}: one design for all scenarios needs something to choose and a goal, and scenario {name} "
                f"has not both. {_INSTEAD}"
            )
        if _choice(one) != _choice(job):
            raise InputError(
                f"{job.name}: scenario {name} changes what may be chosen, how the cranks stand, or what is made best, "
                f"so there is no one design for all. {_INSTEAD}"
            )
    with metered() as meter:
        found = balance(job, others=[one for name, one in variants.items() if name != AS_IT_IS])
    if found.status in NOTHING_FOUND:

        def possible(kept: Kept) -> bool:
            first, *others = [
                replace(one, limits={key: one.limits[key] for key in kept[name]}) for name, one in variants.items()
            ]
            return balance(first, others=others).status != "infeasible"

        own = {name: dict.fromkeys(one.limits, False) for name, one in variants.items()}
        reason = _conflict(own, possible, found.claim, meter.done) if found.status == "infeasible" else ""
        claim = f"{found.claim}; no one design was found that holds in all scenarios"
        return OneForAll(job, found.status, claim, None, {}, {}, reason)
    said = f"{found.claim}; each of {len(variants)} engines turned in time with it"
    return _told(job, found.status, said, {name: answer_at(one, found) for name, one in variants.items()})


def _choice(job: EngineJob) -> tuple[object, ...]:
    """What may be chosen of an engine, and what is made best."""
    shares = [(share.name, share.low, share.high) for share in job.shares if share.is_free]
    weights = [(one.family, one.name, one.cap) for one in job.weights if one.fixed is None]
    cranks = (job.cranks, job.offered, [cylinder.throw for cylinder in job.cylinders])
    return shares, weights, cranks, job.goal


def _told(job: Job, status: str, claim: str, found: Mapping[str, Answer[Any]]) -> OneForAll:
    """What was chosen with its answer in every variant."""
    refused = next(((name, answer) for name, answer in found.items() if answer.status not in GOOD), None)
    if refused is not None:
        return OneForAll(job, refused[1].status, f"{refused[0]}: {refused[1].claim}", None, {}, {})
    goal = max((answer.goal for answer in found.values() if answer.goal is not None), key=lambda one: one[1].value)
    values = {path: one for path, one in chosen(job, found[AS_IT_IS]).items() if isinstance(one, Entry)}
    limits = {name: dict(answer.limits) for name, answer in found.items()}
    return OneForAll(job, status, claim, goal, values, limits, kept=kept_plan(cast(Any, job), found[AS_IT_IS]))


def _asked(whole: Job, name: str, job: Job) -> _Asked:
    if asks_shares(job):
        raise InputError(f"{whole.name}: one plan for all scenarios knows no limit with_probability. {_INSTEAD}")
    if is_known(job) and is_open(job) and job.goal is not None:
        return _shaft(job)
    if is_rotor(job) and is_open(job) and job.aim and not job.is_advice and job.has_phase:
        return _rotor(job)
    raise InputError(
        f"{whole.name}: one plan for all scenarios needs weights that are chosen and readings with their angles, and "
        f"scenario {name} has not both. {_INSTEAD}"
    )


def _shaft(job: KnownJob) -> _Asked:
    """Known masses, the goal counted as the file does: speeds may differ."""
    question, aim = complete(job, pose_known(job).question), aim_of(job)
    question = question if aim is None else replace(question, importance=question.importance * aim.scale)

    def with_only(kept: Sequence[str]) -> Question:
        return pose_known(replace(job, limits={name: one for name, one in job.limits.items() if name in kept})).question

    return _Asked(question, job.limits, with_only, lambda solved: solve_known(job, solver=lambda _: solved))


def _rotor(job: RotorJob) -> _Asked:
    _, _, idle, posed = asked_of(job)
    return _Asked(
        posed.question,
        {one.name: one for one in job.every_limit},
        lambda kept: with_limits(job.limited_to(kept), posed),
        lambda solved: solve_job(job, solver=lambda _: solved),
        not idle,
    )


def _same_choice(first: Question, other: Question) -> bool:
    """Whether the planes may take the same, but for their caps, and the same is made best."""
    holes = [[None if fan is None else (fan.each, *fan.angles) for fan in question.fans] for question in (first, other)]
    return holes[0] == holes[1] and all(_same(getattr(first, name), getattr(other, name)) for name in _SAME_CHOICE)


def _same(one: object, other: object) -> bool:
    if isinstance(one, tuple) and isinstance(other, tuple):
        return len(one) == len(other) and all(map(_same, one, other))
    if isinstance(one, Options) and isinstance(other, Options):
        return all(_same(getattr(one, name), getattr(other, name)) for name in ("u", "masses", "uses"))
    return np.array_equal(np.asarray(one), np.asarray(other))


def _merged(questions: Sequence[Question]) -> Question:
    """The readings of all, within the least of all caps."""
    rows: dict[str, Any] = {
        name: np.concatenate([getattr(question, name) for question in questions])
        for name in ("y0", "H", "importance", "limits")
    }
    caps = np.min([question.caps for question in questions], axis=0)
    if any(question.adds_up for question in questions):
        own = [question.sums if question.adds_up else np.arange(question.n_readings) for question in questions]
        before = np.cumsum([0, *(int(sums.max()) + 1 for sums in own)])
        rows["sums"] = np.concatenate([first + sums for first, sums in zip(before, own, strict=False)])
    return replace(questions[0], **rows, caps=caps, total_cap=min(question.total_cap for question in questions))


Kept = Mapping[str, tuple[str, ...]]
"""Limits that are kept, by variant."""


def _reason(asked: Mapping[str, _Asked], solved: Solved) -> str:
    """Which limits, in which scenarios, cannot hold together."""
    first = asked[AS_IT_IS].limits
    shared = {
        limit: said for limit, said in first.items()
        if getattr(said, "response", "correction") == "correction" and not isinstance(said, ResidualLimit)
    }  # fmt: skip
    own = {
        name: {limit: said == shared.get(limit) for limit, said in one.limits.items()} for name, one in asked.items()
    }

    @cache
    def question(name: str, kept: tuple[str, ...]) -> Question:
        return asked[name].with_only(kept)

    def possible(kept: Kept) -> bool:
        return solve_question(_merged([question(*one) for one in kept.items()])).status != "infeasible"

    return _conflict(own, possible, solved.claim, solved.work)


def _conflict(own: Mapping[str, Mapping[str, bool]], possible: Callable[[Kept], bool], claim: str, work: float) -> str:
    """Which limits cannot hold together, in words.

    own
        Limits of each variant, and whether they bound as much in all of them: they are then told once.
    possible
        Whether something keeps these limits of each variant.
    """
    names: dict[str, set[tuple[str, str]]] = {}
    for variant, limits in own.items():
        for limit, shared in limits.items():
            said = limit if shared or variant == AS_IT_IS else f"{limit} in {variant}"
            names.setdefault(said, set()).add((variant, limit))

    def keeps(kept: tuple[str, ...]) -> bool:
        held = {one for key in kept for one in names[key]}
        return possible({name: tuple(one for one in mine if (name, one) in held) for name, mine in own.items()})

    return clash(tuple(names), keeps, lambda _: [], claim, 1 + len(names), work, allowance(), {})[1]
