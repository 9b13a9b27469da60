"""What the points of a large structure need of it, by rational interpolation.

The matrices are projected on motions under unit loads at the points at a few frequencies, standstill
among them.  For symmetric matrices the projected receptances then agree with the true ones, with their
slopes, at each of these frequencies.  The next frequency is the one where two successive projections
differ most; what the last one misses is measured with fresh solutions of the full matrices.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray, IntArray
from vibopt.mechanics.host.coordinates import Coordinates
from vibopt.mechanics.host.lowest import free_motions, lowest_modes, still, undamped
from vibopt.mechanics.host.matrices import Matrices, negative_count, solve
from vibopt.records import dataclass

TARGET = 1e-10
CHECKS = 11
_GRID = 400
_MOST, _WIDEST = 60, 240
_FEW, _AT_ONCE, _APART = 16, 6, 8
"""Frequencies after which modes are counted, those used at once among many modes, and points of the grid between."""
_SAME, _LEFT = 1e-11, 1e-8
"""Parts: of a motion below which it is nothing new, and between two projections up to which many modes are carried."""
_ABOVE = 1.2


@dataclass(frozen=True, eq=False)
class Reduction:
    """A structure on the coordinates that its points need.

    coordinates
        The coordinates; points in the order asked for.
    size
        Degrees of freedom of the full matrices.
    error
        Greatest relative error of the receptances among the checks.
    checks
        Number of frequencies at which the full matrices were solved for comparison.
    solved
        Number of frequencies at which the full matrices were factored in all.
    top
        Highest frequency that was looked at [rad/s].
    """

    coordinates: Coordinates
    size: int
    error: float
    checks: int
    solved: int
    top: float


class _Basis:
    """Motions, orthonormal by mass, and the matrices projected on them.

    Products with the large matrices are summed in long doubles, because entries of K nearly cancel.
    """

    def __init__(self, matrices: Matrices, places: IntArray) -> None:
        self.matrices = matrices
        self.places = places
        self.count = 0
        self._rows = np.zeros((16, matrices.size))
        self._weighed = np.zeros((16, matrices.size))
        self.small = {key: np.zeros((0, 0)) for key in "MCK"}

    @property
    def vectors(self) -> FloatArray:
        """The motions as rows, shape (r, n)."""
        return self._rows[: self.count]

    def add(self, motion: Any) -> None:
        """Add the part of motions (n, k) that is new; real and imaginary part where they are complex."""
        columns = np.hstack([motion.real, motion.imag]) if np.iscomplexobj(motion) else motion
        for column in columns.T.astype(float):
            self._add_one(column)

    def _add_one(self, column: FloatArray) -> None:
        mass = self.matrices.mass
        size = float(np.sqrt(column @ (mass @ column)))
        if size == 0.0 or not np.isfinite(size):
            return
        rest = column / size
        for _ in range(2):
            rest = rest - (self._weighed[: self.count] @ rest) @ self.vectors
        weighed = mass @ rest
        left = float(np.sqrt(rest @ weighed))
        if left > _SAME:
            self._keep(rest / left, weighed / left)

    def _keep(self, vector: FloatArray, weighed: FloatArray) -> None:
        if self.count == len(self._rows):
            self._rows = np.vstack([self._rows, np.zeros_like(self._rows)])
            self._weighed = np.vstack([self._weighed, np.zeros_like(self._weighed)])
        self._rows[self.count], self._weighed[self.count] = vector, weighed
        self.count += 1
        long = vector.astype(np.longdouble)
        for key, matrix in zip("MCK", self.matrices.long, strict=True):
            column = self.vectors @ (matrix @ long).astype(float)
            grown = np.empty((self.count, self.count))
            grown[:-1, :-1] = self.small[key]
            grown[-1], grown[:, -1] = column, column
            self.small[key] = grown

    def coordinates(self, names: list[str]) -> Coordinates:
        """The projected structure on its own undamped modes, mass 1 each."""
        points = dict(zip(names, self.vectors[:, self.places].T, strict=True))
        return _on_modes(self.small, points, self.matrices)


def _on_modes(small: dict[str, Any], points: dict[str, Any], matrices: Matrices) -> Coordinates:
    """M, C, K (r, r), and rows of points over their coordinates (r,), on their undamped modes, mass 1 each.

    The first coordinates are the free motions of the structure, the others have no part in them.
    """
    free = free_motions(matrices)
    held = slice(free.count, None)
    squares, shapes = np.zeros(len(small["M"])), np.eye(len(small["M"]), dtype=np.longdouble)
    if free.count < len(squares):
        found, shapes[held, held] = undamped(*(small[key][held, held].astype(np.longdouble) for key in "MK"))
        squares[held] = np.maximum(found, 0.0)
    damping = (shapes.T @ small["C"] @ shapes).astype(float)
    damping[: free.coasting], damping[:, : free.coasting] = 0.0, 0.0  # rounding would hold what is free to the ground
    rows = {name: (row.astype(np.longdouble) @ shapes).astype(float) for name, row in points.items()}
    off = damping - np.diag(np.diag(damping))
    if np.abs(off).max(initial=0.0) <= 1e-13 * np.abs(damping).max(initial=0.0):
        damping = np.diag(np.diag(damping))
    return Coordinates(np.ones(len(squares)), squares, damping, rows, matrices.loss_factor)


def reduced_host(matrices: Matrices, points: dict[str, int], top: float, *, modes: int = 0) -> Reduction:
    """The structure on as few coordinates as its points need up to a frequency.

    Parameters
    ----------
    matrices
        The structure.
    points
        Coordinate number per named point.
    top
        Highest frequency of interest [rad/s].
    modes
        Number of lowest natural modes that must be there, seen from the points or not.

    Notes
    -----
    Among more modes than frequencies that are used at first, more are, as long as projections differ; where the
    coordinates then do not suffice, the error says what a resonance between frequencies of the grid may be off by.
    """
    places = np.array(list(points.values()), dtype=np.intp)
    names = list(points)
    loads = matrices.units(places)
    basis = _Basis(matrices, places)
    basis.add(free_motions(matrices).motions)
    if modes:
        frequencies, shapes = lowest_modes(matrices, modes)
        basis.add(shapes)
        top = max(top, _ABOVE * float(frequencies[-1]))
    grid = top * np.linspace(0.0, 1.0, _GRID + 1)[1:]
    used = _begin(matrices, basis, loads, top)
    now = basis.coordinates(names)
    value, before = now.receptances(grid), np.zeros((len(grid), len(places), len(places)), dtype=complex)
    crowded = False
    while True:
        differ = _differ(value, before, grid, used)
        off = float(differ.max())
        if off <= 0.1 * TARGET:
            break
        if len(used) == _FEW:
            crowded = negative_count(matrices.dynamic(top**2, 0.0)) > _MOST
        if len(used) >= _MOST and (not crowded or basis.count >= _WIDEST):
            break  # beside fewer modes than that rounding alone is left
        for omega in _worst(differ, grid, _AT_ONCE if crowded else 1):
            used.append(omega)
            basis.add(solve(matrices, loads, omega).motion)
        now, before = basis.coordinates(names), value
        value = now.receptances(grid)
    found = _checked(matrices, basis, names, loads, top, used)
    if not crowded or off <= _LEFT:
        return found
    return replace(found, error=max(found.error, min(off * _narrow(found, grid), 1.0)))


def _narrow(found: Reduction, grid: FloatArray) -> float:
    """How many times higher than on a grid a resonance may be, that lies between its points and hardly decays."""
    of = found.coordinates
    fast = np.sqrt(of.stiffness / of.mass)
    inside = (fast > 0.0) & (fast < found.top)
    decays = 0.5 * (np.diag(of.damping) / of.mass + of.loss_factor * fast)[inside]
    return max(1.0, float((grid[1] - grid[0]) / max(decays.min(initial=np.inf), 1e-300)))


def whole_host(matrices: Matrices, points: dict[str, int]) -> Reduction:
    """The structure on all of its modes, for what holds every frequency; checked up to the highest of them.

    Parameters
    ----------
    matrices
        The structure.
    points
        Coordinate number per named point.
    """
    places, free = np.array(list(points.values()), dtype=np.intp), free_motions(matrices)
    whole = _beside(matrices, free.motions)
    small = {key: whole.T @ (one @ whole) for key, one in zip("MCK", matrices.long, strict=True)}
    now = _on_modes(small, {name: whole[place] for name, place in points.items()}, matrices)
    top, loads = _ABOVE * float(np.sqrt(now.stiffness.max())), matrices.units(places)
    checks = _between([0.0, top], top, CHECKS)
    errors = [_error(now, omega, solve(matrices, loads, omega).motion[places].astype(complex)) for omega in checks]
    return Reduction(now, matrices.size, max(errors), len(checks), len(checks), top)


def _beside(matrices: Matrices, free: FloatArray) -> Any:
    """A basis of all motions, (n, n) in long doubles: the free ones, then those that have no part in them."""
    from scipy.linalg import qr

    whole = np.eye(matrices.size, dtype=np.longdouble)
    if not free.shape[1]:
        return whole
    whole -= free @ (matrices.long[0] @ free.astype(np.longdouble)).T
    weighed = np.sqrt(matrices.mass.diagonal()) * free.T
    leading = qr(weighed, pivoting=True, mode="r")[1][: free.shape[1]]
    return np.hstack([free, np.delete(whole, leading, axis=1)])


def _begin(matrices: Matrices, basis: _Basis, loads: FloatArray, top: float) -> list[float]:
    """Standstill, of what is held, and the top frequency."""
    basis.add(still(matrices, loads).motion)
    basis.add(solve(matrices, loads, top).motion)
    return [0.0, top]


def _differ(now: ComplexArray, before: ComplexArray, grid: FloatArray, used: list[float]) -> FloatArray:
    """Relative difference of two projections on the grid; nothing beside frequencies already used."""
    size = np.abs(now).max(axis=(1, 2)) + np.abs(before).max(axis=(1, 2))
    with np.errstate(divide="ignore", invalid="ignore"):
        differ = np.nan_to_num(np.abs(now - before).max(axis=(1, 2)) / size)
    step = 0.6 * (grid[1] - grid[0])
    taken = (np.abs(grid[:, None] - np.array(used)) < step).any(axis=1)
    return np.where(taken, 0.0, differ)


def _worst(differ: FloatArray, grid: FloatArray, count: int) -> list[float]:
    """Frequencies at which two projections differ most, apart from each other."""
    left, found = differ.copy(), list[float]()
    for _ in range(count):
        place = int(left.argmax())
        if found and left[place] <= 0.1 * TARGET:
            break
        found.append(float(grid[place]))
        left[max(place - _APART, 0) : place + _APART + 1] = 0.0
    return found


def _checked(
    matrices: Matrices, basis: _Basis, names: list[str], loads: FloatArray, top: float, used: list[float]
) -> Reduction:
    """Measure the error at fresh frequencies between the used ones; what misses is used too, and measured anew."""
    now = basis.coordinates(names)
    done, worst, solved = 0, 0.0, len(used)
    while done < CHECKS:
        omega = _between(used, top, 1)[0]
        used.append(omega)
        true = solve(matrices, loads, omega).motion
        wanted = true[basis.places].astype(complex)
        error, solved = _error(now, omega, wanted), solved + 1
        if error > TARGET and solved < 2 * _MOST and basis.count < _WIDEST:
            basis.add(true)
            now, missed = basis.coordinates(names), error
            error = _error(now, omega, wanted)  # small by itself: only another frequency tells
            if error < 0.1 * missed:
                done, worst = 0, 0.0
                continue
        done, worst = done + 1, max(worst, error)
    return Reduction(now, matrices.size, worst, done, solved, top)


def _error(now: Coordinates, omega: float, wanted: ComplexArray) -> float:
    found = now.receptances(np.array([omega]))[0]
    return float(np.abs(found - wanted).max() / np.abs(wanted).max())


def _between(used: list[float], top: float, count: int) -> list[float]:
    """Frequencies in the widest gaps between those used, golden parts so that no pattern is met."""
    known = sorted(used)
    fresh: list[float] = []
    for _ in range(count):
        gaps = np.diff(np.array(known))
        widest = int(gaps.argmax())
        omega = known[widest] + 0.381966 * float(gaps[widest])
        fresh.append(omega)
        known = sorted([*known, omega])
    return [value for value in fresh if value <= top]
