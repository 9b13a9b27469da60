"""How fast the slowest free vibration dies away."""

from typing import ClassVar

import numpy as np

from vibopt.forms import DecayRate, Form
from vibopt.mechanics.machine import Machine
from vibopt.mechanics.model import Model
from vibopt.responses.response import FEW_MODES, Response
from vibopt.signals import Combine, Drive


class DecayRateOfModes(Response):
    """`response = "decay_rate"`: the least over all modes, -max Re(pole) [1/s]; rigid motion is left out."""

    dimension: ClassVar[str] = "decay_rate"

    @property
    def modes(self) -> int:
        return FEW_MODES

    @property
    def free_vibration(self) -> str:
        return "decay rate of free vibration"

    def form(self, model: Model, drives: tuple[Drive, ...], combine: Combine) -> Form:
        return DecayRate()

    def measure_static(self, machine: Machine) -> float:
        return max(float(machine.held_poles().imag.min(initial=np.inf)), 0.0)
