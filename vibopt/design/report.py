"""The answer as one page that can be printed and signed: HTML with its figures in it, nothing outside."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import date
from pathlib import Path
from typing import Any

from vibopt.design.absorbers import BUILD, build_rows
from vibopt.design.curves import panels
from vibopt.design.design import Design
from vibopt.design.figures import below, plane_figure, response_figure, saved
from vibopt.design.plane import absorbers_with_map, plane
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
    value_at,
    verdict,
    worst_rows,
)
from vibopt.devices import FAMILIES

TEMPLATE = Path(__file__).with_name("template.html.j2")

_REFERENCE = re.compile(r'(\bid="|url\(#|href="#)')


Blocks = Sequence[tuple[str, Sequence[tuple[str, str]]]]
"""Titles, and rows of a name and a sentence."""


def html(design: Design, *, changes: Sequence[str] = (), on: date | None = None, also: Blocks | None = None) -> str:
    """The page.

    Parameters
    ----------
    design
        Any answer; what it lacks is left out of the page.
    changes
        What was set on the command line beside the file, to be said on the page.
    on
        Date of the page; today if None.
    also
        What a study found beside the answer.
    """
    from jinja2 import Environment, StrictUndefined

    environment = Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=StrictUndefined)
    template = environment.from_string(TEMPLATE.read_text(encoding="utf-8"))
    rows = build_rows(design)
    said = {
        "changes": list(changes),
        "date": (on or date.today()).isoformat(),
        "build": (BUILD, rows) if rows else None,
        "also": [(title, some) for title, some in also or () if title != BUILD],
    }
    return template.render(**_words(design), **said)


def _words(design: Design) -> dict[str, Any]:
    """Everything the template says, as text."""
    from markupsafe import Markup

    if design.status == "unbounded":  # its values are as far as a search went, and mean nothing
        design = replace(design, variables={}, limits={}, measures={}, x=())
    scene = design.scene
    ranges = ranges_of(scene)
    ranges |= {path: f"as {design.places[part].value} has it" for path, part in tied(scene).items() if design.places}
    return {
        "title": scene.title,
        "file": scene.name,
        "statement": " ".join(scene.statement.split()),
        "source": str(scene.document.get("source", "")),
        "status": design.status,
        "verdict": verdict(design).partition(": ")[2],
        "claim": design.claim,
        "reason": design.reason,
        "conflict": design.conflict,
        "loosenings": loosening_words(design),
        "found": [interval(*one) for one in design.found] if design.found is not None else None,
        "find_all": scene.find_all,
        "choices": choice_rows(design),
        "dropped": dropped_rows(design),
        "made_to_order": free_words(design),
        "variables": [
            {"path": path, "shown": one.value, "range": one.among or ", ".join(one.options), "end": ""}
            for path, one in design.places.items()
        ]
        + [
            {"path": path, "shown": one.value.shown, "range": ranges.get(path, ""), "end": ENDS.get(one.at_bound, "")}
            for path, one in design.variables.items()
            if ".part." not in path
        ],
        "limits": [_limit(name, design) for name in design.limits],
        "prices": [(name, one.price.words) for name, one in design.limits.items() if one.price is not None],
        "measures": [(name, spoken(one.response, one.place), value_at(one)) for name, one in design.measures.items()],
        "without_tolerances": tolerance_rows(design),
        "worst_machines": worst_rows(design),
        "model": model_words(design),
        "method": design.method,
        "seconds": f"{sum(design.timings.values()):.2g}",
        "notes": list(dict.fromkeys((*notes_of(scene), *design.notes))),
        "figures": [Markup(one) for one in figures(design)],
        "facts": facts(scene.document),
        "version": version(),
    }


def _limit(key: str, design: Design) -> dict[str, str]:
    one = design.limits[key]
    return {
        "name": key,
        "what": spoken(one.response, one.place),
        "value": one.value.shown,
        "at": at_words(one.worst_at),
        "allowed": f"{SIDES.get(one.side, '')} {one.limit.shown if one.limit is not None else ''}",
        "margin": one.margin_shown,
        "state": one.state if design.found is None else "",
    }


def figures(design: Design) -> list[str]:
    """Inline SVG of every panel, then of the design map."""
    drawn = [(panel.title, response_figure([panel])) for panel in panels(design)]
    drawn += [(one.title, response_figure([], "", [one])) for one in below(design)]
    for mapped in filter(None, (plane(design, name) for name in absorbers_with_map(design) or ("",))):
        drawn.append((mapped.title, plane_figure(mapped)))
    return [inline(saved(figure, "svg").decode(), f"f{index}", title) for index, (title, figure) in enumerate(drawn)]


def inline(svg: str, prefix: str, title: str) -> str:
    """An SVG file as part of a page: no prologue, ids of its own, as wide as the text."""
    body = svg[svg.index("<svg") :]
    body = _REFERENCE.sub(lambda found: f"{found[1]}{prefix}-", body)
    body = re.sub(r"<metadata>.*?</metadata>", "", body, flags=re.DOTALL)
    head, _, rest = body.partition(">")
    head = re.sub(r'\s(width|height)="[^"]*"', "", head)
    label = title.replace("&", "&amp;").replace('"', "&quot;").replace("<", "&lt;")
    return f'{head} role="img" aria-label="{label}">{rest}'


def facts(document: Mapping[str, Any]) -> list[tuple[str, list[tuple[str, str]]]]:
    """What the file gives, table by table, in its own words."""
    tables = []
    for family in (*FAMILIES, "excitations", "limits", "measures"):
        for name, table in document.get(family, {}).items():
            tables.append((f"{family}.{name}", [(key, _said(value)) for key, value in table.items()]))
    if isinstance(document.get("goal"), Mapping):
        tables.append(("goal", [(key, _said(value)) for key, value in document["goal"].items()]))
    return tables


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
