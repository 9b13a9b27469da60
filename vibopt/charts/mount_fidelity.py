"""Machines on mounts of a catalogue in the charts; the same question with one, three and six coordinates."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from vibopt.arrays import FloatArray, IntArray
from vibopt.charts.fidelity import Fidelity, seconds
from vibopt.charts.mount_cases import Asked, asked, families, machine_on, stock
from vibopt.charts.mount_machine import LINE, PLANE, SPACE, Machine, Shelf, drawn
from vibopt.charts.mount_rivals import HARD_METHODS, METHODS, Method, judged_parts
from vibopt.charts.mount_truth import every_choice, floor_force, loads, peaks
from vibopt.charts.trial import Table
from vibopt.forms.reduce import reason
from vibopt.program.pose import pose
from vibopt.program.program import Program
from vibopt.solve.branch import Judge
from vibopt.solve.catalogue.parts import Catalogue
from vibopt.solve.ranges import closed

_SLOWER = ("sampled 20", "sampled 500", "sampled 2000", "highs exchange")
AUTOMATIC = "as vibopt chooses"
_WORDS = {LINE: "one coordinate", PLANE: "three coordinates"}
_PARTS, _CHOICES = 20, 12
_CORNERS = tuple(tuple((x, y, 0.0) for y in (0.5, -0.5)) for x in (0.8, -0.8))


def speed(*, quick: bool) -> Table:
    """Time against excess price over the proven best, on random shelves."""
    left = ("steel springs in space", "three groups", "200 parts", f"methods {', '.join(_SLOWER)}")
    return replace(table_of(stock(quick=quick), methods(quick=quick), 2), left=left if quick else ())


def hard(*, quick: bool) -> Table:
    """Like modes, mounts in a line, no inertia, uplift, free motions, no damping, wide ratios, no part that will do."""
    left = ("further degrees of modes alike and apart, of no inertia, of ratios of stiffness",)
    return replace(table_of(families(quick=quick), HARD_METHODS, 1), left=left if quick else ())


def methods(*, quick: bool) -> dict[str, Method]:
    """All of them, or with `quick` those that look at few speeds or at none, and end soon."""
    return {name: method for name, method in METHODS.items() if not quick or name not in _SLOWER}


def table_of(cases: Sequence[Asked], methods: dict[str, Method], runs: int) -> Table:
    """Machines and their shelves given to these methods."""
    warm = asked(*machine_on("space", 6, 2, 3, False))
    return Table([(case.case, case) for case in cases], methods, judged_parts, runs, [(warm.case, warm)])


def fidelity(*, quick: bool) -> list[tuple[str, Callable[[], Sequence[Fidelity]]]]:
    """Three machines by three models each; every value is compared with six coordinates in plain numpy."""
    runs = 1 if quick else 5
    return [(machine.title, partial(_rows, machine, shelf, runs)) for machine, shelf in machines()]


def machines() -> list[tuple[Machine, Shelf]]:
    """Force over the centre of mass, force and centre off along x, and off along x and y."""
    places = {
        "symmetric": ((0.0, 0.0, 0.3), (0.0, 0.0, 0.5)),
        "offset": ((0.15, 0.0, 0.3), (0.4, 0.0, 0.5)),
        "skew": ((0.15, 0.1, 0.3), (0.4, 0.25, 0.5)),
    }
    found = []
    for name, (centre, at) in places.items():
        shelf = drawn(11, _PARTS, 1500.0, 9000.0)
        bare = Machine(name, 1000.0, centre, (150.0, 320.0, 350.0), _CORNERS, 2000.0, at)
        # one kind of part for all mounts of a symmetric machine: two kinds would make it turn
        alike = replace(bare, groups=(_CORNERS[0] + _CORNERS[1],)) if name == "symmetric" else bare
        found.append((_limited(alike, shelf), shelf))
    return found


def _limited(machine: Machine, shelf: Shelf) -> Machine:
    """Limits a little above what the softest but three of the choices does that carry the load."""
    chosen = every_choice(machine, shelf)
    _, _, static = machine.matrices(shelf, chosen)
    values = truth(machine, shelf, chosen[loads(machine, shelf, chosen, static) <= 0.0])
    floor, sway = 1.02 * values[np.argsort(values[:, 0])[3]]
    return replace(machine, floor=float(floor), sway=float(sway))


def _rows(machine: Machine, shelf: Shelf, runs: int) -> list[Fidelity]:
    """With the coordinates that vibopt chooses, with one, and with three."""
    with TemporaryDirectory() as folder:
        return _rows_in(machine, shelf, Path(folder), runs)


def _rows_in(machine: Machine, shelf: Shelf, folder: Path, runs: int) -> list[Fidelity]:
    scene = machine.scene(folder, shelf)
    small, full = closed(pose(scene)), closed(pose(scene, reduce=False))
    whole = _Side(full, runs)
    chosen = np.random.default_rng(13).integers(0, _PARTS, (_CHOICES, len(machine.groups)))
    true = truth(machine, shelf, chosen)
    own = _Side(small, runs)
    used = max(
        limit.model.n_free for limit in own.limits
    )  # the static loads are asked of the whole machine in any case
    rows = [_row(f"{machine.title}, {AUTOMATIC}", used, reason(full.model.n_free, used), own, whole, chosen, true)]
    for motion, words in _WORDS.items():
        less = closed(pose(replace(machine, motion=motion).scene(folder, shelf), reduce=False))
        side = _Side(less, runs)
        rows.append(_row(f"{machine.title}, {words}", less.model.n_free, "chosen by hand", side, whole, chosen, true))
    return rows


def truth(machine: Machine, shelf: Shelf, chosen: IntArray) -> FloatArray:
    """Force into the floor and peak of the sway of every choice, six coordinates, (n_choices, 2)."""
    mass, dynamic, _ = replace(machine, motion=SPACE).matrices(shelf, chosen)
    own = replace(machine, motion=SPACE)
    return np.stack([floor_force(own, mass, dynamic), peaks(own, mass, dynamic)], axis=1)


class _Side:
    """One model: time to measure a choice and to find the best, and its goal."""

    def __init__(self, program: Program, runs: int) -> None:
        self.program, self.judge = program, Judge(program)
        self.limits = [next(limit for limit in program.limits if limit.name == name) for name in ("floor", "sway")]
        x = self.design(np.zeros(len(program.ties), dtype=int))
        self.measuring = seconds(lambda: [self.judge.limit(limit, x) for limit in self.limits], 4 * runs)[0]
        self.solving, first = seconds(lambda: Catalogue().solve(program), runs)
        best = first.x
        self.goal = math.nan if best is None else self.judge.goal(best).value

    def design(self, parts: IntArray) -> FloatArray:
        """Variables of a choice, (n_vars,)."""
        x = np.zeros(len(self.program.axes))
        for tie, part in zip(self.program.ties, parts, strict=True):
            x[list(tie.axes)] = tie.table[part]
        return x

    def values(self, chosen: IntArray) -> FloatArray:
        """Both limits of every choice, (n_choices, 2)."""
        designs = [self.design(parts) for parts in chosen]
        return np.array([[self.judge.limit(limit, x)[1].value for limit in self.limits] for x in designs])


def _row(case: str, used: int, why: str, side: _Side, whole: _Side, chosen: IntArray, true: FloatArray) -> Fidelity:
    return Fidelity(
        case=case,
        declared=whole.program.model.n_free,
        used=used,
        why=why,
        measuring=side.measuring,
        measuring_full=whole.measuring,
        solving=side.solving,
        solving_full=whole.solving,
        value_error=float(np.abs(side.values(chosen) / true - 1.0).max()),
        goal_error=abs(side.goal - whole.goal) / whole.goal,
    )
