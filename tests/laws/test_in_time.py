"""What comes once: closed forms of the literature, a Runge-Kutta route, and laws of peaks in time."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, get_args

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import vibopt as vo
from refusals import refused
from vibopt.arrays import FloatArray
from vibopt.errors import InputError
from vibopt.excitations.pulse import Pulse, Shape
from vibopt.excitations.record import Record
from vibopt.excitations.segments import line, sine, together
from vibopt.mechanics.readout import Reading
from vibopt.mechanics.transient import Transient
from vibopt.program.pose import pose
from vibopt.report.curves import panels
from vibopt.signals import Segment, side_by_side
from vibopt.verify.certify import measure

few = settings(derandomize=True, database=None, deadline=None, max_examples=15)
NOTHING = np.zeros(1)
OVER = [shape for shape in get_args(Shape) if shape != "step"]


def lone(k: float, c: float, *segments: Segment) -> Transient:
    """1 kg on a spring and a damper, pushed."""
    return Transient(np.eye(1), np.array([[c]]), np.array([[k]]), 1, np.eye(1), segments)


def place(n: int = 1, power: int = 0) -> Reading:
    return Reading(np.eye(n)[0], np.zeros(n), np.zeros(n), power)


@pytest.mark.parametrize("turns", [0.1, 0.4, 0.75, 1.5, 3.3, 12.0])
def test_a_half_sine_on_an_undamped_mass_is_as_in_the_books(turns: float) -> None:
    """Peak over static displacement with w / w_n = 1 / (2 turns), primary or residual (Harris, chapter 8)."""
    length = 2.0 * np.pi * turns
    r = np.pi / length
    residual = 2.0 * r * abs(np.cos(0.5 * length)) / abs(1.0 - r * r)
    times = np.linspace(0.0, length, 200_001)
    primary = np.abs((np.sin(r * times) - r * np.sin(times)) / (1.0 - r * r)).max()
    found = lone(1.0, 0.0, sine(length, 1.0, 0.0, np.pi)).peak(place()).value
    assert abs(found) == pytest.approx(max(residual, primary), rel=1e-8)


def test_the_greatest_of_all_half_sines_and_rectangles() -> None:
    """1.768 at 0.81 periods (Harris); 2 for a rectangle of half a period or longer, 2 sin(pi t / T) for a shorter."""
    most = max(
        abs(lone(1.0, 0.0, sine(2.0 * np.pi * turns, 1.0, 0.0, np.pi)).peak(place()).value)
        for turns in np.linspace(0.7, 0.9, 81)
    )
    assert most == pytest.approx(1.768, abs=5e-4)
    for turns in (0.05, 0.3, 0.5, 2.2):
        found = lone(1.0, 0.0, line(2.0 * np.pi * turns, 1.0, 1.0)).peak(place()).value
        assert abs(found) == pytest.approx(2.0 if turns >= 0.5 else 2.0 * np.sin(np.pi * turns), rel=1e-10)


@pytest.mark.parametrize("turns", [1e5, 1e7])
@pytest.mark.parametrize("ratio", [1e-3, 0.05, 1.0, 20.0])
def test_a_pulse_of_a_million_periods_is_that_of_the_books(turns: float, ratio: float) -> None:
    """Sudden: one overshoot. Slow: what a sine of the same frequency does for ever, to first order a sag that lags."""
    length = 2.0 * np.pi * turns
    over = np.exp(-np.pi * ratio / np.sqrt(1.0 - ratio**2)) if ratio < 1.0 else 0.0
    rectangle = lone(1.0, 2.0 * ratio, line(length, 1.0, 1.0)).peak(place())
    assert rectangle.value == pytest.approx(1.0 + over, rel=1e-9)
    half = lone(1.0, 2.0 * ratio, sine(length, 1.0, 0.0, np.pi)).peak(place())
    r = np.pi / length
    assert half.value == pytest.approx(1.0 / np.hypot(1.0 - r * r, 2.0 * ratio * r), rel=1e-9)
    assert half.time == pytest.approx(0.5 * length + 2.0 * ratio, rel=1e-6)
    bend = lone(1.0, 2.0 * ratio, line(0.5 * length, 0.0, 1.0), line(0.5 * length, 1.0, 0.0)).peak(place(power=1))
    assert abs(bend.value) == pytest.approx(2.0 / length * (1.0 + 2.0 * over), rel=1e-7)


@pytest.mark.parametrize("turns", [50.0, 5000.0])
def test_a_long_push_of_what_is_loose_strains_its_spring_by_half(turns: float) -> None:
    """Two masses of one, one pushed: the spring holds half the force, and nearly twice that at once."""
    stiff = np.array([[1.0, -1.0], [-1.0, 1.0]])
    loose = Transient(np.eye(2), 0.1 * stiff, stiff, 2, np.array([[1.0], [0.0]]), (line(turns, 1.0, 1.0),))
    found = loose.peak(Reading(np.array([1.0, -1.0]), np.zeros(2), np.zeros(2)))
    ratio = 0.1 / np.sqrt(2.0)
    assert found.value == pytest.approx(0.5 * (1.0 + np.exp(-np.pi * ratio / np.sqrt(1.0 - ratio**2))), rel=1e-9)


@pytest.mark.parametrize("on", ["box", "floor"])
@pytest.mark.parametrize("shape", ["triangle", "rising sawtooth", "versed sine"])
def test_long_loads_have_one_value_on_both_routes_until_nothing_fades(shape: str, on: str) -> None:
    """A million periods of a chain with a joint: what fades early, and what follows the load, by another way each."""
    size = {"amplitude": "10 N"} if on == "box" else {"acceleration": "2 m/s²"}
    shaken = {"kind": "pulse", "on": on, "shape": shape, "duration": "1e6 s", **size}
    document: dict[str, Any] = {
        "title": "long",
        "bases": {"floor": {}},
        "bodies": {"box": {"mass": "2 kg"}, "lamp": {"mass": "1 kg"}, "joint": {"mass": "0 kg"}},
        "links": {
            "mount": {"between": ["box", "floor"], "stiffness": "150 N/m", "damping": "9 N s/m"},
            "arm": {"between": ["lamp", "joint"], "stiffness": "90 N/m"},
            "grip": {"between": ["joint", "box"], "damping": "8 N s/m", "stiffness": "40 N/m"},
        },
        "excitations": {"it": shaken},
        "measures": {
            "force": {"response": "peak_force", "through": "mount"},
            **({"travel": {"response": "peak_relative_displacement", "across": "arm"}} if on == "floor" else {}),
        },
    }
    found = told(document)
    assert found["force"] == pytest.approx({"box": 10.0, "floor": 6.0}[on], rel=1e-3)
    assert found.get("travel", 2.0 / 90.0) == pytest.approx(2.0 / 90.0, rel=1e-3)
    undamped = {name: {**link, "damping": "0 N s/m"} for name, link in document["links"].items() if name != "arm"}
    with pytest.raises(InputError, match="more than the 20000 that are followed"):
        vo.from_dict({**document, "links": {**document["links"], **undamped}})


@few
@given(seed=st.integers(0, 10_000), count=st.integers(1, 4), shape=st.sampled_from(OVER), free=st.booleans())
def test_no_simulation_finds_a_higher_peak(seed: int, count: int, shape: str, free: bool) -> None:
    """Chains under any pulse: a fine trapezoidal rule comes near the peak and never beyond; slopes are differences."""
    rng = np.random.default_rng(seed)
    mass = np.diag(10.0 ** rng.uniform(-1, 1, count))
    table = np.eye(count) - np.eye(count, k=-1)
    springs, dampers = 10.0 ** rng.uniform(1, 3, count), 10.0 ** rng.uniform(-2, 0.7, count)
    if free and count > 1:
        springs[0] = dampers[0] = 0.0
    stiff, damped = ((table.T * one) @ table for one in (springs, dampers))
    rate = float(np.sqrt(np.linalg.eigvalsh(np.linalg.solve(mass, stiff)).max()))
    length = 10.0 ** rng.uniform(-1.0, 1.0) * 2.0 * np.pi / rate
    words = {"frequency": f"{0.2 * rate} rad/s", "damping_ratio": 0.3} if "decaying" in shape else {}
    pulse = Pulse(kind="pulse", on="a", shape=shape, amplitude="1 N", **(words or {"duration": f"{length!r} s"}))
    row = table[-1] if free and count > 1 else np.eye(count)[-1]
    machine = Transient(mass, damped, stiff, count, np.eye(count)[:, :1], pulse.segments())
    reading = Reading(row, np.zeros(count), np.zeros(count))
    found = machine.peak(reading)
    end = pulse.length + 12.0 * np.pi / rate
    values = simulated(mass, damped, stiff, pulse, row, end)
    assert np.abs(values).max() <= abs(found.value) * (1.0 + 1e-4)
    if found.time < end:
        assert np.abs(values).max() >= abs(found.value) * (1.0 - 1e-3)
    other = [
        Transient(mass, damped, stiff * (1.0 + step), count, np.eye(count)[:, :1], pulse.segments()).peak(reading).value
        for step in (-1e-5, 1e-5)
    ]
    slope = Transient(mass, damped, stiff * (1.0 + 1e-30j), count, np.eye(count)[:, :1], pulse.segments()).at(
        reading, found.within, found.part
    )
    if abs(sum(np.abs(other)) - 2.0 * abs(found.value)) < 1e-8 * abs(found.value):
        assert slope.imag / 1e-30 == pytest.approx((other[1] - other[0]) / 2e-5, rel=1e-3, abs=1e-6 * abs(found.value))


def simulated(
    mass: FloatArray, damped: FloatArray, stiff: FloatArray, pulse: Pulse, row: FloatArray, end: float
) -> FloatArray:
    """Newmark's average acceleration with steps of one length, of which the pulse holds a whole number."""
    count = len(mass)
    turns = end * np.sqrt(np.linalg.eigvalsh(np.linalg.solve(mass, stiff)).max()) / (2.0 * np.pi)
    inside = int(np.ceil(max(10_000, 500 * turns) * pulse.length / end))
    step = pulse.length / inside
    times = step * np.arange(int(end / step) + 1)
    loads = pulse.signal(times * (1.0 - 1e-12))
    loads[inside] *= 0.5  # a jump there is halfway
    whole = np.linalg.inv(mass + 0.5 * step * damped + 0.25 * step**2 * stiff)
    x, v = np.zeros(count), np.zeros(count)
    push = np.eye(count)[0]
    a = np.linalg.solve(mass, push * loads[0])
    found = np.zeros(len(times))
    for i, load in enumerate(loads[1:], start=1):
        x_next, v_next = x + step * v + 0.25 * step**2 * a, v + 0.5 * step * a
        a = whole @ (push * load - damped @ v_next - stiff @ x_next)
        x, v = x_next + 0.25 * step**2 * a, v_next + 0.5 * step * a
        found[i] = row @ x
    return found


@few
@given(parts=st.lists(st.floats(0.05, 2.0), min_size=1, max_size=5), k=st.floats(0.1, 50.0), c=st.floats(0.0, 20.0))
def test_a_ramp_cut_into_pieces_is_the_same_ramp(parts: list[float], k: float, c: float) -> None:
    total = sum(parts)
    ends = np.concatenate([[0.0], np.cumsum(parts)]) / total
    cut = [line(one, low, high) for one, low, high in zip(parts, ends, ends[1:], strict=False)]
    whole, pieces = lone(k, c, line(total, 0.0, 1.0)).peak(place()), lone(k, c, *cut).peak(place())
    assert pieces.value == pytest.approx(whole.value, rel=1e-9)
    assert pieces.time == pytest.approx(whole.time, rel=1e-4, abs=1e-4 * total)


def test_extremes_of_length_damping_and_count_keep_their_digits() -> None:
    """A pulse of a millionth of a period is a blow, one of a thousand is static; 1 000 times critical damping."""
    blow = lone(1.0, 0.0, sine(1e-6, 1.0, 0.0, np.pi)).peak(place())
    assert abs(blow.value) == pytest.approx(2e-6 / np.pi, rel=1e-9)
    slow = lone(1.0, 1e-3, sine(2e3 * np.pi, 1.0, 0.0, np.pi)).peak(place())
    assert abs(slow.value) == pytest.approx(1.0, rel=1e-3)
    stiff = lone(1.0, 2e3, line(1.0, 1.0, 1.0)).peak(place())
    assert abs(stiff.value) == pytest.approx((1.0 - 1.0 / 2e3) / 2e3, rel=1e-3)


def test_several_signals_begin_together_and_add_up() -> None:
    long, short = (sine(2.0, 3.0, 0.0, np.pi),), (line(0.3, 0.0, 5.0), line(0.4, 5.0, 0.0))
    both = Transient(np.eye(1), np.eye(1), 9.0 * np.eye(1), 1, np.ones((1, 2)), together([long, short]))
    times = np.linspace(0.0, 6.0, 61)
    alone = [
        Transient(np.eye(1), np.eye(1), 9.0 * np.eye(1), 1, np.eye(1), one).history(place(), times)
        for one in (long, short)
    ]
    assert both.history(place(), times) == pytest.approx(sum(alone), rel=1e-10, abs=1e-14)


BOX: dict[str, Any] = {
    "title": "instrument in its box",
    "bases": {"box": {}},
    "bodies": {"instrument": {"mass": "10 kg"}},
    "links": {"foam": {"between": ["instrument", "box"], "stiffness": "30 kN/m", "damping": "300 N s/m"}},
    "excitations": {"fall": {"kind": "drop", "on": "box", "height": "0.3 m"}},
    "measures": {
        "acceleration": {"response": "peak_acceleration", "of": "instrument"},
        "rattle": {"response": "peak_relative_displacement", "across": "foam"},
        "force": {"response": "peak_force", "through": "foam"},
        "whole": {"response": "peak_force", "into": "instrument"},
    },
}


def told(document: dict[str, Any]) -> dict[str, float]:
    """Values of the measures; both routes agree on them."""
    answer = vo.solve(vo.from_dict(document))
    assert answer.status == "met", answer.claim
    return {name: one.value.value for name, one in answer.measures.items()}


def test_an_undamped_drop_turns_all_its_speed_into_the_spring() -> None:
    foam = {"between": ["instrument", "box"], "stiffness": "30 kN/m"}
    found = told({**BOX, "links": {"foam": foam}})
    speed, omega = np.sqrt(2.0 * 9.80665 * 0.3), np.sqrt(3e3)
    assert found["acceleration"] == pytest.approx(speed * omega, rel=1e-9)
    assert found["rattle"] == pytest.approx(speed / omega, rel=1e-9)
    assert found["force"] == pytest.approx(found["whole"], rel=1e-9)
    document = {**BOX, "links": {"foam": foam}, "excitations": {"fall": {**BOX["excitations"]["fall"], "rebound": 0.4}}}
    assert told(document)["rattle"] == pytest.approx(1.4 * speed / omega, rel=1e-9)


@pytest.mark.parametrize("stiffness", [12e3, 25.05e3, 70e3])
def test_two_bodies_that_nothing_damps_meet_after_a_drop_as_their_waves_do(stiffness: float) -> None:
    """Both sines of the books over a thousand periods of the slower mode, sampled and then refined."""
    links = {
        "feet": {"between": ["frame", "box"], "stiffness": "54 kN/m"},
        "foam": {"between": ["instrument", "frame"], "stiffness": f"{stiffness} N/m"},
    }
    bodies = {"frame": {"mass": "711 kg"}, "instrument": {"mass": "99.7 kg"}}
    measures = {"rattle": {"response": "peak_relative_displacement", "across": "foam"}}
    found = told({**BOX, "bodies": bodies, "links": links, "measures": measures})
    mass, below = np.diag([711.0, 99.7]), np.array([[54e3 + stiffness, -stiffness], [-stiffness, stiffness]])
    roots, shapes = np.linalg.eig(np.linalg.solve(mass, below))
    omega, shares = np.sqrt(roots), np.linalg.solve(shapes, np.full(2, np.sqrt(2.0 * 9.80665 * 0.3)))
    waves = (shapes[1] - shapes[0]) * shares / omega
    times = np.arange(0.0, 2000.0 * np.pi / omega.min(), 0.02 / omega.max())
    seen = np.abs(waves @ np.sin(np.outer(omega, times)))
    near = times[np.argsort(seen)[-200:], None] + np.linspace(-0.02, 0.02, 401) / omega.max()
    best = float(np.abs(np.einsum("i,ijk", waves, np.sin(omega[:, None, None] * near))).max())
    assert found["rattle"] == pytest.approx(best, rel=1e-7)


def test_many_bodies_that_nothing_damps_are_followed_over_the_same_periods_by_both_routes() -> None:
    """A slowest mode many times slower than the fastest: the first window behind the load is no whole period of it."""
    mass, stiffness = (3.572, 3.202, 1.397, 1.144), (795.6, 169.6, 4347.0, 1299.0)
    links = {
        f"l{i}": {"between": [f"b{i}", f"b{i - 1}" if i else "ground"], "stiffness": f"{one} N/m"}
        for i, one in enumerate(stiffness)
    }
    pulse = {"kind": "pulse", "shape": "sine", "duration": "0.2126 s", "on": "b0", "amplitude": "10 N"}
    bodies = {f"b{i}": {"mass": f"{one} kg"} for i, one in enumerate(mass)}
    measures = {"felt": {"response": "peak_acceleration", "of": "b3"}}
    asked = {"title": "chain", "bodies": bodies, "links": links, "excitations": {"p": pulse}, "measures": measures}
    rows = np.array([[float(i == j) - float(i == j + 1) for j in range(4)] for i in range(4)])
    roots, shapes = np.linalg.eig((rows.T * stiffness @ rows) / np.array(mass)[:, None])
    omega, pushed = np.sqrt(roots), np.linalg.solve(shapes, np.eye(4)[0] * 10.0 / mass[0])
    beat, end = 2.0 * np.pi / 0.2126, 0.2126
    left = beat * (1.0 - np.exp(-1j * omega * end)) / (beat**2 - roots) * pushed / omega
    most = float(np.abs(shapes[3] * roots * left).sum())
    assert 0.998 * most < told(asked)["felt"] < most


@pytest.mark.parametrize("shape", get_args(Shape))
def test_every_pulse_has_one_value_by_both_routes(shape: str) -> None:
    words = {"frequency": "12 Hz", "damping_ratio": 0.2} if "decaying" in shape else {"duration": "25 ms"}
    pulse = {"kind": "pulse", "on": "box", "shape": shape, "acceleration": "30 m/s²", **words}
    again = {} if "decaying" in shape else {"times": 2, "every": "60 ms"}
    if shape == "step":
        pulse, again = {key: one for key, one in pulse.items() if key != "duration"}, {}
    found = told({**BOX, "excitations": {"shock": {**pulse, **again}}})
    assert 0.0 < found["rattle"] < 1.0


def test_an_inerter_hands_a_blow_on_at_once() -> None:
    """The body starts with b / (m + b) of the speed of its base, so the rest of it is left between them."""
    wheel = {"flywheel": {"between": ["instrument", "box"], "inertance": "2 kg"}}
    foam = {"foam": {"between": ["instrument", "box"], "stiffness": "10 kN/m"}}
    document = {**BOX, "links": foam, "inerters": wheel, "measures": {"rattle": BOX["measures"]["rattle"]}}
    speed = np.sqrt(2.0 * 9.80665 * 0.3)
    assert told(document)["rattle"] == pytest.approx(speed * 10.0 / 12.0 / np.sqrt(1e4 / 12.0), rel=1e-9)
    error = refused(vo.from_dict, {**document, "measures": BOX["measures"]})
    assert (
        "scene: measures.acceleration is infinite whatever the design: inerters.flywheel hands the blow of "
        "excitations.fall on at once. Write a pulse with a duration instead." in error.messages
    )


@few
@given(
    st.tuples(*[st.floats(2.0, 20.0)] * 2),
    st.tuples(*[st.floats(3e3, 3e4)] * 2),
    st.tuples(*[st.floats(5.0, 90.0)] * 2),
    st.floats(0.5, 10.0),
    st.floats(0.1, 3.0),
)
def test_beside_an_inerter_that_hands_a_blow_on_springs_pull_as_matrices_say(
    masses: tuple[float, ...], rates: tuple[float, ...], drags: tuple[float, ...], inertance: float, speed: float
) -> None:
    """A body on a base that is struck, with an inerter beside its mount, and another body on it."""
    ends = {"foot": ["lower", "base"], "top": ["upper", "lower"]}
    both = zip(ends, rates, drags, strict=True)
    links = {n: {"between": ends[n], "stiffness": f"{k!r} N/m", "damping": f"{c!r} N s/m"} for n, k, c in both}
    found = told({
        "title": "struck", "bases": {"base": {}}, "links": links,
        "bodies": {n: {"mass": f"{m!r} kg"} for n, m in zip(("lower", "upper"), masses, strict=True)},
        "inerters": {"wheel": {"between": ["lower", "base"], "inertance": f"{inertance!r} kg"}},
        "excitations": {"blow": {"kind": "drop", "on": "base", "velocity_change": f"{speed!r} m/s"}},
        "measures": {
            "foot": {"response": "peak_force", "through": "foot"}, "top": {"response": "peak_force", "through": "top"},
            "upper": {"response": "peak_acceleration", "of": "upper"},
        },
    })  # fmt: skip
    rows = np.array([[1.0, 0.0], [-1.0, 1.0]])
    inverse = np.linalg.inv(np.diag(masses) + inertance * np.diag([1.0, 0.0]))
    pulls = np.hstack([rows * np.array(rates)[:, None], rows * np.array(drags)[:, None]])
    a = np.vstack([np.eye(2, 4, 2), -inverse @ rows.T @ pulls])
    values, vectors = np.linalg.eig(a)
    shares = np.linalg.solve(vectors, np.concatenate([np.zeros(2), -inverse @ np.array(masses) * speed]))
    times = np.linspace(0.0, 4.0 * np.pi / np.abs(values).min(), 40_000)
    seen = np.abs(np.vstack([pulls, a[3]]) @ (vectors * shares) @ np.exp(np.outer(values, times))).max(axis=1)
    for name, sampled in zip(("foot", "top", "upper"), seen, strict=True):
        assert sampled <= found[name] * (1.0 + 1e-9)
        assert found[name] == pytest.approx(sampled, rel=1e-5)


def test_two_bodies_that_ring_on_are_followed_until_they_meet() -> None:
    """Frequencies of 1 and 2 are never both at their greatest; a beat of a hundred periods is waited for."""
    both = {name: {"mass": "1 kg"} for name in ("a", "b")}
    pulse = {"kind": "pulse", "on": "a", "shape": "rectangle", "amplitude": "1 kN", "duration": "1 ms"}

    def found(between: str, damping: str) -> float:
        held = {name: {"between": [name, "ground"], "stiffness": "1 kN/m", "damping": damping} for name in both}
        links = {f"k{name}": one for name, one in held.items()}
        links["kc"] = {"between": ["a", "b"], "stiffness": between, "damping": "0 N s/m"}
        seen = {"d": {"response": "peak_displacement", "of": "b" if damping != "0 N s/m" else "a"}}
        document = {"title": "pair", "bodies": both, "links": links, "excitations": {"p": pulse}, "measures": seen}
        return told(document)["d"]

    time, omega = np.linspace(0.0, 0.25, 400_001), np.sqrt(1e3)
    modes = [1e3 / (2.0 * w * w) * (np.cos(w * (time - 1e-3)) - np.cos(w * time)) for w in (omega, 2.0 * omega)]
    assert found("1.5 kN/m", "0 N s/m") == pytest.approx(np.abs(sum(modes)).max(), rel=1e-7)
    weak = np.linspace(0.0, 60.0, 2_000_001)
    parts = []
    for w, sign in ((omega, 1.0), (np.sqrt(1e3 + 8.0), -1.0)):
        parts.append(sign * 0.5 / w * np.exp(-0.0005 * weak) * np.sin(w * weak))
    assert found("4 N/m", "0.001 N s/m") == pytest.approx(np.abs(sum(parts)).max(), rel=1e-4)


def test_what_drifts_apart_is_infinite_on_both_routes() -> None:
    between = {"left": ["instrument", "box"], "right": ["instrument", "ground"]}
    links = {name: {"between": two, "stiffness": "9 kN/m", "damping": "50 N s/m"} for name, two in between.items()}
    pulse = {"kind": "pulse", "on": "box", "shape": "half sine", "acceleration": "1 g", "duration": "9 ms"}
    rattle = {"rattle": {"response": "peak_relative_displacement", "across": "left"}}
    document = {**BOX, "links": links, "excitations": {"shock": pulse}, "measures": rattle}
    assert told(document)["rattle"] == np.inf
    free = {"title": "free", "bodies": {"puck": {"mass": "2 kg"}, "other": {"mass": "1 kg"}}}
    free["links"] = {"spring": {"between": ["puck", "other"], "stiffness": "1 kN/m", "damping": "1 N s/m"}}
    free["excitations"] = {"hit": {**pulse, "on": "puck", "amplitude": "90 N"}}
    del free["excitations"]["hit"]["acceleration"]
    free["measures"] = {
        "gone": {"response": "peak_displacement", "of": "puck"},
        "speed": {"response": "peak_velocity", "of": "other"},
        "apart": {"response": "peak_relative_displacement", "across": "spring"},
    }
    found = told(free)
    assert found["gone"] == np.inf
    assert 0.0 < found["apart"] < found["speed"] < 1.0


def test_a_record_of_straight_lines_is_the_pulse_of_straight_lines(tmp_path: Path) -> None:
    file = tmp_path / "record.csv"
    file.write_text("time [ms];acceleration [g]\n0;0\n10;2\n20;0\n", encoding="utf-8")
    record = {"kind": "record", "on": "box", "file": str(file), "factor": 1.5}
    pulse = {"kind": "pulse", "on": "box", "shape": "triangle", "acceleration": "3 g", "duration": "20 ms"}
    one, other = (told({**BOX, "excitations": {"shock": shock}}) for shock in (record, pulse))
    assert one == pytest.approx(other, rel=1e-9)


@pytest.mark.parametrize(
    ("rows", "factor", "words"), [("0;0\n10;2", 0.0, "its factor is"), ("0;0\n10;0", 2.0, "all of its samples are")]
)
def test_a_record_that_shakes_nothing_says_so(rows: str, factor: float, words: str, tmp_path: Path) -> None:
    file = tmp_path / "record.csv"
    file.write_text(f"time [ms];acceleration [g]\n{rows}\n", encoding="utf-8")
    record = {"kind": "record", "on": "box", "file": str(file), "factor": factor}
    answer = vo.solve(vo.from_dict({**BOX, "excitations": {"shock": record}}))
    assert {row.value.value for row in answer.measures.values()} == {0.0}
    assert f"excitations.shock: {words} zero: it shakes nothing." in answer.notes


@few
@given(seed=st.integers(0, 10_000), even=st.booleans(), stiff=st.sampled_from([3e3, 3e5]))
def test_records_are_followed_from_sample_to_sample_by_three_roads(seed: int, even: bool, stiff: float) -> None:
    """A box that is shaken and an instrument that is pushed, each at its own times, and a Runge-Kutta method."""
    rng = np.random.default_rng(seed)
    times = [np.cumsum(np.append(0.0, rng.uniform(0.01, 0.03, 12 + i) * (not even) + 0.02 * even)) for i in range(2)]
    values = [rng.normal(size=len(one)) for one in times]
    document = {**BOX, "links": {"foam": {**BOX["links"]["foam"], "stiffness": f"{stiff} N/m"}}, "excitations": {}}
    with TemporaryDirectory() as folder:
        for on, unit, at, size in zip(("box", "instrument"), ("m/s2", "N"), times, values, strict=True):
            rows = "".join(f"{t!r},{one!r}\n" for t, one in zip(at.tolist(), size.tolist(), strict=True))
            Path(folder, f"{on}.csv").write_text(f"t [s],value [{unit}]\n{rows}", encoding="utf-8")
            document["excitations"][on] = {"kind": "record", "on": on, "file": str(Path(folder, f"{on}.csv"))}
        scene: Any = vo.from_dict(document)
        found, rattle = told(document)["rattle"], scene.measures["rattle"]

    def rates(time: float, z: FloatArray, low: float, high: float) -> FloatArray:
        pushed, shaken = (
            float(np.interp(time, at, size)) if at[0] <= low and high <= at[-1] else 0.0
            for at, size in zip(times[::-1], values[::-1], strict=True)
        )
        return np.array([z[1], (pushed - stiff * z[0] - 300.0 * z[1]) / 10.0 - shaken])

    ends = np.unique(np.concatenate([*times, [times[1][-1] + 2.0]]))
    state, most = np.zeros(2), 0.0
    for low, high in pairwise(ends.tolist()):
        run = solve_ivp(
            rates, (low, high), state, "DOP853", rtol=1e-11, atol=1e-15, dense_output=True, args=(low, high)
        )
        seen = np.linspace(low, high, 600 if high - low < 1.0 else 20_000)
        state, most = run.y[:, -1], max(most, float(np.abs(run.sol(seen)[0]).max()))
    assert measure(scene, {}, rattle).value == pytest.approx(found, rel=1e-9)
    assert most == pytest.approx(found, rel=2e-5)
    assert most <= found * (1.0 + 1e-9)


def test_times_with_few_digits_are_evenly_spaced(tmp_path: Path) -> None:
    values = np.sin(np.arange(200) / 9.0) * np.arange(200)
    for name, digits in (("few", 3), ("many", 9)):
        rows = "".join(f"{i / 256:.{digits}f};{value:.5f}\n" for i, value in enumerate(values))
        (tmp_path / f"{name}.csv").write_text(f"t [s];a [m/s²]\n{rows}", encoding="utf-8")
    few, many = (
        told({**BOX, "excitations": {"s": {"kind": "record", "on": "box", "file": str(tmp_path / f"{name}.csv")}}})
        for name in ("few", "many")
    )
    assert few == pytest.approx(many, rel=2e-3)


def test_the_best_spring_and_damper_for_a_drop_are_those_of_the_books() -> None:
    """Least peak acceleration for a rattle space: a d / v^2 = 0.521 at a damping ratio of 0.404 (Sevin and Pilkey)."""
    document = {
        **BOX,
        "links": {
            "foam": {
                "between": ["instrument", "box"],
                "stiffness": {"from": "1 kN/m", "to": "1 MN/m"},
                "damping": {"from": "10 N s/m", "to": "10 kN s/m"},
            }
        },
        "limits": {"rattle": {"response": "peak_relative_displacement", "across": "foam", "at_most": "40 mm"}},
        "goal": {"minimise": "peak_acceleration", "of": "instrument"},
    }
    del document["measures"]
    answer = vo.solve(vo.from_dict(document), explain=False)
    assert answer.status in ("optimal", "feasible")
    k, c = (answer.variables[f"links.foam.{word}"].value.value for word in ("stiffness", "damping"))
    assert c / (2.0 * np.sqrt(10.0 * k)) == pytest.approx(0.404, abs=2e-3)
    assert answer.goal is not None
    assert answer.goal[1].value * 0.04 / (2.0 * 9.80665 * 0.3) == pytest.approx(0.521, abs=1e-3)


@pytest.mark.sampled(2)
@pytest.mark.parametrize("pace", [0.03, 1.0, 1e3, 1e5, 1e6])
@pytest.mark.parametrize("blow", ["drop", "release"])
def test_a_blow_has_no_length_of_its_own_on_a_machine_of_any_pace(blow: str, pace: float) -> None:
    """A machine so many times as fast, of a camera or of a sensor of silicon, is braked as the book says."""
    size, mass, speed = pace**-2, pace**-3, 4.0 / pace
    loads = {
        "drop": f'on = "case"\nvelocity_change = "{speed!r} m/s"',
        "release": f'on = "camera"\nvelocity = "{speed!r} m/s"',
    }
    answer: Any = vo.solve(
        vo.from_text(f"""
[bases.case]
[bodies.camera]
mass = "{0.8 * mass!r} kg"
[links.foam]
between = ["camera", "case"]
stiffness = {{ from = "{100.0 * mass * pace**2!r} N/m", to = "{1e5 * mass * pace**2!r} N/m" }}
damping = {{ from = "{0.1 * mass * pace!r} N s/m", to = "{1e3 * mass * pace!r} N s/m" }}
[excitations.load]
kind = "{blow}"
{loads[blow]}
[limits.room]
response = "peak_relative_displacement"
across = "foam"
at_most = "{0.04 * size!r} m"
[goal]
minimise = "peak_force"
through = "foam"
"""),
        explain=False,
    )
    assert answer.status == "optimal"
    assert answer.goal[1].value * 0.04 * size / (0.8 * mass * speed**2) == pytest.approx(0.521, abs=1e-3)


@pytest.mark.parametrize("turns", [40.0, 1e3, 1e4])
def test_a_base_that_is_pushed_far_away_leaves_the_digits_of_what_rides_on_it(turns: float) -> None:
    """Two masses in a row, undamped, under a constant acceleration for so many turns: by modes; and slopes."""
    springs = np.array([1.0, 0.4])
    table = np.array([[1.0, 0.0, -1.0], [-1.0, 1.0, 0.0]])
    stiff = (table.T * springs) @ table
    length = 2.0 * np.pi * turns
    squares, shapes = np.linalg.eigh(stiff[:2, :2])
    share = shapes[0] * shapes.sum(axis=0) / squares
    times = np.linspace(0.0, length, int(40 * turns) + 1)
    seen = np.abs((1.0 - np.cos(np.outer(times, np.sqrt(squares)))) @ share).max()
    mass, moved = np.diag([1.0, 1.0, 0.0]), np.eye(3)[:, 2:]
    apart, none = np.array([1.0, 0.0, -1.0]), np.zeros(3)
    reading = Reading(apart, none, none)
    machine = Transient(mass, np.zeros((3, 3)), stiff, 2, moved, (line(length, 1.0, 1.0),))
    found = machine.peak(reading)
    assert seen * (1.0 - 1e-12) <= abs(found.value) <= 2.0 * np.abs(share).sum()
    assert abs(found.value) == pytest.approx(seen, rel=2e-2)
    [at] = machine.history(reading, np.array([found.time]))
    exact = float((1.0 - np.cos(found.time * np.sqrt(squares))) @ share)
    assert abs(at) == pytest.approx(exact, rel=1e-10)
    assert abs(found.value) == pytest.approx(exact, rel=1e-10)


def test_a_history_stays_below_the_mark_of_its_greatest_value_and_reaches_it() -> None:
    document = {**BOX, "limits": {"room": {**BOX["measures"]["rattle"], "at_most": "50 mm"}}}
    design = vo.solve(vo.from_dict(document))
    drawn = panels(design)
    assert [one.title for one in drawn] == [
        "Peak relative displacement across foam", "Peak acceleration of instrument", "Peak force through foam",
        "Peak force into instrument", "Peak acceleration against rattle space",
    ]  # fmt: skip
    for panel in drawn[:-1]:
        [curve], [mark] = panel.curves, panel.marks
        assert np.abs(curve.y).max() == pytest.approx(abs(mark.y), rel=1e-9)
        assert curve.y[curve.x.searchsorted(mark.x)] == pytest.approx(mark.y, rel=1e-6)
        assert np.abs(curve.y).max() < panel.y_span[1]
    assert drawn[0].y_label == "relative displacement [mm]"
    assert [(zone.bound, zone.above) for zone in drawn[0].zones] == [(50.0, True), (-50.0, False)]


def test_of_peaks_that_are_as_great_the_one_that_is_named_is_marked() -> None:
    """Without damping every turn behind a fall reaches as far."""
    foam = {"between": ["instrument", "box"], "stiffness": "23.5 kN/m"}
    limits = {"room": {**BOX["measures"]["rattle"], "at_most": "50 mm"}}
    design = vo.solve(vo.from_dict({**BOX, "links": {"foam": foam}, "limits": limits, "measures": {}}))
    [panel] = panels(design)
    [mark] = panel.marks
    [named] = design.limits["room"].worst_at.values()
    assert mark.x * (1e-3 if "[ms]" in panel.x_label else 1.0) == pytest.approx(named.value, rel=1e-9)


WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "steady": (
        {"measures": {"a": {"response": "displacement", "of": "instrument"}}},
        "measures.a: displacement is of a steady vibration, but excitations.fall comes once and is over. Write "
        'response = "peak_displacement".',
    ),
    "infinite": (
        {"measures": {"a": {"response": "peak_displacement", "of": "instrument"}}},
        "measures.a is infinite whatever the design: the base of excitations.fall, whose acceleration is given, moves "
        "on behind it, and instrument with it. Ask for peak_relative_displacement across a link.",
    ),
    "lossy": (
        {"links": {"foam": {"between": ["instrument", "box"], "stiffness": "30 kN/m", "loss_factor": 0.1}}},
        "measures.acceleration asks for the greatest in time, but links.foam has a loss_factor, which speaks of steady "
        "harmonic motion only. Give it damping or damping_ratio instead.",
    ),
    "speed": (
        {"excitations": {"fall": {"kind": "drop", "on": "box", "height": "0.3 m", "speed": "20 Hz"}}},
        'excitations.fall.speed = "20 Hz" is a speed, but this kind of excitation has none. Leave it out.',
    ),
    "amplitude": (
        {"excitations": {"e": {"kind": "pulse", "on": "box", "shape": "sine", "amplitude": "15 g", "duration": "1 s"}}},
        'excitations.e.amplitude = "15 g" is an acceleration, which only a base has. Write acceleration = "15 g".',
    ),
    "amplitude of a motion": (
        {"excitations": {"e": {"kind": "base_motion", "on": "box", "amplitude": "1 mm", "speed": "300 rpm"}}},
        'unknown key "amplitude" in excitations.e. Did you mean "displacement"?',
    ),
    "earthquake": (
        {"excitations": {"e": {"kind": "earthquake", "on": "box", "file": "a.csv"}}},
        'excitations.e.kind = "earthquake" is no kind that vibopt knows. Did you mean "record"?',
    ),
    "rate": (
        {"excitations": {"e": {"kind": "force", "on": "instrument", "amplitude": "1 N", "speed": "300 rpm",
                               "run_up": {"rate": "10 rpm/s"}}}},
        'unknown key "rate" in excitations.e.run_up. Did you mean "acceleration"?',
    ),
    "nothing": (
        {"excitations": {"fall": {"kind": "drop", "on": "box"}}},
        'excitations.fall needs one of height and velocity_change. Write height = "0.5 m".',
    ),
    "both": (
        {"excitations": {"fall": {"kind": "drop", "on": "box", "height": "1 m", "velocity_change": "1 m/s"}}},
        "excitations.fall gives height and velocity_change. Keep one: a drop from a height changes the velocity by as "
        "much.",
    ),
    "zero": (
        {
            "excitations": {
                "s": {"kind": "pulse", "on": "box", "shape": "sine", "acceleration": "1 g", "duration": "0 s"}
            }
        },
        'excitations.s.duration = "0 s" is not greater than zero. Write a positive value, for example "0.2 s".',
    ),
    "too often": (
        {
            "excitations": {
                "s": {
                    "kind": "pulse", "on": "box", "shape": "sine", "acceleration": "1 g", "duration": "1 s", "times": 3,
                    "every": "0.5 s",
                }
            }
        },
        "excitations.s comes again before it is over. Write a longer every, or two excitations.",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_what_makes_no_sense_in_time_is_refused(name: str) -> None:
    change, message = WRONG[name]
    assert f"scene: {message}" in refused(vo.from_dict, {**BOX, **change}).messages


BAD: dict[str, tuple[str, str]] = {
    "unit": ("time [s];acceleration\n0;1\n1;2\n2;0\n", 'record.csv, column "acceleration", says no unit. Write it into '
        'the heading: "acceleration [m/s²]", or [g] for gravity, or [N].'),
    "again": ("time [s];a [g]\n0;1\n1;2\n1;0\n", "record.csv row 4: the time of the row before, with another value. "
        "Keep one of both, or write times with more digits."),
    "back": ("time [s];a [g]\n0;1\n2;2\n1;0\n", "record.csv row 4: the time falls from the row before. Sort the rows."),
    "still": ("time [s];a [g]\n1;1\n1;1\n", "record.csv has one time in all of its rows, and a record needs two."),
    "nan": ("time [s];a [g]\n0;1\n1;nan\n2;0\n", 'record.csv row 3: "nan" is no number. Every sample needs its value; '
        "remove the row or mend it."),
    "empty": ("time [s];a [g]\n0;1\n1;\n2;0\n", "record.csv row 3: there is no number. Every sample needs its value; "
        "remove the row or mend it."),
    "no time": ("a [g]\n1\n2\n0\n", 'record.csv has no column "time [s]", and nothing says how far apart its samples '
        'are. Write interval = "5 ms" where they are evenly spaced.'),
    "short": ("time [s];a [g]\n0;1\n", "record.csv has 1 row below its first, and a record needs two. Write a heading "
        "with units, and a row a sample."),
    "one name": ("time [s];a [g];a [g]\n0;1;1\n1;2;1\n2;0;1\n", "record.csv has two columns of one name. Give each its "
        "own in the heading."),
    "several": ("time [s];a [g];b [g]\n0;1;1\n1;2;1\n2;0;1\n", "record.csv has several columns. Write column = one of "
        '"a", "b".'),
    "no name for time": ("x / s;a / g\n0;1\n1;2\n2;0\n", 'record.csv has columns "x / s", "a / g", and none of them is '
        'the time. Write units in brackets: "time [s]", "acceleration [m/s²]"; or interval = "5 ms", and the column.'),
    "heading": ("0;1\n1;2\n2;0\n", "record.csv begins with numbers. Write a heading with units into its first row: "
        '"time [s],acceleration [m/s²]".'),
    "long": ("time [s];a [g]\n0;1\n1;2;5\n2;0\n", "record.csv row 3 has more cells than its heading. Part columns by "
        "semicolons where numbers have decimal commas, or remove what has no heading."),
    "moved": ("time [s];a [mm]\n0;1\n1;2\n2;0\n", 'record.csv, column "a", has the unit "mm", and a displacement is '
        "not what a record says. Write the acceleration that belongs to it."),
    "gap": ("time [s];a [g]\n0;1\n1;2\n2;0\n3;0\n90;0\n", "record.csv row 6: more than 20 samples are missing before "
        "it. Fill the gap, or cut the record."),
}  # fmt: skip


def test_the_motion_of_a_body_is_not_given() -> None:
    fall = {**BOX["excitations"]["fall"], "on": "instrument"}
    assert refused(vo.from_dict, {**BOX, "excitations": {"fall": fall}}).messages == (
        'scene: excitations.fall.on = "instrument" is a body, but the motion of a base is given. Write [bases.floor], '
        'links to it, and on = "floor".',
    )


def test_a_base_takes_no_force_and_is_not_let_go() -> None:
    for blow in (
        {"kind": "pulse", "shape": "half sine", "amplitude": "10 N", "duration": "11 ms"},
        {"kind": "release", "velocity": "1 m/s"},
    ):
        assert refused(vo.from_dict, {**BOX, "excitations": {"fall": {**blow, "on": "box"}}}).messages == (
            'scene: excitations.fall.on = "box" is a base, but what is given acts on a body. Write on = "instrument", '
            'or how the base moves: kind = "base_motion", or the acceleration of a pulse or a record.',
        )


@pytest.mark.parametrize("name", BAD)
def test_a_record_that_cannot_be_used_is_refused(name: str, tmp_path: Path) -> None:
    text, message = BAD[name]
    (tmp_path / "record.csv").write_text(text, encoding="utf-8")
    record = {"kind": "record", "on": "box", "file": str(tmp_path / "record.csv")}
    error = refused(vo.from_dict, {**BOX, "excitations": {"fall": record}})
    assert f"scene: excitations.fall {message}" in error.messages


GROUND = """PEER NGA STRONG MOTION DATABASE RECORD
NOWHERE 1/1/99, STATION, 090
ACCELERATION TIME SERIES IN UNITS OF G
NPTS=    {count}, DT=   .0200 SEC
   .1000000E-01  -.2000000E-01   .5000000E-01
  -.4000000E-01   .0000000E+00
"""


def test_a_ground_record_says_all_itself(tmp_path: Path) -> None:
    file = tmp_path / "station.at2"
    file.write_text(GROUND.format(count=5), encoding="utf-8")
    asked = {"measures": {"room": BOX["measures"]["rattle"]}}
    scene = vo.from_dict({**BOX, **asked, "excitations": {"quake": {"kind": "record", "on": "box", "file": str(file)}}})
    quake: Any = scene.excitations["quake"]
    assert quake.times == pytest.approx(0.02 * np.arange(5), rel=1e-12)
    assert quake.values == pytest.approx(9.80665 * np.array([0.01, -0.02, 0.05, -0.04, 0.0]), rel=1e-12)


@pytest.mark.parametrize(
    ("said", "unit"),
    [("CM/S/S", 0.01), ("cm/sec2.", 0.01), ("CM / SEC / SEC", 0.01), ("GAL", 0.01), ("M/S**2, FILTERED", 1.0),
     ("g. FILTER POINTS: HP=0.1 Hz", 9.80665), ("mm/s^2", 0.001)],
)  # fmt: skip
def test_a_ground_record_is_read_in_the_unit_of_its_heading(said: str, unit: float, tmp_path: Path) -> None:
    file = tmp_path / "station.at2"
    file.write_text(GROUND.format(count=5).replace("OF G", f"OF {said}"), encoding="utf-8")
    record = Record.model_validate({"kind": "record", "on": "box", "file": file})
    assert record.values[2] == pytest.approx(0.05 * unit, rel=1e-12)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            GROUND.format(count=5).replace("ACCELERATION", "VELOCITY").replace("OF G", "OF CM/S"),
            'station.AT2 says "VELOCITY TIME SERIES IN UNITS OF CM/S", and a velocity is not what a record says. Write '
            "the acceleration that belongs to it.",
        ),
        (
            GROUND.format(count=5).replace("ACCELERATION", "DISPLACEMENT"),
            'station.AT2 says "DISPLACEMENT TIME SERIES IN UNITS OF G", and a displacement is not what a record says. '
            "Write the acceleration that belongs to it.",
        ),
        (
            GROUND.format(count=5).replace("OF G", "OF CM"),
            'station.AT2, "ACCELERATION TIME SERIES IN UNITS OF CM", has the unit "cm", and a displacement is not what '
            "a record says. Write the acceleration that belongs to it.",
        ),
        (
            GROUND.format(count=5).replace("OF G", "OF COUNTS"),
            'station.AT2, "ACCELERATION TIME SERIES IN UNITS OF COUNTS", has the unit "counts", of neither an '
            'acceleration nor a force. Write it into the heading: "ACCELERATION TIME SERIES IN UNITS OF G", or CM/S/S.',
        ),
        (
            GROUND.format(count=5).replace(".0200 SEC", "20 MSEC"),
            'station.AT2 has a DT that is not in seconds. Write "DT= .0100 SEC" into its heading.',
        ),
        (
            GROUND.format(count=5).replace(" IN UNITS OF G", ""),
            'station.AT2 says no unit. Write it into its heading: "ACCELERATION TIME SERIES IN UNITS OF G", or CM/S/S.',
        ),
        (
            GROUND.format(count=6),
            "station.AT2 has 5 samples 0.02 s apart, and its heading says 6. Mend the file.",
        ),
        (
            "1 2 3\n4 5 6\n",
            'station.AT2 is no ground record: its heading has no "NPTS= 4000, DT= .0100 SEC", or what follows is no '
            "numbers. Write it as a CSV file with time [s] and acceleration [g].",
        ),
    ],
)
def test_a_broken_ground_record_is_refused(text: str, words: str, tmp_path: Path) -> None:
    file = tmp_path / "station.AT2"
    file.write_text(text, encoding="utf-8")
    error = refused(vo.from_dict, {**BOX, "excitations": {"quake": {"kind": "record", "on": "box", "file": str(file)}}})
    assert f"scene: excitations.quake {words}" in error.messages


def test_a_steady_vibration_that_a_peak_leaves_out_is_named() -> None:
    both = {
        "title": "both",
        "bodies": {"m": {"mass": "500 kg"}},
        "links": {"s": {"between": ["m", "ground"], "stiffness": "2 MN/m", "damping_ratio": 0.05}},
        "excitations": {
            "comp": {"kind": "force", "on": "m", "amplitude": "300 N", "speed": "900 rpm"},
            "press": {"kind": "pulse", "on": "m", "shape": "rectangle", "amplitude": "1 kN", "duration": "40 ms"},
        },
        "measures": {"peak": {"response": "peak_displacement", "of": "m"}},
    }
    words = (
        "measures.peak is of what comes once alone, without excitations.comp, which is steady. To count both write "
        'combine = "sum", or begins = "suddenly" there.'
    )
    assert words in vo.solve(vo.from_dict(both)).notes
    summed = {"peak": {"response": "peak_displacement", "of": "m", "combine": "sum"}}
    assert words not in vo.solve(vo.from_dict({**both, "measures": summed})).notes


def test_samples_that_were_left_out_of_an_even_record_are_on_straight_lines(tmp_path: Path) -> None:
    values = np.random.default_rng(3).normal(size=60)
    kept = np.setdiff1d(np.arange(60), np.arange(6, 58, 7))
    filled = np.interp(np.arange(60), kept, values[kept])
    found = []
    for name, places, sizes in (("left", kept, values[kept]), ("whole", np.arange(60), filled)):
        rows = "\n".join(f"{0.01 * i:.2f};{one!r}" for i, one in zip(places.tolist(), sizes.tolist(), strict=True))
        (tmp_path / f"{name}.csv").write_text(f"t [s];a [m/s²]\n{rows}", encoding="utf-8")
        record = {"kind": "record", "on": "box", "file": str(tmp_path / f"{name}.csv")}
        found.append(told({**BOX, "excitations": {"s": record}}))
    assert found[0] == pytest.approx(found[1], rel=1e-12)


@pytest.mark.parametrize(
    ("head", "tail", "column"),
    [
        ("# Logger of the lab, 200 Hz\n\ntime [s],a [g]", "", None),  # lines of a logger above the heading
        ("Serial;12\ntime [s],a [g]", "", None),
        ("Zeit [s],a [g]", "", None),  # the only unit of time
        ("time [s],a [g],", ",", None),  # a column of nothing
        ("time [s],a [g],b [N]", ",1", "A [g]"),  # named as it stands there
    ],
)
def test_a_record_is_read_as_loggers_write_it(head: str, tail: str, column: str | None, tmp_path: Path) -> None:
    (tmp_path / "record.csv").write_text(
        head + "".join(f"\n{0.1 * i:.1f},{i * i}{tail}" for i in range(4)), encoding="utf-8"
    )
    named = {} if column is None else {"column": column}
    record = {"kind": "record", "on": "box", "file": str(tmp_path / "record.csv"), **named}
    read: Any = vo.from_dict({**BOX, "excitations": {"s": record}}).excitations["s"]
    assert read.times == pytest.approx(0.1 * np.arange(4))
    assert read.values == pytest.approx(9.80665 * np.arange(4) ** 2)


def test_missing_and_repeated_samples_of_a_record_are_told_or_count_once(tmp_path: Path) -> None:
    """Missing where the rest is even: told with the row. An uneven record has none, and a row written twice is one."""
    rng = np.random.default_rng(5)
    even = 0.01 * np.arange(40)
    times = {"even": even, "twice": np.sort(np.append(even, even[[4, 9, 9]])), "missing": np.delete(even, [7, 20, 21])}
    times["uneven"] = np.cumsum(rng.uniform(0.002, 0.03, 40))
    found, notes = {}, {}
    for name, own in times.items():
        rows = "\n".join(f"{one!r};{float(np.sin(9.0 * one))!r}" for one in own.round(6).tolist())
        (tmp_path / f"{name}.csv").write_text(f"t [s];a [m/s²]\n{rows}", encoding="utf-8")
        record = {"kind": "record", "on": "box", "file": str(tmp_path / f"{name}.csv")}
        answer = vo.solve(vo.from_dict({**BOX, "excitations": {"s": record}}))
        assert answer.status == "met", answer.claim
        found[name] = answer.measures["rattle"].value.value
        notes[name] = [note for note in answer.notes if "samples" in note]
    assert found["twice"] == found["even"]
    assert notes.pop("missing") == [
        "excitations.s: samples are missing in missing.csv at 2 places, the widest before row 21 (30 ms where the rest "
        "is 10 ms apart). What lies there is taken as straight; fill it in where it is not."
    ]
    assert not any(notes.values())


@pytest.mark.parametrize("form", ["{:.3f}", "{:.4f}"])
def test_a_table_may_quote_decimal_commas_between_commas(form: str, tmp_path: Path) -> None:
    """As a spreadsheet writes them; "1,500" beside "0,010" parts no thousands."""
    found = []
    for name, quote in (("comma", True), ("point", False)):
        cells = [(form.format(0.01 * i), form.format(np.sin(0.3 * i))) for i in range(30)]
        rows = [",".join(f'"{one.replace(".", ",")}"' if quote else one for one in row) for row in cells]
        (tmp_path / f"{name}.csv").write_text("\n".join(["t [s],a [m/s²]", *rows]), encoding="utf-8")
        record = {"kind": "record", "on": "box", "file": str(tmp_path / f"{name}.csv")}
        found.append(told({**BOX, "excitations": {"s": record}}))
    assert found[0] == found[1]


@pytest.mark.parametrize("stiffness", ["30 kN/m", "1 MN/m", "100 MN/m", "40 GN/m"])
def test_a_long_load_on_a_stiff_machine_has_one_value_by_both_routes(stiffness: str, tmp_path: Path) -> None:
    """Up to thousands of vibrations under one half sine; and near the static value where it is stiff."""
    file = tmp_path / "stiff.toml"
    file.write_text(
        f'[bodies.tank]\nmass = "100 t"\n[links.columns]\nbetween = ["tank", "ground"]\nstiffness = "{stiffness}"\n'
        '[excitations.blast]\nkind = "pulse"\non = "tank"\nshape = "half sine"\namplitude = "10 kN"\nduration = "8 s"\n'
        '[limits.sway]\nresponse = "peak_displacement"\nof = "tank"\nat_most = "1 m"\n'
    )
    scene: Any = vo.read(file)
    program = pose(scene)
    limit = program.limits[0]
    by_machine = measure(scene, {}, scene.limits["sway"]).value
    assert by_machine == pytest.approx(limit.form.value(limit.model, np.zeros(0)), rel=1e-11)
    static = 1e4 / limit.model.scales.max() if stiffness == "40 GN/m" else None
    assert static is None or by_machine == pytest.approx(static, rel=1e-2)


@pytest.mark.parametrize("damping", ["30 kN s/m", "3 MN s/m", pytest.param("1 GN s/m", marks=pytest.mark.slow)])
def test_a_heavily_damped_machine_has_one_value_by_both_routes(damping: str, tmp_path: Path) -> None:
    """Creeping back long after the load, thousands of times slower than it is braked."""
    file = tmp_path / "braked.toml"
    file.write_text(
        f'[bodies.tank]\nmass = "100 t"\n[links.columns]\nbetween = ["tank", "ground"]\nstiffness = "1 kN/m"\n'
        f'damping = "{damping}"\n'
        '[excitations.blast]\nkind = "pulse"\non = "tank"\nshape = "half sine"\namplitude = "10 kN"\nduration = "8 s"\n'
        '[limits.sway]\nresponse = "peak_displacement"\nof = "tank"\nat_most = "1 m"\n'
    )
    scene: Any = vo.read(file)
    limit = pose(scene).limits[0]
    by_machine = measure(scene, {}, scene.limits["sway"]).value
    assert by_machine == pytest.approx(limit.form.value(limit.model, np.zeros(0)), rel=1e-8)
    if damping == "1 GN s/m":
        assert by_machine == pytest.approx(1e4 * 8.0 * 2.0 / np.pi / 1e9, rel=1e-3)


def test_slopes_of_a_mass_under_a_moved_base_are_differences(tmp_path: Path) -> None:
    file = tmp_path / "base.toml"
    file.write_text(
        '[bases.floor]\n[bodies.box]\nmass = { from = "1 kg", to = "9 kg" }\n[links.foam]\nbetween = ["box", "floor"]\n'
        'stiffness = "2 kN/m"\ndamping = "40 N s/m"\n[excitations.jolt]\nkind = "pulse"\non = "floor"\n'
        'shape = "half sine"\nacceleration = "20 m/s²"\nduration = "60 ms"\n'
        '[goal]\nminimise = "peak_velocity"\nof = "box"\n'
    )
    scene: Any = vo.read(file)
    goal, x = pose(scene).aim.pieces[0], np.array([3.0])
    up, down = (np.log(goal.form.value(goal.model, x * np.exp(step))) for step in (1e-5, -1e-5))
    assert goal.form.slope(goal.model, x)[0] == pytest.approx((up - down) / 2e-5, rel=1e-6)


@pytest.mark.parametrize(
    ("mount", "words"),
    [
        (
            'stiffness = "1e18 N/m"',
            "the machine may vibrate 4e+07 times in it, more than the 20000 that are followed. Write a shorter load, "
            "more damping or a smaller stiffness, or leave out a link that is as good as rigid.",
        ),
        (
            'stiffness = "1 kN/m"\ndamping = "1 GN s/m"',
            "dampers may brake the machine 8e+06 times over in it, more than the 100000 that are followed. Write "
            "a shorter load or a smaller damping, or leave out a link that is as good as clamped.",
        ),
    ],
    ids=["rigid", "clamped"],
)
def test_a_machine_that_is_as_good_as_fixed_is_refused_in_time(tmp_path: Path, mount: str, words: str) -> None:
    file = tmp_path / "fixed.toml"
    file.write_text(
        '[excitations.blast]\nkind = "pulse"\non = "tank"\nshape = "half sine"\namplitude = "10 kN"\nduration = "8 s"\n'
        f'[bodies.tank]\nmass = "1 t"\n[links.columns]\nbetween = ["tank", "ground"]\n{mount}\n'
        '[limits.sway]\nresponse = "peak_velocity"\nof = "tank"\nat_most = "1 m/s"\n'
    )
    assert refused(vo.read, file).messages == (f"fixed.toml line 1: excitations.blast lasts 8 s, and {words}",)


@few
@given(seed=st.integers(0, 10_000), shape=st.sampled_from(OVER))
def test_machines_side_by_side_have_the_peaks_that_each_has_alone(seed: int, shape: str) -> None:
    """Undamped to braked, on a base that moves, some loose and one without a damper, each under its own duration."""
    rng = np.random.default_rng(seed)
    count, none = 6, np.zeros(2)
    k = np.where(rng.random(count) < 0.2, 0.0, 10.0 ** rng.uniform(-2, 3, count))
    c = np.where(rng.random(count) < 0.3, 0.0, 10.0 ** rng.uniform(-3, 2, count))
    turned = np.array([[1.0, -1.0], [-1.0, 1.0]])
    fading = "decaying" in shape
    words = [{"frequency": f"{one!r} rad/s", "damping_ratio": 0.2} if fading else {"duration": f"{one!r} s"}
             for one in (10.0 ** rng.uniform(-1.0, 1.0, count)).tolist()]  # fmt: skip
    signals = [Pulse(kind="pulse", on="b", shape=shape, acceleration="1 m/s²", **one).segments() for one in words]
    mass, moved = np.diag([1.0, 0.0]), np.array([[0.0], [1.0]])
    damped, stiff = (one[:, None, None] * turned for one in (c, k))
    apart = Reading(np.array([1.0, -1.0]), none, none)
    row = Transient(np.tile(mass, (count, 1, 1)), damped, stiff, 1, moved, side_by_side(signals))
    alone = [
        Transient(mass, *both, 1, moved, one).peak(apart) for *both, one in zip(damped, stiff, signals, strict=True)
    ]
    for one, other in zip(row.peaks(apart).each(), alone, strict=True):
        assert one.value == pytest.approx(other.value, rel=1e-11, abs=1e-13)
        assert one.open == other.open


def test_a_motion_that_turns_too_often_to_be_followed_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    job = vo.from_dict(
        {
            "title": "push",
            "bodies": {"box": {"mass": "2 kg"}},
            "links": {"foam": {"between": ["box", "ground"], "stiffness": "20 kN/m", "damping": "20 N s/m"}},
            "excitations": {
                "push": {"kind": "pulse", "on": "box", "shape": "half sine", "amplitude": "100 N", "duration": "2 s"}
            },
            "measures": {"shock": {"response": "peak_acceleration", "of": "box"}},
        }
    )
    monkeypatch.setattr("vibopt.mechanics.panels._MOST", 2)
    monkeypatch.setattr("vibopt.mechanics.pulsed._CELLS", 2)
    assert str(refused(vo.solve, job)) == (
        "The machine moves to and fro more often while a load lasts than is followed. Write a shorter load, a smaller "
        '"to" for the stiffness or damping of what is fastest, or a greater "from" for its mass.'
    )


@pytest.mark.parametrize("damping", [100.0, 5000.0])
def test_what_dampers_alone_hold_creeps_to_where_it_stays(damping: float) -> None:
    """200 kg on a damper: a momentum is a way times the damper, however it came, and a sine ends beside its middle."""
    mass, speed, push, length, omega = 200.0, 2.0, 2000.0, 0.01, 30.0
    blow = {"kind": "pulse", "shape": "half sine", "on": "m", "amplitude": f"{push} N", "duration": f"{length} s"}
    sine = {"kind": "force", "on": "m", "amplitude": f"{push} N", "speed": f"{omega} rad/s", "begins": "suddenly"}
    loads = {
        mass * speed: {"kind": "release", "on": "m", "velocity": f"{speed} m/s"},
        2.0 * push * length / np.pi: blow,
        push / omega * (1.0 + damping / np.hypot(damping, mass * omega)): sine,
    }
    for momentum, load in loads.items():
        answer: Any = vo.solve(
            vo.from_dict(
                {
                    "bodies": {"m": {"mass": f"{mass} kg"}},
                    "links": {"d": {"between": ["m", "ground"], "damping": f"{damping} N s/m"}},
                    "excitations": {"load": load},
                    "measures": {"way": {"response": "peak_displacement", "of": "m"}},
                }
            )
        )
        assert answer.status == "met"
        assert answer.measures["way"].value.value == pytest.approx(momentum / damping, rel=1e-9)


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("count", "shape", "duration"),
    [
        pytest.param(count, shape, duration, marks=[pytest.mark.slow] * (count > 2 or (count > 1 and i != j)))
        for count in (1, 2, 3)
        for i, shape in enumerate(("versed sine", "half sine", "triangle"))
        for j, duration in enumerate((0.1, 1e-2, 1e-3))
    ],
)
def test_a_base_that_comes_back_carries_nothing_away(count: int, shape: str, duration: float) -> None:
    """However short it is, of known duration or unknown; of a mass alone the peak is sqrt(k / m) times the area."""
    under = [f"m{i - 1}" if i else "floor" for i in range(count)]
    document: dict[str, Any] = {
        "bodies": {f"m{i}": {"mass": "1 kg"} for i in range(count)},
        "bases": {"floor": {}},
        "links": {f"k{i}": {"between": [f"m{i}", under[i]], "stiffness": "1000 N/m"} for i in range(count)},
        "excitations": {
            "bump": {"kind": "pulse", "on": "floor", "shape": shape, "displacement": "5 mm",
                     "duration": f"{duration!r} s"}
        },
        "measures": {"x": {"response": "peak_displacement", "of": "m0"}},
    }  # fmt: skip
    known = vo.solve(vo.from_dict(document))
    document["excitations"]["bump"]["duration_up_to"] = document["excitations"]["bump"].pop("duration")
    unknown = vo.solve(vo.from_dict(document))
    assert (known.status, unknown.status) == ("met", "met")
    assert unknown.measures["x"].value.value >= known.measures["x"].value.value * (1.0 - 1e-9)
    if count == 1 and duration < 0.01:
        area = 5e-3 * duration * {"half sine": 2.0 / np.pi}.get(shape, 0.5)
        assert known.measures["x"].value.value == pytest.approx(np.sqrt(1000.0) * area, rel=1e-3)


@pytest.mark.parametrize("shape", ["half sine", "versed sine", "triangle"])
@pytest.mark.parametrize("duration", [1e-6, 1e-5, 1e-4])
@pytest.mark.parametrize("count", [2, 3])
def test_a_base_that_is_displaced_for_no_time_kicks_what_stands_on_it(count: int, duration: float, shape: str) -> None:
    """What is left behind by Gauss's rule over the pulse, then by modes of matrices by hand."""
    rng = np.random.default_rng(count)
    masses, springs = 10.0 ** rng.uniform(0.0, 1.5, count), 10.0 ** rng.uniform(4.0, 6.0, count)
    dampers = 0.1 * np.sqrt(masses * springs)
    rows = np.eye(count) - np.eye(count, k=-1)
    stiff, damped = (rows.T @ np.diag(one) @ rows / masses[:, None] for one in (springs, dampers))
    pull, drag = (np.eye(count)[0] * one[0] / masses[0] for one in (springs, dampers))
    own = np.block([[np.zeros((count, count)), np.eye(count)], [-stiff, -damped]])
    rates, shapes = np.linalg.eig(own)
    pushed = np.linalg.solve(shapes, np.concatenate([drag, pull - damped @ drag]))
    half = {"triangle": lambda s: np.minimum(2.0 * s, 2.0 - 2.0 * s), "half sine": lambda s: np.sin(np.pi * s),
            "versed sine": lambda s: np.sin(np.pi * s) ** 2}[shape]  # fmt: skip
    nodes, weights = np.polynomial.legendre.leggauss(40)
    places = np.concatenate([0.25 + 0.25 * nodes, 0.75 + 0.25 * nodes])
    late = np.exp(rates[:, None] * (duration * (1.0 - places)))
    left = pushed * (late @ (0.25 * np.tile(weights, 2) * half(places))) * duration * 1e-3
    times = np.linspace(0.0, 8.0 * np.pi / np.abs(rates).min(), 400_000)
    moved = np.real((shapes * left) @ np.exp(rates[:, None] * times))
    document: dict[str, Any] = {
        "bodies": {f"b{i}": {"mass": f"{one!r} kg"} for i, one in enumerate(masses.tolist())},
        "bases": {"floor": {}},
        "links": {
            f"l{i}": {"between": [f"b{i - 1}" if i else "floor", f"b{i}"],
                      "stiffness": f"{float(springs[i])!r} N/m", "damping": f"{float(dampers[i])!r} N s/m"}
            for i in range(count)
        },
        "excitations": {"jolt": {"kind": "pulse", "on": "floor", "shape": shape, "displacement": "1 mm",
                                 "duration": f"{duration!r} s"}},
        "measures": {"top": {"response": "peak_displacement", "of": f"b{count - 1}"},
                     "force": {"response": "peak_force", "through": f"l{count - 1}"}},
    }  # fmt: skip
    if count == 2:  # else the lowest body, which the pulse moves to and fro, ends at that link
        del document["measures"]["force"]
    pulled = springs[-1] * rows[-1] @ moved[:count] + dampers[-1] * rows[-1] @ moved[count:]
    wanted = {"top": np.abs(moved[count - 1]).max(), "force": np.abs(pulled).max()}
    for name, value in told(document).items():
        assert value == pytest.approx(wanted[name], rel=2e-6)
