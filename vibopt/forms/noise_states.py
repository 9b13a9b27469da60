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
from vibopt.mechanics.joints import condensed, first_order
from vibopt.mechanics.model import DAMPING, INERTIA, STIFFNESS, Model
from vibopt.mechanics.modes import rigid_count
from vibopt.records import dataclass
from vibopt.signals import Noise, Output

Numbers = np.ndarray[Any, np.dtype[Any]]
_NOTHING = 1e-11
"""Part of its own size below which a share of the noise that is read at once is rounding."""
LIGHT = 1e-6
"""Damping ratio up to which a Lyapunov equation loses digits: decay is what dampers take of each motion instead."""
_RESIDUE, _SLOW = 1e-9, 1e-9
"""Part of its size below which a share of what lasts, and the answer to a slow drift of a base, is rounding."""


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

    def turned(self, model: Model, p: FloatArray) -> tuple[Numbers, Numbers, Numbers]:
        """Rates of free motion (N,), the same where what hardly decays does by what dampers take, and shapes (N, N)."""
        rates, shapes = np.linalg.eig(self.a)
        moved, rows = self.places @ shapes, model.vectors[:, : model.n_free]
        felt = np.abs(rows @ moved)
        felt[felt <= _NOTHING * (np.abs(rows) @ np.abs(moved))] = 0.0
        taken, heavy = (p * (model.kinds == kind) @ felt**2 for kind in (DAMPING, INERTIA))
        with np.errstate(divide="ignore", invalid="ignore"):
            slow = 1j * rates.imag - 0.5 * taken / heavy / self.rate
        return rates, np.where(np.abs(rates.real) <= LIGHT * np.abs(rates), slow, rates), shapes


def under_force(model: Model, output: Output, noise: Noise, p: Numbers, ride: FloatArray | None) -> States | None:
    """Under a force, or an accelerated base, with which the machine can `ride` (n_free,); None where infinite.

    Where it cannot, the states are those beside what follows the base: where it is, u, and its rate v.
    """
    n, u, load, direct = model.n_free, noise.vector[model.n_free :], noise.vector[: model.n_free], 0.0
    beside = ride is None and bool(u.any())
    end = model.n_coords if beside else n
    mass, damping, stiffness = (each[:end, :end] for each in matrices(model, p))
    one, read = first_order(mass, damping, stiffness, n), reading(model, output, p)
    if ride is not None:
        own = p * (model.kinds == INERTIA) * ~model.inerters
        load = -(model.vectors[:, :n].T * own) @ (model.vectors[:, :n] @ ride)
        direct = float(output.row[:n] @ ride) if output.power == 2 else 0.0
    b = one.shaken @ u if beside else one.struck @ load
    c = np.zeros(len(one.rates), dtype=one.rates.dtype)
    through: Any = direct
    size = abs(direct)
    for order, row in enumerate((read.row, read.rates, read.inertia), start=read.power):
        along = row[:end] @ one.places
        for left in range(order, 0, -1):
            felt = along @ b
            if left > 1 and abs(felt) > _NOTHING * float(np.abs(along) @ np.abs(b)):
                return None  # its derivative is read
            through, size = through + felt * (left == 1), size + float(np.abs(along) @ np.abs(b)) * (left == 1)
            along = along @ one.rates
        c = c + along
    if abs(through) > _NOTHING * size:
        return None
    if beside:
        at, (by_place, by_rate) = condensed(mass, damping, stiffness, n), _following(model, p, u)
        for far, near, *bases in ((by_place, 0.0 * by_place, u, 0.0 * u), (by_rate, by_place, 0.0 * u, u)):
            led = np.concatenate([far[at.kept], near[at.kept[: at.heavy]], *bases])
            most = np.concatenate([np.full(at.n, np.abs(far).max()), np.abs(led[at.n :])])
            if abs(led @ c) > _SLOW * (most @ np.abs(c)):
                return None
        b = b - led
    return States(one.rates[: one.own, : one.own], b[: one.own], c[: one.own], one.places[:n, : one.own])


def _following(model: Model, p: Numbers, vector: FloatArray) -> tuple[Numbers, Numbers]:
    """How free coordinates (n_free,) follow where bases are, and their rate, if neither ever changes quickly.

    What no spring holds follows by its dampers.
    """
    n = model.n_free
    mass, damping, stiffness = matrices(model, p)
    turned, held = held_first(model, np.eye(n), p)
    basis, loose = turned[:, :held], turned[:, held:]

    def resting(load: Numbers) -> Numbers:
        return -basis @ np.linalg.solve(basis.T @ stiffness[:n, :n] @ basis, basis.T @ load)

    def dragged(load: Numbers) -> Numbers:
        return -loose @ np.linalg.lstsq(loose.T @ damping[:n, :n] @ loose, loose.T @ load, rcond=None)[0]

    place = resting(stiffness[:n, n:] @ vector)
    place = place + dragged(damping[:n, :n] @ place + damping[:n, n:] @ vector)
    rate = resting(damping[:n, :n] @ place + damping[:n, n:] @ vector)
    return place, rate + dragged(damping[:n, :n] @ rate + mass[:n, :n] @ place + mass[:n, n:] @ vector)


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

    a, b, c, (rates, known, _) = states.a, states.b, states.c, states.turned(model, p)
    lasting = known.real >= 0.0
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


def held_first(model: Model, basis: FloatArray, p: Numbers) -> tuple[FloatArray, int]:
    """The basis turned so that motions held by springs come first, and their number."""
    springs = model.vectors[(model.kinds == STIFFNESS) & (p.real > 0.0), : model.n_free] @ basis
    sizes = np.linalg.norm(springs, axis=1, keepdims=True)
    rows = springs[sizes[:, 0] > 0.0] / sizes[sizes[:, 0] > 0.0]
    if not len(rows):
        return basis, 0
    _, values, turned = np.linalg.svd(rows)
    held = int((values > _NOTHING * values[0]).sum())
    return basis @ turned.T, held
