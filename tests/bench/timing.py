"""Processor time of calls that take turns: a machine that is busy for a while slows all of them alike."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Sequence
from typing import Any


def in_turns(calls: Sequence[Callable[[], Any]], repeats: int) -> tuple[list[float], list[Any]]:
    """Least processor time [s] of each call, and what the last ones gave."""
    best, answers = [float("inf")] * len(calls), [None] * len(calls)
    gc.collect()
    for _ in range(repeats):
        for index, call in enumerate(calls):
            start = time.process_time()
            answers[index] = call()
            best[index] = min(best[index], time.process_time() - start)
    return best, answers


def timed(call: Callable[[], Any], repeats: int = 1) -> tuple[float, Any]:
    """Least processor time [s] of a call, and what it gave last."""
    (seconds,), (answer,) = in_turns([call], repeats)
    return seconds, answer
