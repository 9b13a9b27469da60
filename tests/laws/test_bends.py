"""Second derivatives in closed form against differences of slopes, which share no code with them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vibopt.arrays import FloatArray
from vibopt.forms import ModeFrequency, Modulus, Monomials
from vibopt.forms.bends import curved
from vibopt.forms.extremes import sampled_slopes
from vibopt.program.pose import pose
from vibopt.program.program import Program
from vibopt.scene.read import from_text
from vibopt.signals import Drive

_STEP, _APART = 1e-5, 1e-3
"""Of differences of slopes in logs; those of peaks are told to 1e-8, which takes a longer one."""

MACHINE = """
[bodies.low]
mass = { from = "5 kg", to = "50 kg" }
[bodies.top]
mass = "20 kg"
[links.stand]
between = ["low", "ground"]
stiffness = { from = "10 kN/m", to = "1 MN/m" }
loss_factor = 0.2
[links.upper]
between = ["low", "top"]
stiffness = { from = "10 kN/m", to = "1 MN/m" }
damping = { from = "10 N s/m", to = "10 kN s/m" }
"""
FORCE = """
[excitations.e]
kind = "harmonics"
on = "top"
speed = "10..300 rad/s"
varies = "speed^2"
amplitude_at = "200 rad/s"
harmonics = [{ order = 1, amplitude = "1 kN" }, { order = 2, amplitude = "700 N" }, { order = 3.5, amplitude = "50 N" }]
"""
SHAFT = """
[excitations.e]
kind = "unbalance"
on = "low"
unbalance = "0.1 kg m"
speed = "10..300 rad/s"
"""
BASE = """
[bases.floor]
[links.hanger]
between = ["floor", "top"]
stiffness = "40 kN/m"
damping = "100 N s/m"
[excitations.e]
kind = "base_motion"
on = "floor"
displacement = "1 mm"
speed = "10..300 rad/s"
"""
ASKED = {
    "force": '[goal]\nminimise = "transmitted_force"\ninto = "ground"\n',
    "motion": '[goal]\nminimise = "acceleration"\nof = "low"\n',
    "between": '[goal]\nminimise = "relative_displacement"\nacross = "upper"\n',
}


def program(excitation: str, asked: str, combine: str) -> Program:
    how = f'combine = "{combine}"\n' if excitation is FORCE else ""
    return pose(from_text(MACHINE + excitation + ASKED[asked] + how))


def slope_with_speed(form: Modulus, model: object, drive: Drive, x: FloatArray, speed: float) -> FloatArray:
    """Slope in log x and in the speed, the latter by differences of logs."""
    near = speed * np.array([1.0 - 1e-6, 1.0, 1.0 + 1e-6])
    log, slope = sampled_slopes(model, form, drive, x, near)
    return np.append(slope[1], (log[2] - log[0]) / (2e-6 * speed))


@settings(max_examples=60, deadline=None)
@given(
    excitation=st.sampled_from([FORCE, SHAFT, BASE]),
    asked=st.sampled_from(sorted(ASKED)),
    combine=st.sampled_from(["sum", "rss"]),
    place=st.lists(st.floats(0.1, 0.9), min_size=4, max_size=4),
    speed=st.floats(15.0, 290.0),
)
def test_bends_are_differences_of_slopes(
    excitation: str, asked: str, combine: str, place: list[float], speed: float
) -> None:
    posed = program(excitation, asked, combine)
    assert posed.aim is not None
    assert isinstance(posed.aim.form, Modulus)
    model, form = posed.aim.model, posed.aim.form
    drive = form.drives[0]
    x = posed.low * (posed.high / posed.low) ** np.array(place[: len(posed.axes)])
    other = 0.9 * speed
    found, beside = curved(model, form.output, drive, x, np.array([speed, other]), form.combine)
    assert found is not None
    here = slope_with_speed(form, model, drive, x, speed)
    assert found.slope == pytest.approx(here, rel=1e-6, abs=1e-6 * np.abs(here).max())
    rows = []
    for i in range(len(x)):
        turn = np.exp(_STEP * np.eye(len(x))[i])
        up, down = (slope_with_speed(form, model, drive, one, speed) for one in (x * turn, x / turn))
        rows.append((up - down) / (2.0 * _STEP))
    size = np.abs(found.bend[:-1, :-1]).max() + np.abs(here[:-1]).max() ** 2
    assert found.bend[:-1, :-1] == pytest.approx(np.array(rows)[:, :-1], abs=1e-5 * size)
    mixed = np.abs(found.bend[-1]).max() + np.abs(here).max() ** 2
    _, (before, behind) = sampled_slopes(model, form, drive, x, speed * np.array([1.0 - 1e-6, 1.0 + 1e-6]))
    assert found.bend[:-1, -1] == pytest.approx((behind - before) / (2e-6 * speed), abs=1e-5 * mixed)
    assert found.bend == pytest.approx(found.bend.T)
    assert beside is not None
    assert beside.slope == pytest.approx(
        slope_with_speed(form, model, drive, x, other), rel=1e-6, abs=1e-6 * np.abs(beside.slope).max()
    )


@settings(max_examples=25, deadline=None)
@given(
    excitation=st.sampled_from([FORCE, SHAFT, BASE]),
    asked=st.sampled_from(sorted(ASKED)),
    place=st.lists(st.floats(0.2, 0.8), min_size=4, max_size=4),
)
def test_the_bend_of_a_peak_counts_its_own_motion(excitation: str, asked: str, place: list[float]) -> None:
    """Against differences of the slopes of peaks found anew."""
    posed = program(excitation, asked, "sum")
    assert posed.aim is not None
    model, form = posed.aim.model, posed.aim.form
    x = posed.low * (posed.high / posed.low) ** np.array(place[: len(posed.axes)])
    here = form.extremes(model, x, least_wanted=False)[0]
    if here.bend is None:
        return
    for i in range(len(x)):
        turn = np.exp(_APART * np.eye(len(x))[i])
        slopes = []
        for there in (x * turn, x / turn):
            near = form.extremes(model, there, least_wanted=False)
            slopes.append(min(near, key=lambda one: abs(one.speeds[0] - here.speeds[0])).slope)
        size = np.abs(here.bend).max() + np.abs(here.slope).max() ** 2
        assert here.bend[i] == pytest.approx((slopes[0] - slopes[1]) / (2.0 * _APART), abs=2e-5 * size)


@pytest.mark.parametrize("place", [(0.3, 0.4, 0.5, 0.6), (0.7, 0.2, 0.6, 0.3)])
def test_sums_of_powers_and_natural_frequencies_have_bends(place: tuple[float, ...]) -> None:
    posed = program(SHAFT, "motion", "sum")
    model = posed.model
    x = posed.low * (posed.high / posed.low) ** np.array(place[: len(posed.axes)])
    cost = Monomials(np.array([2.0, 0.01]), np.eye(len(x))[:2] * [[1.0], [0.5]])
    for form in (cost, ModeFrequency(1), ModeFrequency(2)):
        bend = form.extremes(model, x, least_wanted=False)[0].bend
        assert bend is not None
        for i in range(len(x)):
            turn = np.exp(3.0 * _STEP * np.eye(len(x))[i])
            there = (form.slope(model, x * turn) - form.slope(model, x / turn)) / (6.0 * _STEP)
            assert bend[i] == pytest.approx(there, abs=1e-6)
