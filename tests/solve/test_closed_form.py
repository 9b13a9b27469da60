"""One mass in closed form: what other methods prove, in whatever words the machine is written."""

from __future__ import annotations

import pytest

from texts import ANY_DAMPING, ANY_STIFFNESS, floor, moves, press
from vibopt.scene.read import from_text
from vibopt.scene.scene import Scene
from vibopt.solve.solve import solve

DAMPING = f"damping = {ANY_DAMPING}"
SPRING = '[links.spring]\nbetween = ["press", "ground"]\nstiffness = "200 kN/m"'
DAMPER = f'[links.damper]\nbetween = ["press", "ground"]\n{DAMPING}'
GOALS = ('maximise = "stiffness"', 'minimise = "stiffness"', 'maximise = "damping"', 'minimise = "damping"')


def pressed(own: str = DAMPING, more: str = "", varies: str = "constant", goal: str = GOALS[0], of: str = "") -> Scene:
    """A press on a mount of any stiffness, held while it starts and runs."""
    text = press(
        ANY_STIFFNESS, None, floor("10 kN", "force"), moves("press", "20 mm", "start_up", "start_up"),
        f'[goal]\n{goal}\nof = "{of or "mount"}"\n', name="press", varies=varies,
    )  # fmt: skip
    return from_text(text.replace("[excitations.press]", f"{own}\n{more}\n[excitations.press]"))


def goal_of(scene: Scene, method: str | None = None, name: str = "closed_form_kc") -> float:
    design = solve(scene, method=method)
    assert (design.status, design.method) == ("optimal", method or name)
    assert design.goal is not None
    return design.goal[1].value


@pytest.mark.parametrize("more", ["", SPRING], ids=["alone", "beside a spring"])
@pytest.mark.parametrize("goal", GOALS)
def test_the_closed_form_is_what_discs_prove(goal: str, more: str) -> None:
    scene = pressed(more=more, goal=goal)
    assert goal_of(scene) == pytest.approx(goal_of(scene, "discs"), rel=1e-9)


@pytest.mark.parametrize("goal", GOALS)
def test_a_mount_and_a_damper_beside_it_are_one_mount(goal: str) -> None:
    two = pressed("", DAMPER, goal=goal, of="mount" if "stiffness" in goal else "damper")
    assert goal_of(two) == pytest.approx(goal_of(pressed(goal=goal)), rel=1e-12)


@pytest.mark.parametrize("goal", GOALS[:3])
def test_a_straight_table_of_amplitudes_is_the_speed(goal: str) -> None:
    table = pressed(varies='[["0 rpm", 0.0], ["3000 rpm", 1.0]]', goal=goal)
    assert goal_of(table) == pytest.approx(goal_of(pressed(varies="speed", goal=goal)), rel=1e-9)


def test_one_variable_with_a_table_of_amplitudes_is_answered_by_its_power_too() -> None:
    table, power = (
        pressed("damping_ratio = 0.1", varies=one) for one in ('[["0 rpm", 0.0], ["3000 rpm", 1.0]]', "speed")
    )
    assert goal_of(table, name="closed_form") == pytest.approx(goal_of(power, name="closed_form"), rel=1e-9)
