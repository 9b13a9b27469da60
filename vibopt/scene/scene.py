"""A scene: what is there and what is asked, with every value in SI."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import field
from typing import TYPE_CHECKING, Any, ClassVar, TypeAlias

from vibopt.answer.answer import Answer
from vibopt.devices import FAMILIES, Device
from vibopt.document.locate import Locator
from vibopt.excitations import Excitation
from vibopt.records import cached_property, dataclass
from vibopt.responses import Response
from vibopt.values.fields import Choice

if TYPE_CHECKING:
    from vibopt.devices.absorber import AbsorberTable
    from vibopt.devices.base import BaseTable
    from vibopt.devices.body import BodyTable
    from vibopt.devices.link import LinkTable
    from vibopt.devices.mount import MountTable
    from vibopt.devices.point import PointTable
    from vibopt.devices.rotor import RotorTable
    from vibopt.devices.structure import StructureTable

MAXIMISE, MINIMISE = "maximise", "minimise"
OWN_FIELDS = ("bodies", "bases", "structures", "rotors", "absorbers", "links", "points", "mounts")
"""Families of devices that are fields of a scene; all others are in `others`, and read by name all the same."""


@dataclass(frozen=True, slots=True)
class Variable:
    """A design variable: path in the file, what may be chosen [SI], the user's unit and its dimension."""

    path: str
    choice: Choice
    dimension: str

    @property
    def low(self) -> float:
        return self.choice.low

    @property
    def high(self) -> float:
        return self.choice.high

    @property
    def unit(self) -> str:
        return self.choice.unit

    @property
    def values(self) -> tuple[float, ...] | None:
        """The values to choose from [SI]; None for a continuous variable."""
        if self.choice.options:
            return self.choice.options
        if self.choice.whole:
            return tuple(float(n) for n in range(round(self.low + 0.4999999), int(self.high + 1e-9) + 1))
        return None


@dataclass(frozen=True, slots=True)
class Goal:
    """`sense` is MAXIMISE or MINIMISE; `name` as in the file."""

    sense: str
    name: str
    response: Response


@dataclass(frozen=True)
class Scene:
    """Everything a problem file says.  Build one with `read`, `from_dict` or the Python API.

    `find_all` names the excitation whose speeds are asked for; `notes` are readings and assumptions
    that are repeated in every output.  `asked` is the scene as it was asked, where places left open in it
    have been settled here.  `off` says by which factor numbers and parts of the machine as built differ from
    what the file says, by path.  `others` holds the devices of families without a field of their own, by family.
    """

    kind: ClassVar[str] = "scene"
    name: str
    title: str
    statement: str
    bodies: dict[str, BodyTable]
    bases: dict[str, BaseTable]
    links: dict[str, LinkTable]
    excitations: dict[str, Excitation]
    limits: dict[str, Response]
    measures: dict[str, Response]
    goal: Goal | None
    find_all: str | None
    variables: tuple[Variable, ...]
    expected: tuple[Mapping[str, Any], ...]
    document: Mapping[str, Any]
    notes: tuple[str, ...] = ()
    locator: Locator | None = field(default=None, compare=False, repr=False)
    absorbers: dict[str, AbsorberTable] = field(default_factory=dict)
    structures: dict[str, StructureTable] = field(default_factory=dict)
    rotors: dict[str, RotorTable] = field(default_factory=dict)
    points: dict[str, PointTable] = field(default_factory=dict)
    mounts: dict[str, MountTable] = field(default_factory=dict)
    asked: Scene | None = field(default=None, compare=False, repr=False)
    off: Mapping[str, float] = field(default_factory=dict)
    others: Mapping[str, Mapping[str, Device]] = field(default_factory=dict)

    if not TYPE_CHECKING:

        def __getattr__(self, family: str) -> Mapping[str, Device]:
            """Tables of a family of devices without a field of its own."""
            if family in FAMILIES:
                return self.others.get(family, {})
            raise AttributeError(f"Scene has no {family}")

    @cached_property
    def responses(self) -> dict[str, Response]:
        """Everything that is asked, by path: limits, measures and the goal."""
        families = ("limits", self.limits), ("measures", self.measures)
        found = {f"{family}.{name}": response for family, every in families for name, response in every.items()}
        return found if self.goal is None or self.goal.response.of_limits else {**found, "goal": self.goal.response}

    @property
    def finds(self) -> str:
        """What `find_all` answers with, "speeds" or "values" of a variable; "" without it."""
        if self.find_all is None:
            return ""
        return "values" if any(variable.path == self.find_all for variable in self.variables) else "speeds"

    @property
    def is_analysis(self) -> bool:
        """Nothing to choose and nothing to find: responses are measured."""
        return not self.variables and self.find_all is None

    def named(self, x: Iterable[float]) -> dict[str, float]:
        """A value of each of its variables [SI], in their order, by path."""
        return {variable.path: float(value) for variable, value in zip(self.variables, x, strict=True)}


Design: TypeAlias = Answer[Scene]
"""The answer to a scene."""
