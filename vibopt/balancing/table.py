"""A balancing answer as text for a terminal: verdict, what to do, what will be left, conventions.

Reads well at 80 columns, and the same without colour in a file or a pipe.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from vibopt.answer.answer import Answer
from vibopt.balancing.blocks import FOOT, Block
from vibopt.balancing.said import blocks_of, claim, verdict
from vibopt.design.table import STYLES, WIDTH, grid, paragraph, rendered, section

if TYPE_CHECKING:
    from rich.console import Console


def text_of(answer: Answer[Any], *, width: int = WIDTH, colour: bool = False) -> str:
    """The whole answer as text.

    Parameters
    ----------
    answer
        A plan or an outcome, also one without weights.
    width
        Columns of the terminal.
    colour
        Whether escape codes for colour may be written.
    """
    return rendered(lambda console: _write(answer, console), width=width, colour=colour)


def _write(answer: Answer[Any], console: Console) -> None:
    console.print(answer.title, style="bold")
    console.print(verdict(answer), style=STYLES[answer.status])
    for text in (claim(answer), answer.reason):
        if text:
            paragraph(console, text)
    for block in blocks_of(answer):
        _block(block, console)


def _block(block: Block, console: Console) -> None:
    if block.rows:
        section(console, block.title, grid(block.rows, block.heads, block.whole))
    elif block.kind == FOOT:
        section(console, block.title, "\n".join(block.lines))
    else:
        section(console, block.title, grid([(line,) for line in block.lines]))
