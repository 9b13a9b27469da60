"""A body whose centre of mass may be off: its inertia as terms in the factors of three offsets.

The coordinates stay those of the centre as said.  With the mass at delta from it, along each direction k the energy
is m (v_k + (omega x delta)_k)^2; a product of two motions is 2ab = ((a+b)^2 - (a-b)^2) / 2, so some terms have a
negative scale and only their sum is an inertia.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import combinations

from vibopt.devices.symbols import Symbols
from vibopt.mechanics.builder import ModelBuilder
from vibopt.mechanics.model import INERTIA
from vibopt.mechanics.monomial import Monomial
from vibopt.values.directions import AXES, Vector

SPAN = 0.5
"""An offset runs over its tolerance as its factor runs over 1 +- this."""
_TURNED = {"x": {"y": ("rz", -1.0), "z": ("ry", 1.0)}, "y": {"z": ("rx", -1.0), "x": ("rz", 1.0)}}
_TURNED |= {"z": {"x": ("ry", -1.0), "y": ("rx", 1.0)}}
"""omega x delta: per direction and component of delta the turn that moves it, and with which sign."""

Row = Mapping[str, float]
Sum = list[Monomial]


def offset_of(factor: float, tolerance: float) -> float:
    """How far off the centre is along an axis [m] at a factor."""
    return (factor - 1.0) / SPAN * tolerance


def factor_of(offset: float, tolerance: float) -> float:
    """The factor at which the centre is so far off along an axis [m]."""
    return 1.0 + SPAN * offset / tolerance


def add_offset(
    builder: ModelBuilder, name: str, freedoms: tuple[str, ...], mass: Monomial, wide: Vector, symbols: Symbols
) -> None:
    """What the offsets of a body's centre add to its inertia; `wide` is their tolerance along x, y, z [m]."""
    deltas = {axis: _delta(name, axis, size, symbols) for axis, size in zip(AXES, wide, strict=True) if size > 0.0}
    for k, turned in _TURNED.items():
        if k not in freedoms:
            continue
        moved = {f"{name}.{k}": 1.0}
        arms = {
            axis: {f"{name}.{turn}": sign}
            for axis, (turn, sign) in turned.items()
            if axis in deltas and turn in freedoms
        }
        for axis, arm in arms.items():
            _product(builder, name, moved, arm, [mass * one for one in deltas[axis]], weighs=k == "z")
            for time in _times(deltas[axis], deltas[axis]):
                builder.add_term(INERTIA, arm, mass * time, name, 0.0)
        for one_axis, other in combinations(arms, 2):
            both = _times(deltas[one_axis], deltas[other])
            _product(builder, name, arms[one_axis], arms[other], [mass * one for one in both])


def _delta(name: str, axis: str, size: float, symbols: Symbols) -> Sum:
    """The offset as size (f - 1) / SPAN."""
    factor = symbols.off(f"bodies.{name}.centre.{axis}", Monomial(1.0))
    return [factor.times(size / SPAN), Monomial(-size / SPAN)]


def _times(one: Sum, other: Sum) -> Sum:
    return [a * b for a in one for b in other]


def _product(builder: ModelBuilder, name: str, a: Row, b: Row, size: Sum, *, weighs: bool = False) -> None:
    """2 a b with a coefficient; where a is vertical its weight turns along b."""
    for sign, row in _squares(a, b):
        for one in size:
            builder.add_term(INERTIA, row, one.times(0.5 * sign), name, 1.0 if weighs else 0.0)


def _squares(a: Row, b: Row) -> Iterator[tuple[float, Row]]:
    for sign in (1.0, -1.0):
        yield sign, {key: a.get(key, 0.0) + sign * b.get(key, 0.0) for key in {**a, **b}}
