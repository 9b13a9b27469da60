"""By how much a machine without choices misses each of its limits, over its tolerances where it has some."""

from __future__ import annotations

from dataclasses import field

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.errors import InputError
from vibopt.program.meetings import above, watched
from vibopt.program.pose import pose
from vibopt.program.program import Program
from vibopt.program.worst_case import around, hit, missed
from vibopt.records import dataclass
from vibopt.scene.read import with_changes
from vibopt.scene.scene import Scene
from vibopt.scene.uncertain import uncertain
from vibopt.solve.branch import Judge
from vibopt.values.fact_at import FactAt

LARGE = 1e9
"""Stands for an infinite violation."""
_KNOWN = 4
"""Machines that are kept as the first to look at, per limit."""


@dataclass
class Margins:
    """Violation of every limit against one fact; remembers what it has measured.

    Over tolerances each look begins at the machines that were worst before, with `refining` it takes those alone;
    `full` looks everywhere.
    """

    scene: Scene
    fact: FactAt
    programs: dict[float, Program | None] = field(default_factory=dict)
    found: dict[float, FloatArray] = field(default_factory=dict)
    worst_machines: dict[int, list[FloatArray]] = field(default_factory=dict)
    refining: bool = False

    def program(self, value: float) -> Program | None:
        """The question at a value [SI]; None where the scene cannot have it."""
        if value not in self.programs:
            try:
                changed = with_changes(self.scene, self.fact.changes(value))
            except InputError:
                self.programs[value] = None
            else:
                self.programs[value] = around(changed, np.zeros(0)) if uncertain(changed) else pose(changed)
        return self.programs[value]

    def __call__(self, value: float) -> FloatArray | None:
        """Violation of each limit as a part of its bound, shape (n_limits,), positive where broken; None as above."""
        if value not in self.found:
            program = self.program(value)
            if program is None:
                return None
            self.found[value] = np.clip(self._violations(program, full=False), -LARGE, LARGE)
        return self.found[value]

    def full(self, value: float) -> FloatArray | None:
        """The same, over tolerances from every start."""
        program = self.program(value)
        if program is not None and program.axes:
            self.found[value] = np.clip(self._violations(program, full=True), -LARGE, LARGE)
        return self(value)

    def most(self, value: float) -> float:
        """The greatest violation; that of a value that cannot be is none."""
        found = self(value)
        return -LARGE if found is None else float(found.max(initial=-LARGE))

    def name(self, value: float) -> str:
        """The limit that is broken most at a value."""
        program, found = self.program(value), self(value)
        return "" if program is None or found is None or not len(found) else program.limits[int(found.argmax())].name

    def _violations(self, program: Program, *, full: bool) -> FloatArray:
        if not program.axes:
            judge = Judge(program)
            return np.array([judge.limit(limit, np.zeros(0))[0] - judge.tolerance for limit in program.limits])
        looks = (self._look(program, index, full=full) for index in range(len(program.limits)))
        return np.array(list(looks)) - Judge.tolerance

    def _look(self, program: Program, index: int, *, full: bool) -> float:
        """Violation of one limit on the worst machine found."""
        limit, known = program.limits[index], self.worst_machines.setdefault(index, [])
        if known and not full and limit.side != "outside":
            values = [limit.worst(one).value for one in known]
            there = max(missed(limit, value) for value in values)
            if self.refining:
                return there
        one = hit(limit, program.axes, near=tuple(known), quick=not full)
        if not any(np.allclose(one.factors, other, rtol=1e-9, atol=0.0) for other in known):
            known.insert(0, one.factors)
            del known[_KNOWN:]
            self.found.clear()  # the others may be worse than they seemed
        return missed(limit, one.value)

    def above(self, value: float) -> FloatArray | None:
        """How far each free motion is above each frequency that a limit looks at, shape (n,) [rad/s]."""
        program = self.program(value)
        if program is None:
            return None
        asked = watched(program.limits)
        model, axes = program.model, len(program.axes)
        if not len(asked) or not model.n_free:
            return np.zeros(0)
        return above(model, np.ones(axes), asked)


def most_missed(scene: Scene) -> tuple[float, str]:
    """Greatest violation of a machine as a part of its bound, positive where broken, and whose it is."""
    here = Margins(scene, FactAt("", 0.0, "", "ratio"))
    here.programs[0.0] = around(scene, np.zeros(0)) if uncertain(scene) else pose(scene)
    return here.most(0.0), here.name(0.0)
