"""A rigid body that moves along one line, or turns about one axis."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import model_validator

from vibopt.devices.device import Device
from vibopt.devices.disc import Disc
from vibopt.devices.symbols import Symbols
from vibopt.mechanics.builder import ModelBuilder
from vibopt.mechanics.constants import GRAVITY
from vibopt.mechanics.monomial import Monomial
from vibopt.values import Fact, Table, Value, number, word
from vibopt.values.fields import Choice


class Rolling(Table):
    """`rolling = { inertia, radius }`: the body rolls as it moves, and J / r^2 adds to its mass."""

    inertia: Fact = number("inertia", choice=False, required=True)
    radius: Fact = number("length", choice=False, required=True)

    @property
    def added(self) -> float:
        """What rolling adds to the mass [kg]."""
        return self.inertia.value / self.radius.value**2


class BodyTable(Device):
    """`[bodies.NAME]`: its mass, or its weight on earth; of a body that turns its moment of inertia."""

    mass: Value | None = number("mass")
    weight: Fact | None = number("force", choice=False)
    inertia: Value | None = number("inertia")
    disc: Disc | None = None
    rolling: Rolling | None = None

    @model_validator(mode="after")
    def _one_of_four(self) -> BodyTable:
        given = [key for key in ("mass", "weight", "inertia", "disc") if getattr(self, key) is not None]
        if len(given) > 1 and {"inertia", "disc"} & set(given):
            raise word(
                f"gives {' and '.join(given)}. Keep one: mass for a body that moves along a line, inertia or disc "
                "for one that turns."
            )
        if len(given) != 1:
            raise word('needs either mass or weight. Write mass = "300 kg".')
        if self.rolling is not None and self.turns:
            raise word("turns about its own axis and rolls. Remove rolling, or give its mass.")
        return self

    @property
    def turns(self) -> bool:
        """Whether the body turns instead of moving along a line."""
        return self.inertia is not None or self.disc is not None

    @property
    def quantity(self) -> tuple[str, Fact | Choice]:
        """The key that says how heavy it is, and its value: mass [kg] (of a weight too), or inertia [kg m^2]."""
        if self.weight is not None:
            return "mass", Fact(self.weight.value / GRAVITY, "kg")
        if self.disc is not None:
            return "inertia", self.disc.inertia
        if self.inertia is not None:
            return "inertia", self.inertia
        assert self.mass is not None
        return "mass", self.mass

    @classmethod
    def moving_in(cls, name: str, given: Mapping[str, Any]) -> tuple[str, ...]:
        return (name,)

    def declare(self, builder: ModelBuilder, name: str) -> None:
        builder.add_coordinate(name)
        builder.add_point(name, {name: 1.0})

    def add_to(self, builder: ModelBuilder, name: str, symbols: Symbols) -> None:
        key, value = self.quantity
        inertia = symbols.read(f"bodies.{name}.{key}", value)
        builder.add_inertia(name, inertia, weighs=not self.turns)
        builder.turning[name] = self.turns
        whole = inertia
        if self.rolling is not None:
            added = Monomial(self.rolling.added)
            builder.add_inertia(name, added, weighs=False)
            if inertia.exponents:
                return  # the sum is no product of powers
            whole = Monomial(inertia.scale + added.scale)
        builder.masses[name] = whole
