"""A scene as a smooth program in CasADi: peaks over ranges by exchange over their worst speeds.

The unknowns are the logs of the design variables.  A limit over a range of speeds stands for the speeds looked at, one
row each; the worst speeds of the answer are added and the program is solved again, until the exact peaks of its answer
are within 1e-9 of what its rows say.  Natural frequencies are stated with their mode shapes as unknowns.
"""

from __future__ import annotations

from dataclasses import field
from typing import Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms import StaticLoad, StaticRow
from vibopt.mechanics.model import INERTIA, STIFFNESS, Model
from vibopt.mechanics.modes import free_matrices, mode_shapes
from vibopt.posed.nonlinear import NonlinearProgram, told_apart
from vibopt.program.casadi_nlp import SampledProgram, Samples
from vibopt.program.program import Aim, Asked, Limit, Program
from vibopt.records import dataclass
from vibopt.solve.branch import Judge
from vibopt.solve.ranges import log_box, on_ends, starts
from vibopt.units import show
from vibopt.work import late, worked

EXACT = 1e-9
_ROUNDS = 40
"""Exchanges; where peaks are as many as variables the answer converges quadratically, in four or five of them."""
_SPREAD = 50
_POINTS, _STARTS = 32, 4
_IPOPT = 50.0
"""Nominal work of one run, in exact measurements."""
_MARGINS = (0.0, 2e-9, 2e-8)
"""Logs by which bounds are drawn in, one after the other, until the exact peaks keep the true ones."""
_SLACK, _BETWEEN = 1e-6, 0.1
"""Rows missed by more than this are no design; a peak may be so much higher than the samples beside it."""
_FREE = 60.0
_SQUARES = 6
"""Times that the square of a goal is made less, each scaled by the one before."""
_DIGITS = 10
"""Digits of a speed that tell it from its neighbours."""
_NEAR = 0.3
"""Logs by which the variables then move at a time."""
"""Bounds of unknowns beside the design: logs of amplitudes."""


def not_smooth(program: Program) -> str:
    """Why the program has no smooth statement, in words; "" where it has one."""
    for part in program.parts:
        why = part.form.not_smooth(part.model)
        if why:
            return f"{part.name} {why}"
    return next(
        (
            f"{limit.name} has a bound of zero"
            for limit in program.limits
            if limit.side == "at_most" and limit.bound <= 0
        ),
        "",
    )


@dataclass
class Exchange:
    """The program of a scene with the speeds looked at so far.

    own
        Limits that somebody added: name, expression, ends.
    """

    program: Program
    own: tuple[tuple[str, Any, float, float], ...] = ()
    y: Any = None
    samples: Samples = field(init=False)
    margin: float = 0.0
    rounds: int = 0
    words: str = ""
    squared: bool = False

    def __post_init__(self) -> None:
        import casadi

        self.low, self.high = log_box(self.program)
        self.samples = Samples(self.program).spread(_SPREAD)
        self.judge = Judge(self.program, EXACT)
        self.y = casadi.SX.sym("logs", len(self.low)) if self.y is None else self.y
        self.variables = {axis.path: casadi.exp(self.y[i]) for i, axis in enumerate(self.program.axes)}

    def posed(self) -> NonlinearProgram:
        """The program at the speeds that are worst at its answer; it starts there."""
        y, _ = self.run()
        return self.at(y if y is not None else self.begins()[0])

    def run(self) -> tuple[FloatArray | None, float]:
        """Where the exchange ends (y or None) and by what part a limit is then missed."""
        begins = self.begins()
        y = self._best(begins)
        for self.rounds in range(1, _ROUNDS + 1):
            promised, before = self._promised(y), self._missed(y)
            if (
                not self.samples.learn(self.x(y), 6)
                or (before <= EXACT and self._close(y, promised))
                or late("the exchange of speeds")
            ):
                break
            y = self._next(y, begins)
        for self.margin in _MARGINS:
            y = self._next(y, begins) if self.margin else y
            missed = self._missed(y)
            if missed <= EXACT:
                return y, missed
        return None, missed

    def _best(self, begins: list[FloatArray]) -> FloatArray:
        """Of where several starts lead the best that keeps the limits at the speeds looked at, nearly between them."""
        found = []
        for begin in begins:
            y, self.words, slack = self._solved(begin)
            found.append((slack > _SLACK, max(self._missed(y) - _BETWEEN, 0.0), self.judge.goal(self.x(y)).value, y))
            if late("the local search"):
                break
        return min(found, key=lambda one: one[:3])[3]

    def _next(self, y: FloatArray, begins: list[FloatArray]) -> FloatArray:
        """From the design before; where that leads nowhere, from the starts."""
        found, self.words, slack = self._solved(y)
        return found if slack <= _SLACK else self._best([y, *begins])

    def at(self, reference: FloatArray) -> NonlinearProgram:
        """The program at the speeds looked at, scaled and started at a design (its logs)."""
        import casadi

        made = _Rows(self.samples, np.exp(reference), self.low, self.high, y=self.y, squared=self.squared)
        rows = [*(row + self.margin for row in made.rows), *made.equal, *(one for _, one, _, _ in self.own)]
        ends = [(-np.inf, 0.0)] * len(made.rows) + [(0.0, 0.0)] * len(made.equal)
        ends += [(low, high) for *_, low, high in self.own]
        below, above = np.array(ends).reshape(-1, 2).T
        free, reach = np.full(len(made.extra), _FREE), _NEAR if self.squared else np.inf
        low, high = np.maximum(self.low, reference - reach), np.minimum(self.high, reference + reach)
        names = told_apart([*made.names, *["shape"] * len(made.equal), *(name for name, *_ in self.own)])
        return NonlinearProgram(
            casadi.vertcat(self.y, *made.extra), made.problem["f"], casadi.vertcat(*rows) if rows else casadi.SX(0, 1),
            np.append(low, -free), np.append(high, free), below, above,
            np.append(np.clip(reference, low, high), made.extra_starts), names, self.variables,
            self._again, self.own,
        )  # fmt: skip

    def _again(self, own: tuple[tuple[str, Any, float, float], ...]) -> NonlinearProgram:
        """The same with more limits, at the speeds that are worst with them."""
        return Exchange(self.program, own, self.y).posed()

    def begins(self) -> list[FloatArray]:
        """The designs that miss the limits least, of a few spread over the box."""
        points = [np.clip(y, self.low, self.high) for y in starts(self.program, _POINTS)]
        return sorted(points, key=lambda y: (max(self._missed(y), 0.0), self.judge.goal(self.x(y)).value))[:_STARTS]

    def x(self, y: FloatArray) -> FloatArray:
        """The design at y, on the ends of its ranges where it is next to them."""
        return on_ends(self.program, y)

    def _solved(self, y: FloatArray) -> tuple[FloatArray, str, float]:
        """Where IPOPT ends from y, its word, and by how much its rows are missed there.

        Where that is worse than y itself the square of the goal is made least: near a vibration that can be cancelled
        its log has no end, and a step along it leads anywhere.
        """
        found = self._ended(y)
        if not self._lost(y, found[0]):
            return found
        self.squared = True
        for _ in range(_SQUARES):
            other = self._ended(y)
            if self._lost(y, other[0]):
                break
            y, found = other[0], other
        self.squared = False
        return found

    def _lost(self, y: FloatArray, there: FloatArray) -> bool:
        """Whether a goal to be made least is no less there than at y, and no limit is kept better."""
        aim = self.program.aim
        if aim is None or not aim.form.drives or aim.sense < 0.0:
            return False
        goals = [self.judge.goal(self.x(one)).value for one in (y, there)]
        return goals[1] > goals[0] * (1.0 + EXACT) and self._missed(y) <= max(self._missed(there), EXACT)

    def _ended(self, y: FloatArray) -> tuple[FloatArray, str, float]:
        program = self.at(y)
        solver = program.nlpsol()
        worked(_IPOPT * self.program.cost)
        found = solver(**program.bounds)
        x, g = np.array(found["x"]).ravel()[: len(y)], np.array(found["g"]).ravel()
        slack = np.nan_to_num(np.maximum(g - program.ubg, program.lbg - g), nan=np.inf).max(initial=0.0)
        return np.where(np.isfinite(x), x, y), str(solver.stats()["return_status"]), float(slack)

    def _missed(self, y: FloatArray) -> float:
        x = self.x(y)
        return max((self.judge.limit(limit, x)[0] for limit in self.program.limits), default=0.0)

    def _promised(self, y: FloatArray) -> float:
        """Worst value of the goal at the speeds looked at."""
        aim = self.program.aim
        form = aim.form.harmonic if aim is not None else None
        if aim is None or form is None:
            return np.nan
        from vibopt.forms.drive_response import DriveResponse

        x, worst_of = self.x(y), min if aim.sense < 0 else max
        values = [
            worst_of(DriveResponse(aim.model, form, drive, x)(np.array(self.samples.speeds[-1, drive.name])))
            for drive in form.drives
        ]
        return float(np.hypot.reduce(values) if form.combine == "rss" else sum(values))

    def _close(self, y: FloatArray, promised: float) -> bool:
        """Whether the exact peak is the one among the samples."""
        aim = self.program.aim
        if aim is None or np.isnan(promised):
            return True
        value = aim.worst(self.x(y)).value
        return bool(abs(value - promised) <= EXACT * abs(value))


class _Rows(SampledProgram):
    """Rows with names; mode shapes are unknowns, with equations."""

    def __init__(
        self, samples: Samples, reference: FloatArray, low: FloatArray, high: FloatArray, *, y: Any, squared: bool
    ) -> None:
        self.equal: list[Any] = []
        self.names: list[str] = []
        self.squared = squared
        super().__init__(samples, reference, low, high, y=y)

    def _limit(self, index: int, limit: Limit, samples: Samples) -> None:
        super()._limit(index, limit, samples)
        self._name(f"limits.{limit.name}", limit, index, samples)

    def _goal(self, aim: Aim, index: int, samples: Samples) -> Any:
        goal = super()._goal(aim, index, samples)
        self._name("goal", aim, index, samples)
        return goal

    def _name(self, path: str, part: Asked, index: int, samples: Samples) -> None:
        """Names of the rows that are new: of a range the last ones, one a speed of each excitation."""
        new = len(self.rows) - len(self.names)
        drives = part.form.drives
        speeds = [
            (f" of {drive.name}" if len(drives) > 1 else "", speed)
            for drive in drives
            for speed in samples.speeds.get((index, drive.name), [])
        ]
        own = [f"{path} at {show(speed, '', 'angular_rate', digits=_DIGITS)}{of}" for of, speed in speeds]
        self.names += [path] * (new - len(own)) + own if len(own) <= new else [path] * new

    def of_load(self, model: Model, form: StaticLoad, bound: float) -> Any:
        return self.of_sag(model, StaticRow(form.row), bound) + self.of_powers(form.factor, 1.0)

    def _frequency(self, model: Model, mode: int) -> Any:
        """Log of a natural frequency w: (K - w^2 M) phi = 0 and phi . M0 phi = 1, begun at the reference."""
        import casadi

        n, p = model.n_free, model.values(self.reference)
        if n == 1:
            return super()._frequency(model, mode)
        frequencies, shapes = mode_shapes(model, p)
        size = np.abs(shapes).max(axis=1)
        phi = [self._unknown("shape", float(one)) for one in shapes[:, mode] / size]
        log = self._unknown("log of a natural frequency", float(np.log(frequencies[mode])))
        motion = casadi.vertcat(*phi) * size
        pull = casadi.SX.zeros(n)
        for term, row, scale in zip(model.terms, model.exponents, model.scales, strict=True):
            if term.kind in (STIFFNESS, INERTIA):
                part = float(scale) * (self._power(row) if row.any() else 1.0) * casadi.dot(term.vector[:n], motion)
                pull += casadi.DM(term.vector[:n]) * part * (1.0 if term.kind == STIFFNESS else -casadi.exp(2.0 * log))
        mass, _, stiff, _ = free_matrices(model, p)
        heads = (np.abs(stiff) + frequencies[mode] ** 2 * np.abs(mass)) @ size
        self.equal += casadi.vertsplit(pull / np.where(heads > 0.0, heads, 1.0))
        start = shapes[:, mode] / size
        self.equal.append(casadi.dot(casadi.DM(start), casadi.vertcat(*phi)) / float(start @ start) - 1.0)
        return log
