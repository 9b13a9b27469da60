"""Scene to Program: the model that is needed, and every limit as a form with its bound."""

from __future__ import annotations

from typing import Any

from vibopt.forms import Form
from vibopt.mechanics.model import Model
from vibopt.program.program import Aim, Axis, Limit, Program, Side
from vibopt.program.reduce import reduced
from vibopt.responses import HarmonicResponse, RandomResponse, Response
from vibopt.responses.natural_frequency import NaturalFrequency
from vibopt.scene.assemble import model_of
from vibopt.scene.drives import combine_for, drives_for, noises_for
from vibopt.scene.scene import MINIMISE, Scene
from vibopt.values import SpeedRange


def pose(scene: Scene, *, reduce: bool = True) -> Program:
    """The question of a scene as data.

    Parameters
    ----------
    scene
        A scene without mistakes.
    reduce
        Give every form the smallest exact model that it needs.
    """
    full = model_of(scene)
    limits = tuple(limit for name, one in scene.limits.items() for limit in _limits(scene, full, name, one, reduce))
    aim = None
    if scene.goal is not None:
        response = scene.goal.response
        sense = 1.0 if scene.goal.sense == MINIMISE else -1.0
        model, form = on_needed(scene, full, response, reduce=reduce)
        aim = Aim(scene.goal.name, model, form, -sense if response.complement else sense, response.complement)
    axes = tuple(Axis(v.path, v.low, v.high, v.values, v.choice.open_low) for v in scene.variables)
    return Program(full, axes, limits, aim)


def on_needed(scene: Scene, full: Model, response: Response, *, reduce: bool = True) -> tuple[Model, Form]:
    """The smallest exact model for a response, and its form on it."""
    form = form_of(scene, full, response)
    if not reduce or full.n_free == 1:
        return full, form
    model = reduced(full, form)
    return model, form if model is full else form_of(scene, model, response)


def form_of(scene: Scene, model: Model, response: Response) -> Form:
    """The form of one response on a model."""
    if isinstance(response, HarmonicResponse):
        drives = drives_for(scene, response, model.points)
        return response.form(model, drives, combine_for(scene, response))
    if isinstance(response, RandomResponse):
        return response.noise_form(model, noises_for(scene, response, model.points))
    return response.form(model, (), "sum")


def _limits(scene: Scene, full: Model, name: str, response: Response, reduce: bool) -> list[Limit]:
    model, form = on_needed(scene, full, response, reduce=reduce)
    if isinstance(response, NaturalFrequency) and isinstance(response.outside, SpeedRange):
        return [Limit(name, model, form, "outside", band.low, band.high) for band in response.outside.bands]
    made = []
    sides: tuple[tuple[Side, Side, Any], ...] = (
        ("at_most", "at_least", response.at_most),
        ("at_least", "at_most", response.at_least),
    )
    for side, other, given in sides:
        if given is None:
            continue
        if response.complement:
            made.append(Limit(name, model, form, other, 1.0 - given.value, complement=True))
        else:
            made.append(Limit(name, model, form, side, given.value))
    return made
