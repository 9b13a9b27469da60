"""How far the spring of an absorber may be off, each way, before the machine is no longer good enough."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.bracketing import crossing
from vibopt.forms import Form
from vibopt.mechanics.model import HYSTERETIC, STIFFNESS, Model
from vibopt.program.pose import pose
from vibopt.program.program import Limit, Program
from vibopt.records import dataclass
from vibopt.report.absorber_parts import has_absorbers
from vibopt.scene.scene import Design
from vibopt.units import plain

GROWTH = 0.05
"""Part by which the goal may grow worse, and by which a limit that leaves no room may be broken."""
FARTHEST = math.log(4.0)
_FIRST, _WIDER = 0.004, 1.5
_EXACT, _NOTHING = 1e-10, 1e-6


@dataclass(frozen=True, slots=True)
class End:
    """One end of the range: the stiffness as a part more or less than chosen, and what ends it ("" for nothing)."""

    stiffness: float
    because: str

    @property
    def tuning(self) -> float:
        """The same in own frequency."""
        return math.sqrt(1.0 + self.stiffness) - 1.0


@dataclass(frozen=True, slots=True)
class Adjusting:
    """How far one spring may be off.

    low, high
        Ends at which the first limit breaks, or the goal is 5 % worse.
    broken_by
        0.05 where limits leave no room and the ends are those at which one is broken by 5 %; else 0.
    """

    absorber: str
    low: End
    high: End
    broken_by: float

    @property
    def words(self) -> str:
        """As one sentence."""
        past = ["more than " if not end.because else "" for end in (self.low, self.high)]
        spring = f"spring {past[0]}{_percent(self.low.stiffness)} to {past[1]}{_percent(self.high.stiffness)}"
        tuned = f"tuning {past[0]}{_percent(self.low.tuning)} to {past[1]}{_percent(self.high.tuning)}"
        why = " and ".join(dict.fromkeys(filter(None, (self.low.because, self.high.because))))
        if not why:
            return "the spring may be four times as stiff, or a quarter: nothing breaks"
        if max(-self.low.stiffness, self.high.stiffness) < _NOTHING:
            return f"no room at all: {why} does not hold, or is zero and grows with the least drift"
        if self.broken_by:
            return f"no room, {why} at the bound; {spring} ({tuned}) breaks it by {plain(100 * self.broken_by, 2)} %"
        return f"{spring} ({tuned}), ended by {why}"


def adjusting(design: Design) -> tuple[Adjusting, ...]:
    """The adjusting range of every absorber with a spring; worst values are exact, the ends found by root finding."""
    if not has_absorbers(design):
        return ()
    program, x = pose(design.scene), np.array(design.x, dtype=float)
    if all(part.form.powers is not None for part in program.parts):
        return ()
    found = []
    for name, table in design.scene.absorbers.items():
        if not table.has_spring:
            continue
        strict = _ends(_Worse(program, x, name, 0.0))
        tight = any(abs(end.stiffness) < _NOTHING for end in strict)
        low, high = _ends(_Worse(program, x, name, GROWTH)) if tight else strict
        found.append(Adjusting(name, low, high, GROWTH if tight else 0.0))
    return tuple(found)


def _percent(part: float) -> str:
    sign = "+" if part > 0.0 else "-"
    return f"{sign}{plain(abs(100.0 * part), 3)} %"


class _Worse:
    """How much too bad the machine is when a spring is stiffer by e**s: positive where something is broken."""

    def __init__(self, program: Program, x: FloatArray, name: str, slack: float) -> None:
        self.x, self.name, self.slack = x, name, slack
        self.limits = [limit for limit in program.limits if limit.form.powers is None]
        aim = program.aim if program.aim is not None and program.aim.form.powers is None else None
        self.aim = aim
        self.level = 0.0
        if aim is not None:
            self.level = aim.worst(x).value
        self.because = ""

    def __call__(self, s: float) -> float:
        missed = {limit.name: self._missed(limit, s) for limit in self.limits}
        if self.aim is not None and 0.0 < self.level < math.inf:
            here = self._worst(self.aim.model, self.aim.form, self.aim.sense < 0, s)
            grown = _log(here / self.level) * self.aim.sense
            missed["the goal"] = grown - math.log1p(GROWTH)
        self.because = max(missed, key=lambda key: missed[key], default="")
        return missed[self.because] if missed else -1.0

    def _missed(self, limit: Limit, s: float) -> float:
        value = self._worst(limit.model, limit.form, limit.side == "at_least", s)
        slack = math.log1p(self.slack) + 1e-9
        if limit.side == "outside":
            return min(_log(value / limit.bound), _log(limit.upper / value)) - slack
        if limit.bound <= 0.0:  # a bound of nothing holds by rounding alone
            return -1.0
        size = _log(value / limit.bound)
        return (size if limit.side == "at_most" else -size) - slack

    def _worst(self, model: Model, form: Form, least_wanted: bool, s: float) -> float:
        off = math.exp(s)
        terms = tuple(
            replace(term, scale=term.scale * off, static_scale=term.static_scale * off)
            if term.owner == self.name and term.kind in (STIFFNESS, HYSTERETIC)
            else term
            for term in model.terms
        )
        return form.worst(replace(model, terms=terms), self.x, least_wanted=least_wanted).value


def _log(value: float) -> float:
    return math.log(value) if 0.0 < value < math.inf else (-700.0 if value <= 0.0 else 700.0)


def _ends(worse: _Worse) -> tuple[End, End]:
    """The first s each way at which something is broken, as a part of the stiffness."""
    if worse(0.0) > 0.0:
        because = worse.because
        return End(0.0, because), End(0.0, because)
    return _end(worse, -1.0), _end(worse, 1.0)


def _end(worse: _Worse, sign: float) -> End:
    good, step = 0.0, _FIRST
    while good < FARTHEST:
        bad = min(good + step, FARTHEST)
        if worse(sign * bad) > 0.0:
            root = crossing(lambda s: worse(sign * s), good, bad, least=_EXACT)[0]
            worse(sign * (root + _EXACT))
            return End(math.expm1(sign * root) if root > _EXACT else 0.0, worse.because)
        good, step = bad, min(step * _WIDER, 0.1)
    return End(math.expm1(sign * FARTHEST), "")
