"""Pages made from the registries: every table, excitation, response and method, with all keys."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from typing import Any

from vibopt.answer.answer import EXIT_CODES
from vibopt.devices import FAMILIES
from vibopt.excitations import KINDS as EXCITATIONS
from vibopt.manual.key_examples import example_of, method_of, python_of, python_table
from vibopt.manual.keys import keys_of, refusals_of, tables_in, told
from vibopt.manual.markdown_rows import described, fenced, key_table, listed, rows_of
from vibopt.manual.refusals import whole_file_refusals
from vibopt.manual.schema import SCHEMAS
from vibopt.manual.topic import Topic
from vibopt.responses import GOALS, HarmonicResponse, RandomResponse, Response
from vibopt.responses import KINDS as RESPONSES
from vibopt.solve.by_name import METHODS, OWN
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
    "machine": "It is asked of the whole machine, also of one with bodies in space.",
}
_MODELS = {"base": Response, "harmonic": HarmonicResponse, "random": RandomResponse}
_ONES = {"bodies": "a body", "bases": "a base"}


def kinds() -> Iterator[Topic]:
    """A page for each family of devices, each kind of excitation and each response."""
    every = (FAMILIES, FILE, _device), (EXCITATIONS, SHAKES, _excitation), (GOALS, ASKED, _response)
    for names, title, page in every:
        yield from (Topic(name, title, partial(page, name)) for name in names)


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
        facts.append("It has no `speed`: it comes once, with all else that does, and is over.")
    words = [
        f"# {name}",
        _said(kind),
        " ".join(facts),
        *_body(kind, "[excitations.NAME]", method_of(name), {"kind": name}),
    ]
    return "\n\n".join(words)


def _response(name: str) -> str:
    kind = GOALS[name]
    own = [key for key in keys_of(kind) if key.name not in COMMON]
    common = sorted({key.name for key in keys_of(kind)} & COMMON - {"response"})
    if kind.of_limits:
        shown = fenced("toml", ["[goal]", f'maximise = "{name}"'])
        python = f"In Python: `vo.maximise(machine.{name}())`"
        return "\n\n".join([f"# {name}", _said(kind), shown, key_table(own), python, *_refusals([kind])])
    example = example_of(kind, {"response": name})
    words = [f"# {name}", _said(kind), _facts(kind), fenced("toml", [f"[{_family(kind)}.NAME]", *example])]
    words += [key_table(own), "With the keys that many have ([limits](limits.md)): " + listed(common) + "."]
    if not kind.signed:
        words.append(f"In Python: `{python_of(name, kind)}`")
    return "\n\n".join([*words, *_refusals([kind])])


def balancing() -> Iterator[Topic]:
    """A page for each kind of balancing file."""
    for name in SCHEMAS:
        yield Topic(f"{name}_file", BALANCE, partial(_balancing_file, name))


def _balancing_file(name: str) -> str:
    made = SCHEMAS[name]
    titles = {"rotor": "a measured rotor", "known": "known masses on a shaft", "engine": "an engine"}
    words = [
        f"# {name}_file: tables of {titles.get(name, name)}",
        f"The guide is [{_GUIDE[name]}]({_GUIDE[name]}.md).",
    ]
    shapes = made(lambda kind: {"kind": kind, "properties": {}}, lambda one: {"named": one})["properties"]
    words += ["## Above all tables", described({key: shape for key, shape in shapes.items() if _is_text(shape)})]
    for key, (heading, kinds) in balancing_tables(made).items():
        words += [f"## {heading}", "" if kinds else described(shapes[key]["properties"])]
        for kind in kinds:
            words += [_said(kind), key_table(keys_of(kind)), *_inner(kind), *_refusals([kind], "###")]
    words += ["## [scenarios.NAME]", "Named sets of changes, values by path: [studies](studies.md)."]
    return "\n\n".join(word for word in words if word)


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
        "python": lambda: rows_of(("name", ""), [_public(name) for name in sorted(_PACKAGE._HOME_OF)]),
        "limits": lambda: key_table(
            list({key.name: key for one in ("harmonic", "base") for key in keys_of(_MODELS[one])}.values())
        ),
        "excitations": lambda: rows_of(
            ("kind", ""), [(f"[{name}]({name}.md)", _said(kind)) for name, kind in EXCITATIONS.items()]
        ),
        "responses": lambda: rows_of(
            ("response", ""),
            [(f"[{name}]({name}.md)", _said(kind).split("\n\n")[0]) for name, kind in RESPONSES.items()],
        ),
        "devices": lambda: rows_of(
            ("table", ""), [(f"[{name}]({name}.md)", _said(kind).split("\n\n")[0]) for name, kind in FAMILIES.items()]
        ),
        "methods": lambda: rows_of(("method", "how"), [(f"`{name}`", METHODS[name]().summary) for name in OWN]),
        "rivals": lambda: rows_of(
            ("method", "how"), [(f"`{name}`", make().summary) for name, make in METHODS.items() if name not in OWN]
        ),
        "exit codes": lambda: rows_of(
            ("status", "exit code"), [(f"`{name}`", str(code)) for name, code in EXIT_CODES.items()]
        ),
        "units": lambda: rows_of(
            ("what", "for example", "units", "SI"),
            [
                (dimension.noun, f"`{dimension.example}`", ", ".join(dimension.units), dimension.si)
                for dimension in DIMENSIONS.values()
            ],
        ),
    }


_PACKAGE = sys.modules[__name__.partition(".")[0]]
"""What `import vibopt as vo` offers is described here, not used."""


def _public(name: str) -> tuple[str, str]:
    """A public name with its parameters, and the first sentence of its docstring."""
    one = getattr(_PACKAGE, name)
    words = ""
    if not isinstance(one, type):
        words = f"({', '.join(_called(inspect.signature(one).parameters.values()))})"
    first = (inspect.getdoc(one) or "").split("\n\n")[0]
    return f"`vo.{name}{words}`", " ".join(first.split())


COMMON = frozenset(key.name for kind in _MODELS.values() for key in keys_of(kind))


def _called(parameters: Iterable[inspect.Parameter]) -> Iterator[str]:
    """Names of parameters, a star before the first that must be named."""
    named = False
    for parameter in parameters:
        if parameter.kind is parameter.KEYWORD_ONLY and not named:
            named = True
            yield "*"
        yield parameter.name


def _said(kind: type[Table]) -> str:
    """Its words, without `kind = "..."` in front."""
    front, colon, rest = told(kind).partition(": ")
    return rest[:1].upper() + rest[1:] if colon and front[0] in "`[" else told(kind)


def _family(kind: type[Response]) -> str:
    return "measures" if kind.signed else "limits"


def _facts(kind: type[Response]) -> str:
    dimension = DIMENSIONS[kind.dimension]
    known = [unit for unit in dimension.units[:5] if not (kind.complement and unit == "dB")]
    units = f" ({', '.join(known)})" if known else ""
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
        names_place = {"of", "through", "across", "into"} & set(kind.model_fields)
        facts.append(IN_SPACE[kind.in_space or ("" if names_place else "machine")])
    return " ".join(facts)


def _body(kind: type[Table], heading: str, twin: str, fixed: Mapping[str, str]) -> list[str]:
    example = example_of(kind, fixed)
    keys = [key for key in keys_of(kind) if key.name not in fixed]
    python = python_table(twin, example_of(kind, {}))
    shown = [fenced("toml", [heading, *example]), "In Python:", fenced("python", [python])]
    return [*shown, key_table(keys), *_inner(kind), *_refusals([kind, *tables_in(kind)])]


def _inner(kind: type[Table]) -> list[str]:
    """Tables that stand as values in it."""
    return [part for one in tables_in(kind) for part in (_heading(one), told(one), key_table(keys_of(one)))]


def _heading(kind: type[Table]) -> str:
    return f"### {kind.__name__.removesuffix('Table')}"


def _refusals(kinds: list[type[Table]], level: str = "##") -> list[str]:
    said = [one for kind in kinds for one in refusals_of(kind)]
    return [f"{level} Refused, with these words", "\n".join(f"- {one}" for one in said)] if said else []


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
