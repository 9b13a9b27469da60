"""Balancing by amplitudes alone: three trials decide, two leave two answers, circles that miss are said."""

from __future__ import annotations

import cmath
from math import degrees, radians

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rotor_jobs import correction, messages, read_text, solve_text
from vibopt.balancing.phaseless import circles, without_phase
from vibopt.balancing.rotor_job import RotorJob
from vibopt.balancing.verification import simulated_without_phase

HEAD = """title = "without phase"
speed = "900 rpm"
[conventions]
angles = "against rotation"
detector = "rms"
zero = "the keyway"
"""
UNBALANCE = cmath.rect(8.0, radians(250.0))
"""Grams at the angle as written."""


def job(trials: list[complex], gain: float = 0.4, error: dict[int, float] | None = None) -> str:
    lines = [HEAD, '[planes.fan]\nradius = "200 mm"']
    for index, trial in enumerate([0.0, *trials]):
        reading = gain * abs(UNBALANCE + trial) + (error or {}).get(index, 0.0)
        weight = (
            f'weights = {{ fan = "{abs(trial)!r} g @ {degrees(cmath.phase(trial)) % 360.0!r} deg" }}\n' if trial else ""
        )
        lines.append(f'[[runs]]\n{weight}readings = {{ a = "{reading!r} mm/s" }}')
    return "\n".join(lines)


def around(size: float, *angles: float) -> list[complex]:
    return [cmath.rect(size, radians(angle)) for angle in angles]


@pytest.mark.parametrize("trials", [around(5.0, 0, 120, 240), around(6.0, 10, 100, 190), around(5.0, 0, 90, 180, 270)])
def test_four_runs_find_the_weight(trials: list[complex]) -> None:
    plan = solve_text(job(trials))
    assert plan.status == "optimal"
    assert plan.claim.endswith("; the squares of the amplitudes give the same residual")
    assert abs(correction(plan, "fan") * 1e3 + UNBALANCE) < 1e-7


def test_two_trials_leave_two_answers_and_ask_for_a_third_run() -> None:
    plan = solve_text(job(around(5.0, 0, 120)))
    assert (plan.status, plan.exit_code) == ("unproven", 5)
    assert plan.claim == "the amplitudes leave two answers; one more trial run decides"
    found = [cmath.rect(one.planes[0].mass.value * 1e3, one.planes[0].angle.value) for one in plan.plan.fittings]
    assert min(abs(one + UNBALANCE) for one in found) < 1e-6
    assert [note for note in plan.notes if note.startswith("Make one more run with 5 g in fan at ")]
    assert [line.split(":")[0] for line in plan.plan.words[1:]] == ["Answer 1", "Answer 2"]
    assert len(plan.to_json()["answers"]) == 2


def test_the_run_asked_for_decides() -> None:
    plan = solve_text(job(around(5.0, 0, 120)))
    note = next(one for one in plan.notes if one.startswith("Make one more run"))
    angle = float(note.split(" at ")[1].split()[0])
    again = solve_text(job(around(5.0, 0, 120, angle)))
    assert len(again.plan.fittings) == 1
    assert abs(correction(again, "fan") * 1e3 + UNBALANCE) < 1e-6


def test_circles_that_do_not_meet_are_said_with_the_miss() -> None:
    plan = solve_text(job(around(5.0, 0, 120, 240), error={3: 0.25}))
    note = next(one for one in plan.notes if one.startswith("The circles"))
    assert note.startswith("The circles of a at 900 rpm do not meet in one point: they miss by 0.0")
    assert note.endswith("% of the largest reading). Steady readings would meet.")
    assert plan.status == "feasible"
    wild = solve_text(job(around(5.0, 0, 120, 240), error={0: -2.5}))
    assert wild.status == "unproven"
    assert wild.claim.startswith("the circles do not meet: they miss by ")


@settings(max_examples=60, deadline=None)
@given(size=st.floats(0.3, 3.0), angle=st.floats(0.0, 6.28), gain=st.floats(1e-3, 1e3))
def test_exact_circles_meet_in_the_unbalance(size: float, angle: float, gain: float) -> None:
    w0 = cmath.rect(size, angle)
    weights = np.array([0.0, 1.0, cmath.rect(1.0, 2.1), cmath.rect(1.1, 4.2)])
    (found,) = circles(weights, gain * np.abs(w0 + weights))
    assert abs(found.w0 - w0) < 1e-6
    assert found.gain == pytest.approx(gain, rel=1e-6)


H, Y0 = np.array([[0.4, 0.15j], [0.1 - 0.1j, 0.5]]), np.array([3.0 + 1.0j, -2.0 + 2.5j])
ALONE = [(plane, one) for plane in (0, 1) for one in around(5.0, 0, 120, 240)]


def two_planes(
    alone: list[tuple[int, complex]],
    mixed: tuple[complex, complex] | None = None,
    coefficients: np.ndarray = H,
    off: float = 0.0,
    angles: str = "against rotation",
) -> str:
    """Amplitudes of a rotor with two planes; `mixed` is a last run with weights in both, read with the error `off`."""
    lines = [
        HEAD.replace("against rotation", angles), '[planes.p]\nradius = "200 mm"', '[planes.q]\nradius = "200 mm"',
    ]  # fmt: skip
    runs = [(0.0, 0.0), *((one, 0.0) if plane == 0 else (0.0, one) for plane, one in alone)]
    for w in [*runs, *([mixed] if mixed else [])]:
        shown = np.abs(Y0 + coefficients @ np.array(w)) + (off if w is mixed else 0.0)
        weights = ", ".join(
            f'{name} = "{float(abs(one))!r} g @ {degrees(cmath.phase(one)) % 360.0!r} deg"'
            for name, one in zip("pq", w, strict=True)
            if one
        )
        fitted = f"weights = {{ {weights} }}\n" if weights else ""
        lines.append(
            f'[[runs]]\n{fitted}readings = {{ a = "{float(shown[0])!r} mm/s", b = "{float(shown[1])!r} mm/s" }}'
        )
    return "\n".join(lines)


@pytest.mark.parametrize("angles", ["against rotation", "with rotation"])
@pytest.mark.parametrize("mixed", [None, (3.0 + 1.0j, -2.0j)])
def test_two_planes_are_found_and_put_back_where_the_answer_is_unique(
    mixed: tuple[complex, complex] | None, angles: str
) -> None:
    plan = solve_text(two_planes(ALONE, mixed, angles=angles))
    u = np.array([correction(plan, name) for name in "pq"]) * 1e3
    np.testing.assert_allclose(np.abs(Y0 + H @ u), 0.0, atol=1e-5)
    assert plan.status == "optimal"
    assert plan.claim.endswith("; the squares of the amplitudes give the same residual")


def test_the_squares_of_the_amplitudes_show_what_any_weights_in_two_planes_leave() -> None:
    """Not only at the answer: the terms that two planes share are right for random corrections."""
    job, rng = read_text(two_planes(ALONE)), np.random.default_rng(3)
    rotor = without_phase(job).rotors[0]
    for _ in range(50):
        u = (rng.normal(size=2) + 1j * rng.normal(size=2)) * 1e-3
        grams = u.conj() / 0.2 * 1e3  # counted against rotation, at 200 mm
        for row in (0, 1):
            truth = abs(Y0[row] + H[row] @ grams) * 1e-3 * 2**0.5
            assert simulated_without_phase(job, row, u) == pytest.approx(truth, rel=1e-9)
            assert abs(rotor.y0[row] + rotor.H[row] @ u) == pytest.approx(truth, rel=1e-6)


def test_a_run_with_two_weights_that_the_rotor_does_not_show_is_not_passed_over() -> None:
    """Each plane's circles meet exactly; only the last run, with weights in both, speaks against them."""
    little = solve_text(two_planes(ALONE, (3.0 + 1.0j, -2.0j), off=0.05))
    assert little.status == "feasible"
    assert "miss 0.05 mm/s rms" in little.claim
    much = solve_text(two_planes(ALONE, (3.0 + 1.0j, -2.0j), off=2.0))
    assert (much.status, much.exit_code) == ("unproven", 5)
    assert much.claim == "the runs are missed by 2 mm/s rms at a at 900 rpm; repeat the runs"


def test_a_plan_that_the_squares_do_not_show_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    def wrong(job: RotorJob, row: int, u: np.ndarray) -> float:
        return 1e-3

    monkeypatch.setattr("vibopt.balancing.phaseless.simulated_without_phase", wrong)
    plan = solve_text(two_planes(ALONE))
    assert (plan.status, plan.exit_code) == ("check_failed", 6)
    assert plan.claim.startswith("the squares of the amplitudes give 0.707107 mm/s rms at a at 900 rpm, the plan says ")


def test_planes_almost_alike_are_refused_without_phase_as_well() -> None:
    alike = np.array([[0.4, 0.4001], [0.1 - 0.1j, 0.1 - 0.1001j]])
    plan = solve_text(two_planes(ALONE, coefficients=alike))
    assert (plan.status, plan.plan.fittings) == ("unproven", ())
    assert plan.claim.startswith("the weights of the best fit cancel each other (p ")
    assert [one.name for one in plan.plan.remedies][:3] == ["as asked", "p left out", "q left out"]


def test_too_few_runs_are_refused() -> None:
    assert messages(job(around(5.0, 0))) == [
        "fan.toml line 10: the readings have no angles, and plane fan has 1 trial position of its own at 900 rpm. "
        "Write the "
        'readings with their angles, "8.6 mil pp @ 63 deg", or fit a weight in fan alone at three angles (two leave '
        "two answers)."
    ]
    assert messages(job(around(5.0, 0, 180))) == [
        "fan.toml line 10: the two trial weights of plane fan at 900 rpm lie on one line through the centre, so the "
        "side cannot "
        "be told. Add a run with the weight at a right angle to them."
    ]


def test_scatter_and_robust_goals_are_refused_without_phase() -> None:
    text = job(around(5.0, 0, 120, 240)).replace("[conv", 'scatter = { amplitude = "5 %" }\n[conv')
    assert messages(f'{text}\n[goal]\nminimise = "residual"\nrobust = "worst"\n') == [
        "fan.toml line 3: scatter gives bands to readings with angles, and these have none. Write the readings with "
        "their angles, or leave scatter out.",
        'fan.toml line 24: goal.robust = "worst" goes over the scatter of readings with angles, and these have none. '
        "Write the readings with their angles, or leave robust out.",
    ]


def test_coefficients_without_phase_are_not_handed_on() -> None:
    limit = '\n[limits.x]\nresponse = "residual"\nat_most = "0.1 mm/s"\n'
    capped = job(around(5.0, 0, 120, 240)).replace('"200 mm"', '"200 mm"\nweight = { from = "0 g", to = "3 g" }')
    plan = solve_text(capped + limit)
    assert plan.status == "infeasible"
    assert not [path for path in plan.values if path.startswith("influence")]
    assert plan.method == "amplitudes only: circles of weights"


SEEN = {"a": (cmath.rect(8.0, radians(250.0)), 0.4), "b": (cmath.rect(5.0, radians(20.0)), 0.7)}
"""Per sensor the unbalance as it sees it [g at the angle as written], and its gain."""


def test_the_run_that_decides_is_predicted_for_every_answer() -> None:
    lines = [HEAD, '[planes.fan]\nradius = "200 mm"']
    for angle in (None, 0, 120):
        trial = 0.0 if angle is None else cmath.rect(5.0, radians(angle))
        values = ", ".join(f'{name} = "{gain * abs(w0 + trial)!r} mm/s"' for name, (w0, gain) in SEEN.items())
        lines.append("[[runs]]" + ("" if angle is None else f'\nweights = {{ fan = "5 g @ {angle} deg" }}'))
        lines.append(f"readings = {{ {values} }}")
    plan = solve_text("\n".join(lines))
    assert len(plan.plan.fittings) == 4
    (asked,) = [note for note in plan.notes if note.startswith("Make one more run with 5 g in fan at ")]
    angle = float(asked.split(" at ")[1].split(" deg")[0])
    shown = {name: gain * abs(w0 + cmath.rect(5.0, radians(angle))) for name, (w0, gain) in SEEN.items()}
    said = [part for part in asked.split("; ") if "predicts" in part]
    right = [part for part in said if all(f"{shown[name]:.6g} mm/s rms at {name} at 900 rpm" in part for name in SEEN)]
    assert [part.count("predicts") for part in said] == [1, 1, 1, 1]
    assert len(right) == 1
