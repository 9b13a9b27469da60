"""Rotors whose shaft comes as matrices: as the sections it was made of, in any units, order and form, and refused."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from refusals import refused
from shaft_files import ORDER, STEEL, both, plane, save, written
from test_rotors import RPM, asked, friswell, held
from vibopt.report.campbell import campbell_of
from vibopt.report.rotor_parts import rotors_of
from vibopt.report.space_views import machine_figure
from vibopt.scene.read import from_dict
from vibopt.solve import solve

NODES = tuple(np.linspace(0.0, 1.5, 7).tolist())
MEASURES = {
    "whirl": {"response": "displacement", "of": "second"},
    "force": {"response": "transmitted_force", "through": "left_bearing"},
    "forward": {"response": "critical_speed", "mode": 2},
    "backward": {"response": "critical_speed", "whirl": "backward"},
    "sag": {"response": "static_deflection", "of": "first"},
    "mass": {"response": "total_mass"},
}


def by_matrices(folder: Path, nodes: Any = NODES, **how: Any) -> dict[str, Any]:
    """The rotor of two discs, its shaft by files."""
    document = friswell()
    rotor = document["rotors"]["rotor"]
    for key in ("sections", "modulus", "shear_modulus", "density"):
        del rotor[key]
    rotor["matrices"] = written(folder, nodes, 0.05, **how)
    return {**document, "links": held(1e6, 400.0)}


def sections() -> dict[str, Any]:
    """The same by its sizes."""
    document = friswell(**STEEL)
    del document["rotors"]["rotor"]["shear_modulus"]
    return {**document, "links": held(1e6, 400.0)}


@pytest.mark.parametrize("ending", [".npy", ".csv", ".mtx", ".npz"])
def test_every_form_of_file_is_the_same_shaft(ending: str, tmp_path: Path) -> None:
    right = asked(by_matrices(tmp_path), **MEASURES)
    assert asked(by_matrices(tmp_path, ending=ending), **MEASURES) == pytest.approx(right, rel=1e-9)


@pytest.mark.parametrize(
    "units",
    [("t mm s", 1e3, 1e-3, 1.0), ("lbf in s", 4.4482216152605 / 0.0254, 0.0254, 1.0), ("g cm ms", 1e-3, 0.01, 1e-3)],
)
def test_units_are_those_that_are_said(units: Any, tmp_path: Path) -> None:
    right = asked(by_matrices(tmp_path), **MEASURES)
    assert asked(by_matrices(tmp_path, units=units), **MEASURES) == pytest.approx(right, rel=1e-9)


@settings(max_examples=20, suppress_health_check=list(HealthCheck), deadline=None)
@given(
    order=st.permutations([*ORDER, "x", "about_x"]),
    along=st.booleans(),
    mirrors=st.tuples(st.booleans(), st.booleans()),
)
def test_coordinates_may_stand_in_any_order_and_count_either_way(
    order: list[str], along: bool, mirrors: tuple[bool, bool], tmp_path_factory: Any
) -> None:
    folder = tmp_path_factory.mktemp("m")
    signs = {"y": mirrors[0], "about_z": mirrors[0], "z": mirrors[1], "about_y": not mirrors[1]}
    words = [f"-{one}" if signs.get(one) else one for one in order if along or one in ORDER]
    few = {key: MEASURES[key] for key in ("whirl", "forward", "sag")}
    assert asked(by_matrices(folder, order=words), **few) == pytest.approx(asked(by_matrices(folder), **few), rel=1e-9)


def test_finer_elements_come_to_the_shaft_of_sections(tmp_path: Path) -> None:
    """Two-node elements are off by the square of their length where they shear, else by its fourth power."""
    right = asked(sections(), **MEASURES)
    off = []
    for many in (6, 12):
        found = asked(by_matrices(tmp_path, np.linspace(0.0, 1.5, many + 1)), **MEASURES)
        off.append({key: abs(found[key] / right[key] - 1.0) for key in right})
    assert off[0]["mass"] < 1e-12
    assert off[0]["sag"] < 1e-9
    for key in ("forward", "backward"):
        assert off[0][key] < 1e-3
        assert off[1][key] < off[0][key] / 4.0


def test_the_orbit_is_that_of_both_planes_together(tmp_path: Path) -> None:
    """Four coordinates of a node in the order of the file, in bearings that differ and couple both planes."""
    film = {"k_yy": "1.5 MN/m", "k_yz": "0.2 MN/m", "k_zy": "-0.1 MN/m", "k_zz": "0.9 MN/m", "c_yy": "2 kN s/m",
            "c_zz": "900 N s/m"}  # fmt: skip
    document = by_matrices(tmp_path, lags=2e-6)
    document["links"] = {}
    document["bearings"] = {f"{one}_film": {"between": [one, "ground"], **film} for one in ("left", "right")}
    speed = 1300.0 * RPM
    document["excitations"]["imbalance"]["speed"] = f"{speed!r} rad/s"
    found = asked(document, whirl={"response": "displacement", "of": "second"})["whirl"]
    stiffness, inertia, polar = plane(NODES, 0.05)
    m, k, g = both(inertia), both(stiffness), both(polar, skew=True)
    c = 2e-6 * k
    for node, wide in ((2, 0.28), (4, 0.35)):
        mass = 7810.0 * math.pi / 4.0 * (wide**2 - 0.05**2) * 0.07
        about = mass * (wide**2 + 0.05**2) / 8.0
        across = about / 2.0 + mass * 0.07**2 / 12.0
        at = 4 * node
        m[range(at, at + 4), range(at, at + 4)] += [mass, mass, across, across]
        g[at + 2, at + 3] += about
        g[at + 3, at + 2] -= about
    for at in (0, 24):
        k[at : at + 2, at : at + 2] += [[1.5e6, 2e5], [-1e5, 9e5]]
        c[at : at + 2, at : at + 2] += np.diag([2e3, 900.0])
    force = np.zeros(28, dtype=complex)
    force[8:10] = 1e-3 * speed**2 * np.array([1.0, -1j])
    y, z = np.linalg.solve(k + 1j * speed * (c + speed * g) - speed**2 * m, force)[16:18]
    right = math.sqrt(0.5 * (abs(y) ** 2 + abs(z) ** 2 + abs(y**2 + z**2)))
    assert found == pytest.approx(right, rel=1e-9)


def test_a_threshold_of_fits_and_material_is_that_of_sections(tmp_path: Path) -> None:
    ask = {"m": {"response": "stability_threshold"}}
    fine = np.linspace(0.0, 1.5, 13)
    for document, other in ((by_matrices(tmp_path, fine), sections()),):
        for one in (document, other):
            one["rotors"]["rotor"]["material_damping"] = "0.05 ms"
            one["excitations"]["imbalance"]["speed"] = "100 rpm"
        assert asked(document, **ask)["m"] == pytest.approx(asked(other, **ask)["m"], rel=1e-5)


def test_a_disc_of_such_a_shaft_may_be_chosen_and_it_is_drawn(tmp_path: Path) -> None:
    document = by_matrices(tmp_path)
    document["rotors"]["rotor"]["discs"][1] = {"name": "second", "at": "1 m", "mass": {"from": "5 kg", "to": "60 kg"}}
    del document["measures"]
    document["limits"] = {"apart": {"response": "critical_speed", "at_least": "900 rpm"}}
    document["goal"] = {"maximise": "total_mass"}
    design = solve(from_dict(document))
    (mass,) = (one.value.value for one in design.variables.values())
    assert design.status in ("optimal", "feasible")
    assert 5.0 < mass < 60.0
    assert campbell_of(design).critical[0] == pytest.approx(900.0 * RPM, rel=1e-6)
    (rotor,) = rotors_of(design)
    assert [left for left, _, _, _ in rotor.sections] == pytest.approx(NODES[:-1])
    assert machine_figure(design) is not None


# What is refused

SCENE = "scene: rotors.rotor"
ORDERED = 'order = ["y", "z", "about_y", "about_z"].'


def said(document: dict[str, Any]) -> str:
    caught = refused(lambda: solve(from_dict(document)))
    return "\n".join(caught.messages)


KEYS: dict[str, tuple[str, Any, str]] = {
    "no units": (
        "units", None, ' does not say the units of its matrices. Write units = "kg m s", or "t mm s".',
    ),
    "no units of that name": (
        "units", "SI",
        '.units = "SI" is not three units, of mass or force, length and time. Write units = "kg m s", or "t mm s".',
    ),
    "no such coordinate": (
        "order", ["y", "z", "rx", "ry"],
        '.order = ["y", "z", "rx", "ry"] has "rx". The coordinates of a node are y, z, about_y and about_z, and x and '
        "about_x where the matrices have them, with a minus before it where one counts the other way: " + ORDERED,
    ),
    "a coordinate less": (
        "order", ["y", "z", "about_y"],
        f'.order = ["y", "z", "about_y"] has no about_z. Name each coordinate once: {ORDERED}',
    ),
    "a coordinate twice": (
        "order", ["y", "z", "about_y", "-y"],
        f'.order = ["y", "z", "about_y", "-y"] has y twice. Name each coordinate once: {ORDERED}',
    ),
    "nodes that are too few": (
        "nodes", ["0 m", "1 m"],
        " has 2 nodes of 4 coordinates, and matrices of 28 rows. Write a place for each node, and its coordinates in "
        "order.",
    ),
    "nodes that go back": (
        "nodes", ["0 m", "2 m", "1 m"],
        '.nodes = ["0 m", "2 m", "1 m"] does not rise from node 2 at 2 m to node 3 at 1 m. Number the nodes from left '
        'to '
        "right.",
    ),
    "no list of nodes": (
        "nodes", "0 m",
        '.nodes = "0 m" is no list of places. Write nodes = ["0 mm", "250 mm", "500 mm"], one for each node.',
    ),
    "a node that is no place": (
        "nodes", ["0 kg", "1 m"],
        '.nodes = ["0 kg", "1 m"] has "0 kg", which is a mass, but a length is needed here. Write a length, for '
        'example "20 mm". Write a place: "250 mm".',
    ),
    "a node left of the shaft": (
        "nodes", ["-1 m", "1 m"],
        '.nodes = ["-1 m", "1 m"] begins left of the shaft. Count places from its left end.',
    ),
    "the other sense of rotation": (
        "order", ["y", "-z", "-about_y", "about_z"],
        " has a matrix G (gyroscopic) that is of a shaft which turns from z to y. Turn z the other way, "
        '"-z" and "-about_y" in order, or give G for the other sense.',
    ),
    "a tilt that counts the other way": (
        "order", ["y", "z", "about_y", "-about_z"],
        " has a matrix M (mass) that is not alike in both planes: 0.0493167 between y of node 7 and about_z of node 7, "
        "and -0.0493167 between z of node 7 and about_y of node 7 (SI). Leave bearings out of the matrices and write "
        "them as [bearings.NAME], or correct the order and its signs.",
    ),
    "both tilts the other way": (
        "order", ["y", "z", "-about_y", "-about_z"],
        " has a matrix K (stiffness) that does not let the shaft tilt as a whole: at y of node 1 a force of 100 % of "
        "what its parts are holds it back. Leave supports out of it, or correct nodes, units, and the signs in order.",
    ),
    "lengths in other units": (
        "units", "kg mm s",
        " has a matrix K (stiffness) that does not let the shaft tilt as a whole: at y of node 1 a force of 99.8 % of "
        "what its parts are holds it back. Leave supports out of it, or correct nodes, units, and the signs in order.",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("key", "given", "sentence"), KEYS.values(), ids=KEYS)
def test_what_matrices_are_is_said_or_refused(key: str, given: Any, sentence: str, tmp_path: Path) -> None:
    document = by_matrices(tmp_path)
    matrices = document["rotors"]["rotor"]["matrices"]
    matrices[key] = given
    if given is None:
        del matrices[key]
    assert said(document) == f"{SCENE}.matrices{sentence}"


def put(*entries: tuple[int, int, float]) -> Callable[[Any], Any]:
    """Some entries replaced."""

    def changed(whole: Any) -> Any:
        for i, j, value in entries:
            whole[i, j] = value
        return whole

    return changed


def added(places: range | tuple[int, ...], value: float) -> Callable[[Any], Any]:
    """More on the diagonal."""
    return lambda whole: whole + value * np.diag(np.isin(np.arange(len(whole)), places).astype(float))


def without_tilting(whole: Any) -> Any:
    tilts = np.arange(len(whole)) % 4 >= 2
    whole[tilts], whole[:, tilts] = 0.0, 0.0
    return whole


MATRICES: dict[str, tuple[str, Callable[[Any], Any], str]] = {
    "of another size": (
        "stiffness", lambda whole: whole[:24, :24],
        " has matrices that are not of one size: mass 28, stiffness 24. Take them from one model.",
    ),
    "a mass that is singular": (
        "mass", without_tilting,
        " has a matrix M (mass) that is singular: about_z of node 1 has no inertia. Give every node a mass and a "
        "moment of inertia, as a consistent mass matrix does.",
    ),
    "a mass below nothing": (
        "mass", put((0, 4, 9.0), (4, 0, 9.0), (1, 5, 9.0), (5, 1, 9.0)),
        " has a matrix M (mass) that has a negative eigenvalue: some motion would have no mass, or a negative one. "
        "Check the export.",
    ),
    "a mass that couples the planes": (
        "mass", put((4, 5, 1.0), (5, 4, 1.0)),
        " has a matrix M (mass) that couples y of node 2 with z of node 2: the mass of a shaft acts in each plane by "
        "itself. Write what couples them as [bearings.NAME], or correct the order.",
    ),
    "a stiffness with its bearings": (
        "stiffness", added((0, 1, 24, 25), 1e7),
        " has a matrix K (stiffness) that does not let the shaft move along y as a whole: at y of node 1 a force of "
        "9.86 % of what its parts are holds it back. Leave bearings and supports out of the matrix, and write them as "
        "links or bearings.",
    ),
    "a stiffness of bearings that differ": (
        "stiffness", added((0,), 1e7),
        " has a matrix K (stiffness) that is not alike in both planes: 5.56946e+07 between y of node 1 and y of node "
        "1, and 4.56946e+07 between z of node 1 and z of node 1 (SI). Leave bearings out of the matrices and write "
        "them as [bearings.NAME], or correct the order and its signs.",
    ),
    "a stiffness that pushes": (
        "stiffness", lambda whole: -whole,
        " has a matrix K (stiffness) that lets y of node 2 go by itself. Check the export.",
    ),
    "a damping that drives": (
        "damping", lambda whole: -whole,
        " has a matrix C (damping) that has a negative eigenvalue: some motion would gain energy. Check signs and "
        "units.",
    ),
    "gyroscopic moments at a speed": (
        "gyroscopic", lambda whole: 300.0 * whole,
        " has a matrix G (gyroscopic) that has a polar inertia of more than twice the diametral one: there is no such "
        "shaft. Give the matrix that the spin in radians per unit of time is multiplied by, not that at a speed, in "
        "the units of the mass matrix.",
    ),
    "gyroscopic moments within a plane": (
        "gyroscopic", put((0, 3, 1.0), (3, 0, -1.0)),
        " has a matrix G (gyroscopic) that joins y of node 1 with about_z of node 1, in one plane: gyroscopic moments "
        "act from one plane on the other. Correct the order.",
    ),
    "gyroscopic moments that differ": (
        "gyroscopic", put((2, 7, 0.1), (7, 2, -0.1)),
        " has a matrix G (gyroscopic) that is not alike in both planes: -4.72734e-05 between about_z of node 1 and "
        "about_y of node 2, and 0.1 between about_z of node 2 and about_y of node 1 (SI). Correct the order and its "
        "signs.",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("key", "change", "sentence"), MATRICES.values(), ids=MATRICES)
def test_matrices_that_are_none_of_a_shaft_are_refused(
    key: str, change: Callable[[Any], Any], sentence: str, tmp_path: Path
) -> None:
    document = by_matrices(tmp_path, lags=1e-6)
    save(tmp_path / f"{key}.npy", change(np.load(tmp_path / f"{key}.npy")))
    assert said(document) == f"{SCENE}.matrices{sentence}"


FILES: dict[str, tuple[str, str | bytes, str]] = {
    "not skew": (
        "gyroscopic.csv", "",
        " cannot be used. It is not skew: row 2, column 3 has 5, and row 3, column 2 has -0.0001524 (counted from "
        "0), where gyroscopic moments have the opposite. Give the matrix that the speed of rotation is multiplied by, "
        "without damping.",
    ),
    "rows of other length": (
        "mass.csv", "1,2\n3\n",
        " cannot be used. Its row 2 has 1 number, others have 2. Write the whole matrix, a row a line.",
    ),
    "headings": (
        "mass.csv", "y,z\n3,3\n",
        ' cannot be used. Its row 1 has "y", which is no number. Write the numbers alone, without headings.',
    ),
    "damaged": ("mass.npy", b"\x93NUMPY\x01", " is no valid .npy file. Write it anew with numpy.save."),
}  # fmt: skip


@pytest.mark.parametrize(("name", "content", "sentence"), FILES.values(), ids=FILES)
def test_files_that_hold_no_matrix_are_refused(name: str, content: str | bytes, sentence: str, tmp_path: Path) -> None:
    key, ending = name.split(".")
    document = by_matrices(tmp_path, ending=f".{ending}")
    file = tmp_path / name
    if isinstance(content, bytes):
        file.write_bytes(content)
    elif content:
        file.write_text(content, encoding="utf-8")
    else:
        save(file, put((2, 3, 5.0))(np.loadtxt(file, delimiter=",")))
    assert said(document) == f'{SCENE}.matrices.{key} = "{file}"{sentence}'


def test_entries_of_few_digits_are_refused_where_the_mesh_is_fine(tmp_path: Path) -> None:
    document = by_matrices(tmp_path, np.linspace(0.0, 1.5, 121))
    whole = np.load(tmp_path / "stiffness.npy")
    save(tmp_path / "stiffness.npy", np.vectorize(lambda one: float(f"{one:.7e}"))(whole))
    start, _, end = said(document).partition(" may be ")
    assert start == (
        f"{SCENE}.matrices has a matrix K (stiffness) that does not hold enough digits: rounding of its entries"
    )
    assert end.endswith(
        "% of the stiffness of the slowest bending, and 0.01 % is the most that can be trusted. Write all digits of "
        "each entry."
    )


ROTOR: dict[str, tuple[dict[str, Any], str]] = {
    "sections as well": (
        {"sections": [{"length": "1 m", "diameter": "20 mm"}]},
        " gives matrices and sections. Keep the matrices, or sections with what they are made of.",
    ),
    "a density as well": (
        {"density": "7850 kg/m3"},
        " gives matrices and density. Keep the matrices, or sections with what they are made of.",
    ),
    "a station between nodes": (
        {"stations": {"left": "0.1 m", "right": "1.5 m"}},
        " has left at 0.1 m, where its matrices have no node; the nearest is at 0 m. Write that place, or export a "
        "node there.",
    ),
    "neither": (
        {"matrices": None}, ' has no sections. Write sections = [{ length = "0.5 m", diameter = "60 mm" }].',
    ),
}  # fmt: skip


@pytest.mark.parametrize(("over", "sentence"), ROTOR.values(), ids=ROTOR)
def test_a_rotor_has_matrices_or_sections(over: dict[str, Any], sentence: str, tmp_path: Path) -> None:
    document = by_matrices(tmp_path)
    document["rotors"]["rotor"] |= over
    assert said(document) == SCENE + sentence


def test_sections_need_what_they_are_made_of() -> None:
    for key, example in (("modulus", "207 GPa"), ("density", "7850 kg/m3")):
        document = friswell()
        del document["rotors"]["rotor"][key]
        assert said(document) == f'{SCENE} has sections and no {key}. Write {key} = "{example}".'


@pytest.mark.parametrize("key", ["bending_stress", "static_bending_stress", "combined_bending_stress"])
def test_matrices_know_no_stress(key: str, tmp_path: Path) -> None:
    document = {**by_matrices(tmp_path), "measures": {"s": {"response": key, "of": "rotor"}}}
    assert said(document) == (
        f"scene: measures.s asks for the {key} of rotors.rotor, whose matrices do not say how thick it is. Write its "
        "sections instead of the matrices, or ask for the displacement."
    )
