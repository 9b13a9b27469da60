"""Limits at many designs at once: exact where there are no speeds, at the sampled speeds elsewhere."""

from __future__ import annotations

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms import Form
from vibopt.forms.bounds import CLOSE, FormBounds
from vibopt.mechanics.model import Model
from vibopt.mechanics.modes import modes_at
from vibopt.program.program import Limit

MOST_GROUPS = 6
"""Springs and dampers with directions of their own up to which polynomials are worth it."""


def bounds_of(model: Model, form: Form, reference: FloatArray) -> FormBounds:
    """Bounds of a form by polynomials, or where they would be too large its speeds alone."""
    made = FormBounds(model, form, reference)
    made.direct = form.solved_directly or made.directions > MOST_GROUPS
    return made


def fails(limit: Limit, values: FormBounds, x: FloatArray, slack: float | None = None) -> FloatArray:
    """By how much of its bound each design is proven to miss a limit; negative where it is not, shape (n,)."""
    if limit.side == "outside":
        modes = modes_at(limit.model, x)
        depth: FloatArray = np.minimum(modes - limit.bound, limit.upper - modes).max(axis=1)
        return depth / max(limit.bound, 1e-300) - CLOSE
    most, least = values.at(x)
    size = abs(limit.bound) or 1.0
    missed = (most - limit.bound) / size if limit.side == "at_most" else (limit.bound - least) / size
    return np.nan_to_num(missed, nan=-np.inf, posinf=np.inf, neginf=-np.inf) - (
        values.slack if slack is None else slack
    )
