"""Jobs that balance something; their kinds are told by their word, so that nothing is loaded for it."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from typing_extensions import TypeIs

    from vibopt.balancing.engine.engine_job import EngineJob
    from vibopt.balancing.known.known_job import KnownJob
    from vibopt.balancing.rotor_job import RotorJob

    BalancingJob: TypeAlias = RotorJob | KnownJob | EngineJob

ROTOR, KNOWN, ENGINE = "rotor", "known", "engine"


def is_rotor(job: object) -> TypeIs[RotorJob]:
    return getattr(job, "kind", "") == ROTOR


def is_known(job: object) -> TypeIs[KnownJob]:
    return getattr(job, "kind", "") == KNOWN


def is_engine(job: object) -> TypeIs[EngineJob]:
    return getattr(job, "kind", "") == ENGINE
