"""Examples made from the keys of a table: as a file has them, and the same in Python."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

import tomli

from vibopt.manual.keys import keys_of
from vibopt.responses import Response
from vibopt.scene.language import Machine
from vibopt.units import DIMENSIONS
from vibopt.values import Table


def example_of(kind: type[Table], fixed: Mapping[str, str]) -> list[str]:
    """Lines of a table with what it must have: needed keys, and of several ways to say a thing the first."""
    lines = [f'{key} = "{value}"' for key, value in fixed.items()]
    for key in keys_of(kind):
        first = f"One of `{key.name}`" in key.says
        if key.name not in fixed and key.example and (key.needed or first):
            lines.append(key.example)
    return lines + ([_bound(kind)] if issubclass(kind, Response) and not kind.signed else [])


def python_of(name: str, kind: type[Response]) -> str:
    """A limit in Python."""
    *place, bound = example_of(kind, {})
    side, value = bound.split(" = ", 1)
    sign = {"at_most": "<=", "at_least": ">="}[side]
    words = ", ".join(one.replace(" = ", "=", 1) for one in place)
    return f"machine.{name}({words}) {sign} {value}"


def python_table(method: str, lines: Iterable[str]) -> str:
    """A device or an excitation in Python, from its lines in a file."""
    words = tomli.loads("\n".join(lines))
    words.pop("kind", None)
    return "\n".join([f"machine.{method}", *(f"    {key}={_python(word)}," for key, word in words.items()), ")"])


def method_of(family: str) -> str:
    """The method of a machine that adds a device of a family, or an excitation of a kind, up to the name."""
    for method in (family, family.removesuffix("s"), re.sub("ies$", "y", family)):
        if hasattr(Machine, method):
            return f'{method}(\n    "NAME",'
    return f'device(\n    "{family}",\n    "NAME",'


def _python(value: object) -> str:
    """A value of a file as Python code."""
    if isinstance(value, dict):
        return f"{{{', '.join(f'{_python(key)}: {_python(one)}' for key, one in value.items())}}}"
    if isinstance(value, list):
        return f"[{', '.join(map(_python, value))}]"
    return f'"{value}"' if isinstance(value, str) else str(value)


def _bound(kind: type[Response]) -> str:
    example = DIMENSIONS[kind.dimension].example
    side = "at_least" if kind.less_is_worse else "at_most"
    return f"{side} = {example}" if kind.dimension == "count" else f'{side} = "{example}"'
