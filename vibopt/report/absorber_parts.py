"""What a design makes of its absorbers: the parts to build, their strokes, and the modes before and after."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import isfinite, sqrt
from typing import TYPE_CHECKING

import numpy as np

from vibopt.answer.blocks import at_words
from vibopt.answer.entry import Entry
from vibopt.excitations import Excitation
from vibopt.mechanics.built import GROUND
from vibopt.mechanics.machine import Machine
from vibopt.records import dataclass
from vibopt.scene.assemble import bare
from vibopt.scene.drives import names_for
from vibopt.scene.places import neighbours, supports, turning
from vibopt.scene.scene import Design, Scene
from vibopt.signals import Band
from vibopt.units import best_unit, plain, show, to_unit
from vibopt.values.directions import way_words
from vibopt.verify.as_built import machine_of
from vibopt.verify.certify import measure_on

ALONG = ("mass", "stiffness", "damping")
BUILD = "What to build"
AROUND = ("inertia", "torsional_stiffness", "torsional_damping")

if TYPE_CHECKING:
    from vibopt.devices.absorber import AbsorberTable


@dataclass(frozen=True, slots=True)
class Part:
    """One absorber as it is built.

    numbers
        "mass", "stiffness", "damping" (or the words of what turns), "own_frequency", "tuning", "damping_ratio";
        without a spring or a damper those that speak of it are missing.
    on
        What it sits on, and in space where, and along which way it slides.
    """

    name: str
    on: str
    numbers: Mapping[str, Entry]

    @property
    def words(self) -> str:
        """All of it as one sentence."""
        said = [f"{key.replace('_', ' ')} {number.shown}" for key, number in self.numbers.items()]
        return f"on {self.on}: {', '.join(said)}"


@dataclass(frozen=True, slots=True)
class StrokeBar:
    """The stroke of one absorber under one excitation, and its limit (None without one), both [SI]."""

    absorber: str
    excitation: str
    value: float
    at: Entry
    limit: float | None


@dataclass(frozen=True, slots=True)
class Strokes:
    """All strokes in one unit; `values` and `limits` stand in it, inf where there is no end to a stroke."""

    label: str
    bars: tuple[StrokeBar, ...]
    values: tuple[float, ...]
    limits: tuple[float | None, ...]
    words: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class SpeedBand:
    """Frequencies at which an excitation shakes, in the unit of `Modes`; `words` name it."""

    excitation: str
    low: float
    high: float
    words: str


@dataclass(frozen=True, slots=True)
class Modes:
    """Undamped natural frequencies without and with absorbers, against the bands of the excitations."""

    label: str
    before: tuple[float, ...]
    after: tuple[float, ...]
    bands: tuple[SpeedBand, ...]
    span: tuple[float, float]


def has_absorbers(design: Design) -> bool:
    """Whether there are absorbers and a design of them."""
    return bool(design.scene.absorbers) and len(design.x) == len(design.scene.variables)


def parts_of(design: Design) -> tuple[Part, ...]:
    """What to build, absorber by absorber; empty without a design."""
    if not has_absorbers(design):
        return ()
    machine, around = machine_of(design.scene, design.scene.named(design.x)), turning(design.scene)
    return tuple(_part(design.scene, machine, name, name in around) for name in design.scene.absorbers)


def _part(scene: Scene, machine: Machine, name: str, around: bool) -> Part:
    joint, mass, tuned = machine.joint(name), machine.masses[name], machine.tuned[name]
    words = AROUND if around else ALONG
    numbers = {}
    for word, value in zip(words, (mass, joint.stiffness, joint.damping), strict=True):
        if value > 0.0:
            numbers[word] = Entry(value, word, _unit_of(scene, name, word))
    if joint.loss_factor > 0.0:
        numbers["loss_factor"] = Entry(joint.loss_factor, "ratio")
    if joint.stiffness > 0.0:
        own = sqrt(joint.stiffness / mass)
        numbers["own_frequency"] = Entry(own, "angular_rate", _unit_of(scene, name, "frequency") or "Hz")
        if tuned.frequency > 0.0:
            numbers["tuning"] = Entry(own / tuned.frequency, "ratio")
        if joint.damping_ratio > 0.0:
            numbers["damping_ratio"] = Entry(joint.damping_ratio, "ratio")
    return Part(name, _stand(scene.absorbers[name]), numbers)


def _stand(table: AbsorberTable) -> str:
    """What it sits on; in space where, and along which way it slides."""
    at = f" at ({', '.join(plain(one, 4) for one in table.at)}) m" if table.at is not None else ""
    way = f" along {way_words(table.direction)}" if table.direction is not None else ""
    return f"{table.host}{at}{way}"


def _unit_of(scene: Scene, name: str, word: str) -> str:
    """The unit in which the file speaks of this number."""
    given = getattr(scene.absorbers[name], word, None)
    return str(getattr(given, "unit", "") or "")


def stroke_bars(design: Design) -> tuple[StrokeBar, ...]:
    """Every absorber under every steady excitation, measured on the machine as built."""
    scene = design.scene
    if not has_absorbers(design):
        return ()
    machine = machine_of(scene, design.scene.named(design.x))
    return tuple(bar for name in scene.absorbers for bar in _bars(scene, machine, name))


def _bars(scene: Scene, machine: Machine, name: str) -> Iterator[StrokeBar]:
    from vibopt.responses.absorber_responses import Stroke

    asked = [one for one in scene.limits.values() if isinstance(one, Stroke) and one.of == name]
    for excitation, table in scene.excitations.items():
        if table.sort != "steady" or name not in _shaken(scene, table.on):
            continue
        response = next((one for one in asked if excitation in names_for(scene, one)), None)
        own: dict[str, object] = {"response": "stroke", "of": name, "due_to": [excitation]}
        if response is not None and isinstance(response.over, dict):
            own["over"] = {key: one for key, one in response.over.items() if key == excitation}
        elif response is not None:
            own["over"] = response.over
        one = Stroke.model_construct(**own) if response is None else response.model_copy(update=own)  # type: ignore[arg-type]
        measured = measure_on(scene, machine, one, "at_most")
        speed = table.speed
        at = Entry(table.from_rotation(measured.speeds[excitation]), speed.dimension, speed.unit)
        bound = response.at_most.value if response is not None and response.at_most is not None else None
        yield StrokeBar(name, excitation, measured.value, at, bound)


def _shaken(scene: Scene, on: str) -> set[str]:
    """Points that an excitation at one of them can move: what hangs together without the supports."""
    beside, still = neighbours(scene), {GROUND, *supports(scene)}
    found, left = {on}, [on]
    while left:
        fresh = beside.get(left.pop(), set()) - found - still
        found |= fresh
        left += fresh
    return found


def strokes(design: Design) -> Strokes | None:
    """The strokes in one unit; None where nothing is shaken."""
    from vibopt.responses.absorber_responses import Stroke

    bars = stroke_bars(design)
    if not bars:
        return None
    scene = design.scene
    given = [
        limit.at_most for limit in scene.limits.values() if isinstance(limit, Stroke) and limit.at_most is not None
    ]
    sizes = [bar.value for bar in bars if isfinite(bar.value)] + [bar.limit for bar in bars if bar.limit is not None]
    around = set(scene.absorbers) <= turning(scene)
    dimension = "angle" if around else "length"
    unit = given[0].unit if given else best_unit(max(sizes, default=1.0), dimension)
    factor = to_unit(1.0, unit, dimension)
    said = tuple(f"{show(bar.value, unit, dimension, amplitude=True)} at {at_words({'': bar.at})}" for bar in bars)
    bare_unit = unit if unit.endswith(("pp", "rms", "pk")) else f"{unit} pk"
    return Strokes(
        label=f"stroke [{bare_unit}]",
        bars=bars,
        values=tuple(bar.value * factor for bar in bars),
        limits=tuple(None if bar.limit is None else bar.limit * factor for bar in bars),
        words=said,
    )


def modes(design: Design) -> Modes | None:
    """Natural frequencies without and with absorbers; None without steady excitations."""
    scene = design.scene
    steady = {name: excitation for name, excitation in scene.excitations.items() if excitation.sort == "steady"}
    if not has_absorbers(design) or not steady:
        return None
    chosen = design.scene.named(design.x)
    units = [excitation.speed.unit for excitation in steady.values() if not excitation.of_vehicle]
    unit = units[0] if units else "Hz"
    factor = to_unit(1.0, unit, "angular_rate")
    here = bare(scene)
    before = machine_of(here, chosen).natural_frequencies() if here.bodies or here.structures else np.zeros(0)
    after = machine_of(scene, chosen).natural_frequencies()
    bands = tuple(band for name, excitation in steady.items() for band in _bands(name, excitation, factor))
    ends = [end for band in bands for end in (band.low, band.high) if isfinite(end) and end > 0.0]
    low, high = min(ends, default=1.0), max(ends, default=1.0)
    near = [one * factor for one in (*before, *after) if low / 5.0 <= one * factor <= 5.0 * high]
    span = (min([low, *near]) / 1.15, max([high, *near]) * 1.15)
    return Modes(
        label=f"natural frequency [{unit}]",
        before=tuple(float(one * factor) for one in before),
        after=tuple(float(one * factor) for one in after),
        bands=bands,
        span=span,
    )


def _bands(name: str, excitation: Excitation, factor: float) -> Iterator[SpeedBand]:
    """Own speeds times each order."""
    lines = excitation.lines(np.ones(1))
    for line in lines:
        order = f" x {plain(line.order, 3)}" if len(lines) > 1 else ""
        for band in excitation.own_bands():
            yield SpeedBand(
                name,
                line.order * band.low * factor,
                line.order * band.high * factor,
                _said(name, excitation, band) + order,
            )


def _said(name: str, excitation: Excitation, band: Band) -> str:
    speed = excitation.speed
    low, high = (show(excitation.from_rotation(end), speed.unit, speed.dimension) for end in (band.low, band.high))
    return f"{name} {low}" if band.is_point else f"{name} {low.partition(' ')[0]} to {high}"
