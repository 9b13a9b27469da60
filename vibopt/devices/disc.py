"""A solid disc: its moment of inertia about its own axis."""

from __future__ import annotations

from vibopt.values import Fact, Table, number


class Disc(Table):
    """`disc = { mass, diameter }`: J = m d^2 / 8 [kg m^2].

    Keys
    ----
    mass: Its mass.
    diameter: Its diameter; the inertia is m d²/8.
    """

    mass: Fact = number("mass", choice=False, required=True)
    diameter: Fact = number("length", choice=False, required=True)

    @property
    def inertia(self) -> Fact:
        """About the axis of the disc [kg m^2]."""
        return Fact(self.mass.value * self.diameter.value**2 / 8.0, "kg m²")

    @property
    def built(self) -> float:
        """The same from half the mass times the square of the radius, for the machine as built [kg m^2]."""
        return 0.5 * self.mass.value * (0.5 * self.diameter.value) ** 2
