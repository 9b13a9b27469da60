"""What a damper that turns with a shaft can be asked for: thresholds, and steady whirl under what spins with it."""

from __future__ import annotations

from vibopt.document.mistakes import Mistakes, Path, dotted
from vibopt.mechanics.whirl import MOST
from vibopt.responses import Response
from vibopt.scene import places
from vibopt.scene.scene import Scene
from vibopt.scene.space import is_spatial

_THRESHOLD = "stability_threshold"


@places.once
def turning(scene: Scene) -> dict[str, str]:
    """Links with a damping that turns with a shaft, and the key that says it."""
    return {name: key for name, one in scene.links.items() if (key := one.turns_with_shaft)}


def check_spin(scene: Scene, mistakes: Mistakes) -> None:
    """Add what is wrong beside dampers that turn with a shaft."""
    turns = turning(scene)
    if not turns:
        return
    name, key = next(iter(turns.items()))
    path, where = ("links", name, key), f"links.{name}.{key}"
    asked = [*scene.limits.values(), *scene.measures.values(), *([scene.goal.response] if scene.goal else [])]
    if is_spatial(scene) or scene.structures:
        mistakes.add(
            path,
            f"{where} turns with a shaft, which whirls alike in two planes: bodies in space and structures are of one "
            "make across and another along. Leave it out, or write bodies along one line.",
        )
    if places.rubbing(scene):
        mistakes.add(
            path,
            f"{where} turns with a shaft, beside the dry friction of links.{places.rubbing(scene)[0]}, which rubs in "
            "another direction at every instant of a whirl. Keep one of them.",
        )
    if not scene.excitations and not any(one.response == _THRESHOLD for one in asked):
        mistakes.add(
            path,
            f'{where} turns with a shaft, but nothing spins. Add an excitation with kind = "unbalance", whose speed is '
            f'the spin, or ask for the response = "{_THRESHOLD}".',
        )
    for one, table in scene.excitations.items():
        if table.kind != "unbalance" or table.ramp is not None:
            what = "is no unbalance" if table.kind != "unbalance" else "runs up"
            mistakes.add(
                ("excitations", one),
                f"excitations.{one} {what}, but {where} turns with a shaft: it brakes what whirls slower than it spins "
                "in another way forward than backward. Shake with unbalances at steady speeds, or leave it out.",
            )
    if places.raw(scene, "rotors"):
        return
    empty = [body for body, one in scene.bodies.items() if one.massless]
    if len(turns) > 1 and empty:
        mistakes.add(
            path,
            f"{where} turns with a shaft, and so does {list(turns)[1]}, beside bodies.{empty[0]} without a mass: where "
            "several do, thresholds are found among bodies with a mass. Give it one, or leave one of the dampers out.",
        )
    if len(turns) > 1 and places.freedoms(scene) > MOST:
        mistakes.add(
            path,
            f"{where} turns with a shaft, and so does {list(turns)[1]}: where several do, thresholds are found among "
            f"{MOST} bodies at most, and {places.freedoms(scene)} move here. Leave bodies out, or one of the dampers.",
        )


def spins_in(scene: Scene, path: Path, response: Response, mistakes: Mistakes) -> bool:
    """Whether a response has no meaning with, or without, dampers that turn with a shaft; adds the mistake."""
    turns = turning(scene)
    if response.response == _THRESHOLD:
        if not turns and set(places.raw(scene, "links")) <= set(scene.links):
            mistakes.add(
                path,
                f"{dotted(path)} asks for the stability_threshold, but no damper turns with a shaft: nothing makes its "
                'whirl grow. Write rotating_damping = "40 N s/m" on a link, or ask for something else.',
            )
        return not turns
    if turns and response.free_vibration:
        mistakes.add(
            path,
            f"{dotted(path)} asks for the {response.free_vibration}, which is another at every spin where "
            f"links.{next(iter(turns))} has a damping that turns with the shaft. Ask for the {_THRESHOLD}, or leave "
            "the rotating damping out.",
        )
        return True
    return False


__all__ = ["check_spin", "spins_in", "turning"]
