"""What all responses have in common: a place, speeds to look at, bounds."""

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal

from pydantic import WithJsonSchema, field_validator, model_validator

from vibopt import forms
from vibopt.arrays import ComplexArray, FloatArray
from vibopt.errors import QuantityError
from vibopt.forms import Form, Modulus
from vibopt.mechanics.built import Course, Motion
from vibopt.mechanics.machine import Machine
from vibopt.mechanics.model import Model
from vibopt.responses.asked_speeds import At, Over
from vibopt.signals import Band, Combine, Drive, Noise, Output, Sort
from vibopt.units import Quantity, read_quantity, to_unit
from vibopt.units.spelling import split_detector
from vibopt.values import Table, word
from vibopt.values.fields import KeyedError, complaint
from vibopt.values.probability import Probability
from vibopt.values.soft import Soft

PLACES = ("into", "through", "of", "across")
_READ = (*PLACES, "direction")
FEW_MODES = 6
"""Lowest modes of a structure that count where all of them are asked for."""

Bound = Annotated[Any, WithJsonSchema({"type": ["string", "number"], "description": "a value with its unit"})]


class Response(Table):
    """A response with its place; `at_most` / `at_least` make it a limit.

    Class attributes of each kind: `dimension` of its value, `amplitude` (pk, pp, rms apply),
    `complement` (the value is one minus the form's value), `less_is_worse` (a measure shows the least), `signed` (the
    value has a sign and is only measured), `unit_without` (in which it is shown where nobody says one).

    names
        Keys that name something, with its family: "body", "link", "joining link" (of two bodies), "point", ...
    moves
        "line" or "axis": it speaks of what moves along one, or about one; "" of either.
    twin, noise_twin, transient_twin
        The same question of what moves in the other way, under white noise, and of what comes once; "" where there is
        none.
    sort
        Of which excitations it speaks.
    in_space
        Asked of a body in space: "direction" or "axis" of a body or point, that must be said; "whole", of a body that
        says so itself; "place" of a body or point; "body" of a body alone; "" not at all.
    of_link
        Whether it is a property of a link.
    of_mount
        Asked of mounts in space: "each" of a group, "axis" of each along its own, "axes" along all three of each,
        "alike" where one answers for the group, "group" of it as a whole; "" not at all.
    other_bound
        What else may bound it, in brackets.
    sags
        Whether it asks for a static deflection, for which springs must carry the weights.
    priced
        Whether it asks what is bought costs.
    against_friction
        Why it is not asked of a machine with dry friction, behind its name; "" where it is.
    sums
        Families whose members that move along a line it adds up; the first is what messages call them.
    refers_to
        Of an absorber: what of the machine it is a ratio to, "mass" or "frequency"; "" of all else.
    of_rotors
        Whether only rotors have it.
    whirls
        Whether it asks for modes of what spins, at the speed of the spin.
    placed
        Of one of the questions that it stands for, where excitations are that may be at several places, by name.
    of_limits
        Whether it is read off the limits, and can only be made best.
    in_planes
        Whether it is told of a whirl that is no circle, as the greater half axis of its ellipse.

    Keys
    ----
    response: What is asked; the name of this page.
    at_most: The greatest value that is allowed; it makes a limit. Refused in a measure, which has no bound.
    at_least: The least value that is allowed.
    unit: How the value of a measure is shown: `unit = "mm/s rms"`. It must fit the response.
    soft: Of a limit, how easily it may be loosened where not all can hold: with `soft = 2` a loosening by 20 % counts
        as one by 10 %. An answer keeps every limit, soft or not.
    with_probability: Of a limit, the share of all machines that shall keep it, where numbers scatter (`tolerance = {
        normal = "2 %" }`): `with_probability = "99 %"`. Without it the limit holds for the worst machine. Refused where
        parts of a catalogue or positions are chosen.
    worst: Of a measure over speeds, mounts or tolerances, which value is shown: `worst = "least"`.
    """

    response: str
    at_most: Bound = None
    at_least: Bound = None
    unit: str | None = None
    soft: Soft = None
    with_probability: Probability = None
    worst: Literal["least", "greatest"] | None = None
    dimension: ClassVar[str] = "ratio"
    amplitude: ClassVar[bool] = False
    complement: ClassVar[bool] = False
    less_is_worse: ClassVar[bool] = False
    harmonic: ClassVar[bool] = False
    sort: ClassVar[Sort] = "steady"
    signed: ClassVar[bool] = False
    unit_without: ClassVar[str] = ""
    names: ClassVar[dict[str, str]] = {}
    moves: ClassVar[str] = ""
    twin: ClassVar[str] = ""
    noise_twin: ClassVar[str] = ""
    transient_twin: ClassVar[str] = ""
    in_space: ClassVar[str] = ""
    of_rotor: ClassVar[bool] = False
    of_link: ClassVar[bool] = False
    of_mount: ClassVar[str] = ""
    other_bound: ClassVar[str] = ""
    sags: ClassVar[bool] = False
    priced: ClassVar[bool] = False
    against_friction: ClassVar[str] = "speaks of linear motion, and what rubs does not move linearly"
    sums: ClassVar[tuple[str, ...]] = ()
    refers_to: ClassVar[str] = ""
    of_rotors: ClassVar[bool] = False
    whirls: ClassVar[bool] = False
    placed: ClassVar[Mapping[str, str]] = {}
    in_planes: ClassVar[bool] = False
    of_limits: ClassVar[bool] = False

    @model_validator(mode="before")
    @classmethod
    def _bounds(cls, given: Any) -> Any:
        if not isinstance(given, dict):
            return given
        cls._check_unit(given.get("unit"))
        return {**given, **cls._read_bounds(given)}

    @classmethod
    def _check_unit(cls, unit: object) -> None:
        """A unit to show the value in must fit it."""
        if not isinstance(unit, str):
            return
        detector = split_detector(unit)[2]
        if detector and not cls.amplitude:
            raise KeyedError(
                "unit", unit, f'says "{detector}", but only an amplitude can be peak, peak-to-peak or rms.'
            )
        try:
            to_unit(1.0, unit, cls.dimension)
        except QuantityError as error:
            raise KeyedError("unit", unit, str(error)) from None

    @classmethod
    def _read_bounds(cls, given: dict[str, Any]) -> dict[str, Quantity]:
        read = {}
        for key in ("at_most", "at_least"):
            if given.get(key) is not None and not isinstance(given[key], Quantity):
                try:
                    if isinstance(given[key], dict) and "tolerance" in given[key]:
                        raise QuantityError("has a tolerance, but a limit has none. Write the value alone.")
                    read[key] = read_quantity(
                        given[key], cls.dimension, amplitude=cls.amplitude, place=str(given.get("response"))
                    )
                except QuantityError as error:
                    raise KeyedError(key, given[key], str(error)) from None
                if read[key].value < 0.0 and not cls.complement:
                    raise KeyedError(key, given[key], "is negative. Write its size, a positive value.")
        return read

    @field_validator("worst", mode="before")
    @classmethod
    def _worst(cls, given: Any) -> Any:
        if given not in (None, "least", "greatest"):
            raise complaint('is neither "least" nor "greatest". Write which value of a measure is the worst.')
        return given

    @property
    def name(self) -> str:
        return self.response

    @property
    def speaks_of(self) -> tuple[Sort, ...]:
        """Sorts of excitations that it counts."""
        return (self.sort,)

    def counts(self, sorts: tuple[Sort, ...]) -> bool:
        """Whether it speaks of an excitation of some sorts."""
        return any(one in sorts for one in self.speaks_of)

    def speaks_for(self, name: str) -> bool:
        """Whether it is read off the limit, or the rating, of this name."""
        return False

    @property
    def worst_side(self) -> str:
        """The side of a bound that its worst value would break first: "at_least" where less is worse."""
        if self.worst is not None:
            return "at_least" if self.worst == "least" else "at_most"
        return "at_least" if self.less_is_worse else "at_most"

    @property
    def modes(self) -> int:
        """How many of the lowest modes of a structure it needs, where nothing says how high to look."""
        return 0

    @property
    def free_vibration(self) -> str:
        """What it asks of free vibration, of which a loss factor says nothing; "" of all else."""
        return ""

    @property
    def spins(self) -> tuple[Band, ...]:
        """Spins of a rotor at which it asks for free whirls [rad/s]; none of all else."""
        return ()

    @property
    def reaches(self) -> tuple[float, ...]:
        """Frequencies up to which the model must be good for it, beside those of excitations and bands [rad/s]."""
        return ()

    @property
    def reading(self) -> "HarmonicResponse | None":
        """The response over speeds whose peaks it speaks of; None of all else."""
        return None

    @property
    def said_of(self) -> str:
        """Of what it speaks, in words, where no place says it."""
        return ""

    @property
    def outside_bands(self) -> tuple[Band, ...]:
        """Bands that no natural frequency may lie in [rad/s]."""
        return ()

    def asked_by(self, side: str) -> "Response":
        """The question that one of its bounds asks: "at_most", "at_least" or "outside"."""
        return self

    @property
    def unbound(self) -> "Response":
        """The question without the values of its bounds, on which no form depends: where it has one, True."""
        return self.model_copy(update={key: getattr(self, key) and True for key in ("at_most", "at_least")})

    @property
    def orders_of(self) -> str:
        """The excitation to whose speeds the orders that it must avoid belong, where these are not known yet."""
        return ""

    def at_orders(self, speeds: tuple[Band, ...]) -> "Response":
        """The same with the orders of these speeds [rad/s] as bands."""
        return self

    def places(self) -> dict[str, tuple[str, str]]:
        """Names used, by key: (name, family), as `names` has them."""
        given = {key: (getattr(self, key), family) for key, family in self.names.items()}
        return {key: place for key, place in given.items() if place[0] is not None}

    def seen_in(self, model: Model) -> Model:
        """The model that it speaks of: of what spins, forward or backward whirl."""
        return model

    def frequencies_of(self, machine: Machine) -> FloatArray:
        """Natural frequencies or critical speeds of the built machine that it speaks of, ascending [rad/s]."""
        return machine.natural_frequencies()

    def form(self, model: Model, drives: tuple[Drive, ...], combine: Combine) -> Form:
        """What the optimiser gets."""
        raise NotImplementedError

    def measure_static(self, machine: Machine) -> float:
        """Value of the built machine, without any excitation; another road than `form`."""
        raise NotImplementedError

    @property
    def absent(self) -> str:
        """What an infinite value is called, which is of nothing; "" where it is a value."""
        return ""

    def looked_to(self, machine: Machine) -> float:
        """Highest value that is searched for; infinite where an infinite one is known to be."""
        return float("inf")


class HarmonicResponse(Response):
    """A response under excitation, at one speed or over all speeds of a range.

    Keys
    ----
    at: Single speeds to look at: `at = "1500 rpm"`. Not beside `over`.
    over: Every speed of a range, "start-up" from rest to the highest own speed, or a table by excitation: `over =
        "0..3000 rpm"`. Without `at` and `over` it is every own speed.
    due_to: Excitations that count; all without it: `due_to = ["fan"]`.
    combine: How several harmonics or excitations add up: "sum" (never too small), "rss", or "peak" (true peak over
        time, one excitation): `combine = "rss"`. Compulsory where there is more than one.
    """

    at: At = None
    over: Over = None
    due_to: tuple[str, ...] | None = None
    combine: str | None = None
    harmonic: ClassVar[bool] = True
    normalised: ClassVar[bool] = False
    doubles: ClassVar[bool] = True
    """Whether it is twice as large under twice the excitation; an energy is four times so."""

    @property
    def rigid_link(self) -> str:
        """The link against whose rigid one it is a ratio; "" where there is none."""
        return ""

    @property
    def ratio_to(self) -> tuple[str, str, str]:
        """Of a ratio: the family on which the excitation must act, why, and the way out."""
        return "", "", ""

    @model_validator(mode="after")
    def _words(self) -> "HarmonicResponse":
        if self.at is not None and self.over is not None:
            raise word("has both at and over. Keep one: at for single speeds, over for ranges.")
        if self.combine is not None and self.combine not in ("sum", "rss", "peak"):
            raise word(f'has combine = "{self.combine}". Write "sum", "rss" or "peak".')
        return self

    def output(self, model: Model) -> Output:
        """The row that reads this response off the motion."""
        raise NotImplementedError

    def form(self, model: Model, drives: tuple[Drive, ...], combine: Combine) -> Form:
        if model.rubbing:
            rubbing = forms.Rubbing if model.n_free == 1 else forms.RubbingOfSeveral
            return rubbing(self.output(model), drives, self.normalised)
        if model.bearings:
            return forms.Orbit(self.output(model), drives, combine)
        return Modulus(self.output(model), drives, combine)

    def beside(self, machine: Machine) -> float:
        """What stands beside its worst amplitude, whatever shakes the built machine, and adds to it."""
        return 0.0

    def trace(self, machine: Machine, course: Course) -> FloatArray:
        """The response of the built machine at the times of a course; another road than `output`."""
        raise NotImplementedError(f"{type(self).__name__} is not followed through time")

    def measure(self, machine: Machine, motion: Motion) -> ComplexArray:
        """Complex amplitude of the built machine in a given motion; another road than `output`."""
        raise NotImplementedError


ReadAs = tuple[str, type[HarmonicResponse]]
"""Name and kind of a response."""


class UnsteadyResponse(Response):
    """The same reading as a response of steady vibration, `steady`, of a motion that is none.

    read_as
        The steady one.
    """

    due_to: tuple[str, ...] | None = None
    read_as: ClassVar[ReadAs]

    @property
    def steady(self) -> HarmonicResponse:
        """The same reading of a steady vibration."""
        name, kind = self.read_as
        return kind(
            response=name, **{key: value for key, value in vars(self).items() if key in _READ and value is not None}
        )

    def places(self) -> dict[str, tuple[str, str]]:
        return self.steady.places()

    def output(self, model: Model) -> Output:
        """The row that reads this response off the motion."""
        return self.steady.output(model)


class RandomResponse(UnsteadyResponse):
    """A response under white noise: the square root of its mean square.

    Independent noises add as mean squares.

    Keys
    ----
    due_to: White noises that count; all without it: `due_to = ["wind"]`.
    """

    sort: ClassVar[Sort] = "random"
    against_friction: ClassVar[str] = "is a root mean square of linear motion, and what rubs does not move linearly"

    @model_validator(mode="before")
    @classmethod
    def _bounds(cls, given: Any) -> Any:
        if not isinstance(given, dict):
            return given
        bare = {key: _without_rms(key, given[key]) for key in ("at_most", "at_least", "unit") if key in given}
        cls._check_unit(bare.get("unit"))
        given = {**given, **bare}
        return {**given, **cls._read_bounds(given)}

    @property
    def modes(self) -> int:
        return FEW_MODES

    def noise_form(self, model: Model, noises: tuple[Noise, ...]) -> Form:
        """What the optimiser gets."""
        return forms.RootMeanSquare(self.output(model), noises)

    def form(self, model: Model, drives: tuple[Drive, ...], combine: Combine) -> Form:
        return self.noise_form(model, ())

    def measure(self, machine: Machine, motion: Motion) -> ComplexArray:
        """Complex amplitude of the built machine in a given harmonic motion; another road than `output`."""
        return self.steady.measure(machine, motion)


class TransientResponse(UnsteadyResponse):
    """Greatest size of a response over all time, under excitations that come once; before, the machine is at rest.

    Several of them begin together and add up as they are.

    Keys
    ----
    due_to: Only these excitations: `due_to = ["shock"]`. Without it all that come once.
    combine: Without it all excitations act together, from one beginning. "sum" takes the greatest of each by itself,
        whatever the time between them, steady ones as they are when they are steady, and adds these up; "rss" is
        the root of the sum of their squares: `combine = "sum"`.
    """

    combine: str | None = None
    sort: ClassVar[Sort] = "transient"
    against_friction: ClassVar[str] = ""

    @model_validator(mode="after")
    def _combined(self) -> "TransientResponse":
        if self.combine not in (None, "sum", "rss"):
            raise word(
                f'has combine = "{self.combine}". Write "sum" or "rss"; without it all act together from one beginning.'
            )
        return self

    @property
    def speaks_of(self) -> tuple[Sort, ...]:
        return (self.sort, "steady") if self.combine is not None else (self.sort,)

    def alone(self, name: str, sorts: tuple[Sort, ...]) -> "HarmonicResponse | TransientResponse":
        """The same of one excitation: in time, or steady where it never begins."""
        if self.sort in sorts:
            return self.model_copy(update={"due_to": (name,), "combine": None})
        return self.steady.model_copy(update={"due_to": (name,), "combine": "sum"})

    @model_validator(mode="before")
    @classmethod
    def _no_speeds(cls, given: Any) -> Any:
        for key in ("over", "at"):
            if isinstance(given, Mapping) and key in given:
                raise word(
                    f"has {key}, but the greatest in time is that of all that comes: the speeds of a run-up are said "
                    "in run_up of its excitation. Leave it out."
                )
        return given

    def trace(self, machine: Machine, course: Course) -> FloatArray:
        """The response of the built machine at the times of a course; another road than `output`."""
        return self.steady.trace(machine, course)


def _without_rms(key: str, given: object) -> object:
    """A value of which "rms" is said once more; peak values are refused, for noise has no peak."""
    if not isinstance(given, str) or isinstance(given, Quantity):
        return given
    bare, detector, said = split_detector(given)
    if detector in ("pk", "pp"):
        raise KeyedError(key, given, f'says "{said}", but random vibration has no peak. Write the rms value.')
    return bare
