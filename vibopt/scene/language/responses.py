"""Responses as methods of a machine: one method a response, named as in the file.

Values are the worst over all the speeds that are looked at; amplitudes are peak.  A word that a response
does not have is refused by the reader of scenes, with a suggestion.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Literal, TypedDict, Unpack

from vibopt.errors import way_out
from vibopt.responses import GOALS
from vibopt.scene.language.limit import Measure, Speeds, Way


class Shown(TypedDict, total=False):
    """`unit`: how the value is shown, as "mm rms"; `worst`: "least" or "greatest", which value a measure shows.

    Of a limit `soft`, how easily it may be loosened, and `with_probability`, the share of machines that shall keep it.
    """

    unit: str
    worst: str
    soft: float
    with_probability: str


class Looked(Shown, total=False):
    """Speeds and excitations to look at.

    at, over
        Single speeds, or ranges ("start-up": from rest to the highest own speed); neither: every own
        speed of the excitation.
    due_to
        Excitations that count; without it all.
    combine
        "sum", "rss" or "peak"; compulsory when there is more than one harmonic or excitation.
    """

    at: Speeds
    over: Speeds
    due_to: Sequence[str]
    combine: str


class Along(Looked, total=False):
    """In space: the `direction` of a motion or a force."""

    direction: Way


class About(Looked, total=False):
    """In space: the `axis` of a rotation."""

    axis: Way


class Still(Shown, total=False):
    """In space: the `direction` of a static load or deflection."""

    direction: Way


class Whirling(Shown, total=False):
    """Free whirls of a rotor: spins `at` or `over` which, `up_to` which frequency, `whirl` "forward" or "backward"."""

    at: Speeds
    over: Speeds
    up_to: str
    whirl: str


class Random(Shown, total=False):
    """White noises that count; without `due_to` all."""

    due_to: Sequence[str]


class RandomAlong(Random, total=False):
    """In space: the `direction` of a motion or a force."""

    direction: Way


class InTime(Random, total=False):
    """`combine`: "sum" or "rss" of the peaks of each excitation; without it, of all together."""

    combine: str


class InTimeAlong(InTime, total=False):
    """In space: the `direction` of a motion or a force."""

    direction: Way


class Responses:
    """What can be limited, measured or made best; kinds without a method of their own go by their words in a file."""

    if not TYPE_CHECKING:

        def __getattr__(self, kind: str) -> Callable[..., Measure]:
            if kind not in GOALS:
                raise AttributeError(f"there is no {kind}.{way_out(kind, list(GOALS))}")
            return partial(Measure, kind)

    def margin(self, *, limits: Sequence[str] | None = None) -> Measure:
        """Part of its bound that every limit, or each of some `limits`, has left over: only to be made greatest."""
        return Measure("margin", limits=limits)

    def transmitted_force(
        self, *, into: str | None = None, through: str | None = None, **words: Unpack[Along]
    ) -> Measure:
        """Dynamic force, without the weight: total over all links `into` a place, or in each mount of a link [N]."""
        return Measure("transmitted_force", into=into, through=through, **words)

    def transmissibility(self, *, into: str | None = None, of: str | None = None, **words: Unpack[Looked]) -> Measure:
        """Force `into` a place over the force that shakes, or motion `of` a body over that of its base."""
        return Measure("transmissibility", into=into, of=of, **words)

    def isolation(self, *, into: str | None = None, of: str | None = None, **words: Unpack[Looked]) -> Measure:
        """One minus the transmissibility, as "80 %"."""
        return Measure("isolation", into=into, of=of, **words)

    def displacement(self, *, of: str, **words: Unpack[Along]) -> Measure:
        """Motion of a body, absolute [m]."""
        return Measure("displacement", of=of, **words)

    def velocity(self, *, of: str, **words: Unpack[Along]) -> Measure:
        """Velocity of a body, absolute [m/s]."""
        return Measure("velocity", of=of, **words)

    def acceleration(self, *, of: str, **words: Unpack[Along]) -> Measure:
        """Acceleration of a body, absolute [m/s^2]."""
        return Measure("acceleration", of=of, **words)

    def jerk(self, *, of: str, **words: Unpack[Along]) -> Measure:
        """Rate of change of the acceleration of a body, absolute [m/s^3]."""
        return Measure("jerk", of=of, **words)

    def angular_jerk(self, *, of: str, **words: Unpack[About]) -> Measure:
        """Rate of change of the angular acceleration of a body that turns, absolute [rad/s^3]."""
        return Measure("angular_jerk", of=of, **words)

    def relative_displacement(self, *, across: str, **words: Unpack[Looked]) -> Measure:
        """Relative motion of the two ends of a link [m]."""
        return Measure("relative_displacement", across=across, **words)

    def bending_stress(self, *, of: str, **words: Unpack[Looked]) -> Measure:
        """Greatest stress in a beam or shaft that bends, without that of the weight [Pa]."""
        return Measure("bending_stress", of=of, **words)

    def static_bending_stress(self, *, of: str, **words: Unpack[Shown]) -> Measure:
        """Greatest stress in a beam or shaft under all weights [Pa]."""
        return Measure("static_bending_stress", of=of, **words)

    def combined_bending_stress(self, *, of: str, **words: Unpack[Looked]) -> Measure:
        """Greatest of weight and whirl together in a shaft that bends [Pa]."""
        return Measure("combined_bending_stress", of=of, **words)

    def bearing_force(self, *, of: str, bearing: Literal["left", "right"], **words: Unpack[Looked]) -> Measure:
        """Dynamic force on one support of a beam or shaft that bends [N]."""
        return Measure("bearing_force", of=of, bearing=bearing, **words)

    def stability_threshold(self, **words: Unpack[Shown]) -> Measure:
        """Least spin beyond which a whirl grows, by damping that turns with the shaft [rad/s]."""
        return Measure("stability_threshold", **words)

    def combined_displacement(self, *, of: str, **words: Unpack[Looked]) -> Measure:
        """How far a body gets by its sag and its whirl together [m]."""
        return Measure("combined_displacement", of=of, **words)

    def logarithmic_decrement(self, *, mode: int | None = None, **words: Unpack[Whirling]) -> Measure:
        """Log of the ratio of two deflections one period apart, of the least damped modes or whirls."""
        return Measure("logarithmic_decrement", mode=mode, **words)

    def rms_displacement(self, *, of: str, **words: Unpack[RandomAlong]) -> Measure:
        """Root mean square motion of a body under white noise, absolute [m]."""
        return Measure("rms_displacement", of=of, **words)

    def rms_velocity(self, *, of: str, **words: Unpack[RandomAlong]) -> Measure:
        """Root mean square velocity of a body under white noise, absolute [m/s]."""
        return Measure("rms_velocity", of=of, **words)

    def rms_acceleration(self, *, of: str, **words: Unpack[RandomAlong]) -> Measure:
        """Root mean square acceleration of a body under white noise, absolute [m/s^2]."""
        return Measure("rms_acceleration", of=of, **words)

    def rms_relative_displacement(self, *, across: str, **words: Unpack[Random]) -> Measure:
        """Root mean square of the relative motion of the two ends of a link [m]."""
        return Measure("rms_relative_displacement", across=across, **words)

    def rms_force(
        self, *, into: str | None = None, through: str | None = None, **words: Unpack[RandomAlong]
    ) -> Measure:
        """Root mean square force: total over all links `into` a place, or in each mount of a link [N]."""
        return Measure("rms_force", into=into, through=through, **words)

    def rms_travel(self, *, of: str, **words: Unpack[RandomAlong]) -> Measure:
        """Root mean square of how far a mount in space moves in itself: the most along any of its own axes [m]."""
        return Measure("rms_travel", of=of, **words)

    def rms_bending_stress(self, *, of: str, **words: Unpack[Random]) -> Measure:
        """Root mean square of the greatest stress in a beam or shaft that bends [Pa]."""
        return Measure("rms_bending_stress", of=of, **words)

    def peak_displacement(self, *, of: str, **words: Unpack[InTimeAlong]) -> Measure:
        """Greatest displacement of a body in time, under what comes once [m]."""
        return Measure("peak_displacement", of=of, **words)

    def peak_velocity(self, *, of: str, **words: Unpack[InTimeAlong]) -> Measure:
        """Greatest velocity of a body in time, under what comes once [m/s]."""
        return Measure("peak_velocity", of=of, **words)

    def peak_acceleration(self, *, of: str, **words: Unpack[InTimeAlong]) -> Measure:
        """Greatest acceleration of a body in time, under what comes once [m/s^2]."""
        return Measure("peak_acceleration", of=of, **words)

    def peak_relative_displacement(self, *, across: str, **words: Unpack[InTime]) -> Measure:
        """Greatest relative displacement across a link in time, under what comes once [m]."""
        return Measure("peak_relative_displacement", across=across, **words)

    def peak_force(
        self, *, into: str | None = None, through: str | None = None, **words: Unpack[InTimeAlong]
    ) -> Measure:
        """Greatest force in time: total over all links `into` a place, or in each mount of a link [N]."""
        return Measure("peak_force", into=into, through=through, **words)

    def peak_travel(self, *, of: str, **words: Unpack[InTimeAlong]) -> Measure:
        """Greatest in time of how far a mount in space moves in itself: the most along any of its own axes [m]."""
        return Measure("peak_travel", of=of, **words)

    def peak_bending_stress(self, *, of: str, **words: Unpack[InTime]) -> Measure:
        """Greatest stress in time in a beam or shaft that bends, under what comes once [Pa]."""
        return Measure("peak_bending_stress", of=of, **words)

    def decay_rate(self, **words: Unpack[Shown]) -> Measure:
        """Least decay rate of all modes, rigid motion left out [1/s]."""
        return Measure("decay_rate", **words)

    def mode_ratio(self, *, of: str, relative_to: str, mode: int | None = None, **words: Unpack[Shown]) -> Measure:
        """Motion of a body over that of another in an undamped mode, with its sign; mode 1 without a `mode`."""
        return Measure("mode_ratio", of=of, relative_to=relative_to, mode=mode, **words)

    def free_displacement(
        self, *, of: str, after: str, released: Mapping[str, Mapping[str, str]], **words: Unpack[Shown]
    ) -> Measure:
        """Motion of a body `after` a time of free vibration, with its sign; `released` says how it begins [m]."""
        return Measure("free_displacement", of=of, after=after, released=released, **words)

    def insertion_loss(self, *, across: str, **words: Unpack[Looked]) -> Measure:
        """Motion of the receiver with the link rigid over that with the link; a ratio, usually in dB."""
        return Measure("insertion_loss", across=across, **words)

    def static_deflection(self, *, of: str, **words: Unpack[Still]) -> Measure:
        """Under the weights alone: compression of a link, or sag of a body [m]."""
        return Measure("static_deflection", of=of, **words)

    def natural_frequency(self, *, mode: int | None = None, **words: Unpack[Shown]) -> Measure:
        """Undamped natural frequency [rad/s]; mode 1, the lowest, without a `mode`."""
        return Measure("natural_frequency", mode=mode, **words)

    def critical_speed(
        self,
        *,
        mode: int | None = None,
        whirl: str | None = None,
        damped: bool | None = None,
        **words: Unpack[Shown],
    ) -> Measure:
        """Speed at which a rotor whirls freely as fast as it spins [rad/s]; `whirl` "forward", or "backward"."""
        return Measure("critical_speed", mode=mode, whirl=whirl, damped=damped, **words)

    def amplification_factor(
        self, *, of: str, over: Speeds, due_to: Sequence[str] | None = None, **words: Unpack[Shown]
    ) -> Measure:
        """Speed of a peak of a rotor's whirl over its width at 0.707 of it, the greatest over ranges of the spin."""
        return Measure("amplification_factor", of=of, over=over, due_to=due_to, **words)

    def damping_ratio(self, *, of: str | None = None, mode: int | None = None, **words: Unpack[Whirling]) -> Measure:
        """Damping ratio `of` a link, or of the `mode`-th least damped mode; without both, the least damped."""
        return Measure("damping_ratio", of=of, mode=mode, **words)

    def total_mass(self, **words: Unpack[Shown]) -> Measure:
        """Mass of all bodies [kg]."""
        return Measure("total_mass", **words)

    def mass(self, *, of: str, **words: Unpack[Shown]) -> Measure:
        """Mass of one body [kg]."""
        return Measure("mass", of=of, **words)

    def stiffness(self, *, of: str, **words: Unpack[Shown]) -> Measure:
        """Dynamic stiffness of one single mount of a link [N/m]."""
        return Measure("stiffness", of=of, **words)

    def damping(self, *, of: str, **words: Unpack[Shown]) -> Measure:
        """Viscous damping of one single mount of a link [N s/m]."""
        return Measure("damping", of=of, **words)

    def loss_factor(self, *, of: str, **words: Unpack[Shown]) -> Measure:
        """Loss factor of a link."""
        return Measure("loss_factor", of=of, **words)

    def friction_force(self, *, of: str, **words: Unpack[Shown]) -> Measure:
        """Dry friction of one single mount of a link [N]."""
        return Measure("friction_force", of=of, **words)

    def count(self, *, of: str, **words: Unpack[Shown]) -> Measure:
        """Number of mounts in a link."""
        return Measure("count", of=of, **words)

    def price(self, **words: Unpack[Shown]) -> Measure:
        """Price of all parts from catalogues together."""
        return Measure("price", **words)

    def rotation(self, *, of: str, **words: Unpack[About]) -> Measure:
        """Rotation of a body that turns, absolute [rad]."""
        return Measure("rotation", of=of, **words)

    def twist(self, *, across: str, **words: Unpack[Looked]) -> Measure:
        """Rotation of the two ends of a link against each other [rad]."""
        return Measure("twist", across=across, **words)

    def transmitted_moment(
        self, *, into: str | None = None, through: str | None = None, **words: Unpack[Looked]
    ) -> Measure:
        """Dynamic moment: total over all links `into` a place, or in each shaft of a link [N m]."""
        return Measure("transmitted_moment", into=into, through=through, **words)

    def gear_torque(self, *, of: str, **words: Unpack[Looked]) -> Measure:
        """Dynamic torque that the teeth hand to a body that is geared to another, at its own speed [N m]."""
        return Measure("gear_torque", of=of, **words)

    def shear_stress(self, *, of: str, **words: Unpack[Looked]) -> Measure:
        """Greatest stress in a round shaft that twists, the dynamic part [Pa]."""
        return Measure("shear_stress", of=of, **words)

    def inertia(self, *, of: str, **words: Unpack[Shown]) -> Measure:
        """Moment of inertia of a body that turns [kg m^2]."""
        return Measure("inertia", of=of, **words)

    def torsional_stiffness(self, *, of: str, **words: Unpack[Shown]) -> Measure:
        """Stiffness of one single shaft of a link [N m/rad]."""
        return Measure("torsional_stiffness", of=of, **words)

    def torsional_damping(self, *, of: str, **words: Unpack[Shown]) -> Measure:
        """Viscous damping of one single damper of a link [N m s/rad]."""
        return Measure("torsional_damping", of=of, **words)

    def stroke(self, *, of: str, **words: Unpack[Looked]) -> Measure:
        """Motion of an absorber against what it sits on [m]."""
        return Measure("stroke", of=of, **words)

    def own_frequency(self, *, of: str, **words: Unpack[Shown]) -> Measure:
        """Root of k/m of an absorber [rad/s]."""
        return Measure("own_frequency", of=of, **words)

    def mass_ratio(self, *, of: str, **words: Unpack[Shown]) -> Measure:
        """Mass of an absorber over that of what it refers to."""
        return Measure("mass_ratio", of=of, **words)

    def tuning(self, *, of: str, **words: Unpack[Shown]) -> Measure:
        """Own frequency of an absorber over the frequency that it refers to."""
        return Measure("tuning", of=of, **words)

    def absorber_mass(self, **words: Unpack[Shown]) -> Measure:
        """Mass of all absorbers together [kg]."""
        return Measure("absorber_mass", **words)

    def static_load(self, *, of: str, **words: Unpack[Still]) -> Measure:
        """What one mount carries under all weights, along its axis or a direction; of a group the worst [N]."""
        return Measure("static_load", of=of, **words)

    def tilt(self, *, of: str, axis: Way, **words: Unpack[Shown]) -> Measure:
        """Rotation of a body about an axis under all weights [rad]."""
        return Measure("tilt", of=of, axis=axis, **words)

    def travel(self, *, of: str, **words: Unpack[Along]) -> Measure:
        """How far a mount moves along any of its own axes, or along a direction [m]."""
        return Measure("travel", of=of, **words)

    def energy_share(
        self, *, of: str, direction: Way | None = None, axis: Way | None = None, **words: Unpack[Shown]
    ) -> Measure:
        """Greatest part of a mode's kinetic energy in one motion of a body, along a direction or about an axis."""
        return Measure("energy_share", of=of, direction=direction, axis=axis, **words)

    def frequency_separation(self, **words: Unpack[Shown]) -> Measure:
        """Least difference between neighbouring natural frequencies [rad/s]."""
        return Measure("frequency_separation", **words)
