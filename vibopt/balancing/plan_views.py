"""What measured rotors, known masses and engines add to the views of their answers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from vibopt.answer.answer import Answer, odds_said
from vibopt.answer.answer_schema import NUMBER, OPEN, TEXT, TEXTS, listed, maybe, named, ref, table
from vibopt.answer.blocks import Block
from vibopt.answer.entry import Entry
from vibopt.balancing import ENGINE, KNOWN, ROTOR, is_rotor
from vibopt.balancing.blocks_masses import engine_blocks, engine_nearest, known_blocks, known_nearest
from vibopt.balancing.blocks_rotor import nearest_blocks as rotor_nearest
from vibopt.balancing.blocks_rotor import rotor_blocks

if TYPE_CHECKING:
    from vibopt.balancing import BalancingJob


_AMOUNT = dict.fromkeys(("mass", "unbalance"), ref("number"))
_WEIGHT = table(
    {
        **dict.fromkeys(("radius", "depth"), maybe(ref("number"))),
        "angle": ref("number"),
        "hole": {"type": ["integer", "null"]},
    },
    _AMOUNT,
)
_PLANE = table(
    {"action": {"enum": ["add", "remove", "nothing", "keep"]}, "angle": ref("number"), "radius": maybe(ref("number")),
     "weights": listed(_WEIGHT), "words": TEXT},
    _AMOUNT | {"acts_as": ref("number")},
)  # fmt: skip
_READING = table(
    {
        **dict.fromkeys(("speed", "found", "residual"), ref("number")),
        **dict.fromkeys(("found_phasor", "fitted_phasor", "residual_phasor"), TEXT),
        "band": maybe(listed(ref("number"))), "limit": maybe(ref("number")), "margin": NUMBER,
    }
)  # fmt: skip
_SENSOR = table({"speeds": listed(_READING), "residual": ref("number"), "found": ref("number")})
_FITTING = {"planes": named(_PLANE), "sensors": named(_SENSOR)}
_WAYS = listed(table({"remedy": TEXT, "worst": ref("number"), "rms": ref("number"), "masses": TEXTS, "band": TEXT}))
_STATED = named(TEXT) | {"properties": {"words": TEXTS}}
KEYS = {
    "rotor": (
        {"conventions": _STATED, "words": TEXTS, **_FITTING, "answers": listed(table(_FITTING)), "remedies": _WAYS,
         "beside": _WAYS, "condition": NUMBER, "gap": NUMBER},
        {**dict.fromkeys(("influence", "quality", "planes_first", "trim"), ref("entries")), "tolerances": OPEN},
    ),
    "known": ({}, dict.fromkeys(("planes", "as_found", "residual"), ref("entries"))),
    "engine": (
        {"cylinders": ref("entries"), "orders": ref("entries"), "all_orders": ref("entries")},
        {**dict.fromkeys(("counterweights", "balance_shafts", "firing"), ref("entries")),
         **dict.fromkeys(("counterweight_share", "rotating_share"), ref("number"))},
    ),
}  # fmt: skip
"""By kind of job: what its answers have in JSON beside what all have, always and sometimes."""


def sense_of(answer: Answer[BalancingJob]) -> str:
    """Balancing makes least."""
    return "" if answer.goal is None else "minimise"


def notes_of(answer: Answer[BalancingJob]) -> list[str]:
    """How the file was read, and what must be known to use the answer."""
    return list(answer.notes)


def own_json(answer: Answer[BalancingJob]) -> dict[str, Any]:
    """Of a measured rotor its plan and conventions; what the others add are values by path."""
    conventions = getattr(answer.job, "conventions", None)
    if conventions is None:
        return {}
    said = {"conventions": {**conventions.said(), "words": answer.plan.conventions}, **answer.plan.to_json()}
    return said if answer.tolerances is None else {**said, "tolerances": answer.tolerances}


_PLAIN = {
    "optimal": "",
    "feasible": "all limits hold; that nothing better exists is not proven",
    "met": "all limits hold",
    "violated": "limits do not hold",
    "infeasible": "no weights keep all limits",
    "unbounded": "the goal has no best value",
    "unproven": "",
    "check_failed": "the simulated machine refused the answer",
}


def goal_words(answer: Answer[BalancingJob]) -> str:
    """What was made least, and how far: "least worst residual is 0.3216 mil pp"; "least" where that is proven."""
    if answer.goal is None or answer.status in ("infeasible", "unbounded", "met", "violated"):
        return ""
    name, value = answer.goal[0], _without_rounding(answer, answer.goal[1])
    lead = "least " if answer.status == "optimal" else ""
    return "" if len(answer.plan.fittings) > 1 else f"{lead}{name.replace('_', ' ')} is {value.shown}"


def _without_rounding(answer: Answer[BalancingJob], value: Entry) -> Entry:
    """Zero where nothing but rounding is left at any sensor."""
    rows = answer.plan.rows
    nothing = bool(rows) and all(row.left == 0.0 for row in rows)
    if nothing and answer.goal is not None and answer.goal[0] != "correction":
        return replace(value, value=0.0)
    return value


def verdict(answer: Answer[BalancingJob]) -> str:
    """What the first line of the answer says behind its status; "" where the claim says all."""
    said = _PLAIN[answer.status]
    if odds := odds_said(answer):
        said = said.replace("all limits hold", f"all limits hold, {odds}")
    if answer.status == "met" and not answer.limits:
        said = "no limit was set; what was asked stands below"
    if answer.status == "unproven" or (is_rotor(answer.job) and answer.status in ("met", "violated")):
        said = ""
    return "; ".join(filter(None, (goal_words(answer), said)))


def next_step(answer: Answer[BalancingJob]) -> tuple[str, str]:
    """What to type next, with FILE for the file, and what for; "" where the plan itself says what to do."""
    least = None if answer.conflict is None else answer.conflict.least
    if least is not None:
        return f'vibopt solve FILE --set limits.{least[0]}.at_most="{least[2].shown}"', "with the smallest loosening"
    if answer.status == "infeasible" and not is_rotor(answer.job):
        return "vibopt whatif FILE", "see which number, changed alone, would help"
    if answer.status in ("infeasible", "unbounded", "unproven"):
        return "vibopt explain FILE --thorough", "learn why, with all that can be said"
    if answer.status == "check_failed" or len(answer.plan.fittings) > 1:
        return "", ""
    return "vibopt report FILE --sheet -o NAME.html", "print a page for the shop floor"


def nearest_blocks(answer: Answer[Any]) -> list[Block]:
    """The weights that miss the limits least; none where there are others."""
    views: dict[str, Callable[[Answer[Any]], list[Block]]] = {
        ROTOR: rotor_nearest, KNOWN: known_nearest, ENGINE: engine_nearest,
    }  # fmt: skip
    found = views[answer.job.kind](answer) if answer.nearest is not None else []
    return [block for block in found if block.lines or block.rows]


def blocks(answer: Answer[Any]) -> list[Block]:
    """Everything the answer says, in the order in which it is needed."""
    return BLOCKS[answer.job.kind](answer)


def figures(answer: Answer[BalancingJob], *, compact: bool = False) -> list[tuple[str, str]]:
    """Title and SVG of the picture, where there is something to draw."""
    from vibopt.balancing.figures import figure_of
    from vibopt.report.figures import saved

    figure = figure_of(answer, compact=compact)
    return [] if figure is None else [(answer.title, saved(figure, "svg").decode())]


def signs(answer: Answer[BalancingJob]) -> tuple[str, ...]:
    """Who signs the page."""
    return ("Fitted by (name)" if is_rotor(answer.job) else "Done by (name)", "Date", "Checked by")


BLOCKS: Mapping[str, Callable[[Answer[Any]], list[Block]]] = {
    ROTOR: rotor_blocks, KNOWN: known_blocks, ENGINE: engine_blocks,
}  # fmt: skip
