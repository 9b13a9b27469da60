"""`vibopt compare`: variants A, B, C in one table."""

from __future__ import annotations

from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import click

from vibopt.cli.options import Once, anew, as_json, changes, files, force, limited, read_job
from vibopt.cli.output import told
from vibopt.cli.sweep_table import rows_text, table_text
from vibopt.errors import InputError
from vibopt.files.writing import checked_target, write_file

if TYPE_CHECKING:
    from vibopt.answer.console import Console
    from vibopt.jobs import Job
    from vibopt.study.scenarios import Stepped
    from vibopt.study.variant_cells import Cell
    from vibopt.study.variants import Variants

BEST = "*"
TABLES = (".csv", ".txt")
NAME = 26
"""Columns of the names of rows."""


@click.command(cls=Once)
@files
@changes
@click.option("--csv", "csv_file", metavar="FILE", help="Write the table (SI units, limits as margins).")
@click.option("--scenarios", is_flag=True, help="The one file as it is, and with each of its [scenarios.NAME].")
@click.option("--limits", metavar="STEPS", help='The one file with each limit in turn moved: "-20 %, +20 %".')
@limited
@anew
@force
@as_json
def compare(
    files: tuple[str, ...],
    changes: tuple[str, ...],
    csv_file: str | None,
    scenarios: bool,
    limits: str | None,
    force: bool,
    as_json: bool,
) -> int:
    """Set several variants beside each other: problem files, or designs saved by solve --save.

    A file with choices is solved, one without is measured.  A change by --set goes for all of them.

    Exit code: 0 if any variant keeps its limits, else that of the first.
    """
    from vibopt.cli.progress import Bar
    from vibopt.study.variants import compare as beside

    if (scenarios or limits is not None) and (len(files) > 1 or (scenarios and limits is not None)):
        raise InputError("--scenarios and --limits are for one file, each by itself. Name one file, and one of them.")
    jobs = _read(files, changes)
    if scenarios:
        from vibopt.study.scenarios import variants_of

        jobs = variants_of(next(iter(jobs.values())))
    table = checked_target(csv_file, TABLES, force=force) if csv_file is not None else None
    if limits is not None:
        return _stepped(next(iter(jobs.values())), limits, table, as_json=as_json)
    with Bar() as bar:
        result = beside(jobs, progress=bar)
    written = _written(table, csv_text(result)) if table is not None else []
    status = "ok" if result.exit_code == 0 else result.designs[0].status
    told(result, _tell, as_json=as_json, status=status, written=written)
    return result.exit_code


def _written(table: Path, text: str) -> list[str]:
    """The file that is written."""
    write_file(table, text.encode())
    return [str(table)]


def _stepped(job: Job, limits: str, table: Path | None, *, as_json: bool) -> int:
    """Every limit by itself moved by some parts."""
    from vibopt.cli.progress import Bar
    from vibopt.study.scenarios import part_of, stepped

    steps = tuple(one.strip() for one in limits.split(","))
    for step in steps:
        part_of(step)
    with Bar() as bar:
        result = stepped(job, steps, progress=bar)
    written = _written(table, table_text(result)) if table is not None else []
    told(result, _tell_steps, as_json=as_json, written=written)
    return 0


def _tell_steps(result: Stepped, console: Console) -> None:
    from vibopt.answer.text import grid

    status, now = result.now
    console.print(result.job.title, style="bold")
    console.print(f"{result.goal} as it is: {now.shown if now is not None else status}")
    names = [path.split(".")[1] for path, _ in result.rows]
    sides = {path for path, _ in result.rows if names.count(path.split(".")[1]) > 1}
    rows = []
    for path, cells in result.rows:
        said = []
        for bound, status, goal in cells:
            change = result.change(goal)
            by = f" ({100.0 * change + 0.0:+.3g} %)" if change is not None and abs(change) > 1e-9 else ""
            without = "not asked" if status == "refused" else status
            said.append(f"{bound}: {goal.shown}{by or ' (the same)'}" if goal is not None else f"{bound}: {without}")
        rows.append((path.removeprefix("limits.") if path in sides else path.split(".")[1], *said))
    console.print(grid(rows, ("Limit", *result.steps)))
    for note in result.notes:
        console.print(note)


def _read(files: tuple[str, ...], changes: tuple[str, ...]) -> dict[str, Job]:
    """The jobs by name; the mistakes of all files together."""
    names = _names(files)
    jobs, mistakes = {}, []
    for name, file in zip(names, files, strict=True):
        try:
            jobs[name] = read_job(file, changes)
        except InputError as error:
            mistakes += [message if Path(file).name in message else f"{file}: {message}" for message in error.messages]
    if mistakes:
        raise InputError(mistakes)
    return jobs


def _names(files: tuple[str, ...]) -> tuple[str, ...]:
    """Short names where they differ, else the files as they were given."""
    if len(set(files)) < len(files):
        twice = next(file for file in files if files.count(file) > 1)
        raise InputError(f"{twice} is named twice. Name each variant once.")
    short = tuple(Path(file).stem for file in files)
    return short if len(set(short)) == len(short) else files


def csv_text(result: Variants) -> str:
    """The table as comma-separated values: numbers in SI, limits as margins (parts of the bound)."""
    from vibopt.answer.jsonable import number

    rows: list[list[Any]] = [["kind", "row", "unit", *result.names]]
    for row in result.rows:
        name = f"margin of {row.name}" if row.kind == "limit" else row.name
        rows.append([row.kind, name, row.unit, *(_csv_cell(cell, number) for cell in row.cells)])
    return rows_text(rows)


def _csv_cell(cell: Cell | None, number: Any) -> Any:
    if cell is None:
        return ""
    return cell.text if cell.value is None else number(cell.value)


def _tell(result: Variants, console: Console) -> None:
    """One table; reasons of failures under it in full."""
    from vibopt.answer.text import grid, paragraph

    rows = [row for row in result.rows if row.kind != "reason"]
    marked = any(cell is not None and cell.best for row in rows for cell in row.cells)
    names = [row.name for row in rows]
    heads = [row.name if names.count(row.name) == 1 else f"{row.kind} {row.name}" for row in rows]
    lines = [
        (_folded(head), *("-" if cell is None else _said(cell) for cell in row.cells))
        for head, row in zip(heads, rows, strict=True)
    ]
    console.print(grid(lines, ("", *result.names), whole=(0,)))
    for row in result.rows:
        for name, cell in zip(result.names, row.cells, strict=True) if row.kind == "reason" else ():
            if cell is not None:
                paragraph(console, f"{name}: {cell.text}", 0)
    if marked:
        paragraph(console, f"{BEST} best of its row; of a limit, the most room.", 0)


def _folded(name: str) -> str:
    """A name over several lines: a path behind its points, anything else between its words."""
    if len(name) <= NAME:
        return name
    if " " in name:
        return fill(name, NAME, subsequent_indent="  ", break_long_words=False)
    front, point, last = name.rpartition(".")
    return f"{front}{point}\n  {last}"


def _said(cell: Cell) -> str:
    if not cell.best:
        return cell.text
    first, new, rest = cell.text.partition("\n")
    return f"{first} {BEST}{new}{rest}"
