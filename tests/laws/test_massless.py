"""Structures with coordinates without mass: condensed exactly, against direct solution and the limit of tiny masses."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sparse
from hypothesis import given, settings
from hypothesis import strategies as st

import vibopt as vo
from vibopt.mechanics.host import CondensationError, Matrices, condensed

few = settings(derandomize=True, database=None, deadline=None, max_examples=20)


def _structure(seed: int, count: int, beta: float, alpha: float) -> tuple[Any, Any, Any, list[int]]:
    """A random net of springs over ground, a third of its coordinates without mass; damping alpha M + beta K."""
    rng = np.random.default_rng(seed)
    stiffness = np.diag(10.0 ** rng.uniform(3, 5, count))
    for _ in range(2 * count):
        i, j = rng.choice(count, 2, replace=False)
        row = np.zeros(count)
        row[[i, j]] = 1.0, -1.0
        stiffness += 10.0 ** rng.uniform(3, 6) * np.outer(row, row)
    masses = 10.0 ** rng.uniform(-1, 2, count)
    out = sorted(rng.choice(count, max(count // 3, 1), replace=False).tolist())
    masses[out] = 0.0
    mass = np.diag(masses)
    return mass, alpha * mass + beta * stiffness, stiffness, out


@given(
    seed=st.integers(0, 10_000),
    count=st.integers(3, 12),
    beta=st.sampled_from([0.0, 1e-4]),
    alpha=st.sampled_from([0.0, 2.0]),
    loss=st.sampled_from([0.0, 0.03]),
)
@few
def test_what_is_left_answers_as_the_whole_and_as_the_limit_of_tiny_masses(
    seed: int, count: int, beta: float, alpha: float, loss: float
) -> None:
    mass, damping, stiffness, out = _structure(seed, count, beta, alpha)
    kept = [i for i in range(count) if i not in out]
    made = condensed(Matrices(*(sparse.csc_array(one) for one in (mass, damping, stiffness)), loss))
    assert made.size == len(kept)
    tiny = mass + np.diag([1e-12 if i in out else 0.0 for i in range(count)])
    for omega in (3.0, 40.0, 170.0):
        small = np.linalg.inv(made.dynamic(omega**2, omega).toarray())
        for whole in (mass, tiny):
            dynamic = stiffness * (1 + 1j * loss) - omega**2 * whole + 1j * omega * damping
            exact = np.linalg.inv(dynamic)[np.ix_(kept, kept)]
            assert np.abs(small - exact).max() <= 1e-7 * np.abs(exact).max()


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ("loose", "has coordinates without mass that no stiffness holds, 1 (counted from 0) the first of those without "
         "mass. Leave them out, or join them by springs."),
        ("dashpot", "has dampers at coordinates without mass, 1 (counted from 0) the first of those without mass, that "
         "are not in proportion to their stiffness, so they cannot be left out exactly. Give them a small mass, or "
         "damping in proportion."),
        ("weightless", "has no mass at any coordinate. Give the mass matrix entries."),
    ],
)  # fmt: skip
def test_what_cannot_be_left_out_exactly_is_refused(change: str, text: str) -> None:
    mass, damping = np.diag([1.0, 0.0, 2.0]), np.zeros((3, 3))
    stiffness = np.array([[3.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 4.0]]) * 1e3
    if change == "loose":
        stiffness[1, :] = stiffness[:, 1] = 0.0
    if change == "dashpot":
        damping[1, 1] = 5.0
    if change == "weightless":
        mass = np.zeros((3, 3))
    with pytest.raises(CondensationError) as caught:
        condensed(Matrices(*(sparse.csc_array(one) for one in (mass, damping, stiffness))))
    assert str(caught.value) == text


SCENE = """
[structures.frame]
mass = "mass.npz"
stiffness = "stiffness.npz"
loss_factor = 0.02
points = {{ seat = {seat} }}
[bodies.pump]
mass = "5 kg"
[links.mount]
between = ["pump", "seat"]
stiffness = "20 kN/m"
damping = "60 N s/m"
[excitations.shaft]
kind = "force"
on = "pump"
amplitude = "10 N"
speed = "2..30 Hz"
varies = "constant"
[measures.shake]
response = "displacement"
of = "seat"
"""


def _file(folder: Path, seat: int) -> tuple[Path, Any, Any, list[int]]:
    mass, _, stiffness, out = _structure(7, 9, 0.0, 0.0)
    sparse.save_npz(folder / "mass.npz", sparse.coo_array(mass))
    sparse.save_npz(folder / "stiffness.npz", sparse.coo_array(stiffness))
    (folder / "frame.toml").write_text(SCENE.format(seat=seat))
    return folder / "frame.toml", mass, stiffness, out


def test_a_machine_on_such_a_structure_moves_as_the_matrices_in_full_say_and_the_answer_tells(tmp_path: Path) -> None:
    _, mass, stiffness, out = _file(tmp_path, 0)
    seat = next(i for i in range(9) if i not in out)
    file, *_ = _file(tmp_path, seat)
    answer = vo.solve(vo.read(file))
    assert f"frame: 9 degrees of freedom ({len(out)} of them without mass, condensed exactly), " in answer.model.why
    worst = 0.0
    for omega in 2.0 * np.pi * np.linspace(2.0, 30.0, 20_001):
        whole = np.zeros((10, 10), dtype=complex)
        whole[:9, :9] = stiffness * (1 + 0.02j) - omega**2 * mass
        row = np.zeros(10)
        row[[seat, 9]] = -1.0, 1.0
        whole += (20e3 + 60j * omega) * np.outer(row, row)
        whole[9, 9] -= omega**2 * 5.0
        load = np.zeros(10)
        load[9] = 10.0
        worst = max(worst, float(abs(np.linalg.solve(whole, load)[seat])))
    assert answer.measures["shake"].value.value == pytest.approx(worst, rel=1e-4)
    assert answer.measures["shake"].value.value >= worst * (1.0 - 1e-9)


def test_a_point_without_mass_is_refused(tmp_path: Path) -> None:
    _, _, _, out = _file(tmp_path, 0)
    file, *_ = _file(tmp_path, out[0])
    with pytest.raises(vo.InputError) as caught:
        vo.read(file)
    assert (
        f"structures.frame puts seat at coordinate {out[0]}, which has no mass: what would act there moves nothing but "
        "springs. Name a coordinate with a mass, or give this one a mass."
    ) in str(caught.value)
