"""Every number of a balancing file by its path: readings, weights, caps, bounds, speeds, masses, places.

A text that holds several numbers has a path for each: "5.9 mil @ 123 deg" at `runs.2.readings.a` is
`runs.2.readings.a.amplitude` and `runs.2.readings.a.angle`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

from vibopt.balancing.conventions import AMPLITUDES
from vibopt.errors import QuantityError
from vibopt.units import Detector, is_range, read_quantity, read_range
from vibopt.units.complaints import NUMBER
from vibopt.units.parsing import TO_PEAK
from vibopt.values.fact_at import FactAt, fact_among

_WORDS = (
    "title", "statement", "source", "name", "readings", "sensor", "plane", "of", "throw", "firing_order", "response",
    "unit", "orders", "order", "strokes", "minimise", "then", "soft",
)  # fmt: skip
"""Keys whose values are words, or whole numbers that say what is meant and not how large it is."""
_NAMED = tuple((one,) for one in ("weights", "readings", "bearings", "planes", "residual"))
"""Tables whose keys are names of the user's."""
_ASIDE = ("conventions", "scenarios", "expected")
_COUNTS = ("holes", "most_weights", "stock")
_ORDINARY = (
    "mass", "unbalance", "length", "angular_rate", "angle", "couple_unbalance", "force", "moment", "ratio", "velocity",
    "density",
)  # fmt: skip
"""Dimensions in the order in which a unit is tried: lb is a mass here and no force."""
_LIMITED = {
    "residual": AMPLITUDES,
    "correction": ("mass", "unbalance"),
    "static_unbalance": ("unbalance",),
    "couple_unbalance": ("couple_unbalance",),
    "bearing_reaction": ("force",),
}
_SCATTERED = ("ratio", *AMPLITUDES)
_SHAKING = ("force", "moment")
_TEXT = re.compile(
    rf"\s*(?P<number>{NUMBER})\s*(?P<unit>[^@]*?)(?P<between>\s+at\s+|\s+in\s+hole\s+|\s*@\s*|\s*$)(?P<rest>.*)",
    re.DOTALL | re.IGNORECASE,
)


def facts_of(document: Mapping[str, Any]) -> Iterator[FactAt]:
    """Every number of a balancing file that may be varied."""
    return _walked((), document, {}, _detector(document))


def fact_in(document: Mapping[str, Any], path: str) -> FactAt:
    """The number at a path; InputError where there is none, with near ones."""
    here: Any = document
    above: Any = {}
    steps = tuple(path.split("."))
    for count, step in enumerate(steps):
        if not isinstance(here, Mapping | list):
            return fact_among(_leaf(steps[:count], here, above, _detector(document)) or facts_of(document), path)
        above, here = (here if isinstance(here, Mapping) else above), _below(here, step)
    is_leaf = here is not None and not isinstance(here, Mapping | list)
    found = tuple(_walked(steps, here, above, _detector(document))) if is_leaf else ()
    return fact_among(found or facts_of(document), path)


def part_in(document: Mapping[str, Any], path: str) -> FactAt | None:
    """The number at a path that is a part of a text; None where there is none."""
    here: Any = document
    above: Any = {}
    steps = tuple(path.split("."))
    found: Iterator[FactAt] = iter(())
    for count, step in enumerate(steps):
        if here is None:  # a name that has a dot
            found = facts_of(document)
            break
        if not isinstance(here, Mapping | list):
            found = _walked(steps[:count], here, above, _detector(document)) if steps[0] not in _ASIDE else found
            break
        above, here = (here if isinstance(here, Mapping) else above), _below(here, step)
    return next((fact for fact in found if fact.place and fact.path == path), None)


def _below(here: Any, step: str) -> Any:
    """What stands one step further; None where nothing does."""
    if isinstance(here, Mapping):
        return here.get(step)
    index = int(step) - 1 if step.isdigit() else -1
    return here[index] if 0 <= index < len(here) else None


def _detector(document: Mapping[str, Any]) -> Detector | None:
    said = document.get("conventions")
    word = said.get("detector") if isinstance(said, Mapping) else None
    return next((known for known in TO_PEAK if known is not None and known == word), None)


def _walked(path: tuple[str, ...], value: Any, above: Any, detector: Detector | None) -> Iterator[FactAt]:
    if isinstance(value, Mapping):
        for key, one in value.items():
            if path or key not in _ASIDE:
                yield from _walked((*path, str(key)), one, value, detector)
    elif isinstance(value, list):
        for index, one in enumerate(value) if path[-1] not in _WORDS else ():
            yield from _walked((*path, str(index + 1)), one, above, detector)
    elif path[-1] not in _WORDS or path[-2:-1] in _NAMED:
        yield from _leaf(path, value, above, detector)


def _leaf(path: tuple[str, ...], value: Any, above: Any, detector: Detector | None) -> tuple[FactAt, ...]:
    """The numbers of one value: none of a word, two of an amount at an angle."""
    said = ".".join(path)
    if isinstance(value, int | float) and not isinstance(value, bool):
        return (FactAt(said, float(value), "", "count" if path[-1] in _COUNTS else "ratio", signed=True),)
    if not isinstance(value, str):
        return ()
    if is_range(value):
        return _ends(said, value)
    match = _TEXT.fullmatch(value)
    if match is None:
        return ()
    parts = [_amount(said, match, _dimensions(path, above), detector)]
    if match["rest"]:
        parts += _rest(said, value, match)
    return tuple(part for part in parts if part is not None)


def _dimensions(path: tuple[str, ...], above: Any) -> tuple[str, ...]:
    """What a number may be where it stands."""
    if "readings" in path or path[-1] in ("runout", "huber_at"):
        return AMPLITUDES
    if path[0] == "scatter" and path[-1] == "amplitude":
        return _SCATTERED
    response = above.get("response") if isinstance(above, Mapping) and path[-1] == "at_most" else None
    if response is None:
        return _ORDINARY
    return _LIMITED.get(str(response), _SHAKING)


def _amount(path: str, found: re.Match[str], dimensions: tuple[str, ...], detector: Detector | None) -> FactAt | None:
    """The number in front: alone under the path itself, before an angle under the name of what it is."""
    number, unit, several = found["number"], found["unit"].strip(), bool(found["rest"])
    behind = found.string[found.end("unit") :] if several else ""
    place = path if several else ""
    for dimension in dimensions if unit else ():
        swings = dimension in AMPLITUDES and dimensions is not _ORDINARY
        try:
            said = read_quantity(f"{number} {unit}", dimension, amplitude=swings)
        except QuantityError:
            continue
        own = said.detector or (detector if swings else None)
        value = said.value * (TO_PEAK[own] if said.detector is None else 1.0)
        written = said.unit if said.detector or own is None else f"{said.unit} {own}"
        name = "amplitude" if swings else dimension
        return FactAt(
            f"{path}.{name}" if several else path, value, written, dimension, swings, place=place,
            around=f"{{}}{_safe(behind)}", detector=own,
        )  # fmt: skip
    if not several:
        return None
    name = "amplitude" if dimensions is AMPLITUDES else "amount"
    return FactAt(f"{path}.{name}", float(number), "", "ratio", place=path, around=f"{{}} {unit}{_safe(behind)}")


def _rest(path: str, text: str, found: re.Match[str]) -> list[FactAt | None]:
    """A radius behind "at", an angle behind "@"."""
    radius, sign, angle = found["rest"].partition("@") if "at" in found["between"].lower() else ("", "@", found["rest"])
    if "hole" in found["between"].lower():
        return []
    parts = []
    for name, said, dimension in (("radius", radius, "length"), ("angle", angle, "angle")):
        if said.strip() and (sign or name == "radius"):
            start = text.rindex(said.strip())
            front, back = text[:start], text[start + len(said.strip()) :]
            try:
                quantity = read_quantity(said.strip(), dimension)
            except QuantityError:
                continue
            around = f"{_safe(front)}{{}}{_safe(back)}"
            parts.append(
                FactAt(
                    f"{path}.{name}", quantity.value, quantity.unit, dimension, signed=True, place=path, around=around
                )
            )
    return list(parts)


def _ends(path: str, text: str) -> tuple[FactAt, ...]:
    """Both ends of a sector."""
    try:
        low, high = read_range(text, "angle")
    except QuantityError:
        return ()
    ends = [part.strip() for part in text.split("..")]
    return (
        FactAt(f"{path}.from", low.value, low.unit, "angle", signed=True, place=path, around=f"{{}}..{ends[1]}"),
        FactAt(f"{path}.to", high.value, high.unit, "angle", signed=True, place=path, around=f"{ends[0]}..{{}}"),
    )


def _safe(text: str) -> str:
    """Braces that stand for themselves."""
    return text.replace("{", "{{").replace("}", "}}")
