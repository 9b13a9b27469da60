"""Work that a search may do, in counts; a user's time limit is the only clock that ends one.

The same file does the same work on any machine, so it has the same answer, idle or busy.  A budget
counts what a search looks at (boxes, slices, exact measurements); the meter adds up what an answer
took, in nominal milliseconds: a measure of size to decide by, not of time.
"""

from __future__ import annotations

import re
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from contextvars import ContextVar
from math import ceil, inf
from typing import TypeVar

from vibopt.errors import InputError, counted
from vibopt.records import dataclass

T = TypeVar("T")


class SpentError(Exception):
    """The work that was allowed is done."""


@dataclass
class Meter:
    """The work done inside [nominal ms]; `outer` counts it too.  Inside, SpentError ends what does more than `most`."""

    most: float = inf
    done: float = 0.0
    outer: Meter | None = None

    def __enter__(self) -> Meter:
        self.outer = _METER.get()
        _METER.set(self)
        return self

    def __exit__(self, *_: object) -> None:
        _METER.set(self.outer)


@dataclass
class TimeLimit:
    """A limit set by the user.

    seconds, until
        As asked, and by `time.monotonic` [s].
    ended
        What it put an end to, in words ("67 slices"); "" as long as it has ended nothing.
    """

    seconds: float
    until: float
    ended: str = ""

    @property
    def words(self) -> str:
        """What is added to the claim of the answer; "" where nothing was ended."""
        return f"; the time limit of {self.seconds:g} s ended the search after {self.ended}" if self.ended else ""

    def added_to(self, claim: str) -> str:
        """The claim with what the limit ended: the count is said once."""
        known = re.search(r"\b(?:stopped after|nothing proven in) \d", claim)
        return claim + (self.words.partition(" after ")[0] if known else self.words)


_METER: ContextVar[Meter | None] = ContextVar("meter", default=None)
_LIMIT: ContextVar[TimeLimit | None] = ContextVar("time limit", default=None)
_EACH: ContextVar[float | None] = ContextVar("seconds of each answer", default=None)


@dataclass
class Budget:
    """How much a search may look at.

    most
        Where it ends.
    unit
        What is counted, in the plural ("slices").
    cost
        Work of one of them [nominal ms].
    """

    most: int
    unit: str
    cost: float = 0.0
    spent: int = 0

    def spend(self, count: int = 1) -> None:
        """Count what was looked at."""
        self.spent += count
        if self.cost:
            worked(count * self.cost)

    @property
    def over(self) -> bool:
        """Whether the search is to end here: all is spent, or the user's time limit is reached."""
        return self.spent >= self.most or (is_limited() and late(str(self)))

    @property
    def part(self) -> float:
        """Part that is spent, for a progress bar."""
        return min(self.spent / max(self.most, 1), 0.99)

    def __str__(self) -> str:
        return counted(self.spent, self.unit)


@contextmanager
def deaf() -> Iterator[None]:
    """Threads and processes that are started here do not hear Ctrl-C, where the system can tell them apart."""
    import signal

    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def worked(cost: float) -> None:
    """Add to the work of the answer under way [nominal ms]; SpentError where that is more than is allowed."""
    spent, meter = False, _METER.get()
    while meter is not None:
        meter.done += cost
        spent = spent or meter.done > meter.most
        meter = meter.outer
    if spent:
        raise SpentError


def metered(most: float = inf) -> Meter:
    """A meter of what is done inside."""
    return Meter(most)


def done() -> float:
    """Work of the answer under way so far [nominal ms]."""
    meter = _METER.get()
    return 0.0 if meter is None else meter.done


@contextmanager
def within(variable: ContextVar[T], value: T) -> Iterator[None]:
    """A variable has this value inside."""
    before = variable.set(value)
    try:
        yield
    finally:
        variable.reset(before)


def each_answer_within(seconds: float | None) -> AbstractContextManager[None]:
    """End the searches of every answer inside after `seconds` of it; None changes nothing.

    Raises
    ------
    InputError
        No number of seconds above zero.
    """
    if seconds is not None and not 0.0 < seconds < inf:
        raise InputError(f"time_limit = {seconds} is no number of seconds above zero. Write time_limit=5.")
    return nullcontext() if seconds is None else within(_EACH, seconds)


def seconds_of_each_answer() -> float | None:
    """What `each_answer_within` said, to say it again in another process."""
    return _EACH.get()


@contextmanager
def answering() -> Iterator[TimeLimit | None]:
    """One answer: yields the user's time limit of it; None where there is none, or where an answer around it has it."""
    seconds = _EACH.get()
    if seconds is None or _LIMIT.get() is not None:
        yield None
        return
    limit = TimeLimit(seconds, time.monotonic() + seconds)
    with within(_LIMIT, limit):
        yield limit


def is_limited() -> bool:
    """Whether the user has set a time limit: what could wait until it is looked at is then worked out within it."""
    return _LIMIT.get() is not None


def late(what: str = "") -> bool:
    """Whether the user's time limit is reached; the first to ask then is what it ended, in words."""
    limit = _LIMIT.get()
    if limit is None or time.monotonic() <= limit.until:
        return False
    limit.ended = limit.ended or what or "a search"
    return True


def spoken_time(seconds: float) -> str:
    """A time in the two units that matter: "50 s", "3 min", "2 h 10 min", "12 days"."""
    if seconds < 99.5:
        return f"{max(seconds, 1.0):.0f} s"
    minutes = ceil(seconds / 60.0)
    if minutes < 100:
        return f"{minutes} min"
    return f"{minutes // 60} h {minutes % 60} min" if minutes < 2 * 24 * 60 else f"{minutes // (24 * 60)} days"
