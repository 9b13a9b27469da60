"""Strokes that no spring and damper can change."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import vibopt as vo
from vibopt.program.pose import pose
from vibopt.scene.read import from_dict
from vibopt.solve.plane.invariant_points import hopeless
from vibopt.solve.ranges import closed


def absorber(mu: float, stroke: float, *, low: float = 1.0, damping: float = 0.0) -> dict[str, Any]:
    """A mass with a static deflection of 10 mm and an absorber whose stroke is limited [m]."""
    return {
        "bodies": {"machine": {"mass": "100 kg"}},
        "links": {"spring": {"between": ["ground", "machine"], "stiffness": "100 kN/m", "damping_ratio": damping}},
        "absorbers": {
            "tmd": {
                "on": "machine",
                "mass_ratio": mu,
                "tuning": {"from": 0.3, "to": 3.0},
                "damping_ratio": {"from": 0.001, "to": 5.0},
            }
        },
        "excitations": {
            "shake": {"kind": "force", "on": "machine", "amplitude": "1 kN", "varies": "constant"}
            | {"speed": f"{low}..100 rad/s"}
        },
        "limits": {"travel": {"response": "stroke", "of": "tmd", "at_most": f"{stroke:.12g} m"}},
        "goal": {"minimise": "displacement", "of": "machine"},
    }


@settings(max_examples=30, deadline=None)
@given(mu=st.floats(0.005, 1.0), part=st.floats(0.2, 0.999))
def test_the_stroke_at_the_locked_resonance_is_known_whatever_the_absorber(mu: float, part: float) -> None:
    fixed = 0.01 * (1.0 + mu) / mu
    found = hopeless(closed(pose(from_dict(absorber(mu, part * fixed)))))
    assert found is not None
    assert found.value == pytest.approx(fixed, rel=1e-9)
    assert found.speed == pytest.approx(np.sqrt(1000.0 / (1.0 + mu)), rel=1e-9)


def test_it_holds_only_where_that_speed_is_in_the_range_and_nothing_else_damps() -> None:
    assert hopeless(closed(pose(from_dict(absorber(0.05, 0.22))))) is None
    assert hopeless(closed(pose(from_dict(absorber(0.05, 0.15, low=32.0))))) is None
    assert hopeless(closed(pose(from_dict(absorber(0.05, 0.15, damping=0.01))))) is None


def test_the_reason_is_said_with_the_speed_and_the_value() -> None:
    design = vo.solve(from_dict(absorber(0.05, 0.15)))
    assert design.status == "infeasible"
    assert design.reason == (
        "At 30.86 rad/s travel is 0.21 m pk, whatever the spring and the damper; at most 0.15 m pk is asked. "
        "Only a wider limit, another mass, or a range of speeds without this one can help."
    )
