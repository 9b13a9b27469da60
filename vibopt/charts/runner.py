"""The charts over all families of cases, or over one of them; one runner for all."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from functools import cache, partial
from types import ModuleType
from typing import Any

from vibopt.charts import (
    absorber_cases,
    balancing_cases,
    friction_cases,
    isolation_cases,
    mount_fidelity,
    run_up_cases,
    shock_cases,
)
from vibopt.charts import own_scenes as own
from vibopt.charts.fidelity import Fidelity, on_both_models
from vibopt.charts.runs import run
from vibopt.charts.trial import DEFAULT, Case, Table, Trial, filed
from vibopt.charts.verdicts import REFUSES
from vibopt.records import dataclass
from vibopt.scene.scene import Scene

Progress = Callable[[str, float], None]
FAMILIES: Mapping[str, ModuleType] = {
    "isolation": isolation_cases, "absorbers": absorber_cases, "balancing": balancing_cases, "mounts": mount_fidelity,
    "shock": shock_cases, "run_up": run_up_cases, "friction": friction_cases,
}  # fmt: skip
"""Each has its cases and methods as tables, `speed` and `hard`; and rows of `fidelity` where a model can be smaller."""


@dataclass(frozen=True, slots=True)
class Chart:
    """All trials, one for each method on each case that it is given to."""

    cases: tuple[Case, ...]
    methods: tuple[str, ...]
    trials: tuple[Trial, ...]
    left: tuple[str, ...] = ()
    """What only the whole chart asks, where this is a shorter one."""

    @classmethod
    def joined(cls, parts: Sequence[Chart]) -> Chart:
        """Several charts as one."""
        methods = dict.fromkeys(method for part in parts for method in part.methods)
        cases = tuple(case for part in parts for case in part.cases)
        left = tuple(dict.fromkeys(name for part in parts for name in part.left))
        return cls(cases, tuple(methods), tuple(trial for part in parts for trial in part.trials), left)

    @property
    def families(self) -> list[str]:
        return list(dict.fromkeys(case.family for case in self.cases))

    @property
    def cut(self) -> tuple[Trial, ...]:
        """Trials that were asked less than the chart promises."""
        return tuple(trial for trial in self.trials if trial.cut)

    def of(self, case: str) -> list[Trial]:
        """Trials of one case that gave any answer to its question, in the order of the methods."""
        return [trial for trial in self.trials if trial.case == case and trial.status != REFUSES]

    def ratio(self, trial: Trial) -> float:
        """Time over that of the default on the same case."""
        base = next((t.seconds for t in self.trials if t.case == trial.case and t.method == DEFAULT), math.nan)
        return trial.seconds / base

    def asked(self, family: str) -> tuple[str, ...]:
        """Methods that a family of cases was given to."""
        names = {case.name for case in self.cases if case.family == family}
        given = {trial.method for trial in self.trials if trial.case in names}
        return tuple(method for method in self.methods if method in given)

    def verdicts(self, family: str, method: str) -> list[str]:
        """Class of each answer, in the order of the cases."""
        names = {case.name for case in self.cases if case.family == family}
        return [trial.verdict for trial in self.trials if trial.case in names and trial.method == method]

    def count(self, family: str, method: str) -> Counter[str]:
        """How often each class occurs."""
        return Counter(self.verdicts(family, method))


def charted(table: Table, progress: Progress | None = None) -> Chart:
    """Every method on every case: vibopt on all of them first, then everybody else case by case.

    Returns
    -------
    Chart
        Trials case by case, each in the order of the methods.
    """
    warm = cache(
        lambda: [table.tried(case, given, method, 1) for case, given in table.warm for method in table.methods]
    )
    own_pairs = [(i, DEFAULT) for i in range(len(table.cases))] if DEFAULT in table.methods else []
    pairs = own_pairs + [(i, method) for i in range(len(table.cases)) for method in table.methods if method != DEFAULT]
    found: dict[tuple[int, str], Trial] = {}
    for number, (index, method) in enumerate(pairs):
        case, given = table.cases[index]
        if progress:
            progress(f"{case.name}: {method}", number / len(pairs))
        tried = partial(_tried, warm, table, case, given, method)
        found[index, method] = run(f"{case.name}: {method}", Trial, tried)[0]
    trials = [found[index, method] for index in range(len(table.cases)) for method in table.methods]
    answering = {trial.method for trial in trials if trial.status != REFUSES}
    methods = tuple(name for name in table.methods if name in answering or not table.drops)
    kept = tuple(trial for trial in trials if trial.method in methods)
    return Chart(tuple(filed(*pair) for pair in table.cases), methods, kept, tuple(table.left))


def _tried(warm: Callable[[], Any], table: Table, case: Case, given: Any, method: str) -> list[Trial]:
    """A run, once what all of them need is loaded."""
    warm()
    return [table.tried(case, given, method)]


def speed_accuracy(
    scenes: Sequence[Scene] = (), *, family: str | None = None, quick: bool = False, progress: Progress | None = None
) -> Chart:
    """The user's scenes alone where there are any, else the stock cases of a family (None: of all).

    Raises
    ------
    InputError
        A scene asks what the other methods of the chart cannot.
    """
    if not scenes:
        return Chart.joined([charted(module_type.speed(quick=quick), progress) for module_type in _chosen(family)])
    for scene in scenes:
        own.refuse_more(scene)
    most = own.QUICK_MOST if quick else own.MOST
    bought = [own.with_parts(scene, most) for scene in scenes if own.has_parts(scene)]
    parts = [Chart((case,), own.METHODS, tuple(trials)) for case, trials in bought]
    others = [scene for scene in scenes if not own.has_parts(scene)]
    if others:
        parts.append(charted(own.speed(others, quick=quick), progress))
    return Chart.joined(parts)


def stability(*, family: str | None = None, quick: bool = False, progress: Progress | None = None) -> Chart:
    """Hard ground of a family (None: of all), each answer classed from right to silently wrong."""
    return Chart.joined([charted(module_type.hard(quick=quick), progress) for module_type in _chosen(family)])


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
        own.refuse_places(scene)
    made = on_both_models(scenes, quick=quick)
    makers = made if scenes else _rows(family, quick=quick)
    found: list[Fidelity] = []
    for number, (name, make) in enumerate(makers):
        if progress:
            progress(name, number / len(makers))
        found += run(name, Fidelity, make)
    return tuple(found)


def fidelity_left(family: str | None) -> tuple[str, ...]:
    """Rows that only the whole chart of fidelity asks."""
    asked = {name for name, _ in _rows(family, quick=True)}
    left = [name for name, _ in _rows(family, quick=False) if name not in asked]
    return (*([f"cases {', '.join(left)}"] if left else []), "further runs of each")


def _rows(family: str | None, *, quick: bool) -> list[tuple[str, Callable[[], Sequence[Fidelity]]]]:
    return [
        row
        for module_type in _chosen(family)
        if hasattr(module_type, "fidelity")
        for row in module_type.fidelity(quick=quick)
    ]


def _chosen(family: str | None) -> list[ModuleType]:
    return [FAMILIES[family]] if family is not None else list(FAMILIES.values())
