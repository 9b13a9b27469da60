"""What is asked of one machine while another beside it is chosen, and of a motion that no load reaches."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import numpy as np
import pytest

import vibopt as vo
from vibopt.program.pose import whole_models

PULSE: dict[str, Any] = {"kind": "pulse", "shape": "half sine", "amplitude": "400 N"}
MOUNT = {"stiffness": "100 kN/m", "damping": "1 kN s/m"}
OPEN = {"stiffness": {"from": "1 kN/m", "to": "1 MN/m"}, "damping": {"from": "20 N s/m", "to": "70 kN s/m"}}


@pytest.mark.parametrize(
    "load",
    [
        {**PULSE, "duration": "8 ms"},
        {"kind": "unbalance", "unbalance": "0.1 kg m", "speed": "100 rad/s",
         "run_up": {"to": "100 rad/s", "duration": "4 s"}},
    ],
    ids=["pulse", "run-up"],
)  # fmt: skip
def test_what_nothing_chosen_moves_is_as_it_is(load: dict[str, Any]) -> None:
    """Proven the least, and what it is without any choice."""
    felt = {"response": "peak_acceleration", "of": "other", "due_to": ["load"]}
    document: dict[str, Any] = {
        "title": "side by side",
        "bodies": {"one": {"mass": "26 kg"}, "other": {"mass": "99 kg"}},
        "links": {
            "under_one": {"between": ["one", "ground"], **OPEN},
            "under_other": {"between": ["other", "ground"], **MOUNT},
        },
        "excitations": {"load": {"on": "other", **load}, "beside": {**PULSE, "on": "one", "duration": "8 ms"}},
        "goal": {"minimise": felt["response"], "of": "other", "due_to": ["load"]},
    }
    least = vo.solve(vo.from_dict(document))
    assert least.status == "optimal", least.claim
    document["links"]["under_one"] |= MOUNT
    del document["goal"]
    alone = vo.solve(vo.from_dict(document | {"measures": {"felt": felt}}))
    assert least.goal is not None
    assert least.goal[1].value == pytest.approx(alone.measures["felt"].value.value, rel=1e-7)


@pytest.mark.parametrize("seed", range(8))
def test_bodies_that_all_but_follow_a_base_alike_leave_what_both_routes_tell(seed: int) -> None:
    """A relative motion of 1e-14 to 1e-7 of theirs, which rounding of both may hide and no route may call nothing."""
    draw = np.random.default_rng(seed)
    heavy, light = (float(one) for one in 10.0 ** draw.uniform(0.0, 3.0, 2))
    turns, ratio, apart = (float(10.0 ** draw.uniform(*ends)) for ends in ((1.0, 3.0), (-3.0, -0.3), (-12.0, -7.0)))
    spring, oil = turns**2, 2.0 * ratio * turns

    def link(ends: list[str], mass: float, part: float = 1.0) -> dict[str, Any]:
        return {"between": ends, "stiffness": f"{part * spring * mass!r} N/m", "damping": f"{oil * mass!r} N s/m"}

    document: dict[str, Any] = {
        "title": "side by side on a base",
        "bases": {"base": {}},
        "bodies": {"a": {"mass": f"{heavy!r} kg"}, "b": {"mass": f"{light!r} kg"}},
        "links": {
            "under_a": link(["a", "base"], heavy),
            "under_b": link(["b", "base"], light, 1.0 + apart),
            "between": {"between": ["a", "b"], "stiffness": f"{4.0 * spring * heavy!r} N/m"},
        },
        "excitations": {"jolt": {"kind": "pulse", "on": "base", "shape": "versed sine", "displacement": "10 mm",
                                 "duration": f"{float(10.0 ** draw.uniform(-3.0, 1.0)) / turns!r} s"}},
        "measures": {"apart": {"response": "peak_relative_displacement", "across": "between"},
                     "a": {"response": "peak_displacement", "of": "a"}},
    }  # fmt: skip
    design = vo.solve(vo.from_dict(document))
    assert design.status == "met", design.claim
    assert design.measures["apart"].value.value < 1e-5 * design.measures["a"].value.value


BLOCK: dict[str, Any] = {
    "title": "block on unlike mounts, turned about the axis along which it is alike",
    "bodies": {"block": {"mass": "560 kg", "centre": ["0 m", "0 m", "0.21 m"],
                         "inertia": ["95 kg m2", "160 kg m2", "130 kg m2"]}},
    "mounts": {
        end: {
            "between": ["block", "ground"],
            "at": [[f"{x} m", "0.66 m", "0 m"], [f"{x} m", "-0.66 m", "0 m"]],
            "stiffness": {"from": "20 kN/m", "to": "2 MN/m"},
            "shear_ratio": shear,
            "damping": {"from": "0 N s/m", "to": "8 kN s/m"},
        }
        for end, x, shear in (("front", 0.74, 1.6), ("rear", -0.74, 0.36))
    },
    "excitations": {"couple": {"kind": "moment", "on": "block", "axis": "x", "amplitude": "200 N m",
                               "speed": "1000 rpm", "varies": "constant"}},
}  # fmt: skip
PLACE = {"of": "block", "direction": "z"}
UP = {"response": "displacement", **PLACE, "over": "0..3000 rpm"}


@pytest.mark.parametrize("way", ["minimise", "maximise"])
def test_what_no_load_reaches_is_nothing_whatever_is_chosen(way: str) -> None:
    """Known without a search, where boxes of four variables see nothing else than rounding."""
    design = vo.solve(vo.from_dict(BLOCK | {"goal": {way: "displacement", **PLACE}}))
    assert design.status == "optimal", design.claim
    assert design.goal is not None
    assert design.goal[1].value == 0.0


def test_whole_models_find_rounding_alone_there_and_say_zero() -> None:
    """Of one number, where each place of the range has another rounding."""
    mounts = {end: {**one, "damping": "300 N s/m", "stiffness": "300 kN/m"} for end, one in BLOCK["mounts"].items()}
    mounts["front"] |= {"shear_ratio": {"from": 0.15, "to": 0.74}}
    corner = {"corner": {"on": "block", "at": ["0.11 m", "-0.7 m", "0.12 m"]}}
    along = {"couple": {**BLOCK["excitations"]["couple"], "axis": "y"}}
    goal = {"minimise": "velocity", "of": "corner", "direction": "y"}
    with whole_models():
        design = vo.solve(
            vo.from_dict(BLOCK | {"mounts": mounts, "points": corner, "excitations": along, "goal": goal})
        )
    assert design.status == "optimal", design.claim
    assert design.claim == "proven: what the goal counts is zero, up to rounding, and cannot be less"


def test_a_limit_on_what_no_load_reaches_holds_or_cannot_be_kept() -> None:
    """Both routes leave rounding there at standstill, and neither is wrong."""
    across = {"minimise": "displacement", "of": "block", "direction": "y"}
    mounts = {end: {**one, "damping": "1 kN s/m"} for end, one in BLOCK["mounts"].items()}
    asked = BLOCK | {"mounts": mounts, "goal": across}
    kept = vo.solve(vo.from_dict(asked | {"limits": {"up": {**UP, "at_most": "1 mm"}}}))
    assert kept.status == "optimal", kept.claim
    assert kept.x == pytest.approx(vo.solve(vo.from_dict(asked)).x, rel=1e-6)
    never = vo.solve(vo.from_dict(asked | {"limits": {"up": {**UP, "at_least": "1 mm"}}}))
    assert never.status == "infeasible"
    assert never.claim == 'proven by what the loads move: "up" counts nothing of it, whatever the design'
    assert never.reason == (
        "up asks for at least some of a motion that no load moves on this machine. Ask it of another place or "
        "direction, or add the load that moves it."
    )


@pytest.mark.slow
def test_an_antiresonance_that_boxes_find_late_is_zero_too() -> None:
    """Leaning mounts without loss leave nothing of the force along x at one speed: 4.5e-13 N is rounding."""
    at = [[f"{x} m", f"{y} m", "0 m"] for x in (0.728, -0.728) for y in (0.346, -0.346)]
    foot = {
        "between": ["block", "ground"],
        "at": at,
        "direction": [[-0.4, -0.3, 1.0], [-0.4, 0.3, 1.0], [0.4, -0.3, 1.0], [0.4, 0.3, 1.0]],
        "stiffness": {"from": "10.97 kN/m", "to": "802.2 kN/m"},
        "shear_ratio": {"from": 0.8828, "to": 3.686},
        "loss_factor": {"from": 0.0, "to": 1.027},
    }
    block = {
        "mass": "131.2 kg",
        "centre": ["0 m", "0 m", "0.269 m"],
        "inertia": ["12.729 kg m2", "22.19 kg m2", "25.953 kg m2"],
    }
    shaker = {"kind": "unbalance", "on": "block", "direction": "x", "at": ["-0.022 m", "-0.278 m", "0.204 m"],
              "unbalance": "0.02 kg m", "speed": "1882 rpm"}  # fmt: skip
    goal = {"minimise": "transmitted_force", "into": "ground", "direction": "x"}
    design = vo.solve(vo.from_dict({"title": "late", "bodies": {"block": block}, "mounts": {"foot": foot},
                                    "excitations": {"shaker": shaker}, "goal": goal}))  # fmt: skip
    assert design.status == "optimal"
    assert design.claim == "proven: what the goal counts is zero, up to rounding, and cannot be less"
    assert design.goal is not None
    assert design.goal[1].value == 0.0


def _struck(direction: str) -> Any:
    """The least rise of the block under a blow."""
    blow = {"blow": {**PULSE, "on": "block", "direction": direction, "duration": "8 ms"}}
    mounts = {end: {**one, "damping": "1 kN s/m"} for end, one in BLOCK["mounts"].items()}
    goal = {"minimise": "peak_displacement", **PLACE}
    return vo.solve(vo.from_dict(BLOCK | {"mounts": mounts, "excitations": blow, "goal": goal}), explain=False)


def test_a_rise_in_time_that_no_pulse_reaches_is_nothing_by_both_routes(monkeypatch: pytest.MonkeyPatch) -> None:
    """The second route integrates all six coordinates; were something moved, it would be shown."""
    design = _struck("y")
    assert design.status == "optimal", design.claim
    assert design.goal[1].value < 1e-15
    monkeypatch.setattr(import_module("vibopt.solve.without_search"), "unmoved", lambda *_: True)
    assert _struck("z").goal[1].value > 1e-6
