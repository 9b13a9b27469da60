"""Bounds on a box of designs hold at every design in it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from chain_machine import Chain, chains
from lone_mass import LoneMass, lone_masses
from test_chains import asked, read
from vibopt.forms.bounds import FormBounds
from vibopt.program.pose import pose
from vibopt.program.program import Program
from vibopt.scene.read import from_dict
from vibopt.solve.branch import first_speeds

few = settings(derandomize=True, database=None, deadline=None, max_examples=25, suppress_health_check=list(HealthCheck))
many = settings(few, max_examples=150)


def hold(program: Program, seed: int) -> None:
    """Random boxes, some of them tiny; random designs inside, corners among them."""
    rng = np.random.default_rng(seed)
    low, high = np.maximum(program.low, 1e-9 * program.high), program.high
    middle = np.sqrt(low * high)
    for part in (*program.limits, *([program.aim] if program.aim else [])):
        bounds = FormBounds(part.model, part.form, middle)
        if not bounds.bounded:
            continue
        for speeds in first_speeds(part.form):
            bounds.add(speeds)
        reach = np.array([1.0, 0.3, 1e-2, 1e-4])[:, None]
        centre = rng.uniform(size=(len(reach), len(low)))
        corners = [low * (high / low) ** np.clip(centre + side * reach / 2, 0, 1) for side in (-1, 1)]
        for a, b, below, above in zip(*corners, *bounds.on(*corners), strict=True):
            for _ in range(4):
                x = a * (b / a) ** rng.choice([rng.uniform(), 0.0, 1.0], len(a))
                most, fewest = (part.form.worst(part.model, x, least_wanted=least).value for least in (False, True))
                assert below <= most * (1 + 1e-9) + 1e-300, part.name
                assert above >= fewest * (1 - 1e-9), part.name


@given(case=lone_masses(wide=True), seed=st.integers(0, 2**32 - 1))
@few
def test_bounds_of_one_mass_hold(case: LoneMass, seed: int) -> None:
    hold(pose(from_dict(case.document)), seed)


@given(chain=chains(), seed=st.integers(0, 2**32 - 1))
@settings(few, max_examples=12)
def test_bounds_of_chains_hold(chain: Chain, seed: int) -> None:
    hold(pose(read(chain, some(chain, 5))), seed)


def some(chain: Chain, step: int) -> dict[str, Any]:
    """Each `step`-th of all possible limits."""
    return {name: words for name, (words, _, _) in list(asked(chain).items())[::step]}


@pytest.mark.slow
@given(case=lone_masses(wide=True), seed=st.integers(0, 2**32 - 1))
@many
def test_bounds_of_many_lone_masses_hold(case: LoneMass, seed: int) -> None:
    hold(pose(from_dict(case.document)), seed)


@pytest.mark.slow
@given(chain=chains(), seed=st.integers(0, 2**32 - 1))
@many
def test_bounds_of_many_chains_hold(chain: Chain, seed: int) -> None:
    hold(pose(read(chain, some(chain, 1))), seed)
