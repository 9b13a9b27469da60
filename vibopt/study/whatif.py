"""What if: the old answer beside the new, with a new design or with the one that is bought."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from vibopt.answer.entry import Entry, Value
from vibopt.answer.tabular import Tabular
from vibopt.errors import InputError
from vibopt.jobs import answer, is_scene, noun_of, resolved, with_changes
from vibopt.program.drawn import drawn_alike
from vibopt.records import dataclass
from vibopt.scene.uncertain import likely
from vibopt.solve.method import Progress
from vibopt.study.freeze import bought
from vibopt.study.grids import check_asked
from vibopt.study.many import answers
from vibopt.study.rounded_plan import drawn
from vibopt.study.seen import chosen_from, kept
from vibopt.study.thresholds import Threshold, thresholds

if TYPE_CHECKING:
    from vibopt.answer.answer import Answer
    from vibopt.jobs import Job


@dataclass(frozen=True)
class WhatIf(Tabular):
    """Two answers to compare.

    job
        As it was before the changes.
    changes
        Values set, by path.
    before, after
        Answers before and after; with `keep_design` both measure the machine of `before`.
    breaks
        Limits that held before and break after (`keep_design` only).
    thresholds
        Where the frozen design of a scene fails, fact by fact (`keep_design` only): from the changed facts on when
        they leave every limit met, else from the facts as they were; none where neither meets every limit.
    """

    job: Job
    changes: Mapping[str, Any]
    before: Answer[Any]
    after: Answer[Any]
    keep_design: bool
    breaks: tuple[str, ...] = ()
    thresholds: tuple[Threshold, ...] = ()

    def table(self) -> list[dict[str, Any]]:
        """A row for each number and word of either answer, before and after: in SI and as shown."""
        both = [answer.entries() for answer in (self.before, self.after)]
        return [_beside(path, *(one.get(path) for one in both)) for path in dict.fromkeys((*both[0], *both[1]))]

    def as_said(self) -> dict[str, Any]:
        """Changes, both answers, what breaks and where."""
        keys = ("changes", "keep_design", "before", "after", "breaks", "thresholds")
        return {key: getattr(self, key) for key in keys}

    def heading(self) -> tuple[str, ...]:
        """Title, changes, and what breaks of a design that is kept."""
        changes = ", ".join(f"{path} = {change}" for path, change in self.changes.items())
        breaks = f"The design kept breaks {', '.join(self.breaks)}." if self.breaks else ""
        return self.job.title, changes, breaks


def _beside(path: str, before: Value | None, after: Value | None) -> dict[str, Any]:
    """One row of the table; None where an answer has nothing there."""
    one = before if before is not None else after
    return {
        "path": path,
        "unit": one.si if isinstance(one, Entry) else "",
        "before": None if before is None else before.value,
        "after": None if after is None else after.value,
        "before_shown": None if before is None else before.shown,
        "after_shown": None if after is None else after.shown,
    }


def whatif(
    job: Job,
    changes: Mapping[str, Any],
    *,
    keep_design: bool = False,
    rounding: Sequence[str] = (),
    progress: Progress | None = None,
) -> WhatIf:
    """Answer a job before and after some changes.

    Parameters
    ----------
    job
        The scene or balancing job as it is.
    changes
        Values by path, as in the file: {"limits.start_up.at_most": "8 mm"}.
    keep_design
        The design is bought: measure it under the changed facts instead of choosing anew.
    rounding
        What is bought are rounded values, as in `rounded`; `before` is then the design with them.
    progress
        Called with a stage and the part that is done.

    Raises
    ------
    InputError
        A path or value that does not fit, or no design to keep.
    """
    if rounding and not keep_design:
        raise InputError("--round goes with --keep-design: what is chosen anew has no rounded values to keep. Add it.")
    check_asked(rounding)
    changed = with_changes(job, changes)
    changes = resolved(job, changes)[0]
    if not keep_design:
        before, after = answers([job, changed], progress)
        return WhatIf(job, changes, before, after, keep_design)
    _check(job, changed, changes)
    with drawn_alike():
        before = answer(job, progress=progress)
        fixed = kept(job, before)
        if rounding:
            done = drawn(job, before, rounding)
            before, fixed = done.design, bought(done.kept, job) if is_scene(job) and is_scene(done.kept) else done.kept
        after = answer(with_changes(fixed, changes))
    held = {name for name, limit in before.limits.items() if limit.met}
    breaks = tuple(name for name, limit in after.limits.items() if not limit.met and name in held)
    base = with_changes(fixed, changes) if after.status == "met" else fixed
    sound = is_scene(base) and (after.status == "met" or len(held) == len(before.limits))
    found = thresholds(base, progress) if sound and is_scene(base) and not likely(base) else ()
    return WhatIf(job, changes, before, after, keep_design, breaks, tuple(found))


def unfollowed(job: Job) -> str:
    """Why it is not said of a kind of job how far each fact may go; "" where it is."""
    if is_scene(job):
        words = "is told for the worst machine, and a limit asks for a probability. Vary what is in doubt"
        return f"How far each fact may go {words}: vibopt sweep --keep-design." if likely(job) else ""
    return (
        f"How far each fact may go is told for machines alone: {noun_of(job)} feels a weight by its size and its angle "
        "together, and neither alone has an end. Vary what is in doubt: vibopt sweep --keep-design."
    )


def _check(job: Job, changed: Job, changes: Mapping[str, Any]) -> None:
    """Whether there can be a design to keep, and the changes do not speak of how it was chosen."""
    finds = next((one.finds for one in (job, changed) if is_scene(one) and one.finds), "")
    if finds:
        raise InputError(
            f"{job.name}: find_all answers with {finds}, so there is no design to keep: "
            "use whatif without --keep-design instead."
        )
    for path in changes:
        if chosen_from(job, path):
            raise InputError(
                f"{path} says from what a design is chosen, and with --keep-design none is. Leave this change out, or "
                "leave --keep-design out."
            )
