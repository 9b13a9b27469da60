"""Scenes with structures, against dense matrices put together here and solved at many speeds."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sparse
from scipy.io import mmread

import vibopt as vo
from rods import rod
from vibopt.scene.read import with_changes

GIRDER = Path(__file__).parents[2] / "problems" / "absorbers" / "gallery_girder.toml"
THIRD, MIDDLE, MASS, UNBALANCE = 7, 11, 60.0, 0.15


def dense(part: str) -> np.ndarray:
    """A matrix of the girder, with a row and a column for the absorber."""
    return np.pad(mmread(GIRDER.with_name(f"gallery_{part}.mtx")).toarray(), (0, 1))


def midspan(frequency: float, ratio: float, speeds: np.ndarray) -> np.ndarray:
    """Amplitude of midspan at speeds [rad/s], (n,)."""
    mass, damping, stiffness = (dense(part) for part in ("mass", "damping", "stiffness"))
    row = np.zeros(len(mass))
    row[[MIDDLE, -1]] = -1.0, 1.0
    mass[-1, -1] = MASS
    stiffness += MASS * frequency**2 * np.outer(row, row)
    damping += 2.0 * ratio * MASS * frequency * np.outer(row, row)
    w = speeds[:, None, None]
    load = np.zeros((len(speeds), len(mass), 1))
    load[:, THIRD, 0] = UNBALANCE * speeds**2
    return np.abs(np.linalg.solve(stiffness - w**2 * mass + 1j * w * damping, load)[:, MIDDLE, 0])


def test_the_girder_moves_as_its_dense_matrices_say() -> None:
    design = vo.solve(vo.read(GIRDER))
    assert design.status == "optimal"
    frequency, ratio = design.x
    speeds = np.linspace(300.0, 900.0, 4001) * np.pi / 30.0
    assert design.goal is not None
    assert midspan(frequency, ratio, speeds).max() == pytest.approx(design.goal[1].value, rel=1e-6)
    coarse = speeds[::20]
    beside = [
        midspan(frequency * a, min(ratio * b, 0.5), coarse).max()
        for a in np.linspace(0.9, 1.1, 9)
        for b in np.linspace(0.6, 1.6, 9)
    ]
    assert min(beside) > design.goal[1].value * (1.0 - 1e-5)


def test_the_answer_says_how_good_the_structure_is() -> None:
    design = vo.solve(vo.read(GIRDER))
    assert design.model.declared_dof == 25
    assert design.model.used_dof < 12
    assert design.model.why.startswith("girder: 24 degrees of freedom, ")
    assert "checked at 11 frequencies" in design.model.why


def test_changes_see_the_same_files() -> None:
    scene = with_changes(vo.read(GIRDER), {"structures.girder.points.middle": 9})
    assert scene.structures["girder"].matrices.size == 24


def test_a_mode_that_no_point_sees_still_counts(tmp_path: Path) -> None:
    """The middle of a free rod is at rest in its first elastic mode, at 250 Hz."""
    free = rod(300, held=False)
    sparse.save_npz(tmp_path / "m.npz", sparse.csc_matrix(free.mass))
    sparse.save_npz(tmp_path / "k.npz", sparse.csc_matrix(free.stiffness))
    file = tmp_path / "rod.toml"
    file.write_text(
        """
[structures.rod]
mass = "m.npz"
stiffness = "k.npz"
points = { middle = 150 }
[links.held]
between = ["middle", "ground"]
stiffness = "1 MN/m"
[limits.away]
response = "natural_frequency"
outside = "200..300 Hz"
[measures.second]
response = "natural_frequency"
mode = 2
""",
        encoding="utf-8",
    )
    design = vo.solve(vo.read(file))
    assert design.status == "violated"
    assert design.measures["second"].value.value == pytest.approx(500.0 * np.pi, rel=1e-4)


MODES = """
[structures.floor]
modes = [
  { frequency = "10 Hz", modal_mass = "2 t", shape = { midspan = 1.0, quarter = 0.7 } },
  { frequency = "38 Hz", damping_ratio = 0.01, modal_mass = "1 t", shape = { midspan = 0.0, quarter = 1.0 } },
]
[bodies.pump]
mass = "300 kg"
[links.mount]
between = ["quarter", "pump"]
stiffness = "800 kN/m"
damping = "2 kN s/m"
[absorbers.tmd]
on = "midspan"
mass = "60 kg"
frequency = "10 Hz"
damping_ratio = 0.1
[excitations.pump]
kind = "force"
on = "pump"
amplitude = "100 N"
varies = "constant"
speed = "5..40 Hz"
[measures.midspan]
response = "displacement"
of = "midspan"
at = "10 Hz"
[measures.worst]
response = "displacement"
of = "midspan"
[measures.mount]
response = "transmitted_force"
through = "mount"
[measures.second]
response = "natural_frequency"
mode = 2
[measures.sag]
response = "static_deflection"
of = "pump"
"""


def test_a_list_of_modes_carries_bodies_and_absorbers() -> None:
    """Coordinates here: both modes, pump, absorber; the band has an undamped resonance of the floor in it."""
    turn = 2.0 * np.pi
    rows = np.array([[0.7, 1.0, -1.0, 0.0], [1.0, 0.0, 0.0, -1.0]])
    mass = np.diag([2000.0, 1000.0, 300.0, 60.0])
    k = np.array([8e5, 60.0 * (10 * turn) ** 2])
    c = np.array([2e3, 0.2 * 60.0 * 10 * turn])
    stiffness = np.diag([2000.0 * (10 * turn) ** 2, 1000.0 * (38 * turn) ** 2, 0.0, 0.0]) + (rows.T * k) @ rows
    damping = np.diag([0.0, 0.02 * 1000.0 * 38 * turn, 0.0, 0.0]) + (rows.T * c) @ rows

    def moved(speeds: np.ndarray) -> np.ndarray:
        w = speeds[:, None, None]
        load = np.broadcast_to(np.array([0, 0, 100.0, 0])[:, None], (len(speeds), 4, 1))
        return np.linalg.solve(stiffness - w**2 * mass + 1j * w * damping, load)[..., 0]

    found = vo.solve(vo.from_text(MODES)).measures
    speeds = np.linspace(5.0, 40.0, 200_001) * turn
    motion = moved(speeds)
    force = np.abs((k[0] + 1j * speeds * c[0]) * (motion @ rows[0]))
    assert found["midspan"].value.value == pytest.approx(abs(moved(np.array([10 * turn]))[0, 0]), rel=1e-9)
    assert found["worst"].value.value == pytest.approx(np.abs(motion[:, 0]).max(), rel=1e-7)
    assert found["mount"].value.value == pytest.approx(force.max(), rel=1e-7)
    modes = np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real))
    assert found["second"].value.value == pytest.approx(modes[1], rel=1e-9)
    weights = np.array([0.0, 0.0, 300.0, 60.0]) * 9.80665
    weights = np.linalg.solve(stiffness, weights)
    assert found["sag"].value.value == pytest.approx(weights[2], rel=1e-9)


def test_a_rod_of_many_elements_is_designed_and_measured_in_full(tmp_path: Path) -> None:
    of = rod(3000, mass_damping=2.0)
    for name in ("mass", "stiffness", "damping"):
        sparse.save_npz(tmp_path / f"{name}.npz", sparse.csc_matrix(getattr(of, name)))
    text = """
[structures.rod]
mass = "mass.npz"
stiffness = "stiffness.npz"
damping = "damping.npz"
points = { end = 2999, middle = 1500 }
[absorbers.one]
on = "end"
mass = "20 kg"
frequency = { from = "50 Hz", to = "250 Hz" }
damping_ratio = { from = 0.01, to = 0.5 }
[excitations.shaker]
kind = "force"
on = "middle"
amplitude = "100 N"
varies = "constant"
speed = "20..400 Hz"
[goal]
minimise = "displacement"
of = "end"
"""
    file = tmp_path / "rod.toml"
    file.write_text(text, encoding="utf-8")
    design = vo.solve(vo.read(file))
    assert design.status in ("optimal", "feasible")
    assert design.model.declared_dof == 3001
    assert design.model.used_dof < 30
    assert design.goal is not None
    full = _by_sparse(of, design.x, np.linspace(20.0, 400.0, 400) * 2.0 * np.pi)
    assert full.max() <= design.goal[1].value * (1.0 + 1e-7)
    assert full.max() >= design.goal[1].value * 0.99


def _by_sparse(of: object, x: tuple[float, ...], speeds: np.ndarray) -> np.ndarray:
    """Amplitude of the end per speed, the rod and its absorber in one sparse matrix."""
    from scipy.sparse.linalg import spsolve

    frequency, ratio = x
    found = []
    for w in speeds.tolist():
        z = 20.0 * frequency**2 + 2j * w * 20.0 * frequency * ratio
        block = sparse.coo_array(([z, -z, -z, z - 20.0 * w**2], ([2999, 2999, 3000, 3000], [2999, 3000, 2999, 3000])))
        host = of.stiffness - w**2 * of.mass + 1j * w * of.damping
        whole = sparse.coo_array((host.tocoo().data, (host.tocoo().row, host.tocoo().col)), shape=(3001, 3001)) + block
        load = np.zeros(3001, dtype=complex)
        load[1500] = 100.0
        found.append(abs(spsolve(whole.tocsc(), load)[2999]))
    return np.array(found)
