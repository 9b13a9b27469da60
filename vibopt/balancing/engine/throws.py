"""Which cylinders share a crank throw, at which angle it stands, and whether they can fire as the file says."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from math import gcd, pi, tau

from vibopt.balancing.engine.engine_tables import CylinderTable, EngineTable
from vibopt.document.mistakes import Mistakes
from vibopt.units.showing import show_angle

_ALIKE = 1e-6
"""Angles [rad] that are no farther apart are one."""


def throws_of(engine: EngineTable, cylinders: Sequence[CylinderTable]) -> tuple[list[int], tuple[float | None, ...]]:
    """Throw of each cylinder, and the angle of each throw [rad] (None: to be chosen).

    What is written goes before the firing order, which is counted from the first crank that is written.
    """
    throws = _shared(cylinders)
    cranks: list[float | None] = [None] * (max(throws, default=-1) + 1)
    fired = fired_cranks(engine, cylinders)
    for k, angle in reversed(list(enumerate(fired))):
        cranks[throws[k]] = angle
    for k, cylinder in enumerate(cylinders):
        if cylinder.crank is not None:
            cranks[throws[k]] = None if cylinder.crank == "choose" else cylinder.crank
    return throws, tuple(cranks)


def _shared(cylinders: Sequence[CylinderTable]) -> list[int]:
    """Throw of each cylinder, counted from 0."""
    names: dict[str, int] = {}
    return [names.setdefault(cylinder.throw or f"#{k}", len(names)) for k, cylinder in enumerate(cylinders)]


def fired_cranks(engine: EngineTable, cylinders: Sequence[CylinderTable]) -> list[float]:
    """The crank of each cylinder [rad] with which they fire at equal distances in their order; [] without one."""
    if not engine.firing_order:
        return []
    step = engine.strokes * tau / 2.0 / len(cylinders)
    found = [_bank(one) - engine.firing_order.index(k + 1) * step for k, one in enumerate(cylinders)]
    written = ((one.crank, angle) for one, angle in zip(cylinders, found, strict=True) if isinstance(one.crank, float))
    crank, there = next(written, (0.0, 0.0))
    return [(angle + crank - there) % tau for angle in found]


def check_throws(engine: EngineTable, cylinders: Sequence[CylinderTable], mistakes: Mistakes) -> None:
    """What cylinders on one throw say of its crank, in words or by the firing order."""
    fired, throws = fired_cranks(engine, cylinders), _shared(cylinders)
    for throw in range(max(throws, default=-1) + 1):
        members = [k for k, one in enumerate(throws) if one == throw]
        said = [k for k in members if cylinders[k].crank is not None]
        for k in said[1:]:
            if _unlike(cylinders[said[0]].crank, cylinders[k].crank):
                _two(mistakes, cylinders, said[0], k)
        for k in members[1:] if fired and not said else ():
            if _unlike(fired[members[0]], fired[k]):
                mistakes.add(
                    ("engine", "firing_order"),
                    f"engine.firing_order has the crank of cylinders[{members[0] + 1}] at "
                    f"{show_angle(fired[members[0]])} and that of cylinders[{k + 1}] at {show_angle(fired[k])}, but "
                    f'they share throw "{cylinders[k].throw}". Write its crank.',
                )


def _two(mistakes: Mistakes, cylinders: Sequence[CylinderTable], j: int, k: int) -> None:
    """Two cylinders on one throw have each a crank of their own."""
    here, there = (one if isinstance(one, str) else show_angle(one) for one in (cylinders[k].crank, cylinders[j].crank))
    mistakes.add(
        ("cylinders", k, "crank"),
        f'cylinders[{k + 1}] has crank = "{here}", but cylinders[{j + 1}], on the same throw "{cylinders[k].throw}", '
        f'has crank = "{there}". Write the crank of a throw once, or leave throw out.',
    )


def check_firing(engine: EngineTable, tops: Sequence[float], mistakes: Mistakes) -> None:
    """That the cylinders can fire as the file says, where every crank is known; `tops` as of `fires_in`."""
    order = engine.firing_order
    if order and not fires_in(order, tops, engine.strokes):
        one = sorted(range(len(tops)), key=lambda k: round((tops[k] - tops[0]) % tau, 6) % tau)
        mistakes.value(
            ("engine", "firing_order"), order,
            f"is not how these cranks can fire. They can as {[k + 1 for k in one]}, for example; or leave firing_order "
            "out.",
        )  # fmt: skip
    elif engine.even_firing and not fires_evenly(tops, engine.strokes):
        mistakes.add(
            ("engine", "even_firing"),
            "engine.even_firing = true, but these cranks cannot fire at equal distances. Change them, or leave "
            "even_firing out.",
        )


def fires_in(order: Sequence[int], tops: Sequence[float], strokes: int) -> bool:
    """Whether cylinders can fire in an order (numbers from 1).

    tops
        Turn of the crankshaft at which each piston is on top [rad]; with four strokes it fires at every second of them.
    """
    ordered = [tops[one - 1] for one in order]
    gaps = [(after - before + _ALIKE) % tau for before, after in zip(ordered, [*ordered[1:], ordered[0]], strict=True)]
    return sum(gaps) <= strokes * tau / 2.0 + 2.0 * len(gaps) * _ALIKE


def fires_evenly(tops: Sequence[float], strokes: int) -> bool:
    """Whether cylinders can fire at equal distances in some order: their tops mod a turn are those of such an order."""
    many = len(tops)
    places = many // gcd(many, strokes // 2)
    found = [(top - tops[0]) * places / tau for top in tops]
    counts = Counter(round(one) % places for one in found)
    near = all(abs(one - round(one)) * tau <= _ALIKE * places for one in found)
    return near and len(counts) == places and set(counts.values()) == {many // places}


def _bank(cylinder: CylinderTable) -> float:
    return cylinder.bank.value if cylinder.bank is not None else 0.0


def _unlike(one: float | str, other: float | str) -> bool:
    """Two cranks, each an angle [rad] or "choose"."""
    if isinstance(one, str) or isinstance(other, str):
        return one != other
    return abs((one - other + pi) % tau - pi) > _ALIKE
