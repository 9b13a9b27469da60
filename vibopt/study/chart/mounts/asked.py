"""A machine and a shelf, with the choice that is truly best."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from vibopt.study.chart.cases import FEASIBLE, INFEASIBLE, Case
from vibopt.study.chart.mounts.machine import LINE, SPACE, Machine
from vibopt.study.chart.mounts.shelf import Shelf, drawn
from vibopt.study.chart.mounts.truth import every_choice, floor_force, least_price, loads, natural, peaks

MOUNTS = "mounts"
"""Family of the cases of the chart of speed, whose error is a price."""
UNANSWERABLE = "no answer"
"""Truth of a case whose question has no answer: right is a sentence that names why."""


@dataclass(frozen=True)
class Asked:
    """A question with its true answer.

    named
        Words that a refusal must have; "" where the question has an answer.
    """

    case: Case
    machine: Machine
    shelf: Shelf
    named: str = ""


def asked(machine: Machine, shelf: Shelf, family: str = MOUNTS) -> Asked:
    """With the truth found by measuring every choice."""
    price, _ = least_price(machine, shelf)
    truth, goal = (FEASIBLE, price) if np.isfinite(price) else (INFEASIBLE, np.nan)
    known = f"all {len(shelf) ** len(machine.groups)} choices measured by plain numpy"
    return Asked(Case(machine.title, "", truth, goal, known, family), machine, shelf)


def stock(*, quick: bool) -> list[Asked]:
    """Random machines on random shelves: on a line and in space, of rubber and of steel, two groups and three."""
    sizes = [
        (LINE, 60, 2, 1, False), (LINE, 60, 2, 6, True), (SPACE, 60, 2, 3, False), (SPACE, 60, 2, 7, True),
        (SPACE, 24, 3, 4, False), (SPACE, 200, 2, 5, False),
    ]  # fmt: skip
    return [asked(*machine_on(*size)) for size in (sizes[:3] if quick else sizes)]


def machine_on(motion: str, parts: int, groups: int, seed: int, steel: bool) -> tuple[Machine, Shelf]:
    """A random machine and shelf; the limits lie within what the choices do that carry the load."""
    rng = np.random.default_rng(seed)
    mass, wide = float(f"{rng.uniform(600.0, 3000.0):.3g}"), rng.uniform(0.35, 0.6)
    share = mass * 9.81 / (2 * groups)
    shelf = drawn(seed, parts, 0.4 * share, 5.0 * share, steel=steel)
    centre = (round(float(rng.uniform(-0.15, 0.15)), 2), 0.0, round(float(rng.uniform(0.2, 0.5)), 2))
    lengths = np.array([2.2, 2.0 * wide, 0.9])
    inertia = tuple(float(f"{mass / 12.0 * (lengths @ lengths - one * one):.3g}") for one in lengths)
    rows = np.linspace(0.95, -0.95, groups)
    places = tuple(tuple((round(float(x), 3), side * round(float(wide), 2), 0.0) for side in (1, -1)) for x in rows)
    title = f"{motion}, {parts} {'steel springs' if steel else 'rubber mounts'}, {groups} groups"
    bare = Machine(title, mass, centre, inertia, places, 2000.0, (0.3, 0.0, 0.5), motion=motion)  # type: ignore[arg-type]
    return limited(replace(bare, way="z" if motion == LINE or steel else "x"), shelf, rng), shelf


def limited(machine: Machine, shelf: Shelf, rng: np.random.Generator) -> Machine:
    """With limits on the floor's force, the sway and the highest natural frequency."""
    chosen = every_choice(machine, shelf)
    chosen = chosen[rng.permutation(len(chosen))[:4000]]
    mass, dynamic, static = machine.matrices(shelf, chosen)
    sound = loads(machine, shelf, chosen, static) <= 0.0
    dynamic = dynamic[sound][:200]
    if not len(dynamic):
        raise ValueError(f"{machine.title}: no choice carries the machine")
    return replace(
        machine,
        floor=float(f"{np.quantile(floor_force(machine, mass, dynamic), 0.3):.3g}"),
        sway=float(f"{np.quantile(peaks(machine, mass, dynamic), 0.3):.3g}"),
        highest=float(f"{np.quantile(natural(mass, dynamic)[:, -1], 0.6) / (2.0 * np.pi):.3g}"),
    )
