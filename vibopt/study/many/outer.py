"""Outer approximation of many questions together: extreme points, worst speeds, more rows, until nothing is missed."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from vibopt.forms import FloatArray
from vibopt.records import dataclass
from vibopt.study.many.extreme import extreme
from vibopt.study.many.lower import Question, RowKind
from vibopt.study.many.numbers import Numbers
from vibopt.study.many.peaks import worst
from vibopt.study.many.rows import IndexArray, harmonic_row, plain_row, take

OPEN, OPTIMAL, INFEASIBLE = 0, 1, 2
_DONE = 1e-11
_ROUNDS = 40
_COARSE = (33, 513)
_FEWER = 4
"""Times as many questions as a coarse round has, for it to be worth its time."""
_CHUNK = 1024
_WORSE = 1e-3

Speeds = list[tuple[int, FloatArray]]
"""Squared frequencies at which limits are looked at first: (index of the limit, one per question)."""


@dataclass(frozen=True)
class Answers:
    """Per question: OPEN (nothing proven), OPTIMAL or INFEASIBLE; x (n_vars, count) in the order (k, c)."""

    status: IndexArray
    x: FloatArray


def answer(asked: Question, numbers: Numbers, count: int, progress: Callable[[float], None] | None = None) -> Answers:
    """Answer all questions; first a few, whose worst speeds tell where the others begin to look."""
    first: Speeds = []
    near = np.full(count, np.nan)
    for size in (n for n in _COARSE if _FEWER * n <= count):
        few = np.unique(np.round(np.linspace(0, count - 1, size)).astype(int))
        found = _answer(asked, take(numbers, few), _at(first, few), near[few])
        first, near = _speeds(asked, numbers, few, found, count), _expected(asked, few, found, count)
    parts = []
    for begin in range(0, count, _CHUNK):
        chunk = slice(begin, min(begin + _CHUNK, count))
        parts.append(_answer(asked, take(numbers, chunk), _at(first, chunk), near[chunk]))
        if progress is not None:
            progress(chunk.stop / count)
    return Answers(np.concatenate([one.status for one in parts]), np.concatenate([one.x for one in parts], axis=1))


def _at(speeds: Speeds, chosen: IndexArray | slice) -> Speeds:
    return [(index, w[chosen]) for index, w in speeds]


def _speeds(asked: Question, numbers: Numbers, few: IndexArray, found: Answers, count: int) -> Speeds:
    """Worst speeds at a few answers, drawn as straight lines between them."""
    good = found.status == OPTIMAL
    speeds = []
    for index, kind in enumerate(asked.rows):
        if kind.kind != "harmonic" or all(kind.points) or not good.any():
            continue
        _, w = worst(asked, take(numbers, few[good]), index, found.x[:, good])
        between = np.interp(np.arange(count), few[good], np.sqrt(w))
        speeds.append((index, _within(kind, numbers, index, between) ** 2))
    return speeds


def _within(kind: RowKind, numbers: Numbers, index: int, omega: FloatArray) -> FloatArray:
    """Frequencies moved into the nearest band of a limit, (count,): elsewhere the limit asks for nothing."""
    found = np.full(omega.shape, np.inf)
    for b, point in enumerate(kind.points):
        if not point:
            here = np.clip(omega, numbers[f"{index}.low{b}"], numbers[f"{index}.high{b}"])
            found = np.where(np.abs(here - omega) < np.abs(found - omega), here, found)
    return found


def _expected(asked: Question, few: IndexArray, found: Answers, count: int) -> FloatArray:
    """Stiffnesses a little worse than the straight lines between a few answers; nan beside one that has none."""
    k = np.interp(np.arange(count), few, found.x[0])
    return np.asarray(k * (1.0 - asked.goal[1] * _WORSE))


def _answer(asked: Question, numbers: Numbers, first: Speeds, near: FloatArray) -> Answers:
    """Answer some questions, beginning at the speeds `first`; `near` is what `_expected` says."""
    count = len(near)
    low, high = np.array(asked.low), np.array(asked.high)
    status, x = np.zeros(count, dtype=int), np.full((len(low), count), np.nan)
    table = _first_rows(asked, numbers, count, first)
    left = np.arange(count)
    for _ in range(_ROUNDS):
        best = extreme(table, low, high, asked.goal, near)
        none = np.isnan(best[0])
        status[left[none]] = INFEASIBLE
        missed, fresh = _learn(asked, numbers, np.where(none, high[:, None], best))
        done = ~none & (missed <= _DONE)
        status[left[done]], x[:, left[done]] = OPTIMAL, best[:, done]
        rest = ~none & ~done
        if not rest.any():
            break
        left, near, numbers = left[rest], near[rest], take(numbers, rest)
        table = np.concatenate([table, *fresh], axis=1)[:, :, rest]
    return Answers(status, x)


def _first_rows(asked: Question, numbers: Numbers, count: int, first: Speeds) -> FloatArray:
    rows = []
    for index, kind in enumerate(asked.rows):
        if kind.kind != "harmonic":
            rows.append(plain_row(asked, numbers, index, count))
            continue
        for b, point in enumerate(kind.points):
            for end in ("low",) if point else ("low", "high"):
                w = np.broadcast_to(numbers[f"{index}.{end}{b}"] ** 2, (count,))
                rows.append(harmonic_row(asked, numbers, index, w))
    rows += [harmonic_row(asked, numbers, index, w) for index, w in first]
    return np.stack(rows, axis=1) if rows else np.zeros((4, 0, count))


def _learn(asked: Question, numbers: Numbers, x: FloatArray) -> tuple[FloatArray, list[FloatArray]]:
    """Greatest miss of each question, and a row per limit that some question misses, (4, 1, count)."""
    greatest, rows = np.full(x.shape[1], -np.inf), []
    for index, kind in enumerate(asked.rows):
        if kind.kind != "harmonic":
            continue
        missed, w = worst(asked, numbers, index, x)
        greatest = np.maximum(greatest, missed)
        if (missed > _DONE).any():
            rows.append(harmonic_row(asked, numbers, index, w)[:, None])
    return greatest, rows
