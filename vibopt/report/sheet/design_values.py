"""What to build or to buy: parts by name and number, or stiffness and damping with all digits that were verified."""

from __future__ import annotations

from math import isfinite

from vibopt.answer.entry import Entry
from vibopt.devices.link import LinkTable
from vibopt.devices.mount import MountTable
from vibopt.devices.part import Part
from vibopt.mechanics.machine import Joint, Machine
from vibopt.mechanics.rigid import SpaceMachine, Spring3
from vibopt.report.absorber_parts import parts_of
from vibopt.scene.open_places import asked_positions
from vibopt.scene.scene import Design, Scene
from vibopt.units import plain, show, to_unit
from vibopt.units.spelling import split_detector

DIGITS, MOST_DIGITS = 4, 7
ROUNDING = 1e-7
"""Part of a value by which what is shown may differ from what was verified."""
_DEVICES = ("mounts", "links", "absorbers")
_WORDS = ("stiffness", "damping", "loss_factor", "dynamic_to_static", "part", "count", "shear_ratio", "damping_ratio")


def verified(value: float, unit: str, dimension: str) -> str:
    """A chosen value with as many digits as it takes to be the one that was verified, at least 4 and at most 7."""
    for digits in range(DIGITS, MOST_DIGITS):
        text = show(value, unit, dimension, digits=digits)
        bare = split_detector(text.partition(" ")[2])[0] if " " in text else ""
        whole = to_unit(value, bare, dimension)
        if not isfinite(whole) or abs(float(text.partition(" ")[0]) - whole) <= ROUNDING * abs(whole):
            return text
    return show(value, unit, dimension, digits=MOST_DIGITS)


def build_rows(design: Design, machine: Machine) -> list[tuple[str, str]]:
    """What to order or to build, group by group; then every other number that was chosen."""
    scene, rows = design.scene, []
    for name, mount in scene.mounts.items():
        assert isinstance(machine, SpaceMachine)
        own = machine.mount(machine.groups[name][0])
        rows.append((name, _joined(_order(design, f"mounts.{name}", mount.part, mount.count), _mount(mount, own))))
    for name, link in scene.links.items():
        joint = machine.joint(name)
        rows.append((name, _joined(_order(design, f"links.{name}", link.part, joint.count), _link(link, joint, name))))
    for part in parts_of(design):
        words = [f"{key.replace('_', ' ')} {_again(one)}" for key, one in part.numbers.items()]
        rows.append((part.name, f"on {part.on}: {', '.join(words)}"))
    return rows + _others(design)


def _joined(first: str, then: list[str]) -> str:
    return ": ".join(filter(None, (first, ", ".join(then))))


def _again(one: Entry) -> str:
    """The same value with all its digits, in the unit in which it was shown."""
    unit = one.shown.partition(" ")[2]
    exact = one.dimension in ("mass", "stiffness", "damping")
    return verified(one.value, unit, one.dimension) if exact else one.shown


def _order(design: Design, path: str, part: Part | None, count: float) -> str:
    """What to order: "4 x S60-60, 26.95 EUR each, 107.8 EUR"; of what is not bought the number of mounts."""
    if part is None:
        return f"{plain(count)} alike" if count > 1 else ""
    placed = design.places.get(f"{path}.part")
    words = f"{plain(count)} x {placed.value if placed is not None else part.name}"
    price = part.price
    if price is None:
        return words
    chosen = design.variables.get(f"{path}.part.price")
    one = chosen.value.value if chosen is not None else getattr(price, "value", 0.0)
    unit = price.unit
    return f"{words} ({_money(one, unit)} each, {_money(count * one, unit)})"


def _money(value: float, unit: str) -> str:
    return show(value, unit, "price", digits=8)


def _mount(table: MountTable, own: Spring3) -> list[str]:
    """Stiffness along its own axes, damping, what is static of it; of one mount."""
    unit = _unit(table, "stiffness")
    x, y, z = (verified(float(one), unit, "stiffness") for one in own.stiffness)
    words = [f"stiffness {z} along its axis", f"{x} across" if x == y else f"{x} across along x, {y} along y"]
    if own.damping.any():
        dx, dy, dz = (verified(float(one), _unit(table, "damping"), "damping") for one in own.damping)
        words.append(f"damping {dz} along, {dx if dx == dy else f'{dx}, {dy}'} across")
    if own.loss_factor:
        words.append(f"loss factor {verified(own.loss_factor, '', 'ratio')}")
    if own.static_stiffness[2] != own.stiffness[2]:
        words.append(f"static stiffness {show(float(own.static_stiffness[2]), unit, 'stiffness')}")
    axes = {tuple(round(float(one), 3) for one in frame[2]) for frame in table.frames}
    if axes != {(0.0, 0.0, 1.0)}:
        said = " and ".join(f"({', '.join(plain(part + 0.0, 3) for part in one)})" for one in sorted(axes))
        words.append(f"inclined, axis {said}")
    return words


def _link(table: LinkTable, joint: Joint, name: str) -> list[str]:
    """Stiffness and damping of one mount of a link."""
    around = table.torsional_stiffness is not None or table.shaft is not None or table.torsional_damping is not None
    words, turn = [], "torsional_" if around else ""
    for key, value in (("stiffness", joint.stiffness), ("damping", joint.damping)):
        if value > 0.0:
            unit = _unit(table, f"{turn}{key}")
            words.append(f"{key} {verified(value / joint.count, unit, f'{turn}{key}')}")
    if joint.loss_factor:
        words.append(f"loss factor {verified(joint.loss_factor, '', 'ratio')}")
    each = " of one" if joint.count > 1 and words else ""
    ends = f"between {table.between[0]} and {table.between[1]}"
    return [*words[:-1], f"{words[-1]}{each}", ends] if words else [ends]


def _unit(table: object, key: str) -> str:
    given = getattr(table, key, None)
    given = getattr(given, "z", given)
    return str(getattr(given, "unit", "") or "")


def _others(design: Design) -> list[tuple[str, str]]:
    """Chosen numbers and places that no row has said yet."""
    rows = [(_owner(path), one.value) for path, one in design.places.items() if not path.endswith(".part")]
    units = asked_positions(design.scene) | {variable.path: variable for variable in design.scene.variables}
    for path, chosen in design.variables.items():
        if path in units and not _told(design.scene, path):
            one = units[path]
            rows.append((_owner(path), verified(chosen.value.value, one.unit, one.dimension)))
    return rows


def _owner(path: str) -> str:
    """A path without its family: "block mass"."""
    return path.partition(".")[2].replace(".", " ").replace("_", " ")


def _told(scene: Scene, path: str) -> bool:
    """Whether the row of a device has this number."""
    family, _, rest = path.partition(".")
    steps = rest.split(".")[1:]
    if family == "absorbers":
        return True
    return family in _DEVICES and bool(steps) and steps[0].removeprefix("torsional_") in _WORDS


__all__ = ["build_rows", "verified"]
