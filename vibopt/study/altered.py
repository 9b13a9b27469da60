"""A scene's document with an absorber lost, locked or without its damper."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from typing import Any

from vibopt.mechanics.machine import Machine
from vibopt.scene.places import turning
from vibopt.scene.scene import Scene

_DAMPERS = ("damping", "torsional_damping", "damping_ratio", "loss_factor")
_HEAVY = ("mass", "weight", "inertia", "disc")
_PLACES = ("into", "through", "of", "across")
_STIFF, _STIFF_IN_SPACE = 1e8, 1e6
"""Stiffness of a lock on a structure and in space: so many times what its inertia needs at the highest speed."""

Document = dict[str, Any]


def plain_document(document: Mapping[str, Any]) -> Document:
    """A copy in which every number is what it is said to be, without tolerances."""
    bare: Document = _without_tolerance(copy.deepcopy(dict(document)))
    return bare


def _without_tolerance(value: Any) -> Any:
    if isinstance(value, dict):
        if "value" in value:
            return value["value"]
        return {key: _without_tolerance(one) for key, one in value.items() if key != "tolerance"}
    return value


def undamped(document: Document, name: str) -> Document:
    """Without the damper of an absorber."""
    new = copy.deepcopy(document)
    for key in _DAMPERS:
        new["absorbers"][name].pop(key, None)
    return new


def lost(document: Document, name: str) -> Document:
    """Without an absorber, what hangs on it, and what is asked of either."""
    new = copy.deepcopy(document)
    gone = {name}
    for _ in new["absorbers"]:
        gone |= {key for key, one in new["absorbers"].items() if one.get("on") in gone}
    new["absorbers"] = {key: one for key, one in new["absorbers"].items() if key not in gone}
    links = {key: one for key, one in new.get("links", {}).items() if set(one.get("between", ())) & gone}
    new["links"] = {key: one for key, one in new.get("links", {}).items() if key not in links}
    driven = {key for key, one in new.get("excitations", {}).items() if one.get("on") in gone}
    new["excitations"] = {key: one for key, one in new.get("excitations", {}).items() if key not in driven}
    for table in new["absorbers"].values():
        if table.get("relative_to") in gone:
            table.pop("relative_to")
    return _unasked(new, gone | set(links), driven)


def locked(document: Document, scene: Scene, machine: Machine, name: str, top: float) -> Document:
    """An absorber as a rigid part of what it sits on; `top` is the highest frequency that matters [rad/s]."""
    new = copy.deepcopy(document)
    host, mass = machine.joint(name).ends[0], machine.masses[name]
    around = name in turning(scene)
    in_space = scene.absorbers[name].placed
    if host not in machine.masses or in_space:
        return _stiffly(new, name, mass * top**2 * (_STIFF_IN_SPACE if in_space else _STIFF), around)
    _fixed_dampers(new, scene, machine)
    _heavier(new, host, machine, mass, around)
    del new["absorbers"][name]
    for table in new["absorbers"].values():
        table["on"] = host if table.get("on") == name else table.get("on")
        if table.get("relative_to") == name:
            table["relative_to"] = host
    for key, table in list(new.get("links", {}).items()):
        table["between"] = [host if end == name else end for end in table["between"]]
        if table["between"][0] == table["between"][1]:
            del new["links"][key]
    for table in new.get("excitations", {}).values():
        table["on"] = host if table["on"] == name else table["on"]
    return _unasked(new, {name}, set())


def _stiffly(new: Document, name: str, stiffness: float, around: bool) -> Document:
    kept = ("on", "at", "direction", "mass", "inertia")
    table = {key: one for key, one in new["absorbers"][name].items() if key in kept}
    table |= {"torsional_stiffness": f"{stiffness:.17g} N m/rad"} if around else {"stiffness": f"{stiffness:.17g} N/m"}
    new["absorbers"][name] = table
    return _unasked(new, {name}, set())


def _heavier(new: Document, host: str, machine: Machine, mass: float, around: bool) -> None:
    """The mass on top of the host's own, whatever rolls with it."""
    table = new["absorbers"][host] if host in new["absorbers"] else new["bodies"][host]
    own = machine.weights[host] if "rolling" in table else machine.masses[host]
    for key in _HEAVY:
        table.pop(key, None)
    table["inertia" if around else "mass"] = f"{own + mass:.17g} {'kg m2' if around else 'kg'}"


def _fixed_dampers(new: Document, scene: Scene, machine: Machine) -> None:
    """Dampers that were said by a ratio, in numbers: what is built does not change with another mass."""
    for name, table in new.get("links", {}).items():
        if "damping_ratio" in table:
            joint = machine.joint(name)
            around = joint.ends[0] in turning(scene) or joint.ends[1] in turning(scene)
            key, unit = ("torsional_damping", "N m s/rad") if around else ("damping", "N s/m")
            del table["damping_ratio"]
            table.pop("relative_to", None)
            table[key] = f"{joint.damping / joint.count:.17g} {unit}"


def _unasked(new: Document, gone: set[str], driven: set[str]) -> Document:
    """Nothing is asked of what is gone, and nothing is due to what shook it."""
    for family in ("limits", "measures"):
        if family in new:
            new[family] = {key: one for key, one in new[family].items() if _still(one, gone, driven)}
    goal = new.get("goal")
    left = new.get("absorbers")
    if isinstance(goal, dict) and (not _still(goal, gone, driven) or (not left and "absorber_mass" in goal.values())):
        del new["goal"]
    if not left:
        new.pop("absorbers", None)
    return new


def _still(table: Mapping[str, Any], gone: set[str], driven: set[str]) -> bool:
    """Whether a question can still be asked; excitations that are gone are taken out of it."""
    if any(table.get(key) in gone for key in _PLACES):
        return False
    due = table.get("due_to")
    if due is not None and isinstance(table, dict) and driven:
        table["due_to"] = [one for one in due if one not in driven]
        return bool(table["due_to"])
    return True
