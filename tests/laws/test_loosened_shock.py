"""What loosens a mount that is dropped: as closed forms of one mass say, and without a search where it is proven."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

import vibopt as vo

SPEED = 1.5
"""By which the velocity of the base changes [m/s]."""


def product(ratio: float) -> float:
    """Greatest stretch times greatest acceleration of a mass behind a change of velocity, over its square."""
    turn = np.sqrt(1.0 - ratio**2)
    angles = np.linspace(0.0, np.pi, 200_001)
    faded = np.exp(-ratio * angles / turn)
    across = faded * np.sin(angles) / turn
    felt = 2.0 * ratio * faded * (np.cos(angles) - ratio / turn * np.sin(angles)) + across
    return float(across.max() * np.abs(felt).max())


LEAST = float(minimize_scalar(product, bounds=(0.2, 0.7), method="bounded", options={"xatol": 1e-9}).fun)


@pytest.mark.parametrize(("room", "felt"), [(0.02, 30.0), (0.05, 20.0)])
def test_limits_of_a_dropped_mount_are_loosened_to_the_best_spring_and_damper(
    room: float, felt: float, monkeypatch: Any
) -> None:
    module, asked = importlib.import_module("vibopt.solve.solve"), []
    solve = module.solve

    def counted(*scenes: Any, **given: Any) -> Any:
        asked.append(scenes)
        return solve(*scenes, **given)

    monkeypatch.setattr(module, "solve", counted)
    document = {
        "title": "a unit that is dropped",
        "bases": {"base": {}},
        "bodies": {"unit": {"mass": "10 kg"}},
        "links": {
            "mount": {
                "between": ["unit", "base"],
                "stiffness": {"from": "1 kN/m", "to": "1 MN/m"},
                "damping": {"from": "10 N s/m", "to": "10 kN s/m"},
            }
        },
        "excitations": {"fall": {"kind": "drop", "on": "base", "velocity_change": f"{SPEED} m/s"}},
        "limits": {
            "room": {"response": "peak_relative_displacement", "across": "mount", "at_most": f"{room} m"},
            "felt": {"response": "peak_acceleration", "of": "unit", "at_most": f"{felt} m/s²"},
        },
        "goal": {"minimise": "stiffness", "of": "mount"},
    }
    answer = vo.solve(vo.from_dict(document))
    assert answer.status == "infeasible"
    assert answer.conflict is not None
    assert answer.conflict.limits == ("room", "felt")
    found = {name: enough.value for name, _, enough in answer.conflict.loosenings}
    for name, given, other in (("room", room, felt), ("felt", felt, room)):
        right = LEAST * SPEED**2 / other
        assert right * (1.0 - 1e-6) <= found[name] <= right + 0.0102 * (right - given)
    assert len(asked) <= 2 * len(found)
