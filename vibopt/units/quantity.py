"""A value as it came through the door."""

from typing import Literal, TypeAlias

from vibopt.records import dataclass

Detector: TypeAlias = Literal["pk", "pp", "rms"]


@dataclass(frozen=True, slots=True)
class Quantity:
    """A number in SI with the words it was written in.

    Attributes
    ----------
    value
        In SI; speeds of rotation and frequencies in rad/s, ratios as a number, levels in dB.
        An amplitude is peak: pp has been halved, rms multiplied by the root of two (the peak of one sine of that rms).
    unit
        The user's own unit text, with the detector word if there was one ("mm pp"); "" for a bare number.
    detector
        How an amplitude was written; None if no word said so, and then an amplitude is peak.
    echo
        A sentence to show back where the unit was read as the place expects, as in
        '"100 lb/in" read as 100 lbf/in'; else None.
    """

    value: float
    unit: str
    detector: Detector | None = None
    echo: str | None = None
