"""Recorded answers of the shaft problems: both planes together, the shaft as a cubic, no formula of whirl."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from vibopt.units import read_quantity

PROBLEMS = Path(__file__).parents[2] / "problems/shafts"
STEEL, ALUMINIUM = 207e9, 71e9
OPERATING = 200.0 * np.pi


def recorded(stem: str) -> dict[str, float]:
    document = tomllib.loads((PROBLEMS / f"{stem}.toml").read_text(encoding="utf-8"))
    dimensions = {"stiffness": "stiffness", "force": "force", "bearings": "force", "stress": "stress"}
    found = {}
    for one in document["expected"]:
        name = one["path"].removeprefix("measures.").removesuffix(".value")
        rate = name in ("critical_speed", "undamped") or name.endswith("worst_at")
        found[name] = read_quantity(
            one["value"], "angular_rate" if rate else dimensions.get(name.split("_")[0], "length")
        ).value
    return found


def bent(modulus: float, diameter: float, span: float) -> tuple[float, float]:
    """Force [N/m] and stress [Pa/m] per deflection of the middle, from the cubic of half a span: y = a s + b s^3.

    It has no moment at the support, no slope in the middle, and moves it by one.
    """
    half, second = 0.5 * span, np.pi * diameter**4 / 64.0
    a, b = np.linalg.solve([[half, half**3], [1.0, 3.0 * half**2]], [1.0, 0.0])
    assert a > 0.0
    shear, moment = -6.0 * b * modulus * second, -6.0 * b * half * modulus * second
    return 2.0 * shear, moment * 0.5 * diameter / second


def whirl(mass: float, k: float, c: float, off: float, speed: float) -> tuple[float, float]:
    """Greatest distance of the centre from the axis [m] and force on the ground [N], x and y solved together."""
    dynamic = k - mass * speed**2
    one = np.array([[dynamic, c * speed], [-c * speed, dynamic]])  # cos and sin parts of a plane
    whole = np.kron(np.eye(2), one)
    turning = mass * off * speed**2 * np.array([1.0, 0.0, 0.0, 1.0])  # along x it is a cosine, along y a sine
    parts = np.linalg.solve(whole, turning).reshape(2, 2)
    angles = np.linspace(0.0, 2.0 * np.pi, 721)
    wave = np.array([np.cos(angles), np.sin(angles)])
    rate = speed * np.array([-np.sin(angles), np.cos(angles)])
    places, forces = parts @ wave, k * (parts @ wave) + c * (parts @ rate)
    return float(np.hypot(*places).max()), float(np.hypot(*forces).max())


def greatest(mass: float, k: float, c: float, off: float, what: int) -> tuple[float, float]:
    """Over the speed: where [rad/s] and how much."""
    own = np.sqrt(k / mass)
    found: Any = minimize_scalar(
        lambda w: -whirl(mass, k, c, off, w)[what], bounds=(0.98 * own, 1.02 * own), options={"xatol": 1e-9 * own}
    )
    return float(found.x), -float(found.fun)


@pytest.mark.parametrize(("stem", "off"), [("rao_9_15", 0.01), ("rao_9_16", 0.001)])
def test_an_undamped_shaft(stem: str, off: float) -> None:
    k, stress = bent(200e9, 0.02, 0.75)
    far, force = whirl(45.0, k, 0.0, off, 40.0 * np.pi)
    right = {
        "stiffness": k,
        "critical_speed": np.sqrt(k / 45.0),
        "whirl": far,
        "bearings": force,
        "stress": stress * far,
    }
    found = recorded(stem)
    assert found == pytest.approx({name: right[name] for name in found}, rel=1e-7)


@pytest.mark.parametrize(
    ("stem", "loads", "modulus", "above"),
    [("rao_9_17", "rao_9_18", STEEL, 146.417), ("rao_9_19", "rao_9_20", ALUMINIUM, 85.75)],
)
def test_a_damped_shaft(stem: str, loads: str, modulus: float, above: float) -> None:
    k, stress = bent(modulus, 0.025, 1.0)
    rotor = 20.0, k, 0.02 * np.sqrt(20.0 * k), 0.005
    speed, far = greatest(*rotor, 0)
    assert above == pytest.approx(1.5 * speed, abs=5e-4)
    whirls = {"running": whirl(*rotor, OPERATING)[0], "critical": far, "above": whirl(*rotor, above)[0]}
    right = {"stiffness": k, "undamped": np.sqrt(k / 20.0), **whirls}
    found = recorded(stem)
    assert found.pop("critical.worst_at") == pytest.approx(speed, rel=1e-6)
    assert found == pytest.approx(right, rel=1e-7)
    forces = {
        "running": whirl(*rotor, OPERATING)[1],
        "critical": greatest(*rotor, 1)[1],
        "above": whirl(*rotor, above)[1],
    }
    right = {f"force_{name}": one for name, one in forces.items()}
    right |= {f"stress_{name}": stress * one for name, one in whirls.items()}
    assert recorded(loads) == pytest.approx(right, rel=1e-7)


def test_a_rotor_given_by_its_stiffness() -> None:
    rotor = 60.0, 3.75e6, 0.1 * np.sqrt(60.0 * 3.75e6), 0.002
    right = {"running": whirl(*rotor, 120.0 * np.pi)[0], "resonance": whirl(*rotor, 250.0)[0]}
    right["on_the_way"] = greatest(*rotor, 0)[1]
    assert recorded("rao_9_21") == pytest.approx(right, rel=1e-7)
