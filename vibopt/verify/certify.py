"""The finished design measured on the machine as built, by another road than the optimiser took.

The machine is assembled link by link in real arithmetic, forces are read off the balance of
inertia, and the worst speed is searched afresh over the whole band.  No form is asked.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, cast

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.excitations import Excitation
from vibopt.mechanics.combine import combined, foremost
from vibopt.mechanics.machine import Machine
from vibopt.mechanics.modal import WORTH
from vibopt.records import cached_property, dataclass
from vibopt.responses import HarmonicResponse, RandomResponse, Response, TransientResponse
from vibopt.scene.drives import UNIT, bands_for, combine_for, durations_of, names_for, shaker_for, unit_lines
from vibopt.scene.scene import Scene
from vibopt.scene.space import members
from vibopt.signals import Band, Combine, Line
from vibopt.verify.as_built import machine_of
from vibopt.verify.over_bands import Reached, Search
from vibopt.work import worked

if TYPE_CHECKING:
    from vibopt.verify.near_rest import Orders

_CALL, _SPEED = 0.2, 0.05
"""Work of steady responses, and of each of their speeds [nominal ms]."""
_OTHERS = (0.118, 0.382, 0.764)
"""Parts of a band at which a machine is also measured in full, whatever the worst speed."""
_AS_REST = 1e-6
"""Part of the reach of the orders at which a ratio of two motions is as at rest."""
_ASIDE = (1e-8, 1e-6)
"""Parts of a speed to both sides of it: at a pole of a response the nearer are a hundred times as great."""
_TRIED, _NEAR = 48, 0.8
"""Speeds of a range at which places are compared, and the part of the greatest from which on one may be that."""


@dataclass(frozen=True, slots=True)
class Measured:
    """Value of a response on the built machine [SI], and the speed [rad/s] of the worst per excitation.

    `response` is the single question: of a group of mounts the worst of them.  `least` says which end over the speeds
    it is.
    """

    value: float
    speeds: Mapping[str, float]
    response: Response
    least: bool = False


def measure(scene: Scene, chosen: Mapping[str, float], response: Response, side: str = "at_most") -> Measured:
    """The worst of a response; `side` "at_least" looks for its least value.

    For a natural frequency outside a band it is the mode nearest to the band's middle.
    """
    machine = machine_of(scene, chosen)
    return measure_on(scene, machine, response, side)


def measure_on(scene: Scene, machine: Machine, response: Response, side: str) -> Measured:
    """As `measure`, on a machine already built; of a group of mounts the worst of them."""
    asked = members(scene, response)
    whirls = isinstance(response, HarmonicResponse) and not response.sags  # what sags differs from place to place
    if whirls and response.of_rotor and len(asked) > 1 and side != "at_least":
        asked = _foremost(scene, machine, cast("tuple[HarmonicResponse, ...]", asked))
    found = _each(scene, machine, asked, side)
    return (
        found[foremost([measured.value for measured in found], least=side == "at_least")]
        if len(found) > 1
        else found[0]
    )


def _foremost(scene: Scene, machine: Machine, asked: tuple[HarmonicResponse, ...]) -> tuple[HarmonicResponse, ...]:
    """Of many places on one machine those that come near the greatest: of all speeds, or at one of its resonances.

    How high a resonance is nobody knows before it is searched, but which places it moves most.
    """
    kept = np.zeros(len(asked), dtype=bool)
    for name in names_for(scene, asked[0]):
        bands = bands_for(scene, asked[0], name)
        tried = [np.linspace(band.low, band.high, 1 if band.is_point else _TRIED) for band in bands]
        near = [at for at in machine.known_poles.real.tolist() if any(band.holds(at) for band in bands)]
        speeds, count = np.concatenate([*tried, near]), len(near)
        each = [_shaken(scene, machine, one, name)(speeds) for one in asked]
        sizes = np.array(each)
        kept |= sizes.max(axis=1) >= _NEAR * sizes.max()
        at_poles = sizes[:, len(speeds) - count :]
        kept |= (at_poles >= _NEAR * at_poles.max(axis=0, initial=0.0)).any(axis=1)
    return tuple(one for one, may in zip(asked, kept.tolist(), strict=True) if may)


def _each(scene: Scene, machine: Machine, asked: Sequence[Response], side: str) -> list[Measured]:
    """Of several places, or of one; under a pulse that may have any duration all on the same simulations."""
    one = asked[0]
    if (
        not isinstance(one, TransientResponse)
        or one.combine is not None
        or (between := durations_of(scene, one)) is None
    ):
        return [_measured(scene, machine, response, side) for response in asked]
    from vibopt.verify.unknown_duration import peaks_over_durations

    names = names_for(scene, one)
    once = [pulse for name in names if (pulse := scene.excitations[name].once) is not None]
    every = [other for other in scene.responses.values() if isinstance(other, TransientResponse)]
    alike = [other for other in every if other.combine is None and names_for(scene, other) == names]
    others = [other for other in alike if members(scene, other)[0] is other]
    greatest = peaks_over_durations(machine, once, cast("Sequence[TransientResponse]", asked), between, others)
    return [Measured(value, {}, response) for value, response in zip(greatest, asked, strict=True)]


def _measured(scene: Scene, machine: Machine, response: Response, side: str) -> Measured:
    if isinstance(response, HarmonicResponse):
        return _harmonic(scene, machine, response, side)
    if isinstance(response, RandomResponse):
        from vibopt.verify.rms import rms_of

        return Measured(rms_of(scene, machine, response), {}, response)
    if isinstance(response, TransientResponse) and response.combine is not None:
        return _added(scene, machine, response)
    if isinstance(response, TransientResponse):
        from vibopt.verify.simulated import peak_in_time

        if machine.rubs:
            from vibopt.verify.stopping import Stopping

            return Measured(*peak_in_time(scene, machine, response, Stopping), response)
        value, times = peak_in_time(scene, machine, response)
        return Measured(value, times, response)
    if response.reading is not None:
        return _sharpest(scene, machine, response, response.reading)
    if response.outside_bands:
        return Measured(nearest(response.frequencies_of(machine), response.outside_bands), {}, response)
    return Measured(response.measure_static(machine), {}, response)


def _sharpest(scene: Scene, machine: Machine, response: Response, reading: HarmonicResponse) -> Measured:
    """The greatest of the amplification factors of all excitations, each driving by itself."""
    from vibopt.verify.sharpness import sharpest

    found = {}
    for name in names_for(scene, reading):
        shaken = _shaken(scene, machine, reading, name)
        found[name] = sharpest(shaken, bands_for(scene, reading, name), machine.known_poles, machine.known_spins)
    name = max(found, key=lambda one: found[one][0])
    factor, speed = found[name]
    return Measured(factor, {name: speed} if factor else {}, response)


def _added(scene: Scene, machine: Machine, response: TransientResponse) -> Measured:
    """Excitations one by one, each of their greatest at a time or speed of its own."""
    alone = [response.alone(name, scene.excitations[name].sorts) for name in names_for(scene, response)]
    found = [_each(scene, machine, [one], "at_most")[0] for one in alone]
    values = [measured.value for measured in found]
    total = float(np.sqrt(np.sum(np.square(values)))) if response.combine == "rss" else float(sum(values))
    return Measured(total, {name: at for measured in found for name, at in measured.speeds.items()}, response)


def nearest(modes: FloatArray, outside: tuple[Band, ...]) -> float:
    """The natural frequency deepest inside any band, or else the nearest to one [rad/s]; infinite of none."""
    depth = [(min(w - band.low, band.high - w), w) for band in outside for w in modes]
    return float(max(depth)[1]) if depth else float("inf")


def _harmonic(scene: Scene, machine: Machine, response: HarmonicResponse, side: str) -> Measured:
    want_least = (side == "at_least") != response.complement
    found: dict[str, Reached] = {}
    for name in names_for(scene, response):
        found[name] = _one_drive(scene, machine, response, name, want_least)
    values = [one.value for one in found.values()]
    total = float(np.sqrt((np.array(values) ** 2).sum())) if response.combine == "rss" else sum(values)
    value = 1.0 - total if response.complement else total + response.beside(machine)
    return Measured(value, {name: one.speed for name, one in found.items()}, response, want_least)


def _one_drive(scene: Scene, machine: Machine, response: HarmonicResponse, name: str, want_least: bool) -> Reached:
    bands = bands_for(scene, response, name)
    if machine.rubs:
        from vibopt.verify.rubbing_speeds import rubbing

        return rubbing(machine, response, scene.excitations[name], bands, least=want_least)
    shaken = _shaken(scene, machine, response, name)
    between = any(not band.is_point for band in bands)
    top = max(band.high for band in bands)
    singular, breaks = shaken.singularities(top) if between else (np.zeros(0, dtype=complex), np.zeros(0))
    turning = shaken.turning if between and not (want_least and len(machine.masses) > 1) else None
    found = Search(shaken, singular, breaks, want_least).over(bands, turning)
    whole = machine.in_full is machine and (not between or len(machine.masses) < WORTH)  # nothing through modes
    if whole or not np.isfinite(found.value):
        return found
    return _in_full(shaken, found, bands, want_least)


def _shaken(scene: Scene, machine: Machine, response: HarmonicResponse, name: str) -> Shaken:
    """A response to one excitation, at the place that is asked about where it may be at several."""
    shaker, lines = shaker_for(scene, response, name), unit_lines(scene, name)
    return Shaken(machine, response, shaker, lines, combine_for(scene, response))


def _in_full(shaken: Shaken, found: Reached, bands: tuple[Band, ...], want_least: bool) -> Reached:
    """The extreme measured on the machine in full, there and at a few other speeds where that is another machine."""
    machine = shaken.machine.in_full
    full = replace(shaken, machine=machine)
    speeds = [found.speed]
    if machine is not shaken.machine:
        speeds += [band.low + part * (band.high - band.low) for band in bands for part in _OTHERS if not band.is_point]
    values = full(np.array(speeds))
    worst = foremost(values, least=want_least)
    return Reached(float(values[worst]), speeds[worst])


@dataclass(frozen=True)
class Shaken:
    """Response of a built machine to one excitation against its speed; callable."""

    machine: Machine
    response: HarmonicResponse
    excitation: Excitation
    lines: tuple[Line, ...]
    combine: Combine

    def __call__(self, speed: FloatArray) -> FloatArray:
        """Combined peak amplitude, shape of `speed` [rad/s]; a ratio for normalised responses."""
        with np.errstate(all="ignore"):
            value = np.array(self._at(speed))
            if (ends := ~np.isfinite(value)).any():
                value[ends] = self._at_pole(speed[ends])
        return value

    def _at(self, speed: FloatArray) -> FloatArray:
        if not self.response.rigid_link:
            return self._size(self.machine, speed)
        moving = np.maximum(speed, _AS_REST * self._within)
        return self._size(self.bolted, moving) / self._size(self.machine, moving)

    def _at_pole(self, speed: FloatArray) -> FloatArray:
        """Where the machine has no answer: infinite, but of what stays the same on both sides of the pole."""
        near, far = (0.5 * (self._at(speed * (1.0 + off)) + self._at(speed * (1.0 - off))) for off in _ASIDE)
        return np.where(near <= 2.0 * far, near, np.inf)

    def _size(self, machine: Machine, speed: FloatArray) -> FloatArray:
        found = [self._line(machine, line, speed) for line in self.lines]
        return combined(found, tuple(line.order for line in self.lines), self.combine)

    def _line(self, machine: Machine, line: Line, speed: FloatArray) -> ComplexArray:
        """One harmonic of the response; near standstill by orders, where motion without end meets what fades."""
        amplitude = UNIT if self.response.normalised else line.amplitude
        orders = self._orders(machine, line) if machine.loose or amplitude.grows_to_rest else None
        if orders is None or not (near := line.order * speed < orders.reach).any():
            return self._steady(machine, line, line.order * speed, amplitude.at(speed))
        moving = np.where(near, orders.reach / line.order, speed)
        value = self._steady(machine, line, line.order * moving, amplitude.at(moving))
        value[near] = orders.times(amplitude, line.order, speed[near])
        return value

    def _steady(self, machine: Machine, line: Line, omega: FloatArray, size: FloatArray) -> ComplexArray:
        every = self._acts if machine is self.machine else self._acts_on(machine)
        part = int(np.abs(line.vector).argmax()) if len(every) > 1 else 0
        worked(_CALL + _SPEED * np.size(omega))
        drive = line.vector[part] * size.astype(complex)
        shaken = {key: weight * drive for key, weight in every[part].items()}
        forces, bases = (shaken, {}) if self.excitation.family == "bodies" else ({}, shaken)
        return machine.size(self.response.measure(self.machine, machine.shake(omega, forces, bases)))

    def _orders(self, machine: Machine, line: Line) -> Orders:
        key = machine is self.machine, line.order, tuple(line.vector.tolist())
        if key not in self._known:
            from vibopt.verify.near_rest import orders_of

            def steady(omega: ComplexArray) -> ComplexArray:
                return self._steady(machine, line, cast("FloatArray", omega), np.ones(omega.shape))

            self._known[key] = orders_of(steady, machine)
        return self._known[key]

    def under_unit(self, omega: FloatArray) -> FloatArray:
        """Modulus of the first harmonic under a unit amplitude at frequencies [rad/s] of any shape."""
        return np.abs(self._steady(self.machine, self.lines[0], omega, np.ones(omega.shape)))

    def singularities(self, top: float) -> tuple[ComplexArray, FloatArray]:
        """Complex speeds at which it is singular, well known up to a speed, and at which it is not smooth [rad/s]."""
        poles = self.machine.poles_below(top * max(line.order for line in self.lines))
        if self.response.rigid_link:
            poles = np.concatenate([poles, self.bolted.known_poles])
        breaks = sorted({speed for line in self.lines for speed in line.amplitude.breaks()})
        return np.concatenate([poles / line.order for line in self.lines]), np.array(breaks)

    @property
    def turning(self) -> FloatArray | None:
        """Speeds of all extremes [rad/s], where one harmonic of one power of the speed tells them from the machine."""
        line, *others = self.lines
        amplitude = UNIT if self.response.normalised else line.amplitude
        piece = amplitude.pieces[0]
        plain = not others and len(amplitude.pieces) == 1 and not piece.slope and not amplitude.grows_to_rest
        if not plain or self.machine.loose or self.response.rigid_link or not self.response.doubles:
            return None
        found = self.machine.turning(self.under_unit, piece.power)
        return None if found is None else found / line.order

    @cached_property
    def _known(self) -> dict[tuple[bool, float, tuple[complex, ...]], Orders]:
        return {}

    @cached_property
    def bolted(self) -> Machine:
        return joined(self.machine, self.response.rigid_link)

    @cached_property
    def _within(self) -> float:
        """A speed below which the orders of all lines hold [rad/s]; zero where none are needed."""
        machines = (self.machine, self.bolted)
        lines = self.lines
        loose = [machine for machine in machines if machine.loose]
        return min((self._orders(machine, line).reach / line.order for machine in loose for line in lines), default=0.0)

    @cached_property
    def _acts(self) -> list[dict[str, complex]]:
        return self._acts_on(self.machine)

    def _acts_on(self, machine: Machine) -> list[dict[str, complex]]:
        """Where each loose part of the excitation acts; on the receiver, where its body has been joined with it."""
        on, acts = self.excitation.on, [excitation.acts for excitation in self.excitation.loose]
        if list(acts[0]) != [on] or on in machine.places or on in machine.bases:
            return acts
        return [{next(joint.ends[1] for joint in self.machine.joints if joint.name == self.response.rigid_link): 1.0}]


def joined(machine: Machine, link: str) -> Machine:
    """The machine with a link made rigid: its two bodies are one, called by the second end's name."""
    first, second = next(one.ends for one in machine.joints if one.name == link)
    masses = {name: mass for name, mass in machine.masses.items() if name != first}
    masses[second] += machine.masses[first]
    joints = []
    for joint in machine.joints:
        a, b = (second if end == first else end for end in joint.ends)
        if a != b:
            joints.append(replace(joint, ends=(a, b)))
    weights = {name: weight for name, weight in machine.weights.items() if name != first}
    weights[second] += machine.weights[first]
    return replace(machine, masses=masses, joints=tuple(joints), weights=weights)
