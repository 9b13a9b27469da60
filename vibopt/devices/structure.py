"""A structure: floor, skid, frame, given by its modes or by its matrices, with named points."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
from pydantic import BeforeValidator, ValidationInfo, WithJsonSchema, model_validator

from vibopt.devices.device import Device
from vibopt.devices.matrix_files import (
    WORDS,
    Kept,
    holding_fault,
    keys_of,
    mass_fault,
    matrix_of,
    named,
    sign_fault,
)  # fmt: skip
from vibopt.devices.symbols import Numbers, Symbols
from vibopt.errors import InputError, QuantityError, counted
from vibopt.files.reading import file_of
from vibopt.mechanics.assembly import Assembly
from vibopt.mechanics.builder import EVERY_MODE, MOST_WHOLE, ModelBuilder
from vibopt.mechanics.model import DAMPING, HYSTERETIC, INERTIA, STIFFNESS
from vibopt.mechanics.monomial import Monomial
from vibopt.units.parsing import LARGEST
from vibopt.values import Fact, Table, number, word
from vibopt.values.fields import KeyedError, complaint

if TYPE_CHECKING:
    from vibopt.mechanics.host import Coordinates, Matrices, Reduction

MOST_LOST = 1e-4
"""Greatest relative error of a receptance from rounding of the entries that is accepted."""
MOST_OFF = 1e-6
"""Greatest relative error of a receptance from leaving out coordinates that is accepted."""
WORTH_SAYING = 1e-9
_MOST_MODES = 200
_ROUNDING = 1e-12


def _file(given: object, info: ValidationInfo) -> FilePath:
    return named(given, keys_of if info.field_name == "file" else matrix_of)


File = Annotated[FilePath, BeforeValidator(_file), WithJsonSchema({"type": "string", "description": "a file name"})]


def _places(given: object) -> object:
    if not isinstance(given, Mapping) or not given:
        raise complaint("names no point. Write points = { midspan = 12 }, with coordinate numbers from 0.")
    for name, place in given.items():
        if isinstance(place, bool) or not isinstance(place, int):
            raise complaint(f"gives {name} no coordinate number. Write points = {{ {name} = 12 }}, counted from 0.")
    return dict(given)


Places = Annotated[
    dict[str, int], BeforeValidator(_places), WithJsonSchema({"type": "object", "description": "numbers from 0"})
]


def _shape(given: object) -> object:
    if not isinstance(given, Mapping) or not given:
        raise complaint("names no point. Write shape = { midspan = 1.0, quarter = 0.7 }.")
    for name, value in given.items():
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) < LARGEST:
            raise complaint(f"gives {name} no number. Write shape = {{ {name} = 1.0 }}.")
    return {name: float(value) for name, value in given.items()}


Shape = Annotated[
    dict[str, float], BeforeValidator(_shape), WithJsonSchema({"type": "object", "description": "value per point"})
]


class Mode(Table):
    """One entry of `modes`: natural frequency, damping ratio, modal mass that belongs to the shape as given.

    Keys
    ----
    frequency: Natural frequency; 0 Hz for a rigid motion.
    damping_ratio: Of the mode; none without it.
    modal_mass: Modal mass that belongs to the shape as it is written.
    shape: How each point moves: `shape = { midspan = 1.0, quarter = 0.7 }`.
    """

    frequency: Fact = number("angular_rate", choice=False, sign="not negative", required=True)
    damping_ratio: Fact | None = number("ratio", choice=False, sign="not negative", most=10.0)
    modal_mass: Fact = number("mass", choice=False, required=True)
    shape: Shape


class StructureTable(Device):
    """`[structures.NAME]`: modes, or matrices with points.

    Keys
    ----
    modes: Natural modes, each with a value for every point: `modes = [{ frequency = "4.2 Hz", damping_ratio = 0.01,
        modal_mass = "20 t", shape = { midspan = 1.0 } }]`. One of `modes`, `file`, or `mass`
        and `stiffness`.
    mass: File of the mass matrix, Matrix Market, .npy, .npz or .csv, SI units, beside the problem file: `mass =
        "mass.mtx"`. Symmetric, of no negative mass.
    stiffness: File of the stiffness matrix: `stiffness = "stiffness.mtx"`. Symmetric, of no negative stiffness, not
        empty.
    damping: File of the damping matrix; none without it: `damping = "damping.mtx"`.
    file: One .npz with M, K and C instead of single files: `file = "girder.npz"`.
    loss_factor: Structural damping of the whole stiffness matrix; steady vibration only.
    points: Names of the coordinates that are asked about or acted on, by number from 0: `points = { midspan = 12
        }`. Refused beside `modes`, whose shapes name them.
    """

    modes: tuple[Mode, ...] | None = None
    mass: File | None = None
    stiffness: File | None = None
    damping: File | None = None
    file: File | None = None
    loss_factor: Fact | None = number("ratio", choice=False, sign="not negative", most=10.0)
    points: Places | None = None

    may_be_off: ClassVar[bool] = False

    @model_validator(mode="after")
    def _one_way(self) -> StructureTable:
        if self.modes is not None:
            self._check_modes()
        elif self.file is not None or self.mass is not None or self.stiffness is not None:
            self._check_matrices()
        else:
            raise word(
                "has neither modes nor matrices. Write modes = [{ frequency, damping_ratio, modal_mass, shape }], or "
                'mass = "m.mtx" and stiffness = "k.mtx".'
            )
        return self

    def _check_modes(self) -> None:
        others = ("mass", "stiffness", "damping", "file", "loss_factor", "points")
        extra = [key for key in others if getattr(self, key) is not None]
        if extra:
            raise word(f"gives modes and {' and '.join(extra)}. Keep the modes, or the matrices with their points.")
        assert self.modes is not None
        if not self.modes:
            raise KeyedError("modes", [], "is an empty list. Give at least one mode, or leave the structure out.")
        for index, mode in enumerate(self.modes):
            missing = [name for name in self.names if name not in mode.shape]
            if missing:
                raise word(
                    f"has no value for {' and '.join(missing)} in the shape of mode {index + 1}. Every mode says how "
                    f"every point moves; write {missing[0]} = 0 where it does not."
                )

    def _check_matrices(self) -> None:
        if self.file is not None:
            doubled = [key for key in ("mass", "stiffness", "damping") if getattr(self, key) is not None]
            if doubled:
                raise word(
                    f"gives file and {' and '.join(doubled)}. Keep the file with all matrices, or the single ones."
                )
            found = keys_of(self.file)
            for key in ("M", "K"):
                if key not in found:
                    raise KeyedError("file", self.file.name, f"has no matrix {key} ({WORDS[key]}). Add it to the file.")
        else:
            for key in ("mass", "stiffness"):
                if getattr(self, key) is None:
                    raise word(f'has no {key} matrix. Write {key} = "{key}.mtx".')
        if self.points is None:
            raise word("has no points. Write points = { midspan = 12 }, with coordinate numbers from 0.")
        self._check_sizes()
        self._check_physics()

    def _check_sizes(self) -> None:
        try:
            parts = {key: self._part(key) for key in ("M", "K", "C")}
        except QuantityError as error:
            assert self.file is not None
            raise KeyedError("file", self.file.name, str(error)) from None
        size = parts["M"].shape[0]
        for key, part in parts.items():
            if part is not None and part.shape[0] != size:
                raise word(
                    f"has matrices that are not of one size: mass {size}, {WORDS[key]} {part.shape[0]}. Take them from "
                    "one model."
                )
        assert self.points is not None
        for name, place in self.points.items():
            if not 0 <= place < size:
                raise word(
                    f"puts {name} at coordinate {place}, but there are {size}, numbered from 0 to {size - 1}. Check "
                    "the number; it counts from 0."
                )

    def _check_physics(self) -> None:
        mass = self._part("M")
        self._fault("M", mass_fault(mass, self._which("M")))
        given = [key for key in ("K", "C") if self._part(key) is not None]
        for key in given:
            self._fault(key, sign_fault(self._part(key), WORDS[key], self._which(key)))
        self._check_condensed()
        for key in given:
            matrix = self.matrices.stiffness if key == "K" else self.matrices.damping
            self._fault(key, holding_fault(matrix, self.matrices.mass, WORDS[key], self._which(key)))
        assert self.points is not None
        lost = _lost(self.matrices, tuple(self.kept_points.values()))
        if lost.worst > MOST_LOST:
            at = next(name for name, place in self.kept_points.items() if place == lost.place)
            much = f"{100 * lost.worst:.2g} %" if lost.worst < 1.0 else "as much as it is"
            self._fault(
                "K",
                f"does not hold enough digits: rounding each of its entries once moves the receptance at {at} by "
                f"{much}, and {100 * MOST_LOST:g} % is the most that can be trusted. Either the mesh is "
                "much finer than the motion needs, or nothing holds it: take fewer elements, or give modes instead.",
            )

    def _check_condensed(self) -> None:
        """Whether coordinates without mass can be left out, and no point is one of them."""
        from vibopt.mechanics.host import CondensationError, massless

        out = set(massless(self._part("M")).tolist())
        for name, place in (self.points or {}).items():
            if place in out:
                raise word(
                    f"puts {name} at coordinate {place}, which has no mass: what would act there moves nothing but "
                    "springs. Name a coordinate with a mass, or give this one a mass."
                )
        try:
            _ = self.matrices
        except CondensationError as error:
            raise word(str(error)) from None

    def _which(self, key: str) -> str:
        return f"Its matrix {key}" if self.file is not None else "It"

    def _fault(self, key: str, text: str) -> None:
        if text:
            where = "file" if self.file is not None else WORDS[key]
            raise KeyedError(where, getattr(self, where).name, text)

    def _part(self, key: str) -> Any:
        """One of the matrices; None for a damping that is not given."""
        if self.file is not None:
            return matrix_of(self.file, key) if key in keys_of(self.file) else None
        file = getattr(self, WORDS[key])
        return matrix_of(file) if file is not None else None

    @property
    def names(self) -> list[str]:
        """Names of the points."""
        if self.modes is not None:
            return list(dict.fromkeys(name for mode in self.modes for name in mode.shape))
        return list(self.points or {})

    @property
    def whole(self) -> Matrices:
        """The matrices as they are in the file, coordinates without mass included."""
        return _assembled(
            *(Kept(self._part(key)) for key in "MCK"), self.loss_factor.value if self.loss_factor else 0.0
        )

    @property
    def matrices(self) -> Matrices:
        """The matrices of the coordinates that have mass."""
        return _condensed(self.whole)

    @property
    def kept_points(self) -> dict[str, int]:
        """Per point its number among the coordinates that have mass."""
        from vibopt.mechanics.host import massless

        out = massless(self.whole.mass)
        return {name: place - int(np.searchsorted(out, place)) for name, place in (self.points or {}).items()}

    @property
    def loose(self) -> int:
        """How many of its motions nothing holds."""
        if self.modes is not None:
            return sum(not mode.frequency.value for mode in self.modes)
        from vibopt.mechanics.host import free_motions

        return free_motions(self.matrices).count

    def host(self, top: float, modes: int = 0) -> Coordinates | Reduction:
        """What a model needs of the structure up to the frequency `top` [rad/s], with its lowest modes."""
        if self.modes is not None:
            return self.modal
        assert self.points is not None
        return _reduced(self.matrices, tuple(self.kept_points.items()), top, modes)

    @property
    def modal(self) -> Coordinates:
        """The list of modes as coordinates."""
        assert self.modes is not None
        shapes = {name: np.array([mode.shape[name] for mode in self.modes]) for name in self.names}
        ratios = [mode.damping_ratio.value if mode.damping_ratio else 0.0 for mode in self.modes]
        from vibopt.mechanics.host import of_modes

        return of_modes(
            np.array([mode.frequency.value for mode in self.modes]),
            np.array(ratios),
            np.array([mode.modal_mass.value for mode in self.modes]),
            shapes,
        )

    @classmethod
    def moving_in(cls, name: str, given: Mapping[str, Any]) -> tuple[str, ...]:
        points = given.get("points")
        if isinstance(points, Mapping):
            return tuple(points)
        modes = given.get("modes")
        shapes = [mode.get("shape") for mode in modes if isinstance(mode, Mapping)] if isinstance(modes, list) else []
        return tuple(dict.fromkeys(point for shape in shapes if isinstance(shape, Mapping) for point in shape))

    @classmethod
    def freedoms_in(cls, name: str, given: Mapping[str, Any]) -> int:
        modes = given.get("modes")
        if isinstance(modes, list):
            return len(modes)
        for key, matrix in (("file", "M"), ("mass", "")):
            if isinstance(given.get(key), str):
                try:
                    return int(matrix_of(file_of(given[key]), matrix).shape[0])
                except QuantityError:
                    return 0
        return 0

    def declare(self, builder: ModelBuilder, name: str) -> None:
        host = self.host(builder.top, builder.modes)
        coordinates, off = _coordinates(host), getattr(host, "error", 0.0)
        if off > MOST_OFF:
            raise InputError(
                f"scene: structures.{name} moves in more ways up to {builder.top / (2.0 * np.pi):.4g} Hz than are "
                f"carried: with {counted(coordinates.count, 'coordinates')}, receptances are off by {off:.0e} of their "
                f"size, and {MOST_OFF:.0e} is the most. Ask up to a lower frequency, or give its modes instead."
            )
        names = _coordinate_names(name, coordinates.count)
        for one in names:
            builder.add_coordinate(one)
        for point, row in coordinates.points.items():
            builder.add_point(point, dict(zip(names, row.tolist(), strict=True)))

    def add_to(self, builder: ModelBuilder, name: str, symbols: Symbols) -> None:
        host = self.host(builder.top, builder.modes)
        coordinates = _coordinates(host)
        names = _coordinate_names(name, coordinates.count)
        for one, mass, stiffness in zip(names, coordinates.mass, coordinates.stiffness, strict=True):
            builder.add_term(INERTIA, {one: 1.0}, Monomial(float(mass)), name, 0.0)
            if stiffness:
                builder.add_term(STIFFNESS, {one: 1.0}, Monomial(float(stiffness)), name)
                if coordinates.loss_factor:
                    lossy = Monomial(float(stiffness) * coordinates.loss_factor)
                    builder.add_term(HYSTERETIC, {one: 1.0}, lossy, name)
        for row, damping in coordinates.dampers():
            parts = {one: float(part) for one, part in zip(names, row, strict=True) if part}
            builder.add_term(DAMPING, parts, Monomial(damping), name)
        from vibopt.mechanics.host import Reduction

        if isinstance(host, Reduction):
            lost = _lost(self.matrices, tuple(self.kept_points.values()))
            builder.left_out += self.whole.size - coordinates.count
            builder.precision = max(builder.precision, host.error, lost.worst)
            builder.remarks.append(self._remark(name, host))

    def built(self, assembly: Assembly, name: str, numbers: Numbers) -> None:
        """Its modes, or its matrices in full where it has them."""
        from vibopt.mechanics.hosted import Carrier

        if self.modes is not None:
            assembly.carriers[name] = Carrier(self.modal)
            return
        places = np.array(list((self.points or {}).values()))
        assembly.carriers[name] = Carrier(_coordinates(self.host(assembly.top, assembly.modes)), self.whole, places)

    def _remark(self, name: str, host: Reduction) -> str:
        """How good the coordinates are, for the answer."""
        from vibopt.mechanics.host import free_motions

        text = (
            f"{name}: {counted(self.whole.size, 'degrees of freedom')}{self._without()}, {host.coordinates.count} "
            f"used; greatest error of receptances {_size(host.error)}, checked at {counted(host.checks, 'frequencies')}"
        )
        free = free_motions(self.matrices)
        if free.count:
            hidden = float(np.sqrt(free.hidden)) / (2.0 * np.pi)
            text += f"; nothing holds {counted(free.count, 'motions')} of it, to less than {hidden:.0e} Hz"
        lost = _lost(self.matrices, tuple(self.kept_points.values()))
        if lost.worst > WORTH_SAYING:
            text += f"; rounding of the matrix entries alone moves them by {lost.worst:.0e}"
        return text

    def _without(self) -> str:
        """How many coordinates have no mass, in words."""
        out = self.whole.size - self.matrices.size
        return f" ({out} of them without mass, condensed exactly)" if out else ""


def _coordinates(host: Coordinates | Reduction) -> Coordinates:
    from vibopt.mechanics.host import Reduction

    return host.coordinates if isinstance(host, Reduction) else host


def _coordinate_names(structure: str, count: int) -> list[str]:
    """Names of coordinates that no point of a file can have."""
    return [f"{structure} [{index + 1}]" for index in range(count)]


@lru_cache(maxsize=8)
def _assembled(mass: Kept, damping: Kept, stiffness: Kept, loss_factor: float) -> Matrices:
    from scipy.sparse import csc_array

    from vibopt.mechanics.host import Matrices

    none = csc_array(mass.matrix.shape)
    return Matrices(mass.matrix, damping.matrix if damping.matrix is not None else none, stiffness.matrix, loss_factor)


@lru_cache(maxsize=8)
def _condensed(whole: Matrices) -> Matrices:
    from vibopt.mechanics.host import condensed

    return condensed(whole)


@lru_cache(maxsize=32)
def _reduced(matrices: Matrices, points: tuple[tuple[str, int], ...], top: float, modes: int) -> Reduction:
    from vibopt.mechanics.host import reduced_host, whole_host
    from vibopt.mechanics.host.matrices import negative_count

    if modes >= EVERY_MODE:  # more than `MOST_WHOLE` are refused with the scene
        return (
            whole_host(matrices, dict(points))
            if matrices.size <= MOST_WHOLE
            else reduced_host(matrices, dict(points), top)
        )
    if modes:  # those within the look-out count, seen from the points or not
        modes = max(modes, min(negative_count(matrices.dynamic(top**2, 0.0)), _MOST_MODES))
    return reduced_host(matrices, dict(points), top, modes=min(modes, matrices.size))


@lru_cache(maxsize=32)
def _lost(matrices: Matrices, places: tuple[int, ...]) -> Any:
    from vibopt.mechanics.host import digits_lost

    return digits_lost(matrices, list(places))


def _size(error: float) -> str:
    """An error to one digit; what rounding alone decides has none."""
    return f"{error:.0e}" if error >= _ROUNDING else f"below {_ROUNDING:.0e}"
