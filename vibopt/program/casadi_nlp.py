"""A program at sampled speeds as a smooth nonlinear program in CasADi, in the logs of its variables.

Every harmonic limit is |N|^2 against bound^2 |D|^2 at each sampled speed, both multi-affine in the
impedances, as the log of their quotient with both kept away from zero: finite at a resonance and at a
node, and of order one everywhere.  CasADi is loaded here and nowhere else.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field, replace
from typing import Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms import Form, Modulus, Monomials, StaticLoad, StaticRow
from vibopt.forms.drive_response import DriveResponse, rigid_form
from vibopt.forms.extremes import extremes_of
from vibopt.forms.rational import Sampled, sampled, sampled_static
from vibopt.mechanics.model import INERTIA, STIFFNESS, Model
from vibopt.mechanics.modes import mode_shapes
from vibopt.program.program import Aim, Limit, Program
from vibopt.records import dataclass
from vibopt.signals import Drive, Line, Output

_NEAR_ZERO = 1e-14
"""Part of |N|^2 added to |D|^2 and the other way round, so that their log stays finite."""


QUIET: dict[str, Any] = {"print_time": False, "error_on_fail": False, "show_eval_warnings": False}
"""How any solver of CasADi is asked: what it has to say is in its status, and goals of zero have no slope."""
IPOPT: dict[str, Any] = {
    "ipopt.print_level": 0, "ipopt.sb": "yes", "ipopt.bound_relax_factor": 0.0, "ipopt.mu_strategy": "adaptive",
}  # fmt: skip


@dataclass(frozen=True)
class Solved:
    """What the solver left behind: y = log x (n_vars,), whether it claims success, its own word."""

    y: FloatArray
    claims: bool
    word: str


@dataclass
class Samples:
    """Speeds at which each harmonic part of a program is looked at.

    speeds
        Per (part, excitation) the speeds [rad/s]; part is the index of the limit, -1 for the goal.
    shapes
        Per part with a natural frequency, the mode shapes met so far.
    """

    program: Program
    speeds: dict[tuple[int, str], list[float]] = field(default_factory=dict)

    def parts(self) -> list[tuple[int, Limit | Aim]]:
        """Limits by index, the goal as -1."""
        found: list[tuple[int, Limit | Aim]] = list(enumerate(self.program.limits))
        aims = self.program.aim.pieces if self.program.aim is not None else ()
        return [*found, *((-1 - index, aim) for index, aim in enumerate(aims))]

    def spread(self, count: int) -> Samples:
        """With `count` even speeds in every band, its ends among them."""
        for index, part in self.parts():
            for drive in part.form.drives:
                for band in drive.bands:
                    some = [band.low] if band.is_point else np.linspace(band.low, band.high, count)
                    self.add(index, drive.name, [float(one) for one in some])
        return self

    def add(self, index: int, drive: str, speeds: Sequence[float]) -> bool:
        """Look at more speeds; whether any was new."""
        known = self.speeds.setdefault((index, drive), [])
        fresh = [
            speed
            for speed in speeds
            if np.isfinite(speed) and all(abs(speed - old) > 1e-9 * abs(speed) for old in known)
        ]
        known.extend(fresh)
        return bool(fresh)

    def learn(self, x: FloatArray, most: int) -> bool:
        """Look at the speeds at which a design is worst, at most so many of each excitation; whether any was new."""
        fresh = False
        for index, part in self.parts():
            form = part.form.harmonic
            if form is None:
                continue
            for drive in form.drives:
                found = extremes_of(part.model, form, drive, x, least_wanted=part.least_wanted, within=0.7)
                fresh |= self.add(index, drive.name, [one.speed for one in found[:most]])
        return fresh


class SampledProgram:
    """The nonlinear program, built once for a set of samples and solved from many starts.

    Parameters
    ----------
    samples
        The program and the speeds to look at.
    reference
        Typical design (n_vars,): impedances are scaled by their values there.
    low, high
        Box in y = log x, shape (n_vars,).
    elastic
        Let every limit be missed by one common amount and make that amount least.
    y
        The symbol of the logs, (n_vars, 1), where there is one already.

    Attributes
    ----------
    squared
        Make the square of a response least and not its log, which has no end where that can be zero.
    """

    squared = False

    def __init__(
        self, samples: Samples, reference: FloatArray, low: FloatArray, high: FloatArray, *, elastic: bool = False,
        y: Any = None,
    ) -> None:  # fmt: skip
        import casadi

        self.reference, self.low, self.high = reference, low, high
        self.y = casadi.SX.sym("y", len(low)) if y is None else y
        self.extra: list[Any] = []
        self.extra_starts: list[float] = []
        self.rows: list[Any] = []
        objective = casadi.SX(0)
        for index, part in samples.parts():
            if isinstance(part, Aim):
                objective = self._goal(part, index, samples)
            else:
                self._limit(index, part, samples)
        if elastic:
            slack = self._unknown("s", 10.0)
            self.rows = [row - slack for row in self.rows]
            objective = slack
        unknowns = casadi.vertcat(self.y, *self.extra)
        rows = casadi.vertcat(*self.rows) if self.rows else casadi.SX(0, 1)
        self.problem = {"x": unknowns, "f": objective, "g": rows}
        self.solvers: dict[int, Any] = {}

    def solve(self, start: FloatArray, *, iterations: int = 150) -> Solved:
        """Run IPOPT from `start` (y); nothing that it says is believed here."""
        import casadi

        if iterations not in self.solvers:
            options: Any = {**QUIET, **IPOPT, "ipopt.max_iter": iterations, "ipopt.tol": 1e-9}
            self.solvers[iterations] = casadi.nlpsol("sampled", "ipopt", self.problem, options)
        count = len(self.extra)
        begin = np.concatenate([np.clip(start, self.low, self.high), self.extra_starts])
        free = np.full(count, 40.0)
        answer = self.solvers[iterations](
            x0=begin, lbx=np.concatenate([self.low, -free]), ubx=np.concatenate([self.high, free]), lbg=-np.inf, ubg=0.0
        )
        stats = self.solvers[iterations].stats()
        y = np.array(answer["x"]).ravel()[: len(self.low)]
        y = np.where(np.isfinite(y), y, begin[: len(self.low)])
        return Solved(np.clip(y, self.low, self.high), bool(stats["success"]), str(stats["return_status"]))

    def _power(self, exponents: FloatArray) -> Any:
        """prod_i x_i**exponents_i."""
        import casadi

        return casadi.exp(casadi.mtimes(casadi.DM(exponents).T, self.y))

    def _unknown(self, name: str, start: float) -> Any:
        import casadi

        made = casadi.SX.sym(name)
        self.extra.append(made)
        self.extra_starts.append(start)
        return made

    def _limit(self, index: int, limit: Limit, samples: Samples) -> None:
        if limit.side == "outside":
            self._outside(limit)
            return
        sense = 1.0 if limit.side == "at_most" else -1.0
        logs = self._logs(limit.model, limit.form, index, samples, limit.bound, sense)
        self.rows += [sense * log for log in logs]

    def _goal(self, aim: Aim, index: int, samples: Samples) -> Any:
        """The goal; on several machines one unknown that none of them passes."""
        import casadi

        x = self.reference
        if aim.form.harmonic is not None:
            if index == -1:
                start = 1.0 if self.squared else 0.0
                self.worst, self.typical = self._unknown("t", start), self._typical(aim, aim.form.harmonic, samples)
            logs = self._logs(aim.model, aim.form, index, samples, self.typical, aim.sense)
            grown = [casadi.exp(2.0 * log) if self.squared else log for log in logs]
            self.rows += [aim.sense * one - self.worst for one in grown]
            return self.worst
        size = aim.form.value(aim.model, x)
        logs = self._logs(aim.model, aim.form, -1, samples, size if 0 < size < np.inf else 1.0, aim.sense)
        return aim.sense * logs[0]

    def _typical(self, aim: Aim, form: Modulus, samples: Samples) -> float:
        """Size of the goal at the reference, from its samples."""

        total = 0.0
        for drive in form.drives:
            speeds = np.array(samples.speeds[-1, drive.name])
            values = DriveResponse(aim.model, form, drive, self.reference)(speeds)
            good = values[np.isfinite(values) & (values > 0.0)]
            total += float(np.exp(np.log(good).mean())) if len(good) else 0.0
        return total or 1.0

    def _logs(self, model: Model, form: Form, index: int, samples: Samples, bound: float, sense: float) -> list[Any]:
        """log(value / bound): one expression per sampled speed."""
        if form.harmonic is not None:
            return self._modulus(model, form.harmonic, index, samples, bound, sense)
        return [form.logged(self, model, bound)]

    def of_powers(self, form: Monomials, bound: float) -> Any:
        import casadi

        parts = [scale / bound * self._power(row) for scale, row in zip(form.scale, form.exponents, strict=True)]
        return casadi.log(sum(parts[1:], parts[0]))

    def of_sag(self, model: Model, form: StaticRow, bound: float) -> Any:
        import casadi

        square = self._square(sampled_static(model, form.row, self.reference), np.full(1, bound))
        return 0.5 * casadi.log(square)

    def of_load(self, model: Model, form: StaticLoad, bound: float) -> Any:
        return self.of_slope(model, form, bound)

    def of_mode(self, model: Model, index: int, bound: float) -> Any:
        return self._frequency(model, index) - float(np.log(bound))

    def of_slope(self, model: Model, form: Form, bound: float) -> Any:
        """To first order in y about the reference."""
        import casadi

        middle, slope = casadi.DM(np.log(self.reference)), casadi.DM(form.slope(model, self.reference))
        here = float(np.log(form.value(model, self.reference))) + casadi.mtimes(slope.T, self.y - middle)
        return here - float(np.log(bound))

    def _modulus(
        self, model: Model, form: Modulus, index: int, samples: Samples, bound: float, sense: float
    ) -> list[Any]:
        import casadi

        several = len(form.drives) > 1
        logs, shares = [], []
        for drive in form.drives:
            speeds = np.array(samples.speeds.get((index, drive.name), []))
            share = self._unknown("share", -float(np.log(len(form.drives)))) if several else 0.0
            shares.append(share)
            if len(speeds):
                logs.append(sense * self._drive(model, form, drive, speeds, bound) - share * sense)
        rows = [sense * row for log in logs for row in casadi.vertsplit(log)]
        if not several:
            return rows
        power = 2.0 if form.combine == "rss" else 1.0
        total = casadi.log(sum(casadi.exp(power * share) for share in shares)) / power
        if index < 0:
            return [row + total for row in rows]
        self.rows.append(sense * total)
        return rows

    def _drive(self, model: Model, form: Modulus, drive: Drive, speeds: FloatArray, bound: float) -> Any:
        """log(response / bound) at each speed, a column."""
        import casadi

        value = self._lines(model, form, form.output, drive.lines, speeds, bound)
        if form.rigid_link:
            rigid, output = rigid_form(model, form)
            lines = tuple(replace(line, vector=line.vector @ rigid.basis) for line in drive.lines)
            value = self._lines(rigid, form, output, lines, speeds, bound) - self._lines(
                model, form, form.output, drive.lines, speeds, 1.0
            )
        if form.output.shared_by:
            count = model.counts[form.output.shared_by]
            value -= float(np.log(count.scale)) + sum(power * self.y[i] for i, power in count.exponents.items())
        return casadi.densify(value)

    def _lines(
        self, model: Model, form: Modulus, output: Output, lines: tuple[Line, ...], speeds: FloatArray, bound: float
    ) -> Any:
        import casadi

        bounds = np.full(len(speeds), bound)
        squares = [self._square(sampled(model, output, line, speeds, self.reference), bounds) for line in lines]
        if form.combine == "rss" or len(squares) == 1:
            return 0.5 * casadi.log(sum(squares[1:], squares[0]))
        return casadi.log(sum(casadi.sqrt(square) for square in squares))

    def _square(self, line: Sampled, bounds: FloatArray) -> Any:
        """|N|^2 / (bound |D|)^2 at each sample, a column; kept within 1e-14 and 1e14."""
        top, bottom = self._squares(line, bounds)
        return (top + _NEAR_ZERO * bottom) / (bottom + _NEAR_ZERO * top)

    def _squares(self, line: Sampled, bounds: FloatArray) -> tuple[Any, Any]:
        import casadi

        size = np.maximum(np.abs(line.bottom).max(axis=1), 1e-300)[:, None]
        top, bottom = line.top / size / bounds[:, None], line.bottom / size
        model = line.groups.model
        scales = model.static_scales if line.static else model.scales
        values = casadi.vertcat(*[
            float(scale) * self._power(row) if row.any() else float(scale)
            for scale, row in zip(scales, model.exponents, strict=True)
        ])  # fmt: skip
        kappa = []
        for g, members in enumerate(line.groups.members):
            chosen = list(members)
            weight = line.factors[:, chosen] / line.scale[:, g, None]
            part = values[chosen]
            kappa.append((casadi.mtimes(_dm(weight.real), part), casadi.mtimes(_dm(weight.imag), part)))
        squares = []
        for coefficients in (top, bottom):
            real, imag = _multilinear(coefficients, kappa)
            squares.append(real**2 + imag**2)
        return squares[0], squares[1] + 1e-300

    def _frequency(self, model: Model, mode: int) -> Any:
        """Log of a natural frequency, as the Rayleigh quotient of its shape at the reference."""
        import casadi

        p = model.values(self.reference)
        _, shapes = mode_shapes(model, p)
        share = (model.vectors[:, : model.n_free] @ shapes[:, mode]) ** 2
        parts: list[Any] = [1e-300, 1e-300]
        for t, row in enumerate(model.exponents):
            if model.kinds[t] in (STIFFNESS, INERTIA):
                size = float(model.scales[t] * share[t])
                parts[int(model.kinds[t] == INERTIA)] += size * self._power(row)
        return 0.5 * casadi.log(parts[0] / parts[1])

    def _outside(self, limit: Limit) -> None:
        low, high = float(np.log(limit.bound)) if limit.bound > 0 else -60.0, float(np.log(limit.upper))
        for mode in range(limit.model.n_free):
            log = self._frequency(limit.model, mode)
            self.rows.append((log - low) * (high - log) / (high - low))


def _multilinear(coefficients: Any, kappa: list[tuple[Any, Any]]) -> tuple[Any, Any]:
    """sum_S coefficient_S prod_{g in S} kappa_g, real and imaginary columns."""
    import casadi

    parts = [(_dm(column.real), _dm(column.imag)) for column in np.asarray(coefficients).T]
    for real, imag in reversed(kappa):
        pairs = list(zip(parts[0::2], parts[1::2], strict=True))
        parts = [(a + c * real - d * imag, b + c * imag + d * real) for (a, b), (c, d) in pairs]
    return casadi.SX(parts[0][0]), casadi.SX(parts[0][1])


def _dm(values: FloatArray) -> Any:
    import casadi

    return casadi.DM(np.ascontiguousarray(values, dtype=float))
