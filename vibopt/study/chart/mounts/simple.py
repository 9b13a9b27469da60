"""The road that a script takes: eigenvalues, a list of speeds and numpy's solver, and no question whether it may."""

from __future__ import annotations

import numpy as np

from vibopt.forms import FloatArray, IntArray
from vibopt.study.chart.mounts.machine import GRAVITY, Machine
from vibopt.study.chart.mounts.shelf import Shelf


def missed(machine: Machine, shelf: Shelf, chosen: IntArray, speeds: FloatArray) -> FloatArray:
    """Greatest violation as a script would have it, as a part of the bound.

    Parameters
    ----------
    machine, shelf
        What is asked.
    chosen
        Part of each group, shape (n_choices, n_groups).
    speeds
        Speeds at which the displacement is looked at, shape (n_speeds,) [rad/s].

    Returns
    -------
    FloatArray
        Shape (n_choices,).

    Raises
    ------
    numpy.linalg.LinAlgError
        A matrix is singular to the last digit.
    """
    mass, dynamic, static = machine.matrices(shelf, chosen)
    up, n = machine.kept.index(2), len(mass)
    worst = np.full(len(chosen), -np.inf)
    weight = np.zeros((len(chosen), n, 1))
    weight[:, up] = machine.mass * GRAVITY
    sag = np.linalg.solve(static, weight)[..., 0]
    for group, rows in enumerate(machine.falls()):
        carried = (sag @ np.array(rows).T) * shelf.static[chosen[:, group], None]
        most, least = shelf.most[chosen[:, group]], shelf.least[chosen[:, group]]
        own = (least - carried.min(axis=1)) / np.where(least > 0.0, least, most)
        worst = np.maximum(worst, np.maximum(carried.max(axis=1) / most - 1.0, own))
    if machine.highest is not None or machine.apart is not None:
        values = np.sort(np.linalg.eigvals(np.linalg.solve(mass, dynamic.real)).real, axis=1)
        own = np.sqrt(np.maximum(values, 0.0)) / (2.0 * np.pi)
        if machine.highest is not None:
            worst = np.maximum(worst, own[:, -1] / machine.highest - 1.0)
        if machine.apart is not None:
            worst = np.maximum(worst, 1.0 - np.diff(own, axis=1).min(axis=1) / machine.apart)
    if machine.floor is not None or machine.sway is not None:
        every = np.append(speeds, machine.omega)
        stiff = dynamic[:, None] - (every**2)[:, None, None] * mass
        force = (machine.push() * ((every / machine.omega) ** 2)[:, None])[..., None].astype(complex)
        u = np.linalg.solve(stiff, np.broadcast_to(force, (*stiff.shape[:-1], 1)))[..., 0]
        if machine.floor is not None:
            worst = np.maximum(worst, np.abs((dynamic[:, up] * u[:, -1]).sum(axis=-1)) / machine.floor - 1.0)
        if machine.sway is not None:
            worst = np.maximum(worst, np.abs(u @ machine.reads()).max(axis=1) / machine.sway - 1.0)
    return worst


def grid(machine: Machine, count: int) -> FloatArray:
    """Equal steps up to full speed, (count,) [rad/s]."""
    return np.linspace(0.0, machine.omega, count + 1)[1:]
