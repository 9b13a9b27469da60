"""Rows of an answer: every limit and measure on the machine as built, with texts in the user's units."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from vibopt.design.build import machine_of
from vibopt.design.certify import TOLERANCE, measure, measure_on
from vibopt.design.design import Checked, Chosen, Shown
from vibopt.design.words import place_of
from vibopt.mechanics.machine import Machine
from vibopt.responses import Response
from vibopt.scene.scene import Scene, Variable
from vibopt.units import si_unit
from vibopt.values import SpeedRange


def shown_value(response: Response, value: float, unit: str) -> Shown:
    """A response's value in the user's unit."""
    return Shown.of(value, response.dimension, si_unit(response.dimension), unit, amplitude=response.amplitude)


def checked_limits(scene: Scene, chosen: Mapping[str, float]) -> dict[str, Checked]:
    """Every limit on the built machine; a limit with two bounds has two rows."""
    rows: dict[str, Checked] = {}
    machine = machine_of(scene, chosen)
    for name, response in scene.limits.items():
        sides = [side for side in ("at_most", "at_least", "outside") if getattr(response, side, None) is not None]
        for side in sides:
            key = name if side == sides[0] else f"{name} ({side})"
            rows[key] = _checked(scene, machine, name, response, side)
    return rows


def checked_measures(scene: Scene, chosen: Mapping[str, float]) -> dict[str, Checked]:
    """Every measure on the built machine."""
    machine = machine_of(scene, chosen)
    return {name: _checked(scene, machine, name, one, "") for name, one in scene.measures.items()}


def _checked(scene: Scene, machine: Machine, name: str, response: Response, side: str) -> Checked:
    found = measure_on(scene, machine, response, side or _natural_side(response))
    given = getattr(response, side, None) if side else None
    unit = response.unit or getattr(given, "unit", "") or usual_unit(scene, response)
    margin = 0.0
    limit = None
    if side == "outside":
        assert isinstance(given, SpeedRange)
        band = min(given.bands, key=lambda one: -min(found.value - one.low, one.high - found.value))
        depth = min(found.value - band.low, band.high - found.value)
        edge = band.low if found.value - band.low <= band.high - found.value else band.high
        margin = -depth / edge if edge else -depth
        limit = shown_value(response, edge, unit)
    elif given is not None:
        size = abs(1.0 - given.value if response.complement else given.value) or 1.0
        margin = (given.value - found.value) / size if side == "at_most" else (found.value - given.value) / size
        limit = shown_value(response, given.value, unit)
    return Checked(
        name=name,
        response=response.response,
        place=place_of(response),
        side=side,
        value=shown_value(response, found.value, unit),
        limit=limit,
        margin=float(margin) if np.isfinite(margin) else float("-inf") if margin < 0 else float("inf"),
        active=bool(side) and abs(margin) <= 1e-6,
        met=not side or margin >= -TOLERANCE,
        worst_at={key: _speed(scene, key, speed) for key, speed in found.speeds.items()},
    )


def _natural_side(response: Response) -> str:
    """The side that a measure without a bound shows: the worst."""
    return "at_least" if response.complement or response.response == "insertion_loss" else "at_most"


def _speed(scene: Scene, name: str, omega: float) -> Shown:
    excitation = scene.excitations[name]
    dimension = excitation.speed.dimension
    return Shown.of(excitation.from_rotation(omega), dimension, si_unit(dimension), excitation.speed.unit)


def goal_of(scene: Scene, chosen: Mapping[str, float]) -> tuple[str, Shown] | None:
    """The goal's name and its value on the built machine."""
    if scene.goal is None:
        return None
    response = scene.goal.response
    side = "at_most" if scene.goal.sense == "minimise" else "at_least"
    value = measure(scene, chosen, response, side).value
    return scene.goal.name, shown_value(response, value, response.unit or usual_unit(scene, response))


def chosen_of(variable: Variable, value: float) -> Chosen:
    """A chosen value with its text, and the end of its range on which it rests."""
    at = ""
    if variable.values is None:
        if value <= variable.low * (1 + 1e-9):
            at = "from"
        elif value >= variable.high * (1 - 1e-9):
            at = "to"
    return Chosen(Shown.of(value, variable.dimension, si_unit(variable.dimension), variable.unit), at)


def usual_unit(scene: Scene, response: Response) -> str:
    """The unit in which the file speaks of the same quantity, else that of its kind or "" (chosen by size)."""
    path = f".{getattr(response, 'of', None)}.{response.response}"
    for variable in scene.variables:
        if variable.path.endswith(path):
            return variable.unit
    for limit in scene.limits.values():
        if limit.response == response.response:
            for given in (limit.at_most, limit.at_least, getattr(limit, "outside", None)):
                if given is not None:
                    return str(given.unit)
    return {"natural_frequency": "Hz", "own_frequency": "Hz", "insertion_loss": "dB"}.get(response.response, "")
