"""What is asked of a drawn machine: responses at every place that they accept, with speeds, and as limits."""

from __future__ import annotations

import re
from typing import Any

from draw import Draw, aside
from machines import Drawn
from vibopt.document.toml_reading import placed
from vibopt.errors import InputError
from vibopt.responses import KINDS
from vibopt.scene.read import from_dict

Table = dict[str, Any]
_PLACES = ("of", "into", "through", "across")


def candidates(draw: Draw, made: Drawn, kind: str, many: int) -> list[Table]:
    """Questions of one kind that the machine can answer, of `many` that were drawn."""
    kept = [question(draw, made, kind) for _ in range(many)]
    while not all(right := sound(made, kept)):  # some mistakes are only seen once others are gone
        kept = [one for one, good in zip(kept, right, strict=True) if good]
    return kept


def question(draw: Draw, made: Drawn, kind: str) -> Table:
    """A response at some place, its words taken from what the kind says of itself."""
    words = KINDS[kind].model_fields
    table: Table = {"response": kind}
    places = [key for key in _PLACES if key in words]
    place = ""
    if places and (words[places[0]].is_required() or len(places) > 1 or draw.chance(0.5)):
        key = draw.pick(places)
        place = table[key] = draw.pick(_names(made, key))
    _ways(draw, made, words, place, table)
    bodies = [one for one in made.names("bodies") if one not in made.spatial]
    if "relative_to" in words:
        table["relative_to"] = draw.pick(bodies or ["ground"])
    if "bearing" in words:
        table["bearing"] = draw.pick(["left", "right"])
    if "released" in words:
        start = {"velocity": "0.3 m/s"} | draw.pick([{}, {"displacement": "-2 mm"}])
        table |= {"released": {draw.pick(bodies or ["ground"]): start}, "after": f"{draw.size(0.01, 2.0)} s"}
    if "mode" in words and ("of" not in table or words["of"].is_required()):
        table["mode"] = draw.pick([1, 1, 2])
    if "over" in words:
        table |= _speeds(draw, made)
    elif "combine" in words and aside(table).chance(0.3):
        table["combine"] = aside(table).pick(["sum", "rss"])
    return table


def _names(made: Drawn, key: str) -> list[str]:
    bodies = [*made.names("bodies"), *made.points]
    joints = [*made.names("links", "absorbers", "mounts", "inerters")]
    if key == "into":
        return ["ground", *made.names("bases"), *bodies]
    if key in ("through", "across"):
        return joints or ["ground"]
    singles = [f"{one}.1" for one in made.names("mounts")]
    return [*bodies, *made.names("points", "links", "absorbers", "mounts"), *singles]


def _ways(draw: Draw, made: Drawn, words: Any, place: str, table: Table) -> None:
    """A direction, or an axis, of what lies in space."""
    ends = {end for mount in made.document.get("mounts", {}).values() for end in mount["between"]}
    if place.partition(".")[0] not in made.spatial and place not in ends and not draw.chance(0.03):
        return
    keys = [key for key in ("direction", "axis") if key in words]
    if keys and (words[keys[0]].is_required() or draw.chance(0.85)):
        table[draw.pick(keys)] = draw.pick(["x", "y", "z", "z", [0.6, 0, 0.8]])


def _speeds(draw: Draw, made: Drawn) -> Table:
    """At which speeds a steady response is looked at, whose, and how several add up."""
    table: Table = {}
    shakers = made.names("excitations")
    steady = [one for one in shakers if made.document["excitations"][one]["kind"] != "white_noise"]
    asked = steady
    if steady and (len(shakers) > len(steady) or draw.chance(0.3)):
        asked = [draw.pick(steady)]
        table["due_to"] = asked
    kinds = {made.document["excitations"][one]["kind"] for one in asked}
    if len(asked) > 1 or kinds & {"harmonics", "moment_harmonics"}:
        table["combine"] = draw.pick(["sum", "rss", "peak"])
    unit = "km/h" if "road" in kinds else "Hz"
    one = made.frequency * (18.0 if unit == "km/h" else 1.0)
    key = draw.pick(["", "", "over", "over", "at"])
    ways = {"at": f"{draw.size(0.5, 3.0) * one:.3g} {unit}", "over": _range(draw, one, unit)}
    if key:
        table[key] = ways[key] if len(asked) == 1 or draw.chance(0.2) else {asked[0]: ways[key]} if asked else ways[key]
    return table


def _range(draw: Draw, one: float, unit: str) -> str:
    low, high = draw.size(0.3, 1.5) * one, draw.size(1.6, 5.0) * one
    return draw.pick(["start-up", f"{low:.3g}..{high:.3g} {unit}", f"0..{high:.3g} {unit}"])


def sound(made: Drawn, drawn: list[Table]) -> list[bool]:
    """Which questions the file may ask, by the mistakes that are named."""
    if not drawn:
        return []
    asked = {**closed(made.document), "measures": {f"q{index}": one for index, one in enumerate(drawn)}}
    found = mistakes(made, asked)
    if any(re.search(r"measures\.q\d+\b", one) is None for one in found):
        return [False] * len(drawn)
    wrong = " ".join(found)
    return [re.search(rf"measures\.q{index}\b", wrong) is None for index in range(len(drawn))]


def mistakes(made: Drawn, document: Table) -> tuple[str, ...]:
    """What a document has wrong; its files lie where `made` says."""
    try:
        from_dict(beside(made, document))
    except InputError as error:
        return error.messages
    return ()


def beside(made: Drawn, document: Table) -> Table:
    """The document with its files where they have been written."""
    return placed(document, made.folder)


def closed(value: Any) -> Any:
    """The same with each choice settled: the middle of a range, the first of a list."""
    if isinstance(value, list):
        return [closed(one) for one in value]
    if not isinstance(value, dict):
        return value
    if "one_of" in value:
        return value["one_of"][len(value["one_of"]) // 2]
    if "from" in value or "to" in value:
        return closed_range(value)
    if "catalogue" in value and "name" not in value:
        return {"catalogue": value["catalogue"], "name": value.get("only", ["M1"])[0]}
    return {key: closed(one) for key, one in value.items()}


def closed_range(value: Table) -> Any:
    """About the middle of a range, by magnitude."""
    ends = [value[key] for key in ("from", "to") if key in value]
    if value.get("whole"):
        return ends[0]
    if len(ends) < 2:
        return ends[0]
    if isinstance(ends[0], str):
        low, high = (one.split(" ", 1) for one in ends)
        if low[1] != high[1]:
            return ends[0]
        return f"{(float(low[0]) * float(high[0])) ** 0.5:.4g} {low[1]}"
    return float(f"{(ends[0] * ends[1]) ** 0.5:.4g}")
