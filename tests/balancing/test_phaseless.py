"""Balancing by amplitudes alone: three trials decide, two leave two answers, circles that miss are said."""

from __future__ import annotations

import cmath
from math import degrees, radians

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rotor_jobs import correction, messages, solve_text
from vibopt.balancing.phaseless import circles

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
    found = [
        cmath.rect(float(one.planes[0].mass.value) * 1e3, float(one.planes[0].angle.value)) for one in plan.fittings
    ]
    assert min(abs(one + UNBALANCE) for one in found) < 1e-6
    assert [note for note in plan.notes if note.startswith("Make one more run with 5 g in fan at ")]
    assert [line.split(":")[0] for line in plan.words[1:]] == ["Answer 1", "Answer 2"]
    assert len(plan.to_json()["answers"]) == 2


def test_the_run_asked_for_decides() -> None:
    plan = solve_text(job(around(5.0, 0, 120)))
    note = next(one for one in plan.notes if one.startswith("Make one more run"))
    angle = float(note.split(" at ")[1].split()[0])
    again = solve_text(job(around(5.0, 0, 120, angle)))
    assert len(again.fittings) == 1
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


def test_two_planes_are_found_where_the_answer_is_unique() -> None:
    H, y0 = np.array([[0.4, 0.15j], [0.1 - 0.1j, 0.5]]), np.array([3.0 + 1.0j, -2.0 + 2.5j])
    lines = [HEAD, '[planes.p]\nradius = "200 mm"', '[planes.q]\nradius = "200 mm"']
    for plane, trial in [(0, 0.0)] + [(plane, one) for plane in (0, 1) for one in around(5.0, 0, 120, 240)]:
        w = np.zeros(2, dtype=complex)
        w[plane] = trial
        shown = np.abs(y0 + H @ w)
        name = "pq"[plane]
        weight = f'weights = {{ {name} = "5 g @ {degrees(cmath.phase(trial)) % 360.0} deg" }}\n' if trial else ""
        lines.append(
            f'[[runs]]\n{weight}readings = {{ a = "{shown[0]!r} mm/s", b = "{shown[1]!r} mm/s" }}'.replace(
                "np.float64(", ""
            ).replace(")", "")
        )
    plan = solve_text("\n".join(lines))
    u = np.array([correction(plan, name) for name in "pq"]) * 1e3
    np.testing.assert_allclose(np.abs(y0 + H @ u), 0.0, atol=1e-5)


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
