"""One law for every chart and family: what a method claims is compared with what is true."""

from __future__ import annotations

import math

from vibopt.records import dataclass

FEASIBLE, INFEASIBLE = "feasible", "infeasible"
RIGHT, SAYS_SO, UNPROVEN, SILENT, REFUSES = (
    "right",
    "fails and says so",
    "unproven and off",
    "silently wrong",
    "refuses",
)
CLASSES = (RIGHT, SAYS_SO, UNPROVEN, SILENT, REFUSES)
MISSING = "not installed"
"""Status and verdict of a rival that is not there; its claim says how to get it."""

BROKEN, PROVEN, OFF = 1e-6, 1e-5, 1e-3
"""Part of a bound by which a limit counts as broken, and part of the goal by which it counts as missed: where the best
is claimed to be proven, and where it is not."""


@dataclass(frozen=True, slots=True)
class Judged:
    """Class of an answer, and what is wrong with it in words; "" where nothing is."""

    verdict: str
    fault: str


def verdict_of(
    truth: str, status: str, missed: float, off: float, past: float = math.nan, within: float = 0.0
) -> Judged:
    """The class of an answer.

    Parameters
    ----------
    truth
        Whether the question has an answer: "feasible", "infeasible".
    status
        What is claimed: "optimal" (nothing is better), "feasible" (every limit holds), "infeasible"; every other word
        claims nothing.
    missed, off
        Greatest violation as a part of its bound, and distance from the best goal as a part; nan without a design.
    past
        By what part of the best goal a claimed bound excludes it; nan where none is claimed.
    within
        How exact the answer says it is, as a part; 0 where it says nothing.
    """
    if status in (REFUSES, MISSING):
        return Judged(status, "")
    if status == "infeasible":
        return Judged(SILENT, "calls a feasible scene infeasible") if truth == FEASIBLE else Judged(RIGHT, "")
    if status not in ("optimal", "feasible"):
        return Judged(SAYS_SO, "")
    if missed > BROKEN:
        said = UNPROVEN if missed <= within else SILENT
        return Judged(said, f"limit broken by {missed:.1e}" if missed < 1e3 else "limit broken without end")
    if past > PROVEN:
        return Judged(SILENT, f"bound past the best by {past:.1e}")
    if truth == FEASIBLE and off > (PROVEN if status == "optimal" else OFF):
        said = SILENT if status == "optimal" and off > within else UNPROVEN
        return Judged(said, f"goal off by {off:.1e}")
    return Judged(RIGHT, "")
