"""The centrifuge that passes its resonance, by a Runge-Kutta method in the frame of its cycles and by closed forms."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from vibopt.units import read_quantity

FILE = Path(__file__).parents[2] / "problems/run_up/centrifuge_through_resonance.toml"
MASS, UNBALANCE, SAG = 400.0, 0.5, 20e-3
LAST, RATE, RATTLE = 50.0 * np.pi, 200.0 * np.pi / 30.0, 8e-3


def greatest_envelope(stiffness: float, damping: float) -> float:
    """Greatest displacement [m] over every angle, of two unbalances a quarter turn apart as one complex one."""

    def rates(time: float, now: Any) -> Any:
        speed = RATE * time
        force = UNBALANCE * (speed**2 - 1j * RATE) * np.exp(0.5j * RATE * time**2)
        return np.array([now[1], (force - damping * now[1] - stiffness * now[0]) / MASS])

    run: Any = solve_ivp(
        rates, (0.0, LAST / RATE), np.zeros(2, dtype=complex), method="DOP853", rtol=1e-10, atol=1e-12,
        dense_output=True, max_step=0.02,
    )  # fmt: skip
    times = np.linspace(0.0, LAST / RATE, 20_001)
    sizes = np.abs(run.sol(times)[0])
    near = int(sizes.argmax()) + np.arange(-3, 4)
    through = np.polynomial.Polynomial.fit(near, sizes[near] ** 2, 6)
    return float(np.sqrt(through(np.linspace(near[0], near[-1], 6001)).max()))


def recorded() -> dict[str, float]:
    """Values of the file by what they are [SI]."""
    document = tomllib.loads(FILE.read_text(encoding="utf-8"))
    kinds = {"stiffness": "stiffness", "damping": "damping", "goal": "force", "slowly": "length"}
    values = [one for one in document["expected"] if one["path"] != "status"]
    rows = {next(key for key in kinds if key in one["path"]): one["value"] for one in values}
    return {key: read_quantity(value, kinds[key]).value for key, value in rows.items()}


def test_the_record_of_the_centrifuge() -> None:
    """The springs sag as far as they may, and the damper is the weakest that keeps the rattle."""
    found = recorded()
    k, c = MASS * 9.80665 / SAG, found["damping"]
    assert found["stiffness"] == pytest.approx(k, rel=1e-7)
    assert greatest_envelope(k, c) == pytest.approx(RATTLE, rel=1e-6)
    assert greatest_envelope(k, 1.01 * c) < RATTLE
    spring = k + 1j * LAST * c
    assert found["goal"] == pytest.approx(abs(spring / (spring - MASS * LAST**2)) * UNBALANCE * LAST**2, rel=1e-6)
    for stiffer, part in ((1.0, 0.99), (1.01, 0.92), (1.02, 0.85), (1.04, 0.68), (1.06, 0.45)):  # what has less force
        spring = stiffer * k + 1j * LAST * part * c
        assert abs(spring / (spring - MASS * LAST**2)) * UNBALANCE * LAST**2 < found["goal"]
        assert greatest_envelope(stiffer * k, part * c) > RATTLE
    ratio = c / (2.0 * np.sqrt(k * MASS))
    slowly = UNBALANCE / MASS / (2.0 * ratio * np.sqrt(1.0 - ratio**2))
    assert found["slowly"] == pytest.approx(slowly, rel=1e-6)
