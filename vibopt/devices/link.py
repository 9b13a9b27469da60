"""A link: springs and dampers, alike and in parallel, between two points."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BeforeValidator, model_validator

from vibopt.devices.symbols import Symbols
from vibopt.mechanics.builder import ModelBuilder
from vibopt.mechanics.monomial import Monomial
from vibopt.values import Fact, Table, Value, number, word
from vibopt.values.fields import complaint


def _two_ends(given: object) -> object:
    if not isinstance(given, (list, tuple)) or len(given) != 2 or not all(isinstance(one, str) for one in given):
        raise complaint('is not a pair of names. Write between = ["machine", "ground"].')
    if given[0] == given[1]:
        raise complaint("joins a point with itself. Name two different ends.")
    return tuple(given)


Ends = Annotated[tuple[str, str], BeforeValidator(_two_ends)]


class LinkTable(Table):
    """`[links.NAME]`: stiffness and damping of one single mount, and how many there are."""

    between: Ends
    stiffness: Value | None = number("stiffness")
    damping: Value | None = number("damping", sign="not negative")
    damping_ratio: Value | None = number("ratio", sign="not negative", most=10.0)
    relative_to: str | None = None
    loss_factor: Value | None = number("ratio", sign="not negative", most=10.0)
    count: Value | None = number("count")
    dynamic_to_static: Fact | None = number("ratio", choice=False)

    @model_validator(mode="after")
    def _consistent(self) -> LinkTable:
        if self.stiffness is None and self.damping is None:
            raise word('has neither stiffness nor damping. Write stiffness = "200 kN/m".')
        given = [key for key in ("damping", "damping_ratio", "loss_factor") if getattr(self, key) is not None]
        if len(given) > 1:
            raise word(f"gives {' and '.join(given)}. Keep one: they are three ways to say the damping of one link.")
        needs = [key for key in ("damping_ratio", "loss_factor", "dynamic_to_static") if getattr(self, key) is not None]
        if self.stiffness is None and needs:
            raise word(f"has a {needs[0]} but no stiffness to which it belongs. Add the stiffness.")
        if self.relative_to is not None and self.damping_ratio is None:
            raise word("has relative_to without damping_ratio. Remove it, or give the damping ratio.")
        return self

    def add_to(self, builder: ModelBuilder, name: str, symbols: Symbols, mass: Monomial | None) -> None:
        """Add the terms of the whole group; `mass` [kg] is what the damping ratio refers to."""

        def symbol(key: str) -> Monomial:
            value: Any = getattr(self, key)
            return symbols.read(f"links.{name}.{key}", value)

        many = symbol("count") if self.count is not None else Monomial(1.0)
        builder.add_link(name, self.between, many)
        ratio = self.dynamic_to_static.value if self.dynamic_to_static is not None else 1.0
        if self.stiffness is not None:
            stiffness = many * symbol("stiffness")
            builder.add_stiffness(name, stiffness, 1.0 / ratio)
            if self.loss_factor is not None:
                builder.add_hysteretic(name, stiffness * symbol("loss_factor"))
            if self.damping_ratio is not None and mass is not None:
                builder.ratios[name] = symbol("damping_ratio")
                builder.add_damping(name, (symbol("damping_ratio") * (stiffness * mass) ** 0.5).times(2.0))
        if self.damping is not None:
            damping = many * symbol("damping")
            builder.add_damping(name, damping)
            if self.stiffness is not None and mass is not None:
                builder.ratios[name] = (damping * (stiffness * mass) ** -0.5).times(0.5)
