"""A balancing answer as blocks of words and tables, the same for the terminal and for the printed page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite
from typing import TYPE_CHECKING

from vibopt.balancing.outcome import Entry
from vibopt.jobs import is_engine, is_known, is_plan
from vibopt.units import plain, show

if TYPE_CHECKING:
    from vibopt.jobs import Job, Solution

TODO, TABLE, TEXT, WORK, FOOT = "todo", "table", "text", "work", "foot"
"""Kinds of block: what to do; a table; sentences; what only the next job needs; conventions, notes, method."""

WARNING = "Warning"

_PLAIN = {
    "optimal": "",
    "feasible": "all limits hold; that nothing better exists is not proven",
    "met": "all limits hold",
    "violated": "limits do not hold",
    "infeasible": "no weights keep all limits",
    "unbounded": "the goal has no best value",
    "unproven": "no single answer is proven",
    "check_failed": "the simulated machine refused the answer",
}


@dataclass(frozen=True, slots=True)
class Block:
    """A title with sentences, or with a table; a cell of two lines holds a line feed.

    whole
        Columns that are never broken.
    """

    title: str
    kind: str = TABLE
    lines: tuple[str, ...] = ()
    heads: tuple[str, ...] = ()
    rows: tuple[tuple[str, ...], ...] = ()
    whole: tuple[int, ...] = ()


def table(
    title: str,
    heads: Sequence[str],
    rows: Sequence[Sequence[str]],
    kind: str = TABLE,
    whole: Sequence[int] | None = None,
) -> Block:
    """A table without the columns in which nothing stands."""
    kept = [k for k in range(len(heads)) if any(row[k] for row in rows)]
    cells = tuple(tuple(row[k] for k in kept) for row in rows)
    unbroken = kept if whole is None else [k for k in kept if k in whole]
    named = tuple(heads[k] for k in kept)
    return Block(
        title, kind, heads=named if any(named) else (), rows=cells, whole=tuple(kept.index(k) for k in unbroken)
    )


def brief(entry: Entry, digits: int = 4) -> str:
    """A number as people copy it: four digits, angles to a tenth of a degree."""
    if isinstance(entry.value, str):
        return entry.value
    if entry.dimension == "angle":
        from vibopt.balancing.words import show_angle

        return show_angle(entry.value)
    return show(entry.value, entry.unit, entry.dimension, digits=digits, amplitude=entry.amplitude)


def cleaned(entry: Entry, scale: Entry | None) -> Entry:
    """Zero where the value is nothing but rounding beside `scale`."""
    if scale is None or isinstance(scale.value, str) or isinstance(entry.value, str):
        return entry
    small = abs(entry.value) < 1e-9 * abs(scale.value)
    return Entry(0.0, entry.dimension, entry.unit, entry.amplitude) if small else entry


def share(part: float) -> str:
    """What is left of a limit in percent; "" without a limit."""
    if not isfinite(part):
        return ""
    percent = 100.0 * part
    return f"{plain(0.0 if abs(percent) < 1e-4 else percent, 2 if abs(percent) < 10 else 3)} %"


def state(margin: float, met: bool) -> str:
    """BROKEN, ACTIVE or nothing."""
    return "BROKEN" if not met else "ACTIVE" if margin < 1e-6 else ""


def goal_words(answer: Solution) -> str:
    """What was made least, and how far: "least worst residual is 0.3216 mil pp"."""
    if answer.goal is None or answer.status in ("infeasible", "unbounded", "met", "violated"):
        return ""
    name, value = answer.goal[0], _cleaned(answer, answer.goal[1])
    if is_plan(answer) and len(answer.fittings) > 1:
        return ""
    return f"least {name.replace('_', ' ')} is {brief(value)}"


def _cleaned(answer: Solution, value: Entry) -> Entry:
    """Zero where nothing but rounding is left at any sensor."""
    rows = answer.rows if is_plan(answer) else ()
    if rows and all(one.left == 0.0 for one in rows) and answer.goal is not None and answer.goal[0] != "correction":
        return Entry(0.0, value.dimension, value.unit, value.amplitude)
    return value


def verdict(answer: Solution) -> str:
    """The first line of every answer, without its proof."""
    said = _PLAIN[answer.status]
    if answer.status == "met" and not answer.limits:
        said = "no limit was set; what was asked stands below"
    if is_plan(answer) and answer.status in ("met", "violated", "unproven"):
        said = ""
    words = "; ".join(filter(None, (goal_words(answer), said)))
    return f"{answer.status}: {words}" if words else f"{answer.status}: {answer.claim}"


def claim(answer: Solution) -> str:
    """How that is known; "" where the verdict has said it already."""
    return "" if verdict(answer).endswith(answer.claim) else answer.claim


def blocks_of(answer: Solution, job: Job) -> list[Block]:
    """Everything the answer says, in the order in which it is needed."""
    if is_plan(answer):
        from vibopt.balancing.blocks_rotor import rotor_blocks

        found = rotor_blocks(answer)
    elif is_known(job):
        from vibopt.balancing.blocks_known import known_blocks

        found = known_blocks(answer, job)
    else:
        from vibopt.balancing.blocks_engine import engine_blocks

        assert is_engine(job)
        found = engine_blocks(answer, job)
    return [one for one in found if one.lines or one.rows]
