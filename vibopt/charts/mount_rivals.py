"""Ways to a choice of parts in the charts: vibopt, every choice, by hand, at random, rounded; each with its claim."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from vibopt.arrays import FloatArray, IntArray
from vibopt.charts import mount_milp
from vibopt.charts.mount_cases import UNANSWERABLE, Asked
from vibopt.charts.mount_machine import GRAVITY, Machine, Shelf
from vibopt.charts.mount_truth import beside, broken, every_choice, least_price, prices, rated
from vibopt.charts.stopwatch import answered
from vibopt.charts.trial import DEFAULT, Case, Said, Trial, judged
from vibopt.charts.verdicts import REFUSES, RIGHT, SAYS_SO
from vibopt.errors import InputError, VibOptError

Method = Callable[[Asked], Said]
"""Its answer is the part of each group."""
REFUSED = "refused"
DRAWS = 300
_BLOCK = 2000
"""Choices that are solved at once."""
_FEW = 64
"""Choices that are measured at once, the cheapest first."""


def judged_parts(case: Case, asked: Asked, method: str, said: Said) -> Trial:
    """By plain numpy; a refusal is right where it names why there is no answer."""
    most = off = math.nan
    chosen, status = said.answer, said.status
    if chosen is not None:
        most = max(0.0, float(broken(asked.machine, asked.shelf, chosen[None, :])[0]))
        off = float(prices(asked.machine, asked.shelf, chosen[None, :])[0]) / case.goal - 1.0
        off = 0.0 if math.isnan(off) else off
    trial = judged(case, method, said, most, off)
    if status == REFUSED and asked.named and asked.named in said.claim:
        return replace(trial, verdict=RIGHT)
    if status == REFUSED and method == DEFAULT:
        return replace(trial, status="error")
    if status == "infeasible" and case.truth == UNANSWERABLE:
        return replace(trial, verdict=SAYS_SO)
    return trial


def by_vibopt(asked: Asked) -> Said:
    """The answer certified, timed from the file as read; a sentence about the file is a refusal."""
    from vibopt.program.pose import pose
    from vibopt.solve.solve import solve

    with TemporaryDirectory() as folder:
        try:
            scene = asked.machine.scene(Path(folder), asked.shelf)
            design, whole, kernel = answered(lambda: solve(scene, explain=False))
        except InputError as error:
            return Said(REFUSED, str(error))
        except VibOptError as error:
            return Said("error", str(error))
        if not design.x:
            return Said(design.status, f"{design.claim}. {design.reason}", None, kernel, whole)
        chosen = np.array([tie.chosen(np.array(design.x)) for tie in pose(scene).ties])
    return Said(design.status, design.claim, chosen, kernel, whole)


def _every(asked: Asked) -> Said:
    """Every choice measured, its peak found exactly."""
    return _cheapest(least_price(asked.machine, asked.shelf)[1])


def sampled(speeds: int) -> Method:
    """Every choice, its peak looked at on so many speeds."""

    def method(asked: Asked) -> Said:
        machine, shelf = asked.machine, asked.shelf
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


def _pruned(asked: Asked) -> Said:
    """Choices in the order of their price, their peaks found exactly, up to the first that keeps every limit."""
    machine, shelf = asked.machine, asked.shelf
    chosen = every_choice(machine, shelf)
    chosen = chosen[np.argsort(prices(machine, shelf, chosen), kind="stable")]
    for begin in range(0, len(chosen), _FEW):
        block = chosen[begin : begin + _FEW]
        good = np.flatnonzero(broken(machine, shelf, block) <= 0.0)
        if len(good):
            return _cheapest(block[good[0]])
    return _cheapest(None)


def _highs(asked: Asked) -> Said:
    """HiGHS, its program exchanged until its choice holds at its exact peaks."""
    refused = mount_milp.refusal(asked.machine)
    if refused:
        return Said(REFUSES, refused)
    status, chosen = mount_milp.cheapest(asked.machine, asked.shelf)
    return Said(status, "no choice of its program is cheaper", chosen)


def _random(asked: Asked) -> Said:
    """The cheapest of 300 random choices that keeps every limit."""
    chosen = every_choice(asked.machine, asked.shelf)
    if not len(chosen):
        return Said("unproven", "nothing to draw from")
    drawn = chosen[np.random.default_rng(0).integers(0, len(chosen), DRAWS)]
    drawn = drawn[broken(asked.machine, asked.shelf, drawn) <= 0.0]
    if not len(drawn):
        return Said("unproven", f"none of {DRAWS} draws keeps the limits")
    return Said("feasible", "best of the draws", drawn[int(prices(asked.machine, asked.shelf, drawn).argmin())])


def by_hand(asked: Asked) -> Said:
    """The cheapest part of each group that carries its share and is soft enough by the formula of one mass."""
    machine, shelf = asked.machine, asked.shelf
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


def by_rounding(asked: Asked) -> Said:
    return Said(*rounded_choice(asked.machine, asked.shelf, shares(asked.machine)))


SAMPLES = (20, 50, 200, 500, 2000)
METHODS: dict[str, Method] = {
    DEFAULT: by_vibopt,
    "every choice": _every,
    "cheapest first": _pruned,
    "highs exchange": _highs,
    **{f"sampled {count}": sampled(count) for count in SAMPLES},
    "by hand": by_hand,
    "at random": _random,
    "rounded": by_rounding,
}
"""Sampled: every choice, but looked at on so many speeds only."""
HARD_METHODS: dict[str, Method] = {
    DEFAULT: by_vibopt,
    "sampled 50": sampled(50),
    "sampled 1000": sampled(1000),
    "slsqp, rounded": by_rounding,
    "by hand": by_hand,
}

SPEEDS = 200
_ANY = 1e30
"""A load [N] that no part is asked to carry."""


def rounded_choice(machine: Machine, shelf: Shelf, shares: FloatArray) -> tuple[str, str, IntArray | None]:
    """Status, claim and choice.

    Price, loss factor and the softness of slow motion follow the stiffness by straight lines through the shelf, in
    logarithms.  Of the parts that carry their group's share the one with the nearest stiffness is bought.
    """
    from scipy.optimize import minimize

    if not len(shelf):
        return "unproven", "nothing to choose from", None
    low, high = np.log(shelf.k.min()), np.log(shelf.k.max())
    speeds = grid(machine, SPEEDS)
    counts = np.array([len(places) for places in machine.groups])
    chosen = np.arange(len(counts))[None, :]

    def keeps(y: FloatArray) -> float:
        """Above zero where every limit but the loads holds at the sampled speeds."""
        worst = float(missed(machine, made(shelf, y), chosen, speeds)[0])
        return -worst if np.isfinite(worst) else -1e3

    def cost(y: FloatArray) -> float:
        return float(made(shelf, y).price @ counts) / float(shelf.price.mean())

    found: Any = minimize(
        cost,
        np.full(len(counts), 0.5 * (low + high)),
        method="SLSQP",
        bounds=[(low, high)] * len(counts),
        constraints=[{"type": "ineq", "fun": keeps}],
    )
    if not found.success:
        return "unproven", f"SLSQP: {found.message}", None
    carries = (shelf.least <= shares[:, None]) & (shares[:, None] <= shelf.most)
    if not carries.any(axis=1).all():
        return "unproven", "no part carries its share", None
    far = np.where(carries, np.abs(np.log(shelf.k) - found.x[:, None]), np.inf)
    return "feasible", "nearest stiffness that carries its share", far.argmin(axis=1)


def made(shelf: Shelf, y: FloatArray) -> Shelf:
    """Parts of the stiffnesses exp(y) (n,), their other columns by straight lines through the shelf."""

    def line(values: FloatArray) -> FloatArray:
        if np.ptp(shelf.k) == 0.0 or (values <= 0.0).any():
            return np.full(len(y), values.mean())
        return np.asarray(np.exp(np.polyval(np.polyfit(np.log(shelf.k), np.log(values), 1), y)))

    free = np.full(len(y), _ANY)
    return replace(
        shelf, least=-free, most=free, k=np.exp(y), shear=line(shelf.shear), static=line(shelf.static),
        loss=line(shelf.loss), price=line(shelf.price),
    )  # fmt: skip


def missed(machine: Machine, shelf: Shelf, chosen: IntArray, speeds: FloatArray) -> FloatArray:
    """Greatest violation as a script would have it, as a part of the bound.

    Parameters
    ----------
    machine, shelf
        What is asked.
    chosen
        Part of each group, shape (n_choices, n_groups).
    speeds
        Speeds at which the displacement is looked at, shape (n_speeds,) [rad/s].

    Returns
    -------
    FloatArray
        Shape (n_choices,).

    Raises
    ------
    numpy.linalg.LinAlgError
        A matrix is singular to the last digit.
    """
    mass, dynamic, static = machine.matrices(shelf, chosen)
    up, n = machine.kept.index(2), len(mass)
    weight = np.zeros((len(chosen), n, 1))
    weight[:, up] = machine.mass * GRAVITY
    worst = rated(machine, shelf, chosen, np.asarray(np.linalg.solve(static, weight)[..., 0]))
    if machine.highest is not None or machine.apart is not None:
        values = np.sort(np.linalg.eigvals(np.linalg.solve(mass, dynamic.real)).real, axis=1)
        worst = np.maximum(worst, beside(machine, np.sqrt(np.maximum(values, 0.0)) / (2.0 * np.pi)))
    if machine.floor is not None or machine.sway is not None:
        every = np.append(speeds, machine.omega)
        stiff = dynamic[:, None] - (every**2)[:, None, None] * mass
        force = (machine.push() * ((every / machine.omega) ** 2)[:, None])[..., None].astype(complex)
        u = np.linalg.solve(stiff, np.broadcast_to(force, (*stiff.shape[:-1], 1)))[..., 0]
        if machine.floor is not None:
            worst = np.maximum(worst, np.abs((dynamic[:, up] * u[:, -1]).sum(axis=-1)) / machine.floor - 1.0)
        if machine.sway is not None:
            worst = np.maximum(worst, np.abs(u @ machine.reads()).max(axis=1) / machine.sway - 1.0)
    return worst


def grid(machine: Machine, count: int) -> FloatArray:
    """Equal steps up to full speed, (count,) [rad/s]."""
    return np.linspace(0.0, machine.omega, count + 1)[1:]
