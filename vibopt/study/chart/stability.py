"""Stability: every method on hard ground, each answer classed from right to silently wrong."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from vibopt.study.chart.cases import Case
from vibopt.study.chart.hard import ends_of, families, quick_families
from vibopt.study.chart.speed_accuracy import Progress
from vibopt.study.chart.trial import DEFAULT, REFUSES, RIGHT, SAYS_SO, SILENT, UNPROVEN, Trial, trial, warm_up

METHODS = (DEFAULT, "branch_and_bound", "nlp", "grid", "slsqp", "trust_constr", "ipopt_sampled", "cvxpy")
QUICK_METHODS = tuple(name for name in METHODS if name != "trust_constr")
CLASSES = (RIGHT, SAYS_SO, UNPROVEN, SILENT, REFUSES)
PATIENCE = 2.0
"""Seconds that a method with a time limit gets per case."""
QUICK_SECONDS, FULL_SECONDS = 45.0, 270.0


@dataclass(frozen=True, slots=True)
class Stability:
    """All trials; `skipped` names those for which there was no time (case, method)."""

    cases: tuple[Case, ...]
    methods: tuple[str, ...]
    trials: tuple[Trial, ...]
    skipped: tuple[tuple[str, str], ...]

    @property
    def families(self) -> list[str]:
        return list(dict.fromkeys(case.family for case in self.cases))

    def count(self, family: str, method: str) -> Counter[str]:
        """How often each class occurs."""
        names = {case.name for case in self.cases if case.family == family}
        return Counter(one.verdict for one in self.trials if one.case in names and one.method == method)


def stability(
    *,
    cases: Sequence[Case] | None = None,
    methods: Sequence[str] | None = None,
    quick: bool = False,
    progress: Progress | None = None,
) -> Stability:
    """Run every method once on every case; with `quick` on two cases of each family."""
    cases = (quick_families() if quick else families()) if cases is None else ends_of(cases) if quick else cases
    chosen = tuple(methods or (QUICK_METHODS if quick else METHODS))
    deadline = time.perf_counter() + (QUICK_SECONDS if quick else FULL_SECONDS)
    warm_up(list(chosen))
    trials: list[Trial] = []
    skipped: list[tuple[str, str]] = []
    for number, case in enumerate(cases):
        scene = case.scene()
        for method in chosen:
            if progress:
                progress(f"{case.name}: {method}", (number + chosen.index(method) / len(chosen)) / len(cases))
            if time.perf_counter() > deadline:
                skipped.append((case.name, method))
                continue
            trials.append(trial(case, scene, method, 1, PATIENCE))
    return Stability(tuple(cases), chosen, tuple(trials), tuple(skipped))
