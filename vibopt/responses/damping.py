"""Damping ratios of modes and of links, loss factors of links."""

from typing import ClassVar

import numpy as np
from pydantic import model_validator

from vibopt.arrays import ComplexArray
from vibopt.forms import Form, LogDecrement, ModeDamping, Monomials
from vibopt.mechanics.machine import Machine
from vibopt.mechanics.model import HYSTERETIC, STIFFNESS, Model
from vibopt.responses.parameters import OfLink
from vibopt.responses.whirl_damping import OfWhirls
from vibopt.signals import Combine, Drive
from vibopt.values import word


class DampingOfModes(OfWhirls):
    """`response = "damping_ratio"`: of the `mode`-th least damped mode or whirl (1 is the least), or `of` a link.

    Keys
    ----
    of: The damping ratio of this link instead of that of a mode: `of = "mount"`.
    """

    of: str | None = None
    names: ClassVar[dict[str, str]] = {"of": "link"}
    dimension: ClassVar[str] = "ratio"
    of_link: ClassVar[bool] = True
    ratio: ClassVar[bool] = True

    @model_validator(mode="after")
    def _words(self) -> "DampingOfModes":
        if self.of is not None and "mode" in self.model_fields_set:
            raise word("has both of (a link) and mode. Keep one of them.")
        if self.of is not None and self.spins:
            raise word("has both of (a link) and a spin of a rotor. Keep one of them.")
        return self

    @property
    def free_vibration(self) -> str:
        return "damping ratio of free vibration" if self.of is None else ""

    def form(self, model: Model, drives: tuple[Drive, ...], combine: Combine) -> Form:
        if self.spins:
            return self.whirl_form()
        return ModeDamping(self.mode) if self.of is None else Monomials.of(model, model.ratios[self.of])

    def measure_static(self, machine: Machine) -> float:
        if self.of is not None:
            return machine.joint(self.of).damping_ratio
        if self.spins:
            return self.whirl_damping(machine)
        ratios = np.sort(ratios_of(machine.held_poles()))
        return float(ratios[self.mode - 1]) if len(ratios) >= self.mode else float("inf")


class LogarithmicDecrement(OfWhirls):
    """`response = "logarithmic_decrement"`: of the `mode`-th least damped mode or whirl, 2 pi z / sqrt(1 - z^2)."""

    less_is_worse: ClassVar[bool] = True

    @property
    def free_vibration(self) -> str:
        return "logarithmic decrement of free vibration"

    def form(self, model: Model, drives: tuple[Drive, ...], combine: Combine) -> Form:
        return self.whirl_form() if self.spins else LogDecrement(self.mode)

    def measure_static(self, machine: Machine) -> float:
        """By what is left after one turn of each pole e^{i w t}: log of the ratio of two sizes."""
        if self.spins:
            return self.whirl_damping(machine)
        poles = machine.held_poles()
        turning = poles[poles.real > 1e-9 * np.abs(poles)]
        after = np.sort(2.0 * np.pi * turning.imag / turning.real)
        return float(after[self.mode - 1]) if len(after) >= self.mode else float("inf")


def ratios_of(poles: ComplexArray) -> list[float]:
    """Damping ratio per pair of poles: half the sum of their decay rates over the root of the product."""
    top = float(np.abs(poles).max(initial=0.0))
    turning = [p for p in poles if p.real > 1e-9 * abs(p) and abs(p) > 1e-9 * top]
    decaying = sorted(p.imag for p in poles if abs(p.real) <= 1e-9 * abs(p) and abs(p) > 1e-9 * top)
    ratios = [float(p.imag / abs(p)) for p in turning]
    while len(decaying) > 1:
        slow, fast = decaying.pop(0), decaying.pop()
        ratios.append(float((slow + fast) / (2.0 * np.sqrt(slow * fast))))
    return ratios


class LossFactor(OfLink):
    """`response = "loss_factor"`: of a link."""

    of_mount: ClassVar[str] = "alike"

    def form(self, model: Model, drives: tuple[Drive, ...], combine: Combine) -> Form:
        imaginary = [t for t in model.terms if t.owner == self.of and t.kind == HYSTERETIC]
        real = [t for t in model.terms if t.owner == self.of and t.kind == STIFFNESS and t.scale]
        scale = np.array([a.scale / b.scale for a, b in zip(imaginary, real, strict=True)])
        exponents = np.array([a.exponents - b.exponents for a, b in zip(imaginary, real, strict=True)])
        return Monomials(scale, exponents)

    def measure_static(self, machine: Machine) -> float:
        return machine.joint(self.of).loss_factor
