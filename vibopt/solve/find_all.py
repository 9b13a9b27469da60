"""The complete set of speeds at which every limit holds, with exact ends."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from vibopt.answer.entry import Entry
from vibopt.arrays import joined
from vibopt.forms.form import Against
from vibopt.mechanics.peaks import crossings
from vibopt.program.program import Limit, Program
from vibopt.report.machine_notes import notes_of
from vibopt.responses import HarmonicResponse, Response, TransientResponse
from vibopt.responses.asked_speeds import START_UP
from vibopt.scene.drives import names_for, speeds_for
from vibopt.scene.scene import Design, Scene
from vibopt.signals import Band
from vibopt.solve.branch import Judge
from vibopt.verify.checked import checked_limits, checked_measures, disagreement

Interval = tuple[float, float]


def permitted_speeds(scene: Scene, program: Program) -> Design:
    """The answer to `find_all` of the speed of an excitation."""
    name = str(scene.find_all).removesuffix(".speed")
    excitation = scene.excitations[name]
    own = {key for key, limit in scene.limits.items() if _looks_at(scene, limit, name)}
    up_to = {key for key, limit in scene.limits.items() if _looks_at(scene, limit, name, START_UP)}
    found = speeds_of(program, name, excitation.own_bands(), own, up_to)
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


def _looks_at(scene: Scene, limit: Response, name: str, where: str | None = None) -> bool:
    """Whether a limit looks at an excitation at its own speeds, or from rest to them; as one of what comes once."""
    if not isinstance(limit, (HarmonicResponse, TransientResponse)) or name not in names_for(scene, limit):
        return False
    alone = limit.alone(name, scene.excitations[name].sorts) if isinstance(limit, TransientResponse) else limit
    return isinstance(alone, HarmonicResponse) and speeds_for(scene, alone, name) == where


def speeds_of(
    program: Program, drive_name: str, bands: tuple[Band, ...], own: set[str], up_to: set[str]
) -> list[Interval]:
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
    up_to
        Names of those that look at all speeds from rest to it.
    """
    judge = Judge(program)
    x = np.zeros(0)
    here = [(band.low, band.high) for band in bands]
    for limit in program.limits:
        if limit.name in up_to:
            risen = _holds(limit, drive_name, (Band(0.0, max(band.high for band in bands)),))
            here = _intersection(here, [(low, high) for low, high in risen if low == 0.0])
            continue
        if limit.name not in own:
            if judge.limit(limit, x)[0] > judge.tolerance:
                return []
            continue
        here = _intersection(here, _holds(limit, drive_name, bands))
    return here


def _holds(limit: Limit, name: str, bands: tuple[Band, ...]) -> list[Interval]:
    """Speeds of an excitation at which one limit holds, the others at their worst."""
    level = limit.form.against(limit.model, np.zeros(0), name, least_wanted=limit.least_wanted)
    if limit.bound < level.beside:
        return [(band.low, band.high) for band in bands] if limit.least_wanted else []
    sign = -1.0 if limit.least_wanted else 1.0
    return [one for band in bands for one in _pieces(level, band, limit.bound, sign)]


def _pieces(level: Against, band: Band, bound: float, sign: float) -> list[Interval]:
    """Cut a band at every crossing, and keep the parts whose middle is good, and touching points."""
    own = replace(level, beside=0.0)
    cuts = crossings(own, band, level.singular, level.breaks, bound - level.beside)
    edges = [band.low, *cuts, band.high]
    kept: list[Interval] = []
    for low, high in pairwise(edges):
        middle = level(np.array([0.5 * (low + high)]))[0]
        if sign * (middle - bound) <= 0.0:
            kept.append((low, high))
    for point in edges:
        value = level(np.array([point]))[0]
        if sign * (value - bound) <= 1e-12 * bound and not any(a <= point <= b for a, b in kept):
            kept.append((point, point))
    return joined(kept)


def _intersection(first: list[Interval], second: list[Interval]) -> list[Interval]:
    both = [(max(a, c), min(b, d)) for a, b in first for c, d in second]
    return joined(one for one in both if one[0] <= one[1])
