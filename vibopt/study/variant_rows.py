"""Rows of a table of variants: goals, choices, facts that differ, price, limits, measures, natural frequencies.

Machines are compared by what they are as built, balancing plans by their weights and what is left.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.answer.answer import Answer
from vibopt.answer.blocks import at_words, spoken
from vibopt.answer.entry import Checked, Entry, Word
from vibopt.document.toml_reading import inside
from vibopt.errors import InputError
from vibopt.jobs import facts
from vibopt.report.catalogue_choices import tied
from vibopt.scene.places import bought, place_of
from vibopt.scene.scene import MAXIMISE, MINIMISE, Design, Goal, Scene
from vibopt.study.freeze import frozen
from vibopt.study.rounded import goal_on
from vibopt.study.seen import NOTHING, entries_of, goal_of, results, shown_value
from vibopt.study.variant_cells import SAME, Cell, Row, comparable, marked, price_of, price_words, row_of
from vibopt.values.fields import Fact, rule_of
from vibopt.verify.as_built import machine_of
from vibopt.verify.measured_goal import MEASURED, goal_as_shown

if TYPE_CHECKING:
    from vibopt.balancing import BalancingJob

MOST_MODES = 6


def rows_of(designs: Sequence[Design]) -> list[Row]:
    """All rows of the table of machines, in the order in which they are read."""
    rows = [*_verdict_rows(designs), *_goal_rows(designs), *_chosen_rows(designs)]
    rows += _fact_rows(designs, {row.name for row in rows})
    rows += [*_price_rows(designs), *_limit_rows(designs)]
    rows += _measure_rows([_measures(design) for design in designs])
    return rows + _mode_rows(designs)


def rows_of_plans(jobs: Sequence[BalancingJob], found: Sequence[Answer[Any]]) -> list[Row]:
    """The same of balancing plans."""
    names = dict.fromkeys(answer.goal[0] for answer in found if answer.goal is not None)
    goals = [
        _goal_row(f"least {name.replace('_', ' ')}", -1.0, [_goal_of_plan(answer, name) for answer in found], found)
        for name in names
    ]
    paths = dict.fromkeys(path for job in jobs for path in job.choices)
    said = [{fact.path: Entry(fact.value, fact.dimension, fact.unit) for fact in facts(job)} for job in jobs]
    taken = [
        {} if answer.status in NOTHING else {**here, **entries_of(job, answer)}  # what was saved is a fact
        for job, here, answer in zip(jobs, said, found, strict=True)
    ]
    left = [_measures(answer) | results(job, answer) for job, answer in zip(jobs, found, strict=True)]
    return [
        *_verdict_rows(found),
        *goals,
        *(row_of("chosen", path, [one.get(path) for one in taken]) for path in paths),
        *(row for row in _differing(said, lambda k, path: None) if row.name.replace(".weight.", ".") not in paths),
        *_limit_rows(found),
        *_measure_rows(left),
    ]


def _verdict_rows(found: Sequence[Answer[Any]]) -> list[Row]:
    """Verdicts, and why an answer cannot be used."""
    rows = [Row("verdict", "verdict", "", tuple(Cell(answer.status) for answer in found))]
    reasons = [_reason(answer) for answer in found]
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
    return [_goal_row_of(name, goal, designs) for name, goal in goals.items()]


def _goal_name(goal: Goal) -> str:
    what = "least" if goal.sense == MINIMISE else "greatest"
    return f"{what} {spoken(goal.response.response, place_of(goal.response))}"


def _goal_row_of(name: str, goal: Goal, designs: Sequence[Design]) -> Row:
    sense = 1.0 if goal.sense == MAXIMISE else -1.0
    if goal.response.response == "price":
        return _price_row("goal", name, sense, designs)
    return _goal_row(name, sense, [_goal_of(design, name, goal) for design in designs], designs)


def _goal_row(name: str, sense: float, shown: Sequence[Entry | None], found: Sequence[Answer[Any]]) -> Row:
    """One goal on every answer that has it; `sense` is 1 where more is better, else -1."""
    row = row_of("goal", name, shown)
    return replace(row, cells=marked(row.cells, sense, [answer.exit_code == 0 for answer in found]))


def _goal_of_plan(answer: Answer[Any], name: str) -> Entry | None:
    """The goal of an answer, or the measure that it became in a saved plan."""
    if answer.goal is not None:
        return goal_of(answer.job, answer) if answer.goal[0] == name else None
    row = answer.measures.get(MEASURED[MINIMISE])
    return row.value if row is not None and row.response == name else None


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
    own = (path for design in designs for path in design.variables if path not in tied(design.scene))
    free = dict.fromkeys(path for path in own if ".part." not in path)
    rows = [row_of("chosen", path, [_place_at(design, path) for design in designs]) for path in placed]
    return rows + [row_of("chosen", path, [_value_at(design, path) for design in designs]) for path in free]


def _fact_rows(designs: Sequence[Design], known: set[str]) -> list[Row]:
    """Numbers and parts of the files that differ from variant to variant."""
    names = [_bought(design.scene) for design in designs]
    rows = []
    for path in dict.fromkeys(path for name in names for path in name):
        parts = [name.get(path) for name in names]
        if path not in known and len(set(parts)) > 1:
            rows.append(row_of("fact", path, [None if name is None else Word(name) for name in parts]))
    said = [_facts_of(design.scene) for design in designs]
    return rows + _differing(said, lambda k, path: _brought(designs[k], path), known)


def _differing(
    said: Sequence[Mapping[str, Entry]], brought: Callable[[int, str], Entry | None], known: Collection[str] = ()
) -> list[Row]:
    """Numbers that differ from file to file, but for `known`; bounds stand with their limits.

    What the k-th file does not say at a path may be `brought` by a part.
    """
    rows = []
    for path in dict.fromkeys(path for one in said for path in one):
        if path in known or path.startswith("limits."):
            continue
        values = [one[path] if path in one else brought(k, path) for k, one in enumerate(said)]
        if len({value.value for value in values if value is not None}) > 1:
            rows.append(row_of("fact", path, values))
    return rows


def _facts_of(scene: Scene) -> dict[str, Entry]:
    """Every number of a file by its path, as the file has it."""
    return {fact.path.removesuffix(".value"): shown_value(fact, fact.value) for fact in facts(scene)}


def _brought(design: Design, path: str) -> Entry | None:
    """A number of a link that its part brings, chosen or fixed; None where it brings none."""
    if path in design.variables:
        return design.variables[path].value
    family, name, *steps = path.split(".")
    table = design.scene.links.get(name) if family == "links" else None
    if table is None or len(steps) != 1 or steps[0] not in table.brought:
        return None
    value, rule = getattr(table, steps[0]), rule_of(type(table), steps[0])
    if not isinstance(value, Fact) or rule is None:
        return None
    return Entry(value.value, rule.dimension, value.unit)


def _bought(scene: Scene) -> dict[str, str]:
    """Names of the parts that are fixed, by path."""
    return {f"{path}.part": part.name for path, part in bought(scene).items() if part.name is not None}


def _place_at(design: Design, path: str) -> Word | None:
    """A place or a part, chosen or of the file."""
    if path in design.places:
        return Word(design.places[path].value)
    here = inside(design.scene.document, path)
    if isinstance(here, Mapping):
        here = here.get("name")
    return Word(here) if isinstance(here, str) else None


def _value_at(design: Design, path: str) -> Entry | None:
    """A number, chosen, of the file or brought by a part."""
    if path in design.variables:
        return design.variables[path].value
    return _facts_of(design.scene).get(path) or _brought(design, path)


def _price_rows(designs: Sequence[Design]) -> list[Row]:
    """What the bought parts cost together, where it is not the goal of any."""
    if any((goal := goal_in(design.scene)) is not None and goal.response.response == "price" for design in designs):
        return []
    row = _price_row("price", "price of all parts", -1.0, designs)
    return [row] if any(row.cells) else []


def _price_row(kind: str, name: str, sense: float, designs: Sequence[Design]) -> Row:
    """Prices of variants; of those that differ in what is bought none is the best."""
    prices = [price_of(design, design.scene.named(design.x)) if has_machine(design) else None for design in designs]
    said = [
        None if price is None else replace(price, text=price_words(price, design, designs))
        for design, price in zip(designs, prices, strict=True)
    ]
    rivals = [design.exit_code == 0 and fair for design, fair in zip(designs, comparable(designs), strict=True)]
    row = row_of(kind, name, said)
    return replace(row, cells=marked(row.cells, sense, rivals))


def _limit_rows(designs: Sequence[Answer[Any]]) -> list[Row]:
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


def _measures(answer: Answer[Any]) -> dict[str, Entry]:
    return {name: row.value for name, row in answer.measures.items()}


def _measure_rows(measured: Sequence[Mapping[str, Entry]]) -> list[Row]:
    """What was measured of each, but for what was its goal."""
    names = dict.fromkeys(name for one in measured for name in one if name not in MEASURED.values())
    return [row_of("measure", name, [one.get(name) for one in measured]) for name in names]


def _mode_rows(designs: Sequence[Design]) -> list[Row]:
    """The lowest natural frequencies of each machine without tolerances."""
    modes = [
        np.sort(machine_of(design.scene, design.scene.named(design.x)).natural_frequencies())
        if has_machine(design)
        else np.zeros(0)
        for design in designs
    ]
    count = min(max(map(len, modes)), MOST_MODES)
    rows = []
    for k in range(count):
        shown = [Entry(float(mode[k]), "angular_rate", "Hz") if k < len(mode) else None for mode in modes]
        rows.append(row_of("frequency", f"natural frequency {k + 1}", shown))
    return rows
