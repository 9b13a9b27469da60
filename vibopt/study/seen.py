"""What studies see of an answer to a job of any kind: what it chose, what it measured, and what it made best."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from vibopt.answer.answer import Answer
from vibopt.answer.entry import Entry, Value
from vibopt.balancing import is_rotor
from vibopt.errors import InputError
from vibopt.jobs import is_open, is_scene, kept_plan
from vibopt.verify.measured_goal import MEASURED

if TYPE_CHECKING:
    from vibopt.jobs import Job
    from vibopt.values.fact_at import FactAt

GOOD = ("optimal", "feasible", "met")
"""Answers with a design, or with limits that hold."""
_CHOOSING = ("shelf", "most_weights", "split", "forbidden")
NOTHING = ("infeasible", "unbounded", "check_failed")
"""Answers to balancing jobs that fit nothing."""


def shown_value(fact: FactAt, value: float) -> Entry:
    """Another value of a fact, as the file has it."""
    return Entry(value, fact.dimension, fact.unit, amplitude=fact.amplitude)


def goal_of(job: Job, answer: Answer[Any]) -> Entry | None:
    """What was made best; None where nothing was."""
    empty = answer.goal is None or (not is_scene(job) and answer.status in NOTHING)
    return None if empty or answer.goal is None else answer.goal[1]


def goal_word(job: Job) -> str:
    """What is made best, or was where nothing is left to choose, as the file says it; "" where nothing is."""
    if not is_scene(job):
        return job.aim
    became = measured_goal(job)
    return job.goal.name if job.goal is not None else job.measures[became].response if became else ""


def measured_goal(job: Job) -> str:
    """Name of the measure that a goal became beside limits, where nothing is left to choose; "" where none did."""
    judged = is_scene(job) and job.is_analysis and job.limits
    return next((name for name in MEASURED.values() if name in job.measures), "") if judged and is_scene(job) else ""


def entries_of(job: Job, answer: Answer[Any]) -> Mapping[str, Value]:
    """What a balancing job may have chosen or measured; no coefficients of a measured rotor, which may be thousands."""
    return answer.plan.entries() if is_rotor(job) else answer.entries()


def chosen(job: Job, answer: Answer[Any], entries: Mapping[str, Value] | None = None) -> dict[str, Value]:
    """What the answer chose, by path: places and parts first, then numbers; `entries` are those of the answer."""
    if is_scene(job):
        places: dict[str, Value] = dict(answer.places)
        return places | {path: variable.value for path, variable in answer.variables.items() if ".part." not in path}
    if answer.status in NOTHING:
        return {}
    known = entries_of(job, answer) if entries is None else entries
    return {path: known[path] for path in job.choices if path in known}


def results(job: Job, answer: Answer[Any], entries: Mapping[str, Value] | None = None) -> dict[str, Entry]:
    """What was measured beside the limits: of a balancing job what is left; of a scene, where there are none, all."""
    if is_scene(job):
        return {f"measures.{name}": row.value for name, row in answer.measures.items()} if is_measured(job) else {}
    if answer.status in NOTHING:
        return {}
    known = entries_of(job, answer) if entries is None else entries
    return {
        path: one
        for path, one in known.items()
        if path.startswith(job.results)
        if isinstance(one, Entry) and one.dimension != "angle" and not (path.endswith(".found") or ".at " in path)
    }


def is_measured(job: Job) -> bool:
    """Whether a scene only measures: nothing is chosen, and nothing is limited."""
    return is_scene(job) and job.is_analysis and not job.limits and bool(job.measures)


def reason(answer: Answer[Any]) -> str:
    """Why an answer cannot be used; "" where it can."""
    if answer.exit_code == 0 or answer.reason or answer.conflict is None:
        return answer.reason
    said = answer.conflict.said()
    return f"{said[:1].lower()}{said[1:]}"


def chosen_from(job: Job, path: str) -> bool:
    """Whether a path of the file of a balancing job says only from what its weights are chosen."""
    steps = path.split(".")
    if is_scene(job) or len(steps) < 3 or steps[0] != "planes":
        return False
    open_here = any(choice.startswith(f"planes.{steps[1]}.") for choice in job.choices)
    return open_here and steps[2] in ("weight", "unbalance", "keep", *_CHOOSING)


def kept(job: Job, answer: Answer[Any]) -> Job:
    """The same job with what its answer chose as facts; InputError where it chose nothing."""
    if not is_open(job):
        return job
    if not is_scene(job):
        return kept_plan(job, answer)
    if not (answer.variables or answer.places):
        raise InputError(f"{job.name}: there is no design to keep: {answer.status}. Solve the scene first.")
    from vibopt.study.freeze import bought, frozen

    return bought(frozen(answer.scene, answer.x), answer.scene)
