"""What a balancing answer says: its verdict, and all its blocks in the order in which they are needed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from vibopt.answer.answer import Answer
from vibopt.answer.entry import Entry
from vibopt.balancing.blocks import Block
from vibopt.balancing.blocks_engine import engine_blocks
from vibopt.balancing.blocks_known import known_blocks
from vibopt.balancing.blocks_rotor import rotor_blocks
from vibopt.jobs import is_engine, is_known, is_rotor

if TYPE_CHECKING:
    pass

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


def goal_words(answer: Answer[Any]) -> str:
    """What was made least, and how far: "least worst residual is 0.3216 mil pp"."""
    if answer.goal is None or answer.status in ("infeasible", "unbounded", "met", "violated"):
        return ""
    name, value = answer.goal[0], _cleaned(answer, answer.goal[1])
    if is_rotor(answer.job) and len(answer.plan.fittings) > 1:
        return ""
    return f"least {name.replace('_', ' ')} is {value.shown}"


def _cleaned(answer: Answer[Any], value: Entry) -> Entry:
    """Zero where nothing but rounding is left at any sensor."""
    rows = answer.plan.rows if is_rotor(answer.job) else ()
    if rows and all(one.left == 0.0 for one in rows) and answer.goal is not None and answer.goal[0] != "correction":
        return Entry(0.0, value.dimension, value.unit, value.amplitude)
    return value


def verdict(answer: Answer[Any]) -> str:
    """The first line of every answer, without its proof."""
    said = _PLAIN[answer.status]
    if answer.status == "met" and not answer.limits:
        said = "no limit was set; what was asked stands below"
    if is_rotor(answer.job) and answer.status in ("met", "violated", "unproven"):
        said = ""
    words = "; ".join(filter(None, (goal_words(answer), said)))
    return f"{answer.status}: {words}" if words else f"{answer.status}: {answer.claim}"


def claim(answer: Answer[Any]) -> str:
    """How that is known; "" where the verdict has said it already."""
    return "" if verdict(answer).endswith(answer.claim) else answer.claim


def blocks_of(answer: Answer[Any]) -> list[Block]:
    """Everything the answer says, in the order in which it is needed."""
    job = answer.job
    if is_rotor(job):
        found = rotor_blocks(answer)
    elif is_known(job):
        found = known_blocks(answer, job)
    else:
        assert is_engine(job)
        found = engine_blocks(answer, job)
    return [one for one in found if one.lines or one.rows]
