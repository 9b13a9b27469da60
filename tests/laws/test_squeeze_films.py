"""Squeeze-film dampers by their sizes: the damping of the short bearing, by both routes, chosen, and refused."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.linalg import solve_banded

from refusals import refused
from test_rotors import asked, friswell
from vibopt.scene.read import from_dict
from vibopt.solve import solve

FILM = {"clearance": "0.12 mm", "length": "25 mm", "diameter": "100 mm", "viscosity": "0.012 Pa s"}


def pressed(clearance: float, length: float, diameter: float, viscosity: float) -> float:
    """Force over speed [N s/m] by Reynolds' equation on a mesh: d/dz (h^3 dp/dz) = 12 mu dh/dt along z."""
    z, turn = np.linspace(-0.5 * length, 0.5 * length, 2001), np.linspace(0.0, 2.0 * math.pi, 721)[:-1]
    step, inner = z[1] - z[0], len(z) - 2
    bands = np.array([np.ones(inner), -2.0 * np.ones(inner), np.ones(inner)]) * clearance**3 / step**2
    shape = solve_banded((1, 1), bands, np.full(inner, -12.0 * viscosity))  # per speed of closing
    along = float(shape.sum() * step)
    return along * float(np.mean(np.cos(turn) ** 2)) * 2.0 * math.pi * 0.5 * diameter


def held(film: dict[str, Any], **more: Any) -> dict[str, Any]:
    document = friswell()
    both = {
        f"{one}_film": {"between": [one, "ground"], "k_yy": "2 MN/m", "k_zz": "2 MN/m", **more}
        for one in ("left", "right")
    }
    for one in both.values():
        one.update(film)
    return {**document, "links": {}, "bearings": both}


MEASURES = {
    "whirl": {"response": "displacement", "of": "first"},
    "force": {"response": "transmitted_force", "into": "ground"},
}


@pytest.mark.sampled(3)
@pytest.mark.parametrize("cavitated", [False, True])
@pytest.mark.parametrize("springs", ["alike", "apart"])
def test_a_film_damps_as_its_pressure_does(springs: str, cavitated: bool) -> None:
    damping = pressed(1.2e-4, 0.025, 0.1, 0.012) * (0.5 if cavitated else 1.0)
    both = {"c_yy": f"{damping!r} N s/m", "c_zz": f"{damping!r} N s/m"}
    more = {} if springs == "alike" else {"k_zz": "3 MN/m"}
    found = asked(held({"squeeze_film": {**FILM, "cavitated": cavitated}, **more}), **MEASURES)
    assert found == pytest.approx(asked(held({**both, **more}), **MEASURES), rel=1e-5)


def test_a_clearance_may_be_chosen() -> None:
    """A film too tight holds the shaft, one too wide lets it whirl: the ends are those of rotors of facts."""
    document = held({"squeeze_film": FILM})
    chosen = {**FILM, "clearance": {"from": "0.05 mm", "to": "0.4 mm"}}
    left = {**document["bearings"]["left_film"], "squeeze_film": chosen}
    document["bearings"] = {**document["bearings"], "left_film": left}
    document["limits"] = {"whirl": {**MEASURES["whirl"], "at_most": "0.09 mm"}}
    document["goal"] = {"find_all": "bearings.left_film.squeeze_film.clearance"}
    design = solve(from_dict(document))
    assert design.status == "met", design.claim
    ((low, high),) = design.found or ()
    assert 8e-5 < low.value < 1.2e-4 < high.value < 2e-4
    for end in (low.value, high.value):
        left["squeeze_film"] = {**FILM, "clearance": f"{end!r} m"}
        facts = {key: one for key, one in document.items() if key not in ("goal", "limits")}
        assert asked(facts, whirl=MEASURES["whirl"])["whirl"] == pytest.approx(9e-5, rel=1e-8)


WIDE = [(0.39, ""), (0.41, "its damping is that of small"), (1.01, "the rings touch")]


@pytest.mark.parametrize(("part", "said"), WIDE)
def test_an_orbit_that_is_wide_in_its_film_is_told(part: float, said: str) -> None:
    """What whirls is in proportion to the unbalance, so any part of the clearance can be had."""
    document = held({"squeeze_film": FILM})
    shaker = document["excitations"]["imbalance"]
    places = {name: {"response": "displacement", "of": name} for name in ("left", "right")}
    unit = {"imbalance": {**shaker, "unbalance": "1 kg m"}}
    widest = max(asked({**document, "excitations": unit}, **places).values())
    shaker = {**shaker, "unbalance": f"{part * 1.2e-4 / widest!r} kg m"}
    notes = solve(from_dict({**document, "excitations": {"imbalance": shaker}, "measures": places})).notes
    told = [one for one in notes if "in a squeeze film of 0.12 mm clearance" in one]
    assert bool(told) == bool(said)
    assert all(said in one for one in told[:1])


HEAD = "scene: bearings.left_film"
WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "long": (
        {"squeeze_film": {**FILM, "length": "60 mm"}},
        f"{HEAD}.squeeze_film is longer than half its diameter, where the formula of the short bearing no longer "
        "holds. Write a shorter film, two of them, or the damping itself: c_yy and c_zz.",
    ),
    "wide": (
        {"squeeze_film": {**FILM, "clearance": "6 mm"}},
        f"{HEAD}.squeeze_film has a clearance of more than a twentieth of its diameter, which is no film. Write a "
        "smaller one.",
    ),
    "two dampings": (
        {"squeeze_film": FILM, "c_yy": "2 kN s/m"}, f"{HEAD} gives squeeze_film and c_yy. Keep one of them.",
    ),
    "a tolerance": (
        {"squeeze_film": FILM, "tolerance": "5 %"}, f"{HEAD} gives squeeze_film and tolerance. Keep one of them.",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("table", "sentence"), WRONG.values(), ids=WRONG)
def test_films_that_are_none_are_refused(table: dict[str, Any], sentence: str) -> None:
    assert refused(from_dict, held(table)).messages[0] == sentence
