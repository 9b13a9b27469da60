"""Small machines on lines, about axes and on structures: bodies, bases, links, absorbers, structures."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from draw import Draw, aside

GRAVITY = 9.80665


@dataclass
class Drawn:
    """A document with the files that lie beside it.

    `frequency` [Hz] is about where the machine resonates, `spatial` are the names of what has directions.
    """

    document: dict[str, Any] = field(default_factory=dict)
    files: dict[str, bytes] = field(default_factory=dict)
    frequency: float = 10.0
    spatial: set[str] = field(default_factory=set)
    turning: set[str] = field(default_factory=set)
    points: list[str] = field(default_factory=list)
    folder: Path = Path()

    def put(self, family: str, name: str, table: Mapping[str, Any]) -> str:
        self.document.setdefault(family, {})[name] = dict(table)
        return name

    def lay(self) -> None:
        """Write the files that the document names."""
        for name, content in self.files.items():
            (self.folder / name).write_bytes(content)

    def names(self, *families: str) -> list[str]:
        return [name for family in families for name in self.document.get(family, {})]

    @property
    def rate(self) -> float:
        """Angular rate near which the machine resonates [rad/s]."""
        return 2.0 * math.pi * self.frequency


def on_a_line(draw: Draw) -> Drawn:
    """Bodies in a chain that moves along a line, held by the ground, by a base, or by nothing."""
    made = Drawn(frequency=draw.size(2.0, 20.0))
    end = made.put("bases", "floor", {}) if draw.chance(0.35) else "ground"
    free = end == "ground" and draw.chance(0.06) and not draw.small
    count = draw.pick([1, 1, 1, 2, 2, 3]) if not free else 2
    for index in range(count):
        mass = draw.size(20.0, 2000.0)
        body = made.put("bodies", f"body{index + 1}", _heavy(draw, mass))
        if index or not free:
            made.put("links", f"link{index + 1}", _link(draw, made, [body, end], mass))
        if draw.chance(0.08) and not free:
            made.put("links", f"damper{index + 1}", {"between": [end, body], "damping": draw.value(mass, "damping")})
        end = body
    return made


def that_rubs(draw: Draw) -> Drawn:
    """One body that slides on its only link."""
    made, mass = Drawn(frequency=draw.size(2.0, 20.0)), draw.size(20.0, 2000.0)
    end = made.put("bases", "floor", {}) if draw.chance(0.35) else "ground"
    body = made.put("bodies", "body1", {"mass": draw.said(mass, "mass")})
    stiffness = draw.said(mass * made.rate**2 * draw.size(0.5, 2.0), "stiffness")
    friction = draw.value(mass * GRAVITY * draw.size(0.001, 0.2), "force", spread=3.0)
    damping = {"damping": draw.said(0.2 * mass * made.rate, "damping")} if draw.chance(0.5) else {}
    made.put("links", "link1", {"between": [body, end], "stiffness": stiffness, "friction_force": friction, **damping})
    return made


def that_spins(draw: Draw) -> Drawn:
    """One disc or two in a row, on links of which the last has a damping that turns with the shaft."""
    made, end = Drawn(frequency=draw.size(5.0, 50.0)), "ground"
    for number in range(1, draw.pick([2, 3])):
        mass = draw.size(2.0, 200.0)
        body = made.put("bodies", f"body{number}", {"mass": draw.value(mass, "mass", spread=2.0)})
        stiffness = draw.value(mass * made.rate**2 * draw.size(0.5, 2.0), "stiffness", spread=5.0)
        damping = draw.value(draw.size(0.02, 0.2) * mass * made.rate, "damping", spread=3.0)
        link = {"between": [body, end], "stiffness": stiffness, "damping": damping}
        end = body if made.put("links", f"link{number}", link) else end
    turning = draw.value(draw.size(0.01, 0.1) * mass * made.rate, "damping", spread=3.0)
    made.document["links"][f"link{number}"]["rotating_damping"] = turning
    return made


def that_whirls(draw: Draw) -> Drawn:
    """A shaft with a disc between two bearings, or beyond the second, that spins."""
    made = Drawn(frequency=draw.size(10.0, 40.0), points=["left", "right", "disc"])
    mass, at = draw.size(5.0, 80.0), draw.pick([0.3, 0.5, 1.2])
    wide = (64.0 * mass * made.rate**2 * draw.size(0.5, 2.0) / (48.0 * 210e9 * math.pi)) ** 0.25
    radius = draw.size(0.1, 0.3)
    disc: dict[str, Any] = {"name": "disc", "at": draw.said(at, "length"), "mass": draw.said(mass, "mass")}
    if draw.chance(0.8):
        disc["polar"] = draw.said(0.5 * mass * radius**2, "inertia")
        disc["diametral"] = draw.said(0.3 * mass * radius**2, "inertia")
    section = {"diameter": draw.said(wide, "length"), **draw.pick([{}, {"inner_ratio": 0.5}])}
    table = {
        "sections": [{"length": "0.6 m", **section}, {"length": "0.7 m", **section}],
        "discs": [disc],
        "stations": {"left": "0 m", "right": "1 m"},
        "modulus": "210 GPa",
        "density": "7850 kg/m3",
    }
    made.put("rotors", "shaft", table)
    for one in ("left", "right"):
        stiffness = draw.value(mass * made.rate**2 * draw.size(2.0, 20.0), "stiffness", vary=0.2)
        damping = draw.said(0.2 * mass * made.rate, "damping")
        between = {"between": [one, "ground"]}
        if one == "right" and not isinstance(stiffness, dict):  # alike in both planes: critical speeds ask for it
            rows = {"k_yy": stiffness, "k_zz": stiffness, "c_yy": damping, "c_zz": damping}
            made.put("bearings", "film", {**between, **rows})
        else:
            made.put("links", f"{one}_bearing", {**between, "stiffness": stiffness, "damping": damping})
    return made


def _heavy(draw: Draw, mass: float) -> dict[str, Any]:
    if draw.chance(0.1):
        return {"weight": draw.said(mass * GRAVITY, "force")}
    table: dict[str, Any] = {"mass": draw.value(mass, "mass", spread=2.0, vary=0.1)}
    if draw.chance(0.08):
        radius = draw.size(0.05, 0.4)
        inertia = draw.said(0.4 * mass * radius**2, "inertia")
        table["rolling"] = {"inertia": inertia, "radius": draw.said(radius, "length")}
    if draw.doubt(0.05) and not isinstance(table["mass"], dict):
        table["tolerance"] = "5 %"
    return table


def _link(draw: Draw, made: Drawn, between: list[str], mass: float) -> dict[str, Any]:
    stiffness = mass * made.rate**2 * draw.size(0.5, 2.0)
    table: dict[str, Any] = {"between": between if draw.chance(0.8) else between[::-1]}
    many = 1
    if draw.chance(0.2):
        table["count"] = draw.whole(2, 6)
        many = 4
    if draw.bought and draw.left:
        draw.left -= 1
        table["part"] = {"catalogue": catalogue(draw, made, stiffness / many, mass * GRAVITY / many, shear=False)}
        return _choosing(draw, made, table)
    if draw.bent or draw.chance(0.08):
        table["beam"] = _beam(draw, stiffness / many)
    else:
        table["stiffness"] = draw.value(stiffness / many, "stiffness", spread=10.0)
    if draw.chance(0.1):
        table["dynamic_to_static"] = draw.size(1.1, 1.8)
    if draw.doubt(0.06):
        table["tolerance"] = "15 %"
    return {**table, **_damper(draw, between[0], stiffness / many, mass)}


def _choosing(draw: Draw, made: Drawn, table: dict[str, Any]) -> dict[str, Any]:
    """A part that is chosen among all, among a few, or named."""
    names = [line.split(b",")[0].decode() for line in made.files[table["part"]["catalogue"]].splitlines()[1:]]
    more = draw.pick([{}, {}, {"only": names[:2]}, {"name": names[0]}])
    return {**table, "part": {**table["part"], **more}}


def _damper(draw: Draw, body: str, stiffness: float, mass: float) -> dict[str, Any]:
    ratio = draw.size(0.01, 0.5)
    kind = draw.pick(["damping", "damping", "damping", "damping_ratio", "loss_factor", ""])
    if kind == "damping":
        return {"damping": draw.value(2.0 * ratio * math.sqrt(stiffness * mass), "damping", spread=10.0)}
    if kind == "damping_ratio":
        return {"damping_ratio": draw.value(ratio, "ratio", spread=3.0), "relative_to": body}
    return {"loss_factor": draw.value(ratio, "ratio", spread=3.0)} if kind else {}


def _beam(draw: Draw, stiffness: float) -> dict[str, Any]:
    """A beam of about a stiffness under a load at its tip or its middle."""
    kinds = ["simply_supported", "cantilever", "fixed", "fixed_pinned"]
    kind, long = draw.pick([*kinds, "overhung"] if draw.bent else kinds), draw.size(0.5, 3.0)
    factor = {"simply_supported": 48.0, "cantilever": 3.0, "fixed": 192.0, "fixed_pinned": 107.0, "overhung": 32.0}[
        kind
    ]
    second = stiffness * long**3 / (factor * 207e9)
    table = {"kind": kind, "length": draw.said(long, "length"), "modulus": "207 GPa"}
    if draw.bent:
        table |= {"at_ratio": 1.25} if kind == "overhung" else draw.pick([{}, {"at_ratio": 0.4}])
        table |= draw.pick([{}, {"inner_ratio": 0.5}])
        return {**table, "diameter": draw.value((64.0 * second / math.pi) ** 0.25, "length", spread=1.5)}
    if draw.chance(0.5):
        return {**table, "second_moment": f"{second * 1e8:.4g} cm4"}
    return {**table, "diameter": draw.said((64.0 * second / math.pi) ** 0.25, "length")}


def catalogue(draw: Draw, made: Drawn, stiffness: float, load: float, *, shear: bool) -> str:
    """A catalogue of a few parts about a stiffness and a static load; its name."""
    damped = draw.pick(["damping [N s/m]", "loss factor", ""] if shear else ["damping [N s/m]", "loss factor"])
    heads = ["part", "stiffness [N/mm]", "rated load max [N]", "price [EUR]", *([damped] if damped else [])]
    heads += ["stiffness_x [N/mm]", "stiffness_y [N/mm]"] if shear and draw.chance(0.5) else []
    heads += draw.pick([[], [] if draw.small else ["tolerance [%]"], ["dynamic to static"]])
    rows = [",".join(heads)]
    for index in range(draw.random.randint(2, 4)):
        k = stiffness * draw.size(0.2, 5.0)
        cells = {"part": f"M{index + 1}", "damping [N s/m]": 1e-3 * k, "loss factor": draw.size(0.05, 0.3)}
        cells |= {"stiffness [N/mm]": 1e-3 * k, "rated load max [N]": load * draw.size(0.7, 6.0)}
        cells |= {"stiffness_x [N/mm]": 5e-4 * k, "stiffness_y [N/mm]": 7e-4 * k, "tolerance [%]": 10}
        cells |= {"price [EUR]": draw.size(5.0, 50.0), "dynamic to static": draw.size(1.1, 1.6)}
        rows.append(",".join(cells[head] if head == "part" else f"{cells[head]:.4g}" for head in heads))
    name = f"parts{len(made.files) + 1}.csv"
    made.files[name] = ("\n".join(rows) + "\n").encode()
    return name


def about_an_axis(draw: Draw, *, geared: bool = False) -> Drawn:
    """Discs on shafts, now and then one that is geared to the one before; `geared`: each of them, on a shaft held."""
    made = Drawn(frequency=draw.size(5.0, 60.0))
    end, free = "ground", draw.chance(0.1) and not draw.small and not geared
    for index in range(2 if free else draw.pick([2, 2, 3] if geared else [1, 1, 2, 3])):
        mass, wide = draw.size(5.0, 50.0), draw.size(0.2, 0.6)
        inertia = mass * wide**2 / 8.0
        disc = {"disc": {"mass": draw.said(mass, "mass"), "diameter": draw.said(wide, "length")}}
        body = made.put(
            "bodies",
            f"disc{index + 1}",
            disc if draw.chance(0.3) else {"inertia": draw.value(inertia, "inertia", spread=2.0, vary=0.1)},
        )
        made.turning.add(body)
        shaft = _shaft(draw, made, [body, end], inertia) if index or not free else {}
        if index and not free and (geared or aside(shaft).chance(0.25)):
            made.document["bodies"][body] |= {"geared_to": end, "speed_ratio": aside(shaft).pick([-0.4, 3.0])}
        elif shaft:
            made.put("links", f"shaft{index + 1}", shaft)
        end = body
    return made


def that_is_geared(draw: Draw) -> Drawn:
    """Discs of which each turns with the one before."""
    return about_an_axis(draw, geared=True)


def _shaft(draw: Draw, made: Drawn, between: list[str], inertia: float) -> dict[str, Any]:
    stiffness = inertia * made.rate**2 * draw.size(0.5, 2.0)
    table: dict[str, Any] = {"between": between}
    if draw.chance(0.3):
        wide = (32.0 * stiffness * 0.5 / (math.pi * 80e9)) ** 0.25
        shape = {"length": "0.5 m", "diameter": draw.value(wide, "length", spread=1.5), "shear_modulus": "80 GPa"}
        table["shaft"] = {**shape, **draw.pick([{}, {"inner_ratio": 0.4}])}
    else:
        table["torsional_stiffness"] = draw.value(stiffness, "torsional_stiffness", spread=10.0)
    kind, ratio = draw.pick(["torsional_damping", "torsional_damping", "damping_ratio", "loss_factor", ""]), 0.1
    if kind == "torsional_damping":
        damping = 2.0 * ratio * math.sqrt(stiffness * inertia)
        return {**table, kind: draw.value(damping, "torsional_damping", spread=10.0)}
    if kind:
        table[kind] = draw.value(ratio, "ratio", spread=3.0)
    return {**table, **({"relative_to": between[0]} if kind == "damping_ratio" else {})}


def with_absorber(draw: Draw, made: Drawn) -> Drawn:
    """The same machine with an absorber on one of its points, now and then with two, one upon the other."""
    under = [*made.names("bodies"), *made.points, *(made.names("points") if made.spatial else [])]
    host: Any = draw.pick(under)
    alike = [one for one in made.names("bodies") if one not in made.spatial]
    if len(alike) > 1 and draw.chance(0.2):
        host = {"one_of": alike[:2]}
    for name, under_it in (("tmd", host), ("upper", "tmd")):
        if name == "tmd" or draw.chance(0.1):
            table = _absorber(draw, made, under_it)
            made.put("absorbers", name, table)
            made.spatial |= {name} if "direction" in table else set()
    return made


def with_inerter(draw: Draw, made: Drawn) -> Drawn:
    """The same machine with an inerter between two of its points, or from one to a support."""
    sliding = made.spatial & {*made.names("absorbers")}
    moving = [one for one in (*made.names("bodies", "absorbers"), *made.points) if one not in sliding]
    supports = ["ground", *made.names("bases")]
    one = draw.pick([end for end in moving if end in made.spatial] or moving)
    other = draw.pick([end for end in (*moving, *supports) if end != one])
    table: dict[str, Any] = {"between": draw.pick([[one, other], [other, one]])}
    bodies = [end for end in made.names("bodies") if end not in made.spatial or end == one]
    if made.turning:
        table["torsional_inertance"] = draw.value(draw.size(0.01, 1.0), "inertia", spread=2.0, vary=0.2)
    elif bodies and draw.chance(0.4):
        table |= {"mass_ratio": draw.value(0.1, "ratio", spread=3.0, vary=0.2), "relative_to": draw.pick(bodies)}
    else:
        table["inertance"] = draw.value(draw.size(2.0, 100.0), "mass", spread=3.0, vary=0.2)
    if one in made.spatial:
        table |= {"at": ["0.4 m", "0.2 m", "0.1 m"], "direction": draw.pick(["z", [0.6, 0, 0.8]])}
    made.put("inerters", "inerter", table)
    return made


def _absorber(draw: Draw, made: Drawn, host: Any) -> dict[str, Any]:
    around = bool(made.turning)
    mass = draw.size(0.02, 0.3) if around else draw.size(2.0, 40.0)
    heavy = "inertia" if around else "mass"
    table: dict[str, Any] = {"on": host}
    slides = isinstance(host, str) and host in made.spatial
    if slides:
        table["direction"] = draw.pick(["x", "y", "z", [0.6, 0, 0.8]])
        table |= {"at": ["0.4 m", "0.1 m", "0.3 m"]} if host == "machine" and draw.chance(0.5) else {}
    if host in made.points or draw.chance(0.5):
        table[heavy] = draw.value(mass, heavy, spread=3.0, vary=0.3)
    else:
        table["mass_ratio"] = draw.value(draw.size(0.02, 0.2), "ratio", spread=2.0, vary=0.3)
    springs = ["tuning", "frequency", "stiffness", "tuning"] + ([] if slides else [""] if around else ["", "length"])
    spring = draw.pick(springs)
    if spring == "stiffness":
        key = "torsional_stiffness" if around else "stiffness"
        table[key] = draw.value(mass * made.rate**2, key)
    elif spring == "tuning":
        table |= {"tuning": draw.value(0.95, "ratio", spread=1.5)}
        tuned = {"tuning_to": draw.said(made.rate, "angular_rate")}
        table |= draw.pick([{"mode": 2}, tuned] if slides else [{}, {}, tuned])
    elif spring:
        typical = made.rate if spring == "frequency" else GRAVITY / made.rate**2
        table[spring] = draw.value(typical, {"frequency": "angular_rate", "length": "length"}[spring], spread=1.5)
    along = "torsional_damping" if around else "damping"
    kind = draw.pick([along, "damping_ratio", "damping_ratio", "loss_factor", ""]) if spring else along
    if kind == along:
        table[kind] = draw.value(0.3 * mass * made.rate, kind)
    elif kind:
        table[kind] = draw.value(0.1, "ratio", spread=3.0)
    return table


def on_a_structure(draw: Draw) -> Drawn:
    """A body on a structure of a few modes, or of matrices in files."""
    made = Drawn(frequency=draw.size(3.0, 15.0), points=["midspan", "quarter"])
    heavy = draw.size(500.0, 5000.0)
    if draw.chance(0.6):
        shapes = [{"midspan": 1.0, "quarter": 0.7}, {"midspan": 0.0, "quarter": 1.0}, {"midspan": -0.8, "quarter": 0.3}]
        modes = [
            {"frequency": draw.said(made.rate * (n + 1) ** 2, "angular_rate"), "damping_ratio": draw.size(0.005, 0.05)}
            | {"modal_mass": draw.said(heavy, "mass"), "shape": shapes[n]}
            for n in range(draw.random.randint(1, 3))
        ]
        made.put("structures", "floor", {"modes": modes})
    else:
        _matrices(draw, made, heavy)
    mass = draw.size(50.0, 500.0)
    if draw.chance(0.8):
        made.put("bodies", "machine", _heavy(draw, mass))
        made.put("links", "mount", _link(draw, made, ["machine", draw.pick(made.points)], mass))
    return made


def _matrices(draw: Draw, made: Drawn, heavy: float) -> None:
    """Three masses in a chain between two walls, as one archive or as single files."""
    from scipy.io import mmwrite
    from scipy.sparse import coo_array

    stiffness = heavy * made.rate**2
    M = np.eye(3) * heavy
    K = stiffness * (2.0 * np.eye(3) - np.eye(3, k=1) - np.eye(3, k=-1))
    C = 0.002 / made.rate * K
    points = {"midspan": 1, "quarter": 0}
    if draw.chance(0.5):
        packed = BytesIO()
        np.savez(packed, M=M, K=K, C=C)
        made.files["floor.npz"] = packed.getvalue()
        made.put("structures", "floor", {"file": "floor.npz", "points": points})
        return
    table: dict[str, Any] = {"points": points}
    for key, matrix in (("mass", M), ("stiffness", K)):
        text = BytesIO()
        mmwrite(text, coo_array(matrix))
        made.files[f"{key}.mtx"] = text.getvalue()
        table[key] = f"{key}.mtx"
    made.put("structures", "floor", {**table, **draw.pick([{}, {"loss_factor": 0.02}])})
