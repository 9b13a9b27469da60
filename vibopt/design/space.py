"""The machine in space as it would be built, in numbers from the tables' own words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from vibopt.devices import BodyTable, MountTable
from vibopt.devices.axes import DampingAxes, StiffnessAxes
from vibopt.devices.offset import offset_of
from vibopt.forms import FloatArray
from vibopt.mechanics.constants import GRAVITY
from vibopt.mechanics.machine import Machine
from vibopt.mechanics.rigid import Rigid, SpaceMachine, Spring3
from vibopt.scene.scene import Scene
from vibopt.scene.space import bodies_in_space, pins, spatial_bases
from vibopt.values.fields import Choice, Fact

_LETTERS = "xyz"


def line_part(scene: Scene) -> Scene:
    """What of a scene moves on one line: without bodies in space, and without what differs on them."""
    space = bodies_in_space(scene)
    bodies = {name: body for name, body in scene.bodies.items() if name not in space}
    gone = tuple(f"bodies.{name}." for name in space) + tuple(f"mounts.{name}." for name in scene.mounts)
    off = {path: factor for path, factor in scene.off.items() if not path.startswith(gone)}
    return replace(scene, bodies=bodies, mounts={}, points={}, excitations={}, off=off)


def in_space(scene: Scene, chosen: Mapping[str, float], core: Machine) -> SpaceMachine:
    """Bodies in space and mounts around the machine on the line, `core`."""
    rigid = {name: _rigid(scene, chosen, name, scene.bodies[name]) for name in bodies_in_space(scene)}
    masses = dict(core.masses)
    for name, body in rigid.items():
        for index, (_, _, resists) in enumerate(body.moves):
            masses[f"{name}.{index + 1}"] = resists
    mounts, groups = [], {}
    for name, table in scene.mounts.items():
        mounts += _springs(scene, chosen, name, table)
        groups[name] = table.singles(name)
    weights = {**core.weights, **{name: body.mass for name, body in rigid.items()}}
    fixed = {key: (body, np.array(at)) for key, (body, at) in pins(scene).items()}
    return SpaceMachine(
        masses,
        core.joints,
        core.bases,
        weights,
        core.tuned,
        rigid=rigid,
        line=tuple(core.masses),
        mounts=tuple(mounts),
        groups=groups,
        fixed=fixed,
        spatial=spatial_bases(scene),
    )


def _number(scene: Scene, chosen: Mapping[str, float], path: str, value: Fact | Choice) -> float:
    nominal = value.value if isinstance(value, Fact) else chosen[path]
    return nominal * scene.off.get(path, 1.0)


def _rigid(scene: Scene, chosen: Mapping[str, float], name: str, body: BodyTable) -> Rigid:
    key = next(iter(body.parts()))
    if body.made_of is not None:
        own = body.solid(1.0)
        factor = scene.off.get(f"bodies.{name}.made_of", 1.0)
        return Rigid(own.mass * factor, _centre(scene, name, body), own.tensor * factor, body.freedoms, own.centre)
    value = getattr(body, key)
    mass = _number(scene, chosen, f"bodies.{name}.{key}", value) / (GRAVITY if key == "weight" else 1.0)
    tensor = body.solid(mass).tensor * scene.off.get(f"bodies.{name}.inertia", 1.0)
    return Rigid(mass, _centre(scene, name, body), tensor, body.freedoms, np.array(body.place))


def _centre(scene: Scene, name: str, body: BodyTable) -> FloatArray:
    """Centre of mass as built (3,) [m]."""
    factors = {axis: scene.off.get(f"bodies.{name}.centre.{axis}", 1.0) for axis in _LETTERS}
    return np.array(body.place) + [offset_of(factors[axis], body.reaches.get(axis, 0.0)) for axis in _LETTERS]


def _springs(scene: Scene, chosen: Mapping[str, float], name: str, table: MountTable) -> list[Spring3]:
    def three(key: str) -> FloatArray:
        given, path = getattr(table, key), f"mounts.{name}.{key}"
        if given is None:
            return np.zeros(3)
        if isinstance(given, (StiffnessAxes, DampingAxes)):
            each = [_number(scene, chosen, f"{path}.{one}", getattr(given, one)) for one in _LETTERS]
            return np.array(each) * scene.off.get(path, 1.0)
        assert table.shear_ratio is not None
        side = _number(scene, chosen, f"mounts.{name}.shear_ratio", table.shear_ratio)
        return _number(scene, chosen, path, given) * np.array([side, side, 1.0])

    stiffness, damping = three("stiffness"), three("damping")
    inner = f"mounts.{name}.part" if table.part is not None else f"mounts.{name}"
    ratio = table.static_ratio
    static = stiffness / (_number(scene, chosen, f"{inner}.dynamic_to_static", ratio) if ratio is not None else 1.0)
    bought = table.part.price if table.part is not None else None
    price = _number(scene, chosen, f"{inner}.price", bought) if bought is not None else 0.0
    lossy = 0.0
    if table.loss_factor is not None:
        lossy = _number(scene, chosen, f"mounts.{name}.loss_factor", table.loss_factor)
    whole = [
        Spring3(single, table.between, np.array(at), frame, stiffness, static, damping, lossy, price)
        for single, at, frame in zip(table.singles(name), table.sites, table.frames, strict=True)
    ]
    return whole if len(whole) == 1 else [_scattered(scene, one) for one in whole]


def _scattered(scene: Scene, mount: Spring3) -> Spring3:
    """One mount of a group with its own numbers off by themselves."""

    def off(key: str) -> float:
        return scene.off.get(f"mounts.{mount.name}.{key}", 1.0)

    side = off("shear_ratio")
    stiff, dash = (
        off(key) * np.array([side * off(f"{key}.x"), side * off(f"{key}.y"), off(f"{key}.z")])
        for key in ("stiffness", "damping")
    )
    return replace(
        mount,
        stiffness=mount.stiffness * stiff,
        static_stiffness=mount.static_stiffness * stiff,
        damping=mount.damping * dash,
        loss_factor=mount.loss_factor * off("loss_factor"),
    )


__all__ = ["in_space", "line_part"]
