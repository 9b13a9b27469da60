"""`vibopt report --sheet`: written whole, or refused before anything is solved."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from vibopt.errors import InputError
from vibopt.report.sheet import browser

Run = Callable[..., Any]
ROOT = Path(__file__).parents[2] / "problems"
GENSET = str(ROOT / "mounts" / "generator_set.toml")


@pytest.fixture
def unsolved(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fails the test if anything is solved."""
    import vibopt.cli.solve_command as verb

    monkeypatch.setattr(verb, "_answer", lambda *words: pytest.fail("solved"))


def test_the_sheet_is_written_and_says_what_it_says(run: Run, tmp_path: Path) -> None:
    target = tmp_path / "sheet.html"
    done = run("report", GENSET, "--sheet", "-o", str(target))
    assert (done.code, done.err) == (0, "")
    assert done.out.startswith("optimal: least transmitted force into ground along z is 156.8 N pk")
    assert done.out.endswith(f"Written: {target}\n")
    page = target.read_text(encoding="utf-8")
    assert "All limits met" in page
    assert "SHA-256 generator_set.toml" in page


def test_the_exit_code_is_that_of_the_answer_and_changes_are_on_the_sheet(run: Run, tmp_path: Path) -> None:
    target = tmp_path / "sheet.html"
    file = str(ROOT / "isolation" / "rao_9_34_printed_design.toml")
    done = run("report", file, "--sheet", "-o", str(target), "--set", "limits.start_up.at_most=8 mm", "--json")
    assert done.code == 7
    assert done.data["status"] == "violated"
    assert done.data["written"] == [str(target)]
    page = target.read_text(encoding="utf-8")
    assert "limits.start_up.at_most=8 mm" in page
    assert "NOT FOR SIGNATURE" in page
    assert "Signature" not in page


def test_a_pdf_is_one_page(run: Run, tmp_path: Path) -> None:
    try:
        browser("sheet.pdf")
    except InputError as error:
        pytest.skip(f"no page can be printed here: {error}")
    target = tmp_path / "sheet.pdf"
    assert run("report", GENSET, "--sheet", "-o", str(target)).code == 0
    content = target.read_bytes()
    assert content.startswith(b"%PDF")
    assert content.count(b"/Type /Page\n") == 1


@pytest.mark.usefixtures("unsolved")
def test_a_pdf_without_a_browser_is_refused(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    target = tmp_path / "sheet.pdf"
    done = run("report", GENSET, "--sheet", "-o", str(target))
    assert done.code == 2
    assert done.err == (
        f"{target} cannot be written: a PDF is printed by a browser, and none of chromium, chromium-browser, "
        "google-chrome, chrome is on the PATH. Install Chromium or Chrome, or write "
        f"{tmp_path / 'sheet.html'} and print it from any browser: it is made for one page of A4.\n"
    )
    assert not target.exists()


@pytest.mark.parametrize(
    ("name", "sign"), [("rao_9_6_capped", "Fitted by"), ("rao_9_14_b", "Done by"), ("engine_v_twin", "Done by")]
)
def test_a_balancing_job_has_a_sheet_for_the_shop_floor_and_a_report(
    run: Run, tmp_path: Path, name: str, sign: str
) -> None:
    file, target = str(ROOT / "balancing" / f"{name}.toml"), tmp_path / "page.html"
    assert run("report", file, "--sheet", "-o", str(target)).code == 0
    sheet = target.read_text(encoding="utf-8")
    assert f"<div>{sign} (name)</div>" in sheet
    assert "<svg" in sheet
    assert "What was given" not in sheet
    assert run("report", file, "-o", str(target)).code == 0
    page = target.read_text(encoding="utf-8")
    for words in ("What this stands on", "What was given", f"{sign} (name)", "Checked by", "<svg"):
        assert words in page


@pytest.mark.usefixtures("unsolved")
def test_a_search_for_speeds_is_refused(run: Run, tmp_path: Path) -> None:
    done = run("report", str(ROOT / "isolation" / "rao_9_35.toml"), "--sheet", "-o", str(tmp_path / "sheet.html"))
    assert done.code == 2
    assert done.err == (
        "rao_9_35.toml: --sheet is for one design, and find_all asks at which speeds the limits hold. Use vibopt "
        "report without --sheet.\n"
    )


@pytest.mark.usefixtures("unsolved")
@pytest.mark.parametrize(
    ("words", "endings"), [(("--sheet",), ".html, .htm, .pdf"), ((), ".html, .htm, .pdf")], ids=["sheet", "report"]
)
def test_an_ending_that_is_no_page_is_refused(run: Run, tmp_path: Path, words: tuple[str, ...], endings: str) -> None:
    target = tmp_path / "sheet.doc"
    done = run("report", GENSET, *words, "-o", str(target))
    assert done.code == 2
    assert done.err == f"{target} cannot be written: its ending tells the format, and it is none of {endings}.\n"


def test_rounded_values_are_those_on_the_sheet(run: Run, tmp_path: Path) -> None:
    target = tmp_path / "sheet.html"
    done = run("report", GENSET, "--sheet", "--round", "3", "-o", str(target))
    assert (done.code, done.err) == (0, "")
    page = " ".join(target.read_text(encoding="utf-8").split())
    assert "stiffness 2.16 MN/m along its axis" in page
    assert (
        "Transmitted force into ground along z is 157.4 N pk with rounded values; every limit is measured with" in page
    )
    assert "Values rounded to 3 digits, every limit measured with them; the goal is 0.39 % worse than that of" in page


@pytest.mark.usefixtures("unsolved")
def test_the_long_report_is_not_rounded(run: Run, tmp_path: Path) -> None:
    done = run("report", GENSET, "--round", "3", "-o", str(tmp_path / "page.html"))
    assert done.code == 2
    assert done.err == ("--round goes with --sheet: the report has the exact values. Add --sheet, or leave it out.\n")


def test_the_paper_is_said_and_the_machine_stands_in_the_report(run: Run, tmp_path: Path) -> None:
    file, target = str(ROOT / "isolation" / "rao_9_34.toml"), tmp_path / "page.html"
    assert run("report", file, "-o", str(target), "--paper", "letter").code == 0
    page = target.read_text(encoding="utf-8")
    assert "@page { size: letter;" in page
    assert 'aria-label="The machine"' in page
    assert run("report", file, "--sheet", "-o", str(target), "--force").code == 0
    assert "@page { size: A4;" in target.read_text(encoding="utf-8")


def test_the_sketch_of_a_machine_is_a_picture_of_its_own(run: Run, tmp_path: Path) -> None:
    file, target = str(ROOT / "isolation" / "rao_9_34.toml"), tmp_path / "press.svg"
    assert run("plot", file, "--sketch", "-o", str(target)).code == 0
    words = target.read_text(encoding="utf-8")
    for said in ("press 300 kg", "6957 kN/m", "ground", "30 kN, 3000 rpm", "Looked at"):
        assert said in words
    done = run("plot", file, "--sketch", "--map", "-o", str(tmp_path / "both.svg"))
    assert done.err == "--sketch draws the machine and --map two of its numbers: leave one of them out.\n"
    rotor = str(ROOT / "balancing" / "fan_16_blades.toml")
    done = run("plot", rotor, "--sketch", "-o", str(tmp_path / "fan.svg"))
    assert done.code == 2
    said = "--sketch draws machines; here the plot has the shaft in it. Leave --sketch out.\n"
    assert done.err.endswith(said)
