"""Damped whirls of rotors: closed forms, published figures, both routes, none left out, and what is refused."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from refusals import refused
from test_bearings import BENDING, BOTH, FILM, REST, ROWS, at, borne, numbers
from test_rotors import HEAD, NONE, RPM, SHAFT, asked, friswell, held, light
from vibopt.mechanics.free_whirls import NO_PEAK, _crossings, _Look, decrements, free_whirls, synchronous
from vibopt.mechanics.orbits import spun
from vibopt.mechanics.resistance import Resistance
from vibopt.mechanics.whirls_as_built import as_fast, in_planes, whirls
from vibopt.report.machine_views import blocks, own_json
from vibopt.scene.assemble import model_of
from vibopt.scene.read import from_dict, from_text
from vibopt.signals import Band
from vibopt.solve import solve
from vibopt.verify.as_built import machine_of
from vibopt.verify.sharpness import sharpest

OIL = (12.81e6, 16.39e6, -25.06e6, 8.815e6, 232.9e3, -81.92e3, -81.92e3, 294.9e3)
PRINTED = {
    200.0: (14.65456496, 15.00342392, 17.29602598, 17.6304386, 69.39050339, 69.45679729),
    4000.0: (14.65397309, 15.00828414, 17.08915063, 17.78723718, 67.06556436, 71.29745535),
}
"""Sizes of the roots over 2 pi [Hz] of two discs in oil films, Friswell, Penny, Garvey and Lees (2010), example 5.9.6,
of six elements, as the manual of ROSS prints them."""


def up_to(document: dict[str, Any], frequency: str) -> dict[str, Any]:
    """The same, modelled as far as some frequency."""
    far = {"response": "logarithmic_decrement", "at": "0 rpm", "up_to": frequency}
    return {**document, "measures": {**document["measures"], "far": far}}


@pytest.mark.parametrize("speed", PRINTED)
def test_whirls_in_oil_films_are_those_that_are_printed(speed: float) -> None:
    found = free_whirls(spun(model_of(from_dict(borne(friswell(), *OIL))), NONE), speed * RPM, 600.0)
    assert np.abs(found.rates) / (2.0 * math.pi) == pytest.approx(PRINTED[speed], rel=5e-5)


@given(st.integers(0, 10**6), st.floats(0.05, 3.0), st.floats(-4.0, 1.0))
def test_whirls_of_either_sense_meet_in_their_stretches(seed: int, speed: float, damped: float) -> None:
    """Each solved by a system of each sense is a root of the whole resistance, and the motion is what that lets go."""
    eight = np.exp(np.random.default_rng(seed).uniform(-0.7, 0.7, 8)) * [4e6, 7e5, -7e5, 9e6, 3e3, 2e2, -2e2, 6e3]
    rotor = spun(
        model_of(from_dict(borne(friswell(), *eight[:4].tolist(), *(eight[4:] * 10.0**damped).tolist()))), NONE
    )
    spin = speed * rotor.slowest
    resistance = Resistance(rotor, spin)
    still, first, second = resistance.powers
    size = np.sqrt(np.abs(np.diagonal(still)))
    rates, ways = np.linalg.eig(rotor.rates(spin))
    lowest = [k for k in np.argsort(rates.imag) if rates[k].imag > 0.1 * abs(rates[k])][:2]
    for k in lowest:
        found = resistance.freed(complex(-1j * rates[k]), rotor.motions(ways[:, [k]])[:, 0])
        assert found is not None
        rate, way = found
        assert abs(rate + 1j * rates[k]) < 0.1 * abs(rates[k])
        whole = (still + rate * first + rate**2 * second) / np.outer(size, size)
        assert np.linalg.norm(whole @ (way * size)) <= 1e-12 * np.linalg.norm(way * size)


# Closed forms: a disc on a light shaft


def disc_decrement(film: complex, damping: float) -> float:
    """Of 20 kg in the middle of a shaft in two bearings film + w i damping, in series; of a circular whirl."""
    shears = 4.0 * 0.9 * 80e9 * math.pi * 0.02**2
    shaft, bearing = 1.0 / (1.0 / (48.0 * BENDING) + 1.0 / shears), np.array([2.0 * film, 2.0j * damping])
    # m w^2 (k_s + b) = k_s b, b = b_0 + b_1 w
    roots = np.roots([20.0 * bearing[1], 20.0 * (shaft + bearing[0]), -shaft * bearing[1], -shaft * bearing[0]])
    turning = roots[roots.real > 1e-6 * np.abs(roots)]
    return float((2.0 * math.pi * turning.imag / turning.real).min())


@pytest.mark.parametrize("damping", [300.0, 3e3, 2e5])
def test_a_disc_in_films_that_drive_it_fades_by_the_closed_form(damping: float) -> None:
    """Coupling k at right angles is stiffness -+ i k to a forward and to a backward whirl."""
    stiff, drive = 4e6, 2e5
    shaft = light(shear_modulus="80 GPa", shear_coefficient=0.9, density="1e-5 kg/m3")
    document = borne(shaft, stiff, drive, -drive, stiff, damping, 0.0, 0.0, damping)
    asks = {"response": "logarithmic_decrement", "at": "900 rpm", "up_to": "9000 rpm"}
    found = asked(document, forward={**asks, "whirl": "forward"}, backward={**asks, "whirl": "backward"}, least=asks)
    right = [disc_decrement(stiff - sense * 1j * drive, damping) for sense in (1.0, -1.0)]
    assert [found["forward"], found["backward"]] == pytest.approx(right, rel=1e-6, abs=1e-9)
    assert found["least"] == min(found["forward"], found["backward"])


def test_damping_ratio_and_decrement_say_the_same() -> None:
    document = {**friswell(), "links": held(1e6, 3e3)}
    asks = {"at": "2500 rpm", "up_to": "5000 rpm", "mode": 2}
    both = {name: {"response": name, **asks} for name in ("damping_ratio", "logarithmic_decrement")}
    ratio, decrement = asked(document, **both).values()
    assert decrement == pytest.approx(2.0 * math.pi * ratio / math.sqrt(1.0 - ratio**2), rel=1e-12)


def test_without_dampers_damped_critical_speeds_are_the_undamped_ones() -> None:
    for whirl in ("forward", "backward"):
        asks = {"response": "critical_speed", "whirl": whirl, "mode": 2}
        damped, plain = asked(friswell(), damped={**asks, "damped": True}, plain=asks).values()
        assert damped == pytest.approx(plain, rel=1e-10)


@pytest.mark.parametrize("ratio", [0.02, 0.3, 0.6, 0.8])
def test_a_damped_disc_is_as_fast_as_its_spin_below_its_critical_speed(ratio: float) -> None:
    """Dampers at the disc: w_n sqrt(1 - z^2), and none from 1 / sqrt(2) on."""
    document = {**light(), "links": held(1e9)}
    own = asked(document, c={"response": "critical_speed"})["c"]
    damping = 2.0 * ratio * own * 20.0
    document["links"] = {**held(1e9), "seal": {"between": ["disc", "ground"], "damping": f"{damping!r} N s/m"}}
    found = asked(document, c={"response": "critical_speed", "damped": True})["c"]
    if ratio < NO_PEAK:
        assert found == pytest.approx(own * math.sqrt(1.0 - ratio**2), rel=1e-4)  # the shaft weighs something
    else:
        assert found > 10.0 * own


# Sharpness of peaks


@pytest.mark.parametrize("ratio", [0.01, 0.1, 0.2])
def test_the_peak_of_a_disc_is_as_sharp_as_the_closed_form(ratio: float) -> None:
    """r^2 / |1 - r^2 + 2 i z r|, of whose square half the greatest is met where a quadratic in r^2 is nothing."""
    own, damping = math.sqrt(48.0 * BENDING / 20.0), 2.0 * ratio * math.sqrt(48.0 * BENDING * 20.0)
    document = {**light(), "links": held(1e12)}
    document["links"]["seal"] = {"between": ["disc", "ground"], "damping": f"{damping!r} N s/m"}
    document["excitations"]["imbalance"]["speed"] = f"{0.3 * own!r}..{2.0 * own!r} rad/s"
    found = asked(
        document, m={"response": "amplification_factor", "of": "disc", "over": f"{0.3 * own!r}..{2.0 * own!r} rad/s"}
    )
    half = 0.5 / (4.0 * ratio**2 * (1.0 - ratio**2))  # of the square of the peak, e^2 / (4 z^2 (1 - z^2))
    squares = np.sort(np.roots([1.0 - half, half * (2.0 - 4.0 * ratio**2), -half]).real)
    low, high = np.sqrt(squares)
    assert found["m"] == pytest.approx(1.0 / math.sqrt(1.0 - 2.0 * ratio**2) / (high - low), rel=1e-6)


def factors_by_words(speeds: np.ndarray, size: np.ndarray, band: tuple[float, float]) -> tuple[float, set[str]]:
    """The greatest N / (N2 - N1) of all peaks inside a band as the manual says it, on even speeds from rest on."""
    found, seen = [0.0], set()
    for k in np.flatnonzero((size[1:-1] > size[:-2]) & (size[1:-1] > size[2:])) + 1:
        peak, widths = speeds[k], []
        if not band[0] < peak < band[1]:
            continue
        for side in (size[k::-1], size[k : 2 * k + 1]):
            low, over = side < size[k] / math.sqrt(2.0), side > size[k]
            if over.any() and (not low.any() or over.argmax() < low.argmax()):
                seen.add("rises")
                continue
            seen.add("falls" if low.any() and low.argmax() <= k / 2 else "wide")
            widths.append(min(low.argmax() if low.any() else len(side), k / 2) * speeds[1])
        found.append(peak / (2.0 * float(np.mean(widths))) if widths else 1.0)
    return max(found), seen


@pytest.mark.parametrize(
    ("pedestal", "held_by", "seal", "brake", "of", "sides"),
    [
        (20.0, 2.5e5, 1700.0, 200.0, "left", {"falls", "wide", "rises"}),
        (10.0, 1.6e6, 2200.0, 1300.0, "left", {"falls", "wide", "rises"}),
        (10.0, 8.1e5, 2300.0, 120.0, "left", {"falls", "rises"}),
        (10.0, 1.1e6, 2200.0, 120.0, "disc", {"falls", "wide"}),
    ],
)
def test_sides_of_a_peak_count_as_the_manual_says(
    pedestal: float, held_by: float, seal: float, brake: float, of: str, sides: set[str]
) -> None:
    """A disc on a light shaft between pedestals that swing: all in series, by even speeds."""
    shaft, support = 48.0 * BENDING, 2e6
    document = {**light(), "links": {"seal": {"between": ["disc", "ground"], "damping": f"{seal!r} N s/m"}}}
    document["bodies"] = {f"{end}_foot": {"mass": f"{pedestal!r} kg"} for end in ("left", "right")}
    for end in ("left", "right"):
        document["links"][f"{end}_bearing"] = {"between": [end, f"{end}_foot"], "stiffness": f"{support!r} N/m"}
        base = {"stiffness": f"{held_by!r} N/m", "damping": f"{brake!r} N s/m"}
        document["links"][f"{end}_base"] = {"between": [f"{end}_foot", "ground"], **base}
    band = 60.0, 500.0
    asks = {"response": "amplification_factor", "of": of, "over": "60..500 rad/s"}
    w = np.linspace(0.0, 1000.0, 200001)
    bearing = 1.0 / (1.0 / support + 1.0 / (held_by + 1j * brake * w - pedestal * w**2))
    whole = 1.0 / (1.0 / shaft + 0.5 / bearing)
    disc = w**2 / (whole + 1j * seal * w - 20.0 * w**2)
    size = np.abs(disc if of == "disc" else whole * disc / (2.0 * bearing))
    factor, seen = factors_by_words(w, size, band)
    assert seen == sides
    assert asked(document, m=asks)["m"] == pytest.approx(factor, rel=1e-3)


def test_a_range_without_a_peak_has_none_and_a_peak_that_nothing_damps_no_end() -> None:
    over = {"response": "amplification_factor", "of": "second"}
    found = asked(friswell(), none={**over, "over": "1200..1300 rpm"}, endless={**over, "over": "500..1200 rpm"})
    assert found == {"none": 0.0, "endless": math.inf}


def test_what_bends_no_fibre_is_as_sharp_with_and_without_damping_of_its_material() -> None:
    asks = {"response": "amplification_factor", "of": "second", "over": "500..1200 rpm"}
    factors = [
        asked({**friswell(**own), "links": held(1e6, 3e3)}, m=asks)["m"]
        for own in ({}, {"material_damping": "0.002 ms"})
    ]
    assert factors[0] == pytest.approx(factors[1], rel=1e-9)


def test_a_sharp_peak_is_kept_out_of_a_band_and_a_broad_one_may_be_in_it() -> None:
    """That the standard does not count it is a limit on the factor in the band."""
    broad = {"response": "amplification_factor", "of": "left", "over": "3000..4000 rpm", "at_most": 2.5}
    for damping, status in ((3e3, "violated"), (3e4, "met")):
        document = borne(friswell(), 1e6, 0.0, 0.0, 3e6, damping, 0.0, 0.0, damping)
        design = solve(from_dict({**document, "measures": {}, "limits": {"broad": broad}}))
        assert design.status == status, design.claim


@pytest.mark.parametrize(
    "beside", [pytest.param({}, marks=pytest.mark.slow), {"loose": {"response": "total_mass", "at_most": "1 t"}}]
)
def test_all_masses_whose_peak_lies_beside_a_band_are_told_from_just_inside_where_it_comes_in(beside: Any) -> None:
    """Its factor leaps there: the peak is where w^2 = 2 k^2 / (2 k m - c^2)."""
    stiffness, damping, band = 48.0 * BENDING, 300.0, (150.0, 200.0)
    document = {**light(), "links": {**held(1e12), "seal": {"between": ["disc", "ground"], "damping": "300 N s/m"}}}
    document["rotors"]["rotor"]["discs"][0]["mass"] = {"from": "5 kg", "to": "100 kg"}
    sharp = {"response": "amplification_factor", "of": "disc", "over": "150..200 rad/s", "at_most": 2.5}
    goal = {"find_all": "rotors.rotor.discs.1.mass"}
    design = solve(from_dict({**document, "limits": {"sharp": sharp, **beside}, "goal": goal}))
    assert design.status == "met", design.claim
    assert [[end.ended_by for end in two] for two in design.details["ends"]] == [["", "sharp"], ["sharp", ""]]
    assert "or just inside of one where a limit leaps" in design.claim
    light_one, heavy_one = [tuple(end.value for end in pair) for pair in design.found or ()]
    slow, fast = ((2.0 * stiffness**2 / speed**2 + damping**2) / (2.0 * stiffness) for speed in band)
    assert light_one == pytest.approx((5.0, fast), rel=1e-5)
    assert heavy_one == pytest.approx((slow, 100.0), rel=1e-5)


# Both routes, and none left out

SIGNED = st.integers(-300, 300)


@given(
    springs=st.tuples(*[st.floats(1e6, 4e7)] * 2), dampers=st.tuples(*[st.floats(3e2, 4e4)] * 2),
    crossed=st.tuples(*[SIGNED] * 2), lags=st.sampled_from([0.0, 1e-5]), spin=st.floats(10.0, 400.0),
)  # fmt: skip
@settings(max_examples=12)
def test_whirls_by_polynomials_are_those_by_waves(
    springs: Any, dampers: Any, crossed: Any, lags: float, spin: float
) -> None:
    film = (springs[0], *(1e3 * one for one in crossed), springs[1], dampers[0], 0.0, 0.0, dampers[1])
    document = up_to(borne(friswell(), *film), "800 rad/s")
    if lags:
        document = up_to(
            {**friswell(material_damping=f"{1e3 * lags!r} ms"), "links": held(*[springs[0], dampers[0]])}, "800 rad/s"
        )
    scene = from_dict(document)
    model = free_whirls(spun(model_of(scene), NONE), spin, 800.0)
    built = whirls(in_planes(machine_of(scene, {})), spin, 800.0)
    light_ones = model.rates.imag < 0.5 * np.abs(model.rates)
    for rate, goes in zip(model.rates[light_ones], model.senses[light_ones], strict=True):
        near, sense = min(built, key=lambda one: abs(one[0] - rate))
        assert abs(near - rate) <= 1e-9 * abs(rate)
        sure = min((abs(other - rate) for other in model.rates if other != rate), default=1.0) > 1e-3 * abs(rate)
        assert goes == sense or not sure


def winding(values: Any) -> int:
    """How often a path in the complex plane goes round nothing."""
    return round(float(np.angle(values[1:] / values[:-1]).sum()) / (2.0 * math.pi))


@pytest.mark.parametrize("spin", [*(pytest.param(one, marks=pytest.mark.slow) for one in (0.5, 150.0)), 418.9])
@pytest.mark.parametrize("film", [OIL, (1e6, 2e5, -1e5, 3e6, 3e3, 0.0, 0.0, 5e3)])
def test_as_many_whirls_are_found_as_the_argument_of_the_determinant_counts(film: Any, spin: float) -> None:
    """Around a part of the plane of frequencies, by the principle of the argument."""
    rotor = spun(model_of(from_dict(up_to(borne(friswell(), *film), "600 rad/s"))), NONE)
    size = np.sqrt(np.abs(np.diagonal(rotor.dynamic(0.0, spin))))
    low, high, below, above = 1.0, 600.0, -20.0, 200.0
    corners = [
        complex(low, below),
        complex(high, below),
        complex(high, above),
        complex(low, above),
        complex(low, below),
    ]
    path = np.concatenate([np.linspace(a, b, 500, endpoint=False) for a, b in pairwise(corners)] + [corners[:1]])
    signs = [np.linalg.slogdet(rotor.dynamic(complex(at), spin) / np.outer(size, size))[0] for at in path]
    found = free_whirls(rotor, spin, high).rates
    inside = (found.real > low) & (found.imag > below) & (found.imag < above)
    assert winding(np.array(signs)) == inside.sum() > 3


@pytest.mark.parametrize("sense", [pytest.param(1.0, marks=pytest.mark.slow), -1.0])
def test_damped_critical_speeds_by_polynomials_are_those_by_waves(sense: float) -> None:
    """Of a table over the speed, too: a film that stiffens as it spins."""
    rows = [{"speed": f"{spin} rad/s", **numbers(stiff, 2e5, -1e5, 2.0 * stiff, 3e3, 0.0, 0.0, 5e3)}
            for spin, stiff in ((0.0, 1e6), (200.0, 4e6), (900.0, 9e6))]  # fmt: skip
    for document in (borne(friswell(), table=rows), {**friswell(), "links": held(1e6, 2e3)}):
        scene = from_dict(up_to(document, "900 rad/s"))
        rotor = spun(model_of(scene), NONE)
        found = np.array([one.speed for one in synchronous(rotor, sense, 800.0)])
        assert as_fast(in_planes(machine_of(scene, {})), sense, NO_PEAK, 800.0) == pytest.approx(found, rel=1e-9)
        assert len(found) >= 2
        for speed in found.tolist():
            every = free_whirls(rotor, speed, 1.2 * speed)
            assert np.abs(every.of(sense).real / speed - 1.0).min() <= 1e-10


def unruly(seed: int) -> dict[str, Any]:
    """Between films whose numbers leap from row to row: whirls turn back, and two meet the spin close together."""
    draw = np.random.default_rng(seed)
    document = borne(friswell(), *OIL)
    for film in document["bearings"].values():
        springs, dampers = 10.0 ** draw.uniform(6.0, 8.0, (5, 2)), 10.0 ** draw.uniform(3.0, 5.0, (5, 2))
        crossed = draw.uniform(-2e6, 2e6, (5, 2))
        rows = zip((0, 1500, 4000, 8000, 12000), springs, crossed, dampers, strict=True)
        for key in [one for one in film if one != "between"]:
            del film[key]
        film["table"] = [
            {"speed": f"{speed} rpm", **numbers(*map(float, (k[0], x[0], x[1], k[1], c[0], 0.0, 0.0, c[1])))}
            for speed, k, x, c in rows
        ]
    return document


@pytest.mark.parametrize("seed", [1, pytest.param(4, marks=pytest.mark.slow)])
def test_both_roads_meet_every_damped_critical_speed_of_films_that_leap(seed: int) -> None:
    scene = from_dict(up_to(unruly(seed), "1256 rad/s"))
    found = np.array([one.speed for one in synchronous(spun(model_of(scene), NONE), 0.0, 1256.0)])
    assert as_fast(in_planes(machine_of(scene, {})), 0.0, NO_PEAK, 1256.0) == pytest.approx(found, rel=1e-8)
    assert len(found) >= 3


@pytest.mark.parametrize("crossed", [0.0, pytest.param(-0.25, marks=pytest.mark.slow)])
def test_as_many_are_found_as_are_counted_also_where_some_are_met_twice(crossed: float) -> None:
    stiff = 1e6, crossed * 1e6, crossed * 1e6, 1.4e6, 200.0, 0.0, 0.0, 200.0
    scene = from_dict(up_to(borne(friswell(), *stiff), "1500 rad/s"))
    rotor, machine = spun(model_of(scene), NONE), in_planes(machine_of(scene, {}))
    every = [one.speed for one in synchronous(rotor, 0.0, 1500.0)]
    assert len(every) >= 5
    for many in (2, len(every)):
        assert [one.speed for one in synchronous(rotor, 0.0, 0.0, many)][:many] == pytest.approx(every[:many], rel=1e-9)
        assert as_fast(machine, 0.0, NO_PEAK, 0.0, many)[:many] == pytest.approx(every[:many], rel=1e-9)


def test_a_whirl_along_a_line_goes_either_way() -> None:
    """A light shaft that tilts no disc: each plane moves by itself, and its whirl is forward and backward alike."""
    document = borne(light(), 4e6, 0.0, 0.0, 12e6, 1e3, 0.0, 0.0, 1e3)
    document["rotors"]["rotor"]["discs"][0].pop("polar", None)
    asks = {"response": "critical_speed", "damped": True}
    senses: Any = {"both": {}, "forward": {"whirl": "forward"}, "backward": {"whirl": "backward"}}
    for mode in (1, 2):
        found = asked(document, **{name: {**asks, **sense, "mode": mode} for name, sense in senses.items()})
        assert found["forward"] == found["backward"] == found["both"]


def test_the_least_over_a_range_is_no_greater_than_anywhere_in_it() -> None:
    document = borne(friswell(), 1e6, 2e5, -1e5, 3e6, 3e3, 0.0, 0.0, 5e3)
    asks = {"response": "logarithmic_decrement", "up_to": "6000 rpm"}
    least = asked(document, m={**asks, "over": "600..3900 rpm"})["m"]
    rotor = spun(model_of(from_dict(up_to(document, "6000 rpm"))), NONE)
    each = [decrements(free_whirls(rotor, spin * RPM, 6000.0 * RPM).rates).min() for spin in np.linspace(600, 3900, 45)]
    assert least <= min(each) * (1.0 + 1e-9)
    assert least == pytest.approx(min(each), rel=1e-3)


# As limits


def test_a_whirl_goes_the_way_of_its_motion_where_pieces_have_another_beside_it() -> None:
    """Beside a bearing like a wall pieces are 4 % off, nearer to the backward whirl; own elements: 1679.75 rad/s."""
    document = friswell(
        modulus="207 GPa",
        density="7850 kg/m3",
        sections=[
            {"length": "0.2259 m", "diameter": "0.1846 m"},
            {"length": "0.1 m", "diameter": "0.1235 m", "inner_diameter": "0.09784 m"},
            {"length": "0.3034 m", "diameter": "0.2452 m"},
        ],
        stations={"left": "0.1674 m", "right": "0.4368 m"},
        discs=[{"name": "first", "at": "0.4608 m", "mass": "14600 kg"}],
    )
    del document["rotors"]["rotor"]["shear_modulus"]
    document["links"] = {
        "wall": {"between": ["left", "ground"], "stiffness": "11160 GN/m", "damping": "1860 N s/m"},
        "pad": {"between": ["right", "ground"], "stiffness": "240 MN/m", "damping": "38.71 MN s/m"},
        "fit": {"between": ["first", "ground"], "rotating_damping": "35480 N s/m"},
    }
    document["excitations"]["imbalance"] |= {"on": "first", "speed": "1335 rpm"}
    document["measures"] = {"m": {"response": "critical_speed", "damped": True}}
    found = solve(from_dict(document))
    assert found.status == "met", found.claim
    assert found.measures["m"].value.value == pytest.approx(1679.75, rel=1e-3)


def test_no_damped_critical_speed_lies_near_what_runs() -> None:
    document = borne(friswell(), 1e6, 2e5, -1e5, 3e6, 3e3, 0.0, 0.0, 5e3)
    document["excitations"]["imbalance"]["speed"] = "2000 rpm"
    orders = {"orders": [1, 2], "of": "imbalance", "margin": "15 %"}
    apart = {"response": "critical_speed", "damped": True, "whirl": "forward", "outside": orders}
    design = solve(from_dict({**document, "limits": {"apart": apart}}))
    second = asked(document, m={**apart, "mode": 2, "outside": None})["m"]
    assert (design.status, design.limits["apart"].limit.text) == ("violated", "3400..4600 rpm")
    assert design.limits["apart"].value.value == pytest.approx(second, rel=1e-9)
    assert design.limits["apart"].margin == pytest.approx(1.0 - second / (3400.0 * RPM), rel=1e-9)


def test_between_unlike_bearings_a_limit_counts_whirls_of_both_senses() -> None:
    """The whirl of either plane is nearly straight there, m w^2 = k, and the unbalance drives both."""
    document = borne(light(shear_modulus="80 GPa", shear_coefficient=0.9), 4e6, 0.0, 0.0, 12e6, 10.0, 0.0, 0.0, 10.0)
    shaft = 1.0 / (1.0 / (48.0 * BENDING) + 1.0 / (4.0 * 0.9 * 80e9 * math.pi * 0.02**2))
    asks = {"response": "critical_speed", "damped": True}
    found = asked(document, one=asks, two={**asks, "mode": 2})
    for mode, bearing in (("one", 4e6), ("two", 12e6)):
        straight = math.sqrt(1.0 / (1.0 / shaft + 0.5 / bearing) / 20.0)
        assert found[mode] == pytest.approx(straight, rel=1e-5)
        apart = {**asks, "outside": {"orders": [1], "of": "imbalance", "margin": "1 %"}}
        asking = {**at(document, f"{straight / RPM!r} rpm"), "limits": {"apart": apart}}
        assert solve(from_dict(asking)).status == "violated"


def test_where_no_whirl_counts_the_answer_says_so() -> None:
    fades = {"response": "logarithmic_decrement", "at": "2000 rpm", "up_to": "20 rpm", "at_least": 0.1}
    design = solve(from_dict({**borne(friswell(), *OIL), "limits": {"fades": fades}}))
    assert design.limits["fades"].value.text == "no whirl up to 20 rpm"
    few = {"response": "damping_ratio", "at": "2000 rpm", "up_to": "500 rpm", "mode": 9, "whirl": "forward"}
    design = solve(from_dict({**borne(friswell(), *OIL), "measures": {"few": few}}))
    assert design.measures["few"].value.text == "fewer than 9 forward whirls up to 500 rpm"


def test_free_whirls_are_listed_where_their_damping_is_asked() -> None:
    """At both ends of what is asked, with the least decrement that a measure tells; the model has the same."""
    asks = {"response": "logarithmic_decrement", "up_to": "5000 rpm"}
    measures = {"one": {**asks, "at": "2000 rpm"}, "all": {**asks, "over": "2000..3000 rpm", "whirl": "forward"}}
    design = solve(from_dict({**borne(friswell(), *OIL), "measures": measures}))
    listed, rotor = own_json(design)["whirls"], spun(model_of(design.scene), NONE)
    for spin in (2000.0, 3000.0):
        here = [one for one in listed if one.spin.shown == f"{spin:g} rpm"]
        found = free_whirls(rotor, spin * RPM, 5000.0 * RPM)
        assert [one.frequency.value for one in here] == pytest.approx(found.rates.real, rel=1e-8)
        assert [one.logarithmic_decrement.value for one in here] == pytest.approx(decrements(found.rates), rel=1e-6)
        senses = {"forward": 1.0, "backward": -1.0, "along a line": 0.0}
        assert [senses[one.whirl] for one in here] == found.senses.tolist()
        if spin == 2000.0:
            least = min(one.logarithmic_decrement.value for one in here)
            assert least == pytest.approx(design.measures["one"].value.value, rel=1e-9)
    assert {one.spin.shown for one in listed} == {"2000 rpm", "3000 rpm"}
    assert [one.title for one in blocks(design) if one.title == "Free whirls" and len(one.rows) == len(listed)]


def test_every_damping_is_found_at_which_whirls_fade_fast_enough() -> None:
    """Little damping of a bearing damps little, and so does much: it is clamped."""
    document = borne(friswell(), 2e6, 1e5, -1e5, 3e6, 0.0, 0.0, 0.0, 0.0)
    for bearing in document["bearings"].values():
        bearing["c_yy"] = bearing["c_zz"] = "3 kN s/m"
    document["bearings"]["left_film"]["c_zz"] = {"from": "0.3 kN s/m", "to": "300 kN s/m"}
    fades = {"response": "logarithmic_decrement", "at": "3000 rpm", "up_to": "2000 rpm", "at_least": "0.055"}
    document = {**document, "measures": {}, "limits": {"fades": fades}}
    design = solve(from_dict({**document, "goal": {"find_all": "bearings.left_film.c_zz"}}))
    assert design.status == "optimal" or design.found, design.claim
    for low, high in [(one[0].value, one[1].value) for one in design.found]:
        for end in (low, high):
            if 301.0 < end < 299e3:
                at = {**document, "limits": {}, "measures": {"m": {k: v for k, v in fades.items() if k != "at_least"}}}
                at["bearings"] = {
                    **at["bearings"],
                    "left_film": {**at["bearings"]["left_film"], "c_zz": f"{end!r} N s/m"},
                }
                assert asked(at, **at["measures"])["m"] == pytest.approx(0.055, rel=1e-6)


# What is refused

LINE = (
    'title = "t"\n[bodies.b]\nmass = "2 kg"\n[links.l]\nbetween = ["b", "ground"]\nstiffness = "1 MN/m"\n[measures.m]\n'
)
DECREMENT = 'response = "logarithmic_decrement"\n'
REFUSED = {
    "no rotor": (
        LINE + DECREMENT + 'at = "3000 rpm"\nup_to = "6000 rpm"\n',
        "t line 7: measures.m asks for free whirls at a spin, and there is no rotor. Leave at, over, up_to, whirl and "
        "damped out, or write [rotors.NAME].",
    ),
    "damped without a rotor": (
        LINE + 'response = "critical_speed"\ndamped = true\n',
        "t line 7: measures.m asks for free whirls at a spin, and there is no rotor. Leave at, over, up_to, whirl and "
        "damped out, or write [rotors.NAME].",
    ),
    "sharpness without a rotor": (
        LINE + 'response = "amplification_factor"\nof = "b"\nover = "100..200 rpm"\n',
        "t line 7: measures.m asks for the amplification_factor of a rotor, and there is none. Ask for something else, "
        "or write [rotors.NAME].",
    ),
    "sharpness at one speed": (
        HEAD + SHAFT + REST.replace('"displacement"', '"amplification_factor"'),
        't line 19: measures.m has no over. Add it: over = ["2550..3450 rpm", "5100..6900 rpm"].',
    ),
    "sharpness at a point": (
        HEAD + SHAFT + REST.replace('"displacement"', '"amplification_factor"\nover = "3000 rpm"'),
        't line 19: measures.m says no ranges in which peaks of the whirl count. Write over = "2550..3450 rpm".',
    ),
    "no spin": (
        HEAD + SHAFT + REST.replace('"displacement"\nof = "left"', '"logarithmic_decrement"'),
        "t line 19: measures.m asks for the logarithmic_decrement, but the modes of rotors.r change with its speed. "
        'Write at = "3000 rpm" and up_to = "6000 rpm".',
    ),
    "not how far": (
        HEAD + SHAFT + REST.replace('"displacement"\nof = "left"', '"logarithmic_decrement"\nat = "3000 rpm"'),
        "t line 19: measures.m does not say which whirls of the rotor count, and the quickest are the least telling. "
        'Add the greatest frequency that counts: up_to = "6000 rpm".',
    ),
    "at and over": (
        LINE + DECREMENT + 'at = "3000 rpm"\nover = "0..3000 rpm"\nup_to = "6000 rpm"\n',
        "t line 7: measures.m has both at and over. Keep one: at for single spins, over for ranges.",
    ),
    "how far alone": (
        LINE + DECREMENT + 'up_to = "6000 rpm"\n',
        't line 7: measures.m has up_to, but says no spin of the rotor. Add at = "3000 rpm" or over = "0..3600 rpm".',
    ),
    "a vehicle": (
        LINE + DECREMENT + 'at = "30 km/h"\nup_to = "6000 rpm"\n',
        't line 9: measures.m.at = "30 km/h" is no spin of a rotor. Write at = "3000 rpm" or over = "0..3000 rpm".',
    ),
    "beyond the table": (
        HEAD + SHAFT + REST.replace(FILM, BOTH + (ROWS % "2000 rpm").replace("/m\" }]", "/m\", k_zz = \"1 MN/m\" }]"))
        .replace('"displacement"\nof = "left"', '"logarithmic_decrement"\nat = "3000 rpm"\nup_to = "6000 rpm"'),
        "t line 19: measures.m looks at 3000 rpm, but the tables of bearings, bearings.f among them, say something of "
        "0 rpm to 2000 rpm alone. Write more rows, or look at these speeds.",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("text", "said"), REFUSED.values(), ids=REFUSED)
def test_what_is_refused_of_whirls(text: str, said: str) -> None:
    assert said in refused(from_text, text, name="t").messages


class Creeping:
    """What only creeps back, of a rate that rounding turns a little."""

    slowest, knots = 1.0, np.zeros(0)

    def rates(self, spin: float, few: int) -> Any:
        return np.diag([-1.0 + 1e-320j, -2.0, -3.0, -4.0])

    def motions(self, ways: Any) -> Any:
        return ways[:2]


def test_what_creeps_is_as_fast_as_no_spin_and_ends_the_search() -> None:
    """At rest rounding alone says that it goes round; it was followed towards rest for ever."""
    creeping: Any = Creeping()
    ends = (_Look.at(creeping, spin, 1) for spin in (0.0, 2.0))
    assert _crossings(creeping, *ends) == []


def test_no_peak_is_made_of_rounding_at_standstill() -> None:
    """What creeps has a speed of rounding, and there what is next to nothing goes up and down by it."""
    poles = np.array([200.0 + 1.0j, 1e-8 + 3e3j, 2e-8 + 3e3j, -3e-8 + 3e3j])

    def size(speeds: Any) -> Any:
        rounded = np.where(np.abs(speeds - 1e-8) < 1e-15, 1e-12, 0.0)
        return speeds**2 / np.abs(200.0**2 + 2j * speeds - speeds**2) + rounded

    factor, speed = sharpest(size, (Band(0.0, 360.0),), poles, (0.0, math.inf))
    assert speed == pytest.approx(200.0, rel=1e-3)
    assert factor == pytest.approx(100.0, rel=1e-3)
