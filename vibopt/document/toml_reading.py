"""A problem file as text and as a document, before anybody knows what it speaks of."""

from __future__ import annotations

import copy
import re
from codecs import BOM_UTF8, BOM_UTF16_BE, BOM_UTF16_LE
from collections.abc import Iterator, Mapping
from itertools import chain
from pathlib import Path as FilePath
from typing import Any

import tomli

from vibopt.document.locate import DEEPEST, located, may_be_too_deep
from vibopt.document.mistakes import toml_text
from vibopt.errors import InputError, shortened, way_out
from vibopt.files.reading import FileFault, Kind, content_of, shown_name

PROBLEM = Kind("a problem file", 2_000_000, "Name an existing problem file (.toml).", "Name a problem file (.toml).")
COEFFICIENTS = Kind(
    "a file of coefficients", 2_000_000,
    "Name the file that solve --save-coefficients has written, relative to the problem file.",
    "Name a file that solve --save-coefficients has written (.toml).",
)  # fmt: skip
FILES = ("mass", "stiffness", "damping", "gyroscopic", "file", "table")
"""Keys of a structure, of a bearing and of the matrices of a shaft that name a file."""
_FEW_RUNS = 8
"""Runs of a measured rotor up to which it does not pay to read together those that are written alike."""
_MOST_BITS = 1000
"""Of a whole number; a float holds 1024."""
_PLAIN = (str, list, int, float)
"""What is no table, told before it is looked at as one."""
_LETTERS = ("x", "y", "z")
"""Entries of a list of three, along the axes."""
_PLACE = r" \(at (?:line (\d+), column \d+|end of document)\)$"
_TABLE = (
    r"(?m)^\s*\[\[?(?:bodies|bases|structures|absorbers|links|points|mounts|excitations|limits|measures|goal|planes|sensors|"
    r"runs|influence|conventions|quality|masses|shaft|bearings|cylinders|engine|rotor)\b"
)
"""A heading that tells a problem file from any other text."""
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


def texts_of(given: Any) -> Iterator[str]:
    """Every text of a document, names of files among them."""
    if isinstance(given, str):
        yield given
    elif isinstance(given, (Mapping, list, tuple)):
        for one in given.values() if isinstance(given, Mapping) else given:
            yield from texts_of(one)


def placed(document: Mapping[str, Any], folder: FilePath) -> dict[str, Any]:
    """The document with the names of matrix files, catalogues, readings and data seen from the folder of its file."""
    new = dict(document)
    for key in ("readings", "influence"):
        if isinstance(new.get(key), str):
            new[key] = FileText(new[key], folder)
    for family in new.keys() & _SEEN.keys():
        if isinstance(new[family], (dict, Mapping)):
            new[family] = {name: _SEEN[family](table, folder) for name, table in new[family].items()}
    level = [new]
    while level:
        if [table for table in level if "tolerance" in table]:
            return _with_data(new, folder)
        level = [one for table in level for one in table.values() if isinstance(one, dict)]
    return new


def _with_data(table: Mapping[str, Any], folder: FilePath) -> dict[str, Any]:
    """A table in which tolerances name their data as seen from the folder."""
    new = {
        key: one if isinstance(one, _PLAIN) or not isinstance(one, Mapping) else _with_data(one, folder)
        for key, one in table.items()
    }
    scatter = new.get("tolerance")
    if isinstance(scatter, dict) and isinstance(scatter.get("data"), str):
        new["tolerance"] = {**scatter, "data": FileText(scatter["data"], folder)}
    return new


def _with_part(table: Any, folder: FilePath) -> Any:
    """A table whose part names its catalogue as seen from the folder."""
    part = table.get("part") if isinstance(table, (dict, Mapping)) else None
    file = part.get("catalogue") if isinstance(part, (dict, Mapping)) else None
    if part is None or not isinstance(file, str):
        return table
    return {**table, "part": {**part, "catalogue": FileText(file, folder)}}


def _with_matrices(table: Any, folder: FilePath) -> Any:
    """A rotor whose shaft names its matrices as seen from the folder."""
    matrices = table.get("matrices") if isinstance(table, (dict, Mapping)) else None
    return table if matrices is None else {**table, "matrices": _placed(matrices, folder)}


def _placed(table: Any, folder: FilePath) -> Any:
    if not isinstance(table, (dict, Mapping)):
        return table
    return {
        key: FileText(value, folder) if key in FILES and isinstance(value, str) else value
        for key, value in table.items()
    }


_SEEN = {
    **dict.fromkeys(("structures", "excitations", "bearings"), _placed), "rotors": _with_matrices,
    **dict.fromkeys(("links", "mounts"), _with_part),
}  # fmt: skip
"""How a table of a family names its files as seen from the folder."""


def text_of(file: FilePath, kind: Kind = PROBLEM) -> str:
    """The text of a file in TOML; InputError where it cannot be read."""
    try:
        content = content_of(file, kind).removeprefix(BOM_UTF8)
        return content.decode()
    except FileFault as fault:
        name = file if fault.missing or fault.folder else file.name
        raise InputError(f"{shown_name(name)} {fault.text}") from None
    except UnicodeDecodeError as error:
        if content.startswith((BOM_UTF16_LE, BOM_UTF16_BE)):
            said = " is a text in UTF-16. Save it as UTF-8."
        elif b"\0" in content:
            said = f" is not a text in UTF-8. A{kind.noun[1:]} is a TOML text file."
        else:
            line = content[: error.start].count(b"\n") + 1
            said = f" line {line}: holds a sign that is not written in UTF-8. Save the file as UTF-8."
        raise InputError(f"{shown_name(file.name)}{said}") from None


def parsed(text: str, name: str, kind: Kind = PROBLEM) -> dict[str, Any]:
    """The document of a TOML text; `name` stands in front of each message."""
    try:
        document = toml_of(text)
    except tomli.TOMLDecodeError as error:
        raise InputError(_broken(text, name, str(error))) from None
    except ValueError:
        raise InputError(f"{name}: holds a whole number with more digits than any machine has. Write fewer.") from None
    except RecursionError:
        raise InputError(f"{name}: is nested too deeply for {kind.noun}.") from None
    if not document and kind is not PROBLEM:
        raise InputError(f"{name} is empty. {kind.way}")
    if not document:
        raise InputError(f'{name} is empty. A problem file needs at least a [bodies.NAME] with mass = "300 kg".')
    return document


def toml_of(text: str) -> dict[str, Any]:
    """A TOML text as a document.

    Raises
    ------
    RecursionError
        Keys or brackets go deeper than in any job; said before any work.
    ValueError
        It is no TOML, or a number in it has more digits than a float can have.
    """
    if text.count("\n[[runs]]") <= _FEW_RUNS:
        return _guarded(text)
    from vibopt.document.toml_alike import read_alike

    return read_alike(text, _guarded)


def _guarded(text: str) -> dict[str, Any]:
    """The same of any text, whatever it is like."""
    if may_be_too_deep(text) and located(text).too_deep:
        raise RecursionError
    document = tomli.loads(text)
    level: list[Any] = [document]
    depth = 0
    while level:
        kinds = set(map(type, level))
        if int in kinds and any(type(one) is int and one.bit_length() > _MOST_BITS for one in level):
            raise ValueError
        holding = [one for one in level if type(one) in (dict, list)] if kinds & {dict, list} else ()
        level = list(chain.from_iterable(one.values() if type(one) is dict else one for one in holding))
        depth += 1
    if depth > DEEPEST and located(text).too_deep:
        raise RecursionError
    return document


def _broken(text: str, name: str, complaint: str) -> str:
    """What is wrong with a text that is no TOML, at its line; of a text that is no problem file nothing is shown."""
    if "\r" in text and "\n" not in text:
        return f"{name}: its lines end with a bare carriage return, as TOML knows none. Save it with line feeds."
    lines = text.splitlines()
    place = re.search(_PLACE, complaint)
    number = int(place[1]) if place and place[1] else len(lines)
    what = re.sub(_PLACE, "", complaint)
    if what.startswith(_TWICE):
        named = re.search(r"key '(.*)'$", what)  # of an inline table
        key = named[1] if named else _key_of(lines[number - 1])
        key = shortened(key, 60) if re.search(_TABLE, text) else "a key"
        return f"{name} line {number}: {key} is given a second time. Keep one, or take another name."
    return f"{name} line {number}: is no valid TOML: {what}.{_HINTS.get(what, '') or _quoted(lines[number - 1])}"


def _quoted(line: str) -> str:
    """The way out of a heading with a name that TOML knows in quotation marks alone; "" of any other line."""
    heading = re.match(r"\s*(\[\[?)([^\[\]\"']+)(\]\]?)", line)
    steps = [step.strip() for step in heading[2].split(".")] if heading else []
    if not heading or all(re.fullmatch(r"[A-Za-z0-9_-]+", step) for step in steps):
        return ""
    right = ".".join(step if re.fullmatch(r"[A-Za-z0-9_-]+", step) else f'"{step}"' for step in steps)
    return (
        " A name with other signs than letters without accents, digits, - and _ stands in quotation marks: "
        f"{heading[1]}{right}{heading[3]}."
    )


def _key_of(line: str) -> str:
    """What a line of TOML names: a table in its brackets, or the key before the sign of equality."""
    bare = line.strip()
    return bare[: bare.rfind("]") + 1] if bare.startswith("[") and "]" in bare else bare.split("=")[0].strip()


def changed(document: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """The document with some values replaced, by path: {"limits.start_up.at_most": "8 mm"}; the given one stays.

    In a list the step is the number of the entry, from 1: "runs.2.speed".  A number keeps its tolerance, a part of it,
    unless the value is a table that says otherwise; a number alone gets one by ".tolerance" behind its path.
    """
    new = dict(document)
    for path, value in changes.items():
        _replace(new, path, value)
    return new


def inside(document: Any, path: str) -> Any:
    """What stands at a path; None where nothing does."""
    here = document
    for step in path.split("."):
        if isinstance(here, list):
            index = (
                _LETTERS.index(step) if step in _LETTERS and len(here) == 3 else int(step) - 1 if step.isdigit() else -1
            )
            here = here[index] if 0 <= index < len(here) else None
        else:
            here = here.get(step) if isinstance(here, Mapping) else None
    return here


def as_wide(old: Any, value: Any) -> Any:
    """A value in the place of an old one, with its tolerance where that has one and the value is no table."""
    keeps = isinstance(old, Mapping) and "tolerance" in old and isinstance(value, (str, int, float))
    return {"value": value, "tolerance": old["tolerance"]} if keeps else value


def _replace(document: dict[str, Any], path: str, value: Any) -> None:
    steps = path.split(".")
    if steps[-1] == "tolerance" and isinstance(plain := inside(document, ".".join(steps[:-1])), (str, int, float)):
        steps, value = steps[:-1], {"value": plain, "tolerance": value}
    here: Any = document
    for step in steps[:-1]:
        key = _key(here, step, path)
        here[key] = copy.copy(here[key])
        here = here[key]
    if isinstance(here, list) and steps[-1] in _LETTERS and len(here) == 3:
        here[_LETTERS.index(steps[-1])] = value
    elif isinstance(here, list):
        here[_key(here, steps[-1], path)] = value
    elif isinstance(here, dict):
        here[steps[-1]] = as_wide(here.get(steps[-1]), value)
    else:
        above = ".".join(steps[:-1])
        raise InputError(f"--set {path}: {above} is one value, {toml_text(here)}. Write --set {above}=VALUE.")


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
    raise InputError(f'--set {path}: there is no "{step}" in this file.{way_out(step, known)}')
