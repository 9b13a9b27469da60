"""What is bounded or shown in rms or pp where several harmonics act: what fits, and words for what does not."""

from __future__ import annotations

import math
from typing import Any

import pytest

import vibopt as vo
from refusals import refused

RMS = 'the rms of several harmonics is their root of sum of squares. Write combine = "rss".'
SWING = "with several harmonics the swing is not twice the peak. Write the {} in pk."
FAN: dict[str, Any] = {
    "bodies": {"fan": {"mass": "100 kg"}},
    "links": {"mount": {"between": ["fan", "ground"], "stiffness": "400 kN/m", "damping": "500 N s/m"}},
    "excitations": {
        "shaking": {
            "kind": "harmonics", "on": "fan", "speed": "600 rpm",
            "harmonics": [{"order": 1, "amplitude": "141 N"}, {"order": 2, "amplitude": "100 N", "phase": "40 deg"}],
        }
    },
}  # fmt: skip


def asked(family: str, **words: str) -> dict[str, Any]:
    question = {"response": "velocity", "of": "fan", **words}
    return {**FAN, family: {"v": question}}


@pytest.mark.parametrize("what", ["bound", "unit"])
@pytest.mark.parametrize(
    ("detector", "combine", "words"),
    [("rms", "peak", RMS), ("rms", "sum", RMS), ("pp", "peak", SWING), ("pp", "rss", SWING)],
)
def test_what_several_harmonics_do_not_have_is_refused(what: str, detector: str, combine: str, words: str) -> None:
    bound = {"at_most": f"9 mm/s {detector}"} if what == "bound" else {"unit": f"mm/s {detector}"}
    family = "limits" if what == "bound" else "measures"
    said = refused(vo.from_dict, asked(family, combine=combine, **bound), name="fan.toml").messages
    beginning = f'fan.toml: {family}.v.combine = "{combine}" does not fit a {what} in {detector}: '
    assert said == (f"{beginning}{words.format(what)}",) or list(said) == [f"{beginning}{words.format(what)}"]


def test_a_goal_in_rms_is_no_peak() -> None:
    document = {**FAN, "links": {"mount": {**FAN["links"]["mount"], "damping": {"from": "1 N s/m", "to": "9 N s/m"}}}}
    document["goal"] = {"minimise": "velocity", "of": "fan", "combine": "peak", "unit": "mm/s rms"}
    said = refused(vo.from_dict, document, name="fan.toml").messages
    assert said[0] == f'fan.toml: goal.combine = "peak" does not fit a unit in rms: {RMS}'


def test_the_rms_that_is_shown_is_the_root_of_the_sum_of_squares() -> None:
    omega = 20.0 * math.pi
    sizes = [
        amplitude * k * omega / abs(4e5 - 100.0 * (k * omega) ** 2 + 500j * k * omega)
        for k, amplitude in ((1, 141.0), (2, 100.0))
    ]
    row = vo.solve(vo.from_dict(asked("measures", combine="rss", unit="mm/s rms"))).measures["v"].value
    rms = math.hypot(*sizes) / math.sqrt(2.0)
    assert row.shown == f"{1e3 * rms:.4g} mm/s rms"
