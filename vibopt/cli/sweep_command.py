"""`vibopt sweep`: one, two or three facts varied over ranges."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from vibopt.answer.answer import UNPROVEN
from vibopt.answer.entry import ACTIVE
from vibopt.cli import completing
from vibopt.cli.options import (
    Once,
    anew,
    as_json,
    changes,
    changes_of,
    cluster,
    file,
    force,
    keep_design,
    limited,
    read_job,
    scenario,
    with_scenario,
    workers,
)
from vibopt.cli.output import note_kept, told
from vibopt.cli.sweep_table import FORMATS, GrowingTable, csv_text, journal_of, targets
from vibopt.errors import InputError, PoolError, counted
from vibopt.files.reading import shown_name
from vibopt.files.writing import format_of, is_stream, write_file

if TYPE_CHECKING:
    from vibopt.answer.console import Console
    from vibopt.answer.entry import Entry
    from vibopt.files.journal import Journal
    from vibopt.jobs import Job
    from vibopt.study.edges import Boundary
    from vibopt.study.points import Point
    from vibopt.study.sweep import Sweep

MOST_ROWS = 60
_TURNED = (".mass", ".unbalance")
"""Numbers that stand at an angle."""


@click.command(cls=Once)
@file
@click.option(
    "--vary",
    required=True,
    multiple=True,
    metavar='PATH="LOW..HIGH"',
    shell_complete=completing.changes,
    help='As in --vary limits.start_up.at_most="5 mm..30 mm"; also "5..30 mm log", "10, 12, 15 mm", "-20 %..+20 %"; '
    "two or three of them make a grid.",
)
@click.option(
    "--points",
    type=click.IntRange(min=2),
    help="How many values of each range (50 of one, 21 of two, 9 of three); of a sample, in all (256).",
)
@click.option(
    "--sample", type=click.Choice(["sobol", "latin"]), help="Draw points evenly from the ranges in place of a grid."
)
@click.option("--csv", "csv_file", metavar="FILE", help="Write the points as a table (SI units, and dB), as they come.")
@click.option("--resume", is_flag=True, help="Go on with a sweep that was stopped, with the points beside its --csv.")
@click.option("--figure", metavar="FILE", help="Draw the points of one or two facts (.svg, .png, .pdf).")
@click.option("--yes", is_flag=True, help="Answer more than 100000 points.")
@workers
@cluster
@keep_design
@limited
@anew
@changes
@scenario
@force
@as_json
def sweep(
    file: str,
    vary: tuple[str, ...],
    points: int | None,
    sample: Any,
    csv_file: str | None,
    resume: bool,
    figure: str | None,
    yes: bool,
    workers: int,
    cluster: str | None,
    keep_design: bool,
    changes: tuple[str, ...],
    scenario: str | None,
    force: bool,
    as_json: bool,
) -> int:
    """Vary one, two or three facts, and answer at every point.

    Where designs begin or end, and where other limits become active, is found between the points.  A sweep that
    is stopped, or killed, or that loses its cluster, keeps its points in the --csv file, and goes on with --resume.
    Exit code 5 unless every
    point has a proven or checked answer.
    """
    from vibopt.study.seen import goal_word

    ranges = ranges_of(vary)
    for path in ranges:
        if path in changes_of(changes):
            raise InputError(f"{path} is given by --vary and by --set. Leave out the --set.")
    if resume and csv_file is None:
        raise InputError("--resume goes on with the points beside a --csv FILE. Name it.")
    if cluster is not None and workers > 1:
        raise InputError("--workers and --cluster are both given. Leave one out.")
    changes = with_scenario(file, scenario, changes)
    job = read_job(file, changes)
    # the points beside a table, of this very sweep, say whose table it is, however its last line was cut
    table, picture = targets(csv_file, figure, force=(force or resume, force))
    if picture is not None and (sample or len(ranges) > 2):
        why = "a sample has no neighbours" if sample else "three facts have no page"
        raise InputError(f"--figure: {why}. Leave it out, and write the points with --csv FILE.")
    how = {"keep_design": keep_design, "sample": sample or "", "workers": workers, "cluster": cluster}
    edges = as_json or picture is not None or len(ranges) == 1
    journal = None if table is None or is_stream(table) else _journal(file, job, changes, table, (ranges, points, how))
    if resume and journal is None:
        raise InputError(f"--resume: {shown_name(str(table))} is no file, and keeps no points. Name a file.")
    known = journal.take_up() if journal is not None and resume else []
    goal = goal_word(job)
    growing = GrowingTable(table, job, goal, journal, known) if table is not None else None
    result = _run(job, ranges, points, growing, edges=edges, most=_MOST_OF_ALL if yes else None, known=known, **how)
    if table is not None:
        write_file(table, csv_text(result).encode())
    if journal is not None:
        journal.end()
    if picture is not None:
        write_file(picture, _drawn(result, format_of(picture, FORMATS)))
    written = [str(one) for one in (table, picture) if one is not None]
    told(result, _list, as_json=as_json, status="ok" if result.complete else "unproven", written=written)
    return 0 if result.complete else UNPROVEN


_MOST_OF_ALL = 10_000_000
"""Points that the memory of any machine holds."""


def _drawn(result: Sweep, form: str) -> bytes:
    from vibopt.report.figures import map_figure, saved, strips_figure
    from vibopt.study.sweep_series import map_of, strips

    figure = strips_figure(strips(result)) if len(result.varied) == 1 else map_figure(map_of(result))
    return saved(figure, form)


def _journal(
    file: str,
    job: Job,
    changes: Sequence[str],
    table: Path,
    asked: tuple[Mapping[str, str], int | None, Mapping[str, Any]],
) -> Journal[Point]:
    """Where the points are kept; the number of processes makes no difference to them."""
    from vibopt.cli.answer_cache import Asked

    ranges, points, how = asked
    told = [dict(ranges), points, how["sample"], how["keep_design"]]
    journal = journal_of(table, Asked(file, job, tuple(changes)).key(f"sweep {json.dumps(told)}"))
    journal.check()
    return journal


def _run(
    job: Job,
    ranges: Mapping[str, str],
    points: int | None,
    growing: GrowingTable | None,
    *,
    edges: bool,
    most: int | None,
    **how: Any,
) -> Sweep:
    """The sweep, with every point in the table as soon as it is known."""
    from vibopt.cli.progress import Bar
    from vibopt.study.sweep import MOST_POINTS
    from vibopt.study.sweep import sweep as run
    from vibopt.study.varied import how_many

    answered = growing.add if growing is not None else None
    try:
        with Bar() as bar:
            sweep = run(job, ranges, "", points, most=most or MOST_POINTS, progress=bar, answered=answered, **how)
            if edges:
                bar("boundaries", 0.0)
                _ = sweep.boundaries
            return sweep
    except (KeyboardInterrupt, PoolError) as error:
        left = _left(growing, how_many(ranges, points, how["sample"]))
        note_kept(left)
        if isinstance(error, PoolError):
            raise PoolError(f"{error} {left}") from None
        raise


def _left(growing: GrowingTable | None, count: int) -> str:
    """What a sweep that was stopped has left."""
    if growing is None:
        return "No point was kept: with --csv FILE each is written as it comes."
    if not growing.points:
        return "Nothing was written."
    kept = f"{shown_name(growing.target)} holds {len(growing.points)} of {counted(count, 'points')}"
    return f"{kept}." if growing.journal is None else f"{kept}; the same command with --resume goes on."


def ranges_of(given: Sequence[str]) -> dict[str, str]:
    """Path and range text of every --vary."""
    found: dict[str, str] = {}
    for one in given:
        path, sign, text = (part.strip() for part in one.partition("="))
        if not (sign and path and text):
            raise InputError(f'--vary {one}: is no PATH=LOW..HIGH. Write --vary limits.start_up.at_most="5 mm..30 mm".')
        if path in found:
            raise InputError(f"--vary {path} is given twice. Give it once.")
        found[path] = text
    return found


def _list(result: Sweep, console: Console) -> None:
    from vibopt.answer.text import grid

    console.print(result.job.title, style="bold")
    parts, paths = columns(result.job, result.points, keep_design=result.keep_design)
    step = max(1, -(-len(result.points) // MOST_ROWS))
    rows = []
    for point in result.points[::step]:
        entries = {**point.variables, **point.results}
        values = [value_at(entries, path) for path in paths]
        goal = [point.goal or "-"] if result.goal else []
        bought = [point.parts.get(path, "-") for path in parts]
        rows.append((*point.varied.values(), point.status, *goal, *bought, *values, _tight(point, result.drawn)))
    names = [path.split(".", 1)[-1] for path in (*parts, *paths)]
    where = ["Value"] if len(result.paths) == 1 else [_short(path) for path in result.paths]
    heads = (*where, "Verdict", *([result.goal] if result.goal else []), *names, "Active limits")
    held = f", {'a variable that is' if len(result.held) == 1 else 'variables that are'} held at each value"
    console.print(f"{' and '.join(result.paths)} varied{held if result.held else ''}")
    console.print(grid(rows, heads, series=True))
    if step > 1:
        console.print(f"One in {step} of {len(result.points)} points is shown; --csv FILE writes all of them.")
    if result.drawn:
        console.print(
            f"Where the answer changes between these values is not looked for: {' and '.join(result.drawn)} "
            f"{'asks' if len(result.drawn) == 1 else 'ask'} for a probability, which machines that are drawn tell."
        )
    if len(result.paths) == 1 and result.boundaries:
        _list_boundaries(result.boundaries, console)


def _short(path: str) -> str:
    """A path without its family; of a limit its name."""
    family, _, rest = path.partition(".")
    return rest.rpartition(".")[0] if family == "limits" and rest.endswith((".at_most", ".at_least")) else rest


def _list_boundaries(found: Sequence[Boundary], console: Console) -> None:
    from vibopt.answer.text import grid, paragraph, section
    from vibopt.study.sweep_series import change_words

    rows = [(boundary.precise, change_words(boundary)) for boundary in found[:MOST_ROWS]]
    section(console, "Where the answer changes, found by solving again", grid(rows, whole=(0,)))
    if any(boundary.wide for boundary in found):
        paragraph(console, "Between two values it was not followed further, by the work. Sweep a narrower range there.")


def value_at(entries: Mapping[str, Entry], path: str) -> Entry | str:
    """A number, with its angle where it has one."""
    turned, found = entries.get(f"{path.rpartition('.')[0]}.angle"), entries.get(path, "-")
    if isinstance(found, str) or turned is None or not path.endswith(_TURNED) or not found.value:
        return found
    return f"{found.shown} @ {turned.shown}"


def _large(entries: Mapping[str, Entry]) -> dict[str, Entry]:
    """Numbers that are not rounding beside another of their kind."""
    most: dict[str, float] = {}
    for one in entries.values():
        most[one.dimension] = max(most.get(one.dimension, 0.0), abs(one.value))
    return {path: entry for path, entry in entries.items() if abs(entry.value) > 1e-9 * most[entry.dimension]}


def columns(job: Job, points: Iterable[Point], *, keep_design: bool = False) -> tuple[list[str], list[str]]:
    """Paths of the parts and of the variables to list, and not the one that is the goal itself.

    Of jobs without any what is measured; of a design of a scene that is kept the worst value of each limit.
    """
    many = list(points)
    return list(dict.fromkeys(path for point in many for path in point.parts)), _numbers(job, many, keep_design)


def _numbers(scene: Job, points: Sequence[Point], keep_design: bool) -> list[str]:
    from vibopt.jobs import is_scene
    from vibopt.report.catalogue_choices import tied
    from vibopt.scene.open_places import open_positions
    from vibopt.study.seen import is_measured

    if is_measured(scene) or (is_scene(scene) and (keep_design or scene.is_analysis)):
        return list(dict.fromkeys(path for point in points for path in point.results))
    if not is_scene(scene):
        named = [point.variables or _large(point.results) for point in points]
        return [path for path in dict.fromkeys(path for one in named for path in one) if not path.endswith(".angle")]
    goal = scene.goal.response if scene.goal is not None else None
    same = f"links.{getattr(goal, 'of', '')}.{goal.response}" if goal is not None else ""
    inner = tied(scene)
    free = [variable.path for variable in scene.variables if variable.path != same and variable.path not in inner]
    return [*open_positions(scene), *free]


def _tight(point: Point, drawn: Sequence[str]) -> str:
    """Limits that are broken, or of which machines that were drawn tell nothing; else those without any margin."""
    short = point.broken
    unsure = "cannot be told" if point.status == "unproven" else "BROKEN or cannot be told" if short[1:] else "BROKEN"
    broken = [f"{name} {unsure if name in drawn else 'BROKEN'}" for name in short]
    active = [name for name, margin in point.margins.items() if abs(margin) <= ACTIVE]
    return ", ".join(broken or active)
