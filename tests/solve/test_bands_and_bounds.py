"""A bound beside `outside` in one limit is the same as in a limit of its own, wherever something is asked or told."""

from __future__ import annotations

import math
from collections.abc import Sequence

import pytest

import vibopt as vo
from vibopt.answer.entry import Entry
from vibopt.study.scenarios import stepped

ONE_MASS = """
[bodies.box]
mass = "40 kg"
[links.foot]
between = ["box", "ground"]
stiffness = { from = "10 kN/m", to = "20 MN/m" }
"""
CHAIN = """
[bodies.box]
mass = "40 kg"
[bodies.top]
mass = "10 kg"
[links.foot]
between = ["box", "ground"]
stiffness = { from = "10 kN/m", to = "20 MN/m" }
[links.between]
between = ["top", "box"]
stiffness = "2 MN/m"
"""
SHAFT = """
[rotors.shaft]
modulus = "207 GPa"
density = "7850 kg/m3"
sections = [{ length = "800 mm", diameter = { from = "30 mm", to = "70 mm" } }]
stations = { left = "0 mm", right = "800 mm" }
discs = [{ name = "wheel", at = "300 mm", mass = "30 kg", diametral = "0.3 kg m2", polar = "0.5 kg m2" }]
[links.a]
between = ["left", "ground"]
stiffness = "20 MN/m"
[links.b]
between = ["right", "ground"]
stiffness = "20 MN/m"
"""
FOOT = "links.foot.stiffness"
BOUNDS = {"at_least": "10 Hz", "at_most": "60 Hz"}
CASES = {
    "one mass": (ONE_MASS, "natural_frequency", "20..30 Hz", BOUNDS, FOOT, "stiffness", 'of = "foot"'),
    "a chain": (CHAIN, "natural_frequency", "20..30 Hz", BOUNDS, FOOT, "stiffness", 'of = "foot"'),
    "a shaft": (SHAFT, "critical_speed", "2000..3000 rpm", {"at_least": "1700 rpm", "at_most": "4200 rpm"},
                "rotors.shaft.sections.1.diameter", "total_mass", ""),
}  # fmt: skip


def _scene(case: str, goal: str, *, apart: bool, mass: str = '"40 kg"') -> vo.Scene:
    machine, response, bands, bounds, path, what, of = CASES[case]
    head, goal_text = f'[limits.{{}}]\nresponse = "{response}"\n', f'[goal]\n{goal} = "{what}"\n{of}\n'
    words = [f'outside = "{bands}"\n', *(f'{key} = "{value}"\n' for key, value in bounds.items())]
    limits = [head.format(i) + one for i, one in enumerate(words)] if apart else [head.format(0) + "".join(words)]
    if goal == "find_all":
        goal_text = f'[goal]\nfind_all = "{path}"\n'
    return vo.from_text(machine.replace('"40 kg"', mass) + "".join(limits) + goal_text)


def _ends(intervals: Sequence[tuple[Entry, Entry]]) -> list[float]:
    return [end.value for each in intervals for end in each]


def _pair(case: str, goal: str = "minimise") -> tuple[vo.Scene, vo.Scene]:
    return _scene(case, goal, apart=False), _scene(case, goal, apart=True)


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("goal", ["minimise", "maximise"])
def test_best_is_that_of_limits_apart(case: str, goal: str) -> None:
    one, other = (vo.solve(scene) for scene in _pair(case, goal))
    assert one.status == other.status == "optimal"
    assert one.x == pytest.approx(other.x, rel=1e-6)
    assert sorted(row.margin for row in one.limits.values()) == pytest.approx(
        sorted(row.margin for row in other.limits.values()), abs=1e-6
    )


@pytest.mark.parametrize("case", CASES)
def test_every_value_is_that_of_limits_apart(case: str) -> None:
    one, other = (_ends(vo.solve(scene).found or ()) for scene in _pair(case, "find_all"))
    assert one
    assert one == pytest.approx(other, rel=1e-9)


def test_all_values_of_one_mass_are_those_of_the_closed_form() -> None:
    """A frequency f [Hz] takes (2 pi f)^2 m."""
    design = vo.solve(_scene("one mass", "find_all", apart=False))
    ends = [(2.0 * math.pi * f) ** 2 * 40.0 for f in (10.0, 20.0, 30.0, 60.0)]
    assert design.status == "met"
    assert _ends(design.found or ()) == pytest.approx(ends, rel=1e-8)


@pytest.mark.parametrize("case", ["one mass", "a chain"])
def test_windows_are_those_of_limits_apart(case: str) -> None:
    one, other = (vo.window(scene) for scene in _pair(case))
    (found,), (known,) = ([_ends(span.intervals) for span in each.spans] for each in (one, other))
    assert len(found) == 4
    assert found == pytest.approx(known, rel=1e-6)


def test_sweeps_changes_and_limits_in_steps_are_those_of_limits_apart() -> None:
    goals = []
    for scene, name in zip(_pair("one mass"), ("limits.0.at_least", "limits.1.at_least"), strict=True):
        swept = [point.goal.value for point in vo.sweep(scene, "bodies.box.mass", "30..50 kg", 3).points]
        changed = vo.whatif(scene, {name: "12 Hz"}).after.goal
        steps = dict(stepped(scene, ("-10 %", "+10 %")).rows)[name]
        goals.append([*swept, changed[1].value, *(goal.value for _, _, goal in steps)])
    own = [(2.0 * math.pi * f) ** 2 * m for f, m in ((10, 30), (10, 40), (10, 50), (12, 40), (9, 40), (11, 40))]
    assert goals[0] == pytest.approx(goals[1], rel=1e-6)
    assert goals[0] == pytest.approx(own, rel=1e-5)


def test_over_tolerances_the_worst_machine_of_each_bound_counts() -> None:
    """The frequency is least of a mass that is 5 % heavier."""
    design = vo.solve(_scene("one mass", "minimise", apart=False, mass='{ value = "40 kg", tolerance = "5 %" }'))
    assert design.status == "optimal"
    assert design.x[0] == pytest.approx((2.0 * math.pi * 10.0) ** 2 * 42.0, rel=1e-6)


def test_a_damped_critical_speed_keeps_out_of_bands_over_tolerances() -> None:
    text = SHAFT.replace('"30 kg"', '{ value = "30 kg", tolerance = "2 %" }').replace(
        '{ from = "30 mm", to = "70 mm" }', '"50 mm"'
    )
    limit = '[limits.cs]\nresponse = "critical_speed"\ndamped = true\noutside = "2000..3000 rpm"\n'
    design = vo.solve(vo.from_text(text + limit))
    assert design.status == "met"
    assert [row.side for row in design.limits.values()] == ["outside"]
