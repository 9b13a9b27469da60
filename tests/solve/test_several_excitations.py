"""Where several excitations add up, designs are looked at as widely as under one."""

from typing import Any

import numpy as np
import pytest

import vibopt as vo
from vibopt.forms.few import along, few_sampled
from vibopt.program.pose import pose
from vibopt.scene.read import from_dict

SPEED = "27.99 Hz"
SHAKEN = {"on": "set", "speed": SPEED}
SPRING = {"from": "268400 N/m", "to": "21470000 N/m"}


def mounts(x: float, sides: list[float], **words: Any) -> dict[str, Any]:
    places = [[f"{x} m", f"{side * 0.4527} m", "0 m"] for side in sides]
    return {"between": ["set", "ground"], "at": places, "stiffness": SPRING} | words


UNEQUAL: dict[str, Any] = {
    "bodies": {
        "set": {
            "mass": "2444 kg",
            "centre": ["0 m", "0 m", "0.2213 m"],
            "inertia": ["247 kg m2", "660.2 kg m2", "575.4 kg m2"],
        }
    },
    "mounts": {
        "front": mounts(0.7243, [1, -1], shear_ratio=0.48, loss_factor=0.11),
        "left": mounts(-0.7243, [1], shear_ratio=0.45, damping={"from": "405 N s/m", "to": "121500 N s/m"}),
        "right": mounts(-0.7243, [-1], shear_ratio=0.79, loss_factor=0.2),
    },
    "excitations": {
        "rotor": SHAKEN
        | {"kind": "unbalance", "axis": "y", "at": ["0.2858 m", "0.218 m", "0.6452 m"], "unbalance": "0.00492 kg m"},
        "torque": SHAKEN | {"kind": "moment", "axis": "x", "amplitude": "16.6 N m", "varies": "constant"},
        "belt": SHAKEN
        | {
            "kind": "force",
            "direction": "x",
            "at": ["0.05046 m", "-0.08741 m", "0.5454 m"],
            "amplitude": "3.74 N",
            "varies": "constant",
        },
    },
    "limits": {
        "travel": {"response": "travel", "of": "front", "combine": "sum", "at_most": "7.33 µm"},
        "force": {
            "response": "transmitted_force",
            "through": "right",
            "direction": "z",
            "combine": "sum",
            "at_most": "233 N",
        },
    },
    "goal": {"minimise": "displacement", "of": "set", "direction": "x", "combine": "sum"},
}


def test_of_three_excitations_on_unequal_mounts_the_other_optimum_is_found() -> None:
    """One rear mount sixty times as stiff as the other three; four starts agreed on 2.064 µm, all at their softest.

    2.03656 µm by p-norm descents from 150 starts on matrices in numpy, without vibopt.
    """
    design = vo.solve(from_dict(UNEQUAL))
    assert design.goal is not None
    assert design.goal[1].value == pytest.approx(2.03655787e-6, rel=1e-8)


SHAFT: dict[str, Any] = {
    "bodies": {"engine": {"inertia": "2 kg m2"}, "wheel": {"inertia": "5 kg m2"}},
    "links": {
        "coupling": {
            "between": ["engine", "wheel"],
            "torsional_stiffness": {"from": "10 kN m/rad", "to": "90 kN m/rad"},
            "torsional_damping": {"from": "10 N m s/rad", "to": "400 N m s/rad"},
        },
        "bed": {
            "between": ["wheel", "ground"],
            "torsional_stiffness": "200 kN m/rad",
            "torsional_damping": "90 N m s/rad",
        },
    },
    "excitations": {
        "gas": {
            "kind": "moment_harmonics",
            "on": "engine",
            "speed": "5..20 Hz",
            "varies": "constant",
            "harmonics": [{"order": 1, "amplitude": "80 N m"}, {"order": 3, "amplitude": "50 N m"}],
        },
        "blades": {"kind": "moment", "on": "wheel", "speed": "10..40 Hz", "amplitude": "30 N m", "varies": "constant"},
    },
    "goal": {"minimise": "twist", "across": "coupling"},
}


@pytest.mark.parametrize("combine", ["sum", "rss"])
def test_a_look_at_sums_is_no_greater_than_the_worst_and_knows_its_slopes(combine: str) -> None:
    program = pose(from_dict(SHAFT | {"goal": SHAFT["goal"] | {"combine": combine}}))
    assert program.aim is not None
    model, form = program.aim.model, program.aim.form.harmonic
    assert form is not None
    x = np.exp(np.random.default_rng(3).uniform(np.log(program.low), np.log(program.high), (6, 2)))
    worst = np.array([form.worst(model, one).value for one in x])
    few = few_sampled(model, form, x)
    (log, slope), step = along([(model, form, None)], x)[0], 1e-6
    assert few is not None
    for looked in (few, np.exp(log.max(axis=1))):
        assert (looked <= worst * (1 + 1e-12)).all()
        assert (looked >= 0.97 * worst).all()
    for i in range(2):
        ahead, back = (along([(model, form, None)], x * np.exp(side * step * np.eye(2)[i]))[0][0] for side in (1, -1))
        np.testing.assert_allclose(
            (ahead - back) / (2 * step), slope.reshape(*log.shape, 2)[..., i], atol=1e-6 * np.abs(slope).max()
        )
