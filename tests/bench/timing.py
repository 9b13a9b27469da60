"""Processor time of calls that take turns: a machine that is busy for a while slows all of them alike."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Sequence
from statistics import median
from typing import Any


def in_turns(calls: Sequence[Callable[[], Any]], repeats: int) -> tuple[list[float], list[Any]]:
    """Median processor time [s] of each call, and what the last ones gave."""
    times, answers = [list[float]() for _ in calls], [None] * len(calls)
    gc.collect()
    for _ in range(repeats):
        for index, call in enumerate(calls):
            start = time.process_time()
            answers[index] = call()
            times[index].append(time.process_time() - start)
    return [median(one) for one in times], answers


def timed(call: Callable[[], Any], repeats: int = 1) -> tuple[float, Any]:
    """Median processor time [s] of a call, and what it gave last."""
    (seconds,), (answer,) = in_turns([call], repeats)
    return seconds, answer
