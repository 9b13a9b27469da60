"""Machines in space in time and under white noise: against matrix exponentials and the equation of Lyapunov."""

from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.linalg import expm, solve_continuous_lyapunov

import vibopt as vo
from space_machine import Plant, plants, rotation
from vibopt.scene.read import from_dict

FEW = settings(max_examples=8, deadline=None, suppress_health_check=[HealthCheck.too_slow])
SAMPLES = 20_000
Array = NDArray[np.float64]


def on_deck(plant: Plant) -> dict[str, Any]:
    """The plant on a base."""
    document = plant.document()
    del document["excitations"]
    for mount in document["mounts"].values():
        mount["between"] = ["body", "deck"]
    return {**document, "bases": {"deck": {}}}


def answered(document: dict[str, Any], shaker: dict[str, Any], measures: dict[str, Any]) -> dict[str, float]:
    """Measures under one excitation, on the machine as built; both routes agree."""
    design = vo.solve(from_dict({**document, "excitations": {"shaker": shaker}, "measures": measures}))
    assert design.status == "met", design.claim
    return {name: row.value.value for name, row in design.measures.items()}


def system(plant: Plant) -> tuple[Array, Array, Array, Array]:
    """Rates of places and velocities (12, 12), the inverse mass, damping and stiffness."""
    mass, damping, stiffness = plant.matrices()
    inverse = np.linalg.inv(mass)
    return (
        np.block([[np.zeros((6, 6)), np.eye(6)], [-inverse @ stiffness, -inverse @ damping]]),
        inverse,
        damping,
        stiffness,
    )


def history(a: Array, push: Array, omega: float, free: float) -> tuple[Array, Array]:
    """States under a half sine of one along `push` and for a time behind it, and the signal, sample by sample."""
    size = len(a)
    whole = np.zeros((size + 2, size + 2))
    whole[:size, :size], whole[:size, size] = a, push
    whole[size, size + 1], whole[size + 1, size] = omega, -omega
    now, found = np.concatenate([np.zeros(size + 1), [1.0]]), []
    step = expm(whole * (np.pi / omega / SAMPLES))
    for _ in range(SAMPLES + 1):
        found.append(now)
        now = step @ now
    now, onward = found[-1].copy(), expm(a * (free / SAMPLES))
    now[size:] = 0.0
    for _ in range(SAMPLES):
        now = np.concatenate([onward @ now[:size], np.zeros(2)])
        found.append(now)
    every = np.array(found)
    return every[:, :size], every[:, size]


@FEW
@given(plants, st.floats(0.05, 3.0))
def test_a_pulse_on_a_body_moves_it_as_its_matrices_say(plant: Plant, long: float) -> None:
    slow = float(plant.frequencies()[0])
    omega = np.pi / (long * 2.0 * np.pi / slow)
    a, inverse, damping, stiffness = system(plant)
    load, row = plant.reads(plant.force_at, plant.push), plant.reads(plant.point, plant.way)
    states, signal = history(a, np.concatenate([np.zeros(6), inverse @ load]), omega, 8.0 * np.pi / slow)
    fast = states @ a[6:].T + signal[:, None] * (inverse @ load)
    own = {
        "moved": states[:, :6] @ row,
        "speed": states[:, 6:] @ row,
        "fast": fast @ row,
        "force": (states[:, :6] @ stiffness + states[:, 6:] @ damping)[:, :3] @ plant.way,
    }
    found = answered(
        plant.document(),
        {"kind": "pulse", "on": "body", "shape": "half sine", "amplitude": "1 N", "duration": f"{np.pi / omega!r} s",
         "direction": plant.push.tolist(), "at": [f"{one!r} m" for one in plant.force_at.tolist()]},
        {
            "moved": {"response": "peak_displacement", "of": "eye", "direction": plant.way.tolist()},
            "speed": {"response": "peak_velocity", "of": "eye", "direction": plant.way.tolist()},
            "fast": {"response": "peak_acceleration", "of": "eye", "direction": plant.way.tolist()},
            "force": {"response": "peak_force", "into": "ground", "direction": plant.way.tolist()},
        },
    )  # fmt: skip
    for name, values in own.items():
        sampled = float(np.abs(values).max())
        assert sampled <= found[name] * (1.0 + 1e-9)
        assert found[name] == pytest.approx(sampled, rel=1e-4)


@FEW
@given(plants)
def test_the_travel_on_a_base_is_that_of_the_matrices(plant: Plant) -> None:
    """Counted from the base, a pulse of its acceleration is a force on the mass."""
    slow = float(plant.frequencies()[0])
    omega = 1.3 * slow
    a, _, damping, stiffness = system(plant)
    led = np.concatenate([np.zeros(6), -plant.push, np.zeros(3)])
    states, _ = history(a, led, omega, 8.0 * np.pi / slow)
    moved = [states[:, :6] @ plant.reads(plant.at[0], axis) for axis in plant.axes[0]]
    own = {
        "travel": float(np.abs(moved).max()),
        "force": float(np.abs((states[:, :6] @ stiffness + states[:, 6:] @ damping)[:, :3] @ plant.way).max()),
    }
    found = answered(
        on_deck(plant),
        {"kind": "pulse", "on": "deck", "shape": "half sine", "acceleration": "1 m/s²",
         "duration": f"{np.pi / omega!r} s", "direction": plant.push.tolist()},
        {
            "travel": {"response": "peak_travel", "of": "m0"},
            "force": {"response": "peak_force", "into": "deck", "direction": plant.way.tolist()},
        },
    )  # fmt: skip
    for name, value in own.items():
        assert value <= found[name] * (1.0 + 1e-9)
        assert found[name] == pytest.approx(value, rel=1e-4)


@FEW
@given(plants)
def test_noise_of_a_base_and_of_a_force_is_that_of_lyapunov(plant: Plant) -> None:
    a, inverse, *_ = system(plant)
    row = plant.reads(plant.at[0], plant.axes[0][2])
    force = np.concatenate([np.zeros(6), inverse @ plant.reads(plant.force_at, plant.push)])
    base = np.concatenate([np.zeros(6), -plant.push, np.zeros(3)])
    shaker = {"kind": "white_noise", "direction": plant.push.tolist()}
    at = [f"{one!r} m" for one in plant.force_at.tolist()]
    asked = {"travel": {"response": "rms_travel", "of": "m0", "direction": plant.axes[0][2].tolist()}}
    for document, given_, push in (
        (plant.document(), {**shaker, "on": "body", "at": at, "density": "2 N²/Hz"}, force),
        (on_deck(plant), {**shaker, "on": "deck", "density": "2 (m/s²)²/Hz"}, base),
    ):
        square = solve_continuous_lyapunov(a, -np.outer(push, push))  # one sided 2 per Hz: 1 on both sides
        value = float(np.sqrt(row @ square[:6, :6] @ row))
        assert answered(document, given_, asked)["travel"] == pytest.approx(value, rel=1e-8)


@FEW
@given(plants)
def test_a_body_that_is_let_go_slides_without_turning(plant: Plant) -> None:
    a, *_ = system(plant)
    state = np.concatenate([0.01 * plant.push, np.zeros(3), -0.2 * plant.push, np.zeros(3)])
    row, times = plant.reads(plant.point, plant.way), np.linspace(0.0, 20.0 / plant.frequencies()[0], SAMPLES)
    step, values = expm(a * times[1]), []
    for _ in times:
        values.append(abs(float(state[:6] @ row)))
        state = step @ state
    found = answered(
        plant.document(),
        {"kind": "release", "on": "body", "displacement": "10 mm", "velocity": "-0.2 m/s",
         "direction": plant.push.tolist()},
        {"moved": {"response": "peak_displacement", "of": "eye", "direction": plant.way.tolist()}},
    )  # fmt: skip
    assert max(values) <= found["moved"] * (1.0 + 1e-9)
    assert found["moved"] == pytest.approx(max(values), rel=1e-4)


@FEW
@given(plants, st.tuples(*[st.floats(-3.0, 3.0)] * 6))
def test_other_axes_change_nothing_in_time(plant: Plant, by: tuple[float, ...]) -> None:
    found = []
    for one in (plant, plant.turned(rotation(np.array(by[:3])), np.array(by[3:]))):
        shaker = {"kind": "drop", "on": "deck", "height": "0.1 m", "direction": one.push.tolist()}
        asked = {
            "force": {"response": "peak_force", "through": "m1", "direction": one.way.tolist()},
            "travel": {"response": "peak_travel", "of": "m1"},
        }
        found.append(list(answered(on_deck(one), shaker, asked).values()))
    assert found[0] == pytest.approx(found[1], rel=1e-7)


@FEW
@given(plants)
def test_a_place_on_a_machine_that_runs_up_moves_as_its_body(plant: Plant) -> None:
    """What is held by mounts holds its places, wherever the force acts; the centre of mass is one of them."""
    document, slow = plant.document(), float(plant.frequencies()[0]) / (2.0 * np.pi)
    document["points"] = {"heart": {"on": "body", "at": document["bodies"]["body"]["centre"]}}
    shaker = {"kind": "force", "amplitude": "1 N", "speed": f"{1.5 * slow!r} Hz", "direction": plant.push.tolist(),
              "varies": "constant",
              "run_up": {"from": f"{0.7 * slow!r} Hz", "acceleration": f"{0.1 * slow * slow!r} Hz/s"}}  # fmt: skip
    way = {"response": "peak_displacement", "direction": plant.way.tolist()}
    found = [
        answered(document, {**shaker, "on": on}, {"moved": {**way, "of": of}})["moved"]
        for on, of in (("body", "body"), ("heart", "body"), ("body", "heart"))
    ]
    assert found == pytest.approx([found[0]] * 3, rel=1e-7)


ALONG_X: dict[str, dict[str, Any]] = {
    "drop": {"kind": "drop", "on": "deck", "velocity_change": "1 m/s"},
    "sudden": {"kind": "force", "on": "case", "amplitude": "100 N", "speed": "8 Hz", "begins": "suddenly"},
    "step": {"kind": "pulse", "shape": "step", "on": "case", "amplitude": "100 N"},
    "any duration": {"kind": "pulse", "shape": "half sine", "on": "deck", "acceleration": "100 m/s2",
                     "duration_up_to": "30 ms"},
    "run-up": {"kind": "force", "on": "case", "amplitude": "100 N", "speed": "8 Hz", "varies": "constant",
               "run_up": {"from": "1 Hz", "to": "8 Hz", "acceleration": "2 Hz/s"}},
    "noise": {"kind": "white_noise", "on": "deck", "density": "1 (m/s²)²/Hz"},
}  # fmt: skip


@pytest.mark.parametrize("shaker", ALONG_X)
def test_what_symmetry_keeps_still_is_zero(shaker: str) -> None:
    """Neither rounding of what moves beside it, nor hours of looking for its peak."""
    corners = [[f"{x} m", f"{y} m", "0 m"] for x in (0.2, -0.2) for y in (0.15, -0.15)]
    document = {
        "bases": {"deck": {}},
        "bodies": {"case": {"mass": "20 kg", "centre": ["0 m", "0 m", "0.15 m"], "motion": "space",
                            "inertia": ["0.5 kg m2", "0.6 kg m2", "0.7 kg m2"]}},
        "mounts": {"feet": {"between": ["case", "deck"], "at": corners, "stiffness": "20 kN/m", "shear_ratio": 0.5,
                            "damping": "60 N s/m"}},
    }  # fmt: skip
    kind = "rms_acceleration" if shaker == "noise" else "peak_acceleration"
    ways = {way: {"response": kind, "of": "case", "direction": way} for way in "xyz"}
    found = answered(document, {**ALONG_X[shaker], "direction": "x"}, ways)
    assert found["x"] > 1.0
    assert max(found["y"], found["z"]) <= (1e-9 * found["x"] if shaker == "run-up" else 0.0)


@pytest.mark.parametrize(
    ("held", "asked", "said"),
    [
        ({"damping": "60 N s/m"}, {"response": "peak_displacement", "of": "case", "direction": "z"},
         "and case with it. Ask for the peak_travel of a mount."),
        ({"loss_factor": 0.1}, {"response": "peak_travel", "of": "feet"},
         "but mounts.feet has a loss_factor, which speaks of steady harmonic motion only. Give it damping instead."),
    ],
)  # fmt: skip
def test_the_way_out_is_one_that_machines_in_space_have(held: Any, asked: dict[str, str], said: str) -> None:
    corners = [[f"{x} m", f"{y} m", "0 m"] for x in (0.2, -0.2) for y in (0.15, -0.15)]
    with pytest.raises(vo.InputError) as refused:
        vo.solve(from_dict({
            "bases": {"deck": {}},
            "bodies": {"case": {"mass": "20 kg", "inertia": ["0.5 kg m2", "0.6 kg m2", "0.7 kg m2"]}},
            "mounts": {"feet": {"between": ["case", "deck"], "at": corners, "stiffness": "20 kN/m", "shear_ratio": 0.5,
                                **held}},
            "excitations": {"jolt": {"kind": "pulse", "on": "deck", "shape": "half sine", "acceleration": "9 m/s²",
                                     "duration": "9 ms", "direction": "z"}},
            "measures": {"asked": asked},
        }))  # fmt: skip
    assert said in str(refused.value)
