"""Two bodies of which one link rubs, and a Runge-Kutta method between events: it shares nothing with vibopt."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

Rows = np.ndarray[Any, np.dtype[np.float64]]
ENDS = (("rack", "drawer"), ("ground", "drawer"), ("ground", "rack"))
MASSES, LOW, UP = (180.0, 40.0), 4e5, 1e5
"""Where the pad may rub; masses [kg] and springs [N/m] of rack and drawer."""


def drawer_in_rack(
    load: dict[str, Any], ends: tuple[str, str], damping: float, pad: dict[str, Any], measures: dict[str, Any]
) -> dict[str, Any]:
    """A rack on mounts, a drawer on a spring in it, and a pad that rubs; on a floor where that is what moves."""
    floor = "floor" if load.get("on") == "floor" else "ground"
    dash = f"{damping!r} N s/m"
    return {
        "title": "drawer that rubs",
        "bodies": {"rack": {"mass": f"{MASSES[0]} kg"}, "drawer": {"mass": f"{MASSES[1]} kg"}},
        "links": {
            "low": {"between": [floor, "rack"], "stiffness": f"{LOW} N/m", "damping": dash},
            "up": {"between": ["rack", "drawer"], "stiffness": f"{UP} N/m", "damping": dash},
            "pad": {"between": [floor if one == "ground" else one for one in ends]} | pad,
        },
        "excitations": {"load": load},
        "measures": measures,
    } | ({"bases": {"floor": {}}} if floor == "floor" else {})


def follow(
    matrices: tuple[Rows, Rows, Rows],
    across: Rows,
    friction: float,
    push: Callable[[float], Rows],
    joints: tuple[float, ...],
    read: Callable[[float, Rows, Rows, Rows, float], tuple[float, ...]],
) -> list[float]:
    """Greatest sizes of what `read` says of time, places, rates, accelerations and friction, from rest on.

    Masses, dampers and springs are (n, n); the force is smooth between `joints`, of which the last is the end.
    """
    mass, damp, stiff = matrices
    n, inverse = len(mass), np.linalg.inv(mass)
    slips = inverse @ across
    time, now, side, best = 0.0, np.zeros(2 * len(mass)), 0.0, np.zeros(0)

    def free(t: float, y: Rows) -> Rows:
        return np.asarray(inverse @ (push(t) - stiff @ y[:n] - damp @ y[n:]))

    def carried(t: float, y: Rows) -> float:
        return float(across @ free(t, y) / (across @ slips))

    while time < joints[-1]:

        def rubs(t: float, y: Rows, s: float = side) -> float:
            return s * friction if s else carried(t, y)

        def rates(t: float, y: Rows, rubs: Any = rubs) -> Rows:
            return np.concatenate([y[n:], free(t, y) - slips * rubs(t, y)])

        def event(t: float, y: Rows, s: float = side) -> float:
            return s * float(across @ y[n:]) if s else friction - abs(carried(t, y))

        watch: Any = event
        watch.terminal, watch.direction = True, -1
        end = next(one for one in joints if one > time * (1.0 + 1e-12))
        run: Any = solve_ivp(rates, (time, end), now, method="DOP853", rtol=1e-11, atol=1e-13, events=watch,
                             dense_output=True, max_step=4e-3)  # fmt: skip
        for t in np.linspace(time, run.t[-1], max(30, int((run.t[-1] - time) * 2e4))):
            y = run.sol(t)
            seen = np.abs(read(t, y[:n], y[n:], rates(t, y)[n:], rubs(t, y)))
            best = np.maximum(best, seen) if len(best) else seen
        time, now, was = float(run.t[-1]), run.y[:, -1].copy(), side
        if run.status == 1:
            if was:
                now[n:] -= slips * (across @ now[n:]) / (across @ slips)
            force = carried(time, now)
            side = float(np.sign(force)) if not was or abs(force) > friction else 0.0
            side = 0.0 if side == was else side
    return [float(one) for one in best]
