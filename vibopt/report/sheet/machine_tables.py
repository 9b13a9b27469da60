"""The machine on the sheet: bodies with mass, centre and inertia, and what shakes them, in words."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from vibopt.answer.answer_page import given
from vibopt.arrays import FloatArray
from vibopt.errors import counted
from vibopt.mechanics.machine import Machine
from vibopt.mechanics.rigid import SpaceMachine
from vibopt.mechanics.rigid_parts import Rigid
from vibopt.report.sheet.mount_plan import said
from vibopt.scene.places import joints, turning
from vibopt.scene.scene import Scene
from vibopt.units import plain, show

if TYPE_CHECKING:
    from vibopt.devices.structure import StructureTable

_MOTIONS = {6: "in space", 3: "in the plane x-z"}
_SAID_FIRST = ("kind", "on", "direction", "axis", "at", "speed", "varies", "amplitude_at")


def body_rows(scene: Scene, machine: Machine | None) -> list[tuple[str, str]]:
    """Name and words of every body; as the file says it where there is no design."""
    if machine is None:
        tables = given({"bodies": scene.document.get("bodies", {})})
        return [(name.partition(".")[2], "; ".join(" ".join(row) for row in rows)) for name, rows in tables]
    if not isinstance(machine, SpaceMachine):
        around = turning(scene)
        rows = [(name, _on_a_line(scene, machine, name, name in around)) for name in scene.bodies]
        return rows + [(name, _structure(structure)) for name, structure in scene.structures.items()]
    rows = [(name, _in_space(scene, name, body)) for name, body in machine.rigid.items()]
    return rows + [(name, f"{_mass(scene, name, machine.masses[name])}; moves up and down") for name in machine.line]


def _mass(scene: Scene, name: str, value: float) -> str:
    given = getattr(scene.bodies[name], "mass", None)
    return show(value, getattr(given, "unit", ""), "mass")


def _on_a_line(scene: Scene, machine: Machine, name: str, around: bool) -> str:
    if name in joints(scene):
        return "joint without mass; turns about its axis" if around else "joint without mass; moves along one line"
    if around:
        body = scene.bodies[name]
        geared = f", geared to {body.geared_to}" if body.geared_to is not None else ""
        ratio = f", {plain(body.speed_ratio.value)} times as fast" if body.speed_ratio is not None else ""
        return f"inertia {show(machine.masses[name], '', 'inertia')}; turns about its axis{geared}{ratio}"
    beams = machine.carried.get(name, 0.0)  # the body weighs what the file says of it
    mass = machine.own(name) if beams else machine.weights.get(name, machine.masses[name])
    more = f", and {_mass(scene, name, beams)} of beams that move with it" if beams else ""
    return f"{_mass(scene, name, mass)}{more}; moves along one line"


def _structure(table: StructureTable) -> str:
    """Where a structure comes from."""
    if table.modes is not None:
        modes = counted(len(table.modes), "modes")
        return f"structure of {modes} with points {', '.join(table.names)}"
    files = [str(path) for path in (table.mass, table.stiffness, table.damping, table.file) if path is not None]
    return f"structure from {', '.join(files)} with points {', '.join(table.names)}"


def _in_space(scene: Scene, name: str, body: Rigid) -> str:
    """Mass, centre, inertias about the axes through it; a body in a plane has the one about y."""
    centre = ", ".join(plain(float(one)) for one in body.centre)
    words = [_mass(scene, name, body.mass), f"centre of mass x, y, z = {centre} m", _inertias(body.tensor, body)]
    if len(body.freedoms) < 6:
        words.append(f"moves {_MOTIONS[len(body.freedoms)]}")
    return "; ".join(words)


def _inertias(tensor: FloatArray, body: Rigid) -> str:
    """Moments about the axes through the centre, and products where there are any, signed as in the file."""
    if "rx" not in body.freedoms:
        return f"inertia about y = {plain(float(tensor[1, 1]))} kg m²"
    moments = ", ".join(plain(float(tensor[k, k])) for k in range(3))
    products = {
        f"{a}{b}": -float(tensor[i, j]) for a, b, i, j in (("x", "y", 0, 1), ("y", "z", 1, 2), ("z", "x", 2, 0))
    }
    size = float(abs(tensor).max())
    told = ", ".join(f"{key} = {plain(product)}" for key, product in products.items() if abs(product) > 1e-9 * size)
    return f"inertia about x, y, z = {moments} kg m²{f', products {told} kg m²' if told else ''}"


def excitation_rows(scene: Scene) -> list[tuple[str, str]]:
    """Name and sense of everything that shakes: kind, place, direction or axis, size, speed."""
    tables = scene.document.get("excitations", {})
    return [(name, "; ".join(_excitation(tables.get(name, {})))) for name in scene.excitations]


def _excitation(table: Mapping[str, Any]) -> Iterator[str]:
    kind = str(table.get("kind", "")).replace("_", " ")
    way = f" along {said(table['direction'])}" if "direction" in table else ""
    axis = f" about {said(table['axis'])}" if "axis" in table else ""
    at = f" at {said(table['at'])}" if "at" in table else ""
    yield f"{kind} on {table.get('on', '')}{at}{way}{axis}"
    for key, value in table.items():
        if key not in _SAID_FIRST:
            yield f"{key.replace('_', ' ')} {said(value)}".replace("harmonics order", "order")
    if "speed" in table:
        yield f"at {said(table['speed'])}"
    if "varies" in table:
        given_at = f", given at {said(table['amplitude_at'])}" if "amplitude_at" in table else ""
        yield f"amplitude {_varies(table['varies'])}{given_at}"


def _varies(given: object) -> str:
    if given == "constant":
        return "the same at every speed"
    if isinstance(given, str):
        return f"grows with {given.replace('^2', ' squared')}"
    return "follows the table in the file"
