"""Good discrete corrections quickly, by exchange, and bounds on what boxes of options can reach."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.balancing.convex_rounds import KEPT
from vibopt.balancing.scaled import Scaled
from vibopt.records import dataclass

NO_STOCK: FloatArray = np.empty(0)
CHUNK = 2_000_000  # complex numbers held at once
MOST_PAIRS = 300_000
_SWEEPS = 6


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
    values = total.copy() if scene.goal == "correction" else scene.measure(np.abs(x @ scene.G.T + scene.g))
    over = np.maximum(total / scene.total - 1.0, 0.0) if np.isfinite(scene.total) else np.zeros(len(x))
    if len(scene.f):
        over = over + np.maximum(np.abs(x @ scene.F.T + scene.f).max(axis=1) - 1.0, 0.0)
    return np.where(over > KEPT, 1e6 * (1.0 + over), values)


def short_of(used: FloatArray, stock: FloatArray) -> FloatArray:
    """How many weights are missing from the stock, shape (n,), for uses (n, n_kinds)."""
    return np.asarray(np.maximum(used - stock, 0.0).sum(axis=1))


def rounded(
    scene: Scaled,
    lists: list[ComplexArray],
    masses: list[FloatArray],
    x: ComplexArray,
    uses: Sequence[FloatArray] = (),
    stock: FloatArray = NO_STOCK,
) -> tuple[list[int], float]:
    """Places of good options near x (n_planes,) and their goal: one option is exchanged, then two, while that helps.

    `uses` (n_options, n_kinds) per list and `stock` (n_kinds,) count the weights that there are; 1e6 and more is the
    goal of a choice for which they do not suffice.
    """
    chosen = [int(np.argmin(np.abs(options - x[p]))) for p, options in enumerate(lists)]
    best = np.inf
    for _ in range(_SWEEPS):
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


@dataclass(frozen=True)
class Boxes:
    """Middles and half sides (complex: along Re and along Im) per box and plane, least mass of each plane's cell.

    centre, half
        Shape (n_boxes, n_planes), complex, scaled.
    lightest
        Shape (n_boxes, n_planes), scaled mass.
    """

    centre: ComplexArray
    half: ComplexArray
    lightest: FloatArray

    def clip(self, x: ComplexArray, plane: int) -> ComplexArray:
        """x (n_boxes,) of one plane brought into its boxes."""
        off, half = x - self.centre[:, plane], self.half[:, plane]
        inside: ComplexArray = np.clip(off.real, -half.real, half.real) + 1j * np.clip(off.imag, -half.imag, half.imag)
        return self.centre[:, plane] + inside

    def fall(self, slope: ComplexArray, x: ComplexArray) -> FloatArray:
        """Least value of Re slope*(x' - x) over x' in the box, shape (n_boxes, n_planes)."""
        middle = (slope.conj() * (self.centre - x)).real
        least: FloatArray = middle - np.abs(slope.real) * self.half.real - np.abs(slope.imag) * self.half.imag
        return least


def sweep(rows: ComplexArray, t: ComplexArray, weights: FloatArray, boxes: Boxes, x: ComplexArray) -> ComplexArray:
    """One pass over the planes: each plane's best place in its box with the others fixed; x changes, t is returned."""
    for plane in range(rows.shape[1]):
        column = rows[:, plane]
        curvature = weights @ (column.real**2 + column.imag**2)
        step = -((weights * t) @ column.conj()) / np.maximum(curvature, 1e-300)
        new = boxes.clip(x[:, plane] + step, plane)
        t = t + (new - x[:, plane])[:, None] * column
        x[:, plane] = new
    return t


def goal_bounds(
    scene: Scaled, boxes: Boxes, x: ComplexArray, weights: FloatArray, rounds: int, slope: ComplexArray | None = None,
    constant: float = 0.0,
) -> FloatArray:  # fmt: skip
    """Bounds of the goal, shape (n_boxes,); x and weights are improved in place.

    `slope` (n_planes,) and `constant` are Re v*(F x + f) - sum |v| of fixed multipliers of the limits.
    """
    best = np.full(len(x), -np.inf)
    t = x @ scene.G.T + scene.g
    for _ in range(rounds):
        v = _sweep_weights(scene, t, weights)
        t = sweep(scene.G, t, v, boxes, x)
        z, conjugate = _multipliers(scene, t, weights)
        here = (z.conj() * t).real.sum(axis=1) - conjugate
        own = z @ scene.G.conj()
        best = np.maximum(best, here + boxes.fall(own, x).sum(axis=1))
        if constant and slope is not None:
            limits = (x @ slope.conj()).real + constant
            best = np.maximum(best, here + limits + boxes.fall(own + slope, x).sum(axis=1))
        if scene.goal == "worst":
            weights *= np.abs(t)
            weights /= np.maximum(weights.sum(axis=1, keepdims=True), 1e-300)
    return best


def mass_bounds(scene: Scaled, boxes: Boxes, v: ComplexArray) -> FloatArray:
    """Bounds of the sum of masses when the limits have multipliers v (n_boxes or 1, n_limits), shape (n_boxes,).

    Each plane's mass is at least the lightest of its cell and at least `scene.mass` * |x|, which no tangent exceeds.
    """
    slope = v @ scene.F.conj()
    limits = (v.conj() @ scene.f).real - np.abs(v).sum(axis=1)
    zero = np.zeros_like(boxes.centre)
    size = np.abs(boxes.centre)
    tangent = scene.mass * np.divide(boxes.centre, size, out=zero.copy(), where=size > 0)
    off = np.abs(boxes.centre.real), np.abs(boxes.centre.imag)
    near = np.hypot(np.maximum(off[0] - boxes.half.real, 0.0), np.maximum(off[1] - boxes.half.imag, 0.0))
    slack = scene.mass - np.abs(slope)
    cone = np.where(slack >= 0, slack * near, -np.inf)
    least = np.maximum(boxes.lightest + boxes.fall(slope, zero), np.maximum(boxes.fall(slope + tangent, zero), cone))
    bounds: FloatArray = np.maximum(limits + least.sum(axis=1), boxes.lightest.sum(axis=1))
    return bounds


def _sweep_weights(scene: Scaled, t: ComplexArray, weights: FloatArray) -> FloatArray:
    """Weights of the squares whose least value is (nearly) that of the goal at t."""
    if scene.goal == "worst":
        return weights
    if scene.goal == "rms":
        return np.ones(t.shape)
    size = np.abs(t)
    if scene.goal == "sum":
        return 1.0 / np.maximum(size, 1e-6)
    return np.minimum(1.0, scene.huber / np.maximum(size, 1e-300))


def _multipliers(scene: Scaled, t: ComplexArray, weights: FloatArray) -> tuple[ComplexArray, FloatArray | float]:
    """Multipliers in the domain of the goal's conjugate, and the conjugate there."""
    if scene.goal == "rms":
        return t / np.maximum(np.linalg.norm(t, axis=1, keepdims=True) * scene.divisor, 1e-300), 0.0
    if scene.goal == "worst":
        return _unit(weights * t), 0.0
    size = np.abs(t)
    if scene.goal == "sum":
        return t / np.maximum(size, 1e-6), 0.0
    z = 2.0 * t * np.minimum(1.0, scene.huber / np.maximum(size, 1e-300))
    return z, 0.25 * (np.abs(z) ** 2).sum(axis=1)


def _unit(z: ComplexArray) -> ComplexArray:
    """Each row divided by the sum of its moduli."""
    shared: ComplexArray = z / np.maximum(np.abs(z).sum(axis=1, keepdims=True), 1e-300)
    return shared
