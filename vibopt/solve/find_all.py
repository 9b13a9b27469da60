"""The complete set of speeds at which every limit holds, with exact ends."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from vibopt.answer.entry import Entry
from vibopt.arrays import FloatArray, joined
from vibopt.forms import Modulus
from vibopt.forms.drive_response import DriveResponse, drive_extreme, singularities
from vibopt.mechanics.peaks import crossings
from vibopt.program.program import Limit, Program
from vibopt.records import dataclass
from vibopt.report.machine_notes import notes_of
from vibopt.responses import HarmonicResponse
from vibopt.scene.drives import names_for, speeds_for
from vibopt.scene.scene import Design, Scene
from vibopt.signals import Band, Drive
from vibopt.solve.branch import Judge
from vibopt.verify.checked import checked_limits, checked_measures, disagreement

Interval = tuple[float, float]


@dataclass(frozen=True)
class Level:
    """Value of a limit against the speed of one excitation, the others at their worst; callable."""

    response: DriveResponse
    others: float
    combine: str

    def __call__(self, speed: FloatArray) -> FloatArray:
        """Shape of `speed` [rad/s]."""
        value = self.response(speed)
        return np.sqrt(value**2 + self.others**2) if self.combine == "rss" else value + self.others


def permitted_speeds(scene: Scene, program: Program) -> Design:
    """The answer to `find_all` of the speed of an excitation."""
    name = str(scene.find_all).removesuffix(".speed")
    excitation = scene.excitations[name]
    own = {
        key
        for key, limit in scene.limits.items()
        if isinstance(limit, HarmonicResponse)
        and name in names_for(scene, limit)
        and speeds_for(scene, limit, name) is None
    }
    found = speeds_of(program, name, excitation.own_bands(), own)
    unit, dimension = excitation.speed.unit, excitation.speed.dimension

    def shown(omega: float) -> Entry:
        return Entry(excitation.from_rotation(omega), dimension, unit)

    limits = checked_limits(scene, {}, model=program.model)
    measures = checked_measures(scene, {}, model=program.model)
    claim = "the complete set of speeds, with exact ends" if found else "no speed in the range meets every limit"
    doubt = disagreement(limits, measures)
    return Design(
        job=scene,
        status="check_failed" if doubt else "met" if found else "infeasible",
        claim=doubt or claim,
        limits=limits,
        measures=measures,
        method="exact crossings",
        found=None if doubt else tuple((shown(low), shown(high)) for low, high in found),
        notes=notes_of(scene, {}),
    )


def speeds_of(program: Program, drive_name: str, bands: tuple[Band, ...], own: set[str]) -> list[Interval]:
    """All speeds [rad/s] of an excitation at which every limit holds, as closed intervals.

    Parameters
    ----------
    program
        Without design variables.
    drive_name
        Excitation whose speed is the unknown.
    bands
        Where to look.
    own
        Names of limits that look at the unknown speed; the others must hold as they are.
    """
    judge = Judge(program)
    x = np.zeros(0)
    here = [(band.low, band.high) for band in bands]
    for limit in program.limits:
        if limit.name not in own:
            if judge.limit(limit, x)[0] > judge.tolerance:
                return []
            continue
        here = _intersection(here, _holds(limit, drive_name, bands))
    return here


def _holds(limit: Limit, drive_name: str, bands: tuple[Band, ...]) -> list[Interval]:
    """Speeds at which one limit holds."""
    form = limit.form.swings
    assert form is not None
    x = np.zeros(0)
    least = limit.least_wanted
    limit = replace(limit, bound=limit.bound - limit.form.beside(limit.model, x))
    if limit.bound < 0.0:
        return [(band.low, band.high) for band in bands] if least else []
    drive = next(one for one in form.drives if one.name == drive_name)
    rest = [drive_extreme(limit.model, form, one, x, least).value for one in form.drives if one is not drive]
    others = float(np.sqrt(sum(v * v for v in rest))) if form.combine == "rss" else float(sum(rest))
    level = Level(DriveResponse(limit.model, form, drive, x), others, form.combine)
    found: list[Interval] = []
    for band in bands:
        found += _pieces(limit, form, drive, level, band)
    return found


def _pieces(limit: Limit, form: Modulus, drive: Drive, level: Level, band: Band) -> list[Interval]:
    """Cut a band at every crossing, and keep the parts whose middle is good, and touching points."""
    singular, breaks = singularities(limit.model, form, drive, np.zeros(0))
    cuts = crossings(level, band, singular, breaks, limit.bound)
    edges = [band.low, *cuts, band.high]
    sign = 1.0 if limit.side == "at_most" else -1.0
    kept: list[Interval] = []
    for low, high in pairwise(edges):
        middle = level(np.array([0.5 * (low + high)]))[0]
        if sign * (middle - limit.bound) <= 0.0:
            kept.append((low, high))
    for point in edges:
        value = level(np.array([point]))[0]
        if sign * (value - limit.bound) <= 1e-12 * limit.bound and not any(a <= point <= b for a, b in kept):
            kept.append((point, point))
    return joined(kept)


def _intersection(first: list[Interval], second: list[Interval]) -> list[Interval]:
    both = [(max(a, c), min(b, d)) for a, b in first for c, d in second]
    return joined(one for one in both if one[0] <= one[1])
