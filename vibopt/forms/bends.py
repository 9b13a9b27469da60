"""Slope and second derivative of a response at given speeds, in log x and in the speed, in closed form.

With u = D^-1 f and the row r, h = r . u changes with the dynamic stiffness z_t of a term by (signs_t - l_t) a_t,
where a_t = b_t . u and l_t = b_t . D^-1 r, and those change by D^-1 of what moves: two solutions give all of it.
A local extreme moves with the design; its own motion is eliminated from the second derivative.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.mechanics.harmonic import assembled
from vibopt.mechanics.model import DAMPING, INERTIA, Model, factors
from vibopt.records import dataclass
from vibopt.signals import Combine, Drive, Line, Output, Piece

_FLAT = 1e-8
"""Part that a value could still gain at the extreme beside a speed from which on that speed is no extreme."""


@dataclass(frozen=True, slots=True)
class Curved:
    """Log of a response at one speed w: slope (n_vars + 1,) and bend (n_vars + 1, n_vars + 1) in log x and, last, w."""

    log: float
    slope: FloatArray
    bend: FloatArray

    def at_extreme(self, sign: float) -> tuple[FloatArray, FloatArray | None]:
        """Slope and bend in log x alone of a greatest (`sign` 1) or least (-1) value, which moves to stay one.

        Where it does not move, at the end of a band, the speed is held.  The bend is None where it is too flat to tell.
        """
        slope, bend, rise, curve = self.slope[:-1], self.bend[:-1, :-1], self.slope[-1], self.bend[-1, -1]
        if rise * rise > _FLAT * abs(curve):  # an end of the band
            return slope, bend
        if not sign * curve < 0.0:
            return slope, None
        return slope, bend - np.outer(self.bend[:-1, -1], self.bend[:-1, -1]) / curve


def curved(
    model: Model, output: Output, drive: Drive, x: FloatArray, speeds: FloatArray, combine: Combine
) -> list[Curved | None]:
    """The response to one excitation at a design x (n_vars,), at each of `speeds` (n,), all positive.

    None where it has no second derivative.  The lines of a drive are added as sums or as roots of sums of squares.
    """
    if combine == "peak" and len(drive.lines) > 1:
        return [None] * len(speeds)
    try:
        each = zip(*(_line(model, output, line, x, speeds) for line in drive.lines), strict=True)
    except np.linalg.LinAlgError:  # at one of them
        alone = [speeds[i : i + 1] for i in range(len(speeds))] if len(speeds) > 1 else []
        return [curved(model, output, drive, x, one, combine)[0] for one in alone] or [None]
    return [_together(lines, combine) for lines in each]


def _together(lines: Sequence[Curved], combine: Combine) -> Curved | None:
    real = [line for line in lines if np.isfinite(line.log)]
    if not real or not all(np.isfinite(line.bend).all() for line in real):
        return None
    return added(real, 2.0 if combine == "rss" else 1.0)


def added(parts: list[Curved], power: float) -> Curved:
    """Log of (sum of value^power)^(1 / power) from the logs of the values."""
    if len(parts) == 1:
        return parts[0]
    top = max(part.log for part in parts)
    weight = np.array([np.exp(power * (part.log - top)) for part in parts])
    log = top + float(np.log(weight.sum())) / power
    weight = weight / weight.sum()
    slope: FloatArray = sum((w * part.slope for w, part in zip(weight, parts, strict=True)), 0.0 * parts[0].slope)
    bend = -power * np.outer(slope, slope)
    for w, part in zip(weight, parts, strict=True):
        bend = bend + w * (part.bend + power * np.outer(part.slope, part.slope))
    return Curved(log, slope, bend)


def _line(model: Model, output: Output, line: Line, x: FloatArray, speeds: FloatArray) -> list[Curved]:
    """One harmonic at each of `speeds` (n,)."""
    n, kinds, vectors, omega = model.n_free, model.kinds, model.vectors, line.order * speeds
    p = model.values(x)
    phi = factors(kinds, omega)
    z = p * phi
    both = assembled(model, p, omega)
    load = line.vector[:n] - both[..., n:] @ line.vector[n:]
    row = output.row + (output.signs * z) @ vectors
    size = np.sqrt(np.abs(np.diagonal(both, axis1=-2, axis2=-1)))[..., None]
    size = np.where(size == 0.0, 1.0, size)
    scaled = both[..., :n] / (size * size.swapaxes(-1, -2))
    solved = np.linalg.solve(scaled, np.stack([load, row[:, :n]], axis=-1) / size) / size
    u = np.concatenate([solved[..., 0], np.broadcast_to(line.vector[n:], (len(speeds), len(line.vector) - n))], axis=-1)
    h = (row * u).sum(axis=-1)[:, None]
    seen, taken = u @ vectors.T, output.signs - solved[..., 1] @ vectors[:, :n].T
    first = taken * seen
    moves, twice = _terms(model, p, phi, omega, line.order)
    pushed, pulled = (vectors[:, :n].T @ (one[..., None] * moves) / size for one in (seen, taken))
    second = -pushed.swapaxes(-1, -2) @ np.linalg.solve(scaled, pulled)
    exponents = np.column_stack([model.exponents, np.zeros(len(p))])
    slope = (first[:, None] @ moves)[:, 0]
    bend = second + second.swapaxes(-1, -2) + (exponents.T * (first * z)[:, None]) @ exponents
    mixed = (first * moves[..., -1]) @ model.exponents
    bend[:, -1, :-1] += mixed
    bend[:, :-1, -1] += mixed
    bend[:, -1, -1] += first @ twice
    with np.errstate(divide="ignore", invalid="ignore"):
        slope, bend = slope / h, bend / h[..., None]
        bend = (bend - slope[:, :, None] * slope[:, None]).real
        log, rise, curve = line.amplitude.by_piece(speeds, _amplitude).T
        log = log + np.log(np.abs(h[:, 0])) + output.power * np.log(omega)
    slope = slope.real
    slope[:, -1] += rise + output.power / speeds
    bend[:, -1, -1] += curve - output.power / speeds**2
    return [Curved(float(log[i]), slope[i], bend[i]) for i in range(len(speeds))]


def _terms(
    model: Model, p: FloatArray, phi: ComplexArray, omega: FloatArray, order: float
) -> tuple[ComplexArray, ComplexArray]:
    """Slopes of every z_t in log x and the speed, (n, n_terms, n_vars + 1), and second derivatives in the speed."""
    heavy, damping = model.kinds == INERTIA, model.kinds == DAMPING
    along = np.where(heavy, -2.0 * order * omega[:, None], np.where(damping, 1j * order, 0.0))
    moves = np.concatenate([(p * phi)[..., None] * model.exponents, (p * along)[..., None]], axis=-1)
    return np.asarray(moves, dtype=complex), np.asarray(np.where(heavy, -2.0 * order**2, 0.0) * p, dtype=complex)


def _amplitude(piece: Piece, speed: FloatArray) -> FloatArray:
    """Log of an amplitude at speeds (n,), with its first and second derivative, shape (n, 3)."""
    part = piece.constant + piece.slope * speed
    share = piece.slope / part
    rise, curve = share + piece.power / speed, -(share**2) - piece.power / speed**2
    return np.column_stack([np.log(np.abs(part)) + piece.power * np.log(speed), rise, curve])
