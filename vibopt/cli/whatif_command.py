"""`vibopt whatif`: the old answer beside the new."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import click

from vibopt.cli import completing
from vibopt.cli.options import Once, anew, as_json, changes_of, file, keep_design, limited, read_job, rounding, workers
from vibopt.cli.output import told
from vibopt.errors import InputError

if TYPE_CHECKING:
    from vibopt.answer.answer import Answer
    from vibopt.answer.console import Console
    from vibopt.answer.entry import Checked, Entry
    from vibopt.jobs import Job
    from vibopt.scene.scene import Design
    from vibopt.solve.method import Progress
    from vibopt.study.prices import Prices
    from vibopt.study.remedies import Remedies
    from vibopt.study.thresholds import Threshold
    from vibopt.study.whatif import WhatIf


@click.command(cls=Once)
@file
@click.option(
    "--set",
    "changes",
    metavar="PATH=VALUE",
    multiple=True,
    shell_complete=completing.changes,
    help="A change; may be repeated.",
)
@keep_design
@rounding
@click.option("--thorough", is_flag=True, help="Without --set: every number, whatever the work.")
@workers
@limited
@anew
@as_json
def whatif(
    file: str,
    changes: tuple[str, ...],
    keep_design: bool,
    rounding: tuple[str, ...],
    thorough: bool,
    workers: int,
    as_json: bool,
) -> int:
    """Change facts or limits, and see the old answer beside the new.

    Without --set: what to argue about, every limit and fact ranked by what a step of it buys, both ways, over
    which range, and what takes over then; where there is no design, which number changed alone gives one.
    With --keep-design the old design stays: which limits break under the changes, and how far each fact may
    go; with --round it stays with rounded values.  Exit code: that of the new answer.
    """
    from vibopt.cli.progress import Bar
    from vibopt.study.whatif import whatif as compare

    job = read_job(file)
    if not changes:
        return _ranked(job, thorough, as_json, workers, kept=keep_design or bool(rounding))
    if thorough:
        raise InputError("--thorough goes without --set: two answers are all there is. Leave one of them out.")
    if workers > 1:
        raise InputError("--workers goes without --set: two answers are all there is. Leave one of them out.")
    new = changes_of(changes)
    with Bar() as bar:
        result = compare(job, new, keep_design=keep_design, rounding=rounding, progress=bar)
    told(result, _tell, as_json=as_json, status=result.after.status)
    return result.after.exit_code


def _ranked(job: Job, thorough: bool, as_json: bool, workers: int, *, kept: bool) -> int:
    """What each number of the file buys or costs, what to argue about first on top."""
    from vibopt.cli.progress import Bar
    from vibopt.study.prices import answered, prices
    from vibopt.study.remedies import without_design
    from vibopt.study.sweep import pool_of

    if kept:
        raise InputError("--keep-design and --round go with --set. Name a change: --set PATH=VALUE.")
    with Bar() as bar:
        here = answered(job)
        if without_design(job, here):
            return _mended(job, thorough, as_json, bar)
        with pool_of(workers) as pool:
            found = prices(job, found=here, thorough=thorough, pool=pool, progress=bar)
    told(found, _tell_prices, as_json=as_json, status=here.status)
    return here.exit_code


def _tell_prices(prices: Prices, console: Console) -> None:
    from vibopt.answer.text import grid, section
    from vibopt.study.price_words import HEADS, range_rows, rows_of

    console.print(prices.job.title, style="bold")
    console.print(prices.first)
    title = f"What to argue about: {prices.measure} is {prices.shown}"
    section(console, title, grid(rows_of(prices), HEADS, whole=(1, 2, 3)))
    if ranges := list(range_rows(prices)):
        section(console, "How far that goes on, and what takes over", grid(ranges))
    if prices.notes:
        section(console, "Notes", grid([(note,) for note in prices.notes]))


def _mended(job: Job, thorough: bool, as_json: bool, bar: Progress) -> int:
    """Where there is no design: why, and which number, changed alone, gives one."""
    from vibopt.jobs import answer, is_scene
    from vibopt.study.nearest import with_nearest
    from vibopt.study.remedies import remedies

    whole: Any = answer(job)
    found = remedies(job, found=with_nearest(whole) if is_scene(job) else whole, thorough=thorough, progress=bar)
    told(found, _tell_remedies, as_json=as_json, status=found.found.status)
    return found.found.exit_code


def _tell_remedies(mended: Remedies, console: Console) -> None:
    from vibopt.answer.text import grid, paragraph, section, show, verdict
    from vibopt.answer.views import views_of
    from vibopt.jobs import is_scene
    from vibopt.report.machine_words import conflict_words

    answer = mended.found
    console.print(mended.job.title, style="bold")
    console.print(verdict(answer))
    said = conflict_words(replace(answer, nearest=None)) if is_scene(mended.job) else ()
    for text in (answer.reason, *said, mended.first):
        if text:
            paragraph(console, text)
    if mended.helpful:
        heads = ("Number", "Change", "", "Goal then")
        kept = (0, 2, 3) if max(len(line[0]) for line in mended.lines) <= _LONG else (1, 2, 3)
        section(console, "What would help, each by itself", grid(mended.lines, heads, whole=kept))
    for text in (mended.useless, *mended.notes):
        if text:
            paragraph(console, text)
    for block in views_of(answer).nearest_blocks(answer):
        show(block, console)


def _tell(result: WhatIf, console: Console) -> None:
    """Changes, then both answers side by side, then what breaks."""
    from vibopt.answer.text import grid, section
    from vibopt.document.toml_reading import as_wide, inside
    from vibopt.report.machine_words import listed
    from vibopt.study.seen import reason
    from vibopt.study.whatif import unfollowed

    console.print(result.job.title, style="bold")
    job = result.job
    new = {path: as_wide(inside(job.document, path), one) for path, one in result.changes.items()}  # tolerances stay
    console.print(grid([(path, f"{_old(job, path)} -> {_written(one)}") for path, one in new.items()]))
    section(console, "Before and after", grid(_beside(result), ("", "Before", "After")))
    for name, answer in (("before", result.before), ("after", result.after)):
        if words := reason(answer):
            console.print(f"  {name}: {words}")
    if result.keep_design:
        names = listed([f'"{name}"' for name in result.breaks])
        console.print(f"\nThe design kept breaks {names}." if names else "\nThe design kept breaks no limit that held.")
        if result.thresholds:
            _say_thresholds(result, console)
        elif words := unfollowed(result.job):
            console.print(words)


def _written(value: object) -> str:
    """A value as a file has it; a range by its ends."""
    if isinstance(value, dict):
        ends = [str(value[key]) for key in ("from", "to") if key in value]
        if len(ends) == len(value) == 2:
            return " to ".join(ends)
        return f"{{ {', '.join(f'{key} = {_written(one)}' for key, one in value.items())} }}"
    if isinstance(value, list):
        return f"[{', '.join(map(_written, value))}]"
    return str(value).lower() if isinstance(value, bool) else str(value)


def _old(job: Job, path: str) -> str:
    """What stood at a path, also where it is a part of a text."""
    from vibopt.document.toml_reading import inside
    from vibopt.jobs import part_at
    from vibopt.study.seen import shown_value

    here = inside(job.document, path)
    part = part_at(job, path) if here is None else None
    return _written(here) if here is not None else "not given" if part is None else shown_value(part, part.value).shown


def _beside(result: WhatIf) -> list[tuple[str, ...]]:
    """One row for each thing that either answer has, those of the answer before first."""
    from vibopt.jobs import with_changes

    changed = with_changes(result.job, result.changes)
    both = [_cells(job, answer, result) for job, answer in ((result.job, result.before), (changed, result.after))]
    paths = list(both[0])
    for before, path in pairwise(both[1]):
        if path not in both[0]:  # an angle of a weight that was none, beside the weight
            paths.insert(paths.index(before) + 1, path)
    names = [_name(path) for path in paths]
    said = (name if names.count(name) == 1 else path for path, name in zip(paths, names, strict=True))
    return [(name, *(one.get(path, "-") for one in both)) for path, name in zip(paths, said, strict=True)]


def _name(path: str) -> str:
    """What a row is called where no other has the name: goal, limits and measures by their own."""
    family, _, name = path.partition(".")
    return name if family in ("goal", "limits", "measures") else path


def _cells(job: Job, answer: Answer[Any], result: WhatIf) -> dict[str, str]:
    """What an answer is compared by, by paths; of a design that is kept not what was chosen."""
    from vibopt.jobs import is_scene
    from vibopt.study.seen import chosen, goal_of, results
    from vibopt.verify.measured_goal import MEASURED

    cells = {"verdict": answer.status}
    if is_scene(job) and job.find_all is not None:
        cells[job.find_all] = _intervals(answer)
    goal = goal_of(job, answer)
    became = [name for name in MEASURED.values() if result.keep_design and name in result.after.measures]
    if goal is not None and answer.goal is not None and not (became or (result.keep_design and is_scene(job))):
        cells[f"goal.{answer.goal[0]}"] = goal.shown
    taken = {} if result.keep_design else chosen(job, answer)
    cells |= {path: one.shown for path, one in taken.items()}
    if goal is not None:  # what a kept design measures was the goal before
        cells |= {f"measures.{name}": goal.shown for name in became}
    rows = {f"limits.{name}": row for name, row in answer.limits.items()}
    rows |= {f"measures.{name}": row for name, row in answer.measures.items()}
    cells |= {path: _cell(row, told=answer.found is None) for path, row in rows.items()}
    few = not (result.before.limits or result.before.measures)
    return cells | ({path: entry.shown for path, entry in results(job, answer).items()} if few and not taken else {})


def _intervals(design: Design) -> str:
    """What `find_all` found, one interval a line."""
    from vibopt.report.machine_words import interval

    if design.found is None:
        return "-"
    return "\n".join(interval(*one) for one in design.found) or "none"


def _cell(checked: Checked, *, told: bool) -> str:
    """The worst and where; among speeds yet to be told apart no limit is broken."""
    from vibopt.answer.blocks import value_at

    state = checked.state if checked.limit is not None and told else ""
    return f"{value_at(checked)}{f', {state}' if state else ''}"


_LONG = 40
"""Letters of a path up to which it is not broken beside its numbers."""


def _say_thresholds(result: WhatIf, console: Console) -> None:
    """Facts that can break a limit, then those that cannot, then how that was found."""
    from vibopt.answer.text import grid, paragraph, section
    from vibopt.study.thresholds import METHOD

    heads = ("Fact", "Now", "Fails below", "Fails above")
    rows = _thresholds(result)
    kept = (0,) if max((len(row[0]) for row in rows), default=0) <= _LONG else (1,)  # long paths give way to numbers
    when = "" if result.after.status == "met" else ", from the facts as they were before the change"
    section(
        console, f"How far each fact may go{when}", grid(rows, heads, whole=kept) if rows else "as far as was looked"
    )
    free = [threshold.path for threshold in result.thresholds if threshold.free]
    if free:
        paragraph(console, f"No limit breaks over {', '.join(free)}.")
    paragraph(console, METHOD)
    if result.after.tolerances is not None:
        paragraph(console, "Over the tolerances each value counts for the worst machine that was found.")


def _thresholds(result: WhatIf) -> list[tuple[str, ...]]:
    return [
        (
            threshold.path,
            threshold.now.shown,
            edge_words(threshold, threshold.below, threshold.limits[0]),
            edge_words(threshold, threshold.above, threshold.limits[1]),
        )
        for threshold in result.thresholds
        if not threshold.free
    ]


def edge_words(threshold: Threshold, value: Entry | None, limit: str) -> str:
    """An end of what a fact may be and the limit that ends it; of whole numbers the last that holds, and the next."""
    if value is None:
        return "-"
    if threshold.whole:  # the last that holds; the next number fails
        last = value.value + (1.0 if value.value < threshold.now.value else -1.0)
        return f"{last:.0f} ({value.shown} fails)\n  {limit}"
    return f"{'at once' if threshold.at_once(value) else value.shown}\n  {limit}"
