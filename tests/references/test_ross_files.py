"""Rotors that ROSS saved: the files as it writes them, its own answers, and what a rotor does not have."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import vibopt as vo
from refusals import refused
from vibopt.cli.main import main
from vibopt.document.ross_file import ross_document
from vibopt.document.toml_writing import document_toml
from vibopt.errors import InputError
from vibopt.verify.as_built import machine_of

OFF = 5e-4
"""What elements as few as those of the files move an answer by."""


def element(n: int, long: float, outer: float, inner: float, steel: dict[str, Any]) -> dict[str, Any]:
    return {
        "L": long, "idl": inner, "odl": outer, "idr": inner, "odr": outer, "n": n, "axial_force": 0, "torque": 0,
        "shear_effects": True, "rotary_inertia": True, "gyroscopic": True, "shear_method_calc": "cowper",
        "tag": f"Shaft Element {n}", "alpha": 0.0, "beta": 0.0, "material": {"name": "Steel", **steel},
    }  # fmt: skip


def bearing(n: int, tag: str, **some: list[float]) -> dict[str, Any]:
    none: dict[str, Any] = {f"{force}{ends}": [0] for force in "kcm" for ends in ("xx", "xy", "yx", "yy", "zz")}
    return {**none, "n": n, "scale_factor": 1, "tag": tag, **some}


def saved(shaft: list[dict[str, Any]], **others: dict[str, Any]) -> dict[str, Any]:
    """As `Rotor.save` of ROSS 2.3.0 writes it."""
    elements = {f"ShaftElement_{one['tag']}": one for one in shaft}
    return {"ross_version": "2.3.0", "parameters": {}, **elements, **others}


def example() -> dict[str, Any]:
    """`rotor_example()` of ROSS: two discs between two bearings."""
    steel = {"rho": 7810.0, "E": 211e9, "G_s": 81.2e9}
    disc = {"m": 32.58972765304033, "Id": 0.17808928257067666, "Ip": 0.32956362089137037}
    stiff = {"kxx": [1e6], "kyy": [8e5]}
    return saved(
        [element(n, 0.25, 0.05, 0.0, steel) for n in range(6)],
        **{f"DiskElement_Disk {k}": {"n": n, **disc, "tag": f"Disk {k}"} for k, n in enumerate((2, 4))},
        **{f"BearingElement_Bearing {k}": bearing(n, f"Bearing {k}", **stiff) for k, n in enumerate((0, 6))},
    )


def machine() -> dict[str, Any]:
    """A hollow stepped shaft, a film by a table, and a pedestal."""
    steel = {"rho": 7850, "E": 207e9, "G_s": 79.6e9}
    sizes = [(0.1, 0.05, 0.0)] * 3 + [(0.15, 0.08, 0.02)] * 4 + [(0.1, 0.05, 0.0)] * 2
    film = {
        "kxx": [3e7, 2.6e7, 2e7], "kyy": [5e7, 4e7, 3e7], "kxy": [1e6, 2e6, 3e6], "kyx": [-1e6, -3e6, -4e6],
        "cxx": [3e4, 2e4, 1e4], "cyy": [5e4, 3e4, 2e4], "frequency": [50.0, 200.0, 700.0],
    }  # fmt: skip
    rear = bearing(7, "Rear", kxx=[4e7], kyy=[4e7], cxx=[2e3], cyy=[2e3])
    return saved(
        [element(n, *one, steel) for n, one in enumerate(sizes)],
        **{
            "DiskElement_Wheel A": {"n": 4, "m": 20.0, "Id": 0.2, "Ip": 0.35, "tag": "Wheel A", "scale_factor": 1.0},
            "DiskElement_Overhung": {"n": 9, "m": 8.0, "Id": 0.05, "Ip": 0.09, "tag": "Overhung"},
            "BearingElement_Front": bearing(1, "Front", **film),
            "BearingElement_Rear": {**rear, "n_link": 10},
            "BearingElement_Foot": bearing(10, "Foot", kxx=[8e7], kyy=[8e7], cxx=[1e3], cyy=[1e3]),
            "PointMass_Pedestal": {"n": 10, "m": None, "mx": 30.0, "my": 30.0, "mz": 0.0, "tag": "Pedestal"},
        },
    )


def written(folder: Path, document: dict[str, Any], name: str = "saved.json") -> Path:
    file = folder / name
    file.write_text(json.dumps(document) if name.endswith("json") else document_toml(document), encoding="utf-8")
    return file


def read(folder: Path, document: dict[str, Any], name: str = "saved.json") -> dict[str, Any]:
    return ross_document(written(folder, document, name))


def test_the_example_of_ross_whirls_as_ross_says(tmp_path: Path) -> None:
    """Greater half axes of both discs by ROSS 2.3.0 [m], six elements, 1 g m on the first; to the greater of both."""
    spins = np.array([50.0, 200.0, 400.0])
    right = {
        "disk_0": np.array([5.398499470416447e-06, 8.371353213780552e-06, 3.615390770262006e-05]),
        "disk_1": np.array([4.760639623871954e-06, 2.5184863038652382e-05, 1.0630125670757629e-05]),
    }
    built = machine_of(vo.from_dict(read(tmp_path, example())), {})
    moved = built.shake(spins, {"disk_0": 1e-3 * spins**2 + 0j}, {})
    greatest = np.maximum(*right.values())
    for point, far in right.items():
        assert (np.abs(np.abs(built.size(built.position(point, moved))) - far) <= OFF * greatest).all()


@pytest.mark.parametrize(("point", "right"), [
    ("wheel_a", (1.3773520806705089e-07, 2.4578794280364907e-06, 0.0004558633394415011)),
    ("overhung", (1.8774715160989093e-08, 3.4708917948620825e-07, 6.563424710167162e-05)),
])  # fmt: skip
def test_films_and_pedestals_are_those_of_ross(point: str, right: tuple[float, ...], tmp_path: Path) -> None:
    """At the speeds of the rows, by the matrices of ROSS 2.3.0 [m]; between them ROSS lays splines."""
    spins = np.array([50.0, 200.0, 700.0])
    built = machine_of(vo.from_dict(read(tmp_path, machine())), {})
    moved = built.shake(spins, {"wheel_a": 1e-3 * spins**2 + 0j}, {})
    assert np.abs(built.size(built.position(point, moved))) == pytest.approx(right, rel=OFF)


def test_toml_and_json_are_one_rotor_that_is_answered(tmp_path: Path) -> None:
    one = read(tmp_path, machine())
    whole = machine()
    del whole["PointMass_Pedestal"]["m"]
    assert read(tmp_path, whole, "saved.toml") == one
    sections = one["rotors"]["rotor"]["sections"]
    assert [each["length"] for each in sections] == ["300 mm", "600 mm", "200 mm"]
    assert one["excitations"]["imbalance"]["speed"] == "50..700 rad/s"
    design = vo.solve(vo.from_dict(one))
    assert design.status == "met"
    assert set(design.measures) == {
        "whirl_of_wheel_a", "whirl_of_overhung", "force_of_front", "force_of_rear", "force_of_foot",
    }  # fmt: skip


def test_the_command_writes_a_file_that_is_answered(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, target = written(tmp_path, example()), tmp_path / "rotor.toml"
    assert main(["new", "rotor", "--ross", str(file), "-o", str(target)]) == 0
    assert target.read_text(encoding="utf-8").startswith("# From saved.json, which ROSS saved.")
    assert main(["check", str(target)]) == 0
    capsys.readouterr()
    for words, sentence in (
        (["rotor"], "a rotor is written from one that ROSS saved. Name it: vibopt new rotor --ross saved.toml\n"),
        (["balance", "--ross", str(file)], "--ross is of a rotor: vibopt new rotor --ross saved.toml\n"),
    ):
        assert main(["new", *words]) == 2
        assert capsys.readouterr().err == sentence


FIRST, DISC, FILM = "ShaftElement_Shaft Element 0", "DiskElement_Disk 0", "BearingElement_Bearing 0"


def put(name: str, **some: Any) -> Callable[[dict[str, Any]], Any]:
    """Numbers of an element replaced."""
    return lambda whole: whole[name].update(some)


WRONG: dict[str, tuple[Callable[[dict[str, Any]], Any], str]] = {
    "no version": (
        lambda whole: whole.pop("ross_version"),
        "saved.json has no ross_version: it is no rotor that ROSS saved. Save it with Rotor.save.",
    ),
    "a cone": (put(FIRST, odr=0.06), f"saved.json: {FIRST} is conical, and sections are not. Write it as steps."),
    "a layer": (
        put("ShaftElement_Shaft Element 1", n=0),
        "saved.json: ShaftElement_Shaft Element 1 lies beside another element, or leaves a gap. Rotors have one "
        "section after another.",
    ),
    "another material": (
        put("ShaftElement_Shaft Element 1", material={"E": 1e11, "rho": 7810.0, "G_s": 81.2e9}),
        f"saved.json: ShaftElement_Shaft Element 1 is of another material than {FIRST}. A rotor has one.",
    ),
    "an axial force": (
        put(FIRST, axial_force=10.0),
        f"saved.json: {FIRST} has axial_force = 10, which sections do not have. Leave it out.",
    ),
    "no shear": (
        put(FIRST, shear_effects=False),
        f"saved.json: {FIRST} has shear_effects = false, and sections always count it. Leave it out.",
    ),
    "another coefficient": (
        put(FIRST, shear_method_calc="hutchinson"),
        f"saved.json: {FIRST} takes the shear coefficient by another method than Cowper's. Take that one.",
    ),
    "no number": (put(DISC, m="?"), f"saved.json: {DISC} has no number m. Save the rotor anew with Rotor.save."),
    "a disc in the air": (put(DISC, n=9), f"saved.json: {DISC} stands at node 9, where there is no shaft."),
    "a bearing in the air": (
        put(FILM, n=9), f"saved.json: {FILM} ends at node 9, where there is neither shaft nor PointMass.",
    ),
    "a bearing with a mass": (
        put(FILM, mxx=[2.0]), f"saved.json: {FILM} has an inertia mxx, which bearings do not have. Leave it out.",
    ),
    "a table without speeds": (
        put(FILM, kxx=[1e6, 2e6]), f"saved.json: {FILM} has 2 values of a coefficient and 1 speed. Save it anew.",
    ),
    "a gear": (
        lambda whole: whole.update(GearElement_g={"n": 2}),
        "saved.json: GearElement_g is a GearElement, which rotors do not have. Leave it out of the rotor that is "
        "saved.",
    ),
    "no shaft": (
        lambda whole: [whole.pop(one) for one in list(whole) if one.startswith("Shaft")],
        "saved.json: there is no ShaftElement in it. Save a whole rotor with Rotor.save.",
    ),
    "no bearing": (
        lambda whole: [whole.pop(one) for one in list(whole) if one.startswith("Bearing")],
        "saved.json: no bearing holds the shaft. Save the rotor with its bearings.",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("change", "sentence"), WRONG.values(), ids=WRONG)
def test_what_rotors_do_not_have_is_refused(
    change: Callable[[dict[str, Any]], Any], sentence: str, tmp_path: Path
) -> None:
    document = example()
    change(document)
    assert refused(read, tmp_path, document).messages == (sentence,)


def test_a_pedestal_that_differs_in_both_planes_is_refused(tmp_path: Path) -> None:
    for name, change, sentence in (
        ("BearingElement_Foot", {"kyy": [7e7]},
         "holds a pedestal otherwise along x than along y. Pedestals are alike in both planes."),
        ("PointMass_Pedestal", {"my": 20.0}, "has 30 kg along x and 20 kg along y. A body has one mass."),
    ):  # fmt: skip
        document = machine()
        document[name] |= change
        assert refused(read, tmp_path, document).messages == (f"saved.json: {name} {sentence}",)


def test_files_that_are_none_are_said(tmp_path: Path) -> None:
    file = tmp_path / "saved.json"
    file.write_text("{", encoding="utf-8")
    caught = refused(ross_document, file)
    assert caught.messages == ("saved.json is no valid JSON. Save the rotor anew with Rotor.save.",)
    with pytest.raises(InputError, match="is not there"):
        ross_document(tmp_path / "none.toml")
