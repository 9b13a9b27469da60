"""Responses as methods of a machine: one method a response, named as in the file.

Values are the worst over all the speeds that are looked at; amplitudes are peak.  A word that a response
does not have is refused by the reader of scenes, with a suggestion.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial, update_wrapper
from typing import TYPE_CHECKING, Generic, Literal, ParamSpec, TypedDict, Unpack

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


Words = ParamSpec("Words")


class Asked(Generic[Words]):
    """A response by the name under which it stands, which takes its place and its words as `like` does."""

    def __init__(self, like: Callable[Words, None], said: str) -> None:
        update_wrapper(self, like)
        self.__doc__ = said

    def __set_name__(self, owner: type, name: str) -> None:
        self.__name__ = name

    def __call__(self, *unnamed: Words.args, **words: Words.kwargs) -> Measure:
        if unnamed:
            raise TypeError(f"{self.__name__}() takes its words by their names")
        return Measure(self.__name__, **words)


def _through_along(*, into: str | None = None, through: str | None = None, **words: Unpack[Along]) -> None: ...
def _ratio_looked(*, into: str | None = None, of: str | None = None, **words: Unpack[Looked]) -> None: ...
def _of_along(*, of: str, **words: Unpack[Along]) -> None: ...
def _of_about(*, of: str, **words: Unpack[About]) -> None: ...
def _across_looked(*, across: str, **words: Unpack[Looked]) -> None: ...
def _of_looked(*, of: str, **words: Unpack[Looked]) -> None: ...
def _of(*, of: str, **words: Unpack[Shown]) -> None: ...
def _whole(**words: Unpack[Shown]) -> None: ...
def _of_random_along(*, of: str, **words: Unpack[RandomAlong]) -> None: ...
def _across_random(*, across: str, **words: Unpack[Random]) -> None: ...
def _through_random_along(
    *, into: str | None = None, through: str | None = None, **words: Unpack[RandomAlong]
) -> None: ...
def _of_random(*, of: str, **words: Unpack[Random]) -> None: ...
def _of_in_time_along(*, of: str, **words: Unpack[InTimeAlong]) -> None: ...
def _across_in_time(*, across: str, **words: Unpack[InTime]) -> None: ...
def _through_in_time_along(
    *, into: str | None = None, through: str | None = None, **words: Unpack[InTimeAlong]
) -> None: ...
def _of_in_time(*, of: str, **words: Unpack[InTime]) -> None: ...
def _of_still(*, of: str, **words: Unpack[Still]) -> None: ...
def _through_looked(*, into: str | None = None, through: str | None = None, **words: Unpack[Looked]) -> None: ...


class Responses:
    """What can be limited, measured or made best; kinds without a method of their own go by their words in a file."""

    if not TYPE_CHECKING:

        def __getattr__(self, kind: str) -> Callable[..., Measure]:
            if kind not in GOALS:
                raise AttributeError(f"there is no {kind}.{way_out(kind, list(GOALS))}")
            return partial(Measure, kind)

    transmitted_force = Asked(
        _through_along,
        "Dynamic force, without the weight: total over all links `into` a place, or in each mount of a link [N].",
    )
    transmissibility = Asked(
        _ratio_looked, "Force `into` a place over the force that shakes, or motion `of` a body over that of its base."
    )
    isolation = Asked(_ratio_looked, 'One minus the transmissibility, as "80 %".')
    displacement = Asked(_of_along, "Motion of a body, absolute [m].")
    velocity = Asked(_of_along, "Velocity of a body, absolute [m/s].")
    acceleration = Asked(_of_along, "Acceleration of a body, absolute [m/s^2].")
    jerk = Asked(_of_along, "Rate of change of the acceleration of a body, absolute [m/s^3].")
    angular_jerk = Asked(
        _of_about, "Rate of change of the angular acceleration of a body that turns, absolute [rad/s^3]."
    )
    relative_displacement = Asked(_across_looked, "Relative motion of the two ends of a link [m].")
    bending_stress = Asked(
        _of_looked, "Greatest stress in a beam or shaft that bends, without that of the weight [Pa]."
    )
    static_bending_stress = Asked(_of, "Greatest stress in a beam or shaft under all weights [Pa].")
    combined_bending_stress = Asked(_of_looked, "Greatest of weight and whirl together in a shaft that bends [Pa].")
    stability_threshold = Asked(
        _whole, "Least spin beyond which a whirl grows, by damping that turns with the shaft [rad/s]."
    )
    combined_displacement = Asked(_of_looked, "How far a body gets by its sag and its whirl together [m].")
    rms_displacement = Asked(_of_random_along, "Root mean square motion of a body under white noise, absolute [m].")
    rms_velocity = Asked(_of_random_along, "Root mean square velocity of a body under white noise, absolute [m/s].")
    rms_acceleration = Asked(
        _of_random_along, "Root mean square acceleration of a body under white noise, absolute [m/s^2]."
    )
    rms_relative_displacement = Asked(
        _across_random, "Root mean square of the relative motion of the two ends of a link [m]."
    )
    rms_force = Asked(
        _through_random_along,
        "Root mean square force: total over all links `into` a place, or in each mount of a link [N].",
    )
    rms_travel = Asked(
        _of_random_along,
        "Root mean square of how far a mount in space moves in itself: the most along any of its own axes [m].",
    )
    rms_bending_stress = Asked(
        _of_random, "Root mean square of the greatest stress in a beam or shaft that bends [Pa]."
    )
    peak_displacement = Asked(_of_in_time_along, "Greatest displacement of a body in time, under what comes once [m].")
    peak_velocity = Asked(_of_in_time_along, "Greatest velocity of a body in time, under what comes once [m/s].")
    peak_acceleration = Asked(
        _of_in_time_along, "Greatest acceleration of a body in time, under what comes once [m/s^2]."
    )
    peak_relative_displacement = Asked(
        _across_in_time, "Greatest relative displacement across a link in time, under what comes once [m]."
    )
    peak_force = Asked(
        _through_in_time_along,
        "Greatest force in time: total over all links `into` a place, or in each mount of a link [N].",
    )
    peak_travel = Asked(
        _of_in_time_along,
        "Greatest in time of how far a mount in space moves in itself: the most along any of its own axes [m].",
    )
    peak_bending_stress = Asked(
        _of_in_time, "Greatest stress in time in a beam or shaft that bends, under what comes once [Pa]."
    )
    decay_rate = Asked(_whole, "Least decay rate of all modes, rigid motion left out [1/s].")
    insertion_loss = Asked(
        _across_looked, "Motion of the receiver with the link rigid over that with the link; a ratio, usually in dB."
    )
    static_deflection = Asked(_of_still, "Under the weights alone: compression of a link, or sag of a body [m].")
    total_mass = Asked(_whole, "Mass of all bodies [kg].")
    mass = Asked(_of, "Mass of one body [kg].")
    stiffness = Asked(_of, "Dynamic stiffness of one single mount of a link [N/m].")
    damping = Asked(_of, "Viscous damping of one single mount of a link [N s/m].")
    loss_factor = Asked(_of, "Loss factor of a link.")
    friction_force = Asked(_of, "Dry friction of one single mount of a link [N].")
    count = Asked(_of, "Number of mounts in a link.")
    price = Asked(_whole, "Price of all parts from catalogues together.")
    rotation = Asked(_of_about, "Rotation of a body that turns, absolute [rad].")
    twist = Asked(_across_looked, "Rotation of the two ends of a link against each other [rad].")
    transmitted_moment = Asked(
        _through_looked, "Dynamic moment: total over all links `into` a place, or in each shaft of a link [N m]."
    )
    gear_torque = Asked(
        _of_looked, "Dynamic torque that the teeth hand to a body that is geared to another, at its own speed [N m]."
    )
    shear_stress = Asked(_of_looked, "Greatest stress in a round shaft that twists, the dynamic part [Pa].")
    inertia = Asked(_of, "Moment of inertia of a body that turns [kg m^2].")
    torsional_stiffness = Asked(_of, "Stiffness of one single shaft of a link [N m/rad].")
    torsional_damping = Asked(_of, "Viscous damping of one single damper of a link [N m s/rad].")
    stroke = Asked(_of_looked, "Motion of an absorber against what it sits on [m].")
    own_frequency = Asked(_of, "Root of k/m of an absorber [rad/s].")
    mass_ratio = Asked(_of, "Mass of an absorber over that of what it refers to.")
    tuning = Asked(_of, "Own frequency of an absorber over the frequency that it refers to.")
    absorber_mass = Asked(_whole, "Mass of all absorbers together [kg].")
    static_load = Asked(
        _of_still, "What one mount carries under all weights, along its axis or a direction; of a group the worst [N]."
    )
    travel = Asked(_of_along, "How far a mount moves along any of its own axes, or along a direction [m].")
    frequency_separation = Asked(_whole, "Least difference between neighbouring natural frequencies [rad/s].")

    def margin(self, *, limits: Sequence[str] | None = None) -> Measure:
        """Part of its bound that every limit, or each of some `limits`, has left over: only to be made greatest."""
        return Measure("margin", limits=limits)

    def bearing_force(self, *, of: str, bearing: Literal["left", "right"], **words: Unpack[Looked]) -> Measure:
        """Dynamic force on one support of a beam or shaft that bends [N]."""
        return Measure("bearing_force", of=of, bearing=bearing, **words)

    def logarithmic_decrement(self, *, mode: int | None = None, **words: Unpack[Whirling]) -> Measure:
        """Log of the ratio of two deflections one period apart, of the least damped modes or whirls."""
        return Measure("logarithmic_decrement", mode=mode, **words)

    def mode_ratio(self, *, of: str, relative_to: str, mode: int | None = None, **words: Unpack[Shown]) -> Measure:
        """Motion of a body over that of another in an undamped mode, with its sign; mode 1 without a `mode`."""
        return Measure("mode_ratio", of=of, relative_to=relative_to, mode=mode, **words)

    def free_displacement(
        self, *, of: str, after: str, released: Mapping[str, Mapping[str, str]], **words: Unpack[Shown]
    ) -> Measure:
        """Motion of a body `after` a time of free vibration, with its sign; `released` says how it begins [m]."""
        return Measure("free_displacement", of=of, after=after, released=released, **words)

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

    def tilt(self, *, of: str, axis: Way, **words: Unpack[Shown]) -> Measure:
        """Rotation of a body about an axis under all weights [rad]."""
        return Measure("tilt", of=of, axis=axis, **words)

    def energy_share(
        self, *, of: str, direction: Way | None = None, axis: Way | None = None, **words: Unpack[Shown]
    ) -> Measure:
        """Greatest part of a mode's kinetic energy in one motion of a body, along a direction or about an axis."""
        return Measure("energy_share", of=of, direction=direction, axis=axis, **words)
