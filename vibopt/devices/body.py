"""A rigid body that moves along one line."""

from __future__ import annotations

from pydantic import model_validator

from vibopt.devices.symbols import Symbols
from vibopt.mechanics.builder import ModelBuilder
from vibopt.mechanics.constants import GRAVITY
from vibopt.mechanics.monomial import Monomial
from vibopt.values import Fact, Table, Value, number, word
from vibopt.values.fields import Choice


class BodyTable(Table):
    """`[bodies.NAME]`: its mass, or its weight on earth."""

    mass: Value | None = number("mass")
    weight: Fact | None = number("force", choice=False)

    @model_validator(mode="after")
    def _one_of_two(self) -> BodyTable:
        if (self.mass is None) == (self.weight is None):
            raise word('needs either mass or weight. Write mass = "300 kg".')
        return self

    @property
    def inertia(self) -> Fact | Choice:
        """Mass [kg]; a weight is divided by standard gravity."""
        if self.weight is not None:
            return Fact(self.weight.value / GRAVITY, "kg")
        assert self.mass is not None
        return self.mass

    def mass_of(self, name: str, symbols: Symbols) -> Monomial:
        return symbols.read(f"bodies.{name}.mass", self.inertia)

    def add_to(self, builder: ModelBuilder, name: str, symbols: Symbols) -> None:
        builder.add_inertia(name, self.mass_of(name, symbols))
