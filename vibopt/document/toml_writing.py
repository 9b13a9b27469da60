"""A job back as a problem file, in TOML that reads as the same job."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from datetime import date, time
from numbers import Integral, Real
from pathlib import Path as FilePath
from typing import Any, Protocol

from vibopt.errors import InputError

_BARE = re.compile(r"[A-Za-z0-9_-]+")


class Documented(Protocol):
    """A scene or a balancing job."""

    @property
    def document(self) -> Mapping[str, Any]: ...


def write(job: Documented, path: str | FilePath) -> None:
    """Writes a job as a problem file, over one that is there; comments of the file it was read from are lost.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    from vibopt.files.writing import replace_file

    replace_file(FilePath(path), to_toml(job).encode())


def to_toml(job: Documented) -> str:
    """The text of a problem file for a job: every value as it was written, none converted."""
    return document_toml(job.document)


def document_toml(document: Mapping[str, object]) -> str:
    """The text of a problem file for a document."""
    above = {key: value for key, value in document.items() if not _is_below(value)}
    blocks = ["\n".join(_pairs(above))] if above else []
    for key, value in document.items():
        if _is_below(value):
            blocks += _blocks(key, value)
    return "\n\n".join(blocks) + "\n"


def _is_below(value: object) -> bool:
    """Whether a value at the top stands in a [table] of its own."""
    return isinstance(value, Mapping) or _is_records(value)


def _is_records(value: object) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(one, Mapping) for one in value)


def _blocks(key: str, value: object) -> Iterator[str]:
    """[[key]] for each record, [key.NAME] for each table of a family, else [key]."""
    if isinstance(value, Mapping) and value and all(isinstance(one, Mapping) for one in value.values()):
        for name, table in value.items():
            yield "\n".join([f"[{_key(key)}.{_key(name)}]", *_pairs(table)])
    elif isinstance(value, Mapping):
        yield "\n".join([f"[{_key(key)}]", *_pairs(value)])
    elif isinstance(value, list):
        for record in value:
            yield "\n".join([f"[[{_key(key)}]]", *_pairs(record)])


def _pairs(table: Mapping[str, object]) -> Iterator[str]:
    """Lines of keys with their values; what is None is not said."""
    for key, value in table.items():
        if value is not None:
            many = isinstance(value, str) and "\n" in value
            yield f"{_key(key)} = {_paragraphs(str(value)) if many else _value(value)}"


def _key(key: str) -> str:
    return key if _BARE.fullmatch(key) else _string(key)


def _value(value: object) -> str:
    if isinstance(value, str):
        return _string(value)
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, Integral):
        return str(int(value))
    if isinstance(value, Real):
        return repr(float(value))
    if isinstance(value, (date, time)):
        return value.isoformat()
    if isinstance(value, Mapping):
        inner = ", ".join(f"{_key(key)} = {_value(one)}" for key, one in value.items() if one is not None)
        return f"{{ {inner} }}" if inner else "{}"
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(_value(one) for one in value)}]"
    raise InputError(f"{value!r} cannot be written in a problem file. Write a text, a number, a list or a table.")


def _string(text: str) -> str:
    """A TOML string in one line."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _paragraphs(text: str) -> str:
    """A TOML string over several lines, each as it stands."""
    lines = [_string(line)[1:-1] for line in text.split("\n")]
    return '"""\n' + "\n".join(lines) + '"""'
