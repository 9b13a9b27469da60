"""What `check` lets pass is answered: every response at every place, along and about every axis, on every motion."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from every_question import answerable, machine, questions
from refusals import refused
from vibopt.errors import InputError
from vibopt.mechanics.built import Course
from vibopt.responses import KINDS, HarmonicResponse
from vibopt.scene.read import from_dict
from vibopt.solve import solve
from vibopt.verify.as_built import machine_of


def dressed(question: dict[str, Any]) -> dict[str, Any]:
    """The question with its excitation and speed, where it speaks of vibration."""
    if not KINDS[question["response"]].harmonic:
        return question
    turns = {"disc", "shaft"} & {one for one in question.values() if isinstance(one, str)}
    return {**question, "due_to": ["torque" if turns else "shaker"], "at": "15 Hz"}


@pytest.mark.parametrize(("motion", "many"), [("space", 162), ("plane", 145), ("line", 114)])
def test_every_question_about_a_machine_is_answered_or_refused(motion: str, many: int) -> None:
    """All are asked in one file; those that a message names are taken out, and the file is then answered."""
    asked = {f"q{i}": dressed(one) for i, one in enumerate(questions(KINDS))}
    scene = answerable({**machine(motion, opened=False), "measures": asked})
    design = solve(scene, explain=False)
    assert design.status == "met"
    assert len(design.measures) == many, f"not {many} questions are answered; if new ones are, write how many above"
    assert not any(np.isnan(one.value.value) for one in design.measures.values())


@pytest.mark.slow
@pytest.mark.parametrize("motion", ["space", "plane", "line"])
def test_every_goal_of_a_machine_is_answered_or_refused(motion: str) -> None:
    count = 0
    for question in questions(KINDS):
        goal = dressed(question)
        goal = {"minimise": goal["response"], **{key: one for key, one in goal.items() if key != "response"}}
        try:
            scene = from_dict({**machine(motion, opened=True), "goal": goal})
        except InputError:
            continue
        assert solve(scene, explain=False).status in ("optimal", "feasible", "infeasible", "unproven", "unbounded")
        count += 1
    assert count > 60


def test_a_direction_of_the_force_through_a_link_is_refused() -> None:
    measure = {
        "response": "transmitted_force",
        "through": "girder",
        "direction": "z",
        "at": "15 Hz",
        "due_to": ["shaker"],
    }
    assert str(refused(from_dict, {**machine("space", opened=False), "measures": {"force": measure}})).endswith(
        "measures.force has a direction, but girder knows one line only. Remove direction."
    )


def test_an_axis_of_what_turns_about_one_is_refused() -> None:
    measure = {"response": "rotation", "of": "disc", "axis": "y", "at": "15 Hz", "due_to": ["torque"]}
    caught = refused(from_dict, {**machine("space", opened=False), "measures": {"turn": measure}})
    assert str(caught).endswith("measures.turn has an axis, but disc knows one axis only. Remove axis.")


def test_a_force_through_a_body_is_refused() -> None:
    measure = {
        "response": "transmitted_force",
        "through": "pump",
        "direction": "z",
        "at": "15 Hz",
        "due_to": ["shaker"],
    }
    assert str(refused(from_dict, {**machine("space", opened=False), "measures": {"force": measure}})).endswith(
        'measures.force.through = "pump" names no link or mount of this scene. Known: tmd, girder, shaft, foot, '
        "foot.1, foot.2, foot.3, foot.4, stay."
    )


def test_a_body_in_a_plane_moves_nothing_across_it() -> None:
    measure = {"response": "travel", "of": "foot", "direction": "y", "at": "15 Hz", "due_to": ["shaker"]}
    design = solve(from_dict({**machine("plane", opened=False), "measures": {"across": measure}}))
    assert design.measures["across"].value.value == 0.0


@pytest.mark.parametrize(
    "response",
    ["displacement", *(pytest.param(one, marks=pytest.mark.slow) for one in ("transmitted_force", "acceleration"))],
)
def test_a_decay_rate_beside_a_steady_goal_is_kept(response: str) -> None:
    place = {"into": "ground"} if response == "transmitted_force" else {"of": "m"}
    opened = {
        "stiffness": {"from": "1 kN/m", "to": "1 MN/m"},
        "damping": {"from": "1 N s/m", "to": "10 kN s/m"},
    }
    force = {"kind": "force", "on": "m", "amplitude": "30 N", "speed": "20 Hz", "varies": "constant"}
    document = {
        "title": "slow to die away",
        "bodies": {"m": {"mass": "20 kg"}},
        "links": {"s": {"between": ["m", "ground"], **opened}},
        "excitations": {"shaker": force},
        "limits": {"decay": {"response": "decay_rate", "at_least": "3 1/s"}},
        "goal": {"minimise": response, **place, "at": "20 Hz"},
    }
    design = solve(from_dict(document), explain=False)
    assert design.status in ("optimal", "feasible")
    k, c = (one.value.value for one in design.variables.values())
    poles = np.roots([20.0, c, k])
    assert -poles.real.max() >= 3.0 * (1.0 - 1e-8)


def test_what_is_read_in_time_is_what_is_read_of_a_vibration() -> None:
    """A course that goes to and fro at one frequency: `trace` and `measure` read the same off it."""
    kinds = {name: one for name, one in KINDS.items() if one.harmonic}
    asked = {f"q{i}": dressed(one) for i, one in enumerate(questions(kinds))}
    made = machine("line", opened=False)
    made["links"]["foot"] = {"between": ["pump", "floor"], "stiffness": "3.6 MN/m", "damping": "8 kN s/m"}
    scene = answerable({**made, "mounts": {}, "measures": asked})
    built, omega = machine_of(scene, {}), np.array([2.0 * np.pi * 15.0])
    motion = built.shake(omega, {"pump": np.array([3.0 - 1.0j]), "disc": np.array([0.4 + 2.0j])}, {})
    turned = np.array([1.0, 1.0j])  # now, and a quarter of a turn later
    rates = np.stack([omega**0, 1j * omega, -(omega**2)])
    course = Course(
        {name: (rates * one * turned).real for name, one in motion.points.items()},
        {name: (one * turned).real * np.ones(2) for name, one in motion.forces.items()},
    )
    followed = set()
    for response in scene.measures.values():
        assert isinstance(response, HarmonicResponse)
        if response.transient_twin or not response.against_friction:
            now, later = response.trace(built, course).tolist()
            read = complex(response.measure(built, motion)[0])
            assert complex(now, -later) == pytest.approx(read, rel=1e-9, abs=0.0), (
                f"{response.response}: trace and measure"
            )
            followed.add(response.response)
    assert {"displacement", "velocity", "transmitted_force", "relative_displacement"} <= followed
