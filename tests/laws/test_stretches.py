"""Loads of very many segments, each with a length of its own: all at once as one after the other."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vibopt.excitations.segments import line
from vibopt.mechanics import kernel_bounds, stretches
from vibopt.mechanics.model import DAMPING, STIFFNESS
from vibopt.mechanics.readout import Reading
from vibopt.mechanics.transient import Transient

few = settings(derandomize=True, database=None, deadline=None, max_examples=12)


def machines(rng: np.random.Generator, count: int) -> tuple[Any, Any, Any]:
    """Mass, damping and stiffness of several chains of bodies on a base, the last, in a row."""
    table = np.eye(count, count + 1) - np.eye(count, count + 1, k=-1)
    table[0, count] = -1.0
    mass = np.zeros((3, count + 1, count + 1))
    mass[:, range(count), range(count)] = 10.0 ** rng.uniform(-1, 1, (3, count))
    springs, dampers = 10.0 ** rng.uniform(-1, 1.5, (3, count)), 10.0 ** rng.uniform(-2, 1, (3, count))
    return mass, (table.T * dampers[:, None]) @ table, (table.T * springs[:, None]) @ table


@few
@given(seed=st.integers(0, 100_000), count=st.integers(1, 3))
def test_segments_of_any_length_are_followed_at_once_as_one_after_the_other(seed: int, count: int) -> None:
    """Peaks, what is read at times, slopes and rough looks; the first five are of one length."""
    rng = np.random.default_rng(seed)
    mass, damping, stiffness = machines(rng, count)
    lengths = np.concatenate([np.full(5, 0.2), 10.0 ** rng.uniform(-3.0, 0.5, 60)])
    values = rng.normal(size=len(lengths) + 1)
    load = tuple(line(*one) for one in zip(lengths.tolist(), values[:-1], values[1:], strict=True))
    push = np.zeros((count + 1, 1))
    push[rng.integers(count + 1)] = 1.0
    own, none = np.eye(count + 1)[rng.integers(count)], np.zeros(count + 1)
    reading = Reading(own - np.eye(count + 1)[count] * (push[count] != 0.0), none, none, int(rng.integers(2)))
    moved = stiffness * (1.0 + 1e-30j * np.arange(1, 4)[:, None, None])
    times = np.sort(rng.uniform(0.0, 1.3 * lengths.sum(), 50))
    found = []
    for many in (16, 10**9):
        with pytest.MonkeyPatch.context() as patched:
            patched.setattr(stretches, "_MANY", many)
            patched.setattr(stretches, "_AT_ONCE", 7)
            row = Transient(mass, damping, stiffness, count, push, load)
            assert len(row.stretches) == (1 if many == 16 else 61)
            peaks = row.peaks(reading)
            slopes = replace(row, stiffness=moved).at(reading, peaks.within, peaks.part)
            alone = replace(row, mass=mass[0], damping=damping[0], stiffness=stiffness[0])
            looks = row.glimpses(reading, np.ones(3)), row.times_above(reading, 0.5 * np.abs(peaks.value), peaks.time)
            read = alone.history(reading, times)
            found.append((peaks.value, peaks.time, slopes.real, 1e30 * slopes.imag, read, peaks.within))
            assert (looks[0] <= np.abs(peaks.value) * (1.0 + 1e-9)).all()
            assert (looks[1] <= peaks.time).all()
            assert found[-1][2] == pytest.approx(peaks.value, rel=1e-9)
    for at_once, in_turn in zip(*found, strict=True):
        assert at_once == pytest.approx(in_turn, rel=1e-9, abs=1e-9 * np.abs(in_turn).max())


@few
@given(seed=st.integers(0, 100_000), count=st.integers(1, 3))
def test_what_bounds_a_tangent_is_that_of_segments_one_after_the_other(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    lengths, values = 10.0 ** rng.uniform(-3.0, 0.5, 40), rng.normal(size=41)
    load = tuple(line(*one) for one in zip(lengths.tolist(), values[:-1], values[1:], strict=True))
    mount = np.eye(count + 1)[0] - np.eye(count + 1)[count]
    reading = Reading(mount, np.zeros(count + 1), np.zeros(count + 1))
    elements = [kernel_bounds.Element(kind, mount, 0.5) for kind in (STIFFNESS, DAMPING)]
    within, part = np.array([3, 25, 40]), np.array([0.1, 0.9, 0.7]) * np.array([lengths[3], lengths[25], 1.0])
    found = []
    for many in (16, 10**9):
        with pytest.MonkeyPatch.context() as patched:
            patched.setattr(stretches, "_MANY", many)
            row = Transient(*machines(np.random.default_rng(seed), count), count, np.eye(count + 1)[:, -1:], load)
            assert len(row.stretches) == (1 if many == 16 else 40)
            near = kernel_bounds.nearby(row, reading, elements, within, part)
            assert near is not None
            found.append([near.value, near.energies, near.now, near.kernels, near.rests(np.full((3, 1, 2), 1e-3))])
    for at_once, in_turn in zip(*found, strict=True):
        assert at_once == pytest.approx(in_turn, rel=1e-7)
