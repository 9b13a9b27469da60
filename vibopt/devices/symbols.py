"""Values of a file: for the model monomials of the design variables, for the machine as built numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field, replace

from vibopt.mechanics.monomial import Monomial
from vibopt.records import dataclass
from vibopt.values.fields import Choice, Fact


@dataclass(frozen=True)
class Symbols:
    """Index of each design variable by its path in the file, such as "links.mount.stiffness".

    `factors` are the indices, behind those, of the factors by which numbers with a tolerance are off.
    """

    indices: Mapping[str, int]
    factors: Mapping[str, int] = field(default_factory=dict)

    def read(self, path: str, value: Fact | Choice) -> Monomial:
        """The fact as a constant, the choice as its variable [SI]; off by its factor where it has a tolerance."""
        if isinstance(value, Fact):
            return self.off(path, Monomial(value.value))
        return self.off(path, Monomial(1.0, {self.indices[path]: 1.0}))

    def off(self, path: str, value: Monomial) -> Monomial:
        """A value times the factor by which the number or part at `path` is off."""
        return value * Monomial(1.0, {self.factors[path]: 1.0}) if path in self.factors else value

    def nominal(self, value: Monomial) -> Monomial:
        """As said and not as built: what ratios and frequencies of the file refer to."""
        return value.only(len(self.indices)) if self.factors else value


@dataclass(frozen=True)
class Numbers:
    """Values as built: facts as they are unless `chosen` by path [SI], choices as chosen, times the factors `off`."""

    chosen: Mapping[str, float]
    off: Mapping[str, float] = field(default_factory=dict)

    def __call__(self, path: str, value: Fact | Choice | None, default: float = 0.0) -> float:
        """The number at a path, the default where the file says none."""
        if value is None:
            return default
        said = self.chosen[path] if path in self.chosen or isinstance(value, Choice) else value.value
        return said * self.factor(path)

    def factor(self, path: str) -> float:
        """By which the number or part at a path is off."""
        return self.off.get(path, 1.0)

    @property
    def said(self) -> Numbers:
        """The same values as the file says them: what its ratios and frequencies refer to."""
        return replace(self, off={})
