"""One design, or one plan of weights, for a job as it is and for every scenario: what is told of it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from vibopt.answer.answer import OPEN
from vibopt.answer.entry import Checked, Entry
from vibopt.answer.tabular import Tabular
from vibopt.records import dataclass

if TYPE_CHECKING:
    from vibopt.jobs import Job

AS_IT_IS = "as it is"


@dataclass(frozen=True, slots=True)
class OneForAll(Tabular):
    """One design for the job as it is and for every scenario.

    status, claim
        As of an answer; "check_failed" where a limit is missed on a machine as built.
    goal
        Name and value of the goal in the worst scenario; None without a design.
    variables
        What is chosen, by path.
    limits
        Rows of the limits by scenario, measured on each machine as built.
    reason
        Without a design the limits that cannot hold together, each with its scenario; "" where none are known.
    kept
        The job with what is chosen as facts; None without a design.
    """

    job: Job
    status: str
    claim: str
    goal: tuple[str, Entry] | None
    variables: Mapping[str, Entry]
    limits: Mapping[str, Mapping[str, Checked]]
    reason: str = ""
    kept: Job | None = None

    @property
    def verdict(self) -> str:
        """The first line: status and goal."""
        if self.goal is None:
            return self.status
        return f"{self.status}: {self.goal[0].replace('_', ' ')} is {self.goal[1].shown} in the worst of all scenarios"

    def table(self) -> list[dict[str, Any]]:
        """A row for each limit in each scenario."""
        return [
            {
                "scenario": name, "limit": key, "unit": row.value.si, "value": row.value.value, "margin": row.margin,
                "value shown": row.value.shown,
            }
            for name, rows in self.limits.items() for key, row in rows.items()
        ]  # fmt: skip

    def heading(self) -> tuple[str, ...]:
        """Title and verdict."""
        return self.job.title, f"{self.status}: one design for {', '.join(self.limits) or 'all scenarios'}"

    def as_said(self) -> dict[str, Any]:
        """In the shape of an answer: of each limit the row of the scenario with least room; all rows by scenario."""
        from vibopt.answer.jsonable import SCHEMA
        from vibopt.study.holding import measured_by

        worst: dict[str, Checked] = {}
        for rows in self.limits.values():
            worst |= {key: row for key, row in rows.items() if key not in worst or row.margin < worst[key].margin}
        sense = "maximise" if measured_by(self.job)[1] > 0 else "minimise"
        return {
            "schema": SCHEMA, "kind": self.job.kind, "name": self.job.name, "title": self.job.title,
            "status": self.status, "claim": self.claim, "reason": self.reason, "proven": self.status not in OPEN,
            "goal": None if self.goal is None else {"name": self.goal[0], "sense": sense, **self.goal[1].to_json()},
            "limits": worst, "variables": self.variables,
            "scenarios": {name: {"limits": rows} for name, rows in self.limits.items()},
        }  # fmt: skip
