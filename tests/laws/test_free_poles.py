"""Damping ratios, decrements and decay rates where bodies drift freely, and where poles meet."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

import vibopt as vo
from vibopt.arrays import ComplexArray, FloatArray
from vibopt.scene.read import from_dict, from_text
from vibopt.solve import boxes_first

few = settings(derandomize=True, database=None, deadline=None, max_examples=60)
LINE = ("mass", "kg", "", "N/m", "N s/m")
TURNING = ("inertia", "kg m2", "torsional_", "N m/rad", "N m s/rad")


def drawn(seed: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Two to five inertias, and the springs and dampers between them."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, 6))
    masses, springs = 10.0 ** rng.uniform(-1.0, 3.0, count), 10.0 ** rng.uniform(3.0, 6.0, count - 1)
    return masses, springs, 10.0 ** rng.uniform(-3.0, -1.0) * np.sqrt(springs * masses[1:])


def drifting(numbers: tuple[FloatArray, FloatArray, FloatArray], words: tuple[str, ...]) -> dict[str, Any]:
    """A row of bodies that nothing holds."""
    masses, springs, dampers = numbers
    inertia, unit, twist, stiff, dash = words
    links = {
        f"l{i}": {
            "between": [f"b{i}", f"b{i + 1}"],
            f"{twist}stiffness": f"{float(k)!r} {stiff}",
            f"{twist}damping": f"{float(c)!r} {dash}",
        }
        for i, (k, c) in enumerate(zip(springs, dampers, strict=True))
    }
    return {"bodies": {f"b{i}": {inertia: f"{float(m)!r} {unit}"} for i, m in enumerate(masses)}, "links": links}


def stretches(masses: FloatArray, springs: FloatArray, dampers: FloatArray) -> ComplexArray:
    """Poles e^{s t} of the stretches alone, which know no drift: none of them is next to zero."""
    across = np.diff(np.eye(len(masses)), axis=0)
    flexible = across @ np.diag(1.0 / masses) @ across.T
    still, one = np.zeros_like(flexible), np.eye(len(springs))
    found: ComplexArray = np.linalg.eigvals(np.block([[still, one], [-flexible * springs, -flexible * dampers]]))
    return found


def ratios(poles: ComplexArray) -> FloatArray:
    found: FloatArray = np.sort((-poles.real / np.abs(poles))[poles.imag > 0.0])
    return found


@few
@given(seed=st.integers(0, 100_000), words=st.sampled_from([LINE, TURNING]))
def test_what_drifts_is_damped_as_its_stretches_are(seed: int, words: tuple[str, ...]) -> None:
    numbers = drawn(seed)
    poles = stretches(*numbers)
    every = ratios(poles)
    asked = {f"z{i}": {"response": "damping_ratio", "mode": i + 1} for i in range(len(every))}
    asked |= {name: {"response": name} for name in ("logarithmic_decrement", "decay_rate")}
    answer = vo.solve(from_dict(drifting(numbers, words) | {"measures": asked}))
    assert answer.status == "met"
    told = {name: row.value.value for name, row in answer.measures.items()}
    assert [told[f"z{i}"] for i in range(len(every))] == pytest.approx(every, rel=1e-6)
    assert told["logarithmic_decrement"] == pytest.approx(2.0 * math.pi * every[0] / math.sqrt(1.0 - every[0] ** 2))
    assert told["decay_rate"] == pytest.approx(-poles.real.max(), rel=1e-6)


@pytest.mark.parametrize("response", ["damping_ratio", "logarithmic_decrement"])
def test_least_damper_of_a_drive_line_that_drifts(response: str) -> None:
    """The first spring is softest at best, and its damper gives the first mode just the ratio that is asked."""
    masses = np.array([2.0, 0.4, 11.0])
    document = drifting((masses, np.array([1.0, 8e4]), np.array([1.0, 20.0])), TURNING)
    document["links"]["l0"]["torsional_stiffness"] = {"from": "5000 N m/rad", "to": "500000 N m/rad"}
    document["links"]["l0"]["torsional_damping"] = {"from": "1 N m s/rad", "to": "2000 N m s/rad"}
    least = 0.03 if response == "damping_ratio" else 2.0 * math.pi * 0.03 / math.sqrt(1.0 - 0.03**2)
    document |= {"limits": {"z": {"response": response, "at_least": least}}}
    answer = vo.solve(from_dict(document | {"goal": {"minimise": "torsional_damping", "of": "l0"}}))

    def missed(damping: float) -> float:
        return float(ratios(stretches(masses, np.array([5e3, 8e4]), np.array([damping, 20.0])))[0]) - 0.03

    assert answer.goal is not None
    assert answer.goal[1].value == pytest.approx(brentq(missed, 1.0, 20.0), rel=1e-6)


@pytest.mark.parametrize("decrement", [0.01, 0.5, 5.0, 4e4])
@pytest.mark.parametrize("stiffness", [20e3, {"from": "5 kN/m", "to": "800 kN/m"}], ids=["one number", "two"])
def test_least_damper_of_one_mass_under_a_decrement(decrement: float, stiffness: Any) -> None:
    """c = 2 z sqrt(k m) on the softest spring, whatever answers it."""
    scene = {
        "bodies": {"m": {"mass": "80 kg"}},
        "links": {
            "l": {
                "between": ["m", "ground"],
                "stiffness": stiffness if isinstance(stiffness, dict) else f"{stiffness} N/m",
                "damping": {"from": "0.01 N s/m", "to": "9 kN s/m"},
            }
        },
        "limits": {"d": {"response": "logarithmic_decrement", "at_least": decrement}},
        "goal": {"minimise": "damping", "of": "l"},
    }
    answer = vo.solve(from_dict(scene))
    ratio = decrement / math.hypot(decrement, 2.0 * math.pi)
    softest = 5e3 if isinstance(stiffness, dict) else stiffness
    assert answer.goal is not None
    assert answer.goal[1].value == pytest.approx(2.0 * ratio * math.sqrt(softest * 80.0), rel=1e-5)


@pytest.mark.parametrize(("mass", "stiffness"), [(0.3, 1e6)])
def test_three_poles_that_meet_are_known_to_the_root_that_rounding_leaves(mass: float, stiffness: float) -> None:
    """A damper held by a spring eight times as stiff: three poles at sqrt(3) of the natural frequency."""
    frequency = math.sqrt(stiffness / mass)
    answer = vo.solve(
        from_text(f"""
bodies.a.mass = "{mass} kg"
bodies.j.mass = "0 kg"
links.k = {{ between = ["a", "ground"], stiffness = "{stiffness} N/m" }}
links.s = {{ between = ["a", "j"], stiffness = {{ from = "{stiffness} N/m", to = "{30.0 * stiffness} N/m" }} }}
links.c = {{ between = ["j", "ground"], damping = {{ from = "{0.1 * mass * frequency} N s/m", to = "{
            20.0 * mass * frequency
        } N s/m" }} }}
goal.maximise = "decay_rate"
""")
    )
    assert answer.status == "feasible"
    assert answer.goal is not None
    assert answer.goal[1].value == pytest.approx(math.sqrt(3.0) * frequency, rel=1e-4)


@pytest.mark.parametrize("decrement", [0.9])
def test_the_lightest_absorber_for_a_decrement_makes_poles_meet(
    decrement: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On what nothing else damps both modes are alike at best, their ratio half the root of the mass ratio."""
    monkeypatch.setattr(boxes_first, "_WORK", 8e6)  # starts find it, and boxes leave it open
    monkeypatch.setattr(boxes_first, "_LONGER", 5000)
    answer = vo.solve(
        from_text(f"""
bodies.deck.mass = "2 t"
links.k = {{ between = ["deck", "ground"], stiffness = "3 MN/m" }}
limits.l = {{ response = "logarithmic_decrement", at_least = {decrement} }}
goal.minimise = "absorber_mass"
[absorbers.t]
on = "deck"
mass_ratio = {{ from = 0.002, to = 0.3 }}
tuning = {{ from = 0.7, to = 1.2 }}
damping_ratio = {{ from = 0.01, to = 0.6 }}
""")
    )
    ratio = decrement / math.hypot(decrement, 2.0 * math.pi)
    assert answer.goal is not None
    assert answer.goal[1].value == pytest.approx(4.0 * ratio**2 * 2000.0, rel=1e-4)


def test_two_that_drift_are_proven_best_where_they_are_damped_critically() -> None:
    """On the stiffest spring, with c = 2 sqrt(k m) of both masses: two real poles meet."""
    document = drifting((np.array([2.0, 11.0]), np.array([1.0]), np.array([1.0])), TURNING)
    document["links"]["l0"]["torsional_stiffness"] = {"from": "500 N m/rad", "to": "50000 N m/rad"}
    document["links"]["l0"]["torsional_damping"] = {"from": "1 N m s/rad", "to": "20000 N m s/rad"}
    answer = vo.solve(from_dict(document | {"goal": {"maximise": "decay_rate"}}))
    assert answer.status == "optimal"
    assert answer.goal is not None
    assert answer.goal[1].value == pytest.approx(math.sqrt(5e4 * 13.0 / 22.0), rel=2e-5)


def test_where_nothing_swings_at_best_it_is_boxes_that_leave_too_much_open(monkeypatch: pytest.MonkeyPatch) -> None:
    """A ratio above one is of two real poles, which boxes know nothing of; that the goal has no bounds is not said."""
    monkeypatch.setattr(boxes_first, "_WORK", 8e6)
    document = drifting((np.array([30.0, 90.0]), np.array([1.0]), np.array([1.0])), LINE)
    document["links"]["l0"]["stiffness"] = {"from": "20 kN/m", "to": "400 kN/m"}
    document["links"]["l0"]["damping"] = {"from": "100 N s/m", "to": "40 kN s/m"}
    answer = vo.solve(from_dict(document | {"goal": {"maximise": "damping_ratio"}}))
    assert answer.goal is not None
    assert answer.goal[1].value == pytest.approx(40e3 / (2.0 * math.sqrt(2e4 * 22.5)))
    assert answer.claim.endswith("no useful bound: boxes of all variables leave too much open")
