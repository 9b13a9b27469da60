"""An answer as one page that can be printed and signed: HTML with its figures in it, nothing outside."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from datetime import date
from pathlib import Path
from typing import Any

from vibopt.answer.answer import EMPTY, Answer
from vibopt.answer.blocks import FOOT, LEAD, TABLE, TEXT, TODO, WARNING, Block
from vibopt.answer.text import blocks_of, claim, verdict
from vibopt.answer.views import views_of

TEMPLATE = Path(__file__).with_name("page.html.j2")
TO_MEASURE = "Measured"
PAGE, LEAST, MOST = 18.5, 5.0, 13.5
"""What a page to sign has for its picture and its rows, and how small and large the picture may be [cm]."""
NARROW, LONG = 42, 30
"""Letters of a table that stands beside another one, on a page to sign and in a report of more rows than that."""
_REFERENCE = re.compile(r'(\bid="|url\(#|href="#)')

Pairs = Sequence[tuple[str, Sequence[tuple[str, str]]]]
"""Titles, and rows of a name and a sentence."""


def html(
    answer: Answer[Any],
    *,
    changes: Sequence[str] = (),
    digests: Mapping[str, str] | None = None,
    on: date | None = None,
    also: Pairs | None = None,
    sheet: bool = False,
    paper: str = "A4",
) -> str:
    """The page.

    Parameters
    ----------
    answer
        Of any kind of job; what it lacks is left out of the page.
    changes
        What was set on the command line beside the file, to be said on the page.
    digests
        SHA-256 of the problem file and of the files it reads, by their names.
    on
        Date of the page; today if None.
    also
        What a study found beside the answer.
    sheet
        Whether it is for the shop floor: closely set, one picture, room for what is then measured, and none of the
        facts of the file.
    paper
        "A4" or "letter": what it is printed on.
    """
    words = _words(answer, sheet, also or ())
    said = {
        "changes": list(changes),
        "digests": shown_digests(digests),
        "date": (on or date.today()).isoformat(),
        "sheet": sheet,
        "version": version(),
    }
    return filled(TEMPLATE, **words, **said, room=_room(words), paper=paper)


def filled(template: Path, **words: Any) -> str:
    """A page as its template has it with some words; one that is missing is an error."""
    from jinja2 import Environment, StrictUndefined

    environment = Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=StrictUndefined)
    return environment.from_string(template.read_text(encoding="utf-8")).render(**words)


def shown_digests(digests: Mapping[str, str] | None) -> list[tuple[str, str]]:
    """The first 16 digits of each in fours, by name."""
    return [(name, " ".join(one[i : i + 4] for i in (0, 4, 8, 12))) for name, one in (digests or {}).items()]


def _room(words: Mapping[str, Any]) -> float:
    """Height that the picture of a page to sign may have beside what else stands on it [cm]."""
    rows = [(len(one["rows"]) + len(one["lines"]) + 3, one["wide"]) for one in words["tables"]]
    lines = 1.2 * len(words["todo"]) + sum(count if wide else 0.6 * count for count, wide in rows)
    return min(max(PAGE - 0.5 * lines, LEAST), MOST)


def _words(answer: Answer[Any], sheet: bool, also: Pairs) -> dict[str, Any]:
    """Everything the template says, as text."""
    from markupsafe import Markup

    views, blocks = views_of(answer), blocks_of(answer)
    titles = {block.title for block in blocks}
    blocks += [Block(title, rows=tuple(rows)) for title, rows in also if title not in titles]
    document = answer.job.document
    stand = [block for block in blocks if _stands(block, sheet)]
    close = sheet or sum(len(block.rows) for block in stand) > LONG
    figures = [
        Markup(inline(svg, "plan" if sheet else f"f{index}", title))
        for index, (title, svg) in enumerate(views.figures(answer, compact=sheet))
    ]
    return {
        "title": answer.title,
        "file": answer.name,
        "statement": " ".join(str(document.get("statement", "")).split()),
        "source": str(document.get("source", "")),
        "status": answer.status,
        "verdict": verdict(answer).partition(": ")[2],
        "claim": claim(answer),
        "reason": answer.reason,
        "lead": [line for block in blocks if block.kind == LEAD for line in block.lines],
        "warnings": [line for block in blocks if block.title == WARNING for line in block.lines],
        "todo": [line for block in blocks if block.kind == TODO for line in block.lines],
        "tables": [_table(block, sheet, close) for block in stand],
        "foot": [block for block in blocks if block.kind == FOOT],
        "figures": figures,
        "signs": () if answer.status in (*EMPTY, "violated") else views.signs(answer),
        "unsigned": "the limits are not met" if answer.status in ("violated", "infeasible") else "it is no design",
        "given": [] if sheet else given(document),
    }


def _stands(block: Block, sheet: bool) -> bool:
    """Whether it has a place of its own; warnings stand on top."""
    return block.kind in (TABLE, TEXT) and block.title != WARNING and (block.on_sheet or not sheet)


def _table(block: Block, sheet: bool, close: bool) -> dict[str, Any]:
    """A table for the page, beside others where all is set closely; on a sheet with an empty column to fill in."""
    measured = bool(sheet and block.rows and block.measured)
    return {
        "title": block.title,
        "lines": block.lines,
        "heads": (*block.heads, TO_MEASURE) if measured else block.heads,
        "rows": [[cell.split("\n") for cell in row] for row in block.rows],
        "measured": measured,
        "wide": bool(not close or measured or block.lines or _width(block) > NARROW),
    }


def _width(block: Block) -> int:
    """Letters that the longest cells take side by side."""
    columns = zip(*filter(None, (block.heads, *block.rows)), strict=True)
    return sum(max(len(line) for cell in column for line in cell.split("\n")) for column in columns)


def inline(svg: str, prefix: str, title: str) -> str:
    """An SVG file as part of a page: no prologue, ids of its own, as wide as the text."""
    body = svg[svg.index("<svg") :]
    body = _REFERENCE.sub(lambda match: f"{match[1]}{prefix}-", body)
    body = re.sub(r"<metadata>.*?</metadata>", "", body, flags=re.DOTALL)
    head, _, rest = body.partition(">")
    head = re.sub(r'\s(width|height)="[^"]*"', "", head)
    label = title.replace("&", "&amp;").replace('"', "&quot;").replace("<", "&lt;")
    return f'{head} role="img" aria-label="{label}">{rest}'


_ASIDE = ("title", "statement", "source", "scenarios", "expected")


def given(document: Mapping[str, Any]) -> list[tuple[str, list[tuple[str, str]]]]:
    """What the file gives, table by table, in its own words."""
    tables: list[tuple[str, list[tuple[str, str]]]] = []
    single: list[tuple[str, str]] = []
    for family, value in document.items():
        if family in _ASIDE:
            continue
        tables += _tables(family, value)
        if not isinstance(value, (Mapping, list)) or (isinstance(value, list) and not _of_tables(value)):
            single.append((family, _said(value)))
    return [*([("", single)] if single else []), *tables]


def _of_tables(value: Sequence[Any]) -> bool:
    return bool(value) and all(isinstance(one, Mapping) for one in value)


def _tables(family: str, value: Any) -> list[tuple[str, list[tuple[str, str]]]]:
    """Tables of a family by name or number; one without tables in it is a table itself."""
    if isinstance(value, list) and _of_tables(value):
        return [(f"{family} {k}", _rows(one)) for k, one in enumerate(value, start=1)]
    if not isinstance(value, Mapping):
        return []
    if value and all(isinstance(one, Mapping) for one in value.values()):
        return [(f"{family}.{name}", _rows(one)) for name, one in value.items()]
    return [(family, _rows(value))]


def _rows(table: Mapping[str, Any]) -> list[tuple[str, str]]:
    return [(key, _in_lines(value)) for key, value in table.items()]


def _in_lines(value: object) -> str:
    """A list of places, orders or pieces one a line; anything else in one."""
    inner = value if isinstance(value, (list, tuple)) else ()
    if len(inner) > 1 and all(isinstance(one, (list, tuple, Mapping)) for one in inner):
        return "\n".join(_said(one).replace("; ", ", ") for one in inner)
    return _said(value)


def _said(value: object) -> str:
    if isinstance(value, Mapping):
        return ", ".join(f"{key} {_said(one)}" for key, one in value.items())
    if isinstance(value, (list, tuple)):
        return "; ".join(_said(one) for one in value)
    return str(value).lower() if isinstance(value, bool) else str(value)


def version() -> str:
    """Version of vibopt as installed; "" where it is not."""
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("vibopt")
    except PackageNotFoundError:
        return ""
