"""Kinds as a newcomer would write them, from the checklists of the registries alone: a class and a line each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pytest

import vibopt as vo
from vibopt.arrays import ComplexArray, FloatArray
from vibopt.devices import FAMILIES
from vibopt.devices.device import Device, Ends
from vibopt.devices.ends import TwoEnds
from vibopt.devices.symbols import Numbers, Symbols
from vibopt.mechanics.assembly import Assembly
from vibopt.mechanics.builder import ModelBuilder
from vibopt.mechanics.built import Joint, Motion
from vibopt.mechanics.machine import Machine
from vibopt.mechanics.model import Model
from vibopt.mechanics.monomial import Monomial
from vibopt.responses import KINDS
from vibopt.responses.response import HarmonicResponse
from vibopt.responses.response_rows import link_forces
from vibopt.scene.read import from_dict
from vibopt.signals import Output
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


@pytest.fixture(autouse=True)
def registered(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(FAMILIES, "frictions", FrictionTable)
    monkeypatch.setitem(KINDS, "damper_force", LostForce)


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


def test_it_is_designed_like_any_other() -> None:
    loss = {"from": "1 kN/m", "to": "100 kN/m"}
    document = {**PUMP, "frictions": {"pad": {"between": ["pump", "ground"], "loss": loss}}}
    limits = {"x": {"response": "displacement", "of": "pump", "at_most": "10 mm"}}
    goal = {"minimise": "transmitted_force", "into": "ground", "at": "20 Hz"}
    design = solve(from_dict({**document, "limits": limits, "goal": goal}))
    assert design.status == "optimal"
    assert design.variables["frictions.pad.loss"].value.value == pytest.approx(30e3, rel=1e-6)


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
