"""A measured rotor at many values of one bound: all plans together, each proven and put back into a simulated rotor.

The caps and limits follow the fact by a straight line; what was measured is the same.  From one value to the next the
same bounds hold the plan back, so that Newton's method answers a stretch of values at once; where another bound takes
over, the neighbour starts the search for the right ones, and only where that fails the question is asked alone.
Multipliers that prove one value to be impossible are tried on those that follow.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import tau

import numpy as np

from vibopt.arrays import BoolArray, ComplexArray, FloatArray
from vibopt.balancing import active_set
from vibopt.balancing.active_set import FAR, Discs, Held, exchanged
from vibopt.balancing.fitting import NOTHING
from vibopt.balancing.influence import Identified
from vibopt.balancing.optimisers import solve_question
from vibopt.balancing.question import Question, felt, left_over, worst_part
from vibopt.balancing.rates import NOISE
from vibopt.balancing.rotor_job import CorrectionLimit, ResidualLimit, RotorJob
from vibopt.balancing.rotor_limits import AGREES
from vibopt.balancing.rotor_question import limits_over, rows_of
from vibopt.balancing.scaled import scaled
from vibopt.balancing.solve_rotor import asked_of
from vibopt.balancing.trust import conditioning
from vibopt.balancing.verification import shown_with
from vibopt.records import dataclass

CLOSED = 1e-9
"""Gap, relative to the goal, from which a plan is proven."""
KEPT = 1e-10
"""A bound is kept when it is exceeded by no more than this share."""
MOST_CELLS = 10_000_000
"""Readings of plans that are in memory at once."""
NOTHING_LEFT = 1e-12
_AT_BOUND = 1e-6
_BLOCK = 16


@dataclass(frozen=True)
class Plans:
    """Plans at all values; a status "" means that this one was not answered.

    masses, angles
        As they are written, shape (n_values, n_planes) [kg, rad].
    goal
        Shape (n_values,) [SI peak].
    left
        Greatest amplitude left at each sensor, shape (n_values, n_sensors) [SI peak].
    pulls
        Which caps of the planes, then limits of the file, hold the goal back, shape (n_values, n_bounds).
    margins
        Per limit, shape (n_values,).
    """

    status: list[str]
    masses: FloatArray
    angles: FloatArray
    goal: FloatArray
    left: FloatArray
    pulls: BoolArray
    margins: dict[str, FloatArray]


Law = Callable[[Sequence[float]], FloatArray | None]
"""A number at all values (n_values,) from what it is where it was read; None where it follows no law."""


def plans_over(jobs: Sequence[RotorJob], law: Law) -> Plans | None:
    """Plans at all values of some facts, of which `jobs` have a few; None where they are no such family."""
    job, (heard, identified, idle, posed) = jobs[0], asked_of(jobs[0])
    question = posed.question
    if (
        any(agreement.out or agreement.possible or agreement.alone or not agreement.told for agreement in heard.found)
        or idle
    ):
        return None
    if not _is_plain(job, question) or not all(_alike(job, other) for other in jobs[1:]):
        return None
    if conditioning(question, job.free).alike:
        return None
    numbers = [[*(plane.most for plane in one.planes), *(limit.at_most for limit in one.every_limit)] for one in jobs]
    known = [one for one in map(law, zip(*numbers, strict=True)) if one is not None]
    if len(known) < len(numbers[0]):
        return None
    bounds = np.column_stack(known)
    many = max(MOST_CELLS // len(question.y0), 1000)
    found = [_plans(job, identified, question, bounds[at : at + many]) for at in range(0, len(bounds), many)]
    names = ("masses", "angles", "goal", "left", "pulls")
    masses, angles, goal, left, pulls = (np.concatenate([getattr(plans, name) for plans in found]) for name in names)
    margins = {name: np.concatenate([plans.margins[name] for plans in found]) for name in found[0].margins}
    return Plans([status for plans in found for status in plans.status], masses, angles, goal, left, pulls, margins)


def _is_plain(job: RotorJob, question: Question) -> bool:
    """Whether the weights are free, and least squares or the worst residual are asked for."""
    free = all(plane.is_plain for plane in job.planes) and job.total_cap == np.inf
    free = free and not (job.pairs or job.goal.robust or job.asks_shares or len(job.sums))
    return bool(job.choices) and free and question.goal in ("rms", "worst")


def _alike(rotor_job: RotorJob, other: RotorJob) -> bool:
    """Whether two jobs have measured the same and differ in the size of bounds alone."""
    planes = [[replace(plane, cap=0.0) for plane in job.planes] for job in (rotor_job, other)]
    limits = [[replace(limit, at_most=0.0) for limit in job.every_limit] for job in (rotor_job, other)]
    said = (rotor_job.goal, rotor_job.scatter, rotor_job.sensors) == (other.goal, other.scatter, other.sensors)
    measured = rotor_job.runs is other.runs and rotor_job.influence is other.influence
    return measured and said and planes[0] == planes[1] and limits[0] == limits[1]


def _plans(job: RotorJob, identified: Identified, question: Question, bounds: FloatArray) -> Plans:
    """Answer, put back and measure; `bounds` are caps of the planes, then limits of the file (n_values, n_bounds)."""
    caps, own, others = np.split(bounds, np.cumsum([len(job.planes), len(job.residual_limits)]), axis=1)
    limits, caps = limits_over(job, own), caps.copy()
    for cap, bound in zip(job.correction_limits, others.T, strict=True):
        caps[:, cap.plane] = np.minimum(caps[:, cap.plane], bound)
    radii, taken = (np.array([getattr(plane, name) for plane in job.planes]) for name in ("radius", "remove"))
    caps = caps * radii
    following = _Following(question, caps, limits)
    u, status, goal = following.answers()
    pulls = _pulls(job, bounds, (limits, caps), following)
    tiny = NOTHING * np.maximum(felt(identified.y0, identified.H), np.abs(u).max(axis=1, keepdims=True))
    u = np.where(np.abs(u) > tiny, u, 0.0)
    masses = np.abs(u) / radii
    angles = np.where(u != 0.0, job.conventions.weight_sense * np.angle(np.where(taken, -u, u)) % tau, 0.0)
    scale = np.abs(identified.y0) + np.abs(u) @ np.abs(identified.H).T
    left = np.abs(left_over(identified.y0, identified.H, u))
    apart = np.abs(shown_with(job, masses * radii, angles, taken) - left) / np.maximum(scale, 1e-300)
    status[(status == "optimal") & ~(apart <= AGREES).all(axis=1)] = ""
    margins = {}
    for limit, bound in zip(job.every_limit, bounds[:, len(job.planes) :].T, strict=True):
        value = masses[:, limit.plane or 0] if isinstance(limit, CorrectionLimit) else _greatest(job, limit, left)
        margins[limit.name] = (bound - value) / np.where(bound > 0.0, bound, 1.0)
    by_sensor = left.reshape(len(left), -1, len(job.sensors)).max(axis=1)
    return Plans(status.tolist(), masses, angles, goal, by_sensor, pulls, margins)


def _pulls(job: RotorJob, bounds: FloatArray, rows: tuple[FloatArray, FloatArray], of: _Following) -> BoolArray:
    """Which bounds of the file pull, (n_values, n_bounds): of several on a row, or a plane, the tightest."""
    n, (limits, caps) = len(job.planes), rows
    by_row = np.zeros(limits.shape, dtype=bool)
    by_row[:, of.held_rows], by_plane = of.pulling[:, : len(of.held_rows)], of.pulling[:, len(of.held_rows) :]
    found = np.zeros(bounds.shape, dtype=bool)
    for k, limit in enumerate((*range(n), *job.every_limit)):
        bound = bounds[:, k, None] * (1.0 - KEPT)
        if isinstance(limit, ResidualLimit):
            own = rows_of(job, limit.sensor, limit.speed)
            found[:, k] = (by_row[:, own] & (bound <= limits[:, own])).any(axis=1)
        else:
            plane = limit if isinstance(limit, int) else limit.plane or 0
            found[:, k] = by_plane[:, plane] & (bound[:, 0] * job.planes[plane].radius <= caps[:, plane])
    return found


def _greatest(job: RotorJob, limit: ResidualLimit, left: FloatArray) -> FloatArray:
    """The amplitude that a limit is about, of each plan; the first of several that differ by rounding alone."""
    own = left[:, rows_of(job, limit.sensor, limit.speed)]
    first = np.argmax(own >= own.max(axis=1, keepdims=True) * (1.0 - 1e-7), axis=1)
    return np.asarray(own[np.arange(len(own)), first])


class _Following:
    """The question at all values, of order one."""

    def __init__(self, question: Question, caps: FloatArray, limits: FloatArray) -> None:
        self.question, self.caps, self.limits = question, caps, limits
        self.n = len(caps)
        self.unit = float(np.abs(question.y0).max(initial=0.0)) or 1.0
        held = np.isfinite(limits).any(axis=0)
        scene = scaled(replace(question, limits=np.where(held, self.unit, np.inf)))
        self.columns, self.size, self.held_rows = scene.column, scene.goal_size, scene.limited
        self.divisor = scene.divisor if question.goal == "rms" else 1.0
        self.discs = Discs(scene.G, scene.g, scene.F, scene.f, question.goal == "worst")
        self.radii = self.discs.radii(limits[:, self.held_rows] / self.unit, caps / self.columns)
        self.x = np.zeros(caps.shape, dtype=complex)
        self.status = np.full(self.n, "", dtype=object)
        self.goal = np.full(self.n, np.nan)
        self.pulling = np.zeros((self.n, self.radii.shape[1] - self.discs.n_goal), dtype=bool)

    def answers(self) -> tuple[ComplexArray, np.ndarray, FloatArray]:
        """Corrections (n_values, n_planes) [kg m], statuses and goals."""
        known: Held | None = None
        at = 0
        while at < self.n:
            known = self._from_neighbour(known, at) or self._alone(at)
            if known is None:
                at = self._impossible(at) if self.status[at] == "infeasible" else at + 1
                continue
            at, known = self._stretch(known, at + 1)
        return np.asarray(self.x * self.columns, dtype=complex), self.status, self.goal

    def _from_neighbour(self, known: Held | None, at: int) -> Held | None:
        """The answer at one value with the bounds that its neighbour shows to hold it back."""
        found = None if known is None else exchanged(self.discs, known, self.radii[at : at + 1])
        return found if found is not None and self._proven(found, at).all() else None

    def _proven(self, held: Held, at: int) -> BoolArray:
        """Which answers from `at` on are within all bounds and proven; these are noted."""
        rows = slice(at, at + len(held.x))
        with np.errstate(all="ignore"):
            values, low = (
                active_set.value_of(self.discs, held.x),
                active_set.bound_of(self.discs, held, self.radii[rows]),
            )
            beyond = active_set.over(self.discs, held, self.radii[rows])[:, self.discs.n_goal :]
            kept = (beyond <= KEPT * self.radii[rows, self.discs.n_goal :]).all(axis=1)
            good = kept & (values - low <= CLOSED * np.maximum(values, 1e-3)) & np.isfinite(values)
        count = len(good) if good.all() else int(np.argmin(good))
        done = slice(at, at + count)
        self.x[done], self.status[done] = held.x[:count], "optimal"
        firm = np.flatnonzero(held.rows >= self.discs.n_goal)
        places, t = held.rows[firm], np.maximum(values[:count, None], NOISE)
        worth = held.multipliers[:count, firm] * self.radii[done][:, places] ** 2
        pulls = (worth > NOISE * t * np.maximum(t, 1e-3)) & (values[:count, None] > NOTHING_LEFT)
        self.pulling[done, :] = False
        self.pulling[at + np.arange(count)[:, None], places - self.discs.n_goal] = pulls
        goal = np.where(values > NOTHING_LEFT, values, 0.0)
        self.goal[done] = goal[:count] * self.size / self.divisor
        return good

    def _stretch(self, known: Held, at: int) -> tuple[int, Held]:
        """The values from `at` on that the same bounds hold back: where they end, and the last answer."""
        block = _BLOCK
        while at < self.n:
            stop = min(at + block, self.n)
            try:
                held = active_set.newton(self.discs, known, self.radii[at:stop])
            except np.linalg.LinAlgError:
                break
            good = self._proven(held, at)
            count = len(good) if good.all() else int(np.argmin(good))
            if count:
                known = held.at(count - 1)
            at, block = at + count, 2 * block
            if not good.all():
                break
        return at, known

    def _asked(self, at: int) -> Question:
        return replace(self.question, caps=self.caps[at], limits=self.limits[at])

    def _alone(self, at: int) -> Held | None:
        """The answer by the method for any question; None where it is not held by bounds that can be followed."""
        solved = solve_question(self._asked(at))
        self.status[at] = solved.status if solved.status in ("optimal", "infeasible") else ""
        if solved.u is None or solved.status != "optimal":
            return None
        self.x[at], self.goal[at] = solved.u / self.columns, solved.value
        return self._from_neighbour(self._held_at(self.discs, self.x[at], self.radii[at]), at)

    @staticmethod
    def _held_at(discs: Discs, x: ComplexArray, radii: FloatArray) -> Held:
        """A point with the rows that it touches."""
        sizes, bound = np.abs(discs.rows @ x + discs.constants), radii.copy()
        bound[: discs.n_goal] = sizes[: discs.n_goal].max(initial=0.0)
        return active_set.started(discs, x, np.flatnonzero(sizes >= bound * (1.0 - _AT_BOUND)))

    def _impossible(self, at: int) -> int:
        """How far the multipliers go that prove that nothing keeps the limits at `at`; the first value beyond."""
        limits = self.limits[at, self.held_rows]
        least = solve_question(worst_part(self._asked(at), self.limits[at]))
        if least.u is None:
            return at + 1
        k, n_planes = self.discs.k * self.unit / limits, self.discs.n_planes
        M = self.discs.M * self.unit / limits[:, None]
        discs = Discs(M, k, M[:0], k[:0], worst=True)
        radii = discs.radii(np.zeros((1, 0)), self.caps[at : at + 1] / self.columns)
        held = exchanged(discs, self._held_at(discs, least.u / self.columns, radii[0]), radii)
        if held is None:
            return at + 1
        z = active_set.multipliers_of(discs, held)[0][0] / limits * self.unit
        caps = self.radii[at:, -n_planes:]
        lost = np.where(np.isfinite(caps), caps, FAR * (1.0 + np.abs(held.x).max())) @ np.abs(self.discs.M.conj().T @ z)
        room = self.limits[at:, self.held_rows] / self.unit @ np.abs(z)
        proven = (z.conj() @ self.discs.k).real - lost > room * (1.0 + CLOSED)
        count = len(proven) if proven.all() else int(np.argmin(proven))
        self.status[at : at + count] = "infeasible"
        return at + max(count, 1)
