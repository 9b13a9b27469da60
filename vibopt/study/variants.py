"""Variants A, B, C in one table: what each chooses, what it costs, and how much room each limit has."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from vibopt.answer.tabular import Tabular
from vibopt.errors import InputError
from vibopt.jobs import is_scene, noun_of
from vibopt.records import dataclass
from vibopt.report.machine_words import listed
from vibopt.solve.method import Progress
from vibopt.study.many import answers
from vibopt.study.variant_cells import Row
from vibopt.study.variant_rows import rows_of, rows_of_plans

if TYPE_CHECKING:
    from vibopt.answer.answer import Answer
    from vibopt.jobs import Job


@dataclass(frozen=True, slots=True)
class Variants(Tabular):
    """Several answers beside each other, by the names of the variants."""

    names: tuple[str, ...]
    designs: tuple[Answer[Any], ...]
    rows: tuple[Row, ...]

    def table(self) -> list[dict[str, Any]]:
        """A row for each line of the table, a number or word and its text per variant."""
        return [self._row(row) for row in self.rows]

    def _row(self, row: Row) -> dict[str, Any]:
        cells = dict(zip(self.names, row.cells, strict=True))
        values = {name: None if cell is None else cell.value for name, cell in cells.items()}
        shown = {f"{name} shown": None if cell is None else cell.text for name, cell in cells.items()}
        return {"kind": row.kind, "name": row.name, "unit": row.unit, **values, **shown}

    def as_said(self) -> dict[str, Any]:
        """The answers by the names of the variants, and the lines of the table."""
        return {"variants": dict(zip(self.names, self.designs, strict=True)), "rows": self.rows}

    @property
    def exit_code(self) -> int:
        """0 where any variant keeps its limits, else that of the first."""
        codes = [design.exit_code for design in self.designs]
        return 0 if 0 in codes else codes[0]


def compare(jobs: Mapping[str, Job], progress: Progress | None = None) -> Variants:
    """Answer each job and set the answers beside each other.

    Parameters
    ----------
    jobs
        By the name of the variant, all of one kind; one with choices is solved, one without is measured.
    progress
        Called with a stage and the part that is done.

    Raises
    ------
    InputError
        Fewer than two variants, one that asks for speeds, or jobs of several kinds.

    Notes
    -----
    Every goal of any variant is measured on all variants that have its places, so saved designs, which have nothing
    left to choose, are compared by it too.
    """
    _check(jobs)
    found = answers(jobs.values(), progress)
    plans = [job for job in jobs.values() if not is_scene(job)]
    return Variants(tuple(jobs), tuple(found), tuple(rows_of_plans(plans, found) if plans else rows_of(found)))


def _check(jobs: Mapping[str, Job]) -> None:
    if len(jobs) < 2:
        raise InputError("compare needs at least two variants. Name two problem files or saved designs.")
    for name, job in jobs.items():
        if is_scene(job) and job.find_all is not None:
            raise InputError(
                f"{name}: find_all answers with {job.finds}, which compare does not set beside each other."
            )
    kinds: dict[str, str] = {}
    for name, job in jobs.items():
        kinds.setdefault(noun_of(job), name)
    if len(kinds) > 1:
        said = listed([f"{name} is {noun}" for noun, name in kinds.items()])
        raise InputError(f"{said}: what is measured on one does not exist on another. Compare jobs of one kind.")
