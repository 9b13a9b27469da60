"""Responses at standstill and from there on: the limit of chains that float or ride on a base, in 90 digits."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from floating import TOP, Floating
from space_machine import Plant
from vibopt.program.pose import on_needed
from vibopt.scene.assemble import model_of
from vibopt.scene.read import from_dict
from vibopt.signals import Amplitude, Band, Piece
from vibopt.solve import solve
from vibopt.verify.certify import measure

chains = st.builds(Floating.of, st.integers(0, 100_000))
few = settings(max_examples=12)
many = settings(max_examples=200)


def agree(case: Floating, over: str) -> None:
    """Measured machine and optimiser's form against the reference, for every reading."""
    scene = from_dict(case.document(over))
    full, rest, typical = model_of(scene), case.at_rest(), case.values(5.0)
    for name, asked in scene.measures.items():
        found = measure(scene, {}, asked)
        speed = found.speeds["shaker"]
        if not np.isfinite(found.value) and speed > 0.0:
            assert float(case.values(speed * (1.0 - 1e-9))[name]) > 1e5 * float(typical[name])  # an undamped resonance
            continue
        right = rest[name] if speed == 0.0 else float(case.values(speed)[name])
        room = 1e-8 * float(typical[name]) if right < 1e-6 * float(typical[name]) else 0.0
        assert found.value == pytest.approx(right, rel=2e-9, abs=room), f"{name} on the built machine"
        model, asked_form = on_needed(scene, full, asked)
        form = asked_form.worst(model, np.zeros(0))
        assert form.value == pytest.approx(right, rel=2e-9, abs=room), f"{name} for the optimiser"
        if ".." in over:
            beside = (float(case.values(w)[name]) for w in (1e-4, 0.02, 0.6, 3.0, 11.0, TOP))
            assert max(beside) <= found.value * (1.0 + 1e-9)


@given(case=chains)
@example(case=Floating.of(663))  # two bodies that a damper alone ties to a soft spring
@few
def test_a_response_at_standstill_is_its_limit(case: Floating) -> None:
    agree(case, "0 rad/s")


@given(case=chains)
@example(case=Floating.of(39_875))  # the numerator of the force into m1 begins with rounding alone
@few
def test_the_worst_from_standstill_on_is_reached_and_never_passed(case: Floating) -> None:
    agree(case, f"0..{TOP} rad/s")


@pytest.mark.slow
@given(case=chains)
@many
def test_many_responses_at_standstill_are_their_limits(case: Floating) -> None:
    agree(case, "0 rad/s")
    agree(case, f"0..{TOP} rad/s")


def answered(document: dict[str, Any]) -> Any:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return solve(from_dict(document), explain=False)


def judge_design(seed: int, samples: int) -> None:
    """No crash, no refused claim; no sampled design keeps limits called impossible, or beats an optimum."""
    case = Floating.of(seed)
    document = case.as_design(seed)
    if not document:
        return
    design = answered(document)
    assert design.status in ("optimal", "feasible", "infeasible", "unproven"), design.claim
    scene, rng = from_dict(document), np.random.default_rng(seed)
    for _ in range(samples):
        x = {v.path: float(np.exp(rng.uniform(np.log(v.low), np.log(v.high)))) for v in scene.variables}
        if all(measure(scene, x, one).value <= one.at_most.value for one in scene.limits.values()):
            assert scene.goal is not None
            assert design.status != "infeasible", "a design exists"
            value = measure(scene, x, scene.goal.response).value
            assert design.status != "optimal" or value >= design.goal[1].value * (1.0 - 1.1e-6), (
                "a better design exists"
            )


@pytest.mark.parametrize("seed", [1, 2, 4, 5, 12, 13, 14, 19, 23, 24, 34, 39])
def test_designs_of_what_floats_are_neither_refused_nor_beaten(seed: int) -> None:
    judge_design(seed, 8)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(100, 160))
def test_many_designs_of_what_floats_are_neither_refused_nor_beaten(seed: int) -> None:
    judge_design(seed, 60)


def endless(seed: int) -> tuple[Floating, dict[str, Any], dict[str, Any]]:
    """A chain with links open, and a reading of it that is infinite at standstill."""
    case = Floating.of(seed)
    name = next(one for one, value in case.at_rest().items() if not np.isfinite(value))
    return case, case.as_design(seed), case.document(f"0..{TOP} rad/s")["measures"][name]


@pytest.mark.parametrize("seed", [9, 14, 23])
def test_a_limit_on_what_has_no_end_at_standstill_leaves_no_design_and_says_why(seed: int) -> None:
    _, document, reading = endless(seed)
    document["limits"]["bad"] = {**reading, "at_most": "1e9 m" if reading["response"] == "displacement" else "1e9 m/s"}
    design = answered(document)
    assert design.status == "infeasible"
    assert design.claim == 'proven by the orders of the speed: at standstill "bad" has no end, whatever the design'
    why = {
        "base": "the motion of base that shaker says by its rate has no end",
    }.get(document["excitations"]["shaker"]["on"], "no spring holds what shaker pushes, and it drifts away")
    assert design.reason == (
        f"bad looks at standstill, where {why}. Begin its range above standstill, or hold the machine to the ground."
    )


@pytest.mark.parametrize("seed", [1, 9, 12, 14, 18, 23])
def test_a_goal_without_end_at_standstill_is_said_and_the_limits_kept(seed: int) -> None:
    _, document, reading = endless(seed)
    document["goal"] = {**reading, "minimise": reading["response"]}
    document["goal"].pop("response")
    design = answered(document)
    assert design.status == "feasible"
    assert design.claim == "every limit holds; the goal has no end at standstill, whatever the design"
    assert all(one.met for one in design.limits.values())


@pytest.mark.parametrize("said", ["velocity", "acceleration"])
@pytest.mark.parametrize("seed", range(4))
def test_a_machine_in_space_rides_with_its_base_at_standstill(seed: int, said: str) -> None:
    """An accelerated frame: every mount is stretched as by the inertia of the body, and the body moves as the base."""
    plant = Plant(seed)
    document = plant.document()
    for mount in document["mounts"].values():
        mount["between"] = ["body", "base"]
    unit = {"velocity": "m/s", "acceleration": "m/s2"}[said]
    shaker = {"kind": "base_motion", "on": "base", "direction": "x", said: f"2 {unit}", "speed": "50 Hz"}
    document |= {"bases": {"base": {}}, "excitations": {"shaker": {**shaker, "varies": "constant"}}}
    on = {"at": "0 Hz"}
    document["measures"] = {
        "x": {"response": said, "of": "eye", "direction": "x", **on},
        "y": {"response": said, "of": "eye", "direction": "y", **on},
        "far": {"response": "displacement", "of": "eye", "direction": "x", **on},
        "travel": {"response": "travel", "of": "m0", "direction": "x", **on},
        "force": {"response": "transmitted_force", "into": "base", "direction": "x", **on},
    }
    scene = from_dict(document)
    found = {name: measure(scene, {}, one).value for name, one in scene.measures.items()}
    asked = {name: on_needed(scene, model_of(scene), one) for name, one in scene.measures.items()}
    form = {name: one.value(model, np.zeros(0)) for name, (model, one) in asked.items()}
    _, _, stiffness = plant.matrices()
    moved = (
        np.linalg.solve(stiffness, -2.0 * plant.mass * np.array([1.0, 0, 0, 0, 0, 0])) if said == "acceleration" else 0
    )
    stretch = abs(float(plant.reads(plant.at[0], np.array([1.0, 0, 0])) @ (moved + np.zeros(6))))
    right = {"x": 2.0, "y": 0.0, "travel": stretch, "force": 2.0 * plant.mass * (said == "acceleration"), "far": np.inf}
    for name, value in right.items():
        assert found[name] == pytest.approx(value, rel=1e-9, abs=1e-8), name
        first = 1e-8 * (
            2.0 * plant.mass if name == "force" else 1.0
        )  # what goes as the speed has a little at the first
        assert form[name] == pytest.approx(value, rel=1e-9, abs=first), name


def test_what_springs_hold_has_a_limit_at_standstill_though_it_is_nothing() -> None:
    """An absorber that follows its disc: what rounding leaves of its twist is not taken for one without end."""
    shafts = {
        f"shaft{n}": {"between": ends, "torsional_stiffness": f"{k} N m/rad", "loss_factor": 0.05}
        for n, ends, k in ((1, ["a", "ground"], 610), (2, ["b", "a"], 338), (3, ["c", "b"], 414))
    }
    same = {"varies": "constant"}
    for inertia in np.linspace(0.03, 0.2, 12).tolist():
        document = {
            "title": "discs",
            "bodies": {name: {"inertia": f"{one} kg m2"} for name, one in (("a", inertia), ("b", 0.06), ("c", 0.17))},
            "links": shafts,
            "absorbers": {"tmd": {"on": "a", "inertia": "0.09 kg m2", "tuning": 1.3, "damping_ratio": 0.1}},
            "excitations": {"turn": {"kind": "moment", "on": "a", "amplitude": "20 N m", "speed": "3 Hz", **same}},
            "measures": {"twist": {"response": "twist", "across": "tmd", "over": "0..18 Hz", "worst": "least"}},
        }  # fmt: skip
        design = answered(document)
        assert design.status == "met", design.claim
        assert design.measures["twist"].value.value < 1e-16


def test_weight_and_a_base_that_is_accelerated_at_standstill_add_up_as_weights_do() -> None:
    """As much more stress in the beam under two bodies as the acceleration is a part of that of gravity."""
    document = {
        "title": "two bodies on a beam",
        "bases": {"floor": {}},
        "bodies": {"lower": {"mass": "100 kg"}, "upper": {"mass": "50 kg"}},
        "links": {
            "beam": {
                "between": ["lower", "floor"],
                "beam": {"kind": "cantilever", "length": "1 m", "modulus": "207 GPa", "diameter": "60 mm"},
            },
            "pad": {"between": ["upper", "lower"], "stiffness": "300 kN/m", "damping": "100 N s/m"},
        },
        "excitations": {
            "shaker": {
                "kind": "base_motion",
                "on": "floor",
                "acceleration": "1 m/s2",
                "speed": "20 Hz",
                "varies": "constant",
            }
        },
        "measures": {
            "weight": {"response": "static_bending_stress", "of": "beam"},
            "both": {"response": "combined_bending_stress", "of": "beam", "at": "0 Hz"},
            "low": {"response": "combined_bending_stress", "of": "beam", "over": "0..0.001 Hz"},
        },
    }  # fmt: skip
    design = answered(document)
    assert design.status == "met", design.claim
    weight, both, low = (one.value.value for one in design.measures.values())
    assert both == pytest.approx(weight * (1.0 + 1.0 / 9.80665), rel=1e-9)
    assert low == pytest.approx(both, rel=1e-6)


def test_an_acceleration_by_a_table_is_read_at_rest_without_a_warning() -> None:
    """Its displacement has no end there, which a curve that begins at rest shows as such."""
    amplitude = Amplitude((Piece(Band(0.0, 10.0), 2.0, 0.1, -2), Piece(Band(10.0, 50.0), 3.0, 0.0, -2)))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = amplitude.at(np.array([0.0, 5.0, 20.0]))
    assert found.tolist() == [np.inf, pytest.approx(0.1), pytest.approx(0.0075)]


@pytest.mark.parametrize(("soft", "damper"), [(6e-5, 0.0), (6.0, 0.0), (9.5e4, 983.0)])
@pytest.mark.parametrize("held", [1.0, 1e-9])
def test_what_hardly_follows_its_base_keeps_its_digits(soft: float, damper: float, held: float) -> None:
    """On a mount of next to nothing it moves by what rounding takes of the base's motion: 3e-5 of it were lost."""
    w, (m, n), (k, c) = 109.0, (249.0, 19.9), (31.2e3 * held, 242.0 * held)
    scene = from_dict({
        "title": "t",
        "bases": {"floor": {}},
        "bodies": {"raft": {"mass": f"{m} kg"}, "part": {"mass": f"{n} kg"}},
        "links": {
            "lower": {"between": ["raft", "floor"], "stiffness": f"{k} N/m", "damping": f"{c} N s/m"},
            "upper": {"between": ["part", "raft"], "stiffness": f"{soft} N/m", "damping": f"{damper} N s/m"},
        },
        "excitations": {
            "e": {"kind": "base_motion", "on": "floor", "displacement": "1 mm", "speed": f"{w} rad/s"}
        },
        "measures": {
            "moves": {"response": "displacement", "of": "part"},
            "gap": {"response": "relative_displacement", "across": "upper"},
            "force": {"response": "transmitted_force", "through": "upper"},
        },
    })  # fmt: skip
    mount = soft + 1j * w * damper
    raft = (k + 1j * w * c) * 1e-3 / (k + 1j * w * c - mount * n * w**2 / (mount - n * w**2) - m * w**2)
    part = raft * mount / (mount - n * w**2)
    right = {"moves": abs(part), "gap": abs(part - raft), "force": abs(mount * (part - raft))}
    assert {name: measure(scene, {}, asked).value for name, asked in scene.measures.items()} == pytest.approx(
        right, rel=1e-10, abs=0.0
    )
