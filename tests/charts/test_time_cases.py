"""The truths of the charts of run-ups and dry friction: each by another route."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from vibopt.charts import friction_cases, random_cases, run_up_cases
from vibopt.charts.friction_cases import Slip
from vibopt.charts.run_up_cases import Passage
from vibopt.charts.trial import DEFAULT, Table
from vibopt.charts.verdicts import REFUSES, RIGHT, SILENT, UNPROVEN
from vibopt.mechanics.dry_friction import Rub

TABLES: dict[str, Callable[..., Table]] = {
    "run-ups": run_up_cases.speed,
    "hard run-ups": run_up_cases.hard,
    "slips": friction_cases.speed,
    "hard slips": friction_cases.hard,
}


@cache
def rows_of(name: str) -> Table:
    """Made when it is asked for: their truths take a second."""
    return TABLES[name](quick=True)


@pytest.mark.parametrize("name", TABLES)
def test_vibopt_is_right_in_every_row(name: str) -> None:
    table = rows_of(name)
    for case, given in table.cases:
        one = table.tried(case, given, DEFAULT, 1)
        assert (one.verdict, one.error < 3e-7) == (RIGHT, True), (case.name, one.error)


@pytest.mark.parametrize("rate", [0.02, 0.2, 5.0])
def test_the_truth_of_a_run_up_is_duhamels_integral(rate: float) -> None:
    """One mass, by Gauss's rule on short panels: neither a frame nor an integrator nor Faddeeva's function."""
    one = Passage(1, 0.05, 0.3, 2.5, rate)
    size, when = run_up_cases.truth(one)
    turn, fade = np.sqrt(1.0 - 0.05**2), 0.05
    nodes, weights = np.polynomial.legendre.leggauss(12)
    edges = np.unique(np.append(np.linspace(0.0, when, int(8.0 * when) + 8), min(one.length, when)))
    half = 0.5 * np.diff(edges)[:, None]
    at = edges[:-1, None] + half * (1.0 + nodes)
    rising = np.minimum(at, one.length)
    phase = 0.3 * rising + 0.5 * rate * rising**2 + 2.5 * (at - rising)
    blow = np.exp(-fade * (when - at)) * np.sin(turn * (when - at)) / turn
    driven = complex((half * weights * blow * np.exp(1j * phase)).sum())
    begun = 1.0 / (1.0 - 0.3**2 + 2j * 0.05 * 0.3)
    wave = np.exp(-fade * when)
    free = begun * wave * (np.cos(turn * when) + (fade + 0.3j) / turn * np.sin(turn * when))
    assert abs(driven + free) == pytest.approx(size, rel=1e-9)


def test_a_slow_run_up_is_steady_and_the_asymptote_is_off_at_ordinary_rates() -> None:
    steady = 0.5 / 0.3 / np.sqrt(1.0 - 0.3**2)
    hard = rows_of("hard run-ups")
    slow = [case.goal for case, one in hard.cases if one.rate < 1e-4]
    assert slow == pytest.approx([steady], rel=1e-4)
    rows = [hard.tried(case, one, "asymptote", 1) for case, one in hard.cases if one.rate > 1e-4]
    assert {one.verdict for one in rows} == {UNPROVEN, REFUSES}
    fresnel = run_up_cases.by_asymptote(Passage(1, 1e-9, 0.7, 1.5, 4e-3)).answer
    undamped, _ = run_up_cases.truth(Passage(1, 0.0, 0.7, 1.5, 4e-3))
    assert undamped == pytest.approx(fresnel, rel=0.05)
    assert hard.tried(*hard.cases[0], "dop853 1e-09", 1).status == REFUSES


def test_equivalent_viscous_damping_is_silently_wrong_and_says_that_nothing_moves_at_the_edge() -> None:
    hard = rows_of("hard slips")
    rows = {case.family: set[str]() for case, _ in hard.cases}
    for case, one in hard.cases:
        rows[case.family].add(hard.tried(case, one, "equivalent viscous", 1).verdict)
    assert rows["at the edge of holding"] == {SILENT}
    assert SILENT in rows["stops in the cycle"]
    assert friction_cases.by_equivalent_viscous(Slip(0.8, 0.02, 0.95)).claim == "nothing moves"


@pytest.mark.parametrize(
    "one", [Slip(0.6, 0.02, 0.6), Slip(0.4, 0.02, 0.5), Slip(0.8, 0.02, 0.95), Slip(1.5, 0.02, 0.6)]
)
def test_the_integrator_repeats_the_truth_of_friction(one: Slip) -> None:
    assert friction_cases.by_dop853(one).answer == pytest.approx(friction_cases.truth(one), rel=1e-6)


def test_the_truth_follows_beats_behind_the_run_up() -> None:
    """A run-down ends beside the lowest mode: the greatest comes seven slowest periods behind it."""
    one = Passage(3, 0.012653972799981445, 1.5014838453268937, 0.4750134179504101, 0.10730089716375302)
    size, when = run_up_cases.truth(one)
    assert when > one.length + 6.0 * 2.0 * np.pi / one.modes[0]
    assert run_up_cases.by_vibopt(one).answer == pytest.approx(size, rel=1e-9)


def test_a_short_hold_at_the_top_of_a_slip_is_seen() -> None:
    """Friction holds for a fiftieth of a radian; without that the mass is told to swing 7e-5 too far."""
    one = Slip(0.6233381101745086, 0.01077098378593427, 0.571669752383947)
    assert Rub(one.r, one.ratio, one.friction).greatest((1.0, 0.0, 0.0), 0j) == pytest.approx(
        friction_cases.truth(one), rel=1e-12
    )
    assert friction_cases.by_dop853(one, 1e-11).answer == pytest.approx(friction_cases.truth(one), rel=1e-9)


def test_an_integrator_that_turns_back_at_once_comes_to_an_end() -> None:
    """A coarse step leaves a stop backwards and stops again: without a count it went on for ever."""
    (_, one) = random_cases.drawn("friction", 2, 9)[8]
    said = friction_cases.by_dop853(one, 1e-5)
    assert (said.status, said.claim[:24]) == ("unproven", "more than 200 stops in c")


@pytest.mark.parametrize("one", [Slip(0.6, 0.0, 0.2), Slip(1.5, 0.0, 0.3)])
def test_the_truth_of_friction_without_stops_is_den_hartogs(one: Slip) -> None:
    """Undamped (1931): z = (1 / (1 - r^2)^2 - (f u)^2)^(1/2), u = sin(pi / r) / (r (1 + cos(pi / r)))."""
    turned = np.sin(np.pi / one.r) / (one.r * (1.0 + np.cos(np.pi / one.r)))
    expected = np.sqrt(1.0 / (1.0 - one.r**2) ** 2 - (one.friction * turned) ** 2)
    assert friction_cases.truth(one) == pytest.approx(expected, rel=1e-4 if one.r < 1.0 else 1e-3)


@pytest.mark.parametrize("rates", [pytest.param(slice(0, 1), marks=pytest.mark.slow), slice(1, None)])
def test_what_a_steady_speed_and_a_damper_miss_is_told_beside_the_models_that_need_less(rates: slice) -> None:
    """The rows of the chart of fidelity, against the truths and the closed form of the steady peak."""
    steady = 0.5 / 0.05 / np.sqrt(1.0 - 0.05**2)
    for name, make in run_up_cases.fidelity(quick=True)[rates]:  # the first is the slowest
        (row,) = make()
        swept, _ = run_up_cases.truth(Passage(1, 0.05, 0.3, 2.5, float(name.split()[2])))
        assert (row.kinds, row.case) == (("passage", "steady"), name)
        assert row.value_error == pytest.approx(steady / swept - 1.0, rel=1e-6)
    slips = [Slip(r, 0.02, 0.6) for r in (0.6, 0.98, 1.5)]
    for (name, make), slip in zip(friction_cases.fidelity(quick=True), slips, strict=True):
        (row,) = make()
        viscous = friction_cases.by_equivalent_viscous(slip).answer
        assert name == f"friction of 0.6 F at {slip.r:g} of ω₀"
        assert row.kinds == ("friction", "damper")
        assert row.value_error == pytest.approx(abs(viscous / friction_cases.truth(slip) - 1.0), rel=1e-6)
