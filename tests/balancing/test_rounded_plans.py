"""Plans with weights that can be weighed out: limits hold, read again by complex numbers alone."""

from __future__ import annotations

import cmath
from math import radians

import pytest

import vibopt as vo
from rotor_jobs import FAN, read_text
from vibopt.answer.text import verdict
from vibopt.study.rounded_plan import drawn


def phasor(size: float, degrees: float) -> complex:
    """Lag and angles against rotation turn the same way."""
    return cmath.rect(size, -radians(degrees))


FOUND = {"a": phasor(8.6, 63), "b": phasor(6.5, 206)}
LEFT = {"a": phasor(5.9, 123), "b": phasor(4.5, 228)}
RIGHT = {"a": phasor(6.2, 36), "b": phasor(10.4, 162)}


@pytest.mark.parametrize("bound", [1.0, 2.0, 2.5, 3.0])
def test_a_rounding_that_keeps_the_limit_is_found_where_the_nearest_one_breaks_it(bound: float) -> None:
    text = FAN + f'[limits.low]\nresponse = "residual"\nat_most = "{bound} mil"\n[goal]\nminimise = "correction"\n'
    job = read_text(text)
    done = drawn(job, vo.solve(job), ("2",))
    assert (done.design.status, done.broken) == ("feasible", "")
    assert "least" not in verdict(done.design)  # that is said of the exact weights
    chosen = {path: one.rounded for path, one in done.values.items()}
    left, right = (
        phasor(
            chosen[f"planes.{name}.weight.mass"].value * 1e3, chosen[f"planes.{name}.weight.angle"].value * 57.29577951
        )
        for name in ("left", "right")
    )
    for sensor, found in FOUND.items():
        by_left = (LEFT[sensor] - found) / phasor(10, 270)
        by_right = (RIGHT[sensor] - found) / phasor(12, 180)
        assert abs(found + by_left * left + by_right * right) <= bound * (1 + 1e-9)
    for one in chosen.values():
        assert len(one.shown.split()[0].replace(".", "").lstrip("0")) <= 3  # two digits, of an angle above 99 deg three


@pytest.mark.parametrize("cut", ["", "holes = 8\nsplit = true\n"])
def test_a_rounding_drills_no_deeper_than_may_be_drilled(cut: str) -> None:
    """The best hole is 9 mm deep, 5.55 g of steel: the next gram, 6 g, takes 9.7 mm."""
    drill = 'drill = { diameter = "10 mm", density = "7850 kg/m³", deepest = "9 mm" }'
    job = read_text(FAN.replace('"150 mm"\n', f'"150 mm"\nremove = true\n{drill}\n{cut}', 1))
    done = drawn(job, vo.solve(job), ("1 g", "10 deg"))
    assert (done.design.status, done.broken) == ("feasible", "")
    left = {path: one.rounded.value for path, one in done.values.items() if path.startswith("planes.left")}
    assert max(one for path, one in left.items() if path.endswith("mass")) == pytest.approx(0.005)


PAIR = '[pairs.x]\nplanes = ["left", "right"]\nkind = "couple"\n'


def test_rounded_weights_of_a_pair_stay_a_pair() -> None:
    """Equal unbalances at opposite angles; at two radii no masses in whole grams have them, which is said."""
    job = read_text(FAN + PAIR)
    done = drawn(job, vo.solve(job), ("2",))
    left, right = ({key: done.values[f"planes.{name}.weight.{key}"].rounded.value for key in ("mass", "angle")}
                   for name in ("left", "right"))  # fmt: skip
    assert not done.broken
    assert left["mass"] == pytest.approx(right["mass"])
    assert abs(left["angle"] - right["angle"]) == pytest.approx(radians(180.0))
    other = read_text(FAN.replace('"150 mm"', '"137 mm"', 1) + PAIR)
    missed = drawn(other, vo.solve(other), ("1 g", "10 deg"))
    assert missed.broken == "pairs.x"
    assert "the best breaks pairs.x; " in missed.design.claim


@pytest.mark.parametrize("turn", [340.0, 352.6, 357.2, 359.99])
@pytest.mark.parametrize("asked", ["1", "100 deg", "7 deg", "3"])
def test_an_angle_just_below_a_whole_turn_is_rounded_to_one_that_a_file_may_have(turn: float, asked: str) -> None:
    """400 deg is no angle, and 40 deg not near: what is nearest is a multiple of the step, or nothing."""
    text = f"""[masses.m]
unbalance = "2 kg mm"
angle = "{turn - 180.0} deg"
[planes.p]
radius = "100 mm"
[goal]
minimise = "unbalance"
"""
    job = vo.from_text(text, name="shaft.toml")
    done = drawn(job, vo.solve(job), (asked, "planes.p.weight.mass=1 mg"))
    angle = done.values["planes.p.weight.angle"].rounded.value * 57.29577951308232
    step = {"1": 100.0, "100 deg": 100.0, "7 deg": 7.0, "3": 1.0}[asked]
    places = [step * k for k in range(int(360.0 / step) + 1) if step * k < 360.0]
    off = min(abs((turn - place + 180.0) % 360.0 - 180.0) for place in places)
    assert abs((angle - turn + 180.0) % 360.0 - 180.0) == pytest.approx(off, abs=1e-6)
