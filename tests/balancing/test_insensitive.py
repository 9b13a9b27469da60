"""Planes of which nothing is known, grades that nobody can know, and the goal of a robust plan."""

from __future__ import annotations

import re

import numpy as np
import pytest

from rotor_jobs import FAN, solve_text

SCATTER = 'scatter = { amplitude = "5 %", angle = "2 deg" }\n'
AS_FOUND = 'readings = { a = "8.6 mil @ 63 deg", b = "6.5 mil @ 206 deg" }'
LEFT = 'readings = { a = "5.9 mil @ 123 deg", b = "4.5 mil @ 228 deg" }'


def test_a_plane_whose_trial_changed_nothing_gets_no_weight() -> None:
    text = FAN.replace(LEFT, AS_FOUND)
    plan = solve_text(text)
    left = next(one for one in plan.plan.planes if one.name == "left")
    assert not left.weights
    assert plan.status == "optimal"
    assert any(note.startswith("No sensor feels a weight in plane left") for note in plan.notes)


def test_least_correction_puts_nothing_where_nothing_is_felt() -> None:
    """A grid over the right plane alone is the second route."""
    text = FAN.replace(LEFT, AS_FOUND) + (
        '[goal]\nminimise = "correction"\n[limits.all]\nresponse = "residual"\nat_most = "6 mil"\n'
    )
    plan = solve_text(text)
    right = next(one for one in plan.plan.planes if one.name == "right")
    y0 = np.array([8.6 * np.exp(-1j * np.radians(63)), 6.5 * np.exp(-1j * np.radians(206))])
    y1 = np.array([6.2 * np.exp(-1j * np.radians(36)), 10.4 * np.exp(-1j * np.radians(162))])
    h = (y1 - y0) / (12.0 * np.exp(-1j * np.radians(180.0)))
    size, angle = np.meshgrid(np.linspace(0.0, 20.0, 801), np.radians(np.linspace(0.0, 360.0, 1441)))
    u = (size * np.exp(-1j * angle)).ravel()
    good = (np.abs(y0[:, None] + h[:, None] * u) <= 6.0).all(axis=0)
    assert float(right.mass.value) * 1e3 == pytest.approx(float(np.abs(u[good]).min()), abs=0.03)


def test_a_change_within_the_scatter_is_none() -> None:
    moved = 'readings = { a = "8.6 mil @ 63.1 deg", b = "6.5 mil @ 206 deg" }'
    text = re.sub(r"(title = .*\n)", r"\1" + SCATTER, FAN.replace(LEFT, moved))
    plan = solve_text(text)
    assert not next(one for one in plan.plan.planes if one.name == "left").weights


@pytest.mark.parametrize("robust", ["worst", "mean"])
def test_the_goal_of_a_robust_plan_is_its_own(robust: str) -> None:
    goal = f'[goal]\nminimise = "residual"\nrobust = "{robust}"\n'
    text = re.sub(r"(title = .*\n)", r"\1" + SCATTER, FAN) + goal
    plan = solve_text(text)
    name, value = plan.goal if plan.goal is not None else ("", None)
    assert "scatter" in name
    assert value is not None
    assert float(value.value) > 1e-6


@pytest.mark.parametrize("scatter", ["0.01 mil", "0.3 mil", "1 mil", "3 mil", "5 mil", "3 mm"])
def test_a_greater_scatter_may_leave_a_limit_open_but_never_makes_it_impossible(scatter: str) -> None:
    text = re.sub(r"(title = .*\n)", rf'\1scatter = {{ amplitude = "{scatter}", angle = "2 deg" }}\n', FAN)
    plan = solve_text(text + '[limits.running]\nresponse = "residual"\nat_most = "2 mil"\n')
    assert plan.status in ("optimal", "unproven")
    assert plan.status == "unproven" or not any(note.startswith("No sensor feels") for note in plan.notes)


def test_an_open_answer_names_the_planes_that_may_act() -> None:
    text = re.sub(r"(title = .*\n)", r'\1scatter = { amplitude = "3 mm", angle = "2 deg" }\n', FAN)
    plan = solve_text(text + '[limits.running]\nresponse = "residual"\nat_most = "2 mil"\n')
    assert (plan.status, plan.exit_code, plan.reason) == ("unproven", 5, "")
    assert plan.claim == (
        "without weights in left and right, which act within the scatter of the readings, the limits cannot be kept"
    )


def test_a_plane_that_changed_nothing_at_all_leaves_the_impossible_impossible() -> None:
    text = re.sub(r"(title = .*\n)", r"\1" + SCATTER, FAN.replace(LEFT, AS_FOUND))
    plan = solve_text(text + '[limits.running]\nresponse = "residual"\nat_most = "0.01 mil"\n')
    assert plan.status == "infeasible"
    assert any(note.startswith("No sensor feels a weight in plane left") for note in plan.notes)
