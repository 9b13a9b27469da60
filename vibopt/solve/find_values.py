"""All values of one design variable at which every limit holds, and the machine measured at their ends."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from vibopt.answer.entry import Checked, Entry
from vibopt.program.program import Program
from vibopt.records import dataclass
from vibopt.report.machine_notes import notes_of
from vibopt.scene.scene import Design, Scene
from vibopt.solve.one_range import Permitted, permitted
from vibopt.verify.checked import Built, disagreement

_NEAR = 1e-6
"""Part of a bound within which the limit that ends an interval must be met as measured."""

Rows = Mapping[str, Checked]


@dataclass(frozen=True, slots=True)
class End:
    """One end of an interval: the value, the limit that ends it ("" for the range), and what is measured there."""

    value: Entry
    ended_by: str
    rows: Rows

    @property
    def as_found(self) -> bool:
        """Whether every limit holds as measured, and one side of the limit that ends it just so."""
        held = [row.margin for row in self.rows.values() if row.name == self.ended_by and row.side]
        return _good(self.rows) and (not held or min(map(abs, held)) <= _NEAR)


def permitted_values(scene: Scene, program: Program) -> Design:
    """The answer to `find_all` of the one variable.

    Found on the model, and measured on the machine as built at each end, inside and outside of each interval.
    """
    (variable,) = scene.variables
    found = permitted(program)

    def measured(value: float) -> Rows:
        built = Built(scene, {variable.path: value}, program.model)
        return {**built.limits({}), **built.measures({})}

    def end(value: float, name: str) -> End:
        return End(Entry(value, variable.dimension, variable.unit), name, measured(value))

    intervals = tuple(
        (end(low, below), end(high, above))
        for (low, high), (below, above) in zip(found.intervals, found.ends, strict=True)
    )
    ends = [one for two in intervals for one in two]
    tried = _between(found, variable.low, variable.high) if found.complete else ()
    wrong = [Entry(value, variable.dimension, variable.unit).shown for value, good in tried
             if _good(measured(value)) != good]  # fmt: skip
    wrong += [one.value.shown for one in ends if found.complete and not one.as_found]
    alone = [f"the limits hold on one of model and machine as built alone at {', '.join(wrong)}"] if wrong else []
    doubt = disagreement(*(one.rows for one in ends), besides=alone)
    claim, complete = _claim(program, found, variable.path)
    proven, unsettled = ("met", "feasible") if intervals else ("infeasible", "unproven")
    notes = [note for one in ends for note in notes_of(scene, {variable.path: one.value.value})]
    return Design(
        job=scene,
        status="check_failed" if doubt else proven if complete else unsettled,
        claim=doubt or claim,
        method="one_range",
        found=None if doubt else tuple((low.value, high.value) for low, high in intervals),
        details={} if doubt else {"ends": intervals},
        notes=tuple({note.partition(". ")[0]: note for note in reversed(notes)}.values())[::-1],
    )


def _claim(program: Program, found: Permitted, path: str) -> tuple[str, bool]:
    """How the set was found, and whether it is proven."""
    if not found.complete:
        return f"the limits were followed over the range of {path}, but part of it was not settled", False
    claim = f"every limit was followed over the whole range of {path}, and each end is exact"
    searched = sorted({limit.form.searched for limit in program.limits} - {""})
    return (f"{claim}; {', '.join(searched)} and not proven", False) if searched else (claim, True)


def _good(rows: Rows) -> bool:
    return all(row.met for row in rows.values())


def _between(found: Permitted, low: float, high: float) -> Iterator[tuple[float, bool]]:
    """A value inside each interval and each gap [SI], and whether all limits must hold there."""
    for inside in found.intervals:
        yield 0.5 * sum(inside), True
    cuts = [low, *(one for two in found.intervals for one in two), high]
    for before, after in zip(cuts[::2], cuts[1::2], strict=True):
        if after > before:
            yield 0.5 * (before + after), False
