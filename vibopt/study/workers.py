"""The same work on many items by several processes at a time, each with one thread of linear algebra."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from itertools import islice
from multiprocessing import get_all_start_methods, get_context, resource_tracker
from multiprocessing.connection import Connection, wait
from typing import Any, Generic, TypeVar, cast

from vibopt.records import dataclass
from vibopt.work import deaf

Item = TypeVar("Item")
Result = TypeVar("Result")

THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
AT_MOST = 2
"""Processes, unless more are asked for."""
LOADED = "vibopt.study.loaded"


@dataclass(frozen=True, slots=True)
class Lost:
    """The process that worked on an item ended without a result; `why` says how."""

    why: str


def usual_number() -> int:
    """The cores that this process may use, two at most."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return min(AT_MOST, cores)


def each(
    work: Callable[[Item], Result],
    items: Iterable[Item],
    workers: int,
    done: Callable[[int], None] | None = None,
    ready: Callable[[int, Result | Lost], None] | None = None,
) -> list[Result | Lost]:
    """What `work` makes of every item, in the order of the items whichever is ready first.

    Each item has a process of its own, and all begin alike: what was worked on before, or beside, leaves no trace
    in the last digits, and a process that ends costs its own item alone.

    Parameters
    ----------
    work
        A function of a module, or a partial of one; it must not raise.
    items
        Anything that can be pickled, like the results.
    workers
        Processes at a time.
    done
        Called with the number of items that are finished.
    ready
        Called with the index of an item and what was made of it, as soon as it is there.
    """
    results: dict[int, Result | Lost] = {}
    waiting = iter(enumerate(items))
    running: list[_Running[Item, Result]] = []
    try:
        while True:
            running += [_Running(work, *one) for one in islice(waiting, workers - len(running))]
            if not running:
                return [results[index] for index in sorted(results)]
            here = wait([one.pipe for one in running])
            for one in [one for one in running if one.pipe in here]:
                results[one.index] = one.result()
                running.remove(one)
                if ready is not None:
                    ready(one.index, results[one.index])
                if done is not None:
                    done(len(results))
    finally:
        for one in running:
            one.end()


class _Running(Generic[Item, Result]):
    """One item and its process."""

    def __init__(self, work: Callable[[Item], Result], index: int, item: Item) -> None:
        self.index = index
        self.pipe, far = _context().Pipe(duplex=False)
        self.process = _context().Process(target=_serve, args=(far, work, item), daemon=True)
        if hasattr(signal, "pthread_sigmask"):
            resource_tracker.ensure_running()  # else started with the first process, and it lets Ctrl-C through again
        with deaf(), _one_thread():  # Ctrl-C is for the one that waits for them and ends them
            self.process.start()
        far.close()

    def result(self) -> Result | Lost:
        """The result, or how the process ended."""
        try:
            found = cast(Result, self.pipe.recv())
        except (EOFError, OSError):
            self.process.join()
            return Lost(_ending(self.process.exitcode or 0))
        self.end()
        return found

    def end(self) -> None:
        """End the process, whatever it does."""
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


def _serve(pipe: Connection, work: Callable[[Item], Result], item: Item) -> None:
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
