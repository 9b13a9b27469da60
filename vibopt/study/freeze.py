"""A design that is bought: its values become facts of the scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import pi, sqrt
from typing import Any

import numpy as np

from vibopt.answer.entry import Entry
from vibopt.arrays import FloatArray
from vibopt.document.toml_reading import changed
from vibopt.errors import InputError
from vibopt.scene.places import bound_parts, turning
from vibopt.scene.read import from_dict
from vibopt.scene.scene import Scene
from vibopt.units import to_unit
from vibopt.values.fields import numbers_in
from vibopt.values.tolerance import written
from vibopt.verify.as_built import machine_of
from vibopt.verify.measured_goal import measure_goal

_SAID = (
    ("mass", "mass_ratio", "inertia"),
    ("stiffness", "torsional_stiffness", "frequency", "tuning"),
    ("damping", "torsional_damping", "damping_ratio", "loss_factor"),
)
"""Ways to say the mass, the spring and the damper of an absorber, of a spring but for its length and its shaft."""
_KEPT = ("on", "at", "direction", "relative_to", "tuning_to", "mode", "tolerance")
"""Keys of an absorber that stay as the file has them."""
_ALONG = (("mass", "kg"), ("stiffness", "N/m"), ("damping", "N s/m"))
_AROUND = (("inertia", "kg m2"), ("torsional_stiffness", "N m/rad"), ("torsional_damping", "N m s/rad"))


def shown_values(scene: Scene, x: Sequence[float] | FloatArray) -> dict[str, Entry]:
    """The values of its variables in the units of the file, in their order, by path."""
    pairs = zip(scene.variables, x, strict=True)
    return {variable.path: Entry(float(value), variable.dimension, variable.unit) for variable, value in pairs}


def frozen(scene: Scene, x: Sequence[float], *, with_goal: bool = True) -> Scene:
    """The scene with every choice replaced by its value [SI], as an analysis.

    Parameters
    ----------
    scene
        A scene with design variables.
    x
        Their values, in the order of `scene.variables`.
    with_goal
        Whether the goal stays, as a measure called `minimised` or `maximised`.
    """
    values: dict[str, Any] = {}
    chosen = scene.named(x)
    tied = set()
    for part in bound_parts(scene):
        values[f"{part.path}.name"] = part.names[part.chosen(chosen)]
        tied |= set(part.paths)
    for variable, value in zip(scene.variables, x, strict=True):
        if variable.path in tied:
            continue
        unit = variable.unit
        said = _said(value, unit, variable.dimension)
        off = variable.choice.tolerance
        values[variable.path] = {"value": said, "tolerance": written(off)} if off else said
    document = changed(scene.document, values)
    for part in bound_parts(scene):
        family, name = part.path.split(".")[:2]
        document[family][name]["part"].pop("only", None)
    if scene.absorbers:
        document["absorbers"] = _bought(scene, x, document["absorbers"])
    if with_goal:
        measure_goal(scene, document)
    document.pop("goal", None)
    document.pop("expected", None)
    return from_dict(document, name=scene.name)


def bought(kept: Scene, scene: Scene) -> Scene:
    """A design with what was chosen by a ratio as it is built: dampers of links, and inerters.

    On another mass, or beside another spring, they stay what they are.  Where a limit asks for the ratio of a link
    among several bodies, which only a ratio says, it stays one.

    Parameters
    ----------
    kept
        What was chosen as facts.
    scene
        What it was chosen from.
    """
    free = {variable.path for variable in scene.variables}
    made = {
        (family, name): ratios
        for family in ("links", "inerters")
        for name in getattr(kept, family)
        if (ratios := [key for key in _RATIOS if f"{family}.{name}.{key}" in free])
    }
    if not made:
        return kept
    machine: Any = machine_of(kept, {})
    document = dict(kept.document)
    for (family, name), ratios in made.items():
        table = getattr(kept, family)[name]
        line = family == "links" or not table.placed
        joint: Any = machine.joint(name) if line else next(one for one in machine.mounts if one.name == name)
        said = dict(document[family][name])
        for key in ratios:
            word, value, unit = _part(key, table, joint)
            off = getattr(table, key).tolerance
            said.pop(key)
            said[word] = {"value": f"{value!r} {unit}", "tolerance": written(off)} if off else f"{value!r} {unit}"
        if not said.keys() & set(_RATIOS):
            said.pop("relative_to", None)
        document[family] = {**document[family], name: said}
    try:
        return from_dict(document, name=kept.name)
    except InputError:
        return kept


_RATIOS = ("damping_ratio", "rotating_damping_ratio", "mass_ratio")
"""What says a part of a link or of an inerter relative to others."""


def _part(key: str, table: Any, joint: Any) -> tuple[str, float, str]:
    """What says the same of the part alone: key, value and unit."""
    if key == "mass_ratio":
        return "inertance", float(np.sum(joint.inertance)), "kg"
    if key == "rotating_damping_ratio":
        return "rotating_damping", joint.rotating / joint.count, "N s/m"
    around = table.torsional_stiffness is not None or table.shaft is not None
    word, unit = (_AROUND if around else _ALONG)[2]
    return word, joint.damping / joint.count, unit


def _said(value: float, unit: str, dimension: str) -> str | float | int:
    """A value [SI] as it stands in a file, exact to the last digit."""
    if unit:
        return f"{float(to_unit(value, unit, dimension))!r} {unit}"
    return round(value) if dimension == "count" else float(value)


def _bought(scene: Scene, x: Sequence[float], written: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Absorbers as parts: what was said relative to the machine is a mass, a spring and a damper now.

    A pendulum keeps its length, for its own weight pulls it back; `written` are the tables with what was chosen.
    """
    machine = machine_of(scene, scene.named(x))
    around = turning(scene)
    tables = {}
    for name, table in scene.absorbers.items():
        units = _AROUND if name in around else _ALONG
        joint, mass = machine.joint(name), machine.masses[name]
        kept = {key: scene.document["absorbers"][name].get(key) for key in _KEPT}
        off = _doubts(scene, name)
        given: dict[str, Any] = {
            key: f"{float(value)!r} {unit}"
            for (key, unit), value in zip(units, (mass, joint.stiffness, joint.damping), strict=True)
            if value > 0.0
        }
        spring = _spring(written[name], off, joint.stiffness / mass)
        given = dict(spring if spring and key == units[1][0] else (key, one) for key, one in given.items())
        if table.loss_factor is not None:
            given["loss_factor"] = f"{joint.loss_factor:.17g}"
        tables[name] = {**{key: value for key, value in kept.items() if value is not None}, **_with(off, given)}
    return tables


def _doubts(scene: Scene, name: str) -> dict[str, Any]:
    """The own tolerances of an absorber's numbers, as they stand in a file, by key."""
    numbers = numbers_in("", scene.absorbers[name])
    return {path.removeprefix("."): written(one.tolerance) for path, one, _ in numbers if one.tolerance > 0.0}


def _spring(said: Mapping[str, Any], off: Mapping[str, Any], square: float) -> tuple[str, Any] | None:
    """How a spring is said where a stiffness would not be off alike; `square` is that of its own frequency [(rad/s)²].

    It goes with the square of a frequency, and with powers of the sizes of a shaft.
    """
    if "length" in said:
        return "length", said["length"]
    if any(path.startswith("shaft.") for path in off):
        return "shaft", said["shaft"]
    return ("frequency", f"{sqrt(square) / (2.0 * pi)!r} Hz") if off.keys() & {"frequency", "tuning"} else None


def _with(off: Mapping[str, Any], given: Mapping[str, Any]) -> dict[str, Any]:
    """The parts of an absorber with the tolerances of the numbers that said them."""
    found = dict(given)
    for path, tolerance in off.items():
        key = next((key for key in given for kind in _SAID if path in kind and key in kind), None)
        if key is not None and not isinstance(found[key], Mapping):
            found[key] = {"value": found[key], "tolerance": tolerance}
    return found
