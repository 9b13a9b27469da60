"""The smallest worst residual by linear programs with cutting planes: a reference by another road than the method's."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.optimize import linprog

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.balancing.question import Question

_CLOSE, _ROUNDS = 1e-9, 100
_EXACT: Any = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}


def least_worst(question: Question) -> tuple[float, float]:
    """A number no correction comes below, and how far above it, as a part, a correction is known.

    Parameters
    ----------
    question
        Goal "worst" of readings of about size 1, a finite cap for every plane, nothing else.

    Notes
    -----
    |z| is the greatest Re(z exp(-i angle)); each round adds the angles at which the last corrections exceed the
    last bound.  No cone, no slope, no dual: it shares nothing with the program that is charted.
    """
    n, p = question.n_readings, question.n_planes
    whole = np.vstack([question.H, np.eye(p)])
    constant = np.concatenate([question.y0, np.zeros(p)])
    room = np.concatenate([np.zeros(n), question.caps])
    share = np.concatenate([np.ones(n), np.zeros(p)])
    rows = np.repeat(np.arange(n + p), 4)
    angles = np.tile(np.arange(4) * 0.5 * np.pi, n + p)
    bound, value = 0.0, np.inf
    for _ in range(_ROUNDS):
        matrix, right = _cuts(whole[rows], constant[rows], room[rows], share[rows], angles)
        cost = np.zeros(2 * p + 1)
        cost[-1] = 1.0
        solved: Any = linprog(cost, matrix, right, bounds=(None, None), method="highs", options=_EXACT)
        if solved.x is None:
            break
        u = solved.x[:p] + 1j * solved.x[p:-1]
        bound = max(bound, float(solved.fun))
        inside = u * np.minimum(1.0, question.caps / np.maximum(np.abs(u), 1e-300))
        value = min(value, question.value(inside))
        if value <= bound * (1.0 + _CLOSE):
            break
        left = constant + whole @ u
        over = np.flatnonzero(np.abs(left) > (room + share * solved.x[-1]) * (1.0 + 1e-12))
        rows, angles = np.concatenate([rows, over]), np.concatenate([angles, np.angle(left[over])])
    return bound, value / bound - 1.0


def _cuts(
    whole: ComplexArray, constant: ComplexArray, room: FloatArray, share: FloatArray, angles: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Rows of Re((constant + whole u) exp(-i angle)) <= room + share t, for x = (Re u, Im u, t)."""
    turn = np.exp(-1j * angles)
    turned = whole * turn[:, None]
    return np.column_stack([turned.real, -turned.imag, -share]), room - (constant * turn).real
