"""The answer to an engine: measured on its cylinders turning, and said in numbers by path."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import degrees

import numpy as np

from vibopt.answer.answer import Answer
from vibopt.answer.entry import Checked, Entry, Value, Word, at_most, direction_of
from vibopt.arrays import ComplexArray, FloatArray
from vibopt.balancing.engine.choose_weights import NOTHING, Balanced, balance, goal_table, least_bound
from vibopt.balancing.engine.engine_job import EngineJob
from vibopt.balancing.engine.engine_tables import EngineLimitTable
from vibopt.balancing.engine.firing import best_firing, is_even
from vibopt.balancing.engine.shaking import (
    Arms,
    arms,
    around,
    at_crank,
    carried_shares,
    exact_orders,
    of_order,
    peak,
    size_of,
    turning_weights,
)
from vibopt.balancing.impasses import NOTHING_FOUND, Asking
from vibopt.balancing.optimisers import Solver, solve_question
from vibopt.units import show
from vibopt.units.showing import show_angle
from vibopt.work import metered

STEPS = 4096


def simulated(job: EngineJob, found: Balanced, couple: bool) -> ComplexArray:
    """Shaking force [N] (couple [N m]) over one turn of the simulated engine, (STEPS,)."""
    turn, total = np.arange(STEPS) * 2.0 * np.pi / STEPS, np.zeros(STEPS, dtype=complex)
    shares = carried_shares(job, found.x)
    for cylinder in job.cylinders:
        lever = cylinder.at if couple else 1.0
        crank = turn + found.cranks[cylinder.throw]
        along = -cylinder.reciprocating * job.speed**2 * _second_derivative(_piston(crank - cylinder.bank, job.ratio))
        opposite = sum(part * share.of(cylinder) for share, part in zip(job.shares, shares, strict=True))
        carried = cylinder.rotating - opposite
        total += lever * (along * np.exp(1j * cylinder.bank) + carried * job.speed**2 * np.exp(1j * crank))
    for weight, u in zip(job.weights, turning_weights(job, found.x), strict=True):
        lever = weight.at if couple else 1.0
        path = u * np.exp(1j * weight.sense * weight.order * turn)
        total += lever * -_second_derivative(path.real) * job.speed**2
        total += 1j * lever * -_second_derivative(path.imag) * job.speed**2
    return total


def _piston(crank: FloatArray, ratio: float) -> FloatArray:
    """Distance of the piston from the crank axis in crank radii, less the rod, beside which digits are lost."""
    across = np.sin(crank) ** 2
    return np.asarray(np.cos(crank) - ratio * across / (1.0 + np.sqrt(1.0 - ratio**2 * across)))


def _second_derivative(path: FloatArray) -> FloatArray:
    """d²/da² of a function of the crank angle given over one turn."""
    orders = np.fft.rfftfreq(len(path), 1.0 / len(path))
    spectrum: ComplexArray = np.fft.rfft(path)
    return np.asarray(np.fft.irfft(-(orders**2) * spectrum, len(path)))


_MORE = 20
"""Orders behind those of the answer that the turning engine may show."""
_TINY = 1e-6
_SAME = 0.01
"""Percent below which two numbers of five digits are the same."""


def solve_engine(job: EngineJob, *, thorough: bool = False, solver: Solver = solve_question) -> Answer[EngineJob]:
    """Choose what is to be chosen, and say what is left; `thorough` says what clashes, whatever the work."""
    with metered() as meter:
        found = balance(job, solver)
    answer = answer_at(job, found)
    if answer.status not in NOTHING_FOUND or not job.limits:
        return answer
    return Asking(
        job.limits, lambda limits: balance(replace(job, limits=limits)), lambda one: _rows(job, one, job.limits),
        lambda one: _values(job, one, arms(job, one.cranks)), meter.done, thorough,
        lambda name: least_bound(job, name),
    ).told(answer)  # fmt: skip


def answer_at(job: EngineJob, found: Balanced) -> Answer[EngineJob]:
    """What is measured on the engine with what was chosen, which may be for several scenarios of it."""
    here = arms(job, found.cranks)
    limits = _rows(job, found, job.limits)
    status, claim = found.status, found.claim
    if status in ("optimal", "feasible", "met"):
        status, claim = _checked(job, found, here, limits)
    goal, none = goal_table(job), status in NOTHING_FOUND
    value = _measured(job, found, goal)
    return Answer(
        job=job,
        status=status,
        claim=claim,
        values=_values(job, found, here),
        limits={} if none else limits,
        measures=_rows(job, found, job.measures),
        goal=None if job.goal is None or none else (job.goal.minimise, Entry(value, goal.dimension)),
        method=found.way,
        notes=(*job.notes, *_notes(job, found, here, none=none)),
        rates=found.rates,
        details={"classes": found.tried, "as_good": found.alike},
    )


def _rows(job: EngineJob, found: Balanced, tables: Mapping[str, EngineLimitTable]) -> dict[str, Checked]:
    return {name: _held(job, found, name, table) for name, table in tables.items()}


def _checked(job: EngineJob, found: Balanced, here: Arms, limits: dict[str, Checked]) -> tuple[str, str]:
    """Status after the pistons were moved through a turn in time and their accelerations taken by differences."""

    if not job.truncated:
        beyond = float(np.abs(exact_orders(job.ratio, job.orders + _MORE)[job.orders + 1 :]).sum())
        for couple in (False, True):
            shown, now = simulated(job, found, couple), here.at(found.x)
            off = float(np.abs(shown - around(now, couple, STEPS)).max())
            gap = max(off, float(np.abs(shown).max()) - peak(now, couple)) / size_of(job, couple)
            if gap > 1e-5 + beyond:
                return "check_failed", f"the turning engine shows {gap:.1e} of all forces more or less than its orders"
    broken = [name for name, limit in limits.items() if not limit.met]
    if broken and found.status == "met":
        return "violated", "limits that do not hold: " + ", ".join(broken)
    if broken:
        return "check_failed", "limits that the chosen weights break: " + ", ".join(broken)
    return found.status, found.claim


def _clean(value: float, size: float) -> float:
    """Zero where a sum cancels to rounding."""
    return 0.0 if value < NOTHING * size else float(value)


def _measured(job: EngineJob, found: Balanced, table: EngineLimitTable) -> float:
    """A response of the engine as balanced [N or N m]."""
    truncated = None if table.kinematics is None else table.kinematics == "truncated"
    now = arms(job, found.cranks, truncated=truncated).at(found.x)
    if table.when is not None:
        value = at_crank(now, table.is_couple, table.of_order, table.when.value)
    else:
        value = of_order(now, table.is_couple, table.of_order)
    return _clean(value, size_of(job, table.is_couple))


def _held(job: EngineJob, found: Balanced, name: str, table: EngineLimitTable) -> Checked:
    """A limit or measure."""
    order = f"of order {table.order}" if table.order else ""
    bound = None if table.at_most is None else Entry(table.bound, table.dimension, table.unit)
    value = Entry(_measured(job, found, table), table.dimension, table.unit)
    size = size_of(job, table.is_couple)
    return at_most(name, table.response, order, value, bound, None if bound is None or bound.value else size)


def _values(job: EngineJob, found: Balanced, here: Arms) -> dict[str, Value]:
    """Every number by its path."""
    values: dict[str, Value] = {}
    for k, cylinder in enumerate(job.cylinders):
        values[f"cylinders.{k + 1}.crank"] = direction_of(np.exp(1j * found.cranks[cylinder.throw]))
    for share, carried in zip(job.shares, carried_shares(job, found.x), strict=True):
        values[share.name] = Entry(carried, "ratio")
    for weight, u in zip(job.weights, turning_weights(job, found.x), strict=True):
        if weight.fixed is None:
            values[f"{weight.family}.{weight.name}.unbalance"] = Entry(abs(u), "unbalance", weight.unit)
            if u:
                values[f"{weight.family}.{weight.name}.angle"] = direction_of(u)
    values.update(_orders(job, here.at(found.x)))
    if len(job.cylinders) > 1:
        firing = best_firing(job, found.cranks)
        values["firing.order"] = Word("-".join(map(str, job.fires)) or firing.text)
        values["firing.even"] = Word("yes" if is_even(firing) else "no")
        if not job.fires:
            values["firing.neighbours"] = Entry(float(firing.neighbours), "count")
    return values


def _orders(job: EngineJob, now: ComplexArray) -> dict[str, Value]:
    """Force and couple of each order that the series has, and the greatest of all together over a turn."""
    values: dict[str, Value] = {}
    for couple, word, dimension in ((False, "force", "force"), (True, "couple", "moment")):
        size = size_of(job, couple)
        for order in (1, *range(2, (2 if job.truncated else job.orders) + 1, 2)):
            values[f"orders.{order}.{word}"] = Entry(_clean(of_order(now, couple, order), size), dimension)
        values[f"all_orders.{word}"] = Entry(_clean(peak(now, couple), size), dimension)
    return values


def _more(full: float, cut: float, some: bool, unit: str) -> str:
    """ "1200 N (+3 %)", "the same": what exact kinematics shows beside two orders, to a hundredth of a percent."""
    if not some:
        return f"{full:.5g} {unit} (all of it)"
    percent = 100.0 * (full / cut - 1.0)
    return "the same" if abs(percent) < _SAME else f"{full:.5g} {unit} ({percent:+.2g} %)"


def _notes(job: EngineJob, found: Balanced, here: Arms, *, none: bool) -> tuple[str, ...]:
    """Conventions, and what the textbook's two terms would have hidden."""
    notes = [
        "Crank angles are counted in the sense of rotation; couples are about "
        "the middle of the cylinders unless the file says reference.",
    ]
    exact, short = (
        (here if job.truncated is cut else arms(job, found.cranks, truncated=cut)).at(found.x) for cut in (False, True)
    )
    for couple, word, unit in () if none else ((False, "force", "N"), (True, "couple", "N m")):
        full, cut = (_clean(peak(one, couple), size_of(job, couple)) for one in (exact, short))
        if max(full, cut) > _TINY * size_of(job, couple):
            said = f"Two orders alone show a greatest {word} of {cut:.5g} {unit}"
            notes.append(f"{said}; exact kinematics {_more(full, cut, cut > _TINY * size_of(job, couple), unit)}.")
    if job.spaced and job.weights:
        places = [cylinder.at + job.reference for cylinder in job.cylinders]
        first, last, middle = (
            show(value, "mm", "length") for value in (places[0], places[-1], 0.5 * sum(places[:: len(places) - 1]))
        )
        notes.append(
            f"Places are counted from cylinder 1 at {first}; the last cylinder is at {last}, the middle of all at "
            f"{middle}."
        )
    if any(u.sense < 0 or u.order == 2 for u in job.weights):
        stands = show_angle(found.cranks[job.cylinders[0].throw])
        notes.append(
            f"The angle of a balance shaft is that of its weight when the crank of cylinder 1 stands at {stands}."
        )
    if job.is_search:
        listed = ", ".join(f"{degrees(crank):.6g}" for crank in found.cranks)
        notes.append(f"Cranks, in the order of the throws: {listed} deg.")
    return tuple(notes)
