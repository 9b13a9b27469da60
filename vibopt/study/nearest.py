"""Where no design meets every limit, or none was found: the one that misses least, and what each limit could be."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vibopt.answer.answer import Least, Nearest
from vibopt.answer.entry import Checked
from vibopt.arrays import FloatArray
from vibopt.program.pose import pose
from vibopt.program.program import Aim, Program
from vibopt.program.worst_case import around
from vibopt.scene.open_places import open_places, open_positions
from vibopt.scene.scene import Design, Scene
from vibopt.scene.uncertain import likely, uncertain
from vibopt.solve.choose import modest
from vibopt.solve.deviations import limits_over
from vibopt.solve.least_missed import nearest_to
from vibopt.solve.loosen import beside, left_out
from vibopt.solve.proof import searched
from vibopt.solve.ranges import closed
from vibopt.solve.robust import judged
from vibopt.solve.several import Several, keys_of
from vibopt.solve.without_search import moot_goal
from vibopt.values.soft import softness
from vibopt.verify.checked import checked_limits, chosen_of, disagreement
from vibopt.verify.rated import parts_of
from vibopt.work import late, metered

PATIENCE = 2_000.0
"""Work [nominal ms] after which the limits that are left are named as not looked at."""
_ROUNDS = 4
_CLEAR = 1e-6
"""Part of every bound that is left over where a proof that there is no design is plainly wrong."""


def with_nearest(design: Design, *, thorough: bool = False) -> Design:
    """The same answer with the nearest design, where it has none of its own; others as they are.

    Parameters
    ----------
    design
        Of status "infeasible" or "unproven"; not where a limit asks for a probability.
    thorough
        Whatever the work; without it limits that are left are named.
    """
    scene = design.scene
    refused = design.status not in ("infeasible", "unproven") or bool(design.x) or design.nearest is not None
    refused = refused or likely(scene)
    if refused or not scene.variables or not scene.limits or open_places(scene) or open_positions(scene):
        return design
    program = closed(pose(scene))
    known = design.details.get("nearest")  # by a catalogue, deviations behind the variables
    most = beside(scene, np.inf if thorough else PATIENCE)
    with metered() as meter:
        x = np.array(known["x"])[: len(scene.variables)] if isinstance(known, dict) else nearest_to(program)
        if uncertain(scene) and not program.ties:
            x = _over_tolerances(scene, program, x)
        rows = _rows(scene, program, x)
        least: dict[str, Least] = {}
        left: list[str] = []
        for key, row in rows.items():
            if row.side == "outside":
                continue
            if meter.done > most or late("the search for the least of each limit"):
                left.append(key)
            elif (one := _least(scene, program, row)) is not None:
                least[key] = one
    if design.status == "infeasible" and all(one.margin > _CLEAR for one in rows.values()) and not uncertain(scene):
        claim = f"{design.method} claims that there is no design, but one meets every limit on the built machine"
        return replace(design, status="check_failed", claim=claim, conflict=None)
    if not uncertain(scene) and any(one.doubt for one in rows.values()):  # what is claimed is of another machine
        return replace(design, status="check_failed", claim=disagreement(rows), conflict=None)
    chosen = scene.named(x)
    found = Nearest(
        variables={variable.path: chosen_of(variable, chosen[variable.path]) for variable in scene.variables},
        places=parts_of(scene, chosen),
        x=tuple(float(one) for one in x),
        limits=rows,
        least=least,
        left=tuple(left),
        soft=softness(scene.limits),
    )
    note = f"The least of {', '.join(left)} was not looked for: {left_out(scene)}"
    return replace(design, nearest=found, notes=(*design.notes, *([note] if left else [])))


def _rows(scene: Scene, program: Program, x: FloatArray) -> dict[str, Checked]:
    """Every limit on the machine as built, the worst within its tolerances."""
    if uncertain(scene):
        return limits_over(scene, x, judged(scene, x))
    return checked_limits(scene, scene.named(x), model=program.model)


def _least(scene: Scene, program: Program, row: Checked) -> Least | None:
    """What a limit could be if there were no other, measured on the machine as built; None where nothing was found."""
    own = [limit for limit in program.limits if limit.name == row.name and limit.user_side == row.side]
    if not own:
        return None
    sense = 1.0 if own[0].side == "at_most" else -1.0
    aims = [Aim(limit.name, limit.model, limit.form, sense, limit.complement) for limit in own]
    alone = replace(program, limits=(), aim=replace(aims[0], others=tuple(aims[1:])))
    if moot_goal(alone):  # it is as it is, whatever the design
        return Least(row.value, True, row.met)
    best = modest(alone).solve(alone)
    if best.x is None or best.status not in ("optimal", "feasible"):
        return None
    rows = checked_limits(scene, scene.named(np.asarray(best.x)), model=program.model)
    same = next(one for one in rows.values() if (one.name, one.side) == (row.name, row.side))
    opened = any(axis.open_high or axis.open_low for axis in program.axes)
    value = same.value
    if row.name not in scene.limits and same.limit is not None:  # a rating is that of each part
        value = replace(value, text=f"{value.shown} of {same.limit.shown}")
    return Least(value, best.status == "optimal" and not opened, same.met)


def _over_tolerances(scene: Scene, program: Program, x: FloatArray) -> FloatArray:
    """The nearest over the worst machines found, machine after machine; x (n_vars,) is the one without tolerances."""
    machines = Several(scene)
    for _ in range(_ROUNDS):
        hits, known = searched(around(scene, x)), machines.asked
        for index, key in keys_of(program).items():
            if index in hits and index >= 0:
                machines.add(key, machines.parts_off(x, hits[index].factors))
        if machines.asked == known or late("the search for the nearest design"):
            break
        x = nearest_to(machines.program(), (x,))
    return x
