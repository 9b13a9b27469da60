"""Several harmonics as one number: against the signal itself over time."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vibopt.mechanics.combine import combined
from vibopt.scene.read import from_dict
from vibopt.verify.certify import measure

few = settings(derandomize=True, database=None, deadline=None, max_examples=40)
ORDERS = (0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0)
amplitudes = st.lists(
    st.tuples(st.sampled_from(ORDERS), st.floats(0.01, 10.0), st.floats(-180.0, 180.0).map(lambda at: round(at, 6))),
    min_size=2, max_size=4, unique_by=lambda one: one[0],
)  # fmt: skip


@given(lines=amplitudes)
@few
def test_the_true_peak_is_that_of_the_signal(lines: list[tuple[float, float, float]]) -> None:
    orders = tuple(order for order, _, _ in lines)
    values = [np.array([size * np.exp(1j * np.radians(phase))]) for _, size, phase in lines]
    angle = np.linspace(0.0, 4.0 * np.pi, 200_001)
    signal = sum((value[0] * np.exp(1j * order * angle)).real for value, order in zip(values, orders, strict=True))
    found = float(combined(values, orders, "peak")[0])
    assert np.abs(signal).max() <= found * (1 + 1e-12)
    assert found == pytest.approx(np.abs(signal).max(), rel=1e-6)
    assert found <= float(combined(values, orders, "sum")[0]) * (1 + 1e-12)


@given(lines=amplitudes, zeta=st.floats(0.1, 0.5))
@settings(few, max_examples=4)
def test_a_machine_on_its_mount_swings_as_integrated_in_time(
    lines: list[tuple[float, float, float]], zeta: float
) -> None:
    """m u'' + c u' + k u = sum F cos(h w t + phase), run for 16 time constants by small steps."""
    mass, stiffness, speed = 3.0, 1200.0, 11.0
    damping = float(2 * zeta * np.sqrt(mass * stiffness))
    harmonics = [{"order": h, "amplitude": f"{f!r} N", "phase": f"{p!r} deg"} for h, f, p in lines]
    document = {
        "title": "in time",
        "bodies": {"body": {"mass": f"{mass} kg"}},
        "links": {
            "link": {"between": ["body", "ground"], "stiffness": f"{stiffness} N/m", "damping": f"{damping!r} N s/m"}
        },
        "excitations": {"e": {"kind": "harmonics", "on": "body", "speed": f"{speed} rad/s", "harmonics": harmonics}},
        "measures": {"swing": {"response": "displacement", "of": "body", "combine": "peak"}},
    }
    scene = from_dict(document)
    found = measure(scene, {}, scene.measures["swing"]).value
    assert found == pytest.approx(_simulated(mass, damping, stiffness, speed, lines), rel=1e-5)


def _simulated(
    mass: float, damping: float, stiffness: float, speed: float, lines: list[tuple[float, float, float]]
) -> float:
    """Greatest swing over the last two turns by Runge and Kutta's fourth order."""
    period = 4.0 * np.pi / speed
    settled = int(np.ceil(16.0 * 2.0 * mass / damping / period)) * period
    steps = 4000

    def slope(t: float, y: np.ndarray) -> np.ndarray:
        force = sum(f * np.cos(h * speed * t + np.radians(p)) for h, f, p in lines)
        return np.array([y[1], (force - damping * y[1] - stiffness * y[0]) / mass])

    y, dt, t = np.zeros(2), period / steps, 0.0
    coarse = period / 1000
    for _ in range(round(settled / coarse)):
        y, t = _kutta(slope, t, y, coarse), t + coarse
    top = 0.0
    for _ in range(steps):
        y, t = _kutta(slope, t, y, dt), t + dt
        top = max(top, abs(float(y[0])))
    return top


def _kutta(slope: object, t: float, y: np.ndarray, dt: float) -> np.ndarray:
    assert callable(slope)
    a = slope(t, y)
    b = slope(t + dt / 2, y + dt / 2 * a)
    c = slope(t + dt / 2, y + dt / 2 * b)
    d = slope(t + dt, y + dt * c)
    made: np.ndarray = y + dt / 6 * (a + 2 * b + 2 * c + d)
    return made
