"""All values of one design variable at which every limit holds, and the machine measured at their ends."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from vibopt.answer.entry import Checked, Entry
from vibopt.program.program import Program
from vibopt.records import dataclass
from vibopt.scene.scene import Scene
from vibopt.solve.one_range import Permitted, permitted
from vibopt.verify.checked import checked_limits, checked_measures

_NEAR = 1e-6
"""Part of a bound within which the limit that ends an interval must be met as measured."""

Rows = Mapping[str, Checked]


@dataclass(frozen=True, slots=True)
class End:
    """One end of an interval: the value, the limit that ends it ("" for the range), and what is measured there."""

    value: Entry
    ended_by: str
    rows: Rows


@dataclass(frozen=True, slots=True)
class Values:
    """Intervals by their ends, how they were found, and where the machine as built says otherwise ("" nowhere)."""

    intervals: tuple[tuple[End, End], ...]
    claim: str
    doubt: str
    complete: bool


def permitted_values(scene: Scene, program: Program) -> Values:
    """Found on the model, and measured on the machine as built at each end, inside and outside of each interval."""
    (variable,) = scene.variables
    found = permitted(program)

    def measured(value: float) -> Rows:
        chosen = {variable.path: value}
        limits = checked_limits(scene, chosen, model=program.model)
        return {**limits, **checked_measures(scene, chosen, model=program.model)}

    def end(value: float, name: str) -> End:
        return End(Entry(value, variable.dimension, variable.unit), name, measured(value))

    intervals = tuple(
        (end(low, below), end(high, above))
        for (low, high), (below, above) in zip(found.intervals, found.ends, strict=True)
    )
    searched = sorted({one.form.searched for one in program.limits} - {""})
    claim = f"every limit was followed over the whole range of {variable.path}, and each end is exact"
    if not found.complete:
        claim = f"the limits were followed over the range of {variable.path}, but part of it was not settled"
    elif searched:
        claim = f"{claim}; {', '.join(searched)} and not proven"
    tried = _between(found, variable.low, variable.high)
    wrong = [f"{value:.10g}" for value, good in tried if all(one.met for one in measured(value).values()) != good]
    wrong += [one.value.shown for two in intervals for one in two if not _as_found(one)]
    doubts = [row.doubt for two in intervals for one in two for row in one.rows.values() if row.doubt]
    if wrong and found.complete:
        doubts.append(f"the limits hold on one of model and machine as built alone at {', '.join(wrong)}")
    return Values(intervals, claim, "; ".join(dict.fromkeys(doubts)), found.complete and not searched)


def _between(found: Permitted, low: float, high: float) -> Iterator[tuple[float, bool]]:
    """A value inside each interval and each gap [SI], and whether all limits must hold there."""
    for inside in found.intervals:
        yield 0.5 * sum(inside), True
    cuts = [low, *(one for two in found.intervals for one in two), high]
    for before, after in zip(cuts[::2], cuts[1::2], strict=True):
        if after > before:
            yield 0.5 * (before + after), False


def _as_found(end: End) -> bool:
    """Whether every limit holds at an end, and the one that ends it just so."""
    held = end.rows.get(end.ended_by)
    return all(one.met for one in end.rows.values()) and (held is None or abs(held.margin) <= _NEAR)
