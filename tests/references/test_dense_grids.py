"""The second routes themselves, against brute force: no design on a dense grid beats them."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from second_routes import ROUTES, rpm

Array = NDArray[np.float64]
Verdicts = NDArray[np.bool_]
Feasible = Callable[[Array], Verdicts]
FeasiblePair = Callable[[Array, Array], Verdicts]

SLACK = 1e-5
"""Limits are widened by this much, so that a design exactly on its limit counts as meeting it."""


def band(low: float, high: float) -> Array:
    """Every speed of a range, as near as a grid comes."""
    return np.linspace(low, high, 3001)


def at(speed: float) -> Array:
    return np.array([speed])


def motion_over_force(k: Array, c: Array, mass: float, speeds: Array) -> Array:
    """Displacement over force; designs down, speeds across."""
    k, c, w = k[:, None], c[:, None], speeds[None, :]
    return np.asarray(1 / np.abs(k - mass * w**2 + 1j * w * c))


def ratio(k: Array, c: Array, mass: float, speeds: Array) -> Array:
    """Transmissibility; designs down, speeds across."""
    mount = np.abs(k[:, None] + 1j * speeds[None, :] * c[:, None])
    return mount * motion_over_force(k, c, mass, speeds)


def critical(zeta: float, k: Array, mass: float) -> Array:
    """Damping at a damping ratio."""
    return 2 * zeta * np.sqrt(k * mass)


def holds(response: Array, limit: float) -> Verdicts:
    """Which designs stay below the limit at all speeds."""
    return np.asarray((response <= limit * (1 + SLACK)).all(axis=1))


# --- one variable: the stiffness --------------------------------------------------------------


@dataclass(frozen=True)
class Line:
    """A design with the stiffness alone to choose."""

    stem: str
    low: float
    high: float
    feasible: Feasible
    link: str = "mount"


def isolating(mass: float, zeta: float, speeds: Array, limit: float) -> Feasible:
    return lambda k: holds(ratio(k, critical(zeta, k, mass), mass, speeds), limit)


def unbalanced(mass: float, zeta: float, unbalance: float, speeds: Array, limit: float) -> Feasible:
    return lambda k: holds(unbalance * speeds**2 * ratio(k, critical(zeta, k, mass), mass, speeds), limit)


def comfortable(wavenumber: float) -> Feasible:
    speeds = wavenumber * band(65 / 3.6, 130 / 3.6)
    return unbalanced(680, 0.05, 0.15, speeds, 2 * 9.80665)


def two_harmonics(k: Array) -> Verdicts:
    none = np.zeros_like(k)
    first = 18_000 * ratio(k, none, 500, at(300))
    second = 3_600 * ratio(k, none, 500, at(600))
    return holds(first + second, 12_000)


RPM = float(rpm(1))
HERTZ = 2 * np.pi
LINES = (
    Line("rao_9_27", 1e3, 1e7, isolating(85 / 9.80665, 0, HERTZ * band(25, 35), 0.2)),
    Line("rao_9_29_undamped", 1e3, 1e7, isolating(500, 0, RPM * at(300), 0.1)),
    Line("rao_9_29_damped", 1e3, 1e7, isolating(500, 0.1, RPM * at(300), 0.1)),
    Line("rao_9_31", 1e2, 1e7, isolating(68, 0, RPM * at(300), 0.4)),
    Line("rao_9_32", 1e3, 1e8, isolating(50, 0.07, RPM * at(1200), 0.25)),
    Line("rao_9_33", 1e3, 1e8, isolating(80, 0, RPM * at(1000), 0.2)),
    Line("rao_9_36", 1e4, 1e9, unbalanced(200, 0.08, 1, RPM * band(800, 2000), 6000)),
    Line("rao_9_37", 1e3, 1e8, isolating(100, 0, RPM * at(600), 0.1)),
    Line("rao_9_38_necessary_stiffness", 1e4, 1e9, unbalanced(300, 0.05, 1, RPM * at(1800), 8000)),
    Line("rao_9_39", 1e5, 1e10, two_harmonics),
    Line("rao_9_40", 1e2, 1e7, comfortable(0.6), "suspension"),
    Line("rao_9_40_printed_road", 1e2, 1e7, comfortable(6.7), "suspension"),
    Line("rao_9_44", 1e3, 1e9, isolating(60, 0, RPM * at(3000), 0.25)),
    Line("rao_9_46", 1e2, 1e8, isolating(30, 0.25, HERTZ * band(10, 75), 0.15)),
    Line("rao_9_48", 1e-2, 1e5, isolating(1, 0, HERTZ * at(2), 0.05)),
)


@pytest.mark.parametrize("line", LINES, ids=lambda line: line.stem)
def test_no_stiffer_mount_on_a_line(line: Line) -> None:
    best = float(ROUTES[line.stem]()[f"variables.links.{line.link}.stiffness"])
    assert line.feasible(np.array([best, best * 1.0001])).tolist() == [True, False]
    grid = np.geomspace(line.low, line.high, 2001)
    assert not line.feasible(grid[grid > best * 1.0001]).any()


# --- two variables: stiffness and damping -----------------------------------------------------


def fan(k: Array, c: Array) -> Verdicts:
    mass, speed = 800 / 9.80665, RPM * 600
    running = holds(ratio(k, c, mass, at(speed)), 0.1)
    running[running] &= holds(ratio(k[running], c[running], mass, band(0, speed)), 2.5)
    return running


def press(power: int) -> FeasiblePair:
    mass, speed = 300.0, RPM * 3000
    speeds = band(0, speed)
    force = 30_000 * (speeds / speed) ** power

    def feasible(k: Array, c: Array) -> Verdicts:
        running = holds(ratio(k, c, mass, at(speed)), 1 / 3)
        running &= holds(30_000 * motion_over_force(k, c, mass, at(speed)), 0.0025)
        start_up = force * motion_over_force(k[running], c[running], mass, speeds)
        running[running] &= holds(start_up, 0.02)
        return running

    return feasible


PLANES = (
    ("rao_9_28", (1e3, 1e6), (1.0, 1e4), fan),
    ("rao_9_34", (1e4, 1e9), (10.0, 1e6), press(0)),
    ("rao_9_34_speed_squared", (1e4, 1e9), (10.0, 1e6), press(2)),
)


@pytest.mark.parametrize(("stem", "stiffnesses", "dampings", "feasible"), PLANES)
def test_no_stiffer_mount_on_a_plane(
    stem: str,
    stiffnesses: tuple[float, float],
    dampings: tuple[float, float],
    feasible: FeasiblePair,
) -> None:
    answers = ROUTES[stem]()
    best = float(answers["variables.links.mount.stiffness"])
    damping = float(answers["variables.links.mount.damping"])
    assert feasible(np.array([best]), np.array([damping])).all()
    stiffer = np.geomspace(best * 1.001, stiffnesses[1], 150)
    k, c = (axis.ravel() for axis in np.meshgrid(stiffer, np.geomspace(*dampings, 200)))
    assert not feasible(k, c).any()


# --- all speeds -------------------------------------------------------------------------------


def amplified(speeds: Array) -> Verdicts:
    return np.asarray(_soft_mount(speeds) >= 1)


def isolated(speeds: Array) -> Verdicts:
    return np.asarray(_soft_mount(speeds) <= 0.1)


def _soft_mount(speeds: Array) -> Array:
    k = np.array([10_000.0])
    return np.asarray(ratio(k, critical(0.15, k, 200), 200, speeds)[0])


def below(force: float) -> Feasible:
    k = np.array([500_000.0])
    return lambda w: np.asarray(0.2 * w**2 * ratio(k, critical(0.06, k, 120), 120, w)[0] <= force)


SETS = (
    ("rao_9_30_a", 1000, amplified),
    ("rao_9_30_b", 1000, isolated),
    ("rao_9_35", 20_000, below(2500)),
    ("rao_9_35_printed_limit", 20_000, below(2500 * np.sqrt(8) / 3)),
)


@pytest.mark.parametrize(("stem", "highest", "permitted"), SETS)
def test_sets_hold_exactly_the_permitted_speeds(stem: str, highest: float, permitted: Feasible) -> None:
    speeds = np.linspace(0, RPM * highest, 200_003)[1:-1]
    inside = np.zeros_like(speeds, dtype=bool)
    for low, high in ROUTES[stem]()["set"]:
        inside |= (speeds >= float(low)) & (speeds <= float(high))
    assert (inside == permitted(speeds)).all()
