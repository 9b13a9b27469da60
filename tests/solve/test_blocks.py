"""Several absorbers: what holding variables means, and that no single link can be chosen better."""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from vibopt.program.held import held
from vibopt.program.pose import pose
from vibopt.program.program import Program
from vibopt.scene.read import from_dict
from vibopt.solve.branch import Judge
from vibopt.solve.link_by_link import improved_by_links, links_of
from vibopt.solve.local import improved
from vibopt.solve.ranges import closed
from vibopt.work import Budget


def two_absorbers(rng: np.random.Generator) -> Program:
    """A damped mass with two absorbers, their masses facts or variables, and a limit on one of their strokes."""
    absorbers: dict[str, Any] = {}
    for name in ("low", "high"):
        mass: Any = float(rng.uniform(0.01, 0.1)) if rng.random() < 0.5 else {"from": 0.01, "to": 0.1}
        absorbers[name] = {
            "on": "machine",
            "mass_ratio": mass,
            "tuning": {"from": 0.5, "to": 2.0},
            "damping_ratio": {"from": 0.005, "to": 1.0},
        }
    document = {
        "bodies": {"machine": {"mass": "100 kg"}},
        "links": {"spring": {"between": ["ground", "machine"], "stiffness": "100 kN/m", "damping_ratio": 0.01}},
        "absorbers": absorbers,
        "excitations": {
            "shake": {"kind": "force", "on": "machine", "amplitude": "1 kN", "speed": "10..60 rad/s"}
            | {"varies": "constant"}
        },
        "limits": {"travel": {"response": "stroke", "of": "low", "at_most": "400 mm"}},
        "goal": {"minimise": "displacement", "of": "machine"},
    }
    return closed(pose(from_dict(document)))


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_a_program_with_held_variables_has_the_values_of_the_whole(seed: int) -> None:
    rng = np.random.default_rng(seed)
    program = two_absorbers(rng)
    x = np.exp(rng.uniform(np.log(program.low), np.log(program.high)))
    free = sorted(rng.choice(len(x), size=2, replace=False).tolist())
    part, judge = held(program, x, free), Judge(program)
    small = Judge(part)
    assert [axis.path for axis in part.axes] == [program.axes[i].path for i in free]
    np.testing.assert_allclose(small.goal(x[free]).value, judge.goal(x).value, rtol=1e-12)
    for one, whole in zip(part.limits, program.limits, strict=True):
        np.testing.assert_allclose(small.limit(one, x[free])[0], judge.limit(whole, x)[0], rtol=1e-9, atol=1e-12)


@settings(max_examples=3, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_no_other_spring_and_damper_of_one_link_is_better(seed: int) -> None:
    rng = np.random.default_rng(seed)
    program = two_absorbers(rng)
    judge = Judge(program)
    tried = np.exp(rng.uniform(np.log(program.low), np.log(program.high), (200, len(program.axes))))
    start = next(x for x in tried if judge.feasible(x))
    x, settled = improved_by_links(program, start, judge, Budget(1000, "looks"))
    value = judge.goal(x).value
    assert settled
    assert judge.feasible(x)
    assert value <= judge.goal(start).value
    for pair in links_of(program, x):
        for _ in range(40):
            there = x.copy()
            near = x[list(pair)] * np.exp(rng.normal(size=2) * 10 ** rng.uniform(-4, 0))
            there[list(pair)] = np.clip(near, program.low[list(pair)], program.high[list(pair)])
            if judge.feasible(there):
                assert judge.goal(there).value >= value * (1.0 - 3e-6)


STOREYS, CARRIED = (156.0, 73.5), (0, 0, 1, 1)
"""Masses [kg], and which of them each absorber is on."""
MASSES = ((0.116, 4.64), (0.186, 7.44), (0.0856, 3.42), (0.164, 6.56))
SPRINGS = ((13.7, 3890.0), (22.8, 9690.0), (13.3, 2310.0), (40.2, 8180.0))
DAMPERS = ((0.186, 24.3), (0.391, 38.6), (0.165, 24.0), (0.2, 80.0))
STILL, STROKE = 1.742e-3, 25.28e-3
LOCAL = (0.116, 3889.999505510659, 24.29960427202638, 0.186, 9689.99966732853, 38.599911816701685)
LOCAL += (3.42, 1228.0451121165922, 2.562381729209087, 3.097915658689591, 989.3907528702687, 1.9930)
"""An optimum of mass, spring and damper of each beside which there is no lighter one."""


def light_absorbers() -> Program:
    def row(ends: tuple[float, float], unit: str) -> dict[str, str]:
        return {"from": f"{ends[0]} {unit}", "to": f"{ends[1]} {unit}"}

    sizes = zip(CARRIED, MASSES, SPRINGS, DAMPERS, strict=True)
    document: dict[str, Any] = {
        "bodies": {"low": {"mass": "156 kg"}, "top": {"mass": "73.5 kg"}},
        "links": {
            "stand": {"between": ["low", "ground"], "stiffness": "214 kN/m", "damping": "126 N s/m"},
            "upper": {"between": ["top", "low"], "stiffness": "28.8 kN/m", "damping": "12.5 N s/m"},
        },
        "absorbers": {
            f"a{i}": {"on": ("low", "top")[on], "mass": row(m, "kg")}
            | {"stiffness": row(k, "N/m"), "damping": row(c, "N s/m")}
            for i, (on, m, k, c) in enumerate(sizes)
        },
        "excitations": {
            "e": {"kind": "force", "on": "low", "amplitude": "200 N", "speed": "2.756..3.122 Hz", "varies": "constant"}
        },
        "limits": {
            "travel": {"response": "stroke", "of": "a2", "at_most": f"{STROKE} m"},
            "still": {"response": "displacement", "of": "top", "at_most": f"{STILL} m"},
        },
        "goal": {"minimise": "absorber_mass"},
    }
    return closed(pose(from_dict(document)))


def moved(x: np.ndarray) -> tuple[float, float]:
    """Greatest motion of the upper mass and stroke of the third absorber on a grid, by matrices of their own [m]."""
    masses, springs, dampers = x.reshape(-1, 3).T
    rows = [(-1, 0, 214e3, 126.0), (0, 1, 28.8e3, 12.5)]
    rows += [(CARRIED[i], 2 + i, springs[i], dampers[i]) for i in range(4)]
    stiff, damped = np.zeros((6, 6)), np.zeros((6, 6))
    for one, other, k, c in rows:
        turn = np.zeros(6)
        turn[other] = 1.0
        if one >= 0:
            turn[one] = -1.0
        stiff, damped = stiff + k * np.outer(turn, turn), damped + c * np.outer(turn, turn)
    w = 2.0 * np.pi * np.linspace(2.756, 3.122, 2001)[:, None, None]
    load = np.array([200.0, 0, 0, 0, 0, 0])[None, :, None]
    motion = np.linalg.solve(stiff + 1j * w * damped - w**2 * np.diag([*STOREYS, *masses]), load)[..., 0]
    return float(np.abs(motion[:, 1]).max()), float(np.abs(motion[:, 4] - motion[:, 1]).max())


def test_a_link_that_leaves_room_in_a_limit_saves_mass() -> None:
    """No spring and damper changes the mass; those of one absorber chosen anew let another be lighter."""
    program = light_absorbers()
    judge = Judge(program, 1e-9)
    start = improved(program, np.array(LOCAL), judge)
    before = judge.goal(start).value
    x, _ = improved_by_links(program, start, judge, Budget(1000, "looks"))
    assert judge.goal(x).value == sum(x[::3]) < before * (1.0 - 1e-3)
    still, stroke = moved(x)
    assert still <= STILL * (1.0 + 1e-8)
    assert stroke <= STROKE * (1.0 + 1e-8)
    assert moved(start)[0] > 0.999 * STILL, "there was no room before"
