"""Machines in space: against matrices in numpy, against one line, and under other axes."""

from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import vibopt as vo
from space_machine import GRAVITY, Plant, plants, rotation
from vibopt.mechanics.rigid import SpaceMachine
from vibopt.program.pose import on_needed, pose
from vibopt.scene.assemble import model_of
from vibopt.scene.read import from_dict
from vibopt.scene.scene import Scene
from vibopt.verify.as_built import machine_of

FEW = settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.too_slow])
NONE = np.zeros(0)


def asked(plant: Plant, measures: dict[str, dict[str, Any]]) -> Scene:
    """A scene with questions."""
    return from_dict({**plant.document(), "measures": measures})


def both(scene: Scene, name: str) -> tuple[float, float]:
    """A measure by its form and on the machine as built, worst of a group as well."""
    from vibopt.scene.space import members

    response = scene.measures[name]
    full = model_of(scene)
    found = [
        form.value(model, NONE) for model, form in (on_needed(scene, full, one) for one in members(scene, response))
    ]
    return max(found), vo.solve(scene).measures[name].value.value


@FEW
@given(plants)
def test_frequencies_and_responses_are_those_of_the_matrices(plant: Plant) -> None:
    speeds = np.linspace(5.0, 400.0, 9)
    questions: dict[str, dict[str, Any]] = {
        f"at{i}": {"response": "displacement", "of": "eye", "direction": plant.way.tolist(), "at": f"{one!r} rad/s"}
        for i, one in enumerate(speeds.tolist())
    }
    questions |= {f"mode{i}": {"response": "natural_frequency", "mode": i} for i in range(1, 7)}
    scene = asked(plant, questions)
    for i, value in enumerate(plant.response(speeds)):
        assert both(scene, f"at{i}") == pytest.approx((value, value), rel=1e-9)
    for i, value in enumerate(plant.frequencies()):
        assert both(scene, f"mode{i + 1}") == pytest.approx((value, value), rel=1e-9)


@FEW
@given(plants)
def test_the_worst_over_a_range_is_no_less_than_any_sample(plant: Plant) -> None:
    words = {"response": "displacement", "of": "eye", "direction": plant.way.tolist(), "over": "1..400 rad/s"}
    scene = asked(plant, {"worst": words})
    speeds = np.linspace(1.0, 400.0, 40_001)
    highest = speeds[plant.response(speeds).argmax()]
    near = np.clip(np.linspace(highest - 0.01, highest + 0.01, 2_001), 1.0, 400.0)
    samples = plant.response(near).max()
    for value in both(scene, "worst"):
        assert samples <= value * (1 + 1e-12)
        assert value == pytest.approx(samples, rel=1e-5)


@FEW
@given(plants)
def test_static_loads_are_those_of_the_matrices_and_carry_the_weight(plant: Plant) -> None:
    questions: dict[str, dict[str, Any]] = {}
    for i in range(len(plant.at)):
        questions[f"own{i}"] = {"response": "static_load", "of": f"m{i}"}
        questions[f"up{i}"] = {"response": "static_load", "of": f"m{i}", "direction": "z"}
    scene, loads = asked(plant, questions), plant.loads()
    total = 0.0
    size = plant.mass * GRAVITY
    for i, load in enumerate(loads):
        own = plant.axes[i][2]
        assert both(scene, f"own{i}") == pytest.approx((load @ own,) * 2, abs=1e-9 * size)
        up = both(scene, f"up{i}")
        assert up == pytest.approx((load[2],) * 2, abs=1e-9 * size)
        total += up[1]
    assert total == pytest.approx(size, rel=1e-9)


@FEW
@given(plants, st.tuples(*[st.floats(-3.0, 3.0)] * 6))
def test_other_axes_change_nothing(plant: Plant, by: tuple[float, ...]) -> None:
    other = plant.turned(rotation(np.array(by[:3])), np.array(by[3:]))
    found = []
    for one in (plant, other):
        words = {"response": "displacement", "of": "eye", "direction": one.way.tolist(), "over": "10..300 rad/s"}
        force = {
            "response": "transmitted_force",
            "into": "ground",
            "direction": one.way.tolist(),
            "over": "10..300 rad/s",
        }
        scene = asked(
            one, {"moved": words, "force": force, "travel": {"response": "travel", "of": "m1", "over": "10..300 rad/s"}}
        )
        found.append([value for name in scene.measures for value in both(scene, name)])
    assert found[0] == pytest.approx(found[1], rel=1e-8)


@FEW
@given(plants, st.floats(20.0, 300.0))
def test_force_and_motion_may_change_places(plant: Plant, omega: float) -> None:
    other = Plant(0, len(plant.at))
    other.__dict__.update(plant.__dict__)
    other.point, other.force_at, other.way, other.push = plant.force_at, plant.point, plant.push, plant.way
    values = []
    for one in (plant, other):
        words = {"response": "displacement", "of": "eye", "direction": one.way.tolist(), "at": f"{omega!r} rad/s"}
        values += both(asked(one, {"moved": words}), "moved")
    assert values == pytest.approx([values[0]] * 4, rel=1e-9)


@FEW
@given(plants, st.floats(20.0, 300.0))
def test_what_the_force_puts_in_the_dampers_take_out(plant: Plant, omega: float) -> None:
    scene = asked(plant, {"mode": {"response": "natural_frequency"}})
    machine = machine_of(scene, {})
    assert isinstance(machine, SpaceMachine)
    at = np.array([omega])
    excitation = scene.excitations["shaker"]
    motion = machine.shake(at, {key: np.array([one]) for key, one in excitation.acts.items()}, {})
    moved = machine.moved(excitation.place, tuple(plant.push.tolist()), motion.points)[0]
    power = 0.5 * omega * -moved.imag
    lost = sum(
        0.5 * omega**2 * float(mount.damping @ np.abs(machine.stretch(mount, motion.points)[0]) ** 2)
        for mount in machine.mounts
    )
    assert power == pytest.approx(lost, rel=1e-9)


@FEW
@given(plants, st.floats(20.0, 300.0))
def test_momentum_of_the_machine_is_what_the_mounts_hand_on(plant: Plant, omega: float) -> None:
    scene = asked(plant, {"mode": {"response": "natural_frequency"}})
    machine = machine_of(scene, {})
    assert isinstance(machine, SpaceMachine)
    motion = machine.shake(
        np.array([omega]), {k: np.array([v]) for k, v in scene.excitations["shaker"].acts.items()}, {}
    )
    for way in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)):
        by_momentum = machine.force_along("ground", way, motion)[0]
        by_mounts = sum(machine.mount_force(mount, motion)[0] @ np.array(way) for mount in machine.mounts)
        assert by_momentum == pytest.approx(by_mounts, rel=1e-9, abs=1e-9)


def box(offset: float = 0.0, height: float = 0.0, ask: str = "z", choice: bool = False) -> dict[str, Any]:
    """A box on four mounts at its corners, its centre moved."""
    spread: Any = {"from": "0.1 MN/m", "to": "3 MN/m"} if choice else "1 MN/m"
    corners = [[f"{x} m", f"{y} m", "0 m"] for x in (0.85, -0.85) for y in (0.4, -0.4)]
    return {
        "title": "box",
        "bodies": {
            "box": {
                "mass": "1850 kg",
                "centre": [f"{offset} m", "0 m", f"{height} m"],
                "inertia": ["310 kg m2", "620 kg m2", "590 kg m2"],
            }
        },
        "mounts": {
            "foot": {
                "between": ["box", "ground"],
                "at": corners,
                "stiffness": spread,
                "shear_ratio": 0.55,
                "damping": "3 kN s/m",
            }
        },
        "excitations": {
            "shaker": {
                "kind": "force",
                "on": "box",
                "direction": ask,
                "amplitude": "2 kN",
                "speed": "1500 rpm",
                "varies": "speed^2",
            }
        },
    }


LINE: dict[str, Any] = {
    "title": "line",
    "bodies": {"box": {"mass": "1850 kg"}},
    "links": {"foot": {"between": ["box", "ground"], "count": 4, "damping": "3 kN s/m"}},
    "excitations": {
        "shaker": {"kind": "force", "on": "box", "amplitude": "2 kN", "speed": "1500 rpm", "varies": "speed^2"}
    },
}
OVER = {"over": "0..1500 rpm"}


@pytest.mark.parametrize("height", [0.0, 0.45])
def test_symmetric_mounts_are_as_one_line(height: float) -> None:
    space_words = {"into": "ground", "direction": "z", **OVER}
    scene = from_dict(
        {
            **box(height=height),
            "measures": {
                "force": {"response": "transmitted_force", **space_words},
                "moved": {"response": "displacement", "of": "box", "direction": "z", **OVER},
                "fast": {"response": "acceleration", "of": "box", "direction": "z", **OVER},
                "single": {"response": "transmitted_force", "through": "foot", "direction": "z", **OVER},
                "sag": {"response": "static_deflection", "of": "box"},
                "rattle": {"response": "travel", "of": "foot", "direction": "z", **OVER},
            },
        }
    )
    line = from_dict(
        {
            **LINE,
            "links": {"foot": {**LINE["links"]["foot"], "stiffness": "1 MN/m"}},
            "measures": {
                "force": {"response": "transmitted_force", "into": "ground", **OVER},
                "moved": {"response": "displacement", "of": "box", **OVER},
                "fast": {"response": "acceleration", "of": "box", **OVER},
                "single": {"response": "transmitted_force", "through": "foot", **OVER},
                "sag": {"response": "static_deflection", "of": "box"},
                "rattle": {"response": "relative_displacement", "across": "foot", **OVER},
            },
        }
    )
    ours, theirs = vo.solve(scene), vo.solve(line)
    for name in scene.measures:
        expected = theirs.measures[name].value.value
        assert ours.measures[name].value.value == pytest.approx(expected, rel=1e-12)
        assert both(scene, name)[0] == pytest.approx(expected, rel=1e-12)


def test_a_symmetric_design_is_that_of_one_line() -> None:
    limit = {"response": "transmitted_force", "into": "ground", "over": "700..1500 rpm", "at_most": "1.5 kN"}
    goal = {"maximise": "stiffness", "of": "foot"}
    space = from_dict({**box(choice=True), "limits": {"floor": {**limit, "direction": "z"}}, "goal": goal})
    foot = {**LINE["links"]["foot"], "stiffness": {"from": "0.1 MN/m", "to": "3 MN/m"}}
    line = from_dict({**LINE, "links": {"foot": foot}, "limits": {"floor": limit}, "goal": goal})
    ours, theirs = vo.solve(space), vo.solve(line)
    assert (ours.status, theirs.status) == ("optimal", "optimal")
    assert ours.x == pytest.approx(theirs.x, rel=1e-12)


@pytest.mark.parametrize(
    ("offset", "height", "ask", "used"),
    [
        (0.0, 0.0, "z", 1),
        (0.0, 0.45, "z", 1),
        (0.1, 0.0, "z", 2),
        (0.1, 0.45, "z", 3),
        (0.0, 0.45, "x", 2),
        (0.0, 0.0, "y", 1),
    ],
)
@pytest.mark.parametrize("choice", [False, True])
def test_no_more_coordinates_than_needed(offset: float, height: float, ask: str, used: int, choice: bool) -> None:
    limit = {"response": "transmitted_force", "into": "ground", "direction": ask, **OVER, "at_most": "90 kN"}
    goal = {"goal": {"maximise": "stiffness", "of": "foot"}} if choice else {}
    scene = from_dict({**box(offset, height, ask, choice), "limits": {"floor": limit}, **goal})
    assert pose(scene).used_dof == used
    model = vo.solve(scene).model
    assert (model.declared_dof, model.used_dof) == (6, used)
    assert model.why == f"{6 - used} modes are not excited or not observed"


def test_a_design_with_an_offset_is_the_best_of_a_scan() -> None:
    limit = {
        "response": "transmitted_force",
        "into": "ground",
        "direction": "z",
        "over": "700..1500 rpm",
        "at_most": "1.5 kN",
    }
    goal = {"maximise": "stiffness", "of": "foot"}
    scene = from_dict({**box(0.1, 0.45, choice=True), "limits": {"floor": limit}, "goal": goal})
    design = vo.solve(scene)
    part = pose(scene).limits[0]
    good = [k for k in np.linspace(0.1e6, 3e6, 400) if part.form.worst(part.model, np.array([k])).value <= 1500.0]
    assert design.status == "optimal"
    assert max(good) <= design.x[0] <= max(good) + 2.9e6 / 399


def test_six_frequencies_of_a_box_on_its_corners() -> None:
    """Bounce and yaw stand alone; surge with pitch and sway with roll are two quadratics (Harris, chapter 3)."""
    h, a, b, k, m = 0.45, 0.85, 0.4, 1e6, 1850.0
    s = 0.55 * k
    expected = [np.sqrt(4 * k / m), np.sqrt(4 * s * (a**2 + b**2) / 590.0)]
    for arm, inertia in ((a, 620.0), (b, 310.0)):
        own, turn, mixed = 4 * s / m, 4 * (k * arm**2 + s * h**2) / inertia, 4 * s * h
        middle, half = 0.5 * (own + turn), 0.5 * (own - turn)
        root = np.sqrt(half**2 + mixed**2 / (m * inertia))
        expected += [np.sqrt(middle - root), np.sqrt(middle + root)]
    words = {f"n{i}": {"response": "natural_frequency", "mode": i} for i in range(1, 7)}
    scene = from_dict({**box(height=h), "measures": words})
    for i, value in enumerate(sorted(expected)):
        assert both(scene, f"n{i + 1}") == pytest.approx((value, value), rel=1e-12)


def test_shares_of_energy_and_gaps_by_both_roads() -> None:
    words: dict[str, dict[str, Any]] = {
        f"d{axis}": {"response": "energy_share", "of": "box", "direction": axis} for axis in "xyz"
    }
    words |= {f"r{axis}": {"response": "energy_share", "of": "box", "axis": axis} for axis in "xyz"}
    words["gap"] = {"response": "frequency_separation"}
    words["tilt"] = {"response": "tilt", "of": "box", "axis": "y"}
    scene = from_dict({**box(0.05, 0.45), "measures": words})
    for name in words:
        form, built = both(scene, name)
        assert form == pytest.approx(built, rel=1e-9)
    centred = from_dict({**box(0.0, 0.45), "measures": words})
    assert both(centred, "dz") == pytest.approx((1.0, 1.0), rel=1e-12)
    assert both(centred, "rz") == pytest.approx((1.0, 1.0), rel=1e-12)


def test_an_unbalance_that_goes_round_moves_both_ways() -> None:
    """About x it pushes along y and, a quarter turn later, along z; at the centre of the mounts they do not mix."""
    turning = {"kind": "unbalance", "on": "box", "axis": "x", "unbalance": "0.1 kg m", "speed": "1500 rpm"}
    words = {axis: {"response": "transmitted_force", "into": "ground", "direction": axis} for axis in "yz"}
    diagonal = {"response": "transmitted_force", "into": "ground", "direction": [0, 1, 1]}
    scene = from_dict({**box(), "excitations": {"rotor": turning}, "measures": {**words, "both": diagonal}})
    omega, m = 50 * np.pi, 1850.0
    parts = []
    for axis, k, c in (("y", 2.2e6, 6.6e3), ("z", 4e6, 12e3)):
        z = k + 1j * omega * c
        parts.append(0.1 * omega**2 * z / (z - m * omega**2))
        assert both(scene, axis) == pytest.approx((abs(parts[-1]),) * 2, rel=1e-12)
    whole = abs(parts[0] - 1j * parts[1]) / np.sqrt(2.0)
    assert both(scene, "both") == pytest.approx((whole, whole), rel=1e-12)


def test_two_bodies_and_a_floor_that_moves() -> None:
    """A box on a block on a base: where everything is symmetric, a chain of two masses."""
    document = box(height=0.45)
    document["bodies"]["block"] = {
        "mass": "4 t",
        "shape": {"box": ["2.4 m", "1.2 m", "0.5 m"]},
        "centre": ["0 m", "0 m", "-0.4 m"],
    }
    document["mounts"]["foot"]["between"] = ["box", "block"]
    corners = [[f"{x} m", f"{y} m", "-0.65 m"] for x in (1, -1) for y in (0.5, -0.5)]
    document["mounts"]["pad"] = {
        "between": ["block", "hall"],
        "at": corners,
        "stiffness": "2 MN/m",
        "shear_ratio": 0.5,
        "damping": "4 kN s/m",
    }
    document["bases"] = {"hall": {}}
    document["excitations"] = {
        "hall": {
            "kind": "base_motion",
            "on": "hall",
            "direction": "z",
            "displacement": "1 mm",
            "speed": "8 Hz",
            "varies": "constant",
        }
    }
    words = {"response": "displacement", "of": "box", "over": "1..20 Hz"}
    scene = from_dict(
        {**document, "measures": {"moved": {**words, "direction": "z"}, "side": {**words, "direction": "x"}}}
    )
    chain = from_dict(
        {
            "title": "chain",
            "bodies": {"box": {"mass": "1850 kg"}, "block": {"mass": "4 t"}},
            "bases": {"hall": {}},
            "links": {
                "foot": {"between": ["box", "block"], "stiffness": "4 MN/m", "damping": "12 kN s/m"},
                "pad": {"between": ["block", "hall"], "stiffness": "8 MN/m", "damping": "16 kN s/m"},
            },
            "excitations": {
                "hall": {
                    "kind": "base_motion",
                    "on": "hall",
                    "displacement": "1 mm",
                    "speed": "8 Hz",
                    "varies": "constant",
                }
            },
            "measures": {"moved": words},
        }
    )
    expected = vo.solve(chain).measures["moved"].value.value
    assert both(scene, "moved") == pytest.approx((expected, expected), rel=1e-10)
    assert both(scene, "side")[1] == pytest.approx(0.0, abs=1e-15)


def test_the_best_of_several_places() -> None:
    """Mounts under the centre of mass tilt the box least."""
    document = box(0.1, 0.45)
    sets = [[[f"{x + d} m", f"{y} m", "0 m"] for x in (0.85, -0.85) for y in (0.4, -0.4)] for d in (0.0, 0.1, 0.2)]
    document["mounts"]["foot"]["at"] = {"one_of": sets}
    goal = {"minimise": "tilt", "of": "box", "axis": "y"}
    limit = {"response": "static_deflection", "of": "box", "at_most": "10 mm"}
    design = vo.solve(from_dict({**document, "limits": {"sag": limit}, "goal": goal}))
    assert design.status == "optimal"
    assert design.goal is not None
    assert design.goal[1].value == pytest.approx(0.0, abs=1e-12)
    assert design.places["mounts.foot.at"].value == "set 2"


@pytest.mark.parametrize("over", ["1..60 Hz"])
def test_a_plane_is_space_without_what_lies_across(over: str) -> None:
    """Mounts that stand symmetric about the plane: sway, roll and yaw take no part."""
    words = {"response": "displacement", "of": "box", "direction": [1, 0, 1], "over": over}
    turn = {"response": "rotation", "of": "box", "axis": "y", "over": over}
    space = box(0.1, 0.45)
    plane = box(0.1, 0.45)
    plane["bodies"]["box"] |= {"motion": "plane", "inertia": "620 kg m2"}
    found = []
    for document in (space, plane):
        scene = from_dict({**document, "measures": {"moved": words, "turned": turn}})
        found.append([*both(scene, "moved"), *both(scene, "turned")])
        found[-1].append(float(model_of(scene).n_free))
    assert found[0][:4] == pytest.approx(found[1][:4], rel=1e-10)
    assert (found[0][4], found[1][4]) == (6.0, 3.0)
