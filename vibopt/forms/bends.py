"""Slope and second derivative of a response at one speed, in log x and in the speed, in closed form.

With u = D^-1 f and the row r, h = r . u changes with the dynamic stiffness z_t of a term by (signs_t - l_t) a_t,
where a_t = b_t . u and l_t = b_t . D^-1 r, and those change by D^-1 of what moves: two solutions give all of it.
A local extreme moves with the design; its own motion is eliminated from the second derivative.
"""

from __future__ import annotations

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.mechanics.harmonic import assembled
from vibopt.mechanics.model import DAMPING, INERTIA, Model, factors
from vibopt.records import dataclass
from vibopt.signals import Amplitude, Combine, Drive, Line, Output

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


def curved(model: Model, output: Output, drive: Drive, x: FloatArray, speed: float, combine: Combine) -> Curved | None:
    """The response to one excitation at a design x (n_vars,), all positive; None where it has no second derivative.

    The lines of a drive are added as sums or as roots of sums of squares.
    """
    if speed <= 0.0 or (combine == "peak" and len(drive.lines) > 1):
        return None
    try:
        lines = [_line(model, output, line, x, speed) for line in drive.lines]
    except np.linalg.LinAlgError:
        return None
    lines = [line for line in lines if np.isfinite(line.log)]
    if not lines or not all(np.isfinite(line.bend).all() for line in lines):
        return None
    return added(lines, 2.0 if combine == "rss" else 1.0)


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


def _line(model: Model, output: Output, line: Line, x: FloatArray, speed: float) -> Curved:
    """One harmonic."""
    n, kinds, vectors, omega = model.n_free, model.kinds, model.vectors, line.order * speed
    p = model.values(x)
    phi = factors(kinds, np.array(omega))
    z = p * phi
    both = assembled(model, p, np.array(omega))
    load = line.vector[:n] - both[:, n:] @ line.vector[n:]
    row = output.row + (output.signs * z) @ vectors
    size = np.sqrt(np.abs(np.diagonal(both)))
    size = np.where(size == 0.0, 1.0, size)
    scaled = both[:, :n] / np.outer(size, size)
    solved = np.linalg.solve(scaled, np.column_stack([load, row[:n]]) / size[:, None]) / size[:, None]
    u = np.concatenate([solved[:, 0], line.vector[n:]])
    h = complex(row @ u)
    seen, taken = vectors @ u, output.signs - vectors[:, :n] @ solved[:, 1]
    first = taken * seen
    moves, twice = _terms(model, p, phi, omega, line.order)
    pushed, pulled = (vectors[:, :n].T @ (one[:, None] * moves) / size[:, None] for one in (seen, taken))
    second = -pushed.T @ np.linalg.solve(scaled, pulled)
    exponents = np.column_stack([model.exponents, np.zeros(len(p))])
    slope = first @ moves
    bend = second + second.T + (exponents.T * (first * z)) @ exponents
    mixed = (first * moves[:, -1]) @ model.exponents
    bend[-1, :-1] += mixed
    bend[:-1, -1] += mixed
    bend[-1, -1] += first @ twice
    with np.errstate(divide="ignore", invalid="ignore"):
        slope, bend = slope / h, bend / h
        bend = bend - np.outer(slope, slope)
        log, rise, curve = _amplitude(line.amplitude, speed)
        found = Curved(float(np.log(abs(h))) + log + output.power * float(np.log(omega)), slope.real, bend.real)
    found.slope[-1] += rise + output.power / speed
    found.bend[-1, -1] += curve - output.power / speed**2
    return found


def _terms(
    model: Model, p: FloatArray, phi: ComplexArray, omega: float, order: float
) -> tuple[ComplexArray, ComplexArray]:
    """Slopes of every z_t in log x and the speed, (n_terms, n_vars + 1), and second derivatives in the speed."""
    heavy, damping = model.kinds == INERTIA, model.kinds == DAMPING
    along = np.where(heavy, -2.0 * omega * order, np.where(damping, 1j * order, 0.0))
    moves = np.column_stack([(p * phi)[:, None] * model.exponents, p * along])
    return np.asarray(moves, dtype=complex), np.asarray(np.where(heavy, -2.0 * order**2, 0.0) * p, dtype=complex)


def _amplitude(amplitude: Amplitude, speed: float) -> tuple[float, float, float]:
    """Log of an amplitude at a speed, with its first and second derivative."""
    piece = next((one for one in amplitude.pieces if speed <= one.band.high), amplitude.pieces[-1])
    part = piece.constant + piece.slope * speed
    with np.errstate(divide="ignore", invalid="ignore"):
        log = float(np.log(np.abs(part))) + piece.power * float(np.log(speed))
        share = piece.slope / np.float64(part)
    return log, float(share) + piece.power / speed, -(float(share) ** 2) - piece.power / speed**2
