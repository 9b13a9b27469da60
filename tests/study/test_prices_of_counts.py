"""A limit on a number of mounts is loosened by whole numbers."""

from __future__ import annotations

from typing import Any

import pytest
from ranged import ranged

import vibopt as vo
from vibopt.scene.read import from_dict


def scene(**bounds: int) -> Any:
    """Mounts of which as few, or as many, as a limit lets are wanted."""
    document = {
        "bodies": {"m": {"mass": "100 kg"}},
        "links": {
            "l": {
                "between": ["m", "ground"],
                "stiffness": "50 kN/m",
                "damping": "200 N s/m",
                "count": {"from": 1, "to": 8, "whole": True},
            }
        },
        "limits": {"number": {"response": "count", "of": "l", **bounds}},
        "goal": {"minimise" if "at_most" in bounds else "maximise": "static_deflection", "of": "m"},
    }
    return from_dict(document)


@pytest.mark.parametrize(("bounds", "then"), [({"at_most": 3}, 4.0), ({"at_least": 3}, 2.0), ({"at_least": 1}, None)])
def test_the_price_of_a_count_is_that_of_one_mount(bounds: dict[str, int], then: float | None) -> None:
    price = ranged(vo.solve(scene(**bounds))).limits["number"].price
    assert (price.loosened.value if price is not None else None) == then


def test_a_number_that_clashes_is_loosened_to_a_whole_one() -> None:
    document = {**scene(at_most=2).document, "goal": {"minimise": "count", "of": "l"}}
    document["limits"] = {
        **document["limits"],
        "sag": {"response": "static_deflection", "of": "m", "at_most": "4.2 mm"},
    }
    conflict = vo.solve(from_dict(document)).conflict
    assert conflict is not None
    number = next(then for name, _, then in conflict.loosenings if name == "number")
    assert number.value == 5.0  # 100 kg * 9.80665 m/s² / 4.2 mm is 4.67 times 50 kN/m


def test_a_machine_as_given_whose_limits_are_touched_is_explained() -> None:
    """Nothing is chosen and there is no goal: what a wider bound buys is a margin."""
    push = {"kind": "pulse", "on": "m", "shape": "rectangle", "amplitude": "1 kN", "duration": "2 s"}
    document: dict[str, Any] = {
        "bodies": {"m": {"mass": "100 kg"}},
        "links": {"l": {"between": ["m", "ground"], "stiffness": "50 kN/m"}},
        "excitations": {"push": push},
        "limits": {"stiff": {"response": "stiffness", "of": "l", "at_least": "50 kN/m"}},
    }
    document["limits"]["way"] = {"response": "peak_displacement", "of": "m", "at_most": "40 mm"}
    found = vo.explain(vo.from_dict(document)).answer
    assert found.goal is None
    assert found.limits["way"].margin == pytest.approx(0.0, abs=1e-9)
    assert found.limits["stiff"].price is None
