"""The problems with dry friction, by a Runge-Kutta method from event to event that starts on a motion that closes."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, fsolve

from rubbing_route import follow
from vibopt.units import read_quantity

FOLDER = Path(__file__).parents[2] / "problems/friction"


def half_cycle(start: Any, r: float, f: float) -> tuple[Any, float, float]:
    """State half a cycle behind, greatest place and greatest r^2 z'' - cos: r^2 z'' + z + f sgn z' = cos(theta)."""
    theta, now, place, force = 0.0, np.array(start, dtype=float), abs(start[0]), 1.0 - 1.0
    held = abs(now[1]) < 1e-12 and abs(1.0 - now[0]) <= f
    while theta < np.pi:
        if held:
            at = np.linspace(theta, np.pi, 2000)
            beyond = np.abs(np.cos(at) - now[0]) > f
            first = int(beyond.argmax()) if beyond.any() else 0
            end = np.pi
            if first:
                end = brentq(lambda t, z=now[0]: abs(np.cos(t) - z) - f, at[first - 1], at[first])
            force = max(force, float(np.abs(np.cos(np.append(at[(at < end)], end))).max()))
            theta, held = end, False
            continue
        side = np.sign(now[1]) if abs(now[1]) > 1e-12 else np.sign(np.cos(theta) - now[0])

        def rates(t: float, y: Any, s: float = side) -> Any:
            return [y[1], (np.cos(t) - y[0] - s * f) / r**2]

        def stops(t: float, y: Any) -> float:
            return float(y[1])

        watch: Any = stops
        watch.terminal, watch.direction = True, -side
        run: Any = solve_ivp(rates, (theta, np.pi), now, method="DOP853", rtol=1e-12, atol=1e-14, events=watch,
                             dense_output=True, max_step=0.1)  # fmt: skip
        at = np.linspace(theta, run.t[-1], 4000)
        force = max(force, float(np.abs(run.sol(at)[0] + side * f).max()))
        theta, now = float(run.t[-1]), run.y[:, -1].copy()
        place = max(place, abs(now[0]))
        if run.status == 1:
            now[1] = 0.0
            held = abs(np.cos(theta) - now[0]) <= f
    return now, place, force


def steady(r: float, f: float) -> tuple[float, float, float]:
    """Greatest place in static deflections, greatest spring and friction over the force, absolute over the base."""
    state = np.zeros(2)
    for _ in range(12):
        state = -half_cycle(state, r, f)[0]
    state = fsolve(lambda y: half_cycle(y, r, f)[0] + y, state, xtol=1e-12)
    assert np.abs(half_cycle(state, r, f)[0] + state).max() < 1e-8
    _, place, force = half_cycle(state, r, f)
    return place, force, 0.0


def recorded(name: str) -> dict[str, float]:
    """Values of a file by the last word of their path but `value` [SI]."""
    document = tomllib.loads((FOLDER / f"{name}.toml").read_text(encoding="utf-8"))
    found = {}
    for one in document["expected"]:
        kinds = {"mm": "length", "N": "force", "m/s2": "acceleration"}
        kind = next((kind for unit, kind in kinds.items() if one["value"].endswith(f" {unit}")), "ratio")
        found[one["path"].removesuffix(".value").rpartition(".")[2]] = read_quantity(one["value"], kind).value
    return found


def over(speed: float, stiffness: float, mass: float) -> float:
    """Frequency of a speed [rpm] over the natural one."""
    return speed * np.pi / 30.0 / np.sqrt(stiffness / mass)


def test_the_records_of_a_force() -> None:
    found = recorded("rao_9_41")
    for name, speed in (("slow", 120.0), ("near", 280.0), ("fast", 600.0), ("very_fast", 1500.0)):
        assert steady(over(speed, 1e5, 100.0), 0.4)[1] == pytest.approx(found[name], rel=1e-6)


def test_the_records_of_a_base() -> None:
    """The force that moves the mass over its base is m w^2 y: its rattle in r^2 y, its motion by that of the force."""
    found = recorded("rao_9_42")
    for names, speed in ((("slow_rattle"), 150.0), (("rattle"), 600.0)):
        r = over(speed, 1e5, 100.0)
        place = steady(r, 200.0 / (1e5 * r**2 * 10e-3))[0]
        assert place * r**2 * 10e-3 == pytest.approx(found[names], rel=1e-6)


def test_the_records_of_what_was_chosen() -> None:
    """At the friction that is recorded the limit holds by its last digit, and the goal is what it says."""
    press = recorded("press_on_friction_mounts")
    f = press["friction_force"] / 3000.0
    assert steady(over(280.0, 3e5, 300.0), f)[0] * 3000.0 / 3e5 == pytest.approx(20e-3, rel=1e-6)
    assert steady(over(1500.0, 3e5, 300.0), f)[1] * 3000.0 == pytest.approx(press["goal"], rel=1e-6)
    posed = recorded("rao_9_41_posed")
    assert steady(over(200.0, 5e4, 100.0), posed["friction_force"] / 1000.0)[1] == pytest.approx(2.0, rel=1e-6)
    found = steady(over(660.0, 5e4, 100.0), posed["friction_force"] / 1000.0)[1]
    assert found == pytest.approx(posed["goal"], rel=1e-6)


def test_the_records_of_a_drawer_that_rubs_in_a_rack() -> None:
    """Places over the floor; at the friction that is recorded the drawer goes as far as it may."""
    found = recorded("drawer_on_rails")
    shape = np.array([[1.0, -1.0], [-1.0, 1.0]])

    def floor(t: float) -> float:
        return 30.0 * np.sin(np.pi * t / 0.06) if t < 0.06 else 0.0

    way, drawer, rack = follow(
        (np.diag([180.0, 40.0]), np.diag([1500.0, 0.0]), np.diag([4e5, 0.0]) + 2e4 * shape), np.array([-1.0, 1.0]),
        found["friction_force"], lambda t: np.array([-180.0, -40.0]) * floor(t), (0.06, 0.5),
        lambda t, place, _, faster, rubs: (place[1] - place[0], faster[1] + floor(t), faster[0] + floor(t)),
    )  # fmt: skip
    assert way == pytest.approx(15e-3, rel=1e-6)
    assert drawer == pytest.approx(found["goal"], rel=1e-6)
    assert rack == pytest.approx(found["rack"], rel=1e-6)
