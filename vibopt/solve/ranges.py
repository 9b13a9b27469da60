"""Ranges that a search can use, with far ends for open ones, and points spread over them to start from."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.mechanics.constants import GRAVITY
from vibopt.mechanics.model import INERTIA
from vibopt.program.program import Axis, Program

FAR = 1e9
"""How many times the scene's own scale a half-open range reaches."""


def closed(program: Program) -> Program:
    """The program with finite ranges; an end that was open is marked on its axis."""
    opened = tuple(i for i, axis in enumerate(program.axes) if not np.isfinite(axis.high) and axis.values is None)
    if not opened:
        return program
    axes = list(program.axes)
    for i in opened:
        axes[i] = replace(axes[i], high=max(far_end(program, axes[i]), 1e3 * axes[i].low), open_high=True)
    return replace(program, axes=tuple(axes))


def far_end(program: Program, axis: Axis) -> float:
    """A value far above the scene's own scale, in the unit of the variable [SI]."""
    fixed = ~program.model.exponents.any(axis=1)
    masses = program.model.scales[fixed & (program.model.kinds == INERTIA)]
    mass = float(masses.sum()) or 1.0
    fastest = max(
        (
            band.high * max(line.order for line in drive.lines)
            for part in program.parts
            for drive in part.form.shaken
            for band in drive.bands
        ),
        default=0.0,
    )
    longest = _longest_load(program)
    fastest = fastest or (_TURNED / np.sqrt(FAR) / longest if longest else 1e3)
    speed, springs, dampers = FAR * fastest, FAR * mass * fastest**2, FAR * mass * fastest
    if longest:
        speed, springs = min(speed, _TURNED / longest), min(springs, mass * (_TURNED / longest) ** 2)
        dampers = min(dampers, mass * _FADED / longest)
    ends = {"stiffness": springs, "damping": dampers, "mass": FAR * mass, "inertia": FAR * mass}
    ends |= {"frequency": speed, "torsional_stiffness": springs, "torsional_damping": dampers}
    key = axis.path.rsplit(".", 1)[-1]
    return ends.get(key, FAR * 1e-5)


def _longest_load(program: Program) -> float:
    """Of what comes once [s]; 0 without."""
    forms = [part.form.in_time for part in program.parts]
    return max((sum(segment.length for segment in form.segments) for form in forms if form is not None), default=0.0)


_TURNED, _FADED = 6e4, 2e4
"""Radians that a machine may turn in a load, and times that it may fade by e, at the far end of an open range."""
FLOOR = 1e-9
"""Least value of a variable whose range begins at zero, as a part of its natural size or of its upper end."""
_DECADES, _NARROW = 1e6, 30.0
_PRIMES = tuple(n for n in range(2, 128) if all(n % part for part in range(2, n)))
_BESIDE = 0.02


def on_ends(program: Program, y: FloatArray) -> FloatArray:
    """The design whose logs are y, exactly on the ends of its ranges where it is next to them."""
    x = np.exp(y)
    for i, axis in enumerate(program.axes):
        near = [end for end in (axis.low, axis.high) if abs(x[i] - end) <= 1e-9 * abs(end)]
        x[i] = near[-1] if near else min(max(x[i], axis.low), axis.high)
    return x


def on_values(program: Program, x: FloatArray) -> FloatArray:
    """Discrete coordinates of designs (..., n_vars) moved to the nearest value there is."""
    moved = np.array(x, dtype=float)
    for i, axis in enumerate(program.axes):
        if axis.values is not None:
            values = np.array(axis.values)
            moved[..., i] = values[np.abs(values - moved[..., i, None]).argmin(axis=-1)]
    return moved


def log_box(program: Program) -> tuple[FloatArray, FloatArray]:
    """Logs of the least and greatest value of each variable, each (n_vars,), finite.

    A range that begins at zero or has no end is cut far off its natural size.
    """
    pairs = [_ends(axis, natural_size(program, axis)) for axis in program.axes]
    ends = np.log(np.maximum(np.array(pairs), 1e-300)).reshape(-1, 2)  # a list of nothing but zero is a point
    return ends[:, 0], ends[:, 1]


def starts(program: Program, count: int) -> FloatArray:
    """Points of a low-discrepancy sequence over the log box, the middle first, shape (count, n_vars).

    Half of them lie within three decades of the natural size of each variable, of a friction closer to it.
    """
    low, high = log_box(program)
    size = np.log([natural_size(program, axis) for axis in program.axes]).reshape(-1)
    reach = 0.5 * np.log([_NARROW if axis.path.endswith(".friction_force") else _DECADES for axis in program.axes])
    near_low = np.clip(size - reach, low, high)
    near_high = np.clip(size + reach, low, high)
    narrow = near_high > near_low
    near_low, near_high = np.where(narrow, near_low, low), np.where(narrow, near_high, high)
    points = halton(count, len(low))
    found = low + (high - low) * points
    found[::2] = near_low + (near_high - near_low) * points[::2]
    return found


def corners(low: FloatArray, high: FloatArray) -> FloatArray:
    """Points next to the corners of a box, shape (count, n_vars): all of them, or two beyond two free variables."""
    free = np.flatnonzero(high > low)
    signs = np.array(list(product((0.0, 1.0), repeat=len(free)))) if len(free) <= 2 else np.array([[0.0], [1.0]])
    parts = np.full((len(signs), len(low)), 0.5)
    parts[:, free] = _BESIDE + (1.0 - 2.0 * _BESIDE) * signs
    found: FloatArray = low + (high - low) * parts
    return found


def halton(count: int, dimensions: int) -> FloatArray:
    """Halton sequence from 1/2 on, shape (count, dimensions)."""
    table = np.zeros((count, dimensions))
    for column in range(dimensions):
        base = _PRIMES[column % len(_PRIMES)]
        index, part = np.arange(1, count + 1), 1.0
        while index.any():
            part /= base
            table[:, column] += part * (index % base)
            index //= base
    return table


def natural_size(program: Program, axis: Axis) -> float:
    """Size at which a variable begins to matter: m w^2 for a stiffness, m w for a damping, 1 for a ratio [SI]."""
    steps = axis.path.split(".")
    word = steps[-2] if steps[-1] in ("x", "y", "z") else steps[-1]
    mass, speed = _typical_mass(program), _typical_speed(program)
    sizes = {"stiffness": mass * speed**2, "damping": mass * speed, "mass": mass, "inertance": mass}
    sizes |= {"friction_force": max((part.form.push(mass, speed) for part in program.parts), default=1.0)}
    sizes |= {f"torsional_{word}": size for word, size in sizes.items()} | {"inertia": mass}
    sizes |= {"damping_ratio": 0.1, "loss_factor": 0.1, "mass_ratio": 0.1, "tuning": 1.0, "frequency": speed}
    sizes |= {"length": GRAVITY / speed**2} if axis.path.count(".") == 2 else {"length": 1.0, "diameter": 0.1}
    return sizes.get(word, 1.0)


def _typical_mass(program: Program) -> float:
    model = program.model
    fixed = (model.kinds == INERTIA) & ~model.exponents.any(axis=1)
    masses = model.scales[fixed & (model.scales > 0.0)]
    return float(np.exp(np.log(masses).mean())) if len(masses) else 1.0


def _typical_speed(program: Program) -> float:
    forms = [limit.form for limit in program.limits] + ([program.aim.form] if program.aim else [])
    ends = [
        line.order * band.high
        for form in forms
        for drive in form.shaken
        for line in drive.lines
        for band in drive.bands
        if 0.0 < band.high < np.inf
    ]
    return float(np.exp(np.log(ends).mean())) if ends else 100.0


def _ends(axis: Axis, size: float) -> tuple[float, float]:
    low, high = axis.low, axis.high
    if not np.isfinite(high):
        high = max(size, low) / FLOOR
    if low <= 0.0:
        low = min(high, size) * FLOOR
    return low, high
