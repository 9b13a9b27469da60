"""Random machines in space, and their matrices by skew matrices in numpy: a route without vibopt."""

from typing import Any

import numpy as np
from hypothesis import strategies as st
from numpy.typing import NDArray

Array = NDArray[np.float64]
GRAVITY = 9.80665


def skew(arm: Array) -> Array:
    """The matrix whose product with a vector is arm x vector."""
    x, y, z = arm
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def rotation(angles: Array) -> Array:
    """A proper rotation, shape (3, 3)."""
    a, b, c = angles
    one = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1.0]])
    two = np.array([[1.0, 0, 0], [0, np.cos(b), -np.sin(b)], [0, np.sin(b), np.cos(b)]])
    three = np.array([[np.cos(c), 0, np.sin(c)], [0, 1.0, 0], [-np.sin(c), 0, np.cos(c)]])
    return np.asarray(one @ two @ three)


class Plant:
    """One body on mounts: everything in arrays, SI."""

    def __init__(self, seed: int, mounts: int = 4) -> None:
        random = np.random.default_rng(seed)
        self.mass = float(random.uniform(200.0, 3000.0))
        size = random.uniform(0.5, 2.0, 3)
        turn = rotation(random.uniform(-3.0, 3.0, 3))
        self.tensor = turn @ np.diag((size @ size - size**2) * self.mass / 12.0) @ turn.T
        self.centre = random.uniform(-0.3, 0.3, 3)
        corner = np.array([[1, 1, 0], [1, -1, 0], [-1, 1, 0], [-1, -1, 0.0], [0.2, 1.3, 0.0], [-0.3, -1.1, 0.0]])[
            :mounts
        ]
        self.at = corner * 0.8 + random.uniform(-0.2, 0.2, (mounts, 3)) - np.array([0.0, 0.0, 0.6])
        self.k = random.uniform(0.2e6, 2e6, (mounts, 3))
        self.c = random.uniform(0.3e3, 5e3, (mounts, 3))
        self.axes = np.array([rotation(0.3 * random.uniform(-1.0, 1.0, 3)) for _ in range(mounts)])
        self.point = random.uniform(-1.0, 1.0, 3)
        self.force_at = random.uniform(-0.5, 0.5, 3)
        self.way, self.push = (one / np.linalg.norm(one) for one in random.uniform(-1.0, 1.0, (2, 3)))

    def turned(self, by: Array, shift: Array) -> "Plant":
        """The same machine seen from other axes."""
        other = Plant(0, len(self.at))
        other.mass, other.k, other.c = self.mass, self.k, self.c
        other.tensor = by @ self.tensor @ by.T
        other.centre, other.point, other.force_at = (
            by @ one + shift for one in (self.centre, self.point, self.force_at)
        )
        other.at = self.at @ by.T + shift
        other.axes = self.axes @ by.T
        other.way, other.push = by @ self.way, by @ self.push
        return other

    def matrices(self) -> tuple[Array, Array, Array]:
        """M, C, K over x, y, z, rx, ry, rz at the centre of mass."""
        mass = np.zeros((6, 6))
        mass[:3, :3], mass[3:, 3:] = self.mass * np.eye(3), self.tensor
        found = []
        for values in (self.c, self.k):
            whole = np.zeros((6, 6))
            for at, axes, value in zip(self.at, self.axes, values, strict=True):
                block = axes.T @ np.diag(value) @ axes
                arm = skew(at - self.centre)
                whole += np.block([[block, -block @ arm], [arm @ block, -arm @ block @ arm]])
            found.append(whole)
        return mass, found[0], found[1]

    def reads(self, at: Array, way: Array) -> Array:
        """Row of the displacement at a place along a direction, (6,)."""
        return np.concatenate([way, np.cross(at - self.centre, way)])

    def response(self, omega: Array) -> Array:
        """Modulus of the displacement at the point per newton, at each frequency."""
        mass, damping, stiffness = self.matrices()
        whole = stiffness - omega[:, None, None] ** 2 * mass + 1j * omega[:, None, None] * damping
        load = self.reads(self.force_at, self.push)
        moved = np.linalg.solve(whole, np.broadcast_to(load[:, None], (len(omega), 6, 1)).astype(complex))[..., 0]
        return np.abs(moved @ self.reads(self.point, self.way))

    def frequencies(self) -> Array:
        """Natural frequencies [rad/s]."""
        mass, _, stiffness = self.matrices()
        return np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real))

    def loads(self) -> Array:
        """What each mount does to the body under its weight, in space (n, 3) [N]."""
        _, _, stiffness = self.matrices()
        moved = np.linalg.solve(stiffness, np.array([0, 0, -self.mass * GRAVITY, 0, 0, 0.0]))
        found = []
        for at, axes, value in zip(self.at, self.axes, self.k, strict=True):
            there = moved[:3] + np.cross(moved[3:], at - self.centre)
            found.append(-(axes.T @ np.diag(value) @ axes) @ there)
        return np.array(found)

    def document(self) -> dict[str, Any]:
        """The same as a problem file."""
        t = self.tensor
        moments = {"xx": t[0, 0], "yy": t[1, 1], "zz": t[2, 2], "xy": -t[0, 1], "yz": -t[1, 2], "zx": -t[0, 2]}
        mounts = {}
        for i, (at, axes) in enumerate(zip(self.at, self.axes, strict=True)):
            mounts[f"m{i}"] = {
                "between": ["body", "ground"],
                "at": lengths(at),
                "stiffness": [f"{one!r} N/m" for one in self.k[i].tolist()],
                "damping": [f"{one!r} N s/m" for one in self.c[i].tolist()],
                "direction": axes[2].tolist(),
                "across": axes[0].tolist(),
            }
        return {
            "title": "random",
            "bodies": {
                "body": {
                    "mass": f"{self.mass!r} kg",
                    "motion": "space",
                    "centre": lengths(self.centre),
                    "inertia": {key: f"{float(one)!r} kg m2" for key, one in moments.items()},
                }
            },
            "points": {"eye": {"on": "body", "at": lengths(self.point)}},
            "mounts": mounts,
            "excitations": {
                "shaker": {
                    "kind": "force",
                    "on": "body",
                    "at": lengths(self.force_at),
                    "direction": self.push.tolist(),
                    "amplitude": "1 N",
                    "speed": "50 Hz",
                    "varies": "constant",
                }
            },
        }


def lengths(place: Array) -> list[str]:
    """A place as a file says it."""
    return [f"{one!r} m" for one in place.tolist()]


plants = st.builds(Plant, st.integers(0, 10_000), st.integers(4, 6))
"""Random machines on four to six mounts."""
