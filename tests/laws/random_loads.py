"""Random machines on a line under random loads in time, and their motion by an integrator that knows none of vibopt."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Array = NDArray[np.float64]
SHAPES: dict[str, tuple[Callable[[float], float], tuple[float, ...]]] = {
    "half sine": (lambda s: np.sin(np.pi * s), (0.0, 1.0)),
    "versed sine": (lambda s: 0.5 - 0.5 * np.cos(2.0 * np.pi * s), (0.0, 1.0)),
    "sine": (lambda s: np.sin(2.0 * np.pi * s), (0.0, 1.0)),
    "rectangle": (lambda s: 1.0, (0.0, 1.0)),
    "triangle": (lambda s: 2.0 * s if s < 0.5 else 2.0 - 2.0 * s, (0.0, 0.5, 1.0)),
    "rising sawtooth": (lambda s: s, (0.0, 1.0)),
    "falling sawtooth": (lambda s: 1.0 - s, (0.0, 1.0)),
}
"""Each against the part of its duration that is over, and where it jumps or bends."""
BODIES = ("a", "b", "c")


@dataclass
class Chain:
    """One to three bodies one on the other, the first on a floor; what comes over them is added load by load.

    rows
        What each load pushes with a signal of one: force on bodies [N], acceleration of the floor [m/s^2].
    signals, joints
        Of each load against time, and where it jumps or bends.
    start
        Displacements and velocities of the bodies from the floor, (2 n,).
    """

    masses: Array
    springs: Array
    dampers: Array
    loads: dict[str, dict[str, Any]] = field(default_factory=dict)
    rows: list[Array] = field(default_factory=list)
    signals: list[Callable[[float], float]] = field(default_factory=list)
    joints: set[float] = field(default_factory=lambda: {0.0})
    start: Array = field(default_factory=lambda: np.zeros(0))

    @classmethod
    def drawn(cls, rng: np.random.Generator, most: int = 3) -> Chain:
        n = int(rng.integers(1, most + 1))
        masses, springs = 10.0 ** rng.uniform(0.0, 1.0, n), 10.0 ** rng.uniform(2.5, 4.0, n)
        dampers = 2.0 * rng.uniform(0.04, 0.5, n) * np.sqrt(masses * springs)
        return cls(masses, springs, dampers, start=np.zeros(2 * n))

    @property
    def n(self) -> int:
        return len(self.masses)

    def matrix(self, values: Array) -> Array:
        rows = np.eye(self.n) - np.eye(self.n, k=-1)
        return np.asarray(rows.T @ np.diag(values) @ rows)

    @property
    def rates(self) -> Array:
        """Sizes of the poles [1/s], rising."""
        own = np.linalg.solve(np.diag(self.masses), np.hstack([self.matrix(self.springs), self.matrix(self.dampers)]))
        return np.sort(np.abs(np.linalg.eigvals(np.vstack([np.eye(self.n, 2 * self.n, self.n), -own]))))

    def add(self, table: dict[str, Any], row: Array, signal: Callable[[float], float], joints: list[float]) -> None:
        self.loads[f"load{len(self.loads)}"] = table
        self.rows.append(row)
        self.signals.append(signal)
        self.joints |= set(joints)

    def pulse(self, rng: np.random.Generator, duration: float, given: dict[str, str] | None = None) -> None:
        """Of force on a body or of acceleration of the floor, once or a few times; `given` in place of a duration."""
        shape = str(rng.choice(list(SHAPES)))
        value, bends = SHAPES[shape]
        on, size = int(rng.integers(-1, self.n)), float(rng.uniform(5.0, 90.0))
        times = 1 if given else int(rng.integers(1, 4))
        every = duration * float(rng.uniform(1.0, 2.0)) if times > 1 else duration
        table = {"kind": "pulse", "on": "floor" if on < 0 else BODIES[on], "shape": shape}
        table |= {"acceleration": f"{size!r} m/s²"} if on < 0 else {"amplitude": f"{size!r} N"}
        table |= given or {"duration": f"{duration!r} s"}
        table |= {"times": times, "every": f"{every!r} s"} if times > 1 else {}

        def signal(time: float) -> float:
            since = time - every * min(int(time / every), times - 1)
            return float(value(since / duration)) if since <= duration else 0.0

        joints = [k * every + part * duration for k in range(times) for part in bends]
        self.add(table, self.push(on, size), signal, joints)

    def push(self, on: int, size: float) -> Array:
        """Accelerations of the bodies from the floor for a signal of one; the floor itself is -1."""
        return -size * np.ones(self.n) if on < 0 else size * np.eye(self.n)[on] / self.masses

    def lasting(self, rng: np.random.Generator) -> None:
        """A force that begins suddenly and goes on for ever."""
        on, size = int(rng.integers(0, self.n)), float(rng.uniform(5.0, 90.0))
        speed = float(rng.uniform(0.3, 1.5) * self.rates[0])
        table = {"kind": "force", "on": BODIES[on], "amplitude": f"{size!r} N", "speed": f"{speed!r} rad/s"}
        self.add({**table, "begins": "suddenly"}, self.push(on, size), lambda time: float(np.sin(speed * time)), [])

    def step(self, rng: np.random.Generator) -> None:
        """A force, or an acceleration of the floor, that begins at once and stays."""
        on, size = int(rng.integers(-1, self.n)), float(rng.uniform(5.0, 90.0))
        table = {"kind": "pulse", "shape": "step", "on": "floor" if on < 0 else BODIES[on]}
        table |= {"acceleration": f"{size!r} m/s²"} if on < 0 else {"amplitude": f"{size!r} N"}
        self.add(table, self.push(on, size), lambda time: 1.0, [])

    def release(self, rng: np.random.Generator) -> None:
        on = int(rng.integers(0, self.n))
        away, fast = float(rng.uniform(-0.01, 0.01)), float(rng.uniform(-0.3, 0.3))
        words = [{"displacement": f"{away!r} m"}, {"velocity": f"{fast!r} m/s"}]
        kept = words[:1] if (which := rng.integers(0, 3)) == 0 else words[1:] if which == 1 else words
        table = {"kind": "release", "on": BODIES[on]} | {key: one for each in kept for key, one in each.items()}
        self.add(table, np.zeros(self.n), lambda time: 0.0, [])
        self.start[on] += away if "displacement" in table else 0.0
        self.start[self.n + on] += fast if "velocity" in table else 0.0

    @property
    def document(self) -> dict[str, Any]:
        """The file of it; every peak of it is measured."""
        below = ["floor", *BODIES]
        links = {
            f"l{i}": {"between": [BODIES[i], below[i]], "stiffness": f"{k!r} N/m", "damping": f"{c!r} N s/m"}
            for i, (k, c) in enumerate(zip(self.springs.tolist(), self.dampers.tolist(), strict=True))
        }
        return {
            "title": "chain under random loads",
            "bases": {"floor": {}},
            "bodies": {
                name: {"mass": f"{mass!r} kg"} for name, mass in zip(BODIES, self.masses.tolist(), strict=False)
            },
            "links": links,
            "excitations": self.loads,
            "measures": {
                "travel": {"response": "peak_relative_displacement", "across": f"l{self.n - 1}"},
                "force": {"response": "peak_force", "through": "l0"},
                "felt": {"response": "peak_acceleration", "of": BODIES[self.n - 1]},
            },
        }

    def peaks(self) -> dict[str, float]:
        """The greatest of each measure, by an integrator from joint to joint, until all but what lasts has faded."""
        n, inverse = self.n, 1.0 / self.masses[:, None]
        stiff, damped = inverse * self.matrix(self.springs), inverse * self.matrix(self.dampers)
        moves = np.array([row if load["on"] != "floor" else 0.0 * row for row, load in self._each])
        shaken = np.array([row for row, _ in self._each])
        own = np.vstack([np.eye(n, 2 * n, n), -np.hstack([stiff, damped])])
        slowest = float(-np.linalg.eigvals(own).real.max())
        last = max(self.joints)
        ends = [*sorted(self.joints), *(last + np.linspace(0.0, 20.0 / slowest, 9)[1:])]
        fast = max(self.rates[-1], *(np.pi / (high - low) for low, high in pairwise(sorted(self.joints))), 1e-9)
        state, found = self.start, np.zeros(3)
        for low, high in pairwise(ends):
            edge = 1e-9 * (high - low)

            def signals(time: float, low: float = low + edge, high: float = high - edge) -> Array:
                return np.array([one(min(max(time, low), high)) for one in self.signals])

            def rates(time: float, z: Array, signals: Callable[[float], Array] = signals) -> Array:
                return np.asarray(own @ z + np.concatenate([np.zeros(n), signals(time) @ shaken]))

            many = int(np.clip(60.0 * fast * (high - low), 60, 20_000))
            times = np.linspace(low, high, many)
            run: Any = solve_ivp(rates, (low, high), state, method="DOP853", rtol=1e-10, atol=1e-14, t_eval=times)
            z, pushed = run.y, np.array([signals(time) for time in times]).T
            felt = -stiff @ z[:n] - damped @ z[n:] + moves.T @ pushed
            travel = z[n - 1] - (z[n - 2] if n > 1 else 0.0)
            force = self.springs[0] * z[0] + self.dampers[0] * z[n]
            found = np.maximum(found, [_top(np.abs(one)) for one in (travel, force, felt[n - 1])])
            state = z[:, -1]
        return dict(zip(("travel", "force", "felt"), found.tolist(), strict=True))

    @property
    def _each(self) -> list[tuple[Array, dict[str, Any]]]:
        return list(zip(self.rows, self.loads.values(), strict=True))


def _top(values: Array) -> float:
    """The greatest of samples, or of the parabola through the three around it, where it is within them."""
    at = int(np.clip(values.argmax(), 1, len(values) - 2))
    left, middle, right = (float(values[at + step]) for step in (-1, 0, 1))
    bent = max(2.0 * middle - left - right, 1e-300)
    inside = abs(right - left) <= 2.0 * bent
    return max(float(values.max()), middle + (right - left) ** 2 / (8.0 * bent) if inside else 0.0)
