"""Joints without mass: Zener's closed forms, the limit of tiny masses, both routes, slopes, proofs, words."""

from __future__ import annotations

import copy
import itertools
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import vibopt as vo
from refusals import refused
from vibopt.errors import InputError
from vibopt.mechanics.modes import characteristic, poles
from vibopt.program.pose import pose

few = settings(derandomize=True, database=None, deadline=None, max_examples=8)
MASS, STIFFNESS = 100.0, 1e6

ZENER: dict[str, Any] = {
    "title": "elastically held damper",
    "bodies": {"machine": {"mass": "100 kg"}, "joint": {"mass": "0 kg"}},
    "bases": {"floor": {}},
    "links": {
        "main": {"between": ["machine", "floor"], "stiffness": "1 MN/m"},
        "damper": {"between": ["machine", "joint"], "damping": {"from": "10 N s/m", "to": "1 MN s/m"}},
        "held": {"between": ["joint", "floor"], "stiffness": "3 MN/m"},
    },
    "excitations": {
        "shake": {
            "kind": "base_motion", "on": "floor", "displacement": "1 mm", "speed": "1..300 Hz", "varies": "constant"
        }
    },
    "goal": {"minimise": "transmissibility", "of": "machine"},
}  # fmt: skip


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("ratio", [0.4, 1.0, 3.0, 12.0])
def test_the_best_elastically_held_damper_is_that_of_the_fixed_point(ratio: float, turned: bool) -> None:
    """Without damping and with a rigid damper the curves cross at u^2 = 2 (N + 1) / (N + 2), at the height 1 + 2 / N.

    There the best damping has its peak: N sqrt(2 (N + 2)) / (4 (N + 1)) of critical; spring and damper in any order.
    """
    document = copy.deepcopy(ZENER)
    document["links"]["held"]["stiffness"] = f"{ratio * STIFFNESS!r} N/m"
    if turned:
        document["links"]["damper"]["between"], document["links"]["held"]["between"] = (
            ["joint", "floor"],
            ["machine", "joint"],
        )
    answer = vo.solve(vo.from_dict(document))
    assert answer.status == "optimal", answer.claim
    assert answer.goal[1].value == pytest.approx(1.0 + 2.0 / ratio, rel=2e-6)
    best = ratio * np.sqrt(2.0 * (ratio + 2.0)) / (4.0 * (ratio + 1.0)) * 2.0 * np.sqrt(STIFFNESS * MASS)
    assert answer.x[0] == pytest.approx(best, rel=1e-9)


def test_the_record_of_the_elastically_held_damper() -> None:
    """Ruzicka and Derby's optimum, and the force of spring and damper in a row."""
    file = Path(__file__).parents[2] / "problems/isolation/elastically_held_damper.toml"
    rows = {one["path"]: one["value"] for one in tomllib.loads(file.read_text(encoding="utf-8"))["expected"]}
    ratio, omega = 3.0, 200.0 * np.pi
    damping = ratio * np.sqrt(2.0 * (ratio + 2.0)) / (4.0 * (ratio + 1.0)) * 2.0 * np.sqrt(STIFFNESS * MASS)
    assert rows["goal"] == pytest.approx(1.0 + 2.0 / ratio, rel=1e-7)
    assert float(rows["variables.links.damper.damping"].split()[0]) == pytest.approx(damping, rel=1e-7)
    mount = STIFFNESS + 1.0 / (1.0 / (ratio * STIFFNESS) + 1.0 / (1j * omega * damping))
    assert rows["measures.running.value"] == pytest.approx(abs(mount / (mount - MASS * omega**2)), rel=1e-7)
    u, on_floor = np.linspace(0.1, 1.5, 20_001), 2.0j * 0.395  # the damper on the floor of the same peak
    assert np.abs((1.0 + on_floor * u) / (1.0 + on_floor * u - u**2)).max() == pytest.approx(rows["goal"], rel=1e-3)
    fast = omega / np.sqrt(STIFFNESS / MASS)
    other = abs((1.0 + on_floor * fast) / (1.0 + on_floor * fast - fast**2))
    assert other == pytest.approx(1.25 * rows["measures.running.value"], rel=0.01)
    assert float(rows["measures.mode.value"].split()[0]) == pytest.approx(np.sqrt(STIFFNESS / MASS) / (2.0 * np.pi))


def machine(rng: np.random.Generator, light: str) -> dict[str, Any]:
    """One or two bodies over a floor, with joints of mass `light` in some of the links between them."""
    count = int(rng.integers(1, 3))
    bodies = {f"m{i}": {"mass": f"{10.0 ** rng.uniform(0, 1)!r} kg"} for i in range(count)}
    links: dict[str, Any] = {}
    for i in range(count):
        under = f"m{i - 1}" if i else "floor"
        stiff = [f"{10.0 ** rng.uniform(3.5, 4.5)!r} N/m" for _ in range(3)]
        damped = [f"{10.0 ** rng.uniform(1, 2.3)!r} N s/m" for _ in range(2)]
        links[f"k{i}"] = {"between": [f"m{i}", under], "stiffness": stiff[0]}
        if i == 0 or rng.random() < 0.6:
            bodies[f"j{i}"] = {"mass": light}
            ends = [[f"m{i}", f"j{i}"], [f"j{i}", under]]
            ends = ends if rng.random() < 0.5 else ends[::-1]
            links[f"c{i}"] = {"between": ends[0], "damping": damped[0]}
            links[f"e{i}"] = {"between": ends[1], "stiffness": stiff[1]}
            if rng.random() < 0.5:
                links[f"e{i}"]["damping"] = damped[1]
        else:
            links[f"c{i}"] = {"between": [f"m{i}", under], "damping": damped[0]}
        if rng.random() < 0.4:
            bodies[f"q{i}"] = {"mass": light}
            links[f"k{i}"]["between"] = [f"m{i}", f"q{i}"]
            links[f"s{i}"] = {"between": [f"q{i}", under], "stiffness": stiff[2]}
    return {"title": "joints", "bodies": bodies, "bases": {"floor": {}}, "links": links}


SHAKEN: dict[str, dict[str, Any]] = {
    "shake": {"kind": "base_motion", "on": "floor", "displacement": "1 mm", "speed": "1..100 Hz", "varies": "constant"},
    "push": {"kind": "force", "on": "j0", "amplitude": "1 N", "speed": "3..60 Hz", "varies": "constant"},
    "noise": {"kind": "white_noise", "on": "m0", "density": "1 N²/Hz"},
    "rough": {"kind": "white_noise", "on": "floor", "density": "1 (m/s²)²/Hz"},
    "road": {"kind": "white_noise", "on": "floor", "density": "1 mm²/Hz"},
    "bump": {"kind": "pulse", "on": "floor", "shape": "half sine", "acceleration": "5 m/s²", "duration": "30 ms"},
    "kick": {"kind": "pulse", "on": "j0", "shape": "triangle", "amplitude": "5 N", "duration": "50 ms"},
    "drop": {"kind": "drop", "on": "floor", "velocity_change": "1 m/s"},
    "run": {
        "kind": "force", "on": "m0", "amplitude": "1 N", "speed": "30 Hz", "varies": "speed^2",
        "run_up": {"duration": "1 s"},
    },
}  # fmt: skip
STEADY = {
    "ratio": {"response": "transmissibility", "of": "m0", "due_to": ["shake"]},
    "joint": {"response": "velocity", "of": "j0", "due_to": ["push"]},
    "floor": {"response": "transmitted_force", "into": "floor", "due_to": ["push"]},
    "damper": {"response": "transmitted_force", "through": "c0", "due_to": ["shake"]},
    "mode": {"response": "natural_frequency"},
    "sag": {"response": "static_deflection", "of": "m0"},
}
IN_TIME = {
    "free": {"response": "damping_ratio"},
    "decay": {"response": "decay_rate"},
    "noise": {"response": "rms_displacement", "of": "j0", "due_to": ["noise"]},
    "noisy": {"response": "rms_force", "through": "c0", "due_to": ["noise"]},
    "rough": {"response": "rms_acceleration", "of": "m0", "due_to": ["rough"]},
    "travel": {"response": "rms_relative_displacement", "across": "e0", "due_to": ["rough"]},
    "road": {"response": "rms_displacement", "of": "m0", "due_to": ["road"]},
    "bump": {"response": "peak_acceleration", "of": "m0", "due_to": ["bump"]},
    "stroke": {"response": "peak_relative_displacement", "across": "c0", "due_to": ["bump"]},
    "kick": {"response": "peak_velocity", "of": "j0", "due_to": ["kick"]},
    "drop": {"response": "peak_force", "through": "e0", "due_to": ["drop"]},
    "dropped": {"response": "peak_velocity", "of": "j0", "due_to": ["drop"]},
    "run": {"response": "peak_displacement", "of": "j0", "due_to": ["run"]},
    "ran": {"response": "peak_force", "into": "floor", "due_to": ["run"]},
}


def told(document: dict[str, Any], measures: dict[str, Any]) -> dict[str, float]:
    """Values of measures; both routes agree on them."""
    names = {name for one in measures.values() for name in one.get("due_to", ())}
    some = {name: one for name, one in SHAKEN.items() if name in names}
    answer = vo.solve(vo.from_dict({**document, "excitations": some, "measures": measures}))
    assert answer.status == "met", answer.claim
    return {name: one.value.value for name, one in answer.measures.items()}


@few
@given(seed=st.integers(0, 100_000))
def test_every_joint_is_the_limit_of_a_tiny_mass(seed: int) -> None:
    still, tiny = (told(machine(np.random.default_rng(seed), mass), STEADY) for mass in ("0 kg", "1e-9 kg"))
    assert still == pytest.approx(tiny, rel=2e-5)


@few
@given(seed=st.integers(0, 100_000))
def test_noise_loads_and_run_ups_have_one_value_by_both_routes(seed: int) -> None:
    found = told(machine(np.random.default_rng(seed), "0 kg"), IN_TIME)
    assert all(0.0 < one < np.inf for one in found.values()), found


@pytest.mark.parametrize("shape", ["rectangle", "half sine"])
def test_a_zener_mount_under_a_pulse_is_that_of_its_equation_of_force(shape: str) -> None:
    """m x'' + k x + f = p and f' = n k (x' - f / c), by a Runge-Kutta method, from turn to turn of the pulse."""
    m, k, c, n, size, length = 10.0, 4e4, 500.0, 3.0, 200.0, 0.05
    document = {
        "title": "Zener",
        "bodies": {"m": {"mass": f"{m} kg"}, "j": {"mass": "0 kg"}},
        "links": {
            "main": {"between": ["m", "ground"], "stiffness": f"{k} N/m"},
            "damper": {"between": ["j", "ground"], "damping": f"{c} N s/m"},
            "held": {"between": ["m", "j"], "stiffness": f"{n * k} N/m"},
        },
        "excitations": {
            "p": {"kind": "pulse", "on": "m", "shape": shape, "amplitude": f"{size} N", "duration": f"{length} s"}
        },
        "measures": {
            "x": {"response": "peak_displacement", "of": "m"},
            "f": {"response": "peak_force", "through": "held"},
        },
    }
    answer = vo.solve(vo.from_dict(document))
    push = {"rectangle": lambda t: size, "half sine": lambda t: size * np.sin(np.pi * t / length)}[shape]

    def rates(t: float, z: Any) -> Any:
        return [z[1], ((push(t) if t <= length else 0.0) - k * z[0] - z[2]) / m, n * k * (z[1] - z[2] / c)]

    state, most = [0.0, 0.0, 0.0], np.zeros(2)
    for low, high in ((0.0, length), (length * (1.0 + 1e-15), 0.5)):
        run: Any = solve_ivp(rates, (low, high), state, method="DOP853", rtol=1e-12, atol=1e-14, dense_output=True)
        state = run.y[:, -1]
        most = np.maximum(most, np.abs(run.sol(np.linspace(low, high, 40_001))[[0, 2]]).max(axis=1))
    assert answer.status == "met"
    assert [answer.measures[one].value.value for one in "xf"] == pytest.approx(most, rel=1e-7)


@few
@given(seed=st.integers(0, 100_000))
def test_poles_are_the_roots_of_the_determinant(seed: int) -> None:
    document = machine(np.random.default_rng(seed), "0 kg")
    scene = vo.from_dict({**document, "measures": {"mode": {"response": "natural_frequency"}}})
    model = pose(scene).model
    p = model.values(np.ones(0))
    mass, stiffness, damping = (model.matrix(kind, p)[: model.n_free, : model.n_free] for kind in range(3))
    found = 1j * poles(model, p)
    size = np.sqrt(
        np.diag(stiffness) + np.abs(found[:, None]) * np.diag(damping) + np.abs(found[:, None]) ** 2 * np.diag(mass)
    )
    for s, scale in zip(found, size, strict=True):
        dynamic = (s**2 * mass + s * damping + stiffness) / np.outer(scale, scale)
        assert np.linalg.svd(dynamic, compute_uv=False)[-1] < 1e-9
    light = int((np.diag(mass) == 0.0).sum())
    slow = int(((np.diag(mass) == 0.0) & (np.diag(damping) > 0.0)).sum())
    assert len(found) == 2 * (model.n_free - light) + slow
    row = characteristic(model, p, float(np.abs(found).max()))
    assert len(row) == len(found) + 1
    assert row[-1] == 1.0
    assert characteristic(model, np.array([[p], [p]]), float(np.abs(found).max())) == pytest.approx(
        np.array([[row], [row]]), rel=1e-9, abs=1e-12 * np.abs(row).max()
    )


OPEN: dict[str, Any] = {
    **ZENER,
    "links": {
        "main": {"between": ["machine", "floor"], "stiffness": {"from": "10 kN/m", "to": "1 MN/m"}},
        "damper": ZENER["links"]["damper"],
        "held": {"between": ["joint", "floor"], "stiffness": {"from": "10 kN/m", "to": "3 MN/m"}},
    },
}
GOALS: dict[str, tuple[dict[str, str], str]] = {
    "steady": ({"minimise": "transmissibility", "of": "machine"}, "shake"),
    "mode": ({"maximise": "natural_frequency"}, "shake"),
    "damping": ({"maximise": "damping_ratio"}, "shake"),
    "decay": ({"maximise": "decay_rate"}, "shake"),
    "rough": ({"minimise": "rms_acceleration", "of": "machine"}, "rough"),
    "road": ({"minimise": "rms_displacement", "of": "machine"}, "road"),
    "bump": ({"minimise": "peak_acceleration", "of": "machine"}, "bump"),
    "drop": ({"minimise": "peak_force", "through": "held"}, "drop"),
    "run": ({"minimise": "peak_force", "into": "floor"}, "run"),
}


def aimed(name: str, document: dict[str, Any]) -> dict[str, Any]:
    goal, shaken = GOALS[name]
    shaker = {**SHAKEN[shaken], "on": "machine"} if shaken == "run" else SHAKEN[shaken]
    return {**document, "excitations": {shaken: shaker}, "goal": goal}


@pytest.mark.parametrize("name", GOALS)
def test_slopes_are_those_of_differences(name: str) -> None:
    aim = pose(vo.from_dict(aimed(name, OPEN))).aim
    assert aim is not None
    for x in ([3e5, 8e3, 8e5], [2e4, 2e3, 1.1e4]):
        near = [np.array(x) * np.exp(1e-5 * sign * turn) for turn in np.eye(3) for sign in (1.0, -1.0)]
        logs = [np.log(aim.form.worst(aim.model, one, least_wanted=aim.sense < 0).value) for one in near]
        differences = [(up - down) / 2e-5 for up, down in zip(logs[::2], logs[1::2], strict=True)]
        [slope, *_] = [one.slope for one in aim.form.extremes(aim.model, np.array(x), least_wanted=aim.sense < 0)]
        assert slope == pytest.approx(differences, abs=2e-6)


TWO: dict[str, Any] = {**OPEN, "links": {**OPEN["links"], "held": ZENER["links"]["held"]}}


@pytest.mark.sampled(2)
@pytest.mark.parametrize("name", ["steady", "mode", "damping", "decay", "rough", "run"])
def test_no_grid_of_designs_beats_what_is_proven(name: str) -> None:
    """Of main spring and damper, or of the damper alone."""
    document = aimed(name, TWO)
    if name != "steady":
        document["links"] = {**TWO["links"], "main": {"between": ["machine", "floor"], "stiffness": "200 kN/m"}}
    if name == "run":
        open_one = {"damping": {"from": "300 N s/m", "to": "30 kN s/m"}}
        document["links"] = {**document["links"], "damper": {**TWO["links"]["damper"], **open_one}}
    answer = vo.solve(vo.from_dict(document))
    assert answer.status in ("optimal", "feasible"), answer.claim
    program = pose(vo.from_dict(document))
    aim, points = program.aim, 40 if name == "run" or len(program.axes) > 1 else 400
    assert aim is not None
    grids = [np.geomspace(max(axis.low, 1.0), axis.high, points) for axis in program.axes]
    every = np.array(list(itertools.product(*grids)))
    values = [aim.form.worst(aim.model, one, least_wanted=aim.sense < 0).value for one in every]
    best = max(values) if aim.sense < 0 else min(values)
    assert aim.sense * (answer.goal[1].value - best) <= 2e-6 * abs(best)


@pytest.mark.slow
def test_no_grid_beats_a_proven_mount_under_a_pulse() -> None:
    document = aimed("bump", TWO)
    document["limits"] = {"room": {"response": "peak_relative_displacement", "across": "main", "at_most": "3 mm"}}
    document["excitations"]["bump"] = {**SHAKEN["bump"], "acceleration": "50 m/s²", "duration": "20 ms"}
    answer = vo.solve(vo.from_dict(document))
    assert answer.status == "optimal", answer.claim
    program = pose(vo.from_dict(document))
    [limit], aim = program.limits, program.aim
    assert aim is not None
    grids = [np.geomspace(axis.low, axis.high, 60) for axis in program.axes]
    best = min(
        aim.form.value(aim.model, np.array(one))
        for one in itertools.product(*grids)
        if limit.form.value(limit.model, np.array(one)) <= limit.bound
    )
    assert answer.goal[1].value <= best * (1.0 + 2e-6)


def changed(**changes: Any) -> dict[str, Any]:
    return {**ZENER, **changes}


def links(**changes: Any) -> dict[str, Any]:
    return {"links": {**ZENER["links"], **changes}}


MORE = {**ZENER["bodies"], "knee": {"mass": "0 kg"}}
WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "dampers in a row": (
        links(held={"between": ["joint", "floor"], "damping": "1 kN s/m"}),
        "bodies.joint has no mass, and no spring holds it, so that it drifts under any steady force. Of dampers in a "
        "row write one: 1/c = 1/c1 + 1/c2.",
    ),
    "a loose end": (
        {"links": {"main": {**ZENER["links"]["main"], "damping": "1 kN s/m"}, "held": ZENER["links"]["held"]}},
        "bodies.joint has no mass, and only held ends at it, which so carries nothing. Join a second link to it, or "
        "leave both out.",
    ),
    "nothing at it": (
        {"links": {"main": {**ZENER["links"]["main"], "damping": "1 kN s/m"}}},
        "bodies.joint has no mass, and nothing holds it. Join links with stiffness and damping to it, or leave it out.",
    ),
    "springs on both sides of a damper": (
        {
            "bodies": MORE,
            **links(
                damper={"between": ["knee", "joint"], "damping": "1 kN s/m"},
                upper={"between": ["machine", "knee"], "stiffness": "2 MN/m"},
            ),
        },
        "bodies.joint has no mass, and a damper joins it to knee, which has none either, with springs alone on both "
        "sides. Springs and a damper in a row act in any order: put the springs in a row, as 1/k = 1/k1 + 1/k2, and "
        "leave one joint out.",
    ),
    "nothing with mass": (
        {"bodies": {"machine": {"mass": "0 kg"}, "joint": {"mass": "0 kg"}}},
        'nothing has a mass, so that nothing vibrates. Give a body its mass: "300 kg".',
    ),
    "a ratio to nothing": (
        links(main={**ZENER["links"]["main"], "damping_ratio": 0.1, "relative_to": "joint"}),
        'links.main.relative_to = "joint" has no mass to which a ratio could refer. Name another body.',
    ),
    "an absorber on it": (
        {"absorbers": {"tmd": {"on": "joint", "mass": "3 kg", "stiffness": "1 kN/m", "damping": "3 N s/m"}}},
        'absorbers.tmd.on = "joint" has no mass: an absorber works against one. Name a body with mass, or write it as '
        "a body and a link.",
    ),
    "an unbalance on it": (
        {
            "excitations": {"shake": {"kind": "unbalance", "on": "joint", "unbalance": "1 kg m", "speed": "3000 rpm"}},
            "goal": {"minimise": "displacement", "of": "machine"},
        },
        "excitations.shake is an unbalance on joint, which has no mass. What turns there has one: give it, or write "
        'kind = "force".',
    ),
    "in space": (
        {"bodies": {**ZENER["bodies"], "joint": {"mass": "0 kg", "motion": "plane", "inertia": "1 kg m2"}}},
        "bodies.joint has no mass, and moves in more ways than one. A joint is of a line: remove motion, or give its "
        "mass.",
    ),
    "a tolerance": (
        {"bodies": {**ZENER["bodies"], "joint": {"mass": "0 kg", "tolerance": "5 %"}}},
        "bodies.joint has no mass that could be off. Remove the tolerance.",
    ),
    "a wheel": (
        {
            "bodies": {
                **ZENER["bodies"],
                "joint": {"mass": "0 kg", "rolling": {"inertia": "1 kg m2", "radius": "0.1 m"}},
            }
        },
        "bodies.joint has no mass and rolls. Give it its mass, or remove rolling.",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_what_cannot_be_is_said(name: str) -> None:
    changes, text = WRONG[name]
    assert text in str(refused(lambda: vo.solve(vo.from_dict(changed(**changes))))).replace("\n", " ")


SOFT = {
    "title": "springs in a row",
    "bodies": {"m": {"mass": "10 kg"}, "q": {"mass": "0 kg"}},
    "bases": {"floor": {}},
    "links": {
        "upper": {"between": ["m", "q"], "stiffness": "1 kN/m"},
        "lower": {"between": ["q", "floor"], "stiffness": "2 kN/m"},
        "damper": {"between": ["m", "ground"], "damping": "9 N s/m"},
    },
}
PUSHED: dict[str, tuple[dict[str, Any], dict[str, Any], str]] = {
    "a pulse": (
        {"kind": "pulse", "on": "q", "shape": "half sine", "amplitude": "5 N", "duration": "20 ms"},
        {"response": "peak_displacement", "of": "m"},
        "measures.x: excitations.e pushes q, which springs alone hold, so that it jumps with the force. Push a body "
        "with mass, or give it a damper.",
    ),
    "noise": (
        {"kind": "white_noise", "on": "q", "density": "1 N²/Hz"},
        {"response": "rms_displacement", "of": "m"},
        "measures.x: excitations.e pushes q, which springs alone hold, so that it jumps with the force.",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", PUSHED)
def test_what_pushes_a_joint_without_an_answer_is_said(name: str) -> None:
    excitation, measure, text = PUSHED[name]
    error = refused(
        lambda: vo.solve(vo.from_dict({**SOFT, "excitations": {"e": excitation}, "measures": {"x": measure}}))
    )
    assert text in str(error)


def test_a_motion_that_is_let_go_is_of_bodies_with_mass() -> None:
    asked = {
        "x": {"response": "free_displacement", "of": "m", "after": "1 s", "released": {"m": {"displacement": "1 mm"}}}
    }
    with pytest.raises(InputError, match="has no mass that would keep one"):
        vo.solve(vo.from_dict({**SOFT, "measures": asked}))


def test_the_acceleration_of_a_joint_that_is_pushed_is_refused() -> None:
    document = machine(np.random.default_rng(3), "0 kg")
    asked = {"x": {"response": "peak_acceleration", "of": "j0"}}
    with pytest.raises(InputError, match="has no mass: its acceleration follows the rate of the force"):
        vo.solve(vo.from_dict({**document, "excitations": {"kick": SHAKEN["kick"]}, "measures": asked}))


def test_a_mass_that_may_be_chosen_is_still_greater_than_zero() -> None:
    bodies = {**ZENER["bodies"], "joint": {"mass": {"one_of": ["0 kg", "1 kg"]}}}
    with pytest.raises(InputError, match="is not greater than zero"):
        vo.solve(vo.from_dict(changed(bodies=bodies)))


def test_programs_in_the_open_are_refused() -> None:
    with pytest.raises(InputError, match="has no mass, and programs take every body to have one"):
        vo.posed(vo.from_dict(aimed("mode", TWO))).cvxpy()


def test_a_joint_is_drawn_below_what_it_holds() -> None:
    """Floor, joint, machine; the main spring goes past the joint, and the sheet calls it one."""
    from vibopt.report.machine_parts import sketch_of
    from vibopt.report.sheet.machine_tables import body_rows
    from vibopt.report.sketch import levels
    from vibopt.verify.as_built import machine_of

    answer = vo.solve(vo.from_dict(ZENER))
    assert levels(sketch_of(answer)) == {"floor": 0, "joint": 1, "machine": 2}
    rows = dict(body_rows(answer.scene, machine_of(answer.scene, dict(zip(answer.variables, answer.x, strict=True)))))
    assert rows["joint"] == "joint without mass; moves along one line"


def test_a_joint_that_follows_what_no_spring_holds_passes_on_the_whole_torque() -> None:
    """Behind the joint is a body in water alone: 16 T / (pi d^3), for no balance of springs is left in the machine."""
    answer = vo.solve(vo.from_dict({
        "bodies": {"engine": {"inertia": "0 kg m2"}, "propeller": {"inertia": "2500 kg m2"}},
        "links": {
            "shaft": {"between": ["engine", "propeller"],
                      "shaft": {"length": "12 m", "diameter": "200 mm", "shear_modulus": "80 GPa"}},
            "water": {"between": ["propeller", "ground"], "torsional_damping": "30 kN m s/rad"},
        },
        "excitations": {"firing": {
            "kind": "moment", "on": "engine", "speed": "60..140 rpm", "varies": "constant", "amplitude": "60 kN m"}},
        "measures": {"stress": {"response": "shear_stress", "of": "shaft"}},
    }))  # fmt: skip
    assert answer.status == "met", answer.claim
    assert answer.measures["stress"].value.value == pytest.approx(16.0 * 60e3 / (np.pi * 0.2**3), rel=1e-12)


def at_high_frequency(document: dict[str, Any], s: float) -> dict[str, float]:
    """How far each body follows the floor at e^(s t), from m s^2 u = sum of (k + s c) (other - u)."""
    names = list(document["bodies"])
    whole = np.diag([float(one["mass"].split()[0]) * s**2 for one in document["bodies"].values()])
    load = np.zeros(len(names))
    for link in document["links"].values():
        stiff = sum(float(link.get(key, "0").split()[0]) * s**k for k, key in enumerate(("stiffness", "damping")))
        row = np.array([float(name == link["between"][0]) - float(name == link["between"][1]) for name in names])
        whole += stiff * np.outer(row, row)
        load += stiff * np.abs(row) * ("floor" in link["between"])
    return dict(zip(names, np.linalg.solve(whole, load), strict=True))


@pytest.mark.parametrize("seed", range(12))
def test_a_blow_accelerates_a_joint_without_end_where_it_follows_its_base_at_every_frequency(seed: int) -> None:
    document = machine(np.random.default_rng(400 + seed), "0 kg")
    document["excitations"] = {"drop": SHAKEN["drop"]}
    for name, part in at_high_frequency(document, 1e8).items():
        document["measures"] = {"a": {"response": "peak_acceleration", "of": name}}
        if part < 1e-3:
            assert np.isfinite(vo.solve(vo.from_dict(document)).measures["a"].value.value)
            continue
        with pytest.raises(InputError) as error:
            vo.solve(vo.from_dict(document))
        assert str(error.value) == (
            "scene: measures.a is infinite whatever the design: the blow of excitations.drop reaches "
            f"{name}, which has no mass, at once. Give it its mass, or ask for its peak_velocity."
        )


@pytest.mark.parametrize("tuned", [{"frequency": "5 Hz"}, {"tuning": 0.95}])
@pytest.mark.parametrize("ratio", [0.2, 2.0])
def test_a_joint_beside_a_machine_on_mounts_along_the_line_is_that_beside_one_on_links(
    tuned: dict[str, Any], ratio: float
) -> None:
    """Two mounts at their places under a body that moves along the line are one link of twice their stiffness."""
    two = {"stiffness": "0.9 MN/m", "damping": "2 kN s/m"}
    document: dict[str, Any] = {
        "bodies": {"pump": {"mass": "180 kg", "motion": "line"}, "floor": {"mass": "900 kg"}, "knee": {"mass": "0 kg"}},
        "links": {
            "spring": {"between": ["floor", "ground"], "stiffness": "1 MN/m"},
            "relax": {"between": ["floor", "knee"], "stiffness": f"{ratio!r} MN/m"},
            "pot": {"between": ["knee", "ground"], "damping": "4 kN s/m"},
        },
        "absorbers": {"tmd": {"on": "floor", "mass": "40 kg", "damping_ratio": 0.1, **tuned}},
        "excitations": {"f": {"kind": "force", "on": "floor", "amplitude": "100 N", "speed": "1..20 Hz"}},
        "measures": {
            "mode": {"response": "natural_frequency"},
            "least": {"response": "damping_ratio"},
            "moved": {"response": "displacement", "of": "floor"},
        },
    }
    placed, linked = copy.deepcopy(document), copy.deepcopy(document)
    placed["mounts"] = {
        "foot": {**two, "between": ["pump", "floor"], "shear_ratio": 0.5,
                 "at": [["0.6 m", "0.4 m", "0 m"], ["-0.6 m", "-0.4 m", "0 m"]]},
    }  # fmt: skip
    del linked["bodies"]["pump"]["motion"]
    linked["links"]["foot"] = {**two, "between": ["pump", "floor"], "count": 2}
    own, other = (vo.solve(vo.from_dict(one)) for one in (placed, linked))
    assert (own.status, other.status) == ("met", "met")
    for name in document["measures"]:
        assert own.measures[name].value.value == pytest.approx(other.measures[name].value.value, rel=1e-9), name
