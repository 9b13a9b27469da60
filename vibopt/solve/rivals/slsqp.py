"""SciPy's SLSQP on sampled speeds, variables and rows scaled by logs, exact slopes, a good start."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from vibopt.forms import FloatArray
from vibopt.program.program import Program
from vibopt.solve.method import Found, Progress
from vibopt.solve.rivals.claims import claimed, discrete
from vibopt.solve.rivals.sampled import SampledRows


@dataclass
class Slsqp:
    """One SLSQP run; the worst response as a goal is an extra variable above all its samples."""

    speeds: int = 200
    name: str = "slsqp"

    @property
    def summary(self) -> str:
        return f"scipy SLSQP, limits on {self.speeds} sampled speeds"

    def refuses(self, program: Program) -> str | None:
        """Discrete variables."""
        return discrete(self.name, program)

    def solve(self, program: Program, progress: Progress | None = None) -> Found:
        """Run it once, and pass on its flag."""
        rows = SampledRows(program, self.speeds)
        y, success, word = least(rows, rows.start())
        return claimed(self.name, program, y, success=success, word=word, speeds=self.speeds)


def least(rows: SampledRows, start: FloatArray) -> tuple[FloatArray, bool, str]:
    """Where SLSQP ends from `start`, in y = log x (n_vars,), whether it claims success, and its own word."""
    import scipy.optimize

    minimize: Any = scipy.optimize.minimize
    top = float(rows.goal(start)[0].max())
    n = len(start)
    bounds = [*zip(rows.low, rows.high, strict=True), (top - 100.0, top + 100.0)]

    def below(z: FloatArray) -> FloatArray:
        return -np.concatenate([rows.limits(z[:n]), rows.goal(z[:n])[0] - z[n]])

    def below_slopes(z: FloatArray) -> FloatArray:
        goal = rows.goal(z[:n])[1]
        limits = rows.slopes(z[:n])
        table = np.zeros((len(limits) + len(goal), n + 1))
        table[:, :n] = np.concatenate([limits, goal])
        table[-len(goal) :, n] = -1.0
        return -table

    answer = minimize(
        lambda z: z[n],
        np.append(start, top),
        jac=lambda z: np.eye(n + 1)[n],
        method="SLSQP",
        bounds=bounds,
        constraints=[{"type": "ineq", "fun": below, "jac": below_slopes}],
        options={"ftol": rows.tolerance, "maxiter": 200},
    )
    return answer.x[:n], bool(answer.success), str(answer.message)
