"""Limits with a probability in words: what machines that were drawn say of each, and of all together."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from vibopt.answer.answer import Odds
from vibopt.answer.entry import Checked
from vibopt.program.drawn import CONFIDENCE, MET, NOT_MET, OPEN, Sampled


def percent(share: float) -> str:
    """A share as "99 %"."""
    return f"{100.0 * share:.8g} %"


def row_told(row: Checked, seen: Sampled, wanted: float, doubt: str = "") -> Checked:
    """A limit with what a share of all machines stays within, on the safe side of what was drawn."""
    assert row.limit is not None
    least = row.side == "at_least"
    value = seen.stays_within(wanted, least=least)
    size = abs(row.limit.value) or 1.0
    margin = (value - row.limit.value if least else row.limit.value - value) / size
    shown = replace(row.value, value=value, text="")
    if np.isnan(value):
        shown, margin = replace(row.value, value=-np.inf if least else np.inf, text="not known"), -np.inf
    least_said = "" if seen.counted else "at least "  # what is drawn tells a value that is on the safe side
    place = f"{row.place}, {least_said}{percent(wanted)} of all machines".removeprefix(", ")
    unsure = seen.verdict(wanted) == OPEN
    return replace(
        row, value=shown, margin=float(margin), worst_at={}, off={}, place=place, doubt=row.doubt or doubt, open=unsure
    )


def odds_of(worst: Checked, seen: Sampled, wanted: float) -> Odds:
    """What was drawn, beside the limit on the worst machine within the tolerances."""
    low, high = seen.share
    return Odds(
        wanted,
        int(seen.kept.sum()),
        len(seen.kept),
        low,
        high,
        1.0 if seen.counted else CONFIDENCE,
        seen.verdict(wanted),
        worst.value,
        worst.met,
        1.0 - seen.part,
        seen.counted,
    )


def judged_by(limits: Mapping[str, Checked], odds: Mapping[str, Odds], others: str = "") -> tuple[str, str]:
    """Status and claim of what is decided, by the verdicts; `others` is said of the limits without a probability."""
    broken = [key for key, row in limits.items() if key not in odds and not row.met]
    broken += [key for key, one in odds.items() if one.verdict == NOT_MET]
    unknown = [key for key, one in odds.items() if one.verdict == OPEN]
    told = "; ".join(f"{key}: {one.words}" for key, one in odds.items())
    status = "violated" if broken else "unproven" if unknown else MET
    said = f"broken: {', '.join(broken)}" if broken else "every limit holds"
    if unknown and not broken:
        said = f"cannot be told with so many machines: {', '.join(unknown)}"
    return status, f"{said}{others}; {told}"
