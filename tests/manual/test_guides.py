"""What the guides show is what happens: whole files are solved, commands print what stands there, Python runs."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

import pytest

import vibopt as vo
from examples import agrees, blocks_of, run
from vibopt.balancing.conventions import CHOICES
from vibopt.cli.main import main
from vibopt.devices import FAMILIES
from vibopt.devices.shaft_matrices import ShaftMatrices
from vibopt.document.expected import KEYS
from vibopt.excitations import KINDS as EXCITATIONS
from vibopt.manual.book import GROUPS, the_book
from vibopt.manual.keys import keys_of
from vibopt.manual.reference import balancing_tables
from vibopt.manual.schema import SCHEMAS
from vibopt.responses import KINDS as RESPONSES
from vibopt.values import Table

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "vibopt" / "manual" / "guides"
GUIDES = {file.stem: file.read_text(encoding="utf-8") for file in sorted(FOLDER.glob("*.md"))}
SHOWN = [name for name, text in GUIDES.items() if any(one.language in ("console", "python") for one in blocks_of(text))]


def test_every_guide_stands_in_the_contents_once() -> None:
    listed = [name for names in GROUPS.values() for name in names]
    assert sorted(listed) == sorted([*GUIDES, "contributing"])
    assert set(listed) <= set(the_book().topics)


@pytest.mark.parametrize("name", SHOWN)
def test_the_commands_of_a_guide_print_what_it_shows(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "problems").symlink_to(ROOT / "problems")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("VIBOPT_CACHE", f"{tmp_path}-kept")  # as a reader has it
    for command, expected, said in run(GUIDES[name], tmp_path):
        assert agrees(expected, said), f"vibopt {command}\n{said}"
    for picture in re.findall(r"^!\[.+\]\((.+\.svg)\)$", GUIDES[name], re.M):
        assert words_in(tmp_path / picture) == words_in(FOLDER / picture)


SPEED = re.compile(
    r"(half|third|quarter|fourth|fifth|sixth|tenth|fraction)s?\s+of\s+(the|a|its)\s+(processor\s+)?(time|second)"
    r"|in\s+half\s+the\s+time|times\s+(as\s+)?(fast|faster|sooner)\b(?! one turns| it turns)"
    r"|\d (s|ms|us)\s+(became|instead)"
    r"|\b(in|takes?)\s+(a second|seconds|minutes)\b"
)


def test_how_fast_answers_are_is_said_where_charts_print_it_alone() -> None:
    """In the guide of the charts, and in that part of the README; what was changed is another matter."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    rest = re.sub(r"## The five charts.*?\n## ", "## ", readme, flags=re.S)
    pages = {**GUIDES, "readme": rest, "charts": "", "changelog": ""}
    assert SPEED.search(GUIDES["charts"])
    assert SPEED.search("in a fifth to a half of the time")
    assert {name: found[0] for name, text in pages.items() if (found := SPEED.search(text))} == {}


def words_in(picture: Path) -> list[str]:
    """All that a figure says: titles, axes, ticks, labels and legends."""
    return re.findall(r"<!-- (.*?) -->", picture.read_text(encoding="utf-8"), re.S)


@pytest.mark.parametrize("name", GUIDES)
def test_every_whole_file_of_a_guide_has_a_name_and_no_mistake(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    blocks = blocks_of(GUIDES[name])
    assert all(block.file for block in blocks if block.is_whole)
    for block in blocks:
        if block.file:
            (tmp_path / block.file).write_text(block.text, encoding="utf-8")
    for block in blocks:
        if block.is_whole:
            assert main(["check", block.file]) == 0
            shown = any(block.file in one.text for one in blocks if one.language == "console")
            assert shown or vo.solve(vo.read(block.file)).status in ("optimal", "feasible", "met")


def test_a_line_of_dots_stands_for_any_lines() -> None:
    assert agrees("a\n...\nd\n", "a\nb\nc\nd\n")
    assert agrees("...\nd is ...\n...\n", "a\nd is 7\n")
    assert not agrees("a\nd\n", "a\nb\nd\n")
    assert not agrees("...\nd\n", "a\nd\ne\n")


def _known() -> dict[str, set[str]]:
    """Keys that a table may have, by its name: devices, excitations, responses, and those of balancing files."""
    found: dict[str, set[str]] = {}

    def add(family: str, kinds: Iterable[type[Table]]) -> None:
        found.setdefault(family, set()).update(key.name for kind in kinds for key in keys_of(kind))

    for name, kind in FAMILIES.items():
        add(name, [kind])
    add("matrices", [ShaftMatrices])
    add("excitations", EXCITATIONS.values())
    for family in ("limits", "measures", "goal"):
        add(family, RESPONSES.values())
    for made in SCHEMAS.values():
        for key, (_, kinds) in balancing_tables(made).items():
            add(key, kinds)
    found["goal"] |= {"maximise", "minimise", "find_all"}
    found["conventions"] = {*CHOICES, "zero"}
    found["expected"], found["scenarios"] = set(KEYS), set()  # paths in quotation marks
    return found


@pytest.mark.parametrize("name", GUIDES)
def test_no_guide_shows_a_key_that_there_is_not(name: str) -> None:
    known = _known()
    for block in blocks_of(GUIDES[name]):
        table = ""
        for line in block.text.splitlines() if block.language == "toml" else ():
            if heading := re.match(r"\[+(\w+)(?:\.\w+\.(\w+))?", line):
                table = heading[2] if heading[2] in known else heading[1]
                assert table in known, line
            elif table and (key := re.match(r"(\w+) = ", line)):
                assert key[1] in known[table], f"{table}: {line}"
