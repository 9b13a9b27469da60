"""What an answer takes for granted, said aloud."""

from __future__ import annotations

from collections.abc import Mapping

from vibopt.design.build import machine_of
from vibopt.scene.scene import Scene


def notes_of(scene: Scene, chosen: Mapping[str, float]) -> tuple[str, ...]:
    """What to know beside the answer: the scene's own notes, amplitudes taken as constant, soft floors."""
    notes = list(scene.notes)
    for name, excitation in scene.excitations.items():
        if excitation.variation is None and not excitation.inherent and not excitation.speed.is_one_speed:
            notes.append(f"excitations.{name}: the amplitude is taken as the same at each of its own speeds.")
    notes += soft_floor(scene, chosen)
    return tuple(notes)


def soft_floor(scene: Scene, chosen: Mapping[str, float]) -> list[str]:
    """A warning for every mount that stands on a body held less than ten times as stiffly."""
    machine = machine_of(scene, chosen)
    notes = []
    for mount in machine.joints:
        floor = mount.ends[1]
        if mount.stiffness == 0.0 or floor not in machine.masses or mount.ends[0] not in machine.masses:
            continue
        under = sum(one.stiffness for one in machine.joints if floor in one.ends and one is not mount)
        if 0.0 < under < 10.0 * mount.stiffness:
            notes.append(
                f"{floor} is held only {under / mount.stiffness:.2g} times as stiffly as {mount.name}: "
                "it moves too, and the answer counts with it; on a rigid floor it would be another."
            )
    return notes
