"""Motion of one body on links of which one rubs, from rest, under loads that change with time: from event to event.

While it slips, and while friction holds it, body, bases and load together follow z' = A z: states go on by exponentials
of matrices, on panels on which each is the polynomial through its nodes.  A slip ends at a root of its speed, a hold
where friction would have to be more than it is.  Behind the load two motions under one force never move apart in
energy: it goes on until it is held, turns so often that no later turn is greater, or repeats under a sine that lasts.

States are slip and its speed, the force of friction, places and speeds of the bases, and those of the signals.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.polynomial import chebyshev

from vibopt.arrays import FloatArray
from vibopt.errors import InputError
from vibopt.mechanics.panels import COEFFICIENTS, NODES, SLOPES, exponentials, peaks_of
from vibopt.mechanics.ringing import Peak
from vibopt.mechanics.transient import Reading
from vibopt.records import cached_property, dataclass
from vibopt.signals import Segment

_PANEL, _FADED = 2.5, 42.0
"""Radians of the fastest motion on a panel; exponent behind which a motion is gone."""
_SAFE, _ROUND, _BEGUN = 0.02, 1e-12, 1e-6
"""Part of the greatest below which nothing falls between nodes; rounding; part of a panel that is its beginning."""
_TURNS, _LASTING, _REPEATS, _MOST = 12, 1500, 1e-11, 100_000
"""Turns behind a load; of a sine that lasts, at most, and part of the states by which one may differ from the next;
panels in all."""
_FINE, _LONGER = 2001, 10
"""Places on a panel at which the time of a peak is told; doublings of a panel where what is fast has faded."""
_TOO_OFTEN = (
    "What rubs moves to and fro more often than is followed. Write a shorter load, less stiffness or damping, or more "
    "mass or friction."
)
_ENDLESS = (
    f"What rubs does not move alike from turn to turn within {_LASTING} turns of what begins suddenly: hardly anything "
    "damps it, or it grows without end. Write more friction or damping, or ask for the steady vibration alone."
)


@dataclass(frozen=True)
class Law:
    """How the states change on a segment: rates while it slips and while it is held, (n, n) [1/s], and what that takes.

    places, speeds, faster
        Rows of all coordinates and of their rates, of second ones while it slips, (n_coords, n).
    carries
        Row of what friction holds while nothing slips [N].
    """

    slips: FloatArray
    held: FloatArray
    places: FloatArray
    speeds: FloatArray
    faster: FloatArray
    carries: FloatArray

    @cached_property
    def rates(self) -> FloatArray:
        """Of all motions (n,), complex [1/s]."""
        return np.concatenate([np.linalg.eigvals(self.slips), np.linalg.eigvals(self.held)])

    @cached_property
    def _known(self) -> dict[tuple[int, float], FloatArray]:
        return {}

    def ahead(self, side: int, width: float) -> FloatArray:
        """From states at the beginning of a panel [s] to those at its nodes, (17, n, n)."""
        key = abs(side), width
        if key not in self._known:
            self._known[key] = exponentials((self.slips if side else self.held) * width, NODES)
        return self._known[key]

    def width(self, age: float) -> float:
        """Of a panel so long behind the last event [s]."""
        lively = np.abs(self.rates)
        most = lively[-self.rates.real * age < _FADED].max()
        first = _PANEL / lively.max()
        longer = np.floor(np.log2(max(lively.max() / max(most, 1e-300), 1.0)))
        return float(first * 2.0 ** min(longer, _LONGER))

    def row(self, reading: Reading, side: int) -> FloatArray:
        """What a reading is of the states (n,)."""
        motion = self.places, self.speeds, self.faster if side else self._along
        found = reading.row @ motion[reading.power] + reading.rates @ motion[1] + reading.inertia @ motion[2]
        rubbed = np.eye(len(self.slips))[2] if side else self.carries
        return np.asarray(found + reading.grip * rubbed)

    @cached_property
    def _along(self) -> FloatArray:
        """As `faster`, while nothing slips."""
        found = self.faster.copy()
        found[0] -= self.slips[1]
        return found


@dataclass(frozen=True, slots=True)
class Piece:
    """Part of a motion: its beginning and length [s], the sense of slip, 0 of a hold, and states (n, 17) as series."""

    begin: float
    length: float
    side: int
    law: Law
    states: FloatArray


@dataclass(frozen=True)
class Sliding:
    """A body at rest, and the load that then comes.

    mass, damping, stiffness
        Of all coordinates, those of the bases last, (n_coords, n_coords) [kg, N s/m, N/m].
    loads
        (n_coords, n_signals): force on the body [N], acceleration of bases [m/s^2], for a signal of one.
    across, friction
        How far the link that rubs is apart, as a row (n_coords,), and its friction [N].
    """

    mass: FloatArray
    damping: FloatArray
    stiffness: FloatArray
    loads: FloatArray
    segments: tuple[Segment, ...]
    across: FloatArray
    friction: float

    def peak(self, reading: Reading) -> Peak:
        """Greatest size of a reading from the beginning on, for ever."""
        rows = [one.law.row(reading, one.side) @ one.states for one in self.pieces]
        sizes = peaks_of(np.array(rows), np.zeros(len(rows)))
        at = int(np.argmax(sizes >= sizes.max() * (1.0 - _ROUND)))
        places = np.linspace(0.0, 1.0, _FINE)
        values = rows[at] @ _basis(places)
        top = int(np.abs(values).argmax())
        time = self.pieces[at].begin + self.pieces[at].length * float(places[top])
        return Peak(float(np.copysign(sizes[at], values[top])), time)

    def history(self, reading: Reading, times: FloatArray) -> FloatArray:
        """The reading at times [s], (n,); what is not followed stays as it ended."""
        begins = np.array([one.begin for one in self.pieces])
        which = np.maximum(np.searchsorted(begins, times, side="right") - 1, 0)
        found = []
        for time, one in zip(times, (self.pieces[k] for k in which), strict=True):
            part = min((time - one.begin) / one.length, 1.0)
            found.append(float(one.law.row(reading, one.side) @ one.states @ _basis(part)))
        return np.array(found)

    @cached_property
    def pieces(self) -> list[Piece]:
        """The whole motion.

        Raises
        ------
        InputError
            It moves to and fro too often.
        """
        found = list[Piece]()
        for one in self._followed():
            found.append(one)
            if len(found) > _MOST:
                raise InputError(_TOO_OFTEN)
        return found

    def _followed(self) -> Iterator[Piece]:
        time, own, side = 0.0, np.zeros(3 + 2 * (len(self.across) - 1)), 0
        if self.segments[0].released is not None:
            own[:2] = self.loads[0] @ self.segments[0].released
        for segment in self.segments:
            own = own + self._struck @ segment.blows
            law = self._law(segment)
            for _ in range(_LASTING if segment.endless else 1):
                before, state = own, np.concatenate([own, segment.start])
                for one in self._along(law, time, segment.length, state):
                    yield one
                    state, side = one.states.sum(axis=1), one.side
                time, own = time + segment.length, state[: len(own)]
                if np.abs(own - before).max() <= _REPEATS * np.abs(own).max():
                    break
            else:
                if segment.endless:
                    raise InputError(_ENDLESS)
        if self.segments[-1].endless:
            return
        still = Segment(1.0, np.zeros(0), np.zeros((0, 0)), np.zeros((self.loads.shape[1], 0)), np.zeros(0))
        law, turned, most = self._law(still), 0, 0.0
        for one in self._along(law, time, np.inf, own):
            yield one
            turned, side = turned + (one.side == -side), one.side
            end, fast = one.states.sum(axis=1), float(np.abs(one.states[1]).sum())
            most = max(most, fast)
            rests = not (law.carries[3:] @ end[3:] or law.carries @ (law.held @ end))
            if turned > _TURNS or (one.side == 0 and rests) or (one.side and fast <= _ROUND * most):
                return

    def _along(self, law: Law, time: float, length: float, state: FloatArray) -> Iterator[Piece]:
        """Pieces from a state on, over so many seconds."""
        gone, age, fresh, side = 0.0, 0.0, False, self._sense(law, state)
        while gone < length * (1.0 - _ROUND):
            state = state.copy()
            state[2] = side * self.friction
            if not side:
                state[1] = 0.0
            width = law.width(age)
            whole = min(1.0, (length - gone) / width)
            states = (law.ahead(side, width) @ state).T @ COEFFICIENTS
            part = (self._stops if side else self._leaves)(law, states, side, whole, fresh=fresh)
            if part is not None and part <= 0.0:  # by rounding alone: held until that turns
                side, fresh = 0, True
                continue
            ended = whole if part is None else part
            if ended < 1.0:
                states = states @ _basis(ended * NODES) @ COEFFICIENTS
            yield Piece(time + gone, ended * width, side, law, states)
            gone, age, state = gone + ended * width, age + ended * width, states.sum(axis=1)
            if part is None:
                fresh = False
                continue
            age, fresh = 0.0, True
            carried = float(law.carries @ state)
            if side:
                was, state[1] = side, 0.0
                side = 0 if abs(carried) <= self.friction else int(np.sign(carried))
                side = 0 if side == was else side
            else:
                side = int(np.sign(carried))

    def _sense(self, law: Law, state: FloatArray) -> int:
        """Of slip at the beginning of a segment: that of its speed, or what the load pushes."""
        if state[1]:
            return int(np.sign(state[1]))
        carried = float(law.carries @ state)
        return 0 if abs(carried) <= self.friction else int(np.sign(carried))

    def _stops(self, law: Law, states: FloatArray, side: int, whole: float, *, fresh: bool) -> float | None:
        """Part of a panel at which a slip comes to rest; 0 where it never began, None where it goes on."""
        speed = side * states[1]
        values = speed @ (_basis(whole * NODES) if whole < 1.0 else _NODAL)
        begins = fresh or values[0] <= 0.0
        seen = values[1:] / NODES[1:] ** (2 if begins else 0)
        if seen.min() > _SAFE * seen.max():
            return None
        roots = _roots(speed, _BEGUN if begins else 0.0, whole)
        first = float(roots[0]) if len(roots) else whole
        if begins and speed @ _basis(0.5 * first) <= 0.0:
            return 0.0
        return next((float(one) for one in roots if SLOPES @ speed @ _basis(one) <= 0.0), None)

    def _leaves(self, law: Law, states: FloatArray, side: int, whole: float, *, fresh: bool) -> float | None:
        """Part of a panel at which friction holds no longer; None where it does."""
        carried = law.carries @ states
        values = carried @ (_basis(whole * NODES) if whole < 1.0 else _NODAL)
        if np.abs(values).max() < (1.0 - _SAFE) * self.friction:
            return None
        found = []
        for sense in (1.0, -1.0):
            over = sense * carried
            over[0] -= self.friction
            roots = _roots(over, _BEGUN if fresh else 0.0, whole)
            found += [float(one) for one in roots if SLOPES @ over @ _basis(one) > 0.0][:1]
        return max(min(found), 1e-300) if found else None

    @cached_property
    def _struck(self) -> FloatArray:
        """Changes of the states by blows of one of each signal, (n, n_signals)."""
        bases = len(self.across) - 1
        found = np.zeros((3 + 2 * bases, self.loads.shape[1]))
        found[3 + bases :] = self.loads[1:]
        found[1] = self.loads[0] / self.mass[0, 0] - self._ride @ self.loads[1:]
        return found

    @property
    def _ride(self) -> FloatArray:
        """How far the body goes with each base where nothing slips, (n_bases,)."""
        return np.asarray(-self.across[0] * self.across[1:])

    def _law(self, segment: Segment) -> Law:
        """On a segment; kept, for a record has thousands alike."""
        known: dict[tuple[bytes, bytes, float], Law] = vars(self).setdefault("laws", {})
        key = segment.rates.tobytes(), segment.read.tobytes(), float(segment.length)
        if key not in known:
            known[key] = self._made(segment)
        return known[key]

    def _made(self, segment: Segment) -> Law:
        bases = len(self.across) - 1
        signals = segment.read.shape[1]
        unit = np.eye(3 + 2 * bases + signals)
        slip, speed, rubbed, own = unit[0], unit[1], unit[2], unit[3 + 2 * bases :]
        base, fast = unit[3 : 3 + bases], unit[3 + bases : 3 + 2 * bases]
        pushed, led = self.loads[0] @ segment.read @ own, self.loads[1:] @ segment.read @ own
        places = np.vstack([slip + self._ride @ base, base])
        speeds = np.vstack([speed + self._ride @ fast, fast])
        pulled = _cleared(self.stiffness[0] @ places, self.stiffness[0, 0])
        pulled = pulled + _cleared(self.damping[0] @ speeds, self.damping[0, 0])
        faster = (pushed - rubbed - pulled - self.mass[0, 1:] @ led) / self.mass[0, 0] - self._ride @ led
        carries = self.mass[0, 0] * faster + rubbed
        slips = np.zeros(unit.shape)
        slips[0], slips[1], slips[3 : 3 + bases], slips[3 + bases : 3 + 2 * bases] = speed, faster, fast, led
        slips[3 + 2 * bases :, 3 + 2 * bases :] = segment.rates / segment.length
        held = slips.copy()
        held[:2] = 0.0
        accelerations = np.vstack([faster + self._ride @ led, led])
        return Law(slips, held, places, speeds, accelerations, carries)


def _cleared(row: FloatArray, size: float) -> FloatArray:
    """A row without what rounding leaves of links that end where the one that rubs does."""
    return np.where(np.abs(row) <= _ROUND * size, 0.0, row)


def _basis(part: FloatArray | float) -> FloatArray:
    """Chebyshev's polynomials at parts of a panel, (17, n)."""
    return np.asarray(np.cos(np.multiply.outer(np.arange(len(NODES)), np.arccos(np.clip(2.0 * part - 1.0, -1.0, 1.0)))))


_NODAL = _basis(NODES)


def _roots(series: FloatArray, begin: float, end: float) -> FloatArray:
    """Real roots of a series on 0 to 1, from `begin` to `end`, ascending, made better by Newton's method."""
    last = int(np.flatnonzero(np.abs(series) > 1e-17 * np.abs(series).max())[-1])
    roots = chebyshev.chebroots(series[: last + 1]) if last else np.zeros(0)
    found = 0.5 + 0.5 * np.sort(roots.real[np.abs(roots.imag) < 1e-8])
    found = found[(found >= begin - 1e-9) & (found <= end + 1e-9)]
    for _ in range(2):
        basis = _basis(found)
        rate = SLOPES @ series @ basis
        step = 0.5 * (series @ basis) / np.where(rate == 0.0, np.inf, rate)
        found = found - np.where(np.abs(step) < 1e-3, step, 0.0)
    return np.asarray(found[(found >= begin) & (found <= end * (1.0 + _ROUND))])


__all__ = ["Law", "Piece", "Sliding"]
