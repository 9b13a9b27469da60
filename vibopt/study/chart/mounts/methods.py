"""Roads to a choice of parts in the charts: vibopt, every choice, by hand, at random, rounded; each with its claim."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from vibopt.errors import InputError, VibOptError
from vibopt.forms import FloatArray, IntArray
from vibopt.study.chart.mounts.asked import UNANSWERABLE, Asked
from vibopt.study.chart.mounts.machine import GRAVITY, Machine
from vibopt.study.chart.mounts.rounded import rounded_choice
from vibopt.study.chart.mounts.simple import grid, missed
from vibopt.study.chart.mounts.truth import broken, every_choice, least_price, prices
from vibopt.study.chart.trial import BROKEN, DEFAULT, RIGHT, SAYS_SO, Said, Trial, judged, timed

Method = Callable[[Asked, Path], Said]
"""Its answer is the part of each group."""
REFUSED = "refused"
DRAWS = 300
_BLOCK = 2000
"""Choices that are solved at once."""
_FEW = 64
"""Choices that are measured at once, the cheapest first."""


def tried(one: Asked, road: Method, method: str, runs: int, folder: Path) -> Trial:
    """Median time, and the last answer judged by plain numpy; vibopt's file and catalogue lie in `folder`."""
    return _judged(one, method, timed(lambda: road(one, folder), runs))


def _judged(one: Asked, method: str, said: Said) -> Trial:
    """A choice that costs more than the best is wrong only where it was claimed to be the best."""
    most = off = math.nan
    chosen, status = said.answer, said.status
    if chosen is not None:
        most = max(0.0, float(broken(one.machine, one.shelf, chosen[None, :])[0]))
        off = float(prices(one.machine, one.shelf, chosen[None, :])[0]) / one.case.goal - 1.0
        off = 0.0 if math.isnan(off) else off
    found = judged(one.case, method, said, most, off)
    if status == REFUSED and one.named and one.named in said.claim:
        return replace(found, verdict=RIGHT)
    if status == REFUSED and method == DEFAULT:
        return replace(found, status="error")
    if status == "infeasible" and one.case.truth == UNANSWERABLE:
        return replace(found, verdict=SAYS_SO)
    if status == "feasible" and most <= BROKEN and off > 0.0:
        return replace(found, fault="")
    return found


def by_vibopt(one: Asked, folder: Path) -> Said:
    """The answer certified, timed from the file as read; a sentence about the file is a refusal."""
    from vibopt.program.pose import pose
    from vibopt.solve.solve import solve

    try:
        scene = one.machine.scene(folder, one.shelf)
        begin = time.perf_counter()
        design = solve(scene, explain=False)
        whole = time.perf_counter() - begin
    except InputError as error:
        return Said(REFUSED, str(error))
    except VibOptError as error:
        return Said("error", str(error))
    kernel = design.timings.get("solve", math.nan)
    if not design.x:
        return Said(design.status, f"{design.claim}. {design.reason}", None, kernel, whole)
    chosen = np.array([tie.chosen(np.array(design.x)) for tie in pose(scene).ties])
    return Said(design.status, design.claim, chosen, kernel, whole)


def _every(one: Asked, folder: Path) -> Said:
    """Every choice measured, its peak found exactly."""
    return _cheapest(least_price(one.machine, one.shelf)[1])


def sampled(speeds: int) -> Method:
    """Every choice, its peak looked at on so many speeds."""

    def method(one: Asked, folder: Path) -> Said:
        machine, shelf = one.machine, one.shelf
        chosen = every_choice(machine, shelf)
        if not len(chosen):
            return Said("unproven", "nothing to choose from")
        good = [
            block[missed(machine, shelf, block, grid(machine, speeds)) <= 0.0]
            for block in np.array_split(chosen, -(-len(chosen) // _BLOCK))
        ]
        kept = np.concatenate(good)
        return _cheapest(kept[int(prices(machine, shelf, kept).argmin())] if len(kept) else None)

    return method


def _cheapest(chosen: IntArray | None) -> Said:
    if chosen is None:
        return Said("infeasible", "no choice keeps the limits")
    return Said("optimal", "the cheapest of all choices", chosen)


def _pruned(one: Asked, folder: Path) -> Said:
    """Choices in the order of their price, their peaks found exactly, up to the first that keeps every limit."""
    machine, shelf = one.machine, one.shelf
    chosen = every_choice(machine, shelf)
    chosen = chosen[np.argsort(prices(machine, shelf, chosen), kind="stable")]
    for begin in range(0, len(chosen), _FEW):
        block = chosen[begin : begin + _FEW]
        good = np.flatnonzero(broken(machine, shelf, block) <= 0.0)
        if len(good):
            return _cheapest(block[good[0]])
    return _cheapest(None)


def _random(one: Asked, folder: Path) -> Said:
    """The cheapest of 300 random choices that keeps every limit."""
    chosen = every_choice(one.machine, one.shelf)
    if not len(chosen):
        return Said("unproven", "nothing to draw from")
    drawn = chosen[np.random.default_rng(0).integers(0, len(chosen), DRAWS)]
    drawn = drawn[broken(one.machine, one.shelf, drawn) <= 0.0]
    if not len(drawn):
        return Said("unproven", f"none of {DRAWS} draws keeps the limits")
    return Said("feasible", "best of the draws", drawn[int(prices(one.machine, one.shelf, drawn).argmin())])


def by_hand(one: Asked, folder: Path) -> Said:
    """The cheapest part of each group that carries its share and is soft enough by the formula of one mass."""
    machine, shelf = one.machine, one.shelf
    if not len(shelf):
        return Said("unproven", "nothing to choose from")
    softest = _softest(machine)
    chosen = []
    for places, load in zip(machine.groups, shares(machine), strict=True):
        fits = (shelf.least <= load) & (load <= shelf.most) & (shelf.k <= softest)
        if not fits.any() or load < 0.0:
            return Said("unproven", f"no part for {load:.0f} N and {softest:.3g} N/m on {len(places)} places")
        chosen.append(int(np.where(fits, shelf.price, np.inf).argmin()))
    return Said("feasible", "carries the load, and one mass would isolate", np.array(chosen))


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


def by_rounding(one: Asked, folder: Path) -> Said:
    return Said(*rounded_choice(one.machine, one.shelf, shares(one.machine)))


METHODS: dict[str, Method] = {
    DEFAULT: by_vibopt,
    "every choice": _every,
    "cheapest first": _pruned,
    "50 speeds": sampled(50),
    "200 speeds": sampled(200),
    "by hand": by_hand,
    "at random": _random,
    "rounded": by_rounding,
}
"""With numbers of speeds: every choice, but looked at on so many speeds only."""

__all__ = [
    "DRAWS", "METHODS", "REFUSED", "Method", "by_hand", "by_rounding", "by_vibopt", "sampled", "shares",
    "tried",
]  # fmt: skip
