"""What a limit is made of once the words are gone: arrays, and no functions.

A response lowers itself to one of the forms below.  A method says which forms it takes.
"""

from __future__ import annotations

from vibopt.arrays import FloatArray
from vibopt.records import dataclass
from vibopt.signals import Combine, Drive, Noise, Output, Segment


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
class ModeFrequency:
    """Undamped natural frequency number `mode` (1 is the lowest) [rad/s]; 0 means each of them."""

    mode: int


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
class RootMeanSquare:
    """Root of the mean square of a response under independent white noises."""

    output: Output
    noises: tuple[Noise, ...]


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
