"""Peaks under short loads: by modes as by exponentials of matrices, on which the two roads share nothing."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.linalg import expm_frechet

import vibopt as vo
from vibopt.arrays import FloatArray
from vibopt.excitations.segments import line, sine
from vibopt.mechanics import pulsed
from vibopt.mechanics.panels import exponentials
from vibopt.mechanics.peaks_in_time import Peak
from vibopt.mechanics.pulsed import peaks_by_modes
from vibopt.mechanics.readout import Reading
from vibopt.mechanics.transient import Transient
from vibopt.signals import Segment

NOTHING = np.zeros(1)


def chain(rng: np.random.Generator, count: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Mass, damping and stiffness of bodies on a base, the last; damping from none to far too much, even or uneven."""
    mass = np.diag([*10.0 ** rng.uniform(-1, 1, count), 0.0])
    table = np.eye(count, count + 1) - np.eye(count, count + 1, k=-1)
    table[0, count] = -1.0
    springs = 10.0 ** rng.uniform(-1, 1, count)
    dampers = rng.choice([0.0, 0.02, 0.6, 6.0]) * (springs if rng.random() < 0.5 else 10.0 ** rng.uniform(-1, 1, count))
    return mass, (table.T * dampers) @ table, (table.T * springs) @ table


def load(rng: np.random.Generator) -> tuple[Segment, ...]:
    """One to three segments of any kind, some begun by a blow; the second of two signals pushes.  Some stay at last."""
    found = []
    for _ in range(rng.integers(1, 4)):
        length = 10.0 ** rng.uniform(-1.0, 1.5)
        kinds = (
            line(length, *rng.normal(size=2)),
            sine(length, rng.normal(), rng.normal(), rng.uniform(0.5, 20.0)),
            sine(length, 1.0, 0.0, 9.0, 2.0),
            sine(length, 0.5, -0.5 * np.pi, 2.0 * np.pi, 0.0, 0.5),
        )
        one = kinds[rng.integers(4)]
        read, blows = np.zeros((2, one.read.shape[1])), np.zeros(2)
        read[rng.integers(2)] = one.read[0]
        blows[0] = length * rng.normal() if rng.random() < 0.2 else 0.0
        found.append(replace(one, read=read, blows=blows))
    if rng.random() < 0.3:
        stays = line(1.0, *rng.normal(size=1).repeat(2))
        found.append(replace(stays, read=rng.permutation(2)[:, None] * stays.read, blows=np.zeros(2), endless=True))
    return tuple(found[-3:])


def by_modes(machine: Transient, reading: Reading) -> Peak | None:
    """That of a lone machine; None where it has none."""
    found = peaks_by_modes(machine.row_of_one, reading)
    return None if found is None or not found[1].all() else found[0].each()[0]


@settings(max_examples=60)
@given(seed=st.integers(0, 100_000), count=st.integers(1, 5))
def test_a_peak_by_modes_is_the_one_by_exponentials(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    mass, damping, stiffness = chain(rng, count)
    loads = np.zeros((count + 1, 2))
    loads[count, 0], loads[rng.integers(count), 1] = 1.0, rng.normal()
    machine = Transient(mass, damping, stiffness, count, loads, load(rng))
    own, none = np.eye(count + 1)[rng.integers(count)], np.zeros(count + 1)
    readings = (
        Reading(own - np.eye(count + 1)[count], none, none, int(rng.integers(2))),
        Reading(own, none, none, 2),
        Reading(stiffness[count], damping[count], none),
    )
    reading = readings[rng.integers(3)]
    found = by_modes(machine, reading)
    if found is None:
        return
    (other,) = machine.row_of_one._peaks_of_row(reading).each()
    assert abs(found.value) == pytest.approx(abs(other.value), rel=1e-10)
    assert machine.at(reading, found.within, found.part) == pytest.approx(found.value, rel=1e-9)


@settings(max_examples=15)
@given(seed=st.integers(0, 100_000), count=st.integers(1, 3))
def test_machines_in_a_row_have_the_peaks_of_each(seed: int, count: int) -> None:
    """Some by modes and some not: an undamped one, a braked one, one that is far too stiff for so long a load."""
    rng = np.random.default_rng(seed)
    mass, damping, stiffness = chain(rng, count)
    loads = np.eye(count + 1)[:, -1:] * np.array([1.0, 0.0])
    row = Transient(
        np.tile(mass, (4, 1, 1)), damping * np.array([1.0, 0.0, 9.0, 1.0])[:, None, None],
        stiffness * np.array([1.0, 2.0, 0.5, 1e6])[:, None, None], count, loads, load(rng),
    )  # fmt: skip
    apart = np.eye(count + 1)[0] - np.eye(count + 1)[count]
    reading = Reading(apart, 0.0 * apart, 0.0 * apart)
    each = [row.some(np.array([i]))._peaks_of_row(reading).value[0] for i in range(4)]
    assert np.abs(row.peaks(reading).value) == pytest.approx(np.abs(each), rel=1e-10)


@pytest.mark.parametrize("cells", [1 << 11, 1 << 13])
def test_a_row_that_is_too_long_for_one_grid_is_cut(monkeypatch: pytest.MonkeyPatch, cells: int) -> None:
    """Six bodies that ring long after a pulse, forty times: one by one, in parts, and none where one is too much."""
    mass, _, stiffness = chain(np.random.default_rng(3), 6)
    spread = 1.0 + 0.01 * np.arange(40)[:, None, None]
    row = Transient(np.tile(mass, (40, 1, 1)), 1e-3 * stiffness * spread, stiffness * spread, 6, np.eye(7)[:, -1:],
                    (line(1.0, 1.0, 0.0),))  # fmt: skip
    apart = np.eye(7)[0] - np.eye(7)[6]
    reading = Reading(apart, 0.0 * apart, 0.0 * apart)
    found = []
    for most in (pulsed._CELLS, cells, 10):
        monkeypatch.setattr(pulsed, "_CELLS", most)
        known = peaks_by_modes(row, reading)
        assert known is not None
        found.append(known)
    (whole, all_known), (parts, known_by_parts), (_, known_of_none) = found
    assert (all_known.all(), known_by_parts.all(), known_of_none.any()) == (True, True, False)
    assert parts.value == pytest.approx(whole.value, rel=1e-12)
    assert parts.time == pytest.approx(whole.time, rel=1e-6)


@settings(max_examples=12, deadline=None)
@given(seed=st.integers(0, 100_000), count=st.integers(2, 7), span=st.floats(4.0, 8.5))
def test_stiff_structures_keep_the_digits_of_what_is_slow(seed: int, count: int, span: float) -> None:
    """Modes up to 1e4 times as fast as the first, with a device on them, under a rectangle: against 40 digits."""
    rng = np.random.default_rng(seed)
    squares, row = np.geomspace(1.0, 10.0**span, count), np.append(rng.normal(size=count), 0.0)
    apart, own = row - np.eye(count + 1)[count], np.diag(np.append(squares, 0.0))
    mass = np.diag(np.append(np.ones(count), 0.05))
    stiffness = own + 0.05 * rng.uniform(0.5, 2.0) * np.outer(apart, apart)
    damping = rng.choice([1e-3, 1e-2]) * 10.0 ** (-0.5 * span) * own + rng.choice([0.0, 0.02]) * np.outer(apart, apart)
    length = rng.uniform(0.5, 8.0)
    machine = Transient(mass, damping, stiffness, count + 1, row[:, None], (line(length, 1.0, 1.0),))
    found = by_modes(machine, Reading(row, 0.0 * row, 0.0 * row))
    assume(found is not None)
    assert found is not None
    n = count + 1
    with mpmath.workdps(40):
        inverse = mpmath.diag([1 / mpmath.mpf(one) for one in np.diag(mass).tolist()])
        states = mpmath.zeros(2 * n)
        states[:n, n:] = mpmath.eye(n)
        states[n:, :n], states[n:, n:] = -inverse * mpmath.matrix(stiffness), -inverse * mpmath.matrix(damping)
        poles, vectors = mpmath.eig(states)
        shares = mpmath.lu_solve(vectors, mpmath.matrix([0.0] * n + (inverse * mpmath.matrix(row)).T.tolist()[0]))
        read = mpmath.matrix(row).T * vectors[:n, :]
        waves = np.array([complex(read[j] * shares[j] / poles[j]) for j in range(2 * n)])
        rates = np.array([complex(pole) for pole in poles])

    def moved(times: FloatArray) -> FloatArray:
        after = np.where(times > length, np.expm1(np.maximum(times - length, 0.0)[:, None] * rates).T, 0.0)
        return ((np.expm1(times[:, None] * rates).T - after).T @ waves).real  # type: ignore[no-any-return]

    sampled = np.abs(moved(np.linspace(0.0, length + 15.0, 20_000))).max()
    assert abs(found.value) == pytest.approx(abs(moved(np.array([found.time]))[0]), rel=1e-9)
    assert sampled * (1.0 - 1e-9) <= abs(found.value)  # which is no less at any time


def test_a_chain_of_a_hundred_goes_by_modes() -> None:
    """Its last mode swings 127 times as fast as its first."""
    turned = (2.0 * np.arange(1, 101) - 1.0) * np.pi / 402.0
    shape = np.sin(200.0 * turned) * np.sqrt(4.0 / 201.0)
    own = np.diag(4.0 * np.sin(turned) ** 2)
    machine = Transient(np.eye(100), 0.03 * own, own, 100, shape[:, None], (line(200.0, 1.0, 1.0),))
    reading = Reading(shape, 0.0 * shape, 0.0 * shape)
    found = by_modes(machine, reading)
    assert found is not None
    assert abs(found.value) == pytest.approx(abs(machine.row_of_one._peaks_of_row(reading).each()[0].value), rel=1e-9)


def test_most_machines_under_pulses_go_by_modes() -> None:
    rng, taken = np.random.default_rng(14), 0
    for _ in range(40):
        count = int(rng.integers(1, 5))
        loads = np.eye(count + 1)[:, -1:] * np.array([1.0, 0.0])
        machine = Transient(*chain(rng, count), count, loads, load(rng))
        apart = np.eye(count + 1)[0] - np.eye(count + 1)[count]
        taken += by_modes(machine, Reading(apart, 0.0 * apart, 0.0 * apart)) is not None
    assert taken >= 20


@pytest.mark.parametrize("turns", [3.0, 7.5, 40.0])
@pytest.mark.parametrize("length", [1.0, 0.37])
def test_of_equal_peaks_the_earliest_is_named(turns: float, length: float) -> None:
    """A rectangle on an undamped mass: twice the static distance half a period behind its beginning, and then again."""
    w = 2.0 * np.pi * turns / length
    machine = Transient(np.eye(1), np.zeros((1, 1)), w * w * np.eye(1), 1, np.eye(1), (line(length, 1.0, 1.0),))
    found = machine.peak(Reading(np.ones(1), NOTHING, NOTHING))
    assert found.value == pytest.approx(2.0 / w**2, rel=1e-12)
    assert found.time == pytest.approx(np.pi / w, rel=1e-6)


@pytest.mark.parametrize(
    ("mass", "stiffness", "segment"),
    [
        ([1.0, 0.0], [[2.0, -1.0], [-1.0, 2.0]], line(1.0, 1.0, 1.0)),
        ([1.0, 1.0], [[1.0, -1.0], [-1.0, 1.0]], line(1.0, 1.0, 1.0)),
        ([1.0, 1.0], [[1e7 + 1.0, -1e7], [-1e7, 1e7 + 1.0]], line(1.0, 1.0, 1.0)),
        ([1.0, 1.0], [[2.0, -1.0], [-1.0, 2.0]], replace(sine(1.0, 1.0, 0.0, np.pi), endless=True)),
        ([1.0, 1.0], [[2.0, -1.0], [-1.0, 2.0]], line(1e-6, 1.0, 0.0)),
        ([1.0, 1.0], [[2.0, -1.0], [-1.0, 2.0]], sine(1.0, 1.0, 0.0, 1.0)),
    ],
    ids=["massless", "loose", "stiff", "endless", "a blow", "resonant"],
)
def test_what_modes_cannot_say_is_left_to_exponentials(
    mass: list[float], stiffness: list[list[float]], segment: Segment
) -> None:
    machine = Transient(np.diag(mass), np.zeros((2, 2)), np.array(stiffness), 2, np.eye(2)[:, :1], (segment,))
    assert by_modes(machine, Reading(np.array([1.0, 0.0]), np.zeros(2), np.zeros(2))) is None


def test_what_nothing_damps_is_told_with_the_sum_of_its_amplitudes() -> None:
    """Of six bodies, by Duhamel's integral on each mode; of one the peak is the sum, and nothing is said."""
    mass, springs, lasts = 1.0 + 0.37 * np.arange(6), 1000.0 - 77.0 * np.arange(6), 0.05
    document: dict[str, Any] = {
        "title": "chain",
        "bodies": {f"b{i}": {"mass": f"{mass[i]:g} kg"} for i in range(6)},
        "links": {
            f"l{i}": {"between": [f"b{i}", f"b{i - 1}" if i else "ground"], "stiffness": f"{springs[i]:g} N/m"}
            for i in range(6)
        },
        "excitations": {
            "p": {"kind": "pulse", "on": "b0", "shape": "half sine", "amplitude": "10 N", "duration": f"{lasts} s"}
        },
        "measures": {"sway": {"response": "peak_displacement", "of": "b0"}},
    }
    table = np.eye(6) - np.eye(6, k=-1)
    root = np.diag(mass**-0.5)
    squares, turned = np.linalg.eigh(root @ (table.T * springs) @ table @ root)
    w, first = np.sqrt(squares), (root @ turned)[0]
    blows = 10.0 * (np.pi / lasts) * 2.0 * np.cos(0.5 * w * lasts) / ((np.pi / lasts) ** 2 - squares)
    most = float((first**2 * np.abs(blows) / w).sum())
    found = vo.solve(vo.from_dict(document))
    ratio = most / found.measures["sway"].value.value
    said = f"measures.sway may come to {ratio:.4g} times that far later, the sum of its amplitudes, and never beyond."
    assert ratio > 1.001
    assert said in found.notes
    for one in ("bodies", "links"):
        document[one] = dict([*document[one].items()][:1])
    assert not any("far later" in note for note in vo.solve(vo.from_dict(document)).notes)


@pytest.mark.parametrize("seed", range(6))
def test_what_rings_on_is_followed_as_far_as_by_exponentials(seed: int) -> None:
    """Three bodies without damping, or next to none, over a thousand periods."""
    rng = np.random.default_rng(seed)
    table = np.eye(3) - np.eye(3, k=-1)
    stiffness = (table.T * 10.0 ** rng.uniform(0.0, 1.0, 3)) @ table
    push = (sine(rng.uniform(0.1, 3.0), 1.0, 0.0, np.pi),)
    machine = Transient(np.eye(3), 1e-6 * (seed % 2) * stiffness, stiffness, 3, np.eye(3)[:, :1], push)
    reading = Reading(np.eye(3)[0], np.zeros(3), np.zeros(3))
    found, (other,) = by_modes(machine, reading), machine.row_of_one._peaks_of_row(reading).each()
    assert found is not None
    assert (abs(found.value), found.open) == (pytest.approx(abs(other.value), rel=1e-9), other.open)
    assert found.time == pytest.approx(other.time, rel=1e-6)


@pytest.mark.parametrize("size", [0.3, 20.0])
@pytest.mark.parametrize("parts", [[1.0], [0.0, 0.3, 1.0]], ids=len)
def test_exponentials_and_their_slopes_are_those_of_an_approximant(parts: list[float], size: float) -> None:
    """Pade's, of matrices one by one: scipy takes no stack of slopes."""
    rng = np.random.default_rng(3)
    a, way = size * rng.normal(size=(2, 3, 5, 5)) / 5.0
    found = exponentials(a + 1e-30j * way, np.array(parts))
    alone = exponentials(a, np.array(parts))
    for k, part in np.ndindex(len(a), len(parts)):
        value, slope = expm_frechet(parts[part] * a[k], parts[part] * way[k])
        for one in (found[k, part].real, alone[k, part]):
            assert one == pytest.approx(value, rel=1e-12, abs=1e-13 * np.abs(value).max())
        assert found[k, part].imag * 1e30 == pytest.approx(slope, rel=1e-11, abs=1e-12 * np.abs(slope).max())
