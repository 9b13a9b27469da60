"""What a goal is weighed against: a limit, a measure or a response in words, as the bound that is moved."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.balancing import is_rotor
from vibopt.document.mistakes import Mistakes
from vibopt.errors import InputError, way_out
from vibopt.jobs import answer, facts, is_scene, of_document

if TYPE_CHECKING:
    from vibopt.jobs import Job

_WORDS = re.compile(r"\s+(of|into|through|across|over|at|due_to)\s+")


def bounded(job: Job, against: str) -> tuple[Job, str]:
    """The job with the bound that is moved, and its path; a response in words becomes a limit called as it is."""
    if against.startswith("limits."):
        return job, _side(job, against)
    if is_rotor(job):
        known = [f"limits.{one}" for one in job.document.get("limits", {})]
        way = f"Write --against {known[0]}." if known else "Add [limits.NAME] with an at_most."
        raise InputError(
            f"{job.name}: --against {against} is no limit, and a measured rotor is weighed against its limits. {way}"
        )
    words = against.removeprefix("most ")
    side = "at_least" if words != against else "at_most"
    name = words.removeprefix("measures.")
    tables = dict(job.document.get("measures", {}))
    table: Any = tables.pop(name, None) if words.startswith("measures.") else _table(words)
    if table is None:
        known = [*(f"limits.{one}" for one in job.document.get("limits", {})), *(f"measures.{one}" for one in tables)]
        raise InputError(f"{job.name}: --against {against} is none of its limits or measures.{way_out(against, known)}")
    name = name if words.startswith("measures.") else str(table["response"])
    while name in job.document.get("limits", {}) or name in tables:
        name += "_2"
    document = {**job.document, "measures": {**tables, name: dict(table)}}
    try:
        measured = of_document(document, Mistakes(job.name, None))
    except InputError as error:
        words = f'--against "{against}": measure'
        raise InputError([message.replace(f"measures.{name}", words) for message in error.messages]) from None
    if is_scene(measured) and measured.measures[name].complement and side == "at_most":
        raise InputError(
            f'{job.name}: --against "{against}" is to be as small as can be, and an isolation is better the greater it '
            f'is. Write --against "most {against}".'
        )
    found = answer(measured, explain=False)
    row = found.measures.get(name)
    if row is not None and row.value.value == 0.0 and side == "at_most":
        raise InputError(
            f"{job.name}: --against {against} and the goal are best in one and the same design, which leaves nothing "
            "of it: there is nothing to weigh."
        )
    if row is None or not 0.0 < row.value.value < np.inf:
        raise InputError(f"{job.name}: --against {against}: the best design has no such value to begin from.")
    bound = f"{row.value.value:.17g} {row.value.si}".strip()
    limits = {**job.document.get("limits", {}), name: {**table, side: bound}}
    kept = {key: one for key, one in {**job.document, "measures": tables, "limits": limits}.items() if one}
    return of_document(kept, Mistakes(job.name, None)), f"limits.{name}.{side}"


def _side(job: Job, against: str) -> str:
    ends = tuple(f"{against}{end}" for end in ("", ".at_most", ".at_least"))
    bounds = [fact.path for fact in facts(job) if re.fullmatch(r"limits\..+\.at_(most|least)", fact.path)]
    sides = [path for path in bounds if path in ends]
    if len(sides) > 1:
        raise InputError(f"{job.name}: --against {against} has two sides. Name one: {' or '.join(sides)}.")
    if not sides:
        known = dict.fromkeys(path.rpartition(".")[0] for path in bounds)
        raise InputError(
            f"{job.name}: --against {against} is no limit with at_most or at_least.{way_out(against, known)}"
        )
    return sides[0]


def _table(words: str) -> dict[str, str] | None:
    """A response in words as its table; None where the words have no place in them."""
    parts = _WORDS.split(words.strip())
    pairs: dict[str, str] = dict(zip(parts[1::2], parts[2::2], strict=True))
    return {"response": parts[0].strip().replace(" ", "_"), **pairs} if re.fullmatch(r"[a-z_ ]+", parts[0]) else None
