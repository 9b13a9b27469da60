"""What measured rotors, known masses and engines add to the views of their answers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from vibopt.answer.answer import Answer
from vibopt.answer.schema import NUMBER, TEXT, TEXTS, listed, maybe, named, ref, table
from vibopt.balancing.table import text_of

if TYPE_CHECKING:
    from vibopt.jobs import BalancingJob

_CONVENTIONS = ("phase", "readings", "angles", "detector", "zero")


_AMOUNT = dict.fromkeys(("mass", "unbalance"), ref("number"))
_WEIGHT = table(
    {
        **dict.fromkeys(("radius", "depth"), maybe(ref("number"))),
        "angle": ref("number"),
        "hole": {"type": ["integer", "null"]},
    },
    _AMOUNT,
)
_PLANE = table(
    {"action": {"enum": ["add", "remove", "nothing", "keep"]}, "angle": ref("number"), "radius": maybe(ref("number")),
     "weights": listed(_WEIGHT), "words": TEXT},
    _AMOUNT,
)  # fmt: skip
_READING = table(
    {
        **dict.fromkeys(("speed", "found", "residual"), ref("number")),
        **dict.fromkeys(("found_phasor", "fitted_phasor", "residual_phasor", "price"), TEXT),
        "band": maybe(listed(ref("number"))), "limit": maybe(ref("number")), "margin": NUMBER,
    }
)  # fmt: skip
_SENSOR = table({"speeds": listed(_READING), "residual": ref("number"), "found": ref("number")})
_FITTING = {"planes": named(_PLANE), "sensors": named(_SENSOR)}
_WAYS = listed(table({"remedy": TEXT, "worst": ref("number"), "rms": ref("number"), "masses": TEXTS, "band": TEXT}))
_STATED = named(TEXT) | {"properties": {"words": TEXTS}}
KEYS = {
    "rotor": (
        {"conventions": _STATED, "words": TEXTS, **_FITTING, "answers": listed(table(_FITTING)), "remedies": _WAYS,
         "beside": _WAYS, "condition": NUMBER, "gap": NUMBER},
        dict.fromkeys(("influence", "quality", "planes_first", "trim"), ref("entries")),
    ),
    "known": ({}, dict.fromkeys(("planes", "as_found", "residual"), ref("entries"))),
    "engine": (
        {"cylinders": ref("entries"), "orders": ref("entries"), "all_orders": ref("entries")},
        {**dict.fromkeys(("counterweights", "balance_shafts", "firing"), ref("entries")),
         **dict.fromkeys(("counterweight_share", "rotating_share"), ref("number"))},
    ),
}  # fmt: skip
"""By kind of job: what its answers have in JSON beside what all have, always and sometimes."""


def sense_of(answer: Answer[BalancingJob]) -> str:
    """Balancing makes least."""
    return "" if answer.goal is None else "minimise"


def notes_of(answer: Answer[BalancingJob]) -> list[str]:
    """How the file was read, and what must be known to use the answer."""
    return list(answer.notes)


def own_json(answer: Answer[BalancingJob]) -> dict[str, Any]:
    """Of a measured rotor its plan and conventions; what the others add are values by path."""
    conventions = getattr(answer.job, "conventions", None)
    if conventions is None:
        return {}
    spoken = {key: getattr(conventions, key) for key in _CONVENTIONS}
    return {"conventions": {**spoken, "words": answer.plan.conventions}, **answer.plan.to_json()}


__all__ = ["KEYS", "notes_of", "own_json", "sense_of", "text_of"]
