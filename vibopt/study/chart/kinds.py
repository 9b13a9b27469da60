"""The charts over all kinds of stock cases, or over one of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from vibopt.scene.scene import Scene
from vibopt.study.chart import fidelity as isolation_fidelity
from vibopt.study.chart import speed_accuracy as isolation_speed
from vibopt.study.chart import stability as isolation_stability
from vibopt.study.chart.absorbers import charts as absorbers
from vibopt.study.chart.absorbers import fidelity as absorbers_fidelity
from vibopt.study.chart.balancing import charts as balancing
from vibopt.study.chart.balancing import fidelity as balancing_fidelity
from vibopt.study.chart.fidelity import Fidelity
from vibopt.study.chart.speed_accuracy import Progress, SpeedAccuracy
from vibopt.study.chart.stability import Stability

ISOLATION, ABSORBERS, BALANCING = KINDS = ("isolation", "absorbers", "balancing")
_SPEED: dict[str, Callable[..., SpeedAccuracy]] = {
    ISOLATION: isolation_speed.speed_accuracy,
    ABSORBERS: absorbers.speed_accuracy,
    BALANCING: balancing.speed_accuracy,
}
_STABILITY: dict[str, Callable[..., Stability]] = {
    ISOLATION: isolation_stability.stability,
    ABSORBERS: absorbers.stability,
    BALANCING: balancing.stability,
}
_FIDELITY: dict[str, Callable[..., tuple[Fidelity, ...]]] = {
    ISOLATION: isolation_fidelity.fidelity,
    ABSORBERS: absorbers_fidelity.fidelity,
    BALANCING: balancing_fidelity.fidelity,
}


def _chosen(family: str | None) -> tuple[str, ...]:
    return (family,) if family is not None else KINDS


def speed_accuracy(
    scenes: Sequence[Scene] = (), *, family: str | None = None, quick: bool = False, progress: Progress | None = None
) -> SpeedAccuracy:
    """The user's scenes alone where there are any, else the stock cases of a family (None: of all)."""
    if scenes:
        return isolation_speed.speed_accuracy(scenes, quick=quick, progress=progress)
    parts = [_SPEED[kind](quick=quick, progress=progress) for kind in _chosen(family)]
    return SpeedAccuracy(
        tuple(case for one in parts for case in one.cases),
        _joined(parts),
        tuple(row for one in parts for row in one.trials),
        tuple(pair for one in parts for pair in one.skipped),
    )


def stability(*, family: str | None = None, quick: bool = False, progress: Progress | None = None) -> Stability:
    """Hard ground of a family (None: of all)."""
    parts = [_STABILITY[kind](quick=quick, progress=progress) for kind in _chosen(family)]
    return Stability(
        tuple(case for one in parts for case in one.cases),
        _joined(parts),
        tuple(row for one in parts for row in one.trials),
        tuple(pair for one in parts for pair in one.skipped),
    )


def fidelity(
    scenes: Sequence[Scene] = (), *, family: str | None = None, quick: bool = False, progress: Progress | None = None
) -> tuple[Fidelity, ...]:
    """The user's scenes alone where there are any, else the stock cases of a family (None: of all)."""
    if scenes:
        return isolation_fidelity.fidelity(scenes, quick=quick, progress=progress)
    return tuple(row for kind in _chosen(family) for row in _FIDELITY[kind](quick=quick, progress=progress))


def asked(result: Stability, family: str) -> tuple[str, ...]:
    """Methods that a family of cases was given to, whether or not there was time."""
    names = {case.name for case in result.cases if case.family == family}
    given = {one.method for one in result.trials if one.case in names}
    given |= {method for case, method in result.skipped if case in names}
    return tuple(method for method in result.methods if method in given)


def _joined(parts: Sequence[SpeedAccuracy | Stability]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(method for one in parts for method in one.methods))
