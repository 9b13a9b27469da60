"""The plane of two design variables: where each limit holds, and what the goal is.

For pictures only: speeds are sampled, closely around every resonance of every design; no answer is read off it.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

import numpy as np

from vibopt.design.design import Design
from vibopt.forms import Drive, FloatArray, Form, Modulus, Monomials
from vibopt.mechanics.combine import combined
from vibopt.mechanics.harmonic import transfer
from vibopt.mechanics.model import INERTIA, STIFFNESS, Model
from vibopt.program.pose import pose
from vibopt.program.program import Aim, Limit
from vibopt.program.worst import monomials, worst
from vibopt.scene.scene import Variable
from vibopt.units import best_unit, to_unit

SIDE, SMALL_SIDE = 61, 21
SPEEDS = 70
_NEAR = np.concatenate([[0.0], np.geomspace(1e-3, 0.6, 13)])


@dataclass(frozen=True, slots=True)
class PlaneAxis:
    """One variable: label with unit, values in that unit, and whether the axis is logarithmic."""

    label: str
    values: FloatArray
    log: bool


@dataclass(frozen=True, slots=True)
class Boundary:
    """A limit over the plane: `excess` (n_y, n_x) is positive where the limit is broken."""

    name: str
    excess: FloatArray


@dataclass(frozen=True, slots=True)
class Plane:
    """What the design map shows; `goal` (n_y, n_x) in `goal_label`'s unit, `best` in the axes' units."""

    title: str
    x: PlaneAxis
    y: PlaneAxis
    boundaries: tuple[Boundary, ...]
    goal: FloatArray | None
    goal_label: str
    best: tuple[float, float] | None
    best_words: str


def plane(design: Design) -> Plane | None:
    """The map of an answer with exactly two continuous variables; None for any other."""
    variables = design.scene.variables
    if len(variables) != 2 or any(one.values is not None for one in variables):
        return None
    program = pose(design.scene)
    slow = any(isinstance(one.form, Modulus) and one.form.rigid_link for one in program.limits)
    best = design.x if len(design.x) == 2 else None
    axes = [_values(one, best[i] if best else None, SMALL_SIDE if slow else SIDE) for i, one in enumerate(variables)]
    grid = np.stack(np.meshgrid(axes[0][0], axes[1][0]), axis=-1)
    flat = grid.reshape(-1, 2)
    shape = grid.shape[:2]
    units = [_unit(one, values) for one, (values, _) in zip(variables, axes, strict=True)]
    shown = [
        PlaneAxis(f"{one.path} [{unit}]" if unit else one.path, _scaled(values, unit, one), log)
        for one, unit, (values, log) in zip(variables, units, axes, strict=True)
    ]
    goal, label = _goal(design, program.aim, flat, shape)
    return Plane(
        title="Where every limit holds",
        x=shown[0],
        y=shown[1],
        boundaries=tuple(Boundary(one.name, _excess(one, flat).reshape(shape)) for one in program.limits),
        goal=goal,
        goal_label=label,
        best=(
            (_one(best[0], units[0], variables[0]), _one(best[1], units[1], variables[1])) if best is not None else None
        ),
        best_words="\n".join(f"{path.split('.', 1)[-1]} {one.value.shown}" for path, one in design.variables.items()),
    )


def _values(variable: Variable, best: float | None, side: int) -> tuple[FloatArray, bool]:
    """Values along one axis [SI]: around the best if there is one, else the whole range."""
    low, high = variable.low, variable.high
    if not isfinite(high):
        high = 1e3 * max(best or 0.0, low, 1e-3)
    if high <= 12.0 * low or (low == 0.0 and best is None):
        return np.linspace(low, high, side), False
    if best is None or best <= 0.0:
        return np.geomspace(max(low, 1e-6 * high), high, side), True
    return np.geomspace(max(low, best / 10.0), min(high, 10.0 * best), side), True


def _unit(variable: Variable, values: FloatArray) -> str:
    """The unit of the middle value: round numbers stand on the axis."""
    unit = best_unit(float(values[len(values) // 2]), variable.dimension)
    return unit if variable.unit in ("", unit) or _metric(variable.unit) else variable.unit


def _metric(unit: str) -> bool:
    return not any(word in unit for word in ("lb", "in", "ft", "oz", "mil", "kgf"))


def _one(value: float, unit: str, variable: Variable) -> float:
    return to_unit(value, unit, variable.dimension)


def _scaled(values: FloatArray, unit: str, variable: Variable) -> FloatArray:
    return values * to_unit(1.0, unit, variable.dimension)


def _goal(design: Design, aim: Aim | None, x: FloatArray, shape: tuple[int, ...]) -> tuple[FloatArray | None, str]:
    """The goal over the plane, unless it is one of the axes."""
    if aim is None or design.scene.goal is None:
        return None, ""
    response = design.scene.goal.response
    if isinstance(aim.form, Monomials) and np.count_nonzero(aim.form.exponents) == 1:
        return None, ""
    values = _over(aim.model, aim.form, x, False)
    values = 1.0 - values if aim.complement else values
    unit = response.unit or best_unit(float(np.median(values[np.isfinite(values)])), response.dimension)
    label = f"{design.scene.goal.sense} {response.response.replace('_', ' ')}{f' [{unit}]' if unit else ''}"
    if unit == "dB":
        return None, ""
    return (values * to_unit(1.0, unit, response.dimension)).reshape(shape), label


def _excess(limit: Limit, x: FloatArray) -> FloatArray:
    """Positive where a limit is broken, logarithmic so that contours are straight lines of a power law."""
    values = _over(limit.model, limit.form, x, limit.side == "at_least")
    with np.errstate(divide="ignore"):
        size = np.clip(np.log(np.maximum(values, 1e-300) / max(limit.bound, 1e-300)), -50.0, 50.0)
        if limit.side == "at_most":
            return np.asarray(size, dtype=float)
        if limit.side == "at_least":
            return np.asarray(-size, dtype=float)
        upper: FloatArray = np.log(limit.upper / np.maximum(values, 1e-300))
    return np.asarray(np.minimum(size, upper), dtype=float)


def _over(model: Model, form: Form, x: FloatArray, least_wanted: bool) -> FloatArray:
    """Worst value of a form at designs x (n, 2), shape (n,)."""
    if isinstance(form, Monomials):
        return monomials(form, x)
    if not isinstance(form, Modulus) or form.rigid_link:
        return np.array([worst(model, form, one, least_wanted=least_wanted).value for one in x])
    parts = np.array([_drive(model, form, drive, x, least_wanted) for drive in form.drives])
    total: FloatArray = np.sqrt((parts**2).sum(axis=0)) if form.combine == "rss" else parts.sum(axis=0)
    return total


def _drive(model: Model, form: Modulus, drive: Drive, x: FloatArray, least_wanted: bool) -> FloatArray:
    """Worst over sampled speeds of the response to one excitation, shape (n,)."""
    p = model.values(x)
    speeds = _speeds(model, drive, p)
    orders = tuple(line.order for line in drive.lines)
    share = _share(model, form, x)[:, None]
    with np.errstate(all="ignore"):
        lines = [
            transfer(model, p[:, None, :], form.output, line.vector, line.order * speeds) * line.amplitude.at(speeds)
            for line in drive.lines
        ]
        values = combined([one / share for one in lines], orders, form.combine)
    found: FloatArray = values.min(axis=1) if least_wanted else values.max(axis=1)
    return found


def _share(model: Model, form: Modulus, x: FloatArray) -> FloatArray:
    """Number of mounts that share the value, shape (n,)."""
    if not form.output.shared_by:
        return np.ones(len(x))
    count = model.counts[form.output.shared_by]
    row = count.row(model.n_vars)
    share: FloatArray = count.scale * np.where(row == 0.0, 1.0, x**row).prod(axis=1)
    return share


def _speeds(model: Model, drive: Drive, p: FloatArray) -> FloatArray:
    """Speeds to look at, shape (n, n_speeds): evenly in each band, and around every resonance within."""
    even = [np.array([band.low]) if band.is_point else np.linspace(band.low, band.high, SPEEDS) for band in drive.bands]
    everywhere = np.broadcast_to(np.concatenate(even), (len(p), sum(map(len, even))))
    wide = [band for band in drive.bands if not band.is_point]
    if not wide:
        return everywhere
    orders = np.array([line.order for line in drive.lines])
    modes = (_modes(model, p)[:, :, None] / orders).reshape(len(p), -1)
    around = (modes[:, :, None] * np.concatenate([1.0 - _NEAR, 1.0 + _NEAR])).reshape(len(p), -1)
    inside = [np.clip(around, band.low, band.high) for band in wide]
    return np.concatenate([everywhere, *inside], axis=1)


def _modes(model: Model, p: FloatArray) -> FloatArray:
    """Undamped natural frequencies of many designs [rad/s], shape (n, n_free)."""
    n = model.n_free
    mass, stiffness = (_matrices(model, p, kind) for kind in (INERTIA, STIFFNESS))
    squares: FloatArray
    if n == 1:
        squares = stiffness[:, :, 0] / mass[:, :, 0]
    else:
        root = np.linalg.inv(np.linalg.cholesky(mass))
        squares = np.asarray(np.linalg.eigvalsh(root @ stiffness @ np.swapaxes(root, 1, 2)), dtype=float)
    modes: FloatArray = np.sqrt(np.maximum(squares, 0.0))
    return modes


def _matrices(model: Model, p: FloatArray, kind: int) -> FloatArray:
    """Matrix of one kind for many designs, shape (n, n_free, n_free)."""
    chosen = model.kinds == kind
    vectors = model.vectors[chosen, : model.n_free]
    matrices: FloatArray = np.einsum("kt,ti,tj->kij", p[:, chosen], vectors, vectors)
    return matrices
