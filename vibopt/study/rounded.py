"""A design with the values that stand on the drawing: rounded, and measured as rounded."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from vibopt.answer.entry import Entry
from vibopt.errors import InputError
from vibopt.records import dataclass
from vibopt.scene.scene import MINIMISE, Design
from vibopt.study.freeze import frozen, goal_as_shown
from vibopt.study.grids import DIGITS, Grid, Number, grids, numbers
from vibopt.study.nearby import REACHES, Near, goal_on, roomiest, roomy_designs, search
from vibopt.units import plain
from vibopt.verify.checked import chosen_of

if TYPE_CHECKING:
    from vibopt.answer.answer import Answer
    from vibopt.jobs import Job

_SAME = 1e-12
_BEYOND = 100.0
"""A goal so many times worse was as good as zero, and is not said as a part of it."""


@dataclass(frozen=True, slots=True)
class Value:
    """A number of the design: exact, rounded, and the text that stands on the drawing."""

    exact: Entry
    rounded: Entry


@dataclass(frozen=True, slots=True)
class Rounded:
    """What rounding does to a design.

    design
        With the rounded values, every limit measured on the machine that has them.  Its status is `feasible`
        where they keep all limits and `violated` where no rounding does.
    kept
        The scene with the rounded values as facts.
    exact
        The answer that was rounded.
    values
        By path of the number in `kept`.
    worse_by
        What rounding costs, as a part of the exact goal; negative where the rounded one is better; None without a
        goal, or where the exact one is zero.
    tried
        Roundings looked at.
    goal
        With the rounded values.
    broken, by
        The limit that the nearest rounding breaks most, and by what part of its bound; "" and 0 where none breaks.
    enough
        Digits with which all limits hold, where they do not as asked; None where none was found.
    """

    design: Answer[Any]
    kept: Job
    exact: Answer[Any]
    values: Mapping[str, Value]
    worse_by: float | None
    tried: int
    goal: Entry | None = None
    broken: str = ""
    by: float = 0.0
    enough: int | None = None


def rounded(design: Design, asked: Sequence[str]) -> Rounded:
    """Round the chosen values of a design, and measure it anew.

    Parameters
    ----------
    design
        An answer with values.
    asked
        Significant digits for all ("3"), or steps of single values ("links.mount.stiffness=50 kN/m"), or both.

    Raises
    ------
    InputError
        What is asked cannot be read, there is no design, or nothing in it can be rounded.

    Notes
    -----
    The nearest values are taken where they keep every limit; else every combination of the values below and above,
    best goal first; where none of them does, those two and four steps away, and at last those near the best design for
    bounds that are tighter by up to a tenth.
    """
    scene = design.scene
    if not any(variable.values is None for variable in scene.variables):
        why = (
            "what is chosen are parts, places and listed values"
            if scene.variables or design.places
            else ("nothing is chosen")
        )
        raise InputError(f"{scene.name}: there is nothing to round: {why}.")
    if not design.x or design.status in ("check_failed", "unbounded"):
        raise InputError(f"{scene.name}: there is no design to round: {design.status}.")
    kept = frozen(scene, design.x)
    own = numbers(scene, kept)
    steps = grids(own, asked)
    best = search(design, kept, steps, REACHES)
    if best.good:
        return _made(design, steps, best)
    roomy = list(roomy_designs(design))
    spare = roomiest(design, roomy, asked)
    if spare is not None:
        return _made(design, steps, replace(spare, tried=best.tried + spare.tried))
    for more in _finer(steps):
        if search(design, kept, grids(own, (str(more),)), (1,)).good or roomiest(design, roomy, (str(more),)):
            return _made(design, steps, best, more)
    return _made(design, steps, best)


def _finer(steps: Sequence[Grid]) -> range:
    """Digits beyond those that were asked for."""
    most = max(step.digits for step in steps)
    return range(min(most + 1, DIGITS), DIGITS + 1)


def _made(design: Design, steps: Sequence[Grid], best: Near, enough: int | None = None) -> Rounded:
    goal = goal_as_shown(design.scene)
    value = goal_on(best.kept, goal) if goal is not None else None
    values = {step.path: Value(step.exact, step.shown(best.texts[step.path])) for step in steps}
    name, margin = ("", 0.0) if best.good else best.worst
    same = all(abs(one.rounded.value - one.exact.value) <= _SAME * abs(one.exact.value) for one in values.values())
    worse = 0.0 if same and goal is not None else _worse(design, value)
    status = "violated" if not best.good else design.status if same else "feasible"
    found = Rounded(design, best.kept, design, values, worse, best.tried, value, name, max(0.0, -margin), enough)
    chosen = {
        variable.path: _as_written(chosen_of(variable, v), values.get(variable.path))
        for variable, v in zip(design.scene.variables, best.x, strict=True)
    }
    tolerances, measured = design.tolerances, best.answer.tolerances
    if tolerances is not None and measured is not None:
        tolerances = replace(tolerances, open=measured.open)
    made = replace(
        design,
        status=status,
        claim=design.claim if same and best.good else claim_of(found, asked_words(steps)),
        goal=None if design.goal is None or value is None else (design.goal[0], value),
        variables=chosen,
        x=best.x,
        limits=best.answer.limits,
        measures={name: best.answer.measures[name] for name in design.measures},
        tolerances=tolerances,
        details={**design.details, "rounded": _plain(found, asked_words(steps))},
    )
    return replace(found, design=made)


def _as_written(chosen: Any, value: Value | None) -> Any:
    return chosen if value is None else replace(chosen, value=value.rounded)


def _worse(design: Design, value: Entry | None) -> float | None:
    if design.goal is None or value is None or design.scene.goal is None or not design.goal[1].value:
        return None
    sign = 1.0 if design.scene.goal.sense == MINIMISE else -1.0
    exact = design.goal[1].value
    part = sign * (value.value - exact) / abs(exact)
    return part if abs(part) < _BEYOND else None


def asked_words(steps: Sequence[Grid]) -> str:
    """What was asked: "to 3 digits", or "to steps of 50 kN/m"."""
    return f"to {', '.join(dict.fromkeys(step.words for step in steps))}"


def claim_of(found: Rounded, asked: str) -> str:
    """What is known of the rounded values, and what of the exact ones."""
    exact = found.exact
    if found.broken:
        percent = plain(100.0 * found.by, 2)
        words = f"no rounding {asked} near the exact values keeps every limit ({found.tried} tried)"
        words += f"; the best breaks {found.broken} by {percent} %"
        way = f"{found.enough} digits would do" if found.enough else f"nor do {DIGITS} digits"
        return f"{words}; {way}"
    cost = cost_words(found)
    known = {"optimal": "which are proven best", "feasible": "of which it is not proven that they are the best"}
    of = f"the exact values, {known.get(exact.status, 'which were found')} ({exact.claim})"
    return f"values rounded {asked}, every limit measured with them; {cost} {of}"


def cost_words(found: Rounded) -> str:
    """What rounding costs in the goal: "the goal is 0.12 % worse than that of"."""
    if found.worse_by is None:
        goals = found.goal.shown if found.goal is not None else "not known", found.exact.goal
        return f"the goal is {goals[0]} instead of {goals[1][1].shown if goals[1] else 'none'} with"
    if abs(found.worse_by) < 1e-9:
        return "the goal is the same as that of"
    way = "worse" if found.worse_by > 0.0 else "better, for ratios of the file hold only nearly,"
    return f"the goal is {plain(100.0 * abs(found.worse_by), 2)} % {way} than that of"


def _plain(found: Rounded, asked: str) -> dict[str, Any]:
    """For JSON."""
    goal = found.exact.goal
    return {
        "asked": asked,
        "exact": {
            "status": found.exact.status,
            "claim": found.exact.claim,
            "goal": goal[1] if goal else None,
        },
        "worse_by": found.worse_by,
        "values": dict(found.values),
        "tried": found.tried,
        "broken": found.broken,
        "broken_by": found.by,
        "enough_digits": found.enough,
    }


__all__ = ["Number", "Rounded", "Value", "asked_words", "claim_of", "cost_words", "goal_on", "rounded"]
