"""Tables of shafts with known masses and of engines, as blocks."""

from __future__ import annotations

from cmath import rect
from collections.abc import Iterator, Mapping
from dataclasses import replace
from math import pi
from typing import Any

from vibopt.answer.answer import Answer
from vibopt.answer.blocks import FOOT, TEXT, TODO, Block, nearest_block, rows_of, table
from vibopt.answer.entry import Entry, Value, direction_of, in_one_unit
from vibopt.balancing.blocks_rotor import nearest_blocks
from vibopt.balancing.engine.engine_job import EngineJob, Weight
from vibopt.balancing.impasses import NOTHING_FOUND
from vibopt.balancing.known.known_job import KnownJob
from vibopt.balancing.planes import Plane
from vibopt.records import dataclass
from vibopt.units import show
from vibopt.units.showing import show_angle

SMALL = 1e-6
"""Part of what there was, or of all together, below which the rest is nothing."""


def known_blocks(outcome: Answer[KnownJob]) -> list[Block]:
    """What the answer for known masses says, in the order in which it is needed."""
    job = outcome.job
    planes = [plane for plane in job.planes if outcome.status not in NOTHING_FOUND]
    return [
        *known_nearest(outcome),
        Block("What to do", TODO, tuple(answer.words for answer in outcome.plan.planes if planes)),
        _planes(outcome, planes), _left(outcome, job), *(rows_of(outcome) if outcome.nearest is None else ()),
        Block("Conventions", FOOT, job.notes),
        Block("Notes", FOOT, tuple(note for note in outcome.notes if note not in job.notes)),
        _method(outcome),
    ]  # fmt: skip


def _method(outcome: Answer[Any]) -> Block:
    """What answered; nothing where nothing is chosen."""
    return Block("Method", FOOT, (outcome.method,) if outcome.method not in ("", "none") else ())


def known_nearest(outcome: Answer[KnownJob]) -> list[Block]:
    """The same of known masses."""
    return nearest_blocks(outcome, "The nearest weights")


def _planes(outcome: Answer[KnownJob], planes: list[Plane]) -> Block:
    rows = []
    for plane in planes:
        path = f"planes.{plane.name}"
        cells = [outcome.values.get(f"{path}.{key}") for key in ("mass", "angle", "unbalance")]
        radius = show(plane.radius, plane.length_unit, "length") if plane.radii else ""
        rows.append((plane.name, *("" if cell is None else cell for cell in cells), radius))
    return table("Weights, each plane together", ("Plane", "Weight", "Angle", "Unbalance", "Radius"), rows)


def _left(outcome: Answer[KnownJob], job: KnownJob) -> Block:
    """Static and couple unbalance and each bearing's reaction, before and after."""
    keys = [("static unbalance", "static", "static_angle"), ("couple unbalance", "couple", "couple_angle")]
    keys += [
        (f"reaction of bearing {bearing.name}", f"bearings.{bearing.name}.reaction", f"bearings.{bearing.name}.angle")
        for bearing in job.bearings
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
    after = bool(job.planes) and outcome.status not in NOTHING_FOUND
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


def engine_blocks(outcome: Answer[EngineJob]) -> list[Block]:
    """What an engine's answer says, in the order in which it is needed."""
    job = outcome.job
    if outcome.status in NOTHING_FOUND:
        return [*engine_nearest(outcome), Block("Notes", FOOT, outcome.notes)]
    return [
        _build(outcome, job), _weights(outcome, job), _cranks(outcome, job), *_orders(outcome, job), *rows_of(outcome),
        Block("Notes", FOOT, outcome.notes), _method(outcome),
    ]  # fmt: skip


def engine_nearest(outcome: Answer[EngineJob]) -> list[Block]:
    """The weights and cranks that miss the limits least, and how far each is missed."""
    if outcome.nearest is None:
        return []
    near = replace(outcome, values=outcome.nearest.values)
    weights = replace(_weights(near, outcome.job), title="The nearest weights")
    cranks = replace(_cranks(near, outcome.job), title="Its cylinders")
    return [weights, cranks, nearest_block(outcome)]


@dataclass(frozen=True, slots=True)
class _Hung:
    """A weight that turns: what it is called, its unbalance [kg m] and angle as shown, and where it is.

    chosen
        Whether the answer chose it.
    said
        The sentence of who builds it, behind the name.
    """

    name: str
    size: str
    angle: str
    turns: str
    at: float | None
    chosen: bool
    said: str


def _hung(outcome: Answer[EngineJob], job: EngineJob) -> Iterator[_Hung]:
    """Counterweights opposite the cranks, then the weights that have names."""
    yield from _opposite(outcome, job)
    for weight in job.weights:
        yield _named(outcome, job, weight)


def _opposite(outcome: Answer[EngineJob], job: EngineJob) -> Iterator[_Hung]:
    """Of each throw the counterweight that its cylinders' shares come to, mass times radius."""
    if not job.shares:
        return
    parts, rounded = [outcome.values[share.name] for share in job.shares], _rounded(outcome)
    turning = "all" if parts[1].value == 1.0 else parts[1].shown
    some = [*([f"{parts[0].shown} of the reciprocating"] if size_of(parts[0]) else [])]
    some += (
        [f"{turning} of the rotating"]
        if size_of(parts[1]) and any(cylinder.rotating for cylinder in job.cylinders)
        else []
    )
    carries = f": {' and '.join(some)} mass" if some else ""
    for throw in dict.fromkeys(cylinder.throw for cylinder in job.cylinders):
        mine = {k: cylinder for k, cylinder in enumerate(job.cylinders, start=1) if cylinder.throw == throw}
        size = sum(
            size_of(part) * share.of(cylinder)
            for share, part in zip(job.shares, parts, strict=True)
            for cylinder in mine.values()
        )
        crank = size_of(outcome.values[f"cylinders.{next(iter(mine))}.crank"])
        angle, shown = direction_of(rect(1.0, crank + pi)).shown, show(size, "", "unbalance")
        places = {cylinder.at + job.reference for cylinder in mine.values()}
        yield _Hung(
            f"opposite crank {' and '.join(map(str, mine))}", shown, angle, "crank",
            places.pop() if len(places) == 1 else None,
            any(share.is_free or f"engine.{share.name}" in rounded for share in job.shares),
            f"a counterweight of {shown} (mass times radius){carries}" if size > 0.0 else "no counterweight",
        )  # fmt: skip


def _named(outcome: Answer[EngineJob], job: EngineJob, weight: Weight) -> _Hung:
    """A counterweight on the crankshaft or the weight of a balance shaft, as chosen or as given."""
    path = f"{weight.family}.{weight.name}"
    u = weight.fixed
    size = Entry(abs(u or 0.0), "unbalance", weight.unit) if u is not None else outcome.values[f"{path}.unbalance"]
    none = size_of(size) == 0.0
    angle = "" if none else (direction_of(u) if u is not None else outcome.values[f"{path}.angle"]).shown
    ways = f"{weight.order} x, {'with' if weight.sense > 0 else 'against'}"
    turns = "crank" if weight.order == 1 and weight.sense > 0 else ways
    at = show(weight.at + job.reference, "mm", "length")
    shaft = "" if weight.family == "counterweights" else f" (shaft turns {ways} the crank)"
    said = "no weight" if none else f"{size.shown} (mass times radius) at {at}, {angle} from zero{shaft}"
    chosen = u is None or f"{path}.unbalance" in _rounded(outcome)
    return _Hung(weight.name, size.shown, angle, turns, weight.at + job.reference, chosen, said)


def _rounded(outcome: Answer[EngineJob]) -> Mapping[str, Any]:
    """What was chosen and then rounded, by path: it stands in the job as given."""
    values: Mapping[str, Any] = outcome.details.get("rounded", {}).get("values", {})
    return values


def _build(outcome: Answer[EngineJob], job: EngineJob) -> Block:
    """The sentences for who builds it: every crank, counterweight and balance shaft that was chosen."""
    lines = [f"{hung.name}: {hung.said}." for hung in _hung(outcome, job) if hung.chosen]
    if job.is_search:
        cranks = [outcome.values[f"cylinders.{k}.crank"].shown for k in range(1, len(job.cylinders) + 1)]
        lines.insert(0, f"cranks of cylinders 1 to {len(cranks)}: {', '.join(cranks)}.")
    return Block("What to build", TODO, tuple(lines))


def _weights(outcome: Answer[EngineJob], job: EngineJob) -> Block:
    """What was chosen, and the weights that were given."""
    rows = [
        (hung.name, hung.size, hung.angle, hung.turns, "" if hung.at is None else show(hung.at, "mm", "length"),
         show(hung.at - job.reference, "mm", "length") if job.reference and hung.at is not None else "")
        for hung in _hung(outcome, job)
    ]  # fmt: skip
    heads = ("Weight", "Unbalance", "Angle", "Turns", "At", "From the reference")
    return table("Weights", heads, rows, whole=(2, 4, 5))


def _cranks(outcome: Answer[EngineJob], job: EngineJob) -> Block:
    rows = [
        (
            str(k),
            outcome.values[f"cylinders.{k}.crank"].shown,
            show_angle(cylinder.bank) if any(other.bank for other in job.cylinders) else "",
            show(cylinder.at, "mm", "length"),
        )
        for k, cylinder in enumerate(job.cylinders, start=1)
    ]
    return table("Cylinders", ("Cylinder", "Crank", "Bank", "From the reference"), rows)


def _orders(outcome: Answer[EngineJob], job: EngineJob) -> list[Block]:
    """Orders down to a millionth of all together, and the firing order."""
    values = outcome.values
    orders = sorted({int(path.split(".")[1]) for path in values if path.startswith("orders.")})
    least = {word: SMALL * size_of(values[f"all_orders.{word}"]) for word in ("force", "couple")}
    rows, hidden = [], []
    for order in orders:
        found = {word: values[f"orders.{order}.{word}"] for word in least}
        if order > 2 and all(size_of(one) <= least[word] for word, one in found.items()):
            hidden.append(str(order))
        else:
            rows.append((str(order), *(without_rest(one, least[word]) for word, one in found.items())))
    rows.append(("all together", *(without_rest(values[f"all_orders.{word}"], least[word]) for word in least)))
    lines = []
    if hidden:
        lines.append(f"Order{'s' * (len(hidden) > 1)} {', '.join(hidden)}: less than a millionth of all together.")
    if job.truncated:
        lines.append('Orders above 2 are left out, as kinematics = "truncated" says.')
    if "firing.order" in values:
        even = "even" if values["firing.even"].shown == "yes" else "not even"
        lines.append(f"Firing order {values['firing.order'].shown} ({even}).")
    heads = ("Order", "Force", "Couple")
    return [table("What still shakes, greatest over a turn", heads, rows), Block("Besides", TEXT, tuple(lines))]
