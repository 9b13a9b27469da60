"""Tolerances that a scene cannot follow up are refused, never passed over."""

from __future__ import annotations

from vibopt.scene.mistakes import Mistakes
from vibopt.scene.places import devices
from vibopt.scene.scene import Scene
from vibopt.scene.uncertain import uncertain

_KNOWN = ("bodies", "links", "absorbers")


def check_tolerances(scene: Scene, mistakes: Mistakes) -> None:
    """Every tolerance of a table acts on something, and every one is on a device that can be built with it."""
    for family, name, table in devices(scene):
        if getattr(table, "tolerance", None) and not table.parts():
            mistakes.add(
                (family, name, "tolerance"),
                f"{family}.{name} has a tolerance, but gives no mass, stiffness or damping of its own that could be "
                "off. Remove the tolerance.",
            )
    for doubt in uncertain(scene):
        family, name, *steps = doubt.path.split(".")
        spatial = family == "bodies" and bool(scene.bodies[name].freedoms)
        if family not in _KNOWN or spatial:
            mistakes.add(
                (family, name, *steps),
                f"{doubt.path} has a tolerance, which only bodies along a line or about an axis, links and absorbers "
                "can have so far. Remove it.",
            )
