"""The same work on many items by several at a time: by processes of this machine, or by whatever else is a pool."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from itertools import islice
from multiprocessing import current_process, get_all_start_methods, get_context, resource_tracker
from multiprocessing.connection import Connection, wait
from threading import Lock
from typing import Any, Generic, Protocol, TypeVar, cast

from vibopt.errors import PoolError, VibOptError
from vibopt.records import dataclass
from vibopt.work import deaf

Item = TypeVar("Item")
Result = TypeVar("Result")
_Made = TypeVar("_Made", covariant=True)

THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
AT_MOST = 2
"""Processes, unless more are asked for."""
LOADED = "vibopt.study.loaded"
_ONE_AT_A_TIME = Lock()


@dataclass(frozen=True, slots=True)
class Lost:
    """The process that worked on an item ended without a result; `why` says how."""

    why: str


class Running(Protocol[_Made]):
    """An item under way, and its place among the items."""

    index: int

    def result(self) -> _Made | Lost:
        """What was made of it, once it is ready."""

    def end(self) -> None:
        """End it, whatever it does."""


class Pool(Protocol):
    """Those who work on items.

    most
        Items under way at a time.
    advice
        What to do where one is lost.
    """

    advice: str

    @property
    def most(self) -> int: ...

    def begin(self, work: Callable[[Item], Result], index: int, item: Item) -> Running[Result]:
        """Have an item worked on."""

    def ready(self, running: Sequence[Running[Result]]) -> Sequence[Running[Result]]:
        """Those that are ready, as soon as one is."""


def taken(found: Result | VibOptError | Lost, what: str, pool: Pool) -> Result:
    """What another process has made; PoolError where that is lost, and any error with which it ended is raised here."""
    if isinstance(found, Lost):
        raise PoolError(f"{what} was lost: {found.why}. {pool.advice}")
    if isinstance(found, VibOptError):
        raise found
    return found


def usual_number() -> int:
    """The cores that this process may use, two at most."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return min(AT_MOST, cores)


def each(
    work: Callable[[Item], Result],
    items: Iterable[Item],
    pool: Pool,
    done: Callable[[int], None] | None = None,
    ready: Callable[[int, Result | Lost], None] | None = None,
) -> list[Result | Lost]:
    """What `work` makes of every item, in the order of the items whichever is ready first.

    A process that ends costs its own item alone.

    Parameters
    ----------
    work
        A function of a module, or a partial of one; it must not raise.
    items
        Anything that can be pickled, like the results; taken as they are begun.
    pool
        Those who work.
    done
        Called with the number of items that are finished.
    ready
        Called with the index of an item and what was made of it, as soon as it is there.
    """
    results: dict[int, Result | Lost] = {}
    waiting = iter(enumerate(items))
    running: list[Running[Result]] = []
    try:
        while True:
            running += [pool.begin(work, *one) for one in islice(waiting, max(pool.most - len(running), 0))]
            if not running:
                return [results[index] for index in sorted(results)]
            for one in pool.ready(running):
                results[one.index] = one.result()
                running.remove(one)
                if ready is not None:
                    ready(one.index, results[one.index])
                if done is not None:
                    done(len(results))
    finally:
        for one in running:
            one.end()


class Processes:
    """Processes of this machine, each with one thread of linear algebra.

    Parameters
    ----------
    most
        Items under way at a time.
    lasting
        A process that is ready takes the next item, and has loaded what it needs; else each item has one of its own.
        Those that are left end with the pool, used as a context.
    """

    advice = "Take fewer --workers."

    def __init__(self, most: int, *, lasting: bool = False) -> None:
        self.most, self._lasting = most, lasting
        self._idle: list[_Process] = []

    def __enter__(self) -> Processes:
        return self

    def __exit__(self, *_: object) -> None:
        while self._idle:
            self._idle.pop().end()

    def begin(self, work: Callable[[Item], Result], index: int, item: Item) -> Running[Result]:
        """A process for the item."""
        process = self._rested() or _Process()
        process.pipe.send((work, item))
        return _Task(self, index, process)

    def _rested(self) -> _Process | None:
        """One that waits for an item and is well."""
        while True:
            try:
                one = self._idle.pop()  # of several threads each takes another
            except IndexError:
                return None
            if one.process.is_alive():
                return one
            one.end()

    def ready(self, running: Sequence[Running[Result]]) -> Sequence[Running[Result]]:
        """Those whose process has said something, or has ended."""
        tasks = cast("Sequence[_Task[Result]]", running)
        here = wait([one.process.pipe for one in tasks])
        return [one for one in tasks if one.process.pipe in here]

    def alone(self, work: Callable[[Item], Result], item: Item) -> Result | Lost:
        """What `work` makes of one item."""
        one = self.begin(work, 0, item)
        try:
            return one.result()
        except BaseException:
            one.end()
            raise

    def take_back(self, process: _Process) -> None:
        """A process that is ready for another item."""
        if self._lasting:
            self._idle.append(process)
        else:
            process.end()


class _Task(Generic[Result]):
    """An item and its process."""

    def __init__(self, pool: Processes, index: int, process: _Process) -> None:
        self.pool, self.index, self.process = pool, index, process

    def result(self) -> Result | Lost:
        """The result, or how the process ended."""
        try:
            found = cast(Result, self.process.pipe.recv())
        except (EOFError, OSError):
            return Lost(self.process.ending())
        self.pool.take_back(self.process)
        return found

    def end(self) -> None:
        """End its process, whatever it does."""
        self.process.end()


class _Process:
    """A process that works on one item after the other, and ends where nobody has another."""

    def __init__(self) -> None:
        self.pipe, far = _context().Pipe()
        self.process = _context().Process(target=_serve, args=(far,), daemon=True)
        if hasattr(signal, "pthread_sigmask"):
            resource_tracker.ensure_running()  # else started with the first process, and it lets Ctrl-C through again
        with _ONE_AT_A_TIME, deaf(), _one_thread():  # Ctrl-C is for the one that waits for them and ends them
            if current_process().daemon:
                current_process().daemon = False  # these children do not outlive it: they end where it is gone
            self.process.start()
        far.close()

    def ending(self) -> str:
        """How it ended by itself."""
        self.process.join()
        self.pipe.close()
        return _ending(self.process.exitcode or 0)

    def end(self) -> None:
        """End it, whatever it does."""
        self.process.kill()
        self.process.join()
        self.pipe.close()


def _context() -> Any:
    """Processes are forked from one that has loaded what they need and done nothing; or start anew."""
    if "forkserver" not in get_all_start_methods():
        return get_context("spawn")
    context = get_context("forkserver")
    context.set_forkserver_preload([LOADED])
    return context


def _serve(pipe: Connection) -> None:
    with suppress(EOFError, BrokenPipeError, ConnectionResetError):
        while True:
            work, item = pipe.recv()
            pipe.send(work(item))


def _ending(code: int) -> str:
    if code < 0:
        name = signal.Signals(-code).name if -code in set(signal.Signals) else f"signal {-code}"
        return f"the process that solved it was ended by {name}"
    return f"the process that solved it ended with exit code {code}"


@contextmanager
def _one_thread() -> Iterator[None]:
    """Processes that are started here have one thread of linear algebra: more change the last digits."""
    before = {name: os.environ.get(name) for name in THREADS}
    os.environ.update(dict.fromkeys(THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
