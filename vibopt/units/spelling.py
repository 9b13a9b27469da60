"""The field's units and no others, from our own small definitions file, in all the ways in which they are written."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path
from typing import TypeAlias

from vibopt.records import dataclass
from vibopt.units.dimensions import Detector

DEFINITIONS = Path(__file__).with_name("definitions.txt")

Dimensionality: TypeAlias = frozenset[tuple[str, float]]

_PART = re.compile(r"([*/]?)(?:([\d.]+(?:e-?\d+)?)|([A-Za-z]+)|(\()|(\)))(?:\*\*(-?\d+))?")


@dataclass(frozen=True, slots=True)
class _Unit:
    """SI value of one unit, and the powers of its base dimensions."""

    factor: float
    powers: tuple[tuple[str, int], ...] = ()

    def times(self, other: _Unit, power: int) -> _Unit:
        """This unit times a power of another."""
        powers = dict(self.powers)
        for base, one in other.powers:
            powers[base] = powers.get(base, 0) + power * one
        return _Unit(self.factor * other.factor**power, tuple((base, one) for base, one in powers.items() if one))


@cache
def _units() -> dict[str, _Unit]:
    """Every unit of the file by name; each is defined by those above it: "kN = 1e3 * N = other name"."""
    found: dict[str, _Unit] = {}
    for line in DEFINITIONS.read_text(encoding="utf-8").splitlines():
        if line and line[0] != "#":
            name, meaning, *others = line.replace(" ", "").split("=")
            base = meaning.startswith("[")
            found[name] = _Unit(1.0, ((meaning, 1),)) if base else _product(meaning, found)
            found |= dict.fromkeys(others, found[name])
    return found


def _product(expression: str, known: dict[str, _Unit]) -> _Unit:
    """Numbers, units and products in brackets, multiplied and divided from left to right."""
    done = _Unit(1.0)
    outside: list[tuple[_Unit, int]] = []
    """What stands before each open bracket, and the way it goes on."""
    for sign, number, name, opens, closes, power in _PART.findall(expression):
        way = -1 if sign == "/" else 1
        if opens:
            outside.append((done, way))
            done = _Unit(1.0)
        elif closes:
            before, way = outside.pop()
            done = before.times(done, way * int(power or 1))
        else:
            done = done.times(known[name] if name else _Unit(float(number)), way * int(power or 1))
    return done


@cache
def symbols() -> frozenset[str]:
    """The units that the file defines."""
    return frozenset(_units())


@cache
def factor_and_dimensionality(expression: str) -> tuple[float, Dimensionality]:
    """SI value of one `expression` (pint's notation, as "kN*s/m") and the powers of its base dimensions."""
    unit = _product(expression, _units())
    return unit.factor, frozenset(unit.powers)


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
    r"([A-Za-z]+)(?:\s*(?:\*\*|\^)\s*(-?[1-9])|([234])(?!\d))?|([*/(-])|(\))(?:(?:\s*(?:\*\*|\^)\s*|(?=[234](?!\d)))([1-9]))?|(1)(?![\d.])|\s+"
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
    match = _DETECTOR.search(unit) if len(unit) <= LONGEST else None
    if not match:
        return unit.strip(), None, ""
    word = match[1] or match[2]
    return unit[: match.start()].strip(), _DETECTORS[word.lower()], word


@cache
def expression(unit: str) -> str | None:
    """A unit text in pint's notation, "kN·s/m" as "kN*s/m"; None if it is no product of known units, "" for no unit.

    A space, `*`, `·` and `-` multiply; `^2`, `**2`, `²` and a plain 2, 3 or 4 behind a symbol or a bracket are powers.
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
        match = _TOKEN.match(text, position)
        if not match:
            return None
        position = match.end()
        symbol, power, digit, sign, close, raised, one = match.groups()
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
