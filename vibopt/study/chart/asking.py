"""The order in which a chart asks: vibopt on every case first, then everybody else case by case."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

from vibopt.study.chart.trial import DEFAULT, Trial

Progress = Callable[[str, float], None]
Asked = TypeVar("Asked")


def trials_of(
    cases: Sequence[tuple[str, Asked]],
    methods: Sequence[str],
    ask: Callable[[Asked, str], Trial],
    progress: Progress | None = None,
) -> tuple[Trial, ...]:
    """Every method on every case, given by name.

    Returns
    -------
    tuple of Trial
        Case by case, each in the order of the methods; vibopt was asked first wherever it is among them.
    """
    own = [DEFAULT] if DEFAULT in methods else []
    pairs = [(index, method) for method in own for index in range(len(cases))]
    pairs += [(index, method) for index in range(len(cases)) for method in methods if method != DEFAULT]
    found: dict[tuple[int, str], Trial] = {}
    for number, (index, method) in enumerate(pairs):
        name, case = cases[index]
        if progress:
            progress(f"{name}: {method}", number / len(pairs))
        found[index, method] = ask(case, method)
    return tuple(found[index, method] for index in range(len(cases)) for method in methods)
