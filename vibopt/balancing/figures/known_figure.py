"""Figures of shafts with known masses: the shaft, its planes, and what the masses do before and after."""

from __future__ import annotations

import cmath
from dataclasses import replace
from math import tau
from typing import TYPE_CHECKING

from vibopt.answer.answer import Answer
from vibopt.answer.entry import Entry, Value
from vibopt.balancing.figures.dials import Disc, rows_of
from vibopt.balancing.figures.dials import Spot as Placed
from vibopt.balancing.figures.drawing import COMPACT, Bar, Bars, Key, Piece, Shaft, page
from vibopt.balancing.figures.rotor_figure import disc, titled
from vibopt.balancing.known.correct import AS_WRITTEN
from vibopt.balancing.known.known_job import KnownJob
from vibopt.report.figures.paper import WIDTH, drawn
from vibopt.units import best_unit, to_unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def known_figure(outcome: Answer[KnownJob], *, compact: bool) -> Figure | None:
    """The known masses, a disc for each plane, and bars of what was and what is left (not in a compact one)."""
    job = outcome.job
    if outcome.status in ("infeasible", "unbounded", "unproven"):
        return None
    discs = [
        _masses(job),
        *(replace(disc(AS_WRITTEN, *both), turns=False) for both in zip(job.planes, outcome.plan.planes, strict=True)),
    ]
    groups = _groups(outcome, job) if not compact else []
    columns = 3 if compact or len(discs) not in (1, 2, 4) else 2
    caption = "  ".join(("Drawn with the angles counted counter-clockwise from the top.", *job.notes))
    bars = [
        Bars("" if k else "As found and after" if job.planes else "As found", unit, rows)
        for k, (unit, rows) in enumerate(groups)
    ]
    key = Key(
        caption,
        dials=bool(job.planes),
        limits=any(row.limit is not None for _, rows in groups for row in rows),
        fitted=any(not plane.remove for plane in job.planes),
        removed=any(plane.remove for plane in job.planes),
        masses=True,
        before=bool(groups),
        after=bool(job.planes and groups),
    )
    width = COMPACT if compact else WIDTH
    along = [] if job.flat or compact else [shaft_of(job)]
    return page([*along, *rows_of(discs, columns, width), *bars, key], "" if compact else job.title, width)


def shaft_of(job: KnownJob) -> Shaft:
    """The shaft with its masses, planes and bearings where they are."""
    above = [Piece(mass.at, drawn(mass.name, 14), "mass") for mass in job.masses]
    above += [Piece(plane.at, titled("plane", plane.name), "plane") for plane in job.planes if plane.at is not None]
    below = [Piece(bearing.at, titled("bearing", bearing.name), "bearing") for bearing in job.bearings]
    return Shaft(tuple(above), tuple(below))


def _masses(job: KnownJob) -> Disc:
    """All known masses along the shaft seen from its end; the farther out the greater the unbalance."""
    top = max((abs(mass.u) for mass in job.masses), default=1.0) or 1.0
    spots = tuple(
        Placed(cmath.phase(mass.u) % tau, drawn(mass.name, 14), "there", 0.35 + 0.65 * abs(mass.u) / top)
        for mass in job.masses
    )
    return Disc("Known masses", 1, spots, turns=False)


def _groups(outcome: Answer[KnownJob], job: KnownJob) -> list[tuple[str, list[Bar]]]:
    """Bars by unit: static unbalance, couple, reactions."""
    groups = []
    reactions = [(f"bearing {bearing.name}", f"bearings.{bearing.name}.reaction") for bearing in job.bearings]
    for names, dimension, response in (
        ([("static unbalance", "static")], "unbalance", "static_unbalance"),
        ([("couple unbalance", "couple")], "couple_unbalance", "couple_unbalance"),
        (reactions, "force", "bearing_reaction"),
    ):
        kept = [(name, path) for name, path in names if f"as_found.{path}" in outcome.values]
        if not kept:
            continue
        sizes = [outcome.values[f"as_found.{path}"].value for _, path in kept]
        unit = best_unit(max(float(size) for size in sizes), dimension)
        rows = [_bar(outcome, name, path, unit, dimension, _limit(job, response, name)) for name, path in kept]
        groups.append((unit, rows))
    return groups


def _limit(job: KnownJob, response: str, name: str) -> float | None:
    bounds = [
        limit.bound
        for limit in job.limits.values()
        if limit.response == response and (limit.of is None or name.endswith(f" {limit.of}"))
    ]
    return min(bounds, default=None)


def _bar(outcome: Answer[KnownJob], name: str, path: str, unit: str, dimension: str, limit: float | None) -> Bar:
    def number(one: Value | None) -> float | None:
        return to_unit(one.value, unit, dimension) if isinstance(one, Entry) else None

    before, after = (number(outcome.values.get(f"{when}.{path}")) for when in ("as_found", "residual"))
    return Bar(name, before, after, None if limit is None else to_unit(limit, unit, dimension))
