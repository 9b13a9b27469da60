"""Units at the door: text with a unit becomes an SI number here, and an SI number becomes text again.

Inside vibopt every number is SI, every frequency in rad/s and every amplitude peak.
"""

from vibopt.units.dimensions import DIMENSIONS, Detector, Dimension, Quantity, si_unit
from vibopt.units.parsing import is_range, read_quantity, read_range, reads
from vibopt.units.showing import best_unit, outward, plain, show, to_unit

__all__ = [
    "DIMENSIONS",
    "Detector",
    "Dimension",
    "Quantity",
    "best_unit",
    "is_range",
    "outward",
    "plain",
    "read_quantity",
    "read_range",
    "reads",
    "show",
    "si_unit",
    "to_unit",
]
