"""Random questions of the charts: a seed and a number give the same ones on every machine.

Mounts are limited a little above what a drawn mount leaves, worked out here in plain numpy, so that an answer exists;
the questions of rotors are built round their answer, lists and shelves are small enough to try every choice, and
what happens in time has a truth of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.charts import (
    friction_cases,
    mount_cases,
    mount_fidelity,
    run_up_cases,
    shaft_cases,
    shock_cases,
    study_cases,
)
from vibopt.charts.absorber_cases import taking
from vibopt.charts.balancing_cases import SLOWER, table_of
from vibopt.charts.balancing_questions import Asked, asked, least_squares, shelf, worst
from vibopt.charts.balancing_rivals import METHODS as BALANCING
from vibopt.charts.machines import absorbed, shaken, stacked
from vibopt.charts.mount_cases import machine_on
from vibopt.charts.mount_machine import LINE, SPACE
from vibopt.charts.trial import DEFAULT, NOWHERE, Case, Said, Table, Trial, judged, judged_number, scene_table
from vibopt.charts.verdicts import FEASIBLE
from vibopt.program.pose import pose
from vibopt.scene.scene import Scene
from vibopt.solve.branch import Judge

BUILT, BEST = "built round its answer", "the best of all methods"
_SPEEDS, _TRIES = 4000, 20


def isolator(rng: np.random.Generator, name: str) -> Case:
    """A machine on none to two blocks, the lowest mount to be chosen as stiff as the floor and the start-up permit."""
    count = int(rng.integers(1, 4))
    masses = (10.0 ** rng.uniform(1.0, 3.5) * rng.uniform(0.3, 1.0, count)).tolist()
    top = float(rng.uniform(60.0, 600.0))
    force = float(10.0 ** rng.uniform(1.0, 4.0))
    growing = bool(rng.integers(2))
    pads = [float(mass * top**2 * rng.uniform(2.0, 20.0)) for mass in masses[:-1]]
    dash = [float(0.05 * np.sqrt(pad * mass)) for pad, mass in zip(pads, masses, strict=False)]
    stiffness = float(sum(masses) * (top / rng.uniform(1.7, 5.0)) ** 2)
    damping = float(2.0 * rng.uniform(0.03, 0.4) * np.sqrt(stiffness * sum(masses)))
    speeds = np.linspace(0.0, top, _SPEEDS)
    load = force * (speeds / top) ** 2 if growing else np.full(_SPEEDS, force)
    moved = _moved(masses, [*pads, stiffness], [*dash, damping], speeds, load)
    through = abs(moved[-1, -1] * (stiffness + 1j * top * damping))
    floor, start_up = through * rng.uniform(1.02, 1.5), np.abs(moved[:, 0]).max() * rng.uniform(1.02, 2.0)
    return Case(name, _mounted(masses, pads, dash, force, top, growing, float(floor), float(start_up)), FEASIBLE,
                np.nan, BEST, "isolation")  # fmt: skip


def _moved(
    masses: list[float], springs: list[float], dashes: list[float], speeds: FloatArray, load: FloatArray
) -> FloatArray:
    """Complex amplitudes of a stack, the highest body first, shape (n_speeds, n_bodies)."""
    n = len(masses)
    matrices = [np.diag(masses), np.zeros((n, n)), np.zeros((n, n))]
    for values, matrix in ((springs, matrices[1]), (dashes, matrices[2])):
        for i, value in enumerate(values):
            arm = np.eye(n)[i] - (np.eye(n)[i + 1] if i + 1 < n else 0.0)
            matrix += value * np.outer(arm, arm)
    s = 1j * speeds[:, None, None]
    pull = load[:, None, None] * np.eye(n)[:, :1]
    moved: FloatArray = np.linalg.solve(s**2 * matrices[0] + s * matrices[2] + matrices[1], pull)[..., 0]
    return moved


def _mounted(
    masses: list[float], pads: list[float], dash: list[float], force: float, top: float, growing: bool, floor: float,
    start_up: float,
) -> str:  # fmt: skip
    scale = sum(masses) * top**2
    low, high = (f'"{value * scale!r} N/m"' for value in (1e-4, 10.0))
    least, most = (f'"{value * scale / top!r} N s/m"' for value in (1e-4, 10.0))
    return stacked(
        [f'"{mass!r} kg"' for mass in masses],
        [
            *((f'"{pad!r} N/m"', f'"{own!r} N s/m"') for pad, own in zip(pads, dash, strict=True)),
            (f"{{ from = {low}, to = {high} }}", f"{{ from = {least}, to = {most} }}"),
        ],
        shaken("machine", f"{force!r} N", f"{top!r} rad/s", f"{floor!r} N", f"{start_up!r} m",
               varies="speed^2" if growing else "constant"),
    )  # fmt: skip


def absorber(rng: np.random.Generator, name: str) -> Case:
    """One absorber, or two in every third case, on one to three masses: least amplitude of the highest."""
    return _absorbed(rng, name, "absorbers", lambda: 1 + int(rng.integers(3) == 0))


def several(rng: np.random.Generator, name: str) -> Case:
    """Two to four absorbers on one to three masses: least amplitude of the highest."""
    return _absorbed(rng, name, "several", lambda: int(rng.integers(2, 5)))


def _absorbed(rng: np.random.Generator, name: str, family: str, many: Callable[[], int]) -> Case:
    count, number = int(rng.integers(1, 4)), many()
    spring = float(10.0 ** rng.uniform(4.0, 6.0))
    own = float(np.sqrt(spring / 100.0))
    text = absorbed(
        [int(rng.integers(count)) for _ in range(number)],
        [float(10.0 ** rng.uniform(-2.0, -0.7)) for _ in range(number)],
        count=count, spring=spring, damping=float(rng.choice([0.0, 0.01, 0.04])), speeds=(0.1 * own, 3.0 * own),
    )  # fmt: skip
    return Case(name, text, FEASIBLE, np.nan, BEST, family)


def weights(rng: np.random.Generator, name: str) -> Asked:
    """Weights of a shelf in the holes of three planes: the smallest worst residual, or the least mass under a limit."""
    by_residual, by_mass = shelf(int(rng.integers(2**31)), float(rng.uniform(1.05, 1.5)))
    asked = by_residual if rng.integers(2) else by_mass
    return replace(asked, case=replace(asked.case, name=name, family="weights"))


def mounts(rng: np.random.Generator, name: str) -> Any:
    """A machine on two groups of mounts of a shelf of 10 to 60 parts, on a line or in space, of rubber or steel."""
    motion, parts = (LINE, SPACE)[int(rng.integers(2))], int(rng.integers(10, 61))
    for _ in range(_TRIES):
        try:
            asked = mount_cases.asked(*machine_on(motion, parts, 2, int(rng.integers(2**31)), bool(rng.integers(2))))
        except ValueError:  # no choice carries the machine
            continue
        return replace(asked, case=replace(asked.case, name=name))
    raise ValueError(f"{name}: no shelf carries its machine")


def load(rng: np.random.Generator, name: str) -> tuple[Case, shock_cases.Load]:
    """One to five masses under a pulse of a tenth of a period to thirty, or a short record."""
    points = {
        "half sine": np.zeros(0), "rectangle": np.ones(2), "triangle": np.array([0.0, 1.0, 0.0]),
        "record": rng.normal(size=30),
    }  # fmt: skip
    shape = str(rng.choice(list(points)))
    times = np.linspace(0.0, 0.1, max(len(points[shape]), 2))
    one = shock_cases.Load(
        int(rng.integers(1, 6)), float(10.0 ** rng.uniform(0.0, 2.5)), float(10.0 ** rng.uniform(-2.5, -0.5)),
        np.round(times, 12), points[shape],
    )  # fmt: skip
    return Case(name, "", FEASIBLE, shock_cases.truth(one), "modes in closed form", "shock"), one


def passage(rng: np.random.Generator, name: str) -> tuple[Case, run_up_cases.Passage]:
    """One to three masses up or down through their resonances."""
    low, high = float(rng.uniform(0.05, 0.5)), float(rng.uniform(1.5, 3.0))
    up = bool(rng.integers(2))
    one = run_up_cases.Passage(
        int(rng.integers(1, 4)), float(10.0 ** rng.uniform(-2.0, -0.7)), low if up else high, high if up else low,
        float(10.0 ** rng.uniform(-2.0, 1.0)),
    )  # fmt: skip
    return Case(name, "", FEASIBLE, run_up_cases.truth(one)[0], "the turning frame, followed tightly", "run_up"), one


def slip(rng: np.random.Generator, name: str) -> tuple[Case, friction_cases.Slip]:
    """One mass that slips, from a third of the resonance to twice it."""
    one = friction_cases.Slip(
        float(10.0 ** rng.uniform(-0.5, 0.3)), float(10.0 ** rng.uniform(-2.5, -1.0)), float(rng.uniform(0.1, 0.95))
    )
    return Case(name, "", FEASIBLE, friction_cases.truth(one), "slip for slip in closed form", "friction"), one


def rotor(rng: np.random.Generator, name: str) -> Asked:
    """Least squares, or the smallest worst residual under caps, of 4 to 200 readings and one to ten planes."""
    planes = int(rng.integers(1, 11))
    readings = int(planes * rng.uniform(2.0, 20.0)) + 1
    seed = int(rng.integers(2**31))
    if rng.integers(2):
        question, goal = least_squares(readings, planes, seed)
        return asked(name, question, goal, BUILT, "balancing")
    return asked(name, worst(readings, planes, capped=bool(rng.integers(2)), seed=seed), 1.0, BUILT, "balancing")


DRAWN: Mapping[str, Callable[[np.random.Generator, str], Any]] = {
    "isolation": isolator, "absorbers": absorber, "several": several, "balancing": rotor, "weights": weights,
    "mounts": mounts, "shock": load, "run_up": passage, "friction": slip, "shafts": shaft_cases.drawn,
    "studies": study_cases.drawn,
}  # fmt: skip
"""How a question of each family is drawn."""

RIVALS = (
    "slsqp 50", "slsqp 200", "slsqp 1000", "slsqp exchange 1e-11", "slsqp peaks 8 starts 1e-09", "trust 50",
    "ipopt 200", "nlp", "grid 40", "cma-es 1000",
)  # fmt: skip
QUICK_RIVALS = ("slsqp 50", "slsqp 200", "slsqp exchange 1e-11", "slsqp peaks 8 starts 1e-09", "ipopt 200")
_METHODS: Mapping[str, Callable[[tuple[str, ...]], tuple[str, ...]]] = {
    "isolation": lambda names: (*names, "cvxpy 1e-08"),
    "absorbers": taking, "several": taking,
}  # fmt: skip


def table(family: str, questions: Sequence[Any], *, quick: bool) -> Table:
    """Questions with every method."""
    if family in _METHODS:
        names = _METHODS[family](QUICK_RIVALS if quick else RIVALS)
        asked = scene_table([(case, case.scene()) for case in questions], (DEFAULT, *names), 1, questions[:1])
        return replace(asked, judge=judged_measured)
    if family in ("balancing", "weights"):
        dear = ("milp", "hsbalance") if quick and family == "weights" else ()
        less = [name for name in BALANCING if name in SLOWER or name.startswith(dear or "none")]
        return replace(table_of(questions, 1, less), drops=True)
    if family == "mounts":
        return mount_fidelity.table_of(questions, mount_fidelity.methods(quick=quick), 1)
    kin = _KIN[family]
    return Table(
        questions, kin.QUICK_METHODS if quick else kin.METHODS, getattr(kin, "judge", judged_number), 1, questions[:1]
    )


_KIN: Mapping[str, Any] = {
    "shock": shock_cases, "run_up": run_up_cases, "friction": friction_cases, "shafts": shaft_cases,
    "studies": study_cases,
}  # fmt: skip


def judged_measured(case: Case, scene: Scene, method: str, said: Said) -> Trial:
    """A design measured at its exact peaks, its goal against nothing yet."""
    if said.answer is None:
        return judged(case, method, said, *NOWHERE)
    judge = Judge(pose(scene))
    missed = max((judge.limit(limit, said.answer)[0] for limit in judge.program.limits), default=0.0)
    return judged(case, method, said, missed, 0.0, judge.goal(said.answer).value)


def drawn(family: str, seed: int, count: int) -> list[Any]:
    """So many questions; each depends on the seed and its own number alone."""
    draw = DRAWN[family]
    return [draw(np.random.default_rng([seed, i]), f"{family} {seed}.{i}") for i in range(count)]
