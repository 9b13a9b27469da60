"""The answer to a job with known masses, put back into the shaft and turned by hand, with the price of each limit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import ceil, inf, isfinite, tau
from typing import Any

from vibopt.answer.answer import Answer, Conflict
from vibopt.answer.entry import Checked, Entry, Price, Value, Word, at_most, direction_of
from vibopt.answer.plan import Fitting, Plan, PlaneAnswer, Weight
from vibopt.arrays import ComplexArray
from vibopt.balancing.known.correct import Correction, correct
from vibopt.balancing.known.known_job import KnownJob
from vibopt.balancing.known.known_tables import KnownLimitTable
from vibopt.balancing.known.shaft_statics import (
    aim_of,
    balance_rows,
    equilibrium,
    middle_and_arm,
    reactions,
    turned_by_hand,
    unbalances,
)
from vibopt.balancing.planes import MASS, Drill, Plane
from vibopt.balancing.question_prices import Solver, allowance, clash, left_out
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
    steps = any(plane.is_discrete for plane in job.planes)
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
    free = [(k, plane) for k, plane in enumerate(job.planes) if not plane.keep]
    drilled = [(k, plane.drill) for k, plane in free if plane.drill is not None and not plane.is_discrete]
    return [
        *(_cap(job, k) for k, plane in free if isfinite(plane.cap)),
        *(_depth(job, k, drill) for k, drill in drilled if isfinite(drill.deepest)),
    ]


def _cap(job: KnownJob, k: int) -> Bound:
    plane = job.planes[k]

    def measured(_: KnownJob, found: Correction) -> float:
        return sum((one.mass for one in found.planes[k].weights), 0.0)

    key = "unbalance" if "unbalance" in job.document["planes"][plane.name] else "weight"
    path = f"planes.{plane.name}.{key}"
    return Bound(path, plane.cap, plane.unit, plane.dimension, measured, lambda cap: _with(job, k, cap=cap))


def _depth(job: KnownJob, k: int, drill: Drill) -> Bound:
    def measured(_: KnownJob, found: Correction) -> float:
        return max((drill.depth(one.mass) for one in found.planes[k].weights), default=0.0)

    def moved(deepest: float) -> KnownJob:
        return _with(job, k, drill=replace(drill, deepest=deepest))

    return Bound(f"planes.{job.planes[k].name}.drill", drill.deepest, "mm", "length", measured, moved)


def _with(job: KnownJob, k: int, **changes: Any) -> KnownJob:
    """The job with one plane changed."""
    planes = list(job.planes)
    planes[k] = replace(planes[k], **changes)
    return replace(job, planes=tuple(planes))


def impasse(job: KnownJob, claim: str, work: float, budget: Budget) -> tuple[Conflict | None, str]:
    """Why there is no correction: the limits that cannot hold together."""

    def possible(kept: tuple[str, ...]) -> bool:
        return correct(replace(job, limits={name: job.limits[name] for name in kept})).status != "infeasible"

    return clash(tuple(job.limits), possible, lambda names: [], claim, len(job.limits) + 1, work, budget)


_TINY = 1e-9


def solve_known(job: KnownJob, *, thorough: bool = False, solver: Solver | None = None) -> Answer[KnownJob]:
    """Correct the shaft, put the weights back, and say what is left; `thorough` computes every price."""
    with metered() as meter:
        found = correct(job, solver)
    limits = {name: _held(job, found, name, table) for name, table in job.limits.items()}
    status, claim = _status(job, found, limits)
    words, unpriced = prices(job, found, _value, _limit, meter.done, allowance(thorough))
    limits = {
        name: replace(one, price=Price(words.pop(name, ""), rate=found.prices.get(name)))
        for name, one in limits.items()
    }
    impossible = status == "infeasible" and job.limits
    conflict, reason = impasse(job, claim, meter.done, allowance(thorough)) if impossible else (None, "")
    return Answer(
        job=job,
        status=status,
        claim=claim,
        reason=reason,
        conflict=conflict,
        values=_values(job, found),
        limits=limits,
        measures={name: _held(job, found, name, table) for name, table in job.measures.items()},
        goal=_goal(job, found),
        method=found.way,
        notes=(*job.notes, *_notes(job, found), *unpriced),
        prices={path: Price(one) for path, one in words.items()},
        plan=Plan((Fitting(found.planes, (), found.u),)),
    )


def _status(job: KnownJob, found: Correction, limits: dict[str, Checked]) -> tuple[str, str]:
    """The status after the check by hand: force and couple left must be what the sums say."""
    if found.status == "infeasible":
        return found.status, found.claim
    static, couple = left_over(job, found.u)
    force, moment = turned_by_hand(job, found.u)
    speed2 = job.speed**2 if job.speed is not None else 1.0
    size = (abs(unbalances(job)).sum() + abs(found.u).sum()) * speed2 or 1.0
    middle, _ = middle_and_arm(job)
    places = [one.at for one in job.masses] + [one.place for one in job.planes]
    length = max(abs(at - middle) for at in places) or 1.0
    misfit = max(abs(force - abs(static) * speed2), abs(moment - abs(couple) * speed2) / length) / size
    if max(misfit, equilibrium(job, found.u)) > _TINY:
        return "check_failed", f"the turned shaft differs from the vector sums by {misfit:.1e} of all forces"
    broken = [name for name, held in limits.items() if not held.met]
    if found.way == "none":
        return ("violated", "limits that do not hold: " + ", ".join(broken)) if broken else ("met", found.claim)
    if broken:
        return "check_failed", "limits that the correction breaks: " + ", ".join(broken)
    return found.status, found.claim


def left_over(job: KnownJob, u: ComplexArray) -> tuple[complex, complex]:
    """Static [kg m] and couple unbalance about the middle [kg m²] with the correction u."""
    rows = balance_rows(job)
    left = rows.masses @ unbalances(job) + rows.planes @ u
    _, arm = middle_and_arm(job)
    return complex(left[0]), complex(left[1] * arm) if len(left) > 1 else 0j


def _goal(job: KnownJob, found: Correction) -> tuple[str, Entry] | None:
    if job.goal is None:
        return None
    aim = aim_of(job)
    if aim is None:
        return "correction", Entry(_total(found), "mass")
    size = float(abs(unbalances(job)).sum()) * aim.scale
    return aim.name, Entry(_clean(aim.value(job, found.u), size), aim.dimension)


def _value(job: KnownJob, found: Correction) -> float:
    """The goal of an answer as a number."""
    goal = _goal(job, found)
    return float("nan") if goal is None else float(goal[1].value)


def _limit(job: KnownJob, found: Correction, name: str) -> Checked:
    return _held(job, found, name, job.limits[name])


def _total(found: Correction) -> float:
    return sum(amounts(found), 0.0)


def amounts(found: Correction) -> list[float]:
    """Mass per plane [kg] (unbalance [kg m] where a plane has no radius), of all its weights."""
    return [sum((weight.mass for weight in one.weights), 0.0) for one in found.planes]


def _values(job: KnownJob, found: Correction) -> dict[str, Value]:
    """Every number by its path."""
    values: dict[str, Value] = {}
    for plane, one in zip(job.planes, found.planes, strict=True):
        values.update(_plane_values(plane, one))
    for when, u in (("as_found", 0.0 * found.u), ("residual", found.u)):
        static, couple = left_over(job, u)
        size = float(abs(unbalances(job)).sum())
        values[f"{when}.static"] = Entry(_clean(abs(static), size), "unbalance")
        if _clean(abs(static), size):
            values[f"{when}.static_angle"] = direction_of(static)
        if not job.flat:
            length = middle_and_arm(job)[1]
            values[f"{when}.couple"] = Entry(_clean(abs(couple), size * length), "couple_unbalance")
            if _clean(abs(couple), size * length):
                values[f"{when}.couple_angle"] = direction_of(couple)
        for name, force in reactions(job, u).items():
            value, path = _clean(abs(force), size * (job.speed or 1.0) ** 2), f"{when}.bearings.{name}"
            values[f"{path}.reaction"] = Entry(value, "force")
            if value:
                values[f"{path}.angle"] = direction_of(force)
        if not job.planes:
            break
    return values


def _plane_values(plane: Plane, answer: PlaneAnswer) -> dict[str, Value]:
    """Mass, angle, hole and depth of one plane; where material is removed, of the material to take away."""
    path, u, weights = f"planes.{plane.name}", answer.u, answer.weights
    values: dict[str, Value] = {f"{path}.unbalance": Entry(abs(u), "unbalance")}
    if plane.kind == MASS:
        values[f"{path}.mass"] = Entry(sum((one.mass for one in weights), 0.0), "mass", plane.unit)
    if abs(u) > 0.0:
        values[f"{path}.angle"] = direction_of(-u if plane.remove else u)
    if plane.remove:
        values[f"{path}.action"] = Word("remove material here")
    if plane.drill is not None:
        values[f"{path}.depth"] = Entry(max((one.depth or 0.0 for one in weights), default=0.0), "length", "mm")
    if plane.shelf or len(weights) > 1 or any(one.hole is not None for one in weights):
        values[f"{path}.weights"] = Word(", ".join(_weight_words(plane, one) for one in weights) or "none")
    return values


def _weight_words(plane: Plane, weight: Weight) -> str:
    """ "5 g in hole 7 (105 deg)", or away from holes "5 g @ 105 deg"."""
    turned = _degrees(weight.angle)
    where = f"@ {turned}" if weight.hole is None else f"in hole {weight.hole + 1} ({turned})"
    return f"{plane.show(weight.mass)} {where}"


def _degrees(turn: float) -> str:
    return f"{turn / tau * 360.0:.6g} deg"


def _clean(value: float, size: float) -> float:
    """Zero where a sum cancels to rounding."""
    return 0.0 if value < 1e-13 * size else float(value)


def _held(job: KnownJob, found: Correction, name: str, table: KnownLimitTable) -> Checked:
    """A limit or measure on the corrected shaft, by the masses turned by hand where it is a sum."""
    static, couple = left_over(job, found.u)
    size = float(abs(unbalances(job)).sum())
    if table.response == "static_unbalance":
        place, value = "", _clean(abs(static), size)
    elif table.response == "couple_unbalance":
        place, value = "", _clean(abs(couple), size * middle_and_arm(job)[1])
    elif table.response == "bearing_reaction":
        all_forces = {n: abs(force) for n, force in reactions(job, found.u).items()}
        place = f"of {table.of}" if table.of else ""
        value = _clean(all_forces[table.of] if table.of else max(all_forces.values()), size * (job.speed or 1.0) ** 2)
    else:
        masses = dict(zip((plane.name for plane in job.planes), amounts(found), strict=True))
        place = f"of {table.of}" if table.of else "in total"
        value = masses[table.of] if table.of else sum(masses.values())
    bound = None if table.at_most is None else Entry(table.bound, table.dimension, table.unit)
    return at_most(name, table.response, place, Entry(float(value), table.dimension, table.unit), bound)


def _notes(job: KnownJob, found: Correction) -> tuple[str, ...]:
    """What must be known to use the answer."""
    notes = []
    if reactions(job, found.u):
        notes.append("A reaction is the force of the bearing on the shaft; it turns with it; weight is left out.")
    if not job.flat and not job.bearings:
        ends = "; the unbalances at both ends are those in the outermost of their planes"
        goal = job.goal is not None and job.goal.minimise == "unbalance"
        notes.append(
            f"Without bearings the couple is taken about the middle of all masses and planes{ends if goal else ''}."
        )
    static, couple = left_over(job, found.u)
    size = float(abs(unbalances(job)).sum())
    complete = job.goal is not None and job.goal.minimise in ("unbalance", "reaction")
    if complete and found.way == "program" and max(abs(static), abs(couple) / middle_and_arm(job)[1]) > 1e-6 * size:
        notes.append("Complete balance is out of reach within the caps, holes and limits; this is what comes nearest.")
    return tuple(notes)
