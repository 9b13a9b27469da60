"""What a limit costs: the scene solved again with it loosened, and without it."""

from __future__ import annotations

import math
from dataclasses import replace

from vibopt.design.certify import measure
from vibopt.design.design import Checked, Design, Price, Shown
from vibopt.scene.facts import fact_at
from vibopt.scene.read import with_changes
from vibopt.solve import solve
from vibopt.solve.solve import outward_shown, shown_value

STEP = 0.1
"""A sensible step: a tenth of the bound."""


def priced(design: Design) -> Design:
    """The same design with a price on every active limit; analyses and failures are returned as they are."""
    if design.goal is None or design.status not in ("optimal", "feasible"):
        return design
    limits = {
        key: replace(row, price=_price(design, row)) if row.active and row.side != "outside" else row
        for key, row in design.limits.items()
    }
    return replace(design, limits=limits)


def _price(design: Design, row: Checked) -> Price | None:
    scene = design.scene
    assert row.limit is not None and design.goal is not None
    fact = fact_at(scene, f"limits.{row.name}.{row.side}")
    response = scene.limits[row.name]
    sign = 1.0 if row.side == "at_most" else -1.0
    aimed = fact.value * (1.0 + sign * STEP)
    if response.complement:
        aimed = 1.0 - (1.0 - fact.value) * (1.0 + STEP * (1.0 if row.side == "at_least" else -1.0))
    loosened = outward_shown(response, aimed, fact.unit, row.side, digits=2)
    other = solve(with_changes(scene, {fact.path: fact.text(loosened.value)}), explain=False)
    if other.goal is None:
        return None
    until = _until(design, row)
    return Price(loosened, other.goal[1], until, _words(design, row, loosened, other.goal[1], until))


def _until(design: Design, row: Checked) -> Shown | None:
    """Value that the response takes when its limit is left out: beyond it loosening buys nothing."""
    scene = design.scene
    document = dict(scene.document)
    document["limits"] = {name: dict(table) for name, table in document["limits"].items()}
    document["limits"][row.name].pop(row.side)
    if not any(key in document["limits"][row.name] for key in ("at_most", "at_least", "outside")):
        document["limits"].pop(row.name)
    from vibopt.scene.read import from_dict

    free = solve(from_dict(document, name=scene.name), explain=False)
    if not free.x:
        return None
    chosen = {v.path: value for v, value in zip(scene.variables, free.x, strict=True)}
    response = scene.limits[row.name]
    value = measure(scene, chosen, response, row.side).value
    if not math.isfinite(value):
        return None
    return shown_value(response, value, response.unit or getattr(getattr(response, row.side), "unit", ""))


def _words(design: Design, row: Checked, loosened: Shown, goal: Shown, until: Shown | None) -> str:
    assert row.limit is not None and design.goal is not None
    name, now = design.goal
    text = f"{row.limit.shown} -> {loosened.shown}: {name} {now.shown} -> {goal.shown}"
    if now.shown == goal.shown:
        text = f"{row.limit.shown} -> {loosened.shown}: {name} stays {now.shown}"
    return f"{text}; no more to gain beyond {until.shown}" if until is not None else text
