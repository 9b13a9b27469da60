"""Work shared by many machines, through a scheduler of Dask and its workers."""

from __future__ import annotations

import logging
import pickle
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import cache, partial
from importlib import import_module
from pathlib import Path
from re import fullmatch
from typing import Any, cast

from vibopt.errors import InputError, PoolError
from vibopt.study.workers import Item, Lost, Processes, Result, Running
from vibopt.work import deaf

PATIENCE = 10.0
"""How long a scheduler may take to answer, and to have a worker again where all have gone [s]."""
LOOK_UP = 1.0
"""How often it is asked for its workers while no item gets ready [s]."""
AHEAD = 2
"""Items under way for each thread of a worker: one to work on, and one that waits there."""
_OWN = Processes(1, lasting=True)
"""Of a worker, one for each of its threads: they stay for the next sweep, and end with it."""
_LOGS = ("distributed", "tornado", "asyncio")
"""Beginnings of the names of loggers."""
_ADDRESS = r"((tcp|tls|ws|wss|ucx)://)?[^\s/@]+:\d{1,5}"


@contextmanager
def cluster(address: str) -> Iterator[Cluster]:
    """The workers of a scheduler, as long as they are needed.

    Raises
    ------
    InputError
        No scheduler answers there, distributed is not installed, there is no worker, or one is unlike this machine.
    """
    given = f"--cluster {address}"
    if not fullmatch(_ADDRESS, address):
        raise InputError(f"{given} is no address. Write --cluster tcp://HOST:8786, as the scheduler says it.")
    try:
        distributed = import_module("distributed")
    except ImportError:
        raise InputError(
            "--cluster needs distributed, which is not installed. Install it, pip install 'vibopt[cluster]', or take "
            "--workers 2: processes of this machine."
        ) from None
    with _quiet():
        try:
            with deaf(), warnings.catch_warnings():  # Ctrl-C is for the one that waits
                warnings.simplefilter("ignore")  # of other versions, which are looked at below
                client = distributed.Client(address, timeout=PATIENCE, set_as_default=False)
        except (OSError, ValueError, TypeError, ImportError):
            raise InputError(
                f"{given}: no scheduler of Dask answers there within {PATIENCE:g} s. Start one, dask scheduler, and "
                "name the address that it says."
            ) from None
        try:
            pool = Cluster(address, client, distributed)
            pool.check()
            with client.as_current():
                yield pool
        finally:
            with suppress(Exception):
                client.close(timeout=PATIENCE)


class Cluster:
    """The workers of one scheduler, who have a process of their own for each item that they work on at a time.

    An item whose worker is gone is given to another.
    """

    advice = "Look at the memory of the workers."

    def __init__(self, address: str, client: Any, distributed: Any) -> None:
        self.address, self._client, self._distributed = address, client, distributed
        self._threads, self._idle = 1, 0.0

    def check(self) -> None:
        """InputError where there is no worker, or one that is not as this machine is."""
        told = self._asked(partial(self._client.run, _errand(), {}, b"", on_error="return"))
        self._threads = self._count()
        if not told:
            raise InputError(f"--cluster {self.address} has no worker. Start one, dask worker {self.address}.")
        here = made_of()
        install = " ".join(f"'{name}=={one.split()[0]}'" for name, one in here.items() if name != "python")
        for worker, there in sorted(told.items()):
            if there == here:
                continue
            has = "has no vibopt, or one that knows no cluster"
            if isinstance(there, dict):
                others = [name for name, one in here.items() if there.get(name) != one]
                has = " and ".join(f"has {name} {there.get(name)} in place of {here[name]}" for name in others)
            raise InputError(
                f"--cluster {self.address}: the worker {worker} {has}. Install there what is here: pip install "
                f"{install}."
            )

    @property
    def most(self) -> int:
        """Items under way at a time."""
        return AHEAD * max(self._threads, 1)

    def begin(self, work: Callable[[Item], Result], index: int, item: Item) -> Running[Result]:
        """Give an item to the scheduler."""
        sent = pickle.dumps((work, item))  # a worker that cannot read what it is given would end
        return _Remote(self, index, self._asked(partial(self._client.submit, _errand(), made_of(), sent, pure=False)))

    def ready(self, running: Sequence[Running[Result]]) -> Sequence[Running[Result]]:
        """Those that are ready; PoolError where the scheduler or all workers are gone."""
        remote = cast("Sequence[_Remote[Result]]", running)
        futures = [one.future for one in remote]

        def first() -> None:
            with suppress(TimeoutError):
                self._distributed.wait(futures, timeout=LOOK_UP, return_when="FIRST_COMPLETED")

        while True:
            self._asked(first)
            self._threads = self._count()
            if here := [one for one in remote if one.future.done()]:
                self._idle = 0.0
                return here
            self._idle = 0.0 if self._threads else self._idle + LOOK_UP
            if self._idle >= PATIENCE:
                raise PoolError(f"The cluster at {self.address} has no worker any more.")

    def result(self, future: Any) -> Any:
        """What a worker has made, or Lost."""
        found = self._asked(future.exception)
        if isinstance(found, self._distributed.KilledWorker):
            return Lost("every worker that solved it was ended")
        made = self._asked(future.result) if found is None else None
        if isinstance(made, bytes):
            return pickle.loads(made)
        try:
            self.check()
        except InputError as error:  # one has come in the middle
            raise PoolError(str(error)) from None
        words = "it had another vibopt" if found is None else " ".join(f"{type(found).__name__}: {found}".split())
        return Lost(f"a worker has failed, {words}")

    def _count(self) -> int:
        return sum(self._asked(self._client.nthreads).values())

    def _asked(self, ask: Callable[[], Any]) -> Any:
        """What the scheduler says."""
        try:
            found, there = ask(), self._client.status == "running"
        except (self._distributed.CancelledError, OSError):
            found, there = None, False
        if not there:
            raise PoolError(f"The scheduler at {self.address} went away.")
        return found


class _Remote(Running[Result]):
    """One item and what stands for its result."""

    def __init__(self, pool: Cluster, index: int, future: Any) -> None:
        self.pool, self.index, self.future = pool, index, future

    def result(self) -> Result | Lost:
        """The result, or how it was lost."""
        return cast(Result | Lost, self.pool.result(self.future))

    def end(self) -> None:
        """Have it left."""
        with suppress(Exception):
            self.future.cancel()


def served(wanted: dict[str, str], sent: bytes) -> bytes | dict[str, str]:
    """On a worker: what its process makes of an item; what the worker has where other versions are wanted."""
    here = made_of()
    return pickle.dumps(_OWN.alone(*pickle.loads(sent))) if here == wanted else here


def _errand() -> Callable[[dict[str, str], bytes], bytes | dict[str, str] | None]:
    """`served`, or None where a worker has no such thing, as a function that arrives without any vibopt."""

    def served(wanted: dict[str, str], sent: bytes) -> bytes | dict[str, str] | None:
        try:
            there: Any = import_module("vibopt.study.cluster")
        except ImportError:
            return None
        return there.served(wanted, sent)  # type: ignore[no-any-return]

    return served


@cache
def made_of() -> dict[str, str]:
    """What the last digits depend on: the files of vibopt, and the versions of what computes."""
    from hashlib import sha256

    from vibopt.study.archive import versions

    home = Path(__file__).parents[1]
    files = sorted((one.relative_to(home).as_posix(), one) for one in home.rglob("*.py"))
    digest = sha256(b"".join(name.encode() + one.read_bytes() for name, one in files)).hexdigest()[:8]
    found = versions()
    return {**found, "vibopt": f"{found['vibopt']} ({digest})"}


@contextmanager
def _quiet() -> Iterator[None]:
    """Dask writes no lines in between: what went wrong is said in words of ours."""
    loggers = [logging.getLogger(name) for name in logging.root.manager.loggerDict if name.startswith(_LOGS)]
    before = [one.disabled for one in loggers]
    for one in loggers:
        one.disabled = True
    try:
        yield
    finally:
        for one, disabled in zip(loggers, before, strict=True):
            one.disabled = disabled
