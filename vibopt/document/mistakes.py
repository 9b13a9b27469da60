"""Collects every mistake of a file, each with its line, and says them all at once."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import field
from functools import lru_cache
from typing import Any, TypeVar, get_args

from pydantic import BaseModel, ValidationError

from vibopt.document.locate import Locator
from vibopt.errors import InputError, way_out
from vibopt.records import dataclass

Path = tuple[str | int, ...]
T = TypeVar("T", bound=BaseModel)
_RUN_UP = (
    " Over start-up each speed counts as if it lasted; a run-up of a given rate is written run_up = "
    '{ acceleration = "50 rpm/s" } on an unbalance or a force. The acceleration of a base stands in '
    'kind = "base_motion".'
)
_CHANCE = (
    " Limits of machines, and on what is left in a measured rotor, have one. Of known masses and engines: vibopt sweep "
    "FILE --keep-design."
)
_WHY_NOT = {
    **dict.fromkeys(("acceleration", "angular_acceleration", "run_up_time", "ramp", "sweep_rate"), _RUN_UP),
    "with_probability": _CHANCE,
}
"""Keys that nobody needs, and why."""
_ELSEWHERE = {
    "bearings": ' Bearings stand in [shaft], of a measured rotor in [quality]: bearings = { A = "0 mm", B = "900 mm" }.'
}
"""Tables that are a key of another one."""
_PLACES = ("of", "on", "into", "through", "across")
"""Keys that say where something is asked: one stands where another is needed."""
MOST_SAID = 200
"""Most mistakes of one file that are said at once."""


NO_TABLE = "is not a table. Write [{}] and its keys below it."
"""Of what stands where a table is needed, by its path."""


@lru_cache(maxsize=4096)
def dotted(path: Path) -> str:
    """Path as in the messages: limits.start_up.at_most, harmonics[2]."""
    text = ""
    for step in path:
        text += f"[{step + 1}]" if isinstance(step, int) else f".{step}" if text else str(step)
    return text


def toml_text(given: object) -> str:
    """A value as it would stand in the file; long ones are cut, but for a path, whose end tells which file it is."""
    if isinstance(given, Mapping):
        text = "{ " + ", ".join(f"{key} = {toml_text(one)}" for key, one in given.items()) + " }"
    elif isinstance(given, list):
        text = "[" + ", ".join(toml_text(one) for one in given) + "]"
    elif isinstance(given, bool):
        text = str(given).lower()
    elif isinstance(given, str):
        import json

        text = json.dumps(given, ensure_ascii=False)
    else:
        text = str(given)
    whole = len(text) <= 80 or (isinstance(given, str) and "/" in given and not any(map(str.isspace, given)))
    return text if whole else text[:77] + "..."


@dataclass
class Mistakes:
    """Mistakes of one document, kept with their line so that they come in the order of the file.

    places
        By key of a place ("across") names of the document that may stand there, one of which is proposed.
    """

    name: str
    locator: Locator | None = None
    found: list[tuple[int, str]] = field(default_factory=list)
    places: Mapping[str, list[str]] = field(default_factory=dict)

    @property
    def full(self) -> bool:
        """Whether so many mistakes are known that more would help nobody."""
        return len(self.found) >= MOST_SAID

    def at(self, path: Path) -> str:
        """The beginning of a message: file and line."""
        line = self.locator.line_of(path) if self.locator is not None else None
        return f"{self.name} line {line}" if line is not None else self.name

    def add(self, path: Path, sentence: str) -> None:
        """A mistake at `path`; `sentence` follows the place and a colon."""
        line = (self.locator.line_of(path) or 0) if self.locator is not None else 0
        message = f"{self.at(path)}: {sentence}"
        if not self.full and (line, message) not in self.found:
            self.found.append((line, message))

    def value(self, path: Path, given: object, text: str) -> None:
        """A mistake in one value; `text` continues `path = given `."""
        self.add(path, f"{dotted(path)} = {toml_text(given)} {text}")

    def unknown_key(self, path: Path, known: list[str]) -> None:
        """A key that this table does not have."""
        if self.full:
            return
        where = f" in {dotted(path[:-1])}" if len(path) > 1 else " at the top level"
        inner = _ELSEWHERE.get(str(path[-1])) if len(path) == 1 else None
        way = inner or _WHY_NOT.get(str(path[-1])) or way_out(str(path[-1]), known)
        self.add(path, f'unknown key "{path[-1]}"{where}.{way}')

    def unknown_name(self, path: Path, given: str, what: str, known: list[str]) -> None:
        """A reference to something that the scene does not have."""
        self.value(path, given, f"names no {what} of this scene.{way_out(given, known)}")

    def raise_any(self) -> None:
        if self.found:
            said = [message for _, message in sorted(self.found, key=lambda one: one[0])]
            raise InputError(
                [*said, f"{self.name}: only the first {MOST_SAID} mistakes are said."] if self.full else said
            )


def validated(kind: type[T], path: Path, table: object, mistakes: Mistakes) -> T | None:
    """A table read by its kind; None where it has mistakes, which are then all noted.

    A value that ends the reading is left out and the rest is read again: its other values are looked at, too.
    """
    try:
        return kind.model_validate(table)
    except ValidationError as error:
        take(error, path, table, mistakes, kind)
        wrong = error
    while isinstance(table, Mapping) and (key := _ends_reading(wrong)) in table:
        table = {name: one for name, one in table.items() if name != key}
        try:
            kind.model_validate(table)
            break
        except ValidationError as error:
            take(error, path, table, mistakes, kind, within=True)
            wrong = error
    return None


def _ends_reading(error: ValidationError) -> str:
    """The key of a value for which the table was not read on; "" where it was."""
    found = [one["ctx"]["error"] for one in error.errors(include_url=False) if one["type"] == "value_error"]
    return next((one.key for one in found if hasattr(one, "key")), "")


def take(
    error: ValidationError,
    base: Path,
    table: object,
    mistakes: Mistakes,
    kind: type[BaseModel] | list[str],
    *,
    within: bool = False,
) -> None:
    """Translate the errors of pydantic into our sentences; `kind` is the table that was read, or its keys.

    With `within` only what is wrong with a value that is there, not what the table as a whole lacks.
    """
    found = error.errors(include_url=False)
    for one in found if within else _misplaced(found, base, table, mistakes):
        keyed = hasattr(one.get("ctx", {}).get("error"), "key")
        if within and not keyed and (not one["loc"] or one["type"] == "missing"):
            continue
        inner: Path = tuple(step for step in one["loc"] if not _is_tag(step))
        path = base + inner
        within_it = kind if isinstance(kind, list) else _table_of(kind, inner)
        _take_one(one, path, given_at(table, inner), mistakes, within_it)


def _misplaced(found: list[Any], base: Path, table: object, mistakes: Mistakes) -> list[Any]:
    """The errors without those of a place that stands under the key of another one: these are said as one."""
    wrong, lacking = (
        {one["loc"][:-1]: one for one in found if one["type"] == kind and one["loc"] and one["loc"][-1] in _PLACES}
        for kind in ("extra_forbidden", "missing")
    )
    both = [where for where in wrong if where in lacking]
    for where in both:
        inner = tuple(step for step in wrong[where]["loc"] if not _is_tag(step))
        path, needed, given = base + inner, lacking[where]["loc"][-1], toml_text(given_at(table, inner))
        text = f"{dotted(path[:-1])} has {path[-1]} = {given} where {needed} is needed. Write {needed} = {given}."
        mistakes.add(path, text)
    said = [one[where] for one in (wrong, lacking) for where in both]
    return [one for one in found if one not in said]


def _table_of(kind: type[BaseModel], inner: Path) -> type[BaseModel]:
    """The table, or the table in it, in which `inner` ends."""
    for step in inner[:-1]:
        field = kind.model_fields.get(str(step))
        tables = _tables(field.annotation if field else None)
        kind = tables[0] if tables else kind
    return kind


def _added(kind: type[BaseModel] | list[str], key: str, mistakes: Mistakes) -> str:
    """How to write a key that is not there, as the words of its table show it, with a name of the document."""
    for owner in kind.__mro__ if not isinstance(kind, list) else ():
        said = re.search(rf"^    {key}: (.*(?:\n {{8}}.*)*)", owner.__doc__ or "", re.M)
        shown = re.search(rf"`({key} = [^`]+)`", said[1]) if said else None
        if shown:
            example = re.search(r'"(\w+)"', shown[1])  # an example's body or link stands for one of the file
            names = mistakes.places.get(key) or (mistakes.places.get(example[1]) if example else None)
            text = f'{key} = "{names[0]}"' if names else " ".join(shown[1].split())
            return f"Add it: {text}."
    return 'Add the name of what is asked: of = "NAME".' if key == "of" else "Add it."


def _tables(annotation: Any) -> list[type[BaseModel]]:
    """Kinds of table that an annotation speaks of."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [table for part in get_args(annotation) for table in _tables(part)]


def _is_tag(step: Any) -> bool:
    return isinstance(step, str) and ("[" in step or step in ("Fact", "Choice"))


def _take_one(one: Any, path: Path, given: object, mistakes: Mistakes, table: type[BaseModel] | list[str]) -> None:
    kind, context = one["type"], one.get("ctx", {})
    if kind == "complaint":
        mistakes.value(path, given, str(context["text"]))
    elif kind == "sentence":
        mistakes.add((*path, *context.get("at", ())), f"{dotted(path)} {context['text']}")
    elif kind == "sentences":
        for text in str(context["text"]).split("\n"):
            mistakes.add(path, text)
    elif kind == "extra_forbidden":
        mistakes.unknown_key(path, table if isinstance(table, list) else list(table.model_fields))
    elif kind == "missing":
        mistakes.add(path, f"{dotted(path[:-1])} has no {path[-1]}. {_added(table, str(path[-1]), mistakes)}")
    elif kind == "value_error" and hasattr(context.get("error"), "kind"):
        take(context["error"].error, path, given, mistakes, context["error"].kind)
    elif kind == "value_error" and hasattr(context.get("error"), "key"):
        wrong = context["error"]
        mistakes.value((*path, wrong.key), wrong.given, wrong.text)
    elif kind == "string_type":
        several = isinstance(given, list) and all(isinstance(one, str) for one in given)
        way = "is a list. Write one text." if several else "is not a text. Write it in quotation marks."
        mistakes.value(path, given, way)
    elif kind in ("int_type", "int_parsing", "int_from_float"):
        mistakes.value(path, given, f"is not a whole number. Write one, for example {path[-1]} = 1.")
    elif kind in ("bool_type", "bool_parsing"):
        mistakes.value(path, given, "is neither true nor false. Write one of them, without quotation marks.")
    elif kind == "literal_error":
        words = str(context["expected"]).replace("'", '"')
        key = next(step for step in reversed(path) if isinstance(step, str))
        mistakes.value(path, given, f"is none of the values that {key} may have. Write {words}.")
    elif kind in ("tuple_type", "list_type"):
        mistakes.value(path, given, "is not a list. Write it in square brackets.")
    elif kind in ("model_type", "model_attributes_type", "dict_type"):
        mistakes.value(path, given, NO_TABLE.format(dotted(path)))
    else:
        mistakes.value(path, given, f"cannot be read: {one['msg']}.")


def given_at(table: object, path: Path) -> object:
    """What stands at `path` inside a document; None where nothing does."""
    here: Any = table
    for step in path:
        try:
            here = here[step]
        except (KeyError, IndexError, TypeError):
            return None
    return here


def text_in(document: Mapping[str, Any], key: str, default: str, mistakes: Mistakes) -> str:
    """A text at the top of a document, or what stands for it; a mistake where it is none."""
    given = document.get(key, default)
    if isinstance(given, str):
        return given
    mistakes.value((key,), given, "is not a text. Write it in quotation marks.")
    return default


def records_in(document: Mapping[str, Any], mistakes: Mistakes) -> tuple[Mapping[str, Any], ...]:
    """The records of a document, [[expected]]; a mistake where they are none."""
    given = document.get("expected", [])
    if isinstance(given, list) and all(isinstance(one, Mapping) for one in given):
        return tuple(given)
    mistakes.add(("expected",), "expected is not a list of tables. Write [[expected]] above each record.")
    return ()


def name_fault(name: str) -> str:
    """What is wrong with a name that somebody gave, and the way out; "" where nothing is."""
    if not name.strip():
        return 'is a blank name. Write one with letters, "press".'
    if "." in name:
        way = name.replace(".", "-")
        return f'has a point, which parts the steps of a path as bodies.press.mass. Write "{way}".'
    return "" if name.isprintable() else "has a sign that cannot be shown. Write a name of letters and digits."


def check_names(document: Mapping[str, Any], mistakes: Mistakes) -> None:
    """Mistakes of names by which no path could lead: of tables and of what runs read, the first of which has all."""

    def look(table: object, path: Path) -> None:
        if isinstance(table, Mapping):
            for key, inner in table.items():
                if path or key not in ("scenarios", "expected"):  # of which the keys are paths, or of no matter
                    if not key.isidentifier() and (wrong := name_fault(key)):
                        where = f"{dotted(path)}: " if path else ""
                        mistakes.add((*path, key), f'{where}"{key}" {wrong}')
                    if not isinstance(inner, (str, float, int)):
                        look(inner, (*path, key))
        elif isinstance(table, list) and table:
            look(table[0], (*path, 0))

    look(document, ())


def named_tables(document: Mapping[str, Any], family: str, mistakes: Mistakes) -> Mapping[str, Any]:
    """The tables of a family by name; a mistake where the family is none."""
    tables = document.get(family, {})
    if isinstance(tables, Mapping):
        return tables
    mistakes.value((family,), tables, f"is not a table. Write [{family}.NAME].")
    return {}
