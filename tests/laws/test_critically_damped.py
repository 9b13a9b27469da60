"""A mass at exactly critical damping, where both of its poles are one but for rounding, against integrals."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.integrate import cumulative_simpson

import vibopt as vo

SIZE = 4.0
SHAPES: dict[str, Callable[[Any], Any]] = {
    "rectangle": lambda part: np.ones(part.shape),
    "falling sawtooth": lambda part: 1.0 - part,
    "half sine": lambda part: np.sin(np.pi * part),
    "versed sine": lambda part: np.sin(np.pi * part) ** 2,
    "sine": lambda part: np.sin(2.0 * np.pi * part),
}


def stretch(rate: float, shape: str, duration: float) -> float:
    """Greatest size of x with (d/dt + rate)^2 x = - signal, from rest, over the pulse and what rings on behind it."""
    most, x, y = 0.0, 0.0, 0.0
    for length, signal in ((duration, SHAPES[shape]), (12.0 / rate, lambda part: 0.0 * part)):
        times = np.linspace(0.0, length, 40_001)
        grown = np.exp(rate * (times - length))
        first = (y * grown[0] - cumulative_simpson(SIZE * signal(times / length) * grown, x=times, initial=0.0)) / grown
        second = (x * grown[0] + cumulative_simpson(first * grown, x=times, initial=0.0)) / grown
        most, x, y = max(most, float(np.abs(second).max())), float(second[-1]), float(first[-1])
    return most


@given(
    shape=st.sampled_from(sorted(SHAPES)),
    mass=st.floats(0.1, 400.0),
    rate=st.floats(3.0, 400.0),
    turns=st.floats(0.2, 2.5),
)
@example(shape="sine", mass=102.1635081427573, rate=34.37735, turns=0.5)
@example(shape="rectangle", mass=9.0, rate=51.3, turns=0.4)
@settings(derandomize=True, database=None, deadline=None)
def test_a_critically_damped_mass_is_answered_by_both_routes(
    shape: str, mass: float, rate: float, turns: float
) -> None:
    duration, stiffness = turns * 2.0 * np.pi / rate, mass * rate**2
    document = {
        "title": "critically damped",
        "bases": {"base": {}},
        "bodies": {"unit": {"mass": f"{mass!r} kg"}},
        "links": {
            "mount": {
                "between": ["unit", "base"],
                "stiffness": f"{stiffness!r} N/m",
                "damping": f"{2.0 * float(np.sqrt(stiffness * mass))!r} N s/m",
            }
        },
        "excitations": {
            "blow": {"kind": "pulse", "on": "base", "shape": shape, "acceleration": f"{SIZE} m/s²",
                     "duration": f"{duration!r} s"}
        },
        "measures": {"room": {"response": "peak_relative_displacement", "across": "mount"}},
    }  # fmt: skip
    answer = vo.solve(vo.from_dict(document))
    assert answer.status == "met", answer.claim
    assert answer.measures["room"].value.value == pytest.approx(stretch(rate, shape, duration), rel=1e-6)
