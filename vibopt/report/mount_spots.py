"""Mounts of a machine in space: where each stands, what it carries, and how its group is marked."""

from __future__ import annotations

from math import inf, isfinite

from vibopt.mechanics.rigid import SpaceMachine
from vibopt.records import dataclass
from vibopt.report.figures.paper import FAINT, INK

MARKERS = (("o", INK), ("s", "white"), ("^", FAINT), ("D", "white"), ("v", INK), ("P", FAINT))
"""Shape and filling by group: told apart in grey, and without seeing the filling."""


@dataclass(frozen=True, slots=True)
class Spot:
    """One mount.

    name, group
        "foot.1" and "foot".
    at
        Place [m].
    carried, by
        What stands on it, and what it stands on.
    load
        Vertical static force on what is carried [N]; below zero the mount is lifted, infinite where nothing holds
        the machine.
    """

    name: str
    group: str
    at: tuple[float, float, float]
    carried: str
    by: str
    load: float


def spots_of(machine: SpaceMachine) -> list[Spot]:
    """All mounts, in the order of the file."""
    groups = {single: group for group, singles in machine.groups.items() for single in singles}
    moving = {*machine.rigid, *machine.line}
    found = []
    for mount in (one for one in machine.mounts if one.name in groups):  # no inerters, no absorbers
        first, second = mount.ends
        hangs = first not in moving
        force = machine.static_force(mount.name)
        load = inf if force is None else float(force[2]) * (-1.0 if hangs else 1.0)
        carried, by = (second, first) if hangs else (first, second)
        x, y, z = (float(one) for one in mount.at)
        found.append(Spot(mount.name, groups[mount.name], (x, y, z), carried, by, load))
    return found


def sums_of(spots: list[Spot]) -> dict[str, float]:
    """Sum of the loads under each body that stands on mounts [N]; bodies that are not held are left out."""
    sums: dict[str, float] = {}
    for spot in spots:
        if isfinite(spot.load):
            sums[spot.carried] = sums.get(spot.carried, 0.0) + spot.load
    return sums


def markers_of(machine: SpaceMachine) -> dict[str, tuple[str, str]]:
    """Marker of each group."""
    return {name: MARKERS[i % len(MARKERS)] for i, name in enumerate(machine.groups)}
