"""Drive lines with gears: closed form, referred lines put together here, torques of teeth by Newton, and the words."""

from __future__ import annotations

import copy
import json
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import vibopt as vo
from refusals import refused

LINE: dict[str, Any] = {
    "title": "drive line",
    "bodies": {
        "engine": {"inertia": "12 kg m2"},
        "pinion": {"inertia": "0.8 kg m2"},
        "wheel": {"inertia": "9 kg m2", "geared_to": "pinion", "speed_ratio": -0.3},
        "screw": {"inertia": "60 kg m2"},
        "idler": {"inertia": "0.3 kg m2", "geared_to": "wheel", "speed_ratio": -5.0},
        "pump": {"inertia": "0.5 kg m2"},
    },
    "links": {
        "coupling": {"between": ["engine", "pinion"], "torsional_stiffness": "0.4 MN m/rad", "loss_factor": 0.1},
        "shaft": {
            "between": ["wheel", "screw"],
            "shaft": {"length": "6 m", "diameter": "110 mm", "shear_modulus": "80 GPa"},
        },
        "spindle": {"between": ["idler", "pump"], "torsional_stiffness": "30 kN m/rad"},
        "water": {"between": ["screw", "ground"], "torsional_damping": "400 N m s/rad"},
    },
    "excitations": {
        "firing": {"kind": "moment", "on": "engine", "amplitude": "1 kN m", "speed": "12 Hz", "varies": "constant"}
    },
    "measures": {
        "screw": {"response": "rotation", "of": "screw"},
        "teeth": {"response": "gear_torque", "of": "wheel"},
        "idler": {"response": "gear_torque", "of": "idler"},
        "stress": {"response": "shear_stress", "of": "shaft"},
        "into": {"response": "transmitted_moment", "into": "wheel"},
        "water": {"response": "transmitted_moment", "into": "ground"},
        "first": {"response": "natural_frequency", "mode": 2},
        "third": {"response": "natural_frequency", "mode": 4},
    },
}


def measured(document: dict[str, Any]) -> dict[str, float]:
    answer = vo.solve(vo.from_dict(document))
    assert answer.status == "met", answer.claim
    return {name: row.value.value for name, row in answer.measures.items()}


def test_a_base_at_rest_is_the_ground() -> None:
    document = json.loads(json.dumps(LINE).replace('"ground"', '"wall"'))
    assert measured({**document, "bases": {"wall": {}}}) == measured(LINE)


def referred(ratio: float, other: float, coupling: float, omega: float) -> dict[str, float]:
    """The line at the engine's speed: an inertia or a stiffness at n times it counts n^2 times; torques by Newton."""
    inertias = np.array(
        [12.0, 0.8 + 9.0 * ratio**2 + 0.3 * (ratio * other) ** 2, 60.0 * ratio**2, 0.5 * (ratio * other) ** 2]
    )
    polar = np.pi * 0.11**4 / 32.0
    shaft, spindle = 80e9 * polar / 6.0, 30e3
    springs = [(0, 1, coupling), (1, 2, shaft * ratio**2), (1, 3, spindle * (ratio * other) ** 2)]
    stiff, lossy = np.zeros((4, 4)), np.zeros((4, 4), dtype=complex)
    for i, j, k in springs:
        for a, b, sign in ((i, i, 1), (j, j, 1), (i, j, -1), (j, i, -1)):
            stiff[a, b] += sign * k
            lossy[a, b] += sign * k * (1.0 + 0.1j * (i == 0))
    lossy[2, 2] += 1j * omega * 400.0 * ratio**2
    turned = np.linalg.solve(lossy - omega**2 * np.diag(inertias), [1e3, 0, 0, 0])
    wheel, screw, idler, pump = (
        turned[1] * ratio,
        turned[2] * ratio,
        turned[1] * ratio * other,
        turned[3] * ratio * other,
    )
    on_idler = -(omega**2) * 0.3 * idler + spindle * (idler - pump)
    on_wheel = -(omega**2) * 9.0 * wheel + shaft * (wheel - screw) + other * on_idler
    frequencies = np.sqrt(np.sort(np.linalg.eigvals(stiff / inertias[:, None]).real).clip(0.0))
    return {
        "screw": abs(screw), "teeth": abs(on_wheel), "idler": abs(on_idler), "into": abs(shaft * (wheel - screw)),
        "stress": abs(shaft * (screw - wheel)) * 0.055 / polar, "water": abs(400.0 * omega * screw),
        "first": frequencies[1], "third": frequencies[3],
    }  # fmt: skip


@given(
    ratio=st.floats(-4.0, 4.0).filter(lambda one: abs(one) > 0.1),
    other=st.floats(-6.0, 6.0).filter(lambda one: abs(one) > 0.1),
    coupling=st.floats(1e4, 1e7),
    speed=st.floats(1.0, 80.0),
)
def test_a_branched_line_is_the_one_that_is_referred_to_its_engine(
    ratio: float, other: float, coupling: float, speed: float
) -> None:
    document = copy.deepcopy(LINE)
    document["bodies"]["wheel"]["speed_ratio"] = ratio
    document["bodies"]["idler"]["speed_ratio"] = other
    document["links"]["coupling"]["torsional_stiffness"] = f"{coupling!r} N m/rad"
    document["excitations"]["firing"]["speed"] = f"{speed!r} Hz"
    known = referred(ratio, other, coupling, 2.0 * np.pi * speed)
    for name, value in measured(document).items():
        assert value == pytest.approx(known[name], rel=1e-8), name


@given(
    ratio=st.floats(-4.0, 4.0).filter(lambda one: abs(one) > 0.1),
    damping=st.floats(1.0, 1e4),
    inertance=st.floats(0.1, 30.0),
    spring=st.floats(1e4, 1e6),
)
def test_a_spring_on_one_gear_holds_the_other_at_rest_where_only_a_damper_or_an_inerter_does(
    ratio: float, damping: float, inertance: float, spring: float
) -> None:
    """Referred to the pinion: one oscillator of J + n^2 J', k n^2 and c; at rest the damper and the inerter are not."""
    document: dict[str, Any] = {
        "title": "held by its gear",
        "bodies": {
            "pinion": {"inertia": "10 kg m2"},
            "wheel": {"inertia": "5 kg m2", "geared_to": "pinion", "speed_ratio": ratio},
        },
        "links": {"spring": {"between": ["wheel", "ground"], "torsional_stiffness": f"{spring!r} N m/rad"}},
        "excitations": {
            "push": {"kind": "moment", "on": "pinion", "amplitude": "100 N m", "speed": "1 Hz", "varies": "constant"}
        },
        "measures": {
            "turned": {"response": "rotation", "of": "wheel", "over": "start-up"},
            "twisted": {"response": "twist", "across": "brake", "over": "start-up"},
        },
    }
    referred_spring, inertia = spring * ratio**2, 10.0 + 5.0 * ratio**2
    top = float(min(0.4 * np.sqrt(referred_spring / (inertia + inertance)), 100.0))
    document["excitations"]["push"]["speed"] = f"{top!r} rad/s"
    speeds = np.linspace(0.0, top, 2001)
    braked = copy.deepcopy(document)
    braked["links"]["brake"] = {"between": ["pinion", "ground"], "torsional_damping": f"{damping!r} N m s/rad"}
    document["inerters"] = {"brake": {"between": ["pinion", "ground"], "torsional_inertance": f"{inertance!r} kg m2"}}
    for one, damper, whole in ((braked, damping, inertia), (document, 0.0, inertia + inertance)):
        turned = np.abs(100.0 / (referred_spring - whole * speeds**2 + 1j * damper * speeds)).max()
        found = measured(one)
        assert found["twisted"] == pytest.approx(turned, rel=1e-5)
        assert found["turned"] == pytest.approx(abs(ratio) * turned, rel=1e-5)


def test_two_shafts_with_light_gears_are_springs_in_a_row() -> None:
    """w^2 = k (1 / J1 + 1 / n^2 J2) with 1 / k = 1 / k1 + 1 / n^2 k2: gears have no inertia (Rao, Den Hartog)."""
    document = {
        "title": "two gears",
        "bodies": {
            "motor": {"inertia": "3 kg m2"}, "pinion": {"inertia": "0 kg m2"},
            "wheel": {"inertia": "0 kg m2", "geared_to": "pinion", "speed_ratio": -0.25},
            "drum": {"inertia": "80 kg m2"},
        },
        "links": {
            "fast": {"between": ["motor", "pinion"], "torsional_stiffness": "20 kN m/rad"},
            "slow": {"between": ["wheel", "drum"], "torsional_stiffness": "500 kN m/rad"},
        },
        "measures": {"twisting": {"response": "natural_frequency", "mode": 2}},
    }  # fmt: skip
    spring = 1.0 / (1.0 / 20e3 + 16.0 / 500e3)
    assert measured(document)["twisting"] == pytest.approx(np.sqrt(spring * (1.0 / 3.0 + 16.0 / 80.0)), rel=1e-12)


def test_every_coupling_under_a_hammer_limit_ends_where_the_referred_line_reaches_it() -> None:
    document = copy.deepcopy(LINE)
    document["links"]["coupling"]["torsional_stiffness"] = {"from": "20 kN m/rad", "to": "2 MN m/rad"}
    document["limits"] = {"hammer": {"response": "gear_torque", "of": "wheel", "at_most": "1.4 kN m"}}
    document["goal"] = {"find_all": "links.coupling.torsional_stiffness"}
    answer = vo.solve(vo.from_dict(document))
    assert answer.status == "met", answer.claim
    ends = [end for part in answer.found for end in (part[0].value, part[1].value) if 20e3 < end < 2e6]
    torques = [referred(-0.3, -5.0, end, 24.0 * np.pi)["teeth"] for end in ends]
    assert torques == pytest.approx([1.4e3] * len(ends), rel=1e-7)
    many = np.geomspace(20e3, 2e6, 400)
    inside = [any(part[0].value <= one <= part[1].value for part in answer.found) for one in many]
    assert inside == [referred(-0.3, -5.0, one, 24.0 * np.pi)["teeth"] <= 1.4e3 for one in many]
    assert len(ends) >= 1


REFUSED: dict[str, tuple[dict[str, Any], str]] = {
    "a whirl": (
        {"measures.whirls": {"response": "critical_speed"}},
        "measures.whirls asks for the critical_speed, at which a shaft that bends whirls, and bodies.engine turns "
        'about its axis. Write response = "natural_frequency", with outside = { orders = [1, 2], of = "engine", margin '
        '= "15 %" } for the orders of what shakes it.',
    ),
    "itself": (
        {"bodies.wheel.geared_to": "wheel"},
        'bodies.wheel.geared_to = "wheel" is the body itself. Name the one whose teeth turn it.',
    ),
    "a slip": (
        {"bodies.wheel.geared_to": "pinon"},
        'bodies.wheel.geared_to = "pinon" names no other body of this scene. Did you mean "pinion"?',
    ),
    "a ring": (
        {"bodies.wheel.geared_to": "idler"},
        'bodies.wheel.geared_to = "idler" is geared to wheel in turn. One body of a train of gears is geared to '
        "no other.",
    ),
    "no turning": (
        {"bodies.wheel.speed_ratio": 0},
        "bodies.wheel has a speed_ratio of zero, so that it never turns. Write how many times as fast it turns.",
    ),
    "no ratio": (
        {"bodies.wheel.speed_ratio": None},
        'bodies.wheel needs geared_to and speed_ratio together. Write geared_to = "pinion" and speed_ratio = -0.25.',
    ),
    "to what slides": (
        {"bodies.pinion": {"mass": "3 kg"}},
        'bodies.wheel.geared_to = "pinion" does not turn about its axis. Give it an inertia instead of its mass.',
    ),
    "what slides": (
        {"bodies.pump": {"mass": "3 kg", "geared_to": "idler", "speed_ratio": 2}},
        "bodies.pump moves along a line and is geared. Give it an inertia instead of the mass, or remove geared_to.",
    ),
    "a link within": (
        {"links.coupling.between": ["wheel", "pinion"]},
        'links.coupling.between = ["wheel", "pinion"] joins two bodies of one train of gears, which turn as one '
        "already. Leave it out, or one of the gears.",
    ),
    "teeth of none": (
        {"measures.teeth.of": "pinion"},
        'measures.teeth.of = "pinion" names no geared body of this scene. Known: wheel, idler.',
    ),
    "driven behind": (
        {"excitations.firing.on": "idler"},
        "measures.teeth asks for the gear_torque of wheel, which would have to balance excitations.firing on idler as "
        "well. Write the gears the other way round, pinion geared to wheel, and ask of pinion; or put the excitation "
        "on a body of its own that a shaft joins to idler.",
    ),
    "a structure": (
        {"structures.deck": {"modes": [{"frequency": "9 Hz", "mass": "2000 kg", "shape": {"mid": 1}}]}},
        "bodies.wheel is geared beside deck. Gears are answered among bodies that turn about one axis. Leave the other "
        "out.",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_gears_that_cannot_be_are_told_in_a_sentence(case: str) -> None:
    changes, words = REFUSED[case]
    document = copy.deepcopy(LINE)
    for path, value in changes.items():
        *steps, last = path.split(".")
        table = document
        for step in steps:
            table = table.setdefault(step, {})
        table[last] = value
        if value is None:
            del table[last]
    said = refused(vo.from_dict, document, name="drive.toml").messages
    assert f"drive.toml: {words}" in said
    alone = ("itself", "a slip", "no turning", "no ratio", "what slides")
    assert len(said) == 1 or case not in alone, "nothing more is told of what a wrong gear does not turn"


@given(inertia=st.floats(1.0, 90.0), ratio=st.floats(0.1, 4.0), speed=st.floats(1.0, 9.0))
def test_a_light_pinion_hands_the_inertia_of_its_wheel_on(inertia: float, ratio: float, speed: float) -> None:
    """One coupling alone ends at it, which so carries the wheel."""
    line: dict[str, Any] = {
        "title": "light pinion",
        "bodies": {
            "engine": {"inertia": "9 kg m2"},
            "pinion": {"inertia": "0 kg m2"},
            "wheel": {"inertia": f"{inertia!r} kg m2", "geared_to": "pinion", "speed_ratio": -ratio},
        },
        "links": {
            "coupling": {
                "between": ["engine", "pinion"],
                "torsional_stiffness": "20 kN m/rad",
                "torsional_damping": "80 N m s/rad",
            }
        },
        "excitations": {
            "firing": {
                "kind": "moment",
                "on": "engine",
                "amplitude": "1 kN m",
                "speed": f"{speed!r} Hz",
                "varies": "constant",
            }
        },
        "measures": {"engine": {"response": "rotation", "of": "engine"}},
    }
    omega = 2.0 * np.pi * speed
    spring, wheel = 20e3 + 80j * omega, -inertia * ratio**2 * omega**2
    through = spring * wheel / (spring + wheel)
    assert measured(line)["engine"] == pytest.approx(abs(1e3 / (through - 9.0 * omega**2)), rel=1e-9)
