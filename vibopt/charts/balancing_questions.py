"""Balancing questions built round their answers, or small enough to try every choice; hard ground.

Readings and coefficients are drawn, then the coefficients are turned just so far that a chosen correction fulfils
the conditions of the optimum.  The programs are convex, so it is the best there is, and no solver had a say in it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.balancing.conventions import WITH, Conventions
from vibopt.balancing.plane_options import options_of
from vibopt.balancing.planes import Plane
from vibopt.balancing.question import Goal, Question
from vibopt.balancing.rotor_job import RotorJob
from vibopt.charts.cutting_planes import least_worst
from vibopt.charts.rotor_file import HOLES, WEIGHTS, document, job_of
from vibopt.charts.trial import Case
from vibopt.charts.verdicts import FEASIBLE, INFEASIBLE
from vibopt.document.toml_writing import document_toml
from vibopt.records import cached_property, dataclass

BUILT = "built round its answer"
SIZES, QUICK_SIZES = ((8, 2), (1000, 20), (5000, 8)), ((8, 2), (1000, 20))
LEFT = 1e-3
"""Residual of the questions of least squares, as a share of the readings."""


@dataclass(frozen=True)
class Asked:
    """A question with its true answer."""

    case: Case
    question: Question

    @cached_property
    def job(self) -> RotorJob:
        """The same as the problem file of a measured rotor, read."""
        return job_of(self.question, self.case.name or "question")

    @property
    def text(self) -> str:
        """The problem file."""
        return document_toml(document(self.question))


def asked(name: str, question: Question, goal: float, known_by: str, family: str = "", truth: str = FEASIBLE) -> Asked:
    """A question under a name; `goal` [unit of the question's goal], nan where there is none to miss."""
    return Asked(Case(name, "", truth, goal, known_by, family), question)


def plain(y0: ComplexArray, H: ComplexArray, goal: Goal, cap: float = np.inf) -> Question:
    """Equal importance, no limits, one cap for all planes."""
    n, p = H.shape
    return Question(y0, H, np.ones(n), np.full(n, np.inf), np.full(p, cap), goal=goal)


def normal(rng: np.random.Generator, *shape: int) -> ComplexArray:
    """Complex numbers with normal parts."""
    numbers: ComplexArray = rng.normal(size=shape) + 1j * rng.normal(size=shape)
    return numbers


def turns(rng: np.random.Generator, count: int) -> ComplexArray:
    """Complex numbers of size 1."""
    numbers: ComplexArray = np.exp(2j * np.pi * rng.uniform(size=count))
    return numbers


def orthonormal(rng: np.random.Generator, n: int, p: int) -> ComplexArray:
    """Shape (n, p), columns of size 1 at right angles."""
    columns: ComplexArray = np.linalg.qr(normal(rng, n, p))[0]
    return columns


def held(H: ComplexArray, slope: ComplexArray, pull: ComplexArray) -> ComplexArray:
    """The nearest coefficients with H^H slope = pull.

    Parameters
    ----------
    H
        Shape (n_readings, n_planes).
    slope
        Slope of the goal in each reading left, shape (n_readings,).
    pull
        Zero for a plane below its cap, else against the correction there, shape (n_planes,).
    """
    amiss = pull - H.conj().T @ slope
    turned: ComplexArray = H + np.outer(slope, amiss.conj()) / np.vdot(slope, slope).real
    return turned


def least_squares(n: int, p: int, seed: int = 1) -> tuple[Question, float]:
    """Least squares without limits, and its root mean square."""
    rng = np.random.default_rng(seed)
    left = normal(rng, n)
    H = held(normal(rng, n, p), left, np.zeros(p, dtype=complex))
    return plain(left - H @ turns(rng, p), H, "rms"), float(np.linalg.norm(left) / np.sqrt(n))


def worst(n: int, p: int, *, capped: bool = True, seed: int = 1) -> Question:
    """Smallest worst residual, which is 1, with every second plane at its cap, which is 1 as well."""
    rng = np.random.default_rng(seed)
    u = turns(rng, p)
    full = (np.arange(p) % 2 == 0) & capped
    left, slope = touching(rng, n, min(n, 2 * p + 1 - int(full.sum())))
    u[~full] *= 0.7
    H = held(normal(rng, n, p), slope, np.where(full, -0.2 * u, 0.0))
    return plain(left - H @ u, H, "worst", 1.0 if capped else np.inf)


def touching(rng: np.random.Generator, n: int, count: int) -> tuple[ComplexArray, ComplexArray]:
    """Readings left, `count` of them of size 1 and the others smaller, and the slope of the worst in each."""
    left = turns(rng, n) * rng.uniform(0.0, 0.95, n)
    rows = rng.permutation(n)[:count]
    left[rows] /= np.abs(left[rows])
    share = np.zeros(n)
    share[rows] = rng.uniform(0.5, 1.5, count)
    return left, left * share / share.sum()


def spoilt(count: int) -> tuple[Question, float]:
    """Huber's goal, and what it is: `count` of eight readings are off by a hundred times the threshold."""
    rng = np.random.default_rng(7)
    left = turns(rng, 8) * rng.uniform(0.2, 0.8, 8)
    left[:count] *= 100.0 / np.abs(left[:count])
    slope = left / np.maximum(np.abs(left), 1.0)
    H = held(normal(rng, 8, 2), slope, np.zeros(2, dtype=complex))
    question = replace(plain(left - H @ turns(rng, 2), H, "huber"), huber=1.0)
    return question, huber(np.abs(left))


def huber(sizes: FloatArray) -> float:
    """Sum of squares up to 1, and of 2 t - 1 beyond."""
    return float(np.where(sizes <= 1.0, sizes**2, 2.0 * sizes - 1.0).sum())


def critical(cap: float, seed: int = 3) -> Question:
    """Two of six sensors are to be quiet, the others keep 2 and do as found; the worst of the two is 1."""
    rng = np.random.default_rng(seed)
    u = 0.7 * turns(rng, 2)
    left = turns(rng, 6) * np.array([1.0, 1.0, 2.0, 1.5, 1.2, 1.0])
    slope = left * np.array([0.5, 0.5, 0.2, 0.0, 0.0, 0.0])
    H = held(normal(rng, 6, 2), slope, np.zeros(2, dtype=complex))
    question = plain(left - H @ u, H, "worst", cap)
    quiet = np.arange(6) < 2
    return replace(question, importance=quiet.astype(float), limits=np.where(quiet, np.inf, 2.0))


def stock(*, quick: bool) -> list[Asked]:
    """Least squares and smallest worst residual at several sizes, then weights that exist."""
    found = []
    for n, p in QUICK_SIZES if quick else SIZES:
        found.append(asked(f"least squares, {n}x{p}", *least_squares(n, p), BUILT))
        found.append(asked(f"worst with caps, {n}x{p}", worst(n, p), 1.0, BUILT))
    return [*found, *shelf()]


def shelf(seed: int = 1, room: float = 1.1) -> list[Asked]:
    """24 holes, five shelf weights and three planes: the smallest worst residual, and the least mass under limits.

    room
        The limit over the smallest worst residual.
    """
    rng = np.random.default_rng(seed)
    holes = tuple((np.arange(HOLES) * 2 * np.pi / HOLES).tolist())
    options = options_of(Plane("", radii=(1.0,), holes=holes, shelf=WEIGHTS), Conventions("", "", WITH, "pk", ""))
    question = replace(plain(normal(rng, 8), normal(rng, 8, 3), "worst"), options=(options,) * 3)
    left, masses = every_choice(question, options.masses)
    best = float(left.min())
    limit = room * best
    lighter = replace(question, goal="correction", limits=np.full(8, limit))
    least = float(masses[left <= limit].min())
    words, size = f"all {left.size} choices tried", f"{HOLES} holes, {len(WEIGHTS)} weights, 3 planes"
    return [asked(f"worst, {size}", question, best, words), asked(f"least mass, {size}", lighter, least, words)]


def every_choice(question: Question, masses: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Worst residual and mass of every choice in three planes with the same list, (n_options,) * 3."""
    effects = [
        np.outer(option.u, column)
        for option, column in zip(question.options, question.H.T, strict=True)
        if option is not None
    ]
    pair = effects[1][:, None, :] + effects[2][None, :, :]
    left = np.stack([np.abs(question.y0 + first + pair).max(axis=-1) for first in effects[0]])
    return left, masses[:, None, None] + masses[:, None] + masses


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
