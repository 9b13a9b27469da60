"""Every answer that is not proven says how far the best may be, or in words why that is not known."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import pytest

from vibopt.program.pose import pose
from vibopt.program.program import Program
from vibopt.scene.read import from_dict
from vibopt.solve.boundable import refusal, with_reason
from vibopt.solve.method import Found
from vibopt.solve.ranges import closed
from vibopt.solve.solve import solve

OWN = {
    "mass": "2 kg",
    "frequency": {"from": "8 Hz", "to": "12 Hz"},
    "damping_ratio": {"from": 0.01, "to": 0.6},
}
TWO: dict[str, Any] = {
    "title": "t",
    "bodies": {"host": {"mass": "100 kg"}},
    "links": {"mount": {"between": ["host", "ground"], "stiffness": "400 kN/m", "damping": "100 N s/m"}},
    "absorbers": {"a": {"on": "host", **OWN}, "b": {"on": "host", **OWN}},
    "excitations": {"e": {"kind": "force", "on": "host", "amplitude": "100 N", "speed": "4 Hz..30 Hz"}},
    "goal": {"minimise": "displacement", "of": "host"},
}


def changed(**values: Any) -> Program:
    """The two absorbers with other entries, by their paths with double underscores."""
    document = copy.deepcopy(TWO)
    for path, value in values.items():
        at = document
        *steps, last = path.split("__")
        for step in steps:
            at = at[step]
        at[last] = value
    return closed(pose(from_dict(document)))


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({}, ""),
        (
            {f"absorbers__{one}__frequency": {"one_of": ["8 Hz", "9 Hz"]} for one in "ab"}
            | {f"absorbers__{one}__damping_ratio": 0.1 for one in "ab"},
            "all that may be chosen is listed: combinations are compared with each other",
        ),
        (
            {"links__mount__stiffness": {"from": "1 kN/m"}},
            "the range of links.mount.stiffness has no end: write one",
        ),
        (
            {"absorbers__b__mass": {"from": "0 kg", "to": "3 kg"}},
            "the range of absorbers.b.mass begins at zero: begin it above",
        ),
        (
            {"absorbers__b__damping_ratio": {"from": 0, "to": 1}},
            "",
        ),
        (
            {"absorbers__b__on": "a"}
            | {f"absorbers__{one}": {"on": below, **OWN} for one, below in ("cb", "dc", "ed")},
            "10 numbers are open, and bounds are known of up to 6",
        ),
        (
            {"goal": {"maximise": "decay_rate"}},
            "the goal is a decay rate: of up to three variables and six coordinates, held or free, poles have bounds",
        ),
        (
            {"excitations__f": TWO["excitations"]["e"], "goal__combine": "sum"},
            "the goal counts several harmonics or excitations, and bounds are known of one",
        ),
    ],
)
def test_what_boxes_do_not_bound_is_said(values: dict[str, Any], words: str) -> None:
    program = changed(**values)
    assert program.aim is not None
    assert refusal(program, program.aim.pieces) == words


def test_a_bound_that_says_next_to_nothing_is_called_so() -> None:
    """Within a factor of three a bound stands as it is; of an answer that is proven nothing is said."""
    program = changed()
    x = np.sqrt(program.low * program.high)
    assert program.aim is not None
    value = program.aim.form.value(program.aim.model, x)
    for part, useful in ((1.0, True), (0.4, True), (0.3, False), (np.nan, False), (-1.0, False)):
        told = with_reason(program, Found("feasible", x, "found", "nlp", bound=part * value), "not asked").claim
        assert told == ("found" if useful else "found; no useful bound: not asked")
    assert with_reason(program, Found("optimal", x, "proven", "nlp")).claim == "proven"
    least = Found("feasible", x, "found", "nlp")
    assert with_reason(program, least).claim == "found; no useful bound: boxes of all variables leave too much open"


def test_a_method_that_is_asked_for_answers_alone() -> None:
    found = solve(from_dict(TWO), method="nlp", explain=False)
    assert found.status == "feasible"
    assert " above what any passive device of the same mass could reach" in found.claim
    document = TWO | {"goal": {"minimise": "stroke", "of": "a"}}
    found = solve(from_dict(document), method="nlp", explain=False)
    assert found.claim.endswith("; no useful bound: a method that is asked for by its name answers alone")
