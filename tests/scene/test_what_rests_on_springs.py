"""Weights are asked after only where springs carry all of them: random machines against the rank of their stiffness."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from refusals import refused
from vibopt.scene.read import from_dict
from vibopt.solve import solve

SPRING, PART = 4e5, 2.5e5
"""Stiffness of a spring and of the part [N/m]."""
INSTEAD = ", or write stiffness and damping in place of the part."


def machine(seed: int, folder: Path) -> tuple[dict[str, Any], NDArray[np.float64], NDArray[np.float64]]:
    """Bodies joined by springs, dampers and a bought part; its static stiffness (n, n), and its masses (n,).

    Body n is joined with one before it or with the ground.
    """
    draw = np.random.default_rng(seed)
    count = int(draw.integers(1, 5))
    mass = draw.integers(20, 200, count).astype(float)
    names = [*(f"b{i}" for i in range(count)), "ground"]
    catalogue = folder / "parts.csv"
    catalogue.write_text(f"part,rated load max [N],stiffness [N/mm],loss factor\nP,1e6,{PART / 1e3},0.1\n")
    document: dict[str, Any] = {
        "bodies": {f"b{i}": {"mass": f"{one} kg"} for i, one in enumerate(mass)},
        "links": {},
        "excitations": {"e": {"kind": "force", "on": "b0", "amplitude": "1 N", "speed": "9 Hz"}},
    }
    stiffness = np.zeros((count + 1, count + 1))
    bought = int(draw.integers(count))
    for i in range(count):
        other = int(draw.choice([-1, *range(i)]))
        own: dict[str, Any] = {"damping": "900 N s/m"}
        if i == bought:
            own = {"part": {"catalogue": str(catalogue), "name": "P"}}
        elif draw.random() < 0.7:
            own = {"stiffness": f"{SPRING} N/m", "damping": "90 N s/m"}
        value = PART if "part" in own else SPRING if "stiffness" in own else 0.0
        document["links"]["part" if i == bought else f"l{i}"] = {"between": [names[i], names[other]], **own}
        row = np.eye(count + 1)[i] - np.eye(count + 1)[other]
        stiffness += value * np.outer(row, row)
    return document, stiffness[:count, :count], mass


@pytest.mark.parametrize("seed", range(24))
def test_loads_are_refused_where_the_stiffness_is_singular_and_right_elsewhere(seed: int, tmp_path: Path) -> None:
    document, stiffness, mass = machine(seed, tmp_path)
    asked = {"measures": {f"sag_{name}": {"response": "static_deflection", "of": name} for name in document["bodies"]}}
    plain = {**document, "measures": {"moved": {"response": "displacement", "of": "b0"}}}
    if np.linalg.matrix_rank(stiffness) < len(mass):
        rated, *more = refused(from_dict, plain).messages
        assert not more
        assert rated.startswith("scene: links.part.part has a rated load, but no spring holds ")
        assert rated.endswith(f" towards the ground{INSTEAD}")
        said = refused(from_dict, {**document, **asked}).messages
        assert sum("asks for the static deflection" in one and "no spring holds" in one for one in said) == len(mass)
        return
    down = np.append(np.linalg.solve(stiffness, 9.80665 * mass), 0.0)
    found = solve(from_dict({**document, **asked}))
    for i in range(len(mass)):
        assert found.measures[f"sag_b{i}"].value.value == pytest.approx(down[i], rel=1e-9)
    ends = [-1 if one == "ground" else int(one[1:]) for one in document["links"]["part"]["between"]]
    load = found.limits["part: rated load"].value.value
    assert load == pytest.approx(PART * abs(down[ends[0]] - down[ends[1]]), rel=1e-9)


@pytest.mark.parametrize("held", [True, False])
def test_how_the_weight_of_a_structure_that_nothing_holds_rests_is_not_known(held: bool, tmp_path: Path) -> None:
    document = machine(1, tmp_path)[0]
    modes = [{"frequency": "9 Hz" if held else "0 Hz", "modal_mass": "90 kg", "damping_ratio": 0.02 * held,
              "shape": {"edge": 1.0}}]  # fmt: skip
    document |= {
        "structures": {"frame": {"modes": modes}},
        "bodies": {"b0": {"mass": "20 kg"}},
        "links": {"part": {**document["links"]["part"], "between": ["edge", "ground"]},
                  "foot": {"between": ["b0", "edge"], "stiffness": "400 N/mm"}},
        "measures": {"sag": {"response": "static_deflection", "of": "b0"}},
    }  # fmt: skip
    if held:
        assert solve(from_dict(document)).status == "met"
        return
    why = "but nothing holds structures.frame, and how its weight rests is not known. Let it have supports"
    assert refused(from_dict, document).messages == (
        f"scene: measures.sag asks for the static deflection of b0, {why}.",
        f"scene: links.part.part has a rated load, {why}{INSTEAD}",
    )
