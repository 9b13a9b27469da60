"""Newton on the active set: a good design made exact.

At fixed speeds every limit is smooth; the worst speeds are measured anew after each step.  Where
as many limits are active as there are variables the steps are those of Newton on equations.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from vibopt.forms import ComplexArray, Drive, FloatArray, Form, Modulus
from vibopt.mechanics.harmonic import transfer
from vibopt.mechanics.model import Model
from vibopt.mechanics.peaks import Extreme, peaks
from vibopt.program.program import Aim, Limit, Program
from vibopt.program.worst import (
    DriveResponse,
    closed_form,
    drive_extreme,
    monomial_count,
    plain_value,
    rigid_form,
    singularities,
)
from vibopt.solve.branch import Judge

_NEAR = 1e-2
_STEP = 1e-5


@dataclass(frozen=True, slots=True)
class Piece:
    """One smooth inequality g(y) <= 0 in y = log x: a limit at fixed speeds, or a side of the box.

    speeds
        Speed per excitation [rad/s].
    """

    part: Limit | Aim
    speeds: tuple[float, ...]


def polish(program: Program, x: FloatArray, *, rounds: int = 30) -> FloatArray:
    """A design no worse than `x` (n_vars,), exact to rounding where the active limits are regular.

    Discrete variables stay as they are.  Returns `x` itself where nothing better was found.
    """
    judge = Judge(program)
    free = np.array([axis.values is None for axis in program.axes]) & (x > 0.0)
    if program.aim is None or not free.any():
        return x
    best, best_value = _to_ends(program, judge, np.array(x, dtype=float))
    here = best.copy()
    for _ in range(rounds):
        step = _step(program, here, free)
        if step is None:
            break
        there = here.copy()
        there[free] = np.clip(here[free] * np.exp(step), program.low[free], program.high[free])
        moved = float(np.abs(there / here - 1.0).max())
        here = there
        value = judge.goal(here).value
        if judge.feasible(here) and value <= best_value + 1e-15 * abs(best_value):
            best, best_value = here.copy(), value
        if moved < 1e-14:
            break
    return best


def _to_ends(program: Program, judge: Judge, x: FloatArray) -> tuple[FloatArray, float]:
    """Each continuous variable moved to the better end of its range where the limits allow it."""
    value = judge.goal(x).value
    for i, axis in enumerate(program.axes):
        for end in (axis.low, axis.high):
            if axis.values is not None or end == x[i]:
                continue
            there = x.copy()
            there[i] = end
            other = judge.goal(there).value
            if other < value and judge.feasible(there):
                x, value = there, other
    return x, value


def _step(program: Program, x: FloatArray, free: FloatArray) -> FloatArray | None:
    """Newton step in log x for the free variables; None where there is no active set to follow."""
    goal, pieces = _pieces(program, x)
    if goal is None:
        return None
    n = int(free.sum())
    y = np.log(x[free])
    nodes = _stencil(n)
    points = np.repeat(x[None, :], len(nodes), axis=0)
    points[:, free] = np.exp(y + _STEP * nodes)
    values = np.array([_value(piece, points) for piece in (goal, *pieces)])
    if not np.isfinite(values).all():
        return None
    gradients, hessians = _derivatives(values, n)
    low, high = np.log(np.maximum(program.low[free], 1e-300)) - y, np.log(program.high[free]) - y
    return _kkt(values[:, 0], gradients, hessians, low, high)


def _pieces(program: Program, x: FloatArray) -> tuple[Piece | None, list[Piece]]:
    pieces = []
    for limit in program.limits:
        if limit.side == "outside":
            return None, []
        for speeds, value in local_extremes(limit.model, limit.form, x, least=limit.side == "at_least"):
            missed = (value - limit.bound) / (abs(limit.bound) or 1.0)
            if abs(missed) <= _NEAR:
                pieces.append(Piece(limit, speeds))
    aim = program.aim
    assert aim is not None
    tops = local_extremes(aim.model, aim.form, x, least=aim.sense < 0)
    if len(tops) != 1 and isinstance(aim.form, Modulus):
        best = (min if aim.sense < 0 else max)(value for _, value in tops)
        tops = [one for one in tops if abs(one[1] - best) <= 1e-6 * abs(best)][:1]
    return Piece(aim, tops[0][0]), pieces


def local_extremes(model: Model, form: Form, x: FloatArray, *, least: bool) -> list[tuple[tuple[float, ...], float]]:
    """Speeds per excitation and value of every local extreme that could be the worst."""
    if not isinstance(form, Modulus):
        return [((), plain_value(model, form, x))]
    per_drive = [_drive_extremes(model, form, drive, x, least) for drive in form.drives]
    found = per_drive[0] if len(per_drive) == 1 else []
    if len(per_drive) == 1:
        return [((one.speed,), one.value) for one in found]
    tops = [(min if least else max)(one, key=lambda e: e.value) for one in per_drive]
    values = np.array([one.value for one in tops])
    total = float(np.sqrt((values**2).sum())) if form.combine == "rss" else float(values.sum())
    return [(tuple(one.speed for one in tops), total)]


def _drive_extremes(model: Model, form: Modulus, drive: Drive, x: FloatArray, least: bool) -> list[Extreme]:
    closed = closed_form(model, form, drive, x)
    if closed is not None:
        found = [one for band in drive.bands for one in closed.candidates(band)]
    elif least:
        return [drive_extreme(model, form, drive, x, True)]
    else:
        singular, breaks = singularities(model, form, drive, x)
        found = peaks(DriveResponse(model, form, drive, x), drive.bands, singular, breaks, within=0.9)
    unique: list[Extreme] = []
    for one in found:
        if not any(abs(one.speed - other.speed) <= 1e-9 * abs(one.speed) for other in unique):
            unique.append(one)
    return unique


def _value(piece: Piece, points: FloatArray) -> FloatArray:
    """log(value / bound) of a limit, signed so that <= 0 is met; log of the goal, signed to be minimised.

    points
        Designs, shape (n_points, n_vars).
    """
    part = piece.part
    with np.errstate(all="ignore"):
        logs = np.log(_form_values(part.model, part.form, points, piece.speeds))
        if isinstance(part, Aim):
            return part.sense * logs
        value: FloatArray = logs - np.log(part.bound)
    return value if part.side == "at_most" else -value


def _form_values(model: Model, form: Form, points: FloatArray, speeds: tuple[float, ...]) -> FloatArray:
    if not isinstance(form, Modulus):
        return np.array([plain_value(model, form, point) for point in points])
    totals = [_at_speed(model, form, drive, points, speed) for drive, speed in zip(form.drives, speeds, strict=True)]
    squares = np.array(totals)
    return np.sqrt((squares**2).sum(axis=0)) if form.combine == "rss" else squares.sum(axis=0)


def _at_speed(model: Model, form: Modulus, drive: Drive, points: FloatArray, speed: float) -> FloatArray:
    if len(drive.lines) > 1 or form.rigid_link:
        return np.array([DriveResponse(model, form, drive, point)(np.array([speed]))[0] for point in points])
    line = drive.lines[0]
    p = model.values(points)
    h: ComplexArray = transfer(model, p, form.output, line.vector, np.full(len(points), line.order * speed))
    share = np.array([monomial_count(model, form, point) for point in points])
    return np.abs(h * line.amplitude.at(np.full(len(points), speed))) / share


def _stencil(n: int) -> FloatArray:
    """Centre, plus and minus each axis, and the four corners of each pair of axes."""
    rows = [np.zeros(n)]
    eye = np.eye(n)
    for i in range(n):
        rows += [eye[i], -eye[i]]
    for i, j in combinations(range(n), 2):
        rows += [eye[i] + eye[j], -eye[i] - eye[j], eye[i] - eye[j], eye[j] - eye[i]]
    return np.array(rows)


def _derivatives(values: FloatArray, n: int) -> tuple[FloatArray, FloatArray]:
    """Central differences: gradients (m, n) and hessians (m, n, n) from values on the stencil (m, n_nodes)."""
    count = len(values)
    gradients, hessians = np.zeros((count, n)), np.zeros((count, n, n))
    for i in range(n):
        plus, minus = values[:, 1 + 2 * i], values[:, 2 + 2 * i]
        gradients[:, i] = (plus - minus) / (2 * _STEP)
        hessians[:, i, i] = (plus - 2 * values[:, 0] + minus) / _STEP**2
    for index, (i, j) in enumerate(combinations(range(n), 2)):
        a, b, c, d = (values[:, 1 + 2 * n + 4 * index + k] for k in range(4))
        hessians[:, i, j] = hessians[:, j, i] = (a + b - c - d) / (4 * _STEP**2)
    return gradients, hessians


def _kkt(
    values: FloatArray, gradients: FloatArray, hessians: FloatArray, low: FloatArray, high: FloatArray
) -> FloatArray | None:
    """Step of the quadratic model with the active set whose multipliers fit best."""
    n = gradients.shape[1]
    eye = np.eye(n)
    rows = [(values[i], gradients[i], hessians[i]) for i in range(1, len(values))]
    flat = np.zeros((n, n))
    rows += [(-high[i], eye[i], flat) for i in range(n) if abs(high[i]) < _NEAR]
    rows += [(low[i], -eye[i], flat) for i in range(n) if abs(low[i]) < _NEAR]
    best: tuple[float, FloatArray] | None = None
    for size in range(min(n, len(rows)) + 1):
        for chosen in combinations(range(len(rows)), size):
            trial = _trial([rows[i] for i in chosen], gradients[0], hessians[0], n)
            if trial is None:
                continue
            residual, step = trial
            worst = max((value + slope @ step for value, slope, _ in rows), default=0.0)
            score = residual + 10.0 * max(worst, 0.0)
            if best is None or score < best[0] - 1e-12:
                best = (score, step)
    if best is None or best[0] > 1e-3:
        return None
    return np.clip(best[1], -0.5, 0.5)


def _trial(
    active: list[tuple[float, FloatArray, FloatArray]], slope: FloatArray, bend: FloatArray, n: int
) -> tuple[float, FloatArray] | None:
    """Misfit of stationarity with multipliers >= 0, and the step, for one active set."""
    size = len(active)
    if size == 0:
        if np.linalg.norm(slope) > 1e-4 or np.any(np.linalg.eigvalsh(bend) <= 0):
            return None
        return float(np.linalg.norm(slope)), np.linalg.solve(bend, -slope)
    jacobian = np.array([row[1] for row in active])
    multipliers = np.linalg.lstsq(jacobian.T, -slope, rcond=None)[0]
    if np.any(multipliers < -1e-9):
        return None
    residual = float(np.linalg.norm(jacobian.T @ multipliers + slope)) / max(float(np.linalg.norm(slope)), 1e-300)
    values = np.array([row[0] for row in active])
    if size == n:
        return residual, np.linalg.lstsq(jacobian, -values, rcond=1e-12)[0]
    lagrangian = bend + sum((m * row[2] for m, row in zip(multipliers, active, strict=True)), np.zeros((n, n)))
    matrix = np.block([[lagrangian, jacobian.T], [jacobian, np.zeros((size, size))]])
    solved = np.linalg.lstsq(matrix, np.concatenate([-slope, -values]), rcond=1e-12)[0]
    return min(residual, 1e-4) if residual < 0.05 else residual, solved[:n]
