"""A bar on standard error for whatever takes longer than a second, and only on a terminal."""

from __future__ import annotations

import sys
from threading import Lock, Timer
from types import TracebackType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

PATIENCE = 1.0
"""Seconds before the bar appears."""


class Bar:
    """Call it with what is being done and the part that is finished (0 to 1)."""

    def __init__(self) -> None:
        self._shown: Progress | None = None
        self._task: TaskID | None = None
        self._state = ("solving", 0.0)
        self._lock = Lock()
        self._timer = Timer(PATIENCE, self._start) if _is_terminal() else None

    def __call__(self, doing: str, part: float) -> None:
        with self._lock:
            self._state = (doing, part)
            if self._shown is not None and self._task is not None:
                self._shown.update(self._task, description=doing, completed=part)

    def __enter__(self) -> Bar:
        if self._timer is not None:
            self._timer.daemon = True
            self._timer.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._timer is not None:
            self._timer.cancel()
        with self._lock:
            if self._shown is not None:
                self._shown.stop()
            self._timer = None

    def _start(self) -> None:
        from rich.console import Console
        from rich.progress import Progress

        with self._lock:
            if self._timer is None:
                return
            self._shown = Progress(console=Console(stderr=True), transient=True)
            self._task = self._shown.add_task(self._state[0], total=1.0)
            self._shown.update(self._task, completed=self._state[1])
            self._shown.start()


def _is_terminal() -> bool:
    return sys.stderr is not None and sys.stderr.isatty()
