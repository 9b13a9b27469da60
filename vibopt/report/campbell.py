"""The Campbell diagram of a design with rotors: frequencies of free whirl against the spin, and critical speeds."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeGuard

import numpy as np

from vibopt.answer.entry import Entry
from vibopt.arrays import FloatArray
from vibopt.errors import InputError
from vibopt.mechanics.machine import Machine
from vibopt.records import dataclass
from vibopt.report.what_to_build import machine_in
from vibopt.scene.check_bearings import in_planes
from vibopt.scene.scene import Design, Scene

if TYPE_CHECKING:
    from vibopt.mechanics.rotating import RotatingMachine

_SPINS, _NO_PEAK = 81, 0.5**0.5
_BEYOND, _MET, _ABOVE = 1.25, 1.1, 2.2
"""How far the diagram goes beyond the highest speed of the file, and beyond the lowest critical speed of either sense;
how much higher its frequencies than that."""


@dataclass(frozen=True, eq=False)
class Campbell:
    """Whirls that are free at each spin, without damping.

    spins
        Shape (n,) [rad/s].
    forward, backward
        Sizes of their frequencies, ascending at each spin, (n, m) and (n, k) [rad/s].
    critical, against
        Critical speeds of forward and of backward whirl up to the last spin [rad/s].
    running
        Speeds of the unbalances, low and high [rad/s].
    damped
        Whether dampers count; whirls come and go with the spin then, and tables end with nothing.
    """

    spins: FloatArray
    forward: FloatArray
    backward: FloatArray
    critical: FloatArray
    against: FloatArray
    running: tuple[tuple[float, float], ...]
    damped: bool = False

    @property
    def top(self) -> float:
        """Highest frequency that is drawn [rad/s]."""
        return _ABOVE * float(self.spins[-1])


def campbell_of(design: Design) -> Campbell:
    """Of the finished design; its critical speeds by direct solution, without a grid.

    Raises
    ------
    InputError
        Nothing spins, there is no design, or no speed says how far to look.
    """
    scene, machine = design.scene, machine_in(design)
    if not scene.rotors:
        raise InputError(f"{scene.name}: --campbell is of rotors, and there is none. Leave --campbell out.")
    if machine is None or not _spins(machine):
        raise InputError(_no_machine(design))
    bands = _running(scene)
    if not bands:
        raise InputError(
            f"{scene.name}: nothing says how far to look. Add an unbalance with its speed, or a limit of "
            "critical_speed with outside."
        )
    if in_planes(scene):
        return _damped(machine, bands)
    every = machine.critical_speeds(), machine.critical_speeds(-1.0)
    last = max(
        [_BEYOND * max(high for _, high in bands), *(_MET * float(speeds[0]) for speeds in every if len(speeds))]
    )
    spins = np.linspace(0.0, last, _SPINS)
    found = [machine.free_whirls(float(spin)) for spin in spins]
    forward, backward = _table([one[one > 0.0] for one in found]), _table([np.sort(-one[one < 0.0]) for one in found])
    critical, against = (one[one <= last] for one in every)
    return Campbell(spins, forward, backward, critical, against, bands)


def _damped(machine: RotatingMachine, bands: tuple[tuple[float, float], ...]) -> Campbell:
    """Of free whirls with all dampers, at the coefficients of each spin, as far as tables go."""
    from vibopt.mechanics.whirls_as_built import as_fast, whirls_of_pieces
    from vibopt.mechanics.whirls_as_built import in_planes as both_planes

    built = both_planes(machine)
    low, high = built.known_spins
    firsts = [as_fast(built, sense, _NO_PEAK, many=1)[:1] for sense in (1.0, -1.0)]
    wanted = [_BEYOND * max(end for _, end in bands), *(_MET * float(one[0]) for one in firsts if len(one))]
    last = min(max(wanted), high)
    spins = np.linspace(low, last, 2 * _SPINS)
    found = [whirls_of_pieces(built, float(spin), _ABOVE * last) for spin in spins]
    tables = [_padded([[w.real for w, goes in one if goes * way >= 0.0] for one in found]) for way in (1.0, -1.0)]
    critical, against = (as_fast(built, sense, _NO_PEAK, last) for sense in (1.0, -1.0))
    return Campbell(spins, tables[0], tables[1], critical, against, bands, damped=True)


def _padded(rows: list[list[float]]) -> FloatArray:
    """Rows of as many numbers as the longest has, nothing behind."""
    found = np.full((len(rows), max(map(len, rows), default=0)), np.nan)
    for row, one in zip(found, rows, strict=True):
        row[: len(one)] = sorted(one)
    return found


def _no_machine(design: Design) -> str:
    """Why there is no Campbell diagram, and of which machine one would be."""
    scene = design.scene
    if design.found is None:
        return f"{scene.name}: there is no Campbell diagram: there is no design ({design.status})."
    (variable,) = scene.variables
    sets = [(a.value, b.value) for a, b in design.found]
    low, high = max(sets, key=lambda ends: ends[1] - ends[0], default=(variable.low, variable.high))
    there = Entry(0.5 * (low + high), variable.dimension, variable.unit).shown
    return (
        f"{scene.name}: find_all answers with values of {variable.path}, and a Campbell diagram is of one machine. "
        "Choose "
        f'it: vibopt plot {scene.name} --campbell --set {variable.path}="{there}" -o campbell.svg'
    )


def _spins(machine: Machine) -> TypeGuard[RotatingMachine]:
    return hasattr(machine, "free_whirls")


def _running(scene: Scene) -> tuple[tuple[float, float], ...]:
    """Speeds of what is out of balance, or those that limits keep away from [rad/s]."""
    bands = [band for excitation in scene.excitations.values() for band in excitation.own_bands()]
    bands = bands or [band for limit in scene.limits.values() for band in limit.outside_bands]
    return tuple(dict.fromkeys((band.low, band.high) for band in bands if 0.0 < band.high < np.inf))


def _table(rows: list[FloatArray]) -> FloatArray:
    """Rows of as many whirls as all of them have."""
    count = min(len(row) for row in rows)
    return np.array([row[:count] for row in rows])
