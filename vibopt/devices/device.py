"""What every family of devices says of itself, so that nobody else must know the families by name."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, ClassVar

from vibopt.devices.symbols import Numbers, Symbols
from vibopt.mechanics.assembly import Assembly
from vibopt.mechanics.builder import ModelBuilder
from vibopt.mechanics.monomial import Monomial
from vibopt.values import Table, Value

if TYPE_CHECKING:
    from vibopt.devices.part import Bound

Ends = tuple[str, str]

OTHER_WAY = {
    "stiffness": 'torsional_stiffness = "40 kN m/rad"',
    "beam": 'torsional_stiffness = "40 kN m/rad"',
    "damping": 'torsional_damping = "20 N m s/rad"',
    "dynamic_to_static": "torsional_stiffness alone",
    "torsional_stiffness": 'stiffness = "200 kN/m"',
    "shaft": 'stiffness = "200 kN/m"',
    "torsional_damping": 'damping = "5 kN s/m"',
}
"""What to write for a key of a spring or damper where its ends move in the other way."""


class Device(Table):
    """A table of a device.

    The class methods read the names off a table of the document, which may have mistakes still.

    may_be_off
        Whether its numbers may have tolerances.
    exchangeable
        Whether two with the same words may exchange their numbers without any effect.
    between_points
        Whether it acts between two points, along the line or about the axis.
    in_space
        What to write instead, or beside, where an end moves in space; "" where it may always end there.
    passes
        Power of the frequency that its force has over relative motion, beyond that of a spring, at high frequencies.
    other_way
        What to write for a key where what it ends at moves in the other way, along a line or about an axis.
    """

    may_be_off: ClassVar[bool] = True
    exchangeable: ClassVar[bool] = False
    between_points: ClassVar[bool] = False
    in_space: ClassVar[str] = ""
    passes: ClassVar[int] = 0
    other_way: ClassVar[Mapping[str, str]] = {}

    @classmethod
    def moving_in(cls, name: str, given: Mapping[str, Any]) -> tuple[str, ...]:
        """Points that move freely, by name: a body is one, a structure may have several."""
        return ()

    @classmethod
    def supports_in(cls, name: str, given: Mapping[str, Any]) -> tuple[str, ...]:
        """Points that move as prescribed."""
        return ()

    @classmethod
    def links_in(cls, name: str, given: Mapping[str, Any]) -> tuple[str, ...]:
        """Names under which a spring and a damper between two points can be asked for."""
        return ()

    @classmethod
    def freedoms_in(cls, name: str, given: Mapping[str, Any]) -> int:
        """Number of free coordinates."""
        return len(cls.moving_in(name, given))

    def joins(self, name: str) -> dict[str, Ends]:
        """Per link its two ends."""
        return {}

    def springs(self, name: str) -> tuple[str, ...]:
        """Links that have a stiffness."""
        return ()

    @property
    def says_line(self) -> str:
        """A key that says that it acts along a line; "" where none does."""
        return ""

    @property
    def says_axis(self) -> str:
        """A key that says that it acts about an axis; "" where none does."""
        return ""

    @property
    def rubs(self) -> bool:
        """Whether it has dry friction."""
        return False

    @property
    def massless(self) -> bool:
        """Whether its name is that of a point without mass, a joint between links."""
        return False

    @property
    def placed(self) -> bool:
        """Whether it stands at a place in space."""
        return False

    @property
    def printed(self) -> Value | None:
        """Tolerance of its stiffness from a catalogue; of different parts it differs."""
        return None

    @property
    def spreads_mass(self) -> bool:
        """Whether it brings its ends a mass of its own."""
        return False

    def several(self, word: str) -> str:
        """Why it has no one number that a response of it alone tells, with the way out; "" where it has."""
        return ""

    def lacks(self, word: str, alone: bool) -> str:
        """What it lacks to be asked for a property, `word` or what that needs; "" where it has it.

        `alone`: no other body than its own moves, so that a ratio refers to that one.
        """
        return "" if getattr(self, word, None) is not None else word

    def parts(self) -> dict[str, str]:
        """What a tolerance of the whole table makes uncertain: names of parts, each with the key that says it."""
        return {}

    def offsets(self) -> dict[str, float]:
        """What may be off by a length, by the end of its path, each with the span of the factor that says it."""
        return {}

    def scattered(self, name: str, path: str) -> tuple[str, ...]:
        """Paths of the numbers that are off by themselves where the one at `path` has a tolerance."""
        return (path,)

    def bound(self, name: str) -> "tuple[Bound, ...]":
        """Parts of a catalogue that are to be chosen."""
        return ()

    def declare(self, builder: ModelBuilder, name: str) -> None:
        """Add coordinates and points; every device does before any adds its terms."""

    def needs(self, name: str) -> set[str]:
        """Points and bodies that must be there before this is built: its ends, and what its ratios refer to."""
        ends = {end for two in self.joins(name).values() for end in two if end != name}
        relative = getattr(self, "relative_to", None)
        return ends | ({relative} if relative else set())

    def add_to(self, builder: ModelBuilder, name: str, symbols: Symbols) -> None:
        """The first route, for optimisers: add the terms to the model."""
        raise NotImplementedError(f"{type(self).__name__} adds nothing to the model")

    def built(self, assembly: Assembly, name: str, numbers: Numbers) -> None:
        """The second route, for the check: add masses and forces as built, from the file's own words."""
        raise NotImplementedError(f"{type(self).__name__} cannot be built")


class OneLink(Device):
    """A device that is a link between two points by its own name, each of its numbers said by one of several keys.

    along, around
        Keys that say that it acts along a line, and about an axis.
    elastic
        Keys that say its stiffness.
    """

    along: ClassVar[tuple[str, ...]] = ()
    around: ClassVar[tuple[str, ...]] = ()
    elastic: ClassVar[tuple[str, ...]] = ()

    def _given(self, keys: tuple[str, ...]) -> list[str]:
        said = vars(self)
        return [key for key in keys if said[key] is not None]

    @property
    def says_line(self) -> str:
        return next(iter(self._given(self.along)), "")

    @property
    def says_axis(self) -> str:
        return next(iter(self._given(self.around)), "")

    @property
    def has_spring(self) -> bool:
        """Whether it has a stiffness."""
        return bool(self._given(self.elastic))

    @property
    def damper(self) -> str:
        """The key that says the viscous damping."""
        return "torsional_damping" if self._given(("torsional_damping",)) else "damping"

    def _damp(
        self, builder: ModelBuilder, name: str, read: Callable[[str], Monomial], symbols: Symbols,
        stiffness: Monomial | None, mass: Monomial | None, many: Monomial,
    ) -> None:  # fmt: skip
        """Its damping, said in one of three ways: `many` dampers, a ratio on a mass, or the loss of its stiffness.

        `read` gives the number of a key.
        """
        if self._given((self.damper,)):
            damping = many * read(self.damper)
            builder.add_damping(name, damping)
            if stiffness is not None and mass is not None:
                builder.ratios[name] = (damping * (stiffness * mass) ** -0.5).times(0.5)
        elif stiffness is not None and mass is not None and self._given(("damping_ratio",)):
            critical = ((stiffness * mass) ** 0.5).times(2.0)
            damping = read("damping_ratio") * symbols.nominal(critical)
            builder.ratios[name] = damping * critical**-1.0 if symbols.factors else read("damping_ratio")
            builder.add_damping(name, damping)
        elif stiffness is not None and self._given(("loss_factor",)):
            builder.add_hysteretic(name, stiffness * read("loss_factor"))

    @classmethod
    def links_in(cls, name: str, given: Mapping[str, Any]) -> tuple[str, ...]:
        return (name,)

    def springs(self, name: str) -> tuple[str, ...]:
        return (name,) if self.has_spring else ()
