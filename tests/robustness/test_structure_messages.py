"""Matrices and modes of structures that cannot be used, each with its sentence, word for word."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sparse
from scipy.io import mmwrite

import vibopt as vo
from rods import beam
from vibopt.devices import structure
from vibopt.errors import InputError

MASS = np.diag([10.0, 10.0, 10.0])
STIFFNESS = np.array([[2e6, -1e6, 0.0], [-1e6, 2e6, -1e6], [0.0, -1e6, 1e6]])
DAMPING = 1e-4 * STIFFNESS
SKID = """[structures.skid]
mass = "mass.mtx"
stiffness = "stiffness.mtx"
damping = "damping.mtx"
points = { end = 2 }
"""
MODES = """[structures.skid]
modes = [
{ frequency = "10 Hz", damping_ratio = 0.01, modal_mass = "2 t", shape = { end = 1.0, mid = 0.5 } },
{ frequency = "20 Hz", modal_mass = "1 t", shape = { end = 1.0, mid = 0.3 } },
]
"""
REST = """
[bodies.pump]
mass = "50 kg"
[links.mount]
between = ["pump", "ground"]
stiffness = "200 kN/m"
[measures.first]
response = "natural_frequency"
"""


def put(matrix: np.ndarray, place: tuple[int, int], value: float) -> np.ndarray:
    """The matrix with one entry replaced."""
    changed = matrix.copy()
    changed[place] = value
    return changed


def said(folder: Path, table: str, matrices: Mapping[str, np.ndarray] | None = None) -> list[str]:
    """What reading the scene complains of."""
    for name, matrix in {"mass": MASS, "stiffness": STIFFNESS, "damping": DAMPING, **(matrices or {})}.items():
        mmwrite(folder / f"{name}.mtx", sparse.coo_array(matrix), symmetry="general")
    file = folder / "bad.toml"
    file.write_text(table + REST, encoding="utf-8")
    try:
        vo.read(file)
    except InputError as error:
        return list(error.messages)
    return []


def test_good_matrices_and_modes_pass(tmp_path: Path) -> None:
    assert said(tmp_path, SKID) == []
    assert said(tmp_path, MODES) == []


MATRICES: dict[str, tuple[dict[str, np.ndarray], str]] = {
    "stiffness not symmetric": (
        {"stiffness": put(STIFFNESS, (0, 1), -2e6)},
        'bad.toml line 3: structures.skid.stiffness = "stiffness.mtx" cannot be used. It is not symmetric: row 0, '
        "column 1 has -2e+06, but row 1, column 0 has -1e+06 (counted from 0). Write both triangles alike, or one "
        'triangle of a file that says "symmetric" in its first line.',
    ),
    "damping not symmetric": (
        {"damping": put(DAMPING, (2, 1), 7.0)},
        'bad.toml line 4: structures.skid.damping = "damping.mtx" cannot be used. It is not symmetric: row 1, column 2 '
        "has -100, but row 2, column 1 has 7 (counted from 0). Write both triangles alike, or one triangle of a file "
        'that says "symmetric" in its first line.',
    ),
    "sizes": (
        {"mass": MASS[:2, :2]},
        "bad.toml line 1: structures.skid has matrices that are not of one size: mass 2, stiffness 3. Take them from "
        "one model.",
    ),
    "not square": (
        {"mass": MASS[:2]},
        'bad.toml line 2: structures.skid.mass = "mass.mtx" cannot be used. It is not square: 2 rows, 3 columns. '
        "Export the whole matrix.",
    ),
    "nan": (
        {"mass": put(MASS, (1, 1), np.nan)},
        'bad.toml line 2: structures.skid.mass = "mass.mtx" cannot be used. It has nan at row 1, column 1 (counted '
        "from 0), which is no number. Correct the export.",
    ),
    "inf": (
        {"stiffness": put(STIFFNESS, (1, 1), np.inf)},
        'bad.toml line 3: structures.skid.stiffness = "stiffness.mtx" cannot be used. It has inf at row 1, column 1 '
        "(counted from 0), which is no number. Correct the export.",
    ),
    "negative mass": (
        {"mass": put(MASS, (1, 1), -10.0)},
        'bad.toml line 2: structures.skid.mass = "mass.mtx" cannot be used. It has the mass -10 kg at coordinate 1 '
        "(counted from 0); a mass is positive. Leave a coordinate without mass out (static condensation).",
    ),
    "indefinite mass": (
        {"mass": put(put(MASS, (0, 1), 20.0), (1, 0), 20.0)},
        'bad.toml line 2: structures.skid.mass = "mass.mtx" cannot be used. It is not positive definite: some motion '
        "would have a negative mass. Check signs and units of the export.",
    ),
    "negative stiffness": (
        {"stiffness": put(put(STIFFNESS, (0, 1), -3e6), (1, 0), -3e6)},
        'bad.toml line 3: structures.skid.stiffness = "stiffness.mtx" cannot be used. It has a negative eigenvalue: '
        "some motion would be pushed on instead of held back. Check signs and units of the export.",
    ),
    "negative damping": (
        {"damping": -DAMPING},
        'bad.toml line 4: structures.skid.damping = "damping.mtx" cannot be used. It has -200 at coordinate 0 (counted '
        "from 0); a damping is not negative. Check signs and units of the export.",
    ),
    "damping that gives energy": (
        {"damping": put(put(DAMPING, (0, 1), -400.0), (1, 0), -400.0)},
        'bad.toml line 4: structures.skid.damping = "damping.mtx" cannot be used. It has a negative eigenvalue: some '
        "motion would gain energy. Check signs and units of the export.",
    ),
    "complex": (
        {"stiffness": STIFFNESS * (1 + 0.01j)},
        'bad.toml line 3: structures.skid.stiffness = "stiffness.mtx" cannot be used. It has complex values; mass, '
        "damping and stiffness are real. Write structural damping as loss_factor = 0.02.",
    ),
}


@pytest.mark.parametrize("case", MATRICES)
def test_wrong_matrices(case: str, tmp_path: Path) -> None:
    matrices, sentence = MATRICES[case]
    assert said(tmp_path, SKID, matrices) == [sentence]


TABLES = {
    "format": (
        SKID.replace("mass.mtx", "bad.toml"),
        'bad.toml line 2: structures.skid.mass = "bad.toml" is in no format that vibopt reads. Give a Matrix Market '
        "file (.mtx), a NumPy file (.npy, .npz) or a table (.csv).",
    ),
    "no file name": (
        SKID.replace('"mass.mtx"', "3"),
        'bad.toml line 2: structures.skid.mass = 3 is no file name. Write it in quotation marks: "m.mtx".',
    ),
    "point": (
        SKID.replace("end = 2", "end = 3"),
        "bad.toml line 1: structures.skid puts end at coordinate 3, but there are 3, numbered from 0 to 2. Check the "
        "number; it counts from 0.",
    ),
    "point in words": (
        SKID.replace("end = 2", 'end = "2"'),
        'bad.toml line 5: structures.skid.points = { end = "2" } gives end no coordinate number. Write points = { end '
        "= 12 }, counted from 0.",
    ),
    "no points": (
        SKID.replace("points = { end = 2 }\n", ""),
        "bad.toml line 1: structures.skid has no points. Write points = { midspan = 12 }, with coordinate numbers from "
        "0.",
    ),
    "no stiffness": (
        SKID.replace('stiffness = "stiffness.mtx"\n', ""),
        'bad.toml line 1: structures.skid has no stiffness matrix. Write stiffness = "stiffness.mtx".',
    ),
    "nothing": (
        "[structures.skid]\n",
        "bad.toml line 1: structures.skid has neither modes nor matrices. Write modes = [{ frequency, damping_ratio, "
        'modal_mass, shape }], or mass = "m.mtx" and stiffness = "k.mtx".',
    ),
    "missing point": (
        MODES.replace(", mid = 0.3", ""),
        "bad.toml line 1: structures.skid has no value for mid in the shape of mode 2. Every mode says how every point "
        "moves; write mid = 0 where it does not.",
    ),
    "no mode": (
        "[structures.skid]\nmodes = []\n",
        "bad.toml line 2: structures.skid.modes = [] is an empty list. Give at least one mode, or leave the structure "
        "out.",
    ),
    "negative modal mass": (
        MODES.replace('"1 t"', '"-1 t"'),
        'bad.toml line 4: structures.skid.modes[2].modal_mass = "-1 t" is not greater than zero. Write a positive '
        'value, for example "300 kg".',
    ),
    "no frequency": (
        MODES.replace('frequency = "20 Hz", ', ""),
        "bad.toml line 4: structures.skid.modes[2] has no frequency. Add it.",
    ),
    "shape in words": (
        MODES.replace("0.3", '"a"'),
        'bad.toml line 4: structures.skid.modes[2].shape = { end = 1.0, mid = "a" } gives mid no number. Write shape = '
        "{ mid = 1.0 }.",
    ),
    "modes and points": (
        MODES + "points = { a = 1 }\n",
        "bad.toml line 1: structures.skid gives modes and points. Keep the modes, or the matrices with their points.",
    ),
    "one point of two structures": (
        MODES + MODES.replace("skid", "floor").replace("mid", "other"),
        "bad.toml line 6: structures.floor has a point end, which takes a name that structures.skid has already. "
        "Choose another.",
    ),
}


@pytest.mark.parametrize("case", TABLES)
def test_wrong_tables(case: str, tmp_path: Path) -> None:
    table, sentence = TABLES[case]
    assert said(tmp_path, table) == [sentence]


def test_a_file_that_is_missing_or_broken(tmp_path: Path) -> None:
    assert said(tmp_path, SKID.replace("mass.mtx", "m.mtx")) == [
        f'bad.toml line 2: structures.skid.mass = "m.mtx" is not there. vibopt looked for {tmp_path / "m.mtx"}; write '
        "it as seen from the problem file."
    ]
    (tmp_path / "m.mtx").write_text("no matrix", encoding="utf-8")
    (sentence,) = said(tmp_path, SKID.replace("mass.mtx", "m.mtx"))
    assert sentence.startswith('bad.toml line 2: structures.skid.mass = "m.mtx" is no valid Matrix Market file: ')
    assert sentence.endswith(" Write it anew, for example with scipy.io.mmwrite.")


def test_several_matrices_in_one_file(tmp_path: Path) -> None:
    table = '[structures.skid]\nfile = "skid.npz"\npoints = { end = 2 }\n'
    begin = 'bad.toml line 2: structures.skid.file = "skid.npz" '
    file = tmp_path / "skid.npz"
    np.savez(file, M=MASS, K=STIFFNESS, C=DAMPING)
    assert said(tmp_path, table) == []
    one = sparse.csc_array(STIFFNESS)
    np.savez(file, M=MASS, K_data=one.data, K_indices=one.indices, K_indptr=one.indptr, K_shape=one.shape)
    assert said(tmp_path, table) == []
    np.savez(file, M=MASS)
    assert said(tmp_path, table) == [begin + "has no matrix K (stiffness). Add it to the file."]
    np.savez(file, M=np.array([one], dtype=object), K=STIFFNESS)
    assert said(tmp_path, table) == [
        begin
        + "holds Python objects, which vibopt does not open. Save each matrix with scipy.sparse.save_npz, or as a "
        "dense array."
    ]
    file.write_bytes(b"PK\x03\x04 cut off")
    assert said(tmp_path, table) == [
        begin + "is no valid .npz file. Write it anew with numpy.savez or scipy.sparse.save_npz."
    ]


def test_a_beam_that_has_lost_its_digits_is_not_trusted(tmp_path: Path) -> None:
    fine = beam(10_000)
    sparse.save_npz(tmp_path / "m.npz", sparse.csc_matrix(fine.mass))
    sparse.save_npz(tmp_path / "k.npz", sparse.csc_matrix(fine.stiffness))
    table = '[structures.skid]\nmass = "m.npz"\nstiffness = "k.npz"\npoints = { end = 19998 }\n'
    assert said(tmp_path, table) == [
        'bad.toml line 3: structures.skid.stiffness = "k.npz" does not hold enough digits: rounding each of its '
        "entries once moves the receptance at end by 2.3 %, and 0.01 % is the most that can be trusted. Either "
        "the mesh is much finer than the motion needs, or nothing holds it: take fewer elements, or give modes instead."
    ]


N = 4
FREE = np.diag([1.0, 2.0, 2.0, 1.0]) - np.diag(np.ones(3), 1) - np.diag(np.ones(3), -1)
BLOCKS: dict[str, np.ndarray] = {
    "empty": np.zeros((N, N)), "free": FREE, "of one coordinate": np.diag([1.0, 0.0, 0.0, 0.0]),
    "of one direction": np.ones((N, N)), "crossed": np.eye(N)[::-1],
    "one pair": np.kron(np.diag([1.0, 0]), np.eye(2)[::-1]),
    "crossed beside one": np.diag([9.0, 0.0, 0.0, 0.0]) + np.kron(np.diag([0.0, 1.0]), np.eye(2)[::-1]),
}  # fmt: skip


@pytest.mark.sampled(4)
@pytest.mark.parametrize("c", BLOCKS)
@pytest.mark.parametrize("k", BLOCKS)
@pytest.mark.parametrize("m", ["whole", "empty", "of one coordinate", "of one direction", "crossed"])
def test_singular_matrices_are_answered_or_refused_and_what_pulls_both_ways_never_passes(
    m: str, k: str, c: str, tmp_path: Path
) -> None:
    mass = 10.0 * (np.eye(N) if m == "whole" else BLOCKS[m])
    np.savez(tmp_path / "all.npz", M=mass, K=1e6 * BLOCKS[k], C=10.0 * BLOCKS[c])
    file = tmp_path / "bad.toml"
    file.write_text('[structures.skid]\nfile = "all.npz"\npoints = { end = 0 }\n' + REST, encoding="utf-8")
    indefinite = any(np.linalg.eigvalsh(BLOCKS[one]).min() < -1e-9 for one in (k, c))
    passes = m == "whole" and k != "empty" and not indefinite
    with nullcontext() if passes else pytest.raises(InputError):
        vo.solve(vo.read(file))


@pytest.mark.parametrize(("k", "said_of_it"), [
    ("empty", "is empty: nothing that has a mass has a stiffness. Check the export."),
    ("one pair", "has a negative eigenvalue: some motion would be pushed on instead of held back. Check signs and "
     "units of the export."),
])  # fmt: skip
def test_a_stiffness_that_holds_nothing_is_said(k: str, said_of_it: str, tmp_path: Path) -> None:
    table = SKID.replace('damping = "damping.mtx"\n', "")
    assert said(tmp_path, table, {"mass": np.eye(N), "stiffness": BLOCKS[k]}) == [
        f'bad.toml line 3: structures.skid.stiffness = "stiffness.mtx" cannot be used. It {said_of_it}'
    ]


def test_a_structure_that_its_coordinates_do_not_carry_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, matrix in (("mass", MASS), ("stiffness", STIFFNESS), ("damping", DAMPING)):
        mmwrite(tmp_path / f"{name}.mtx", sparse.coo_array(matrix))
    (tmp_path / "scene.toml").write_text(SKID + REST, encoding="utf-8")
    assert vo.solve(vo.read(tmp_path / "scene.toml")).status == "met"
    good = structure._reduced
    monkeypatch.setattr(structure, "_reduced", lambda *given: replace(good(*given), error=3e-3))
    with pytest.raises(InputError) as error:
        vo.solve(vo.read(tmp_path / "scene.toml"))
    assert "structures.skid moves in more ways up to" in str(error.value)
    assert (
        "with 3 coordinates, receptances are off by 3e-03 of their size, and 1e-06 is the most. "
        "Ask up to a lower frequency, or give its modes instead."
    ) in str(error.value)
