"""Any job as a program in the open."""

from __future__ import annotations

from collections.abc import Callable, Container, Mapping
from typing import TYPE_CHECKING, Any

from vibopt.posed.posed import Posed, refused
from vibopt.records import replace

if TYPE_CHECKING:
    from vibopt.balancing.engine.engine_job import EngineJob
    from vibopt.balancing.known.known_job import KnownJob
    from vibopt.balancing.question import Question
    from vibopt.balancing.rates import Bounding
    from vibopt.balancing.rotor_job import RotorJob
    from vibopt.posed.weights import Named
    from vibopt.scene.scene import Scene


BALANCED = "complete balance"
"""Name of what is asked of known masses where no limit says how good."""


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
    from vibopt.balancing.rates import own_caps
    from vibopt.balancing.rotor_limits import bounds_of
    from vibopt.balancing.solve_rotor import asked_of

    of, _, _, whole = asked_of(job)
    named = _named(whole.question, _paths(of.job), bounds_of(of.job, whole), own_caps(of.job.planes))
    rows, readings = named.question.n_readings, [of.job.row_name(row) for row in range(of.job.n_rows)]
    drawn = [f"{reading}, rotor {k + 1}" for k in range(rows // len(readings) - 1) for reading in readings]
    return replace(named, readings=(*readings, *drawn), pairs=tuple(f"pairs.{name}" for name, *_ in of.job.pairs))


def _paths(job: RotorJob | KnownJob) -> tuple[str, ...]:
    return tuple(f"planes.{plane.name}" for plane in job.planes)


def _named(question: Question, planes: tuple[str, ...], known: Mapping[str, Bounding], own: Container[str]) -> Named:
    """A question with the paths of what bounds it, names of limits but for its `own`; of several caps the tightest."""
    import numpy as np

    from vibopt.posed.weights import Named

    paths = {name if name in own else f"limits.{name}": one for name, one in known.items()}
    limits = [(path, np.array(one.rows), np.full(len(one.rows), one.bound)) for path, one in paths.items() if one.rows]
    caps = []
    for k, plane in enumerate(planes):
        tightest = [(one.bound, path in own, path) for path, one in paths.items() if one.plane == k]
        caps.append(min(tightest, default=(0.0, True, f"{plane}.weight"))[2])
    total = next((path for path, one in paths.items() if not one.rows and one.plane is None), "limits.total")
    return Named.of(question, planes, limits, caps, total)


def _known(job: KnownJob) -> Posed:
    if not job.planes or job.goal is None:
        return refused(job.name, "nothing is to be corrected")
    return _of_weights(job.name, named_known(job))


def named_known(job: KnownJob) -> Named:
    """The question of known masses in the words of its file; complete balance where no limit says how good."""
    import numpy as np

    from vibopt.balancing.known.correct import bounds_of, complete, pose
    from vibopt.balancing.rates import Bounding, own_caps

    question, known, own = complete(job, pose(job).question), bounds_of(job), {*own_caps(job.planes), BALANCED}
    if not any(one.rows for one in known.values()) and np.isfinite(question.limits).any():
        known[BALANCED] = Bounding(0.0, rows=np.flatnonzero(np.isfinite(question.limits)).tolist())
    return _named(question, _paths(job), known, own)


def _engine(job: EngineJob) -> Posed:
    from vibopt.balancing.engine.choose_weights import chosen

    if job.is_search:
        return refused(job.name, "the angles of the cranks are chosen from a list, which is neither convex nor smooth")
    if job.goal is None or not chosen(job):
        return refused(job.name, "nothing is to be chosen")
    return _of_weights(job.name, named_engine(job))


def named_engine(job: EngineJob) -> Named:
    """The shares and weights of an engine whose cranks are given; all orders together at every degree of a turn."""
    from vibopt.balancing.engine.choose_weights import bounds_of, chosen, pose
    from vibopt.balancing.engine.shaking import arms

    question, own = pose(job, arms(job, tuple(crank or 0.0 for crank in job.cranks)))
    known = bounds_of(job, question, own)
    return _named(question, chosen(job), known, known.keys() - job.limits.keys())


def _scene(scene: Scene) -> Posed:
    from vibopt.posed.posed_scene import posed_scene

    return posed_scene(scene)


_KINDS: dict[str, Callable[[Any], Posed]] = {
    "Scene": _scene, "RotorJob": _rotor, "KnownJob": _known, "EngineJob": _engine,
}  # fmt: skip
