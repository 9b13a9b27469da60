"""The machine without its absorbers, drawn and measured beside the one with them."""

from __future__ import annotations

from vibopt.forms import Modulus
from vibopt.mechanics.model import Model
from vibopt.program.pose import form_of
from vibopt.responses import HarmonicResponse
from vibopt.scene.assemble import bare, model_of
from vibopt.scene.drives import names_for
from vibopt.scene.scene import Scene


def model_without(scene: Scene) -> Model | None:
    """The model without absorbers in the same variables; None where there are none, or nothing else moves."""
    if not scene.absorbers:
        return None
    model = model_of(bare(scene))
    return model if model.n_free else None


def form_without(scene: Scene, model: Model, response: HarmonicResponse) -> Modulus | None:
    """A response on the model without absorbers; None where it speaks of an absorber, or is driven through one."""
    here = bare(scene)
    gone = {*scene.absorbers, *(name for name in scene.links if name not in here.links)}
    read = {name for name, _ in response.places().values()}
    driven = {scene.excitations[name].on for name in names_for(scene, response)}
    if (read | driven) & gone:
        return None
    form = form_of(here, model, response)
    return form if isinstance(form, Modulus) else None
