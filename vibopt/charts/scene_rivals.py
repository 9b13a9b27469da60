"""Rivals of scenes as lines: each general solver over numbers of speeds, tolerances, or designs that it may measure."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from vibopt.solve.by_name import METHODS
from vibopt.solve.method import Method
from vibopt.solve.rivals import convex_sampled, general, grid, population

SPEEDS = (50, 200, 500, 1000, 5000)
TOLERANCES = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11)
CONES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
DESIGNS = (100, 300, 1000, 3000, 10_000)
POINTS = (5, 10, 20, 40, 80)
"""Values of each variable in a grid."""
STARTS = 8

Make = Callable[[], Method]


def _line(kind: Any, key: str, settings: tuple[float, ...], words: str, **given: Any) -> dict[str, Make]:
    def at(setting: float) -> Make:
        return lambda: kind(**{key: setting}, name=f"{words} {setting:g}", **given)

    return {f"{words} {setting:g}": at(setting) for setting in settings}


LINES: Mapping[str, Mapping[str, Make]] = {
    "slsqp": _line(general.Slsqp, "speeds", SPEEDS, "slsqp"),
    "slsqp 8 starts": _line(general.Slsqp, "speeds", SPEEDS, "slsqp 8 starts", starts=STARTS),
    "slsqp peaks": _line(general.OnPeaks, "tolerance", TOLERANCES, "slsqp peaks"),
    "slsqp peaks 8 starts": _line(general.OnPeaks, "tolerance", TOLERANCES, "slsqp peaks 8 starts", starts=STARTS),
    "slsqp exchange": {
        name: make for tolerance in TOLERANCES
        for name, make in _line(general.Exchange, "tolerance", (tolerance,), "slsqp exchange",
                                close=100.0 * tolerance).items()
    },
    "slsqp exchange 8 starts": {
        name: make for tolerance in TOLERANCES
        for name, make in _line(general.Exchange, "tolerance", (tolerance,), "slsqp exchange 8 starts",
                                close=100.0 * tolerance, starts=STARTS).items()
    },
    "trust": _line(general.TrustConstr, "speeds", SPEEDS[:4], "trust"),
    "ipopt": _line(general.IpoptSampled, "speeds", SPEEDS, "ipopt"),
    "ipopt 8 starts": _line(general.IpoptSampled, "speeds", SPEEDS[:4], "ipopt 8 starts", starts=STARTS),
    "cvxpy": _line(convex_sampled.Convex, "tolerance", CONES, "cvxpy"),
    "cvxpy kept": _line(convex_sampled.Convex, "tolerance", CONES, "cvxpy kept", keep=True),
    "grid": _line(grid.Grid, "per_axis", POINTS, "grid"),
    "evolution": _line(population.DifferentialEvolution, "most", DESIGNS, "evolution"),
    "cma-es": _line(population.CmaEs, "most", DESIGNS, "cma-es"),
}  # fmt: skip
"""Rivals by name, each setting by its own."""

EVERY = {
    **dict.fromkeys(LINES, 5), "trust": 4, "ipopt 8 starts": 4, "evolution": 4, "cma-es": 4,
}  # fmt: skip
"""Settings of each line in the whole charts, and in the quick ones."""
QUICK: Mapping[str, int | tuple[int, ...]] = {
    "slsqp": 3, "slsqp peaks 8 starts": (1, 3), "slsqp exchange": (0, 2, 4), "trust": 1, "ipopt": 3,
    "cvxpy": (0, 2, 4), "cvxpy kept": (2,), "grid": (1, 2), "evolution": 2, "cma-es": 2,
}  # fmt: skip
HARD: Mapping[str, int | tuple[int, ...]] = {
    "grid": (3,), "slsqp": (1,), "slsqp peaks 8 starts": (3,), "slsqp exchange": (4,), "trust": (1,), "ipopt": (1,),
    "cvxpy": (2,), "evolution": (2,), "cma-es": (2,),
}  # fmt: skip
QUICK_HARD = {
    name: places
    for name, places in HARD.items()
    if name not in ("trust", "evolution", "cma-es", "slsqp peaks 8 starts")
}

RIVALS: Mapping[str, Make] = {name: make for line in LINES.values() for name, make in line.items()}


def method(name: str) -> Method:
    """A registered method or a rival at one of its settings."""
    return METHODS[name]() if name in METHODS else RIVALS[name]()


def absent(name: str) -> str:
    """How to get the package of a rival that is not there; "" where it is."""
    return population.HOW if name.startswith("cma-es") and not population.installed() else ""


def chosen(settings: Mapping[str, int | tuple[int, ...]]) -> tuple[str, ...]:
    """Names of rivals by line: all settings up to one, or those of these places."""
    found: list[str] = []
    for line, wanted in settings.items():
        names = list(LINES[line])
        found += names[:wanted] if isinstance(wanted, int) else [names[place] for place in wanted]
    return tuple(found)
