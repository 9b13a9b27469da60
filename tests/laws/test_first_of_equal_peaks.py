"""Of peaks that are equally high the first is told, whatever rounding makes of the later ones."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import vibopt as vo

LOADS: dict[str, tuple[dict[str, str], float]] = {
    "struck": ({"kind": "drop", "on": "base", "velocity_change": "1 m/s"}, 0.25),
    "let go": ({"kind": "release", "on": "mass", "velocity": "1 m/s"}, 0.25),
    "loaded": ({"kind": "pulse", "shape": "step", "on": "mass", "amplitude": "3 N"}, 0.5),
    "pushed": ({"kind": "pulse", "shape": "rectangle", "on": "mass", "amplitude": "3 N"}, 0.5),
}
"""What comes over an undamped mass, and the part of its period at which it is displaced most."""


@given(load=st.sampled_from(sorted(LOADS)), mass=st.floats(0.05, 150.0), rate=st.floats(1.0, 400.0))
@settings(derandomize=True, database=None, deadline=None)
def test_the_first_of_equal_peaks_of_an_undamped_mass_is_told(load: str, mass: float, rate: float) -> None:
    period = 2.0 * np.pi / rate
    (given_load, part), place = LOADS[load], "base" if load == "struck" else "ground"
    lasts: dict[str, Any] = {"duration": f"{5.3 * period!r} s"} if load == "pushed" else {}
    document = {
        "title": "a mass on a spring",
        "bodies": {"mass": {"mass": f"{mass!r} kg"}},
        "bases": {"base": {}} if place == "base" else {},
        "links": {"spring": {"between": ["mass", place], "stiffness": f"{mass * rate**2!r} N/m"}},
        "excitations": {"load": given_load | lasts},
        "measures": {
            "room": {"response": "peak_relative_displacement", "across": "spring"},
            "force": {"response": "peak_force", "through": "spring"},
        },
    }
    answer = vo.solve(vo.from_dict(document))
    for row in answer.measures.values():
        assert row.worst_at["load"].value == pytest.approx(part * period, rel=1e-4)
