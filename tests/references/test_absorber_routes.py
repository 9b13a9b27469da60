"""The second routes of the absorber problems against grids of designs."""

from typing import Any

import numpy as np
import pytest

from absorber_cases import BRIDGE, CASES, SKID, TOOL, Case, grid, refined, scaled


@pytest.mark.parametrize("case", [BRIDGE, TOOL], ids=["bridge", "tool"])
def test_the_region_found_does_not_depend_on_the_grid(case: Case) -> None:
    assert refined(case, grid(case, 16))[0] == pytest.approx(refined(case, grid(case))[0], rel=1e-7)


def test_no_lighter_pair_of_absorbers_lies_on_a_grid_of_the_skid() -> None:
    """Every design of a grid that holds the limits is heavier than the one found by evolution."""
    speeds, lightest = SKID.speeds(40), CASES["pump_skid_two_grids"]()["goal"]
    points = grid_of_six()
    found = scaled(SKID, points)
    light = found[:, found[0] + found[3] < lightest * (1 - 1e-6)]
    assert light.shape[1] > 10_000
    parts = (light[:, start : start + 2000] for start in range(0, light.shape[1], 2000))
    assert all(SKID.highest(part, speeds).min() > 1 for part in parts)


def grid_of_six() -> Any:
    """Numbers between 0 and 1 for both absorbers, the first with the lower frequency; little damping counts most."""

    mass, own, ratio = np.linspace(0, 1, 9), np.linspace(0, 0.8, 13), np.array([0.0, 0.15, 0.4])
    axes = np.meshgrid(mass, own, ratio, mass, own, ratio, indexing="ij")
    points = np.array([axis.ravel() for axis in axes])
    return points[:, points[1] < points[4]]
