"""The statuses of answers: exit codes, which of them are proven, and the refusal of those that are not."""

from __future__ import annotations

from typing import Self

from vibopt.errors import NotProven

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
UNPROVEN = EXIT_CODES["unproven"]
OPEN = ("feasible", "unproven", "check_failed")
"""Answers that may be good, but nothing proves it."""
EMPTY = ("infeasible", "unbounded", "unproven", "check_failed")
"""Answers without a design to round or to save."""


class Judged:
    """Anything with a status."""

    status: str
    claim: str

    @property
    def exit_code(self) -> int:
        """Exit code of the command line."""
        return EXIT_CODES[self.status]

    @property
    def proven(self) -> bool:
        """Whether nothing about the status is left open."""
        return self.status not in OPEN

    def require_proof(self) -> Self:
        """This answer, if its status is proven.

        Raises
        ------
        NotProven
            The answer may be good, but nothing proves it.
        """
        if not self.proven:
            raise NotProven(f"{self.name}: {self.status}: {self.claim}")  # type: ignore[attr-defined]
        return self
