"""What all excitations have in common: a place, speeds, and how the amplitude varies with speed."""

import math
from collections.abc import Mapping
from functools import lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
from pydantic import field_validator

from vibopt.arrays import FloatArray
from vibopt.errors import QuantityError
from vibopt.signals import Amplitude, Band, Line, Noise, Piece, Segment, Sort
from vibopt.units import read_quantity, reads
from vibopt.values import SpeedRange, Table, read_speeds
from vibopt.values.fields import CLOSED, ReadBy, complaint
from vibopt.values.speeds import ROTATION

if TYPE_CHECKING:
    from vibopt.excitations.run_up import RunUpTable

POWERS = {"constant": 0, "speed": 1, "speed^2": 2}
_EVER = 1e15


def _speeds(given: object) -> object:
    if isinstance(given, SpeedRange):
        return given
    try:
        if isinstance(given, dict):
            return _unknown_speed(given)
        return read_speeds(given)
    except QuantityError as error:
        raise complaint(str(error)) from None


def _unknown_speed(given: dict[str, object]) -> SpeedRange:
    """{ from, to } for a speed: a range whose speeds `find_all` looks for."""
    unknown = [key for key in given if key not in ("from", "to")]
    if unknown or not given:
        if "tolerance" in given:
            raise QuantityError('has a tolerance, but a speed has none. Write every speed: "2900..3100 rpm".')
        raise QuantityError('is no range of speeds. Write { from = "0 rpm", to = "3000 rpm" }.')
    low = read_speeds(given["from"]) if "from" in given else None
    high = read_speeds(given["to"]) if "to" in given else None
    some = high or low
    if some is None or (low is not None and high is not None and low.dimension != high.dimension):
        raise QuantityError("mixes speeds of rotation with vehicle speeds. Write both ends of one kind.")
    ends = (low.bands[0].low if low else 0.0, high.bands[-1].high if high else math.inf)
    if ends[0] >= ends[1]:
        raise QuantityError("is an empty or reversed range. Write the lower speed first.")
    return SpeedRange((Band(*ends),), some.dimension, some.unit, asked=True)


Speeds = Annotated[SpeedRange, ReadBy(_speeds, {"description": 'speed, list or range, for example "800..2000 rpm"'})]


def _no_speed(given: object) -> object:
    if isinstance(given, SpeedRange):
        return given
    raise complaint("is a speed, but this kind of excitation has none. Leave it out.")


NoSpeed = Annotated[SpeedRange, ReadBy(_no_speed, CLOSED)]
EVERYWHERE = SpeedRange((Band(0.0, math.inf),), ROTATION, "Hz")


def _one_speed(given: object) -> object:
    speeds = _speeds(given)
    if isinstance(speeds, SpeedRange) and not speeds.is_one_speed:
        raise complaint('is a range, but one speed is needed here. Write "2000 rpm".')
    return speeds


OneSpeed = Annotated[SpeedRange, ReadBy(_one_speed, {"type": "string", "description": 'one speed, "2000 rpm"'})]


def _varies(given: object) -> object:
    if isinstance(given, Amplitude):
        return given
    if isinstance(given, str):
        if given.replace("²", "^2").replace("**", "^") in POWERS:
            return given.replace("²", "^2").replace("**", "^")
        raise complaint(
            'is not a way of varying that vibopt knows. Write "constant", "speed", "speed^2" '
            'or a table [["0 rpm", 0.0], ["3000 rpm", 1.0]].'
        )
    return _varies_table(given)


def _varies_table(given: object) -> Amplitude:
    rows = given if isinstance(given, list) else []
    if len(rows) < 2 or not all(isinstance(row, list) and len(row) == 2 for row in rows):
        raise complaint(
            'is not a table of at least two rows [speed, factor]. Write [["0 rpm", 0.0], ["3000 rpm", 1.0]].'
        )
    try:
        speeds = [read_speeds(row[0]) for row in rows]
        factors = [read_quantity(row[1], "ratio").value for row in rows]
    except QuantityError as error:
        raise complaint(f"has a row that cannot be read: it {error}") from None
    if any(speed.dimension != ROTATION or not speed.is_one_speed for speed in speeds):
        raise complaint('has a row without one speed of rotation. Write each row as ["1500 rpm", 0.4].')
    if min(factors) < 0.0:
        raise complaint("has a factor below zero, and an amplitude is its size. Write factors of zero or more.")
    return straight_between([speed.bands[0].low for speed in speeds], factors)


def straight_between(speeds: list[float], values: list[float]) -> Amplitude:
    """Values at speeds [rad/s] that must rise from row to row, and straight lines between them."""
    if len(set(speeds)) < len(speeds):
        raise complaint("has two rows of one speed. Keep one row of each speed.")
    if any(b <= a for a, b in pairwise(speeds)):
        raise complaint("has speeds that do not rise from row to row. Sort the rows by speed.")
    pieces = []
    for (a, b), (first, last) in zip(pairwise(speeds), pairwise(values), strict=True):
        slope = (last - first) / (b - a)
        pieces.append(Piece(Band(a, b), first - slope * a, slope))
    return Amplitude(tuple(pieces))


Varies = Annotated[
    Any,
    ReadBy(_varies, {"anyOf": [{"enum": list(POWERS)}, {"type": "array", "description": "rows [speed, factor]"}]}),
]


class Meant(Table):
    """Whose amplitude may be meant as that of another kind.

    instead
        What it then is, and the kind for it.
    """

    instead: ClassVar[tuple[str, str]]

    @field_validator("amplitude", mode="before", check_fields=False)
    @classmethod
    def _of_its_kind(cls, given: Any) -> Any:
        dimension, kind = cls.instead
        if reads(given, dimension):
            raise complaint(f'is a {dimension}. For {dimension}s write kind = "{kind}".')
        return given


class Excitation(Table):
    """Common words of `[excitations.NAME]`.

    Subclasses say where they act and give their lines.

    family
        Where it acts: "bodies", as a force, or "bases", as a motion.
    sort
        "steady", "random", or "transient": the last two have no speed at all.
    of_vehicle, inherent
        Whether its speed is that of a vehicle; its amplitude is known at every speed.
    moment
        Of a moment, which acts on what turns, the kind that is its like along a line; "" of all others.

    Keys
    ----
    kind: What shakes; the name of this page.
    on: The body (or point) that it acts on; a motion or a road acts on a base: `on = "press"`.
    speed: Its own speeds: one, a list, a range, a list of ranges; rpm, cpm, Hz and rad/s are all angular rates:
        `speed = "800..2000 rpm"`. Of a road the speed of the vehicle; white noise has none.
    """

    kind: str
    on: str
    speed: Speeds
    family: ClassVar[str] = "bodies"
    of_vehicle: ClassVar[bool] = False
    inherent: ClassVar[bool] = False
    sort: ClassVar[Sort] = "steady"
    moment: ClassVar[str] = ""

    @property
    def ramp(self) -> "RunUpTable | None":
        """`run_up` as read: how its speed rises or falls; None where the file does not say."""
        return getattr(self, "run_up", None)

    @property
    def sorts(self) -> tuple[Sort, ...]:
        """What may be asked about it: what runs up comes once, too."""
        return (self.sort, "transient") if self.ramp is not None or self.once is not None else (self.sort,)

    @property
    def once(self) -> "Once | None":
        """What of it comes once, from rest: itself, or the vibration that begins suddenly."""
        return None

    @property
    def remark(self) -> str:
        """What to know of it beside every answer; "" of most."""
        return ""

    @property
    def swung(self) -> float:
        """What a change of its speed adds to its force, a quarter turn behind, per change [N s^2]: of an unbalance."""
        return 0.0

    @property
    def variation(self) -> str | Amplitude | None:
        """`varies` as read; None where the file does not say."""
        return getattr(self, "varies", None)

    def own_bands(self) -> tuple[Band, ...]:
        """Own speeds of the excitation [rad/s]."""
        return tuple(self.to_rotation(band) for band in self.speed.bands)

    def to_rotation(self, band: Band) -> Band:
        """A band in the unit of `speed` as angular rates [rad/s]."""
        return band

    def from_rotation(self, omega: float) -> float:
        """The speed, as the file counts it [SI], that belongs to `omega` [rad/s]."""
        return omega

    @property
    def acts(self) -> dict[str, complex]:
        """Rows of the model that it acts on, by name, each with its complex part of the amplitude."""
        return {self.on: 1.0}

    @property
    def everywhere(self) -> tuple[str, ...]:
        """Points on which it acts."""
        return (self.on,)

    @property
    def anywhere(self) -> Mapping[str, "Excitation"]:
        """Of what may be at any of several points, or in parts at several: itself at each of these; else nothing."""
        return {}

    @property
    def loose(self) -> tuple["Excitation", ...]:
        """Its parts that stand at any angles to each other; itself where none do."""
        return (self,)

    @property
    def direction_known(self) -> bool:
        """Whether it acts in space, in a direction of its own."""
        return list(self.acts) != [self.on]

    @property
    def place(self) -> str:
        """Name of the place where it acts."""
        return self.on

    @property
    def quantity(self) -> str:
        """Of noise the dimension of its density; "" of all others."""
        return ""

    @property
    def displaced(self) -> bool:
        """Whether it is noise, as the displacement of a base."""
        return False

    def noise(self, name: str, row: FloatArray) -> Noise:
        """What random vibration counts of it, which acts along a row over the coordinates (n_coords,)."""
        raise NotImplementedError(f"{type(self).__name__} is no noise")

    def lines(self, direction: FloatArray) -> tuple[Line, ...]:
        """Harmonics of the excitation; `direction` (n_coords,) is the unit row of `on`."""
        raise NotImplementedError

    @property
    def known_bands(self) -> tuple[Band, ...]:
        """Speeds at which the amplitude is known [rad/s]."""
        variation = self.variation
        if isinstance(variation, Amplitude):
            return (Band(variation.pieces[0].band.low, variation.pieces[-1].band.high),)
        if variation is not None or self.inherent:
            return (Band(0.0, _EVER),)
        return self.own_bands()

    def varied(self, amplitude: float, power: int = 0) -> Amplitude:
        """Amplitude against speed: given at its own speed, varied as the file says.

        `power` is the extra power of the frequency by which a velocity or an acceleration
        becomes a displacement (-1, -2).
        """
        variation = self.variation
        if isinstance(variation, Amplitude):
            scaled = [
                Piece(piece.band, piece.constant * amplitude, piece.slope * amplitude, power)
                for piece in variation.pieces
            ]
            return Amplitude(tuple(scaled))
        grows = POWERS[variation] if isinstance(variation, str) else 0
        at = (self._reference() or 1.0) if grows else 1.0
        return _everywhere(amplitude / at**grows, grows + power)

    def _reference(self) -> float:
        """Speed [rad/s] at which the amplitude is given."""
        given: SpeedRange | None = getattr(self, "amplitude_at", None)
        return given.bands[0].low if given is not None else self.own_bands()[0].low

    @property
    def begins_at_rest(self) -> bool:
        """Whether an amplitude that grows with the speed is given at standstill, where it is zero."""
        return self.grows and not self.needs_reference and self._reference() == 0.0

    @property
    def grows(self) -> bool:
        """Whether the amplitude grows with a power of the speed, and so belongs to one."""
        return isinstance(self.variation, str) and POWERS[self.variation] > 0

    @property
    def needs_reference(self) -> bool:
        """Whether the file must say to which speed the amplitude belongs."""
        return self.grows and getattr(self, "amplitude_at", None) is None and not self.speed.is_one_speed


class Once:
    """What comes once: a force on a body [N], or an acceleration of a base [m/s^2], from rest.

    on, family, acts
        Where it acts, as of an excitation.
    """

    if TYPE_CHECKING:
        on: str
        family: ClassVar[str]

        @property
        def acts(self) -> dict[str, complex]: ...

    def segments(self) -> tuple[Segment, ...]:
        """Its signal from the beginning to the end [N] or [m/s^2]; it acts along the row of `on`."""
        raise NotImplementedError

    @property
    def length(self) -> float:
        """How long it lasts [s]."""
        raise NotImplementedError

    @property
    def fastest(self) -> float:
        """About the fastest rate of its signal [rad/s]."""
        return 2.0 * math.pi / min(self.length, 2.0 * self.step)

    @property
    def endless(self) -> bool:
        """Whether it goes on for ever; its length is then that of one turn."""
        return False

    @property
    def holds(self) -> bool:
        """Whether it begins at once and stays at its value for ever."""
        return False

    @property
    def durations(self) -> tuple[float, float] | None:
        """Shortest and longest of a pulse whose duration nobody knows [s], its `length` then the longest."""
        return None

    def lasting(self, duration: float) -> "Once":
        """Of a pulse whose duration nobody knows, the one of such a duration [s]."""
        return self

    @property
    def returns(self) -> bool:
        """Whether the base that it moves stays near the place where it began."""
        return False

    def course(self, time: float) -> tuple[float, float]:
        """Of what `returns`: displacement [m] and velocity [m/s] of its base at a time behind its end [s]."""
        return 0.0, 0.0

    @property
    def blows(self) -> dict[float, float]:
        """Changes of the velocity of a base [m/s] at once, by their times, which are joints [s]."""
        return {}

    @property
    def start(self) -> tuple[float, float]:
        """Displacement [m] and velocity [m/s] with which the body on which it acts begins."""
        return 0.0, 0.0

    def signal(self, time: FloatArray) -> FloatArray:
        """Its value at times [s], shape of `time`; another road than `segments`."""
        raise NotImplementedError

    @property
    def joints(self) -> tuple[float, ...]:
        """Times at which its signal jumps or bends, its beginning and its end among them [s]; of samples the ends."""
        raise NotImplementedError

    @property
    def kinks(self) -> FloatArray:
        """All times at which its signal jumps or bends, samples among them [s]."""
        return np.array(self.joints)

    @property
    def step(self) -> float:
        """Time between its samples [s]; infinite where it has none."""
        return math.inf

    @property
    def straight(self) -> bool:
        """Whether it goes straight from each of its kinks to the next."""
        return False


class Transient(Excitation, Once):
    """An excitation that comes once and is over."""

    speed: NoSpeed = EVERYWHERE
    inherent: ClassVar[bool] = True
    sort: ClassVar[Sort] = "transient"

    @property
    def once(self) -> Once:
        return self

    def lines(self, direction: FloatArray) -> tuple[Line, ...]:
        """None: what comes once has no lines."""
        return ()


@lru_cache(maxsize=256)
def _everywhere(constant: float, power: int) -> Amplitude:
    """The amplitude at every speed; each limit and measure asks for the same one."""
    return Amplitude((Piece(Band(0.0, math.inf), constant, 0.0, power),))


def unit_line(order: float, direction: FloatArray, phase: float, amplitude: Amplitude) -> Line:
    """A line along `direction`, leading by `phase` [rad]."""
    turned = direction * np.exp(1j * phase) if phase else direction.astype(complex)
    return Line(order, turned, amplitude)
