"""Keys of the tables of a problem file: words from docstrings, all else from the fields that read them."""

from __future__ import annotations

import ast
import inspect
import re
import sys
import types
from collections.abc import Iterator
from functools import cache
from typing import Any, Literal, Union, get_args, get_origin

from vibopt.records import dataclass
from vibopt.units import DIMENSIONS
from vibopt.values import Table
from vibopt.values.fields import CLOSED, ReadBy, Rule, rule_of
from vibopt.values.kinds import Later

_SECTION = re.compile(r"\n\s*Keys\n----\n", re.M)
_ENTRY = re.compile(r"^(\w+): (.*(?:\n {4}.*)*)", re.M)
_BOUNDS = ("at_most", "at_least")
_SAYS = ("word", "complaint")
"""Functions that make the sentence of a refusal."""


@dataclass(frozen=True, slots=True)
class Key:
    """A key of a table.

    says, example
        Its words, and how it may be written: `mass = "300 kg"`.
    value, default
        What may stand there, in words, and what it is where the key is left out.
    refused
        What the rule of its number refuses, in words.
    """

    name: str
    says: str
    value: str
    default: str
    example: str
    refused: str
    needed: bool


def told(kind: type) -> str:
    """The docstring of a table without its keys."""
    return _SECTION.split(inspect.getdoc(kind) or "")[0].strip() if kind.__doc__ else ""


@cache
def said_of(kind: type) -> dict[str, str]:
    """Words for each key, those of the table itself before those of its bases."""
    found: dict[str, str] = {}
    for owner in kind.__mro__:
        parts = _SECTION.split(inspect.cleandoc(owner.__doc__ or ""))
        for name, text in _ENTRY.findall(parts[1]) if len(parts) > 1 else ():
            found.setdefault(name, " ".join(text.split()))
    return found


@cache
def keys_of(kind: type[Table]) -> tuple[Key, ...]:
    """The keys that a file may write, those that must be there first."""
    made = [_key(kind, name) for name in kind.model_fields if name in said_of(kind) and not _is_closed(kind, name)]
    return tuple(sorted(made, key=lambda key: not key.needed))


def tables_in(kind: type[Table]) -> tuple[type[Table], ...]:
    """Tables that stand as the value of a key of it, and in them; those without words are never written as tables."""
    found: dict[type[Table], None] = {}
    for name, field in kind.model_fields.items():
        if name in said_of(kind):
            for inner in filter(said_of, _tables(field.annotation)):
                found.update(dict.fromkeys((inner, *tables_in(inner))))
    return tuple(found)


@cache
def refusals_of(kind: type[Table]) -> tuple[str, ...]:
    """Sentences with which the table itself refuses what makes no sense together; "…" stands for what was given."""
    sentences = []
    for node in ast.walk(_classes_of(kind.__module__)[kind.__name__]):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in _SAYS and node.args:
            said = text_of(node.args[0])
            if said:
                sentences.append(said)
    return tuple(dict.fromkeys(sentences))


@cache
def _classes_of(module: str) -> dict[str, ast.ClassDef]:
    source = inspect.getsource(sys.modules[module])
    return {node.name: node for node in ast.parse(source).body if isinstance(node, ast.ClassDef)}


def _key(kind: type[Table], name: str) -> Key:
    field = kind.model_fields[name]
    says = said_of(kind).get(name, "")
    needed = field.is_required() and f"One of `{name}`" not in says
    default = None if needed or field.default_factory is not None else field.default
    shown = _shown(default) if isinstance(default, (bool, int, float, str)) and default != "" else ""
    example = _example(kind, name)
    return Key(name, says, _what(kind, name), shown, example, _refused(rule_of(kind, name)), needed)


def _what(kind: type[Table], name: str) -> str:
    rule, annotation = rule_of(kind, name), kind.model_fields[name].annotation
    if rule is not None:
        read = DIMENSIONS[rule.dimension]
        units = f" ({', '.join(read.units[:4])})" if read.units else ""
        choice = ", or a choice" if rule.choice else ""
        return f"{read.noun}{units}{', pk, pp or rms' if rule.amplitude else ''}{choice}"
    listed = _literals(annotation)
    if listed:
        return f"one of {', '.join(_shown(one) for one in listed)}"
    if _plain(annotation) is bool:
        return "true or false"
    if name in _BOUNDS and isinstance(dimension := getattr(kind, "dimension", None), str):
        return f"{DIMENSIONS[dimension].noun}{', pk, pp or rms' if getattr(kind, 'amplitude', False) else ''}"
    return ""


def _refused(rule: Rule | None) -> str:
    if rule is None:
        return ""
    words = {"positive": ["zero or less"], "not negative": ["below zero"]}.get(rule.sign, [])
    if rule.most < float("inf"):
        words.append(f"above {rule.most:g}")
    if not rule.choice:
        words.append("a choice")
    if not rule.may_be_off:
        words.append("a tolerance")
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


def _example(kind: type[Table], name: str) -> str:
    """As its words show it, else as its rule or its type has it."""
    rule, annotation = rule_of(kind, name), kind.model_fields[name].annotation
    match = re.search(rf"`({name} = [^`]+)`", said_of(kind).get(name, ""))
    if match:
        return match[1]
    if rule is not None:
        shown = DIMENSIONS[rule.dimension].example
        return f"{name} = {shown}" if rule.dimension == "count" else f'{name} = "{shown}"'
    listed = _literals(annotation)
    if listed:
        return f"{name} = {_shown(listed[0])}"
    plain = _plain(annotation)
    if plain is bool:
        return f"{name} = true"
    if plain is int:
        return f"{name} = 2"
    dimension = getattr(kind, "dimension", None)
    return f'{name} = "{DIMENSIONS[dimension].example}"' if name in _BOUNDS and isinstance(dimension, str) else ""


def _shown(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return f'"{value}"' if isinstance(value, str) else str(value)


def _plain(annotation: object) -> object:
    """The one type of an annotation that is not None."""
    inner = [one for one in get_args(annotation) if one is not types.NoneType]
    return _plain(inner[0]) if get_origin(annotation) in (Union, types.UnionType) and len(inner) == 1 else annotation


def _literals(annotation: object) -> tuple[Any, ...]:
    plain = _plain(annotation)
    return get_args(plain) if get_origin(plain) is Literal else ()


def _tables(annotation: object) -> Iterator[type[Table]]:
    if isinstance(annotation, type) and issubclass(annotation, Table):
        yield annotation
    elif isinstance(annotation, Later):
        yield annotation.kind
    for one in get_args(annotation):
        yield from _tables(one)


def _is_closed(kind: type[Table], name: str) -> bool:
    """Whether the table has a key of its base that it refuses."""
    told = kind.model_fields[name].metadata
    return any(isinstance(read_by, ReadBy) and read_by.schema == CLOSED for read_by in told)


def text_of(node: ast.expr) -> str:
    """A text of the source, what is put into it left open; "" for what is no text."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    if isinstance(node, ast.JoinedStr):
        return "".join(text_of(value) if isinstance(value, ast.Constant) else "…" for value in node.values)
    return ""
