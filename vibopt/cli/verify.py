"""`vibopt verify`: every file of a folder against its own records."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import groupby
from typing import TYPE_CHECKING

import click

from vibopt.cli.options import Once, as_json, limited, method
from vibopt.cli.output import colour, say, say_json, width

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from vibopt.jobs import Answer, Job
    from vibopt.study.verify import Row, Verification

DIFFERENT = 6


@click.command(cls=Once)
@click.argument("paths", metavar="PATH...", nargs=-1, required=True)
@method
@limited
@as_json
def verify(paths: tuple[str, ...], method: str | None, as_json: bool) -> int:
    """Solve every .toml file of the folders and files named, and compare with its [[expected]] records.

    Exit code 6 unless every file gives what it recorded.
    """
    from vibopt.cli.progress import Bar
    from vibopt.jobs import answer as answer_of
    from vibopt.jobs import is_scene
    from vibopt.study.verify import verify as verified

    def answer(job: Job) -> Answer:
        return answer_of(job, method=method if is_scene(job) else None)

    with Bar() as bar:
        result = verified(paths, answer, bar)
    if as_json:
        say_json({"status": "ok" if result.ok else "different", "files": result.files, "records": result.rows})
    else:
        _tell(result)
    return 0 if result.ok else DIFFERENT


def _tell(result: Verification) -> None:
    from vibopt.design.table import rendered

    columns = width()
    say(rendered(lambda console: _tables(result, console, columns), width=columns, colour=colour()))
    for row in result.rows:
        if not row.ok:
            say(f"{row.file}, {row.what}: {row.why or f'{row.ours} instead of {row.right}.'}")
    agreed = sum(row.ok for row in result.rows)
    files, records = result.files, len(result.rows)
    say(f"{files} file{'s' * (files != 1)}, {records} record{'s' * (records != 1)}, {agreed} as recorded.")


def _tables(result: Verification, console: Console, columns: int) -> None:
    """One heading, then each file's name and its records; columns stand under each other."""
    spare = max(columns - 80, 0)
    widths = (20 + spare, 12, 15, 15, 10, 3)
    console.print(_table([("What", "Printed", "Right", "Ours", "Verdict", "OK")], widths), style="dim")
    for file, rows in groupby(result.rows, key=lambda row: row.file):
        console.print(file, style="bold")
        console.print(_table([_cells(row) for row in rows], widths))


def _table(rows: Iterable[tuple[str, ...]], widths: tuple[int, ...]) -> Table:
    from rich.table import Table

    table = Table(box=None, show_header=False, padding=(0, 1, 0, 0), pad_edge=False)
    for wide in widths:
        table.add_column(width=wide, overflow="fold")
    for row in rows:
        table.add_row(*row)
    return table


def _cells(row: Row) -> tuple[str, ...]:
    return row.what, row.printed or "-", row.right, row.ours, row.verdict or "-", "ok" if row.ok else "NO"
