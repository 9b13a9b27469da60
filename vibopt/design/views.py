"""What a machine adds to the views of its answer."""

from __future__ import annotations

from typing import Any

from vibopt.answer.entry import Chosen, Word
from vibopt.answer.schema import NUMBER, OPEN, TEXT, TEXTS, maybe, named, ref, table
from vibopt.design.absorbers import parts_of
from vibopt.design.design import Design
from vibopt.design.shelf import choices_of
from vibopt.design.table import text_of
from vibopt.design.words import notes_of as readings_of

_CHOSEN = table(
    {"value": {"anyOf": [NUMBER, TEXT]}, "unit": TEXT, "shown": TEXT, "at_bound": {"enum": ["from", "to", ""]}},
    {"one_of": TEXTS},
)
_USED = table({"declared_dof": {"type": "integer"}, "used_dof": {"type": "integer"}, "why": TEXT})
_INTERVALS = {"type": "array", "items": {"type": "array", "items": ref("number")}}
KEYS = {
    "scene": (
        {"variables": named(_CHOSEN), "set": maybe(_INTERVALS), "model": maybe(_USED)},
        {"build": OPEN, "tolerances": OPEN, "choices": {"type": "array"}},
    )
}
"""By kind of job: what its answers have in JSON beside what all have, always and sometimes."""


def sense_of(design: Design) -> str:
    """ "minimise" or "maximise"; "" without a goal."""
    return design.scene.goal.sense if design.scene.goal is not None else ""


def notes_of(design: Design) -> list[str]:
    """How the file was read, and what must be known to use the answer."""
    return list(dict.fromkeys((*readings_of(design.scene), *design.notes)))


def own_json(design: Design) -> dict[str, Any]:
    """Variables and places, parts to build, the set of good speeds, the model, tolerances, choices."""
    return {
        "variables": {
            **{path: _placed(one) for path, one in design.places.items()},
            **{path: _chosen(one) for path, one in design.variables.items()},
        },
        **({} if not design.scene.absorbers else {"build": {one.name: one for one in parts_of(design)}}),
        "set": None if design.found is None else design.found,
        "model": design.model,
        **({} if design.tolerances is None else {"tolerances": design.tolerances}),
        **({"choices": choices_of(design)} if "picks" in design.details else {}),
    }


def _chosen(chosen: Chosen) -> dict[str, Any]:
    return {**chosen.value.to_json(), "at_bound": chosen.at_bound}


def _placed(placed: Word) -> dict[str, Any]:
    return {"value": placed.value, "unit": "", "shown": placed.value, "at_bound": "", "one_of": list(placed.options)}


__all__ = ["KEYS", "notes_of", "own_json", "sense_of", "text_of"]
