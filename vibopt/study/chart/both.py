"""The charts over both kinds of stock cases, isolation and balancing, or over one of them."""

from __future__ import annotations

from collections.abc import Sequence

from vibopt.scene.scene import Scene
from vibopt.study.chart import fidelity as isolation_fidelity
from vibopt.study.chart import speed_accuracy as isolation_speed
from vibopt.study.chart import stability as isolation_stability
from vibopt.study.chart.balancing import charts as balancing
from vibopt.study.chart.balancing import fidelity as balancing_fidelity
from vibopt.study.chart.fidelity import Fidelity
from vibopt.study.chart.speed_accuracy import Progress, SpeedAccuracy
from vibopt.study.chart.stability import Stability

ISOLATION, BALANCING = "isolation", "balancing"


def speed_accuracy(
    scenes: Sequence[Scene] = (), *, family: str | None = None, quick: bool = False, progress: Progress | None = None
) -> SpeedAccuracy:
    """The user's scenes alone where there are any, else the stock cases of a family (None: of both)."""
    if scenes or family == ISOLATION:
        return isolation_speed.speed_accuracy(scenes, quick=quick, progress=progress)
    b = balancing.speed_accuracy(quick=quick, progress=progress)
    if family == BALANCING:
        return b
    a = isolation_speed.speed_accuracy(quick=quick, progress=progress)
    return SpeedAccuracy(a.cases + b.cases, _joined(a, b), a.trials + b.trials, a.skipped + b.skipped)


def stability(*, family: str | None = None, quick: bool = False, progress: Progress | None = None) -> Stability:
    """Hard ground of a family (None: of both)."""
    if family == ISOLATION:
        return isolation_stability.stability(quick=quick, progress=progress)
    b = balancing.stability(quick=quick, progress=progress)
    if family == BALANCING:
        return b
    a = isolation_stability.stability(quick=quick, progress=progress)
    return Stability(a.cases + b.cases, _joined(a, b), a.trials + b.trials, a.skipped + b.skipped)


def fidelity(
    scenes: Sequence[Scene] = (), *, family: str | None = None, quick: bool = False, progress: Progress | None = None
) -> tuple[Fidelity, ...]:
    """The user's scenes alone where there are any, else the stock cases of a family (None: of both)."""
    if scenes or family == ISOLATION:
        return isolation_fidelity.fidelity(scenes, quick=quick, progress=progress)
    own = balancing_fidelity.fidelity(quick=quick, progress=progress)
    return own if family == BALANCING else isolation_fidelity.fidelity(quick=quick, progress=progress) + own


def asked(result: Stability, family: str) -> tuple[str, ...]:
    """Methods that a family of cases was given to, whether or not there was time."""
    names = {case.name for case in result.cases if case.family == family}
    given = {one.method for one in result.trials if one.case in names}
    given |= {method for case, method in result.skipped if case in names}
    return tuple(method for method in result.methods if method in given)


def _joined(one: SpeedAccuracy | Stability, other: SpeedAccuracy | Stability) -> tuple[str, ...]:
    return tuple(dict.fromkeys((*one.methods, *other.methods)))
