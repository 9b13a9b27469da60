"""Recorded answers of the shaft problems: both planes together, the shaft as a cubic, no formula of whirl."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, minimize_scalar

from vibopt.units import read_quantity

PROBLEMS = Path(__file__).parents[2] / "problems/shafts"
STEEL, ALUMINIUM = 207e9, 71e9
OPERATING = 200.0 * np.pi


def recorded(stem: str) -> dict[str, float]:
    document = tomllib.loads((PROBLEMS / f"{stem}.toml").read_text(encoding="utf-8"))
    dimensions = {
        "stiffness": "stiffness",
        "force": "force",
        "bearings": "force",
        "bearing": "force",
        "stress": "stress",
    }
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
    right = {f"force_{name}": one for name, one in forces.items()} | {"bearing_running": 0.5 * forces["running"]}
    right |= {f"stress_{name}": stress * one for name, one in whirls.items()}
    assert recorded(loads) == pytest.approx(right, rel=1e-7)


def test_a_rotor_given_by_its_stiffness() -> None:
    rotor = 60.0, 3.75e6, 0.1 * np.sqrt(60.0 * 3.75e6), 0.002
    right = {"running": whirl(*rotor, 120.0 * np.pi)[0], "resonance": whirl(*rotor, 250.0)[0]}
    right["on_the_way"] = greatest(*rotor, 0)[1]
    assert recorded("rao_9_21") == pytest.approx(right, rel=1e-7)


# worked problems


def expected(stem: str) -> dict[str, str]:
    document = tomllib.loads((PROBLEMS / f"{stem}.toml").read_text(encoding="utf-8"))
    return {one["path"]: one["value"] for one in document["expected"]}


def overhung(diameter: float, span: float, out: float) -> tuple[float, float]:
    """Stiffness [N/m] and stress [Pa/m] of a steel shaft loaded `out` beyond its second bearing, by Mohr's areas.

    The moment falls from the bearing to either side: to the load, and to the other bearing.
    """
    bending = STEEL * np.pi * diameter**4 / 64.0
    sag = out**2 * (span + out) / (3.0 * bending)  # per force
    return 1.0 / sag, out * 0.5 * diameter * 64.0 / (np.pi * diameter**4) / sag


def test_the_pump_shaft_is_the_thinnest() -> None:
    """Stepping down from a thick one, the first limit that breaks, and its root; nothing thinner holds them all."""

    def misses(diameter: float) -> float:
        k, stress = overhung(diameter, 0.3, 0.18)
        speeds = np.linspace(1.0, 2950.0 * np.pi / 30.0, 2000)
        far = 0.4e-3 * speeds**2 / np.hypot(k - 14.0 * speeds**2, 300.0 * speeds)
        own = np.sqrt(k / 14.0) * 30.0 / np.pi
        sag = 14.0 * 9.80665 / k / 1e-4
        apart = min(abs(own - 2360.0), abs(3540.0 - own)) / 3540.0 if 2360.0 < own < 3540.0 else 0.0
        return max(far.max() / 0.12e-3 - 1.0, stress * far[-1] / 8e6 - 1.0, sag - 1.0, apart)

    low = brentq(lambda one: np.sqrt(overhung(one, 0.3, 0.18)[0] / 14.0) - 118.0 * np.pi, 0.02, 0.05, xtol=1e-15)
    assert misses(low * (1.0 + 1e-9)) <= 1e-12
    assert all(misses(one) > 0.0 for one in np.geomspace(0.01, low * (1.0 - 1e-6), 3000))
    found = expected("pump_shaft")
    assert read_quantity(found["variables.links.shaft.beam.diameter"], "length").value == pytest.approx(low, rel=1e-7)


def braked(diameter: float) -> tuple[float, float]:
    """Greatest deflection [m] and stress [Pa] of the fan as it is braked, by Runge and Kutta on a complex phasor.

    Its size at a time is the greatest over every angle at which it may have begun.
    """
    k, stress = overhung(diameter, 0.7, 0.35)
    c, top = 0.06 * np.sqrt(60.0 * k), 100.0 * np.pi
    slow = top / 4.0

    def force(time: float) -> complex:
        speed = max(top - slow * time, 0.0)
        turned = top * time - 0.5 * slow * time**2
        return complex(0.012 * (speed**2 + 1j * slow) * np.exp(1j * turned)) if time < 4.0 else 0.0j

    def rates(time: float, now: Any) -> Any:
        return np.array([now[1], (force(time) - c * now[1] - k * now[0]) / 60.0])

    steady = 0.012 * top**2 / (k - 60.0 * top**2 + 1j * c * top)
    begin = np.array([steady, 1j * top * steady])
    run: Any = solve_ivp(rates, (0.0, 4.0), begin, method="DOP853", rtol=1e-10, atol=1e-14, max_step=2e-3)
    sizes = np.abs(run.y[0])
    near = int(np.clip(sizes.argmax(), 3, len(sizes) - 4)) + np.arange(-3, 4)
    through = np.polynomial.Polynomial.fit(run.t[near], sizes[near], 6)
    far = max(float(through(np.linspace(run.t[near[0]], run.t[near[-1]], 20001)).max()), sizes[0])
    return far, stress * far


def test_the_fan_takes_the_thinnest_bar_that_holds() -> None:
    held = {}
    for bar in (0.05, 0.055, 0.06, 0.065, 0.07, 0.075):
        sag = 60.0 * 9.80665 / overhung(bar, 0.7, 0.35)[0]
        held[bar] = sag <= 2e-4 and braked(bar)[1] <= 150e6
    assert [bar for bar, good in held.items() if good] == [0.06, 0.075]
    found, (far, stress) = expected("overhung_fan"), braked(0.06)
    assert found["variables.links.shaft.beam.diameter"] == "60 mm"
    assert read_quantity(found["limits.stress.value"], "stress").value == pytest.approx(stress, rel=1e-6)
    assert read_quantity(found["measures.movement.value"], "length").value == pytest.approx(far, rel=1e-6)


def test_the_turbine_whirls_least_on_the_softest_supports_and_their_best_damper() -> None:
    shaft, _ = bent(STEEL, 0.06, 0.9)
    softest = (132.0 * 9.80665) / 5e-5
    speeds = np.linspace(10.0, 300.0 * np.pi, 6001)

    def worst(k: float, c: float) -> float:
        support = k + 1j * c * speeds - 12.0 * speeds**2
        return float(np.abs(2.4e-3 * speeds**2 / (shaft * support / (shaft + support) - 120.0 * speeds**2)).max())

    best: Any = minimize_scalar(lambda c: worst(softest, np.exp(c)), bounds=np.log([1e3, 1e6]), options={"xatol": 1e-9})
    for k in np.geomspace(softest, 200e6, 30):
        assert min(worst(k, c) for c in np.geomspace(1e4, 1e6, 60)) >= best.fun * (1.0 - 1e-9)
    found = expected("turbine_on_flexible_supports")
    assert read_quantity(found["goal"], "length").value == pytest.approx(best.fun, rel=1e-5)
    assert read_quantity(found["variables.links.supports.stiffness"], "stiffness").value == pytest.approx(
        softest, rel=1e-7
    )
    assert read_quantity(found["variables.links.supports.damping"], "damping").value == pytest.approx(
        np.exp(best.x), rel=1e-3
    )


def test_the_ship_needs_the_shaft_that_was_found() -> None:
    speeds = np.linspace(60.0, 140.0, 40_001) * np.pi / 30.0

    def stress(diameter: float) -> float:
        polar = np.pi * diameter**4 / 32.0
        k, total = 80e9 * polar / 12.0, np.zeros(len(speeds))
        for order, moment in ((3.0, 60e3), (6.0, 25e3)):
            w = order * speeds
            engine, propeller = -900.0 * w**2, 30e3j * w - 2500.0 * w**2
            total += np.abs(k * moment * propeller / (engine * propeller + k * (engine + propeller)))
        return float(total.max() * 0.5 * diameter / polar)

    least = brentq(lambda one: stress(one) - 40e6, 0.29, 0.33, xtol=1e-13)
    assert all(stress(one) > 40e6 for one in np.linspace(0.15, least * (1.0 - 1e-6), 400))
    assert all(stress(one) < 40e6 for one in np.linspace(least * (1.0 + 1e-6), 0.5, 100))
    document = tomllib.loads((PROBLEMS / "drive_line_of_a_ship.toml").read_text(encoding="utf-8"))
    ((low, high),) = document["expected"][0]["value"]
    assert read_quantity(low, "length").value == pytest.approx(least, rel=1e-6)
    assert high == "500 mm"


def holzer(coupling: complex, omega: Any, moment: float) -> tuple[Any, Any, Any]:
    """Torque in the coupling, on the wheel's teeth and in the propeller's shaft [N m], from the propeller on."""
    shaft = 80e9 * np.pi * 0.42**4 / 32.0 / 12.0
    turned = np.ones_like(omega, dtype=complex)
    torque = (2500.0 * omega**2 - 30e3j * omega) * turned
    held, turned = torque, turned - torque / shaft
    torque = torque + 400.0 * omega**2 * turned
    teeth, turned, torque = torque, -4.0 * turned, -0.25 * torque
    torque = torque + 30.0 * omega**2 * turned
    joined, turned = torque, turned - torque / coupling
    scale = moment / (-(torque + 900.0 * omega**2 * turned))
    return joined * scale, teeth * scale, held * scale


def test_the_coupling_of_the_geared_line_is_every_one_that_was_found() -> None:
    speeds = np.linspace(240.0, 560.0, 20001) * np.pi / 30.0
    far = np.linspace(0.85 * 3.0 * 240.0, 1.15 * 3.0 * 560.0, 3001) * np.pi / 30.0

    def misses(k: float) -> float:
        both = [np.abs(holzer(k * (1.0 + 0.12j), order * speeds, one)) for order, one in ((3.0, 12e3), (6.0, 5e3))]
        coupling, teeth, shaft = (both[0] + both[1]).max(axis=1)
        return float(max(coupling / 9e3, teeth / 12e3, shaft * 16.0 / (np.pi * 0.42**3) / 30e6)) - 1.0

    def residual(k: float, omega: Any) -> Any:
        """What undamped torques leave over at the engine; it changes its sign at natural frequencies."""
        inner = 2500.0 * omega**2
        turn = 1.0 - inner / (80e9 * np.pi * 0.42**4 / 32.0 / 12.0)
        torque = -0.25 * (inner + 400.0 * omega**2 * turn) - 120.0 * omega**2 * turn
        return torque + 900.0 * omega**2 * (-4.0 * turn - torque / k)

    document = tomllib.loads((PROBLEMS / "geared_drive_line.toml").read_text(encoding="utf-8"))
    ((low, high),) = document["expected"][0]["value"]
    least, most = (read_quantity(one, "torsional_stiffness").value for one in (low, high))
    assert brentq(misses, 7e5, 9e5, xtol=1.0) == pytest.approx(most, rel=1e-6)
    assert brentq(lambda k: residual(k, far[-1]), 5e5, 8e5, xtol=1e-3) == pytest.approx(least, rel=1e-6)
    for k, holds in (
        (2e5, False),
        (4e5, False),
        (least * 0.999, False),
        (least * 1.001, True),
        (most, True),
        (4e6, False),
    ):
        clear = (np.sign(residual(k, far)) == np.sign(residual(k, far[0]))).all()
        assert (clear and misses(k * (1.0 - 1e-6)) <= 0.0) == holds


# programs: the shaft with its mass by its half span, limits one by one, their ends by roots


def held_in_the_middle(
    modulus: float, outer: float, span: float, density: float, *, inner: float = 0.0, fixed: bool = False
) -> dict[str, float]:
    """Stiffness, mass, and means over half a span: of the shape, its square, and its moment about the middle."""
    second, area = np.pi * (outer**4 - inner**4) / 64.0, np.pi * (outer**2 - inner**2) / 4.0
    shape = Polynomial([0.0, 0.0, 12.0, -16.0]) if fixed else Polynomial([0.0, 3.0, 0.0, -4.0])

    def mean(of: Polynomial) -> float:
        whole = of.integ()
        return float(2.0 * (whole(0.5) - whole(0.0)))

    return {
        "k": (192.0 if fixed else 48.0) * modulus * second / span**3,
        "mass": density * area * span,
        "one": mean(shape),
        "square": mean(shape * shape),
        "arm": mean(shape * Polynomial([0.5, -1.0])),
        "fibre": 0.5 * outer / second,
    }


def intervals(misses: Any, low: float, high: float) -> list[list[float]]:
    """Where what may not be above zero is not, found on a grid and sharpened by roots."""
    grid = np.geomspace(low, high, 4001)
    good = np.array([misses(one) <= 0.0 for one in grid])
    found, begun = [], grid[0]
    for i in np.flatnonzero(good[1:] != good[:-1]):
        end = float(brentq(misses, grid[i], grid[i + 1], xtol=1e-15))
        if good[i]:
            found.append([float(begun), end])
        begun = end
    return found + ([[float(begun), high]] if good[-1] else [])


def permitted(stem: str) -> list[list[float]]:
    document = tomllib.loads((PROBLEMS / f"{stem}.toml").read_text(encoding="utf-8"))
    (one,) = [each for each in document["expected"] if each["path"] == "set"]
    return [[read_quantity(end, "length").value for end in two] for two in one["value"]]


def inside(value: float, low: float, high: float) -> float:
    """Above zero within a band."""
    return min(value - low, high - value) / high


def test_every_diameter_that_holds_the_flywheel() -> None:
    speed, off, load, span = 40.0 * np.pi, 5e-5, 45.0, 0.75

    def misses(outer: float) -> float:
        s = held_in_the_middle(200e9, outer, span, 7850.0)
        moving = load + s["square"] * s["mass"]
        far = load * off * speed**2 / (s["k"] - moving * speed**2)
        on_disc, spread = load * speed**2 * (off + far), s["mass"] * speed**2 * far
        bearing = 0.5 * (on_disc + s["one"] * spread)
        moment = bearing * 0.5 * span - 0.5 * s["arm"] * spread * span
        still = 9.80665 * span * (load / 4.0 + s["mass"] / 8.0)
        own = np.sqrt(s["k"] / moving) / (2.0 * np.pi)
        return max(
            (abs(moment) + still) * s["fibre"] / 1e8 - 1.0,
            abs(bearing) / 60.0 - 1.0,
            inside(own, 16.0, 24.0),
            inside(own, 32.0, 48.0),
        )

    right = intervals(misses, 0.01, 0.08)
    assert np.array(permitted("rao_9_15_diameters")) == pytest.approx(np.array(right), rel=1e-7)


def test_every_tube_that_stays_in_its_gap() -> None:
    speed, load = OPERATING, 20.0

    def misses(outer: float) -> float:
        s = held_in_the_middle(ALUMINIUM, outer, 1.0, 2700.0, inner=0.6 * outer)
        moving, c = load + s["square"] * s["mass"], 0.02 * np.sqrt(s["k"] * load)
        far = load * 5e-5 * speed**2 / abs(s["k"] - moving * speed**2 + 1j * c * speed)
        sag = 9.80665 * (load + s["one"] * s["mass"]) / s["k"]
        return max((far + sag) / 5e-4 - 1.0, inside(np.sqrt(s["k"] / moving), 0.8 * speed, 1.2 * speed))

    right = intervals(misses, 0.04, 0.15)
    assert np.array(permitted("rao_9_19_tubes")) == pytest.approx(np.array(right), rel=1e-7)


def test_every_diameter_with_its_separation_margins() -> None:
    def misses(outer: float) -> float:
        s = held_in_the_middle(STEEL, outer, 0.8, 7850.0, fixed=True)
        moving, sag = 40.0 + s["square"] * s["mass"], 9.80665 * (40.0 + s["one"] * s["mass"]) / s["k"]
        own = np.sqrt(s["k"] / moving)

        def far(rpm: Any) -> Any:
            w = np.asarray(rpm) * np.pi / 30.0
            return 1.2e-4 * w**2 / np.abs(s["k"] - moving * w**2 + 400j * w)

        peak = own / np.sqrt(1.0 - 2.0 * (200.0 / np.sqrt(s["k"] * moving)) ** 2) * 30.0 / np.pi
        passed = [6300.0, peak] if peak < 6300.0 else [6300.0]
        return max(
            inside(own * 30.0 / np.pi, 4150.0, 7560.0),
            far(np.linspace(5000.0, 6000.0, 101)).max() / 12.5e-6 - 1.0,
            (far(passed).max() + sag) / 3e-4 - 1.0,
            1.0 - own * (1.0 + 400.0 / 300.0) / (210.0 * np.pi),
        )

    right = intervals(misses, 0.03, 0.16)
    assert np.array(permitted("separation_margins")) == pytest.approx(np.array(right), rel=1e-7)


def test_the_bar_the_damping_and_the_stable_rotor() -> None:
    bars = np.array([15.0, 20.0, 25.0, 30.0, 35.0, 40.0, 50.0, 60.0]) / 1e3
    bows = [np.prod([bent(200e9, one, 0.75)[1], whirl(45.0, bent(200e9, one, 0.75)[0], 0.0, 1e-3, 40.0 * np.pi)[0]])
            for one in bars]  # fmt: skip
    assert bars[next(i for i, one in enumerate(bows) if one <= 3e7)] == 0.04
    assert expected("rao_9_16_bars")["variables.links.shaft.beam.diameter"] == "40 mm"
    k, _ = bent(STEEL, 0.025, 1.0)

    def bearing(ratio: float) -> float:
        c = 2.0 * ratio * np.sqrt(20.0 * k)
        w = np.sqrt(k / 20.0) * np.linspace(0.98, 1.05, 200_001)
        return float((0.5 * np.abs(k + 1j * w * c) * 4e-4 * w**2 / np.abs(k - 20.0 * w**2 + 1j * w * c)).max())

    least = brentq(lambda one: bearing(one) - 60.0, 0.005, 0.05, xtol=1e-12)
    found = expected("rao_9_18_damping")
    assert read_quantity(found["variables.links.shaft.damping_ratio"], "ratio").value == pytest.approx(least, rel=1e-6)

    ratio = brentq(lambda z: 5e-6 / (2.0 * z * np.sqrt(1.0 - z * z)) - 4e-5, 0.01, 0.3, xtol=1e-15)
    root = 0.1 * 144.0 * np.pi * 60.0 / (0.1 + 2.0 * ratio)  # of k m: where both limits hold just so
    found = expected("rao_9_21_stable")
    stiffness = read_quantity(found["variables.links.shaft.stiffness"], "stiffness").value
    assert stiffness == pytest.approx(root**2 / 60.0, rel=1e-6)
    assert read_quantity(found["goal"], "damping").value == pytest.approx(2.0 * ratio * root, rel=1e-6)
