"""Sheets that are read in one piece say what they say cell by cell, and a plan is held against the sheet itself."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rotor_jobs import messages, read_text
from vibopt.balancing import csv_runs, parse_runs
from vibopt.balancing.csv_runs import Cells
from vibopt.balancing.rotor_job import RotorJob
from vibopt.balancing.solve_rotor import solve_job
from vibopt.balancing.written import numbers, short_numbers
from vibopt.document.mistakes import Mistakes
from vibopt.document.mistakes import Path as Place

HEAD = """title = "sheet"
readings = "job.csv"
[conventions]
phase = "{phase}"
readings = "phase"
angles = "{angles}"
detector = "{detector}"
zero = "mark"
[planes.p]
radius = "100 mm"
[planes.q]
radius = "0.3 ft"
[sensors.a]
importance = 1
{runout}
[sensors.b]
unit = "mm/s"
importance = 1e-4
[sensors.c]
importance = 1
"""
CELLS = st.sampled_from(
    ["8.6", "0", "1e-1", "07.50", "123.456", "5.", ".5", "-3", "nan", "1_0", "", "-", "x", "2,5", "9 µm"]
)
PLAIN = st.sampled_from(["8.6", "1e1", "7.50", "123.456", "3", "0.2"])


def sheet(cells: list[list[str]], sign: str, comma: bool) -> str:
    names = (
        "a amplitude [mil pp]",
        "a angle [deg]",
        "b amplitude",
        "b angle [deg]",
        "c angle [°]",
        "c amplitude [µm rms]",
    )
    rows = [["run", "speed [rpm]", "p mass [g]", "p angle [deg]", "q", *names]]
    weights = (("", "", ""), ("10", "90", ""), ("", "", "12 oz @ 200 deg"))
    for own, (mass, angle, text) in zip(cells, weights, strict=True):
        rows.append([f"run {mass}{text}", "1500", mass, angle, text, *own])
    if comma:
        rows[1:] = [[cell.replace(".", ",") for cell in row] for row in rows[1:]]
    return "\n".join(sign.join(row) for row in rows) + "\n"


def head(lag: bool = True, against: bool = True, detector: str = "pp", runout: str = "") -> str:
    return HEAD.format(
        phase="lag" if lag else "lead", angles=f"{'against' if against else 'with'} rotation", detector=detector,
        runout=runout,
    )  # fmt: skip


def cell_by_cell(text: str, folder: Path) -> tuple[list[str], RotorJob | None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Cells, "readings", lambda own, rows: [None] * len(rows))
        patch.setattr(parse_runs, "_in_one_piece", lambda raws, document: raws)
        patch.setattr(parse_runs, "_in_arrays", lambda *given: None)
        said = messages(text, folder)
        return said, None if said else read_text(text, folder)


@settings(max_examples=60, deadline=None)
@given(
    cells=st.one_of(st.lists(st.lists(one, min_size=6, max_size=6), min_size=3, max_size=3) for one in (PLAIN, CELLS)),
    comma=st.booleans(), lag=st.booleans(), against=st.booleans(), detector=st.sampled_from(["pk", "pp", "rms"]),
)  # fmt: skip
def test_a_sheet_in_one_piece_is_what_its_cells_are(
    cells: list[list[str]], comma: bool, lag: bool, against: bool, detector: str
) -> None:
    text = head(lag, against, detector)
    with TemporaryDirectory() as made:
        folder = Path(made)
        (folder / "job.csv").write_text(sheet(cells, ";" if comma else ",", comma))
        said, job = cell_by_cell(text, folder)
        assert messages(text, folder) == said
        if job is None:
            return
        whole = read_text(text, folder)
    assert (whole.sensors, whole.notes, whole.planes) == (job.sensors, job.notes, job.planes)
    for one, other in zip(whole.runs, job.runs, strict=True):
        assert (one.name, one.given_speed, one.fitted, one.written) == (
            other.name, other.given_speed, other.fitted, other.written,
        )  # fmt: skip
        np.testing.assert_allclose(one.readings, other.readings, rtol=1e-14)
        np.testing.assert_array_equal(one.weights, other.weights)


WORDS = st.tuples(
    st.sampled_from(["1500", "1500 rpm", "3000", "", "fast"]), st.sampled_from(["", "yes", "no", "perhaps", "-"])
)


@settings(max_examples=60, deadline=None)
@given(
    words=st.lists(WORDS, min_size=2, max_size=6), names=st.lists(st.sampled_from(["", "-", "2,5", "a"]), min_size=6),
    named=st.booleans(), comma=st.booleans(),
)  # fmt: skip
def test_rows_with_the_words_of_others_are_what_their_cells_are(
    words: list[tuple[str, str]], names: list[str], named: bool, comma: bool
) -> None:
    """Speeds and stays that stand in several rows, readable or not, with names, without any, or with some."""
    sizes = [f"{one} amplitude [{'mm/s' if one == 'b' else 'mil pp'}]" for one in "abc"]
    heads = ["speed [rpm]", "p", "stayed", *sizes, *(f"{one} angle [deg]" for one in "abc")]
    trials = [[speed, f"10 g @ {k % 2}0 deg", stayed, *"753987"] for k, (speed, stayed) in enumerate(words)]
    rows = [heads, ["1500", "", "", *"864123"], *trials]
    if named:
        rows = [[name, *row] for name, row in zip(["run", *names, *names], rows, strict=False)]
    with TemporaryDirectory() as made:
        folder = Path(made)
        (folder / "job.csv").write_text("\n".join((";" if comma else ",").join(row) for row in rows))
        text = head().replace('[planes.q]\nradius = "0.3 ft"\n', "")
        said, job = cell_by_cell(text, folder)
        assert messages(text, folder) == said
        whole = None if job is None else read_text(text, folder)
    for one, other in zip(whole.runs if whole else (), job.runs if job else (), strict=True):
        for key in ("name", "given_speed", "fitted", "stayed"):
            assert getattr(one, key) == getattr(other, key)
        np.testing.assert_array_equal(one.weights, other.weights)


def test_a_word_of_many_rows_is_read_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []
    read = csv_runs._own

    def counted(column: csv_runs.Column, cell: str, path: Place, mistakes: Mistakes) -> dict[str, Any]:
        asked.append(cell)
        return read(column, cell, path, mistakes)

    monkeypatch.setattr(csv_runs, "_own", counted)
    head_row, found, *trials = sheet(SOUND, ",", False).splitlines()
    rows = [head_row, found, *trials, *(f"again {k}{row[5:]}" for k in range(20) for row in trials)]
    (tmp_path / "job.csv").write_text("\n".join(rows))
    assert len(read_text(head(), tmp_path).runs) == 43
    assert asked.count("1500") == 3


SOUND = [
    ["8.6", "63", "6.5", "3.1", "20", "40"],
    ["5.9", "123", "4.5", "1.2", "100", "30"],
    ["6.2", "36", "3.4", "5.1", "250", "44"],
]


@pytest.mark.parametrize(
    "wrong",
    [
        lambda run: replace(run, readings=run.readings * np.array([1.0, 1.0, 1.01])),
        lambda run: replace(run, readings=np.conj(run.readings)),
        lambda run: replace(run, weights=run.weights * 1.01),
        lambda run: replace(run, weights=np.conj(run.weights)),
    ],
    ids=["a wrong unit", "lag for lead", "a wrong radius", "the sense of rotation"],
)
def test_a_job_that_was_read_wrongly_is_refused(wrong: object, tmp_path: Path) -> None:
    (tmp_path / "job.csv").write_text(sheet(SOUND, ",", False))
    job = read_text(head(runout='runout = "0.4 mil pp @ 20 deg"'), tmp_path)
    assert solve_job(job).status == "optimal"
    assert callable(wrong)
    odd = replace(job, runs=(job.runs[0], *(wrong(run) for run in job.runs[1:])))
    assert solve_job(odd).status == "check_failed"


DIGITS = st.from_regex(r"-?[0-9]{0,8}\.?[0-9]{0,7}", fullmatch=True)
SHAPES = st.sampled_from(
    ["1.2.3", "", "-", ".", "-.", "+1", "1e3", "1_0", "nan", "--1", "1-", " 1", "1\n2", "１", "1234567890123456"]
)


@given(st.lists(DIGITS.filter(lambda text: any(map(str.isdigit, text))), min_size=1), st.none() | SHAPES)
def test_numbers_that_are_read_all_at_once_are_those_of_float(texts: list[str], other: str | None) -> None:
    found = short_numbers(texts)
    assert found is not None
    assert found.tobytes() == np.array(list(map(float, texts))).tobytes()
    if other is not None:
        assert short_numbers([*texts, other, "1"]) is None


def test_long_sheets_are_read_all_at_once() -> None:
    rng = np.random.default_rng(5)
    texts = [f"{value:.6g}" for value in rng.uniform(0.01, 360.0, 6000)]
    found = numbers(texts, (2, 3000))
    assert found is not None
    np.testing.assert_array_equal(found, np.array(texts, dtype=float).reshape(2, 3000))
    assert numbers([*texts[1:], "x"], (2, 3000)) is None
