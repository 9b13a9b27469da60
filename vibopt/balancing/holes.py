"""What can be fitted in one plane with holes, radii and the weights on the shelf: a list of unbalances and masses."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.errors import InputError
from vibopt.records import dataclass

MOST_OPTIONS = 3_000_000


@dataclass(frozen=True)
class HoleOptions:
    """Every way of fitting at most so many weights, those of equal unbalance once (the lightest).

    unbalances, masses
        Shape (n_options,) [kg m, kg]; the first is the empty plane.
    fitted
        Shape (n_options, most_weights), places in the list of single weights, -1 for none.
    single
        (angle [rad], radius [m], mass [kg]) of each single weight in each hole, shape (n_single, 3).
    """

    unbalances: ComplexArray
    masses: FloatArray
    fitted: NDArray[np.intp]
    single: FloatArray

    def weights(self, option: int) -> tuple[tuple[float, float, float], ...]:
        """(angle [rad], radius [m], mass [kg]) of each weight of an option."""
        return tuple(tuple(self.single[k]) for k in self.fitted[option] if k >= 0)


def hole_options(
    angles: FloatArray, radii: FloatArray, shelf: FloatArray, most_weights: int = 1, per_hole: int = 1
) -> HoleOptions:
    """List the ways of fitting up to `most_weights` weights, at most `per_hole` in one hole.

    Parameters
    ----------
    angles
        Angles of the holes [rad], shape (n_holes,).
    radii
        Radii there are at each angle [m], shape (n_radii,); each is a hole of its own.
    shelf
        Masses on the shelf [kg], each as often as wanted, shape (n_weights,).  Negative for drilled material.

    Raises
    ------
    InputError
        More than three million ways.
    """
    grid = np.array([(a, r, m) for a in angles for r in radii for m in shelf])
    hole = np.repeat(np.arange(len(angles) * len(radii)), len(shelf))
    first, n = np.unique(hole, return_index=True)[1], len(grid)
    assert len(first) == len(angles) * len(radii)
    fitted = [np.full((1, most_weights), -1)]
    level = np.empty((1, 0), dtype=int)
    for count in range(1, most_weights + 1):
        level = _one_more(level, hole, per_hole, n)
        fitted.append(np.hstack([level, np.full((len(level), most_weights - count), -1)]))
        if sum(map(len, fitted)) > MOST_OPTIONS:
            raise InputError(
                f"{len(first)} holes with {len(shelf)} weights and up to {most_weights} of them at once can be fitted"
                f" in more than {MOST_OPTIONS} ways. Allow fewer weights at once, or list fewer weights."
            )
    return _once_each(np.vstack(fitted), grid)


def _one_more(level: NDArray[np.intp], hole: NDArray[np.intp], per_hole: int, n: int) -> NDArray[np.intp]:
    """Every set with one more weight, in rising order, that keeps the number per hole."""
    if not level.shape[1]:
        return np.arange(n)[:, None]
    counts = n - level[:, -1]
    if int(counts.sum()) > 4 * MOST_OPTIONS:
        return np.zeros((MOST_OPTIONS + 1, level.shape[1] + 1), dtype=int)
    rows = np.repeat(np.arange(len(level)), counts)
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    added = level[rows, -1] + np.arange(len(rows)) - starts[rows]
    more = np.column_stack([level[rows], added])
    same = (hole[more[:, :-1]] == hole[added][:, None]).sum(axis=1)
    return np.asarray(more[same < per_hole])


def _once_each(fitted: NDArray[np.intp], grid: FloatArray) -> HoleOptions:
    """Of the sets with the same unbalance the lightest one, in rising mass."""
    unbalance = np.append(grid[:, 1] * grid[:, 2] * np.exp(1j * grid[:, 0]), 0.0)
    mass = np.append(np.abs(grid[:, 2]), 0.0)
    totals, masses = unbalance[fitted].sum(axis=1), mass[fitted].sum(axis=1)
    grain = 1e-9 * float(np.abs(unbalance).max()) or 1.0
    cells = np.round(np.column_stack([totals.real, totals.imag]) / grain)
    order = np.lexsort((np.arange(len(masses)), np.round(masses / (1e-9 * masses.max() or 1.0))))
    kept = np.sort(order[np.unique(cells[order], axis=0, return_index=True)[1]])
    kept = kept[np.argsort(np.abs(totals[kept]) + masses[kept], kind="stable")]
    kept = np.concatenate([[0], kept[kept != 0]])
    return HoleOptions(totals[kept], masses[kept], fitted[kept], grid)


def splits(target: complex, angles: FloatArray, radius: float) -> tuple[tuple[int, float], tuple[int, float]] | None:
    """Two neighbouring holes and the masses [kg] in them that together make the unbalance `target` [kg m] exactly.

    None where fewer than two holes are there or the target does not lie between two holes less than half a turn apart.
    """
    if len(angles) < 2:
        return None
    order = np.argsort(angles % (2.0 * np.pi))
    for a, b in zip(order, np.roll(order, -1), strict=True):
        basis = radius * np.array([[np.cos(angles[a]), np.cos(angles[b])], [np.sin(angles[a]), np.sin(angles[b])]])
        if abs(np.linalg.det(basis)) < 1e-12 * radius**2:
            continue
        masses = np.linalg.solve(basis, [target.real, target.imag])
        if masses.min() >= -1e-12 * abs(target) / radius:
            return (int(a), float(max(masses[0], 0.0))), (int(b), float(max(masses[1], 0.0)))
    return None
