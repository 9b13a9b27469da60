"""Limits that cannot hold together, in words: a smallest set of them, and what loosening helps."""

from __future__ import annotations

from collections.abc import Callable, Sequence

Step = tuple[str, str, str]
"""A limit, its bound now, and the bound that alone makes the job possible, as text."""


def smallest_set(names: Sequence[str], possible: Callable[[tuple[str, ...]], bool]) -> tuple[str, ...]:
    """Limits that cannot hold together, none of which can be left out; empty where it is not the limits.

    Parameters
    ----------
    names
        All limits; together they are impossible.
    possible
        Whether an answer keeps the limits named.
    """
    if not possible(()):
        return ()
    kept = tuple(names)
    for name in names:
        fewer = tuple(one for one in kept if one != name)
        if not possible(fewer):
            kept = fewer
    return kept


def conflict_words(names: Sequence[str], steps: Sequence[Step]) -> str:
    """ "These cannot hold together: a, b. Smallest loosening of one: a 1 mil pp -> 2 mil pp." """
    if not names:
        return ""
    together = "These cannot hold together" if len(names) > 1 else "This cannot hold"
    said = f"{together}: {', '.join(names)}."
    if steps:
        told = ", or ".join(f"{name} {now} -> {then}" for name, now, then in steps)
        said += f" Smallest loosening of one: {told}."
    return said
