"""Pages made from the registries: every table, excitation, response and method, with all keys."""

from __future__ import annotations

import inspect
import re
import sys
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any

from vibopt.answer.answer import EXIT_CODES
from vibopt.devices import FAMILIES
from vibopt.excitations import KINDS as EXCITATIONS
from vibopt.excitations import Excitation
from vibopt.manual.keys import Key, keys_of, refusals_of, tables_in, told
from vibopt.manual.refusals import whole_file_refusals
from vibopt.manual.topic import Topic
from vibopt.responses import KINDS as RESPONSES
from vibopt.responses import HarmonicResponse, RandomResponse, Response
from vibopt.scene.language import Machine
from vibopt.solve.method import METHODS, OWN
from vibopt.units import DIMENSIONS
from vibopt.values import Table

FILE, SHAKES, ASKED, BALANCE = "Tables of a problem file", "Excitations", "Responses", "Files of balancing jobs"
IN_SPACE = {
    "direction": "Of a body in space, or a point on it, it is asked along a `direction`, which must be said.",
    "axis": "Of a body in space it is asked about an `axis`, which must be said.",
    "whole": "It may be asked of a body in space.",
    "place": "It may be asked of a body in space, or of a point on it.",
    "body": "It is asked of bodies in space.",
    "": "Bodies in space have no such response.",
}
_MODELS = {"base": Response, "harmonic": HarmonicResponse, "random": RandomResponse}
_ONES = {"bodies": "a body", "bases": "a base"}


def devices() -> Iterator[Topic]:
    """A page for each family of devices."""
    for name in FAMILIES:
        yield Topic(name, FILE, partial(_device, name))


def excitations() -> Iterator[Topic]:
    """A page for each kind of excitation."""
    for name in EXCITATIONS:
        yield Topic(name, SHAKES, partial(_excitation, name))


def _device(name: str) -> str:
    kind = FAMILIES[name]
    return "\n\n".join([f"# {name}", _said(kind), *_body(kind, f"[{name}.NAME]", method_of(name), {})])


def _excitation(name: str) -> str:
    kind = EXCITATIONS[name]
    facts = [f"It acts on {_ONES.get(str(kind.family), 'a body or a base')}."]
    if kind.inherent and kind.sort == "steady":
        facts.append("It is known at every speed: no `varies`.")
    if kind.sort == "random":
        facts.append("It has no `speed`: it shakes at every frequency at once.")
    if kind.sort == "transient":
        facts.append("It has no `speed`: it comes once, over a machine at rest, and is over.")
    words = [
        f"# {name}",
        _said(kind),
        " ".join(facts),
        *_body(kind, "[excitations.NAME]", method_of(name), {"kind": name}),
    ]
    return "\n\n".join(words)


def responses() -> Iterator[Topic]:
    """A page for each response."""
    for name in RESPONSES:
        yield Topic(name, ASKED, partial(_response, name))


def _response(name: str) -> str:
    kind = RESPONSES[name]
    own = [key for key in keys_of(kind) if key.name not in COMMON]
    common = sorted({one.name for one in keys_of(kind)} & COMMON - {"response"})
    example = example_of(kind, {"response": name})
    words = [f"# {name}", _said(kind), _facts(kind), _fenced("toml", [f"[{_family(kind)}.NAME]", *example])]
    words += [_table(own), "With the keys that many have ([limits](limits.md)): " + _listed(common) + "."]
    if not kind.signed:
        words.append(f"In Python: `{python_of(name, kind)}`")
    return "\n\n".join([*words, *_refusals([kind])])


def balancing() -> Iterator[Topic]:
    """A page for each kind of balancing file."""
    from vibopt.balancing.table_schemas import SCHEMAS

    for name in SCHEMAS:
        yield Topic(f"{name}_file", BALANCE, partial(_balancing_file, name))


def _balancing_file(name: str) -> str:
    from vibopt.balancing.table_schemas import SCHEMAS

    made = SCHEMAS[name]
    titles = {"rotor": "a measured rotor", "known": "known masses on a shaft", "engine": "an engine"}
    words = [
        f"# {name}_file: tables of {titles.get(name, name)}",
        f"The guide is [{_GUIDE[name]}]({_GUIDE[name]}.md).",
    ]
    shapes = made(lambda kind: {"kind": kind, "properties": {}}, lambda one: {"named": one})["properties"]
    words += ["## Above all tables", _described({key: one for key, one in shapes.items() if _is_text(one)})]
    for key, (heading, kinds) in balancing_tables(made).items():
        words += [f"## {heading}", "" if kinds else _described(shapes[key]["properties"])]
        for kind in kinds:
            words += [_said(kind), _table(keys_of(kind)), *_inner(kind), *_refusals([kind], "###")]
    return "\n\n".join(one for one in words if one)


_GUIDE = {"rotor": "balancing", "known": "known_masses", "engine": "engines"}


def balancing_tables(made: Callable[..., Any]) -> dict[str, tuple[str, list[type[Table]]]]:
    """Heading and tables of every key at the top of a balancing file that is a table."""
    shapes = made(lambda kind: {"kind": kind, "properties": {}}, lambda one: {"named": one})["properties"]
    found = {}
    for key, shape in shapes.items():
        kinds = list(_kinds_in(shape))
        if kinds or shape.get("type") == "object":
            name = f"[{key}.NAME]" if "named" in shape else f"[{key}]"
            found[key] = (f"[[{key}]]" if "array" in str(shape) and kinds else name, kinds)
    return found


def tables() -> Mapping[str, Callable[[], str]]:
    """Tables that guides put in, by the name in their text: `<!-- table: units -->`."""
    return {
        "refusals": whole_file_refusals,
        "python": lambda: _rows(("name", ""), [_public(name) for name in sorted(_PACKAGE._HOME_OF)]),
        "limits": lambda: _table([key for one in ("base", "harmonic") for key in keys_of(_MODELS[one])]),
        "excitations": lambda: _rows(
            ("kind", ""), [(f"[{name}]({name}.md)", _said(kind)) for name, kind in EXCITATIONS.items()]
        ),
        "responses": lambda: _rows(
            ("response", ""),
            [(f"[{name}]({name}.md)", _said(kind).split("\n\n")[0]) for name, kind in RESPONSES.items()],
        ),
        "devices": lambda: _rows(
            ("table", ""), [(f"[{name}]({name}.md)", _said(kind).split("\n\n")[0]) for name, kind in FAMILIES.items()]
        ),
        "methods": lambda: _rows(("method", "how"), [(f"`{name}`", METHODS[name]().summary) for name in OWN]),
        "rivals": lambda: _rows(
            ("method", "how"), [(f"`{name}`", make().summary) for name, make in METHODS.items() if name not in OWN]
        ),
        "exit codes": lambda: _rows(
            ("status", "exit code"), [(f"`{name}`", str(code)) for name, code in EXIT_CODES.items()]
        ),
        "units": lambda: _rows(
            ("what", "for example", "units", "SI"),
            [(one.noun, f"`{one.example}`", ", ".join(one.units), one.si) for one in DIMENSIONS.values()],
        ),
    }


_PACKAGE = sys.modules[__name__.partition(".")[0]]
"""What `import vibopt as vo` offers is described here, not used."""


def _public(name: str) -> tuple[str, str]:
    """A public name with its parameters, and the first sentence of its docstring."""
    one = getattr(_PACKAGE, name)
    words = ""
    if not isinstance(one, type):
        words = f"({', '.join(inspect.signature(one).parameters)})"
    first = (inspect.getdoc(one) or "").split("\n\n")[0]
    return f"`vo.{name}{words}`", " ".join(first.split())


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
    words = tomllib.loads("\n".join(lines))
    words.pop("kind", None)
    return "\n".join([f"machine.{method}", *(f"    {key}={_python(one)}," for key, one in words.items()), ")"])


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


COMMON = frozenset(key.name for kind in _MODELS.values() for key in keys_of(kind))


def _said(kind: type[Table]) -> str:
    """Its words, without `kind = "..."` in front."""
    front, colon, rest = told(kind).partition(": ")
    return rest[:1].upper() + rest[1:] if colon and front[0] in "`[" else told(kind)


def _family(kind: type[Response]) -> str:
    return "measures" if kind.signed else "limits"


def _bound(kind: type[Response]) -> str:
    example = DIMENSIONS[kind.dimension].example
    side = "at_least" if kind.less_is_worse else "at_most"
    return f"{side} = {example}" if kind.dimension == "count" else f'{side} = "{example}"'


def _facts(kind: type[Response]) -> str:
    dimension = DIMENSIONS[kind.dimension]
    units = f" ({', '.join(dimension.units[:5])})" if dimension.units else ""
    size = f"It is {dimension.noun}{units}"
    size += ", an amplitude: peak unless `pp` or `rms` stands behind its unit." if kind.amplitude else "."
    facts = [size]
    if kind.harmonic:
        facts.append("Its value is the worst over all speeds that are looked at.")
    elif kind.sort == "random":
        facts.append("It is the root mean square under white noise, whose mean squares add.")
    elif kind.sort == "transient":
        facts.append("It is the greatest size in time, free vibration behind the load included.")
    if kind.signed:
        facts.append("It has a sign and is only measured: no limit, no goal.")
    if kind.twin:
        facts.append(f"Of what moves in the other way ask `{kind.twin}`.")
    if kind.noise_twin:
        facts.append(f"Under white noise ask `{kind.noise_twin}`.")
    if kind.transient_twin:
        facts.append(f"Of what comes once ask `{kind.transient_twin}`.")
    if not kind.of_mount:
        facts.append(IN_SPACE[kind.in_space])
    return " ".join(facts)


def _body(kind: type[Table], heading: str, twin: str, fixed: Mapping[str, str]) -> list[str]:
    example = example_of(kind, fixed)
    keys = [key for key in keys_of(kind) if key.name not in fixed]
    python = python_table(twin, example_of(kind, {}))
    shown = [_fenced("toml", [heading, *example]), "In Python:", _fenced("python", [python])]
    return [*shown, _table(keys), *_inner(kind), *_refusals([kind, *tables_in(kind)])]


def _inner(kind: type[Table]) -> list[str]:
    """Tables that stand as values in it."""
    return [part for one in tables_in(kind) for part in (_heading(one), told(one), _table(keys_of(one)))]


def _heading(kind: type[Table]) -> str:
    return f"### {kind.__name__.removesuffix('Table')}"


def _refusals(kinds: list[type[Table]], level: str = "##") -> list[str]:
    said = [one for kind in kinds for one in refusals_of(kind)]
    return [f"{level} Refused, with these words", "\n".join(f"- {one}" for one in said)] if said else []


def _table(keys: Iterable[Key]) -> str:
    return _rows(("key", "what it says"), [(f"`{key.name}`", _sentences(key)) for key in keys])


def _sentences(key: Key) -> str:
    """All that is known of a key, in a row."""
    needed = "Needed. " if key.needed else ""
    shown = f", for example `{key.example}`" if f"`{key.example}`" not in key.says and key.example and key.value else ""
    value = f" *{key.value[0].upper()}{key.value[1:]}{shown}.*" if key.value else ""
    default = f" Without it {key.default}." if key.default else ""
    refused = f" Refused: {key.refused}." if key.refused else ""
    return f"{needed}{key.says}{value}{default}{refused}"


def _rows(heads: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> str:
    """A table in Markdown; "" without rows."""
    lines = [" | ".join(heads), " | ".join("---" for _ in heads)]
    lines += [" | ".join(cell.replace("|", "\\|").replace("\n", " ") for cell in row) for row in rows]
    return "\n".join(f"| {line} |" for line in lines) if rows else ""


def _fenced(language: str, lines: list[str]) -> str:
    return "\n".join([f"```{language}", *lines, "```"])


def _listed(names: list[str]) -> str:
    return ", ".join(f"`{name}`" for name in names)


def _kinds_in(shape: Any) -> Iterator[type[Table]]:
    if isinstance(shape, Mapping):
        if "kind" in shape and isinstance(shape["kind"], type):
            yield shape["kind"]
        for one in shape.values():
            yield from _kinds_in(one)
    elif isinstance(shape, list):
        for one in shape:
            yield from _kinds_in(one)


def _is_text(shape: Mapping[str, Any]) -> bool:
    return shape.get("type") == "string" or "anyOf" in shape


def _described(shapes: Mapping[str, Mapping[str, Any]]) -> str:
    """Keys that are read one by one, as their schema describes them."""
    rows = []
    for key, shape in shapes.items():
        listed = [f'"{one}"' for one in shape.get("enum", ())]
        texts = [one.get("description", "") for one in (shape, *shape.get("anyOf", ()))]
        says = "; ".join([*filter(None, texts), *([f"one of {', '.join(listed)}"] if listed else [])])
        rows += [(f"`{key}`", f"{says[:1].upper()}{says[1:]}.")] if says else []
    return _rows(("key", "what it says"), rows)


__all__ = [
    "COMMON",
    "Excitation",
    "balancing",
    "devices",
    "example_of",
    "excitations",
    "python_of",
    "responses",
    "tables",
]
