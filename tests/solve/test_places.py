"""A place left open: the best of all, proven only where each is."""

from __future__ import annotations

from functools import cache
from itertools import combinations_with_replacement, product
from typing import Any

import numpy as np
import pytest

from vibopt.scene.open_places import settled
from vibopt.scene.read import from_dict
from vibopt.scene.scene import Design
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


def worst_by_hand(place: int, frequency: float, mass: float = 8e4, damping: float = 0.1) -> float:
    """Greatest displacement of the upper floor on a grid that is dense around resonances, by plain matrices [m]."""
    m = np.diag([1e5, mass, 4e3])
    k = np.array([[170e6, -80e6, 0.0], [-80e6, 80e6, 0.0], [0.0, 0.0, 0.0]])
    c = np.array([[200e3, -100e3, 0.0], [-100e3, 100e3, 0.0], [0.0, 0.0, 0.0]])
    own = 4e3 * frequency**2
    row = np.zeros(3)
    row[place], row[2] = -1.0, 1.0
    k, c = k + own * np.outer(row, row), c + 2 * damping * np.sqrt(own * 4e3) * np.outer(row, row)
    modes = np.sqrt(np.linalg.eigvals(np.linalg.solve(m, k)).real)
    near = np.outer(modes, 1.0 + np.outer([-1.0, 1.0], np.geomspace(1e-7, 0.1, 300)).ravel()).ravel()
    w = np.union1d(np.linspace(1e-6, 12 * np.pi, 1501), near[near < 12 * np.pi])[:, None, None]
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
    said = design.to_json()["variables"]["absorbers.tmd.on"]
    assert said == {"value": "high", "unit": "", "shown": "high", "at_bound": "", "one_of": ["low", "high"]}
    assert "absorbers.tmd.on         high      chosen from low, high" in design.report()


def test_the_studies_take_a_place_left_open() -> None:
    scene = from_dict(DOCUMENT)
    assert explain(scene).answer.places["absorbers.tmd.on"].value == "high"
    kept = whatif(scene, {"bodies.low.mass": "120 t"}, keep_design=True)
    assert kept.after.scene.absorbers["tmd"].host == "high"
    assert whatif(scene, {"absorbers.tmd.on": "low"}).after.status == "optimal"


def test_an_absorber_without_a_damper_is_followed_over_its_range_where_boxes_do_not_end() -> None:
    absorber = {**DOCUMENT["absorbers"]["tmd"], "on": "low", "damping_ratio": 0.0}
    design = solve(from_dict({**DOCUMENT, "absorbers": {"tmd": absorber}}))
    assert (design.status, design.method) == ("optimal", "one_range")
    assert design.goal is not None
    best = design.goal[1].value
    tried = [worst_by_hand(0, 2.0 * np.pi * f, damping=0.0) for f in np.linspace(2.0, 5.0, 61)]
    assert best <= min(tried) * (1.0 + 1e-4)
    assert worst_by_hand(0, design.variables["absorbers.tmd.frequency"].value.value, damping=0.0) <= best * (1.0 + 1e-6)


def test_an_analysis_with_nothing_but_a_place_to_choose_is_answered() -> None:
    absorber = {**DOCUMENT["absorbers"]["tmd"], "frequency": "3 Hz"}
    design = solve(from_dict({**DOCUMENT, "absorbers": {"tmd": absorber}}))
    assert (design.status, design.places["absorbers.tmd.on"].value) == ("optimal", "high")


@pytest.mark.parametrize("tolerance", ["3 %", "10 %"])
def test_with_nothing_but_a_place_to_choose_the_goal_is_that_of_the_worst_machine(tolerance: str) -> None:
    absorber = {**DOCUMENT["absorbers"]["tmd"], "frequency": "3 Hz"}
    high = {**DOCUMENT["bodies"]["high"], "tolerance": tolerance}
    document = {**DOCUMENT, "absorbers": {"tmd": absorber}, "bodies": {**DOCUMENT["bodies"], "high": high}}
    design = solve(from_dict(document))
    part = float(tolerance.split()[0]) / 100.0

    def worst(place: int) -> float:
        return max(worst_by_hand(place, 6 * np.pi, 8e4 * off) for off in np.linspace(1 - part, 1 + part, 21))

    assert design.status == "optimal"
    assert design.goal is not None
    assert design.goal[1].value == pytest.approx(min(worst(0), worst(1)), rel=2e-3)
    assert design.goal[1].value > 1.01 * min(worst_by_hand(0, 6 * np.pi), worst_by_hand(1, 6 * np.pi))
    assert design.tolerances is not None
    assert set(design.tolerances.goal_off) == {"bodies.high.mass"}


def test_a_measure_that_is_not_proven_over_the_tolerances_takes_nothing_from_the_place() -> None:
    tmd = {"on": {"one_of": ["low", "high"]}, "mass": "4 t", "frequency": "3.5 Hz", "damping_ratio": 0.1}
    high = {**DOCUMENT["bodies"]["high"], "tolerance": "3 %"}
    asked = {"absorbers": {"tmd": tmd}, "bodies": DOCUMENT["bodies"] | {"high": high}}
    measured = {"measures": {"rate": {"response": "decay_rate"}}}
    alone, beside = (solve(from_dict(DOCUMENT | asked | more)) for more in ({}, measured))
    assert (beside.status, beside.goal) == (alone.status, alone.goal)
    assert alone.status == "optimal"
    assert not beside.proven
    assert beside.tolerances is not None
    assert beside.tolerances.open == ("measures.rate",)


FLOORS = ("low", "middle", "high")


def _storeys(count: int, **changes: Any) -> dict[str, Any]:
    """Three floors and some absorbers, all alike but for what is changed by name."""
    one = {"on": {"one_of": list(FLOORS)}, "mass": "2 t", "frequency": "2 Hz", "damping_ratio": 0.1}
    names = [f"tmd{n}" for n in range(count)]
    return {
        "bodies": {name: {"mass": "100 t"} for name in FLOORS},
        "links": {
            f"storey{n}": {"between": list(two), "stiffness": "90 MN/m", "damping": "100 kN s/m"}
            for n, two in enumerate((("ground", "low"), ("low", "middle"), ("middle", "high")))
        },
        "absorbers": {name: {**one, **changes.get(name, {})} for name in names},
        "excitations": {
            "wind": {"kind": "force", "on": "high", "amplitude": "10 kN", "speed": "0..9 Hz", "varies": "constant"}
        },
        "limits": {f"travel of {name}": {"response": "stroke", "of": name, "at_most": "300 mm"} for name in names},
        "goal": {"minimise": "displacement", "of": "high"},
    }


@pytest.mark.parametrize("count", [2, pytest.param(3, marks=pytest.mark.slow)])
def test_identical_absorbers_are_put_on_each_set_of_places_once_and_the_best_is_that_of_all_orders(count: int) -> None:
    document = _storeys(count)
    design = solve(from_dict(document))
    tried = [tuple(row["on"].values()) for row in design.details["places"]]
    assert tried == list(combinations_with_replacement(FLOORS, count))
    assert f"the best of {len(tried)} places" in design.claim
    names = " and ".join(f"tmd{n}" for n in range(count))
    assert design.claim.endswith(f"; {names} are identical: exchanged they count once")
    assert design.goal is not None
    goals = {}
    for places in product(FLOORS, repeat=count):
        put = {f"tmd{n}": {"on": place} for n, place in enumerate(places)}
        fixed = {**_storeys(count, **put), "measures": {"sway": {"response": "displacement", "of": "high"}}}
        del fixed["goal"]
        answer = solve(from_dict(fixed), explain=False)
        if answer.status == "met":
            goals[places] = answer.measures["sway"].value.value
    assert design.goal[1].value == pytest.approx(min(goals.values()), rel=1e-12)
    chosen = tuple(one.value for one in design.places.values())
    assert goals[chosen] == pytest.approx(min(goals.values()), rel=1e-12)
    assert list(chosen) == sorted(chosen, key=FLOORS.index)


@pytest.mark.parametrize(
    "changes",
    [
        {"tmd1": {"mass": "2.1 t"}},
        {"tmd1": {"on": {"one_of": ["low", "high"]}}},
        {"limits": {"only": {"response": "stroke", "of": "tmd0", "at_most": "300 mm"}}},
        {"links": {"tie": {"between": ["tmd1", "ground"], "stiffness": "1 kN/m"}}},
    ],
    ids=["another mass", "other places", "a limit of one", "a link to one"],
)
def test_absorbers_that_differ_in_anything_that_the_file_says_are_not_exchanged(changes: dict[str, Any]) -> None:
    document = _storeys(2, **{key: one for key, one in changes.items() if key.startswith("tmd")})
    document |= {"limits": changes.get("limits", document["limits"])}
    document |= {"links": {**document["links"], **changes.get("links", {})}}
    design = solve(from_dict(document), explain=False)
    places = [len(one["on"]["one_of"]) for one in document["absorbers"].values()]
    assert len(design.details["places"]) == places[0] * places[1]
    assert "identical" not in design.claim


def test_identical_absorbers_at_many_places_are_few_enough_to_be_looked_at() -> None:
    """Five on three floors: 21 sets instead of 243 orders, which would be refused."""
    assert len(list(settled(from_dict(_storeys(5))))) == 21
