"""Absorbers in space: against matrices in numpy, against a line, by energy and momentum, and under other axes."""

from __future__ import annotations

import copy
from datetime import date
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import vibopt as vo
from space_machine import GRAVITY, Plant, lengths, rotation, skew
from vibopt.mechanics.rigid import SpaceMachine
from vibopt.program.pose import on_needed
from vibopt.report.absorber_parts import parts_of
from vibopt.report.curves import panels
from vibopt.report.sheet import html
from vibopt.report.space_views import machine_figure
from vibopt.scene.assemble import model_of
from vibopt.scene.read import from_dict
from vibopt.scene.scene import Scene
from vibopt.scene.space import members
from vibopt.study.absorbers import consequences
from vibopt.verify.as_built import machine_of

Array = NDArray[np.float64]
FEW = settings(max_examples=12, deadline=None, suppress_health_check=[HealthCheck.too_slow])
NONE = np.zeros(0)


class Damped(Plant):
    """A body on mounts with two absorbers at places of it and a third upon the second; rows over ten coordinates."""

    def __init__(self, seed: int, mounts: int = 4) -> None:
        super().__init__(seed, mounts)
        random = np.random.default_rng(seed + 1)
        self.heavy = self.mass * random.uniform(0.02, 0.2, 3)
        self.spring = self.heavy * random.uniform(20.0, 300.0, 3) ** 2
        self.dash = 2.0 * random.uniform(0.02, 0.3, 3) * np.sqrt(self.spring * self.heavy)
        self.stand = random.uniform(-1.0, 1.0, (3, 3))
        self.slide = np.array([one / np.linalg.norm(one) for one in random.uniform(-1.0, 1.0, (3, 3))])

    def turned(self, by: Array, shift: Array) -> Damped:
        other = copy.deepcopy(self)
        other.__dict__.update(super().turned(by, shift).__dict__)
        other.stand, other.slide = self.stand @ by.T + shift, self.slide @ by.T
        return other

    def moves(self, i: int) -> Array:
        """Motion of the mass of an absorber in space over x, y, z, three turns and three strokes, (3, 9)."""
        rows = np.zeros((3, 9))
        rows[:, :3], rows[:, 3:6] = np.eye(3), -skew(self.stand[i] - self.centre)
        for one in {0: (0,), 1: (1,), 2: (1, 2)}[i]:
            rows[:, 6 + one] = self.slide[one]
        return rows

    def matrices(self) -> tuple[Array, Array, Array]:
        """M, C, K: kinetic energy of each mass by its velocity, springs and dampers on the strokes."""
        whole = [np.zeros((9, 9)) for _ in range(3)]
        for full, six in zip(whole, super().matrices(), strict=True):
            full[:6, :6] = six
        for i in range(3):
            whole[0] += self.heavy[i] * self.moves(i).T @ self.moves(i)
            whole[1][6 + i, 6 + i], whole[2][6 + i, 6 + i] = self.dash[i], self.spring[i]
        return whole[0], whole[1], whole[2]

    def reads(self, at: Array, way: Array) -> Array:
        return np.concatenate([super().reads(at, way), np.zeros(3)])

    def motion(self, omega: float) -> NDArray[np.complex128]:
        """Coordinates under the unit force, (9,)."""
        mass, damping, stiffness = self.matrices()
        found = np.linalg.solve(
            stiffness - omega**2 * mass + 1j * omega * damping, self.reads(self.force_at, self.push).astype(complex)
        )
        return np.asarray(found)

    def down(self) -> Array:
        """Coordinates under all weights, (9,)."""
        pull = np.zeros(9)
        pull[2] = -self.mass * GRAVITY
        for i in range(3):
            pull -= self.heavy[i] * GRAVITY * self.moves(i)[2]
        return np.asarray(np.linalg.solve(self.matrices()[2], pull))

    def document(self) -> dict[str, Any]:
        document = super().document()
        document["absorbers"] = {
            f"a{i}": {
                "on": ("body", "spot", "a1")[i],
                "direction": self.slide[i].tolist(),
                "stiffness": f"{float(self.spring[i])!r} N/m",
                "damping": f"{float(self.dash[i])!r} N s/m",
                "mass": f"{float(self.heavy[i])!r} kg",
                **({} if i == 1 else {"at": lengths(self.stand[i])}),
            }
            for i in range(3)
        }
        document["points"]["spot"] = {"on": "body", "at": lengths(self.stand[1])}
        return document


damped = st.builds(Damped, st.integers(0, 10_000), st.integers(4, 6))


def both(scene: Scene) -> dict[str, tuple[float, float]]:
    """Every measure by its form, and on the machine as built."""
    full, design = model_of(scene), vo.solve(scene, explain=False)
    assert design.status == "met", design.claim
    found = {}
    for name, response in scene.measures.items():
        every = [on_needed(scene, full, one) for one in members(scene, response)]
        found[name] = max(form.value(model, NONE) for model, form in every), design.measures[name].value.value
    return found


def asked(plant: Damped, measures: dict[str, dict[str, Any]]) -> dict[str, tuple[float, float]]:
    """The same of a plant with questions."""
    return both(from_dict({**plant.document(), "measures": measures}))


@FEW
@given(damped, st.floats(10.0, 300.0))
def test_what_vibrates_is_that_of_the_matrices(plant: Damped, omega: float) -> None:
    at, way = {"at": f"{omega!r} rad/s"}, plant.way.tolist()
    found = asked(
        plant,
        {
            "eye": {"response": "displacement", "of": "eye", "direction": way, **at},
            "fast": {"response": "acceleration", "of": "a2", "direction": way, **at},
            "stroke": {"response": "stroke", "of": "a1", **at},
            "apart": {"response": "relative_displacement", "across": "a2", **at},
            "pull": {"response": "transmitted_force", "through": "a0", **at},
            "floor": {"response": "transmitted_force", "into": "ground", "direction": way, **at},
            **{f"mode{i}": {"response": "natural_frequency", "mode": i} for i in range(1, 10)},
        },
    )
    moved = plant.motion(omega)
    slid = [plant.moves(i) @ moved for i in range(3)]
    momentum = plant.mass * moved[:3] + sum(m * one for m, one in zip(plant.heavy, slid, strict=True))
    expected = {
        "eye": moved @ plant.reads(plant.point, plant.way),
        "fast": omega**2 * slid[2] @ plant.way,
        "stroke": moved[7],
        "apart": moved[8],
        "pull": (plant.spring[0] + 1j * omega * plant.dash[0]) * moved[6],
        "floor": plant.push @ plant.way + omega**2 * momentum @ plant.way,
        **{f"mode{i + 1}": one for i, one in enumerate(plant.frequencies())},
    }
    for name, value in expected.items():
        assert found[name] == pytest.approx((abs(value),) * 2, rel=1e-8), name


@FEW
@given(damped)
def test_weights_are_carried_as_the_matrices_say(plant: Damped) -> None:
    down, total = plant.down(), plant.mass + plant.heavy.sum()
    found = asked(
        plant,
        {
            "sag": {"response": "static_deflection", "of": "eye", "direction": plant.way.tolist()},
            "mass": {"response": "static_deflection", "of": "a0"},
            "tilt": {"response": "tilt", "of": "body", "axis": "x"},
            "heavy": {"response": "total_mass"},
            "own": {"response": "mass", "of": "a1"},
            "absorbers": {"response": "absorber_mass"},
            **{f"m{i}": {"response": "static_load", "of": f"m{i}", "direction": "z"} for i in range(len(plant.at))},
        },
    )
    assert found["sag"] == pytest.approx((abs(down @ plant.reads(plant.point, plant.way)),) * 2, rel=1e-8)
    assert found["mass"] == pytest.approx((abs(down[6]),) * 2, rel=1e-8)
    assert found["tilt"] == pytest.approx((abs(down[3]),) * 2, rel=1e-8)
    assert found["heavy"] == pytest.approx((total,) * 2, rel=1e-12)
    assert found["own"] == pytest.approx((plant.heavy[1],) * 2, rel=1e-12)
    assert found["absorbers"] == pytest.approx((plant.heavy.sum(),) * 2, rel=1e-12)
    assert sum(found[f"m{i}"][1] for i in range(len(plant.at))) == pytest.approx(total * GRAVITY, rel=1e-8)


@FEW
@given(damped, st.tuples(*[st.floats(-3.0, 3.0)] * 6))
def test_other_axes_change_nothing(plant: Damped, by: tuple[float, ...]) -> None:
    found = []
    for one in (plant, plant.turned(rotation(np.array(by[:3])), np.array(by[3:]))):
        over, way = {"over": "10..300 rad/s"}, one.way.tolist()
        measures = {
            "moved": {"response": "displacement", "of": "eye", "direction": way, **over},
            "force": {"response": "transmitted_force", "into": "ground", "direction": way, **over},
            "stroke": {"response": "stroke", "of": "a2", **over},
            "share": {"response": "energy_share", "of": "body", "direction": way},
        }
        found.append([value for pair in asked(one, measures).values() for value in pair])
    assert found[0] == pytest.approx(found[1], rel=1e-7)


@FEW
@given(damped, st.floats(20.0, 300.0))
def test_what_the_force_puts_in_the_dampers_take_out(plant: Damped, omega: float) -> None:
    scene = from_dict({**plant.document(), "measures": {"mode": {"response": "natural_frequency"}}})
    machine = machine_of(scene, {})
    assert isinstance(machine, SpaceMachine)
    excitation = scene.excitations["shaker"]
    motion = machine.shake(np.array([omega]), {k: np.array([v]) for k, v in excitation.acts.items()}, {})
    moved = machine.moved(excitation.place, tuple(plant.push.tolist()), motion.points)[0]
    lost = sum(
        0.5 * omega**2 * float(mount.damping @ np.abs(machine.stretch(mount, motion.points)[0]) ** 2)
        for mount in machine.mounts
    )
    assert 0.5 * omega * -moved.imag == pytest.approx(lost, rel=1e-9)


@FEW
@given(damped)
def test_shares_of_energy_are_those_of_the_body_alone(plant: Damped) -> None:
    ways: dict[str, dict[str, Any]] = {"z": {"direction": "z"}, "rx": {"axis": "x"}}
    found = asked(plant, {name: {"response": "energy_share", "of": "body", **way} for name, way in ways.items()})
    mass, _, stiffness = plant.matrices()
    _, shapes = np.linalg.eig(np.linalg.solve(mass, stiffness))
    own = np.zeros((9, 9))
    own[:6, :6] = Plant.matrices(plant)[0]
    energy = np.einsum("im,ij,jm->m", shapes, mass, shapes)
    for name, row in (("z", 2), ("rx", 3)):
        assert found[name] == pytest.approx(((shapes[row] * (own @ shapes)[row] / energy).max(),) * 2, rel=1e-6)


# Against a machine on a line


def stood(direction: Any = "z", **more: Any) -> dict[str, Any]:
    """A box on four mounts at its corners with an absorber over its centre."""
    corners = [[f"{x} m", f"{y} m", "0 m"] for x in (0.85, -0.85) for y in (0.4, -0.4)]
    inertia = ["310 kg m2", "620 kg m2", "590 kg m2"]
    foot = {"between": ["box", "ground"], "at": corners, "stiffness": "1 MN/m", "shear_ratio": 0.55}
    force = {
        "kind": "force",
        "on": "box",
        "direction": "z",
        "amplitude": "2 kN",
        "speed": "10..1500 rpm",
        "amplitude_at": "1500 rpm",
    }
    return {
        "title": "box",
        "bodies": {"box": {"mass": "1850 kg", "inertia": inertia}},
        "mounts": {"foot": {**foot, "damping": "3 kN s/m"}},
        "absorbers": {"tmd": {"on": "box", "direction": direction, "at": ["0 m", "0 m", "0.9 m"], **more}},
        "excitations": {"shaker": {**force, "varies": "speed^2"}},
    }


def on_a_line(document: dict[str, Any]) -> dict[str, Any]:
    """The same machine, if it moves up and down only."""
    line = copy.deepcopy(document)
    line["bodies"]["box"].pop("inertia")
    foot = line.pop("mounts")["foot"]
    line["links"] = {"foot": {key: one for key, one in foot.items() if key not in ("at", "shear_ratio")} | {"count": 4}}
    for key in ("at", "direction"):
        line["absorbers"]["tmd"].pop(key)
    line["excitations"]["shaker"].pop("direction")
    for table in [*line.get("measures", {}).values(), line.get("goal", {})]:
        table.pop("direction", None)
    return line


@pytest.mark.parametrize("direction", ["z", [0, 0, -1]])
def test_what_only_moves_up_and_down_is_as_on_a_line(direction: Any) -> None:
    document = stood(direction, mass_ratio=0.05, frequency="6 Hz", damping_ratio=0.1)
    way = {"direction": "z"}
    document["measures"] = {
        "force": {"response": "transmitted_force", "into": "ground", **way},
        "moved": {"response": "displacement", "of": "box", **way},
        "mass": {"response": "velocity", "of": "tmd", **way},
        "stroke": {"response": "stroke", "of": "tmd"},
        "sag": {"response": "static_deflection", "of": "box"},
        "own": {"response": "own_frequency", "of": "tmd"},
        "ratio": {"response": "mass_ratio", "of": "tmd"},
        "damping": {"response": "damping_ratio", "of": "tmd"},
    }
    ours, theirs = both(from_dict(document)), both(from_dict(on_a_line(document)))
    for name, (form, value) in theirs.items():
        assert ours[name] == pytest.approx((form, value), rel=1e-10), name


def test_the_best_absorber_is_that_on_a_line() -> None:
    chosen = {"frequency": {"from": "2 Hz", "to": "20 Hz"}, "damping_ratio": {"from": 0.01, "to": 0.5}}
    document = stood(mass="90 kg", **chosen)
    document["goal"] = {"minimise": "displacement", "of": "box", "direction": "z"}
    ours, theirs = (vo.solve(from_dict(one)) for one in (document, on_a_line(document)))
    assert (ours.status, theirs.status) == ("optimal", "optimal")
    assert ours.x == pytest.approx(theirs.x, rel=1e-8)


def lumped() -> tuple[dict[str, Any], dict[str, Any]]:
    """A box in which an absorber slides along y in the plane of symmetry, and the box with its mass in its place."""
    document, at = stood("y", mass="150 kg", frequency="5 Hz", damping_ratio=0.1), ["0.4 m", "0 m", "0.9 m"]
    solid = {"mass": "1850 kg", "shape": {"box": ["2 m", "0.9 m", "0.8 m"]}, "centre": ["0 m", "0 m", "0 m"]}
    document["bodies"]["box"] = {"made_of": [solid]}
    document["points"] = {"mark": {"on": "box", "at": ["0 m", "0 m", "0 m"]}}
    document["absorbers"]["tmd"]["at"], document["excitations"]["shaker"]["on"] = at, "mark"
    lump = {key: copy.deepcopy(table) for key, table in document.items() if key != "absorbers"}
    small = {"mass": "150 kg", "centre": at, "shape": {"box": ["1e-9 m", "1e-9 m", "1e-9 m"]}}
    lump["bodies"]["box"]["made_of"].append(small)
    return document, lump


def test_across_its_direction_it_is_a_part_of_the_body() -> None:
    """Shaken along z it does not slide."""
    measures = {
        "moved": {"response": "displacement", "of": "mark", "direction": "z"},
        "rocks": {"response": "rotation", "of": "box", "axis": "y"},
        "load": {"response": "static_load", "of": "foot"},
    }
    ours, theirs = (both(from_dict({**one, "measures": measures})) for one in lumped())
    for name in theirs:
        assert ours[name] == pytest.approx(theirs[name], rel=1e-9), name


def test_locked_it_is_a_part_of_the_body_and_lost_it_is_not_there() -> None:
    document, lump = lumped()
    measures = {"moved": {"response": "displacement", "of": "mark", "direction": "y", "due_to": ["side"]}}
    for one in (document, lump):
        one["excitations"]["side"] = {**one["excitations"]["shaker"], "direction": "y"}
    document["goal"] = {"minimise": "displacement", "of": "mark", "direction": "y", "due_to": ["side"]}
    document["absorbers"]["tmd"]["frequency"] = {"from": "3 Hz", "to": "9 Hz"}
    bare = {key: table for key, table in document.items() if key not in ("absorbers", "goal")}
    found = {one.what: one for one in consequences(vo.solve(from_dict(document), explain=False))}
    for what, other in (("locked", lump), ("lost", bare)):
        goal = found[what].goal
        assert goal is not None
        expected = vo.solve(from_dict({**other, "measures": measures})).measures["moved"].value.value
        assert goal.value == pytest.approx(expected, rel=1e-6), what


def test_of_several_places_the_best_is_found() -> None:
    document = stood(mass="90 kg", frequency={"from": "2 Hz", "to": "20 Hz"}, damping_ratio=0.1)
    document["points"] = {name: {"on": "box", "at": [f"{x} m", "0 m", "0 m"]} for name, x in (("a", 0.2), ("b", 0.7))}
    document["excitations"]["shaker"]["at"] = ["0.3 m", "0 m", "0 m"]
    document["goal"] = {"minimise": "displacement", "of": "b", "direction": "z"}
    del document["absorbers"]["tmd"]["at"]
    answers = {}
    for on in ("a", "b", {"one_of": ["a", "b"]}):
        document["absorbers"]["tmd"]["on"] = on
        answers[str(on)] = vo.solve(from_dict(document), explain=False)
    *known, both_open = (answer.goal[1].value for answer in answers.values() if answer.goal is not None)
    assert both_open == pytest.approx(min(known), rel=1e-9)
    assert [one.value for one in list(answers.values())[2].places.values()] == ["ab"[int(known[1] < known[0])]]


def test_the_curve_without_absorbers_is_that_of_the_worst_mount() -> None:
    document = stood(mass="90 kg", frequency="5 Hz", damping_ratio=0.1)
    document["excitations"]["shaker"]["at"] = ["0.3 m", "0.1 m", "0 m"]
    document["measures"] = {"foot": {"response": "transmitted_force", "through": "foot", "direction": "z"}}
    (panel,) = panels(vo.solve(from_dict(document)))
    bare = {key: table for key, table in document.items() if key != "absorbers"}
    alone = vo.solve(from_dict(bare)).measures["foot"].value
    assert panel.curves[1].label.startswith(f"without absorbers: worst {alone.shown} at ")


def test_pages_and_figures_hold_what_slides_and_inerters() -> None:
    document = stood([0.6, 0, 0.8], mass="90 kg", frequency="5 Hz", damping_ratio=0.1)
    stands = {"at": ["0.2 m", "0 m", "0 m"], "direction": "z"}
    document["inerters"] = {"wheel": {"between": ["box", "ground"], "inertance": "40 kg", **stands}}
    design = vo.solve(from_dict({**document, "measures": {"mode": {"response": "natural_frequency"}}}))
    figure = machine_figure(design)
    assert figure is not None
    assert "tmd" in {text.get_text().strip() for axes in figure.axes for text in axes.texts}
    (part,) = parts_of(design)
    assert part.on == "box at (0, 0, 0.9) m along (0.6, 0, 0.8)"
    page = html(design, on=date(2026, 1, 31))
    assert "foot.4" in page
    assert "tmd sliding" in page
