"""A rigid body that moves along one line, or turns about one axis."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from pydantic import field_validator, model_validator

from vibopt.devices.device import Device
from vibopt.devices.offset import SPAN, add_offset, offset_of
from vibopt.devices.symbols import Numbers, Symbols
from vibopt.errors import QuantityError
from vibopt.mechanics.assembly import Assembly
from vibopt.mechanics.builder import ModelBuilder
from vibopt.mechanics.constants import GRAVITY
from vibopt.mechanics.model import INERTIA
from vibopt.mechanics.monomial import Monomial
from vibopt.units import read_quantity, reads
from vibopt.values import Fact, Table, Tolerance, Value, number, word
from vibopt.values.directions import AXES, SIX, Place, Reach, is_tensor
from vibopt.values.fields import Choice, Rule, RuleSchema, complaint, ruled
from vibopt.values.kinds import Later

if TYPE_CHECKING:
    from vibopt.devices.inertia import Disc, Piece, Principal, Rolling, Shape, Solid, Tensor
    from vibopt.mechanics.rigid_parts import Rigid

    Inertia = Value | Principal | Tensor
else:
    Inertia = Value
    Disc, Piece, Rolling, Shape = (
        Annotated[Any, Later("vibopt.devices", f"inertia.{one}")] for one in ("Disc", "Piece", "Rolling", "Shape")
    )

FREEDOMS: dict[str, tuple[str, ...]] = {"space": ("x", "y", "z", "rx", "ry", "rz"), "plane": ("x", "z", "ry")}
"""Coordinates of a body by the word for its motion; of any other it is the one along its line."""
_SPATIAL = ("centre", "centre_tolerance", "shape", "made_of")


def _is_nothing(given: str, dimension: str) -> bool:
    try:
        return read_quantity(given, dimension).value == 0.0
    except QuantityError:
        return False


class InertiaSchema(RuleSchema):
    """Schema of a moment of inertia, of a list of three or of a tensor by its components."""

    def __call__(self, schema: dict[str, Any]) -> None:
        super().__call__(schema)
        one, moment = dict(schema), {"type": ["string", "number"]}
        schema.clear()
        tensor = {"type": "object", "properties": dict.fromkeys(SIX, moment), "required": list(SIX[:3])}
        three_of = {"type": "array", "items": moment, "minItems": 3, "maxItems": 3}
        schema.update({"anyOf": [one, three_of, {**tensor, "additionalProperties": False}]})


class BodyTable(Device):
    """`[bodies.NAME]`: its mass, or its weight on earth; of a body that turns its moment of inertia.

    Keys
    ----
    mass: Its mass. One of `mass`, `weight`, `inertia`, `disc`, `made_of`. `mass = "0 kg"` is a joint between links,
        as between the spring and the damper of an elastically held damper; springs must hold it.
    weight: Its weight on earth instead of `mass`. A fact.
    inertia: Moment of inertia of a body that turns about one axis, instead of `mass`; in space those about x, y, z
        through the centre of mass, `inertia = ["310 kg m2", "620 kg m2", "590 kg m2"]`, or a table of xx, yy, zz and
        products xy, yz, zx, of which xy is the integral of x y dm. A fact there.
    disc: Instead of `inertia` a round disc: `disc = { mass = "45 kg", diameter = "0.38 m" }`. Refused in space.
    geared_to: The body whose teeth turn this one, so that both turn as one, without play and rigid: `geared_to =
        "pinion"`. It has an inertia and turns about its axis, as the other one does; beside `speed_ratio`. Refused in
        space and along a line.
    speed_ratio: How many times as fast it turns as the body it is geared to, the teeth of that one over its own;
        below zero where it turns the other way: `speed_ratio = -0.25`.
    rolling: What rolls as it moves adds J/r²: `rolling = { inertia = "0.2 kg m2", radius = "0.3 m" }`. A
        `damping_ratio` or `mass_ratio` relative to the body refers to m + J/r², its static deflection to m alone.
        Refused in space and beside `inertia`.
    tolerance: How far each of its numbers may be off as built, either way: `tolerance = "5 %"`.
    motion: "space": x, y, z and three turns; "plane": x, z and the turn about y; "line": along z. Without it three
        inertias, a shape or pieces mean "space".
    centre: Centre of mass of a body in space, from the origin of all places; the origin without it: `centre = ["0.1
        m", "0 m", "0.4 m"]`. Refused along a line.
    centre_tolerance: How far the centre of mass may be off along x, y and z, one length or three: `centre_tolerance
        = "20 mm"`. Refused along a line.
    shape: Instead of `inertia` in space: `shape = { box = ["2.2 m", "1.4 m", "0.5 m"] }`, or a cylinder.
    made_of: Instead of mass, centre and inertia the sum of pieces: `made_of = [{ mass = "90 kg", centre = ["0 m",
        "0 m", "0.1 m"], shape = { box = ["1 m", "1 m", "0.2 m"] } }]`.
    """

    mass: Value | None = number("mass", zero=True)
    weight: Fact | None = number("force", choice=False, tolerance=True)
    inertia: Inertia | None = ruled(InertiaSchema(Rule("inertia", zero=True)))
    disc: Disc | None = None
    geared_to: str | None = None
    speed_ratio: Fact | None = number("ratio", choice=False, sign="any")
    rolling: Rolling | None = None
    tolerance: Tolerance | None = None
    motion: Literal["space", "plane", "line"] | None = None
    centre: Place | None = None
    centre_tolerance: Reach | None = None
    shape: Shape | None = None
    made_of: tuple[Piece, ...] | None = None

    @field_validator("mass", mode="before")
    @classmethod
    def _weighed(cls, given: Any) -> Any:
        if not reads(given, "mass") and reads(given, "force"):
            raise complaint(f'is a force, but a mass is needed here. Write weight = "{given}".')
        return given

    @field_validator("inertia", mode="before")
    @classmethod
    def _tensor(cls, given: Any) -> Any:
        if not isinstance(given, (list, Mapping)):
            return given
        from vibopt.devices.inertia import read_inertia

        return read_inertia(given)

    @field_validator("motion", mode="before")
    @classmethod
    def _motion(cls, given: Any) -> Any:
        if given not in (None, "space", "plane", "line"):
            raise complaint(
                'is no motion that vibopt knows. Write "space", "plane" (x, z and the turn about y) or "line".'
            )
        return given

    @model_validator(mode="after")
    def _whole(self) -> "BodyTable":
        if self.freedoms:
            self._check_space()
        else:
            self._check_line()
        return self

    @property
    def massless(self) -> bool:
        """Whether it is a joint between links, without mass or moment of inertia."""
        return self.moves == "line" and any(
            isinstance(one, Fact) and one.value == 0.0 for one in (self.mass, self.inertia)
        )

    def _check_joint(self) -> None:
        if self.rolling is not None:
            raise word("has no mass and rolls. Give it its mass, or remove rolling.")
        if self.tolerance is not None or any(
            isinstance(one, Fact) and one.tolerance for one in (self.mass, self.inertia)
        ):
            raise word("has no mass that could be off. Remove the tolerance.")

    def _check_space(self) -> None:
        if any(isinstance(one, Fact) and one.value == 0.0 for one in (self.mass, self.inertia)):
            raise word(
                "has no mass, and moves in more ways than one. A joint is of a line: remove motion, or give its mass."
            )
        said = [key for key in ("disc", "rolling", "geared_to") if getattr(self, key) is not None]
        if said:
            raise word(
                f"moves in {'space' if self.moves == 'space' else 'a plane'} and has {said[0]}. Remove {said[0]}."
            )
        if self.made_of is not None:
            doubled = [k for k in ("mass", "weight", "centre", "inertia", "shape") if getattr(self, k) is not None]
            if doubled:
                raise word(f"gives made_of and {doubled[0]}. Keep one: made_of says mass, centre and inertia.")
            if not self.made_of:
                raise word("has an empty made_of. Name its pieces, or give mass and inertia.")
            from vibopt.devices.inertia import tensor_fault

            fault = tensor_fault(self._sum.tensor) if self.moves == "space" else ""
            if fault:
                raise word(f"is made of pieces whose sum {fault}")
        elif (self.mass is None) == (self.weight is None):
            raise word('needs either mass or weight. Write mass = "300 kg".')
        elif (self.inertia is None) == (self.shape is None):
            about = '"620 kg m2" (about y)' if self.moves == "plane" else '["310 kg m2", "620 kg m2", "590 kg m2"]'
            raise word(f"moves in a way that needs one of inertia and shape. Write inertia = {about}.")
        elif self.moves == "space" and isinstance(self.inertia, (Fact, Choice)):
            raise word(
                "moves in space, but its inertia is one value. Write those about x, y, z: inertia = "
                '["310 kg m2", "620 kg m2", "590 kg m2"].'
            )
        elif isinstance(self.inertia, Choice):
            raise word("leaves its inertia open. Give it as a fact; the mass may be chosen.")

    def _check_line(self) -> None:
        for key in _SPATIAL:
            if getattr(self, key) is not None and self.motion is None:
                raise word(f'has a {key}, but no motion that needs it. Add motion = "space", or remove {key}.')
        self._one_of_four()

    def _one_of_four(self) -> "BodyTable":
        given = [key for key in ("mass", "weight", "inertia", "disc") if getattr(self, key) is not None]
        if len(given) > 1 and {"inertia", "disc"} & set(given):
            raise word(
                f"gives {' and '.join(given)}. Keep one: mass for a body that moves along a line, inertia or disc "
                "for one that turns."
            )
        if len(given) != 1:
            raise word('needs either mass or weight. Write mass = "300 kg".')
        if self.rolling is not None and self.turns:
            raise word("turns about its own axis and rolls. Remove rolling, or give its mass.")
        if self.massless:
            self._check_joint()
        if (self.geared_to is None) != (self.speed_ratio is None):
            raise word('needs geared_to and speed_ratio together. Write geared_to = "pinion" and speed_ratio = -0.25.')
        if self.geared_to is not None and not self.turns:
            raise word("moves along a line and is geared. Give it an inertia instead of the mass, or remove geared_to.")
        if self.speed_ratio is not None and self.speed_ratio.value == 0.0:
            raise word("has a speed_ratio of zero, so that it never turns. Write how many times as fast it turns.")
        return self

    @property
    def turns(self) -> bool:
        """Whether the body turns instead of moving along a line."""
        return not self.freedoms and (self.inertia is not None or self.disc is not None)

    @property
    def moves(self) -> str:
        """ "space", "plane" or "line"."""
        if self.motion is not None:
            return self.motion
        spatial = self.shape is not None or self.made_of is not None
        return "space" if spatial or (self.inertia is not None and isinstance(self.inertia, Table)) else "line"

    @property
    def freedoms(self) -> tuple[str, ...]:
        """Coordinates of a body in space or in a plane, by the words behind its name; of any other none."""
        return FREEDOMS.get(self.moves, ())

    @property
    def place(self) -> tuple[float, float, float]:
        """Centre of mass [m]."""
        if self.made_of is not None:
            centre = self._sum.centre
            return float(centre[0]), float(centre[1]), float(centre[2])
        return self.centre or (0.0, 0.0, 0.0)

    @property
    def _sum(self) -> "Solid":
        """Its pieces as one."""
        from vibopt.devices.inertia import together

        assert self.made_of is not None
        return together(self.made_of)

    def solid(self, mass: float) -> "Solid":
        """The body at a mass [kg]: what a shape weighs turns with it, an inertia in numbers does not."""
        if self.made_of is not None:
            return self._sum
        from vibopt.devices.inertia import Solid

        if self.shape is not None:
            return Solid(mass, np.array(self.place), mass * self.shape.per_mass)
        if isinstance(self.inertia, Fact):
            return Solid(mass, np.array(self.place), np.diag([0.0, self.inertia.value, 0.0]))
        assert isinstance(self.inertia, Table)
        return Solid(mass, np.array(self.place), self.inertia.tensor)

    @property
    def reaches(self) -> dict[str, float]:
        """How far the centre of mass may be off along each axis on which it may [m]."""
        wide = zip(AXES, self.centre_tolerance or (0.0, 0.0, 0.0), strict=True)
        return {axis: far for axis, far in wide if far > 0.0}

    def offsets(self) -> dict[str, float]:
        if self.centre_tolerance is None:
            return {}
        return {f"centre.{axis}": SPAN for axis in self.reaches if self.moves == "space" or axis != "y"}

    @property
    def quantity(self) -> tuple[str, Fact | Choice]:
        """The key that says how heavy it is, and its value: mass [kg] (of a weight too), or inertia [kg m^2]."""
        if self.weight is not None:
            return "mass", Fact(self.weight.value / GRAVITY, "kg")
        if self.made_of is not None:
            return "mass", Fact(self._sum.mass, "kg")
        if self.freedoms:
            assert self.mass is not None
            return "mass", self.mass
        if self.disc is not None:
            return "inertia", self.disc.inertia
        if self.inertia is not None:
            assert not isinstance(self.inertia, Table)
            return "inertia", self.inertia
        assert self.mass is not None
        return "mass", self.mass

    def parts(self) -> dict[str, str]:
        keys = ("mass", "weight", "made_of") if self.freedoms else ("mass", "weight", "inertia", "disc")
        key = next(key for key in keys if getattr(self, key) is not None)
        return {key: key, "inertia": "inertia"} if self.freedoms and self.inertia is not None else {key: key}

    @classmethod
    def moving_in(cls, name: str, given: Mapping[str, Any]) -> tuple[str, ...]:
        return (name,)

    @classmethod
    def freedoms_in(cls, name: str, given: Mapping[str, Any]) -> int:
        motion, inertia = given.get("motion"), given.get("inertia")
        whole = is_tensor(inertia)
        if any(isinstance(given.get(key), str) and _is_nothing(given[key], key) for key in ("mass", "inertia")):
            return 0
        if "geared_to" in given:
            return 0
        if motion is None and (whole or "shape" in given or "made_of" in given):
            motion = "space"
        return len(FREEDOMS.get(str(motion), (name,)))

    def declare(self, builder: ModelBuilder, name: str) -> None:
        if self.freedoms:
            builder.add_frame(name, self.place, self.freedoms)
            return
        if self.geared_to is not None and self.speed_ratio is not None:
            builder.add_gear(name, self.geared_to, self.speed_ratio.value)
            return
        builder.add_coordinate(name)
        builder.add_point(name, {name: 1.0})

    def add_to(self, builder: ModelBuilder, name: str, symbols: Symbols) -> None:
        key, value = self.quantity
        said = next(iter(self.parts()))
        inertia = symbols.read(f"bodies.{name}.{key}", value)
        if said != key:
            inertia = symbols.off(f"bodies.{name}.{said}", inertia)
        if self.freedoms:
            self._add_in_space(builder, name, inertia, symbols)
            return
        if self.massless:
            builder.turning[name] = self.turns
            return
        builder.add_inertia(name, inertia, weighs=not self.turns)
        builder.turning[name] = self.turns
        whole = inertia
        if self.rolling is not None:
            added = Monomial(self.rolling.added)
            builder.add_inertia(name, added, weighs=False)
            nominal = symbols.nominal(inertia)
            if nominal.exponents:
                return  # the sum is no product of powers
            whole = Monomial(nominal.scale + added.scale)
        builder.masses[name] = whole

    def _add_in_space(self, builder: ModelBuilder, name: str, mass: Monomial, symbols: Symbols) -> None:
        """Mass along each coordinate, and the principal moments as rank-one terms of the turns."""
        for axis in self.freedoms:
            if axis in ("x", "y", "z"):
                builder.add_inertia(f"{name}.{axis}", mass, name, weighs=axis == "z")
        turns = [axis for axis in ("rx", "ry", "rz") if axis in self.freedoms]
        kept = [("rx", "ry", "rz").index(axis) for axis in turns]
        solid = self.solid(1.0)
        tensor = solid.tensor[np.ix_(kept, kept)]
        follows = symbols.off(f"bodies.{name}.inertia", Monomial(1.0))
        if self.shape is not None or self.made_of is not None:
            follows = mass.times(1.0 / solid.mass)
        diagonal = not (tensor - np.diag(np.diag(tensor))).any()
        values, axes = (np.diag(tensor), np.eye(len(kept))) if diagonal else np.linalg.eigh(tensor)
        for value, axis in zip(values, axes.T, strict=True):
            row = {f"{name}.{turn}": float(part) for turn, part in zip(turns, axis, strict=True) if part}
            builder.add_term(INERTIA, row, follows.times(float(value)), name, 0.0)
        if self.centre_tolerance is not None:
            add_offset(builder, name, self.freedoms, mass, self.centre_tolerance, symbols)
        builder.masses[name] = mass
        builder.turning[name] = False

    def built(self, assembly: Assembly, name: str, numbers: Numbers) -> None:
        """What resists acceleration, and the part of it on which gravity acts; in space mass, centre and tensor."""
        if self.freedoms:
            assembly.add_rigid(name, self._rigid(name, numbers), self._rigid(name, numbers.said).mass)
            return
        mass, weight = self._resists(name, numbers)
        assembly.add_mass(name, mass, weight, self._resists(name, numbers.said)[0])
        if self.geared_to is not None and self.speed_ratio is not None:
            assembly.gears[name] = (self.geared_to, self.speed_ratio.value)

    def _resists(self, name: str, numbers: Numbers) -> tuple[float, float]:
        if self.disc is not None:
            return self.disc.built * numbers.factor(f"bodies.{name}.disc"), 0.0
        if self.inertia is not None:
            assert isinstance(self.inertia, (Fact, Choice))
            return numbers(f"bodies.{name}.inertia", self.inertia), 0.0
        mass = numbers(f"bodies.{name}.mass", self.mass) + numbers(f"bodies.{name}.weight", self.weight) / GRAVITY
        rolls = self.rolling.inertia.value / self.rolling.radius.value**2 if self.rolling is not None else 0.0
        return mass + rolls, mass

    def _rigid(self, name: str, numbers: Numbers) -> "Rigid":
        from vibopt.mechanics.rigid_parts import Rigid

        off = [numbers.factor(f"bodies.{name}.centre.{axis}") for axis in AXES]
        moved = [offset_of(value, self.reaches.get(axis, 0.0)) for value, axis in zip(off, AXES, strict=True)]
        centre = np.array(self.place) + moved
        if self.made_of is not None:
            own, factor = self.solid(1.0), numbers.factor(f"bodies.{name}.made_of")
            return Rigid(own.mass * factor, centre, own.tensor * factor, self.freedoms, own.centre)
        mass = numbers(f"bodies.{name}.mass", self.mass) + numbers(f"bodies.{name}.weight", self.weight) / GRAVITY
        tensor = self.solid(mass).tensor * numbers.factor(f"bodies.{name}.inertia")
        return Rigid(mass, centre, tensor, self.freedoms, np.array(self.place))
