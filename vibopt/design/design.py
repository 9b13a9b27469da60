"""The answer with its evidence: status, claim, values, limits, and how each was checked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from vibopt.errors import NotProven
from vibopt.scene.scene import Scene
from vibopt.units import show

EXIT_CODES = {
    "optimal": 0,
    "feasible": 0,
    "met": 0,
    "violated": 7,
    "infeasible": 3,
    "unbounded": 4,
    "unproven": 5,
    "check_failed": 6,
}


@dataclass(frozen=True, slots=True)
class Shown:
    """A value in SI, its SI unit, and the text in the user's unit."""

    value: float
    unit: str
    shown: str

    @classmethod
    def of(cls, value: float, dimension: str, si: str, unit: str = "", *, amplitude: bool = False) -> Shown:
        """From an SI value; `unit` is how the user wrote it ("" lets the size choose)."""
        return cls(value, si, show(value, unit, dimension, amplitude=amplitude))


@dataclass(frozen=True, slots=True)
class Chosen:
    """A design variable as chosen; `at_bound` is "from", "to" or "" (not at an end of its range)."""

    value: Shown
    at_bound: str = ""


@dataclass(frozen=True, slots=True)
class Placed:
    """A place or a part as chosen, by its name, and what it was chosen from; `among` says that in words."""

    value: str
    options: tuple[str, ...]
    among: str = ""


@dataclass(frozen=True, slots=True)
class Price:
    """What a loosened limit buys, checked by solving again.

    loosened
        The bound after a sensible step.
    goal
        Goal with the loosened bound.
    until
        The bound beyond which loosening buys nothing more; None when there is no such point.
    words
        The whole as one sentence.
    """

    loosened: Shown
    goal: Shown
    until: Shown | None
    words: str


@dataclass(frozen=True, slots=True)
class Checked:
    """One limit (or measure) of the finished design, measured on the built machine.

    name
        As in the file.
    response
        Kind of response, with its place in `place` ("into ground").
    side
        "at_most", "at_least", "outside", or "" for a measure.
    value
        Worst value.
    limit
        The bound; None for a measure.
    margin
        Part of the bound that is left over, (bound - value) / bound for at_most; negative when broken.
    active
        Whether the limit holds the design back (margin below 1e-6).
    met
        Whether the limit holds.
    worst_at
        Speed per excitation at which the worst is reached.
    off
        By how much numbers of the machine are off at its worst, by path: -0.2 is 20 % less.
    doubt
        What the optimiser's model says of it where that is another number; "" where both routes agree.
    """

    name: str
    response: str
    place: str
    side: str
    value: Shown
    limit: Shown | None
    margin: float
    active: bool
    met: bool
    worst_at: Mapping[str, Shown] = field(default_factory=dict)
    price: Price | None = None
    off: Mapping[str, float] = field(default_factory=dict)
    doubt: str = ""


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
    goal: Shown | None
    variables: Mapping[str, Shown]
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
    loosenings: tuple[tuple[str, Shown, Shown], ...]
    proof: str
    left: tuple[str, ...] = ()


@dataclass(frozen=True)
class Design:
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
    goal: tuple[str, Shown] | None
    variables: Mapping[str, Chosen]
    x: tuple[float, ...]
    limits: Mapping[str, Checked]
    measures: Mapping[str, Checked]
    model: Used
    method: str
    timings: Mapping[str, float]
    found: tuple[tuple[Shown, Shown], ...] | None = None
    conflict: Conflict | None = None
    reason: str = ""
    notes: tuple[str, ...] = ()
    details: Mapping[str, Any] = field(default_factory=dict)
    places: Mapping[str, Placed] = field(default_factory=dict)
    tolerances: Tolerances | None = None
    work: float = 0.0

    @property
    def exit_code(self) -> int:
        """Exit code of the command line."""
        return EXIT_CODES[self.status]

    @property
    def proven(self) -> bool:
        """Whether nothing about the status is left open."""
        sure = self.tolerances is None or not self.tolerances.open or self.status == "violated"
        return sure and self.status not in ("feasible", "unproven", "check_failed")

    def report(self) -> str:
        """The answer as text, as the command line prints it."""
        from vibopt.design.table import text_of

        return text_of(self)

    def require_proof(self) -> Design:
        """This design, if its status is proven.

        Raises
        ------
        NotProven
            The answer may be good, but nothing proves it.
        """
        if not self.proven:
            raise NotProven(f"{self.scene.name}: {self.status}: {self.claim}")
        return self
