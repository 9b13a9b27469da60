"""Limiting performance: closed forms, a linear program of another make, and what no isolator of the zoo undercuts."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path as File
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog
from scipy.sparse import coo_array

import vibopt as vo
from vibopt.arrays import FloatArray
from vibopt.excitations.pulse import Pulse
from vibopt.excitations.segments import line
from vibopt.mechanics.limiting import CLOSE, Path, least_peak, least_room
from vibopt.mechanics.readout import Reading
from vibopt.mechanics.transient import Transient
from vibopt.report.curves import panels
from vibopt.report.limiting_views import limiting
from vibopt.report.sheet.judgement import proof_of

few = settings(derandomize=True, database=None, deadline=None, max_examples=12)
ONE = np.ones(1)
SHAPES = ("half sine", "versed sine", "sine", "rectangle", "triangle", "rising sawtooth", "falling sawtooth")
PUSHED = [one for one in SHAPES if one != "sine"]


def pulse(shape: str, duration: float = 1.0, **words: Any) -> Pulse:
    return Pulse(kind="pulse", on="a", shape=shape, amplitude="1 N", duration=f"{duration!r} s", **words)


def walked(one: Pulse, times: FloatArray) -> FloatArray:
    """Path under a signal from its formula, by the trapezoidal rule twice on a fine grid."""
    fine = np.linspace(0.0, one.joints[-1], 200_001)
    pushed = one.signal(fine)
    step = fine[1]
    speed = np.append(0.0, np.cumsum(0.5 * step * (pushed[1:] + pushed[:-1])))
    path = np.append(0.0, np.cumsum(0.5 * step * (speed[1:] + speed[:-1])))
    return np.asarray(np.interp(times, fine, path) + np.maximum(times - fine[-1], 0.0) * speed[-1])


@pytest.mark.parametrize("room", [0.01, 0.3, 5.0])
def test_a_step_of_velocity_and_a_rectangle_are_as_in_the_books(room: float) -> None:
    """V^2 / (2 d), and a^2 T^2 / (2 d + a T^2) where the base goes on (Sevin and Pilkey)."""
    struck = replace(line(1e-3, 0.0, 0.0), blows=np.array([2.0]))
    for path, least in (
        (Path(ONE, (struck,)), 2.0**2 / (2.0 * room)),
        (Path(3.0 * ONE, (line(0.5, 1.0, 1.0),)), 1.5**2 / (2.0 * room + 3.0 * 0.5**2)),
    ):
        found = least_peak(path, room)
        assert found is not None
        assert found.low <= least * (1.0 + 1e-12)
        assert least <= found.high
        assert found.high <= least * (1.0 + 1e-6)
        back = least_room(path, least)
        assert back is not None
        assert back.low <= room * (1.0 + 1e-12)
        assert back.high == pytest.approx(room, rel=1e-6)


@pytest.mark.parametrize("shape", PUSHED)
def test_a_push_that_one_touch_answers_is_the_tangent_from_rest(shape: str) -> None:
    """A constant u from the beginning reaches the room once, at the greatest 2 (Y - d) / t^2 of all times."""
    one, room = pulse(shape), 0.2
    times = np.linspace(1e-3, 12.0, 400_001)
    least = float((2.0 * (walked(one, times) - room) / times**2).max())
    found = least_peak(Path(ONE, one.segments()), room)
    assert found is not None
    assert (0.5 * least * times**2 - walked(one, times) <= room)[times < 2.0 * np.sqrt(room / least)].all()
    assert found.low == pytest.approx(least, rel=1e-7)
    assert found.high == pytest.approx(least, rel=1e-6)


def programs(one: Pulse, room: float, cells: int) -> tuple[float, float]:
    """Bounds on the least peak by straight programs on an even grid, with margins and without."""
    times, h = np.linspace(0.0, 4.0 * one.joints[-1], cells + 1), 4.0 * one.joints[-1] / cells
    y = walked(one, times)
    row, col, val = [], [], []
    for i in range(1, cells):  # second differences are means of u: a relaxation
        for sign, side in ((1.0, 2 * i), (-1.0, 2 * i + 1)):
            row += [side] * 4
            col += [i - 1, i, i + 1, cells + 1]
            val += [sign, -2.0 * sign, sign, -h * h]
    row += [0, 0, 1, 1]
    col += [1, cells + 1] * 2
    val += [1.0, -0.5 * h * h, -1.0, -0.5 * h * h]
    table = coo_array((val, (row, col)), shape=(2 * cells, cells + 2))
    bounds = [(0.0, 0.0), *((a - room, a + room) for a in y[1:]), (0.0, None)]
    cost = np.eye(cells + 2)[-1]
    outer = linprog(cost, table, np.zeros(2 * cells), bounds=bounds)
    u = np.tril(np.ones((cells, cells)))  # u by cell: X at the nodes, held with a margin, and with the base in the end
    placed = h * h * (np.cumsum(u, axis=0) - 0.5 * u)
    margin = h * h / 8.0
    held = np.column_stack([placed, np.full(cells, margin)])
    under = np.column_stack([-placed, np.full(cells, margin)])
    peak = np.column_stack([np.vstack([np.eye(cells), -np.eye(cells)]), -np.ones(2 * cells)])
    left = room - margin  # the load is no more than one
    speed = (walked(one, times[-1:] + 1.0) - y[-1:])[0]
    inner = linprog(
        np.append(np.zeros(cells), 1.0),
        np.vstack([held, under, peak]),
        np.concatenate([y[1:] + left, left - y[1:], np.zeros(2 * cells)]),
        A_eq=np.append(np.full(cells, h), 0.0)[None, :],
        b_eq=[speed],
        bounds=[(None, None)] * cells + [(0.0, None)],
    )
    return float(outer.fun), float(inner.fun)


@pytest.mark.parametrize(("shape", "room"), [("sine", 0.03), ("half sine", 0.012), ("triangle", 0.02), ("sine", 0.1)])
def test_programs_of_another_make_agree(shape: str, room: float) -> None:
    """Relaxed and restricted programs on an even grid, by another solver, enclose the answer."""
    one = pulse(shape)
    outer, inner = programs(one, room, 160)
    found = least_peak(Path(ONE, one.segments()), room)
    assert found is not None
    assert found.low <= found.high <= found.low * (1.0 + CLOSE)
    assert outer * (1.0 - 1e-7) <= found.high
    assert found.low <= inner * (1.0 + 1e-7)
    assert inner == pytest.approx(outer, rel=0.06)


@few
@given(shape=st.sampled_from(SHAPES), turns=st.floats(0.05, 3.0), damping=st.floats(0.0, 2.0), times=st.integers(1, 3))
@example(shape="rising sawtooth", turns=2.579930803104673, damping=0.2240296471590822, times=2)  # eleven programs
def test_no_spring_and_damper_does_better(shape: str, turns: float, damping: float, times: int) -> None:
    """Any mount in the room that it takes passes on no less than the proven end, and the ends are close."""
    words = {"times": times, "every": "1.3 s"} if times > 1 else {}
    one = pulse(shape, **words)
    w = 2.0 * np.pi * turns
    table = np.array([[1.0, -1.0], [-1.0, 1.0]])
    machine = Transient(
        np.diag([1.0, 0.0]), 2.0 * damping * w * table, w * w * table, 1, np.array([[0.0], [1.0]]), one.segments()
    )
    none = np.zeros(2)
    room = abs(machine.peak(Reading(np.array([1.0, -1.0]), none, none)).value)
    peak = abs(machine.peak(Reading(np.array([1.0, 0.0]), none, none, 2)).value)
    found = least_peak(Path(ONE, one.segments()), room)
    assert found is not None
    assert found.low <= peak
    assert found.low <= found.high <= found.low * (1.0 + CLOSE) + 1e-6
    back = least_room(Path(ONE, one.segments()), peak)
    assert back is not None
    assert back.low <= room


@few
@given(seed=st.integers(0, 10_000), length=st.floats(0.01, 100.0), size=st.floats(0.01, 100.0))
def test_units_of_length_and_time_do_not_matter(seed: int, length: float, size: float) -> None:
    rng = np.random.default_rng(seed)
    points = rng.normal(size=12)
    room = 10.0 ** rng.uniform(-2.5, -0.5)
    plain = least_peak(Path(ONE, tuple(line(0.1, a, b) for a, b in pairwise(points))), room)
    segments = tuple(line(0.1 * length, size * a, size * b) for a, b in pairwise(points))
    scaled = least_peak(Path(ONE, segments), room * size * length**2)
    assert plain is not None
    assert scaled is not None
    assert scaled.low <= plain.high * size * (1.0 + 1e-9) + 1e-9
    assert plain.low * size <= scaled.high * (1.0 + 1e-9) + 1e-9


FELL = File("problems/shock/dropped_instrument.toml")
MEASURED: dict[str, Any] = {
    "title": "x",
    "bases": {"box": {}},
    "bodies": {"a": {"mass": "10 kg"}},
    "links": {"foam": {"between": ["a", "box"], "count": 2, "stiffness": "6.63 kN/m", "damping": "147.1 N s/m"}},
    "excitations": {"fall": {"kind": "drop", "on": "box", "height": "0.3 m"}},
    "limits": {"rattle": {"response": "peak_relative_displacement", "across": "foam", "at_most": "50 mm"}},
    "measures": {"shock": {"response": "peak_acceleration", "of": "a"}},
}


def answered(**changes: Any) -> vo.Answer[Any]:
    return vo.solve(vo.from_dict({**MEASURED, **changes}))


def test_the_answer_says_how_near_it_is_to_any_isolator() -> None:
    """In 50 mm: v^2 / (2 d) = 58.84 m/s^2; as a force of 10 kg, by mount, and as room for a peak."""
    found = answered()
    said = (
        "peak acceleration of a: 1.3 times the least that any isolator, passive or active, could reach in 50 mm "
        "(58.83 to 58.84 m/s², proven)"
    )
    assert [one.words for one in limiting(found)] == [said]
    assert said in " ".join(found.report().split())
    assert f"P{said[1:]}." in proof_of(found)
    [row] = found.to_json()["limiting_performance"]
    assert row["words"] == said
    assert [end["value"] for end in row["least"]] == pytest.approx([58.8399, 58.8399], rel=1e-6)
    [panel] = [one for one in panels(found) if "against rattle space" in one.title]
    assert panel.curves[0].y == pytest.approx(1e3 * 0.3 * 9.80665 / panel.curves[0].x, rel=0.01)
    assert (panel.marks[0].x, panel.marks[0].y) == pytest.approx((40.0, 76.58), rel=1e-3)
    [force] = limiting(answered(measures={"shock": {"response": "peak_force", "through": "foam"}}))
    assert force.least.low == pytest.approx(294.2, rel=1e-5)
    room = {"rattle": {"response": "peak_relative_displacement", "across": "foam"}}
    bounded = {"shock": {"response": "peak_acceleration", "of": "a", "at_most": "10 g"}}
    [space] = limiting(answered(measures=room, limits=bounded))
    assert space.judged.where == "measures.rattle"
    assert space.least.low == pytest.approx(30e-3, rel=1e-6)
    assert "could reach with 10 g (29.99 to 30.01 mm, proven)" in space.words


def test_a_force_on_the_mass_counts_as_the_path_of_a_base() -> None:
    """The force into the ground under a force of the mass, in the sway of the body; the bound is that of the base."""
    blast = {"kind": "pulse", "on": "a", "shape": "rectangle", "amplitude": "30 N", "duration": "0.5 s"}
    [found] = limiting(
        answered(
            bases={},
            links={"foam": {"between": ["a", "ground"], "stiffness": "100 N/m", "damping": "30 N s/m"}},
            excitations={"blast": blast},
            limits={"sway": {"response": "peak_displacement", "of": "a", "at_most": "0.5 m"}},
            measures={"force": {"response": "peak_force", "into": "ground"}},
        )
    )
    assert found.least.low == pytest.approx(10.0 * 1.5**2 / (2.0 * 0.5 + 3.0 * 0.5**2), rel=1e-6)


ANY = {"kind": "pulse", "on": "box", "shape": "half sine", "acceleration": "1 g", "duration_up_to": "20 ms"}


@pytest.mark.parametrize(
    "changes",
    [
        {"measures": {"shock": {"response": "peak_velocity", "of": "a"}}},
        {
            "bodies": {"a": {"mass": "10 kg"}, "b": {"mass": "1 kg"}},
            "links": {**MEASURED["links"], "top": {"between": ["a", "b"], "stiffness": "1 kN/m"}},
            "measures": {"shock": {"response": "peak_force", "into": "box"}},
        },
        {
            "bodies": {"a": {"mass": "10 kg", "tolerance": "5 %"}},
            "measures": {"shock": {"response": "peak_force", "into": "box"}},
        },
    ],
    ids=["no peak", "two masses", "a mass that may be off"],
)
def test_it_says_nothing_where_no_history_of_a_force_is_the_least(changes: dict[str, Any]) -> None:
    found = answered(**changes)
    assert limiting(found) == []
    assert "any isolator" not in found.report()
    assert "limiting_performance" not in found.to_json()


def test_it_says_nothing_of_a_pulse_that_may_have_any_duration() -> None:
    found = answered()
    asked = vo.from_dict({**MEASURED, "excitations": {"fall": ANY}})
    assert limiting(replace(found, job=asked)) == []
