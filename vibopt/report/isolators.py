"""What everybody asks of an isolator: natural frequency, damping, static deflection, isolation; and of the machine its
modes.  All is asked in the language of files: what that refuses has no single meaning here, and is left out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from math import isfinite
from typing import TYPE_CHECKING

import numpy as np

from vibopt.answer.blocks import Block, at_words, table
from vibopt.answer.entry import Checked, Entry
from vibopt.document.mistakes import Mistakes
from vibopt.mechanics.built import GROUND, Joint
from vibopt.mechanics.machine import Machine, is_in_space
from vibopt.records import dataclass
from vibopt.report.mode_shapes import Shape, shapes_of
from vibopt.responses import KINDS
from vibopt.scene.check_scene import check_response
from vibopt.scene.places import turning
from vibopt.scene.scene import Design, Scene
from vibopt.units import plain, show
from vibopt.values.directions import AXES
from vibopt.verify.checked import measured_row

if TYPE_CHECKING:
    from vibopt.excitations.excitation import Excitation
    from vibopt.responses import Response

MOST_MODES = 8
TITLE, MODES = "Springs and mounts", "Natural frequencies"


@dataclass(frozen=True, slots=True)
class Isolator:
    """All springs and dampers between the same two points, or the mounts of a group.

    mode
        Number of the mode in which it is strained most, and the part of that mode's strain energy in it; None of a
        machine in space or with a structure, where it governs several.
    sag
        Static deflection; None where no weight acts along it.
    isolation
        By what shakes.
    """

    name: str
    ends: tuple[str, str]
    mode: tuple[int, float] | None
    shape: Shape | None
    sag: Checked | None
    isolation: Mapping[str, Checked]


def blocks_of(design: Design, machine: Machine | None) -> list[Block]:
    """Isolators, and the modes of a machine that has more than one."""
    if machine is None:
        return []
    shapes = _shapes(design, machine)
    block = isolator_block(design, machine)
    return [block, mode_block(design, shapes if len(shapes) > 1 or not block.rows else [])]


def isolator_block(design: Design, machine: Machine) -> Block:
    """One row an isolator, and one more for each further excitation."""
    shapes, scene = _shapes(design, machine), design.scene
    found = isolators_of(scene, machine, shapes)
    rows = [row for isolator in found for row in _rows(isolator, found, several=len(shapes) > 1)]
    worst = "Static sag,\nworst mount"
    asked = any(
        response.response == "static_deflection" for response in (*scene.limits.values(), *scene.measures.values())
    )
    sag = worst if machine.in_space else "Static sag" if asked else "Static sag\nif vertical"
    heads = ("", "Strained\nin mode", "Natural\nfrequency", "Damping\nratio", sag, "Isolation")
    shown = [row for row in rows if any(row[1:])]
    return table(f"{TITLE}{_without(design)}", heads, shown, whole=range(len(heads) - 1))


def _shapes(design: Design, machine: Machine) -> list[Shape]:
    """Modes with their shapes; none with structures, of which they are many."""
    return [] if machine.on_structures else shapes_of(machine, sorted(turning(design.scene)))


def _without(design: Design) -> str:
    return ", without tolerances" if design.tolerances is not None else ""


def mode_block(design: Design, shapes: list[Shape]) -> Block:
    """The first modes with their shapes in words."""
    rows = [
        (
            plain(number),
            Entry(shape.frequency, "angular_rate", "Hz"),
            Entry(shape.damping, "ratio", digits=3) if shape.damping is not None else "",
            shape.words if shape.frequency > 0.0 else f"{shape.words}: free, nothing holds it",
        )
        for number, shape in enumerate(shapes[:MOST_MODES], start=1)
    ]
    more = len(shapes) - MOST_MODES
    title = f"{MODES}{_without(design)}{f' (the first {MOST_MODES} of {len(shapes)})' if more > 0 else ''}"
    return table(title, ("Mode", "Frequency", "Damping\nratio", "Share of kinetic energy"), rows, whole=(0, 1, 2))


def _rows(isolator: Isolator, every: list[Isolator], *, several: bool) -> Iterator[tuple[str | Entry, ...]]:
    """A row, and one more for each further excitation."""
    alone = [_support(other.ends) for other in every].count(_support(isolator.ends)) == 1
    said = [
        f"{'' if len(isolator.isolation) == 1 and 'along ' not in name else f'{name}: '}{isolation_words(row)}"
        f"{'' if alone else f', all into {_support(isolator.ends)}'}"
        for name, row in isolator.isolation.items()
    ]
    first = (
        isolator.name,
        f"{isolator.mode[0]} ({plain(100.0 * isolator.mode[1], 2)} %)" if isolator.mode is not None and several else "",
        Entry(isolator.shape.frequency, "angular_rate", "Hz") if isolator.shape is not None else "",
        Entry(isolator.shape.damping, "ratio", digits=3)
        if isolator.shape is not None and isolator.shape.damping
        else "",
        isolator.sag.value if isolator.sag is not None and isfinite(isolator.sag.value.value) else "",
    )
    yield (*first, said[0] if said else "")
    yield from (("", "", "", "", "", more) for more in said[1:])


def isolation_words(row: Checked) -> str:
    """ "82.4 % at 1450 rpm"; where more comes through than goes in, how many times as much."""
    at = f" at {at_words(row.worst_at)}" if row.worst_at else ""
    if row.value.value >= 0.0:
        return f"{show(row.value.value, '%', 'ratio')}{at}"
    if not isfinite(row.value.value):
        return f"none: resonance{at}"
    return f"none: {show(1.0 - row.value.value, '', 'ratio')} times{at}"


def isolators_of(scene: Scene, machine: Machine, shapes: list[Shape] | None = None) -> list[Isolator]:
    """Everything that is held by springs between two points, in the order of the file; absorbers are none."""
    told = shapes_of(machine) if shapes is None else shapes
    found, borne = [], {place for rotor in scene.rotors.values() for place in rotor.names}
    for ends, names in _groups(machine):
        if borne & {*ends}:  # a bearing carries a shaft, and isolates nothing
            continue
        joints = [joint for joint in machine.joints if joint.name in names]
        mode = None if machine.in_space or machine.on_structures else _mode(machine, joints)
        found.append(
            Isolator(
                name=" and ".join(names),
                ends=ends,
                mode=mode,
                shape=told[mode[0] - 1] if mode is not None else None,
                sag=_sag(scene, machine, names),
                isolation=dict((_in_space if machine.in_space else _along)(scene, machine, ends)),
            )
        )
    return found


def _groups(machine: Machine) -> list[tuple[tuple[str, str], list[str]]]:
    """Two ends and the names of what is between them, where that is a spring; mounts in space by group."""
    names: dict[tuple[str, str], list[str]] = {}
    held: set[tuple[str, str]] = set()
    for joint in machine.joints:
        if joint.name not in machine.tuned:
            ends = joint.ends[::-1] if joint.ends[::-1] in names else joint.ends
            names.setdefault(ends, []).append(joint.name)
            held |= {ends} if joint.stiffness > 0.0 else set()
    found = [(ends, some) for ends, some in names.items() if ends in held]
    if is_in_space(machine):
        found += [(machine.mount(singles[0]).ends, [group]) for group, singles in machine.groups.items()]
    return found


def _mode(machine: Machine, joints: list[Joint]) -> tuple[int, float] | None:
    """The mode in which these springs have the greatest part of the strain energy, and that part."""
    omega, modes = machine.mode_shapes()
    rows = {name: machine.row(name) @ modes for name in machine.masses}
    still = np.zeros(len(omega))
    apart = [rows.get(joint.ends[1], still) - rows.get(joint.ends[0], still) for joint in joints]
    energy = np.sum([joint.stiffness * stretch**2 for joint, stretch in zip(joints, apart, strict=True)], axis=0)
    share = np.divide(energy, omega**2, out=np.zeros(len(omega)), where=omega > 0.0)
    best = int(np.argmax(share))
    return (best + 1, float(min(share[best], 1.0))) if share[best] > 0.0 else None


def _support(ends: tuple[str, str]) -> str:
    return GROUND if GROUND in ends else ends[1]


def _sag(scene: Scene, machine: Machine, names: list[str]) -> Checked | None:
    """Of the group the greatest; of a machine that is not held none."""
    found = [row for name in names if (row := asked(scene, machine, "static_deflection", of=name)) is not None]
    return max(found, key=lambda row: row.value.value, default=None)


def _along(scene: Scene, machine: Machine, ends: tuple[str, str]) -> Iterator[tuple[str, Checked]]:
    """Into a support of what shakes a body, and of a body from the base that shakes; at own speeds the least."""
    for name, excitation in scene.excitations.items():
        if excitation.sort != "steady":
            continue
        for here, there in (ends, ends[::-1]):
            words = {"of": here} if there == excitation.on else {"into": there}
            held = there == GROUND or there in scene.bases
            row = asked(scene, machine, "isolation", **words, due_to=[name]) if held else None
            if row is not None:
                yield name, row


def _in_space(scene: Scene, machine: Machine, ends: tuple[str, str]) -> Iterator[tuple[str, Checked]]:
    """As along a line, way by way: of the force that comes through most, or of the body's motion beside its base's."""
    for name, excitation in scene.excitations.items():
        lines = excitation.lines(np.ones(1)) if excitation.sort == "steady" else ()
        for here, there in (ends, ends[::-1]) if len(lines) == 1 else ():
            held, moved = there == GROUND or there in scene.bases, there == excitation.on
            if not held or excitation.family != ("bases" if moved else "bodies"):
                continue
            for said, way, share in _ways(excitation):
                kind, words = ("displacement", {"of": here}) if moved else ("transmitted_force", {"into": there})
                row = asked(scene, machine, kind, **words, direction=way, due_to=[name])
                if row is None or name not in row.worst_at:
                    continue
                whole = share * float(np.abs(lines[0].amplitude.at(np.array([row.worst_at[name].value])))[0])
                if whole > 0.0:
                    key = f"{name} {said}" if len(scene.excitations) > 1 else said
                    yield key, replace(row, value=Entry(1.0 - row.value.value / whole, "ratio"))


def _ways(excitation: Excitation) -> Iterator[tuple[str, list[float], float]]:
    """Directions in which it acts, in words and as numbers, and its amplitude along each as a part of the whole."""
    acts = {key.rpartition(".")[2]: part for key, part in excitation.acts.items()} if excitation.direction_known else {}
    if getattr(excitation, "direction", None) is not None and len(acts) > 1:
        yield "along its direction", [acts.get(axis, 0j).real for axis in AXES], 1.0
        return
    for number, axis in enumerate(AXES):
        if axis in acts:
            yield f"along {axis}", [float(number == other) for other in range(len(AXES))], abs(acts[axis])


def asked(scene: Scene, machine: Machine, kind: str, **words: object) -> Checked | None:
    """A response as a measure of a file would ask for it; None where a file with it would be refused."""
    from pydantic import ValidationError

    try:
        response: Response = KINDS[kind].model_validate({"response": kind, **words})
    except ValidationError:
        return None
    mistakes = Mistakes(scene.name)
    check_response(scene, ("measures", "asked"), response, mistakes, set())
    if mistakes.found:
        return None
    return measured_row(scene, machine, "asked", response)
