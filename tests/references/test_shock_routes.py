"""Recorded answers of shock problems by a Runge-Kutta method on the printed equations of motion."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from vibopt.units import read_quantity

PROBLEMS = Path(__file__).parents[2] / "problems/shock"
HEAD, COLUMN, BASE, BLOCK = 500.0, 480e3, 1000.0, 500.0
DAMPER = 2.0 * 0.15 * np.sqrt(COLUMN * HEAD)
SOURCES = {"crane": (20e-6, 60.0, 20.0 * np.pi, 0.1), "press": (30e-6, 80.0, 30.0 * np.pi, 0.0)}
SOURCES["compressor"] = (25e-6, 40.0, 40.0 * np.pi, 0.0)


def recorded(stem: str, dimension: str) -> float:
    document = tomllib.loads((PROBLEMS / f"{stem}.toml").read_text(encoding="utf-8"))
    return read_quantity(next(one["value"] for one in document["expected"] if one["path"] != "status"), dimension).value


def ground(names: tuple[str, ...], time: float) -> complex:
    """Displacement [m] and, as the imaginary part, velocity [m/s] of the ground (E1 to E7 of the print)."""
    total = 0.0j
    for name in names:
        size, far, omega, fades = SOURCES[name]
        wave = size * np.exp(-0.005 * far - fades * omega * time)
        sine, cosine = np.sin(omega * time), np.cos(omega * time)
        total += wave * (sine + 1j * omega * (cosine - fades * sine))
    return total


def from_rest(k: float, *names: str) -> float:
    """Greatest displacement of the head [m] by E10 of the print."""
    c = 0.2 * np.sqrt(BLOCK * k)

    def rates(time: float, now: Any) -> Any:
        moved = ground(names, time)
        column = COLUMN * (now[0] - now[1]) + DAMPER * (now[2] - now[3])
        isolator = k * (moved.real - now[0]) + c * (moved.imag - now[2])
        return np.array([now[2], now[3], (isolator - column) / (BASE + BLOCK), column / HEAD])

    run: Any = solve_ivp(rates, (0.0, 2.0), np.zeros(4), method="DOP853", rtol=1e-10, atol=1e-16, dense_output=True)
    times = np.linspace(0.0, 2.0, 4001)
    sizes = np.abs(run.sol(times)[1])
    near = int(sizes.argmax()) + np.arange(-3, 4)
    through = np.polynomial.Polynomial.fit(near, sizes[near], 6)
    return float(through(np.linspace(near[0], near[-1], 6001)).max())


def steady(k: float, name: str) -> float:
    """Steady amplitude of the head [m]."""
    size, far, w, _ = SOURCES[name]
    support, column = k + 0.2j * w * np.sqrt(BLOCK * k), COLUMN + 1j * w * DAMPER
    stiffness = np.array([[support + column - w * w * (BASE + BLOCK), -column], [-column, column - w * w * HEAD]])
    return abs(size * np.exp(-0.005 * far) * np.linalg.solve(stiffness, np.array([support, 0.0]))[1])


SUMS: dict[str, Callable[[float], float]] = {
    "rao_9_72": lambda k: sum(from_rest(k, name) for name in SOURCES),
    "rao_9_72_together": lambda k: from_rest(k, *SOURCES),
    "rao_9_72_steady": lambda k: from_rest(k, "crane") + steady(k, "press") + steady(k, "compressor"),
}


@pytest.mark.parametrize("stem", SUMS)
def test_the_records_of_the_milling_machine(stem: str) -> None:
    """The cutter moves by 2.5 µm on the recorded spring, and by more on a stiffer one."""
    k = recorded(stem, "stiffness")
    assert SUMS[stem](k) == pytest.approx(2.5e-6, rel=1e-6)
    assert SUMS[stem](0.99 * k) < 2.5e-6 < SUMS[stem](1.01 * k)


def test_the_record_of_the_tower_under_a_blast_of_any_length() -> None:
    """Undamped, the first peak under a half sine, over its static value, at its greatest over the length."""
    r = 0.5 / np.linspace(0.75, 0.9, 400_001)
    factor = (np.sin(2.0 * np.pi * r / (1.0 + r)) / (1.0 - r)).max()
    assert recorded("rao_9_50_any_length", "stiffness") == pytest.approx(factor * 10e3 / 0.5, rel=1e-7)


def test_the_record_of_the_cushion() -> None:
    """Mindlin's spring and damper under a step of velocity, solved outright: the first peaks of x'' and of x."""
    ratio, velocity = 0.2, 1.3 * np.sqrt(2.0 * 9.80665 * 0.9)
    ring = np.sqrt(1.0 - ratio**2)
    handed = np.exp(-ratio / ring * np.arctan2(ring * (1.0 - 4.0 * ratio**2), ratio * (3.0 - 4.0 * ratio**2)))
    rate = 60.0 * 9.80665 / (velocity * handed)
    room = velocity / rate * np.exp(-ratio / ring * np.arccos(ratio))
    document = tomllib.loads((PROBLEMS / "packaging_cushion.toml").read_text(encoding="utf-8"))
    assert recorded("packaging_cushion", "stiffness") == pytest.approx(4.0 * rate**2, rel=1e-7)
    assert read_quantity(document["expected"][1]["value"], "length").value == pytest.approx(room, rel=1e-7)


MASS, CENTRE, INERTIA = 20.0, np.array([0.02, 0.01, 0.15]), np.diag([0.5, 0.6, 0.7])
FEET = [np.array([x, y, 0.0]) - CENTRE for x in (0.2, -0.2) for y in (0.15, -0.15)]
SHOCK, LONG = 30.0 * 9.80665, 0.011


def _moved(arm: Any) -> Any:
    """How a place moves with the centre of the case and its turns, (3, 6)."""
    x, y, z = arm
    return np.array([[1, 0, 0, 0, z, -y], [0, 1, 0, -z, 0, x], [0, 0, 1, y, -x, 0.0]])


def case_struck(k: float, c: float) -> tuple[float, float]:
    """Greatest upward acceleration of the screen [m/s^2] and travel of a foot [m], by exponentials of its states."""
    mass = np.block([[MASS * np.eye(3), np.zeros((3, 3))], [np.zeros((3, 3)), INERTIA]])
    ways = np.diag([0.7, 0.7, 1.0])
    whole: Any = sum(_moved(arm).T @ ways @ _moved(arm) for arm in FEET)
    inverse = np.linalg.inv(mass)
    a = np.block([[np.zeros((6, 6)), np.eye(6)], [-inverse @ whole * k, -inverse @ whole * c]])  # counted from the deck
    signal = np.zeros((14, 14))
    signal[:12, :12], signal[8, 12] = a, -SHOCK
    signal[12, 13], signal[13, 12] = np.pi / LONG, -np.pi / LONG
    now, states = np.concatenate([np.zeros(13), [1.0]]), []
    for count, step in ((1100, expm(signal * 1e-5)), (12_000, expm(np.pad(a, (0, 2)) * 1e-5))):
        for _ in range(count):
            states.append(now)
            now = step @ now
    every = np.array(states)[:, :12]
    travel = max(float(np.abs(every[:, :6] @ _moved(arm).T).max()) for arm in FEET)
    forces = -(every[:, :6] * k + every[:, 6:] * c) @ whole @ inverse
    return float(np.abs(forces @ _moved(np.array([0.2, 0.0, 0.35]) - CENTRE)[2]).max()), travel


def test_the_record_of_the_case_on_four_mounts() -> None:
    """It meets the travel, and no other design near it that does shakes the screen less."""
    best, k, c = recorded("case_on_four_mounts", "acceleration"), 13781.958, 230.490555
    fast, travel = case_struck(k, c)
    assert (fast, travel) == pytest.approx((best, 0.025), rel=1e-5)
    around = [case_struck(k * p, c * q) for p in (0.93, 0.98, 1.0, 1.02, 1.07) for q in (0.93, 0.98, 1.0, 1.02, 1.07)]
    assert all(other > best * (1.0 - 1e-5) for other, room in around if room <= 0.025 * (1.0 + 1e-6))


MODES = np.array([[8.2, 0.02, 14e3, 1.0, -0.8], [14.5, 0.02, 14e3, 0.7, 1.0], [21.0, 0.03, 10e3, -0.4, 0.9]]).T


def scale_shaken(k: float, c: float) -> tuple[float, float]:
    """Greatest acceleration of the scale and greatest stretch of its feet, by the printed modes of its floor."""
    frequency, ratio, mass, bay, table = MODES
    rate, row = 2.0 * np.pi * frequency, np.append(-table, 1.0)
    heavy = np.append(mass, 90.0)
    stiffness = np.diag(np.append(mass * rate**2, 0.0)) + k * np.outer(row, row)
    damping = np.diag(np.append(2.0 * ratio * mass * rate, 0.0)) + c * np.outer(row, row)
    whole = np.zeros((10, 10))
    whole[:4, 4:8] = np.eye(4)
    whole[4:8, :4], whole[4:8, 4:8] = -stiffness / heavy[:, None], -damping / heavy[:, None]
    free = whole.copy()
    whole[4:8, 8], whole[8, 9], whole[9, 8] = 20e3 * np.append(bay, 0.0) / heavy, np.pi / 0.025, -np.pi / 0.025
    now, states = np.append(np.zeros(9), 1.0), []
    for count, step in ((2500, expm(whole * 1e-5)), (40_000, expm(free * 1e-5))):
        for _ in range(count):
            states.append(now)
            now = step @ now
        now[8:] = 0.0
    every = np.array(states)
    return float(np.abs(every @ free[7]).max()), float(np.abs(every[:, :4] @ row).max())


def test_the_record_of_the_scale_in_the_next_bay() -> None:
    """Its cables are just free, and no other feet that leave them so shake it less."""
    best, k, c = recorded("weighing_in_the_next_bay", "acceleration"), 50e3, 3669.3318
    assert scale_shaken(k, c) == pytest.approx((best, 0.45e-3), rel=1e-6)
    around = [scale_shaken(k * p, c * q) for p in (1.0, 1.03, 1.1) for q in (0.95, 0.99, 1.01, 1.05)]
    assert all(other > best * (1.0 - 1e-6) for other, room in around if room <= 0.45e-3 * (1.0 + 1e-6))
