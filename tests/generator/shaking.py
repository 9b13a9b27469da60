"""What shakes a drawn machine: one recipe for each kind of excitation."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, get_args

from draw import Draw, aside
from machines import Drawn
from vibopt.excitations import KINDS
from vibopt.excitations.pulse import Shape

Table = dict[str, Any]
SMOOTH = ("half sine", "versed sine", "sine", "triangle", "decaying sine")
"""Pulses that may be those of a displacement."""
_HIGHEST = 6.0
"""Highest speed, over the one at which the machine resonates."""


def shaken(draw: Draw, made: Drawn, *, sort: str, many: int = 1) -> None:
    """Adds excitations of kinds that act on something there; one of the `sort` that is asked for first."""
    fits = [kind for kind in KINDS if _places(kind, made)] if "rotors" not in made.document else ["unbalance"]
    sorts = {one: [kind for kind in fits if KINDS[kind].sort == one] for one in ("steady", "random", "transient")}
    other = "random" if sort == "steady" else "steady"
    for index in range(many):
        kinds = sorts[sort if index == 0 else other] or sorts["steady"]
        if kinds:
            rare = [kind for kind in kinds if set(_places(kind, made)) <= set(made.names("bases"))]
            kind = draw.pick([*kinds, *rare, *rare, *rare])
            on = draw.pick(_places(kind, made))
            made.put("excitations", f"shaker{index + 1}", {"kind": kind, "on": on, **recipe(kind)(draw, made, on)})


def recipe(kind: str) -> Callable[[Draw, Drawn, str], Table]:
    """How a kind of excitation is drawn."""
    if kind not in RECIPES:
        raise LookupError(
            f'the generator has no recipe for excitations of kind "{kind}". Add one to RECIPES in '
            "tests/generator/shaking.py."
        )
    return RECIPES[kind]


def _places(kind: str, made: Drawn) -> list[str]:
    """Names on which a kind of excitation acts."""
    bases = [] if made.turning else made.names("bases")
    bodies = [*made.names("bodies"), *made.points, *made.names("points")]
    lines = [one for one in bodies if one not in made.turning]
    rigid = [one for one in made.names("bodies") if one in made.spatial]
    named: dict[str, list[str]] = {
        "base_motion": bases,
        "road": bases if not made.spatial else [],
        "moment": [*made.turning, *rigid],
        "moment_harmonics": rigid,
        "pulse": [] if made.turning else [*lines, *bases],
        "drop": bases,
        "release": sorted({*lines} - {*made.points, *made.names("points")}) if not made.turning else [],
        "record": [] if made.turning else [*lines, *bases],
        "white_noise": [*([] if made.turning else lines), *bases],
    }
    return sorted(named.get(kind, lines))


def _speed(draw: Draw, made: Drawn) -> Table:
    """Own speeds: one, several, a range or ranges."""
    unit = draw.pick(["rpm", "Hz"])
    one = (60.0 if unit == "rpm" else 1.0) * made.frequency
    low, high = sorted((draw.size(0.3, 4.0) * one, draw.size(0.3, 4.0) * one))
    if high < 1.02 * low:
        high = 1.3 * low
    first, last = f"{low:.4g}", f"{high:.4g}"
    ways: list[Any] = [f"{last} {unit}"] * 3
    ways += [f"{first}..{last} {unit}", [f"{first} {unit}", f"{last} {unit}"]]
    return {"speed": draw.pick(ways)}


def _steady(draw: Draw, made: Drawn) -> Table:
    """Speeds, and how an amplitude varies away from them."""
    table = _speed(draw, made)
    top = f"{60.0 * _HIGHEST * made.frequency:.4g} rpm"
    rows: list[list[Any]] = [["0 rpm", 0.2], [f"{60.0 * made.frequency:.4g} rpm", 1.0], [top, draw.size(0.5, 2.0)]]
    table["varies"] = draw.pick(["constant", "constant", "speed^2", "speed", rows])
    single = isinstance(table["speed"], str) and ".." not in table["speed"]
    if table["varies"] in ("speed", "speed^2") and not single:
        table["amplitude_at"] = f"{60.0 * made.frequency:.4g} rpm"
    return table


def _way(draw: Draw, made: Drawn, on: str) -> Table:
    """The direction of what acts in space, and now and then the place."""
    if on not in made.spatial:
        return {}
    at = {"at": ["0.3 m", "0.1 m", "0.4 m"]} if on in made.names("bodies") and draw.chance(0.3) else {}
    return {"direction": draw.pick(["x", "y", "z", "z", [0.5, 0, 0.866]]), **at}


def _along(draw: Draw, made: Drawn, on: str) -> Table:
    """The direction of what comes once, or of noise, on a body in space or on a base that carries one."""
    if on in made.names("bases") and made.spatial:
        return {"direction": draw.pick(["x", "y", "z", [0.5, 0, 0.866]])}
    return _way(draw, made, on)


def _begins(made: Drawn, steady: Table) -> Table:
    """Now and then suddenly, where it has one speed, on a line."""
    one = isinstance(steady["speed"], str) and ".." not in steady["speed"]
    return {"begins": "suddenly"} if one and not made.spatial and aside(steady).chance(0.3) else {}


def _force(draw: Draw, made: Drawn, on: str) -> Table:
    amplitude = draw.said(draw.size(10.0, 2000.0), "force", amplitude=True)
    steady = _steady(draw, made)
    return {**steady, **_way(draw, made, on), **_begins(made, steady), "amplitude": amplitude}


def _unbalance(draw: Draw, made: Drawn, on: str) -> Table:
    says = {"unbalance": draw.said(draw.size(0.005, 0.5), "unbalance")}
    if draw.chance(0.3):
        says = {"rotating_mass": "3 kg", "radius": draw.said(draw.size(0.002, 0.1), "length")}
    way = _way(draw, made, on)
    if way and draw.chance(0.6):
        way["axis"] = way.pop("direction")
    return {**_speed(draw, made), **way, **says}


def _harmonics(draw: Draw, made: Drawn, on: str) -> Table:
    orders = draw.pick([[1], [1, 2], [0.5, 1]])
    rows = [{"order": n, "amplitude": draw.said(draw.size(10.0, 1000.0), "force")} for n in orders]
    rows[-1] |= draw.pick([{}, {"phase": "30 deg"}])
    return {**_steady(draw, made), **_way(draw, made, on), "harmonics": rows}


def _moment_harmonics(draw: Draw, made: Drawn, on: str) -> Table:
    rows = [{"order": n, "amplitude": draw.said(draw.size(5.0, 500.0), "moment")} for n in draw.pick([[2], [1, 2]])]
    return {**_steady(draw, made), "axis": draw.pick(["x", "y", "z"]), "harmonics": rows}


def _moment(draw: Draw, made: Drawn, on: str) -> Table:
    axis = {"axis": draw.pick(["x", "y", "z"])} if on in made.spatial else {}
    return {**_steady(draw, made), **axis, "amplitude": draw.said(draw.size(1.0, 300.0), "moment")}


def _base_motion(draw: Draw, made: Drawn, on: str) -> Table:
    key, dimension, size = draw.pick(
        [("displacement", "length", 1e-3), ("velocity", "velocity", 0.05), ("acceleration", "acceleration", 2.0)]
    )
    way = {"direction": draw.pick(["x", "y", "z"])} if made.spatial else {}
    steady = _steady(draw, made)
    size_said = draw.said(size * draw.size(0.1, 10.0), dimension, amplitude=True)
    return {**steady, **way, **_begins(made, steady), key: size_said}


def _road(draw: Draw, made: Drawn, on: str) -> Table:
    wave = draw.size(2.0, 10.0)
    speed = 3.6 * wave * made.frequency
    ways: list[Any] = [f"{speed:.3g} km/h", f"{0.4 * speed:.3g}..{2.0 * speed:.3g} km/h"]
    says: Table = {"wavelength": f"{wave} m"}
    if draw.chance(0.3):
        says = {"wavenumber": f"{2.0 * math.pi / wave:.4g} rad/m"}
    return {"speed": draw.pick(ways), "amplitude": draw.said(draw.size(0.001, 0.05), "length"), **says}


def _white_noise(draw: Draw, made: Drawn, on: str) -> Table:
    force = on not in made.names("bases")
    unit, size = ("N²/Hz", draw.size(0.1, 100.0)) if force else ("(m/s²)²/Hz", draw.size(1e-4, 0.1))
    return {"density": f"{size} {unit}", **_along(draw, made, on)}


def _pushed(draw: Draw, made: Drawn, on: str) -> tuple[str, str]:
    """The key of a pulse, with its size."""
    if on in made.names("bases"):
        return "acceleration", draw.said(draw.size(1.0, 300.0), "acceleration")
    return "amplitude", draw.said(draw.size(10.0, 5000.0), "force")


def _pulse(draw: Draw, made: Drawn, on: str) -> Table:
    key, size = _pushed(draw, made, on)
    way, period = _along(draw, made, on), 1.0 / made.frequency
    shape = draw.pick(list(get_args(Shape)))
    if key == "acceleration" and shape in SMOOTH and (other := aside({shape: size})).chance(0.4):
        key, size = "displacement", other.said(other.size(1e-4, 0.1), "length")
    if shape == "decaying sine":
        return {
            "shape": shape,
            key: size,
            "frequency": f"{made.frequency:.3g} Hz",
            "damping_ratio": draw.size(0.05, 0.5),
            **way,
        }
    if shape == "step":
        return {"shape": shape, key: size, **way}
    duration = period * draw.size(0.05, 3.0)
    again = {"times": 3, "every": f"{duration * draw.size(1.0, 3.0):.4g} s"} if draw.chance(0.2) else {}
    return {"shape": shape, key: size, "duration": f"{duration:.4g} s", **again, **way}


def _drop(draw: Draw, made: Drawn, on: str) -> Table:
    rebound = {"rebound": draw.size(0.1, 0.9)} if draw.chance(0.5) else {}
    way = _along(draw, made, on) if made.spatial else {}
    return {"height": draw.said(draw.size(0.01, 1.0), "length"), **rebound, **way}


def _release(draw: Draw, made: Drawn, on: str) -> Table:
    away = {"displacement": draw.said(draw.size(1e-4, 0.05) * draw.pick([-1, 1]), "length")}
    fast = {"velocity": draw.said(draw.size(1e-3, 1.0) * draw.pick([-1, 1]), "velocity")}
    way = {"direction": draw.pick(["x", "y", "z"])} if on in made.spatial else {}
    return {**draw.pick([away, fast, {**away, **fast}]), **way}


def _record(draw: Draw, made: Drawn, on: str) -> Table:
    unit = draw.pick(["m/s²", "g"]) if on in made.names("bases") else "N"
    step = 0.2 / made.frequency
    rows = "".join(f"{index * step:.6g};{draw.size(0.1, 50.0) * draw.pick([-1, 1]):.4g}\n" for index in range(8))
    made.files[f"record_{on}.csv"] = f"time [s];shake [{unit}]\n{rows}".encode()
    return {"file": f"record_{on}.csv", **_along(draw, made, on)}


RECIPES: dict[str, Callable[[Draw, Drawn, str], Table]] = {
    "force": _force,
    "unbalance": _unbalance,
    "harmonics": _harmonics,
    "moment": _moment,
    "moment_harmonics": _moment_harmonics,
    "base_motion": _base_motion,
    "road": _road,
    "white_noise": _white_noise,
    "pulse": _pulse,
    "drop": _drop,
    "release": _release,
    "record": _record,
}
