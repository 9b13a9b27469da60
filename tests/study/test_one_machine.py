"""Answers along a limit share one machine: they are those of machines posed anew, for less."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from vibopt.forms.form import by_differences
from vibopt.forms.rubbing import Rubbing
from vibopt.jobs import answer, facts, is_scene, open_job, with_changes
from vibopt.mechanics.slipping import Slipping
from vibopt.program.one_machine import one_machine
from vibopt.program.pose import pose
from vibopt.scene.open_places import open_places
from vibopt.scene.uncertain import uncertain
from vibopt.study.holding import Road
from vibopt.work import metered

PROBLEMS = Path(__file__).parent.parent.parent / "problems"


def _limit(job: Any) -> Any:
    return next(fact for fact in facts(job) if fact.path.startswith("limits."))


def test_what_was_measured_of_a_machine_is_not_measured_again_where_a_limit_alone_moves(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    job = open_job(PROBLEMS / "friction/rao_9_42_posed.toml")
    limit, looked = _limit(job), list[float]()
    measured = Rubbing.sizes

    def counted(self: Rubbing, *args: Any, **more: Any) -> Any:
        looked.append(1.0)
        return measured(self, *args, **more)

    monkeypatch.setattr(Rubbing, "sizes", counted)
    road, counts, values = Road(job, limit, None), list[int](), (1.1 * limit.value, 1.2 * limit.value)
    states = []
    for value in values:
        states.append(road(value))
        counts.append(len(looked))
        looked.clear()
    assert counts[1] < 0.5 * counts[0]
    alone = answer(with_changes(job, limit.changes(values[1])), explain=False, brief=True)
    assert alone.goal is not None
    assert (states[1].measure, states[1].x) == (alone.goal[1], alone.x)
    assert road.work == pytest.approx(2.0 * alone.work, rel=0.1)  # what is spared in time is counted all the same


def test_a_machine_is_shared_with_scenes_that_differ_in_bounds_alone() -> None:
    job = open_job(PROBLEMS / "isolation/rao_9_34.toml")
    looser = with_changes(job, {"limits.floor_force.at_most": "12 kN"})
    heavier = with_changes(job, {"bodies.press.mass": "301 kg"})
    with one_machine(job):
        here, other, third = pose(job), pose(looser), pose(heavier)
    assert other.model is here.model
    assert [limit.form is one.form for limit, one in zip(other.limits, here.limits, strict=True)] == [True] * 3
    assert other.limits[0].bound == pytest.approx(12e3)
    assert third.model is not here.model
    assert pose(looser).model is not here.model  # outside nothing is kept


def test_a_scene_with_a_structure_is_posed_anew() -> None:
    job = open_job(PROBLEMS / "absorbers/gallery_girder.toml")
    assert job.structures
    with one_machine(job):
        assert pose(job).model is not pose(job).model


def test_to_ask_again_for_what_friction_leaves_counts_as_the_same_work() -> None:
    program = pose(open_job(PROBLEMS / "friction/rao_9_42_posed.toml"))
    part, x, works = program.limits[0], np.array([500.0]), list[float]()
    for _ in range(2):
        with metered() as meter:
            part.worst(x)
        works.append(meter.done)
    assert works[0] > 0.0
    assert works[1] == works[0]


def test_differences_of_a_response_under_friction_are_measured_together_and_are_those_of_one_after_the_other(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    program = pose(open_job(PROBLEMS / "friction/rao_9_41_posed.toml"))
    assert program.aim is not None
    part, x, counts = program.aim, np.array([60e3, 700.0]), list[int]()
    greatest = Slipping.greatest

    def counted(self: Slipping, *given: Any) -> Any:
        counts.append(len(self.r))
        return greatest(self, *given)

    part.worst(x)
    monkeypatch.setattr(Slipping, "greatest", counted)
    [top] = part.extremes(x)
    assert len(counts) == 1  # seven designs beside each other
    [speed] = top.speeds
    assert isinstance(part.form, Rubbing)
    form = part.form
    alone = by_differences(lambda one: form.at(part.model, one, speed), x, 1e-5)
    assert top.slope == pytest.approx(alone, rel=1e-6)


def test_no_form_hangs_on_the_value_of_a_bound() -> None:
    """One file of each kind of limit that the problems ask is posed without the values, to the same measurements."""
    kinds = set[str]()
    for path in sorted(PROBLEMS.rglob("*.toml")):
        job = open_job(path)
        if not is_scene(job) or job.structures or job.rotors or open_places(job) or uncertain(job):
            continue
        fresh = {one.response for one in job.limits.values()} - kinds
        if not fresh:
            continue
        kinds |= fresh
        plain = pose(job)
        with one_machine(job):
            kept = pose(job)
        x = np.where(np.isfinite(plain.high), np.sqrt(np.maximum(plain.low, 1e-3) * np.minimum(plain.high, 1e9)), 1.0)
        for one, other in zip(plain.limits, kept.limits, strict=True):
            if one.form.cost(one.model) < 20.0:
                assert one.worst(x).value == other.worst(x).value
    assert len(kinds) > 20
