"""What a good engineer writes with scipy for one problem: logs of variables, 200 speeds, SLSQP from a good start."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

FloatArray = NDArray[np.float64]
Rows = Callable[[float, float], list[FloatArray]]
RPM = 2.0 * np.pi / 60.0
HERTZ = 2.0 * np.pi
GRAVITY = 9.80665


@dataclass(frozen=True)
class ByHand:
    """One problem: stiffest mount k (and damping c) with every row of value / bound at most 1.

    file
        The same problem for vibopt, in `problems/isolation`.
    start, low, high
        Of k, and of c where it is chosen.
    damping
        c from k where it is not chosen.
    """

    file: str
    start: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]
    rows: Rows
    damping: Callable[[float], float] = lambda k: 0.0

    def solve(self) -> FloatArray:
        """The design that SLSQP leaves behind."""

        def room(z: FloatArray) -> FloatArray:
            x = np.exp(z)
            c = x[1] if len(x) == 2 else self.damping(x[0])
            return -np.log(np.concatenate(self.rows(x[0], c)))

        answer = minimize(
            lambda z: -z[0],
            np.log(self.start),
            jac=lambda z: -np.eye(len(z))[0],
            method="SLSQP",
            bounds=np.log(np.column_stack([self.low, self.high])),
            constraints={"type": "ineq", "fun": room},
            options={"ftol": 1e-10},
        )
        return np.exp(answer.x)


def size(k: float, c: float, m: float, w: FloatArray) -> FloatArray:
    """|k - m w^2 + i w c|."""
    return np.hypot(k - m * w**2, w * c)


def ratio(k: float, c: float, m: float, w: FloatArray) -> FloatArray:
    """Transmissibility."""
    return np.hypot(k, w * c) / size(k, c, m, w)


def press(bound: float = 0.02, power: int = 0) -> ByHand:
    """Problem 9.34, with the bound of the way up [m] and the power of the speed in the force."""
    m, top = 300.0, 3000.0 * RPM
    run, up = np.array([top]), np.linspace(0.0, top, 200)
    force = 30e3 * (up / top) ** power

    def rows(k: float, c: float) -> list[FloatArray]:
        return [
            30e3 / 10e3 * ratio(k, c, m, run),
            30e3 / 2.5e-3 / size(k, c, m, run),
            np.maximum(force, 1e-6) / bound / size(k, c, m, up),
        ]

    name = "rao_9_34.toml" if power == 0 else "rao_9_34_speed_squared.toml"
    return ByHand(name, (3e6, 2e4), (1e4, 10.0), (1e9, 1e6), rows)


def fan() -> ByHand:
    """Problem 9.28."""
    m, top = 800.0 / GRAVITY, 600.0 * RPM
    run, up = np.array([top]), np.linspace(0.0, top, 200)
    return ByHand(
        "rao_9_28.toml",
        (1e4, 400.0),
        (1e3, 1.0),
        (1e6, 1e4),
        lambda k, c: [ratio(k, c, m, run) / 0.1, ratio(k, c, m, up) / 2.5],
    )


def tied(file: str, m: float, zeta: float, w: FloatArray, bound: float, power: int = 0) -> ByHand:
    """One mount with a fixed damping ratio; force ratio times w**power at most `bound`."""
    return ByHand(
        file,
        (0.05 * m * float(w.min()) ** 2,),
        (1e-3 * m * float(w.min()) ** 2,),
        (0.9 * m * float(w.min()) ** 2,),
        lambda k, c: [ratio(k, c, m, w) * w**power / bound],
        lambda k: 2.0 * zeta * float(np.sqrt(k * m)),
    )


def problems() -> list[ByHand]:
    """Ten one-mass problems."""
    one = np.ones(1)
    return [
        press(),
        press(power=2),
        fan(),
        tied("rao_9_27.toml", 85.0 / GRAVITY, 0.0, np.linspace(25.0, 35.0, 200) * HERTZ, 0.2),
        tied("rao_9_29_damped.toml", 500.0, 0.1, 300.0 * RPM * one, 0.1),
        tied("rao_9_33.toml", 80.0, 0.0, 1000.0 * RPM * one, 0.2),
        tied("rao_9_36.toml", 200.0, 0.08, np.linspace(800.0, 2000.0, 200) * RPM, 6e3, 2),
        tied("rao_9_44.toml", 60.0, 0.0, 3000.0 * RPM * one, 0.25),
        tied("rao_9_46.toml", 30.0, 0.25, np.linspace(10.0, 75.0, 200) * HERTZ, 0.15),
        tied("rao_9_48.toml", 1.0, 0.0, 2.0 * HERTZ * one, 0.05),
    ]
