"""Whether dry friction is asked of what can be answered: one link that rubs, beside what, and under what."""

from __future__ import annotations

import numpy as np

from vibopt.devices import FAMILIES, Device
from vibopt.devices.body import BodyTable
from vibopt.devices.link import LinkTable
from vibopt.document.mistakes import Mistakes, Path, dotted
from vibopt.mechanics.builder import GROUND
from vibopt.responses import Response, TransientResponse
from vibopt.scene import places
from vibopt.scene.scene import Scene

_BESIDE = (
    "where friction holds, what it joins moves as one, and which of several hold changes in every cycle. Dry friction "
    "is answered between one pair of ends that move along a line, beside links and absorbers that do not rub."
)
_TOGETHER = "rub between the same two ends: they slip together, and only the sum of their friction is known to act."


def check_friction(scene: Scene, mistakes: Mistakes) -> None:
    """Add what stands beside a link with dry friction and what shakes it, where that has no answer."""
    name, path = places.rubbing(scene)[0], ("links", places.rubbing(scene)[0], "friction_force")
    where, supports, together = ".".join(path), places.supports(scene), _together(scene)
    others = [
        f"{family}.{one}"
        for family, one, table in places.devices(scene)
        if one not in supports and one not in together and not _linear(table)
    ]
    if others:
        mistakes.add(path, f"{where} rubs beside {others[0]}: {_BESIDE}")
    lossy = [
        f"{family}.{one}"
        for family, one, table in places.devices(scene)
        if one != name and family in ("links", "absorbers") and getattr(table, "loss_factor", None) is not None
    ]
    if lossy:
        mistakes.add(
            path,
            f"{where} rubs beside {lossy[0]}.loss_factor, which knows harmonic motion only, and a motion that "
            "rubs is not harmonic. Write damping or damping_ratio there.",
        )
    loose = _loose(scene)
    if not places.springs(scene):
        mistakes.add(
            path,
            f"links.{name} has a friction_force but no stiffness that brings it back: it slips away, and where it "
            'stays nobody knows. Add stiffness = "200 kN/m".',
        )
    elif loose:
        mistakes.add(
            path,
            f"{where} rubs, and no spring brings bodies.{loose[0]} back: it slips away, and where it stays nobody "
            f'knows. Join bodies.{loose[0]} by a link with stiffness = "200 kN/m" to what is held.',
        )
    _shaken(scene, where, path, mistakes)
    if scene.find_all is not None:
        way = "Limit the response over ranges of speeds, and look at their margins."
        if scene.finds == "values":
            way = "Write a goal with minimise or maximise instead: vibopt window FILE then tells what is permitted."
        mistakes.add(
            ("goal", "find_all"),
            f"goal.find_all finds all {scene.finds} at which a linear machine keeps its limits, but {where} rubs. "
            + way,
        )


def _shaken(scene: Scene, where: str, path: Path, mistakes: Mistakes) -> None:
    """One harmonic, or what comes once: together such excitations are one motion, beside others they are none."""
    names = [f"excitations.{name}" for name in scene.excitations]
    lasting = [one for one, table in scene.excitations.items() if table.sort != "transient"]
    if len(names) > 1 and lasting:
        mistakes.add(
            path,
            f"{where} rubs under {names[0]} and {names[1]}. The sum of both decides when it slips, so that their "
            "motions do not add. Keep one of them.",
        )
    for one, table in scene.excitations.items():
        if table.on in places.joints(scene):
            mistakes.add(
                path,
                f"{where} rubs under excitations.{one}, which acts on {table.on}. It has no mass, and would slip as "
                "suddenly as that. Let it act on a body with mass, or give the joint its mass.",
            )
        if table.sort == "random" or table.ramp is not None:
            what = "run-up" if table.ramp is not None else "white noise"
            mistakes.add(
                path,
                f"{where} rubs under the {what} of excitations.{one}. Dry friction is answered in steady vibration "
                "under one harmonic, and under what comes once. Write damping or damping_ratio, or another excitation.",
            )
        elif table.once is not None and table.once.holds:
            mistakes.add(
                path,
                f"{where} rubs under excitations.{one}, which stays for ever. Dry friction is answered under what "
                'ends: write shape = "rectangle" and a duration that is long enough for it to come to rest.',
            )
        elif table.once is not None and table.once.durations is not None:
            mistakes.add(
                path,
                f"{where} rubs under a pulse of unknown duration, excitations.{one}: which is the worst is known of "
                'linear motion alone. Write duration = "20 ms", and look at others with vibopt sweep.',
            )
        elif table.sort == "steady" and not table.direction_known and len(table.lines(np.ones(1))) > 1:
            mistakes.add(
                path,
                f"{where} rubs under the harmonics of excitations.{one}. All of them together decide when it slips, so "
                'that their motions do not add. Write the greatest alone: kind = "force".',
            )


def _together(scene: Scene) -> list[str]:
    """The first link that rubs, and those that rub between the same two ends."""
    ends = {name: frozenset(places.ends(scene)[name]) for name in places.rubbing(scene)}
    return [name for name in ends if ends[name] == ends[places.rubbing(scene)[0]]]


def _listed(links: list[str]) -> str:
    return " and ".join(f"links.{name}" for name in links)


def _linear(table: Device) -> bool:
    """Whether it may stand beside what rubs: forces that follow motion, and a mass along the line."""
    if isinstance(table, LinkTable):
        return not table.rubs and not table.spreads_mass
    if isinstance(table, BodyTable):
        return not table.turns and table.geared_to is None
    return isinstance(table, FAMILIES["absorbers"])


def _loose(scene: Scene) -> list[str]:
    """Bodies that no chain of springs joins to a support."""
    held, ends = {GROUND, *places.supports(scene)}, places.ends(scene)
    for _ in scene.bodies:
        held |= {end for link in places.springs(scene) if held & {*ends[link]} for end in ends[link]}
    return [name for name in scene.bodies if name not in held]


def rubs_in(scene: Scene, path: Path, response: Response, mistakes: Mistakes) -> bool:
    """Whether a response has no meaning with the dry friction of the scene; adds the mistake."""
    rubbing = places.rubbing(scene)
    why, way = response.against_friction, "Ask for a steady displacement, force or transmissibility, or write damping "
    way += "instead of the friction."
    if isinstance(response, TransientResponse) and response.combine is not None:
        why = "of one excitation is no part of that of several, for all together decide when it slips"
        way = "Leave combine out: then all act together, from one beginning."
    if len(rubbing) > 1 and getattr(response, "through", None) in rubbing:
        mistakes.add(
            path,
            f"{dotted(path)}.through: {_listed(_together(scene))} {_TOGETHER} Ask for the force into a place, or "
            f"give the friction of all to links.{rubbing[0]}.",
        )
        return True
    if not rubbing or not why:
        return False
    mistakes.add(path, f"{dotted(path)}: with links.{rubbing[0]}.friction_force, {response.response} {why}. {way}")
    return True
