"""Time and error of `solve` (with its certificate) against SLSQP written by hand, in one run.

    python tests/bench/one_mass.py

Time: median CPU time of interleaved repetitions, from the scene and from the file.  Error: of the stiffest mount,
against an answer in 30 digits; and by how much the worst limit is missed at its worst speed, as a part of its bound.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from by_hand import ByHand, problems
from timing import in_turns

sys.path.insert(0, str(Path(__file__).parents[2]))

from vibopt.program.pose import pose
from vibopt.scene.read import read
from vibopt.solve.branch import Judge
from vibopt.solve.solve import solve

ROOT = Path(__file__).parents[2]

REPEATS = 40


def times(one: ByHand) -> list[float]:
    """Seconds from the scene, from the file, and of SLSQP."""
    file = ROOT / "problems" / "isolation" / one.file
    scene = read(file)
    return in_turns((lambda: solve(scene), lambda: solve(read(file)), one.solve), REPEATS)[0]


def compared(one: ByHand) -> tuple[float, float, float, float, float, float, float]:
    """Times [s] from the scene, from the file, and of SLSQP; errors of both, misses of both."""
    ours, whole, theirs = times(one)
    scene = read(ROOT / "problems" / "isolation" / one.file)
    design, hand = solve(scene), one.solve()
    program = pose(scene)
    judge = Judge(program)
    exact = sharpened(design.x[0], scene.expected)

    def missed(x: tuple[float, ...]) -> float:
        return max(judge.limit(limit, np.array(x))[0] for limit in program.limits)

    return (
        ours, whole, theirs, abs(design.x[0] / exact - 1.0), abs(hand[0] / exact - 1.0),
        max(missed(design.x), 0.0), max(missed(tuple(hand)), 0.0),
    )  # fmt: skip


def sharpened(found: float, expected: object) -> float:
    """The record of the second road (8 digits) where it differs from ours by more than its rounding."""
    from vibopt.units import read_quantity

    for record in expected if isinstance(expected, tuple) else ():
        if str(record.get("path", "")).endswith(".stiffness"):
            value = read_quantity(record["value"], "stiffness").value
            return found if abs(found / value - 1.0) <= 1e-7 else value
    return found


def main() -> None:
    heads = f"{'problem':34}{'vibopt':>9}{'SLSQP':>9}{'ratio':>7}{'read':>6}"
    print(f"{heads}   error of k: ours, SLSQP   limit missed: ours, SLSQP")
    ratios = []
    for one in problems():
        ours, whole, theirs, error, hand, miss, broken = compared(one)
        ratios.append((ours / theirs, whole / theirs))
        print(
            f"{one.file:34}{1e3 * ours:6.2f} ms{1e3 * theirs:6.2f} ms{ratios[-1][0]:7.2f}{ratios[-1][1]:6.2f}"
            f"{error:14.1e}{hand:10.1e}{miss:20.1e}{broken:10.1e}"
        )
    for name, some in zip(("from the scene", "with reading"), zip(*ratios, strict=True), strict=True):
        print(f"{name}: geometric mean of time over time {np.exp(np.log(some).mean()):.2f}, greatest {max(some):.2f}")


if __name__ == "__main__":
    main()
