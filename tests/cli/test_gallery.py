"""The page of verified problems: what it says of each, what it never writes over, and that it is always the same."""

import re
import shutil
import tomllib
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import pytest

from vibopt.document.expected import VERDICTS
from vibopt.files.marks import is_ours
from vibopt.study.gallery import MEANINGS, _plain

PROBLEMS = Path(__file__).parents[2] / "problems"
Run = Callable[..., Any]
WRONG = "1 / 11.76 in place of 1 / (11.76 - 1)"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Two problems with printed answers in a folder, and one that has a mistake."""
    for name in ("isolation/rao_9_27", "isolation/rao_9_2", "balancing/rao_9_3"):
        target = tmp_path / f"{name}.toml"
        target.parent.mkdir(exist_ok=True)
        shutil.copy(PROBLEMS / f"{name}.toml", target)
    return tmp_path


def cells(page: str, link: str) -> list[list[str]]:
    """The cells of every line of a table that belongs to this link: its own, and those below that name no other."""
    found, inside = [], False
    for line in page.splitlines():
        inside = f"]({link}) |" in line if line.startswith("| [") else inside and line.startswith("|  |")
        if inside:
            found.append(re.split(r" ?(?<!\\)\| ?", line)[1:-1])
    return found


def test_a_problem_is_a_line_with_printed_answer_ours_verdict_reason_and_proof(run: Run, folder: Path) -> None:
    done = run("verify", str(folder), "--report")
    assert (done.code, done.out.splitlines()[-1]) == (0, f"Written: {folder / 'README.md'}")
    page = (folder / "README.md").read_text(encoding="utf-8")
    *faults, line = cells(page, "isolation/rao_9_27.toml")
    source = "Rao, Mechanical Vibrations, problem 9.27"
    assert ["transmissibility at 35 Hz", "0.0850", "0.092936803", "wrong", WRONG] in [one[1:] for one in faults]
    assert [one[0] for one in faults] == [f"[{source}](isolation/rao_9_27.toml)", "", ""]
    assert (line[0], line[1]) == ("[Instrument on a vibrating panel](isolation/rao_9_27.toml)", source)
    assert "stiffest mount: **35.644026 kN/m**" in line[2].split("<br>")
    assert f"transmissibility at 35 Hz: **0.092936803**; printed 0.0850: **wrong** ({WRONG})" in line[2].split("<br>")
    assert "isolation at 35 Hz: **90.70632 %**, right 90.706320 %; printed 91.5 %" in line[2]
    assert line[3] == "optimal, proven: closed_form"
    (angle,) = cells(page, "balancing/rao_9_3.toml")[:-1]
    assert angle[1:4] == ["angle of the balancing weight", "-25.5525 deg", "154.44788 deg"]
    assert page.index("## balancing") < page.index("## isolation")
    assert page.index("isolation/rao_9_2.toml") < page.index("| [Instrument")


def test_the_head_counts_files_records_and_verdicts(run: Run, folder: Path) -> None:
    assert run("verify", str(folder), "--report").code == 0
    page = (folder / "README.md").read_text(encoding="utf-8")
    records = [one for file in folder.rglob("*.toml") for one in tomllib.loads(file.read_text())["expected"]]
    judged = Counter(one["verdict"] for one in records if "verdict" in one)
    assert f"\n3 files, {len(records)} records, all as recorded. 3 answers proven, " in page
    assert f"\n{judged.total()} printed answers:\n" in page
    assert all(f"\n| {word} | {judged[word]} | {MEANINGS[word]} |\n" in page for word in VERDICTS)
    assert tuple(MEANINGS) == VERDICTS


def test_it_is_the_same_on_every_run_from_anywhere_with_any_number_of_workers(
    run: Run, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pages = set()
    for words in (
        (str(folder), "--workers", "1"),
        (".", "--workers", "3"),
        ("isolation", "balancing", "-o", "README.md"),
    ):
        assert run("verify", *words, "--report").code == 0
        pages.add((folder / "README.md").read_bytes())
        monkeypatch.chdir(folder)
    assert len(pages) == 1
    assert is_ours(pages.pop())


def test_what_does_not_agree_stands_in_head_and_line(run: Run, folder: Path) -> None:
    file = folder / "isolation" / "rao_9_2.toml"
    text = file.read_text(encoding="utf-8")
    value = re.search(r'^value = "?([\d.]+)', text, re.M)
    assert value is not None
    file.write_text(text.replace(value[0], value[0].replace(value[1], f"{2 * float(value[1])}"), 1), encoding="utf-8")
    (folder / "balancing" / "rao_9_3.toml").write_text("title = 1", encoding="utf-8")
    assert run("verify", str(folder), "--report").code == 6
    page = (folder / "README.md").read_text(encoding="utf-8")
    assert " as recorded and **2 not**. 2 answers proven, or measured on a machine as given; 1 not proven.\n" in page
    assert "relative difference 0.5, allowed 1e-09." in cells(page, "isolation/rao_9_2.toml")[-1][2]
    (broken,) = cells(page, "balancing/rao_9_3.toml")
    assert (broken[0], broken[3]) == ("[rao_9_3.toml](balancing/rao_9_3.toml)", "input_error")
    assert broken[2].startswith("the file: **input_error**, right no mistakes; **not as recorded**: rao_9_3.toml")


def test_a_page_of_somebody_else_stays(run: Run, folder: Path) -> None:
    shutil.rmtree(folder / "balancing")
    mine = folder / "README.md"
    mine.write_text("# My problems\n", encoding="utf-8")
    refused = (
        2,
        f"{mine} cannot be written: it is there already, and vibopt did not write it or it has been changed since. "
        "Name another file, or add --force.\n",
    )
    done = run("verify", str(folder), "--report")
    assert (done.code, done.err, mine.read_text()) == (*refused, "# My problems\n")
    assert run("verify", str(folder), "--report", "--force").code == 0
    assert run("verify", str(folder), "--report").code == 0
    mine.write_text(mine.read_text(encoding="utf-8").replace("right", "left", 1), encoding="utf-8")
    done = run("verify", str(folder), "--report")
    assert (done.code, done.err) == refused


def test_json_names_the_page_and_is_otherwise_as_without(run: Run, folder: Path) -> None:
    plain = run("verify", str(folder / "isolation"), "--json").data
    told = run("verify", str(folder / "isolation"), "--json", "-o", str(folder / "page.md")).data
    assert told == {**plain, "written": [str(folder / "page.md")]}


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            ["isolation", "balancing", "--report"],
            "--report writes README.md into the folder that is verified, and 2 paths are named. Add -o FILE.md.\n",
        ),
        (
            ["isolation/rao_9_2.toml", "--report"],
            "--report writes README.md into the folder that is verified, and a single file is named. Add -o FILE.md.\n",
        ),
        (["nowhere", "--report"], "nowhere is not there. Name a problem file (.toml) or a folder of them.\n"),
        (
            ["isolation", "-o", "page.html"],
            "page.html cannot be written: its ending tells the format, and it is none of .md.\n",
        ),
    ],
)
def test_where_it_cannot_go_is_said(
    run: Run, folder: Path, monkeypatch: pytest.MonkeyPatch, words: list[str], message: str
) -> None:
    monkeypatch.chdir(folder)
    done = run("verify", *words)
    assert (done.code, done.err) == (2, message)
    assert list(folder.glob("*.*")) == []


def test_texts_stand_as_they_are_written() -> None:
    assert _plain("1 <= w_n | 2*a ~ `b` [c]\n d") == r"1 \<= w_n \| 2\*a \~ \`b\` \[c\] d"
    assert _plain("_x_ a_b") == r"\_x\_ a_b"


def test_the_page_of_the_problems_names_every_file_and_all_that_was_printed() -> None:
    page = (PROBLEMS / "README.md").read_text(encoding="utf-8")
    again = "Run vibopt verify problems/ --report: the page is older than the files."
    assert is_ours(page.encode()), again
    named = {unquote(one) for one in re.findall(r"\]\((.+?\.toml)\) \|", page)}
    files = {file.relative_to(PROBLEMS).as_posix(): file for file in PROBLEMS.rglob("*.toml")}
    assert named == set(files), again
    for place, file in files.items():
        document = tomllib.loads(file.read_text(encoding="utf-8"))
        *faults, line = cells(page, place)
        assert line[0] == f"[{_plain(document['title'])}]({place})", again
        assert line[1] == _plain(document.get("source", "")), again
        told = line[2].split("<br>")
        assert len(told) == len(document["expected"]), again
        for record, said in zip(document["expected"], told, strict=True):
            assert said.startswith(f"{_plain(record['what'])}: **"), again
            assert "printed" not in record or f"; printed {_plain(record['printed'])}" in said, again
            assert _plain(record.get("why", "")) in said, again
        assert [one[4] for one in faults] == [
            one["verdict"] for one in document["expected"] if one.get("verdict") in ("wrong", "misprint")
        ], again


def test_the_page_of_the_problems_has_no_record_that_fails() -> None:
    page = (PROBLEMS / "README.md").read_text(encoding="utf-8")
    assert ", all as recorded. " in page
    assert "not as recorded" not in page
