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
