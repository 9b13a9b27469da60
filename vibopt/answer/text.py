"""An answer as text for a terminal: verdict, what to do, values, one row per limit, what it stands on.

Reads well at 80 columns, and the same without colour in a file or a pipe.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from shlex import quote
from typing import TYPE_CHECKING, Any

from vibopt.answer.blocks import FOOT, LEAD, Block, told
from vibopt.answer.console import Console, Grid, columns
from vibopt.answer.entry import Value
from vibopt.answer.views import views_of

if TYPE_CHECKING:
    from vibopt.answer.answer import Answer

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


def verdict(answer: Answer[Any]) -> str:
    """The first line of every answer, without its proof."""
    return f"{answer.status}: {views_of(answer).verdict(answer) or answer.claim}"


def claim(answer: Answer[Any]) -> str:
    """How that is known; "" where the verdict has said it already."""
    return "" if verdict(answer) == f"{answer.status}: {answer.claim}" else answer.claim


def blocks_of(answer: Answer[Any]) -> list[Block]:
    """Everything the answer says, in the order in which it is needed."""
    return [block for block in views_of(answer).blocks(answer) if block.lines or block.rows]


def text_of(
    answer: Answer[Any], *, width: int = WIDTH, colour: bool = False, file: str = "", changes: Sequence[str] = ()
) -> str:
    """The whole answer as text.

    Parameters
    ----------
    answer
        Of any kind of job, also one without values.
    width
        Columns of the terminal.
    colour
        Whether escape codes for colour may be written.
    file, changes
        The file as it was typed, by default the name of the job, and what was set beside it: for the next step.
    """
    return rendered(lambda console: _write(answer, console, file, changes), width=width, colour=colour)


def next_step(answer: Answer[Any], file: str = "", changes: Sequence[str] = ()) -> tuple[str, list[str]]:
    """What for, and the one most useful command after this answer in pieces to be joined by blanks.

    Nothing where there is none, or where the job comes from no file.
    """
    command, purpose = views_of(answer).next_step(answer)
    if not command or not answer.name.endswith(".toml"):
        return "", []
    verb, _, options = command.partition(" FILE ")
    kept = [change for change in changes if f"--set {change.partition('=')[0]}=" not in options]
    sets = [f"--set {quote(one)}" for one in kept]
    page = quote(f"{answer.name.removesuffix('.toml')}.html")
    return purpose, [f"{verb} {quote(file or answer.name)}", *sets, options.replace("NAME.html", page)]


def _write(answer: Answer[Any], console: Console, file: str, changes: Sequence[str]) -> None:
    console.print(answer.title, style="bold")
    console.print(verdict(answer), style=STYLES[answer.status])
    for text in (claim(answer), answer.reason):
        if text:
            paragraph(console, text)
    blocks = blocks_of(answer)
    for block in blocks:
        if block.kind != FOOT:
            show(block, console)
    foot = [
        (one.title if k == 0 else "", line) for one in blocks if one.kind == FOOT for k, line in enumerate(one.lines)
    ]
    purpose, pieces = next_step(answer, file, changes)
    if pieces:
        wide = max(columns(title) for title, _ in [*foot, ("Next", "")]) + 2
        whole = columns(" ".join(pieces)) <= console.width - wide
        lines = [" ".join(pieces)] if whole else " \\\n  ".join(pieces).split("\n")  # a shell joins them
        foot += [("Next", f"{purpose}:"), *(("", line) for line in lines)]
    if foot:
        console.print()
        console.print(grid(foot))


def show(block: Block, console: Console) -> None:
    """A block with its title."""
    if block.rows:
        section(console, block.title, grid(block.rows, block.heads, block.whole))
    elif block.kind == LEAD:
        console.print()
        for line in block.lines:
            paragraph(console, line.lstrip(), len(line) - len(line.lstrip()))
    else:
        section(console, block.title, grid([(line,) for line in block.lines]))


def rendered(write: Callable[[Console], None], *, width: int = WIDTH, colour: bool = False) -> str:
    """What `write` prints on a console of this width, without blanks at the ends of lines."""
    console = Console(max(width, 40), colour=colour)
    write(console)
    return console.text


def grid(
    rows: Iterable[Sequence[str | Value]], heads: Sequence[str] = (), whole: Sequence[int] = (), *, series: bool = False
) -> Grid:
    """A table without lines, each column in one unit a dimension; columns numbered in `whole` are never broken.

    In a `series` each column is one quantity, whose unit stands in its heading where lines would be too long.
    """
    return Grid(told(list(rows)), heads, whole, series=series)


def section(console: Console, title: str, body: str | Grid) -> None:
    """A title and what stands under it, indented by two."""
    console.print()
    console.print(title, style="bold")
    console.print(body, indent=2)


def paragraph(console: Console, text: str, indent: int = 2) -> None:
    """Wrapped text, indented."""
    console.print(text, indent=indent)
