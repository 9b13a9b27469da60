"""Kinds by name; the file of a kind is read when a job names it, for there are many and a job has few."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, MutableMapping
from importlib import import_module
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler, ValidationError
from pydantic_core import CoreSchema, core_schema

if TYPE_CHECKING:
    from vibopt.values.fields import Table

Kind = TypeVar("Kind")


class Kinds(MutableMapping[str, type[Kind]], Generic[Kind]):
    """Classes by the name that a file gives them.

    Parameters
    ----------
    package
        Where their modules are: "vibopt.responses".
    places
        Module in the package and class of each, "motion.Displacement", by name; in the order of the words.
    """

    def __init__(self, package: str, places: Mapping[str, str]) -> None:
        self._package, self._places = package, dict(places)
        self._known: dict[str, type[Kind]] = {}

    def __getitem__(self, name: str) -> type[Kind]:
        if name not in self._known:
            self._known[name] = loaded(self._package, self._places[name])
        return self._known[name]

    def __setitem__(self, name: str, kind: type[Kind]) -> None:
        self._places.setdefault(name, "")
        self._known[name] = kind

    def __delitem__(self, name: str) -> None:
        del self._places[name]
        self._known.pop(name, None)

    def __iter__(self) -> Iterator[str]:
        return iter(self._places)

    def __len__(self) -> int:
        return len(self._places)

    def __contains__(self, name: object) -> bool:
        return name in self._places


def loaded(package: str, place: str) -> Any:
    """The class at a place, "motion.Displacement"."""
    module, _, name = place.partition(".")
    return getattr(import_module(f"{package}.{module}"), name)


class Later:
    """Reads a table within a table by its own kind, whose file is opened when a job has such a table.

    `place` is the module in a package and the class there: "inertia.Shape".
    """

    def __init__(self, package: str, place: str) -> None:
        self.package, self.place = package, place

    @property
    def kind(self) -> type[Table]:
        """The kind of the table."""
        found: type[Table] = loaded(self.package, self.place)
        return found

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self._read)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        kind = self.kind
        kind.model_rebuild()
        return handler(kind.__pydantic_core_schema__)

    def _read(self, given: Any) -> Any:
        try:
            return self.kind.model_validate(given)
        except ValidationError as error:
            raise TableError(error, self.kind) from None


class TableError(ValueError):
    """A table within a table that cannot be read; carries what is wrong, and its kind."""

    def __init__(self, error: ValidationError, kind: type[Table]) -> None:
        super().__init__(str(error))
        self.error, self.kind = error, kind
