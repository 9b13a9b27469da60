"""Limits `with_probability`: whether enough of all machines keep them, from machines that are drawn."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from vibopt.answer.answer import Odds
from vibopt.answer.entry import Checked
from vibopt.arrays import FloatArray
from vibopt.program.drawn import RARE, Sampled, drawn, every_one, looks, sampled, until_told
from vibopt.program.program import Limit
from vibopt.program.told import judged_by, odds_of, row_told
from vibopt.program.worst_case import around, doubts_at
from vibopt.scene.scene import Design, Scene
from vibopt.scene.uncertain import Uncertain
from vibopt.solve.rare import proven_beyond
from vibopt.verify.checked import checked_limits
from vibopt.work import worked

DRAWN = "machines_drawn"
"""What found a design, where a limit asks for a probability."""
_PUT_BACK = 8
"""Machines nearest to a bound that are measured as built."""
_SAME = 1e-6


def with_odds(design: Design) -> Design:
    """An analysis over tolerances with what is drawn of each limit with a probability; the others stay as they are.

    Its rows show what so many of all machines stay within; the worst within the tolerances stands beside it.
    """
    rows, odds = rows_drawn(design.scene, np.zeros(0), design.limits)
    assert design.tolerances is not None
    left = tuple(name for name in design.tolerances.open if name not in odds)
    made = replace(design, limits=rows, tolerances=replace(design.tolerances, odds=odds, open=left))
    return _judged(made, odds)


def rows_drawn(
    scene: Scene, x: FloatArray, limits: Mapping[str, Checked]
) -> tuple[dict[str, Checked], dict[str, Odds]]:
    """Rows at a design x (n_vars,), those with a probability by what is drawn, and what that says of each."""
    rows, odds = dict(limits), {}
    for key, row in limits.items():
        limit = scene.limits.get(row.name)
        if limit is None or limit.with_probability is None:
            continue
        parts = [one for one in around(scene, x).limits if one.name == row.name and one.user_side == row.side]
        seen, doubt = _looked(scene, x, row, parts, limit.with_probability)
        odds[key] = odds_of(row, seen, limit.with_probability)
        rows[key] = row_told(row, seen, limit.with_probability, doubt)
    return rows, odds


def _looked(scene: Scene, x: FloatArray, row: Checked, parts: list[Limit], wanted: float) -> tuple[Sampled, str]:
    """Machines drawn until a verdict is reached or the work is done, and what the machines as built say against it."""
    assert row.limit is not None
    doubts = doubts_at(scene, x)
    cost = sum(one.cost for one in parts)
    whole = every_one(doubts, cost)
    if whole is not None:
        worked(len(whole) * cost)
        seen = replace(sampled(parts, whole, 1.0), counted=True)
        return seen, _contradicted(scene, x, row, seen, _machines(doubts, whole))
    sizes, confidence = looks(cost)
    far = proven_beyond(parts, doubts, wanted) if wanted > RARE else None
    every = far.machines(sizes[-1]) if far is not None else drawn(doubts, sizes[-1])
    part = far.part if far is not None else 1.0
    seen = until_told(lambda some: replace(sampled(parts, every[some], confidence), part=part), sizes, wanted)
    worked(len(seen.values) * cost)
    return seen, _contradicted(scene, x, row, seen, _machines(doubts, every[: len(seen.values)]))


def _machines(doubts: Sequence[Uncertain], factors: FloatArray) -> list[dict[str, float]]:
    """Factors (n, n_doubts) of each machine, by path."""
    names = [doubt.path for doubt in doubts]
    return [dict(zip(names, row, strict=True)) for row in factors.tolist()]


def _contradicted(scene: Scene, x: FloatArray, row: Checked, seen: Sampled, machines: list[dict[str, float]]) -> str:
    """What the machines nearest to the bound, measured as built, say against their values; "" where nothing."""
    assert row.limit is not None
    chosen = scene.named(x)
    near = np.argsort(np.abs(seen.values - row.limit.value), kind="stable")[:_PUT_BACK]
    for k in {*near.tolist(), int(seen.values.argmin()), int(seen.values.argmax())}:
        rows = checked_limits(replace(scene, off=machines[k]), chosen).values()
        built = next(one for one in rows if (one.name, one.side) == (row.name, row.side))
        value, other = built.value.value, float(seen.values[k])
        if abs(value - other) > _SAME * max(abs(value), abs(other)) and value != other:
            return f"{row.name} is {other:.9g} in the model of a machine that was drawn, {value:.9g} on it as built"
    return ""


def _judged(design: Design, odds: Mapping[str, Odds]) -> Design:
    """Status and claim by the verdicts."""
    if design.status == "check_failed":
        return design
    doubts = [row.doubt for row in design.limits.values() if row.doubt]
    if doubts:
        return replace(design, status="check_failed", claim=doubts[0])
    rest = "; the other limits over all machines within the tolerances" if len(odds) < len(design.limits) else ""
    status, claim = judged_by(design.limits, odds, rest)
    return replace(design, status=status, claim=claim)
