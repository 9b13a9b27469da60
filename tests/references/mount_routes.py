"""Problems of mounts solved a second time, without vibopt: six coordinates in numpy, designs by root finding.

All results are in SI; amplitudes are peak.
"""

from collections.abc import Callable
from math import cos, pi, radians, sin

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq, minimize_scalar

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
GRAVITY = 9.80665
UP = np.array([0.0, 0.0, 1.0])


def rpm(speed: float) -> float:
    """Angular speed in rad/s."""
    return speed * pi / 30.0


def cross_matrix(arm: Array) -> Array:
    """arm x ... as a matrix."""
    return np.array([[0.0, -arm[2], arm[1]], [arm[2], 0.0, -arm[0]], [-arm[1], arm[0], 0.0]])


def carried(at: Array, centre: Array) -> Array:
    """Displacement at a place from the six coordinates of a body, (3, 6)."""
    return np.hstack([np.eye(3), -cross_matrix(np.asarray(at, dtype=float) - centre)])


def block(axis: Array, along: complex, side: complex) -> Complex:
    """Stiffness of a mount in space, (3, 3)."""
    own = np.outer(axis, axis)
    return np.asarray(along * own + side * (np.eye(3) - own), dtype=complex)


def corners(x: float, y: float, z: float = 0.0) -> list[Array]:
    """Four places."""
    return [np.array([a * x, b * y, z]) for a in (1, -1) for b in (1, -1)]


class Body:
    """One body on mounts to the ground."""

    def __init__(self, mass: float, centre: Array, tensor: Array) -> None:
        self.mass, self.centre, self.tensor = mass, centre, tensor
        self.whole = np.zeros((6, 6))
        self.whole[:3, :3], self.whole[3:, 3:] = mass * np.eye(3), tensor

    def stiffness(self, places: list[Array], axes: list[Array], along: complex, side: complex) -> Complex:
        """Sum over the mounts, (6, 6)."""
        total = np.zeros((6, 6), dtype=complex)
        for at, axis in zip(places, axes, strict=True):
            rows = carried(at, self.centre)
            total += rows.T @ block(axis, along, side) @ rows
        return total

    def motion(self, stiffness: Complex, omega: float, load: Complex) -> Complex:
        """Six complex amplitudes."""
        return np.asarray(np.linalg.solve(stiffness - omega**2 * self.whole, load))


def peak(response: Callable[[float], float], low: float, high: float, points: int = 4001) -> float:
    """Greatest value over a range, from a fine grid and a search around its best."""
    grid = np.linspace(low, high, points)
    best = grid[int(np.argmax([response(one) for one in grid]))]
    step = grid[1] - grid[0]
    bounds = max(best - step, low), min(best + step, high)
    found = minimize_scalar(lambda one: -response(one), bounds=bounds, method="bounded", options={"xatol": 1e-12})
    return float(max(response(best), -found.fun))


def generator_set() -> dict[str, float | str]:
    """The force rises with the stiffness, so the softest that keeps the flange still enough is best."""
    body = Body(1850.0, np.array([0.10, 0.0, 0.45]), np.diag([310.0, 620.0, 590.0]))
    places, axes = corners(0.85, 0.4), [UP] * 4

    def held(k: float, eta: float = 0.12) -> Complex:
        return body.stiffness(places, axes, k * (1 + 1j * eta), 0.55 * k * (1 + 1j * eta))

    flange = carried(np.array([1.2, 0.3, 0.9]), body.centre)[1]
    torque = np.array([0, 0, 0, 400.0, 0, 0], dtype=complex)

    def moved(k: float) -> float:
        whole = held(k)
        return peak(lambda speed: abs(flange @ body.motion(whole, 2 * speed, torque)), 1.0, rpm(1500))

    k = float(brentq(lambda one: moved(one) - 2e-3, 0.5e6, 4e6, xtol=1e-2, rtol=1e-13))
    omega = rpm(1500)
    at = carried(np.array([-0.5, 0.0, 0.5]), body.centre)
    load = at.T @ (0.02 * omega**2 * np.array([0, 1, -1j]))
    force = held(k)[2] @ body.motion(held(k), omega, load)
    still = np.linalg.solve(held(k, 0.0).real, 1850.0 * GRAVITY * np.eye(6)[2])
    squares = np.linalg.eigvals(np.linalg.solve(body.whole, held(k, 0.0).real)).real
    loads = [k * carried(one, body.centre)[2] @ still for one in places]
    return {
        "status": "optimal",
        "variables.mounts.foot.stiffness": k,
        "goal": float(abs(force)),
        "limits.load.value": float(max(loads)),
        "limits.sag.value": float(still[2]),
        "measures.highest.value": float(np.sqrt(squares.max())),
    }


def focalised_engine() -> dict[str, float | str]:
    """Modes, travel and force of the engine as it is."""
    tensor = np.array([[9.0, 0, -2.2], [0, 19.0, 0], [-2.2, 0, 17.0]])
    body = Body(210.0, np.array([0.0, 0.0, 0.15]), tensor)
    lean = radians(40.0)
    places = [np.array([x, side * 0.28, 0.0]) for side in (1, -1) for x in (0.3, -0.35)]
    axes = [np.array([0.0, -side * sin(lean), cos(lean)]) for side in (1, -1) for _ in range(2)]

    def held(omega: float) -> Complex:
        return body.stiffness(places, axes, 420e3 + 500j * omega, 84e3 + 100j * omega)

    squares, shapes = np.linalg.eig(np.linalg.solve(body.whole, held(0.0).real))
    omega = np.sqrt(squares.real)
    order = np.argsort(omega)
    omega, shapes = omega[order], shapes.real[:, order]
    shares = shapes[3] * (body.whole @ shapes)[3] / np.einsum("im,ij,jm->m", shapes, body.whole, shapes)
    torque = np.array([0, 0, 0, 180.0, 0, 0], dtype=complex)

    def moved(speed: float) -> Complex:
        return body.motion(held(2 * speed), 2 * speed, torque)

    def side(speed: float) -> float:
        return float(abs(held(2 * speed)[1] @ moved(speed)))

    return {
        "status": "met",
        "measures.first.value": float(omega[0]),
        "measures.last.value": float(omega[-1]),
        "measures.gap.value": float(np.diff(omega).min()),
        "measures.roll.value": float(shares.max()),
        "measures.sideways.value": peak(side, rpm(700), rpm(5500)),
        "measures.idle.value": float(abs(moved(rpm(700))[3])),
    }


def _pump() -> Body:
    pieces = []
    for mass, x, long, wide in ((180.0, 0.45, 0.4, 0.5), (150.0, -0.35, 0.6, 0.34)):
        side = mass * (3 * (wide / 2) ** 2 + long**2) / 12
        pieces.append((mass, np.array([x, 0, 0.35]), np.diag([mass * (wide / 2) ** 2 / 2, side, side])))
    box = 90.0 / 12 * np.diag([0.6**2 + 0.1**2, 1.6**2 + 0.1**2, 1.6**2 + 0.6**2])
    pieces.append((90.0, np.array([0, 0, 0.06]), box))
    mass = sum(one[0] for one in pieces)
    centre = sum((one[0] * one[1] for one in pieces), np.zeros(3)) / mass
    tensor = np.zeros((3, 3))
    for own, at, turn in pieces:
        arm = cross_matrix(at - centre)
        tensor += turn - own * arm @ arm
    return Body(mass, centre, tensor)


def pump_flange() -> dict[str, float | str]:
    """For each set of places the force over the stiffness, within what pipe and sag allow, searched finely."""
    body, omega = _pump(), rpm(2950)
    at = carried(np.array([0.5, 0, 0.35]), body.centre)
    flange = carried(np.array([0.75, 0, 0.35]), body.centre)[2]
    turning = np.array([0, 1, -1j])
    best = {}
    for number, x in enumerate((0.4, 0.55, 0.7), start=1):
        unit = body.stiffness(corners(x, 0.25), [UP] * 4, 1.0, 0.6)

        def held(k: float, w: float, unit: Complex = unit) -> Complex:
            c = 3e3
            whole: Complex = (k + 1j * w * c) * unit
            return whole

        def pipe(k: float, held: Callable[[float, float], Complex] = held) -> float:
            return peak(
                lambda w: abs(flange @ body.motion(held(k, w), w, at.T @ (0.04 * w**2 * turning))), 1.0, omega, 801
            )

        def sag(k: float, held: Callable[[float, float], Complex] = held) -> float:
            return float(abs(flange @ np.linalg.solve(held(k, 0.0).real, body.mass * GRAVITY * np.eye(6)[2])))

        def force(k: float, held: Callable[[float, float], Complex] = held) -> float:
            whole = held(k, omega)
            return float(abs(whole[2] @ body.motion(whole, omega, at.T @ (0.04 * omega**2 * turning))))

        low = float(brentq(lambda k, sag=sag: sag(k) - 6e-3, 5e4, 3e6, xtol=1e-6, rtol=1e-14))
        if pipe(low) > 0.3e-3:
            grid = np.linspace(low, 3e6, 60)
            good = next((k for k in grid if pipe(k) <= 0.3e-3), None)
            if good is None:
                continue
            low = float(brentq(lambda k, pipe=pipe: pipe(k) - 0.3e-3, low, good, xtol=1e-3, rtol=1e-13))
        best[number] = force(low), low
    number = min(best, key=lambda one: best[one][0])
    return {
        "status": "optimal",
        "goal": best[number][0],
        "variables.mounts.foot.stiffness": best[number][1],
    }


def pump_with_absorber() -> dict[str, float | str]:
    """A slide answers along y with its apparent mass and across with its own; for each damping the spring that makes
    the peak as high as the end, then the damping with the lowest of both.
    """
    body, mass, end = _pump(), 25.0, rpm(1500)
    held = body.stiffness(corners(0.7, 0.25), [UP] * 4, 0.9e6, 0.54e6)
    dash = body.stiffness(corners(0.7, 0.25), [UP] * 4, 1.2e3, 0.72e3)
    flange = carried(np.array([0.75, 0, 0.35]), body.centre)
    load = carried(np.array([0.5, 0, 0.35]), body.centre).T @ np.array([0, 1, -1j])

    def moved(w: float, own: float, zeta: float) -> tuple[Complex, complex]:
        pulls = mass * (own**2 + 2j * zeta * own * w)
        part = pulls / (pulls - w**2 * mass)
        whole = held + 1j * w * dash - w**2 * (flange.T @ np.diag([mass, mass * part, mass]) @ flange)
        six = body.motion(whole, w, 0.04 * w**2 * load)
        return six, complex(flange[1] @ six) * (part - 1.0)

    def side(w: float, own: float, zeta: float) -> float:
        return float(abs(flange[1] @ moved(w, own, zeta)[0]))

    def level(own: float, zeta: float) -> float:
        return peak(lambda w: side(w, own, zeta), rpm(900), rpm(1200), 31)

    def tuned(zeta: float) -> float:
        return float(brentq(lambda own: level(own, zeta) - side(end, own, zeta), 120.0, 140.0, xtol=1e-11))

    bounds, fine = (0.24, 0.28), {"xatol": 1e-9}
    zeta = float(minimize_scalar(lambda z: side(end, tuned(z), z), bounds=bounds, method="bounded", options=fine).x)
    own = tuned(zeta)
    rows, heavy = np.zeros((7, 7)), np.zeros((7, 7))
    heavy[:6, :6], rows[:6, :6], rows[6, 6] = body.whole, held.real, mass * own**2
    for k in range(3):
        row = np.append(flange[k], float(k == 1))
        heavy += mass * np.outer(row, row)
    squares = np.linalg.eigvals(np.linalg.solve(heavy, rows)).real
    sag = np.linalg.solve(held.real, GRAVITY * (body.mass * np.eye(6)[2] + mass * flange[2]))
    loads = [0.9e6 * carried(one, body.centre)[2] @ sag for one in corners(0.7, 0.25)]

    def floor(w: float) -> float:
        return float(abs((held + 1j * w * dash)[1] @ moved(w, own, zeta)[0]))

    return {
        "status": "optimal",
        "goal": side(end, own, zeta),
        "variables.absorbers.slide.frequency": own,
        "variables.absorbers.slide.damping_ratio": zeta,
        "limits.travel.value": peak(lambda w: abs(moved(w, own, zeta)[1]), rpm(600), end),
        "measures.load.value": float(max(loads)),
        "measures.floor.value": peak(floor, rpm(600), end),
        "measures.highest.value": float(np.sqrt(squares.max())),
    }


def inertia_base() -> dict[str, float | str]:
    """Thirteen coordinates: two bodies in space and a floor; the block as heavy as the floor needs."""
    centre, low = np.array([0.12, 0, 0.55]), np.array([0.0, 0, -0.25])
    omega = rpm(985)

    def moved(mass: float) -> Complex:
        m = np.zeros((13, 13))
        m[:3, :3], m[3:6, 3:6] = 900.0 * np.eye(3), np.diag([95.0, 170.0, 150.0])
        m[6:9, 6:9] = mass * np.eye(3)
        m[9:12, 9:12] = mass / 12 * np.diag([1.4**2 + 0.5**2, 2.2**2 + 0.5**2, 2.2**2 + 1.4**2])
        m[12, 12] = 12e3
        d = np.zeros((13, 13), dtype=complex) - omega**2 * m
        d[12, 12] += 38.373e6 + 27e3j * omega
        for at in corners(0.5, 0.3):
            rows = np.zeros((3, 13))
            rows[:, :6], rows[:, 6:12] = carried(at, centre), -carried(at, low)
            z = 40e6 + 20e3j * omega
            d += rows.T @ block(UP, z, 0.5 * z) @ rows
        for at in corners(0.9, 0.6, -0.5):
            rows = np.zeros((3, 13))
            rows[:, 6:12], rows[2, 12] = carried(at, low), -1.0
            z = 350e3 + 1.5e3j * omega
            d += rows.T @ block(UP, z, 0.8 * z) @ rows
        load = np.zeros(13, dtype=complex)
        load[:6] = carried(np.array([0.12, 0, 0.7]), centre).T @ (4242.6 / np.sqrt(2) * np.array([1.0, 0, 1.0]))
        return np.asarray(np.linalg.solve(d, load))

    mass = float(brentq(lambda one: abs(moved(one)[12]) - 3.5e-6, 500.0, 6000.0, xtol=1e-9, rtol=1e-14))
    return {
        "status": "optimal",
        "goal": mass,
        "limits.compressor.value": float(abs(moved(mass)[0])),
    }


ROUTES: dict[str, Callable[[], dict[str, float | str]]] = {
    "generator_set": generator_set,
    "focalised_engine": focalised_engine,
    "pump_flange": pump_flange,
    "pump_with_absorber": pump_with_absorber,
    "inertia_base": inertia_base,
}
