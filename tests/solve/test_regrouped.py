"""Designs beside one of several devices: half of one given to another, and what that leads to."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vibopt.program.pose import pose
from vibopt.scene.read import from_dict
from vibopt.solve.ranges import closed
from vibopt.solve.regrouped import divided
from vibopt.solve.solve import solve

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
def test_half_of_a_device_goes_to_an_idle_one_and_both_are_alike_but_for_their_tuning(
    own: dict[str, Any], parts: list[float], idle: int
) -> None:
    """No mass is added, and none of the other devices' numbers change."""
    program = closed(pose(from_dict(tower((0, 0, 2), own))))
    x = program.low * (program.high / program.low) ** np.array(parts)
    x = np.clip(x, program.low, program.high)
    paths = [axis.path for axis in program.axes]
    masses = [paths.index(f"absorbers.a{i}.mass") for i in range(3)]
    x[masses] = np.maximum(x[masses], 0.4)
    x[masses[idle]] = program.low[masses[idle]]
    others = [i for i in range(3) if i != idle]
    designs = divided(program, x)
    assert len(designs) == 4
    for y, giver in zip(designs, np.repeat(others, 2), strict=True):
        changed = {paths[i].split(".")[1] for i in np.flatnonzero(y != x)}
        assert changed == {f"a{idle}", f"a{giver}"}
        assert y[masses[idle]] == y[masses[giver]] == 0.5 * x[masses[giver]]
        assert (y >= program.low).all()
        assert (y <= program.high).all()


def test_where_none_is_idle_none_takes_anything() -> None:
    program = closed(pose(from_dict(tower((0, 0, 2), SPRING))))
    assert not divided(program, np.sqrt(program.low * program.high))


@pytest.mark.slow
def test_five_absorbers_share_the_mass_as_well_as_any_search_of_theirs_did() -> None:
    """Starts alone end with two of them at work, 9 % above; SLSQP on exact peaks from 354 starts ends at 35.45 um."""
    found = solve(from_dict(tower((0, 0, 0, 0, 2), SPRING)), explain=False)
    assert found.goal is not None
    assert found.goal[1].value < 1.01 * 3.545348e-5
