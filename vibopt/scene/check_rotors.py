"""What rotors are asked, and by what they are driven: a whirl with the spin, alike in both planes."""

from __future__ import annotations

import numpy as np

from vibopt.document.mistakes import Mistakes, Path, dotted
from vibopt.responses import Response
from vibopt.scene import places
from vibopt.scene.assemble import model_of
from vibopt.scene.check_bearings import holding_rows, planes_fault
from vibopt.scene.drives import looked_at
from vibopt.scene.scene import Scene
from vibopt.signals import Band
from vibopt.units import show
from vibopt.values.fields import Choice

_BESIDE = {
    "structures": "a structure moves along one line. Model it as bodies that are alike in both planes",
    "mounts": "a mount in space is not alike in both planes. Write a link of the stiffness that it has in each",
    "absorbers": "an absorber is tuned to frequencies that change with the speed. Write it as a body and a link",
}
"""Families that no rotor stands beside, and why."""
_STOUT, _MANY = 100, 100
"""Times its length beyond which no shaft is thick; half waves of one span that are the most."""


def check_rotors(scene: Scene, mistakes: Mistakes) -> None:
    """Add what is wrong around rotors, of which there is one."""
    name = next(iter(scene.rotors))
    for family, why in _BESIDE.items():
        for other in places.raw(scene, family):
            mistakes.add((family, other), f"{family}.{other} stands beside rotors.{name}, and {why}.")
    for other, body in scene.bodies.items():
        if body.freedoms or body.turns:
            mistakes.add(
                ("bodies", other),
                f"bodies.{other} turns or moves in space, beside rotors.{name}, whose whirl is a displacement alike in "
                "both planes. Give it a mass that moves along a line.",
            )
    for other in places.rubbing(scene):
        mistakes.add(
            ("links", other),
            f"links.{other} rubs, beside rotors.{name}. Friction in a whirl goes round with it and is no linear force: "
            "write it as damping.",
        )
    for other, link in scene.links.items():
        if link.spreads_mass:
            mistakes.add(
                ("links", other, "beam"),
                f"links.{other} has a beam with a mass, beside rotors.{name}. Write the shaft as sections of a rotor, "
                "or leave the mass of the beam out.",
            )
    _driven(scene, name, mistakes)
    if not mistakes.found and places.is_whole(scene):
        _sizes(scene, mistakes)
    if not mistakes.found and places.is_whole(scene):
        _held(scene, mistakes)


def _sizes(scene: Scene, mistakes: Mistakes) -> None:
    """Sizes of which no shaft is made, as by a slip in a unit."""
    top, _ = looked_at(scene)
    for name, table in scene.rotors.items():
        where, long = ("rotors", name, "sections"), sum(section.lengths[2] for section in table.sections)
        for i, section in enumerate(table.sections):
            wide = section.diameter.low if isinstance(section.diameter, Choice) else section.diameter.value
            if wide > _STOUT * long:
                mistakes.add(
                    where,
                    f"rotors.{name}.sections[{i + 1}] is {show(wide, 'm', 'length')} wide on a shaft of "
                    f"{show(long, 'm', 'length')}: no shaft is more than {_STOUT} times as thick as it is long. Check "
                    "the units.",
                )
        if table.half_waves(top) > _MANY:
            speed = show(top, "rpm", "angular_rate")
            mistakes.add(
                where,
                f"rotors.{name} is so slender that more than {_MANY} half waves stand on one of its spans at {speed}. "
                "Check the units, write a thicker shaft, or ask for lower speeds.",
            )


def _driven(scene: Scene, name: str, mistakes: Mistakes) -> None:
    speeds: dict[tuple[Band, ...], str] = {}
    for key, shaker in scene.excitations.items():
        path = ("excitations", key)
        if shaker.kind != "unbalance":
            mistakes.add(
                path,
                f'excitations.{key} is of kind "{shaker.kind}", beside rotors.{name}. What is answered is the whirl '
                'with the spin, which an unbalance alone drives. Write kind = "unbalance".',
            )
            continue
        if shaker.ramp is not None and shaker.ramp.torque is not None:
            mistakes.add(
                (*path, "run_up"),
                f"excitations.{key} runs up by torque, beside rotors.{name}, of which it is not known what its whirl "
                'takes of that. Write the acceleration that the motor reaches: run_up = { acceleration = "50 rpm/s" }.',
            )
        if shaker.speed.highest == float("inf"):
            mistakes.add((*path, "speed"), f'excitations.{key}.speed has no upper end. Write one: "0..12000 rpm".')
        speeds.setdefault(shaker.own_bands(), key)
    if len(speeds) > 1:
        first, second, *_ = speeds.values()
        mistakes.add(
            ("excitations", second, "speed"),
            f"excitations.{second}.speed differs from that of excitations.{first}, but a rotor spins at one speed. "
            "Write the same for both.",
        )


def _held(scene: Scene, mistakes: Mistakes) -> None:
    """Whether springs hold every rotor against moving along and against tilting."""
    model = model_of(scene)
    lefts = []
    for rows in holding_rows(model):
        sizes = np.linalg.norm(rows, axis=1, keepdims=True)
        lefts.append(model.n_free - int(np.linalg.matrix_rank(rows / sizes, tol=1e-9)))
    if not any(lefts):
        return
    free = [name for name, table in scene.rotors.items() if len(_springs(scene, table.names)) < 2] or [*scene.rotors]
    plane = "" if all(lefts) else f" in the plane {'y' if lefts[0] else 'z'}"
    mistakes.add(
        ("rotors", free[0]),
        f"rotors.{free[0]} is not held: springs at its stations leave it free to move or to tilt{plane}. Let links or "
        "bearings with a stiffness end at two of its stations, and lead to the ground.",
    )


def _springs(scene: Scene, points: list[str]) -> list[str]:
    """Points at which a spring ends."""
    ends = [places.ends(scene)[name] for name in places.springs(scene)]
    return [point for point in points if any(point in two for two in ends)]


def whirl_fault(scene: Scene, path: Path, response: Response, mistakes: Mistakes) -> bool:
    """Whether a response asks of a rotor what changes with its speed, or what it has no number for; adds it."""
    key, where = response.response, dotted(path)
    if not scene.rotors:
        turns = next((body for body, body_table in scene.bodies.items() if body_table.turns), "")
        if response.whirls and turns and not response.free_vibration:
            mistakes.add(
                path,
                f"{where} asks for the critical_speed, at which a shaft that bends whirls, and bodies.{turns} turns "
                'about its axis. Write response = "natural_frequency", with outside = { orders = [1, 2], '
                'of = "engine", margin = "15 %" } for the orders of what shakes it.',
            )
            return True
        asks = response.spins or (response.whirls and response.free_vibration)
        if not asks or places.raw(scene, "rotors"):
            return False
        mistakes.add(
            path,
            f"{where} asks for free whirls at a spin, and there is no rotor. Leave at, over, up_to, whirl and "
            "damped out, or write [rotors.NAME].",
        )
        return True
    name = next(iter(scene.rotors))
    if planes_fault(scene, path, response, mistakes):
        return True
    rotor = str(getattr(response, "of", "")) if response.of_rotor else ""
    if rotor in scene.rotors and scene.rotors[rotor].matrices is not None:
        mistakes.add(
            path,
            f"{where} asks for the {key} of rotors.{rotor}, whose matrices do not say how thick it is. Write its "
            "sections instead of the matrices, or ask for the displacement.",
        )
        return True
    if (
        response.modes
        and not response.whirls
        and response.response != "stability_threshold"
        and getattr(response, "of", None) not in places.links(scene)
    ):
        mistakes.add(
            path,
            f"{where} asks for the {key}, but the modes of rotors.{name} change with its speed. Write "
            + (
                'at = "3000 rpm" and up_to = "6000 rpm".'
                if "up_to" in type(response).model_fields
                else 'response = "critical_speed".'
            ),
        )
        return True
    from vibopt.mechanics.shaft_waves import MODES  # of rotors alone

    if response.whirls and response.modes > MODES:
        mistakes.value(
            (*path, "mode"),
            response.modes,
            f"is beyond the {MODES} lowest critical speeds, up to which whirls are told. Write one from 1 to {MODES}.",
        )
        return True
    return False
