"""The plan for the shop floor: one printable page (HTML), nothing outside it, with room for name and date."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vibopt.answer.answer import Answer
from vibopt.balancing.blocks import FOOT, TABLE, TEXT, TODO, WARNING, Block
from vibopt.balancing.said import blocks_of, claim, verdict
from vibopt.design.report import inline
from vibopt.jobs import is_rotor

if TYPE_CHECKING:
    pass

TEMPLATE = Path(__file__).with_name("sheet.html.j2")
TO_MEASURE = "Measured"
NARROW = 42
_MEASURED = ("What will be left",)


def html(answer: Answer[Any], *, changes: Sequence[str] = (), on: date | None = None) -> str:
    """The page.

    Parameters
    ----------
    answer
        A plan or an outcome; what it lacks is left out of the page.
    changes
        What was set on the command line beside the file, to be said on the page.
    on
        Date of the page; today if None.
    """
    from jinja2 import Environment, StrictUndefined

    environment = Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=StrictUndefined)
    template = environment.from_string(TEMPLATE.read_text(encoding="utf-8"))
    return template.render(**_words(answer), changes=list(changes), date=(on or date.today()).isoformat())


def _words(answer: Answer[Any]) -> dict[str, Any]:
    """Everything the template says."""
    blocks = blocks_of(answer)
    return {
        "title": answer.title,
        "file": answer.name,
        "status": answer.status,
        "verdict": verdict(answer).partition(": ")[2],
        "claim": claim(answer),
        "reason": answer.reason,
        "warnings": [line for one in blocks if one.title == WARNING for line in one.lines],
        "todo": [line for one in blocks if one.kind == TODO for line in one.lines],
        "tables": [_table(one) for one in blocks if one.kind in (TABLE, TEXT) and not _said_before(answer, one)],
        "foot": [one for one in blocks if one.kind == FOOT],
        "figure": _figure(answer),
        "is_plan": is_rotor(answer.job),
    }


def _table(block: Block) -> dict[str, Any]:
    """A table for the page; of what will be left with an empty column for what is then measured."""
    measured = block.rows and block.title.startswith(_MEASURED)
    return {
        "title": block.title,
        "lines": block.lines,
        "heads": (*block.heads, TO_MEASURE) if measured else block.heads,
        "rows": [[cell.split("\n") for cell in row] for row in block.rows],
        "measured": bool(measured),
        "wide": bool(measured or block.lines or _width(block) > NARROW),
    }


def _width(block: Block) -> int:
    """Letters that the longest cells take side by side."""
    columns = zip(*filter(None, (block.heads, *block.rows)), strict=True)
    return sum(max(len(line) for cell in column for line in cell.split("\n")) for column in columns)


def _said_before(answer: Answer[Any], block: Block) -> bool:
    """Warnings stand on top, and limits on readings beside each reading."""
    if block.title == WARNING:
        return True
    if not is_rotor(answer.job) or block.title != "Limits":
        return False
    return all(one.response == "residual" for one in answer.limits.values())


def _figure(answer: Answer[Any]) -> Any:
    """The compact picture as inline SVG; "" where there is nothing to draw."""
    from markupsafe import Markup

    from vibopt.balancing.figures import figure_of
    from vibopt.design.figures import saved

    figure = figure_of(answer, compact=True)
    return "" if figure is None else Markup(inline(saved(figure, "svg").decode(), "plan", answer.title))
