"""Numbers that may stand on a drawing: significant digits, or whole steps of a size."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from decimal import ROUND_CEILING, ROUND_FLOOR, Decimal
from itertools import combinations
from math import tau

import numpy as np

from vibopt.answer.entry import Entry
from vibopt.errors import InputError, QuantityError, counted, way_out
from vibopt.mechanics.constants import GRAVITY
from vibopt.records import dataclass
from vibopt.scene.facts import facts, read_fact
from vibopt.scene.scene import Design, Scene, Variable
from vibopt.units import DIMENSIONS, read_quantity, reads, to_unit
from vibopt.values.fact_at import FactAt
from vibopt.verify.as_built import machine_of

DIGITS = 12
"""Most significant digits that are tried."""
_BUILT = ("mass", "inertia", "stiffness", "torsional_stiffness", "damping", "torsional_damping")
_SAID = (*_BUILT, "mass_ratio", "tuning", "frequency", "damping_ratio", "loss_factor", "length")
"""Numbers of an absorber that follow from its mass, spring and damper."""
_EDGE = 1e-9
_AMOUNT = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")


@dataclass(frozen=True, slots=True)
class Number:
    """A chosen number as a fact of the frozen job, and the least number of steps that it may be."""

    fact: FactAt
    least: int = 1

    @property
    def path(self) -> str:
        return self.fact.path

    @property
    def name(self) -> str:
        """Path as the file has it."""
        return self.path.removesuffix(".value")


@dataclass(frozen=True, slots=True)
class Grid:
    """Where a number may stand: whole multiples of a step.

    exact_count
        The exact value over the step.
    doubt
        How far that is from a whole number (0 to 0.5).
    digits, words
        Significant digits of the step, and what was asked.
    """

    number: Number
    step: Decimal
    unit: str
    exact_count: Decimal
    digits: int
    words: str

    @property
    def path(self) -> str:
        return self.number.path

    @property
    def doubt(self) -> float:
        return float(abs(self.exact_count - self.exact_count.to_integral_value()))

    @property
    def nearest(self) -> str:
        """The nearest value, which is not zero where it must not be, as a text."""
        return self._text(max(self.exact_count.to_integral_value(), Decimal(self.number.least)))

    def around(self, reach: int) -> tuple[str, ...]:
        """Values below and above, so many each way, as texts; an exact value that stands on the grid counts once."""
        middle = self.exact_count.to_integral_value()
        if reach == 1 and self.doubt <= _EDGE:
            return (self._text(middle),)
        below, above = (self.exact_count.to_integral_value(way) for way in (ROUND_FLOOR, ROUND_CEILING))
        first, last = below - (reach - 1), above + (reach - 1)
        counts = [first + k for k in range(int(last - first) + 1)]
        return tuple(self._text(count) for count in counts if count >= self.number.least)

    def _text(self, count: Decimal) -> str:
        value = count * self.step
        if value >= _turn(self.number, self.unit):
            value = Decimal(0)
        return f"{(value + 0).normalize():f} {self.unit}".strip()

    @property
    def exact(self) -> Entry:
        fact = self.number.fact
        return Entry(fact.value, fact.dimension, fact.unit)

    def shown(self, text: str) -> Entry:
        """A rounded value, as it is written."""
        fact = self.number.fact
        return Entry(read_fact(fact, text), fact.dimension, text=text)


def numbers(scene: Scene, kept: Scene) -> list[Number]:
    """What may be rounded of a design: ranges of the file; of absorbers the mass, the spring and the damper."""
    free = [variable for variable in scene.variables if variable.values is None]
    paths = {variable.path for variable in free}
    for name in scene.absorbers:
        own = {path for path in paths if path.startswith(f"absorbers.{name}.")}
        if own and all(one.split(".")[2] in _SAID and one.count(".") == 2 for one in own):
            paths = (paths - own) | {f"absorbers.{name}.{word}" for word in (*_BUILT, "frequency")}
            paths |= {one for one in own if one.endswith(".loss_factor")}
    return [number for number in map(Number, facts(kept)) if number.name in paths]


def check_asked(asked: Sequence[str]) -> None:
    """Whether what is asked can be a number of digits or a step, before anything is solved; InputError where not."""
    for text in asked:
        path, sign, step = (part.strip() for part in text.partition("="))
        amount = _AMOUNT.match(step if sign else path)
        if not sign and (amount is None or amount[0] == path) and not _is_digits(path):
            raise _neither(text, 'a step with its unit, "0.5 g"')
        if amount is not None and not float(amount[0]) > 0.0:
            raise InputError(f'--round {text}: a step is greater than zero. Write one with its unit, "0.5 g".')
    for first, second in combinations(asked, 2):
        _differ(first, second)


def _differ(first: str, second: str) -> None:
    """Whether two that are asked are for other values; InputError where one of them would be lost."""
    (one, sign, _), (other, mark, _) = (tuple(map(str.strip, text.partition("="))) for text in (first, second))
    if sign and mark and one == other:
        raise InputError(f"--round {one} is given twice. Give it once.")
    if sign or mark:
        return
    if one.isdigit() and other.isdigit():
        raise InputError(f"--round {one} and --round {other} are both digits of all values. Give one of them.")
    if any(reads(one, dimension) and reads(other, dimension) for dimension in DIMENSIONS):
        raise InputError(
            f"--round {one} and --round {other} are both steps of the same values. Give one of them, or name a value "
            "before each: --round PATH=STEP."
        )


def _is_digits(text: str) -> bool:
    return text.isdigit() and 1 <= int(text) <= DIGITS


def _neither(text: str, step: str) -> InputError:
    return InputError(
        f"--round {text}: is neither a number of digits from 1 to {DIGITS} nor a step. Write --round 3, or {step}."
    )


def grids(own: Sequence[Number], asked: Sequence[str]) -> list[Grid]:
    """The grid of each number that is to be rounded.

    Raises
    ------
    InputError
        A text that is neither a number of digits nor a step for all of a kind nor PATH=STEP, or one that does not fit.
    """
    digits: int | None = None
    steps: dict[str, str] = {}
    kinds: dict[str, str] = {}
    for text in asked:
        path, sign, step = (part.strip() for part in text.partition("="))
        if sign:
            steps[_known(own, path)] = step
            continue
        alike = [number.name for number in own if _is_step(path, number.fact)]
        if alike:
            kinds |= dict.fromkeys(alike, path)
            continue
        if not _is_digits(path):
            raise _neither(text, f'--round {own[0].name}="{_example(own[0])}"')
        digits = int(path)
    steps = kinds | steps
    made = [_stepped(number, steps[number.name]) for number in own if number.name in steps]
    return made + [_to_digits(number, digits) for number in own if digits is not None and number.name not in steps]


def _is_step(text: str, fact: FactAt) -> bool:
    """Whether a text is an amount of the kind of a number."""
    try:
        return bool(fact.unit) and bool(read_quantity(text, fact.dimension).unit)
    except QuantityError:
        return False


def _known(own: Sequence[Number], path: str) -> str:
    names = [number.name for number in own]
    if path not in names:
        raise InputError(f"--round {path}: this is no value that can be rounded.{way_out(path, names)}")
    return path


def _example(number: Number) -> str:
    size = Decimal(1).scaleb(_decimal(number).adjusted() - 2)
    return f"{size:f} {number.fact.unit}".strip()


def _decimal(number: Number) -> Decimal:
    fact = number.fact
    return Decimal(repr(float(to_unit(fact.value, fact.unit, fact.dimension) if fact.unit else fact.value)))


def _to_digits(number: Number, digits: int) -> Grid:
    exact = _decimal(number)
    step = Decimal(1).scaleb(exact.adjusted() - digits + 1)
    return _grid(number, exact, step, number.fact.unit, digits, counted(digits, "digits"))


def _stepped(number: Number, text: str) -> Grid:
    """Whole steps; the unit is that of the step."""
    fact = number.fact
    try:
        said = read_quantity(text, fact.dimension)
    except QuantityError as error:
        raise InputError(f'--round {number.name}="{text}": {error}') from None
    step = Decimal(repr(float(to_unit(said.value, said.unit, fact.dimension) if said.unit else said.value)))
    if step <= 0:
        raise InputError(f'--round {number.name}="{text}": a step is greater than zero. Write "{_example(number)}".')
    exact = Decimal(repr(float(to_unit(fact.value, said.unit, fact.dimension) if said.unit else fact.value)))
    if exact < step and number.least:
        raise InputError(
            f'--round {number.name}="{text}": the step is greater than the value, {exact:.4g} {said.unit}. Write a '
            f'smaller one, "{_example(number)}".'
        )
    digits = max(1, exact.adjusted() - step.adjusted() + 1)
    return _grid(number, exact, step, said.unit, digits, f"steps of {text}")


def _grid(number: Number, exact: Decimal, step: Decimal, unit: str, digits: int, words: str) -> Grid:
    turn = _turn(number, unit)
    if turn - exact < exact % step:  # nearer to a whole turn, which is none, than to the last whole step
        exact -= turn
    count = exact / step
    near = count.to_integral_value()
    return Grid(number, step, unit, near if abs(count - near) <= Decimal("1e-9") else count, digits, words)


def _turn(number: Number, unit: str) -> Decimal:
    """A whole turn in the unit of an angle; without end for all else."""
    angle = number.fact.dimension == "angle"
    return Decimal(repr(float(to_unit(tau, unit, "angle")))) if angle else Decimal("Infinity")


def x_of(design: Design, kept: Scene) -> tuple[float, ...] | None:
    """The values of the file's variables [SI] in a frozen scene; None where one leaves its range."""
    known = {fact.path.removesuffix(".value"): fact.value for fact in facts(kept)}
    found = []
    for variable, exact in zip(design.scene.variables, design.x, strict=True):
        value = next(_values(variable, kept, known), exact)
        low, high = variable.low * (1.0 - _EDGE), variable.high * (1.0 + _EDGE)
        if variable.values is None and not low <= value <= high:
            return None
        found.append(value)
    return tuple(found)


def _values(variable: Variable, kept: Scene, known: dict[str, float]) -> Iterator[float]:
    if variable.values is not None:
        return
    if variable.path in known:
        yield known[variable.path]
    family, name, word = [*variable.path.split("."), ""][:3]
    if family == "absorbers" and variable.path.count(".") == 2:
        yield from _of_absorber(kept, name, word)


def _of_absorber(kept: Scene, name: str, word: str) -> Iterator[float]:
    """A ratio or a frequency of an absorber from its parts as built."""
    machine = machine_of(kept, {})
    joint, mass, tuned = machine.joint(name), machine.masses[name], machine.tuned[name]
    own = float(np.sqrt(joint.stiffness / mass))
    found = {
        "mass_ratio": mass / tuned.mass if tuned.mass else 0.0,
        "tuning": own / tuned.frequency if tuned.frequency else 0.0,
        "frequency": own,
        "damping_ratio": joint.damping_ratio,
        "length": GRAVITY / own**2 if own else 0.0,
    }
    if word in found:
        yield float(found[word])
