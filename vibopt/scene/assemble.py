"""Scene to mechanical model: every device adds its coordinates and points, then its terms."""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.devices import Device
from vibopt.devices.symbols import Symbols
from vibopt.mechanics.builder import ModelBuilder
from vibopt.mechanics.model import INERTIA, STIFFNESS, Model, Term
from vibopt.mechanics.modes import natural_frequencies
from vibopt.mechanics.monomial import Monomial
from vibopt.scene.places import devices
from vibopt.scene.scene import Scene
from vibopt.scene.space import guides, pins, spatial_bases
from vibopt.scene.uncertain import uncertain
from vibopt.units import show

_NOTHING = 1e-7
"""A natural frequency below this part of the highest one is that of a machine that nothing holds."""


class NoReferenceError(Exception):
    """There is no one frequency that a tuning could refer to; the text says why."""


def model_of(scene: Scene, chosen: FloatArray | None = None, *, free: Container[str] = ()) -> Model:
    """The full mechanical model of a scene in its design variables, off by `scene.off`.

    With a design `chosen` (n_vars,), the model of that machine in the factors of its uncertain numbers instead.
    The factors of numbers at the paths `free` stay variables, behind the design variables.

    Raises
    ------
    NoReferenceError
        A tuning refers to a frequency that is not there, or that is to be chosen in a way that cannot be followed.
    """
    count, doubts = len(scene.variables), uncertain(scene)
    builder = ModelBuilder(count + len(doubts))
    builder.spatial, builder.guides = spatial_bases(scene), guides(scene)
    if scene.structures or scene.rotors:
        from vibopt.scene.drives import looked_at

        builder.top, builder.modes = looked_at(scene)
    builder.families = {family: tuple(getattr(scene, family)) for family in ("bodies", "absorbers")}
    for name, absorber in scene.absorbers.items():
        if absorber.has_spring:
            try:
                builder.references[name] = reference(scene, name)
            except NoReferenceError:
                if absorber.tuning is not None:
                    raise
    symbols = Symbols(
        {variable.path: i for i, variable in enumerate(scene.variables)},
        {doubt.path: count + i for i, doubt in enumerate(doubts)},
    )
    ordered = list(_ordered(scene))
    for name, table in ordered:
        table.declare(builder, name)
    for name, (body, at) in pins(scene).items():
        if name not in scene.points:
            builder.fix(name, body, at)
    for name, table in ordered:
        table.add_to(builder, name, symbols)
    model = builder.build()
    if not doubts:
        return model
    factors = np.array([scene.off.get(doubt.path, 1.0) for doubt in doubts])
    if chosen is None:
        left = [count + i for i, doubt in enumerate(doubts) if doubt.path in free]
        return model.held(np.array([*range(count), *left], dtype=int), np.concatenate([np.ones(count), factors]))
    return model.held(count + np.arange(len(doubts)), np.concatenate([chosen, factors]))


def _ordered(scene: Scene) -> Iterator[tuple[str, Device]]:
    """All devices in the order of the families, but every absorber after what it sits on and refers to."""
    left = set(scene.absorbers)
    for family, name, table in devices(scene):
        if family != "absorbers":
            yield name, table
        elif name in left:
            yield from _chain(scene, name, left)


def _chain(scene: Scene, name: str, left: set[str]) -> Iterator[tuple[str, Device]]:
    left.discard(name)
    table = scene.absorbers[name]
    for under in (table.host, table.relative_to):
        if under in left:
            yield from _chain(scene, under, left)
    yield name, table


def reference(scene: Scene, name: str) -> Monomial:
    """Frequency that the tuning of an absorber refers to [rad/s]: given, or a natural one without any absorber.

    Raises
    ------
    NoReferenceError
        The structure may be chosen too, has fewer modes, or is not held.
    """
    table = scene.absorbers[name]
    if table.tuning_to is not None:
        return Monomial(table.tuning_to.value)
    model, mode = model_of(replace(bare(scene), off={})), table.mode or 1
    many = int((~model.massless).sum())
    if table.placed and table.mode is None:
        raise NoReferenceError(
            f"without absorbers there are {many} natural frequencies. Add mode = 1, which is the lowest"
        )
    if mode > many:
        raise NoReferenceError(f"there is no mode {mode}: without absorbers there are {many}")
    asked = [term for term in model.terms if term.kind in (INERTIA, STIFFNESS)]
    if not any(term.exponents.any() for term in asked):
        found = natural_frequencies(model, model.values(np.ones(model.n_vars)))
        if not found[mode - 1] > _NOTHING * found[-1]:
            raise NoReferenceError(
                f"without absorbers natural frequency number {mode} is zero: nothing holds the machine"
            )
        return Monomial(float(found[mode - 1]))
    springs = [term for term in asked if term.kind == STIFFNESS]
    if len(springs) != 1 or len(asked) != 2 or model.n_free != 1 or model.n_coords != 1:
        raise NoReferenceError("what it would refer to is to be chosen too")
    mass = next(term for term in asked if term.kind == INERTIA)
    return (_value(springs[0]) * _value(mass) ** -1.0) ** 0.5


def _value(term: Term) -> Monomial:
    powers = {int(i): float(term.exponents[i]) for i in np.flatnonzero(term.exponents)}
    return Monomial(term.scale, powers)


def bare(scene: Scene) -> Scene:
    """The scene without absorbers, and without anything that ends at one."""

    def kept(tables: Mapping[str, Device]) -> dict[str, Any]:
        ends = {name: {end for two in table.joins(name).values() for end in two} for name, table in tables.items()}
        return {name: table for name, table in tables.items() if not ends[name] & set(scene.absorbers)}

    others = {family: kept(tables) for family, tables in scene.others.items()}
    return replace(scene, absorbers={}, links=kept(scene.links), others=others)


_COUNTED = ("first", "second", "third", "fourth", "fifth")


def tuning_notes(scene: Scene) -> list[str]:
    """What each tuning refers to."""
    return [_note(scene, name) for name, absorber in scene.absorbers.items() if absorber.tuning is not None]


def _note(scene: Scene, name: str) -> str:
    table = scene.absorbers[name]
    said = f"absorbers.{name}: tuning refers to"
    if table.tuning_to is not None:
        return f"{said} {show(table.tuning_to.value, table.tuning_to.unit, 'angular_rate')}"
    mode = table.mode or 1
    which = _COUNTED[mode - 1] if mode <= len(_COUNTED) else f"{mode}th"
    found = reference(scene, name)
    if found.exponents:
        return f"{said} the natural frequency without absorbers, which is chosen too"
    return f"{said} the {which} natural frequency without absorbers, {show(found.scale, 'Hz', 'angular_rate')}"
