"""How far each variable of a machine may go over all permitted designs, and by how much designs miss its limits."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from vibopt.answer.entry import Entry
from vibopt.arrays import FloatArray
from vibopt.errors import InputError
from vibopt.forms import Monomials
from vibopt.program.program import Aim, Program
from vibopt.records import dataclass
from vibopt.scene.scene import Scene
from vibopt.solve.branch import Judge
from vibopt.solve.closed_peaks import worst
from vibopt.solve.closed_program import NotClosedError, question, value_at
from vibopt.solve.dispatch import best_of
from vibopt.solve.least_missed import slid
from vibopt.solve.method import Progress
from vibopt.solve.one_range import permitted
from vibopt.verify.checked import checked_limits

BETWEEN = "A value between them may be forbidden, whatever the others are"
"""What least and greatest of several variables leave open."""
_TRIED_INSIDE = 24
"""Values between the ends of each of two variables that are tried."""
_SPREAD = 6
"""Values of the other variable from which a permitted design is sought where none is near."""
_GAP = 1e-6
"""Part by which a gap is one."""


@dataclass(frozen=True, slots=True)
class Span:
    """How far a variable may go while the others move as it needs.

    intervals
        From and to; where one variable is all there is, every interval, of two every one that `tried` values tell.  Of
        more the least and the greatest value; one between them may be forbidden, whatever the others are.
    proven
        Whether the ends are: beyond them no design is permitted.
    opened
        Whether it goes on beyond the last end without end.
    tried
        How many values between the ends were tried, each gap that one fell into known by its ends; 0 where none was.
    """

    path: str
    intervals: tuple[tuple[Entry, Entry], ...]
    proven: bool
    opened: bool = False
    tried: int = 0


def no_design(name: str, words: str) -> InputError:
    """That there is no design to tell a window of."""
    return InputError(f"{name}: there is no permitted design ({words}). vibopt explain says which limits clash.")


def _only(scene: Scene, program: Program) -> tuple[Span, ...]:
    """Of one variable all intervals."""
    (variable,) = scene.variables
    found = permitted(program)
    if not found.intervals:
        raise no_design(scene.name, "proven" if found.complete else "none was found")
    ends = tuple(
        (Entry(low, variable.dimension, variable.unit), Entry(high, variable.dimension, variable.unit))
        for low, high in found.intervals
    )
    opened = program.axes[0].open_high and found.intervals[-1][1] >= 0.999 * program.axes[0].high
    sound = all(row.met for low, high in found.intervals for x in (low, high) for row in _rows(scene, np.array([x])))
    return (Span(variable.path, ends, found.complete and sound, opened),)


def spans_of(scene: Scene, program: Program, progress: Progress | None, designs: list[FloatArray]) -> tuple[Span, ...]:
    """How far each variable may go over all permitted designs.

    Of one variable every interval; of two every interval between gaps that were met by some values inside; of more the
    least and the greatest value.  The designs at the ends (n_vars,) are put into `designs`.
    """
    if len(program.axes) == 1:
        return _only(scene, program)
    whole = []
    for index in range(len(program.axes)):
        if progress is not None:
            progress("window", 0.5 * index / len(program.axes))
        whole.append(_Whole(scene, program, index, designs))
    return tuple(one.span() for one in whole)


class _Whole:
    """One variable, while the others move as it needs: each end is a program of its own, begun at those before."""

    def __init__(self, scene: Scene, program: Program, index: int, designs: list[FloatArray]) -> None:
        self.scene, self.program, self.index, self.designs = scene, program, index, designs
        self.proven, self.opened = True, False
        self.low, self.high = self.end(program, 1.0), self.end(program, -1.0)

    def end(self, program: Program, sense: float) -> float:
        """The least value (`sense` 1) or the greatest (-1) within the ranges of a program."""
        scene, index, variable = self.scene, self.index, self.scene.variables[self.index]
        row = np.zeros((1, len(program.axes)))
        row[0, index] = 1.0
        aimed = program.aiming(Aim(variable.path, program.model, Monomials(np.ones(1), row), sense))
        begin = self.designs[-1].tolist() if self.designs else None
        found, _ = best_of(aimed, scene, None, None, begin)
        if found.x is None and found.status != "unbounded":
            raise no_design(scene.name, "proven" if found.status == "infeasible" else "none was found")
        self.opened |= found.status == "unbounded"
        self.designs += [] if found.x is None else [found.x]
        sound = found.x is None or all(one.met for one in _rows(scene, found.x))
        self.proven &= found.status in ("optimal", "unbounded") and sound
        return program.axes[index].high if found.x is None else float(found.x[index])

    def span(self) -> Span:
        """With every gap that some values between the ends fall into."""
        variable, tried = self.scene.variables[self.index], 0
        ends = [self.low]
        if len(self.program.axes) == 2 and 0.0 < self.low < self.high:
            tried = _TRIED_INSIDE
            for gap in self._gaps(between(self.low, self.high, tried)):
                ends += gap
        ends.append(self.high)
        entries = [Entry(end, variable.dimension, variable.unit) for end in ends]
        intervals = tuple(zip(entries[::2], entries[1::2], strict=True))
        return Span(variable.path, intervals, self.proven, self.opened, tried)

    def _gaps(self, values: FloatArray) -> Iterator[tuple[float, float]]:
        """Rising; each from the greatest permitted value below one that is not to the least above it."""
        beyond, x = self.low, self.designs[0]
        for value in values:
            if value <= beyond:
                continue
            there = self._held(float(value), x)
            if there is not None:
                x = there
                continue
            try:
                below, above = (
                    self.end(self._within(self.low, value), -1.0),
                    self.end(self._within(value, self.high), 1.0),
                )
            except InputError:  # nothing was found on one side, where something is: no end that could be told
                self.proven = False
                continue
            beyond, x = above, self.designs[-1]
            if above > below * (1.0 + _GAP):
                yield below, above

    def _within(self, low: float, high: float) -> Program:
        """The program with a part of the range."""
        axes = list(self.program.axes)
        axes[self.index] = replace(axes[self.index], low=float(low), high=float(high), open_low=False, open_high=False)
        return replace(self.program, axes=tuple(axes))

    def _held(self, value: float, begin: FloatArray) -> FloatArray | None:
        """A permitted design with this value: by slopes from others; None where they lead to none."""
        program, other = self._within(value, value), 1 - self.index
        starts = [begin, *self.designs]
        for start in (*starts, *_places(program, other, begin)):
            x = np.array(start, dtype=float)
            x[self.index] = value
            there, missed = slid(program, x)
            if missed <= 0.0 and all(row.met for row in _rows(self.scene, there)):
                return there
        return None


def _places(program: Program, index: int, x: FloatArray) -> Iterator[FloatArray]:
    """The design with some values of one variable, all over its range."""
    axis = program.axes[index]
    for one in between(max(axis.low, axis.high * 1e-9), axis.high, _SPREAD):
        made = np.array(x, dtype=float)
        made[index] = one
        yield made


def _rows(scene: Scene, x: FloatArray) -> list[Any]:
    return list(checked_limits(scene, scene.named(x)).values())


class Violations:
    """How far limits are missed at many designs, as parts of their bounds: at once where there are closed forms."""

    def __init__(self, program: Program) -> None:
        self.judge, self.limits = Judge(program), list(program.limits)
        try:
            asked = question(program)
            self.asked = None if any(row.tabled is not None for row in asked.rows) else asked
        except NotClosedError:
            self.asked = None

    def __call__(self, index: int, x: FloatArray) -> FloatArray:
        """Of one limit at designs x (n, n_vars), shape (n,)."""
        if self.asked is None:
            return np.array([self.judge.limit(self.limits[index], one)[0] for one in x])
        design = x.T[list(self.asked.order)]
        kind, numbers = self.asked.rows[index], self.asked.numbers
        with np.errstate(all="ignore"):
            if kind.kind == "harmonic":
                return worst(self.asked, numbers, index, design)[0]
            value, _ = value_at(self.asked, numbers, index, design, 0.0)
            bound = numbers[f"{index}.bound"]
            return np.asarray(kind.sign * (value - bound) / bound)

    def most(self, x: FloatArray) -> FloatArray:
        """The greatest of all limits at designs x (n, n_vars), shape (n,)."""
        if self.asked is None:
            self.judge.ahead(x)
        every = [self(index, x) for index in range(len(self.limits))]
        return np.asarray(np.max(every, axis=0, initial=-np.inf))


def between(low: float, high: float, count: int) -> FloatArray:
    """Places inside of an interval, by ratios where it is wide."""
    spaced = np.geomspace if low > 0.0 and high > 3.0 * low else np.linspace
    return np.asarray(spaced(low, high, count + 2)[1:-1])
