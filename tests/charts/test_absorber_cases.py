"""References of the absorber rows, worked out again in forty digits; fair verdicts; small models that are right."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
import pytest

from vibopt.charts.absorber_cases import EDGES, QUICK, STOCK, families, fidelity, least_peak
from vibopt.charts.trial import DEFAULT, Case, trial
from vibopt.charts.verdicts import RIGHT, SAYS_SO

sys.path.append(str(Path(__file__).parents[1] / "references"))
from absorber_optima import Chain, equal_peaks
from absorber_routes import nishihara_asami

OWN = math.sqrt(1000.0)


def stack(count: int, hosts: tuple[int, ...], mu: tuple[float, ...], ratio: float, spring: float = 1e6) -> Chain:
    """Equal masses of 100 kg, shaken and read at the top."""
    top = count - 1
    return Chain((100.0,) * count, (spring,) * count, (ratio,) * count, top, top, hosts, mu)


STARTS: dict[str, tuple[Chain, list[float], list[float]]] = {
    "1 absorber, undamped mass": (stack(1, (0,), (0.05,), 0.0, 1e5), [0.952, 0.134], [28.3, 33.5]),
    "1 absorber, damped mass": (stack(1, (0,), (0.05,), 0.02, 1e5), [0.946, 0.137], [28.1, 33.3]),
    "2 absorbers": (
        stack(1, (0, 0), (0.025, 0.025), 0.0, 1e5),
        [1.0233, 0.0949, 0.8988, 0.0844],
        [27.48, 30.59, 34.33],
    ),
    "3 absorbers": (
        stack(1, (0, 0, 0), (0.02, 0.015, 0.015), 0.0, 1e5),
        [0.95798, 0.07553, 1.06176, 0.07238, 0.87269, 0.06096],
        [26.950, 29.206, 31.952, 34.992],
    ),
    "5 absorbers": (
        stack(1, (0,) * 5, (0.01,) * 5, 0.01, 1e5),
        [0.900355, 0.047505, 1.095314, 0.055896, 1.018924, 0.052415, 0.845819, 0.045249, 0.956410, 0.049676],
        [26.2705, 27.8713, 29.5053, 31.277, 33.291, 35.723],
    ),
    "3 masses, 1 absorber": (stack(3, (2,), (0.05,), 0.01), [0.9716, 0.1007], [41.21, 46.42]),
    "3 masses, 2 absorbers": (
        stack(3, (2, 1), (0.05, 0.05), 0.01),
        [0.9084, 0.0890, 1.0333, 0.0824],
        [38.93, 43.51, 48.25],
    ),
    "10 masses, 1 absorber": (stack(10, (9,), (0.1,), 0.01), [0.9801, 0.0976], [14.27, 15.27, 44.55]),
    "100 masses, 1 absorber": (stack(100, (99,), (0.5,), 0.01), [1.00084, 0.20786], [1.5544, 4.6909]),
}


LONG = ("3 absorbers", "5 absorbers", "100 masses, 1 absorber")


@pytest.mark.parametrize(
    "case", [pytest.param(case, id=case.name, marks=pytest.mark.slow if case.name in LONG else ()) for case in STOCK]
)
def test_each_reference_is_an_optimum_in_forty_digits(case: Case) -> None:
    """Peaks are equally high and no step lowers them all; that nothing else is lower is what the methods try."""
    chain, design, peaks = STARTS[case.name]
    value, found = equal_peaks(chain, design, peaks)
    assert float(value) == pytest.approx(case.goal, rel=1e-12)
    lowest = chain.lowest()
    everywhere = np.geomspace(0.05 * float(lowest), 60.0 * float(lowest), 150)
    assert all(chain.amplitude(w, found, lowest) <= value for w in everywhere.tolist())


def test_the_edges_of_bands_are_optima_in_forty_digits() -> None:
    chain = Chain((100.0,), (1e5,), (0.0,), 0, 0, (0,), (0.05,), (OWN,))
    for design, peak, value in (([1.069, 0.0724], 36.87, EDGES[0]), ([0.9126, 0.0854], 26.95, EDGES[1])):
        assert float(equal_peaks(chain, design, [peak])[0]) == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize("mu", [1e-6, 1e-3, 0.05, 0.5, 2.0])
def test_the_closed_form_of_the_chart_is_that_of_the_second_route(mu: float) -> None:
    assert least_peak(mu) == pytest.approx(float(nishihara_asami(repr(mu))["peak"]), rel=1e-14)


@pytest.mark.parametrize("case", QUICK, ids=lambda case: case.name)
def test_the_default_reaches_the_reference(case: Case) -> None:
    one = trial(case, case.scene(), DEFAULT, 1)
    assert one.verdict == RIGHT
    assert one.error < 1e-9


@pytest.mark.parametrize("case", families(), ids=lambda case: case.name)
def test_the_default_is_right_on_hard_ground(case: Case) -> None:
    one = trial(case, case.scene(), DEFAULT, 1)
    assert one.verdict in (RIGHT, SAYS_SO)
    assert one.verdict == RIGHT or "1e-06" in case.name


def test_the_small_model_of_a_rod_gives_the_values_of_the_whole() -> None:
    for row in (row for _, make in fidelity(quick=True) for row in make()):
        assert row.used < 20 < row.declared
        assert row.value_error < 1e-8
        assert row.goal_error < 1e-9
