"""A number in a problem file: a fact, or a choice that the solver is to make."""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import cache, partial
from types import NoneType
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, get_args

from pydantic import BaseModel, ConfigDict, Field, GetCoreSchemaHandler, GetJsonSchemaHandler, model_validator
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from vibopt.document.mistakes import toml_text
from vibopt.errors import QuantityError
from vibopt.records import dataclass
from vibopt.units import DIMENSIONS, Quantity, is_range, read_quantity
from vibopt.units.parsing import BARE, split_value
from vibopt.values.tolerance import read_tolerance


@dataclass(frozen=True, slots=True)
class Fact:
    """A given value: `value` in SI (amplitudes peak), `unit` as the user wrote it.

    As built it may be off by the part `tolerance` of itself, either way.
    """

    value: float
    unit: str
    echo: str | None = None
    tolerance: float = 0.0


@dataclass(frozen=True, slots=True)
class Choice:
    """A design variable: the range [low, high] in SI, or the listed `options` only.

    Where the user left the range half open `high` is the most that is possible there, often inf, or `open_low` says
    that `low` stands for "as near to zero as you like".  As built it may be off by the part `tolerance` of what is
    chosen.
    """

    low: float
    high: float
    unit: str
    whole: bool = False
    options: tuple[float, ...] = ()
    echo: str | None = None
    open_low: bool = False
    tolerance: float = 0.0


Value = Fact | Choice
_NEAR_ZERO = 1e-9
LEAST = 1e-30
"""Least value above zero [SI]; below it products run out of digits."""
MOST_WHOLE = 5000
"""Most whole numbers that a range may hold: each one is tried."""
_KEYS = ("from", "to", "one_of", "whole")


class Table(BaseModel):
    """Base of every table of a problem file: unknown keys are mistakes.

    Files of tables go without `from __future__ import annotations`: pydantic would read each annotation again, from
    its text, for every child of a table.

    printed_in_catalogue
        Whether its numbers are those of a catalogue, and no facts of the file.
    """

    printed_in_catalogue: ClassVar[bool] = False
    model_config = ConfigDict(
        extra="forbid", frozen=True, arbitrary_types_allowed=True, defer_build=True, protected_namespaces=()
    )

    @model_validator(mode="before")
    @classmethod
    def _no_truth_for_a_number(cls, given: Any) -> Any:
        """True and false are numbers to Python, and 1 and 0 to nobody else."""
        for key in counts_of(cls) if isinstance(given, (dict, Mapping)) else ():
            said = given.get(key)
            if isinstance(said, bool) or (isinstance(said, list) and any(isinstance(one, bool) for one in said)):
                raise KeyedError(key, said, "is true or false, but a number is needed here. Write one, for example 2.")
        return given

    if not TYPE_CHECKING:

        def __getattr__(self, key: str) -> Any:
            """What a kind has no key for is asked for often: said at once, without a search for the nearest word."""
            if key.startswith("_"):
                return super().__getattr__(key)
            raise AttributeError(key)

    @classmethod
    def __pydantic_init_subclass__(cls, **_: Any) -> None:
        """What a kind says of itself is no field, and not looked at again for every child of it."""
        cls.__annotations__ = {
            key: annotation for key, annotation in cls.__annotations__.items() if key not in cls.__class_vars__
        }


_PLAIN = {NoneType, str, bool, int, float}


def numbers_in(path: str, table: Table) -> Iterator[tuple[str, Fact | Choice, Table]]:
    """Path and value of every number of a table and of the tables in it, and the table that holds it."""
    for key, value in vars(table).items():
        if type(value) in _PLAIN:
            continue
        here = f"{path}.{key}"
        if isinstance(value, (Fact, Choice)):
            yield here, value, table
        elif isinstance(value, (list, tuple)):
            for number, one in enumerate(value, start=1):
                if isinstance(one, Table):
                    yield from numbers_in(f"{here}.{number}", one)
        elif isinstance(value, Table):
            yield from numbers_in(here, value)


class KeyedError(ValueError):
    """A value of a table that cannot be read; carries the key and what was given."""

    def __init__(self, key: str, given: object, text: str) -> None:
        super().__init__(text)
        self.key, self.given, self.text = key, given, text


@cache
def counts_of(kind: type[BaseModel]) -> tuple[str, ...]:
    """Keys of a table that hold plain numbers."""
    return tuple(key for key, field in kind.model_fields.items() if _is_plain_number(field.annotation))


def _is_plain_number(annotation: Any) -> bool:
    """Whether an annotation speaks of whole or other numbers, and not of true and false."""
    level, kinds = [annotation], set()
    while level:
        kinds |= {one if isinstance(one, type) else type(one) for one in level}
        level = [part for one in level for part in get_args(one)]
    return bool(kinds & {int, float}) and bool not in kinds


def rule_of(kind: type[BaseModel], key: str) -> "Rule | None":
    """The rule of a number field of a table; None for any other field."""
    extra = kind.model_fields[key].json_schema_extra
    return extra.rule if isinstance(extra, RuleSchema) else None


def complaint(text: str) -> PydanticCustomError:
    """An error whose text continues `<file> line N: <path> = <given> `."""
    return PydanticCustomError("complaint", "{text}", {"text": text})


def wrong_part(what: str, given: object, error: QuantityError) -> PydanticCustomError:
    """A complaint about one part of what is given, quoted as it stands in the file."""
    return complaint(f"has a wrong {what}: {toml_text(given)} {error}")


def word(text: str, *at: str | int) -> PydanticCustomError:
    """An error whose text is a sentence of its own behind `<file> line N: <path>: `, the line that of the keys `at`."""
    return PydanticCustomError("sentence", "{text}", {"text": text, "at": at})


@dataclass(frozen=True, slots=True)
class Rule:
    """What a number must be: dimension, sign, whether it may be a choice, and whether, as a fact, it may be zero."""

    dimension: str
    amplitude: bool = False
    choice: bool = True
    sign: str = "positive"
    most: float = float("inf")
    tolerance: bool = False
    zero: bool = False

    @property
    def may_be_off(self) -> bool:
        """Whether the number may have a tolerance: what may be chosen as a part, but no count."""
        return self.tolerance or (self.choice and self.dimension != "count")

    def check(self, value: float) -> None:
        if self.sign == "positive" and value <= 0.0:
            raise QuantityError("is not greater than zero." + self._way_out())
        if self.sign == "not negative" and value < 0.0:
            raise QuantityError("is negative." + self._way_out())
        if 0.0 < value < LEAST:
            raise QuantityError(f"is beyond what any machine has (|value| < {LEAST:g} in SI).")
        if value > self.most:
            raise QuantityError(f"is greater than {self.most:g}, the most that is possible here.")

    def _way_out(self) -> str:
        return f' Write a positive value, for example "{DIMENSIONS[self.dimension].example}".'


def number(
    dimension: str,
    *,
    amplitude: bool = False,
    choice: bool = True,
    sign: str = "positive",
    most: float = float("inf"),
    required: bool = False,
    tolerance: bool = False,
    zero: bool = False,
) -> Any:
    """Field of a table that reads a Fact (or a Choice) of one dimension.

    Parameters
    ----------
    dimension
        Name of the dimension, as in `vibopt.units`.
    amplitude
        Whether `pk`, `pp` and `rms` may stand behind the unit; the value is then peak.
    choice
        Whether a range `{ from, to }` is allowed.
    sign
        "positive", "not negative" or "any".
    most
        Greatest value allowed [SI].
    required
        Whether the key must be there.
    tolerance
        Whether a tolerance may be given although the number may not be chosen.
    zero
        Whether it may be zero as a fact, whatever its sign must be.
    """
    rule = Rule(dimension, amplitude, choice, sign, most, tolerance, zero)
    return ruled(RuleSchema(rule), required=required)


def ruled(schema: "RuleSchema", *, required: bool = False) -> Any:
    """Field that is read, and described in the JSON schema, by a rule."""
    made: Any = Field(default=... if required else None, json_schema_extra=schema)
    made.metadata.append(schema)
    return made


@dataclass(frozen=True, slots=True)
class RuleSchema:
    """Carries the rule of a field, reads its value and writes its JSON schema."""

    rule: Rule

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """What may be nothing but a number is read here, without a schema of its own, which takes long to make."""
        kinds = {*get_args(source)} or {source}
        read = self._read if NoneType in kinds else partial(read_number, self.rule)  # None is left out, or no value
        if kinds <= {Fact, Choice, NoneType}:
            return core_schema.no_info_plain_validator_function(read)
        return core_schema.no_info_before_validator_function(read, handler(source))

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        return {}

    def _read(self, given: Any) -> Any:
        return None if given is None else read_number(self.rule, given)

    def __call__(self, schema: dict[str, Any]) -> None:
        schema.clear()
        schema.update(_schema(self.rule))


CLOSED: dict[str, Any] = {"not": {}}
"""JSON schema of a key of its base that a table refuses."""


@dataclass(frozen=True, eq=False, slots=True)
class ReadBy:
    """Carries what reads a field, for good: what it gives is what the field holds; and its JSON schema."""

    read: Callable[[Any], Any]
    schema: dict[str, Any]

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        return dict(self.schema)


def _read_tolerance(given: object) -> float:
    try:
        return read_tolerance(given)
    except QuantityError as error:
        raise complaint(str(error)) from None


Tolerance = Annotated[
    float,
    ReadBy(
        _read_tolerance,
        {"type": ["string", "number", "object"], "description": "how far each number of the table may be off, 5 %"},
    ),
]
"""`tolerance = "5 %"` of a whole table: each of its numbers on its own."""


def _schema(rule: Rule) -> dict[str, Any]:
    plain: dict[str, Any] = {
        "type": ["string", "number"],
        "description": f"{rule.dimension}, for example {DIMENSIONS[rule.dimension].example}",
    }
    side = {"type": ["string", "number"]}
    wide = {**side, "type": ["string", "number", "object"]}
    off = {
        "type": "object",
        "properties": {"value": side, "tolerance": wide},
        "required": ["value", "tolerance"],
        "additionalProperties": False,
    }
    if not rule.choice:
        return {"anyOf": [plain, off]} if rule.may_be_off else plain
    table = {
        "type": "object",
        "properties": {
            "from": side,
            "to": side,
            "one_of": {"type": "array"},
            "whole": {"type": "boolean"},
            **({"tolerance": wide} if rule.may_be_off else {}),
        },
        "additionalProperties": False,
    }
    return {"anyOf": [plain, table, *([off] if rule.may_be_off else [])]}


def read_number(rule: Rule, given: object) -> Value:
    """A number of a table as its rule has it; PydanticCustomError where it is none."""
    if isinstance(given, (Fact, Choice, Table)):
        return given  # type: ignore[return-value]  # a table of such values, read by its own kind
    try:
        if isinstance(given, (dict, Mapping)):
            return read_value(rule, given)
        if isinstance(given, str) and is_range(given):
            way = ', or { from = "...", to = "..." } to let vibopt choose one' if rule.choice else ""
            raise QuantityError(
                f"asks for every value in a range, which is not supported for this fact yet. Write one value{way}."
            )
        return read_fact(rule, given)
    except QuantityError as error:
        raise complaint(str(error)) from None


def read_value(rule: Rule, given: object) -> Value:
    """A fact or a choice by its rule.

    Raises
    ------
    QuantityError
        It is none.
    """
    if not isinstance(given, (dict, Mapping)):
        return read_fact(rule, given)
    return (_read_off if "tolerance" in given or "value" in given else _read_choice)(rule, given)


def _read_off(rule: Rule, given: Mapping[str, object]) -> Value:
    """A value or a choice with its tolerance."""
    if rule.dimension == "count":
        raise QuantityError("has a tolerance, but a count is built as it is said. Remove the tolerance.")
    if not rule.may_be_off:
        raise QuantityError(
            "has a tolerance, but is taken as it is said: of a machine only masses, moments of inertia, stiffnesses, "
            "dampings and diameters may have one. Write the value alone; vibopt sweep FILE --vary of this value with "
            "--keep-design tells what it does when it is off."
        )
    if "tolerance" not in given:
        raise QuantityError('has a value without a tolerance. Add tolerance = "5 %", or write the value alone.')
    rest = {key: one for key, one in given.items() if key != "tolerance"}
    try:
        tolerance = read_tolerance(given["tolerance"])
    except QuantityError as error:
        raise QuantityError(_as_ratio(rule, rest, given["tolerance"]) or str(error)) from None
    if list(rest) != ["value"]:
        if not rest or "value" in rest:
            raise QuantityError('needs one value, or from and to. Write { value = "...", tolerance = "5 %" }.')
        return replace(_read_choice(rule, rest), tolerance=tolerance)
    if isinstance(rest["value"], Mapping):
        raise QuantityError('has a table as its value. Write { value = "...", tolerance = "5 %" }.')
    return replace(read_fact(rule, rest["value"]), tolerance=tolerance)


def _as_ratio(rule: Rule, rest: Mapping[str, object], given: object) -> str:
    """How a tolerance in the unit of its value is written; nothing of another."""
    if list(rest) != ["value"] or not isinstance(given, str):
        return ""
    try:
        part = read_quantity(given, rule.dimension).value / read_fact(rule, rest["value"]).value
    except (QuantityError, ZeroDivisionError):
        return ""
    return f'has a tolerance that is no ratio. Write tolerance = "{100.0 * part:.6g} %".' if 0.0 < part < 1.0 else ""


def read_fact(rule: Rule, given: object) -> Fact:
    """A fact by its rule; QuantityError where it is none."""
    quantity = read_quantity(given, rule.dimension, amplitude=rule.amplitude)
    if not (rule.zero and quantity.value == 0.0):
        rule.check(quantity.value)
    return Fact(quantity.value, quantity.unit, quantity.echo)


def _read_choice(rule: Rule, given: Mapping[str, object]) -> Choice:
    if not rule.choice:
        raise QuantityError("is a choice, but this value must be a fact. Write one value.")
    for key in given:
        if key not in _KEYS:
            raise QuantityError(f'has the unknown key "{key}". A choice has from, to, one_of and whole.')
    if "one_of" in given:
        return _read_options(rule, given)
    if "from" not in given and "to" not in given:
        raise QuantityError('has neither from nor to. Write { from = "...", to = "..." }.')
    ends = {key: _end(rule, given, key) for key in ("from", "to") if key in given}
    unit = next(iter(ends.values())).unit
    low = ends["from"].value if "from" in ends else 0.0
    high = ends["to"].value if "to" in ends else rule.most
    if low > high:
        raise QuantityError("is a reversed range: from is greater than to. Exchange the two.")
    if low == high:
        raise QuantityError("is an empty range: from equals to. Write the value alone, as a fact.")
    echo = next((end.echo for end in ends.values() if end.echo), None)
    whole = _is_whole(rule, given, low, high)
    if whole and rule.sign == "positive":
        low = max(low, 1.0)
    near_zero = rule.sign == "positive" and low == 0.0 and not whole
    if near_zero:
        low = _NEAR_ZERO * (high if high < float("inf") else 1.0)
    return Choice(low, high, unit, whole, (), echo, near_zero)


def _is_whole(rule: Rule, given: Mapping[str, object], low: float, high: float) -> bool:
    """Whether only whole numbers may be chosen; a few of them must be there, and not too many."""
    whole = given.get("whole", rule.dimension == "count")
    if not isinstance(whole, bool):
        raise QuantityError("has a whole that is neither true nor false. Write whole = true.")
    if rule.dimension == "count" and not whole:
        raise QuantityError("has whole = false, but a count is a whole number. Leave whole out.")
    if not whole:
        return False
    if rule.dimension != "count":
        raise QuantityError(
            'asks for whole numbers, but only a count is one. Write one_of = ["...", "..."] for a list of values.'
        )
    if high == float("inf"):
        raise QuantityError("has no upper end. Whole numbers need both from and to.")
    least = max(math.ceil(low), 1 if rule.sign == "positive" else 0)
    many = math.floor(high) - least + 1
    if many < 1:
        raise QuantityError("holds no whole number. Write a wider range, or leave whole out.")
    if many > MOST_WHOLE:
        raise QuantityError(f"holds more than {MOST_WHOLE} whole numbers. Write a narrower range, or leave whole out.")
    return True


def _end(rule: Rule, table: Mapping[str, object], key: str) -> Quantity:
    given, quantity = table[key], read_end(table, key, rule.dimension, amplitude=rule.amplitude)
    if quantity.value < 0.0 or (quantity.value == 0.0 and rule.sign == "positive" and key == "to"):
        raise QuantityError(f"has a wrong {key}: {toml_text(given)} is not greater than zero.")
    if quantity.value > rule.most:
        raise QuantityError(f"has a wrong {key}: {toml_text(given)} is greater than {rule.most:g}.")
    return quantity


def _read_options(rule: Rule, given: Mapping[str, object]) -> Choice:
    listed = given["one_of"]
    if set(given) != {"one_of"} or not isinstance(listed, list) or not listed:
        raise QuantityError('needs one_of = ["...", "..."] alone, with at least one value in it.')
    quantities = [read_quantity(one, rule.dimension, amplitude=rule.amplitude) for one in listed]
    for quantity in quantities:
        rule.check(quantity.value)
    values = tuple(sorted({quantity.value for quantity in quantities}))
    echo = next((quantity.echo for quantity in quantities if quantity.echo), None)
    return Choice(values[0], values[-1], quantities[0].unit, False, values, echo)


def read_end(table: Mapping[str, object], key: str, dimension: str, *, amplitude: bool = False) -> Quantity:
    """One end of { from, to }; QuantityError with its key, and a forgotten unit is that of the other end."""
    given = table[key]
    try:
        return read_quantity(given, dimension, amplitude=amplitude)
    except QuantityError as error:
        beside = _unit_beside(table.get("to" if key == "from" else "from"), given, dimension)
        wrong = f'has no unit. Write "{given} {beside}".' if beside else error
        raise QuantityError(f"has a wrong {key}: {toml_text(given)} {wrong}") from None


def _unit_beside(other: object, given: object, dimension: str) -> str:
    """The unit of another value, where this one is a number without any; "" elsewhere."""
    if not isinstance(other, str) or not isinstance(given, (str, int, float)) or isinstance(given, bool):
        return ""
    try:
        bare = dimension not in BARE and not split_value(str(given), dimension)[1]
        return split_value(other, dimension)[1] if bare else ""
    except QuantityError:
        return ""
