"""Dry friction at and beside joints without mass: both roads, a third one, and the machines at its ends."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import vibopt as vo

few = settings(derandomize=True, database=None, deadline=None, max_examples=6)
SINE = {"kind": "force", "on": "device", "amplitude": "100 N", "speed": "6 Hz", "varies": "constant"}
PULSE = {"kind": "pulse", "on": "device", "shape": "half sine", "amplitude": "300 N", "duration": "50 ms"}
FLOOR = {"kind": "base_motion", "on": "floor", "displacement": "8 mm", "speed": "6 Hz"}
SHOCK = {"kind": "pulse", "on": "floor", "shape": "triangle", "acceleration": "30 m/s2", "duration": "80 ms"}
LOADS = {"sine": SINE, "pulse": PULSE, "floor": FLOOR, "shock": SHOCK}


def mount(load: dict[str, Any], links: dict[str, Any], joints: int = 1, seen: str = "joint") -> dict[str, Any]:
    """A device of 10 kg on a spring and a damper, beside it links over joints, one of them a pad."""
    once = load["kind"] == "pulse"
    floor = "floor" if load["on"] == "floor" else "ground"
    word = "peak_{}" if once else "{}"
    force = "peak_force" if once else "transmitted_force"
    own = {"between": ["device", "ground"], "stiffness": "10 kN/m", "damping": "20 N s/m"}
    every = {"own": own} | links
    for link in every.values():
        link["between"] = [floor if end == "ground" else end for end in link["between"]]
    return {
        "title": "friction behind a spring",
        "bodies": {"device": {"mass": "10 kg"}} | {f"joint{i or ''}": {"mass": "0 kg"} for i in range(joints)},
        "links": every,
        "excitations": {"load": load},
        "measures": {
            "fast": {"response": word.format("acceleration"), "of": "device"},
            "slip": {"response": word.format("relative_displacement"), "across": "pad"},
            "own": {"response": word.format("relative_displacement"), "across": "own"},
            "speed": {"response": word.format("velocity"), "of": seen},
            "pad": {"response": force, "through": "pad"},
            "into": {"response": force, "into": floor},
        },
    } | ({"bases": {"floor": {}}} if floor == "floor" else {})  # fmt: skip


def behind(friction: float, spring: float = 2e4, **pad: Any) -> dict[str, Any]:
    """A pad behind a spring: Jenkins' element."""
    return {
        "spring": {"between": ["device", "joint"], "stiffness": f"{spring!r} N/m"},
        "pad": {"between": ["joint", "ground"], "friction_force": f"{friction!r} N"} | pad,
    }


def told(document: dict[str, Any]) -> dict[str, float]:
    """Values of the measures; both routes agree on them."""
    answer = vo.solve(vo.from_dict(document))
    assert answer.status == "met", answer.claim
    return {name: one.value.value for name, one in answer.measures.items()}


def followed(
    friction: float, push: Any, joints: tuple[float, ...], from_then: float = 0.0
) -> tuple[float, float, float]:
    """Greatest acceleration, place, and force of the element by its own law: that goes with the spring up to friction.

    States are place, speed and the force of the element; a Runge-Kutta method goes from event to event.
    """
    now, time, best = np.zeros(3), 0.0, np.zeros(3)
    slips = 0.0
    while time < joints[-1]:

        def rates(t: float, y: Any, slips: float = slips) -> list[float]:
            return [y[1], (push(t) - 1e4 * y[0] - 20.0 * y[1] - y[2]) / 10.0, 0.0 if slips else 2e4 * y[1]]

        def ends(_: float, y: Any, slips: float = slips) -> float:
            return slips * float(y[1]) if slips else friction - abs(float(y[2]))

        watch: Any = ends
        watch.terminal, watch.direction = True, -1
        end = next(one for one in joints if one > time * (1.0 + 1e-12))
        run: Any = solve_ivp(rates, (time, end), now, method="DOP853", rtol=1e-12, atol=1e-13, events=watch,
                             dense_output=True, max_step=5e-3)  # fmt: skip
        if run.t[-1] > from_then:
            some = np.linspace(time, run.t[-1], max(30, int((run.t[-1] - time) * 5e4)))
            y = run.sol(some)
            fast = (np.vectorize(push)(some) - 1e4 * y[0] - 20.0 * y[1] - y[2]) / 10.0
            best = np.maximum(best, np.abs([fast, y[0], y[2]]).max(axis=1))
        time, now = float(run.t[-1]), run.y[:, -1]
        if run.status == 1:
            slips = 0.0 if slips else float(np.sign(now[2]))
            now[2] = np.clip(now[2], -friction, friction)
    fast, place, force = best.tolist()
    return fast, place, force


@pytest.mark.parametrize("friction", [60.0, *(pytest.param(one, marks=pytest.mark.slow) for one in (20.0, 95.0))])
def test_the_law_of_the_element_itself_gives_the_same_motion(friction: float) -> None:
    pulse = followed(friction, lambda t: 300.0 * np.sin(np.pi * t / 0.05) * (t < 0.05), (0.05, 1.0))
    found = told(mount(PULSE, behind(friction)))
    assert [found[name] for name in ("fast", "own", "pad")] == pytest.approx(pulse, rel=1e-6)
    turns = [k / 6.0 for k in range(91)]
    sine = followed(friction, lambda t: 100.0 * np.cos(12.0 * np.pi * t), (*turns[1:],), turns[-2])
    found = told(mount(SINE, behind(friction)))
    assert [found[name] for name in ("fast", "own", "pad")] == pytest.approx(sine, rel=1e-6)


@few
@given(
    load=st.sampled_from(sorted(LOADS)), hertz=st.floats(0.5, 20.0), friction=st.floats(1.0, 150.0),
    damping=st.floats(5.0, 500.0), kind=st.integers(0, 5),
)  # fmt: skip
@example(load="sine", hertz=7.0, friction=8.0, damping=50.0, kind=5)
@example(load="floor", hertz=3.0, friction=30.0, damping=50.0, kind=1)
@example(load="sine", hertz=6.0, friction=60.0, damping=300.0, kind=2)
def test_every_response_has_one_value_by_both_routes(
    load: str, hertz: float, friction: float, damping: float, kind: int
) -> None:
    """What rubs stands behind a spring, has a damper, or stands beside an elastic damper; or between two joints."""
    shaken = LOADS[load] | ({"speed": f"{hertz!r} Hz"} if "speed" in LOADS[load] else {})
    brake: dict[str, Any] = {"damping": f"{damping!r} N s/m"}
    holder: dict[str, Any] = {"stiffness": "7 kN/m"}
    pad = {"friction_force": f"{friction!r} N"}
    spring = {"between": ["device", "joint"], "stiffness": "20 kN/m"}
    links: list[dict[str, Any]] = [
        behind(friction, **holder),
        behind(friction, **brake),
        {"spring": spring, "brake": {"between": ["joint", "ground"]} | brake,
         "pad": {"between": ["device", "ground"]} | pad},
        {"spring": spring, "brake": {"between": ["joint", "ground"]} | brake,
         "pad": {"between": ["joint", "device"]} | pad},
        {"spring": spring, "pad": {"between": ["joint", "joint1"]} | pad,
         "up": {"between": ["joint1", "ground"]} | holder},
        {"spring": spring, "pad": {"between": ["joint", "joint1"]} | pad,
         "up": {"between": ["joint1", "ground"]} | holder | brake},
    ]  # fmt: skip
    told(mount(shaken, links[kind], 1 + (kind > 3)))


def test_a_spring_before_a_pad_that_never_slips_is_one_alone() -> None:
    for load in (SINE, PULSE, SHOCK):
        found = told(mount(load, behind(1e6)))
        bound = mount(load, {"pad": {"between": ["device", "ground"], "stiffness": "20 kN/m"}}, 0, "device")
        assert found["fast"] == pytest.approx(told(bound)["fast"], rel=1e-9)
        assert found["slip"] == pytest.approx(0.0, abs=1e-12)


def test_two_springs_before_a_pad_are_one() -> None:
    """Wherever the joints are: one of them before the pad and one behind it, or both before it."""
    for load in (SINE, PULSE):
        one = told(mount(load, behind(30.0, 12e3)))
        two = behind(30.0, 3e4)
        two["pad"]["between"] = ["joint", "joint1"]
        two["up"] = {"between": ["joint1", "ground"], "stiffness": "20 kN/m"}
        three = behind(30.0, 2e4)
        three["spring"]["between"] = ["joint1", "joint"]
        three["up"] = {"between": ["device", "joint1"], "stiffness": "30 kN/m"}
        for links in (two, three):
            found = told(mount(load, links, 2))
            for name in ("fast", "slip", "own", "pad", "into"):
                assert found[name] == pytest.approx(one[name], rel=1e-9), name


def test_a_softer_spring_before_the_pad_lets_friction_take_less() -> None:
    """In a turn friction takes four times its force over the slip, and a slip begins later behind a soft spring."""
    slips = [told(mount(SINE | {"speed": "1 Hz"}, behind(20.0, one)))["slip"] for one in (1e4, 4e4)]
    assert all(one < other for one, other in pairwise(slips))
