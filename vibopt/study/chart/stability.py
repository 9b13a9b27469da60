"""Stability: every method on hard ground, each answer classed from right to silently wrong."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from vibopt.study.chart.asking import Progress, trials_of
from vibopt.study.chart.cases import Case
from vibopt.study.chart.hard import ends_of, families, quick_families
from vibopt.study.chart.trial import DEFAULT, REFUSES, RIGHT, SAYS_SO, SILENT, UNPROVEN, Trial, trial, warm_up

METHODS = (
    DEFAULT, "branch_and_bound", "nlp", "grid", "slsqp", "slsqp_exchange", "trust_constr", "ipopt_sampled", "cvxpy",
)  # fmt: skip
QUICK_METHODS = tuple(name for name in METHODS if name != "trust_constr")
CLASSES = (RIGHT, SAYS_SO, UNPROVEN, SILENT, REFUSES)


@dataclass(frozen=True, slots=True)
class Stability:
    """All trials, one for each method on each case of the families it is given to."""

    cases: tuple[Case, ...]
    methods: tuple[str, ...]
    trials: tuple[Trial, ...]

    @property
    def families(self) -> list[str]:
        return list(dict.fromkeys(case.family for case in self.cases))

    @property
    def cut(self) -> tuple[Trial, ...]:
        """Trials that were asked less than the chart promises."""
        return tuple(one for one in self.trials if one.cut)

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
    warm_up(list(chosen))
    trials = trials_of(
        [(case.name, (case, case.scene())) for case in cases],
        chosen,
        lambda pair, method: trial(*pair, method, 1),
        progress,
    )
    return Stability(tuple(cases), chosen, trials)
