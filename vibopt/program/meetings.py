"""Frequencies at which something begins or ends for a limit: where a natural frequency meets them, it may turn."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms import ModeFrequency, ModeGap, Modulus
from vibopt.program.program import Aim, Limit


def watched(parts: Iterable[Limit | Aim]) -> FloatArray:
    """Orders of single speeds and of the ends of ranges, edges of forbidden bands, bounds of frequencies [rad/s]."""
    found: list[float] = []
    for part in parts:
        if isinstance(part.form, Modulus):
            for drive in part.form.drives:
                ends = [end for band in drive.bands for end in (band.low, band.high)]
                found += [line.order * end for line in drive.lines for end in ends]
        elif isinstance(part.form, ModeFrequency | ModeGap) and isinstance(part, Limit):
            found += [part.bound, part.upper]
    return np.array(list(dict.fromkeys(one for one in found if 0.0 < one < np.inf)))


__all__ = ["watched"]
