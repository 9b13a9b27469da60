"""Small machines in space and in a plane, on groups of mounts."""

from __future__ import annotations

from typing import Any

from draw import Draw
from machines import GRAVITY, Drawn, catalogue

_SIDES = (0.8, 0.5)
"""Half the length and half the width of what stands on mounts [m]."""


def in_space(draw: Draw) -> Drawn:
    """A body with six coordinates on four mounts, of one group or two."""
    made = Drawn(frequency=draw.size(4.0, 15.0))
    mass = draw.size(200.0, 3000.0)
    made.put("bodies", "machine", _solid(draw, mass))
    corners = [[sx * _SIDES[0], sy * _SIDES[1], 0.0] for sx in (1, -1) for sy in (1, -1)]
    below = _below(draw, made, mass)
    for name, at in (("left", corners[:2]), ("right", corners[2:])) if draw.chance(0.3) else (("foot", corners),):
        made.put("mounts", name, _mounts(draw, made, below, at, mass))
    return _named(draw, made)


def in_a_plane(draw: Draw) -> Drawn:
    """A body that moves along x and z and turns about y, on two mounts."""
    made = Drawn(frequency=draw.size(4.0, 15.0))
    mass = draw.size(100.0, 1000.0)
    inertia = draw.said(mass * 0.2, "inertia")
    table = {"motion": "plane", "mass": draw.value(mass, "mass", spread=2.0, vary=0.1), "inertia": inertia}
    made.put("bodies", "machine", {**table, **draw.pick([{}, {"centre": ["0.1 m", "0 m", "0.2 m"]}])})
    below = _below(draw, made, mass)
    made.put("mounts", "foot", _mounts(draw, made, below, [[0.7, 0.0, 0.0], [-0.7, 0.0, 0.0]], mass))
    return _named(draw, made)


def _named(draw: Draw, made: Drawn) -> Drawn:
    if draw.chance(0.5):
        made.put("points", "flange", {"on": "machine", "at": _place(draw, [0.6, 0.0, 0.5])})
    made.spatial |= {"machine", *made.names("points", "mounts")}
    return made


def _below(draw: Draw, made: Drawn, mass: float) -> str:
    """What carries the mounts: the ground, a base, or a floor that is a body on a line."""
    kind = draw.pick(["ground", "ground", "ground", "base", "body"])
    if kind == "base":
        return made.put("bases", "deck", {})
    if kind == "body":
        floor = {"mass": draw.said(3.0 * mass, "mass"), **draw.pick([{}, {"motion": "line"}])}
        made.put("bodies", "floor", floor)
        stiffness = draw.value(3.0 * mass * (2.0 * made.rate) ** 2, "stiffness")
        damped = draw.pick([{}, {"damping": draw.value(0.2 * mass * made.rate, "damping")}])
        made.put("links", "slab", {"between": ["floor", "ground"], "stiffness": stiffness, **damped})
        return "floor"
    return "ground"


def _solid(draw: Draw, mass: float) -> dict[str, Any]:
    heavy = {"mass": draw.value(mass, "mass", spread=1.5, vary=0.1)}
    centre = {"centre": _place(draw, [0.1, 0.05, 0.3])} if draw.chance(0.6) else {}
    three = [mass * part for part in (0.15, 0.3, 0.35)]
    kind = draw.pick(["principal", "principal", "tensor", "box", "cylinder", "pieces"])
    box = {"box": ["1.6 m", "1 m", "0.8 m"]}
    if kind == "pieces":
        half = {"mass": draw.said(0.5 * mass, "mass"), "shape": box}
        return {"made_of": [{**half, "centre": ["0.3 m", "0 m", "0.3 m"]}, {**half, "centre": ["-0.2 m", 0, "0.4 m"]}]}
    if kind == "tensor":
        moments = dict(zip(("xx", "yy", "zz"), (draw.said(one, "inertia") for one in three), strict=True))
        inertia: Any = {**moments, "xy": draw.said(0.02 * mass, "inertia")}
    else:
        inertia = [draw.said(one, "inertia") for one in three]
    shape = box if kind == "box" else {"cylinder": {"diameter": "0.8 m", "length": "1.5 m", "axis": "x"}}
    says = {"shape": shape} if kind in ("box", "cylinder") else {"inertia": inertia}
    loose = draw.pick([{"centre_tolerance": "10 mm"}, {"tolerance": "5 %"}]) if draw.doubt(0.15) else {}
    return {**heavy, **centre, **says, **(loose if not isinstance(heavy["mass"], dict) else {})}


def _place(draw: Draw, near: list[float]) -> list[Any]:
    return [draw.said(one * draw.size(0.7, 1.4), "length") if one else 0 for one in near]


def _mounts(draw: Draw, made: Drawn, below: str, at: list[list[float]], mass: float) -> dict[str, Any]:
    many = {"left": 4, "foot": len(at)}.get("foot", 4)
    stiffness = mass * made.rate**2 / many
    table: dict[str, Any] = {"between": ["machine", below], "at": _sites(draw, at)}
    if draw.chance(0.15):
        table["rating"] = f"10..{mass * GRAVITY:.4g} N"
    if draw.chance(0.15):
        table["gap"] = draw.said(0.005, "length")
    if draw.bought and draw.left:
        draw.left -= 1
        name = catalogue(draw, made, stiffness, mass * GRAVITY / many, shear=True)
        table.pop("rating", None)
        split = b"stiffness_x" in made.files[name]
        return {**table, "part": {"catalogue": name}, **({} if split else {"shear_ratio": 0.6})}
    if draw.chance(0.1):
        table["direction"] = [[0.3 if one[0] < 0 else -0.3, 0, 0.95] for one in at]
    return {**table, **_stiff(draw, stiffness, inclined="direction" in table)}


def _sites(draw: Draw, at: list[list[float]]) -> Any:
    """Places that are known, or of which the best set is to be chosen."""
    known = [[draw.said(x, "length") if x else "0 m" for x in one] for one in at]
    if not draw.left or not draw.chance(0.15):
        return known
    draw.left -= 1
    wider = [[draw.said(1.3 * x, "length") if x else "0 m" for x in one] for one in at]
    return {"one_of": [known, wider]}


def _stiff(draw: Draw, stiffness: float, *, inclined: bool) -> dict[str, Any]:
    """Stiffness and damping of one mount, along and across."""
    damping = 0.1 * stiffness / 40.0
    three = draw.chance(0.3) and not inclined
    if three:
        table: dict[str, Any] = {"stiffness": [draw.value(part * stiffness, "stiffness") for part in (0.6, 0.6, 1.0)]}
    else:
        table = {"stiffness": draw.value(stiffness, "stiffness"), "shear_ratio": draw.value(0.6, "ratio", vary=0.1)}
    kind = draw.pick(["damping", "damping", "loss_factor", ""])
    if kind == "damping" and three:
        table["damping"] = [draw.value(part * damping, "damping", vary=0.2) for part in (0.6, 0.6, 1.0)]
    elif kind == "damping":
        table["damping"] = draw.value(damping, "damping")
    elif kind:
        table["loss_factor"] = draw.value(0.1, "ratio", spread=3.0)
    if draw.chance(0.15):
        table["dynamic_to_static"] = 1.3
    if draw.doubt(0.06):
        table |= {"tolerance": "15 %", **draw.pick([{}, {"tolerance_of": "mount"}])}
    return table
