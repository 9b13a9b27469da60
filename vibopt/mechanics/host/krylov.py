"""What the points of a large structure need of it, by rational interpolation.

The matrices are projected on motions under unit loads at the points at a few frequencies, standstill
among them.  For symmetric matrices the projected receptances then agree with the true ones, with their
slopes, at each of these frequencies.  The next frequency is the one where two successive projections
differ most; what the last one misses is measured with fresh solutions of the full matrices.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray, IntArray
from vibopt.mechanics.host.coordinates import Coordinates
from vibopt.mechanics.host.matrices import Matrices, factored, solve
from vibopt.records import dataclass

TARGET = 1e-10
CHECKS = 11
_GRID = 400
_MOST = 60
_SAME = 1e-11
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
        return _on_modes(self.small, points, self.matrices.loss_factor)


def _on_modes(small: dict[str, FloatArray], points: dict[str, FloatArray], loss_factor: float) -> Coordinates:
    """M, C, K (r, r), and rows of points over their coordinates (r,), on their undamped modes, mass 1 each."""
    squares, shapes = _modes(small["M"].astype(np.longdouble), small["K"].astype(np.longdouble))
    damping = (shapes.T @ small["C"] @ shapes).astype(float)
    rows = {name: (row.astype(np.longdouble) @ shapes).astype(float) for name, row in points.items()}
    size = np.abs(damping).max(initial=0.0)
    free = (squares == 0.0) & (np.abs(damping).max(axis=1, initial=0.0) <= 1e-15 * size)
    damping[free], damping[:, free] = 0.0, 0.0  # rounding would hold what is free to the ground
    off = damping - np.diag(np.diag(damping))
    if np.abs(off).max(initial=0.0) <= 1e-13 * size:
        damping = np.diag(np.diag(damping))
    return Coordinates(np.ones(len(squares)), squares, damping, rows, loss_factor)


def _modes(mass: Any, stiffness: Any) -> tuple[FloatArray, Any]:
    """Squares of the natural frequencies, not negative, and mass-normalised shapes in long doubles.

    The first solution is in doubles; one step of first-order correction in long doubles gives the low
    modes the digits that the high ones cost them.
    """
    from scipy.linalg import eigh

    _, first = eigh(stiffness.astype(float), mass.astype(float))
    shapes = first.astype(np.longdouble)
    for _ in range(2):
        m, k = shapes.T @ mass @ shapes, shapes.T @ stiffness @ shapes
        squares = np.diag(k) / np.diag(m)
        gap = squares[None, :] - squares[:, None]
        near = np.abs(gap) <= 1e-6 * np.abs(squares).max() * 1e-6 + 1e-9 * np.abs(squares)[None, :]
        turn = np.where(near, -0.5 * m, (k - m * squares[None, :]) / np.where(near, 1.0, gap))
        np.fill_diagonal(turn, 0.5 * (1.0 - np.diag(m)))
        shapes = shapes + shapes @ turn
    k = shapes.T @ stiffness @ shapes
    m = shapes.T @ mass @ shapes
    squares = (np.diag(k) / np.diag(m)).astype(float)
    floor = 1e-15 * float(squares.max(initial=0.0))
    return np.where(squares < floor, 0.0, squares), shapes / np.sqrt(np.diag(m))


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
    """
    places = np.array(list(points.values()), dtype=np.intp)
    names = list(points)
    loads = matrices.units(places)
    basis = _Basis(matrices, places)
    if modes:
        frequencies, shapes = lowest_modes(matrices, modes)
        basis.add(shapes)
        top = max(top, _ABOVE * float(frequencies[-1]))
    grid = top * np.linspace(0.0, 1.0, _GRID + 1)[1:]
    used = _begin(matrices, basis, loads, top)
    now = basis.coordinates(names)
    value, before = now.receptances(grid), np.zeros((len(grid), len(places), len(places)), dtype=complex)
    while len(used) < _MOST:
        differ = _differ(value, before, grid, used)
        omega = float(grid[int(differ.argmax())])
        if differ.max() <= 0.1 * TARGET:
            break
        used.append(omega)
        basis.add(solve(matrices, loads, omega).motion)
        now, before = basis.coordinates(names), value
        value = now.receptances(grid)
    return _checked(matrices, basis, names, loads, top, used)


def whole_host(matrices: Matrices, points: dict[str, int]) -> Reduction:
    """The structure on all of its modes, for what holds every frequency; checked up to the highest of them.

    Parameters
    ----------
    matrices
        The structure.
    points
        Coordinate number per named point.
    """
    places, unit = np.array(list(points.values()), dtype=np.intp), np.eye(matrices.size)
    small = {"M": matrices.mass.toarray(), "C": matrices.damping.toarray(), "K": matrices.stiffness.toarray()}
    now = _on_modes(small, {name: unit[place] for name, place in points.items()}, matrices.loss_factor)
    top, loads = _ABOVE * float(np.sqrt(now.stiffness.max())), matrices.units(places)
    checks = _between([0.0, top], top, CHECKS)
    errors = [_error(now, omega, solve(matrices, loads, omega).motion[places].astype(complex)) for omega in checks]
    return Reduction(now, matrices.size, max(errors), len(checks), len(checks), top)


def lowest_modes(matrices: Matrices, count: int) -> tuple[FloatArray, FloatArray]:
    """Lowest undamped natural frequencies (k,) [rad/s] and shapes (n, k) of the structure alone."""
    from scipy.linalg import eigh
    from scipy.sparse.linalg import LinearOperator, eigsh

    size = matrices.size
    if count >= size - 1 or size <= 2 * _MOST:
        squares, shapes = eigh(matrices.stiffness.toarray(), matrices.mass.toarray())
        return np.sqrt(np.maximum(squares[:count], 0.0)), shapes[:, :count]
    shift = (1e-6 * matrices.fastest) ** 2
    lu = factored(matrices.dynamic(-shift, 0.0))
    inverse = LinearOperator(shape=(size, size), matvec=lu.solve, dtype=float)
    start = np.sqrt(matrices.mass.diagonal())
    squares, shapes = eigsh(matrices.stiffness, count, matrices.mass, sigma=-shift, OPinv=inverse, v0=start)
    order = np.argsort(squares)
    return np.sqrt(np.maximum(squares[order], 0.0)), shapes[:, order]


def _begin(matrices: Matrices, basis: _Basis, loads: FloatArray, top: float) -> list[float]:
    """Standstill (beside it where nothing holds the structure) and the top frequency."""
    try:
        still = solve(matrices, loads, 0.0)
        held = still.left < 1e-6
    except RuntimeError:
        held = False
    basis.add(still.motion if held else solve(matrices, loads, 0.0, shift=(0.03 * top) ** 2).motion)
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


def _checked(
    matrices: Matrices, basis: _Basis, names: list[str], loads: FloatArray, top: float, used: list[float]
) -> Reduction:
    """Measure the error at fresh frequencies between the used ones; one that misses is used too."""
    now = basis.coordinates(names)
    done, worst, solved = 0, 0.0, len(used)
    for omega in _between(used, top, CHECKS):
        true = solve(matrices, loads, omega).motion
        wanted = true[basis.places].astype(complex)
        error = _error(now, omega, wanted)
        done, solved = done + 1, solved + 1
        if error > TARGET and solved < 2 * _MOST:
            basis.add(true)
            now = basis.coordinates(names)
            error = _error(now, omega, wanted)
        worst = max(worst, error)
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
