"""Least squares and least worst residual within discs by an interior-point method on the squares of all moduli.

With s for the square of the worst, |G x + g|² <= s, |F x + f|² <= bound² and |x|² <= cap² are smooth and convex.
Newton's method follows slacks and multipliers whose products go to zero together; each step looks ahead first, and
takes into account what the squares bend and what the products move (Mehrotra, 1992).  It takes 6 to 15 steps, and
whoever asks proves the answer.
"""

from __future__ import annotations

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray, solved
from vibopt.cones import over_parts

STEPS = 30
CLOSED = 1e-11  # of the goal's square
_TO_EDGE = 0.9999  # how much of the way to where a slack or a multiplier is zero
_BEGIN = (0.01, 0.3)  # least slack of rows kept, and of rows exceeded, at x = 0 as parts of their bounds
_SHORT = 0.01  # no way is left


class _Squares:
    """Half the squares of goal rows, limits and caps over the real and imaginary parts of x, and s.

    weights
        Of real and imaginary parts and of slopes, (3, n_rows): the first two multipliers, one for least squares.
    first
        From this row on they are held by bounds, whose squares are twice `half`.
    """

    def __init__(self, M: ComplexArray, c: ComplexArray, bounds: FloatArray, n_goal: int, *, worst: bool) -> None:
        self.worst, self.n_goal, self.n_parts = worst, n_goal, 2 * M.shape[1]
        self.first = 0 if worst else n_goal
        self.half, self.constant = 0.5 * bounds**2, np.stack([c.real, c.imag])
        rows = np.zeros((3, len(M), self.n_parts + worst))
        rows[:2, :, : self.n_parts] = over_parts(M)
        self.parts, self.slopes, self.every = rows[:2], rows[2], rows.reshape(3 * len(M), -1)
        self.flat, self.held = self.every[: 2 * len(M)], self.slopes[self.first :]
        self.weights = np.zeros((3, len(M)))
        self.weights[:2, : self.first] = 1.0
        self.cost = np.zeros(self.n_parts + worst)
        self.cost[self.n_parts :] = 0.5

    def along(self, x: FloatArray) -> FloatArray:
        """Parts of what all rows move by x (2, n_rows)."""
        return (self.flat @ x).reshape(2, -1)

    def at(self, x: FloatArray) -> tuple[FloatArray, FloatArray, float]:
        """Parts of all rows (2, n_rows), how far those held are beyond their bounds, and half the goal's square."""
        r = self.along(x) + self.constant
        np.multiply(r[0, :, None], self.parts[0], out=self.slopes)
        self.slopes += r[1, :, None] * self.parts[1]
        self.slopes[: self.n_goal, self.n_parts :] = -0.5
        squares = 0.5 * (r[0] * r[0] + r[1] * r[1])
        size = 0.5 * float(x[-1]) if self.worst else float(squares[: self.n_goal].sum())
        squares -= self.half
        if self.worst:
            squares[: self.n_goal] -= size
        return r, squares[self.first :], size

    def step(
        self, pair: FloatArray, beyond: FloatArray, pull: FloatArray, least: float
    ) -> tuple[FloatArray, FloatArray]:
        """A step of x, and of slacks and multipliers `pair` (2, n_held), which looks ahead first.

        The sum of their products goes to `least` and no further, where slacks would lose their digits.  Ahead slacks
        change by the parts `ahead`, and multipliers by -1 - `ahead` of them: no product would be left.
        """
        slack, multipliers = pair
        rate, off, products = multipliers / slack, beyond + slack, slack * multipliers
        self.weights[2, self.first :] = rate
        K = (self.every.T * self.weights.ravel()) @ self.every
        right = (rate * beyond) @ self.held + pull
        move = solved(K, -right)
        ahead = -(off + self.held @ move) / slack
        part = 1.0 / max(-float(ahead.min()), 1.0 + float(ahead.max()), 1.0)
        bent, moved = self.along(move)[:, self.first :], part**2 * products * ahead * (1.0 + ahead)
        gap = float(products.sum())
        centre = max((1.0 - part - float(moved.sum()) / gap) ** 2 * gap, least)
        curve = 0.5 * part**2 * (bent[0] * bent[0] + bent[1] * bent[1])
        more = (moved + centre / len(slack)) / slack
        move = solved(K, -right - (more + rate * curve) @ self.held)
        down = off + curve + self.held @ move
        return move, np.array([-down, more - multipliers + rate * down])


@np.errstate(all="ignore")  # a step that overflows proves nothing
def least_within(
    G: ComplexArray, g: ComplexArray, F: ComplexArray, f: ComplexArray, caps: FloatArray, *, worst: bool
) -> tuple[ComplexArray, ComplexArray, ComplexArray] | None:
    """The x of least norm |G x + g|, or with `worst` of its least greatest modulus; None where it does not settle.

    Parameters
    ----------
    G, g
        Rows of order one, shape (n_goal, n_planes) and (n_goal,).
    F, f
        Limits |F x + f| <= 1, shape (n_limits, n_planes) and (n_limits,).
    caps
        |x| <= caps (n_planes,); inf without one.

    Returns
    -------
    tuple
        x (n_planes,), and the pulls of goal rows and limits, residuals times multipliers: their slopes and that of the
        caps add up to nothing.
    """
    n, k, capped = G.shape[1], len(g), (caps < np.inf).nonzero()[0]
    M, c = np.concatenate([G, F, np.eye(n)[capped]]), np.concatenate([g, f, np.zeros(len(capped))])
    rows = _Squares(M, c, np.concatenate([np.zeros(k), np.ones(len(f)), caps[capped]]), k, worst=worst)
    if rows.first == len(M):  # nothing holds
        return None
    x, pair = np.zeros(2 * n + worst), np.empty((0, 0))
    x[2 * n :] = 1.1 * float(np.abs(g).max()) ** 2
    for _ in range(STEPS):
        r, beyond, size = rows.at(x)
        if not len(pair):
            bounds = np.maximum(rows.half, size)[rows.first :]
            slack = np.maximum(-beyond, np.where(beyond < 0.0, *_BEGIN) * bounds)
            pair = np.array([slack, size / slack / len(slack)])
        rows.weights[:2, rows.first :] = pair[1]
        pull = rows.cost + rows.weights[0] @ rows.slopes
        least = CLOSED * size
        if pair[0] @ pair[1] <= least and max(np.abs(beyond + pair[0]).max(), np.abs(pull).max()) <= least:
            pulls = rows.weights[0] * (r[0] + 1j * r[1])
            return x[:n] + 1j * x[n : 2 * n], pulls[:k], pulls[k : k + len(f)]
        move, step = rows.step(pair, beyond, pull, 0.1 * least)
        part = 1.0 / max(-float((step / pair).min()) / _TO_EDGE, 1.0)  # the first slack or multiplier stays above zero
        if not part > _SHORT:
            return None
        x, pair = x + part * move, pair + part * step
    return None
