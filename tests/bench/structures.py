"""Two absorbers on a rod of finite elements: sparse solutions, what is solved beforehand, one design with its slopes.

    python tests/bench/structures.py

Read as ratios within one run.  Every row is one size of the same rod, looked at over 200 frequencies:

sparse    one design: the rod and both absorbers in one sparse matrix, factored at every frequency
enough    beforehand: the rod on the coordinates that its points need, and their receptances
direct    beforehand, the other road: the rod factored once per frequency for all its points
design    each further design, with its slopes in six variables, from what was solved beforehand

Error: of the response of the design against the rod's recurrence in 40 digits; of the sparse solution likewise.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy; several threads only hinder each other on matrices this small

sys.path.insert(0, str(Path(__file__).parents[2]))
sys.path.insert(1, str(Path(__file__).parents[1] / "laws"))

import mpmath
import numpy as np
import scipy.sparse as sparse
from timing import timed

from rods import ROD, rod
from vibopt.arrays import ComplexArray, FloatArray
from vibopt.mechanics.host import Coordinates, Matrices, reduced_host
from vibopt.mechanics.host.matrices import Dashed, factored
from vibopt.mechanics.model import DAMPING, INERTIA, STIFFNESS
from vibopt.mechanics.receptance import Attached, Host

SIZES = (100, 1_000, 10_000, 100_000)
FREQUENCIES = 200
FIRST = 0.5 * np.pi * np.sqrt(ROD["stiffness"] / ROD["mass"]) / ROD["length"]
TOP = 5.7 * FIRST
DESIGN = np.array([20.0, FIRST, 0.1, 10.0, 3.0 * FIRST, 0.05])
"""Mass [kg], frequency [rad/s] and damping ratio of the absorber at the free end, and of the one in the middle."""


def speeds() -> FloatArray:
    """The frequencies [rad/s]."""
    return np.linspace(0.01, 1.0, FREQUENCIES) * TOP


def attached(receptance: ComplexArray, dash: float) -> Attached:
    """Both absorbers on receptances (n, 2, 2) of the end and the middle; the end is shaken and read."""
    kinds = [INERTIA, STIFFNESS, DAMPING] * 2
    exponents = np.zeros((6, 6))
    for i in (0, 3):
        exponents[i : i + 3, i : i + 3] = [[1, 0, 0], [1, 2, 0], [1, 1, 1]]
    table = np.ascontiguousarray(np.moveaxis(receptance, 0, -1))
    return Attached(
        host=Host(table, table[:, 0].copy(), table[:, 0].copy(), table[0, 0].copy(), dash),
        omega=speeds(),
        scale=np.ones(FREQUENCIES, dtype=complex),
        scales=np.array([1.0, 1.0, 2.0] * 2),
        exponents=exponents,
        groups=np.array([0, 1, 1, 2, 3, 3]),
        kinds=np.array(kinds),
        vectors=np.array([[0, 0, 1, 0], [-1, 0, 1, 0], [0, 0, 0, 1], [0, -1, 0, 1]], dtype=float),
        offsets=np.zeros(4, dtype=complex),
        signs=np.zeros(4),
        inner_load=np.zeros(2, dtype=complex),
        inner_row=np.zeros(2),
    )


def sparse_design(of: Matrices) -> ComplexArray:
    """The whole in one sparse matrix, factored at every frequency, (n,)."""
    n, found = of.size, np.empty(FREQUENCIES, dtype=complex)
    places = (n - 1, n // 2)
    for i, w in enumerate(speeds().tolist()):
        rows: list[int] = []
        columns: list[int] = []
        values: list[complex] = []
        for j, place in enumerate(places):
            m, own, ratio = DESIGN[3 * j : 3 * j + 3]
            z = m * own**2 + 2j * w * m * own * ratio
            rows += [place, place, n + j, n + j]
            columns += [place, n + j, place, n + j]
            values += [z, -z, -z, z - m * w**2]
        host = (of.stiffness - w**2 * of.mass).tocoo()
        data = np.concatenate([host.data.astype(complex), values])
        at = (np.concatenate([host.row, rows]), np.concatenate([host.col, columns]))
        load = np.zeros(n + 2, dtype=complex)
        load[n - 1] = 1.0
        found[i] = factored(sparse.coo_array((data, at), shape=(n + 2, n + 2)).tocsc()).solve(load)[n - 1]
    return found


def exact(n: int, picks: list[int]) -> ComplexArray:
    """The same from the rod's recurrence in 40 digits: receptances of end and middle, then both absorbers."""
    found = []
    with mpmath.workdps(40):
        piece = mpmath.mpf(ROD["length"]) / n
        k = mpmath.mpf(ROD["stiffness"]) / piece
        for pick in picks:
            w = mpmath.mpf(float(speeds()[pick]))
            m = mpmath.mpf(ROD["mass"]) * piece / 6 * w**2
            angle, middle = mpmath.acos((k - 2 * m) / (k + m)), n // 2 + 1
            size = (k - 2 * m) * mpmath.sin(n * angle) - (k + m) * mpmath.sin((n - 1) * angle)
            a, b = mpmath.sin(n * angle) / size, mpmath.sin(middle * angle) / size
            c = b * _beyond(k, m, angle, n - middle)
            impedance = []
            for j in (0, 3):
                mass, own, ratio = (mpmath.mpf(float(one)) for one in DESIGN[j : j + 3])
                z = mass * own**2 + 2j * w * mass * own * ratio
                impedance.append(-(w**2) * mass * z / (z - w**2 * mass))
            one, two = impedance
            determinant = (1 + a * one) * (1 + c * two) - b * b * one * two
            found.append(complex((a * (1 + c * two) - b * two * b) / determinant))
    return np.array(found)


def _beyond(k: mpmath.mpf, m: mpmath.mpf, angle: mpmath.mpf, count: int) -> mpmath.mpf:
    """Motion of a node over that of the free end, `count` elements further on, with nothing acting between."""
    slope = ((k - 2 * m) / (k + m) - mpmath.cos(angle)) / mpmath.sin(angle)
    return mpmath.cos(count * angle) + slope * mpmath.sin(count * angle)


def enough(of: Matrices) -> tuple[Coordinates, float, Attached]:
    """The rod on the coordinates that it needs, and the devices on their receptances."""
    made = reduced_host(of, {"end": of.size - 1, "middle": of.size // 2}, TOP)
    dash = 1e-2 * float(np.sqrt(ROD["stiffness"] * ROD["mass"]))
    return made.coordinates, made.error, attached(made.coordinates.receptances(speeds(), dash), dash)


def row(n: int) -> str:
    """One size."""
    of = rod(n)
    once, plain = timed(lambda: sparse_design(of))
    before, found = timed(lambda: enough(of), 2)
    assert isinstance(found, tuple)
    coordinates, error, few = found
    direct, _ = timed(lambda: Dashed(of, np.array([n - 1, n // 2]), 1e3).receptances(speeds(), refined=False))
    few.slopes(DESIGN)
    each = min(timed(lambda: [few.slopes(DESIGN) for _ in range(50)])[0] / 50 for _ in range(10))
    picks = list(range(0, FREQUENCIES, 13))
    true = exact(n, picks)
    own = np.abs(few.response(DESIGN)[picks] / true - 1.0).max()
    theirs = np.abs(np.asarray(plain)[picks] / true - 1.0).max()
    return (
        f"{n:>8} {once:>9.3f} s {before / once:>9.2f} {direct / once:>9.2f} {1e6 * each:>9.0f} us {once / each:>11.0f}"
        f" {coordinates.count:>6} {error:>9.0e} {own:>9.0e} {theirs:>9.0e}"
    )


def main() -> None:
    """The table."""
    print("                                before / sparse        design     sparse /        greatest error of")
    print("    size      sparse    enough    direct                    design   used  checked    design    sparse")
    for n in SIZES:
        print(row(n), flush=True)


if __name__ == "__main__":
    main()
