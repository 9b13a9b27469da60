"""Turns values of a file into monomials of the design variables."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from vibopt.mechanics.monomial import Monomial
from vibopt.values.fields import Choice, Fact


@dataclass(frozen=True)
class Symbols:
    """Index of each design variable by its path in the file, such as "links.mount.stiffness"."""

    indices: Mapping[str, int]

    def read(self, path: str, value: Fact | Choice) -> Monomial:
        """The fact as a constant, the choice as its variable [SI]."""
        if isinstance(value, Fact):
            return Monomial(value.value)
        return Monomial(1.0, {self.indices[path]: 1.0})
