"""What each limit and each cap of a job with known masses costs, by solving again."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import ceil, inf, isfinite

from vibopt.answer.answer import Conflict
from vibopt.answer.entry import Checked
from vibopt.balancing.known.job import KnownJob
from vibopt.balancing.known.solve import Correction, correct
from vibopt.balancing.planes import Plane
from vibopt.balancing.prices import clash, left_out
from vibopt.records import dataclass
from vibopt.units import show, si_unit
from vibopt.work import Budget, metered

STEP = 1.1
SOLVES = 3
"""Solutions that one price takes: wider, without the limit, and at what that one reaches."""
_ACTIVE = 1e-4

Measure = Callable[[KnownJob, Correction], float]


@dataclass(frozen=True, slots=True)
class Bound:
    """A limit or a cap: its value now [SI], how an answer measures it, and the job with another bound."""

    path: str
    now: float
    unit: str
    dimension: str
    measured: Measure
    moved: Callable[[float], KnownJob]

    def shown(self, value: float) -> str:
        return show(value, self.unit, self.dimension)


def prices(
    job: KnownJob, found: Correction, goal: Measure, held: Callable[[KnownJob, Correction, str], Checked], work: float,
    budget: Budget,
) -> tuple[dict[str, str], tuple[str, ...]]:  # fmt: skip
    """What a wider limit or cap buys, in words by name (path), and a sentence where a price was not found out.

    Parameters
    ----------
    goal
        Value of the goal of an answer, in its SI unit.
    held
        A limit measured on an answer.
    work, budget
        What the answer took, which is expected of each further solution, and what all may take [nominal ms].
    """
    if job.goal is None or found.status not in ("optimal", "feasible") or found.way == "none":
        return {}, ()
    steps = any(spot.plane.is_discrete for spot in job.spots)
    words, left = {}, []
    for one in (*_limits(job, held), *_caps(job)):
        if not steps and one.measured(job, found) < one.now * (1.0 - _ACTIVE):
            continue
        if budget.over or budget.spent + SOLVES * work > budget.most:
            left.append(one.path)
            continue
        with metered() as meter:
            said = _price(job, found, goal, one)
        budget.spend(ceil(meter.done))
        if said:
            words[one.path] = said
    return words, left_out(left, SOLVES * len(left))


def _price(job: KnownJob, found: Correction, goal: Measure, one: Bound) -> str:
    """ "20 g -> 22 g buys 812 N -> 640 N; nothing more to gain beyond 41 g"; "" where it buys nothing."""
    now, then = goal(job, found), _best(one.moved(one.now * STEP), goal)
    if then is None or not then[0] < now * (1.0 - 1e-6):
        return ""
    dimension = _dimension(job)
    bound, further = (one.shown(value) for value in (one.now, one.now * STEP))
    said = f"{bound} -> {further} buys {show(now, '', dimension)} -> {show(then[0], '', dimension)}"
    return said + _until(goal, one, 1e-6 * now)


def _until(goal: Measure, one: Bound, slack: float) -> str:
    """The bound that the answer without it reaches, if with that bound the goal is as good."""
    without = one.moved(inf)
    free = _best(without, goal)
    if free is None:
        return ""
    reached = one.measured(without, free[1]) * (1.0 + 1e-9)
    again = _best(one.moved(reached), goal) if reached > one.now else None
    return f"; nothing more to gain beyond {one.shown(reached)}" if again and again[0] <= free[0] + slack else ""


def _best(job: KnownJob, goal: Measure) -> tuple[float, Correction] | None:
    found = correct(job)
    return (goal(job, found), found) if found.status in ("optimal", "feasible") else None


def _dimension(job: KnownJob) -> str:
    """Of the goal."""
    assert job.goal is not None
    of = {"correction": "mass", "reaction": "force", "couple_unbalance": "couple_unbalance"}
    return of.get(job.goal.minimise, "unbalance")


def _limits(job: KnownJob, held: Callable[[KnownJob, Correction, str], Checked]) -> list[Bound]:
    def bound(name: str) -> Bound:
        table = job.limits[name]

        def measured(other: KnownJob, found: Correction) -> float:
            return float(held(other, found, name).value.value)

        def moved(value: float) -> KnownJob:
            text = f"{value!r} {si_unit(table.dimension)}" if isfinite(value) else None
            wider = table.model_copy(update={"at_most": text})
            return replace(job, limits={**job.limits, name: wider})

        return Bound(name, table.bound, table.unit, table.dimension, measured, moved)

    return [bound(name) for name in job.limits]


def _caps(job: KnownJob) -> list[Bound]:
    """Of the planes: the greatest weight, unbalance, or depth of a hole."""
    return [_cap(job, k) for k, spot in enumerate(job.spots) if isfinite(spot.plane.cap) and not spot.plane.keep]


def _cap(job: KnownJob, k: int) -> Bound:
    plane = job.spots[k].plane
    deep = plane.drill is not None and plane.drill.depth(plane.cap) >= plane.drill.deepest * (1.0 - 1e-9)
    per = plane.drill.depth(1.0) if deep and plane.drill is not None else 1.0

    def measured(_: KnownJob, found: Correction) -> float:
        own = found.weights[k] if found.weights else ()
        return per * (sum(mass for _, mass, _ in own) if plane.shelf else plane.amount(complex(found.u[k])))

    def moved(value: float) -> KnownJob:
        spots = list(job.spots)
        spots[k] = replace(spots[k], plane=replace(plane, cap=value / per))
        return replace(job, spots=tuple(spots))

    key, dimension, unit = ("drill", "length", "mm") if deep else (_key(plane), plane.dimension, plane.unit)
    return Bound(f"planes.{plane.name}.{key}", per * plane.cap, unit, dimension, measured, moved)


def _key(plane: Plane) -> str:
    return "weight" if plane.unit and plane.dimension == "mass" else "unbalance"


def impasse(job: KnownJob, claim: str, work: float, budget: Budget) -> tuple[Conflict | None, str]:
    """Why there is no correction: the limits that cannot hold together."""

    def possible(kept: tuple[str, ...]) -> bool:
        return correct(replace(job, limits={name: job.limits[name] for name in kept})).status != "infeasible"

    return clash(tuple(job.limits), possible, lambda names: [], claim, len(job.limits) + 1, work, budget)
