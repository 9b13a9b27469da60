"""What a drawing shows of a rotor: sections, discs and bearings as chosen."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from vibopt.devices.rotor import RotorTable
from vibopt.devices.spring import bore
from vibopt.report.figures.paper import drawn
from vibopt.report.figures.rotor_drawing import Rotor
from vibopt.scene.places import ends
from vibopt.scene.scene import Design
from vibopt.values import Value

_LONGEST = 24
"""Letters of a name in a drawing."""
_THIN = 0.02
"""Part of its length by which a shaft is drawn whose diameters are not known."""


def rotors_of(design: Design) -> list[Rotor]:
    """Every rotor of a scene; what was to be chosen and is not known stands between its ends."""
    return [_rotor(design, name, table) for name, table in design.scene.rotors.items()]


def _rotor(design: Design, name: str, table: RotorTable) -> Rotor:
    sections, stops = [], [0.0]
    for number, section in enumerate(table.sections, start=1):
        path = f"rotors.{name}.sections.{number}"
        wide = _known(design, f"{path}.diameter", section.diameter)
        stops.append(stops[-1] + _known(design, f"{path}.length", section.length))
        sections.append((stops[-2], stops[-1], wide, bore(section) * wide))
    places = table.places_on(np.array(stops))
    if table.matrices is not None:  # which do not say how thick it is
        sections = [(a, b, _THIN * table.long, 0.0) for a, b in pairwise(table.nodes)]
    discs = []
    for number, disc in enumerate(table.discs, start=1):
        path = f"rotors.{name}.discs.{number}"
        mass = "" if disc.mass is None else f"\n{_shown(design, f'{path}.mass', disc.mass)}"
        words = f"{drawn(disc.name, _LONGEST)}{mass}"
        discs.append((
            words, places[disc.name], _known(design, f"{path}.outer_diameter", disc.outer_diameter),
            _known(design, f"{path}.width", disc.width),
        ))  # fmt: skip
    held: dict[float, list[str]] = {}
    for link, two in ends(design.scene).items():
        for place in (places[end] for end in two if end in places):
            held.setdefault(place, []).append(drawn(link, _LONGEST))
    return Rotor(name, tuple(sections), tuple(discs), tuple((at, "\n".join(names)) for at, names in held.items()))


def _known(design: Design, path: str, value: Value | None) -> float:
    """SI; nan where a file says nothing."""
    chosen = design.variables.get(path)
    if chosen is not None:
        return chosen.value.value
    if value is None:
        return math.nan
    return float(getattr(value, "value", 0.5 * (getattr(value, "low", 0.0) + getattr(value, "high", 0.0))))


def _shown(design: Design, path: str, value: Value) -> str:
    chosen = design.variables.get(path)
    return chosen.value.shown if chosen is not None else f"{_known(design, path, value):.4g} kg"
