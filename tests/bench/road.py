"""The whole road beside what a good engineer writes by hand: every aim of speed in one table, in one run.

    python tests/bench/road.py [words of a line ...]

Processor time, medians; whoever is compared takes turns with its rival.  `over` is the ratio over what is wanted of
it: above 1 the aim is missed.  Errors and details: one_mass.py, absorbers.py, rotor_files.py, catalogue.py, chains.py.
"""

from __future__ import annotations

# ruff: noqa: E402
import os

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from statistics import geometric_mean, median
from typing import Any

import numpy as np

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT))

import absorbers
import catalogue
import chains
import one_mass
import rotor_files
from by_hand import press, problems
from timing import in_turns, timed

from vibopt.arrays import FloatArray
from vibopt.charts import shock_cases
from vibopt.charts.cost import LADDERS
from vibopt.charts.machines import absorbed
from vibopt.charts.scene_rivals import method
from vibopt.charts.trial import filed
from vibopt.forms.peak_in_time import PeakInTime
from vibopt.mechanics.model import Model
from vibopt.program.pose import on_needed, pose
from vibopt.scene.read import from_dict, from_text, read
from vibopt.solve.branch import Judge
from vibopt.solve.ranges import closed
from vibopt.solve.solve import solve
from vibopt.study.sweep import sweep

PROBLEMS = ROOT / "problems"
Line = tuple[str, float, str, float, float]
"""What is asked, our seconds, beside what, its seconds, and the most that the ratio may be."""


def one_body() -> Iterator[Line]:
    """Ten problems of one mass: geometric means."""
    ours, whole, theirs = (geometric_mean(some) for some in zip(*map(one_mass.times, problems()), strict=True))
    yield "one mass, as read", ours, "SLSQP, 200 speeds", theirs, 1.0
    yield "one mass, from its file", whole, "SLSQP, 200 speeds", theirs, 1.5


def sweeps() -> Iterator[Line]:
    """(k, c) of problem 9.34 while a bound goes from 5 to 30 mm; SLSQP starts where the last point ended."""
    scene = read(PROBLEMS / "isolation" / "rao_9_34.toml")
    bounds = np.linspace(0.03, 0.005, 100)

    def by_hand() -> None:
        start = press().start
        for bound in bounds:
            x = replace(press(float(bound)), start=start).solve()
            start = tuple(x) if np.all(np.isfinite(x)) else press().start

    counts = (1_000, 10_000)
    calls = [by_hand, *(partial(sweep, scene, "limits.start_up.at_most", "5 mm..30 mm", n) for n in counts)]
    (hand, *ours), _ = in_turns(calls, 5)
    for count, seconds in zip(counts, ours, strict=True):
        yield f"sweep, one of {count} points", seconds / count, "SLSQP, warm", hand / len(bounds), 0.01
    yield f"sweep, one of {counts[-1]} points", ours[-1] / counts[-1], "10 µs", 1e-5, 1.0


def one_absorber() -> Iterator[Line]:
    """Seven mass ratios and dampings: geometric means."""
    rows = []
    for ratio, zeta in absorbers.CASES:
        scene = from_dict(absorbers.document(ratio, zeta))
        rows.append(in_turns([partial(solve, scene), partial(absorbers.by_slsqp, float(ratio), float(zeta))], 9)[0])
    ours, theirs = (geometric_mean(some) for some in zip(*rows, strict=True))
    yield "one absorber", ours, "SLSQP, 200 speeds", theirs, 1.5


def exchange(scene: Any) -> Any:
    """SLSQP on the exact peaks found so far."""
    return method("slsqp exchange 1e-11").solve(closed(pose(scene)))


def several_absorbers() -> Iterator[Line]:
    """Two and three on one mass; what is ahead of SLSQP in its answer may take three times as long.

    Two with the proof; three by the search alone, and once more with what the whole answer says beside it: how near to
    the best they are, which is longer than the search.
    """
    for ratios, words in (([0.025] * 2, {}), ([0.02, 0.015, 0.015], {"method": "nlp"}), ([0.02, 0.015, 0.015], {})):
        scene = from_text(absorbed([0] * len(ratios), ratios), name="absorbers")
        (ours, theirs), (design, found) = in_turns([partial(solve, scene, **words), partial(exchange, scene)], 3)
        ahead = Judge(pose(scene)).goal(found.x).value / design.goal[1].value - 1.0
        how = "" if words else ", bound"
        yield f"{len(ratios)} absorbers{how}, theirs {ahead:+.0e} off", ours, "SLSQP, exchange", theirs, 3.0


def measured_rotors() -> Iterator[Line]:
    """Caps that bind, from a CSV file to the verified plan."""
    with tempfile.TemporaryDirectory() as folder:
        for sensors, speeds, planes in rotor_files.SIZES:
            readings = sensors * speeds
            for goal in rotor_files.GOALS:
                file, _ = rotor_files.rotor_files(Path(folder), sensors, speeds, planes, goal)
                (ours, theirs), _ = rotor_files.compared(file, goal, readings)
                wanted = 1 / 3 if readings <= 40 else 1 / 5
                yield f"rotor {readings} x {planes}, {goal}, from CSV", ours, "cvxpy, fresh", theirs, wanted


def bought_parts() -> Iterator[Line]:
    """Within so many seconds: a third of what they took before this table was kept."""
    with tempfile.TemporaryDirectory() as folder:
        catalogue.catalogue(Path(folder), 75)
        scene = catalogue.scene(Path(folder), {"minimise": "transmitted_force", "into": "ground"}, counts=True)
        yield "75 parts on two stages, counts", timed(partial(solve, scene))[0], "3.6 s", 3.6, 1.0
    scene = read(PROBLEMS / "mounts" / "generator_set_on_six.toml")
    yield "set on six mounts, tolerances", timed(partial(solve, scene))[0], "4.3 s", 4.3, 1.0


def large() -> Iterator[Line]:
    """Harmonics and long chains, each within a second."""
    answered = next(LADDERS["harmonics"][2](20))
    yield "20 harmonics, summed", timed(answered, 3)[0], "1 s", 1.0, 1.0
    for variables in (1, 2):
        scene = from_text(chains.text(100, variables))
        yield f"chain of 100 bodies, {variables} chosen", timed(partial(solve, scene), 3)[0], "1 s", 1.0, 1.0
    scene = from_text(chains.text(200, 0))
    yield "200 bodies, analysis", timed(partial(solve, scene), 3)[0], "1 s", 1.0, 1.0


def shocks() -> Iterator[Line]:
    """Peaks under pulses and a record, of one machine and of 64 at once; the integrator with 1e-9, as it keeps."""
    for case, load in shock_cases.speed(quick=False).cases:
        if not case.name.startswith(("half sine", "rectangle", "record of 20000 points, 1 ")):
            continue
        scene = filed(case, load).scene()
        model, form = on_needed(scene, pose(scene).model, scene.measures["greatest"])
        assert isinstance(form, PeakInTime)
        spread = 1.0 + 1e-3 * np.random.default_rng(14).normal(size=(64, 1))
        calls: list[Callable[[], Any]] = [partial(peaks, model, form, model.values(np.zeros(0)) * np.ones((1, 1)))]
        if not len(load.points) or len(load.points) == 2:
            calls.append(partial(peaks, model, form, model.values(np.zeros(0)) * spread))
        (hand, *ours), _ = in_turns([partial(shock_cases.by_dop853, load, 1e-9), *calls], 1 + 8 * len(calls[1:]))
        for seconds, words in zip(ours, ("", ", one of 64"), strict=False):
            yield f"{case.name}{words}", seconds / (64.0 if words else 1.0), "DOP853, 1e-9", hand, 0.02


def peaks(model: Model, form: PeakInTime, p: FloatArray) -> Any:
    """Of machines of coefficients (n, n_terms), none of which is known."""
    vars(model).pop("in_time", None)
    machine, reading = form.transient(model, p)
    return machine.peaks(reading)


IMPORTS = """
import click, numpy, tomllib
from pydantic import BaseModel
class Table(BaseModel):
    value: float
Table(value=1.0)
"""
"""What any such tool loads; a first model belongs to pydantic's import: only then does it look for plugins."""


def cold_start() -> Iterator[Line]:
    """A whole process, byte code kept, as it is for installed packages."""
    commands = (["-m", "vibopt", "solve", str(PROBLEMS / "isolation" / "rao_9_34.toml")], ["-c", IMPORTS])
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    times: tuple[list[float], list[float]] = ([], [])
    with tempfile.TemporaryDirectory() as folder:
        for turn in range(16):
            for words, own in zip(commands, times, strict=True):
                begin = resource.getrusage(resource.RUSAGE_CHILDREN)
                subprocess.run(
                    [sys.executable, *words], check=True, capture_output=True, cwd=ROOT,
                    env={**kept, "PYTHONPYCACHEPREFIX": folder},
                )  # fmt: skip
                end = resource.getrusage(resource.RUSAGE_CHILDREN)
                if turn:
                    own.append(end.ru_utime + end.ru_stime - begin.ru_utime - begin.ru_stime)
    yield "cold solve of one mass", median(times[0]), "its imports", median(times[1]), 1.3


TABLE: tuple[Callable[[], Iterator[Line]], ...] = (
    one_body, sweeps, one_absorber, several_absorbers, measured_rotors, bought_parts, large, shocks, cold_start,
)  # fmt: skip


def main() -> None:
    """Every line, or those of the functions whose names hold a word given."""
    words = sys.argv[1:]
    print(f"{'':38}{'vibopt':>11}{'beside':>11}  {'':18}{'ratio':>7}{'wanted':>8}{'over':>6}")
    for lines in TABLE:
        if words and not any(word in lines.__name__ for word in words):
            continue
        for what, ours, beside, theirs, wanted in lines():
            ratio = ours / theirs
            times = f"{shown(ours):>11}{shown(theirs):>11}"
            print(f"{what:38}{times}  {beside:18}{ratio:7.3f}{wanted:8.3f}{ratio / wanted:6.2f}", flush=True)


def shown(seconds: float) -> str:
    """In a unit that leaves one to four digits before the point."""
    size, unit = next((one for one in ((1.0, "s"), (1e-3, "ms")) if seconds >= one[0]), (1e-6, "µs"))
    return f"{seconds / size:.2f} {unit}"


if __name__ == "__main__":
    main()
