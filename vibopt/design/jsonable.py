"""A design as strict JSON: SI values with their unit, and the text as shown."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence, Set
from dataclasses import fields, is_dataclass
from math import isinf, isnan
from typing import Any

from vibopt.answer.entry import Chosen, Entry, Word
from vibopt.design.design import Conflict, Design
from vibopt.design.shelf import choices_of
from vibopt.design.words import notes_of

INFINITE, MINUS_INFINITE = "infinite", "minus infinite"


def as_json(design: Design) -> dict[str, Any]:
    """The answer as plain data.

    Infinite values are the texts "infinite" and "minus infinite", a value that does not exist is None:
    strict JSON has no words for them.
    """
    return {
        "name": design.scene.name,
        "title": design.scene.title,
        "status": design.status,
        "claim": design.claim,
        "reason": design.reason,
        "goal": _goal(design),
        "variables": {
            **{path: _placed(one) for path, one in design.places.items()},
            **{path: _chosen(one) for path, one in design.variables.items()},
        },
        **({} if not design.scene.absorbers else {"build": {one.name: plain(one) for one in _parts(design)}}),
        "limits": {name: plain(one) for name, one in design.limits.items()},
        "measures": {name: plain(one) for name, one in design.measures.items()},
        "set": None if design.found is None else [[plain(low), plain(high)] for low, high in design.found],
        "conflict": None if design.conflict is None else _conflict(design.conflict),
        "model": plain(design.model),
        "method": design.method,
        "timings": plain(design.timings),
        **({} if design.tolerances is None else {"tolerances": plain(design.tolerances)}),
        "notes": list(dict.fromkeys((*notes_of(design.scene), *design.notes))),
        "details": plain(design.details),
        **({"choices": plain(choices_of(design))} if "picks" in design.details else {}),
    }


def json_text(data: object, *, ascii_only: bool = False) -> str:
    """Any answer as strict JSON text, two blanks a level; what JSON cannot say is said in words."""
    return json.dumps(plain(data), indent=2, ensure_ascii=ascii_only, allow_nan=False)


def plain(data: object) -> Any:
    """Dataclasses, arrays, numbers and containers as JSON has them."""
    if data is None or isinstance(data, (bool, int, str)):
        return data
    if isinstance(data, float):
        return number(data)
    if isinstance(data, Design):
        return as_json(data)
    if hasattr(data, "to_json"):
        return plain(data.to_json())
    if isinstance(data, (Sequence, Set)):
        return [plain(one) for one in data]
    if is_dataclass(data) and not isinstance(data, type):
        return {one.name: plain(getattr(data, one.name)) for one in fields(data)}
    if isinstance(data, Mapping):
        return {str(key): plain(one) for key, one in data.items()}
    if hasattr(data, "tolist"):
        return plain(data.tolist())
    return str(data)


def number(value: float) -> float | str | None:
    """A float that strict JSON can hold, or the word for it; None where there is no value."""
    if isnan(value):
        return None
    if isinf(value):
        return INFINITE if value > 0 else MINUS_INFINITE
    return float(value)


def _parts(design: Design) -> Sequence[Any]:
    """The absorbers as they are built."""
    from vibopt.design.absorbers import parts_of

    return parts_of(design)


def _goal(design: Design) -> dict[str, Any] | None:
    if design.goal is None:
        return None
    name, shown = design.goal
    sense = design.scene.goal.sense if design.scene.goal is not None else ""
    return {"name": name, "sense": sense, **plain(shown)}


def _chosen(chosen: Chosen) -> dict[str, Any]:
    return {**plain(chosen.value), "at_bound": chosen.at_bound}


def _placed(placed: Word) -> dict[str, Any]:
    return {"value": placed.value, "unit": "", "shown": placed.value, "at_bound": "", "one_of": list(placed.options)}


def _conflict(conflict: Conflict) -> dict[str, Any]:
    steps = [{"limit": name, "from": plain(now), "to": plain(then)} for name, now, then in conflict.loosenings]
    return {"limits": list(conflict.limits), "loosenings": steps, "left": list(conflict.left), "proof": conflict.proof}


__all__ = ["INFINITE", "MINUS_INFINITE", "Entry", "as_json", "json_text", "number", "plain"]
