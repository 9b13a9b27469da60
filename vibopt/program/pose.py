"""Scene to Program: the model that is needed, and every limit as a form with its bound."""

from __future__ import annotations

from typing import Any

from vibopt.devices.symbols import Symbols
from vibopt.forms import Form
from vibopt.mechanics.builder import ModelBuilder
from vibopt.mechanics.model import Model
from vibopt.program.program import Aim, Axis, Limit, Program, Side
from vibopt.program.reduce import reduced
from vibopt.responses import HarmonicResponse, Response
from vibopt.responses.natural_frequency import NaturalFrequency
from vibopt.scene.drives import combine_for, drives_for
from vibopt.scene.scene import MINIMISE, Scene
from vibopt.values import SpeedRange


def model_of(scene: Scene) -> Model:
    """The full mechanical model of a scene, one coordinate a body."""
    symbols = Symbols({variable.path: i for i, variable in enumerate(scene.variables)})
    builder = ModelBuilder(len(scene.variables), list(scene.bodies), list(scene.bases))
    for name, body in scene.bodies.items():
        body.add_to(builder, name, symbols)
    only = next(iter(scene.bodies)) if len(scene.bodies) == 1 else None
    for name, link in scene.links.items():
        relative = link.relative_to or only
        mass = scene.bodies[relative].mass_of(relative, symbols) if relative is not None else None
        link.add_to(builder, name, symbols, mass)
    return builder.build()


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
        coords = (*scene.bodies, *scene.bases)
        drives = tuple(model.carry(drive) for drive in drives_for(scene, response, coords))
        return response.form(model, drives, combine_for(scene, response))
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
