"""Beams with a mass: handbook parts of it, both routes, and the whole beam by its differential equation."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from refusals import refused
from vibopt.report.curves import panels
from vibopt.scene.read import from_dict
from vibopt.solve import solve
from vibopt.verify.as_built import machine_of

E, LONG, WIDE, DENSITY, LOAD = 207e9, 0.8, 0.03, 7850.0, 25.0
BENDING, PER_LENGTH = E * np.pi * WIDE**4 / 64.0, DENSITY * np.pi * WIDE**2 / 4.0
STEEL = {"length": "0.8 m", "diameter": "30 mm", "modulus": "207 GPa", "density": "7850 kg/m3"}
PARTS = {
    "simply_supported": (17.0 / 35.0, 5.0 / 8.0),
    "cantilever": (33.0 / 140.0, 3.0 / 8.0),
    "fixed": (13.0 / 35.0, 0.5),
}
"""Of the mass of a beam that carries in its middle or at its tip, what moves with its load and what weighs there."""


def scene_of(beam: dict[str, Any], *, load: str = "25 kg", **more: Any) -> Any:
    """A load on a beam over the ground, shaken at 12 Hz."""
    shaker = {"kind": "force", "on": "load", "amplitude": "90 N", "speed": "12 Hz", "varies": "constant"}
    return from_dict(
        {
            "title": "drawn",
            "bodies": {"load": {"mass": load}},
            "links": {"beam": {"between": ["load", "ground"], "beam": {**STEEL, **beam}, "damping": "40 N s/m"}},
            "excitations": {"shaker": shaker},
            **more,
        }
    )


def measured(scene: Any) -> dict[str, float]:
    design = solve(scene, explain=False)
    assert design.status == "met", design.claim
    return {name: one.value.value for name, one in design.measures.items()}


@pytest.mark.parametrize(("kind", "parts"), PARTS.items(), ids=PARTS)
def test_the_handbook_part_of_its_mass_moves_with_the_load(kind: str, parts: tuple[float, float]) -> None:
    scene = scene_of({"kind": kind}, measures={"own": {"response": "natural_frequency"}, "sag": SAG, "k": STIFF})
    found, beam = measured(scene), PER_LENGTH * LONG
    assert found["own"] == pytest.approx(np.sqrt(found["k"] / (LOAD + parts[0] * beam)), rel=1e-12)
    assert found["sag"] == pytest.approx(9.80665 * (LOAD + parts[1] * beam) / found["k"], rel=1e-12)


SAG = {"response": "static_deflection", "of": "load"}
STIFF = {"response": "stiffness", "of": "beam"}


def bending(kind: str, at: float, omega: float) -> Any:
    """Of the whole beam under a force of one at its load and steady motion: deflection there, moments and supports.

    Krylov's functions in each span, four constants each; exact for any speed.  Lengths in metres.
    """
    far = max(at, LONG)
    cuts = sorted({0.0, at, LONG, far})
    wave = (PER_LENGTH * omega**2 / BENDING) ** 0.25

    def waves(x: float) -> Any:
        """Rows of deflection, slope, moment and shear over the four constants."""
        s, c, h, g = np.sin(wave * x), np.cos(wave * x), np.sinh(wave * x), np.cosh(wave * x)
        rows = [[s, c, h, g], [c, -s, g, h], [-s, -c, h, g], [-c, s, g, h]]
        return np.array([wave**i * (BENDING if i > 1 else 1.0) * np.array(row) for i, row in enumerate(rows)])

    spans, count = list(pairwise(cuts)), 4 * (len(cuts) - 1)
    rows, right = [], []

    def add(parts: dict[int, Any], value: float = 0.0) -> None:
        row = np.zeros(count)
        for span, part in parts.items():
            row[4 * span : 4 * span + 4] = part
        rows.append(row)
        right.append(value)

    held = {"simply_supported": (0.0, LONG), "overhung": (0.0, LONG), "cantilever": (0.0,)}.get(kind, (0.0, LONG))
    clamped = {"cantilever": (0.0,), "fixed": (0.0, LONG), "fixed_pinned": (0.0,)}.get(kind, ())
    for place in cuts:
        before = next((k for k, two in enumerate(spans) if two[1] == place), None)
        after = next((k for k, two in enumerate(spans) if two[0] == place), None)
        ends = [(k, waves(place - spans[k][0])) for k in (before, after) if k is not None]
        if len(ends) == 1:
            (k, one), force = ends[0], 1.0 if place == at else 0.0
            add({k: one[1 if place in clamped else 2]})
            if place in held:
                add({k: one[0]})
            else:
                add({k: one[3]}, -force)
            continue
        (k, one), (j, two) = ends
        for i in (1, 2):
            add({k: one[i], j: -two[i]})
        if place in held:
            add({k: one[0]})
            add({j: two[0]})
        else:
            add({k: one[0], j: -two[0]})
            add({k: one[3], j: -two[3]}, -(1.0 if place == at else 0.0))
    constants = np.linalg.solve(np.array(rows), np.array(right))

    def read(place: float, what: int, left: bool) -> float:
        k = next(i for i, two in enumerate(spans) if place == two[1 if left else 0])
        return float(waves(place - spans[k][0])[what] @ constants[4 * k : 4 * k + 4])

    return read


PLACES = [
    ("simply_supported", 0.5),
    ("simply_supported", 0.3),
    ("cantilever", 1.0),
    ("fixed", 0.5),
    ("fixed_pinned", 0.6),
    ("overhung", 1.3),
]


@pytest.mark.parametrize(("kind", "ratio"), PLACES)
def test_the_whole_beam_is_no_stiffer_than_its_shape_and_softer_by_the_bound_at_most(kind: str, ratio: float) -> None:
    """The first natural frequency with the load, from the exact dynamic stiffness of the beam."""
    at = ratio * LONG
    scene = scene_of({"kind": kind, "at_ratio": ratio}, measures={"k": STIFF})
    machine = machine_of(scene, {})
    joint, found = machine.joint("beam"), float(machine.natural_frequencies()[0])
    assert joint.borne is not None

    def balance(omega: float) -> float:
        return 1.0 / bending(kind, at, omega)(at, 0, True) - LOAD * omega**2

    right = brentq(balance, 0.5 * found, 1.001 * found, xtol=1e-9 * found)
    shaft, square = joint.borne.mass * joint.borne.means[1], (found / joint.borne.frequency) ** 2
    least = np.sqrt(joint.stiffness / (LOAD + shaft / (1.0 - square)))
    assert least <= right * (1.0 + 1e-6)
    assert right <= found * (1.0 + 1e-9)


@pytest.mark.parametrize(("kind", "ratio"), PLACES)
def test_stress_and_bearing_forces_are_those_of_the_whole_beam(kind: str, ratio: float) -> None:
    """At less than a tenth of its own frequency; what is left is of the order of the fourth power of that."""
    at, asked = ratio * LONG, {"of": "beam", "at": "12 Hz"}
    scene = scene_of(
        {"kind": kind, "at_ratio": ratio},
        measures={
            "far": {"response": "displacement", "of": "load", "at": "12 Hz"},
            "stress": {"response": "bending_stress", **asked},
            "left": {"response": "bearing_force", "bearing": "left", **asked},
            "right": {"response": "bearing_force", "bearing": "right", **asked},
        },
        links={"beam": {"between": ["load", "ground"], "beam": {**STEEL, "kind": kind, "at_ratio": ratio}}},
    )
    found, omega = measured(scene), 24.0 * np.pi
    read = bending(kind, at, omega)
    size = found["far"] / read(at, 0, True)
    ends = [(0.0, False), (at, True), (LONG, True)]
    moments = [abs(read(*one[:1], 2, one[1])) for one in ends if one[0] <= max(at, LONG)]
    assert found["stress"] == pytest.approx(size * max(moments) * 0.5 * WIDE * BENDING**-1 * E, rel=5e-4)
    assert found["left"] == pytest.approx(size * abs(read(0.0, 3, False)), rel=2e-3)
    over = abs(read(LONG, 3, True) - (read(LONG, 3, False) if at > LONG else 0.0)) * (kind != "cantilever")
    assert found["right"] == pytest.approx(size * over, rel=2e-3, abs=1e-9)


WEIGHTS = {
    "cantilever": (1.0, 0.5, {}),
    "simply_supported": (0.25, 0.125, {}),
    "fixed": (0.125, 1.0 / 12.0, {}),
    "overhung": (0.25, 0.25**2 / 2.0 / 1.25, {"at_ratio": 1.25}),
}
"""Moment at the section that a load bends most, over length and load, and over length and the weight of the beam."""


@pytest.mark.parametrize(("kind", "arms"), WEIGHTS.items(), ids=WEIGHTS)
def test_its_weight_bends_it_as_the_handbook_says(kind: str, arms: tuple[float, float, dict[str, Any]]) -> None:
    beam = {"kind": kind, **arms[2]}
    asked = {
        "still": {"response": "static_bending_stress", "of": "beam"},
        "moving": {"response": "bending_stress", "of": "beam"},
        "both": {"response": "combined_bending_stress", "of": "beam"},
        "mass": {"response": "total_mass"},
        "sag": SAG,
        "far": {"response": "displacement", "of": "load"},
        "reach": {"response": "combined_displacement", "of": "load"},
        "fades": {"response": "logarithmic_decrement"},
        "ratio": {"response": "damping_ratio"},
    }
    found = measured(scene_of(beam, measures=asked))
    own = PER_LENGTH * LONG * arms[2].get("at_ratio", 1.0)
    moment = 9.80665 * LONG * (arms[0] * LOAD + arms[1] * own)
    assert found["still"] == pytest.approx(32.0 * moment / (np.pi * WIDE**3), rel=1e-11)
    assert found["both"] == pytest.approx(found["still"] + found["moving"], rel=1e-12)
    assert found["reach"] == pytest.approx(found["sag"] + found["far"], rel=1e-12)
    assert found["mass"] == pytest.approx(LOAD + own, rel=1e-12)
    assert found["fades"] == pytest.approx(2.0 * np.pi * np.tan(np.arcsin(found["ratio"])), rel=1e-9)


@pytest.mark.parametrize(("kind", "ratio"), PLACES)
def test_both_routes_agree_on_a_heavy_shaft_over_bearings_that_give_way(kind: str, ratio: float) -> None:
    """Every question about it, of two shafts side by side on bearings with a mass and on those without."""
    steady = ["displacement", "velocity"]
    asked: dict[str, Any] = {f"{one} of {body}": {"response": one, "of": body} for one in steady for body in BODIES}
    asked |= {f"into {body}": {"response": "transmitted_force", "into": body} for body in (*BODIES, "ground")}
    asked |= {f"on {side}": {"response": "bearing_force", "of": "beam", "bearing": side} for side in ("left", "right")}
    asked |= {
        "through": {"response": "transmitted_force", "through": "beam"},
        "sag": {"response": "static_deflection", "of": "beam"},
        "low": {"response": "natural_frequency"},
        "damped": {"response": "damping_ratio"},
        "whole": {"response": "combined_bending_stress", "of": "beam"},
    }
    beam = {**STEEL, "kind": kind, "at_ratio": ratio}
    links = {
        "beam": {"between": ["load", "bearings"], "beam": beam, "count": 2, "damping": "40 N s/m"},
        "supports": {"between": ["bearings", "ground"], "stiffness": "900 kN/m", "damping": "900 N s/m"},
    }
    for mass in ("6 kg", "0 kg"):
        bodies = {"load": {"mass": "25 kg"}, "bearings": {"mass": mass}}
        found = measured(scene_of({}, bodies=bodies, links=links, measures=asked))  # "met": both routes say the same
        sides = found["on left"], found["on right"]
        assert abs(sides[0] - sides[1]) <= found["through"] * (1.0 + 1e-9) <= sum(sides) * (1.0 + 2e-9)


BODIES = ("load", "bearings")


def test_what_vibrates_by_itself_is_not_answered_by_its_shape() -> None:
    """A light load on a heavy beam, beyond its own frequency: said, and no number passes for right."""
    design = solve(scene_of({"kind": "fixed"}, load="1 kg", measures={"far": FAR}), explain=False)
    assert design.status == "check_failed"
    assert design.claim == (
        "far is not known: at 600 Hz the beam of links.beam does not keep its static shape, for it vibrates by itself "
        "from 590.7 Hz on, its load and supports held. Look at lower speeds or stiffer beams"
    )


FAR = {"response": "displacement", "of": "load", "at": "600 Hz"}
WRONG: dict[str, tuple[dict[str, Any], dict[str, Any], str]] = {
    "both": ({"mass": "3 kg"}, {}, "links.beam.beam gives density and mass. Keep one: each says how heavy it is."),
    "no area": (
        {"diameter": None, "second_moment": "4 cm4"},
        {},
        "links.beam.beam has a density, but says of its section the second moment alone, which is no area. Write mass "
        '= "12 kg", or its diameter.',
    ),
    "negative": (
        {"diameter": "-30 mm"},
        {},
        'links.beam.beam.diameter = "-30 mm" is not greater than zero. Write a positive value, for example "20 mm".',
    ),
    "wide bore": (
        {"inner_diameter": "31 mm"},
        {},
        "links.beam.beam is as wide inside as outside, or wider: nothing is left to bend. Write a smaller inner "
        "diameter.",
    ),
    "beyond": (
        {"at": "0.9 m"},
        {},
        "links.beam.beam has its load (at) on or beyond the far support. Write a place along its length.",
    ),
    "upside down": (
        {},
        {"between": ["ground", "load"]},
        "links.beam begins at the ground, but its beam has a mass, of which more moves with its load than with its "
        'supports. Write what it carries first: between = ["load", "ground"].',
    ),
    "on a base": (
        {},
        {"between": ["load", "floor"]},
        "links.beam ends at floor, but its beam has a mass, which is spread between bodies along a line and the "
        "ground. Put a body there on a link of its own, or leave the mass of the beam out.",
    ),
    "rubs": (
        {},
        {"friction_force": "3 N"},
        "links.beam rubs, and its beam has a mass: where friction holds its load, the beam goes on vibrating by "
        "itself. Leave the mass of the beam out, or write damping instead of the friction.",
    ),
}


@pytest.mark.parametrize(("beam", "link", "said"), WRONG.values(), ids=WRONG)
def test_a_wrong_beam_is_told(beam: dict[str, Any], link: dict[str, Any], said: str) -> None:
    words = {key: one for key, one in {**STEEL, "kind": "simply_supported", **beam}.items() if one is not None}
    links = {"beam": {"between": ["load", "ground"], "beam": words, **link}}
    caught = refused(scene_of, {}, bases={"floor": {}}, links=links, measures={"k": STIFF})
    assert any(one.endswith(said) for one in caught.messages), caught.messages


def test_a_curve_of_whirl_and_weight_together_passes_through_what_is_measured() -> None:
    scene = scene_of(
        {"kind": "fixed"},
        limits={"both": {"response": "combined_bending_stress", "of": "beam", "at_most": "99 MPa"}},
    )
    design = solve(scene, explain=False)
    (panel,) = panels(design)
    curve = panel.curves[0]
    there = np.interp(12.0, curve.x, curve.y)
    assert there == pytest.approx(design.limits["both"].value.value / 1e6, rel=1e-3)
