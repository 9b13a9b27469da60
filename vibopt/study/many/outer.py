"""Outer approximation of many questions together: extreme points, worst speeds, more rows, until nothing is missed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from vibopt.forms import FloatArray
from vibopt.study.many.extreme import extreme
from vibopt.study.many.lower import Question
from vibopt.study.many.numbers import Numbers
from vibopt.study.many.peaks import worst
from vibopt.study.many.rows import IndexArray, harmonic_row, plain_row, take

OPEN, OPTIMAL, INFEASIBLE = 0, 1, 2
_DONE = 1e-11
_ROUNDS = 40
_COARSE = (33, 513)
_EVEN = (0, 3, 9)
_CHUNK = 1024


@dataclass(frozen=True)
class Answers:
    """Per question: OPEN (nothing proven), OPTIMAL or INFEASIBLE; x (n_vars, count) in the order (k, c).

    work
        A measure of what it cost.
    """

    status: IndexArray
    x: FloatArray
    work: float = 0.0


def answer(
    asked: Question, numbers: Numbers, count: int, progress: Callable[[float], None] | None = None
) -> Answers:
    """Answer all questions; first a few, whose worst speeds tell where the others begin to look."""
    first: Speeds = []
    for size in (n for n in _COARSE if n < count):
        few = np.unique(np.round(np.linspace(0, count - 1, size)).astype(int))
        found = _answer(asked, take(numbers, few), len(few), _at(first, few))
        first = _speeds(asked, numbers, few, found, count)
        trials = [first + _even(asked, numbers, n, count) for n in _EVEN]
        work = [_answer(asked, take(numbers, few), len(few), _at(one, few)).work for one in trials]
        first = trials[int(np.argmin(work))]
    parts = []
    for begin in range(0, count, _CHUNK):
        chunk = slice(begin, min(begin + _CHUNK, count))
        parts.append(_answer(asked, take(numbers, chunk), chunk.stop - begin, _at(first, chunk)))
        if progress is not None:
            progress(chunk.stop / count)
    return Answers(np.concatenate([one.status for one in parts]), np.concatenate([one.x for one in parts], axis=1))


Speeds = list[tuple[int, FloatArray]]


def _at(speeds: Speeds, chosen: IndexArray | slice) -> Speeds:
    return [(index, w[chosen]) for index, w in speeds]


def _even(asked: Question, numbers: Numbers, many: int, count: int) -> Speeds:
    """Evenly spread speeds of every range: where a peak can move away from one speed, several hold it."""
    speeds = []
    for index, kind in enumerate(asked.rows):
        for b, point in enumerate(kind.points):
            if not point:
                low, high = numbers[f"{index}.low{b}"], numbers[f"{index}.high{b}"]
                for part in np.arange(1, many + 1) / (many + 1.0):
                    speeds.append((index, np.broadcast_to((low + (high - low) * part) ** 2, (count,))))
    return speeds


def _speeds(
    asked: Question, numbers: Numbers, few: IndexArray, found: Answers, count: int
) -> Speeds:
    """Worst speeds at a few answers, drawn as straight lines between them."""
    good = found.status == OPTIMAL
    speeds = []
    for index, kind in enumerate(asked.rows):
        if kind.kind != "harmonic" or all(kind.points) or not good.any():
            continue
        _, w = worst(asked, take(numbers, few[good]), index, found.x[:, good])
        speeds.append((index, np.interp(np.arange(count), few[good], w)))
    return speeds


def _answer(asked: Question, numbers: Numbers, count: int, first: Speeds) -> Answers:
    low, high = np.array(asked.low), np.array(asked.high)
    status, x = np.zeros(count, dtype=int), np.full((len(low), count), np.nan)
    table = _first_rows(asked, numbers, count, first)
    left, work = np.arange(count), 0.0
    for _ in range(_ROUNDS):
        work += (1.0 + len(left)) * (2.0 + table.shape[1]) ** 3
        best = extreme(table, low, high, *asked.goal)
        none = np.isnan(best[0])
        status[left[none]] = INFEASIBLE
        missed, fresh = _learn(asked, numbers, np.where(none, high[:, None], best))
        done = ~none & (missed <= _DONE)
        status[left[done]], x[:, left[done]] = OPTIMAL, best[:, done]
        rest = ~none & ~done
        if not rest.any():
            break
        left, numbers = left[rest], take(numbers, rest)
        table = np.concatenate([table, *fresh], axis=1)[:, :, rest]
    return Answers(status, x, work)


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
