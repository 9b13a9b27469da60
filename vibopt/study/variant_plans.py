"""Rows of a table of balancing plans: goal, weights, facts that differ, limits, and what is left."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from vibopt.answer.entry import Entry, Value
from vibopt.jobs import facts
from vibopt.study.freeze import MEASURED
from vibopt.study.seen import chosen, goal_of, reason, results
from vibopt.study.variant_cells import SAME, Cell, Row, marked
from vibopt.study.variant_rows import limit_words
from vibopt.units import si_unit

if TYPE_CHECKING:
    from vibopt.answer.answer import Answer
    from vibopt.balancing import BalancingJob


def rows_of_plans(jobs: Sequence[BalancingJob], found: Sequence[Answer[Any]]) -> list[Row]:
    """All rows of the table, in the order in which they are read."""
    rows = [Row("verdict", "verdict", "", tuple(Cell(one.status) for one in found))]
    why = [_why(one) for one in found]
    if any(why):
        rows.append(Row("reason", "why", "", tuple(Cell(one) if one else None for one in why)))
    rows += _goals(found)
    paths = dict.fromkeys(path for one in jobs for path in one.choices)
    taken = [chosen(job, one) for job, one in zip(jobs, found, strict=True)]
    rows += [_numbers("chosen", path, [one.get(path) for one in taken]) for path in paths]
    rows += _facts(jobs)
    rows += _limits(found)
    left = [{**{name: measure.value for name, measure in a.measures.items()}, **results(j, a)}
            for j, a in zip(jobs, found, strict=True)]  # fmt: skip
    names = dict.fromkeys(name for one in left for name in one if name not in MEASURED.values())
    return rows + [_numbers("measure", name, [one.get(name) for one in left]) for name in names]


def _why(one: Answer[Any]) -> str:
    if one.exit_code == 0:
        return ""
    broken = [name for name, row in one.limits.items() if not row.met]
    return reason(one) or (f"breaks {', '.join(broken)}" if broken else one.claim)


def _goals(found: Sequence[Answer[Any]]) -> list[Row]:
    """What any plan makes least, on every plan that measures it."""
    names = dict.fromkeys(one.goal[0] for one in found if one.goal is not None)
    rows = []
    for name in names:
        shown = [_goal(one, name) for one in found]
        cells = [None if one is None else Cell(one.shown, one.value) for one in shown]
        unit = next((one.si for one in shown if one is not None), "")
        best = marked(cells, -1.0, [one.exit_code == 0 for one in found])
        rows.append(Row("goal", f"least {name.replace('_', ' ')}", unit, best))
    return rows


def _goal(found: Answer[Any], name: str) -> Entry | None:
    """The goal of an answer, or the measure that it became in a saved plan."""
    if found.goal is not None:
        return goal_of(found.job, found) if found.goal[0] == name else None
    row = found.measures.get(MEASURED["minimise"])
    return row.value if row is not None and row.response == name else None


def _numbers(kind: str, name: str, values: Sequence[Value | None]) -> Row:
    unit = next((value.si for value in values if isinstance(value, Entry)), "")
    cells = [
        None if value is None else Cell(value.shown, value.value if isinstance(value, Entry) else None)
        for value in values
    ]
    return Row(kind, name, unit, tuple(cells))


def _facts(jobs: Sequence[BalancingJob]) -> list[Row]:
    """Numbers of the files that differ; bounds stand with their limits."""
    said = [{fact.path: fact for fact in facts(job)} for job in jobs]
    rows = []
    for path in dict.fromkeys(path for one in said for path in one):
        found = [one.get(path) for one in said]
        if path.startswith("limits.") or len({one.value for one in found if one is not None}) < 2:
            continue
        entries = [None if one is None else Entry(one.value, one.dimension, one.unit) for one in found]
        first = next(one for one in found if one is not None)
        cells = tuple(None if entry is None else Cell(entry.shown, entry.value) for entry in entries)
        rows.append(Row("fact", path, si_unit(first.dimension), cells))
    return rows


def _limits(found: Sequence[Answer[Any]]) -> list[Row]:
    rows = []
    for name in dict.fromkeys(name for one in found for name in one.limits):
        held = [one.limits.get(name) for one in found]
        cells = [None if one is None else Cell(limit_words(one), one.margin) for one in held]
        room = ["" if one is None else one.margin_shown for one in held]
        best = marked(cells, 1.0, [one is not None and one.met for one in held], room, least=SAME)
        rows.append(Row("limit", name, "", best))
    return rows
