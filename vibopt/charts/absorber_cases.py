"""Absorbers in the charts: equal peaks in closed form or in forty digits, and rods of a hundred thousand freedoms.

No reference comes from a method that is charted; `tests/references/absorber_optima.py` works them out again.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable, Sequence
from decimal import Decimal, localcontext
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.charts.fidelity import Fidelity, seconds
from vibopt.charts.isolation_cases import (
    HARD_METHODS,
    METHODS,
    QUICK_HARD_METHODS,
    QUICK_METHODS,
    QUICK_RUNS,
    RUNS,
    WARM,
    ends_of,
)
from vibopt.charts.machines import absorbed
from vibopt.charts.stopwatch import spent
from vibopt.charts.trial import Case, Table, left_out, scene_table
from vibopt.charts.verdicts import FEASIBLE, INFEASIBLE
from vibopt.program.pose import pose
from vibopt.scene.read import read
from vibopt.scene.scene import Scene
from vibopt.solve.branch import Judge
from vibopt.solve.choose import choose
from vibopt.solve.ranges import closed

_CLOSED = "closed form (Nishihara and Asami)"
_DIGITS = "equal peaks of the optimum in 40 digits"


def least_peak(mu: float) -> float:
    """Least greatest amplitude of an undamped mass, over its static deflection, at mass ratio mu.

    Over all speeds and all absorbers with one spring and one damper: Nishihara and Asami, 2002.
    """
    with localcontext() as context:
        context.prec = 40
        m = Decimal(mu)
        root = (4 + 3 * m).sqrt()
        square = ((8 + 9 * m) ** 2 * (16 + 9 * m) - 128 * root**3) / (3 * (32 + 27 * m))
        return float(square.sqrt() / (3 * m))


STOCK = (
    Case("1 absorber, undamped mass", absorbed([0], [0.05]), FEASIBLE, least_peak(0.05) / 1e5, _CLOSED),
    Case("1 absorber, damped mass", absorbed([0], [0.05], damping=0.02), FEASIBLE, 5.2671574936586e-5, _DIGITS),
    Case("2 absorbers", absorbed([0, 0], [0.025, 0.025]), FEASIBLE, 5.69505539428107e-5, _DIGITS),
    Case("3 absorbers", absorbed([0] * 3, [0.02, 0.015, 0.015]), FEASIBLE, 5.40552619487582e-5, _DIGITS),
    Case("5 absorbers", absorbed([0] * 5, [0.01] * 5, damping=0.01), FEASIBLE, 4.7444443273958e-5, _DIGITS),
    Case(
        "3 masses, 1 absorber",
        absorbed([2], [0.05], count=3, spring=1e6, damping=0.01, speeds=(5.0, 250.0)),
        FEASIBLE,
        2.23276362921596e-5,
        _DIGITS,
    ),
    Case(
        "3 masses, 2 absorbers",
        absorbed([2, 1], [0.05, 0.05], count=3, spring=1e6, damping=0.01, speeds=(5.0, 250.0)),
        FEASIBLE,
        1.5733801123856977e-5,
        _DIGITS,
    ),
    Case(
        "10 masses, 1 absorber",
        absorbed([9], [0.1], count=10, spring=1e6, damping=0.01, speeds=(1.0, 250.0)),
        FEASIBLE,
        8.82694002423295e-5,
        _DIGITS,
    ),
    Case(
        "100 masses, 1 absorber",
        absorbed([99], [0.5], count=100, spring=1e6, damping=0.01, speeds=(0.2, 30.0)),
        FEASIBLE,
        3.42211459859741e-3,
        _DIGITS,
    ),
)

QUICK = (STOCK[0], STOCK[1], STOCK[2], STOCK[5])


def taking(methods: tuple[str, ...]) -> tuple[str, ...]:
    """Newton on equal peaks as well; no convex form of an absorber is known, so cvxpy would only refuse."""
    return (*(name for name in methods if not name.startswith("cvxpy")), "equal_peaks")


def speed(*, quick: bool) -> Table:
    """One to five absorbers, and one on chains of up to a hundred masses."""
    stock, methods = (QUICK, QUICK_METHODS) if quick else (STOCK, METHODS)
    left = left_out(STOCK, stock, taking(METHODS), taking(methods))
    cases = [(case, case.scene()) for case in stock]
    return scene_table(cases, taking(methods), QUICK_RUNS if quick else RUNS, WARM, left)


def hard(*, quick: bool) -> Table:
    """Small masses, limits out of reach, band edges on a resonance, like modes."""
    every = families()
    cases, methods = (ends_of(every), QUICK_HARD_METHODS) if quick else (every, HARD_METHODS)
    left = left_out(every, cases, taking(HARD_METHODS), taking(methods))
    return scene_table([(case, case.scene()) for case in cases], taking(methods), 1, WARM, left)


def fidelity(*, quick: bool) -> list[tuple[str, Callable[[], Sequence[Fidelity]]]]:
    """One row a size; the full model is the rod and its absorber in one sparse matrix, at 200 speeds."""
    return [(f"rod of {size} freedoms", partial(_row, size)) for size in (_QUICK_SIZES if quick else _SIZES)]


_STATIC = 1e-5
_OWN = math.sqrt(1000.0)


def families() -> list[Case]:
    """Hard ground: all cases, those of a family next to each other."""
    return [*small_masses(), *out_of_reach(), *fixed_stroke(), *edges(), *like_modes()]


def small_masses() -> list[Case]:
    """Mass ratios down to 1e-6: two peaks that lie ever nearer together."""
    return [
        Case(f"mass ratio {mu:g}", absorbed([0], [mu], least_damping=1e-6), FEASIBLE, least_peak(mu) * _STATIC, _CLOSED,
             "small absorbers")
        for mu in (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
    ]  # fmt: skip


def _limited(parts: float) -> str:
    """Least damping of an absorber under a limit of so many times the least possible peak."""
    most = parts * least_peak(0.05) * _STATIC
    bound = f'[limits.amplitude]\nresponse = "displacement"\nof = "m0"\nat_most = "{most!r} m"'
    return absorbed([0], [0.05], extra=bound, goal='[goal]\nminimise = "damping_ratio"\nof = "a0"')


def out_of_reach() -> list[Case]:
    """A limit a hair below the least peak that any absorber of that mass can reach."""
    return [
        Case(
            f"limit {part:g} below the least peak", _limited(1.0 - part), INFEASIBLE, math.nan, _CLOSED, "out of reach"
        )
        for part in (1e-1, 1e-2, 1e-3, 1e-4, 1e-5)
    ]


def fixed_stroke() -> list[Case]:
    """At the resonance of the locked machine the stroke is (1 + mu)/mu static deflections, whatever the absorber."""
    cases = []
    for mu in (0.2, 0.05, 0.01, 0.001):
        bound = 0.999 * (1.0 + mu) / mu * _STATIC
        extra = f'[limits.stroke]\nresponse = "stroke"\nof = "a0"\nat_most = "{bound!r} m"'
        text = absorbed([0], [mu], extra=extra)
        cases.append(
            Case(f"stroke at mass ratio {mu:g}", text, INFEASIBLE, math.nan, "closed form", "stroke out of reach")
        )
    return cases


def edges() -> list[Case]:
    """The band begins or ends on the resonance of the bare machine: no closed form, equal peaks in 40 digits."""
    above = absorbed([0], [0.05], speeds=(_OWN, 100.0), least_damping=0.0)
    below = absorbed([0], [0.05], speeds=(5.0, _OWN), least_damping=0.0)
    return [
        Case(
            "band from the resonance on", above, FEASIBLE, EDGES[0], "equal peaks in 40 digits", "edge on a resonance"
        ),
        Case("band up to the resonance", below, FEASIBLE, EDGES[1], "equal peaks in 40 digits", "edge on a resonance"),
    ]


EDGES = (3.6537468181360059676e-5, 5.3959542036293631977e-5)
"""Least greatest amplitude with the band above, and below, the resonance of the bare mass [m]."""


def like_modes() -> list[Case]:
    """A second machine with nearly the same frequency, hardly coupled: the answer of the first alone."""
    cases = []
    for apart in (1e-3, 1e-6, 1e-9):
        twin = (
            '[bodies.twin]\nmass = "100 kg"\n[links.feet]\nbetween = ["ground", "twin"]\n'
            f'stiffness = "{1e5 * (1 + apart)!r} N/m"\n'
            'damping_ratio = 0.05\nrelative_to = "twin"\n[links.pipe]\nbetween = ["m0", "twin"]\nstiffness = "1e-6 N/m"'
        )
        text = absorbed([0], [0.05], extra=twin).replace(
            "tuning = {", 'tuning_to = "31.622776601683793 rad/s"\ntuning = {'
        )
        cases.append(Case(f"twin {apart:g} apart", text, FEASIBLE, least_peak(0.05) * _STATIC, _CLOSED, "like modes"))
    return cases


_SIZES, _QUICK_SIZES = (100, 1_000, 10_000, 100_000), (100, 1_000)
_SPEEDS = 200
_LENGTH, _LINE_MASS, _AXIAL = 10.0, 100.0, 1e8
"""Rod: length [m], mass per length [kg/m], modulus times area [N]."""
_LOSS = 0.02
_FIRST = 0.5 * np.pi * float(np.sqrt(_AXIAL / _LINE_MASS)) / _LENGTH
_LOW, _TOP = 0.2 * _FIRST, 2.4 * _FIRST
_MASS, _FORCE = 30.0, 1e3


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


def _row(count: int) -> list[Fidelity]:
    mass, stiffness = rod(count)
    with tempfile.TemporaryDirectory() as folder:
        scene = _scene(Path(folder), count, mass, stiffness)
        begin = spent()
        program = closed(pose(scene))
        found = choose(program, None).solve(program)
        solving = spent() - begin
    assert found.x is not None
    judge, speeds = Judge(program), np.linspace(_LOW, _TOP, _SPEEDS)
    x = found.x
    measuring = seconds(lambda: judge.goal(x), 5)[0]
    begin = spent()
    full = _full(mass, stiffness, found.x, speeds)
    measuring_full = spent() - begin
    small = _small(program, found.x, speeds)
    worst = judge.goal(found.x)
    there = np.array(list(worst.speeds.values()))
    exact = float(np.abs(_full(mass, stiffness, found.x, there))[0])
    return [Fidelity(
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
    )]  # fmt: skip


def _small(program: Any, x: FloatArray, speeds: FloatArray) -> FloatArray:
    from vibopt.forms.drive_response import DriveResponse

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
