"""All values of one design variable at which every limit holds, and the machine measured at their ends."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from vibopt.answer.entry import Checked, Entry
from vibopt.program.program import Program
from vibopt.records import dataclass
from vibopt.report.machine_notes import notes_of, static_shapes
from vibopt.scene.scene import Design, Scene
from vibopt.solve.one_range import Permitted, permitted
from vibopt.solve.spared import NONE_WITH, known_to, spared, widened
from vibopt.verify.checked import Built, disagreement, unsteady

_SHAPES = " for beams in their static shape, the model in the note below"
_NUMBER = re.compile(r"\d[\d.e+-]*")
_NEAR = 1e-6
"""Part of a bound within which the limit that ends an interval must be met as measured."""
_BESIDE, _STEEP, _LEAPS = (1e-9, 1e-8, 1e-7, 1e-6, 1e-5), 1e-8, 1e-3
"""Parts of a value by which one goes inward where a limit is steep, whose place two routes know to less than its last
digits; the most of them where it does not leap; part of its bound by which it leaps at least."""

Rows = Mapping[str, Checked]


@dataclass(frozen=True, slots=True)
class End:
    """One end of an interval: the value, the limit that ends it ("" for the range), and what is measured there.

    leaps, between
        Whether that limit leaps there, and whether it holds on this side of the end and not on the other; the value is
        then one just inside.
    spared
        Part of its bound that the limit is kept with to spare.
    """

    value: Entry
    ended_by: str
    rows: Rows
    leaps: bool = False
    between: bool = False
    spared: float = 0.0

    @property
    def as_found(self) -> bool:
        """Whether every limit holds as measured, and one side of the limit that ends it just so."""
        held, near = _margins(self.rows, self.ended_by), max(_NEAR, 2.0 * self.spared)
        return _good(self.rows) and (self.between or not held or min(map(abs, held)) <= near)


def permitted_values(scene: Scene, program: Program) -> Design:
    """The answer to `find_all` of the one variable.

    Found on the model, and measured on the machine as built at each end, inside and outside of each interval.
    """
    (variable,) = scene.variables
    found = permitted(program)

    def measured(value: float) -> Rows:
        built = Built(scene, {variable.path: value}, program.model)
        return {**built.limits({}), **built.measures({})}

    def end(value: float, name: str, inward: float) -> End:
        at = End(Entry(value, variable.dimension, variable.unit), name, measured(value), spared=known_to(program))
        for part in _BESIDE if name and found.complete and not at.as_found else ():
            inside = value * (1.0 + inward * part)
            rows, beyond = measured(inside), min(_margins(measured(value * (1.0 - inward * part)), name))
            leaps = min(_margins(rows, name)) - beyond > _LEAPS
            if _good(rows) and not disagreement(rows) and beyond < 0.0 and (leaps or part <= _STEEP):
                there = Entry(inside, variable.dimension, variable.unit)
                return replace(at, value=there, rows=rows, leaps=leaps, between=True)
        return at

    intervals = tuple(
        (end(low, below, 1.0), end(high, above, -1.0))
        for (low, high), (below, above) in zip(found.intervals, found.ends, strict=True)
    )
    ends = [one for two in intervals for one in two]
    tried = _between(found, variable.low, variable.high) if found.complete else ()
    wrong = [(Entry(value, variable.dimension, variable.unit).shown, rows)
             for value, good in tried if _good(rows := measured(value)) != good]  # fmt: skip
    wrong += [(one.value.shown, one.rows) for one in ends if found.complete and not one.as_found]
    looked = [*(one.rows for one in ends), *(rows for _, rows in wrong)]
    grown = unsteady(*looked)
    there = ", ".join(shown for shown, _ in wrong)
    alone = [f"the limits hold on one of model and machine as built alone at {there}"] if wrong and not grown else []
    doubt = disagreement(*looked if grown else (one.rows for one in ends), besides=alone)
    near = any(static_shapes(scene, {variable.path: one.value.value}) for one in ends)
    claim, complete = _claim(program, found, variable.path, any(one.leaps for one in ends), _SHAPES if near else "")
    proven, unsettled = ("met", "feasible") if intervals else ("infeasible", "unproven")
    notes = [(one.value.shown, note) for one in ends for note in notes_of(scene, {variable.path: one.value.value})]
    return Design(
        job=scene,
        status="unproven"
        if doubt and doubt == grown
        else "check_failed"
        if doubt
        else proven
        if complete
        else unsettled,
        claim=doubt or claim,
        method="one_range",
        found=None if doubt else tuple((low.value, high.value) for low, high in intervals),
        details={} if doubt else {"ends": intervals},
        notes=_said_once(notes),
    )


def _said_once(notes: Sequence[tuple[str, str]]) -> tuple[str, ...]:
    """The notes of all ends, those that differ by numbers alone with the first end of which they are said."""
    alike: dict[str, list[tuple[str, str]]] = {}
    for place, note in notes:
        alike.setdefault(_NUMBER.sub("", note.partition(". ")[0]), []).append((place, note))
    return tuple(
        one[0][1] if len({note for _, note in one}) == 1 else f"At {one[0][0]}, {one[0][1]}" for one in alike.values()
    )


def _claim(program: Program, found: Permitted, path: str, leaps: bool, model: str) -> tuple[str, bool]:
    """How the set was found, and whether it is proven."""
    if not found.complete:
        return f"the limits were followed over the range of {path}, but part of it was not settled", False
    exact = f"keeps its limit with up to {room} to spare" if (room := spared(program)) else "is exact"
    claim = f"every limit was followed over the whole range of {path}, and each end {exact}{model}"
    if room and not found.intervals and permitted(widened(program)).intervals:
        return NONE_WITH.format(part=room), False
    claim += ", or just inside of one where a limit leaps" if leaps else ""
    return (f"{claim}; {program.doubts}", False) if program.doubts else (claim, True)


def _margins(rows: Rows, name: str) -> list[float]:
    """Of a limit, on each of its sides."""
    return [row.margin for row in rows.values() if row.name == name and row.side]


def _good(rows: Rows) -> bool:
    return all(row.met for row in rows.values())


def _between(permitted: Permitted, low: float, high: float) -> Iterator[tuple[float, bool]]:
    """A value inside each interval and each gap [SI], and whether all limits must hold there."""
    for inside in permitted.intervals:
        yield 0.5 * sum(inside), True
    cuts = [low, *(value for two in permitted.intervals for value in two), high]
    for before, after in zip(cuts[::2], cuts[1::2], strict=True):
        if after > before:
            yield 0.5 * (before + after), False
