"""Time per point of a sweep of 10 000 and of 1 000 points against one SLSQP run written by hand, in one run.

    python tests/bench/sweep.py

Both choose (k, c) of problem 9.34 while the bound of the way up goes from 5 to 30 mm.  SLSQP starts each
point where the last one ended; its points are counted at every fiftieth bound.
"""

from __future__ import annotations

import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from by_hand import press

sys.path.insert(0, str(Path(__file__).parents[2]))

from vibopt.scene.read import read
from vibopt.study.sweep import sweep

ROOT = Path(__file__).parents[2]

POINTS = (10_000, 1_000)
REPEATS = 5


def ours(points: int) -> float:
    """Seconds per point, all statuses and numbers at hand."""
    scene = read(ROOT / "problems" / "isolation" / "rao_9_34.toml")
    begin = time.process_time()
    found = sweep(scene, "limits.start_up.at_most", "5 mm..30 mm", points)
    seconds = (time.process_time() - begin) / points
    assert found.complete
    return seconds


def theirs() -> float:
    """Seconds per point."""
    bounds = np.linspace(0.005, 0.03, POINTS[0])[::50][::-1]
    start = press().start
    begin = time.process_time()
    for bound in bounds:
        x = replace(press(float(bound)), start=start).solve()
        start = tuple(x) if np.all(np.isfinite(x)) else press().start
    return (time.process_time() - begin) / len(bounds)


def main() -> None:
    runs = [(theirs(), *(ours(points) for points in POINTS)) for _ in range(REPEATS)]
    hand, *mine = (min(one[i] for one in runs) for i in range(1 + len(POINTS)))
    print(f"SLSQP with 200 speeds: {1e3 * hand:.2f} ms a point")
    for points, seconds in zip(POINTS, mine, strict=True):
        print(f"sweep of {points} points: {1e6 * seconds:.1f} us a point, ratio {hand / seconds:.0f}")


if __name__ == "__main__":
    main()
