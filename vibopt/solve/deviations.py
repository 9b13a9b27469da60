"""Scenes with tolerances: answered over all machines within them, and measured on the worst."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import product

import numpy as np

from vibopt.answer.answer import Tolerances
from vibopt.answer.entry import Checked
from vibopt.arrays import FloatArray
from vibopt.mechanics.combine import FOUND, foremost
from vibopt.program.worst_case import Hit, around, doubts_at, hit, measured_around, missed
from vibopt.scene.scene import Design, Scene
from vibopt.scene.uncertain import Uncertain, uncertain
from vibopt.solve.method import Found
from vibopt.solve.proof import decided
from vibopt.solve.robust import Robust
from vibopt.verify.as_built import differing
from vibopt.verify.checked import Offs, checked_limits, checked_measures, chosen_of, goal_of, limit_rows
from vibopt.verify.rated import parts_of

_CORNERS = 4
"""Uncertain numbers up to which the built machine is measured at every corner as well."""


def side_by_side(scene: Scene, nominal: Found | None, robust: Robust, goal_off: Mapping[str, float]) -> Tolerances:
    """The answer without tolerances, to stand beside the one with them."""
    widths = {one.path: one.tolerance for one in uncertain(scene)}
    if nominal is None or nominal.x is None:
        return Tolerances("", None, {}, widths, goal_off, robust.open)
    plain = replace(scene, off={})
    chosen = scene.named(nominal.x)
    goal = goal_of(plain, chosen)
    variables = {variable.path: chosen_of(variable, chosen[variable.path]).value for variable in scene.variables}
    parts = {path: word.value for path, word in parts_of(plain, chosen).items()}
    return Tolerances(nominal.status, goal[1] if goal else None, variables, widths, goal_off, robust.open, parts)


def limit_offs(scene: Scene, x: FloatArray, hits: Mapping[int, Hit]) -> Offs:
    """Machines on which each row of the limits is measured: the worst found, and the corners of few numbers."""
    doubts, program = doubts_at(scene, x), around(scene, x)
    corners = _corners(doubts)
    found: dict[str, list[Mapping[str, float]]] = {}
    for key, (name, side) in limit_rows(scene).items():
        own = [i for i, limit in enumerate(program.limits) if limit.name == name and limit.user_side == side]
        index = own[foremost([missed(program.limits[i], hits[i].value) for i in own], even=FOUND)]  # of several bands
        found[key] = [_named(doubts, hits[index].factors), *([] if hits[index].proven or hits[index].sure else corners)]
    rated = [(i, one) for i, one in enumerate(program.limits) if one.name not in scene.limits]  # brought by parts
    for index, limit in rated:
        both = any((one.name, one.side) == (limit.name, "at_most") for _, one in rated)
        key = f"{limit.name} (at_least)" if both and limit.side == "at_least" else limit.name
        found.setdefault(key, []).append(_named(doubts, hits[index].factors))
    return found


def _measure_offs(scene: Scene, x: FloatArray, hits: Mapping[str, Hit]) -> Offs:
    """Machines on which each measure is measured: as those of a limit."""
    doubts = doubts_at(scene, x)
    corners = _corners(doubts)
    return {
        name: [_named(doubts, one.factors), *([] if one.proven or one.sure else corners)] for name, one in hits.items()
    }


def goal_machine(scene: Scene, hits: Mapping[int, Hit]) -> dict[str, float]:
    """Factors of the machine on which the goal is worst."""
    return _named(uncertain(scene), hits[-1].factors) if -1 in hits else {}


def limits_over(scene: Scene, x: FloatArray, robust: Robust) -> dict[str, Checked]:
    """Limits on the worst machines around a design."""
    chosen = scene.named(x)
    return checked_limits(scene, chosen, limit_offs(scene, x, robust.hits))


def measures_over(scene: Scene, x: FloatArray, robust: Robust) -> tuple[dict[str, Checked], Robust]:
    """Measures on the worst machines around a design, and what is proven of them beside limits and goal."""
    chosen = scene.named(x)
    hits, left = {}, list(robust.open)
    for name in scene.measures:
        program, part = measured_around(scene, x, name)
        hits[name], told = decided(part, program.axes, hit(part, program.axes))
        left += [] if told else [f"measures.{name}"]
    rows = checked_measures(scene, chosen, _measure_offs(scene, x, hits))
    return rows, replace(robust, open=tuple(left), measured=hits)


def analysed(design: Design, robust: Robust) -> Design:
    """An analysis measured over the tolerances: what is said of machines that were not looked at."""
    words = "for every machine within the tolerances, proven"
    if robust.open and design.status == "met":
        words = f"over the tolerances: {robust.doubt}"
    elif design.status == "violated":
        words = "by a machine within the tolerances" + (f"; {robust.doubt}" if robust.open else "")
    machine = goal_machine(design.scene, robust.hits) if design.goal is not None else {}
    both = side_by_side(design.scene, None, robust, differing(design.scene, machine))
    return replace(design, claim=f"{design.claim}; {words}", tolerances=both)


def _corners(doubts: tuple[Uncertain, ...]) -> list[dict[str, float]]:
    if len(doubts) > _CORNERS:
        return []
    return [_named(doubts, np.array(corner)) for corner in product(*(doubt.ends for doubt in doubts))]


def _named(doubts: tuple[Uncertain, ...], factors: FloatArray) -> dict[str, float]:
    return dict(zip((doubt.path for doubt in doubts), factors.tolist(), strict=True))
