"""How fast the slowest free vibration dies away."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from vibopt.forms import Combine, DecayRate, Drive, FloatArray, Form
from vibopt.mechanics.machine import Machine
from vibopt.mechanics.model import Model
from vibopt.responses.kind import Response


class DecayRateOfModes(Response):
    """`response = "decay_rate"`: the least over all modes, -max Re(pole) [1/s]; rigid motion is left out."""

    dimension: ClassVar[str] = "decay_rate"

    def form(self, model: Model, drives: tuple[Drive, ...], combine: Combine) -> Form:
        return DecayRate()

    def measure_static(self, machine: Machine) -> float:
        poles = machine.poles()
        kept = poles[np.argsort(np.abs(poles))[_loose(machine) :]]
        return max(float(kept.imag.min(initial=np.inf)), 0.0)


def _loose(machine: Machine) -> int:
    """Poles at zero, counted as the motions on which no spring (and no damper) does any work."""
    _, damping, stiffness, _ = machine.matrices()
    return _nullity(stiffness) + _nullity(stiffness, damping)


def _nullity(*matrices: FloatArray) -> int:
    """Directions along which none of some positive matrices (n, n) does work."""
    scaled = []
    for matrix in matrices:
        size = np.sqrt(np.where(np.diag(matrix) > 0.0, np.diag(matrix), 1.0))
        scaled.append(matrix / size[:, None] / np.abs(matrix / size[:, None]).max(initial=1e-300))
    rank = int(np.linalg.matrix_rank(np.concatenate(scaled), tol=1e-12))
    return int(matrices[0].shape[0]) - rank
