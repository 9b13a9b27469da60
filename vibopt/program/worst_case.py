"""The worst case of a design within its tolerances: the worst factors of its uncertain numbers, limit by limit."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from math import isclose

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.bracketing import crossing
from vibopt.forms.undamped import frequency_senses
from vibopt.mechanics.combine import FOUND, beyond, foremost
from vibopt.mechanics.modes import natural_frequencies
from vibopt.program.pose import asked_of, on_needed
from vibopt.program.program import Aim, Axis, Limit, Program
from vibopt.records import dataclass
from vibopt.scene.assemble import model_of
from vibopt.scene.drives import at_rates
from vibopt.scene.scene import Scene
from vibopt.scene.space import members
from vibopt.scene.uncertain import Uncertain, uncertain_at

_FEW_CORNERS = 8
_MOST_CORNERS, _TRIED_CORNERS, _INSIDE = 12, 64, 24
_STARTS = 4
_PASSES = 4
_FLAT = 1e-11
"""Slope, of logs in logs, below which a factor makes no difference."""


@dataclass(frozen=True, slots=True)
class Hit:
    """Worst machine found for one limit or for the goal.

    factors
        Of the uncertain numbers, shape (n_uncertain,).
    value
        Of the form on that machine.
    proven
        Whether no other machine within the tolerances is worse.
    tried
        Machines looked at.
    sure
        Whether a search that misses none found no machine that is worse by more than a margin.
    """

    factors: FloatArray
    value: float
    proven: bool
    tried: int
    sure: bool = False


def around(scene: Scene, x: FloatArray) -> Program:
    """The limits and the goal of a machine at a design x (n_vars,), in the factors of its uncertain numbers."""
    nominal = replace(at_rates(scene, x), off={})
    asked = asked_of(nominal, model_of(nominal, np.asarray(x, dtype=float)))
    axes = tuple(Axis(uncertain.path, *uncertain.ends) for uncertain in doubts_at(scene, x))
    return replace(asked, axes=axes)


def doubts_at(scene: Scene, x: FloatArray) -> tuple[Uncertain, ...]:
    """Numbers that may be off at a design x (n_vars,)."""
    return uncertain_at(scene, scene.named(x))


def measured_around(scene: Scene, x: FloatArray, name: str) -> tuple[Program, Aim]:
    """One measure as a limit, so that its worst case is searched."""
    program, response = around(scene, x), scene.measures[name]
    sense = -1.0 if (response.worst_side == "at_least") != response.complement else 1.0
    pieces = []
    for each in members(scene, response):
        model, form = on_needed(replace(at_rates(scene, x), off={}), program.model, each)
        pieces.append(Aim(name, model, form, sense, response.complement))
    return program, replace(pieces[0], others=tuple(pieces[1:]))


def hit(part: Limit | Aim, axes: tuple[Axis, ...], *, near: tuple[FloatArray, ...] = (), quick: bool = False) -> Hit:
    """The worst factors for one limit, or for the goal.

    Parameters
    ----------
    part
        In the factors, at one design.
    axes
        Ranges of the factors.
    near
        Factors that were worst of designs nearby.
    quick
        Begin at `near` only, where there are any, and at corners where they are few.
    """
    if isinstance(part, Aim) and part.others:
        found = [hit(piece, axes, near=near, quick=quick) for piece in part.pieces]
        first = found[foremost([one.value for one in found], least=part.sense < 0.0, even=FOUND)]
        return replace(first, proven=all(one.proven for one in found), tried=sum(one.tried for one in found))
    hunt = _Hunt(part, axes)
    if not hunt.free.any():
        return Hit(hunt.rest, hunt.value(hunt.rest), True, 1)
    if isinstance(part, Limit) and part.side == "outside":
        return hunt.inside_band(part)
    simple = hunt.corner()
    if simple is not None:
        return Hit(simple, hunt.value(simple), True, 1)
    if hunt.at_corners:
        return hunt.best_corner()
    return hunt.climbed(near, quick)


class _Hunt:
    def __init__(self, part: Limit | Aim, axes: tuple[Axis, ...]) -> None:
        self.part, self.axes = part, axes
        self.low = np.array([axis.low for axis in axes])
        self.high = np.array([axis.high for axis in axes])
        self.rest = np.array([axis.rest for axis in axes])
        least = part.least_wanted
        self.sign = -1.0 if least else 1.0
        self.free = (part.form.acting(part.model) != 0.0).any(axis=0)
        self.tried = 0

    def value(self, factors: FloatArray) -> float:
        """Of the form: its worst over the speeds."""
        self.tried += 1
        return self.part.worst(factors).value

    def corner(self) -> FloatArray | None:
        """The one corner that is worst, where the form rises or falls with each factor; None where it may not."""
        senses = self.part.form.senses(self.part.model)
        if senses is None:
            return None
        rising = self.sign * senses
        up, down = (rising > 0.0).any(axis=0), (rising < 0.0).any(axis=0)
        if (up & down).any():
            return None
        return np.where(up, self.high, np.where(down, self.low, self.rest))

    @property
    def at_corners(self) -> bool:
        """Whether the worst lies at some corner for sure: sags and loads are monotone in each coefficient by itself."""
        return self.part.form.at_corners(self.part.model, least_wanted=self.sign < 0.0)

    def corners(self) -> FloatArray:
        """All corners in the factors that matter, or some of very many; shape (n_corners, n_uncertain)."""
        where = np.flatnonzero(self.free)
        if len(where) <= _MOST_CORNERS:
            signs = np.array(list(product((False, True), repeat=len(where))))
        else:
            signs = np.random.default_rng(len(where)).random((_TRIED_CORNERS, len(where))) < 0.5
        found = np.tile(self.rest, (len(signs), 1))
        found[:, where] = np.where(signs, self.high[where], self.low[where])
        return found

    def best_corner(self) -> Hit:
        corners = self.corners()
        values = np.array([self.value(corner) for corner in corners])
        index = foremost(values, least=self.sign < 0.0)
        factors, value = corners[index], float(values[index])
        return Hit(self._without_idle(factors, value, 1e-13), value, True, self.tried)

    def _without_idle(self, factors: FloatArray, value: float, same: float) -> FloatArray:
        """The factors with those at rest that make no difference."""
        for axis in np.flatnonzero(self.free):
            other = np.where(np.arange(len(factors)) == axis, self.rest, factors)
            factors = other if isclose(self.value(other), value, rel_tol=same) else factors  # infinite is not finite
        return factors

    def inside_band(self, limit: Limit) -> Hit:
        """Natural frequencies outside a band: the machine with a mode deepest inside, between two corners."""
        senses = frequency_senses(limit.model)
        up, down = (senses > 0.0).any(axis=0), (senses < 0.0).any(axis=0)
        proven = not (up & down).any()
        stiff = np.where(up, self.high, np.where(down, self.low, self.rest))
        soft = np.where(up, self.low, np.where(down, self.high, self.rest))
        middle = 0.5 * (limit.bound + limit.upper)
        best, at = -np.inf, self.rest
        for mode in range(limit.model.n_free):
            factors = self._nearest(limit, soft, stiff, mode, middle)
            omega = self._mode(limit, factors, mode)
            depth = min(omega - limit.bound, limit.upper - omega)
            if depth > best:
                best, at = depth, factors
        for corner in () if proven else self._some_corners():
            self.tried += 1
            modes = natural_frequencies(limit.model, limit.model.values(corner))
            depth = float(np.minimum(modes - limit.bound, limit.upper - modes).max())
            if depth > best:
                best, at = depth, corner
        return Hit(at, best, proven, self.tried)

    def _mode(self, limit: Limit, factors: FloatArray, mode: int) -> float:
        self.tried += 1
        return float(natural_frequencies(limit.model, limit.model.values(factors))[mode])

    def _nearest(self, limit: Limit, soft: FloatArray, stiff: FloatArray, mode: int, aimed: float) -> FloatArray:
        """Factors on the way from the softest to the stiffest machine at which a mode is nearest to a frequency."""
        if self._mode(limit, stiff, mode) <= aimed:
            return stiff
        if self._mode(limit, soft, mode) >= aimed:
            return soft
        _, part = crossing(lambda part: self._mode(limit, soft + part * (stiff - soft), mode) - aimed, 0.0, 1.0)
        return soft + part * (stiff - soft)

    def climbed(self, near: tuple[FloatArray, ...], quick: bool) -> Hit:
        """From the middle, from corners and from factors given, up along exact slopes."""
        few = 2 ** int(self.free.sum()) <= _FEW_CORNERS
        starts = [*near, *(self.corners() if few else ())] if quick and near else self._everywhere(near)
        values = [self.value(start) for start in starts]
        order = np.argsort([-self.sign * float(f"{value:.9g}") for value in values], kind="stable")
        reached = [(starts[order[0]], values[order[0]])]
        for index in order[:_STARTS]:
            if not np.isfinite(values[order[0]]):
                break
            there = self._climb(starts[index])
            reached.append((there, self.value(there)))
        best = self._first_of(reached)
        if not quick:
            best = self._flipped(*best)
            if not self.part.form.drives:
                best = self._without_idle(*best, 1e-12), best[1]
        return Hit(best[0], best[1], False, self.tried)

    def _everywhere(self, near: tuple[FloatArray, ...]) -> list[FloatArray]:
        inside: list[FloatArray] = []
        if self.part.form.screened:  # from a plain where nothing slips no slope leads up
            parts = np.random.default_rng(len(self.rest)).random((_INSIDE, len(self.rest)))
            inside = list(np.where(self.free, self.low + parts * (self.high - self.low), self.rest))
        return [*near, self.rest, *self._some_corners(), *inside]

    def _flipped(self, factors: FloatArray, value: float) -> tuple[FloatArray, float]:
        """Each factor by itself at its other end, and from there up again, as long as that is worse."""
        for _ in range(_PASSES):
            before = value
            for axis in np.flatnonzero(self.free):
                for end in (self.low[axis], self.high[axis]):
                    if factors[axis] == end or not np.isfinite(value):
                        continue
                    other = np.where(np.arange(len(factors)) == axis, end, factors)
                    tried = self.value(other)
                    if beyond(tried, value, self.sign):
                        factors, value = other, tried
            if value == before:
                return factors, value
            up = self._climb(factors)
            reached = self.value(up)
            if beyond(reached, value, self.sign):
                factors, value = up, reached
        return factors, value

    def _first_of(self, reached: list[tuple[FloatArray, float]]) -> tuple[FloatArray, float]:
        """The worst machine; of equals the first in the order of their factors."""
        ordered = sorted(reached, key=lambda one: [round(factor, 6) for factor in one[0].tolist()])
        return ordered[foremost([value for _, value in ordered], least=self.sign < 0.0, even=FOUND)]

    def _some_corners(self) -> FloatArray:
        """Some of the corners, drawn evenly where there are many."""
        corners = self.corners()
        if len(corners) <= _TRIED_CORNERS:
            return corners
        return corners[np.random.default_rng(len(corners)).permutation(len(corners))[:_TRIED_CORNERS]]

    def _climb(self, start: FloatArray) -> FloatArray:
        """Up from some factors; where all slopes point to a corner, and there do not point away, at once to it."""
        start = np.clip(start, self.low, self.high)
        height, corner = self._ahead(start)
        if np.array_equal(corner, start):
            return start
        higher, stays = self._ahead(corner) if np.isfinite(corner).all() else (height, corner)
        return corner if higher > height and np.array_equal(stays, corner) else self._searched(start)

    def _ahead(self, factors: FloatArray) -> tuple[float, FloatArray]:
        """The log of the value (falling for the least), and the corner to which all slopes point; NaN without them."""
        self.tried += 1
        first = self.part.extremes(factors)[0]
        up = self.sign * first.slope
        corner = np.where(up > _FLAT, self.high, np.where(up < -_FLAT, self.low, factors))
        return self.sign * first.value, np.where(np.isfinite([first.value, *up]).all(), corner, np.nan)

    def _searched(self, start: FloatArray) -> FloatArray:
        from scipy.optimize import minimize

        low, high = np.log(self.low), np.log(self.high)

        def fall(y: FloatArray) -> tuple[float, FloatArray]:
            self.tried += 1
            first = self.part.extremes(np.exp(y))[0]
            value = first.value if np.isfinite(first.value) else 1e3
            return -self.sign * value, -self.sign * first.slope

        found = minimize(
            fall,
            np.log(start),
            jac=True,
            method="L-BFGS-B",
            bounds=list(zip(low, high, strict=True)),
            options={"maxiter": 60, "ftol": 1e-15, "gtol": _FLAT},
        )
        there: FloatArray = np.clip(np.exp(found.x), self.low, self.high)
        for side in (self.low, self.high):  # exactly on an end where it is next to it
            there = np.where(np.abs(there - side) <= 1e-9, side, there)
        return there


def missed(part: Limit, value: float) -> float:
    """How far the value of a hit misses the bound, as a part of it."""
    return value / max(part.bound, 1e-300) if part.side == "outside" else part.missed(value)
