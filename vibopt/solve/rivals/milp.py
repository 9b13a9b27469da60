"""Weights from lists by HiGHS: a mixed-integer linear program, every amplitude between the sides of a polygon."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray

GAP = 1e-6
"""Gap that HiGHS is asked to prove."""


def chosen_weights(
    y0: ComplexArray,
    H: ComplexArray,
    limits: FloatArray,
    options: Sequence[ComplexArray],
    masses: Sequence[FloatArray],
    *,
    by_mass: bool,
    sides: int,
    nodes: int,
) -> tuple[str, ComplexArray | None]:
    """HiGHS's own word, and the correction (n_planes,).

    Parameters
    ----------
    y0, H, limits
        Readings (n_readings,), response per unbalance (n_readings, n_planes), greatest amplitude left (n_readings,).
    options, masses
        What may be fitted in each plane and what it weighs, each (n_options,).
    by_mass
        Whether the least mass is looked for, else the smallest worst residual.
    sides
        Of the polygon: an amplitude is at most 1 / cos(pi / sides) of what its sides say.
    nodes
        Most of its search.
    """
    from scipy.optimize import Bounds, milp

    effects = np.concatenate([np.outer(column, option) for column, option in zip(H.T, options, strict=True)], axis=1)
    count = effects.shape[1]
    goal = np.zeros(count + 1)
    goal[:count], goal[count] = (np.concatenate(masses), 0.0) if by_mass else (0.0, 1.0)
    bounds = Bounds(0.0, np.append(np.ones(count), np.inf))
    rules = _rules(y0, effects, limits, [len(option) for option in options], sides)
    how: Any = {"mip_rel_gap": GAP, "node_limit": nodes}
    with quiet():
        whole = np.append(np.ones(count), 0.0)
        found: Any = milp(goal, integrality=whole, bounds=bounds, constraints=rules, options=how)
    if found.x is None:
        return str(found.message), None
    ends = np.cumsum([len(option) for option in options])[:-1]
    picks = [int(part.argmax()) for part in np.split(found.x[:count], ends)]
    word = "optimal" if found.status == 0 else str(found.message)
    return word, np.array([option[pick] for option, pick in zip(options, picks, strict=True)])


def _rules(y0: ComplexArray, effects: ComplexArray, limits: FloatArray, counts: Sequence[int], sides: int) -> Any:
    """One option in each plane, and every side of every polygon within the goal, the last column, and its limit."""
    from scipy.optimize import LinearConstraint
    from scipy.sparse import block_diag, csr_array, hstack, vstack

    turn = np.exp(-2j * np.pi * np.arange(sides) / sides)
    rows = (turn[:, None, None] * effects).real.reshape(-1, effects.shape[1])
    right, size = -(turn[:, None] * y0).real.ravel(), np.abs(y0).max()
    kept = np.tile(limits * np.cos(np.pi / sides), sides)  # within the limit, whatever the angle
    held = np.isfinite(kept)
    one_each: Any = block_diag([np.ones((1, count)) for count in counts])
    tables = [
        hstack([one_each, csr_array((len(counts), 1))]),
        hstack([csr_array(rows / size), csr_array(-np.ones((len(rows), 1)))]),
        hstack([csr_array(rows[held] / size), csr_array((int(held.sum()), 1))]),
    ]
    high = np.concatenate([np.ones(len(counts)), right / size, (right + kept)[held] / size])
    low = np.where(np.arange(len(high)) < len(counts), 1.0, -np.inf)
    return LinearConstraint(vstack(tables), low, high)


@contextmanager
def quiet() -> Iterator[None]:
    """HiGHS writes lines of its own to standard output, whatever it is told; there they would stand in our JSON."""
    sys.stdout.flush()
    kept, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    try:
        yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nowhere)
