"""Greatest response in the steady motion of several bodies of which a link rubs, over the speeds of one excitation."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from vibopt.arrays import BoolArray, ComplexArray, FloatArray
from vibopt.errors import InputError
from vibopt.forms.peak_rubbing import in_stretches, read_in_stretches
from vibopt.forms.rubbing import LEAST, TIMES, Rubbing, friction_of
from vibopt.mechanics.modes import natural_frequencies
from vibopt.mechanics.panels import basis
from vibopt.mechanics.slipping import radians_at
from vibopt.records import cached_property, dataclass
from vibopt.signals import Segment

if TYPE_CHECKING:
    from vibopt.mechanics.model import Model
    from vibopt.mechanics.readout import Reading
    from vibopt.mechanics.returning import Returning

_KEPT, _HOPE = 640, 0.6
"""Motions that are kept; part by which the rough look may be off."""
_SLOW, _RADIANS, _NOTHING = 2e-3, 1e4, 1e-14
"""Frequency over the greatest natural one from which on none is too slow; radians of free vibration that are followed
in half a cycle; rounding of what stands still."""
_PARTS = np.linspace(0.0, 1.0, 9)
_BASIS = basis(_PARTS)
"""Parts of a panel at which a cycle is drawn, and Chebyshev's polynomials at them."""


@dataclass(frozen=True)
class Harmonic:
    """The machine as a linear one at frequencies omega (m,) [rad/s], in stretches, that of the link that rubs first.

    free, given
        Motion without friction, and by a force of one of friction, (m, n_coords).
    friction
        [N].
    """

    omega: FloatArray
    free: ComplexArray
    given: ComplexArray
    friction: float

    @cached_property
    def holds(self) -> ComplexArray:
        """What friction must be so that nothing slips [N], (m,)."""
        return np.asarray(-self.free[:, 0] / self.given[:, 0])

    @cached_property
    def rubs(self) -> ComplexArray:
        """Friction [N], (m,): what holds, or as much work as it takes while it slips, by a harmonic."""
        apart, per, push = self.free[:, 0], self.given[:, 0], 4.0 / np.pi * self.friction
        beside = np.abs(apart) ** 2 - (push * per.real) ** 2
        size = np.sqrt(np.maximum(beside, 0.0)) - push * per.imag
        slips = (np.abs(self.holds) > self.friction) & (beside > 0.0) & (size > 0.0) & (self.omega > 0.0)
        turn = apart / np.where(slips, size - 1j * push * per, 1.0)
        still = np.minimum(1.0, self.friction / np.maximum(np.abs(self.holds), 1e-300))
        held = self.holds * np.where(self.omega > 0.0, 1.0, still)
        return np.where(slips, 1j * push * turn, held)

    @property
    def moved(self) -> ComplexArray:
        """Places of all coordinates (m, n_coords)."""
        return self.free + self.given * self.rubs[:, None]

    def read(self, reading: Reading) -> ComplexArray:
        """A reading (m,)."""
        turn, moved = 1j * self.omega, self.moved
        found = turn**reading.power * (moved @ reading.row) + turn * (moved @ reading.rates)
        return np.asarray(found - self.omega**2 * (moved @ reading.inertia) + reading.grip * self.rubs)


@dataclass(frozen=True, slots=True)
class RubbingOfSeveral(Rubbing):
    """As `Rubbing`, of machines of several bodies; a motion of theirs is followed at each speed."""

    once, over = 3.0, 1500.0

    def naturals(self, model: Model, x: FloatArray) -> FloatArray:
        """While it slips, and while friction holds it [rad/s]."""
        from scipy.linalg import eigvalsh

        (mass, _, stiff), n = in_stretches(model, x).rows, in_stretches(model, x).n_free
        heavy, found = 1 + np.flatnonzero(np.diag(mass)[1:n]), [natural_frequencies(model, model.values(x))]
        light = 1 + np.flatnonzero(np.diag(mass)[1:n] == 0.0)
        for joints in (light[:0], light)[: 1 + bool(len(light))]:  # held by their dampers, or given way
            own = np.concatenate([heavy, joints])
            held = stiff[np.ix_(own, own)]
            gives = np.linalg.inv(np.linalg.inv(held)[: len(heavy), : len(heavy)])
            found.append(np.sqrt(eigvalsh(gives, mass[np.ix_(heavy, heavy)])) if len(heavy) else np.zeros(0))
        return np.sort(np.concatenate(found))

    def grasp(self, model: Model, x: FloatArray, speeds: FloatArray) -> FloatArray:
        harmonic = self._harmonic(model, x, speeds)
        return np.asarray(harmonic.friction / np.abs(harmonic.holds))

    def room(self, model: Model, x: FloatArray, value: float, other: float, rounding: float) -> float:
        """And less still of what moves without friction, and where nothing does of what it reads."""
        ends = np.array([end for band in self.shaken[0].bands for end in (band.low, band.high) if np.isfinite(end)])
        harmonic, read = self._harmonic(model, x, ends), read_in_stretches(model, x, self.output)
        count = float(self.per(model, x, ends).min())
        free = float(np.abs(replace(harmonic, friction=0.0).read(read)).max()) / count
        most = float(np.abs(harmonic.free).max() * (1.0 + np.abs(harmonic.omega).max() ** 2))
        still = _NOTHING * (most * float(np.abs(read.row).sum()) + abs(read.grip) * harmonic.friction) / count
        return 1e-7 * max(abs(one) for one in (0.0, value, other) if np.isfinite(one)) + 1e-9 * free + still

    def half_cycle(self, model: Model, x: FloatArray, speed: float) -> tuple[FloatArray, FloatArray, BoolArray]:
        speeds, read = np.array([speed]), read_in_stretches(model, x, self.output)
        harmonic, count = self._harmonic(model, x, speeds), float(self.per(model, x, np.array(speed)))
        if abs(harmonic.holds[0]) <= harmonic.friction:
            times = np.linspace(0.0, np.pi / harmonic.omega[0], TIMES)
            return times, (harmonic.read(read)[0] * np.exp(1j * harmonic.omega[0] * times)).real / count, times >= 0.0
        motion = self.returning(model, x, speed)
        found = np.hstack([
            [piece.begin + piece.length * _PARTS, series @ _BASIS, _PARTS * 0.0 + (piece.side == 0)]
            for piece, series in zip(motion.half_cycle, motion.read(read), strict=True)
        ])  # fmt: skip
        return found[0], found[1] / count, found[2] > 0.0

    def left_to_the_start(self, model: Model, x: FloatArray, speed: float) -> bool:
        return False

    def at(self, model: Model, x: FloatArray, speed: float, *, rough: bool = False) -> float:
        speeds = np.array([speed])
        if not rough:
            return float(self.sizes(model, x, speeds)[0])
        found = np.abs(self._harmonic(model, x, speeds).read(read_in_stretches(model, x, self.output)))
        return float((found / self.per(model, x, speeds))[0])

    def each(self, model: Model, x: FloatArray, speeds: FloatArray) -> FloatArray:
        return np.array([self.at(model, one, float(speed)) for one, speed in zip(x, speeds, strict=True)])

    def sizes(self, model: Model, x: FloatArray, speeds: FloatArray, *, hope: float = 0.0) -> FloatArray:
        amplitude = self._amplitude(speeds)
        count = self.per(model, x, speeds) * np.ones(speeds.shape)
        harmonic, read = self._harmonic(model, x, speeds), read_in_stretches(model, x, self.output)
        moves = (amplitude > 0.0) & (amplitude < np.inf)
        found = np.where(moves, np.abs(harmonic.read(read)) / count, np.where(self.normalised, 1.0, amplitude))
        left = np.flatnonzero(moves & (speeds > 0.0) & (np.abs(harmonic.holds) > harmonic.friction))
        if hope > 0.0:  # what friction jumps by is felt at once, and no harmonic
            rough = found + np.where(moves, harmonic.friction * self._at_once(model, x, read) / count, 0.0)
            some = (rough[left] >= (1.0 - _HOPE) * rough.max()) | (left == 0) | (left == len(speeds) - 1)
            found[left[~some]] = -np.inf
            left = left[some]
        if len(left):
            self._check(model, x, float(speeds[left].min()))
        for k in left.tolist():
            found[k] = self.returning(model, x, float(speeds[k])).greatest(read) / count[k]
        return found

    def returning(self, model: Model, x: FloatArray, speed: float) -> Returning:
        """The motion at a speed [rad/s] at which it slips."""
        from vibopt.mechanics.returning import Returning

        known: dict[tuple[bytes, float], Returning] = vars(model).setdefault("returning", {})
        forces, bases = self._loads(model, x, np.array([speed]))
        key = np.asarray(x, dtype=float).tobytes() + forces.tobytes() + bases.tobytes(), speed
        if key not in known:
            if len(known) >= _KEPT:
                known.pop(next(iter(known)))
            harmonic, seen = self._harmonic(model, x, np.array([speed])), in_stretches(model, x)
            [omega] = harmonic.omega
            begun = np.array([harmonic.moved[0].real, -omega * harmonic.moved[0].imag]).T
            half = Segment(
                np.pi / omega,
                np.array([1.0, 0.0]),
                np.pi * np.array([[0.0, -1.0], [1.0, 0.0]]),
                np.eye(1, 2),
                np.zeros(1),
            )
            loads = np.concatenate([forces[0], -(omega**2) * bases[0]])[:, None]
            known[key] = Returning(*seen.rows, seen.n_free, loads, (half,), begun, harmonic.friction)
        return known[key]

    def _check(self, model: Model, x: FloatArray, speed: float) -> None:
        """Refuse a speed [rad/s] beside which it vibrates too often by itself, slipping or held."""
        order, naturals = self.shaken[0].lines[0].order, self.naturals(model, x)
        if order * speed > _SLOW * naturals[-1]:
            return
        radians = float(radians_at(self.returning(model, x, speed).law.rates, order * speed).max())
        if radians > _RADIANS or order * speed < LEAST * naturals[0]:
            raise InputError(self.too_slow(speed, float(naturals[-1]) / order, _RADIANS if radians > _RADIANS else 0.0))

    def _at_once(self, model: Model, x: FloatArray, read: Reading) -> float:
        """What a reading jumps by with a friction of one [N]: through inertia, and its own."""
        return float(abs(self.returning(model, x, 1.0).law.row(read, 1)[2]))

    def _loads(self, model: Model, x: FloatArray, speeds: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Amplitudes of forces [N] on stretches (m, n_free), and of bases [m], (m, n_bases)."""
        line, n, seen = self.shaken[0].lines[0], model.n_free, in_stretches(model, x)
        size = np.abs(line.amplitude.at(speeds))
        lead = line.vector[np.abs(line.vector).argmax()]
        vector = np.multiply.outer(np.where(np.isfinite(size), size, 0.0), (line.vector * np.abs(lead) / lead).real)
        return vector[:, :n] @ seen.whole[:n, : seen.n_free], vector[:, n:]

    def _harmonic(self, model: Model, x: FloatArray, speeds: FloatArray) -> Harmonic:
        seen, omega = in_stretches(model, x), self.shaken[0].lines[0].order * speeds
        (forces, bases), n, turn = self._loads(model, x, speeds), seen.n_free, 1j * omega[:, None, None]
        mass, damping, stiff = seen.rows
        system = stiff + turn * damping + turn**2 * mass
        pushed = forces - (system[:, :n, n:] @ bases[:, :, None])[..., 0]
        rubbed = np.broadcast_to(-np.eye(n)[0], pushed.shape)
        moved = np.linalg.solve(system[:, :n, :n], np.stack([pushed, rubbed], axis=-1))
        free, given = (
            np.concatenate([moved[..., 0], bases], axis=1),
            np.concatenate([moved[..., 1], 0.0 * bases], axis=1),
        )
        return Harmonic(omega, free, given, friction_of(model, x))
