"""Limits of measured rotors with a probability: drawn, integrated by another route, and never better than can be."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import rice

import vibopt as vo
from rotor_jobs import FAN, messages, solve_text
from vibopt.answer.answer import Answer
from vibopt.balancing.chances import farthest
from vibopt.balancing.contradictions import heard
from vibopt.balancing.rotor_job import RotorJob
from vibopt.cli.main import main
from vibopt.errors import InputError
from vibopt.program.drawn import clopper_pearson

SCATTER = 'scatter = { amplitude = "0.2 mil" }\n'
"""Alike in every direction: what is left at a sensor then follows the law of Rice."""


def fan(bound: float, wanted: str, goal: str = "correction", scatter: str = SCATTER, more: str = "") -> str:
    limit = f'[limits.rest]\nresponse = "residual"\nat_most = "{bound!r} mil pp"\nwith_probability = "{wanted}"\n'
    return f'{scatter}{FAN}{limit}[goal]\nminimise = "{goal}"\n{more}'


def share_of(answer: Answer[RotorJob], bound: float) -> float:
    """Share of all rotors that keep a bound [SI peak] at every sensor, by integrals: errors are alike either way."""
    of = heard(answer.job)
    u = np.array([plane.u for plane in answer.plan.fittings[0].planes])
    share = 1.0
    for learnt, along in zip(of.identified.learnt, of.noise.along, strict=True):
        left, carried = of.identified.residual(u), np.abs(learnt.weights_of(u))
        for sensor, z in enumerate(left):
            sd = float(np.sqrt(((carried * along[:, sensor]) ** 2).sum()))
            share *= float(rice.cdf(bound / sd, abs(z) / sd))
    return share


@given(st.floats(0.9, 2.0), st.sampled_from(["60 %", "90 %", "99 %", "99.99 %"]))
def test_enough_of_all_rotors_keep_the_limit_by_integrals_and_no_more_than_is_asked(bound: float, wanted: str) -> None:
    answer = solve_text(fan(bound, wanted))
    if answer.status == "unproven":
        assert float(wanted[:-2]) > 90.0
        return
    assert answer.status in ("optimal", "feasible")
    limit, odds = answer.limits["rest"], answer.tolerances.odds["rest"]
    share, asked = share_of(answer, limit.limit.value), float(wanted[:-2]) / 100.0
    assert odds.low <= share <= odds.high
    assert asked <= share
    if answer.goal[1].value > answer.tolerances.goal.value * (1.0 + 1e-9):
        assert share <= 1.0 - 0.4 * (1.0 - asked)


def test_weights_that_are_given_are_judged_by_machines_drawn_word_for_word() -> None:
    text = fan(1.0, "90 %", "residual")
    for name, weight in (("left", "10.8 g @ 326 deg"), ("right", "5.8 g @ 66 deg")):
        text = text.replace(f"[planes.{name}]\n", f'[planes.{name}]\nweight = "{weight}"\n')
    for wanted, status in (("90 %", "met"), ("99.9 %", "violated"), ("99.2 %", "unproven")):
        answer = solve_text(text.replace("90 %", wanted))
        odds = answer.tolerances.odds["rest"]
        assert answer.status == status, wanted
        assert odds.low <= share_of(answer, answer.limits["rest"].limit.value) <= odds.high
        assert not answer.proven or status != "met"
        shown = f"{odds.kept} of {odds.drawn} machines drawn keep it"
        assert shown in answer.claim
        assert f"; {wanted} asked: {odds.verdict}; worst within the tolerances" in answer.claim
        assert answer.to_json()["tolerances"]["odds"]["rest"]["drawn"] == odds.drawn


def test_the_same_is_drawn_each_time_and_two_answers_compare_on_the_same_machines() -> None:
    job = vo.from_text(fan(1.0, "90 %"))
    assert vo.solve(job).to_json() == vo.solve(vo.from_text(fan(1.0, "90 %"))).to_json()
    pair = vo.whatif(job, {"limits.rest.at_most": "1.1 mil pp"})
    assert pair.before.tolerances.odds["rest"].drawn == pair.after.tolerances.odds["rest"].drawn == 4096


def test_a_machine_that_is_modelled_wrongly_is_found_by_the_other_sampler(monkeypatch: pytest.MonkeyPatch) -> None:
    from vibopt.balancing import chances

    true = chances.covariances
    monkeypatch.setattr(chances, "covariances", lambda *given: 1.3 * true(*given))
    answer = solve_text(fan(1.0, "90 %"))
    assert answer.status == "check_failed"
    assert "machines of another draw" in answer.claim


@given(
    st.complex_numbers(max_magnitude=3.0, allow_nan=False),
    st.lists(st.complex_numbers(max_magnitude=2.0, allow_nan=False), min_size=1, max_size=6),
)
def test_the_worst_within_the_tolerances_is_that_of_all_corners(z: complex, steps: list[complex]) -> None:
    signs = np.stack(np.meshgrid(*[(-1.0, 1.0)] * len(steps), indexing="ij"), -1).reshape(-1, len(steps))
    corners = np.abs(z + signs @ np.array(steps, dtype=complex))
    assert farthest(z, np.array(steps, dtype=complex)) == pytest.approx(corners.max(), rel=1e-12, abs=1e-12)


def test_holes_and_a_plan_for_the_rare_one_in_a_million_keep_their_share() -> None:
    shelf = 'radius = "150 mm"\nholes = 24\nshelf = ["10 g", "6 g"]\n'
    answer = solve_text(fan(2.0, "99 %", "residual").replace('radius = "150 mm"\n', shelf))
    assert answer.status in ("optimal", "feasible")
    assert share_of(answer, answer.limits["rest"].limit.value) >= 0.99
    rare = solve_text(fan(2.0, "99.9999 %"))
    assert rare.tolerances.odds["rest"].within == pytest.approx(0.9999)
    assert share_of(rare, rare.limits["rest"].limit.value) >= 0.999999


def test_errors_of_different_sizes_along_and_across_are_drawn_as_they_are() -> None:
    """By a plain draw of every reading, refined by the least squares of numpy."""
    answer = solve_text(fan(1.4, "90 %", scatter='scatter = { amplitude = "6 %", angle = "0.3 deg" }\n'))
    job, odds = answer.job, answer.tolerances.odds["rest"]
    dice, kept, many = np.random.default_rng(5), 0, 4000
    u = np.array([plane.u for plane in answer.plan.fittings[0].planes])
    X = np.array([[1.0, *run.weights] for run in job.runs])
    for _ in range(many):
        read = np.array([run.readings for run in job.runs])
        along, across = dice.standard_normal((2, *read.shape))
        read = read * (1.0 + 0.06 * along + 1j * np.radians(0.3) * across)
        left = np.array([1.0, *u]) @ np.linalg.solve(X, read)
        kept += bool((np.abs(left) <= job.residual_limits[0].at_most).all())
    low, high = clopper_pearson(kept, many, 0.999)
    assert low <= odds.high
    assert high >= odds.low


def test_limits_that_the_prediction_cannot_keep_are_proven_and_a_share_is_not() -> None:
    text = fan(0.4, "90 %")
    assert solve_text(text).status == "unproven"
    assert solve_text(text).claim == "no plan was found that enough of all machines bear (rest), which proves nothing"
    capped = text.replace('radius = "150 mm"\n', 'radius = "150 mm"\nweight = { from = "0 g", to = "2 g" }\n')
    assert solve_text(capped).status == "infeasible"


HAS = "limits.rest has with_probability, but"
BARE = 'no reading scatters. Add scatter = { amplitude = "5 %", angle = "2 deg" }.'
WORST = 'goal.robust = "worst" keeps every limit on all rotors within the scatter. Remove one of the two.'
ANGLES = "readings without angles scatter in a way that nobody knows. Remove with_probability."
WAY = 'Write a share from "50 %" to "99.9999 %", for example with_probability = "99 %".'


def test_what_is_no_share_of_all_rotors_is_refused_word_for_word() -> None:
    good = fan(1.0, "90 %", "residual")
    assert messages(good) == []
    line = 1 + good[: good.index("with_probability")].count("\n")
    assert messages(good.replace(SCATTER, "")) == [f"fan.toml line {line - 1}: {HAS} {BARE}"]
    assert messages(f'{good}combine = "worst"\nrobust = "worst"\n') == [f"fan.toml line {line}: {HAS} {WORST}"]
    said = 'limits.rest.with_probability = "120 %" is more than all machines. For every machine within the tolerances'
    assert messages(good.replace("90 %", "120 %")) == [f"fan.toml line {line}: {said} leave it out. {WAY}"]


SCENARIO = '[scenarios.tighter.limits.rest]\nat_most = "0.9 mil pp"\n'


def test_prices_and_one_plan_for_all_say_why_there_are_none(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    file = tmp_path / "fan.toml"
    file.write_text(fan(1.0, "90 %", more=SCENARIO), encoding="utf-8")
    job = vo.read(file)
    assert vo.solve(job).limits["rest"].price is None
    assert main(["whatif", str(file)]) == 2
    assert "fan.toml: a limit asks for a probability, and what a step buys of it is the luck" in said(capsys)
    assert main(["solve", str(file), "--all-scenarios"]) == 2
    one = "fan.toml: one plan for all scenarios knows no limit with_probability. vibopt compare FILE --scenarios"
    assert one in said(capsys)
    with pytest.raises(InputError, match="a limit asks for a probability, which rotors that are drawn tell"):
        vo.posed(job).cvxpy()


def said(capsys: pytest.CaptureFixture[str]) -> str:
    return " ".join(capsys.readouterr().err.split())
