"""What is being done, on standard error: a bar on a terminal after half a second, a line a minute elsewhere."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from threading import Lock, Timer
from types import TracebackType
from typing import TYPE_CHECKING

from vibopt.cli.output import complain
from vibopt.work import deaf, spoken_time

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

PATIENCE, MINUTE = 0.5, 60.0
"""Seconds before the bar appears, and between two lines where there is no terminal."""
_BUDGETS, _ALIKE = ("one range",), ("sweep", "variants", "listed values", "what a step buys")
"""Stages that end with a budget at the latest, and those of answers that are like each other; of no others it is known
how much of them a part is, unless they count."""
_LEAST = 0.01
"""Part of a stage that must be done before its end is estimated."""


class Bar:
    """Call it with what is being done and the part of it that is finished (0 to 1); the part counts work, no time.

    clock
        Seconds that have passed; what it says is shown, and decides nothing.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._shown: Progress | None = None
        self._task: TaskID | None = None
        self._clock = clock
        self._state = ("solving", 0.0)
        self._begun = self._stage = clock()
        self._lock = Lock()
        self._timer: Timer | None = None

    def __call__(self, doing: str, part: float) -> None:
        with self._lock:
            if part < self._state[1] or doing.split(",")[0] != self._state[0].split(",")[0]:
                self._stage = self._clock()
            self._state = (doing, part)
            if self._shown is not None and self._task is not None:
                self._shown.update(self._task, description=doing, completed=part, left=self.left)

    @property
    def left(self) -> str:
        """How long the stage may still take, in words: at most, of a budget; about, of like answers; else ""."""
        stage, _, counted = self._state[0].partition(",")
        bound = "at most" if counted or stage in _BUDGETS else "about" if stage in _ALIKE else ""
        part, passed = self._state[1], self._clock() - self._stage
        if part < _LEAST or not bound:
            return ""
        return f"{bound} {spoken_time(passed * (1.0 - part) / part)} more"

    @property
    def line(self) -> str:
        """Stage, part, time so far and time left in a line."""
        doing, part = self._state
        done = f"{100.0 * part:.0f} % of it" if part >= _LEAST else ""
        said = (doing, done, f"{spoken_time(self._clock() - self._begun)} so far", self.left)
        return f"vibopt: {', '.join(one for one in said if one)}"

    def __enter__(self) -> Bar:
        terminal = sys.stderr is not None and sys.stderr.isatty()
        self._wait(PATIENCE if terminal else MINUTE, self._start if terminal else self._tell)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with self._lock:
            if self._timer is not None:
                self._timer.cancel()
            if self._shown is not None:
                self._shown.stop()
            self._timer = None

    def _wait(self, seconds: float, then: Callable[[], None]) -> None:
        self._timer = Timer(seconds, then)
        self._timer.daemon = True
        with deaf():  # Ctrl-C is for the thread that works, and comes when that one lets it
            self._timer.start()

    def _tell(self) -> None:
        """One line, and the next a minute later."""
        with self._lock:
            if self._timer is not None:
                complain(self.line)
                self._wait(MINUTE, self._tell)

    def _start(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

        with self._lock:
            if self._timer is None:
                return
            columns = (
                TextColumn("{task.description}"),
                BarColumn(),
                TimeElapsedColumn(),
                TextColumn("{task.fields[left]}"),
            )
            self._shown = Progress(*columns, console=Console(stderr=True), transient=True)
            self._task = self._shown.add_task(self._state[0], total=1.0, left=self.left)
            self._shown.update(self._task, completed=self._state[1])
            self._shown.start()
