"""Answers without a solver: a scene measured at values given by hand."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from vibopt.design.certify import measure
from vibopt.design.design import Checked, Chosen, Design, Shown, Used
from vibopt.design.words import place_of
from vibopt.responses import Response
from vibopt.scene.read import read
from vibopt.scene.scene import Scene
from vibopt.units import si_unit

PROBLEMS = Path(__file__).parents[2] / "problems" / "isolation"


def scene_of(name: str) -> Scene:
    """A problem of the isolation folder."""
    return read(PROBLEMS / f"{name}.toml")


def design_of(scene: Scene | str, *x: float, **changes: Any) -> Design:
    """The scene (or the problem of this name) at the values `x` [SI]; status from its limits."""
    scene = scene_of(scene) if isinstance(scene, str) else scene
    chosen = {variable.path: value for variable, value in zip(scene.variables, x, strict=True)}
    limits = {name: checked(scene, chosen, name, one) for name, one in scene.limits.items()}
    good = all(one.met for one in limits.values())
    design = Design(
        scene=scene,
        status=("optimal" if scene.variables else "met") if good else "violated",
        claim="set by hand",
        goal=_goal(scene, chosen),
        variables={v.path: Chosen(Shown.of(chosen[v.path], v.dimension, si_unit(v.dimension), v.unit)) for v in scene.variables},
        x=x,
        limits=limits,
        measures={name: checked(scene, chosen, name, one) for name, one in scene.measures.items()},
        model=Used(len(scene.bodies), len(scene.bodies), ""),
        method="by hand",
        timings={"solve": 0.0012},
    )
    return replace(design, **changes)


def checked(scene: Scene, chosen: Mapping[str, float], name: str, response: Response) -> Checked:
    """One response measured on the built machine."""
    side = next((key for key in ("at_most", "at_least") if getattr(response, key) is not None), "")
    bound = getattr(response, side) if side else None
    found = measure(scene, chosen, response, side or "at_most")
    unit = response.unit or (bound.unit if bound is not None else "")
    margin = 0.0
    if bound is not None:
        margin = (bound.value - found.value) / bound.value * (1.0 if side == "at_most" else -1.0)
    return Checked(
        name=name,
        response=response.response,
        place=place_of(response),
        side=side,
        value=_shown(found.value, response, unit),
        limit=_shown(bound.value, response, unit) if bound is not None else None,
        margin=margin,
        active=bound is not None and abs(margin) < 1e-6,
        met=margin >= -1e-8,
        worst_at={one: _speed(scene, one, speed) for one, speed in found.speeds.items()},
    )


def _shown(value: float, response: Response, unit: str) -> Shown:
    return Shown.of(value, response.dimension, si_unit(response.dimension), unit, amplitude=response.amplitude)


def _speed(scene: Scene, name: str, omega: float) -> Shown:
    excitation = scene.excitations[name]
    dimension = excitation.speed.dimension
    return Shown.of(excitation.from_rotation(omega), dimension, si_unit(dimension), excitation.speed.unit)


def _goal(scene: Scene, chosen: Mapping[str, float]) -> tuple[str, Shown] | None:
    if scene.goal is None:
        return None
    response = scene.goal.response
    return scene.goal.name, _shown(measure(scene, chosen, response).value, response, "")


PRESS = (6956917.2, 9908.6017)
"""Stiffness [N/m] and damping [N s/m] of the best mount of rao_9_34."""
