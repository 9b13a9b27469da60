"""A drop: a base falls from a height and comes to rest at once, or rebounds."""

import math
from dataclasses import replace
from typing import ClassVar

import numpy as np
from pydantic import model_validator

from vibopt.excitations.at_once import AtOnce
from vibopt.excitations.directed import Along
from vibopt.excitations.segments import AFTER, line
from vibopt.mechanics.constants import GRAVITY
from vibopt.signals import Segment
from vibopt.values import Fact, number, word


class Drop(AtOnce, Along):
    """`kind = "drop"`: the velocity of a base changes at once: it falls and comes to rest, or it is struck.

    Keys
    ----
    height: From which it falls: `height = "0.5 m"`. One of `height` and `velocity_change`.
    velocity_change: By how much its velocity changes at once: `velocity_change = "3 m/s"`.
    rebound: Part of the velocity at which it goes up again, 0 to 1: `rebound = 0.3`.
    """

    height: Fact | None = number("length", choice=False)
    velocity_change: Fact | None = number("velocity", choice=False)
    rebound: Fact | None = number("ratio", choice=False, sign="not negative", most=1.0)
    family: ClassVar[str] = "bases"

    @model_validator(mode="after")
    def _one_of_two(self) -> "Drop":
        if self.height is not None and self.velocity_change is not None:
            raise word(
                "gives height and velocity_change. Keep one: a drop from a height changes the velocity by as much."
            )
        if self.height is None and self.velocity_change is None:
            raise word('needs one of height and velocity_change. Write height = "0.5 m".')
        if self.rebound is not None and self.height is None:
            raise word("has a rebound, which speaks of a drop from a height. Write the whole velocity_change instead.")
        return self

    @property
    def kick(self) -> float:
        """Change of the velocity of the base [m/s]."""
        if self.velocity_change is not None:
            return self.velocity_change.value
        assert self.height is not None
        back = self.rebound.value if self.rebound is not None else 0.0
        return (1.0 + back) * math.sqrt(2.0 * GRAVITY * self.height.value)

    @property
    def blows(self) -> dict[float, float]:
        return {0.0: self.kick}

    def segments(self) -> tuple[Segment, ...]:
        return (replace(line(AFTER, 0.0, 0.0), blows=np.array([self.kick])),)
