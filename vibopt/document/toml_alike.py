"""A TOML text with many runs that are written alike: one line of each shape is parsed, and of the others their texts.

A line is cut at its quotation marks.  What lies between its texts is its shape, which decides what it means; a shape is
parsed once, with numbers in the stead of its texts, which says where they belong.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

_HEADING = "\n[[runs]]\n"
_SIGNS = bytes({*range(256)} - {*range(32), 127} | {*b"\n\t"})
"""Bytes of the signs that a text may have."""
Parse = Callable[[str], dict[str, Any]]
Shapes = dict[tuple[str, ...], tuple[str, tuple[str, ...]] | None]
"""What the lines of a shape set: a key to their one text, or to a table of all their texts by these keys."""


def read_alike(text: str, parse: Parse) -> dict[str, Any]:
    """What `parse` makes of a TOML text; ValueError where it is none."""
    head, *runs = text.replace("\r\n", "\n").split(_HEADING)
    if runs:
        runs[-1], _, rest = runs[-1].partition("\n[")
        shapes: Shapes = {}
        try:
            document = parse(head + _HEADING)  # no text and no list goes on beyond this heading
            document = parse(f"{head}{_HEADING}[{rest}") if rest else document
            if document.get("runs") == [{}] and _is_plain("".join(runs)):
                document["runs"] = [_table(run, shapes, parse) or parse(run) for run in runs]
                return document
        except ValueError:
            pass  # read as a whole it says what is wrong, and where
    return parse(text)


def _is_plain(text: str) -> bool:
    """Whether every text in it is what stands there: without escapes, and without signs that no text may have."""
    return "\\" not in text and not text.encode().translate(None, _SIGNS)


def _table(run: str, shapes: Shapes, parse: Parse) -> dict[str, Any] | None:
    """The table of a run; None of one with other lines than those of known shapes."""
    table: dict[str, Any] = {}
    count = 0
    for line in run.split("\n"):
        if not line:
            continue
        parts = line.split('"')
        shape = tuple(parts[::2])
        if shape not in shapes:
            shapes[shape] = _meant(shape, parse)
        meant = shapes[shape]
        if meant is None or len(parts) == 2 * len(shape):
            return None
        key, inner = meant
        table[key] = dict(zip(inner, parts[1::2], strict=True)) if inner else parts[1]
        count += 1
    return table if len(table) == count else None


def _meant(shape: tuple[str, ...], parse: Parse) -> tuple[str, tuple[str, ...]] | None:
    """What a line sets whose texts all stand in quotation marks and are all the values there are; None of another."""
    numbers = [*map(str, range(len(shape) - 1))]
    if not numbers or any("'" in part for part in shape):
        return None
    ((key, value),) = parse("".join(map('{}"{}"'.format, shape, numbers)) + shape[-1]).items()
    if value == "0" and len(numbers) == 1:
        return key, ()
    return (key, tuple(value)) if type(value) is dict and [*value.values()] == numbers else None
