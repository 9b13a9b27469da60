"""Permitted plans of a rotor or a shaft: how far each weight goes, and by how much all may be off at once.

What is left is linear in the weights, so permitted plans are convex.  Weights that may each be off by a part t of
themselves in any direction add up to t |H w| to what is left, plane by plane in its worst direction: exact, and convex
for each t.  Every cone program has a bound from its multipliers, worked out here.
"""

from __future__ import annotations

from collections.abc import Callable
from math import inf, pi, tau
from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.answer.entry import Entry, direction
from vibopt.arrays import ComplexArray, FloatArray
from vibopt.balancing import KNOWN, ROTOR, is_rotor
from vibopt.balancing.known.correct import AS_WRITTEN, correct, pose
from vibopt.balancing.known.shaft_statics import rows_by_hand
from vibopt.balancing.plane_options import decided_of
from vibopt.balancing.question import tied
from vibopt.balancing.rotor_question import row_limits
from vibopt.balancing.solve_rotor import asked_of
from vibopt.balancing.verification import shown_with
from vibopt.bracketing import crossing
from vibopt.cones import Cones
from vibopt.errors import InputError, RoutesDiffer
from vibopt.jobs import answer
from vibopt.records import dataclass
from vibopt.study.permitted import Window, turned
from vibopt.study.spans import Span, no_design

if TYPE_CHECKING:
    from vibopt.answer.answer import Answer
    from vibopt.balancing.conventions import Conventions
    from vibopt.balancing.known.known_job import KnownJob
    from vibopt.balancing.planes import Plane
    from vibopt.balancing.question import Question
    from vibopt.balancing.rotor_job import RotorJob

_MOST, _ROOM, _CLOSE = 0.5, 1e-6, 1e-6
"""Greatest part that is looked at, by which part it is drawn in, and how closely ends are found."""
_AROUND, _HALVINGS = 24, 80
EACH = "Every value between them is permitted, with weights in the other planes that go with it"


class _Plans:
    """Permitted plans, over limits of one and weights of natural size; of planes in pairs one number for both.

    of_planes, spread
        What each plane does to the limited rows, over their limits (n_rows, n_free), and its part of each number
        (n_free, n).
    off
        What the planes of each number do if each is off by all of itself the worst way (n_rows, n).
    """

    def __init__(self, question: Question, free: tuple[int, ...], decided: ComplexArray) -> None:
        rows, planes = np.isfinite(question.limits), list(free)
        self.of_planes = question.H[rows][:, planes] / question.limits[rows, None]
        spread = tied(question.n_planes, question.pairs)[planes]
        self.spread = spread[:, np.any(spread != 0.0, axis=0)]
        part, H = np.abs(self.spread), self.of_planes @ self.spread
        self.y0 = question.residual(decided)[rows] / question.limits[rows]
        with np.errstate(divide="ignore"):
            self.caps = (question.caps[planes, None] / part).min(axis=0)
        felt = np.abs(H).max(axis=0, initial=0.0)
        self.unit = np.where(np.isfinite(self.caps), self.caps, 1.0 / np.maximum(felt, 1e-300))
        self.H, self.off, self.caps = H * self.unit, np.abs(self.of_planes) @ part * self.unit, self.caps / self.unit
        left = question.total_cap - question.masses(decided).sum()
        self.masses = question.densities[planes] @ part * self.unit / left
        self.n, known = len(self.unit), np.linalg.svd(H * self.unit, compute_uv=False)
        full = len(known) == self.n and known[-1] > 1e-9 * known[0]
        far = (2.0 * np.sqrt(len(self.y0)) + float(np.linalg.norm(self.y0))) / known[-1] if full else inf
        with np.errstate(divide="ignore"):
            self.reach = np.minimum(np.minimum(2.0 * self.caps, 2.0 / self.masses), far)
        self.known: dict[tuple[int, float], tuple[float, complex]] = {}

    def least(self, part: float, cost: FloatArray | None = None, near: int | None = None) -> tuple[float, ComplexArray]:
        """A proven bound from below, and a plan (n_planes,), where each weight may be off by a part of itself.

        Of the limits' common factor; within the limits as they are of `cost` (2 n_planes,) times the real and
        imaginary parts, or of the weight in the plane `near`.
        """
        n, m = self.n, len(self.y0)
        cones = Cones(n)
        inside = cost is not None or near is not None
        sizes = cones.helpers(n, np.arange(n) == near if near is not None else 0.0)
        left = cones.helpers(m)
        cones.helpers(1, 0.0 if inside else 1.0)
        cones.moduli(np.eye(n, dtype=complex), np.zeros(n, dtype=complex), 0.0, (sizes,))
        cones.moduli(self.H, self.y0, 0.0, (left,))
        capped = np.flatnonzero(np.isfinite(self.caps))
        caps = np.concatenate([np.eye(n)[capped] / self.caps[capped, None], self.masses[None]])
        weights = np.concatenate([part * self.off, (1.0 + part) * caps])
        table = np.concatenate([weights, np.eye(len(weights), m), np.full((len(weights), 1), -1.0)], axis=1)
        if inside:  # the factor is one at most
            table = np.concatenate([table, np.eye(1, n + m + 1, n + m)])
        at, slots = np.nonzero(table)
        bounds = np.where(np.arange(len(table)) < len(weights), 0.0, 1.0)
        cones.linear(np.zeros((len(table), 2 * n)), bounds, (at, slots, table[at, slots]))
        point = cones.solve(cost)
        x = point.x[:n] + 1j * point.x[n : 2 * n]
        if not point.is_finite:
            return -inf, x
        most = 1.0 if inside else max(self.factor(x, part), 1.0)
        z = cones.into_dual(point.z)
        off = np.concatenate([np.zeros(2 * n) if cost is None else cost, cones.cost]) + cones.pulled(z)
        far = most * np.concatenate([np.tile(self.reach, 3), np.ones(m + 1)])
        return float(-cones.rows()[1] @ z - np.abs(off) @ far), x

    def factor(self, x: ComplexArray, part: float) -> float:
        """By which all limits would have to be as wide for a plan of which each weight is off by a part of itself."""
        left = np.abs(self.y0 + self.H @ x) + part * self.off @ np.abs(x)
        return float(max(left.max(initial=0.0), (1.0 + part) * self._capped(x)))

    def _capped(self, x: ComplexArray) -> float:
        """Caps and total that a plan takes up, as a part."""
        return max(float((np.abs(x) / self.caps).max()), float(self.masses @ np.abs(x)))

    def half(self, x: ComplexArray) -> float:
        """By which part of itself each weight of a plan may be off."""
        with np.errstate(divide="ignore", invalid="ignore"):
            rows = (1.0 - np.abs(self.y0 + self.H @ x)) / (self.off @ np.abs(x))
            caps = np.float64(1.0) / self._capped(x) - 1.0
        return float(np.clip(min(np.nanmin(rows, initial=inf), caps), 0.0, _MOST))

    def largest(self) -> tuple[ComplexArray, float, bool]:
        """The plan that bears most, how much, and whether it is proven that none bears more."""

        def over(part: float) -> float:
            return self.factor(self.least(part)[1], part) - 1.0

        part = _MOST if over(_MOST) <= 0.0 else crossing(over, 0.0, _MOST, least=1e-10)[0]
        x = self.least(part)[1]
        sure = part == _MOST or self.least(min(part * (1.0 + _CLOSE) + 1e-9, _MOST))[0] > 1.0
        return x, self.half(x), sure

    def support(self, plane: int, turn: float) -> tuple[float, complex]:
        """How far a weight goes in a direction at most, and the weight that does."""
        key = plane, turn % tau
        if key not in self.known:
            cost = np.zeros(2 * self.n)
            cost[[plane, self.n + plane]] = -np.cos(turn), -np.sin(turn)
            bound, x = self.least(0.0, cost)
            self.known[key] = -bound, complex(x[plane])
        return self.known[key]

    def farthest(self, plane: int) -> float:
        """The greatest weight, bounded from outside by lines that touch the permitted ones."""
        turns = [tau * k / _AROUND for k in range(_AROUND + 1)]
        with np.errstate(divide="ignore"):
            most = min(self.caps[plane], 1.0 / self.masses[plane])
        for _ in range(_HALVINGS):
            ends = np.array([self.support(plane, turn)[0] for turn in turns])
            step = np.diff(turns)
            across = (ends[1:] - ends[:-1] * np.cos(step)) / np.sin(step)
            beyond = np.hypot(ends[:-1], np.clip(across, 0.0, None))
            outer = np.minimum(np.where(ends[:-1] < ends[1:] * np.cos(step), ends[1:], beyond), most)
            best = max(abs(self.support(plane, turn)[1]) for turn in turns)
            k = int(np.argmax(outer))
            if outer[k] <= best * (1.0 + _CLOSE):
                break
            turns.insert(k + 1, 0.5 * (turns[k] + turns[k + 1]))
        return float(outer.max())

    def turned(self, plane: int, middle: float, side: float) -> float:
        """How far to one side of a permitted direction another is permitted: where a line through zero touches."""
        return crossing(
            lambda turn: -self.support(plane, middle + side * (turn + 0.5 * pi))[0], 0.0, 0.5 * pi, least=1e-9
        )[1]


@dataclass(frozen=True)
class _Asked:
    """What a window of weights is of.

    decided, own
        Unbalances of planes that are decided, and those of the answer (n_planes,) [kg m].
    free
        Planes that may be changed.
    shown
        What is left in the limited rows, the first of the question's, with each of many corrections, over their limits
        by another route (n_corrections, n_rows).
    """

    question: Question
    decided: ComplexArray
    own: ComplexArray
    free: tuple[int, ...]
    conventions: Conventions
    shown: Callable[[ComplexArray], FloatArray]
    claim: str


def weights_window(job: RotorJob | KnownJob) -> Window:
    """How far each weight goes over all permitted plans, and the plan of which all may be off by most.

    Raises
    ------
    InputError
        Weights that are not free, limits that are no limits of the prediction, or no plan that is permitted.
    RoutesDiffer
        The simulated rotor, or the masses turned by hand, show something else at a corner.
    """
    _check(job)
    plan = answer(job, explain=False, brief=True)
    if plan.status not in ("optimal", "feasible"):
        known = "proven" if plan.status == "infeasible" else plan.claim
        raise no_design(job.name, known)
    asked = _of_rotor(job, plan) if is_rotor(job) else _of_shaft(job)
    plans = _Plans(asked.question, asked.free, asked.decided)
    which = np.abs(plans.spread).argmax(axis=1)  # the number of each plane
    for plane, k in zip(asked.free, which, strict=True):
        if not np.isfinite(plans.reach[k]):
            name = job.planes[plane].name
            raise InputError(
                f"{job.name}: window is for weights that something bounds, and the {_LIMITED[job.kind]} do not tell "
                f'what planes.{name} does from the others. Cap it: weight = {{ from = "0 g", to = "50 g" }}.'
            )
    x, part, sure = plans.largest()
    part *= 1.0 - _ROOM
    _put_back(job, asked, plans, x, part)
    spans, centre = [], {}
    for plane, k, ratio in zip(asked.free, which, plans.spread[np.arange(len(which)), which], strict=True):
        for span, middle in _spans(job.planes[plane], asked.conventions, plans, int(k), complex(ratio), complex(x[k])):
            spans.append(span)
            centre[span.path] = middle
    own = np.linalg.pinv(plans.spread) @ asked.own[list(asked.free)] / plans.unit
    return Window(job, tuple(spans), centre, part, sure, asked.claim, plans.half(own), EACH)


_LIMITED = {ROTOR: "sensors", KNOWN: "limits"}


def _of_rotor(job: RotorJob, plan: Answer[Any]) -> _Asked:
    of, _, idle, posed = asked_of(job)
    question, limits = posed.question, row_limits(of.job)
    open_ = {k for k, own in enumerate(job.planes) if own.is_open and k not in idle and question.caps[k] > 0.0}
    alone = {k for pair in question.pairs for k in pair[:2] if not open_.issuperset(pair[:2])}
    free = tuple(sorted(open_ - alone))
    removed = np.array([plane.remove for plane in job.planes])
    rows = np.flatnonzero(np.isfinite(limits))

    def shown(u: ComplexArray) -> FloatArray:
        angles = of.job.conventions.weight_sense * np.angle(np.where(removed, -u, u))
        return shown_with(of.job, np.abs(u), angles, removed)[:, rows] / limits[rows]

    own = np.array([one.u for one in plan.plan.fittings[0].planes])
    claim = "cone programs, with bounds from their multipliers; put back into a simulated rotor"
    return _Asked(question, decided_of(posed.question.options), own, free, job.conventions, shown, claim)


def _of_shaft(job: KnownJob) -> _Asked:
    posed = pose(job)
    question = posed.question
    free = tuple(k for k, own in enumerate(job.planes) if own.is_open and question.caps[k] > 0.0)
    rows = np.flatnonzero(np.isfinite(question.limits))

    def shown(u: ComplexArray) -> FloatArray:
        return np.array([rows_by_hand(job, one)[rows] / question.limits[rows] for one in u])

    claim = "cone programs, with bounds from their multipliers; the masses turned by hand at its corners"
    return _Asked(question, decided_of(question.options), correct(job).u, free, AS_WRITTEN, shown, claim)


def _check(job: RotorJob | KnownJob) -> None:
    """Whether the permitted plans are those of free weights under limits of the prediction."""
    limited = job.residual_limits if is_rotor(job) else np.isfinite(pose(job).question.limits).any()
    if not limited:
        raise InputError(f"{job.name}: window needs limits on what is left: without any every weight is permitted.")
    listed = next((plane.name for plane in job.planes if plane.is_open and not plane.is_plain), "")
    what = f"planes.{listed} has holes, a list, sectors or a split" if listed else ""
    if is_rotor(job):
        what = what or ("a limit asks for a probability" if job.asks_shares else "")
        what = what or ("sensors are added up, so that no one direction is worst" if len(job.sums) else "")
        what = what if job.has_phase else "nothing is chosen by readings with their angles"
    what = what if job.choices else "nothing is chosen"
    if what:
        raise InputError(
            f"{job.name}: window is for weights of any size and angle, and {what}. "
            "vibopt sweep FILE --keep-design --vary PATH=RANGE shows what each may be."
        )


def _spans(
    own: Plane, conventions: Conventions, plans: _Plans, k: int, ratio: complex, x: complex
) -> list[tuple[Span, Entry]]:
    """Of one weight, `ratio` times number k, its size and its angle, each with where the centre has it."""
    unit, x = abs(ratio) * float(plans.unit[k]), x * ratio / abs(ratio)
    nearest, there = plans.least(0.0, near=k)
    sizes = [Entry(own.amount(size * unit), own.dimension, own.unit) for size in (max(nearest, 0.0), plans.farthest(k))]
    angle = conventions.weight_angle
    turn, at = float(np.angle(there[k])), ratio * there[k]
    middle = angle(-at if own.remove else at)
    ends = Entry(0.0, "angle", "deg"), Entry(tau, "angle", "deg")
    if nearest > _CLOSE * sizes[1].value / own.amount(unit):
        sides = [side * plans.turned(k, turn, side * conventions.weight_sense) for side in (-1.0, 1.0)]
        ends = turned(middle, sides[0]), turned(middle, sides[1])
    path, sure = f"planes.{own.name}", bool(np.isfinite(nearest))
    size = Entry(own.amount(x * unit), own.dimension, own.unit)
    return [
        (Span(f"{path}.{own.dimension}", ((sizes[0], sizes[1]),), sure), size),
        (Span(f"{path}.angle", (ends,), sure), direction(angle(-x if own.remove else x))),
    ]


def _put_back(job: RotorJob | KnownJob, asked: _Asked, plans: _Plans, x: ComplexArray, part: float) -> None:
    """Each row with every weight off the way that is worst for it, by another route."""
    weights = plans.spread @ (x * plans.unit)
    left, effect = plans.y0 + plans.H @ x, plans.of_planes * weights
    turns = np.exp(1j * (np.angle(left)[:, None] - np.angle(effect)))
    u = np.tile(asked.decided, (len(left), 1))
    u[:, list(asked.free)] = weights * (1.0 + part * turns)
    shown = asked.shown(u).diagonal()
    said = (np.abs(left) + part * np.abs(effect).sum(axis=1))[: len(shown)]
    if not np.allclose(shown, said, rtol=1e-6, atol=1e-6):
        raise RoutesDiffer(f"{job.name}: no window is told: {_OTHER[job.kind]} other vibrations at a corner")


_OTHER = {ROTOR: "the simulated rotor shows", KNOWN: "the masses turned by hand show"}
