"""White noise on machines that have joints without mass, or a base that moves beside ground: as states z' = a z + b w.

The mean square of a reading y = c z follows from a Lyapunov equation (`mean_square`).  Here a machine, its excitation
and its reading become a, b and c (`States`), and what makes the mean square infinite is told:

- A reading that holds the white noise itself.  The derivative of r z is r a z + r b w, so r b must be nothing for each
  derivative that the reading takes.
- A base of white acceleration drifts away without end.  Its drift must not be read; the rest is counted from where
  the machine would be if the base moved slowly.
- A motion that lasts, rigid or without damping, that is both shaken and read (`decaying`).

A white displacement u of a base brings its rate u' into the equations, z' = a z + g u + h u'.  The states s = z - h u
are free of it: s' = a s + (g + a h) u.

Notes
-----
Kwakernaak and Sivan, Linear Optimal Control Systems (1972), section 1.11, on white noise through linear systems.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibopt.arrays import BoolArray, FloatArray
from vibopt.forms.peak_in_time import matrices, reading
from vibopt.mechanics.joints import FirstOrder, first_order
from vibopt.mechanics.model import DAMPING, INERTIA, STIFFNESS, Model
from vibopt.mechanics.modes import rigid_count
from vibopt.records import dataclass
from vibopt.signals import Noise, Output

if TYPE_CHECKING:
    from vibopt.mechanics.readout import Reading

Numbers = np.ndarray[Any, np.dtype[Any]]
"""Real, or complex with the imaginary part as a slope; after `decaying` complex."""
_ROUNDING = 1e-11
"""Part of the sizes in a sum below which what is left of it is rounding."""
_LIGHT, _SWINGS, _DIGITS = 1e-6, 1e-2, 2e-4
"""Damping ratio up to which eigenvalues lose the decay: it is told by what dampers take of a motion instead; up to
which it is also where the decay is less than a part of the fastest rate, whose rounding it has."""
_UNSEEN, _UNMOVED = 1e-9, 1e-9
"""Part of its size below which a share of what lasts, and of the drift of a base, is neither shaken nor read."""


class Eigen(NamedTuple):
    """Free motions e^(rate t) of states.

    rates, shapes
        Eigenvalues (N,) [`rate` of the states] and vectors (N, N) of a.
    decays
        The rates; of those that are `slow` the real part is that of energy, and exactly 0 without dampers.
    """

    rates: Numbers
    decays: Numbers
    shapes: Numbers


def slow(rates: Numbers) -> BoolArray:
    """Which rates (N,) have lost digits of their decay, for it is so little beside themselves or the fastest."""
    sizes = np.abs(rates)
    beside = np.minimum(_SWINGS * sizes, _DIGITS * sizes.max(initial=0.0))
    return np.asarray(np.abs(rates.real) <= np.maximum(_LIGHT * sizes, beside))


@dataclass(frozen=True, slots=True)
class States:
    """z' = a z + b w under white noise w, read as y = c z; a (N, N), b and c (N,), time in 1 / `rate` [rad/s].

    places
        Free coordinates of a free motion from the states, (n_free, N), up to a factor for all.
    """

    a: Numbers
    b: Numbers
    c: Numbers
    places: Numbers
    rate: float = 1.0

    def eigen(self, model: Model, p: FloatArray) -> Eigen:
        """Free motions of the states of a model at coefficients p (n_terms,).

        Re(rate) of a motion x that decays slowly is -1/2 sum_k c_k |b_k x|^2 / sum_k m_k |b_k x|^2, over the dampers
        c_k and masses m_k of the model.
        """
        rates, shapes = np.linalg.eig(self.a)
        motions, terms = self.places @ shapes, model.vectors[:, : model.n_free]
        strain = np.abs(terms @ motions)
        strain[strain <= _ROUNDING * (np.abs(terms) @ np.abs(motions))] = 0.0
        dissipated, kinetic = (p * (model.kinds == kind) @ strain**2 for kind in (DAMPING, INERTIA))
        with np.errstate(divide="ignore", invalid="ignore"):
            by_energy = 1j * rates.imag - 0.5 * dissipated / kinetic / self.rate
        return Eigen(rates, np.where(slow(rates), by_energy, rates), shapes)


def under_force(model: Model, output: Output, noise: Noise, p: Numbers) -> States | None:
    """States of a machine under a white force, at coefficients p (n_terms,); None where the reading is infinite."""
    system = _alone(model, p)
    return _own_states(system, system.struck @ noise.vector[: model.n_free], reading(model, output, p))


def on_carrier(model: Model, output: Output, p: Numbers, ride: FloatArray) -> States | None:
    """States relative to a base of white acceleration that carries all; None where the reading is infinite.

    ride
        Motion (n_free,) of the free coordinates with the base in which no spring and no damper is strained.  Beside
        it bodies feel the force -M ride; inerters do not, for they resist relative motion alone.
    """
    n, system = model.n_free, _alone(model, p)
    bodies = p * (model.kinds == INERTIA) * ~model.inerters
    load = -(model.vectors[:, :n].T * bodies) @ (model.vectors[:, :n] @ ride)
    carried = float(output.row[:n] @ ride) if output.power == 2 else 0.0
    return _own_states(system, system.struck @ load, reading(model, output, p), carried)


def beside_base(model: Model, output: Output, noise: Noise, p: Numbers) -> States | None:
    """States beside a base of white acceleration, where ground holds the machine back; None where infinite.

    They are counted from the motion in which the machine follows the base slowly: place u + rate u' for its
    displacement u.  That motion grows without end, so it may not be read.
    """
    n, base = model.n_free, noise.vector[model.n_free :]
    system = first_order(*matrices(model, p), n)
    b = system.shaken @ base
    c = _row(system, b, reading(model, output, p))
    if c is None:
        return None
    place, rate = _following(model, p, base)
    still, moving = system.state(place, 0.0 * place, base, 0.0 * base), system.state(rate, place, 0.0 * base, base)
    for drift, free in ((still, place), (moving, rate)):
        size = np.abs(drift)
        size[: len(system.kept)] = np.abs(free).max()
        if abs(drift @ c) > _UNMOVED * (size @ np.abs(c)):
            return None
    own = system.own
    return States(system.rates[:own, :own], (b - moving)[:own], c[:own], system.places[:n, :own])


def under_displacement(model: Model, output: Output, noise: Noise, p: Numbers) -> States | None:
    """States s = z - h u under a white displacement u of a base, with h u' what its rate adds; None where infinite."""
    n, base = model.n_free, noise.vector[model.n_free :]
    system, read = first_order(*matrices(model, p), n), reading(model, output, p)
    own, end = system.own, system.own + len(base)
    a, by_place, by_rate = system.rates[:own, :own], system.rates[:own, own:end], system.rates[:own, end:]
    h = by_rate @ base
    b = by_place @ base + a @ h
    row = read.row @ system.places + (read.rates @ system.places) @ system.rates
    c = row[:own]
    if read.inertia.any() or _remains(row[end:] * base) or _remains(np.append(row[own:end] * base, c * h)):
        return None  # u' or u itself is read
    for _ in range(output.power):
        if _remains(c * b):
            return None
        c = a.T @ c
    return States(a, b, c, system.places[:n, :own])


def _alone(model: Model, p: Numbers) -> FirstOrder:
    """The free coordinates of a model, all bases at rest."""
    n = model.n_free
    mass, damping, stiffness = (each[:n, :n] for each in matrices(model, p))
    return first_order(mass, damping, stiffness, n)


def _own_states(system: FirstOrder, b: Numbers, read: Reading, direct: float = 0.0) -> States | None:
    """States of a system without bases, shaken by b (N,); None where the reading is infinite."""
    c = _row(system, b, read, direct)
    return None if c is None else States(system.rates, b, c, system.places)


def _row(system: FirstOrder, b: Numbers, read: Reading, direct: float = 0.0) -> Numbers | None:
    """Row c (N,) of a reading y = c z + d w with z' = a z + b w; None where d, or a derivative of w, is not nothing.

    `direct` is what the reading has of w besides, as of the acceleration of a base.
    """
    c = np.zeros(len(system.rates), dtype=system.rates.dtype)
    share: Any = direct
    size, end = abs(direct), len(system.places)
    for order, row in enumerate((read.row, read.rates, read.inertia), start=read.power):
        along = row[:end] @ system.places
        for left in range(order, 0, -1):  # d^left/dt^left of along . z
            of_noise, most = along @ b, float(np.abs(along) @ np.abs(b))
            if left == 1:
                share, size = share + of_noise, size + most
            elif abs(of_noise) > _ROUNDING * most:
                return None
            along = along @ system.rates
        c = c + along
    return None if abs(share) > _ROUNDING * size else c


def _remains(terms: Numbers) -> bool:
    """Whether a sum of terms is more than rounding of them."""
    return bool(abs(terms.sum()) > _ROUNDING * np.abs(terms).sum())


def _following(model: Model, p: Numbers, base: FloatArray) -> tuple[Numbers, Numbers]:
    """How free coordinates follow a base that moves slowly: x = place u + rate u', each (n_free,).

    base
        Direction of the motion u among the bases, (n_bases,).

    Notes
    -----
    In M x'' + C x' + K x = 0 over all coordinates, what springs hold is told by the terms of u and u', and what none
    holds, for which K x = 0, by its dampers and the terms of u' and u''.
    """
    n = model.n_free
    mass, damping, stiffness = matrices(model, p)
    turned, held = held_first(model, np.eye(n), p)
    sprung, loose = turned[:, :held], turned[:, held:]

    def by_springs(load: Numbers) -> Numbers:
        return -sprung @ np.linalg.solve(sprung.T @ stiffness[:n, :n] @ sprung, sprung.T @ load)

    def by_dampers(load: Numbers) -> Numbers:
        return -loose @ np.linalg.lstsq(loose.T @ damping[:n, :n] @ loose, loose.T @ load, rcond=None)[0]

    place = by_springs(stiffness[:n, n:] @ base)
    place = place + by_dampers(damping[:n, :n] @ place + damping[:n, n:] @ base)
    rate = by_springs(damping[:n, :n] @ place + damping[:n, n:] @ base)
    return place, rate + by_dampers(damping[:n, :n] @ rate + mass[:n, :n] @ place + mass[:n, n:] @ base)


def decaying(states: States, model: Model, p: FloatArray) -> States | None:
    """The states without motions that last: rigid ones, and those without damping; None where one is shaken and read.

    Schur's form Q^H a Q is block triangular.  With what lasts in front its first entries of c Q tell whether it is
    read; behind, its last entries of Q^H b whether it is shaken.
    """
    from scipy.linalg import solve_sylvester

    rates, decays, _ = states.eigen(model, p)
    lasting = decays.real >= 0.0
    lasting[np.argsort(np.abs(rates))[: rigid_count(model, p)]] = True
    if not lasting.any():
        return states
    turned, count, read, _ = _in_order(states, rates, lasting)
    if np.abs(turned.c[:count]).max(initial=0.0) <= _UNSEEN * np.linalg.norm(read):
        form, places = turned.a, turned.places
        beside = solve_sylvester(form[:count, :count], -form[count:, count:], -form[:count, count:])
        places = places[:, count:] + places[:, :count] @ beside
        return States(form[count:, count:], turned.b[count:], turned.c[count:], places)
    turned, count, _, shaken = _in_order(states, rates, ~lasting)
    if np.abs(turned.b[count:]).max(initial=0.0) > _UNSEEN * np.linalg.norm(shaken):
        return None
    return States(turned.a[:count, :count], turned.b[:count], turned.c[:count], turned.places[:, :count])


def _in_order(states: States, rates: Numbers, first: Numbers) -> tuple[States, int, Numbers, Numbers]:
    """States turned by Q to Schur's form, those of the rates marked `first` (N,) in front, and how many these are.

    Besides |c| |Q| and |Q^H| |b|, to tell rounding in c Q and Q^H b.
    """
    from scipy.linalg import schur

    sorted_by: Any = schur  # its stubs know no function of a complex number
    form, q, count = sorted_by(
        states.a.astype(complex), output="complex", sort=lambda rate: bool(first[np.abs(rates - rate).argmin()])
    )
    turned = States(form, q.conj().T @ states.b, states.c @ q, states.places @ q)
    return turned, count, np.abs(states.c) @ np.abs(q), np.abs(q.conj().T) @ np.abs(states.b)


def held_first(model: Model, basis: FloatArray, p: Numbers) -> tuple[FloatArray, int]:
    """A basis of motions (n_free, d), turned so that those held by springs come first, and how many these are."""
    springs = model.vectors[(model.kinds == STIFFNESS) & (p.real > 0.0), : model.n_free] @ basis
    sizes = np.linalg.norm(springs, axis=1, keepdims=True)
    rows = springs[sizes[:, 0] > 0.0] / sizes[sizes[:, 0] > 0.0]
    if not len(rows):
        return basis, 0
    _, values, turned = np.linalg.svd(rows)
    held = int((values > _ROUNDING * values[0]).sum())
    return basis @ turned.T, held
