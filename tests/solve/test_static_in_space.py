"""The softest mounts that sag or tilt no more than allowed, against the plain statics of a body on four mounts."""

from typing import Any

import numpy as np
import pytest

from vibopt.scene.read import from_dict
from vibopt.solve import solve

PLACES = np.array([[x, y, 0.0] for x in (0.5, -0.5) for y in (0.4, -0.4)])
CENTRE = np.array([0.1, 0.02, 0.3])
EYE = np.array([0.7, 0.0, 0.5])


def down(stiffness: float, shear: float) -> np.ndarray:
    """Displacement of the centre and turns under 600 kg, (6,)."""
    whole = np.zeros((6, 6))
    for x, y, z in PLACES - CENTRE:
        read = np.hstack([np.eye(3), np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])])
        whole += stiffness * read.T @ np.diag([shear, shear, 1.0]) @ read
    return np.linalg.solve(whole, np.array([0.0, 0.0, -600.0 * 9.80665, 0.0, 0.0, 0.0]))


@pytest.mark.parametrize("shear", [0.3, 0.5, 1.0])
@pytest.mark.parametrize(
    ("words", "bound"),
    [
        ({"response": "static_deflection", "of": "box"}, ("4 mm", 4e-3)),
        ({"response": "static_deflection", "of": "eye"}, ("4 mm", 4e-3)),
        ({"response": "tilt", "of": "box", "axis": "y"}, ("0.3 deg", np.deg2rad(0.3))),
    ],
    ids=["sag of the centre", "sag of a point", "tilt"],
)
def test_the_softest_mounts_that_will_do(words: dict[str, Any], bound: tuple[str, float], shear: float) -> None:
    document = {
        "bodies": {
            "box": {
                "mass": "600 kg",
                "centre": ["0.1 m", "0.02 m", "0.3 m"],
                "inertia": ["60 kg m2", "90 kg m2", "99 kg m2"],
            }
        },
        "points": {"eye": {"on": "box", "at": ["0.7 m", "0 m", "0.5 m"]}},
        "mounts": {
            "foot": {
                "between": ["box", "ground"],
                "at": [[f"{x} m", f"{y} m", f"{z} m"] for x, y, z in PLACES],
                "stiffness": {"from": "0.05 MN/m", "to": "9 MN/m"},
                "shear_ratio": shear,
            }
        },
        "limits": {"still": {**words, "at_most": bound[0]}},
        "goal": {"minimise": "stiffness", "of": "foot"},
    }
    design = solve(from_dict(document))
    once = down(1.0, shear)
    arm = (EYE if words["of"] == "eye" else CENTRE) - CENTRE
    moved = abs(once[4]) if words["response"] == "tilt" else abs(once[2] + once[3] * arm[1] - once[4] * arm[0])
    assert design.status == "optimal"
    assert design.x[0] == pytest.approx(moved / bound[1], rel=1e-6)
    assert design.limits["still"].met
