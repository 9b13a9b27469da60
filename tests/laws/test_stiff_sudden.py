"""A sudden sine on a mass whose damper is far faster than its spring: by its modes, no integrator feels its way."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import vibopt as vo
from vibopt.mechanics.beating import highest

MASSES, SPRINGS, DAMPERS = (2.0, 1.0), (20.0, 50.0), (300_000.0, 2.0)
FORCE, SPEED = 80.0, 1.547


def by_modes() -> float:
    """Greatest rate of the upper mass, from rest on."""
    across = np.eye(2) - np.eye(2, k=-1)
    stiff, damped = (across.T @ np.diag(one) @ across for one in (SPRINGS, DAMPERS))
    heavy = np.array(MASSES)[:, None]
    a = np.block([[np.zeros((2, 2)), np.eye(2)], [-stiff / heavy, -damped / heavy]])
    load = np.array([0.0, 0.0, 0.0, FORCE / MASSES[1]])
    driven = np.linalg.solve(1j * SPEED * np.eye(4) - a, load)  # force sin(w t)
    rates, shapes = np.linalg.eig(a)
    shares = np.linalg.solve(shapes, -np.imag(driven).astype(complex))
    most = 0.0
    for low, high, many in ((0.0, 60.0, 400_001), (60.0, 3000.0, 2_000_001)):
        times = np.linspace(low, high, many)
        free = np.real((shapes[3] * shares) @ np.exp(rates[:, None] * times))
        rate = np.abs(np.imag(driven[3] * np.exp(1j * SPEED * times)) + free)
        most = max(most, float(rate.max()))
    return most


def test_a_sudden_sine_on_a_stiff_damper_is_followed_by_modes(monkeypatch: Any) -> None:
    monkeypatch.setattr("scipy.integrate.solve_ivp", None)
    ends = ("ground", "low", "high")
    document = {
        "title": "stiff damper",
        "bodies": {name: {"mass": f"{mass} kg"} for name, mass in zip(ends[1:], MASSES, strict=True)},
        "links": {
            f"l{i}": {"between": [ends[i + 1], ends[i]], "stiffness": f"{k} N/m", "damping": f"{c} N s/m"}
            for i, (k, c) in enumerate(zip(SPRINGS, DAMPERS, strict=True))
        },
        "excitations": {
            "push": {"kind": "force", "on": "high", "amplitude": f"{FORCE} N", "speed": f"{SPEED} rad/s",
                     "begins": "suddenly"}
        },
        "measures": {"rate": {"response": "peak_velocity", "of": "high"}},
    }  # fmt: skip
    answer = vo.solve(vo.from_dict(document))
    assert answer.status == "met", answer.claim
    assert answer.measures["rate"].value.value == pytest.approx(by_modes(), rel=1e-6)


def test_a_wave_that_has_faded_sets_no_pace() -> None:
    """A sine that lasts and a swing that fades, and beside them what is a part of 1e-20 and far faster."""
    rates, waves = np.array([1.03e-5j, -6.67e-6 + 4.67e-5j]), np.array([2.5927 - 0.088j, -2.568 + 0.039j])
    alone = highest(rates, waves, 6.2e10, 0.0246)
    beside = highest(np.append(rates, -1.0), np.append(waves, 3e-20), 6.2e10, 0.0246)
    assert alone[0] == pytest.approx(beside[0], rel=1e-12)
    assert alone[1] == pytest.approx(beside[1], rel=1e-12)
    assert not alone[2]
    assert not beside[2]
