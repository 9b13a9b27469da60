"""What bearings hold, and what is asked of rotors in bearings that are not alike in both planes."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.document.mistakes import Mistakes, Path, dotted
from vibopt.mechanics.model import STIFFNESS, Model
from vibopt.responses import HarmonicResponse, Response
from vibopt.scene import places
from vibopt.scene.drives import bands_for, names_for
from vibopt.scene.scene import Scene
from vibopt.signals import Band
from vibopt.units import show

if TYPE_CHECKING:
    from vibopt.devices.bearing import BearingTable


def bearings(scene: Scene) -> dict[str, BearingTable]:
    """All that could be read."""
    return cast("dict[str, BearingTable]", scene.others.get("bearings", {}))


@places.once
def in_planes(scene: Scene) -> list[str]:
    """Names of the bearings that are not alike in both planes: orbits are then no circles."""
    return [name for name, bearing_table in bearings(scene).items() if not bearing_table.alike]


def table_ends(scene: Scene) -> tuple[str, float, float] | None:
    """Speeds [rad/s] between which all tables of bearings say something, and the one that says least; None of none."""
    ends = [
        (name, *bearing_table.ends) for name, bearing_table in bearings(scene).items() if bearing_table.ends is not None
    ]
    if not ends:
        return None
    low, high = max(one[1] for one in ends), min(one[2] for one in ends)
    return next((one[0] for one in ends if one[2] == high), ends[0][0]), low, high


def check_bearings(scene: Scene, mistakes: Mistakes) -> None:
    """Add what is wrong around bearings; nothing where there are none."""
    names = places.raw(scene, "bearings")
    if not names:
        return
    first = next(iter(names))
    if not places.raw(scene, "rotors"):
        mistakes.add(
            ("bearings", first),
            f"bearings.{first} holds a rotor, and there is none. Write [links.{first}] with a stiffness.",
        )
        return
    name, braked = next(iter(in_planes(scene)), ""), [one for one, table in scene.rotors.items() if table.lags]
    if name and braked:
        mistakes.add(
            ("rotors", braked[0], "material_damping"),
            f"rotors.{braked[0]}.material_damping stands beside bearings.{name}, which is not alike in both planes: "
            "the whirl is then no circle, and bends every fibre to and fro. Leave it out, or write bearings that are "
            "alike.",
        )
    stations = {point for rotor in scene.rotors.values() for point in rotor.names}
    for name, table in bearings(scene).items():
        if scene.rotors and not stations & {*table.between}:
            mistakes.value(
                ("bearings", name, "between"),
                list(table.between),
                "has no station or disc of a rotor at either end. Name one, or write a link.",
            )
        for one, other in (("k_yz", "k_zy"), ("c_yz", "c_zy")):
            said = [key for key in (one, other) if getattr(table, key) is not None]
            if len(said) == 1:
                missing = other if said[0] == one else one
                mistakes.add(
                    ("bearings", name, said[0]),
                    f"bearings.{name} gives {said[0]} without {missing}. Write both: the same where the bearing is "
                    "symmetric, of opposite sign where a film drives the whirl.",
                )


def holding_rows(model: Model) -> list[FloatArray]:
    """Rows of all springs on the free coordinates, (n_springs, n_free), of the plane y and of z."""
    springs = [term.vector[: model.n_free] for term in model.terms if term.kind == STIFFNESS and not term.apart]
    planes = []
    for place in (0, 3):  # of k_yy and k_zz
        held = []
        for bearing in model.bearings:
            least = bearing.table[:, place].min() if len(bearing.speeds) else bearing.powers[place].scale
            held += [bearing.row[: model.n_free]] if least > 0.0 else []
        planes.append(np.array([*springs, *held]))
    return planes


def planes_fault(scene: Scene, path: Path, response: Response, mistakes: Mistakes) -> bool:
    """Whether a response has no meaning, or no numbers, beside bearings that are not alike in both planes; adds it."""
    names = in_planes(scene)
    if not names:
        return False
    key, where, name = response.response, dotted(path), names[0]
    if response.sags:
        mistakes.add(
            path,
            f"{where} asks for the {key}, but bearings.{name} says its stiffness about the place at which it runs, not "
            "under the weight. Leave it out.",
        )
        return True
    if response.whirls and not response.free_vibration:
        why = next((f"bearings.{one} {why}" for one in names if (why := bearings(scene)[one].no_potential)), "")
        if why:
            mistakes.add(path, f"{where} asks for the {key} without dampers, but {why}: add damped = true.")
        return bool(why)
    if isinstance(response, HarmonicResponse) and not response.in_planes:
        mistakes.add(
            path,
            f"{where} asks for the {key}, but in bearings.{name}, which is not alike in both planes, it is another "
            "along each direction. Ask for the displacement, the transmitted_force or the bending_stress: the greater "
            "half axis of the orbit.",
        )
        return True
    if response.response == "stability_threshold":
        return _threshold_beyond(scene, path, response, mistakes)
    if bands := response.spins or response.outside_bands:
        return beyond_tables(
            scene, path, Band(min(band.low for band in bands), max(band.high for band in bands)), mistakes
        )
    return isinstance(response, HarmonicResponse) and _beyond_table(scene, path, response, mistakes)


def _threshold_beyond(scene: Scene, path: Path, response: Response, mistakes: Mistakes) -> bool:
    """Whether a threshold is judged beyond the end of a table, where nobody knows what grows; adds it."""
    ends = table_ends(scene)
    if ends is None:
        return False
    name, _, high = ends
    for side, bound in {"at_least": response.at_least, "at_most": response.at_most}.items():
        if bound is not None and bound.value > high * (1.0 + 1e-12):
            said, known = (show(one, "rpm", "angular_rate") for one in (bound.value, high))
            mistakes.add(
                (*path, side),
                f"{dotted(path)}.{side} is {said}, but the table of bearings.{name} ends at {known}: whether a whirl "
                f"grows beyond is not known. Write more rows, or {known} at most.",
            )
            return True
    return False


def _beyond_table(scene: Scene, path: Path, response: HarmonicResponse, mistakes: Mistakes) -> bool:
    """Whether speeds are looked at of which a table says nothing; adds it."""
    if table_ends(scene) is None or not set(names_for(scene, response)) <= set(scene.excitations):
        return False
    bands = [band for one in names_for(scene, response) for band in bands_for(scene, response, one)]
    if not bands:
        return False  # a speed that is wrong, or none: told elsewhere
    asked = Band(min(band.low for band in bands), max(band.high for band in bands))
    return beyond_tables(scene, path, asked, mistakes)


def beyond_tables(scene: Scene, path: Path, asked: Band, mistakes: Mistakes) -> bool:
    """Whether speeds are looked at of which no table of a bearing says anything; adds it."""
    ends = table_ends(scene)
    if ends is None:
        return False
    name, low, high = ends
    if asked.low >= low * (1.0 - 1e-12) and asked.high <= high * (1.0 + 1e-12):
        return False
    said, known = (
        " to ".join(dict.fromkeys(show(value, "rpm", "angular_rate") for value in two))
        for two in ((asked.low, asked.high), (low, high))
    )
    mistakes.add(
        path,
        f"{dotted(path)} looks at {said}, but the tables of bearings, bearings.{name} among them, say something of "
        f"{known} alone. Write more rows, or look at these speeds.",
    )
    return True
