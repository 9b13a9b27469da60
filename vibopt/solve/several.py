"""The same question of several machines: every limit on those that are worst for it."""

from __future__ import annotations

from collections import Counter
from dataclasses import field, replace
from functools import partial

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.program.one_machine import model_kept
from vibopt.program.pose import asked_of
from vibopt.program.program import Aim, Axis, Limit, Program, Tie
from vibopt.program.worst_case import doubts_at
from vibopt.records import dataclass
from vibopt.scene.assemble import model_of
from vibopt.scene.scene import Scene
from vibopt.scene.uncertain import uncertain
from vibopt.solve.ranges import closed

_SAME = 1e-12


Key = tuple[str, str, int]
"""Name and side of a limit, and which of those it is: at a part that has no least rating that limit is not there."""
GOAL: Key = ("", "", -1)


def keys_of(program: Program) -> dict[int, Key]:
    """Key of each limit by its number; of the goal by -1."""
    found, seen = {-1: GOAL}, Counter[tuple[str, str]]()
    for index, limit in enumerate(program.limits):
        found[index] = (limit.name, limit.side, seen[limit.name, limit.side])
        seen[limit.name, limit.side] += 1
    return found


@dataclass
class Several:
    """Machines by what they are worst for.

    A machine is known by how far each uncertain number is off, as a part of its tolerance (n_uncertain,): of a bought
    part the tolerance is that of the row, so the same machine is off differently with another part.  Where rows have
    tolerances of their own, what each would be is one more column of the catalogue.

    worst
        Per limit (by its key; that of the goal is GOAL) the machines asked about.
    """

    scene: Scene
    worst: dict[Key, list[FloatArray]] = field(default_factory=dict)
    _columns: list[tuple[int, float]] = field(default_factory=list)
    _posed: dict[bytes, Program] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.doubts = uncertain(self.scene)
        self.wide = [i for i, doubt in enumerate(self.doubts) if doubt.printed]
        self.off_nothing = np.zeros(len(self.doubts))

    @property
    def count(self) -> int:
        """Number of machines."""
        return len({one.tobytes() for many in self.worst.values() for one in many})

    @property
    def asked(self) -> int:
        """Number of questions: limits, each with each of its machines."""
        return sum(len(many) for many in self.worst.values())

    def parts_off(self, x: FloatArray, factors: FloatArray) -> FloatArray:
        """A machine from the factors (n_uncertain,) at a design x (n_vars,)."""
        widths = np.array([uncertain.tolerance for uncertain in doubts_at(self.scene, x)])
        off = np.divide(factors - 1.0, widths, out=np.zeros(len(widths)), where=widths > 0.0)
        parts: FloatArray = np.where(np.abs(np.abs(off) - 1.0) < _SAME, np.sign(off), off)
        return parts

    def factors(self, x: FloatArray, machine: FloatArray) -> FloatArray:
        """Factors (n_uncertain,) of a machine at a design x (n_vars,)."""
        widths = np.array([uncertain.tolerance for uncertain in doubts_at(self.scene, x)])
        factors: FloatArray = 1.0 + machine * widths
        return factors

    def near(self, x: FloatArray, key: Key) -> tuple[FloatArray, ...]:
        """Factors at a design x (n_vars,) of the machines last asked about."""
        return tuple(self.factors(x, one) for one in self.worst.get(key, ())[-2:])

    def add(self, key: Key, machine: FloatArray) -> None:
        """One more machine for a limit."""
        known = self.worst.setdefault(key, [])
        if any(np.array_equal(machine, one) for one in known):
            return
        known.append(machine)
        for i in self.wide:
            if (i, machine[i]) not in self._columns:
                self._columns.append((i, float(machine[i])))
                self._posed.clear()

    def program(self) -> Program:
        """Every limit and the goal, each on its machines; behind the design variables the columns of tolerances."""
        for i in self.wide:
            if (i, 0.0) not in self._columns:
                self._columns.append((i, 0.0))
                self._posed.clear()
        nominal = self._asked(self.off_nothing)
        limits: list[Limit] = []
        aims: list[Aim] = []
        for index, key in keys_of(nominal).items():
            limits += [self._asked(one).limits[index] for one in self.worst.get(key, ()) if index >= 0]
        for one in self.worst.get(GOAL, ()):
            aim = self._asked(one).aim
            assert aim is not None
            aims += aim.pieces
        whole = replace(aims[0], others=tuple(aims[1:])) if aims else nominal.aim
        return replace(nominal, limits=tuple(limits), aim=whole, several=True)

    def _asked(self, machine: FloatArray) -> Program:
        key = machine.tobytes()
        if key not in self._posed:
            self._posed[key] = self._pose(machine)
        return self._posed[key]

    def _pose(self, machine: FloatArray) -> Program:
        off = {
            doubt.path: 1.0 + doubt.tolerance * float(part)
            for doubt, part in zip(self.doubts, machine, strict=True)
            if not doubt.printed
        }
        scene, count = replace(self.scene, off=off), len(self.scene.variables)
        free = {self.doubts[i].path for i in self.wide}
        model = model_kept(scene, free, partial(model_of, scene, free=free))
        if self.wide:
            places = [count + self._columns.index((i, float(machine[i]))) for i in self.wide]
            model = model.placed(np.array([*range(count), *places], dtype=int), count + len(self._columns))
        asked = asked_of(scene, model)
        return closed(self._with_columns(asked) if self.wide else asked)

    def _with_columns(self, program: Program) -> Program:
        """The program with one axis more for every column, tied to the part that it belongs to."""
        paths = [axis.path for axis in program.axes]
        axes, ties = list(program.axes), list(program.ties)
        for i, part in self._columns:
            printed = paths.index(self.doubts[i].printed)
            at = next(j for j, tie in enumerate(ties) if printed in tie.axes)
            values = 1.0 + part * ties[at].table[:, ties[at].axes.index(printed)]
            ties[at] = _wider(ties[at], len(axes), values)
            axes.append(Axis(f"{self.doubts[i].path} off", values.min(), values.max(), tuple(np.unique(values))))
        return replace(program, axes=tuple(axes), ties=tuple(ties))


def _wider(tie: Tie, axis: int, values: FloatArray) -> Tie:
    return replace(tie, axes=(*tie.axes, axis), table=np.column_stack([tie.table, values]))
