"""Shafts, discs and beams: the form of the optimiser, the built machine, and handbook formulas."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from vibopt.program.pose import pose
from vibopt.scene.read import from_dict
from vibopt.verify.certify import measure

E, L, AREA = 207e9, 2.0, 80e-8
BEAMS = {
    "middle": ({"kind": "simply_supported"}, 48.0 * E * AREA / L**3),
    "tip": ({"kind": "cantilever"}, 3.0 * E * AREA / L**3),
    "both ends held": ({"kind": "fixed"}, 192.0 * E * AREA / L**3),
    "one end pinned": ({"kind": "fixed_pinned"}, 768.0 * E * AREA / (7.0 * L**3)),
    "off centre": ({"kind": "simply_supported", "at": "0.5 m"}, 3.0 * E * AREA * L / (0.5 * 1.5) ** 2),
    "short of the tip": ({"kind": "cantilever", "at": "0.5 m"}, 3.0 * E * AREA / 0.5**3),
    "overhung": ({"kind": "overhung", "at_ratio": 1.25}, 3.0 * E * AREA / (0.5**2 * 2.5)),
}
BENT = {
    "middle": ({"kind": "simply_supported"}, 0.25),
    "off centre": ({"kind": "simply_supported", "at_ratio": 0.2}, 0.16),
    "tip": ({"kind": "cantilever"}, 1.0),
    "short of the tip": ({"kind": "cantilever", "at_ratio": 0.3}, 0.3),
    "both ends held": ({"kind": "fixed"}, 0.125),
    "both ends held, off centre": ({"kind": "fixed", "at_ratio": 0.25}, 0.25 * 0.75**2),
    "both ends held, near the right": ({"kind": "fixed", "at_ratio": 0.8}, 0.8**2 * 0.2),
    "one end pinned": ({"kind": "fixed_pinned"}, 3.0 / 16.0),
    "one end pinned, near it": ({"kind": "fixed_pinned", "at_ratio": 0.8}, 0.5 * 0.64 * 0.2 * 2.2),
    "overhung": ({"kind": "overhung", "at_ratio": 1.25}, 0.25),
}
"""Greatest moment over force and length, of the handbooks."""
SECTIONS: dict[str, tuple[dict[str, Any], dict[str, float], float]] = {
    "rod": ({"diameter": {"from": "1 cm", "to": "9 cm"}}, {"diameter": 0.05}, 32.0 / (np.pi * 0.05**3)),
    "tube": (
        {"diameter": {"from": "1 cm", "to": "9 cm"}, "inner_ratio": 0.5},
        {"diameter": 0.05},
        32.0 / (np.pi * 0.05**3 * (1.0 - 0.5**4)),
    ),
    "bored": ({"diameter": "5 cm", "inner_diameter": "3 cm"}, {}, 32.0 * 0.05 / (np.pi * (0.05**4 - 0.03**4))),
    "strip": (
        {"width": {"from": "1 cm", "to": "9 cm"}, "height": {"from": "1 mm", "to": "9 mm"}},
        {"width": 0.04, "height": 0.006},
        6.0 / (0.04 * 0.006**2),
    ),
}
"""Of beams: the words, what is chosen [m], and stress over moment [1/m^3]."""


def both(scene_words: dict[str, Any], response: dict[str, Any], chosen: dict[str, float]) -> tuple[float, float]:
    """What the form says, and what the built machine measures."""
    scene = from_dict({"title": "drawn", **scene_words, "limits": {"asked": response}})
    limit = pose(scene).limits[0]
    x = np.array([chosen[one.path] for one in scene.variables])
    return limit.form.worst(limit.model, x).value, measure(scene, chosen, scene.limits["asked"]).value


@pytest.mark.parametrize(("beam", "right"), BEAMS.values(), ids=BEAMS)
def test_beams_are_as_stiff_as_the_handbook_says(beam: dict[str, str], right: float) -> None:
    words = {**beam, "length": "2 m", "modulus": "207 GPa", "second_moment": "80 cm4"}
    scene = {"bodies": {"load": {"mass": "1 kg"}}, "links": {"beam": {"between": ["load", "ground"], "beam": words}}}
    found = both(scene, {"response": "stiffness", "of": "beam", "at_least": "1 N/m"}, {})
    assert found == pytest.approx((right, right), rel=1e-11)


@pytest.mark.parametrize("section", SECTIONS)
@pytest.mark.parametrize(("held", "arm"), BENT.values(), ids=BENT)
def test_the_stress_of_a_beam_is_that_of_the_force_it_carries(held: dict[str, Any], arm: float, section: str) -> None:
    words, chosen, over = SECTIONS[section]
    beam = {"length": {"from": "1 m", "to": "3 m"}, "modulus": "207 GPa", **held, **words}
    scene: dict[str, Any] = {
        "bodies": {"load": {"mass": "3 kg"}},
        "links": {"beam": {"between": ["load", "ground"], "beam": beam}},
        "excitations": {
            "shaker": {"kind": "force", "on": "load", "amplitude": "90 N", "speed": "7 Hz", "varies": "constant"}
        },
        "goal": {"minimise": "stiffness", "of": "beam"},
    }
    values = {f"links.beam.beam.{key}": one for key, one in {"length": 2.0, **chosen}.items()}
    force = both(scene, {"response": "transmitted_force", "through": "beam", "at_most": "1 N"}, values)
    right = force[1] * arm * 2.0 * over
    found = both(scene, {"response": "bending_stress", "of": "beam", "at_most": "1 MPa"}, values)
    assert found == pytest.approx((right, right), rel=1e-10)
    right = 3.0 * 9.80665 * arm * 2.0 * over
    found = both(scene, {"response": "static_bending_stress", "of": "beam", "at_most": "1 MPa"}, values)
    assert found == pytest.approx((right, right), rel=1e-10)


def test_the_stress_of_a_shaft_is_that_of_the_moment_it_hands_on() -> None:
    shaft = {"length": "1 m", "diameter": {"from": "1 cm", "to": "9 cm"}, "inner_ratio": 0.5, "shear_modulus": "80 GPa"}
    scene: dict[str, Any] = {
        "bodies": {"disc": {"inertia": "2 kg m2"}},
        "links": {"rod": {"between": ["disc", "ground"], "shaft": shaft}},
        "excitations": {
            "motor": {"kind": "moment", "on": "disc", "amplitude": "9 N m", "speed": "7 Hz", "varies": "constant"}
        },
        "goal": {"minimise": "torsional_stiffness", "of": "rod"},
    }
    chosen = {"links.rod.shaft.diameter": 0.05}
    moment = both(scene, {"response": "transmitted_moment", "through": "rod", "at_most": "1 N m"}, chosen)
    right = moment[1] * 16.0 / (np.pi * 0.05**3 * (1.0 - 0.5**4))
    found = both(scene, {"response": "shear_stress", "of": "rod", "at_most": "1 MPa"}, chosen)
    assert found == pytest.approx((right, right), rel=1e-11)


def test_a_hollow_shaft_of_any_size_is_as_stiff_as_the_handbook_says() -> None:
    shaft = {"length": "1 m", "diameter": {"from": "1 cm", "to": "9 cm"}, "inner_ratio": 0.5, "shear_modulus": "80 GPa"}
    scene = {
        "bodies": {"disc": {"disc": {"mass": "45 kg", "diameter": "0.38 m"}}},
        "links": {"rod": {"between": ["disc", "ground"], "shaft": shaft}},
        "goal": {"minimise": "torsional_stiffness", "of": "rod"},
    }
    chosen = {"links.rod.shaft.diameter": 0.05}
    right = np.pi * 80e9 * (0.05**4 - 0.025**4) / 32.0
    found = both(scene, {"response": "torsional_stiffness", "of": "rod", "at_least": "1 N m/rad"}, chosen)
    assert found == pytest.approx((right, right), rel=1e-12)
    own = np.sqrt(right / (45.0 * 0.38**2 / 8.0))
    found = both(scene, {"response": "natural_frequency", "at_least": "1 Hz"}, chosen)
    assert found == pytest.approx((own, own), rel=1e-12)


def test_a_body_that_rolls_is_heavier_in_motion_than_in_weight() -> None:
    roller = {"mass": "20 kg", "rolling": {"inertia": "0.4 kg m2", "radius": "0.2 m"}}
    scene = {
        "bodies": {"roller": roller},
        "links": {"spring": {"between": ["roller", "ground"], "stiffness": "3 kN/m"}},
    }
    own = np.sqrt(3000.0 / 30.0)
    assert both(scene, {"response": "natural_frequency", "at_least": "1 Hz"}, {}) == pytest.approx(
        (own, own), rel=1e-14
    )
    assert both(scene, {"response": "total_mass", "at_most": "1 t"}, {}) == pytest.approx((20.0, 20.0), rel=1e-14)
    sag = 20.0 * 9.80665 / 3000.0
    found = both(scene, {"response": "static_deflection", "of": "roller", "at_most": "1 m"}, {})
    assert found == pytest.approx((sag, sag), rel=1e-13)


def test_a_damping_ratio_is_a_damping_that_may_be_asked_for() -> None:
    link = {"between": ["box", "ground"], "stiffness": {"from": "1 kN/m", "to": "1 MN/m"}, "damping_ratio": 0.2}
    scene = {"bodies": {"box": {"mass": "30 kg"}}, "links": {"foot": {**link, "count": 4}}}
    asked = {**scene, "goal": {"maximise": "stiffness", "of": "foot"}}
    right = 0.4 * np.sqrt(4.0 * 9e3 * 30.0) / 4.0
    found = both(asked, {"response": "damping", "of": "foot", "at_most": "1 MN s/m"}, {"links.foot.stiffness": 9e3})
    assert found == pytest.approx((right, right), rel=1e-13)
