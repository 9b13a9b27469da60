"""A design that is bought: its values become facts of the scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from vibopt.answer.entry import Entry
from vibopt.arrays import FloatArray
from vibopt.document.toml_reading import changed
from vibopt.scene.places import bound_parts, turning
from vibopt.scene.read import from_dict
from vibopt.scene.scene import Scene
from vibopt.scene.uncertain import uncertain
from vibopt.units import to_unit
from vibopt.values.tolerance import read_tolerance, span, written
from vibopt.verify.as_built import machine_of
from vibopt.verify.measured_goal import measure_goal

_MASSES = ("mass", "inertia", "mass_ratio", "disc")
_SPRINGS = ("stiffness", "torsional_stiffness", "shaft", "frequency", "tuning", "length")
_DAMPERS = ("damping", "torsional_damping", "damping_ratio", "loss_factor")
_POWERS = {"frequency": 2, "tuning": 2, "length": -1, "shaft.diameter": 4, "shaft.length": -1}
"""With which power of a number its part goes; 1 where none is given."""
_KEPT = ("on", "at", "direction", "relative_to", "tuning_to", "mode")
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
        joint = machine.joint(name)
        kept = {key: scene.document["absorbers"][name].get(key) for key in _KEPT}
        parts = (machine.masses[name], joint.stiffness, joint.damping)
        given: dict[str, Any] = {
            key: f"{float(value)!r} {unit}" for (key, unit), value in zip(units, parts, strict=True) if value > 0.0
        }
        doubts = {one.path for one in uncertain(scene)}
        if table.length is not None and not doubts & {f"absorbers.{name}.{key}" for key in ("stiffness", "length")}:
            given = {"length" if key == "stiffness" else key: one for key, one in given.items()}
            given["length"] = written[name]["length"]
        if table.loss_factor is not None:
            given["loss_factor"] = f"{joint.loss_factor:.17g}"
        _keep_tolerances(scene, name, given)
        tables[name] = {**{key: value for key, value in kept.items() if value is not None}, **given}
    return tables


def _keep_tolerances(scene: Scene, name: str, given: dict[str, Any]) -> None:
    """Tolerances of an absorber's numbers, put on the parts that they became."""
    kinds = (_MASSES, _SPRINGS, _DAMPERS)
    for doubt in uncertain(scene):
        family, owner, word = doubt.path.split(".")[:3]
        if (family, owner) != ("absorbers", name):
            continue
        power = _POWERS.get(doubt.path.split(".", 2)[2], 1)
        key = next((key for key in given if any(word in kind and key in kind for kind in kinds)), None)
        if key is None:
            continue
        had = read_tolerance(given[key]["tolerance"]) if isinstance(given[key], dict) else 0.0
        value = given[key]["value"] if isinstance(given[key], dict) else given[key]
        alone = power == 1 and not had  # a distribution goes on only where nothing is combined with it
        wide = written(doubt.tolerance) if alone else _farthest(had, doubt.tolerance, power)
        given[key] = {"value": value, "tolerance": wide}


def _farthest(had: float, tolerance: float, power: int) -> float:
    """How far a part is off at most, by its own tolerance and by one of a number that it goes with a power of."""
    factors = [own * off**power for own in span(had) for off in span(tolerance)]
    return float(max(abs(value - 1.0) for value in factors))
