"""Work shared by processes: same results in the same order, and one that dies costs its own item alone."""

import os
import signal
import time
from functools import partial

import pytest

from vibopt.study.workers import THREADS, Lost, Processes, each


def slow_first(item: int) -> int:
    """The first items take the longest, so that later ones are ready before them."""
    time.sleep(0.1 * max(3 - item, 0))
    return item * item


def perhaps_dies(item: int, *, how: str) -> int:
    if item == 2:
        os.kill(os.getpid(), signal.SIGKILL) if how == "killed" else os._exit(7)
    return item


def threads(_: int) -> list[str | None]:
    return [os.environ.get(name) for name in THREADS]


@pytest.mark.parametrize("workers", [1, 2, 5])
def test_results_come_in_the_order_of_the_items_with_any_number_of_processes(workers: int) -> None:
    counted: list[int] = []
    assert each(slow_first, range(4), Processes(workers), counted.append) == [0, 1, 4, 9]
    assert counted == [1, 2, 3, 4]


@pytest.mark.parametrize(
    ("how", "why"),
    [
        ("killed", "the process that solved it was ended by SIGKILL"),
        ("left", "the process that solved it ended with exit code 7"),
    ],
)
@pytest.mark.parametrize("workers", [1, 2])
def test_a_process_that_dies_costs_its_own_item_alone(workers: int, how: str, why: str) -> None:
    assert each(partial(perhaps_dies, how=how), range(5), Processes(workers)) == [0, 1, Lost(why), 3, 4]


def test_each_process_has_one_thread_of_linear_algebra_and_this_one_keeps_its_own(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv(THREADS[0], "8")
    monkeypatch.delenv(THREADS[1], raising=False)
    assert each(threads, [0], Processes(1)) == [["1"] * len(THREADS)]
    assert (os.environ[THREADS[0]], THREADS[1] in os.environ) == ("8", False)
