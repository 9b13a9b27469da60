"""Least squares and least worst residual over discs by Newton's method on the bounds that hold the answer back.

Rows are discs |m x + k| <= d: caps of planes (m a unit vector, k = 0), limits on readings, and for the goal "worst" its
rows with d = t, which is to be least.  Where it is known which rows hold with equality, smooth equations in x, their
multipliers and t are left; it is the right ones that hold when no multiplier is negative and no other row is exceeded
(a primal-dual active set method; Hintermüller, Ito and Kunisch, 2003).  All arrays have an axis of points in front, so
that many values of a bound are answered together; an answer alone is a batch of one.
"""

from __future__ import annotations

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray, IntArray
from vibopt.records import dataclass

Rows = IntArray
STEPS = 12  # of Newton's method on given rows; it takes three to six
EXCHANGES = 30
SETTLED = 1e-9  # a step of this part of x is the last one: what is left after it is its square
BEYOND = 1e-11  # a row is exceeded, or its multiplier negative, from this part on
RIDGE = 1e-13
FAR = 1e3  # a plane without a cap is bounded this many times beyond the answer; convexity carries the rest


class Discs:
    """A goal and rows of order one, in the order goal (only for `worst`), limits, caps.

    Parameters
    ----------
    G, g
        Goal rows, shape (n_goal, n_planes) and (n_goal,); the norm of G x + g is least, or with `worst` its greatest.
    M, k
        Limits on readings |M x + k|, shape (n_limits, n_planes) and (n_limits,).
    """

    def __init__(self, G: ComplexArray, g: ComplexArray, M: ComplexArray, k: ComplexArray, worst: bool) -> None:
        self.G, self.g, self.M, self.k, self.worst = G, g, M, k, worst
        self.n_planes, self.n_goal, self.n_limits = G.shape[1], len(g) if worst else 0, len(k)
        none = np.zeros(self.n_planes, dtype=complex)
        self.rows = np.concatenate([G[: self.n_goal], M, np.eye(self.n_planes)])
        self.constants = np.concatenate([g[: self.n_goal], k, none])
        self.square = np.zeros((self.n_planes, self.n_planes)) if worst else G.conj().T @ G
        self.slope = none if worst else G.conj().T @ g

    def radii(self, limits: FloatArray, caps: FloatArray) -> FloatArray:
        """d of all rows (n_points, n_rows), zero for those of the goal, from limits and caps (n_points, ...)."""
        return np.concatenate([np.zeros((len(caps), self.n_goal)), limits, caps], axis=1)


@dataclass(frozen=True)
class Held:
    """Answers to a batch that the same rows hold back.

    x
        Shape (n_points, n_planes).
    rows
        Those met with equality, rising.
    multipliers
        Of these rows, shape (n_points, n_held): slope of half the square of the goal + sum of multiplier m* (m x + k)
        is zero; those of goal rows add up to one.
    level
        Square of the goal "worst", shape (n_points,).
    """

    x: ComplexArray
    rows: Rows
    multipliers: FloatArray
    level: FloatArray

    def at(self, place: int) -> Held:
        """One point alone."""
        one = slice(place, place + 1)
        return Held(self.x[one], self.rows, self.multipliers[one], self.level[one])


@np.errstate(all="ignore")  # far off a step may overflow, which proves nothing
def newton(discs: Discs, held: Held, radii: FloatArray) -> Held:
    """The rows of `held` met with equality at all points of `radii`, from where `held` is (one point, or as many)."""
    A, c, top = discs.rows[held.rows], discs.constants[held.rows], held.rows < discs.n_goal
    n, count = len(radii), len(held.rows)
    x, lam = np.repeat(held.x, n // len(held.x), axis=0), np.repeat(held.multipliers, n // len(held.x), axis=0)
    level = np.repeat(held.level, n // len(held.x))
    wanted = radii[:, held.rows] ** 2
    border = np.zeros((n, count + 1, count + 1)) if discs.worst else None
    flat = (A.conj()[:, :, None] * A[:, None, :]).reshape(count, discs.n_planes**2)
    for _ in range(STEPS):
        r = x @ A.T + c
        V = A.conj() * r[..., None]
        K = (lam @ flat).reshape(n, discs.n_planes, discs.n_planes) + discs.square
        slope = x @ discs.square.T + discs.slope + (lam[:, None, :] @ V)[:, 0]
        if border is not None:  # where fewer rows hold than there are planes
            K[:, range(discs.n_planes), range(discs.n_planes)] += RIDGE * np.abs(K).max(axis=(1, 2))[:, None]
        Z = np.linalg.solve(K, np.concatenate([V.swapaxes(1, 2), slope[..., None]], axis=2))
        W = (V.conj() @ Z).real
        right = 0.5 * ((r * r.conj()).real - np.where(top, level[:, None], wanted)) - W[..., -1]
        if border is None:
            step = np.linalg.solve(W[..., :-1], right[..., None])[..., 0]
        else:
            border[:, :count, :count], border[:, :count, -1], border[:, -1, :count] = W[..., :-1], 0.5 * top, top
            right = np.column_stack([right, 1.0 - lam @ top])
            step = np.linalg.solve(border, right[..., None])[..., 0]
            level, step = level + step[:, -1], step[:, :-1]
        moved = Z[..., -1] + (Z[..., :-1] @ step[..., None])[..., 0]
        x, lam = x - moved, lam + step
        if float(np.abs(moved).max()) <= SETTLED * float(np.abs(x).max()):
            break
    return Held(x, held.rows, lam, level)


def started(discs: Discs, x: ComplexArray, rows: Rows) -> Held:
    """A point (n_planes,) with the multipliers of `rows` that come nearest to stationarity."""
    A, top = discs.rows[rows], rows < discs.n_goal
    V = A.conj() * (A @ x + discs.constants[rows])[:, None]
    left = np.concatenate([V.real.T, V.imag.T])
    slope = discs.square @ x + discs.slope
    right = -np.concatenate([slope.real, slope.imag])
    if discs.worst:
        weight = float(np.abs(left).max(initial=1e-300))
        left, right = np.vstack([left, weight * top]), np.append(right, weight)
    lam = np.linalg.lstsq(left, right, rcond=None)[0] if len(rows) else np.zeros(0)
    level = float(np.abs(discs.G @ x + discs.g).max() ** 2) if discs.worst else 0.0
    return Held(x[None], rows, lam[None], np.array([level]))


def exchanged(discs: Discs, held: Held, radii: FloatArray) -> Held | None:
    """The answer at one point by dropping rows that pull and taking up those exceeded; None where that does not end."""
    for count in range(EXCHANGES):
        try:
            held = newton(discs, held, radii)
        except np.linalg.LinAlgError:
            return None
        lam, x = held.multipliers[0], held.x[0]
        if not np.isfinite(x).all():
            return None
        beyond = over(discs, held, radii)[0]
        beyond[held.rows] = -np.inf
        pull = lam < -BEYOND * np.abs(lam).max(initial=1.0)
        out = np.flatnonzero(beyond > BEYOND)
        if not pull.any() and not len(out):
            return held
        if count >= EXCHANGES // 2:  # one at a time, where several went in circles
            out = out[[int(np.argmax(beyond[out]))]] if len(out) else out
            pull = pull & (lam == lam.min()) if not len(out) else np.zeros_like(pull)
        rows = np.union1d(held.rows[~pull], out)
        known = dict(zip(held.rows.tolist(), lam.tolist(), strict=True))
        held = Held(held.x, rows, np.array([[max(known.get(row, 0.0), 0.0) for row in rows.tolist()]]), held.level)
    return None


def over(discs: Discs, held: Held, radii: FloatArray) -> FloatArray:
    """How far each row is exceeded (n_points, n_rows); those of the goal by its level."""
    bound = radii.copy()
    bound[:, : discs.n_goal] = np.sqrt(np.maximum(held.level, 0.0))[:, None]
    return np.asarray(np.abs(held.x @ discs.rows.T + discs.constants) - bound)


def value_of(discs: Discs, x: ComplexArray) -> FloatArray:
    """The goal at x (n_points, n_planes)."""
    left = np.abs(x @ discs.G.T + discs.g)
    return np.asarray(left.max(axis=1) if discs.worst else np.sqrt((left * left).sum(axis=1)))


def multipliers_of(discs: Discs, held: Held) -> tuple[ComplexArray, ComplexArray]:
    """Multipliers z of the goal rows and v of the limits for weak duality (n_points, ...)."""
    n = len(held.x)
    lam = np.zeros((n, len(discs.rows)))
    lam[:, held.rows] = np.maximum(held.multipliers, 0.0)
    pulls = lam * (held.x @ discs.rows.T + discs.constants)
    if discs.worst:
        z = pulls[:, : discs.n_goal]
        size = np.abs(z).sum(axis=1)
    else:
        z = held.x @ discs.G.T + discs.g
        size = np.sqrt((np.abs(z) ** 2).sum(axis=1))
    unit = 1.0 / np.maximum(size, 1e-300)[:, None]
    return z * unit, pulls[:, discs.n_goal : discs.n_goal + discs.n_limits] * unit


def bound_of(discs: Discs, held: Held, radii: FloatArray) -> FloatArray:
    """What no point within the rows comes below, whatever x and the multipliers are (n_points,)."""
    z, v = multipliers_of(discs, held)
    limits, caps = radii[:, discs.n_goal : discs.n_goal + discs.n_limits], radii[:, discs.n_goal + discs.n_limits :]
    far = FAR * (1.0 + np.abs(held.x).max(axis=1, keepdims=True))
    lost = np.abs(z @ discs.G.conj() + v @ discs.M.conj()) * np.where(np.isfinite(caps), caps, far)
    constant = (z.conj() @ discs.g).real + (v.conj() @ discs.k).real
    return np.asarray(constant - (np.abs(v) * np.where(v != 0.0, limits, 0.0)).sum(axis=1) - lost.sum(axis=1))
