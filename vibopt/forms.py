"""What a limit is made of once the words are gone: arrays, and no functions.

A response lowers itself to one of the forms below.  A method says which forms it takes.
Speeds and frequencies are in rad/s, amplitudes are peak values in SI units.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, TypeVar

import numpy as np

from vibopt.records import dataclass

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    FloatArray = NDArray[np.float64]
    ComplexArray = NDArray[np.complex128]
    BoolArray = NDArray[np.bool_]
    IntArray = NDArray[np.intp]
else:  # numpy.typing is slow to load, and only a type checker reads it
    FloatArray = ComplexArray = BoolArray = IntArray = np.ndarray

Values = TypeVar("Values", FloatArray, ComplexArray)
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
        """Amplitude at each speed [rad/s], same shape as `speed`."""
        value: FloatArray = self.constant + self.slope * speed
        return value * speed**self.power if self.power else value


@dataclass(frozen=True, slots=True)
class Amplitude:
    """How an excitation's amplitude depends on speed, piece by piece."""

    pieces: tuple[Piece, ...]

    def at(self, speed: FloatArray) -> FloatArray:
        """Amplitude at each speed [rad/s], shape of `speed`; signed factors allowed."""
        return self.by_piece(np.asarray(speed, dtype=float), Piece.at)

    def by_piece(self, speed: FloatArray, function: Callable[[Piece, FloatArray], Values]) -> Values:
        """A function of the piece that holds and of the speed, at each speed [rad/s]."""
        if len(self.pieces) == 1:
            return function(self.pieces[0], speed)
        ends = np.array([piece.band.high for piece in self.pieces[:-1]])
        which = np.searchsorted(ends, speed, side="left")
        parts = [(which == index, piece) for index, piece in enumerate(self.pieces)]
        found = [(chosen, function(piece, speed[chosen])) for chosen, piece in parts]
        value = np.empty(speed.shape, dtype=found[0][1].dtype)
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
    With `shared_by` naming a link, the value is divided by the number of its mounts.
    """

    row: FloatArray
    signs: FloatArray
    power: int = 0
    shared_by: str = ""


@dataclass(frozen=True, slots=True)
class Modulus:
    """Combined modulus of linear responses under equilibrium D(p) u = f, over bands of speeds.

    With `rigid_link` named, the value is the modulus with that link made rigid divided by the
    modulus as it is (insertion loss).  `endless` names the drives under which it is infinite at standstill,
    whatever the design.
    """

    output: Output
    drives: tuple[Drive, ...]
    combine: Combine
    rigid_link: str = ""
    endless: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class StaticRow:
    """Response under the weights alone, static stiffness: row . u [m]."""

    row: FloatArray


@dataclass(frozen=True, slots=True)
class StaticLoad:
    """Static force of one mount under the weights alone, as a part of what it is rated for: factor(x) * |row . u|.

    `factor` is one monomial: static stiffness of one mount over its rating.  `signed` keeps the sign of row . u:
    a mount that is lifted has a force below zero.
    """

    row: FloatArray
    factor: Monomials
    signed: bool = False


@dataclass(frozen=True, slots=True)
class StaticForce:
    """Force of some springs under the weights alone, with its sign: sum_t signs_t p_t b_t . u [N], u downward."""

    signs: FloatArray


@dataclass(frozen=True, slots=True)
class ModeGap:
    """Least difference between neighbouring undamped natural frequencies [rad/s]."""


@dataclass(frozen=True, slots=True)
class EnergyShare:
    """Part of the kinetic energy that a mode has in one motion of one body: (r . phi) (r . M phi) / (phi . M phi).

    The greatest over all modes; modes of one frequency count together.  row (n_coords,).
    """

    row: FloatArray


@dataclass(frozen=True, slots=True)
class ModeFrequency:
    """Undamped natural frequency number `mode` (1 is the lowest) [rad/s]; 0 means each of them."""

    mode: int


@dataclass(frozen=True, slots=True)
class ModeRatio:
    """Motion over motion in undamped mode number `mode`, with its sign: (of . phi) / (to . phi); rows (n_coords,)."""

    mode: int
    of: FloatArray
    to: FloatArray


@dataclass(frozen=True, slots=True)
class FreeMotion:
    """Motion row . u [m], with its sign, `after` a time [s] of free vibration.

    row (n_coords,); displacements [m] and velocities [m/s] at the start, (n_free,).
    """

    row: FloatArray
    displacements: FloatArray
    velocities: FloatArray
    after: float


@dataclass(frozen=True, slots=True)
class ModeDamping:
    """Damping ratio of the `mode`-th least damped mode (1 is the least)."""

    mode: int


@dataclass(frozen=True, slots=True)
class DecayRate:
    """Least decay rate of free vibration, -max Re(pole) [1/s]; rigid motion, which nothing calls back, is left out."""


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
    """

    length: float
    start: FloatArray
    rates: FloatArray
    read: FloatArray
    blows: FloatArray


@dataclass(frozen=True, slots=True)
class PeakInTime:
    """Greatest size of a response from the beginning of some signals on, for ever; the machine is at rest before.

    loads
        (n_coords, n_signals): force on free coordinates [N], acceleration of bases [m/s^2], for a signal of one.
    segments
        The signals, one segment behind the other.
    """

    output: Output
    loads: FloatArray
    segments: tuple[Segment, ...]


@dataclass(frozen=True, slots=True)
class RootMeanSquare:
    """Root of the mean square of a response under independent white noises."""

    output: Output
    noises: tuple[Noise, ...]


@dataclass(frozen=True, slots=True)
class Monomials:
    """Sum of scale_j * prod_i x_i**exponents_ji.  scale (n,), exponents (n, n_vars)."""

    scale: FloatArray
    exponents: FloatArray


Form = (
    Modulus
    | StaticRow
    | StaticLoad
    | StaticForce
    | ModeFrequency
    | ModeGap
    | EnergyShare
    | ModeRatio
    | FreeMotion
    | ModeDamping
    | DecayRate
    | RootMeanSquare
    | PeakInTime
    | Monomials
)
