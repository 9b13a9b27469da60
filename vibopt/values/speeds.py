"""Speeds as a file gives them: one, a list, a range, several ranges; of rotation or of a vehicle."""

from __future__ import annotations

from vibopt.errors import QuantityError
from vibopt.records import dataclass
from vibopt.signals import Band
from vibopt.units import is_range, read_quantity, read_range

ROTATION, VEHICLE = "angular_rate", "velocity"


@dataclass(frozen=True, slots=True)
class SpeedRange:
    """Bands of speeds in SI, their dimension (ROTATION [rad/s] or VEHICLE [m/s]) and the user's unit.

    `asked` marks a range written { from, to }: the speeds are to be found.
    """

    bands: tuple[Band, ...]
    dimension: str
    unit: str
    asked: bool = False

    @property
    def highest(self) -> float:
        return max(band.high for band in self.bands)

    @property
    def is_one_speed(self) -> bool:
        return len(self.bands) == 1 and self.bands[0].is_point


def read_speeds(given: object) -> SpeedRange:
    """Bands of speeds from "3000 rpm", "800..2000 rpm" or a list of such texts.

    Raises
    ------
    QuantityError
        No unit, wrong dimension, reversed range, negative speed, mixed dimensions.
    """
    listed = given if isinstance(given, list) else [given]
    if not listed:
        raise QuantityError('is an empty list. Write a speed, for example "3000 rpm".')
    parts = [_one(item) for item in listed]
    dimensions = {part.dimension for part in parts}
    if len(dimensions) > 1:
        raise QuantityError("mixes speeds of rotation with vehicle speeds. Write all of one kind.")
    bands = tuple(sorted((band for part in parts for band in part.bands), key=lambda band: band.low))
    return SpeedRange(merged(bands), parts[0].dimension, parts[0].unit)


def merged(bands: tuple[Band, ...]) -> tuple[Band, ...]:
    """Overlapping bands joined; bands in ascending order."""
    joined: list[Band] = []
    for band in bands:
        if joined and band.low <= joined[-1].high:
            joined[-1] = Band(joined[-1].low, max(joined[-1].high, band.high))
        else:
            joined.append(band)
    return tuple(joined)


def _one(given: object) -> SpeedRange:
    try:
        return _read(given, ROTATION)
    except QuantityError as error:
        try:
            return _read(given, VEHICLE)
        except QuantityError:
            raise error from None


def _read(given: object, dimension: str) -> SpeedRange:
    if isinstance(given, str) and is_range(given):
        low, high = read_range(given, dimension)
        band, unit = Band(low.value, high.value), high.unit
    else:
        quantity = read_quantity(given, dimension)
        band, unit = Band(quantity.value, quantity.value), quantity.unit
    if band.low < 0.0:
        raise QuantityError(
            "is a negative speed. Write its size: what turns the other way has the other axis in space, and k_yz, "
            "k_zy, c_yz and c_zy of the other sign in bearings; to all else the sense of rotation does not matter."
        )
    return SpeedRange((band,), dimension, unit)
