"""A release: a body is let go from a displacement, with a velocity, or both."""

from dataclasses import replace
from typing import ClassVar

import numpy as np
from pydantic import model_validator

from vibopt.excitations.at_once import AtOnce
from vibopt.excitations.directed import Along
from vibopt.excitations.segments import AFTER, line
from vibopt.signals import Segment
from vibopt.values import Fact, number, word


class Release(AtOnce, Along):
    """`kind = "release"`: a body is let go from a place beside its rest, or with a velocity; no force acts on it.

    Keys
    ----
    displacement: Where it is let go, from its place at rest on, with its sign: `displacement = "10 mm"`. One of
        `displacement` and `velocity`, or both.
    velocity: How fast it then moves, with its sign: `velocity = "-0.3 m/s"`.
    """

    displacement: Fact | None = number("length", choice=False, sign="any")
    velocity: Fact | None = number("velocity", choice=False, sign="any")
    family: ClassVar[str] = "bodies"

    @model_validator(mode="after")
    def _somewhere(self) -> "Release":
        if not any(self.start):
            raise word('needs a displacement or a velocity that is not zero. Write velocity = "0.3 m/s".')
        return self

    @property
    def start(self) -> tuple[float, float]:
        displacement, velocity = (0.0 if fact is None else fact.value for fact in (self.displacement, self.velocity))
        return displacement, velocity

    @property
    def fastest(self) -> float:
        """Nothing acts."""
        return 0.0

    def segments(self) -> tuple[Segment, ...]:
        return (replace(line(AFTER, 0.0, 0.0), released=np.array([self.start])),)
