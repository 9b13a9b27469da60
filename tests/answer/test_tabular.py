"""Answers and studies as rows: every number once, the same keys in each row, in a notebook as shown."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

import vibopt as vo
from vibopt.errors import VibOptError

ROOT = Path(__file__).parents[2] / "problems"
FILES = (
    "isolation/rao_9_34",
    "absorbers/rao_9_62",
    "balancing/rao_9_3",
    "balancing/foiles_min_max",
    "balancing/engine_v_twin",
)
PRESS = ROOT / "isolation" / "rao_9_34.toml"


def studies() -> dict[str, Any]:
    job = vo.read(PRESS)
    other = vo.with_changes(job, {"limits.floor_force.at_most": "12 kN"})
    return {
        "sweep": vo.sweep(job, "limits.floor_force.at_most", "8 kN..12 kN", 3),
        "whatif": vo.whatif(job, {"limits.floor_force.at_most": "12 kN"}),
        "compare": vo.compare({"A": job, "B <": other}),
        "explain": vo.explain(job),
        "prices": vo.prices(vo.read(ROOT / "balancing" / "rao_9_6_capped.toml")),
        "spectrum": vo.shock_spectrum(vo.read(ROOT / "shock" / "rao_9_49.toml"), frequencies=(1.0, 2.0)),
    }


def check_rows(one: Any) -> None:
    rows, page = one.table(), one._repr_html_()
    assert rows
    assert len({tuple(row) for row in rows}) == 1
    assert page.count("<tr>") == len(rows) + 1
    assert len(set(re.findall(r"<t[hd]", page))) == 2
    assert page.count("<td") == page.count("<th ") * len(rows)
    assert "&lt;" in page or "B <" not in str(rows)
    json.dumps(one.to_json(), allow_nan=False)  # plain data, nothing of ours inside
    lines = str(one).splitlines()
    assert lines[0] == next(filter(None, one.heading()), lines[0])
    assert isinstance(one, vo.Answer) or len(lines) >= len(rows) + 1


@pytest.mark.parametrize("name", FILES)
def test_an_answer_has_a_row_for_each_number_and_word(name: str) -> None:
    answer: Any = vo.solve(vo.read(ROOT / f"{name}.toml"))
    rows = {row["path"]: row for row in answer.table()}
    assert rows.keys() == answer.entries().keys()
    assert all(rows[path]["value"] == one.value for path, one in answer.entries().items())
    for name, limit in answer.limits.items():
        row = rows[f"limits.{name}.value"]
        assert (row["limit"], row["margin"], row["met"]) == (limit.limit.value, limit.margin, limit.met)
    check_rows(answer)
    assert answer.title in answer._repr_html_()
    assert all(f">{one.shown}<" in answer._repr_html_() for one in answer.entries().values() if "<" not in one.shown)


def test_every_study_has_rows_and_shows_itself() -> None:
    done = studies()
    for one in done.values():
        check_rows(one)
    assert [row["limits.floor_force.at_most [N]"] for row in done["sweep"].table()] == [8000.0, 10000.0, 12000.0]
    goal = next(row for row in done["whatif"].table() if row["path"] == "goal")
    assert goal["after"] == done["sweep"].points[2].goal.value
    assert {row["of"] for row in done["explain"].table()} == {"model", "method", "limit"}
    lines = {row["name"]: row for row in done["compare"].table() if row["kind"] == "chosen"}
    assert lines["links.mount.stiffness"]["B <"] == goal["after"]


def test_pandas_has_the_rows_or_is_asked_for_in_words(monkeypatch: pytest.MonkeyPatch) -> None:
    answer = vo.solve(vo.read(PRESS))
    frame = pytest.importorskip("pandas") and answer.to_pandas()
    assert list(frame.columns) == list(answer.table()[0])
    assert frame.shape[0] == len(answer.table())
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(VibOptError, match=r"^to_pandas needs pandas, which is not installed\. Install it, pip install"):
        answer.to_pandas()


def test_a_grid_has_a_dimension_for_each_fact(monkeypatch: pytest.MonkeyPatch) -> None:
    job = vo.read(PRESS)
    ranges = {"limits.start_up.at_most": "15 mm..30 mm", "bodies.press.mass": "290, 300 kg"}
    study = vo.sweep(job, ranges, points=3)
    seen: dict[str, Any] = {}
    made = SimpleNamespace(Dataset=lambda data, coords: seen.update(data=data, coords=coords))
    monkeypatch.setitem(sys.modules, "xarray", made)
    study.to_xarray()
    names = ["limits.start_up.at_most [m]", "bodies.press.mass [kg]"]
    assert [*seen["coords"]] == names
    assert seen["coords"][names[1]].tolist() == [290.0, 300.0]
    for head, (where, column) in seen["data"].items():
        assert (where, column.shape) == (names, (3, 2)), head
        assert column.ravel().tolist() == [row[head] for row in study.table()]
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(
        VibOptError, match=r"^to_xarray needs xarray, which is not installed\. Install it, pip install x"
    ):
        study.to_xarray()
    with pytest.raises(VibOptError, match=r"^to_xarray is for a grid, and these points are a sample\. Take"):
        vo.sweep(job, {"limits.start_up.at_most": "15 mm..30 mm"}, points=4, sample="latin").to_xarray()
