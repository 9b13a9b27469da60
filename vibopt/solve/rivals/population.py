"""Differential evolution of SciPy and CMA-ES of the package `cma`, on exact peaks; both only compare points.

A point that breaks a limit is worse than every one that breaks none, and the worse the more it breaks (Deb, 2000).
"""

from __future__ import annotations

import warnings
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np

from vibopt.answer.entry import TOLERANCE
from vibopt.arrays import FloatArray
from vibopt.errors import counted
from vibopt.program.program import Program
from vibopt.records import dataclass
from vibopt.solve.branch import Judge
from vibopt.solve.method import Found, Progress
from vibopt.solve.ranges import log_box
from vibopt.solve.rivals.general import Continuous
from vibopt.work import late

HOW = "pip install cma"
_SEED, _CROWD = 1, 15
"""The seed; points per variable of a generation."""


class _Measured:
    """A point (n_vars,) of the unit cube of logs as a number to compare; the best that keeps every limit is kept."""

    def __init__(self, program: Program) -> None:
        self.program, self.judge = program, Judge(program)
        self.low, self.high = log_box(program)
        self.best: FloatArray | None = None
        self.least, self.count = np.inf, 0

    def design(self, u: FloatArray) -> FloatArray:
        """Variables [SI], (n_vars,)."""
        y = self.low + np.clip(u, 0.0, 1.0) * (self.high - self.low)
        return np.asarray(np.clip(np.exp(y), self.program.low, self.program.high))

    def __call__(self, u: FloatArray) -> float:
        self.count += 1
        x = self.design(np.asarray(u))
        missed = max((self.judge.limit(limit, x)[0] for limit in self.program.limits), default=0.0)
        if not missed <= TOLERANCE:
            return 10.0 + float(np.log1p(min(missed, 1e300))) if missed == missed else 1e3
        goal = self.judge.goal(x).value
        if goal < self.least:
            self.best, self.least = x, goal
        return float(goal / (1.0 + abs(goal)))  # the same order, never above a point that breaks a limit


@dataclass
class _ByComparing(Continuous):
    """So many measured points."""

    most: int = 1000
    name: str = ""
    words: str = ""

    @property
    def summary(self) -> str:
        return f"{self.words}, {counted(self.most, 'designs')} measured at their exact peaks"

    def solve(self, program: Program, progress: Progress | None = None) -> Found:
        """The best that was measured and keeps every limit."""
        measured = _Measured(program)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            self.run(measured)
        words = f"the best of {counted(measured.count, 'designs')}"
        if measured.best is None:
            return Found("unproven", None, f"none of {counted(measured.count, 'designs')} keeps every limit", self.name)
        return Found("feasible", measured.best, words, self.name)

    def run(self, measured: _Measured) -> None:
        """Look for the least."""
        raise NotImplementedError


@dataclass
class DifferentialEvolution(_ByComparing):
    """As it comes, without the last step by slopes, which its corners would mislead."""

    name: str = "differential_evolution"
    words: str = "scipy differential_evolution"

    def run(self, measured: _Measured) -> None:
        """From points spread by Sobol's sequence."""
        import scipy.optimize

        evolve: Any = scipy.optimize.differential_evolution
        n = len(measured.low)
        generations = max(self.most // (_CROWD * n) - 1, 1)
        evolve(
            measured, [(0.0, 1.0)] * n, maxiter=generations, popsize=_CROWD, init="sobol", polish=False, tol=1e-12,
            rng=_SEED, callback=lambda *_, **__: late(counted(measured.count, "designs")),
        )  # fmt: skip


@dataclass
class CmaEs(_ByComparing):
    """As it comes, from the middle of the ranges with a third of them as a step, begun anew where it stops early."""

    name: str = "cma_es"
    words: str = "CMA-ES of the package cma"

    def refuses(self, program: Program) -> str | None:
        """Discrete variables, and where the package is not there."""
        return super().refuses(program) if installed() else f"cma_es needs the package cma: {HOW}."

    def run(self, measured: _Measured) -> None:
        """Restarts from points at random, until all is spent."""
        cma: Any = import_module("cma")
        rng, n = np.random.default_rng(_SEED), len(measured.low)
        start = np.full(n, 0.5)
        while measured.count < self.most and not late(counted(measured.count, "designs")):
            options = {
                "bounds": [0.0, 1.0], "seed": _SEED + measured.count, "verbose": -9, "tolfun": 1e-13, "tolx": 1e-12,
                "maxfevals": self.most - measured.count,
            }  # fmt: skip
            if n == 1:  # the package knows no single variable
                cma.fmin(lambda u: measured(u[:1]), np.append(start, 0.5), 0.3, options)
            else:
                cma.fmin(measured, start, 0.3, options)
            start = rng.uniform(size=n)


def installed() -> bool:
    """Whether `cma` is there."""
    return find_spec("cma") is not None
