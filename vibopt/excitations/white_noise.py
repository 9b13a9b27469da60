"""White noise: a force on a body, or the acceleration or displacement of a base, of one density at every frequency."""

import re
from typing import Annotated, Any

from vibopt.arrays import FloatArray
from vibopt.errors import QuantityError
from vibopt.excitations.directed import Directed
from vibopt.excitations.excitation import EVERYWHERE
from vibopt.signals import Line, Noise
from vibopt.units import DIMENSIONS, Quantity, read_quantity
from vibopt.values import Fact, SpeedRange
from vibopt.values.fields import CLOSED, ReadBy, complaint

FORCE, ACCELERATION, DISPLACEMENT = "force_density", "acceleration_density", "displacement_density"


def _no_speed(given: object) -> object:
    if isinstance(given, SpeedRange):
        return given
    raise complaint("is a speed, but white noise shakes at every frequency at once. Leave it out.")


def _read(given: object) -> Quantity:
    """A density of force, else one of a motion; what is none of them is told the way out of all."""
    for quantity in (ACCELERATION, DISPLACEMENT):
        try:
            return read_quantity(given, quantity)
        except QuantityError:
            continue
    try:
        return read_quantity(given, FORCE)
    except QuantityError as error:
        kinds = ((FORCE, "of force"), (ACCELERATION, "on a base of acceleration"), (DISPLACEMENT, "or of displacement"))
        units = "; ".join(f"{place}: {', '.join(DIMENSIONS[one].units)}" for one, place in kinds)
        text = str(error).replace(
            'Write a spectral density of force, for example "100 N²/Hz".',
            'Write "100 N²/Hz" for a force, or "0.01 (m/s²)²/Hz" for the acceleration or "0.01 mm²/Hz" for the '
            "displacement of a base.",
        )
        text = re.sub(r"Units of a spectral density of force: .*", f"Units of a spectral density {units}.", text)
        raise complaint(text) from None


def _density(given: object) -> object:
    """A fact, of a force or of a motion by its unit."""
    if isinstance(given, Fact):
        return given
    if isinstance(given, dict):
        raise complaint("is a choice, but this value must be a fact. Write one value.")
    quantity = _read(given)
    if quantity.value <= 0.0:
        raise complaint('is not greater than zero. Write a positive value, for example "100 N²/Hz".')
    return Fact(quantity.value, quantity.unit, quantity.echo)


NoSpeed = Annotated[SpeedRange, ReadBy(_no_speed, CLOSED)]
Density = Annotated[
    Any,
    ReadBy(_density, {"type": "string", "description": "spectral density: 100 N²/Hz, 0.01 (m/s²)²/Hz, 0.01 mm²/Hz"}),
]


class WhiteNoise(Directed):
    """`kind = "white_noise"`: one-sided spectral density, of a force on a body or of a motion of a base.

    Inside, densities are over the angular frequency [N^2 s/rad, (m/s^2)^2 s/rad, m^2 s/rad].

    Keys
    ----
    density: One-sided, per Hz: of the force on a body, of the acceleration or of the displacement of a base:
        `density = "100 N²/Hz"`. A fact.
    """

    density: Density
    speed: NoSpeed = EVERYWHERE
    inherent = True
    sort = "random"

    @property
    def quantity(self) -> str:
        """Dimension of the density, by its unit."""
        for quantity in (ACCELERATION, DISPLACEMENT):
            try:
                read_quantity(f"1 {self.density.unit}", quantity)
            except QuantityError:
                continue
            return quantity
        return FORCE

    @property
    def displaced(self) -> bool:
        """Whether the displacement of a base is the noise."""
        return self.quantity == DISPLACEMENT

    @property
    def family(self) -> str:  # type: ignore[override]  # only the unit tells force from motion
        """Where it acts: a force on bodies, a motion on bases."""
        return "bodies" if self.quantity == FORCE else "bases"

    def noise(self, name: str, row: FloatArray) -> Noise:
        return Noise(name, row, self.density.value, self.displaced)

    def lines(self, direction: FloatArray) -> tuple[Line, ...]:
        """None: noise has no lines."""
        return ()
