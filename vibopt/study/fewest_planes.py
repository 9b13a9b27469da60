"""The fewest planes of a rotor, measured or modelled, or of a shaft in which weights keep every limit."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations
from math import comb
from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.balancing import is_known, is_rotor
from vibopt.balancing.known.correct import complete, pose
from vibopt.balancing.question import together
from vibopt.balancing.rotor_question import row_limits
from vibopt.errors import InputError, counted
from vibopt.jobs import answer, with_changes
from vibopt.records import dataclass
from vibopt.solve.method import Progress
from vibopt.study.seen import goal_of

if TYPE_CHECKING:
    from vibopt.answer.answer import Answer
    from vibopt.balancing.known.known_job import KnownJob
    from vibopt.balancing.question import Question
    from vibopt.balancing.rotor_job import RotorJob
    from vibopt.jobs import Job

MOST_SETS = 1_000
"""Sets of planes that are tried at most."""


@dataclass(frozen=True, slots=True)
class FewestPlanes:
    """Planes that take weights, those that are left untouched, and in words what was tried and what that proves."""

    planes: tuple[str, ...]
    untouched: tuple[str, ...]
    words: str

    @property
    def changes(self) -> Mapping[str, bool]:
        """What makes the job one of these planes alone, by path."""
        return {f"planes.{name}.keep": True for name in self.untouched}


def fewest_planes(job: Job, progress: Progress | None = None) -> FewestPlanes:
    """Of all sets of one plane, of two, and so on the first size that keeps every limit, and of these the best goal.

    That fewer planes keep them not is proven where no weights in any smaller set can, and else said to be open.

    Raises
    ------
    InputError
        The job is no rotor or shaft with limits on what is left; no plane is needed, or no set is enough; or there are
        too many.
    """
    if not (is_rotor(job) or is_known(job)):
        raise InputError(f"{job.name}: --fewest-planes is of the planes of a rotor or a shaft. Leave it out.")
    if not (job.residual_limits if is_rotor(job) else np.isfinite(_asked(job).limits).any()):
        response = "residual" if is_rotor(job) else "static_unbalance"
        raise InputError(
            f"{job.name}: without a limit on what is left no plane is needed. Add [limits.NAME] with response = "
            f'"{response}" and at_most.'
        )
    names = tuple(plane.name for plane in job.planes if not plane.keep)
    tried, unsettled = 0, 0
    for count in range(1, len(names) + 1):
        here = comb(len(names), count)
        if tried + here > MOST_SETS:
            raise InputError(
                f"{job.name}: {counted(tried, 'sets')} of fewer than {counted(count, 'planes')} keep the limits not, "
                f"and more than {MOST_SETS} sets are not tried. Write keep = true in planes that are to stay untouched."
            )
        found: dict[tuple[str, ...], Answer[Any]] = {}
        for chosen in (one for one in combinations(names, count) if not _parted(job, one)):
            if progress is not None:
                progress("fewest planes", (tried + len(found)) / 2.0 ** len(names))
            found[chosen] = _with(job, chosen, names)
        good = [chosen for chosen, answer in found.items() if answer.status in ("optimal", "feasible")]
        if good:
            best = min(good, key=lambda chosen: _goal(job, found[chosen]))
            if count == 1 and _holds_as_found(job, found[best]):
                what = "rotor" if is_rotor(job) else "shaft"
                raise InputError(
                    f"{job.name}: as found the {what} keeps every limit: no plane needs a weight. Leave "
                    "--fewest-planes out to see what weights gain."
                )
            return _told(best, names, tried, len(found), proven=not unsettled)
        tried += len(found)
        unsettled += sum(answer.status != "infeasible" for answer in found.values())
    raise InputError(
        f"{job.name}: no planes keep every limit, not all of them. Leave --fewest-planes out: the answer says which "
        "limits cannot hold together."
    )


def _asked(job: KnownJob) -> Question:
    """What is asked of a shaft, complete balance where no limit says how good."""
    return complete(job, pose(job).question)


def _with(job: RotorJob | KnownJob, chosen: tuple[str, ...], names: tuple[str, ...]) -> Answer[Any]:
    """The answer where all other planes stay untouched."""
    changes = {f"planes.{name}.keep": True for name in names if name not in chosen}
    return answer(with_changes(job, changes) if changes else job, explain=False, brief=True)


def _parted(job: RotorJob | KnownJob, chosen: tuple[str, ...]) -> bool:
    """Whether one plane of a pair is among them without the other, so that both stay untouched."""
    names = [plane.name for plane in job.planes]
    return is_rotor(job) and any(
        (names[first] in chosen) != (names[second] in chosen) for _, first, second, _ in job.pairs
    )


def _goal(job: RotorJob | KnownJob, answer: Answer[Any]) -> float:
    goal = goal_of(job, answer)
    return goal.value if goal is not None else 0.0


def _holds_as_found(job: RotorJob | KnownJob, answer: Answer[Any]) -> bool:
    if is_known(job):
        asked = _asked(job)
        return bool((np.abs(asked.y0) <= asked.limits).all())
    found = np.abs([row.y0 for row in answer.plan.fittings[0].rows])
    return bool((together(found, job.sums) <= row_limits(job)).all())


def _told(chosen: tuple[str, ...], names: tuple[str, ...], fewer: int, alike: int, *, proven: bool) -> FewestPlanes:
    untouched = tuple(name for name in names if name not in chosen)
    many = counted(len(names), "planes")
    words = f"Fewest planes: {', '.join(chosen)} of {many}" if untouched else f"Fewest planes: all {many} are needed"
    if fewer:
        known = "proven of each" if proven else "not proven of all"
        words += f"; {counted(fewer, 'sets')} of fewer planes cannot keep the limits, {known}"
    words += f"; of the {alike} sets of as many the one with the best goal" if untouched and alike > 1 else ""
    return FewestPlanes(chosen, untouched, f"{words}.")
