"""Optima of the single absorber on an undamped mass: white noise, decay rate, damping ratio; checked in 40 digits."""

from __future__ import annotations

from typing import Any

import mpmath
import numpy as np
import pytest

import vibopt as vo
from vibopt.solve import boxes_first

RATIOS = (0.01, 0.1, 0.5)
MIDDLE = [one if one == 0.1 else pytest.param(one, marks=pytest.mark.slow) for one in RATIOS]
MASS, RATE, DENSITY = 100.0, 100.0, 100.0
STIFFNESS = MASS * RATE**2


def solved(ratio: float, goal: dict[str, Any], **more: Any) -> vo.Answer[vo.Scene]:
    document = {
        "bodies": {"m": {"mass": f"{MASS} kg"}, "t": {"mass": f"{ratio * MASS!r} kg"}},
        "links": {
            "l": {"between": ["m", "ground"], "stiffness": f"{STIFFNESS} N/m"},
            "a": {
                "between": ["t", "m"],
                "stiffness": {"from": "100 N/m", "to": "10 MN/m"},
                "damping": {"from": "0.1 N s/m", "to": "100 kN s/m"},
            },
        },
        "excitations": {"w": {"kind": "white_noise", "on": "m", "density": f"{DENSITY} N²/Hz"}},
        "goal": goal,
    }
    return vo.solve(vo.from_dict({**document, **more}))


def h2_design(mu: Any) -> tuple[Any, Any]:
    """Tuning and damping ratio."""
    root = mpmath.sqrt
    return root(1 + mu / 2) / (1 + mu), root(mu * (1 + 3 * mu / 4) / ((1 + mu) * (1 + mu / 2))) / 2


def mean_square(mu: Any, tuning: Any, damping: Any) -> Any:
    """Integral of |X k / F|^2 over w / w_1 from 0 to infinity, by quadrature."""

    def square(w: Any) -> Any:
        s = mpmath.mpc(0, w)
        top = s**2 + 2 * damping * tuning * s + tuning**2
        below = (s**2 + 1) * top + mu * s**2 * (2 * damping * tuning * s + tuning**2)
        return abs(top / below) ** 2

    return mpmath.quad(square, [0, 0.5, 0.8, 1, 1.2, 2, 10, mpmath.inf])


@pytest.mark.parametrize("ratio", MIDDLE)
def test_the_closed_form_under_white_noise_is_stationary(ratio: float) -> None:
    with mpmath.workdps(40):
        mu = mpmath.mpf(ratio)
        tuning, damping = h2_design(mu)
        value = mean_square(mu, tuning, damping)
        assert mpmath.almosteq(value, mpmath.pi / 2 * mpmath.sqrt((4 + 3 * mu) / (mu * (1 + mu))), 1e-25)
        assert abs(mpmath.diff(lambda f: mean_square(mu, f, damping), tuning)) < 1e-15 * value
        assert abs(mpmath.diff(lambda z: mean_square(mu, tuning, z), damping)) < 1e-15 * value


@pytest.mark.parametrize("ratio", RATIOS)
def test_least_motion_under_white_noise(ratio: float) -> None:
    design = solved(ratio, {"minimise": "rms_displacement", "of": "m"})
    tuning, damping = h2_design(ratio)
    wanted = np.sqrt(DENSITY * RATE / 4.0 * np.sqrt((4 + 3 * ratio) / (ratio * (1 + ratio)))) / STIFFNESS
    assert design.goal is not None
    assert design.goal[1].value == pytest.approx(wanted, rel=1e-12)
    assert design.x[0] == pytest.approx(float(ratio * STIFFNESS * tuning**2), rel=1e-7)
    assert design.x[1] == pytest.approx(float(2 * damping * tuning * ratio * MASS * RATE), rel=1e-7)
    assert (design.status, design.method) == ("optimal", "branch_and_bound")
    assert design.claim == "proven by branch and bound: nothing is better by more than 1e-06 of the goal"


def meeting(ratio: float) -> tuple[float, float]:
    """Stiffness and damping at which two pairs of poles meet: tuning 1 / (1 + mu), ratio sqrt(mu / (1 + mu))."""
    tuning, damping = 1.0 / (1.0 + ratio), np.sqrt(ratio / (1.0 + ratio))
    return ratio * STIFFNESS * tuning**2, float(2.0 * damping * tuning * ratio * MASS * RATE)


@pytest.mark.parametrize("ratio", RATIOS)
def test_the_poles_meet_exactly(ratio: float) -> None:
    with mpmath.workdps(40):
        mu = mpmath.mpf(ratio)
        f, z = 1 / (1 + mu), mpmath.sqrt(mu / (1 + mu))
        whole = [1, 2 * z * f * (1 + mu), 1 + f**2 * (1 + mu), 2 * z * f, f**2]
        a, b = z, f
        twice = [1, 2 * a, a**2 + 2 * b, 2 * a * b, b**2]
        assert all(mpmath.almosteq(one, other, 1e-38) for one, other in zip(whole, twice, strict=True))


@pytest.mark.parametrize("ratio", MIDDLE)
@pytest.mark.parametrize("goal", ["decay_rate", "damping_ratio"])
def test_the_best_least_pole(ratio: float, goal: str) -> None:
    design = solved(ratio, {"maximise": goal})
    wanted = 0.5 * RATE * np.sqrt(ratio / (1.0 + ratio)) if goal == "decay_rate" else 0.5 * np.sqrt(ratio)
    assert design.goal is not None
    assert design.goal[1].value == pytest.approx(wanted, rel=1e-6)
    assert design.x == pytest.approx(meeting(ratio), rel=1e-6)
    rng = np.random.default_rng(5)
    for k, c in np.exp(np.log(design.x) + rng.normal(0.0, 1.0, (500, 2)) * 10.0 ** rng.uniform(-6, 0, (500, 1))):
        state = np.array(
            [
                [0.0, 0.0, 1.0, 0.0],
                [0.0, 0.0, 0.0, 1.0],
                [-(STIFFNESS + k) / MASS, k / MASS, -c / MASS, c / MASS],
                [k / (ratio * MASS), -k / (ratio * MASS), c / (ratio * MASS), -c / (ratio * MASS)],
            ]
        )
        rates = np.linalg.eigvals(state)
        least = -rates.real.max() if goal == "decay_rate" else (-rates.real / np.abs(rates)).min()
        assert least <= wanted * (1.0 + 1e-6)


@pytest.mark.slow
def test_the_least_mass_for_a_decay_rate_lets_poles_meet(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(boxes_first, "_WORK", 8e6)  # starts find it, and boxes leave it open
    monkeypatch.setattr(boxes_first, "_LONGER", 5000)
    wanted = 0.5 * RATE * float(np.sqrt(0.05 / 1.05))
    bodies = {"m": {"mass": f"{MASS} kg"}, "t": {"mass": {"from": "1 kg", "to": "100 kg"}}}
    limit = {"response": "decay_rate", "at_least": f"{wanted!r} 1/s"}
    design = solved(0.05, {"minimise": "mass", "of": "t"}, bodies=bodies, limits={"fast": limit})
    assert design.status == "feasible"
    assert design.goal is not None
    assert design.goal[1].value == pytest.approx(5.0, rel=1e-5)


def test_one_damper_on_one_mass_decays_fastest_when_critical() -> None:
    document = {
        "bodies": {"m": {"mass": "100 kg"}},
        "links": {
            "l": {
                "between": ["m", "ground"],
                "stiffness": "1 MN/m",
                "damping": {"from": "1 N s/m", "to": "1 MN s/m"},
            }
        },
        "goal": {"maximise": "decay_rate"},
    }
    design = vo.solve(vo.from_dict(document))
    assert design.goal is not None
    assert design.goal[1].value == pytest.approx(100.0, rel=1e-6)
    assert design.x == pytest.approx([20e3], rel=1e-6)


def test_rigid_motion_has_no_decay_rate() -> None:
    document = {
        "bodies": {"a": {"mass": "1 kg"}, "b": {"mass": "1 kg"}},
        "links": {"l": {"between": ["a", "b"], "stiffness": "200 N/m", "damping": "1 N s/m"}},
        "measures": {"decay": {"response": "decay_rate"}},
    }
    assert vo.solve(vo.from_dict(document)).measures["decay"].value.value == pytest.approx(1.0, rel=1e-10)
