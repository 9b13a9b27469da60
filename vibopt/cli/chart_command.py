"""`vibopt chart`: methods against each other, on known scenes, on hard ground, on smaller models."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from vibopt.cli.options import Named, Once, as_json, force, limited, read_scene
from vibopt.cli.output import note_kept, say, say_json, show
from vibopt.errors import InputError, counted
from vibopt.files.reading import shown_name
from vibopt.files.writing import checked_target, format_of, is_stream, write_file
from vibopt.records import dataclass
from vibopt.work import seconds_of_each_answer

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from vibopt.answer.console import Console
    from vibopt.charts.runner import Chart
    from vibopt.charts.runs import Rows
    from vibopt.files.journal import Journal
    from vibopt.scene.scene import Scene

FORMATS = (".svg", ".png", ".pdf")
SILENTLY_WRONG, ASKED_LESS = 6, 5
_RANDOM = (
    "isolation", "absorbers", "several", "balancing", "weights", "mounts", "shock", "run_up", "friction", "shafts",
    "studies",
)  # fmt: skip

_files = click.argument("files", metavar="[FILE]...", nargs=-1)
_quick = click.option(
    "--quick", is_flag=True, help="Two minutes of work: always the same cases, methods and runs; the others are listed."
)
_resume = click.option("--resume", is_flag=True, help="Go on with the runs of a chart that was stopped.")
_family = click.option(
    "--family",
    type=click.Choice(["isolation", "absorbers", "balancing", "mounts", "shock", "run_up", "friction"]),
    help="Stock cases of one kind only; all if left out.",
)
_figure = click.option(
    "--figure", metavar="FILE", help="Draw the chart (.svg, .png, .pdf); its data stand beside it as .json and .csv."
)


def _options(verb: Callable[..., int]) -> Callable[..., int]:
    """What may be asked of every chart."""
    for option in (as_json, force, _resume, _figure, limited, _quick):
        verb = option(verb)
    return verb


@click.group(cls=Named)
def chart() -> None:
    """Chart methods against each other: speed and accuracy, stability, profiles, cost, fidelity of the model."""


@chart.command("speed-accuracy", cls=Once)
@_files
@_family
@_options
def speed_accuracy(files: tuple[str, ...], family: str | None, quick: bool, **how: Any) -> int:
    """Time and true error of every method, on scenes whose answer is known or on problem files.

    True error is the greater of the goal's distance from the best and the worst violation of a limit, both as
    parts; where parts are bought, that is excess price or violation.  Exit code 6 if vibopt itself claims
    anything wrong, 5 if less was asked than the chart promises.
    """
    from vibopt.charts.runner import speed_accuracy as run

    scenes = _scenes(files, family)
    made = partial(run, scenes, family=family, quick=quick)
    asked = _Asked("accuracy", [family, quick], files, scenes, **how)
    result = _charted(asked, made)
    return _code(result)


@chart.command(cls=Once)
@_family
@_options
def stability(family: str | None, quick: bool, **how: Any) -> int:
    """How methods fail on hard ground: right, says so, wrong but unproven, or silently wrong.

    Exit code 6 if vibopt itself is ever silently wrong, 5 if less was asked than the chart promises.
    """
    from vibopt.charts.runner import stability as run

    made = partial(run, family=family, quick=quick)
    result = _charted(_Asked("stability", [family, quick], **how), made)
    return _code(result)


@chart.command(cls=Once)
@_files
@_family
@_options
def fidelity(files: tuple[str, ...], family: str | None, quick: bool, **how: Any) -> int:
    """Freedoms, planes, sensors and speeds declared and needed; error of smaller or simpler models, and time saved.

    Exit code 5 if less was asked than the chart promises.
    """
    from vibopt.charts.runner import fidelity as run
    from vibopt.charts.runner import fidelity_left

    scenes = _scenes(files, family)
    made = partial(run, scenes, family=family, quick=quick)
    left = fidelity_left(family) if quick and not scenes else ()
    asked = _Asked("fidelity", [family, quick], files, scenes, left, **how)
    rows = _charted(asked, made)
    return ASKED_LESS if left or any(row.cut for row in rows) else 0


@chart.command(cls=Once)
@click.option("--family", type=click.Choice(_RANDOM), help="One kind only; all if left out.")
@click.option("--seed", type=click.IntRange(0), default=1, show_default=True, help="Which random questions.")
@click.option("--count", type=click.IntRange(1, 10_000), help="How many of a kind; 50, with --quick 4.")
@_options
def profiles(family: str | None, seed: int, count: int | None, quick: bool, **how: Any) -> int:
    """Share of random questions that each method answers rightly, against its time (performance profiles).

    A seed gives the same questions on every machine; --quick asks few of each, of fewer methods.  Exit code 6 if vibopt
    itself is ever silently wrong, 5 if less was asked than the chart promises.
    """
    from vibopt.charts.profiles import profiles as run

    made = partial(run, family, seed=seed, count=count, quick=quick)
    result = _charted(_Asked("profiles", [family, seed, count, quick], **how), made)
    return _code(*result.charts.values())


@dataclass
class _Asked:
    """A chart by its name among the views, with its options and all that says where it goes.

    left
        What only the whole chart asks, where its result does not say it.
    """

    name: str
    options: list[Any]
    files: Sequence[str] = ()
    scenes: Sequence[Scene] = ()
    left: tuple[str, ...] = ()
    figure: str | None = None
    resume: bool = False
    force: bool = False
    as_json: bool = False

    @property
    def key(self) -> str:
        """Tells these runs from those of every other chart, program and machine."""
        from vibopt.charts.conditions import conditions
        from vibopt.cli.answer_cache import Asked, program

        here = conditions()
        read = [Asked(file, scene).key("chart") for file, scene in zip(self.files, self.scenes, strict=True)]
        told = [self.name, self.options, seconds_of_each_answer(), read, program(), here.processor, here.versions]
        return sha256(json.dumps(told).encode()).hexdigest()


def _charted(asked: _Asked, make: Callable[..., Any]) -> Any:
    """A chart made, written and said, by what its views have of its name."""
    from vibopt.charts import chart_views, cost_views
    from vibopt.charts.runs import kept
    from vibopt.cli.progress import Bar

    name, views = asked.name, cost_views if asked.name == "cost" else chart_views
    targets = _targets(asked.figure, force=asked.force)
    journal = _journal(asked, targets)
    known = journal.take_up() if journal is not None and asked.resume else []
    try:
        with Bar() as bar, kept(known, journal.add if journal is not None else lambda _: None):
            result = make(progress=bar)
    except KeyboardInterrupt:
        note_kept(_kept_words(journal))
        raise
    data = getattr(views, f"{name}_json")(result)
    data |= {"left": list(asked.left)} if asked.left else {}

    def written(console: Console) -> None:
        getattr(views, f"{name}_table")(result, console)
        chart_views.say_left(asked.left, console)

    _write(targets, data, lambda: getattr(views, f"draw_{name}")(result))
    if journal is not None:
        journal.end()
    _say(data, written, targets, as_json=asked.as_json)
    return result


def _journal(asked: _Asked, targets: Sequence[Path]) -> Journal[Rows] | None:
    """Where the runs are kept as they come: beside the figure, None without one."""
    from vibopt.files.journal import Journal

    if len(targets) < 2:
        if asked.resume:
            raise InputError("--resume goes on with the runs beside a --figure FILE. Name it.")
        return None
    journal: Journal[Rows] = Journal(
        targets[0].with_name(f"{targets[0].name}.runs"), "chart", asked.key,
        others="another chart, other options, another machine", option="--figure", told=list,
        made=lambda told: (str(told[0]), list(told[1])),
    )  # fmt: skip
    journal.check()
    return journal


def _kept_words(journal: Journal[Rows] | None) -> str:
    """What is left of a chart that was stopped."""
    if journal is None:
        return "No run was kept: with --figure FILE each is written as it comes."
    count = len(journal.items)
    if not count:
        return ""
    held = f"{shown_name(journal.target)} holds {counted(count, 'runs')}"
    return f"{held}; the same command with --resume goes on."


def _code(*charts: Chart) -> int:
    """Exit code: whether vibopt itself is silently wrong, or less was asked than the charts promise."""
    from vibopt.charts.trial import DEFAULT
    from vibopt.charts.verdicts import SILENT

    if any(trial.verdict == SILENT and trial.method == DEFAULT for one in charts for trial in one.trials):
        return SILENTLY_WRONG
    return ASKED_LESS if any(one.cut or one.left for one in charts) else 0


@chart.command(cls=Once)
@click.option(
    "--ladder",
    type=click.Choice(
        ["bodies", "variables", "absorbers", "limits", "harmonics", "readings", "planes", "parts", "points"]
    ),
    help="What grows; all if left out.",
)
@_options
def cost(ladder: str | None, quick: bool, **how: Any) -> int:
    """CPU time and memory of whole answers as a job grows, with fitted exponents and their intervals.

    Exit code 5 if less was asked than the chart promises.
    """
    from vibopt.charts.cost import cost as run
    from vibopt.charts.cost import cost_left

    left = cost_left(ladder) if quick else ()
    asked = _Asked("cost", [ladder, quick], left=left, **how)
    sizes = _charted(asked, partial(run, ladder, quick=quick))
    return ASKED_LESS if left or any(size.cut for size in sizes) else 0


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
    show(write, least=100)
    if targets:
        say(f"Written: {', '.join(map(str, targets))}")
