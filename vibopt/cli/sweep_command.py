"""`vibopt sweep`: one fact varied over a range."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from vibopt.answer.answer import UNPROVEN
from vibopt.cli import completing
from vibopt.cli.options import Once, anew, as_json, changes, changes_of, file, force, keep_design, limited, read_job
from vibopt.cli.output import colour, note_kept, say, say_json, width
from vibopt.cli.sweep_table import GrowingTable, csv_text
from vibopt.errors import InputError
from vibopt.files.reading import shown_name
from vibopt.files.writing import checked_target, format_of, write_file

if TYPE_CHECKING:
    from vibopt.answer.console import Console
    from vibopt.answer.entry import Entry
    from vibopt.jobs import Job
    from vibopt.study.sweep import Sweep

TABLES = (".csv", ".txt")
FORMATS = (".svg", ".png", ".pdf")
MOST_ROWS = 60
_TURNED = (".mass", ".unbalance")
"""Numbers that stand at an angle."""


@click.command(cls=Once)
@file
@click.option(
    "--vary",
    required=True,
    metavar='PATH="LOW..HIGH"',
    shell_complete=completing.changes,
    help='As in --vary limits.start_up.at_most="5 mm..30 mm".',
)
@click.option("--points", type=click.IntRange(2, 100_000), default=50, show_default=True, help="How many values.")
@click.option("--csv", "csv_file", metavar="FILE", help="Write the points as a table (SI units, and dB), as they come.")
@click.option("--figure", metavar="FILE", help="Draw the points (.svg, .png, .pdf).")
@keep_design
@limited
@anew
@changes
@force
@as_json
def sweep(
    file: str,
    vary: str,
    points: int,
    csv_file: str | None,
    figure: str | None,
    keep_design: bool,
    changes: tuple[str, ...],
    force: bool,
    as_json: bool,
) -> int:
    """Vary one fact over a range, and answer at every point.

    A sweep that is stopped keeps its points in the --csv file.  Exit code 5 unless every point has a proven or
    checked answer.
    """
    path, low_high = split_range(vary)
    if path in changes_of(changes):
        raise InputError(f"{path} is given by --vary and by --set. Leave out the --set.")
    job = read_job(file, changes)
    table = checked_target(csv_file, TABLES, force=force) if csv_file is not None else None
    picture = checked_target(figure, FORMATS, force=force) if figure is not None else None
    if table is not None and picture is not None and table.resolve() == picture.resolve():
        raise InputError(f"--csv and --figure name one file, {shown_name(table)}. Name two.")
    result = _run(job, path, low_high, points, table, keep_design=keep_design)
    if table is not None:
        write_file(table, csv_text(result).encode())
    if picture is not None:
        from vibopt.report.figures import saved, strips_figure
        from vibopt.study.sweep_series import strips

        write_file(picture, saved(strips_figure(strips(result)), format_of(picture, FORMATS)))
    written = [str(one) for one in (table, picture) if one is not None]
    if as_json:
        status = "ok" if result.complete else "unproven"
        say_json({"status": status, "path": path, "written": written, **_points(result)})
    else:
        from vibopt.answer.text import rendered

        say(rendered(lambda console: _list(result, console), width=width(), colour=colour()))
        for one in written:
            say(f"Written: {one}")
    return 0 if result.complete else UNPROVEN


def _run(job: Job, path: str, low_high: str, points: int, table: Path | None, *, keep_design: bool) -> Sweep:
    """The sweep, with every point in the table as soon as it is known."""
    from vibopt.cli.progress import Bar
    from vibopt.jobs import is_scene
    from vibopt.study.seen import goal_word
    from vibopt.study.sweep import sweep as run

    goal = "" if keep_design and is_scene(job) else goal_word(job)
    growing = GrowingTable(table, job, goal) if table is not None else None
    answered = growing.add if growing is not None else None
    try:
        with Bar() as bar:
            return run(job, path, low_high, points, keep_design=keep_design, progress=bar, answered=answered)
    except KeyboardInterrupt:
        if growing is not None and growing.points:
            note_kept(f"{shown_name(growing.target)} holds {len(growing.points)} of {points} points.")
        elif growing is None:
            note_kept("No point was kept: with --csv FILE each is written as it comes.")
        raise


def split_range(given: str) -> tuple[str, str]:
    """Path and range text of --vary."""
    path, sign, low_high = given.partition("=")
    if not (sign and path.strip() and low_high.strip()):
        raise InputError(f'--vary {given}: is no PATH=LOW..HIGH. Write --vary limits.start_up.at_most="5 mm..30 mm".')
    return path.strip(), low_high.strip()


def _points(result: Sweep) -> dict[str, Any]:
    from vibopt.answer.jsonable import plain

    return {"goal": result.goal, "keep_design": result.keep_design, "points": plain(result.points)}


def _list(result: Sweep, console: Console) -> None:
    from vibopt.answer.text import grid

    console.print(result.job.title, style="bold")
    parts = list(dict.fromkeys(path for point in result.points for path in point.parts))
    paths = _columns(result)
    step = max(1, -(-len(result.points) // MOST_ROWS))
    rows = []
    for point in result.points[::step]:
        entries = {**point.variables, **point.results}
        values = [_value(entries, path) for path in paths]
        goal = [point.goal.shown if point.goal is not None else "-"] if result.goal else []
        bought = [point.parts.get(path, "-") for path in parts]
        rows.append((point.value.shown, point.status, *goal, *bought, *values, _tight(point.margins)))
    names = [path.split(".", 1)[-1] for path in (*parts, *paths)]
    heads = ("Value", "Verdict", *([result.goal] if result.goal else []), *names, "Active limits")
    console.print(f"{result.path} varied{', a variable that is held at each value' if result.held else ''}")
    console.print(grid(rows, heads))
    if step > 1:
        console.print(f"One in {step} of {len(result.points)} points is shown; --csv FILE writes all of them.")


def _value(entries: Mapping[str, Entry], path: str) -> str:
    """A number, with its angle where it has one."""
    turned = entries.get(f"{path.rpartition('.')[0]}.angle")
    if path not in entries:
        return "-"
    angle = f" @ {turned.shown}" if turned is not None and path.endswith(_TURNED) else ""
    return f"{entries[path].shown}{angle}"


def _large(entries: Mapping[str, Entry]) -> dict[str, Entry]:
    """Numbers that are not rounding beside another of their kind."""
    most: dict[str, float] = {}
    for one in entries.values():
        most[one.dimension] = max(most.get(one.dimension, 0.0), abs(one.value))
    return {path: one for path, one in entries.items() if abs(one.value) > 1e-9 * most[one.dimension]}


def _columns(result: Sweep) -> list[str]:
    """Paths of the variables to list, and not the one that is the goal itself; of balancing jobs without any the rest.

    Of a kept design of a scene there are none.
    """
    from vibopt.jobs import is_scene
    from vibopt.report.catalogue_choices import tied
    from vibopt.scene.open_places import open_positions

    scene = result.job
    if not is_scene(scene):
        named = [point.variables or _large(point.results) for point in result.points]
        return [path for path in dict.fromkeys(path for one in named for path in one) if not path.endswith(".angle")]
    if result.keep_design:
        return []
    goal = scene.goal.response if scene.goal is not None else None
    same = f"links.{getattr(goal, 'of', '')}.{goal.response}" if goal is not None else ""
    inner = tied(scene)
    free = [one.path for one in scene.variables if one.path != same and one.path not in inner]
    return [*open_positions(scene), *free]


def _tight(margins: Mapping[str, float]) -> str:
    """Limits that are broken, else those without any margin, else the tightest."""
    broken = [f"{name} BROKEN" for name, one in margins.items() if one < -1e-6]
    active = [name for name, one in margins.items() if abs(one) <= 1e-6]
    return ", ".join(broken or active)
