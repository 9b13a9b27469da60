"""Responses as methods of a machine: one method a response, named as in the file.

Values are the worst over all the speeds that are looked at; amplitudes are peak.  A word that a response
does not have is refused by the reader of scenes, with a suggestion.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial, update_wrapper
from inspect import getdoc
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

    def __init__(self, like: Callable[Words, None]) -> None:
        update_wrapper(self, like, assigned=("__annotations__",))

    def __set_name__(self, owner: type, name: str) -> None:
        self.__name__ = name

    if not TYPE_CHECKING:

        @property
        def __doc__(self) -> str:
            """What it is, as beside its table."""
            return getdoc(GOALS[self.__name__])

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
def _margin(*, limits: Sequence[str] | None = None) -> None: ...
def _bearing_force(*, of: str, bearing: Literal["left", "right"], **words: Unpack[Looked]) -> None: ...
def _logarithmic_decrement(*, mode: int | None = None, **words: Unpack[Whirling]) -> None: ...
def _mode_ratio(*, of: str, relative_to: str, mode: int | None = None, **words: Unpack[Shown]) -> None: ...
def _free_displacement(
    *, of: str, after: str, released: Mapping[str, Mapping[str, str]], **words: Unpack[Shown]
) -> None: ...
def _natural_frequency(*, mode: int | None = None, **words: Unpack[Shown]) -> None: ...
def _critical_speed(
    *, mode: int | None = None, whirl: str | None = None, damped: bool | None = None, **words: Unpack[Shown]
) -> None: ...
def _amplification_factor(
    *, of: str, over: Speeds, due_to: Sequence[str] | None = None, **words: Unpack[Shown]
) -> None: ...
def _damping_ratio(*, of: str | None = None, mode: int | None = None, **words: Unpack[Whirling]) -> None: ...
def _tilt(*, of: str, axis: Way, **words: Unpack[Shown]) -> None: ...
def _energy_share(
    *, of: str, direction: Way | None = None, axis: Way | None = None, **words: Unpack[Shown]
) -> None: ...


class Responses:
    """What can be limited, measured or made best; kinds without a method of their own go by their words in a file."""

    if not TYPE_CHECKING:

        def __getattr__(self, kind: str) -> Callable[..., Measure]:
            if kind not in GOALS:
                raise AttributeError(f"there is no {kind}.{way_out(kind, list(GOALS))}")
            return partial(Measure, kind)

    transmitted_force = Asked(_through_along)
    transmissibility = Asked(_ratio_looked)
    isolation = Asked(_ratio_looked)
    displacement = Asked(_of_along)
    velocity = Asked(_of_along)
    acceleration = Asked(_of_along)
    jerk = Asked(_of_along)
    angular_jerk = Asked(_of_about)
    relative_displacement = Asked(_across_looked)
    bending_stress = Asked(_of_looked)
    static_bending_stress = Asked(_of)
    combined_bending_stress = Asked(_of_looked)
    stability_threshold = Asked(_whole)
    combined_displacement = Asked(_of_looked)
    rms_displacement = Asked(_of_random_along)
    rms_velocity = Asked(_of_random_along)
    rms_acceleration = Asked(_of_random_along)
    rms_relative_displacement = Asked(_across_random)
    rms_force = Asked(_through_random_along)
    rms_travel = Asked(_of_random_along)
    rms_bending_stress = Asked(_of_random)
    peak_displacement = Asked(_of_in_time_along)
    peak_velocity = Asked(_of_in_time_along)
    peak_acceleration = Asked(_of_in_time_along)
    peak_relative_displacement = Asked(_across_in_time)
    peak_force = Asked(_through_in_time_along)
    peak_travel = Asked(_of_in_time_along)
    peak_bending_stress = Asked(_of_in_time)
    decay_rate = Asked(_whole)
    insertion_loss = Asked(_across_looked)
    static_deflection = Asked(_of_still)
    total_mass = Asked(_whole)
    mass = Asked(_of)
    stiffness = Asked(_of)
    damping = Asked(_of)
    loss_factor = Asked(_of)
    friction_force = Asked(_of)
    count = Asked(_of)
    price = Asked(_whole)
    rotation = Asked(_of_about)
    twist = Asked(_across_looked)
    transmitted_moment = Asked(_through_looked)
    gear_torque = Asked(_of_looked)
    shear_stress = Asked(_of_looked)
    inertia = Asked(_of)
    torsional_stiffness = Asked(_of)
    torsional_damping = Asked(_of)
    stroke = Asked(_of_looked)
    own_frequency = Asked(_of)
    mass_ratio = Asked(_of)
    tuning = Asked(_of)
    absorber_mass = Asked(_whole)
    static_load = Asked(_of_still)
    travel = Asked(_of_along)
    frequency_separation = Asked(_whole)
    margin = Asked(_margin)
    bearing_force = Asked(_bearing_force)
    logarithmic_decrement = Asked(_logarithmic_decrement)
    mode_ratio = Asked(_mode_ratio)
    free_displacement = Asked(_free_displacement)
    natural_frequency = Asked(_natural_frequency)
    critical_speed = Asked(_critical_speed)
    amplification_factor = Asked(_amplification_factor)
    damping_ratio = Asked(_damping_ratio)
    tilt = Asked(_tilt)
    energy_share = Asked(_energy_share)
