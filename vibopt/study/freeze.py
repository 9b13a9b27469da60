"""A design that is bought: its values become facts of the scene."""

from __future__ import annotations

import copy
from collections.abc import Sequence

from vibopt.scene.read import from_dict
from vibopt.scene.scene import Scene
from vibopt.units import to_unit


def frozen(scene: Scene, x: Sequence[float]) -> Scene:
    """The scene with every choice replaced by its value [SI], as an analysis.

    Parameters
    ----------
    scene
        A scene with design variables.
    x
        Their values, in the order of `scene.variables`.
    """
    document = copy.deepcopy(dict(scene.document))
    for variable, value in zip(scene.variables, x, strict=True):
        family, name, key = variable.path.split(".", 2)
        unit = variable.unit
        document[family][name][key] = (
            f"{to_unit(value, unit, variable.dimension):.17g} {unit}" if unit else float(value)
        )
    document.pop("goal", None)
    return from_dict(document, name=scene.name)
