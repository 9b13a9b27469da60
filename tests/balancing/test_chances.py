"""Limits of measured rotors with a probability: drawn, integrated by another route, and never better than can be."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import rice

import vibopt as vo
from rotor_jobs import FAN, messages, polar, solve_text
from vibopt.answer.answer import Answer
from vibopt.arrays import FloatArray
from vibopt.balancing.chance_plan import kept_share
from vibopt.balancing.chances import farthest
from vibopt.balancing.contradictions import heard
from vibopt.balancing.rotor_job import RotorJob
from vibopt.cli.main import main
from vibopt.errors import InputError
from vibopt.program.drawn import clopper_pearson, sure_share
from vibopt.work import metered

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


@given(st.floats(0.0, 1.6), st.floats(0.01, 3.0), st.floats(-1.2, 1.2), st.floats(0.0, 3.2), st.floats(0.0, 6.3))
def test_a_share_of_errors_of_any_shape_is_that_of_rice_or_of_a_grid(
    size: float, sd: float, shape: float, tilt: float, way: float
) -> None:
    z = size * np.exp(1j * way)
    alike = kept_share(np.array([z]), sd**2 * np.eye(2)[None], 1.0)
    assert float(alike[0]) == pytest.approx(float(rice.cdf(1.0 / sd, size / sd)), abs=1e-9)
    one, other = 0.4 * np.exp(shape), 0.4 * np.exp(-shape)
    turn = np.array([[np.cos(tilt), -np.sin(tilt)], [np.sin(tilt), np.cos(tilt)]])
    share = kept_share(np.array([z]), (turn @ np.diag([one**2, other**2]) @ turn.T)[None], 1.0)
    angles, radii = 2.0 * np.pi * (np.arange(120) + 0.5) / 120, np.sqrt((np.arange(200) + 0.5) / 200)
    errors = np.outer(np.exp(1j * angles), radii).ravel() - z  # of equal areas in the disc of radius one
    x, y = turn.T @ np.stack([errors.real, errors.imag])
    density = np.exp(-0.5 * ((x / one) ** 2 + (y / other) ** 2)) / (2.0 * np.pi * one * other)
    assert float(share[0]) == pytest.approx(np.pi * density.mean(), abs=1e-3)


def one_plane(seed: int, wanted: float, room: float) -> tuple[str, FloatArray, float]:
    """A rotor with one plane and two sensors, shares of a grid of its plans by integrals, and that of the best bound.

    The bound is so wide that the best plan of the grid keeps what is asked, and a part `room` wider.
    """
    dice = np.random.default_rng(seed)
    y0, h = (dice.normal(size=(2, 2)) @ [1.0, 1j] for _ in range(2))
    text = f'{SCATTER}speed = "1200 rpm"\n{FAN[FAN.index("[conventions]") : FAN.index("[planes")]}'
    text += '[planes.p]\nradius = "150 mm"\n[limits.rest]\nresponse = "residual"\nat_most = "BOUND mil pp"\n'
    text += f'with_probability = "{100.0 * wanted:.8g} %"\n[goal]\nminimise = "GOAL"\n'
    read = [5.0 * y0, 5.0 * y0 + 2.0 * h]
    for name, own in zip(("as found", "trial"), read, strict=True):
        two = ", ".join(f'{k} = "{polar(complex(z), "mil")}"' for k, z in zip("ab", own, strict=True))
        text += f'[[runs]]\nname = "{name}"\n' + ('weights = { p = "10 g @ 0 deg" }\n' if name == "trial" else "")
        text += f"readings = {{ {two} }}\n"
    best = -np.vdot(read[1] - read[0], read[0]) / np.vdot(h, h).real / 4.0
    part = 3.0 * max(abs(best), 1.0) * np.linspace(-1.0, 1.0, 31)
    w = 0.5 * best + part[:, None] + 1j * part
    left = np.abs(read[0] + w[..., None] * (read[1] - read[0]))
    sd = 0.2 * np.sqrt(np.abs(1.0 - w) ** 2 + np.abs(w) ** 2)[..., None]
    needed, low, high = sure_share(wanted, 16384, 0.9975), 0.0, 20.0
    while high - low > 5e-3:
        bound = 0.5 * (low + high)
        low, high = (low, bound) if rice.cdf(bound / sd, left / sd).prod(axis=-1).max() >= needed else (bound, high)
    bound = float(f"{(1.0 + room) * high:.5g}")
    return text.replace("BOUND", repr(bound)), rice.cdf(bound / sd, left / sd).prod(axis=-1), needed


@given(
    st.integers(0, 10**6), st.sampled_from([0.75, 0.9, 0.95, 0.99]), st.floats(-0.05, 0.05),
    st.sampled_from(["correction", "residual"]),
)  # fmt: skip
def test_where_no_plan_is_found_no_plan_of_a_grid_keeps_the_probability(
    seed: int, wanted: float, room: float, goal: str
) -> None:
    text, shares, needed = one_plane(seed, wanted, room)
    answer = solve_text(text.replace("GOAL", goal))
    if answer.plan.fittings:
        assert share_of(answer, answer.limits["rest"].limit.value) >= wanted
    else:
        assert answer.status in ("unproven", "infeasible")
        assert shares.max() < needed


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
    from vibopt.balancing import chance_plan, chances

    true = chances.covariances
    for room in (chances, chance_plan):
        monkeypatch.setattr(room, "covariances", lambda *given: 1.3 * true(*given))
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


def test_a_list_beside_a_free_weight_is_searched_to_the_end() -> None:
    """Programs of the free plane count as the work that they are; at eight times as much a search ended early."""
    shelf = 'radius = "150 mm"\nholes = 24\nshelf = ["7 g", "3 g"]\nmost_weights = 2\n'
    text = fan(0.95, "90 %").replace('radius = "150 mm"\n', shelf, 1)
    with metered() as meter:
        answer = solve_text(text)
    assert answer.status == "feasible"
    assert share_of(answer, answer.limits["rest"].limit.value) >= 0.9
    assert meter.done < 1000.0


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
    said = 'limits.rest.with_probability = "120 %" is more than all rotors. For the rotor that the readings predict'
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


def test_the_nearest_plan_is_told_by_the_share_and_not_as_met(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """By integrals the share keeps what its row tells with these weights, and does not keep the limit."""
    file = tmp_path / "fan.toml"
    file.write_text(fan(1.0, "99.99 %"), encoding="utf-8")
    assert main(["solve", str(file)]) == 5
    told = capsys.readouterr().out
    assert " met" not in told
    assert "at least 99.99 %" in told
    near = vo.solve(vo.read(file)).nearest
    assert near is not None
    assert not near.least
    row = near.limits["rest"]
    assert not row.met
    assert row.limit is not None
    weight = {f"planes.{one}.weight": f"{near.values[f'planes.{one}.mass'].value!r} kg @ "
              f"{near.values[f'planes.{one}.angle'].value!r} rad" for one in ("left", "right")}  # fmt: skip
    fitted: Any = vo.solve(vo.with_changes(vo.read(file), weight))
    assert share_of(fitted, row.value.value) >= 0.9999 > share_of(fitted, row.limit.value)


def said(capsys: pytest.CaptureFixture[str]) -> str:
    return " ".join(capsys.readouterr().err.split())
