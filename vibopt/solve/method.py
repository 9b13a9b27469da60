"""What every method has: a name, what it refuses, and an answer with its claim."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import field
from typing import Any, Protocol

from vibopt.arrays import FloatArray
from vibopt.program.program import Program
from vibopt.records import dataclass
from vibopt.work import Budget

Progress = Callable[[str, float], None]
Told = dict[float, tuple[float, Budget]]
"""Of logs of goals the log that none is below, as boxes told, and these."""
OPEN = "feasible", "unproven"
"""Statuses that prove nothing."""
VANISHED = "proven: what the goal counts is zero, up to rounding, and cannot be less"
"""Claim where a goal is zero, or an isolation leaves nothing."""


@dataclass(frozen=True, slots=True)
class Found:
    """Answer of a method, before anybody else has checked it.

    status
        "optimal" (proven), "feasible", "infeasible" (proven), "unbounded" (proven) or "unproven".
    x
        Design [SI], shape (n_vars,); None where there is none.
    claim
        How the status is known, in words.
    bound
        Proven bound of the goal in the sense to be minimised; nan where there is none.
    details
        Counts and figures of the method, for `explain`.
    zero
        Whether the goal, of an isolation what it leaves, is zero up to rounding, and cannot be less.
    """

    status: str
    x: FloatArray | None
    claim: str
    method: str
    bound: float = float("nan")
    details: Mapping[str, Any] = field(default_factory=dict)
    zero: bool = False


class Method(Protocol):
    """A way to answer a program."""

    name: str
    summary: str

    def refuses(self, program: Program) -> str | None:
        """A sentence that names what this method cannot take; None where it takes the program."""
        ...

    def solve(self, program: Program, progress: Progress | None = None) -> Found:
        """Answer the program."""
        ...
