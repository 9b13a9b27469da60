"""`vibopt check`: all mistakes of a file, or what it says, without solving anything."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from vibopt.cli.options import Once, as_json, files
from vibopt.cli.output import complain, say, say_json
from vibopt.errors import InputError, counted

if TYPE_CHECKING:
    from vibopt.devices.part import Bound
    from vibopt.jobs import Job
    from vibopt.scene.scene import Scene

_COUNTED = (
    "bodies", "bases", "structures", "absorbers", "links", "inerters", "mounts", "excitations", "limits", "measures",
    "variables", "planes", "sensors", "runs", "speeds", "masses", "bearings", "cylinders", "weights", "expected",
)  # fmt: skip
"""What is counted, in this order; then what further families there are."""
_CALLED = {
    "mounts": "groups of mounts", "weights": "counterweights and balance shafts", "expected": "records",
}  # fmt: skip


@click.command(cls=Once)
@files
@as_json
def check(files: tuple[str, ...], as_json: bool) -> int:
    """Say whether problem files have mistakes, what they ask, and how their values were read.

    Nothing is solved.  Exit code 2 if there is any mistake.
    """
    read = [_checked(file) for file in files]
    found = [one for one, _ in read]
    messages = [message for one in found for message in one["messages"]]
    if as_json:
        say_json({"status": "input_error" if messages else "ok", "messages": messages, "files": found})
    else:
        for one, bought in read:
            _tell(one, bought)
    return 2 if messages else 0


def _checked(file: str) -> tuple[dict[str, Any], tuple[Bound, ...]]:
    """What one file says, as plain data, and the parts of catalogues that it leaves to choose."""
    from vibopt.jobs import is_scene, open_job

    try:
        job = open_job(file)
        _check_records(job)
    except InputError as error:
        return {"file": file, "status": "input_error", "messages": list(error.messages)}, ()
    if is_scene(job):
        from vibopt.scene.places import bound_parts

        return _checked_scene(file, job), tuple(bound_parts(job))
    from vibopt.balancing.explained import said_by

    return {"file": file, "status": "ok", "messages": [], **said_by(job)}, ()


def _check_records(job: Job) -> None:
    """Records are compared by `verify` alone; that they can be is said before."""
    from vibopt.document.expected import complaint_of

    records = enumerate(job.document.get("expected", ()), 1)
    if faults := [f"{job.name}: expected[{k}]: {fault}" for k, one in records if (fault := complaint_of(one))]:
        raise InputError(faults)


def _checked_scene(file: str, scene: Scene) -> dict[str, Any]:
    from vibopt.report.machine_words import notes_of, ranges_of

    return {
        "file": file,
        "status": "ok",
        "messages": [],
        "title": scene.title,
        **{family: len(getattr(scene, family)) for family in (*_COUNTED, *scene.others) if hasattr(scene, family)},
        "asked": asked(scene),
        "choices": ranges_of(scene),
        "notes": notes_of(scene),
    }


def asked(scene: Scene) -> str:
    """The question in words: "goal: maximise stiffness of mount"."""
    from vibopt.answer.blocks import spoken
    from vibopt.scene.places import place_of

    if scene.find_all is not None:
        return f"goal: find all {scene.find_all}"
    if scene.goal is None:
        return "an analysis, nothing to choose"
    response = scene.goal.response
    return f"goal: {scene.goal.sense} {spoken(response.response, place_of(response))}"


def _tell(one: dict[str, Any], bought: tuple[Bound, ...]) -> None:
    """A part to be bought is one choice, not a variable for each column of its catalogue."""
    if one["messages"]:
        complain("\n".join(one["messages"]))
        return
    from vibopt.devices import FAMILIES

    columns = {path for part in bought for path in part.paths}
    numbers = {**one, "variables": one["variables"] - len(columns)} if columns else one
    every = dict.fromkeys((*_COUNTED, *FAMILIES))
    counts = [counted(numbers[key], _CALLED.get(key, key)) for key in every if numbers.get(key)]
    chosen = [counted(len(bought), "choices")] if bought else []
    say(f"{one['file']}: no mistakes. {'; '.join(filter(None, [', '.join([*counts, *chosen]), one['asked']]))}.")
    for part in bought:
        say(f"  {part.path}: one of {counted(len(part.names), 'parts')} of {part.catalogue.file}")
    for path, choice in one["choices"].items():
        if path not in columns:
            say(f"  {path}: {choice}")
    for note in one["notes"]:
        say(f"  {note}")
