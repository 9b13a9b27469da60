"""A wider range never gives a worse answer: what the narrow one permits the wide one permits, too."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vibopt.program.pose import pose
from vibopt.scene.read import from_dict
from vibopt.solve.nlp import Nlp
from vibopt.solve.ranges import closed

MASS, OTHER, SPRING, UPPER, DASH, UPPER_DASH = 100.0, 60.0, 1e5, 8e4, 50.0, 20.0
ABSORBERS = (4.0, 6.0)


def two_absorbers(least: float, speeds: tuple[float, float], strokes: tuple[float, float]) -> dict[str, Any]:
    """Two limited absorbers on one of two bodies, damped by at least `least` [N s/m]; speeds [Hz], strokes [m]."""
    return {
        "bodies": {"a": {"mass": f"{MASS} kg"}, "b": {"mass": f"{OTHER} kg"}},
        "links": {
            "g": {"between": ["a", "ground"], "stiffness": f"{SPRING} N/m", "damping": f"{DASH} N s/m"},
            "h": {"between": ["b", "a"], "stiffness": f"{UPPER} N/m", "damping": f"{UPPER_DASH} N s/m"},
        },
        "absorbers": {
            f"t{i}": {
                "on": "a",
                "mass": f"{mass} kg",
                "frequency": {"from": "1 Hz", "to": "12 Hz"},
                "damping": {"from": f"{least} N s/m", "to": "100 N s/m"},
            }
            for i, mass in enumerate(ABSORBERS)
        },
        "excitations": {
            "f": {
                "kind": "force",
                "on": "a",
                "amplitude": "100 N",
                "speed": [f"{speed} Hz" for speed in speeds],
                "varies": "constant",
            }
        },
        "limits": {
            f"s{i}": {"response": "stroke", "of": f"t{i}", "at_most": f"{stroke} m"} for i, stroke in enumerate(strokes)
        },
        "goal": {"minimise": "displacement", "of": "a"},
    }


def motion(x: np.ndarray, speed: float) -> np.ndarray:
    """Peak motion of the host and peak strokes [m] at a speed [Hz], from the equations of motion written down."""
    w = 2.0 * np.pi * speed
    size = 2 + len(ABSORBERS)
    mass, upper, lower = np.diag([MASS, OTHER, *ABSORBERS]), UPPER + 1j * w * UPPER_DASH, SPRING + 1j * w * DASH
    table = -(w**2) * mass.astype(complex)
    table[0, 0] += lower
    for place, link in [(1, upper)] + [
        (2 + i, m * x[2 * i] ** 2 + 1j * w * x[2 * i + 1]) for i, m in enumerate(ABSORBERS)
    ]:
        arm = np.zeros(size)
        arm[[0, place]] = 1.0, -1.0
        table += link * np.outer(arm, arm)
    moved = np.linalg.solve(table, np.eye(size)[0] * 100.0)
    return np.abs(np.array([moved[0], *(moved[2:] - moved[0])]))


def found(least: float, speeds: tuple[float, float], strokes: tuple[float, float]) -> float:
    """Goal found, confirmed; infinite where nothing is."""
    answer = Nlp().solve(closed(pose(from_dict(two_absorbers(least, speeds, strokes)))))
    if answer.x is None:
        return np.inf
    worst = np.max([motion(answer.x, speed) for speed in speeds], axis=0)
    assert (worst[1:] <= np.array(strokes) * (1.0 + 1e-8)).all()
    return float(worst[0])


@pytest.mark.slow
def test_damping_from_nothing_is_no_worse_than_from_a_little() -> None:
    """Without the limits on strokes the least motion is none at all, of undamped absorbers: starts are drawn there."""
    best = np.array([19.5133315, 18.2517026, 11.8662936, 91.2585154])
    known = max(motion(best, speed)[0] for speed in (3.5, 6.0))
    assert found(0.0, (3.5, 6.0), (0.03, 0.009)) == pytest.approx(known, rel=1e-7)


@pytest.mark.slow
@settings(max_examples=20)
@given(
    first=st.floats(2.5, 4.5),
    second=st.floats(4.8, 8.0),
    parts=st.tuples(st.floats(0.5, 0.95), st.floats(0.5, 0.95)),
    least=st.sampled_from([0.1, 1.0, 10.0]),
)
def test_a_wider_range_of_damping_is_no_worse(
    first: float, second: float, parts: tuple[float, float], least: float
) -> None:
    """Strokes are limited to parts of what the undamped absorbers need that hold the host at rest."""
    speeds = (round(first, 2), round(second, 2))
    needs = 100.0 / (np.array(ABSORBERS) * (2.0 * np.pi * np.array(speeds)) ** 2)
    strokes = parts[0] * float(needs[0]), parts[1] * float(needs[1])
    assert found(0.0, speeds, strokes) <= found(least, speeds, strokes) * (1.0 + 1e-6)
