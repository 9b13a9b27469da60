"""Every problem file: its answer is what it records, and the answer can be told."""

from __future__ import annotations

import json
import tomllib
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from shapes import faults

from vibopt.answer.answer import Answer
from vibopt.answer.jsonable import json_text
from vibopt.answer.text import blocks_of, text_of, verdict
from vibopt.document.expected import KEYS, REL_TOL
from vibopt.jobs import answer, is_scene, kind_of, open_job
from vibopt.manual.schema import schema_of, schema_of_answers
from vibopt.study.recorded import compare

if TYPE_CHECKING:
    from vibopt.balancing import BalancingJob

PROBLEMS = Path(__file__).parents[1] / "problems"
FILES = sorted(PROBLEMS.rglob("*.toml"))


ANSWERS = schema_of_answers()
FILES_OF = cache(schema_of)


LONG = "friction/cabinet_on_pads_as_bought"
"""Takes ten seconds beside a file of its kind that takes less; it is answered with `-m slow`."""


def name_of(file: Path) -> str:
    return file.relative_to(PROBLEMS).with_suffix("").as_posix()


def records(file: Path) -> list[dict[str, Any]]:
    """The `[[expected]]` tables of one problem file."""
    return list(tomllib.loads(file.read_text(encoding="utf-8")).get("expected", []))


@pytest.mark.parametrize(
    "file", [pytest.param(one, marks=pytest.mark.slow) if name_of(one) == LONG else one for one in FILES], ids=name_of
)
def test_every_file_answers_what_it_records(file: Path) -> None:
    job = open_job(file)
    found = answer(job)
    rows = [compare(found, record, name_of(file)) for record in job.expected]
    assert rows
    assert [row for row in rows if not row.ok] == []
    assert list(faults(json.loads(json_text(found)), ANSWERS, ANSWERS)) == []
    if not is_scene(job) and not is_scene(found.job):
        told_in_80_columns(found, job)


@pytest.mark.parametrize("file", FILES, ids=name_of)
def test_every_file_has_the_shape_that_the_schema_of_its_kind_prints(file: Path) -> None:
    document = tomllib.loads(file.read_text(encoding="utf-8"))
    shape = FILES_OF(kind_of(document))
    assert list(faults(document, shape, shape)) == []
    assert list(faults({**document, "titel": "Press"}, shape, shape)) == [".titel: nobody knows it"]


def told_in_80_columns(found: Answer[Any], job: BalancingJob) -> None:
    """The text and the blocks of the page of a balancing job."""
    assert verdict(found).startswith(f"{found.status}: ")
    assert max(map(len, text_of(found).splitlines())) <= 80
    assert blocks_of(found)


@pytest.mark.parametrize("file", FILES, ids=name_of)
def test_a_record_coarser_than_the_rule_says_why(file: Path) -> None:
    for record in records(file):
        assert set(record) <= set(KEYS)
        assert (record.get("rel_tol", REL_TOL) > REL_TOL) == ("rel_tol_why" in record), record["path"]
