"""What comes nearest where no choice meets every limit."""

from __future__ import annotations

from typing import Any

import numpy as np

from vibopt.forms import FloatArray, IntArray
from vibopt.solve.shelf.pointwise import fails
from vibopt.solve.shelf.search import LEAF, Search
from vibopt.solve.shelf.tree import Node

_LOOKED = 40
_MOST, _MOST_SEVERAL = 2_000_000, 20_000


def nearest(search: Search) -> dict[str, Any] | None:
    """The choice whose worst miss is least; exact where they are no more than two million, else among a part.

    Of limits on several machines there are too many to ask all of them of that many choices.
    """
    node, exact = _thinned(search)
    chosen = search.shelf.all_in(node)
    misses = np.concatenate([_misses(search, search.shelf.designs(part)) for part in _parts(chosen)])
    order = np.argsort(misses, kind="stable")
    best: tuple[float, int, int] | None = None
    for count, index in enumerate(order):
        if best is not None and (misses[index] >= best[0] or count >= _LOOKED):
            exact = exact and misses[index] >= best[0]
            break
        x = search.shelf.designs(chosen[index][None, :])[0]
        found = [search.judge.limit(limit, x)[0] for limit in search.program.limits]
        worst = int(np.argmax(found))
        if best is None or found[worst] < best[0]:
            best = (float(found[worst]), int(index), worst)
    if best is None or not np.isfinite(best[0]):
        return None
    missed, index, worst = best
    limit = search.program.limits[worst]
    pairs = zip(search.shelf.factors, chosen[index], strict=True)
    return {
        "parts": {factor.path: factor.names[entry] for factor, entry in pairs if factor.names},
        "x": search.shelf.designs(chosen[index][None, :])[0].tolist(),
        "limit": limit.name,
        "side": limit.side,
        "missed": missed,
        "proven": exact,
    }


def _misses(search: Search, x: FloatArray) -> FloatArray:
    """Lower bound of the worst miss of each design as a part of its bound."""
    table = [fails(limit, values, x, 0.0) for limit, values in zip(search.program.limits, search.limits, strict=True)]
    most: FloatArray = np.max(table, axis=0)
    return most


def _parts(chosen: IntArray) -> list[IntArray]:
    return [chosen[at : at + LEAF] for at in range(0, len(chosen), LEAF)]


def _thinned(search: Search) -> tuple[Node, bool]:
    """All choices, or where they are too many every second, third, ... row."""
    node, step = search.shelf.root, 1
    most = _MOST_SEVERAL if search.program.several else _MOST
    while node.size > most:
        step += 1
        node = Node(tuple(one[::step] for one in search.shelf.root.entries))
    return node, step == 1


__all__ = ["nearest"]
