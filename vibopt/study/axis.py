"""How the values of a number of a file lie, and what a sensible step of it is."""

from __future__ import annotations

import math
from collections.abc import Callable

from vibopt.records import dataclass
from vibopt.scene.scene import Scene
from vibopt.units import read_quantity, to_unit
from vibopt.values.fact_at import FactAt

STEP = 0.1
"""A sensible step: a tenth of the number."""
_NEAR = 0.05
"""Part of the step by which rounding may change it."""
_NOTHING = 1e-12
"""Part of an extent that is rounding."""
_TURN = math.pi / 2.0
NO_STEP = "it is zero, and nothing says how large a step is"


@dataclass(frozen=True, slots=True)
class Axis:
    """Values of a number by how far they are from what it is: in decades, whole steps, or parts of an extent.

    complement
        What is counted is what is left to one: 1 - value.
    extent
        Of numbers that may be zero or negative: what the whole way is [SI]; else 0.
    """

    fact: FactAt
    complement: bool = False
    extent: float = 0.0

    def value(self, t: float) -> float:
        """The number [SI] at t, 0 where it is."""
        now = self.fact.value
        if t == 0.0:
            return now
        if self.counted:
            return max(now + round(t * max(now, 1.0) * (9.0 if t > 0.0 else 1.0)), 1.0)
        if self.extent:
            moved = now + t * self.extent
            return moved if abs(moved) > _NOTHING * self.extent else 0.0
        return 1.0 - (1.0 - now) * float(10.0**-t) if self.complement else now * float(10.0**t)

    def at(self, value: float) -> float:
        """Inverse of `value`."""
        now = self.fact.value
        if self.extent:
            return (value - now) / self.extent
        ratio = (1.0 - now) / (1.0 - value) if self.complement else value / now
        return math.log10(ratio) if ratio > 0.0 else math.nan

    @property
    def counted(self) -> bool:
        """Whether it is a whole number."""
        return self.fact.dimension == "count"

    def step(self, way: int) -> float:
        """A sensible step, rounded so that it can be named as it is solved."""
        now = self.fact.value
        if self.counted:
            return max(now + way, 1.0)
        if self.extent:
            aimed = now + way * (math.radians(1.0) if self.fact.dimension == "angle" else 0.01 * self.extent)
        else:
            aimed = 1.0 - (1.0 - now) * (1.0 - way * STEP) if self.complement else now * (1.0 + way * STEP)
        return rounded(self.fact, aimed)


def axis_of(fact: FactAt, extent: Callable[[], float], job: object = None) -> Axis | None:
    """The axis of a number of a job; None where it is zero and nothing says how large a step is.

    Only of a place it is asked how far the `extent` of all places is [m].
    """
    if fact.dimension == "angle" and not fact.path.startswith("limits."):
        return Axis(fact, extent=_TURN)
    if fact.dimension == "length" and (fact.signed or is_place(fact)):
        return Axis(fact, extent=extent())
    steps = fact.path.split(".")
    complement = steps[0] == "limits" and isinstance(job, Scene) and job.limits[steps[1]].complement
    size = 1.0 - fact.value if complement else fact.value
    below = fact.value < 0.0 and steps[0] != "limits"
    return Axis(fact, complement=complement) if size > 0.0 or below else None


def is_shelf(path: str) -> bool:
    """Whether a number is the weight of one piece of a shelf."""
    return path.startswith("planes.") and path.split(".")[-2] == "shelf"


def is_place(fact: FactAt) -> bool:
    """Whether a length says where something is along the shaft."""
    family, name, *_ = *fact.path.split("."), ""
    return fact.path.endswith(".at") or (family in ("shaft", "quality") and name in ("bearings", "planes"))


def rounded(fact: FactAt, aimed: float) -> float:
    """A number with as few digits in its unit as leave the step what it is."""
    step, unit = aimed - fact.value, fact.unit
    for digits in range(1, 6):
        number = float(f"{to_unit(aimed, unit, fact.dimension) if unit else aimed:.{digits - 1}e}")
        value = number
        if unit:
            value = read_quantity(f"{number:.12g} {unit}", fact.dimension, amplitude=fact.amplitude).value
        if abs(value - aimed) <= _NEAR * abs(step):
            return value
    return aimed
