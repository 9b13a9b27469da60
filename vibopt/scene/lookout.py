"""How high a scene looks: the frequencies up to which its structures must be right, and their lowest modes."""

from __future__ import annotations

import math

import numpy as np

from vibopt.responses import HarmonicResponse, Response
from vibopt.scene.drives import bands_for, names_for
from vibopt.scene.places import devices
from vibopt.scene.scene import Scene

_LEAST = 1.0
_MARGIN = 1.05


def looked_at(scene: Scene) -> tuple[float, int]:
    """Highest frequency of any limit, measure or goal [rad/s], and how many lowest modes are asked for.

    Frequencies without an end are left to the modes.
    """
    asked: list[Response] = [*scene.limits.values(), *scene.measures.values()]
    if scene.goal is not None:
        asked.append(scene.goal.response)
    tops = [top for one in asked for top in _tops(scene, one) if math.isfinite(top)]
    modes = max((one.modes for one in asked), default=0)
    tuned = [one.mode or 1 for one in scene.absorbers.values() if one.has_spring and one.tuning_to is None]
    modes = max([modes, *tuned])
    if modes:
        modes += sum(table.between_points for _, _, table in devices(scene))
    return _MARGIN * max([_LEAST, *tops]), modes


def _tops(scene: Scene, response: Response) -> list[float]:
    if isinstance(response, HarmonicResponse):
        names = [name for name in names_for(scene, response) if name in scene.excitations]
        return [
            line.order * band.high
            for name in names
            for band in bands_for(scene, response, name)
            for line in scene.excitations[name].lines(np.ones(1))
        ]
    return [band.high for band in response.outside_bands]
