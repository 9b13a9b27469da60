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
