"""Runs of a chart, each kept as soon as it is known, so that a chart that was stopped goes on where it was."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from contextvars import ContextVar
from dataclasses import fields
from typing import Any, TypeVar

from vibopt.records import dataclass
from vibopt.work import within

T = TypeVar("T")
Rows = tuple[str, list[dict[str, Any]]]
"""What was run, and what came of it as plain data."""


@dataclass
class _Kept:
    known: list[Rows]
    add: Callable[[Rows], None]
    taken: int = 0


_KEPT: ContextVar[_Kept | None] = ContextVar("kept", default=None)


def kept(known: Sequence[Rows], add: Callable[[Rows], None]) -> AbstractContextManager[None]:
    """Runs inside are those that are known, as long as they come in the same order; `add` is given the others."""
    return within(_KEPT, _Kept([*known], add))


def run(name: str, kind: type[T], make: Callable[[], Sequence[T]]) -> list[T]:
    """The rows of a run, made now or known from before.

    Parameters
    ----------
    name
        What is run, in words that are the same in every run of the chart.
    kind
        Class of its rows: numbers, words and pairs of numbers.
    """
    found = _KEPT.get()
    if found is None:
        return [*make()]
    found.taken += 1
    if found.taken <= len(found.known) and found.known[found.taken - 1][0] == name:
        return [_row(kind, row) for row in found.known[found.taken - 1][1]]
    del found.known[found.taken - 1 :]
    rows = [*make()]
    found.add((name, [{field.name: getattr(row, field.name) for field in fields(row)} for row in rows]))  # type: ignore[arg-type]
    return rows


def _row(kind: type[T], told: dict[str, Any]) -> T:
    return kind(**{key: tuple(value) if isinstance(value, list) else value for key, value in told.items()})
