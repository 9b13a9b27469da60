"""Run-ups and run-downs: an integrator in cycles, Fresnel's integrals, Lewis's limits, and laws of swept peaks."""

from __future__ import annotations

import itertools
import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.special import wofz

import vibopt as vo
from refusals import refused
from vibopt.arrays import FloatArray, IntArray
from vibopt.mechanics.readout import Reading
from vibopt.mechanics.sweep_response import Modal, RunUp, Stretches, faddeeva_at_most
from vibopt.program.pose import pose
from vibopt.program.worst_case import around, hit, measured_around
from vibopt.report.curves import panels
from vibopt.report.machine_notes import ringing_notes
from vibopt.signals import Sweep

few = settings(derandomize=True, database=None, deadline=None, max_examples=12)


def lone(ratio: float, rate: float, low: float, high: float, *, unbalance: bool) -> RunUp:
    """1 kg on 1 N/m, under a force of 1 N or an unbalance of 1 kg m."""
    sweep = (
        Sweep((low, high), (rate,), (np.array([-1j * rate, 0.0, 1.0]),), (low**2, high**2))
        if unbalance
        else Sweep((low, high), (rate,), (np.ones(1, dtype=complex),), (1.0, 1.0))
    )
    return RunUp(np.eye(1), np.array([[2.0 * ratio]]), np.eye(1), 1, np.ones(1), sweep)


def place(n: int = 1, power: int = 0) -> Reading:
    return Reading(np.eye(n)[-1], np.zeros(n), np.zeros(n), power)


def integrated(machine: RunUp, end: float, count: int) -> tuple[FloatArray, Any]:
    """Positions (n, n_times) of a machine under two forces a quarter turn apart, by a Runge-Kutta method."""
    sweep, size = machine.sweep, machine.n_free
    low, high, rate = sweep.speeds[0], sweep.speeds[-1], sweep.rates[0]
    length = (high - low) / rate

    def force(time: float) -> complex:
        if time >= length:
            return sweep.still[1] * np.exp(1j * (0.5 * (low + high) * length + high * (time - length)))
        phasor = np.polynomial.polynomial.polyval(low + rate * time, sweep.powers[0])
        return complex(phasor * np.exp(1j * (low + 0.5 * rate * time) * time))

    def rates(time: float, now: Any) -> Any:
        pulled = machine.load * force(time) - machine.damping @ now[size:] - machine.stiffness @ now[:size]
        return np.concatenate([now[size:], np.linalg.solve(machine.mass, pulled)])

    begin = machine.stiffness + 1j * low * machine.damping - low**2 * machine.mass
    start = np.linalg.solve(begin, machine.load * sweep.still[0])
    times, found, now = [], [], np.concatenate([start, 1j * low * start])
    for a, b in ((0.0, length), (length, end)):
        run: Any = solve_ivp(rates, (a, b), now, method="DOP853", rtol=1e-11, atol=1e-13, dense_output=True)
        at = np.linspace(a, b, count)
        now = run.sol(b)
        times.append(at)
        found.append(run.sol(at)[:size])
    return np.concatenate(times), np.concatenate(found, axis=1)


@few
@given(seed=st.integers(0, 10_000), count=st.integers(1, 3), down=st.booleans(), unbalance=st.booleans())
def test_no_integration_in_cycles_finds_another_history_or_a_higher_peak(
    seed: int, count: int, down: bool, unbalance: bool
) -> None:
    """Chains from next to undamped to overdamped, up and down, from rest or from speed, slow or at once."""
    rng = np.random.default_rng(seed)
    mass = np.diag(10.0 ** rng.uniform(-0.5, 0.5, count))
    table = np.eye(count) - np.eye(count, k=-1)
    stiff, damped = ((table.T * 10.0**one) @ table for one in (rng.uniform(0, 1, count), rng.uniform(-2, 0.7, count)))
    rates = np.sqrt(np.linalg.eigvals(np.linalg.solve(mass, stiff)).real)
    low, high = sorted((rng.choice([0.0, rng.uniform(0.1, 1.0)]), rng.uniform(1.1, 2.0)))
    low, high = (rates.max() * one for one in ((high, low) if down else (low, high)))
    rate = np.copysign(rates.min() ** 2 * 10.0 ** rng.uniform(-2.0, 1.0), high - low)
    powers, still = np.array([0.3, 0.1, 1.0 if unbalance else 0.0], dtype=complex), np.array([low, high])
    sizes = np.polynomial.polynomial.polyval(still, powers.real)
    powers[0] -= 1j * rate * unbalance
    load = np.eye(count)[int(rng.integers(count))]
    machine = RunUp(mass, damped, stiff, count, load, Sweep((low, high), (rate,), (powers,), (sizes[0], sizes[1])))
    end = (high - low) / rate + 30.0 / rates.min()
    times, moved = integrated(machine, end, 2000)
    found = machine.peak(place(count))
    assert machine.history(place(count), times) == pytest.approx(np.abs(moved[-1]), abs=1e-8 * found.value)
    assert np.abs(moved[-1]).max() <= found.value * (1.0 + 1e-9)
    if found.time < end:
        assert np.abs(moved[-1]).max() >= found.value * 0.98


@pytest.mark.parametrize("unbalance", [False, True])
@pytest.mark.parametrize("rate", [1e-4, 1e-6, 1e-8])
def test_undamped_passages_tend_to_the_first_turn_of_cornus_spiral(rate: float, unbalance: bool) -> None:
    """1.1707 sqrt(pi / 2) w / sqrt(a) static deflections, 3.67 f / sqrt(Hz/s) (Fearn and Millsaps): a limit alone."""
    found = lone(0.0, rate, 0.0, 3.0, unbalance=unbalance).peak(place())
    assert found.value == pytest.approx(1.17074 * np.sqrt(0.5 * np.pi / rate), rel=2.0 * np.sqrt(rate))
    assert found.time * rate == pytest.approx(1.0 + 2.16 * np.sqrt(rate), abs=0.3 * np.sqrt(rate))


def test_slow_passages_tend_to_the_steady_peak_and_quick_ones_to_little() -> None:
    """With damping: the steady peak, reached late (Lewis, 1932); rates from 1e-8 to 1e8 of the frequency squared."""
    steady = 1.0 / (0.1 * np.sqrt(1.0 - 0.0025))
    slow = [lone(0.05, rate, 0.0, 2.0, unbalance=False).peak(place()) for rate in (1e-8, 1e-6, 1e-4)]
    assert slow[0].value == pytest.approx(steady, rel=1e-6)
    assert steady > slow[1].value > slow[2].value
    late = [one.time * rate / np.sqrt(1.0 - 0.005) for one, rate in zip(slow, (1e-8, 1e-6, 1e-4), strict=True)]
    assert 1.0 < late[0] < late[1] < late[2]
    down = lone(0.05, -1e-4, 2.0, 0.0, unbalance=False).peak(place())
    assert 2.0 - 1e-4 * down.time < np.sqrt(1.0 - 0.005)
    at_once = lone(0.05, 1e8, 0.0, 100.0, unbalance=False).peak(place()).value
    assert at_once == pytest.approx(1.0, rel=1e-3)  # it stays where the static force held it, and swings about nothing


def test_the_greatest_swept_amplitude_is_not_monotone_in_the_rate() -> None:
    """What one resonance leaves meets the next one in or out of phase; and a sudden stop lifts what is steady."""
    mass, stiff = np.diag([1.0, 0.5]), np.array([[3.0, -2.0], [-2.0, 2.0]])
    found = []
    for rate in np.geomspace(0.01, 1.0, 30):
        sweep = Sweep((0.0, 4.0), (rate,), (np.array([-1j * rate, 0.0, 1.0]),), (0.0, 16.0))
        machine = RunUp(mass, 0.1 * stiff, stiff, 2, np.eye(2)[0], sweep)
        found.append(machine.peak(Reading(np.eye(2)[0], np.zeros(2), np.zeros(2))).value)
    rises = np.diff(found) > 1e-3 * found[-1]
    assert 3 <= rises.sum() <= 25
    near = lone(0.02, 1.0, 0.0, 1.3, unbalance=True)
    assert near.peak(place()).value > near.steady(place(), np.array([1.3]))[0] * 1.2


def test_the_tangential_force_is_the_rest_of_the_acceleration_of_an_unbalance() -> None:
    """A body that is next to free moves against the unbalance: x = -(m e / m) e^(i phase), at any rate."""
    sweep = Sweep((1.0, 50.0), (7.0,), (np.array([-7j, 0.0, 1.0]),), (1.0, 2500.0))
    loose = RunUp(np.eye(1), np.zeros((1, 1)), 1e-12 * np.eye(1), 1, np.ones(1), sweep)
    assert loose.history(place(), np.linspace(0.0, 7.0, 30)) == pytest.approx(np.ones(30), rel=1e-6)


def test_no_quasi_steady_motion_is_greater_than_its_bound_and_beside_a_slow_pole_that_is_not_far_off() -> None:
    """In speeds of a slow passage whose widest panel is as wide as the resonance; half as much again at most."""
    machine = Modal(np.array([-1.0 + 60j]), np.array([1.0 + 0j]), 0j)
    squared = np.array([[0.0, 0.0, 1.0]], dtype=complex)
    ends = np.array([40.0]), np.array([0.05]), np.array([800.0])
    one, only = Stretches(machine, np.zeros(1, dtype=complex), *ends, squared), np.zeros(80, dtype=int)
    joints = np.linspace(0.0, 800.0, 81)
    inside = joints[:-1, None] + np.linspace(0.0, 10.0, 41)
    pushed = one._pushed(np.zeros(inside.size, dtype=int), inside.ravel())
    sizes = np.abs(pushed).reshape(inside.shape).max(axis=1)
    bounds = one.bound(only, joints[:-1], joints[1:]) - one.fading(only, joints[:-1], joints[1:])
    assert (sizes <= bounds * (1.0 + 1e-12)).all()
    assert (bounds <= 1.5 * sizes).all()


@pytest.mark.parametrize("size", [0.1, 1.0, 1.3334, 1.5, 2.0, 4.0, 6.0])
def test_the_faddeeva_function_is_no_greater_in_the_upper_half_plane_than_is_said(size: float) -> None:
    further = size * np.geomspace(1.0, 30.0, 400)[:, None] * np.exp(1j * np.linspace(0.0, np.pi, 181))
    most = float(np.abs(wofz(further)).max())
    assert most <= faddeeva_at_most(np.array([size]))[0] * (1.0 + 1e-9) <= 1.35 * most


def test_energy_is_kept_in_every_history() -> None:
    """What the force does is what the damper takes and what is stored."""
    machine = lone(0.04, 0.02, 0.2, 1.8, unbalance=True)
    times = np.linspace(0.0, 80.0, 200_001)
    turned = np.exp(1j * (0.2 + 0.01 * times) * times)
    place_, speed = ((machine.turning(machine.modal(place(power=power)), times) * turned).real for power in (0, 1))
    force = (((0.2 + 0.02 * times) ** 2 - 0.02j) * turned).real
    stored = 0.5 * (place_**2 + speed**2)
    step = times[1]

    def over_time(rate: FloatArray) -> float:
        return float(step * (rate.sum() - 0.5 * (rate[0] + rate[-1])))

    done = over_time(force * speed)
    assert done - over_time(0.08 * speed**2) == pytest.approx(stored[-1] - stored[0], abs=1e-6 * abs(done))


def test_no_cycle_costs_anything(monkeypatch: pytest.MonkeyPatch) -> None:
    """A thousand cycles and ten million take the same number of values."""
    taken, own = [0], Stretches._pushed

    def counted(one: Stretches, which: IntArray, times: FloatArray) -> Any:
        taken.append(len(times))
        return own(one, which, times)

    monkeypatch.setattr(Stretches, "_pushed", counted)
    counts = []
    for rate in (1e-3, 1e-7):
        taken.clear()
        lone(0.01, rate, 0.0, 3.0, unbalance=True).peak(place())
        counts.append(sum(taken))
    assert counts[1] < 3 * counts[0] < 60_000


def test_of_many_stretches_only_those_beside_the_resonance_are_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    """A motor's run-up has a stretch for each little change of its acceleration; bounds rule most of them out."""
    looked, own = [0], Stretches._pushed

    def counted(one: Stretches, which: IntArray, times: FloatArray) -> Any:
        looked.append(len(times))
        return own(one, which, times)

    monkeypatch.setattr(Stretches, "_pushed", counted)
    run_up = {"torque": "6 N m", "inertia": "2 kg m2"}
    scene = vo.from_dict({
        "bodies": {"fan": {"mass": "200 kg"}},
        "links": {"springs": {"between": ["fan", "ground"], "stiffness": "800 kN/m", "damping": "1500 N s/m"}},
        "excitations": {
            "blades": {"kind": "unbalance", "on": "fan", "unbalance": "0.2 kg m", "speed": "1500 rpm", "run_up": run_up}
        },
        "limits": {"rattle": {"response": "peak_displacement", "of": "fan", "at_most": "12 mm"}},
    })  # fmt: skip
    (limit,) = pose(scene).limits
    assert limit.worst(np.zeros(0)).value == pytest.approx(8.4812571e-3, rel=limit.form.known_to)
    assert len(looked) < 12  # all stretches go side by side
    assert sum(looked) < 10_000


@pytest.mark.parametrize("ratio", [0.5, 0.999999, 1.0, 1.0000001, pytest.param(4.0, marks=pytest.mark.slow), 1e4])
def test_modes_that_are_alike_lose_no_digits(ratio: float) -> None:
    """Critical damping and its neighbours: smooth in the damping ratio, and as integrated."""
    machine = lone(ratio, 0.05, 0.0, 3.0, unbalance=True)
    if ratio < 100.0:
        times, moved = integrated(machine, 100.0, 300)
        assert machine.history(place(), times) == pytest.approx(np.abs(moved[0]), abs=1e-10)
    beside = [lone(ratio * (1.0 + step), 0.05, 0.0, 3.0, unbalance=True).peak(place()).value for step in (-1e-7, 1e-7)]
    assert machine.peak(place()).value == pytest.approx(0.5 * sum(beside), rel=1e-11)


FAN: dict[str, Any] = {
    "title": "fan that runs up",
    "bodies": {"fan": {"mass": "200 kg"}},
    "links": {"springs": {"between": ["fan", "ground"], "stiffness": "800 kN/m", "damping_ratio": 0.05}},
    "excitations": {
        "blade": {
            "kind": "unbalance", "on": "fan", "unbalance": "0.2 kg m", "speed": "1500 rpm",
            "run_up": {"acceleration": "50 rpm/s"},
        }
    },
    "measures": {
        "displacement": {"response": "peak_displacement", "of": "fan"},
        "velocity": {"response": "peak_velocity", "of": "fan"},
        "acceleration": {"response": "peak_acceleration", "of": "fan"},
        "travel": {"response": "peak_relative_displacement", "across": "springs"},
        "force": {"response": "peak_force", "into": "ground"},
        "whole": {"response": "peak_force", "into": "fan"},
    },
}  # fmt: skip


def fan(**run_up: Any) -> dict[str, Any]:
    return {**FAN, "excitations": {"blade": {**FAN["excitations"]["blade"], "run_up": run_up}}}


def told(document: dict[str, Any]) -> dict[str, float]:
    """Values of the measures; both routes agree on them."""
    answer = vo.solve(vo.from_dict(document))
    assert answer.status == "met", answer.claim
    return {name: one.value.value for name, one in answer.measures.items()}


SHAKEN: dict[str, dict[str, Any]] = {
    "unbalance": FAN["excitations"]["blade"],
    "constant": {"kind": "force", "on": "fan", "amplitude": "1 kN", "speed": "1500 rpm", "varies": "constant"},
    "square": {"kind": "force", "on": "fan", "amplitude": "1 kN", "speed": "1500 rpm", "varies": "speed^2"},
    "rows": {
        "kind": "force", "on": "fan", "amplitude": "1 kN", "speed": "1500 rpm",
        "varies": [["0 rpm", 0.2], ["500 rpm", 0.9], ["1000 rpm", 0.1], ["1500 rpm", 1.0]],
    },
}  # fmt: skip
RUNS: dict[str, dict[str, str]] = {
    "up": {"acceleration": "50 rpm/s"},
    "down": {"from": "1500 rpm", "to": "0 rpm", "duration": "20 s"},
    "through": {"from": "400 rpm", "to": "1500 rpm", "acceleration": "200 rpm/s"},
    "at once": {"duration": "1 ms"},
}


@pytest.mark.sampled(3)
@pytest.mark.parametrize(("kind", "run"), list(itertools.product(SHAKEN, RUNS)))
def test_every_run_up_has_one_value_by_both_routes(kind: str, run: str) -> None:
    for damping in ({"damping_ratio": 0.05}, {"damping": "40 kN s/m"}):
        links = {"springs": {"between": ["fan", "ground"], "stiffness": "800 kN/m", **damping}}
        shaken = {"blade": {**SHAKEN[kind], "run_up": RUNS[run]}}
        some = {name: FAN["measures"][name] for name in ("displacement", "acceleration", "force", "whole")}
        found = told({**FAN, "links": links, "excitations": shaken, "measures": some})
        assert found["force"] == pytest.approx(found["whole"], rel=1e-9)
        assert all(0.0 < one < np.inf for one in found.values())


@pytest.mark.parametrize(
    "ends", [(0.5, 1.0), (1.0, 1.5), *(pytest.param(one, marks=pytest.mark.slow) for one in ((0.5, 1.5), (1.5, 1.0)))]
)
@pytest.mark.parametrize(("pushed", "excited"), [("middle", False), ("left", True)])
def test_a_resonance_that_nothing_damps_counts_only_where_the_force_excites_it(
    ends: tuple[float, float], pushed: str, *, excited: bool
) -> None:
    """Left and right against each other, met exactly at an end of the run-up: half the machine has no such mode."""
    met = (55_000.0 / 100.0) ** 0.5
    low, high = (met * one for one in ends)
    shaken = {
        "kind": "force", "on": pushed, "amplitude": "10 N", "varies": "constant", "speed": f"{max(low, high)!r} rad/s",
        "run_up": {"from": f"{low!r} rad/s", "to": f"{high!r} rad/s", "duration": "6 s"},
    }  # fmt: skip
    ways = [(side, end, k) for side in ("left", "right") for end, k in (("ground", 40), ("middle", 15))]
    links = {f"{side} {end}": {"between": [side, end], "stiffness": f"{k} kN/m"} for side, end, k in ways}
    asked = {"excitations": {"it": shaken}, "measures": {"asked": {"response": "peak_displacement", "of": "left"}}}
    bodies = {"left": {"mass": "100 kg"}, "middle": {"mass": "50 kg"}, "right": {"mass": "100 kg"}}
    answer = vo.solve(vo.from_dict({"title": "three", "bodies": bodies, "links": links, **asked}))
    assert answer.status == "met", answer.claim
    whole = {name: one.value.value for name, one in answer.measures.items()}
    if excited:
        assert np.isinf(whole["asked"]) == (1.0 in ends)
        if 1.0 in ends:  # it is told at the resonance, at whichever end that is
            assert answer.measures["asked"].worst_at["it"].value == pytest.approx(met, rel=1e-12)
        return
    bodies = {"left": {"mass": "200 kg"}, "middle": {"mass": "50 kg"}}
    links = {f"left {end}": {"between": ["left", end], "stiffness": f"{2 * k} kN/m"} for _, end, k in ways[:2]}
    half = told({"title": "half", "bodies": bodies, "links": links, **asked})
    assert whole["asked"] == pytest.approx(half["asked"], rel=1e-8)


def test_units_and_idle_rows_change_nothing() -> None:
    """rpm/s, Hz/s, rad/s^2 and a duration; a table with a row too many in it."""
    first = told(fan(acceleration="60 rpm/s"))
    for same in ({"acceleration": "1 Hz/s"}, {"acceleration": f"{2.0 * np.pi!r} rad/s²"}, {"duration": "25 s"}):
        assert told(fan(**same)) == pytest.approx(first, rel=1e-12)
    rows = [["0 rpm", 0.0], ["700 rpm", 0.7], ["1500 rpm", 1.5]]
    shaken = {**SHAKEN["rows"], "run_up": {"acceleration": "60 rpm/s"}}
    values = [
        told({**FAN, "excitations": {"blade": {**shaken, "varies": some}}}) for some in (rows, [rows[0], rows[2]])
    ]
    assert values[0] == pytest.approx(values[1], rel=1e-10)


def test_slopes_are_those_of_differences() -> None:
    document = {
        **FAN,
        "bodies": {"fan": {"mass": "200 kg"}, "frame": {"mass": "500 kg"}},
        "links": {
            "springs": {
                "between": ["fan", "frame"],
                "stiffness": {"from": "100 kN/m", "to": "5 MN/m"},
                "damping": {"from": "100 N s/m", "to": "1 MN s/m"},
            },
            "floor": {"between": ["frame", "ground"], "stiffness": "10 MN/m", "damping": "10 kN s/m"},
        },
        "limits": {
            "force": {"response": "peak_force", "into": "ground", "at_most": "1 kN"},
            "motion": {"response": "peak_acceleration", "of": "fan", "at_most": "1 g"},
        },
        "goal": {"minimise": "peak_displacement", "of": "fan"},
    }
    del document["measures"]
    for limit in pose(vo.from_dict(document)).limits:
        for x in ([8e5, 1e3], [8e5, 25298.221], [3e5, 3e5]):
            near = [np.array(x) * np.exp(1e-5 * sign * turn) for turn in np.eye(2) for sign in (1.0, -1.0)]
            logs = [np.log(limit.form.value(limit.model, one)) for one in near]
            differences = [(logs[0] - logs[1]) / 2e-5, (logs[2] - logs[3]) / 2e-5]
            assert limit.form.slope(limit.model, np.array(x)) == pytest.approx(differences, abs=1e-6)


def chosen_rate(low: str, high: str, bound: str) -> dict[str, Any]:
    """A fan on a frame whose rate is to be chosen: its peak force rises and falls with it."""
    springs = {"between": ["fan", "frame"], "stiffness": "800 kN/m", "damping": "500 N s/m"}
    floor = {"between": ["frame", "ground"], "stiffness": "2 MN/m", "damping": "3 kN s/m"}
    rate = {"from": f"{low} rpm/s", "to": f"{high} rpm/s"}
    return {
        "title": "fan on a frame",
        "bodies": {"fan": {"mass": "200 kg"}, "frame": {"mass": "300 kg"}},
        "links": {"springs": springs, "floor": floor},
        "excitations": {"blade": {**FAN["excitations"]["blade"], "run_up": {"acceleration": rate}}},
        "limits": {"force": {"response": "peak_force", "into": "ground", "at_most": bound}},
    }


def test_all_rates_that_keep_a_limit_are_the_intervals_of_a_fine_sweep() -> None:
    """Neither the least rate nor the greatest says which between them are good."""
    path = "excitations.blade.run_up.acceleration"
    scene = vo.from_dict({**chosen_rate("455", "620", "5.86 kN"), "goal": {"find_all": path}})
    answer = vo.solve(scene)
    assert answer.status == "met", answer.claim
    intervals = [(low.value, high.value) for low, high in answer.found]
    assert len(intervals) == 2
    [limit] = pose(scene).limits
    for rate in np.geomspace(455.0, 620.0, 24) * np.pi / 30.0:
        value = limit.form.value(limit.model, np.array([rate]))
        inside = any(low <= rate <= high for low, high in intervals)
        if abs(value - limit.bound) > 1e-6 * limit.bound:
            assert (value < limit.bound) == inside, rate


def test_a_rate_is_chosen_beside_a_damper_and_has_its_slope() -> None:
    document = chosen_rate("20", "500", "9 kN")
    document["links"]["springs"]["damping"] = {"from": "100 N s/m", "to": "5 kN s/m"}
    scene = vo.from_dict({**document, "goal": {"minimise": "peak_displacement", "of": "fan"}})
    program = pose(scene)
    assert [axis.path for axis in program.axes] == ["links.springs.damping", "excitations.blade.run_up.acceleration"]
    for limit in program.limits:
        for x in ([500.0, 5.0], [3e3, 20.0], [800.0, 47.0]):
            near = [np.array(x) * np.exp(1e-5 * sign * turn) for turn in np.eye(2) for sign in (1.0, -1.0)]
            logs = [np.log(limit.form.value(limit.model, one)) for one in near]
            differences = [(logs[0] - logs[1]) / 2e-5, (logs[2] - logs[3]) / 2e-5]
            assert limit.form.slope(limit.model, np.array(x)) == pytest.approx(differences, abs=2e-6)
            held = limit.form.held(np.array(x), [0])
            assert held.value(limit.model, np.array(x)) == pytest.approx(limit.form.value(limit.model, np.array(x)))


def doubtful(mass: Any, damping: Any, rate: Any, **more: Any) -> dict[str, Any]:
    springs = {"between": ["fan", "ground"], "stiffness": "800 kN/m", "damping": damping}
    peak = {"peak": FAN["measures"]["displacement"]}
    given = {"bodies": {"fan": {"mass": mass}}, "links": {"springs": springs}, "measures": peak}
    return {**fan(acceleration=rate), **given, **more}


@pytest.mark.parametrize("damping", ["1 kN s/m", {"from": "600 N s/m", "to": "6 kN s/m"}], ids=["rate", "both"])
@pytest.mark.parametrize("rates", [{"one_of": ["20 rpm/s", "150 rpm/s"]}, {"from": "20 rpm/s", "to": "150 rpm/s"}])
def test_the_worst_machine_within_tolerances_has_the_rate_that_is_chosen(rates: dict[str, Any], damping: Any) -> None:
    """Beside finished machines of given mass, damper and rate, over all of the tolerance."""
    limit = {"rattle": {**FAN["measures"]["displacement"], "at_most": "8 mm"}}
    goal = {"minimise": "peak_acceleration", "of": "fan"}
    scene = vo.from_dict(doubtful({"value": "200 kg", "tolerance": "5 %"}, damping, rates, limits=limit, goal=goal))
    x = np.array([1000.0, 12.0][-len(scene.variables) :])
    masses = np.linspace(190.0, 210.0, 5).tolist()
    found = [told(doubtful(f"{mass!r} kg", "1 kN s/m", "12 rad/s^2"))["peak"] for mass in masses]
    program, measure = measured_around(scene, x, "peak")
    for part in (*around(scene, x).limits, measure):
        worst = hit(part, program.axes)
        assert worst.value == pytest.approx(max(found), rel=1e-9)
        values = [part.form.value(part.model, np.array([mass / 200.0])) for mass in masses]
        assert values == pytest.approx(found, rel=1e-9)


def test_a_rate_is_chosen_for_the_worst_machine() -> None:
    """The middle one of three passes for the machine as said, and not for one that is lighter."""
    limits = {"rattle": {**FAN["measures"]["displacement"], "at_most": "11.9 mm"}}
    goal = {"maximise": "peak_acceleration", "of": "fan"}
    rates = {"one_of": ["20 rpm/s", "60 rpm/s", "150 rpm/s"]}
    for mass, chosen in (("200 kg", "60 rpm/s"), ({"value": "200 kg", "tolerance": "5 %"}, "150 rpm/s")):
        answer = vo.solve(vo.from_dict(doubtful(mass, "1 kN s/m", rates, limits=limits, goal=goal)), explain=False)
        assert [one.value.shown for one in answer.variables.values()] == [chosen], answer.claim
    lightest = told(doubtful("190 kg", "1 kN s/m", "150 rpm/s"))["peak"]
    assert answer.limits["rattle"].value.value == pytest.approx(lightest, rel=1e-9)


def shaken(**changes: Any) -> dict[str, Any]:
    return {"excitations": {"blade": {**FAN["excitations"]["blade"], **changes}}}


WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "two rates": (
        shaken(run_up={"acceleration": "1 rpm/s", "duration": "3 s"}),
        "excitations.blade.run_up gives acceleration and duration. Keep one: each says how fast the speed changes.",
    ),
    "a choice of the duration": (
        shaken(run_up={"duration": {"from": "1 s", "to": "3 s"}}),
        'excitations.blade.run_up chooses the duration. What may be chosen is the rate: acceleration = { from = "5 '
        'rpm/s", to = "500 rpm/s" }.',
    ),
    "a choice without an end": (
        shaken(run_up={"acceleration": {"from": "0 rpm/s", "to": "3 rpm/s"}}),
        "excitations.blade.run_up chooses the acceleration in a range without both ends: a run-up at no rate takes for "
        'ever. Write { from = "5 rpm/s", to = "500 rpm/s" }.',
    ),
    "a tolerance": (
        shaken(run_up={"acceleration": {"value": "50 rpm/s", "tolerance": "5 %"}}),
        "excitations.blade.run_up gives the acceleration a tolerance: peaks rise and fall with the rate, and are worst "
        'anywhere in it. Write acceleration = { from = "45 rpm/s", to = "55 rpm/s" }, and [goal] with maximise and the '
        "peak.",
    ),
    "a unit": (
        shaken(run_up={"acceleration": "50 rpm"}),
        'excitations.blade.run_up.acceleration = "50 rpm" is a speed of rotation or a frequency, but an angular '
        'acceleration is needed here. Write an angular acceleration, for example "50 rpm/s".',
    ),
    "no length": (
        shaken(run_up={"duration": "0 s"}),
        'excitations.blade.run_up.duration = "0 s" is not greater than zero. Write a positive value, for example '
        '"0.2 s".',
    ),
    "no way": (
        shaken(run_up={"from": "1500 rpm", "acceleration": "50 rpm/s"}),
        "excitations.blade.run_up begins at 1500 rpm and stays there. Write another from or to.",
    ),
    "too low": (
        shaken(run_up={"to": "1000 rpm", "acceleration": "50 rpm/s"}),
        "excitations.blade.run_up goes up to 1000 rpm, but speed = 1500 rpm is beyond it: which of the two does the "
        'machine reach? Write to = "1500 rpm", or a lower speed.',
    ),
    "too slow": (
        shaken(run_up={"duration": "100 h"}),
        "excitations.blade.run_up takes more than 300000 turns, so slowly that it is steady at every speed. Ask for "
        'steady responses over the range instead: over = "0 rpm..1500 rpm".',
    ),
    "unknown on the way": (
        {
            "excitations": {
                "blade": {
                    "kind": "force", "on": "fan", "amplitude": "1 kN", "speed": "1500 rpm",
                    "run_up": {"duration": "9 s"},
                }
            }
        },
        "excitations.blade.run_up goes from 0 rpm to 1500 rpm, and its amplitude is not known at all of these speeds. "
        'Add varies = "constant" or varies = "speed^2" to excitations.blade, or extend its table.',
    ),
    "over": (
        {"measures": {"d": {"response": "peak_displacement", "of": "fan", "over": "0..1500 rpm"}}},
        "measures.d has over, but the greatest in time is that of all that comes: the speeds of a run-up are said in "
        "run_up of its excitation. Leave it out.",
    ),
    "two of them": (
        {"excitations": dict.fromkeys(("blade", "other"), FAN["excitations"]["blade"])},
        "measures.force counts the run-up of excitations.blade and excitations.other, which have no known angle or "
        'time between them. Name one: due_to = ["blade"].',
    ),
    "loose": (
        {
            "bodies": {"fan": {"mass": "200 kg"}, "cart": {"mass": "10 kg"}},
            "links": {"springs": {"between": ["fan", "cart"], "stiffness": "800 kN/m"}},
            "measures": {"d": {"response": "peak_acceleration", "of": "fan"}},
        },
        "measures.d asks for the run-up of a machine of which cart is held by no spring: it is pushed away as the "
        "force begins. Hold it by a link with stiffness to a support.",
    ),
    "no run-up": (
        {
            "excitations": {"blade": {"kind": "unbalance", "on": "fan", "unbalance": "1 kg m", "speed": "10 Hz"}},
            "measures": {"d": {"response": "peak_displacement", "of": "fan"}},
        },
        "measures.d: peak_displacement is the greatest in time of what comes once, but excitations.blade is a steady "
        'vibration. Write response = "displacement", or name a pulse, a drop, a record or a run-up in due_to.',
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_what_makes_no_sense_in_a_run_up_is_refused(name: str) -> None:
    change, message = WRONG[name]
    assert f"scene: {message}" in refused(vo.from_dict, {**FAN, **change}).messages


def test_notes_say_what_steady_vibration_would_be_and_what_is_never_reached() -> None:
    some = {"measures": {"d": FAN["measures"]["displacement"]}}
    notes = vo.solve(vo.from_dict({**FAN, **some})).notes
    assert (
        "measures.d: steady, it is at most 10.01 mm on the way, at 605.5 rpm; in the run-up it is 2.5 % less, at a "
        "speed 4.1 % above." in notes
    )
    assert "A peak in a run-up is the greatest over every angle at which the force may begin." in notes
    sudden = {"speed": "10 rpm", "run_up": {"to": "10 rpm", "acceleration": "50 rpm/s"}}
    (words,) = [
        one for one in vo.solve(vo.from_dict({**FAN, **some, **shaken(**sudden)})).notes if "measures.d:" in one
    ]
    assert re.search(r"; in the run-up it is \d{3} % more, at a speed ", words)
    slow = {"speed": "400 rpm", "run_up": {"duration": "30 s"}}
    notes = vo.solve(vo.from_dict({**FAN, **some, **shaken(**slow)})).notes
    assert "excitations.blade: its run-up passes no resonance; the nearest natural frequency is 604 rpm." in notes
    steady = {"measures": {"d": {"response": "displacement", "of": "fan"}}}
    notes = vo.solve(vo.from_dict({**FAN, **steady})).notes
    assert "excitations.blade: nothing asks of its run-up. Add a response in time, as peak_displacement." in notes


def test_the_figure_has_the_envelope_and_the_steady_curve_over_the_speed() -> None:
    design = vo.solve(vo.from_dict({**FAN, "measures": {"d": FAN["measures"]["displacement"]}}))
    [panel] = panels(design)
    envelope, steady = panel.curves
    assert (envelope.label, steady.label, panel.x_label) == ("run-up", "steady", "speed of blade [rpm]")
    [mark] = panel.marks
    assert envelope.y.max() == pytest.approx(mark.y, rel=1e-9)
    assert envelope.x[envelope.y.argmax()] == pytest.approx(mark.x, rel=1e-9)
    assert steady.y.max() == pytest.approx(10.0125, rel=1e-4)


def test_a_shaft_that_its_bearings_damp_is_not_told_to_ring_on() -> None:
    """Their damping along each plane stands in no matrix of one plane."""
    bearing = {"k_yy": "22 MN/m", "k_zz": "9 MN/m", "c_yy": "672 N s/m", "c_zz": "506 N s/m"}
    disc = {"name": "fan", "at": "0.2 m", "mass": "11 kg", "diametral": "0.1 kg m2", "polar": "0.15 kg m2"}
    shaft = {
        "modulus": "207 GPa", "density": "7850 kg/m3", "sections": [{"length": "0.5 m", "diameter": "38 mm"}],
        "stations": {"A": "0.05 m", "B": "0.4 m"}, "discs": [disc],
    }  # fmt: skip
    scene = vo.from_dict({
        "title": "shaft", "rotors": {"shaft": shaft},
        "bearings": {f"at_{one}": {"between": [one, "ground"], **bearing} for one in "AB"},
        "excitations": {"blade": {**FAN["excitations"]["blade"], "on": "fan", "unbalance": "1 g m"}},
        "measures": {"d": {"response": "peak_displacement", "of": "fan"}},
    })  # fmt: skip
    assert ringing_notes(scene, {}) == []
