"""A machine as built that spins: shafts by their waves, coupled with bodies and joints in one dynamic stiffness.

Shafts and supports are alike in both planes, so that what an unbalance drives goes round on circles, and one complex
deflection says both planes: forward at a positive frequency, backward at a negative one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import field, replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray, IntArray
from vibopt.bracketing import crossing
from vibopt.mechanics.built import Course, Joint, Motion
from vibopt.mechanics.built_algebra import at_rest, solved
from vibopt.mechanics.constants import GRAVITY
from vibopt.mechanics.machine import Machine
from vibopt.mechanics.shaft_waves import MODES
from vibopt.records import cached_property, dataclass

if TYPE_CHECKING:
    from typing import Self

_FAR = 1.3
"""Factor of a speed within which it is looked for between two others, where pieces say it badly."""
_ROUNDED = 1e-13
"""Part of the greatest period squared below which one is rounding, of a shaft that weighs next to nothing."""
_REAL = 1e-9
"""Part of itself by which a pole without damping may lie off the real axis."""
_NEWTON, _CLOSE, _AROUND = 12, 1e-14, 0.05
"""Steps of a secant or of Newton, the part of a speed by which it is known, and that by which it may lie off the one
of the pieces."""


@dataclass(frozen=True)
class RotatingMachine(Machine):
    """A machine with shafts that spin, all at the speed that is looked at.

    shafts
        By name of the rotor: a `WhirlingShaft`, or a `MatrixShaft`.
    """

    shafts: Mapping[str, Any] = field(default_factory=dict)
    on_structures: ClassVar[bool] = True

    @property
    def places(self) -> tuple[str, ...]:
        return (*self.masses, *(point for shaft in self.shafts.values() for point in shaft.points))

    @property
    def spinning(self) -> float:
        return float(sum(shaft.weighs for shaft in self.shafts.values()))

    def shake(self, omega: FloatArray, forces: dict[str, ComplexArray], bases: dict[str, ComplexArray]) -> Motion:
        """As `Machine.shake`, of a whirl with the spin on bases at rest; real frequencies and complex ones alike."""
        flat = np.ravel(omega)
        cut = self.cut_for(float(np.abs(flat).max(initial=0.0)))
        at, stiff = cut._exact_places, cut._dynamic(flat)
        load = np.zeros((len(flat), stiff.shape[-1]), dtype=complex)
        for name, force in forces.items():
            load[:, at[name]] += np.ravel(force)
        found = solved(stiff, load)
        points = {name: found[:, i].reshape(np.shape(omega)) for name, i in at.items()}
        points |= {base: np.zeros(np.shape(omega), dtype=complex) for base in self.bases}
        return Motion(points, forces, omega, inner=found)

    def stress_at(self, end: str, motion: Motion) -> ComplexArray:
        """Greatest of bending at one end of a span, NAME@1.left for instance, in a steady motion [Pa]."""
        assert motion.inner is not None
        shaft, k, right, own = self._end_of(end, motion.omega)
        moment = shaft.moment(k, right, np.ravel(motion.omega) ** 2, motion.inner[:, own])
        return np.asarray(moment * shaft.sections[k].stress).reshape(np.shape(motion.omega))

    def _end_of(self, end: str, omega: FloatArray) -> tuple[Any, int, int, slice]:
        """Of one end of a span its shaft as cut for such speeds, its section, its side and its four coordinates."""
        (rotor, _, span), top = end.partition("@"), float(np.abs(omega).max(initial=0.0))
        number, _, side = span.partition(".")
        shafts, right = self.cut_for(top).shafts, int(side == "right")
        k = self.shafts[rotor].cuts(top)[int(number) - 1 + right] - right
        before = list(shafts).index(rotor)
        begin = len(self.masses) + sum(shaft.size for shaft in list(shafts.values())[:before]) + 2 * k
        return shafts[rotor], k, right, slice(begin, begin + 4)

    def weight_stress_at(self, end: str) -> float:
        """As `stress_at`, under the weights alone, by the balance of what lies left of there; infinite without hold."""
        rotor, _, span = end.partition("@")
        number, _, side = span.partition(".")
        shaft, k, sag = self.shafts[rotor], int(number) - 1, self.sag()
        if sag is None:
            return math.inf
        places = np.cumsum([0.0, *(section.length for section in shaft.sections)])
        at = places[k + (side == "right")]
        moment = -sum(disc.mass * GRAVITY * max(at - places[disc.node], 0.0) for disc in shaft.discs)
        for begin, section in zip(places[: k + (side == "right")], shaft.sections, strict=False):
            moment -= section.mass * section.length * GRAVITY * (at - begin - 0.5 * section.length)
        for joint in self.joints:
            for here, there in (joint.ends, joint.ends[::-1]):
                if here in shaft.points:
                    carries = joint.static_stiffness * (sag[here] - sag.get(there, 0.0))
                    moment += carries * max(at - places[shaft.points[here]], 0.0)
        return float(abs(moment) * shaft.sections[k].stress)

    @cached_property
    def _exact_places(self) -> dict[str, int]:
        """Number of the coordinate of each body and point in the exact dynamic stiffness."""
        found, start = {name: i for i, name in enumerate(self.masses)}, len(self.masses)
        for shaft in self.shafts.values():
            found |= {point: start + 2 * node for point, node in shaft.points.items()}
            start += shaft.size
        return found

    def _dynamic(
        self, omega: ComplexArray | FloatArray, spin: FloatArray | None = None, *, braked: bool = False
    ) -> ComplexArray:
        """Of the whole at frequencies (n,) [rad/s], each with its spin or that of a whirl with it, (n, size, size).

        `braked` as of `WhirlingShaft.dynamic`.
        """
        stiff = self._shafts_alone(omega, spin, braked=braked)
        for joint, ends in self._joined(self._exact_places):
            z = joint.dynamic(np.asarray(omega))
            for i, a in ends:
                for j, b in ends:
                    stiff[:, i, j] += a * b * z
        return stiff

    def _shafts_alone(self, omega: Any, spin: Any, *, braked: bool = False) -> ComplexArray:
        """As `_dynamic`, without joints."""
        start = len(self.masses)
        size = start + sum(shaft.size for shaft in self.shafts.values())
        stiff = np.zeros((len(omega), size, size), dtype=complex)
        for i, mass in enumerate(self.masses.values()):
            stiff[:, i, i] -= mass * omega**2
        for one in self.shafts.values():
            stiff[:, start : start + one.size, start : start + one.size] = one.dynamic(omega, spin, braked=braked)
            start += one.size
        return stiff

    def _joined(self, places: Mapping[str, int]) -> Iterator[tuple[Any, list[tuple[int, float]]]]:
        """Each joint with the coordinates of its ends that move freely, and their signs in its stretch."""
        for joint in self.joints:
            yield (
                joint,
                [(places[end], sign) for end, sign in zip(joint.ends, (-1.0, 1.0), strict=True) if end in places],
            )

    @cached_property
    def slow(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
        """M, C, K, hysteretic stiffness and polar inertia of all pieces, each (n, n), good for slow motion."""
        parts = [shaft.slow for shaft in self.shafts.values()]
        size = len(self.masses) + sum(len(part[0]) for part in parts)
        mass, damping, stiffness, hysteretic, polar = (np.zeros((size, size)) for _ in range(5))
        mass[range(len(self.masses)), range(len(self.masses))] = list(self.masses.values())
        places, start = {name: i for i, name in enumerate(self.masses)}, len(self.masses)
        for shaft, (stiff, inertia, tilted) in zip(self.shafts.values(), parts, strict=True):
            here = slice(start, start + len(stiff))
            stiffness[here, here], mass[here, here], polar[here, here] = stiff, inertia, tilted
            damping[here, here] += shaft.drag
            places |= {point: start + shaft.place(point) for point in shaft.points}
            start += len(stiff)
        for joint, ends in self._joined(places):
            for target, value in zip((mass, damping, stiffness, hysteretic), joint.four, strict=True):
                for i, a in ends:
                    for j, b in ends:
                        target[i, j] += a * b * value
        return mass, damping, stiffness, hysteretic, polar

    def matrices(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """M, C, K and hysteretic stiffness of a whirl with the spin, good for slow motion."""
        mass, damping, stiffness, hysteretic, polar = self.slow
        return mass - polar, damping, stiffness, hysteretic

    def poles(self) -> ComplexArray:
        """Complex speeds at which the unbalance response is singular [rad/s]; those without damping exact."""
        mass, damping, stiffness, hysteretic = self.matrices()
        found = inverse_poles(mass, damping, stiffness + 1j * hysteretic)
        real = np.abs(found.imag) <= _REAL * np.abs(found)
        slow = np.abs(found) <= np.sort(np.abs(found))[: 2 * MODES][-1]
        here = np.flatnonzero(real & slow)
        met = np.sign(found[here].real) * self._met(np.abs(found[here].real))
        found[here] = np.where(np.isnan(met), found[here], met)  # where peaks are looked for, and no answer itself
        return found

    def cut_for(self, omega: float) -> Self:
        """The same in stretches that are short enough for a frequency [rad/s]."""
        shafts = {name: shaft.cut(omega) for name, shaft in self.shafts.items()}
        same = all(shaft is shafts[name] for name, shaft in self.shafts.items())
        return self if same else replace(self, shafts=shafts)

    def _met(self, omega: FloatArray, sense: float = 1.0, numbers: IntArray | None = None) -> FloatArray:
        """The frequencies near `omega` (n,) [rad/s] at which the whole without damping resists some motion no more.

        `sense` is 1 of a whirl with the spin and -1 of one against it, both at the speed of the spin.  By their
        `numbers` (n,), the lowest is 0, it is the value of that number which falls through zero; else the nearest.
        """
        found, cuts = omega.copy(), [self.cut_for(float(one)) for one in omega]
        sizes = np.array([sum(shaft.size for shaft in cut.shafts.values()) for cut in cuts])
        for size in np.unique(sizes):
            here = np.flatnonzero(sizes == size)
            ranks = None if numbers is None else numbers[here]
            found[here] = cuts[here[0]]._met_whole(omega[here], sense, ranks)
        return found

    def _met_whole(self, omega: FloatArray, sense: float, numbers: IntArray | None) -> FloatArray:
        """As `_met`, in the stretches that there are."""
        before, here = omega * (1.0 + 1e-5), omega.copy()
        low, high = self._least(before, sense, numbers), self._least(here, sense, numbers)
        left = np.ones(len(omega), dtype=bool)
        for _ in range(_NEWTON):
            left &= (high != low) & (np.abs(here - before) > _CLOSE * np.abs(here))
            if not left.any():
                break
            with np.errstate(divide="ignore", invalid="ignore"):
                there = here - high * (here - before) / (high - low)
                astray = left & ~(np.abs(there - omega) <= _AROUND * np.abs(omega))
            left &= ~astray
            for i in np.flatnonzero(astray).tolist():
                here[i] = self._between(omega[i], sense, None if numbers is None else int(numbers[i]))
            before[left], low[left], here[left] = here[left], high[left], there[left]
            high[left] = self._least(here[left], sense, None if numbers is None else numbers[left])
        return here

    def _least(self, omega: FloatArray, sense: float, numbers: IntArray | None) -> FloatArray:
        """Eigenvalue of the dynamic stiffness without dampers at frequencies (n,) [rad/s], scaled; as of `_met`."""
        values = np.linalg.eigvalsh(self._scaled(omega, sense))
        ranks = np.abs(values).argmin(axis=-1) if numbers is None else np.minimum(numbers, values.shape[1] - 1)
        return np.asarray(np.take_along_axis(values, ranks[:, None], axis=-1)[:, 0])

    def _scaled(self, omega: FloatArray, sense: float) -> FloatArray:
        """Dynamic stiffness without dampers at frequencies (n,) [rad/s], over its static size, (n, size, size)."""
        return np.asarray(self._dynamic(sense * omega, omega).real / np.outer(self._size, self._size))

    def _between(self, near: float, sense: float, number: int | None) -> float:
        """As `_met` of one of them, between a lower and a higher frequency: of its number, else the nearest.

        No number at all where it is not there, so that no answer stands on it.
        """
        below = int((np.linalg.eigvalsh(self._scaled(np.array([near]), sense)[0]) < 0.0).sum())
        met = [math.nan]
        for rank in (below - 1, below) if number is None else (number,):

            def risen(at: float, rank: int = rank) -> float:
                return -float(self._least(np.array([at]), sense, np.array([rank]))[0])

            low, high = near / _FAR, near * _FAR
            if rank >= 0 and risen(low) < 0.0 < risen(high):
                met.append(crossing(risen, low, high, _CLOSE)[0])
        return min(met, key=lambda value: math.inf if math.isnan(value) else abs(value - near))

    @cached_property
    def _size(self) -> FloatArray:
        """Root of the static stiffness of each coordinate in `_dynamic`."""
        return np.asarray(np.sqrt(np.diagonal(self._dynamic(np.zeros(1))[0].real)))

    def critical_speeds(self, sense: float = 1.0) -> FloatArray:
        """Speeds at which a whirl with the spin, or against it (`sense` -1), is free, ascending [rad/s].

        The lowest of them, by the equations of the waves, begun at those of the pieces.
        """
        mass, _, stiffness, _, polar = self.slow
        squares = inverse_squares(mass - sense * polar, stiffness)
        speeds = np.sqrt(1.0 / squares[squares > _ROUNDED * squares.max()])
        quick = min(shaft.quick for shaft in self.shafts.values())
        lowest = np.sort(speeds[speeds <= quick])[:MODES]
        return np.sort(self._met(lowest, sense, np.arange(len(lowest))))

    def free_whirls(self, spin: float) -> FloatArray:
        """Frequencies of undamped whirl at a spin [rad/s], forward ones above zero and backward ones below, ascending.

        By the pieces; none above where their waves are short.
        """
        moved, turned = self._at_rest
        n = len(moved)
        periods = np.linalg.eigvalsh(np.block([[-spin * turned, moved], [moved.T, np.zeros((n, n))]]))
        found = 1.0 / periods[np.abs(periods) > _REAL * np.abs(periods).max()]
        return np.sort(found[np.abs(found) <= min(shaft.quick for shaft in self.shafts.values())])

    @cached_property
    def _at_rest(self) -> tuple[FloatArray, FloatArray]:
        """Root of M and polar inertia over the root of K, each (n, n).

        With v = w u, K u = w (M v - W P u) and M v = w M u are one symmetric problem of 1 / w, positive on its left.
        """
        mass, _, stiffness, _, polar = self.slow
        root = np.linalg.inv(np.linalg.cholesky(stiffness))
        sizes, ways = np.linalg.eigh(mass)
        return root @ (ways * np.sqrt(np.maximum(sizes, 0.0))), root @ polar @ root.T

    def threshold(self, top: float = 0.0) -> float:
        """Least spin [rad/s] beyond which a whirl grows, infinite where none does: by the waves, begun at the pieces.

        Where a complex value of the dynamic stiffness of whirl w at spin W is nothing at once in both its parts.
        """
        mass, damping, stiffness, _, polar = self.slow
        turning = self.turning_damping
        begun = _neutral(mass, damping + turning, turning, stiffness, polar)
        if begun is None:
            return float("inf")
        cut = self.cut_for(1.5 * begun[0])

        def least(whirl: float, spin: float) -> complex:
            stiff = cut._dynamic(np.array([whirl]), np.array([spin]), braked=True)[0].astype(complex)
            for joint, ends in cut._joined(cut._exact_places):
                for i, a in ends:
                    for j, b in ends:
                        stiff[i, j] += a * b * 1j * joint.rotating * (whirl - spin)
            values = np.linalg.eigvals(stiff / np.outer(cut._size, cut._size))
            return complex(values[np.abs(values).argmin()])

        return vanishing(least, begun)

    @property
    def turning_damping(self) -> FloatArray:
        """Damping that turns with shafts, of slow motion, (n, n) [N s/m]."""
        found = self.lagging.copy()
        for joint, ends in self._joined(self.slow_places):
            for i, a in ends:
                for j, b in ends:
                    found[i, j] += a * b * joint.rotating
        return found

    def joint_course(self, joint: Joint, course: Course) -> FloatArray:
        found = super().joint_course(joint, course)
        if joint.rotating:
            apart = course.points[joint.ends[1]] - course.points[joint.ends[0]]
            found = found - joint.rotating * (apart[1] - 1j * course.spins * apart[0])
        return found

    @cached_property
    def lagging(self) -> FloatArray:
        """Damping by the material of shafts, of slow motion, (n, n) [N s/m]."""
        start, size = len(self.masses), len(self.slow[0])
        found = np.zeros((size, size))
        for shaft in self.shafts.values():
            stop = start + len(shaft.slow[0])
            found[start:stop, start:stop] = shaft.lags * shaft.slow[0]
            start = stop
        return found

    def natural_frequencies(self) -> FloatArray:
        """Critical speeds of the whirl with the spin, which an unbalance drives [rad/s]."""
        return self.critical_speeds()

    def sag(self) -> dict[str, float] | None:
        """Displacement of every point under the weights of bodies, shafts and discs [m]."""
        mass, _, stiffness, _, _ = self.slow
        for joint, ends in self._joined(self.slow_places):
            for i, a in ends:
                for j, b in ends:
                    stiffness = stiffness.copy()
                    stiffness[i, j] += a * b * (joint.static_stiffness - joint.stiffness)
        down = np.zeros(len(mass))
        down[: len(self.masses)] = [self.weights[name] for name in self.masses]
        start = len(self.masses)
        for shaft in self.shafts.values():
            stop = start + len(shaft.slow[0])
            down[start:stop] = shaft.slow[1] @ np.tile([1.0, 0.0], (stop - start) // 2)
            start = stop
        found = at_rest(stiffness, GRAVITY * down)
        return None if found is None else {name: float(found[i]) for name, i in self.slow_places.items()}

    @cached_property
    def slow_places(self) -> dict[str, int]:
        """Number of the coordinate of each body and point among those of slow motion."""
        found, start = {name: i for i, name in enumerate(self.masses)}, len(self.masses)
        for shaft in self.shafts.values():
            found |= {point: start + shaft.place(point) for point in shaft.points}
            start += len(shaft.slow[0])
        return found


def _neutral(
    mass: FloatArray, damping: FloatArray, turning: FloatArray, stiffness: FloatArray, polar: FloatArray
) -> tuple[float, float] | None:
    """Whirl and least spin [rad/s] at which one of the lowest free motions neither grows nor fades; None of none."""
    if not turning.any():
        return None
    root = np.linalg.inv(np.linalg.cholesky(stiffness))
    periods, vectors = np.linalg.eigh(root @ mass @ root.T)
    lowest = periods[: -4 * MODES - 1 : -1]
    lowest = lowest[lowest > _ROUNDED * lowest[0]]
    shapes, squares = root.T @ vectors[:, : -len(lowest) - 1 : -1] / np.sqrt(lowest), 1.0 / lowest
    drag, cross, turned = (shapes.T @ one @ shapes for one in (damping, turning, polar))
    spring, n = np.diag(squares), len(squares)

    def growth(spin: float) -> tuple[float, float]:
        state = np.block([[-drag + 1j * spin * turned, -spring + 1j * spin * cross], [np.eye(n), np.zeros((n, n))]])
        rates = np.linalg.eigvals(state)
        one = rates[rates.real.argmax()]
        return float(one.real), float(one.imag)

    low, slow = 0.0, float(np.sqrt(squares[0]))
    for high in slow * np.geomspace(0.4, 300.0, 48):
        if growth(high)[0] > _REAL * slow:
            spin = crossing(lambda at: growth(at)[0] - _REAL * slow, low, float(high), 1e-12)[1]
            return growth(spin)[1], spin
        low = float(high)
    return None


def inverse_squares(mass: FloatArray, stiffness: FloatArray) -> FloatArray:
    """Eigenvalues 1/w^2 of M over K (n, n): K is positive, M need not be; below zero where nothing is free."""
    root = np.linalg.inv(np.linalg.cholesky(stiffness))
    return np.asarray(np.linalg.eigvalsh(root @ mass @ root.T))


def vanishing(least: Callable[[float, float], complex], begun: tuple[float, float]) -> float:
    """The spin near `begun`, a whirl and a spin [rad/s], at which a complex value of both is nothing: by Newton."""
    at = np.array(begun)
    for _ in range(_NEWTON):
        here, steps = least(*at), 1e-6 * at
        slopes = [(least(*(at + move)) - least(*(at - move))) / (2.0 * move.sum()) for move in np.diag(steps)]
        table = [[slope.real for slope in slopes], [slope.imag for slope in slopes]]
        step = np.linalg.solve(table, [-here.real, -here.imag])
        at = at + step
        if np.all(np.abs(step) <= 1e-13 * np.abs(at)):
            break
    return float(at[1])


def inverse_poles(mass: FloatArray, damping: FloatArray, stiffness: ComplexArray | FloatArray) -> ComplexArray:
    """Frequencies w with det(K + i w C - w^2 M) = 0 [rad/s], of an M that need not be positive: by those of 1 / w."""
    n = len(mass)
    unit = float(np.sqrt(np.abs(np.diag(stiffness)).max() / np.abs(np.diag(mass)).max()))
    flexible = np.linalg.solve(stiffness, np.hstack([mass * unit**2, -1j * unit * damping]))
    state = np.block([[np.zeros((n, n)), np.eye(n)], [flexible]])
    inverse = np.linalg.eigvals(state)
    return np.asarray(unit / inverse[np.abs(inverse) > 1e-12 * np.abs(inverse).max()], dtype=complex)
