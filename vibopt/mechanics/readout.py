"""What is read of a motion: places, rates and accelerations of coordinates in one sum, or its rates."""

from __future__ import annotations

from vibopt.arrays import IntArray
from vibopt.mechanics.panels import Numbers
from vibopt.records import dataclass


@dataclass(frozen=True, slots=True)
class Reading:
    """row . u + rates . u' + inertia . u'', differentiated `power` times; rows (..., n_coords), real or complex.

    grip
        Dry friction in it, against a stretch of the link that rubs.
    """

    row: Numbers
    rates: Numbers
    inertia: Numbers
    power: int = 0
    grip: float = 0.0

    def of(self, index: int | IntArray) -> Reading:
        """Of one or some of many machines."""
        row, rates, inertia = (one if one.ndim == 1 else one[index] for one in (self.row, self.rates, self.inertia))
        return Reading(row, rates, inertia, self.power)
