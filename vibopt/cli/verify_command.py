"""`vibopt verify`: every file of a folder against its own records."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from vibopt.answer.answer import Answer
from vibopt.cli import completing
from vibopt.cli.options import Once, as_json, force, limited, method
from vibopt.cli.output import complain, fail, say, say_json, show, width
from vibopt.errors import InputError, counted
from vibopt.files.writing import checked_target, write_file

if TYPE_CHECKING:
    from vibopt.answer.console import Console, Grid
    from vibopt.jobs import Job
    from vibopt.study.archive import Comparison
    from vibopt.study.verify import Verification

DIFFERENT, INTERRUPTED = 6, 130
README, PAGES = "README.md", (".md",)
MOST_DIFFERENCES = 5
"""Of one file, that are said in words; JSON has them all."""


@click.command(cls=Once)
@click.argument("paths", metavar="PATH...", nargs=-1, required=True, shell_complete=completing.problem_files)
@method
@limited
@click.option(
    "--workers",
    metavar="NUMBER",
    type=click.IntRange(min=1),
    help="Processes that share the files; without it as many as there are cores, two at most.",
)
@click.option("--save", metavar="FILE", help="Keep the answers, without their timings (.json).")
@click.option("--against", metavar="FILE", help="Compare with answers that were kept, here or on another machine.")
@click.option("--report", is_flag=True, help="Write a page of all answers, README.md in the folder that is verified.")
@click.option("-o", "--output", metavar="FILE", help="Write that page to another file (.md).")
@force
@as_json
def verify(
    paths: tuple[str, ...],
    method: str | None,
    workers: int | None,
    save: str | None,
    against: str | None,
    report: bool,
    output: str | None,
    force: bool,
    as_json: bool,
) -> int:
    """Solve every .toml file of the folders and files named, and compare with its [[expected]] records.

    The answers are the same with any number of workers, and come in the order of the files.  With --save
    they are kept; with --against they are compared with kept ones, file by file: byte-equal, equal to 1e-9,
    or what differs.  With --report each problem has a line on a page: what was asked, ours, what was printed and
    whether that is right, and the proof.

    Exit code 6 unless every file gives what it recorded, and what was kept.
    """
    from vibopt.cli.progress import Bar
    from vibopt.study.archive import archive_text, compared_among, kept_answer, read_archive
    from vibopt.study.gallery import gallery
    from vibopt.study.verify import verify as verified
    from vibopt.study.workers import usual_number

    kept = read_archive(against) if against is not None else None
    target = _target(paths, save, (".json",), force=force) if save is not None else None
    page = _target(paths, output or _beside(paths), PAGES, force=force) if report or output is not None else None
    keep = None if kept is None and target is None else kept_answer
    try:
        with Bar() as bar:
            result = verified(paths, partial(_answer, method=method), bar, workers=workers or usual_number(), keep=keep)
    except KeyboardInterrupt:
        return _stopped(as_json)
    comparisons = [compared_among(one.name, kept["answers"], one.kept) for one in result.results] if kept else []
    if target is not None:
        answers = {one.name: one.kept for one in result.results if one.kept is not None}
        write_file(target, archive_text(answers).encode())
    if page is not None:
        write_file(page, gallery(result.results, page.parent).encode())
    written = [one for one in (target, page) if one is not None]
    if as_json:
        _say_json(result, comparisons, written)
    else:
        _tell(result)
        if kept is not None:
            _tell_comparisons(comparisons, kept, str(against))
        if target is not None:
            _tell_missing(result)
        for one in written:
            say(f"Written: {one}")
    alike = all(comparison.verdict != "differs" for comparison in comparisons)
    return 0 if result.ok and alike else DIFFERENT


def _beside(paths: tuple[str, ...]) -> str:
    """The page beside the files, where a single folder is named."""
    from vibopt.study.verify import problem_files

    problem_files(paths)  # what is not there is said first
    if len(paths) != 1 or not os.path.isdir(paths[0]):
        named = f"{len(paths)} paths are" if len(paths) != 1 else "a single file is"
        raise InputError(
            f"--report writes {README} into the folder that is verified, and {named} named. Add -o FILE.md."
        )
    return os.path.join(paths[0], README)


def _target(paths: tuple[str, ...], name: str, endings: tuple[str, ...], *, force: bool) -> Path:
    """Where answers will be kept; the problem files are inputs, though other processes read them."""
    from vibopt.files.reading import FileFault, Kind, stamp_of
    from vibopt.study.verify import problem_files

    for file, _ in problem_files(paths):
        with suppress(FileFault):
            stamp_of(file, Kind("a problem file", 1_000_000_000, "", ""))
    return checked_target(name, endings, force=force)


def _say_json(result: Verification, comparisons: Sequence[Comparison], written: Sequence[Path]) -> None:
    alike = result.ok and all(comparison.verdict != "differs" for comparison in comparisons)
    say_json(
        {
            "status": "ok" if alike else "different",
            "files": result.files,
            "records": result.rows,
            **({"compared": comparisons} if comparisons else {}),
            **({"written": [str(path) for path in written]} if written else {}),
        }
    )


def _tell_comparisons(comparisons: Sequence[Comparison], kept: Mapping[str, Any], against: str) -> None:
    """A line for each file, what differs below it, and how many are as they were."""
    from vibopt.study.archive import CLOSE, EQUAL, changed_versions

    say(f"\nAgainst {against}:")
    for comparison in comparisons:
        say(f"{comparison.file}: {comparison.words}")
        for difference in comparison.differences[:MOST_DIFFERENCES]:
            say(f"  {difference}")
        if len(comparison.differences) > MOST_DIFFERENCES:
            say(f"  and {len(comparison.differences) - MOST_DIFFERENCES} more")
    verdicts = [comparison.verdict for comparison in comparisons]
    counts = ((EQUAL, verdicts.count(EQUAL)), (CLOSE, verdicts.count(CLOSE)), ("different", verdicts.count("differs")))
    say(f"{counted(len(verdicts), 'files')}: {', '.join(f'{count} {word}' for word, count in counts)}.")
    if rest := len(set(kept["answers"]) - {comparison.kept_as or comparison.file for comparison in comparisons}):
        say(f"{counted(rest, 'more kept answers')} not asked for.")
    for words in changed_versions(kept):
        say(f"{words}.")


def _tell_missing(result: Verification) -> None:
    missing = [one.name for one in result.results if one.kept is None]
    if missing:
        complain(f"Without an answer, so not kept: {', '.join(missing)}.")


def _answer(job: Job, method: str | None) -> Answer[Any]:
    """The answer to a job; a method is one for scenes."""
    from vibopt.jobs import answer, is_scene

    return answer(job, method=method if is_scene(job) else None)


def _stopped(as_json: bool) -> int:
    message = "Stopped before every file was solved; nothing was compared."
    return fail(INTERRUPTED, "interrupted", message, as_json=as_json)


_RECORDS = "See `vibopt help verification`."


def _tell(result: Verification) -> None:
    if not result.rows:
        say(f"{counted(result.files, 'files')} without a record: what is right stands in [[expected]]. {_RECORDS}")
        return
    show(lambda console: _tables(result, console, width()))
    for row in result.rows:
        if not row.ok:
            say(f"{row.file}, {row.what}: {row.why or f'{row.ours} instead of {row.right}.'}")
    agreed = sum(row.ok for row in result.rows)
    files, records = result.files, len(result.rows)
    say(f"{counted(files, 'files')}, {counted(records, 'records')}, {agreed} as recorded.")


def _tables(result: Verification, console: Console, columns: int) -> None:
    """One heading, then each file's name and its records; columns stand under each other."""
    spare = max(columns - 80, 0)
    widths = (20 + spare, 12, 15, 15, 10, 3)
    console.print(_table([("What", "Printed", "Right", "Ours", "Verdict", "OK")], widths), style="dim")
    for file, rows in groupby(result.rows, key=lambda row: row.file):
        console.print(file, style="bold")
        cells = [
            (row.what, row.printed or "-", row.right, row.ours, row.verdict or "-", "ok" if row.ok else "NO")
            for row in rows
        ]
        console.print(_table(cells, widths))


def _table(rows: Iterable[tuple[str, ...]], widths: tuple[int, ...]) -> Grid:
    from vibopt.answer.console import Grid

    return Grid(list(rows), widths=widths, gap=1)
