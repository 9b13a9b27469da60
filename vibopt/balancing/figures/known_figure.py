"""Known masses on a shaft: what to fit in each plane, and unbalance and bearing reactions before and after."""

from __future__ import annotations

import cmath
from collections.abc import Sequence
from math import tau
from typing import TYPE_CHECKING

from vibopt.answer.answer import Answer
from vibopt.answer.entry import Entry, Value
from vibopt.balancing.figures.drawing import Bar, Disc, bars, draw_disc, height, key, pad_more
from vibopt.balancing.figures.drawing import Spot as Placed
from vibopt.balancing.known.known_job import KnownJob, Spot
from vibopt.report.figures.paper import INK, SIZE, WIDTH, sheet
from vibopt.units import best_unit, to_unit
from vibopt.units.showing import show_angle

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def known_figure(outcome: Answer[KnownJob], job: KnownJob, *, compact: bool = False) -> Figure | None:
    """The known masses, a disc for each plane, and bars of what was and what is left (not in a compact one)."""
    if outcome.status in ("infeasible", "unbounded"):
        return None
    discs = [_masses(job), *(_disc(outcome, one) for one in job.spots)]
    groups = _groups(outcome, job) if not compact else []
    columns = 3 if compact or len(discs) not in (1, 2, 4) else 2
    count = -(-len(discs) // columns)
    each, tall = (1.0 if compact else 0.94) * WIDTH / columns, [height(len(one)) for _, one in groups]
    figure = sheet(WIDTH, each * count + sum(tall) + 0.9)
    pad_more(figure)
    grid = figure.add_gridspec(count + len(groups), columns, height_ratios=[each] * count + tall)
    for k, one in enumerate(discs):
        draw_disc(figure, grid[divmod(k, columns)] if len(discs) > 1 else grid[0, :], one, WIDTH / columns)
    for index, (unit, rows) in enumerate(groups):
        axes = figure.add_subplot(grid[count + index, :])
        bars(axes, "" if index else "As found and after" if job.spots else "As found", unit, rows)
    if not compact:
        figure.suptitle(job.title, fontsize=SIZE + 3, color=INK, fontweight="bold")
    caption = "  ".join(("Drawn with the angles counted counter-clockwise from the top.", *job.notes))
    removed = any(one.plane.remove for one in job.spots)
    fitted = any(not one.plane.remove for one in job.spots)
    limits = any(row.limit is not None for _, rows in groups for row in rows)
    key(
        figure,
        caption,
        dials=bool(job.spots),
        limits=limits,
        fitted=fitted,
        removed=removed,
        masses=True,
        before=bool(groups),
        after=bool(job.spots and groups),
    )
    return figure


def _masses(job: KnownJob) -> Disc:
    """All known masses along the shaft seen from its end; the farther out the greater the unbalance."""
    top = max((abs(one.u) for one in job.masses), default=1.0) or 1.0
    spots = tuple(
        Placed(cmath.phase(one.u) % tau, one.name, "there", 0.35 + 0.65 * abs(one.u) / top) for one in job.masses
    )
    return Disc("Known masses", 1, spots, turns=False)


def _disc(outcome: Answer[KnownJob], spot: Spot) -> Disc:
    plane, path = spot.plane, f"planes.{spot.plane.name}"
    look = "away" if plane.remove else "fit"
    note, angle = "", outcome.values.get(f"{path}.angle")
    spots: tuple[Placed, ...] = ()
    if plane.shelf and f"{path}.weights" in outcome.values:
        spots = _in_holes(outcome.values[f"{path}.weights"].shown, plane.holes, look)
    elif angle is not None and isinstance(angle.value, float):
        amount = outcome.values.get(f"{path}.mass", outcome.values[f"{path}.unbalance"])
        spots = (Placed(angle.value, f"{amount.shown}\n{angle.shown.replace(' deg', '°')}", look),)
    if not spots:
        note = "leave\nuntouched" if plane.keep else "no weight"
    return Disc(f"Plane {plane.name}", 1, spots, plane.holes, plane.forbidden, note, turns=False)


def _in_holes(text: str, holes: Sequence[float], look: str) -> tuple[Placed, ...]:
    """Weights of the shelf from "50 g in hole 10 (202.5 deg), 20 g in hole 11 (225 deg)"."""
    spots = []
    for part in text.split(", "):
        weight, sign, rest = part.partition(" in hole ")
        if sign:
            hole = int(rest.split(" ")[0])
            angle = show_angle(holes[hole - 1]).replace(" deg", "°")
            spots.append(Placed(holes[hole - 1], f"{weight}, hole {hole}\n{angle}", look))
    return tuple(spots)


def _groups(outcome: Answer[KnownJob], job: KnownJob) -> list[tuple[str, list[Bar]]]:
    """Bars by unit: static unbalance, couple, reactions."""
    groups = []
    reactions = [(f"bearing {one.name}", f"bearings.{one.name}.reaction") for one in job.bearings]
    for names, dimension, response in (
        ([("static unbalance", "static")], "unbalance", "static_unbalance"),
        ([("couple unbalance", "couple")], "couple_unbalance", "couple_unbalance"),
        (reactions, "force", "bearing_reaction"),
    ):
        kept = [(name, path) for name, path in names if f"as_found.{path}" in outcome.values]
        if not kept:
            continue
        sizes = [outcome.values[f"as_found.{path}"].value for _, path in kept]
        unit = best_unit(max(float(one) for one in sizes), dimension)
        rows = [_bar(outcome, name, path, unit, dimension, _limit(job, response, name)) for name, path in kept]
        groups.append((unit, rows))
    return groups


def _limit(job: KnownJob, response: str, name: str) -> float | None:
    bounds = [
        one.bound
        for one in job.limits.values()
        if one.response == response and (one.of is None or name.endswith(f" {one.of}"))
    ]
    return min(bounds, default=None)


def _bar(outcome: Answer[KnownJob], name: str, path: str, unit: str, dimension: str, limit: float | None) -> Bar:
    def number(one: Value | None) -> float | None:
        return to_unit(one.value, unit, dimension) if isinstance(one, Entry) else None

    before, after = (number(outcome.values.get(f"{when}.{path}")) for when in ("as_found", "residual"))
    return Bar(name, before, after, None if limit is None else to_unit(limit, unit, dimension))


__all__ = ["known_figure"]
