"""An inerter: a force proportional to the relative acceleration of its two ends (M. C. Smith, 2002)."""

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
from pydantic import model_validator

from vibopt.devices.device import Ends, OneLink
from vibopt.devices.ends import ChosenEnds
from vibopt.devices.symbols import Numbers, Symbols
from vibopt.mechanics.assembly import Assembly
from vibopt.mechanics.builder import ModelBuilder
from vibopt.mechanics.built import Joint
from vibopt.mechanics.monomial import Monomial
from vibopt.values import Tolerance, Value, number, word
from vibopt.values.directions import Direction, Place

_SAID = ("inertance", "mass_ratio", "torsional_inertance")


class InerterTable(OneLink):
    """`[inerters.NAME]`: force over relative acceleration [kg], or moment over angular acceleration [kg m^2].

    As a number, or as the ratio of it to the mass of a body, `relative_to`.  Between bodies in space it stands `at` a
    place and acts along `direction`.

    Keys
    ----
    between: The two ends: `between = ["tmd", "ground"]`; or pairs of which the best is found: `between = { one_of =
        [["machine", "joint"], ["joint", "ground"]] }`.
    inertance: Force over relative acceleration. One of `inertance`, `torsional_inertance`, `mass_ratio`.
    torsional_inertance: Moment over relative angular acceleration, of what turns.
    mass_ratio: Inertance over the mass of `relative_to`, which counts what rolling adds: `mass_ratio = 0.1`.
    relative_to: The body that `mass_ratio` refers to: `relative_to = "deck"`.
    at: Place of an inerter in space: `at = ["0.8 m", "0.4 m", "0 m"]`. Refused along a line.
    direction: Along which it acts in space: `direction = "z"`. Refused along a line.
    tolerance: How far its inertance may be off as built, either way: `tolerance = "5 %"`.
    """

    between: ChosenEnds
    inertance: Value | None = number("mass", sign="not negative")
    torsional_inertance: Value | None = number("inertia", sign="not negative")
    mass_ratio: Value | None = number("ratio", sign="not negative", most=1e6)
    relative_to: str | None = None
    at: Place | None = None
    direction: Direction | None = None
    tolerance: Tolerance | None = None

    along: ClassVar[tuple[str, ...]] = ("inertance",)
    around: ClassVar[tuple[str, ...]] = ("torsional_inertance",)
    between_points: ClassVar[bool] = True
    in_space: ClassVar[str] = 'Say where it stands and which way: at = ["0.5 m", "0 m", "0 m"], direction = "z".'
    exchangeable: ClassVar[bool] = True
    passes: ClassVar[int] = 2
    other_way: ClassVar[Mapping[str, str]] = {
        "inertance": 'torsional_inertance = "2 kg m2"',
        "torsional_inertance": 'inertance = "40 kg"',
    }

    @model_validator(mode="after")
    def _consistent(self) -> "InerterTable":
        said = self._given(_SAID)
        if len(said) != 1:
            raise word('needs one of inertance, mass_ratio and torsional_inertance. Write inertance = "40 kg".')
        if (self.mass_ratio is None) != (self.relative_to is None):
            raise word("needs mass_ratio and relative_to together: the inertance over the mass of which body?")
        if (self.at is None) != (self.direction is None):
            raise word('needs at and direction together: where it stands in space, and which way. Add direction = "z".')
        if self.at is not None and self.torsional_inertance is not None:
            raise word("has torsional_inertance, but stands at a place and acts along a direction. Write inertance.")
        return self

    @property
    def placed(self) -> bool:
        return self.at is not None

    def parts(self) -> dict[str, str]:
        return {key: key for key in self._given(_SAID)}

    def joins(self, name: str) -> dict[str, Ends]:
        return {name: self.between}

    def add_to(self, builder: ModelBuilder, name: str, symbols: Symbols) -> None:
        key = next(iter(self.parts()))
        value: Any = getattr(self, key)
        inertance = symbols.read(f"inerters.{name}.{key}", value)
        if self.relative_to is not None:
            inertance = inertance * symbols.nominal(builder.masses[self.relative_to])
        if self.at is not None:
            builder.add_spring_at(name, self.between, self.at, np.array(self.direction))
        else:
            builder.add_link(name, self.between, Monomial(1.0))
        builder.add_inertance(name, inertance)

    def built(self, assembly: Assembly, name: str, numbers: Numbers) -> None:
        inertance = sum(numbers(f"inerters.{name}.{key}", getattr(self, key)) for key in _SAID)
        if self.relative_to is not None:
            inertance *= assembly.said[self.relative_to]
        if self.at is None:
            assembly.add_joint(Joint(name, self.between, 0.0, 0.0, 0.0, 0.0, 1.0, inertance=inertance))
            return
        from vibopt.mechanics.rigid_parts import Spring3

        none, axes = np.zeros(1), np.array([self.direction])
        force = Spring3(name, self.between, np.array(self.at), axes, none, none, none, inertance=np.array([inertance]))
        assembly.mounts.append(force)
