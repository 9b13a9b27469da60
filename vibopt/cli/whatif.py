"""`vibopt whatif`: the old answer beside the new."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from vibopt.cli.options import Once, as_json, changes_of, file, keep_design, limited, read_scene, rounding
from vibopt.cli.output import colour, say, say_json, width

if TYPE_CHECKING:
    from rich.console import Console

    from vibopt.answer.entry import Checked, Entry
    from vibopt.design.design import Design
    from vibopt.study.thresholds import Threshold
    from vibopt.study.whatif import WhatIf


@click.command(cls=Once)
@file
@click.option("--set", "changes", metavar="PATH=VALUE", multiple=True, required=True, help="A change; may be repeated.")
@keep_design
@rounding
@limited
@as_json
def whatif(file: str, changes: tuple[str, ...], keep_design: bool, rounding: tuple[str, ...], as_json: bool) -> int:
    """Change facts or limits, and see the old answer beside the new.

    With --keep-design the old design stays: which limits break under the changes, and how far each fact
    may go; with --round it stays with rounded values.  Exit code: that of the new answer.
    """
    from vibopt.cli.progress import Bar
    from vibopt.study.whatif import whatif as compare

    scene = read_scene(file, "whatif", instead="Solve the file twice, the second time with --set PATH=VALUE.")
    new = changes_of(changes)
    with Bar() as bar:
        result = compare(scene, new, keep_design=keep_design, rounding=rounding, progress=bar)
    if as_json:
        say_json({"status": result.after.status, **_parts(result)})
    else:
        from vibopt.design.table import rendered

        say(rendered(lambda console: _tell(result, console), width=width(), colour=colour()))
    return result.after.exit_code


def _parts(result: WhatIf) -> dict[str, Any]:
    from vibopt.answer.jsonable import plain

    keys = ("changes", "keep_design", "before", "after", "breaks", "thresholds")
    return {key: plain(getattr(result, key)) for key in keys}


def _tell(result: WhatIf, console: Console) -> None:
    """Changes, then both answers side by side, then what breaks."""
    from vibopt.design.table import grid, section
    from vibopt.design.words import listed

    console.print(result.before.scene.title, style="bold")
    rows = [(path, f"{_old(result.before, path)} -> {new}") for path, new in result.changes.items()]
    console.print(grid(rows))
    section(console, "Before and after", grid(_beside(result), ("", "Before", "After")))
    for name, one in (("before", result.before), ("after", result.after)):
        if one.reason or one.conflict:
            limits = one.conflict.limits if one.conflict else ()
            words = one.reason or f"these cannot hold together: {', '.join(limits)}."
            console.print(f"  {name}: {words}")
    if result.keep_design:
        names = listed([f'"{name}"' for name in result.breaks])
        console.print(f"\nThe design kept breaks {names}." if names else "\nThe design kept breaks no limit that held.")
        if result.thresholds:
            _say_thresholds(result, console)


def _old(design: Design, path: str) -> str:
    here: Any = design.scene.document
    for step in path.split("."):
        here = _inside(here, step)
    return "not given" if here is None else str(here)


def _inside(table: Any, step: str) -> Any:
    """Entry of a table by its key, or of a list by its number from 1; of three coordinates also by x, y, z."""
    if isinstance(table, dict):
        return table.get(step)
    if isinstance(table, list):
        index = int(step) - 1 if step.isdigit() else "xyz".find(step) if step in ("x", "y", "z") else -1
        return table[index] if 0 <= index < len(table) else None
    return None


def _beside(result: WhatIf) -> list[tuple[str, ...]]:
    before, after = result.before, result.after
    rows: list[tuple[str, ...]] = [("verdict", before.status, after.status)]
    if before.found is not None or after.found is not None:
        rows.append((str(before.scene.find_all or after.scene.find_all), _intervals(before), _intervals(after)))
    if (before.goal or after.goal) and not result.keep_design:
        name = (before.goal or after.goal or ("", None))[0]
        rows.append((name, *(one.goal[1].shown if one.goal else "-" for one in (before, after))))
    if not result.keep_design:
        places = list(dict.fromkeys((*before.places, *after.places)))
        rows += [
            (path, *(one.places[path].value if path in one.places else "-" for one in (before, after)))
            for path in places
        ]
        paths = [one for one in dict.fromkeys((*before.variables, *after.variables)) if ".part." not in one]
        rows += [
            (path, *(one.variables[path].value.shown if path in one.variables else "-" for one in (before, after)))
            for path in paths
        ]
    for family in ("limits", "measures"):
        names = list(dict.fromkeys((*getattr(before, family), *getattr(after, family))))
        both = [(name, [(one, getattr(one, family).get(name)) for one in (before, after)]) for name in names]
        rows += [(name, *(_cell(*one, name) for one in cells)) for name, cells in both]
    return rows


def _intervals(design: Design) -> str:
    """What `find_all` found, one interval a line."""
    from vibopt.design.words import interval

    if design.found is None:
        return "-"
    return "\n".join(interval(*one) for one in design.found) or "none"


def _cell(design: Design, checked: Checked | None, name: str) -> str:
    """The worst and where; among speeds yet to be told apart no limit is broken."""
    from vibopt.design.words import value_at
    from vibopt.study.freeze import MEASURED

    if checked is None:  # what a kept design measures was the goal before
        return design.goal[1].shown if design.goal is not None and name in MEASURED.values() else "-"
    state = checked.state if checked.limit is not None and design.found is None else ""
    return f"{value_at(checked)}{f', {state}' if state else ''}"


def _say_thresholds(result: WhatIf, console: Console) -> None:
    """Facts that can break a limit, then those that cannot, then how that was found."""
    from vibopt.design.table import grid, paragraph, section
    from vibopt.study.thresholds import METHOD

    heads = ("Fact", "Now", "Fails below", "Fails above")
    rows = _thresholds(result)
    when = "" if result.after.status == "met" else ", from the facts as they were before the change"
    section(
        console, f"How far each fact may go{when}", grid(rows, heads, whole=(0,)) if rows else "as far as was looked"
    )
    free = [one.path for one in result.thresholds if one.free]
    if free:
        paragraph(console, f"No limit breaks over {', '.join(free)}.")
    paragraph(console, METHOD)
    if result.after.tolerances is not None:
        paragraph(console, "Over the tolerances each value counts for the worst machine that was found.")


def _thresholds(result: WhatIf) -> list[tuple[str, ...]]:
    return [
        (one.path, one.now.shown, edge_words(one, one.below, one.limits[0]), edge_words(one, one.above, one.limits[1]))
        for one in result.thresholds
        if not one.free
    ]


def edge_words(one: Threshold, value: Entry | None, limit: str) -> str:
    """An end of what a fact may be and the limit that ends it; of whole numbers the last that holds, and the next."""
    if value is None:
        return "-"
    if one.whole:  # the last that holds; the next number fails
        last = value.value + (1.0 if value.value < one.now.value else -1.0)
        return f"{last:.0f} ({value.shown} fails)\n  {limit}"
    return f"{'at once' if one.at_once(value) else value.shown}\n  {limit}"
