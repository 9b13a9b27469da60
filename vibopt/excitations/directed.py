"""Excitations on bodies in space: where they act, along which direction or about which axis."""

import math
from typing import Annotated, Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.excitations.excitation import Excitation, Once
from vibopt.mechanics.vectors import cross
from vibopt.values.directions import AXES, Direction, Place, Vector
from vibopt.values.kinds import Later

RunUp = Annotated[Any, Later("vibopt.excitations", "run_up.RunUp")]


class Along(Excitation):
    """Words of what acts along a direction.

    Keys
    ----
    direction: In space the direction in which it acts: `direction = "z"`, or three numbers. Refused along a line.
    """

    direction: Direction | None = None

    @property
    def acts(self) -> dict[str, complex]:
        if self.direction is None:
            return super().acts
        return {f"{self.place}.{axis}": complex(part) for axis, part in zip(AXES, self.direction, strict=True) if part}

    @property
    def once(self) -> Once | None:
        if getattr(self, "begins", None) is None:
            return None
        from vibopt.excitations.begun import begun

        return begun(self)


class Directed(Along):
    """Words of a force at a place: `at` (else the centre of mass, or the point that it is on), `direction`.

    Keys
    ----
    at: In space its place; without it the centre of mass, or the point it is on: `at = ["0.2 m", "0 m", "0.4 m"]`.
        Refused along a line.
    """

    at: Place | None = None

    @property
    def place(self) -> str:
        """Name of the place where it acts: a body, a point, or one that only this excitation knows."""
        return self.on if self.at is None else place_name(self.on, self.at)


def place_name(body: str, at: Vector) -> str:
    """Name of a place on a body without a name of its own."""
    return f"{body} ({', '.join(repr(value) for value in at)})"


def turned(axis: Vector) -> tuple[FloatArray, FloatArray]:
    """Two directions at right angles to an axis, the second a quarter turn on about it."""
    own = np.array(axis)
    least = int(np.abs(own).argmin())
    first = cross(own, np.eye(3)[least])
    if np.abs(own).max() > 1.0 - 1e-12:
        first = np.eye(3)[(int(np.abs(own).argmax()) + 1) % 3]
    first = first / math.sqrt(float(first @ first))
    return first, cross(own, first)
