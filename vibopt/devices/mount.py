"""Mounts with a place and directions: identical ones form a group."""

from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
from pydantic import ConfigDict, ValidationError, field_validator, model_validator

from vibopt.arrays import FloatArray
from vibopt.devices.axes import DampingAxes, Rated, StiffnessAxes, ThreeSchema, three
from vibopt.devices.device import Device, Ends
from vibopt.devices.ends import TwoEnds
from vibopt.devices.part import OWN, Bound, Part
from vibopt.devices.sites import At, Directions, Shift, Single, Sites
from vibopt.devices.symbols import Numbers, Symbols
from vibopt.errors import counted
from vibopt.mechanics.assembly import Assembly
from vibopt.mechanics.builder import ModelBuilder
from vibopt.mechanics.monomial import Monomial
from vibopt.mechanics.vectors import cross
from vibopt.values import Fact, Table, Tolerance, Value, number, word
from vibopt.values.directions import AXES, Span
from vibopt.values.fields import Choice, Rule, complaint, ruled

_SCATTERED = ("stiffness", "damping", "loss_factor")
"""What a tolerance of the whole table is about."""


def _asked(schema: dict[str, Any]) -> None:
    """A part brings its stiffness with it."""
    schema["required"].remove("stiffness")
    schema["anyOf"] = [{"required": ["stiffness"]}, {"required": ["part"]}]


class MountTable(Device):
    """`[mounts.NAME]`: a group of identical mounts, each at its place; values are those of one.

    Keys
    ----
    between: What is carried, and what carries it: `between = ["genset", "ground"]`.
    at: Places from the common origin, a list with one for each mount; a coordinate may be a range, and `{ one_of =
        [...] }` a choice among places: `at = [["0.8 m", "0.4 m", "0 m"], ["-0.8 m", "0.4 m", "0 m"]]`.
    shift: Moves all places of the group together: `shift = { x = { from = "-0.2 m", to = "0.2 m" } }`.
    stiffness: Dynamic stiffness of ONE mount along its own axis z, or a list along its own x, y, z: `stiffness =
        ["0.6 MN/m", "0.6 MN/m", "1.1 MN/m"]`. One of `stiffness` and `part`.
    shear_ratio: Stiffness (and damping) across over that along the axis, beside one stiffness: `shear_ratio =
        0.55`.
    damping: Viscous damping of ONE mount, one value or three: `damping = "3 kN s/m"`. Not beside `loss_factor`.
    loss_factor: Structural damping; steady vibration only: `loss_factor = 0.12`.
    direction: Its own z where it is inclined, three numbers or a list with one for each mount: `direction = [0,
        0.5, 0.866]`.
    across: Its own x, where stiffness across differs by direction: `across = [1, 0, 0]`.
    dynamic_to_static: Dynamic over static stiffness, for sags and static loads: `dynamic_to_static = 1.3`. A fact.
    rating: Least and greatest static load; a limit on `static_load` without a bound holds it to this: `rating =
        "500..3500 N"`.
    gap: How far it may move; a limit on `travel` without a bound holds it to this: `gap = "4 mm"`.
    tolerance: How far stiffness and damping may be off as built, either way: `tolerance = "20 %"`.
    tolerance_of: "group": all mounts are off alike; "mount": each by itself.
    part: Bought instead of made: `part = { catalogue = "mounts.csv" }`. Refused beside stiffness and damping.
    """

    model_config = ConfigDict(**{**Device.model_config, "json_schema_extra": _asked})

    between: TwoEnds
    at: At
    shift: Shift = None
    stiffness: Value | StiffnessAxes = ruled(ThreeSchema(Rule("stiffness")), required=True)
    shear_ratio: Value | None = number("ratio")
    damping: Value | DampingAxes | None = ruled(ThreeSchema(Rule("damping", sign="not negative")))
    loss_factor: Value | None = number("ratio", sign="not negative", most=10.0)
    direction: Directions = ((0.0, 0.0, 1.0),)
    across: Directions | None = None
    dynamic_to_static: Fact | None = number("ratio", choice=False)
    rating: Rated = None
    gap: Fact | None = number("length", choice=False)
    tolerance: Tolerance | None = None
    tolerance_of: Literal["group", "mount"] | None = None
    part: Part | None = None

    @model_validator(mode="before")
    @classmethod
    def _of_part(cls, given: Any) -> Any:
        """The columns of a part that are keys of a mount stand there as if they had been written there."""
        if not isinstance(given, Mapping) or given.get("part") is None or isinstance(given["part"], Part):
            return given
        for key in ("stiffness", "damping", "loss_factor", "dynamic_to_static", "rating"):
            if key in given:
                raise word(f"gives part and {key}. Keep one: a part brings its stiffness, damping and rating with it.")
        try:
            part = Part.model_validate(given["part"])
        except ValidationError:  # said where the part itself is read
            return {"shear_ratio": Fact(1.0, ""), **given, "stiffness": Fact(1.0, "N/m")}
        if part.column("damping_ratio") is not None:
            raise word(
                f"is bought from {part.catalogue.name}, which has damping ratios: relative to what? Give the catalogue "
                "a column of damping or of loss factors."
            )
        return {**given, **_brought(part)}

    @field_validator("stiffness", mode="before")
    @classmethod
    def _stiffnesses(cls, given: Any) -> Any:
        return three(StiffnessAxes, "stiffness", "positive", given)

    @field_validator("damping", mode="before")
    @classmethod
    def _dampings(cls, given: Any) -> Any:
        return three(DampingAxes, "damping", "not negative", given)

    @field_validator("tolerance_of", mode="before")
    @classmethod
    def _whose(cls, given: Any) -> Any:
        if given not in (None, "group", "mount"):
            raise complaint(
                'is not "group" (all mounts of the group are off alike, as one batch) or "mount" (each by itself).'
            )
        return given

    @model_validator(mode="before")
    @classmethod
    def _no_ratio(cls, given: Any) -> Any:
        if isinstance(given, Mapping) and "damping_ratio" in given:
            raise word(
                "has a damping_ratio, but a machine in space has a mass and three inertias: relative to what? Write "
                'damping = "2 kN s/m", or loss_factor = 0.1.'
            )
        return given

    @model_validator(mode="after")
    def _consistent(self) -> "MountTable":
        three = isinstance(self.stiffness, StiffnessAxes)
        if not three and self.shear_ratio is None:
            raise word(
                "has one stiffness, that along its axis: how stiff is it across? Add shear_ratio = 0.5 (across over "
                "along), or write three values: stiffness = [x, y, z]."
            )
        if three and self.shear_ratio is not None:
            raise word("gives three stiffnesses and shear_ratio. Keep one of them.")
        if three and self.damping is not None and not isinstance(self.damping, DampingAxes):
            raise word("gives three stiffnesses but one damping. Write three: damping = [x, y, z].")
        if self.damping is not None and self.loss_factor is not None:
            raise word("gives damping and loss_factor. Keep one: they are two ways to say the damping of one mount.")
        for key in ("direction", "across"):
            many = len(getattr(self, key) or ())
            if many > 1 and many != self.count:
                places = counted(self.count, "places")
                raise word(f"has {places} but {many} values of {key}. Give one for all, or one for each.")
        if self.shift is not None and isinstance(self.at, Sites):
            raise word("has shift beside places to choose from. Keep one of them, or name the moved places in one_of.")
        self._check_across()
        return self

    def _check_across(self) -> None:
        for own, side in zip(self._each(self.direction), self._each(self.across or (None,)), strict=True):
            if side is not None and abs(float(np.dot(own, side))) > 1.0 - 1e-9:
                raise word("has across along its direction. Write across at right angles to direction.")
            if side is None and isinstance(self.stiffness, StiffnessAxes) and abs(own[2]) < 1.0 - 1e-9:
                x, y = self.stiffness.x, self.stiffness.y
                if x != y:
                    raise word(
                        "is inclined and differs across: which way does its own x point? Add across = [1, 0, 0], for "
                        "example."
                    )

    def _each(self, given: tuple[Any, ...]) -> tuple[Any, ...]:
        return given * self.count if len(given) == 1 else given

    @property
    def placed(self) -> bool:
        return True

    @property
    def brought(self) -> tuple[str, ...]:
        """Keys that the part has filled in."""
        return ("stiffness", "damping", "loss_factor") if self.part is not None else ()

    @property
    def printed(self) -> Value | None:
        """Tolerance of the stiffness that the catalogue prints, where the file says none."""
        return self.part.tolerance if self.part is not None and self.tolerance is None else None

    def parts(self) -> dict[str, str]:
        return {key: key for key in _SCATTERED if getattr(self, key) is not None}

    def scattered(self, name: str, path: str) -> tuple[str, ...]:
        """Of a group the number itself, or where `tolerance_of` is "mount" that of each mount."""
        if self.tolerance_of != "mount" or self.count == 1:
            return (path,)
        end = path.removeprefix(f"mounts.{name}.")
        return tuple(f"mounts.{single}.{end}" for single in self.singles(name))

    @property
    def static_ratio(self) -> Value | None:
        """Dynamic over static stiffness."""
        return self.dynamic_to_static if self.part is None else self.part.dynamic_to_static

    def bound(self, name: str) -> "tuple[Bound, ...]":
        base = f"mounts.{name}"
        paths = {key: f"{base}.part.{key}" for key in OWN} | {"loss_factor": f"{base}.loss_factor"}
        for key in ("stiffness", "damping"):
            if isinstance(getattr(self, key), (StiffnessAxes, DampingAxes)):
                paths |= {key: f"{base}.{key}.z", f"{key}_x": f"{base}.{key}.x", f"{key}_y": f"{base}.{key}.y"}
            else:
                paths[key] = f"{base}.{key}"
        found = self.part.bound(f"{base}.part", paths) if self.part is not None else None
        return () if found is None else (found,)

    @property
    def sites(self) -> Single:
        """Place of each mount [m]; of the first set, or half way, where the places are open."""
        if isinstance(self.at, Sites):
            return self.at.options[0]
        moved = self.shift or (0.0, 0.0, 0.0)
        return tuple(
            (_middle(x) + _middle(moved[0]), _middle(y) + _middle(moved[1]), _middle(z) + _middle(moved[2]))
            for x, y, z in self.at
        )

    @property
    def count(self) -> int:
        """Number of mounts."""
        return len(self.sites)

    @property
    def frames(self) -> list[FloatArray]:
        """Own x, y and z of each mount as rows (3, 3)."""
        return [
            _frame(np.array(own), None if side is None else np.array(side))
            for own, side in zip(self._each(self.direction), self._each(self.across or (None,)), strict=True)
        ]

    def singles(self, name: str) -> tuple[str, ...]:
        """Name of each mount of the group."""
        return _singles(name, self.count)

    @classmethod
    def links_in(cls, name: str, given: Mapping[str, Any]) -> tuple[str, ...]:
        at = given.get("at")
        if isinstance(at, Mapping) and isinstance(at.get("one_of"), list) and at["one_of"]:
            at = at["one_of"][0]
        many = len(at) if isinstance(at, list) and at and all(isinstance(one, list) for one in at) else 1
        return tuple(dict.fromkeys((name, *_singles(name, many))))

    def joins(self, name: str) -> dict[str, Ends]:
        return dict.fromkeys((name, *self.singles(name)), self.between)

    def springs(self, name: str) -> tuple[str, ...]:
        return (name, *self.singles(name))

    def values_of(self, key: str, name: str, symbols: Symbols) -> list[Monomial] | None:
        """Stiffness [N/m] or damping [N s/m] along the own x, y, z; None where it has none."""
        given = getattr(self, key)
        path = f"mounts.{name}.{key}"
        if given is None:
            return None
        if isinstance(given, (StiffnessAxes, DampingAxes)):
            three = [symbols.read(f"{path}.{axis}", getattr(given, axis)) for axis in AXES]
            return [symbols.off(path, one) for one in three]
        assert self.shear_ratio is not None
        along = symbols.read(path, given)
        side = along * symbols.read(f"mounts.{name}.shear_ratio", self.shear_ratio)
        return [side, side, along]

    def add_to(self, builder: ModelBuilder, name: str, symbols: Symbols) -> None:
        """Three links for each mount, along its own axes: NAME.1.x, NAME.1.y, NAME.1.z."""
        stiffness, damping = self.values_of("stiffness", name, symbols), self.values_of("damping", name, symbols)
        assert stiffness is not None
        lossy = symbols.read(f"mounts.{name}.loss_factor", self.loss_factor) if self.loss_factor is not None else None
        ratio = self.static_ratio
        inner = "part." if self.part is not None else ""
        softer = (
            Monomial(1.0) if ratio is None else symbols.read(f"mounts.{name}.{inner}dynamic_to_static", ratio) ** -1.0
        )
        for single, at, frame in zip(self.singles(name), self.sites, self.frames, strict=True):
            for k, axis in enumerate(AXES):
                link = f"{single}.{axis}"
                own = self._off(name, single, "stiffness", axis, symbols, stiffness[k])
                builder.add_spring_at(link, self.between, at, frame[k])
                if isinstance(ratio, Choice):
                    builder.add_stiffness(link, own, 0.0)
                    builder.add_static_stiffness(link, own * softer)
                else:
                    builder.add_stiffness(link, own, softer.scale)
                if damping is not None:
                    builder.add_damping(link, self._off(name, single, "damping", axis, symbols, damping[k]))
                if lossy is not None:
                    loss = self._off(name, single, "loss_factor", "", symbols, lossy)
                    builder.add_hysteretic(link, own * loss)
                if self.part is not None:
                    builder.properties[link, "static_stiffness"] = own * softer
        builder.counts[name] = Monomial(float(self.count))
        if self.part is not None:
            self._rate(builder, name, symbols, self.part)

    def _off(self, name: str, single: str, key: str, axis: str, symbols: Symbols, value: Monomial) -> Monomial:
        """A number of one mount, off by itself; where the group is off alike it was read so."""
        if single == name or self.tolerance_of != "mount":
            return value
        value = symbols.off(f"mounts.{single}.{key}", value)
        if axis:
            value = symbols.off(f"mounts.{single}.{key}.{axis}", value)
            if axis != "z" and not isinstance(getattr(self, key), Table):
                value = symbols.off(f"mounts.{single}.shear_ratio", value)
        return value

    def _rate(self, builder: ModelBuilder, name: str, symbols: Symbols, part: Part) -> None:
        """What a part is rated for, mount by mount, and what the group costs."""
        for key in ("rated_min", "rated_max", "price"):
            value = getattr(part, key)
            if value is None:
                continue
            one = symbols.read(f"mounts.{name}.part.{key}", value)
            if key == "price":
                builder.properties[name, key] = one.times(float(self.count))
                continue
            for single in self.singles(name):
                builder.properties[f"{single}.z", key] = one

    def built(self, assembly: Assembly, name: str, numbers: Numbers) -> None:
        """Every mount by itself, each with its own numbers off where they scatter."""
        from vibopt.mechanics.rigid_parts import Spring3

        stiffness, damping = (self._three(key, name, numbers) for key in ("stiffness", "damping"))
        inner = f"mounts.{name}.part" if self.part is not None else f"mounts.{name}"
        static = stiffness / numbers(f"{inner}.dynamic_to_static", self.static_ratio, 1.0)
        price = numbers(f"{inner}.price", self.part.price if self.part is not None else None)
        lossy = numbers(f"mounts.{name}.loss_factor", self.loss_factor)
        mounts = []
        for single, at, frame in zip(self.singles(name), self.sites, self.frames, strict=True):
            stiff, dash, loss = _scatter(single, numbers) if self.count > 1 else (1.0, 1.0, 1.0)
            own = (stiffness * stiff, static * stiff, damping * dash, lossy * loss, price)
            mounts.append(Spring3(single, self.between, np.array(at), frame, *own))
        assembly.add_mounts(name, mounts)

    def _three(self, key: str, name: str, numbers: Numbers) -> FloatArray:
        """Stiffness [N/m] or damping [N s/m] of the group along the own x, y, z (3,)."""
        given, path = getattr(self, key), f"mounts.{name}.{key}"
        if isinstance(given, (StiffnessAxes, DampingAxes)):
            each = [numbers(f"{path}.{axis}", getattr(given, axis)) for axis in AXES]
            return np.array(each) * numbers.factor(path)
        side = numbers(f"mounts.{name}.shear_ratio", self.shear_ratio)
        return numbers(path, given) * np.array([side, side, 1.0])


def _scatter(single: str, numbers: Numbers) -> tuple[FloatArray, FloatArray, float]:
    """By what stiffness (3,), damping (3,) and loss factor of one mount of a group are off by themselves."""

    def off(key: str) -> float:
        return numbers.factor(f"mounts.{single}.{key}")

    side = off("shear_ratio")
    stiff, dash = (
        off(key) * np.array([side * off(f"{key}.x"), side * off(f"{key}.y"), off(f"{key}.z")])
        for key in ("stiffness", "damping")
    )
    return stiff, dash, off("loss_factor")


def _brought(part: Part) -> dict[str, Any]:
    """Keys of a mount from the columns of a part."""
    loss = {} if part.column("loss_factor") is None else {"loss_factor": part.column("loss_factor")}
    if part.column("stiffness_x") is None:
        damping = {} if part.column("damping") is None else {"damping": part.column("damping")}
        return {"stiffness": part.column("stiffness"), **damping, **loss}
    found: dict[str, Any] = dict(loss)
    for key, kind in (("stiffness", StiffnessAxes), ("damping", DampingAxes)):
        if part.column(key) is not None:
            three = {"x": part.column(f"{key}_x"), "y": part.column(f"{key}_y"), "z": part.column(key)}
            found[key] = kind.model_validate(three)
    return found


def _middle(given: float | Span) -> float:
    return given.middle if isinstance(given, Span) else given


def _singles(name: str, count: int) -> tuple[str, ...]:
    return (name,) if count == 1 else tuple(f"{name}.{i + 1}" for i in range(count))


def _frame(own: FloatArray, side: FloatArray | None) -> FloatArray:
    """Rows x, y, z of a mount whose axis is `own`; x along `side`, else as level as y."""
    if side is None:
        level = np.array([-own[1], own[0], 0.0])
        size = float(np.linalg.norm(level))
        y = level / size if size > 1e-12 else np.array([0.0, 1.0, 0.0])
        if size > 1e-12 and y[np.abs(y).argmax()] < 0.0:
            y = -y
        x = cross(y, own)
    else:
        x = side - own * float(own @ side)
        x = x / np.linalg.norm(x)
        y = cross(own, x)
    return np.array([x, y, own])
