"""A step and a steady force, the greatest of each added up: where at least so much is asked, and speed by speed."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import vibopt as vo

M, C, STEP, PUSH = 100.0, 1000.0, 500.0, 100.0
SPEEDS = np.linspace(10.0 * np.pi, 80.0 * np.pi, 200_001)


def asked(stiffness: Any, speed: Any, combine: str, bound: dict[str, str], goal: dict[str, str]) -> Any:
    return vo.solve(
        vo.from_dict({
            "title": "step and steady force",
            "bodies": {"m": {"mass": f"{M} kg"}},
            "links": {"k": {"between": ["m", "ground"], "stiffness": stiffness, "damping": f"{C} N s/m"}},
            "excitations": {
                "blow": {"kind": "pulse", "on": "m", "shape": "step", "amplitude": f"{STEP} N"},
                "push": {"kind": "force", "on": "m", "amplitude": f"{PUSH} N", "speed": speed, "varies": "constant"},
            },
            "limits": {"moves": {"response": "peak_displacement", "of": "m", "combine": combine, **bound}},
            "goal": goal,
        })
    )  # fmt: skip


def added(k: float, combine: str) -> Any:
    """In closed form, at every speed [m]."""
    zeta = C / (2.0 * np.sqrt(k * M))
    once = STEP / k * (1.0 + np.exp(-np.pi * zeta / np.sqrt(1.0 - zeta**2)))
    steady = PUSH / np.hypot(k - M * SPEEDS**2, C * SPEEDS)
    return np.hypot(once, steady) if combine == "rss" else once + steady


@pytest.mark.parametrize("combine", ["sum", "rss"])
def test_at_least_so_much_is_asked_of_the_greatest_over_the_speeds(combine: str) -> None:
    bound = {"at_least": f"{float(added(4e5, combine).max())!r} m"}
    answer = asked(
        {"from": "100 kN/m", "to": "1 MN/m"}, "5..40 Hz", combine, bound, {"maximise": "stiffness", "of": "k"}
    )
    assert answer.goal[1].value == pytest.approx(4e5, rel=1e-6)


@pytest.mark.parametrize("side", ["at_most", "at_least"])
@pytest.mark.parametrize("combine", ["sum", "rss"])
def test_speeds_are_found_at_which_a_sum_of_the_greatest_keeps_its_bound(combine: str, side: str) -> None:
    values = added(1e6, combine)
    bound = float(values.min() + 0.3 * np.ptp(values))
    answer = asked(
        "1 MN/m", {"from": "5 Hz", "to": "40 Hz"}, combine, {side: f"{bound!r} m"}, {"find_all": "push.speed"}
    )
    good = values <= bound if side == "at_most" else values >= bound
    inside = np.zeros(len(SPEEDS), dtype=bool)
    for low, high in answer.found:
        inside |= (low.value <= SPEEDS) & (high.value >= SPEEDS)
    assert good.any()
    assert not good.all()
    assert np.array_equal(good[1:-1], inside[1:-1])
