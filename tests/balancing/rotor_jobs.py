"""Small measured rotors as text, and the way from text to plan."""

from __future__ import annotations

import cmath
import tomllib
from math import degrees
from pathlib import Path

from vibopt.answer.answer import Answer
from vibopt.balancing.read_rotor import read_rotor
from vibopt.balancing.rotor_job import RotorJob
from vibopt.balancing.solve_rotor import solve_job
from vibopt.document.locate import Locator
from vibopt.document.mistakes import Mistakes
from vibopt.errors import InputError

FAN = """title = "Two-plane fan"
[conventions]
phase = "lag"
readings = "phase"
angles = "against rotation"
detector = "pp"
zero = "reflective tape"
[planes.left]
radius = "150 mm"
[planes.right]
radius = "150 mm"
[[runs]]
name = "as found"
speed = "1200 rpm"
readings = { a = "8.6 mil @ 63 deg", b = "6.5 mil @ 206 deg" }
[[runs]]
name = "trial left"
speed = "1200 rpm"
weights = { left = "10 g @ 270 deg" }
readings = { a = "5.9 mil @ 123 deg", b = "4.5 mil @ 228 deg" }
[[runs]]
name = "trial right"
speed = "1200 rpm"
weights = { right = "12 g @ 180 deg" }
readings = { a = "6.2 mil @ 36 deg", b = "10.4 mil @ 162 deg" }
"""
"""A published two-plane job (readings in mil peak to peak), the base of most tests here."""


def read_text(text: str, folder: Path | None = None) -> RotorJob:
    return read_rotor(tomllib.loads(text), Mistakes("fan.toml", Locator(text)), folder)


def solve_text(text: str, folder: Path | None = None) -> Answer[RotorJob]:
    return solve_job(read_text(text, folder))


def messages(text: str, folder: Path | None = None) -> list[str]:
    """What is said about a wrong file; empty for a right one."""
    try:
        read_text(text, folder)
    except InputError as error:
        return list(error.messages)
    return []


def polar(z: complex, unit: str, factor: float = 1.0) -> str:
    return f"{abs(z) * factor!r} {unit} @ {degrees(cmath.phase(z)) % 360.0!r} deg"


def correction(plan: Answer[RotorJob], name: str) -> complex:
    """Mass [kg] and written angle of a plane as one number; of several weights what they do together."""
    plane = next(one for one in plan.plan.planes if one.name == name)
    return cmath.rect(float((plane.acts_as or plane.mass).value), float(plane.angle.value))
