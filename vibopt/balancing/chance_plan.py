"""The plan of which enough rotors keep limits `with_probability`; what share keeps them is integrated, not drawn.

Each reading leaves room for its error: of how many standard deviations is bisected.  From there the gradient leads on
where weights are free, to the greatest share and then to the best goal; where they are listed weights are exchanged, or
all choices looked at if they are few.
"""

from __future__ import annotations

from dataclasses import replace
from math import prod
from typing import Any

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray, IntArray
from vibopt.balancing.chances import Left, Rotors, radius
from vibopt.balancing.continuous import free_planes
from vibopt.balancing.optimisers import Solver
from vibopt.balancing.question import Question, Solved, breaks, relative_gap
from vibopt.balancing.trust import covariances
from vibopt.program.told import percent
from vibopt.records import dataclass
from vibopt.work import late, worked

_MORE = 0.0, 0.1, 0.3
"""Part of the rotors that may break a limit, which is not used where the rotors of the verdict happen to be worse."""
_FARTHEST, _HALVINGS, _ROUNDS = 2.0, 9, 3
_FEW, _BATCH, _NEAREST, _PASSES = 100_000, 512, 1024, 20
"""Readings on all choices that are looked at one by one, plans at once, options of a plane, and rounds over all."""
_MOST_WORK, _WORK = 4_000.0, 5e-3
"""Of all questions with room, and of the share of one reading [nominal ms]."""
_STEPS, _ENDS, _SPARE, _BACK, _ROUNDING = 60, 1e-8, 1e-6, 0.8, 1e-9
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
        if best.margin < 0.0:
            break
    claim = f"no plan was found that enough of all machines bear ({', '.join(lefts)}), which proves nothing"
    return Solved(None, "unproven", claim, details=first.details, work=first.work)


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
        """The best plan of the least room that is enough; where none is, that of which most rotors keep the limits."""
        low, high, near, good = 0.0, _FARTHEST, self.first, list[_Plan]()
        for _ in range(_HALVINGS):
            level = 0.5 * (low + high)
            tried = self._with_room(level, good[-1] if good else near)
            if tried is not None and tried.margin < 0.0:
                near, low = max(near, tried, key=lambda plan: plan.margin), level
            else:
                good, high = [*good, *([] if tried is None else [tried])], level
        return min(good, key=self._value) if good else near

    def _with_room(self, level: float, near: _Plan) -> _Plan | None:
        """The best plan whose readings leave room for errors of so many times what one reading alone asks for.

        None where there is none, or where the work is done.
        """
        plan = near
        for _ in range(_ROUNDS):
            limits = self.question.limits.copy()
            for left in self.rotors.left(plan.at).values():
                room = level * float(radius(left.wanted)) * left.spread
                limits[left.rows] = np.minimum(limits[left.rows], left.bound - room)
            if not (limits > 0.0).all() or self.work > _MOST_WORK or late("the search among machines drawn"):
                return None
            solved = self.solver(replace(self.question, limits=limits))
            self.work += solved.work
            if solved.u is None:
                return None
            plan = self._plan(solved.u, solved.chosen)
        return plan

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
        """The plan along the gradient to the greatest margin, or to the best goal with no margin below zero.

        No plane takes a reading farther than by its bound: far away no rotor keeps a limit and the share has no slope.
        """
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
            return np.concatenate([self.margins(free.spread @ x) - v[2 * n :].sum() - _SPARE, 1.0 - parts**2])

        def cost(v: FloatArray) -> float:
            return inner.value(planes(v)) / value if to_goal else -float(v[-1])

        more = [] if to_goal else [plan.margin]
        v = np.concatenate([start.real, start.imag, more])
        held: Any = {"type": "ineq", "fun": room}
        near = [(one - 1.0, one + 1.0) for one in v[: 2 * n]] + [(None, None) for _ in more]
        end = minimize(
            cost, v, method="SLSQP", bounds=near, constraints=held, options={"maxiter": _STEPS, "ftol": _ENDS}
        ).x
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
