"""What begins suddenly and lasts, bases that move and come back, and sums of what is greatest at several times."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import vibopt as vo
from refusals import refused
from vibopt.excitations.segments import sine, together
from vibopt.mechanics.beating import highest
from vibopt.mechanics.readout import Reading
from vibopt.mechanics.transient import Transient
from vibopt.report.curves import panels
from vibopt.verify.certify import measure

few = settings(derandomize=True, database=None, deadline=None, max_examples=12)
MASS = 10.0
TABLE: dict[str, Any] = {
    "title": "instrument on a table",
    "bases": {"floor": {}},
    "bodies": {"table": {"mass": "10 kg"}},
    "links": {"mount": {"between": ["table", "floor"], "stiffness": "4 kN/m", "damping": "40 N s/m"}},
    "excitations": {
        "fan": {"kind": "force", "on": "table", "amplitude": "30 N", "speed": "5 Hz", "begins": "suddenly"},
        "press": {"kind": "base_motion", "on": "floor", "displacement": "2 mm", "speed": "4 Hz", "begins": "suddenly"},
        "crane": {
            "kind": "pulse", "on": "floor", "shape": "decaying sine", "displacement": "3 mm", "frequency": "6 Hz",
            "damping_ratio": 0.1,
        },
        "pump": {"kind": "force", "on": "table", "amplitude": "10 N", "speed": "7 Hz"},
    },
    "measures": {
        "place": {"response": "peak_displacement", "of": "table"},
        "rattle": {"response": "peak_relative_displacement", "across": "mount"},
        "force": {"response": "peak_force", "into": "floor"},
    },
}  # fmt: skip


def asked(measures: dict[str, Any], **other: Any) -> dict[str, float]:
    """Values of measures; both routes agree on them."""
    answer = vo.solve(vo.from_dict({**TABLE, **other, "measures": measures}))
    assert answer.status == "met", answer.claim
    return {name: one.value.value for name, one in answer.measures.items()}


def begun(k: float, c: float, speed: float, times: np.ndarray) -> np.ndarray:
    """Displacement of 1 kg from rest under sin(speed t), underdamped, by the formulas of the books."""
    decay, omega = 0.5 * c, np.sqrt(k - 0.25 * c * c)
    steady = 1.0 / (k - speed**2 + 1j * speed * c)
    first, second = -steady.imag, -(speed * steady.real + decay * steady.imag) / omega
    free = np.exp(-decay * times) * (first * np.cos(omega * times) + second * np.sin(omega * times))
    return np.asarray(np.imag(steady * np.exp(1j * speed * times)) + free)


@few
@given(k=st.floats(0.5, 20.0), ratio=st.floats(0.02, 0.9), speed=st.floats(0.2, 8.0))
def test_a_sine_from_rest_is_that_of_the_books(k: float, ratio: float, speed: float) -> None:
    c = 2.0 * ratio * np.sqrt(k)
    sine = vo.from_dict(
        {
            **TABLE,
            "excitations": {"f": {**TABLE["excitations"]["fan"], "amplitude": "1 N", "speed": f"{speed!r} rad/s"}},
            "measures": {"place": TABLE["measures"]["place"]},
        }
    ).excitations["f"].once  # fmt: skip
    assert sine is not None
    machine = Transient(np.eye(1), np.array([[c]]), np.array([[k]]), 1, np.eye(1), sine.segments())
    found = machine.peak(Reading(np.ones(1), np.zeros(1), np.zeros(1)))
    fades = 30.0 / (0.5 * c)
    times = np.linspace(0.0, fades + 20.0 / speed, 400_001)
    assert abs(found.value) == pytest.approx(np.abs(begun(k, c, speed, times)).max(), rel=1e-5)
    assert abs(found.value) >= np.abs(begun(k, c, speed, times)).max() * (1.0 - 1e-9)
    if np.isfinite(found.time):
        assert found.value == pytest.approx(begun(k, c, speed, np.array([found.time]))[0], rel=1e-8)


def test_all_together_each_alone_and_steady() -> None:
    """Sums of the single peaks, never less than all together; steady ones count as they are when nothing begins."""
    every = {"response": "peak_displacement", "of": "table"}
    names = ["fan", "press", "crane"]
    measures = {"together": {**every, "due_to": names}, "sum": {**every, "combine": "sum", "due_to": [*names, "pump"]}}
    measures |= {"all": {**every, "combine": "sum"}, "root": {**every, "combine": "rss", "due_to": ["fan", "pump"]}}
    measures |= {name: {**every, "due_to": [name]} for name in names}
    measures["pump"] = {"response": "displacement", "of": "table", "due_to": ["pump"]}
    found = asked(measures)
    assert found["sum"] == pytest.approx(sum(found[name] for name in [*names, "pump"]), rel=1e-12)
    assert found["all"] == found["sum"]
    assert found["root"] == pytest.approx(np.hypot(found["fan"], found["pump"]), rel=1e-12)
    assert max(found[name] for name in names) < found["together"] < found["sum"] - found["pump"]


def test_what_lasts_together_is_the_true_peak_and_nears_the_sum_without_a_common_turn() -> None:
    """Speeds of 3 and 4 keep their phases; 3 and 3 times the root of 2 come as near to the sum as you like."""
    mount = {"between": ["table", "floor"], "stiffness": "1 kN/m", "damping": "90 N s/m"}

    def two(first: float, second: float) -> tuple[float, float]:
        force = {"kind": "force", "on": "table", "amplitude": "10 N", "begins": "suddenly"}
        both = {name: {**force, "speed": f"{speed!r} rad/s"} for name, speed in (("a", first), ("b", second))}
        place = {"response": "peak_displacement", "of": "table"}
        found = asked({"both": place, "sum": {**place, "combine": "sum"}}, links={"mount": mount}, excitations=both)
        return found["both"], found["sum"]

    both, total = two(6.0, 8.0)
    times = np.linspace(0.0, 12.0, 100_001)
    assert both == pytest.approx(np.abs(begun(100.0, 9.0, 6.0, times) + begun(100.0, 9.0, 8.0, times)).max(), rel=1e-6)
    assert both < 0.999 * total
    both, total = two(6.0, 6.0 * 2.0**0.5)
    steady = sum(1.0 / abs(100.0 - w * w + 9j * w) for w in (6.0, 6.0 * np.sqrt(2.0)))
    assert both == pytest.approx(steady, rel=1e-9)
    assert total >= both * (1.0 - 1e-12)


def test_a_resonance_that_nothing_damps_grows_without_end_on_both_routes() -> None:
    spring = {"between": ["table", "floor"], "stiffness": "4 kN/m"}
    fan = {**TABLE["excitations"]["fan"], "speed": "20 rad/s"}
    found = asked({"place": TABLE["measures"]["place"]}, links={"mount": spring}, excitations={"fan": fan})
    assert found["place"] == np.inf


@pytest.mark.parametrize("shape", ["half sine", "versed sine", "sine", "triangle", "decaying sine"])
def test_a_base_that_moves_and_comes_back(shape: str) -> None:
    """Both routes; a stiff mount rides on it, and a soft one stays while the base passes by."""
    words = {"frequency": "5 Hz", "damping_ratio": 0.2} if shape == "decaying sine" else {"duration": "0.2 s"}
    bump = {"kind": "pulse", "on": "floor", "shape": shape, "displacement": "5 mm", **words}
    again = {} if shape == "decaying sine" else {"times": 2, "every": "0.5 s"}
    found = asked(TABLE["measures"], excitations={"bump": {**bump, **again}})
    assert 0.0 < found["rattle"] < 0.05
    angle = np.arctan(1.0 / 0.2)  # at which a decaying sine is greatest
    most = 5e-3 * (1.0 if again else np.exp(-0.2 * angle) * np.sin(angle))
    stiff = {"between": ["table", "floor"], "stiffness": "4 MN/m", "damping": "9 kN s/m"}
    soft = {"between": ["table", "floor"], "stiffness": "4 N/m", "damping": "2 N s/m"}
    rides = asked({"place": TABLE["measures"]["place"]}, excitations={"bump": bump}, links={"mount": stiff})
    stays = asked({"rattle": TABLE["measures"]["rattle"]}, excitations={"bump": bump}, links={"mount": soft})
    assert rides["place"] == pytest.approx(most, rel=2e-2)
    assert stays["rattle"] == pytest.approx(most, rel=2e-2)


def test_signals_that_last_are_cut_where_others_end() -> None:
    scene = vo.from_dict(TABLE)
    signals = [scene.excitations[name].once for name in ("fan", "press", "crane")]
    whole = together([one.segments() for one in signals if one is not None])
    assert [one.endless for one in whole] == [False] * (len(whole) - 1) + [True]
    machine = Transient(np.eye(1), np.eye(1), 9.0 * np.eye(1), 1, np.ones((1, 3)), whole)
    times = np.linspace(0.0, 12.0, 61)
    place = Reading(np.ones(1), np.zeros(1), np.zeros(1))
    alone = [
        Transient(np.eye(1), np.eye(1), 9.0 * np.eye(1), 1, np.eye(1), one.segments()).history(place, times)
        for one in signals
        if one is not None
    ]
    assert machine.history(place, times) == pytest.approx(sum(alone), rel=1e-8, abs=1e-12)


def test_the_goal_may_be_a_sum() -> None:
    """What was found is the best of a grid by the second route."""
    mount = {"between": ["table", "floor"], "stiffness": "4 kN/m", "damping": {"from": "100 N s/m", "to": "500 N s/m"}}
    goal = {"minimise": "peak_displacement", "of": "table", "due_to": ["fan", "press"], "combine": "sum"}
    asks = {name: table for name, table in TABLE.items() if name != "measures"}
    scene = vo.from_dict({**asks, "links": {"mount": mount}, "goal": goal})
    answer = vo.solve(scene, explain=False)
    assert answer.status == "optimal"
    assert answer.goal is not None
    assert scene.goal is not None
    best, response = answer.goal[1].value, scene.goal.response
    grid = [measure(scene, {"links.mount.damping": c}, response).value for c in (120.0, 220.0, 400.0)]
    assert best * (1.0 - 1e-9) <= min(grid) <= best * 1.2


WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "combine": (
        {"measures": {"a": {"response": "peak_displacement", "of": "table", "combine": "peak"}}},
        'measures.a has combine = "peak". Write "sum" or "rss"; without it all act together from one beginning.',
    ),
    "which speed": (
        {"excitations": {"fan": {**TABLE["excitations"]["fan"], "speed": "5..9 Hz"}}},
        'excitations.fan begins suddenly, at which speed? Write one above zero: speed = "2000 rpm".',
    ),
    "both": (
        {"excitations": {"fan": {**TABLE["excitations"]["fan"], "run_up": {"acceleration": "9 rpm/s"}}}},
        "excitations.fan has run_up and begins: does it gain speed, or begin suddenly at full speed? Keep one.",
    ),
    "at once": (
        {
            "excitations": {
                "bump": {
                    "kind": "pulse", "on": "floor", "shape": "rectangle", "displacement": "5 mm", "duration": "1 s"
                }
            }
        },
        "excitations.bump is a rectangle, which would displace its base at once. Write another shape, or its "
        "acceleration.",
    ),
    "in m/s2": (
        {
            "excitations": {
                "bump": {"kind": "pulse", "on": "floor", "shape": "sine", "amplitude": "1 m/s2", "duration": "1 s"}
            }
        },
        'excitations.bump.amplitude = "1 m/s2" is an acceleration, which only a base has. Write '
        'acceleration = "1 m/s2".',
    ),
    "in mm": (
        {
            "excitations": {
                "bump": {"kind": "pulse", "on": "floor", "shape": "sine", "amplitude": "5 mm", "duration": "1 s"}
            }
        },
        'excitations.bump.amplitude = "5 mm" is a length, which only a base has. Write displacement = "5 mm".',
    ),
    "none": (
        {"excitations": {"bump": {"kind": "pulse", "on": "floor", "shape": "sine", "duration": "1 s"}}},
        "excitations.bump needs one of amplitude, a force on a body, and acceleration or displacement of a base. Write "
        'amplitude = "2 kN".',
    ),
    "two sizes": (
        {
            "excitations": {
                "bump": {
                    "kind": "pulse", "on": "floor", "shape": "sine", "duration": "1 s", "amplitude": "3 N",
                    "acceleration": "30 m/s2",
                }
            }
        },
        "excitations.bump gives amplitude and acceleration. Keep one: it is a force on a body, or the motion of a "
        "base.",
    ),
    "a range": (
        {
            "excitations": {
                "bump": {
                    "kind": "pulse", "on": "floor", "shape": "sine", "duration": "1..11 ms", "acceleration": "30 m/s2"
                }
            }
        },
        'excitations.bump.duration = "1..11 ms" asks for every value in a range, which is not supported for this fact '
        "yet. Write one value.",
    ),
    "standstill": (
        {
            "excitations": {"pump": {**TABLE["excitations"]["pump"], "speed": "0..9 Hz"}},
            "measures": {"a": {"response": "peak_velocity", "of": "table", "combine": "sum"}},
        },
        "measures.a adds the steady vibration of excitations.pump, whose own speeds begin at standstill. Write those "
        "at which it runs.",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_what_makes_no_sense_is_refused(name: str) -> None:
    change, message = WRONG[name]
    assert f"scene: {message}" in refused(vo.from_dict, {**TABLE, **change}).messages


@pytest.mark.parametrize("on_base", [False, True])
@pytest.mark.parametrize("off", [1e-3, 1e-4, 1e-8])
def test_an_undamped_beat_reaches_the_sum_of_both_amplitudes(off: float, *, on_base: bool) -> None:
    """However long it takes: 10 kg on 4 kN/m near 20 rad/s, by the formula of the books; both routes agree."""
    speed = 20.0 * (1.0 + off)
    steady = speed**2 / abs(20.0**2 - speed**2) * 1e-3 if on_base else 1.0 / abs(4e3 - 10.0 * speed**2)
    press, fan = TABLE["excitations"]["press"], TABLE["excitations"]["fan"]
    given = {**press, "displacement": "1 mm"} if on_base else {**fan, "amplitude": "1 N"}
    asks = TABLE["measures"]["rattle" if on_base else "place"]
    links = {"mount": {**TABLE["links"]["mount"], "damping": "0 N s/m"}}
    found = asked({"asked": asks}, links=links, excitations={"it": {**given, "speed": f"{speed!r} rad/s"}})
    free = 20.0 / speed if on_base else speed / 20.0
    assert found["asked"] == pytest.approx(steady * (1.0 + free), rel=1e-6)


def test_a_slow_beat_that_hardly_fades_is_followed_to_its_greatest_value() -> None:
    """Over a thousand periods to the first top of a beat, by the formula of the books on a grid."""
    speed, c = 20.0 * (1.0 + 4e-4), 1e-3
    force = {**TABLE["excitations"]["fan"], "amplitude": "1 N", "speed": f"{speed!r} rad/s"}
    links = {"mount": {**TABLE["links"]["mount"], "damping": f"{c} N s/m"}}
    found = asked({"asked": TABLE["measures"]["place"]}, links=links, excitations={"it": force})
    times = np.linspace(370.0, 410.0, 50_001)
    assert found["asked"] == pytest.approx(np.abs(begun(400.0, 0.1 * c, speed, times)).max() / MASS, rel=1e-5)


@pytest.mark.parametrize(("off", "ratio"), [(1e-5, 2.5e-6), (2e-5, 1e-5), (-1e-4, 1e-5)])
def test_beats_that_fade_slower_than_they_beat_have_one_value_on_both_routes(off: float, ratio: float) -> None:
    """Its envelope next to resonance, as in the books: 1 - e^(-d t + i (w - wd) t), times what is steady."""
    speed = 20.0 * (1.0 + off)
    force = {**TABLE["excitations"]["fan"], "amplitude": "1 N", "speed": f"{speed!r} rad/s"}
    links = {"mount": {**TABLE["links"]["mount"], "damping": f"{2.0 * ratio * 20.0 * MASS!r} N s/m"}}
    found = asked({"asked": TABLE["measures"]["place"]}, links=links, excitations={"it": force})
    steady = 1.0 / (MASS * np.hypot(400.0 - speed**2, 40.0 * ratio * speed))
    times = np.linspace(0.0, 4.0 * np.pi / (20.0 * abs(off)), 1_000_001)
    beats = np.abs(1.0 - np.exp(times * (-20.0 * ratio + 1j * (speed - 20.0 * np.sqrt(1.0 - ratio**2)))))
    assert found["asked"] == pytest.approx(steady * beats.max(), rel=abs(off))  # it begins with another speed


@settings(derandomize=True, database=None, deadline=None, max_examples=25)
@given(seed=st.integers(0, 10_000), count=st.integers(1, 4), length=st.sampled_from([3.0, 400.0]))
def test_no_sample_of_beating_waves_is_higher(seed: int, count: int, length: float) -> None:
    rng = np.random.default_rng(seed)
    speeds = rng.uniform(0.0, 3.0) + rng.choice([0.0, 0.01, 1.0]) * rng.uniform(0.0, 1.0, count)
    rates = 1j * speeds - 10.0 ** rng.uniform(-4.0, -1.0, count)
    waves = rng.normal(size=count) + 1j * rng.normal(size=count)
    value, at, left = highest(rates, waves, length, 0.0)
    times = np.linspace(0.0, length, 200_001)
    values = np.abs((waves @ np.exp(rates[:, None] * times)).real)
    assert not left
    assert values.max() * (1.0 - 1e-9) <= value <= values.max() * (1.0 + 1e-4)
    assert abs((waves @ np.exp(rates * at)).real) == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize("damping", [1e3, 1e5, 1e7])
def test_a_far_too_great_damper_takes_a_sudden_sine_up_from_rest(damping: float) -> None:
    """It is pushed one way for half a turn: twice the distance of the steady motion, once what is fast has faded."""
    begins = replace(sine(0.2, 30.0, 0.0, 2.0 * np.pi), endless=True)
    numbers = (np.array([[one]]) for one in (MASS, damping, 200.0))
    found = Transient(*numbers, 1, np.ones((1, 1)), (begins,)).peak(Reading(np.ones(1), np.zeros(1), np.zeros(1)))
    assert abs(found.value) == pytest.approx(2.0 * 30.0 / (damping * 10.0 * np.pi), rel=max(50.0 / damping, 1e-5))
    assert found.time == pytest.approx(0.1, rel=max(200.0 / damping, 1e-4))


def test_a_sum_over_several_times_is_drawn_part_by_part() -> None:
    """The greatest of the parts, each by itself, add up to what the answer tells."""
    design = vo.solve(vo.read(Path(__file__).parents[2] / "problems/shock/rao_9_72.toml"), explain=False)
    drawn = panels(design)
    assert [one.title for one in drawn] == [
        f"Peak displacement of head, {name} by itself" for name in ("crane", "press", "compressor")
    ]
    total = sum(abs(mark.y) for one in drawn for mark in one.marks)
    assert total == pytest.approx(1e6 * float(design.limits["cutter"].value.value), rel=1e-9)
