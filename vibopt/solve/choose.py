"""Which method answers a program."""

from __future__ import annotations

from vibopt.errors import InputError, way_out
from vibopt.program.program import Program
from vibopt.solve.method import Method
from vibopt.solve.outer import OneVariable, StiffnessAndDamping

_UNBOUNDED_SECONDS = 5.0
"""Time of a search that cannot prove anything, because a limit has no bound on boxes."""


def choose(program: Program, name: str | None) -> Method:
    """The method called `name`, or the one that proves most.

    Raises
    ------
    InputError
        No such method, or it refuses the program.
    """
    if name is not None:
        from vibopt.solve.registry import METHODS

        if name not in METHODS:
            raise InputError(f"--method {name}: there is no such method.{way_out(name, list(METHODS))}")
        method: Method = METHODS[name]()
        refusal = method.refuses(program)
        if refusal is not None:
            raise InputError(f"--method {name}: {refusal}")
        return method
    for exact in (OneVariable(), StiffnessAndDamping()):
        if exact.refuses(program) is None:
            return exact
    from vibopt.solve.nlp import Nlp, blind

    if blind(program):
        return Nlp()
    from vibopt.solve.plane.method import DiscsOfOneLink

    discs = DiscsOfOneLink()
    if discs.refuses(program) is None:
        return discs
    from vibopt.solve.global_search import BranchAndBound, provable

    search = BranchAndBound() if provable(program) else BranchAndBound(seconds=_UNBOUNDED_SECONDS)
    refusal = search.refuses(program)
    if refusal is None:
        return search
    from vibopt.solve.registry import METHODS

    general: Method = METHODS["nlp"]()
    refusal = general.refuses(program)
    if refusal is not None:
        raise InputError(f"this scene is more than vibopt can solve yet: {refusal}")
    return general
