"""What a sketch shows of a machine: boxes, links with their words, what shakes, where it is looked at."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from vibopt.devices import Device
from vibopt.mechanics.built import GROUND
from vibopt.records import dataclass
from vibopt.report.figures.paper import drawn
from vibopt.scene.places import carried, devices, ends, joints, place_of, springs, supports
from vibopt.scene.scene import Design, Scene

LONGEST = 18
_NUMBERS = (
    "stiffness", "torsional_stiffness", "damping", "torsional_damping", "loss_factor", "damping_ratio", "inertance",
    "tuning", "frequency",
)  # fmt: skip
_DAMPED = ("damping", "torsional_damping", "loss_factor", "damping_ratio")
_MASSES = ("mass", "weight", "inertia", "mass_ratio")
MOST_SITES = 12


@dataclass(frozen=True, slots=True)
class Piece:
    """A body, a base, a point of a structure or the ground; `still` what holds others, `joint` without mass."""

    name: str
    words: str
    still: bool
    joint: bool = False


@dataclass(frozen=True, slots=True)
class Link:
    """What joins two boxes, with its numbers in words; `gear` of teeth."""

    name: str
    ends: tuple[str, str]
    words: str
    spring: bool
    damper: bool
    inerter: bool
    gear: bool = False


@dataclass(frozen=True, slots=True)
class Shake:
    """An excitation of a box; `motion` where it moves it as prescribed."""

    name: str
    on: str
    words: str
    motion: bool


@dataclass(frozen=True, slots=True)
class Sketch:
    """All of it; `sites` are boxes at which a limit or measure looks, `notes` say which."""

    boxes: tuple[Piece, ...]
    links: tuple[Link, ...]
    shakes: tuple[Shake, ...]
    sites: tuple[str, ...]
    notes: tuple[str, ...]


def sketch_of(design: Design) -> Sketch:
    """Of a machine on a line or about an axis, with what was chosen of it."""
    scene = design.scene
    still = {GROUND, *supports(scene), *carried(scene)}
    joined = ends(scene)
    names = list(dict.fromkeys([*(end for two in joined.values() for end in two), *scene.bodies]))
    tables = {link: (family, name, table) for family, name, table in devices(scene) for link in table.joins(name)}
    links = tuple(_link(design, link, two, *tables[link]) for link, two in joined.items()) + _gears(scene)
    shakes = tuple(
        Shake(name, str(excitation.on or ""), shake_words(scene, name), excitation.on in supports(scene))
        for name, excitation in scene.excitations.items()
    )
    looks = {**scene.limits, **scene.measures}
    sites = tuple(dict.fromkeys(place for look in looks.values() for place, _ in look.places().values()))
    return Sketch(tuple(_piece(design, name, name in still) for name in names), links, shakes, sites, notes_of(scene))


def notes_of(scene: Scene) -> tuple[str, ...]:
    """Where the machine is looked at, in a sentence."""
    looks = {**scene.limits, **scene.measures}
    said = [f"{name}: {look.response.replace('_', ' ')} {place_of(look)}".rstrip() for name, look in looks.items()]
    more = f"; and {len(said) - MOST_SITES} more" if len(said) > MOST_SITES else ""
    return (f"Looked at (circles): {'; '.join(said[:MOST_SITES])}{more}.",) if said else ()


def _piece(design: Design, name: str, still: bool) -> Piece:
    if name in joints(design.scene) or ((body := design.scene.bodies.get(name)) is not None and body.massless):
        return Piece(name, drawn(name, LONGEST), still, joint=True)
    table = next(
        (f"{family}.{name}" for family in ("bodies", "absorbers") if name in getattr(design.scene, family)), ""
    )
    numbers = list(_numbers(design, table, _MASSES))[:1] if table else []
    return Piece(name, " ".join((drawn(name, LONGEST), *numbers)), still)


def _link(design: Design, link: str, two: tuple[str, str], family: str, name: str, table: Device) -> Link:
    path = f"{family}.{name}"
    given = _table(design.scene, path)
    placed, bought = design.places.get(f"{path}.part"), given.get("part")
    part = placed.value if placed is not None else bought.get("name", "") if isinstance(bought, Mapping) else ""
    numbers = [drawn(str(part), LONGEST)] if part else list(_numbers(design, path, _NUMBERS))[:3]
    many = next((number.removeprefix("count ") for number in _numbers(design, path, ("count",))), "1")
    if many != "1":  # of each, not of all together
        numbers = [f"{many} x {numbers[0]}", *numbers[1:]] if numbers else [f"{many} alike"]
        numbers = numbers if part or len(numbers[0]) > LONGEST else [f"{numbers[0]} each", *numbers[1:]]
    return Link(
        link,
        two,
        "\n".join((drawn(link, LONGEST), *numbers)),
        spring=link in springs(design.scene),
        damper=any(key in given for key in _DAMPED),
        inerter=family == "inerters",
    )


def _gears(scene: Scene) -> tuple[Link, ...]:
    """Teeth between bodies that turn as one, how many times as fast in words."""
    return tuple(
        Link(
            f"gears of {name}",
            (body.geared_to, name),
            f"gears\n{name} turns {body.speed_ratio.value:g} x",
            spring=False,
            damper=False,
            inerter=False,
            gear=True,
        )
        for name, body in scene.bodies.items()
        if body.geared_to is not None and body.speed_ratio is not None
    )


def _table(scene: Scene, path: str) -> Mapping[str, Any]:
    family, name = path.split(".", 1)
    given = scene.document.get(family, {}).get(name, {})
    return given if isinstance(given, Mapping) else {}


def _numbers(design: Design, path: str, keys: tuple[str, ...]) -> Iterator[str]:
    """What was chosen, else what the file gives."""
    given = _table(design.scene, path)
    for key in keys:
        chosen = design.variables.get(f"{path}.{key}")
        if chosen is not None:
            yield _named(key, chosen.value.shown)
        elif key in given and not isinstance(given[key], Mapping):
            yield _named(key, str(given[key]))


def _named(key: str, shown: str) -> str:
    """A value whose unit does not say what it is gets its key."""
    return f"{key.replace('_', ' ')} {shown}" if shown.split(" ")[-1] in ("%", shown) else shown


def shake_words(scene: Scene, name: str) -> str:
    """An excitation in a line or two: its name, size and speed."""
    table = _table(scene, f"excitations.{name}")
    size = next((str(table[key]) for key in _SIZES if key in table and isinstance(table[key], str)), "")
    size = size or scene.excitations[name].kind.replace("_", " ")
    speed = next((str(table[key]) for key in ("speed", "frequency") if isinstance(table.get(key), str)), "")
    return "\n".join((drawn(name, LONGEST), ", ".join(filter(None, (drawn(size, 28), drawn(speed, 24))))))


_SIZES = ("amplitude", "unbalance", "grade", "displacement", "velocity", "acceleration", "height", "density")
