"""Inerters and jerk against closed forms: one mass, one disc, an absorber with an inerter to the ground."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import vibopt as vo
from refusals import refused
from vibopt.jobs import with_changes
from vibopt.scene.read import from_dict
from vibopt.solve import solve

LAYOUTS = Path(__file__).parents[2] / "problems" / "absorbers" / "inerter_layouts.toml"
FORCE = {"kind": "force", "on": "pump", "amplitude": "300 N", "speed": "5..30 Hz", "varies": "constant"}
PUMP: dict[str, Any] = {
    "title": "pump on a mount beside an inerter",
    "bodies": {"pump": {"mass": "120 kg"}},
    "links": {"mount": {"between": ["pump", "ground"], "stiffness": "200 kN/m", "damping": "1 kN s/m"}},
    "inerters": {"flywheel": {"between": ["pump", "ground"], "inertance": "40 kg"}},
    "excitations": {"rotor": FORCE},
}


def asked(document: dict[str, Any], **measures: Any) -> dict[str, float]:
    """Values of some measures; both routes have agreed on them."""
    design = solve(from_dict({**document, "measures": measures}))
    assert design.status == "met", design.claim
    return {name: one.value.value for name, one in design.measures.items()}


@given(
    mass=st.floats(1.0, 1e4),
    ratio=st.floats(1e-3, 10.0),
    stiffness=st.floats(1e3, 1e7),
    damping_ratio=st.floats(1e-3, 0.5),
    speed=st.floats(0.1, 50.0),
)
def test_one_mass_beside_an_inerter_is_a_heavier_mass_of_the_same_weight(
    mass: float, ratio: float, stiffness: float, damping_ratio: float, speed: float
) -> None:
    """(k + i w c - w^2 b) x through the support, on (k + i w c - w^2 (m + b)) x = F."""
    inertance, damping = ratio * mass, float(2.0 * damping_ratio * np.sqrt(stiffness * mass))
    document = copy.deepcopy(PUMP)
    document["bodies"]["pump"]["mass"] = f"{mass!r} kg"
    document["links"]["mount"] |= {"stiffness": f"{stiffness!r} N/m", "damping": f"{damping!r} N s/m"}
    document["inerters"]["flywheel"] = {"between": ["pump", "ground"], "mass_ratio": ratio, "relative_to": "pump"}
    at = {"at": f"{speed!r} Hz"}
    found = asked(
        document,
        jerk={"response": "jerk", "of": "pump", **at},
        floor={"response": "transmitted_force", "into": "ground", **at},
        own={"response": "transmitted_force", "through": "flywheel", **at},
        mode={"response": "natural_frequency"},
        decay={"response": "decay_rate"},
        sag={"response": "static_deflection", "of": "pump"},
        weight={"response": "total_mass"},
    )
    w = 2.0 * np.pi * speed
    through = stiffness + 1j * w * damping - w**2 * inertance
    x = 300.0 / (through - w**2 * mass)
    both = mass + inertance
    assert found["jerk"] == pytest.approx(abs(x) * w**3, rel=1e-9)
    size = 1e-9 * abs(x) * (stiffness + w**2 * inertance)
    assert found["floor"] == pytest.approx(abs(through * x), rel=1e-9, abs=size)
    assert found["own"] == pytest.approx(w**2 * inertance * abs(x), rel=1e-9)
    assert found["mode"] == pytest.approx(np.sqrt(stiffness / both), rel=1e-9)
    half = 0.5 * damping / both
    slow = half - np.sqrt(max(half**2 - stiffness / both, 0.0))
    assert found["decay"] == pytest.approx(slow, rel=1e-6)
    assert found["sag"] == pytest.approx(mass * 9.80665 / stiffness, rel=1e-9)
    assert found["weight"] == pytest.approx(mass, rel=1e-12)


def test_an_inertance_that_is_chosen_moves_the_antiresonance_to_the_speed() -> None:
    """Without damping nothing is transmitted at w = sqrt(k / b)."""
    document = copy.deepcopy(PUMP)
    del document["links"]["mount"]["damping"]
    document["inerters"]["flywheel"]["inertance"] = {"from": "1 kg", "to": "100 kg"}
    goal = {"minimise": "transmitted_force", "into": "ground", "at": "20 Hz"}
    design = solve(from_dict({**document, "goal": goal}))
    assert design.status == "optimal"
    chosen = design.variables["inerters.flywheel.inertance"].value.value
    assert chosen == pytest.approx(200e3 / (40.0 * np.pi) ** 2, rel=1e-4)
    assert design.goal is not None
    assert design.goal[1].value < 1e-2


def test_the_best_inertance_over_a_range_is_that_of_a_fine_grid() -> None:
    document = copy.deepcopy(PUMP)
    document["inerters"]["flywheel"]["inertance"] = {"from": "0.1 kg", "to": "100 kg"}
    goal = {"minimise": "transmitted_force", "into": "ground", "over": "12..20 Hz"}
    design = solve(from_dict({**document, "goal": goal}))
    assert design.status == "optimal"
    w, b = 2.0 * np.pi * np.linspace(12.0, 20.0, 400), np.linspace(0.1, 100.0, 2001)[:, None]
    through = 200e3 + 1e3j * w - b * w**2
    worst = np.abs(300.0 * through / (through - 120.0 * w**2)).max(axis=1)
    assert design.goal is not None
    assert design.goal[1].value == pytest.approx(worst.min(), rel=2e-3)
    assert design.goal[1].value <= worst.min() * (1.0 + 1e-6)


def test_a_tuned_mass_damper_with_an_inerter_to_the_ground_is_two_equations() -> None:
    document = copy.deepcopy(PUMP)
    document["absorbers"] = {"tmd": {"on": "pump", "mass": "6 kg", "stiffness": "12 kN/m", "damping": "40 N s/m"}}
    document["inerters"] = {"flywheel": {"between": ["tmd", "ground"], "inertance": "3 kg"}}
    found = asked(
        document,
        pump={"response": "displacement", "of": "pump", "at": "7 Hz"},
        stroke={"response": "stroke", "of": "tmd", "at": "7 Hz"},
        floor={"response": "transmitted_force", "into": "ground", "at": "7 Hz"},
    )
    w = 14.0 * np.pi
    k, c, b = 200e3 + 1e3j * w, 12e3 + 40j * w, -3.0 * w**2
    x, y = np.linalg.solve([[k + c - 120.0 * w**2, -c], [-c, c + b - 6.0 * w**2]], [300.0, 0.0])
    assert found["pump"] == pytest.approx(abs(x), rel=1e-10)
    assert found["stroke"] == pytest.approx(abs(y - x), rel=1e-10)
    assert found["floor"] == pytest.approx(abs(k * x + b * y), rel=1e-10)


def test_a_tuning_refers_to_the_machine_with_the_inerters_that_end_at_no_absorber() -> None:
    document = copy.deepcopy(PUMP)
    document["absorbers"] = {"tmd": {"on": "pump", "mass": "6 kg", "tuning": 1.0, "damping_ratio": 0.1}}
    document["inerters"]["second"] = {"between": ["tmd", "ground"], "inertance": "3 kg"}
    found = asked(document, own={"response": "own_frequency", "of": "tmd"}, as_said={"response": "tuning", "of": "tmd"})
    assert found["own"] == pytest.approx(np.sqrt(200e3 / 160.0), rel=1e-12)
    assert found["as_said"] == pytest.approx(1.0, rel=1e-12)


def test_a_torsional_inerter_adds_to_the_inertia_of_a_disc() -> None:
    document = {
        "title": "disc",
        "bodies": {"disc": {"inertia": "2 kg m2"}},
        "links": {"shaft": {"between": ["disc", "ground"], "torsional_stiffness": "9 kN m/rad"}},
        "inerters": {"flywheel": {"between": ["disc", "ground"], "torsional_inertance": "0.5 kg m2"}},
        "excitations": {
            "torque": {"kind": "moment", "on": "disc", "amplitude": "9 N m", "speed": "2 Hz", "varies": "constant"}
        },
    }
    found = asked(
        document,
        mode={"response": "natural_frequency"},
        jerk={"response": "angular_jerk", "of": "disc"},
        shaft={"response": "transmitted_moment", "through": "flywheel"},
    )
    w = 4.0 * np.pi
    turn = 9.0 / (9e3 - 2.5 * w**2)
    assert found["mode"] == pytest.approx(60.0, rel=1e-12)
    assert found["jerk"] == pytest.approx(turn * w**3, rel=1e-12)
    assert found["shaft"] == pytest.approx(turn * 0.5 * w**2, rel=1e-12)


def test_an_inertance_within_its_tolerance_is_worst_at_an_end() -> None:
    document = copy.deepcopy(PUMP)
    document["inerters"]["flywheel"]["tolerance"] = "10 %"
    found = asked(document, force={"response": "transmitted_force", "into": "ground", "at": "20 Hz"})
    w = 40.0 * np.pi
    each = []
    for b in (36.0, 44.0):
        through = 200e3 + 1e3j * w - b * w**2
        each.append(abs(300.0 * through / (through - 120.0 * w**2)))
    assert found["force"] == pytest.approx(max(each), rel=1e-10)


def test_a_ratio_to_a_body_in_space_is_one_of_its_mass_as_said() -> None:
    document: dict[str, Any] = {
        "bodies": {"pump": {"mass": "200 kg", "inertia": ["10 kg m2", "12 kg m2", "9 kg m2"]}},
        "mounts": {
            "foot": {
                "between": ["pump", "ground"],
                "at": [[x, y, "0 m"] for x in ("-0.4 m", "0.4 m") for y in ("-0.3 m", "0.3 m")],
                "stiffness": ["200 kN/m", "200 kN/m", "400 kN/m"],
            }
        },
        "excitations": {"rotor": {**FORCE, "direction": "z"}},
    }
    place = {"between": ["pump", "ground"], "at": ["0.4 m", "0.3 m", "0 m"], "direction": "z"}
    ask = {"jerk": {"response": "jerk", "of": "pump", "direction": "z", "at": "9 Hz"}}
    plain = asked({**document, "inerters": {"one": {**place, "inertance": "30 kg"}}}, **ask)
    ratio = asked({**document, "inerters": {"one": {**place, "mass_ratio": 0.15, "relative_to": "pump"}}}, **ask)
    assert ratio["jerk"] == pytest.approx(plain["jerk"], rel=1e-12)


@pytest.mark.parametrize(("noise", "place"), [("force", "pump"), ("base", "ground")])
def test_random_vibration_beside_an_inerter_is_that_of_the_sum_over_frequencies(noise: str, place: str) -> None:
    """A Lyapunov equation and a sum over all frequencies agree, and S_0 / (4 c k) of any mass with them."""
    document = copy.deepcopy(PUMP)
    document["excitations"] = {"hiss": {"kind": "white_noise", "on": place, "density": "100 N2/Hz"}}
    if noise == "base":
        document["bases"] = {"floor": {}}
        for family in ("links", "inerters"):
            for table in document[family].values():
                table["between"] = ["pump", "floor"]
        document["excitations"]["hiss"] = {"kind": "white_noise", "on": "floor", "density": "0.01 (m/s²)²/Hz"}
    found = asked(document, rms={"response": "rms_relative_displacement", "across": "mount"})
    density = 100.0 if noise == "force" else 0.01 * 120.0**2
    square = density / (4.0 * 1e3 * 200e3)
    assert found["rms"] == pytest.approx(np.sqrt(square), rel=1e-6)


REFUSED: dict[str, tuple[dict[str, Any], str]] = {
    "nothing": (
        {"inertance": None},
        'inerters.flywheel needs one of inertance, mass_ratio and torsional_inertance. Write inertance = "40 kg".',
    ),
    "turning": (
        {"inertance": None, "torsional_inertance": "2 kg m2"},
        "inerters.flywheel.torsional_inertance is about an axis, but pump moves along a line. Write inertance = "
        '"40 kg".',
    ),
    "ratio": (
        {"inertance": None, "mass_ratio": 0.1},
        "inerters.flywheel needs mass_ratio and relative_to together: the inertance over the mass of which body?",
    ),
    "nobody": (
        {"inertance": None, "mass_ratio": 0.1, "relative_to": "fan"},
        'inerters.flywheel.relative_to = "fan" names no body of this scene. Known: pump.',
    ),
    "end": (
        {"between": ["pump", "grund"]},
        'inerters.flywheel.between = ["pump", "grund"] names "grund", which is no body, base or ground. Did you mean '
        '"ground"?',
    ),
    "place": (
        {"at": ["0 m", "0 m", "0 m"], "direction": "z"},
        "inerters.flywheel has at, but neither of its ends moves in space. Remove at and direction.",
    ),
    "half a place": (
        {"at": ["0 m", "0 m", "0 m"]},
        "inerters.flywheel needs at and direction together: where it stands in space, and which way. Add direction = "
        '"z".',
    ),
    "key": ({"inertence": "4 kg"}, 'unknown key "inertence" in inerters.flywheel. Did you mean "inertance"?'),
}


@pytest.mark.parametrize(("change", "text"), REFUSED.values(), ids=REFUSED)
def test_mistakes_of_inerters_are_said(change: dict[str, Any], text: str) -> None:
    document = copy.deepcopy(PUMP)
    table = {**document["inerters"]["flywheel"], **change}
    document["inerters"]["flywheel"] = {key: one for key, one in table.items() if one is not None}
    document["measures"] = {"x": {"response": "displacement", "of": "pump"}}
    assert list(refused(from_dict, document).messages) == [f"scene: {text}"]


def test_what_an_inerter_does_not_have_is_not_asked_of_it() -> None:
    document = {**PUMP, "measures": {"k": {"response": "stiffness", "of": "flywheel"}}}
    assert list(refused(from_dict, document).messages) == [
        "scene: measures.k asks for the stiffness of flywheel, but inerters.flywheel has no stiffness. "
        "Ask for something else."
    ]


def test_jerk_of_what_turns_is_angular() -> None:
    document = {
        "title": "disc",
        "bodies": {"disc": {"inertia": "2 kg m2"}},
        "links": {"shaft": {"between": ["disc", "ground"], "torsional_stiffness": "9 kN m/rad"}},
        "excitations": {"torque": {"kind": "moment", "on": "disc", "amplitude": "9 N m", "speed": "2 Hz"}},
        "measures": {"j": {"response": "jerk", "of": "disc"}},
    }
    assert list(refused(from_dict, document).messages) == [
        'scene: measures.j asks for the jerk of disc, which turns. Write response = "angular_jerk".'
    ]


def test_identical_inerters_share_evenly() -> None:
    document = copy.deepcopy(PUMP)
    one = {"between": ["pump", "ground"], "inertance": {"from": "1 kg", "to": "40 kg"}}
    document["inerters"] = {"left": one, "right": dict(one)}
    goal = {"minimise": "transmitted_force", "into": "ground", "at": "20 Hz"}
    design = solve(from_dict({**document, "goal": goal}))
    left, right = (design.variables[f"inerters.{name}.inertance"].value.value for name in ("left", "right"))
    assert left == pytest.approx(right, rel=1e-9)
    w = 40.0 * np.pi
    b = np.linspace(2.0, 80.0, 100_001)
    through = 200e3 + 1e3j * w - b * w**2
    assert design.goal is not None
    assert design.goal[1].value == pytest.approx(np.abs(300.0 * through / (through - 120.0 * w**2)).min(), rel=1e-5)


def test_behind_a_spring_and_a_damper_an_inerter_to_the_ground_is_a_mass_without_weight() -> None:
    above = {f"links.{name}.between": ["machine", "joint"] for name in ("spring", "damper")}
    job = with_changes(vo.read(LAYOUTS), above)
    behind = vo.solve(job)
    document = {key: table for key, table in job.document.items() if key not in ("inerters", "expected", "scenarios")}
    document["bodies"] = {"machine": {"mass": "100 kg"}, "joint": {"mass": "10 kg"}}
    hung = solve(from_dict(document))
    assert (behind.status, hung.status) == ("optimal", "optimal")
    assert behind.goal is not None
    assert hung.goal is not None
    assert behind.goal[1].value == pytest.approx(hung.goal[1].value, rel=1e-6)
    sag = vo.solve(from_dict({**job.document, "measures": {"sag": {"response": "static_deflection", "of": "spring"}}}))
    assert sag.measures["sag"].value.value == 0.0


def test_before_a_damper_and_an_inerter_a_spring_is_tuned_as_a_search_on_fine_frequencies_finds() -> None:
    """|F / (k - m w^2 + 1 / (1 / s + 1 / (i w c - w^2 b)))|, and its peaks no higher for any spring and damper near."""
    design = vo.solve(vo.read(LAYOUTS))
    omega = np.linspace(1.0, 40.0 * np.pi, 400_001)

    def peak(spring: float, damper: float) -> float:
        inner = 1j * omega * damper - 10.0 * omega**2
        return float(np.abs(100.0 / (1e5 - 100.0 * omega**2 + 1.0 / (1.0 / spring + 1.0 / inner))).max())

    assert design.status == "optimal"
    assert design.goal is not None
    spring, damper = (design.variables[f"links.{one}"].value.value for one in ("spring.stiffness", "damper.damping"))
    assert design.goal[1].value == pytest.approx(peak(spring, damper), rel=1e-9)
    turns = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
    for far in (1e-3, 0.05):
        around = [peak(spring * np.exp(far * np.cos(one)), damper * np.exp(far * np.sin(one))) for one in turns]
        assert min(around) > design.goal[1].value * (1.0 - 1e-9)
