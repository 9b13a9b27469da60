"""Dry friction within tolerances: no machine is worse than the one that is told, and that is never called proven."""

from __future__ import annotations

from math import pi, sqrt
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import vibopt as vo
from vibopt.verify.as_built import machine_of
from vibopt.verify.certify import measure_on

few = settings(derandomize=True, database=None, deadline=None, max_examples=3)
NUMBERS = {"links.mount.stiffness": 3e5, "links.mount.friction_force": 900.0}
STEADY = {"kind": "force", "on": "press", "amplitude": "2 kN", "speed": "4.6 Hz", "varies": "constant"}
BLOW = {"kind": "pulse", "on": "press", "shape": "half sine", "amplitude": "4 kN", "duration": "80 ms"}


def press(load: dict[str, Any], wide: float = 0.1, most: str = "1 km", **numbers: float) -> dict[str, Any]:
    """A press on a mount that rubs, each number off by a part `wide` at most."""

    def off(path: str, unit: str) -> dict[str, Any]:
        return {"value": f"{numbers.get(path, NUMBERS[path])!r} {unit}", "tolerance": wide}

    once = "peak_" if load["kind"] == "pulse" else ""
    return {
        "title": "press of a batch",
        "bodies": {"press": {"mass": "300 kg"}},
        "links": {"mount": {
            "between": ["press", "ground"], "damping": "300 N s/m",
            "stiffness": off("links.mount.stiffness", "N/m"),
            "friction_force": off("links.mount.friction_force", "N"),
        }},
        "excitations": {"load": load},
        "limits": {"travel": {"response": f"{once}displacement", "of": "press", "at_most": most}},
    }  # fmt: skip


BAND = pytest.param({**STEADY, "speed": "5.4..6 Hz"}, marks=pytest.mark.slow, id="band")


@pytest.mark.parametrize("load", [pytest.param(STEADY, id="speed"), BAND, pytest.param(BLOW, id="blow")])
def test_no_machine_drawn_is_worse_by_the_second_route_and_the_worst_is_not_called_proven(
    load: dict[str, Any],
) -> None:
    """The machines that are drawn are followed as built, by what shares no code with the search for the worst."""
    answer = vo.solve(vo.from_dict(press(load)))
    assert answer.status == "met"
    assert answer.tolerances is not None
    assert answer.tolerances.open == ("travel",)
    assert "found, not proven for travel" in answer.claim
    worst = answer.limits["travel"].value.value
    plain = vo.from_dict(press(load, 0.0))
    for factors in np.random.default_rng(5).uniform(0.9, 1.1, (4, 2)).tolist():
        drawn = {path: NUMBERS[path] * factor for path, factor in zip(NUMBERS, factors, strict=True)}
        machine = machine_of(vo.from_dict(press(load, 0.0, **drawn)), {})
        assert measure_on(plain, machine, plain.limits["travel"], "at_most").value <= worst * (1.0 + 1e-6)


@few
@given(stiffness=st.floats(2e5, 4e5), friction=st.floats(200.0, 1500.0))
def test_a_worst_machine_inside_is_found(stiffness: float, friction: float) -> None:
    """Springs from below the resonance to beyond: the worst is the greatest over the spring with the least friction."""
    only = {"links.mount.stiffness": stiffness, "links.mount.friction_force": friction}
    document = press({**STEADY, "speed": f"{sqrt(stiffness / 300.0) / 2.0 / pi!r} Hz"}, 0.2, **only)
    worst = vo.solve(vo.from_dict(document)).limits["travel"].value.value
    document["links"]["mount"]["friction_force"] = f"{0.8 * friction!r} N"
    found = []
    for part in np.linspace(0.8, 1.2, 5).tolist():
        document["links"]["mount"]["stiffness"] = f"{part * stiffness!r} N/m"
        scene = vo.from_dict(document)
        found.append(measure_on(scene, machine_of(scene, {}), scene.limits["travel"], "at_most").value)
    assert worst >= max(found) * (1.0 - 1e-6)


def test_hold_is_left_within_the_tolerances() -> None:
    """As designed nothing slips; with a tenth less friction something does."""
    document = press(STEADY, **{"links.mount.friction_force": 2100.0})
    document["limits"]["travel"]["at_most"] = "1 um"
    assert vo.solve(vo.from_dict(document | {"links": {"mount": {
        **document["links"]["mount"], "friction_force": "2100 N"}}})).status == "met"  # fmt: skip
    answer = vo.solve(vo.from_dict(document))
    assert answer.status == "violated"
    assert answer.limits["travel"].off["links.mount.friction_force"] == pytest.approx(-0.1)


def test_friction_of_two_pads_adds_and_each_is_off_by_itself() -> None:
    document = press(STEADY)
    mount = document["links"]["mount"]
    alone = vo.solve(vo.from_dict(document)).limits["travel"].value.value
    half = {"value": "450 N", "tolerance": 0.1}
    pad = {"between": ["ground", "press"], "friction_force": half}
    document["links"] = {"mount": mount | {"friction_force": half}, "pad": pad}
    both = vo.solve(vo.from_dict(document)).limits["travel"]
    assert both.value.value == pytest.approx(alone, rel=1e-6)
    assert both.off["links.pad.friction_force"] == pytest.approx(-0.1)


def test_friction_is_chosen_on_one_of_two_pads() -> None:
    """As much as on one link alone, less what the other has."""
    document = press(STEADY, 0.0, "30 mm")
    mount, chosen = document["links"]["mount"], {"from": "1 N", "to": "5 kN"}
    document["links"]["mount"] = mount | {"friction_force": chosen}
    alone = vo.solve(vo.from_dict(document | {"goal": {"minimise": "friction_force", "of": "mount"}}))
    pad = {"between": ["ground", "press"], "friction_force": chosen}
    document["links"] = {"mount": mount | {"friction_force": "450 N"}, "pad": pad}
    both = vo.solve(vo.from_dict(document | {"goal": {"minimise": "friction_force", "of": "pad"}}))
    assert both.goal[1].value == pytest.approx(alone.goal[1].value - 450.0, rel=1e-6)
