"""An answer as strict JSON: SI values with their unit, and the text as shown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from dataclasses import fields, is_dataclass
from math import isinf, isnan
from typing import TYPE_CHECKING, Any

from vibopt.answer.views import views_of

if TYPE_CHECKING:
    from vibopt.answer.answer import Answer
    from vibopt.answer.entry import Value

SCHEMA = "vibopt.answer/2"
"""Name and number of the shape; the number is raised where a key goes or changes its meaning."""
INFINITE, MINUS_INFINITE = "infinite", "minus infinite"


def said_of(answer: Answer[Any]) -> dict[str, Any]:
    """What an answer says, of which `plain` makes JSON: what all kinds of job have, then what its kind adds."""
    views = views_of(answer)
    return {
        "schema": SCHEMA, "kind": answer.job.kind, "name": answer.name, "title": answer.title,
        "status": answer.status, "claim": answer.claim, "reason": answer.reason, "proven": answer.proven,
        "goal": _goal(answer, views.sense_of(answer)),
        "limits": answer.limits, "measures": answer.measures, "prices": answer.prices, "conflict": answer.conflict,
        **({} if answer.nearest is None else {"nearest": answer.nearest}),
        **nested(answer.values), **views.own_json(answer),
        "method": answer.method, "timings": answer.timings, "notes": views.notes_of(answer), "details": answer.details,
    }  # fmt: skip


def _goal(answer: Answer[Any], sense: str) -> dict[str, Any] | None:
    return None if answer.goal is None else {"name": answer.goal[0], "sense": sense, **answer.goal[1].to_json()}


def nested(values: Mapping[str, Value]) -> dict[str, Any]:
    """Numbers and words by path as tables within tables: the path of a number is its path in the JSON."""
    found: dict[str, Any] = {}
    for path, entry in values.items():
        *steps, last = path.split(".")
        here = found
        for step in steps:
            here = here.setdefault(step, {})
        here[last] = entry.to_json()
    return found


def json_text(data: object, *, ascii_only: bool = False) -> str:
    """Any answer as strict JSON text, two blanks a level; what JSON cannot say is said in words."""
    import json

    return json.dumps(plain(data), indent=2, ensure_ascii=ascii_only, allow_nan=False)


def plain(data: object) -> Any:
    """Dataclasses, arrays, numbers and containers as JSON has them.

    Infinite values are the texts "infinite" and "minus infinite", a value that does not exist is None:
    strict JSON has no words for them.
    """
    if data is None or isinstance(data, (bool, int, str)):
        return data
    if isinstance(data, float):
        return number(data)
    if hasattr(data, "as_said"):
        return plain(data.as_said())
    if hasattr(data, "to_json"):
        return plain(data.to_json())
    if isinstance(data, (Sequence, Set)):
        return [plain(one) for one in data]
    if is_dataclass(data) and not isinstance(data, type):
        return {field.name: plain(getattr(data, field.name)) for field in fields(data)}
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
