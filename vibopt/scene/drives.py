"""Which excitations a response looks at, and over which speeds."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from vibopt.excitations import Excitation
from vibopt.forms import Amplitude, Band, Combine, Drive, FloatArray, Line, Noise, Piece
from vibopt.responses import HarmonicResponse, RandomResponse
from vibopt.responses.kind import START_UP
from vibopt.scene.scene import Scene
from vibopt.values import SpeedRange
from vibopt.values.speeds import VEHICLE

UNIT = Amplitude((Piece(Band(0.0, math.inf), 1.0),))


def names_for(scene: Scene, response: HarmonicResponse | RandomResponse) -> tuple[str, ...]:
    """Excitations that the response counts: those in `due_to`, else all of its sort, steady or random."""
    if response.due_to is not None:
        return response.due_to
    return tuple(name for name, one in scene.excitations.items() if one.random == response.random)


def noises_for(scene: Scene, response: RandomResponse, points: Mapping[str, FloatArray]) -> tuple[Noise, ...]:
    """The white noises that the response counts; `points` are rows of the model by name, (n_coords,) each."""
    return tuple(scene.excitations[name].noise(name, points) for name in names_for(scene, response))


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
        return excitation.own_bands()
    if isinstance(given, str) and given == START_UP:
        return (Band(0.0, max(band.high for band in excitation.own_bands())),)
    if isinstance(given, SpeedRange) and given.dimension == VEHICLE:
        return tuple(excitation.to_rotation(band) for band in given.bands)
    assert isinstance(given, SpeedRange)
    return given.bands


def drives_for(scene: Scene, response: HarmonicResponse, points: Mapping[str, FloatArray]) -> tuple[Drive, ...]:
    """The excitations as the response sees them; `points` are rows of the model by name, (n_coords,) each."""
    drives = []
    for name in names_for(scene, response):
        excitation = scene.excitations[name]
        lines = excitation.lines(row_of(excitation, points))
        if response.normalised:
            lines = tuple(replace(line, amplitude=UNIT) for line in lines)
        drives.append(Drive(name, lines, bands_for(scene, response, name)))
    return tuple(drives)


def row_of(excitation: Excitation, points: Mapping[str, FloatArray]) -> FloatArray:
    """What an excitation acts on, as a row over the coordinates (n_coords,); complex where it goes round."""
    acts = excitation.acts
    weights = np.array(list(acts.values()), dtype=complex)
    row: FloatArray = (weights if weights.imag.any() else weights.real) @ np.array([points[place] for place in acts])
    return row


def combine_for(scene: Scene, response: HarmonicResponse) -> Combine:
    """How several harmonics or excitations are combined; "sum" where there is only one."""
    if response.combine == "rss":
        return "rss"
    return "peak" if response.combine == "peak" else "sum"


def line_count(scene: Scene, response: HarmonicResponse) -> int:
    """Number of harmonics that the response counts, over all its excitations."""
    one = np.ones(1)
    return sum(len(scene.excitations[name].lines(one)) for name in names_for(scene, response))


__all__ = ["Line", "bands_for", "combine_for", "drives_for", "line_count", "names_for", "noises_for", "speeds_for"]
