"""What a scene takes for granted about its absorbers, said in every answer."""

from __future__ import annotations

from vibopt.scene.assemble import reference
from vibopt.scene.scene import Scene
from vibopt.units import show

_COUNTED = ("first", "second", "third", "fourth", "fifth")


def tuning_notes(scene: Scene) -> list[str]:
    """What each tuning refers to."""
    return [_note(scene, name) for name, one in scene.absorbers.items() if one.tuning is not None]


def _note(scene: Scene, name: str) -> str:
    table = scene.absorbers[name]
    said = f"absorbers.{name}: tuning refers to"
    if table.tuning_to is not None:
        return f"{said} {show(table.tuning_to.value, table.tuning_to.unit, 'angular_rate')}"
    mode = table.mode or 1
    which = _COUNTED[mode - 1] if mode <= len(_COUNTED) else f"{mode}th"
    found = reference(scene, name)
    if found.exponents:
        return f"{said} the natural frequency without absorbers, which is chosen too"
    return f"{said} the {which} natural frequency without absorbers, {show(found.scale, 'Hz', 'angular_rate')}"
