"""Which excitations a response looks at, over which speeds, how high a scene looks, and bounds that these bring."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.excitations import Excitation
from vibopt.mechanics.builder import EVERY_MODE
from vibopt.responses import HarmonicResponse, RandomResponse, Response, TransientResponse
from vibopt.responses.asked_speeds import START_UP
from vibopt.scene.places import devices, once, rubbing
from vibopt.scene.scene import Scene
from vibopt.signals import Amplitude, Band, Combine, Drive, Line, Noise, Piece, Segment, Sort, Sweep, Sweeps
from vibopt.units import Quantity
from vibopt.values import SpeedRange
from vibopt.values.speeds import VEHICLE

if TYPE_CHECKING:
    from vibopt.devices.mount import MountTable
    from vibopt.mechanics.motor import Motor


UNIT = Amplitude((Piece(Band(0.0, math.inf), 1.0),))
_ALONE = np.ones((1, 1))


def names_for(scene: Scene, response: HarmonicResponse | RandomResponse | TransientResponse) -> tuple[str, ...]:
    """Excitations that the response counts: those in `due_to`, else all of its sort: steady, random or transient."""
    if response.due_to is not None:
        return response.due_to
    return _of_sorts(scene, *response.speaks_of)


@once
def _of_sorts(scene: Scene, *sorts: Sort) -> tuple[str, ...]:
    return tuple(
        name for name, excitation in scene.excitations.items() if any(sort in excitation.sorts for sort in sorts)
    )


@once
def own_bands(scene: Scene, name: str) -> tuple[Band, ...]:
    """Own speeds of an excitation [rad/s]."""
    return scene.excitations[name].own_bands()


def noises_for(scene: Scene, response: RandomResponse, points: Mapping[str, FloatArray]) -> tuple[Noise, ...]:
    """The white noises that the response counts; `points` are rows of the model by name, (n_coords,) each."""
    every = ((name, scene.excitations[name]) for name in names_for(scene, response))
    return tuple(noise.noise(name, row_of(noise, points)) for name, noise in every)


def signals_for(
    scene: Scene, response: TransientResponse, points: Mapping[str, FloatArray], n_free: int
) -> tuple[FloatArray, tuple[Segment, ...] | Sweep | Sweeps | Motor]:
    """What the response counts in time: the coordinates that it acts on, (n_coords, n_signals), signals or a run-up."""
    every = [scene.excitations[name] for name in names_for(scene, response)]
    rows = np.array([row_of(excitation, points) for excitation in every]).T
    forces = np.array([excitation.family == "bodies" for excitation in every])
    acts = np.arange(len(rows))[:, None] < n_free
    loads = np.where(acts == forces, rows, 0.0)
    if every[0].ramp is not None:
        from vibopt.excitations.run_up import course_of

        places = {variable.path: i for i, variable in enumerate(scene.variables)}
        return loads, course_of(every[0], places, names_for(scene, response)[0])
    return loads, _signals(scene, *names_for(scene, response))


@once
def _signals(scene: Scene, *names: str) -> tuple[Segment, ...]:
    """What some excitations do in time, together: one for all responses, whose motion is then one, too."""
    from vibopt.excitations.segments import together

    every = (scene.excitations[name].once for name in names)
    return together([one.segments() for one in every if one is not None])


def at_rates(scene: Scene, x: FloatArray) -> Scene:
    """The scene of which every run-up has the rate that a design x (n_vars,) chooses; its variables stay."""
    from vibopt.excitations.run_up import RATE, at_rate

    chosen = scene.named(x)
    fixed = {name: at_rate(each, chosen.get(RATE.format(name))) for name, each in scene.excitations.items()}
    return replace(scene, excitations=fixed)


def signals_lasting(scene: Scene, response: TransientResponse, duration: float) -> tuple[Segment, ...]:
    """The signals that the response counts, where a pulse that may have any duration has this one [s]."""
    from vibopt.excitations.segments import together

    every = [scene.excitations[name].once for name in names_for(scene, response)]
    return together([one.lasting(duration).segments() for one in every if one is not None])


def beside_of(scene: Scene, response: TransientResponse) -> float:
    """About the fastest rate of what comes beside a pulse that may have any duration [rad/s]; zero of none."""
    every = (scene.excitations[name].once for name in names_for(scene, response))
    return max((one.fastest for one in every if one is not None and one.durations is None), default=0.0)


def durations_of(scene: Scene, response: TransientResponse) -> tuple[float, float] | None:
    """Shortest and longest duration of the pulse among what it counts that may have any [s]; None without one."""
    every = (scene.excitations[name].once for name in names_for(scene, response))
    return next((one.durations for one in every if one is not None and one.durations is not None), None)


def speeds_for(scene: Scene, response: HarmonicResponse, name: str) -> SpeedRange | str | None:
    """What the response says about the speeds of one excitation; None for its own speeds."""
    given = response.at if response.at is not None else response.over
    own: SpeedRange | str | None = given.get(name) if isinstance(given, dict) else given
    return own


def bands_for(scene: Scene, response: HarmonicResponse, name: str) -> tuple[Band, ...]:
    """Speeds to look at [rad/s] for one excitation."""
    excitation = scene.excitations[name]
    given = speeds_for(scene, response, name)
    if given is None:
        return own_bands(scene, name)
    if isinstance(given, str) and given == START_UP:
        return (Band(0.0, max(band.high for band in own_bands(scene, name))),)
    if isinstance(given, SpeedRange) and given.dimension == VEHICLE:
        return tuple(excitation.to_rotation(band) for band in given.bands)
    assert isinstance(given, SpeedRange)
    return given.bands


def drives_for(scene: Scene, response: HarmonicResponse, points: Mapping[str, FloatArray]) -> tuple[Drive, ...]:
    """The excitations as the response sees them; `points` are rows of the model by name, (n_coords,) each."""
    drives = []
    last, known = scene.__dict__.get("drives", (None, {}))  # of the last model: every response asks for the same lines
    if last is not points:
        known = dict[str, tuple[Line, ...]]()
        scene.__dict__["drives"] = points, known
    for name in names_for(scene, response):
        key = f"{name} on {response.placed.get(name, '')}"
        if key not in known:
            parts = shaker_for(scene, response, name).loose
            known[key] = tuple(line for part in parts for line in part.lines(row_of(part, points)))
        lines = known[key]
        if response.normalised and not rubbing(scene):  # friction makes a ratio hang on the amplitude
            lines = tuple(replace(line, amplitude=UNIT) for line in lines)
        drives.append(Drive(name, lines, bands_for(scene, response, name)))
    return tuple(drives)


def loose_in(scene: Scene, response: HarmonicResponse) -> str:
    """The excitation that it counts of which parts stand at any angles; "" of none."""
    known = (name for name in names_for(scene, response) if name in scene.excitations)
    return next((name for name in known if len(scene.excitations[name].loose) > 1), "")


def shaker_for(scene: Scene, response: Response, name: str) -> Excitation:
    """An excitation as the response sees it: what may be at several places at the one that is asked about."""
    shaker = scene.excitations[name]
    return shaker.anywhere[response.placed[name]] if name in response.placed else shaker


def row_of(excitation: Excitation, points: Mapping[str, FloatArray]) -> FloatArray:
    """What an excitation acts on, as a row over the coordinates (n_coords,); complex where it goes round."""
    acts = excitation.acts
    if acts == {excitation.on: 1.0}:
        return points[excitation.on]
    weights = np.array(list(acts.values()), dtype=complex)
    row: FloatArray = (weights if weights.imag.any() else weights.real) @ np.array([points[place] for place in acts])
    return row


def combine_for(scene: Scene, response: HarmonicResponse) -> Combine:
    """How several harmonics or excitations are combined; "sum" where there is only one."""
    if response.combine == "rss":
        return "rss"
    return "peak" if response.combine == "peak" else "sum"


@once
def unit_lines(scene: Scene, name: str) -> tuple[Line, ...]:
    """Harmonics of an excitation, those of each of its loose parts along a direction of its own."""
    parts = scene.excitations[name].loose
    ways = _ALONE if len(parts) == 1 else np.eye(len(parts))
    return tuple(line for way, part in zip(ways, parts, strict=True) for line in part.lines(way))


def line_count(scene: Scene, names: Iterable[str]) -> int:
    """Number of harmonics of some excitations; what is loose counts once, for it adds up in one way alone."""
    return sum(len(unit_lines(scene, name)) // len(scene.excitations[name].loose) for name in names)


_LEAST = 1.0
_MARGIN = 1.05
_RINGS = 3.0
"""Highest frequency of free whirls in a run-up of a rotor, over its speed."""


def looked_at(scene: Scene) -> tuple[float, int]:
    """Highest frequency of any limit, measure or goal [rad/s], and how many lowest modes are asked for.

    Frequencies without an end are left to the modes.
    """
    asked = scene.responses.values()
    tops = [top for response in asked for top in _tops(scene, response) if math.isfinite(top)]
    modes = max((response.modes for response in asked), default=0)
    tuned = [
        absorber.mode or 1
        for absorber in scene.absorbers.values()
        if absorber.has_spring and absorber.tuning_to is None
    ]
    modes = max([modes, *tuned])
    if scene.structures and any(isinstance(one, (RandomResponse, TransientResponse)) for one in asked):
        modes = EVERY_MODE
    if modes and scene.structures:
        modes += sum(table.between_points for _, _, table in devices(scene))
    return _MARGIN * max([_LEAST, *tops]), modes


def highest_asked(scene: Scene) -> float:
    """Highest frequency of any limit, measure or goal that has an end [rad/s]; zero of none."""
    return max(
        (top for response in scene.responses.values() for top in _tops(scene, response) if math.isfinite(top)),
        default=0.0,
    )


def _tops(scene: Scene, response: Response) -> list[float]:
    if isinstance(response, HarmonicResponse):
        names = [name for name in names_for(scene, response) if name in scene.excitations]
        return [
            line.order * band.high
            for name in names
            for band in bands_for(scene, response, name)
            for line in unit_lines(scene, name)
        ]
    if isinstance(response, TransientResponse) and scene.rotors:
        from vibopt.excitations.run_up import band_of

        rising = [scene.excitations[name] for name in names_for(scene, response) if name in scene.excitations]
        return [_RINGS * band_of(each).high for each in rising if each.ramp is not None]
    beyond = [] if response.reading is None else _tops(scene, response.reading)
    return [*(band.high for band in response.outside_bands), *response.reaches, *beyond]


def with_own_bounds(
    limits: Mapping[str, Response], mounts: Mapping[str, MountTable], excitations: Mapping[str, Excitation]
) -> dict[str, Response]:
    """The limits: without a bound on the load or the travel of a mount its rating or its gap; orders as bands."""
    return {name: _bounded(_banded(limit, excitations), mounts) for name, limit in limits.items()}


def _banded(limit: Response, excitations: Mapping[str, Excitation]) -> Response:
    """Orders stay where the excitation that they name is none, or has no speed."""
    shaker = excitations.get(limit.orders_of)
    return limit if shaker is None or shaker.sort != "steady" else limit.at_orders(shaker.own_bands())


def _bounded(limit: Response, mounts: Mapping[str, MountTable]) -> Response:
    if limit.at_most is not None or limit.at_least is not None:
        return limit
    name = getattr(limit, "of", None)
    mount = next(
        (mount_table for group, mount_table in mounts.items() if name == group or name in mount_table.singles(group)),
        None,
    )
    if mount is None:
        return limit
    if limit.response == "static_load" and mount.rating is not None:
        return limit.model_copy(update={"at_least": mount.rating.least, "at_most": mount.rating.most})
    if limit.response in ("travel", "peak_travel") and mount.gap is not None:
        return limit.model_copy(update={"at_most": Quantity(mount.gap.value, mount.gap.unit)})
    return limit
