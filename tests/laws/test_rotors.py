"""Rotors of discs on a shaft: polynomials against waves, closed forms, published figures, and what is refused."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from refusals import refused
from test_spin import whirl_rates
from vibopt.document.toml_writing import document_toml
from vibopt.errors import InputError
from vibopt.forms.whirling import WhirlDamping, WhirlThreshold
from vibopt.jobs import answer
from vibopt.jobs import from_text as job_from_text
from vibopt.mechanics.model import INERTIA, STIFFNESS
from vibopt.mechanics.modes import natural_frequencies
from vibopt.mechanics.orbits import roots, spun
from vibopt.mechanics.shaft_waves import MODES, Section, WhirlingShaft
from vibopt.program.pose import pose
from vibopt.report.campbell import campbell_of
from vibopt.report.figures.campbell_diagram import campbell_figure
from vibopt.report.modelled_balancing import balancing_document
from vibopt.scene.assemble import model_of
from vibopt.scene.read import from_dict, from_text
from vibopt.solve import solve
from vibopt.verify.as_built import machine_of

NONE = np.zeros(0)
RPM = math.pi / 30.0


def held(stiffness: float = 1e6, damping: float = 0.0) -> dict[str, Any]:
    """Bearings alike at both ends."""
    table = {"stiffness": f"{stiffness!r} N/m", **({"damping": f"{damping!r} N s/m"} if damping else {})}
    return {name: {"between": [name[:-8], "ground"], **table} for name in ("left_bearing", "right_bearing")}


def friswell(**over: Any) -> dict[str, Any]:
    """Two discs between two bearings: Friswell, Penny, Garvey and Lees (2010), example 5.9.1."""
    disc = {"inner_diameter": "50 mm", "width": "70 mm", "density": "7810 kg/m3"}
    rotor = {
        "sections": [{"length": "1.5 m", "diameter": "50 mm"}],
        "discs": [
            {"name": "first", "at": "0.5 m", "outer_diameter": "280 mm", **disc},
            {"name": "second", "at": "1 m", "outer_diameter": "350 mm", **disc},
        ],
        "stations": {"left": "0 m", "right": "1.5 m"},
        "modulus": "211 GPa",
        "shear_modulus": "81.2 GPa",
        "density": "7810 kg/m3",
    }
    return {
        "title": "two discs",
        "rotors": {"rotor": {**rotor, **over}},
        "links": held(),
        "excitations": {
            "imbalance": {"kind": "unbalance", "on": "first", "unbalance": "1 g m", "speed": "100..4000 rpm"}
        },
        "measures": {"first": {"response": "displacement", "of": "first"}},
    }


def asked(document: dict[str, Any], **measures: dict[str, Any]) -> dict[str, float]:
    """Values of measures [SI], agreed on by both routes."""
    design = solve(from_dict({**document, "measures": measures}))
    assert design.status == "met", design.claim
    return {name: row.value.value for name, row in design.measures.items()}


# Published figures, with the shear coefficient of Cowper and converged elements

FREE_AT_REST = (86.65811435, 274.31285391, 716.78631221)
WHIRLS_AT_4000 = (85.389467, 87.7958637, 251.78460413, 294.71333087, 600.17936195, 827.07536193)
"""Of six elements, as the manual of ROSS prints them [rad/s]."""


@pytest.mark.parametrize(("speed", "printed"), [(0.0, FREE_AT_REST), (4000.0, WHIRLS_AT_4000)])
def test_whirls_of_two_discs_are_those_that_are_printed(speed: float, printed: tuple[float, ...]) -> None:
    machine = machine_of(from_dict(friswell()), {})
    mass, _, stiffness, _, polar = machine.slow
    n, spin = len(mass), speed * RPM
    state = np.block(
        [[np.zeros((n, n)), np.eye(n)], [np.linalg.solve(mass, stiffness), np.linalg.solve(mass, spin * polar)]]
    )
    found = np.sort(np.abs(np.linalg.eigvals(state).real))
    lowest = found[: len(printed)] if speed else found[: 2 * len(printed) : 2]
    assert lowest == pytest.approx(printed, rel=5e-4)


# Both routes: polynomials in the model, waves on the machine as built


@pytest.mark.parametrize("whirl", ["forward", "backward"])
@pytest.mark.parametrize("discs", [2, 0])
def test_critical_speeds_by_polynomials_are_those_by_waves(discs: int, whirl: str) -> None:
    """All that are told, with discs and without: a bare shaft of one section is the longest stretch of waves."""
    document = friswell() if discs else friswell(discs=[])
    document["excitations"]["imbalance"]["on"] = "left"
    document["measures"] = {"c": {"response": "critical_speed", "mode": MODES, "whirl": whirl}}
    scene = from_dict(document)
    model, sense = model_of(scene), 1.0 if whirl == "forward" else -1.0
    seen = model if whirl == "forward" else model.backward
    speeds = natural_frequencies(seen, seen.values(NONE))[:MODES]
    assert machine_of(scene, {}).critical_speeds(sense) == pytest.approx(speeds, rel=1e-9)


@pytest.mark.parametrize("whirl", ["forward", "backward"])
@pytest.mark.parametrize("long", ["0.6 m", "1 m"])
def test_critical_speeds_of_a_thick_shaft_by_polynomials_are_those_by_waves(long: str, whirl: str) -> None:
    """Shear and tilting let a stretch held at its ends vibrate long before bending does: none is skipped."""
    document = friswell(discs=[], sections=[{"length": long, "diameter": "200 mm"}])
    document["rotors"]["rotor"]["stations"]["right"] = long
    document["links"] = held(9e8)
    document["excitations"]["imbalance"]["on"] = "left"
    document["measures"] = {"c": {"response": "critical_speed", "mode": MODES, "whirl": whirl}}
    scene = from_dict(document)
    model, sense = model_of(scene), 1.0 if whirl == "forward" else -1.0
    seen = model if whirl == "forward" else model.backward
    speeds = natural_frequencies(seen, seen.values(NONE))[:MODES]
    assert machine_of(scene, {}).critical_speeds(sense) == pytest.approx(speeds, rel=1e-9)


def test_a_critical_speed_is_where_the_unbalance_response_has_no_end() -> None:
    critical = asked(friswell(), c={"response": "critical_speed", "mode": 2})["c"]
    near = friswell()
    near["excitations"]["imbalance"]["speed"] = f"{critical * (1.0 - 1e-7) / RPM!r} rpm"
    close = asked(near, first={"response": "displacement", "of": "first"})["first"]
    near["excitations"]["imbalance"]["speed"] = f"{critical * (1.0 - 1e-6) / RPM!r} rpm"
    assert close == pytest.approx(
        10.0 * asked(near, first={"response": "displacement", "of": "first"})["first"], rel=1e-4
    )


@pytest.mark.parametrize("speed", ["500 rpm", "100..6000 rpm"])
def test_the_whirl_under_an_unbalance_is_answered_and_agreed(speed: str) -> None:
    document = friswell()
    document["links"] = held(2e6, 3e3)
    document["excitations"]["imbalance"]["speed"] = speed
    measures = {
        "near": {"response": "displacement", "of": "first"},
        "far": {"response": "velocity", "of": "right"},
        "bearing": {"response": "transmitted_force", "through": "left_bearing"},
        "ground": {"response": "transmitted_force", "into": "ground"},
        "sag": {"response": "static_deflection", "of": "second"},
    }
    assert min(asked(document, **measures).values()) > 0.0


def test_whirls_of_the_campbell_diagram_part_with_the_spin_and_meet_it_at_the_critical_speeds() -> None:
    machine = machine_of(from_dict(friswell()), {})
    still = machine.free_whirls(0.0)
    assert still[still > 0.0] == pytest.approx(-still[still < 0.0][::-1], rel=1e-6)
    for sense in (1.0, -1.0):
        for speed in machine.critical_speeds(sense)[:3]:
            whirls = sense * machine.free_whirls(float(speed))
            assert np.abs(whirls / speed - 1.0).min() <= 1e-4
    found = machine.free_whirls(4000.0 * RPM)
    assert np.sort(np.abs(found))[:6] == pytest.approx(WHIRLS_AT_4000, rel=5e-4)


def test_a_campbell_diagram_is_drawn_of_rotors_alone() -> None:
    design = solve(from_dict(friswell()))
    drawn = campbell_of(design)
    model = model_of(from_dict(friswell()))
    assert drawn.critical == pytest.approx(
        natural_frequencies(model, model.values(NONE))[: len(drawn.critical)], rel=1e-9
    )
    assert len(drawn.critical) > 1
    (axes,) = campbell_figure(drawn, "two discs").axes
    words = [one.get_text() for one in axes.texts if "rpm" in one.get_text()]
    said = sorted(int(one) for text in words for one in text.removesuffix(" rpm").split(", "))
    assert said == sorted(round(float(f"{one / RPM:.4g}")) for one in (*drawn.critical, *drawn.against))
    assert len(words) < len(said)  # those next to each other share a label
    slow = friswell()
    slow["excitations"]["imbalance"]["speed"] = "10 rpm"
    slow = campbell_of(solve(from_dict(slow)))
    assert (slow.critical[0], slow.against[0]) == (drawn.critical[0], drawn.against[0])  # however slowly it runs
    table = {"title": "t", "bodies": {"b": {"mass": "2 kg"}}, "measures": {"m": {"response": "total_mass"}}}
    caught = refused(lambda: campbell_of(solve(from_dict(table))))
    assert caught.messages == ("scene: --campbell is of rotors, and there is none. Leave --campbell out.",)


def test_a_campbell_diagram_of_a_set_of_values_says_how_to_choose_one() -> None:
    document = friswell(sections=[{"length": "1.5 m", "diameter": {"from": "40 mm", "to": "60 mm"}}])
    document["limits"] = {"apart": {"response": "critical_speed", "at_least": "100 rpm"}}
    document["goal"] = {"find_all": "rotors.rotor.sections.1.diameter"}
    del document["measures"]
    assert refused(lambda: campbell_of(solve(from_dict(document)))).messages == (
        "scene: find_all answers with values of rotors.rotor.sections.1.diameter, and a Campbell diagram is of one "
        'machine. Choose it: vibopt plot scene --campbell --set rotors.rotor.sections.1.diameter="50 mm" -o '
        "campbell.svg",
    )


# Closed forms


def light(**over: Any) -> dict[str, Any]:
    """A shaft that weighs nothing and is stiff in shear, on bearings that hardly give way."""
    rotor = {
        "sections": [{"length": "1 m", "diameter": "40 mm"}],
        "discs": [{"name": "disc", "at": "0.5 m", "mass": "20 kg"}],
        "stations": {"left": "0 m", "right": "1 m"},
        "modulus": "200 GPa",
        "shear_modulus": "1e9 GPa",
        "shear_coefficient": 1.0,
        "density": "1e-12 kg/m3",
    }
    unbalance = {"kind": "unbalance", "on": "disc", "unbalance": "2 g m", "speed": "3000 rpm"}
    return {
        "title": "Jeffcott",
        "rotors": {"rotor": {**rotor, **over}},
        "links": held(1e14),
        "excitations": {"imbalance": unbalance},
    }


BENDING = 200e9 * math.pi * 0.04**4 / 64.0


def test_jeffcott() -> None:
    """r = u w^2 / (k - m w^2) with k = 48 E I / L^3."""
    stiffness, omega = 48.0 * BENDING, 3000.0 * RPM
    found = asked(
        light(),
        whirl={"response": "displacement", "of": "disc"},
        critical={"response": "critical_speed"},
        sag={"response": "static_deflection", "of": "disc"},
    )
    assert found["critical"] == pytest.approx(math.sqrt(stiffness / 20.0), rel=1e-8)
    assert found["whirl"] == pytest.approx(2e-3 * omega**2 / abs(stiffness - 20.0 * omega**2), rel=1e-7)
    assert found["sag"] == pytest.approx(20.0 * 9.80665 / stiffness, rel=1e-7)


@pytest.mark.parametrize("speed", ["900 rpm", "100..2500 rpm"])
def test_a_light_stepped_shaft_bends_most_where_force_times_arm_says(speed: str) -> None:
    """32 F a / pi d^3 at the step of the thinner shaft, of the force on the bearing near it."""
    sections = [{"length": "0.4 m", "diameter": "40 mm"}, {"length": "0.6 m", "diameter": "50 mm"}]
    document = light(sections=sections, density="1e-6 kg/m3")
    document["links"] = held(3e7, 3e3)
    document["excitations"]["imbalance"]["speed"] = speed
    force = {"response": "transmitted_force", "through": "left_bearing"}
    found = asked(document, force=force, stress={"response": "bending_stress", "of": "rotor"})
    assert found["stress"] == pytest.approx(found["force"] * 0.4 * 32.0 / (math.pi * 0.04**3), rel=1e-7)


def test_the_stress_of_a_heavy_shaft_is_agreed() -> None:
    """Bending by the inertia of all parts, discs that tilt among them, as polynomials and waves hand it on."""
    document = {**friswell(), "links": held(2e6, 3e3)}
    document["excitations"]["imbalance"]["speed"] = "300..1500 rpm"
    both = {name: {"response": "bending_stress", "of": "rotor", **more} for name, more in
            (("all", {}), ("slow", {"at": "500 rpm"}))}  # fmt: skip
    found = asked(document, **both)
    assert found["all"] > found["slow"] > 0.0


@pytest.mark.slow
def test_the_stress_of_a_heavy_shaft_bounds_its_diameter() -> None:
    document = friswell(sections=[{"length": "1.5 m", "diameter": {"from": "40 mm", "to": "60 mm"}}])
    document["links"] = held(2e7, 2e4)
    document["excitations"]["imbalance"]["speed"] = "800 rpm"
    document["limits"] = {"stress": {"response": "bending_stress", "of": "rotor", "at_most": "10 MPa"}}
    document["goal"] = {"find_all": "rotors.rotor.sections.1.diameter"}
    del document["measures"]
    design = solve(from_dict(document))
    assert design.status == "met"
    for _, end in ((one.value, other.value) for one, other in design.found):
        if end < 0.06:
            there = {**friswell(sections=[{"length": "1.5 m", "diameter": f"{end!r} m"}]), "links": held(2e7, 2e4)}
            there["excitations"] = document["excitations"]
            stress = asked(there, s={"response": "bending_stress", "of": "rotor"})["s"]
            assert stress == pytest.approx(10e6, rel=1e-8)


@pytest.mark.parametrize("whirl", ["forward", "backward"])
def test_an_overhung_disc_tilts_by_the_closed_form(whirl: str) -> None:
    """A disc at the end of a cantilever: (12 E I / L^3 - m w^2)(4 E I / L -+ ...) = (6 E I / L^2)^2."""
    disc = {"name": "disc", "at": "1.5 m", "mass": "20 kg", "diametral": "0.3 kg m2", "polar": "0.6 kg m2"}
    sections = [{"length": "1 m", "diameter": "400 mm"}, {"length": "0.5 m", "diameter": "40 mm"}]
    document = light(sections=sections, discs=[disc])
    document["links"] = held(1e15)
    tilting = -0.3 if whirl == "forward" else 0.9
    long = 0.5
    a, b, c = 12.0 * BENDING / long**3, 6.0 * BENDING / long**2, 4.0 * BENDING / long
    squares = np.roots([20.0 * tilting, -(20.0 * c + tilting * a), a * c - b * b])
    lowest = math.sqrt(min(one for one in squares.real if one > 0.0))
    found = asked(document, c={"response": "critical_speed", "whirl": whirl})["c"]
    assert found == pytest.approx(lowest, rel=2e-3)  # the inner section and its bearings give way a little


@pytest.mark.parametrize("modes", [1, 2, 3])
def test_a_slender_shaft_alone_whirls_as_a_beam(modes: int) -> None:
    """Pinned at both ends, Timoshenko's frequency equation with forward gyroscopic moments of a round section."""
    document = friswell(discs=[], density="7810 kg/m3")
    document["links"] = held(1e14)
    document["excitations"]["imbalance"]["on"] = "left"
    found = asked(document, c={"response": "critical_speed", "mode": modes})["c"]
    area, second = math.pi * 0.05**2 / 4.0, math.pi * 0.05**4 / 64.0
    shear = 6.0 * 1.3 / (7.0 + 6.0 * 0.3) * 81.2e9 * area
    k = modes * math.pi / 1.5
    # (E I k^2 + S + rho I w^2)(S k^2 - rho A w^2) = S^2 k^2
    a, b = 211e9 * second * k**2 + shear, 7810.0 * second
    c, d = shear * k**2, 7810.0 * area
    squares = np.roots([-b * d, b * c - a * d, a * c - shear**2 * k**2])
    assert found == pytest.approx(math.sqrt(min(one for one in squares.real if one > 0.0)), rel=1e-7)


# The threshold beyond which a whirl grows


def shrunk(**over: str) -> dict[str, Any]:
    """A disc that feels a damper at rest and one that turns with the shaft."""
    document = light()
    fits = {"between": ["disc", "ground"], "damping": "60 N s/m", "rotating_damping": "40 N s/m", **over}
    return {**document, "links": {**document["links"], "fit": fits}}


def test_the_threshold_of_one_disc_is_the_closed_form() -> None:
    """w_n (1 + c_e / c_i), whatever the shaft is made of."""
    found = asked(shrunk(), threshold={"response": "stability_threshold"}, critical={"response": "critical_speed"})
    assert found["threshold"] == pytest.approx(found["critical"] * (1.0 + 60.0 / 40.0), rel=1e-7)


def test_slopes_of_whirls_are_those_of_their_differences() -> None:
    """They hang on a diameter, a disc, a bearing, a damper at rest and one that turns, beside material that damps."""
    document = {**friswell(material_damping="0.01 ms"), "links": held(2e6, 3e3), "measures": {}}
    document["rotors"]["rotor"]["sections"][0]["diameter"] = {"from": "20 mm", "to": "120 mm"}
    document["rotors"]["rotor"]["discs"].append({"name": "hub", "at": "0.7 m", "mass": {"from": "5 kg", "to": "80 kg"}})
    document["links"]["left_bearing"]["stiffness"] = {"from": "0.1 MN/m", "to": "50 MN/m"}
    document["links"]["right_bearing"]["damping"] = {"from": "10 N s/m", "to": "90 kN s/m"}
    fit = {"between": ["second", "ground"], "rotating_damping": {"from": "1 N s/m", "to": "1 kN s/m"}}
    document["links"]["fit"] = fit
    document["limits"] = {"stable": {"response": "stability_threshold", "at_least": "4000 rpm"}}
    scene = from_dict({**document, "goal": {"minimise": "total_mass"}})
    (limit,) = pose(scene).limits
    middle = {"sections": 0.05, "discs": 20.0, "left": 2e6, "right": 3e3, "fit": 20.0}
    sizes = [next(one for key, one in middle.items() if key in variable.path) for variable in scene.variables]
    x, way = np.array(sizes), 1e-4 * np.array([0.6, -0.5, 0.7, 0.2, -0.4])
    damping = [
        WhirlDamping(ratio, ((300.0, 300.0 + over),), 700.0, sense, number)
        for ratio, over, sense, number in ((False, 0.0, 0.0, 1), (True, 0.0, 1.0, 2), (False, 60.0, -1.0, 1))
    ]
    for form in (WhirlThreshold(), *damping):
        slope = form.slope(limit.model, x)
        ahead, back = (form.value(limit.model, x * np.exp(sign * way)) for sign in (1.0, -1.0))
        assert 2.0 * slope @ way == pytest.approx(math.log(ahead / back), rel=1e-5)


@pytest.mark.parametrize("ratio", [False, True])
def test_slopes_of_whirls_between_unlike_bearings_are_those_of_their_differences(ratio: bool) -> None:
    table = [{"speed": f"{at} rpm", "k_yy": "4 MN/m", "k_yz": "0.2 MN/m", "k_zz": f"{k} MN/m", "c_yy": "9 kN s/m"}
             | {"k_zy": "-0.1 MN/m", "c_zz": "5 kN s/m"} for at, k in ((0, 6), (9000, 8))]  # fmt: skip
    document = {**friswell(), "measures": {}, "links": {}}
    document["rotors"]["rotor"]["sections"][0]["diameter"] = {"from": "20 mm", "to": "120 mm"}
    unlike = {"k_yy": {"from": "0.1 MN/m", "to": "50 MN/m"}, "k_zz": "6 MN/m", "k_yz": "0.2 MN/m", "k_zy": "-0.1 MN/m"}
    damps = {"c_yy": "3 kN s/m", "c_zz": {"from": "10 N s/m", "to": "90 kN s/m"}}
    document["bearings"] = {
        "left_film": {"between": ["left", "ground"], "table": table},
        "right_film": {"between": ["right", "ground"], **unlike, **damps},
    }
    fit = {"between": ["second", "ground"], "rotating_damping": {"from": "1 N s/m", "to": "1 kN s/m"}}
    document["links"] = {"fit": fit}
    fades = {"response": "logarithmic_decrement", "at": "2000 rpm", "up_to": "7000 rpm", "at_least": 0.01}
    stable = {"response": "stability_threshold", "at_least": "4000 rpm"}
    scene = from_dict({**document, "limits": {"fades": fades, "stable": stable}, "goal": {"minimise": "total_mass"}})
    model = pose(scene).limits[0].model
    middle = {"sections": 0.05, "k_yy": 2e6, "c_zz": 5e3, "fit": 20.0}
    sizes = [next(one for key, one in middle.items() if key in variable.path) for variable in scene.variables]
    x, way = np.array(sizes), 1e-4 * np.array([0.6, -0.5, 0.7, 0.2])
    for number in (1, 2):
        form = WhirlDamping(ratio, ((200.0, 200.0),), 700.0, 0.0, number)
        ahead, back = (form.value(model, x * np.exp(sign * way)) for sign in (1.0, -1.0))
        assert 2.0 * form.slope(model, x) @ way == pytest.approx(math.log(ahead / back), rel=1e-5)


@pytest.mark.parametrize("damping", [3e2, 3e3])
def test_the_threshold_of_a_heavy_rotor_is_where_its_whirl_neither_grows_nor_fades(damping: float) -> None:
    """Both routes agree, and the rates of all its pieces say so on either side; polar inertia counts."""
    document = {**friswell(), "links": held(2e6, damping)}
    document["links"]["fit"] = {"between": ["second", "ground"], "damping": "1 N s/m", "rotating_damping": "200 N s/m"}
    document["excitations"]["imbalance"]["speed"] = "500 rpm"
    spin = asked(document, threshold={"response": "stability_threshold"})["threshold"]
    machine = machine_of(from_dict(document), {})
    mass, fixed, stiffness, _, polar = machine.slow
    at = machine.shafts["rotor"].place("second")
    turning = np.zeros_like(mass)
    turning[at, at] = 200.0
    growth = []
    for part in (1.0 - 1e-3, 1.0 + 1e-3):
        rates = whirl_rates(mass, fixed, turning, stiffness, part * spin, polar)
        growth.append(rates.real.max())
    assert growth[0] < 0.0 < growth[1]


@pytest.mark.parametrize("wide", [46.0, 56.811320755, 111.0])
def test_the_threshold_of_a_thick_shaft_in_heavy_dampers_is_where_its_whirl_begins_to_grow(wide: float) -> None:
    """Few free motions at rest tell little of what dampers hold: from where they end Newton may lead nowhere."""
    sizes = (("first", "0.1638 m", 6.086, 0.1254, 0.233), ("second", "0.4603 m", 9.358, 0.2301, 0.4277))
    document = friswell(
        sections=[{"length": "0.6559 m", "diameter": f"{wide!r} mm"}],
        stations={"left": "0.1088 m", "right": "0.3765 m"},
        discs=[
            {"name": name, "at": at, "mass": f"{mass} kg", "diametral": f"{tilts} kg m2", "polar": f"{spins} kg m2"}
            for name, at, mass, tilts, spins in sizes
        ],
        modulus="213.2 GPa", shear_modulus="82 GPa", density="7850 kg/m3",
    )  # fmt: skip
    document["links"] = {
        **held(4.889e9, 1.095e6),
        "fit": {"between": ["left", "ground"], "rotating_damping": "328 kN s/m"},
    }
    document["links"]["right_bearing"] |= {"stiffness": "2592 MN/m", "damping": "2787 kN s/m"}
    model = model_of(from_dict(document))
    spin = asked(document, threshold={"response": "stability_threshold"})["threshold"]
    rotor = spun(model, NONE)
    growth = []
    for part in (1.0 - 1e-3, 1.0 + 1e-3):
        first, second = rotor.powers(part * spin)
        rates = roots(second, first, rotor.dynamic(0.0, part * spin))
        growth.append(-(rates.imag / np.abs(rates))[np.abs(rates) < 20.0 * spin].min())
    assert growth[0] < 1e-6 < growth[1]


# Laws of the model


def test_stiffness_is_positive_and_gyroscopic_moments_alone_make_inertia_negative() -> None:
    model = model_of(from_dict(friswell()))
    p = model.values(NONE)
    heavy = model.matrix(INERTIA, np.where([term.polar for term in model.terms], 0.0, p))
    assert np.linalg.eigvalsh(heavy).min() > 0.0
    assert np.linalg.eigvalsh(model.matrix(INERTIA, p)).min() < 0.0
    assert np.linalg.eigvalsh(model.matrix(STIFFNESS, p)).min() > 0.0


def test_forward_and_backward_are_one_without_polar_inertia_and_apart_with_it() -> None:
    alike, apart = light(), light()
    disc = {"name": "disc", "at": "0.3 m", "mass": "20 kg", "diametral": "0.3 kg m2", "polar": "0.6 kg m2"}
    alike["rotors"]["rotor"]["discs"] = [{**disc, "polar": "1e-20 kg m2"}]
    apart["rotors"]["rotor"]["discs"] = [disc]
    both = {way: {"response": "critical_speed", "whirl": way} for way in ("forward", "backward")}
    one, other = asked(alike, **both), asked(apart, **both)
    assert one["forward"] == pytest.approx(one["backward"], rel=1e-9)
    assert other["backward"] < one["forward"] < other["forward"]


@pytest.mark.parametrize(("driven", "seen"), [("first", "second"), ("second", "right")])
def test_the_whirl_is_reciprocal(driven: str, seen: str) -> None:
    """In a whirl with the spin the dynamic stiffness is symmetric."""
    there, back = friswell(), friswell()
    for document, on in ((there, driven), (back, seen)):
        document["links"] = held(2e6, 3e3)
        document["excitations"]["imbalance"] |= {"on": on, "speed": "2500 rpm"}
    one = asked(there, m={"response": "displacement", "of": seen})["m"]
    assert asked(back, m={"response": "displacement", "of": driven})["m"] == pytest.approx(one, rel=1e-10)


def test_a_station_more_changes_nothing() -> None:
    """Nodes cut the shaft, and neither route knows of it."""
    more = friswell(stations={"left": "0 m", "probe": "0.71 m", "right": "1.5 m"})
    question = {"response": "displacement", "of": "second", "at": "3700 rpm"}
    assert asked(more, m=question)["m"] == pytest.approx(asked(friswell(), m=question)["m"], rel=1e-10)


def test_waves_at_rest_are_the_beam_of_the_textbook() -> None:
    """Stiffness of a Timoshenko element, by its formula."""
    long, bends, shears = 0.4, 5e4, 3e7
    found = WhirlingShaft((Section(long, bends, shears, 10.0, 0.01),), (), {}).dynamic(np.zeros(1))[0].real
    phi = 12.0 * bends / (shears * long**2)
    near, far = (4.0 + phi) * long**2, (2.0 - phi) * long**2
    rows = [[12, 6 * long, -12, 6 * long], [6 * long, near, -6 * long, far],
            [-12, -6 * long, 12, -6 * long], [6 * long, far, -6 * long, near]]  # fmt: skip
    assert np.allclose(found, np.array(rows) * bends / (long**3 * (1.0 + phi)), rtol=1e-12, atol=0.0)


# Designs


def test_every_diameter_at_which_the_limits_hold() -> None:
    document = friswell(sections=[{"length": "1.5 m", "diameter": {"from": "40 mm", "to": "60 mm"}}])
    document["links"] = held(2e7, 2e4)
    document["limits"] = {"apart": {"response": "critical_speed", "outside": "1000..1100 rpm"}}
    document["goal"] = {"find_all": "rotors.rotor.sections.1.diameter"}
    del document["measures"]
    design = solve(from_dict(document))
    assert design.status == "met"
    (_, low), (high, _) = [(one.value, other.value) for one, other in design.found]
    for wide, speed in ((low, 1000.0), (high, 1100.0)):
        there = {**friswell(sections=[{"length": "1.5 m", "diameter": f"{wide!r} m"}]), "links": held(2e7, 2e4)}
        assert asked(there, c={"response": "critical_speed"})["c"] == pytest.approx(speed * RPM, rel=1e-8)


def test_bearings_that_whirl_least() -> None:
    document = friswell()
    for link in document["links"].values():
        link["damping"] = {"from": "1 kN s/m", "to": "100 kN s/m"}
    document["goal"] = {"minimise": "displacement", "of": "second"}
    del document["measures"]
    design = solve(from_dict(document))
    assert design.status == "feasible"
    best = design.goal[1].value
    for c in (2e3, 1e4, 5e4):
        there = {**friswell(), "links": held(1e6, c)}
        assert asked(there, m={"response": "displacement", "of": "second"})["m"] >= best * (1.0 - 1e-9)


# What is refused

HEAD = """title = "t"
[rotors.r]
modulus = "200 GPa"
density = "7800 kg/m3"
"""
TAIL = """[links.a]
between = ["left", "ground"]
stiffness = "1 MN/m"
[links.b]
between = ["right", "ground"]
stiffness = "1 MN/m"
[excitations.u]
kind = "unbalance"
on = "left"
unbalance = "1 g m"
speed = "1000 rpm"
[measures.m]
response = "displacement"
of = "left"
"""
SHAFT = 'sections = [{ length = "1 m", diameter = "50 mm" }]\nstations = { left = "0 m", right = "1 m" }\n'
REFUSED = {
    "a negative diameter": (
        HEAD + SHAFT.replace("50 mm", "-50 mm") + TAIL,
        't line 5: rotors.r.sections[1].diameter = "-50 mm" is not greater than zero. Write a positive value, for '
        'example "20 mm".',
    ),
    "a bore wider than the shaft": (
        HEAD + SHAFT.replace('"50 mm"', '"50 mm", inner_diameter = "60 mm"') + TAIL,
        "t line 5: rotors.r.sections[1] is as wide inside as outside, or wider: nothing is left to bend. Write a "
        "smaller inner diameter.",
    ),
    "a disc beyond the shaft": (
        HEAD + SHAFT + 'discs = [{ name = "fan", at = "1.2 m", mass = "3 kg" }]\n' + TAIL,
        "t line 7: rotors.r has fan at 1.2 m, beyond the end of its shaft at 1 m. Write a place on the shaft, or "
        "longer sections.",
    ),
    "a shaft that is not held": (
        HEAD + SHAFT + TAIL.replace('[links.b]\nbetween = ["right", "ground"]\nstiffness = "1 MN/m"\n', ""),
        "t line 2: rotors.r is not held: springs at its stations leave it free to move or to tilt. Let links or "
        "bearings with a stiffness end at two of its stations, and lead to the ground.",
    ),
    "a force": (
        HEAD + SHAFT + TAIL.replace('"unbalance"', '"force"').replace('unbalance = "1 g m"', 'amplitude = "1 N"'),
        't line 13: excitations.u is of kind "force", beside rotors.r. What is answered is the whirl with the spin, '
        'which an unbalance alone drives. Write kind = "unbalance".',
    ),
    "natural frequencies": (
        HEAD + SHAFT + TAIL.replace('"displacement"\nof = "left"', '"natural_frequency"'),
        "t line 18: measures.m asks for the natural_frequency, but the modes of rotors.r change with its speed. Write "
        'response = "critical_speed".',
    ),
    "a separation": (
        HEAD + SHAFT + TAIL.replace('"displacement"\nof = "left"', '"frequency_separation"'),
        "t line 18: measures.m asks for the frequency_separation, but the modes of rotors.r change with its speed. "
        'Write response = "critical_speed".',
    ),
    "two speeds": (
        HEAD + SHAFT + TAIL + '[excitations.v]\nkind = "unbalance"\non = "right"\nunbalance = "1 g m"\n'
        'speed = "900 rpm"\n',
        "t line 25: excitations.v.speed differs from that of excitations.u, but a rotor spins at one speed. Write the "
        "same for both.",
    ),
    "a high critical speed": (
        HEAD + SHAFT + TAIL.replace('"displacement"\nof = "left"', '"critical_speed"\nmode = 13'),
        "t line 20: measures.m.mode = 13 is beyond the 12 lowest critical speeds, up to which whirls are told. Write "
        "one from 1 to 12.",
    ),
    "a stress of nothing": (
        HEAD + SHAFT + TAIL.replace('"displacement"\nof = "left"', '"bending_stress"'),
        't line 18: measures.m has no of. Add it: of = "shaft".',
    ),
    "a diameter to millimetres": (
        HEAD + SHAFT.replace('"50 mm"', '{ value = "50 mm", tolerance = "0.02 mm" }') + TAIL,
        't line 5: rotors.r.sections[1].diameter = { value = "50 mm", tolerance = "0.02 mm" } has a tolerance that is '
        'no ratio. Write tolerance = "0.04 %".',
    ),
    "one moment of inertia": (
        HEAD + SHAFT + 'discs = [{ name = "fan", at = "0.2 m", mass = "3 kg", polar = "1 kg m2" }]\n' + TAIL,
        't line 7: rotors.r.discs[1] gives one moment of inertia. Write both: diametral = "0.4 kg m2" and polar = "0.8 '
        'kg m2".',
    ),
    "two stations of one name": (
        HEAD + SHAFT + 'discs = [{ name = "left", at = "0.2 m", mass = "3 kg" }]\n' + TAIL,
        "t line 2: rotors.r has two places called left. Give each a name of its own; a disc is a station, too.",
    ),
    "no stations": (
        HEAD + SHAFT.replace('{ left = "0 m", right = "1 m" }', "{}") + TAIL,
        't line 6: rotors.r.stations = {  } names no station. Write stations = { left = "0 mm", right = "800 mm" }.',
    ),
    "a station left of the shaft": (
        HEAD + SHAFT.replace('left = "0 m"', 'left = "-0.1 m"') + TAIL,
        't line 6: rotors.r.stations = { left = "-0.1 m", right = "1 m" } puts left at "-0.1 m", which is left of the '
        'shaft. Write left = "800 mm".',
    ),
    "a body that turns": (
        HEAD + SHAFT + TAIL + '[bodies.wheel]\ninertia = "2 kg m2"\n',
        "t line 21: bodies.wheel turns or moves in space, beside rotors.r, whose whirl is a displacement alike in both "
        "planes. Give it a mass that moves along a line.",
    ),
    "a thread between bars": (
        HEAD
        + SHAFT.replace('diameter = "50 mm" }', 'diameter = "50 mm" }, { length = "1 m", diameter = "1e-9 mm" }')
        + TAIL,
        "t line 2: rotors.r has sections of 1e-12 m and of 0.05 m: where diameters differ by more than a factor of "
        "1000, rounding decides how the shaft bends. Write diameters nearer to each other.",
    ),
    "a diameter without a least one": (
        HEAD + SHAFT.replace('diameter = "50 mm"', 'diameter = { from = "0 mm", to = "50 mm" }') + TAIL,
        "t line 5: rotors.r.sections[1] leaves an end of its diameter open. Write both: "
        'diameter = { from = "40 mm", to = "120 mm" }.',
    ),
    "a diameter without a greatest one": (
        HEAD + SHAFT.replace('diameter = "50 mm"', 'diameter = { from = "50 mm" }') + TAIL,
        "t line 5: rotors.r.sections[1] leaves an end of its diameter open. Write both: "
        'diameter = { from = "40 mm", to = "120 mm" }.',
    ),
    "a threshold without a cause": (
        HEAD + SHAFT + TAIL.replace('"displacement"\nof = "left"', '"stability_threshold"'),
        "t line 18: measures.m asks for the stability_threshold, but no damper turns with a shaft: nothing makes its "
        'whirl grow. Write rotating_damping = "40 N s/m" on a link, or ask for something else.',
    ),
    "a disc that cannot be": (
        HEAD
        + SHAFT
        + 'discs = [{ name = "fan", at = "0.2 m", mass = "3 kg", diametral = "1 kg m2", polar = "2.1 kg m2" }]\n'
        + TAIL,
        "t line 7: rotors.r.discs[1] has a polar moment of inertia of more than twice the diametral one: there is no "
        "such body. A thin disc has twice.",
    ),
    "a disc that could be chosen as none can be": (
        HEAD
        + SHAFT
        + 'discs = [{ name = "fan", at = "0.2 m", mass = "3 kg", diametral = "1 kg m2", polar = { from = "1 kg m2", '
        'to = "2.1 kg m2" } }]\n' + TAIL,
        "t line 7: rotors.r.discs[1] may have a polar moment of inertia of more than twice the diametral one: there is "
        "no such body. A thin disc has twice.",
    ),
    "a tolerance beside a bore": (
        HEAD + SHAFT.replace('"50 mm"', '{ value = "50 mm", tolerance = "2 %" }, inner_diameter = "20 mm"') + TAIL,
        "t line 5: rotors.r.sections[1] has an inner_diameter while its diameter has a tolerance. Write inner_ratio = "
        "0.5 (inner over outer diameter) instead.",
    ),
}


def test_a_rotor_that_cannot_be_read_is_not_taken_for_a_chain_of_bodies() -> None:
    """Several dampers may turn beside a rotor, and its own mistake stands alone."""
    fits = "".join(
        f'[links.{one}]\nbetween = ["{end}", "ground"]\ndamping = "1 N s/m"\nrotating_damping = "2 N s/m"\n'
        for one, end in (("c", "left"), ("d", "right"))
    )
    assert len(refused(from_text, HEAD + SHAFT.replace("50 mm", "-50 mm") + TAIL + fits, name="t").messages) == 1


@pytest.mark.parametrize(("text", "said"), REFUSED.values(), ids=REFUSED)
def test_what_is_refused(text: str, said: str) -> None:
    assert said in refused(from_text, text, name="t").messages


def test_a_bearing_with_a_tolerance_has_its_worst_at_the_softest() -> None:
    text = """
[rotors.r]
modulus = "207 GPa"
density = "7850 kg/m3"
sections = [{ length = "900 mm", diameter = "50 mm" }]
stations = { a = "0 mm", b = "900 mm" }
discs = [{ name = "w", at = "450 mm", mass = "10 kg" }]
[links.one]
between = ["a", "ground"]
stiffness = "30 MN/m"
tolerance = "20 %"
[links.two]
between = ["b", "ground"]
stiffness = "50 MN/m"
[excitations.u]
kind = "unbalance"
on = "w"
unbalance = "600 g mm"
speed = "1480 rpm"
[limits.x]
response = "displacement"
of = "w"
at_most = "1 mm"
"""
    found = solve(from_text(text)).limits["x"].value.value
    softest = text.replace('"30 MN/m"', '"24 MN/m"').replace('tolerance = "20 %"', "")
    assert found == pytest.approx(solve(from_text(softest)).limits["x"].value.value, rel=1e-9)


TOLERANT = """title = "t"
[rotors.r]
modulus = "207 GPa"
density = "7850 kg/m3"
sections = [{ length = "900 mm", diameter = %s, inner_ratio = 0.3 }]
stations = { a = "0 mm", b = "900 mm" }
[[rotors.r.discs]]
name = "w"
at = "300 mm"
outer_diameter = "300 mm"
inner_diameter = "40 mm"
width = %s
density = "7850 kg/m3"
[links.one]
between = ["a", "ground"]
stiffness = "30 MN/m"
[links.two]
between = ["b", "ground"]
stiffness = "50 MN/m"
[limits.slow]
response = "critical_speed"
at_least = "1500 rpm"
[limits.heavy]
response = "total_mass"
at_most = "60 kg"
"""


def test_tolerances_on_the_sizes_of_a_rotor_have_their_worst_at_ends() -> None:
    """A thinner shaft under a wider disc whirls slowest; both wider weigh most."""
    off = '{ value = "%s mm", tolerance = "%s %%" }'
    found = solve(from_text(TOLERANT % (off % (50, 2), off % (40, 5)))).limits
    ends = [solve(from_text(TOLERANT % (f'"{d} mm"', f'"{w} mm"'))).limits for d, w in ((49, 42), (51, 42))]
    assert found["slow"].value.value == pytest.approx(ends[0]["slow"].value.value, rel=1e-9)
    assert found["heavy"].value.value == pytest.approx(ends[1]["heavy"].value.value, rel=1e-9)
    shaft = 7850.0 * 0.25 * math.pi * 0.051**2 * (1.0 - 0.3**2) * 0.9
    disc = 7850.0 * 0.25 * math.pi * (0.3**2 - 0.04**2) * 0.042
    assert ends[1]["heavy"].value.value == pytest.approx(shaft + disc, rel=1e-12)


# Balancing by the model


def test_a_rotor_is_balanced_by_its_model_as_one_that_was_measured() -> None:
    """What the plan is said to leave at each speed is what the machine as built does with both unbalances."""
    document = friswell()
    document["links"] = held(2e6, 3e3)
    document["limits"] = {
        "first": {"response": "displacement", "of": "first", "at_most": "1 mm"},
        "slow": {"response": "displacement", "of": "second", "over": "100..600 rpm", "at_most": "0.5 mm"},
    }
    scene = from_dict(document)
    written = balancing_document(solve(scene))
    slow = [float(row["speed"].split()[0]) for name, row in written["limits"].items() if name != "first"]
    assert len(slow) >= 9
    assert all(100.0 <= one <= 600.0 for one in slow)
    speeds = np.array([float(run["speed"].split()[0]) for run in written["runs"]])
    worst = solve(scene).limits["first"]
    assert np.abs(speeds / (worst.worst_at["imbalance"].value / RPM) - 1.0).min() < 1e-3  # the peak, or one beside it
    assert (np.diff(speeds) > 0.01 * speeds[:-1]).all()  # or a meter would count them as one
    written["planes"]["first"]["keep"] = True
    plan = answer(job_from_text(document_toml(written)))
    assert plan.status == "optimal"
    fitted = plan.to_json()["planes"]["second"]
    weight = fitted["unbalance"]["value"] * np.exp(1j * fitted["angle"]["value"])
    machine, left = machine_of(scene, {}), []
    for run in written["runs"]:
        omega = np.array([float(run["speed"].split()[0]) * RPM])
        forces = {"first": 1e-3 * omega**2 + 0j, "second": weight * omega**2}
        points = machine.shake(omega, forces, {}).points
        left += [abs(points[name][0]) for name in ("first", "second")]
    assert max(left) == pytest.approx(plan.goal[1].value, rel=1e-8)
    for missing, said in (
        ({"limits": {}, "measures": {"m": {"response": "critical_speed"}}}, "no displacement is asked, and balancing"),
        ({"rotors": {"rotor": {**document["rotors"]["rotor"], "discs": []}}}, "no rotor has a disc that could take"),
    ):
        other = {**document, **missing}
        if "rotors" in missing:
            other["excitations"]["imbalance"]["on"] = "left"
            other["measures"], other["limits"] = {"m": {"response": "displacement", "of": "left"}}, {}
        with pytest.raises(InputError, match=said):
            balancing_document(solve(from_dict(other)))
    fast = {"response": "velocity", "of": "first", "at_most": "1 mm/s"}
    with pytest.raises(
        InputError, match=r"limits\.fast asks for the velocity, and a balancing job limits displacements"
    ):
        balancing_document(solve(from_dict({**document, "limits": {"fast": fast}})))
    two = {"again": {"kind": "unbalance", "on": "second", "unbalance": "1 g m", "speed": "100..4000 rpm"}}
    excitations = {**document["excitations"], **two}
    summed = {"response": "displacement", "of": "first", "at_most": "1 mm", "combine": "sum"}
    with pytest.raises(InputError, match="has several unbalances, and nothing says at which angles they stand"):
        balancing_document(
            solve(from_dict({**document, "excitations": excitations, "limits": {"m": summed}, "measures": {}}))
        )


def test_a_rotor_that_is_hardly_damped_is_balanced_at_its_critical_speed() -> None:
    """Damping of 1e-5 of critical and less: rounding moves the peak by more than the routes differ elsewhere."""
    document = friswell()
    document["links"] = {**held(2e6), "oil": {"between": ["first", "ground"], "damping": "0.02 N s/m"}}
    written = balancing_document(solve(from_dict(document)))
    readings = [float(run["readings"]["first"].split()[0]) for run in written["runs"]]
    assert max(readings) > 1e4 * sorted(readings)[len(readings) // 2]


@given(st.floats(0.05, 1.0), st.sampled_from(["d0", "d2"]))
def test_what_keeps_the_limits_of_a_balancing_job_does_so_at_every_speed(part: float, name: str) -> None:
    """Also weights that do as much as they can at some speed between; whirls by the machine as built."""
    scene, written, speeds = _over_speed()
    bounds, machine = {"d0": 4e-5, "d2": 6e-5}, machine_of(scene, {})
    listed: dict[tuple[str, str], list[complex]] = {}
    for row in written["influence"]:
        size, angle = (float(one.split()[0]) for one in row["value"].split(" @ "))
        listed.setdefault((row["speed"], row["sensor"]), []).append(1e3 * size * np.exp(1j * np.radians(angle)))
    most = {row["at"]: float(row["at_most"].split()[0]) * 1e-3 for row in written["limits"].values()}
    assert all(0.94 * bounds[one] < value < bounds[one] for one, value in most.items())
    rows = np.array([np.array(row) / most[of] for (_, of), row in listed.items() if of in most])

    def does(at: Any, weights: Any) -> Any:
        forces = {f"d{i}": one * at**2 for i, one in enumerate(weights)}
        return machine.shake(at, forces, {}).points

    at = np.array([part * speeds[-1]])
    here = np.array([does(at, one)[name][0] for one in np.eye(3, dtype=complex)])
    share, weights = np.ones(len(rows)), np.zeros(3, dtype=complex)
    for _ in range(60):
        weights = np.linalg.solve((rows.conj().T * share) @ rows, here.conj())
        felt = np.abs(rows @ weights)
        share = np.maximum(share * felt / felt.max(), 1e-12)
    points = does(speeds, weights / np.abs(rows @ weights).max())
    for one, bound in bounds.items():
        assert np.abs(points[one]).max() <= bound * (1.0 + 1e-9)


@cache
def _over_speed() -> tuple[Any, Any, Any]:
    """A rotor of three discs through two critical speeds, its balancing job, and many speeds [rad/s]."""
    discs = [
        {"name": f"d{i}", "at": f"{at} m", "mass": "20 kg", "diametral": "0.2 kg m2", "polar": "0.4 kg m2"}
        for i, at in enumerate((0.3, 0.7, 1.1))
    ]
    held = {"stiffness": "20 MN/m", "damping": "6 kN s/m"}
    scene = from_dict(
        {
            "title": "overspeed",
            "rotors": {
                "rotor": {
                    "sections": [{"length": "1.4 m", "diameter": "70 mm"}],
                    "discs": discs,
                    "stations": {"left": "0 m", "right": "1.4 m"},
                    "modulus": "207 GPa",
                    "density": "7850 kg/m3",
                }
            },
            "links": {name: {"between": [name[:-1], "ground"], **held} for name in ("leftb", "rightb")},
            "excitations": {"u": {"kind": "unbalance", "on": "d1", "unbalance": "1 g m", "speed": "0..12000 rpm"}},
            "limits": {
                "one": {"response": "displacement", "of": "d0", "at_most": "40 um"},
                "two": {"response": "displacement", "of": "d2", "at_most": "60 um"},
            },
        }
    )
    between = np.linspace(1.0, 12000.0 * RPM, 4_001)
    return scene, balancing_document(solve(scene)), between
