"""The machine as built: numbers only, assembled straight from bodies and links.

This is the second road.  It shares no matrices with `Model`: it is put together link by link,
works in real arithmetic, and reads forces off the balance of inertia where it can.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import field, replace
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from vibopt.arrays import BoolArray, ComplexArray, FloatArray
from vibopt.mechanics.built import GROUND, Course, Joint, Motion, Tuned
from vibopt.mechanics.built_algebra import (
    inverse_root,
    inverted,
    nullity,
    pencil_poles,
    settled,
    singular,
    steady_solution,
)
from vibopt.mechanics.constants import GRAVITY
from vibopt.mechanics.modal import WORTH, Modal, decompose
from vibopt.mechanics.turning import of_two
from vibopt.records import cached_property, dataclass

if TYPE_CHECKING:
    from typing_extensions import TypeIs

    from vibopt.mechanics.rigid import SpaceMachine

_MANY = 8
_LITTLE = 1e-3
"""Part of the motion of bases below which that of a mass is not told by how it moves beside them."""


@dataclass(frozen=True)
class Machine:
    """A chain of bodies.

    masses
        By body [kg], or [kg m^2] where it turns.
    joints
        Links, and the springs and dampers of absorbers.
    bases
        Names of moving bases.
    weights
        Part of each mass on which gravity acts along the coordinate [kg].
    tuned
        Absorbers by name.
    carried
        Of masses and weights, what belongs to beams that end there [kg].
    rates
        Rates of run-ups that were chosen with it, by path [rad/s^2].
    """

    masses: dict[str, float]
    joints: tuple[Joint, ...]
    bases: tuple[str, ...] = ()
    weights: Mapping[str, float] = field(default_factory=dict)
    tuned: Mapping[str, Tuned] = field(default_factory=dict)
    carried: Mapping[str, float] = field(default_factory=dict, kw_only=True)
    rates: Mapping[str, float] = field(default_factory=dict, kw_only=True)
    in_space: ClassVar[bool] = False
    on_structures: ClassVar[bool] = False

    @property
    def places(self) -> tuple[str, ...]:
        """Everything that moves freely, by name."""
        return tuple(self.masses)

    @property
    def in_full(self) -> Machine:
        """The same machine, nothing shortened to save time."""
        return self

    def turning(self, read: Callable[[FloatArray], FloatArray], power: float) -> FloatArray | None:
        """Every frequency [rad/s] at which a reading times w**power may be greatest; None where not known.

        Of one body also those at which it may be least.

        `read` is the modulus under a unit amplitude at frequencies of any shape.
        """
        if len(self.masses) != 2 or self.in_space or self.on_structures or self.jointed.any():
            return None
        return of_two(read, self._equations, self.known_poles, power)

    @property
    def rubs(self) -> bool:
        """Whether a joint has dry friction."""
        return any(joint.friction for joint in self.joints)

    @property
    def rubbing(self) -> Joint:
        """The first joint that rubs, with the dry friction of all that slip together with it."""
        every = [joint for joint in self.joints if joint.friction]
        return replace(every[0], friction=sum(joint.friction for joint in every))

    def joint(self, name: str) -> Joint:
        """The joint of a name."""
        return next(one for one in self.joints if one.name == name)

    def shake(self, omega: FloatArray, forces: dict[str, ComplexArray], bases: dict[str, ComplexArray]) -> Motion:
        """Motion under forces [N] on bodies and motions [m] of bases, each of the shape of `omega`.

        Solved in real arithmetic for the cosine and the sine part of every displacement; a complex `omega` continues
        it off the axis.
        """
        if np.iscomplexobj(omega) or self.loose:
            return self._shake_stretched(omega, forces, bases)
        moved = self._shake_outright(omega, forces, bases)
        if not bases or len(self.masses) >= WORTH:
            return moved
        stretched, common = self._shake_stretched(omega, forces, bases), sum(np.abs(one) for one in bases.values())
        little = {name: np.abs(one) < _LITTLE * common for name, one in moved.points.items()}
        points = {name: np.where(little[name], moved.points[name], one) for name, one in stretched.points.items()}
        apart = {}
        for joint in self.joints:
            first, second = joint.ends
            both = little.get(first, False) & little.get(second, False)
            outright = self.position(second, moved) - self.position(first, moved)
            apart[joint.name] = np.where(both, outright, stretched.stretches[joint.name])
        return replace(stretched, points=points, stretches=apart)

    def _shake_outright(
        self, omega: FloatArray, forces: dict[str, ComplexArray], bases: dict[str, ComplexArray]
    ) -> Motion:
        """As `shake`, in the motions of all masses: what hardly follows a base keeps its digits."""
        names = list(self.masses)
        load = np.zeros((*omega.shape, len(names)), dtype=complex)
        for i, name in enumerate(names):
            load[..., i] = forces.get(name, 0.0)
        for joint in self.joints if bases else ():
            for here, there in (joint.ends, joint.ends[::-1]):
                if here in self.masses and there in bases:
                    load[..., names.index(here)] += joint.dynamic(omega) * bases[there]
        if len(names) >= WORTH and omega.size > _MANY and self._modes is not None:
            moved = self._modes.motion(load, omega)
        else:
            mass, damping, stiffness, hysteretic = self._equations
            flat = np.ravel(omega)[:, None, None]
            elastic, dash = stiffness - flat**2 * mass, flat * damping + hysteretic
            moved = steady_solution(elastic, dash, load.reshape(-1, len(names))).reshape(load.shape)
        points = {name: moved[..., i] for i, name in enumerate(names)}
        for base in self.bases:
            points[base] = bases.get(base, np.zeros(omega.shape, dtype=complex))
        return Motion(points, forces, omega)

    @cached_property
    def known_poles(self) -> ComplexArray:
        """Its poles, found once."""
        return self.poles()

    def poles_below(self, top: float) -> ComplexArray:
        """Its poles, those up to a frequency [rad/s] to as many digits as their peaks are slim."""
        return self.known_poles

    @cached_property
    def _equations(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        return self.matrices()

    @cached_property
    def _modes(self) -> Modal | None:
        mass, damping, stiffness, hysteretic = self._equations
        return decompose(mass, damping, stiffness + 1j * hysteretic)

    def _shake_stretched(
        self, omega: FloatArray, forces: dict[str, ComplexArray], bases: dict[str, ComplexArray]
    ) -> Motion:
        """As `shake`, in the stretches of a tree of joints: small ones keep their digits beside a common motion."""
        rows, n, flat = self._stretched, len(self.masses), np.ravel(omega)
        own, extensions = (np.array([*kind.values()]).reshape(-1, n + len(self.bases)) for kind in rows)
        own = own[:n]
        inert, damper, spring, lossy = ((extensions.T * four) @ extensions for four in self._fours)
        heavy = (own.T * np.array([*self.masses.values()])) @ own + inert
        elastic = spring[:n] - flat[:, None, None] ** 2 * heavy[:n]
        turned = flat[:, None, None] * damper[:n] + lossy[:n]
        load = np.zeros((flat.size, n), dtype=complex)
        for name, force in forces.items():
            load += np.ravel(force)[:, None] * rows[0][name][:n]
        still = np.zeros(flat.size, dtype=complex)
        moved = np.array([np.ravel(bases[name]) if name in bases else still for name in self.bases]).reshape(
            -1, flat.size
        )
        load -= ((elastic + 1j * turned)[:, :, n:] @ moved.T[..., None])[..., 0]
        found = np.hstack([steady_solution(elastic[..., :n], turned[..., :n], load), moved.T])
        points, apart = (
            {name: np.asarray((found @ row).reshape(omega.shape), dtype=complex) for name, row in kind.items()}
            for kind in rows
        )
        return Motion(points, forces, np.asarray(omega), apart)

    @property
    def _fours(self) -> FloatArray:
        """What each joint adds to M, C, K and the hysteretic stiffness, shape (4, n_joints)."""
        return np.array([joint.four for joint in self.joints]).reshape(-1, 4).T

    @cached_property
    def _stretched(self) -> tuple[dict[str, FloatArray], dict[str, FloatArray]]:
        """Rows of points and extensions of joints over the stretches of a tree, and the bases.

        The tree grows from the supports by the stiffest joint; what hangs on none has a root of its own.
        """
        unit = np.eye(len(self.masses) + len(self.bases))
        number = {name: i for i, name in enumerate((*self.masses, *self.bases))}
        rows = {name: unit[number[name]] for name in self.bases} | {GROUND: np.zeros(len(unit))}
        order = sorted(self.joints, key=lambda one: (-one.stiffness, -one.damping))
        while len(rows) <= len(unit):
            leads = next((joint for joint in order if len({*joint.ends} & {*rows}) == 1), None)
            if leads is None:
                new = next(name for name in self.masses if name not in rows)
                rows[new] = unit[number[new]]
                continue
            known, new = leads.ends if leads.ends[0] in rows else leads.ends[::-1]
            rows[new] = rows[known] + unit[number[new]]
        points = {name: rows[name] for name in number}
        return points, {joint.name: rows[joint.ends[1]] - rows[joint.ends[0]] for joint in self.joints}

    def size(self, value: ComplexArray) -> ComplexArray:
        """What of a reading counts as its amplitude, shape of the speeds: itself where all moves along one line."""
        return value

    def joint_force(self, joint: Joint, motion: Motion) -> ComplexArray:
        """Force of the whole joint on its second end [N], positive along the coordinate."""
        force: ComplexArray = -joint.dynamic(motion.omega) * self.stretch_of(joint, motion)
        if joint.carried[1]:
            force = force + joint.carried[1] * motion.omega**2 * self.position(joint.ends[1], motion)
        return force

    def stretch_of(self, joint: Joint, motion: Motion) -> ComplexArray:
        """Second end of a joint less its first [m]."""
        if joint.name in motion.stretches:
            return motion.stretches[joint.name]
        first, second = joint.ends
        return self.position(second, motion) - self.position(first, motion)

    def position(self, point: str, motion: Motion) -> ComplexArray:
        if point == GROUND or point not in motion.points:
            return np.zeros(motion.omega.shape, dtype=complex)
        return motion.points[point]

    def stretch_course(self, joint: Joint, course: Course) -> FloatArray:
        """Second end of a joint less its first in time, with its first two rates, (3, n_times) [m, m/s, m/s^2]."""
        first, second = (course.points.get(end, np.zeros((3, 1))) for end in joint.ends)
        return np.asarray(second - first)

    @property
    def coordinate_names(self) -> tuple[str, ...]:
        """Coordinates of what moves freely, those of the bases behind them."""
        return (*self.masses, *self.bases)

    @property
    def n_free(self) -> int:
        """How many of the coordinates are of what moves freely."""
        return len(self.masses)

    def pushes(self, acts: Mapping[str, complex]) -> FloatArray:
        """Forces on coordinates, accelerations of those of bases, of what acts on places by their names, (n,)."""
        return np.array([acts.get(place, 0.0).real for place in self.coordinate_names])

    def begins(self, acts: Mapping[str, complex]) -> FloatArray:
        """Displacements of coordinates (n,) of a body that is released along the directions of `acts` by one."""
        return self.pushes(acts)

    def parts_in_time(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Inertia, damping and stiffness over all coordinates, each (n, n); those of bases as links pull on bodies."""
        return self._over(self.coordinate_names)[:3]

    def points_in_time(self, moved: FloatArray) -> dict[str, FloatArray]:
        """Displacement and its two rates (3, n_times) of every place, from those of coordinates (3, n, n_times)."""
        return dict(zip(self.coordinate_names, moved.transpose(1, 0, 2), strict=True))

    def joint_course(self, joint: Joint, course: Course) -> FloatArray:
        """Force of the whole joint on its second end in time [N], (n_times,); positive along the coordinate."""
        apart = self.stretch_course(joint, course)
        pulled = joint.stiffness * apart[0] + joint.damping * apart[1] + joint.inertance * apart[2]
        if joint.carried[1]:
            pulled = pulled + joint.carried[1] * course.points.get(joint.ends[1], np.zeros((3, 1)))[2]
        return np.asarray(-(pulled + course.rubbing.get(joint.name, 0.0)))

    def force_course(self, place: str, course: Course) -> FloatArray:
        """Dynamic force of all joints into a body, base or the ground in time [N], (n_times,).

        Into a body: its inertia force less what acts on it from outside.
        """
        if place in self.masses:
            return np.asarray(self.own(place) * course.points[place][2] - course.forces.get(place, np.zeros(1)))
        into = [joint for joint in self.joints if place in joint.ends]
        forces = [(1.0 if joint.ends[1] == place else -1.0) * self.joint_course(joint, course) for joint in into]
        return np.asarray(sum(forces, np.zeros(1)))

    def force_into(self, place: str, motion: Motion) -> ComplexArray:
        """Dynamic force of all joints into a body, base or the ground [N].

        Into a body: its inertia force less what acts on it from outside.  Into the only support
        of what hangs on it: all external forces less all inertia forces.  Else joint by joint.
        """
        if place in self.masses:
            beams = self.carried.get(place, 0.0) * motion.omega**2 * motion.points[place]
            return self._inertia(place, motion) + beams - self._external(place, motion)
        group = self._hanging_on(place)
        if group is None:
            into = [joint for joint in self.joints if place in joint.ends]
            signs = [1.0 if joint.ends[1] == place else -1.0 for joint in into]
            zero = np.zeros(motion.omega.shape, dtype=complex)
            return sum((s * self.joint_force(j, motion) for s, j in zip(signs, into, strict=True)), zero)
        total = np.zeros(motion.omega.shape, dtype=complex)
        for body in (mass for mass in self.masses if mass in group):  # a set has an order of its own in each process
            total = total + self._external(body, motion) - self._inertia(body, motion)
        return total

    def own(self, body: str) -> float:
        """What a body resists by itself, without beams that end there [kg] or [kg m^2]."""
        return self.masses[body] - self.carried.get(body, 0.0)

    def _inertia(self, body: str, motion: Motion) -> ComplexArray:
        """Mass times acceleration [N]."""
        return -self.masses[body] * motion.omega**2 * motion.points[body]

    def _external(self, body: str, motion: Motion) -> ComplexArray:
        return motion.forces.get(body, np.zeros(motion.omega.shape, dtype=complex))

    def _hanging_on(self, place: str) -> set[str] | None:
        """Bodies connected with `place` when it is their only support; None where it is not."""
        group: set[str] = set()
        todo = [place]
        while todo:
            here = todo.pop()
            for there in self._neighbours.get(here, ()):
                if there in self.masses and there not in group:
                    group.add(there)
                    todo.append(there)
                elif there not in self.masses and there != place:
                    return None
        return group

    @cached_property
    def _neighbours(self) -> dict[str, list[str]]:
        """The other ends of the joints at each point."""
        found: dict[str, list[str]] = {}
        for joint in self.joints:
            for here, there in (joint.ends, joint.ends[::-1]):
                found.setdefault(here, []).append(there)
        return found

    def matrices(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """M, C, K and hysteretic stiffness over the bodies, each (n, n)."""
        return self._over(tuple(self.masses))

    def _over(self, names: Sequence[str]) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """M, C, K and hysteretic stiffness over some coordinates."""
        mass, damping, stiffness, hysteretic = (self._on_stretches(four, names) for four in self._fours)
        return np.diag([self.masses.get(name, 0.0) for name in names]) + mass, damping, stiffness, hysteretic

    def _on_stretches(self, values: Iterable[float], names: Sequence[str]) -> FloatArray:
        """What joints add, each a value times the square of its stretch, over coordinates."""
        number = {name: i for i, name in enumerate(names)}
        found = np.zeros((len(names), len(names)))
        for joint, value in zip(self.joints, values, strict=True):
            at = [number[end] for end in joint.ends if end in number]
            for i in at:
                found[i, i] += value
            if len(at) == 2:
                found[at[0], at[1]] -= value
                found[at[1], at[0]] -= value
        return found

    def rotating(self) -> FloatArray:
        """Of dampers that turn with a shaft, over the bodies, (n, n)."""
        return self._on_stretches((joint.rotating for joint in self.joints), tuple(self.masses))

    def poles(self) -> ComplexArray:
        """Complex frequencies of free motion [rad/s], time factor e^{i w t}: two per mass, one per damped joint."""
        mass, damping, stiffness, hysteretic = self.matrices()
        n = len(mass)
        if self.jointed.any():
            return pencil_poles(mass, damping, stiffness + 1j * hysteretic)
        inverse = inverted(mass)
        complex_stiffness = stiffness + 1j * hysteretic
        size = np.sqrt(np.abs(inverse @ complex_stiffness).max() + np.abs(inverse @ damping).max() ** 2)
        if size == 0.0:
            return np.zeros(2 * n, dtype=complex)
        if not damping.any():
            root = inverse_root(mass)
            squares = (
                np.linalg.eigvals(root @ complex_stiffness @ root.T)
                if hysteretic.any()
                else (np.linalg.eigvalsh(root @ stiffness @ root.T).astype(complex))
            )
            half = np.sqrt(squares)
            return np.concatenate([half, -half])
        if n >= WORTH and self._modes is not None:
            return self._modes.poles
        state = np.zeros((2 * n, 2 * n), dtype=complex)
        state[:n, n:] = np.eye(n)
        state[n:, :n] = -inverse @ complex_stiffness / size**2
        state[n:, n:] = -inverse @ damping / size
        rates: ComplexArray = np.linalg.eigvals(state) * size
        return -1j * rates

    def held_poles(self) -> ComplexArray:
        """As `poles`, ascending by size, without those at zero."""
        poles = self.poles()
        return poles[np.argsort(np.abs(poles))[self.loose :]]

    @cached_property
    def loose(self) -> int:
        """Number of poles at zero: motions on which no spring, and again those on which no damper does any work."""
        _, damping, stiffness, _ = self.matrices()
        return nullity(stiffness) + nullity(stiffness, damping)

    def natural_frequencies(self) -> FloatArray:
        """Undamped natural frequencies, ascending [rad/s], one of each body with mass, by singular values.

        K = B diag(k) B^T, so the frequencies are the singular values of M^-1/2 B diag(k)^1/2:
        no squares are taken and small ones keep their digits.
        """
        return singular(self._spring_columns())

    def grows(self, spin: float) -> bool:
        """Whether a whirl grows at a spin [rad/s] that is beyond the `threshold`."""
        return True

    def settled_to(self, top: float = 0.0) -> float:
        """Spin [rad/s] up to which it is known whether a whirl grows, by a search up to `top`; infinite of all."""
        return float("inf")

    def threshold(self, top: float = 0.0) -> float:
        """Least spin [rad/s] beyond which a whirl grows under dampers that turn with a shaft; infinite of none."""
        from vibopt.mechanics.two_planes import threshold_in_planes

        mass, damping, stiffness, _ = self.matrices()
        rotating = self.rotating()
        return threshold_in_planes(mass, damping + rotating, rotating, stiffness)

    @property
    def known_spins(self) -> tuple[float, float]:
        """Spins between which its bearings are known [rad/s]."""
        return 0.0, float("inf")

    @property
    def spinning(self) -> float:
        """Mass of shafts and of what sits on them [kg]."""
        return 0.0

    def stress_at(self, end: str, motion: Motion) -> ComplexArray:
        """Greatest of bending at one end of a span of a rotor [Pa]; there is none."""
        raise KeyError(end)

    def weight_stress_at(self, end: str) -> float:
        """As `stress_at`, under the weights alone."""
        raise KeyError(end)

    def critical_speeds(self, sense: float = 1.0) -> FloatArray:
        """Speeds at which a whirl with the spin, or against it (`sense` -1), is free, ascending [rad/s]."""
        return self.natural_frequencies()

    def mode_shapes(self) -> tuple[FloatArray, FloatArray]:
        """Undamped natural frequencies, ascending (n_bodies,) [rad/s], and their shapes (n_bodies, n_modes)."""
        left, values, _ = np.linalg.svd(self._spring_columns())
        values, shapes = settled(values), (self._root.T @ left)[:, ::-1]
        if not self.jointed.any():
            return values[::-1], shapes
        stiffness, light, whole = self.matrices()[2], self.jointed, np.zeros((len(self.jointed), shapes.shape[1]))
        whole[~light] = shapes
        whole[light] = np.linalg.solve(stiffness[light][:, light], -stiffness[light][:, ~light] @ shapes)
        return values[::-1], whole

    def row(self, body: str) -> FloatArray:
        """The row that reads the motion of a body, (n_bodies,)."""
        return np.array([float(name == body) for name in self.masses])

    def _spring_columns(self) -> FloatArray:
        """M^-1/2 B diag(k)^1/2, (n_modes, at least as many), less what joints that follow take of each spring."""
        columns, light = self.spring_rows(), self.jointed
        if light.any():
            across = np.linalg.qr(columns[light].T)[0]
            columns = columns[~light] - columns[~light] @ across @ across.T
        scaled: FloatArray = self._root @ columns
        return scaled

    def spring_rows(self) -> FloatArray:
        """B diag(k)^1/2 over the coordinates, (n, at least as many)."""
        names = list(self.masses)
        columns = np.zeros((len(names), max(len(self.joints), len(names))))
        for j, joint in enumerate(self.joints):
            for end, sign in zip(joint.ends, (-1.0, 1.0), strict=True):
                if end in self.masses:
                    columns[names.index(end), j] = sign * np.sqrt(joint.stiffness)
        return columns

    @property
    def _root(self) -> FloatArray:
        """M^-1/2 of what has mass, (n_modes, n_modes)."""
        heavy = ~self.jointed
        return inverse_root(self.matrices()[0][heavy][:, heavy])

    @cached_property
    def jointed(self) -> BoolArray:
        """Which places are joints that nothing with mass, and no inerter, resists; (n,)."""
        return np.asarray(~self.matrices()[0].any(axis=1))

    def sag(self) -> dict[str, float] | None:
        """Displacement of every point under the weights [m], down positive; None when nothing holds it."""
        stiffness = self._on_stretches((joint.static_stiffness for joint in self.joints), tuple(self.masses))
        if np.linalg.matrix_rank(stiffness, tol=1e-15 * np.abs(stiffness).max(initial=0.0)) < len(stiffness):
            return None
        down = np.linalg.solve(stiffness, np.array([self.weights[name] * GRAVITY for name in self.masses]))
        return dict(zip(self.masses, down.tolist(), strict=True))


def is_in_space(machine: Machine) -> TypeIs[SpaceMachine]:
    """Whether bodies of it move in space; asked without the file of such machines."""
    return machine.in_space
