"""One machine in other scenarios: what is said relative to another number is one part, whatever changes beside it.

A tuning, a mass ratio or a damping ratio refers to the machine as the file is.  In a scenario with a heavier deck the
absorber on it is no other one: the deck is off from what the file says, as it may be within a tolerance.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from vibopt.document.toml_reading import inside
from vibopt.errors import InputError
from vibopt.mechanics.built import Joint
from vibopt.report.machine_words import listed
from vibopt.scene.places import devices
from vibopt.scene.read import with_changes
from vibopt.scene.scene import Scene
from vibopt.values.fields import Fact, numbers_in
from vibopt.verify.as_built import machine_of

_RELATIVE = {"mass_ratio": "mass", "tuning": "frequency", "damping_ratio": "damping"}
"""What is said relative to another number, and what says the same of the part alone."""
_OFF = "1 %"
"""Marks a number that may be off; how far does not matter."""


def same_parts(scene: Scene, name: str, changes: Mapping[str, Any], changed: Scene) -> Scene:
    """The scene under the changes of a scenario, with the parts of `scene`.

    Parameters
    ----------
    scene
        As the file is.
    name, changes
        Of the scenario, these by path.
    changed
        The scene with the changes read as a file of its own, where a ratio refers to what is changed.

    Raises
    ------
    InputError
        A change of another kind, as of a length, changes what an absorber or a damper refers to.
    """
    marks, off = dict[str, Any](), dict[str, float]()
    after = _facts(changed)
    for path, (value, scattered) in _facts(scene).items():
        if path in changes and path in after and value > 0.0 and after[path][0] > 0.0:
            mark = {"value": inside(scene.document, path), "tolerance": _OFF}
            try:
                with_changes(scene, {path: mark})
            except InputError:  # of a length or a count, which are never off
                continue
            marks[path] = mark
            off |= dict.fromkeys(scattered, after[path][0] / value)
    rest = {path: value for path, value in changes.items() if path not in marks}
    made = replace(with_changes(scene, {**rest, **marks}), off=off) if marks else changed
    _check(scene, made, name, rest)
    return made


def _facts(scene: Scene) -> dict[str, tuple[float, tuple[str, ...]]]:
    """Every given number of a device [SI], by path, and the paths of what is off with it."""
    return {
        path: (one.value, table.scattered(name, path))
        for family, name, table in devices(scene)
        for path, one, _ in numbers_in(f"{family}.{name}", table)
        if isinstance(one, Fact)
    }


def _check(scene: Scene, made: Scene, name: str, rest: Mapping[str, Any]) -> None:
    """Whether every part that is said relative to something is the same one."""
    chosen = {variable.path: _middle(variable.low, variable.high) for variable in scene.variables}
    touched = {tuple(path.split(".")[:2]) for path in rest}
    for family, one, table in devices(scene):
        said = [key for key in _RELATIVE if getattr(table, key, None) is not None]
        if not said or (family, one) in touched:
            continue
        if _part(scene, family, one, chosen) != _part(made, family, one, chosen):
            raise InputError(
                f"{scene.name}: scenario {name} changes {', '.join(rest)}, which {listed(said)} of "
                f"{family}.{one} refer to: it would be another part in each scenario. Write its "
                f"{listed([_RELATIVE[key] for key in said])}."
            )


def _part(scene: Scene, family: str, name: str, chosen: Mapping[str, float]) -> tuple[float, ...]:
    """Mass, stiffness, damping and inertance of a part as said, to digits that rounding leaves alone."""
    machine = machine_of(replace(scene, off={}), chosen)
    try:
        joint: Joint = machine.joint(name)
    except (KeyError, StopIteration):
        return ()
    mass = machine.masses.get(name, 0.0) if family == "absorbers" else 0.0
    found = (mass, joint.stiffness, joint.damping, joint.inertance)
    return tuple(float(f"{one:.9g}") for one in found)


def _middle(low: float, high: float) -> float:
    """A value between the ends of a range."""
    return (max(low, high * 1e-6) * high) ** 0.5 if low >= 0.0 and high < float("inf") else max(low, 1.0)
