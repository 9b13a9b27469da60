"""Dampers from next to nothing to a thousand times critical, pulses from a millionth of a period to a million."""

from __future__ import annotations

import math
from typing import Any

import mpmath
import numpy as np
import pytest

import vibopt as vo
from vibopt.mechanics.panels import greatest
from vibopt.verify.states import States

RATIOS = (0.0, 1e-6, 1e-3, 0.05, 1.0, 50.0, 1e3)
SHAPES = ("half sine", "versed sine", "sine", "triangle")
ALWAYS = ("peak_relative_displacement", "peak_force")
SOMEWHERE = ("peak_displacement", "peak_velocity", "peak_acceleration")


def machine(seed: int) -> dict[str, Any]:
    """Two bodies on a base that a pulse moves to and fro, or of which one is pushed; now and then one is held, too."""
    rng = np.random.default_rng(seed)
    document: dict[str, Any] = {"title": "extreme", "bases": {"base": {}}, "bodies": {}, "links": {}, "measures": {}}
    below, rate = "base", 10.0 ** rng.uniform(0.0, 2.0)
    for name in ("low", "high"):
        mass, ratio = 10.0 ** rng.uniform(0.0, 2.0), float(rng.choice(RATIOS))
        stiffness = mass * rate**2 * 10.0 ** rng.uniform(-0.5, 0.5)
        damping = {"damping": f"{2.0 * ratio * math.sqrt(stiffness * mass)!r} N s/m"} if ratio else {}
        document["bodies"][name] = {"mass": f"{mass!r} kg"}
        document["links"][f"under_{name}"] = {"between": [name, below], "stiffness": f"{stiffness!r} N/m", **damping}
        document["measures"] |= {f"{response} {name}": {"response": response, "of": name} for response in SOMEWHERE}
        document["measures"] |= {
            f"{one} {name}": {"response": one, ("through" if one == "peak_force" else "across"): f"under_{name}"}
            for one in ALWAYS
        }
        below = name
    if rng.random() < 0.4:
        held = {"stiffness": f"{30.0 * rate**2!r} N/m", "damping": f"{3.0 * rate!r} N s/m"}
        document["links"]["stay"] = {"between": ["low", "ground"], **held}
    lasts = 2.0 * np.pi / rate * 10.0 ** rng.uniform(-6.0, 3.0)
    pushed = {"on": "base", "displacement": "3 mm"} if rng.random() < 0.6 else {"on": "high", "amplitude": "20 N"}
    pulse = {"kind": "pulse", "shape": str(rng.choice(SHAPES)), "duration": f"{lasts!r} s", **pushed}
    document["excitations"] = {"blow": pulse}
    return document


@pytest.mark.parametrize("seed", [5, 12, 37, 43, 77, 113, 161, 190, 224, 342, 514])
def test_extreme_machines_have_one_answer_on_both_routes(seed: int) -> None:
    answer = vo.solve(vo.from_dict(machine(seed)))
    assert answer.status == "met", answer.claim


def test_what_creeps_for_long_is_followed_to_its_top_by_both_routes(monkeypatch: pytest.MonkeyPatch) -> None:
    """A mass drawn along by a soft spring against a heavy damper is farthest when all that swings has long faded.

    Of the hundreds of thousands of steps until then few are looked at.
    """
    looked, read = [0], States.read
    monkeypatch.setattr(States, "read", lambda self, at, *more: looked.append(at.shape[1]) or read(self, at, *more))
    k, c, low, high, push = 200.0, 2e4, 3e4, 30.0, 50.0 * 0.02 * 2.0 / np.pi
    document = {
        "title": "creeps",
        "bodies": {"low": {"mass": "3 kg"}, "high": {"mass": "2 kg"}},
        "links": {
            "seat": {"between": ["low", "ground"], "stiffness": f"{high} N/m", "damping": f"{low} N s/m"},
            "spring": {"between": ["high", "low"], "stiffness": f"{k} N/m"},
            "brake": {"between": ["high", "ground"], "damping": f"{c} N s/m"},
        },
        "excitations": {
            "blow": {"kind": "pulse", "on": "low", "shape": "half sine", "amplitude": "50 N", "duration": "20 ms"}
        },
        "measures": {"place": {"response": "peak_displacement", "of": "high"}},
    }
    answer = vo.solve(vo.from_dict(document))
    assert answer.status == "met", answer.claim
    assert sum(looked) < 100_000, sum(looked)
    rates = np.linalg.eigvals([[-(high + k) / low, k / low], [k / c, -k / c]])  # nothing has mass that long after
    times = np.geomspace(1.0, 1e5, 100_001)
    alone = np.abs(np.exp(rates[0] * times) - np.exp(rates[1] * times)) * (push / low) * (k / c) / abs(np.ptp(rates))
    assert answer.measures["place"].value.value == pytest.approx(alone.max(), rel=1e-3)


@pytest.mark.parametrize("creep", [1e-3, 1e-5, 1e-7])
@pytest.mark.parametrize("fast", [3e3, 1e5])
def test_what_creeps_along_a_line_keeps_its_digits(creep: float, fast: float) -> None:
    """Where a straight line would hold what creeps is far beyond where it gets to: it is not counted from there."""
    a = np.array([[-creep, 1.0, 0.0, 0.0], [0.0, -fast, fast, 0.0], [0.0, 0.0, 0.0, 1.0], [0.0] * 4])
    start, row = np.array([0.3, 0.0, 2.0, 5.0]), np.array([1.0, 0.0, 0.0, 0.0])
    with mpmath.workdps(30):
        last = mpmath.expm(mpmath.matrix(a.tolist())) * mpmath.matrix(start.tolist())
    found = greatest(a[None], row[None], start[None, None])
    assert found.value[0] == pytest.approx(float(last[0]), rel=1e-10)
    assert found.at[0] == 1.0
