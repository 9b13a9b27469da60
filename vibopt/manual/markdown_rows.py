"""Tables and blocks of a page in Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from vibopt.manual.keys import Key


def key_table(keys: Iterable[Key]) -> str:
    """Keys with all that is known of each."""
    return rows_of(("key", "what it says"), [(f"`{key.name}`", _sentences(key)) for key in keys])


def _sentences(key: Key) -> str:
    """All that is known of a key, in a row."""
    needed = "Needed. " if key.needed else ""
    shown = f", for example `{key.example}`" if f"`{key.example}`" not in key.says and key.example and key.value else ""
    value = f" *{key.value[0].upper()}{key.value[1:]}{shown}.*" if key.value else ""
    default = f" Without it {key.default}." if key.default else ""
    refused = f" Refused: {key.refused}." if key.refused else ""
    return f"{needed}{key.says}{value}{default}{refused}"


def rows_of(heads: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> str:
    """A table in Markdown; "" without rows."""
    lines = [" | ".join(heads), " | ".join("---" for _ in heads)]
    lines += [" | ".join(cell.replace("|", "\\|").replace("\n", " ") for cell in row) for row in rows]
    return "\n".join(f"| {line} |" for line in lines) if rows else ""


def fenced(language: str, lines: list[str]) -> str:
    return "\n".join([f"```{language}", *lines, "```"])


def listed(names: list[str]) -> str:
    return ", ".join(f"`{name}`" for name in names)


def described(shapes: Mapping[str, Mapping[str, Any]]) -> str:
    """Keys that are read one by one, as their schema describes them."""
    rows = []
    for key, shape in shapes.items():
        choices = [f'"{one}"' for one in shape.get("enum", ())]
        texts = [one.get("description", "") for one in (shape, *shape.get("anyOf", ()))]
        says = "; ".join([*filter(None, texts), *([f"one of {', '.join(choices)}"] if choices else [])])
        rows += [(f"`{key}`", f"{says[:1].upper()}{says[1:]}.")] if says else []
    return rows_of(("key", "what it says"), rows)
