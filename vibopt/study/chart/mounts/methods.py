"""Roads to a choice of parts in the charts: vibopt, every choice, by hand, at random, rounded; each with its claim."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from statistics import median

import numpy as np

from vibopt.errors import InputError, VibOptError
from vibopt.forms import FloatArray, IntArray
from vibopt.study.chart.mounts.asked import UNANSWERABLE, Asked
from vibopt.study.chart.mounts.machine import GRAVITY, Machine
from vibopt.study.chart.mounts.rounded import rounded_choice
from vibopt.study.chart.mounts.simple import grid, missed
from vibopt.study.chart.mounts.truth import broken, every_choice, least_price, prices
from vibopt.study.chart.trial import BROKEN, DEFAULT, RIGHT, SAYS_SO, Trial, judged

Answer = tuple[str, str, IntArray | None]
"""Status, claim and the part of each group."""
Method = Callable[[Asked, Path], Answer]
REFUSED = "refused"
DRAWS = 300
_LONG = 2.0
_BLOCK = 2000
"""Choices that are solved at once."""


def tried(one: Asked, road: Method, method: str, runs: int, folder: Path) -> Trial:
    """Median time, and the last answer judged by plain numpy; vibopt's file and catalogue lie in `folder`."""
    times: list[float] = []
    answer: Answer = ("error", "", None)
    try:
        for _ in range(runs):
            begin = time.perf_counter()
            answer = road(one, folder)
            times.append(time.perf_counter() - begin)
            if times[-1] > _LONG:
                break
    except Exception as error:  # a method that breaks down ends its own trial only
        times.append(math.nan)
        answer = ("error", f"{type(error).__name__}: {error}", None)
    return _judged(one, method, float(median(times)), *answer)


def _judged(one: Asked, method: str, seconds: float, status: str, claim: str, chosen: IntArray | None) -> Trial:
    """A choice that costs more than the best is wrong only where it was claimed to be the best."""
    most = off = math.nan
    if chosen is not None:
        most = max(0.0, float(broken(one.machine, one.shelf, chosen[None, :])[0]))
        off = float(prices(one.machine, one.shelf, chosen[None, :])[0]) / one.case.goal - 1.0
        off = 0.0 if math.isnan(off) else off
    found = judged(one.case, method, seconds, status, claim, most, off)
    if status == REFUSED and one.named and one.named in claim:
        return replace(found, verdict=RIGHT)
    if status == REFUSED and method == DEFAULT:
        return replace(found, status="error")
    if status == "infeasible" and one.case.truth == UNANSWERABLE:
        return replace(found, verdict=SAYS_SO)
    if status == "feasible" and most <= BROKEN and off > 0.0:
        return replace(found, fault="")
    return found


def by_vibopt(one: Asked, folder: Path) -> Answer:
    """The file is read and the answer certified; a sentence about the file is a refusal."""
    from vibopt.program.pose import pose
    from vibopt.solve.solve import solve

    try:
        scene = one.machine.scene(folder, one.shelf)
        design = solve(scene, explain=False)
    except InputError as error:
        return REFUSED, str(error), None
    except VibOptError as error:
        return "error", str(error), None
    if not design.x:
        return design.status, f"{design.claim}. {design.reason}", None
    chosen = np.array([tie.chosen(np.array(design.x)) for tie in pose(scene).ties])
    return design.status, design.claim, chosen


def _every(one: Asked, folder: Path) -> Answer:
    """Every choice measured, its peak found exactly."""
    return _cheapest(least_price(one.machine, one.shelf)[1])


def sampled(speeds: int) -> Method:
    """Every choice, its peak looked at on so many speeds."""

    def method(one: Asked, folder: Path) -> Answer:
        machine, shelf = one.machine, one.shelf
        chosen = every_choice(machine, shelf)
        if not len(chosen):
            return "unproven", "nothing to choose from", None
        good = [
            block[missed(machine, shelf, block, grid(machine, speeds)) <= 0.0]
            for block in np.array_split(chosen, -(-len(chosen) // _BLOCK))
        ]
        kept = np.concatenate(good)
        return _cheapest(kept[int(prices(machine, shelf, kept).argmin())] if len(kept) else None)

    return method


def _cheapest(chosen: IntArray | None) -> Answer:
    if chosen is None:
        return "infeasible", "no choice keeps the limits", None
    return "optimal", "the cheapest of all choices", chosen


def _random(one: Asked, folder: Path) -> Answer:
    """The cheapest of 300 random choices that keeps every limit."""
    chosen = every_choice(one.machine, one.shelf)
    if not len(chosen):
        return "unproven", "nothing to draw from", None
    drawn = chosen[np.random.default_rng(0).integers(0, len(chosen), DRAWS)]
    drawn = drawn[broken(one.machine, one.shelf, drawn) <= 0.0]
    if not len(drawn):
        return "unproven", f"none of {DRAWS} draws keeps the limits", None
    return "feasible", "best of the draws", drawn[int(prices(one.machine, one.shelf, drawn).argmin())]


def by_hand(one: Asked, folder: Path) -> Answer:
    """The cheapest part of each group that carries its share and is soft enough by the formula of one mass."""
    machine, shelf = one.machine, one.shelf
    if not len(shelf):
        return "unproven", "nothing to choose from", None
    softest = _softest(machine)
    chosen = []
    for places, load in zip(machine.groups, shares(machine), strict=True):
        fits = (shelf.least <= load) & (load <= shelf.most) & (shelf.k <= softest)
        if not fits.any() or load < 0.0:
            return "unproven", f"no part for {load:.0f} N and {softest:.3g} N/m on {len(places)} places", None
        chosen.append(int(np.where(fits, shelf.price, np.inf).argmin()))
    return "feasible", "carries the load, and one mass would isolate", np.array(chosen)


def _softest(machine: Machine) -> float:
    """Most stiffness of one mount [N/m]: the isolated part of the force of one mass without damping."""
    mounts = sum(len(places) for places in machine.groups)
    most = math.inf
    if machine.floor is not None:
        most = min(most, machine.mass * machine.omega**2 / (1.0 + machine.force / machine.floor))
    if machine.highest is not None:
        most = min(most, machine.mass * (2.0 * np.pi * machine.highest) ** 2)
    return most / mounts


def shares(machine: Machine) -> FloatArray:
    """Load of one mount of each group by the lever along x [N]; the nearest two groups of several share alike."""
    x = np.array([place[0] for places in machine.groups for place in places])
    lever = np.stack([np.ones(len(x)), x - machine.centre[0]])
    each = np.linalg.lstsq(lever, np.array([machine.mass * GRAVITY, 0.0]), rcond=None)[0]
    ends = np.cumsum([len(places) for places in machine.groups])[:-1]
    return np.array([part.mean() for part in np.split(each, ends)])


def by_rounding(one: Asked, folder: Path) -> Answer:
    return rounded_choice(one.machine, one.shelf, shares(one.machine))


METHODS: dict[str, Method] = {
    DEFAULT: by_vibopt,
    "every choice": _every,
    "50 speeds": sampled(50),
    "200 speeds": sampled(200),
    "by hand": by_hand,
    "at random": _random,
    "rounded": by_rounding,
}
"""With numbers of speeds: every choice, but looked at on so many speeds only."""

__all__ = [
    "DRAWS", "METHODS", "REFUSED", "Answer", "Method", "by_hand", "by_rounding", "by_vibopt", "sampled", "shares",
    "tried",
]  # fmt: skip
