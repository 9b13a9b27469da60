"""What a damper that turns with a shaft can be asked for: thresholds, and steady whirl under what spins with it."""

from __future__ import annotations

from math import isfinite, pi

from vibopt.document.mistakes import Mistakes, Path, dotted
from vibopt.responses import HarmonicResponse, Response
from vibopt.scene import places
from vibopt.scene.check_bearings import in_planes
from vibopt.scene.drives import bands_for, names_for
from vibopt.scene.scene import Scene
from vibopt.scene.space import is_spatial
from vibopt.units import show

THRESHOLD = "stability_threshold"
_ROUNDING, _DIGIT = 1e-9, 1e-5
"""Part by which a speed may differ from a bound in another unit, and that by which six digits are raised."""


@places.once
def turning(scene: Scene) -> dict[str, str]:
    """Links and rotors with a damping that turns with a shaft, by path, and the key that says it."""
    both = (("links", scene.links), ("rotors", scene.rotors))
    return {f"{family}.{name}": key for family, of in both for name, one in of.items() if (key := one.turns_with_shaft)}


def check_spin(scene: Scene, mistakes: Mistakes) -> None:
    """Add what is wrong beside dampers that turn with a shaft."""
    turns = turning(scene)
    if not turns:
        return
    name, key = next(iter(turns.items()))
    path, where = (*name.split("."), key), f"{name}.{key}"
    asked = scene.responses.values()
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
    if not scene.excitations and not any(response.response == THRESHOLD for response in asked):
        mistakes.add(
            path,
            f'{where} turns with a shaft, but nothing spins. Add an excitation with kind = "unbalance", whose speed is '
            f'the spin, or ask for the response = "{THRESHOLD}".',
        )
    for one, table in scene.excitations.items():
        if table.kind != "unbalance" or (table.ramp is not None and not scene.rotors):
            what = "is no unbalance" if table.kind != "unbalance" else "runs up"
            mistakes.add(
                ("excitations", one),
                f"excitations.{one} {what}, but {where} turns with a shaft: it brakes what whirls slower than it spins "
                "in another way forward than backward. Shake with unbalances at steady speeds, or leave it out.",
            )
    if places.raw(scene, "rotors") or len(turns) == 1:
        return
    from vibopt.mechanics.whirl import MOST

    other = [*turns][1].partition(".")[2]
    empty = [*places.empty(scene).values()]
    if empty:
        mistakes.add(
            path,
            f"{where} turns with a shaft, and so does {other}, beside {empty[0]} without a mass: where "
            "several do, thresholds are found among bodies with a mass. Give it one, or leave one of the dampers out.",
        )
    if places.freedoms(scene) > MOST:
        mistakes.add(
            path,
            f"{where} turns with a shaft, and so does {other}: where several do, thresholds are found among "
            f"{MOST} bodies at most, and {places.freedoms(scene)} move here. Leave bodies out, or one of the dampers.",
        )


def check_stable(scene: Scene, mistakes: Mistakes) -> None:
    """Add it where a steady whirl is asked of designs that may spin beyond their threshold, and no limit forbids it."""
    turns, goal = turning(scene), [(("goal",), scene.goal.response)] if scene.goal is not None else []
    if not turns or not scene.variables:
        return
    asked = [((family, name), one) for family in ("limits", "measures") for name, one in vars(scene)[family].items()]
    limits = [one.at_least for _, one in asked if one.response == THRESHOLD and one.at_least is not None]
    known = max((limit.value for limit in limits), default=0.0)
    for path, response in [*asked, *goal]:
        driven = response.reading or response
        if not isinstance(driven, HarmonicResponse):
            continue
        bands = [band.high for name in names_for(scene, driven) for band in bands_for(scene, driven, name)]
        top = max(filter(isfinite, bands), default=0.0)
        if top > known * (1.0 + _ROUNDING):
            spin, name = _at_least(top), next(iter(turns))
            mistakes.add(
                path,
                f"{dotted(path)} asks for a steady whirl at up to {spin}, but {name}.{turns[name]} makes it grow "
                "without end beyond a threshold that hangs on what is chosen. Forbid such designs: add a limit with "
                f'response = "{THRESHOLD}" and at_least = "{spin}".',
            )
            return


def _at_least(spin: float) -> str:
    """A spin [rad/s] in rpm, not below it: a whirl grows at any part of a revolution beyond its threshold."""
    shown = show(spin, "rpm", "angular_rate", digits=6)
    if float(shown.split()[0]) * pi / 30.0 >= spin * (1.0 - _ROUNDING):
        return shown
    return show(spin * (1.0 + _DIGIT), "rpm", "angular_rate", digits=6)


def spins_in(scene: Scene, path: Path, response: Response, mistakes: Mistakes) -> bool:
    """Whether a response has no meaning with, or without, dampers that turn with a shaft; adds the mistake."""
    turns = turning(scene)
    if response.response == THRESHOLD:
        if not turns and not in_planes(scene) and set(places.raw(scene, "links")) <= set(scene.links):
            mistakes.add(
                path,
                f"{dotted(path)} asks for the stability_threshold, but no damper turns with a shaft: nothing makes its "
                'whirl grow. Write rotating_damping = "40 N s/m" on a link, or ask for something else.',
            )
        return not turns and not in_planes(scene)
    if turns and response.free_vibration and not (response.spins or response.whirls):
        mistakes.add(
            path,
            f"{dotted(path)} asks for the {response.free_vibration}, which is another at every spin where "
            f"{next(iter(turns))} has a damping that turns with the shaft. Ask for the {THRESHOLD}, or leave "
            "the rotating damping out.",
        )
        return True
    return False
