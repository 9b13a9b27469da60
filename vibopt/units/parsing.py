"""Reading a value or a range: text with a unit, or a bare number where a ratio or a count is meant."""

from __future__ import annotations

import re
from functools import lru_cache
from math import inf, isfinite, sqrt
from numbers import Real

from vibopt.errors import QuantityError
from vibopt.units import complaints
from vibopt.units.dimensions import DIMENSIONS, Detector, Quantity
from vibopt.units.scales import Scale, scale_of
from vibopt.units.spelling import split_detector

TO_PEAK: dict[Detector | None, float] = {None: 1.0, "pk": 1.0, "pp": 0.5, "rms": sqrt(2.0)}
"""Peak over the value written with each detector, for one sine."""

LARGEST = 1e30
_LONGEST = 300
"""Most letters of a value."""
BARE = ("ratio", "count")
"""Dimensions whose values may be bare numbers."""

_VALUE = re.compile(rf"({complaints.NUMBER})(?=\s+1/[A-Za-z]|(?!\s*(?:[\d,.'_]|[-–—]\s*\d|to\s*\d)))\s*(.*)", re.DOTALL)
_WORD_NOT_FINITE = re.compile(r"[+-]?(?:nan|inf|infinity|infinite)\b", re.IGNORECASE)


def reads(given: object, dimension: str) -> bool:
    """Whether a text is a quantity of a dimension."""
    try:
        return isinstance(given, str) and bool(read_quantity(given, dimension))
    except QuantityError:
        return False


def read_quantity(given: object, dimension: str, *, amplitude: bool = False, place: str | None = None) -> Quantity:
    """A value at the door, in SI.

    Parameters
    ----------
    given
        Text such as "300 kg", "20 mm pp", "-14 dB"; a number only for the dimensions "ratio" and "count".
    dimension
        Name in `DIMENSIONS`.
    amplitude
        Whether pk, pp or rms may stand behind the unit; without a word an amplitude is peak.
    place
        Who needs the dimension, for the message: "transmitted_force".

    Returns
    -------
    Quantity
        `value` in SI and, for amplitudes, peak.

    Raises
    ------
    QuantityError
        Anything that is not exactly one finite value of this dimension.
    """
    if isinstance(given, str):
        return _of_text(str(given), dimension, amplitude, place)
    if isinstance(given, bool):
        raise QuantityError(f"is true or false, but {complaints.needs(dimension, place)}")
    if not isinstance(given, Real):
        raise QuantityError(f"is no value with a unit, but {complaints.needs(dimension, place)}")
    if isinstance(given, float) and not isfinite(given):
        raise QuantityError(complaints.NOT_FINITE)
    return _quantity(str(given), "", dimension, amplitude, place)


@lru_cache(maxsize=4096)
def _of_text(text: str, dimension: str, amplitude: bool, place: str | None) -> Quantity:
    number, unit = split_value(text, dimension)
    return _quantity(number, unit, dimension, amplitude, place)


def split_value(text: str, dimension: str) -> tuple[str, str]:
    """Number and unit of a value as texts; QuantityError where there is not exactly one number in front."""
    if len(text) > _LONGEST:
        raise QuantityError("is longer than any value. Write one number and its unit.")
    tidy = text.replace("−", "-").strip()
    if ("±" in tidy or "+-" in tidy or "+/-" in tidy) and (wrong := complaints.with_tolerance(tidy, dimension)):
        raise QuantityError(wrong)
    match = None if ".." in tidy else _VALUE.fullmatch(tidy)
    if match:
        return match[1], match[2]
    if _WORD_NOT_FINITE.match(tidy):
        raise QuantityError(complaints.NOT_FINITE)
    raise QuantityError(complaints.no_single_number(tidy, dimension))


def _quantity(number: str, unit: str, dimension: str, amplitude: bool, place: str | None) -> Quantity:
    """A number with its unit text, checked and converted."""
    bare, detector, word = split_detector(unit)
    if not bare and dimension not in BARE:
        raise QuantityError(complaints.no_unit(number, word, dimension, moves=amplitude or place is not None))
    if "%" in bare and bare.strip() != "%" and dimension not in BARE:
        raise QuantityError(f"is a part and a size at once. Write it in {bare.replace('%', '').strip()} alone.")
    scale = scale_of(bare, dimension, place)
    if detector and not amplitude:
        raise QuantityError(complaints.no_amplitude(number, bare, word))
    value = _to_si(number, scale) * TO_PEAK[detector]
    if not abs(value) <= LARGEST:
        raise QuantityError(complaints.BEYOND)
    if dimension == "count" and not value.is_integer():
        raise QuantityError(f"is not a whole number. {DIMENSIONS[dimension].way_out}")
    echo = _echo(number, unit, scale.reading, word) if scale.reading else None
    return Quantity(value, unit, detector, echo)


def _to_si(number: str, scale: Scale) -> float:
    """SI value; infinite where floats end."""
    try:
        return scale.to_si(float(number))
    except OverflowError:
        return inf


def _echo(number: str, unit: str, reading: str, word: str) -> str:
    """The sentence that shows a reading back: '"100 lb/in" read as 100 lbf/in'."""
    gravity = " (gravity, 9.80665 m/s²)" if "gn" in reading else ""
    return f'"{number} {unit}" read as {complaints.words(number, reading, word)}{gravity}'


def is_range(text: object) -> bool:
    """Whether a value is written as a range, with two points."""
    return isinstance(text, str) and ".." in text


def read_range(given: str, dimension: str, *, amplitude: bool = False) -> tuple[Quantity, Quantity]:
    """Lower and upper end of "800..2000 rpm", "800 rpm..2000 rpm" or "13.3 Hz..2000 rpm".

    A lower end without a unit has that of the upper end. Parameters as in `read_quantity`.

    Raises
    ------
    QuantityError
        An end is missing or cannot be read, or the range is reversed or holds one value only.
    """
    low_text, high_text = _ends(given, dimension)
    low_unit, unit = _unit_of("lower", low_text, dimension), _unit_of("upper", high_text, dimension)
    if not (low_unit or unit or dimension in BARE):
        raise QuantityError(complaints.no_unit(f"{low_text}..{high_text}", "", dimension))
    shared = not low_unit
    full_low = f"{low_text} {unit}".rstrip() if shared else low_text
    high = _end("upper", high_text, dimension, amplitude, alone=shared)
    low = _end("lower", full_low, dimension, amplitude, alone=shared)
    if low.value > high.value:
        turned = f"{high_text}..{full_low}"
        raise QuantityError(f'runs downwards: its lower end is above its upper end. Write "{turned}".')
    if low.value == high.value:
        raise QuantityError(f'is empty: both ends are the same. Write the one value, "{high_text}", or a wider range.')
    return low, high


def _ends(given: str, dimension: str) -> tuple[str, str]:
    """Texts of the two ends."""
    example = f'Write a range, for example "0..{DIMENSIONS[dimension].example}".'
    if given.count("..") != 1 or "..." in given:
        raise QuantityError(f"is no range with two points between its ends. {example}")
    low, high = (text.strip() for text in given.split(".."))
    for name, text in (("lower", low), ("upper", high)):
        if not text:
            raise QuantityError(f"has no {name} end. {example}")
    return low, high


def _unit_of(name: str, end: str, dimension: str) -> str:
    """Unit text of an end, "" if it has none."""
    try:
        return split_value(end, dimension)[1]
    except QuantityError as error:
        raise _at_end(name, end, error) from None


def _end(name: str, text: str, dimension: str, amplitude: bool, *, alone: bool) -> Quantity:
    """One end; a complaint names the end unless both share one unit."""
    try:
        return read_quantity(text, dimension, amplitude=amplitude)
    except QuantityError as error:
        if alone:
            raise
        raise _at_end(name, text, error) from None


def _at_end(name: str, text: str, error: QuantityError) -> QuantityError:
    return QuantityError(f'has the {name} end "{text}", which {error.complaint}')
