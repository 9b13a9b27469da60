"""Large structures that other devices sit on: sparse matrices, modes, and what the points need of them."""

from vibopt.mechanics.host.condense import CondensationError, condensed, massless
from vibopt.mechanics.host.coordinates import Coordinates, digits_lost, of_modes
from vibopt.mechanics.host.krylov import Reduction, reduced_host, whole_host
from vibopt.mechanics.host.lowest import free_motions
from vibopt.mechanics.host.matrices import Matrices

__all__ = [
    "CondensationError",
    "Coordinates",
    "Matrices",
    "Reduction",
    "condensed",
    "digits_lost",
    "free_motions",
    "massless",
    "of_modes",
    "reduced_host",
    "whole_host",
]
