"""What takes over at the end of a range is what the goal feels; what is free of the goal touches limits by chance."""

from __future__ import annotations

import math
import re
from pathlib import Path

import pytest

import vibopt as vo
from vibopt.answer.entry import Way
from vibopt.scene.read import from_text, with_changes
from vibopt.solve import solve
from vibopt.study.prices import prices
from vibopt.units import si_unit

TEXT = """
[bases.floor]
[bodies.a]
mass = "266.05 kg"
[links.m0]
between = ["a", "floor"]
stiffness = { from = "6348.9 N/m", to = "35977 N/m" }
loss_factor = { from = 0.066083, to = 0.39842 }
[excitations.e0]
kind = "base_motion"
on = "floor"
speed = "720.44 rpm"
acceleration = "1.4827 m/s2 pp"
varies = [["0 rpm", 0.0], ["600 rpm", 0.71454], ["1500 rpm", 0.96164], ["20000 rpm", 1.0]]
[limits.l0]
response = "relative_displacement"
across = "m0"
over = "start-up"
at_most = "0.0071525 m"
[goal]
minimise = "stiffness"
of = "m0"
"""
FROM, ALLOWED = "links.m0.stiffness.from", "limits.l0.at_most"
CLOSE = 5e-5
"""Ends of ranges are told to four digits where values are answered one by one."""


def drift(stiffness: float, allowed: float = 0.0071525) -> float:
    """Greatest relative displacement over the start-up with the most damping, as a part of what is allowed [m].

    On a grid of 40 000 speeds by the textbook: |Z| = |Y w²| / |w0² (1 + i eta) - w²|, the acceleration |Y w²| given.
    """
    greatest = 0.0
    for k in range(1, 40_001):
        speed = 720.44 * k / 40_000
        factor = 0.71454 * speed / 600.0 if speed < 600.0 else 0.71454 + (speed - 600.0) / 900.0 * (0.96164 - 0.71454)
        acceleration, w = 0.5 * 1.4827 * factor, speed * 2.0 * math.pi / 60.0
        greatest = max(greatest, acceleration / abs(stiffness / 266.05 * (1.0 + 0.39842j) - w * w))
    return greatest / allowed


def goal_at(path: str, value: float, unit: str) -> float:
    found = vo.solve(with_changes(from_text(TEXT), {path: f"{value!r} {unit}"}))
    assert found.goal is not None
    return found.goal[1].value


def way_of(path: str) -> Way:
    """Downwards."""
    return prices(from_text(TEXT), only=[path]).find(path).ways[0]


@pytest.mark.slow
def test_a_limit_takes_over_where_the_goal_leaves_the_end_of_the_range() -> None:
    way = way_of(FROM)
    assert way.until is not None
    for part in (0.999, 0.9, 0.6):  # l0 may be touched there, the goal is the end of the range
        assert goal_at(FROM, 6348.9 * part, "N/m") == 6348.9 * part
    end = way.until.value
    assert "l0 takes over" in way.then
    assert abs(drift(end) - 1.0) < CLOSE
    assert goal_at(FROM, 1.001 * end, "N/m") == 1.001 * end
    assert abs(goal_at(FROM, 0.999 * end, "N/m") / end - 1.0) < CLOSE


def test_a_tighter_limit_takes_over_where_the_goal_begins_to_rise() -> None:
    way = way_of(ALLOWED)
    assert way.until is not None
    end = way.until.value
    assert abs(drift(6348.9, end) - 1.0) < CLOSE
    assert goal_at(ALLOWED, 1.001 * end, "m") == 6348.9
    assert goal_at(ALLOWED, 0.998 * end, "m") > 6348.9 * (1.0 + 1e-4)


SHELF = """part,rated load max [N],stiffness [N/mm],loss factor,price [EUR]
A,1200,180,0.12,14
B,1700,260,0.12,17
C,2300,420,0.14,22
D,2000,240,0.2,29
"""
PUMP = """
bodies.pump.mass = "520 kg"
links.feet.between = ["pump", "ground"]
links.feet.part = { catalogue = "shelf.csv" }
links.feet.count = { from = 4, to = 7, whole = true }
excitations.shaft = { kind = "unbalance", on = "pump", unbalance = "0.08 kg m", speed = "1100 rpm" }
limits.floor = { response = "transmitted_force", into = "ground", at_most = "300 N" }
limits.start = { response = "displacement", of = "pump", over = "start-up", at_most = "1.4 mm" }
goal.minimise = "price"
"""


def test_of_parts_the_choice_takes_over_and_not_what_it_brings(tmp_path: Path) -> None:
    (tmp_path / "shelf.csv").write_text(SHELF)
    (tmp_path / "pump.toml").write_text(PUMP)
    job = vo.read(tmp_path / "pump.toml")
    feet, count, seen = "links.feet.part", "links.feet.count", 0
    for path in ("bodies.pump.mass", "limits.floor.at_most", "limits.start.at_most", "excitations.shaft.unbalance"):
        row = prices(job, only=[path]).find(path)
        for way in row.ways:
            if way.until is None or " = " not in way.then:
                continue
            end, seen = way.until.value, seen + 1
            out = end + 1e-3 * (end - row.now.value)
            unit = si_unit(way.until.dimension)
            sides = [vo.solve(vo.with_changes(job, {path: f"{x!r} {unit}"})) for x in (2.0 * end - out, out)]
            inside, outside = (
                {f"{feet} = {one.places[feet].value}", f"{count} = {one.variables[count].value.shown}"} for one in sides
            )
            assert set(re.findall(r"links\.\S+ = \w+", way.then)) == inside ^ outside
    assert seen >= 4


FLOORS = """
bodies = { f1.mass = "8 t", f2.mass = "6 t" }
links.c1 = { between = ["f1", "ground"], stiffness = "6 MN/m", damping = "8 kN s/m" }
links.c2 = { between = ["f2", "f1"], stiffness = "5 MN/m", damping = "6 kN s/m" }
excitations.fan = { kind = "force", on = "f2", amplitude = "500 N", speed = "2..8 Hz", varies = "constant" }
limits.mass = { response = "total_mass", at_most = "14.3 t" }
goal = { minimise = "displacement", of = "f2" }
[absorbers.low]
on = "f1"
mass = { from = "10 kg", to = "400 kg" }
frequency = { from = "2 Hz", to = "9 Hz" }
damping_ratio = 0.12
[absorbers.top]
on = "f2"
mass = { from = "10 kg", to = "400 kg" }
frequency = { from = "2 Hz", to = "9 Hz" }
damping_ratio = 0.12
"""


@pytest.mark.parametrize("allowed", [12.9, 14.0, 14.015])
def test_beside_a_design_that_there_is_none_is_proven_as_without_it(allowed: float) -> None:
    """The floors are 14 t, and either absorber 10 kg at least."""
    near = (100.0, 3.0, 100.0, 3.0)
    job = with_changes(from_text(FLOORS), {"limits.mass.at_most": f"{allowed} t"})
    assert solve(job, explain=False).status == "infeasible"
    assert solve(job, explain=False, near=near).status == "infeasible"
