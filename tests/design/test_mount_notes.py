"""What a mount is given and nothing asks for is said, and which damping ratios a table shows."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import vibopt as vo
from vibopt.scene.read import from_dict


def skid(**limits: Any) -> dict[str, Any]:
    places = [[f"{x} m", f"{y} m", "0 m"] for x in (-0.5, 0.5) for y in (-0.4, 0.4)]
    mounts = {"between": ["skid", "ground"], "at": places, "stiffness": "1 MN/m", "shear_ratio": 0.6}
    return {
        "bodies": {
            "skid": {"mass": "800 kg", "motion": "space", "inertia": ["60 kg m2", "90 kg m2", "120 kg m2"]}
            | {"centre": ["0 m", "0 m", "0.4 m"]}
        },
        "mounts": {"feet": {**mounts, "rating": "1..3 kN"}},
        "measures": {"load": {"response": "static_load", "of": "feet"}},
        "limits": limits,
    }


def test_a_rating_that_no_limit_asks_for_is_said_to_bind_nothing() -> None:
    said = 'mounts.feet: its rating binds nothing. Add a limit with response = "static_load" and of = "feet".'
    assert said in vo.solve(from_dict(skid())).notes
    asked = vo.solve(from_dict(skid(load={"response": "static_load", "of": "feet"})))
    assert said not in asked.notes
    assert asked.status == "met"


@pytest.mark.parametrize("once", [False, True])
def test_a_gap_is_held_by_a_travel_in_time_too(once: bool) -> None:
    """What to add is what the loads of the file have an answer to."""
    document, response = skid(), "peak_travel" if once else "travel"
    document["mounts"]["feet"] |= {"gap": "9 mm", "damping": "9 kN s/m"}
    del document["mounts"]["feet"]["rating"]
    pulse = {"kind": "pulse", "shape": "half sine", "amplitude": "2 kN", "duration": "20 ms"}
    steady = {"kind": "force", "amplitude": "2 kN", "speed": "20 Hz"}
    document["excitations"] = {"shaker": {**(pulse if once else steady), "on": "skid", "direction": "z"}}
    said = f'mounts.feet: its gap binds nothing. Add a limit with response = "{response}" and of = "feet".'
    assert said in vo.solve(from_dict(document)).notes
    asked = vo.solve(from_dict({**document, "limits": {"room": {"response": response, "of": "feet"}}}))
    assert asked.status == "met"
    assert not any("binds nothing" in note for note in asked.notes)


@pytest.mark.parametrize("share", [0.0, 1.0])
def test_ratios_of_poles_that_are_not_those_of_the_table_are_told(share: float) -> None:
    """Damping that goes with the stiffness leaves modes as they are; all of it in one link does not."""
    m, k = np.diag([50.0, 5.0]), np.array([[216e3, -16e3], [-16e3, 16e3]])
    apart = np.array([[1.0, -1.0], [-1.0, 1.0]])
    c = 173.0 * apart if share else 1e-3 * k
    document = {
        "bodies": {"a": {"mass": "50 kg"}, "b": {"mass": "5 kg"}},
        "links": {
            "low": {"between": ["a", "ground"], "stiffness": "200 kN/m"} | ({} if share else {"damping": "200 N s/m"}),
            "up": {
                "between": ["b", "a"], "stiffness": "16 kN/m", "damping": "173 N s/m" if share else "16 N s/m"
            },
        },
        "limits": {"z": {"response": "damping_ratio", "at_least": 0.001}},
    }  # fmt: skip
    still = np.zeros((2, 2))
    poles = np.linalg.eigvals(np.block([[still, np.eye(2)], [-np.linalg.solve(m, k), -np.linalg.solve(m, c)]]))
    ratios = sorted(-one.real / abs(one) for one in poles if one.imag > 0.0)
    said = (
        "Tables show the damping ratio of each undamped mode. damping_ratio is asked of the poles, which damping makes "
        f"others here: {', '.join(f'{one:.3g}' for one in ratios)}."
    )
    answer = vo.solve(from_dict(document))
    assert (said in answer.notes) == bool(share)
    assert answer.limits["z"].value.value == pytest.approx(ratios[0], rel=1e-9)
    document["limits"] = {"d": {"response": "decay_rate", "at_least": "0.001 1/s"}}
    assert not any("undamped mode" in note for note in vo.solve(from_dict(document)).notes)
