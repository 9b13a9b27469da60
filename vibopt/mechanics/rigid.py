"""The machine as built where bodies move in space: Newton and Euler, by positions and cross products.

The second road.  Every coordinate is moved by one in turn; the mounts answer with forces at their places,
the forces and their moments about each centre of mass are added up, and what they do against each
coordinate gives the matrices.  Bodies turn about their principal axes, so masses stand alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.mechanics.built import GROUND, Course, Joint, Motion
from vibopt.mechanics.built_algebra import at_rest, inverse_root, steady_solution
from vibopt.mechanics.constants import GRAVITY
from vibopt.mechanics.machine import Machine
from vibopt.mechanics.rigid_parts import LETTERS, Guided, Rigid, Spring3
from vibopt.mechanics.vectors import cross
from vibopt.records import cached_property, dataclass

if TYPE_CHECKING:
    from numpy.typing import NDArray

Vector = tuple[float, float, float]
Points = Mapping[str, Any]
"""Motion of places along each axis, and turns: "pump.x", "pump.rx"; of one shape."""


@dataclass(frozen=True)
class SpaceMachine(Machine):
    """Bodies in space beside those on a line.

    `masses` holds what resists each coordinate: NAME of what moves on a line, numbered ones of each body in space, and
    NAME of each absorber in space.

    rigid
        Bodies in space.
    line
        Names of what moves on the one line, z.
    guided
        Absorbers in space.
    mounts
        Single mounts, inerters, and springs of absorbers.
    groups
        Names of the mounts of each group.
    fixed
        Places on bodies by name.
    spatial
        Bases that move in any direction.
    """

    rigid: Mapping[str, Rigid] = field(default_factory=dict)
    line: tuple[str, ...] = ()
    guided: Mapping[str, Guided] = field(default_factory=dict)
    mounts: tuple[Spring3, ...] = ()
    groups: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    fixed: Mapping[str, tuple[str, FloatArray]] = field(default_factory=dict)
    spatial: tuple[str, ...] = ()
    in_space: ClassVar[bool] = True

    @property
    def places(self) -> tuple[str, ...]:
        bodies = (*self.rigid, *self.guided, *self.fixed)
        return (*self.line, *(f"{name}.{turn}{axis}" for name in bodies for turn in ("", "r") for axis in LETTERS))

    @cached_property
    def columns(self) -> list[tuple[str, FloatArray, FloatArray]]:
        """Per coordinate what it moves: name, velocity of its centre, angular velocity."""
        found = [(name, np.array([0.0, 0.0, 1.0]), np.zeros(3)) for name in self.line]
        for name, body in self.rigid.items():
            found += [(name, velocity, spin) for velocity, spin, _ in body.moves]
        return found + [(name, slider.way, np.zeros(3)) for name, slider in self.guided.items()]

    @cached_property
    def _motions(self) -> tuple[NDArray[np.str_], FloatArray, FloatArray]:
        """`columns` as arrays: names (n,), velocities and spins (n, 3)."""
        names, velocities, spins = zip(*self.columns, strict=True)
        return np.array(names), np.array(velocities), np.array(spins)

    def _moved(self, place: str, at: FloatArray) -> FloatArray:
        """Displacement at a place [m] on a body under each unit motion, shape (n, 3)."""
        names, velocities, spins = self._motions
        if place in self.guided:
            slider = self.guided[place]
            apart = (names == place) - self._moved(slider.host, slider.at) @ slider.way
            return np.asarray(self._moved(slider.host, at) + apart[:, None] * slider.way)
        moves = names == place
        arm = at - self.rigid[place].centre if place in self.rigid else np.zeros(3)
        field_: FloatArray = moves[:, None] * (velocities + cross(spins, arm))
        return field_

    def _against(self, place: str, at: FloatArray, forces: FloatArray) -> FloatArray:
        """Work of forces (m, 3) at a place on a body against each unit motion: by sum and moment; (n, m)."""
        names, velocities, spins = self._motions
        if place in self.guided:  # along its direction they push the mass, across it the guide hands them on
            slider, along = self.guided[place], forces @ self.guided[place].way
            freed = self._against(slider.host, slider.at, along[:, None] * slider.way)
            pushed: FloatArray = self._against(slider.host, at, forces) - freed + (names == place)[:, None] * along
            return pushed
        arm = at - self.rigid[place].centre if place in self.rigid else np.zeros(3)
        done: FloatArray = (names == place)[:, None] * (velocities @ forces.T + spins @ cross(arm, forces).T)
        return done

    def _assembled(self, which: str) -> FloatArray:
        """Forces against each coordinate under unit motions of all, shape (n, n)."""
        n = len(self.columns)
        whole = np.zeros((n, n))
        for mount in self.mounts:
            strength = getattr(mount, which)
            first, second = (self._moved(end, mount.at) for end in mount.ends)
            pulls = (strength * ((second - first) @ mount.axes.T)) @ mount.axes
            whole -= self._against(mount.ends[0], mount.at, pulls)
            whole += self._against(mount.ends[1], mount.at, pulls)
        for joint in self.joints:
            strength = {"hysteretic": joint.stiffness * joint.loss_factor}.get(which, getattr(joint, which, 0.0))
            at = [self.line.index(end) for end in joint.ends if end in self.line]
            for i in at:
                whole[i, i] += strength
            if len(at) == 2:
                whole[at[0], at[1]] -= strength
                whole[at[1], at[0]] -= strength
        return whole

    def matrices(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        return self._four

    @cached_property
    def _four(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        mass = np.diag(list(self.masses.values())) + self._assembled("inertance")
        for slider in self.guided.values():
            along = self._moved(slider.host, slider.at)
            across = along - np.outer(along @ slider.way, slider.way)
            mass += slider.mass * self._against(slider.host, slider.at, across)
        return mass, self._assembled("damping"), self._assembled("stiffness"), self._assembled("hysteretic")

    def shake(self, omega: FloatArray, forces: dict[str, ComplexArray], bases: dict[str, ComplexArray]) -> Motion:
        """As `Machine.shake`; forces by place and direction ("pump.x", "pump.rx"), real arithmetic."""
        flat = np.ravel(omega)
        n = len(self.columns)
        load = np.zeros((flat.size, n), dtype=complex)
        for key, force in forces.items():
            load += np.ravel(force)[:, None] * self._work(key)
        supports = {key: np.ravel(one) for key, one in bases.items()}
        for mount in self.mounts:
            for end, other in ((mount.ends[0], mount.ends[1]), (mount.ends[1], mount.ends[0])):
                moved = self._base(end, supports)
                if moved is not None:
                    stretch = moved @ mount.axes.T
                    pull = (mount.dynamic(flat) * stretch) @ mount.axes
                    basis = self._against(other, mount.at, np.eye(3)).T
                    load += pull @ basis
        for joint in self.joints:
            for here, there in (joint.ends, joint.ends[::-1]):
                moved = self._base(there, supports)
                if here in self.line and moved is not None:
                    load[:, self.line.index(here)] += joint.dynamic(flat) * moved[:, 2]
        state = self._state(flat, load).reshape(*omega.shape, n)
        points = {name: state[..., i] for i, name in enumerate(self.line)}
        for name in (*self.rigid, *self.guided, *self.fixed):
            for k in range(3):
                points[f"{name}.{LETTERS[k]}"] = state @ self._row(name)[:, k]
                points[f"{name}.r{LETTERS[k]}"] = state @ self._turn(name)[:, k]
        zero = np.zeros(omega.shape, dtype=complex)
        for base in self.bases:
            points[base] = bases.get(base, zero) + bases.get(f"{base}.z", zero)
            for axis in LETTERS:
                points[f"{base}.{axis}"] = bases.get(f"{base}.{axis}", zero)
        return Motion(points, forces, omega)

    def _state(self, omega: FloatArray, load: ComplexArray) -> ComplexArray:
        """Coordinates under loads, each (n_speeds, n); in real arithmetic at real frequencies."""
        mass, damping, stiffness, hysteretic = self._four
        elastic = stiffness - omega[:, None, None] ** 2 * mass
        dash = omega[:, None, None] * damping + hysteretic
        return steady_solution(elastic, dash, load)

    def _base(self, place: str, supports: Mapping[str, ComplexArray]) -> ComplexArray | None:
        """Motion of a base (n, 3); None where it does not move."""
        keys = [key for key in supports if key == place or (key[:-2] == place and key[-2:] in (".x", ".y", ".z"))]
        if place not in self.bases or not keys:
            return None
        moved = np.zeros((len(supports[keys[0]]), 3), dtype=complex)
        for key in keys:
            moved[:, 2 if key == place else LETTERS.index(key[-1])] += supports[key]
        return moved

    def _body(self, place: str) -> tuple[str, FloatArray]:
        if place in self.fixed:
            return self.fixed[place]
        return place, self.guided[place].at if place in self.guided else self.rigid[place].mark

    def _row(self, place: str) -> FloatArray:
        """Displacement of a body's mark, or of a fixed place, under each unit motion, (n, 3)."""
        return self._moved(*self._body(place))

    def _turn(self, place: str) -> FloatArray:
        """Rotation of the body of a place under each unit motion, (n, 3)."""
        body = self._body(place)[0]
        while body in self.guided:
            body = self.guided[body].host
        return np.array([spin if name == body else np.zeros(3) for name, _, spin in self.columns])

    def _work(self, key: str) -> FloatArray:
        """Work of a unit force or moment "place.x", "place.rx" against each coordinate, (n,)."""
        if key in self.line:
            return np.array([1.0 if name == key else 0.0 for name, _, _ in self.columns])
        place, _, axis = key.rpartition(".")
        if axis.startswith("r"):
            return self._turn(place)[:, LETTERS.index(axis[1])]
        body, at = self._body(place)
        return self._against(body, at, np.eye(3)[[LETTERS.index(axis)]])[:, 0]

    def moved(self, place: str, way: Vector, points: Points, *, turn: bool = False) -> Any:
        """Motion of a place along a direction [m], or rotation about it [rad], of the shape of `points`."""
        kind = ".r" if turn else "."
        parts = [part * points[f"{place}{kind}{axis}"] for part, axis in zip(way, LETTERS, strict=True) if part]
        return np.sum(parts, axis=0)

    def _end(self, place: str, at: FloatArray, points: Points) -> Any:
        """Displacement at a place on a body, base or line (..., 3), from translation and rotation."""
        if place in self.rigid or place in self.guided:
            slide = np.stack([points[f"{place}.{axis}"] for axis in LETTERS], axis=-1)
            turn = np.stack([points[f"{place}.r{axis}"] for axis in LETTERS], axis=-1)
            return slide + cross(turn, at - self._body(place)[1])
        if place in self.spatial:
            return np.stack([points[f"{place}.{axis}"] for axis in LETTERS], axis=-1)
        some = next(iter(points.values()))
        along = points[place] if place != GROUND and place in points else np.zeros_like(some)
        return np.stack([np.zeros_like(some), np.zeros_like(some), along], axis=-1)

    def mount(self, name: str) -> Spring3:
        """The single mount of a name."""
        return next(one for one in self.mounts if one.name == name)

    def stretch(self, mount: Spring3, points: Points) -> Any:
        """Second end less first along the own axes (..., 3) [m]; in time with its first two rates in front."""
        return (self._end(mount.ends[1], mount.at, points) - self._end(mount.ends[0], mount.at, points)) @ mount.axes.T

    def mount_force(self, mount: Spring3, motion: Motion | Course) -> Any:
        """Force of a mount on its second end in space (..., 3) [N], at each speed or time."""
        apart = self.stretch(mount, motion.points)
        if isinstance(motion, Motion):
            return -(mount.dynamic(motion.omega) * apart) @ mount.axes
        return -(mount.stiffness * apart[0] + mount.damping * apart[1] + mount.inertance * apart[2]) @ mount.axes

    def joint(self, name: str) -> Joint:
        """A link; of a mount one own axis as a link, "front.1.z"; of a group its number."""
        if name in self.guided:
            return self.guided[name].joint
        if name in self.groups:
            many = float(len(self.groups[name]))
            return Joint(name, self.mount(self.groups[name][0]).ends, 0.0, 0.0, 0.0, 0.0, many)
        single, _, axis = name.rpartition(".")
        if axis in LETTERS and any(mount.name == single for mount in self.mounts):
            own, k = self.mount(single), LETTERS.index(axis)
            numbers = own.stiffness[k], own.damping[k], own.loss_factor, own.static_stiffness[k]
            stiff, dash, lossy, still = (float(number) for number in numbers)
            return Joint(name, own.ends, stiff, dash, lossy, still, 1.0)
        if any(mount.name == name and len(mount.axes) == 1 for mount in self.mounts):
            own = self.mount(name)
            numbers = own.stiffness, own.damping, own.loss_factor, own.static_stiffness
            stiff, dash, lossy, still = (float(np.ravel(number)[0]) for number in numbers)
            return Joint(name, own.ends, stiff, dash, lossy, still, 1.0, inertance=float(np.ravel(own.inertance)[0]))
        return super().joint(name)

    def stretch_of(self, joint: Joint, motion: Motion) -> ComplexArray:
        """Second end of a joint less its first [m]; of one that stands in space along its own axis."""
        if any(mount.name == joint.name for mount in self.mounts):
            return np.asarray(self.stretch(self.mount(joint.name), motion.points)[..., 0])
        return super().stretch_of(joint, motion)

    def stretch_course(self, joint: Joint, course: Course) -> FloatArray:
        if any(mount.name == joint.name for mount in self.mounts):
            return np.asarray(self.stretch(self.mount(joint.name), course.points)[..., 0])
        return super().stretch_course(joint, course)

    def _hanging_on(self, place: str) -> set[str] | None:
        """As of a machine on a line; None too where a mount holds or pushes any of it."""
        group = super()._hanging_on(place)
        return None if group is None or any(group & set(mount.ends) for mount in self.mounts) else group

    def force_along(self, place: str, way: Vector, motion: Any) -> Any:
        """Dynamic force of all mounts and links into a place, along a direction [N], at each speed of a `Motion` or
        time of a `Course`.

        Of the only support: all forces from outside less all that goes into momentum.  Else mount by mount.
        """
        along, total = np.array(way), np.zeros(1)
        if self._only(place, along):
            faster = _accelerations(motion)
            for name, body in self.rigid.items():
                total = total - body.mass * (self._end(name, body.centre, faster) @ along)
            for name, slider in self.guided.items():
                total = total - slider.mass * (self._end(name, slider.at, faster) @ along)
            for name in self.line:
                total = total - along[2] * self.masses[name] * faster[name]
            for key, force in motion.forces.items():
                axis = key.rpartition(".")[2]
                part = along[2] if key in self.line else along[LETTERS.index(axis)] if axis in LETTERS else 0.0
                total = total + part * force
            return total
        for mount in self.mounts:
            if place in mount.ends:
                sign = 1.0 if mount.ends[1] == place else -1.0
                total = total + sign * self.mount_force(mount, motion) @ along
        for joint in self.joints:
            if place in joint.ends:
                sign = along[2] if joint.ends[1] == place else -along[2]
                steady = isinstance(motion, Motion)
                pull: Any = self.joint_force(joint, motion) if steady else self.joint_course(joint, motion)
                total = total + sign * pull
        return total

    def _only(self, place: str, along: FloatArray) -> bool:
        """Whether every path to a support ends at this place, and nothing is guided across the direction."""
        standing = {end for mount in self.mounts for end in mount.ends} | {
            end for joint in self.joints for end in joint.ends
        }
        supports = standing - set(self.rigid) - set(self.line) - set(self.guided)
        free = all(along[k] == 0.0 or LETTERS[k] in body.freedoms for body in self.rigid.values() for k in range(3))
        return supports == {place} and free and (not self.line or not along[:2].any())

    def spring_rows(self) -> FloatArray:
        """Stretches of the springs under unit motions, times the roots of their stiffnesses."""
        stretches = []
        for mount in self.mounts:
            apart = self._moved(mount.ends[1], mount.at) - self._moved(mount.ends[0], mount.at)
            stretches += list(np.sqrt(mount.stiffness)[:, None] * (mount.axes @ apart.T))
        for joint in self.joints:
            row = np.zeros(len(self.columns))
            for end, sign in zip(joint.ends, (-1.0, 1.0), strict=True):
                if end in self.line:
                    row[self.line.index(end)] = sign * np.sqrt(joint.stiffness)
            stretches.append(row)
        n = len(self.columns)
        return np.array([*stretches, *[np.zeros(n)] * max(n - len(stretches), 0)]).T

    @property
    def coordinate_names(self) -> tuple[str, ...]:
        return (*self.masses, *(f"{base}.{axis}" for base in self.bases for axis in LETTERS))

    def pushes(self, acts: Mapping[str, complex]) -> FloatArray:
        found = np.zeros(len(self.coordinate_names))
        for key, part in acts.items():
            base = key if key in self.bases else key[:-2]
            if base in self.bases:
                found[self.coordinate_names.index(key if key != base else f"{base}.z")] += part.real
            else:
                found[: len(self.columns)] += part.real * self._work(key)
        return found

    def begins(self, acts: Mapping[str, complex]) -> FloatArray:
        """The body slides without turning."""
        found, (names, velocities, _) = np.zeros(len(self.coordinate_names)), self._motions
        for key, part in acts.items():
            if key in self.line:
                found[self.line.index(key)] += part.real
            else:
                found[: len(names)] += part.real * (names == key[:-2]) * velocities[:, LETTERS.index(key[-1])]
        return found

    def parts_in_time(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        n, whole = len(self.columns), np.zeros((3, *2 * (len(self.coordinate_names),)))
        whole[:, :n, :n] = self._four[:3]
        for k, key in enumerate(self.coordinate_names[n:]):  # a base moves by one, and mounts and links pull
            base, axis = key[:-2], LETTERS.index(key[-1])
            for mount in self.mounts:
                for other in (mount.ends[1 - i] for i, end in enumerate(mount.ends) if end == base):
                    for kind, strength in enumerate((mount.inertance, mount.damping, mount.stiffness)):
                        pull = (strength * mount.axes[:, axis]) @ mount.axes
                        whole[kind, :n, n + k] -= self._against(other, mount.at, pull[None])[:, 0]
            for joint in self.joints if axis == 2 else ():
                for other in (joint.ends[1 - i] for i, end in enumerate(joint.ends) if end == base):
                    if other in self.line:
                        strengths = joint.inertance, joint.damping, joint.stiffness
                        whole[:, self.line.index(other), n + k] -= strengths
        return whole[0], whole[1], whole[2]

    def points_in_time(self, moved: FloatArray) -> dict[str, FloatArray]:
        n = len(self.columns)
        own, bases = np.moveaxis(moved, 1, -1)[..., :n], moved[:, n:]
        found = {name: own[..., i] for i, name in enumerate(self.line)}
        for name in (*self.rigid, *self.guided, *self.fixed):
            for k, axis in enumerate(LETTERS):
                found[f"{name}.{axis}"], found[f"{name}.r{axis}"] = (
                    own @ self._row(name)[:, k],
                    own @ self._turn(name)[:, k],
                )
        for i, base in enumerate(self.bases):
            found |= {f"{base}.{axis}": bases[:, 3 * i + k] for k, axis in enumerate(LETTERS)}
            found[base] = found[f"{base}.z"]
        return found

    def sag(self) -> dict[str, float] | None:
        """Displacement of every place under the weights, along each axis; z of them downward, by equilibrium."""
        state = self._down
        if state is None:
            return None
        found = {name: float(state[i]) for i, name in enumerate(self.line)}
        for name in (*self.rigid, *self.guided, *self.fixed):
            for k in range(3):
                found[f"{name}.{LETTERS[k]}"] = float(state @ self._row(name)[:, k])
                found[f"{name}.r{LETTERS[k]}"] = float(state @ self._turn(name)[:, k])
        return found

    @cached_property
    def _down(self) -> FloatArray | None:
        """Coordinates under weights that act along +z, (n,); the true ones are their negative."""
        stiff = self._assembled("static_stiffness")
        load = np.zeros(len(self.columns))
        for name in self.line:
            load[self.line.index(name)] += self.weights.get(name, 0.0) * GRAVITY
        for name, body in self.rigid.items():
            load += self._against(name, body.centre, np.array([[0.0, 0.0, body.mass * GRAVITY]]))[:, 0]
        for name, slider in self.guided.items():
            load += self._against(name, slider.at, np.array([[0.0, 0.0, slider.mass * GRAVITY]]))[:, 0]
        return at_rest(stiff, load)

    def static_force(self, name: str) -> FloatArray | None:
        """Force of a single mount on its first end under the weights, in space (3,) [N]."""
        down, mount = self._down, self.mount(name)
        if down is None:
            return None
        apart = down @ (self._moved(mount.ends[0], mount.at) - self._moved(mount.ends[1], mount.at))
        force: FloatArray = (mount.static_stiffness * (mount.axes @ apart)) @ mount.axes
        return force

    def energy_share(self, body: str, way: tuple[float, float, float], *, turn: bool) -> float:
        """Greatest part of the kinetic energy that a mode has in one motion of a body, velocity times momentum."""
        mass, _, stiffness, _ = self._four
        root = inverse_root(mass)
        squares, vectors = np.linalg.eigh(root @ stiffness @ root.T)
        shapes = root.T @ vectors
        along, own = np.array(way), self.rigid[body]
        spin, slide = shapes.T @ self._turn(body), shapes.T @ self._moved(body, own.centre)
        velocity = (spin if turn else shapes.T @ self._row(body)) @ along
        momentum = own.mass * slide @ along
        if turn:
            momentum = (spin @ own.tensor + cross(own.centre - own.mark, own.mass * slide)) @ along
        omega = np.sqrt(np.maximum(squares, 0.0))
        best, start = 0.0, 0
        for stop in range(1, len(omega) + 1):
            if stop < len(omega) and omega[stop] - omega[stop - 1] <= 1e-6 * omega[stop]:
                continue
            share = np.outer(velocity[start:stop], momentum[start:stop])
            best = max(best, float(np.linalg.eigvalsh(0.5 * (share + share.T)).max()))
            start = stop
        return best


def _accelerations(motion: Motion | Course) -> Points:
    """Accelerations of all places [m/s^2], at each speed or time."""
    if isinstance(motion, Motion):
        return {name: -(motion.omega**2) * one for name, one in motion.points.items()}
    return {name: one[2] for name, one in motion.points.items()}
