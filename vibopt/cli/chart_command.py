"""`vibopt chart`: methods against each other, on known scenes, on hard ground, on smaller models."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from vibopt.cli.options import Once, as_json, force, limited, read_scene
from vibopt.cli.output import colour, say, say_json, width
from vibopt.errors import InputError
from vibopt.files.writing import checked_target, format_of, is_stream, write_file

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from vibopt.answer.console import Console
    from vibopt.charts.trial import Trial
    from vibopt.scene.scene import Scene

FORMATS = (".svg", ".png", ".pdf")
SILENTLY_WRONG, ASKED_LESS = 6, 5
_RANDOM = (
    "isolation", "absorbers", "several", "balancing", "weights", "mounts", "shock", "run_up", "friction", "shafts",
    "studies",
)  # fmt: skip

_files = click.argument("files", metavar="[FILE]...", nargs=-1)
_quick = click.option("--quick", is_flag=True, help="Fewer scenes, methods and runs; which ones is fixed.")
_family = click.option(
    "--family",
    type=click.Choice(["isolation", "absorbers", "balancing", "mounts", "shock", "run_up", "friction"]),
    help="Stock cases of one kind only; all if left out.",
)
_figure = click.option(
    "--figure", metavar="FILE", help="Draw the chart (.svg, .png, .pdf); its data stand beside it as .json and .csv."
)


@click.group()
def chart() -> None:
    """Chart methods against each other: speed and accuracy, stability, profiles, cost, fidelity of the model."""


@chart.command("speed-accuracy", cls=Once)
@_files
@_family
@_quick
@limited
@_figure
@force
@as_json
def speed_accuracy(
    files: tuple[str, ...], family: str | None, quick: bool, figure: str | None, force: bool, as_json: bool
) -> int:
    """Time and true error of every method, on scenes whose answer is known or on problem files.

    True error is the greater of the goal's distance from the best and the worst violation of a limit, both as
    parts; where parts are bought, that is excess price or violation.  Exit code 6 if vibopt itself claims
    anything wrong, 5 if less was asked than the chart promises.
    """
    from vibopt.charts.runner import speed_accuracy as run

    scenes = _scenes(files, family)
    made = partial(run, scenes, family=family, quick=quick)
    result = _charted("accuracy", made, figure, force=force, as_json=as_json)
    return _code(result.trials, cut=result.cut)


@chart.command(cls=Once)
@_family
@_quick
@limited
@_figure
@force
@as_json
def stability(family: str | None, quick: bool, figure: str | None, force: bool, as_json: bool) -> int:
    """How methods fail on hard ground: right, says so, wrong but unproven, or silently wrong.

    Exit code 6 if vibopt itself is ever silently wrong, 5 if less was asked than the chart promises.
    """
    from vibopt.charts.runner import stability as run

    made = partial(run, family=family, quick=quick)
    result = _charted("stability", made, figure, force=force, as_json=as_json)
    return _code(result.trials, cut=result.cut)


@chart.command(cls=Once)
@_files
@_family
@_quick
@limited
@_figure
@force
@as_json
def fidelity(
    files: tuple[str, ...], family: str | None, quick: bool, figure: str | None, force: bool, as_json: bool
) -> int:
    """Freedoms, planes, sensors and speeds declared and needed; error of the smaller model, and time saved.

    Exit code 5 if less was asked than the chart promises.
    """
    from vibopt.charts.runner import fidelity as run

    scenes = _scenes(files, family)
    made = partial(run, scenes, family=family, quick=quick)
    rows = _charted("fidelity", made, figure, force=force, as_json=as_json)
    return ASKED_LESS if any(row.cut for row in rows) else 0


@chart.command(cls=Once)
@click.option("--family", type=click.Choice(_RANDOM), help="One kind only; all if left out.")
@click.option("--seed", type=click.IntRange(0), default=1, show_default=True, help="Which random questions.")
@click.option("--count", type=click.IntRange(1, 10_000), default=50, show_default=True, help="How many of a kind.")
@_quick
@limited
@_figure
@force
@as_json
def profiles(
    family: str | None, seed: int, count: int, quick: bool, figure: str | None, force: bool, as_json: bool
) -> int:
    """Share of random questions that each method answers rightly, against its time (performance profiles).

    A seed gives the same questions on every machine; --quick asks fewer methods.  Exit code 6 if vibopt itself is ever
    silently wrong, 5 if less was asked than the chart promises.
    """
    from vibopt.charts.profiles import profiles as run

    made = partial(run, family, seed=seed, count=count, quick=quick)
    result = _charted("profiles", made, figure, force=force, as_json=as_json)
    trials = [trial for part in result.charts.values() for trial in part.trials]
    return _code(trials, cut=any(trial.cut for trial in trials))


def _charted(name: str, make: Callable[..., Any], figure: str | None, *, force: bool, as_json: bool) -> Any:
    """A chart made, written and said, by what `vibopt.charts.chart_views` has of its name."""
    from vibopt.charts import chart_views as views
    from vibopt.cli.progress import Bar

    targets = _targets(figure, force=force)
    with Bar() as bar:
        result = make(progress=bar)
    data = getattr(views, f"{name}_json")(result)
    _write(targets, data, lambda: getattr(views, f"draw_{name}")(result))
    _say(data, lambda console: getattr(views, f"{name}_table")(result, console), targets, as_json=as_json)
    return result


def _code(trials: Iterable[Trial], *, cut: bool) -> int:
    """Exit code: whether vibopt itself is silently wrong, or less was asked than the chart promises."""
    from vibopt.charts.trial import DEFAULT
    from vibopt.charts.verdicts import SILENT

    if any(trial.verdict == SILENT and trial.method == DEFAULT for trial in trials):
        return SILENTLY_WRONG
    return ASKED_LESS if cut else 0


@chart.command(cls=Once)
@click.option(
    "--ladder",
    type=click.Choice(
        ["bodies", "variables", "absorbers", "limits", "harmonics", "readings", "planes", "parts", "points"]
    ),
    help="What grows; all if left out.",
)
@_quick
@limited
@_figure
@force
@as_json
def cost(ladder: str | None, quick: bool, figure: str | None, force: bool, as_json: bool) -> int:
    """CPU time and memory of whole answers as a job grows, with fitted exponents and their intervals.

    Exit code 5 if less was asked than the chart promises.
    """
    from vibopt.charts import cost_views as views
    from vibopt.charts.cost import cost as run
    from vibopt.cli.progress import Bar

    targets = _targets(figure, force=force)
    with Bar() as bar:
        sizes = run(ladder, quick=quick, progress=bar)
    data = views.cost_json(sizes)
    _write(targets, data, lambda: views.draw_cost(sizes))
    _say(data, lambda console: views.cost_table(sizes, console), targets, as_json=as_json)
    return ASKED_LESS if any(size.cut for size in sizes) else 0


def _scenes(files: tuple[str, ...], family: str | None) -> list[Scene]:
    if files and family:
        raise InputError("--family chooses among the stock cases. Leave it out where files are named.")
    return [_with_goal(file) for file in files]


def _with_goal(file: str) -> Scene:
    """The scene of a file, which must leave something to choose."""
    scene = read_scene(file, "chart", instead="--family balancing charts stock cases of balancing.")
    if not scene.variables:
        raise InputError(f"{file}: nothing is to be chosen here, so there are no methods to compare. Name a design.")
    return scene


def _targets(figure: str | None, *, force: bool) -> tuple[Path, ...]:
    """The figure, and beside it its data as JSON and CSV; the figure alone where it goes to a device."""
    if figure is None:
        return ()
    target = checked_target(figure, FORMATS, force=force)
    beside = () if is_stream(target) else (".json", ".csv")
    return target, *(checked_target(str(target.with_suffix(ending)), force=force) for ending in beside)


def _write(targets: tuple[Path, ...], data: Mapping[str, Any], make: Callable[[], Figure]) -> None:
    """The figure and its data."""
    if not targets:
        return
    from vibopt.answer.jsonable import json_text
    from vibopt.charts.chart_views import csv_text
    from vibopt.files.marks import with_json_check
    from vibopt.report.figures import saved

    write_file(targets[0], saved(make(), format_of(targets[0], FORMATS)))
    for target, text in zip(targets[1:], (with_json_check(json_text(data)), csv_text(data)), strict=False):
        write_file(target, text.encode())


def _say(
    data: Mapping[str, Any], write: Callable[[Console], None], targets: tuple[Path, ...], *, as_json: bool
) -> None:
    if as_json:
        say_json(data)
        return
    from vibopt.answer.text import rendered

    say(rendered(write, width=max(width(), 100), colour=colour()))
    if targets:
        say(f"Written: {', '.join(map(str, targets))}")
