"""A bearing of a rotor: of other stiffness across than along, that couples both planes and changes with the speed."""

from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
from pydantic import BeforeValidator, ValidationError, WithJsonSchema, model_validator

from vibopt.devices.device import Device, Ends
from vibopt.devices.ends import TwoEnds
from vibopt.devices.symbols import Numbers, Symbols
from vibopt.errors import InputError, counted
from vibopt.files.reading import FileFault, file_of
from vibopt.mechanics.assembly import Assembly
from vibopt.mechanics.bearings import COEFFICIENTS
from vibopt.mechanics.builder import ModelBuilder
from vibopt.mechanics.built import Joint, PlaneBearing
from vibopt.mechanics.monomial import Monomial
from vibopt.units import show
from vibopt.values import Fact, Table, Tolerance, Value, number, word
from vibopt.values.csv_tables import bare, heading_of, sheet_of
from vibopt.values.fields import complaint
from vibopt.values.kinds import Later

if TYPE_CHECKING:
    from vibopt.devices.squeeze_film import SqueezeFilm
else:
    SqueezeFilm = Annotated[Any, Later("vibopt.devices", "squeeze_film.SqueezeFilm")]

_STIFF, _DAMP = COEFFICIENTS[:4], COEFFICIENTS[4:]
_CROSSED = ("k_yz", "k_zy", "c_yz", "c_zy")
_EXAMPLE = 'table = [{ speed = "1000 rpm", k_yy = "80 MN/m", k_zz = "120 MN/m" }, ...]'


class BearingRow(Table):
    """One entry of `table`: the coefficients at a speed; what it leaves out is zero.

    Keys
    ----
    speed: Of the rotor: `speed = "3000 rpm"`.
    k_yy: Stiffness along y, across the shaft and level. Not negative.
    k_yz: Force along y, against it, per displacement along z. Of either sign, as `k_zy`.
    k_zy: Force along z, against it, per displacement along y.
    k_zz: Stiffness along z, upward, a quarter turn ahead of y in the sense of the spin.
    c_yy: Damping along y.
    c_yz: Force along y, against it, per velocity along z.
    c_zy: Force along z, against it, per velocity along y.
    c_zz: Damping along z.
    """

    speed: Fact = number("angular_rate", choice=False, sign="not negative", required=True)
    k_yy: Fact | None = number("stiffness", choice=False, sign="not negative")
    k_yz: Fact | None = number("stiffness", choice=False, sign="any")
    k_zy: Fact | None = number("stiffness", choice=False, sign="any")
    k_zz: Fact | None = number("stiffness", choice=False, sign="not negative")
    c_yy: Fact | None = number("damping", choice=False, sign="not negative")
    c_yz: Fact | None = number("damping", choice=False, sign="any")
    c_zy: Fact | None = number("damping", choice=False, sign="any")
    c_zz: Fact | None = number("damping", choice=False, sign="not negative")


def _table(given: object) -> object:
    if isinstance(given, str):
        try:
            given = _of_file(file_of(given))
        except FileFault as fault:
            raise complaint(fault.text) from None
    if not isinstance(given, (list, tuple)) or not all(isinstance(one, (Mapping, BearingRow)) for one in given):
        raise complaint(f"is neither a list of rows nor the name of a CSV file. Write {_EXAMPLE}.")
    return given


def _of_file(file: FilePath) -> list[BearingRow]:
    """Rows of a CSV file, a column "speed [rpm]" and one of each coefficient, "k_yy [N/m]"."""
    try:
        sheet = sheet_of(file)
    except InputError as error:
        raise word(error.messages[0]) from None
    if not sheet.rows:
        raise word(f'{file.name} is empty. Its first row names the columns: "speed [rpm]", "k_yy [N/m]", ...')
    (_, heads), *body = sheet.rows
    columns = [heading_of(head) for head in heads]
    for name, unit in columns:
        if name not in ("speed", *COEFFICIENTS):
            raise word(f'{file.name} has a column "{name}". It may have speed, {", ".join(COEFFICIENTS)}.')
        if not unit:
            raise word(f'{file.name} has a column {name} without a unit. Write it behind: "{name} [rpm]" or "[N/m]".')
    found = []
    for row, cells in body:
        said = {
            name: f"{sheet.number(bare(cell, unit))} {unit}"
            for (name, unit), cell in zip(columns, cells, strict=False)
            if cell
        }
        try:
            found.append(BearingRow.model_validate(said))
        except ValidationError as error:
            one = error.errors()[0]
            key = str(one["loc"][0]) if one["loc"] else "it"
            given = f'"{said[key]}" {one["msg"]}' if key in said else "is not there. Write one."
            raise word(f"{file.name} row {row}: {key} {given}") from None
    return found


Rows = Annotated[
    tuple[BearingRow, ...],
    BeforeValidator(_table),
    WithJsonSchema({"type": ["array", "string"], "description": "rows by speed, or a CSV file of them"}),
]


class BearingTable(Device):
    """`[bearings.NAME]`: what holds a rotor, otherwise across (y, level) than along (z, upward), and couples both.

    The shaft turns from y to z.  A bearing that is alike in both planes is taken as the link that it is.

    Keys
    ----
    between: The two ends: a station or disc, and what it stands on: `between = ["left", "ground"]`, or a body, the
        pedestal, that moves alike in both planes.
    k_yy: Stiffness along y: `k_yy = "80 MN/m"`. It may be chosen, as the next three. One of `k_yy`, `k_zz`, `c_yy`,
        `c_zz` at least, or a `table`.
    k_yz: Force along y, against it, per displacement along z: `k_yz = "-30 MN/m"`. A fact of either sign.
    k_zy: Force along z, against it, per displacement along y.
    k_zz: Stiffness along z.
    c_yy: Damping along y: `c_yy = "200 kN s/m"`. A squeeze-film damper is a bearing of
        damping, and of stiffness if any.
    c_yz: Force along y, against it, per velocity along z.
    c_zy: Force along z, against it, per velocity along y.
    c_zz: Damping along z.
    table: The eight by speed, straight between the rows, instead of single numbers: `table = "bearing.csv"`, or a list
        of rows. Speeds beyond its ends are refused.
    squeeze_film: A squeeze-film damper by its sizes, which may be chosen, instead of `c_yy` and `c_zz`: `squeeze_film =
        { clearance = "0.12 mm", length = "25 mm", diameter = "100 mm", viscosity = "0.012 Pa s" }`. Refused beside a
        table and a tolerance; its numbers have their own.
    tolerance: How far each of the numbers may be off as built, either way: `tolerance = "10 %"`. Refused beside a
        table.
    """

    between: TwoEnds
    k_yy: Value | None = number("stiffness")
    k_yz: Fact | None = number("stiffness", choice=False, sign="any")
    k_zy: Fact | None = number("stiffness", choice=False, sign="any")
    k_zz: Value | None = number("stiffness")
    c_yy: Value | None = number("damping", sign="not negative")
    c_yz: Fact | None = number("damping", choice=False, sign="any")
    c_zy: Fact | None = number("damping", choice=False, sign="any")
    c_zz: Value | None = number("damping", sign="not negative")
    table: Rows | None = None
    squeeze_film: SqueezeFilm | None = None
    tolerance: Tolerance | None = None

    between_points: ClassVar[bool] = True

    @model_validator(mode="after")
    def _consistent(self) -> "BearingTable":
        said = [key for key in COEFFICIENTS if getattr(self, key) is not None]
        if self.squeeze_film is not None:
            both = [key for key in (*_DAMP, "table", "tolerance") if getattr(self, key) is not None]
            if both:
                raise word(f"gives squeeze_film and {both[0]}. Keep one of them.")
            return self
        if self.table is None:
            if not any(key in said for key in ("k_yy", "k_zz", "c_yy", "c_zz")):
                raise word('has neither stiffness nor damping. Write k_yy = "80 MN/m" and k_zz = "120 MN/m".')
            return self
        if said or self.tolerance is not None:
            raise word(f"gives table and {said[0] if said else 'tolerance'}. Keep one of them.")
        if len(self.table) < 2:
            raise word(
                f"has a table of {counted(len(self.table), 'rows')}, and two at least say something of the speeds "
                "between."
            )
        speeds = [row.speed for row in self.table]
        for fact, other in pairwise(speeds):
            if fact.value == other.value:
                raise word(f"has a table with two rows for {_rpm(fact.value)}. Keep one of them.")
            if fact.value > other.value:
                raise word(f"has a table that falls from {_rpm(fact.value)} to {_rpm(other.value)}. Sort its rows.")
        return self

    @property
    def alike(self) -> bool:
        """Whether it is so in both planes, and couples none: a link."""
        crossed = any(getattr(self, key) is not None and getattr(self, key).value for key in _CROSSED)
        pairs = [(getattr(self, f"{one}_yy"), getattr(self, f"{one}_zz")) for one in "kc"]
        same = all(a is b is None or (isinstance(a, Fact) and isinstance(b, Fact) and a.value == b.value
                   and a.tolerance == b.tolerance == 0.0) for a, b in pairs)  # fmt: skip
        return self.table is None and self.tolerance is None and same and not crossed

    @property
    def no_potential(self) -> str:
        """Why its springs have no energy that all whirls at any speed share, in words; "" where they have."""
        if self.table is not None:
            return "changes with the speed"
        yy, yz, zy, zz = (
            0.0 if one is None else one.value if isinstance(one, Fact) else one.low
            for one in (self.k_yy, self.k_yz, self.k_zy, self.k_zz)
        )
        if yz != zy or (yz and self.tolerance is not None):
            return "feeds and brakes what goes round where k_yz is not k_zy"
        return "pushes where k_yz times k_zy is above k_yy times k_zz" if yz and yz * yz >= yy * zz else ""

    @property
    def ends(self) -> tuple[float, float] | None:
        """First and last speed of its table [rad/s]; None without one."""
        return (self.table[0].speed.value, self.table[-1].speed.value) if self.table is not None else None

    @classmethod
    def links_in(cls, name: str, given: Mapping[str, Any]) -> tuple[str, ...]:
        return (name,)

    def joins(self, name: str) -> dict[str, Ends]:
        return {name: self.between}

    def springs(self, name: str) -> tuple[str, ...]:
        rows = self.table or (self,)
        return (name,) if any(getattr(row, key) is not None for row in rows for key in ("k_yy", "k_zz")) else ()

    def several(self, word: str) -> str:
        if self.alike or word not in ("stiffness", "damping"):
            return ""
        key = {"stiffness": "k_yy", "damping": "squeeze_film.clearance" if self.squeeze_film else "c_yy"}[word]
        way = f"every value of {key} that keeps the limits, by find_all, or for " if self.table is None else ""
        return f"says its {word} along y and z apart, which is no one number. Ask for {way}what it does."

    def lacks(self, word: str, alone: bool) -> str:
        """Alike in both planes it has the stiffness and the damping of a link; more is asked of none alone."""
        said = {"stiffness": self.k_yy, "damping": self.squeeze_film or self.c_yy}.get(word)
        return "" if self.alike and said is not None else word

    def parts(self) -> dict[str, str]:
        return {key: key for key in COEFFICIENTS if getattr(self, key) is not None}

    def add_to(self, builder: ModelBuilder, name: str, symbols: Symbols) -> None:
        builder.add_link(name, self.between, Monomial(1.0))
        if self.table is not None:
            speeds = np.array([row.speed.value for row in self.table])
            builder.add_bearing(name, (), speeds, np.array([_eight(row) for row in self.table]))
            return

        def read(key: str) -> Monomial:
            if self.squeeze_film is not None and key in ("c_yy", "c_zz"):
                return self.squeeze_film.damping(f"bearings.{name}.squeeze_film", symbols)
            value: Any = getattr(self, key)
            return symbols.read(f"bearings.{name}.{key}", value) if value is not None else Monomial(0.0)

        if not self.alike:
            builder.add_bearing(name, tuple(read(key) for key in COEFFICIENTS))
            return
        if self.k_yy is not None:
            builder.add_stiffness(name, read("k_yy"))
        if self.c_yy is not None or self.squeeze_film is not None:
            builder.add_damping(name, read("c_yy"))

    def built(self, assembly: Assembly, name: str, numbers: Numbers) -> None:
        """Force of either plane by displacement and velocity in both."""

        def given(key: str) -> float:
            if self.squeeze_film is not None and key in ("c_yy", "c_zz"):
                return self.squeeze_film.built(f"bearings.{name}.squeeze_film", numbers)
            return numbers(f"bearings.{name}.{key}", getattr(self, key))

        if self.alike:
            stiffness = given("k_zz")
            assembly.add_joint(Joint(name, self.between, stiffness, given("c_zz"), 0.0, stiffness, 1.0))
            return
        assembly.add_joint(Joint(name, self.between, 0.0, 0.0, 0.0, 0.0, 1.0))
        speeds, rows = np.zeros(1), [[given(key) for key in COEFFICIENTS]]
        if self.table is not None:
            speeds, rows = np.array([row.speed.value for row in self.table]), [_eight(row) for row in self.table]
        squares = np.array(rows).reshape(-1, 2, 2, 2)
        assembly.bearings[name] = PlaneBearing(self.between, speeds, squares[:, 0], squares[:, 1])


def _eight(row: BearingRow) -> list[float]:
    """Coefficients of a row [SI]."""
    return [getattr(getattr(row, key), "value", 0.0) for key in COEFFICIENTS]


def _rpm(speed: float) -> str:
    return show(speed, "rpm", "angular_rate")
