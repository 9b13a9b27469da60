"""A place left open: the best of all, proven only where each is."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

from vibopt.design.design import Design
from vibopt.design.jsonable import as_json
from vibopt.scene.read import from_dict
from vibopt.solve import solve
from vibopt.study.explain import explain
from vibopt.study.whatif import whatif

DOCUMENT: dict[str, Any] = {
    "title": "Two floors",
    "bodies": {"low": {"mass": "100 t"}, "high": {"mass": "80 t"}},
    "links": {
        "first": {"between": ["ground", "low"], "stiffness": "90 MN/m", "damping": "100 kN s/m"},
        "second": {"between": ["low", "high"], "stiffness": "80 MN/m", "damping": "100 kN s/m"},
    },
    "absorbers": {
        "tmd": {
            "on": {"one_of": ["low", "high"]},
            "mass": "4 t",
            "frequency": {"from": "2 Hz", "to": "5 Hz"},
            "damping_ratio": 0.1,
        }
    },
    "excitations": {
        "wind": {"kind": "force", "on": "high", "amplitude": "10 kN", "speed": "0..6 Hz", "varies": "constant"}
    },
    "limits": {"low": {"response": "displacement", "of": "low", "at_most": "1 m"}},
    "goal": {"minimise": "displacement", "of": "high"},
}


@cache
def _solved() -> Design:
    return solve(from_dict(DOCUMENT))


def worst_by_hand(place: int, frequency: float) -> float:
    """Greatest displacement of the upper floor on a dense grid, by plain matrices [m]."""
    m = np.diag([1e5, 8e4, 4e3])
    k = np.array([[170e6, -80e6, 0.0], [-80e6, 80e6, 0.0], [0.0, 0.0, 0.0]])
    c = np.array([[200e3, -100e3, 0.0], [-100e3, 100e3, 0.0], [0.0, 0.0, 0.0]])
    own = 4e3 * frequency**2
    row = np.zeros(3)
    row[place], row[2] = -1.0, 1.0
    k, c = k + own * np.outer(row, row), c + 2 * 0.1 * np.sqrt(own * 4e3) * np.outer(row, row)
    w = np.linspace(1e-6, 12 * np.pi, 1501)[:, None, None]
    return float(np.abs(np.linalg.inv(k + 1j * w * c - w**2 * m)[:, 1, 1]).max() * 1e4)


def test_the_best_place_is_that_of_a_dense_search() -> None:
    design = _solved()
    assert design.goal is not None
    tried = {
        place: min(worst_by_hand(i, w) for w in np.linspace(4 * np.pi, 10 * np.pi, 400))
        for i, place in enumerate(("low", "high"))
    }
    assert design.status == "optimal"
    assert design.places["absorbers.tmd.on"].value == min(tried, key=lambda one: tried[one]) == "high"
    assert design.goal[1].value == pytest.approx(tried["high"], rel=1e-2)
    assert {one["place"]: one["value"] for one in design.details["places"]} == pytest.approx(tried, rel=1e-2)


def test_the_place_is_among_the_variables_of_every_output() -> None:
    design = _solved()
    said = as_json(design)["variables"]["absorbers.tmd.on"]
    assert said == {"value": "high", "unit": "", "shown": "high", "at_bound": "", "one_of": ["low", "high"]}
    assert "absorbers.tmd.on         high      chosen from low, high" in design.report()


def test_the_studies_take_a_place_left_open() -> None:
    scene = from_dict(DOCUMENT)
    assert explain(scene).design.places["absorbers.tmd.on"].value == "high"
    kept = whatif(scene, {"bodies.low.mass": "120 t"}, keep_design=True)
    assert kept.after.scene.absorbers["tmd"].host == "high"
    assert whatif(scene, {"absorbers.tmd.on": "low"}).after.status == "optimal"


def test_an_analysis_with_nothing_but_a_place_to_choose_is_answered() -> None:
    absorber = {**DOCUMENT["absorbers"]["tmd"], "frequency": "3 Hz"}
    design = solve(from_dict({**DOCUMENT, "absorbers": {"tmd": absorber}}))
    assert (design.status, design.places["absorbers.tmd.on"].value) == ("optimal", "high")
