"""Which method answers a program."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from vibopt.errors import InputError
from vibopt.program.program import Program
from vibopt.solve.closed_form import StiffnessAndDamping
from vibopt.solve.method import Method
from vibopt.solve.outer import OneVariable

if TYPE_CHECKING:
    from vibopt.solve.nlp import Nlp

_UNBOUNDED_BOXES = 20_000
"""Boxes of a search that cannot prove anything, because a limit has no bound on boxes."""
MODEST_GAP, _MODEST_BOXES, _MODEST_TANGENTS, _MODEST_MEASUREMENTS, _MODEST_PIECES = 1e-4, 20_000, 1000, 300, 60
"""Gap, boxes, boxes with tangents, exact measurements and dear pieces of a search for what stands beside an answer."""
_MODEST_ENOUGH = 0.01
"""Gap with which such a search on tangents tries no other starts."""
_PLANE = 2
"""Variables in the plane of a link."""
_SLICES, _EMPTY_SLICES, _HUNG_SLICES = 300, 200, 100
"""Slices of a third variable, and those of them without any design, that boxes of all three are left to follow; of what
hangs on one place boxes are quick."""
_VALLEY = 50
"""Exact measurements of designs of which each takes long."""
_LINE_BOXES = 5_000
"""Boxes of a search over one variable: what they leave open is followed along its range."""
_FEW = 2
"""Starts beside a design that is known to be near."""


def choose(program: Program, method: Method | None, near: Sequence[float] | None = None) -> Method:
    """The method as it is given, or the one that proves most; `near` is a design to start from.

    Raises
    ------
    InputError
        The method refuses the program.
    """
    if program.ties:
        return _of_parts(program, method)
    if method is not None:
        refusal = method.refuses(program)
        if refusal is not None:
            why = refusal.removesuffix(".")
            raise InputError(f"--method {method.name}: {why}. Leave --method out: vibopt takes one that can.")
        return _begun(method, near)
    exact = closed_form(program)
    if exact is not None:
        return exact
    from vibopt.solve.global_search import provable
    from vibopt.solve.nlp import blind, sampleable
    from vibopt.solve.one_range import OneRange
    from vibopt.solve.tangents import Tangents

    if blind(program) or (program.aim is None and not provable(program) and OneRange().refuses(program) is None):
        return _seen_in_part(program, near)
    if program.aim is None and not sampleable(program) and Tangents().refuses(program) is None:
        return Tangents(near=near)  # boxes bound a peak in time, but hardly
    return _seen_whole(program, near) or _begun(_of_starts_alone(program), near)


def _seen_in_part(program: Program, near: Sequence[float] | None) -> Method:
    """The method where some part has no bound on boxes, or no goal says which design to look for."""
    from vibopt.solve.one_range import OneRange
    from vibopt.solve.tangents import Tangents

    methods: list[Method] = [OneRange(), Tangents(near=near)]
    if any(part.form.searched for part in program.parts):  # a range that is followed proves nothing of what is searched
        methods.reverse()
    sure = next((one for one in methods if one.refuses(program) is None), None)
    if sure is not None:
        return sure
    from vibopt.solve.boxes_first import BoxesFirst

    starts = _of_starts(program, near)
    boxes = BoxesFirst(starts, None if near is None else np.array(near, dtype=float))
    return boxes if boxes.refuses(program) is None else starts


def _seen_whole(program: Program, near: Sequence[float] | None) -> Method | None:
    """The method that searches all of what may be chosen, or each value listed; None where that is too much."""
    from vibopt.solve.boundable import on_few_places
    from vibopt.solve.global_search import BranchAndBound, dear, provable
    from vibopt.solve.one_range import OneRange
    from vibopt.solve.plane.discs import DiscsOfOneLink

    start = None if near is None else np.array(near, dtype=float)
    discs = DiscsOfOneLink(start=start)
    if len(program.axes) > _PLANE and all(axis.values is None for axis in program.axes):
        most = _HUNG_SLICES if on_few_places(program, 1) else _SLICES
        discs = DiscsOfOneLink(start=start, most=most, patience=_EMPTY_SLICES)
    if discs.refuses(program) is None:
        return discs
    search = BranchAndBound(near=start) if provable(program) else BranchAndBound(most=_UNBOUNDED_BOXES, near=start)
    if OneRange().refuses(program) is None:
        search = BranchAndBound(most=_LINE_BOXES, near=start)
    each = each_listed()
    if each.refuses(program) is None and (search.refuses(program) is not None or not provable(program)):
        return each
    if search.refuses(program) is None and not dear(program):
        return search
    from vibopt.solve.round_and_exchange import RoundAndExchange

    turns = RoundAndExchange(near=start)
    return turns if turns.refuses(program) is None else None


def _of_starts_alone(program: Program) -> Method:
    """The best of many starts, of all that is smooth; InputError where that is no way either."""
    from vibopt.solve.nlp import Nlp

    general = Nlp()
    refusal = general.refuses(program)
    if refusal is not None:
        raise InputError(f"this scene is more than vibopt can solve yet: {refusal}")
    return general


def closed_form(program: Program) -> Method | None:
    """The method that answers a program outright; None where there is no such."""
    return next((one for one in (OneVariable(), StiffnessAndDamping()) if one.refuses(program) is None), None)


def each_listed() -> Method:
    """Listed values one by one, with this choice of what answers the rest."""
    from vibopt.solve.each_listed import EachListed

    return EachListed(choose)


def modest(program: Program) -> Method:
    """The method for what stands beside an answer (conflicts, loosenings, ideal values): a coarser proof will do."""
    from vibopt.solve.boxes_first import BoxesFirst
    from vibopt.solve.global_search import BranchAndBound
    from vibopt.solve.nlp import Nlp
    from vibopt.solve.one_range import OneRange
    from vibopt.solve.tangents import Tangents

    method = choose(program, None)
    method = method.starts if isinstance(method, BoxesFirst) else method
    if isinstance(method, BranchAndBound):
        return BranchAndBound(MODEST_GAP, _MODEST_BOXES)
    if isinstance(method, Tangents):
        return Tangents(MODEST_GAP, _MODEST_TANGENTS, enough=_MODEST_ENOUGH)
    if isinstance(method, OneRange):
        return OneRange(MODEST_GAP, _MODEST_PIECES)
    return replace(method, count=_FEW, most=_MODEST_MEASUREMENTS) if isinstance(method, Nlp) else method


def _begun(method: Method, near: Sequence[float] | None) -> Method:
    """The method, begun at a design; what tries many starts then tries few others."""
    from vibopt.solve.nlp import Nlp

    return _near(method, near) if isinstance(method, Nlp) else method


def _near(method: Nlp, near: Sequence[float] | None) -> Nlp:
    if near is None:
        return method
    return replace(method, given=(np.array(near, dtype=float),), count=_FEW, brief=True)


def _of_starts(program: Program, near: Sequence[float] | None) -> Nlp:
    """Few starts of the most promising designs where each takes long and leads along a flat valley.

    Those are no fewer beside a design that is `near`: of several valleys another may be the best.
    """
    from vibopt.solve.nlp import Nlp

    if not any(part.form.screened for part in program.parts):
        return _near(Nlp(), near)
    return replace(_near(Nlp(), near), count=_FEW, most=_VALLEY, brief=False)


def _of_parts(program: Program, asked: Method | None) -> Method:
    """Parts of a catalogue alone are chosen by one method, and beside ranges by another."""
    from vibopt.solve.catalogue import Catalogue
    from vibopt.solve.round_and_exchange import RoundAndExchange

    method = RoundAndExchange() if program.ranged else Catalogue()
    if asked is not None and asked.name != method.name:
        beside = " beside a range" * isinstance(method, RoundAndExchange)
        raise InputError(
            f"--method {asked.name}: parts of a catalogue{beside} are chosen by --method {method.name} alone."
        )
    refusal = method.refuses(program)
    if refusal is not None:
        raise InputError(refusal)
    return method
