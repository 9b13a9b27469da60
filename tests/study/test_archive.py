"""Kept answers: what counts as the same answer on another machine, and what does not."""

import json
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from refusals import refused
from vibopt.errors import InputError
from vibopt.study.archive import CLOSE, DIFFERS, EQUAL, Comparison, archive_text, compared, read_archive

ANSWER: dict[str, Any] = {
    "status": "optimal",
    "claim": "none of the 1234 choices is better; put back into a simulated rotor, which shows the same to 3e-16",
    "goal": {"name": "residual", "value": 5.8e-20, "unit": "m", "shown": "5.8e-17 mm pk"},
    "variables": {
        "links.mount.stiffness": {"value": 6956917.2, "unit": "N/m", "shown": "6957 kN/m"},
        "planes.left.angle": {"value": 0.0, "unit": "rad", "shown": "0 deg"},
    },
    "limits": {
        "sag": {"value": 0.02, "unit": "m", "margin": 1e-15, "worst_at": {"press": {"value": 103.2, "unit": ""}}}
    },
    "choices": [{"part": "S60"}, {"part": "S70"}],
    "details": {"exact measurements": 1705},
}


def beside(now: dict[str, Any], *, changed: bool = False) -> Comparison:
    """The answer above, and another."""
    digest = {"a.toml": "0" if changed else "1"}
    return compared("a.toml", {"sha256": {"a.toml": "1"}, "answer": ANSWER}, {"sha256": digest, "answer": now})


def altered(path: str, value: Any) -> dict[str, Any]:
    """The answer with one entry changed; names of variables hold points, so steps are parted by bars."""
    new = deepcopy(ANSWER)
    *steps, last = path.split("|")
    here: Any = new
    for step in steps:
        here = here[step]
    here[last] = value
    return new


def test_the_same_answer_is_byte_equal_and_a_changed_file_is_said() -> None:
    assert beside(deepcopy(ANSWER)) == Comparison("a.toml", EQUAL)
    said = beside(deepcopy(ANSWER), changed=True)
    assert said.words == "byte-equal; the problem file or a file that it names has changed since"


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        (
            "variables|links.mount.stiffness|value",
            6956917.2 * (1 + 2e-12),
            "equal to 1e-9 (largest difference 2e-12 at variables.links.mount.stiffness.value)",
        ),
        ("goal|value", 1.1e-19, "equal to 1e-9 (largest difference 2.6e-18 at goal.value)"),
        ("goal|shown", "1.1e-16 mm pk", "equal to 1e-9"),
        ("limits|sag|margin", -3e-15, "equal to 1e-9 (largest difference 4e-15 at limits.sag.margin)"),
        ("variables|planes.left.angle|value", 6.283185307179586, "equal to 1e-9"),
        ("claim", ANSWER["claim"].replace("3e-16", "8e-16"), "equal to 1e-9"),
        ("details", {"exact measurements": 1710}, "equal to 1e-9"),
    ],
)
def test_rounding_of_another_machine_is_the_same_answer(path: str, value: Any, words: str) -> None:
    assert beside(altered(path, value)).words == words


@pytest.mark.parametrize(
    ("path", "value", "difference"),
    [
        ("status", "feasible", 'status: "feasible" instead of "optimal"'),
        (
            "variables|links.mount.stiffness|value",
            6956917.3,
            "variables.links.mount.stiffness.value: 6956917.3 instead of 6956917.2, difference 1.4e-08",
        ),
        ("goal|value", 5e-11, "goal.value: 5e-11 instead of 5.8e-20, difference 1"),
        ("goal|value", None, "goal.value: null instead of 5.8e-20"),
        ("limits|sag|value", "infinite", 'limits.sag.value: "infinite" instead of 0.02'),
        ("goal|name", "correction", 'goal.name: "correction" instead of "residual"'),
        ("goal|shown", "5.8e-17 mm rms", 'goal.shown: "5.8e-17 mm rms" instead of "5.8e-17 mm pk"'),
        ("choices", [{"part": "S70"}, {"part": "S60"}], 'choices.1.part: "S70" instead of "S60"'),
        ("choices", [{"part": "S60"}], 'choices: [{"part": "S60"}] instead of [{"part": "S60"}, {"part": "S70"}]'),
        ("reason", "", "reason: was not there"),
        ("limits|sag|margin", 2e-9, "limits.sag.margin: 2e-09 instead of 1e-15, difference 2e-09"),
    ],
)
def test_another_answer_is_told(path: str, value: Any, difference: str) -> None:
    found = beside(altered(path, value))
    assert (found.verdict, found.differences[0]) == (DIFFERS, difference)


def test_a_claim_that_counts_something_else_is_another_claim() -> None:
    found = beside(altered("claim", ANSWER["claim"].replace("1234", "1235")))
    assert found.verdict == DIFFERS


@given(
    st.floats(1e-30, 1e30),
    st.floats(-8.0, -7e-14).map(lambda e: 10.0**e) | st.floats(-15.0, -9.5).map(lambda e: 10.0**e),
)
def test_a_number_is_the_same_up_to_1e_9_of_itself(value: float, part: float) -> None:
    kept = {"sha256": {}, "answer": {"x": value}}
    found = compared("a", kept, {"sha256": {}, "answer": {"x": value * (1.0 + part)}})
    near = value * (1.0 + part) == value
    assert found.verdict == (EQUAL if near else CLOSE if part < 1e-9 else DIFFERS)


def test_an_answer_that_was_not_kept_or_is_not_there_now_differs() -> None:
    kept = {"sha256": {}, "answer": ANSWER}
    assert compared("a", None, kept).differences == ("no answer of it was kept.",)
    assert compared("a", kept, None).differences == ("it has no answer now.",)


def test_kept_answers_are_read_as_they_were_written(tmp_path: Path) -> None:
    answers = {"b.toml": {"sha256": {"b.toml": "12"}, "answer": ANSWER}, "a.toml": {"sha256": {}, "answer": {"x": 0.1}}}
    text = archive_text(answers)
    assert text == archive_text(dict(reversed(answers.items())))
    file = tmp_path / "kept.json"
    file.write_text(text, encoding="utf-8")
    assert read_archive(file)["answers"] == answers


@pytest.mark.parametrize(
    "text", ["", "[1]", '{"kept_by": "me", "answers": {}}', '{"kept_by": "vibopt verify", "answers": 1}', "[" * 9000]
)
def test_what_vibopt_did_not_write_is_no_archive(tmp_path: Path, text: str) -> None:
    file = tmp_path / "other.json"
    file.write_text(text)
    assert str(refused(read_archive, file)) == (
        f"{file} holds no answers kept by vibopt. Write them with vibopt verify PATH... --save {file}."
    )


def test_an_archive_that_is_not_there_is_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none\.json is not there"):
        read_archive(tmp_path / "none.json")


def test_an_archive_that_was_changed_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "kept.json"
    file.write_text(archive_text({"a.toml": {"sha256": {}, "answer": {"x": 0.1}}}).replace("0.1", "0.2"))
    with pytest.raises(InputError, match="has been changed since vibopt wrote it"):
        read_archive(file)


def test_what_is_kept_is_strict_json(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="not JSON compliant"):
        archive_text({"a": {"answer": {"x": float("nan")}}})
    assert json.loads(archive_text({}))["kept_by"] == "vibopt verify"


@pytest.mark.parametrize(("off", "verdict"), [(1e-8, CLOSE), (1e-5, DIFFERS)])
def test_the_speed_of_a_flat_peak_may_differ_by_more_than_its_height(off: float, verdict: str) -> None:
    def kept(speed: float) -> dict[str, Any]:
        at = {"fan": {"value": speed, "unit": "rad/s", "shown": "12.4 rad/s"}}
        return {"sha256": {}, "answer": {"limits": {"comfort": {"value": 1.0, "unit": "m", "worst_at": at}}}}

    assert compared("a.toml", kept(12.4), kept(12.4 * (1.0 + off))).verdict == verdict
