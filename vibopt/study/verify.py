"""Problem files solved one after the other, or side by side, and compared with their own records."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vibopt.answer.answer import Answer
from vibopt.document.toml_reading import PROBLEM
from vibopt.errors import InputError, counted
from vibopt.files.reading import FileFault, shown_name, stamp_of
from vibopt.jobs import NO_NAME, open_job
from vibopt.records import dataclass
from vibopt.study.recorded import Row, compare
from vibopt.study.workers import Lost, Processes, each
from vibopt.work import each_answer_within, seconds_of_each_answer

if TYPE_CHECKING:
    from vibopt.jobs import Job

Solve = Callable[["Job"], "Answer[Any]"]
Progress = Callable[[str, float], None]


@dataclass(frozen=True, slots=True)
class About:
    """What a page says of one problem file beside its rows.

    file
        Where it lies.
    status, proven, method
        Of the answer; `input_error` or `internal_error` where there is none.
    title, source
        As the file says; "" where it does not.
    reasons
        Why each record has its verdict, in the order of the rows; "" where it does not say.
    """

    file: Path
    status: str
    title: str = ""
    source: str = ""
    proven: bool = False
    method: str = ""
    reasons: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class FileResult:
    """What became of one problem file.

    rows
        Its records against the answer; one row that is not ok where there is no answer.
    about
        File, title, source and proof.
    kept
        What is kept of the answer, where that was asked for; None where there is no answer.
    """

    name: str
    rows: tuple[Row, ...]
    about: About
    kept: Mapping[str, Any] | None = None


@dataclass(frozen=True, slots=True)
class Verification:
    """Rows of all files, in order; `files` counts the files, those without records included."""

    rows: tuple[Row, ...]
    files: int
    results: tuple[FileResult, ...] = field(default=(), repr=False)

    @property
    def ok(self) -> bool:
        """Whether every file gave what it recorded."""
        return all(row.ok for row in self.rows)


def verify(
    paths: Iterable[str | Path],
    solve: Solve,
    progress: Progress | None = None,
    *,
    workers: int = 0,
    keep: Callable[[Path, Job, Answer[Any]], Mapping[str, Any]] | None = None,
) -> Verification:
    """Solve every problem file and compare with its records.

    Parameters
    ----------
    paths
        Files, or folders that are searched for .toml files with all that is below them.
    solve
        Job to answer; a function of a module, or a partial of one, where there are workers.
    progress
        Called with how many files are done, in words and as a part.
    workers
        Processes that share the files; 0 solves them in this one.
    keep
        Called with file, job and answer: what is kept of each answer.

    Raises
    ------
    InputError
        A path that is not there, or a folder without any .toml file.
    """
    files = problem_files(paths)
    work = partial(verify_file, solve=solve, keep=keep, seconds=seconds_of_each_answer())

    def done(count: int) -> None:
        if progress is not None:
            progress(f"{count} of {counted(len(files), 'files')}", count / len(files))

    done(0)
    if workers:
        found = each(work, files, Processes(workers), done)
        results = [
            FileResult(name, (_no_answer(name, *_NOTHING, f"{one.why}."),), About(file, "internal_error"))
            if isinstance(one, Lost)
            else one
            for (file, name), one in zip(files, found, strict=True)
        ]
    else:
        results = []
        for file in files:
            results.append(work(file))
            done(len(results))
    return Verification(tuple(row for result in results for row in result.rows), len(files), tuple(results))


def problem_files(paths: Iterable[str | Path]) -> list[tuple[Path, str]]:
    """Each file once, with the name that is shown for it: short, and as given where two would be the same."""
    found: dict[Path, tuple[str, str]] = {}
    for path in paths:
        if not str(path):
            raise InputError(NO_NAME)
        given = Path(path)
        if os.path.isdir(given):
            inside = sorted(one for one in given.rglob("*.toml") if one.is_file())
            if not inside:
                raise InputError(f"{shown_name(given)} holds no problem file (.toml). Name another folder, or a file.")
            for one in inside:
                found.setdefault(one.resolve(), (one.relative_to(given).as_posix(), one.as_posix()))
        elif os.path.exists(given):
            _check_regular(given)
            found.setdefault(given.resolve(), (given.name, given.as_posix()))
        else:
            raise InputError(f"{shown_name(given)} is not there. Name a problem file (.toml) or a folder of them.")
    short = Counter(name for name, _ in found.values())
    return [(file, name if short[name] == 1 else whole) for file, (name, whole) in found.items()]


def _check_regular(file: Path) -> None:
    try:
        stamp_of(file, PROBLEM, counts=False)
    except FileFault as fault:
        raise InputError(f"{shown_name(file)} {fault.text}") from None


def verify_file(
    given: tuple[Path, str],
    solve: Solve,
    keep: Callable[[Path, Job, Answer[Any]], Mapping[str, Any]] | None = None,
    seconds: float | None = None,
) -> FileResult:
    """The records of one file with its name; one row that is not ok where there is no answer to compare with."""
    file, name = given
    try:
        job = open_job(file)
    except InputError as error:
        row = _no_answer(name, "the file", "no mistakes", "input_error", str(error))
        return FileResult(name, (row,), About(file, "input_error"))
    try:
        with each_answer_within(seconds):
            answer = solve(job)
            kept = keep(file, job, answer) if keep is not None else None
    except Exception as error:
        row = _no_answer(name, *_NOTHING, " ".join(f"{type(error).__name__}: {error}".split()))
        return FileResult(name, (row,), _about(file, job, None))
    rows = [compare(answer, record, name) for record in job.expected]
    recorded = any(record.get("path") == "status" for record in job.expected)
    if answer.status in ("check_failed", "unproven") and not recorded:
        rows.append(_no_answer(name, "status", "a checked answer", answer.status, answer.claim))
    return FileResult(name, tuple(rows), _about(file, job, answer), kept)


_NOTHING = ("the answer", "an answer", "internal_error")


def _about(file: Path, job: Job, answer: Answer[Any] | None) -> About:
    source = str(job.document.get("source", ""))
    if answer is None:
        return About(file, "internal_error", job.title, source)
    reasons = tuple(str(record.get("why", "")) for record in job.expected)
    return About(file, answer.status, job.title, source, answer.proven, answer.method, reasons)


def _no_answer(name: str, what: str, right: str, ours: str, why: str) -> Row:
    return Row(name, what, "", right, ours, "", False, why=why)
