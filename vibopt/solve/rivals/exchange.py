"""SLSQP with exchange: few speeds at first, and after every run those of the exact peaks found between them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vibopt.forms import Drive, FloatArray, Modulus
from vibopt.program.program import Aim, Limit, Program
from vibopt.program.slopes import local_extremes
from vibopt.solve.method import Found, Progress
from vibopt.solve.rivals.claims import discrete
from vibopt.solve.rivals.sampled import SampledRows, sampled_speeds
from vibopt.solve.rivals.slsqp import least

_FIRST, _ROUNDS, _CLOSE = 20, 30, 1e-9
_BESIDE = 0.2
"""Part of the highest peak that a lower one must have to be added as well."""


class ExchangedRows(SampledRows):
    """Rows at few even speeds and at those that were added, per excitation of each part."""

    tolerance = 1e-11
    """As close as SLSQP comes; where it gives up so near the end, it is asked once more for less."""

    def __init__(self, program: Program) -> None:
        super().__init__(program, _FIRST)
        self.known: dict[int, FloatArray] = {}

    def speeds(self, drive: Drive) -> FloatArray:
        return self.known.setdefault(id(drive), sampled_speeds(drive, self.count))

    def highest(self, y: FloatArray) -> float:
        """How far the worst limit is exceeded and the goal is above what its rows say, in logs; peaks are added."""
        sampled = float(self.goal(y)[0].max())
        over = [self._added(limit, y, limit.side == "at_least") for limit in self.program.limits]
        bounds = [np.log(max(limit.bound, 1e-300)) for limit in self.program.limits]
        missed = [
            (bound - value) if limit.side == "at_least" else (value - bound)
            for limit, value, bound in zip(self.program.limits, over, bounds, strict=True)
            if isinstance(limit.form, Modulus) and limit.side != "outside"
        ]
        aim = self.program.aim
        if aim is not None and isinstance(aim.form, Modulus):
            missed.append(aim.sense * self._added(aim, y, aim.sense < 0) - sampled)
        return max(missed, default=0.0)

    def _added(self, part: Limit | Aim, y: FloatArray, least_wanted: bool) -> float:
        """Log of the exact worst value; the speeds of every peak are looked at from now on."""
        if not isinstance(part.form, Modulus):
            return 0.0
        found = local_extremes(part.model, part.form, np.exp(y), least_wanted=least_wanted, within=_BESIDE)
        for index, drive in enumerate(part.form.drives):
            fresh = [one.speeds[index] for one in found if one.speeds and np.isfinite(one.speeds[index])]
            self.known[id(drive)] = np.unique(np.concatenate([self.speeds(drive), fresh]))
        return found[0].value if found else 0.0


@dataclass
class Exchange:
    """SLSQP from the last design again and again until no exact peak is above what it was told."""

    name: str = "slsqp_exchange"
    summary: str = "scipy SLSQP, exact peaks exchanged"

    def refuses(self, program: Program) -> str | None:
        """Discrete variables."""
        return discrete(self.name, program)

    def solve(self, program: Program, progress: Progress | None = None) -> Found:
        """Claims success where SLSQP does and the exact peaks agree."""
        rows = ExchangedRows(program)
        y, success, word, over = rows.start(), False, "", np.inf
        for _ in range(_ROUNDS):
            before = y
            y, success, word = least(rows, y)
            over = rows.highest(y)
            if over <= _CLOSE or np.array_equal(before, y):
                break
        if not success and over <= _CLOSE:
            rows.tolerance = SampledRows.tolerance
            y, success, word = least(rows, y)
            over = rows.highest(y)
        x = np.clip(np.exp(y), program.low, program.high)
        if success and over <= 1e-7:
            return Found("feasible", x, f"{word} (exact peaks within {max(over, 0.0):.0e})", self.name)
        return Found("unproven", None, f"the solver gives up: {word}; exact peaks {over:.0e} above", self.name)
