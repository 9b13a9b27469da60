"""What is made least in time on one machine, while springs and dampers of another beside it are chosen."""

from __future__ import annotations

from typing import Any

import pytest

import vibopt as vo

PULSE: dict[str, Any] = {"kind": "pulse", "shape": "half sine", "amplitude": "400 N"}
MOUNT = {"stiffness": "100 kN/m", "damping": "1 kN s/m"}
OPEN = {"stiffness": {"from": "1 kN/m", "to": "1 MN/m"}, "damping": {"from": "20 N s/m", "to": "70 kN s/m"}}


@pytest.mark.parametrize(
    "load",
    [
        {**PULSE, "duration": "8 ms"},
        {"kind": "unbalance", "unbalance": "0.1 kg m", "speed": "100 rad/s",
         "run_up": {"to": "100 rad/s", "duration": "4 s"}},
    ],
    ids=["pulse", "run-up"],
)  # fmt: skip
def test_what_nothing_chosen_moves_is_as_it_is(load: dict[str, Any]) -> None:
    """Proven the least, and what it is without any choice."""
    felt = {"response": "peak_acceleration", "of": "other", "due_to": ["load"]}
    document: dict[str, Any] = {
        "title": "side by side",
        "bodies": {"one": {"mass": "26 kg"}, "other": {"mass": "99 kg"}},
        "links": {
            "under_one": {"between": ["one", "ground"], **OPEN},
            "under_other": {"between": ["other", "ground"], **MOUNT},
        },
        "excitations": {"load": {"on": "other", **load}, "beside": {**PULSE, "on": "one", "duration": "8 ms"}},
        "goal": {"minimise": felt["response"], "of": "other", "due_to": ["load"]},
    }
    least = vo.solve(vo.from_dict(document))
    assert least.status == "optimal", least.claim
    document["links"]["under_one"] |= MOUNT
    del document["goal"]
    alone = vo.solve(vo.from_dict(document | {"measures": {"felt": felt}}))
    assert least.goal is not None
    assert least.goal[1].value == pytest.approx(alone.measures["felt"].value.value, rel=1e-7)
