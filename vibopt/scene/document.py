"""A problem file as text and as a document, before anybody knows what it speaks of."""

from __future__ import annotations

import copy
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path as FilePath
from typing import Any

from vibopt.errors import InputError, way_out

LARGEST = 2_000_000
FILES = ("mass", "stiffness", "damping", "file")
"""Keys of a structure that name a file."""
_LETTERS = ("x", "y", "z")
"""Entries of a list of three, along the axes."""
_PLACE = re.compile(r" \(at (?:line (\d+), column \d+|end of document)\)$")
_TWICE = ("Cannot overwrite a value", "Cannot declare", "Duplicate inline table key")
_HINTS = {
    "Expected newline or end of document after a statement": ' A text stands in quotation marks: mass = "300 kg".',
    "Invalid value": ' A text stands in quotation marks: mass = "300 kg".',
    "Illegal character '\\n'": " Close the quotation mark.",
    "Unterminated string": " Close the quotation mark.",
}


class FileText(str):
    """The name of another file as a problem file gives it, with the folder that it is seen from."""

    __slots__ = ("folder",)

    def __new__(cls, text: str, folder: FilePath | None = None) -> FileText:
        made = super().__new__(cls, text)
        made.folder = folder or FilePath()
        return made

    folder: FilePath

    def __deepcopy__(self, memo: object) -> FileText:
        return self


def placed(document: Mapping[str, Any], folder: FilePath) -> dict[str, Any]:
    """The document with the names of matrix files and catalogues seen from the folder of the problem file."""
    new = dict(document)
    tables = new.get("structures")
    if isinstance(tables, Mapping):
        new["structures"] = {name: _placed(table, folder) for name, table in tables.items()}
    for family in ("links", "mounts"):
        tables = new.get(family)
        if isinstance(tables, Mapping):
            new[family] = {name: _with_part(table, folder) for name, table in tables.items()}
    return new


def _with_part(table: Any, folder: FilePath) -> Any:
    """A table whose part names its catalogue as seen from the folder."""
    part = table.get("part") if isinstance(table, Mapping) else None
    file = part.get("catalogue") if isinstance(part, Mapping) else None
    if part is None or not isinstance(file, str):
        return table
    return {**table, "part": {**part, "catalogue": FileText(file, folder)}}


def _placed(table: Any, folder: FilePath) -> Any:
    if not isinstance(table, Mapping):
        return table
    return {
        key: FileText(value, folder) if key in FILES and isinstance(value, str) else value
        for key, value in table.items()
    }


def text_of(file: FilePath) -> str:
    """The text of a problem file; InputError where it cannot be read."""
    try:
        if file.is_dir():
            raise InputError(f"{file} is a folder. Name a problem file (.toml).")
        size = file.stat().st_size
        if size > LARGEST:
            raise InputError(f"{file.name} has {size / 1e6:.1f} MB; a problem file has at most {LARGEST / 1e6:.0f} MB.")
        return file.read_bytes().decode("utf-8-sig")
    except FileNotFoundError:
        raise InputError(f"{file} is not there. Name an existing problem file (.toml).") from None
    except UnicodeDecodeError:
        raise InputError(f"{file.name} is not a text in UTF-8. A problem file is a TOML text file.") from None
    except OSError as error:
        raise InputError(f"{file} cannot be read: {error.strerror or error}.") from None


def parsed(text: str, name: str) -> dict[str, Any]:
    """The document of a TOML text; `name` stands in front of each message."""
    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(_broken(text, name, str(error))) from None
    except RecursionError:
        raise InputError(f"{name}: is nested too deeply for a problem file.") from None
    if not document:
        raise InputError(f'{name} is empty. A problem file needs at least a [bodies.NAME] with mass = "300 kg".')
    return document


def _broken(text: str, name: str, complaint: str) -> str:
    """What is wrong with a text that is no TOML, at its line."""
    lines = text.splitlines()
    place = _PLACE.search(complaint)
    number = int(place[1]) if place and place[1] else len(lines)
    what = _PLACE.sub("", complaint)
    if what.startswith(_TWICE):
        named = re.search(r"key '(.*)'$", what)  # of an inline table
        key = named[1] if named else lines[number - 1].split("=")[0].strip()
        return f"{name} line {number}: {key} is given a second time. Keep one, or take another name."
    return f"{name} line {number}: is no valid TOML: {what}.{_HINTS.get(what, '')}"


def changed(document: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """A copy of the document with some values replaced, by path: {"limits.start_up.at_most": "8 mm"}.

    In a list the step is the number of the entry, from 1: "runs.2.speed".
    """
    new = copy.deepcopy(dict(document))
    for path, value in changes.items():
        _replace(new, path, value)
    return new


def _replace(document: dict[str, Any], path: str, value: Any) -> None:
    steps = path.split(".")
    here: Any = document
    for step in steps[:-1]:
        here = here[_key(here, step, path)]
    if isinstance(here, list) and steps[-1] in _LETTERS and len(here) == 3:
        here[_LETTERS.index(steps[-1])] = value
    elif isinstance(here, list):
        here[_key(here, steps[-1], path)] = value
    elif isinstance(here, dict):
        here[steps[-1]] = value
    else:
        raise InputError(f"--set {path}: this is not a table of the scene.")


def _key(here: Any, step: str, path: str) -> Any:
    """Key or index of a step; InputError where there is none."""
    if isinstance(here, list):
        if step in _LETTERS and len(here) == 3:
            return _LETTERS.index(step)
        if step.isdigit() and 1 <= int(step) <= len(here):
            return int(step) - 1
        raise InputError(f"--set {path}: {step} is no entry of this list. Write a number from 1 to {len(here)}.")
    if isinstance(here, dict) and step in here:
        return step
    known = list(here) if isinstance(here, dict) else []
    raise InputError(f'--set {path}: there is no "{step}" in this scene.{way_out(step, known)}')
