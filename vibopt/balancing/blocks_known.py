"""Tables of shafts with known masses, as blocks."""

from __future__ import annotations

from dataclasses import replace

from vibopt.answer.answer import Answer
from vibopt.answer.blocks import FOOT, TEXT, TODO, Block, nearest_block, rows_of, table
from vibopt.answer.entry import Entry, Value, in_one_unit
from vibopt.balancing.known.known_job import KnownJob
from vibopt.balancing.planes import Plane
from vibopt.units import show

SMALL = 1e-6
"""Part of what there was, or of all together, below which the rest is nothing."""


def known_blocks(outcome: Answer[KnownJob]) -> list[Block]:
    """What the answer for known masses says, in the order in which it is needed."""
    job = outcome.job
    planes = [one for one in job.planes if outcome.status != "infeasible"]
    return [
        *known_nearest(outcome),
        Block("What to do", TODO, tuple(plane_words(outcome, one) for one in planes)),
        _planes(outcome, planes), _left(outcome, job), *(rows_of(outcome) if outcome.nearest is None else ()),
        Block("Conventions", FOOT, job.notes),
        Block("Notes", FOOT, tuple(one for one in outcome.notes if one not in job.notes)),
        Block("Method", FOOT, (outcome.method,) if job.planes else ()),
    ]  # fmt: skip


def known_nearest(outcome: Answer[KnownJob]) -> list[Block]:
    """The weights that miss the limits least, and how far each is missed."""
    if outcome.nearest is None:
        return []
    near = replace(outcome, values=outcome.nearest.values)
    words = tuple(plane_words(near, one) for one in outcome.job.planes)
    return [Block("The nearest weights", TEXT, words), nearest_block(outcome)]


def plane_words(outcome: Answer[KnownJob], plane: Plane) -> str:
    """The sentence for the shop floor."""
    path, value = f"planes.{plane.name}", outcome.values
    if plane.keep:
        return f"{plane.name}: leave untouched."
    angle = value.get(f"{path}.angle")
    if angle is None:
        return f"{plane.name}: no weight."
    verb = "take away" if plane.remove else "fit"
    where = f" at radius {show(plane.radius, plane.length_unit, 'length')}" if plane.radii else ""
    if f"{path}.weights" in value:
        return f"{plane.name}: {verb} {value[f'{path}.weights'].shown.replace(', ', ' and ')}{where}."
    amount = value.get(f"{path}.mass", value[f"{path}.unbalance"])
    depth = f", hole {value[f'{path}.depth'].short(3)} deep" if f"{path}.depth" in value else ""
    return f"{plane.name}: {verb} {amount.shown}{where}, {angle.shown} from zero{depth}."


def _planes(outcome: Answer[KnownJob], planes: list[Plane]) -> Block:
    rows = []
    for plane in planes:
        path = f"planes.{plane.name}"
        cells = [outcome.values.get(f"{path}.{key}") for key in ("mass", "angle", "unbalance")]
        radius = show(plane.radius, plane.length_unit, "length") if plane.radii else ""
        rows.append((plane.name, *("" if one is None else one for one in cells), radius))
    return table("Weights, each plane together", ("Plane", "Weight", "Angle", "Unbalance", "Radius"), rows)


def _left(outcome: Answer[KnownJob], job: KnownJob) -> Block:
    """Static and couple unbalance and each bearing's reaction, before and after."""
    keys = [("static unbalance", "static", "static_angle"), ("couple unbalance", "couple", "couple_angle")]
    keys += [
        (f"reaction of bearing {one.name}", f"bearings.{one.name}.reaction", f"bearings.{one.name}.angle")
        for one in job.bearings
    ]
    times = ("as_found", "residual")
    sizes = [[outcome.values.get(f"{when}.{size}") for when in times] for _, size, _ in keys]
    sizes = [[one if one is None else without_rest(one, SMALL * size_of(row[0])) for one in row] for row in sizes]
    shown = in_one_unit("" if one is None else one for row in sizes for one in row)
    rows = []
    for number, (words, _, angle) in enumerate(keys):
        pair = shown[2 * number : 2 * number + 2]
        cells = [_at(outcome, one, f"{when}.{angle}") for one, when in zip(pair, times, strict=True)]
        if any(cells):
            rows.append((words, *cells))
    after = bool(job.planes) and outcome.status != "infeasible"
    heads = ("", "As found", "After") if after else ("", "As found")
    return table(
        "As found and after" if after else "As found", heads, [row[: len(heads)] for row in rows], whole=(1, 2)
    )


def _at(outcome: Answer[KnownJob], size: str | Value, angle: str) -> str:
    """ "27.91 N @ 190.9 deg" """
    if isinstance(size, str):
        return size
    nothing = isinstance(size, Entry) and size.value == 0.0
    turned = f" @ {outcome.values[angle].shown}" if angle in outcome.values and not nothing else ""
    return f"{size.shown}{turned}"


def size_of(entry: Value | None) -> float:
    return entry.value if isinstance(entry, Entry) else 0.0


def without_rest(entry: Value, least: float) -> Value:
    """A value; zero where it is less than a millionth of all together."""
    return replace(entry, value=0.0) if isinstance(entry, Entry) and entry.value < least else entry
