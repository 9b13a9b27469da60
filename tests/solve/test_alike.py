"""Identical devices have a canonical order: heaviest first, then frequency, in the order of the file."""

from __future__ import annotations

from importlib import import_module
from itertools import permutations
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vibopt.program.pose import pose
from vibopt.scene.read import from_dict
from vibopt.solve import solve
from vibopt.solve.alike import in_order
from vibopt.solve.branch import Judge
from vibopt.solve.method import Found

MASS, TUNING = {"from": "1 kg", "to": "9 kg"}, {"from": "6 Hz", "to": "20 Hz"}


def machine(names: tuple[str, ...], **limits: Any) -> dict[str, Any]:
    absorber = {"on": "skid", "mass": MASS, "frequency": TUNING, "damping_ratio": {"from": 0.01, "to": 0.4}}
    return {
        "title": "Skid",
        "bodies": {"skid": {"mass": "100 kg"}},
        "links": {"mounts": {"between": ["skid", "ground"], "stiffness": "0.6 MN/m", "damping_ratio": 0.02}},
        "absorbers": {name: dict(absorber) for name in names},
        "excitations": {
            "fan": {"kind": "force", "on": "skid", "amplitude": "50 N", "speed": "8..16 Hz", "varies": "constant"}
        },
        "limits": {"mass": {"response": "absorber_mass", "at_most": "12 kg"}, **limits},
        "goal": {"minimise": "displacement", "of": "skid"},
    }


def numbers(count: int) -> st.SearchStrategy[list[list[float]]]:
    """Equal or well apart, for what differs by next to nothing counts as equal."""
    part = st.integers(2, 30).map(lambda hundredths: 0.01 * hundredths)
    one = st.tuples(st.sampled_from([1.5, 2.0, 3.0]), st.integers(40, 120).map(float), part).map(list)
    return st.lists(one, min_size=count, max_size=count)


@settings(max_examples=30, deadline=None)
@given(count=st.integers(2, 4), data=st.data())
def test_whatever_order_a_method_finds_them_in_the_answer_is_the_same(count: int, data: st.DataObject) -> None:
    rows = data.draw(numbers(count))
    scene = from_dict(machine(tuple("abcd"[:count])))
    program = pose(scene)
    found = {
        tuple(np.asarray(in_order(scene, program, Found("feasible", np.concatenate(one), "", "")).x))
        for one in permutations([np.array(row) for row in rows])
    }
    assert len(found) == 1
    x = np.array(found.pop()).reshape(count, 3)
    told = np.array(sorted(rows, key=lambda row: (-row[0], row[1], row[2])))
    if (told[:, 1:] == told[0, 1:]).all():  # move as one, and share evenly
        told[:, 0] = told[:, 0].mean()
    np.testing.assert_allclose(x, told, rtol=1e-15)


def test_what_one_of_them_alone_must_keep_is_not_broken_by_the_order() -> None:
    scene = from_dict(machine(("a", "b"), light={"response": "mass", "of": "a", "at_most": "2 kg"}))
    program = pose(scene)
    x = np.array([1.5, 60.0, 0.1, 8.0, 70.0, 0.1])
    assert Judge(program).feasible(x)
    kept = in_order(scene, program, Found("feasible", x, "", ""))
    np.testing.assert_array_equal(kept.x, x)


def test_devices_with_words_of_their_own_keep_their_numbers() -> None:
    document = machine(("a", "b"))
    document["absorbers"]["b"]["damping_ratio"] = {"from": 0.01, "to": 0.3}
    scene = from_dict(document)
    x = np.array([1.5, 60.0, 0.1, 8.0, 70.0, 0.1])
    np.testing.assert_array_equal(in_order(scene, pose(scene), Found("feasible", x, "", "")).x, x)


def test_names_of_identical_absorbers_change_no_number_of_the_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(import_module("vibopt.solve.relaxed"), "MOST", 5_000)
    answers = [solve(from_dict(machine(one)), explain=False) for one in (("x", "y"), ("zeta", "alpha"))]
    x, other = (np.array(one.x) for one in answers)
    np.testing.assert_allclose(x, other, rtol=1e-12)
    assert x[0] >= x[3] * (1.0 - 1e-9)


def test_words_and_units_make_no_two_devices_of_one() -> None:
    document = machine(("a", "b"))
    document["absorbers"]["b"] |= {
        "mass": {"from": "1000 g", "to": "9000 g"},
        "frequency": {"from": "360 rpm", "to": "20 Hz"},
    }
    scene = from_dict(document)
    x = np.array([1.5, 60.0, 0.1, 8.0, 70.0, 0.1])
    there = in_order(scene, pose(scene), Found("feasible", x, "", "")).x
    np.testing.assert_array_equal(there, [8.0, 70.0, 0.1, 1.5, 60.0, 0.1])


def test_springs_side_by_side_that_may_share_in_any_way_share_evenly() -> None:
    mount = {"between": ["skid", "ground"], "stiffness": {"from": "10 kN/m", "to": "1 MN/m"}, "damping": "90 N s/m"}
    document = machine(())
    document |= {"links": {"p": dict(mount), "q": dict(mount)}, "limits": {}}
    del document["absorbers"]
    scene = from_dict(document)
    there = in_order(scene, pose(scene), Found("feasible", np.array([2e4, 6e4]), "", "")).x
    np.testing.assert_allclose(there, [4e4, 4e4], rtol=1e-15)
