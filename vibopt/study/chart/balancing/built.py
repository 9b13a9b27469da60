"""Balancing questions built round their answers.

Readings and coefficients are drawn, then the coefficients are turned just so far that a chosen correction fulfils
the conditions of the optimum.  The programs are convex, so it is the best there is, and no solver had a say in it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from vibopt.balancing.job import RotorJob
from vibopt.balancing.question import Goal, Question
from vibopt.forms import ComplexArray, FloatArray
from vibopt.study.chart.cases import FEASIBLE, Case

BUILT = "built round its answer"


@dataclass(frozen=True)
class Asked:
    """A question with its true answer."""

    case: Case
    question: Question

    @cached_property
    def job(self) -> RotorJob:
        """The same as the problem file of a measured rotor, read."""
        from vibopt.study.chart.balancing.rotor_file import job_of

        return job_of(self.question, self.case.name or "question")


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


def spoilt(count: int, seed: int = 7) -> tuple[Question, float]:
    """Huber's goal, and what it is: `count` of eight readings are off by a hundred times the threshold."""
    rng = np.random.default_rng(seed)
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
