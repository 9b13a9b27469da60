"""Many one-mass machines as built, straight from the scene, with the speeds and amplitudes of what shakes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from vibopt.forms import FloatArray
from vibopt.mechanics.constants import GRAVITY
from vibopt.mechanics.lone import LoneMachine
from vibopt.mechanics.machine import Joint
from vibopt.responses import HarmonicResponse, Response
from vibopt.scene.drives import bands_for, names_for
from vibopt.scene.scene import Scene
from vibopt.study.many.lower import RefusedError
from vibopt.values.fields import Choice, Fact

_NUMBERS = {
    "stiffness": 0.0,
    "damping": 0.0,
    "damping_ratio": 0.0,
    "loss_factor": 0.0,
    "count": 1.0,
    "dynamic_to_static": 1.0,
}
"""Of a link, with what holds where the file says nothing."""


def is_plain(scene: Scene) -> bool:
    """Whether the scene is one body that moves along a line, on links that give stiffness and damping outright."""
    springs = ("torsional_stiffness", "torsional_damping", "shaft", "beam")
    return (
        len(scene.bodies) == 1
        and not scene.absorbers
        and not scene.structures
        and not scene.mounts
        and all(not one.freedoms for one in scene.bodies.values())
        and all(one.mass is not None or one.weight is not None for one in scene.bodies.values())
        and all(one.rolling is None for one in scene.bodies.values())
        and all(getattr(link, key) is None for link in scene.links.values() for key in springs)
    )


def machines(scene: Scene, known: Mapping[str, FloatArray]) -> LoneMachine:
    """The machines of a scene as one, whose numbers are arrays, shape () or (count,).

    Values at the paths in `known` (variables, the varied fact) are given [SI].

    Raises
    ------
    RefusedError
        There is more than one body.
    """
    if not is_plain(scene):
        raise RefusedError

    def number(path: str, value: Fact | Choice | None, default: float = 0.0) -> Any:
        if path in known:
            return known[path]
        if isinstance(value, Choice):
            raise RefusedError
        return np.array(default if value is None else value.value)

    body = next(iter(scene.bodies))
    mass = number(f"bodies.{body}.mass", scene.bodies[body].quantity[1])
    if f"bodies.{body}.weight" in known:
        mass = known[f"bodies.{body}.weight"] / GRAVITY
    joints = []
    for name, table in scene.links.items():
        if table.part is not None:  # its rating is a limit that no table of limits names
            raise RefusedError
        stiffness, damping, ratio, loss, count, softer = (
            number(f"links.{name}.{key}", getattr(table, key), default) for key, default in _NUMBERS.items()
        )
        stiffness, viscous = count * stiffness, count * damping
        critical = 2.0 * np.sqrt(stiffness * mass)
        joints.append(
            Joint(
                name=name,
                ends=table.between,
                stiffness=stiffness,
                damping=np.where(viscous > 0.0, viscous, ratio * critical),
                loss_factor=loss,
                static_stiffness=stiffness / softer,
                count=count,
                damping_ratio=np.where(ratio > 0.0, ratio, viscous / np.where(critical > 0.0, critical, np.inf)),
            )
        )
    return LoneMachine({body: mass}, tuple(joints), tuple(scene.bases), {body: mass})


def shaking(scene: Scene) -> dict[str, float]:
    """Bounds, amplitudes and speeds of all limits as numbers, and their structure in the names.

    Raises
    ------
    RefusedError
        A response has several harmonics, or an amplitude in pieces.
    """
    found: dict[str, float] = {}
    for name, response in scene.limits.items():
        found |= _bounds(name, response)
        if isinstance(response, HarmonicResponse):
            found |= _line(scene, name, response)
    return found


def _bounds(name: str, response: Response) -> dict[str, float]:
    if getattr(response, "outside", None) is not None:
        raise RefusedError
    given = {side: getattr(response, side) for side in ("at_most", "at_least")}
    return {f"{name}.{side}": float(one.value) for side, one in given.items() if one is not None}


def _line(scene: Scene, name: str, response: HarmonicResponse) -> dict[str, float]:
    drives = names_for(scene, response)
    lines = scene.excitations[drives[0]].lines(np.ones(1)) if len(drives) == 1 else ()
    if len(lines) != 1 or len(lines[0].amplitude.pieces) != 1 or lines[0].amplitude.pieces[0].slope:
        raise RefusedError
    piece, order = lines[0].amplitude.pieces[0], lines[0].order
    power = 0 if response.normalised else piece.power
    size = 1.0 if response.normalised else abs(piece.constant) / order**power
    found = {f"{name}.amplitude.{power}": size * float(abs(lines[0].vector[0]))}
    for b, band in enumerate(bands_for(scene, response, drives[0])):
        if not np.isfinite(band.high) or (band.low == 0.0 and power < 0):
            raise RefusedError
        found |= {
            f"{name}.low{b}{'.point' if band.is_point else ''}": order * band.low,
            f"{name}.high{b}": order * band.high,
        }
    return found
