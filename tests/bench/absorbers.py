"""The best absorber on one mass: time and error of `discs` against 200 speeds with SLSQP and with IPOPT, in one run.

    python tests/bench/absorbers.py

Time: median of interleaved repetitions; vibopt's with the building of its tables, IPOPT's without the building of
its program.  Error: true peak of the design found, over the best possible one in 40 digits, less one.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
from mpmath import mpf, sqrt
from numpy.typing import NDArray
from scipy.optimize import minimize

sys.path.insert(0, str(Path(__file__).parents[2]))
sys.path.insert(1, str(Path(__file__).parents[1] / "references"))

from timing import in_turns

from absorber_routes import System, h_infinity, nishihara_asami
from vibopt.program.pose import pose
from vibopt.program.program import Program
from vibopt.scene.read import from_dict
from vibopt.solve.plane.discs import DiscsOfOneLink
from vibopt.solve.ranges import closed
from vibopt.solve.solve import solve

FloatArray = NDArray[np.float64]
REPEATS = 7
MASS, STIFFNESS = 100.0, 1e5
SPEEDS = np.linspace(0.5, 1.5, 200) * np.sqrt(STIFFNESS / MASS)
LOW, HIGH = np.log([100.0, 0.1]), np.log([2e5, 5e3])
CASES = [*((mu, "0") for mu in ("0.01", "0.02", "0.05", "0.1", "0.2", "0.5")), ("0.05", "0.02"), ("0.2", "0.05")]


def document(ratio: str, zeta: str) -> dict[str, object]:
    spring: dict[str, object] = {"between": ["ground", "main"], "stiffness": "100 kN/m"}
    if float(zeta):
        spring |= {"damping_ratio": float(zeta), "relative_to": "main"}
    tuner = {
        "between": ["main", "absorber"],
        "stiffness": {"from": "100 N/m", "to": "200 kN/m"},
        "damping": {"from": "0.1 N s/m", "to": "5 kN s/m"},
    }
    shaker = {"kind": "force", "on": "main", "amplitude": "1 kN", "speed": "1..100 rad/s", "varies": "constant"}
    return {
        "bodies": {"main": {"mass": "100 kg"}, "absorber": {"mass": f"{100 * float(ratio)} kg"}},
        "links": {"spring": spring, "tuner": tuner},
        "excitations": {"shaker": shaker},
        "goal": {"minimise": "displacement", "of": "main"},
    }


def squares(k: Any, c: Any, ratio: float, zeta: float) -> Any:
    """Squared height at SPEEDS, in numbers or in casadi's symbols."""
    w, m = SPEEDS, MASS * ratio
    own = 2.0 * zeta * np.sqrt(STIFFNESS * MASS) * w
    stiff = STIFFNESS - MASS * w**2
    real, imag = k - m * w**2, c * w
    below_real = stiff * real - own * imag - m * w**2 * k
    below_imag = stiff * imag + own * real - m * w**2 * imag
    return STIFFNESS**2 * (real**2 + imag**2) / (below_real**2 + below_imag**2)


def start(ratio: float) -> FloatArray:
    """Den Hartog's rule, some per cent off."""
    tuning, zeta = 1.0 / (1.0 + ratio), np.sqrt(3.0 * ratio / (8.0 * (1.0 + ratio)))
    m, w = MASS * ratio, tuning * np.sqrt(STIFFNESS / MASS)
    return np.log([1.05 * m * w**2, 0.9 * 2.0 * zeta * m * w])


def by_slsqp(ratio: float, zeta: float) -> FloatArray:
    def room(z: FloatArray) -> FloatArray:
        return np.asarray(z[2] - 0.5 * np.log(np.asarray(squares(np.exp(z[0]), np.exp(z[1]), ratio, zeta))))

    first = start(ratio)
    top = -room(np.append(first, 0.0)).min()
    answer = minimize(
        lambda z: z[2],
        np.append(first, top),
        jac=lambda z: np.array([0.0, 0.0, 1.0]),
        method="SLSQP",
        bounds=[*zip(LOW, HIGH, strict=True), (None, None)],
        constraints={"type": "ineq", "fun": room},
        options={"ftol": 1e-12, "maxiter": 300},
    )
    return np.exp(answer.x[:2])


def ipopt(ratio: float, zeta: float) -> Callable[[], FloatArray]:
    z = ca.SX.sym("z", 3)
    rows = 0.5 * ca.log(squares(ca.exp(z[0]), ca.exp(z[1]), ratio, zeta)) - z[2]
    quiet = {"ipopt.print_level": 0, "print_time": 0, "ipopt.sb": "yes", "ipopt.tol": 1e-12}
    solver = ca.nlpsol("absorber", "ipopt", {"x": z, "f": z[2], "g": rows}, quiet)
    first = np.append(start(ratio), 2.0)
    ends = {"lbx": [*LOW, -np.inf], "ubx": [*HIGH, np.inf], "ubg": 0.0}
    return lambda: np.exp(np.array(solver(x0=first, **ends)["x"]).ravel()[:2])


def error(x: FloatArray, ratio: str, zeta: str, best: object) -> float:
    """True peak of a design in 40 digits over the best possible one, less one."""
    mass, own = MASS * mpf(ratio), sqrt(mpf(STIFFNESS) / MASS)
    k, c = (mpf(float(one)) for one in x)
    height, _ = System(mpf(ratio), sqrt(k / mass) / own, c / (mass * own), mpf(zeta)).peak()
    return float(height / best - 1)


def line(ratio: str, zeta: str) -> float:
    """One case printed; how many times longer SLSQP takes."""
    scene, mu, own = from_dict(document(ratio, zeta)), float(ratio), float(zeta)
    posed: list[Program] = [closed(pose(scene)) for _ in range(REPEATS)]
    fresh = iter(posed)
    hand = ipopt(mu, own)
    calls = (lambda: DiscsOfOneLink().solve(next(fresh)), lambda: solve(scene), lambda: by_slsqp(mu, own), hand)
    (ours, whole, slsqp, interior), _ = in_turns(calls, REPEATS)
    found = DiscsOfOneLink().solve(posed[0])
    assert found.x is not None
    best = h_infinity(ratio, zeta)["peak"] if own else nishihara_asami(ratio)["peak"]
    claimed = found.details["goal"] * STIFFNESS / 1e3 / float(best) - 1.0
    errors = [error(x, ratio, zeta, best) for x in (found.x, by_slsqp(mu, own), hand())]
    print(
        f"{ratio:>6}{zeta:>6}{1e3 * ours:8.1f}{1e3 * whole:8.1f}{1e3 * slsqp:8.1f}{1e3 * interior:8.1f}"
        f"{slsqp / ours:8.1f}{interior / ours:8.1f}{claimed:11.0e}{errors[0]:10.0e}{errors[1]:10.0e}{errors[2]:10.0e}"
    )
    return slsqp / ours


def main() -> None:
    print(f"{'':12}{'time [ms]':^32}{'over discs':^16}{'error of the peak':^41}")
    print(
        f"{'mu':>6}{'zeta':>6}{'discs':>8}{'scene':>8}{'SLSQP':>8}{'IPOPT':>8}{'SLSQP':>8}{'IPOPT':>8}"
        f"{'claimed':>11}{'discs':>10}{'SLSQP':>10}{'IPOPT':>10}"
    )
    ratios = [line(*case) for case in CASES]
    print(f"SLSQP over discs, geometric mean: {np.exp(np.log(ratios).mean()):.1f}, least {min(ratios):.1f}")


if __name__ == "__main__":
    main()
