"""What every answer says of isolators is what a file that asks for it is told, and what a formula says."""

from __future__ import annotations

from math import pi, sqrt
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vibopt.mechanics.constants import GRAVITY
from vibopt.report.isolators import isolator_block, isolators_of
from vibopt.report.mode_shapes import shapes_of
from vibopt.report.what_to_build import machine_in
from vibopt.scene.read import from_dict, read
from vibopt.scene.scene import Design
from vibopt.solve import solve
from vibopt.verify.as_built import machine_of

PROBLEMS = Path(__file__).parents[2] / "problems"


def fan(mass: float, stiffness: float, ratio: float, count: int, **more: Any) -> dict[str, Any]:
    """One body on alike springs, shaken by a force."""
    return {
        "bodies": {"fan": {"mass": f"{mass!r} kg"}},
        "links": {
            "spring": {
                "between": ["fan", "ground"], "stiffness": f"{stiffness!r} N/m", "damping_ratio": ratio, "count": count,
            }
        },
        "excitations": {"push": {"kind": "force", "on": "fan", "amplitude": "50 N", "speed": "1450 rpm"}},
        "measures": {"through": {"response": "transmitted_force", "into": "ground"}},
        **more,
    }  # fmt: skip


@given(st.floats(5.0, 5e3), st.floats(1e3, 1e8), st.floats(0.005, 2.0), st.integers(1, 8))
def test_one_body_has_the_facts_of_the_formulas(mass: float, stiffness: float, ratio: float, count: int) -> None:
    scene = from_dict(fan(mass, stiffness, ratio, count), name="fan.toml")
    (one,) = isolators_of(scene, machine_of(scene, {}))
    together, answer = count * stiffness, solve(scene, explain=False)
    own = sqrt(together / mass)
    assert one.shape is not None
    assert one.sag is not None
    assert one.mode == pytest.approx((1, 1.0))
    assert one.shape.frequency == pytest.approx(own, rel=1e-9)
    assert one.shape.damping == pytest.approx(ratio, rel=1e-9)
    assert one.sag.value.value == pytest.approx(mass * GRAVITY / together, rel=1e-9)
    force = answer.measures["through"].value.value
    assert 1.0 - one.isolation["push"].value.value == pytest.approx(force / 50.0, rel=1e-7)


def of_file(name: str) -> Design:
    return solve(read(PROBLEMS / f"{name}.toml"), explain=False)


CHAINS = ["isolation/rao_9_44_printed_design", "absorbers/rao_9_55_printed_design", "isolation/rao_9_1"]
SPACE = ["mounts/focalised_engine"]


@pytest.mark.parametrize("name", [*CHAINS, *SPACE])
def test_a_file_that_asks_is_told_the_same(name: str) -> None:
    """The measures are answered by the model as well, which shares no matrices with the machine as built."""
    design = of_file(name)
    scene, machine = design.scene, machine_of(design.scene, {})
    asked: dict[str, Any] = {}
    facts: dict[str, float] = {}
    for number, shape in enumerate(shapes_of(machine), start=1):
        asked[f"mode {number}"] = {"response": "natural_frequency", "mode": number}
        facts[f"mode {number}"] = shape.frequency
    for one in isolators_of(scene, machine):
        if one.sag is not None:
            asked[f"sag of {one.name}"] = {"response": "static_deflection", "of": one.name}
            facts[f"sag of {one.name}"] = one.sag.value.value
        for shaker, row in one.isolation.items():
            key, _, place = row.place.partition(" ")
            asked[f"{one.name} of {shaker}"] = {"response": "isolation", key: place, "due_to": [shaker]}
            facts[f"{one.name} of {shaker}"] = row.value.value
    answer = solve(from_dict({**scene.document, "measures": asked, "expected": []}, name=scene.name), explain=False)
    assert answer.status == design.status
    assert {key: row.value.value for key, row in answer.measures.items()} == pytest.approx(facts, rel=1e-8)


def test_a_machine_beyond_its_mounts_keeps_its_facts() -> None:
    """It is allowed because its file asks what a mount that is pulled carries."""
    document: dict[str, Any] = {
        "bodies": {"box": {"mass": "100 kg", "inertia": ["9 kg m2"] * 3, "centre": ["0.7 m", "0 m", "0 m"]}},
        "mounts": {
            "foot": {
                "between": ["box", "ground"], "at": CORNERS, "shear_ratio": 0.5,
                "stiffness": "100 kN/m", "loss_factor": 0.1,
            }
        },
        "excitations": {"it": {"kind": "force", "on": "box", "amplitude": "7 N", "direction": "z", "speed": "900 rpm"}},
        "measures": {"pull": {"response": "static_load", "of": "foot.1"}},
    }  # fmt: skip
    (one,) = isolators_of(scene := from_dict(document), machine_of(scene, {}))
    document["measures"] |= {
        "sag": {"response": "static_deflection", "of": "foot"},
        "through": {"response": "transmitted_force", "into": "ground", "direction": "z"},
    }
    told = solve(from_dict(document), explain=False).measures
    assert told["pull"].value.value < 0.0
    assert one.sag is not None
    assert one.sag.value.value == pytest.approx(told["sag"].value.value, rel=1e-9)
    assert 1.0 - one.isolation["along z"].value.value == pytest.approx(told["through"].value.value / 7.0, rel=1e-9)


def test_the_mode_of_an_isolator_is_the_one_that_its_stiffness_moves_most() -> None:
    """The share of strain energy is what the square of a frequency gains by one part of the stiffness."""
    scene = read(PROBLEMS / "isolation/rao_9_44_printed_design.toml")
    machine = machine_of(scene, {})
    for one in isolators_of(scene, machine):
        assert one.mode is not None
        number, share = one.mode
        step = 1e-4
        squares = []
        for part in (1.0 - step, 1.0 + step):
            changed = dict(scene.document)
            links = {name: dict(table) for name, table in changed["links"].items()}
            value, unit = links[one.name]["stiffness"].split(" ", 1)
            links[one.name]["stiffness"] = f"{float(value) * part!r} {unit}"
            other = from_dict({**changed, "links": links, "expected": []}, name="other.toml")
            squares.append(machine_of(other, {}).natural_frequencies() ** 2)
        gains = (squares[1] - squares[0]) / (squares[1] + squares[0]) / step
        assert gains.argmax() == number - 1
        assert gains.max() == pytest.approx(share, rel=1e-4)


def test_an_answer_begins_with_what_to_build_and_ends_with_what_to_type() -> None:
    document = fan(120.0, 95e3, 0.05, 4, title="Fan")
    document["links"]["spring"]["stiffness"] = {"from": "1 kN/m", "to": "1 MN/m"}
    document["limits"] = {"floor": {"response": "transmitted_force", "into": "ground", "at_most": "10 N"}}
    document["goal"] = {"maximise": "stiffness", "of": "spring"}
    design = solve(from_dict(document, name="fan.toml"), explain=False)
    each = design.variables["links.spring.stiffness"].value.value
    said = design.report().splitlines()
    build = said.index("What to build")
    words = " ".join(" ".join(said[build + 1 : build + 3]).split())
    assert words.startswith(f"spring 4 springs of {each / 1e3:.4g} kN/m each, {4 * each / 1e3:.4g} kN/m together, damp")
    assert said[-2:] == ["Next    round the values for the drawing:", "        vibopt solve fan.toml --round 3"]
    order = [said.index(one) for one in ("What to build", "Springs and mounts", "Limits", "Measures")]
    assert order == sorted(order)
    assert not any("needed" in line for line in said)


def test_what_amplifies_is_not_called_isolation() -> None:
    soft = from_dict(fan(100.0, 1e7, 0.05, 1), name="fan.toml")
    text = solve(soft, explain=False).report()
    ratio = (2.0 * pi * 1450.0 / 60.0) ** 2 * 100.0 / 1e7
    through = sqrt((1.0 + 0.01 * ratio) / ((1.0 - ratio) ** 2 + 0.01 * ratio))
    assert f"none: {through:.4g} times at 1450 rpm" in text


def test_without_a_design_there_are_no_facts() -> None:
    document = fan(120.0, 95e3, 0.05, 4)
    document["links"]["spring"]["stiffness"] = {"from": "1 kN/m", "to": "1 MN/m"}
    document["limits"] = {
        "floor": {"response": "transmitted_force", "into": "ground", "at_most": "1 N"},
        "sag": {"response": "static_deflection", "of": "spring", "at_most": "1 mm"},
    }
    document["goal"] = {"maximise": "stiffness", "of": "spring"}
    design = solve(from_dict(document, name="fan.toml"), explain=False)
    assert design.status == "infeasible"
    assert machine_in(design) is None
    assert "Springs and mounts" not in design.report()


CORNERS = [[f"{x} m", f"{y} m", "0 m"] for x in (-0.6, 0.6) for y in (-0.4, 0.4)]
SHAKERS: dict[str, tuple[dict[str, Any], tuple[float, float, float]]] = {
    "force": ({"kind": "force", "on": "set", "amplitude": "70 N", "direction": "z"}, (0.0, 0.0, 1.0)),
    "slanted force": (
        {"kind": "force", "on": "set", "amplitude": "70 N", "direction": [0, 0.6, 0.8]}, (0.0, 0.6, 0.8),
    ),
    "unbalance": ({"kind": "unbalance", "on": "set", "axis": "x", "unbalance": "0.02 kg m"}, (0.0, 1.0, 1.0)),
    "shaken floor": (
        {"kind": "base_motion", "on": "floor", "displacement": "0.1 mm", "direction": "x"}, (1.0, 0.0, 0.0),
    ),
}  # fmt: skip


@pytest.mark.parametrize("shaker", SHAKERS)
@given(st.floats(50.0, 5e3), st.floats(1e4, 1e7), st.floats(0.02, 0.3))
@settings(max_examples=6, deadline=None)
def test_isolation_in_space_is_that_of_one_mass_along_each_way(
    shaker: str, mass: float, stiffness: float, loss: float
) -> None:
    """With the centre of mass among its mounts no way stirs another: one mass, four springs, one formula each."""
    table, (x, y, z) = SHAKERS[shaker]
    floor = "floor" if table["on"] == "floor" else "ground"
    scene = from_dict(
        {
            "bodies": {"set": {"mass": f"{mass!r} kg", "inertia": ["90 kg m2", "90 kg m2", "90 kg m2"]}},
            **({"bases": {"floor": {}}} if floor == "floor" else {}),
            "mounts": {
                "foot": {
                    "between": ["set", floor], "at": CORNERS, "shear_ratio": 0.5,
                    "stiffness": f"{stiffness!r} N/m", "loss_factor": loss,
                }
            },
            "excitations": {"it": {**table, "speed": "1450 rpm"}},
            "measures": {"first": {"response": "natural_frequency"}},
        }
    )  # fmt: skip
    (one,) = isolators_of(scene, machine_of(scene, {}))
    springs = {"x": 0.5 * stiffness, "y": 0.5 * stiffness, "z": stiffness}
    inertia = mass * (1450.0 * pi / 30.0) ** 2
    ratio = {axis: 4 * k * (1 + 1j * loss) / (4 * k * (1 + 1j * loss) - inertia) for axis, k in springs.items()}
    found = {key: row.value.value for key, row in one.isolation.items()}
    if shaker == "slanted force":
        assert found == pytest.approx({"along its direction": 1.0 - abs(0.36 * ratio["y"] + 0.64 * ratio["z"])})
        return
    ways = [axis for axis, part in zip("xyz", (x, y, z), strict=True) if part]
    assert found == pytest.approx({f"along {axis}": 1.0 - abs(ratio[axis]) for axis in ways})


def test_a_bearing_of_a_rotor_is_no_isolator() -> None:
    scene = read(PROBLEMS / "shafts/three_disc_turbine.toml")
    assert isolators_of(scene, machine_of(scene, {})) == []


def test_a_sag_says_whose_it_is_and_when() -> None:
    """A file that asks a sag knows that its line is upright; under mounts in space the worst of them is meant."""
    heads = []
    asks = {"measures": {"sag": {"response": "static_deflection", "of": "spring"}}}
    documents = [fan(100.0, 1e5, 0.05, 1), fan(100.0, 1e5, 0.05, 1, **asks)]
    for scene in [*(from_dict(one) for one in documents), read(PROBLEMS / "mounts/pump_flange.toml")]:
        design = solve(scene, explain=False)
        machine = machine_in(design)
        assert machine is not None
        heads.append(isolator_block(design, machine).heads[-2])
    assert heads == ["Static sag\nif vertical", "Static sag", "Static sag,\nworst mount"]


SIZES = st.tuples(*[st.floats(1.0, 2e3)] * 3, *[st.floats(1e3, 1e7)] * 2)


@settings(max_examples=30)
@given(SIZES)
def test_what_a_damper_alone_holds_has_the_frequency_zero_and_strains_nothing(sizes: tuple[float, ...]) -> None:
    """Rounding of 1e-16 Hz was told, and springs were said to be strained in that mode."""
    *masses, low, up = sizes
    document = fan(1.0, 1.0, 0.1, 1)
    document["bodies"] = {
        name: {"mass": f"{mass!r} kg"} for name, mass in zip(("fan", "top", "rider"), masses, strict=True)
    }
    document["links"] = {
        "low": {"between": ["fan", "ground"], "stiffness": f"{low!r} N/m"},
        "up": {"between": ["top", "fan"], "stiffness": f"{up!r} N/m"},
        "side": {"between": ["top", "ground"], "stiffness": "70 kN/m"},
        "dash": {"between": ["rider", "fan"], "damping": "20 N s/m"},
    }
    document["inerters"] = {"wheel": {"between": ["rider", "fan"], "inertance": "40 kg"}}
    scene = from_dict(document)
    machine = machine_of(scene, {})
    found = machine.natural_frequencies()
    assert found[0] == 0.0
    assert found[1] > 0.0
    assert all(one.mode is not None and one.mode[0] > 1 for one in isolators_of(scene, machine))
