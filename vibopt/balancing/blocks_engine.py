"""An engine in blocks: cranks and weights, and what still shakes order by order."""

from __future__ import annotations

from dataclasses import replace

from vibopt.answer.answer import Answer
from vibopt.answer.blocks import FOOT, TEXT, Block, rows_of, table
from vibopt.answer.entry import Entry, Value
from vibopt.balancing.engine.job import EngineJob
from vibopt.units import show
from vibopt.units.showing import show_angle

SMALL = 1e-6


def engine_blocks(outcome: Answer[EngineJob]) -> list[Block]:
    """What an engine's answer says, in the order in which it is needed."""
    job = outcome.job
    if outcome.status == "infeasible":
        return [Block("Notes", FOOT, outcome.notes)]
    return [
        _weights(outcome, job), _cranks(outcome, job), *_orders(outcome, job), *rows_of(outcome),
        Block("Notes", FOOT, outcome.notes), Block("Method", FOOT, _method(outcome)),
    ]  # fmt: skip


def _method(outcome: Answer[EngineJob]) -> tuple[str, ...]:
    return (outcome.method,) if outcome.method not in ("", "none") else ()


def _weights(outcome: Answer[EngineJob], job: EngineJob) -> Block:
    """What was chosen, and the weights that were given."""
    rows = []
    if job.shares:
        parts = [outcome.values[share.name] for share in job.shares]
        turning = "all" if parts[1].value == 1.0 else parts[1].shown
        said = f"{parts[0].shown} of the reciprocating mass, and {turning} of the rotating"
        rows.append(("opposite each crank", said, "", "", "", ""))
    for one in job.weights:
        path = f"{one.family}.{one.name}"
        chosen = [outcome.values.get(f"{path}.{key}") for key in ("unbalance", "angle")]
        size, angle = (("", "") if entry is None else (entry.shown, "") for entry in chosen)
        if one.fixed is not None:
            size = (show(abs(one.fixed), one.unit, "unbalance"), "")
            angle = (_angle_of(one.fixed).shown, "")
        forward = one.sense > 0
        speed = "crank" if one.order == 1 and forward else f"{one.order} x, {'with' if forward else 'against'}"
        at, away = (show(place, "mm", "length") for place in (one.at + job.reference, one.at))
        rows.append((one.name, size[0], angle[0], speed, at, away if job.reference else ""))
    heads = ("Weight", "Unbalance", "Angle", "Turns", "At", "From the reference")
    return table("Weights", heads, rows, whole=(2, 4, 5))


def _angle_of(u: complex) -> Entry:
    from vibopt.answer.entry import direction_of

    return direction_of(u)


def _cranks(outcome: Answer[EngineJob], job: EngineJob) -> Block:
    rows = [
        (
            str(k),
            outcome.values[f"cylinders.{k}.crank"].shown,
            show_angle(one.bank) if any(other.bank for other in job.cylinders) else "",
            show(one.at, "mm", "length"),
        )
        for k, one in enumerate(job.cylinders, start=1)
    ]
    return table("Cylinders", ("Cylinder", "Crank", "Bank", "From the reference"), rows)


def _orders(outcome: Answer[EngineJob], job: EngineJob) -> list[Block]:
    """Orders down to a millionth of all together, and the firing order."""
    values = outcome.values
    orders = sorted({int(path.split(".")[1]) for path in values if path.startswith("orders.")})
    least = {word: SMALL * _size(values[f"all_orders.{word}"]) for word in ("force", "couple")}
    rows, hidden = [], []
    for order in orders:
        found = {word: values[f"orders.{order}.{word}"] for word in least}
        if order > 2 and all(_size(one) <= least[word] for word, one in found.items()):
            hidden.append(str(order))
        else:
            rows.append((str(order), *(_cell(one, least[word]) for word, one in found.items())))
    rows.append(("all together", *(_cell(values[f"all_orders.{word}"], least[word]) for word in least)))
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


def _size(entry: Value) -> float:
    return entry.value if isinstance(entry, Entry) else 0.0


def _cell(entry: Value, least: float) -> str:
    """A value; zero where it is less than a millionth of all together."""
    return replace(entry, value=0.0).shown if isinstance(entry, Entry) and entry.value < least else entry.shown


__all__ = ["SMALL", "engine_blocks"]
