"""Where each kind of job says what it adds to each view of its answers: told from above, by the package itself."""

from __future__ import annotations

TYPE_CHECKING = False  # that of typing takes a hundred times as long to load as this, and the package loads this
if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Any

    from vibopt.answer.answer import Answer

_PLACES: dict[str, str] = {}


def register(places: Mapping[str, str]) -> None:
    """Make known the modules of kinds of job, by kind; each is opened when an answer is first looked at."""
    _PLACES.update(places)


def views_of(answer: Answer[Any]) -> Any:
    """The module in which a kind of job says what it adds to each view of its answers."""
    from importlib import import_module

    return import_module(_PLACES[answer.job.kind])
