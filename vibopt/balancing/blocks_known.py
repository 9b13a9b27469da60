"""Known masses on a shaft in blocks: what to fit, and unbalance and bearing reactions before and after."""

from __future__ import annotations

from vibopt.answer.answer import Answer
from vibopt.answer.blocks import FOOT, TODO, Block, rows_of, table
from vibopt.balancing.known.job import KnownJob, Spot
from vibopt.units import show


def known_blocks(outcome: Answer[KnownJob]) -> list[Block]:
    """What the answer for known masses says, in the order in which it is needed."""
    job = outcome.job
    planes = [one for one in job.spots if outcome.status != "infeasible"]
    return [
        Block("What to do", TODO, tuple(plane_words(outcome, one) for one in planes)),
        _planes(outcome, planes), _left(outcome, job), *rows_of(outcome),
        Block("Conventions", FOOT, job.notes),
        Block("Notes", FOOT, tuple(one for one in outcome.notes if one not in job.notes)),
        Block("Method", FOOT, (outcome.method,) if job.spots else ()),
    ]  # fmt: skip


def plane_words(outcome: Answer[KnownJob], spot: Spot) -> str:
    """The sentence for the shop floor."""
    plane, path = spot.plane, f"planes.{spot.plane.name}"
    value = outcome.values
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


def _planes(outcome: Answer[KnownJob], planes: list[Spot]) -> Block:
    rows = []
    for spot in planes:
        path = f"planes.{spot.plane.name}"
        cells = [outcome.values.get(f"{path}.{key}") for key in ("mass", "angle", "unbalance")]
        radius = show(spot.plane.radius, spot.plane.length_unit, "length") if spot.plane.radii else ""
        rows.append((spot.plane.name, *("" if one is None else one.shown for one in cells), radius))
    return table("Weights, each plane together", ("Plane", "Weight", "Angle", "Unbalance", "Radius"), rows)


def _left(outcome: Answer[KnownJob], job: KnownJob) -> Block:
    """Static and couple unbalance and each bearing's reaction, before and after."""
    keys = [("static unbalance", "static", "static_angle"), ("couple unbalance", "couple", "couple_angle")]
    keys += [
        (f"reaction of bearing {one.name}", f"bearings.{one.name}.reaction", f"bearings.{one.name}.angle")
        for one in job.bearings
    ]
    rows = []
    for words, size, angle in keys:
        cells = [_at(outcome, f"{when}.{size}", f"{when}.{angle}") for when in ("as_found", "residual")]
        if any(cells):
            rows.append((words, *cells))
    title = "As found and after" if job.spots else "As found"
    return table(title, ("", "As found", "After"), rows, whole=(1, 2))


def _at(outcome: Answer[KnownJob], size: str, angle: str) -> str:
    """ "27.91 N @ 190.9 deg" """
    if size not in outcome.values:
        return ""
    turned = f" @ {outcome.values[angle].shown}" if angle in outcome.values else ""
    return f"{outcome.values[size].shown}{turned}"
