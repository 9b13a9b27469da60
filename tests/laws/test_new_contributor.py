"""Kinds as a newcomer would write them, from the checklists of the registries alone: a class and a line each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

import vibopt as vo
from refusals import refused
from vibopt.answer.answer_page import html
from vibopt.arrays import ComplexArray, FloatArray
from vibopt.cli.main import main
from vibopt.devices import FAMILIES
from vibopt.devices.device import Device, Ends, OneLink
from vibopt.devices.ends import TwoEnds
from vibopt.devices.symbols import Numbers, Symbols
from vibopt.forms import Form, Modulus
from vibopt.forms.form import Against, Worst
from vibopt.mechanics.assembly import Assembly
from vibopt.mechanics.builder import ModelBuilder
from vibopt.mechanics.built import Joint, Motion
from vibopt.mechanics.machine import Machine
from vibopt.mechanics.model import DAMPING, HYSTERETIC, Model
from vibopt.mechanics.monomial import Monomial
from vibopt.mechanics.peaks import greatest, least
from vibopt.report.curves import panels
from vibopt.responses import KINDS
from vibopt.responses.response import HarmonicResponse
from vibopt.responses.response_rows import across_link, link_forces
from vibopt.scene.read import from_dict
from vibopt.signals import Combine, Drive, Output
from vibopt.solve import solve
from vibopt.values import Value, number

PUMP: dict[str, Any] = {
    "title": "pump on a mount beside a friction damper",
    "bodies": {"pump": {"mass": "120 kg"}},
    "links": {"mount": {"between": ["pump", "ground"], "stiffness": "200 kN/m"}},
    "excitations": {
        "rotor": {"kind": "force", "on": "pump", "amplitude": "300 N", "speed": "5..30 Hz", "varies": "constant"}
    },
}


class FrictionTable(Device):
    """`[frictions.NAME]`: a damper c(w) = loss / w, whose force does not grow with the frequency; `loss` [N/m]."""

    between: TwoEnds
    loss: Value = number("stiffness", required=True)

    between_points: ClassVar[bool] = True
    in_space: ClassVar[str] = "Put it on a body on a line."
    passes: ClassVar[int] = 0

    @classmethod
    def links_in(cls, name: str, given: Mapping[str, Any]) -> tuple[str, ...]:
        return (name,)

    def joins(self, name: str) -> dict[str, Ends]:
        return {name: self.between}

    def add_to(self, builder: ModelBuilder, name: str, symbols: Symbols) -> None:
        builder.add_link(name, self.between, Monomial(1.0))
        builder.add_hysteretic(name, symbols.read(f"frictions.{name}.loss", self.loss))

    def built(self, assembly: Assembly, name: str, numbers: Numbers) -> None:
        assembly.add_joint(Friction(name, self.between, loss=numbers(f"frictions.{name}.loss", self.loss)))


@dataclass(frozen=True, slots=True)
class Friction(Joint):
    """Force in phase with the velocity, of a size that the frequency does not change."""

    stiffness: float = 0.0
    damping: float = 0.0
    loss_factor: float = 0.0
    static_stiffness: float = 0.0
    count: float = 1.0
    loss: float = 0.0

    def dynamic(self, omega: FloatArray) -> ComplexArray:
        return np.asarray(1j * self.loss * np.ones_like(omega), dtype=complex)

    @property
    def four(self) -> tuple[float, float, float, float]:
        return 0.0, 0.0, 0.0, self.loss


class LostForce(HarmonicResponse):
    """`response = "damper_force"`: of one damper; times pi and its stroke it is the energy lost per turn [N] peak."""

    of: str
    dimension: ClassVar[str] = "force"
    amplitude: ClassVar[bool] = True
    moves: ClassVar[str] = "line"

    def places(self) -> dict[str, tuple[str, str]]:
        return {"of": (self.of, "link")}

    def output(self, model: Model) -> Output:
        return link_forces(model, {self.of: 1.0})

    def measure(self, machine: Machine, motion: Motion) -> ComplexArray:
        return machine.joint_force(machine.joint(self.of), motion)


class StrutTable(OneLink):
    """`[struts.NAME]`: a dashpot behind a spring, c(w) = c0 / (1 + (w / w0)^2); `damping` c0 and `corner` w0 [rad/s].

    The point between both has its name, as the dashpot has; the spring is NAME.spring.
    """

    between: TwoEnds
    damping: Value = number("damping", required=True)
    corner: Value = number("angular_rate", required=True)

    between_points: ClassVar[bool] = True
    in_space: ClassVar[str] = "Put it on a body on a line."

    @property
    def massless(self) -> bool:
        return True

    @classmethod
    def links_in(cls, name: str, given: Mapping[str, Any]) -> tuple[str, ...]:
        return (name, f"{name}.spring")

    @classmethod
    def moving_in(cls, name: str, given: Mapping[str, Any]) -> tuple[str, ...]:
        return (name,)

    @classmethod
    def freedoms_in(cls, name: str, given: Mapping[str, Any]) -> int:
        return 0

    def joins(self, name: str) -> dict[str, Ends]:
        return {name: (self.between[0], name), f"{name}.spring": (name, self.between[1])}

    def springs(self, name: str) -> tuple[str, ...]:
        return (f"{name}.spring",)

    def declare(self, builder: ModelBuilder, name: str) -> None:
        builder.add_coordinate(name)
        builder.add_point(name, {name: 1.0})

    def add_to(self, builder: ModelBuilder, name: str, symbols: Symbols) -> None:
        damping = symbols.read(f"struts.{name}.damping", self.damping)
        for link, ends in self.joins(name).items():
            builder.add_link(link, ends, Monomial(1.0))
        builder.add_damping(name, damping)
        builder.add_stiffness(f"{name}.spring", damping * symbols.read(f"struts.{name}.corner", self.corner))

    def built(self, assembly: Assembly, name: str, numbers: Numbers) -> None:
        damping = numbers(f"struts.{name}.damping", self.damping)
        stiffness = damping * numbers(f"struts.{name}.corner", self.corner)
        dashpot, spring = self.joins(name).items()
        assembly.add_mass(name, 0.0, 0.0, 0.0)
        assembly.add_joint(Joint(*dashpot, 0.0, damping, 0.0, 0.0, 1.0))
        assembly.add_joint(Joint(*spring, stiffness, 0.0, 0.0, stiffness, 1.0))


@dataclass(frozen=True, slots=True)
class Lost(Form):
    """Energy that the damping of a link takes out in a cycle of one frequency, the greatest over all speeds."""

    link: str
    stroke: Modulus
    no_bounds = not_convex = rough = "is a product of two responses"

    @property
    def drives(self) -> tuple[Drive, ...]:
        return self.stroke.drives

    def value(self, model: Model, x: FloatArray) -> float:
        return self.worst(model, x).value

    def worst(self, model: Model, x: FloatArray, *, least_wanted: bool = False) -> Worst:
        (drive,) = self.drives
        found = self.against(model, x, drive.name, least_wanted=least_wanted)
        top = (least if least_wanted else greatest)(found, drive.bands, found.singular, found.breaks)
        return Worst(top.value, {drive.name: top.speed})

    def against(self, model: Model, x: FloatArray, name: str, *, least_wanted: bool) -> Against:
        stroke, values = self.stroke.against(model, x, name, least_wanted=least_wanted), model.values(x)
        own = [(term.kind, value) for term, value in zip(model.terms, values, strict=True) if term.owner == self.link]
        damped, lossy = (sum(value for kind, value in own if kind == one) for one in (DAMPING, HYSTERETIC))
        return replace(stroke, sizes=lambda speeds: np.pi * (damped * speeds + lossy) * stroke(speeds) ** 2)


class LostEnergy(LostForce):
    """`response = "lost_energy"`: of one damper in a cycle [J]."""

    dimension: ClassVar[str] = "moment"
    amplitude: ClassVar[bool] = False
    doubles: ClassVar[bool] = False

    def form(self, model: Model, drives: tuple[Drive, ...], combine: Combine) -> Form:
        return Lost(self.of, Modulus(across_link(model, self.of), drives, combine))

    def measure(self, machine: Machine, motion: Motion) -> ComplexArray:
        joint = machine.joint(self.of)
        return np.pi * joint.dynamic(motion.omega).imag * np.abs(machine.stretch_of(joint, motion)) ** 2 + 0j


@pytest.fixture(autouse=True)
def registered(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, device in (("frictions", FrictionTable), ("struts", StrutTable)):
        monkeypatch.setitem(FAMILIES, name, device)
    for name, response in (("damper_force", LostForce), ("lost_energy", LostEnergy)):
        monkeypatch.setitem(KINDS, name, response)


def test_a_damper_that_depends_on_frequency_is_a_class_and_a_line() -> None:
    """|k + i h - w^2 m| at the resonance is h; found by both routes, in a file and in Python."""
    document = {**PUMP, "frictions": {"pad": {"between": ["pump", "ground"], "loss": "20 kN/m"}}}
    measures = {"x": {"response": "displacement", "of": "pump"}, "f": {"response": "damper_force", "of": "pad"}}
    design = solve(from_dict({**document, "measures": measures}))
    assert design.status == "met", design.claim
    assert design.measures["x"].value.value == pytest.approx(300.0 / 20e3, rel=1e-12)
    assert design.measures["f"].value.value == pytest.approx(300.0, rel=1e-12)
    machine: Any = vo.Machine("Pump")
    machine.body("pump", mass="120 kg")
    machine.link("mount", between=("pump", "ground"), stiffness="200 kN/m")
    machine.device("frictions", "pad", between=("pump", "ground"), loss="20 kN/m")
    machine.force("rotor", on="pump", amplitude="300 N", speed="5..30 Hz", varies="constant")
    said = vo.solve(machine.scene(limits={"f": machine.damper_force(of="pad") <= "310 N"}))
    assert said.status == "met"


def with_strut(damping: Any) -> dict[str, Any]:
    return {**PUMP, "struts": {"strut": {"between": ["pump", "ground"], "damping": damping, "corner": "12 Hz"}}}


def lost(damping: float, speed: FloatArray) -> FloatArray:
    """In a cycle of the pump on its mount beside a dashpot behind a spring [J], at speeds [rad/s]."""
    strut = 1j * speed * damping / (1.0 + 1j * speed / (24.0 * np.pi))
    return np.asarray(np.pi * strut.imag * np.abs(300.0 / (200e3 - 120.0 * speed**2 + strut)) ** 2)


def test_a_device_may_bring_a_point_and_several_links() -> None:
    """Force and energy of a dashpot behind a spring, by its dynamic stiffness i w c / (1 + i w / w0)."""
    measures = {"e": {"response": "lost_energy", "of": "strut"}, "x": {"response": "displacement", "of": "pump"}}
    design = solve(from_dict({**with_strut("2 kN s/m"), "measures": measures}))
    assert design.status == "met", design.claim
    speeds = 2.0 * np.pi * np.linspace(5.0, 30.0, 200001)
    assert design.measures["e"].value.value == pytest.approx(lost(2e3, speeds).max(), rel=1e-8)


@pytest.mark.parametrize("damped", [{"damping": "900 N s/m"}, {"loss_factor": 0.2}])
def test_energy_is_that_of_the_damping_whatever_spring_is_beside_it(damped: dict[str, Any]) -> None:
    """pi (w c + k eta) |X|^2 of a mount; the force of its spring does no work in a cycle."""
    mount = {"mount": {"between": ["pump", "ground"], "stiffness": "200 kN/m", **damped}}
    asked = {"e": {"response": "lost_energy", "of": "mount"}}
    design = solve(from_dict({**PUMP, "links": mount, "measures": asked}))
    assert design.status == "met", design.claim
    speeds = 2.0 * np.pi * np.linspace(5.0, 30.0, 1_000_001)
    resists = speeds * 900.0 if "damping" in damped else 40e3 + 0.0 * speeds
    energy = np.pi * resists * np.abs(300.0 / (200e3 - 120.0 * speeds**2 + 1j * resists)) ** 2
    assert design.measures["e"].value.value == pytest.approx(energy.max(), rel=1e-8)


def test_a_point_without_mass_of_a_device_is_refused_what_a_joint_is() -> None:
    modes = [{"frequency": "4 Hz", "damping_ratio": 0.02, "modal_mass": "3 t", "shape": {"mid": 1.0}}]
    measures = {"x": {"response": "displacement", "of": "pump"}, "f": {"response": "free_displacement", "of": "pump"}}
    measures["f"] |= {"released": {"pump": {"velocity": "0.3 m/s"}}, "after": "0.1 s"}
    spin = {"kind": "unbalance", "on": "strut", "unbalance": "3 g m", "speed": "20 Hz"}
    sole = {**with_strut("2 kN s/m"), "measures": measures, "excitations": {"spin": spin}}
    for document, words in (
        (
            {**sole, "structures": {"slab": {"modes": modes}}},
            "struts.strut has no mass, beside slab. A joint without mass",
        ),
        (sole, "excitations.spin is an unbalance on strut, which has no mass."),
        (
            {**sole, "excitations": {}, "measures": {"f": measures["f"]}},
            "and struts.strut has no mass that would keep one.",
        ),
    ):
        assert words in str(refused(from_dict, document))
    opened = with_strut({"from": "1 kN s/m", "to": "20 kN s/m"})
    scene = from_dict({**opened, "goal": {"minimise": "displacement", "of": "pump"}})
    assert solve(scene).status == "optimal"
    assert "struts.strut has no mass, and programs take" in str(refused(vo.posed(scene).cvxpy))


@pytest.mark.parametrize("asked", ["limits", "goal"])
def test_a_response_that_is_no_modulus_is_solved_drawn_and_reported(asked: str) -> None:
    """The curve of an energy goes through the worst that is told of it."""
    question = {"response": "lost_energy", "of": "strut"}
    limit = {"limits": {"heat": {**question, "at_most": "5 N m"}}, "goal": {"minimise": "displacement", "of": "pump"}}
    aim = {"limits": {"x": {"response": "displacement", "of": "pump", "at_most": "8 mm"}},
           "goal": {"minimise": "lost_energy", "of": "strut"}}  # fmt: skip
    document = {**with_strut({"from": "1 kN s/m", "to": "20 kN s/m"}), **(limit if asked == "limits" else aim)}
    design = solve(from_dict(document))
    assert design.status in ("optimal", "feasible"), design.claim
    panel = next(one for one in panels(design) if one.title.startswith("Lost energy"))
    (mark,), (curve,) = panel.marks, panel.curves
    right = lost(design.x[0], 2.0 * np.pi * curve.x)
    assert np.allclose(curve.y, right, rtol=1e-9)
    assert mark.y == pytest.approx(np.interp(mark.x, curve.x, right), rel=1e-4)
    assert "Lost energy" in html(design)


def test_it_is_designed_like_any_other() -> None:
    loss = {"from": "1 kN/m", "to": "100 kN/m"}
    document = {**PUMP, "frictions": {"pad": {"between": ["pump", "ground"], "loss": loss}}}
    limits = {"x": {"response": "displacement", "of": "pump", "at_most": "10 mm"}}
    goal = {"minimise": "transmitted_force", "into": "ground", "at": "20 Hz"}
    design = solve(from_dict({**document, "limits": limits, "goal": goal}))
    assert design.status == "optimal"
    assert design.variables["frictions.pad.loss"].value.value == pytest.approx(30e3, rel=1e-6)


def test_a_file_with_it_is_said_to_have_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lines = [
        "[bodies.pump]",
        'mass = "120 kg"',
        "[frictions.pad]",
        'between = ["pump", "ground"]',
        'loss = "2 kN/m"',
        "[measures.m]",
        'response = "total_mass"',
    ]
    (tmp_path / "pump.toml").write_text("\n".join(lines), encoding="utf-8")
    assert main(["check", str(tmp_path / "pump.toml")]) == 0
    assert "no mistakes. 1 body, 1 measure, 1 friction; an analysis" in capsys.readouterr().out


def test_its_mistakes_are_said_as_those_of_any_other() -> None:
    document = {**PUMP, "frictions": {"pad": {"between": ["pump", "grund"], "los": "20 kN/m"}}}
    document["measures"] = {"x": {"response": "displacement", "of": "pump"}}
    with pytest.raises(vo.InputError) as caught:
        from_dict(document)
    assert any('unknown key "los" in frictions.pad. Did you mean "loss"?' in one for one in caught.value.messages)


def test_a_response_that_is_not_there_is_said_in_python() -> None:
    machine: Any = vo.Machine("Pump")
    with pytest.raises(AttributeError, match=r'there is no displacment\. Did you mean "displacement"\?'):
        machine.displacment(of="pump")
    with pytest.raises(vo.InputError, match=r'"springs" is no family of devices\.'):
        machine.device("springs", "pad")
