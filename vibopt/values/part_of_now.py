"""Parts of what a number is now, "-20 %": the one rule of `--set`, `--vary`, `--limits`, scenarios and Python.

A percentage with a sign is a part of what the number is now, whatever number it is.  Without a sign it is the value of
a number that is counted in percent, as an isolation; of any other number it may be meant in two ways, and is refused.
A value below zero of a number in percent is written as a number: -0.05.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from vibopt.records import dataclass
from vibopt.values.fact_at import FactAt

IN_PERCENT = "ratio"
"""Dimension of numbers that are counted in percent themselves."""
_PART = re.compile(r"\s*([+−-]?)\s*(\d+(?:\.\d+)?)\s*%\s*")


@dataclass(frozen=True, slots=True)
class Part:
    """A percentage: its sign as it was written, 1, -1, or 0 without one, and its size as a share."""

    sign: int
    share: float

    @property
    def times(self) -> float:
        """By what the number is multiplied; a plus is meant where none is written."""
        return 1.0 - self.share if self.sign < 0 else 1.0 + self.share


def part_in(text: object) -> Part | None:
    """The percentage that a text is, and nothing else; None where it is none."""
    said = _PART.fullmatch(text) if isinstance(text, str) and "%" in text else None
    if said is None:
        return None
    return Part({"": 0, "+": 1}.get(said[1], -1), float(said[2]) / 100.0)


def parts_in(texts: Sequence[str]) -> list[Part] | None:
    """Percentages that are parts of a number: at least two, one of them signed; None where they are none.

    Among signed ones a plus is meant where none is written, as in "-20 %..20 %".
    """
    found = [part for part in map(part_in, texts) if part is not None]
    return found if len(found) == len(texts) > 1 and any(part.sign for part in found) else None


def two_ways(text: str, fact: FactAt, share: float) -> str:
    """That a percentage without a sign may be meant in two ways, and how each is written."""
    that = "" if share in (0.0, 1.0) else f', "{100.0 * (share - 1.0):+.6g} %" for {fact.now(share)}'
    return (
        f'may be a part of {fact.now(1.0)} in two ways. Write "+{text}" for {fact.now(1.0 + share)}, "-{text}" for '
        f"{fact.now(1.0 - share)}{that}."
    )


def as_read(text: str, fact: FactAt, part: Part) -> str:
    """How a part was read: "read as 57 %, from 60 %"."""
    itself = ""
    if part.sign < 0 and fact.dimension == IN_PERCENT:
        itself = f"; a sign makes it a part of that, and the value itself is written {-part.share:.6g}"
    return f'"{text}" read as {fact.now(part.times)}, from {fact.now(1.0)}{itself}'
