"""A harmonic force on a body."""

from __future__ import annotations

from vibopt.excitations.kind import OneSpeed, Varies, unit_line
from vibopt.excitations.spatial import Directed
from vibopt.forms import FloatArray, Line
from vibopt.values import Fact, number


class Force(Directed):
    """`kind = "force"`: F cos(w t), amplitude [N] peak."""

    amplitude: Fact = number("force", amplitude=True, choice=False, required=True)
    varies: Varies = None
    amplitude_at: OneSpeed | None = None

    def lines(self, direction: FloatArray) -> tuple[Line, ...]:
        return (unit_line(1.0, direction, 0.0, self.shape(self.amplitude.value)),)
