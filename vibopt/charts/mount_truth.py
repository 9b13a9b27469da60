"""What is true of choices of parts: loads, natural frequencies and peaks over the whole range, in plain numpy."""

from __future__ import annotations

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray, IntArray
from vibopt.charts.mount_machine import GRAVITY, Machine, Shelf

_GRID, _PEAKS, _STEPS = 40, 3, 60
_ROUNDING = 1e-9
"""Part of a resonance frequency within which an undamped mode counts as on it."""


def prices(machine: Machine, shelf: Shelf, chosen: IntArray) -> FloatArray:
    """Price of all mounts, (n_choices,)."""
    counts = np.array([len(places) for places in machine.groups])
    return np.asarray(shelf.price[chosen] @ counts)


def broken(machine: Machine, shelf: Shelf, chosen: IntArray) -> FloatArray:
    """Greatest violation of any limit, as a part of its bound; zero or less where all hold.

    Parameters
    ----------
    machine, shelf
        What is asked.
    chosen
        Part of each group, shape (n_choices, n_groups).

    Returns
    -------
    FloatArray
        Shape (n_choices,); infinite where a machine cannot stand.
    """
    mass, dynamic, static = machine.matrices(shelf, chosen)
    worst = np.maximum(loads(machine, shelf, chosen, static), modes(machine, mass, dynamic))
    asked = np.flatnonzero(np.isfinite(worst))
    stiff = dynamic[asked]
    if machine.floor is not None:
        worst[asked] = np.maximum(worst[asked], _over(floor_force(machine, mass, stiff), machine.floor))
    if machine.sway is not None:
        worst[asked] = np.maximum(worst[asked], _over(peaks(machine, mass, stiff), machine.sway))
    return worst


def _over(value: FloatArray, bound: float) -> FloatArray:
    return np.nan_to_num(value / bound - 1.0, nan=np.inf, posinf=np.inf)


def loads(machine: Machine, shelf: Shelf, chosen: IntArray, static: FloatArray) -> FloatArray:
    """Greatest violation of a rating, (n_choices,); infinite where the mounts leave a motion free."""
    weight = np.zeros(len(machine.kept))
    weight[machine.kept.index(2)] = machine.mass * GRAVITY
    worst = np.full(len(chosen), -np.inf)
    held = np.array([np.linalg.matrix_rank(one, hermitian=True) == len(weight) for one in _scaled(static)])
    worst[~held] = np.inf
    sag = np.linalg.solve(static[held], np.broadcast_to(weight[:, None], (int(held.sum()), len(weight), 1)))[..., 0]
    worst[held] = rated(machine, shelf, chosen[held], sag)
    return worst


def rated(machine: Machine, shelf: Shelf, chosen: IntArray, sag: FloatArray) -> FloatArray:
    """Greatest violation of a rating, (n_choices,), where the coordinates sag so far (n_choices, n)."""
    worst = np.full(len(chosen), -np.inf)
    for group, rows in enumerate(machine.falls()):
        carried = (sag @ np.array(rows).T) * shelf.static[chosen[:, group], None]
        most, least = shelf.most[chosen[:, group]], shelf.least[chosen[:, group]]
        below = (least - carried.min(axis=1)) / np.where(least > 0.0, least, most)
        worst = np.maximum(worst, np.maximum(carried.max(axis=1) / most - 1.0, below))
    return worst


def _scaled(stiff: FloatArray) -> FloatArray:
    """With ones on the diagonal, so that metres and radians weigh alike."""
    own = np.sqrt(np.maximum(np.einsum("nii->ni", stiff), 1e-300))
    return np.asarray(stiff / own[:, :, None] / own[:, None, :])


def modes(machine: Machine, mass: FloatArray, dynamic: ComplexArray) -> FloatArray:
    """Greatest violation of the limits on natural frequencies, (n_choices,)."""
    if machine.highest is None and machine.apart is None:
        return np.full(len(dynamic), -np.inf)
    return beside(machine, natural(mass, dynamic) / (2.0 * np.pi))


def beside(machine: Machine, own: FloatArray) -> FloatArray:
    """The same of natural frequencies that rise (n_choices, n) [Hz]."""
    worst = np.full(len(own), -np.inf)
    if machine.highest is not None:
        worst = np.maximum(worst, own[:, -1] / machine.highest - 1.0)
    if machine.apart is not None:
        worst = np.maximum(worst, 1.0 - np.diff(own, axis=1).min(axis=1) / machine.apart)
    return worst


def natural(mass: FloatArray, dynamic: ComplexArray) -> FloatArray:
    """Undamped natural frequencies, rising, (n_choices, n) [rad/s]; infinite along coordinates without inertia."""
    with np.errstate(divide="ignore"):
        slow = np.linalg.eigvals(np.linalg.solve(dynamic.real, np.broadcast_to(mass, dynamic.shape)))
        return np.sort(1.0 / np.sqrt(np.maximum(slow.real, 0.0)), axis=1)


def motion(machine: Machine, mass: FloatArray, dynamic: ComplexArray, speeds: FloatArray) -> ComplexArray:
    """Amplitudes (n_choices, n_speeds, n) at speeds (n_choices, n_speeds) [rad/s]."""
    stiff = dynamic[:, None] - (speeds**2)[..., None, None] * mass
    force = machine.push() * ((speeds / machine.omega) ** 2)[..., None]
    try:
        return np.asarray(np.linalg.solve(stiff, force[..., None].astype(complex))[..., 0])
    except np.linalg.LinAlgError:  # exactly on an undamped resonance
        return np.asarray(
            np.linalg.solve(stiff + 1e-14j * dynamic.real[:, None], force[..., None].astype(complex))[..., 0]
        )


def floor_force(machine: Machine, mass: FloatArray, dynamic: ComplexArray) -> FloatArray:
    """Force of all mounts along z at full speed, (n_choices,) [N]."""
    u = motion(machine, mass, dynamic, np.full((len(dynamic), 1), machine.omega))[:, 0]
    return np.asarray(np.abs((dynamic[:, machine.kept.index(2)] * u).sum(axis=-1)))


def size(machine: Machine, mass: FloatArray, dynamic: ComplexArray, speeds: FloatArray) -> FloatArray:
    """Amplitude of the limited displacement (n_choices, n_speeds) [m]."""
    return np.asarray(np.abs(motion(machine, mass, dynamic, speeds) @ machine.reads()))


def peaks(machine: Machine, mass: FloatArray, dynamic: ComplexArray) -> FloatArray:
    """Greatest displacement from standstill to full speed, (n_choices,) [m].

    Looked for round every natural frequency and on a grid; the three highest places are made exact by golden section.
    Infinite with an undamped mode in the range that force and row both reach.
    """
    speeds = _places(machine, mass, dynamic)
    values = size(machine, mass, dynamic, speeds)
    inner = np.pad(values, ((0, 0), (1, 1)), constant_values=-1.0)
    hills = np.where((values >= inner[:, :-2]) & (values >= inner[:, 2:]), values, -1.0)
    best: FloatArray = values.max(axis=1, initial=0.0)
    for place in np.argsort(-hills, axis=1)[:, :_PEAKS].T:
        low = np.take_along_axis(speeds, np.maximum(place - 1, 0)[:, None], 1)[:, 0]
        high = np.take_along_axis(speeds, np.minimum(place + 1, speeds.shape[1] - 1)[:, None], 1)[:, 0]
        best = np.maximum(best, _golden(machine, mass, dynamic, low, high))
    return best


def _places(machine: Machine, mass: FloatArray, dynamic: ComplexArray) -> FloatArray:
    """Speeds to look at, rising, (n_choices, n_speeds): a grid, and a swarm round every natural frequency."""
    top = machine.omega
    own = natural(mass, dynamic)
    own = np.where(np.isfinite(own), own, top)
    swarm = 1.0 + np.array([-0.1, -0.03, -0.01, -0.003, 0.0, 0.003, 0.01, 0.03, 0.1])
    near = np.minimum((own[:, :, None] * swarm).reshape(len(own), own.shape[1] * len(swarm)), top)
    grid = np.broadcast_to(np.linspace(0.0, top, _GRID + 1)[1:], (len(own), _GRID))
    return np.sort(np.hstack([near, grid]), axis=1)


def _golden(machine: Machine, mass: FloatArray, dynamic: ComplexArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """Greatest value between speeds low and high (n_choices,), with one hill between them."""
    part = (np.sqrt(5.0) - 1.0) / 2.0
    left, right = high - part * (high - low), low + part * (high - low)
    best = np.zeros(len(low))
    for _ in range(_STEPS // 2):
        pair = size(machine, mass, dynamic, np.stack([left, right], axis=1))
        best = np.maximum(best, pair.max(axis=1))
        down = pair[:, 0] >= pair[:, 1]
        low, high = np.where(down, low, left), np.where(down, right, high)
        left, right = high - part * (high - low), low + part * (high - low)
    return best


def every_choice(machine: Machine, shelf: Shelf) -> IntArray:
    """All choices (n_parts ** n_groups, n_groups)."""
    return np.stack(np.meshgrid(*[np.arange(len(shelf))] * len(machine.groups), indexing="ij"), -1).reshape(
        -1, len(machine.groups)
    )


def least_price(machine: Machine, shelf: Shelf) -> tuple[float, IntArray | None]:
    """Least price of all choices that hold, and the choice; infinite and None where none does.

    What the loads and natural frequencies forbid is not asked for its peak.
    """
    chosen = every_choice(machine, shelf)
    if not len(chosen):
        return np.inf, None
    mass, dynamic, static = machine.matrices(shelf, chosen)
    sound = np.maximum(loads(machine, shelf, chosen, static), modes(machine, mass, dynamic)) <= _ROUNDING
    chosen = chosen[sound]
    good = chosen[broken(machine, shelf, chosen) <= _ROUNDING] if len(chosen) else chosen
    if not len(good):
        return np.inf, None
    price = prices(machine, shelf, good)
    return float(price.min()), np.asarray(good[int(price.argmin())])
