"""A one-mass program as plain numbers and the structure that they fill."""

from __future__ import annotations

from collections.abc import Hashable, Mapping

import numpy as np

from vibopt.forms import FloatArray, Line, ModeDamping, ModeFrequency, Modulus, Monomials, Output, StaticRow
from vibopt.mechanics.constants import GRAVITY
from vibopt.mechanics.harmonic import transfer
from vibopt.mechanics.model import DAMPING, HYSTERETIC, INERTIA, STIFFNESS, Model
from vibopt.program.program import Limit, Program
from vibopt.records import dataclass
from vibopt.solve.outer import OneVariable, StiffnessAndDamping
from vibopt.solve.rows import PlaneRows, direction, single_lines

_LETTERS = {INERTIA: "M", STIFFNESS: "K", DAMPING: "C", HYSTERETIC: "H"}


class RefusedError(Exception):
    """This question is not one of those that are answered many at a time."""


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
    """

    name: str
    kind: str
    sign: float
    power: int = 0
    through: bool = False
    inertia: bool = False
    points: tuple[bool, ...] = ()
    exponents: tuple[tuple[float, ...], ...] = ()


@dataclass(frozen=True, slots=True)
class Question:
    """A one-mass program.

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
    goal: tuple[int, float]
    rows: tuple[RowKind, ...]
    numbers: Mapping[str, float]

    @property
    def structure(self) -> Hashable:
        """All but the numbers."""
        return (self.plane, self.order, self.low, self.high, self.goal, self.rows, tuple(self.numbers))


def question(program: Program, like: Question | None = None) -> Question:
    """Read a program; with `like`, one that differs from a program read before in its numbers alone.

    Raises
    ------
    RefusedError
        It is more than one mass with one variable or with a stiffness and a damping.
    """
    if (
        program.model.inerters.any()
        or program.model.n_free != 1
        or any(axis.values is not None for axis in program.axes)
    ):
        raise RefusedError
    plane, order, goal = _kind(program) if like is None else (like.plane, like.order, like.goal)
    if not np.all(np.isfinite([*program.low, *program.high])) or any(a.open_low or a.open_high for a in program.axes):
        raise RefusedError
    numbers = _machine(program.model, order, "", range(len(program.model.terms)))
    rows = [_row(program, limit, index, order, numbers) for index, limit in enumerate(program.limits)]
    if like is None:
        _verified(program, rows, numbers)
    low, high = (tuple(float(v[i]) for i in order) for v in (program.low, program.high))
    if not all(np.isfinite(v) for v in numbers.values()):
        raise RefusedError
    return Question(plane, order, low, high, goal, tuple(rows), numbers)


def _kind(program: Program) -> tuple[bool, tuple[int, ...], tuple[int, float]]:
    if len(program.axes) == 1 and OneVariable().refuses(program) is None:
        sense = direction(program.aim, program.aim.model, 0) if program.aim is not None else 1.0
        return False, (0,), (0, sense or 1.0)
    method, rows = StiffnessAndDamping(), PlaneRows.of(program)
    if rows is None or method.refuses(program) is not None:
        raise RefusedError
    goal = method.goal(program, rows)
    assert goal is not None
    return True, rows.order, goal


def _machine(model: Model, order: tuple[int, ...], prefix: str, chosen: range | list[int]) -> dict[str, float]:
    """Sums of some terms of each kind as functions of the variables."""
    sums = {f"{prefix}{letter}{part}": 0.0 for letter in "MKCH" for part in "01"} | {f"{prefix}Ch": 0.0}
    for t in chosen:
        term = model.terms[t]
        powers = [float(e) for e in term.exponents if e]
        own = order[1] if term.kind == DAMPING and len(order) == 2 else order[0]
        if powers and (len(powers) > 1 or not term.exponents[own]):
            raise RefusedError
        part = {(): "0", (1.0,): "1", (0.5,): "h"}.get(tuple(powers), "")
        name = f"{prefix}{_LETTERS[term.kind]}{part}"
        if name not in sums:
            raise RefusedError
        sums[name] += term.scale * float(term.vector[0]) ** 2
    plain = not any(sums[f"{prefix}{one}"] for one in ("C0", "C1", "H0", "H1"))
    crowded = len(order) == 2 and any(sums[f"{prefix}{one}"] for one in ("M1", "C0", "Ch", "H0", "H1"))
    if crowded or (sums[f"{prefix}Ch"] and not plain):
        raise RefusedError
    return sums


def _row(program: Program, limit: Limit, index: int, order: tuple[int, ...], numbers: dict[str, float]) -> RowKind:
    form, sign = limit.form, 1.0 if limit.side == "at_most" else -1.0
    numbers[f"{index}.bound"] = limit.bound
    if limit.side == "outside" or not limit.bound > 0.0:
        raise RefusedError
    if isinstance(form, ModeFrequency):
        return RowKind(limit.name, "frequency", sign)
    if isinstance(form, ModeDamping):
        return RowKind(limit.name, "damping", sign)
    if isinstance(form, StaticRow):
        _static(limit.model, form, index, order, numbers)
        return RowKind(limit.name, "static", sign)
    if isinstance(form, Monomials):
        return _monomial(limit.name, form, sign, index, numbers)
    if not isinstance(form, Modulus):
        raise RefusedError
    return _harmonic(limit, form, sign, index, order, numbers)


def _static(model: Model, form: StaticRow, index: int, order: tuple[int, ...], numbers: dict[str, float]) -> None:
    """Static stiffness, and the weight per mass as the row reads it."""
    for part in "01":
        numbers[f"{index}.S{part}"] = 0.0
    for term in model.terms:
        if term.kind == STIFFNESS:
            part = "1" if term.exponents[order[0]] else "0"
            numbers[f"{index}.S{part}"] += term.static_scale * float(term.vector[0]) ** 2
    numbers[f"{index}.gravity"] = GRAVITY * abs(float(form.row[0]))


def _monomial(name: str, form: Monomials, sign: float, index: int, numbers: dict[str, float]) -> RowKind:
    exponents = tuple(tuple(float(e) for e in row) for row in form.exponents)
    if len(exponents[0]) == 1 and not all(row[0] in (0.0, 1.0, 2.0) for row in exponents):
        raise RefusedError
    for j, scale in enumerate(form.scale):
        numbers[f"{index}.scale{j}"] = float(scale)
    return RowKind(name, "monomial", sign, exponents=exponents)


def _harmonic(
    limit: Limit, form: Modulus, sign: float, index: int, order: tuple[int, ...], numbers: dict[str, float]
) -> RowKind:
    line = form.drives[0].lines[0]
    if not single_lines(limit) or len(line.amplitude.pieces) != 1 or line.amplitude.pieces[0].slope:
        raise RefusedError
    piece = line.amplitude.pieces[0]
    size, selected, inertia = _numerator(limit.model, form.output, line)
    numbers[f"{index}.size"] = abs(piece.constant) * size / line.order**piece.power
    for b, band in enumerate(form.drives[0].bands):
        numbers[f"{index}.low{b}"], numbers[f"{index}.high{b}"] = line.order * band.low, line.order * band.high
    own = _machine(limit.model, order, f"{index}.", selected or [])
    if selected is not None:
        numbers.update(own)
    power = form.output.power + piece.power + (2 if inertia else 0)
    points = tuple(band.is_point for band in form.drives[0].bands)
    if power < 0 or (inertia and numbers["M1"]) or not points:
        raise RefusedError
    return RowKind(limit.name, "harmonic", sign, power, selected is not None, inertia, points)


def _numerator(model: Model, output: Output, line: Line) -> tuple[float, list[int] | None, bool]:
    """Factor, terms whose impedance stands in the numerator (None: a constant), and whether the mass does."""
    links = [t for t in range(len(model.terms)) if model.kinds[t] != INERTIA]
    read = [t for t in links if output.signs[t]]
    moved = [int(j) for j in np.flatnonzero(line.vector)]
    if len(moved) != 1 or len({float(output.signs[t] * model.vectors[t, 0]) for t in read}) > 1:
        raise RefusedError
    place, size = moved[0], float(abs(line.vector[moved[0]]))
    if place == 0:
        if output.row[1:].any() or (bool(read) == bool(output.row[0])):
            raise RefusedError
        return (size, read, False) if read else (size * abs(float(output.row[0])), None, False)
    joined = [t for t in links if model.vectors[t, place]]
    others = [t for t in links if t not in joined and model.vectors[t, 0]]
    if not read and not output.row[1:].any():
        return size * abs(float(output.row[0])), joined, False
    if others:
        raise RefusedError
    if not read and output.row[0] == -output.row[place]:
        return size * abs(float(output.row[0])), None, True
    if read == joined and not output.row.any():
        return size, joined, True
    raise RefusedError


def _verified(program: Program, rows: list[RowKind], numbers: Mapping[str, float]) -> None:
    for index, (limit, row) in enumerate(zip(program.limits, rows, strict=True)):
        if isinstance(limit.form, Modulus):
            _same(limit, limit.form, row, numbers, index)


def _same(limit: Limit, form: Modulus, row: RowKind, numbers: Mapping[str, float], index: int) -> None:
    """The reading is compared with the model's own response at two designs and speeds."""
    line = form.drives[0].lines[0]
    high = numbers[f"{index}.high0"] or 1.0
    for part in (0.37, 1.0):
        p = limit.model.values(np.full(limit.model.n_vars, 1e3 * (1.0 + part)))
        p = np.where(np.isfinite(p), p, 0.0)
        omega = np.array([part * high])
        right = np.abs(transfer(limit.model, p, form.output, line.vector, omega)) * line.amplitude.at(
            omega / line.order
        )
        mine = _value(limit.model, p, form, row, float(omega[0]), numbers[f"{index}.size"])
        if not abs(mine - right[0]) <= 1e-9 * abs(right[0]):
            raise RefusedError


def _value(model: Model, p: FloatArray, form: Modulus, row: RowKind, omega: float, size: float) -> float:
    kinds, squares = model.kinds, model.vectors[:, 0] ** 2
    unit = np.select([kinds == INERTIA, kinds == DAMPING, kinds == HYSTERETIC], [-(omega**2), 1j * omega, 1j], 1.0)
    z = p * unit * squares
    selected = _numerator(model, form.output, form.drives[0].lines[0])[1]
    top = size * omega**row.power * (abs(z[selected].sum()) if selected is not None else 1.0)
    top *= float(p[kinds == INERTIA] @ squares[kinds == INERTIA]) if row.inertia else 1.0
    return float(top / abs(z.sum()))
