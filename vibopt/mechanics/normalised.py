"""Linear machines and their loads as states with z' = A z, so that exponentials keep their digits.

Displacements are counted in mass-normalised coordinates and time in the inverse of the fastest rate.  States take
complex coefficients, too: an imaginary part is a slope.  All that is of one of many like machines has their number in
front, written "...".
"""

from __future__ import annotations

import numpy as np

from vibopt.arrays import BoolArray, FloatArray
from vibopt.mechanics.joints import Condensed, condensed, eliminated, riding
from vibopt.mechanics.panels import Numbers
from vibopt.mechanics.readout import Reading
from vibopt.mechanics.stacked import cholesky, product, row_sum, trace, wide
from vibopt.mechanics.stretches import come_back, runs_of
from vibopt.records import cached_property, dataclass
from vibopt.signals import Segment

_CANCELLED = 1e-15
"""Part of what cancels in a reading that is its rounding."""
_LONG = 1e3
"""Radians of the fastest motion from which on a load is never brief."""


@dataclass(frozen=True)
class Normalised:
    """Linear machines at rest, and the load that then comes, as z' = A z of states and signals.

    mass, damping, stiffness
        Of all coordinates, those of the bases last, (..., n_coords, n_coords) [kg, N s/m, N/m].
    n_free
        Number of free coordinates.
    loads
        (n_coords, n_signals): force on free coordinates [N], acceleration of bases [m/s^2], for a signal of one.
    segments
        The signals, of all machines or of each.
    """

    mass: Numbers
    damping: Numbers
    stiffness: Numbers
    n_free: int
    loads: FloatArray
    segments: tuple[Segment, ...]

    @cached_property
    def begun(self) -> Numbers:
        """State before the first blow, (..., size): at rest, or as bodies are let go."""
        released, half = self.segments[0].released, self.size // 2
        state = np.zeros((*self.mass.shape[:-2], self.size), dtype=self.root.dtype)
        if released is None:
            return state
        n, heavy = self.parts[3:]
        kept = np.arange(n) if self.jointed is None else self.jointed.kept
        begins = np.linalg.solve(self.root, (self.loads[kept] @ released) / wide(self.scale))
        state[..., :n], state[..., half : half + heavy] = begins[..., 0], begins[..., :heavy, 1] / self.rate[..., None]
        return state

    @cached_property
    def jointed(self) -> Condensed | None:
        """The machine without coordinates that only springs hold; None where all have mass."""
        if self.mass[..., : self.n_free, :].any(axis=-1).all():
            return None
        return condensed(self.mass, self.damping, self.stiffness, self.n_free)

    @cached_property
    def parts(self) -> tuple[Numbers, Numbers, Numbers, int, int]:
        """Mass, damping, stiffness of the coordinates that are states, the number of free ones, and with mass."""
        condensed = self.jointed
        if condensed is None:
            return self.mass, self.damping, self.stiffness, self.n_free, self.n_free
        return condensed.mass, condensed.damping, condensed.stiffness, condensed.n, condensed.heavy

    @cached_property
    def root(self) -> Numbers:
        """Free coordinates from normalised ones, (..., n, n): of mass one, or where there is none of damping one."""
        mass, damping, _, n, heavy = self.parts
        kind = np.result_type(self.mass, self.damping, self.stiffness)
        root = np.asarray(np.linalg.inv(cholesky(mass[..., :heavy, :heavy])).mT, dtype=kind)
        if heavy == n:
            return root
        whole = np.zeros((*mass.shape[:-2], n, n), dtype=kind)
        whole[..., :heavy, :heavy] = root
        size = np.sqrt(self._rate_of(root, heavy))
        whole[..., heavy:, heavy:] = np.linalg.inv(cholesky(damping[..., heavy:n, heavy:n])).mT * wide(size)
        return whole

    def _rate_of(self, root: Numbers, n: int) -> FloatArray:
        """A rate [1/s] that none of the first n coordinates has by itself."""
        stiff, damped = (root.mT @ one[..., :n, :n] @ root for one in (self.parts[2], self.parts[1]))
        fast = np.sqrt(row_sum(stiff.real)) + row_sum(damped.real)
        return np.where(fast > 0.0, fast, 1.0 / sum(segment.length for segment in self.segments))

    @cached_property
    def rate(self) -> FloatArray:
        """A rate [1/s] that none of the machine's exceeds, (...)."""
        _, damping, stiffness, n, heavy = self.parts
        rate = self._rate_of(self.root[..., :heavy, :heavy], heavy)
        if heavy == n:
            return rate
        elastic, braked = (
            self.root.mT @ one[..., :n, :n] @ self.root for one in (stiffness / wide(rate**2), damping / wide(rate))
        )
        return np.asarray(rate * np.maximum(1.0, row_sum(eliminated(elastic, braked, heavy).real)))

    @property
    def size(self) -> int:
        """Number of states without those of the signals: all motions, those of the bases last, and their rates.

        The rate of what has no mass is no state: its place stays empty.
        """
        return 2 * int(self.parts[0].shape[-1])

    @cached_property
    def scale(self) -> FloatArray:
        """Unit of the states, (...): what signals of one push, or halvings of what is pushed much would take digits."""
        kinds = [self.segments[-1].read, *(alike[0].read for alike in self.runs)]
        most = np.max([np.abs(self._pushed_by_one @ one).max(axis=(-2, -1), initial=0.0) for one in kinds], axis=0)
        return np.where(most > 0.0, most, 1.0)

    @cached_property
    def places(self) -> Numbers:
        """All coordinates from the first half of the states, (..., n_coords, size / 2)."""
        return self._turned if self.jointed is None else np.asarray(self.jointed.lift @ self._turned)

    @cached_property
    def _turned(self) -> Numbers:
        """Coordinates that are states from the first half of the states, (..., size / 2, size / 2)."""
        mass, _, _, n, _ = self.parts
        whole = np.zeros(mass.shape, dtype=self.root.dtype)
        whole[..., :n, :n] = self.root
        own = np.arange(n, mass.shape[-1])
        unit = 1.0 / np.sqrt(trace(mass[..., :n, :n]))
        whole[..., own, own] = unit[..., None]
        whole[..., :n, n:] = self.ride * wide(unit)
        return whole

    @cached_property
    def ride(self) -> Numbers:
        """How free coordinates follow the bases when these move slowly, (..., n, n_bases): places count from there.

        A base that is pushed for a thousand periods is far away, and what is near it would be lost in rounding.  One
        that comes back before anything follows it is not: what hardly moves would be lost beside it.
        """
        found = riding(self.parts[2], self.parts[3])
        brief = self._brief if found.any() else np.zeros(())
        return np.where(wide(brief), 0.0, found) if brief.any() else found

    @cached_property
    def _brief(self) -> BoolArray:
        """Whether bases are moved to and back so briefly that fast coordinates follow them less than slow ones do not,
        (...).
        """
        long = sum(segment.length for segment in self.segments)
        heavy, turned = self.parts[4], np.asarray(self.rate * long)
        if self.segments[-1].endless or (turned >= _LONG).all():
            return np.zeros(turned.shape, dtype=bool)
        root = self.root[..., :heavy, :heavy].real
        held = np.linalg.eigvalsh(root.mT @ self.parts[2][..., :heavy, :heavy].real @ root)[..., 0]
        brief = (turned < _LONG) & (turned * np.sqrt(np.maximum(held, 0.0)) * long < 1.0)
        led = np.flatnonzero(self.loads[self.n_free :].any(axis=0))
        return np.asarray(brief & (brief.any() and come_back(self.runs, led)))

    @cached_property
    def _rides(self) -> FloatArray:
        return wide(self.ride.any(axis=(-2, -1)))

    @cached_property
    def elastic(self) -> Numbers:
        """Forces on the normalised free coordinates per place, (..., n, size / 2), time in 1 / rate."""
        n = self.parts[3]
        found = np.asarray(self.root.mT @ self.parts[2][..., :n, :] @ self._turned / wide(self.rate**2))
        if self._rides.any():
            found[..., n:] = np.where(self._rides, 0.0, found[..., n:])
        return found

    @cached_property
    def braked(self) -> Numbers:
        """The same per rate."""
        n = self.parts[3]
        found = np.asarray(self.root.mT @ self.parts[1][..., :n, :] @ self._turned / wide(self.rate))
        if self._rides.any():
            riding = self.root.mT @ product(self.parts[1][..., :n, :], self._turned[..., n:]) / wide(self.rate)
            found[..., n:] = np.where(self._rides, riding, found[..., n:])
        return found

    @cached_property
    def own(self) -> Numbers:
        """A of the machine by itself, (..., size, size), time in 1 / rate."""
        n, heavy = self.parts[3:]
        half = self.size // 2
        a = np.zeros((*self.mass.shape[:-2], self.size, self.size), dtype=self.root.dtype)
        a[..., :half, half:] = np.eye(half)
        if heavy == n:
            a[..., half : half + n, :half], a[..., half : half + n, half:] = -self.elastic, -self.braked
            return a
        rows = eliminated(self.elastic, self.braked, heavy)
        a[..., heavy:n, :], a[..., half : half + heavy, :] = rows[..., heavy:, :], rows[..., :heavy, :]
        return a

    @cached_property
    def struck(self) -> Numbers:
        """States behind a blow of one on each free coordinate, (..., size, n_free), time in 1 / rate."""
        n, heavy = self.parts[3:]
        half, forces = self.size // 2, self.root.mT
        if self.jointed is not None:
            forces = forces @ self.jointed.lift[..., : self.n_free, :n].mT
        b = np.zeros((*self.mass.shape[:-2], self.size, self.n_free), dtype=self.root.dtype)
        b[..., half : half + heavy, :] = forces[..., :heavy, :]
        if heavy < n:
            b[..., heavy:n, :] = np.linalg.solve(self.braked[..., heavy:, heavy:n], forces[..., heavy:, :])
            b[..., half : half + heavy, :] -= self.braked[..., :heavy, heavy:n] @ b[..., heavy:n, :]
        return b / wide(self.rate)

    @cached_property
    def _pushed_by_one(self) -> Numbers:
        """What signals of one add to the rates of the states, (..., size, n_signals), time in 1 / rate."""
        own, n, half = self.n_free, self.parts[3], self.size // 2
        led = self.mass[..., :own, own:]
        if self._rides.any():
            lift = np.eye(own, self.mass.shape[-1]) if self.jointed is None else self.jointed.lift[..., :own, :]
            led = led + self.mass[..., :own, :own] @ (lift[..., :n] @ self.ride + lift[..., n:] * self._rides)
        b = self.struck @ (self.loads[:own] - led @ self.loads[own:]) / wide(self.rate)
        unit = np.sqrt(trace(self.mass[..., :own, :own])) / self.rate**2
        b[..., half + n :, :] = self.loads[own:] * wide(unit)
        return b

    @cached_property
    def _pushed(self) -> Numbers:
        return self._pushed_by_one / wide(self.scale)

    def whole(self, segment: Segment, lengths: FloatArray | None = None) -> Numbers:
        """A of machine and signal together, (..., N, N), time from 0 to 1 on a segment.

        Of segments like it with lengths (n,) of their own (..., n, N, N).
        """
        own, pushed, size, more = self.own, self._pushed @ segment.read, self.size, segment.start.shape[-1]
        span, front = wide(self.rate * segment.length), self.mass.shape[:-2]
        if lengths is not None:
            own, pushed = own[..., None, :, :], pushed[..., None, :, :]
            span, front = wide(self.rate[..., None] * lengths), (*front, len(lengths))
        a = np.zeros((*front, size + more, size + more), dtype=own.dtype)
        a[..., :size, :size] = own * span
        a[..., :size, size:] = pushed * span
        a[..., size:, size:] = segment.rates
        return a

    def row(self, reading: Reading, a: Numbers) -> Numbers:
        """Row over the states that a reading is, (..., N), where z' = a z, time in 1 / rate."""
        places = np.zeros((*self.places.shape[:-1], a.shape[-1]), dtype=self.root.dtype)
        places[..., : self.size // 2] = self.places
        rows = np.stack([reading.row, reading.rates, reading.inertia], axis=-2)
        found, rate, scale = product(rows, places), wide(self.rate), wide(self.scale)
        if a.ndim > places.ndim:  # of each segment
            found, rate, scale = found[..., None, :, :], rate[..., None], scale[..., None]
        both = (found, a * rate), (np.abs(found), np.abs(a) * rate)
        row, size = (self._read_by(one, many, reading.power) for one, many in both)
        row = np.where(np.abs(row) > _CANCELLED * size, row, 0.0)
        return np.asarray(row * scale)[..., 0, :]

    @staticmethod
    def _read_by(found: Numbers, rates: Numbers, power: int) -> Numbers:
        """Displacement, rate and acceleration (..., 3, N) of states with z' = rates z as one row (..., 1, N)."""
        row = found[..., :1, :] + (found[..., 1:2, :] + found[..., 2:, :] @ rates) @ rates
        for _ in range(power):
            row = row @ rates
        return np.asarray(row)

    @property
    def finite(self) -> tuple[Segment, ...]:
        """All segments but one that goes on for ever, which is the last."""
        return self.segments[:-1] if self.segments[-1].endless else self.segments

    @cached_property
    def runs(self) -> list[list[Segment]]:
        """Segments of one kind that follow each other, as far as they end: of one length, or very many of any."""
        return runs_of(self.finite)
