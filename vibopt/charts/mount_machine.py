"""A machine on groups of mounts: its file for vibopt, and its matrices in plain numpy, which share nothing with it.

Shelves of parts are drawn with the laws of real rubber mounts.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray, IntArray
from vibopt.records import dataclass
from vibopt.scene.scene import Scene

GRAVITY = 9.80665
FILE = "parts.csv"
SPACE, PLANE, LINE = "space", "plane", "line"
_KEPT = {SPACE: [0, 1, 2, 3, 4, 5], PLANE: [0, 2, 4], LINE: [2]}
_RPM = np.pi / 30.0
HEADS = (
    "part", "rated load min [N]", "rated load max [N]", "stiffness [N/mm]", "shear stiffness [N/mm]",
    "static stiffness [N/mm]", "loss factor", "price [EUR]",
)  # fmt: skip
_PER_MM = 1e3
"""N/m in one N/mm."""


@dataclass(frozen=True)
class Shelf:
    """Columns of a catalogue [SI, EUR], each of shape (n_parts,).

    least, most
        Rated load [N].
    k, shear, static
        Dynamic stiffness along and across the axis, static stiffness along it [N/m].
    loss
        Loss factor.
    price
        Of one part.
    """

    least: FloatArray
    most: FloatArray
    k: FloatArray
    shear: FloatArray
    static: FloatArray
    loss: FloatArray
    price: FloatArray

    def __len__(self) -> int:
        return len(self.k)

    def names(self) -> list[str]:
        """P0, P1, ..."""
        return [f"P{index}" for index in range(len(self))]

    @property
    def text(self) -> str:
        """As a catalogue; every digit is kept."""
        scale = (1.0, 1.0, _PER_MM, _PER_MM, _PER_MM, 1.0, 1.0)
        columns = (self.least, self.most, self.k, self.shear, self.static, self.loss, self.price)
        rows = zip(self.names(), *(column / value for column, value in zip(columns, scale, strict=True)), strict=True)
        lines = [";".join([name, *(repr(float(cell)) for cell in cells)]) for name, *cells in rows]
        return "\n".join([";".join(HEADS), *lines]) + "\n"


@dataclass(frozen=True)
class Machine:
    """One body on groups of mounts of a shelf; limits that are None are not asked.

    mass, centre, inertia
        [kg], shape (3,) [m], shape (3,) [kg m2] about x, y, z through the centre of mass.
    groups
        Places of the mounts of each group, each of shape (n_mounts, 3) [m].
    force, at
        Amplitude along z at full speed [N], growing with its square, and its place, shape (3,) [m].
    speed
        Full speed [rpm].
    floor
        Most force into the floor along z at full speed [N].
    sway, way
        Most displacement of the centre of mass from standstill to full speed [m], along x, y or z.
    highest
        Most of the highest natural frequency [Hz].
    apart
        Least distance of two neighbouring natural frequencies [Hz].
    motion
        "space", "plane" with x, z and the turn about y, or "line" with the vertical coordinate alone.
    """

    title: str
    mass: float
    centre: tuple[float, float, float]
    inertia: tuple[float, float, float]
    groups: tuple[tuple[tuple[float, float, float], ...], ...]
    force: float
    at: tuple[float, float, float]
    speed: float = 1500.0
    floor: float | None = None
    sway: float | None = None
    way: str = "z"
    highest: float | None = None
    apart: float | None = None
    motion: str = SPACE

    @property
    def kept(self) -> list[int]:
        """Coordinates of x, y, z, rx, ry, rz that are free."""
        return _KEPT[self.motion]

    @property
    def omega(self) -> float:
        """Full speed [rad/s]."""
        return self.speed * _RPM

    def matrices(self, shelf: Shelf, chosen: IntArray) -> tuple[FloatArray, ComplexArray, FloatArray]:
        """M (n, n), complex dynamic K (n_choices, n, n) and static K, for choices (n_choices, n_groups) of parts."""
        mass = np.diag([*[self.mass] * 3, *self.inertia])
        n = len(chosen)
        dynamic, static = np.zeros((n, 6, 6), complex), np.zeros((n, 6, 6))
        slow = shelf.static / shelf.k  # the static column counts for every direction
        for group, places in enumerate(self.groups):
            part = chosen[:, group]
            own = np.stack([shelf.shear, shelf.shear, shelf.k], axis=1)[part]
            for place in places:
                reach = self._reach(place)
                block = np.einsum("ci,nc,cj->nij", reach, own, reach)
                dynamic += block * (1.0 + 1j * shelf.loss[part])[:, None, None]
                static += block * slow[part][:, None, None]
        index = np.ix_(self.kept, self.kept)
        return mass[index], dynamic[:, index[0], index[1]], static[:, index[0], index[1]]

    def _reach(self, place: tuple[float, float, float]) -> FloatArray:
        """Motion of a place from the six coordinates, (3, 6)."""
        x, y, z = np.subtract(place, self.centre)
        return np.hstack([np.eye(3), np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])])

    def push(self) -> FloatArray:
        """Force along z at its place, on the kept coordinates, (n,) [N]."""
        push: FloatArray = (self.force * self._reach(self.at)[2])[self.kept]
        return push

    def reads(self) -> FloatArray:
        """Row of the limited displacement, (n,)."""
        row: FloatArray = np.eye(6)["xyz".index(self.way)][self.kept]
        return row

    def falls(self) -> list[list[FloatArray]]:
        """Row of the vertical motion of every mount of every group, (n,)."""
        return [[self._reach(place)[2][self.kept] for place in places] for places in self.groups]

    def document(self) -> dict[str, Any]:
        """The problem file as a dictionary."""
        space = self.motion != LINE
        inertia = [f"{value!r} kg m2" for value in self.inertia]
        body: dict[str, Any] = {"mass": f"{self.mass!r} kg"}
        if space:
            own = inertia[1] if self.motion == PLANE else inertia
            body |= {"motion": self.motion, "centre": _lengths(self.centre), "inertia": own}
        there = {"direction": "z", "at": _lengths(self.at)} if space else {}
        return {
            "title": self.title,
            "bodies": {"machine": body},
            ("mounts" if space else "links"): {f"g{i}": self._group(places) for i, places in enumerate(self.groups)},
            "excitations": {
                "shaft": {"kind": "force", "on": "machine", "amplitude": f"{self.force!r} N", "varies": "speed^2",
                          "speed": f"{self.speed!r} rpm", "amplitude_at": f"{self.speed!r} rpm", **there}
            },
            "limits": self._limits(),
            "goal": {"minimise": "price"},
        }  # fmt: skip

    def _group(self, places: tuple[tuple[float, float, float], ...]) -> dict[str, Any]:
        own = {"between": ["machine", "ground"], "part": {"catalogue": FILE}}
        return own | ({"at": [_lengths(place) for place in places]} if self.motion != LINE else {"count": len(places)})

    def _limits(self) -> dict[str, Any]:
        space = self.motion != LINE
        limits: dict[str, Any] = {}
        if self.floor is not None:
            there = {"direction": "z"} if space else {}
            limits["floor"] = {
                "response": "transmitted_force", "into": "ground", "at_most": f"{self.floor!r} N", **there
            }  # fmt: skip
        if self.sway is not None:
            there = {"direction": self.way} if space else {}
            limits["sway"] = {"response": "displacement", "of": "machine", "over": "start-up",
                              "at_most": f"{self.sway!r} m", **there}  # fmt: skip
        if self.highest is not None:
            limits["highest"] = {"response": "natural_frequency", "mode": len(self.kept),
                                 "at_most": f"{self.highest!r} Hz"}  # fmt: skip
        if self.apart is not None:
            limits["apart"] = {"response": "frequency_separation", "at_least": f"{self.apart!r} Hz"}
        return limits

    def scene(self, folder: Path, shelf: Shelf) -> Scene:
        """Read beside its catalogue, which is written there."""
        from vibopt.document.toml_reading import placed
        from vibopt.scene.read import from_dict

        (folder / FILE).write_text(shelf.text, encoding="utf-8")
        return from_dict(placed(self.document(), folder), name=self.title)


def _lengths(place: tuple[float, float, float]) -> list[str]:
    return [f"{float(value)!r} m" for value in place]


def drawn(seed: int, parts: int, low: float, high: float, *, steel: bool = False) -> Shelf:
    """Parts for loads from `low` to `high` [N].

    Makers' rows of rubber mounts keep a working deflection of 2 to 8 mm, whatever their load; harder rubber has more
    loss and is stiffer against fast than against slow motion; price grows with about the square root of the load.
    Steel springs have the same stiffness fast and slow, and a tenth of the loss.
    """
    rng = np.random.default_rng(seed)
    most = rounded(10.0 ** rng.uniform(np.log10(low), np.log10(high), parts))
    hard = rng.uniform(0.0, 1.0, parts)
    static = rounded(most / (8e-3 * 0.25**hard) * rng.lognormal(0.0, 0.1, parts))
    loss = rounded((0.06 + 0.14 * hard) * rng.lognormal(0.0, 0.15, parts))
    return Shelf(
        least=rounded(0.2 * most),
        most=most,
        k=static if steel else rounded(static * (1.1 + 0.4 * hard)),
        shear=rounded(static * rng.uniform(0.3, 0.7, parts)),
        static=static,
        loss=rounded(0.1 * loss) if steel else loss,
        price=rounded((3.0 + 0.4 * most**0.55) * rng.lognormal(0.0, 0.2, parts)),
    )


def alike(parts: int, **columns: float | FloatArray) -> Shelf:
    """Parts that differ in the columns given as arrays only; sound values for the others."""
    own: dict[str, Any] = {
        "least": 0.0, "most": 1e5, "k": 1e6, "shear": 5e5, "static": 8e5, "loss": 0.1,
        "price": 10.0 + np.arange(parts),
    }  # fmt: skip
    return Shelf(**{name: np.broadcast_to(value, parts).astype(float) for name, value in (own | columns).items()})


def rounded(values: FloatArray) -> FloatArray:
    """To four digits, as on a data sheet."""
    return np.array([float(f"{value:.4g}") for value in values])
