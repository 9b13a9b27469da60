"""Which kind of job a problem file is, and what studies and commands ask of it: the one place where kinds part ways.

Of a job they know its name, title and document, the facts that may be varied, the same job with some values changed,
whether anything is chosen, and its answer.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import nullcontext
from math import isclose
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar, cast

from vibopt.answer.answer import EMPTY, Answer
from vibopt.balancing import ENGINE, KNOWN, ROTOR, is_engine, is_known, is_rotor
from vibopt.document.locate import located
from vibopt.document.mistakes import Mistakes, check_names
from vibopt.document.toml_reading import COEFFICIENTS, FileText, changed, inside, parsed, placed, text_of
from vibopt.errors import InputError
from vibopt.files.reading import FileFault, file_of, shown_name
from vibopt.records import replace
from vibopt.values.part_of_now import IN_PERCENT, as_read, part_in, two_ways
from vibopt.work import answering, each_answer_within, metered

if TYPE_CHECKING:
    from typing_extensions import TypeIs

    from vibopt.balancing import BalancingJob
    from vibopt.balancing.coefficients import Saved
    from vibopt.balancing.engine.engine_job import EngineJob
    from vibopt.scene.scene import Scene
    from vibopt.values.fact_at import FactAt

    Job: TypeAlias = Scene | BalancingJob

J = TypeVar("J", bound="Job")
B = TypeVar("B", bound="BalancingJob")
Progress = Callable[[str, float], None]
POSED = ("cvxpy", "ipopt")
"""Methods that solve the program in the open (`vibopt.posed`)."""
SCENE = "scene"
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
    file = path if isinstance(path, FilePath) else FilePath(path)
    text, name = text_of(file), shown_name(file.name)
    document = placed(parsed(text, name), file.parent)
    job = _whole(document, Mistakes(name, located(text)))
    return with_changes(job, changes) if changes else job


def scenarios_of(job: Job) -> dict[str, dict[str, Any]]:
    """The changes by path of each `[scenarios.NAME]` of a file."""
    return {name: dict(_flat((), table)) for name, table in job.document.get("scenarios", {}).items()}


def _flat(steps: tuple[str, ...], table: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Values by path; what is said by keys of its own, as a range, is one value."""
    for key, value in table.items():
        here = (*steps, str(key))
        if isinstance(value, Mapping) and not {"from", "to", "one_of", "value"} & value.keys():
            yield from _flat(here, value)
        else:
            yield ".".join(here), value


def _whole(document: Mapping[str, Any], mistakes: Mistakes) -> Job:
    """The job of a document with its scenarios, each of which has been tried."""
    if "scenarios" not in document:
        return of_document(document, mistakes)
    _check_scenarios(document, mistakes)
    return _with_scenarios(of_document(document, mistakes), Mistakes(mistakes.name, mistakes.locator))


def _with_scenarios(job: J, mistakes: Mistakes) -> J:
    """The job with a note that its scenarios are no part of the answer, each of which has been tried."""
    for name, changes in scenarios_of(job).items():
        path = ("scenarios", name)
        try:
            made = with_changes(job, changes)
        except InputError as error:
            for message in error.messages:
                mistakes.add(path, f"scenarios.{name}: {message.removeprefix(f'{job.name}: ')}")
            continue
        if is_same(job, made, changes):
            mistakes.add(path, f"scenarios.{name} changes nothing: the file says all of it already. Leave it out.")
    mistakes.raise_any()
    names = ", ".join(scenarios_of(job))
    note = f"Scenarios of the file, {names}, are no part of this answer: --scenario NAME, or compare FILE --scenarios."
    whole: Any = job
    return cast(J, replace(whole, notes=(*whole.notes, note)))


def is_same(job: Job, made: Job, changes: Mapping[str, Any]) -> bool:
    """Whether changes change nothing, or of numbers alone say the same ones in other units: "0.3 t" for "300 kg"."""
    if made.document == job.document:
        return True
    before, after = ({fact.path: fact for fact in facts(of)} for of in (job, made))
    numbers = {*before, *(fact_at.place for fact_at in before.values())}
    return changes.keys() <= numbers and before.keys() == after.keys() and all(
        isclose(fact_at.value, after[path].value, rel_tol=1e-12) and fact_at.dimension == after[path].dimension
        for path, fact_at in before.items()
    )  # fmt: skip


def _check_scenarios(document: Mapping[str, Any], mistakes: Mistakes) -> None:
    """Whether every scenario is a table of changes."""
    given = document["scenarios"]
    if not isinstance(given, Mapping):
        mistakes.value(("scenarios",), given, "is not a table. Write [scenarios.NAME] and changes below it.")
    for name, table in given.items() if isinstance(given, Mapping) else ():
        if not isinstance(table, Mapping) or not table:
            mistakes.add(
                ("scenarios", name),
                f"scenarios.{name} changes nothing. Write changes by path below it: "
                '"limits.start_up.at_most" = "25 mm".',
            )
    mistakes.raise_any()


def _unnamed(document: Mapping[str, Any]) -> str:
    """What stands in front of the messages of a job without a name."""
    return SCENE if kind_of(document) == SCENE else "job"


def from_text(text: str, name: str = "") -> Job:
    """What a TOML text asks; `name` stands in front of each message."""
    document = parsed(text, name or SCENE)
    return _whole(document, Mistakes(name or _unnamed(document), located(text)))


def from_dict(document: Mapping[str, Any], name: str = "") -> Job:
    """What a document already parsed asks; the keys are those of the file."""
    return _whole(document, Mistakes(name or _unnamed(document), None))


def with_changes(job: J, changes: Mapping[str, Any]) -> J:
    """The same job with some values replaced, by path: {"limits.start_up.at_most": "8 mm"}.

    Part of a text has a path of its own: {"runs.2.readings.a.angle": "125 deg"}.

    Raises
    ------
    InputError
        A path that the job does not have, or a value that does not fit there.
    """
    document, now = job.document, job
    aside = next((path for path in changes if path.partition(".")[0] == "scenarios"), None)
    if aside is not None:
        way = "Change the scenario in the file, or give the path behind its name."
        raise InputError(f"{job.name}: {aside} is part of a scenario, and of no answer without it. {way}")
    read, notes = resolved(job, changes)
    written: set[str] = set()
    for path, value in read.items():
        part = None if inside(document, path) is not None else part_at(now, path)
        if part is not None and part.place in written:  # the text of its other numbers is not what it was
            new = of_document(document, Mistakes(job.name, None)) if is_scene(job) else _half(now, document)
            now = cast(J, new)
            part = part_at(now, path)
        document = changed(document, {path: value} if part is None else {part.place: part.around.format(value)})
        if (document.get("goal") or {}).get("find_all") == path and not isinstance(value, Mapping):
            document = {key: one for key, one in document.items() if key != "goal"}  # found, and measured there
        written |= {part.place} if part is not None else set()
    if (is_scene(job) or is_engine(job)) and job.goal is not None and _nothing_open(job, read):
        document = _measuring(job, document)
    made: Any = of_document(document, Mistakes(job.name, None), job)
    return cast(J, replace(made, notes=(*made.notes, *notes)) if notes else made)


def _half(job: Any, document: Mapping[str, Any]) -> Any:
    """A balancing job with the numbers of a document that is not whole yet, and may be a mistake."""
    return replace(job, document=document)


def _nothing_open(job: Scene | EngineJob, changes: Mapping[str, Any]) -> bool:
    """Whether some changes by path give a value to every choice of a job that has any."""
    values = {
        path for path, value in changes.items()
        if value != "choose" and not (isinstance(value, Mapping) and {"from", "to", "one_of"} & value.keys())
    }  # fmt: skip
    mine = {variable.path for variable in job.variables} if is_scene(job) else {*job.open_at}
    asks = any(path.startswith("goal.") for path in changes) or (is_scene(job) and job.asked is not None)
    return bool(mine) and mine <= values and not asks


def _measuring(job: Scene | EngineJob, document: Mapping[str, Any]) -> dict[str, Any]:
    """A document of which nothing is open any more: what was made best is measured."""
    if not is_scene(job):
        from vibopt.balancing.decided import with_goal_measured

        return with_goal_measured(document)
    from vibopt.verify.measured_goal import measure_goal

    measured = dict(document)
    measure_goal(job, measured)
    return measured


def resolved(job: Job, changes: Mapping[str, Any]) -> tuple[dict[str, Any], tuple[str, ...]]:
    """The changes with "-20 %" of a number as the number (`vibopt.values.part_of_now`), and how that was read.

    Raises
    ------
    InputError
        A part of what has no value yet, or one without a sign, which may be meant in two ways.
    """
    read, notes = dict(changes), []
    for path, value in changes.items():
        part = part_in(value)
        if part is None:
            continue
        chosen = _dimension_of_chosen(job, path)
        if chosen and (part.sign or chosen not in (IN_PERCENT, "level")):
            raise InputError(
                f'{job.name}: {path} = "{value}" is a part of a number, and this one is chosen from a range. Write a '
                f"value, or move an end of the range: --set {path}.to=..."
            )
        fact = next((one for one in facts(job) if one.path in (path, f"{path}.value")), None)
        if fact is None or fact.dimension == "level" or (fact.dimension == IN_PERCENT and not part.sign):
            continue
        if not part.sign:
            raise InputError(f'{job.name}: {path} = "{value}" {two_ways(value, fact, part.share)}')
        read[path] = fact.now(part.times)
        notes.append(f"{path}: {as_read(value, fact, part)}")
    return read, tuple(notes)


def _dimension_of_chosen(job: Job, path: str) -> str:
    """What a number of a machine is that is chosen from a range; "" of any other."""
    chosen = job.variables if is_scene(job) else ()
    return next((one.dimension for one in chosen if one.path == path and one.values is None), "")


def part_at(job: Job, path: str) -> FactAt | None:
    """The number at a path that is a part of a text."""
    if is_scene(job):
        return next((fact for fact in facts(job) if fact.place and fact.path == path), None)
    from vibopt.balancing.paths import part_in

    return part_in(job.document, path)


def facts(job: Job) -> Iterator[FactAt]:
    """Every number of the job that may be varied."""
    if is_scene(job):
        from vibopt.scene.facts import facts as of_scene

        return of_scene(job)
    from vibopt.balancing.paths import facts_of

    return facts_of(job.document)


def fact_at(job: Job, path: str) -> FactAt:
    """The fact at a path; InputError where there is none, with near ones."""
    if is_scene(job):
        from vibopt.scene.facts import fact_at as of_scene

        return of_scene(job, path)
    from vibopt.balancing.paths import fact_in

    return fact_in(job.document, path)


def is_open(job: Job) -> bool:
    """Whether anything is to be chosen."""
    if is_scene(job):
        from vibopt.scene.open_places import is_open as of_scene

        return of_scene(job)
    return bool(job.choices)


def asks_shares(job: Job) -> tuple[str, ...]:
    """Limits with a probability, which machines that are drawn tell."""
    if is_rotor(job):
        return job.asks_shares
    limits = job.limits.items() if is_scene(job) else ()
    return tuple(name for name, limit in limits if limit.with_probability is not None)


def kept_plan(job: B, answer: Answer[Any]) -> B:
    """The same job with what its answer chose as facts: solved again it is an analysis that measures that answer.

    Raises
    ------
    InputError
        The answer has chosen nothing.
    """
    if is_open(job) and answer.status in EMPTY:
        raise InputError(f"{job.name}: there is no design to keep: {answer.status}. Solve the file first.")
    if not is_open(job):
        return job
    from vibopt.balancing import decided as plans

    document = plans.of_engine(job, answer) if is_engine(job) else plans.of_planes(cast(Any, job), answer)
    return cast(B, of_document(document, Mistakes(job.name, None)))


def noun_of(job: Job) -> str:
    """What a job is about: "a measured rotor"."""
    return NOUNS[job.kind]


def of_document(document: Mapping[str, Any], mistakes: Mistakes, like: Job | None = None) -> Job:
    """The job of a document; `like` is one whose document this is but for some values."""
    if like is None:
        check_names(document, mistakes)
        mistakes.raise_any()
    kind = kind_of(document)
    if kind == SCENE:
        from vibopt.scene.read import from_dict

        return from_dict(document, name=mistakes.name, locator=mistakes.locator, like=cast(Any, like))
    _refuse_mixture(document, mistakes)
    if kind == KNOWN:
        from vibopt.balancing.known import read_known

        return read_known(document, mistakes)
    if kind == ENGINE:
        from vibopt.balancing.engine import read_engine

        return read_engine(document, mistakes)
    from vibopt.balancing.read_rotor import read_rotor

    file = document.get("readings")
    folder = file.folder if isinstance(file, FileText) else None
    known = like if like is not None and is_rotor(like) else None
    return read_rotor(document, mistakes, folder, lambda: _coefficients(document, mistakes), known)


def _coefficients(document: Mapping[str, Any], mistakes: Mistakes) -> Saved | None:
    """The file of coefficients that a measured rotor names; None where it names none, or where it cannot be read."""
    given = document.get("influence")
    if not isinstance(given, str):
        return None
    from vibopt.balancing.coefficients import Saved

    try:
        file = file_of(given)
        text, name = text_of(file, COEFFICIENTS), shown_name(file.name)
        return Saved(parsed(text, name, COEFFICIENTS), Mistakes(name, located(text)))
    except FileFault as fault:
        mistakes.value(("influence",), given, fault.text)
    except InputError as error:
        mistakes.add(("influence",), str(error))
    mistakes.raise_any()  # without it runs would seem to be missing
    return None


def _refuse_mixture(document: Mapping[str, Any], mistakes: Mistakes) -> None:
    """A balancing job never mixes with bodies and links."""
    from vibopt.devices import FAMILIES

    mixed = [key for key in document if key in FAMILIES or key == "excitations"]
    if mixed:
        listed = ", ".join(f"[{key}]" for key in mixed)
        mistakes.add((mixed[0],), f"a balancing job does not mix with {listed}. Put each into a file of its own.")
        mistakes.raise_any()


def answer(
    job: J,
    *,
    method: str | None = None,
    progress: Progress | None = None,
    time_limit: float | None = None,
    explain: bool = True,
    brief: bool = False,
) -> Answer[J]:
    """The answer to any job, with its evidence.

    Parameters
    ----------
    job
        From `open_job`, or a scene made in Python.
    method
        Forces a method of a scene; a balancing job knows its own, "cvxpy" and "ipopt".
    progress
        Called with what is being done and the part that is finished.
    time_limit
        Seconds after which every search ends with what it has, and the claim says so.  Without it no clock is
        read: the same job has the same answer on any machine, idle or busy.
    explain
        Whether what clashes where nothing holds is found out too.
    brief
        Without words that no point of a sweep shows.

    Raises
    ------
    InputError
        A method that does not take the job.
    """
    with each_answer_within(time_limit):
        by = method_of(job, method)
        if is_scene(job):
            from vibopt.solve import solve

            return cast("Answer[J]", solve(job, method=by, progress=progress, explain=explain, brief=brief))
        return cast("Answer[J]", balanced(job, explain=explain, method=by))


def method_of(job: Job, method: str | None) -> Any:
    """A method that is asked for by its name, for a job that it may answer: as its name where a job knows it by that.

    Raises
    ------
    InputError
        No such method, or a job in which nothing is chosen by one.
    """
    if method is None:
        return None
    if is_scene(job):
        from vibopt.posed.posed_scene import METHODS
        from vibopt.solve.by_name import called

        by = METHODS[method]() if method in POSED else called(method)
    elif method not in POSED:
        raise InputError(
            f"{job.name}: --method {method}: goal and limits decide the method of a balancing job. Leave it out, "
            f"or write {' or '.join(POSED)}."
        )
    if why := _without_method(job):
        raise InputError(f"{job.name}: --method {method}: {why}, whatever the method. Leave --method out.")
    return by if is_scene(job) else method


def _without_method(job: Job) -> str:
    """Why no method is asked; "" where one searches for what is chosen."""
    if is_scene(job) and job.find_all is not None:
        return "find_all answers with the ends of intervals, which are found one by one"
    if not is_open(job):
        return "nothing is chosen, and what is asked is measured"
    if is_scene(job) and not job.variables:
        return "places alone are chosen, and each is measured"
    return ""


def balanced(
    job: BalancingJob, *, thorough: bool = False, explain: bool = True, method: str | None = None
) -> Answer[Any]:
    """The answer to a balancing job; `thorough` says what clashes, whatever the work; without `explain` none."""
    from vibopt.balancing.optimisers import answers_alone

    with answering() as limit, metered() as meter, nullcontext() if explain else answers_alone():
        answer = replace(_balanced(job, thorough, method), work=meter.done)
    return answer if limit is None or answer.proven else replace(answer, claim=limit.added_to(answer.claim))


def reasons(job: BalancingJob, answer: Answer[Any]) -> tuple[Any, Any]:
    """Why a balancing job has its model (name, words) and its method (name, whether it answered, why)."""
    from vibopt.balancing import explained as why

    if is_rotor(job):
        return why.of_rotor(job, answer)
    return why.of_known(job, answer) if is_known(job) else why.of_engine(job, answer)


def _balanced(job: BalancingJob, thorough: bool, method: str | None) -> Answer[Any]:
    if is_known(job):
        from vibopt.balancing.known import solve_known

        return solve_known(job, thorough=thorough, **_by(job, method))
    if is_engine(job):
        from vibopt.balancing.engine import solve_engine

        return solve_engine(job, thorough=thorough, **_by(job, method))
    if is_rotor(job):
        from vibopt.balancing.solve_rotor import solve_job

        return solve_job(job, thorough=thorough, **_by(job, method))
    raise TypeError(f"{type(job).__name__} is no job. Take one from vibopt.read, or make a scene.")


def _by(job: BalancingJob, method: str | None) -> dict[str, Any]:
    """The solver of a program in the open, where a method names one."""
    if method is None:
        return {}
    from vibopt.posed.methods import solver_of

    return {"solver": solver_of(job, method)}


def is_scene(job: object) -> TypeIs[Scene]:
    """Whether it is a machine put together of bodies, links and absorbers."""
    return getattr(job, "kind", "") == SCENE


NOUNS = {SCENE: "a machine", ROTOR: "a measured rotor", KNOWN: "a shaft with known masses", ENGINE: "an engine"}


def scene_only(job: Job, verb: str, instead: str = "") -> Scene:
    """The job, if it is a scene; InputError with the way out where a verb makes no sense for balancing jobs."""
    if is_scene(job):
        return job
    way = f" {instead}" if instead else ""
    raise InputError(f"{job.name}: {verb} is for a machine on its mounts, and this is {noun_of(job)}.{way}")


read, solve = open_job, answer
"""As `vibopt.read` and `vibopt.solve`."""
