"""Records beside pulses that bend, and long sines: the second route steps from bend to bend, against exponentials."""

from __future__ import annotations

import tracemalloc
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

import vibopt as vo
from vibopt.cones import LINEAR, by_columns, solve_cones
from vibopt.verify.motion_in_time import even_steps

MASSES, STIFFNESSES, DAMPINGS = (70.8, 9.52, 70.8), (180_688.0, 67_966.0, 5_111_698.0), (7154.0, 1609.0, 38_050.0)
SIZE, LENGTH = 1.85, 0.00545


def chain(folder: Path, times: np.ndarray, values: np.ndarray) -> dict[str, Any]:
    """Three bodies on a base that a record shakes and a versed sine strikes at once."""
    rows = [f"{time:.9g},{value:.6g}" for time, value in zip(times, values, strict=True)]
    (folder / "shaking.csv").write_text("\n".join(["time [s],acceleration [m/s²]", *rows]), encoding="utf-8")
    ends = ["base", "b0", "b1", "b2"]
    return {
        "title": "chain on a base",
        "bases": {"base": {}},
        "bodies": {f"b{i}": {"mass": f"{mass} kg"} for i, mass in enumerate(MASSES)},
        "links": {
            f"l{i}": {"between": [ends[i + 1], ends[i]], "stiffness": f"{k} N/m", "damping": f"{c} N s/m"}
            for i, (k, c) in enumerate(zip(STIFFNESSES, DAMPINGS, strict=True))
        },
        "excitations": {
            "shaking": {"kind": "record", "on": "base", "file": str(folder / "shaking.csv")},
            "blow": {"kind": "pulse", "on": "base", "shape": "versed sine", "acceleration": f"{SIZE} m/s²",
                     "duration": f"{LENGTH} s"},
        },
        "measures": {"force": {"response": "peak_force", "through": "l2"}},
    }  # fmt: skip


def by_exponentials(times: np.ndarray, values: np.ndarray) -> float:
    """Greatest force in the last link over the record, from exponentials of the chain and its load together."""
    times = times - times[0]
    count, across = len(MASSES), np.eye(3) - np.eye(3, k=-1)
    pulled = [across.T @ np.diag(one) @ across / np.array(MASSES)[:, None] for one in (STIFFNESSES, DAMPINGS)]
    whole = np.zeros((2 * count + 5, 2 * count + 5))  # against the base; then straight line and versed sine
    whole[:count, count : 2 * count] = np.eye(count)
    whole[count : 2 * count, : 2 * count] = -np.hstack(pulled)
    turns = 2.0 * np.pi / LENGTH
    line, wave = 2 * count, 2 * count + 2
    whole[line, line + 1], whole[wave + 1, wave + 2], whole[wave + 2, wave + 1] = 1.0, turns, -turns
    row = np.zeros(len(whole))
    row[[1, 2, count + 1, count + 2]] = [-STIFFNESSES[2], STIFFNESSES[2], -DAMPINGS[2], DAMPINGS[2]]
    state, most = np.zeros(len(whole)), 0.0
    for low, high in pairwise(sorted({*times.tolist(), LENGTH})):
        step = (high - low) / 4000
        state[line : line + 2] = (
            np.interp(low, times, values),
            np.diff(np.interp([low, high], times, values))[0] / (high - low),
        )
        struck = low < LENGTH
        state[wave : wave + 3] = [0.5 * SIZE, -0.5 * SIZE * np.cos(turns * low), 0.5 * SIZE * np.sin(turns * low)]
        state[wave : wave + 3] *= struck
        whole[count : 2 * count, line], whole[count : 2 * count, wave : wave + 2] = -1.0, -1.0
        onward = expm(whole * step)
        course = [state]
        for _ in range(4000):
            course.append(onward @ course[-1])
        read = np.array(course) @ row
        at = int(np.abs(read[1:-1]).argmax()) + 1
        near = [float(row @ expm(whole * part) @ course[at - 1]) for part in np.linspace(0.0, 2.0 * step, 401)]
        most, state = max(most, float(np.abs(read).max()), float(np.abs(near).max())), course[-1]
    return most


@pytest.mark.parametrize("rows", [((0.27, -0.789), (0.888, -0.487), (1.937, -0.328)),
                                  ((0.0, 0.0), (0.01, 3.0), (0.013, -1.0), (0.06, 0.5))])  # fmt: skip
def test_a_record_beside_a_pulse_that_bends_is_exact(tmp_path: Path, rows: Any, monkeypatch: Any) -> None:
    """To nine digits, and from bend to bend: no integrator feels its way along it."""
    monkeypatch.setattr("scipy.integrate.solve_ivp", None)
    times, values = np.array(rows).T
    answer = vo.solve(vo.from_dict(chain(tmp_path, times, values)))
    assert answer.status == "met", answer.claim
    assert answer.measures["force"].value.value == pytest.approx(by_exponentials(times, values), rel=1e-9)


@given(count=st.integers(1, 70), size=st.integers(1, 4), seed=st.integers(0, 999))
@settings(derandomize=True, database=None, deadline=None)
def test_rows_of_even_steps_side_by_side_are_one_step_after_the_other(count: int, size: int, seed: int) -> None:
    drawn = np.random.default_rng(seed)
    free, start = 0.6 * drawn.normal(size=(size, size)), drawn.normal(size=size)
    added = drawn.normal(size=(count, size))
    found = even_steps(free, start, added)
    for state, push in zip(found, added, strict=True):
        assert state == pytest.approx(start, rel=1e-9, abs=1e-9 * np.abs(found).max())
        start = free @ start + push


def test_a_program_without_squares_takes_no_room_for_them() -> None:
    """Two thousand numbers, each at least one: a matrix of all with all would be 32 MB."""
    count = 2000
    table = by_columns(-np.ones(count), np.arange(count), np.arange(count + 1), (count, count))
    tracemalloc.start()
    found = solve_cones(np.ones(count), table, -np.ones(count), [(LINEAR, count)])
    room = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert found.x == pytest.approx(np.ones(count), rel=1e-8)
    assert room < 16e6


def test_loads_that_act_together_are_joined_once_for_all_that_is_asked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Cut at each other's joints anew for every measure they were most of an answer."""
    from vibopt.excitations import segments

    asked, joined = [], segments.together
    monkeypatch.setattr(segments, "together", lambda signals: asked.append(len(signals)) or joined(signals))
    document = chain(tmp_path, np.linspace(0.0, 0.02, 20), np.ones(20))
    document["measures"] |= {f"felt{i}": {"response": "peak_acceleration", "of": f"b{i}"} for i in range(3)}
    scene = vo.from_dict(document)
    asked.clear()  # what was tried of the file
    assert vo.solve(scene).status == "met"
    assert asked in ([], [2])
