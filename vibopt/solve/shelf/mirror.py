"""Groups that may be exchanged without changing anything: of two such choices one is enough."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np

from vibopt.forms import BoolArray, FloatArray, Form, IntArray, Modulus, Monomials, StaticLoad, StaticRow
from vibopt.mechanics.model import Model
from vibopt.program.program import Program
from vibopt.records import dataclass
from vibopt.solve.shelf.tree import Shelf


@dataclass(frozen=True, slots=True)
class Mirror:
    """Factors (part, count, ...) of one group and those of another, in the same order."""

    one: tuple[int, ...]
    other: tuple[int, ...]

    def first(self, chosen: IntArray) -> BoolArray:
        """Choices (n, n_factors) that stand for themselves and their mirror image, shape (n,)."""
        kept = np.ones(len(chosen), dtype=bool)
        level = np.ones(len(chosen), dtype=bool)
        for here, there in zip(self.one, self.other, strict=True):
            kept &= ~(level & (chosen[:, here] > chosen[:, there]))
            level &= chosen[:, here] == chosen[:, there]
        return kept

    def images(self, chosen: IntArray) -> IntArray:
        """Mirror images of choices, those left out that are their own."""
        turned = chosen.copy()
        turned[:, list(self.one)], turned[:, list(self.other)] = chosen[:, list(self.other)], chosen[:, list(self.one)]
        found: IntArray = turned[(turned != chosen).any(axis=1)]
        return found


def mirrors(program: Program, shelf: Shelf) -> list[Mirror]:
    """Pairs of groups that may be exchanged, so that each chain of them keeps one order."""
    groups: dict[str, list[int]] = {}
    for index, factor in enumerate(shelf.factors):
        groups.setdefault(".".join(factor.path.split(".")[:2]), []).append(index)
    found = []
    for one, other in combinations(groups.values(), 2):
        if _alike(shelf, one, other) and _unchanged(program, shelf, one, other):
            found.append(Mirror(tuple(one), tuple(other)))
    return found


def _alike(shelf: Shelf, one: list[int], other: list[int]) -> bool:
    if len(one) != len(other):
        return False
    pairs = [(shelf.factors[i], shelf.factors[j]) for i, j in zip(one, other, strict=True)]
    return all(
        a.path.split(".")[2:] == b.path.split(".")[2:] and np.array_equal(a.table, b.table) and a.names == b.names
        for a, b in pairs
    )


def _unchanged(program: Program, shelf: Shelf, one: list[int], other: list[int]) -> bool:
    """Whether the limits and the goal are the same with the variables of both groups exchanged."""
    order = np.arange(len(program.axes))
    for i, j in zip(one, other, strict=True):
        here, there = list(shelf.factors[i].axes), list(shelf.factors[j].axes)
        order[here], order[there] = order[there], order[here]
    asked = [_said(part, order) for part in program.parts]
    return sorted(map(repr, asked)) == sorted(repr(_said(part, np.arange(len(order)))) for part in program.parts)


def _said(part: Any, order: IntArray) -> tuple[Any, ...]:
    """A limit or the goal as plain data, its variables renumbered."""
    model, form = part.model, part.form
    own = (type(form).__name__, getattr(part, "side", "goal"), getattr(part, "bound", 0.0), getattr(part, "upper", 0.0))
    return (*own, _of_form(model, form, order), () if isinstance(form, Monomials) else _terms(model, form, order))


def _of_form(model: Model, form: Form, order: IntArray) -> tuple[Any, ...]:
    if isinstance(form, Monomials):
        return tuple(sorted((float(s), _tuple(e[order])) for s, e in zip(form.scale, form.exponents, strict=True)))
    if isinstance(form, StaticLoad):
        return (_row(form.row), _of_form(model, form.factor, order))
    if isinstance(form, StaticRow):
        return (_row(form.row),)
    if isinstance(form, Modulus):
        shared = form.output.shared_by
        share = model.counts[shared].row(model.n_vars)[order] if shared else np.zeros(0)
        drives = tuple((one.name, one.bands) for one in form.drives)
        return (_tuple(form.output.row), form.output.power, _tuple(share), form.combine, form.rigid_link, drives)
    return tuple(getattr(form, name) for name in ("mode",) if hasattr(form, name))


def _terms(model: Model, form: Form, order: IntArray) -> tuple[Any, ...]:
    signs = form.output.signs if isinstance(form, Modulus) else np.zeros(len(model.terms))
    return tuple(
        sorted(
            (one.kind, _row(one.vector), one.scale, one.static_scale, _tuple(one.exponents[order]), float(sign))
            for one, sign in zip(model.terms, signs, strict=True)
        )
    )


def _row(row: FloatArray) -> tuple[float, ...]:
    """A row without its sign: springs and the size of a squeeze do not know it."""
    turned = row if not row.any() or row[np.flatnonzero(row)[0]] > 0 else -row
    return _tuple(turned)


def _tuple(row: FloatArray) -> tuple[float, ...]:
    return tuple(float(one) + 0.0 for one in row)


__all__ = ["Mirror", "mirrors"]
