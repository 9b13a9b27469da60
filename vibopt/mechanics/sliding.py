"""Motion of a machine of which one link rubs, from rest, under loads that change with time: from event to event.

While it slips, and while friction holds it, bodies, bases and load together follow z' = A z: states go on by
exponentials of matrices, on panels on which each is the polynomial through its nodes.  A slip ends at a root of its
speed, a hold where friction would have to be more than it is.  Behind the load what friction takes only lowers the
energy: it goes on until it is held for good, and then rings as a linear machine does, until no later turn can be
greater, or repeats under a sine that lasts.

The first coordinate is the slip.  States are slip and its speed, the force of friction, the other places, bases last,
their rates, and those of the signals.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray, IntArray
from vibopt.errors import InputError
from vibopt.mechanics.panels import COEFFICIENTS, NODES, SLOPES, basis, crossing, exponentials, peaks_of, roots_of
from vibopt.mechanics.peaks_in_time import Peak
from vibopt.mechanics.readout import Reading
from vibopt.mechanics.ringing import rung
from vibopt.records import cached_property, dataclass
from vibopt.signals import Segment

_PANEL, _FADED = 2.5, 42.0
"""Radians of the fastest motion on a panel; exponent behind which a motion is gone."""
_SAFE, _ROUND, _NOISE, _BEGUN = 0.02, 1e-12, 1e-13, 1e-6
"""Part of the greatest below which nothing falls between nodes; rounding, and of values on a panel; part of it that is
its beginning."""
_LASTING, _REPEATS, _CREEPS, _MOST, _TOGETHER = 1500, 1e-11, 1e-4, 100_000, 24
"""Turns of a sine that lasts, at most, and part of the states by which one may differ from the next, and from the next
of what creeps; panels in all, and those behind the load between two looks at what may still come."""
_SWUNG, _SLOW, _STOPPED = 100.0, 1e-9, 1e-11
"""Periods of the slowest motion over which slips and holds are followed that never end; part of the fastest rate from
which on it is one, and of the greatest speed of a base at which it stands still."""
_FINE, _LONGER = 2001, 40
"""Places on a panel at which the time of a peak is told; doublings of a panel where what is fast has faded."""
_NODAL = basis(NODES)
_FIRST_NODE = _NODAL[:, 0]
TOO_OFTEN = (
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

    places
        Rows of all coordinates, (n_coords, n).
    speeds
        Of their rates, while it is held and while it slips, (2, n_coords, n).
    carries
        Row of what friction holds while nothing slips [N].
    rests
        Row of the place to which what slips follows without a delay, where neither mass nor damper resists it.
    """

    slips: FloatArray
    held: FloatArray
    places: FloatArray
    speeds: FloatArray
    carries: FloatArray
    rests: FloatArray | None = None

    @cached_property
    def faster(self) -> tuple[FloatArray, FloatArray]:
        """Rows of second rates, while it is held and while it slips, (n_coords, n) each."""
        return self.speeds[0] @ self.held, self.speeds[1] @ self.slips

    @cached_property
    def rates(self) -> ComplexArray:
        """Of all motions (n,) [1/s]."""
        return np.concatenate([np.linalg.eigvals(self.slips), np.linalg.eigvals(self.held)]).astype(complex)

    @cached_property
    def _fades(self) -> float:
        """The fastest fading of any motion [1/s]."""
        return float(-self.rates.real.min())

    @cached_property
    def period(self) -> float:
        """Of the slowest motion while it slips [s]."""
        sizes = np.abs(self.rates[: len(self.slips)])
        return float(2.0 * np.pi / sizes[sizes > _SLOW * sizes.max()].min())

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
        first = _PANEL / lively.max()
        if age * self._fades < _FADED:
            return float(first)
        most = lively[-self.rates.real * age < _FADED].max()
        longer = np.floor(np.log2(max(lively.max() / max(most, 1e-300), 1.0)))
        return float(first * 2.0 ** min(longer, _LONGER))

    def row(self, reading: Reading, side: int) -> FloatArray:
        """What a reading is of the states (n,)."""
        motion = self.places, self.speeds[abs(side)], self.faster[abs(side)]
        found = reading.row @ motion[reading.power] + reading.rates @ motion[1] + reading.inertia @ motion[2]
        rubbed = np.eye(len(self.slips))[2] if side else self.carries
        return np.asarray(found + reading.grip * rubbed)


@dataclass(frozen=True, slots=True)
class Piece:
    """Part of a motion: its beginning and length [s], the sense of slip, 0 of a hold, and states (n, 17) as series.

    Of the last one, which is held for good and goes on for ever, the states with which it begins, (n, 1).

    width
        Of the panel of which it is the beginning [s].
    """

    begin: float
    length: float
    side: int
    law: Law
    states: FloatArray
    width: float = 0.0

    @property
    def ahead(self) -> FloatArray:
        """From states at its beginning to those at its end (n, n)."""
        nodes = self.law.ahead(self.side, self.width)
        if self.length == self.width:
            return np.asarray(nodes[-1])
        return np.asarray(np.tensordot(COEFFICIENTS @ basis(self.length / self.width), nodes, 1))

    @property
    def start(self) -> FloatArray:
        """States at its beginning (n,)."""
        return np.asarray(self.states @ _FIRST_NODE[: self.states.shape[1]])


@dataclass(frozen=True)
class Sliding:
    """A machine at rest, and the load that then comes.

    mass, damping, stiffness
        Of all coordinates, the slip first, those of the bases last, (n_coords, n_coords) [kg, N s/m, N/m].
    n_free
        Number of free coordinates.
    loads
        (n_coords, n_signals): force on free coordinates [N], acceleration of bases [m/s^2], for a signal of one.
    begun
        Coordinates and rates with which it begins, (n_coords, 2).
    friction
        Against any slip [N].
    """

    mass: FloatArray
    damping: FloatArray
    stiffness: FloatArray
    n_free: int
    loads: FloatArray
    segments: tuple[Segment, ...]
    begun: FloatArray
    friction: float

    def peak(self, reading: Reading) -> Peak:
        """Greatest size of a reading from the beginning on, for ever."""
        best, seen = Peak(0.0, 0.0), 0
        load = np.inf if self.segments[-1].endless else sum(segment.length for segment in self.segments)
        while some := self._from(seen):
            best, seen = self._higher(some, reading, best), seen + len(some)
            last = some[-1]
            if last.begin >= load and self._most(reading, last) <= abs(best.value):
                break
        return best

    def _higher(self, pieces: list[Piece], reading: Reading, best: Peak) -> Peak:
        """The greatest on some pieces, where it is above the best so far."""
        rows = [piece.law.row(reading, piece.side) for piece in pieces]
        if pieces[-1].length == np.inf:
            law = pieces[-1].law
            value, time = rung((law.held, law.period), self._swings, rows.pop(), pieces[-1].start, abs(best.value))
            best = Peak(value, pieces[-1].begin + time) if value else best
        if not rows:
            return best
        read = [row @ piece.states for row, piece in zip(rows, pieces, strict=False)]
        sizes = peaks_of(np.array(read), np.zeros(len(read)))
        if sizes.max() <= abs(best.value) * (1.0 + _ROUND):
            return best
        at = int(np.argmax(sizes >= sizes.max() * (1.0 - _ROUND)))
        places = np.linspace(0.0, 1.0, _FINE)
        values = read[at] @ basis(places)
        top = int(np.abs(values).argmax())
        time = pieces[at].begin + pieces[at].length * float(places[top])
        return Peak(float(np.copysign(sizes[at], values[top])), time)

    def _most(self, reading: Reading, last: Piece) -> float:
        """What a reading is never above behind a piece without a load: at rest, by all energy and by all friction."""
        if last.length == np.inf:
            return 0.0
        n, end, row = self.n_free, last.states.sum(axis=1), last.law.row(reading, 1)
        places, rates, bases, led = self._numbers
        mass, stiff = self.mass[np.ix_(self._heavy, self._heavy)], self.stiffness[:n, :n]
        if np.linalg.matrix_rank(stiff) < n or (self.stiffness[:n, n:] @ end[led]).any() or row[bases] @ end[led]:
            return np.inf
        rest = -np.linalg.solve(stiff, self.stiffness[:n, n:] @ end[bases] + self.damping[:n, n:] @ end[led])
        away, fast, by_place, by_rate = end[places] - rest, end[rates], row[places], row[rates]
        energy = away @ stiff @ away + fast @ mass @ fast
        per = by_place @ np.linalg.solve(stiff, by_place) + by_rate @ np.linalg.solve(mass, by_rate)
        still = by_place @ rest + row[bases] @ end[bases] + row[led] @ end[led]
        return float(abs(still) + np.sqrt(per * energy) + abs(row[2]) * self.friction)

    def history(self, reading: Reading, times: FloatArray) -> FloatArray:
        """The reading at times [s], (n,); what is not followed stays as it ended."""
        while (not self._known or self._known[-1].begin < times.max(initial=0.0)) and self._from(len(self._known)):
            pass
        begins = np.array([piece.begin for piece in self._known])
        which = np.maximum(np.searchsorted(begins, times, side="right") - 1, 0)
        found = []
        for time, one in zip(times, (self._known[k] for k in which), strict=True):
            row = one.law.row(reading, one.side)
            if one.length == np.inf:
                found.append(float(row @ exponentials(one.law.held * (time - one.begin), NODES[-1:])[0] @ one.start))
            else:
                found.append(float(row @ one.states @ basis(min((time - one.begin) / one.length, 1.0))))
        return np.array(found)

    @property
    def pieces(self) -> list[Piece]:
        """The whole motion.

        Raises
        ------
        InputError
            It moves to and fro too often.
        """
        while self._from(len(self._known)):
            pass
        return self._known

    @cached_property
    def _known(self) -> list[Piece]:
        """Pieces so far."""
        return []

    @cached_property
    def _coming(self) -> Iterator[Piece]:
        return self._followed()

    def _from(self, seen: int) -> list[Piece]:
        """Pieces from a number on, some more where there are none yet; empty where it is over."""
        if seen == len(self._known):
            self._known.extend(islice(self._coming, _TOGETHER))
            if len(self._known) > _MOST:
                raise InputError(TOO_OFTEN)
        return self._known[seen:]

    def _followed(self) -> Iterator[Piece]:
        time, own, led = 0.0, self._struck_by(self.begun), self._numbers[3]
        most = np.zeros(len(led))
        for segment in self.segments:
            own = own + self._struck @ segment.blows
            law = self._law(segment)
            for _ in range(_LASTING if segment.endless else 1):
                before, state, pieces = own, np.concatenate([own, segment.start]), list[Piece]()
                for piece in self._along(law, time, segment.length, state):
                    yield piece
                    pieces.append(piece)
                    state, most = piece.states.sum(axis=1), np.maximum(most, np.abs(piece.states[led]).sum(axis=1))
                time, own = time + segment.length, state[: len(own)]
                if segment.endless and self._repeats(segment, before, pieces):
                    break
            else:
                if segment.endless:
                    raise InputError(_ENDLESS)
        if not self.segments[-1].endless:
            own[led] = np.where(np.abs(own[led]) <= _STOPPED * most, 0.0, own[led])  # rounding would carry bases away
            yield from self._behind(time, own)

    def _repeats(self, segment: Segment, before: FloatArray, turn: list[Piece]) -> bool:
        """Whether what comes behind a turn of a sine that lasts is as that, or no greater.

        Where friction can hold all in the end, it creeps back to its middle, slipping one way alone, and comes there as
        one over the number of turns.  A load that stays has another middle.
        """
        after = turn[-1].states.sum(axis=1)[: len(before)]
        size, own, fast, bases, led = np.max([np.abs(one.start) for one in turn], axis=0), *self._numbers
        kinds = (np.concatenate([own, bases]), np.concatenate([fast, led]))  # friction that is held is neither
        changed = max(float(np.abs(after - before)[kind].max() / (size[kind].max() or 1.0)) for kind in kinds)
        swings = np.linalg.matrix_rank(segment.rates) == len(segment.rates)
        creeps = swings and len({one.side for one in turn} - {0}) == 1 and abs(after[0]) < abs(before[0])
        return changed <= (_CREEPS if creeps else _REPEATS)

    def _behind(self, time: float, own: FloatArray) -> Iterator[Piece]:
        """Pieces behind the load, until it is held for good, creeps to where it stays, or swings on and on."""
        still = Segment(1.0, np.zeros(0), np.zeros((0, 0)), np.zeros((self.loads.shape[1], 0)), np.zeros(0))
        law, before, most = self._law(still), 1, 0.0
        for piece in self._along(law, time, np.inf, own):
            held = (law.held, law.period), self._swings, law.carries, piece.start, self.friction
            if piece.side == 0 and before and rung(*held, any_above=True)[0] == 0.0:
                yield Piece(piece.begin, np.inf, 0, law, piece.start[:, None])
                return
            yield piece
            before, fast = piece.side, float(np.abs(piece.states[self._numbers[1]]).sum())
            most = max(most, fast)
            if (piece.side and fast <= _ROUND * most) or piece.begin - time > _SWUNG * law.period:
                return

    @cached_property
    def _numbers(self) -> tuple[IntArray, IntArray, IntArray, IntArray]:
        """Numbers of states: places and rates of the free coordinates, the slip first, then of the bases."""
        n, m = self.n_free, len(self.mass)
        others, rates = np.arange(3, 2 + m), np.arange(2 + m, 1 + 2 * m)
        own = np.insert(rates[: n - 1], 0, 1)[self._heavy]
        return np.insert(others[: n - 1], 0, 0), own, others[n - 1 :], rates[n - 1 :]

    @cached_property
    def _heavy(self) -> IntArray:
        """Free coordinates with mass: the rates of others are no states, and their places there are empty."""
        return np.flatnonzero(np.diag(self.mass)[: self.n_free])

    @cached_property
    def _swings(self) -> IntArray:
        """Numbers of the states that move freely while friction holds: places, then rates."""
        return np.setdiff1d(np.concatenate(self._numbers[:2]), [0, 1])

    def _along(self, law: Law, time: float, length: float, state: FloatArray) -> Iterator[Piece]:
        """Pieces from a state on, over so many seconds."""
        gone, age, fresh, side = 0.0, 0.0, False, self._sense(law, state)
        while gone < length * (1.0 - _ROUND):
            state = state.copy()
            state[2] = side * self.friction
            if not side:
                state[1] = 0.0
            elif law.rests is not None:
                state[0] = law.rests @ state
            width = law.width(age)
            whole = min(1.0, (length - gone) / width)
            states = (law.ahead(side, width) @ state).T @ COEFFICIENTS
            part = (self._stops if side else self._leaves)(law, states, side, whole, fresh=fresh)
            if side and part is not None and part <= _NOISE:  # by rounding alone: held until that turns
                side, fresh = 0, True
                continue
            ended = whole if part is None else part
            if ended < 1.0:
                states = states @ basis(ended * NODES) @ COEFFICIENTS
            yield Piece(time + gone, ended * width, side, law, states, width)
            gone, age, state = gone + ended * width, age + ended * width, states.sum(axis=1)
            if part is None:
                fresh = False
                continue
            age, fresh = 0.0, True
            if side:
                was, state[1] = side, 0.0
                side = self._sense(law, state)
                side = 0 if side == was else side
            else:
                side = int(np.sign(law.carries @ state))

    def _sense(self, law: Law, state: FloatArray) -> int:
        """Of slip at the beginning of a segment: that of its speed, or what the load pushes."""
        if state[1]:
            return int(np.sign(state[1]))
        carried = float(law.carries @ state)
        side, beyond = int(np.sign(carried)), abs(carried) / self.friction - 1.0
        if law.rests is None or abs(beyond) > _ROUND:
            return side if beyond > 0.0 else 0
        begins: FloatArray = np.where(np.arange(len(state)) == 2, side * self.friction, state)  # it may slip on
        return side if side * float(law.speeds[1][0] @ begins) > 0.0 else 0

    def _stops(self, law: Law, states: FloatArray, side: int, whole: float, *, fresh: bool) -> float | None:
        """Part of a panel at which a slip comes to rest; 0 where it never began, None where it goes on."""
        speed = side * (law.speeds[1][0] @ states)
        values = speed @ (basis(whole * NODES) if whole < 1.0 else _NODAL)
        begins = fresh or values[0] <= 0.0
        seen = values[1:] / NODES[1:] ** (2 if begins else 0)
        if seen.min() > _SAFE * seen.max():
            return None
        turned = int((seen <= 0.0).argmax())
        if turned > 1 and seen[: turned - 1].min() > _SAFE * seen.max():
            return crossing(speed, whole * float(NODES[turned]), whole * float(NODES[turned + 1]))
        roots = roots_of(speed, _BEGUN if begins else 0.0, whole)
        if begins:
            early = speed @ basis(0.5 * np.append(roots, whole))
            told = np.flatnonzero(np.abs(early) > _NOISE * np.abs(values).max())  # before, roots are of rounding
            if not len(told) or early[told[0]] < 0.0:
                return 0.0
            roots = roots[told[0] :]
        return next((float(root) for root in roots if SLOPES @ speed @ basis(root) <= 0.0), None)

    def _leaves(self, law: Law, states: FloatArray, side: int, whole: float, *, fresh: bool) -> float | None:
        """Part of a panel at which friction holds no longer; None where it does."""
        carried = law.carries @ states
        values = carried @ (basis(whole * NODES) if whole < 1.0 else _NODAL)
        if np.abs(values).max() < (1.0 - _SAFE) * self.friction:
            return None
        sizes = np.abs(values)
        beyond = sizes > self.friction
        first = int(beyond.argmax())
        if first > 1 and sizes[: first - 1].max() < (1.0 - _SAFE) * self.friction:
            part = np.copysign(1.0, values[first]) * carried
            part[0] -= self.friction
            return crossing(part, whole * float(NODES[first - 1]), whole * float(NODES[first]))
        if whole == 1.0 and not beyond.any() and peaks_of(carried[None], np.array([self.friction]))[0] <= self.friction:
            return None
        found, early = list[float](), float(carried @ basis(_BEGUN))
        if abs(early) > self.friction * (1.0 + _NOISE):
            over = np.copysign(1.0, early) * carried
            over[0] -= self.friction
            return max(crossing(over, 0.0, _BEGUN), 1e-300) if over @ _FIRST_NODE < 0.0 else _BEGUN
        for sense in (1.0, -1.0):
            over = sense * carried
            over[0] -= self.friction
            roots = roots_of(over, _BEGUN if fresh else 0.0, whole)
            found += [float(root) for root in roots if SLOPES @ over @ basis(root) > 0.0][:1]
        if not found and abs(values[-1]) > self.friction:  # it was so from the beginning
            return _BEGUN
        return max(min(found), 1e-300) if found else None

    def _struck_by(self, changes: FloatArray) -> FloatArray:
        """States without those of signals, from places and rates of all coordinates (n_coords, 2)."""
        places, rates = changes.T.copy()
        rates[: self.n_free][np.diag(self.mass)[: self.n_free] == 0.0] = 0.0
        return np.concatenate([[places[0], rates[0], 0.0], places[1:], rates[1:]])

    @cached_property
    def _struck(self) -> FloatArray:
        """Changes of the states by blows of one of each signal, (n, n_signals)."""
        n, heavy = self.n_free, self._heavy
        pushed, fast = (self.loads[:n] - self.mass[:n, n:] @ self.loads[n:])[heavy], np.zeros(self.loads[:n].shape)
        fast[heavy] = np.linalg.solve(self.mass[np.ix_(heavy, heavy)], pushed)
        fast = np.where(np.abs(fast) <= _ROUND * np.abs(fast).max(axis=0, initial=0.0), 0.0, fast)
        every = np.vstack([fast, self.loads[n:]])
        return np.array([self._struck_by(np.array([0.0 * one, one]).T) for one in every.T]).T

    def _law(self, segment: Segment) -> Law:
        """On a segment; kept, for a record has thousands alike."""
        known: dict[tuple[bytes, bytes, float], Law] = vars(self).setdefault("laws", {})
        key = segment.rates.tobytes(), segment.read.tobytes(), float(segment.length)
        if key not in known:
            known[key] = self._made(segment)
        return known[key]

    def _made(self, segment: Segment) -> Law:
        n, m = self.n_free, len(self.mass)
        size = 1 + 2 * m
        unit = np.eye(size + segment.read.shape[1])
        at, fast_at = np.array([0, *range(3, 2 + m)]), np.array([1, *range(2 + m, size)])
        places, known, light = unit[at], unit[fast_at], np.setdiff1d(np.arange(n), self._heavy)
        known[light] = 0.0
        acting = self.loads @ segment.read @ unit[size:]
        pulled = self.stiffness[:n] @ places + self.damping[:n] @ known + self.mass[:n, n:] @ acting[n:]
        forces, resists = acting[:n] - pulled, self.mass[:n, :n].copy()
        resists[:, light] = self.damping[:n, light]
        follows, soft = not resists[0].any(), self.stiffness[0, 0]
        held = np.vstack([0.0 * unit[0], np.linalg.solve(resists[1:, 1:], forces[1:])])
        slips = held if follows else np.linalg.solve(resists, forces - np.outer(np.eye(n)[0], unit[2]))
        laws, speeds = np.zeros((2, *unit.shape)), np.array([known, known])
        for rates, own, fast in zip(laws, speeds, (held, slips), strict=True):
            own[light] = fast[light]
            if follows:
                own[0] = own[1:].T @ self.stiffness[0, 1:] / -soft
            rates[at], rates[fast_at] = own, np.vstack([fast, acting[n:]])
            rates[fast_at[light]] = 0.0
            rates[size:, size:] = segment.rates / segment.length
        laws[0, 0], speeds[0, 0] = 0.0, known[0]
        rests = unit[0] + (forces[0] - unit[2]) / soft if follows else None
        return Law(laws[1], laws[0], places, speeds, forces[0] - resists[0] @ held, rests)
