"""The plan of a measured rotor in blocks: what to fit, what will be left, and how far that is known."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

from vibopt.answer.answer import Answer
from vibopt.answer.blocks import (
    FOOT,
    TEXT,
    TODO,
    WARNING,
    WORK,
    Block,
    cleaned,
    limits_block,
    nearest_block,
    prices_block,
    table,
)
from vibopt.answer.entry import Entry
from vibopt.answer.plan import DeferredMapping, Fitting, PlaneAnswer, Remedy, RowAnswer, Weight
from vibopt.balancing.plan_values import shows_whole
from vibopt.balancing.rotor_job import RotorJob
from vibopt.units import show
from vibopt.units.showing import show_angle

MOST_COEFFICIENTS = 12
_WARNS = re.compile(
    "act almost alike|act nearly alike|What plane|Plane .* buys nothing|No sensor feels|not agree|No other run checks|"
    "do not meet|upper end of its 95 % band|no two weights together act"
)
_ACTIONS = {"remove": "take away", "keep": "untouched", "nothing": "no weight"}


def rotor_blocks(plan: Answer[RotorJob]) -> list[Block]:
    """What a rotor's plan says, in the order in which it is needed."""
    several = len(plan.plan.fittings) > 1
    warnings = tuple(note for note in plan.notes if _WARNS.search(note))
    further = tuple(note for note in plan.notes if note.startswith("Make one more run"))
    notes = tuple(note for note in plan.notes if note not in (*warnings, *further))
    answers = tuple(word for word in plan.plan.words if word.startswith("Answer ")) if several else ()
    todo = (*further, *(word for word in plan.plan.words if word not in answers)) if not several else further
    found = [
        Block(WARNING, TEXT, warnings),
        *nearest_blocks(plan),
        Block("What to do", TODO, todo),
        Block("Either", TEXT, answers),
    ]
    for number, fitting in enumerate(plan.plan.fittings, start=1):
        which = f", answer {number}" if several else ""
        weights = "Whole weights, all others taken off" if shows_whole(plan.job) else "Weights"
        found += [_weights(fitting, f"{weights}{which}"), _rows(fitting, f"What will be left{which}")]
    return [
        *found,
        replace(limits_block(plan), on_sheet=any(limit.response != "residual" for limit in plan.limits.values())),
        _cost(plan),
        prices_block(plan),
        _side_by_side(plan, plan.plan.beside, "Plans by other runs, side by side"),
        _side_by_side(plan, plan.plan.remedies, "Planes almost alike: the ways round, side by side"),
        *_quality(plan),
        _trials(plan),
        Block("Conventions", FOOT, plan.plan.conventions),
        Block("Notes", FOOT, notes),
        Block("Method", FOOT, (plan.method,) if plan.method else ()),
        _coefficients(plan),
    ]


def _cost(plan: Answer[RotorJob]) -> Block:
    """The goal beside that of the plan of which the prediction alone keeps the limits."""
    without = None if plan.tolerances is None else plan.tolerances.goal
    rows = [] if without is None or plan.goal is None else [(plan.goal[0], without.shown, plan.goal[1].shown)]
    return Block("What the tolerances cost", heads=("", "without", "with"), rows=tuple(rows))


def nearest_blocks(plan: Answer[Any], title: str = "The nearest plan") -> list[Block]:
    """The weights that miss the limits least, and how far each is missed."""
    near = plan.nearest
    return [] if near is None else [Block(title, TEXT, near.words), nearest_block(plan)]


def _weights(fitting: Fitting, title: str) -> Block:
    rows = [row for plane in fitting.planes for row in _plane(plane)]
    return table(title, ("Plane", "Weight", "Angle", "Hole", "Radius", "Depth", ""), rows)


def _plane(plane: PlaneAnswer) -> list[tuple[str, ...]]:
    what = _ACTIONS.get(plane.action, "")
    if not plane.weights:
        return [(plane.name, "-", "", "", "", "", what)]
    return [(plane.name, *_weight(weight, plane.mass), what) for weight in plane.weights]


def _weight(weight: Weight, mass: Entry) -> tuple[str, ...]:
    return (
        Entry(weight.mass, mass.dimension, mass.unit).shown,
        show_angle(weight.angle),
        "" if weight.hole is None else str(weight.hole + 1),
        "" if weight.radius is None else show(weight.radius, "mm", "length"),
        "" if weight.depth is None else show(weight.depth, "mm", "length", digits=3),
    )


def _rows(fitting: Fitting, title: str) -> Block:
    band = " (95 % band)" if any(row.band for row in fitting.rows) else ""
    fit = " (fit of all runs)" if any(row.fitted_phasor for row in fitting.rows) else ""
    heads = ("Sensor", "Speed", f"As found{fit}", f"After{band}", "At most", "Margin")
    rows = [_row(row) for row in fitting.rows]
    return replace(table(title, heads, rows, whole=(1, 2, 3, 4, 5)), measured=True)


def _row(row_answer: RowAnswer) -> tuple[str, ...]:
    after = row_answer.residual.shown
    if row_answer.band is not None:
        low, high = (end.short(3).partition(" ")[0] for end in row_answer.band)
        after += f"\n({low} to {high})"
    limit = "" if row_answer.limit is None else row_answer.limit.shown
    margin = (
        "" if row_answer.check is None else row_answer.check.margin_shown + ("" if row_answer.check.met else "\nBROKEN")
    )
    found = row_answer.found_phasor + (f"\n({row_answer.fitted_phasor})" if row_answer.fitted_phasor else "")
    return row_answer.sensor, row_answer.speed.shown, found, after, limit, margin


def _side_by_side(plan: Answer[RotorJob], plans: tuple[Remedy, ...], title: str) -> Block:
    scale = max((row.found for row in plan.plan.rows), key=lambda entry: float(entry.value), default=None)
    rows = [
        (
            remedy.name,
            cleaned(remedy.worst, scale).shown,
            cleaned(remedy.rms, scale).shown,
            ", ".join(remedy.masses),
            remedy.band,
        )
        for remedy in plans
    ]
    heads = ("Instead", "Worst left", "Rms left", "Weights", "95 % band")
    return table(title, heads, rows, whole=(1, 2))


def _quality(plan: Answer[RotorJob]) -> list[Block]:
    """Permissible unbalances by place, and the grade earned."""
    if plan.job.quality is None:
        return []
    values = {
        path.removeprefix("quality."): value for path, value in plan.values.items() if path.startswith("quality.")
    }
    if not values:
        return []
    rows = []
    for family, word in (("bearings", "bearing"), ("planes", "plane")):
        names = dict.fromkeys(path.split(".")[1] for path in values if path.startswith(f"{family}."))
        for name in names:
            keys = ("permissible", "may_show", "left")
            cells = [values.get(f"{family}.{name}.{key}") for key in keys]
            allowed = values.get(f"{family}.{name}.permissible")
            shown = ["" if cell is None else cleaned(cell, allowed).shown for cell in cells]
            if shown[1].startswith("-"):
                shown[1] = "nothing"
            rows.append((f"{word} {name}", *shown))
    lines = [
        f"Permissible unbalance of the whole rotor: {values['permissible'].shown} "
        f"(eccentricity {values['eccentricity'].shown}; {values['kind'].shown} rotor)."
    ]
    if "earned" in values:
        met = "is" if values["met"].shown == "yes" else "is NOT"
        grade = cleaned(values["earned"], Entry(plan.job.quality.grade, "velocity"))
        lines.append(
            f"{'The unbalance given' if plan.job.quality.residual else 'What should be left'} "
            f"earns the grade {grade.shown} (worst at {values['worst_at'].shown}): "
            f"the grade asked for {met} met."
        )
    return [
        Block("Quality grade", TEXT, tuple(lines)),
        table("Permissible residual unbalance", ("At", "Permissible", "May be measured", "Left"), rows),
    ]


def _trials(plan: Answer[RotorJob]) -> Block:
    advised = plan.values if plan.job.rotor_mass is not None else {}
    found = [(path.split(".")[1], value) for path, value in advised.items() if path.startswith("planes_first.")]
    if any(word.endswith(".") and "first trial" in word for word in plan.plan.words):
        found = []
    lines = tuple(f"{name}: at most {one.short(3)}." for name, one in found)
    return Block("First trial weights", TEXT, lines)


def _coefficients(plan: Answer[RotorJob]) -> Block:
    many = plan.values.more // 2 if isinstance(plan.values, DeferredMapping) else 0  # what nobody reads is not written
    every = plan.values if many <= MOST_COEFFICIENTS else {}
    found = {path: value for path, value in every.items() if path.startswith("influence.") and path.endswith("value")}
    many = max(many, len(found))
    title = "Influence coefficients, for the next job ([[influence]])"
    if many > MOST_COEFFICIENTS:
        return Block(title, WORK, (f"{many} values; vibopt solve --json prints them under influence.",))
    rows = []
    for path, one in found.items():
        _, sensor, plane, *speed, _ = path.split(".")
        rows.append((sensor, ".".join(speed), plane, str(one.value)))
    return table(title, ("Sensor", "Speed", "Plane", "Value"), rows, WORK)
