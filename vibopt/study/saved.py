"""A design as a problem file of its own: every choice is a value, so it can be solved and varied as it stands."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

from vibopt.answer.answer import EMPTY
from vibopt.answer.text import verdict
from vibopt.document.toml_reading import FileText
from vibopt.document.toml_writing import document_toml
from vibopt.errors import InputError
from vibopt.files.marks import with_check
from vibopt.jobs import is_open, is_scene, scenarios_of, with_changes
from vibopt.study.freeze import bought
from vibopt.study.seen import chosen, kept

if TYPE_CHECKING:
    from vibopt.answer.answer import Answer
    from vibopt.jobs import Job
    from vibopt.study.for_all import OneForAll


def saved_text(
    job: Job, answer: Answer[Any], target: FilePath, *, fixed: Job | None = None, changes: Sequence[str] = ()
) -> str:
    """The text of a problem file that says what an answer chose, as it must read at `target`.

    Parameters
    ----------
    job, found
        A job and its answer; an analysis is saved as it stands.
    target
        Where the file will lie; the files that it names are named as seen from there.
    fixed
        The job with the values to write, where they are not exactly those of the answer (rounded values).
    changes
        What was changed before solving, as "path=value"; said in the comments.

    Raises
    ------
    InputError
        There is no design to save.
    """
    if is_scene(job) and job.find_all is not None:
        raise InputError(f"{job.name}: find_all answers with {job.finds}, so there is no design to save.")
    if answer.status in EMPTY or (fixed is None and is_open(job) and not chosen(job, answer)):
        raise InputError(f"{job.name}: there is no design to save: {answer.status}. {target.name} is not written.")
    if is_open(job) and answer.status == "violated":
        broken = ", ".join(name for name, limit in answer.limits.items() if not limit.met) or "what may be chosen"
        raise InputError(f"{job.name}: the rounded design breaks {broken}. {target.name} is not written; round finer.")
    said = (verdict(answer), answer.claim, list(chosen(job, answer)))
    if fixed is None:
        return _text(job, kept(job, answer), said, target, changes)
    return _text(job, bought(fixed, job) if is_scene(job) and is_scene(fixed) else fixed, said, target, changes)


def saved_for_all(found: OneForAll, target: FilePath, *, changes: Sequence[str] = ()) -> str:
    """The same of one design for all scenarios, which stay in the file; InputError where there is none."""
    if found.kept is None:
        raise InputError(f"{found.job.name}: there is no design to save: {found.status}. {target.name} is not written.")
    said = (found.verdict, found.claim, list(found.variables))
    return _text(found.job, found.kept, said, target, changes)


def _text(job: Job, whole: Job, said: tuple[str, str, Sequence[str]], target: FilePath, changes: Sequence[str]) -> str:
    document, left = _with_places(whole)
    comments = _comments(job, *said, changes) + (f"\n# {left}" if left else "")
    return with_check(f"{comments}\n\n{document_toml(moved(document, target))}")


def _with_places(whole: Job) -> tuple[dict[str, Any], str]:
    """The document with those changes of scenarios that still have a place, and in words which ones have none."""
    stay: dict[str, Any] = {}
    left = []
    for name, asked in scenarios_of(whole).items():
        kept = (
            asked if _has_place(whole, asked) else {p: one for p, one in asked.items() if _has_place(whole, {p: one})}
        )
        if kept and _has_place(whole, kept):
            stay[name] = whole.document["scenarios"][name] if kept is asked else kept
        left += [f"{path} of {name}" for path in asked if name not in stay or path not in kept]
    rest = {key: one for key, one in whole.document.items() if key not in ("expected", "scenarios")}
    words = f"Left out of the scenarios, for it has no place in a design or changes nothing: {', '.join(left)}."
    return rest | ({"scenarios": stay} if stay else {}), words if left else ""


def _has_place(job: Job, asked: Mapping[str, Any]) -> bool:
    """Whether a scenario has a place in a job, and changes something there."""
    try:
        return with_changes(job, asked).document != job.document
    except InputError:
        return False


def moved(document: Mapping[str, Any], target: FilePath) -> dict[str, Any]:
    """The document with the files it names as seen from the folder of `target`."""
    return {key: _moved(one, target.resolve().parent) for key, one in document.items()}


def _moved(value: Any, folder: FilePath) -> Any:
    if isinstance(value, FileText):
        return _seen_from(folder, value)
    if isinstance(value, Mapping):
        return {key: _moved(one, folder) for key, one in value.items()}
    if isinstance(value, list):
        return [_moved(one, folder) for one in value]
    return value


def _seen_from(folder: FilePath, file: FileText) -> str:
    """The name of a file as seen from another folder; an absolute name stays as it is."""
    if FilePath(file).is_absolute():
        return str(file)
    there = (file.folder / file).resolve()
    try:
        return FilePath(os.path.relpath(there, folder)).as_posix()
    except ValueError:  # another drive
        return there.as_posix()


def _comments(job: Job, verdict: str, claim: str, taken: Sequence[str], changes: Sequence[str]) -> str:
    """From which file and which answer a design comes."""
    words = f"Design of {job.name}" + (f" with {', '.join(changes)}" if changes else "")
    lines = [f"{words}, saved by vibopt: nothing is left to choose.", f"Answer: {verdict}."]
    lines += [f"Claim: {claim}."] if claim else []
    lines += [f"Chosen: {', '.join(taken)}."] if taken else []
    return "\n".join(f"# {' '.join(line.split())}" for line in lines)
