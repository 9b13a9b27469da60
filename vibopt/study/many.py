"""One list of changes, one list of answers: in one batch where closed forms allow, else one by one or by processes.

Sweeps, boundaries, trade-offs, windows, comparisons and what-ifs all ask here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from functools import partial
from math import ceil
from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.balancing import is_rotor
from vibopt.document.mistakes import Mistakes
from vibopt.errors import VibOptError
from vibopt.jobs import answer, is_scene, of_document, with_changes
from vibopt.program.drawn import drawn_alike
from vibopt.program.one_machine import one_machine
from vibopt.records import dataclass
from vibopt.scene.open_places import open_positions
from vibopt.scene.uncertain import uncertain
from vibopt.solve.method import Progress
from vibopt.study.points import Columns, Point, Points, point_of
from vibopt.study.seen import is_measured
from vibopt.study.together import Seen, columns
from vibopt.values.fact_at import FactAt
from vibopt.work import each_answer_within, metered, seconds_of_each_answer

if TYPE_CHECKING:
    from vibopt.answer.answer import Answer
    from vibopt.jobs import Job
    from vibopt.study.varied import Varied
    from vibopt.study.workers import Lost, Pool

Answered = Callable[[Sequence[FactAt], Point], None]
FEWEST_TOGETHER = 12
"""Fewer points than this are answered one by one."""
BATCH = 25.0
"""Work of the points that are sent away together, at least [nominal ms]."""
_SAME = 1e-9
_OF_BATCH, _LEAST = 0.006, 5.0
"""Work of an answer in a batch, and at least of one alone [nominal ms]."""
PROVEN = 2e-7
"""Part of the goal by which two plans of a measured rotor may differ, both proven."""


def answers(jobs: Iterable[Job], progress: Progress | None = None, stage: str = "variants") -> list[Answer[Any]]:
    """The answers to some jobs, one after the other."""
    many, found = list(jobs), []
    for index, one in enumerate(many):
        if progress is not None:
            progress(stage, index / len(many))
        with drawn_alike():
            found.append(answer(one, progress=progress))
    return found


def changed_at(job: Job, facts: Sequence[FactAt], values: FloatArray) -> Job:
    """The job with its facts at some values [SI], (n_facts,)."""
    places = [fact.place for fact in facts if fact.place]
    pairs = [(fact, float(value)) for fact, value in zip(facts, values, strict=True)]
    if len({*places}) == len(places):
        return with_changes(
            job, {path: text for fact_at, value in pairs for path, text in fact_at.changes(value).items()}
        )
    return with_changes(job, {fact_at.path: fact_at.text(value) for fact_at, value in pairs})  # two numbers of one text


def answered(
    job: Job,
    facts: tuple[FactAt, ...],
    values: FloatArray,
    *,
    pool: Pool | None = None,
    progress: Progress | None = None,
    told: Answered | None = None,
    known: Mapping[int, Point] | None = None,
    sparing: bool = False,
    seen: Seen | None = None,
) -> Points:
    """The answers at all values of some facts.

    Parameters
    ----------
    job
        In which the facts have any values.
    facts, values
        What is varied, and its values [SI], shape (n_points, n_facts).
    pool
        Those who answer the points that are not answered together, one by one here where there are none; the answers
        do not depend on it.
    progress
        Called now and then with a stage and the part that is done.
    told
        Called with the facts and each point as soon as it is known, in any order; not where all are found together.
    known
        Points that were answered before, by index.
    sparing
        Leave points with the status "" that were not answered where the others were answered together; the goal alone
        is asked for, and of designs that have it any is told.
    seen
        What other points of the same facts have shown that were answered together: that is not done again.
    """

    def tell(part: float) -> None:
        if progress is not None:
            progress("sweep", part)

    single: dict[int, Point] = dict(known or {})
    together = None
    if len(values) - len(single) >= FEWEST_TOGETHER:
        seen = seen or Seen()
        asked = partial(batch, job, facts, values, tell, whole=not sparing, seen=seen)
        together = asked() if seen.compared else _compared(job, facts, values, asked, single)
        seen.compared |= together is not None
    columns = together or Columns([""] * len(values), np.full((0, len(values)), np.nan), None, {})
    points = Points(job, facts, values, columns, single)
    open_ = [index for index, status in enumerate(columns.status) if not status and index not in single]
    if open_ and not (sparing and together is not None):
        _one_by_one(points, open_, pool, told, tell)
    return points


def _one_by_one(
    points: Points, rest: list[int], pool: Pool | None, told: Answered | None, tell: Callable[[float], None]
) -> None:
    """Add the points of the indices `rest`, each by itself; all others are told first."""
    facts, values = points.facts, points.values

    def alone(index: int, point: Point) -> None:
        points.single[index] = point
        if told is not None:
            told(facts, point)

    if told is not None:
        for index in sorted({*range(len(values))} - {*rest}):
            told(facts, points[index])
    if pool is not None and len(rest) > 1:
        _Shared(points.job, facts, values, rest, pool).answer(alone, tell)
        return
    for done, index in enumerate(rest):
        tell(done / len(rest))
        alone(index, one_point(points.job, facts, values[index]))


def of_one_machine(job: Job, paths: Iterable[str]) -> AbstractContextManager[None]:
    """While numbers at some paths move: where bounds of limits alone do, what is measured of the machine stays."""
    if not is_scene(job) or not all(path.startswith("limits.") for path in paths):
        return nullcontext()
    return one_machine(job)


def one_point(job: Job, facts: Sequence[FactAt], values: FloatArray) -> Point:
    """The answer at one place, by itself."""
    here = changed_at(job, facts, values)
    with drawn_alike(), of_one_machine(job, [fact.path for fact in facts]):
        return point_of(facts, values, here, answer(here, explain=False, brief=True))


def work_of_one(job: Job, varied: Sequence[Varied]) -> float:
    """Work of one of many answers [nominal ms]: a share of a batch where two of them are found in one."""
    ends = np.array([[getattr(one, end) for one in varied] for end in ("low", "high")])
    if batch(job, tuple(one.fact for one in varied), ends) is not None:
        return _OF_BATCH
    return max(answer(job, explain=False, brief=True).work, _LEAST)


@dataclass(frozen=True, slots=True)
class _Errand:
    """Some points for another process: the job as its document, which travels lightly, and the user's time limit."""

    document: Mapping[str, Any]
    name: str
    facts: tuple[FactAt, ...]
    values: FloatArray
    seconds: float | None


def _ran(errand: _Errand) -> tuple[list[Point], float] | VibOptError:
    """The points, and the work of one of them [nominal ms]."""
    try:
        job = of_document(errand.document, Mistakes(errand.name, None))
        with metered() as meter, each_answer_within(errand.seconds):
            points = [one_point(job, errand.facts, value) for value in errand.values]
        return points, max(meter.done / len(points), _LEAST)
    except VibOptError as error:
        return error


class _Shared:
    """Points that others answer, in parts that are worth the way; as long as no work is known a part is one point."""

    def __init__(
        self, job: Job, facts: tuple[FactAt, ...], values: FloatArray, rest: Sequence[int], pool: Pool
    ) -> None:
        self._errand = partial(_Errand, job.document, job.name, facts, seconds=seconds_of_each_answer())
        self._values, self._rest, self._pool = values, rest, pool
        self._parts: list[Sequence[int]] = []
        self._done, self._work = 0, 0.0

    def answer(self, alone: Callable[[int, Point], None], tell: Callable[[float], None]) -> None:
        """Have all points answered; each is told by its index as soon as it is there."""
        from vibopt.study.workers import each, taken  # loads multiprocessing, of no use for one process

        def ready(index: int, found: tuple[list[Point], float] | VibOptError | Lost) -> None:
            points, work = taken(found, "A point", self._pool)
            self._done += len(points)
            self._work += work * len(points)
            tell(self._done / len(self._rest))
            for place, point in zip(self._parts[index], points, strict=True):
                alone(place, point)

        each(_ran, self._errands(), self._pool, ready=ready)

    def _errands(self) -> Iterator[_Errand]:
        begun = 0
        while begun < len(self._rest):
            size = ceil(BATCH * self._done / self._work) if self._done else 1
            self._parts.append(self._rest[begun : begun + size])
            begun += len(self._parts[-1])
            yield self._errand(self._values[self._parts[-1]])


def _compared(
    job: Job,
    facts: tuple[FactAt, ...],
    values: FloatArray,
    asked: Callable[[], Columns | None],
    single: dict[int, Point],
) -> Columns | None:
    """All points `asked` in one batch, one of them answered alone to compare; None where that is not possible."""
    columns = asked()
    if columns is None:
        return None
    middle = len(values) // 2
    point = one_point(job, facts, values[middle])
    single.setdefault(middle, point)
    return columns if _agree(job, columns, middle, point) else None


def batch(
    job: Job,
    facts: Sequence[FactAt],
    values: FloatArray,
    tell: Callable[[float], None] | None = None,
    *,
    whole: bool = True,
    seen: Seen | None = None,
) -> Columns | None:
    """The answers at all values (n_points, n_facts) [SI] in one batch; None where they are not found together.

    Without `whole` also where the goal leaves a part of the design open, of which any is then told.
    """
    if is_rotor(job):
        from vibopt.study import rotor_points

        return rotor_points.columns(job, partial(changed_at, job, facts), values)
    if not is_scene(job) or uncertain(job) or open_positions(job) or is_measured(job):
        return None
    return columns(job, facts, values, tell, whole=whole, seen=seen)


def _agree(scene: Job, together: Columns, index: int, point: Point) -> bool:
    """Whether a point answered alone has the same answer as among the others."""
    status = together.status[index]
    if status != point.status:
        return status == ""
    if status == "infeasible":
        return True
    if not is_scene(scene):  # each proven to a part of the goal
        goal = together.goal
        return point.goal is None or goal is None or abs(point.goal.value - goal[index]) <= PROVEN * point.goal.value
    designs = [
        (point.variables[variable.path].value, x[index])
        for variable, x in zip(scene.variables, together.x, strict=True)
    ]
    if not all(_near(alone, other, abs(alone)) for alone, other in designs):
        # where a peak is level with a limit, rounding leaves free what the goal does not fix
        goal = together.goal
        return point.goal is not None and goal is not None and _near(point.goal.value, goal[index], abs(goal[index]))
    return all(_near(point.margins[name], margin[index], 1.0) for name, margin in together.margins.items())


def _near(alone: float, other: float, size: float) -> bool:
    return alone == other or abs(alone - other) <= _SAME * max(size, abs(alone))
