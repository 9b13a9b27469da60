"""Numbers of balancing files by their paths: each can be named, varied and read back."""

from __future__ import annotations

from math import isclose
from pathlib import Path

import pytest

from refusals import refused
from vibopt.jobs import fact_at, facts, from_text, open_job, with_changes

FILES = sorted((Path(__file__).parents[2] / "problems" / "balancing").glob("*.toml"))
ROTOR = """
[conventions]
phase = "lag"
readings = "phase"
angles = "against rotation"
detector = "pp"
zero = "tape"
[planes.left]
radius = ["140 mm", "150 mm"]
forbidden = ["80..110 deg"]
[sensors.a]
unit = "mil"
[[runs]]
speed = "1200 rpm"
readings = { a = "8.6 @ 63 deg" }
[[runs]]
speed = "1200 rpm"
weights = { left = "10 g at 140 mm @ 270 deg" }
readings = { a = "5.9 mil @ 123 deg" }
[[influence]]
sensor = "a"
plane = "left"
value = "0.43 mil pp/(g mm) @ 120 deg"
"""


@pytest.mark.parametrize("file", FILES, ids=lambda one: one.stem)
def test_every_number_of_a_file_is_found_by_its_path_and_is_what_it_was_when_written_back(file: Path) -> None:
    job = open_job(file)
    known = list(facts(job))
    assert len({one.path for one in known}) == len(known) > 0
    for one in known[:: max(1, len(known) // 8)]:
        assert fact_at(job, one.path) == one
        same = with_changes(job, {one.path: one.text(one.value)})
        assert isclose(fact_at(same, one.path).value, one.value, rel_tol=1e-14, abs_tol=1e-300)
        others = {at.path: at.value for at in facts(same)}
        assert all(isclose(others[at.path], at.value, rel_tol=1e-14, abs_tol=1e-300) for at in known)


@pytest.mark.parametrize(
    ("path", "value", "unit"),
    [
        ("planes.left.radius.2", 0.15, "mm"),
        ("planes.left.forbidden.1.to", 1.9198621771937625, "deg"),
        ("runs.1.readings.a.amplitude", 8.6, ""),
        ("runs.2.readings.a.amplitude", 0.5 * 5.9 * 25.4e-6, "mil pp"),
        ("runs.2.readings.a.angle", 2.1467549799530254, "deg"),
        ("runs.2.weights.left.mass", 0.01, "g"),
        ("runs.2.weights.left.radius", 0.14, "mm"),
        ("runs.2.weights.left.angle", 4.71238898038469, "deg"),
        ("influence.1.value.amount", 0.43, ""),
        ("influence.1.value.angle", 2.0943951023931953, "deg"),
    ],
)
def test_each_number_of_a_text_has_a_path_of_its_own(path: str, value: float, unit: str) -> None:
    found = fact_at(from_text(ROTOR), path)
    assert (found.value, found.unit) == (pytest.approx(value, rel=1e-14), unit)


def test_numbers_of_one_text_are_changed_one_after_the_other() -> None:
    job = from_text(ROTOR)
    changed = with_changes(job, {"runs.2.readings.a.angle": "125 deg", "runs.2.readings.a.amplitude": "6 mil"})
    assert changed.document["runs"][1]["readings"]["a"] == "6 mil @ 125 deg"
    assert job.document["runs"][1]["readings"]["a"] == "5.9 mil @ 123 deg"


@pytest.mark.parametrize(
    ("path", "message"),
    [
        (
            "runs.2.readings.a",
            "runs.2.readings.a holds 2 numbers. Name one: runs.2.readings.a.amplitude or runs.2.readings.a.angle.",
        ),
        ("planes.left.forbiden.1.to", "there is no fact called planes.left.forbiden.1.to. Did you mean "
         '"planes.left.forbidden.1.to"?'),
    ],
)  # fmt: skip
def test_a_path_that_is_no_number_is_answered_with_those_there_are(path: str, message: str) -> None:
    assert str(refused(lambda: fact_at(from_text(ROTOR), path))) == message
