"""The answer to a job with known masses, put back into the shaft and turned by hand, with the price of each limit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import tau

from vibopt.answer.answer import Answer
from vibopt.answer.entry import Checked, Entry, Value, Word, at_most, direction_of
from vibopt.answer.plan import Fitting, Plan, PlaneAnswer, Weight
from vibopt.arrays import ComplexArray
from vibopt.balancing.fitting import not_permitted
from vibopt.balancing.impasses import NOTHING_FOUND, Asking
from vibopt.balancing.known.correct import Correction, bounded_rows, correct
from vibopt.balancing.known.known_job import KnownGoalTable, KnownJob, KnownLimitTable
from vibopt.balancing.known.shaft_statics import (
    aim_of,
    balance_rows,
    equilibrium,
    middle_and_arm,
    reactions,
    turned_by_hand,
    unbalances,
)
from vibopt.balancing.optimisers import Solver
from vibopt.balancing.planes import MASS, Plane
from vibopt.records import dataclass
from vibopt.work import metered

_TINY, _OPEN = 1e-9, 1e-10
_WORSE = 1e-3
"""Part by which a bearing is loaded more for that to be said."""


def solve_known(job: KnownJob, *, thorough: bool = False, solver: Solver | None = None) -> Answer[KnownJob]:
    """Correct the shaft, put weights back, say what is left; `thorough` says what clashes, whatever the work."""
    with metered() as meter:
        found = correct(job, solver)
    limits = _rows(job, found, job.limits)
    status, claim = _status(job, found, limits)
    none = status in NOTHING_FOUND
    answer = Answer(
        job=job,
        status=status,
        claim=claim,
        values=_values(job, found),
        limits={} if none else limits,
        measures=_rows(job, found, job.measures),
        goal=None if none else _goal(job, found),
        method=found.way,
        notes=(*job.notes, *_notes(job, found)),
        plan=Plan((Fitting(found.planes, (), found.u),)),
        rates=found.rates,
    )
    if not none or not job.limits:
        return answer
    return Asking(
        job.limits, lambda limits: correct(_with_limits(job, limits)),
        lambda correction: _rows(job, correction, job.limits),
        lambda correction: _values(job, correction), meter.done, thorough,
        words=lambda correction: tuple(plane.words for plane in correction.planes),
    ).told(answer)  # fmt: skip


def _with_limits(job: KnownJob, limits: Mapping[str, KnownLimitTable]) -> KnownJob:
    """The job with some of its limits; complete balance is not meant because those that say how good are left out."""

    def say_how_good(some: Mapping[str, KnownLimitTable]) -> bool:
        return any(bounded_rows(job, one)[0] for one in some.values())

    fewer = replace(job, limits=limits)
    if job.goal is None or job.goal.minimise != "correction" or say_how_good(limits) or not say_how_good(job.limits):
        return fewer
    return replace(fewer, goal=KnownGoalTable(minimise="static_unbalance"))


def _rows(job: KnownJob, correction: Correction, tables: Mapping[str, KnownLimitTable]) -> dict[str, Checked]:
    left = Left.of(job, correction.u) if tables else Left(0.0, 0.0, {})
    return {name: _held(job, correction, left, name, table) for name, table in tables.items()}


def _status(job: KnownJob, correction: Correction, limits: dict[str, Checked]) -> tuple[str, str]:
    """The status after the check by hand: force and couple left must be what the sums say."""
    if correction.status in NOTHING_FOUND:
        return correction.status, correction.claim
    static, couple = left_over(job, correction.u)
    force, moment = turned_by_hand(job, correction.u)
    speed2 = job.speed**2 if job.speed is not None else 1.0
    size = (abs(unbalances(job)).sum() + abs(correction.u).sum()) * speed2 or 1.0
    middle, _ = middle_and_arm(job)
    places = [mass.at for mass in job.masses] + [plane.place for plane in job.planes]
    length = max(abs(at - middle) for at in places) or 1.0
    misfit = max(abs(force - abs(static) * speed2), abs(moment - abs(couple) * speed2) / length) / size
    if max(misfit, equilibrium(job, correction.u)) > _TINY:
        return "check_failed", f"the turned shaft differs from the vector sums by {misfit:.1e} of all forces"
    broken = [name for name, held in limits.items() if not held.met]
    broken += [] if correction.way == "none" else not_permitted(job.planes, correction.planes)
    if correction.way == "none":
        return ("violated", "limits that do not hold: " + ", ".join(broken)) if broken else ("met", correction.claim)
    if broken:
        return "check_failed", "limits that the correction breaks: " + ", ".join(broken)
    return correction.status, correction.claim


@dataclass(frozen=True)
class Left:
    """What is left on the shaft, as it stands and as it turns: zero where it is rounding, or left open by a program."""

    static: complex
    couple: complex
    reactions: dict[str, complex]

    @staticmethod
    def of(job: KnownJob, u: ComplexArray) -> Left:
        """With the correction u; the couple is about the middle."""
        static, couple = left_over(job, u)
        size = float(abs(unbalances(job)).sum())
        forces = {name: _clean(one, size * (job.speed or 1.0) ** 2) for name, one in reactions(job, u).items()}
        return Left(_clean(static, size), _clean(couple, size * middle_and_arm(job)[1]), forces)


def left_over(job: KnownJob, u: ComplexArray) -> tuple[complex, complex]:
    """Static [kg m] and couple unbalance about the middle [kg m²] with the correction u."""
    rows = balance_rows(job)
    left = rows.masses @ unbalances(job) + rows.planes @ u
    _, arm = middle_and_arm(job)
    return complex(left[0]), complex(left[1] * arm) if len(left) > 1 else 0j


def _goal(job: KnownJob, correction: Correction) -> tuple[str, Entry] | None:
    if job.goal is None:
        return None
    aim = aim_of(job)
    if aim is None:
        return "correction", Entry(sum(amounts(correction), 0.0), "mass")
    size = float(abs(unbalances(job)).sum()) * aim.scale
    return aim.name, Entry(abs(_clean(aim.value(job, correction.u), size)), aim.dimension)


def amounts(correction: Correction) -> list[float]:
    """Mass per plane [kg] (unbalance [kg m] where a plane has no radius), of all its weights."""
    return [sum((weight.mass for weight in plane.weights), 0.0) for plane in correction.planes]


def _values(job: KnownJob, correction: Correction) -> dict[str, Value]:
    """Every number by its path."""
    values: dict[str, Value] = {}
    for plane, plane_answer in zip(job.planes, correction.planes, strict=True):
        values.update(_plane_values(plane, plane_answer))
    for when, u in (("as_found", 0.0 * correction.u), ("residual", correction.u)):
        left = Left.of(job, u)
        sizes = [("static", "static_angle", left.static, "unbalance")]
        sizes += [] if job.flat else [("couple", "couple_angle", left.couple, "couple_unbalance")]
        sizes += [(f"bearings.{n}.reaction", f"bearings.{n}.angle", z, "force") for n, z in left.reactions.items()]
        for size, angle, z, dimension in sizes:
            values[f"{when}.{size}"] = Entry(abs(z), dimension)
            if z:
                values[f"{when}.{angle}"] = direction_of(z)
        if not job.planes:
            break
    return values


def _plane_values(plane: Plane, answer: PlaneAnswer) -> dict[str, Value]:
    """Mass, angle, hole and depth of one plane; where material is removed, of the material to take away."""
    path, u, weights = f"planes.{plane.name}", answer.u, answer.weights
    values: dict[str, Value] = {f"{path}.unbalance": Entry(abs(u), "unbalance")}
    if plane.kind == MASS:
        values[f"{path}.mass"] = Entry(sum((weight.mass for weight in weights), 0.0), "mass", plane.unit)
    if plane.radii:
        values[f"{path}.radius"] = Entry(plane.radius, "length", plane.length_unit)
    if abs(u) > 0.0:
        values[f"{path}.angle"] = direction_of(-u if plane.remove else u)
    if plane.remove:
        values[f"{path}.action"] = Word("remove material here")
    if plane.drill is not None:
        values[f"{path}.depth"] = Entry(max((weight.depth or 0.0 for weight in weights), default=0.0), "length", "mm")
    if plane.shelf or len(weights) > 1 or any(weight.hole is not None for weight in weights):
        values[f"{path}.weights"] = Word(", ".join(_weight_words(plane, weight) for weight in weights) or "none")
    return values


def _weight_words(plane: Plane, weight: Weight) -> str:
    """ "5 g in hole 7 (105 deg)", or away from holes "5 g @ 105 deg"."""
    turned = f"{weight.angle / tau * 360.0:.6g} deg"
    where = f"@ {turned}" if weight.hole is None else f"in hole {weight.hole + 1} ({turned})"
    return f"{plane.show(weight.mass)} {where}"


def _clean(value: complex, size: float) -> complex:
    """Zero where a sum cancels to rounding, or to what a program leaves open."""
    return 0.0 if abs(value) < _OPEN * size else value


def _held(job: KnownJob, correction: Correction, left: Left, name: str, table: KnownLimitTable) -> Checked:
    """A limit or measure on the corrected shaft, by the masses turned by hand where it is a sum."""
    place = ""
    if table.response == "static_unbalance":
        value = abs(left.static)
    elif table.response == "couple_unbalance":
        value = abs(left.couple)
    elif table.response == "bearing_reaction":
        forces = {name: abs(force) for name, force in left.reactions.items()}
        place = f"of {table.of}" if table.of else ""
        value = forces[table.of] if table.of else max(forces.values())
    else:
        masses = dict(zip((plane.name for plane in job.planes), amounts(correction), strict=True))
        place = f"of {table.of}" if table.of else "in total"
        value = masses[table.of] if table.of else sum(masses.values())
    bound = None if table.at_most is None else Entry(table.bound, table.dimension, table.unit)
    return at_most(name, table.response, place, Entry(float(value), table.dimension, table.unit), bound)


def _worse(job: KnownJob, correction: Correction) -> list[str]:
    """Bearings that the correction loads more than the shaft did as found, of which no limit speaks."""
    limited = {limit.of for limit in job.limits.values() if limit.response == "bearing_reaction"}
    found, after = (Left.of(job, u).reactions for u in (0.0 * correction.u, correction.u))
    return [
        f"Bearing {name} is loaded more than as found: {Entry(abs(found[name]), 'force').shown} -> "
        f'{Entry(abs(force), "force").shown}. To forbid it, add a limit with response = "bearing_reaction" and '
        f'of = "{name}".'
        for name, force in after.items()
        if abs(force) > (1.0 + _WORSE) * abs(found[name]) and not limited & {name, None}
    ]


def _notes(job: KnownJob, correction: Correction) -> tuple[str, ...]:
    """What must be known to use the answer."""
    notes = []
    if reactions(job, correction.u):
        notes.append("A reaction is the force of the bearing on the shaft; it turns with it; weight is left out.")
    if not job.flat and not job.bearings:
        ends = "; the unbalances at both ends are those in the outermost of their planes"
        goal = job.goal is not None and job.goal.minimise == "unbalance"
        notes.append(
            f"Without bearings the couple is taken about the middle of all masses and planes{ends if goal else ''}."
        )
    notes += _worse(job, correction)
    static, couple = left_over(job, correction.u)
    size = float(abs(unbalances(job)).sum())
    complete = job.goal is not None and job.goal.minimise in ("unbalance", "reaction")
    if (
        complete
        and correction.way == "program"
        and max(abs(static), abs(couple) / middle_and_arm(job)[1]) > 1e-6 * size
    ):
        notes.append("Complete balance is out of reach within the caps, holes and limits; this is what comes nearest.")
    return tuple(notes)
