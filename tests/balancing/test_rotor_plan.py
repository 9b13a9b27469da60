"""Plans of measured rotors: what is fitted where, what is left, what it costs, and how it is checked."""

from __future__ import annotations

import cmath
import json
import re
from dataclasses import replace
from math import degrees, radians

import numpy as np
import pytest

from rotor_jobs import FAN, correction, read_text, solve_text
from vibopt.balancing import solve_rotor
from vibopt.balancing.fitting import fitting_of, plan_text
from vibopt.balancing.influence import identify
from vibopt.balancing.verification import simulated
from vibopt.study.prices import priced

LEFT = '[planes.left]\nradius = "150 mm"\n'
RIGHT = '[planes.right]\nradius = "150 mm"\n'


def fan(left: str = "", right: str = "", more: str = "") -> str:
    return FAN.replace(LEFT, LEFT + left).replace(RIGHT, RIGHT + right) + more


def put_back_of(text: str) -> None:
    """What the plan says is what the simulated rotor shows."""
    job = read_text(text)
    plan = solve_rotor.solve_job(job)
    shown = simulated(job, plan_text(job, plan.plan.fittings[0]))
    np.testing.assert_allclose([float(row.residual.value) for row in plan.plan.rows], shown, atol=1e-15, rtol=1e-9)


def test_the_fan_is_balanced_as_published() -> None:
    """Two-plane vector solution by hand: (A - B) / weight per run, then the 2 by 2 equations."""
    plan = solve_text(FAN)
    lag = {"a": 8.6 * cmath.exp(1j * radians(63)), "b": 6.5 * cmath.exp(1j * radians(206))}
    left = {"a": cmath.rect(5.9, radians(123)), "b": cmath.rect(4.5, radians(228))}
    right = {"a": cmath.rect(6.2, radians(36)), "b": cmath.rect(10.4, radians(162))}
    H = np.array(
        [
            [(left[s] - lag[s]) / cmath.rect(10, radians(270)), (right[s] - lag[s]) / cmath.rect(12, radians(180))]
            for s in "ab"
        ]
    )
    by_hand = np.linalg.solve(H, [-lag["a"], -lag["b"]])
    for name, one in zip(("left", "right"), by_hand, strict=True):
        assert abs(correction(plan, name) * 1e3 - one) < 1e-10
    assert (plan.status, plan.exit_code) == ("optimal", 0)
    assert plan.plan.words == (
        "Take every trial weight off first: the plan is added to the rotor as found.",
        "left: fit 10.76 g at radius 150 mm, 326.6 deg against rotation from the reflective tape.",
        "right: fit 6.202 g at radius 150 mm, 65.4 deg against rotation from the reflective tape.",
    )
    assert plan.find("planes.left.mass").shown == "10.76 g"
    assert plan.find("sensors.a.found").shown == "8.6 mil pp"


def test_a_textbook_job_in_plain_numbers() -> None:
    """Rao, Mechanical Vibrations, problem 9.13 with the coefficients divided by the trial weights as they should be."""
    text = (
        FAN.replace("8.6 mil @ 63", "5 mil @ 100")
        .replace("6.5 mil @ 206", "4 mil @ 180")
        .replace("10 g @ 270", "2 oz @ 30")
    )
    text = (
        text.replace("5.9 mil @ 123", "6.5 mil @ 120")
        .replace("4.5 mil @ 228", "4.5 mil @ 140")
        .replace("12 g @ 180", "2 oz @ 0")
    )
    text = (
        text.replace("6.2 mil @ 36", "6 mil @ 90")
        .replace("10.4 mil @ 162", "7 mil @ 60")
        .replace('radius = "150 mm"\n', "")
    )
    plan = solve_text(text)
    V, L, R = (
        np.array([cmath.rect(a, radians(p)) for a, p in pair])
        for pair in (((5, 100), (4, 180)), ((6.5, 120), (4.5, 140)), ((6, 90), (7, 60)))
    )
    H = np.stack([(L - V) / cmath.rect(2, radians(30)), (R - V) / 2.0], axis=1)
    for name, one in zip(("left", "right"), np.linalg.solve(H, -V), strict=True):
        assert abs(correction(plan, name) / 0.028349523125 - one) < 1e-10
    assert plan.plan.words[1] == "left: fit 4.232 oz, 130.3 deg against rotation from the reflective tape."


def test_holes_and_shelf_weights_are_named() -> None:
    text = fan(
        'holes = 24\nshelf = ["5 g", "10 g"]\nmost_weights = 2\n',
        'holes = ["0 deg", "60 deg", "120 deg", "300 deg"]\nshelf = ["3 g", "6 g"]\n',
    )
    plan = solve_text(text)
    assert plan.status == "optimal"
    assert (
        plan.plan.words[2]
        == "right: fit 6 g at radius 150 mm in hole 2 at 60 deg against rotation from the reflective tape."
    )
    put_back_of(text)
    weights = plan.to_json()["planes"]["right"]["weights"]
    assert weights[0]["hole"] == 2
    assert weights[0]["mass"]["shown"] == "6 g"


def test_a_split_weight_is_the_same_vector_in_two_holes() -> None:
    text = fan("holes = 12\nsplit = true\n")
    plan = solve_text(text)
    parts = plan.plan.planes[0].weights
    assert [part.hole for part in parts] == [10, 11]
    together = sum(cmath.rect(part.mass, part.angle) for part in parts)
    assert abs(together - correction(solve_text(FAN), "left")) < 1e-12
    put_back_of(text)


def test_the_cap_of_a_split_weight_is_on_both_parts() -> None:
    plan = solve_text(fan('holes = 8\nsplit = true\nweight = { from = "0 g", to = "11 g" }\n'))
    assert sum(part.mass for part in plan.plan.planes[0].weights) <= 0.011 * (1 + 1e-7)
    assert plan.status == "optimal"


def test_a_forbidden_sector_is_kept_in_the_users_sense() -> None:
    text = fan('forbidden = ["300..350 deg"]\n')
    plan = solve_text(text)
    angle = degrees(float(plan.plan.planes[0].angle.value))
    assert min(abs(angle - 300.0), abs(angle - 350.0)) < 1e-6
    assert plan.status == "optimal"
    put_back_of(text)
    through_zero = solve_text(fan('forbidden = ["300..10 deg"]\n'))
    angle = degrees(float(through_zero.plan.planes[0].angle.value))
    assert min(abs(angle - 300.0), abs(angle - 10.0)) < 1e-6


def test_material_is_removed_on_the_opposite_side() -> None:
    text = fan('remove = true\ndrill = { diameter = "10 mm", density = "7850 kg/m³" }\n')
    plan = solve_text(text)
    added = correction(solve_text(FAN), "left")
    assert abs(correction(plan, "left") + added) < 1e-12
    assert plan.plan.planes[0].words == (
        "left: take away 10.76 g at radius 150 mm, 146.6 deg against rotation from the reflective tape (hole of 10 "
        "mm, 17.5 mm deep)."
    )
    put_back_of(text)


def test_a_forbidden_sector_of_drilling_is_where_the_drill_goes() -> None:
    plan = solve_text(fan('remove = true\nforbidden = ["120..170 deg"]\n'))
    angle = degrees(float(plan.plan.planes[0].angle.value))
    assert min(abs(angle - 120.0), abs(angle - 170.0)) < 1e-6


def test_a_shallow_drill_is_a_cap() -> None:
    plan = solve_text(fan('remove = true\ndrill = { diameter = "10 mm", density = "7850 kg/m³", deepest = "8 mm" }\n'))
    depth = plan.plan.planes[0].weights[0].depth
    assert depth == pytest.approx(8e-3, rel=1e-6)


def test_a_plane_is_kept() -> None:
    plan = solve_text(fan(right="keep = true\n"))
    assert plan.plan.words[2] == "right: leave untouched."
    assert plan.plan.planes[1].u == 0.0


@pytest.mark.parametrize(("kind", "sign"), [("static", 1.0), ("couple", -1.0)])
def test_pairs_are_equal_or_opposite(kind: str, sign: float) -> None:
    text = fan(more=f'[pairs.p]\nplanes = ["left", "right"]\nkind = "{kind}"\n')
    plan = solve_text(text)
    assert abs(correction(plan, "left") - sign * correction(plan, "right")) < 1e-12
    put_back_of(text)


def test_of_several_radii_the_greatest_takes_least_mass() -> None:
    text = FAN.replace(LEFT, '[planes.left]\nradius = ["100 mm", "150 mm"]\n').replace(
        "10 g @ 270", "15 g at 100 mm @ 270"
    )
    plan = solve_text(text)
    assert abs(correction(plan, "left") - correction(solve_text(FAN), "left")) < 1e-12
    assert plan.find("planes.left.radius").shown == "150 mm"


def test_planes_in_unbalance_need_no_radius() -> None:
    text = FAN.replace(LEFT, '[planes.left]\nunbalance = { from = "0 g mm", to = "5000 g mm" }\n').replace(
        "10 g @ 270", "1500 g mm @ 270"
    )
    plan = solve_text(text)
    assert plan.find("planes.left.unbalance").shown == "1615 g mm"
    assert plan.plan.words[1] == "left: fit 1615 g mm, 326.6 deg against rotation from the reflective tape."


def test_runout_is_subtracted() -> None:
    shifted = FAN
    runout = cmath.rect(0.7, radians(20))
    for amount, angle in ((8.6, 63), (5.9, 123), (6.2, 36)):
        z = cmath.rect(amount, radians(angle)) + runout
        shifted = shifted.replace(
            f"{amount} mil @ {angle} deg", f"{abs(z)!r} mil @ {degrees(cmath.phase(z)) % 360!r} deg"
        )
    shifted += '[sensors.a]\nrunout = "0.7 mil @ 20 deg"\n[sensors.b]\n'
    for name in ("left", "right"):
        assert abs(correction(solve_text(shifted), name) - correction(solve_text(FAN), name)) < 1e-12
    put_back_of(shifted)


def test_weights_that_stayed_count_in_the_next_run() -> None:
    """The third run with the left trial still on: the same coefficients."""
    job = identify(read_text(FAN))
    w = np.array([0.0015 * cmath.exp(-1j * radians(270)), 0.0018 * cmath.exp(-1j * radians(180))])
    left = job.y0 + job.H @ w
    a, b = (
        f"{2 * abs(z) / 2.54e-5!r} mil @ {degrees(-cmath.phase(z)) % 360!r} deg".replace("np.float64(", "").replace(
            ")", ""
        )
        for z in left
    )
    text = (
        FAN.replace('name = "trial right"', 'name = "trial right"\nstayed = true')
        .replace("6.2 mil @ 36 deg", a)
        .replace("10.4 mil @ 162 deg", b)
    )
    for name in ("left", "right"):
        assert abs(correction(solve_text(text), name) - correction(solve_text(FAN), name)) < 1e-12
    put_back_of(text)


SECOND = (
    FAN[FAN.index("[[runs]]") :].replace("1200 rpm", "1800 rpm").replace("8.6 mil @ 63", "4.1 mil @ 110")
    .replace("5.9 mil @ 123", "3.5 mil @ 150").replace("10.4 mil @ 162", "7.7 mil @ 130")
)  # fmt: skip


def test_two_speeds_share_one_plan_and_have_limits_of_their_own() -> None:
    limits = (
        '[limits.low]\nresponse = "residual"\nspeed = "1200 rpm"\nat_most = "1.2 mil"\n[limits.high]\nresponse '
        '= "residual"\nat = "a"\nspeed = "1800 rpm"\nat_most = "2.5 mil"\n'
    )
    text = FAN + SECOND + limits
    plan = solve_text(text)
    assert plan.status == "optimal"
    assert [row.speed.shown for row in plan.plan.rows] == ["1200 rpm", "1200 rpm", "1800 rpm", "1800 rpm"]
    assert all(limit.met for limit in plan.limits.values())
    tight = [limit for limit in plan.limits.values() if limit.margin < 1e-4]
    assert tight
    bought = priced(plan).limits
    assert all(bought[limit.name].price.goal.value < plan.goal[1].value for limit in tight)
    assert plan.find("sensors.a.at 1800 rpm.residual").shown.endswith("mil pp")
    put_back_of(text)


def test_limits_that_cannot_hold_are_refused_with_the_smallest_loosening() -> None:
    plan = solve_text(FAN + SECOND + '[limits.all]\nresponse = "residual"\nat_most = "0.2 mil"\n')
    assert (plan.status, plan.exit_code) == ("infeasible", 3)
    assert plan.reason.startswith("This cannot hold: all. Smallest loosening of one: all 0.2 mil pp -> ")
    conflict = plan.to_json()["conflict"]
    assert (conflict["limits"], conflict["loosenings"][0]["limit"]) == (["all"], "all")
    bound = plan.reason.split(" -> ")[1].rstrip(".")
    assert solve_text(FAN + SECOND + f'[limits.all]\nresponse = "residual"\nat_most = "{bound}"\n').status == "optimal"


@pytest.mark.parametrize(
    "goal",
    ['combine = "rms"', 'combine = "worst"', 'combine = "sum"', 'combine = "huber"\nhuber_at = "1 mil"'],
)
def test_every_goal_is_proven_and_put_back(goal: str) -> None:
    text = (
        FAN + SECOND + f'[limits.m]\nresponse = "correction"\nof = "left"\nat_most = "8 g"\n[limits.t]\nresponse = '
        f'"correction"\ntotal = true\nat_most = "12 g"\n[goal]\nminimise = "residual"\n{goal}\n'
    )
    plan = solve_text(text)
    assert plan.status == "optimal"
    assert float(plan.limits["m"].value.value) <= 8e-3 * (1 + 1e-8)
    assert float(plan.limits["t"].value.value) <= 12e-3 * (1 + 1e-8)
    put_back_of(text)


def test_the_least_correction_under_a_limit() -> None:
    plan = solve_text(FAN + '[limits.a]\nresponse = "residual"\nat_most = "2 mil"\n[goal]\nminimise = "correction"\n')
    assert plan.status == "optimal"
    assert plan.goal is not None
    assert float(plan.goal[1].value) < sum(abs(correction(solve_text(FAN), name)) for name in ("left", "right"))
    assert priced(plan).limits["a"].price.goal.value < plan.goal[1].value


ALIKE = FAN.replace(
    'weights = { right = "12 g @ 180 deg" }\nreadings = { a = "6.2 mil @ 36 deg", b = "10.4 mil @ 162 deg" }',
    'weights = { right = "10 g @ 270 deg" }\nreadings = { a = "5.91 mil @ 123 deg", b = "4.5 mil @ 228.1 deg" }',
)


def test_planes_that_act_alike_are_named_with_remedies_side_by_side() -> None:
    plan = solve_text(ALIKE + '[scatter]\namplitude = "2 %"\nangle = "1 deg"\n')
    note = next(one for one in plan.notes if one.startswith("Planes "))
    assert note.startswith("Planes left and right act almost alike: condition number ")
    assert note.endswith("; one can be left out, or the mass penalised.")
    assert [one.name.split(" of ")[0] for one in plan.plan.remedies] == [
        "as asked",
        "left left out",
        "right left out",
        "mass penalised",
        "caps",
    ]
    asked, without, *_ = plan.plan.remedies
    assert float(asked.rms.value) < float(without.rms.value)
    assert all(one.band for one in plan.plan.remedies)


def test_a_dead_sensor_does_not_stop_the_plan() -> None:
    text = FAN
    for old in ("8.6 mil @ 63 deg", "5.9 mil @ 123 deg", "6.2 mil @ 36 deg"):
        text = text.replace(old, "0 mil @ 0 deg")
    plan = solve_text(text)
    assert plan.status == "optimal"
    assert float(plan.plan.rows[1].residual.value) < 1e-16


def test_repeated_runs_give_the_scatter() -> None:
    again = FAN[FAN.index("[[runs]]") :].replace("8.6 mil @ 63", "8.8 mil @ 64").replace("6.2 mil @ 36", "6.1 mil @ 35")
    plan = solve_text(FAN + again.replace('name = "', 'name = "again '))
    assert plan.plan.rows[0].band is not None
    assert (
        plan.notes[-1]
        == "Bands hold 95 % of what the scatter of the readings allows (scatter from 3 runs more than unknowns)."
    )


def test_a_first_trial_weight_is_advised_from_mass_and_speed() -> None:
    found = FAN[: FAN.index('[[runs]]\nname = "trial left"')] + '[rotor]\nmass = "500 kg"\n'
    plan = solve_text(found)
    omega = 1200.0 * 2.0 * np.pi / 60.0
    assert (plan.status, plan.claim) == ("unproven", "no trial run yet: what a weight does is not known")
    assert float(plan.find("planes_first.left.trial").value) == pytest.approx(
        0.1 * 500.0 * 9.80665 / omega**2 / 2 / 0.15
    )
    assert plan.plan.words[0] == "left: a first trial of at most 103.5 g."


def test_a_plan_that_the_simulated_rotor_refuses_is_no_plan() -> None:
    job = read_text(FAN)
    plan = solve_rotor.solve_job(job)
    identified = identify(job)
    wrong = fitting_of(
        job, replace(identified, y0=identified.y0 * 1.1), np.array([one.u for one in plan.plan.planes]), (None, None)
    )
    refused = solve_rotor._certified(plan.with_plan(fittings=(wrong,)), identified)
    assert (refused.status, refused.exit_code) == ("check_failed", 6)
    assert refused.claim.startswith("the simulated rotor shows ")


def test_the_json_is_strict_and_in_si() -> None:
    data = json.loads(
        json.dumps(
            solve_text(FAN + '[limits.a]\nresponse = "residual"\nat = "a"\nat_most = "1 mil"\n').to_json(),
            allow_nan=False,
        )
    )
    assert data["planes"]["left"]["mass"]["unit"] == "kg"
    assert data["sensors"]["a"]["speeds"][0]["limit"]["shown"] == "1 mil pp"
    assert data["conventions"]["zero"] == "reflective tape"
    assert data["limits"]["a"]["met"] is True


def test_ways_round_are_compared_by_parts_where_sensors_read_several_kinds() -> None:
    """A displacement and a velocity have no root mean square in one unit: it was told in mil, whatever the velocity."""
    text = re.sub(r'b = "([0-9.]+) mil', r'b = "\1 mm/s', ALIKE)
    limits = '[limits.a]\nresponse = "residual"\nat = "a"\nat_most = "5 mil"\n'
    plan = solve_text(f'{text}{limits}[goal]\nminimise = "correction"\n')
    ways = {one.name: one for one in plan.plan.remedies}
    assert "as asked" in ways
    rows = plan.plan.fittings[0].rows
    parts = [row.residual.value / row.found.value for row in rows]
    assert ways["as asked"].rms.dimension == "ratio"
    assert ways["as asked"].rms.value == pytest.approx(np.sqrt(np.mean(np.square(parts))), rel=1e-9)
    assert ways["as asked"].worst == max(rows, key=lambda row: row.residual.value / row.found.value).residual
