"""The method for parts of catalogues: nothing is better than its answer, and nine next best stand beside it.

Where no choice meets every limit, the one that comes nearest is told.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from vibopt.arrays import FloatArray, IntArray
from vibopt.errors import counted
from vibopt.program.program import Program
from vibopt.solve.catalogue.choices import Node, factors_of
from vibopt.solve.catalogue.part_search import COST, LEAF, MOST_STEPS, Pick, Search
from vibopt.solve.catalogue.pointwise import fails
from vibopt.solve.method import Found, Progress
from vibopt.work import Budget

KEEP = 10
MOST = 10**12


class Catalogue:
    """Every combination of parts, counts and other listed values; proves the best of them, or that none will do."""

    name = "catalogue"
    summary = "branch and bound over the rows of catalogues, with exact peaks"

    def __init__(self, keep: int = KEEP, most: int = MOST_STEPS) -> None:
        self.keep = keep
        self.most = most

    def refuses(self, program: Program) -> str | None:
        if not program.ties:
            return "no part of a catalogue is to be chosen."
        ranged = program.ranged
        if ranged is not None:
            return (
                f"{ranged.path} may be any value of a range, but beside parts of a catalogue only listed values are "
                f"chosen from. Write one value, or one_of = [...]."
            )
        many = 1
        for factor in factors_of(program):
            many *= len(factor.table)
        if many > MOST:
            return f"{many:.1e} combinations of parts are too many. Leave fewer with only = [...]."
        return None

    def solve(self, program: Program, progress: Progress | None = None) -> Found:
        """Status "optimal" or "infeasible", both proven; else what is left when its budget is spent."""
        search = Search(program, self.keep, Budget(self.most, "steps", COST), progress)
        search.run()
        details = self._details(program, search)
        every = counted(search.total, "combinations of parts")
        if not search.best:
            if search.stopped:
                claim = f"nothing found and nothing proven: stopped after {search.looked} of {every}"
                return Found("unproven", None, claim, self.name, details=details)
            details["nearest"] = nearest(search)
            claim = f"proven: {'each of ' * (search.total != 1)}{every} breaks a limit"
            return Found("infeasible", None, claim, self.name, details=details)
        first = search.best[0]
        if search.stopped:
            claim = f"the best of {search.looked} looked at one by one, of {every}; not proven"
            return Found("feasible", first.x, claim, self.name, details=details)
        claim = f"proven: none of {every} is better"
        return Found("optimal", first.x, claim, self.name, first.goal, details)

    def _details(self, program: Program, search: Search) -> dict[str, Any]:
        tally = search.tally
        kinds = _kinds(program)
        return {
            "combinations": search.total,
            "measured": tally.measured,
            "mirrored": tally.mirrored,
            "dropped": [
                {"limit": name, "side": side, "combinations": round(float(tally.limits[own].sum()))}
                for (name, side), own in kinds.items()
                if tally.limits[own].any()
            ],
            "rows": _rows(program, search),
            "picks": [_pick(search, pick) for pick in search.best],
        }


def _kinds(program: Program) -> dict[tuple[str, str], list[int]]:
    """Limits by name and side: the mounts of a group share theirs."""
    found: dict[tuple[str, str], list[int]] = {}
    for index, limit in enumerate(program.limits):
        found.setdefault((limit.name, limit.side), []).append(index)
    return found


def _pick(search: Search, pick: Pick) -> dict[str, Any]:
    chosen = zip(search.choices.factors, pick.entries, strict=True)
    return {
        "parts": {factor.path: factor.names[entry] for factor, entry in chosen if factor.names},
        "x": [float(one) for one in pick.x],
        "goal": pick.goal,
        "tightest": pick.tightest,
        "margin": pick.margin,
    }


def _rows(program: Program, search: Search) -> list[dict[str, Any]]:
    """Parts that no combination can use, each with the limit that stands against it most often."""
    found = []
    for index, factor in enumerate(search.choices.factors):
        whole = search.total / len(factor.table)
        table = search.tally.rows[index]
        for entry, name in enumerate(factor.names):
            if table[entry].sum() < whole * (1.0 - 1e-9) - 0.5:
                continue
            counts = {kind: float(table[entry, own].sum()) for kind, own in _kinds(program).items()}
            limit, side = max(counts, key=lambda kind: counts[kind])
            alone = counts[limit, side] >= whole - 0.5
            found.append({"path": factor.path, "part": name, "limit": limit, "side": side, "alone": alone})
    return found


_LOOKED = 40
_MOST, _MOST_SEVERAL = 2_000_000, 20_000


def nearest(search: Search) -> dict[str, Any] | None:
    """The choice whose worst miss, by the weights of the limits, is least; of more than two million among a part.

    Of limits on several machines there are too many to ask all of them of that many choices.
    """
    node, exact = _thinned(search)
    chosen = search.choices.all_in(node)
    misses = np.concatenate([_misses(search, search.choices.designs(part)) for part in _parts(chosen)])
    order = np.argsort(misses, kind="stable")
    best: tuple[float, int, int] | None = None
    soft = np.array([limit.soft for limit in search.program.limits])
    for count, index in enumerate(order):
        if best is not None and (misses[index] >= best[0] or count >= _LOOKED):
            exact = exact and misses[index] >= best[0]
            break
        x = search.choices.designs(chosen[index][None, :])[0]
        found = np.array([search.judge.limit(limit, x)[0] for limit in search.program.limits]) / soft
        worst = int(np.argmax(found))
        if best is None or found[worst] < best[0]:
            best = (float(found[worst]), int(index), worst)
    if best is None or not np.isfinite(best[0]):
        return None
    missed, index, worst = best
    limit = search.program.limits[worst]
    pairs = zip(search.choices.factors, chosen[index], strict=True)
    return {
        "parts": {factor.path: factor.names[entry] for factor, entry in pairs if factor.names},
        "x": search.choices.designs(chosen[index][None, :])[0].tolist(),
        "limit": limit.name,
        "side": limit.side,
        "missed": missed * limit.soft,
        "proven": exact,
    }


def _misses(search: Search, x: FloatArray) -> FloatArray:
    """Lower bound of the worst miss of each design as a part of its bound, divided by the weight of the limit."""
    table = [
        fails(limit, values, x, 0.0) / limit.soft
        for limit, values in zip(search.program.limits, search.limits, strict=True)
    ]
    most: FloatArray = np.max(table, axis=0)
    return most


def _parts(chosen: IntArray) -> list[IntArray]:
    return [chosen[at : at + LEAF] for at in range(0, len(chosen), LEAF)]


def _thinned(search: Search) -> tuple[Node, bool]:
    """All choices, or where they are too many every second, third, ... row."""
    node, step = search.choices.root, 1
    most = _MOST_SEVERAL if search.program.several else _MOST
    while node.size > most:
        step += 1
        node = Node(tuple(entry[::step] for entry in search.choices.root.entries))
    return node, step == 1
