"""Caps of the planes themselves, which cost something where they bind: the greatest weight, the deepest hole."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import isfinite

import numpy as np

from vibopt.balancing.job import RotorJob
from vibopt.balancing.planes import Plane
from vibopt.balancing.question import Question


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

    def measured(self, question: Question, u: complex) -> float:
        """What the correction u of the plane takes of it."""
        only = np.zeros(question.n_planes, dtype=complex)
        only[self.plane] = u
        alone = float(question.masses(only)[self.plane])
        if not self.drilled or self.owner.drill is None:
            return alone
        fan = question.rims[self.plane] if question.rims else None
        most = alone if fan is None else float(fan.greatest(u)) / self.owner.radius
        return self.owner.drill.depth(most)


def own_caps(job: RotorJob) -> tuple[OwnCap, ...]:
    """Caps of the planes that may be changed, in the order of the file."""
    found = []
    for index in job.free:
        plane = job.planes[index]
        if isfinite(plane.cap):
            name = f"planes.{plane.name}.{_key(job, plane)}"
            found.append(OwnCap(name, index, plane, plane.cap, plane.unit))
        if plane.drill is not None and isfinite(plane.drill.deepest) and not plane.is_discrete:
            name = f"planes.{plane.name}.drill"
            found.append(OwnCap(name, index, plane, plane.drill.deepest, "mm", drilled=True))
    return tuple(found)


def _key(job: RotorJob, plane: Plane) -> str:
    """As the file says it."""
    return "unbalance" if "unbalance" in job.document.get("planes", {}).get(plane.name, {}) else "weight"


def with_wider(job: RotorJob, cap: OwnCap, factor: float) -> RotorJob:
    """The job with one cap `factor` times as great."""
    plane = cap.owner
    if cap.drilled and plane.drill is not None:
        wider = replace(plane, drill=replace(plane.drill, deepest=cap.at_most * factor))
    else:
        wider = replace(plane, cap=cap.at_most * factor)
    return replace(job, planes=(*job.planes[: cap.plane], wider, *job.planes[cap.plane + 1 :]))
