"""What is told of permitted designs: how far each number may go, and a box in which all may be off at once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import asin, degrees, tau
from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.answer.entry import Entry, direction
from vibopt.answer.tabular import Tabular
from vibopt.records import dataclass
from vibopt.study.spans import BETWEEN, Span

if TYPE_CHECKING:
    from vibopt.jobs import Job


@dataclass(frozen=True, slots=True)
class Window(Tabular):
    """Permitted designs of a machine, or plans of weights.

    spans
        One per variable.
    centre
        Design in the middle of the largest box that was found, by path.
    part
        Half of that box, as a part of each value: 0.09 for ±9 %.  Of weights as amounts, in any direction.
    proven
        Whether it is proven that every limit holds all over the box.
    claim
        How the box was tested.
    around
        Half of the largest box around the answer itself.
    between
        What is known of values between the least and the greatest of several variables.
    doubts
        What of the limits is found by a search and not proven, in words.
    """

    job: Job
    spans: tuple[Span, ...]
    centre: Mapping[str, Entry]
    part: float
    proven: bool
    claim: str
    around: float
    between: str = BETWEEN
    doubts: str = ""

    def box(self, path: str) -> tuple[Entry, Entry]:
        """How far one variable goes in the box; an angle alone as far as its weight goes across."""
        middle = self.centre[path]
        if middle.dimension == "angle":
            return turned(middle.value, -asin(self.part)), turned(middle.value, asin(self.part))
        low, high = (replace(middle, value=middle.value * (1.0 + side * self.part)) for side in (-1.0, 1.0))
        return low, high

    @property
    def safe(self) -> str:
        """What may be off at once: "±9 % on both"."""
        angles = sum(entry.dimension == "angle" for entry in self.centre.values())
        count, half = len(self.centre) - angles, f"±{percent(self.part)}"
        each = ("the weight" if angles else "the value") if count == 1 else "both" if count == 2 else f"all {count}"
        said = f"{half}{' and more' if self.part > 0.499 else ''} on {each}"
        if not angles:
            return said
        kind = " weights" if count > 1 else ""
        return f"{said}{kind} in any direction, alone {half} in size or ±{degrees(asin(self.part)):.3g} deg,"

    def table(self) -> list[dict[str, Any]]:
        """A row for each interval of each variable: its ends, and the box in it."""
        rows = []
        for span in self.spans:
            middle, (least, most) = self.centre[span.path], self.box(span.path)
            for low, high in span.intervals:
                rows.append({
                    "path": span.path, "unit": middle.si, "from": low.value, "to": high.value, "proven": span.proven,
                    "open": span.opened, "centre": middle.value, "box from": least.value, "box to": most.value,
                    "from shown": low.shown, "to shown": high.shown, "centre shown": middle.shown,
                })  # fmt: skip
        return rows

    def heading(self) -> tuple[str, ...]:
        """Title, and the box in words."""
        return self.job.title, f"±{percent(self.part)} on each at once is safe: {self.claim}"

    def as_said(self) -> dict[str, Any]:
        """Spans, centre and box."""
        keys = ("spans", "centre", "part", "proven", "claim", "around")
        return {**{key: getattr(self, key) for key in keys}, **({"spans_are": self.said} if self.said else {})}

    @property
    def said(self) -> str:
        """What the intervals of several variables are, in words."""
        tried = max(span.tried for span in self.spans)
        if len(self.spans) == 1:
            return ""
        if not tried:
            return f"least and greatest. {self.between}"
        return f"every interval that {tried} values between the least and the greatest tell. A narrower gap may be left"


def turned(angle: float, by: float) -> Entry:
    """A direction beside another one, which may be beyond a full turn."""
    return replace(direction((angle + by) % tau), value=angle + by)


def percent(part: float) -> str:
    """A part in percent, rounded down: what is said holds."""
    if part <= 0.0:
        return "0 %"
    step = 10.0 ** (np.floor(np.log10(100.0 * part)) - 2)
    return f"{np.floor(100.0 * part / step * (1.0 + 1e-12)) * step:.3g} %"
