"""How a rival's answer is put: what its solver says, and nothing more."""

from __future__ import annotations

import numpy as np

from vibopt.forms import FloatArray
from vibopt.program.program import Program
from vibopt.solve.method import Found


def claimed(name: str, program: Program, y: FloatArray, *, success: bool, word: str, speeds: int) -> Found:
    """A design y = log x with the solver's own word for it."""
    x = np.clip(np.exp(y), program.low, program.high)
    if success:
        return Found("feasible", x, f"{word} (limits at {speeds} sampled speeds)", name)
    return Found("unproven", None, f"the solver gives up: {word}", name)


def discrete(name: str, program: Program) -> str | None:
    """The refusal of discrete variables."""
    for axis in program.axes:
        if axis.values is not None and len(axis.values) > 1:
            return f"{name} takes continuous variables only, but {axis.path} is chosen from {len(axis.values)} values."
    return None
