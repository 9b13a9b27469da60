"""Ranges that a search can use: half-open ones get an end far beyond what any machine of the scene has."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vibopt.forms import Modulus
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
    fastest = (
        max(
            (
                band.high * max(line.order for line in drive.lines)
                for part in program.parts
                if isinstance(part.form, Modulus)
                for drive in part.form.drives
                for band in drive.bands
            ),
            default=0.0,
        )
        or 1e3
    )
    key = axis.path.rsplit(".", 1)[-1]
    springs, dampers = mass * fastest**2, mass * fastest
    scales = {"stiffness": springs, "damping": dampers, "mass": mass, "inertia": mass, "frequency": fastest}
    scales |= {"torsional_stiffness": springs, "torsional_damping": dampers}
    scale = scales.get(key, 1e-5)
    return FAR * scale
