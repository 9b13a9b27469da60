"""What is claimed of one mass on one link: thousands of sampled designs, by the textbook, say nothing against it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings

from lone_mass import PATHS, LoneMass, lone_masses
from vibopt.scene.read import from_dict
from vibopt.scene.scene import Design
from vibopt.solve import solve

GAP = 1.1e-6
"""Claimed gap of a proven optimum, with a little for rounding."""

few = settings(derandomize=True, database=None, deadline=None, max_examples=25, suppress_health_check=list(HealthCheck))
many = settings(few, max_examples=100)


def chosen(case: LoneMass, design: Design) -> dict[str, float] | None:
    """The chosen values and the facts by name; None where there is no design."""
    if not design.variables:
        return None
    values = {name: design.variables[PATHS.get(name, f"links.link.{name}")].value.value for name in case.ranges}
    return {**case.facts, **values}


def judge(case: LoneMass) -> None:
    """Solve, and hold every word of the answer against the textbook."""
    design = solve(from_dict(case.document), explain=False)
    assert design.status in ("optimal", "feasible", "infeasible", "unproven"), design.claim
    rng = np.random.default_rng(1)
    x = chosen(case, design)
    if x is None:
        assert design.status in ("infeasible", "unproven")
        miss, _ = case.best(rng, None, 2000)
        assert design.status != "infeasible" or miss > 0.0, "a design exists"
        return
    here = {name: np.array([value]) for name, value in x.items()}
    assert float(case.missed(here)[0]) <= 2e-9, "the design breaks a limit"
    goal, told = float(case.aim(here)[0]), design.goal[1].value
    assert told == pytest.approx(goal if case.goal[0] == "minimise" else -goal, rel=1e-8)
    if design.status == "optimal":
        miss, best = case.best(rng, x, 2000)
        least = goal - GAP * abs(goal) if np.isfinite(goal) else goal
        assert miss > 0.0 or best >= least, "a better design exists"


@given(case=lone_masses())
@few
def test_no_sampled_design_beats_a_claim(case: LoneMass) -> None:
    judge(case)


@pytest.mark.slow
@given(case=lone_masses())
@many
def test_no_sampled_design_beats_a_claim_in_many_scenes(case: LoneMass) -> None:
    judge(case)


@pytest.mark.slow
@given(case=lone_masses(wide=True))
@many
def test_no_sampled_design_beats_a_claim_over_wide_ranges(case: LoneMass) -> None:
    judge(case)
