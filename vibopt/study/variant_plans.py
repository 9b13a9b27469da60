"""Rows of a table of balancing plans: goal, weights, facts that differ, limits, and what is left."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from vibopt.answer.entry import Entry, Value
from vibopt.jobs import facts
from vibopt.study.freeze import MEASURED
from vibopt.study.seen import chosen, goal_of, results
from vibopt.study.variant_cells import Cell, Row
from vibopt.study.variant_rows import goal_row, limit_rows, verdict_rows
from vibopt.units import si_unit

if TYPE_CHECKING:
    from vibopt.answer.answer import Answer
    from vibopt.balancing import BalancingJob


def rows_of_plans(jobs: Sequence[BalancingJob], found: Sequence[Answer[Any]]) -> list[Row]:
    """All rows of the table, in the order in which they are read."""
    rows = verdict_rows(found)
    rows += _goals(found)
    paths = dict.fromkeys(path for one in jobs for path in one.choices)
    taken = [chosen(job, one) for job, one in zip(jobs, found, strict=True)]
    rows += [_numbers("chosen", path, [one.get(path) for one in taken]) for path in paths]
    rows += _facts(jobs)
    rows += limit_rows(found)
    left = [{**{name: measure.value for name, measure in a.measures.items()}, **results(j, a)}
            for j, a in zip(jobs, found, strict=True)]  # fmt: skip
    names = dict.fromkeys(name for one in left for name in one if name not in MEASURED.values())
    return rows + [_numbers("measure", name, [one.get(name) for one in left]) for name in names]


def _goals(found: Sequence[Answer[Any]]) -> list[Row]:
    """What any plan makes least, on every plan that measures it."""
    names = dict.fromkeys(one.goal[0] for one in found if one.goal is not None)
    shown = {name: [_goal(one, name) for one in found] for name in names}
    return [goal_row(f"least {name.replace('_', ' ')}", -1.0, goals, found) for name, goals in shown.items()]


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
