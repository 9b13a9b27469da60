"""A design that is bought: its values become facts of the scene."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from vibopt.design.build import machine_of
from vibopt.scene.document import changed
from vibopt.scene.places import turning
from vibopt.scene.read import from_dict
from vibopt.scene.scene import Scene
from vibopt.units import to_unit

_ALONG = (("mass", "kg"), ("stiffness", "N/m"), ("damping", "N s/m"))
_AROUND = (("inertia", "kg m2"), ("torsional_stiffness", "N m/rad"), ("torsional_damping", "N m s/rad"))


def frozen(scene: Scene, x: Sequence[float]) -> Scene:
    """The scene with every choice replaced by its value [SI], as an analysis.

    Parameters
    ----------
    scene
        A scene with design variables.
    x
        Their values, in the order of `scene.variables`.
    """
    values = {}
    for variable, value in zip(scene.variables, x, strict=True):
        unit = variable.unit
        values[variable.path] = f"{to_unit(value, unit, variable.dimension):.17g} {unit}" if unit else float(value)
    document = changed(scene.document, values)
    if scene.absorbers:
        document["absorbers"] = _bought(scene, x)
    document.pop("goal", None)
    return from_dict(document, name=scene.name)


def _bought(scene: Scene, x: Sequence[float]) -> dict[str, dict[str, Any]]:
    """Absorbers as parts: what was said relative to the machine is a mass, a spring and a damper now."""
    machine = machine_of(scene, {one.path: float(value) for one, value in zip(scene.variables, x, strict=True)})
    around = turning(scene)
    tables = {}
    for name, table in scene.absorbers.items():
        units = _AROUND if name in around else _ALONG
        joint = machine.joint(name)
        kept = {key: scene.document["absorbers"][name].get(key) for key in ("on", "relative_to", "tuning_to", "mode")}
        parts = (machine.masses[name], joint.stiffness, joint.damping)
        given = {key: f"{value:.17g} {unit}" for (key, unit), value in zip(units, parts, strict=True) if value > 0.0}
        if table.loss_factor is not None:
            given["loss_factor"] = f"{joint.loss_factor:.17g}"
        tables[name] = {**{key: value for key, value in kept.items() if value is not None}, **given}
    return tables
