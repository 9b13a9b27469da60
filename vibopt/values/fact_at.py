"""A number of a problem file by its path: what it is, and how a value is written back into the document."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from vibopt.errors import InputError, counted, way_out
from vibopt.records import dataclass
from vibopt.units import Detector, Quantity, read_quantity, read_range, to_unit
from vibopt.units.parsing import TO_PEAK


@dataclass(frozen=True, slots=True)
class FactAt:
    """A fact: its path, value [SI], the user's unit, its dimension, whether it is an amplitude.

    signed
        Whether it may be zero or negative: a coordinate of a place.
    place, around
        For a part of a text (an end of a range, the angle of a reading): where the text stands in the file, and the
        text with {} for this part.
    detector
        What an amplitude without a word means in this file; None: peak.
    """

    path: str
    value: float
    unit: str
    dimension: str
    amplitude: bool = False
    signed: bool = False
    place: str = ""
    around: str = "{}"
    detector: Detector | None = None

    def text(self, value: float) -> str | float:
        """A value [SI] as it would stand in the file, exact to the last digit."""
        if not self.unit or self._below(value):
            return int(value) if self.dimension == "count" and value.is_integer() else value
        return f"{to_unit(value, self.unit, self.dimension):.17g} {self.unit}"

    def now(self, times: float) -> str:
        """The value times a factor in the unit of the file, to twelve digits: "8 kN"."""
        value = times * self.value
        if self._below(value):
            return f"{value:.12g}"
        return f"{to_unit(value, self.unit, self.dimension) if self.unit else value:.12g} {self.unit}".rstrip()

    def _below(self, value: float) -> bool:
        """Whether it is a percentage below zero, which a sign would make a part of what the number is now."""
        return self.unit == "%" and value < 0.0

    def changes(self, value: float) -> dict[str, str | float]:
        """What to put into the document, by path, for a value [SI]."""
        return {self.place: self.around.format(self.text(value))} if self.place else {self.path: self.text(value)}

    def read(self, text: str) -> float:
        """A text as a value of this fact [SI]."""
        return self.quantity(text).value

    def quantity(self, text: str) -> Quantity:
        """A text as a value of this fact [SI], with its unit; QuantityError where it cannot be read."""
        return self._meant(read_quantity(text, self.dimension, amplitude=self.amplitude))

    def ends(self, text: str) -> tuple[Quantity, Quantity]:
        """Both ends of a range [SI]; QuantityError where it cannot be read."""
        low, high = read_range(text, self.dimension, amplitude=self.amplitude)
        return self._meant(low), self._meant(high)

    def _meant(self, said: Quantity) -> Quantity:
        """An amplitude without a word as the file means it."""
        if self.detector is None or said.detector is not None:
            return said
        return replace(said, value=said.value * TO_PEAK[self.detector], unit=f"{said.unit} {self.detector}")


def fact_among(known: Iterable[FactAt], path: str) -> FactAt:
    """The fact at a path; InputError where there is none, with near ones, or the parts of a text that stands there."""
    found = {fact_at.path: fact_at for fact_at in known}
    if path in found:
        return found[path]
    ends = (f"{path}.from", f"{path}.to")
    parts = [fact_at.path for fact_at in found.values() if fact_at.place == path or fact_at.path in ends]
    if parts:
        one = "one" if len(parts) > 1 else "it"
        raise InputError(f"{path} holds {counted(len(parts), 'numbers')}. Name {one}: {' or '.join(parts)}.")
    near = [one for one in found if path in one.split(".")][:1]  # a step of a path alone
    raise InputError(f"there is no fact called {path}.{way_out((near or [path])[0], list(found))}")
