"""Dry friction between bodies that move, under what comes once: both roads, closed forms, energy, and a third road."""

from __future__ import annotations

from itertools import pairwise
from math import pi
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import vibopt as vo
from refusals import refused
from rubbing_route import ENDS, LOW, MASSES, UP, drawer_in_rack, follow
from vibopt.program.pose import form_of, pose

few = settings(derandomize=True, database=None, deadline=None, max_examples=8)
PUSH: dict[str, Any] = {"kind": "pulse", "on": "rack", "shape": "half sine", "amplitude": "6 kN", "duration": "80 ms"}
ASKED: dict[str, Any] = {
    "rack": {"response": "peak_velocity", "of": "rack"},
    "drawer": {"response": "peak_acceleration", "of": "drawer"},
    "slip": {"response": "peak_relative_displacement", "across": "pad"},
    "through": {"response": "peak_force", "through": "pad"},
    "into": {"response": "peak_force", "into": "drawer"},
}


def rack(load: dict[str, Any], ends: tuple[str, str] = ENDS[0], damping: float = 200.0, **pad: Any) -> dict[str, Any]:
    return drawer_in_rack(load, ends, damping, {"friction_force": "800 N"} | pad, dict(ASKED))


def told(document: dict[str, Any]) -> dict[str, float]:
    """Values of the measures; both routes agree on them."""
    answer = vo.solve(vo.from_dict(document))
    assert answer.status == "met", answer.claim
    return {name: one.value.value for name, one in answer.measures.items()}


def motion_of(document: dict[str, Any], name: str) -> tuple[Any, Any]:
    """The motion piece by piece, and what a measure reads of it."""
    scene = vo.from_dict(document)
    model = pose(scene).model
    form: Any = form_of(scene, model, scene.measures[name])
    return form.motion(model, np.zeros(0))


@few
@given(
    kind=st.sampled_from(["rack", "drawer", "floor", "release", "drop", "suddenly"]), ends=st.sampled_from(ENDS),
    length=st.floats(0.01, 0.3), friction=st.floats(50.0, 4000.0), damping=st.floats(50.0, 3000.0),
)  # fmt: skip
@example(kind="floor", ends=ENDS[0], length=0.06, friction=900.0, damping=0.0)
@example(kind="drop", ends=ENDS[0], length=0.1, friction=40e3, damping=100.0)
def test_every_peak_has_one_value_by_both_routes(
    kind: str, ends: tuple[str, str], length: float, friction: float, damping: float
) -> None:
    """Under pulses, a body let go, a drop and a sudden start."""
    load = PUSH | {"duration": f"{length!r} s", "on": kind}
    if kind == "floor":
        load = {key: one for key, one in load.items() if key != "amplitude"} | {"acceleration": "30 m/s2"}
    elif kind == "release":
        load = {"kind": "release", "on": "drawer", "displacement": f"{0.1 * length!r} m"}
    elif kind == "drop":
        load = {"kind": "drop", "on": "floor", "height": f"{length!r} m"}
    elif kind == "suddenly":
        load = {"kind": "force", "on": "rack", "amplitude": "2 kN", "speed": f"{0.5 / length!r} Hz", "begins": kind}
    told(rack(load, ends, max(damping, 400.0) if kind == "suddenly" else damping, friction_force=f"{friction!r} N"))


@pytest.mark.parametrize(("ends", "friction"), [(ENDS[0], 500.0), (ENDS[1], 1200.0)])
def test_a_runge_kutta_method_between_events_finds_the_same_peaks(ends: tuple[str, str], friction: float) -> None:
    row = {"rack": np.array([1.0, 0.0]), "drawer": np.array([0.0, 1.0]), "ground": np.zeros(2)}
    across, shape = row[ends[1]] - row[ends[0]], np.array([[1.0, -1.0], [-1.0, 1.0]])
    damp, stiff = (np.diag([low, 0.0]) + up * shape for low, up in ((100.0, 100.0), (LOW, UP)))
    peaks = follow(
        (np.diag(MASSES), damp, stiff), across, friction,
        lambda t: np.array([6e3 * np.sin(pi * t / 0.08) if t < 0.08 else 0.0, 0.0]), (0.08, 0.4),
        lambda _, place, rate, faster, rubs: (rate[0], faster[1], across @ place, rubs),
    )  # fmt: skip
    found = told(rack(PUSH, ends, 100.0, friction_force=f"{friction!r} N"))
    for name, value in zip(("rack", "drawer", "slip", "through"), peaks, strict=True):
        assert found[name] == pytest.approx(value, rel=2e-6, abs=1e-9)


def test_what_friction_never_lets_slip_moves_as_one_body() -> None:
    """A step on one of two that are held together: 2 F / k, and of the force each takes as much as it weighs."""
    step = PUSH | {"shape": "rectangle", "amplitude": "1 kN", "duration": "3 s"}
    document = rack(step, damping=0.0, friction_force="100 kN")
    document["measures"]["place"] = {"response": "peak_displacement", "of": "drawer"}
    found = told(document)
    assert found["place"] == pytest.approx(2e3 / LOW, rel=1e-9)
    assert found["slip"] == pytest.approx(0.0, abs=1e-12)
    assert found["into"] == pytest.approx(MASSES[1] * found["drawer"], rel=1e-9)
    assert found["through"] == pytest.approx(MASSES[1] * found["drawer"], rel=1e-9)


@pytest.mark.parametrize("ends", ENDS)
def test_hardly_any_friction_leaves_the_linear_machine(ends: tuple[str, str]) -> None:
    found = told(rack(PUSH, ends, friction_force="0.000001 N", stiffness="50 kN/m"))
    linear = told(rack(PUSH, ends, friction_force="0 N", stiffness="50 kN/m"))
    assert found == pytest.approx(linear, rel=1e-9)


def test_beside_a_body_that_nothing_moves_it_is_one_body_alone() -> None:
    """On a rack of a million tons the drawer rubs as on the ground."""
    load = PUSH | {"on": "drawer"}
    document = rack(load, damping=150.0)
    document["bodies"]["rack"]["mass"] = "1000000000 kg"
    document["links"]["low"]["stiffness"] = "10000000 GN/m"
    alone = rack(load, damping=150.0)
    alone["bodies"].pop("rack")
    alone["links"].pop("low")
    for name in ("up", "pad"):
        alone["links"][name]["between"] = ["ground", "drawer"]
    alone["measures"].pop("rack")
    document["measures"].pop("rack")
    assert told(document) == pytest.approx(told(alone), rel=1e-6)


def test_three_bodies_and_an_absorber_are_followed_too() -> None:
    document = rack(PUSH, friction_force="600 N")
    document["bodies"]["lamp"] = {"mass": "5 kg"}
    document["links"]["arm"] = {"between": ["drawer", "lamp"], "stiffness": "20 kN/m", "damping": "30 N s/m"}
    document["absorbers"] = {"tmd": {"on": "rack", "mass": "9 kg", "frequency": "7 Hz", "damping_ratio": 0.1}}
    document["measures"]["lamp"] = {"response": "peak_acceleration", "of": "lamp"}
    told(document)


@few
@given(friction=st.floats(50.0, 2500.0), damping=st.floats(0.0, 5e3), length=st.floats(0.02, 0.4))
def test_what_a_pulse_does_friction_and_dampers_take_and_the_springs_keep(
    friction: float, damping: float, length: float
) -> None:
    """Energy up to any time: work of the force = kinetic and elastic energy + what is lost."""
    damping = damping if damping > 1e-3 else 0.0
    load = PUSH | {"duration": f"{length!r} s"}
    motion, _ = motion_of(rack(load, damping=damping, friction_force=f"{friction!r} N"), "rack")
    nodes, weights = np.polynomial.legendre.leggauss(20)
    work = lost = 0.0
    for one in motion.pieces:
        if one.length == np.inf:  # held for good
            break
        part, v = 0.5 * (nodes + 1.0), 0.5 * one.length * weights
        slip, first = np.polynomial.chebyshev.chebval(2.0 * part - 1.0, (one.law.speeds[1] @ one.states).T)
        time = one.begin + part * one.length
        push = np.where(time < length, 6e3 * np.sin(pi * time / length), 0.0)
        assert (one.side * slip >= -1e-9).all()
        work += float(v @ (push * first))
        lost += float(v @ (friction * np.abs(slip) + damping * (first**2 + slip**2)))
        end = one.states.sum(axis=1)
        (apart, place), (faster, speed) = one.law.places @ end, one.law.speeds[1] @ end
        kept = MASSES[0] * speed**2 + MASSES[1] * (speed + faster) ** 2 + LOW * place**2 + UP * apart**2
        assert work == pytest.approx(lost + 0.5 * kept, rel=1e-9, abs=1e-9)
    assert all(one.begin + one.length == pytest.approx(after.begin) for one, after in pairwise(motion.pieces))


def test_the_same_machine_a_thousand_times_as_heavy_and_as_strong_moves_alike() -> None:
    """Masses, springs, dampers, friction and force in tons and kilonewtons."""
    document = rack(PUSH, friction_force="700 N")
    heavy = rack(PUSH | {"amplitude": "6 MN"}, friction_force="700 kN")
    heavy["bodies"] = {"rack": {"mass": "180 t"}, "drawer": {"mass": "40 t"}}
    for name, stiffness in (("low", LOW), ("up", UP)):
        heavy["links"][name] |= {"stiffness": f"{stiffness} kN/m", "damping": "200 kN s/m"}
    found, other = told(document), told(heavy)
    for name in ("rack", "drawer", "slip"):
        assert other[name] == pytest.approx(found[name], rel=1e-10)
    assert other["through"] == pytest.approx(1e3 * found["through"], rel=1e-10)


WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "a force on a joint": (
        {"bodies": {"rack": {"mass": "0 kg"}, "drawer": {"mass": "40 kg"}}},
        "links.pad.friction_force rubs under excitations.load, which acts on rack. It has no mass, and would slip as "
        "suddenly as that. Let it act on a body with mass, or give the joint its mass.",
    ),
    "loose": (
        {"links": {"low": {"between": ["ground", "rack"], "stiffness": "1 kN/m"},
                   "pad": {"between": ["rack", "drawer"], "friction_force": "800 N"}}},
        "links.pad.friction_force rubs, and no spring brings bodies.drawer back: it slips away, and where it stays "
        'nobody knows. Join bodies.drawer by a link with stiffness = "200 kN/m" to what is held.',
    ),
    "absorber with a loss": (
        {"absorbers": {"tmd": {"on": "rack", "mass": "9 kg", "frequency": "7 Hz", "loss_factor": 0.1}}},
        "links.pad.friction_force rubs beside absorbers.tmd.loss_factor, which knows harmonic motion only, and a "
        "motion that rubs is not harmonic. Write damping or damping_ratio there.",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_what_has_no_answer_is_said(name: str) -> None:
    change, words = WRONG[name]
    assert f"scene: {words}" in refused(vo.from_dict, rack(PUSH) | change).messages
