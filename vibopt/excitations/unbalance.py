"""A rotating unbalance on a body."""

import cmath
import math
from collections.abc import Mapping
from typing import Any, ClassVar, Literal

from pydantic import model_validator

from vibopt.arrays import FloatArray
from vibopt.excitations.directed import Directed, RunUp, turned
from vibopt.excitations.excitation import unit_line
from vibopt.signals import Amplitude, Band, Line, Piece
from vibopt.values import Fact, Table, number, word
from vibopt.values.directions import AXES, Direction
from vibopt.values.fields import KeyedError
from vibopt.values.grade import grade_velocity, permissible_unbalance

_OF_A_FORCE = {
    "amplitude": 'is for kind = "force"; an unbalance gives its mass times its distance from the axis. Write unbalance '
    '= "20 kg mm", or kind = "force".',
    "varies": 'is for kind = "force"; the force of an unbalance grows with the square of the speed by its nature. '
    'Leave it out, or write kind = "force" with an amplitude.',
}
"""Keys that only a force has, and why."""


class Further(Table):
    """One entry of `also`: an unbalance on another place of what spins, at an angle to the first.

    Keys
    ----
    on: Body, station or disc on which it is: `on = "turbine"`.
    unbalance: Mass times its distance from the axis: `unbalance = "300 g mm"`.
    angle: How far it stands ahead of the first in the sense of the spin; zero without it: `angle = "120 deg"`.
    """

    on: str
    unbalance: Fact = number("unbalance", choice=False, required=True)
    angle: Fact | None = number("angle", choice=False, sign="any")


class Unbalance(Directed):
    """`kind = "unbalance"`: force m e w^2 [N] peak, by its nature at every speed.

    Keys
    ----
    unbalance: Mass times its distance from the axis: `unbalance = "0.2 kg m"`. One of `unbalance`, `grade`, or
        `rotating_mass` and `radius` together.
    rotating_mass: The mass that is off the axis.
    radius: How far it is off.
    grade: Of a rotor, instead of its unbalance: all that its balance quality grade permits, grade times mass over speed
        (ISO 21940-11): `grade = "2.5 mm/s"`, which "G2.5" means too.
    rotor_mass: The mass that the grade counts; without it that of the rotor, shaft and discs, where no size of it is to
        be chosen.
    service_speed: The speed that the grade counts, the highest in service: `service_speed = "12000 rpm"`. Without it
        `speed`, where that is one.
    or_on: Further stations and discs of a rotor where it may be, in any parts and at any angles: the worst of all is
        answered. `or_on = ["second", "third"]`.
    axis: In space the axis about which it goes round in the right-handed sense: `axis = "x"`. Not beside
        `direction`.
    run_up: How its speed rises or falls, for responses in time: `run_up = { from = "0 rpm", to = "3000 rpm",
        acceleration = "50 rpm/s" }`.
    also: Further unbalances that turn with it, each at its angle: `also = [{ on = "turbine", unbalance = "300 g mm",
        angle = "120 deg" }]`. In steady vibration along a line and of rotors; refused in space, beside `run_up`
        and dry friction, and of ratios.
    angles: Of a rotor, "any" where nobody knows at which angles those in `also` stand: the worst of all is answered.
    """

    unbalance: Fact | None = number("unbalance", choice=False)
    rotating_mass: Fact | None = number("mass", choice=False)
    radius: Fact | None = number("length", choice=False)
    grade: Fact | None = number("velocity", choice=False)
    rotor_mass: Fact | None = number("mass", choice=False)
    service_speed: Fact | None = number("angular_rate", choice=False)
    or_on: tuple[str, ...] = ()
    axis: Direction | None = None
    run_up: RunUp | None = None
    also: tuple[Further, ...] = ()
    angles: Literal["any"] | None = None
    inherent: ClassVar[bool] = True

    @model_validator(mode="before")
    @classmethod
    def _no_force(cls, given: Any) -> Any:
        for key in _OF_A_FORCE if isinstance(given, Mapping) else ():
            if key in given:
                raise KeyedError(key, given[key], _OF_A_FORCE[key])
        if isinstance(given, Mapping) and "grade" in given:
            return {**given, "grade": grade_velocity(given["grade"])}
        return given

    @model_validator(mode="after")
    def _one_of_two(self) -> "Unbalance":
        pair = (self.rotating_mass is not None, self.radius is not None)
        if self.axis is not None and self.direction is not None:
            raise word("gives axis (it rotates about it) and direction (it goes to and fro). Keep one.")
        if (self.unbalance is not None) + (self.grade is not None) + any(pair) != 1 or any(pair) != all(pair):
            raise word('needs either unbalance or both rotating_mass and radius. Write unbalance = "0.2 kg m".')
        counted = next((key for key in ("rotor_mass", "service_speed") if getattr(self, key) is not None), "")
        if self.grade is None and counted:
            raise word(f"gives {counted}, which only a grade counts. Leave it out, or write grade for the unbalance.")
        if self.grade is not None and self.service_speed is None and not self.speed.is_one_speed:
            raise word(
                "gives a grade, and its speed is not one value: which speed does the grade count? Add service_speed = "
                '"12000 rpm", the highest in service.'
            )
        return self

    @model_validator(mode="after")
    def _alone(self) -> "Unbalance":
        beside = next((key for key in ("run_up", "direction", "axis", "at") if getattr(self, key) is not None), "")
        several = "further unbalances (also)" if self.also else "further places (or_on)" if self.or_on else ""
        if several and beside:
            raise word(
                f"has {several} beside {beside}. They are of steady vibration along a line and of rotors: leave one of "
                "the two out."
            )
        if self.also and self.or_on:
            raise word(
                "says where all of it may be (or_on) and what else there is (also). Keep one, or write two excitations."
            )
        if twice := next((one for one in self.or_on if [self.on, *self.or_on].count(one) > 1), ""):
            raise word(f"names {twice} twice among the places where it may be. Name each once.")
        if self.angles is not None and (not self.also or any(one.angle is not None for one in self.also)):
            lacks = "gives angles of some of them" if self.also else "has no further unbalances (also)"
            raise word(f'says angles = "any", and {lacks}. Leave one of the two out.')
        return self

    @property
    def everywhere(self) -> tuple[str, ...]:
        return (self.on, *(one.on for one in self.also), *self.or_on)

    @property
    def anywhere(self) -> dict[str, "Unbalance"]:
        places = (self.on, *self.or_on) if self.or_on else ()
        return {place: self.model_copy(update={"on": place, "or_on": ()}) for place in places}

    @property
    def loose(self) -> tuple["Unbalance", ...]:
        if self.angles is None:
            return (self,)
        own = {"also": (), "angles": None}
        others = (self.model_copy(update={**own, "on": one.on, "unbalance": one.unbalance}) for one in self.also)
        return (self.model_copy(update=own), *others)

    @property
    def direction_known(self) -> bool:
        return not self.also and super().direction_known

    @property
    def product(self) -> float:
        """Mass times eccentricity [kg m]."""
        if self.unbalance is not None:
            return self.unbalance.value
        if self.grade is not None:
            assert self.rotor_mass is not None
            return permissible_unbalance(self.grade.value, self.rotor_mass.value, self.counted_speed)
        assert self.rotating_mass is not None
        assert self.radius is not None
        return self.rotating_mass.value * self.radius.value

    @property
    def counted_speed(self) -> float:
        """Of a grade [rad/s]."""
        return self.service_speed.value if self.service_speed is not None else self.speed.highest

    @property
    def swung(self) -> float:
        return self.product

    @property
    def acts(self) -> dict[str, complex]:
        if self.also:
            found = dict.fromkeys(self.everywhere, 0j)
            found[self.on] += 1.0
            for one in self.also:
                angle = one.angle.value if one.angle is not None else 0.0
                found[one.on] += one.unbalance.value / self.product * cmath.exp(1j * angle)
            return found
        if self.axis is None:
            return super().acts
        first, second = turned(self.axis)
        whole = first - 1j * second
        return {f"{self.place}.{axis}": complex(part) for axis, part in zip(AXES, whole, strict=True) if part}

    def lines(self, direction: FloatArray) -> tuple[Line, ...]:
        amplitude = Amplitude((Piece(Band(0.0, math.inf), self.product, 0.0, 2),))
        return (unit_line(1.0, direction, 0.0, amplitude),)
