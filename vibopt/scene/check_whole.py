"""Mistakes in what is asked of a machine as a whole: tolerances, prices, free vibration."""

from __future__ import annotations

import math
from itertools import product

import numpy as np

from vibopt.arrays import BoolArray, FloatArray
from vibopt.devices import FAMILIES
from vibopt.document.mistakes import Mistakes, Path, dotted
from vibopt.excitations.excitation import Transient
from vibopt.mechanics.model import DAMPING, INERTIA, STIFFNESS, Model
from vibopt.mechanics.modes import poles
from vibopt.responses import Response
from vibopt.scene import places
from vibopt.scene.assemble import model_of
from vibopt.scene.open_places import is_open
from vibopt.scene.places import devices
from vibopt.scene.scene import Scene
from vibopt.scene.space import is_spatial
from vibopt.scene.uncertain import uncertain

MOST_TURNS, MOST_FADES, MOST_SEARCHED = 20_000, 100_000, 50
"""Vibrations of the fastest mode that are followed until a load ends or they fade, how often dampers may brake them
over, and vibrations over which durations are searched."""
_FADED = 30.0
"""Decay after which nothing is left of a vibration."""
_LIGHT, _OPEN = 1e-9, 1e4
"""Part of its greatest value at which a mass that may be nothing is counted; times its beginning at which a range
without end is counted where durations are searched."""


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
                f"{doubt.path} has a tolerance, which bodies, links, absorbers, mounts and rotors can have. Remove it.",
            )
        low, high = doubt.ends
        if not low <= 1.0 <= high and is_open(scene):
            side = "above" if low > 1.0 else "below"
            mistakes.add(
                (family, name, *steps),
                f"{doubt.path} has deviations that are all {side} zero, and something is to be chosen, which begins "
                'with the machine as said. Add "0 %" to the data.',
            )


def check_turns(scene: Scene, mistakes: Mistakes) -> None:
    """A machine is followed in time only as far as its own motion under the load can be told from rounding."""
    model = model_of(scene)
    low, high = np.array([[variable.low, variable.high] for variable in scene.variables]).reshape(-1, 2).T
    closed = np.isfinite(high)
    ends = "" if closed.all() else " or a smaller end of each range"
    any_length = any(isinstance(one, Transient) and one.durations is not None for one in scene.excitations.values())
    least, most = model.extent(low, np.where(closed, high, low * (_OPEN if any_length else 1.0)))
    free = model.vectors[:, : model.n_free]
    mass, damping, stiffness, held = (
        (free[model.kinds == kind].T * one[model.kinds == kind]) @ free[model.kinds == kind]
        for kind, one in (
            (INERTIA, np.maximum(least, _LIGHT * most)),
            (DAMPING, most),
            (STIFFNESS, most),
            (DAMPING, np.maximum(least, _LIGHT * most)),
        )
    )
    heavy, slow = ~model.massless, model.massless & (np.diag(held) > 0.0)
    fades, turns = (_fastest(mass, one, heavy) for one in (damping, stiffness))
    fades, turns = max(fades, _fastest(held, stiffness, slow)), float(np.sqrt(turns)) / (2.0 * np.pi)
    for name, excitation in scene.excitations.items():
        if not isinstance(excitation, Transient):
            continue
        followed = excitation.length
        if excitation.step == math.inf and max(turns, fades) * followed > MOST_SEARCHED:
            followed = min(followed, _fading(model, least, most))
        turned, faded = turns * followed, fades * followed
        vibrates = f"the machine may vibrate {_about(turned)} times in it"
        brake = f"dampers may brake the machine {_about(faded)} times over in it"
        if excitation.durations is not None and max(turned, faded) > MOST_SEARCHED:
            mistakes.add(
                ("excitations", name, "duration_up_to"),
                f"excitations.{name} may last {excitation.length:.4g} s, and {vibrates if turned > faded else brake}, "
                f"more than the {MOST_SEARCHED} over which durations are searched. Write a shorter duration_up_to{ends}"
                ": pulses much longer than a period are all alike.",
            )
            continue
        for many, known, key, how, rigid in (
            (turned, MOST_TURNS, "stiffness", vibrates, "rigid"),
            (faded, MOST_FADES, "damping", brake, "clamped"),
        ):
            if many > known:
                smaller = f'a smaller "to" for the {key}' if scene.variables else f"a smaller {key}"
                fine = next((f"structures.{name}" for name, one in scene.structures.items() if one.modes is None), "")
                way = f"give {fine} by its lowest modes" if fine else f"leave out a link that is as good as {rigid}"
                damped = ", more damping" if key == "stiffness" and excitation.step == math.inf else ""
                mistakes.add(
                    ("excitations", name),
                    f"excitations.{name} lasts {excitation.length:.4g} s, and {how}, more than the {known} that are "
                    f"followed. Write a shorter load{damped} or {smaller}, or {way}.",
                )


def _about(many: float) -> str:
    """A large number in two digits."""
    return f"{float(f'{many:.2g}'):g}"


def _fading(model: Model, least: FloatArray, most: FloatArray) -> float:
    """How long it takes until nothing of free vibration is left, at the ends of all ranges [s]."""
    slowest, sides = math.inf, (most,) if np.array_equal(least, most) else (least, most)
    for ends in product(sides, repeat=3):
        ends_of = zip((INERTIA, DAMPING, STIFFNESS), ends, strict=True)
        found = poles(
            model, sum((np.where(model.kinds == kind, end, 0.0) for kind, end in ends_of), np.zeros(len(least)))
        )
        slowest = min(slowest, float(found.imag.min(initial=math.inf)))
    return _FADED / slowest if slowest > 0.0 else math.inf


def _fastest(against: FloatArray, matrix: FloatArray, among: BoolArray) -> float:
    """Greatest size of a value of one matrix over another, on some coordinates (n,)."""
    parts = (one[among][:, among] for one in (against, matrix))
    return float(np.abs(np.linalg.eigvals(np.linalg.solve(*parts))).max(initial=0.0))


def check_price(scene: Scene, path: Path, response: Response, mistakes: Mistakes) -> None:
    """A price is asked for only where every part has one, all in one currency."""
    bought = places.bought(scene)
    if not bought and any("part" in table for one in ("links", "mounts") for table in places.raw(scene, one).values()):
        return  # said where the part is
    if not bought:
        mistakes.add(
            path,
            f"{dotted(path)} asks for a price, but nothing is bought. Give a link its part = {{ catalogue = "
            '"mounts.csv" }.',
        )
        return
    units = {}
    for name, part in bought.items():
        if part.price is None:
            mistakes.add(
                path,
                f"{dotted(path)} asks for a price, but {part.catalogue.name}, from which {name} is bought, has "
                'none. Add a column "price [EUR]".',
            )
            return
        units[name] = part.price.unit
    for key in ("at_most", "at_least"):
        given = getattr(response, key)
        if given is not None:
            units[f"{dotted(path)}.{key}"] = given.unit
    _one_currency(path, units, mistakes)


def _one_currency(path: Path, units: dict[str, str], mistakes: Mistakes) -> None:
    (first, unit), *rest = units.items()
    for other, another in rest:
        if another != unit:
            mistakes.add(
                path,
                f"{other} is in {another}, but {first} is in {unit}. Nothing is exchanged: write all prices in one "
                "currency.",
            )
            return


def check_free(scene: Scene, path: Path, response: Response, mistakes: Mistakes) -> bool:
    """Add what is wrong with a response that has a sign; whether the rest is worth checking."""
    where, key = dotted(path), response.response
    if path[0] != "measures":
        way = f"Move it to [measures.{path[1]}]" if len(path) > 1 else "Ask for it in [measures.NAME]"
        mistakes.add(path, f"{where} asks for the {key}, which has a sign and is only measured. {way}.")
        return False
    if is_spatial(scene) or scene.structures or scene.rotors:
        whose = "with rotors" if scene.rotors else "in space or on structures"
        mistakes.add(path, f"{where}: {key} is not supported for machines {whose} yet. Remove it.")
        return False
    if (light := places.joints(scene)) and "after" in type(response).model_fields:
        mistakes.add(
            path,
            f"{where}: {key} begins with the velocity of every body, and {places.empty(scene)[light[0]]} has no mass "
            "that would keep one. Give it its mass, or remove the response.",
        )
        return False
    doubts = uncertain(scene)
    if doubts:
        mistakes.add(
            path,
            f"{where}: {key} is worked out for one machine, but {doubts[0].path} has a tolerance. Remove the one or "
            "the other.",
        )
        return False
    named = [name for name, _ in response.places().values() if name in places.moving(scene)]
    turns = [name for name in named if name in places.turning(scene)]
    slides = [name for name in named if name not in turns]
    if turns and slides:
        mistakes.add(
            path,
            f"{where} looks at {turns[0]}, which turns, and at {slides[0]}, which moves along a line. Name one kind.",
        )
        return False
    return True
