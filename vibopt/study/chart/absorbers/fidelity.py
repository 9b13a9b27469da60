"""Rods of up to a hundred thousand freedoms with an absorber: what the small model costs, saves and misses."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from vibopt.forms import ComplexArray, FloatArray
from vibopt.program.pose import pose
from vibopt.scene.scene import Scene
from vibopt.solve.box import closed
from vibopt.solve.branch import Judge
from vibopt.solve.choose import choose
from vibopt.study.chart.asking import Progress
from vibopt.study.chart.fidelity import Fidelity

_SIZES, _QUICK_SIZES = (100, 1_000, 10_000, 100_000), (100, 1_000)
_SPEEDS = 200
_LENGTH, _LINE_MASS, _AXIAL = 10.0, 100.0, 1e8
"""Rod: length [m], mass per length [kg/m], modulus times area [N]."""
_LOSS = 0.02
_FIRST = 0.5 * np.pi * float(np.sqrt(_AXIAL / _LINE_MASS)) / _LENGTH
_LOW, _TOP = 0.2 * _FIRST, 2.4 * _FIRST
_MASS, _FORCE = 30.0, 1e3


def fidelity(*, quick: bool = False, progress: Progress | None = None) -> tuple[Fidelity, ...]:
    """One row a size; the full model is the rod and its absorber in one sparse matrix, at 200 speeds."""
    rows = []
    for number, size in enumerate(_QUICK_SIZES if quick else _SIZES):
        if progress:
            progress(f"rod of {size} freedoms", number / len(_SIZES))
        rows.append(_row(size))
    return tuple(rows)


def rod(count: int) -> tuple[Any, Any]:
    """Consistent mass and stiffness of a rod that is held at one end, `count` freedoms, sparse."""
    from scipy import sparse

    piece = _LENGTH / count
    own, beside = np.ones(count), np.ones(count - 1)
    own[-1] = 0.5
    band = sparse.diags(2.0 * own), sparse.diags(beside, -1) + sparse.diags(beside, 1)
    mass = band[0].multiply(_LINE_MASS * piece / 3.0) + band[1].multiply(_LINE_MASS * piece / 6.0)
    stiff = band[0].multiply(_AXIAL / piece) - band[1].multiply(_AXIAL / piece)
    return sparse.csc_array(mass), sparse.csc_array(stiff)


def _scene(folder: Path, count: int, mass: Any, stiffness: Any) -> Scene:
    from scipy import sparse

    from vibopt.scene.read import read

    sparse.save_npz(folder / "mass.npz", mass)
    sparse.save_npz(folder / "stiffness.npz", stiffness)
    text = f"""title = "Rod of {count} freedoms"
[structures.rod]
mass = "mass.npz"
stiffness = "stiffness.npz"
loss_factor = {_LOSS}
points = {{ end = {count - 1} }}
[absorbers.tmd]
on = "end"
mass = "{_MASS} kg"
frequency = {{ from = "{0.3 * _FIRST!r} rad/s", to = "{2.0 * _FIRST!r} rad/s" }}
damping_ratio = {{ from = 0.005, to = 1.0 }}
[excitations.shake]
kind = "force"
on = "end"
amplitude = "{_FORCE} N"
speed = "{_LOW!r}..{_TOP!r} rad/s"
varies = "constant"
[goal]
minimise = "displacement"
of = "end"
"""
    target = folder / f"rod of {count} freedoms.toml"
    target.write_text(text, encoding="utf-8")
    return read(target)


def _row(count: int) -> Fidelity:
    mass, stiffness = rod(count)
    with tempfile.TemporaryDirectory() as folder:
        scene = _scene(Path(folder), count, mass, stiffness)
        begin = time.perf_counter()
        program = closed(pose(scene))
        found = choose(program, None).solve(program)
        solving = time.perf_counter() - begin
    assert found.x is not None
    judge, speeds = Judge(program), np.linspace(_LOW, _TOP, _SPEEDS)
    measuring = median(_seconds(judge, found.x) for _ in range(5))
    begin = time.perf_counter()
    full = _full(mass, stiffness, found.x, speeds)
    measuring_full = time.perf_counter() - begin
    small = _small(program, found.x, speeds)
    worst = judge.goal(found.x)
    there = np.array(list(worst.speeds.values()))
    exact = float(np.abs(_full(mass, stiffness, found.x, there))[0])
    return Fidelity(
        case=f"rod of {count} freedoms",
        declared=count + 1,
        used=program.used_dof,
        why="the rest does not show at the points; the error is mostly rounding of the full solution",
        measuring=measuring,
        measuring_full=measuring_full,
        solving=solving,
        solving_full=float("nan"),
        value_error=float((np.abs(small - np.abs(full)) / np.abs(full)).max()),
        goal_error=abs(worst.value - exact) / exact,
    )


def _seconds(judge: Judge, x: FloatArray) -> float:
    begin = time.perf_counter()
    judge.goal(x)
    return time.perf_counter() - begin


def _small(program: Any, x: FloatArray, speeds: FloatArray) -> FloatArray:
    from vibopt.program.worst import DriveResponse

    form = program.aim.form
    return DriveResponse(program.aim.model, form, form.drives[0], x)(speeds)


def _full(mass: Any, stiffness: Any, x: FloatArray, speeds: FloatArray) -> ComplexArray:
    """Motion of the end [m] with the absorber x (frequency [rad/s], damping ratio), factored at every speed."""
    from scipy import sparse
    from scipy.sparse.linalg import splu

    count = mass.shape[0]
    found = np.empty(len(speeds), dtype=complex)
    load = np.zeros(count, dtype=complex)
    load[-1] = _FORCE
    for i, w in enumerate(speeds.tolist()):
        spring = _MASS * x[0] ** 2 + 2j * w * x[1] * _MASS * x[0]
        extra = sparse.coo_array(
            ([-(w**2) * _MASS * spring / (spring - w**2 * _MASS)], ([count - 1], [count - 1])), shape=mass.shape
        )
        dynamic = sparse.csc_array(stiffness * (1.0 + 1j * _LOSS) - w**2 * mass + extra)
        found[i] = splu(dynamic).solve(load)[-1]
    return found
