"""Mean squares on boxes of designs: polynomials that bound them, and optima proven by them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import differential_evolution

from vibopt.forms import RootMeanSquare
from vibopt.forms.bounds import FormBounds
from vibopt.forms.mean_square_on_boxes import at_designs
from vibopt.program.pose import pose
from vibopt.program.program import Program
from vibopt.scene.read import from_dict
from vibopt.solve.boxes_first import BoxesFirst
from vibopt.solve.nlp import Nlp
from vibopt.solve.ranges import closed
from vibopt.solve.solve import solve

few = settings(derandomize=True, database=None, deadline=None, max_examples=6)
HOST, SPRING, DAMPER, DENSITY = 100.0, 4e5, 100.0, 1.0 / (2.0 * np.pi)
FREE = {
    "mass": {"from": "1 kg", "to": "5 kg"},
    "frequency": {"from": "5 Hz", "to": "20 Hz"},
    "damping_ratio": {"from": 0.01, "to": 0.9},
}


def scene(count: int = 1, *, goal: str = "rms_displacement", on_base: bool = False, **own: Any) -> dict[str, Any]:
    """An absorber at the end of a chain of `count` bodies under white noise on the first of them, or on its base."""
    foot = "floor" if on_base else "ground"
    noise = {"on": "floor", "density": "0.01 (m/s²)²/Hz"} if on_base else {"on": "b0", "density": "1 N²/Hz"}
    links = {
        f"l{i}": {
            "between": [f"b{i}", f"b{i - 1}" if i else foot],
            "stiffness": f"{SPRING} N/m",
            "damping": f"{DAMPER} N s/m",
        }
        for i in range(count)
    }
    return {
        "title": "t",
        "bodies": {f"b{i}": {"mass": f"{HOST} kg"} for i in range(count)},
        **({"bases": {"floor": {}}} if on_base else {}),
        "links": links,
        "absorbers": {"a": {"on": f"b{count - 1}", **FREE, **own}},
        "excitations": {"e": {"kind": "white_noise", **noise}},
        "goal": {"minimise": goal, "across" if "relative" in goal else "of": "l0" if "relative" in goal else "b0"},
    }


def posed(document: dict[str, Any]) -> Program:
    return closed(pose(from_dict(document)))


def by_states(count: int, mass: float, w: float, zeta: float) -> float:
    """Root mean square of the first body's motion [m] by the sum over all poles of its response, residue by residue."""
    size = count + 1
    m, c, k = np.diag([HOST] * count + [mass]), np.zeros((size, size)), np.zeros((size, size))
    links = [(i, i - 1, SPRING, DAMPER) for i in range(count)] + [
        (count, count - 1, mass * w * w, 2.0 * zeta * mass * w)
    ]
    for i, j, spring, damper in links:
        way = np.eye(size)[i] - (np.eye(size)[j] if j >= 0 else 0.0)
        k, c = k + spring * np.outer(way, way), c + damper * np.outer(way, way)
    a = np.block([[np.zeros((size, size)), np.eye(size)], [-np.linalg.solve(m, k), -np.linalg.solve(m, c)]])
    rates, shapes = np.linalg.eig(a)
    load = np.linalg.solve(shapes, np.concatenate([np.zeros(size), np.linalg.solve(m, np.eye(size)[0])]))
    parts = shapes[0] * load
    square = -(parts[:, None] * parts / (rates[:, None] + rates)).sum().real
    return float(np.sqrt(np.pi * DENSITY * square))


@few
@given(st.integers(1, 3), st.booleans(), st.sampled_from([1e-6, 0.03, 0.3]), st.integers(0, 999))
def test_no_mean_square_on_a_box_passes_its_bounds(count: int, given_mass: bool, wide: float, seed: int) -> None:
    """On boxes of next to no size they are the value itself."""
    program, rng = posed(scene(count, **({"mass": "4 kg"} if given_mass else {}))), np.random.default_rng(seed)
    assert program.aim is not None
    bounds = FormBounds(program.aim.model, program.aim.form, np.sqrt(program.low * program.high))
    assert bounds.bounded
    size = (program.high / program.low) ** wide
    low = program.low * (program.high / program.low) ** (rng.random((20, len(size))) * (1.0 - wide))
    least, most = bounds.on(low, low * size)
    for box in range(20):
        for part in rng.random((6, len(size))):
            x = low[box] * size**part
            value = by_states(count, *(x if len(x) == 3 else (4.0, *x)))
            assert (1.0 - 1e-9) * least[box] <= value <= (1.0 + 1e-9) * most[box]
            assert wide > 1e-3 or most[box] < value * (1.0 + 2e-4)


@few
@given(st.integers(1, 3), st.sampled_from([1.0, 1e-6, 1e-12]), st.integers(0, 999))
def test_many_designs_at_once_are_each_by_itself(count: int, damped: float, seed: int) -> None:
    """Where damping is next to nothing rounding would decide, and they are measured one by one."""
    free = {"damping_ratio": {"from": 0.01 * damped, "to": 0.9 * damped}}
    document, rng = scene(count, **free), np.random.default_rng(seed)
    for link in document["links"].values():
        link["damping"] = f"{DAMPER * damped} N s/m"
    program = posed(document)
    assert program.aim is not None
    form, model = program.aim.form, program.aim.model
    x = program.low * (program.high / program.low) ** rng.random((40, 3))
    assert form.values(model, x) == pytest.approx([form.value(model, one) for one in x], rel=1e-9)
    assert isinstance(form, RootMeanSquare)
    together = at_designs(form, model, x)
    assert np.isfinite(together).all() or damped < 1.0
    assert not np.isfinite(together).all() or damped > 1e-9


@pytest.mark.parametrize("count", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_the_least_mean_square_is_proven(count: int) -> None:
    """By boxes of all three numbers of an absorber; a search of another kind finds nothing less."""
    found = solve(from_dict(scene(count)), explain=False)
    assert (found.status, found.method) == ("optimal", "branch_and_bound")
    assert found.goal is not None
    ends = [(np.log(1.0), np.log(5.0)), (np.log(10.0 * np.pi), np.log(40.0 * np.pi)), (np.log(0.01), np.log(0.9))]
    other = differential_evolution(lambda y: by_states(count, *np.exp(y)), ends, seed=1, tol=1e-12, maxiter=60)
    assert found.goal[1].value <= other.fun * (1.0 + 1e-7)
    assert found.goal[1].value == pytest.approx(other.fun, rel=1e-4)


@pytest.mark.parametrize(
    ("goal", "response"),
    [
        ({"minimise": "rms_velocity", "of": "b0"}, "motion"),
        ({"minimise": "rms_force", "into": "ground"}, "force"),
        ({"minimise": "rms_force", "through": "a"}, "share"),
        ({"minimise": "rms_force", "through": "l1"}, "shares"),
        ({"minimise": "rms_acceleration", "of": "b0"}, "floor"),
        ({"minimise": "rms_relative_displacement", "across": "a"}, "floor"),
        ({"minimise": "rms_displacement", "of": "b0"}, "drift"),
    ],
)
def test_forces_and_bases_are_bounded_too(goal: dict[str, str], response: str) -> None:
    """Against the equation of Lyapunov, which is the form's own value, on small boxes."""
    document = scene(2, on_base=response in ("floor", "drift")) | {"goal": goal}
    if response == "drift":
        document["excitations"]["e"]["density"] = "1e-6 m²/Hz"
    if response == "shares":
        document["absorbers"]["a"]["mass"] = "4 kg"
        document["links"]["l1"] |= {"stiffness": "100 kN/m", "count": {"from": 2, "to": 6, "whole": True}}
    program, rng = posed(document), np.random.default_rng(3)
    assert program.aim is not None
    form, model = program.aim.form, program.aim.model
    bounds = FormBounds(model, form, np.sqrt(program.low * program.high))
    low = program.low * (program.high / program.low) ** (0.98 * rng.random((10, 3)))
    size = (program.high / program.low) ** 0.02
    least, most = bounds.on(low, low * size)
    for box in range(10):
        for part in rng.random((5, 3)):
            assert least[box] <= form.value(model, low[box] * size**part) <= most[box]
    assert np.median(most / least) < 1.1


def test_what_two_noises_move_is_bounded_and_what_is_too_large_says_so() -> None:
    document = scene()
    document["excitations"]["other"] = document["excitations"]["e"] | {"density": "3 N²/Hz"}
    found, one = (solve(from_dict(each), explain=False).goal for each in (document, scene()))
    assert found is not None
    assert one is not None
    assert found[1].value == pytest.approx(2.0 * one[1].value, rel=1e-9)
    large = solve(from_dict(scene(4, mass="4 kg")), explain=False)
    assert large.claim.endswith(
        "; no useful bound: the goal is a mean square under white noise "
        "of more than four coordinates or three numbers, or one that its boxes bound too loosely in the work allowed"
    )


def test_the_lightest_within_a_mean_square_is_proven_and_that_a_limit_is_out_of_reach() -> None:
    best = solve(from_dict(scene()), explain=False).goal
    assert best is not None
    for part, status in ((0.99, "infeasible"), (1.01, "optimal")):
        quiet = {"response": "rms_displacement", "of": "b0", "at_most": f"{part * best[1].value!r} m"}
        light = scene() | {"limits": {"quiet": quiet}, "goal": {"minimise": "absorber_mass"}}
        assert solve(from_dict(light), explain=False).status == status


@pytest.mark.parametrize(("rattle", "sag"), [(1e-3, 4e-3), (1e-3, None), (2e-4, 4e-3)])
def test_a_limit_at_its_bound_leaves_the_least_mean_square_proven(rattle: float, sag: float | None) -> None:
    """One mass on a shaken floor: with G the density, w and r = c / m, rattle**2 = G / (4 r w**2) at most and the mean
    square of acceleration is G (w**2 / r + r) / 4, w**2 at least g / sag."""
    g, density = 9.80665, 0.01
    limits = {"rattle": {"response": "rms_relative_displacement", "across": "pad", "at_most": f"{rattle!r} m"}}
    if sag is not None:
        limits["sag"] = {"response": "static_deflection", "of": "pad", "at_most": f"{sag!r} m"}
    document = {
        "title": "t",
        "bases": {"floor": {}},
        "bodies": {"cabinet": {"mass": "80 kg"}},
        "links": {
            "pad": {
                "between": ["cabinet", "floor"],
                "stiffness": {"from": "1 kN/m", "to": "10 MN/m"},
                "damping": {"from": "50 N s/m", "to": "20 kN s/m"},
            }
        },
        "excitations": {"floor": {"kind": "white_noise", "on": "floor", "density": f"{density} (m/s²)²/Hz"}},
        "limits": limits,
        "goal": {"minimise": "rms_acceleration", "of": "cabinet"},
    }
    found = solve(from_dict(document), explain=False)
    r = np.geomspace(1.0, 250.0, 2_000_001)
    stiff = np.maximum(density / (4.0 * r * rattle**2), 0.0 if sag is None else g / sag)
    assert found.status == "optimal"
    assert found.goal is not None
    assert found.goal[1].value == pytest.approx(np.sqrt(density * (stiff / r + r).min() / 4.0), rel=2e-6)


@pytest.mark.parametrize(("ratio", "status"), [("5 %", "optimal"), ("17 %", "feasible")])
def test_what_has_no_bounds_leaves_the_proof_where_it_does_not_count(ratio: str, status: str) -> None:
    """And a bound, for no design is better with one more limit."""
    free = {"frequency": {"from": "2 Hz", "to": "10 Hz"}, "damping_ratio": {"from": 0.01, "to": 1}}
    document = {
        "title": "t",
        "bodies": {"deck": {"mass": "100 kg"}},
        "links": {"girder": {"between": ["deck", "ground"], "stiffness": "100 kN/m"}},
        "absorbers": {"tmd": {"on": "deck", "mass": "10 kg", **free}},
        "excitations": {"wind": {"kind": "white_noise", "on": "deck", "density": "100 N²/Hz"}},
        "limits": {"decay": {"response": "damping_ratio", "mode": 2, "at_least": ratio}},
        "goal": {"minimise": "rms_displacement", "of": "deck"},
    }
    program = posed(document)
    found = BoxesFirst(Nlp(count=2, brief=True)).solve(program)
    assert found.status == status
    assert found.claim.endswith(", without limit decay, which has no bounds on boxes") == (status == "feasible")
    assert found.x is not None
    assert program.aim is not None
    del document["limits"]
    best = solve(from_dict(document), explain=False).goal
    assert best is not None
    assert found.bound <= best[1].value * (1.0 + 1e-6)
    assert program.aim.form.value(program.aim.model, found.x) >= best[1].value * (1.0 - 1e-6)
    assert program.limits[0].worst(found.x).value >= program.limits[0].bound * (1.0 - 1e-9)
