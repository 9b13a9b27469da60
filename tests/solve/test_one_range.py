"""One variable is always decided: against dense sampling of the machine as built, by plain matrices."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vibopt.scene.read import from_dict
from vibopt.solve import solve

MASS, UPPER = 100.0, 40.0
RANGES = {
    "k": (2e3, 2e6, "N/m"),
    "c": (5.0, 2e4, "N s/m"),
    "m": (20.0, 500.0, "kg"),
    "zeta": (0.005, 0.9, ""),
    "tuning": (0.4, 1.6, ""),
}
DENSITY = 100.0
"""Of the force on the lower body [N^2/Hz]."""
KINDS = ("rms_displacement", "rms_velocity", "rms_force", "decay_rate", "damping_ratio", "natural_frequency")


def _document(variable: str, given_: Any) -> dict[str, Any]:
    """A machine under noise with a smaller mass on it; one of its numbers is `given_`."""
    mount: dict[str, Any] = {"between": ["low", "ground"], "stiffness": "90 kN/m", "damping": "400 N s/m"}
    absorber = {"on": "low", "mass": "5 kg", "tuning": 0.95, "damping_ratio": 0.1}
    low: dict[str, Any] = {"mass": "100 kg"}
    if variable in ("k", "c"):
        mount["stiffness" if variable == "k" else "damping"] = given_
    elif variable == "m":
        low["mass"] = given_
    else:
        absorber["damping_ratio" if variable == "zeta" else "tuning"] = given_
    return {
        "bodies": {"low": low},
        "links": {"mount": mount},
        "absorbers": {"tmd": absorber},
        "excitations": {"noise": {"kind": "white_noise", "on": "low", "density": "100 N²/Hz"}},
    }


def _asked(kind: str) -> dict[str, Any]:
    place = {"rms_force": {"into": "ground"}} | {key: {"of": "low"} for key in KINDS[:2]}
    return {"response": kind, **place.get(kind, {})}


def _by_hand(variable: str, x: float) -> dict[str, float]:
    """All responses from the state matrix: eigenvalues, and mean squares by adding up residues."""
    k, c, m, zeta, tuning = 90e3, 400.0, 100.0, 0.1, 0.95
    k, c, m, zeta, tuning = (
        x if variable == one else now for one, now in zip(RANGES, (k, c, m, zeta, tuning), strict=True)
    )
    own = tuning * math.sqrt(k / m)
    k2, c2 = 5.0 * own**2, 2.0 * zeta * 5.0 * own
    mass = np.diag([m, 5.0])
    stiff = np.array([[k + k2, -k2], [-k2, k2]])
    dash = np.array([[c + c2, -c2], [-c2, c2]])
    over = np.linalg.inv(mass)
    a = np.block([[np.zeros((2, 2)), np.eye(2)], [-over @ stiff, -over @ dash]])
    b = np.array([0.0, 0.0, 1.0 / m, 0.0])
    rates, right = np.linalg.eig(a)
    left = np.linalg.inv(right)

    def rms(row: np.ndarray[Any, Any]) -> float:
        parts = (row @ right) * (left @ b)
        square = (parts[:, None] * parts[None, :] / -(rates[:, None] + rates[None, :])).sum().real
        return float(math.sqrt(0.5 * DENSITY * square))

    ratios = [-one.real / abs(one) for one in rates if one.imag > 1e-9 * abs(one)]
    return {
        "rms_displacement": rms(np.array([1.0, 0, 0, 0])),
        "rms_velocity": rms(np.array([0, 0, 1.0, 0])),
        "rms_force": rms(np.array([k, 0, c, 0])),
        "decay_rate": float(min(-rates.real)),
        "damping_ratio": float(min([*ratios, 1.0])),
        "natural_frequency": float(math.sqrt(min(np.linalg.eigvals(over @ stiff).real))),
    }


CASES = {
    "variable": st.sampled_from(sorted(RANGES)),
    "goal": st.sampled_from(KINDS[:5]),
    "limits": st.lists(st.sampled_from(KINDS), min_size=2, max_size=3, unique=True),
    "part": st.floats(0.02, 0.98),
    "tight": st.lists(st.sampled_from([0.9, 0.999, 1.0005, 1.1]), min_size=3, max_size=3),
}


@pytest.mark.slow
@given(**CASES)
@settings(derandomize=True, database=None, deadline=None, max_examples=60)
def test_one_variable_is_decided_as_very_dense_sampling_says(
    variable: str, goal: str, limits: list[str], part: float, tight: list[float]
) -> None:
    decided(variable, goal, limits, part, tight, 3001)


@given(**CASES)
@settings(derandomize=True, database=None, deadline=None, max_examples=6)
def test_one_variable_is_decided_as_dense_sampling_says(
    variable: str, goal: str, limits: list[str], part: float, tight: list[float]
) -> None:
    decided(variable, goal, limits, part, tight, 401)


def decided(variable: str, goal: str, limits: list[str], part: float, tight: list[float], samples: int) -> None:
    low, high, unit = RANGES[variable]
    at = _by_hand(variable, low * (high / low) ** part)
    document = _document(variable, {"from": f"{low!r} {unit}".strip(), "to": f"{high!r} {unit}".strip()})
    if not unit:
        document = _document(variable, {"from": low, "to": high})
    bounds: dict[str, tuple[bool, float]] = {}
    units = dict(zip(KINDS, ("m", "m/s", "N", "1/s", "", "rad/s"), strict=True))
    document["limits"] = {}
    for kind, room in zip(limits, tight, strict=False):
        least = kind in ("decay_rate", "damping_ratio")
        bound = at[kind] * (2.0 - room if least else room)
        text = f"{bound!r} {units[kind]}" if units[kind] else min(bound, 0.999)
        document["limits"][kind] = {**_asked(kind), "at_least" if least else "at_most": text}
        bounds[kind] = least, bound
    upward = goal in ("decay_rate", "damping_ratio")
    ask = _asked(goal)
    document["goal"] = {"maximise" if upward else "minimise": ask.pop("response"), **ask}
    design = solve(from_dict(document), explain=False)
    assert design.status in ("optimal", "infeasible"), design.claim
    tried = [_by_hand(variable, float(x)) for x in np.geomspace(low, high, samples)]
    fine = [one for one in tried if all((one[k] >= b) if least else (one[k] <= b) for k, (least, b) in bounds.items())]
    if design.status == "infeasible":
        assert not fine
        return
    assert design.goal is not None
    chosen = _by_hand(variable, design.x[0])
    assert chosen[goal] == pytest.approx(design.goal[1].value, rel=1e-6)
    for kind, (least, bound) in bounds.items():
        assert (chosen[kind] >= bound * (1 - 1e-6)) if least else (chosen[kind] <= bound * (1 + 1e-6))
    values = [one[goal] for one in fine]
    if values:
        best = max(values) if upward else min(values)
        assert (chosen[goal] >= best * (1 - 1e-6)) if upward else (chosen[goal] <= best * (1 + 1e-6))


def test_a_resonance_that_is_narrower_than_any_piece_is_not_overlooked() -> None:
    """A mode of one part in a million of damping may not meet one speed; only a sliver of stiffness is forbidden."""
    document: dict[str, Any] = {
        "bodies": {"a": {"mass": "100 kg"}, "b": {"mass": "10 kg"}},
        "links": {
            "low": {"between": ["a", "ground"], "stiffness": {"from": "10 kN/m", "to": "4 MN/m"}, "damping": "1 N s/m"},
            "high": {"between": ["b", "a"], "stiffness": "1 MN/m", "damping": "0.1 N s/m"},
        },
        "excitations": {"e": {"kind": "force", "on": "a", "amplitude": "1 N", "speed": "100 rad/s"}},
        "limits": {
            "swing": {"response": "displacement", "of": "b", "at_least": "5 mm"},
            "slow": {"response": "decay_rate", "at_least": "0.001 1/s"},
        },
        "goal": {"maximise": "stiffness", "of": "low"},
    }
    design = solve(from_dict(document), explain=False)
    assert design.status == "optimal"
    w, k2 = 100.0, 1e6 + 10j
    follow = k2 / (k2 - 10.0 * w**2)

    def swing(k: float) -> float:
        return float(abs(follow / (k + 100j - 100.0 * w**2 + k2 - k2 * follow)))

    assert swing(design.x[0]) == pytest.approx(5e-3, rel=1e-7)
    assert swing(design.x[0] * (1.0 + 1e-6)) < 5e-3


@pytest.mark.parametrize("bound", ["0.02 mm", "2 mm"])
def test_a_half_open_range_of_one_variable_is_decided_too(bound: str) -> None:
    """Mean square S / (4 c k): with k = 90 kN/m it takes c of at least 100 / (4 k x^2)."""
    document: dict[str, Any] = {
        "bodies": {"m": {"mass": "100 kg"}},
        "links": {"s": {"between": ["m", "ground"], "stiffness": "90 kN/m", "damping": {"from": "1 N s/m"}}},
        "excitations": {"w": {"kind": "white_noise", "on": "m", "density": "100 N²/Hz"}},
        "limits": {"sway": {"response": "rms_displacement", "of": "m", "at_most": bound}},
        "goal": {"minimise": "damping", "of": "s"},
    }
    design = solve(from_dict(document), explain=False)
    assert design.status == "optimal"
    least = 100.0 / (4.0 * 90e3 * (1e-3 * float(bound.split()[0])) ** 2)
    assert design.x[0] == pytest.approx(max(least, 1.0), rel=1e-6)


def struck(**absorber: Any) -> Any:
    """A mass on a spring with an absorber, pushed by half a sine of 50 ms; the least of its greatest motion."""
    return solve(from_dict({
        "title": "t",
        "bodies": {"m": {"mass": "100 kg"}},
        "links": {"s": {"between": ["m", "ground"], "stiffness": "50 kN/m", "damping": "100 N s/m"}},
        "absorbers": {"t": {"on": "m", "mass": "5 kg"} | absorber},
        "excitations": {
            "e": {"kind": "pulse", "shape": "half sine", "on": "m", "amplitude": "1 kN", "duration": "50 ms"}
        },
        "goal": {"minimise": "peak_displacement", "of": "m"},
    }), explain=False)  # fmt: skip


def test_an_open_range_of_what_is_struck_is_as_good_as_a_wide_one() -> None:
    """An absorber however stiff is a mass stuck to the other; its range ended where no motion can be followed."""
    found = struck(frequency={"from": "1 Hz"}, damping_ratio=0.1)
    wide = struck(frequency={"from": "1 Hz", "to": "1 kHz"}, damping_ratio=0.1)
    assert found.status == wide.status == "optimal"
    assert found.goal[1].value == pytest.approx(wide.goal[1].value, rel=2e-6)


@pytest.mark.slow
def test_two_open_ranges_of_what_is_struck_are_as_good_as_wide_ones() -> None:
    """Bounds of what is next to nothing beside rounding are no roots of numbers below zero."""
    found = struck(stiffness={"from": "1 N/m"}, damping={"from": "1 N s/m"})
    wide = struck(stiffness={"from": "1 N/m", "to": "1 MN/m"}, damping={"from": "1 N s/m", "to": "100 kN s/m"})
    assert found.goal[1].value == pytest.approx(wide.goal[1].value, rel=2e-6)


def test_a_goal_that_is_rounding_alone_is_settled_at_once() -> None:
    """Nothing loads the feet across: no value of the spring is better than another, and none is looked for."""
    feet = [[f"{x} m", f"{y} m", "0 m"] for x in (0.8, -0.8) for y in (0.5, -0.5)]
    foot = {"between": ["machine", "ground"], "at": feet, "shear_ratio": 0.62}
    document = {
        "title": "machine whose feet carry nothing across",
        "bodies": {
            "machine": {
                "mass": "2440 kg",
                "centre": ["0.07 m", "0.04 m", "0.25 m"],
                "inertia": ["300 kg m2", "500 kg m2", "600 kg m2"],
            }
        },
        "mounts": {"foot": {**foot, "stiffness": {"from": "0.3 MN/m", "to": "8 MN/m"}, "damping": "3.7 kN s/m"}},
        "goal": {"minimise": "static_load", "of": "foot.1", "direction": "y"},
    }
    design = solve(from_dict(document))
    assert design.status == "optimal"
    assert design.details["pieces"] < 100
    assert design.goal is not None
    assert abs(design.goal[1].value) < 1e-9
