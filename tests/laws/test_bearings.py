"""Rotors in bearings that are not alike in both planes: closed forms, both routes, what grows, and what is refused."""

from __future__ import annotations

import json
import math
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from refusals import refused
from test_rotors import HEAD, NONE, RPM, SHAFT, TAIL, asked, friswell, held, light
from vibopt.cli.picture_command import _picture
from vibopt.document.toml_writing import document_toml
from vibopt.forms.whirling import WhirlThreshold
from vibopt.jobs import answer
from vibopt.jobs import from_text as job_from_text
from vibopt.mechanics import orbits
from vibopt.mechanics.free_whirls import synchronous
from vibopt.mechanics.growth import first_growth
from vibopt.mechanics.orbiting import OrbitingMachine
from vibopt.mechanics.orbits import spun
from vibopt.program.pose import form_of, on_needed, pose
from vibopt.report.campbell import campbell_of
from vibopt.report.curves import panels
from vibopt.report.figures.campbell_diagram import campbell_figure
from vibopt.report.figures.response_curves import response_figure
from vibopt.report.modelled_balancing import balancing_document
from vibopt.responses import KINDS
from vibopt.scene.assemble import model_of
from vibopt.scene.read import from_dict, from_text, read
from vibopt.scene.space import members
from vibopt.solve import solve
from vibopt.units import to_unit
from vibopt.verify.as_built import machine_of
from vibopt.verify.certify import measure

BENDING = 200e9 * math.pi * 0.04**4 / 64.0
KEYS = ("k_yy", "k_yz", "k_zy", "k_zz", "c_yy", "c_yz", "c_zy", "c_zz")


def numbers(*eight: float) -> dict[str, str]:
    said = {key: f"{one!r} N{' s' * (key[0] == 'c')}/m" for key, one in zip(KEYS, eight, strict=True)}
    pair = {"yz": "zy", "zy": "yz"}
    value = dict(zip(KEYS, eight, strict=True))
    return {key: one for key, one in said.items() if value[key] or value[key[:2] + pair.get(key[2:], key[2:])]}


def borne(document: dict[str, Any], *eight: float, **table: Any) -> dict[str, Any]:
    """The rotor with both of its bearings exchanged for ones of eight coefficients, or of a table."""
    said = table or numbers(*eight)
    both = {f"{end}_film": {"between": [end, "ground"], **said} for end in ("left", "right")}
    return {**document, "links": {}, "bearings": both}


def grounded(document: dict[str, Any], place: str) -> dict[str, Any]:
    """The machine on a base at rest in place of the ground, or on the ground."""
    stood = json.loads(json.dumps(document).replace('"ground"', f'"{place}"'))
    return stood if place == "ground" else {**stood, "bases": {place: {}}}


def at(document: dict[str, Any], speed: str) -> dict[str, Any]:
    shaker = {**document["excitations"]["imbalance"], "speed": speed}
    return {**document, "excitations": {"imbalance": shaker}}


STEADY = (4e6, 7e5, 7e5, 9e6, 3e3, 2e2, 2e2, 6e3)


def threshold_of(document: dict[str, Any], **bound: str) -> dict[str, Any]:
    """Its threshold alone, as a measure, or as a limit."""
    asked_for = {"m": {"response": "stability_threshold", **bound}}
    return {**document, "measures": {}, "limits": {}, "limits" if bound else "measures": asked_for}


# Closed forms


@pytest.mark.parametrize("eight", [
    (4e6, 0.0, 0.0, 9e6, 3e3, 0.0, 0.0, 2e3),
    (4e6, 7e5, -4e5, 9e6, 3e3, 2e2, 2e2, 6e3),
    (2e6, 0.0, 0.0, 9e6, 0.0, 0.0, 0.0, 0.0),
])  # fmt: skip
@pytest.mark.parametrize("speed", [700.0, 1250.0, 1700.0])
def test_a_disc_between_bearings_goes_round_on_the_ellipse_of_the_closed_form(eight: Any, speed: float) -> None:
    """(K - m w^2) u = e w^2 (1, -i), K of the shaft and twice a bearing in series; half axes are singular values."""
    omega, unit = speed * RPM, np.eye(2)
    film = np.array(eight[:4]).reshape(2, 2) + 1j * omega * np.array(eight[4:]).reshape(2, 2)
    series = np.linalg.inv(unit / (48.0 * BENDING) + np.linalg.inv(2.0 * film))
    moved = np.linalg.solve(series - 20.0 * omega**2 * unit, 2e-3 * omega**2 * np.array([1.0, -1j]))
    force = film @ np.linalg.solve(2.0 * film, series @ moved)
    right = [np.linalg.svd(np.array([one.real, one.imag]), compute_uv=False)[0] for one in (moved, force)]
    found = asked(
        at(borne(light(), *eight), f"{speed!r} rpm"),
        disc={"response": "displacement", "of": "disc"},
        film={"response": "transmitted_force", "through": "left_film"},
    )
    assert [found["disc"], found["film"]] == pytest.approx(right, rel=1e-7)  # the shaft weighs something, and shears


def test_a_rotor_that_turns_the_other_way_has_couplings_of_the_other_sign() -> None:
    """As the message to a negative speed says: the closed form spun from z to y."""
    eight, omega, unit = (4e5, 9e4, -6e4, 9e5, 3e3, 4e2, 2e2, 6e3), 1250.0 * RPM, np.eye(2)
    film = np.array(eight[:4]).reshape(2, 2) + 1j * omega * np.array(eight[4:]).reshape(2, 2)
    series = np.linalg.inv(unit / (48.0 * BENDING) + np.linalg.inv(2.0 * film))
    moved = np.linalg.solve(series - 20.0 * omega**2 * unit, 2e-3 * omega**2 * np.array([1.0, 1j]))
    right = np.linalg.svd(np.array([moved.real, moved.imag]), compute_uv=False)[0]
    other = (eight[0], -eight[1], -eight[2], eight[3], eight[4], -eight[5], -eight[6], eight[7])
    disc = {"response": "displacement", "of": "disc"}
    found = [asked(at(borne(light(), *one), "1250 rpm"), disc=disc)["disc"] for one in (other, eight)]
    assert found[0] == pytest.approx(right, rel=1e-7)
    assert abs(found[1] / right - 1.0) > 0.01


def test_bearings_alike_in_both_planes_are_the_links_that_they_are() -> None:
    """By a table of two like rows, which is answered in both planes, and by numbers, which is not."""
    measures = {
        "whirl": {"response": "displacement", "of": "second"},
        "force": {"response": "transmitted_force", "into": "ground"},
        "stress": {"response": "bending_stress", "of": "rotor"},
    }
    plain = {**friswell(), "links": held(2e6, 3e3)}
    rows = [{"speed": speed, "k_yy": "2 MN/m", "k_zz": "2 MN/m", "c_yy": "3 kN s/m", "c_zz": "3 kN s/m"}
            for speed in ("0 rpm", "4000 rpm")]  # fmt: skip
    right = asked(plain, **measures)
    for document in (borne(friswell(), table=rows), borne(friswell(), 2e6, 0.0, 0.0, 2e6, 3e3, 0.0, 0.0, 3e3)):
        assert asked(document, **measures) == pytest.approx(right, rel=1e-12)
        assert bool(model_of(from_dict({**document, "measures": measures})).bearings) == ("table" in str(document))


@pytest.mark.parametrize("document", [friswell(), borne(friswell(), *STEADY)], ids=["whirl", "orbit"])
def test_a_rotor_on_a_base_at_rest_stands_on_the_ground(document: dict[str, Any]) -> None:
    def found(place: str) -> dict[str, float]:
        whirl = {"response": "displacement", "of": "second"}
        return asked(grounded(document, place), whirl=whirl, force={"response": "transmitted_force", "into": place})

    assert found("floor") == found("ground")


@pytest.mark.parametrize("drive", [60.0, 240.0])
def test_a_film_that_drives_the_whirl_does_so_beyond_the_closed_form(drive: float) -> None:
    """Cross-coupling a W of a film with damping c: neutral where c w = a W, at the frequency w of disc and springs."""
    stiff, damp, last = 4e6, 900.0, 2000.0
    rows = [{"speed": f"{spin!r} rad/s", **numbers(stiff, drive * spin, -drive * spin, stiff, damp, 0.0, 0.0, damp)}
            for spin in (0.0, last)]  # fmt: skip
    document = at(borne(light(), table=rows), "100 rpm")
    whirl = math.sqrt(1.0 / (1.0 / (48.0 * BENDING) + 1.0 / (2.0 * stiff)) / 20.0)
    right = damp * whirl / drive
    found = asked(document, threshold={"response": "stability_threshold"})["threshold"]
    assert found == (pytest.approx(right, rel=1e-7) if right < last else math.inf)


@pytest.mark.parametrize(("loss", "speed"), [(0.02, 500.0), (0.3, 1250.0), (2.0, 2600.0)])
def test_a_loss_factor_beside_films_is_the_damper_of_its_speed(loss: float, speed: float) -> None:
    """It makes no whirl grow, though it would one that went on with time."""
    document = at(borne(friswell(), *STEADY), f"{speed!r} rpm")
    moved = []
    for said in ({"loss_factor": loss}, {"damping": f"{loss * 3e6 / (speed * RPM)!r} N s/m"}):
        foot = {"between": ["second", "ground"], "stiffness": "3 MN/m", **said}
        moved.append(asked({**document, "links": {"foot": foot}}, d={"response": "displacement", "of": "first"})["d"])
    assert moved[0] == pytest.approx(moved[1], rel=1e-9)


def test_a_whirl_that_grows_is_said_once_of_all_that_it_makes_unknown() -> None:
    document = at(borne(friswell(), 1e6, 2e5, -1e5, 1.5e6, 200.0, 0.0, 0.0, 300.0), "100..3000 rpm")
    places = {name: {"response": "displacement", "of": name} for name in ("first", "second", "left")}
    claim = solve(from_dict({**document, "measures": places})).claim
    assert claim.count("is not known") == 1
    assert claim.endswith("; nor is second; nor is left")


def test_values_at_which_every_whirl_grows_from_another_spin_on_are_unproven() -> None:
    disc = {"name": "d", "at": "0.4 m", "mass": "20 kg", "diametral": "0.2 kg m2", "polar": "0.35 kg m2"}
    document = friswell(
        sections=[{"length": "0.9 m", "diameter": {"from": "30 mm", "to": "45 mm"}}],
        stations={"left": "0 m", "right": "0.9 m"}, discs=[disc],
    )  # fmt: skip
    film = {"between": ["left", "ground"], **numbers(20e6, 6e6, -6e6, 30e6, 15e3, 0.0, 0.0, 18e3)}
    document |= {
        "bearings": {"film": film},
        "links": {"right_bearing": held(3e7, 3e3)["right_bearing"]},
        "measures": {},
    }
    document["excitations"]["imbalance"] |= {"on": "d", "speed": "3000..4000 rpm"}
    document["limits"] = {"far": {"response": "displacement", "of": "d", "at_most": "1 mm"}}
    design = solve(from_dict({**document, "goal": {"find_all": "rotors.rotor.sections.1.diameter"}}))
    assert (design.status, design.found) == ("unproven", None)
    assert "beyond its stability threshold of 0 rpm" in design.claim


# Both routes

SIGNED = st.integers(-300, 300)


@given(
    springs=st.tuples(*[st.floats(1e6, 4e7)] * 2), dampers=st.tuples(*[st.floats(1e3, 4e4)] * 2),
    crossed=st.tuples(*[SIGNED] * 2), drags=st.tuples(*[SIGNED] * 2), turning=st.floats(1.0, 200.0),
)  # fmt: skip
@settings(max_examples=16)
def test_orbits_forces_stresses_and_thresholds_are_those_of_waves_in_both_planes(
    springs: Any, dampers: Any, crossed: Any, drags: Any, turning: float
) -> None:
    """On pedestals, with a seal, and with a fit that turns with the shaft."""
    document = friswell()
    film = numbers(springs[0], *(1e3 * one for one in crossed), springs[1], dampers[0], *drags, dampers[1])
    document["bodies"] = {"pedestal": {"mass": "40 kg"}}
    document["links"] = {
        "foot": {"between": ["pedestal", "ground"], "stiffness": "60 MN/m", "damping": "4 kN s/m"},
        "seal": {"between": ["second", "ground"], "damping": "0.3 kN s/m", "rotating_damping": f"{turning!r} N s/m"},
    }
    document["bearings"] = {
        "left_film": {"between": ["left", "pedestal"], **film},
        "right_film": {"between": ["right", "ground"], **film},
    }
    document["measures"] = {
        "orbit": {"response": "displacement", "of": "first"},
        "film": {"response": "transmitted_force", "through": "left_film"},
        "floor": {"response": "transmitted_force", "into": "ground"},
        "stretch": {"response": "relative_displacement", "across": "left_film"},
        "least": {"response": "velocity", "of": "second", "worst": "least"},
        "stress": {"response": "bending_stress", "of": "rotor", "at": "2000 rpm"},
        "threshold": {"response": "stability_threshold"},
    }
    scene = from_dict(document)
    model = model_of(scene)
    for response in scene.measures.values():
        side = response.worst_side
        values = []
        for each in members(scene, response):
            needed, form = on_needed(scene, model, each)
            values.append(form.worst(needed, NONE, least_wanted=side == "at_least").value)
        best = max(values)
        assert measure(scene, {}, response, side).value == pytest.approx(best, rel=1e-8), response.response


def test_what_is_found_through_whirls_is_what_all_coordinates_say() -> None:
    """Also where a speed is that of a whirl of the shaft held in both planes alike, unknown to the whole."""
    scene = from_dict(borne(friswell(), 1e6, 2e5, -1e5, 3e6, 3e3, 0.0, 0.0, 5e3))
    model = model_of(scene)
    rotor, load = spun(model, NONE), model.points["first"]
    own = 1.0 / np.sqrt(rotor._whirls[0][0][-3:])
    speeds = np.concatenate([[60.0, 400.0], own])
    lines = np.array([model.points["second"], model.points["right"]])
    n = len(load)
    for k, one in enumerate(speeds):
        motion = np.linalg.solve(rotor.dynamic(one, one), np.concatenate([load, np.zeros(n)]))
        right = np.stack([lines @ half for half in np.split(motion, 2)])
        assert np.allclose(rotor.seen(lines, load, speeds)[:, k], right, rtol=1e-9, atol=1e-12 * np.abs(right).max())


# Growth


@pytest.mark.parametrize("centre", [0.3, 17.3, 900.0])
def test_no_window_of_growth_is_stepped_over(centre: float) -> None:
    """Two motions, one of which gives what the other takes, grow within a thousandth of where they are as fast."""
    pull, fade = 1e-3, 0.9e-3
    first = np.array([[-fade, pull], [pull, -fade - 1j * centre]], dtype=complex)
    slope = np.array([[0.0, 0.0], [0.0, 1j]])
    begins = centre - 2.0 * math.sqrt(pull**2 - fade**2)
    assert first_growth(first, slope, 0.0, 1e3, 1e-3) == pytest.approx(begins, rel=1e-6)
    first[0, 0] = first[1, 1].real - 1e-3
    first[1, 1] -= 1e-3
    assert first_growth(first, slope, 0.0, 1e3, 1e-3) is None


def test_a_rotor_beyond_its_threshold_has_no_steady_answer() -> None:
    document = borne(friswell(), 1e6, 2e5, -1e5, 1.5e6, 200.0, 0.0, 0.0, 300.0)
    design = solve(from_dict(document))
    assert design.status == "violated"
    assert design.claim.startswith(
        "first is not known: excitations.imbalance spins the rotor up to 4000 rpm, beyond its stability threshold of "
    )


def test_a_window_of_growth_that_is_passed_is_told_as_one() -> None:
    """A film that drives the whirl at 3001 rpm alone: at 5000 rpm nothing grows, but it comes by there."""
    calm, wild = (6e6, 1e5, -1e5, 8e6, 1e4, 0.0, 0.0, 1e4), (6e6, 4e6, -4e6, 8e6, 1e3, 0.0, 0.0, 1e3)
    rows = [(500, calm), (3000, calm), (3001, wild), (3002, calm), (9000, calm)]
    table = [{"speed": f"{speed} rpm", **numbers(*eight)} for speed, eight in rows]
    design = solve(from_dict(at(borne(friswell(), table=table), "5000 rpm")))
    assert design.status == "violated"
    assert design.claim.startswith("first is not known: excitations.imbalance spins the rotor up to 5000 rpm, beyond ")
    assert " of 3000." in design.claim
    assert panels(design) == []  # nothing steady is drawn
    assert design.claim.endswith(
        " rpm, from which on a whirl grows without end, though none does at 5000 rpm itself. Look at lower speeds"
    )


IDLE = (4e6, 7e5, 7e5, 9e6, 3e3, 2e2, -9e2, 6e3)
"""Springs with a potential; dampers that take energy, beside a part that does no work."""
TABLED = [{"speed": "0 rpm", **numbers(*IDLE)}, {"speed": "8000 rpm", **numbers(*(0.4 * one for one in IDLE))}]


@settings(max_examples=6)
@given(st.tuples(*[st.floats(-1.0, 1.0)] * 3), st.tuples(*[st.floats(-1.0, 1.0)] * 3), st.floats(-2e3, 2e3))
def test_what_nothing_feeds_never_grows_and_is_not_searched(springs: Any, dampers: Any, turned: float) -> None:
    """R^T R of springs and of dampers, any at all: no free motion of all coordinates grows, and none is looked for."""
    (a, b, c), (d, e, f) = springs, dampers
    k, k_yz, k_zz = 1e6 * (3.0 + a * a), 1e6 * a * b, 1e6 * (1.0 + b * b + c * c)
    damp = [1e4 * one for one in (d * d, d * e, e * e + f * f)]
    eight = (k, k_yz, k_yz, k_zz, damp[0], damp[1] + turned, damp[1] - turned, damp[2])
    document = borne(friswell(), *eight)
    scene = from_dict(document)
    rotor = spun(on_needed(scene, pose(scene).model, scene.measures["first"])[0], np.zeros(0))
    assert rotor.threshold() == math.inf
    for spin in (1.0, 300.0, 4e3):
        rates = rotor.rates(spin)
        assert np.linalg.eigvals(rates).real.max() < 1e-9 * rotor.slowest
    found = solve(from_dict(threshold_of(document))).measures["m"].value
    assert (found.value, found.shown) == (math.inf, "none")


@pytest.mark.parametrize(("bearing", "looked"), [
    (numbers(*IDLE), 0),
    ({"table": TABLED}, 0),
    (numbers(*IDLE[:2], -7e5, *IDLE[3:]), 1),
    (numbers(*IDLE[:4], 1e3, 2.1e3, 2.1e3, 4e3), 1),
    ({"table": [*TABLED, {"speed": "9000 rpm", **numbers(*STEADY[:2], -7e5, *STEADY[3:])}]}, 1),
])  # fmt: skip
def test_growth_is_looked_for_only_where_something_may_feed_a_whirl(
    bearing: dict[str, Any], looked: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each of the routes by itself: a skew stiffness, or dampers of which a motion takes energy."""
    calls: dict[str, list[float]] = {"model": [], "built": []}

    def first(*args: Any) -> Any:
        calls["model"].append(args[2])
        return first_growth(*args)

    def growth(machine: OrbitingMachine, spin: float) -> tuple[float, float]:
        calls["built"].append(spin)
        return own(machine, spin)

    own = OrbitingMachine._growth
    monkeypatch.setattr(orbits, "first_growth", first)
    monkeypatch.setattr(OrbitingMachine, "_growth", growth)
    both = {f"{end}_film": {"between": [end, "ground"], **bearing} for end in ("left", "right")}
    solve(from_dict(threshold_of({**friswell(), "links": {}, "bearings": both})))
    assert [bool(one) for one in calls.values()] == [bool(looked)] * 2
    if "table" in bearing and looked:
        assert min(calls["model"]) == pytest.approx(8000.0 * RPM)  # from the last row on which nothing feeds it


def test_a_threshold_that_a_search_did_not_find_is_said_with_how_far_it_went() -> None:
    document = borne(friswell(), 1e6, 2e5, -1e5, 1.5e6, 200.0, 0.0, 0.0, 300.0)
    far = float(solve(from_dict(threshold_of(document))).measures["m"].value.value) / RPM
    asked_for = threshold_of(document, at_least=f"{0.5 * far!r} rpm")
    design = solve(from_dict(asked_for))
    assert (design.status, design.limits["m"].value.shown) == ("met", f"none up to {0.75 * far:.4g} rpm")


def test_a_shaft_keeps_the_whirl_that_grows_however_slowly_it_runs() -> None:
    disc = {"name": "first", "at": "0.5 m", "mass": "40 kg", "diametral": "0.6 kg m2", "polar": "1.1 kg m2"}
    sections, stations = [{"length": "1 m", "diameter": "60 mm"}], {"left": "0 m", "right": "1 m"}
    slender = friswell(sections=sections, stations=stations, discs=[disc], modulus="207 GPa", density="7850 kg/m3")
    del slender["rotors"]["rotor"]["shear_modulus"]
    document = at(borne(slender, 3e7, 0.0, 0.0, 6e7, 2e4, 0.0, 0.0, 2e4), "1000 rpm")
    document["links"] = {"fit": {"between": ["first", "ground"], "rotating_damping": "40 N s/m", "damping": "1 mN s/m"}}
    assert solve(from_dict(threshold_of(document))).status == "met"


def test_nothing_is_judged_beyond_the_end_of_a_table() -> None:
    rows = [{"speed": "0 rpm", **numbers(*STEADY)}, {"speed": "8000 rpm", **numbers(*STEADY)}]
    document = borne(friswell(), table=rows)
    assert solve(from_dict(threshold_of(document))).measures["m"].value.shown == "none up to 8000 rpm"
    assert from_dict(threshold_of(document, at_least="8000 rpm")).limits
    assert refused(from_dict, threshold_of(document, at_least="8001 rpm"), name="t").messages == (
        "t: limits.m.at_least is 8001 rpm, but the table of bearings.left_film ends at 8000 rpm: whether a whirl grows "
        "beyond is not known. Write more rows, or 8000 rpm at most.",
    )


# Tables


def test_a_table_is_straight_between_its_rows_and_may_be_a_file(tmp_path: Path) -> None:
    rows = [(500.0, 2e6, 5e6), (2000.0, 4e6, 9e6), (5000.0, 5e6, 8e6)]
    listed = [{"speed": f"{speed!r} rpm", **numbers(y, 0, 0, z, 3e3, 0, 0, 4e3)} for speed, y, z in rows]
    question = {"m": {"response": "displacement", "of": "second"}}
    there = asked(at(borne(friswell(), table=listed), "1250 rpm"), **question)
    between = asked(at(borne(friswell(), 3e6, 0, 0, 7e6, 3e3, 0, 0, 4e3), "1250 rpm"), **question)
    assert there["m"] == pytest.approx(between["m"], rel=1e-12)
    lines = ["speed [rpm];k_yy [MN/m];k_zz [MN/m];c_yy [kN s/m];c_zz [kN s/m]"]
    lines += [f"{speed:g};{y / 1e6:g};{z / 1e6:g};3;4".replace(".", ",") for speed, y, z in rows]
    (tmp_path / "film.csv").write_text("\n".join(lines), encoding="utf-8")
    (tmp_path / "rotor.toml").write_text(
        HEAD + SHAFT + TAIL.replace("[links", "[bearings").replace('stiffness = "1 MN/m"', 'table = "film.csv"'),
        encoding="utf-8",
    )
    assert len(model_of(read(tmp_path / "rotor.toml")).bearings[0].speeds) == 3


def test_every_speed_at_which_an_orbit_keeps_its_bound_is_found() -> None:
    document, place = borne(friswell(), 4e6, 0, 0, 9e6, 3e3, 0, 0, 2e3), {"response": "displacement", "of": "first"}
    speeds = np.linspace(300.0, 4000.0, 21)
    values = asked(document, **{f"m{n:g}": {**place, "at": f"{n} rpm"} for n in speeds})
    document["excitations"]["imbalance"]["speed"] = {"from": "300 rpm", "to": "4000 rpm"}
    document["limits"] = {"move": {**place, "at_most": "0.2 mm"}}
    found = solve(from_dict({**document, "goal": {"find_all": "imbalance.speed"}})).found
    good = [value <= 2e-4 for value in values.values()]
    inside = [any(low.value <= n * RPM <= high.value for low, high in found) for n in speeds]
    assert 0 < sum(good) < len(good)
    assert inside == good
    ends = [end.value for pair in found for end in pair if 301.0 * RPM < end.value < 3999.0 * RPM]
    there = {f"m{i}": {**place, "at": f"{n!r} rad/s"} for i, n in enumerate(ends)}
    del document["limits"]
    document["excitations"]["imbalance"]["speed"] = "3000 rpm"
    assert list(asked(document, **there).values()) == pytest.approx([2e-4] * len(ends), rel=1e-6)


def test_bearings_that_whirl_least_are_chosen() -> None:
    document = borne(light(), 4e6, 0, 0, 9e6, 3e3, 0, 0, 2e3)
    document["excitations"]["imbalance"]["speed"] = "200..2500 rpm"
    for bearing in document["bearings"].values():
        bearing["c_yy"] = bearing["c_zz"] = "3 kN s/m"
    document["bearings"]["left_film"]["c_yy"] = {"from": "1 kN s/m", "to": "200 kN s/m"}
    document["goal"] = {"minimise": "displacement", "of": "disc"}
    design = solve(from_dict(document))
    assert design.status == "optimal", design.claim
    best, chosen = design.goal[1].value, design.variables["bearings.left_film.c_yy"].value.value
    for part in (0.5, 0.9, 1.1, 2.0):
        other = {**document, "bearings": {**document["bearings"]}}
        other["bearings"]["left_film"] = {**document["bearings"]["left_film"], "c_yy": f"{part * chosen!r} N s/m"}
        del other["goal"]
        assert asked(other, m={"response": "displacement", "of": "disc"})["m"] >= best * (1.0 - 1e-9)


# What is refused

FILM = '[bearings.f]\nbetween = ["left", "ground"]\nk_yy = "1 MN/m"\nk_zz = "2 MN/m"\n'
REST = TAIL.replace('[links.a]\nbetween = ["left", "ground"]\nstiffness = "1 MN/m"\n', FILM)
ROWS = '\ntable = [{ speed = "0 rpm", k_yy = "1 MN/m", k_zz = "2 MN/m" }, { speed = "%s", k_yy = "1 MN/m" }]\n'
BOTH = FILM.split("k_yy", maxsplit=1)[0]
CRITICAL = REST.replace('"displacement"\nof = "left"', '"critical_speed"')
REFUSED = {
    "no rotor": (
        'title = "t"\n[bodies.b]\nmass = "2 kg"\n' + FILM.replace("left", "b"),
        "t line 4: bearings.f holds a rotor, and there is none. Write [links.f] with a stiffness.",
    ),
    "no station": (
        HEAD
        + SHAFT
        + REST.replace("[bearings.f]", '[bodies.b]\nmass = "2 kg"\n[bearings.f]').replace('"left", "g', '"b", "g'),
        't line 10: bearings.f.between = ["b", "ground"] has no station or disc of a rotor at either end. Name one, or '
        "write a link.",
    ),
    "nothing said": (
        HEAD + SHAFT + REST.replace('k_yy = "1 MN/m"\nk_zz = "2 MN/m"\n', ""),
        't line 7: bearings.f has neither stiffness nor damping. Write k_yy = "80 MN/m" and k_zz = "120 MN/m".',
    ),
    "a material that damps": (
        HEAD + 'material_damping = "0.02 ms"\n' + SHAFT + REST,
        "t line 5: rotors.r.material_damping stands beside bearings.f, which is not alike in both planes: the whirl is "
        "then no circle, and bends every fibre to and fro. Leave it out, or write bearings that are alike.",
    ),
    "one coupling": (
        HEAD + SHAFT + REST.replace('k_zz = "2 MN/m"', 'k_zz = "2 MN/m"\nk_yz = "3 MN/m"'),
        "t line 11: bearings.f gives k_yz without k_zy. Write both: the same where the bearing is symmetric, of "
        "opposite sign where a film drives the whirl.",
    ),
    "a negative stiffness": (
        HEAD + SHAFT + REST.replace('k_yy = "1 MN/m"', 'k_yy = "-1 MN/m"'),
        't line 9: bearings.f.k_yy = "-1 MN/m" is not greater than zero. Write a positive value, for example "2 '
        'MN/m".',
    ),
    "two rows of one speed": (
        HEAD + SHAFT + REST.replace(FILM, BOTH + ROWS % "0 rpm"),
        "t line 7: bearings.f has a table with two rows for 0 rpm. Keep one of them.",
    ),
    "rows that fall": (
        HEAD + SHAFT + REST.replace(FILM, BOTH + (ROWS % "500 rpm").replace('"0 rpm"', '"600 rpm"')),
        "t line 7: bearings.f has a table that falls from 600 rpm to 500 rpm. Sort its rows.",
    ),
    "one row": (
        HEAD + SHAFT + REST.replace(FILM, BOTH + '\ntable = [{ speed = "0 rpm", k_yy = "1 MN/m" }]\n'),
        "t line 7: bearings.f has a table of 1 row, and two at least say something of the speeds between.",
    ),
    "a table and a number": (
        HEAD + SHAFT + REST.replace(FILM, BOTH + 'k_yy = "1 MN/m"' + ROWS % "600 rpm"),
        "t line 7: bearings.f gives table and k_yy. Keep one of them.",
    ),
    "a table that ends": (
        HEAD + SHAFT + REST.replace(FILM, BOTH + (ROWS % "600 rpm").replace("/m\" }]", "/m\", k_zz = \"1 MN/m\" }]")),
        "t line 19: measures.m looks at 1000 rpm, but the tables of bearings, bearings.f among them, say "
        "something of 0 rpm to 600 rpm alone. Write more rows, or look at these speeds.",
    ),
    "a table and a speed that is wrong": (
        (HEAD + SHAFT + REST.replace(FILM, BOTH + (ROWS % "1000 rpm").replace("/m\" }]", "/m\", k_zz = \"1 MN/m\" }]")))
        .replace('speed = "1000 rpm"\n[', 'speed = "-3 mm"\n['),
        't line 18: excitations.u.speed = "-3 mm" is a length, but a speed of rotation or a frequency is needed here. '
        'Write a speed of rotation or a frequency, for example "3000 rpm".',
    ),
    "no table": (
        HEAD + SHAFT + REST.replace(FILM, BOTH + "table = 3\n"),
        "t line 9: bearings.f.table = 3 is neither a list of rows nor the name of a CSV file. Write table = [{ speed = "
        '"1000 rpm", k_yy = "80 MN/m", k_zz = "120 MN/m" }, ...].',
    ),
    "a plane that is free": (
        HEAD + SHAFT + REST.replace('k_yy = "1 MN/m"\n', ""),
        "t line 2: rotors.r is not held: springs at its stations leave it free to move or to tilt in the plane y. Let "
        "links or bearings with a stiffness end at two of its stations, and lead to the ground.",
    ),
    "a sag": (
        HEAD + SHAFT + REST.replace('"displacement"', '"static_deflection"'),
        "t line 19: measures.m asks for the static_deflection, but bearings.f says its stiffness about the place at "
        "which it runs, not under the weight. Leave it out.",
    ),
    "a critical speed": (
        HEAD + SHAFT + CRITICAL.replace(FILM, FILM + 'k_yz = "1 MN/m"\nk_zy = "-1 MN/m"\n'),
        "t line 21: measures.m asks for the critical_speed without dampers, but bearings.f feeds and brakes what goes "
        "round where k_yz is not k_zy: add damped = true.",
    ),
    "a critical speed where bearings push": (
        HEAD + SHAFT + CRITICAL.replace(FILM, FILM + 'k_yz = "1.5 MN/m"\nk_zy = "1.5 MN/m"\n'),
        "t line 21: measures.m asks for the critical_speed without dampers, but bearings.f pushes where k_yz times "
        "k_zy is above k_yy times k_zz: add damped = true.",
    ),
    "a critical speed where bearings change": (
        (HEAD + SHAFT + CRITICAL).replace(
            FILM, BOTH + (ROWS % "2000 rpm").replace("/m\" }]", "/m\", k_zz = \"1 MN/m\" }]")
        ),
        "t line 19: measures.m asks for the critical_speed without dampers, but bearings.f changes with the speed: add "
        "damped = true.",
    ),
    "one number of two planes": (
        HEAD + SHAFT + REST.replace('"displacement"\nof = "left"', '"stiffness"\nof = "f"'),
        "t line 19: measures.m asks for the stiffness of f, but bearings.f says its stiffness along y and z apart, "
        "which is no one number. Ask for every value of k_yy that keeps the limits, by find_all, or for what it does.",
    ),
    "one number of a table": (
        (HEAD + SHAFT + REST.replace('"displacement"\nof = "left"', '"stiffness"\nof = "f"')).replace(
            FILM, BOTH + (ROWS % "2000 rpm").replace("/m\" }]", "/m\", k_zz = \"1 MN/m\" }]")
        ),
        "t line 19: measures.m asks for the stiffness of f, but bearings.f says its stiffness along y and z apart, "
        "which is no one number. Ask for what it does.",
    ),
    "a ratio": (
        HEAD + SHAFT + REST.replace('"displacement"\nof = "left"', '"transmissibility"\ninto = "ground"'),
        "t line 19: measures.m asks for the transmissibility, but in bearings.f, which is not alike in both planes, it "
        "is another along each direction. Ask for the displacement, the transmitted_force or the bending_stress: the "
        "greater half axis of the orbit.",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("text", "said"), REFUSED.values(), ids=REFUSED)
def test_what_is_refused_of_bearings(text: str, said: str) -> None:
    assert said in refused(from_text, text, name="t").messages


SHEETS = {
    "an unknown column": ("speed [rpm];kyy [N/m]\n0;1\n", 'film.csv has a column "kyy". It may have speed, k_yy, k_yz'),
    "no unit": ("speed [rpm];k_yy\n0;1\n", "film.csv has a column k_yy without a unit. Write it behind:"),
    "no speed": ("k_yy [N/m]\n1\n", "film.csv row 2: speed is not there. Write one."),
    "a negative one": ("speed [rpm];k_yy [N/m]\n0;-1\n", 'film.csv row 2: k_yy "-1 N/m" is negative. Write a positive'),
    "nothing": ("", "film.csv is empty. Its first row names the columns:"),
}


@pytest.mark.parametrize(("sheet", "said"), SHEETS.values(), ids=SHEETS)
def test_a_file_of_a_bearing_that_cannot_be_read(sheet: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "film.csv").write_text(sheet, encoding="utf-8")
    (tmp_path / "t.toml").write_text(HEAD + SHAFT + REST.replace(FILM, BOTH + 'table = "film.csv"\n'), encoding="utf-8")
    caught = refused(read, tmp_path / "t.toml")
    assert any(said in one for one in caught.messages), caught.messages


def test_an_orbit_is_drawn_to_scale_and_both_of_its_parts_apart() -> None:
    document = at(borne(friswell(), *STEADY), "2000 rpm")
    both = panels(solve(from_dict(document)))
    figure = response_figure(both)
    assert [panel.to_scale for panel in both] == [False, True]
    curves, orbit = figure.axes
    assert len({(line.get_color(), str(line.get_linestyle())) for line in curves.get_lines()[:3]}) == 3
    figure.draw_without_rendering()
    (left, right), (low, high), box = orbit.get_xlim(), orbit.get_ylim(), orbit.get_window_extent()
    assert (right - left) / box.width == pytest.approx((high - low) / box.height, rel=1e-6)


def test_what_is_told_of_an_orbit_is_said_by_the_kind() -> None:
    told = {name for name, kind in KINDS.items() if kind.in_planes and kind.moves != "axis" and not kind.sags}
    assert {"displacement", "velocity", "acceleration", "transmitted_force", "bending_stress"} <= told


# Pictures


def test_an_orbit_is_drawn_as_far_as_its_greater_half_axis() -> None:
    document = borne(friswell(), 1e6, 2e5, -1e5, 1.5e6, 3e3, 0.0, 0.0, 5e3)
    design = solve(from_dict(document))
    against, orbit = panels(design)
    worst = design.measures["first"].value.value
    half, *parts = against.curves
    assert half.y == pytest.approx(sum(one.y for one in parts))
    path = np.hypot(orbit.curves[0].x, orbit.curves[0].y)
    axis = np.hypot(orbit.curves[1].x, orbit.curves[1].y)
    assert [path.max(), half.y.max()] == pytest.approx([axis[0]] * 2, rel=1e-3)
    assert axis[0] == pytest.approx(to_unit(worst, orbit.y_label[-3:-1], "length"), rel=1e-9)


# Needles


def test_two_routes_differ_at_a_needle_by_what_rounding_carries_there() -> None:
    """A damping ratio of 1e-9: 6e-4 of the peak; where dampers are as usual no more than everywhere."""
    for damping, most in ((0.003, 1.01e-3), (3e3, 1.01e-6)):
        document = at(borne(friswell(), 4e6, 0.0, 0.0, 12.4e6, damping, 0.0, 0.0, 2.0 * damping), "100..4000 rpm")
        design = solve(from_dict(document))
        assert design.status == "met"
        value, model = design.measures["first"].value.value, model_of(design.scene)
        form = form_of(design.scene, model, design.scene.measures["first"])
        room = form.room(model, NONE, value, value, 1e4 * float(np.finfo(float).eps))
        assert room == pytest.approx(most * value, rel=0.02)


def test_slim_peaks_are_where_the_waves_have_them() -> None:
    """As fast as whirls of the model are, by pieces and waves; by the pieces alone they are next to it."""
    scene = from_dict(at(borne(friswell(), 4e6, 0.0, 0.0, 9e6, 0.5, 0.0, 0.0, 1.0), "100..4000 rpm"))
    machine, top = machine_of(scene, {}), 4000.0 * RPM
    speeds = np.array([one.speed for one in synchronous(spun(model_of(scene), NONE), 0.0, top)])
    for poles, close in ((machine.poles_below(top), 1e-8), (machine.known_poles, 1e-4)):
        told = np.unique(np.round(poles.real[(poles.real > 0.0) & (poles.real < top)], 6))
        assert np.abs(told[:, None] / speeds - 1.0).min(axis=0).max() < close


@pytest.mark.parametrize(("diameter", "grows"), [("112.3 mm", True), ("112.45 mm", False)])
def test_both_routes_say_whether_a_whirl_grows_at_the_first_speed_of_a_table(diameter: str, grows: bool) -> None:
    """By 2-node elements of both planes it grows by 0.105 /s at 112.3 mm, and fades at 112.45 mm."""
    text = Path("problems/shafts/compressor_on_tilting_pads.toml").read_text(encoding="utf-8")
    document = {key: one for key, one in tomllib.loads(text).items() if key != "expected"}
    (rotor,) = document["rotors"].values()
    rotor["sections"][1]["diameter"] = diameter
    for name in ("drive_pads", "free_pads"):
        document["bearings"][name]["table"] = str(Path("problems/shafts/tilting_pads.csv").resolve())
    scene, top = from_dict(document), 12000.0 * RPM
    found = machine_of(scene, {}).threshold(top), spun(model_of(scene), NONE).threshold(top)
    assert found == (pytest.approx(1000.0 * RPM, rel=1e-12),) * 2 if grows else found == (math.inf,) * 2


# Balancing by the model

TILTED = [
    {"speed": "100 rpm", "k_yy": "3 MN/m", "k_yz": "0.2 MN/m", "k_zy": "-0.1 MN/m", "k_zz": "6 MN/m",
     "c_yy": "9 kN s/m", "c_zz": "20 kN s/m"},
    {"speed": "5000 rpm", "k_yy": "2 MN/m", "k_yz": "0.1 MN/m", "k_zy": "-0.2 MN/m", "k_zz": "4 MN/m",
     "c_yy": "5 kN s/m", "c_zz": "8 kN s/m"},
]  # fmt: skip


@pytest.mark.parametrize("film", [{"table": TILTED}, numbers(*STEADY)], ids=["table", "numbers"])
def test_weights_that_keep_a_balancing_job_keep_the_half_axis_of_every_orbit(film: dict[str, Any]) -> None:
    """Put back onto the rotor as further unbalances, over the whole range of speeds; one disc alone is not enough."""
    document = borne(friswell(), **film)
    document["measures"], document["excitations"] = {}, document["excitations"] | {}
    shaker = {"kind": "unbalance", "on": "first", "unbalance": "2 g m", "speed": "700..2500 rpm"}

    def run(*weights: tuple[str, float, float]) -> Any:
        also = [{"on": on, "unbalance": f"{size!r} kg m", "angle": f"{turn!r} rad"} for on, size, turn in weights]
        bounds = {name: {"response": "displacement", "of": name, "at_most": "0.1 mm"} for name in ("first", "second")}
        return solve(from_dict({**document, "limits": bounds, "excitations": {"imbalance": {**shaker, "also": also}}}))

    found = ("second", 1.5e-3, 2.1)
    before = run(found)
    assert before.status == "violated"
    written = balancing_document(before)
    assert written["sensors"]["first_backward"] == {"added_to": "first_forward"}
    assert written["statement"].endswith(
        "so that they hold at every speed of their ranges. Forward and backward whirl of a place add up to the greater "
        "half axis of its orbit."
    )
    plan = answer(job_from_text(document_toml({**written, "goal": {"minimise": "correction"}})))
    assert plan.status == "optimal"
    planes = {name: row for name, row in plan.to_json()["planes"].items() if row["unbalance"]["value"]}
    left = run(found, *((name, row["unbalance"]["value"], row["angle"]["value"]) for name, row in planes.items()))
    assert left.status == "met"
    assert min(row.margin for row in left.limits.values()) < 0.06


@pytest.mark.parametrize("holes", [0, 18], ids=["free", "holes"])
def test_weights_of_a_modelled_rotor_go_as_far_as_the_half_axis_of_its_orbits(holes: int) -> None:
    """At one speed nothing is tightened: the least weights leave just what is allowed; no holes are better.

    What each of them leaves is put back onto the rotor, as the sum of forward and backward whirl.
    """
    document = at(borne(friswell(), **numbers(2e6, 3e5, -1e5, 8e5, 3e3, 0.0, 0.0, 2e3)), "1300 rpm")
    places = ("first", "second")
    bounds = {name: {"response": "displacement", "of": name, "at_most": "0.01 mm"} for name in places}
    design = solve(from_dict({**document, "measures": {}, "limits": bounds}))
    written = {**balancing_document(design), "goal": {"minimise": "correction"}}
    if holes:
        shelf = [f"{grams} g" for grams in (1, 2, 4, 7)]
        written["planes"] = {name: {"radius": "100 mm", "holes": holes, "shelf": shelf} for name in places}
    plan = answer(job_from_text(document_toml(written)))
    assert plan.status == "optimal"
    built, omega = machine_of(design.scene, {}), 1300.0 * RPM
    ones = {name: built.shake(np.array([omega]), {name: np.array([omega**2 + 0j])}, {}) for name in places}
    effect = {of: {on: ones[on].points[of][:, 0] for on in places} for of in places}
    found = {"first": design.scene.excitations["imbalance"].swung}

    def axes(u: dict[str, Any]) -> Any:
        moved = [sum(np.multiply.outer(effect[of][on], u[on] + found.get(on, 0.0)) for on in places) for of in places]
        forward, backward = (np.abs([y + sense * 1j * z for y, z in moved]) / 2.0 for sense in (1, -1))
        return (forward + backward).max(axis=0)

    fitted = plan.plan.fittings[0].planes
    u = {own.name: own.u for own in fitted}
    if not holes:
        assert axes(u) == pytest.approx(1e-5, rel=1e-7)
        return
    grams = [0.0, 1e-3, 2e-3, 4e-3, 7e-3]
    each = np.unique([0.1 * one * np.exp(2j * np.pi * k / holes) for one in grams for k in range(holes)])
    first, second = (grid.ravel() for grid in np.meshgrid(each, each))
    kept = axes({"first": first, "second": second}) <= 1e-5
    least = ((np.abs(first) + np.abs(second)) / 0.1)[kept].min()
    assert axes(u) <= 1e-5
    assert plan.goal[1].value == pytest.approx(least, rel=1e-9)


def test_a_rotor_whose_whirl_grows_is_no_balancing_job() -> None:
    document = {**friswell(material_damping="1 ms"), "links": held(2e6, 3e3)}
    design = solve(from_dict(document))
    assert refused(lambda: balancing_document(design)).messages == (f"scene: {design.measures['first'].unsteady}.",)
    assert "beyond its stability threshold" in design.measures["first"].unsteady


def test_the_campbell_diagram_of_damped_whirls_meets_the_spin_at_damped_critical_speeds() -> None:
    design = solve(from_dict(borne(friswell(), 1e6, 0, 0, 1.5e6, 3e3, 0.0, 0.0, 5e3)))
    found = campbell_of(design)
    rotor = spun(model_of(design.scene), NONE)
    for table, speeds, sense in ((found.forward, found.critical, 1.0), (found.backward, found.against, -1.0)):
        assert speeds == pytest.approx(
            [one.speed for one in synchronous(rotor, sense, float(found.spins[-1]))], rel=1e-8
        )
        assert len(speeds)
        for speed in speeds:
            near = int(np.abs(found.spins - speed).argmin())
            assert np.nanmin(np.abs(table[near] - speed)) <= 2.0 * found.spins[1]
    campbell_figure(found, "rotor")


def test_a_plot_of_what_grows_alone_says_why_it_is_none() -> None:
    document = borne(friswell(), 1e6, 2e5, -1e5, 1.5e6, 200.0, 0.0, 0.0, 300.0)
    assert refused(lambda: _picture(solve(from_dict(document)), None)).messages == (
        "scene: there is nothing to draw: a whirl grows without end, and nothing that is asked has a steady motion.",
    )


def fit_on_a_disc(**limits: dict[str, Any]) -> dict[str, Any]:
    """A disc of any mass with a fit, in bearings that are nearly rigid: it grows from w_n (1 + c_e / c_i) on."""
    document = borne(light(), 1e12, 0.0, 0.0, 2e12, 0.0, 0.0, 0.0, 0.0)
    document["links"] = {"fit": {"between": ["disc", "ground"], "damping": "60 N s/m", "rotating_damping": "40 N s/m"}}
    document["rotors"]["rotor"]["discs"][0]["mass"] = {"from": "5 kg", "to": "100 kg"}
    return {**document, "limits": limits, "goal": {"find_all": "rotors.rotor.discs.1.mass"}}


def test_a_threshold_that_is_found_no_more_does_not_cut_what_is_permitted() -> None:
    stable = {"response": "stability_threshold", "at_least": "400 rad/s"}
    design = solve(from_dict(fit_on_a_disc(stable=stable)))
    assert design.status == "met", design.claim
    heaviest = 48.0 * BENDING * (2.5 / 400.0) ** 2
    assert [[end.value for end in two] for two in design.found or ()] == [pytest.approx([5.0, heaviest], rel=1e-5)]
    model = model_of(from_dict(friswell()))
    for top, other, agreed in ((600.0, 599.0, True), (600.0, 500.0, False), (0.0, 599.0, False)):
        assert (WhirlThreshold(top).room(model, NONE, math.inf, other, 1e-12) == other) == agreed


def test_a_threshold_keeps_its_digits_beside_parts_that_are_far_stiffer() -> None:
    """Shear of the shaft is a billion times as stiff as bending, its bearings a million times: they take 2.3e-7 off.

    Between both planes' frequencies, of springs in series, the whirl is at the mean of these.
    """
    limits = {"stable": {"response": "stability_threshold", "at_least": "400 rad/s"}}
    limit = pose(from_dict(fit_on_a_disc(**limits))).limits[0]
    bending = 48.0 * BENDING
    softer = sum(bending / (2.0 * bearing) for bearing in (1e12, 2e12)) / 4.0
    for mass in np.linspace(47.1238, 47.1239, 7):
        found = spun(limit.model, np.array([mass])).threshold(600.0)
        assert found == pytest.approx(2.5 * math.sqrt(bending / mass) * (1.0 - softer), rel=2e-9)


@pytest.mark.parametrize(("damping", "grows"), [("3804 N s/m", True), ("3804.4 N s/m", True), ("3804.7 N s/m", False)])
def test_a_whirl_that_grows_in_a_narrow_range_of_spins_alone_is_found_by_both_routes(damping: str, grows: bool) -> None:
    """Gyroscopic moments part the whirls again beyond: of 3804.4 N s/m from 1086 to 1098 rpm."""
    disc = {"name": "basket", "at": "1 m", "mass": "80 kg", "diametral": "2.6 kg m2", "polar": "4.2 kg m2"}
    document = friswell(
        modulus="207 GPa",
        density="7850 kg/m3",
        sections=[{"length": "600 mm", "diameter": "60 mm"}, {"length": "400 mm", "diameter": "60 mm"}],
        stations={"left": "0 mm", "right": "600 mm"},
        discs=[disc],
    )
    del document["rotors"]["rotor"]["shear_modulus"]
    document["links"] = {"drive": {"between": ["left", "ground"], "stiffness": "60 MN/m"}}
    document["bearings"] = {"seal": {"between": ["right", "ground"], **numbers(4e6, 5e5, -3e5, 7e6, 0, 0, 0, 3e3)}}
    document["bearings"]["seal"]["c_yy"] = damping
    document["excitations"]["imbalance"]["on"] = "basket"
    document["measures"] = {"m": {"response": "stability_threshold"}}
    scene = from_dict(document)
    found = spun(model_of(scene), NONE).threshold(628.0), machine_of(scene, {}).threshold(628.0)
    assert found[0] == pytest.approx(found[1], rel=1e-8)
    assert (found[0] < 116.0) == grows


def test_a_whirl_that_stiff_bearings_bend_grows_where_both_routes_say() -> None:
    """It grows by what bearings bend the shaft alone: of the lowest motions nothing grows yet."""
    discs = [
        {"name": "first", "at": "347.9 mm", "mass": "10.16 kg", "diametral": "0.01796 kg m2", "polar": "0.01757 kg m2"},
        {
            "name": "second",
            "at": "79.57 mm",
            "mass": "45.28 kg",
            "diametral": "0.007138 kg m2",
            "polar": "0.007758 kg m2",
        },
        {"name": "third", "at": "191.8 mm", "mass": "11.22 kg", "diametral": "402.4 kg mm2", "polar": "225.9 kg mm2"},
    ]
    document = friswell(
        modulus="207 GPa",
        density="7850 kg/m3",
        sections=[{"length": "347.9 mm", "diameter": "60.46 mm", "inner_diameter": "35.3 mm"}],
        stations={"left": "79.56 mm", "right": "308.4 mm"},
        discs=discs,
    )
    del document["rotors"]["rotor"]["shear_modulus"]
    document["links"] = {}
    document["bearings"] = {
        "front": {"between": ["left", "ground"], **numbers(51.25e6, 14.68e6, 7.986e6, 202.6e6, 171.2, 0, 0, 386.7)},
        "rear": {"between": ["right", "ground"], **numbers(4180e6, 812.3e6, 582.6e6, 9499e6, 1874.0, 0, 0, 635.2)},
    }
    document["excitations"]["imbalance"]["on"] = "first"
    document["measures"] = {"m": {"response": "stability_threshold"}}
    scene = from_dict(document)
    found = spun(model_of(scene), NONE).threshold(), machine_of(scene, {}).threshold()
    assert found[0] == pytest.approx(found[1], rel=1e-6)
    assert 5.0 < found[0] < 50.0


def test_a_bearing_that_is_alike_in_both_planes_has_the_numbers_of_a_link() -> None:
    film = {"clearance": "0.1 mm", "length": "25 mm", "diameter": "80 mm", "viscosity": "0.01 Pa s"}
    document = {**friswell(), "links": {}}
    document["bearings"] = {
        "left_film": {"between": ["left", "ground"], "k_yy": "5 MN/m", "k_zz": "5 MN/m", "squeeze_film": film},
        "right_film": {"between": ["right", "ground"], **numbers(4e6, 0, 0, 4e6, 3e3, 0, 0, 3e3)},
    }
    found = asked(
        document,
        stiff={"response": "stiffness", "of": "left_film"},
        film={"response": "damping", "of": "left_film"},
        damps={"response": "damping", "of": "right_film"},
    )
    assert found == pytest.approx({"stiff": 5e6, "film": math.pi * 0.01 * 0.04 * 250.0**3, "damps": 3e3}, rel=1e-12)


DRIVEN = (4e6, 2e5, -2e5, 4e6, 1e3, 0.0, 0.0, 1e3)


def test_values_at_which_a_whirl_grows_are_told_with_the_limit_that_is_missing() -> None:
    document = borne(light(shear_modulus="80 GPa", shear_coefficient=0.9, density="1e-5 kg/m3"), *DRIVEN)
    document["rotors"]["rotor"]["discs"][0]["mass"] = {"from": "5 kg", "to": "100 kg"}
    far = {"response": "displacement", "of": "disc", "at_most": "1 mm"}
    design = solve(from_dict({**document, "limits": {"far": far}, "goal": {"find_all": "rotors.rotor.discs.1.mass"}}))
    assert (design.status, design.found) == ("unproven", None)
    assert design.claim.startswith("far is not known: excitations.imbalance spins the rotor up to 3000 rpm, beyond its")
    assert 'Add a limit with response = "stability_threshold", at_least = "3000 rpm"' in design.claim
