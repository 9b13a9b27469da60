"""Rows of a table of variants: goals, choices, facts that differ, price, limits, measures, natural frequencies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from vibopt.answer.answer import Answer
from vibopt.answer.blocks import at_words, spoken
from vibopt.answer.entry import Checked, Entry
from vibopt.arrays import FloatArray
from vibopt.errors import InputError
from vibopt.report.catalogue_choices import tied
from vibopt.responses.response import place_of
from vibopt.scene.facts import FactAt, facts
from vibopt.scene.scene import MAXIMISE, MINIMISE, Design, Goal, Scene
from vibopt.study.freeze import MEASURED, frozen, goal_as_shown
from vibopt.study.rounded import goal_on
from vibopt.study.variant_cells import SAME, Cell, Row, bought, comparable, marked, price_of, price_words
from vibopt.units import si_unit
from vibopt.values.fields import Fact, rule_of
from vibopt.verify.as_built import machine_of

MOST_MODES = 6


def rows_of(designs: Sequence[Design]) -> list[Row]:
    """All rows of the table, in the order in which they are read."""
    rows = verdict_rows(designs)
    rows += _goal_rows(designs)
    rows += _chosen_rows(designs)
    rows += _fact_rows(designs, {row.name for row in rows})
    rows += _price_rows(designs)
    rows += limit_rows(designs)
    rows += _measure_rows(designs)
    return rows + _mode_rows(designs)


def verdict_rows(found: Sequence[Answer[Any]]) -> list[Row]:
    """Verdicts, and why an answer cannot be used."""
    rows = [Row("verdict", "verdict", "", tuple(Cell(one.status) for one in found))]
    reasons = [_reason(one) for one in found]
    if any(reasons):
        rows.append(Row("reason", "why", "", tuple(Cell(reason) if reason else None for reason in reasons)))
    return rows


def has_machine(design: Design) -> bool:
    """Whether there is a machine to measure."""
    return bool(design.limits or design.measures or design.x or design.places) and design.status != "unbounded"


def _reason(design: Answer[Any]) -> str:
    """Why a variant has no answer that can be used; "" where it has one."""
    if design.exit_code == 0:
        return ""
    if design.reason:
        return design.reason
    if design.conflict is not None:
        return f"cannot hold together: {', '.join(design.conflict.limits)}"
    broken = [name for name, limit in design.limits.items() if not limit.met]
    return f"breaks {', '.join(broken)}" if broken else design.claim


def goal_in(scene: Scene) -> Goal | None:
    """The goal of a scene, or of the file that a saved design came from."""
    if scene.goal is not None:
        return goal_as_shown(scene)
    for sense in (MINIMISE, MAXIMISE):
        if MEASURED[sense] in scene.measures:
            response = scene.measures[MEASURED[sense]]
            return Goal(sense, response.response, response)
    return None


def _goal_rows(designs: Sequence[Design]) -> list[Row]:
    """Every goal that a variant has, on each variant on which it can be measured."""
    goals: dict[str, Goal] = {}
    for design in designs:
        goal = goal_in(design.scene)
        if goal is not None:
            goals.setdefault(_goal_name(goal), goal)
    return [_goal_row(name, goal, designs) for name, goal in goals.items()]


def _goal_name(goal: Goal) -> str:
    what = "least" if goal.sense == MINIMISE else "greatest"
    return f"{what} {spoken(goal.response.response, place_of(goal.response))}"


def _goal_row(name: str, goal: Goal, designs: Sequence[Design]) -> Row:
    sense = 1.0 if goal.sense == MAXIMISE else -1.0
    if goal.response.response == "price":
        return _price_row("goal", name, sense, designs)
    return goal_row(name, sense, [_goal_of(design, name, goal) for design in designs], designs)


def goal_row(name: str, sense: float, shown: Sequence[Entry | None], found: Sequence[Answer[Any]]) -> Row:
    """One goal on every answer that has it; `sense` is 1 where more is better, else -1."""
    unit = next((one.si for one in shown if one is not None), "")
    cells = [None if one is None else Cell(one.shown, one.value) for one in shown]
    return Row("goal", name, unit, marked(cells, sense, [one.exit_code == 0 for one in found]))


def _goal_of(design: Design, name: str, goal: Goal) -> Entry | None:
    if not has_machine(design):
        return None
    own = goal_in(design.scene)
    if design.goal is not None and own is not None and _goal_name(own) == name:
        return design.goal[1]
    if design.variables or design.places:
        return _measured_goal(frozen(design.scene, design.x), goal)
    return _measured_goal(design.scene, goal)


def _measured_goal(scene: Scene, goal: Goal) -> Entry | None:
    """A goal on another machine; None where its places are not there."""
    try:
        return goal_on(scene, goal)
    except (KeyError, StopIteration, InputError, AssertionError):
        return None


def _chosen_rows(designs: Sequence[Design]) -> list[Row]:
    """Parts, places and values that any variant chooses, with what the others have there."""
    placed = dict.fromkeys(path for design in designs for path in design.places)
    free = dict.fromkeys(path for design in designs for path in design.variables if not _of_part(path, design))
    rows = [Row("chosen", path, "", tuple(_place_cell(design, path) for design in designs)) for path in placed]
    for path in free:
        cells = tuple(_value_cell(design, path) for design in designs)
        unit = next(design.variables[path].value.si for design in designs if path in design.variables)
        rows.append(Row("chosen", path, unit, cells))
    return rows


def _fact_rows(designs: Sequence[Design], known: set[str]) -> list[Row]:
    """Numbers and parts of the files that differ from variant to variant; bounds stand with their limits."""
    said = [{fact.path.removesuffix(".value"): fact for fact in facts(design.scene)} for design in designs]
    rows = []
    for path in dict.fromkeys(path for one in designs for path in _bought(one.scene)):
        names = [_bought(one.scene).get(path) for one in designs]
        if path not in known and len(set(names)) > 1:
            rows.append(Row("fact", path, "", tuple(None if name is None else Cell(name) for name in names)))
    for path in dict.fromkeys(path for one in said for path in one):
        if path in known or path.startswith("limits."):
            continue
        found = [one.get(path) for one in said]
        cells = tuple(
            _brought_cell(design, path) if one is None else _fact_cell(one)
            for one, design in zip(found, designs, strict=True)
        )
        if len({cell.value for cell in cells if cell is not None}) > 1:
            unit = next(si_unit(one.dimension) for one in found if one is not None)
            rows.append(Row("fact", path, unit, cells))
    return rows


def _fact_cell(one: FactAt) -> Cell:
    return Cell(Entry(one.value, one.dimension, one.unit, amplitude=one.amplitude).shown, one.value)


def _brought_cell(design: Design, path: str) -> Cell | None:
    """A number of a link that its part brings, chosen or fixed; None where it brings none."""
    if path in design.variables:
        chosen = design.variables[path].value
        return Cell(chosen.shown, chosen.value)
    family, name, *steps = path.split(".")
    table = design.scene.links.get(name) if family == "links" else None
    if table is None or len(steps) != 1 or steps[0] not in table.brought:
        return None
    value, rule = getattr(table, steps[0]), rule_of(type(table), steps[0])
    if not isinstance(value, Fact) or rule is None:
        return None
    return Cell(Entry(value.value, rule.dimension, value.unit).shown, value.value)


def _bought(scene: Scene) -> dict[str, str]:
    """Names of the parts that are fixed, by path."""
    return {f"{path}.part": part.name for path, part in bought(scene).items() if part.name is not None}


def _of_part(path: str, design: Design) -> bool:
    """Whether a number is a column of a part."""
    return ".part." in path or path in tied(design.scene)


def _place_cell(design: Design, path: str) -> Cell | None:
    if path in design.places:
        return Cell(design.places[path].value)
    here: object = design.scene.document
    for step in path.split("."):
        here = here.get(step) if isinstance(here, Mapping) else None
    if isinstance(here, Mapping):
        here = here.get("name")
    return Cell(here) if isinstance(here, str) else None


def _value_cell(design: Design, path: str) -> Cell | None:
    if path in design.variables:
        value = design.variables[path].value
        return Cell(value.shown, value.value)
    found = (fact for fact in facts(design.scene) if fact.path.removesuffix(".value") == path)
    return next((_fact_cell(one) for one in found), None) or _brought_cell(design, path)


def _price_rows(designs: Sequence[Design]) -> list[Row]:
    """What the bought parts cost together, where it is not the goal of any."""
    if any((goal := goal_in(design.scene)) is not None and goal.response.response == "price" for design in designs):
        return []
    row = _price_row("price", "price of all parts", -1.0, designs)
    return [row] if any(row.cells) else []


def _price_row(kind: str, name: str, sense: float, designs: Sequence[Design]) -> Row:
    """Prices of variants; of those that differ in what is bought none is the best."""
    shown = [price_of(design, _chosen(design)) if has_machine(design) else None for design in designs]
    cells = [
        None if price is None else Cell(price_words(price, design, designs), price.value)
        for design, price in zip(designs, shown, strict=True)
    ]
    rivals = [design.exit_code == 0 and fair for design, fair in zip(designs, comparable(designs), strict=True)]
    unit = next((one.si for one in shown if one is not None), "")
    return Row(kind, name, unit, marked(cells, sense, rivals))


def _chosen(design: Design) -> dict[str, float]:
    return (
        {variable.path: float(v) for variable, v in zip(design.scene.variables, design.x, strict=True)}
        if design.x
        else {}
    )


def limit_rows(designs: Sequence[Answer[Any]]) -> list[Row]:
    """The room of every limit."""
    names = dict.fromkeys(name for design in designs for name in design.limits)
    rows = []
    for name in names:
        checked = [design.limits.get(name) for design in designs]
        cells = [None if one is None else Cell(limit_words(one), one.margin) for one in checked]
        rivals = [one is not None and one.met for one in checked]
        if any(one is not None and one.response == "price" for one in checked):
            rivals = [met and fair for met, fair in zip(rivals, comparable(designs), strict=True)]
        room = ["" if one is None else one.margin_shown for one in checked]
        rows.append(Row("limit", name, "", marked(cells, 1.0, rivals, room, least=SAME)))
    return rows


def limit_words(checked: Checked) -> str:
    """The worst value, the bound and the room: "268 N pk at 1500 rpm\\nat most 330 N pk, 18.8 %"."""
    at, state = at_words(checked.worst_at), checked.state
    side = checked.side.replace("_", " ")
    bound = f"{side} {checked.limit.shown}" if checked.limit is not None else ""
    room = ", ".join(filter(None, (bound, checked.margin_shown, state)))
    return f"{checked.value.shown}{f' at {at}' if at else ''}\n{room}"


def _measure_rows(designs: Sequence[Design]) -> list[Row]:
    goals = set(MEASURED.values())
    names = dict.fromkeys(name for design in designs for name in design.measures if name not in goals)
    rows = []
    for name in names:
        shown = [design.measures[name].value if name in design.measures else None for design in designs]
        unit = next(one.si for one in shown if one is not None)
        cells = tuple(None if one is None else Cell(one.shown, one.value) for one in shown)
        rows.append(Row("measure", name, unit, cells))
    return rows


def _mode_rows(designs: Sequence[Design]) -> list[Row]:
    """The lowest natural frequencies of each machine without tolerances."""
    modes = [_modes(design) if has_machine(design) else np.zeros(0) for design in designs]
    count = min(max(map(len, modes)), MOST_MODES)
    rows = []
    for k in range(count):
        shown = [Entry(float(mode[k]), "angular_rate", "Hz") if k < len(mode) else None for mode in modes]
        cells = tuple(None if one is None else Cell(one.shown, one.value) for one in shown)
        rows.append(Row("frequency", f"natural frequency {k + 1}", "rad/s", cells))
    return rows


def _modes(design: Design) -> FloatArray:
    return np.sort(np.asarray(machine_of(design.scene, _chosen(design)).natural_frequencies(), dtype=float))


__all__ = ["Cell", "Row", "goal_in", "has_machine", "limit_words", "rows_of"]
