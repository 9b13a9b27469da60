"""Choices from catalogues in an answer: the best ones, what was dropped and why, what free values would do."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import Any

from vibopt.answer.entry import Entry
from vibopt.errors import counted
from vibopt.program.pose import RATED
from vibopt.report.machine_words import THOROUGH
from vibopt.scene.places import bound_parts
from vibopt.scene.scene import MINIMISE, Design, Scene
from vibopt.units import show
from vibopt.values import Fact
from vibopt.verify.checked import in_usual_unit

MOST_NAMES = 6
"""Names of parts that are listed in a line; JSON has all of them."""


def tied(scene: Scene) -> dict[str, str]:
    """Path of the part of every number that a part brings."""
    return {path: part.path for part in bound_parts(scene) for path in part.paths}


def choices_of(design: Design) -> list[dict[str, Any]]:
    """The best choices, the first of them the answer; empty where no catalogue was asked."""
    return [_choice(design.scene, pick) for pick in design.details.get("picks", ())]


def _choice(scene: Scene, pick: Mapping[str, Any]) -> dict[str, Any]:
    chosen = scene.named(pick["x"])
    inner = tied(scene)
    values = {
        variable.path: Entry(chosen[variable.path], variable.dimension, variable.unit)
        for variable in scene.variables
        if variable.path not in inner
    }
    return {
        "parts": dict(pick["parts"]),
        "values": values,
        "goal": _goal(scene, pick["goal"]),
        "price": _price(scene, chosen),
        "tightest": pick["tightest"],
        "margin": pick["margin"],
    }


def _goal(scene: Scene, value: float) -> Entry | None:
    """A goal as a search counts it, as the user does."""
    if scene.goal is None:
        return None
    response = scene.goal.response
    size = value if (scene.goal.sense == MINIMISE) != response.complement else -value
    return in_usual_unit(scene, response, 1.0 - size if response.complement else size)


def _price(scene: Scene, chosen: Mapping[str, float]) -> Entry | None:
    """What all bought parts cost together; None where a catalogue has no prices."""
    total, unit = 0.0, ""
    bought = {f"links.{name}": (link.part, link.count) for name, link in scene.links.items()}
    bought |= {f"mounts.{name}": (mount.part, Fact(mount.count, "")) for name, mount in scene.mounts.items()}
    for path, (part, count) in bought.items():
        if part is None:
            continue
        if part.price is None:
            return None
        price = part.price
        one = chosen.get(f"{path}.part.price", getattr(price, "value", 0.0))
        many = chosen.get(f"{path}.count", getattr(count, "value", 1.0))
        total, unit = total + one * many, price.unit
    return Entry(total, "price", unit) if unit else None


def parts_words(scene: Scene, choice: Mapping[str, Any]) -> str:
    """A choice as one would order it: "4 x S75-60 (feet)"."""
    words = []
    for path, name in choice["parts"].items():
        owner = path.rsplit(".", 1)[0]
        given = choice["values"].get(f"{owner}.count")
        count = given.shown if given is not None else _count_of(scene, owner)
        words.append(f"{f'{count} x ' if count else ''}{name} ({owner.split('.', 1)[1]})")
    return ", ".join(words)


def _count_of(scene: Scene, owner: str) -> str:
    """Number of mounts in a group as the file says it; "" where it does not."""
    family, name = owner.split(".", 1)
    count = getattr(getattr(scene, family)[name], "count", None)
    return f"{getattr(count, 'value', count):g}" if count is not None else ""


def choice_rows(design: Design) -> list[tuple[str, str, str, str]]:
    """The best choices as a table: what to order, the goal, the price, the tightest limit."""
    rows = []
    by_price = design.scene.goal is not None and design.scene.goal.name == "price"
    for one in choices_of(design):
        price = one["price"].shown if one["price"] is not None and not by_price else ""
        goal = one["goal"].shown if one["goal"] is not None else ""
        tight = f"{one['tightest']} {show(one['margin'], '%', 'ratio', digits=3)}"
        rows.append((parts_words(design.scene, one), goal, price, tight))
    return rows


def dropped_rows(design: Design) -> list[tuple[str, str]]:
    """What was looked at, what was dropped by which limit, and the parts that can never be used."""
    details = design.details
    if "combinations" not in details:
        return []
    rows = [("combinations", f"{details['combinations']}, of which {details['measured']} were measured exactly")]
    rows += [
        (f"{one['limit']}{' (at least)' if one['side'] == 'at_least' else ''}", f"drops {one['combinations']}")
        for one in details["dropped"]
    ]
    if details["mirrored"]:
        rows.append(("mirror images", f"{details['mirrored']} are the same with two groups exchanged"))
    return rows + _never(design)


def _never(design: Design) -> list[tuple[str, str]]:
    """Per part to be chosen the parts of the catalogue that no combination can use."""
    rows = []
    for bound in bound_parts(design.scene):
        mine = [one for one in design.details["rows"] if one["path"] == bound.path]
        kinds = Counter((one["limit"], one["side"], one["alone"]) for one in mine)
        for kind, count in kinds.most_common():
            names = [one["part"] for one in mine if (one["limit"], one["side"], one["alone"]) == kind]
            said = ", ".join(names[:MOST_NAMES]) + (", ..." if count > MOST_NAMES else "")
            rows.append((bound.path, f"{count} of {counted(len(bound.names), 'parts')} {why(*kind)}: {said}"))
    return rows


def why(limit: str, side: str, alone: bool) -> str:
    """What stands against parts, by the limit that forbids them `alone` or most often."""
    if not alone:
        return f"are in no combination that will do, mostly for {limit}"
    if limit.endswith(RATED):
        return "cannot carry the load" if side == "at_most" else "are loaded less than they need"
    return f"break {limit} whatever goes with them"


def free_words(design: Design) -> str:
    """What stiffness and damping at will would do, beside what was bought; "" where it was not asked."""
    free = design.details.get("free")
    if not free or design.goal is None:
        return ""
    if free["status"] == "unproven":
        return f"not worked out ({free['claim']}). {THOROUGH} searches further."
    goal = _goal(design.scene, free["goal"])
    assert goal is not None
    units = {variable.path: variable for variable in design.scene.variables}
    values = ", ".join(
        f"{path} {show(value, units[path].unit, units[path].dimension)}" for path, value in free["values"].items()
    )
    proof = "proven" if free["status"] == "optimal" else "the best found"
    proof += ", with nothing off" if design.tolerances is not None else ""
    return f"{design.goal[0]} {goal.shown} instead of {design.goal[1].shown}, with {values} ({proof})"
