"""What nothing holds: rigid motions of frames and beams by their matrices, against statics of rigid bodies."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sparse
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.linalg import block_diag

import vibopt as vo
from vibopt.mechanics.host import Matrices, digits_lost, free_motions, reduced_host, whole_host
from vibopt.scene.read import from_dict

Array = NDArray[np.float64]
FEW = settings(max_examples=30, deadline=None)


def member(begin: Array, end: Array, axial: float, bending: float, mass: float) -> tuple[Array, Array]:
    """M, K (6, 6) of a beam with a density `mass` between two nodes, over x, y and turn of each."""
    length = float(np.hypot(*(end - begin)))
    a, b = length, length**2
    bent = np.array([[12, 6 * a, -12, 6 * a], [6 * a, 4 * b, -6 * a, 2 * b],
                     [-12, -6 * a, 12, -6 * a], [6 * a, 2 * b, -6 * a, 4 * b]])  # fmt: skip
    heavy = np.array([[156, 22 * a, 54, -13 * a], [22 * a, 4 * b, 13 * a, -3 * b],
                      [54, 13 * a, 156, -22 * a], [-13 * a, -3 * b, -22 * a, 4 * b]])  # fmt: skip
    M, K = np.zeros((2, 6, 6))
    along, across = np.ix_([0, 3], [0, 3]), np.ix_([1, 2, 4, 5], [1, 2, 4, 5])
    M[along], M[across] = mass * a / 6.0 * np.array([[2, 1], [1, 2]]), mass * a / 420.0 * heavy
    K[along], K[across] = axial / a * np.array([[1, -1], [-1, 1]]), bending / a**3 * bent
    c, s = (end - begin) / length
    turn = block_diag(*[np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])] * 2)
    return turn.T @ M @ turn, turn.T @ K @ turn


def frame(seed: int, nodes: int) -> tuple[Array, Array, Array]:
    """M, K (3 n, 3 n) of a plane frame that nothing holds, and its nodes (n, 2)."""
    draw = np.random.default_rng(seed)
    at = [np.zeros(2)]
    for _ in range(nodes - 1):
        angle = draw.uniform(0.0, 2.0 * np.pi)
        at.append(at[draw.integers(len(at))] + draw.uniform(0.3, 1.5) * np.array([np.cos(angle), np.sin(angle)]))
    axial, mass = 10.0 ** draw.uniform(7, 9), draw.uniform(5.0, 50.0)
    M, K = np.zeros((2, 3 * nodes, 3 * nodes))
    for i in range(1, nodes):
        j = int(draw.integers(i))
        here = np.ix_(*2 * [[3 * i, 3 * i + 1, 3 * i + 2, 3 * j, 3 * j + 1, 3 * j + 2]])
        m, k = member(at[i], at[j], axial, axial * 10.0 ** draw.uniform(-5, -2), mass)
        M[here] += m
        K[here] += k
    return M, K, np.array(at)


def as_one_body(M: Array, at: Array) -> Array:
    """How the frame moves as a rigid body, (3 n, 3): along x, along y, about the origin."""
    x, y = at.T
    one, none = np.ones(len(at)), np.zeros(len(at))
    columns = [np.stack(part, axis=1).ravel() for part in ((one, none, none), (none, one, none), (-y, x, one))]
    return np.stack(columns, axis=1)


def sparsed(M: Array, C: Array, K: Array) -> Matrices:
    mass, damping, stiffness = (sparse.csc_array(one) for one in (M, C, K))
    return Matrices(mass, damping, stiffness)


@FEW
@given(st.integers(0, 10**6), st.integers(2, 12), st.sampled_from([0.0, 1e-5]), st.sampled_from([0.0, 0.3]))
def test_a_frame_that_nothing_holds_has_three_free_motions(seed: int, nodes: int, with_k: float, with_m: float) -> None:
    M, K, at = frame(seed, nodes)
    of = sparsed(M, with_k * K + with_m * M, K)
    free, rigid = free_motions(of), as_one_body(M, at)
    assert (free.count, free.coasting) == (3, 0 if with_m else 3)
    assert free.hidden < 1e-12 * of.fastest**2
    found = free.motions @ free.motions.T
    own = rigid @ np.linalg.solve(rigid.T @ M @ rigid, rigid.T)
    assert found == pytest.approx(own, abs=1e-8 * np.abs(own).max())
    last = 3 * nodes - 2
    for host in (whole_host(of, {"a": 0, "b": last}), reduced_host(of, {"a": 0, "b": last}, 300.0)):
        at_rest = host.coordinates
        assert host.error < 1e-8
        assert not at_rest.stiffness[:3].any()
        assert (at_rest.stiffness[3:] > 0.0).all()
        slow, rows = 1e-3, at_rest.rows()
        pushed = 1.0 / (-(slow**2) + 1j * slow * with_m)
        still = at_rest.receptances(np.array([slow]))[0] - pushed * own[np.ix_([0, last], [0, last])]
        assert np.abs(still).max() < np.abs(rows[:, 3:] ** 2 @ (1.01 / at_rest.stiffness[3:])).max() + 1e-8 * abs(
            pushed
        )
        if not with_m:
            assert not at_rest.damping[:3].any()


@FEW
@given(st.integers(0, 10**6), st.integers(2, 9), st.floats(2.0, 12.0))
def test_a_free_frame_on_springs_moves_as_its_matrices_say(
    tmp_path_factory: pytest.TempPathFactory, seed: int, nodes: int, speed: float
) -> None:
    """Along x at one node and along y at two, with a box on one of them: steady, against a dense solution."""
    M, K, _ = frame(seed, nodes)
    C, n = 1e-5 * K, 3 * nodes
    file = tmp_path_factory.mktemp("frame") / "frame.npz"
    np.savez(file, M=M, C=C, K=K)
    held = {"stiffness": "20 kN/m", "damping": "90 N s/m"}
    links = {f"h{place}": {"between": [f"p{place}", "ground"], **held} for place in (0, 1, n - 2)}
    document: dict[str, Any] = {
        "structures": {"frame": {"file": str(file), "points": {f"p{place}": place for place in (0, 1, n - 2)}}},
        "bodies": {"box": {"mass": "40 kg"}},
        "links": {**links, "foot": {"between": ["box", "p1"], "stiffness": "30 kN/m", "damping": "150 N s/m"}},
        "excitations": {"e": {"kind": "force", "on": "box", "amplitude": "100 N", "speed": f"{speed!r} Hz"}},
        "measures": {"moved": {"response": "displacement", "of": "p0"}},
    }
    M, C, K = (np.pad(one, (0, 1)) for one in (M, C, K))
    M[n, n], stretch = 40.0, np.eye(n + 1)[n] - np.eye(n + 1)[1]
    for row, k, c in ((stretch, 30e3, 150.0), *((np.eye(n + 1)[place], 20e3, 90.0) for place in (0, 1, n - 2))):
        K, C = K + k * np.outer(row, row), C + c * np.outer(row, row)
    w = 2.0 * np.pi * speed
    own = abs(np.linalg.solve(K - w**2 * M + 1j * w * C, 100.0 * np.eye(n + 1)[n])[0])
    design = vo.solve(from_dict(document))
    assert design.status == "met", design.claim
    assert design.measures["moved"].value.value == pytest.approx(own, rel=1e-6)


@pytest.mark.parametrize(
    ("part", "count", "lost"), [(0.0, 1, 1e-9), (1e-17, 1, 1e-9), (1e-6, 0, 1e-8), (1e-12, 0, 1.0)]
)
def test_what_is_held_by_next_to_nothing_is_held_or_free_or_not_known(part: float, count: int, lost: float) -> None:
    """A chain on a spring to the ground that is a part of its own: digits know it, or not, or hardly."""
    n, stiffness = 12, 1234.5
    K = stiffness * (2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
    K[0, 0], K[-1, -1] = stiffness * (1.0 + part), stiffness
    of = sparsed(np.eye(n), 0.0 * K, K)
    assert free_motions(of).count == count
    found = digits_lost(of, [0, n - 1])
    assert found.worst < lost
    assert (found.worst > 1e-4) == (part == 1e-12)


def test_the_answer_says_what_nothing_holds(tmp_path: Path) -> None:
    K = 1e6 * np.array([[1.0, -1.0], [-1.0, 1.0]])
    np.savez(tmp_path / "pair.npz", M=np.eye(2), K=K)
    document = {
        "structures": {"pair": {"file": str(tmp_path / "pair.npz"), "points": {"a": 0}}},
        "links": {"held": {"between": ["a", "ground"], "stiffness": "1 kN/m"}},
        "excitations": {"e": {"kind": "force", "on": "a", "amplitude": "1 N", "speed": "1 Hz"}},
        "measures": {"moved": {"response": "displacement", "of": "a"}},
    }
    used = vo.solve(from_dict(document)).model
    assert used is not None
    assert "nothing holds 1 motion of it, to less than " in used.why
