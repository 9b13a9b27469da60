"""The machine as it would be built: every value of the scene with the choice put in."""

from __future__ import annotations

from collections.abc import Mapping

from vibopt.devices import LinkTable
from vibopt.mechanics.machine import Joint, Machine
from vibopt.scene.scene import Scene
from vibopt.values.fields import Choice, Fact


def machine_of(scene: Scene, chosen: Mapping[str, float]) -> Machine:
    """Bodies and links in numbers.

    Parameters
    ----------
    scene
        What is there.
    chosen
        Value of each design variable by path [SI].
    """

    def number(path: str, value: Fact | Choice | None, default: float = 0.0) -> float:
        if value is None:
            return default
        return value.value if isinstance(value, Fact) else chosen[path]

    masses = {name: number(f"bodies.{name}.mass", body.inertia) for name, body in scene.bodies.items()}
    joints = []
    for name, link in scene.links.items():
        given = {
            key: number(
                f"links.{name}.{key}", getattr(link, key), 1.0 if key in ("count", "dynamic_to_static") else 0.0
            )
            for key in ("stiffness", "damping", "damping_ratio", "loss_factor", "count", "dynamic_to_static")
        }
        joints.append(_joint(name, link, given, masses))
    return Machine(masses, tuple(joints), tuple(scene.bases))


def _joint(name: str, link: LinkTable, given: Mapping[str, float], masses: Mapping[str, float]) -> Joint:
    stiffness = given["count"] * given["stiffness"]
    damping = given["count"] * given["damping"]
    ratio = given["damping_ratio"]
    relative = link.relative_to or (next(iter(masses)) if len(masses) == 1 else None)
    if relative is not None and stiffness > 0.0:
        critical = 2.0 * float((stiffness * masses[relative]) ** 0.5)
        damping = damping or ratio * critical
        ratio = ratio or damping / critical
    return Joint(
        name=name,
        ends=link.between,
        stiffness=stiffness,
        damping=damping,
        loss_factor=given["loss_factor"],
        static_stiffness=stiffness / given["dynamic_to_static"],
        count=given["count"],
        damping_ratio=ratio,
    )
