"""Designs beside one of several devices, and what they lead to."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vibopt.arrays import FloatArray
from vibopt.program.pose import pose
from vibopt.program.program import Aim, Limit
from vibopt.scene.read import from_dict
from vibopt.solve.least_pth import _followed, _norm, _rows, _steepness
from vibopt.solve.ranges import closed
from vibopt.solve.screen import beside, tuned
from vibopt.solve.solve import solve
from vibopt.work import metered

few = settings(derandomize=True, database=None, deadline=None, max_examples=30)
SPRING = {
    "stiffness": {"from": "1472 N/m", "to": "1326 kN/m"},
    "damping": {"from": "0.02038 N s/m", "to": "4324 N s/m"},
}
TUNED = {"tuning": {"from": 0.5, "to": 1.5}, "damping_ratio": {"from": 0.01, "to": 0.5}}


def tower(on: tuple[int, ...], own: dict[str, Any]) -> dict[str, Any]:
    """Four undamped floors, the third shaken, and light absorbers on them that share 3.525 kg."""
    floors = zip((10.1, 19.6, 10.2, 30.6), (96973.0, 869975.0, 113065.0, 948722.0), strict=True)
    tables: dict[str, Any] = {"bodies": {}, "links": {}}
    for i, (m, k) in enumerate(floors):
        tables["bodies"][f"b{i}"] = {"mass": f"{m} kg"}
        tables["links"][f"l{i}"] = {"between": [f"b{i}", f"b{i - 1}" if i else "ground"], "stiffness": f"{k} N/m"}
    mass = {"mass": {"from": "0.0705 kg", "to": "3.525 kg"}}
    return {
        "title": "t",
        **tables,
        "absorbers": {f"a{i}": {"on": f"b{one}", **mass, **own} for i, one in enumerate(on)},
        "excitations": {"f": {"kind": "force", "on": "b2", "amplitude": "1 kN", "speed": "289.011..408.887 rad/s"}},
        "limits": {"mass": {"response": "absorber_mass", "at_most": "3.525 kg"}},
        "goal": {"minimise": "displacement", "of": "b1"},
    }


@few
@given(st.sampled_from([SPRING, TUNED]), st.lists(st.floats(0.0, 1.0), min_size=9, max_size=9), st.integers(0, 2))
def test_what_designs_beside_one_lead_to_is_apart_from_each_other_and_within_the_ranges(
    own: dict[str, Any], parts: list[float], batch: int
) -> None:
    program = closed(pose(from_dict(tower((0, 0, 2), own))))
    low, high = np.log(program.low), np.log(program.high)
    fresh = np.array(beside(program, low + (high - low) * np.array(parts), batch))
    assert (fresh >= low).all()
    assert (fresh <= high).all()
    away = np.abs(fresh[:, None] - fresh) / (high - low)
    assert away.max(axis=2)[np.triu_indices(len(fresh), 1)].min(initial=1.0) > 0.03


@few
@given(st.sampled_from([SPRING, TUNED]), st.sampled_from([1.0, 4.0, 24.0]))
def test_the_norm_of_a_power_goes_with_its_slope_and_falls_towards_the_greatest_value(
    own: dict[str, Any], power: float
) -> None:
    """What limits are missed by is in it; designs followed for a high power end with a greatest value no greater."""
    program = closed(pose(from_dict(tower((0, 0, 2), own))))
    low, high = np.log(program.low), np.log(program.high)
    y = np.clip(tuned(program, 8), low, high)
    parts: list[Limit | Aim] = list(program.parts)
    rows = _rows(parts, y)
    slope, bend = _steepness(rows, power)
    step = 1e-6 * np.cos(np.arange(y.size)).reshape(y.shape)
    risen = (_norm(_rows(parts, y + step), power) - _norm(_rows(parts, y - step), power)) / 2.0
    along = (slope * step).sum(axis=1)
    assert risen == pytest.approx(along, rel=1e-4, abs=1e-4 * np.abs(along).max())
    assert (np.linalg.eigvalsh(bend) > -1e-9 * np.abs(bend).max()).all()
    there, _ = _followed(parts, y, low, high, power, 10)
    assert (_norm(_rows(parts, there), power) <= _norm(rows, power)).all()


@few
@given(st.integers(1, 8), st.integers(0, 5))
def test_following_designs_counts_as_work(count: int, rounds: int) -> None:
    """As much for each of them, and for each step of it and its beginning."""
    program = closed(pose(from_dict(tower((0, 0, 2), SPRING))))
    y, parts = tuned(program, count), list[Limit | Aim](program.parts)

    def taken(some: FloatArray, steps: int) -> float:
        with metered() as meter:
            _followed(parts, some, np.log(program.low), np.log(program.high), 4.0, steps)
        return meter.done

    assert taken(y, rounds) == pytest.approx(count * (1 + rounds) * taken(y[:1], 0))
    assert taken(y[:1], 0) > 0.0


TOWERS: dict[str, tuple[Any, ...]] = {
    "two of any mass": (
        (20.0, 10.2, 11.9, 97.5), (84412.0, 770912.0, 737022.0, 60410.0), (51.97, 112.17, 118.46, 97.08),
        {"on": (3, 0), "mass": (0.1396, 6.98), "k": (116.9, 96320.0), "c": (0.008081, 1640.0)},
        ("57.884..78.314 rad/s", 3, 2), 1.7950691e-3,
    ),
    "three in two bands": (
        (47.8, 26.6, 55.6, 13.6), (447795.0, 430340.0, 786168.0, 149064.0), (0.0,) * 4,
        {"on": (0, 3, 0), "mass": (0.1436, 7.18), "k": (292.7, 1276000.0), "c": (0.01297, 6055.0)},
        (["90.292..122.16 rad/s", "180.449..281.086 rad/s"], 2, 0), 1.1264783e-3,
    ),
    "five of given mass": (
        (15.0, 22.6, 21.4, 21.1), (912276.0, 606920.0, 46997.0, 378908.0), (0.0,) * 4,
        {"on": (0, 2, 1, 1, 2), "mass": (0.875, 2.105, 2.273, 2.271, 1.016), "k": (3046.0, 130300.0), "c": (0.1, 1089)},
        ("118..159.647 rad/s", 0, 0), 6.815374e-4,
    ),
    "five of any mass": (
        (10.1, 19.6, 10.2, 30.6), (96973.0, 869975.0, 113065.0, 948722.0), (0.0,) * 4,
        {"on": (0, 0, 0, 0, 2), "mass": (0.0705, 3.525), "k": (1472.0, 1326000.0), "c": (0.02038, 4324.0)},
        ("289.011..408.887 rad/s", 2, 1), 3.545348e-5,
    ),
}  # fmt: skip
"""Masses, springs and dampers of floors, absorbers on some with ranges, the force (1 kN) and where the motion counts,
and the least of it that SLSQP found (scipy, own matrices, exchange of peaks, tuned at random, 60 to 350 starts)."""


@pytest.mark.parametrize("name", [*[*TOWERS][:1], *(pytest.param(n, marks=pytest.mark.slow) for n in [*TOWERS][1:])])
def test_absorbers_on_towers_are_as_good_as_many_random_starts_of_another_search(name: str) -> None:
    masses, springs, dampers, own, (speed, shaken, seen), theirs = TOWERS[name]
    document = tower(own["on"], {"stiffness": ends("N/m", *own["k"]), "damping": ends("N s/m", *own["c"])})
    for i, (m, k, c) in enumerate(zip(masses, springs, dampers, strict=True)):
        document["bodies"][f"b{i}"] = {"mass": f"{m} kg"}
        document["links"][f"l{i}"] |= {"stiffness": f"{k} N/m"} | ({"damping": f"{c} N s/m"} if c else {})
    given_ = name.endswith("given mass")
    for i, absorber in enumerate(document["absorbers"].values()):
        absorber["mass"] = f"{own['mass'][i]} kg" if given_ else ends("kg", *own["mass"])
    document["limits"] = {} if given_ else {"mass": {"response": "absorber_mass", "at_most": f"{own['mass'][1]} kg"}}
    document["excitations"]["f"] |= {"on": f"b{shaken}", "speed": speed}
    document["goal"]["of"] = f"b{seen}"
    found = solve(from_dict(document), explain=False)
    assert found.goal is not None
    assert found.goal[1].value < (1.0 + 1e-4) * theirs


def ends(unit: str, low: float, high: float) -> dict[str, str]:
    return {"from": f"{low} {unit}", "to": f"{high} {unit}"}
