"""Limits that hardly any machine may break: a box of machines that are proven to keep one, and draws beyond it."""

from __future__ import annotations

from collections.abc import Sequence

from vibopt.program.far_off import Beyond
from vibopt.program.program import Limit
from vibopt.scene.uncertain import Uncertain
from vibopt.solve.proof import kept_within

_TIMES = (20.0, 50.0, 100.0, 200.0, 500.0, 1000.0)
"""By how many times more machines lie beyond the box than may break the limit."""
_MOST = 0.9
_LEAST_LEFT = 0.02


def beyond(parts: Sequence[Limit], doubts: Sequence[Uncertain], wanted: float, times: float) -> Beyond | None:
    """Machines beyond a box, so many times more than may break a limit; None where there is no such box."""
    acting = sum((part.form.acting(part.model) != 0.0).any(axis=0) for part in parts) > 0
    found = Beyond.of(doubts, acting, times * (1.0 - wanted))
    if found.part >= _MOST or not found.bounded.any():
        return None
    return found if min(axis.low for axis in found.axes) >= _LEAST_LEFT else None


def proven_beyond(parts: Sequence[Limit], doubts: Sequence[Uncertain], wanted: float) -> Beyond | None:
    """Machines beyond the greatest of some boxes on which a limit is proven to hold; None where it is on none."""
    for times in _TIMES:
        found = beyond(parts, doubts, wanted, times)
        if found is not None and all(kept_within(part, found.axes) for part in parts):
            return found
    return None
