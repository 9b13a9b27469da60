"""Weights that are decided: read where a plane has a value and no range, and written by an answer that is kept."""

from __future__ import annotations

import copy
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from vibopt.answer.entry import Entry, direction
from vibopt.answer.plan import Weight
from vibopt.balancing.planes import Plane, read_fitted, text_of, unit_of
from vibopt.balancing.rotor_tables import read_each
from vibopt.document.mistakes import Mistakes, Path, dotted
from vibopt.units import to_unit

if TYPE_CHECKING:
    from vibopt.answer.answer import Answer
    from vibopt.balancing.engine.engine_job import EngineJob
    from vibopt.balancing.known.known_job import KnownJob
    from vibopt.balancing.rotor_job import RotorJob

_CHOOSING = ("shelf", "split", "forbidden", "keep")
"""Keys of a plane that say what may be chosen."""


def is_fitted(given: object) -> bool:
    """Whether weights are decided: texts that say where they sit."""
    return isinstance(given, list) or (isinstance(given, str) and ("@" in given or "hole" in given))


def with_fitted(path: Path, plane: Plane, table: Mapping[str, Any], mistakes: Mistakes) -> Plane:
    """The plane with the weights that its table decides."""
    key = "weight" if table.get("weight") is not None else "unbalance"
    given = table.get(key)
    if not is_fitted(given):
        return plane
    listed = given if isinstance(given, list) else [given]
    if idle := [word for word in _CHOOSING if table.get(word)]:
        mistakes.add(
            (*path, idle[0]),
            f"{dotted(path)} has {idle[0]}, which is for a weight that is chosen, but its {key} is decided. Leave "
            f"{idle[0]} out, or write {key} as a range {{ from, to }}.",
        )
        return plane
    fitted = read_each((*path, key), given, mistakes, read_fitted, plane)
    unit = next((unit for one in listed if (unit := unit_of(one, plane))), plane.unit)
    return replace(plane, fitted=tuple(fitted), unit=unit)


def _decided_table(table: Mapping[str, Any], plane: Plane, weights: Iterable[Weight]) -> dict[str, Any]:
    """The table of a plane with its weights as facts, and without what was there to choose them."""
    kept = {key: one for key, one in table.items() if key not in (*_CHOOSING, "weight", "unbalance", "most_weights")}
    if "drill" in kept:
        kept["drill"] = {key: one for key, one in kept["drill"].items() if key != "deepest"}
    texts = [text_of(weight, plane) for weight in weights]
    return {**kept, plane.kind_word: texts[0] if len(texts) == 1 else texts}


MINIMISED = "minimised"
"""Name of the measure that the goal of an engine becomes."""


def of_planes(job: RotorJob | KnownJob, plan: Answer[Any]) -> dict[str, Any]:
    """The file of a measured rotor, or of known masses, with the weights of the first answer."""
    document = _bare(job.document)
    document.pop("pairs", None)
    for plane, answer in zip(job.planes, plan.plan.fittings[0].planes, strict=True):
        if plane.is_open:
            document["planes"][plane.name] = _decided_table(document["planes"][plane.name], plane, answer.weights)
    return document


def of_engine(job: EngineJob, answer: Answer[Any]) -> dict[str, Any]:
    """The file of an engine with its cranks, shares and weights; what was made least is measured."""
    document, entries = _bare(job.document), answer.entries()
    for path in job.choices:
        family, *rest = path.split(".")
        entry = entries.get(path, direction(0.0))  # a weight of zero has no angle, and a fact needs one
        assert isinstance(entry, Entry)
        unit = entry.unit or "g mm"
        text = f"{to_unit(float(entry.value), unit, entry.dimension):.15g} {unit}" if entry.dimension != "ratio" else ""
        if family == "cylinders":
            document["cylinders"][int(rest[0]) - 1]["crank"] = text
        elif rest:
            document[family][rest[0]][rest[1]] = text
        else:
            document["engine"][family] = float(entry.value)
    return with_goal_measured(document)


def with_goal_measured(given: Mapping[str, Any]) -> dict[str, Any]:
    """The file of an engine of which nothing is open any more; what was made least is measured."""
    document = {**given, "engine": {key: one for key, one in given["engine"].items() if key != "cranks"}}
    goal = document.pop("goal", None)
    if goal is not None:
        measure = {"response": goal["minimise"], **({"order": goal["order"]} if "order" in goal else {})}
        measures = document.get("measures", {})
        document["measures"] = {**measures, MINIMISED: measures.get(MINIMISED, measure)}
    return document


def _bare(given: Mapping[str, Any]) -> dict[str, Any]:
    document = copy.deepcopy(dict(given))
    document.pop("expected", None)
    return document
