"""Frequencies at which something begins or ends for a limit: where a natural frequency meets them, it may turn."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.program.program import Aim, Limit


def watched(parts: Iterable[Limit | Aim]) -> FloatArray:
    """Orders of single speeds and of the ends of ranges, edges of forbidden bands, bounds of frequencies [rad/s]."""
    found: list[float] = []
    for part in parts:
        found += part.form.watched((part.bound, part.upper) if isinstance(part, Limit) else ())
    return np.array(list(dict.fromkeys(value for value in found if 0.0 < value < np.inf)))
