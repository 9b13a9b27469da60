"""How units are written: "kN·s/m", "N-s/m", "kg m", "m/s²", "m/s**2" become one notation, or nothing."""

import re
from functools import cache

from vibopt.units.quantity import Detector
from vibopt.units.registry import symbols

LONGEST = 100
"""Most letters of a unit."""
_SIGNS = str.maketrans(
    {
        "·": "*",
        "⋅": "*",
        "×": "*",
        "µ": "u",
        "μ": "u",
        "−": "-",
        "²": "^2",
        "³": "^3",
        "⁴": "^4",
        "°": "deg",
        "%": "percent",
        "€": "EUR",
        "£": "GBP",
        "$": "USD",
    }
)
_TOKEN = re.compile(
    r"([A-Za-z]+)(?:\s*(?:\*\*|\^)\s*(-?[1-9])|([234])(?!\d))?|([*/(-])|(\))(?:\s*(?:\*\*|\^)\s*([1-9]))?|(1)(?![\d.])|\s+"
)

_DETECTORS: dict[str, Detector] = {
    **dict.fromkeys(("pk", "peak", "0-p", "0-pk", "0-peak", "zero-to-peak"), "pk"),
    **dict.fromkeys(("pp", "p-p", "ptp", "p2p", "pk-pk", "peak-peak", "peak-to-peak"), "pp"),
    **dict.fromkeys(("rms", "eff"), "rms"),
}
_WORDS = "|".join(map(re.escape, _DETECTORS))
_DETECTOR = re.compile(rf"[\s_-]*(?:\(({_WORDS})\)|({_WORDS}))$", re.IGNORECASE)


@cache
def split_detector(unit: str) -> tuple[str, Detector | None, str]:
    """Parts of a unit text such as "mm pp": the unit, the detector meant, and its word as written ("" if none)."""
    found = _DETECTOR.search(unit) if len(unit) <= LONGEST else None
    if not found:
        return unit.strip(), None, ""
    word = found[1] or found[2]
    return unit[: found.start()].strip(), _DETECTORS[word.lower()], word


@cache
def expression(unit: str) -> str | None:
    """A unit text in pint's notation, "kN·s/m" as "kN*s/m"; None if it is no product of known units, "" for no unit.

    A space, `*`, `·` and `-` multiply; `^2`, `**2`, `²` and a plain 2, 3 or 4 behind a symbol are powers.
    """
    tokens = _tokens(_ascii(unit)) if len(unit) <= LONGEST else None
    if tokens is None:
        return None
    written, operand_next, depth = "", True, 0
    for token in tokens:
        if token in ("*", "/") or token[0] == ")":
            if operand_next:
                return None
        elif not operand_next:
            written += "*"
        depth += (token == "(") - (token[0] == ")")
        if depth < 0:
            return None
        written += token
        operand_next = token in ("*", "/", "(")
    return None if depth or (tokens and operand_next) else written


def _tokens(text: str) -> list[str] | None:
    """Symbols with their powers, signs, and a leading 1; None at anything else."""
    tokens: list[str] = []
    position = 0
    while position < len(text):
        found = _TOKEN.match(text, position)
        if not found:
            return None
        position = found.end()
        symbol, power, digit, sign, close, raised, one = found.groups()
        if (symbol and symbol not in symbols()) or (one and tokens):
            return None
        if symbol:
            tokens.append(f"{symbol}**{power or digit}" if power or digit else symbol)
        elif close:
            tokens.append(f"){'**' if raised else ''}{raised or ''}")
        elif sign or one:
            tokens.append("*" if sign == "-" else sign or one)
    return tokens


def _ascii(unit: str) -> str:
    """A unit text with its raised digits and special signs spelt out."""
    return unit.replace("⁻¹", "^-1").replace("⁻²", "^-2").translate(_SIGNS).strip()
