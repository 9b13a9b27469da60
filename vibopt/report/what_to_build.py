"""What to build or to buy: parts by name and number, or stiffness and damping with all digits that were verified."""

from __future__ import annotations

from collections.abc import Callable
from math import isfinite
from typing import TYPE_CHECKING

from vibopt.answer.entry import Entry
from vibopt.mechanics.built import Joint
from vibopt.mechanics.machine import Machine, is_in_space
from vibopt.report.absorber_parts import parts_of
from vibopt.scene.open_places import asked_positions, open_places
from vibopt.scene.scene import Design, Scene
from vibopt.units import plain, show, to_unit
from vibopt.units.spelling import split_detector
from vibopt.values.fields import rule_of
from vibopt.verify.as_built import machine_of

if TYPE_CHECKING:
    from vibopt.devices.link import LinkTable
    from vibopt.devices.mount import MountTable
    from vibopt.devices.part import Part
    from vibopt.mechanics.rigid_parts import Spring3

DIGITS, MOST_DIGITS = 4, 7
ROUNDING = 1e-7
"""Part of a value by which what is shown may differ from what was verified."""
Shown = Callable[[float, str, str], str]
"""A value [SI], its unit and its dimension as text."""
_DEVICES = ("mounts", "links", "absorbers")
_WORDS = (
    "stiffness",
    "damping",
    "loss_factor",
    "friction_force",
    "dynamic_to_static",
    "part",
    "count",
    "shear_ratio",
    "damping_ratio",
    "beam",
    "shaft",
)


def verified(value: float, unit: str, dimension: str) -> str:
    """A chosen value with as many digits as it takes to be the one that was verified, at least 4 and at most 7."""
    for digits in range(DIGITS, MOST_DIGITS):
        text = show(value, unit, dimension, digits=digits)
        bare = split_detector(text.partition(" ")[2])[0] if " " in text else ""
        whole = to_unit(value, bare, dimension)
        if not isfinite(whole) or abs(float(text.partition(" ")[0]) - whole) <= ROUNDING * abs(whole):
            return text
    return show(value, unit, dimension, digits=MOST_DIGITS)


def machine_in(design: Design) -> Machine | None:
    """The machine as built without tolerances; None where no design was found."""
    scene = design.scene
    found = len(design.x) == len(scene.variables) and design.status not in ("infeasible", "unbounded", "unproven")
    return machine_of(scene, design.scene.named(design.x)) if found and not open_places(scene) else None


def build_rows(design: Design, machine: Machine, *, whole: bool = True) -> list[tuple[str, str]]:
    """What to order or to build, group by group; then every other number that was chosen.

    Parameters
    ----------
    design, machine
        An answer with a design, and the machine that it is.
    whole
        Whether all is said, and with as many digits as were verified: for a page to build by.  Else what was chosen
        or is bought, and springs of which there are several, in the digits of the answer.
    """
    scene, rows = design.scene, []
    exact = verified if whole else show
    for name, mount in scene.mounts.items():
        if whole or mount.part is not None or _chosen_in(design, f"mounts.{name}"):
            assert is_in_space(machine)
            own = machine.mount(machine.groups[name][0])
            order = _order(design, f"mounts.{name}", mount.part, mount.count)
            rows.append((name, _joined(order, _mount(mount, own, exact))))
    for name, link in scene.links.items():
        joint = machine.joint(name)
        if whole or link.part is not None or joint.count > 1 or _chosen_in(design, f"links.{name}"):
            order = _order(design, f"links.{name}", link.part, joint.count) or _sizes(design, name, exact, whole=whole)
            rows.append((name, _joined(order, _link(link, joint, exact))))
    for part in parts_of(design):
        words = [f"{key.replace('_', ' ')} {_again(number)}" for key, number in part.numbers.items()]
        rows.append((part.name, f"on {part.on}: {', '.join(words)}" if whole else part.words))
    return rows + _others(design, exact)


def _chosen_in(design: Design, device: str) -> bool:
    """Whether a number, a part or a place of a device was chosen."""
    return any(path.startswith(f"{device}.") for path in (*design.variables, *design.places))


def _joined(first: str, then: list[str]) -> str:
    return ": ".join(filter(None, (first, ", ".join(then))))


def _again(entry: Entry) -> str:
    """The same value with all its digits, in the unit in which it was shown."""
    unit = entry.shown.partition(" ")[2]
    exact = entry.dimension in ("mass", "stiffness", "damping")
    return verified(entry.value, unit, entry.dimension) if exact else entry.shown


def _order(design: Design, path: str, part: Part | None, count: float) -> str:
    """What to order: "4 x S60-60 (26.95 EUR each, 107.8 EUR)"; "" of what is not bought."""
    if part is None:
        return ""
    placed = design.places.get(f"{path}.part")
    words = f"{plain(count)} x {placed.value if placed is not None else part.name}"
    price = part.price
    if price is None:
        return words
    chosen = design.variables.get(f"{path}.part.price")
    one = chosen.value.value if chosen is not None else getattr(price, "value", 0.0)
    unit = price.unit
    return f"{words} ({_money(one, unit)} each, {_money(count * one, unit)})"


def _sizes(design: Design, link: str, exact: Shown, *, whole: bool) -> str:
    """Of a beam or shaft that was chosen, or all of them: "overhung beam, length 0.3 m, diameter 31.48 mm"."""
    table = design.scene.links[link]
    key, bar = ("beam", table.beam) if table.beam is not None else ("shaft", table.shaft)
    if bar is None:
        return ""
    words = [f"{getattr(bar, 'kind', 'round').replace('_', ' ')} {key}"] if whole else []
    for size in type(bar).model_fields:
        value, chosen = getattr(bar, size), design.variables.get(f"links.{link}.{key}.{size}")
        rule = rule_of(type(bar), size)
        if rule is None or value is None or (chosen is None and not whole):
            continue
        shown = (
            show(value.value, value.unit, rule.dimension)
            if chosen is None
            else exact(chosen.value.value, value.unit, rule.dimension)
        )
        words.append(f"{size.replace('_', ' ')} {shown}")
    return ", ".join(words)


def _money(value: float, unit: str) -> str:
    return show(value, unit, "price", digits=8)


def _mount(table: MountTable, own: Spring3, exact: Shown) -> list[str]:
    """Stiffness along its own axes, damping, what is static of it; of one mount."""
    unit = _unit(table, "stiffness")
    x, y, z = (exact(float(one), unit, "stiffness") for one in own.stiffness)
    many = f"{table.count} mounts, each of " if table.count > 1 else ""
    words = [f"{many}stiffness {z} along its axis", f"{x} across" if x == y else f"{x} across along x, {y} along y"]
    if own.damping.any():
        dx, dy, dz = (exact(float(one), _unit(table, "damping"), "damping") for one in own.damping)
        words.append(f"damping {dz} along, {dx if dx == dy else f'{dx}, {dy}'} across")
    if own.loss_factor:
        words.append(f"loss factor {exact(own.loss_factor, '', 'ratio')}")
    if own.static_stiffness[2] != own.stiffness[2]:
        words.append(f"static stiffness {show(float(own.static_stiffness[2]), unit, 'stiffness')}")
    axes = {tuple(round(float(one), 3) for one in frame[2]) for frame in table.frames}
    if axes != {(0.0, 0.0, 1.0)}:
        said = " and ".join(f"({', '.join(plain(part + 0.0, 3) for part in axis)})" for axis in sorted(axes))
        words.append(f"inclined, axis {said}")
    return words


def _link(table: LinkTable, joint: Joint, exact: Shown) -> list[str]:
    """Springs and dampers: of each, and of all together where there are several."""
    around = table.torsional_stiffness is not None or table.shaft is not None or table.torsional_damping is not None
    words: list[str] = []
    turn = "torsional_" if around else ""
    for key, value, noun in (("stiffness", joint.stiffness, "spring"), ("damping", joint.damping, "damper")):
        if value > 0.0:
            unit = _unit(table, f"{turn}{key}")
            one, all_ = (exact(each, unit, f"{turn}{key}") for each in (value / joint.count, value))
            what = f"{turn.replace('_', ' ')}{noun} of" if not words else key
            if joint.count == 1:
                words.append(one if table.part is not None and not words else f"{what} {one}")
            elif words:
                words.append(f"{what} {one} each")
            else:
                many = "" if table.part is not None else f"{plain(joint.count)} {what.replace(noun, f'{noun}s')} "
                words.append(f"{many}{one} each, {all_} together")
    if joint.loss_factor:
        words.append(f"loss factor {exact(joint.loss_factor, '', 'ratio')}")
    if joint.friction:
        one = exact(joint.friction / joint.count, _unit(table, "friction_force"), "force")
        words.append(f"friction {one}{' each' if joint.count > 1 else ''}")
    return [*words, f"between {table.between[0]} and {table.between[1]}"]


def _unit(table: object, key: str) -> str:
    given = getattr(table, key, None)
    given = getattr(given, "z", given)
    return str(getattr(given, "unit", "") or "")


def _others(design: Design, exact: Shown) -> list[tuple[str, str]]:
    """Chosen numbers and places that no row has said yet."""
    places = {path: place.value for path, place in design.places.items() if not path.endswith(".part")}
    rows = [(_owner(path), place) for path, place in places.items() if not path.startswith(("absorbers.", "links."))]
    units = asked_positions(design.scene) | {variable.path: variable for variable in design.scene.variables}
    for path, chosen in design.variables.items():
        if path in units and not _told(design.scene, path):
            one = units[path]
            rows.append((_owner(path), exact(chosen.value.value, one.unit, one.dimension)))
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
