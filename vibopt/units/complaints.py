"""What is wrong with a value, and the way out; each text continues the sentence "<path> = <given> "."""

import re
from math import isfinite

from vibopt.units.dimensions import DIMENSIONS

NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_LIKELY = {
    "length": (("mm", 1.0, 1e9), ("m", 0.01, 10.0)),
    "force": (("N", 1.0, 1e9), ("kN", 0.01, 20.0)),
    "stiffness": (("N/m", 300.0, 1e12), ("kN/m", 0.1, 1e5)),
    "damping": (("N s/m", 3.0, 1e9), ("kN s/m", 0.01, 100.0)),
    "angular_rate": (("rpm", 60.0, 1e6), ("Hz", 0.01, 200.0)),
    "unbalance": (("g mm", 1.0, 1e9), ("kg m", 1e-6, 1.0)),
    "time": (("s", 1e-4, 1e9), ("ms", 1.0, 1e4)),
}
"""Units before which a number from here to below there is likely to stand."""
NOT_FINITE = "is not a finite number."
BEYOND = "is beyond what any machine has (|value| > 1e30 in SI)."

_COMMA = r"(?s)([+-]?)(\d+),(\d+)(?![\d.,])(.*)"
_GAP = r"(?s)([+-]?\d{1,3}(?:[\s_',]\d{3})+(?!\d)\S*)(.*)"
_SCATTER = rf"(?s)({NUMBER})\s*([^±]*?)\s*\(?\s*(?:±|\+/?-)\s*({NUMBER})\s*(%?)\s*(.*?)\s*\)?\s*"
_DASH = rf"(?s)({NUMBER})\s*(?:-|–|—|to)\s*({NUMBER})(.*)"


def words(*parts: str) -> str:
    """The parts that are not empty, with spaces between."""
    return " ".join(part for part in parts if part)


def needs(dimension: str, place: str | None) -> str:
    """The half sentence that says what is needed here, or what `place` is, with the way out."""
    wanted = DIMENSIONS[dimension]
    alike = not place or wanted.noun.endswith(f" {place}")  # "jerk is a jerk" says nothing
    needed = f"{wanted.noun} is needed here" if alike else f"{place} is {wanted.noun}"
    return f"{needed}. {wanted.way_out}"


def no_unit(number: str, word: str, dimension: str, *, moves: bool = False) -> str:
    """For a bare `number` (with the detector `word`, if any) of a dimension that has units.

    What `moves`, or is bounded, is small: its length is one of millimetres.
    """
    kind, size = DIMENSIONS[dimension], abs(float(number)) if re.fullmatch(NUMBER, number) else 0.0
    likely = [unit for unit, low, high in _LIKELY.get(dimension, ()) if low <= size < high]
    units = likely if likely and not (moves and dimension == "length") else [kind.usual]
    return f"has no unit. Write {' or '.join(_quoted(words(number, unit, word)) for unit in units)}."


def _quoted(text: str) -> str:
    return f'"{text}"'


def no_amplitude(number: str, unit: str, word: str) -> str:
    """For a detector `word` behind something that is no amplitude."""
    shown = words(number, unit)
    return f'says "{word}", but only an amplitude can be peak, peak-to-peak or rms. Write "{shown}".'


def unknown_unit(unit: str, dimension: str) -> str:
    """Proposes the units that differ by case only, else the nearest, else all of the dimension."""
    kind = DIMENSIONS[dimension]
    near = [text for text in kind.units if text.casefold() == unit.casefold()]
    if not near:
        from difflib import get_close_matches

        near = get_close_matches(unit, kind.units, n=1)
    if near:
        way_out = "Did you mean " + " or ".join(f'"{text}"' for text in near) + "?"
    elif kind.units:
        way_out = f"Units of {kind.noun}: {', '.join(kind.units)}."
    else:
        way_out = kind.way_out
    return f'has the unknown unit "{unit}". {way_out}'


def wrong_dimension(unit: str, given: str | None, dimension: str, place: str | None, meant: str = "") -> str:
    """`given` is the dimension that `unit` has, None if it has no name; `meant` is the unit with weights for masses."""
    what = f"is {DIMENSIONS[given].noun}" if given else f'has the unit "{unit}"'
    wanted = needs(dimension, place)
    if dimension == "angular_rate" and unit.replace(" ", "") == "1/min":
        return f'{what}, but {wanted.removesuffix(DIMENSIONS[dimension].way_out)}Did you mean "rpm"?'
    if meant:
        wanted = wanted.removesuffix(DIMENSIONS[dimension].way_out)
        return f'{what}, but {wanted}Did you mean "{meant}", with the weight of a kilogram (9.80665 N)?'
    return f"{what}, but {wanted}"


def with_tolerance(text: str, dimension: str) -> str:
    """For a value with how far it may be off in one text, as a part or as a size; "" for any other."""
    found = re.fullmatch(_SCATTER, text)
    if found is None:
        return ""
    number, before, off, part, behind = found.groups()
    value, unit = float(number), before or ("" if part else behind) or DIMENSIONS[dimension].usual
    if not isfinite(value) or not value:
        return ""
    share = abs(float(off)) * (0.01 if part else 1.0 / abs(value))
    shown = words(number, unit)
    if dimension == "angular_rate":
        low, high = (f"{value * (1.0 + side * share):.6g}" for side in (-1.0, 1.0))
        return f'is a value and a tolerance at once. Write "{shown}" alone, or "{low}..{words(high, unit)}" for each.'
    told = f'{{ value = "{shown}", tolerance = "{100.0 * share:.4g} %" }}'
    return f'is a value and a tolerance at once. Write "{shown}" alone, or {told} where a number may be off.'


def no_single_number(text: str, dimension: str) -> str:
    """For a text that does not start with exactly one number."""
    way_out = DIMENSIONS[dimension].way_out
    if not text:
        return f"is empty. {way_out}"
    if ".." in text:
        return f"is a range, but one value is needed here. {way_out}"
    if comma := re.fullmatch(_COMMA, text):
        return _comma(*comma.groups())
    if gap := re.fullmatch(_GAP, text):
        number = re.sub(r"[\s_',]", "", gap[1])
        return f'has a separator inside its number. Write "{number}{gap[2]}".'
    if dash := re.fullmatch(_DASH, text):
        return f'looks like a range. Write it with two points: "{dash[1]}..{dash[2]}{dash[3]}".'
    return f"does not start with one number. {way_out}"


def _comma(sign: str, whole: str, decimals: str, rest: str) -> str:
    point = f"{sign}{whole}.{decimals}{rest}"
    if len(decimals) == 3 and len(whole) <= 3 and int(whole):
        return f'has a comma that can be read in two ways. Write "{sign}{whole}{decimals}{rest}" or "{point}".'
    return f'has a decimal comma; write a point for the decimals: "{point}".'
