"""Measured rotors from their file to the verified plan, against cvxpy: `python tests/bench/rotor_files.py [--profile]`.

The rival reads the same file as plainly as can be (csv or tomli, one unit, one trial weight a plane), builds the
program anew and solves it by Clarabel; nothing is checked.  One BLAS thread, processor time, ratios within one run.
"""

from __future__ import annotations

# ruff: noqa: E402, E501
import os

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import cmath
import cProfile
import csv
import pstats
import sys
import tempfile
from math import radians
from pathlib import Path
from typing import Any

import numpy as np
import tomli
from timing import in_turns

import vibopt as vo

SIZES = ((4, 2, 2), (10, 4, 8), (100, 10, 20), (500, 10, 8))
"""Sensors, speeds, planes."""
GOALS = ("rms", "worst")
RADIUS = 0.15
Numbers = np.ndarray[Any, np.dtype[Any]]


def rotor_files(folder: Path, sensors: int, speeds: int, planes: int, goal: str) -> tuple[Path, Path]:
    """The same rotor as a problem file with a CSV file beside it, and as one TOML file; caps that bind on its planes."""
    rng = np.random.default_rng(sensors * speeds + planes)
    n = sensors * speeds
    y0 = 0.1 * (rng.normal(size=n) + 1j * rng.normal(size=n)).reshape(speeds, sensors)  # mm
    H = 0.002 * (rng.normal(size=(n, planes)) + 1j * rng.normal(size=(n, planes)))  # mm per g
    best = np.linalg.lstsq(H, -y0.ravel(), rcond=None)[0]
    cap = 0.7 * float(np.median(np.abs(best)))
    H = H.reshape(speeds, sensors, planes)
    trials = 10.0 * np.exp(2j * np.pi * rng.random(planes))
    runs = []
    for speed in range(speeds):
        runs.append((f"found {speed}", 1000 + 300 * speed, None, y0[speed]))
        for plane in range(planes):
            runs.append(
                (f"trial {speed} {plane}", 1000 + 300 * speed, plane, y0[speed] + H[speed, :, plane] * trials[plane])
            )
    head = _head(sensors, planes, cap, goal)
    stem = f"{sensors}_{speeds}_{planes}_{goal}"
    (folder / f"{stem}.csv").write_text(_as_csv(runs, trials, sensors, planes))
    (folder / f"{stem}_sheet.toml").write_text(f'readings = "{stem}.csv"\n{head}')
    (folder / f"{stem}.toml").write_text(head + _as_toml(runs, trials))
    return folder / f"{stem}_sheet.toml", folder / f"{stem}.toml"


def _head(sensors: int, planes: int, cap: float, goal: str) -> str:
    lines = ['title = "rotor"', "[conventions]", 'phase = "lag"', 'readings = "phase"', 'angles = "with rotation"']
    lines += ['detector = "pk"', 'zero = "mark"', "[goal]", 'minimise = "residual"', f'combine = "{goal}"']
    for plane in range(planes):
        lines += [f"[planes.p{plane}]", 'radius = "150 mm"', f'weight = {{ from = "0 g", to = "{cap!r} g" }}']
    return "\n".join([*lines, ""])


def _polar(z: complex, sign: int) -> tuple[str, str]:
    return f"{abs(z):.6g}", f"{sign * np.degrees(cmath.phase(z)) % 360.0:.6g}"


def _as_csv(runs: list[Any], trials: Numbers, sensors: int, planes: int) -> str:
    heading = ["run", "speed [rpm]"]
    heading += [one for p in range(planes) for one in (f"p{p} mass [g]", f"p{p} angle [deg]")]
    heading += [one for s in range(sensors) for one in (f"s{s} amplitude [mm pk]", f"s{s} angle [deg]")]
    rows = [",".join(heading)]
    for name, speed, plane, readings in runs:
        cells = [name, str(speed)]
        for p in range(planes):
            cells += _polar(trials[p], 1) if p == plane else ("", "")
        for z in readings:
            cells += _polar(z, -1)
        rows.append(",".join(cells))
    return "\n".join([*rows, ""])


def _as_toml(runs: list[Any], trials: Numbers) -> str:
    rows = []
    for name, speed, plane, readings in runs:
        rows += ["[[runs]]", f'name = "{name}"', f'speed = "{speed} rpm"']
        if plane is not None:
            amount, angle = _polar(trials[plane], 1)
            rows.append(f'weights = {{ p{plane} = "{amount} g @ {angle} deg" }}')
        shown = (f's{s} = "{" mm pk @ ".join(_polar(z, -1))} deg"' for s, z in enumerate(readings))
        rows.append(f"readings = {{ {', '.join(shown)} }}")
    return "\n".join([*rows, ""])


def rival(file: Path, goal: str) -> float:
    """The same plan by a plain reading and a fresh cvxpy program [goal in m]."""
    document = tomli.loads(file.read_text())
    planes = list(document["planes"])
    caps = np.array([float(document["planes"][one]["weight"]["to"].split()[0]) * 1e-3 for one in planes])
    rows = (
        _sheet_rows(file.parent / document["readings"], len(planes)) if "readings" in document else _toml_rows(document)
    )
    y0, H = [], []
    for speed in dict.fromkeys(row[0] for row in rows):
        own = [row for row in rows if row[0] == speed]
        found = next(readings for _, weights, readings in own if not weights.any())
        block = np.zeros((len(found), len(planes)), dtype=complex)
        for _, weights, readings in own:
            for plane in np.flatnonzero(weights):
                block[:, plane] = (readings - found) / weights[plane]
        y0.append(found)
        H.append(block)
    return _cvxpy(np.concatenate(y0), np.concatenate(H), caps, goal)


def _sheet_rows(file: Path, planes: int) -> list[Any]:
    with open(file, newline="") as stream:
        reader = csv.reader(stream)
        next(reader)
        rows = []
        for row in reader:
            values = np.array([float(one or 0.0) for one in row[2:]]).reshape(-1, 2)
            weights = 1e-3 * values[:planes, 0] * np.exp(1j * np.radians(values[:planes, 1]))
            rows.append((row[1], weights, 1e-3 * values[planes:, 0] * np.exp(-1j * np.radians(values[planes:, 1]))))
    return rows


def _toml_rows(document: dict[str, Any]) -> list[Any]:
    planes = list(document["planes"])
    rows = []
    for run in document["runs"]:
        weights = np.zeros(len(planes), dtype=complex)
        for name, text in run.get("weights", {}).items():
            amount, _, _, angle, _ = text.split()
            weights[planes.index(name)] = cmath.rect(1e-3 * float(amount), radians(float(angle)))
        parts = [text.split() for text in run["readings"].values()]
        size = 1e-3 * np.array([float(part[0]) for part in parts])
        rows.append((run["speed"], weights, size * np.exp(-1j * np.radians([float(part[4]) for part in parts]))))
    return rows


def _cvxpy(y0: Numbers, H: Numbers, caps: Numbers, goal: str) -> float:
    import cvxpy as cp

    u = cp.Variable(len(caps), complex=True)
    unit = float(np.abs(y0).max())
    left = y0 / unit + (H / unit * caps.max()) @ u
    least = cp.max(cp.abs(left)) if goal == "worst" else cp.norm(left) / np.sqrt(len(y0))
    problem = cp.Problem(cp.Minimize(least), [cp.abs(u) <= caps / caps.max()])
    problem.solve(solver="CLARABEL")
    return float(problem.value) * unit


def ours(file: Path) -> Any:
    """From the file to the verified plan."""
    return vo.solve(vo.read(file))


def compared(file: Path, goal: str, readings: int) -> tuple[list[float], list[Any]]:
    """Seconds and answers: ours, and cvxpy's."""
    return in_turns([lambda: ours(file), lambda: rival(file, goal)], 15 if readings <= 40 else 5)


def main() -> None:
    """The table of ratios."""
    print(f"{'readings':>9} {'goal':>6} {'file':>5} {'ours ms':>9} {'cvxpy ms':>9} {'ratio':>6} {'difference':>10}")
    with tempfile.TemporaryDirectory() as folder:
        for sensors, speeds, planes in SIZES:
            for goal in GOALS:
                for kind, file in zip(
                    ("csv", "toml"), rotor_files(Path(folder), sensors, speeds, planes, goal), strict=True
                ):
                    best, (plan, value) = compared(file, goal, sensors * speeds)
                    own = float(plan.goal[1].value)
                    print(
                        f"{sensors * speeds:>6}x{planes:<2} {goal:>6} {kind:>5} {1e3 * best[0]:9.1f} {1e3 * best[1]:9.1f}"
                        f" {best[1] / best[0]:6.1f} {(own - value) / value:10.1e} {plan.status}"
                    )


def profile(index: int, goal: str, kind: str) -> None:
    """Where the time goes."""
    with tempfile.TemporaryDirectory() as folder:
        file = rotor_files(Path(folder), *SIZES[index], goal)[kind == "toml"]
        ours(file)
        profiler = cProfile.Profile()
        profiler.runcall(ours, file)
        pstats.Stats(profiler).sort_stats("cumulative").print_stats(60)


if __name__ == "__main__":
    if "--profile" in sys.argv:
        profile(int(sys.argv[2]), sys.argv[3], sys.argv[4])
    else:
        main()
