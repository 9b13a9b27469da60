"""The charts as tables, as plain data and as figures."""

from __future__ import annotations

import csv
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from io import StringIO
from statistics import median
from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.answer import jsonable
from vibopt.answer.text import grid, section
from vibopt.charts.conditions import conditions
from vibopt.charts.fidelity import Fidelity
from vibopt.charts.mount_cases import MOUNTS
from vibopt.charts.profiles import EXACT, FAIR, Profiles, times
from vibopt.charts.runner import Chart
from vibopt.charts.trial import DEFAULT, Case, Trial, as_row, setting_of
from vibopt.charts.verdicts import CLASSES, MISSING, REFUSES, SILENT

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from vibopt.answer.console import Console
    from vibopt.charts.cost import Size

_SHORT = {"branch_and_bound": "b&b", "equal_peaks": "equal peaks"}
"""Names in the figures; a number behind a name is a setting."""
_LONG = 100


def _json(name: str, *charts: Chart, ratios: bool = True, **more: Any) -> dict[str, Any]:
    """Cases and trials of charts as plain data, with their times over that of the default."""
    return {
        "chart": name, "conditions": conditions(), **more, "left": [line for chart in charts for line in chart.left],
        "cases": [_about(case) for chart in charts for case in chart.cases],
        "trials": [{**as_row(trial), **({"ratio": chart.ratio(trial)} if ratios else {})}
                   for chart in charts for trial in chart.trials],
    }  # fmt: skip


def _counts(chart: Chart, family: str, methods: Sequence[str]) -> dict[str, dict[str, int]]:
    """How often each class occurs, by method."""
    return {method: dict(chart.count(family, method)) for method in methods}


def accuracy_json(result: Chart) -> dict[str, Any]:
    """Trials with their times over that of the default, as plain data."""
    return _json("speed-accuracy", result, default=DEFAULT)


def stability_json(result: Chart) -> dict[str, Any]:
    """Trials, and how often each class occurs by family and method, as plain data."""
    counts = {family: _counts(result, family, result.asked(family)) for family in result.families}
    return _json("stability", result, ratios=False, counts=counts)


def profiles_json(result: Profiles) -> dict[str, Any]:
    """Trials on random questions, as plain data."""
    counts = {family: _counts(chart, family, chart.methods) for family, chart in result.charts.items()}
    return _json("profiles", *result.charts.values(), seed=result.seed, count=result.count, counts=counts)


def _about(case: Case) -> dict[str, Any]:
    """A case as plain data, with its problem file, so that any row can be asked again."""
    goal = None if math.isnan(case.goal) else case.goal
    return {
        "name": case.name, "family": case.family, "truth": case.truth, "goal": goal, "known_by": case.known_by,
        "text": case.text, "beside": dict(case.beside),
    }  # fmt: skip


def fidelity_json(rows: tuple[Fidelity, ...]) -> dict[str, Any]:
    """Rows as plain data."""
    return {"chart": "fidelity", "conditions": conditions(), "scenes": list(rows)}


def csv_text(data: Mapping[str, Any]) -> str:
    """The rows of a chart's plain data as a table, each with the conditions at its end."""
    plain = jsonable.plain(data)
    rows = plain.get("trials") or plain["scenes"]
    stream = StringIO()
    write = csv.writer(stream, lineterminator="\n").writerow
    write(["chart", *rows[0], "conditions"])
    for row in rows:
        write([plain["chart"], *map(_cell, row.values()), data["conditions"].words])
    return stream.getvalue()


def _cell(value: Any) -> Any:
    return "..".join(f"{one}" for one in value if one is not None) if isinstance(value, list) else value


def accuracy_table(result: Chart, console: Console) -> None:
    """A table a case: time, kernel, true error, and what is wrong with a claim."""
    console.print("Speed against accuracy", style="bold")
    console.print(
        f"Time is from the job as read to the answer, that of {DEFAULT} checked on the machine as built; kernel: the "
        f"optimiser alone. Ratio: over the time of {DEFAULT} on the same case. Times are CPU seconds, "
        f"which a busy machine hardly changes, and medians; ± is half the distance between their quartiles."
    )
    console.print(conditions().words)
    for case in result.cases:
        rows = [
            (
                trial.method,
                time_of(trial.seconds) + spread(trial),
                time_of(trial.kernel),
                _ratio(result.ratio(trial)),
                _part(trial.error),
                trial.status,
                _note(trial),
            )
            for trial in result.of(case.name)
        ]
        heads = ("Method", "Time", "Kernel", "Ratio", "True error", "Claims", "Wrong, or why not")
        section(console, f"{case.name} ({case.known_by})", grid(rows, heads, whole=(0, 1, 2, 3, 4)))
    say_left(result.left, console)
    _say_cut(result, console)


def _note(trial: Trial) -> str:
    """What is wrong with a claim, why there is none, or how to get a rival that is not there."""
    words = trial.cut or (trial.claim if trial.status in ("error", MISSING) else trial.fault)
    return words if len(words) <= _LONG else f"{words[: _LONG - 3]}..."


def stability_table(result: Chart, console: Console) -> None:
    """Families by methods, with the worst of what is silently wrong below."""
    brief = dict(zip(CLASSES, ("right", "says so", "unproven", "WRONG", "refuses"), strict=True))
    console.print("Stability on hard ground", style="bold")
    console.print(conditions().words)
    for methods in dict.fromkeys(result.asked(family) for family in result.families):
        rows = []
        for family in (one for one in result.families if result.asked(one) == methods):
            cells = []
            for method in methods:
                count = result.count(family, method)
                words = [f"{count[name]} {brief[name]}" for name in CLASSES if count[name] and name != REFUSES]
                cells.append(", ".join(words) or next(one for one in (REFUSES, MISSING) if count[one]))
            rows.append((family, *cells))
        console.print()
        console.print(grid(rows, ("Family", *map(short, methods))))
    wrong = _worst_faults(result)
    if wrong:
        section(console, "Silently wrong", grid(wrong, ("Method", "Family", "Scenes", "Worst")))
    stops = Counter((trial.method, _note(trial)) for trial in result.trials if trial.status == "error")
    if stops:
        rows = [(method, str(count), words) for (method, words), count in stops.items()]
        section(console, "Stopped", grid(rows, ("Method", "Scenes", "With the words")))
    say_left(result.left, console)
    for method, how in {trial.method: trial.claim for trial in result.trials if trial.status == MISSING}.items():
        console.print(f"\n{method} is not installed: {how}")
    _say_cut(result, console)


def profiles_table(result: Profiles, console: Console) -> None:
    """A table a family: classes of the answers, how many are exact, and the time beside the default's."""
    console.print("Profiles over random questions", style="bold")
    console.print(
        f"{result.count} questions a family, seed {result.seed}; CPU seconds, 1 run each. Within 1e-6 and "
        f"1e-3: by true error. Ratio: median "
        f"time over that of {DEFAULT} on the same question."
    )
    console.print(conditions().words)
    heads = (
        "Method",
        "Right",
        "Says so",
        "Unproven",
        "Silently wrong",
        "Refuses",
        "Within 1e-6",
        "Within 1e-3",
        "Ratio",
    )
    for family, chart in result.charts.items():
        fine, fair = times(chart, EXACT), times(chart, FAIR)
        rows = []
        for method in chart.methods:
            count = chart.count(family, method)
            ratios = [
                chart.ratio(trial) for trial in chart.trials if trial.method == method and trial.status != REFUSES
            ]
            good = sorted(ratio for ratio in ratios if math.isfinite(ratio))
            within = (str(int(np.isfinite(one[method]).sum())) for one in (fine, fair))
            rows.append((method, *(str(count[name]) for name in CLASSES), *within, _ratio(median(good or [math.nan]))))
        section(console, family, grid(rows, heads, whole=(0,)))
        say_left(chart.left, console)
        _say_cut(chart, console)


def draw_profiles(result: Profiles) -> Figure:
    """A row of panels a family: share answered to 1e-6 and to 1e-3 over time ratios, and to 1e-6 over CPU seconds."""
    from vibopt.charts.chart_figures import profiles_figure

    rows = {
        family: tuple(
            {short(method): row for method, row in made.items() if np.isfinite(row).any()}
            for made in (times(chart, EXACT), times(chart, FAIR), times(chart, EXACT, absolute=True))
        )
        for family, chart in result.charts.items()
    }
    asked = f"Seed {result.seed}, {result.count} questions a family; CPU seconds, 1 run each. "
    return profiles_figure(rows, result.count, DEFAULT, asked + conditions().words)


def say_left(left: Sequence[str], console: Console) -> None:
    """What a shorter chart does not ask."""
    if left:
        console.print(f"\nAsked without --quick only: {'; '.join(left)}.")


def _say_cut(result: Chart, console: Console) -> None:
    """What was asked less than the chart promises."""
    if result.cut:
        listed = "".join(f"\n  {trial.method} on {trial.case}: {trial.cut}." for trial in result.cut)
        console.print(
            f"\nLess was asked than this chart promises, in {len(result.cut)} of {len(result.trials)} runs:{listed}"
        )


def _worst_faults(result: Chart) -> list[tuple[str, str, str, str]]:
    """Per method and family how many scenes are silently wrong, and the worst of them."""
    found = []
    for method in result.methods:
        for family in result.families:
            names = {case.name for case in result.cases if case.family == family}
            trials = [trial for trial in result.trials if trial.method == method and trial.case in names]
            wrong = [trial for trial in trials if trial.verdict == SILENT]
            if wrong:
                worst = max(wrong, key=lambda one: math.inf if math.isnan(one.error) else one.error)
                found.append((method, family, f"{len(wrong)} of {len(trials)}", f"{worst.case}: {worst.fault}"))
    return found


def fidelity_table(rows: tuple[Fidelity, ...], console: Console) -> None:
    """Declared and used, time saved and error, row by row."""
    console.print("Fidelity: the smaller model against the full one", style="bold")
    heads = ("Scene", "Declared", "Used", "Measuring", "Solving", "Noise", "Error of values", "Error of goal")
    listed = [
        (
            row.case, *row.counts, *map(_ratio, (*row.saved, row.noise)), _part(row.value_error), _part(row.goal_error),
        )
        for row in rows
    ]  # fmt: skip
    console.print(grid(listed, heads, whole=(0,)))
    console.print(
        "Measuring and solving: CPU time on the full model over that on the smaller one. Noise: greatest factor "
        "between runs of the same model; what is nearer to 1 says nothing."
    )
    console.print(conditions().words)
    for row in rows:
        if row.cut:
            console.print(f"Less was asked than this chart promises: {row.case}, {row.cut}")


def draw_accuracy(result: Chart) -> Figure:
    """True error over time, a panel a case."""
    from vibopt.charts.accuracy_figure import Dot, Scatter, accuracy_figure

    cases = []
    for case in result.cases:
        ran = result.of(case.name)
        dots = tuple(
            Dot(
                short(trial.method),
                result.ratio(trial),
                trial.error,
                trial.verdict,
                _kernel(trial),
                _setting(trial.method)[0],
                _middle(result, trial),
            )
            for trial in sorted(ran, key=lambda one: _setting(one.method))
            if math.isfinite(trial.error)
        )
        silent = tuple(_name(trial) for trial in ran if not math.isfinite(trial.error))
        seconds = next((trial.seconds for trial in ran if trial.method == DEFAULT), math.nan)
        error = "excess price or broken limit (part)" if case.family == MOUNTS else "true error (part)"
        cases.append(Scatter(case.name, seconds, dots, silent, error))
    runs = sorted({trial.runs for trial in result.trials if trial.runs})
    how = f"CPU seconds, median of {' or '.join(map(str, runs))} runs, bars over the middle half. " if runs else ""
    return accuracy_figure(cases, DEFAULT, how + conditions().words)


def short(method: str) -> str:
    """The name in a figure."""
    return _SHORT.get(method, method)


def _middle(result: Chart, trial: Trial) -> tuple[float, float]:
    low, high = trial.quartiles
    part = result.ratio(trial) / trial.seconds
    return (low * part, high * part) if trial.runs > 2 else (math.nan, math.nan)


def _setting(method: str) -> tuple[str, float]:
    """A rival that is asked at several settings, and how fine it is: numbers of speeds, or 1 over a tolerance."""
    line, setting = setting_of(method)
    number = float(setting or 1.0)
    return line, number if number >= 1.0 else 1.0 / number


def _kernel(trial: Trial) -> float:
    """Part of vibopt's time that is the optimiser alone; of the others the whole is nearly that."""
    return trial.kernel / trial.seconds if trial.method == DEFAULT else math.nan


def _name(trial: Trial) -> str:
    name = short(trial.method)
    return f"{name} ({MISSING})" if trial.status == MISSING else name


def draw_stability(result: Chart) -> Figure:
    """Families by methods, filled by class."""
    from vibopt.charts.chart_figures import stability_figure

    found = {(family, short(method)): result.verdicts(family, method)
             for family in result.families for method in result.asked(family)}  # fmt: skip
    words = "Each cell: the cases of a family in the order of its table, mostly from mild to severe. "
    return stability_figure(result.families, [*map(short, result.methods)], found, words + conditions().words)


def draw_fidelity(rows: tuple[Fidelity, ...]) -> Figure:
    """What is declared and used, time saved, error."""
    from vibopt.charts.chart_figures import fidelity_figure

    return fidelity_figure(rows, conditions().words)


def time_of(seconds: float) -> str:
    """CPU seconds as shown; "-" where there are none."""
    if not math.isfinite(seconds):
        return "-"
    return f"{seconds * 1e3:.3g} ms" if seconds < 1.0 else f"{seconds:.3g} s"


def spread(one: Trial | Size) -> str:
    """Half of the distance between the quartiles, as a part of the median."""
    low, high = one.quartiles
    return f" ±{50.0 * (high - low) / one.seconds:.0f} %" if one.runs > 2 else ""


def _ratio(value: float) -> str:
    return f"{value:.3g}" if math.isfinite(value) else "-"


def _part(value: float) -> str:
    if math.isnan(value):
        return "-"
    return "0" if value == 0.0 else f"{value:.1e}" if math.isfinite(value) else "infinite"
