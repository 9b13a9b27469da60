"""find_all: a hundred thousand sampled speeds agree with the set, and its ends lie on a bound."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from refusals import refused
from vibopt.scene.read import from_dict
from vibopt.scene.scene import Design
from vibopt.solve import solve

few = settings(derandomize=True, database=None, deadline=None, max_examples=25)
NATURAL = 10.0


def power(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high).map(lambda e: float(10.0**e))


def asked(zeta: float, ratio: float, stroke: float, side: str, *, top: float = 50.0) -> Design:
    """1 kg on 100 N/m under 1 N; limits on transmissibility and on displacement."""
    document = {
        "title": "speeds",
        "bodies": {"body": {"mass": "1 kg"}},
        "links": {"link": {"between": ["body", "ground"], "stiffness": "100 N/m", "damping_ratio": zeta}},
        "excitations": {
            "e": {
                "kind": "force", "on": "body", "amplitude": "1 N", "varies": "constant",
                "speed": {"from": "0 rad/s", "to": f"{top} rad/s"},
            }
        },
        "limits": {
            "force": {"response": "transmissibility", "into": "ground", "at_most": ratio},
            "stroke": {"response": "displacement", "of": "body", side: f"{stroke!r} m"},
        },
        "goal": {"find_all": "e.speed"},
    }  # fmt: skip
    return solve(from_dict(document))


@given(zeta=power(-4, 0), ratio=power(-1, 1.5), stroke=power(-3.5, -0.5), side=st.sampled_from(["at_most", "at_least"]))
@few
def test_sampled_speeds_agree_with_the_set(zeta: float, ratio: float, stroke: float, side: str) -> None:
    design = asked(zeta, ratio, stroke, side)
    near = NATURAL * (1 + np.concatenate([-np.logspace(-9, -1, 500), np.logspace(-9, -1, 500)]))
    speeds = np.concatenate([np.linspace(0.0, 50.0, 100_001), near])
    below = np.hypot(100.0 - speeds**2, 20.0 * zeta * speeds)
    carried = np.hypot(100.0, 20.0 * zeta * speeds) / below
    moved = 1.0 / below
    good = (carried <= ratio) & (moved <= stroke if side == "at_most" else moved >= stroke)
    inside = np.zeros(len(speeds), dtype=bool)
    ends = [end.value for pair in design.found or () for end in pair]
    for low, high in design.found or ():
        inside |= (speeds >= low.value) & (speeds <= high.value)
    far = np.array([all(abs(one - end) > 2e-9 * one for end in ends) for one in speeds[good != inside]])
    assert not far.any()
    for end in ends:
        if 0.0 < end < 50.0:
            there = np.hypot(100.0 - end**2, 20.0 * zeta * end)
            off = min(abs(np.hypot(100.0, 20.0 * zeta * end) / there / ratio - 1), abs(1.0 / there / stroke - 1))
            assert off <= 1e-8


def document(limit: dict[str, Any], **shaking: Any) -> dict[str, Any]:
    """1 kg on 100 N/m, damping ratio 0.1, under 1 N."""
    return {
        "bodies": {"body": {"mass": "1 kg"}},
        "links": {"link": {"between": ["body", "ground"], "stiffness": "100 N/m", "damping_ratio": 0.1}},
        "excitations": {
            "e": {
                "kind": "force", "on": "body", "amplitude": "1 N", "varies": "constant",
                "speed": {"from": "2 rad/s", "to": "50 rad/s"}, **shaking,
            }
        },
        "limits": {"asked": limit},
        "goal": {"find_all": "e.speed"},
    }  # fmt: skip


@pytest.mark.parametrize("over", ["start-up", {"e": "start-up"}])
@given(stroke=power(-3.5, -0.5), side=st.sampled_from(["at_most", "at_least"]))
@few
def test_a_start_up_ends_at_the_speed_that_is_looked_for(over: Any, stroke: float, side: str) -> None:
    design = solve(from_dict(document({"response": "displacement", "of": "body", "over": over, side: f"{stroke!r} m"})))
    speeds = np.linspace(0.0, 50.0, 100_001)
    moved = 1.0 / np.hypot(100.0 - speeds**2, 2.0 * speeds)
    good = (moved <= stroke if side == "at_most" else moved >= stroke).cumprod()
    last = speeds[max(int(good.sum()) - 1, 0)]
    if last < 2.0:
        assert (design.status, design.found) == ("infeasible", ())
        return
    ((low, high),) = design.found or ()
    assert low.value == 2.0
    assert high.value == pytest.approx(last, abs=6e-4)


def test_orders_and_run_ups_of_each_speed_are_refused() -> None:
    bands = {"response": "natural_frequency", "outside": {"orders": [1, 2], "of": "e", "margin": "10 %"}}
    peak = {"response": "peak_displacement", "of": "body", "at_most": "20 mm"}
    run_up = {"run_up": {"acceleration": "5 rad/s2"}}
    for asked_for, what in ((document(bands), "orders"), (document(peak, **run_up), "run-ups")):
        assert refused(from_dict, asked_for).messages == (
            f"scene: goal.find_all looks for speeds of e, but limits.asked looks at {what} of each by itself. Leave "
            "the goal out, and look at one speed after the other: vibopt sweep FILE --vary "
            'excitations.e.speed="1000..2000 rpm".',
        )


def test_no_speed_at_all_is_infeasible() -> None:
    design = asked(0.1, 1e-3, 1e-3, "at_most")
    assert (design.status, design.found) == ("infeasible", ())


def test_every_speed_is_one_interval_with_the_ends_of_the_range() -> None:
    design = asked(0.5, 100.0, 100.0, "at_most")
    assert [(low.value, high.value) for low, high in design.found or ()] == [(0.0, 50.0)]


def test_a_speed_that_only_touches_its_bound_belongs_to_the_set() -> None:
    """At least the peak itself: F / (2 k zeta sqrt(1 - zeta^2)) at w0 sqrt(1 - 2 zeta^2)."""
    zeta = 0.1
    peak = 0.01 / (2 * zeta * np.sqrt(1 - zeta**2)) * (1 - 1e-13)
    design = asked(zeta, 100.0, float(peak), "at_least")
    (pair,) = design.found or ()
    assert pair[0].value == pytest.approx(NATURAL * np.sqrt(1 - 2 * zeta**2), rel=1e-6)
    assert pair[1].value == pytest.approx(pair[0].value, rel=1e-6)


@pytest.mark.parametrize("side", ["at_most", "at_least"])
def test_stress_of_weight_and_whirl_together_is_that_of_the_whirl_under_a_bound_less_the_weight(side: str) -> None:
    document = {
        "title": "a fan on its beam",
        "bodies": {"fan": {"mass": "40 kg"}},
        "links": {
            "beam": {
                "between": ["fan", "ground"],
                "beam": {"kind": "simply_supported", "length": "1 m", "modulus": "207 GPa", "diameter": "40 mm"},
                "damping": "60 N s/m",
            }
        },
        "excitations": {
            "e": {
                "kind": "force", "on": "fan", "amplitude": "50 N", "varies": "constant",
            }
        },
    }  # fmt: skip
    own = {"still": {"response": "static_bending_stress", "of": "beam"}}
    alone = {key: value for key, value in document.items() if key != "excitations"}
    weight = solve(from_dict({**alone, "measures": own})).measures["still"].value.value
    both = []
    for response, bound in (("combined_bending_stress", 2.0 * weight), ("bending_stress", weight)):
        limits = {"stress": {"response": response, "of": "beam", side: f"{bound!r} Pa"}}
        document["excitations"]["e"]["speed"] = {"from": "10 rad/s", "to": "400 rad/s"}
        design = solve(from_dict({**document, "limits": limits, "goal": {"find_all": "e.speed"}}))
        both.append([end.value for one in design.found for end in one])
        document["excitations"]["e"]["speed"] = "10..400 rad/s"
        assert solve(from_dict({**document, "limits": limits})).status == "violated"
    assert len(both[0]) == (4 if side == "at_most" else 2)
    assert both[0] == pytest.approx(both[1], rel=1e-9)
