"""Tolerances that a scene cannot follow up are refused, never passed over."""

from __future__ import annotations

from vibopt.devices import FAMILIES
from vibopt.document.mistakes import Mistakes
from vibopt.scene.places import devices
from vibopt.scene.scene import Scene
from vibopt.scene.uncertain import uncertain


def check_tolerances(scene: Scene, mistakes: Mistakes) -> None:
    """Every tolerance of a table acts on something, and every one is on a device that can be built with it."""
    for family, name, table in devices(scene):
        if getattr(table, "tolerance", None) and not table.parts():
            mistakes.add(
                (family, name, "tolerance"),
                f"{family}.{name} has a tolerance, but gives no mass, stiffness or damping of its own that could be "
                "off. Remove the tolerance.",
            )
    doubts = uncertain(scene)
    for name, mount in scene.mounts.items():
        if mount.tolerance_of is not None and not any(one.path.startswith(f"mounts.{name}.") for one in doubts):
            mistakes.add(
                ("mounts", name, "tolerance_of"),
                f'mounts.{name} has tolerance_of, but nothing of it has a tolerance. Add tolerance = "20 %", or remove '
                "tolerance_of.",
            )
    for doubt in doubts:
        family, name, *steps = doubt.path.split(".")
        if not FAMILIES[family].may_be_off:
            mistakes.add(
                (family, name, *steps),
                f"{doubt.path} has a tolerance, which only bodies, links, absorbers and mounts can have so far. "
                "Remove it.",
            )
