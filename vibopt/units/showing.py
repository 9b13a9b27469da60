"""Showing a value: from SI back to the user's unit, in plain digits."""

from math import ceil, degrees, floor, isfinite, isinf, isnan, log10

from vibopt.units.dimensions import DIMENSIONS
from vibopt.units.parsing import TO_PEAK
from vibopt.units.scales import scale_of
from vibopt.units.spelling import split_detector


def to_unit(value: float, unit: str, dimension: str) -> float:
    """Number of `unit` in an SI `value`; with a detector word in `unit`, `value` is a peak.

    Raises
    ------
    QuantityError
        `unit` is not one of this dimension.
    ValueError
        Decibels of a ratio that is not positive.
    """
    bare, detector, _ = split_detector(unit)
    scale = scale_of(bare, dimension)
    if isinf(value):
        return value
    return scale.from_si(value / TO_PEAK[detector])


_ALL, _ROUNDING = 99.9, 1e-6
"""Percents from which on what is left of a hundred counts."""


def show(value: float, unit: str, dimension: str, *, digits: int = 4, amplitude: bool = False) -> str:
    """An SI value as text: "6.957 MN/m", "20 mm pk".

    Parameters
    ----------
    value
        In SI; peak if an amplitude.
    unit
        The user's unit text, with its detector word if there is one; "" chooses a unit by size.
    dimension
        Name in `DIMENSIONS`.
    digits
        Significant digits at most; digits before the point are never dropped.
    amplitude
        Says "pk" behind a unit that has no detector word.

    Notes
    -----
    Decibels of a ratio that is not positive do not exist: it is shown in percent.  A part that is not all, but for
    rounding, is not shown as "100 %".
    """
    if isinf(value):
        return "infinite" if value > 0 else "minus infinite"
    if isnan(value):
        return "not a number"
    bare, _, word = split_detector(unit)
    if not bare:
        bare = best_unit(value, dimension)
    if bare == "dB" and dimension == "ratio" and value <= 0:
        bare = "%"
    number = to_unit(value, f"{bare} {word}".strip(), dimension)
    if bare == "%" and _ALL < number < 100.0 - _ROUNDING:
        digits = max(digits, 3 - floor(log10(100.0 - number)))
    return " ".join(filter(None, (plain(number, digits), bare, word or ("pk" if amplitude else ""))))


def best_unit(value: float, dimension: str) -> str:
    """A unit for an SI `value` by its size, where the user gave none; the usual one for 0 and infinity."""
    kind = DIMENSIONS[dimension]
    if value == 0 or isinf(value) or isnan(value):
        return kind.usual if kind.ladder[0][1] else ""
    chosen = kind.ladder[0][1]
    for start, unit in kind.ladder:
        if abs(value) >= start:
            chosen = unit
    return chosen


def plain(number: float, digits: int = 4) -> str:
    """A finite number with at most `digits` significant digits, but all of those before the point.

    Exponents only below 1e-6 and from 1e15 ("1.5e-9"), where plain digits are no longer read by anybody.
    """
    if number == 0:
        return "0"
    size = abs(number)
    if not 1e-6 <= size < 1e15:
        mantissa, _, exponent = f"{number:.{digits - 1}e}".partition("e")
        return f"{float(mantissa):.{digits}g}e{int(exponent)}"
    decimals = max(0, digits - 1 - floor(log10(size)))
    text = f"{number:.{decimals}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def show_angle(angle: float, digits: int = 4) -> str:
    """An angle [rad] as text in degrees from 0 to below 360, with `digits` - 3 decimals."""
    text = f"{degrees(angle):.{max(digits - 3, 0)}f}"
    text = text.rstrip("0").rstrip(".") if "." in text else text
    return "0 deg" if text in ("360", "-0") else f"{text} deg"


def outward(value: float, side: str, digits: int = 3) -> float:
    """A number rounded away from its limit, so that using it really works."""
    if value == 0.0 or not isfinite(value):
        return value
    unit = 10.0 ** (floor(log10(abs(value))) - digits + 1)
    steps = value / unit
    whole = ceil(steps * (1 + 1e-9)) if side == "at_most" else floor(steps * (1 - 1e-9))
    return whole * unit
