"""Why no choice of parts will do, in words."""

from __future__ import annotations

from collections import Counter
from typing import Any

from vibopt.forms import ModeFrequency, StaticLoad
from vibopt.program.program import Limit, Program
from vibopt.solve.method import Found


def why_dropped(limit: Limit) -> str:
    """What stands against parts that a limit forbids, behind "12 of 60 parts"."""
    if isinstance(limit.form, StaticLoad):
        return "cannot carry the load" if limit.side == "at_most" else "are loaded less than they need"
    if isinstance(limit.form, ModeFrequency) and limit.side in ("at_most", "at_least"):
        return f"are too {'stiff' if limit.side == 'at_most' else 'soft'} for {limit.name}"
    return f"break {limit.name}"


def reason_of(program: Program, found: Found) -> str:
    """Parts that cannot be used, and the choice that comes nearest."""
    sentences = [*_tables(program, found), _near(program, found.details.get("nearest"))]
    return " ".join(one for one in sentences if one)


def _tables(program: Program, found: Found) -> list[str]:
    sentences = []
    for tie in program.ties:
        mine = [one for one in found.details["rows"] if one["path"] == tie.path]
        kinds = Counter((one["limit"], one["side"]) for one in mine if one["alone"])
        words = [f"{count} {why_dropped(_limit(program, *key))}" for key, count in kinds.most_common()]
        if list(kinds.values()) == [len(tie.names)]:
            (key,) = kinds
            sentences.append(f"{tie.path}: no part will do: all {len(mine)} {why_dropped(_limit(program, *key))}.")
        elif words:
            sentences.append(f"{tie.path}: of {len(tie.names)} parts {', '.join(words)}.")
    return sentences


def _limit(program: Program, name: str, side: str) -> Limit:
    return next(one for one in program.limits if (one.name, one.side) == (name, side))


def _near(program: Program, near: dict[str, Any] | None) -> str:
    if near is None:
        return ""
    tied = {axis for tie in program.ties for axis in tie.axes}
    others = [
        f"{axis.path} = {value:.4g}"
        for i, (axis, value) in enumerate(zip(program.axes, near["x"], strict=True))
        if i not in tied
    ]
    chosen = ", ".join([*(f"{path} = {name}" for path, name in near["parts"].items()), *others])
    limit = _limit(program, near["limit"], near["side"])
    percent = f"{100.0 * near['missed']:.3g} %"
    if isinstance(limit.form, StaticLoad):
        if limit.side == "at_least" and near["missed"] > 1.0:
            return f"The nearest is {chosen}: a mount of {limit.name.split(':')[0]} is lifted."
        over = "above" if limit.side == "at_most" else "below"
        return f"The nearest is {chosen}: its load is {percent} {over} its rating."
    return f"The nearest is {chosen}: it misses {limit.name} by {percent}."


__all__ = ["reason_of", "why_dropped"]
