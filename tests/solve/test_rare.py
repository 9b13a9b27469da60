"""Limits that hardly any machine may break: draws beyond a box against integrals, and shares against quantiles."""

from __future__ import annotations

from math import erf, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import ndtr, ndtri

from texts import hanging
from vibopt.jobs import answer, from_text
from vibopt.program.drawn import MET, NOT_MET, OPEN
from vibopt.program.far_off import Beyond
from vibopt.program.worst_case import around
from vibopt.scene.uncertain import Uncertain, uncertain
from vibopt.solve.rare import proven_beyond
from vibopt.values.tolerance import Scatter

SAG = 300.0 * 9.80665 / 2e5


def broken_by(bound: float, sigma: float, width: float) -> float:
    """Share of machines that sag more: normal mass in closed form, uniform spring by Simpson's rule."""
    k = np.linspace(2e5 * (1.0 - width), 2e5 * (1.0 + width), 2001)
    weights = np.ones(2001)
    weights[1:-1:2], weights[2:-1:2] = 4.0, 2.0
    above = ndtr(-(bound * k / 9.80665 / 300.0 - 1.0) / sigma)
    return float((weights * above).sum() / weights.sum())


@settings(max_examples=16)
@given(st.floats(1.0, 8.0), st.floats(0.5, 10.0), st.floats(3.0, 5.5), st.sampled_from([99.95, 99.99, 99.999, 99.9999]))
def test_the_interval_holds_the_few_that_break_a_limit(sigma: float, width: float, away: float, wanted: float) -> None:
    """Bounds some standard deviations away, so that all verdicts come."""
    bound = SAG * (1.0 + away * sqrt((sigma / 100.0) ** 2 + (width / 100.0) ** 2 / 3.0))
    design = answer(from_text(hanging(sigma=sigma, width=width, bound=bound, wanted=wanted), "hanging.toml"))
    assert design.tolerances is not None
    odds = design.tolerances.odds["sag"]
    truth = broken_by(bound, sigma / 100.0, width / 100.0)
    assert 1.0 - odds.high <= truth * (1.0 + 1e-9)
    assert truth <= 1.0 - odds.low
    right = {MET: truth <= 1.0 - wanted / 100.0, NOT_MET: truth > 1.0 - wanted / 100.0, OPEN: True}
    assert right[odds.verdict]
    clear = truth < 0.3 * (1.0 - wanted / 100.0)
    assert not (clear and odds.within) or odds.verdict == MET
    assert 1.0 - odds.within >= truth  # none within the box breaks it


@settings(max_examples=4)
@given(st.floats(1.0, 6.0), st.sampled_from([99.95, 99.99, 99.9999]))
def test_a_design_for_one_number_stands_at_its_quantile(sigma: float, wanted: float) -> None:
    text = hanging(sigma=sigma, width=5.0, bound=0.015, wanted=wanted)
    text = text.replace('value = "200 kN/m", tolerance = { uniform = "5.0 %" }', 'from = "10 kN/m", to = "10 MN/m"')
    design = answer(from_text(text + '[goal]\nminimise = "stiffness"\nof = "spring"\n', "hanging.toml"))
    assert design.status == "feasible"
    off = (design.x[0] * 0.015 / (300.0 * 9.80665) - 1.0) * 100.0 / sigma  # standard deviations that it bears
    least = ndtri(wanted / 100.0)
    assert least <= off <= least + 0.35
    assert design.tolerances is not None
    odds = design.tolerances.odds["sag"]
    assert odds.low <= 0.5 * (1.0 + erf(off / sqrt(2.0))) <= odds.high


@settings(max_examples=12)
@given(st.floats(1e-5, 0.5), st.lists(st.floats(0.01, 0.1), min_size=1, max_size=4), st.integers(0, 3))
def test_machines_beyond_are_those_of_all_that_lie_outside(part: float, sizes: list[float], left_out: int) -> None:
    """Each lies outside the box, to both sides alike; a number that the box leaves alone scatters as it does."""
    doubts = [Uncertain(f"a.b{k}.c", Scatter("normal", size)) for k, size in enumerate(sizes)]
    acting = np.array([k != left_out for k in range(len(sizes))])
    if not acting.any():
        acting[0] = True
    far = Beyond.of(doubts, acting, part)
    machines = far.machines(20_000)
    low, high = np.array([[axis.low, axis.high] for axis in far.axes]).T
    off = (machines < low) | (machines > high)
    assert off[:, acting].any(axis=1).all()
    tail = ndtr((low - 1.0) / np.array(sizes))[acting]
    assert 1.0 - np.prod(1.0 - 2.0 * tail) == pytest.approx(part, rel=1e-9)
    for k in np.flatnonzero(acting):  # the chance of each by itself, of those that are outside anywhere
        assert off[:, k].mean() == pytest.approx(2.0 * far.tail / part, abs=0.02)
        assert (machines[off[:, k], k] > 1.0).mean() == pytest.approx(0.5, abs=0.1)
    for k in np.flatnonzero(~acting):
        assert machines[:, k].std() == pytest.approx(sizes[k], rel=0.05)


def test_a_box_is_proven_or_there_is_none() -> None:
    text = hanging(sigma=5.0, width=5.0, bound=SAG * 1.4, wanted=99.99)
    scene = from_text(text, "hanging.toml")
    (limit,) = around(scene, np.zeros(0)).limits
    far = proven_beyond([limit], uncertain(scene), 0.9999)
    assert far is not None
    corner = far.axes[0].high / far.axes[1].low
    assert SAG * corner <= SAG * 1.4
    tight = from_text(text.replace(repr(SAG * 1.4), repr(SAG * 1.01)), "hanging.toml")
    (limit,) = around(tight, np.zeros(0)).limits
    assert proven_beyond([limit], uncertain(tight), 0.9999) is None
    assert answer(tight).tolerances is not None
    assert answer(tight).status == "violated"
