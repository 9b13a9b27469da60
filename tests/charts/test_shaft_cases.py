"""Random shafts and studies of the charts: their judges against closed forms and brute force."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vibopt.charts import shaft_cases, study_cases
from vibopt.charts.shaft_cases import DENSITY, MODULUS, Shaft, extrapolated
from vibopt.charts.study_cases import FACTS, START_UP, Study
from vibopt.charts.trial import Said
from vibopt.charts.verdicts import SILENT

PLAIN = Shaft(
    (1.0, 1.0), (0.01, 0.01), False, 1e-9, 0.0, 0.0, 1e12, 1.0, 1e-6, 10.0, (0.0, 1.0), 1.0
)  # fmt: skip
NONE = np.zeros(0)


def test_a_slender_shaft_has_the_critical_speeds_of_a_pinned_beam() -> None:
    own, _ = extrapolated(PLAIN, NONE)
    area, second = np.pi * 0.01**2 / 4.0, np.pi * 0.01**4 / 64.0
    pinned = (np.arange(1, 4) * np.pi / 2.0) ** 2 * np.sqrt(MODULUS * second / (DENSITY * area))
    assert own[:3] == pytest.approx(pinned, rel=1e-3)


def test_a_heavy_disc_whirls_as_laval_has_it() -> None:
    heavy = replace(PLAIN, mass=1e4, unbalance=2.0, speed=0.5)
    own, whirl = extrapolated(heavy, NONE)
    stiff = 48.0 * MODULUS * np.pi * 0.01**4 / 64.0 / 2.0**3
    assert own[0] == pytest.approx(np.sqrt(stiff / 1e4), rel=1e-3)
    assert whirl == pytest.approx(2.0 * 0.25 / abs(stiff - 1e4 * 0.25), rel=1e-3)


def test_a_disc_that_resists_its_tilt_has_no_second_critical_speed_of_tilting() -> None:
    """Beyond the bearing, with more polar than diametral inertia: the whirl that tilts it is never met."""
    over = replace(PLAIN, given=(0.05, 0.05), overhung=True, mass=1.0, diametral=1.0, polar=2.0)
    flat = replace(over, diametral=1.0, polar=0.0)
    assert extrapolated(over, NONE)[0][0] > extrapolated(flat, NONE)[0][0]


@settings(max_examples=5)
@given(st.integers(0, 10**6))
def test_a_shaft_is_judged_by_its_mass_and_by_its_worst_limit(seed: int) -> None:
    case, one = shaft_cases.drawn(np.random.default_rng(seed), "")
    x = np.full(len(one.free), 0.02)
    seen = shaft_cases.judge(case, one, "", Said("feasible", "", x))
    own, whirl = extrapolated(one, x)
    low, high = one.band
    inside = [min(speed / low - 1.0 if low else np.inf, 1.0 - speed / high) for speed in own.tolist()]
    assert seen.goal == pytest.approx(one.mass + DENSITY * np.pi / 4.0 * sum(
        long * (d or 0.02) ** 2 for long, d in zip(one.lengths, one.given, strict=True)))  # fmt: skip
    assert seen.missed == pytest.approx(max(0.0, *inside, whirl / one.whirl - 1.0))


@settings(max_examples=5)
@given(st.integers(0, 10**6))
def test_no_mount_of_a_fine_grid_beats_the_formulas_of_a_study(seed: int) -> None:
    """Every stiffness with every damping, the peak looked for on speeds: the best is that of the formulas, nearly."""
    _, one = study_cases.drawn(np.random.default_rng(seed), "")
    least, at = one.least
    ks = at * np.geomspace(0.5, 2.0, 41)
    scale = 2.0 * np.sqrt(at * one.mass)
    cs = scale * np.geomspace(1e-3, 30.0, 161)  # steps of 1.07, and a peak goes down as damping goes up
    w = np.linspace(0.0, one.top, 801)[1:]
    load = one.force * (w / one.top) ** 2 if one.growing else np.full(len(w), one.force)
    best = np.inf
    for k in ks.tolist():
        dynamic = k + 1j * np.outer(cs, w)
        moved = load / np.abs(dynamic - one.mass * w**2)
        floor = np.abs(dynamic[:, -1]) * moved[:, -1]
        still = 0.0 if one.growing else one.force / k
        held = np.maximum(moved.max(axis=1), still)[floor <= one.floor]
        best = min(best, float(held.min(initial=np.inf)))
    assert best > least * (1.0 - 1e-3)
    assert best < least * 1.08


def test_a_study_that_says_a_mount_where_there_is_none_is_silently_wrong() -> None:
    case, one = study_cases.drawn(np.random.default_rng(3), "")
    right = study_cases.judge(case, one, "", Said("optimal", "", one.truth))
    assert (right.error, right.fault) == (0.0, "")
    filled = np.where(np.isnan(one.truth), 1e6, one.truth)
    assert study_cases.judge(case, one, "", Said("feasible", "", filled)).verdict == SILENT
    stiff = one.truth * np.where(np.arange(len(one.truth)) == 0, 1.0, 1.0 + 1e-4)
    assert study_cases.judge(case, one, "", Said("feasible", "", stiff)).fault == "limit broken by 1.0e-04"


def test_the_place_of_a_study_moves_with_its_fact_alone() -> None:
    """Twice the force, the floor and the start-up: the same mounts."""
    one = Study(100.0, 100.0, 50.0, False, 20.0, 1.0, START_UP, (0.0, 0.0))
    twice = replace(one, force=100.0, floor=40.0)
    assert twice.least[0] == pytest.approx(2.0 * one.least[0], rel=1e-12)
    assert set(FACTS) == {one.fact, "limits.floor.at_most", "excitations.shaft.amplitude"}
