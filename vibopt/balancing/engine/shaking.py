"""Shaking forces and couples of an engine, order by order, linear in what is chosen.

In the plane across the crankshaft a vector is x + iy, x along the axis of bank zero, y a quarter turn on in the sense
of rotation.  Each order k is P exp(i k a) + N exp(-i k a), a the crank angle: two arms that turn with and against the
crank.  Their ellipse is |P| + |N| at its longest; in-line pistons alone have |P| = |N|, a line.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.balancing.engine.engine_job import EngineJob, Share
from vibopt.records import dataclass

_DIGITS = 21.0
"""Powers of the squared ratio are summed down to exp(-2 * 21), 1e-18."""


def exact_orders(ratio: float, highest: int) -> FloatArray:
    """A_0..A_highest for crank over rod `ratio` < 1, shape (highest + 1,); index is the order, A_0 = 0.

    From the binomial series of the square root, with each power of the sine written as a cosine series.
    """
    series = np.zeros(highest + 1)
    series[1] = 1.0
    for half in range(1, highest // 2 + 1):
        series[2 * half] = (2 * half) ** 2 * _cosine_of_root(ratio, half)
    return series


def truncated_orders(ratio: float, highest: int) -> FloatArray:
    """The textbook's series: A_1 = 1, A_2 = ratio, nothing beyond; shape (highest + 1,)."""
    series = np.zeros(highest + 1)
    series[1:3] = (1.0, ratio)
    return series


@cache
def _cosine_of_root(ratio: float, half: int) -> float:
    """Coefficient of cos(2 half a) in sqrt(1 - ratio² sin²(a)) / ratio."""
    binomial = math.prod((0.5 - j) / (j + 1.0) for j in range(half))
    first = -2.0 * abs(binomial) * (ratio / 2.0) ** (2 * half)
    count = math.ceil(-_DIGITS / math.log(ratio)) + half
    k = np.arange(1.0, count)
    steps = (half + k - 1.5) * (half + k - 0.5) / (k * (2.0 * half + k)) * ratio**2
    sum_of_terms = 1.0 + float(np.cumprod(steps)[::-1].sum())  # all of one sign, the small ones first
    return float((-1) ** half) * first * sum_of_terms / ratio


_GRID, _NEAR = 1440, 0.99
"""Crank angles at which the greatest size is looked for, and the part of it above which others are refined."""


@dataclass(frozen=True)
class Arms:
    """Arms of force (rows 0) and couple (rows 1) per order, affine in the choices x.

    constant
        Shape (2, 2, n_orders + 1): force or couple, arm with or against, order [N, N m].
    slope
        Shape (2, 2, n_orders + 1, n_x) per unit of x: shares [1], which are real, then complex unbalances [kg m].
    """

    constant: ComplexArray
    slope: ComplexArray

    def at(self, x: ComplexArray) -> ComplexArray:
        """Arms at the choices x, shape (2, 2, n_orders + 1)."""
        found: ComplexArray = self.constant + self.slope @ x
        return found


def free_weights(job: EngineJob) -> list[int]:
    """Indices of the weights that are chosen."""
    return [k for k, weight in enumerate(job.weights) if weight.fixed is None]


def free_shares(job: EngineJob) -> list[Share]:
    """Shares of the counterweights opposite each crank that are chosen."""
    return [share for share in job.shares if share.is_free]


def carried_shares(job: EngineJob, x: ComplexArray) -> list[float]:
    """Every share of the job at the choices x, as given or as chosen."""
    free = free_shares(job)
    return [float(x[free.index(share)].real) if share.is_free else share.low for share in job.shares]


def turning_weights(job: EngineJob, x: ComplexArray) -> list[complex]:
    """Unbalance of every weight at crank angle zero at the choices x, as given or as chosen [kg m]."""
    chosen = iter(x[len(free_shares(job)) :].tolist())
    return [next(chosen) if weight.fixed is None else weight.fixed for weight in job.weights]


def size_of(job: EngineJob, couple: bool, *, rotating: bool = True) -> float:
    """Sum of the primary forces [N] or couples [N m] of all cylinders, with or without rotating masses; 1 for none."""
    levers = [abs(cylinder.at) if couple else 1.0 for cylinder in job.cylinders]
    masses = [cylinder.reciprocating + cylinder.rotating * rotating for cylinder in job.cylinders]
    return sum(a * b for a, b in zip(levers, masses, strict=True)) * job.speed**2 or 1.0


def arms(job: EngineJob, cranks: Sequence[float], *, truncated: bool | None = None) -> Arms:
    """Arms of all orders for given crank angles per throw [rad]; x: free shares, then free weights."""
    short = job.truncated if truncated is None else truncated
    series = (truncated_orders if short else exact_orders)(job.ratio, job.orders)
    free, chosen = free_weights(job), free_shares(job)
    constant = np.zeros((2, 2, job.orders + 1), dtype=complex)
    slope = np.zeros((2, 2, job.orders + 1, len(chosen) + len(free)), dtype=complex)
    speed2 = job.speed**2
    order = np.arange(job.orders + 1)
    for cylinder in job.cylinders:
        crank = cranks[cylinder.throw]
        levers = np.array([1.0, cylinder.at])
        half = 0.5 * speed2 * cylinder.reciprocating * series * np.exp(1j * cylinder.bank)
        turn = np.exp(1j * order * (crank - cylinder.bank))
        constant[:, 0] += np.outer(levers, half * turn)
        constant[:, 1] += np.outer(levers, half / turn)
        pin = speed2 * np.exp(1j * crank) * levers
        constant[:, 0, 1] += pin * cylinder.rotating
        for share in job.shares:
            if share.is_free:
                slope[:, 0, 1, chosen.index(share)] -= pin * share.of(cylinder)
            else:
                constant[:, 0, 1] -= pin * share.low * share.of(cylinder)
    for k, weight in enumerate(job.weights):
        arm = np.array([1.0, weight.at]) * (weight.order**2 * speed2)
        side = 0 if weight.sense > 0 else 1
        if weight.fixed is not None:
            constant[:, side, weight.order] += arm * weight.fixed
        else:
            slope[:, side, weight.order, len(chosen) + free.index(k)] += arm
    return Arms(constant, slope)


def of_order(found: ComplexArray, couple: bool, order: int) -> float:
    """Greatest force [N] or couple [N m] of one order over a turn; of all orders together where `order` is 0."""
    if order == 0:
        return peak(found, couple)
    if order >= found.shape[2]:
        return 0.0
    return float(np.abs(found[int(couple), :, order]).sum())


def at_crank(found: ComplexArray, couple: bool, order: int, crank: float) -> float:
    """Size of the force [N] or couple [N m] at one crank angle [rad]; `order` 0: all together."""
    orders = np.arange(found.shape[2]) if order == 0 else np.array([order])
    with_, against = found[int(couple), :, orders].T if order else found[int(couple)]
    return float(abs((with_ * np.exp(1j * orders * crank) + against * np.exp(-1j * orders * crank)).sum()))


@cache
def _turns(n_orders: int, samples: int) -> ComplexArray:
    """exp(i k a) at evenly spaced crank angles a, shape (samples, n_orders)."""
    turn = 2.0 * np.pi * np.arange(samples) / samples
    return np.asarray(np.exp(1j * np.outer(turn, np.arange(n_orders))))


def over_turn(found: ComplexArray, couple: bool, crank: FloatArray) -> ComplexArray:
    """Force or couple at crank angles [rad], all orders together, same shape as `crank`."""
    orders = np.arange(found.shape[2])
    turn = np.exp(1j * np.outer(crank, orders))
    total: ComplexArray = turn @ found[int(couple), 0] + turn.conj() @ found[int(couple), 1]
    return total


def around(found: ComplexArray, couple: bool, samples: int) -> ComplexArray:
    """The same at evenly spaced crank angles from zero on, (samples,)."""
    turns, (with_, against) = _turns(found.shape[2], samples), found[int(couple)]
    total: ComplexArray = turns @ with_ + turns.conj() @ against
    return total


def peak(found: ComplexArray, couple: bool) -> float:
    """Greatest size over a turn of all orders together."""
    if np.abs(found[int(couple)]).max() == 0.0:
        return 0.0
    return float(peaks(found, couple)[1].max())


def peaks(found: ComplexArray, couple: bool) -> tuple[FloatArray, FloatArray]:
    """Crank angles [rad] and sizes of all orders together where those are greatest in their surroundings, each (n,).

    Of a grid, those within 1 % of the greatest, refined by ever smaller steps.
    """
    step = 2.0 * np.pi / _GRID
    sizes = np.abs(around(found, couple, _GRID))
    tops = (sizes >= np.roll(sizes, 1)) & (sizes >= np.roll(sizes, -1)) & (sizes >= _NEAR * sizes.max())
    best: FloatArray = np.asarray(step * np.flatnonzero(tops), dtype=np.float64)
    low = step
    while low > 1e-9:
        near = best[:, None] + low * np.linspace(-1.0, 1.0, 9)
        most = np.abs(over_turn(found, couple, near.ravel())).reshape(near.shape).argmax(axis=1)
        best, low = near[np.arange(len(best)), most], 0.25 * low
    return best, np.asarray(np.abs(over_turn(found, couple, best)), dtype=np.float64)
