"""Drop what is not excited or not observed; exact, for every value of the design variables.

In mass-normalised coordinates every operator of the equations is symmetric.  The smallest space
that holds the excitations and that no operator leaves carries the whole motion; within it, the
smallest space that holds the readings carries all that is asked.  Symmetric machines lose their
antisymmetric modes this way.  The certificate of a design always uses the full machine.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.errors import counted
from vibopt.mechanics.model import DAMPING, HYSTERETIC, INERTIA, STIFFNESS, Model
from vibopt.records import cached_property, dataclass
from vibopt.signals import Output

if TYPE_CHECKING:
    from vibopt.forms.form import Form

_TINY = 1e-13
_PLAIN = 1e-6
"""Part of its terms from which on a sum is no rounding."""


@dataclass(frozen=True, slots=True)
class Reach:
    """What moves a machine and what is read of it, rows (n_coords,); `static` where it is under the weights alone."""

    loads: list[FloatArray]
    read: list[FloatArray]
    static: bool = False


def driven(model: Model, output: Output, loads: list[FloatArray]) -> Reach:
    """Under loads, which may move bases."""
    if any(load[model.n_free :].any() for load in loads):
        loads = [*loads, *(row for row in model.vectors if row[model.n_free :].any())]
    return Reach(loads, rows_of(model, output))


def weighed(model: Model, read: list[FloatArray]) -> Reach:
    """Under the weights."""
    return Reach([term.vector for term in model.terms if term.kind == INERTIA and term.static_scale], read, static=True)


def rows_of(model: Model, output: Output) -> list[FloatArray]:
    """Rows that an output reads: its own, and the extension of each link whose force it takes."""
    rows = [output.row] if output.row.any() else []
    return rows + [model.vectors[t] for t in np.flatnonzero(output.signs)]


def reduced(model: Model, form: Form) -> Model:
    """The smallest exact model for one form; the same model where nothing can be left out."""
    found = _needed(model, form)
    if found is None:
        return model
    within, kept = found
    if kept.shape[1] in (0, model.n_free):
        return model
    if kept.shape[1] == within.basis.shape[1]:
        return within.model
    return model.on_basis(within.root @ within.basis @ kept, drop=True)


def unmoved(model: Model, form: Form) -> bool:
    """Whether no load moves what a form reads, whatever the values of the variables; weights are no load."""
    found, reach = _needed(model, form), form.reach(model)
    if found is None or reach is None or reach.static or found[1].shape[1]:
        return False
    n = model.n_free
    return not any(row[n:].any() for row in reach.read) or not any(load[n:].any() for load in reach.loads)


def _needed(model: Model, form: Form) -> tuple[_Reached, FloatArray] | None:
    """What loads move, and in its basis (n_reached, n_needed) what a form reads of it; None where plainly all of it."""
    n = model.n_free
    reach = form.reach(model) if n > 1 and not model.massless.any() and not model.spins else None
    if reach is None or (n == 2 and both_needed(model, reach)):
        return None
    within = _reached(model, reach)
    seen = within.basis.T @ (within.root.T @ _table(model, reach.read))
    return within, _closed(seen, within.singles, lambda: within.operators)


def both_needed(model: Model, reach: Reach) -> bool:
    """Whether of two coordinates a varied spring or damper between known masses plainly leaves neither out.

    It takes the motion that loads begin out of its line, and it is out of line with what is read.
    """
    mass, varied = [0.0, 0.0], dict[tuple[float, ...], list[list[float]]]()
    for term in model.terms:
        row, powers = term.vector[:2].tolist(), term.exponents.tolist()
        if any(powers):
            varied.setdefault((term.kind, *powers), []).append(row)
        elif term.kind == INERTIA:
            mass = [mass[0] + term.scale * row[0] ** 2, mass[1] + term.scale * row[1] ** 2]
        if term.kind == INERTIA and (any(powers) or all(row)):
            return False
    if reach.static or not all(mass):
        return False

    def turned(along: list[float], row: FloatArray) -> bool:
        (a, b), (first, second, *_) = along, row.tolist()
        whole, size = abs(a * second) + abs(b * first), abs(a * first) / mass[0] + abs(b * second) / mass[1]
        across, held = abs(a * second - b * first), abs(a * first / mass[0] + b * second / mass[1])
        return bool(across > _PLAIN * whole and held > _PLAIN * size)

    lone = [rows[0] for rows in varied.values() if len(rows) == 1]
    return all(any(turned(along, row) for along in lone for row in rows) for rows in (reach.loads, reach.read))


@dataclass(frozen=True)
class _Reached:
    """What some loads can move of a model.

    basis
        Shape (n_free, n_reached), in coordinates of M^-1/2 = `root`.
    singles
        Of the model, in that basis.
    every
        Makes the operators of the whole model.
    """

    whole: Model
    root: FloatArray
    basis: FloatArray
    singles: FloatArray
    every: Callable[[], list[FloatArray]]

    @cached_property
    def operators(self) -> list[FloatArray]:
        """In the basis."""
        return [self.basis.T @ one @ self.basis for one in self.every()]

    @cached_property
    def model(self) -> Model:
        """The model with nothing but that."""
        return self.whole.on_basis(self.root @ self.basis, drop=True)


_KEPT = 16
_reached_last: dict[tuple[int, bool, bytes], _Reached] = {}
"""Of the last models: the loads of many limits are the same."""


def _reached(model: Model, asked: Reach) -> _Reached:
    loads = _table(model, asked.loads)
    key = id(model), asked.static, loads.tobytes()
    if key not in _reached_last:
        while len(_reached_last) >= _KEPT:
            _reached_last.pop(next(iter(_reached_last)), None)
        root, singles, operators = _operators(model, static=asked.static)
        reach = _closed(root.T @ loads, singles, operators)
        _reached_last[key] = _Reached(model, root, reach, reach.T @ singles, operators)  # keeps the model, and its id
    return _reached_last[key]


def reason(declared: int, used: int) -> str:
    """Why so many degrees of freedom, as a sentence without its end."""
    left = declared - used
    if used == 0:
        return "nothing that vibrates is asked for"
    if left == 0:
        return "every mode is excited and observed" if declared > 1 else ""
    modes = f"{counted(left, 'modes')} {'is' if left == 1 else 'are'}"
    return f"{modes} not excited or not observed"


def _table(model: Model, rows: list[FloatArray]) -> FloatArray:
    """Rows on the free coordinates as columns (n_free, n_rows); there may be none, where nothing is to be seen."""
    return np.array(rows).reshape(-1, model.n_coords).T[: model.n_free]


def _operators(model: Model, *, static: bool) -> tuple[FloatArray, FloatArray, Callable[[], list[FloatArray]]]:
    """M^-1/2 at nominal masses, the rank-one vectors of variable terms, and what makes the operators.

    Terms that vary alike, as those of identical mounts, are one operator.
    """
    n = model.n_free
    fixed = ~model.exponents.any(axis=1) if model.n_vars else np.ones(len(model.terms), dtype=bool)
    scales = np.where(model.kinds == INERTIA, model.scales, model.static_scales) if static else model.scales
    p = scales * np.where(fixed, 1.0, 0.0)
    mass = model.matrix(INERTIA, p)[:n, :n]
    for t in np.flatnonzero(~fixed & (model.kinds == INERTIA)):
        row = model.vectors[t, :n]
        mass += np.outer(row, row) * max(float(np.diag(mass).max()), 1.0)
    root = np.linalg.inv(np.linalg.cholesky(mass)).T
    alike: dict[tuple[float, ...], list[int]] = {}
    for t in np.flatnonzero(~fixed):
        alike.setdefault((float(model.kinds[t]), *model.exponents[t]), []).append(int(t))

    @cache
    def operators() -> list[FloatArray]:
        found = [root.T @ model.matrix(kind, p)[:n, :n] @ root for kind in (STIFFNESS, DAMPING, HYSTERETIC)]
        for group in alike.values():
            if len(group) > 1:
                rows = model.vectors[group, :n] @ root
                found.append((rows.T * scales[group]) @ rows)
        return [_tidy(one) for one in found if one.any()]

    lone = [group[0] for group in alike.values() if len(group) == 1]
    return root, root.T @ model.vectors[lone, :n].T, operators


def _closed(start: FloatArray, singles: FloatArray, operators: Callable[[], list[FloatArray]]) -> FloatArray:
    """As `closure`; the operators are made only where the rank-one vectors leave something out."""
    found = closure(start, [], singles)
    return found if found.shape[1] in (0, len(start)) else closure(start, operators(), singles)


def _tidy(operator: FloatArray) -> FloatArray:
    """A positive operator without the couplings that are rounding: what does not couple must not by a long chain."""
    size = np.sqrt(np.abs(np.diag(operator)))
    tidy: FloatArray = np.where(np.abs(operator) <= _TINY * np.outer(size, size), 0.0, operator)
    return tidy


def closure(start: FloatArray, operators: list[FloatArray], singles: FloatArray) -> FloatArray:
    """Orthonormal basis of the smallest invariant space that holds `start`, shape (n, r)."""
    basis = np.zeros((start.shape[0], 0))
    todo = list(start.T)
    waiting = list(singles.T)
    while todo and basis.shape[1] < len(start):
        vector = todo.pop(0)
        fresh = _new_direction(basis, vector)
        if fresh is None:
            continue
        basis = np.column_stack([basis, fresh])
        todo += [operator @ fresh for operator in operators]
        touched = [b for b in waiting if abs(b @ fresh) > _TINY * np.sqrt(b @ b)]
        todo += touched
        waiting = [b for b in waiting if not any(b is one for one in touched)]
    return basis


def _new_direction(basis: FloatArray, vector: FloatArray) -> FloatArray | None:
    size = np.sqrt(vector @ vector)
    if size == 0.0:
        return None
    rest = vector / size
    for _ in range(2 if basis.shape[1] else 0):
        rest = rest - basis @ (basis.T @ rest)
    left = np.sqrt(rest @ rest)
    if left <= _TINY:
        return None
    fresh: FloatArray = rest / left
    return fresh
