"""Any job as a program in the open."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from vibopt.posed.posed import Posed, refused

if TYPE_CHECKING:
    from vibopt.balancing.engine.engine_job import EngineJob
    from vibopt.balancing.known.known_job import KnownJob
    from vibopt.balancing.rotor_job import RotorJob
    from vibopt.posed.weights import Named
    from vibopt.scene.scene import Scene


def posed(job: Any) -> Posed:
    """A job from `vibopt.read` (or a scene made in Python) as a program for cvxpy and for CasADi."""
    make = _KINDS.get(type(job).__name__)
    if make is None:
        raise TypeError(f"{type(job).__name__} is no job. Take one from vibopt.read, or make a scene.")
    return make(job)


def _of_weights(name: str, named: Named) -> Posed:
    from vibopt.posed import weights

    rough = named.not_smooth()
    return Posed(name, rough or named.not_convex(), rough, lambda: weights.convex(named), lambda: weights.smooth(named))


def _rotor(job: RotorJob) -> Posed:
    if not job.runs or job.is_advice:
        return refused(job.name, "no trial run or coefficient says what a weight does")
    if not job.has_phase:
        return refused(
            job.name, "amplitudes without phase leave several rotors possible, each with a program of its own"
        )
    if job.asks_shares:
        return refused(job.name, "a limit asks for a probability, which rotors that are drawn tell")
    return _of_weights(job.name, named_rotor(job))


def named_rotor(job: RotorJob) -> Named:
    """The question of a measured rotor, with scatter where the goal is robust, in the words of its file."""
    import numpy as np

    from vibopt.balancing.rotor_question import rows_of
    from vibopt.balancing.solve_rotor import asked_of
    from vibopt.posed.weights import Named

    of, _, _, whole = asked_of(job)
    job, question = of.job, whole.question
    limits = []
    for limit in job.residual_limits:
        own = np.array(rows_of(job, limit.sensor, limit.speed))
        times = question.n_readings // whole.n_rows if job.goal.robust == "worst" else 1
        rows = np.concatenate([own + k * whole.n_rows for k in range(times)])
        limits.append((f"limits.{limit.name}", rows, np.full(len(rows), limit.at_most)))
    caps = []
    for index, plane in enumerate(job.planes):
        own_limits = [limit for limit in job.correction_limits if limit.plane == index and limit.at_most <= plane.cap]
        least = min(own_limits, key=lambda one: one.at_most, default=None)
        caps.append(f"limits.{least.name}" if least is not None else f"planes.{plane.name}.{_cap_word(plane.kind)}")
    total = next((f"limits.{limit.name}" for limit in job.correction_limits if limit.plane is None), "limits.total")
    return Named.of(question, tuple(f"planes.{plane.name}" for plane in job.planes), limits, caps, total)


def _cap_word(kind: str) -> str:
    return "unbalance" if kind == "unbalance" else "weight"


def _known(job: KnownJob) -> Posed:
    if not job.planes or job.goal is None:
        return refused(job.name, "nothing is to be corrected")
    return _of_weights(job.name, named_known(job))


def named_known(job: KnownJob) -> Named:
    """The question of known masses in the words of its file; complete balance where no limit says how good."""
    import numpy as np

    from vibopt.balancing.known.correct import bounded_rows, complete, pose
    from vibopt.posed.weights import Named

    question = complete(job, pose(job).question)
    limits, caps = [], [f"planes.{one.name}.weight" for one in job.planes]
    total = "limits.total"
    bare = pose(replace(job, limits={})).question
    for name, table in job.limits.items():
        own = pose(replace(job, limits={name: table})).question
        bounded, size = bounded_rows(job, table)
        if bounded:
            limits.append((f"limits.{name}", np.array(bounded), np.full(len(bounded), table.bound / size)))
        for plane in np.flatnonzero(own.caps < bare.caps).tolist():
            caps[plane] = f"limits.{name}"
        total = f"limits.{name}" if np.isfinite(own.total_cap) else total
    if not limits and np.isfinite(question.limits).any():
        rows = np.flatnonzero(np.isfinite(question.limits))
        limits.append(("complete balance", rows, question.limits[rows]))
    return Named.of(question, tuple(f"planes.{one.name}" for one in job.planes), limits, caps, total)


def _engine(job: EngineJob) -> Posed:
    from vibopt.balancing.engine.choose_weights import chosen

    if job.is_search:
        return refused(job.name, "the angles of the cranks are chosen from a list, which is neither convex nor smooth")
    if job.goal is None or not chosen(job):
        return refused(job.name, "nothing is to be chosen")
    return _of_weights(job.name, named_engine(job))


def named_engine(job: EngineJob) -> Named:
    """The shares and weights of an engine whose cranks are given; all orders together at every degree of a turn."""
    import numpy as np

    from vibopt.balancing.engine.choose_weights import chosen, pose
    from vibopt.balancing.engine.shaking import arms
    from vibopt.posed.weights import Named

    question, own = pose(job, arms(job, tuple(crank or 0.0 for crank in job.cranks)))
    limits = []
    for number, name in enumerate(job.limits, start=1):
        rows = np.flatnonzero(own == number)
        limits.append((f"limits.{name}", rows, question.limits[rows]))
    return Named.of(question, chosen(job), limits, [f"{path}.unbalance" for path in chosen(job)], "limits.total")


def _scene(scene: Scene) -> Posed:
    from vibopt.posed.posed_scene import posed_scene

    return posed_scene(scene)


_KINDS: dict[str, Callable[[Any], Posed]] = {
    "Scene": _scene, "RotorJob": _rotor, "KnownJob": _known, "EngineJob": _engine,
}  # fmt: skip
