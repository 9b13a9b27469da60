"""A steady vibration that begins suddenly: a sine from zero that goes on for ever; before, the machine is at rest."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.excitations.excitation import Excitation, Once
from vibopt.excitations.segments import moved, sine
from vibopt.records import dataclass
from vibopt.signals import Segment


@dataclass(frozen=True, slots=True)
class Begun(Once):
    """What an excitation of one speed is from its beginning on.

    on, acts
        What it acts on, in space along which directions.
    size
        Amplitude of its force [N], or of the displacement of its base [m].
    omega
        Its speed [rad/s].
    base
        Whether it moves a base.
    """

    on: str
    size: float
    omega: float
    base: bool
    acts: dict[str, complex]

    @property
    def family(self) -> str:  # type: ignore[override]  # that of the excitation
        """Where it acts."""
        return "bases" if self.base else "bodies"

    @property
    def length(self) -> float:
        return 2.0 * np.pi / self.omega

    @property
    def endless(self) -> bool:
        return True

    @property
    def returns(self) -> bool:
        return True

    @property
    def blows(self) -> dict[float, float]:
        return {0.0: self.size * self.omega} if self.base else {}

    def course(self, time: float) -> tuple[float, float]:
        """Displacement [m] and velocity [m/s] of its base at a time behind its beginning [s]."""
        turned = self.omega * time
        return self.size * math.sin(turned), self.size * self.omega * math.cos(turned)

    @property
    def joints(self) -> tuple[float, ...]:
        return (0.0, self.length)

    def segments(self) -> tuple[Segment, ...]:
        whole = (replace(sine(self.length, self.size, 0.0, 2.0 * np.pi), endless=True),)
        return moved(whole) if self.base else whole

    def signal(self, time: FloatArray) -> FloatArray:
        size = -self.size * self.omega**2 if self.base else self.size
        return np.where(time >= 0.0, size * np.sin(self.omega * time), 0.0)


def begun(excitation: Excitation) -> Begun:
    """An excitation of one speed from its beginning on."""
    [line], speed = excitation.lines(np.ones(1)), excitation.own_bands()[0].low
    size = float(abs(line.amplitude.at(np.array(speed))))
    on_base = excitation.family == "bases"
    return Begun(excitation.on, size, speed, on_base, excitation.acts)
