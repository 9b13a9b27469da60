"""Weighted least squares in closed form: the oldest way to balance in many planes (Goodman, 1964)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vibopt.balancing.question import Question, Solved, breaks
from vibopt.forms import ComplexArray

RANK = 1e-13
NOTHING = 1e-13  # residual that counts as nothing, as a share of the goal as found


def least_squares(weighted: ComplexArray, constant: ComplexArray) -> tuple[ComplexArray, int]:
    """The x of least norm |weighted x + constant|, and the rank.

    Parameters
    ----------
    weighted
        Shape (n_readings, n_planes); columns are divided by their norms before the singular values are compared.
    constant
        Shape (n_readings,).

    Returns
    -------
    tuple
        x (n_planes,) and the rank; below full rank x is the solution of least Euclidean norm.
    """
    norms = np.sqrt(
        np.einsum("kp,kp->p", weighted.real, weighted.real) + np.einsum("kp,kp->p", weighted.imag, weighted.imag)
    )
    norms[norms == 0] = 1.0
    level = weighted / norms
    if len(constant) > 4 * weighted.shape[1]:  # the same problem in n_planes + 1 rows
        triangle: ComplexArray = np.asarray(np.linalg.qr(np.column_stack([level, constant]), mode="r"))
        level, constant = triangle[:, :-1], triangle[:, -1]
    solution, _, rank, _ = np.linalg.lstsq(level, -constant, rcond=RANK)
    x: ComplexArray = solution / norms
    if rank < weighted.shape[1]:
        _, _, right = np.linalg.svd(level, full_matrices=True)
        idle = right[rank:].conj().T / norms[:, None]
        x = x - idle @ np.linalg.lstsq(idle, x, rcond=None)[0]
    return x, int(rank)


def closed_form(question: Question) -> Solved | None:
    """The answer where no program is needed; None otherwise.

    That is so where the least-squares solution keeps every limit and is asked for (or leaves nothing, which no goal
    can better), and where least mass is asked for and nothing has to be fitted.
    """
    if question.goal == "correction":
        return _nothing_needed(question)
    if question.pairs or not np.all(question.caps > 0):
        return None
    if question.goal != "rms" and question.n_readings > question.n_planes and np.isfinite(question.caps).any():
        return None  # more readings than planes and caps: something will be left
    u, rank = least_squares(question.importance[:, None] * question.H, question.importance * question.y0)
    bare = not question.sectors and not np.isfinite(question.total_cap) and np.all(np.isinf(question.limits))
    if not np.all(np.abs(u) <= question.caps) or not (bare or not breaks(replace(question, options=()), u, 0.0)):
        return None
    value = question.value(u)
    if question.goal != "rms" and value > NOTHING * float(question.measure(np.abs(question.y0))):
        return None
    n = question.n_planes
    claim = "least squares in closed form"
    if rank < n:
        claim += f"; the readings tell only {rank} of {n} planes apart, so of all such corrections this is the smallest"
    return Solved(u, "optimal", claim, value, value, 0.0, details={"rank": rank})


def _nothing_needed(question: Question) -> Solved | None:
    """No correction, where the readings keep their limits as found."""
    none = np.zeros(question.n_planes, dtype=complex)
    if breaks(replace(question, options=()), none, 0.0):
        return None
    return Solved(none, "optimal", "the limits are kept as found: nothing has to be fitted", 0.0, 0.0, 0.0)
