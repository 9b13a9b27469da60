"""Damping that turns with a shaft: from which spin on its whirl grows, and what is refused beyond."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from refusals import refused
from vibopt.mechanics.two_planes import threshold_in_planes
from vibopt.mechanics.whirl import rotor_threshold, threshold
from vibopt.scene.read import from_dict
from vibopt.solve import solve


def whirl_rates(mass: Any, fixed: Any, turning: Any, stiffness: Any, spin: float, polar: Any = 0.0) -> Any:
    """Rates s of free whirl e^{s t} [1/s] of y + i z, as y turns to z: by a state matrix of its own."""
    damping, still = fixed + turning - 1j * spin * polar, stiffness - 1j * spin * turning
    zero, unit = np.zeros_like(mass), np.eye(len(mass))
    return np.linalg.eigvals(np.block([[zero, unit], [-np.linalg.solve(mass, still), -np.linalg.solve(mass, damping)]]))


def chain(seed: int, n: int, many: int) -> tuple[Any, Any, Any, Any]:
    """M, C_e, C_i and K of a chain over the ground, of which the last `many` links have a damper that turns."""
    random = np.random.default_rng(seed)
    mass = np.diag(random.uniform(1.0, 30.0, n))
    stiffness, fixed, rotating = np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, n))
    for i in range(n):
        way = np.zeros(n)
        way[i] = 1.0
        way[max(i - 1, 0)] -= 1.0 if i else 0.0
        square = np.outer(way, way)
        stiffness += 10.0 ** random.uniform(4.0, 7.0) * square
        fixed += (i == 0 or random.random() < 0.6) * 10.0 ** random.uniform(0.0, 3.0) * square
        rotating += (i >= n - many) * 10.0 ** random.uniform(0.0, 3.0) * square
    return mass, fixed, rotating, stiffness


@settings(max_examples=20)
@given(st.floats(0.1, 100.0), st.floats(1e3, 1e8), st.floats(0.0, 1e3), st.floats(1e-2, 1e3))
def test_one_disc_whirls_by_the_closed_form(mass: float, k: float, fixed: float, rotating: float) -> None:
    one = [np.array([[each]]) for each in (mass, fixed, rotating, k)]
    right = np.sqrt(k / mass) * (1.0 + fixed / rotating)
    assert threshold(*one) == pytest.approx(right, rel=1e-12)


@settings(max_examples=25)
@given(st.integers(0, 10**6), st.integers(1, 5), st.integers(1, 3))
def test_a_whirl_is_neutral_at_its_threshold_and_fades_below(seed: int, n: int, many: int) -> None:
    machine = chain(seed, n, min(many, n, 3 if n < 5 else 1))
    spin = threshold(*machine)
    sizes = [np.abs(whirl_rates(*machine, spin)).max()]
    assert abs(whirl_rates(*machine, spin).real.max()) <= 1e-11 * sizes[0]
    assert all(whirl_rates(*machine, part * spin).real.max() < 0.0 for part in (0.0, 0.3, 0.9, 0.999))
    assert whirl_rates(*machine, 1.001 * spin).real.max() > 0.0
    assert np.sqrt(np.linalg.eigvals(np.linalg.solve(machine[0], machine[3])).real.min()) <= spin * (1.0 + 1e-9)


@pytest.mark.parametrize("seed", range(12))
def test_both_planes_in_real_numbers_say_the_same(seed: int) -> None:
    mass, fixed, rotating, stiffness = chain(seed, 1 + seed % 4, 1 + seed % 2)
    found = threshold(mass, fixed, rotating, stiffness)
    assert threshold_in_planes(mass, fixed + rotating, rotating, stiffness) == pytest.approx(found, rel=1e-6)


@pytest.mark.parametrize("seed", [*range(2, 12), 86, 98])
def test_steps_that_are_sure_end_at_the_same_spin(seed: int) -> None:
    """As of a rotor without gyroscopic moments; 10, 86 and 98 are neutral there to the last digit."""
    n = 1 + seed % 5
    mass, fixed, rotating, stiffness = chain(seed, n, min(1 + seed % 3, n))
    found = threshold(mass, fixed, rotating, stiffness)
    assert rotor_threshold(mass, 0.0 * mass, fixed, rotating, stiffness).spin == pytest.approx(found, rel=1e-9)


def test_several_dampers_that_turn_alike_are_as_one() -> None:
    """A rank of one in two terms takes the other road."""
    mass, fixed, rotating, stiffness = chain(3, 3, 1)
    found = threshold(mass, fixed, rotating, stiffness)
    tiny = rotating + 1e-7 * np.abs(rotating).max() * np.eye(3)
    assert threshold(mass, fixed, tiny, stiffness) == pytest.approx(found, rel=1e-4)


def test_gyroscopic_moments_lift_the_threshold_of_a_disc_that_tilts() -> None:
    """One tilt: s^2 + (c - i W g) s + k - i W c_i = 0 is neutral at w with w c = W c_i and k = w^2 - W g w."""
    one, g, k, c, ci = np.eye(1), 0.3, 1e4, 2.0, 3.0
    found = rotor_threshold(one, g * one, c * one, ci * one, k * one).spin
    ratio = ci / (c + ci)  # w over W
    assert found == pytest.approx(np.sqrt(k / (ratio**2 - g * ratio)), rel=1e-10)


def test_what_no_damper_reaches_is_left_out() -> None:
    mass, stiffness = np.diag([2.0, 3.0]), np.diag([2e4, 1e4])
    fixed, rotating = np.diag([6.0, 0.0]), np.diag([2.0, 0.0])
    assert threshold(mass, fixed, rotating, stiffness) == pytest.approx(400.0, rel=1e-12)
    assert threshold_in_planes(mass, fixed + rotating, rotating, stiffness) == pytest.approx(400.0, rel=1e-8)
    assert threshold(mass, fixed, 0.0 * rotating, stiffness) == float("inf")


def rotor(**more: Any) -> dict[str, Any]:
    shaft = {
        "between": ["disc", "ground"],
        "beam": {"kind": "simply_supported", "length": "1 m", "diameter": "30 mm", "modulus": "207 GPa"},
        "damping": "60 N s/m",
        "rotating_damping": "40 N s/m",
    }
    return {
        "title": "drawn",
        "bodies": {"disc": {"mass": "20 kg"}},
        "links": {"shaft": shaft},
        "excitations": {"u": {"kind": "unbalance", "on": "disc", "unbalance": "1 kg mm", "speed": "2000 rpm"}},
        "measures": {"least": {"response": "stability_threshold"}, "far": {"response": "displacement", "of": "disc"}},
        **more,
    }


def test_steady_whirl_does_not_feel_what_turns_with_it() -> None:
    found = solve(from_dict(rotor()), explain=False)
    assert found.status == "met"
    own = np.sqrt(48.0 * 207e9 * np.pi * 0.03**4 / 64.0 / 20.0)
    assert found.measures["least"].value.value == pytest.approx(own * 2.5, rel=1e-9)
    still = rotor(measures={"far": {"response": "displacement", "of": "disc"}})
    del still["links"]["shaft"]["rotating_damping"]
    other = solve(from_dict(still), explain=False).measures["far"].value.value
    assert found.measures["far"].value.value == other


def test_what_turns_with_a_shaft_may_be_a_link_of_its_own() -> None:
    document = rotor()
    turning = document["links"]["shaft"].pop("rotating_damping")
    document["links"]["fit"] = {"between": ["disc", "ground"], "rotating_damping": turning}
    one, two = (solve(from_dict(each), explain=False).measures for each in (rotor(), document))
    for name in ("least", "far"):
        assert two[name].value.value == pytest.approx(one[name].value.value, rel=1e-12)


def test_a_rotor_beyond_its_threshold_is_said() -> None:
    document = rotor()
    document["excitations"]["u"]["speed"] = "0..4500 rpm"
    found = solve(from_dict(document), explain=False)
    assert (found.status, found.measures["far"].value.shown) == ("violated", "not known")
    assert found.claim == (
        "far is not known: excitations.u spins the rotor up to 4500 rpm, beyond its stability threshold of 3355.29 "
        "rpm, where a whirl grows without end. Look at lower speeds"
    )
    assert not found.measures["far"].worst_at
    limits = {"far": {"response": "displacement", "of": "disc", "at_most": "1 m"}}
    broken = solve(from_dict({**document, "limits": limits, "measures": {}}), explain=False)
    assert (broken.status, broken.limits["far"].met) == ("violated", False)


def test_every_diameter_that_is_stable() -> None:
    """At least 4500 rpm: (d / 30 mm)^2 is the ratio of thresholds, for the damping stays."""
    document = rotor(limits={"stable": {"response": "stability_threshold", "at_least": "4500 rpm"}}, measures={})
    document["links"]["shaft"]["beam"]["diameter"] = {"from": "10 mm", "to": "80 mm"}
    document["goal"] = {"find_all": "links.shaft.beam.diameter"}
    found = solve(from_dict(document), explain=False)
    assert found.status == "met"
    own = np.sqrt(48.0 * 207e9 * np.pi * 0.03**4 / 64.0 / 20.0)
    least = 0.03 * np.sqrt(4500.0 * np.pi / 30.0 / (2.5 * own))
    assert np.array([[one.value for one in two] for two in found.found]) == pytest.approx(
        np.array([[least, 0.08]]), rel=1e-9
    )


def altered(**words: Any) -> dict[str, Any]:
    document = rotor(**{key: one for key, one in words.items() if key != "shaft"})
    document["links"]["shaft"] |= words.get("shaft", {})
    return document


FORCE = {"kind": "force", "on": "disc", "amplitude": "3 N", "speed": "9 Hz", "varies": "constant"}
WRONG = {
    "no spin": (
        altered(excitations={}, measures={"own": {"response": "natural_frequency"}}),
        "links.shaft.rotating_damping turns with a shaft, but nothing spins. Add an excitation with kind = "
        '"unbalance", whose speed is the spin, or ask for the response = "stability_threshold".',
    ),
    "a force": (
        altered(excitations={"f": FORCE}),
        "excitations.f is no unbalance, but links.shaft.rotating_damping turns with a shaft: it brakes what whirls "
        "slower than it spins in another way forward than backward. Shake with unbalances at steady speeds, or leave "
        "it out.",
    ),
    "free vibration": (
        altered(measures={"r": {"response": "damping_ratio"}}),
        "measures.r asks for the damping ratio of free vibration, which is another at every spin where links.shaft has "
        "a damping that turns with the shaft. Ask for the stability_threshold, or leave the rotating damping out.",
    ),
    "both ways": (
        altered(shaft={"rotating_damping_ratio": 0.01}),
        "links.shaft gives rotating_damping and rotating_damping_ratio. Keep one: they are two ways to say one "
        "damping.",
    ),
    "nothing turns": (
        altered(shaft={"rotating_damping": "0 N s/m"}),
        "measures.least asks for the stability_threshold, but no damper turns with a shaft: nothing makes its whirl "
        'grow. Write rotating_damping = "40 N s/m" on a link, or ask for something else.',
    ),
}


@pytest.mark.parametrize(("document", "said"), WRONG.values(), ids=WRONG)
def test_what_does_not_spin_is_told(document: dict[str, Any], said: str) -> None:
    caught = refused(from_dict, document)
    assert any(one.endswith(said) for one in caught.messages), caught.messages


def test_what_no_spring_calls_back_grows_at_any_spin() -> None:
    one = np.eye(1)
    assert threshold(3.0 * one, 2.0 * one, 4.0 * one, 0.0 * one) == 0.0
    assert threshold_in_planes(3.0 * one, 6.0 * one, 4.0 * one, 0.0 * one) == 0.0


@pytest.mark.parametrize("seed", range(4))
def test_bearings_without_mass_are_in_both_routes(seed: int) -> None:
    mass, fixed, rotating, stiffness = chain(seed, 3, 1)
    mass[0, 0] = 0.0
    found = threshold(mass, fixed, rotating, stiffness)
    assert threshold_in_planes(mass, fixed + rotating, rotating, stiffness) == pytest.approx(found, rel=1e-6)
    mass[0, 0] = 1e-9
    assert threshold(mass, fixed, rotating, stiffness) == pytest.approx(found, rel=1e-6)


def test_a_broken_link_is_told_alone() -> None:
    caught = refused(from_dict, altered(shaft={"rotating_damping": "-3 N s/m"}))
    assert [one.partition(": ")[2] for one in caught.messages] == [
        'links.shaft.rotating_damping = "-3 N s/m" is negative. Write a positive value, for example "5 kN s/m".'
    ]


def test_the_thinnest_stable_shaft_spins_at_its_threshold() -> None:
    limits = {"stable": {"response": "stability_threshold", "at_least": "6000 rpm"}}
    document = rotor(limits=limits, goal={"minimise": "stiffness", "of": "shaft"})
    document["links"]["shaft"]["beam"]["diameter"] = {"from": "20 mm", "to": "60 mm"}
    document["excitations"]["u"]["speed"] = "6000 rpm"
    found = solve(from_dict(document), explain=False)
    assert found.status == "optimal", found.claim
    assert found.measures["least"].value.value == pytest.approx(200.0 * np.pi, rel=1e-8)


def test_designs_that_may_spin_beyond_their_threshold_are_asked_with_a_limit_on_it() -> None:
    limits = {"whirl": {"response": "displacement", "of": "disc", "at_most": "1 mm"}}
    document = rotor(limits=limits, goal={"find_all": "links.shaft.beam.diameter"})
    document["links"]["shaft"]["beam"]["diameter"] = {"from": "20 mm", "to": "60 mm"}
    document["excitations"]["u"]["speed"] = "6000 rpm"
    assert refused(from_dict, document, name="rotor.toml").messages == (
        "rotor.toml: limits.whirl asks for a steady whirl at up to 6000 rpm, but links.shaft.rotating_damping makes it "
        "grow without end beyond a threshold that hangs on what is chosen. Forbid such designs: add a limit with "
        'response = "stability_threshold" and at_least = "6000 rpm".',
    )
    document["limits"]["stable"] = {"response": "stability_threshold", "at_least": "6000 rpm"}
    assert from_dict(document).variables


def test_the_limit_that_is_asked_for_is_no_lower_than_the_speed_that_has_more_digits() -> None:
    """A threshold of 2 ppm less than the speed was let pass, and ended in `check_failed`."""
    limits = {"whirl": {"response": "displacement", "of": "disc", "at_most": "1 mm"}}
    document = rotor(limits=limits, goal={"minimise": "stiffness", "of": "shaft"})
    document["links"]["shaft"]["beam"]["diameter"] = {"from": "20 mm", "to": "60 mm"}
    document["excitations"]["u"]["speed"] = "6000.003 rpm"
    (said,) = refused(from_dict, document, name="rotor.toml").messages
    assert said.endswith('and at_least = "6000.06 rpm".')
    document["limits"]["stable"] = {"response": "stability_threshold", "at_least": "5999.99 rpm"}
    assert refused(from_dict, document, name="rotor.toml").messages == (said,)
    document["limits"]["stable"]["at_least"] = "6000.06 rpm"
    assert solve(from_dict(document), explain=False).status == "optimal"


def test_speeds_beyond_the_threshold_have_no_table() -> None:
    limits = {"whirl": {"response": "displacement", "of": "disc", "at_most": "1 mm"}}
    document = rotor(limits=limits, goal={"find_all": "u.speed"})
    document["excitations"]["u"]["speed"] = {"from": "100 rpm", "to": "90000 rpm"}
    found = solve(from_dict(document), explain=False)
    assert (found.status, found.found) == ("check_failed", None)
    assert "beyond its stability threshold" in found.claim
