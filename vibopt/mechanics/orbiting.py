"""A machine as built whose rotors turn in bearings that are not alike in both planes: four coordinates of each node.

Deflection and tilt in the planes y and z, coupled by gyroscopic moments and by bearings; amplitudes of e^{i w t}, z a
quarter turn ahead of y in the sense of the spin.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import field, replace
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.bracketing import crossing
from vibopt.mechanics.built import Course, Joint, Motion, PlaneBearing
from vibopt.mechanics.built_algebra import solved
from vibopt.mechanics.machine import Machine
from vibopt.mechanics.rotating import RotatingMachine, inverse_poles, vanishing
from vibopt.records import cached_property, dataclass

if TYPE_CHECKING:
    from typing import Self

_LOWEST, _ROUNDED, _REAL, _SLIM, _STEPS = 20, 1e-12, 1e-9, 1e-3, 12
"""Free motions at rest by which singular speeds are looked for, and the part of the longest period squared below which
one is rounding; parts of itself by which a speed without damping may lie off its axis, and one whose peak is so slim
that the waves must tell it; steps of a secant."""
FARTHEST, _SCANNED, _STILL = 50.0, 80, 1e-9
"""Spin over the lowest frequency at rest up to which growth is looked for where nothing says how far; spins at which it
is, evenly and near that frequency; part of the slowest frequency below which a rate is rounding."""
_HARDLY = 0.02
"""Part of a frequency that a whirl at the first spin grows or fades by at most where its pieces do not say which."""
_SKEW = 1e-12
"""Part of the greatest damping below which one is rounding."""
_EVEN = 4
"""Spins of the whole range of tables, beside their rows, at which singular speeds are looked for."""


@dataclass(frozen=True)
class OrbitingMachine(RotatingMachine):
    """A machine with bearings in planes, by name; each stands among `joints` as well, without a force of its own."""

    bearings: Mapping[str, PlaneBearing] = field(default_factory=dict)

    def shake(self, omega: FloatArray, forces: dict[str, ComplexArray], bases: dict[str, ComplexArray]) -> Motion:
        """As `Machine.shake`: points (2, ...) along y and z, under forces that go round with the spin."""
        flat = np.ravel(omega)
        cut = self.cut_for(float(np.abs(flat).max(initial=0.0)))
        at, stiff = cut._exact_places, cut.planes(flat)
        n = stiff.shape[-1] // 2
        load = np.zeros((len(flat), 2 * n), dtype=complex)
        for name, force in forces.items():
            load[:, at[name]] += np.ravel(force)
            load[:, n + at[name]] -= 1j * np.ravel(force)
        found, shape = solved(stiff, load), np.shape(omega)
        points = {name: np.stack([found[:, i], found[:, n + i]]).reshape(2, *shape) for name, i in at.items()}
        both = {name: np.stack([force, -1j * force]) for name, force in forces.items()}
        return Motion(points, both, omega, inner=found)

    def size(self, value: ComplexArray) -> ComplexArray:
        """Greater half axis of the ellipse on which (2, ...) goes round."""
        y, z = value
        return np.asarray(np.sqrt(0.5 * (np.abs(y) ** 2 + np.abs(z) ** 2 + np.abs(y**2 + z**2))), dtype=complex)

    def planes(
        self, omega: ComplexArray | FloatArray, spin: FloatArray | None = None, *, braked: bool = False
    ) -> ComplexArray:
        """Dynamic stiffness over y, then z, at frequencies (k,) [rad/s] and spins, those of an unbalance without.

        `braked` as of `WhirlingShaft.dynamic`.
        """
        turn = np.asarray(omega) if spin is None else spin
        forward, backward = (
            self._shafts_alone(np.asarray(omega), sense * turn, braked=braked) for sense in (1.0, -1.0)
        )
        n = forward.shape[-1]
        found = np.zeros((len(forward), 2 * n, 2 * n), dtype=complex)
        found[:, :n, :n] = found[:, n:, n:] = 0.5 * (forward + backward)
        found[:, :n, n:], found[:, n:, :n] = 0.5j * (forward - backward), -0.5j * (forward - backward)
        for joint, ends in self._joined(self._exact_places):
            force = self.force_of(joint, np.asarray(omega), np.asarray(turn))
            for i, a in ends:
                for j, b in ends:
                    found[:, [[i], [n + i]], [j, n + j]] += a * b * force
        return found

    def force_of(self, joint: Joint, omega: Any, spin: Any) -> ComplexArray:
        """Force of a joint along each plane per stretch along each, (k, 2, 2); a damper that turns feels the spin."""
        found = joint.dynamic(omega)[:, None, None] * np.eye(2, dtype=complex)
        if joint.rotating:
            turned = np.array([[0.0, 1.0], [-1.0, 0.0]])
            found += joint.rotating * (1j * omega[:, None, None] * np.eye(2) + spin[:, None, None] * turned)
        if joint.name in self.bearings:
            stiff, damp = self.bearings[joint.name].at(np.abs(np.real(spin)))
            found += stiff + 1j * omega[:, None, None] * damp
        return found

    def joint_force(self, joint: Joint, motion: Motion) -> ComplexArray:
        flat = np.ravel(motion.omega)
        stretch = self.stretch_of(joint, motion).reshape(2, -1).T
        force = -(self.force_of(joint, flat, flat) @ stretch[..., None])[..., 0]
        return np.asarray(force.T.reshape(2, *np.shape(motion.omega)))

    def joint_course(self, joint: Joint, course: Course) -> FloatArray:
        """As of `Machine`, (2, n_times) of points (3, 2, n_times)."""
        found = Machine.joint_course(self, joint, course)
        apart = course.points[joint.ends[1]] - course.points[joint.ends[0]]
        turned = np.stack([apart[0, 1], -apart[0, 0]])
        found = found - joint.rotating * (apart[1] + course.spins * turned)
        if joint.name in self.bearings:
            stiff, damp = self.bearings[joint.name].at(course.spins)
            found = found - np.einsum("kij,jk->ik", stiff, apart[0]) - np.einsum("kij,jk->ik", damp, apart[1])
        return np.asarray(found)

    def position(self, point: str, motion: Motion) -> ComplexArray:
        if point in motion.points:
            return motion.points[point]
        return np.zeros((2, *np.shape(motion.omega)), dtype=complex)

    def force_into(self, place: str, motion: Motion) -> ComplexArray:
        """As of `Machine`, joint by joint."""
        into = [(joint, 1.0 if joint.ends[1] == place else -1.0) for joint in self.joints if place in joint.ends]
        none = np.zeros((2, *np.shape(motion.omega)), dtype=complex)
        return sum((sign * self.joint_force(joint, motion) for joint, sign in into), none)

    def stress_at(self, end: str, motion: Motion) -> ComplexArray:
        """As of `RotatingMachine`, (2, ...) of bending in either plane."""
        assert motion.inner is not None
        shaft, k, right, own = self._end_of(end, motion.omega)
        y, z = (half[:, own] for half in np.split(motion.inner, 2, axis=1))
        squares = np.ravel(motion.omega) ** 2
        moments = [
            shaft.moment(k, right, squares, 0.5 * (y + sense * 1j * z), sense) * shaft.sections[k].stress
            for sense in (1.0, -1.0)
        ]
        found = np.stack([moments[0] + moments[1], -1j * (moments[0] - moments[1])])
        return found.reshape(2, *np.shape(motion.omega))

    @cached_property
    def undamped(self) -> Self:
        """The machine without dampers and loss factors."""
        joints = tuple(replace(joint, damping=0.0, loss_factor=0.0, rotating=0.0) for joint in self.joints)
        bearings = {name: replace(one, damping=0.0 * one.damping) for name, one in self.bearings.items()}
        return replace(self, joints=joints, bearings=bearings)

    def poles(self) -> ComplexArray:
        """Complex speeds near which the unbalance response is singular [rad/s], coefficients as at some spins."""
        knots = np.unique(
            [at for bearing in self.bearings.values() if len(bearing.speeds) > 1 for at in bearing.speeds.tolist()]
        )
        spins = np.zeros(1)
        if len(knots):
            middles = 0.5 * (knots[1:] + knots[:-1])
            spins = np.unique(np.concatenate([knots, middles, np.linspace(knots[0], knots[-1], _EVEN)]))
        found = []
        for spin in spins.tolist():
            mass, damping, stiffness = self.reduced(spin)
            polar = self._few[1]
            turned = np.kron(np.array([[0.0, 1j], [-1j, 0.0]]), polar)
            found.append(inverse_poles(cast("FloatArray", mass - turned), damping, stiffness))
        near = np.concatenate(found)
        real = (np.abs(near.imag) <= _REAL * np.abs(near)) & (near.real > 0.0)
        near[real] = [self._resisted_no_more(complex(one)) for one in near[real].real]
        return near

    def poles_below(self, top: float) -> ComplexArray:
        near = self.known_poles.copy()
        slim = (np.abs(near.imag) <= _SLIM * near.real) & (np.abs(near) <= 1.05 * top) & (near.imag != 0.0)
        near[slim] = [self._resisted_no_more(one) for one in near[slim].tolist()]
        return near

    @cached_property
    def _few(self) -> tuple[FloatArray, FloatArray]:
        """Lowest motions at rest (n, m), held in both planes alike, of unit stiffness, and polar inertia in them."""
        mass, _, stiffness, _, polar = self.slow
        stiffness = stiffness.copy()
        for bearing, ends in self._held():
            stiff = float(np.mean(np.trace(bearing.stiffness, axis1=1, axis2=2))) / 2.0
            for i, a in ends:
                for j, b in ends:
                    stiffness[i, j] += a * b * stiff
        root = np.linalg.inv(np.linalg.cholesky(stiffness))
        squares, vectors = np.linalg.eigh(root @ mass @ root.T)
        lowest = np.argsort(-squares)[:_LOWEST]
        shapes = (root.T @ vectors)[:, lowest[squares[lowest] > _ROUNDED * squares.max()]]
        return shapes, shapes.T @ polar @ shapes

    def reduced(self, spin: float) -> tuple[Any, Any, Any]:
        """M, C and K of the lowest motions in both planes at a spin [rad/s], that of a steady whirl with it."""
        shapes, both = self._few[0], np.eye(2)
        mass, damping, stiffness, hysteretic, _ = (shapes.T @ one @ shapes for one in self.slow)
        whole = [np.kron(both, one).astype(complex) for one in (damping, stiffness + 1j * hysteretic)]
        for bearing, ends in self._held():
            row = sum(sign * shapes[i] for i, sign in ends)
            for target, four in zip(whole, bearing.at(np.array([spin]))[::-1], strict=True):
                target += np.kron(four[0], np.outer(row, row))
        for joint, ends in self._joined(self.slow_places):
            if joint.rotating:  # y and z a quarter turn apart: nothing forward, twice as much backward
                row = sum(sign * shapes[i] for i, sign in ends)
                turned = np.array([[1.0, -1j], [1j, 1.0]])
                whole[0] = whole[0] + joint.rotating * np.kron(turned, np.outer(row, row))
        return np.kron(both, mass), whole[0], whole[1]

    def _growth(self, spin: float) -> tuple[float, float]:
        """Greatest rate of growth [1/s] of the lowest free motions at a spin, and its frequency [rad/s]."""
        mass, damping, stiffness = self.free(spin)
        n, inverse = len(mass), np.linalg.inv(mass)
        state = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ stiffness, -inverse @ damping]])
        rates = np.linalg.eigvals(state)
        one = rates[rates.real.argmax()]
        return float(one.real), float(abs(one.imag))

    def free(self, spin: float) -> tuple[Any, Any, Any]:
        """M, C and K of the lowest motions in both planes, free at a spin [rad/s]."""
        shapes, polar = self._few
        mass, damping, stiffness = (np.kron(np.eye(2), shapes.T @ one @ shapes) for one in self.slow[:3])
        turned = np.array([[0.0, 1.0], [-1.0, 0.0]])
        damping = damping + spin * np.kron(turned, polar)
        if any(shaft.lags for shaft in self.shafts.values()):
            lagging = shapes.T @ self.lagging @ shapes
            damping = damping + np.kron(np.eye(2), lagging)
            stiffness = stiffness + spin * np.kron(turned, lagging)
        for joint, ends in self._joined(self.slow_places):
            row = sum((sign * shapes[i] for i, sign in ends), np.zeros(shapes.shape[1]))
            square = np.outer(row, row)
            damping = damping + joint.rotating * np.kron(np.eye(2), square)
            stiffness = stiffness + spin * joint.rotating * np.kron(turned, square)
            if joint.name in self.bearings:
                stiff, damp = self.bearings[joint.name].at(np.array([spin]))
                damping, stiffness = damping + np.kron(damp[0], square), stiffness + np.kron(stiff[0], square)
        return mass, damping, stiffness

    def begun(self, omega: float, motion: ComplexArray) -> tuple[Self, ComplexArray]:
        """Short enough stretches for a frequency [rad/s], and a motion of `free` over their nodes, y then z."""
        cut, planes = self.cut_for(omega), []
        for moved in (self._few[0] @ half for half in np.split(motion, 2)):
            bodies, start, whole = len(self.masses), len(self.masses), []
            for shaft in self.shafts.values():
                stop = start + len(shaft.slow[0])
                whole.append(shaft.on_nodes(moved[start:stop], omega))
                start = stop
            planes.append(np.concatenate([moved[:bodies], *whole]))
        return cut, np.concatenate(planes)

    @property
    def tables(self) -> list[FloatArray]:
        return [bearing.speeds for bearing in self.bearings.values() if len(bearing.speeds) > 1]

    @property
    def known_spins(self) -> tuple[float, float]:
        return max([0.0, *(table[0] for table in self.tables)]), min([np.inf, *(table[-1] for table in self.tables)])

    @cached_property
    def slowest(self) -> float:
        """Lowest frequency at rest [rad/s]."""
        few = self._few[0]
        return float(1.0 / np.sqrt(np.linalg.norm(few.T @ self.slow[0] @ few, 2)))

    def grows(self, spin: float) -> bool:
        return self._growth(spin)[0] > _STILL * self.slowest

    def settled_to(self, top: float = 0.0) -> float:
        return self.searched(top) if self.tables or not self._idle else float("inf")

    def searched(self, top: float = 0.0) -> float:
        """Highest spin [rad/s] of a search for whirls that grow."""
        return float(min([top or FARTHEST * self.slowest, *(table[-1] for table in self.tables)]))

    def threshold(self, top: float = 0.0) -> float:
        """As of `RotatingMachine`, up to a spin and as far as tables go: lowest motions scanned, then the waves."""
        tables, slow, high = self.tables, self.slowest, self.searched(top)
        low = max((table[0] for table in tables), default=0.0)
        if self._idle:
            return float("inf")
        spins = np.concatenate([np.linspace(low, high, _SCANNED), slow * np.geomspace(1e-3, 10.0, _SCANNED), *tables])
        none, spins = _STILL * slow, np.unique(spins[(spins >= low) & (spins <= high)])
        growth: list[float] = []
        for k, spin in enumerate(spins.tolist()):
            growth.append(self._growth(spin)[0] - none if k else self._first(spin) - none)
            grows = spin if growth[k] > 0.0 else self._summit(spins[max(k - 2, 0) : k + 1], growth[-3:], none)
            if growth[0] > 0.0:
                return low
            if grows:
                begun = float(spins[max(k - 2, 0)])
                near = begun  # where the pieces grow already, and the waves fade
                if self._growth(begun)[0] <= none:
                    near = crossing(lambda at: self._growth(at)[0] - none, begun, grows, 1e-12)[1]
                return self._neutral(self._growth(near)[1], near)
        return float("inf")

    def _first(self, spin: float) -> float:
        """Greatest rate of growth at the first spin of all [1/s], by the waves where it hardly is one."""
        growth, whirl = self._growth(spin)
        if spin == 0.0 or abs(growth) > _HARDLY * whirl:
            return growth
        cut, turn = self.cut_for(1.5 * whirl), np.array([spin])
        size = np.sqrt(np.abs(np.diagonal(cut.planes(np.array([0.5 * whirl]), turn)[0])))

        def least(omega: float, above: float) -> complex:
            stiff = cut.planes(np.array([omega * (1.0 + 1j * (above - 1.0))]), turn, braked=True)[0]
            values = np.linalg.eigvals(stiff / np.outer(size, size))
            return complex(values[np.abs(values).argmin()])

        return whirl * (1.0 - vanishing(least, (whirl, 1.0 - growth / whirl)))

    def _summit(self, spins: FloatArray, growth: list[float], none: float) -> float:
        """A spin about the middle one of three at which something grows between them; 0 where nothing can."""
        from scipy.optimize import minimize_scalar

        if len(growth) < 3 or growth[1] < max(growth) or 2.0 * growth[1] <= min(growth):
            return 0.0
        ends = float(spins[0]), float(spins[2])
        top = minimize_scalar(lambda at: none - self._growth(at)[0], bounds=ends, method="bounded")
        return float(top.x) if top.fun < 0.0 else 0.0

    @cached_property
    def _idle(self) -> bool:
        """Whether nothing feeds a free motion at any spin that tables know: all is straight between their rows."""
        rows = np.unique(np.concatenate([[0.0, self.slowest], *self.tables]))
        low, high = self.known_spins
        return not any(self._fed(spin) for spin in rows[(rows >= low) & (rows <= high)].tolist())

    def _fed(self, spin: float) -> bool:
        """Whether forces may feed a free motion that goes round: a stiffness that is skew or pushes, or dampers."""
        skew = any(joint.rotating for joint in self.joints) or any(shaft.lags for shaft in self.shafts.values())
        films = [bearing.at(np.array([spin]))[0][0] for bearing in self.bearings.values()]
        if skew or any(film[0, 1] != film[1, 0] for film in films):
            return True
        _, damping, stiffness = self.free(spin)
        least = [float(np.linalg.eigvalsh(0.5 * (one + one.T))[0]) for one in (stiffness, damping)]
        return least[0] <= 0.0 or least[1] < -_SKEW * float(np.abs(damping).max())

    def _neutral(self, whirl: float, spin: float) -> float:
        """The spin near one at which a whirl of about such a frequency [rad/s] neither grows nor fades."""
        cut = self.cut_for(1.5 * whirl)
        size = np.sqrt(np.abs(np.diagonal(cut.planes(np.zeros(1), np.zeros(1))[0])))
        size[size == 0.0] = 1.0

        def least(omega: float, turn: float) -> complex:
            values = np.linalg.eigvals(cut.planes(np.array([omega]), np.array([turn]))[0] / np.outer(size, size))
            return complex(values[np.abs(values).argmin()])

        return vanishing(least, (whirl, spin))

    def _held(self) -> Iterator[tuple[PlaneBearing, list[tuple[int, float]]]]:
        """Each bearing with the slow coordinates of its ends, and their signs in its stretch."""
        for joint, ends in self._joined(self.slow_places):
            if joint.name in self.bearings:
                yield self.bearings[joint.name], ends

    def _resisted_no_more(self, near: complex) -> complex:
        """The speed near one [rad/s] at which some motion is free, real without damping; by the waves."""
        cut = self.cut_for(1.1 * abs(near))
        size = np.sqrt(np.abs(np.diagonal(cut.planes(np.zeros(1))[0])))

        def least(omega: complex) -> complex:
            values = np.linalg.eigvals(cut.planes(np.array([omega]))[0] / np.outer(size, size))
            value = complex(values[np.abs(values).argmin()])
            return value if near.imag else complex(value.real)

        before, here = near * (1.0 + 1e-5), near
        low = least(before)
        for _ in range(_STEPS):
            high = least(here)
            if high == low or abs(here - before) <= 1e-15 * abs(here):
                break
            before, here, low = here, here - high * (here - before) / (high - low), high
        return here if abs(here - near) <= 0.05 * abs(near) else near

    def natural_frequencies(self) -> FloatArray:
        """None: what is free is damped, changes with the spin, and is forward and backward at once."""
        return np.zeros(0)

    @cached_property
    def loose(self) -> int:
        """None: checked before."""
        return 0
