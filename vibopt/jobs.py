"""Which kind of job a problem file is, and its answer: the one place where scenes and balancing jobs part ways."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, TypeAlias, overload

from vibopt.errors import InputError
from vibopt.files.reading import shown_name
from vibopt.scene.document import changed, parsed, placed, text_of
from vibopt.scene.locate import located
from vibopt.scene.mistakes import Mistakes
from vibopt.work import answering, each_answer_within

if TYPE_CHECKING:
    from typing_extensions import TypeIs

    from vibopt.balancing.engine.job import EngineJob
    from vibopt.balancing.job import RotorJob
    from vibopt.balancing.known.job import KnownJob
    from vibopt.balancing.outcome import Outcome
    from vibopt.balancing.plan import Plan
    from vibopt.design.design import Design
    from vibopt.scene.scene import Scene

    BalancingJob: TypeAlias = RotorJob | KnownJob | EngineJob
    Job: TypeAlias = Scene | BalancingJob
    Solution: TypeAlias = Plan | Outcome
    Answer: TypeAlias = Design | Solution

Progress = Callable[[str, float], None]
SCENE, ROTOR, KNOWN, ENGINE = "scene", "rotor", "known", "engine"
_SCENE_TABLES = ("bodies", "bases", "structures", "absorbers", "links", "excitations")
_ROTOR_TABLES = ("planes", "runs", "readings", "influence", "sensors", "conventions", "quality", "scatter", "rotor")
NO_NAME = "No file is named: the name is empty. Name a problem file (.toml)."


def kind_of(document: Mapping[str, Any]) -> str:
    """SCENE, ROTOR, KNOWN or ENGINE, told by the tables at the top level."""
    if "masses" in document or "shaft" in document:
        return KNOWN
    if "cylinders" in document or "engine" in document:
        return ENGINE
    return ROTOR if any(key in document for key in _ROTOR_TABLES) else SCENE


def open_job(path: str | FilePath, changes: Mapping[str, Any] | None = None) -> Job:
    """What a problem file asks: a scene, a measured rotor, known masses on a shaft, or an engine.

    Parameters
    ----------
    path
        A TOML file in UTF-8; a CSV file that it names lies beside it.
    changes
        Values to replace, by path: {"limits.left.at_most": "60 g"}; entries of a list by number, "runs.2.speed".

    Raises
    ------
    InputError
        All mistakes at once, with lines.
    """
    if not str(path):
        raise InputError(NO_NAME)
    file = FilePath(path)
    text, name = text_of(file), shown_name(file.name)
    document = placed(parsed(text, name), file.parent)
    job = _read(document, Mistakes(name, located(text)), file.parent)
    if not changes:
        return job
    return _read(changed(document, changes), Mistakes(name, None), file.parent)


def _read(document: Mapping[str, Any], mistakes: Mistakes, folder: FilePath) -> Job:
    kind = kind_of(document)
    if kind == SCENE:
        from vibopt.scene.read import from_dict

        return from_dict(document, name=mistakes.name, locator=mistakes.locator)
    _refuse_mixture(document, mistakes)
    if kind == KNOWN:
        from vibopt.balancing.known import read_known

        return read_known(document, mistakes)
    if kind == ENGINE:
        from vibopt.balancing.engine import read_engine

        return read_engine(document, mistakes)
    from vibopt.balancing.rotor import read_rotor

    return read_rotor(document, mistakes, folder)


def _refuse_mixture(document: Mapping[str, Any], mistakes: Mistakes) -> None:
    """A balancing job never mixes with bodies and links."""
    mixed = [key for key in document if key in _SCENE_TABLES]
    if mixed:
        listed = ", ".join(f"[{key}]" for key in mixed)
        mistakes.add((mixed[0],), f"a balancing job does not mix with {listed}. Put each into a file of its own.")
        mistakes.raise_any()


@overload
def answer(
    job: Scene, *, method: str | None = None, progress: Progress | None = None, time_limit: float | None = None
) -> Design: ...
@overload
def answer(
    job: RotorJob, *, method: str | None = None, progress: Progress | None = None, time_limit: float | None = None
) -> Plan: ...
@overload
def answer(
    job: KnownJob | EngineJob,
    *,
    method: str | None = None,
    progress: Progress | None = None,
    time_limit: float | None = None,
) -> Outcome: ...
@overload
def answer(
    job: Job, *, method: str | None = None, progress: Progress | None = None, time_limit: float | None = None
) -> Answer: ...
def answer(
    job: Job, *, method: str | None = None, progress: Progress | None = None, time_limit: float | None = None
) -> Answer:
    """The answer to any job, with its evidence.

    Parameters
    ----------
    job
        From `open_job`, or a scene made in Python.
    method
        Forces a method of a scene; a balancing job has no choice of methods.
    progress
        Called with what is being done and the part that is finished.
    time_limit
        Seconds after which every search ends with what it has, and the claim says so.  Without it no clock is
        read: the same job has the same answer on any machine, idle or busy.

    Raises
    ------
    InputError
        A method named for a balancing job, or one that does not take the scene.
    """
    with each_answer_within(time_limit):
        if is_scene(job):
            from vibopt.solve import solve

            return solve(job, method=method, progress=progress)
        if method is not None:
            raise InputError(
                f"{job.name}: --method is not supported for balancing jobs: goal and limits decide the method."
            )
        return balanced(job)


def balanced(job: BalancingJob, *, thorough: bool = False) -> Solution:
    """The answer to a balancing job; `thorough` computes every price, whatever the work."""
    with answering() as limit:
        found = _balanced(job, thorough)
    ended = "" if limit is None or found.proven else limit.words
    return replace(found, claim=found.claim + ended) if ended else found


def plain_answer(found: Answer) -> dict[str, Any]:
    """The answer as plain data, as `solve --json` prints it."""
    if is_design(found):
        from vibopt.design.jsonable import as_json

        return as_json(found)
    return found.to_json()


def _balanced(job: BalancingJob, thorough: bool) -> Solution:
    if is_known(job):
        from vibopt.balancing.known import solve_known

        return solve_known(job, thorough=thorough)
    if is_engine(job):
        from vibopt.balancing.engine import solve_engine

        return solve_engine(job, thorough=thorough)
    if is_rotor(job):
        from vibopt.balancing.solve_rotor import solve_job

        return solve_job(job, thorough=thorough)
    raise TypeError(f"{type(job).__name__} is no job. Take one from open_job, or make a Scene.")


def is_scene(job: object) -> TypeIs[Scene]:
    """Told by the name of the class, so that nothing is loaded for it; the same below."""
    return type(job).__name__ == "Scene"


def is_rotor(job: object) -> TypeIs[RotorJob]:
    return type(job).__name__ == "RotorJob"


def is_known(job: object) -> TypeIs[KnownJob]:
    return type(job).__name__ == "KnownJob"


def is_engine(job: object) -> TypeIs[EngineJob]:
    return type(job).__name__ == "EngineJob"


def is_design(answer: object) -> TypeIs[Design]:
    return type(answer).__name__ == "Design"


def is_plan(answer: object) -> TypeIs[Plan]:
    return type(answer).__name__ == "Plan"


def scene_only(job: Job, verb: str, instead: str = "") -> Scene:
    """The job, if it is a scene; InputError with the way out where a verb makes no sense for balancing jobs yet."""
    if is_scene(job):
        return job
    way = f" {instead}" if instead else ""
    raise InputError(f"{job.name}: {verb} is not supported for balancing jobs yet.{way}")


read, solve = open_job, answer
"""As `vibopt.read` and `vibopt.solve`."""
