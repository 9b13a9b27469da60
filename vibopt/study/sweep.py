"""One, two or three facts varied over ranges: goal and variables against them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.answer.tabular import Tabular, installed
from vibopt.arrays import FloatArray
from vibopt.errors import InputError, VibOptError
from vibopt.jobs import answer, asks_shares, is_open, is_scene
from vibopt.records import cached_property, dataclass
from vibopt.solve.method import Progress
from vibopt.study import many
from vibopt.study.edges import Boundary, boundaries
from vibopt.study.points import Heads, Point, Points
from vibopt.study.seen import goal_word, kept
from vibopt.study.varied import Sample, Varied, how_many, is_variable, points_of, varied
from vibopt.values.fact_at import FactAt
from vibopt.work import spoken_time

if TYPE_CHECKING:
    from vibopt.jobs import Job
    from vibopt.study.workers import Pool

MOST_POINTS = 100_000
"""More points than this are answered if that is asked for twice."""


@dataclass(frozen=True)
class Sweep(Tabular):
    """All points of a sweep: of a grid in rising order, the first fact slowest; of a sample as they were drawn.

    varied
        What is varied, in the units of the ranges asked for.
    points
        One for each combination of values.
    goal
        Name of the goal, "" for an analysis.
    axes
        Values of each fact in the grid [SI]; () for a sample.
    base
        The job as it was answered, with what is held or kept as facts.
    """

    job: Job
    varied: tuple[Varied, ...]
    points: Sequence[Point]
    goal: str
    keep_design: bool = False
    axes: tuple[FloatArray, ...] = ()
    base: Job | None = None

    @property
    def fact(self) -> FactAt:
        """The first fact that is varied."""
        return self.varied[0].fact

    @property
    def facts(self) -> tuple[FactAt, ...]:
        """All facts that are varied."""
        return tuple(varied.fact for varied in self.varied)

    @property
    def path(self) -> str:
        """Path of the fact that is varied; of the first of several."""
        return self.fact.path

    @property
    def paths(self) -> tuple[str, ...]:
        """Paths of all facts that are varied."""
        return tuple(varied.fact.path for varied in self.varied)

    @property
    def held(self) -> tuple[str, ...]:
        """Paths of variables that are held at each value, and are no facts."""
        return tuple(varied.fact.path for varied in self.varied if varied.held)

    @property
    def by_ratios(self) -> bool:
        """Whether the values of the first fact have equal ratios."""
        return self.varied[0].by_ratios

    @property
    def drawn(self) -> tuple[str, ...]:
        """Limits with a probability, which machines that are drawn tell, or leave open."""
        return asks_shares(self.job)

    @cached_property
    def boundaries(self) -> tuple[Boundary, ...]:
        """Where answers begin or end and where other limits become active, found between the points of a grid.

        None where a limit asks for a probability: a verdict ends where the machines that were drawn end it.
        """
        if not self.axes or not isinstance(self.points, Points) or self.base is None or self.drawn:
            return ()
        return boundaries(self.base, self.varied, self.axes, self.points)

    def table(self) -> list[dict[str, Any]]:
        """A row for each point, with the columns of the CSV file: SI units in their heads, margins as parts."""
        points = list(self.points)
        return Heads(self.facts, self.job, self.goal, points).table(points)

    def to_xarray(self) -> Any:
        """The grid as an `xarray.Dataset`: a dimension for each fact [SI], a variable for each other column.

        Raises
        ------
        VibOptError
            xarray is not installed, or the points are a sample, which is no grid.
        """
        if not self.axes:
            raise VibOptError("to_xarray is for a grid, and these points are a sample. Take .to_pandas() or .table().")
        xarray = installed("xarray", "to_xarray", "or take .table(): the same rows as a list.")
        rows, shape = self.table(), [len(axis) for axis in self.axes]
        heads = list(rows[0])
        names = heads[: len(self.axes)]
        columns = {head: _column([row[head] for row in rows]).reshape(shape) for head in heads[len(names) :]}
        coords = dict(zip(names, self.axes, strict=True))
        return xarray.Dataset({head: (names, column) for head, column in columns.items()}, coords=coords)

    def as_said(self) -> dict[str, Any]:
        """Path or paths, goal, and all points."""
        where = {"path": self.path} if len(self.varied) == 1 else {"paths": self.paths}
        return {**where, "goal": self.goal, "keep_design": self.keep_design, "points": self.points,
                "boundaries": self.boundaries}  # fmt: skip

    def heading(self) -> tuple[str, ...]:
        """Title and what is varied."""
        return self.job.title, f"{', '.join(self.paths)} varied"

    @property
    def complete(self) -> bool:
        """Whether every point has a proven or checked answer."""
        points = self.points
        found = points.statuses if isinstance(points, Points) else [point.status for point in points]
        return not {"unproven", "check_failed"} & set(found)


def _column(cells: list[Any]) -> Any:
    """Numbers as such, nan where there is none; words as they are."""
    words = any(isinstance(cell, str) for cell in cells)
    return np.array(
        ["" if cell is None else str(cell) for cell in cells] if words else cells, dtype=None if words else float
    )


def sweep(
    job: Job,
    vary: str | Mapping[str, str],
    low_high: str = "",
    points: int | None = None,
    *,
    sample: Sample = "",
    keep_design: bool = False,
    workers: int = 1,
    cluster: str | None = None,
    most: int = MOST_POINTS,
    progress: Progress | None = None,
    answered: many.Answered | None = None,
    known: Sequence[Point] = (),
) -> Sweep:
    """Answer a job at values of one, two or three facts.

    Parameters
    ----------
    job
        A scene or a balancing job as it is.
    vary
        Path of a fact, "limits.start_up.at_most", or of a variable, which is then held at each value; or ranges by
        path, {"limits.start_up.at_most": "5 mm..30 mm", "bodies.press.mass": "-20 %..+20 %"}.
    low_high
        The range of the one fact, "5 mm..30 mm", "5 mm..30 mm log", a list "10, 12, 15 mm", or parts of what it is
        now, "-20 %..+20 %".  A range is evenly spaced in its unit, in dB too; by equal ratios where it says log, or
        spans more than a factor 100, and is not in dB.
    points
        How many values of each range, both ends included (50 of one, 21 of two, 9 of three); of a sample, in all.
    sample
        "sobol" or "latin": points drawn evenly from the ranges, the same each time, in place of a grid.
    keep_design
        Keep the design of the job as it is, and measure it.
    workers, cluster
        Processes at a time, or the address of a scheduler of Dask whose workers answer in their place,
        "tcp://10.0.0.5:8786"; the answers depend on neither.
    most
        Refuse more points than this.
    progress
        Called now and then with a stage and the part that is done (0 to 1).
    answered
        Called with the facts and each point as soon as it is known, in any order; not where all are found together.
    known
        Points of the same sweep that were answered before; the others are answered.

    Raises
    ------
    InputError
        No such fact, a range that cannot be read, no design to keep, a scene that asks for speeds, or no cluster.
    PoolError
        A process or the cluster went away in the middle.
    """
    job, base, what = _varied(job, ranges := _ranges(job, vary, low_high), keep_design)
    _check_count(base, what, (how_many(ranges, points, sample), points), most)
    where, facts = points_of(what, points, sample), tuple(varied.fact for varied in what)
    before = _before(where.values, known)
    with pool_of(workers, cluster) as pool:
        found = many.answered(base, facts, where.values, pool=pool, progress=progress, told=answered, known=before)
    return Sweep(job, what, found, goal_word(base), keep_design, where.axes, base)


def pool_of(workers: int, address: str | None = None) -> AbstractContextManager[Pool | None]:
    """Those who answer; None for this process alone, which has no use for what others load."""
    if address is not None:
        from vibopt.study.cluster import cluster

        return cluster(address)
    if workers == 1:
        return nullcontext()
    from vibopt.study.workers import Processes

    return Processes(workers, lasting=True)


def _ranges(job: Job, vary: str | Mapping[str, str], low_high: str) -> dict[str, str]:
    """Ranges by path, of a job that answers with numbers."""
    if not isinstance(vary, (str, Mapping)):
        raise InputError(f'{job.name}: sweep over {vary!r}: write a path and its range, or {{"path": "5 mm..30 mm"}}.')
    ranges = {vary: low_high} if isinstance(vary, str) else dict(vary)
    if is_scene(job) and job.find_all is not None and job.find_all not in ranges:
        raise InputError(
            f"{job.name}: sweep needs a goal or limits to measure; find_all answers with {job.finds}: use whatif "
            "instead."
        )
    return ranges


def _before(values: FloatArray, known: Sequence[Point]) -> dict[int, Point]:
    """Points that are known by the index of their values [SI], (n_points, n_facts)."""
    at = {tuple(map(float, value)): index for index, value in enumerate(values)} if known else {}
    return {at[here]: point for point in known if (here := tuple(each.value for each in point.varied.values())) in at}


def _varied(job: Job, ranges: Mapping[str, str], keep_design: bool) -> tuple[Job, Job, tuple[Varied, ...]]:
    """The job with variables held where they are varied, the same with the design that is kept, and what is varied."""
    held = any(is_variable(job, path) for path in ranges)
    parts = held and any("%" in name for name in ranges.values())
    design = answer(job, explain=False) if is_open(job) and (keep_design or parts) else None
    base = kept(job, design) if keep_design and design is not None else job
    made, what = varied(base, ranges, design)
    return made if held and not keep_design else job, made if base is job else base, what


def _check_count(job: Job, what: Sequence[Varied], count: tuple[int, int | None], most: int) -> None:
    """Whether so many points, of so many values each, are answered unasked."""
    points, each = count
    if each is not None and each < 2:
        raise InputError(f"--points {each} is not between 2 and {MOST_POINTS}.")
    if points > most > MOST_POINTS:
        raise InputError(f"{points} points are more than the {most} of one sweep. Take fewer --points.")
    if points > most:
        work = spoken_time(1e-3 * points * many.work_of_one(job, what))
        raise InputError(
            f"{points} points are {points} answers, some {work} of work, more than the {MOST_POINTS} that are answered "
            "unasked. Take fewer --points, or add --yes."
        )
