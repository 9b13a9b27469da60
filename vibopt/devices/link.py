"""A link: springs and dampers, alike and in parallel, between two points."""

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from pydantic import ValidationError, model_validator

from vibopt.devices.device import OTHER_WAY, Ends, OneLink
from vibopt.devices.ends import ChosenEnds
from vibopt.devices.symbols import Numbers, Symbols
from vibopt.mechanics.assembly import Assembly
from vibopt.mechanics.builder import ModelBuilder
from vibopt.mechanics.built import Borne, Joint
from vibopt.mechanics.model import forced, stressed
from vibopt.mechanics.monomial import Monomial
from vibopt.values import Fact, Table, Tolerance, Value, number, word
from vibopt.values.fields import Choice
from vibopt.values.kinds import Later

if TYPE_CHECKING:
    from vibopt.devices.beam import Beam
    from vibopt.devices.part import Bound, Part
    from vibopt.devices.spring import Shaft
else:
    Beam, Part, Shaft = (
        Annotated[Any, Later("vibopt.devices", one)] for one in ("beam.Beam", "part.Part", "spring.Shaft")
    )


_ALONG = ("part", "stiffness", "beam", "damping", "rotating_damping", "friction_force", "dynamic_to_static")
_AROUND = ("torsional_stiffness", "shaft", "torsional_damping")
_SPRINGS = ("stiffness", "torsional_stiffness", "shaft", "beam")
_DAMPERS = ("damping", "torsional_damping", "damping_ratio", "loss_factor")
_TURNING = ("rotating_damping", "rotating_damping_ratio")
_RUBS = "friction_force"


class LinkTable(OneLink):
    """`[links.NAME]`: stiffness and damping of one single mount, and how many there are.

    Keys
    ----
    between: The two ends: bodies, absorbers, bases, points of structures, or "ground": `between = ["press",
        "ground"]`; or pairs of which the best is found: `between = { one_of = [["machine", "joint"], ["joint",
        "ground"]] }`. Ends in space take a mount.
    stiffness: Dynamic stiffness of ONE single mount; `count` of them stand side by side. One of `stiffness`,
        `torsional_stiffness`, `shaft`, `beam`, or a `part`.
    torsional_stiffness: Of one single spring about the axis of what turns.
    shaft: A round shaft instead of a number: `shaft = { length = "1 m", diameter = "50 mm", shear_modulus = "80
        GPa" }`.
    beam: A beam, loaded where it carries: `beam = { kind = "cantilever", length = "2 m", modulus = "207 GPa",
        second_moment = "80 cm4" }`.
    damping: Viscous damping of ONE single mount. One of `damping`, `torsional_damping`, `damping_ratio`,
        `loss_factor`, or none.
    torsional_damping: Viscous, about the axis of what turns.
    damping_ratio: Of the whole group on the mass of one body, c = 2 ζ √(k m): `damping_ratio = 0.08`. Refused
        without a stiffness.
    relative_to: The body whose mass `damping_ratio` refers to; compulsory when several bodies move: `relative_to =
        "press"`.
    loss_factor: Structural damping; steady harmonic vibration only: `loss_factor = 0.1`. Refused with white noise,
        `decay_rate` and free vibration.
    rotating_damping: Viscous damping of ONE that turns with a shaft, as that of its material and of fits on it: it does
        nothing in steady whirl and may make it grow, see `stability_threshold`: `rotating_damping = "40 N s/m"`.
    rotating_damping_ratio: The same of the whole group on the mass of one body, c = 2 ζ √(k m):
        `rotating_damping_ratio = 0.005`.
    friction_force: Dry friction of ONE single mount while it slips, and the most that it holds, coefficient times
        normal force; beside a stiffness and viscous damping, its own or those of other links: `friction_force =
        "120 N"`. Of one body, on one link.
    count: How many identical mounts stand side by side; forces and stiffnesses of the group are so many times those
        of one.
    dynamic_to_static: Dynamic over static stiffness; sag is counted with the static one: `dynamic_to_static = 1.4`.
        A fact.
    tolerance: How far stiffness, damping and friction may be off as built, either way: `tolerance = "20 %"`.
    part: Bought instead of made: `part = { catalogue = "mounts.csv" }`. Refused beside stiffness and damping.
    """

    between: ChosenEnds
    stiffness: Value | None = number("stiffness")
    torsional_stiffness: Value | None = number("torsional_stiffness")
    shaft: Shaft | None = None
    beam: Beam | None = None
    damping: Value | None = number("damping", sign="not negative")
    torsional_damping: Value | None = number("torsional_damping", sign="not negative")
    damping_ratio: Value | None = number("ratio", sign="not negative", most=10.0)
    relative_to: str | None = None
    loss_factor: Value | None = number("ratio", sign="not negative", most=10.0)
    rotating_damping: Value | None = number("damping", sign="not negative")
    rotating_damping_ratio: Value | None = number("ratio", sign="not negative", most=10.0)
    friction_force: Value | None = number("force", sign="not negative")
    count: Value | None = number("count")
    dynamic_to_static: Fact | None = number("ratio", choice=False)
    tolerance: Tolerance | None = None
    part: Part | None = None

    along: ClassVar[tuple[str, ...]] = _ALONG
    around: ClassVar[tuple[str, ...]] = _AROUND
    elastic: ClassVar[tuple[str, ...]] = _SPRINGS
    between_points: ClassVar[bool] = True
    exchangeable: ClassVar[bool] = True
    in_space: ClassVar[str] = "Write [mounts.NAME] with a place."
    other_way: ClassVar[Mapping[str, str]] = OTHER_WAY

    @model_validator(mode="before")
    @classmethod
    def _of_part(cls, given: Any) -> Any:
        """The columns of a part that are keys of a link stand there as if they had been written there."""
        if not isinstance(given, (dict, Mapping)) or given.get("part") is None or isinstance(given["part"], Table):
            return given
        from vibopt.devices.part import DYNAMIC, Part

        for key in (*_SPRINGS, *_DAMPERS, "dynamic_to_static"):
            if key in given:
                raise word(f"gives part and {key}. Keep one: a part brings its stiffness and its damping with it.")
        try:
            part = Part.model_validate(given["part"])
        except ValidationError:  # said where the part itself is read
            return given
        return {**given, **{key: value for key in DYNAMIC if (value := part.column(key)) is not None}}

    @model_validator(mode="after")
    def _consistent(self) -> "LinkTable":
        springs, dampers = self._given(_SPRINGS), self._given(_DAMPERS)
        others = ("damping", "rotating_damping", "torsional_damping", "friction_force")
        if not springs and not self._given(others):
            raise word('has neither stiffness nor damping. Write stiffness = "200 kN/m".')
        if len(springs) > 1:
            raise word(f"gives {' and '.join(springs)}. Keep one: they are ways to say the stiffness of one link.")
        if len(dampers) > 1:
            raise word(f"gives {' and '.join(dampers)}. Keep one: they are three ways to say the damping of one link.")
        turning = self._given(_TURNING)
        if len(turning) > 1:
            raise word(f"gives {' and '.join(turning)}. Keep one: they are two ways to say one damping.")
        along, around = self._given(_ALONG), self._given(_AROUND)
        if along and around:
            raise word(
                f"gives {along[0]}, which is along a line, and {around[0]}, which is about an axis. A link is one or "
                "the other."
            )
        needs = self._given(("damping_ratio", "rotating_damping_ratio", "loss_factor", "dynamic_to_static"))
        if not springs and needs:
            raise word(f"has a {needs[0]} but no stiffness to which it belongs. Add the stiffness.")
        if self.friction_force is not None and self.loss_factor is not None:
            raise word(
                "gives friction_force and loss_factor, which knows harmonic motion only, and a motion that rubs is not "
                "harmonic. Write damping or damping_ratio beside the friction."
            )
        if self.relative_to is not None and self.damping_ratio is None and self.rotating_damping_ratio is None:
            raise word("has relative_to without damping_ratio. Remove it, or give the damping ratio.")
        return self

    @property
    def rubs(self) -> bool:
        return self.friction_force is not None and getattr(self.friction_force, "value", 1.0) != 0.0

    @property
    def spreads_mass(self) -> bool:
        return self.beam is not None and self.beam.heavy

    @property
    def brought(self) -> tuple[str, ...]:
        """Keys that the part has filled in."""
        if self.part is None:
            return ()
        from vibopt.devices.part import DYNAMIC

        return DYNAMIC

    @property
    def printed(self) -> Value | None:
        """Tolerance of the stiffness that the catalogue prints, where the file says none."""
        return self.part.tolerance if self.part is not None and self.tolerance is None else None

    @property
    def static_ratio(self) -> Value | None:
        """Dynamic over static stiffness."""
        return self.dynamic_to_static if self.part is None else self.part.dynamic_to_static

    def bound(self, name: str) -> "tuple[Bound, ...]":
        if self.part is None:
            return ()
        from vibopt.devices.part import DYNAMIC, OWN

        paths = {key: f"links.{name}.{key}" for key in DYNAMIC} | {key: f"links.{name}.part.{key}" for key in OWN}
        found = self.part.bound(f"links.{name}.part", paths)
        return () if found is None else (found,)

    def lacks(self, word: str, alone: bool) -> str:
        viscous = self._given(("damping", "torsional_damping"))
        there = {
            "stiffness": self.has_spring,
            "torsional_stiffness": self.has_spring,
            "damping": self.damping is not None or self.damping_ratio is not None,
            "torsional_damping": self.torsional_damping is not None or self.damping_ratio is not None,
            "damping_ratio": self.damping_ratio is not None or (bool(viscous) and self.has_spring and alone),
            "loss_factor": self.loss_factor is not None,
            "friction_force": self.friction_force is not None,
        }
        if word.endswith("bending_stress"):
            deep = self.beam is not None and self.beam.second_moment is None
            return "" if deep else "beam with a diameter or a height"
        if word == "bearing_force":
            return "" if self.beam is not None else "beam"
        if word == "shear_stress":
            return "" if self.shaft is not None else "shaft"
        return "" if there.get(word, True) else word

    def parts(self) -> dict[str, str]:
        return {key: key for key in self._given((*_SPRINGS, *_DAMPERS, *_TURNING, _RUBS))}

    @property
    def turns_with_shaft(self) -> str:
        """The key of a damping that turns with the shaft; "" without."""
        return next((key for key in self._given(_TURNING) if getattr(getattr(self, key), "value", 1.0) != 0.0), "")

    def joins(self, name: str) -> dict[str, Ends]:
        return {name: self.between}

    def spring(self, name: str, symbols: Symbols) -> Monomial | None:
        """Stiffness of one single mount [N/m] or [N m/rad]; None where there is no spring."""
        bar, path = self._bar(name)
        if bar is not None:
            return symbols.off(path, bar.spring(path, symbols))
        for key in ("stiffness", "torsional_stiffness"):
            value = getattr(self, key)
            if value is not None:
                return symbols.read(f"links.{name}.{key}", value)
        return None

    def _bar(self, name: str) -> "tuple[Beam | Shaft | None, str]":
        """What bends or twists instead of a number, and where it stands in the file."""
        key = "beam" if self.beam is not None else "shaft"
        return getattr(self, key), f"links.{name}.{key}"

    def add_to(self, builder: ModelBuilder, name: str, symbols: Symbols) -> None:
        """Add the terms of the whole group; its damping ratio refers to the mass of one body."""

        def symbol(key: str) -> Monomial:
            value: Any = getattr(self, key)
            return symbols.read(f"links.{name}.{key}", value)

        bodies = builder.families.get("bodies", ())
        mass = builder.masses.get(self.relative_to or (bodies[0] if len(bodies) == 1 else ""))
        many = symbol("count") if self.count is not None else Monomial(1.0)
        builder.add_link(name, self.between, many)
        single = self.spring(name, symbols)
        stiffness = many * single if single is not None else None
        if stiffness is not None:
            self._add_spring(builder, name, symbols, stiffness)
            bar, path = self._bar(name)
            stress = bar.stress(path, symbols) if bar is not None else None
            if stress is not None:
                builder.counts[stressed(name)] = symbols.off(path, stress) ** -1.0
            if self.beam is not None:
                self._add_beam(builder, name, self.beam, symbols)
            if self.rotating_damping_ratio is not None and mass is not None:
                critical = symbols.nominal((stiffness * mass) ** 0.5).times(2.0)
                builder.add_rotating(name, symbol("rotating_damping_ratio") * critical)
        self._damp(builder, name, symbol, symbols, stiffness, mass, many)
        if self.rotating_damping is not None:
            builder.add_rotating(name, many * symbol("rotating_damping"))
        if self.friction_force is not None:
            builder.properties[name, _RUBS] = many * symbol(_RUBS)
            if not self.has_spring and self.damping is None:  # what it carries is read like a damper
                builder.add_damping(name, Monomial(0.0))

    def _add_beam(self, builder: ModelBuilder, name: str, beam: "Beam", symbols: Symbols) -> None:
        """Its mass, of which one part moves as the mean does and one as the shape beside it, and what is read of it."""
        path = f"links.{name}.beam"
        shape, stress = beam.shape, beam.stress(path, symbols)
        mean, square = shape.means
        spread = square - mean**2
        if beam.heavy:
            builder.add_mass_of_beam(name, builder.counts[name] * beam.weight(path, symbols), mean, spread)
        for said, influence in shape.readings(beam.heavy).items():
            point, alone, shaped = shape.read(influence)
            builder.readings[name, said] = -point, -alone, -(shaped - mean * alone) / spread
        if beam.heavy and stress is not None:
            by_force = stress * (beam.spring(path, symbols).times(shape.read(shape.moment)[0])) ** -1.0
            builder.counts[forced(name)] = builder.counts[name] * by_force**-1.0

    def _add_spring(self, builder: ModelBuilder, name: str, symbols: Symbols, stiffness: Monomial) -> None:
        """The stiffness of the group, and under weights alone the static one; of a part its rating and its price."""
        ratio = self.static_ratio
        path = f"links.{name}.dynamic_to_static" if self.part is None else f"links.{name}.part.dynamic_to_static"
        static = stiffness * symbols.read(path, ratio) ** -1.0 if ratio is not None else stiffness
        if isinstance(ratio, Choice):
            builder.add_stiffness(name, stiffness, 0.0)
            builder.add_static_stiffness(name, static)
        else:
            builder.add_stiffness(name, stiffness, static.scale / stiffness.scale)
        if self.part is None:
            return
        builder.properties[name, "static_stiffness"] = static * builder.counts[name] ** -1.0
        for key in ("rated_min", "rated_max", "price"):
            value = getattr(self.part, key)
            if value is not None:
                one = symbols.read(f"links.{name}.part.{key}", value)
                builder.properties[name, key] = one * builder.counts[name] if key == "price" else one

    def built(self, assembly: Assembly, name: str, numbers: Numbers) -> None:
        """The whole group in numbers; a damping ratio refers to stiffness and mass as said."""

        def given(key: str, of: Numbers = numbers, default: float = 0.0) -> float:
            return of(f"links.{name}.{key}", getattr(self, key), default)

        def of_part(key: str, default: float = 0.0) -> float:
            return numbers(f"links.{name}.part.{key}", getattr(self.part, key, None), default)

        relative, count = self.relative_to or assembly.only, given("count", default=1.0)
        single, stress, borne = self._single(name, numbers)
        stiffness = count * single
        damping, ratio = count * (given("damping") + given("torsional_damping")), 0.0  # one of them at most
        rotating = count * given("rotating_damping")
        if relative in assembly.masses and self.has_spring:
            if self.damping_ratio is not None or self.rotating_damping_ratio is not None:
                said = given("count", numbers.said, 1.0) * self._single(name, numbers.said)[0]
                critical = 2.0 * (said * assembly.said[relative]) ** 0.5
                damping = damping + given("damping_ratio") * critical
                rotating = rotating + given("rotating_damping_ratio") * critical
            ratio = damping / (2.0 * (stiffness * assembly.masses[relative]) ** 0.5)
        static = given("dynamic_to_static", default=1.0) if self.part is None else of_part("dynamic_to_static", 1.0)
        joint = Joint(
            name=name,
            ends=self.between,
            stiffness=stiffness,
            damping=damping,
            loss_factor=given("loss_factor"),
            static_stiffness=stiffness / static,
            count=count,
            damping_ratio=ratio,
            price=count * of_part("price"),
            friction=count * given(_RUBS),
            inertance=count * borne.inertance if borne is not None and borne.mass else 0.0,
            stress=stress,
            borne=borne,
            rotating=rotating,
        )
        assembly.add_joint(joint)

    def _single(self, name: str, numbers: Numbers) -> tuple[float, float, Borne | None]:
        """Stiffness of one single mount [N/m] or shaft [N m/rad], stress over stretch or twist, 0 without, and beam."""
        path, off = f"links.{name}.{'shaft' if self.beam is None else 'beam'}", numbers.factor
        if self.beam is not None:
            beam = self.beam.built(path, numbers)
            softer = replace(beam, stress=(beam.stress[0] * off(path), *beam.stress[1:]))
            return beam.stiffness * off(path), softer.stress[0], softer
        if self.shaft is not None:
            stiffness, stress = self.shaft.built(path, numbers)
            return stiffness * off(path), stress * off(path), None
        around = numbers(f"links.{name}.torsional_stiffness", self.torsional_stiffness)
        return numbers(f"links.{name}.stiffness", self.stiffness) + around, 0.0, None  # one of them at most
