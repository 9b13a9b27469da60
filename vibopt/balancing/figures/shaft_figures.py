"""Figures of shafts with known masses, and of engines: what the masses do before and after, and over a turn."""

from __future__ import annotations

import cmath
from dataclasses import replace
from math import tau
from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.answer.answer import Answer
from vibopt.answer.entry import Entry, Value
from vibopt.arrays import ComplexArray, FloatArray
from vibopt.balancing.engine.engine_job import EngineJob
from vibopt.balancing.engine.shaking import arms, free_shares, free_weights, of_order, over_turn
from vibopt.balancing.figures.drawing import AFTER, BEFORE, Bar, Disc, bars, draw_disc, height, key, pad_more
from vibopt.balancing.figures.drawing import Spot as Placed
from vibopt.balancing.figures.rotor_figure import disc
from vibopt.balancing.known.correct import AS_WRITTEN
from vibopt.balancing.known.known_job import KnownJob
from vibopt.report.figures.paper import BLUE, FAINT, INK, SIZE, WIDTH, dress, sheet
from vibopt.units import best_unit, to_unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def known_figure(outcome: Answer[KnownJob], job: KnownJob, *, compact: bool = False) -> Figure | None:
    """The known masses, a disc for each plane, and bars of what was and what is left (not in a compact one)."""
    if outcome.status in ("infeasible", "unbounded"):
        return None
    discs = [
        _masses(job),
        *(replace(disc(AS_WRITTEN, *both), turns=False) for both in zip(job.planes, outcome.plan.planes, strict=True)),
    ]
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
        bars(axes, "" if index else "As found and after" if job.planes else "As found", unit, rows)
    if not compact:
        figure.suptitle(job.title, fontsize=SIZE + 3, color=INK, fontweight="bold")
    caption = "  ".join(("Drawn with the angles counted counter-clockwise from the top.", *job.notes))
    removed = any(one.remove for one in job.planes)
    fitted = any(not one.remove for one in job.planes)
    limits = any(row.limit is not None for _, rows in groups for row in rows)
    key(
        figure,
        caption,
        dials=bool(job.planes),
        limits=limits,
        fitted=fitted,
        removed=removed,
        masses=True,
        before=bool(groups),
        after=bool(job.planes and groups),
    )
    return figure


def _masses(job: KnownJob) -> Disc:
    """All known masses along the shaft seen from its end; the farther out the greater the unbalance."""
    top = max((abs(one.u) for one in job.masses), default=1.0) or 1.0
    spots = tuple(
        Placed(cmath.phase(one.u) % tau, one.name, "there", 0.35 + 0.65 * abs(one.u) / top) for one in job.masses
    )
    return Disc("Known masses", 1, spots, turns=False)


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


VISIBLE = 1e-3
_KINDS = ((False, "force", "force"), (True, "couple", "moment"))


def engine_figure(outcome: Answer[EngineJob], job: EngineJob, *, compact: bool = False) -> Figure | None:
    """Crank star; force and couple over one turn of the crank, and their orders; a couple that is nil is left out."""
    if outcome.status in ("infeasible", "unbounded"):
        return None
    after, before = shaken(outcome, job)
    kinds = [one for one in _KINDS if np.abs(after[int(one[0])]).max() > _nil(job, one[0])] or [_KINDS[0]]
    figure = sheet(WIDTH, (2.0 if compact else 2.7) * (1 + len(kinds)) + 0.7)
    pad_more(figure)
    grid = figure.add_gridspec(1 + len(kinds), 2)
    draw_disc(figure, grid[0, 0], _star(outcome, job), WIDTH / 2)
    _say_nil(figure.add_subplot(grid[0, 1]), outcome, job, [word for _, word, _ in kinds])
    for row, (couple, word, dimension) in enumerate(kinds, start=1):
        _draw_turn(figure.add_subplot(grid[row, 0]), after, before, couple, word, dimension)
        _draw_orders(figure.add_subplot(grid[row, 1]), after, before, couple, word, dimension)
    if before is not None:
        _key(figure)
    if not compact:
        figure.suptitle(job.title, fontsize=SIZE + 3, color=INK, fontweight="bold")
    return figure


def _key(figure: Figure) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    look: Any = {"facecolor": "white", "edgecolor": FAINT, "hatch": "////"}
    handles = [
        (Line2D([], [], color=BLUE, lw=1.8), Patch(facecolor=BLUE, edgecolor=INK)),
        (Line2D([], [], color=FAINT, lw=1.4, ls="--"), Patch(**look)),
    ]
    flat = [one for pair in handles for one in pair]
    words = ["as balanced", "as balanced", "without what was chosen", "without what was chosen"]
    figure.legend(flat, words, loc="outside lower center", ncols=2, fontsize=SIZE - 1, frameon=False)


def _nil(job: EngineJob, couple: bool) -> float:
    """Below this a force [N] or couple [N m] is rounding."""
    levers = [abs(one.at) if couple else 1.0 for one in job.cylinders]
    masses = [one.reciprocating + one.rotating for one in job.cylinders]
    return 1e-9 * job.speed**2 * sum(a * b for a, b in zip(levers, masses, strict=True))


def shaken(outcome: Answer[EngineJob], job: EngineJob) -> tuple[ComplexArray, ComplexArray | None]:
    """Arms of all orders as balanced, and without what was chosen (None where no weight was)."""
    cranks = [0.0] * len(job.cranks)
    for k, one in enumerate(job.cylinders, start=1):
        cranks[one.throw] = _number(outcome, f"cylinders.{k}.crank")
    x: list[float] = [_number(outcome, one.name) for one in free_shares(job)]
    for index in free_weights(job):
        path = f"{job.weights[index].family}.{job.weights[index].name}"
        u = _number(outcome, f"{path}.unbalance") * np.exp(1j * _number(outcome, f"{path}.angle"))
        x += [float(u.real), float(u.imag)]
    found = arms(job, cranks)
    return found.at(np.array(x)), found.at(np.zeros(len(x))) if x else None


def _number(outcome: Answer[EngineJob], path: str) -> float:
    value = outcome.values[path].value
    return value if isinstance(value, float) else 0.0


def _star(outcome: Answer[EngineJob], job: EngineJob) -> Disc:
    """Cranks seen from the end, cylinders on one angle together."""
    at: dict[float, list[str]] = {}
    for k in range(1, len(job.cylinders) + 1):
        angle = round(_number(outcome, f"cylinders.{k}.crank"), 9)
        at.setdefault(angle, []).append(str(k))
    spots = tuple(Placed(angle, ", ".join(names)) for angle, names in at.items())
    return Disc("Cranks, by cylinder", 1, spots)


def _say_nil(axes: Any, outcome: Answer[EngineJob], job: EngineJob, drawn: list[str]) -> None:
    """What the pictures do not show, in words."""
    axes.axis("off")
    lines = [f"{len(job.cylinders)} cylinder{'s' * (len(job.cylinders) != 1)}, crank 1 at the top when the angle is 0°"]
    if "firing.order" in outcome.values:
        even = "even" if outcome.values["firing.even"].value == "yes" else "not even"
        lines.append(f"firing order {outcome.values['firing.order'].shown} ({even})")
    if "counterweight_share" in outcome.values:
        lines.append(f"counterweights carry {outcome.values['counterweight_share'].shown} of the reciprocating mass")
    for one in job.weights:
        path = f"{one.family}.{one.name}"
        if f"{path}.unbalance" in outcome.values:
            size, angle = (outcome.values[f"{path}.{key}"].shown for key in ("unbalance", "angle"))
            lines.append(f"{one.name}: {size} at {angle}")
    lines += [f"no {word} is left" for _, word, _ in _KINDS if word not in drawn]
    axes.text(0.0, 0.5, "\n".join(lines), transform=axes.transAxes, va="center", fontsize=SIZE, color=INK, wrap=True)


def _draw_turn(
    axes: Any, after: ComplexArray, before: ComplexArray | None, couple: bool, word: str, dimension: str
) -> None:
    turn: FloatArray = np.linspace(0.0, 2.0 * np.pi, 361)
    values = [np.abs(over_turn(one, couple, turn)) for one in (after, before) if one is not None]
    unit = best_unit(float(max(one.max() for one in values)), dimension)
    dress(axes, f"Size of the {word} over a turn", "crank angle [deg]", f"{word} [{unit}]")
    for sizes, look in zip(
        values,
        ({"color": BLUE, "ls": "-", "lw": 1.8}, {"color": FAINT, "ls": "--", "lw": 1.4}),
        strict=False,
    ):
        axes.plot(np.degrees(turn), [to_unit(float(one), unit, dimension) for one in sizes], **look)
    axes.set_xticks(np.arange(0, 361, 60))
    axes.set_xlim(0.0, 360.0)
    axes.set_ylim(bottom=0.0)


def _draw_orders(
    axes: Any, after: ComplexArray, before: ComplexArray | None, couple: bool, word: str, dimension: str
) -> None:
    """Greatest of each order; orders too small to be seen are left out."""
    found = [one for one in (before, after) if one is not None]
    orders = [1, *range(2, after.shape[2], 2)]
    sizes = [[of_order(one, couple, order) for order in orders] for one in found]
    top = max(max(one) for one in sizes)
    kept = [k for k in range(len(orders)) if max(one[k] for one in sizes) > VISIBLE * top] or [0]
    unit = best_unit(top, dimension)
    dress(axes, "By order, greatest over a turn", "order (times crank speed)", f"{word} [{unit}]")
    place = np.arange(len(kept))
    for index, one in enumerate(sizes):
        look = AFTER if index == len(sizes) - 1 else BEFORE
        shift = 0.0 if len(sizes) == 1 else 0.4 * index - 0.2
        axes.bar(place + shift, [to_unit(one[k], unit, dimension) for k in kept], 0.38, zorder=3, **look)
    axes.set_xticks(place, [str(orders[k]) for k in kept])
    axes.set_xlim(-0.7, max(len(kept) - 0.3, 2.3))
    axes.grid(False, axis="x")
