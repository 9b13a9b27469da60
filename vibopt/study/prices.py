"""What a limit costs: the scene solved again with it loosened, and without it."""

from __future__ import annotations

import math
from dataclasses import replace

from vibopt.answer.entry import Checked, Entry, Price
from vibopt.report.machine_words import THOROUGH
from vibopt.responses import Response
from vibopt.scene.facts import FactAt, fact_at
from vibopt.scene.read import from_dict, with_changes
from vibopt.scene.scene import Design, Scene
from vibopt.solve import solve
from vibopt.units import read_quantity, to_unit
from vibopt.verify.checked import shown_value

PATIENCE = 2_000.0
"""Work of an answer [nominal ms] beyond which it is priced only when that is asked for."""
QUICK = 100.0
"""The same for the bound where a limit stops to matter, which takes some fifty answers."""

STEP = 0.1
"""A sensible step: a tenth of the bound."""
_NEAR = 0.05
"""Part of the step by which rounding may change it."""


def priced(design: Design, *, until: bool = False, thorough: bool = False) -> Design:
    """The same design with a price on every active limit; analyses and failures are returned as they are.

    Parameters
    ----------
    design
        An answer with a goal.
    until
        Look as well for the bound beyond which loosening buys nothing more (some fifty solutions per limit).
    thorough
        Whatever the work; without it the answer says what was left out.
    """
    if design.goal is None or design.status not in ("optimal", "feasible"):
        return design
    asked = [key for key, row in design.limits.items() if _has_price(design, row)]
    if not asked:
        return design
    names = ", ".join(dict.fromkeys(design.limits[key].name for key in asked))
    if design.work > PATIENCE and not thorough:
        note = f"No price was computed for {names}: each is an answer of its own. {THOROUGH} computes it."
        return replace(design, notes=(*design.notes, note))
    ends = until and (thorough or design.work <= QUICK)
    note = f"Where {names} would stop to matter was not looked for: some fifty answers each. {THOROUGH} does."
    limits = {key: replace(design.limits[key], price=_price(design, design.limits[key], ends)) for key in asked}
    notes = design.notes if ends or not until else (*design.notes, note)
    return replace(design, limits={**design.limits, **limits}, notes=notes)


def _has_price(design: Design, row: Checked) -> bool:
    return row.active and row.side != "outside" and row.name in design.scene.limits


def _price(design: Design, row: Checked, until: bool) -> Price | None:
    scene = design.scene
    assert row.limit is not None
    assert design.goal is not None
    fact = fact_at(scene, f"limits.{row.name}.{row.side}")
    response = scene.limits[row.name]
    sign = 1.0 if row.side == "at_most" else -1.0
    aimed = fact.value * (1.0 + sign * STEP)
    if response.complement:
        aimed = 1.0 - (1.0 - fact.value) * (1.0 + STEP * (1.0 if row.side == "at_least" else -1.0))
    if response.dimension == "count":  # the next whole number; there is none below one
        aimed, until = max(fact.value + sign, 1.0), False
    loosened = _rounded(response, fact, aimed)
    if loosened.value == fact.value:
        return None
    goal = _goal_at(design, fact, loosened.value)
    if goal is None:
        return None
    end = _until(design, row, fact) if until else None
    return Price(_words(design, row, loosened, goal, end), loosened, goal, end)


def _rounded(response: Response, fact: FactAt, aimed: float) -> Entry:
    """A bound with as few digits as leave the step what it is: one that can be named as it is solved."""
    step, unit = aimed - fact.value, fact.unit
    for digits in range(1, 5):
        number = float(f"{to_unit(aimed, unit, fact.dimension) if unit else aimed:.{digits - 1}e}")
        text = f"{number:.12g} {unit}".strip()
        value = read_quantity(text, fact.dimension, amplitude=fact.amplitude).value if unit else number
        if abs(value - aimed) <= _NEAR * abs(step):
            return shown_value(response, value, unit)
    return shown_value(response, aimed, unit)


def _asked(design: Design) -> Scene:
    """The scene as it was asked, with the places open that were."""
    return design.scene.asked or design.scene


def _goal_at(design: Design, fact: FactAt, bound: float) -> Entry | None:
    """Goal of the scene with one bound changed."""
    other = solve(with_changes(_asked(design), {fact.path: fact.text(bound)}), explain=False, brief=True, near=design.x)
    return other.goal[1] if other.goal is not None else None


def _until(design: Design, row: Checked, fact: FactAt) -> Entry | None:
    """The bound from which on the goal is as good as without the limit; None when it always helps."""
    free = solve(without_bound(_asked(design), row.name, row.side), explain=False, brief=True, near=design.x)
    if free.goal is None:
        return None
    target = free.goal[1].value
    good, bad = fact.value * (1e-6 if row.side == "at_least" else 1e6), fact.value
    if not _as_good(_goal_at(design, fact, good), target):
        return None
    for _ in range(60):
        middle = math.sqrt(good * bad)
        if _as_good(_goal_at(design, fact, middle), target):
            good = middle
        else:
            bad = middle
        if abs(good / bad - 1.0) < 1e-6:
            break
    response = design.scene.limits[row.name]
    return shown_value(response, good, fact.unit)


def _as_good(goal: Entry | None, target: float) -> bool:
    return goal is not None and abs(goal.value - target) <= 1e-8 * abs(target)


def without_bound(scene: Scene, name: str, side: str) -> Scene:
    """The scene less one bound of one limit."""
    document = dict(scene.document)
    document["limits"] = {key: dict(table) for key, table in document["limits"].items()}
    document["limits"][name].pop(side)
    if not any(key in document["limits"][name] for key in ("at_most", "at_least", "outside")):
        document["limits"].pop(name)
    return from_dict(document, name=scene.name)


def _words(design: Design, row: Checked, loosened: Entry, goal: Entry, until: Entry | None) -> str:
    assert row.limit is not None
    assert design.goal is not None
    name, now = design.goal
    text = f"{row.limit.shown} -> {loosened.shown}: {name} {now.shown} -> {goal.shown}"
    if now.shown == goal.shown:
        text = f"{row.limit.shown} -> {loosened.shown}: {name} stays {now.shown}"
    return f"{text}; nothing more to gain beyond {until.shown}" if until is not None else text
