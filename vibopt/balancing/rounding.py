"""Good discrete corrections quickly: the nearest options of a continuous answer, bettered by exchange."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vibopt.balancing.convex import KEPT
from vibopt.balancing.scaled import Scaled
from vibopt.forms import ComplexArray, FloatArray

NO_STOCK: FloatArray = np.empty(0)
CHUNK = 2_000_000  # complex numbers held at once
MOST_PAIRS = 3_000_000


def judge(scene: Scaled, x: ComplexArray, masses: FloatArray) -> FloatArray:
    """The goal of each correction, and 1e6 and more where limits or total are not kept; shape (n,).

    Parameters
    ----------
    x, masses
        Shape (n, n_planes), scaled.
    """
    step = max(1, CHUNK // max(len(scene.g) + len(scene.f), 1))
    return np.concatenate(
        [_judge(scene, x[k : k + step], masses[k : k + step]) for k in range(0, max(len(x), 1), step)]
    )


def _judge(scene: Scaled, x: ComplexArray, masses: FloatArray) -> FloatArray:
    total = masses.sum(axis=1)
    values = total.copy() if scene.goal == "correction" else measure(scene, np.abs(x @ scene.G.T + scene.g))
    over = np.maximum(total / scene.total - 1.0, 0.0) if np.isfinite(scene.total) else np.zeros(len(x))
    if len(scene.f):
        over = over + np.maximum(np.abs(x @ scene.F.T + scene.f).max(axis=1) - 1.0, 0.0)
    return np.where(over > KEPT, 1e6 * (1.0 + over), values)


def measure(scene: Scaled, t: FloatArray) -> FloatArray:
    """The scaled goal of moduli (n, n_rows); not for "correction"."""
    if scene.goal == "rms":
        return np.asarray(np.linalg.norm(t, axis=1) / scene.divisor)
    if scene.goal == "worst":
        return np.asarray(t.max(axis=1, initial=0.0))
    if scene.goal == "sum":
        return np.asarray(t.sum(axis=1))
    inside = np.minimum(t, scene.huber)
    return np.asarray((inside * inside + 2.0 * np.where(t > inside, inside * (t - inside), 0.0)).sum(axis=1))


def short_of(used: FloatArray, stock: FloatArray) -> FloatArray:
    """How many weights are missing from the stock, shape (n,), for uses (n, n_kinds)."""
    return np.asarray(np.maximum(used - stock, 0.0).sum(axis=1))


def rounded(
    scene: Scaled,
    lists: list[ComplexArray],
    masses: list[FloatArray],
    x: ComplexArray,
    sweeps: int = 6,
    uses: Sequence[FloatArray] = (),
    stock: FloatArray = NO_STOCK,
) -> tuple[list[int], float]:
    """Places of good options near x (n_planes,) and their goal: one option is exchanged, then two, while that helps.

    `uses` (n_options, n_kinds) per list and `stock` (n_kinds,) count the weights that there are; 1e6 and more is the
    goal of a choice for which they do not suffice.
    """
    chosen = [int(np.argmin(np.abs(options - x[p]))) for p, options in enumerate(lists)]
    best = np.inf
    for _ in range(sweeps):
        before = best
        for plane in range(len(lists)):
            chosen, best = _exchange(scene, lists, masses, chosen, (plane,), best, uses, stock)
        if best >= before:
            for p in range(len(lists)):
                for q in range(p):
                    if len(lists[p]) * len(lists[q]) * (len(scene.g) + len(scene.f)) <= MOST_PAIRS:
                        chosen, best = _exchange(scene, lists, masses, chosen, (p, q), best, uses, stock)
        if best >= before:
            break
    return chosen, best


def _exchange(
    scene: Scaled,
    lists: list[ComplexArray],
    masses: list[FloatArray],
    chosen: list[int],
    planes: tuple[int, ...],
    best: float,
    uses: Sequence[FloatArray],
    stock: FloatArray,
) -> tuple[list[int], float]:
    """The best options of one or two planes with the others fixed."""
    grid = [g.ravel() for g in np.meshgrid(*(np.arange(len(lists[p])) for p in planes), indexing="ij")]
    x = np.tile(np.array([lists[p][k] for p, k in enumerate(chosen)], dtype=complex), (len(grid[0]), 1))
    m = np.tile(np.array([masses[p][k] for p, k in enumerate(chosen)]), (len(grid[0]), 1))
    for p, places in zip(planes, grid, strict=True):
        x[:, p], m[:, p] = lists[p][places], masses[p][places]
    values = judge(scene, x, m)
    if len(stock):
        rows = [own[grid[planes.index(p)]] if p in planes else own[[chosen[p]]] for p, own in enumerate(uses)]
        missing = short_of(np.asarray(sum(rows)), stock)
        values = np.where(missing > 0.0, 1e6 * (1.0 + missing) + values, values)
    winner = int(np.argmin(values))
    if values[winner] >= best:
        return chosen, best
    new = list(chosen)
    for p, places in zip(planes, grid, strict=True):
        new[p] = int(places[winner])
    return new, float(values[winner])
