"""What the curves of a machine with absorbers are read against: itself without them, and its own equal peaks."""

from __future__ import annotations

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms import Modulus
from vibopt.forms.drive_response import DriveResponse, drive_extreme, singularities
from vibopt.mechanics.combine import Extreme
from vibopt.mechanics.model import Model
from vibopt.mechanics.peaks import peaks
from vibopt.program.pose import form_of
from vibopt.responses import HarmonicResponse, Response
from vibopt.scene.assemble import bare, model_of
from vibopt.scene.drives import names_for
from vibopt.scene.scene import Scene
from vibopt.signals import Drive


def model_without(scene: Scene) -> Model | None:
    """The model without absorbers in the same variables; None where there are none, or nothing else moves."""
    if not scene.absorbers:
        return None
    model = model_of(bare(scene))
    return model if model.n_free else None


def form_without(scene: Scene, model: Model, response: Response) -> Modulus | None:
    """A response on the model without absorbers; None where it speaks of an absorber, or is driven through one."""
    assert isinstance(response, HarmonicResponse)
    here = bare(scene)
    gone = {*scene.absorbers, *(name for name in scene.links if name not in here.links)}
    read = {name for name, _ in response.places().values()}
    driven = {scene.excitations[name].on for name in names_for(scene, response)}
    if (read | driven) & gone:
        return None
    return form_of(here, model, response).harmonic


ALIKE = 1e-3
"""Part of the greatest value by which a peak may be lower and still counts as equal."""
_APART, _BESIDE = 1e-6, 1e-5
MOST = 8


def equal_peaks(model: Model, form: Modulus, drive: Drive, x: FloatArray) -> list[Extreme]:
    """Peaks and band ends within 0.1 % of the greatest response to one excitation, by speed [rad/s].

    Empty where the greatest value is alone, infinite or zero.
    """
    top = drive_extreme(model, form, drive, x, False).value
    if not 0.0 < top < np.inf:
        return []
    singular, breaks = singularities(model, form, drive, x)
    response = DriveResponse(model, form, drive, x)
    found = peaks(response, drive.bands, singular, breaks, within=1.0 - 2.0 * ALIKE)
    kept: list[Extreme] = []
    for one in found:
        alone = all(abs(one.speed - other.speed) > _APART * one.speed for other in kept)
        if one.value >= (1.0 - ALIKE) * top and alone and _highest(response, drive, one):
            kept.append(one)
    kept = kept[:MOST]
    return sorted(kept, key=lambda one: one.speed) if len(kept) > 1 else []


def _highest(response: DriveResponse, drive: Drive, one: Extreme) -> bool:
    """Whether nothing beside it, within the bands, is higher."""
    beside = one.speed * np.array([1.0 - _BESIDE, 1.0 + _BESIDE])
    inside = [speed for speed in beside if any(band.low <= speed <= band.high for band in drive.bands)]
    return not inside or bool((response(np.array(inside)) <= one.value * (1.0 + 1e-12)).all())
