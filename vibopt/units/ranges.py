"""Reading a range, "800..2000 rpm": every value in it."""

from vibopt.errors import QuantityError
from vibopt.units import complaints
from vibopt.units.dimensions import DIMENSIONS
from vibopt.units.quantity import Quantity
from vibopt.units.reading import BARE, read_quantity, split_value


def is_range(text: object) -> bool:
    """Whether a value is written as a range, with two points."""
    return isinstance(text, str) and ".." in text


def read_range(
    given: str, dimension: str, *, amplitude: bool = False, place: str | None = None
) -> tuple[Quantity, Quantity]:
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
    high = _end("upper", high_text, dimension, amplitude, place, alone=shared)
    low = _end("lower", full_low, dimension, amplitude, place, alone=shared)
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


def _end(name: str, text: str, dimension: str, amplitude: bool, place: str | None, *, alone: bool) -> Quantity:
    """One end; a complaint names the end unless both share one unit."""
    try:
        return read_quantity(text, dimension, amplitude=amplitude, place=place)
    except QuantityError as error:
        if alone:
            raise
        raise _at_end(name, text, error) from None


def _at_end(name: str, text: str, error: QuantityError) -> QuantityError:
    return QuantityError(f'has the {name} end "{text}", which {error.complaint}')
