"""`vibopt chart`: methods against each other, on known scenes, on hard ground, on smaller models."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from vibopt.cli.options import Once, as_json, force, limited, read_scene
from vibopt.cli.output import colour, say, say_json, width
from vibopt.errors import InputError
from vibopt.files.writing import checked_target, format_of, write_file

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from rich.console import Console

    from vibopt.charts.fidelity import Fidelity
    from vibopt.charts.runner import Chart
    from vibopt.charts.trial import Case, Trial
    from vibopt.scene.scene import Scene

_SHORT = {
    "branch_and_bound": "b&b",
    "slsqp_50": "slsqp 50",
    "slsqp": "slsqp 200",
    "slsqp_1000": "slsqp 1000",
    "slsqp_exchange": "slsqp exchange",
    "equal_peaks": "equal peaks",
    "trust_constr_50": "trust 50",
    "trust_constr": "trust 200",
    "ipopt_sampled": "ipopt 200",
    "ipopt_sampled_1000": "ipopt 1000",
    "cvxpy_dpp": "cvxpy, kept",
}
"""Names in the figure; the number is that of the sampled speeds."""
FORMATS = (".svg", ".png", ".pdf")
SILENTLY_WRONG, ASKED_LESS = 6, 5
_LONG = 100

_files = click.argument("files", metavar="[FILE]...", nargs=-1)
_quick = click.option("--quick", is_flag=True, help="Fewer scenes, methods and runs; which ones is fixed.")
_family = click.option(
    "--family",
    type=click.Choice(["isolation", "absorbers", "balancing", "mounts"]),
    help="Stock cases of one kind only; all if left out.",
)
_figure = click.option("--figure", metavar="FILE", help="Draw the chart (.svg, .png, .pdf).")


@click.group()
def chart() -> None:
    """Chart methods against each other: speed and accuracy, stability, fidelity of the model."""


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
    from vibopt.charts.trial import DEFAULT
    from vibopt.cli.progress import Bar

    scenes = _scenes(files, family)
    target = checked_target(figure, FORMATS, force=force) if figure is not None else None
    with Bar() as bar:
        result = run(scenes, family=family, quick=quick, progress=bar)
    _draw(target, lambda: _accuracy_figure(result))
    if as_json:
        say_json(_accuracy_json(result))
    else:
        _say(lambda console: _accuracy_table(result, console), target)
    if any(one.fault and one.method == DEFAULT for one in result.trials):
        return SILENTLY_WRONG
    return ASKED_LESS if result.cut else 0


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
    from vibopt.charts.trial import DEFAULT, SILENT
    from vibopt.cli.progress import Bar

    target = checked_target(figure, FORMATS, force=force) if figure is not None else None
    with Bar() as bar:
        result = run(family=family, quick=quick, progress=bar)
    _draw(target, lambda: _stability_figure(result))
    if as_json:
        say_json(_stability_json(result))
    else:
        _say(lambda console: _stability_table(result, console), target)
    if any(one.verdict == SILENT and one.method == DEFAULT for one in result.trials):
        return SILENTLY_WRONG
    return ASKED_LESS if result.cut else 0


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
    from vibopt.cli.progress import Bar

    scenes = _scenes(files, family)
    target = checked_target(figure, FORMATS, force=force) if figure is not None else None
    with Bar() as bar:
        rows = run(scenes, family=family, quick=quick, progress=bar)
    _draw(target, lambda: _fidelity_figure(rows))
    if as_json:
        say_json({"chart": "fidelity", "scenes": list(rows)})
    else:
        _say(lambda console: _fidelity_table(rows, console), target)
    return ASKED_LESS if any(row.cut for row in rows) else 0


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


def _draw(target: Path | None, make: Callable[[], Figure]) -> None:
    if target is not None:
        from vibopt.design.figures import saved

        write_file(target, saved(make(), format_of(target, FORMATS)))


def _say(write: Callable[[Console], None], target: Path | None) -> None:
    from vibopt.answer.text import rendered

    say(rendered(write, width=max(width(), 100), colour=colour()))
    if target is not None:
        say(f"Written: {target}")


def _accuracy_json(result: Chart) -> dict[str, Any]:
    from vibopt.charts.trial import DEFAULT

    trials = [{**_row(one), "ratio": result.ratio(one)} for one in result.trials]
    return {
        "chart": "speed-accuracy",
        "default": DEFAULT,
        "cases": [_about(case) for case in result.cases],
        "trials": trials,
    }


def _about(case: Case) -> dict[str, Any]:
    """A case as plain data, without its text."""
    goal = None if math.isnan(case.goal) else case.goal
    return {
        "name": case.name, "family": case.family, "truth": case.truth, "goal": goal, "known_by": case.known_by,
    }  # fmt: skip


def _stability_json(result: Chart) -> dict[str, Any]:
    cases = [_about(case) for case in result.cases]
    counts = {
        family: {method: dict(result.count(family, method)) for method in result.asked(family)}
        for family in result.families
    }
    trials = [_row(one) for one in result.trials]
    return {"chart": "stability", "counts": counts, "cases": cases, "trials": trials}


def _row(one: Trial) -> dict[str, Any]:
    """A trial as plain data; numbers that do not exist are None."""
    from vibopt.charts.trial import as_row

    return {
        key: None if isinstance(value, float) and math.isnan(value) else value for key, value in as_row(one).items()
    }


def _accuracy_table(result: Chart, console: Console) -> None:
    from vibopt.answer.text import grid, section
    from vibopt.charts.trial import DEFAULT

    console.print("Speed against accuracy", style="bold")
    console.print(
        f"Time is from the job as read to the answer, that of {DEFAULT} checked on the machine as built; kernel: the "
        f"optimiser alone. Ratio: over the time of {DEFAULT} on the same case."
    )
    for case in result.cases:
        rows = [
            (
                one.method,
                _time(one.seconds),
                _time(one.kernel),
                _ratio(result.ratio(one)),
                _part(one.error),
                one.status,
                _note(one),
            )
            for one in result.of(case.name)
        ]
        heads = ("Method", "Time", "Kernel", "Ratio", "True error", "Claims", "Wrong, or why not")
        section(console, f"{case.name} ({case.known_by})", grid(rows, heads, whole=(0, 1, 2, 3, 4)))
    _say_cut(result, console)


def _note(one: Trial) -> str:
    """What is wrong with a claim, why there is none, or how to get a rival that is not there."""
    from vibopt.charts.trial import MISSING

    words = one.cut or (one.claim if one.status in ("error", MISSING) else one.fault)
    return words if len(words) <= _LONG else f"{words[: _LONG - 3]}..."


def _stability_table(result: Chart, console: Console) -> None:
    from vibopt.answer.text import grid, section
    from vibopt.charts.runner import CLASSES
    from vibopt.charts.trial import MISSING, REFUSES

    short = dict(zip(CLASSES, ("right", "says so", "unproven", "WRONG", "refuses"), strict=True))
    console.print("Stability on hard ground", style="bold")
    for methods in dict.fromkeys(result.asked(family) for family in result.families):
        rows = []
        for family in (one for one in result.families if result.asked(one) == methods):
            cells = []
            for method in methods:
                count = result.count(family, method)
                words = [f"{count[name]} {short[name]}" for name in CLASSES if count[name] and name != REFUSES]
                cells.append(", ".join(words) or next(one for one in (REFUSES, MISSING) if count[one]))
            rows.append((family, *cells))
        console.print()
        console.print(grid(rows, ("Family", *(_SHORT.get(method, method) for method in methods))))
    wrong = _worst_faults(result)
    if wrong:
        section(console, "Silently wrong", grid(wrong, ("Method", "Family", "Scenes", "Worst")))
    stops = Counter((one.method, _note(one)) for one in result.trials if one.status == "error")
    if stops:
        rows = [(method, str(count), words) for (method, words), count in stops.items()]
        section(console, "Stopped", grid(rows, ("Method", "Scenes", "With the words")))
    for method, how in {one.method: one.claim for one in result.trials if one.status == MISSING}.items():
        console.print(f"\n{method} is not installed: {how}")
    _say_cut(result, console)


def _say_cut(result: Chart, console: Console) -> None:
    """What was asked less than the chart promises."""
    if result.cut:
        listed = "".join(f"\n  {one.method} on {one.case}: {one.cut}." for one in result.cut)
        console.print(
            f"\nLess was asked than this chart promises, in {len(result.cut)} of {len(result.trials)} runs:{listed}"
        )


def _worst_faults(result: Chart) -> list[tuple[str, str, str, str]]:
    """Per method and family how many scenes are silently wrong, and the worst of them."""
    from vibopt.charts.trial import SILENT

    found = []
    for method in result.methods:
        for family in result.families:
            names = {case.name for case in result.cases if case.family == family}
            trials = [one for one in result.trials if one.method == method and one.case in names]
            wrong = [one for one in trials if one.verdict == SILENT]
            if wrong:
                worst = max(wrong, key=lambda one: math.inf if math.isnan(one.error) else one.error)
                found.append((method, family, f"{len(wrong)} of {len(trials)}", f"{worst.case}: {worst.fault}"))
    return found


def _fidelity_table(rows: tuple[Fidelity, ...], console: Console) -> None:
    from vibopt.answer.text import grid

    console.print("Fidelity: the smaller model against the full one", style="bold")
    heads = ("Scene", "Declared", "Used", "Measuring", "Solving", "Error of values", "Error of goal")
    listed = [
        (
            row.case, str(row.declared), str(row.used), _ratio(row.measuring_full / row.measuring),
            _ratio(row.solving_full / row.solving), _part(row.value_error), _part(row.goal_error),
        )
        for row in rows
    ]  # fmt: skip
    console.print(grid(listed, heads, whole=(0,)))
    console.print("Measuring and solving: time on the full model over time on the smaller one.")
    for row in rows:
        if row.cut:
            console.print(f"Less was asked than this chart promises: {row.case}, {row.cut}")


def _accuracy_figure(result: Chart) -> Figure:
    from vibopt.charts.mount_cases import MOUNTS
    from vibopt.charts.trial import DEFAULT
    from vibopt.design.chart_figures import Dot, Scatter, accuracy_figure

    cases = []
    for case in result.cases:
        ran = result.of(case.name)
        dots = tuple(
            Dot(_SHORT.get(one.method, one.method), result.ratio(one), one.error, bool(one.fault), _kernel(one))
            for one in ran
            if math.isfinite(one.error)
        )
        silent = tuple(_name(one) for one in ran if not math.isfinite(one.error))
        seconds = next((one.seconds for one in ran if one.method == DEFAULT), math.nan)
        error = "excess price or broken limit (part)" if case.family == MOUNTS else "true error (part)"
        cases.append(Scatter(case.name, seconds, dots, silent, error))
    return accuracy_figure(cases, DEFAULT)


def _kernel(one: Trial) -> float:
    """Part of vibopt's time that is the optimiser alone; of the others the whole is nearly that."""
    from vibopt.charts.trial import DEFAULT

    return one.kernel / one.seconds if one.method == DEFAULT else math.nan


def _name(one: Trial) -> str:
    from vibopt.charts.trial import MISSING

    name = _SHORT.get(one.method, one.method)
    return f"{name} ({MISSING})" if one.status == MISSING else name


def _stability_figure(result: Chart) -> Figure:
    from vibopt.charts.runner import CLASSES
    from vibopt.design.chart_figures import stability_figure

    counts = {(f, m): dict(result.count(f, m)) for f in result.families for m in result.asked(f)}
    return stability_figure(result.families, result.methods, counts, CLASSES)


def _fidelity_figure(rows: tuple[Fidelity, ...]) -> Figure:
    from vibopt.design.chart_figures import Bars, fidelity_figure

    return fidelity_figure(
        [
            Bars(
                row.case,
                row.declared,
                row.used,
                row.measuring_full / row.measuring,
                row.solving_full / row.solving,
                row.value_error,
            )
            for row in rows
        ]
    )


def _time(seconds: float) -> str:
    if not math.isfinite(seconds):
        return "-"
    return f"{seconds * 1e3:.3g} ms" if seconds < 1.0 else f"{seconds:.3g} s"


def _ratio(value: float) -> str:
    return f"{value:.3g}" if math.isfinite(value) else "-"


def _part(value: float) -> str:
    if math.isnan(value):
        return "-"
    return "0" if value == 0.0 else f"{value:.1e}" if math.isfinite(value) else "infinite"
