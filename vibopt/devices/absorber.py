"""An absorber: a small mass on a spring and a damper, tuned to take over the motion of what it sits on."""

import math
from collections.abc import Mapping
from functools import partial
from typing import Annotated, Any, ClassVar

from pydantic import BeforeValidator, WithJsonSchema, model_validator

from vibopt.devices.device import OTHER_WAY, Ends, OneLink
from vibopt.devices.inertia import Disc
from vibopt.devices.spring import Shaft
from vibopt.devices.symbols import Numbers, Symbols
from vibopt.mechanics.assembly import Assembly
from vibopt.mechanics.builder import ModelBuilder
from vibopt.mechanics.built import Joint, Tuned
from vibopt.mechanics.constants import GRAVITY
from vibopt.mechanics.monomial import Monomial
from vibopt.records import dataclass
from vibopt.values import Fact, Tolerance, Value, number, word
from vibopt.values.directions import Direction, Place
from vibopt.values.fields import complaint


@dataclass(frozen=True, slots=True)
class Places:
    """Places of which the best is to be found."""

    names: tuple[str, ...]


def _place(given: object) -> object:
    if isinstance(given, Places) or (isinstance(given, str) and given):
        return given
    if isinstance(given, Mapping) and list(given) == ["one_of"]:
        listed = given["one_of"]
        if isinstance(listed, (list, tuple)) and listed and all(isinstance(one, str) and one for one in listed):
            if len(set(listed)) < len(listed):
                raise complaint("names a place twice. Name each once.")
            return Places(tuple(listed))
    raise complaint(
        'is no place. Write on = "machine", or on = { one_of = ["floor1", "floor2"] } to let vibopt choose.'
    )


On = Annotated[
    str | Places,
    BeforeValidator(_place),
    WithJsonSchema(
        {
            "anyOf": [
                {"type": "string", "description": "what it sits on"},
                {
                    "type": "object",
                    "properties": {"one_of": {"type": "array", "items": {"type": "string"}}},
                    "required": ["one_of"],
                    "additionalProperties": False,
                },
            ]
        }
    ),
]
_MASSES = ("mass", "mass_ratio", "inertia", "disc")
_SPRINGS = ("stiffness", "frequency", "tuning", "length", "torsional_stiffness", "shaft")
_DAMPERS = ("damping", "torsional_damping", "damping_ratio", "loss_factor")
_ALONG = ("mass", "stiffness", "length", "damping")
_AROUND = ("inertia", "disc", "torsional_stiffness", "shaft", "torsional_damping")


class AbsorberTable(OneLink):
    """`[absorbers.NAME]`: its mass, its spring and its damper, each in one of several ways.

    Its name is at once a point (its mass), a link (its spring and damper, from what it sits on to its
    mass) and a body.  In space it slides along `direction` on what it sits on: across that its mass goes with its host
    as a part of it, which adds to what the host has to carry and to turn.

    Keys
    ----
    on: What it sits on, a body, a point of a structure or another absorber: `on = "deck"`; or places of which the best
        is found: `on = { one_of = ["floor1", "floor2"] }`. In space a body, a point of it, or another absorber.
    at: In space its place on the body, from the common origin; without it the centre of mass, or the point that it is
        on: `at = ["0.8 m", "0 m", "0.6 m"]`. Refused along a line.
    direction: In space, which way it slides: `direction = "z"`. Compulsory there, refused along a line.
    mass: Its mass. One of `mass`, `mass_ratio`, `inertia`, `disc`.
    mass_ratio: Its mass over that of what it sits on, or of `relative_to`, which counts what rolling adds:
        `mass_ratio = 0.02`.
    relative_to: The body that `mass_ratio` refers to: `relative_to = "deck"`.
    inertia: Moment of inertia of an absorber that turns.
    disc: A disc that turns, instead of `inertia`: `disc = { mass = "4 kg", diameter = "0.2 m" }`.
    stiffness: Its spring. One of `stiffness`, `frequency`, `tuning`, `length`, `torsional_stiffness`, `shaft`; none
        of them is a Lanchester damper.
    frequency: Own frequency on a host at rest, instead of the stiffness: `frequency = "2 Hz"`.
    tuning: Own frequency over that of the host: mode number `mode` of everything without absorbers, or `tuning_to`:
        `tuning = 0.98`.
    tuning_to: The frequency that `tuning` refers to: `tuning_to = "2 Hz"`. Not beside `mode`.
    mode: Number of the mode that `tuning` refers to, 1 is the lowest: `mode = 1`. Refused without a spring.
    length: Length of a pendulum instead of a spring: `length = "62 mm"`.
    torsional_stiffness: Spring of an absorber that turns.
    shaft: A round shaft as its spring: `shaft = { length = "0.3 m", diameter = "20 mm", shear_modulus = "80 GPa"
        }`.
    damping: Viscous damper. One of `damping`, `torsional_damping`, `damping_ratio`, `loss_factor`, or none.
    torsional_damping: Viscous damper of an absorber that turns.
    damping_ratio: Of its own mass and spring, c = 2 ζ √(k m): `damping_ratio = 0.1`. Refused without a spring.
    loss_factor: Of its own spring; steady vibration only: `loss_factor = 0.1`. Refused without a spring.
    tolerance: How far its mass, its spring and its damper may be off as built, either way: `tolerance = "3 %"`.
    """

    on: On
    at: Place | None = None
    direction: Direction | None = None
    mass: Value | None = number("mass")
    mass_ratio: Value | None = number("ratio", most=1e6)
    relative_to: str | None = None
    inertia: Value | None = number("inertia")
    disc: Disc | None = None
    stiffness: Value | None = number("stiffness")
    frequency: Value | None = number("angular_rate")
    tuning: Value | None = number("ratio", most=1e6)
    tuning_to: Fact | None = number("angular_rate", choice=False)
    mode: int | None = None
    length: Value | None = number("length")
    torsional_stiffness: Value | None = number("torsional_stiffness")
    shaft: Shaft | None = None
    damping: Value | None = number("damping", sign="not negative")
    torsional_damping: Value | None = number("torsional_damping", sign="not negative")
    damping_ratio: Value | None = number("ratio", sign="not negative", most=10.0)
    loss_factor: Value | None = number("ratio", sign="not negative", most=10.0)
    tolerance: Tolerance | None = None

    along: ClassVar[tuple[str, ...]] = _ALONG
    around: ClassVar[tuple[str, ...]] = _AROUND
    elastic: ClassVar[tuple[str, ...]] = _SPRINGS
    exchangeable: ClassVar[bool] = True
    in_space: ClassVar[str] = 'Say which way it slides: direction = "z".'
    other_way: ClassVar[Mapping[str, str]] = {
        **OTHER_WAY,
        "mass": 'inertia = "0.8 kg m2"',
        "length": 'torsional_stiffness = "40 kN m/rad"',
        "inertia": 'mass = "20 kg"',
        "disc": 'mass = "20 kg"',
    }

    @model_validator(mode="after")
    def _consistent(self) -> "AbsorberTable":
        masses, springs, dampers = (self._given(keys) for keys in (_MASSES, _SPRINGS, _DAMPERS))
        if not masses:
            raise word('has no mass. Write mass = "20 kg", or mass_ratio = 0.05 (of what it sits on).')
        for given, what in ((masses, "mass"), (springs, "stiffness"), (dampers, "damping")):
            if len(given) > 1:
                raise word(f"gives {' and '.join(given)}. Keep one: they are ways to say the {what} of one absorber.")
        along, around = self._given(_ALONG), self._given(_AROUND)
        if along and around:
            raise word(
                f"gives {along[0]}, which is along a line, and {around[0]}, which is about an axis. An absorber is "
                "one or the other."
            )
        self._complete(springs, dampers)
        self._check_space(springs)
        return self

    def _complete(self, springs: list[str], dampers: list[str]) -> None:
        if not springs and not dampers:
            raise word(
                'has neither a spring nor a damper. Write frequency = "12 Hz", stiffness = "..." or tuning = 1.0.'
            )
        if not springs and dampers[0] in ("damping_ratio", "loss_factor"):
            raise word(
                f"has a {dampers[0]} but no spring to which it belongs. Add the stiffness, or give the damping in "
                "N s/m."
            )
        for key in ("tuning_to", "mode"):
            if getattr(self, key) is not None and not springs:
                raise word(f"has {key} without a spring to be tuned. Remove it, or give the tuning.")
        if self.tuning_to is not None and self.mode is not None:
            raise word("has tuning_to and mode. Keep one: either says what the tuning refers to.")
        if self.mode is not None and self.mode < 1:
            raise word("has a mode below 1. Modes are counted from 1, the lowest.")

    def _check_space(self, springs: list[str]) -> None:
        if self.direction is None:
            if self.at is not None:
                raise word('has at, but no direction. Say which way it slides: direction = "z".')
            return
        around = self._given(_AROUND)
        if around:
            raise word(
                f"has a direction, along which it slides, and {around[0]}, which is about an axis. Write "
                f"{self.other_way[around[0]]}."
            )
        if not springs:
            raise word(
                "slides along a direction in space without a spring, so that nothing says where it rests. Give it a "
                'spring: frequency = "12 Hz", or a stiffness.'
            )
        if self.length is not None:
            raise word(
                "has a direction, along which it slides, and length, which is of a pendulum. Write its frequency "
                'instead: frequency = "2 Hz".'
            )

    @property
    def placed(self) -> bool:
        return self.direction is not None

    @property
    def host(self) -> str:
        """What it sits on; of several places the first."""
        return self.on if isinstance(self.on, str) else self.on.names[0]

    def lacks(self, word: str, alone: bool) -> str:
        viscous = bool(self._given(("damping", "torsional_damping")))
        if word in ("stiffness", "torsional_stiffness", "own_frequency", "tuning"):
            return "" if self.has_spring else "spring"
        if word in ("damping", "torsional_damping"):
            return "" if viscous or self.damping_ratio is not None else "damping"
        if word.endswith("stress") or word == "bearing_force":
            return word
        there = {
            "damping_ratio": self.damping_ratio is not None or (viscous and self.has_spring),
            "friction_force": False,
            "loss_factor": self.loss_factor is not None,
        }
        return "" if there.get(word, True) else word

    def parts(self) -> dict[str, str]:
        found = {key: key for key in (*self._given(_MASSES), *self._given(_DAMPERS))}
        for key in self._given(_SPRINGS):
            found[key if key in ("stiffness", "torsional_stiffness", "shaft") else "stiffness"] = key
        return found

    @classmethod
    def moving_in(cls, name: str, given: Mapping[str, Any]) -> tuple[str, ...]:
        return (name,)

    def joins(self, name: str) -> dict[str, Ends]:
        return {name: (self.host, name)}

    def declare(self, builder: ModelBuilder, name: str) -> None:
        if self.direction is not None:
            builder.add_slider(name, self.direction)
            return
        builder.add_coordinate(name)
        builder.add_point(name, {name: 1.0})

    def add_to(self, builder: ModelBuilder, name: str, symbols: Symbols) -> None:
        """Add the terms; what it sits on and refers to is known to the builder already."""
        mass = self._mass(builder, name, symbols)
        builder.masses[name] = mass
        builder.turning[name] = builder.turning.get(self.host, False)
        if self.direction is not None:
            builder.add_mass_of_slider(name, mass)
        else:
            builder.add_inertia(name, mass, weighs=not builder.turning[name])
            builder.add_link(name, (self.host, name), Monomial(1.0))
        base = builder.masses.get(self._base(builder, name))
        if base is not None:
            builder.properties[name, "mass_ratio"] = mass * symbols.nominal(base) ** -1.0
        stiffness = self._stiffness(builder, name, symbols, mass)
        if stiffness is not None:
            builder.add_stiffness(name, stiffness)
            own = (stiffness * mass**-1.0) ** 0.5
            builder.properties[name, "own_frequency"] = own
            reference = builder.references.get(name)
            if reference is not None:
                builder.properties[name, "tuning"] = own * reference**-1.0
        read = partial(self._read, name, symbols=symbols)
        self._damp(builder, name, read, symbols, stiffness, mass, Monomial(1.0))

    def _base(self, route: ModelBuilder | Assembly, name: str) -> str:
        """What its mass ratio refers to: of a point in space the body."""
        return self.relative_to or (route.guides[name][0] if self.placed else self.host)

    def _read(self, name: str, key: str, symbols: Symbols) -> Monomial:
        value: Any = getattr(self, key)
        return symbols.read(f"absorbers.{name}.{key}", value)

    def _mass(self, builder: ModelBuilder, name: str, symbols: Symbols) -> Monomial:
        if self.mass_ratio is not None:
            base = symbols.nominal(builder.masses[self._base(builder, name)])
            return self._read(name, "mass_ratio", symbols) * base
        if self.disc is not None:
            return symbols.off(f"absorbers.{name}.disc", Monomial(self.disc.inertia.value))
        return self._read(name, "mass" if self.mass is not None else "inertia", symbols)

    def _stiffness(self, builder: ModelBuilder, name: str, symbols: Symbols, mass: Monomial) -> Monomial | None:
        path, said = f"absorbers.{name}.stiffness", symbols.nominal(mass)
        if self.shaft is not None:
            shaft = f"absorbers.{name}.shaft"
            return symbols.off(shaft, self.shaft.spring(shaft, symbols))
        if self.length is not None:
            return symbols.off(path, (mass * self._read(name, "length", symbols) ** -1.0).times(GRAVITY))
        if self.frequency is not None:
            return symbols.off(path, said * self._read(name, "frequency", symbols) ** 2.0)
        if self.tuning is not None:
            tuned = self._read(name, "tuning", symbols) * builder.references[name]
            return symbols.off(path, said * tuned**2.0)
        for key in ("stiffness", "torsional_stiffness"):
            if getattr(self, key) is not None:
                return self._read(name, key, symbols)
        return None

    def built(self, assembly: Assembly, name: str, numbers: Numbers) -> None:
        """Its mass, its spring and its damper, and what its tuning and its mass ratio refer to."""
        base = assembly.said.get(self._base(assembly, name), 0.0)
        mass, said = (self._heavy(name, of, base) for of in (numbers, numbers.said))
        tuned = Tuned(base, self._tuned_to(assembly))
        stiffness = self._spring(name, numbers, mass, said, tuned.frequency)
        critical = 2.0 * math.sqrt(said * self._spring(name, numbers.said, said, said, tuned.frequency))
        damping = numbers(f"absorbers.{name}.{self.damper}", getattr(self, self.damper))
        damping = damping or numbers(f"absorbers.{name}.damping_ratio", self.damping_ratio) * critical
        assembly.tuned[name] = tuned
        joint = Joint(
            name=name,
            ends=(assembly.guides[name][0] if self.placed else self.host, name),
            stiffness=stiffness,
            damping=damping,
            loss_factor=numbers(f"absorbers.{name}.loss_factor", self.loss_factor),
            static_stiffness=stiffness,
            count=1.0,
            damping_ratio=damping / (2.0 * math.sqrt(stiffness * mass)) if stiffness else 0.0,
        )
        if self.direction is not None:
            assembly.add_slider(joint, self.direction, mass, said)
            return
        hangs = self.host not in assembly.masses or assembly.weights[self.host] > 0.0
        assembly.add_mass(name, mass, mass if hangs else 0.0, said)
        assembly.add_joint(joint)

    def _heavy(self, name: str, numbers: Numbers, base: float) -> float:
        """Its mass or inertia; `base` is what a mass ratio refers to."""
        if self.disc is not None:
            return self.disc.built * numbers.factor(f"absorbers.{name}.disc")
        own = numbers(f"absorbers.{name}.mass", self.mass) or numbers(f"absorbers.{name}.inertia", self.inertia)
        return own or numbers(f"absorbers.{name}.mass_ratio", self.mass_ratio) * base

    def _spring(self, name: str, numbers: Numbers, mass: float, said: float, reference: float) -> float:
        """Its stiffness; a frequency means the mass as said, and a pendulum pulls back with its own weight."""

        def given(key: str) -> float:
            return numbers(f"absorbers.{name}.{key}", getattr(self, key))

        if self.shaft is not None:
            return self.shaft.built(f"absorbers.{name}.shaft", numbers)[0] * numbers.factor(f"absorbers.{name}.shaft")
        if self.stiffness is not None or self.torsional_stiffness is not None:
            return given("stiffness") or given("torsional_stiffness")
        own = given("frequency") or given("tuning") * reference
        pulled = mass * GRAVITY / given("length") if self.length is not None else said * own * own
        return pulled * numbers.factor(f"absorbers.{name}.stiffness")

    def _tuned_to(self, assembly: Assembly) -> float:
        """What its tuning refers to [rad/s]; 0 where there is nothing."""
        if self.tuning_to is not None:
            return self.tuning_to.value
        if self.placed and self.mode is None:
            return 0.0
        found, mode = assembly.alone(), self.mode or 1
        return float(found[mode - 1]) if mode <= len(found) else 0.0
