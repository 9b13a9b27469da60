"""The shaft of a rotor by matrices of both planes from files: checked, brought to SI, and to one plane."""

from functools import lru_cache
from itertools import pairwise
from pathlib import Path as FilePath
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator, WithJsonSchema, model_validator
from pydantic_core import PydanticCustomError

from vibopt.arrays import FloatArray, IntArray
from vibopt.devices.matrix_files import Kept, matrix_of, named
from vibopt.errors import QuantityError, counted
from vibopt.records import dataclass
from vibopt.units import read_quantity
from vibopt.values import Table, word
from vibopt.values.fields import complaint

MOST_NODES = 150
"""Most nodes of a shaft by its matrices: each frequency solves for all of them."""
SAME = 1e-6
"""Part of its size by which an entry may differ from that of the other plane: rounding of an export."""
LOST = 1e-4
"""Greatest part of the stiffness of the slowest bending that rounding of the entries may be."""
_SINGULAR = 1e-12
_KEYS = {"mass": "M", "stiffness": "K", "gyroscopic": "G", "damping": "C"}
_AXES = ("y", "about_z", "z", "about_y")
"""Deflection and tilt of the plane y, then of z; the tilt of z is against a turn about y."""
_AWAY = ("x", "about_x")
_ORDER = 'order = ["y", "z", "about_y", "about_z"]'
_UNITS = 'units = "kg m s"'


@dataclass(frozen=True)
class Planes:
    """A shaft in SI, coordinates deflection and tilt of each node in turn.

    both
        M, C, G and K over the plane y, then z, each (2 n, 2 n).
    mass, damping, polar, stiffness
        Of one plane (n, n): M z'' + (C - i W P) z' + K z of the whirl y + i z at the spin W.
    precision
        Part of the stiffness of the slowest bending that is rounding.
    """

    both: tuple[FloatArray, FloatArray, FloatArray, FloatArray]
    mass: FloatArray
    damping: FloatArray
    polar: FloatArray
    stiffness: FloatArray
    precision: float


def _symmetric(given: object) -> FilePath:
    return named(given, matrix_of)


def _skew(given: object) -> FilePath:
    return named(given, lambda file: matrix_of(file, skew=True))


_NAME = WithJsonSchema({"type": "string", "description": "a file name"})
Symmetric = Annotated[FilePath, BeforeValidator(_symmetric), _NAME]
Skew = Annotated[FilePath, BeforeValidator(_skew), _NAME]


def _units(given: object) -> tuple[float, float, float]:
    """Mass [kg], length [m] and time [s] of the matrices; the first may be a force."""
    words = given.split() if isinstance(given, str) else []
    if len(words) != 3:
        raise complaint(f'is not three units, of mass or force, length and time. Write {_UNITS}, or "t mm s".')
    first, length, time = words
    try:
        long, lasts = read_quantity(f"1 {length}", "length").value, read_quantity(f"1 {time}", "time").value
        try:
            return read_quantity(f"1 {first}", "mass").value, long, lasts
        except QuantityError:
            return read_quantity(f"1 {first}", "force").value * lasts**2 / long, long, lasts
    except QuantityError:
        raise complaint(
            f'is not three units, of mass or force, length and time. Write {_UNITS}, or "t mm s".'
        ) from None


Units = Annotated[
    tuple[float, float, float],
    BeforeValidator(_units),
    WithJsonSchema({"type": "string", "description": "units of mass, length and time"}),
]


def _order(given: object) -> tuple[str, ...]:
    words = tuple(given) if isinstance(given, (list, tuple)) else ()
    axes = [str(word).removeprefix("-") for word in words]
    strange = next((one for one, axis in zip(words, axes, strict=True) if axis not in (*_AXES, *_AWAY)), None)
    if strange is not None or not words:
        what = f'has "{strange}"' if strange is not None else "is empty"
        raise complaint(
            f"{what}. The coordinates of a node are y, z, about_y and about_z, and x and about_x where the matrices "
            f"have them, with a minus before it where one counts the other way: {_ORDER}."
        )
    double = next((axis for axis in axes if axes.count(axis) > 1), None)
    missing = next((axis for axis in _AXES if axis not in axes), None)
    if double is not None or missing is not None:
        raise complaint(f"has {f'{double} twice' if double else f'no {missing}'}. Name each coordinate once: {_ORDER}.")
    return words


Order = Annotated[
    tuple[str, ...],
    BeforeValidator(_order),
    WithJsonSchema({"type": "array", "description": "coordinates of each node in turn"}),
]


def _nodes(given: object) -> tuple[float, ...]:
    if not isinstance(given, (list, tuple)) or len(given) < 2:
        raise complaint('is no list of places. Write nodes = ["0 mm", "250 mm", "500 mm"], one for each node.')
    found = []
    for place in given:
        try:
            found.append(place if isinstance(place, float) else read_quantity(place, "length").value)
        except QuantityError as error:
            raise complaint(f'has "{place}", which {error} Write a place: "250 mm".') from None
    for number, (value, other) in enumerate(pairwise(found), start=1):
        if other <= value:
            raise complaint(
                f"does not rise from node {number} at {value:g} m to node {number + 1} at {other:g} m. Number the "
                "nodes from left to right."
            )
    if found[0] < 0.0:
        raise complaint("begins left of the shaft. Count places from its left end.")
    if len(found) > MOST_NODES:
        raise complaint(f"has {len(found)} places; {MOST_NODES} nodes are the most. Export a coarser model.")
    return tuple(found)


Nodes = Annotated[
    tuple[float, ...],
    BeforeValidator(_nodes),
    WithJsonSchema({"type": "array", "description": "places from the left end"}),
]


class ShaftMatrices(Table):
    """`[rotors.NAME.matrices]`: the shaft as another program has it, without its bearings, instead of `sections`.

    M u'' + (C + W G) u' + K u at the spin W. The shaft points along x, y is level and z upward; it turns from y to z.
    Both planes are alike: what differs between them belongs to `[bearings.NAME]`.

    Keys
    ----
    mass: File of M: .mtx, .npy, .npz or .csv: `mass = "mass.mtx"`. Symmetric and positive definite.
    stiffness: File of K: `stiffness = "stiffness.mtx"`. Symmetric; it lets the shaft move and tilt freely.
    gyroscopic: File of G, which the spin is multiplied by: `gyroscopic = "gyroscopic.mtx"`. Skew.
    damping: File of C, of what damps at rest and does not turn with the shaft; none without it: `damping =
        "damping.mtx"`.
    units: Of mass (or force), length and time: `units = "kg m s"`, `units = "t mm s"`, `units = "lbf in s"`. Angles are
        in radians.
    order: Coordinates of each node in turn: `order = ["y", "z", "about_y", "about_z"]`. With a minus, `"-about_y"`,
        where one counts the other way; `"x"` and `"about_x"` are left out.
    nodes: Place of each node from the left end, in turn: `nodes = ["0 mm", "250 mm", "500 mm"]`. Stations and discs
        stand at nodes.
    """

    mass: Symmetric
    stiffness: Symmetric
    gyroscopic: Skew
    damping: Symmetric | None = None
    units: Units | None = None
    order: Order
    nodes: Nodes

    @model_validator(mode="after")
    def _fits(self) -> "ShaftMatrices":
        if self.units is None:
            raise word(f'does not say the units of its matrices. Write {_UNITS}, or "t mm s".', "mass")
        parts = {key: self._part(key) for key in _KEYS}
        size = parts["mass"].shape[0]
        for key, part in parts.items():
            if part is not None and part.shape[0] != size:
                raise word(
                    f"has matrices that are not of one size: mass {size}, {key} {part.shape[0]}. Take them from one "
                    "model.",
                    key,
                )
        if size != len(self.nodes) * len(self.order):
            raise word(
                f"has {counted(len(self.nodes), 'nodes')} of {counted(len(self.order), 'coordinates')}, and matrices "
                f"of {counted(size, 'rows')}. Write a place for each node, and its coordinates in order.",
                "nodes",
            )
        _ = self.planes
        return self

    def _part(self, key: str) -> Any:
        file = getattr(self, key)
        return matrix_of(file, skew=key == "gyroscopic") if file is not None else None

    @property
    def planes(self) -> Planes:
        """The shaft in SI; PydanticCustomError where the matrices are none of a shaft."""
        assert self.units is not None
        return _planes(tuple(Kept(self._part(key)) for key in _KEYS), self.units, self.order, self.nodes)


@dataclass(frozen=True)
class _Reading:
    """Where coordinates stand in a file.

    places, signs
        Of the plane y, then z, deflection and tilt of each node in turn, (2 n,).
    """

    order: tuple[str, ...]
    places: IntArray
    signs: FloatArray

    def name(self, i: int) -> str:
        """A coordinate of both planes by the words of the file."""
        row = int(self.places[i])
        return self.row(row)

    def row(self, row: int) -> str:
        node, which = divmod(row, len(self.order))
        return f"{self.order[which].removeprefix('-')} of node {node + 1}"


def _read(order: tuple[str, ...], nodes: int) -> _Reading:
    axes = [one.removeprefix("-") for one in order]
    columns, signs = [], []
    for axis in _AXES:
        columns.append(axes.index(axis))
        signs.append((-1.0 if order[columns[-1]].startswith("-") else 1.0) * (-1.0 if axis == "about_y" else 1.0))
    base = len(order) * np.arange(nodes)[:, None]
    places = np.concatenate([(base + columns[:2]).ravel(), (base + columns[2:]).ravel()])
    both = np.concatenate([np.tile(signs[:2], nodes), np.tile(signs[2:], nodes)])
    return _Reading(order, places, both)


@lru_cache(maxsize=8)
def _planes(
    files: tuple[Kept, ...], units: tuple[float, float, float], order: tuple[str, ...], nodes: tuple[float, ...]
) -> Planes:
    reading = _read(order, len(nodes))
    heavy, long, lasts = units
    lengths = np.tile([1.0 / long, 1.0], 2 * len(nodes)) * reading.signs
    energy = heavy * long**2 / lasts**2
    sizes = {"mass": energy * lasts**2, "stiffness": energy, "gyroscopic": energy * lasts**2, "damping": energy * lasts}
    found = {}
    for key, kept in zip(_KEYS, files, strict=True):
        whole = kept.matrix.toarray() if kept.matrix is not None else np.zeros((len(order) * len(nodes),) * 2)
        _alone(key, whole, reading)
        chosen = whole[np.ix_(reading.places, reading.places)]
        found[key] = sizes[key] * np.outer(lengths, lengths) * chosen
    mass, stiffness, gyroscopic, damping = (found[key] for key in _KEYS)
    _check_inertia(mass, reading)
    one = {key: _one_plane(key, found[key], np.diag(mass if key == "mass" else found[key]), reading)
           for key in ("mass", "stiffness", "damping")}  # fmt: skip
    precision = _check_free(one["stiffness"], nodes, reading)
    _check_damping(one["damping"])
    polar = _polar(gyroscopic, one["mass"], reading)
    both = (mass, damping, gyroscopic, stiffness)
    return Planes(both, one["mass"], one["damping"], polar, one["stiffness"], precision)


def _alone(key: str, whole: FloatArray, reading: _Reading) -> None:
    """What moves along the shaft or turns about it is left out: it must move by itself."""
    out = np.setdiff1d(np.arange(len(whole)), reading.places)
    if not len(out):
        return
    coupled = np.abs(whole[np.ix_(reading.places, out)])
    if coupled.max(initial=0.0) > SAME * np.abs(whole).max():
        i, j = _worst(coupled)
        raise _fault(
            key,
            f"couples {reading.name(i)} with {reading.row(int(out[j]))}: bending by itself is answered. Correct "
            "the order, or export the shaft without that coupling.",
        )


def _one_plane(key: str, both: FloatArray, diagonal: FloatArray, reading: _Reading) -> FloatArray:
    """Mean of both planes, which are alike and do not act on each other."""
    n = len(both) // 2
    size = np.sqrt(np.abs(diagonal))
    if not size.any():
        return both[:n, :n]
    least = np.outer(size, size)
    across = np.abs(both[:n, n:])
    if (across > SAME * least[:n, n:]).any():
        i, j = _worst(across / np.maximum(least[:n, n:], 1e-300))
        raise _fault(
            key,
            f"couples {reading.name(i)} with {reading.name(n + j)}: the {key} of a shaft acts in each plane "
            "by itself. Write what couples them as [bearings.NAME], or correct the order.",
        )
    apart = np.abs(both[:n, :n] - both[n:, n:])
    if (apart > SAME * least[:n, :n]).any():
        i, j = _worst(apart / np.maximum(least[:n, :n], 1e-300))
        raise _fault(
            key,
            f"is not alike in both planes: {both[i, j]:.6g} between {reading.name(i)} and {reading.name(j)}, and "
            f"{both[n + i, n + j]:.6g} between {reading.name(n + i)} and {reading.name(n + j)} (SI). Leave bearings "
            "out of the matrices and write them as [bearings.NAME], or correct the order and its signs.",
        )
    return np.asarray(0.5 * (both[:n, :n] + both[n:, n:]))


def _check_inertia(mass: FloatArray, reading: _Reading) -> None:
    """Whether a mass matrix is positive definite."""
    diagonal = np.diag(mass)
    least = int(diagonal.argmin())
    if diagonal[least] <= 0.0:
        raise _fault(
            "mass",
            f"is singular: {reading.name(least)} has no inertia. Give every node a mass and a moment of inertia, as a "
            "consistent mass matrix does.",
        )
    values = np.linalg.eigvalsh(mass / np.sqrt(np.outer(diagonal, diagonal)))
    if values[0] <= _SINGULAR:
        what = "is singular" if values[0] > -_SINGULAR else "has a negative eigenvalue"
        raise _fault("mass", f"{what}: some motion would have no mass, or a negative one. Check the export.")


def _check_free(stiffness: FloatArray, nodes: tuple[float, ...], reading: _Reading) -> float:
    """What rounding does to the slowest bending of a shaft that may move and tilt freely, which is checked."""
    diagonal = np.diag(stiffness)
    least = int(diagonal.argmin())
    if diagonal[least] <= 0.0:
        raise _fault("stiffness", f"lets {reading.name(least)} go by itself. Check the export.")
    moves = np.tile([1.0, 0.0], len(nodes))
    tilts = np.array([[place - nodes[0], 1.0] for place in nodes]).ravel()
    rounding = 0.0
    for way, words in ((moves, "move along y"), (tilts, "tilt")):
        left, size = np.abs(stiffness @ way), np.abs(stiffness) @ np.abs(way)
        worst = int((left / size).argmax())
        part = float(left[worst] / size[worst])
        if part > SAME:
            why = (
                "Leave bearings and supports out of the matrix, and write them as links or bearings."
                if words != "tilt"
                else "Leave supports out of it, or correct nodes, units, and the signs in order."
            )
            raise _fault(
                "stiffness",
                f"does not let the shaft {words} as a whole: at {reading.name(worst)} a force of {100.0 * part:.3g} % "
                f"of what its parts are holds it back. {why}",
            )
        rounding = max(rounding, part)
    size = np.sqrt(np.outer(diagonal, diagonal))
    values = np.linalg.eigvalsh(stiffness / size)
    if values[0] < -LOST * values[2]:
        raise _fault("stiffness", "has a negative eigenvalue: some motion would be pushed on. Check the export.")
    lost = rounding * float(values[-1] / values[2]) if values[2] > 0.0 else np.inf
    if lost > LOST:
        raise _fault(
            "stiffness",
            f"does not hold enough digits: rounding of its entries may be {100.0 * lost:.2g} % of the stiffness of the "
            f"slowest bending, and {100.0 * LOST:g} % is the most that can be trusted. Write all digits of each entry.",
        )
    return lost


def _check_damping(damping: FloatArray) -> None:
    diagonal = np.diag(damping)
    size = np.sqrt(np.maximum(np.abs(diagonal), np.abs(diagonal).max(initial=0.0) * _SINGULAR))
    if damping.any() and np.linalg.eigvalsh(damping / np.outer(size, size))[0] < -SAME:
        raise _fault("damping", "has a negative eigenvalue: some motion would gain energy. Check signs and units.")


def _polar(gyroscopic: FloatArray, mass: FloatArray, reading: _Reading) -> FloatArray:
    """Polar inertia of one plane, of gyroscopic moments that join both."""
    n = len(mass)
    size = np.sqrt(np.tile(np.diag(mass), 2))
    least = np.outer(size, size)
    blocks = [gyroscopic[:n, :n], gyroscopic[n:, n:]]
    for begin, block in zip((0, n), blocks, strict=True):
        within = np.abs(block) / least[:n, :n]
        if (within > SAME).any():
            i, j = (begin + one for one in _worst(within))
            raise _fault(
                "gyroscopic",
                f"joins {reading.name(i)} with {reading.name(j)}, in one plane: gyroscopic moments act from one plane "
                "on the other. Correct the order.",
            )
    found = gyroscopic[:n, n:]
    apart = np.abs(found - found.T) / least[:n, :n]
    if (apart > SAME).any():
        i, j = _worst(apart)
        raise _fault(
            "gyroscopic",
            f"is not alike in both planes: {found[i, j]:.6g} between {reading.name(i)} and {reading.name(n + j)}, and "
            f"{found[j, i]:.6g} between {reading.name(j)} and {reading.name(n + i)} (SI). Correct the order and its "
            "signs.",
        )
    polar = np.asarray(0.5 * (found + found.T))
    own = np.sqrt(np.diag(mass))
    values = np.linalg.eigvalsh(polar / np.outer(own, own))
    if values[0] < -SAME and values[-1] <= SAME:
        raise _fault(
            "gyroscopic",
            'is of a shaft which turns from z to y. Turn z the other way, "-z" and "-about_y" in order, or give G '
            "for the other sense.",
        )
    if values[0] < -SAME:
        raise _fault("gyroscopic", "has a polar inertia below zero somewhere. Correct the order and its signs.")
    if np.linalg.eigvalsh((2.0 * mass - polar) / np.outer(own, own))[0] < -SAME:
        raise _fault(
            "gyroscopic",
            "has a polar inertia of more than twice the diametral one: there is no such shaft. Give the matrix that "
            "the spin in radians per unit of time is multiplied by, not that at a speed, in the units of the mass "
            "matrix.",
        )
    return polar


def _worst(table: FloatArray) -> tuple[int, int]:
    """Row and column of the greatest entry."""
    i, j = divmod(int(table.argmax()), table.shape[1])
    return i, j


def _fault(key: str, text: str) -> PydanticCustomError:
    return word(f"has a matrix {_KEYS[key]} ({key}) that {text}", key)
