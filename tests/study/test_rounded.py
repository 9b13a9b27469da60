"""Values as they stand on a drawing: rounded, measured, and what that costs."""

from __future__ import annotations

import math
from decimal import Decimal
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from refusals import refused
from texts import best, choice, one_mass, table
from vibopt.charts.machines import absorbed
from vibopt.scene.read import from_text, read, with_changes
from vibopt.solve import solve
from vibopt.study.freeze import frozen
from vibopt.study.grids import x_of
from vibopt.study.rounded import rounded
from vibopt.study.whatif import whatif

PROBLEMS = Path(__file__).parents[2] / "problems"
PRESS = PROBLEMS / "isolation" / "rao_9_34.toml"


def _press(stiffness: float, damping: float) -> tuple[float, float, float]:
    """Dense grid by hand: floor force at 3000 rpm [N], motion there and on the way up [m]."""
    speeds = np.append(np.linspace(1.0, 100.0 * math.pi, 200_001), 100.0 * math.pi)
    motion = 30e3 / np.hypot(stiffness - 300.0 * speeds**2, damping * speeds)
    return float(motion[-1] * math.hypot(stiffness, damping * speeds[-1])), float(motion[-1]), float(motion.max())


@pytest.mark.parametrize("asked", [["1"], ["2"], ["3"], ["4"], ["5"], ["links.mount.stiffness=50 kN/m", "3"]])
def test_rounded_values_keep_every_limit_on_a_dense_grid(asked: list[str]) -> None:
    found = rounded(solve(read(PRESS)), asked)
    stiffness, damping = found.design.x
    force, moved, passed = _press(stiffness, damping)
    assert found.design.status == "feasible"
    assert force <= 10e3 * (1 + 1e-9)
    assert moved <= 2.5e-3
    assert passed <= 20e-3 * (1 + 1e-9)
    assert found.worse_by is not None
    assert found.worse_by >= -1e-9
    assert 6956917.16 * (1.0 - found.worse_by) == pytest.approx(stiffness, rel=1e-6)


@given(digits=st.integers(2, 6), mass=st.floats(200.0, 400.0))
@settings(max_examples=10, deadline=None)
def test_rounded_values_have_as_many_digits_as_asked_and_stay_near(digits: int, mass: float) -> None:
    design = solve(with_changes(read(PRESS), {"bodies.press.mass": f"{mass:.6g} kg"}), explain=False)
    if not design.x:
        return
    found = rounded(design, [str(digits)])
    for value in found.values.values():
        number = Decimal(value.rounded.shown.split()[0])
        assert len(number.normalize().as_tuple().digits) <= digits
        assert value.rounded.value == pytest.approx(value.exact.value, rel=6.0 * 10.0 ** (1 - digits))
    assert (found.design.status == "feasible") == all(one.met for one in found.design.limits.values())


def test_what_is_proven_of_the_exact_values_is_not_said_of_the_rounded_ones() -> None:
    exact = solve(read(PRESS))
    found = rounded(exact, ["3"])
    assert exact.status == "optimal"
    assert found.design.status == "feasible"
    assert not found.design.proven
    assert found.design.claim == (
        "values rounded to 3 digits, every limit measured with them; the goal is 0.099 % worse than that of the exact "
        f"values, which are proven best ({exact.claim})"
    )
    assert found.design.variables["links.mount.stiffness"].value.shown == "6950 kN/m"
    assert found.design.details["rounded"]["worse_by"] == found.worse_by


def test_values_that_are_round_already_stay_proven() -> None:
    design = solve(read(PROBLEMS / "isolation" / "rao_9_34.toml"))
    scene = with_changes(
        design.scene, {"links.mount.stiffness": {"from": "10 kN/m", "to": "5 MN/m"}, "links.mount.damping": "12 kN s/m"}
    )
    exact = solve(scene)
    assert exact.x == (5e6,)
    found = rounded(exact, ["3"])
    assert (found.design.status, found.design.claim) == ("optimal", exact.claim)
    assert found.worse_by == pytest.approx(0.0, abs=1e-12)


NARROW = one_mass(
    "b", "100 kg", {"stiffness": choice("100 kN/m", "400 kN/m"), "damping": "20 N s/m"}, {},
    table("limits.low", response="natural_frequency", at_least="7.12 Hz"),
    table("limits.high", response="natural_frequency", at_most="7.125 Hz"),
    best(minimise="stiffness", of="k"), link="k",
)  # fmt: skip


def test_where_no_rounding_holds_the_answer_says_by_how_much_and_what_would_do() -> None:
    low, high = ((2 * math.pi * f) ** 2 * 100.0 / 1e3 for f in (7.12, 7.125))
    assert (low, high) == pytest.approx((200.13, 200.42), abs=0.01)
    found = rounded(solve(from_text(NARROW)), ["3"])
    assert found.design.status == "violated"
    assert (found.broken, found.enough) == ("low", 4)
    assert found.by == pytest.approx(1.0 - math.sqrt(200.0 / low), rel=1e-9)
    assert found.design.claim == (
        "no rounding to 3 digits near the exact values keeps every limit (8 tried); the best breaks low by 0.033 %; "
        "4 digits would do"
    )
    assert rounded(solve(from_text(NARROW)), ["4"]).kept.document["links"]["k"]["stiffness"] == "200.2 kN/m"


def test_rounding_never_leaves_the_range_of_the_file() -> None:
    text = NARROW.replace('"100 kN/m"', '"200.3 kN/m"').replace("7.125 Hz", "9 Hz")
    found = rounded(solve(from_text(text)), ["3"])
    assert found.kept.document["links"]["k"]["stiffness"] == "201 kN/m"


@pytest.mark.slow
def test_of_an_absorber_mass_spring_and_damper_are_rounded() -> None:
    design = solve(read(PROBLEMS / "absorbers" / "footbridge_marching.toml"), explain=False)
    found = rounded(design, ["2"])
    table = found.kept.document["absorbers"]["absorber"]
    assert set(found.values) == {f"absorbers.absorber.{key}" for key in ("mass", "stiffness", "damping")}
    for key in ("mass", "stiffness", "damping"):
        assert len(Decimal(table[key].split()[0]).normalize().as_tuple().digits) <= 2
    again = solve(found.kept, explain=False)
    assert all(one.met for one in again.limits.values())
    for key, row in again.limits.items():
        assert found.design.limits[key].value.value == row.value.value
    own = math.sqrt(float(table["stiffness"].split()[0]) / float(table["mass"].split()[0]))
    for path, one in found.design.variables.items():
        if path.endswith(".frequency"):
            assert one.value.value == pytest.approx(own, rel=1e-12)


def test_rounded_values_hold_over_the_tolerances() -> None:
    found = rounded(solve(read(PROBLEMS / "isolation" / "press_on_rubber.toml"), explain=False), ["2"])
    stiffness, damping = found.design.x
    worst = 0.0
    for m in (0.95, 1.05):
        for k in (0.8, 1.2):
            for c in (0.9, 1.1):
                speeds = np.linspace(1.0, 100.0 * math.pi, 20_001)
                motion = 30e3 / np.hypot(k * stiffness - 300.0 * m * speeds**2, c * damping * speeds)
                force = motion[-1] * math.hypot(k * stiffness, c * damping * speeds[-1])
                worst = max(worst, force / 10e3, float(motion.max()) / 20e-3)
    assert found.design.status == "feasible"
    assert worst <= 1.0 + 1e-9
    assert found.design.goal is not None
    assert found.design.goal[1].value == pytest.approx(0.8 * stiffness)


def test_a_kept_design_may_be_the_rounded_one() -> None:
    result = whatif(read(PRESS), {"bodies.press.mass": "301 kg"}, keep_design=True, rounding=["3"])
    assert result.before.x == (6.95e6, 9920.0)
    force, _, passed = _press(6.95e6, 9920.0)
    assert result.before.limits["floor_force"].value.value == pytest.approx(force, rel=1e-9)
    (mass,) = (one for one in result.thresholds if one.path == "bodies.press.mass")
    assert mass.above is not None
    assert mass.above.value > 300.0
    assert passed < 20e-3


@pytest.mark.parametrize(
    ("asked", "text"),
    [
        (
            ["three"],
            "--round three: is neither a number of digits from 1 to 12 nor a step. Write --round 3, or --round "
            'links.mount.stiffness="10 kN/m".',
        ),
        (
            ["0"],
            "--round 0: is neither a number of digits from 1 to 12 nor a step. Write --round 3, or --round "
            'links.mount.stiffness="10 kN/m".',
        ),
        (
            ["links.mount.stifness=50 kN/m"],
            '--round links.mount.stifness: this is no value that can be rounded. Did you mean "links.mount.stiffness"?',
        ),
        (
            ["links.mount.stiffness=50 MN/m"],
            '--round links.mount.stiffness="50 MN/m": the step is greater than the value, 6.957 MN/m. Write a smaller '
            'one, "10 kN/m".',
        ),
        (
            ["links.mount.damping=0 N s/m"],
            '--round links.mount.damping="0 N s/m": a step is greater than zero. Write "10 N s/m".',
        ),
    ],
)
def test_what_cannot_be_rounded_is_said(asked: list[str], text: str) -> None:
    design = solve(read(PRESS))
    assert str(refused(rounded, design, asked)) == text


def test_parts_are_not_rounded() -> None:
    design = solve(read(PROBLEMS / "mounts" / "genset_front_and_rear.toml"), explain=False)
    assert str(refused(rounded, design, ["3"])) == (
        "genset_front_and_rear.toml: there is nothing to round: what is chosen are parts, places and listed values."
    )


@pytest.mark.slow
def test_where_the_best_design_has_no_room_a_design_with_room_is_rounded() -> None:
    found = rounded(solve(read(PROBLEMS / "absorbers" / "pump_skid_two_grids.toml"), explain=False), ["3"])
    tables = found.kept.document["absorbers"]
    m, k, c = (
        [float(tables[name][key].split()[0]) for name in ("first", "second")]
        for key in ("mass", "stiffness", "damping")
    )
    base, damper = 95e6, 2 * 0.01 * math.sqrt(95e6 * 800.0)
    for low, high in ((2850, 3000), (3420, 3600)):
        w = np.linspace(low, high, 20_001) * math.pi / 30
        matrix = np.zeros((len(w), 3, 3), dtype=complex)
        matrix[:, 0, 0] = base - 800.0 * w**2 + 1j * damper * w
        for i in (0, 1):
            spring = k[i] + 1j * c[i] * w
            matrix[:, 0, 0] += spring
            matrix[:, i + 1, i + 1] = spring - m[i] * w**2
            matrix[:, 0, i + 1] = matrix[:, i + 1, 0] = -spring
        force = np.zeros((len(w), 3, 1), dtype=complex)
        force[:, 0, 0] = 2e-3 * w**2
        motion = np.linalg.solve(matrix, force)[:, :, 0]
        assert (w * np.abs(motion[:, 0])).max() <= 1.4e-3 * math.sqrt(2.0) * (1 + 1e-9)
        for i in (0, 1):
            assert np.abs(motion[:, i + 1] - motion[:, 0]).max() <= 0.5e-3 * (1 + 1e-9)
    assert found.design.status == "feasible"
    assert found.worse_by is not None
    assert 0.0 < found.worse_by < 0.2


def test_without_limits_the_nearest_values_are_taken() -> None:
    design = solve(read(PROBLEMS / "absorbers" / "rao_9_62.toml"), explain=False)
    found = rounded(design, ["3"])
    assert (found.design.status, found.broken, found.tried) == ("feasible", "", 1)
    for one in found.values.values():
        assert one.rounded.value == pytest.approx(float(f"{one.exact.value:.2e}"), rel=1e-12)
    k, c = (found.values[f"absorbers.absorber.{key}"].rounded.value for key in ("stiffness", "damping"))
    omega = np.linspace(11.0, 12.3, 400_001)
    joint = k + 1j * omega * c
    hung = joint * 10.0 * omega**2 / (joint - 10.0 * omega**2)
    peak = float(np.abs(600.0 / (2e6 - 15000.0 * omega**2 - hung)).max())
    assert found.goal is not None
    assert found.goal.value == pytest.approx(peak, rel=1e-6)


def test_ratios_of_an_absorber_are_read_off_the_parts_that_are_built() -> None:
    design = solve(from_text(absorbed([0], [0.05], damping=0.01)), explain=False)
    assert x_of(design, frozen(design.scene, design.x)) == pytest.approx(design.x, rel=1e-12)
