"""Questions about one machine that differ in bounds alone: it is posed once, and what is measured stays with it."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import field, replace
from typing import Any

from vibopt.forms import Form
from vibopt.mechanics.model import Model
from vibopt.records import dataclass
from vibopt.responses import Response
from vibopt.scene.scene import Scene
from vibopt.work import within

_MOST = 64
"""Machines that are kept: the one that is asked about, and itself off within its tolerances."""
_ASKED: dict[str, Any] = {
    "name": "", "title": "", "statement": "", "limits": {}, "measures": {}, "goal": None, "expected": (), "notes": (),
    "document": {},
}  # fmt: skip
"""What of a scene is no machine."""


@dataclass
class _Machine:
    """A machine and its model.

    forms
        Of what was asked of it, each on the model that it needs: the question without its bounds, then both.
    """

    scene: Scene
    free: frozenset[str]
    model: Model
    forms: list[tuple[Any, tuple[Model, Form]]] = field(default_factory=list)


_KEPT: ContextVar[list[_Machine] | None] = ContextVar("machines that are kept", default=None)


@contextmanager
def one_machine(scene: Scene) -> Iterator[None]:
    """Machines posed inside that are that of a scene are posed once, with all that is measured of them.

    What structures and rotors are modelled by depends on what is asked: theirs are not kept.
    """
    if scene.structures or scene.rotors:
        yield
        return
    with within(_KEPT, scene.__dict__.setdefault("machines", [])):
        yield


def model_kept(scene: Scene, free: Collection[str], made: Callable[[], Model]) -> Model:
    """The model of a scene, numbers at the paths `free` variables in it: the one that is kept, or that is made."""
    kept = _KEPT.get()
    if kept is None:
        return made()
    bare, free = replace(scene, **_ASKED), frozenset(free)
    known = next((one for one in kept if one.free == free and one.scene == bare), None)
    if known is None:
        known = _Machine(bare, free, made())
        kept.append(known)
        del kept[1:-_MOST]  # the first is the one that is asked about
    return known.model


def form_kept(
    model: Model, response: Response, how: Any, made: Callable[[Response], tuple[Model, Form]]
) -> tuple[Model, Form]:
    """The smallest model that a question needs of a machine, and its form: those that are kept, or that are made.

    What is kept is made without the values of bounds, so that none can hang on them unseen.
    """
    known = next((one for one in _KEPT.get() or () if one.model is model), None)
    if known is None:
        return made(response)
    asked = response.unbound, how
    found = next((both for one, both in known.forms if one == asked), None)
    if found is None:
        found = made(asked[0])
        known.forms.append((asked, found))
    return found
