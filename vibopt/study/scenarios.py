"""Named sets of changes in a file, `[scenarios.NAME]`: each answered by itself, or one design for all of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

from vibopt.answer.answer import OPEN
from vibopt.answer.clashes import Conflict
from vibopt.answer.entry import Entry
from vibopt.answer.tabular import Tabular
from vibopt.balancing import is_engine, is_known, is_rotor
from vibopt.errors import InputError
from vibopt.jobs import J, facts, is_open, scenarios_of, scene_only, with_changes
from vibopt.program.pose import pose
from vibopt.program.program import Aim, Program
from vibopt.records import dataclass
from vibopt.scene.open_places import open_places, open_positions
from vibopt.scene.scene import Scene
from vibopt.scene.uncertain import as_printed, uncertain
from vibopt.solve.dispatch import best_of
from vibopt.solve.loosen import clashes_of
from vibopt.solve.method import Progress
from vibopt.study.for_all import AS_IT_IS, OneForAll
from vibopt.study.freeze import bought, frozen, shown_values
from vibopt.study.many import answers
from vibopt.study.same_parts import same_parts
from vibopt.study.seen import goal_of, goal_word, shown_value
from vibopt.values.part_of_now import part_in
from vibopt.verify.checked import checked_limits, disagreement, goal_row
from vibopt.work import answering

if TYPE_CHECKING:
    from vibopt.jobs import Job

_PATIENCE = 2_000.0
"""Work [nominal ms] after which no further limit is left out of those that clash."""


def variants_of(job: J) -> dict[str, J]:
    """The job as it is, and with the changes of each scenario, by name; InputError where the file has none."""
    found = scenarios_of(job)
    if not found:
        proposed = ((fact.path, fact.now(1.1)) for fact in facts(job))
        path, value = next(filter(partial(_is_change, job), proposed), ("title", "another"))
        raise InputError(
            f'{job.name}: has no scenarios. Write [scenarios.other] with "{path}" = "{value}", for example.'
        )
    return {AS_IT_IS: job, **{name: with_changes(job, changes) for name, changes in found.items()}}


def _is_change(job: Job, change: tuple[str, str]) -> bool:
    """Whether a value by its path makes another job of it, and one without a mistake."""
    try:
        return with_changes(job, dict([change])).document != job.document
    except InputError:
        return False


def one_for_all(job: Job, *, progress: Progress | None = None) -> OneForAll:
    """The best one design, plan of weights or engine that keeps every limit as the file is and in every scenario.

    The goal is that of the worst of them.

    Raises
    ------
    InputError
        No scenarios, nothing to choose, or scenarios that change what may be chosen.
    """
    with answering() as limit:
        found = _one_for_all(job, progress)
    if limit is None or found.status not in OPEN:  # a complete proof needs no more search
        return found
    return replace(found, claim=limit.added_to(found.claim))


def _one_for_all(job: Job, progress: Progress | None) -> OneForAll:
    if is_rotor(job) or is_known(job):
        from vibopt.study.one_plan import one_plan

        return one_plan(job, variants_of(job))
    if is_engine(job):
        from vibopt.study.one_plan import one_engine

        return one_engine(job, variants_of(job))
    scene = scene_only(job, "one design for all scenarios")
    scenes, changes = variants_of(scene), scenarios_of(scene)
    _check(scene, scenes)
    scenes = {name: same_parts(scene, name, changes.get(name, {}), one) for name, one in scenes.items()}
    program = _merged(scenes)
    found, _ = best_of(program, scene, None, progress)
    if found.x is None:
        claim = f"{found.claim}; no one design was found that holds in all scenarios"
        reason = _reason(program, found.claim) if found.status == "infeasible" else ""
        return OneForAll(job, found.status, claim, None, {}, {}, reason)
    chosen = scene.named(found.x)
    limits = {name: dict(checked_limits(one, chosen)) for name, one in scenes.items()}
    broken = [f"{key} in {name}" for name, rows in limits.items() for key, row in rows.items() if not row.met]
    doubt = disagreement(*limits.values()) or (f"{', '.join(broken)} not met as measured" if broken else "")
    rows = [goal_row(one, chosen) for one in scenes.values()]
    worst = None
    if scene.goal is not None:
        pick = max if scene.goal.sense == "minimise" else min
        worst = (
            scene.goal.name,
            pick((row for row in rows if row is not None), key=lambda checked: checked.value.value).value,
        )
    status, values = "check_failed" if doubt else found.status, shown_values(scene, found.x)
    kept = None if doubt else bought(frozen(scene, found.x.tolist()), scene)
    return OneForAll(job, status, doubt or found.claim, worst, values, limits, kept=kept)


def _reason(program: Program, claim: str) -> str:
    """Which limits, in which scenarios, cannot hold together."""
    clashes = clashes_of(program, most=_PATIENCE)
    if not clashes.sets:
        return ""
    conflict = Conflict(clashes.sets[0], (), claim, (), clashes.sets[1:], clashes.complete, {}, clashes.doubtful)
    return " ".join([conflict.said(), *conflict.others_said()])


def _check(scene: Scene, scenes: Mapping[str, Scene]) -> None:
    if not scene.variables or scene.goal is None:
        raise InputError(
            f"{scene.name}: nothing is to be chosen, so there is no one design to find. vibopt compare FILE "
            "--scenarios measures each."
        )
    for name, one in scenes.items():
        if one.variables != scene.variables or open_places(one) or open_positions(one):
            raise InputError(
                f"{scene.name}: scenario {name} changes what may be chosen, or places are open, so there is no one "
                "design for all. vibopt compare FILE --scenarios answers each."
            )
        if uncertain(one):
            raise InputError(
                f"{scene.name}: one design for all scenarios does not go with tolerances: each scenario has a worst "
                f"machine of its own. {_without_tolerances(one)}, or vibopt compare FILE --scenarios."
            )


def _without_tolerances(scene: Scene) -> str:
    """What to change in the file, where tolerances may stand in a catalogue."""
    bought = as_printed(scene)
    own = [one for one in uncertain(scene) if not one.path.startswith(tuple(f"{name}." for name in bought))]
    said = ["leave the tolerances out"] if own else []
    said += [f'write tolerance = "0 %" into {" and ".join(bought)}, in place of the catalogue\'s'] if bought else []
    words = " and ".join(said)
    return words[:1].upper() + words[1:]


def _merged(scenes: Mapping[str, Scene]) -> Program:
    """All limits of all scenarios; the goal is the worst of all."""
    programs = {name: pose(scene) for name, scene in scenes.items()}
    first = programs[AS_IT_IS]
    limits = [
        limit if name == AS_IT_IS else replace(limit, name=f"{limit.name} in {name}")
        for name, program in programs.items()
        for limit in program.limits
    ]
    pieces: list[Aim] = [
        piece for program in programs.values() if program.aim is not None for piece in program.aim.pieces
    ]
    aim = replace(pieces[0], others=tuple(pieces[1:])) if first.aim is not None and not _alike(pieces) else first.aim
    return replace(first, limits=tuple(limits), aim=aim, several=True)


def _alike(pieces: list[Aim]) -> bool:
    """Whether the goal is of the variables alone, the same in all scenarios."""
    powers = [piece.form.powers for piece in pieces]
    first = powers[0]
    return first is not None and all(
        power is not None
        and power.scale.tolist() == first.scale.tolist()
        and power.exponents.tolist() == first.exponents.tolist()
        for power in powers
    )


@dataclass(frozen=True, slots=True)
class Stepped(Tabular):
    """The goal with one bound at a time moved by some parts.

    steps
        As asked: "-20 %", "+20 %".
    now
        Status and goal of the job as it is.
    rows
        Per bound its path and, for each step, the bound, the status and the goal; "refused" where no file may ask it.
    left
        Names of limits without a bound that a part could move.
    refused
        Why bounds were refused.
    """

    job: Job
    goal: str
    steps: tuple[str, ...]
    now: tuple[str, Entry | None]
    rows: tuple[tuple[str, tuple[tuple[str, str, Entry | None], ...]], ...]
    left: tuple[str, ...] = ()
    refused: tuple[str, ...] = ()

    @property
    def notes(self) -> tuple[str, ...]:
        """Which limits were not moved, and which steps are not asked."""
        way = "Only at_most and at_least that are above zero and no level in dB are moved by parts."
        left = (f"Not moved: {', '.join(self.left)}. {way}",) if self.left else ()
        return *left, *(f"Not asked: {one}" for one in self.refused)

    def table(self) -> list[dict[str, Any]]:
        """A row for each bound and step; the change of the goal as a part of what it is."""
        return [
            {
                "path": path, "step": step, "bound": bound, "status": status,
                "goal": None if goal is None else goal.value, "change": self.change(goal),
                "goal shown": None if goal is None else goal.shown,
            }
            for path, cells in self.rows for step, (bound, status, goal) in zip(self.steps, cells, strict=True)
        ]  # fmt: skip

    def change(self, goal: Entry | None) -> float | None:
        """By which part the goal changes."""
        now = self.now[1]
        return None if goal is None or now is None or not now.value else goal.value / now.value - 1.0

    def heading(self) -> tuple[str, ...]:
        """Title and what is moved."""
        return self.job.title, f"{self.goal} with one limit at a time moved by {', '.join(self.steps)}", *self.notes

    def as_said(self) -> dict[str, Any]:
        """The goal now, and the rows of the table."""
        now = {"status": self.now[0], "goal": self.now[1]}
        return {"goal": self.goal, "now": now, "rows": self.table(), "notes": list(self.notes)}


def stepped(job: Job, steps: tuple[str, ...], *, progress: Progress | None = None) -> Stepped:
    """The goal with every bound by itself moved by some parts, "-20 %".

    Raises
    ------
    InputError
        No goal to look at, no bound, or a step that is no part.
    """
    if not is_open(job) or not goal_word(job):
        raise InputError(f"{job.name}: --limits shows what each limit does to the goal, and there is none.")
    bounds = [
        fact for fact in facts(job)
        if fact.path.startswith("limits.") and fact.path.endswith((".at_most", ".at_least")) and fact.value > 0.0
        and fact.dimension != "level"
    ]  # fmt: skip
    if not bounds:
        raise InputError(
            f"{job.name}: has no limits with a bound to move. Add [limits.NAME] with an at_most. What caps and facts "
            "buy says vibopt whatif FILE."
        )
    moved = [(bound, bound.value * (1.0 + part_of(step))) for bound in bounds for step in steps]
    asked = [(bound.path, bound.now(value / bound.value)) for bound, value in moved]
    jobs: dict[tuple[str, str | float], Job] = {("", ""): job}
    refused: list[str] = []
    for path, text in asked:
        try:
            jobs[path, text] = with_changes(job, {path: text})
        except InputError as error:
            refused += [message.removeprefix(f"{job.name}: ") for message in error.messages]
    found = answers(list(jobs.values()), progress, "limits")
    seen = {
        one: (answer.status, goal_of(each, answer))
        for (one, each), answer in zip(jobs.items(), found, strict=True)
    }  # fmt: skip
    nothing: tuple[str, Entry | None] = ("refused", None)
    cells = [
        (shown_value(bound, value).shown, *seen.get(one, nothing))
        for one, (bound, value) in zip(asked, moved, strict=True)
    ]
    width = len(steps)
    rows = tuple((bound.path, tuple(cells[i * width : (i + 1) * width])) for i, bound in enumerate(bounds))
    names = {bound.path.split(".")[1] for bound in bounds}
    left = tuple(name for name in job.document["limits"] if name not in names)
    return Stepped(job, goal_word(job), steps, seen["", ""], rows, left, tuple(dict.fromkeys(refused)))


def part_of(step: str) -> float:
    """The part in "-20 %"; InputError where there is none."""
    part = part_in(step)
    if part is None or not part.sign or not part.times > 0.0 or part.share == 0.0:
        raise InputError(f'--limits "{step}" is no part of a bound. Write --limits "-20 %, +20 %".')
    return part.times - 1.0
