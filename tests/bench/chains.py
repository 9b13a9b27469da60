"""Time and error of `solve` against the number of bodies of a chain, with one and with two variables.

    python tests/bench/chains.py

A chain of equal bodies stands on a mount; its top is shaken at every speed of a range, and the floor may get a
bounded force.  Wanted: the stiffest mount (with one variable its damping is given, with two it is chosen).

Error: the greatest force at the design, by a continued fraction in 30 digits and a search of its own,
against the bound; and how far the status is proven.
"""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy; several threads only hinder each other on matrices this small

import mpmath

sys.path.insert(0, str(Path(__file__).parents[2]))

from vibopt.scene.read import from_text
from vibopt.scene.scene import Design
from vibopt.solve.solve import solve

BODIES = (2, 5, 20, 100)
MASS, LINK, DAMPER, FORCE, BOUND = 10.0, 4e5, 120.0, 1000.0, 900.0
LOW, HIGH = 60.0, 90.0
POINTS = 400


def text(bodies: int, variables: int) -> str:
    """The problem file of a chain; nothing is chosen with no variables."""
    stiffness = '{ from = "1 kN/m", to = "10 MN/m" }' if variables else '"1 MN/m"'
    damping = '{ from = "10 N s/m", to = "20 kN s/m" }' if variables == 2 else '"300 N s/m"'
    parts = [f'[bodies.b{i}]\nmass = "{MASS} kg"' for i in range(bodies)]
    parts += [
        f'[links.l{i}]\nbetween = ["b{i}", "b{i - 1}"]\nstiffness = "{LINK} N/m"\ndamping = "{DAMPER} N s/m"'
        for i in range(1, bodies)
    ]
    parts += [
        '[links.mount]\nbetween = ["b0", "ground"]',
        f"stiffness = {stiffness}\ndamping = {damping}",
        f'[excitations.top]\nkind = "force"\non = "b{bodies - 1}"\namplitude = "{FORCE} N"\n'
        f'speed = "{LOW}..{HIGH} rad/s"\nvaries = "constant"',
        f'[limits.floor]\nresponse = "transmitted_force"\ninto = "ground"\nat_most = "{BOUND} N"',
    ]
    return "\n".join(parts + ['[goal]\nmaximise = "stiffness"\nof = "mount"'] * bool(variables))


def force(bodies: int, k: mpmath.mpf, c: mpmath.mpf, omega: mpmath.mpf) -> mpmath.mpf:
    """Force on the floor, from body to body: below each link stands one dynamic stiffness."""
    mount = mpmath.mpc(k, omega * c)
    link = mpmath.mpc(LINK, omega * DAMPER)
    below, passed = mount, mpmath.mpc(1)
    for _ in range(bodies - 1):
        point = below - MASS * omega**2  # dynamic stiffness of all that hangs below the next link
        passed *= link / (point + link)
        below = point * link / (point + link)
    return abs(FORCE * mount * passed / (below - MASS * omega**2))


def worst(bodies: int, k: float, c: float) -> mpmath.mpf:
    """Greatest force over the range: the best of many speeds, then thirds."""
    k, c = mpmath.mpf(k), mpmath.mpf(c)
    step = mpmath.mpf(HIGH - LOW) / POINTS
    speeds = [LOW + i * step for i in range(POINTS + 1)]
    centre = max(speeds, key=lambda omega: force(bodies, k, c, omega))
    low, high = max(centre - step, mpmath.mpf(LOW)), min(centre + step, mpmath.mpf(HIGH))
    for _ in range(80):
        first, second = low + (high - low) / 3, high - (high - low) / 3
        if force(bodies, k, c, first) < force(bodies, k, c, second):
            low = first
        else:
            high = second
    return max(force(bodies, k, c, one) for one in (low, mpmath.mpf(LOW), mpmath.mpf(HIGH)))


def damping_of(design: Design) -> float:
    return design.x[1] if len(design.x) == 2 else 300.0


def main() -> None:
    mpmath.mp.dps = 30
    heads = f"{'bodies':>7}{'variables':>10}{'seconds':>9}  {'status':10}{'method':18}"
    print(f"{heads}{'stiffness [N/m]':>17}{'error of the force':>20}")
    for variables in (1, 2):
        for bodies in BODIES:
            scene = from_text(text(bodies, variables))
            begin = time.perf_counter()
            design = solve(scene, explain=False)
            seconds = time.perf_counter() - begin
            row = f"{bodies:7}{variables:10}{seconds:9.3f}  {design.status:10}{design.method:18}"
            if design.x:
                error = worst(bodies, design.x[0], damping_of(design)) / BOUND - 1
                row += f"{design.x[0]:17.8g}{float(error):20.1e}"
            print(row, flush=True)


if __name__ == "__main__":
    main()
