"""The manual holds every kind, key, method, status and verb that there is, with words and examples that are read."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Mapping
from typing import Any, ClassVar

import pytest
from pydantic import ValidationError

import vibopt as vo
from vibopt.answer.answer import EXIT_CODES
from vibopt.cli.help_command import whole_book
from vibopt.cli.main import VERBS
from vibopt.cli.main import vibopt as verbs
from vibopt.devices import FAMILIES
from vibopt.excitations import KINDS as EXCITATIONS
from vibopt.manual.key_examples import example_of, method_of, python_of, python_table
from vibopt.manual.keys import keys_of, refusals_of, said_of, tables_in
from vibopt.manual.reference import COMMON, balancing_tables
from vibopt.manual.schema import SCHEMAS, schema_of
from vibopt.responses import KINDS as RESPONSES
from vibopt.responses import HarmonicResponse, RandomResponse
from vibopt.solve.by_name import METHODS
from vibopt.units import DIMENSIONS
from vibopt.values import Table

BOOK = whole_book(verbs)
FILES: dict[str, tuple[type[Table], dict[str, str]]] = {
    **{name: (kind, {}) for name, kind in FAMILIES.items()},
    **{name: (kind, {"kind": name}) for name, kind in EXCITATIONS.items()},
    **{name: (kind, {"response": name}) for name, kind in RESPONSES.items()},
}
ELSEWHERE = {
    "mounts.csv",
    "mass.mtx",
    "stiffness.mtx",
    "damping.mtx",
    "gyroscopic.mtx",
    "girder.npz",
    "record.csv",
    "bearing.csv",
}
"""Files that examples name and that are not here."""
TABLES: dict[str, type[Table]] = {
    **{f"{name}: {one.__name__}": one for name, (kind, _) in FILES.items() for one in (kind, *tables_in(kind))},
    **{
        f"{file}: {one.__name__}": one
        for file, made in SCHEMAS.items()
        for _, kinds in balancing_tables(made).values()
        for kind in kinds
        for one in (kind, *tables_in(kind))
    },
}


@pytest.mark.parametrize("name", FILES)
def test_every_kind_has_a_page_with_all_its_keys(name: str) -> None:
    kind, fixed = FILES[name]
    text = BOOK.topics[name].text
    for key in keys_of(kind):
        assert key.name in fixed or f"`{key.name}`" in text, key.name


@pytest.mark.parametrize("name", FILES)
def test_the_example_of_every_kind_is_read(name: str) -> None:
    kind, fixed = FILES[name]
    lines = example_of(kind, fixed)
    assert "\n".join(lines) in BOOK.topics[name].text
    if not any(file in line for file in ELSEWHERE for line in lines):
        kind.model_validate(tomllib.loads("\n".join(lines)))


@pytest.mark.parametrize("name", [name for name, kind in RESPONSES.items() if not kind.signed])
def test_every_response_has_its_twin_in_python(name: str) -> None:
    code = python_of(name, RESPONSES[name])
    assert code in BOOK.topics[name].text
    limit = eval(code, {"machine": vo.Machine("any")})
    assert limit.words == tomllib.loads("\n".join(example_of(RESPONSES[name], {"response": name})))


class Recorder(vo.Machine):
    """Keeps the tables that are added."""

    tables: ClassVar[list[Any]] = []

    def _add(self, family: str, name: str, words: Mapping[str, object]) -> None:
        self.tables.append((family, dict(words)))


@pytest.mark.parametrize("name", [*FAMILIES, *EXCITATIONS])
def test_every_device_and_excitation_has_its_twin_in_python(name: str) -> None:
    kind, fixed = FILES[name]
    code = python_table(method_of(name), example_of(kind, {}))
    assert f"```python\n{code}\n```" in BOOK.topics[name].text
    eval(code, {"machine": Recorder("any")})
    family, words = Recorder.tables.pop()
    assert family == (name if name in FAMILIES else "excitations")
    assert words == tomllib.loads("\n".join(example_of(kind, fixed)))


@pytest.mark.parametrize("name", TABLES)
def test_every_key_has_words_and_an_example_that_is_read(name: str) -> None:
    kind = TABLES[name]
    schema = kind.model_json_schema().get("properties", {})
    shown = {key.name: key for key in keys_of(kind)}
    assert set(shown) == {key for key, one in schema.items() if "not" not in one}
    for key in shown.values():
        assert key.says, f"no words for {key.name}"
        if key.name in ("response", "kind") and not key.example:
            continue
        assert key.example, f"no example of {key.name}"
        if any(file in key.example for file in ELSEWHERE):
            continue
        assert not _complaints(kind, key.name, tomllib.loads(key.example))


def _complaints(kind: type[Table], key: str, given: dict[str, Any]) -> list[str]:
    """What is said of the value of a key; that others are missing does not count."""
    try:
        kind.model_validate(given)
    except ValidationError as error:
        return [one["msg"] for one in error.errors() if one["loc"][:1] == (key,)]
    return []


@pytest.mark.parametrize("name", TABLES)
def test_words_are_of_keys_that_there_are(name: str) -> None:
    kind = TABLES[name]
    own = {key for one in kind.__mro__ if issubclass(one, Table) for key in one.model_fields}
    assert set(said_of(kind)) <= own


@pytest.mark.parametrize("file", ["scene", *SCHEMAS])
def test_every_key_of_the_schema_is_described(file: str) -> None:
    silent = [path for path, one in _keys(schema_of(file), file) if "description" not in one]
    assert not silent


def _keys(schema: dict[str, Any], path: str) -> Iterator[tuple[str, dict[str, Any]]]:
    """Keys of the tables of devices, excitations, responses and balancing files, with their schemas."""
    for name, one in schema.get("$defs", {}).items():
        yield from ((f"{name}.{key}", inner) for key, inner in one.get("properties", {}).items() if _open(inner))
    for name, one in schema["properties"].items():
        if name in ("title", "statement", "source", "expected"):
            continue
        for table in _tables(one):
            yield from ((f"{path}.{name}.{key}", inner) for key, inner in table["properties"].items() if _open(inner))


def _tables(one: dict[str, Any]) -> Iterator[dict[str, Any]]:
    for word in ("additionalProperties", "items"):
        if isinstance(one.get(word), dict):
            yield from _tables(one[word])
    for word in ("oneOf", "anyOf"):
        for part in one.get(word, []):
            yield from _tables(part)
    if "properties" in one:
        yield one


def _open(one: dict[str, Any]) -> bool:
    return "const" not in one and "not" not in one


@pytest.mark.parametrize("kind", [HarmonicResponse, RandomResponse])
def test_the_keys_that_many_responses_have_stand_with_the_limits(kind: type[Table]) -> None:
    assert {key.name for key in keys_of(kind)} <= COMMON
    text = BOOK.topics["limits"].text
    assert all(f"`{key.name}`" in text for key in keys_of(kind))


def test_a_balancing_file_has_every_table_that_its_schema_has() -> None:
    for file in SCHEMAS:
        text = BOOK.topics[f"{file}_file"].text
        for name, one in schema_of(file)["properties"].items():
            if name not in ("title", "statement", "source", "expected", "readings", "speed"):
                assert any(heading in text for heading in (f"[{name}]", f"[{name}.NAME]", f"[[{name}]]")), name
            for table in _tables(one):
                assert all(f"`{key}`" in text for key in table["properties"] if name != "expected"), name


def test_methods_statuses_units_and_verbs_have_their_place() -> None:
    methods, statuses, units = (BOOK.topics[name].text for name in ("methods", "statuses", "units"))
    assert all(f"`{name}`" in methods for name in METHODS)
    assert all(f"| `{name}` | {code} |" in statuses for name, code in EXIT_CODES.items())
    assert all(one.noun in units and one.example in units for one in DIMENSIONS.values())
    assert set(VERBS) <= set(BOOK.topics)


def test_every_public_name_stands_with_its_parameters_and_its_words() -> None:
    rows = dict(re.findall(r"^\| `vo\.(\w+)[^`]*` \| (.*) \|$", BOOK.topics["python"].text, re.M))
    assert set(rows) == set(vo._HOME_OF)
    assert all(len(words) > 20 for words in rows.values())
    assert "`vo.sweep(job, vary, low_high, points" in BOOK.topics["python"].text


def test_what_a_table_refuses_stands_on_its_page() -> None:
    said = refusals_of(FAMILIES["links"])
    assert 'has neither stiffness nor damping. Write stiffness = "200 kN/m".' in said
    for name, (kind, _) in FILES.items():
        assert all(one in BOOK.topics[name].text for one in refusals_of(kind))


def test_what_is_asked_of_the_whole_machine_may_be_asked_in_space() -> None:
    assert (
        "It is asked of the whole machine, also of one with bodies in space." in BOOK.topics["natural_frequency"].text
    )
    assert "Bodies in space have no such response." in BOOK.topics["own_frequency"].text
