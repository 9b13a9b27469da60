"""A drawn scene through the command line: what `check`, `solve` and an analysis of the saved design say of it."""

from __future__ import annotations

import copy
import json
import math
from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass, replace
from io import StringIO
from itertools import islice
from pathlib import Path
from typing import Any

from asking import Table, beside, closed
from draw import Draw
from machines import Drawn
from vibopt.answer.answer import EXIT_CODES
from vibopt.cli.main import main
from vibopt.document.toml_writing import document_toml
from vibopt.errors import InputError
from vibopt.scene.read import from_dict
from vibopt.scene.scene import Variable
from vibopt.solve import solve
from vibopt.verify.measured_goal import MEASURED

CODES = {**EXIT_CODES, "input_error": 2}
GAP = 1e-5
"""Part of a goal by which a sampled design may seem better than one proven best: its gap is 1e-6."""
AGAIN = 1e-6
"""Part of a value by which a saved design may differ when it is measured again."""
_DESIGN = ("optimal", "feasible", "met")
_OPEN = ("optimal", "feasible", "infeasible", "unproven")


@dataclass(frozen=True)
class Said:
    """What a command printed, as JSON, and its exit code."""

    code: int
    data: dict[str, Any]


def said(*words: str) -> Said:
    """Run one command with --json; strict JSON or nothing."""
    out, err = StringIO(), StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        code = main([*words, "--json"])
    return Said(code, json.loads(out.getvalue(), parse_constant=_no_json))


def _no_json(word: str) -> None:
    raise AssertionError(f"the answer holds {word}, which is no JSON")


_TOO_LONG = "The machine moves to and fro more often while a load lasts than is followed."


def judged(made: Drawn, seed: int, tried: int = 10) -> str:
    """The status of a scene, if everything said about it agrees; an assertion fails where it does not.

    So many designs are `tried` against what is said of the best.
    """
    file = made.folder / "scene.toml"
    file.write_text(document_toml(made.document), encoding="utf-8")
    checked = said("check", str(file))
    find_all = "find_all" in made.document.get("goal", {})
    saved = made.folder / "saved.toml"
    prices = [] if seed % 10 == 0 else ["--no-prices"]
    answer = said("solve", str(file), *prices, *([] if find_all else ["--save", str(saved)]))
    status = answer.data["status"]
    assert status != "check_failed", answer.data["claim"]
    assert answer.code == CODES[status], f"exit code {answer.code} with {status}: {answer.data.get('messages')}"
    followed = _TOO_LONG not in "".join(answer.data.get("messages", []))  # how long, only an answer finds out
    assert checked.code == (2 if status == "input_error" and followed else 0), (checked.data, answer.data["messages"])
    if status in _DESIGN and not find_all:
        _measured_again(answer.data, saved)
    if status in ("met", "infeasible") and find_all:
        _every_speed(made, answer.data, Draw(seed), tried)
    if status in _OPEN and made.document.get("goal") and not find_all:
        _sampled(made, answer.data, Draw(seed), tried)
    return str(status)


def _measured_again(answer: dict[str, Any], saved: Path) -> None:
    """The saved design is an analysis that meets every limit, with the same values."""
    again = said("solve", str(saved), "--no-prices")
    assert again.data["status"] == "met", (again.data["status"], again.data.get("messages"), again.data.get("limits"))
    for name, one in answer["limits"].items():
        _same(f"limits.{name}", one["value"], again.data["limits"][name]["value"], one.get("limit"))
    if answer["goal"] is not None:
        word = MEASURED[answer["goal"]["sense"]]
        _same("goal", answer["goal"]["value"], again.data["measures"][word]["value"], None)


def _same(what: str, one: Any, other: Any, bound: Any) -> None:
    if isinstance(one, str) or isinstance(other, str) or one is None or other is None:
        assert one == other, f"{what} is {one}, and {other} measured again"
        return
    size = max(abs(one), abs(other), abs(bound) if isinstance(bound, float) else 0.0)
    assert abs(one - other) <= AGAIN * size + 1e-12, f"{what} is {one!r}, and {other!r} measured again"


def _sampled(made: Drawn, answer: dict[str, Any], draw: Draw, tried: int) -> None:
    """No sampled design meets all limits where none should, nor beats one that is proven best."""
    status = answer["status"]
    for typed in islice(samples(made, answer, draw), tried):
        found = typed_in(made, typed)
        if found is None or found[0] != "met":
            continue
        assert status != "infeasible", f"infeasible, but {typed} meets every limit"
        if status == "optimal":
            best, value = _number(answer["goal"]["value"]), found[1]
            sign = 1.0 if answer["goal"]["sense"] == "minimise" else -1.0
            room = GAP * max(abs(best), 1e-12) if math.isfinite(best) else 0.0
            assert sign * value >= sign * best - room, f"optimal at {best!r}, but {typed} gives {value!r}"


def _every_speed(made: Drawn, answer: dict[str, Any], draw: Draw, tried: int) -> None:
    """A sampled speed meets all limits where it lies in the set that was found, and elsewhere does not."""
    path = made.document["goal"]["find_all"]
    shaker = path.removesuffix(".speed").removeprefix("excitations.")
    found = [[end["value"] for end in pair] for pair in answer["set"] or ()]
    top = from_dict(beside(made, made.document)).excitations[shaker].speed.highest
    inside = [low + part * (high - low) for low, high in found for part in (0.01, 0.99)]
    for speed in [*inside, *(top * draw.random.random() ** power for power in (1, 4) for _ in range(tried))]:
        if any(abs(speed - end) <= GAP * max(end, 1e-6 * top) for pair in found for end in pair):
            continue
        document = copy.deepcopy(made.document)
        del document["goal"]
        document["excitations"][shaker]["speed"] = f"{speed!r} rad/s"
        status = solve(from_dict(beside(made, document))).status
        within = any(low <= speed <= high for low, high in found)
        assert (status == "met") is within, f"{path} = {speed!r} rad/s is {status}, but permitted are {found}"


def _number(given: Any) -> float:
    return {"infinite": math.inf, "minus infinite": -math.inf}.get(given, given) if isinstance(given, str) else given


def samples(made: Drawn, answer: dict[str, Any], draw: Draw) -> Iterator[dict[str, Any]]:
    """Values by path: some anywhere in the ranges, some near the design."""
    scene = from_dict(beside(made, made.document))
    own = [one for one in scene.variables if ".part." not in one.path and not _bought(made, one.path)]
    parts = list(_parts(made))
    places = dict(_places(made.document))
    for index in range(10):
        typed: dict[str, Any] = {}
        for one in own:
            chosen = answer["variables"].get(one.path)
            near = chosen["value"] if chosen is not None and index % 2 else None
            typed[one.path] = _value(draw, one, near)
        typed |= {f"{path}.name": draw.pick(names) for path, names in parts}
        yield {**typed, **{path: draw.pick(among) for path, among in places.items()}}


def _bought(made: Drawn, path: str) -> bool:
    family, name = path.split(".")[:2]
    return "part" in made.document[family][name] and not path.endswith(".count")


def _parts(made: Drawn) -> Iterator[tuple[str, list[str]]]:
    for family in ("links", "mounts"):
        for name, table in made.document.get(family, {}).items():
            if "part" in table and "name" not in table["part"]:
                rows = made.files[table["part"]["catalogue"]].decode().splitlines()[1:]
                yield f"{family}.{name}.part", table["part"].get("only") or [row.split(",")[0] for row in rows]


def _places(document: Table) -> Iterator[tuple[str, list[Any]]]:
    for family, key in (("absorbers", "on"), ("mounts", "at")):
        for name, table in document.get(family, {}).items():
            if isinstance(table[key], dict):
                yield f"{family}.{name}.{key}", table[key]["one_of"]


def _value(draw: Draw, one: Variable, near: float | None) -> float:
    if one.values is not None:
        return draw.pick(one.values)
    high = one.high if math.isfinite(one.high) else 1e3 * max(one.low, 1.0)
    low = one.low if one.low > 0.0 else 1e-3 * high
    if near is not None:
        return min(max(near * (1.0 + draw.pick([-1, 1]) * draw.size(1e-6, 0.1)), low), high)
    return float(low * (high / low) ** draw.random.random())


def typed_in(made: Drawn, typed: dict[str, Any]) -> tuple[str, float] | None:
    """Status and goal of an analysis of the scene with values typed in; None where a value does not fit the rest."""
    document = copy.deepcopy(made.document)
    scene = from_dict(beside(made, made.document))
    units = {one.path: one for one in scene.variables}
    for path, value in typed.items():
        *steps, last = path.split(".")
        holder: Any = document
        for step in steps:
            holder = holder[_step(holder, step)]
        key = _step(holder, last)
        if last == "name":
            holder.pop("only", None)  # a part has one of the two
        was = holder.get(key) if isinstance(holder, dict) else holder[key]
        loose = was.get("tolerance") if isinstance(was, dict) else None
        text = _text(units[path], value) if path in units else value
        holder[key] = {"value": text, "tolerance": loose} if loose else text
    goal = document.pop("goal")
    sense = next(iter(goal))
    words = {key: value for key, value in goal.items() if key != sense}
    worst = "greatest" if sense == "minimise" else "least"
    document.setdefault("measures", {})["aim"] = {"response": goal[sense], **words, "worst": worst}
    try:
        found = solve(from_dict(beside(replace(made, document=document), document)))
    except InputError:
        return None
    return found.status, found.measures["aim"].value.value


def _step(holder: Any, step: str) -> Any:
    """Where a step of a path leads: x, y and z of three values stand in a list."""
    return "xyz".index(step) if isinstance(holder, list) else step


def _text(one: Variable, value: float) -> Any:
    from vibopt.units import si_unit

    unit = si_unit(one.dimension)
    return f"{value!r} {unit}" if unit else (round(value) if one.dimension == "count" else value)


__all__ = ["Said", "closed", "judged", "said"]
