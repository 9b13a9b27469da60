"""What is proven of the worst machines within the tolerances: that none is worse, or at least that limits hold."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from vibopt.answer.entry import TOLERANCE
from vibopt.arrays import FloatArray
from vibopt.program.over import MARGIN, Cover
from vibopt.program.program import Aim, Axis, Limit, Program
from vibopt.program.vicinity import Vicinity
from vibopt.program.worst_case import Hit, hit, missed
from vibopt.work import Budget

_BATCHES, _QUICK_BATCHES, _OF_NOTHING = 1600, 400, 20
"""Batches of boxes for one proof, where many are asked for, and for a level of zero, which no bound reaches."""
_COST = 5.0
_TIMES = 6


def worst_machines(
    program: Program,
    known: Mapping[int, tuple[FloatArray, ...]],
    *,
    quick: bool = False,
    told: Mapping[int, Hit] | None = None,
) -> dict[int, Hit]:
    """The worst machine for every limit, and as -1 for the goal.

    `known` are factors that were worst nearby; what is `told` is not looked for.
    """
    told = told or {}
    return {
        index: told.get(index) or hit(part, program.axes, near=known.get(index, ()), quick=quick)
        for index, part in parts_of(program).items()
    }


def settled(program: Program, hits: Mapping[int, Hit]) -> tuple[dict[int, Hit], tuple[str, ...]]:
    """The worst machines, after a search that misses none, and the names of what is neither broken nor proven."""
    final, left = {}, []
    for index, part in parts_of(program).items():
        final[index], told = decided(part, program.axes, hits[index])
        if not told:
            left.append(part.name if isinstance(part, Limit) else "the goal")
    return final, tuple(dict.fromkeys(left))


def searched(program: Program) -> dict[int, Hit]:
    """The worst machines as `settled` has them, where nothing is said of what is proven: the same for less work."""
    hits, parts = worst_machines(program, {}), parts_of(program)
    return {index: raised(part, program.axes, hits[index])[0] for index, part in parts.items()}


def decided(part: Limit | Aim, axes: tuple[Axis, ...], one: Hit) -> tuple[Hit, bool]:
    """The worst machine of one part after a search that misses none, and whether it is broken or proven."""
    one, sure = raised(part, axes, one)
    broken = isinstance(part, Limit) and missed(part, one.value) > TOLERANCE
    return replace(one, sure=sure), sure or broken or _held(part, axes, one)


def breaks(part: Limit | Aim, axes: tuple[Axis, ...], near: tuple[FloatArray, ...]) -> Hit | None:
    """The worst machine for a limit, looked for only where it is not proven at once that none breaks it."""
    if isinstance(part, Limit) and part.side != "outside" and _single(part):
        proof = Vicinity(part, axes, part.bound, part.side == "at_least")
        if proof.proven(_batches(_QUICK_BATCHES)):
            return None
        near = near if proof.witness is None else (*near, proof.witness)
    return hit(part, axes, near=near)


def kept_within(limit: Limit, axes: tuple[Axis, ...]) -> bool:
    """Whether it is proven that every machine within the axes keeps a limit, with room but where a corner is worst."""
    one = hit(limit, axes)
    off = missed(limit, one.value)
    return off <= 0.0 and (one.proven or (off < -1.01 * MARGIN and _held(limit, axes, one)))


def tight(program: Program, index: int, one: Hit) -> bool:
    """Whether a proof could only be given with a margin."""
    if one.proven:
        return False
    return index < 0 or missed(program.limits[index], one.value) > -1.01 * MARGIN


def parts_of(program: Program) -> dict[int, Limit | Aim]:
    """Limits by number, and as -1 the goal."""
    parts: dict[int, Limit | Aim] = dict(enumerate(program.limits))
    if program.aim is not None:
        parts[-1] = program.aim
    return parts


def _least(part: Limit | Aim) -> bool:
    return part.least_wanted


def _pieces(part: Limit | Aim) -> tuple[Limit | Aim, ...]:
    return part.pieces if isinstance(part, Aim) else (part,)


def raised(part: Limit | Aim, axes: tuple[Axis, ...], one: Hit) -> tuple[Hit, bool]:
    """The hit, or a worse one where the proof that there is none fails on a machine; whether it is proven to MARGIN."""
    if one.proven or (one.value == np.inf and not _least(part)):
        return one, True
    if isinstance(part, Limit) and part.side == "outside":
        return one, False
    least = _least(part)
    for _ in range(_TIMES):
        level = one.value + (-MARGIN if least else MARGIN) * abs(one.value)
        proofs = [Vicinity(piece, axes, level, least) for piece in _pieces(part) if _single(piece)]
        if len(proofs) < len(_pieces(part)):
            return one, False
        lost = next((proof for proof in proofs if not proof.proven(_batches(_QUICK_BATCHES, level))), None)
        if lost is None:
            return one, True
        if lost.witness is None:
            return one, False
        again = hit(part, axes, near=(lost.witness,), quick=True)
        if (again.value >= one.value) if least else (again.value <= one.value):
            return one, False
        one = replace(again, tried=one.tried + again.tried)
    return one, False


def _batches(most: int, level: float = 1.0) -> Budget:
    return Budget(most if level else _OF_NOTHING, "batches of machines", _COST)


def _single(part: Limit | Aim) -> bool:
    return len(part.form.drives) < 2


def _held(part: Limit | Aim, axes: tuple[Axis, ...], one: Hit) -> bool:
    """Whether the bound is proven to be kept (the goal's value to be reached), to MARGIN where it is tight."""
    least, level = _least(part), one.value if isinstance(part, Aim) else part.bound
    loose = isinstance(part, Limit) and missed(part, one.value) < -1.01 * MARGIN
    if isinstance(part, Limit) and part.side == "outside":
        return Vicinity(part, axes, level, margin=0.0 if loose else MARGIN).proven(_batches(_BATCHES))
    level *= 1.0 if loose else 1.0 - MARGIN if least else 1.0 + MARGIN
    return all(_covered(piece, axes, level, least) for piece in _pieces(part))


def _covered(part: Limit | Aim, axes: tuple[Axis, ...], level: float, least: bool) -> bool:
    """Whether a level is kept on the whole box; several excitations each by themselves, the level shared out."""
    form = part.form.harmonic
    if form is None or len(form.drives) == 1:
        if Vicinity(part, axes, level, least).proven(_batches(_BATCHES, level)):
            return True
        return Cover(part, axes, level, least).proven(_batches(_BATCHES, level))
    if least:
        return False
    alone = [replace(part, form=replace(form, drives=(drive,))) for drive in form.drives]
    tops = np.array([hit(one, axes).value for one in alone])
    total = float(np.sqrt((tops**2).sum())) if form.combine == "rss" else float(tops.sum())
    if not 0.0 < total < level:
        return False
    shares = [(one, float(top) * level / total) for one, top in zip(alone, tops, strict=True)]
    return all(top > 0.0 and _covered(one, axes, top, least) for one, top in shares)
