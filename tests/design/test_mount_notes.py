"""What a mount is given and nothing asks for is said."""

from __future__ import annotations

from typing import Any

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
