"""The answer with its evidence: status, claim, values, limits, and how each was checked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from vibopt.answer.entry import Checked, Chosen, Entry, Word
from vibopt.answer.status import OPEN, Judged
from vibopt.scene.scene import Scene


@dataclass(frozen=True, slots=True)
class Tolerances:
    """What tolerances do to an answer.

    status, goal, variables, parts
        Of the answer without tolerances; empty for an analysis.
    uncertain
        How far each number may be off, by path.
    goal_off
        By how much numbers are off where the goal is worst.
    open
        Limits (and "the goal") of which the worst machine is found, but not proven to be the worst.
    """

    status: str
    goal: Entry | None
    variables: Mapping[str, Entry]
    uncertain: Mapping[str, float]
    goal_off: Mapping[str, float] = field(default_factory=dict)
    open: tuple[str, ...] = ()
    parts: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Used:
    """Degrees of freedom declared by the file and needed by the questions asked, with the reason."""

    declared_dof: int
    used_dof: int
    why: str


@dataclass(frozen=True, slots=True)
class Conflict:
    """Limits that cannot hold together, and for each the smallest loosening that helps, rounded outward.

    limits
        Names of a smallest such set.
    loosenings
        (name, bound now, bound that makes the scene feasible); a limit that no loosening alone mends is left out.
    proof
        How the conflict was proven, in words.
    left
        Names of limits for which no loosening was looked for, because of the work.
    """

    limits: tuple[str, ...]
    loosenings: tuple[tuple[str, Entry, Entry], ...]
    proof: str
    left: tuple[str, ...] = ()


@dataclass(frozen=True)
class Design(Judged):
    """Answer to a scene.

    status
        A key of EXIT_CODES.
    claim
        How the status is known, in words.
    variables
        Design variables by path; empty for an analysis or where nothing was found.
    x
        Their values [SI], in the order of `scene.variables`.
    limits, measures
        Each measured on the built machine.
    found
        `find_all`: intervals (low, high) in the user's unit, else None.
    places
        Places chosen, by path; `scene` is then the one in which they have been.
    tolerances
        With numbers that may be off: `goal`, `limits` and `measures` are then the worst over all machines.
    method
        Name of the method that answered.
    timings
        Seconds by stage.
    work
        What the answer took [nominal ms], the same on any machine; studies decide by it what they compute.
    """

    scene: Scene
    status: str
    claim: str
    goal: tuple[str, Entry] | None
    variables: Mapping[str, Chosen]
    x: tuple[float, ...]
    limits: Mapping[str, Checked]
    measures: Mapping[str, Checked]
    model: Used
    method: str
    timings: Mapping[str, float]
    found: tuple[tuple[Entry, Entry], ...] | None = None
    conflict: Conflict | None = None
    reason: str = ""
    notes: tuple[str, ...] = ()
    details: Mapping[str, Any] = field(default_factory=dict)
    places: Mapping[str, Word] = field(default_factory=dict)
    tolerances: Tolerances | None = None
    work: float = 0.0

    @property
    def proven(self) -> bool:
        """Whether nothing about the status is left open."""
        sure = self.tolerances is None or not self.tolerances.open or self.status == "violated"
        return sure and self.status not in OPEN

    @property
    def name(self) -> str:
        return self.scene.name

    def report(self) -> str:
        """The answer as text, as the command line prints it."""
        from vibopt.design.table import text_of

        return text_of(self)
