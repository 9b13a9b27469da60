"""White noise as one system of first order, z' = a z + b w, y = c z: of joints without mass, of a base's displacement.

With v = x' + M^-1 C_b u the derivative of the base's motion u drops out of the equations of motion.  A reading
y = c z + d u is finite where d is nothing; each derivative of it is c A z + c b u + d u', finite as long as that holds
again.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms.peak_in_time import matrices, reading
from vibopt.mechanics.joints import first_order
from vibopt.mechanics.model import DAMPING, INERTIA, Model
from vibopt.mechanics.modes import rigid_count
from vibopt.records import dataclass
from vibopt.signals import Noise, Output

Numbers = np.ndarray[Any, np.dtype[Any]]
_NOTHING = 1e-11
"""Part of its own size below which a share of the noise that is read at once is rounding."""
LIGHT = 1e-6
"""Damping ratio up to which a Lyapunov equation loses digits: decay is what dampers take of each motion instead."""
_RESIDUE = 1e-9


@dataclass(frozen=True, slots=True)
class States:
    """z' = a z + b w and y = c z, (N, N) and (N,), with time counted in 1 / `rate` [rad/s].

    places
        The free coordinates of a free motion from the states, times any number, (n_free, N).
    """

    a: Numbers
    b: Numbers
    c: Numbers
    places: Numbers
    rate: float = 1.0

    def turned(self, model: Model, p: FloatArray) -> tuple[Numbers, Numbers]:
        """Rates (N,) and shapes (N, N) of free motion; what hardly decays does by what dampers take of its motion."""
        rates, shapes = np.linalg.eig(self.a)
        moved, rows = self.places @ shapes, model.vectors[:, : model.n_free]
        felt = np.abs(rows @ moved)
        felt[felt <= _NOTHING * (np.abs(rows) @ np.abs(moved))] = 0.0
        taken, heavy = (p * (model.kinds == kind) @ felt**2 for kind in (DAMPING, INERTIA))
        with np.errstate(divide="ignore", invalid="ignore"):
            slow = 1j * rates.imag - 0.5 * taken / heavy / self.rate
        return np.where(np.abs(rates.real) <= LIGHT * np.abs(rates), slow, rates), shapes


def under_force(model: Model, output: Output, noise: Noise, p: Numbers, ride: FloatArray | None) -> States | None:
    """Under a force, or relative to a base with which the machine can `ride` (n_free,); None where infinite."""
    n = model.n_free
    mass, damping, stiffness = (each[:n, :n] for each in matrices(model, p))
    one = first_order(mass, damping, stiffness, n)
    read = reading(model, output, p)
    load, direct = noise.vector[:n], 0.0
    if ride is not None:
        own = p * (model.kinds == INERTIA) * ~model.inerters
        load = -(model.vectors[:, :n].T * own) @ (model.vectors[:, :n] @ ride)
        direct = float(output.row[:n] @ ride) if output.power == 2 else 0.0
    b, c = one.struck @ load, np.zeros(len(one.rates), dtype=one.rates.dtype)
    through: Any = direct
    size = abs(direct)
    for order, row in enumerate((read.row, read.rates, read.inertia), start=read.power):
        along = row[:n] @ one.places
        for left in range(order, 0, -1):
            felt = along @ b
            if left > 1 and abs(felt) > _NOTHING * float(np.abs(along) @ np.abs(b)):
                return None  # its derivative is read
            through, size = through + felt * (left == 1), size + float(np.abs(along) @ np.abs(b)) * (left == 1)
            along = along @ one.rates
        c = c + along
    return None if abs(through) > _NOTHING * size else States(one.rates, b, c, one.places[:n])


def under_displacement(model: Model, output: Output, noise: Noise, p: Numbers) -> States | None:
    """Where a base's displacement u is the noise: the states less what its rate adds; None where infinite."""
    n = model.n_free
    one = first_order(*matrices(model, p), n)
    own, bases = one.own, model.n_coords - n
    read, vector = reading(model, output, p), noise.vector[n:]
    row = read.row @ one.places + (read.rates @ one.places) @ one.rates
    a, at, fast = one.rates[:own, :own], one.rates[:own, own : own + bases] @ vector, one.rates[:own, own + bases :]
    kick = fast @ vector
    b, c = at + a @ kick, row[:own]
    direct = [row[own : own + bases] @ vector + c @ kick, row[own + bases :] @ vector]
    sizes = [np.abs(row[own : own + bases] * vector).sum() + np.abs(c * kick).sum(), np.abs(direct[1])]
    if read.inertia.any() or abs(direct[1]) > _NOTHING * sizes[1] or abs(direct[0]) > _NOTHING * sizes[0]:
        return None
    for _ in range(output.power):
        if abs(c @ b) > _NOTHING * np.abs(c * b).sum():
            return None
        c = a.T @ c
    return States(a, b, c, one.places[:n, :own])


def decaying(states: States, model: Model, p: FloatArray) -> States | None:
    """The states that die away; None where one that does not is both shaken and seen."""
    from scipy.linalg import schur, solve_sylvester

    a, b, c, rates = states.a, states.b, states.c, states.turned(model, p)[0]
    lasting = rates.real >= 0.0
    lasting[np.argsort(np.abs(rates))[: rigid_count(model, p)]] = True
    if not lasting.any():
        return states

    def lasts(rate: Any) -> bool:
        return bool(lasting[np.abs(rates - rate).argmin()])

    sorted_by: Any = schur  # its stubs know no function of a complex number
    form, turn, count = sorted_by(a.astype(complex), output="complex", sort=lasts)
    load, row, places = turn.conj().T @ b, c @ turn, states.places @ turn
    if np.abs(row[:count]).max(initial=0.0) <= _RESIDUE * np.linalg.norm(np.abs(c) @ np.abs(turn)):
        beside = solve_sylvester(form[:count, :count], -form[count:, count:], -form[:count, count:])
        return States(form[count:, count:], load[count:], row[count:], places[:, count:] + places[:, :count] @ beside)
    form, turn, count = sorted_by(a.astype(complex), output="complex", sort=lambda rate: not lasts(rate))
    load, row, places = turn.conj().T @ b, c @ turn, states.places @ turn
    if np.abs(load[count:]).max(initial=0.0) > _RESIDUE * np.linalg.norm(np.abs(turn.conj().T) @ np.abs(b)):
        return None
    return States(form[:count, :count], load[:count], row[:count], places[:, :count])
