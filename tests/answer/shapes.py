"""A small judge of JSON against a JSON schema: the words that the schemas use, and no others."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, Literal

TYPES: dict[str, Any] = {
    "object": dict,
    "array": list,
    "string": str,
    "number": (int, float),
    "integer": int,
    "boolean": bool,
    "null": type(None),
}
WORDS = {
    "type", "enum", "const", "anyOf", "oneOf", "$ref", "properties", "required", "additionalProperties", "items",
    "$defs", "$schema", "title", "description", "default", "not", "minItems", "maxItems", "minProperties",
    "exclusiveMinimum", "exclusiveMaximum",
}  # fmt: skip

SIZES: dict[str, Callable[[Any, Any], bool]] = {
    "minItems": lambda data, least: len(data) < least,
    "maxItems": lambda data, most: len(data) > most,
    "minProperties": lambda data, least: len(data) < least,
    "exclusiveMinimum": lambda data, least: data <= least,
    "exclusiveMaximum": lambda data, most: data >= most,
}
KIND_OF_SIZE: dict[str, Any] = {
    **dict.fromkeys(("minItems", "maxItems"), list), "minProperties": dict,
    **dict.fromkeys(("exclusiveMinimum", "exclusiveMaximum"), (int, float)),
}  # fmt: skip


def faults(data: Any, schema: dict[str, Any] | Literal[True], root: dict[str, Any], at: str = "") -> Iterator[str]:
    """What is wrong with the data, each with its path."""
    if schema is True:
        return
    assert set(schema) <= WORDS, set(schema) - WORDS
    if "$ref" in schema:
        yield from faults(data, root["$defs"][schema["$ref"].rpartition("/")[2]], root, at)
    if "const" in schema and data != schema["const"]:
        yield f"{at}: {data!r} is not {schema['const']!r}"
    if "enum" in schema and data not in schema["enum"]:
        yield f"{at}: {data!r} is none of {schema['enum']}"
    if "type" in schema and not _is(data, schema["type"]):
        yield f"{at}: {data!r} is no {schema['type']}"
        return
    if "not" in schema and not list(faults(data, schema["not"], root, at)):
        yield f"{at}: may not be there"
    for word, beyond in SIZES.items():
        if word in schema and isinstance(data, KIND_OF_SIZE[word]) and beyond(data, schema[word]):
            yield f"{at}: {data!r} is beyond {word} {schema[word]}"
    for word, most in (("anyOf", None), ("oneOf", 1)):
        if word in schema:
            found = [list(faults(data, one, root, at)) for one in schema[word]]
            fitting = sum(not one for one in found)
            if not fitting or (most is not None and fitting > most):
                yield from min(found, key=len) or [f"{at}: fits {fitting} shapes"]
    if isinstance(data, dict):
        yield from _table(data, schema, root, at)
    if isinstance(data, list) and "items" in schema:
        for k, one in enumerate(data):
            yield from faults(one, schema["items"], root, f"{at}[{k}]")


def _is(data: Any, types: str | list[str]) -> bool:
    asked = [types] if isinstance(types, str) else types
    return any(isinstance(data, TYPES[one]) and (one == "boolean" or not isinstance(data, bool)) for one in asked)


def _table(data: dict[str, Any], schema: dict[str, Any], root: dict[str, Any], at: str) -> Iterator[str]:
    keys = schema.get("properties", {})
    yield from (f"{at}.{key}: is missing" for key in schema.get("required", []) if key not in data)
    for key, one in data.items():
        other = schema.get("additionalProperties", {})
        if key not in keys and other is False:
            yield f"{at}.{key}: nobody knows it"
        else:
            yield from faults(one, keys.get(key, other), root, f"{at}.{key}")
