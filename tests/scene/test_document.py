"""Problem files are read line by line where that is what a TOML reader makes of them, whatever stands in them."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vibopt.document.toml_reading import _by_lines, toml_of

KEYS = st.sampled_from(["a", "b-1", "long_name_of_a_sensor", "7"])
VALUES = st.text(st.characters(blacklist_characters='"\\', blacklist_categories=("Cc", "Cs")), max_size=90)
LONG = ", ".join(f's{k} = "{k}.5 mil pp @ {k} deg"' for k in range(12))


def both(text: str) -> tuple[Any, Any]:
    """What the two readers say, a document or that it is none."""
    answers: list[Any] = []
    for read in (toml_of, tomllib.loads):
        try:
            answers.append(read(text))
        except tomllib.TOMLDecodeError as error:
            answers.append(str(error))
    return answers[0], answers[1]


@given(
    tables=st.lists(st.lists(st.tuples(KEYS, VALUES), min_size=1, max_size=9), min_size=1, max_size=4),
    newline=st.sampled_from(["\n", "\r\n"]),
    space=st.sampled_from(["", " ", "\t "]),
)
def test_tables_of_texts_are_read_as_by_any_reader(
    tables: list[list[tuple[str, str]]], newline: str, space: str
) -> None:
    lines = []
    for one in tables:
        pairs = ",".join(f'{space}{key} ={space} "{value}"{space}' for key, value in one)
        lines.append(f"[[runs]]{newline}t = {{{pairs}}}")
    ours, theirs = both(newline.join([*lines, "[end]", "x = 1"]))
    assert ours == theirs


@pytest.mark.parametrize(
    "text",
    [
        f"a = {{ {LONG} }}",
        f"a = {{ {LONG}, s3 = \"again\" }}",
        f"a = {{ {LONG} }}\na = {{ {LONG} }}",
        f"a = {{ {LONG} }}\n[a.more]\nx = 1",
        f"a = {{ {LONG} }}\na.more = 1",
        f'a = """\nb = {{ {LONG} }}\n"""',
        f"a = '''\nb = {{ {LONG} }}\n'''\nc = {{ {LONG} }}",
        f"a = {{ {LONG}, }}",
        f"a = {{ {LONG} }} # as found",
        f"a = [\nb = {{ {LONG} }}\n]",
        f'mark = "\ue0000"\na = {{ {LONG} }}',
        f"a = {{ {LONG} }}\nb = ",
    ],
)  # fmt: skip
def test_a_table_in_another_place_or_twice_is_told_as_by_any_reader(text: str) -> None:
    ours, theirs = both(text)
    assert ours == theirs


LINES = [
    "[a]", "[[a]]", "[a.b]", "[[a.b]]", "[e.y]", "[[e]]", " [b] # c", "[a.]", "[a]]", "[[a]", "[]", "a = 1",
    "a = 1 # c", 'b = "x"', 'b = "x" y', "a = {}", "a = []", 'c = { a = "1", b = "2" }', 'c = { a = "1", a = "2" }',
    'b = """', '"""', "k = [", "1,", "]", "k = [[1], [", "# x", "a.b = 2", "e = { x = 1 }", "f = 2020-01-01",
    "g = 'l'", 'h = "a\\nb"', "= 3", "t = true", "n = -0", "n = 1_0", "n = 1e3", 'u = """x"""', "v = ''''", "v = '''",
    "\r", "\x00", "", 'a = "#"',
]  # fmt: skip


@settings(max_examples=2000)
@given(lines=st.lists(st.sampled_from(LINES), max_size=7), newline=st.sampled_from(["\n", "\r\n"]))
def test_lines_in_any_order_are_read_as_by_any_reader(lines: list[str], newline: str) -> None:
    ours, theirs = both(newline.join(lines))
    assert repr(ours) == repr(theirs)


def test_nearly_every_problem_file_is_read_by_lines() -> None:
    texts = [file.read_text(encoding="utf-8-sig") for file in (Path(__file__).parents[2] / "problems").rglob("*.toml")]
    read = {text: _by_lines(text) for text in texts}
    assert all(found is None or repr(found) == repr(tomllib.loads(text)) for text, found in read.items())
    assert sum(found is not None for found in read.values()) > 0.9 * len(texts) > 100
