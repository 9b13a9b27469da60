"""The charts over all kinds of stock cases, or over one of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from vibopt.errors import InputError
from vibopt.scene.scene import Scene
from vibopt.scene.settle import open_places
from vibopt.scene.uncertain import uncertain
from vibopt.study.chart import fidelity as isolation_fidelity
from vibopt.study.chart import speed_accuracy as isolation_speed
from vibopt.study.chart import stability as isolation_stability
from vibopt.study.chart.absorbers import charts as absorbers
from vibopt.study.chart.absorbers import fidelity as absorbers_fidelity
from vibopt.study.chart.asking import Progress
from vibopt.study.chart.balancing import charts as balancing
from vibopt.study.chart.balancing import fidelity as balancing_fidelity
from vibopt.study.chart.fidelity import Fidelity
from vibopt.study.chart.mounts import charts as mounts
from vibopt.study.chart.mounts import fidelity as mounts_fidelity
from vibopt.study.chart.mounts.own import has_parts
from vibopt.study.chart.speed_accuracy import SpeedAccuracy
from vibopt.study.chart.stability import Stability

ISOLATION, ABSORBERS, BALANCING, MOUNTS = KINDS = ("isolation", "absorbers", "balancing", "mounts")
_SPEED: dict[str, Callable[..., SpeedAccuracy]] = {
    ISOLATION: isolation_speed.speed_accuracy,
    ABSORBERS: absorbers.speed_accuracy,
    BALANCING: balancing.speed_accuracy,
    MOUNTS: mounts.speed_accuracy,
}
_STABILITY: dict[str, Callable[..., Stability]] = {
    ISOLATION: isolation_stability.stability,
    ABSORBERS: absorbers.stability,
    BALANCING: balancing.stability,
    MOUNTS: mounts.stability,
}
_FIDELITY: dict[str, Callable[..., tuple[Fidelity, ...]]] = {
    ISOLATION: isolation_fidelity.fidelity,
    ABSORBERS: absorbers_fidelity.fidelity,
    BALANCING: balancing_fidelity.fidelity,
    MOUNTS: mounts_fidelity.fidelity,
}


def _chosen(family: str | None) -> tuple[str, ...]:
    return (family,) if family is not None else KINDS


def speed_accuracy(
    scenes: Sequence[Scene] = (), *, family: str | None = None, quick: bool = False, progress: Progress | None = None
) -> SpeedAccuracy:
    """The user's scenes alone where there are any, else the stock cases of a family (None: of all).

    Raises
    ------
    InputError
        A scene asks what the other methods of the chart cannot.
    """
    if scenes:
        for scene in scenes:
            _refuse_more(scene)
        bought = [one for one in scenes if has_parts(one)]
        others = [one for one in scenes if not has_parts(one)]
        roads = [(mounts.speed_accuracy, bought), (isolation_speed.speed_accuracy, others)]
        parts = [road(given, quick=quick, progress=progress) for road, given in roads if given]
    else:
        parts = [_SPEED[kind](quick=quick, progress=progress) for kind in _chosen(family)]
    return SpeedAccuracy(
        tuple(case for one in parts for case in one.cases),
        _joined(parts),
        tuple(row for one in parts for row in one.trials),
    )


def stability(*, family: str | None = None, quick: bool = False, progress: Progress | None = None) -> Stability:
    """Hard ground of a family (None: of all)."""
    parts = [_STABILITY[kind](quick=quick, progress=progress) for kind in _chosen(family)]
    return Stability(
        tuple(case for one in parts for case in one.cases),
        _joined(parts),
        tuple(row for one in parts for row in one.trials),
    )


def fidelity(
    scenes: Sequence[Scene] = (), *, family: str | None = None, quick: bool = False, progress: Progress | None = None
) -> tuple[Fidelity, ...]:
    """The user's scenes alone where there are any, else the stock cases of a family (None: of all).

    Raises
    ------
    InputError
        A scene leaves places open.
    """
    for scene in scenes:
        _refuse_places(scene)
    if scenes:
        return isolation_fidelity.fidelity(scenes, quick=quick, progress=progress)
    return tuple(row for kind in _chosen(family) for row in _FIDELITY[kind](quick=quick, progress=progress))


def asked(result: Stability, family: str) -> tuple[str, ...]:
    """Methods that a family of cases was given to."""
    names = {case.name for case in result.cases if case.family == family}
    given = {one.method for one in result.trials if one.case in names}
    return tuple(method for method in result.methods if method in given)


def _refuse_more(scene: Scene) -> None:
    """Places and tolerances, which vibopt would answer and the others not: their numbers could not be compared."""
    _refuse_places(scene)
    found = uncertain(scene)
    if found and not has_parts(scene):
        raise InputError(
            f"{scene.name}: {found[0].path} has a tolerance, and the other methods of the chart know none. Remove it."
        )


def _refuse_places(scene: Scene) -> None:
    for path in open_places(scene):
        raise InputError(
            f"{scene.name}: {path} leaves several places open, and the chart compares one machine at a time. Name one "
            "place."
        )


def _joined(parts: Sequence[SpeedAccuracy | Stability]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(method for one in parts for method in one.methods))
