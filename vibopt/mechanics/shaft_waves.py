"""A whirling shaft by the equations of its waves: dynamic stiffness of each section, exact at every frequency.

The second road to a rotor.  Along a section the state (deflection, tilt, shear force, moment) obeys a system of first
order, whose exponential carries it from end to end: Timoshenko's beam with the gyroscopic moments of its own mass.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.records import cached_property, dataclass

MODES = 12
"""Lowest critical speeds that are told."""
_SERIES = np.array([1.0 / math.factorial(k) for k in range(17)])
_SMALL = 0.5
"""Terms of the exponential series, and the size of a matrix below which they are all that matters."""
_PIECES, _FEWEST, _LONG, _SHORT = 16, 3, 10.0, 1.3
"""Pieces in matrices for slow motion, of the whole and of a section; inertia over stiffness up to which it is slow.

Phase along a piece where matrices are said to be good up to a frequency [rad].
"""
_ROUNDED = 1e-7
"""Part of what adds up to a moment below which it is rounding, as at a free end."""
_WHOLE, _CLAMPED = 3.5, 4.730040744862704
"""Phase along a section up to which it is followed in one stretch [rad]: held at both ends it does not vibrate yet.

At the second it would, if it were slender.
"""


@dataclass(frozen=True, slots=True)
class Section:
    """A round piece of shaft: length [m], E I [N m^2], kappa G A [N], rho A [kg/m], rho I [kg m].

    `stress` is the greatest over the moment that bends it [1/m^3].
    """

    length: float
    bending: float
    shear: float
    mass: float
    rotary: float
    stress: float = 0.0

    def quick(self, pieces: int) -> float:
        """Frequency up to which the waves along one of some pieces of it are long [rad/s]."""
        long = self.length / pieces
        return float(np.sqrt(_LONG * self.bending / max(self.mass * long**4, self.rotary * long**2)))

    def stretches(self, omega: float, phase: float) -> int:
        """Into how many it is cut so that a wave at a frequency [rad/s] goes on by at most `phase` [rad] along each.

        Of a thick one what counts is how near a stretch held at both ends is to vibrating by itself: squares of
        periods of bending, shear and tilting add up, of tilting three times in a backward whirl with the spin.
        """
        part = (phase / _CLAMPED) ** 4
        bends = self.mass * self.length**4 / self.bending / _CLAMPED**4 * omega**2
        thick = (self.mass / self.shear + 3.0 * self.rotary / self.bending) * (self.length * omega / np.pi) ** 2
        return max(1, int(np.ceil(np.sqrt((thick + np.sqrt(thick**2 + 4.0 * part * bends)) / (2.0 * part)))))


@dataclass(frozen=True, slots=True)
class Disc:
    """A rigid disc at a node: mass [kg], diametral and polar moment of inertia [kg m^2]."""

    node: int
    mass: float
    diametral: float
    polar: float


@dataclass(frozen=True)
class WhirlingShaft:
    """Sections from left to right, discs on their ends, and the points that have names.

    sections
        Section i lies between the nodes i and i + 1; each node has a deflection and a tilt.
    points
        Node of each name.
    top
        Frequency up to which matrices for slow motion are good at least [rad/s].
    lags
        Time by which the stress of its material leads the strain, in the frame that turns with it [s].
    """

    sections: tuple[Section, ...]
    discs: tuple[Disc, ...]
    points: Mapping[str, int]
    top: float = 0.0
    lags: float = 0.0

    @property
    def size(self) -> int:
        """Number of coordinates: deflection and tilt of each node in turn."""
        return 2 * len(self.sections) + 2

    @property
    def pieces(self) -> int:
        """Into how many each section is cut for slow motion."""
        slender = [replace(section, shear=np.inf, rotary=0.0) for section in self.sections]
        longest = max(section.stretches(self.top, _SHORT) for section in slender)
        return max(_FEWEST, -(-_PIECES // len(self.sections)), longest)

    @property
    def quick(self) -> float:
        """Frequency up to which the whole is slow [rad/s]."""
        return min(section.quick(self.pieces) for section in self.sections)

    def cuts(self, omega: float) -> list[int]:
        """Number of each node where sections are cut so short."""
        return [0, *np.cumsum([section.stretches(omega, _WHOLE) for section in self.sections]).tolist()]

    def cut(self, omega: float) -> WhirlingShaft:
        """The same with its sections cut to stretches short enough for a frequency [rad/s].

        Along a long one waves grow beyond all digits, and a section held at its ends vibrates by itself.
        """
        node = self.cuts(omega)
        counts = np.diff(node).tolist()
        if max(counts) == 1:
            return self
        shorter = [
            replace(section, length=section.length / n) for section, n in zip(self.sections, counts, strict=True)
        ]
        return replace(
            self,
            sections=tuple(section for section, n in zip(shorter, counts, strict=True) for _ in range(n)),
            discs=tuple(replace(disc, node=node[disc.node]) for disc in self.discs),
            points={name: node[point] for name, point in self.points.items()},
        )

    def dynamic(
        self, omega: ComplexArray | FloatArray, spin: ComplexArray | FloatArray | None = None, *, braked: bool = False
    ) -> ComplexArray:
        """Dynamic stiffness at frequencies omega (n,) of forward whirl at spins (n,) [rad/s], (n, size, size).

        Without a spin it is that of the whirl with the shaft, which an unbalance drives.  A negative frequency is
        that of a backward whirl.  With `braked` its material damps what differs from the spin.
        """
        square = np.asarray(omega) ** 2
        turned = square if spin is None else np.asarray(omega * spin)
        kinds = tuple(dict.fromkeys(self.sections))
        modulus = 1.0 + 1j * self.lags * (omega - spin) if braked and spin is not None else np.ones(1)
        each = _stiffness(kinds, square / modulus, (square - 2.0 * turned) / modulus) * modulus[:, None, None]
        found = np.zeros((len(square), self.size, self.size), dtype=each.dtype)
        for i, section in enumerate(self.sections):
            found[:, 2 * i : 2 * i + 4, 2 * i : 2 * i + 4] += each[kinds.index(section)]
        for disc in self.discs:
            found[:, 2 * disc.node, 2 * disc.node] -= square * disc.mass
            found[:, 2 * disc.node + 1, 2 * disc.node + 1] -= square * disc.diametral - turned * disc.polar
        return found

    def moment(
        self, k: int, end: int, square: ComplexArray | FloatArray, ends: ComplexArray, sense: float = 1.0
    ) -> ComplexArray:
        """Moment on the left (0) or right (1) end of section k of a whirl with the shaft [N m], (n,).

        With `sense` -1 of one against it, as fast.
        From deflection and tilt at both its ends (n, 4), at frequencies squared (n,) [1/s^2]; what is rounding is zero.
        """
        parts = _stiffness((self.sections[k],), square, (1.0 - 2.0 * sense) * square)[0, :, 1 + 2 * end] * ends
        whole = parts.sum(axis=-1)
        return np.asarray(np.where(np.abs(whole) > _ROUNDED * np.abs(parts).sum(axis=-1), whole, 0.0))

    @cached_property
    def slow(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Stiffness, inertia, and polar inertia over all tilts, each (n, n), good for slow motion.

        Every section is cut into pieces, and the waves of each followed to first order in the square of the
        frequency; the nodes keep every so manieth pair of coordinates.
        """
        pieces = self.pieces
        count = 2 * pieces * len(self.sections) + 2
        stiff, inertia, polar = (np.zeros((count, count)) for _ in range(3))
        step, still = np.array([1e-30j]), np.zeros(1, dtype=complex)
        moved = (
            _stiffness(self.sections, step, still, pieces)[:, 0],
            _stiffness(self.sections, still, step, pieces)[:, 0],
        )
        for i, (along, turned) in enumerate(zip(*moved, strict=True)):
            tilted = -turned.imag / step.imag
            for k in range(pieces):
                begin = 2 * (pieces * i + k)
                here = slice(begin, begin + 4)
                stiff[here, here] += along.real
                inertia[here, here] += tilted - along.imag / step.imag
                polar[here, here] += 2.0 * tilted
        for disc in self.discs:
            at = 2 * pieces * disc.node
            inertia[at, at] += disc.mass
            inertia[at + 1, at + 1] += disc.diametral
            polar[at + 1, at + 1] += disc.polar
        return stiff, inertia, polar

    @property
    def drag(self) -> float:
        """None at rest: what damps a shaft by itself turns with it."""
        return 0.0

    @property
    def weighs(self) -> float:
        """Its mass and that of its discs [kg]."""
        return sum(section.mass * section.length for section in self.sections) + sum(disc.mass for disc in self.discs)

    def on_nodes(self, moved: ComplexArray, omega: float) -> ComplexArray:
        """A slow motion (n,) over the nodes of `cut`, (size,), where both have one."""
        nodes = self.cuts(omega)
        found = np.zeros(2 * nodes[-1] + 2, dtype=complex)
        for k, node in enumerate(nodes):
            found[2 * node : 2 * node + 2] = moved[2 * self.pieces * k :][:2]
        return found

    def place(self, point: str) -> int:
        """Number of a point's deflection among the coordinates of `slow`."""
        return 2 * self.pieces * self.points[point]


def _stiffness(sections: tuple[Section, ...], square: Any, tilting: Any, pieces: int = 1) -> ComplexArray:
    """Dynamic stiffness of sections over deflection and tilt at the left and the right end, (n_sections, n, 4, 4).

    Parameters
    ----------
    square
        Frequencies squared [1/s^2], (n,).
    tilting
        What the diametral inertia is multiplied by, w^2 - 2 w W at the spin W [1/s^2], (n,).
    pieces
        Into how many each section is cut; the stiffness is that of one of them.
    """
    table = np.array(
        [
            (section.length / pieces, section.bending, section.shear, section.mass, section.rotary)
            for section in sections
        ]
    )
    long, bending, shear, mass, rotary = table.T[..., None]
    system = np.zeros((len(sections), len(square), 4, 4), dtype=np.result_type(square, tilting, float))
    system[..., 0, 1], system[..., 0, 2] = 1.0, bending / (shear * long**2)
    system[..., 1, 3], system[..., 3, 2] = 1.0, -1.0
    system[..., 2, 0] = -mass * long**4 / bending * square
    system[..., 3, 1] = -rotary * long**2 / bending * tilting
    carried = _exponential(system)
    a, b, c, d = (carried[..., i : i + 2, j : j + 2] for i in (0, 2) for j in (0, 2))
    across = np.linalg.inv(b)
    found = np.empty_like(system)
    found[..., :2, :2], found[..., :2, 2:] = across @ a, -across
    found[..., 2:, :2], found[..., 2:, 2:] = c - d @ across @ a, d @ across
    size = np.stack([1.0 / long, np.ones_like(long), 1.0 / long, np.ones_like(long)], axis=-1)
    return np.asarray(found * ((bending / long)[..., None, None] * size[..., :, None] * size[..., None, :]))


def _exponential(matrix: ComplexArray) -> ComplexArray:
    """Of many small matrices (..., n, n), by its series in fourth powers and squaring."""
    size = float(np.abs(matrix).sum(axis=-1).max(initial=_SMALL))
    turns = int(np.ceil(np.log2(size / _SMALL)))
    powers = [np.broadcast_to(np.eye(matrix.shape[-1]), matrix.shape), matrix / 2.0**turns]
    for _ in range(3):
        powers.append(powers[-1] @ powers[1])
    found = _SERIES[16] * powers[4]
    for k in (12, 8, 4, 0):
        found = found @ powers[4] if k < 12 else found
        found = found + sum(_SERIES[k + i] * powers[i] for i in range(4))
    for _ in range(turns):
        found = found @ found
    return np.asarray(found)
