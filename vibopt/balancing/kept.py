"""The plan of a balancing job as facts of its file: the same job with nothing left to choose."""

from __future__ import annotations

import copy
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from vibopt.answer.entry import Entry
from vibopt.balancing.fitted import decided
from vibopt.balancing.planes import Fitted, Plane
from vibopt.units import to_unit

if TYPE_CHECKING:
    from vibopt.answer.answer import Answer
    from vibopt.balancing.engine.engine_job import EngineJob
    from vibopt.balancing.known.known_job import KnownJob
    from vibopt.balancing.rotor_job import RotorJob

MINIMISED = "minimised"
"""Name of the measure that the goal of an engine becomes."""


def of_planes(job: RotorJob | KnownJob, plan: Answer[Any]) -> dict[str, Any]:
    """The file of a measured rotor, or of known masses, with the weights of the first answer."""
    weights = [
        [Fitted(one.mass, one.radius or plane.radius, one.angle, one.hole) for one in answer.weights]
        for plane, answer in zip(job.planes, plan.plan.fittings[0].planes, strict=True)
    ]
    return _with_weights(job.document, job.planes, weights)


def _with_weights(
    given: Mapping[str, Any], planes: Sequence[Plane], weights: Sequence[Iterable[Fitted]]
) -> dict[str, Any]:
    document = _bare(given)
    document.pop("pairs", None)
    for plane, own in zip(planes, weights, strict=True):
        if plane.is_open:
            document["planes"][plane.name] = decided(document["planes"][plane.name], plane, own)
    return document


def of_engine(job: EngineJob, found: Answer[Any]) -> dict[str, Any]:
    """The file of an engine with its cranks, shares and weights; what was made least is measured."""
    document = _bare(job.document)
    for path in job.choices:
        family, *rest = path.split(".")
        entry = found.find(path)
        assert isinstance(entry, Entry)
        unit = entry.unit or "g mm"
        text = f"{to_unit(float(entry.value), unit, entry.dimension):.15g} {unit}" if entry.dimension != "ratio" else ""
        if family == "cylinders":
            document["cylinders"][int(rest[0]) - 1]["crank"] = text
        elif rest:
            document[family][rest[0]][rest[1]] = text
        else:
            document["engine"][family] = float(entry.value)
    document["engine"].pop("cranks", None)
    goal = document.pop("goal", None)
    if goal is not None:
        measure = {"response": goal["minimise"], **({"order": goal["order"]} if "order" in goal else {})}
        document.setdefault("measures", {}).setdefault(MINIMISED, measure)
    return document


def _bare(given: Mapping[str, Any]) -> dict[str, Any]:
    document = copy.deepcopy(dict(given))
    document.pop("expected", None)
    return document


__all__ = ["MINIMISED", "of_engine", "of_planes"]
