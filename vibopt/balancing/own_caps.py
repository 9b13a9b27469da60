"""Caps of the planes themselves: the greatest weight of each, and the greatest depth of its holes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import isfinite
from typing import Any, TypeVar, cast

from vibopt.answer.plan import Weight
from vibopt.arrays import ComplexArray, FloatArray
from vibopt.balancing.planes import Corrected, Plane
from vibopt.balancing.question import Question
from vibopt.records import dataclass

J = TypeVar("J", bound=Corrected)


@dataclass(frozen=True, slots=True)
class OwnCap:
    """The greatest weight of a plane [kg; kg m without a radius], or the greatest depth of its holes [m].

    name
        Path in the file, "planes.left.weight".
    drilled
        Whether it is the depth.
    """

    name: str
    plane: int
    owner: Plane
    at_most: float
    unit: str
    drilled: bool = False

    @property
    def dimension(self) -> str:
        return "length" if self.drilled else self.owner.dimension

    def measured(self, question: Question, u: ComplexArray, masses: FloatArray) -> float:
        """What the corrections u (n_planes,) with their `masses` take of it."""
        alone, own = float(masses[self.plane]), complex(u[self.plane])
        if not self.drilled or self.owner.drill is None:
            return alone
        fan = question.fans[self.plane] if question.fans else None
        return self.owner.drill.depth(alone if fan is None else float(fan.greatest(own)) / self.owner.radius)

    def taken(self, weights: Sequence[Weight]) -> float:
        """What the weights of its plane take of it."""
        if not self.drilled or self.owner.drill is None:
            return sum((one.mass for one in weights), 0.0)
        return max((self.owner.drill.depth(one.mass) for one in weights), default=0.0)

    def moved(self, job: J, at_most: float) -> J:
        """The job with another cap."""
        if self.drilled and self.owner.drill is not None:
            plane = replace(self.owner, drill=replace(self.owner.drill, deepest=at_most))
        else:
            plane = replace(self.owner, cap=at_most)
        planes = (*job.planes[: self.plane], plane, *job.planes[self.plane + 1 :])
        return cast(J, replace(cast(Any, job), planes=planes))


def own_caps(job: Corrected) -> tuple[OwnCap, ...]:
    """Caps of the planes that may be changed, in the order of the file."""
    found = []
    for index, plane in enumerate(job.planes):
        drill = plane.drill if not plane.is_discrete else None
        if isfinite(plane.cap) and not plane.keep:
            key = "unbalance" if "unbalance" in job.document.get("planes", {}).get(plane.name, {}) else "weight"
            found.append(OwnCap(f"planes.{plane.name}.{key}", index, plane, plane.cap, plane.unit))
        if drill is not None and isfinite(drill.deepest) and not plane.keep:
            found.append(OwnCap(f"planes.{plane.name}.drill", index, plane, drill.deepest, "mm", drilled=True))
    return tuple(found)
