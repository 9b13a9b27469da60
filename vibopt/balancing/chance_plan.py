"""The plan of which enough rotors keep limits `with_probability`; what share keeps them is integrated, not drawn.

Rotors at an edge stand for all: errors of so many standard deviations, at each reading those that take it farthest, are
further readings of the question (cutting planes; Kelley, J. SIAM 8, 1960), whatever a plane may be.  How many standard
deviations are enough is bisected.  Where no number is, the plan whose farthest reading is least, and the greatest share
from there: along the gradient where weights are free, by exchanging weights where they are listed.
"""

from __future__ import annotations

from dataclasses import replace
from math import prod
from typing import Any

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray, IntArray
from vibopt.balancing.chances import Left, Rotors, radius, root_of
from vibopt.balancing.continuous import free_planes
from vibopt.balancing.influence import with_readings
from vibopt.balancing.optimisers import Solver
from vibopt.balancing.question import Question, Solved, breaks, relative_gap
from vibopt.balancing.trust import covariances
from vibopt.program.told import percent
from vibopt.records import dataclass
from vibopt.work import late, worked

_MORE = 0.0, 0.1, 0.3
"""Part of the rotors that may break a limit, which is not used where the rotors of the verdict happen to be worse."""
_FARTHEST, _HALVINGS, _ROUNDS, _CLOSE = 2.0, 9, 8, 1e-4
_LEVELS = 0.2, 0.5, 0.8, 1.1
"""Sizes of errors, as parts of what one reading alone asks for, over which the farthest reading is made least."""
_FEW, _BATCH, _NEAREST, _PASSES = 100_000, 512, 1024, 20
"""Readings on all choices that are looked at one by one, plans at once, options of a plane, and rounds over all."""
_MOST_WORK, _WORK = 4_000.0, 1e-3
"""Of all questions with further readings, and of the share of one reading [nominal ms]."""
_STEPS, _ENDS, _BACK, _ROUNDING = 60, 1e-6, 0.8, 1e-9
_DIRECTIONS = np.exp(2j * np.pi * np.arange(256) / 256)
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(48)
_TAIL, _FLAT = 8.3, 1e-9


def kept_share(z: ComplexArray, covariance: FloatArray, bound: float) -> FloatArray:
    """Share of normal errors with which |z + error| stays within a bound, (..., n_rows).

    z, covariance
        The prediction (..., n_rows) and the covariance of its error (..., n_rows, 2, 2) [SI peak].  It is integrated
        across z; along z it is known in closed form.
    """
    from scipy.special import ndtr

    size, way = np.abs(z), np.exp(1j * np.angle(z))
    turn = np.stack([np.stack([way.real, way.imag], -1), np.stack([-way.imag, way.real], -1)], -2)
    own = turn @ covariance @ turn.swapaxes(-1, -2)
    least = (_FLAT * bound) ** 2
    across = np.maximum(own[..., 1, 1], least)
    slope = own[..., 0, 1] / across
    along = np.sqrt(np.maximum(own[..., 0, 0] - slope * own[..., 0, 1], least))[..., None]
    end = np.minimum(_TAIL * np.sqrt(across), bound)[..., None]
    t, steps = end * np.sin(0.5 * np.pi * _NODES), end * np.cos(0.5 * np.pi * _NODES) * 0.5 * np.pi * _WEIGHTS
    half, middle = np.sqrt(np.maximum(bound**2 - t * t, 0.0)), size[..., None] + slope[..., None] * t
    inner = ndtr((half - middle) / along) - ndtr((-half - middle) / along)
    weight = steps * np.exp(-0.5 * t * t / across[..., None]) / np.sqrt(2.0 * np.pi * across)[..., None]
    worked(_WORK * size.size)
    return np.asarray((weight * inner).sum(axis=-1))


def planned(rotors: Rotors, question: Question, first: Solved, solver: Solver) -> Solved:
    """The plan of which enough rotors keep every limit; `first` is the best of which the prediction keeps them.

    Where the prediction is beyond a bound fewer than half of all rotors keep it, so nothing is better than `first`.
    """
    assert first.u is not None
    lefts = rotors.left(first.u)
    if all(one.holds for one in lefts.values()):
        sure = all(one.sure >= one.wanted for one in lefts.values())
        return replace(first, status=first.status if sure else "feasible", prices=None)
    for more in _MORE:
        best = _Search(rotors, question, solver, first, tuple(lefts.values()), more).best()
        if best is None:
            break
        if all(one.holds for one in rotors.left(best.at).values()):
            value = question.chosen_only(best.chosen).value(best.at)
            gap = relative_gap(value, first.bound, 0.0)
            claim = f"no plan is better by more than {percent(float(f'{gap:.2g}'))}"
            found = replace(first, u=best.at, chosen=best.chosen, value=value)
            return replace(found, status="feasible", claim=claim, gap=gap, prices=None)
    claim = f"no plan was found that enough of all machines bear ({', '.join(lefts)}), which proves nothing"
    return Solved(None, "unproven", claim, details=first.details, work=first.work)


@dataclass(frozen=True)
class _Cut:
    """Readings (y0, H) of a rotor (n_rows, 1 + n_planes), and what one standard deviation changes of them.

    size
        Standard deviations at level one.
    """

    rows: ComplexArray
    off: ComplexArray
    bound: float
    size: float

    def at(self, level: float) -> ComplexArray:
        """The readings as parts of the bound (n_rows, 1 + n_planes)."""
        return np.asarray((self.rows + level * self.size * self.off) / self.bound)


@dataclass(frozen=True)
class _Plan:
    """A plan that is permitted, its choices from lists, and how many standard deviations more keep it than must."""

    at: ComplexArray
    chosen: tuple[int, ...]
    margin: float


class _Search:
    """A search for the best plan that keeps the share which a verdict on other rotors needs, and a little `more`."""

    def __init__(
        self, rotors: Rotors, question: Question, solver: Solver, first: Solved, lefts: tuple[Left, ...], more: float
    ) -> None:
        self.rotors, self.question, self.solver, self.lefts = rotors, question, solver, lefts
        self.needed = np.array([1.0 - (1.0 - more) * (1.0 - one.needed) for one in lefts])
        self.cuts: list[_Cut] = []
        self.work = 0.0
        assert first.u is not None
        self.first = self._plan(first.u, first.chosen)

    def best(self) -> _Plan | None:
        """The best plan found, or the one that most rotors bear; None where no verdict can be reached."""
        if not np.isfinite(self.needed).all():
            return None
        every = self._every_choice()
        if every is not None:
            return self._among(every, self.first)
        plan = self._bisected()
        if plan.margin < 0.0:
            levels = (self._off(level, plan, least=True) for level in _LEVELS)
            plan = max((plan, *(one for one in levels if one is not None)), key=lambda one: one.margin)
        if self.question.is_discrete:
            return self._exchanged(plan)
        if plan.margin < 0.0:
            plan = self._stepped(plan, to_goal=False)
        return self._stepped(plan, to_goal=True) if plan.margin >= 0.0 else plan

    def _plan(self, u: ComplexArray, chosen: tuple[int, ...]) -> _Plan:
        return _Plan(u, chosen, float(self.margins(u).min()))

    def _value(self, plan: _Plan) -> float:
        return self.question.chosen_only(plan.chosen).value(plan.at)

    def margins(self, u: ComplexArray) -> FloatArray:
        """By how many standard deviations more rotors keep each limit than must (..., n_limits)."""
        from scipy.special import ndtri

        rotors = self.rotors
        z, covariance = rotors.identified.residual(u), covariances(rotors.job, rotors.identified, rotors.noise, u)
        found = []
        for left, needed in zip(self.lefts, self.needed, strict=True):
            own, errors = z[..., left.rows], covariance[..., left.rows, :, :]
            share = kept_share(own, errors, left.bound).prod(axis=-1)
            margin = ndtri(np.clip(share, 1e-300, 1.0 - 1e-16)) - ndtri(needed)
            if left.part < 1.0:
                spread = np.sqrt(np.maximum(np.linalg.eigvalsh(errors)[..., -1], 0.0))
                room = left.bound - (np.abs(own) + left.near * spread).max(axis=-1)
                margin = np.minimum(margin, room / np.maximum(spread.max(axis=-1), 1e-300))
            found.append(margin)
        return np.stack(found, axis=-1)

    def _bisected(self) -> _Plan:
        """The plan of the least errors that are enough; where none are, that of those that are just too few."""
        low, high, near, good = 0.0, _FARTHEST, self.first, list[_Plan]()
        for _ in range(_HALVINGS):
            level = 0.5 * (low + high)
            tried = self._off(level, good[-1] if good else near, least=False)
            if tried is not None and tried.margin < 0.0:
                near, low = tried, level
            else:
                good, high = [*good, *([] if tried is None else [tried])], level
        return min(good, key=self._value) if good else near

    def _off(self, level: float, near: _Plan, *, least: bool) -> _Plan | None:
        """The best plan that keeps the limits on rotors so far off, or that of which the farthest reading is `least`.

        None where there is none, or where the work is done.
        """
        plan, most = near, 0.0 if least else 1.0
        for _ in range(_ROUNDS):
            seen = self._cut(level, plan.at, most * (1.0 + _CLOSE))
            if not seen and plan is not near:
                break
            if self.work > _MOST_WORK or late("the search among machines drawn"):
                return None
            solved = self.solver(self._with_cuts(level, least=least))
            self.work += solved.work
            if solved.u is None:
                return None
            plan, most = self._plan(solved.u, solved.chosen), solved.value if least else 1.0
        return plan

    def _with_cuts(self, level: float, *, least: bool) -> Question:
        if not self.cuts:
            return self.question
        question, rows = self.question, np.concatenate([cut.at(level) for cut in self.cuts])
        if least:
            question = replace(question, goal="worst", importance=np.zeros(question.n_readings))
        limits = np.full(len(rows), np.inf if least else 1.0)
        return question.with_rows(rows[:, 0], rows[:, 1:], np.full(len(rows), float(least)), limits)

    def _cut(self, level: float, u: ComplexArray, most: float) -> bool:
        """Add the readings that rotors so far off show beyond a part `most` of their bound; whether there are any."""
        found = False
        for left in self.lefts:
            size = float(radius(left.wanted))
            cut = _Cut(*self._farthest(left, u, level * size), left.bound, size)
            beyond = np.abs(cut.at(level) @ np.append(1.0, u)) > most
            if beyond.any():
                self.cuts.append(replace(cut, rows=cut.rows[beyond], off=cut.off[beyond]))
                found = True
        return found

    def _farthest(self, left: Left, u: ComplexArray, k: float) -> tuple[ComplexArray, ComplexArray]:
        """Rows (y0, H) of a limit, and how errors change them that take them farthest after u; k standard deviations.

        The errors have the length of one standard deviation.
        """
        identified, noise, at, errors = self.rotors.identified, self.rotors.noise, 0, []
        z = identified.residual(u)
        for learnt, along, across in zip(identified.learnt, noise.along, noise.across, strict=True):
            turn = learnt.weights_of(u)[:, None] * learnt.turn
            steps = np.concatenate([turn * along, 1j * turn * across]).T
            apart = np.stack([steps.real, steps.imag], axis=1)
            covariance = apart @ apart.swapaxes(1, 2)
            edge = root_of(covariance) @ np.stack([_DIRECTIONS.real, _DIRECTIONS.imag])
            own = z[at : at + len(steps)]
            place = np.abs(own[:, None] + k * (edge[:, 0] + 1j * edge[:, 1])).argmax(axis=1)
            to = np.take_along_axis(edge, place[:, None, None], axis=2)
            unit = (apart.swapaxes(1, 2) @ (np.linalg.pinv(covariance, rcond=1e-12, hermitian=True) @ to))[..., 0].T
            errors.append(learnt.turn * (along * unit[: len(along)] + 1j * across * unit[len(along) :]))
            at += len(steps)
        rows = np.column_stack([identified.y0, identified.H])
        return rows[left.rows], (np.column_stack(with_readings(identified, errors)) - rows)[left.rows]

    def _every_choice(self) -> IntArray | None:
        """All choices from the lists (n_choices, n_planes); None where they are many, or not all that there is."""
        question = self.question
        free = [one is None and cap > 0.0 for one, cap in zip(question.options, question.caps, strict=True)]
        lists = [np.array([-1]) if one is None else np.arange(len(one.u)) for one in question.options]
        if question.pairs or not lists or any(free) or prod(map(len, lists)) * question.n_readings > _FEW:
            return None
        return np.stack(np.meshgrid(*lists, indexing="ij"), axis=-1).reshape(-1, len(lists))

    def _among(self, chosen: IntArray, plan: _Plan) -> _Plan:
        """The best of some choices (n, n_planes) that enough rotors bear, or what most bear, the plan included."""
        question, tiny = self.question, 1.0 + _ROUNDING
        u, masses = np.tile(plan.at, (len(chosen), 1)), np.tile(question.masses(plan.at), (len(chosen), 1))
        uses = np.zeros((len(chosen), len(question.stock)))
        for p, options in enumerate(question.options):
            if options is not None:
                u[:, p], masses[:, p] = options.u[chosen[:, p]], options.masses[chosen[:, p]]
                uses += options.uses[chosen[:, p]] if len(question.stock) else 0.0
        left = np.abs(question.residual(u))
        kept = (left <= question.limits * tiny).all(axis=1) & (masses.sum(axis=1) <= question.total_cap * tiny)
        kept &= (masses <= question.caps * question.densities * tiny).all(axis=1) & (uses <= question.stock).all(axis=1)
        values = masses.sum(axis=1) if question.goal == "correction" else question.measure(left)
        order = np.flatnonzero(kept)[np.argsort(values[kept], kind="stable")]
        for start in range(0, len(order), _BATCH):
            some = order[start : start + _BATCH]
            margins = self.margins(u[some]).min(axis=1)
            enough = np.flatnonzero(margins >= 0.0)
            place = int(enough[0] if len(enough) else margins.argmax())
            if len(enough) or margins[place] > plan.margin:
                plan = _Plan(u[some[place]], tuple(chosen[some[place]].tolist()), float(margins[place]))
            if len(enough):
                break
        return plan

    def _exchanged(self, plan: _Plan) -> _Plan:
        """The plan with one choice after the other exchanged, as long as that makes it better."""
        for _ in range(_PASSES if not self.question.pairs else 0):
            before = plan
            for p, options in enumerate(self.question.options):
                if options is not None:
                    left = np.abs(
                        self.question.residual(plan.at) + np.outer(options.u - plan.at[p], self.question.H[:, p])
                    )
                    near = np.argsort((left / self.question.limits).max(axis=1), kind="stable")[:_NEAREST]
                    chosen = np.tile(plan.chosen, (len(near), 1))
                    chosen[:, p] = near
                    plan = self._among(chosen, plan)
            if plan.chosen == before.chosen:
                break
        return plan

    def _stepped(self, plan: _Plan, *, to_goal: bool) -> _Plan:
        """The plan along the gradient to the greatest margin, or to the best goal with no margin below zero."""
        from scipy.optimize import minimize

        free = free_planes(self.question)
        inner, n, tied = free.question, free.question.n_planes, np.concatenate([left.rows for left in self.lefts])
        others = np.setdiff1d(np.flatnonzero(np.isfinite(inner.limits)), tied)
        size = min(left.bound for left in self.lefts) / np.abs(inner.H).max(axis=0)
        start = np.linalg.pinv(free.spread) @ plan.at / size
        value = self._value(plan) or 1.0

        def planes(v: FloatArray) -> ComplexArray:
            return np.asarray(size * (v[:n] + 1j * v[n : 2 * n]))

        def room(v: FloatArray) -> FloatArray:
            x = planes(v)
            parts = np.concatenate([
                np.abs(inner.residual(x)[others]) / inner.limits[others], np.abs(x) / inner.caps,
                [float(np.abs(x) @ inner.densities) / inner.total_cap],
            ])  # fmt: skip
            return np.concatenate([self.margins(free.spread @ x) - v[2 * n :].sum(), 1.0 - parts**2])

        def cost(v: FloatArray) -> float:
            return inner.value(planes(v)) / value if to_goal else -float(v[-1])

        more = [] if to_goal else [plan.margin]
        v = np.concatenate([start.real, start.imag, more])
        held: Any = {"type": "ineq", "fun": room}
        end = minimize(cost, v, method="SLSQP", constraints=held, options={"maxiter": _STEPS, "ftol": _ENDS}).x
        return self._on_the_way(plan, free.spread @ planes(end), to_goal=to_goal)

    def _on_the_way(self, plan: _Plan, to: ComplexArray, *, to_goal: bool) -> _Plan:
        """The last plan on the way to another that is permitted and better; the plan itself where none is."""
        part = 1.0
        for _ in range(_HALVINGS):
            tried = self._plan(plan.at + part * (to - plan.at), plan.chosen)
            better = tried.margin >= 0.0 and self._value(tried) < self._value(plan)
            if (better if to_goal else tried.margin > plan.margin) and not breaks(self.question, tried.at):
                return tried
            part *= _BACK
        return plan
