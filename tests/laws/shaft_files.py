"""Matrices of a shaft by two-node elements, as other programs write them, in any units and order of coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import mmwrite
from scipy.sparse import coo_array, csc_array, save_npz

from test_rotor_routes import element

ORDER = ("y", "z", "about_y", "about_z")
STEEL = {"modulus": "211 GPa", "density": "7810 kg/m3"}


def plane(nodes: Sequence[float], outer: float) -> tuple[Any, Any, Any]:
    """Stiffness, inertia and polar inertia of a bare shaft in one plane, deflection and tilt of each node in turn."""
    found = tuple(np.zeros((2 * len(nodes), 2 * len(nodes))) for _ in range(3))
    for i, (a, b) in enumerate(pairwise(nodes)):
        here = slice(2 * i, 2 * i + 4)
        for target, part in zip(found, element(b - a, outer, 0.0, STEEL), strict=True):
            target[here, here] += part
    return found


def both(one: Any, *, skew: bool = False) -> Any:
    """Of both planes over y, z, about_y, about_z of each node; the tilt of z is against a turn about y."""
    n = len(one) // 2
    found, (y, z) = (
        np.zeros((4 * n, 4 * n)),
        (np.add.outer(4 * np.arange(n), side).ravel() for side in ([0, 3], [1, 2])),
    )
    sign = np.tile([1.0, -1.0], n)
    if skew:
        found[np.ix_(y, z)], found[np.ix_(z, y)] = one * sign, -(sign[:, None] * one)
    else:
        found[np.ix_(y, y)], found[np.ix_(z, z)] = one, one * np.outer(sign, sign)
    return found


def ordered(whole: Any, order: Sequence[str], axial: float) -> Any:
    """Coordinates in another order, with other signs, and with those along and about the shaft, which move alone."""
    n, m = len(whole) // 4, len(order)
    found = np.zeros((m * n, m * n))
    names = [one.removeprefix("-") for one in order]
    for j, name in enumerate(names):
        if name not in ORDER:
            found[range(j, m * n, m), range(j, m * n, m)] = axial
    sign = np.array([-1.0 if one.startswith("-") else 1.0 for one in order if one.removeprefix("-") in ORDER])
    there = [j for j, name in enumerate(names) if name in ORDER]
    here = [ORDER.index(names[j]) for j in there]
    to, of = (np.add.outer(step * np.arange(n), side).ravel() for step, side in ((m, there), (4, here)))
    signs = np.tile(sign, n)
    found[np.ix_(to, to)] = whole[np.ix_(of, of)] * np.outer(signs, signs)
    return found


def save(file: Path, whole: Any) -> None:
    """In the form that the ending says."""
    ending = file.suffix
    if ending == ".npy":
        np.save(file, whole)
    elif ending == ".csv":
        np.savetxt(file, whole, delimiter=",", fmt="%.17g")
    elif ending == ".mtx":
        mmwrite(file, coo_array(whole), precision=17, symmetry="general")
    else:
        save_npz(file, csc_array(whole))


def written(
    folder: Path, nodes: Sequence[float], outer: float, *, order: Sequence[str] = ORDER, ending: str = ".npy",
    units: tuple[str, float, float, float] = ("kg m s", 1.0, 1.0, 1.0), lags: float = 0.0,
) -> dict[str, Any]:  # fmt: skip
    """Writes the files of a shaft and gives the table that names them; units by name and by size in kg, m and s.

    With `lags` [s] a damping at rest of so much of the stiffness.
    """
    stiffness, inertia, polar = plane(nodes, outer)
    words, heavy, long, lasts = units
    whole = {"mass": both(inertia), "stiffness": both(stiffness), "gyroscopic": both(polar, skew=True)}
    whole |= {"damping": lags * whole["stiffness"]} if lags else {}
    power = {"mass": 2, "stiffness": 0, "gyroscopic": 2, "damping": 1}
    size = np.tile([long, long, 1.0, 1.0], len(nodes))
    table: dict[str, Any] = {"units": words, "order": list(order), "nodes": [f"{one!r} m" for one in map(float, nodes)]}
    for key, one in whole.items():
        own = one * np.outer(size, size) / (heavy * long**2 * lasts ** (power[key] - 2))
        save(folder / f"{key}{ending}", ordered(own, order, 0.0 if key in ("gyroscopic", "damping") else 3.0))
        table[key] = str(folder / f"{key}{ending}")
    return table
