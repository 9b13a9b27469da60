"""One mass in closed form: what other methods prove, in whatever words the machine is written."""

from __future__ import annotations

import pytest

from vibopt.scene.read import from_text
from vibopt.scene.scene import Scene
from vibopt.solve.solve import solve

DAMPING = 'damping = { from = "10 N s/m", to = "1 MN s/m" }'
SPRING = '[links.spring]\nbetween = ["press", "ground"]\nstiffness = "200 kN/m"'
DAMPER = f'[links.damper]\nbetween = ["press", "ground"]\n{DAMPING}'
GOALS = ('maximise = "stiffness"', 'minimise = "stiffness"', 'maximise = "damping"', 'minimise = "damping"')


def press(own: str = DAMPING, more: str = "", varies: str = '"constant"', goal: str = GOALS[0], of: str = "") -> Scene:
    """A press on a mount of any stiffness, held while it starts and runs."""
    return from_text(f"""
[bodies.press]
mass = "300 kg"
[links.mount]
between = ["press", "ground"]
stiffness = {{ from = "10 kN/m", to = "1 GN/m" }}
{own}
{more}
[excitations.press]
kind = "force"
on = "press"
amplitude = "30 kN"
speed = "3000 rpm"
varies = {varies}
[limits.force]
response = "transmitted_force"
into = "ground"
at_most = "10 kN"
[limits.start_up]
response = "displacement"
of = "press"
over = "start_up"
at_most = "20 mm"
[goal]
{goal}
of = "{of or "mount"}"
""")


def goal_of(scene: Scene, method: str | None = None, name: str = "closed_form_kc") -> float:
    design = solve(scene, method=method)
    assert (design.status, design.method) == ("optimal", method or name)
    assert design.goal is not None
    return design.goal[1].value


@pytest.mark.parametrize("more", ["", SPRING], ids=["alone", "beside a spring"])
@pytest.mark.parametrize("goal", GOALS)
def test_the_closed_form_is_what_discs_prove(goal: str, more: str) -> None:
    scene = press(more=more, goal=goal)
    assert goal_of(scene) == pytest.approx(goal_of(scene, "discs"), rel=1e-9)


@pytest.mark.parametrize("goal", GOALS)
def test_a_mount_and_a_damper_beside_it_are_one_mount(goal: str) -> None:
    two = press("", DAMPER, goal=goal, of="mount" if "stiffness" in goal else "damper")
    assert goal_of(two) == pytest.approx(goal_of(press(goal=goal)), rel=1e-12)


@pytest.mark.parametrize("goal", GOALS[:3])
def test_a_straight_table_of_amplitudes_is_the_speed(goal: str) -> None:
    table = press(varies='[["0 rpm", 0.0], ["3000 rpm", 1.0]]', goal=goal)
    assert goal_of(table) == pytest.approx(goal_of(press(varies='"speed"', goal=goal)), rel=1e-9)


def test_one_variable_with_a_table_of_amplitudes_is_answered_by_its_power_too() -> None:
    table, power = (
        press("damping_ratio = 0.1", varies=one) for one in ('[["0 rpm", 0.0], ["3000 rpm", 1.0]]', '"speed"')
    )
    assert goal_of(table, name="closed_form") == pytest.approx(goal_of(power, name="closed_form"), rel=1e-9)
