"""A one-mass program as plain numbers and the structure that they fill: what has a closed form.

The numbers of many programs that differ in one fact are arrays over them.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from functools import cache
from math import isfinite
from operator import itemgetter
from typing import Any

import numpy as np

from vibopt.arrays import some
from vibopt.forms import Modulus, Monomials, StaticRow
from vibopt.mechanics.constants import GRAVITY
from vibopt.mechanics.model import DAMPING, HYSTERETIC, INERTIA, STIFFNESS, Model
from vibopt.mechanics.onemass import reading
from vibopt.program.program import Limit, Program
from vibopt.records import dataclass
from vibopt.signals import Line, Output
from vibopt.solve.rows import single_lines

Number = Any
"""A float, or one for each of many questions, shape (count,)."""
Numbers = Mapping[str, Number]
_OTHER = "the variables are not the stiffness and the damping of one mass."
_NO_ROW = "the limit {} is not linear in the square of the damping."
_ANY, _PART = np.array([1370.0, 1813.0]), 0.7351
"""A design and a part of a speed at which two formulas that agree are the same."""
_LETTERS = {INERTIA: "M", STIFFNESS: "K", DAMPING: "C", HYSTERETIC: "H"}


class NotClosedError(Exception):
    """A program has no closed form; the text says why."""


@dataclass(frozen=True, slots=True)
class RowKind:
    """Structure of one limit.

    kind
        "harmonic", "frequency", "damping", "static" or "monomial".
    sign
        +1 when the value must stay below the bound.
    power
        |r|^2 carries w**power, w the square of the frequency.
    through
        Whether the numerator is the impedance of some links (else a constant).
    inertia
        Whether the mass stands in the numerator.
    points
        Per band whether it is one speed.
    exponents
        Of a monomial, one tuple per term.
    tabled
        The limit itself where the amplitude is a table over the speed: then it is one question and not many.
    """

    name: str
    kind: str
    sign: float
    power: int = 0
    through: bool = False
    inertia: bool = False
    points: tuple[bool, ...] = ()
    exponents: tuple[tuple[float, ...], ...] = ()
    tabled: Limit | None = None

    def amplitude(self, omega: Number) -> Number:
        """Factor of a table at frequencies [rad/s]; one where there is none."""
        if self.tabled is None:
            return 1.0
        line = self.tabled.form.drives[0].lines[0]
        return np.abs(line.amplitude.at(omega / line.order))

    @property
    def over_speeds(self) -> bool:
        """Whether it asks for a range of speeds: else it is a row of its own."""
        return not all(self.points)


@dataclass(frozen=True, slots=True)
class Question:
    """A one-mass program.

    opened
        Of each variable whether its high end only stands for infinity.
    plane
        Variables are stiffness and damping; else there is one variable.
    order
        Indices of the variables: (k, c) or (x,).
    goal
        Place in `order` of the variable that the goal moves, and in which direction.
    rows
        Structure of each limit; its numbers are called "0.bound", "0.low0", and so on.
    numbers
        M0 + M1 x, K0 + K1 x, C0 + C1 x + Ch sqrt(x), H0 + H1 x of the machine, and those of the limits.
    """

    plane: bool
    order: tuple[int, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]
    opened: tuple[bool, ...]
    goal: tuple[int, float]
    rows: tuple[RowKind, ...]
    numbers: Numbers

    @property
    def structure(self) -> Hashable:
        """All but the numbers."""
        return (self.plane, self.order, self.low, self.high, self.opened, self.goal, self.rows, tuple(self.numbers))


def question(program: Program, like: Question | None = None) -> Question:
    """Read a program; with `like`, one that differs from a program read before in its numbers alone.

    Raises
    ------
    NotClosedError
        It is more than one mass with one variable or with a stiffness and a damping.
    """
    if program.several:
        raise NotClosedError("the limits speak of several machines, the same design within its tolerances.")
    model, axes = program.model, program.axes
    if model.n_free != 1 or model.inerters.any() or model.with_beams:
        raise NotClosedError(_OTHER)
    if any(axis.values is not None for axis in axes):
        raise NotClosedError("a variable is discrete.")
    order = _order(program) if like is None else like.order
    goal = _goal(program, order) if like is None else like.goal
    numbers = _machine(model, order, "", range(len(model.terms)))
    rows = tuple(_row(limit, index, order, numbers) for index, limit in enumerate(program.limits))
    low, high = (tuple(float(getattr(axes[i], end)) for i in order) for end in ("low", "high"))
    if not all(map(isfinite, (*low, *high, *numbers.values()))):
        raise NotClosedError("a number is without end.")
    asked = Question(len(order) == 2, order, low, high, tuple(axes[i].open_high for i in order), goal, rows, numbers)
    if like is None:
        _verify(program, asked)
    return asked


def _order(program: Program) -> tuple[int, ...]:
    """The variables: none, one, or a stiffness and a damping, in that order."""
    model, axes = program.model, program.axes
    if len(axes) < 2:
        return tuple(range(len(axes)))
    kinds = [{term.kind for term in model.terms if term.exponents[i]} for i in range(len(axes))]
    if sorted(kinds, key=sorted) != sorted([{STIFFNESS}, {DAMPING}], key=sorted):
        raise NotClosedError(_OTHER)
    return (0, 1) if kinds[0] == {STIFFNESS} else (1, 0)


def _goal(program: Program, order: tuple[int, ...]) -> tuple[int, float]:
    """Which of the variables the goal moves, and in which direction."""
    aim = program.aim
    if aim is None:
        return 0, 1.0
    for place, index in enumerate(order):
        sense = aim.direction(index)
        if sense is not None:
            return place, sense
    names = program.axes[0].path if len(order) < 2 else "stiffness or damping"
    raise NotClosedError(f"the goal {aim.name} does not simply rise or fall with {names}.")


def _machine(model: Model, order: tuple[int, ...], prefix: str, chosen: range | list[int]) -> dict[str, float]:
    """Sums of some terms of each kind as functions of the variables."""
    sums = {f"{prefix}{letter}{part}": 0.0 for letter in "MKCH" for part in "01"} | {f"{prefix}Ch": 0.0}
    for t in chosen:
        term = model.terms[t]
        powers = [e for e in term.exponents.tolist() if e]
        if powers and (len(powers) > 1 or not term.exponents[order[-1] if term.kind == DAMPING else order[0]]):
            raise NotClosedError(_OTHER)
        part = {(): "0", (1.0,): "1", (0.5,): "h"}.get(tuple(powers), "")
        name = f"{prefix}{_LETTERS[term.kind]}{part}"
        if name not in sums:
            raise NotClosedError(_OTHER)
        sums[name] += term.scale * float(term.vector[0]) ** 2
    viscous, structural = (any(sums[prefix + one] for one in names) for names in (("C0", "C1"), ("H0", "H1")))
    crowded = len(order) == 2 and any(sums[prefix + one] for one in ("M1", "C0", "Ch", "H0", "H1"))
    if crowded or (viscous and structural) or (sums[f"{prefix}Ch"] and (viscous or structural)):
        raise NotClosedError("its damping is of several kinds.")
    return sums


def _row(limit: Limit, index: int, order: tuple[int, ...], numbers: dict[str, float]) -> RowKind:
    form, sign = limit.form, 1.0 if limit.side == "at_most" else -1.0
    numbers[f"{index}.bound"] = limit.bound
    if limit.side == "outside" or not limit.bound > 0.0:
        raise NotClosedError(_NO_ROW.format(limit.name))
    if form.harmonic is not None:
        return _harmonic(limit, form.harmonic, sign, index, order, numbers)
    if form.powers is not None:
        return _monomial(limit.name, form.powers, sign, index, numbers)
    if isinstance(form, StaticRow):  # not of a load, which has its own factor
        _static(limit.model, form, index, order, numbers)
        return RowKind(limit.name, "static", sign)
    if form.one_line and form.is_polynomial(limit.model, 0):
        return RowKind(limit.name, "damping" if form.frequency is None else "frequency", sign)
    raise NotClosedError(_NO_ROW.format(limit.name))


def _static(model: Model, form: StaticRow, index: int, order: tuple[int, ...], numbers: dict[str, float]) -> None:
    """Static stiffness, and the weight per mass as the row reads it."""
    for part in "01":
        numbers[f"{index}.S{part}"] = 0.0
    for term in model.terms:
        if term.kind == STIFFNESS:
            part = "1" if order and term.exponents[order[0]] else "0"
            numbers[f"{index}.S{part}"] += term.static_scale * float(term.vector[0]) ** 2
    numbers[f"{index}.gravity"] = GRAVITY * abs(float(form.row[0]))


def _monomial(name: str, form: Monomials, sign: float, index: int, numbers: dict[str, float]) -> RowKind:
    exponents = tuple(tuple(float(e) for e in row) for row in form.exponents)
    plain = all(row[:1] in ((0.0,), (1.0,), (2.0,)) for row in exponents)
    if not (plain if len(exponents[0]) == 1 else len(exponents) == 1 and sorted(exponents[0]) == [0.0, 1.0]):
        raise NotClosedError(_NO_ROW.format(name))
    for j, scale in enumerate(form.scale):
        numbers[f"{index}.scale{j}"] = float(scale)
    return RowKind(name, "monomial", sign, exponents=exponents)


def _harmonic(
    limit: Limit, form: Modulus, sign: float, index: int, order: tuple[int, ...], numbers: dict[str, float]
) -> RowKind:
    line = form.drives[0].lines[0]
    if not single_lines(limit):
        raise NotClosedError(_NO_ROW.format(limit.name))
    piece, *others = line.amplitude.pieces
    tabled = bool(others or piece.slope)
    size, selected, inertia = _numerator(limit, form.output, line)
    numbers[f"{index}.size"] = size if tabled else abs(piece.constant) * size / line.order**piece.power
    for b, band in enumerate(form.drives[0].bands):
        numbers[f"{index}.low{b}"], numbers[f"{index}.high{b}"] = line.order * band.low, line.order * band.high
    own = _machine(limit.model, order, f"{index}.", selected or [])
    if selected is not None:
        numbers.update(own)
    power = form.output.power + (2 if inertia else 0) + (0 if tabled else piece.power)
    points = tuple(band.is_point for band in form.drives[0].bands)
    begins = min((numbers[f"{index}.low{b}"] for b in range(len(points))), default=0.0)
    if (min(power, piece.power) < 0 and not begins) or (inertia and numbers["M1"]) or not points:
        raise NotClosedError(_NO_ROW.format(limit.name))
    table = limit if tabled else None
    return RowKind(limit.name, "harmonic", sign, power, selected is not None, inertia, points, tabled=table)


def _numerator(limit: Limit, output: Output, line: Line) -> tuple[float, list[int] | None, bool]:
    """Factor, terms whose impedance stands in the numerator (None: a constant), and whether the mass does."""
    model = limit.model
    links = [t for t in range(len(model.terms)) if model.kinds[t] != INERTIA]
    read = [t for t in links if output.signs[t]]
    moved = [int(j) for j in np.flatnonzero(line.vector)]
    if len(moved) != 1 or len({float(output.signs[t] * model.vectors[t, 0]) for t in read}) > 1:
        raise NotClosedError(_NO_ROW.format(limit.name))
    place, size = moved[0], float(abs(line.vector[moved[0]]))
    if place == 0:
        if output.row[1:].any() or (bool(read) == bool(output.row[0])):
            raise NotClosedError(_NO_ROW.format(limit.name))
        return (size, read, False) if read else (size * abs(float(output.row[0])), None, False)
    joined = [t for t in links if model.vectors[t, place]]
    others = [t for t in links if t not in joined and model.vectors[t, 0]]
    if not read and not output.row[1:].any():
        return size * abs(float(output.row[0])), joined, False
    if others:
        raise NotClosedError(_NO_ROW.format(limit.name))
    if not read and output.row[0] == -output.row[place]:
        return size * abs(float(output.row[0])), None, True
    if read == joined and not output.row.any():
        return size, joined, True
    raise NotClosedError(_NO_ROW.format(limit.name))


def _verify(program: Program, asked: Question) -> None:
    """Every limit over speeds as it was read beside the model's own response, at a design and a speed of no meaning."""
    for index, limit in enumerate(program.limits):
        form = limit.form.harmonic
        if form is None:
            continue
        line, numbers = form.drives[0].lines[0], asked.numbers
        x = _ANY[: limit.model.n_vars]
        omega = _PART * (numbers[f"{index}.high0"] or 1.0)
        size = float(line.amplitude.at(np.array(omega / line.order)))
        right = abs(size * reading(limit.model, limit.model.values(x), form.output, line, omega)[0])
        design = _ANY[list(asked.order)] if asked.order else np.zeros(1)
        if not abs(value_at(asked, numbers, index, design, omega)[0] - right) <= 1e-9 * right:
            raise NotClosedError(_NO_ROW.format(limit.name))


def value_at(asked: Question, numbers: Numbers, index: int, x: Number, omega: Number) -> tuple[Number, Number]:
    """Value of a limit at designs x in the order (k, c) and frequencies, as its row has it; and its terms over it."""
    row = asked.rows[index]
    if row.kind == "monomial":
        scales = [numbers[f"{index}.scale{j}"] for j in range(len(row.exponents))]
        places = [asked.order.index(i) for i in range(len(asked.order))]
        return sum(
            scale * np.prod([x[at] ** e for at, e in zip(places, powers, strict=True)], axis=0)
            for scale, powers in zip(scales, row.exponents, strict=True)
        ), 1.0
    mass, stiff, damper, loss = machine_at(numbers, x)
    if row.kind == "frequency":
        return np.sqrt(stiff / mass), 1.0
    if row.kind == "damping":
        return damper / (2.0 * np.sqrt(stiff * mass)), 1.0
    if row.kind == "static":
        static = numbers[f"{index}.S0"] + numbers[f"{index}.S1"] * x[0]
        return numbers[f"{index}.gravity"] * mass / static, 1.0
    top = numbers[f"{index}.size"] * row.amplitude(omega) * omega**row.power * (mass if row.inertia else 1.0)
    if row.through:
        _, part, dash, lossy = machine_at(numbers, x, f"{index}.")
        top = top * np.hypot(part, omega * dash + lossy)
    with np.errstate(divide="ignore", invalid="ignore"):
        bottom = np.hypot(stiff - mass * omega**2, omega * damper + loss)
        return top / bottom, (stiff + mass * omega**2) / bottom


@cache
def coefficients(prefix: str) -> Callable[[Numbers], tuple[Number, ...]]:
    """What reads M0, M1, K0, K1, C0, C1, Ch, H0, H1 of a machine, or of the links of a numerator, in numbers."""
    names = ("M0", "M1", "K0", "K1", "C0", "C1", "Ch", "H0", "H1")
    return itemgetter(*(prefix + name for name in names))


def machine_at(numbers: Numbers, x: Number, prefix: str = "") -> tuple[Number, Number, Number, Number]:
    """M, K, C, H at designs x (n_vars, ...) in the order (k, c)."""
    m0, m1, k0, k1, c0, c1, ch, h0, h1 = coefficients(prefix)(numbers)
    damper = c1 * x[-1] + c0
    if some(ch):
        damper = damper + ch * x[0] ** 0.5
    return m0 + m1 * x[0], k0 + k1 * x[0], damper, h0 + h1 * x[0]
