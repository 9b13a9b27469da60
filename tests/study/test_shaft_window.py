"""How far the weights of a shaft with known masses may go: by formula, and by descent with sums of our own."""

from __future__ import annotations

from math import asin, degrees, pi
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize

import vibopt as vo
from vibopt.arrays import ComplexArray, FloatArray
from vibopt.balancing.known.correct import pose
from vibopt.balancing.known.known_job import KnownJob
from vibopt.balancing.known.shaft_statics import rows_by_hand
from vibopt.study.permitted import Window

DISC = """title = "Disc with a lump"
[masses.lump]
mass = "10 g"
radius = "100 mm"
angle = "40 deg"
[planes.rim]
radius = "100 mm"
weight = { from = "0 g", to = "1 kg" }
[limits.low]
response = "static_unbalance"
at_most = "300 g mm"
[goal]
minimise = "correction"
[conventions]
angles = "with rotation"
"""
BLOWER = """title = "Shaft of a blower"
[shaft]
bearings = { A = "0 mm", B = "900 mm" }
speed = "1450 rpm"
[masses.blade]
mass = "60 g"
radius = "120 mm"
angle = "30 deg"
at = "300 mm"
[masses.hub]
mass = "25 g"
radius = "70 mm"
angle = "160 deg"
at = "550 mm"
[planes.left]
at = "100 mm"
radius = "110 mm"
weight = { from = "0 g", to = "40 g" }
[planes.right]
at = "800 mm"
radius = "110 mm"
weight = { from = "0 g", to = "100 g" }
[limits.bearing]
response = "bearing_reaction"
at_most = "20 N"
[limits.couple]
response = "couple_unbalance"
at_most = "400 kg mm^2"
[goal]
minimise = "correction"
[conventions]
angles = "with rotation"
"""


def test_a_disc_has_its_window_by_formula() -> None:
    """Weights within 300 g mm of the one that cancels 1000 g mm: 7 g to 13 g, and asin(0.3) to each side."""
    window = vo.window(vo.from_text(DISC, name="disc.toml"))
    size, angle = window.spans
    ((low, high),) = size.intervals
    assert (low.value, high.value) == pytest.approx((7e-3, 13e-3), rel=1e-5)
    ((first, last),) = angle.intervals
    turn = degrees(asin(0.3))
    assert [degrees(one.value) for one in (first, last)] == pytest.approx([220.0 - turn, 220.0 + turn], abs=1e-4)
    assert window.centre["planes.rim.mass"].value == pytest.approx(10e-3, rel=1e-5)
    assert window.part == pytest.approx(0.3, rel=1e-5)
    assert window.proven


def _left(u: ComplexArray) -> FloatArray:
    """Reactions of A and B [N] and couple about the middle [kg mm²], by moments about each other bearing."""
    known = [(60e-3 * 0.12, 30.0, 0.3), (25e-3 * 0.07, 160.0, 0.55)]
    points = [(z * np.exp(1j * np.radians(angle)), at) for z, angle, at in known] + [(u[0], 0.1), (u[1], 0.8)]
    speed2 = (1450.0 * pi / 30.0) ** 2
    about = [sum(z * (at - place) for z, at in points) for place in (0.9, 0.0, 0.45)]
    return np.array([abs(about[0]) / 0.9 * speed2, abs(about[1]) / 0.9 * speed2, 1e6 * abs(about[2])])


def test_the_weights_of_a_shaft_go_as_far_as_descent_leads_and_no_farther() -> None:
    job = vo.from_text(BLOWER, name="blower.toml")
    window, dice = vo.window(job), np.random.default_rng(3)
    bounds = np.array([20.0, 20.0, 400.0])
    u0 = np.array([complex(*_vector(window, name)) for name in ("left", "right")])
    assert (_left(u0) < bounds).all()

    def room(x: FloatArray) -> FloatArray:
        return np.asarray(1.0 - np.append(_left(_of(x)) / bounds, np.abs(_of(x)) / CAPS) ** 2)

    middle = 1e3 * np.concatenate([u0.real, u0.imag])
    starts = [middle + dice.normal(size=4) for _ in range(6)]
    for k, name in enumerate(("left", "right")):
        ends = [_least(lambda x, k=k, sign=sign: sign * abs(_of(x)[k]) * 1e3, room, starts) for sign in (1.0, -1.0)]
        ends = [ends[0] / 0.11, -ends[1] / 0.11]
        span = next(one for one in window.spans if one.path == f"planes.{name}.mass")
        ((low, high),) = span.intervals
        assert [1000.0 * low.value, 1000.0 * high.value] == pytest.approx(ends, rel=1e-4)
    turns = np.exp(1j * dice.uniform(0.0, 2.0 * pi, (200, 2)))
    inside = [_left(u0 * (1.0 + window.part * turn)) / bounds for turn in turns]
    assert 0.5 < np.max(inside) <= 1.0 + 1e-9
    assert (np.abs(u0) * (1.0 + window.part) / 0.11 <= np.array([40e-3, 100e-3]) * (1.0 + 1e-6)).all()


def _of(x: FloatArray) -> ComplexArray:
    return np.asarray(1e-3 * (x[:2] + 1j * x[2:]), dtype=complex)


def _least(fun: Any, room: Any, starts: list[FloatArray]) -> float:
    """The least value that SLSQP finds from several starts within the room."""
    keeps: Any = {"type": "ineq", "fun": room}
    runs = [minimize(fun, start, constraints=keeps) for start in starts]
    return float(min(one.fun for one in runs if room(one.x).min() > -1e-7))


CAPS = 0.11 * np.array([40e-3, 100e-3])


def _vector(window: Window, name: str) -> tuple[float, float]:
    size, angle = (window.centre[f"planes.{name}.{key}"].value for key in ("mass", "angle"))
    return 0.11 * size * np.cos(angle), 0.11 * size * np.sin(angle)


def test_masses_turned_by_hand_are_what_the_rows_say() -> None:
    job = vo.from_text(BLOWER, name="blower.toml")
    assert isinstance(job, KnownJob)
    question, dice = pose(job).question, np.random.default_rng(5)
    for _ in range(20):
        u: ComplexArray = np.asarray(5e-3 * (dice.normal(size=2) + 1j * dice.normal(size=2)), dtype=complex)
        by_hand = rows_by_hand(job, u)
        assert by_hand == pytest.approx(np.abs(question.residual(u))[: len(by_hand)], rel=1e-9)
