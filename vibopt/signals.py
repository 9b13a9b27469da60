"""What shakes a machine, and what is read of its motion, as arrays.

Speeds and frequencies are in rad/s, amplitudes are peak values in SI units.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from vibopt.arrays import BoolArray, ComplexArray, FloatArray, IntArray, Values
from vibopt.records import dataclass

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

Combine = Literal["sum", "rss", "peak"]
Sense = Literal["greatest", "least"]
Sort = Literal["steady", "random", "transient"]
"""Of an excitation, and of what is asked about it."""


@dataclass(frozen=True, slots=True)
class Band:
    """Closed interval of speeds [rad/s]; one speed when `low == high`."""

    low: float
    high: float

    @property
    def is_point(self) -> bool:
        return self.low == self.high

    def holds(self, speed: float, slack: float = 1e-12) -> bool:
        """Whether `speed` [rad/s] lies in the band, rounding allowed for."""
        room = slack * max(abs(self.low), abs(self.high), 1e-300)
        return self.low - room <= speed <= self.high + room


@dataclass(frozen=True, slots=True)
class Piece:
    """On `band`, amplitude = (constant + slope * speed) * speed**power."""

    band: Band
    constant: float
    slope: float = 0.0
    power: int = 0

    def at(self, speed: FloatArray) -> FloatArray:
        """Amplitude at each speed [rad/s], same shape as `speed`; at rest without end where it falls with speed."""
        value: FloatArray = self.constant + self.slope * speed
        if self.power >= 0:
            return value * speed**self.power if self.power else value
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(value * speed**self.power)


@dataclass(frozen=True, slots=True)
class Amplitude:
    """How an excitation's amplitude depends on speed, piece by piece."""

    pieces: tuple[Piece, ...]

    def at(self, speed: FloatArray) -> FloatArray:
        """Amplitude at each speed [rad/s], shape of `speed`; signed factors allowed."""
        return self.by_piece(np.asarray(speed, dtype=float), Piece.at)

    def by_piece(self, speed: FloatArray, function: Callable[[Piece, FloatArray], Values]) -> Values:
        """A function of the piece that holds and of speeds [rad/s] (n,), at each speed: a number, or a row of them."""
        if len(self.pieces) == 1:
            return function(self.pieces[0], speed)
        ends = np.array([piece.band.high for piece in self.pieces[:-1]])
        which = np.searchsorted(ends, speed, side="left")
        parts = [(which == index, piece) for index, piece in enumerate(self.pieces)]
        found: list[tuple[BoolArray, Values]] = [(chosen, function(piece, speed[chosen])) for chosen, piece in parts]
        value = np.empty((*speed.shape, *found[0][1].shape[1:]), dtype=found[0][1].dtype)
        for chosen, part in found:
            value[chosen] = part
        return value

    @property
    def grows_to_rest(self) -> bool:
        """Whether it is a displacement whose velocity or acceleration is given."""
        return self.pieces[0].power < 0

    def breaks(self) -> tuple[float, ...]:
        """Speeds [rad/s] at which one piece ends and the next begins."""
        return tuple(piece.band.high for piece in self.pieces[:-1])


@dataclass(frozen=True, slots=True)
class Line:
    """One harmonic of an excitation: frequency = order * speed.

    vector
        Shape (n_coords,), complex: force on free coordinates, displacement on bases, for amplitude 1.
    amplitude
        Peak amplitude against the speed.
    """

    order: float
    vector: ComplexArray
    amplitude: Amplitude


def sizes(lines: Sequence[Line], speed: FloatArray) -> FloatArray:
    """Amplitude of every line at each speed [rad/s], shape (n_lines, ...)."""
    first = [line.amplitude.pieces[0] for line in lines]
    power = first[0].power
    if any(piece.power != power for piece in first) or any(len(line.amplitude.pieces) > 1 for line in lines):
        return np.array([line.amplitude.at(speed) for line in lines])
    each = (-1, *[1] * speed.ndim)
    constant, slope = (np.array(one).reshape(each) for one in zip(*((p.constant, p.slope) for p in first), strict=True))
    value = constant + slope * speed
    return value * speed**power if power else value


@dataclass(frozen=True, slots=True)
class Drive:
    """One excitation as a limit sees it: its lines, and the speeds to look at."""

    name: str
    lines: tuple[Line, ...]
    bands: tuple[Band, ...]


@dataclass(frozen=True, slots=True)
class Output:
    """Row that reads a response off the motion: (row + sum_t signs_t z_t b_t) . u * (i omega)**power.

    `z_t` is the dynamic stiffness of term t.  row (n_coords,), signs (n_terms,).
    With `shared_by` naming a link, the value is divided by the number of its mounts; more general, by what the model
    counts under that name.  `held` are bearings, and dampers that turn with a shaft, whose force is read beside that,
    by name, each with its sign.
    """

    row: FloatArray
    signs: FloatArray
    power: int = 0
    shared_by: str = ""
    held: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True, slots=True)
class Noise:
    """One white noise.

    vector
        Shape (n_coords,): force on free coordinates, motion of bases, for a noise of one.
    density
        One-sided spectral density over the angular frequency [N^2 s/rad, (m/s^2)^2 s/rad, m^2 s/rad].
    displaced
        Of a base: whether its displacement is the noise; its acceleration otherwise.
    """

    name: str
    vector: FloatArray
    density: float
    displaced: bool = False


@dataclass(frozen=True, slots=True)
class Segment:
    """Part of some signals in time without a joint inside: they are read off states w with w' = rates w.

    length
        [s], above zero.
    start
        (m,): the states at its beginning; time runs from 0 to 1 on it.
    rates
        (m, m).
    read
        (n_signals, m): the signals.
    blows
        (n_signals,): time integral of each signal at the very beginning [s].
    endless
        Whether it goes on for ever; `length` is then only the time in which `rates` count.
    released
        (n_signals, 2): displacement [m] and velocity [m/s] with which begins what each acts on, in the first of all
        segments; None where all is at rest.
    """

    length: float
    start: FloatArray
    rates: FloatArray
    read: FloatArray
    blows: FloatArray
    endless: bool = False
    released: FloatArray | None = None

    @property
    def states(self) -> tuple[FloatArray, ...]:
        """start, rates, read and blows."""
        return self.start, self.rates, self.read, self.blows

    def each(self, length: Any, *states: FloatArray) -> Segment:
        """The like of it with others of these, of one machine or of each of a row."""
        start, rates, read, blows = states
        return Segment(length, start, rates, read, blows, self.endless, self.released)

    def of(self, those: IntArray) -> Segment:
        """Of some machines, where each has its own."""
        every: Any = self.length, *self.states
        return self if np.ndim(self.length) == 0 else self.each(*(one[those] for one in every))


AT_REST = Segment(1.0, np.zeros(1), np.zeros((1, 1)), np.zeros((1, 1)), np.zeros(1))
"""No signal."""


def side_by_side(signals: Sequence[tuple[Segment, ...]]) -> tuple[Segment, ...]:
    """Signals of as many like segments, of any lengths and sizes, as one in which each machine of a row has its own."""
    found = []
    for every in zip(*signals, strict=True):
        rows: Any = zip(*((one.length, *one.states) for one in every), strict=True)
        found.append(every[0].each(*(np.array(row) for row in rows)))
    return tuple(found)


def stretched(signal: tuple[Segment, ...], parts: FloatArray) -> tuple[Segment, ...]:
    """One signal so many times as long (n,), as one in which each machine of a row has its own."""
    rows = [[np.broadcast_to(own, (len(parts), *own.shape)) for own in segment.states] for segment in signal]
    return tuple(segment.each(segment.length * parts, *row) for segment, row in zip(signal, rows, strict=True))


@dataclass(frozen=True, slots=True)
class Sweep:
    """A force whose speed changes from one to another, and stays there; before, it stays at the first.

    speeds
        First and last, and those between at which the force or the rate changes its way, rising or falling [rad/s].
    rates
        Change of the speed on each stretch between two of them [rad/s^2], even on it; below zero where it falls.
    powers
        On each stretch between two of `speeds` the complex amplitude by powers of the speed, (n_powers,) [N].
    still
        Amplitude at the first speed before it changes, and at the last behind [N].
    """

    speeds: tuple[float, ...]
    rates: tuple[float, ...]
    powers: tuple[ComplexArray, ...]
    still: tuple[float, float]

    def of(self, x: FloatArray) -> Sweep:
        """At a design (n_vars,): it is the same at all."""
        return self

    @property
    def times(self) -> FloatArray:
        """When it reaches each of `speeds` [s], from the beginning on."""
        return np.concatenate([[0.0], np.cumsum(np.diff(self.speeds) / self.rates)])

    def at(self, times: FloatArray) -> FloatArray:
        """The speed at times [rad/s], shape of `times`."""
        return np.interp(times, self.times, self.speeds)


@dataclass(frozen=True)
class Sweeps:
    """Run-ups of every rate in a range, of which one is chosen: `make` gives the one of a size of the rate [rad/s^2].

    index
        Of the variable that says it.
    """

    make: Callable[[float], Sweep]
    index: int

    def of(self, x: FloatArray) -> Sweep:
        """At a design (n_vars,)."""
        return self.make(float(x[self.index]))
