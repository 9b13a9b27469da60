"""A rotor that ROSS saved (`Rotor.save`, TOML or JSON) as a problem file: sections, discs, bearings and pedestals."""

from __future__ import annotations

import json
import math
import re
from codecs import BOM_UTF8
from collections.abc import Iterator, Mapping
from pathlib import Path as FilePath
from typing import Any, NoReturn

from vibopt.document.toml_reading import parsed
from vibopt.errors import InputError, counted
from vibopt.files.reading import FileFault, Kind, content_of, shown_name
from vibopt.records import dataclass

SAVED = Kind(
    "a rotor that ROSS saved", 50_000_000, "Name the file that Rotor.save wrote.", "Name a .toml or .json file."
)
_FORCES = ("k", "c")
_ALONG = {"x": "y", "y": "z"}
"""Axes across the shaft: ROSS has x level and y upward, z along the shaft."""
_SAME = 1e-9
_ZERO = ("axial_force", "torque", "alpha", "beta")
_TRUE = ("shear_effects", "rotary_inertia", "gyroscopic")
_STEEL = ("E", "rho", "G_s")
_HELD = ("BearingElement", "SealElement")
UNBALANCE, SPEEDS = "1 g m", "0..6000 rpm"
"""What drives the rotor in the file that is written: ROSS saves neither an unbalance nor speeds."""


@dataclass(frozen=True)
class _Element:
    """One element of the file: the name that it has there, its class, and its numbers."""

    name: str
    kind: str
    said: Mapping[str, Any]
    file: str

    def refuse(self, why: str) -> NoReturn:
        raise InputError(f"{self.file}: {self.name} {why}")

    def number(self, key: str, default: float | None = None) -> float:
        given = self.said.get(key)
        given = default if given is None else given
        if isinstance(given, list) and len(given) == 1:
            (given,) = given
        if isinstance(given, bool) or not isinstance(given, (int, float)) or not math.isfinite(given):
            self.refuse(f"has no number {key}. Save the rotor anew with Rotor.save.")
        return float(given)

    @property
    def node(self) -> int:
        return int(self.number("n"))


def ross_document(path: str | FilePath) -> dict[str, Any]:
    """The document of a problem file for a rotor that ROSS saved, with an unbalance of 1 g m, which it does not save.

    Raises
    ------
    InputError
        The file cannot be read, or has what rotors of a problem file do not: cones, layers, several materials, axial
        force, bearings with inertia, elements of other classes.
    """
    file = FilePath(path)
    elements = list(_elements(file))
    shaft = sorted((one for one in elements if one.kind == "ShaftElement"), key=lambda one: one.node)
    if not shaft:
        raise InputError(f"{file.name}: there is no ShaftElement in it. Save a whole rotor with Rotor.save.")
    places = _places(shaft)
    known = ("ShaftElement", "DiskElement", "PointMass")
    for one in elements:
        if one.kind not in known and not one.kind.endswith(_HELD):
            one.refuse(f"is a {one.kind}, which rotors do not have. Leave it out of the rotor that is saved.")
    names = _names(elements)
    discs, bodies = _heavy(elements, places, names)
    held = [one for one in elements if one.kind.endswith(_HELD)]
    stations = {f"node_{one.node}": _in("mm", places[one.node]) for one in held if one.node in places}
    if not stations:
        raise InputError(f"{file.name}: no bearing holds the shaft. Save the rotor with its bearings.")
    first = shaft[0].said["material"]
    rotor = {
        "sections": _sections(shaft),
        "stations": stations,
        "modulus": _in("GPa", first["E"]),
        "density": _in("kg/m3", first["rho"]),
        "shear_modulus": _in("GPa", first["G_s"]),
        "poisson_ratio": float(first["E"]) / (2.0 * float(first["G_s"])) - 1.0,
        **({"discs": list(discs.values())} if discs else {}),
    }
    bearings = {names[one.name]: _bearing(one, places, bodies) for one in held}
    links = {name: _link(one, bearings.pop(name)) for one in held if not places.keys() & _ends(one)
             for name in (names[one.name],)}  # fmt: skip
    points = [str(disc["name"]) for disc in discs.values()] or list(stations)
    shaker = {"kind": "unbalance", "on": points[0], "unbalance": UNBALANCE, "speed": _speeds(bearings)}
    return {
        "title": f"{file.stem}, a rotor of ROSS",
        "rotors": {"rotor": rotor},
        **({"bodies": {name: {"mass": mass} for name, mass in bodies.values()}} if bodies else {}),
        **({"bearings": bearings} if bearings else {}),
        **({"links": links} if links else {}),
        "excitations": {"imbalance": shaker},
        "measures": {
            **{f"whirl_of_{name}": {"response": "displacement", "of": name} for name in points},
            **{f"force_of_{one}": {"response": "transmitted_force", "through": one} for one in (*bearings, *links)},
        },
    }


def _speeds(bearings: Mapping[str, dict[str, Any]]) -> str:
    """Those at which all tables of bearings say something, whose own speeds get their unit here."""
    tables = [bearing["table"] for bearing in bearings.values() if "table" in bearing]
    if not tables:
        return SPEEDS
    low, high = max(table[0]["speed"] for table in tables), min(table[-1]["speed"] for table in tables)
    for row in (row for rows in tables for row in rows):
        row["speed"] = _in("rad/s", row["speed"])
    return f"{low:.12g}..{high:.12g} rad/s"


def _elements(file: FilePath) -> Iterator[_Element]:
    try:
        text = content_of(file, SAVED).removeprefix(BOM_UTF8).decode(errors="replace")
    except FileFault as fault:
        raise InputError(f"{shown_name(file)} {fault.text}") from None
    if file.suffix.lower() == ".json":
        try:
            document = json.loads(text)
        except (ValueError, RecursionError):
            raise InputError(f"{file.name} is no valid JSON. Save the rotor anew with Rotor.save.") from None
    else:
        document = parsed(text, file.name)
    if not isinstance(document, dict) or "ross_version" not in document:
        raise InputError(f"{file.name} has no ross_version: it is no rotor that ROSS saved. Save it with Rotor.save.")
    for name, said in document.items():
        if isinstance(said, Mapping) and name != "parameters":
            yield _Element(name, name.partition("_")[0], said, file.name)


def _places(shaft: list[_Element]) -> dict[int, float]:
    """Place of each node of the shaft [m], whose elements are looked at."""
    places, at = {shaft[0].node: 0.0}, 0.0
    material = shaft[0].said.get("material")
    for number, element in enumerate(shaft):
        if element.node != shaft[0].node + number:
            element.refuse("lies beside another element, or leaves a gap. Rotors have one section after another.")
        for key in _ZERO:
            if element.number(key, 0.0):
                element.refuse(f"has {key} = {element.number(key):g}, which sections do not have. Leave it out.")
        for key in _TRUE:
            if not element.said.get(key, True):
                element.refuse(f"has {key} = false, and sections always count it. Leave it out.")
        if element.said.get("shear_method_calc", "cowper") != "cowper":
            element.refuse("takes the shear coefficient by another method than Cowper's. Take that one.")
        outer, inner, *other = (element.number(key) for key in ("odl", "idl", "odr", "idr"))
        if abs(outer - other[0]) + abs(inner - other[1]) > _SAME * outer:
            element.refuse("is conical, and sections are not. Write it as steps.")
        own = element.said.get("material")
        if not isinstance(own, Mapping) or any(not isinstance(own.get(key), (int, float)) for key in _STEEL):
            element.refuse("has no material with E, rho and G_s. Save the rotor anew with Rotor.save.")
        assert isinstance(material, Mapping)
        if any(own[key] != material[key] for key in _STEEL):
            element.refuse(f"is of another material than {shaft[0].name}. A rotor has one.")
        at += element.number("L")
        places[element.node + 1] = at
    return places


def _sections(shaft: list[_Element]) -> list[dict[str, str]]:
    """Sections, of neighbours of the same diameters one."""
    found: list[tuple[float, float, float]] = []
    for element in shaft:
        long, outer, inner = (element.number(key) for key in ("L", "odl", "idl"))
        if found and found[-1][1:] == (outer, inner):
            long += found.pop()[0]
        found.append((long, outer, inner))
    return [
        {
            "length": _in("mm", long),
            "diameter": _in("mm", outer),
            **({"inner_diameter": _in("mm", inner)} if inner else {}),
        }
        for long, outer, inner in found
    ]


def _names(elements: list[_Element]) -> dict[str, str]:
    """A name of its own for each element, of letters, digits and underscores."""
    found: dict[str, str] = {}
    for element in elements:
        tag = element.said.get("tag")
        base = (
            re.sub(r"\W+", "_", str(tag or element.name.partition("_")[2] or element.kind).lower()).strip("_") or "part"
        )
        name, number = base, 2
        while name in found.values():
            name, number = f"{base}_{number}", number + 1
        found[element.name] = name
    return found


def _heavy(
    elements: list[_Element], places: Mapping[int, float], names: Mapping[str, str]
) -> tuple[dict[str, dict[str, Any]], dict[int, tuple[str, str]]]:
    """Discs and points with a mass on the shaft, and bodies beside it by their node."""
    discs: dict[str, dict[str, Any]] = {}
    bodies: dict[int, tuple[str, str]] = {}
    for element in elements:
        if element.kind == "DiskElement":
            if element.node not in places:
                element.refuse(f"stands at node {element.node}, where there is no shaft.")
            mass, across, about = (element.number(key) for key in ("m", "Id", "Ip"))
            discs[element.name] = {
                "name": names[element.name],
                "at": _in("mm", places[element.node]),
                "mass": _in("kg", mass),
            }
            if across or about:
                discs[element.name] |= {"diametral": _in("kg m2", across), "polar": _in("kg m2", about)}
        elif element.kind == "PointMass":
            level, upward = (element.number(key, element.number("m", 0.0)) for key in ("mx", "my"))
            if level != upward:
                element.refuse(f"has {level:g} kg along x and {upward:g} kg along y. A body has one mass.")
            if element.node in places:
                discs[element.name] = {
                    "name": names[element.name],
                    "at": _in("mm", places[element.node]),
                    "mass": _in("kg", level),
                }
            else:
                bodies[element.node] = names[element.name], _in("kg", level)
    return discs, bodies


def _ends(element: _Element) -> tuple[int, ...]:
    """Nodes at which a bearing ends; of the ground none."""
    link = element.said.get("n_link")
    return (element.node, link) if isinstance(link, int) else (element.node,)


def _link(element: _Element, said: dict[str, Any]) -> dict[str, Any]:
    """What holds a pedestal, alike in both planes."""
    words = {"k_yy": "stiffness", "c_yy": "damping"}
    if (
        "table" in said
        or any(said.get(f"{force}_yy") != said.get(f"{force}_zz") for force in _FORCES)
        or "k_yz" in said
    ):
        element.refuse("holds a pedestal otherwise along x than along y. Pedestals are alike in both planes.")
    return {"between": said["between"], **{words[key]: said[key] for key in words if key in said}}


def _bearing(element: _Element, places: Mapping[int, float], bodies: Mapping[int, tuple[str, str]]) -> dict[str, Any]:
    """Its ends, and its eight coefficients, by speed where they change."""

    def place(node: int) -> str:
        if node in places:
            return f"node_{node}"
        if node not in bodies:
            element.refuse(f"ends at node {node}, where there is neither shaft nor PointMass.")
        return bodies[node][0]

    first, *others = _ends(element)
    ends = [place(first), *(place(other) for other in others)] if others else [place(first), "ground"]
    for key in ("mxx", "mxy", "myx", "myy"):
        if any(_list(element.said.get(key, 0.0))):
            element.refuse(f"has an inertia {key}, which bearings do not have. Leave it out.")
    rows = {}
    for force in _FORCES:
        for a, b in (("x", "x"), ("x", "y"), ("y", "x"), ("y", "y")):
            unit = "MN/m" if force == "k" else "kN s/m"
            values = _list(element.said.get(f"{force}{a}{b}", 0.0))
            rows[f"{force}_{_ALONG[a]}{_ALONG[b]}"] = values, unit
    speeds = _list(element.said.get("frequency") or 0.0)
    many = max(len(values) for values, _ in rows.values())
    if many > 1 and len(speeds) != many:
        element.refuse(
            f"has {counted(many, 'values')} of a coefficient and {counted(len(speeds), 'speeds')}. Save it anew."
        )

    def at(k: int) -> dict[str, str]:
        found = {key: values[k if len(values) > 1 else 0] for key, (values, _) in rows.items()}
        pairs = {"yz": "zy", "zy": "yz"}
        kept = [key for key in found if found[key] or found.get(key[:2] + pairs.get(key[2:], "-"))]
        return {key: _in(rows[key][1], found[key]) for key in kept}

    if many == 1:
        return {"between": ends, **at(0)}
    return {"between": ends, "table": [{"speed": speed, **at(k)} for k, speed in enumerate(speeds)]}


_SIZES = {"mm": 1e-3, "GPa": 1e9, "MN/m": 1e6, "kN s/m": 1e3}


def _in(unit: str, value: float) -> str:
    """A value [SI] as a file has it."""
    return f"{value / _SIZES.get(unit, 1.0):.12g} {unit}"


def _list(given: Any) -> list[float]:
    return [float(one) for one in given] if isinstance(given, list) else [float(given)]
