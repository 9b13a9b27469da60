"""Balancing in cvxpy, the program built and solved anew: a rival for the charts."""

from __future__ import annotations

import warnings

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray


def balanced(
    y0: ComplexArray,
    H: ComplexArray,
    importance: FloatArray,
    limits: FloatArray,
    caps: FloatArray,
    *,
    goal: str,
    threshold: float,
    tolerance: float = 1e-8,
) -> tuple[str, ComplexArray | None]:
    """cvxpy's own word for how it ended, and the correction.

    Parameters
    ----------
    y0, H, importance
        Readings (n_readings,), response per unbalance (n_readings, n_planes), factor in the goal (n_readings,).
    limits, caps
        Greatest amplitude left (n_readings,) and greatest correction (n_planes,); inf where there is none.
    goal
        "rms", "worst" or "huber" with its threshold.
    tolerance
        Of Clarabel.
    """
    import cvxpy as cp

    u = cp.Variable(H.shape[1], complex=True)
    left = y0 + H @ u
    sizes = cp.multiply(importance, cp.abs(left))
    measure = {
        "rms": lambda: cp.norm(cp.multiply(importance, left)) / np.sqrt(H.shape[0]),
        "worst": lambda: cp.max(sizes),
        "huber": lambda: cp.sum(cp.huber(sizes, threshold)),
    }[goal]()
    limited, capped = np.flatnonzero(np.isfinite(limits)), np.flatnonzero(np.isfinite(caps))
    kept = [cp.abs(left[limited]) <= limits[limited]] if len(limited) else []
    kept += [cp.abs(u[capped]) <= caps[capped]] if len(capped) else []
    problem = cp.Problem(cp.Minimize(measure), kept)
    with warnings.catch_warnings():  # what it warns of is in its status
        warnings.simplefilter("ignore")
        problem.solve(solver="CLARABEL", **clarabel(tolerance))
    return str(problem.status), u.value


def clarabel(tolerance: float) -> dict[str, float]:
    """Its options for a tolerance of the gap and of every row."""
    return dict.fromkeys(("tol_gap_abs", "tol_gap_rel", "tol_feas"), tolerance)
