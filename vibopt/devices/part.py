"""A part that is bought: one row of a catalogue brings all of its columns at once."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
from pydantic import BeforeValidator, ConfigDict, ValidationInfo, WithJsonSchema, model_validator
from pydantic_core import PydanticCustomError

from vibopt.arrays import FloatArray
from vibopt.errors import InputError, counted, way_out
from vibopt.files.reading import FileFault, file_of
from vibopt.records import dataclass
from vibopt.values import Choice, Fact, Table, Value, number, word
from vibopt.values.fields import complaint

if TYPE_CHECKING:
    from vibopt.values.catalogue import Catalogue

DYNAMIC = ("stiffness", "damping", "loss_factor", "damping_ratio")
"""Columns that are keys of a link as well: they stand there as if they had been written there."""
OWN = ("dynamic_to_static", "rated_min", "rated_max", "price", "tolerance")
"""Columns that stand in the part."""


@dataclass(frozen=True, slots=True)
class Bound:
    """Numbers that take their values together: one row of a table is chosen.

    path
        Of the part in the file, "links.mount.part".
    catalogue
        The parts that may be chosen.
    paths
        Of the numbers that differ from part to part.
    table
        Their values [SI], shape (n_parts, n_paths).
    """

    path: str
    catalogue: Catalogue
    paths: tuple[str, ...]
    table: FloatArray

    @property
    def names(self) -> tuple[str, ...]:
        return self.catalogue.names

    def chosen(self, values: Mapping[str, float]) -> int:
        """Index of the part that has these values, by path; the first of those that are alike."""
        if not self.paths:
            return 0
        wanted = np.array([values[path] for path in self.paths])
        return int(np.abs(self.table - wanted).max(axis=1).argmin())


def sentences(texts: tuple[str, ...]) -> PydanticCustomError:
    """An error of several sentences, each of its own behind `<file> line N: `."""
    return PydanticCustomError("sentences", "{text}", {"text": "\n".join(texts)})


def _headings(given: object) -> object:
    if given is not None and not _are_headings(given):
        raise complaint('is no table of headings. Write { stiffness = "Federrate [N/mm]", note = ["Farbe"] }.')
    return given


def _are_headings(given: object) -> bool:
    """Whether it is a table of texts, or of lists of texts."""
    rows = list(given.values()) if isinstance(given, Mapping) else [None]
    listed = [text for row in rows for text in (row if isinstance(row, list) else [row])]
    return all(isinstance(one, str) for one in listed)


Columns = Annotated[dict[str, str | list[str]], BeforeValidator(_headings)]


def catalogue_of(file: FilePath, columns: Columns | None = None) -> Catalogue:
    """The parts of a file whose columns may have other headings."""
    from vibopt.values.catalogue import catalogue_of as read

    told = {name: (one,) if isinstance(one, str) else tuple(one) for name, one in (columns or {}).items()}
    return read(file, tuple(told.items()))


def _catalogue(given: object, info: ValidationInfo) -> FilePath:
    if isinstance(given, FilePath):
        return given
    if not isinstance(given, str):
        raise complaint('is no file name. Write it in quotation marks: "mounts.csv".')
    try:
        catalogue_of(file := file_of(given), info.data.get("columns"))
    except FileFault as fault:
        raise complaint(fault.text) from None
    except InputError as error:
        raise sentences(error.messages) from None
    return file


CatalogueFile = Annotated[
    FilePath, BeforeValidator(_catalogue), WithJsonSchema({"type": "string", "description": "a CSV file of parts"})
]


def _asked(schema: dict[str, Any]) -> None:
    """Only what a file may say of a part stands in the schema."""
    for key in OWN:
        schema.get("properties", {}).pop(key, None)


class Part(Table):
    """`part = { catalogue = "mounts.csv" }`: a row is chosen; with `name` it is that one, with `only` one of those.

    Keys
    ----
    catalogue: CSV file of parts, beside the problem file: `catalogue = "mounts.csv"`.
    columns: Where its headings are others: what each column holds, by its name here, with the unit where the heading
        has none: `columns = { stiffness = "Federrate [N/mm]", note = ["Farbe", "Lager"] }`.
    name: The one part that it is: `name = "S60-60"`. Without it the best is chosen.
    only: Parts among which to choose: `only = ["S60-60", "R60-55"]`. Not beside `name`.
    """

    printed_in_catalogue: ClassVar[bool] = True
    model_config = ConfigDict(**{**Table.model_config, "json_schema_extra": _asked})

    columns: Columns | None = None
    catalogue: CatalogueFile
    name: str | None = None
    only: list[str] | None = None
    dynamic_to_static: Value | None = number("ratio", choice=False)
    rated_min: Value | None = number("force", choice=False, sign="not negative")
    rated_max: Value | None = number("force", choice=False)
    price: Value | None = number("price", choice=False, sign="not negative")
    tolerance: Value | None = number("ratio", choice=False, sign="not negative")

    @model_validator(mode="before")
    @classmethod
    def _columns(cls, given: Any) -> Any:
        """Put the columns in that belong to the part; what is wrong with the names is said here."""
        if isinstance(given, str):
            raise word(f'is a name without a catalogue. Write part = {{ catalogue = "mounts.csv", name = "{given}" }}.')
        if not isinstance(given, Mapping):
            return given
        for key in OWN:
            if key in given:
                raise word(f"has {key}, but every number comes from the catalogue. Remove it.")
        file = given.get("catalogue")
        if not isinstance(file, (str, FilePath)):
            return given
        told = given.get("columns")
        if not _are_headings(told or {}):
            return given
        try:
            whole = catalogue_of(file_of(file) if isinstance(file, str) else file, told)
        except (FileFault, InputError):
            return given
        parts = among(whole, given)
        return {**given, **{key: value for key in OWN if (value := value_of(parts, key)) is not None}}

    @property
    def parts(self) -> Catalogue:
        """The parts that may be chosen."""
        return among(catalogue_of(self.catalogue, self.columns), {"name": self.name, "only": self.only})

    @property
    def fixed(self) -> bool:
        """Whether there is nothing to choose."""
        return len(self.parts) == 1

    def column(self, key: str) -> Value | None:
        """A column as a fact, or as a choice where the parts differ; None where the catalogue has none."""
        return value_of(self.parts, key)

    def bound(self, path: str, paths: Mapping[str, str]) -> Bound | None:
        """What is chosen together; `paths` are those of the columns in the file.  None where the part is fixed."""
        parts = self.parts
        if len(parts) == 1:
            return None
        keys = [key for key in paths if isinstance(value_of(parts, key), Choice)]
        table = np.array([column_of(parts, key) for key in keys]).reshape(len(keys), len(parts)).T
        return Bound(path, parts, tuple(paths[key] for key in keys), table)


def among(whole: Catalogue, given: Mapping[str, Any]) -> Catalogue:
    """The parts of a catalogue that `name` and `only` leave."""
    name, only = given.get("name"), given.get("only")
    if name is not None and only is not None:
        raise word("has both name and only. Keep one: name fixes the part, only leaves a choice.")
    asked = [name] if name is not None else only
    if asked is None:
        return whole
    if not isinstance(asked, list) or not asked or not all(isinstance(one, str) for one in asked):
        raise word('has a name or only that names no part. Write name = "..." or only = ["...", "..."].')
    for one in asked:
        if one not in whole.names:
            near = way_out(one, whole.names) if len(whole) <= 12 else _near(one, whole)
            raise word(f'names "{one}", which is no part of {whole.file}.{near}')
    return whole.only(tuple(asked))


def _near(name: str, whole: Catalogue) -> str:
    near = way_out(name, whole.names)
    return (
        near if near.startswith(" Did") else f" It has {counted(len(whole), 'parts')}, the first is {whole.names[0]}."
    )


def column_of(parts: Catalogue, key: str) -> FloatArray | None:
    """A column [SI]; that of the ratio of dynamic to static stiffness may come from the two stiffnesses."""
    if key == "dynamic_to_static" and "static_stiffness" in parts.columns:
        ratio: FloatArray = parts.columns["stiffness"] / parts.columns["static_stiffness"]
        return ratio
    if key in ("damping_x", "damping_y") and key not in parts.columns and "damping" in parts.columns:
        across = parts.columns.get(key.replace("damping", "stiffness"))
        if across is not None:  # as much softer across as its stiffness
            derived: FloatArray = parts.columns["damping"] * across / parts.columns["stiffness"]
            return derived
    if key == "rated_min" and key in parts.columns and not parts.columns[key].any():
        return None
    return parts.columns.get(key)


def value_of(parts: Catalogue, key: str) -> Value | None:
    """A column as a fact where all parts have the same, else as a choice."""
    column = column_of(parts, key)
    if column is None:
        return None
    unit = parts.units.get(key, parts.units.get(key[:-2], ""))
    options = tuple(sorted({float(one) for one in column}))
    if len(options) == 1:
        return Fact(options[0], unit)
    return Choice(options[0], options[-1], unit, False, options)
