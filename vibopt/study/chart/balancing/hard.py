"""The questions of the chart of stability: planes alike, dead and spoilt sensors, units, scatter."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vibopt.forms import ComplexArray
from vibopt.study.chart.balancing.built import (
    BUILT,
    Asked,
    asked,
    critical,
    held,
    normal,
    orthonormal,
    plain,
    spoilt,
    touching,
    turns,
    worst,
)  # fmt: skip
from vibopt.study.chart.balancing.cutting import least_worst
from vibopt.study.chart.cases import INFEASIBLE

LEFT = 1e-3
"""Residual of the questions of least squares, as a share of the readings."""


def families(*, quick: bool) -> list[Asked]:
    """All of them, or with `quick` some of each kind."""
    return [
        *condition((2, 14) if quick else (2, 4, 6, 8, 10, 12, 14)),
        *alike((1e-4, 0.0) if quick else (1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 0.0)),
        *dead_sensor(),
        *spoilt_readings(),
        *critical_sensors(),
        *units((-6, 6) if quick else (-9, -6, -3, 3, 6, 9)),
        *scatter((0.1,) if quick else (0.01, 0.1, 0.5)),
    ]


def condition(decades: tuple[int, ...]) -> list[Asked]:
    """Singular values spread over so many decades; the correction behind the readings is of size 1."""
    rng = np.random.default_rng(3)
    found = []
    for decade in decades:
        left = orthonormal(rng, 8, 4)
        H = (left[:, :3] * np.logspace(0, -decade, 3)) @ orthonormal(rng, 3, 3).conj().T
        name, family = f"condition number 1e{decade}", "condition number"
        one = _free(name, H, left[:, 3], rng, family)
        capped = replace(one.question, caps=np.full(3, 2.0))
        found += [one, asked(f"{name}, capped", capped, one.case.goal, BUILT, family)]
    return found


def alike(differences: tuple[float, ...]) -> list[Asked]:
    """Two planes whose coefficients differ by so little: least squares, and the worst with both at their caps."""
    rng = np.random.default_rng(4)
    found = []
    for difference in differences:
        name, family = f"planes alike to {difference:.0e}", "planes alike"
        basis = orthonormal(rng, 8, 3)
        H = np.stack([basis[:, 0], basis[:, 0] + difference * basis[:, 1]], axis=1)
        found.append(_free(name, H, basis[:, 2], rng, family))
        left, slope = touching(rng, 8, 3)
        u = 2.0 * turns(rng, 1)[0]
        common, own = held(basis[:, :2], slope, np.array([-0.1 * u, 0.0])).T
        H = np.stack([common, common + difference * own], axis=1)
        capped = plain(left - H @ np.array([u, u]), H, "worst", 2.0)
        found.append(asked(f"{name}, capped", capped, 1.0, BUILT, family))
    return found


def dead_sensor() -> list[Asked]:
    """A row of zeros: it shows nothing, the same whatever is fitted, or more than its limit."""
    rng = np.random.default_rng(5)
    basis = np.vstack([orthonormal(rng, 7, 3), np.zeros((1, 3))])
    silent = _free("dead sensor", basis[:, :2], basis[:, 2], rng, "dead sensor")
    y0 = silent.question.y0.copy()
    y0[-1] = 2.0
    stuck = replace(silent.question, y0=y0, goal="worst")
    limited = replace(stuck, goal="rms", limits=np.array([*[np.inf] * 7, 1.0]))
    return [
        silent,
        asked("dead sensor, stuck", stuck, 2.0, "its reading, which nothing changes", "dead sensor"),
        asked("dead sensor, limited", limited, np.nan, "its reading is twice its limit", "dead sensor", INFEASIBLE),
    ]


def spoilt_readings() -> list[Asked]:
    """Huber's goal with one and two of eight readings far off."""
    return [
        asked(f"{words} of 8 readings spoilt", *spoilt(count), BUILT, "spoilt readings")
        for count, words in ((1, "one"), (2, "two"))
    ]


def critical_sensors() -> list[Asked]:
    """Two sensors are to be quiet and the others keep a limit; corrections free, or with caps that do not bind."""
    return [
        asked("critical sensors", critical(np.inf), 1.0, BUILT, "critical sensors"),
        asked("critical sensors, caps of 10", critical(10.0), 1.0, BUILT, "critical sensors"),
    ]


def units(decades: tuple[int, ...]) -> list[Asked]:
    """The same machine with readings or corrections in other units."""
    q = worst(8, 2)
    found = []
    for decade in decades:
        s = 10.0**decade
        reading = replace(q, y0=q.y0 * s, H=q.H * s)
        weight = replace(q, H=q.H / s, caps=q.caps * s)
        for name, question, goal in (("readings", reading, s), ("corrections", weight, 1.0)):
            found.append(asked(f"{name} times 1e{decade}", question, goal, f"{BUILT}, unit changed", "units"))
    return found


def scatter(shares: tuple[float, ...]) -> list[Asked]:
    """Worst residual over 30 draws of coefficients and readings with so much scatter."""
    rng = np.random.default_rng(6)
    y0, H = normal(rng, 8), normal(rng, 8, 2)
    found = []
    for share in shares:
        noise = [rng.normal(size=(30, 8, 3)) * share for _ in range(2)]
        draws = (np.column_stack([y0, H]) * (1.0 + noise[0] + 1j * noise[1])).reshape(240, 3)
        question = plain(draws[:, 0], draws[:, 1:], "worst", 0.3)
        bound, gap = least_worst(question)
        found.append(
            asked(f"scatter of {100 * share:g} %", question, bound, f"cutting planes, gap {gap:.0e}", "scatter")
        )
    return found


def _free(name: str, H: ComplexArray, rest: ComplexArray, rng: np.random.Generator, family: str) -> Asked:
    """Readings of a correction of size 1 and of a rest at a right angle to every column."""
    question = plain(-(H @ turns(rng, H.shape[1])) + LEFT * rest, H, "rms")
    return asked(name, question, LEFT / float(np.sqrt(len(rest))), BUILT, family)
