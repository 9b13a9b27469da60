"""Fidelity: degrees of freedom declared and needed, and what the smaller model costs and saves."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median

import numpy as np

from vibopt.errors import VibOptError
from vibopt.forms import FloatArray
from vibopt.program.pose import pose
from vibopt.program.program import Program
from vibopt.program.reduce import reason
from vibopt.scene.scene import Scene
from vibopt.solve.box import closed
from vibopt.solve.branch import Judge
from vibopt.solve.choose import choose
from vibopt.study.chart.asking import Progress
from vibopt.study.chart.cases import chain
from vibopt.work import answering

RUNS, QUICK_RUNS = 3, 1


@dataclass(frozen=True, slots=True)
class Fidelity:
    """One scene on its reduced and on its full model.

    declared, used
        Degrees of freedom in the file, and those of the largest model that a question needs.
    why
        Reason for the difference, in words.
    measuring, measuring_full
        Seconds for measuring every limit at one design.
    solving, solving_full
        Seconds for the answer; nan where there is none to be had.
    value_error
        Greatest difference of any limit's value between the two models over some designs, as a part of it.
    goal_error
        Difference of the best goals found on the two, as a part of it; nan where one is missing.
    cut
        Why less was asked than the chart promises; "" where all was.
    """

    case: str
    declared: int
    used: int
    why: str
    measuring: float
    measuring_full: float
    solving: float
    solving_full: float
    value_error: float
    goal_error: float
    cut: str = ""


def fidelity(
    scenes: Sequence[Scene] = (), *, quick: bool = False, progress: Progress | None = None
) -> tuple[Fidelity, ...]:
    """Every scene posed twice, with and without reduction."""
    from vibopt.scene.read import from_text

    stock = scenes or [from_text(text, name=name) for name, text in texts(quick=quick)]
    rows = []
    for number, scene in enumerate(stock):
        if progress:
            progress(scene.name, number / len(stock))
        rows.append(_compared(scene, QUICK_RUNS if quick else RUNS))
    return tuple(rows)


def texts(*, quick: bool) -> list[tuple[str, str]]:
    """Symmetric machines, chains and halls of unrelated machines, as (name, problem file)."""
    made = [(f"symmetric machine, {n + 1} bodies", star(n)) for n in (2, 4, 8, 16)]
    made += [(f"chain of {n} bodies", chain(n, floor="300 N", start_up="4 mm")) for n in (2, 5, 10)]
    made += [(f"hall of {n} unrelated machines", hall(n)) for n in (2, 5, 10, 20)]
    return made[::2] if quick else made


def star(count: int) -> str:
    """A machine on its mount with `count` alike motors hung on it: they move as one."""
    motors = "\n".join(
        f'[bodies.motor{i}]\nmass = "20 kg"\n\n[links.arm{i}]\nbetween = ["motor{i}", "machine"]\n'
        f'stiffness = "8 MN/m"\ndamping = "500 N s/m"\n'
        for i in range(1, count + 1)
    )
    return f"""title = "Machine with {count} alike motors"

[bodies.machine]
mass = "300 kg"

{motors}
[links.mount]
between = ["machine", "ground"]
stiffness = {{ from = "10 kN/m", to = "1 GN/m" }}
damping = {{ from = "10 N s/m", to = "1 MN s/m" }}

[excitations.shaft]
kind = "force"
on = "machine"
amplitude = "30 kN"
speed = "3000 rpm"
varies = "constant"

[limits.floor]
response = "transmitted_force"
into = "ground"
at_most = "12 kN"

[limits.start_up]
response = "displacement"
of = "machine"
over = "0..3000 rpm"
at_most = "20 mm"

[goal]
maximise = "stiffness"
of = "mount"
"""


def hall(count: int) -> str:
    """Machines that stand beside each other; one is to be mounted anew."""
    others = "\n".join(
        f'[bodies.other{i}]\nmass = "{100 + 10 * i} kg"\n\n[links.feet{i}]\nbetween = ["other{i}", "ground"]\n'
        f'stiffness = "{1 + i} MN/m"\ndamping = "1 kN s/m"\n'
        for i in range(1, count)
    )
    return f"""title = "Hall of {count} machines"

[bodies.press]
mass = "300 kg"

{others}
[links.mount]
between = ["press", "ground"]
stiffness = {{ from = "10 kN/m", to = "1 GN/m" }}
damping = {{ from = "10 N s/m", to = "1 MN s/m" }}

[excitations.shaft]
kind = "force"
on = "press"
amplitude = "30 kN"
speed = "3000 rpm"
varies = "constant"

[limits.floor]
response = "transmitted_force"
into = "ground"
at_most = "10 kN"

[limits.start_up]
response = "displacement"
of = "press"
over = "0..3000 rpm"
at_most = "20 mm"

[goal]
maximise = "stiffness"
of = "mount"
"""


def _compared(scene: Scene, runs: int) -> Fidelity:
    small = closed(pose(scene))
    full = closed(pose(scene, reduce=False))
    own, whole = _solved(small, runs), _solved(full, runs)
    points = _designs(small, own.x)
    return Fidelity(
        case=scene.name.removesuffix(".toml"),
        declared=small.model.n_free,
        used=small.used_dof,
        why=reason(small.model.n_free, small.used_dof),
        measuring=_measuring(small, points[0]),
        measuring_full=_measuring(full, points[0]),
        solving=own.seconds,
        solving_full=whole.seconds,
        value_error=max(_value_error(small, full, point) for point in points),
        goal_error=abs(own.goal - whole.goal) / max(abs(whole.goal), 1e-300),
        cut="; ".join(f"{name}: {one.cut}" for name, one in (("smaller model", own), ("full model", whole)) if one.cut),
    )


@dataclass(frozen=True, slots=True)
class _Solved:
    """Seconds, goal and design of the method that vibopt would choose, and why there is less of it."""

    seconds: float = math.nan
    goal: float = math.nan
    x: FloatArray | None = None
    cut: str = ""


def _solved(program: Program, runs: int) -> _Solved:
    times, goal, x = [], math.nan, None
    for _ in range(runs):
        with answering() as limit:
            begin = time.perf_counter()
            try:
                found = choose(program, None).solve(program)
            except VibOptError as error:
                return _Solved(cut=str(error))
            times.append(time.perf_counter() - begin)
        if found.x is not None:
            goal, x = Judge(program).goal(found.x).value, found.x
        if limit is not None and limit.ended:
            return _Solved(median(times), goal, x, f"the time limit of {limit.seconds:g} s ended it")
    return _Solved(median(times), goal, x)


def _designs(program: Program, best: FloatArray | None) -> list[FloatArray]:
    """The best design and a few others, at which the two models are compared."""
    from vibopt.solve.starts import starts

    spread = [np.clip(np.exp(y), program.low, program.high) for y in starts(program, 8)]
    return spread if best is None else [best, *spread]


def _measuring(program: Program, x: FloatArray) -> float:
    judge = Judge(program)
    times = []
    for _ in range(5):
        begin = time.perf_counter()
        for limit in program.limits:
            judge.limit(limit, x)
        times.append(time.perf_counter() - begin)
    return median(times)


def _value_error(small: Program, full: Program, x: FloatArray) -> float:
    """Greatest relative difference of a limit's value, measured on both models."""
    worst = 0.0
    for one, other in zip(small.limits, full.limits, strict=True):
        a, b = (Judge(p).limit(limit, x)[1].value for p, limit in ((small, one), (full, other)))
        if np.isfinite(a) and np.isfinite(b):
            worst = max(worst, abs(a - b) / max(abs(b), 1e-300))
        elif a != b:
            return math.inf
    return worst
