"""The shape of answers as JSON schema: what all kinds of job have, and what each kind adds."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from vibopt.answer.answer import EXIT_CODES
from vibopt.answer.jsonable import INFINITE, MINUS_INFINITE, SCHEMA

Shape = dict[str, Any]

TEXT: Shape = {"type": "string"}
TEXTS: Shape = {"type": "array", "items": TEXT}
NUMBER: Shape = {"anyOf": [{"type": "number"}, {"enum": [INFINITE, MINUS_INFINITE, None]}]}
OPEN: Shape = {"type": "object"}


def ref(name: str) -> Shape:
    """One of the parts that are described once."""
    return {"$ref": f"#/$defs/{name}"}


def named(one: Shape) -> Shape:
    """Tables by name or path."""
    return {"type": "object", "additionalProperties": one}


def table(required: Mapping[str, Shape], optional: Mapping[str, Shape] | None = None) -> Shape:
    """A table with these keys and no others."""
    keys = {**required, **(optional or {})}
    return {"type": "object", "properties": keys, "required": list(required), "additionalProperties": False}


def listed(one: Shape) -> Shape:
    return {"type": "array", "items": one}


def maybe(one: Shape) -> Shape:
    """That, or null."""
    return {"anyOf": [one, {"type": "null"}]}


_NUMBER = {"value": NUMBER, "unit": TEXT, "shown": TEXT}
_LIMIT = {
    "side": {"enum": ["at_most", "at_least", "outside"]}, "limit": NUMBER, "limit_shown": TEXT, "margin": NUMBER,
    "active": {"type": "boolean"}, "met": {"type": "boolean"}, "price": maybe(ref("price")),
}  # fmt: skip
_ROW = {"response": TEXT, "place": TEXT, **_NUMBER, "worst_at": named(ref("number"))}
_SCATTER = {
    "off": named({"type": "number"}), "band": listed(ref("number")), "met_by_band": {"type": ["boolean", "null"]},
    "doubt": TEXT,
}  # fmt: skip
PARTS = {
    "number": table(_NUMBER),
    "entry": {"anyOf": [ref("number"), TEXT]},
    "entries": named({"anyOf": [ref("entry"), ref("entries")]}),
    "goal": table({"name": TEXT, "sense": {"enum": ["minimise", "maximise"]}, **_NUMBER}),
    "price": table(
        {"words": TEXT, **dict.fromkeys(("loosened", "goal", "until"), maybe(ref("number")))},
        {"rate": NUMBER, "ways": {"type": "array", "items": ref("way")}},
    ),
    "way": table(
        {
            "value": ref("number"),
            "change": maybe(NUMBER),
            **dict.fromkeys(("status", "then", "beyond"), TEXT),
            **dict.fromkeys(("goal", "until", "there", "ends", "far", "again"), maybe(ref("number"))),
            "looked": {"type": "integer"},
        }
    ),
    "limit": table({**_ROW, **_LIMIT}, _SCATTER),
    "measure": table(_ROW, _SCATTER),
    "nearest": table(
        {
            "values": named(ref("entry")),
            "words": TEXTS,
            "limits": named(ref("limit")),
            "left": TEXTS,
            "least": named(table({**_NUMBER, "proven": {"type": "boolean"}, "enough": {"type": "boolean"}})),
        }
    ),
    "conflict": table(
        {
            "limits": TEXTS,
            "loosenings": listed(table({"limit": TEXT, "from": ref("number"), "to": ref("number")})),
            "left": TEXTS,
            "proof": TEXT,
            "others": listed(TEXTS),
            "complete": {"type": "boolean"},
            "soft": named(NUMBER),
            "doubtful": TEXTS,
        }
    ),
}
COMMON = {
    "schema": {"const": SCHEMA}, "kind": TEXT, "name": TEXT, "title": TEXT, "status": {"enum": list(EXIT_CODES)},
    "claim": TEXT, "reason": TEXT, "proven": {"type": "boolean"}, "goal": maybe(ref("goal")),
    "limits": named(ref("limit")), "measures": named(ref("measure")), "prices": named(ref("price")),
    "conflict": maybe(ref("conflict")), "method": TEXT, "timings": named({"type": "number"}), "notes": TEXTS,
    "details": OPEN,
}  # fmt: skip
NEAREST = {"nearest": ref("nearest")}
"""What an answer without a design may have."""
WRITTEN = {"written": TEXTS, "messages": TEXTS}
"""What a command adds that writes files."""


def answer_schema(kinds: Mapping[str, tuple[Mapping[str, Shape], Mapping[str, Shape]]]) -> Shape:
    """JSON schema (draft 2020-12) of every answer.

    Parameters
    ----------
    kinds
        By kind of job the keys that its answers always have beside the common ones, and those that they may have.
    """
    shapes = [
        table({**COMMON, "kind": {"const": kind}, **always}, {**sometimes, **NEAREST, **WRITTEN})
        for kind, (always, sometimes) in kinds.items()
    ]
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema", "title": f"vibopt answer ({SCHEMA})",
        "oneOf": shapes, "$defs": PARTS,
    }  # fmt: skip
