"""Runs that are written alike are read by their shape: the law is that the document is the one that TOML says."""

from __future__ import annotations

import re
from pathlib import Path
from unittest import mock

import pytest
import tomli
from hypothesis import given
from hypothesis import strategies as st

from vibopt.document import toml_alike, toml_reading
from vibopt.document.toml_reading import toml_of

PLAIN = ('name = "{}"', 'speed = "{} rpm"', 'readings = {{ a = "{} mm @ 3 deg", b = "{}" }}', 'weights={{p="{} g"}}')
STRANGE = (
    'name = "{}" # the "first"', "name = 'one \"{}\" more'", 'name = """{}"""', 'name = "{}\\t"', 'readings.a = "{}"',
    'readings = {{ b = "{}", a = "1" }}', 'readings = {{ "a" = "{}" }}', 'readings = {{ a = "{}", a = "2" }}',
    'readings = {{ c = {{ d = "{}" }} }}', 'readings = {{ a.b = "{}" }}', "readings = {{}}",
    'weights = {{ p = ["{}"] }}', "stayed = true",
    "speed = 3", "", "  ", "# {}", 'name = "{}', 'name = {}"', 'name = ""{}""', '"name" = "{}"', "]",
    'text = """', "text = '''", "x = [", "[runs.weights]", 'p = "{}"', "[[runs]] # {}", "[goal]", "runs = [{{}}]",
)  # fmt: skip
TEXTS = st.sampled_from(["1", "", "ä µm", "a\u00a0b", "a\tb", "\\", "#", "'", "= {", "\x7f"])
LINES = st.builds(str.format, st.sampled_from((*PLAIN, *PLAIN, *STRANGE)), TEXTS, TEXTS)
PLAIN_LINES = st.lists(st.sampled_from(PLAIN), min_size=1, max_size=4, unique=True).flatmap(
    lambda lines: st.tuples(*(st.builds(str.format, st.just(line), TEXTS, TEXTS) for line in lines))
)
RUNS = st.lists(st.one_of(PLAIN_LINES, PLAIN_LINES, st.lists(LINES, max_size=3)), min_size=1, max_size=5)


ODD = {
    "a mark too many": ("", ['name = "1"', 'name = "1""'], ""),
    "an escape": ("", ['name = "1"', 'name = "\\u0041"'], ""),
    "a sign that no text has": ("", ['name = "1"', 'name = "\x7f"'], ""),
    "marks in a comment": ("", ["name = '0' # \"1\"", "name = '0' # \"2\""], ""),
    "a key twice": ("", ['name = "1"', 'name = "1"\nname = "2"'], ""),
    "a text around them": ('text = """\n', ['name = "1"', 'name = "2"'], '[x]\n"""\nruns = [{}]\n'),
    "more of the last one": ("", ['name = "1"', 'name = "2"'], '[runs.weights]\np = "1 g"\n'),
    "tables behind": ('[planes.a]\n', ['name = "1"', 'name = "2"'], '[planes.b]\nradius = "1 m"\n'),
    "a table in a table": ("", ['name = "1"', 'readings = { c = { d = "2" } }'], ""),
    "nothing to cut": ("", ["stayed = true", "readings = {}"], ""),
}  # fmt: skip


def same(text: str) -> None:
    """The document is that of TOML, its keys in the same order; or both complain alike."""
    with mock.patch.object(toml_reading, "_FEW_RUNS", 0):
        try:
            said = tomli.loads(text)
        except tomli.TOMLDecodeError as error:
            with pytest.raises(tomli.TOMLDecodeError, match=f"^{re.escape(str(error))}$"):
                toml_of(text)
        else:
            assert repr(toml_of(text)) == repr(said)


@pytest.mark.parametrize("odd", ODD)
def test_of_runs_that_are_nearly_alike_each_is_what_toml_says(odd):
    head, runs, tail = ODD[odd]
    same(f"{head}\n{''.join(f'[[runs]]{chr(10)}{run}{chr(10)}' for run in runs)}{tail}")


@given(st.lists(LINES, max_size=2), RUNS, st.lists(LINES, max_size=2), st.sampled_from(["\n", "\r\n"]))
def test_runs_that_are_written_alike_are_what_toml_says(head, runs, tail, end):
    same(end.join([*head, *(end.join(["[[runs]]", *run]) for run in runs), *tail, ""]))


def test_of_runs_that_are_written_alike_one_of_each_line_is_parsed():
    text = Path("problems/balancing/bk_17_227.toml").read_text()
    head = text[: text.index("[[runs]]")]
    runs = [f'[[runs]]\nname = "{run}"\nreadings = {{ a = "{run} mm @ 3 deg" }}\n' for run in range(50)]
    parsed = []
    document = toml_alike.read_alike(head + "".join(runs), lambda part: parsed.append(part) or tomli.loads(part))
    assert document == tomli.loads(head + "".join(runs))
    assert len(parsed) == 3  # what stands around the runs, and their two lines
