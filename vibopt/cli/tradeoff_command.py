"""`vibopt tradeoff`: what a better value of one quantity costs of the goal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import click

from vibopt.cli import completing
from vibopt.cli.options import Once, anew, as_json, changes, file, force, limited, read_job, scenario, with_scenario
from vibopt.cli.output import told
from vibopt.cli.sweep_command import MOST_ROWS, columns, value_at
from vibopt.cli.sweep_table import FORMATS, table_text, targets
from vibopt.errors import counted
from vibopt.files.writing import format_of, write_file

if TYPE_CHECKING:
    from vibopt.answer.console import Console
    from vibopt.answer.entry import Entry
    from vibopt.jobs import Job
    from vibopt.study.points import Point
    from vibopt.study.tradeoff import Tradeoff
    from vibopt.study.tradeoff_surface import Surface

STEPS, MOST_LEAPS = 50, 3
"""Steps of a curve; leaps of it that are named."""
MOST_COLUMNS = 4
ROUNDING = 1e-9
"""Part of the greatest value of a column below which one is no more than the rounding of the search."""


@click.command(cls=Once)
@file
@click.option(
    "--against",
    required=True,
    multiple=True,
    metavar="LIMIT",
    shell_complete=completing.changes,
    help='A limit, limits.start_up; a measure, measures.sag; or a response, "displacement of press over 0..3000 rpm". '
    "Given twice, for each bound of the first the curve against the second.",
)
@click.option(
    "--points", type=click.IntRange(min=3), help="Steps of equal length (50; against two of them 7 curves of 7 steps)."
)
@click.option("--csv", "csv_file", metavar="FILE", help="Write the points as a table (SI units, and dB).")
@click.option("--figure", metavar="FILE", help="Draw the curve (.svg, .png, .pdf).")
@click.option("--thorough", is_flag=True, help="All points, whatever the work.")
@limited
@anew
@changes
@scenario
@force
@as_json
def tradeoff(
    file: str,
    against: tuple[str, ...],
    points: int | None,
    csv_file: str | None,
    figure: str | None,
    changes: tuple[str, ...],
    scenario: str | None,
    force: bool,
    thorough: bool,
    as_json: bool,
) -> int:
    """Weigh the goal against a limit, or two: the designs of which none is better in all, from end to end.

    The bound is moved from where the goal has its own best value to the tightest at which a design exists; every
    point is an answer by itself, verified.
    """
    from vibopt.cli.progress import Bar
    from vibopt.study.tradeoff import tradeoff as weigh
    from vibopt.study.tradeoff_surface import USUAL, tradeoff_surface

    job = read_job(file, with_scenario(file, scenario, changes))
    table, picture = targets(csv_file, figure, force=(force, force))
    with Bar() as bar:
        result = (
            weigh(job, against[0], points or STEPS, thorough=thorough, progress=bar)
            if len(against) == 1
            else tradeoff_surface(job, against, points or USUAL, thorough=thorough, progress=bar)
        )
    if table is not None:
        write_file(table, table_text(result).encode())
    if picture is not None:
        from vibopt.report.figures import saved, tradeoff_figure
        from vibopt.study.sweep_series import front_of, fronts_of
        from vibopt.study.tradeoff import Tradeoff

        curves = (front_of(result),) if isinstance(result, Tradeoff) else fronts_of(result)
        write_file(picture, saved(tradeoff_figure(*curves), format_of(picture, FORMATS)))
    written = [str(path) for path in (table, picture) if path is not None]
    told(result, _list if len(against) == 1 else _list_curves, as_json=as_json, written=written)
    return 0


def _list(result: Tradeoff, console: Console) -> None:
    from vibopt.answer.text import paragraph

    open_ones = _headed(result, console, result.fact.path, "", "both")
    last = len(result.points) - 1
    marks = {0: "tightest"} | ({last: "goal's own best"} if result.free else {})
    marks |= {result.knee: "knee"} if result.knee is not None else {}
    _rows(console, result.job, result.points, [(result.name, result.reached)], result.goal, marks)
    spacing = (
        f"Neighbours are no further apart than {50.0 * result.gap:.2g} % of the whole curve, in parts of both spans"
    )
    paragraph(console, f"{spacing}{_leaps(result)}. {_knee(result)}")
    knee = ", and the knee may be elsewhere" if result.knee is not None else ""
    _say_open(open_ones, console, f"others may be better in both there{knee}")
    _say_short(result, console)
    if not result.free:
        further = f"it goes on where {result.name} is loosened further"
        paragraph(console, f"The goal has no best value of its own: {further}.")


def _list_curves(result: Surface, console: Console) -> None:
    from vibopt.answer.text import paragraph

    paths = f"{result.facts[0].path} and {result.facts[1].path}"
    open_ones = _headed(result, console, paths, f" on {counted(len(result.curves), 'curves')}", "all three")
    first, second = result.names
    reached = [(name, [pair[k] for pair in result.reached]) for k, name in enumerate(result.names)]
    _rows(console, result.job, result.points, reached, result.goal, {})
    spacing = f"no further apart than {50.0 * result.gap:.2g} % of that curve, in parts of both spans"
    left = "but where nothing lies between, or only designs that another curve betters"
    paragraph(console, f"At each bound of {first} the curve against {second}: neighbours on it are {spacing}, {left}.")
    _say_open(open_ones, console, "others may be better in all three there")
    _say_short(result, console)


def _headed(result: Tradeoff | Surface, console: Console, against: str, curves: str, every: str) -> int:
    """Title and how many designs there are; how many of them are not proven best."""
    console.print(result.job.title, style="bold")
    open_ones = sum(point.status == "feasible" for point in result.points)
    those = f"none {'of them ' if open_ones else ''}better in {every}"
    console.print(f"{result.goal} against {against}: {counted(len(result.points), 'designs')}{curves}, {those}")
    return open_ones


def _say_open(count: int, console: Console, better: str) -> None:
    from vibopt.answer.text import paragraph

    if count:
        paragraph(
            console, f"{'1 design is' if count == 1 else f'{count} of the designs are'} not proven best: {better}."
        )


def _say_short(result: Tradeoff | Surface, console: Console) -> None:
    """What the work that is done unasked has left out."""
    from vibopt.answer.text import paragraph
    from vibopt.study.moved_bound import ROUGHLY

    if result.short:
        done = f"{counted(result.asked, 'answers')} are about the work that is done unasked"
        paragraph(
            console,
            f"{done}: there are fewer points than asked for, and the ends are found to {100.0 * ROUGHLY:g} %. "
            "`vibopt tradeoff FILE --thorough` finds all.",
        )


def _rows(
    console: Console,
    job: Job,
    points: Sequence[Point],
    reached: Sequence[tuple[str, Sequence[Entry]]],
    goal: str,
    marks: Mapping[int, str],
) -> None:
    """A row for each point, or for one in several: what was reached, the goal, what was chosen, what holds it back."""
    from vibopt.answer.text import grid
    from vibopt.study.tradeoff import weighs

    step = max(1, -(-len(points) // (MOST_ROWS // 3)))
    parts, paths = columns(job, points)
    paths = paths[:MOST_COLUMNS]
    sizes: dict[str, float] = {}
    for one in points:
        sizes |= {path: max(sizes.get(path, 0.0), abs(value.value)) for path, value in one.variables.items()}
    rows = []
    for index, point in enumerate(points):
        mark = marks.get(index, "")
        if index % step == 0 or mark:
            chosen = {path: _shown(value, sizes[path]) for path, value in point.variables.items()}
            values = [*(point.parts.get(path, "-") for path in parts), *(value_at(chosen, path) for path in paths)]
            proof = "not proven" if point.status == "feasible" else ""
            at = [values_of[index] for _, values_of in reached]
            rows.append((*at, point.goal or "-", *values, weighs(point), ", ".join(filter(None, (mark, proof)))))
    names = [name for name, _ in reached]
    heads = (*names, goal, *(path.split(".", 1)[-1] for path in (*parts, *paths)), "Active limits", "")
    console.print(grid(rows, heads, series=True))
    if step > 1:
        console.print(f"One in {step} of the points is shown; --csv FILE writes all of them.")


def _leaps(result: Tradeoff) -> str:
    """Between which neighbours there is nothing, the first of them."""
    both = [
        [(at.shown, best.goal.shown if best.goal is not None else "-")
         for at, best in zip(result.reached[jump : jump + 2], result.points[jump : jump + 2], strict=True)]
        for jump in result.jumps[:MOST_LEAPS]
    ]  # fmt: skip
    ends = [" and ".join(f"{goal} at {at}" for at, goal in two) for two in both]
    more = len(result.jumps) - len(ends)
    return f"; nothing lies between {', '.join(ends)}{f' and at {more} more' if more else ''}" if ends else ""


def _knee(result: Tradeoff) -> str:
    from vibopt.study.tradeoff import KNEE

    if result.knee is None:
        return "There is no knee: no point lies before the straight line between both ends."
    return f"The knee is {KNEE}."


def _shown(value: Entry, size: float) -> Entry:
    """A value in a column of that size, whose rounding is zero."""
    from dataclasses import replace

    return value if abs(value.value) > ROUNDING * size else replace(value, value=0.0)
