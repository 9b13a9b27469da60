"""General solvers as a good script asks them: SLSQP, trust-constr and IPOPT on sampled speeds, SLSQP with exchange.

Variables and rows are scaled by logs, slopes are exact, and the start is a good one; what a solver claims is passed on.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import field
from functools import partial
from typing import Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.errors import counted
from vibopt.program.casadi_nlp import SampledProgram, Samples
from vibopt.program.program import Aim, Limit, Program
from vibopt.records import dataclass
from vibopt.signals import Drive
from vibopt.solve.method import Found, Progress
from vibopt.solve.rivals.sampled import SampledRows, sampled_speeds
from vibopt.work import late

Run = tuple[FloatArray, bool, str]
"""Where a solver ends, in y = log x (n_vars,), whether it claims success, and its own word."""
_FIRST, _ROUNDS, _CLOSE = 20, 30, 1e-9
_BESIDE = 0.2
"""Part of the highest peak that a lower one must have to be added as well."""


class Continuous:
    """A method of continuous variables."""

    name: str

    def refuses(self, program: Program) -> str | None:
        """Discrete variables."""
        for axis in program.axes:
            if axis.values is not None and len(axis.values) > 1:
                many = f"{axis.path} is chosen from {len(axis.values)} values"
                return f"{self.name} takes continuous variables only, but {many}."
        return None


@dataclass
class _OnSampledSpeeds(Continuous):
    """One run on so many speeds of every band; the worst response as a goal is an unknown above all its samples."""

    speeds: int = 200
    name: str = ""
    starts: int = 1
    words: str = field(default="", init=False)

    @property
    def summary(self) -> str:
        return f"{self.words}{_from(self.starts)}, limits on {counted(self.speeds, 'sampled speeds')}"

    def solve(self, program: Program, progress: Progress | None = None) -> Found:
        """Run it from every start, and pass on the flag of the best."""
        rows = SampledRows(program, self.speeds)
        y, success, word = best_run(rows, [self.run(program, rows, start) for start in rows.starts(self.starts)])
        if not success:
            return Found("unproven", None, f"the solver gives up: {word}", self.name)
        x = np.clip(np.exp(y), program.low, program.high)
        sampled = any(part.form.drives for part in program.parts)  # of peaks in time there are no speeds
        where = f" (limits at {counted(self.speeds, 'sampled speeds')})" if sampled else ""
        return Found("feasible", x, f"{word}{where}", self.name)

    def run(self, program: Program, rows: SampledRows, start: FloatArray) -> Run:
        """Where the solver ends, in y = log x (n_vars,), whether it claims success, and its own word."""
        raise NotImplementedError


@dataclass
class Slsqp(_OnSampledSpeeds):
    """SciPy's SLSQP."""

    name: str = "slsqp"
    words: str = field(default="scipy SLSQP", init=False)

    def run(self, program: Program, rows: SampledRows, start: FloatArray) -> Run:
        """From one of the starts."""
        return least(rows, start)


@dataclass
class IpoptSampled(_OnSampledSpeeds):
    """IPOPT on the same smooth program as `nlp`, with exact second derivatives, without measuring or adding speeds."""

    name: str = "ipopt_sampled"
    words: str = field(default="CasADi with IPOPT", init=False)

    def run(self, program: Program, rows: SampledRows, start: FloatArray) -> Run:
        """From one of the starts."""
        samples = Samples(program).spread(self.speeds)
        answer = SampledProgram(samples, np.exp(start), rows.low, rows.high).solve(start, iterations=500)
        return answer.y, answer.claims, answer.word


@dataclass
class TrustConstr(_OnSampledSpeeds):
    """SciPy's trust-constr with BFGS curvature; a sparse table of slopes makes it thirty times faster."""

    name: str = "trust_constr"
    words: str = field(default="scipy trust-constr", init=False)
    iterations: int = 500

    def run(self, program: Program, rows: SampledRows, start: FloatArray) -> Run:
        """From one of the starts."""
        import scipy.optimize
        from scipy.sparse import csr_array

        optimize: Any = scipy.optimize
        top = float(rows.goal(start)[0].max())
        n = len(start)

        slopes, last = lambda z: csr_array(_above_slopes(rows, z)), np.eye(n + 1)[n]
        above = optimize.NonlinearConstraint(partial(_above, rows), -np.inf, 0.0, jac=slopes, hess=optimize.BFGS())
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            answer = optimize.minimize(
                lambda z: z[n],
                np.append(start, top),
                jac=lambda z: last,
                hess=lambda z: np.zeros((n + 1, n + 1)),
                method="trust-constr",
                bounds=optimize.Bounds(np.append(rows.low, top - 100.0), np.append(rows.high, top + 100.0)),
                constraints=[above],
                options={"gtol": 1e-8, "xtol": 1e-8, "maxiter": self.iterations},
                callback=lambda z, state: late(counted(state.niter, "iterations")),
            )
        success = answer.status in (1, 2) and answer.constr_violation <= 1e-6
        return answer.x[:n], bool(success), str(answer.message)


def best_run(rows: SampledRows, runs: Sequence[Run]) -> Run:
    """Of those that claim success the one with the least goal, else the first."""
    good = [(float(rows.goal(run[0])[0].max()), index) for index, run in enumerate(runs) if run[1]]
    return runs[min(good)[1]] if good else runs[0]


def _above(rows: SampledRows, z: FloatArray) -> FloatArray:
    """What is to be zero at most at z = (y, t) (n_vars + 1,): limits, and the rows of the goal less t."""
    return np.concatenate([rows.limits(z[:-1]), rows.goal(z[:-1])[0] - z[-1]])


def _above_slopes(rows: SampledRows, z: FloatArray) -> FloatArray:
    """Its slopes (n_rows, n_vars + 1)."""
    limits, goal = rows.slopes(z[:-1]), rows.goal(z[:-1])[1]
    last = np.repeat([0.0, -1.0], [len(limits), len(goal)])
    return np.column_stack([np.concatenate([limits, goal]), last])


def _from(starts: int) -> str:
    return f" from {starts} starts" if starts > 1 else ""


def least(rows: SampledRows, start: FloatArray) -> Run:
    """Where SLSQP ends from `start`, in y = log x (n_vars,), whether it claims success, and its own word."""
    import scipy.optimize

    minimize: Any = scipy.optimize.minimize
    top = float(rows.goal(start)[0].max())
    n = len(start)
    bounds = [*zip(rows.low, rows.high, strict=True), (top - 100.0, top + 100.0)]
    below = {"type": "ineq", "fun": lambda z: -_above(rows, z), "jac": lambda z: -_above_slopes(rows, z)}
    answer = minimize(
        lambda z: z[n],
        np.append(start, top),
        jac=lambda z: np.eye(n + 1)[n],
        method="SLSQP",
        bounds=bounds,
        constraints=[below],
        options={"ftol": rows.tolerance, "maxiter": 200},
    )
    return answer.x[:n], bool(answer.success), str(answer.message)


class ExchangedRows(SampledRows):
    """Rows at few even speeds and at those that were added, per excitation of each part."""

    def __init__(self, program: Program, tolerance: float) -> None:
        super().__init__(program, _FIRST)
        self.tolerance = tolerance
        self.known: dict[int, FloatArray] = {}

    def speeds(self, drive: Drive) -> FloatArray:
        return self.known.setdefault(id(drive), sampled_speeds(drive, self.count))

    def highest(self, y: FloatArray) -> float:
        """How far the worst limit is exceeded and the goal is above what its rows say, in logs; peaks are added."""
        sampled = float(self.goal(y)[0].max())
        over = [self._added(limit, y) for limit in self.program.limits]
        bounds = [np.log(max(limit.bound, 1e-300)) for limit in self.program.limits]
        missed = [
            (bound - value) if limit.side == "at_least" else (value - bound)
            for limit, value, bound in zip(self.program.limits, over, bounds, strict=True)
            if limit.form.drives and limit.side != "outside"
        ]
        aim = self.program.aim
        if aim is not None and aim.form.drives:
            missed.append(aim.sense * self._added(aim, y) - sampled)
        return max(missed, default=0.0)

    def _added(self, part: Limit | Aim, y: FloatArray) -> float:
        """Log of the exact worst value; the speeds of every peak are looked at from now on."""
        if not part.form.drives:
            return 0.0
        found = part.extremes(np.exp(y), within=_BESIDE)
        for index, drive in enumerate(part.form.drives):
            fresh = [local.speeds[index] for local in found if local.speeds and np.isfinite(local.speeds[index])]
            self.known[id(drive)] = np.unique(np.concatenate([self.speeds(drive), fresh]))
        return found[0].value if found else 0.0


class PeakRows(SampledRows):
    """One row per limit and one for the goal: its exact worst value, whose slope jumps where another peak is it."""

    def __init__(self, program: Program, tolerance: float) -> None:
        super().__init__(program, _FIRST)
        self.tolerance = tolerance

    def _part(self, part: Limit | Aim, y: FloatArray) -> tuple[FloatArray, FloatArray]:
        found = part.extremes(np.exp(y), within=1.0)
        if not found:
            return np.full(1, -60.0), np.zeros((1, len(y)))
        value = np.clip(np.nan_to_num([found[0].value], nan=30.0), -60.0, 60.0)
        return value, np.nan_to_num(np.asarray(found[0].slope))[None, :]


@dataclass
class OnPeaks(Continuous):
    """SLSQP with the exact worst value of every limit and of the goal as one row each."""

    name: str = "slsqp_peaks"
    tolerance: float = 1e-9
    starts: int = 1

    @property
    def summary(self) -> str:
        return f"scipy SLSQP on exact peaks{_from(self.starts)}"

    def solve(self, program: Program, progress: Progress | None = None) -> Found:
        """The best of its runs, with its flag."""
        rows = PeakRows(program, self.tolerance)
        y, success, word = best_run(rows, [least(rows, start) for start in rows.starts(self.starts)])
        if not success:
            return Found("unproven", None, f"the solver gives up: {word}", self.name)
        x = np.clip(np.exp(y), program.low, program.high)
        return Found("feasible", x, f"{word} (exact peaks)", self.name, details={"within": self.tolerance})


@dataclass
class Exchange(Continuous):
    """SLSQP from the last design again and again until no exact peak is above what it was told.

    tolerance
        Of SLSQP: as close as it comes; where it gives up so near the end, it is asked once more for less.
    close
        How far an exact peak may be above, in logs.
    """

    name: str = "slsqp_exchange"
    tolerance: float = 1e-11
    close: float = _CLOSE
    starts: int = 1

    @property
    def summary(self) -> str:
        return f"scipy SLSQP{_from(self.starts)}, exact peaks exchanged"

    def solve(self, program: Program, progress: Progress | None = None) -> Found:
        """Claims success where SLSQP does and the exact peaks agree."""
        runs = []
        for start in SampledRows(program, _FIRST).starts(self.starts):
            rows = ExchangedRows(program, self.tolerance)
            y, success, word, over = self._exchanged(rows, start)
            kept = success and over <= max(1e-7, self.close)
            runs.append((not kept, float(rows.goal(y)[0].max()), tuple(y), word, over))
        failed, _, last, word, over = min(runs)
        x = np.clip(np.exp(np.array(last)), program.low, program.high)
        if not failed:
            said = {"within": 2.0 * max(over, 0.0)}
            return Found("feasible", x, f"{word} (exact peaks within {max(over, 0.0):.0e})", self.name, details=said)
        return Found("unproven", None, f"the solver gives up: {word}; exact peaks {over:.0e} above", self.name)

    def _exchanged(self, rows: ExchangedRows, start: FloatArray) -> tuple[FloatArray, bool, str, float]:
        y, success, word, over = start, False, "", np.inf
        for _ in range(_ROUNDS):
            before = y
            y, success, word = least(rows, y)
            over = rows.highest(y)
            if over <= self.close or np.array_equal(before, y):
                break
        if not success and over <= self.close:
            rows.tolerance = max(SampledRows.tolerance, self.tolerance)
            y, success, word = least(rows, y)
            over = rows.highest(y)
        return y, success, word, over
