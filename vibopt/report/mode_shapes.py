"""Natural modes of the finished machine, each with its shape in words: who moves, which way, with what share.

The share of a motion in a mode is its part of the mode's kinetic energy, as `energy_share` counts it: velocity
times momentum, along x, y, z and about them through each centre of mass.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.mechanics.built_algebra import inverse_root
from vibopt.mechanics.machine import Machine, is_in_space
from vibopt.records import dataclass
from vibopt.units import plain

WORTH_SAYING = 0.1
"""Shares below this are left out of the words."""
MOST_SAID = 3
SAME = 1e-6
"""Frequencies closer than this, as a part of themselves, belong to modes that mix as one likes."""
_AXES = ("x", "y", "z", "rx", "ry", "rz")
_FIRST = {
    "x": "along x",
    "y": "along y",
    "z": "vertical",
    "rx": "rocking about x",
    "ry": "rocking about y",
    "rz": "turning about z",
    "": "",
    "turn": "turning",
    "slides": "sliding",
}
_THEN = _FIRST | {"x": "motion along x", "y": "motion along y", "z": "vertical motion"}


@dataclass(frozen=True, slots=True)
class Part:
    """One motion of a mode: body, "x" to "rz" (of what moves on a line "", of what turns "turn", of an absorber in
    space "slides"), share, sense."""

    body: str
    way: str
    share: float
    sense: float


@dataclass(frozen=True, slots=True)
class Shape:
    """One mode.

    frequency
        Undamped [rad/s].
    damping
        Ratio, of the mode by itself; None where the machine has no damping or the mode does not swing.
    parts
        All motions in it, the greatest share first; empty where a structure swings with it.
    """

    frequency: float
    damping: float | None
    parts: tuple[Part, ...]

    @property
    def words(self) -> str:
        """The shape in words: "rocking about y (78 %) with motion along x (21 %)"."""
        return words_of(self.parts)


def shapes_of(machine: Machine, turning: Sequence[str] = ()) -> list[Shape]:
    """All modes, ascending.

    Parameters
    ----------
    machine
        As built.  With structures only the frequencies are told.
    turning
        Names of what turns about its own axis instead of moving along a line.

    Notes
    -----
    A damping ratio is the diagonal of the damping in the undamped modes: exact where the damping goes with mass or
    stiffness, else right to first order in the damping.
    """
    if machine.on_structures:
        return [Shape(float(one), None, ()) for one in machine.natural_frequencies()]
    mass, damping, stiffness, hysteretic = machine.matrices()
    if machine.jointed.any():
        omega, shapes = machine.mode_shapes()
    else:
        root = inverse_root(mass)
        squares, vectors = np.linalg.eigh(root @ stiffness @ root.T)
        omega, shapes = np.sqrt(np.maximum(squares, 0.0)), root.T @ vectors
    omega[omega <= SAME * omega.max(initial=0.0)] = 0.0
    motions = list(_motions(machine, set(turning)))
    modes = _told_apart(shapes, omega, motions)
    lossy = bool(damping.any() or hysteretic.any())
    found = []
    for frequency, mode in zip(omega, modes.T, strict=True):
        ratio = None
        if lossy and frequency > 0.0:
            ratio = float(mode @ (damping / frequency + hysteretic / frequency**2) @ mode) / 2.0
        parts = [_part(body, way, rows, mode) for body, way, rows in motions]
        found.append(Shape(float(frequency), ratio, tuple(sorted(parts, key=lambda part: -part.share))))
    return found


Motion = tuple[str, str, tuple[FloatArray, FloatArray]]
"""Body, way, and the rows of its velocity and its momentum over the coordinates, each (n,)."""


def _motions(machine: Machine, turning: set[str]) -> Iterator[Motion]:
    """Everything that can move by itself."""
    if not is_in_space(machine):
        for name, mass in machine.masses.items():
            row = machine.row(name)
            yield name, "turn" if name in turning else "", (row, mass * row)
        return
    count = len(machine.columns)
    for name in machine.line:
        row = np.eye(count)[machine.line.index(name)]
        yield name, "z", (row, machine.masses[name] * row)
    for name, slider in machine.guided.items():
        row = machine.row(name)
        yield name, "slides", (row, slider.mass * row)
    for name, body in machine.rigid.items():
        slide = np.array([velocity if one == name else np.zeros(3) for one, velocity, _ in machine.columns])
        turn = np.array([spin if one == name else np.zeros(3) for one, _, spin in machine.columns])
        for k, way in enumerate(_AXES):
            if way not in body.freedoms:
                continue
            rows = (slide[:, k], body.mass * slide[:, k]) if k < 3 else (turn[:, k - 3], turn @ body.tensor[k - 3])
            yield name, way, rows


def _part(body: str, way: str, rows: tuple[FloatArray, FloatArray], mode: FloatArray) -> Part:
    velocity, momentum = (float(row @ mode) for row in rows)
    return Part(body, way, max(velocity * momentum, 0.0), velocity)


def _told_apart(modes: FloatArray, omega: FloatArray, motions: Sequence[Motion]) -> FloatArray:
    """Modes of equal frequency turned so that each has as much as it can of one motion; the same for others."""
    found, start = modes.copy(), 0
    for stop in range(1, len(omega) + 1):
        if stop < len(omega) and omega[stop] - omega[stop - 1] <= SAME * omega[stop]:
            continue
        if stop - start > 1:
            some = modes[:, start:stop]
            weight = sum((k + 1.0) * np.outer(v, m) for k, (_, _, (v, m)) in enumerate(motions))
            told = some.T @ np.asarray(weight) @ some
            found[:, start:stop] = some @ np.linalg.eigh(0.5 * (told + told.T))[1]
        start = stop
    return found


def words_of(parts: Sequence[Part]) -> str:
    """Motions in words, the greatest first; those with little of the energy are left out."""
    if not parts:
        return ""
    several = len({part.body for part in parts}) > 1
    if not several and parts[0].way in ("", "turn"):
        return f"{parts[0].body} {'turns' if parts[0].way else 'moves'}"
    said = [parts[0], *(part for part in parts[1 : 2 if several else MOST_SAID] if part.share >= WORTH_SAYING)]
    words = []
    for i, one in enumerate(said):
        who = one.body if several and (i == 0 or one.body != said[i - 1].body) else ""
        way = (_THEN if i else _FIRST)[one.way]
        words.append(" ".join(filter(None, (who, way, _percent(one.share)))))
    if len(said) == 1:
        return words[0]
    return f"{words[0]} with {' and '.join(words[1:])}{_step(said)}"


def _percent(share: float) -> str:
    return "" if share >= 0.995 else f"({plain(100.0 * share, 2)} %)"


def _step(said: Sequence[Part]) -> str:
    """Whether the two bodies that move most go the same way."""
    part, other = said[:2]
    if part.way != other.way or part.body == other.body:
        return ""
    return ", in step" if part.sense * other.sense > 0.0 else ", against each other"
