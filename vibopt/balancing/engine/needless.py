"""Limits and caps of an engine that are touched, and without which its goal would be no better."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from math import inf

from vibopt.balancing.engine.choose_weights import Known, box_of, caps_of, goal_table, moved, size_of, weigh
from vibopt.balancing.engine.engine_job import EngineJob
from vibopt.balancing.engine.shaking import arms

_AS_GOOD = 3e-8
"""Part of all forces within which two goals are the same: the lightest of equal weights are taken within a third."""


def needless(job: EngineJob, touched: Collection[str], caps: Mapping[str, str]) -> frozenset[str]:
    """Of what is touched, what can be left out together without a better goal; nothing where cranks are chosen.

    Where several weights are as good, those that were taken may touch what holds nothing back.

    Parameters
    ----------
    touched
        Limits by name, caps by what stands for them.
    caps
        What stands for a cap, by its path.
    """
    known: dict[str, Known] = {caps[one.path]: one for one in caps_of(job) if one.path in caps}
    known = {name: one for name, one in {**known, **job.limits}.items() if name in touched}
    if job.is_search or job.goal is None or not known or not box_of(job).size:
        return frozenset()
    here = arms(job, tuple(0.0 if crank is None else crank for crank in job.cranks))
    best = weigh(job, here)
    if best.x is None:
        return frozenset()
    least = best.value - _AS_GOOD * size_of(job, goal_table(job).is_couple)
    left: set[str] = set()
    for name in sorted(known):
        without = moved(job, name, known[name], inf)
        found = weigh(without, here)
        if found.x is not None and found.value >= least:
            job = without
            left.add(name)
    return frozenset(left)
