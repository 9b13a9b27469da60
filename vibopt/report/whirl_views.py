"""The free whirls of a design with rotors at the spins at which their damping is asked: frequency, sense, decrement."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from vibopt.answer.blocks import Block, table
from vibopt.answer.entry import Entry
from vibopt.errors import InputError
from vibopt.mechanics.machine import Machine
from vibopt.records import dataclass
from vibopt.scene.scene import Design, Scene
from vibopt.values.speeds import ROTATION

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from vibopt.responses.whirl_damping import OfWhirls

_SENSES = {1.0: "forward", -1.0: "backward", 0.0: "along a line"}


@dataclass(frozen=True, slots=True)
class Whirl:
    """One free whirl at one spin."""

    spin: Entry
    frequency: Entry
    whirl: str
    logarithmic_decrement: Entry


def asks_whirls(scene: Scene) -> bool:
    """Whether some number of the file is the damping of a free whirl at a spin."""
    return bool(_asked(scene))


def _asked(scene: Scene) -> list[OfWhirls]:
    return [cast("OfWhirls", response) for response in scene.responses.values() if response.spins]


def whirls_of(design: Design, machine: Machine | None) -> list[Whirl]:
    """By waves, at both ends of what is asked, up to the greatest frequency that counts there; the slowest first."""
    asked = _asked(design.scene)
    if not asked:
        return []
    from vibopt.mechanics.rotating import RotatingMachine
    from vibopt.mechanics.whirls_as_built import in_planes, whirls

    if not isinstance(machine, RotatingMachine):
        return []
    built = in_planes(machine)
    reach: dict[float, OfWhirls] = {}
    for one in sorted(asked, key=lambda one: one.up_to.value):
        reach.update({spin: one for band in one.spins for spin in (band.low, band.high)})
    return [
        Whirl(
            Entry(spin, ROTATION, one.up_to.unit),
            Entry(rate.real, ROTATION, one.up_to.unit),
            _SENSES[sense],
            Entry(2.0 * np.pi * rate.imag / rate.real, "ratio"),
        )
        for spin, one in sorted(reach.items())
        for rate, sense in whirls(built, spin, one.up_to.value)
    ]


def whirls_block(design: Design, machine: Machine | None) -> Block:
    """Their table; empty where no damping of a whirl is asked."""
    rows = [
        (whirl.spin, whirl.frequency, whirl.whirl, whirl.logarithmic_decrement) for whirl in whirls_of(design, machine)
    ]
    return table("Free whirls", ("Spin", "Frequency", "Whirl", "Log. decrement"), rows)


def whirls_json(design: Design, machine: Machine | None) -> dict[str, Any]:
    """The same for programs: numbers in SI beside the texts."""
    found = whirls_of(design, machine)
    return {"whirls": found} if found else {}


def campbell_drawn(design: Design) -> list[tuple[str, Figure]]:
    """The Campbell diagram, where the damping of a whirl is asked and something says how far to look."""
    from vibopt.report.campbell import campbell_of
    from vibopt.report.figures.campbell_diagram import campbell_figure

    if not asks_whirls(design.scene):
        return []
    with suppress(InputError):
        return [("Campbell diagram", campbell_figure(campbell_of(design), ""))]
    return []
