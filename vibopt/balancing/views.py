"""What measured rotors, known masses and engines add to the views of their answers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from vibopt.answer.answer import Answer
from vibopt.balancing.table import text_of

if TYPE_CHECKING:
    from vibopt.jobs import BalancingJob

_CONVENTIONS = ("phase", "readings", "angles", "detector", "zero")


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


__all__ = ["notes_of", "own_json", "sense_of", "text_of"]
