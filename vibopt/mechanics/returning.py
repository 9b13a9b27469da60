"""Steady motion under one harmonic of a machine of which one link rubs: half a cycle that ends at the negative of it.

Slips and holds follow one another as in `sliding`.  Its beginning is found by Newton's method on the exact derivative
of its end: exponentials of matrices, and at each event the change that the motion is given by a later stop.
"""

from __future__ import annotations

from itertools import islice, pairwise

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.errors import InputError
from vibopt.mechanics.closing import closing
from vibopt.mechanics.panels import peaks_of
from vibopt.mechanics.readout import Reading
from vibopt.mechanics.sliding import TOO_OFTEN, Law, Piece, Sliding
from vibopt.records import cached_property, dataclass

_TURNS, _MOST, _ENDLESS = 600, 20_000, 1e9
"""Half cycles that are followed until one closes, and panels of one, at most; motion over that under a load at rest, of
what has no end."""
_BRIEF, _ROUNDING = 1e-9, 1e-12
"""Part of half a cycle in which nothing slips yet, and of a sum that is none."""
_OPEN = (
    f"What rubs comes to no steady motion within {_TURNS} half cycles: hardly anything damps it, or it grows without "
    "end. Write more friction or damping, or speeds away from its resonances."
)


@dataclass(frozen=True)
class Returning(Sliding):
    """As `Sliding`, under a harmonic of which the one segment is half a cycle.

    begun
        Of the free coordinates of a motion near it, of the bases as they move, (n_coords, 2).
    """

    def greatest(self, reading: Reading) -> float:
        """Greatest size of a reading in a cycle; a slip that lasts no longer than rounding moves is none."""
        lengths = np.array([piece.length for piece in self.half_cycle])
        seen = self.read(reading)[lengths > _BRIEF * lengths.sum()]
        return float(peaks_of(seen, np.zeros(len(seen))).max())

    def read(self, reading: Reading) -> FloatArray:
        """A reading as a series on each panel of half a cycle, (n_panels, 17)."""
        return np.array([piece.law.row(reading, piece.side) @ piece.states for piece in self.half_cycle])

    @cached_property
    def half_cycle(self) -> tuple[Piece, ...]:
        """Panels of half a cycle; the other half is its negative.

        Raises
        ------
        InputError
            None was found that closes.
        """
        start = self._struck_by(self.begun)
        begun, scale = self._own @ start[self._free], max(self._size(start), self._likely) or 1.0
        road = closing(
            lambda own: self._half(own, scale), lambda own: float(np.linalg.norm(own)), begun / scale, _TURNS, warm=0
        )
        found = next((pieces for pieces in road if pieces is not None), None)
        if found is None or self._size(found[0].start) > _ENDLESS * self._size(self._still):
            raise InputError(_OPEN)
        return found

    @property
    def law(self) -> Law:
        return self._law(self.segments[0])

    @property
    def _still(self) -> FloatArray:
        """States (n,) of the free coordinates if the load stayed at its greatest."""
        n, found = self.n_free, self._struck_by(0.0 * self.begun)
        found[self._numbers[0]] = np.linalg.solve(self.stiffness[:n, :n], self._pushed)
        return found

    @property
    def _pushed(self) -> FloatArray:
        """What the load at its greatest pushes the free coordinates with (n_free,) [N]."""
        n = self.n_free
        return np.asarray(
            self.loads[:n, 0] - self.mass[:n, n:] @ self.loads[n:, 0] - self.stiffness[:n, n:] @ self.begun[n:, 0]
        )

    @property
    def _likely(self) -> float:
        """Size of a motion under the load by springs or by masses alone, the lesser: what is to it as rounding is none.

        Where friction all but holds, what is left of its motion is rounding, to which nothing closes.
        """
        still, fast, heavy = self._still, self._struck_by(0.0 * self.begun), self._heavy
        struck = np.linalg.solve(self.mass[np.ix_(heavy, heavy)], self._pushed[heavy])
        fast[self._numbers[1]] = struck * self.segments[0].length / np.pi
        return min(self._size(still), self._size(fast))

    def _size(self, state: FloatArray) -> float:
        return float(np.linalg.norm(self._own @ state[self._free]))

    @cached_property
    def _free(self) -> list[int]:
        """Numbers of the states of the free coordinates: places, then rates."""
        return [*self._numbers[0], *self._numbers[1]]

    @cached_property
    def _own(self) -> FloatArray:
        """From places and rates of the free coordinates to states as long as the root of twice the energy."""
        n, heavy = self.n_free, self._heavy
        found = np.zeros((len(self._free), len(self._free)))
        found[:n, :n] = np.linalg.cholesky(self.stiffness[:n, :n]).T
        found[n:, n:] = np.linalg.cholesky(self.mass[np.ix_(heavy, heavy)]).T
        return found

    def _half(self, own: FloatArray, scale: float) -> tuple[tuple[Piece, ...], FloatArray, FloatArray]:
        """Panels of half a cycle from a state, that at its end, and the derivative of this (2 n, 2 n)."""
        [segment] = self.segments
        law, free = self.law, self._free
        state = np.concatenate([self._struck_by(self.begun), segment.start])
        state[free] = np.linalg.solve(self._own, own * scale)
        if (
            abs(state[1]) <= _ROUNDING * np.abs(state[self._numbers[1]]).max()
        ):  # of what is held rounding would make a slip
            state[1] = 0.0
        pieces = tuple(islice(self._along(law, 0.0, segment.length, state), _MOST))
        if len(pieces) == _MOST:
            raise InputError(TOO_OFTEN)
        slope = np.eye(len(state))[:, free]
        if not pieces[0].side:
            slope[1] = 0.0
        elif law.rests is not None:
            slope[0] = law.rests @ slope
        for piece, following in pairwise((*pieces, None)):
            assert piece is not None
            slope = piece.ahead @ slope
            if following is None or piece.side == following.side:
                continue
            if law.rests is not None and not piece.side:
                slope[0] = law.rests @ slope
            elif piece.side and law.slips[1].any():
                before = law.slips @ piece.states.sum(axis=1)
                after = (law.slips if following.side else law.held) @ following.start
                if abs(before[1]) > _ROUNDING * (np.abs(law.slips[1]) @ np.abs(following.start)):  # else it only grazes
                    slope = slope + np.outer(after - before, slope[1]) / before[1]
        end = pieces[-1].states.sum(axis=1)[free]
        return pieces, self._own @ end / scale, self._own @ slope[free] @ np.linalg.inv(self._own)
