"""A design as text for a terminal: verdict, values, one row per limit, what loosening buys.

Reads well at 80 columns, and the same without colour in a file or a pipe.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from io import StringIO
from typing import TYPE_CHECKING

from vibopt.answer.entry import Checked
from vibopt.design.absorbers import BUILD, build_rows
from vibopt.design.design import Design
from vibopt.design.shelf import choice_rows, dropped_rows, free_words, tied
from vibopt.design.words import (
    ENDS,
    SIDES,
    at_words,
    interval,
    loosening_words,
    model_words,
    notes_of,
    ranges_of,
    spoken,
    tolerance_rows,
    verdict,
    worst_rows,
)

if TYPE_CHECKING:
    from rich.console import Console, RenderableType
    from rich.table import Table

WIDTH = 80
GOOD, BAD, OPEN = "bold green", "bold red", "bold yellow"
STYLES = {
    "optimal": GOOD,
    "met": GOOD,
    "feasible": OPEN,
    "unproven": OPEN,
    "violated": BAD,
    "infeasible": BAD,
    "unbounded": BAD,
    "check_failed": BAD,
}


def text_of(design: Design, *, width: int = WIDTH, colour: bool = False) -> str:
    """The whole answer as text.

    Parameters
    ----------
    design
        Any answer, also one without values.
    width
        Columns of the terminal.
    colour
        Whether escape codes for colour may be written.
    """
    return rendered(lambda console: _write(design, console), width=width, colour=colour)


def rendered(write: Callable[[Console], None], *, width: int = WIDTH, colour: bool = False) -> str:
    """What `write` prints on a console of this width, without blanks at the ends of lines."""
    from rich.console import Console

    stream = StringIO()
    console = Console(
        file=stream,
        width=max(width, 40),
        force_terminal=colour,
        color_system="standard" if colour else None,
        highlight=False,
        markup=False,
        emoji=False,
        legacy_windows=False,
    )
    write(console)
    return "".join(f"{line.rstrip()}\n" for line in stream.getvalue().splitlines())


def grid(rows: Iterable[Sequence[str]], heads: Sequence[str] = (), whole: Sequence[int] = ()) -> Table:
    """A table without lines; columns numbered in `whole` are never broken."""
    from rich.table import Table

    listed_rows = [list(row) for row in rows]
    count = len(heads) or max((len(row) for row in listed_rows), default=1)
    table = Table(box=None, show_header=bool(heads), padding=(0, 2, 0, 0), pad_edge=False, header_style="dim")
    for column in range(count):
        table.add_column(heads[column] if heads else "", overflow="fold", no_wrap=column in whole)
    for row in listed_rows:
        table.add_row(*row)
    return table


def section(console: Console, title: str, body: RenderableType) -> None:
    """A title and what stands under it, indented by two."""
    from rich.padding import Padding

    console.print()
    console.print(title, style="bold")
    console.print(Padding(body, (0, 0, 0, 2)))


def paragraph(console: Console, text: str, indent: int = 2) -> None:
    """Wrapped text, indented."""
    from rich.padding import Padding

    console.print(Padding(text, (0, 0, 0, indent)))


def _write(design: Design, console: Console) -> None:
    console.print(design.scene.title, style="bold")
    console.print(verdict(design), style=STYLES[design.status])
    for text in (design.claim, design.reason):
        if text:
            paragraph(console, text)
    _conflict(design, console)
    _found(design, console)
    if design.status != "unbounded":  # its values are as far as a search went, and mean nothing
        _values_and_limits(design, console)
    _footing(design, console)


def _values_and_limits(design: Design, console: Console) -> None:
    if design.variables or design.places:
        section(console, "Design", grid(_values(design)))
    if design.details.get("places"):
        section(console, "Places", grid(_places(design)))
    build = build_rows(design)
    if build:
        section(console, BUILD, grid(build, whole=(0,)))
    if design.limits:
        heads = ("Limit", "Worst", "Allowed", "Margin")
        title = "Limits" if design.found is None else f"Limits over the whole range of {design.scene.find_all}"
        section(console, title, grid((_limit(one, design) for one in design.limits.values()), heads))
    _tolerances(design, console)
    _prices(design, console)
    _shelf(design, console)
    if design.measures:
        section(console, "Measures", grid(_measure(one) for one in design.measures.values()))


def _conflict(design: Design, console: Console) -> None:
    if design.conflict is None:
        return
    names = ", ".join(f'"{name}"' for name in design.conflict.limits)
    console.print()
    together = "These cannot hold together" if len(design.conflict.limits) > 1 else "This cannot hold"
    console.print(f"{together}: {names}.")
    if design.conflict.proof and design.conflict.proof != design.claim:
        paragraph(console, design.conflict.proof)
    steps = loosening_words(design)
    if steps:
        console.print(f"Smallest loosening of one: {', or '.join(steps)}.")


def _found(design: Design, console: Console) -> None:
    if design.found:
        intervals = grid([[interval(*one)] for one in design.found])
        section(console, f"All limits hold for {design.scene.find_all}", intervals)


def _values(design: Design) -> list[tuple[str, ...]]:
    ranges = ranges_of(design.scene)
    brought = {
        path: f"as {design.places[part].value} has it"
        for path, part in tied(design.scene).items()
        if part in design.places
    }
    placed: list[tuple[str, ...]] = [
        (path, one.value, f"chosen from {one.among or ', '.join(one.options)}") for path, one in design.places.items()
    ]
    return placed + [
        (path, one.value.shown, ENDS.get(one.at_bound, "") or brought.get(path, f"chosen from {ranges.get(path, '')}"))
        for path, one in design.variables.items()
        if ".part." not in path
    ]


def _places(design: Design) -> list[tuple[str, ...]]:
    """What was found at each place, or each combination of places."""
    return [(one["place"], one["status"], one["goal"]) for one in design.details.get("places", ())]


def _limit(one: Checked, design: Design) -> tuple[str, ...]:
    """Four cells of two lines each."""
    at = at_words(one.worst_at)
    return (
        f"{one.name}\n  {spoken(one.response, one.place)}",
        f"{one.value.shown}\n{f'at {at}' if at else ''}",
        f"{SIDES.get(one.side, '')}\n{one.limit.shown if one.limit is not None else ''}",
        f"{one.margin_shown}\n{one.state if design.found is None else ''}".lstrip("\n"),
    )


def _measure(one: Checked) -> tuple[str, ...]:
    at = at_words(one.worst_at)
    return one.name, spoken(one.response, one.place), f"{one.value.shown} at {at}" if at else one.value.shown


def _tolerances(design: Design, console: Console) -> None:
    both, worst = tolerance_rows(design), worst_rows(design)
    if both:
        section(console, "What the tolerances cost", grid(both, ("", "without", "with")))
    if worst:
        section(console, "Worst machine within the tolerances", grid(worst))


def _prices(design: Design, console: Console) -> None:
    words = [(name, one.price.words) for name, one in design.limits.items() if one.price is not None]
    if words:
        section(console, "What loosening a limit buys", grid(words))


def _shelf(design: Design, console: Console) -> None:
    """The best choices from a catalogue, what was dropped, and what free values would do."""
    choices, dropped, free = choice_rows(design), dropped_rows(design), free_words(design)
    if len(choices) > 1:
        costs = "" if not any(one[2] for one in choices) else "Price"
        section(console, f"The best {len(choices)} choices", grid(choices, ("Order", "Goal", costs, "Tightest limit")))
    if dropped:
        section(console, "What was dropped", grid(dropped))
    if free:
        section(console, "Stiffness and damping made to order", grid([[free]]))


def _footing(design: Design, console: Console) -> None:
    """What the answer stands on: model, method, notes."""
    seconds = sum(design.timings.values())
    console.print()
    rows = [("Model", model_words(design)), ("Method", f"{design.method}, {_time(seconds)}" if design.method else "")]
    notes = list(dict.fromkeys((*notes_of(design.scene), *design.notes)))
    rows += [("Notes" if i == 0 else "", note) for i, note in enumerate(notes)]
    console.print(grid([row for row in rows if row[1]]))


def _time(seconds: float) -> str:
    return f"{seconds:.1f} s" if seconds >= 1.0 else f"{1e3 * seconds:.0f} ms"
