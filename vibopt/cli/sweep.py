"""`vibopt sweep`: one fact varied over a range."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from io import StringIO
from typing import TYPE_CHECKING, Any

import click

from vibopt.cli.options import as_json, file, keep_design, limited, read_scene
from vibopt.cli.output import checked_target, colour, say, say_json, width, write_file
from vibopt.errors import InputError

if TYPE_CHECKING:
    from rich.console import Console

    from vibopt.design.design import Shown
    from vibopt.study.sweep import Sweep

FORMATS = (".svg", ".png", ".pdf")
UNPROVEN = 5
MOST_ROWS = 60


@click.command()
@file
@click.option(
    "--vary", required=True, metavar='PATH="LOW..HIGH"', help='As in --vary limits.start_up.at_most="5 mm..30 mm".'
)
@click.option("--points", type=click.IntRange(2, 100_000), default=50, show_default=True, help="How many values.")
@click.option("--csv", "csv_file", metavar="FILE", help="Write the points as a table (SI units, and dB).")
@click.option("--figure", metavar="FILE", help="Draw the points (.svg, .png, .pdf).")
@keep_design
@limited
@as_json
def sweep(
    file: str, vary: str, points: int, csv_file: str | None, figure: str | None, keep_design: bool, as_json: bool
) -> int:
    """Vary one fact over a range, and answer at every point.

    Exit code 5 unless every point has a proven or checked answer.
    """
    from vibopt.cli.progress import Bar
    from vibopt.study.sweep import sweep as run

    table = checked_target(csv_file) if csv_file else None
    picture = checked_target(figure, FORMATS) if figure else None
    path, low_high = split_range(vary)
    scene = read_scene(file, "sweep", instead="Solve the file with several values of --set PATH=VALUE.")
    with Bar() as bar:
        result = run(scene, path, low_high, points, keep_design=keep_design, progress=bar)
    if table is not None:
        write_file(table, csv_text(result).encode())
    if picture is not None:
        from vibopt.design.figures import saved, strips_figure
        from vibopt.study.strips import strips

        write_file(picture, saved(strips_figure(strips(result)), picture.suffix[1:].lower()))
    written = [str(one) for one in (table, picture) if one is not None]
    if as_json:
        status = "ok" if result.complete else "unproven"
        say_json({"status": status, "path": path, "written": written, **_points(result)})
    else:
        from vibopt.design.table import rendered

        say(rendered(lambda console: _list(result, console), width=width(), colour=colour()))
        for one in written:
            say(f"Written: {one}")
    return 0 if result.complete else UNPROVEN


def split_range(given: str) -> tuple[str, str]:
    """Path and range text of --vary."""
    path, sign, low_high = given.partition("=")
    if not (sign and path.strip() and low_high.strip()):
        raise InputError(f'--vary {given}: is no PATH=LOW..HIGH. Write --vary limits.start_up.at_most="5 mm..30 mm".')
    return path.strip(), low_high.strip()


def _points(result: Sweep) -> dict[str, Any]:
    from vibopt.design.jsonable import plain

    return {"goal": result.goal, "keep_design": result.keep_design, "points": plain(result.points)}


def csv_text(result: Sweep) -> str:
    """Points as comma-separated values: numbers in SI or dB, units in the head; margins as parts of the bound."""
    from vibopt.design.jsonable import number

    points = list(result.points)
    units = {path: one.unit for point in points for path, one in point.variables.items()}
    paths = list(units)
    names = list(dict.fromkeys(name for point in points for name in point.margins))
    goal = next((point.goal for point in points if point.goal is not None), None)
    stream = StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    fact, asked = result.fact, result.scene.goal.response if result.scene.goal is not None else None
    head = [_head(result.path, _unit(fact.unit, points[0].value.unit)), "status"]
    goal_unit = _unit((asked.unit if asked else "") or "", goal.unit) if goal is not None else ""
    head += [_head(result.goal or "goal", goal_unit)] if goal is not None else []
    parts = list(dict.fromkeys(path for point in points for path in point.parts))
    head += parts
    writer.writerow([*head, *(_head(path, units[path]) for path in paths), *(f"margin of {name}" for name in names)])
    for point in points:
        goals = [] if goal is None else ["" if point.goal is None else _number(point.goal, goal_unit)]
        chosen = ["" if path not in point.variables else number(point.variables[path].value) for path in paths]
        margins = ["" if name not in point.margins else number(point.margins[name]) for name in names]
        bought = [point.parts.get(path, "") for path in parts]
        writer.writerow([_number(point.value, fact.unit), point.status, *goals, *bought, *chosen, *margins])
    return stream.getvalue()


def _unit(users: str, si: str) -> str:
    """Unit of a column: SI, but dB where the user counts in dB."""
    return users if users == "dB" else si


def _number(shown: Shown, unit: str) -> float | str | None:
    from vibopt.design.jsonable import number
    from vibopt.units import to_unit

    if unit != "dB":
        return number(shown.value)
    return number(round(to_unit(shown.value, unit, "ratio"), 12)) if shown.value > 0.0 else None


def _head(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit else name


def _list(result: Sweep, console: Console) -> None:
    from vibopt.design.table import grid

    console.print(result.scene.title, style="bold")
    parts = list(dict.fromkeys(path for point in result.points for path in point.parts))
    paths = _columns(result)
    step = max(1, -(-len(result.points) // MOST_ROWS))
    rows = []
    for point in result.points[::step]:
        values = [point.variables[path].shown if path in point.variables else "-" for path in paths]
        goal = [point.goal.shown if point.goal is not None else "-"] if result.goal else []
        bought = [point.parts.get(path, "-") for path in parts]
        rows.append((point.value.shown, point.status, *goal, *bought, *values, _tight(point.margins)))
    names = [path.split(".", 1)[-1] for path in (*parts, *paths)]
    heads = ("Value", "Verdict", *([result.goal] if result.goal else []), *names, "Active limits")
    console.print(f"{result.path} varied")
    console.print(grid(rows, heads))
    if step > 1:
        console.print(f"Every {step}th of {len(result.points)} points; --csv FILE writes all of them.")


def _columns(result: Sweep) -> list[str]:
    """Paths of the variables to list: none for a kept design, and not the one that is the goal itself."""
    from vibopt.design.shelf import tied
    from vibopt.scene.positions import open_positions

    scene = result.scene
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
