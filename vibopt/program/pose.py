"""Scene to Program: the model that is needed, and every limit as a form with its bound."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import AbstractContextManager
from contextvars import ContextVar
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from vibopt import forms
from vibopt.arrays import FloatArray
from vibopt.forms import Form
from vibopt.forms.reduce import reduced
from vibopt.mechanics.model import Model
from vibopt.program.from_rest import from_rest, graded
from vibopt.program.one_machine import form_kept, model_kept
from vibopt.program.program import Aim, Axis, Limit, Program, Side, Tie
from vibopt.responses import HarmonicResponse, RandomResponse, Response, TransientResponse
from vibopt.scene.assemble import model_of
from vibopt.scene.drives import (
    beside_of,
    combine_for,
    drives_for,
    durations_of,
    names_for,
    noises_for,
    signals_for,
    signals_lasting,
)
from vibopt.scene.places import bound_parts
from vibopt.scene.scene import MINIMISE, Goal, Scene
from vibopt.scene.space import members
from vibopt.signals import Drive
from vibopt.work import within

RATED = ": rated load"
"""How the names of limits end that a part brings with it."""
_RATINGS: dict[str, Side] = {"rated_max": "at_most", "rated_min": "at_least"}


_WHOLE: ContextVar[bool] = ContextVar("whole models", default=False)


def whole_models() -> AbstractContextManager[None]:
    """What is posed inside leaves no freedom out, whatever a response needs."""
    return within(_WHOLE, True)


def are_whole() -> bool:
    """Whether whole models are asked for."""
    return _WHOLE.get()


def pose(scene: Scene, *, reduce: bool = True) -> Program:
    """The question of a scene as data.

    Parameters
    ----------
    scene
        A scene without mistakes.
    reduce
        Give every form the smallest exact model that it needs.
    """
    return asked_of(scene, model_kept(scene, (), partial(model_of, scene)), reduce=reduce)


def asked_of(scene: Scene, full: Model, *, reduce: bool = True) -> Program:
    """The question of a scene on a model of it; its axes are the design variables."""
    limits = tuple(
        limit
        for name, response in scene.limits.items()
        for each in members(scene, response)
        for limit in _limits(scene, full, name, each, reduce)
    )
    limits += tuple(ratings(full, reduce=reduce))
    aim, room = None, tuple[str, ...]()
    if scene.goal is not None and scene.goal.response.of_limits:
        room = tuple(dict.fromkeys(limit.name for limit in limits if scene.goal.response.speaks_for(limit.name)))
    elif scene.goal is not None:
        aim = _aim(scene, scene.goal, full, reduce)
    axes = tuple(Axis(v.path, v.low, v.high, v.values, v.choice.open_low) for v in scene.variables)
    return Program(full, axes, limits, aim, ties=tuple(_ties(scene)), room=room)


def _aim(scene: Scene, goal: Goal, full: Model, reduce: bool) -> Aim:
    """The goal; of a group of mounts each of them counts."""
    response = goal.response
    sense = 1.0 if goal.sense == MINIMISE else -1.0
    pieces = []
    for each in members(scene, response):
        model, form = on_needed(scene, full, each, reduce=reduce)
        pieces.append(Aim(goal.name, model, form, -sense if response.complement else sense, response.complement))
    return pieces[0] if len(pieces) == 1 else replace(pieces[0], others=tuple(pieces[1:]))


def _ties(scene: Scene) -> Iterator[Tie]:
    places = {variable.path: i for i, variable in enumerate(scene.variables)}
    for part in bound_parts(scene):
        yield Tie(part.path, tuple(places[path] for path in part.paths), part.table, part.names)


def ratings(full: Model, *, reduce: bool = True) -> Iterator[Limit]:
    """The static load of one mount of every part, between what it is rated for."""
    models: dict[str, Model] = {}
    for (name, word), rating in full.properties.items():
        side = _RATINGS.get(word)
        if side is None or name not in full.links or rating.scale == 0.0:
            continue
        part = full.properties[name, "static_stiffness"] * rating**-1.0
        factor = forms.Monomials.of(full, part)
        if name not in models:
            models[name] = reduced(full, forms.StaticRow(full.links[name])) if reduce and full.n_free > 1 else full
        needed = models[name]
        form = forms.StaticLoad(needed.links[name], factor)
        if name in full.axes:  # one own axis of a mount in space, which may be lifted
            form = forms.StaticLoad(_pressing(needed, name), factor, signed=True)
        yield Limit(rated_name(name), needed, form, side, 1.0)


def _pressing(full: Model, name: str) -> FloatArray:
    """Row that reads how far a mount is pressed along its own axis under the weights; below zero it is lifted."""
    first = full.ends[name][0]
    hangs = not any(point == first or point.startswith(f"{first}.") for point in full.points)
    up = full.axes[name][2] >= 0.0
    return full.links[name] * (1.0 if up == hangs else -1.0)


def rated_name(link: str) -> str:
    """Name of the limit that a part brings with it; the mounts of a group share it."""
    group = re.sub(r"(\.\d+)?\.z$", "", link)
    return f"{group}{RATED}"


def on_needed(scene: Scene, full: Model, response: Response, *, reduce: bool = True) -> tuple[Model, Form]:
    """The smallest exact model for a response, and its form on it."""
    return form_kept(full, response, (reduce, are_whole()), partial(_on_needed, scene, full, reduce))


def _on_needed(scene: Scene, full: Model, reduce: bool, response: Response) -> tuple[Model, Form]:
    full = response.seen_in(full)
    form = form_of(scene, full, response)
    model = full if not reduce or are_whole() or full.n_free == 1 else reduced(full, form)
    smooth = model if form.swings is None else graded(model, form.swings)
    form = form if smooth is full else form_of(scene, smooth, response)
    if form.swings is None or smooth is model:
        return smooth, form
    return smooth, form.swinging(from_rest(smooth, form.swings, _some_design(scene, smooth)))


def _some_design(scene: Scene, model: Model) -> FloatArray:
    """A design in the middle of all ranges (n_vars,); ones where the model has other variables."""
    ends = [[end for end in (v.low, v.high) if 0.0 < end < np.inf] or [1.0] for v in scene.variables]
    found = np.array([np.exp(np.mean(np.log(one))) for one in ends])
    return found if len(found) == model.n_vars else np.ones(model.n_vars)


def form_of(scene: Scene, model: Model, response: Response) -> Form:
    """The form of one response on a model; those on the last model are kept."""
    last, kept = scene.__dict__.get("forms", (None, {}))
    if last is not model:
        kept = dict[int, tuple[Response, Form]]()
        scene.__dict__["forms"] = model, kept
    known: tuple[Response, Form] | None = kept.get(id(response))
    if known is None:
        known = kept[id(response)] = response, _form_of(scene, model, response)  # it stays, and so does its number
    return known[1]


def _form_of(scene: Scene, model: Model, response: Response) -> Form:
    if isinstance(response, HarmonicResponse):
        drives = tuple(_pushed(scene, model, drive) for drive in drives_for(scene, response, model.points))
        return response.form(model, drives, combine_for(scene, response))
    if isinstance(response, RandomResponse):
        return response.noise_form(model, noises_for(scene, response, model.points))
    if isinstance(response, TransientResponse) and response.combine is not None:
        alone = (response.alone(name, scene.excitations[name].sorts) for name in names_for(scene, response))
        return forms.Added(tuple(_form_of(scene, model, one) for one in alone), response.combine == "rss", peaks=True)
    if isinstance(response, TransientResponse):
        loads, signals = signals_for(scene, response, model.points, model.n_free)
        if not isinstance(signals, tuple):
            return forms.PeakInRunUp(response.output(model), loads[:, 0], signals, spun=model.spun_in_time)
        between = durations_of(scene, response)
        if between is not None:
            lasting = partial(signals_lasting, scene, response)
            return forms.PeakOverDurations(
                response.output(model), loads, lasting, *between, beside=beside_of(scene, response)
            )
        peak = forms.PeakRubbing if model.rubbing else forms.PeakInTime
        return peak(response.output(model), loads, signals)
    drives = drives_for(scene, response.reading, model.points) if response.reading is not None else ()
    return response.form(model, drives, "sum")


def _pushed(scene: Scene, model: Model, drive: Drive) -> Drive:
    """A force acts on free coordinates alone, also where a body's row counts the base that it rides on."""
    if model.n_free == model.n_coords or scene.excitations[drive.name].family != "bodies":
        return drive
    acts = np.arange(model.n_coords) < model.n_free
    return replace(drive, lines=tuple(replace(line, vector=np.where(acts, line.vector, 0.0)) for line in drive.lines))


def _limits(scene: Scene, full: Model, name: str, response: Response, reduce: bool) -> Iterator[Limit]:
    """A limit as one of the program for every bound, and for every band."""
    soft = response.soft or 1.0
    sides: tuple[tuple[Side, Side, Any], ...] = (
        ("at_most", "at_least", response.at_most),
        ("at_least", "at_most", response.at_least),
    )
    for side, other, given in sides:
        if given is None:
            continue
        model, form = on_needed(scene, full, response.asked_by(side), reduce=reduce)
        if response.complement:
            yield Limit(name, model, form, other, 1.0 - given.value, complement=True, soft=soft)
        else:
            spared = given.value * (1.0 + (form.known_to if side == "at_least" else -form.known_to))
            yield Limit(name, model, form, side, spared, soft=soft)
    if not response.outside_bands:
        return
    model, form = on_needed(scene, full, response.asked_by("outside"), reduce=reduce)
    if form.frequency is None:  # one number says how far it is from all bands
        yield Limit(name, model, form, "at_least", 1.0, soft=soft, of_bands=True)
        return
    for band in response.outside_bands:
        yield Limit(name, model, form, "outside", band.low, band.high, soft=soft)
