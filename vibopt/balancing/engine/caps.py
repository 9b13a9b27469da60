"""The greatest weights and shares that an engine's file allows, which cost something where they bind."""

from __future__ import annotations

from dataclasses import replace
from math import isfinite

import numpy as np

from vibopt.balancing.engine.job import EngineJob
from vibopt.balancing.engine.program import Lengths
from vibopt.balancing.engine.shaking import free_shares, free_weights
from vibopt.balancing.engine.solve import Balanced, box_of
from vibopt.records import dataclass


@dataclass(frozen=True, slots=True)
class Cap:
    """The upper end of what is chosen: an unbalance [kg m], or a share [1].

    path
        In the file: "counterweights.front.unbalance", "engine.counterweight_share".
    weight, share
        Index of the weight, or name of the share.
    """

    path: str
    bound: float
    unit: str
    dimension: str
    weight: int | None = None
    share: str = ""

    def columns(self, job: EngineJob) -> list[int]:
        """Its places in the choices x."""
        shares = free_shares(job)
        if self.weight is None:
            return [[one.name for one in shares].index(self.share)]
        first = len(shares) + 2 * free_weights(job).index(self.weight)
        return [first, first + 1]

    def reached(self, job: EngineJob, found: Balanced) -> float:
        """Part of it that an answer takes."""
        return float(np.linalg.norm(found.x[self.columns(job)])) / self.bound

    def size(self, job: EngineJob) -> Lengths:
        """What it bounds as a length of the choices."""
        slope = np.zeros((1, box_of(job).size), dtype=complex)
        slope[0, self.columns(job)] = (1.0, 1j)[: len(self.columns(job))]
        return Lengths(np.zeros(1, dtype=complex), slope)


def caps_of(job: EngineJob) -> list[Cap]:
    """All of them, shares first."""
    found = [Cap(f"engine.{one.name}", one.high, "%", "ratio", share=one.name) for one in free_shares(job)]
    for index in free_weights(job):
        one = job.weights[index]
        if isfinite(one.cap):
            path = f"{one.family}.{one.name}.unbalance"
            found.append(Cap(path, one.cap, one.unit, "unbalance", weight=index))
    return found


def wider(job: EngineJob, cap: Cap, bound: float) -> EngineJob:
    """The job with one of them at another bound."""
    if cap.weight is None:
        shares = tuple(replace(one, high=max(bound, one.low)) if one.name == cap.share else one for one in job.shares)
        return replace(job, shares=shares)
    weights = list(job.weights)
    weights[cap.weight] = replace(weights[cap.weight], cap=bound)
    return replace(job, weights=tuple(weights))
