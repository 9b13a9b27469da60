"""Closed forms of absorbers against brute force: dense grids in numpy, and a proof by two frequencies."""

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from mpmath import mpf
from scipy.integrate import quad

from absorber_routes import (
    PROBLEMS,
    System,
    band_free,
    certificate,
    damped,
    den_hartog,
    fastest_decay,
    h_infinity,
    lanchester,
    least_mean_square,
    least_mean_square_damped,
    nishihara_asami,
    operating_range,
)

Array = Any
RATIOS = ("0.01", "0.05", "0.2", "1")
SYSTEMS = [*((mu, "0") for mu in RATIOS), ("0.05", "0.01"), ("0.05", "0.1"), ("0.2", "0.05"), ("1", "0.1")]


def heights(x: Array, mu: float, f: Array, zeta: Array, zeta1: float = 0.0) -> Array:
    """Height of the main mass, the absorber taken as an added dynamic mass."""
    omega = np.sqrt(x)
    link = f**2 + 2j * zeta * f * omega
    added = mu * link / (link - x)
    return 1 / np.abs(1 - x + 2j * zeta1 * omega - added * x)


def around(middle: float, width: float, count: int) -> Array:
    """A grid about a value, which it holds."""
    return middle * np.linspace(1 - width, 1 + width, 2 * count + 1)


def slowest(mu: float, f: Array, zeta: Array) -> Array:
    """Slowest decay rate by the eigenvalues of the first-order form."""
    system = np.zeros((*np.broadcast(f, zeta).shape, 4, 4))
    system[..., 0, 2] = system[..., 1, 3] = 1
    spring, damper = f**2, 2 * zeta * f
    system[..., 2, 0], system[..., 2, 1] = -1 - mu * spring, mu * spring
    system[..., 2, 2], system[..., 2, 3] = -mu * damper, mu * damper
    system[..., 3, 0], system[..., 3, 1] = spring, -spring
    system[..., 3, 2], system[..., 3, 3] = damper, -damper
    return -np.linalg.eigvals(system).real.max(axis=-1)


@pytest.mark.parametrize("name", PROBLEMS)
def test_both_routes_of_a_problem_agree(name: str) -> None:
    assert PROBLEMS[name]()


@pytest.mark.parametrize("mu", RATIOS)
def test_fixed_points_do_not_feel_the_damping(mu: str) -> None:
    found = den_hartog(mu)
    for x in found["fixed_points"]:
        for zeta in ("0.01", "0.1", "3"):
            height = damped(mpf(mu), found["tuning"], mpf(zeta)).height(x)
            assert abs(height / found["fixed_height"] - 1) < 1e-30


@pytest.mark.parametrize("mu", RATIOS)
def test_den_hartog_peak_is_a_little_above_the_best(mu: str) -> None:
    found, best = den_hartog(mu), nishihara_asami(mu)
    assert found["fixed_height"] < best["peak"] < found["peak"] < mpf("1.006") * best["peak"]
    grid = heights(np.linspace(1e-3, 3, 200_000), float(mu), float(found["tuning"]), float(found["zeta"]))
    assert grid.max() == pytest.approx(float(found["peak"]), rel=1e-7)


@pytest.mark.parametrize("mu", RATIOS)
def test_closed_form_fulfils_the_conditions_of_the_optimum(mu: str) -> None:
    closed, newton = nishihara_asami(mu), h_infinity(mu)
    for name, value in closed.items():
        assert abs(value / newton[name] - 1) < mpf(10) ** -30


def test_best_peak_of_a_twentieth() -> None:
    assert float(nishihara_asami("0.05")["peak"]) == pytest.approx(6.40792, abs=5e-6)


@pytest.mark.parametrize(("mu", "zeta1"), SYSTEMS)
def test_no_absorber_is_better_by_two_frequencies(mu: str, zeta1: str) -> None:
    proof = certificate(mu, zeta1)
    assert all(weight > 0 for weight in proof["weights"])
    assert abs(proof["slope_in_F"]) < 1e-30
    assert abs(proof["slope_in_d"]) < 1e-30
    assert proof["curvature_in_F"] < 0
    assert proof["curvature_in_d"] < 1e-30


@pytest.mark.parametrize(("mu", "zeta1"), SYSTEMS)
def test_no_absorber_of_a_grid_is_better(mu: str, zeta1: str) -> None:
    best = h_infinity(mu, zeta1)
    f, zeta, peak = (float(best[name]) for name in ("tuning", "zeta", "peak"))
    low, high = (float(x) for x in best["peaks_at"])
    x = np.linspace(0.9 * low, 1.1 * high, 800)
    whole = heights(np.linspace(1e-3, 4, 50_000), float(mu), f, zeta, float(zeta1))
    assert whole.max() == pytest.approx(peak, rel=1e-6)
    for width in (0.5, 0.02):
        grid = heights(x, float(mu), around(f, width, 6)[:, None, None], around(zeta, width, 6)[:, None], float(zeta1))
        greatest = grid.max(axis=-1)
        assert greatest.min() > peak * (1 - 1e-4)
        assert np.unravel_index(greatest.argmin(), greatest.shape) == (6, 6)


@pytest.mark.parametrize("mu", RATIOS)
def test_lanchester_damper(mu: str) -> None:
    found = lanchester(mu)
    peaks = [System(mpf(mu), mpf(0), 2 * found["zeta"] * mpf(change)).peak()[0] for change in ("0.98", "1", "1.02")]
    assert abs(peaks[1] / found["peak"] - 1) < 1e-15
    assert min(peaks) == peaks[1]


@pytest.mark.parametrize("zeta1", ["0", "0.03"])
@pytest.mark.parametrize("mu", RATIOS)
def test_mean_square_is_the_integral(mu: str, zeta1: str) -> None:
    best = least_mean_square(mu)
    f, zeta = float(best["tuning"]), float(best["zeta"])
    exact = float(damped(mpf(mu), best["tuning"], best["zeta"], mpf(zeta1)).white_noise())

    def squared(omega: float) -> float:
        return float(heights(omega**2, float(mu), f, zeta, float(zeta1)) ** 2)

    pieces = [quad(squared, a, b, limit=200)[0] for a, b in pairwise((1e-9, 0.5, 0.9, 1.1, 2, np.inf))]
    assert 2 * sum(pieces) == pytest.approx(exact, rel=1e-7)


@pytest.mark.parametrize("mu", RATIOS)
def test_least_mean_square_of_a_grid(mu: str) -> None:
    best = least_mean_square(mu)
    changes = [1 + mpf(step) / 50 for step in range(-4, 5)]
    values = [damped(mpf(mu), best["tuning"] * p, best["zeta"] * q).white_noise() for p in changes for q in changes]
    assert min(values) == values[len(values) // 2]
    newton = least_mean_square_damped(mu, 0)
    assert abs(newton["tuning"] / best["tuning"] - 1) < 1e-25
    assert abs(newton["zeta"] / best["zeta"] - 1) < 1e-25


@pytest.mark.parametrize("mu", RATIOS)
def test_fastest_decay_of_a_grid(mu: str) -> None:
    best = fastest_decay(mu)
    f, zeta, decay = (float(best[name]) for name in ("tuning", "zeta", "decay"))
    assert slowest(float(mu), np.array(f), np.array(zeta)) == pytest.approx(decay, rel=1e-6)
    for width in (0.9, 0.1, 0.01):
        grid = slowest(float(mu), around(f, width, 30)[:, None], around(zeta, width, 30)[None, :])
        assert grid.max() < decay * (1 + 1e-6)
    exact = damped(mpf(mu), best["tuning"], best["zeta"]).decay()
    assert abs(exact / best["decay"] - 1) < 1e-15


@pytest.mark.parametrize(("low", "high"), [(0.8, 1.2), (0.875, 1.3), (0.7, 1.3), (0.75, 4 / 3)])
def test_least_absorber_out_of_a_band_by_scanning(low: float, high: float) -> None:
    found = band_free(mpf(1), mpf(1), mpf(low), mpf(high))
    mu, w2 = np.meshgrid(np.linspace(0.02, 0.6, 1161), np.linspace(0.5, 2, 1501), indexing="ij")
    half = (1 + (1 + mu) * w2) / 2
    spread = np.sqrt(half**2 - w2)
    outside = (half - spread <= low**2) & (half + spread >= high**2)
    least = mu[outside].min()
    assert 0 <= least - float(found["mass"]) < 0.002


def test_operating_range_by_scanning() -> None:
    (low, high), (above, _) = operating_range()["set"]
    r = np.linspace(0.01, 5, 1_000_001)
    quiet = np.abs((1 - r**2) / ((1.1 - r**2) * (1 - r**2) - 0.1)) <= 0.5
    inside = ((r >= float(low)) & (r <= float(high))) | (r >= float(above))
    assert (quiet == inside).all()
