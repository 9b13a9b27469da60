"""Cost against size: the CPU time of whole answers as one number of a job grows, with the exponent that fits it."""

from __future__ import annotations

import math
import tracemalloc
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from itertools import pairwise
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

import numpy as np

from vibopt.charts import machines
from vibopt.charts.balancing_questions import asked, worst
from vibopt.charts.mount_cases import machine_on
from vibopt.charts.mount_machine import LINE
from vibopt.charts.runs import run
from vibopt.charts.stopwatch import spent
from vibopt.records import dataclass
from vibopt.scene.read import from_text
from vibopt.work import answering

Answered = Callable[[], str]
"""Answers a job anew and says by which method."""


@dataclass(frozen=True, slots=True)
class Size:
    """One job of a ladder.

    seconds, quartiles, runs
        CPU seconds of an answer: median of so many runs, and between what the middle half of them lies.
    method
        What answered; it changes where a ladder jumps.
    memory
        Most that Python and numpy held at once [byte], beside what was there before.
    cut
        Why less was asked than the chart promises; "" where all was.
    """

    ladder: str
    size: int
    seconds: float
    memory: int
    quartiles: tuple[float, float]
    runs: int
    method: str
    cut: str = ""


@dataclass(frozen=True, slots=True)
class Fit:
    """seconds ~ size^exponent over the sizes of one method.

    half
        Half the width of the interval that holds the exponent with 95 %; nan of two sizes.
    """

    ladder: str
    method: str
    exponent: float
    half: float
    sizes: tuple[int, ...]


Ladder = tuple[tuple[int, ...], tuple[int, ...], Callable[[int], Iterator[Answered]]]
"""All sizes, those with --quick, and what makes a job of one that can be answered again and again."""


def _scene(text: str) -> Iterator[Answered]:
    from vibopt.solve.solve import solve

    scene = from_text(text, name="job")
    yield lambda: str(solve(scene, explain=False).method)


def _chain(count: int) -> Iterator[Answered]:
    return _scene(machines.chain(count, floor="300 N", start_up="2 mm"))


def _absorbers(count: int) -> Iterator[Answered]:
    return _scene(machines.absorbed([0] * count, [0.05 / count] * count, damping=0.01))


def _presses(count: int) -> Iterator[Answered]:
    from vibopt.charts.isolation_cases import presses

    return _scene(presses(count // 2))


def _limits(count: int) -> Iterator[Answered]:
    """The press under more and more limits, each looser than the one before."""
    extra = "".join(
        f'[limits.more{i}]\nresponse = "displacement"\nof = "machine"\nover = "0..{1000 + 10 * i} rpm"\n'
        f'at_most = "{20 + i} mm"\n\n'
        for i in range(1, count - 1)
    )
    return _scene(machines.press().replace("[goal]", f"{extra}[goal]"))


def _harmonics(count: int) -> Iterator[Answered]:
    """The press shaken by so many harmonics of its speed, each half of the one before."""
    rows = ", ".join(f'{{ order = {i + 1}, amplitude = "{30.0 / 2**i!r} kN" }}' for i in range(count))
    single = 'kind = "force"\namplitude = "30 kN"\nspeed = "3000 rpm"\nvaries = "constant"'
    several = f'kind = "harmonics"\nspeed = "3000 rpm"\nvaries = "constant"\nharmonics = [{rows}]'
    text = machines.press(start_up="60 mm", floor="30 kN").replace(single, several)
    return _scene(text.replace("at_most", 'combine = "sum"\nat_most'))


def _balance(readings: int, planes: int) -> Iterator[Answered]:
    from vibopt.balancing.solve_rotor import solve_job

    job = asked("", worst(readings, planes), 1.0, "").job
    yield lambda: str(solve_job(job).method)


def _parts(count: int) -> Iterator[Answered]:
    from vibopt.solve.solve import solve

    machine, shelf = machine_on(LINE, count, 2, 1, steel=False)
    with TemporaryDirectory() as folder:
        scene = machine.scene(Path(folder), shelf)
        yield lambda: str(solve(scene, explain=False).method)


def _points(count: int) -> Iterator[Answered]:
    from vibopt.study.sweep import sweep

    scene = from_text(machines.press(), name="job")

    def answered() -> str:
        sweep(scene, "limits.start_up.at_most", "5 mm..30 mm", count)
        return "sweep"

    yield answered


LADDERS: Mapping[str, Ladder] = {
    "bodies": ((2, 4, 8, 16, 32, 64), (2, 4, 8, 16), _chain),
    "variables": ((2, 4, 6, 10), (2, 4, 6), _presses),
    "absorbers": ((1, 2, 3, 4), (1, 2), _absorbers),
    "limits": ((2, 4, 8, 16, 32, 64, 128), (2, 8, 32), _limits),
    "harmonics": ((1, 2, 4, 8, 16), (1, 2, 4), _harmonics),
    "readings": ((10, 30, 100, 300, 1000, 3000), (10, 100, 1000), partial(_balance, planes=4)),
    "planes": ((1, 2, 4, 8, 16, 32), (1, 2, 4, 8), lambda count: _balance(200, count)),
    "parts": ((10, 20, 40, 80, 160), (10, 20, 40), _parts),
    "points": ((10, 100, 1000, 10_000), (10, 100, 1000), _points),
}
"""By what grows."""
RUNS, QUICK_RUNS = 5, 3


def cost(
    ladder: str | None = None, *, quick: bool = False, progress: Callable[[str, float], None] | None = None
) -> tuple[Size, ...]:
    """Every size of a ladder (None: of all), timed; the first answer of each job is not, as it loads what is needed."""
    jobs = []
    for name in [ladder] if ladder else LADDERS:
        every, fewer, make = LADDERS[name]
        jobs += [(name, size, make) for size in (fewer if quick else every)]
    found = []
    for number, (name, size, make) in enumerate(jobs):
        if progress:
            progress(f"{name}: {size}", number / len(jobs))
        found += run(f"{name}: {size}", Size, partial(_sized, name, size, make, QUICK_RUNS if quick else RUNS))
    return tuple(found)


def cost_left(ladder: str | None) -> tuple[str, ...]:
    """Sizes that only the whole chart asks, and its runs."""
    left = {name: [size for size in LADDERS[name][0] if size not in LADDERS[name][1]]
            for name in ([ladder] if ladder else LADDERS)}  # fmt: skip
    words = [f"{name} of {', '.join(map(str, sizes))}" for name, sizes in left.items() if sizes]
    return (*words, f"{RUNS} runs instead of {QUICK_RUNS}")


def _sized(name: str, size: int, make: Callable[[int], Iterator[Answered]], runs: int) -> list[Size]:
    return [_timed(name, size, answered, runs) for answered in make(size)]


def _timed(ladder: str, size: int, answered: Answered, runs: int) -> Size:
    answered()
    tracemalloc.start()
    method = answered()
    memory = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    times, cut = list[float](), ""
    for _ in range(runs):
        with answering() as limit:
            begin = spent()
            method = answered()
            times.append(spent() - begin)
        if limit is not None and limit.ended:
            cut = f"the time limit of {limit.seconds:g} s ended it after {limit.ended}"
            break
    low, high = np.quantile(times, (0.25, 0.75)).tolist()
    return Size(ladder, size, median(times), memory, (low, high), len(times), method, cut)


def fits(sizes: tuple[Size, ...]) -> list[Fit]:
    """A straight line in logarithms through each stretch of sizes that one method answers, of two sizes or more."""
    found = []
    for ladder in dict.fromkeys(size.ladder for size in sizes):
        rows = [size for size in sizes if size.ladder == ladder]
        begins = [0, *(i + 1 for i, (a, b) in enumerate(pairwise(rows)) if a.method != b.method), len(rows)]
        for first, last in pairwise(begins):
            if last - first > 1:
                found.append(_fit(rows[first:last]))
    return found


def _fit(rows: list[Size]) -> Fit:
    from scipy.stats import t

    x, y = np.log([row.size for row in rows]), np.log([row.seconds for row in rows])
    x, y = x - x.mean(), y - y.mean()
    exponent, free = float(x @ y / (x @ x)), len(rows) - 2
    left = y - exponent * x  # not by the correlation: near 1 its digits are gone
    half = float(t.ppf(0.975, free) * np.sqrt(left @ left / free / (x @ x))) if free else math.nan
    return Fit(rows[0].ladder, rows[0].method, exponent, half, tuple(row.size for row in rows))
