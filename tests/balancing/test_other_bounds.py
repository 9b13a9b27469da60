"""A rotor with another bound is read as its whole file would be, without reading again what was measured."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from vibopt.balancing.rotor_job import RotorJob
from vibopt.document.mistakes import Mistakes
from vibopt.document.toml_reading import changed
from vibopt.jobs import facts, of_document, open_job, with_changes

FILES = sorted((Path(__file__).parents[2] / "problems" / "balancing").glob("*.toml"))
BOUNDS = ("limits.", "planes.", "goal.", "scatter.", "rotor.", "quality.", "runs.", "sensors.")
SAME = (
    "planes", "sensors", "speeds", "speed_units", "residual_limits", "correction_limits", "goal", "scatter", "notes",
    "pairs", "influence", "rotor_mass", "quality", "has_phase",
)  # fmt: skip


@pytest.mark.parametrize("file", FILES, ids=[one.stem for one in FILES])
def test_a_job_with_another_number_is_what_its_whole_document_says(file: Path) -> None:
    job = open_job(file)
    if not isinstance(job, RotorJob) or not job.runs:
        return
    for fact in [one for one in facts(job) if one.path.startswith(BOUNDS) and one.dimension != "count"]:
        changes = fact.changes(0.999 * fact.value)
        here = with_changes(job, changes)
        assert isinstance(here, RotorJob)
        whole = of_document(here.document, Mistakes(job.name, None))
        assert isinstance(whole, RotorJob)
        assert [getattr(here, key) for key in SAME] == [getattr(whole, key) for key in SAME], fact.path
        for one, other in zip(here.runs, whole.runs, strict=True):
            np.testing.assert_array_equal(one.readings, other.readings)
            np.testing.assert_array_equal(one.weights, other.weights)
            assert (one.name, one.fitted, one.speed) == (other.name, other.fitted, other.speed)
        if fact.path.startswith("limits."):
            assert here.runs is job.runs or job.pairs


def test_what_was_measured_is_read_again_where_it_is_new() -> None:
    job = open_job(FILES[[one.stem for one in FILES].index("foiles_min_max_capped")])
    assert isinstance(job, RotorJob)
    again = with_changes(job, {"runs.1.name": "anew"})
    assert again.runs is not job.runs
    assert again.runs[0].name == "anew"
    assert changed(job.document, {}) == job.document
